!> Reads from a checkpoint what another run goes on from; all else in a results file is for other programs to read.
module geartrain_results_reading
   use, intrinsic :: iso_c_binding, only: c_loc, c_ptr
   use, intrinsic :: iso_fortran_env, only: int8
   use hdf5, only: h5dclose_f, h5dget_space_f, h5dopen_f, h5dread_f, h5eset_auto_f, h5f_acc_rdonly_f, h5fclose_f, h5fopen_f, &
      h5iis_valid_f, h5open_f, h5sclose_f, h5sget_simple_extent_npoints_f, h5t_native_integer, h5t_std_i8le, hid_t, hsize_t
   implicit none (type, external)
   private
   public :: read_state, state_path

   character(*), parameter :: state_path = '/state'

contains

   !> The bytes of the state in the file; not allocated where it cannot be read.
   subroutine read_state(path, bytes)
      character(*), intent(in) :: path
      integer(int8), allocatable, target, intent(out) :: bytes(:)
      integer(hid_t) :: file, dataset, space
      integer(hsize_t) :: n
      integer :: status, ignored
      type(c_ptr) :: address
      logical :: ready

      !$omp critical (geartrain_hdf5)
      call h5iis_valid_f(h5t_native_integer, ready, status)
      if (.not. ready .or. status < 0) call h5open_f(status)
      call h5eset_auto_f(0, status)
      call h5fopen_f(path, h5f_acc_rdonly_f, file, status)
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
      !$omp end critical (geartrain_hdf5)
   end subroutine read_state

end module geartrain_results_reading
