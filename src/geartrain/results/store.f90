!> HDF5 without its rough edges: a file is put together in memory and handed over as bytes, so that the disk only ever sees
!> whole files and its failures are those of plain writing. Silent; the first failure is kept and told at the end.
module geartrain_results_store
   use, intrinsic :: iso_c_binding, only: c_bool, c_char, c_int, c_int64_t, c_loc, c_null_char, c_null_ptr, c_ptr
   use, intrinsic :: iso_fortran_env, only: int8
   use hdf5, only: h5aclose_f, h5acreate_f, h5awrite_f, h5dclose_f, h5dcreate_f, h5dopen_f, h5dwrite_f, &
      h5eset_auto_f, h5fclose_f, h5fcreate_f, h5fflush_f, h5fget_file_image_f, h5gclose_f, h5gcreate_f, h5iis_valid_f, &
      h5lexists_f, h5oclose_f, h5oopen_f, h5open_f, h5pclose_f, h5pcreate_f, h5pset_buffer_f, h5pset_fapl_core_f, h5sclose_f, &
      h5screate_f, h5screate_simple_f, h5tclose_f, h5tcopy_f, h5tset_cset_f, h5tset_size_f, &
      h5f_acc_trunc_f, h5f_scope_global_f, h5p_dataset_create_f, h5p_dataset_xfer_f, h5p_file_access_f, h5s_scalar_f, &
      h5t_c_s1, h5t_cset_utf8_f, h5t_native_double, h5t_native_integer, h5t_std_i8le, hid_t, hsize_t, size_t
   use geartrain_base_error, only: error_type, fatal, status_file
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: store_type

   !> H5T_VARIABLE of the C library, which its Fortran module does not name.
   integer(size_t), parameter :: variable_length = -1_size_t

   !> Bytes that text goes through on its way into the file: HDF5's own megabyte, cleared anew for each dataset, takes longer to
   !> clear than a usual curve to write.
   integer(hsize_t), parameter :: buffer = 16384

   !> A file in the making. Paths are absolute ('/response/rms'); the dimensions of a dataset are named in the order in which
   !> the file has them, the last one varying fastest (Fortran's order reversed), by axes of its group or of the one above.
   !> One at a time: HDF5 knows no threads.
   type :: store_type
      private
      integer(hid_t) :: file = -1, transfer = -1
      !> What all datasets and attributes share: how a dataset is made, the type of text, the space of a scalar.
      integer(hid_t) :: creation = -1, text = -1, scalar = -1
      character(:), allocatable :: failure
   contains
      procedure :: open => open_store
      procedure :: group
      generic :: attribute => text_attribute, integer_attribute, real_attribute
      generic :: axis => index_axis, real_axis, text_axis
      generic :: put => put_text, put_logical, put_integer, put_integer_2, put_real_1, put_real_2, put_real_3
      procedure :: put_bytes
      procedure :: close => close_store
      procedure, private :: text_attribute, integer_attribute, real_attribute
      procedure, private :: opens, number_attribute, describe, write_attribute
      procedure, private :: index_axis, real_axis, text_axis, make_axis
      procedure, private :: put_text, put_logical, put_integer, put_integer_2, put_real_1, put_real_2, put_real_3, put_any
      procedure, private :: attach_axes
      procedure, private :: note
   end type store_type

   !> Of HDF5's C library: dimension scales (the Fortran module for them has no fixed place among the systems), and whether a
   !> dataset holds the time at which it was made (not in the Fortran module of every version).
   interface
      integer(c_int) function h5ds_set_scale(dataset, name) bind(c, name='H5DSset_scale')
         import :: c_char, c_int, c_int64_t
         implicit none (type, external)
         integer(c_int64_t), value :: dataset
         character(kind=c_char), intent(in) :: name(*)
      end function h5ds_set_scale

      integer(c_int) function h5ds_attach_scale(dataset, scale, dimension) bind(c, name='H5DSattach_scale')
         import :: c_int, c_int64_t
         implicit none (type, external)
         integer(c_int64_t), value :: dataset, scale
         integer(c_int), value :: dimension
      end function h5ds_attach_scale

      integer(c_int) function h5pset_obj_track_times(list, track) bind(c, name='H5Pset_obj_track_times')
         import :: c_bool, c_int, c_int64_t
         implicit none (type, external)
         integer(c_int64_t), value :: list
         logical(c_bool), value :: track
      end function h5pset_obj_track_times
   end interface

contains

   !> Begins an empty file in memory; the library is opened where nobody has, and its own printing turned off.
   subroutine open_store(self)
      class(store_type), intent(inout) :: self
      integer(hid_t) :: access
      integer :: status
      logical :: ready

      call h5iis_valid_f(h5t_native_integer, ready, status)
      if (.not. ready .or. status < 0) call h5open_f(status)
      call self%note(status, 'open the library')
      call h5eset_auto_f(0, status)
      call h5pcreate_f(h5p_file_access_f, access, status)
      call h5pset_fapl_core_f(access, 1048576_size_t, .false., status)
      call h5fcreate_f('geartrain results, in memory', h5f_acc_trunc_f, self%file, status, access_prp=access)
      call self%note(status, 'begin a file in memory')
      call h5pclose_f(access, status)
      call h5pcreate_f(h5p_dataset_xfer_f, self%transfer, status)
      call h5pset_buffer_f(self%transfer, buffer, status)
      ! Without the time: the same results are the same bytes.
      call h5pcreate_f(h5p_dataset_create_f, self%creation, status)
      status = h5pset_obj_track_times(int(self%creation, c_int64_t), .false._c_bool)
      ! UTF-8 of any length.
      call h5tcopy_f(h5t_c_s1, self%text, status)
      call h5tset_size_f(self%text, variable_length, status)
      call h5tset_cset_f(self%text, h5t_cset_utf8_f, status)
      call h5screate_f(h5s_scalar_f, self%scalar, status)
   end subroutine open_store

   subroutine group(self, path)
      class(store_type), intent(inout) :: self
      character(*), intent(in) :: path
      integer(hid_t) :: id
      integer :: status

      if (allocated(self%failure)) return
      call h5gcreate_f(self%file, path, id, status)
      call self%note(status, 'create '//path)
      if (status >= 0) call h5gclose_f(id, status)
   end subroutine group

   !> Hands the file over as bytes and frees everything.
   subroutine close_store(self, content, error)
      class(store_type), intent(inout) :: self
      integer(int8), allocatable, target, intent(out) :: content(:)
      type(error_type), allocatable, intent(inout) :: error
      integer(size_t) :: bytes
      type(c_ptr) :: address
      integer :: status

      bytes = 0
      if (.not. allocated(self%failure)) then
         call h5fflush_f(self%file, h5f_scope_global_f, status)
         call self%note(status, 'flush the file in memory')
         address = c_null_ptr
         call h5fget_file_image_f(self%file, address, 0_size_t, status, bytes)
         call self%note(status, 'measure the file in memory')
      end if
      allocate (content(bytes))
      if (.not. allocated(self%failure)) then
         address = c_loc(content)
         call h5fget_file_image_f(self%file, address, bytes, status)
         call self%note(status, 'copy the file in memory')
      end if
      call h5pclose_f(self%transfer, status)
      call h5pclose_f(self%creation, status)
      call h5tclose_f(self%text, status)
      call h5sclose_f(self%scalar, status)
      call h5fclose_f(self%file, status)
      self%file = -1
      if (allocated(self%failure)) call fatal(error, self%failure, status_file)
   end subroutine close_store

   subroutine text_attribute(self, path, name, value)
      class(store_type), intent(inout) :: self
      character(*), intent(in) :: path, name, value
      integer(hid_t) :: object
      integer :: status

      if (.not. self%opens(path, object)) return
      call self%describe(object, path, name, value)
      call h5oclose_f(object, status)
   end subroutine text_attribute

   !> Opens the group or dataset at `path`; false where that or something before it failed.
   logical function opens(self, path, object)
      class(store_type), intent(inout) :: self
      character(*), intent(in) :: path
      integer(hid_t), intent(out) :: object
      integer :: status

      opens = .not. allocated(self%failure)
      if (.not. opens) return
      call h5oopen_f(self%file, path, object, status)
      call self%note(status, 'open '//path)
      opens = status >= 0
   end function opens

   !> A text attribute of an open group or dataset.
   subroutine describe(self, object, path, name, value)
      class(store_type), intent(inout) :: self
      integer(hid_t), intent(in) :: object
      character(*), intent(in) :: path, name, value
      character(kind=c_char), allocatable, target :: text(:, :)
      type(c_ptr), target :: address(1)

      if (allocated(self%failure)) return
      call terminate([value], text)
      address(1) = c_loc(text)
      call self%write_attribute(object, path, name, self%text, c_loc(address))
   end subroutine describe

   subroutine integer_attribute(self, path, name, value)
      class(store_type), intent(inout) :: self
      character(*), intent(in) :: path, name
      integer, intent(in), target :: value

      call self%number_attribute(path, name, h5t_native_integer, c_loc(value))
   end subroutine integer_attribute

   subroutine real_attribute(self, path, name, value)
      class(store_type), intent(inout) :: self
      character(*), intent(in) :: path, name
      real(dp), intent(in), target :: value

      call self%number_attribute(path, name, h5t_native_double, c_loc(value))
   end subroutine real_attribute

   subroutine number_attribute(self, path, name, kind, address)
      class(store_type), intent(inout) :: self
      character(*), intent(in) :: path, name
      integer(hid_t), intent(in) :: kind
      type(c_ptr), intent(in) :: address
      integer(hid_t) :: object
      integer :: status

      if (.not. self%opens(path, object)) return
      call self%write_attribute(object, path, name, kind, address)
      call h5oclose_f(object, status)
   end subroutine number_attribute

   !> A scalar attribute of an open group or dataset.
   subroutine write_attribute(self, object, path, name, kind, address)
      class(store_type), intent(inout) :: self
      integer(hid_t), intent(in) :: object, kind
      character(*), intent(in) :: path, name
      type(c_ptr), intent(in) :: address
      integer(hid_t) :: id
      integer :: status

      call h5acreate_f(object, name, kind, self%scalar, id, status)
      call self%note(status, 'create the attribute '//name//' of '//path)
      if (status >= 0) then
         call h5awrite_f(id, kind, address, status)
         call self%note(status, 'write the attribute '//name//' of '//path)
         call h5aclose_f(id, status)
      end if
   end subroutine write_attribute

   !> A dimension whose places are numbered from 1.
   subroutine index_axis(self, path, length, description)
      class(store_type), intent(inout) :: self
      character(*), intent(in) :: path, description
      integer, intent(in) :: length
      integer :: i

      call self%put(path, [(i, i=1, length)], [character(1) ::], '1', description)
      call self%make_axis(path)
   end subroutine index_axis

   !> A dimension whose places have values.
   subroutine real_axis(self, path, values, units, description)
      class(store_type), intent(inout) :: self
      character(*), intent(in) :: path, units, description
      real(dp), intent(in), contiguous, target :: values(:)

      call self%put(path, values, [character(1) ::], units, description)
      call self%make_axis(path)
   end subroutine real_axis

   !> A dimension whose places have names.
   subroutine text_axis(self, path, labels, description)
      class(store_type), intent(inout) :: self
      character(*), intent(in) :: path, labels(:), description

      call self%put(path, labels, [character(1) ::], '', description)
      call self%make_axis(path)
   end subroutine text_axis

   subroutine make_axis(self, path)
      class(store_type), intent(inout) :: self
      character(*), intent(in) :: path
      integer(hid_t) :: id
      integer :: status

      if (allocated(self%failure)) return
      call h5dopen_f(self%file, path, id, status)
      if (status >= 0) status = h5ds_set_scale(int(id, c_int64_t), path(index(path, '/', back=.true.) + 1:)//c_null_char)
      call self%note(status, 'make an axis of '//path)
      call h5dclose_f(id, status)
   end subroutine make_axis

   subroutine put_text(self, path, values, dimensions, units, description)
      class(store_type), intent(inout) :: self
      character(*), intent(in) :: path, values(:), dimensions(:), units, description
      character(kind=c_char), allocatable, target :: text(:, :)
      type(c_ptr), allocatable, target :: address(:)
      integer :: i

      if (allocated(self%failure)) return
      call terminate(values, text)
      allocate (address(size(values)))
      do i = 1, size(values)
         address(i) = c_loc(text(1, i))
      end do
      call self%put_any(path, self%text, shape(values), dimensions, units, description, c_loc(address))
   end subroutine put_text

   !> 0 and 1, marked so that xarray makes booleans of them.
   subroutine put_logical(self, path, values, dimensions, description)
      class(store_type), intent(inout) :: self
      character(*), intent(in) :: path, dimensions(:), description
      logical, intent(in) :: values(:)
      integer(int8), allocatable, target :: bytes(:)

      bytes = merge(1_int8, 0_int8, values)
      call self%put_any(path, h5t_std_i8le, shape(values), dimensions, '1', description, c_loc(bytes), dtype='bool')
   end subroutine put_logical

   !> Without axes: of use to this program alone.
   subroutine put_bytes(self, path, values, description)
      class(store_type), intent(inout) :: self
      character(*), intent(in) :: path, description
      integer(int8), intent(in), contiguous, target :: values(:)

      call self%put_any(path, h5t_std_i8le, shape(values), [character(1) ::], '', description, c_loc(values))
   end subroutine put_bytes

   subroutine put_integer(self, path, values, dimensions, units, description)
      class(store_type), intent(inout) :: self
      character(*), intent(in) :: path, dimensions(:), units, description
      integer, intent(in), contiguous, target :: values(:)

      call self%put_any(path, h5t_native_integer, shape(values), dimensions, units, description, c_loc(values))
   end subroutine put_integer

   subroutine put_integer_2(self, path, values, dimensions, units, description)
      class(store_type), intent(inout) :: self
      character(*), intent(in) :: path, dimensions(:), units, description
      integer, intent(in), contiguous, target :: values(:, :)

      call self%put_any(path, h5t_native_integer, shape(values), dimensions, units, description, c_loc(values))
   end subroutine put_integer_2

   subroutine put_real_1(self, path, values, dimensions, units, description)
      class(store_type), intent(inout) :: self
      character(*), intent(in) :: path, dimensions(:), units, description
      real(dp), intent(in), contiguous, target :: values(:)

      call self%put_any(path, h5t_native_double, shape(values), dimensions, units, description, c_loc(values))
   end subroutine put_real_1

   subroutine put_real_2(self, path, values, dimensions, units, description)
      class(store_type), intent(inout) :: self
      character(*), intent(in) :: path, dimensions(:), units, description
      real(dp), intent(in), contiguous, target :: values(:, :)

      call self%put_any(path, h5t_native_double, shape(values), dimensions, units, description, c_loc(values))
   end subroutine put_real_2

   subroutine put_real_3(self, path, values, dimensions, units, description)
      class(store_type), intent(inout) :: self
      character(*), intent(in) :: path, dimensions(:), units, description
      real(dp), intent(in), contiguous, target :: values(:, :, :)

      call self%put_any(path, h5t_native_double, shape(values), dimensions, units, description, c_loc(values))
   end subroutine put_real_3

   !> A dataset from memory at `address`.
   subroutine put_any(self, path, kind, extents, dimensions, units, description, address, dtype)
      class(store_type), intent(inout) :: self
      character(*), intent(in) :: path, dimensions(:), units, description
      integer(hid_t), intent(in) :: kind
      integer, intent(in) :: extents(:)
      type(c_ptr), intent(in) :: address
      !> The type that xarray makes of it.
      character(*), intent(in), optional :: dtype
      integer(hid_t) :: space, id
      integer :: status

      if (allocated(self%failure)) return
      call h5screate_simple_f(size(extents), int(extents, hsize_t), space, status)
      call h5dcreate_f(self%file, path, kind, space, id, status, dcpl_id=self%creation)
      call self%note(status, 'create '//path)
      if (status >= 0) then
         if (product(extents) > 0) call h5dwrite_f(id, kind, address, status, xfer_prp=self%transfer)
         call self%note(status, 'write '//path)
         call self%attach_axes(id, path, dimensions)
         call self%describe(id, path, 'units', units)
         call self%describe(id, path, 'description', description)
         if (present(dtype)) call self%describe(id, path, 'dtype', dtype)
         call h5dclose_f(id, status)
      end if
      call h5sclose_f(space, status)
   end subroutine put_any

   subroutine attach_axes(self, dataset, path, dimensions)
      class(store_type), intent(inout) :: self
      integer(hid_t), intent(in) :: dataset
      character(*), intent(in) :: path, dimensions(:)
      character(:), allocatable :: folder
      integer(hid_t) :: axis
      integer :: k, status
      logical :: exists

      do k = 1, size(dimensions)
         folder = path(:index(path, '/', back=.true.))
         call h5lexists_f(self%file, folder//trim(dimensions(k)), exists, status)
         if (.not. exists) folder = folder(:index(folder(:len(folder) - 1), '/', back=.true.))
         call h5dopen_f(self%file, folder//trim(dimensions(k)), axis, status)
         call self%note(status, 'find the axis '//trim(dimensions(k))//' of '//path)
         if (status < 0) return
         status = h5ds_attach_scale(int(dataset, c_int64_t), int(axis, c_int64_t), int(k - 1, c_int))
         call self%note(status, 'attach the axis '//trim(dimensions(k))//' to '//path)
         call h5dclose_f(axis, status)
      end do
   end subroutine attach_axes

   !> Keeps the first failure.
   subroutine note(self, status, action)
      class(store_type), intent(inout) :: self
      integer, intent(in) :: status
      character(*), intent(in) :: action

      if (status < 0 .and. .not. allocated(self%failure)) self%failure = 'HDF5 cannot '//action
   end subroutine note

   !> As C has text: without the blanks at the end, closed by a null; one a column.
   pure subroutine terminate(values, text)
      character(*), intent(in) :: values(:)
      character(kind=c_char), allocatable, intent(out) :: text(:, :)
      integer :: i, k

      allocate (text(len(values) + 1, size(values)), source=c_null_char)
      do i = 1, size(values)
         do k = 1, len_trim(values(i))
            text(k, i) = values(i) (k:k)
         end do
      end do
   end subroutine terminate

end module geartrain_results_store
