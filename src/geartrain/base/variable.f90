!> A row of the table of input variables, and the visitor that is led over the rows and the values that they name.
!>
!> The table itself is written as visits (the modules `geartrain_*_variables`): one call a variable ties its
!> name, unit, range and description to the component that holds it. Reading, checking, writing and documenting are visitors.
module geartrain_base_variable
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text, real_text
   implicit none (type, external)
   private
   public :: variable_type, visitor_type, is_utf_8, smallest, largest

   !> Magnitudes of numbers that are not 0, for every variable: products of several of them are numbers still, and no train in SI
   !> units comes near. A list may hold smaller ones: rounding of what is 0.
   real(dp), parameter :: smallest = 1e-20_dp, largest = 1e20_dp

   !> Room for choices in a variable and in words, where each may gain quotes and a comma; for what is allowed, and for that in a
   !> message.
   integer, parameter :: choices_length = 80, range_length = 5*choices_length, expectation_length = range_length + 200
   !> Room for a number.
   integer, parameter :: number_length = 40

   type :: variable_type
      !> Name in the namelist; where the names differ, the keyword of a Fortran or Python call is told in the description.
      character(24) :: name = ''
      !> Unit, blank for a dimensionless value.
      character(12) :: unit = ''
      character(280) :: description = ''
      logical :: required = .false.
      !> Range: above < value, least <= value <= most.
      real(dp) :: above = -huge(1.0_dp), least = -huge(1.0_dp), most = huge(1.0_dp)
      !> One value outside the range that leaves the choice to the program; huge: there is none.
      real(dp) :: automatic = huge(1.0_dp)
      !> Words a text may be, separated by blanks; blank: any text.
      character(choices_length) :: choices = ''
      !> Name of a variable that may not be given together with this one.
      character(24) :: excludes = ''
   contains
      procedure :: allows
      procedure :: allows_number
      procedure :: allows_text
      procedure :: range => range_text
      procedure :: expectation
   end type variable_type

   type, abstract :: visitor_type
      !> The group being visited, and its number among the groups of that name.
      character(16) :: group = ''
      integer :: index = 1
   contains
      procedure :: enter
      procedure :: leave
      procedure(on_real_interface), deferred :: on_real
      procedure(on_integer_interface), deferred :: on_integer
      procedure(on_logical_interface), deferred :: on_logical
      procedure(on_text_interface), deferred :: on_text
      procedure(on_list_interface), deferred :: on_list
   end type visitor_type

   abstract interface
      subroutine on_real_interface(self, variable, value, in_force)
         import :: visitor_type, variable_type, dp
         implicit none (type, external)
         class(visitor_type), intent(inout) :: self
         type(variable_type), intent(in) :: variable
         real(dp), intent(inout) :: value
         !> Whether the value is in force (absent: it is); whoever gives the variable sets it.
         logical, intent(inout), optional :: in_force
      end subroutine on_real_interface
      subroutine on_integer_interface(self, variable, value)
         import :: visitor_type, variable_type
         implicit none (type, external)
         class(visitor_type), intent(inout) :: self
         type(variable_type), intent(in) :: variable
         integer, intent(inout) :: value
      end subroutine on_integer_interface
      subroutine on_logical_interface(self, variable, value)
         import :: visitor_type, variable_type
         implicit none (type, external)
         class(visitor_type), intent(inout) :: self
         type(variable_type), intent(in) :: variable
         logical, intent(inout) :: value
      end subroutine on_logical_interface
      subroutine on_text_interface(self, variable, value)
         import :: visitor_type, variable_type
         implicit none (type, external)
         class(visitor_type), intent(inout) :: self
         type(variable_type), intent(in) :: variable
         character(:), allocatable, intent(inout) :: value
      end subroutine on_text_interface
      subroutine on_list_interface(self, variable, value)
         import :: visitor_type, variable_type, dp
         implicit none (type, external)
         class(visitor_type), intent(inout) :: self
         type(variable_type), intent(in) :: variable
         real(dp), allocatable, intent(inout) :: value(:)
      end subroutine on_list_interface
   end interface

contains

   !> Opens a group; a visitor that cares extends it.
   subroutine enter(self, group, index)
      class(visitor_type), intent(inout) :: self
      character(*), intent(in) :: group
      integer, intent(in) :: index

      self%group = group
      self%index = index
   end subroutine enter

   !> Closes the group.
   subroutine leave(self)
      class(visitor_type), intent(inout) :: self

      self%group = ''
   end subroutine leave

   elemental logical function allows(self, value)
      class(variable_type), intent(in) :: self
      real(dp), intent(in) :: value

      allows = ieee_is_finite(value)
      if (.not. allows) return
      allows = value > self%above .and. value >= self%least .and. value <= self%most .and. abs(value) <= largest
      if (self%automatic < huge(1.0_dp)) allows = allows .or. abs(value - self%automatic) <= 0
   end function allows

   !> Of a real number on its own, which must not be next to nothing.
   pure logical function allows_number(self, value)
      class(variable_type), intent(in) :: self
      real(dp), intent(in) :: value

      allows_number = self%allows(value)
      if (allows_number) allows_number = abs(value) >= smallest .or. abs(value) <= 0
   end function allows_number

   pure logical function allows_text(self, value)
      class(variable_type), intent(in) :: self
      character(*), intent(in) :: value
      integer :: i

      if (self%choices == '') then
         allows_text = all([(iachar(value(i:i)) >= 32 .and. iachar(value(i:i)) /= 127, i = 1, len(value))]) .and. is_utf_8(value)
      else
         allows_text = value /= '' .and. scan(trim(value), ' ') == 0 .and. index(' '//self%choices//' ', ' '//trim(value)//' ') > 0
      end if
   end function allows_text

   !> Whether the bytes are characters of UTF-8: what HDF5 and Python are told that every text is.
   pure logical function is_utf_8(text)
      character(*), intent(in) :: text
      integer, parameter :: shortest(3) = [128, 2048, 65536]
      integer :: i, k, byte, more, code

      is_utf_8 = .false.
      i = 1
      do while (i <= len(text))
         byte = iachar(text(i:i))
         more = count(byte >= [192, 224, 240])
         if (byte >= 128 .and. more == 0 .or. byte >= 248 .or. i + more > len(text)) return
         code = iand(byte, merge(127, 63/2**more, more == 0))
         do k = i + 1, i + more
            byte = iachar(text(k:k))
            if (iand(byte, 192) /= 128) return
            code = 64*code + iand(byte, 63)
         end do
         ! Not longer than need be, no surrogate, within Unicode.
         if (more > 0 .and. code < shortest(max(1, more))) return
         if (code >= 55296 .and. code <= 57343 .or. code > 1114111) return
         i = i + more + 1
      end do
      is_utf_8 = .true.
   end function is_utf_8

   !> What is allowed, short: '> 0', '>= 1, or 0', "'up', 'down' or 'both'"; '' where anything is. To be trimmed.
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

   !> What is allowed, as a message says it: 'must be > 0 N/m', 'must be >= 1, or 0 to leave the choice to the program'. Of a value
   !> that is too large or too small for a number of any variable it says that. To be trimmed.
   pure function expectation(self, value) result(text)
      class(variable_type), intent(in) :: self
      real(dp), intent(in), optional :: value
      character(expectation_length) :: text

      text = self%range()
      if (text == '') then
         text = 'must be finite'
      else
         text = 'must be '//trim(text)
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

   !> A bound as text; whole numbers without the point. To be trimmed.
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
