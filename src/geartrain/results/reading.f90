!> Reads from a checkpoint what another run goes on from; all else in a results file is for other programs to read.
module geartrain_results_reading
   use, intrinsic :: iso_c_binding, only: c_loc, c_ptr
   use, intrinsic :: iso_fortran_env, only: int8, int64
   use geartrain_base_regular_file, only: is_regular_file
   use hdf5, only: h5dclose_f, h5dget_space_f, h5dopen_f, h5dread_f, h5eset_auto_f, h5f_acc_rdonly_f, h5fclose_f, h5fopen_f, &
      h5iis_valid_f, h5open_f, h5p_file_access_f, h5pclose_f, h5pcreate_f, h5pset_fapl_core_f, h5pset_file_image_f, h5sclose_f, &
      h5sget_simple_extent_npoints_f, h5t_native_integer, h5t_std_i8le, hid_t, hsize_t, size_t
   use geartrain_results_seal, only: is_whole, seal_bytes
   implicit none (type, external)
   private
   public :: read_state, state_path

   character(*), parameter :: state_path = '/state'

contains

   !> The bytes of the state in the file; not allocated where it cannot be read or is not, bit by bit, what was written.
   subroutine read_state(path, bytes)
      character(*), intent(in) :: path
      integer(int8), allocatable, target, intent(out) :: bytes(:)
      integer(int8), allocatable, target :: content(:)
      integer(hid_t) :: access, file, dataset, space
      integer(hsize_t) :: n
      integer :: status, ignored
      type(c_ptr) :: address
      logical :: ready

      call load(path, content)
      if (.not. allocated(content)) return
      if (.not. is_whole(content)) return
      !$omp critical (geartrain_hdf5)
      call h5iis_valid_f(h5t_native_integer, ready, status)
      if (.not. ready .or. status < 0) call h5open_f(status)
      call h5eset_auto_f(0, status)
      ! From memory: what is read is what was checked.
      call h5pcreate_f(h5p_file_access_f, access, status)
      call h5pset_fapl_core_f(access, 1048576_size_t, .false., status)
      address = c_loc(content)
      call h5pset_file_image_f(access, address, size(content, kind=size_t) - seal_bytes, status)
      if (status >= 0) call h5fopen_f('geartrain checkpoint, in memory', h5f_acc_rdonly_f, file, status, access_prp=access)
      if (status >= 0) then
         call h5dopen_f(file, state_path, dataset, status)
         if (status >= 0) then
            call h5dget_space_f(dataset, space, status)
            call h5sget_simple_extent_npoints_f(space, n, status)
            allocate (bytes(n))
            address = c_loc(bytes)
            call h5dread_f(dataset, h5t_std_i8le, address, status)
            if (status < 0) deallocate (bytes)
            call h5sclose_f(space, ignored)
            call h5dclose_f(dataset, ignored)
         end if
         call h5fclose_f(file, ignored)
      end if
      call h5pclose_f(access, ignored)
      !$omp end critical (geartrain_hdf5)
   end subroutine read_state

   !> All bytes of a file; not allocated where they cannot be read.
   subroutine load(path, content)
      character(*), intent(in) :: path
      integer(int8), allocatable, intent(out) :: content(:)
      integer(int64) :: bytes
      integer :: unit, status

      if (.not. is_regular_file(path)) return
      open (newunit=unit, file=path, access='stream', form='unformatted', status='old', action='read', iostat=status)
      if (status /= 0) return
      inquire (unit=unit, size=bytes)
      allocate (content(max(0_int64, bytes)), stat=status)
      if (status == 0) read (unit, iostat=status) content
      if (status /= 0 .and. allocated(content)) deallocate (content)
      close (unit, iostat=status)
   end subroutine load

end module geartrain_results_reading
