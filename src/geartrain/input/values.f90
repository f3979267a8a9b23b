!> Reads one value of a case file as a number, a logical or a text, or tells what is wrong with the value.
!>
!> All characters are checked before the value goes to Fortran's read, which accepts too much (NaN, 1.0+5, 3abc).
module geartrain_input_values
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use geartrain_base_kinds, only: dp
   use geartrain_input_cursor, only: digits, lower
   use geartrain_input_scanner, only: token_type
   implicit none (type, external)
   private
   public :: read_real, read_integer, read_logical, read_text

contains

   !> Reads a real number.
   subroutine read_real(token, value, wrong)
      !> The value as written.
      type(token_type), intent(in) :: token
      !> The number; unchanged if the value is wrong.
      real(dp), intent(inout) :: value
      !> What is expected; '': the value is right.
      character(:), allocatable, intent(out) :: wrong
      real(dp) :: number
      integer :: status

      wrong = 'must be a number'
      if (token%quoted) then
         wrong = 'must be a number, without quotes'
      else if (is_not_finite(token%text)) then
         wrong = 'must be a finite number'
      else if (is_real(token%text)) then
         read (token%text, *, iostat=status) number
         if (status /= 0) return
         wrong = 'must be a finite number (it is too large)'
         if (.not. ieee_is_finite(number)) return
         wrong = 'is too small to be represented: write 0.0'
         if (abs(number) <= 0 .and. scan(token%text(:scan(token%text//'e', 'eEdD') - 1), '123456789') > 0) return
         wrong = ''
         value = number
      end if
   end subroutine read_real

   !> Reads a whole number.
   subroutine read_integer(token, value, wrong)
      !> The value as written.
      type(token_type), intent(in) :: token
      !> The number; unchanged if the value is wrong.
      integer, intent(inout) :: value
      !> What is expected; '': the value is right.
      character(:), allocatable, intent(out) :: wrong
      integer :: number, status

      wrong = 'must be a whole number'
      if (token%quoted) then
         wrong = 'must be a whole number, without quotes'
      else if (is_integer(token%text)) then
         read (token%text, *, iostat=status) number
         if (status /= 0) then
            wrong = 'must be a whole number below 2147483648'
         else
            wrong = ''
            value = number
         end if
      end if
   end subroutine read_integer

   !> Reads a logical.
   subroutine read_logical(token, value, wrong)
      !> The value as written.
      type(token_type), intent(in) :: token
      !> The logical; unchanged if the value is wrong.
      logical, intent(inout) :: value
      !> What is expected; '': the value is right.
      character(:), allocatable, intent(out) :: wrong

      wrong = ''
      select case (lower(token%text))
      case ('.true.', '.t.', 'true', 't')
         if (.not. token%quoted) value = .true.
      case ('.false.', '.f.', 'false', 'f')
         if (.not. token%quoted) value = .false.
      case default
         wrong = 'must be .true. or .false.'
      end select
      if (token%quoted) wrong = 'must be .true. or .false., without quotes'
   end subroutine read_logical

   !> Reads a text in quotes.
   subroutine read_text(token, value, wrong)
      !> The value as written.
      type(token_type), intent(in) :: token
      !> The text; unchanged if the value is wrong.
      character(:), allocatable, intent(inout) :: value
      !> What is expected; '': the value is right.
      character(:), allocatable, intent(out) :: wrong

      wrong = ''
      if (token%quoted) then
         value = token%text
      else
         wrong = "must be a text in quotes, '...'"
      end if
   end subroutine read_text

   pure logical function is_not_finite(text)
      character(*), intent(in) :: text
      character(len(text)) :: unsigned

      unsigned = lower(text)
      if (scan(text, '+-') == 1) unsigned = unsigned(2:)
      is_not_finite = unsigned == 'nan' .or. unsigned == 'inf' .or. unsigned == 'infinity'
   end function is_not_finite

   pure logical function is_integer(text)
      character(*), intent(in) :: text
      integer :: first

      first = 1
      if (scan(text, '+-') == 1) first = 2
      is_integer = len(text) >= first .and. verify(text(first:), digits) == 0
   end function is_integer

   !> Whether a text has the form [+-] digits [. digits] [e or d, [+-] digits], with at least one digit before the exponent.
   pure logical function is_real(text)
      character(*), intent(in) :: text
      character(:), allocatable :: mantissa
      integer :: at_exponent, at_point

      is_real = .false.
      at_exponent = scan(text, 'eEdD')
      if (at_exponent > 0) then
         if (.not. is_integer(text(at_exponent + 1:))) return
         mantissa = text(:at_exponent - 1)
      else
         mantissa = text
      end if
      if (scan(mantissa, '+-') == 1) mantissa = mantissa(2:)
      at_point = index(mantissa, '.')
      if (at_point > 0) mantissa = mantissa(:at_point - 1)//mantissa(at_point + 1:)
      is_real = len(mantissa) > 0 .and. verify(mantissa, digits) == 0
   end function is_real

end module geartrain_input_values
