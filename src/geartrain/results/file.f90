!> Replaces files: a reader always sees the whole old file or the whole new file. Reads the bytes of a file.
module geartrain_results_file
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char, c_size_t
   use, intrinsic :: iso_fortran_env, only: int8, int64
   use geartrain_base_error, only: error_type, fatal, status_file, status_memory
   use geartrain_base_numbers, only: text
   use geartrain_base_regular_file, only: is_regular_file
   implicit none (type, external)
   private
   public :: check_place, exists, read_bytes, remove_file, remove_temporary_files, replace_file

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

      !> Target of a link; -1 where the path is no link (ssize_t is as wide as size_t).
      integer(c_size_t) function c_readlink(path, buffer, bytes) bind(c, name='readlink')
         import :: c_char, c_size_t
         implicit none (type, external)
         character(kind=c_char), intent(in) :: path(*)
         character(kind=c_char), intent(inout) :: buffer(*)
         integer(c_size_t), value :: bytes
      end function c_readlink

      !> Opens a file; without the third argument, the mode, which only a new file needs.
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

      !> In temporary_files.c, like the next: locks a temporary file; -1 where another process removes it.
      integer(c_int) function c_lock_temporary(path) bind(c, name='geartrain_lock_temporary')
         import :: c_char, c_int
         implicit none (type, external)
         character(kind=c_char), intent(in) :: path(*)
      end function c_lock_temporary

      subroutine c_remove_left(path) bind(c, name='geartrain_remove_left')
         import :: c_char
         implicit none (type, external)
         character(kind=c_char), intent(in) :: path(*)
      end subroutine c_remove_left
   end interface

contains

   !> Writes a temporary file beside the file and renames it; on failure only the old file is left. Where two runs write a file at
   !> once, each has its own temporary file, and the file of the later run stays. A link is replaced, its target is not changed.
   !> Temporary files of killed writers are removed.
   subroutine replace_file(path, content, error)
      !> Path of the file.
      character(*), intent(in) :: path
      !> All bytes of the new file.
      integer(int8), intent(in) :: content(:)
      type(error_type), allocatable, intent(inout) :: error
      character(:), allocatable :: why
      integer, parameter :: most_attempts = 3
      integer :: attempt
      logical :: vanished

      call check_kind(path, error)
      if (allocated(error)) return
      do attempt = 1, most_attempts
         call write_and_rename(path, content, why, vanished, error)
         if (allocated(error)) return
         if (.not. vanished) exit
      end do
      call remove_temporary_files(path)
      if (allocated(why)) call fatal(error, path//': error: cannot be written: '//why, status_file)
   end subroutine replace_file

   subroutine write_and_rename(path, content, why, vanished, error)
      character(*), intent(in) :: path
      integer(int8), intent(in) :: content(:)
      !> Why the file is not written; not allocated: it is.
      character(:), allocatable, intent(out) :: why
      !> Another process removed the temporary file.
      logical, intent(out) :: vanished
      type(error_type), allocatable, intent(inout) :: error
      character(:), allocatable :: temporary
      integer(int64) :: bytes
      integer(c_int) :: lock
      integer :: unit

      vanished = .false.
      call open_temporary(path, temporary, unit, lock, error)
      if (allocated(error)) return
      call fill(unit, content, why)
      inquire (file=temporary, size=bytes)
      if (.not. allocated(why) .and. bytes /= size(content, kind=int64)) why = 'not all bytes were taken; is the disk full?'
      if (.not. allocated(why)) call put_on_disk(temporary, why)
      if (allocated(why)) call remove_file(temporary)
      ! The lock stays with the file that is renamed, and HDF5 opens no file that another process has locked.
      lock = c_close(lock)
      if (allocated(why)) return
      if (c_rename(temporary//c_null_char, path//c_null_char) == 0) return
      why = temporary//' cannot be renamed'
      vanished = .not. exists(temporary)
      call remove_file(temporary)
   end subroutine write_and_rename

   !> Fails where `replace_file` would fail; to be called before hours of computing.
   subroutine check_place(path, error)
      !> Path of the file.
      character(*), intent(in) :: path
      type(error_type), allocatable, intent(inout) :: error
      character(:), allocatable :: temporary
      integer(c_int) :: lock
      integer :: unit

      call check_kind(path, error)
      if (allocated(error)) return
      call open_temporary(path, temporary, unit, lock, error)
      if (allocated(error)) return
      close (unit, status='delete')
      lock = c_close(lock)
   end subroutine check_place

   !> Removes the temporary files of a path that killed writers have left; files that are being written stay.
   subroutine remove_temporary_files(path)
      !> Path of the file that the temporary files were to become.
      character(*), intent(in) :: path

      call c_remove_left(path//c_null_char)
   end subroutine remove_temporary_files

   !> Removes a file, if there is one.
   subroutine remove_file(path)
      !> Path of the file.
      character(*), intent(in) :: path
      integer(c_int) :: status

      if (exists(path)) status = c_remove(path//c_null_char)
   end subroutine remove_file

   !> Bytes of a file.
   subroutine read_bytes(path, content, last, error)
      !> Path of the file.
      character(*), intent(in) :: path
      !> The bytes; not allocated where the file is no regular file, cannot be read, or has fewer than `last` bytes.
      integer(int8), allocatable, intent(out) :: content(:)
      !> Number of bytes at the end of the file that are read; absent: all bytes.
      integer, intent(in), optional :: last
      !> That there is no memory for the bytes.
      type(error_type), allocatable, intent(inout), optional :: error
      integer(int64) :: bytes, wanted
      integer :: unit, status

      if (.not. is_regular_file(path)) return
      open (newunit=unit, file=path, access='stream', form='unformatted', status='old', action='read', iostat=status)
      if (status /= 0) return
      inquire (unit=unit, size=bytes)
      wanted = bytes
      if (present(last)) wanted = last
      if (wanted > 0 .and. wanted <= bytes) then
         allocate (content(wanted), stat=status)
         if (status /= 0 .and. present(error)) &
            call fatal(error, 'there is no memory for its '//text(wanted)//' bytes', status_memory)
         if (status == 0) read (unit, pos=bytes - wanted + 1, iostat=status) content
         if (status /= 0 .and. allocated(content)) deallocate (content)
      end if
      close (unit, iostat=status)
   end subroutine read_bytes

   !> Whether there is a file, a folder or a link, even a link without target.
   logical function exists(path)
      !> Any path.
      character(*), intent(in) :: path
      character(kind=c_char) :: buffer(1)

      inquire (file=path, exist=exists)
      if (.not. exists) exists = c_readlink(path//c_null_char, buffer, 1_c_size_t) >= 0
   end function exists

   !> Fails where a file may not replace what is at the path.
   subroutine check_kind(path, error)
      character(*), intent(in) :: path
      type(error_type), allocatable, intent(inout) :: error
      character(:), allocatable :: folder
      character(8) :: writable
      logical :: there

      inquire (file=path//'/.', exist=there)
      if (there) then
         call fatal(error, path//': error: cannot be written: it is a folder; give the name of a file', status_file)
         return
      end if
      folder = path(:index(path, '/', back=.true.))
      inquire (file=folder//'.', exist=there)
      if (.not. there) then
         call fatal(error, path//': error: cannot be written: there is no folder '//folder, status_file)
         return
      end if
      ! Renaming would replace a write-protected file, and a device.
      inquire (file=path, exist=there, write=writable)
      if (there .and. writable == 'NO') then
         call fatal(error, path//': error: cannot be written: it is write-protected', status_file)
      else if (folder == '/dev/') then
         call fatal(error, path//': error: cannot be written: it is a device', status_file)
      end if
   end subroutine check_kind

   !> Opens a temporary file beside a file, with status 'new', which excludes files of others and targets of links; where the name
   !> is taken, tries another name. The lock shows other processes that the file is being written.
   subroutine open_temporary(path, temporary, unit, lock, error)
      character(*), intent(in) :: path
      !> Path of the temporary file.
      character(:), allocatable, intent(out) :: temporary
      integer, intent(out) :: unit
      !> Descriptor that holds the lock, to be closed before the renaming.
      integer(c_int), intent(out) :: lock
      type(error_type), allocatable, intent(inout) :: error
      integer, parameter :: most_attempts = 100
      character(512) :: message
      integer :: attempt, status

      do attempt = 1, most_attempts
         temporary = path//'.'//random_name(attempt)//'.tmp'
         open (newunit=unit, file=temporary, access='stream', form='unformatted', status='new', action='write', iostat=status, &
               iomsg=message)
         if (status == 0) then
            lock = c_lock_temporary(temporary//c_null_char)
            if (lock >= 0) return
            ! Between creation and lock the file had no owner, and another process took it for a killed writer's.
            close (unit, status='delete', iostat=status)
            message = 'its temporary files are removed by another process'
            cycle
         end if
         if (.not. exists(temporary)) exit
      end do
      call fatal(error, path//': error: cannot be written: '//trim(message), status_file)
   end subroutine open_temporary

   !> Sixteen random hexadecimal digits; made of process number and time where there is no /dev/urandom.
   function random_name(attempt) result(name)
      integer, intent(in) :: attempt
      character(16) :: name
      integer(int64) :: number
      integer :: unit, status

      open (newunit=unit, file='/dev/urandom', access='stream', form='unformatted', status='old', action='read', iostat=status)
      if (status == 0) then
         read (unit, iostat=status) number
         close (unit)
      end if
      if (status /= 0) then
         call system_clock(number)
         number = ieor(shiftl(int(c_getpid(), int64), 40), number + attempt)
      end if
      write (name, '(z16.16)') number
   end function random_name

   !> Waits until the bytes of a file are on the disk: else a power failure after the renaming could leave an empty file.
   subroutine put_on_disk(path, why)
      character(*), intent(in) :: path
      character(:), allocatable, intent(inout) :: why
      integer(c_int) :: descriptor, status

      descriptor = c_open(path//c_null_char, 0_c_int)
      if (descriptor < 0) return
      if (c_fsync(descriptor) /= 0) why = 'the disk does not take it'
      status = c_close(descriptor)
   end subroutine put_on_disk

   !> Writes and closes a file; `why` is allocated on failure.
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
