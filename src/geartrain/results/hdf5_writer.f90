!> Groups of fields as the bytes of an HDF5 file, which is made in memory: the disk only gets whole files, by plain writing. Prints
!> nothing; the first failure is kept and told at the end.
module geartrain_results_hdf5_writer
   use, intrinsic :: iso_c_binding, only: c_bool, c_char, c_int, c_int64_t, c_loc, c_null_char, c_null_ptr, c_ptr
   use, intrinsic :: iso_fortran_env, only: int64, int8
   use hdf5, only: h5aclose_f, h5acreate_f, h5awrite_f, h5dclose_f, h5dcreate_f, h5dopen_f, h5dwrite_f, &
      h5eset_auto_f, h5fclose_f, h5fcreate_f, h5fflush_f, h5fget_file_image_f, h5gclose_f, h5gcreate_f, h5iis_valid_f, &
      h5lexists_f, h5oclose_f, h5oopen_f, h5open_f, h5pclose_f, h5pcreate_f, h5pset_buffer_f, h5pset_fapl_core_f, h5sclose_f, &
      h5screate_f, h5screate_simple_f, h5tclose_f, h5tcopy_f, h5tset_cset_f, h5tset_size_f, &
      h5f_acc_trunc_f, h5f_scope_global_f, h5p_dataset_create_f, h5p_dataset_xfer_f, h5p_file_access_f, h5s_scalar_f, &
      h5t_c_s1, h5t_cset_utf8_f, h5t_native_double, h5t_native_integer, h5t_std_i8le, hid_t, hsize_t, size_t
   use geartrain_base_error, only: error_type, fatal, status_file
   use geartrain_base_field, only: groups_type, kind_integer, kind_logical, kind_real, kind_text, text_type, values_type, word
   use geartrain_base_numbers, only: text
   use geartrain_results_seal, only: seal_bytes
   implicit none (type, external)
   private
   public :: begin_hdf5, hdf5_content

   !> H5T_VARIABLE of the C library, which its Fortran module does not name.
   integer(size_t), parameter :: variable_length = -1_size_t

   !> Bytes of the buffer for text: HDF5's default of a megabyte, cleared for each dataset, takes longer to clear than a usual curve
   !> takes to write.
   integer(hsize_t), parameter :: buffer = 16384

   !> A file that is being made. There may be one at a time: HDF5 knows no threads.
   type :: writer_type
      !> The file; how values are transferred.
      integer(hid_t) :: file = -1, transfer = -1
      !> Shared by all datasets and attributes: how a dataset is made, the type of text, the space of a scalar.
      integer(hid_t) :: creation = -1, text = -1, scalar = -1
      !> The first failure; not allocated: none.
      character(:), allocatable :: failure
   contains
      procedure, private :: open => open_file
      procedure, private :: close => close_file
      procedure, private :: write_group, write_dataset, write_attribute, write_text_attribute, attach_axes, note
   end type writer_type

   !> HDF5's C library: dimension scales (their Fortran module has different places on different systems), and whether a dataset
   !> holds the time of its making (not in the Fortran module of every version).
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

   !> Makes the bytes of a file.
   subroutine hdf5_content(groups, content, error)
      !> Groups of the file, whose values are deallocated one by one. Every dimension of a dataset needs an axis in the group of the
      !> dataset or in the group above.
      class(groups_type), intent(inout) :: groups
      !> All bytes of the file, with room for the seal at the end.
      integer(int8), allocatable, intent(out) :: content(:)
      type(error_type), allocatable, intent(inout) :: error
      type(writer_type) :: writer
      integer :: i

      !$omp critical (geartrain_hdf5)
      call writer%open()
      do i = 1, groups%count
         call writer%write_group(groups, i)
      end do
      call writer%close(content, error)
      !$omp end critical (geartrain_hdf5)
   end subroutine hdf5_content

   !> Opens the HDF5 library, unless it is open, and turns off its printing.
   subroutine begin_hdf5(status)
      !> Negative: failure.
      integer, intent(out) :: status
      integer :: ignored
      logical :: ready

      call h5iis_valid_f(h5t_native_integer, ready, status)
      if (.not. ready .or. status < 0) call h5open_f(status)
      call h5eset_auto_f(0, ignored)
   end subroutine begin_hdf5

   !> Begins an empty file in memory.
   subroutine open_file(self)
      class(writer_type), intent(inout) :: self
      integer(hid_t) :: access
      integer :: status

      call begin_hdf5(status)
      call self%note(status, 'open the library')
      call h5pcreate_f(h5p_file_access_f, access, status)
      call h5pset_fapl_core_f(access, 1048576_size_t, .false., status)
      call h5fcreate_f('geartrain results, in memory', h5f_acc_trunc_f, self%file, status, access_prp=access)
      call self%note(status, 'begin a file in memory')
      call h5pclose_f(access, status)
      call h5pcreate_f(h5p_dataset_xfer_f, self%transfer, status)
      call h5pset_buffer_f(self%transfer, buffer, status)
      ! Without the time of making, so that equal results have equal bytes.
      call h5pcreate_f(h5p_dataset_create_f, self%creation, status)
      status = h5pset_obj_track_times(int(self%creation, c_int64_t), .false._c_bool)
      ! UTF-8 of any length.
      call h5tcopy_f(h5t_c_s1, self%text, status)
      call h5tset_size_f(self%text, variable_length, status)
      call h5tset_cset_f(self%text, h5t_cset_utf8_f, status)
      call h5screate_f(h5s_scalar_f, self%scalar, status)
   end subroutine open_file

   !> Hands the file over as bytes and frees everything.
   subroutine close_file(self, content, error)
      class(writer_type), intent(inout) :: self
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
      allocate (content(bytes + seal_bytes), stat=status)
      if (status /= 0) call self%note(-1, 'copy the file in memory: there is no memory for '//text(int(bytes, int64))//' bytes')
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
      if (allocated(self%failure)) call fatal(error, self%failure, status_file)
   end subroutine close_file

   !> Writes group `number`: its attributes, its axes, then its other datasets.
   subroutine write_group(self, groups, number)
      class(writer_type), intent(inout) :: self
      class(groups_type), intent(inout) :: groups
      integer, intent(in) :: number
      integer(hid_t) :: id
      integer :: i, pass, status

      if (allocated(self%failure)) return
      associate (group => groups%groups(number))
         if (group%path /= '/') then
            call h5gcreate_f(self%file, group%path, id, status)
            call self%note(status, 'create '//group%path)
            if (status < 0) return
            call h5gclose_f(id, status)
         end if
         call h5oopen_f(self%file, group%path, id, status)
         call self%note(status, 'open '//group%path)
         if (status < 0) return
         if (group%description /= '') call self%write_text_attribute(id, group%path, 'description', trim(group%description))
         do i = 1, group%count
            if (group%fields(i)%about%dimensions == '') call self%write_attribute(id, group%path, group%fields(i))
         end do
         call h5oclose_f(id, status)
         do pass = 1, 2
            do i = 1, group%count
               if (group%fields(i)%about%dimensions == '' .or. (group%fields(i)%axis .neqv. pass == 1)) cycle
               call self%write_dataset(group%path, group%fields(i))
            end do
         end do
      end associate
   end subroutine write_group

   !> Writes a scalar attribute of an open group; logical values are written as whole numbers.
   subroutine write_attribute(self, object, path, field)
      class(writer_type), intent(inout) :: self
      integer(hid_t), intent(in) :: object
      character(*), intent(in) :: path
      type(values_type), intent(in), target :: field
      integer(hid_t) :: id, kind
      type(c_ptr) :: address
      integer :: status

      if (allocated(self%failure)) return
      select case (field%kind)
      case (kind_text)
         call self%write_text_attribute(object, path, trim(field%about%name), field%texts(1)%text)
         return
      case (kind_real)
         kind = h5t_native_double
         address = c_loc(field%reals)
      case default
         kind = h5t_native_integer
         address = c_loc(field%integers)
      end select
      call h5acreate_f(object, trim(field%about%name), kind, self%scalar, id, status)
      call self%note(status, 'create the attribute '//trim(field%about%name)//' of '//path)
      if (status < 0) return
      call h5awrite_f(id, kind, address, status)
      call self%note(status, 'write the attribute '//trim(field%about%name)//' of '//path)
      call h5aclose_f(id, status)
   end subroutine write_attribute

   !> Writes a text attribute of an open group or dataset.
   subroutine write_text_attribute(self, object, path, name, value)
      class(writer_type), intent(inout) :: self
      integer(hid_t), intent(in) :: object
      character(*), intent(in) :: path, name, value
      character(kind=c_char, len=:), allocatable, target :: text
      type(c_ptr), target :: address(1)
      type(c_ptr) :: place
      integer(hid_t) :: id
      integer :: status

      if (allocated(self%failure)) return
      text = value//c_null_char
      address(1) = c_loc(text)
      place = c_loc(address)
      call h5acreate_f(object, name, self%text, self%scalar, id, status)
      call self%note(status, 'create the attribute '//name//' of '//path)
      if (status < 0) return
      call h5awrite_f(id, self%text, place, status)
      call self%note(status, 'write the attribute '//name//' of '//path)
      call h5aclose_f(id, status)
   end subroutine write_text_attribute

   !> Writes an array and deallocates its values.
   subroutine write_dataset(self, home, field)
      class(writer_type), intent(inout) :: self
      character(*), intent(in) :: home
      type(values_type), intent(inout), target :: field
      character(:), allocatable :: path
      integer(int8), allocatable, target :: bytes(:)
      character(kind=c_char), allocatable, target :: text(:, :)
      type(c_ptr), allocatable, target :: items(:)
      type(c_ptr) :: address
      integer(hid_t) :: kind, space, id
      integer :: i, status

      if (allocated(self%failure)) return
      path = home//'/'//trim(field%about%name)
      select case (field%kind)
      case (kind_real)
         kind = h5t_native_double
         address = c_loc(field%reals)
      case (kind_integer)
         kind = h5t_native_integer
         address = c_loc(field%integers)
      case (kind_logical)
         kind = h5t_std_i8le
         bytes = int(field%integers, int8)
         address = c_loc(bytes)
      case default
         kind = self%text
         call terminate(field%texts, text)
         allocate (items(size(field%texts)))
         do i = 1, size(items)
            items(i) = c_loc(text(1, i))
         end do
         address = c_loc(items)
      end select
      call h5screate_simple_f(size(field%extents), int(field%extents, hsize_t), space, status)
      call h5dcreate_f(self%file, path, kind, space, id, status, dcpl_id=self%creation)
      call self%note(status, 'create '//path)
      if (status >= 0) then
         if (product(field%extents) > 0) call h5dwrite_f(id, kind, address, status, xfer_prp=self%transfer)
         call self%note(status, 'write '//path)
         if (field%axis) then
            if (h5ds_set_scale(int(id, c_int64_t), trim(field%about%name)//c_null_char) < 0) &
               call self%note(-1, 'make an axis of '//path)
         else
            call self%attach_axes(id, home, field)
         end if
         call self%write_text_attribute(id, path, 'units', trim(field%about%unit))
         call self%write_text_attribute(id, path, 'description', trim(field%about%description))
         ! So that xarray makes booleans of the numbers 0 and 1.
         if (field%kind == kind_logical) call self%write_text_attribute(id, path, 'dtype', 'bool')
         call h5dclose_f(id, status)
      end if
      call h5sclose_f(space, status)
      if (allocated(field%reals)) deallocate (field%reals)
      if (allocated(field%integers)) deallocate (field%integers)
      if (allocated(field%texts)) deallocate (field%texts)
   end subroutine write_dataset

   !> Attaches the axes of a dataset of the group `home`.
   subroutine attach_axes(self, dataset, home, field)
      class(writer_type), intent(inout) :: self
      integer(hid_t), intent(in) :: dataset
      character(*), intent(in) :: home
      type(values_type), intent(in) :: field
      character(:), allocatable :: folder, name
      integer(hid_t) :: axis
      integer :: k, status
      logical :: exists

      do k = 1, size(field%extents)
         name = trim(word(field%about%dimensions, k))
         folder = home//'/'
         call h5lexists_f(self%file, folder//name, exists, status)
         if (.not. exists) folder = folder(:index(folder(:len(folder) - 1), '/', back=.true.))
         call h5dopen_f(self%file, folder//name, axis, status)
         call self%note(status, 'find the axis '//name//' of '//home//'/'//trim(field%about%name))
         if (status < 0) return
         status = h5ds_attach_scale(int(dataset, c_int64_t), int(axis, c_int64_t), int(k - 1, c_int))
         call self%note(status, 'attach the axis '//name//' to '//home//'/'//trim(field%about%name))
         call h5dclose_f(axis, status)
      end do
   end subroutine attach_axes

   !> Keeps the first failure.
   subroutine note(self, status, action)
      class(writer_type), intent(inout) :: self
      integer, intent(in) :: status
      character(*), intent(in) :: action

      if (status < 0 .and. .not. allocated(self%failure)) self%failure = 'HDF5 cannot '//action
   end subroutine note

   !> Texts as C has them, closed by a null character, (length, text).
   pure subroutine terminate(values, text)
      type(text_type), intent(in) :: values(:)
      character(kind=c_char), allocatable, intent(out) :: text(:, :)
      integer :: i, k, longest

      longest = 0
      do i = 1, size(values)
         longest = max(longest, len(values(i)%text))
      end do
      allocate (text(longest + 1, size(values)), source=c_null_char)
      do i = 1, size(values)
         do k = 1, len(values(i)%text)
            text(k, i) = values(i)%text(k:k)
         end do
      end do
   end subroutine terminate

end module geartrain_results_hdf5_writer
