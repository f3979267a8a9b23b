!> The seal at the end of a checkpoint, after what HDF5 reads: how long the file is and its checksum. A file whose seal fits is what
!> was written, bit by bit, and nothing of another is handed on, not even to HDF5.
module geartrain_results_seal
   use, intrinsic :: iso_fortran_env, only: int8, int64
   use geartrain_base_checksum, only: crc64
   use geartrain_base_regular_file, only: is_regular_file
   implicit none (type, external)
   private
   public :: add_seal, is_whole, read_seal, seal_bytes

   character(*), parameter :: mark = 'geartrain sealed'
   !> Bytes of a seal: the mark, the number of bytes before it and their checksum.
   integer, parameter :: seal_bytes = len(mark) + 16

contains

   !> Appends the seal to the content of a file.
   subroutine add_seal(content)
      integer(int8), allocatable, intent(inout) :: content(:)
      integer(int8), allocatable :: sealed(:)
      integer(int64) :: n

      n = size(content, kind=int64)
      allocate (sealed(n + seal_bytes))
      sealed(:n) = content
      sealed(n + 1:) = seal_of(content)
      call move_alloc(sealed, content)
   end subroutine add_seal

   !> Whether the content of a file ends with its seal.
   pure logical function is_whole(content)
      integer(int8), intent(in) :: content(:)
      integer(int64) :: n

      n = size(content, kind=int64) - seal_bytes
      is_whole = n >= 0
      if (is_whole) is_whole = all(content(n + 1:) == seal_of(content(:n)))
   end function is_whole

   pure function seal_of(content) result(seal)
      integer(int8), intent(in) :: content(:)
      integer(int8) :: seal(seal_bytes)

      seal(:len(mark)) = transfer(mark, seal)
      seal(len(mark) + 1:) = transfer([size(content, kind=int64), crc64(content)], seal)
   end function seal_of

   !> The seal at the end of a file, as it stands there; not allocated where there is no such file or it is too short.
   subroutine read_seal(path, seal)
      character(*), intent(in) :: path
      integer(int8), allocatable, intent(out) :: seal(:)
      integer(int64) :: bytes
      integer :: unit, status

      if (.not. is_regular_file(path)) return
      open (newunit=unit, file=path, access='stream', form='unformatted', status='old', action='read', iostat=status)
      if (status /= 0) return
      inquire (unit=unit, size=bytes)
      if (bytes >= seal_bytes) then
         allocate (seal(seal_bytes))
         read (unit, pos=bytes - seal_bytes + 1, iostat=status) seal
         if (status /= 0) deallocate (seal)
      end if
      close (unit, iostat=status)
   end subroutine read_seal

end module geartrain_results_seal
