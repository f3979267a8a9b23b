!> Small cases of every kind, two of whose variables have drawn values.
module drawing
   use fixtures, only: single_pair
   use geartrain, only: case_type, dp
   use geartrain_base_random, only: begin_random, generator_type
   use geartrain_base_variable, only: variable_type, visitor_type
   use geartrain_input_template, only: paper_case
   use geartrain_input_variables, only: visit_case
   implicit none (type, external)
   private
   public :: draw_case

   !> Kinds of cases that are tried in turn; the responses twice.
   integer, parameter :: kinds = 7

   !> Counts the variables that it is led over, and gives those of the chosen numbers a value.
   type, extends(visitor_type) :: drawer_type
      type(generator_type) :: generator
      integer :: count = 0
      integer, allocatable :: chosen(:)
      !> Group of each variable, as far as it is counted.
      character(24) :: groups(400) = ''
   contains
      procedure :: on_real
      procedure :: on_integer
      procedure :: on_logical
      procedure :: on_text
      procedure :: on_list
      procedure :: on_names
      procedure :: is_next
   end type drawer_type

contains

   !> Case number `number` of a seed. One in four has a variable of the train and any other one; the others go over all pairs of
   !> variables of the analyses in turn.
   subroutine draw_case(seed, number, case)
      integer, intent(in) :: seed, number
      type(case_type), intent(out) :: case
      type(drawer_type) :: counter, drawer
      integer, allocatable :: train(:), analyses(:)
      integer :: i

      drawer%generator = begin_random(seed, number)
      case = small_case(mod(number, kinds), drawer%generator)
      allocate (counter%chosen(0))
      call visit_case(case, counter)
      associate (groups => counter%groups(:counter%count))
         train = pack([(i, i=1, size(groups))], groups == 'train' .or. groups == 'shaft' .or. groups == 'mesh')
         analyses = pack([(i, i=1, size(groups))], .not. (groups == 'train' .or. groups == 'shaft' .or. groups == 'mesh' &
                                                          .or. groups == 'output'))
      end associate
      if (drawer%generator%one_of(4) == 1) then
         drawer%chosen = [train(drawer%generator%one_of(size(train))), drawer%generator%one_of(counter%count)]
      else
         drawer%chosen = analyses(pair(size(analyses), number/kinds + 7919*seed))
      end if
      call visit_case(case, drawer)
   end subroutine draw_case

   !> Pair number `number` of 1 .. n, in turn.
   pure function pair(n, number)
      integer, intent(in) :: n, number
      integer :: pair(2), left

      left = mod(number, n*(n - 1)/2)
      pair = [1, 2]
      do while (left > n - pair(1) - 1)
         left = left - (n - pair(1))
         pair(1) = pair(1) + 1
      end do
      pair(2) = pair(1) + 1 + left
   end function pair

   !> A train and an analysis or two that take little time.
   function small_case(kind, generator) result(case)
      !> 0 .. kinds-1.
      integer, intent(in) :: kind
      type(generator_type), intent(inout) :: generator
      type(case_type) :: case
      real(dp) :: centre

      case = paper_case()
      if (generator%one_of(2) == 1) case%train = single_pair(0.05_dp, 0.2_dp, 0.4_dp)
      centre = 0.3_dp + 1.5_dp*generator%uniform()
      case%modes = .false.
      case%response%start = centre
      case%response%stop = centre + 0.05_dp
      case%response%harmonics = generator%one_of(5) - 1
      case%response%max_points = 30
      case%integration%start = centre
      case%integration%stop = centre + 0.05_dp
      case%integration%points = 3
      case%integration%max_periods = 100
      case%attractors%frequency = centre + 0.02_dp
      case%attractors%starts = 3
      case%attractors%max_periods = 100
      case%stability_map%start = centre
      case%stability_map%stop = centre + 0.05_dp
      case%stability_map%points = 4
      case%stability_map%parameter_points = 2
      case%stability_map%linear = generator%one_of(2) == 1
      case%run_up%start = centre
      case%run_up%stop = centre + 0.05_dp
      case%run_up%duration = 100/case%train%characteristic_frequency
      if (kind /= 6) deallocate (case%run_up)
      select case (kind)
      case (0, 1)
         deallocate (case%integration, case%attractors, case%stability_map)
      case (2)
         deallocate (case%response, case%attractors, case%stability_map)
      case (3)
         deallocate (case%response, case%integration, case%stability_map)
      case (4)
         deallocate (case%response, case%integration, case%attractors)
      case (6)
         deallocate (case%response, case%integration, case%attractors, case%stability_map)
      case default
         deallocate (case%integration, case%stability_map)
         case%attractors%follow = .true.
      end select
   end function small_case

   !> Whether the next variable is one of those chosen.
   logical function is_next(self)
      class(drawer_type), intent(inout) :: self

      self%count = self%count + 1
      if (self%count <= size(self%groups)) self%groups(self%count) = self%group
      is_next = any(self%chosen == self%count)
   end function is_next

   subroutine on_real(self, variable, value, in_force)
      class(drawer_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      real(dp), intent(inout) :: value
      logical, intent(inout), optional :: in_force
      real(dp), parameter :: factor(*) = [0.0_dp, 1e-6_dp, 0.1_dp, 0.5_dp, 0.9_dp, 1.0_dp, 1.1_dp, 2.0_dp, 10.0_dp, 1e6_dp, -1.0_dp]

      if (.not. self%is_next()) return
      if (present(in_force)) then
         if (.not. in_force) return
      end if
      select case (self%generator%one_of(4))
      case (1)
         value = end_of(variable, self%generator)
      case default
         value = factor(self%generator%one_of(size(factor)))*value
      end select
   end subroutine on_real

   subroutine on_integer(self, variable, value)
      class(drawer_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      integer, intent(inout) :: value
      integer, parameter :: some(*) = [0, 1, 2, 3, 4, 5, 7, 12, 20, 50, 100, 1000, 100000]

      if (.not. self%is_next()) return
      select case (self%generator%one_of(3))
      case (1)
         value = self%generator%one_of(4) - 1
      case (2)
         value = nint(max(-2e9_dp, min(2e9_dp, end_of(variable, self%generator))))
      case default
         value = some(self%generator%one_of(size(some)))
      end select
   end subroutine on_integer

   !> An end of the range of a variable, or just beyond it, or what leaves the choice to the program.
   real(dp) function end_of(variable, generator) result(value)
      type(variable_type), intent(in) :: variable
      type(generator_type), intent(inout) :: generator

      select case (generator%one_of(3))
      case (1)
         value = max(variable%above, variable%least, -1e9_dp)
      case (2)
         value = min(variable%most, 1e20_dp)
      case default
         value = min(variable%automatic, 1e9_dp)
      end select
   end function end_of

   subroutine on_logical(self, variable, value)
      class(drawer_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      logical, intent(inout) :: value

      ! A shaft that becomes rigid takes its stiffness along.
      if (self%is_next() .and. variable%name /= 'rigid') value = .not. value
   end subroutine on_logical

   subroutine on_text(self, variable, value)
      class(drawer_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      character(:), allocatable, intent(inout) :: value
      integer :: from, to, i

      if (.not. self%is_next() .or. variable%choices == '') return
      from = 1
      do i = 1, self%generator%one_of(4)
         to = from + index(trim(variable%choices(from:))//' ', ' ') - 1
         value = variable%choices(from:to - 1)
         if (to < len_trim(variable%choices)) from = to + 1
      end do
   end subroutine on_text

   subroutine on_list(self, variable, value)
      class(drawer_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      real(dp), allocatable, intent(inout) :: value(:)
      real(dp) :: scale
      integer :: i

      if (.not. self%is_next()) return
      scale = 0.1_dp
      if (allocated(value)) then
         if (size(value) > 0) scale = maxval(abs(value))
      end if
      ! Of the right order where the list was empty: transmission errors and torques.
      if (variable%unit == 'm') scale = 1e-6_dp
      select case (self%generator%one_of(5))
      case (1)
         value = [real(dp) ::]
      case (2)
         value = [scale]
      case (3)
         value = [0.0_dp, 0.0_dp, scale]
      case (4)
         value = [(scale/i, i=1, 40)]
      case default
         value = [-scale, scale]
      end select
   end subroutine on_list

   !> Names are no setting to try: a chain has none.
   subroutine on_names(self, variable, value)
      class(drawer_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      character(*), intent(inout) :: value(:)

      associate (unused_self => self, unused_variable => variable, unused_value => value)
      end associate
   end subroutine on_names

end module drawing
