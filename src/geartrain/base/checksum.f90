!> CRC-64 as in xz (polynomial of ECMA-182, reflected). A change within eight neighbouring bytes or of any two bits always changes
!> the checksum, any other change fails to do so in one case of 2**64.
module geartrain_base_checksum
   use, intrinsic :: iso_fortran_env, only: int8, int64
   implicit none (type, external)
   private
   public :: crc64

   integer(int64), parameter :: polynomial = int(z'C96C5795D7870F42', int64)

contains

   !> Checksum; 995DC9BBDF1939FA for the nine characters 123456789. Takes eight bytes at a time, each with its own table
   !> (M. E. Kounavis and F. L. Berry, IEEE Symposium on Computers and Communications 2005).
   pure integer(int64) function crc64(bytes)
      !> Any number of bytes.
      integer(int8), intent(in), contiguous :: bytes(:)
      integer(int64) :: table(0:255, 0:7), word, i
      integer :: k

      call make_tables(table)
      crc64 = -1
      do i = 1, size(bytes, kind=int64) - 7, 8
         word = 0
         do k = 7, 0, -1
            word = ior(shiftl(word, 8), iand(int(bytes(i + k), int64), 255_int64))
         end do
         word = ieor(word, crc64)
         crc64 = 0
         do k = 0, 7
            crc64 = ieor(crc64, table(ibits(word, 8*k, 8), 7 - k))
         end do
      end do
      do i = size(bytes, kind=int64) - mod(size(bytes, kind=int64), 8_int64) + 1, size(bytes, kind=int64)
         crc64 = ieor(table(iand(ieor(crc64, int(bytes(i), int64)), 255_int64), 0), shiftr(crc64, 8))
      end do
      crc64 = not(crc64)
   end function crc64

   !> table(b, k): what the byte b contributes to the checksum when k bytes follow it.
   pure subroutine make_tables(table)
      integer(int64), intent(out) :: table(0:255, 0:7)
      integer :: k, bit

      do k = 0, 255
         table(k, 0) = k
         do bit = 1, 8
            table(k, 0) = ieor(shiftr(table(k, 0), 1), merge(polynomial, 0_int64, btest(table(k, 0), 0)))
         end do
      end do
      do k = 1, 7
         table(:, k) = ieor(table(iand(table(:, k - 1), 255_int64), 0), shiftr(table(:, k - 1), 8))
      end do
   end subroutine make_tables

end module geartrain_base_checksum
