!> Puts a whole file in place of an old one: whoever looks sees the old one or the new one, never half of it.
module geartrain_results_file
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char
   use, intrinsic :: iso_fortran_env, only: int8, int64
   use geartrain_base_error, only: error_type, fatal, status_file
   use geartrain_base_numbers, only: integer_text
   implicit none (type, external)
   private
   public :: check_place, remove_file, replace_file, temporary

   interface
      integer(c_int) function c_rename(from, to) bind(c, name='rename')
         import :: c_char, c_int
         implicit none (type, external)
         character(kind=c_char), intent(in) :: from(*), to(*)
      end function c_rename

      integer(c_int) function c_getpid() bind(c, name='getpid')
         import :: c_int
         implicit none (type, external)
      end function c_getpid

      !> The flags say for reading; without a mode, which only a file to be made needs.
      integer(c_int) function c_open(path, flags) bind(c, name='open')
         import :: c_char, c_int
         implicit none (type, external)
         character(kind=c_char), intent(in) :: path(*)
         integer(c_int), value :: flags
      end function c_open

      integer(c_int) function c_fsync(descriptor) bind(c, name='fsync')
         import :: c_int
         implicit none (type, external)
         integer(c_int), value :: descriptor
      end function c_fsync

      integer(c_int) function c_close(descriptor) bind(c, name='close')
         import :: c_int
         implicit none (type, external)
         integer(c_int), value :: descriptor
      end function c_close

      integer(c_int) function c_remove(path) bind(c, name='remove')
         import :: c_char, c_int
         implicit none (type, external)
         character(kind=c_char), intent(in) :: path(*)
      end function c_remove
   end interface

contains

   !> Writes `content` to a file beside it and renames that; on failure the old file and nothing else is left. Of two runs that
   !> write one file the later one wins, with a whole file: each has a temporary file of its own.
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
      inquire (file=temporary(path), size=bytes)
      if (.not. allocated(why) .and. bytes /= size(content, kind=int64)) why = 'not all bytes were taken; is the disk full?'
      if (.not. allocated(why)) call put_on_disk(temporary(path), why)
      if (.not. allocated(why)) then
         if (c_rename(temporary(path)//c_null_char, path//c_null_char) /= 0) why = temporary(path)//' cannot be renamed'
      end if
      if (.not. allocated(why)) return
      call remove_file(temporary(path))
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

      open (newunit=unit, file=temporary(path), access='stream', form='unformatted', status='replace', action='write', &
            iostat=status, iomsg=message)
      if (status /= 0) call fatal(error, path//': error: cannot be written: '//trim(message), status_file)
   end subroutine open_temporary

   !> Where the file at `path` is put together, of this process alone.
   function temporary(path) result(name)
      character(*), intent(in) :: path
      character(:), allocatable :: name

      name = path//'.'//integer_text(int(c_getpid()))//'.tmp'
   end function temporary

   !> Waits until the bytes of a file are on the disk: renamed earlier, an empty file could be left by a power failure.
   subroutine put_on_disk(path, why)
      character(*), intent(in) :: path
      character(:), allocatable, intent(inout) :: why
      integer(c_int) :: descriptor, status

      descriptor = c_open(path//c_null_char, 0_c_int)
      if (descriptor < 0) return
      if (c_fsync(descriptor) /= 0) why = 'the disk does not take it'
      status = c_close(descriptor)
   end subroutine put_on_disk

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
