!> Numbers as short text for messages.
module geartrain_base_text
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: text

   interface text
      module procedure :: text_real
      module procedure :: text_integer
   end interface text

contains

   !> Up to six significant digits, no padding: 0.6356, 1e-09, 12.
   pure function text_real(x) result(text)
      real(dp), intent(in) :: x
      character(:), allocatable :: text
      character(24) :: buffer
      integer :: mark

      if (abs(x) >= 1e-3_dp .and. abs(x) < 1e6_dp) then
         write (buffer, '(f0.6)') x
         mark = len_trim(buffer)
         do while (buffer(mark:mark) == '0')
            mark = mark - 1
         end do
         if (buffer(mark:mark) == '.') mark = mark - 1
         text = buffer(:mark)
         if (text(1:1) == '.') text = '0'//text
         if (len(text) > 1) then
            if (text(1:2) == '-.') text = '-0'//text(2:)
         end if
      else if (abs(x) > 0) then
         write (buffer, '(es12.4)') x
         text = trim(adjustl(buffer))
      else
         text = '0'
      end if
   end function text_real

   pure function text_integer(i) result(text)
      integer, intent(in) :: i
      character(:), allocatable :: text
      character(12) :: buffer

      write (buffer, '(i0)') i
      text = trim(buffer)
   end function text_integer

end module geartrain_base_text
