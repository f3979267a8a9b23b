!> The seal at the end of a results file, after the bytes of HDF5: length and checksum of these bytes. A file whose seal fits has
!> not changed since it was written; no other file is read, not even by HDF5.
module geartrain_results_seal
   use, intrinsic :: iso_fortran_env, only: int8, int64
   use geartrain_base_checksum, only: crc64
   use geartrain_base_error, only: error_type, fatal, status_file
   use geartrain_results_file, only: read_bytes
   implicit none (type, external)
   private
   public :: add_seal, check_replaceable, is_whole, read_seal, seal_bytes

   character(*), parameter :: mark = 'geartrain sealed'
   !> Bytes of a seal: the mark, the number of bytes before it and their checksum.
   integer, parameter :: seal_bytes = len(mark) + 16

contains

   !> Puts the seal at the end of the content of a file.
   pure subroutine add_seal(content)
      !> All bytes of the file; the last `seal_bytes` are room for the seal.
      integer(int8), intent(inout), contiguous :: content(:)
      integer(int64) :: n

      n = size(content, kind=int64) - seal_bytes
      content(n + 1:) = seal_of(content(:n))
   end subroutine add_seal

   !> Whether the content of a file ends with its seal.
   pure logical function is_whole(content)
      !> All bytes of the file.
      integer(int8), intent(in), contiguous :: content(:)
      integer(int64) :: n

      n = size(content, kind=int64) - seal_bytes
      is_whole = n >= 0
      if (is_whole) is_whole = all(content(n + 1:) == seal_of(content(:n)))
   end function is_whole

   !> Fails where there is a file that is no results file: a slip in the name of the output must not cost another file.
   subroutine check_replaceable(path, error)
      !> Path of the file that is to be written.
      character(*), intent(in) :: path
      type(error_type), allocatable, intent(inout) :: error
      integer(int8), allocatable :: seal(:)
      logical :: there, is_folder

      ! A link without target is replaced; writing tells of a folder.
      inquire (file=path, exist=there)
      inquire (file=path//'/.', exist=is_folder)
      if (.not. there .or. is_folder) return
      call read_seal(path, seal)
      if (allocated(seal)) then
         if (all(seal(:len(mark)) == transfer(mark, seal))) return
      end if
      call fatal(error, path//': error: cannot be written: there is a file that is no results file of geartrain, and it is not &
                 &overwritten: remove or rename it, or name another file', status_file)
   end subroutine check_replaceable

   !> The seal of the bytes before it.
   pure function seal_of(content) result(seal)
      integer(int8), intent(in), contiguous :: content(:)
      integer(int8) :: seal(seal_bytes)

      seal(:len(mark)) = transfer(mark, seal)
      seal(len(mark) + 1:) = transfer([size(content, kind=int64), crc64(content)], seal)
   end function seal_of

   !> Reads the seal of a file; whether the seal fits is not checked.
   subroutine read_seal(path, seal)
      !> Path of the file.
      character(*), intent(in) :: path
      !> (seal_bytes); not allocated where the file cannot be read or is too short.
      integer(int8), allocatable, intent(out) :: seal(:)

      call read_bytes(path, seal, seal_bytes)
   end subroutine read_seal

end module geartrain_results_seal
