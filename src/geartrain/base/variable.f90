!> A row of the table of input variables, and the visitor that is called for each row with the value of its variable.
!>
!> The table is written as visits (the modules `geartrain_*_variables`): one call for each variable ties name, unit, range and
!> description to the component that holds the value. Reading, checking, writing and documenting are visitors.
module geartrain_base_variable
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text, real_text
   use geartrain_base_plain_text, only: is_plain
   implicit none (type, external)
   private
   public :: variable_type, visitor_type, smallest, largest

   !> Range of the magnitude of every number except 0: products of several such numbers do not overflow, and no train in SI units
   !> comes near. Lists may hold smaller numbers, which rounding makes of 0.
   real(dp), parameter :: smallest = 1e-20_dp, largest = 1e20_dp

   !> Lengths: of the choices, of a range as text (each choice may gain quotes and a comma), of an expectation in a message.
   integer, parameter :: choices_length = 80, range_length = 5*choices_length, expectation_length = range_length + 200
   !> Length of the longest number as text.
   integer, parameter :: number_length = 40

   type :: variable_type
      !> Name in the namelist; the description tells where a Fortran or Python call has another name.
      character(24) :: name = ''
      !> Unit, blank for a dimensionless value.
      character(12) :: unit = ''
      !> Meaning, as the reference page prints it.
      character(280) :: description = ''
      !> The case must give the variable.
      logical :: required = .false.
      !> Range: above < value, least <= value <= most.
      real(dp) :: above = -huge(1.0_dp), least = -huge(1.0_dp), most = huge(1.0_dp)
      !> A value outside the range that leaves the choice to the program; huge: none.
      real(dp) :: automatic = huge(1.0_dp)
      !> Allowed words of a text, separated by blanks; blank: any text.
      character(choices_length) :: choices = ''
      !> Of a list: number of values, 0: any number; whether all are whole numbers.
      integer :: values = 0
      logical :: whole = .false.
      !> Name of a variable that may not be given together with this variable; blank: none.
      character(24) :: excludes = ''
   contains
      procedure :: allows
      procedure :: allows_number
      procedure :: allows_text
      procedure :: range => range_text
      procedure :: expectation
   end type variable_type

   type, abstract :: visitor_type
      !> Name of the present group, blank between groups, and its number among the groups of this name.
      character(24) :: group = ''
      integer :: index = 1
   contains
      procedure :: enter
      procedure :: leave
      procedure(on_real_interface), deferred :: on_real
      procedure(on_integer_interface), deferred :: on_integer
      procedure(on_logical_interface), deferred :: on_logical
      procedure(on_text_interface), deferred :: on_text
      procedure(on_list_interface), deferred :: on_list
      procedure(on_names_interface), deferred :: on_names
   end type visitor_type

   abstract interface
      subroutine on_real_interface(self, variable, value, in_force)
         import :: visitor_type, variable_type, dp
         implicit none (type, external)
         class(visitor_type), intent(inout) :: self
         type(variable_type), intent(in) :: variable
         !> Value of the variable [variable%unit].
         real(dp), intent(inout) :: value
         !> Whether the value is used (absent: it is); a visitor that reads the variable sets .true.
         logical, intent(inout), optional :: in_force
      end subroutine on_real_interface
      subroutine on_integer_interface(self, variable, value)
         import :: visitor_type, variable_type
         implicit none (type, external)
         class(visitor_type), intent(inout) :: self
         type(variable_type), intent(in) :: variable
         !> Value of the variable.
         integer, intent(inout) :: value
      end subroutine on_integer_interface
      subroutine on_logical_interface(self, variable, value)
         import :: visitor_type, variable_type
         implicit none (type, external)
         class(visitor_type), intent(inout) :: self
         type(variable_type), intent(in) :: variable
         !> Value of the variable.
         logical, intent(inout) :: value
      end subroutine on_logical_interface
      subroutine on_text_interface(self, variable, value)
         import :: visitor_type, variable_type
         implicit none (type, external)
         class(visitor_type), intent(inout) :: self
         type(variable_type), intent(in) :: variable
         !> Value of the variable, not allocated where it is not given.
         character(:), allocatable, intent(inout) :: value
      end subroutine on_text_interface
      subroutine on_list_interface(self, variable, value)
         import :: visitor_type, variable_type, dp
         implicit none (type, external)
         class(visitor_type), intent(inout) :: self
         type(variable_type), intent(in) :: variable
         !> Values of the variable [variable%unit], not allocated where they are not given.
         real(dp), allocatable, intent(inout) :: value(:)
      end subroutine on_list_interface
      subroutine on_names_interface(self, variable, value)
         import :: visitor_type, variable_type
         implicit none (type, external)
         class(visitor_type), intent(inout) :: self
         type(variable_type), intent(in) :: variable
         !> Values of the variable, of which a case gives all or none: blank where they are not given.
         character(*), intent(inout) :: value(:)
      end subroutine on_names_interface
   end interface

contains

   !> Begins a group of variables; a visitor may extend this procedure.
   subroutine enter(self, group, index)
      class(visitor_type), intent(inout) :: self
      !> Name of the group.
      character(*), intent(in) :: group
      !> Number of the group among the groups of its name, from 1.
      integer, intent(in) :: index

      self%group = group
      self%index = index
   end subroutine enter

   !> Ends the group.
   subroutine leave(self)
      class(visitor_type), intent(inout) :: self

      self%group = ''
   end subroutine leave

   !> Whether a number is finite and in the range; an element of a list may be as small as it likes.
   elemental logical function allows(self, value)
      class(variable_type), intent(in) :: self
      !> Any number [self%unit].
      real(dp), intent(in) :: value

      allows = ieee_is_finite(value)
      if (.not. allows) return
      allows = value > self%above .and. value >= self%least .and. value <= self%most .and. abs(value) <= largest
      if (self%whole) allows = allows .and. abs(value - anint(value)) <= 0
      if (self%automatic < huge(1.0_dp)) allows = allows .or. abs(value - self%automatic) <= 0
   end function allows

   !> Whether the value of a scalar variable is allowed: in the range, and 0 or at least `smallest` in magnitude.
   pure logical function allows_number(self, value)
      class(variable_type), intent(in) :: self
      !> Any number [self%unit].
      real(dp), intent(in) :: value

      allows_number = self%allows(value)
      if (allows_number) allows_number = abs(value) >= smallest .or. abs(value) <= 0
   end function allows_number

   !> Whether a text is one of the choices; without choices, whether it is plain.
   pure logical function allows_text(self, value)
      class(variable_type), intent(in) :: self
      !> Any bytes.
      character(*), intent(in) :: value

      if (self%choices == '') then
         allows_text = is_plain(value)
      else
         allows_text = value /= '' .and. scan(trim(value), ' ') == 0 .and. index(' '//self%choices//' ', ' '//trim(value)//' ') > 0
      end if
   end function allows_text

   !> The range as text: '> 0', '>= 1, or 0', "'up', 'down' or 'both'"; '' where every value is allowed. To be trimmed.
   pure function range_text(self) result(text)
      class(variable_type), intent(in) :: self
      character(range_length) :: text

      text = ''
      if (self%choices /= '') then
         text = choice(trim(self%choices))
         return
      end if
      if (self%above > -huge(1.0_dp)) text = '> '//short(self%above)
      if (self%least > -huge(1.0_dp)) text = '>= '//short(self%least)
      if (self%most < huge(1.0_dp)) then
         if (text /= '') then
            text = trim(text)//' and <= '//short(self%most)
         else
            text = '<= '//short(self%most)
         end if
      end if
      if (self%automatic < huge(1.0_dp)) text = trim(text)//', or '//short(self%automatic)
   end function range_text

   !> The range as a message tells it: 'must be > 0 N/m', 'must be >= 1, or 0 to leave the choice to the program'. To be trimmed.
   pure function expectation(self, value) result(text)
      class(variable_type), intent(in) :: self
      !> The wrong value; where its magnitude is too large or too small for any variable, the text tells these limits.
      real(dp), intent(in), optional :: value
      character(expectation_length) :: text

      text = self%range()
      if (text == '') then
         text = 'must be finite'
      else
         text = 'must be '//trim(text)
         if (self%whole) text = trim(text)//' and whole'
         if (self%unit /= '') text = trim(text)//' '//trim(self%unit)
         if (self%automatic < huge(1.0_dp)) text = trim(text)//' to leave the choice to the program'
      end if
      if (.not. present(value)) return
      if (.not. ieee_is_finite(value)) return
      if (abs(value) > largest .or. abs(value) < smallest .and. abs(value) > 0) &
         text = trim(text)//', of a magnitude from '//real_text(smallest)//' to '//real_text(largest)
   end function expectation

   !> 'up down both' becomes "'up', 'down' or 'both'".
   pure function choice(words) result(text)
      character(*), intent(in) :: words
      character(range_length) :: text
      integer :: first, next

      text = ''
      first = 1
      do
         next = index(words(first:), ' ')
         if (next == 0) exit
         if (text /= '') text = trim(text)//','
         text = trim(text)//" '"//words(first:first + next - 2)//"'"
         first = first + next
      end do
      if (text /= '') text = trim(text)//' or'
      text = adjustl(trim(text)//" '"//words(first:)//"'")
   end function choice

   !> A bound as text, whole numbers without a decimal point. To be trimmed.
   pure function short(value) result(text)
      real(dp), intent(in) :: value
      character(number_length) :: text

      if (abs(value) < 1e6_dp .and. abs(value - anint(value)) <= 0) then
         text = integer_text(nint(value))
      else
         text = real_text(value)
      end if
   end function short

end module geartrain_base_variable
