!> Numbers as text: the shortest decimal that reads back to the same bits, or a rounded one for messages.
!>
!> No function of the library has a result `character(:), allocatable`: gfortran keeps the length of such a result in a static
!> variable of the caller, which two threads in this statement would share. Short texts have a length that follows from the
!> arguments, or blanks at the end; long texts are arguments of a subroutine.
module geartrain_base_numbers
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: counted, fixed, integer_text, ordinal, real_text, significant, text, whole

   !> A number in a message: an integer, or a real to six digits.
   interface text
      module procedure :: short_text
      module procedure :: integer_text
      module procedure :: long_text
   end interface text

   !> Length of the longest number as text.
   integer, parameter :: longest = 40

contains

   !> Nearest integer to a number of a case that may not have been checked; the largest where there is none.
   pure elemental integer function whole(value)
      !> Any number, also none.
      real(dp), intent(in) :: value

      whole = huge(1)
      if (.not. ieee_is_finite(value)) return
      if (abs(value) < huge(1)) whole = nint(value)
   end function whole

   ! Each function with blanks at the end stands before the function whose length it gives, as gfortran requires.

   pure function padded_real(value) result(text)
      real(dp), intent(in) :: value
      character(longest) :: text
      character(longest) :: buffer
      character(*), parameter :: full(15:17) = ['(es36.14e3)', '(es36.15e3)', '(es36.16e3)']
      character(16) :: form
      real(dp) :: again
      integer :: digits

      if (ieee_is_nan(value)) then
         text = 'NaN'
      else if (.not. ieee_is_finite(value)) then
         text = 'Infinity'
         if (value < 0) text = '-Infinity'
      else
         ! 15 digits tell all decimals of 15 digits and fewer apart, but for numbers with less than full precision.
         do digits = merge(1, 15, abs(value) < tiny(value)), 17
            if (digits < 15) then
               write (form, '(a, i0, a)') '(es36.', digits - 1, 'e3)'
               write (buffer, form) value
            else
               write (buffer, full(digits)) value
            end if
            read (buffer, '(f36.0)') again
            if (abs(again - value) <= 0) exit
         end do
         text = plain(trim(adjustl(buffer)))
      end if
   end function padded_real

   !> Shortest decimal of 1 to 17 significant digits that reads back to the same bits: '0.05', '2.5e8', '-1.0'.
   pure function real_text(value) result(text)
      !> Any number; 'NaN', 'Infinity' or '-Infinity' where it is not finite.
      real(dp), intent(in) :: value
      character(len_trim(padded_real(value))) :: text

      text = padded_real(value)
   end function real_text

   !> Turns '2.50E+008' into '2.5e8' and '5.00E-002' into '0.05': no zeros at the end, no exponent from 1e-4 to below 1e6.
   pure function plain(scientific) result(text)
      character(*), intent(in) :: scientific
      character(longest) :: text
      character(:), allocatable :: digits, sign
      integer :: at_exponent, exponent, first

      sign = ''
      if (scientific(1:1) == '-') sign = '-'
      at_exponent = index(scientific, 'E')
      read (scientific(at_exponent + 1:), '(i8)') exponent
      first = len(sign) + 1
      digits = scientific(first:first)//scientific(first + 2:at_exponent - 1)
      digits = digits(:max(1, verify(digits, '0', back=.true.)))
      if (exponent >= 6 .or. exponent < -4) then
         if (len(digits) == 1) digits = digits//'0'
         text = sign//digits(1:1)//'.'//digits(2:)//'e'//integer_text(exponent)
      else if (exponent >= 0) then
         if (len(digits) < exponent + 2) digits = digits//repeat('0', exponent + 2 - len(digits))
         text = sign//digits(:exponent + 1)//'.'//digits(exponent + 2:)
      else
         text = sign//'0.'//repeat('0', -exponent - 1)//digits
      end if
   end function plain

   pure function padded_short(x) result(text)
      real(dp), intent(in) :: x
      character(longest) :: text
      character(24) :: buffer
      real(dp) :: rounded
      integer :: mark

      if (abs(x) >= 1e-3_dp .and. abs(x) < 1e6_dp) then
         write (buffer, '(f0.6)') x
         mark = len_trim(buffer)
         do while (buffer(mark:mark) == '0')
            mark = mark - 1
         end do
         if (buffer(mark:mark) == '.') mark = mark - 1
         text = buffer(:mark)
         if (text(1:1) == '.') text = '0'//trim(text)
         if (text(1:2) == '-.') text = '-0'//trim(text(2:))
      else if (abs(x) > 0 .and. ieee_is_finite(x)) then
         write (buffer, '(es13.4e3)') x
         read (buffer, *) rounded
         text = padded_real(rounded)
      else
         text = padded_real(x)
      end if
   end function padded_short

   !> Up to six digits after the point, no padding: 0.6356, 1.0e-9, 12.
   pure function short_text(x) result(text)
      !> Any number.
      real(dp), intent(in) :: x
      character(len_trim(padded_short(x))) :: text

      text = padded_short(x)
   end function short_text

   pure function padded_integer(value) result(text)
      integer(int64), intent(in) :: value
      character(longest) :: text
      integer(int64) :: rest
      integer :: place

      ! Digit by digit: an internal write takes fifty times as long, and a list of fields has hundreds of numbers. The digits are
      ! those of a negative number, because the least integer has no positive counterpart.
      text = ''
      rest = value
      if (rest > 0) rest = -rest
      place = longest
      do
         text(place:place) = achar(iachar('0') - int(mod(rest, 10_int64)))
         rest = rest/10
         if (rest == 0) exit
         place = place - 1
      end do
      if (value < 0) then
         place = place - 1
         text(place:place) = '-'
      end if
      text = adjustl(text)
   end function padded_integer

   !> A whole number without blanks: '-12'.
   pure function integer_text(value) result(text)
      !> Any number.
      integer, intent(in) :: value
      character(len_trim(padded_integer(int(value, int64)))) :: text

      text = padded_integer(int(value, int64))
   end function integer_text

   !> A whole number of 64 bits without blanks.
   pure function long_text(value) result(text)
      !> Any number.
      integer(int64), intent(in) :: value
      character(len_trim(padded_integer(value))) :: text

      text = padded_integer(value)
   end function long_text

   !> A number with blanks at the end. Unlike f0.d the text has the zero before the point, and no point at the end.
   pure function padded_fixed(value, decimals) result(text)
      real(dp), intent(in) :: value
      integer, intent(in) :: decimals
      character(32) :: text
      character(8) :: form

      write (form, '(a, i0, a)') '(f24.', decimals, ')'
      write (text, form) value
      text = adjustl(text)
      if (decimals == 0) text = text(:len_trim(text) - 1)
   end function padded_fixed

   !> A number with a fixed number of digits after the point: '0.50'.
   pure function fixed(value, decimals) result(text)
      !> The number.
      real(dp), intent(in) :: value
      !> Digits after the point.
      integer, intent(in) :: decimals
      character(len_trim(padded_fixed(value, decimals))) :: text

      text = padded_fixed(value, decimals)
   end function fixed

   pure function padded_significant(value) result(text)
      real(dp), intent(in) :: value
      character(longest) :: text
      character(longest) :: buffer
      real(dp) :: rounded
      integer :: exponent, last

      if (.not. (abs(value) > 0 .and. ieee_is_finite(value))) then
         text = padded_real(value)
         if (abs(value) <= 0) text = '0'
         return
      end if
      write (buffer, '(es13.3e3)') value
      read (buffer(index(buffer, 'E') + 1:), *) exponent
      read (buffer, *) rounded
      if (exponent < -4 .or. exponent > 8) then
         text = padded_real(rounded)
         return
      end if
      text = padded_fixed(rounded, max(0, 3 - exponent))
      if (exponent >= 3) return
      last = verify(trim(text), '0', back=.true.)
      if (text(last:last) == '.') last = last - 1
      text = text(:last)
   end function padded_significant

   !> A result to four significant digits, without zeros at the end: '38810', '0.3656', '1.5'.
   pure function significant(value) result(text)
      !> Any number.
      real(dp), intent(in) :: value
      character(len_trim(padded_significant(value))) :: text

      text = padded_significant(value)
   end function significant

   !> How many there are of something: '1 point', '0 points', '2 meshes'.
   pure function counted(number, one, many) result(text)
      !> The number.
      integer, intent(in) :: number
      !> The word for one, and the word for several.
      character(*), intent(in) :: one, many
      character(len_trim(padded_integer(int(number, int64))) + 1 + merge(len(one), len(many), number == 1)) :: text

      if (number == 1) text = '1 '//one
      if (number /= 1) text = trim(padded_integer(int(number, int64)))//' '//many
   end function counted

   !> A number of a series: '1st', '2nd', '3rd', '4th', '11th', '22nd'.
   pure function ordinal(number) result(text)
      !> The number, > 0.
      integer, intent(in) :: number
      character(len_trim(padded_integer(int(number, int64))) + 2) :: text
      character(2) :: ending

      ending = 'th'
      if (mod(number/10, 10) /= 1) then
         if (mod(number, 10) == 1) ending = 'st'
         if (mod(number, 10) == 2) ending = 'nd'
         if (mod(number, 10) == 3) ending = 'rd'
      end if
      text = trim(padded_integer(int(number, int64)))//ending
   end function ordinal

end module geartrain_base_numbers
