!> One value of a case file: from its characters to a number, a logical or a text, or to what is wrong with it.
!>
!> Every character is looked at before Fortran's own read sees the value, which forgives too much (NaN, 1.0+5, 3abc).
module geartrain_input_values
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use geartrain_base_kinds, only: dp
   use geartrain_input_cursor, only: digits, lower
   use geartrain_input_scanner, only: token_type
   implicit none (type, external)
   private
   public :: read_real, read_integer, read_logical, read_text

contains

   !> `wrong` is '' where all is well, else what is expected.
   subroutine read_real(token, value, wrong)
      type(token_type), intent(in) :: token
      real(dp), intent(inout) :: value
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

   subroutine read_integer(token, value, wrong)
      type(token_type), intent(in) :: token
      integer, intent(inout) :: value
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

   subroutine read_logical(token, value, wrong)
      type(token_type), intent(in) :: token
      logical, intent(inout) :: value
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

   subroutine read_text(token, value, wrong)
      type(token_type), intent(in) :: token
      character(:), allocatable, intent(inout) :: value
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

   !> [+-] digits [. digits] [e or d, [+-] digits], at least one digit before the exponent.
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
