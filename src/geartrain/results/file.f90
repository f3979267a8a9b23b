!> Puts a whole file in place of an old one: whoever looks sees the old one or the new one, never half of it.
module geartrain_results_file
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char
   use, intrinsic :: iso_fortran_env, only: int8, int64
   use geartrain_base_error, only: error_type, fatal, status_file
   implicit none (type, external)
   private
   public :: check_place, remove_file, replace_file

   interface
      integer(c_int) function c_rename(from, to) bind(c, name='rename')
         import :: c_char, c_int
         implicit none (type, external)
         character(kind=c_char), intent(in) :: from(*), to(*)
      end function c_rename

      integer(c_int) function c_remove(path) bind(c, name='remove')
         import :: c_char, c_int
         implicit none (type, external)
         character(kind=c_char), intent(in) :: path(*)
      end function c_remove
   end interface

contains

   !> Writes `content` to path.tmp and renames it; on failure the old file and nothing else is left.
   subroutine replace_file(path, content, error)
      character(*), intent(in) :: path
      integer(int8), intent(in) :: content(:)
      type(error_type), allocatable, intent(inout) :: error
      character(:), allocatable :: why
      integer(int64) :: bytes
      integer :: unit

      call check_kind(path, error)
      if (allocated(error)) return
      call open_temporary(path, unit, error)
      if (allocated(error)) return
      call fill(unit, content, why)
      inquire (file=path//'.tmp', size=bytes)
      if (.not. allocated(why) .and. bytes /= size(content, kind=int64)) why = 'not all bytes were taken; is the disk full?'
      if (.not. allocated(why)) then
         if (c_rename(path//'.tmp'//c_null_char, path//c_null_char) /= 0) why = path//'.tmp cannot be renamed'
      end if
      if (.not. allocated(why)) return
      call remove_file(path//'.tmp')
      call fatal(error, path//': error: cannot be written: '//why, status_file)
   end subroutine replace_file

   !> Fails where replace_file would: asked before hours of computing.
   subroutine check_place(path, error)
      character(*), intent(in) :: path
      type(error_type), allocatable, intent(inout) :: error
      integer :: unit

      call check_kind(path, error)
      if (allocated(error)) return
      call open_temporary(path, unit, error)
      if (.not. allocated(error)) close (unit, status='delete')
   end subroutine check_place

   !> Removes a file if it is there.
   subroutine remove_file(path)
      character(*), intent(in) :: path
      logical :: exists
      integer(c_int) :: status

      inquire (file=path, exist=exists)
      if (exists) status = c_remove(path//c_null_char)
   end subroutine remove_file

   !> What stands at `path` must be something that a file may replace.
   subroutine check_kind(path, error)
      character(*), intent(in) :: path
      type(error_type), allocatable, intent(inout) :: error
      character(:), allocatable :: folder
      character(8) :: writable
      logical :: exists

      inquire (file=path//'/.', exist=exists)
      if (exists) then
         call fatal(error, path//': error: cannot be written: it is a folder; give the name of a file', status_file)
         return
      end if
      folder = path(:index(path, '/', back=.true.))
      inquire (file=folder//'.', exist=exists)
      if (.not. exists) then
         call fatal(error, path//': error: cannot be written: there is no folder '//folder, status_file)
         return
      end if
      ! Renaming would go over a write-protected file, and over a device.
      inquire (file=path, exist=exists, write=writable)
      if (exists .and. writable == 'NO') then
         call fatal(error, path//': error: cannot be written: it is write-protected', status_file)
      else if (folder == '/dev/') then
         call fatal(error, path//': error: cannot be written: it is a device', status_file)
      end if
   end subroutine check_kind

   subroutine open_temporary(path, unit, error)
      character(*), intent(in) :: path
      integer, intent(out) :: unit
      type(error_type), allocatable, intent(inout) :: error
      character(512) :: message
      integer :: status

      open (newunit=unit, file=path//'.tmp', access='stream', form='unformatted', status='replace', action='write', &
            iostat=status, iomsg=message)
      if (status /= 0) call fatal(error, path//': error: cannot be written: '//trim(message), status_file)
   end subroutine open_temporary

   !> Writes and closes; `why` is allocated where that failed.
   subroutine fill(unit, content, why)
      integer, intent(in) :: unit
      integer(int8), intent(in) :: content(:)
      character(:), allocatable, intent(out) :: why
      character(512) :: message
      integer :: status

      write (unit, iostat=status, iomsg=message) content
      if (status /= 0) why = trim(message)
      close (unit, iostat=status, iomsg=message)
      if (status /= 0 .and. .not. allocated(why)) why = trim(message)
   end subroutine fill

end module geartrain_results_file
