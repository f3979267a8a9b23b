!> Reads a results file into groups of fields, if the seal of the file fits.
module geartrain_results_hdf5_reader
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_int, c_int64_t, c_loc, c_ptr, c_size_t
   use, intrinsic :: iso_fortran_env, only: int8
   use hdf5, only: h5aclose_f, h5aget_name_f, h5aget_num_attrs_f, h5aget_space_f, h5aget_type_f, h5aopen_by_idx_f, h5aread_f, &
      h5dget_space_f, h5dget_type_f, h5dread_f, h5f_acc_rdonly_f, h5fclose_f, h5fopen_f, h5gget_info_f, h5i_group_f, &
      h5iget_type_f, h5lget_name_by_idx_f, h5oclose_f, h5oopen_f, h5p_file_access_f, h5pclose_f, h5pcreate_f, &
      h5pset_fapl_core_f, h5pset_file_image_f, h5sclose_f, h5sget_simple_extent_dims_f, h5sget_simple_extent_ndims_f, &
      h5tclose_f, h5tget_class_f, h5tget_size_f, h5tis_variable_str_f, h5_index_name_f, h5_iter_inc_f, h5t_float_f, &
      h5t_integer_f, h5t_native_double, h5t_native_integer, h5t_string_f, hid_t, hsize_t, size_t
   use geartrain_base_field, only: field_type, groups_type, kind_integer, kind_logical, kind_real, kind_text, text_type
   use geartrain_base_plain_text, only: escaped_lines
   use geartrain_results_file, only: read_bytes
   use geartrain_results_hdf5_writer, only: begin_hdf5
   use geartrain_results_seal, only: is_whole, seal_bytes
   implicit none (type, external)
   private
   public :: read_groups

   integer, parameter :: most_dimensions = 7

   interface
      integer(c_int) function h5dvlen_reclaim(kind, space, transfer, buffer) bind(c, name='H5Dvlen_reclaim')
         import :: c_int, c_int64_t, c_ptr
         implicit none (type, external)
         integer(c_int64_t), value :: kind, space, transfer
         type(c_ptr), value :: buffer
      end function h5dvlen_reclaim

      integer(c_size_t) function c_strlen(text) bind(c, name='strlen')
         import :: c_ptr, c_size_t
         implicit none (type, external)
         type(c_ptr), value :: text
      end function c_strlen
   end interface

contains

   !> Groups of a file; none where the file cannot be read or its seal does not fit.
   subroutine read_groups(path, groups)
      !> Path of the file.
      character(*), intent(in) :: path
      !> The groups of the file are added, with all fields but without their dimensions, units and descriptions.
      class(groups_type), intent(inout) :: groups
      integer(int8), allocatable, target :: content(:)
      integer(hid_t) :: access, file
      type(c_ptr) :: address
      integer :: status, ignored

      call read_bytes(path, content)
      if (.not. allocated(content)) return
      if (.not. is_whole(content)) return
      !$omp critical (geartrain_hdf5)
      call begin_hdf5(status)
      ! From memory: HDF5 reads the bytes whose seal was checked.
      call h5pcreate_f(h5p_file_access_f, access, status)
      call h5pset_fapl_core_f(access, 1048576_size_t, .false., status)
      address = c_loc(content)
      call h5pset_file_image_f(access, address, size(content, kind=size_t) - seal_bytes, status)
      if (status >= 0) call h5fopen_f('geartrain results, in memory', h5f_acc_rdonly_f, file, status, access_prp=access)
      if (status >= 0) then
         call read_group(file, '/', groups)
         call h5fclose_f(file, ignored)
      end if
      call h5pclose_f(access, ignored)
      !$omp end critical (geartrain_hdf5)
   end subroutine read_groups

   !> Reads the attributes and the datasets of a group, then the groups in it.
   recursive subroutine read_group(file, path, groups)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path
      class(groups_type), intent(inout) :: groups
      integer(hid_t) :: home, object
      integer :: status, storage, links, order, number, kind, i, last
      integer(size_t) :: length
      character(64) :: name
      character(:), allocatable :: inside, within

      call h5oopen_f(file, path, home, status)
      if (status < 0) return
      call groups%add_group(path, '')
      number = groups%count
      call read_attributes(home, groups, number)
      call h5gget_info_f(home, storage, links, order, status)
      if (status < 0) links = 0
      inside = path
      if (path /= '/') inside = path//'/'
      do last = 1, 2
         do i = 0, links - 1
            call h5lget_name_by_idx_f(home, '.', h5_index_name_f, h5_iter_inc_f, int(i, hsize_t), name, status, length)
            if (status < 0 .or. length > len(name)) cycle
            within = inside//trim(name)
            call h5oopen_f(home, trim(name), object, status)
            if (status < 0) cycle
            call h5iget_type_f(object, kind, status)
            if (kind /= h5i_group_f .and. last == 1) call read_dataset(object, trim(name), groups, number)
            call h5oclose_f(object, status)
            if (kind == h5i_group_f .and. last == 2) call read_group(file, within, groups)
         end do
      end do
      call h5oclose_f(home, status)
   end subroutine read_group

   !> Reads the attributes of an object into group `number`.
   subroutine read_attributes(home, groups, number)
      integer(hid_t), intent(in) :: home
      class(groups_type), intent(inout) :: groups
      integer, intent(in) :: number
      integer(hid_t) :: id, kind, space
      integer :: status, attributes, i
      character(64) :: name

      call h5aget_num_attrs_f(home, attributes, status)
      if (status < 0) return
      do i = 0, attributes - 1
         call h5aopen_by_idx_f(home, '.', h5_index_name_f, h5_iter_inc_f, int(i, hsize_t), id, status)
         if (status < 0) cycle
         call h5aget_name_f(id, int(len(name), size_t), name, status)
         call h5aget_type_f(id, kind, status)
         call h5aget_space_f(id, space, status)
         call read_values(id, .true., kind, space, field_type(name), groups, number)
         call h5sclose_f(space, status)
         call h5tclose_f(kind, status)
         call h5aclose_f(id, status)
      end do
   end subroutine read_attributes

   !> Reads a dataset into group `number`.
   subroutine read_dataset(id, name, groups, number)
      integer(hid_t), intent(in) :: id
      character(*), intent(in) :: name
      class(groups_type), intent(inout) :: groups
      integer, intent(in) :: number
      integer(hid_t) :: kind, space
      integer :: status

      call h5dget_type_f(id, kind, status)
      call h5dget_space_f(id, space, status)
      ! Not blank: a dataset; the true dimensions are in the tables of fields.
      call read_values(id, .false., kind, space, field_type(name, 'of the file'), groups, number)
      call h5sclose_f(space, status)
      call h5tclose_f(kind, status)
   end subroutine read_dataset

   !> Reads numbers or texts as a field of group `number`; values of other types are skipped.
   subroutine read_values(id, attribute, kind, space, about, groups, number)
      integer(hid_t), intent(in) :: id, kind, space
      logical, intent(in) :: attribute
      type(field_type), intent(in) :: about
      class(groups_type), intent(inout), target :: groups
      integer, intent(in) :: number
      integer(hsize_t) :: extents(most_dimensions), most(most_dimensions)
      integer(size_t) :: bytes
      integer :: status, dimensions, sort
      logical :: variable

      call h5sget_simple_extent_ndims_f(space, dimensions, status)
      if (status < 0 .or. dimensions > most_dimensions) return
      if (dimensions > 0) call h5sget_simple_extent_dims_f(space, extents, most, status)
      if (status < 0) return
      call h5tget_class_f(kind, sort, status)
      call h5tget_size_f(kind, bytes, status)
      variable = .false.
      if (sort == h5t_string_f) call h5tis_variable_str_f(kind, variable, status)
      status = 0
      associate (group => groups%groups(number), n => int(extents(:dimensions)))
         if (sort == h5t_float_f) then
            call group%add(about, kind_real, n)
            if (product(n) > 0) call fetch(id, attribute, h5t_native_double, c_loc(group%fields(group%count)%reals), status)
         else if (sort == h5t_integer_f) then
            call group%add(about, merge(kind_logical, kind_integer, bytes == 1), n)
            if (product(n) > 0) call fetch(id, attribute, h5t_native_integer, c_loc(group%fields(group%count)%integers), status)
         else if (variable) then
            call group%add(about, kind_text, n)
            if (product(n) > 0) call fetch_texts(id, attribute, kind, space, group%fields(group%count)%texts, status)
         end if
         ! A field that cannot be read is dropped; results that need the field will not fit.
         if (status < 0) group%count = group%count - 1
      end associate
   end subroutine read_values

   !> Reads the values of an attribute or a dataset, as `kind` in memory.
   subroutine fetch(id, attribute, kind, values, status)
      integer(hid_t), intent(in) :: id, kind
      logical, intent(in) :: attribute
      type(c_ptr), intent(in) :: values
      integer, intent(out) :: status
      type(c_ptr) :: address

      address = values
      if (attribute) call h5aread_f(id, kind, address, status)
      if (.not. attribute) call h5dread_f(id, kind, address, status)
   end subroutine fetch

   !> Reads texts of variable length, which HDF5 allocates.
   subroutine fetch_texts(id, attribute, kind, space, texts, status)
      integer(hid_t), intent(in) :: id, kind, space
      logical, intent(in) :: attribute
      type(text_type), intent(inout) :: texts(:)
      integer, intent(out) :: status
      type(c_ptr), target :: items(size(texts))
      character(kind=c_char), pointer :: bytes(:)
      character(:), allocatable :: text
      integer :: i, k, ignored

      call fetch(id, attribute, kind, c_loc(items), status)
      if (status < 0) return
      do i = 1, size(items)
         texts(i)%text = ''
         if (.not. c_associated(items(i))) cycle
         call c_f_pointer(items(i), bytes, [c_strlen(items(i))])
         deallocate (texts(i)%text)
         allocate (character(size(bytes)) :: text)
         do k = 1, size(bytes)
            text(k:k) = bytes(k)
         end do
         ! Tables, plots and reports show these texts; the title in the file may be older than the rules for titles.
         texts(i)%text = escaped_lines(text)
         deallocate (text)
      end do
      ignored = h5dvlen_reclaim(int(kind, c_int64_t), int(space, c_int64_t), 0_c_int64_t, c_loc(items))
   end subroutine fetch_texts

end module geartrain_results_hdf5_reader
