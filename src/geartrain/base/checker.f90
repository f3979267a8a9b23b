!> The visitor that checks every value against the range of its variable.
module geartrain_base_checker
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text, real_text
   use geartrain_base_plain_text, only: not_plain
   use geartrain_base_problems, only: problems_type
   use geartrain_base_variable, only: variable_type, visitor_type
   implicit none (type, external)
   private
   public :: checker_type

   type, extends(visitor_type) :: checker_type
      type(problems_type) :: problems
   contains
      procedure :: on_real => check_real
      procedure :: on_integer => check_integer
      procedure :: on_logical => check_logical
      procedure :: on_text => check_text
      procedure :: on_list => check_list
      procedure :: on_names => check_names
      procedure :: complain
      procedure :: lacks
      procedure :: drawing_is_wrong
   end type checker_type

   !> Bytes of a text that a message shows.
   integer, parameter :: longest_shown = 60

   !> Variables of a drawing, from which others follow.
   character(*), parameter :: drawn(*) = [character(15) :: 'teeth', 'normal_module', 'pressure_angle', 'helix_angle', &
      'face_width', 'ring_face_width', 'profile_shift', 'centre_distance', 'tip_diameter', 'dedendum', 'backlash', &
      'elastic_modulus', 'internal', 'diameter', 'length', 'shear_modulus', 'outer_diameter', 'width', 'bore', 'density']

contains

   subroutine check_real(self, variable, value, in_force)
      class(checker_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      !> Value of the variable [variable%unit].
      real(dp), intent(inout) :: value
      !> .false.: the value is not used and not checked.
      logical, intent(inout), optional :: in_force

      if (present(in_force)) then
         if (.not. in_force) return
      end if
      if (.not. variable%allows_number(value)) &
         call self%complain(variable%name, real_text(value), trim(variable%expectation(value)))
   end subroutine check_real

   subroutine check_integer(self, variable, value)
      class(checker_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      !> Value of the variable.
      integer, intent(inout) :: value

      if (.not. variable%allows(real(value, dp))) &
         call self%complain(variable%name, integer_text(value), trim(variable%expectation()))
   end subroutine check_integer

   !> Finds nothing: both values are allowed.
   subroutine check_logical(self, variable, value)
      class(checker_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      !> Value of the variable.
      logical, intent(inout) :: value
   end subroutine check_logical

   subroutine check_text(self, variable, value)
      class(checker_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      !> Value of the variable, not allocated where it is not given.
      character(:), allocatable, intent(inout) :: value

      if (.not. allocated(value)) return
      if (variable%allows_text(value)) return
      if (variable%choices == '') then
         call self%complain(variable%name, quoted(value), trim(not_plain(value)))
      else
         call self%complain(variable%name, "'"//value//"'", trim(variable%expectation()))
      end if
   end subroutine check_text

   subroutine check_list(self, variable, value)
      class(checker_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      !> Values of the variable [variable%unit], not allocated where they are not given.
      real(dp), allocatable, intent(inout) :: value(:)
      integer :: bad

      if (.not. allocated(value)) return
      bad = findloc(variable%allows(value), .false., dim=1)
      if (bad > 0) call self%complain(variable%name, real_text(value(bad)), trim(variable%expectation(value(bad))), bad)
      if (variable%values > 0 .and. size(value) > 0 .and. size(value) /= variable%values) &
         call self%complain(variable%name, integer_text(size(value))//' values', &
                            'must be '//integer_text(variable%values)//' values')
   end subroutine check_list

   subroutine check_names(self, variable, value)
      class(checker_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      !> Values of the variable, blank where they are not given.
      character(*), intent(inout) :: value(:)
      integer :: i

      do i = 1, size(value)
         if (.not. variable%allows_text(value(i))) &
            call self%complain(variable%name, quoted(trim(value(i))), trim(not_plain(value(i))))
      end do
   end subroutine check_names

   !> A text in quotes, '...' where it is long.
   pure function quoted(value) result(text)
      character(*), intent(in) :: value
      character(2 + merge(3, len(value), len(value) > longest_shown)) :: text

      text = "'...'"
      if (len(value) <= longest_shown) text = "'"//value//"'"
   end function quoted

   !> Adds the problem 'name = value: expectation' unless the variable has a problem already.
   subroutine complain(self, name, value, expectation, place)
      class(checker_type), intent(inout) :: self
      !> Name of the variable of the present group, its value as text, and what it must be.
      character(*), intent(in) :: name, value, expectation
      !> Index of the value in a list.
      integer, intent(in), optional :: place
      character(:), allocatable :: text

      if (self%problems%reported(self%group, self%index, name)) return
      text = trim(name)
      if (present(place)) then
         if (index(name, '_cos') + index(name, '_sin') > 0) then
            text = text//' harmonic '//integer_text(place)
         else
            text = text//' value '//integer_text(place)
         end if
      end if
      call self%problems%add(text//' = '//value//': '//expectation, self%group, self%index, name, place=place)
   end subroutine complain

   !> Adds the problem 'lacks name (range)' unless the variable has a problem already.
   subroutine lacks(self, name, range, instead)
      class(checker_type), intent(inout) :: self
      !> Name of the variable of the present group.
      character(*), intent(in) :: name
      !> Range of the variable, with its unit; blank: any value.
      character(*), intent(in) :: range
      !> Alternative to the variable, such as ' or rigid = .true.'.
      character(*), intent(in), optional :: instead
      character(:), allocatable :: text

      if (self%problems%reported(self%group, self%index, name)) return
      text = 'lacks '//trim(name)
      if (range /= '') text = text//' ('//trim(adjustl(range))//')'
      if (present(instead)) text = text//instead
      call self%problems%add(text, self%group, self%index, name)
   end subroutine lacks

   !> Whether the drawing of a group has a problem already: what would follow from the drawing is not missed then.
   pure logical function drawing_is_wrong(self, group, index)
      class(checker_type), intent(in) :: self
      !> 'body', 'shaft' or 'mesh'.
      character(*), intent(in) :: group
      !> Number of the group among the groups of its name.
      integer, intent(in) :: index

      drawing_is_wrong = any(self%problems%reported(group, index, drawn))
   end function drawing_is_wrong

end module geartrain_base_checker
