!> Parameters of a train by name: 'input_torque', 'shaft 2 stiffness', 'mesh * half_backlash' (of all meshes alike), 'body motor
!> inertia', 'mesh 1 stiffness_cos 2' (a value of a list) or 'stiffness_variation' (the largest amplitude of kappa, all others in
!> proportion); and how the plain train changes with them.
module geartrain_model_parameter
   use geartrain_base_error, only: error_type, fatal
   use geartrain_base_kinds, only: dp
   use geartrain_base_nearest, only: nearest_name
   use geartrain_base_numbers, only: integer_text
   use geartrain_base_series, only: make_series, series_type
   use geartrain_base_variable, only: variable_type, visitor_type
   use geartrain_model_drawing, only: plain_train, reduce_light_loads
   use geartrain_model_mesh, only: mesh_type
   use geartrain_model_train, only: train_type
   use geartrain_model_variables, only: visit_body, visit_mesh, visit_model, visit_shaft, visit_train
   implicit none (type, external)
   private
   public :: parameter_type, add_to_parameter, clear_numbers, find_parameter, find_train_rate, largest_variation

   !> Variables that are in the plain train as they are given; those among them that `phase` turns.
   character(*), parameter :: plain_variables = ' input_torque torque_cos torque_sin prime_mover_inertia load_inertia inertia &
      &torque damping_to_ground stiffness damping_ratio damping driving_radius driven_radius driving_inertia driven_inertia &
      &half_backlash back_stiffness back_phase stiffness_cos stiffness_sin error_cos error_sin '
   character(*), parameter :: turned_variables = ' stiffness_cos stiffness_sin error_cos error_sin '
   !> Change of a parameter for differences of the derivation from the drawing, relative, or absolute where the parameter is 0.
   real(dp), parameter :: drawing_step = 1e-5_dp
   character(*), parameter :: variation = 'stiffness_variation'

   type :: parameter_type
      !> Group 'train', 'body', 'shaft' or 'mesh'; the variable; number of the group, 0: all; value of a list, 0: no list.
      character(5) :: group = ''
      character(24) :: variable = ''
      integer :: index = 0, item = 0
      !> Value [unit of the variable]; of several groups that of the first.
      real(dp) :: value = 0
      !> A number of the plain train that the drawing gives: the derivative is as if it were given.
      logical :: derived = .false.
   end type parameter_type

   !> Finds a variable, and changes it; or carries all numbers of a train.
   type, extends(visitor_type) :: toucher_type
      !> 'find', 'add' (to the variable), 'clear' (all numbers), 'take' (all numbers into the list) or 'give' (out of the list).
      character(5) :: way = 'find'
      character(24) :: variable = ''
      integer :: item = 0
      !> What is added to the variable; its value, number of values (-1: no list) and whether it is in force.
      real(dp) :: change = 0, value = 0
      integer :: values = -1
      logical :: found = .false., in_force = .true., continuous = .true., allowed = .true.
      !> Names of the variables visited, (variable); numbers in the order of the visits.
      character(24), allocatable :: names(:)
      real(dp), allocatable :: numbers(:)
      integer :: count = 0
   contains
      procedure :: on_real
      procedure :: on_integer
      procedure :: on_logical
      procedure :: on_text
      procedure :: on_list
      procedure :: on_names
      procedure, private :: meet
      procedure, private :: is_given
   end type toucher_type

contains

   !> Finds the parameter of a name.
   subroutine find_parameter(train, plain, name, parameter, error)
      !> A train that has passed `check_train`, and its plain train; both are left as they are.
      type(train_type), intent(inout) :: train, plain
      !> The name.
      character(*), intent(in) :: name
      !> The parameter.
      type(parameter_type), intent(out) :: parameter
      !> Added to where the train has no such parameter.
      type(error_type), allocatable, intent(inout) :: error
      type(toucher_type) :: toucher, of_plain
      character(:), allocatable :: rest, which
      integer :: at, best

      rest = trim(adjustl(name))
      if (rest == variation) then
         parameter%variable = rest
         parameter%value = largest_variation(plain%meshes)
         if (.not. parameter%value > 0) call refuse('no mesh stiffness varies')
         return
      end if
      at = index(rest, ' ', back=.true.)
      if (verify(rest(at + 1:), '0123456789') == 0 .and. at > 0 .and. len(rest) - at < 9) then
         read (rest(at + 1:), *) parameter%item
         rest = trim(rest(:at))
         at = index(rest, ' ', back=.true.)
      end if
      parameter%variable = rest(at + 1:)
      rest = trim(rest(:at))
      parameter%group = 'train'
      parameter%index = 1
      if (rest /= '') then
         at = index(rest//' ', ' ')
         parameter%group = rest(:at - 1)
         which = trim(adjustl(rest(at:)))
         call find_group()
         if (parameter%index < 0) return
      end if
      toucher%variable = parameter%variable
      toucher%item = parameter%item
      of_plain = toucher
      call visit(train, parameter, toucher, first=.true.)
      if (is_one_of(parameter, plain_variables) .and. .not. (toucher%is_given() .and. abs(toucher%value) > 0)) then
         call visit(plain, parameter, of_plain, first=.true.)
         if (of_plain%is_given()) parameter%derived = .not. toucher%is_given() .or. abs(of_plain%value) > 0
      end if
      if (parameter%derived) toucher = of_plain
      if (.not. toucher%found) then
         allocate (toucher%names(0))
         call visit(train, parameter, toucher, first=.true.)
         best = nearest_name(trim(parameter%variable), toucher%names)
         if (best > 0) then
            call refuse('no variable of &'//trim(parameter%group)//' (did you mean "'//trim(toucher%names(best))//'"?)')
         else
            call refuse('no variable of &'//trim(parameter%group))
         end if
      else if (.not. toucher%continuous) then
         call refuse('no continuous parameter')
      else if (index(parameter%variable, 'characteristic_') == 1) then
         call refuse('a unit of the results, no property of the train')
      else if (toucher%values < 0 .and. parameter%item > 0) then
         call refuse('one number, no list')
      else if (.not. toucher%is_given()) then
         call refuse('not in force in this train: it is not given')
      else if (toucher%values > 0 .and. (parameter%item < 1 .or. parameter%item > toucher%values)) then
         call refuse('a list: its values are named by their numbers, 1 to '//integer_text(toucher%values)//', as in "'// &
                     trim(parameter%variable)//' 1"')
      end if
      parameter%value = toucher%value

   contains

      subroutine refuse(why)
         character(*), intent(in) :: why

         call fatal(error, 'parameter "'//trim(adjustl(name))//'": '//why)
      end subroutine refuse

      !> Sets the number of the group, 0: all; -1: refused.
      subroutine find_group()
         integer :: groups, i

         groups = -1
         if (parameter%group == 'train') groups = 1
         if (parameter%group == 'shaft') groups = size(train%shafts)
         if (parameter%group == 'mesh') groups = size(train%meshes)
         if (parameter%group == 'body' .and. allocated(train%bodies)) groups = size(train%bodies)
         parameter%index = -1
         if (groups < 0) then
            call refuse('must begin with "mesh", "shaft" or, in a network, "body", or be a variable of &train')
            return
         end if
         if (which == '*') parameter%index = 0
         if (verify(which, '0123456789') == 0 .and. len(which) > 0 .and. len(which) < 9) read (which, *) parameter%index
         if (parameter%group == 'train' .and. which == '') parameter%index = 1
         if (parameter%group == 'body') then
            do i = 1, groups
               if (train%bodies(i)%name == which) parameter%index = i
            end do
         end if
         if (parameter%index >= 0 .and. parameter%index <= groups .and. (parameter%index > 0 .or. which == '*')) return
         parameter%index = -1
         call refuse('must tell which &'//trim(parameter%group)//': 1 to '//integer_text(groups)//', or * for all'// &
                     trim(merge(', or its name', '             ', parameter%group == 'body')))
      end subroutine find_group

   end subroutine find_parameter

   pure logical function is_one_of(parameter, names)
      type(parameter_type), intent(in) :: parameter
      character(*), intent(in) :: names

      is_one_of = index(names, ' '//trim(parameter%variable)//' ') > 0
   end function is_one_of

   !> Visits the groups of a parameter.
   subroutine visit(train, parameter, toucher, first)
      type(train_type), intent(inout) :: train
      type(parameter_type), intent(in) :: parameter
      type(toucher_type), intent(inout) :: toucher
      !> Of all groups only the first is visited.
      logical, intent(in), optional :: first
      integer :: i, groups

      groups = 1
      if (parameter%group == 'shaft') groups = size(train%shafts)
      if (parameter%group == 'mesh') groups = size(train%meshes)
      if (parameter%group == 'body') groups = size(train%bodies)
      if (present(first)) groups = max(1, parameter%index)
      do i = max(1, parameter%index), merge(groups, parameter%index, parameter%index == 0)
         select case (parameter%group)
         case ('train')
            call visit_train(train, toucher)
         case ('body')
            call visit_body(train%bodies(i), i, toucher)
         case ('shaft')
            call visit_shaft(train%shafts(i), i, toucher)
         case ('mesh')
            call visit_mesh(train%meshes(i), i, toucher)
         end select
      end do
   end subroutine visit

   !> Adds to a parameter, of all its groups.
   subroutine add_to_parameter(train, parameter, change, allowed)
      !> The train.
      type(train_type), intent(inout) :: train
      !> Its parameter, a variable.
      type(parameter_type), intent(in) :: parameter
      !> What is added [unit of the parameter].
      real(dp), intent(in) :: change
      !> Whether the new values are in the range of the variable.
      logical, intent(out), optional :: allowed
      type(toucher_type) :: toucher

      toucher%way = 'add'
      toucher%variable = parameter%variable
      toucher%item = parameter%item
      toucher%change = change
      call visit(train, parameter, toucher)
      if (present(allowed)) allowed = toucher%allowed
   end subroutine add_to_parameter

   !> Sets all numbers of a train to 0.
   subroutine clear_numbers(train)
      !> Any train.
      type(train_type), intent(inout) :: train
      type(toucher_type) :: toucher

      toucher%way = 'clear'
      call visit_model(train, toucher)
   end subroutine clear_numbers

   !> Finds the derivative of every number of the plain train with respect to a parameter: 1 at the parameter itself; where the
   !> parameter is one of the drawing, or turned by `phase`, by differences of the derivation.
   subroutine find_train_rate(train, plain, parameter, rate, differentiable)
      !> The train as described; its plain train, with the stiffnesses for its loads.
      type(train_type), intent(in) :: train, plain
      !> The parameter.
      type(parameter_type), intent(in) :: parameter
      !> A train after `clear_numbers` of `plain`; gets the derivatives [1/unit of the parameter], lists perhaps longer.
      type(train_type), intent(inout) :: rate
      !> False at the end of the range of the parameter, where the derivation from the drawing cannot go on.
      logical, intent(out) :: differentiable
      type(train_type) :: changed, side
      type(toucher_type) :: above, below
      real(dp) :: step
      integer :: j

      differentiable = .true.
      if (parameter%variable == variation) then
         do j = 1, size(plain%meshes)
            associate (mesh => plain%meshes(j))
               if (allocated(mesh%stiffness_cos)) rate%meshes(j)%stiffness_cos = mesh%stiffness_cos/parameter%value
               if (allocated(mesh%stiffness_sin)) rate%meshes(j)%stiffness_sin = mesh%stiffness_sin/parameter%value
            end associate
         end do
         return
      end if
      if (is_direct()) then
         call add_to_parameter(rate, parameter, 1.0_dp)
         return
      end if
      if (parameter%variable == 'phase') then
         do j = 1, size(plain%meshes)
            if (parameter%index /= 0 .and. parameter%index /= j) cycle
            associate (mesh => plain%meshes(j), d => rate%meshes(j))
               call turn(mesh%stiffness_cos, mesh%stiffness_sin, d%stiffness_cos, d%stiffness_sin)
               call turn(mesh%error_cos, mesh%error_sin, d%error_cos, d%error_sin)
            end associate
         end do
         return
      end if
      step = drawing_step*merge(abs(parameter%value), 1.0_dp, abs(parameter%value) > 0)
      call derive(step, above)
      call derive(-step, below)
      if (differentiable) differentiable = above%count == below%count
      if (.not. differentiable) return
      below%way = 'give'
      below%numbers = (above%numbers(:above%count) - below%numbers(:below%count))/(2*step)
      below%count = 0
      rate = side
      call visit_model(rate, below)

   contains

      !> Whether the parameter is in the plain train as it is given, and nothing else is derived from it. A face width may mean a
      !> stiffness that depends on the loads.
      logical function is_direct()
         is_direct = is_one_of(parameter, plain_variables) .and. .not. any(train%meshes%face_width > 0)
         if (is_one_of(parameter, turned_variables) .and. any(abs(train%meshes%phase) > 0)) is_direct = .false.
         is_direct = is_direct .or. parameter%derived
      end function is_direct

      !> Derivative of harmonics with respect to the phase by which they lag.
      subroutine turn(cosine, sine, d_cosine, d_sine)
         real(dp), allocatable, intent(in) :: cosine(:), sine(:)
         real(dp), allocatable, intent(inout) :: d_cosine(:), d_sine(:)
         integer :: h

         if (allocated(sine)) d_cosine = [(-h*sine(h), h=1, size(sine))]
         if (allocated(cosine)) d_sine = [(h*cosine(h), h=1, size(cosine))]
      end subroutine turn

      !> Takes the numbers of the plain train at a changed parameter.
      subroutine derive(change, toucher)
         real(dp), intent(in) :: change
         type(toucher_type), intent(inout) :: toucher
         logical :: allowed

         changed = train
         call add_to_parameter(changed, parameter, change, allowed)
         differentiable = differentiable .and. allowed
         if (.not. allowed) return
         call plain_train(changed, side)
         call reduce_light_loads(side)
         toucher%way = 'take'
         allocate (toucher%numbers(256))
         call visit_model(side, toucher)
      end subroutine derive

   end subroutine find_train_rate

   !> Largest amplitude of any harmonic of kappa of any mesh of a plain train.
   pure real(dp) function largest_variation(meshes) result(largest)
      !> Meshes of a plain train.
      type(mesh_type), intent(in) :: meshes(:)
      type(series_type) :: kappa
      integer :: j

      largest = 0
      do j = 1, size(meshes)
         kappa = make_series(meshes(j)%stiffness_cos, meshes(j)%stiffness_sin, 1.0_dp, 1)
         largest = maxval([largest, abs(kappa%amplitude)])
      end do
   end function largest_variation

   !> Whether the variable found has a value that is used.
   pure logical function is_given(self)
      class(toucher_type), intent(in) :: self

      is_given = self%in_force .and. self%values /= 0
   end function is_given

   !> Notes a variable.
   subroutine meet(self, variable, continuous)
      class(toucher_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      logical, intent(in) :: continuous

      if (variable%name == self%variable) self%found = .true.
      if (variable%name == self%variable) self%continuous = continuous
      if (allocated(self%names) .and. continuous) self%names = [character(24) :: self%names, variable%name]
   end subroutine meet

   subroutine on_real(self, variable, value, in_force)
      class(toucher_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      real(dp), intent(inout) :: value
      logical, intent(inout), optional :: in_force
      real(dp) :: values(1)

      values = value
      call touch(self, variable, values)
      value = values(1)
      if (self%way == 'find' .and. variable%name == self%variable) then
         self%value = value
         if (present(in_force)) self%in_force = in_force
      end if
   end subroutine on_real

   subroutine on_list(self, variable, value)
      class(toucher_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      real(dp), allocatable, intent(inout) :: value(:)

      if (allocated(value)) call touch(self, variable, value)
      if (self%way /= 'find' .or. variable%name /= self%variable) return
      self%continuous = .not. variable%whole
      self%found = .true.
      self%values = 0
      if (allocated(value)) self%values = size(value)
      if (self%item > 0 .and. self%item <= self%values) self%value = value(self%item)
   end subroutine on_list

   subroutine touch(self, variable, values)
      class(toucher_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      real(dp), intent(inout) :: values(:)
      integer :: n

      n = size(values)
      select case (self%way)
      case ('find')
         call self%meet(variable, .not. variable%whole)
      case ('add')
         if (variable%name /= self%variable .or. self%item > n) return
         n = max(1, self%item)
         values(n) = values(n) + self%change
         self%allowed = self%allowed .and. variable%allows(values(n))
      case ('clear')
         values = 0
      case ('take')
         if (self%count + n > size(self%numbers)) self%numbers = [self%numbers, self%numbers, values]
         self%numbers(self%count + 1:self%count + n) = values
         self%count = self%count + n
      case ('give')
         values = self%numbers(self%count + 1:self%count + n)
         self%count = self%count + n
      end select
   end subroutine touch

   subroutine on_integer(self, variable, value)
      class(toucher_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      integer, intent(inout) :: value

      call self%meet(variable, .false.)
   end subroutine on_integer

   subroutine on_logical(self, variable, value)
      class(toucher_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      logical, intent(inout) :: value

      call self%meet(variable, .false.)
   end subroutine on_logical

   subroutine on_text(self, variable, value)
      class(toucher_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      character(:), allocatable, intent(inout) :: value

      call self%meet(variable, .false.)
   end subroutine on_text

   subroutine on_names(self, variable, value)
      class(toucher_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      character(*), intent(inout) :: value(:)

      call self%meet(variable, .false.)
   end subroutine on_names

end module geartrain_model_parameter
