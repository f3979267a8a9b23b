!> Reads a results file into groups of fields, if the seal of the file fits.
!>
!> A seal that fits does not make the content true: another program can seal what it likes. Every number of the file that decides
!> how much is read is therefore held against the size of the file. An array as geartrain writes it stands in the file in whole,
!> without compression, and has one place there; so all arrays, texts and links together cannot be more than the bytes of the file.
!> This bound ends circles of links as well, which read the same bytes again and again.
module geartrain_results_hdf5_reader
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t, c_loc, c_null_char, c_null_ptr, c_ptr, c_size_t
   use, intrinsic :: iso_fortran_env, only: int8, int64
   use hdf5, only: h5aclose_f, h5aget_name_f, h5aget_num_attrs_f, h5aget_space_f, h5aget_type_f, h5aopen_by_idx_f, &
      h5d_compact_f, h5d_contiguous_f, h5dget_create_plist_f, h5dget_space_f, h5dget_storage_size_f, h5dget_type_f, &
      h5f_acc_rdonly_f, h5fclose_f, h5fopen_f, h5gget_info_f, h5i_dataset_f, h5i_group_f, h5iget_type_f, h5lget_name_by_idx_f, &
      h5oclose_f, h5oopen_f, h5p_file_access_f, h5pclose_f, h5pcreate_f, h5pget_external_count_f, &
      h5pget_layout_f, h5pset_fapl_core_f, h5pset_file_image_f, h5sclose_f, h5sget_simple_extent_dims_f, &
      h5sget_simple_extent_ndims_f, h5sget_simple_extent_npoints_f, h5tclose_f, h5tget_class_f, h5tget_size_f, &
      h5tis_variable_str_f, h5_index_name_f, h5_iter_inc_f, h5t_float_f, h5t_integer_f, h5t_native_double, h5t_native_integer, &
      h5t_string_f, hid_t, hsize_t, size_t
   use geartrain_base_error, only: error_type, fatal, status_file, status_memory
   use geartrain_base_field, only: field_type, groups_type, kind_integer, kind_logical, kind_real, kind_text
   use geartrain_base_memory, only: has_room
   use geartrain_base_numbers, only: text
   use geartrain_results_file, only: read_bytes
   use geartrain_results_hdf5_values, only: fetch, fetch_texts
   use geartrain_results_hdf5_writer, only: begin_hdf5
   use geartrain_results_seal, only: is_whole, seal_bytes
   implicit none (type, external)
   private
   public :: read_groups

   !> Most dimensions of an array; most groups one inside another, the root included, of which a results file has four; most
   !> characters of a name.
   integer, parameter :: most_dimensions = 7, most_depth = 8, most_characters = 64
   !> Least bytes that a link to an object takes in a file, with the header of the object.
   integer(int64), parameter :: link_bytes = 16
   !> Bytes that a text takes in a file beside its characters: its length and its place.
   integer(int64), parameter :: text_bytes = 16

   !> A file that is being read.
   type :: reader_type
      !> The file.
      integer(hid_t) :: file = -1
      !> Bytes of the file; bytes that what is still to be read can have.
      integer(int64) :: bytes = 0, left = 0
      !> The first thing that cannot be as it stands in the file; not allocated: none.
      type(error_type), allocatable :: error
   contains
      procedure, private :: read_group, read_attributes, read_dataset, read_values, spend, refuse
   end type reader_type

   !> HDF5's C library, whose Fortran module lacks this routine for a link of any kind.
   interface
      !> Value of a soft or external link; negative for a hard link, which has none.
      integer(c_int) function h5lget_val(home, name, buffer, bytes, access) bind(c, name='H5Lget_val')
         import :: c_char, c_int, c_int64_t, c_ptr, c_size_t
         implicit none (type, external)
         integer(c_int64_t), value :: home, access
         character(kind=c_char), intent(in) :: name(*)
         type(c_ptr), value :: buffer
         integer(c_size_t), value :: bytes
      end function h5lget_val
   end interface

contains

   !> Groups of a file; none where the file cannot be read or its seal does not fit.
   subroutine read_groups(path, groups, error)
      !> Path of the file.
      character(*), intent(in) :: path
      !> The groups of the file are added, with all fields but without their dimensions, units and descriptions.
      class(groups_type), intent(inout) :: groups
      !> What in a sealed file cannot be, or that there is no memory to read the file.
      type(error_type), allocatable, intent(out) :: error
      type(reader_type) :: reader
      integer(int8), allocatable, target :: content(:)
      integer(hid_t) :: access
      type(c_ptr) :: address
      integer :: status, ignored

      call read_bytes(path, content, error=error)
      if (.not. allocated(content)) return
      if (.not. is_whole(content)) return
      reader%bytes = size(content, kind=int64) - seal_bytes
      reader%left = reader%bytes
      ! HDF5 has a copy of the bytes; its fields, and the results made of them, are as large again at most.
      if (.not. has_room(3*reader%bytes)) then
         call fatal(error, 'there is no memory for what its '//text(reader%bytes)//' bytes hold', status_memory)
         return
      end if
      !$omp critical (geartrain_hdf5)
      call begin_hdf5(status)
      ! From memory: HDF5 reads the bytes whose seal was checked.
      call h5pcreate_f(h5p_file_access_f, access, status)
      call h5pset_fapl_core_f(access, 1048576_size_t, .false., status)
      address = c_loc(content)
      call h5pset_file_image_f(access, address, size(content, kind=size_t) - seal_bytes, status)
      if (status >= 0) call h5fopen_f('geartrain results, in memory', h5f_acc_rdonly_f, reader%file, status, access_prp=access)
      if (status >= 0) then
         call reader%read_group('/', 1, groups)
         call h5fclose_f(reader%file, ignored)
      end if
      call h5pclose_f(access, ignored)
      !$omp end critical (geartrain_hdf5)
      call move_alloc(reader%error, error)
   end subroutine read_groups

   !> Reads the attributes and the datasets of a group, then the groups in it.
   recursive subroutine read_group(self, path, depth, groups)
      class(reader_type), intent(inout) :: self
      character(*), intent(in) :: path
      !> Number of groups from the root to this group.
      integer, intent(in) :: depth
      class(groups_type), intent(inout) :: groups
      integer(hid_t) :: home, object
      integer :: status, storage, links, order, number, kind, i, last
      integer(size_t) :: length
      character(most_characters) :: name
      character(:), allocatable :: inside, within

      if (depth > most_depth) then
         call self%refuse(path, 'is a group in '//text(depth - 1)//' others: must be in '// &
                          text(most_depth - 1)//' at most')
         return
      end if
      call h5oopen_f(self%file, path, home, status)
      if (status < 0) return
      call groups%add_group(path, '')
      number = groups%count
      call self%read_attributes(home, groups, number)
      call h5gget_info_f(home, storage, links, order, status)
      if (status < 0) links = 0
      inside = path
      if (path /= '/') inside = path//'/'
      do last = 1, 2
         do i = 0, links - 1
            if (allocated(self%error)) exit
            call h5lget_name_by_idx_f(home, '.', h5_index_name_f, h5_iter_inc_f, int(i, hsize_t), name, status, length)
            if (status < 0) cycle
            if (length > len(name)) then
               call self%refuse(inside//name//'...', 'is a name of '//text(int(length))//' characters: must have '// &
                                text(len(name))//' at most')
               exit
            end if
            within = inside//trim(name)
            if (last == 1) call self%spend(link_bytes, within, 'is one link more')
            ! Only hard links lead to what is in the file.
            if (h5lget_val(int(home, c_int64_t), trim(name)//c_null_char, c_null_ptr, 0_c_size_t, 0_c_int64_t) >= 0) &
               call self%refuse(within, 'is a link to another place: must be an array or a group')
            if (allocated(self%error)) exit
            call h5oopen_f(home, trim(name), object, status)
            if (status < 0) cycle
            call h5iget_type_f(object, kind, status)
            if (kind == h5i_dataset_f .and. last == 1) call self%read_dataset(object, trim(name), groups, number)
            call h5oclose_f(object, status)
            if (kind == h5i_group_f .and. last == 2) call self%read_group(within, depth + 1, groups)
         end do
      end do
      call h5oclose_f(home, status)
   end subroutine read_group

   !> Reads the attributes of an object into group `number`.
   subroutine read_attributes(self, home, groups, number)
      class(reader_type), intent(inout) :: self
      integer(hid_t), intent(in) :: home
      class(groups_type), intent(inout) :: groups
      integer, intent(in) :: number
      integer(hid_t) :: id, kind, space
      integer :: status, attributes, i
      character(most_characters) :: name

      call h5aget_num_attrs_f(home, attributes, status)
      if (status < 0) return
      do i = 0, attributes - 1
         if (allocated(self%error)) return
         call h5aopen_by_idx_f(home, '.', h5_index_name_f, h5_iter_inc_f, int(i, hsize_t), id, status)
         if (status < 0) cycle
         call h5aget_name_f(id, int(len(name), size_t), name, status)
         call h5aget_type_f(id, kind, status)
         call h5aget_space_f(id, space, status)
         call self%read_values(id, .true., kind, space, field_type(name), groups, number)
         call h5sclose_f(space, status)
         call h5tclose_f(kind, status)
         call h5aclose_f(id, status)
      end do
   end subroutine read_attributes

   !> Reads a dataset into group `number`.
   subroutine read_dataset(self, id, name, groups, number)
      class(reader_type), intent(inout) :: self
      integer(hid_t), intent(in) :: id
      character(*), intent(in) :: name
      class(groups_type), intent(inout) :: groups
      integer, intent(in) :: number
      integer(hid_t) :: kind, space
      integer :: status

      call h5dget_type_f(id, kind, status)
      call h5dget_space_f(id, space, status)
      ! Not blank: a dataset; the true dimensions are in the tables of fields.
      call self%read_values(id, .false., kind, space, field_type(name, 'of the file'), groups, number)
      call h5sclose_f(space, status)
      call h5tclose_f(kind, status)
   end subroutine read_dataset

   !> Reads numbers or texts as a field of group `number`; values of other types are skipped.
   subroutine read_values(self, id, attribute, kind, space, about, groups, number)
      class(reader_type), intent(inout) :: self
      integer(hid_t), intent(in) :: id, kind, space
      logical, intent(in) :: attribute
      type(field_type), intent(in) :: about
      class(groups_type), intent(inout), target :: groups
      integer, intent(in) :: number
      character(:), allocatable :: path
      integer, allocatable :: extents(:)
      integer(size_t) :: bytes
      integer :: status, sort, failed
      logical :: variable

      path = groups%groups(number)%path//'/'//trim(about%name)
      if (groups%groups(number)%path == '/') path = '/'//trim(about%name)
      call h5tget_class_f(kind, sort, status)
      call h5tget_size_f(kind, bytes, status)
      variable = .false.
      if (sort == h5t_string_f) call h5tis_variable_str_f(kind, variable, status)
      if (sort /= h5t_float_f .and. sort /= h5t_integer_f .and. .not. variable) return
      call find_extents(self, id, attribute, space, merge(text_bytes, max(1_int64, int(bytes, int64)), variable), path, extents)
      if (allocated(self%error)) return
      status = 0
      associate (group => groups%groups(number))
         if (variable) then
            call group%add(about, kind_text, extents, failed)
            if (failed == 0 .and. product(extents) > 0) &
               call fetch_texts(id, attribute, kind, space, group%fields(group%count)%texts, self%left, failed, status)
         else if (sort == h5t_float_f) then
            call group%add(about, kind_real, extents, failed)
            if (failed == 0 .and. product(extents) > 0) &
               call fetch(id, attribute, h5t_native_double, c_loc(group%fields(group%count)%reals), status)
         else
            call group%add(about, merge(kind_logical, kind_integer, bytes == 1), extents, failed)
            if (failed == 0 .and. product(extents) > 0) &
               call fetch(id, attribute, h5t_native_integer, c_loc(group%fields(group%count)%integers), status)
         end if
         if (failed /= 0) then
            if (.not. allocated(self%error)) &
               call fatal(self%error, 'there is no memory for '//path//', '//trim(words_of(int(extents, int64))), status_memory)
         else if (self%left < 0) then
            call self%refuse(path, 'has texts of more characters than the file has bytes, '//text(self%bytes))
         else if (status < 0) then
            ! A field that cannot be read is dropped; results that need the field will not fit.
            group%count = group%count - 1
         end if
      end associate
   end subroutine read_values

   !> Extents of an array in the order of memory, which the reader can hold and the file has the bytes for, else the error.
   subroutine find_extents(self, id, attribute, space, each, path, extents)
      class(reader_type), intent(inout) :: self
      integer(hid_t), intent(in) :: id, space
      logical, intent(in) :: attribute
      !> Bytes of a value in the file.
      integer(int64), intent(in) :: each
      character(*), intent(in) :: path
      integer, allocatable, intent(out) :: extents(:)
      integer(hsize_t) :: lengths(most_dimensions), most(most_dimensions), total, stored
      integer(int64) :: values
      integer(hid_t) :: creation
      integer :: status, dimensions, layout, files, i

      extents = [integer ::]
      call h5sget_simple_extent_ndims_f(space, dimensions, status)
      if (status < 0 .or. dimensions > most_dimensions .or. attribute .and. dimensions > 0) then
         call self%refuse(path, 'has '//text(dimensions)//' dimensions: must have '// &
                          text(merge(0, most_dimensions, attribute))//' at most')
         return
      end if
      lengths = 1
      if (dimensions > 0) call h5sget_simple_extent_dims_f(space, lengths, most, status)
      if (status >= 0) call h5sget_simple_extent_npoints_f(space, total, status)
      values = product_of(int(lengths(:dimensions), int64))
      if (values > huge(extents) .or. any(lengths(:dimensions) < 0 .or. lengths(:dimensions) > huge(extents))) then
         call self%refuse(path, 'has '//trim(words_of(int(lengths(:dimensions), int64)))//': must be '//text(huge(extents))// &
                          ' at most')
      else if ((status < 0 .or. total /= values) .and. values > 0) then
         ! As the space of an attribute that has none; of a list of length 0 the library does not tell the number of values.
         call self%refuse(path, 'has no value: must have '//text(values))
      else if (.not. attribute .and. values > 0) then
         call h5dget_create_plist_f(id, creation, status)
         call h5pget_layout_f(creation, layout, status)
         call h5pget_external_count_f(creation, files, status)
         call h5pclose_f(creation, status)
         call h5dget_storage_size_f(id, stored, status)
         if (layout /= h5d_contiguous_f .and. layout /= h5d_compact_f .or. files /= 0) then
            call self%refuse(path, 'is chunked, compressed or in another file: must be in one piece, as geartrain writes it')
         else if (status < 0 .or. stored/each < values) then
            call self%refuse(path, 'has '//trim(words_of(int(lengths(:dimensions), int64)))//' of '//text(each)// &
                             ' bytes each, of which the file has '//text(stored)//' bytes')
         end if
      end if
      if (allocated(self%error)) return
      call self%spend(each*values, path, 'has '//trim(words_of(int(lengths(:dimensions), int64)))//' of '//text(each)// &
                      ' bytes each')
      extents = [(int(lengths(i)), i=1, dimensions)]
   end subroutine find_extents

   !> Counts bytes that the file must have for what is read next.
   subroutine spend(self, bytes, path, what)
      class(reader_type), intent(inout) :: self
      integer(int64), intent(in) :: bytes
      !> Path in the file of what is read; what it has.
      character(*), intent(in) :: path, what

      self%left = self%left - bytes
      if (self%left < 0) call self%refuse(path, what//', and with all before it more than the file has bytes, '// &
                                          text(self%bytes)//': is it linked in a circle?')
   end subroutine spend

   !> Keeps the first error.
   subroutine refuse(self, path, why)
      class(reader_type), intent(inout) :: self
      !> Path in the file of what cannot be; the reason.
      character(*), intent(in) :: path, why

      if (.not. allocated(self%error)) call fatal(self%error, path//' in it '//why, status_file)
   end subroutine refuse

   !> Product of lengths; -1 or more than huge(0) where it is larger than that.
   pure integer(int64) function product_of(lengths) result(values)
      integer(int64), intent(in) :: lengths(:)
      integer :: i

      values = 1
      if (any(lengths == 0)) values = 0
      do i = 1, size(lengths)
         if (values <= huge(0)) values = values*min(lengths(i), int(huge(0), int64) + 1)
      end do
   end function product_of

   !> '3 x 4 values', in the order of the file; to be trimmed.
   pure character(160) function words_of(lengths) result(words)
      !> Lengths of the dimensions in the order of memory.
      integer(int64), intent(in) :: lengths(:)
      integer :: i

      words = '1 value'
      if (size(lengths) == 0) return
      words = text(lengths(size(lengths)))
      do i = size(lengths) - 1, 1, -1
         words = trim(words)//' x '//text(lengths(i))
      end do
      words = trim(words)//' values'
   end function words_of

end module geartrain_results_hdf5_reader
