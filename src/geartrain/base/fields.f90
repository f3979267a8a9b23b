!> Results as fields by name, and back. A routine for each type of result (`visit_NAME` in the modules `geartrain_*_fields`) calls
!> `carry` for each component, with the row that describes the field. Writing and reading the results file and the checkpoint, the
!> arrays of Python and the reference page all use these routines.
!>
!> `enter` begins a group of a type. The axes of a group come first and tell the lengths of the dimensions: an array with spare room
!> in the last index is cut, an array that is shorter in the first index is filled with NaN.
module geartrain_base_fields
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_base_field, only: field_type, groups_type, kind_integer, kind_logical, kind_real, kind_text, &
      lengths_type, text_type, word
   use geartrain_base_kinds, only: dp
   use geartrain_base_memory, only: has_room
   implicit none (type, external)
   private
   public :: arranging, fields_type, listing, measuring, reading, writing

   !> What `carry` does. writing: results to fields; reading: fields to results; listing: adds every possible field, without values;
   !> arranging: no fields, each array gets the expected lengths of its dimensions and its last index the order `order`.
   !> measuring: no fields, but the bytes that writing would take for their values, in `bytes`.
   integer, parameter :: writing = 0, reading = 1, listing = 2, arranging = 3, measuring = 4

   !> Bytes of an item of a list, such as a motion with its few arrays; number of items for which there is always memory.
   integer(int64), parameter :: item_bytes = 2048
   integer, parameter :: few_items = 1000

   !> Labels of the places of a dimension.
   type :: labels_type
      character(24) :: name = ''
      type(text_type), allocatable :: labels(:)
   end type labels_type

   type, extends(groups_type) :: fields_type
      !> One of writing, reading, listing, arranging, measuring.
      integer :: way = writing
      !> Path of the first field that does not fit; not allocated while all fields fit.
      character(:), allocatable :: wrong
      !> Whether that field is not there.
      logical :: lacks = .false.
      !> Whether there is no memory for that field.
      logical :: no_room = .false.
      !> Measuring: bytes of the values of all fields so far, but for texts and for values that follow from others.
      integer(int64) :: bytes = 0
      !> Arranging: old index, in the last dimension, of the values that become first, second, ...; further values are not set.
      integer, allocatable :: order(:)
      !> Number of the present group.
      integer :: here = 0
      !> Number of the field in the present group that probably comes next.
      integer, private :: next = 0
      !> Lengths of the dimensions of the present group; expected lengths in all groups.
      type(lengths_type), private :: lengths, expected
      !> The dimensions whose places have labels beside their numbers, see `expect`.
      type(labels_type), private :: labelled(8)
      !> Dimension of the list that is visited item by item; '': no list.
      character(24) :: along = ''
      !> Number of items of the list; number of the present item.
      integer, private :: items = 0, item = 0
   contains
      procedure :: expect
      procedure :: enter
      procedure :: has
      procedure :: derives
      procedure :: describe
      procedure :: index_axis
      procedure :: text_axis
      procedure :: length_of
      procedure :: lengths_of
      procedure :: begin_list
      procedure :: visit_item
      procedure :: end_list
      procedure :: check
      procedure :: room_for
      procedure :: take
      procedure, private :: find, say_length, add_labels
   end type fields_type

contains

   !> Sets the length that a dimension must have in every group, unless it is 0 there.
   subroutine expect(self, name, length, labels)
      class(fields_type), intent(inout) :: self
      !> Name of the dimension.
      character(*), intent(in) :: name
      !> Number of places of the dimension.
      integer, intent(in) :: length
      !> Labels that stand beside the numbers of the places wherever the dimension has an axis, (length); for eight dimensions at
      !> most.
      character(*), intent(in), optional :: labels(:)
      integer :: i, n

      call self%expected%set(name, length)
      call self%lengths%set(name, length)
      if (.not. present(labels)) return
      n = findloc(self%labelled%name == name .or. self%labelled%name == '', .true., 1)
      self%labelled(n)%name = name
      if (allocated(self%labelled(n)%labels)) deallocate (self%labelled(n)%labels)
      allocate (self%labelled(n)%labels(length))
      do i = 1, length
         self%labelled(n)%labels(i)%text = trim(labels(i))
      end do
   end subroutine expect

   !> Enters a group; .false.: there is no group to visit.
   logical function enter(self, path, description, there)
      class(fields_type), intent(inout) :: self
      !> Absolute path in the file; meaning, as the file tells it.
      character(*), intent(in) :: path, description
      !> Whether there are results of the group; not used by reading.
      logical, intent(in) :: there

      self%lengths = self%expected
      self%next = 1
      self%here = 0
      if (self%way == reading) then
         self%here = self%find_group(path)
      else if (self%way == measuring) then
         ! A number that no group needs to have.
         self%here = merge(1, 0, there)
      else if (there .or. self%way == listing) then
         call self%add_group(path, description)
         self%here = self%count
      end if
      enter = self%here > 0 .and. .not. allocated(self%wrong)
   end function enter

   !> Whether to visit a dataset that only some results have.
   logical function has(self, name, there)
      class(fields_type), intent(inout) :: self
      !> Name of the dataset.
      character(*), intent(in) :: name
      !> Whether the results have values of the dataset; not used by reading.
      logical, intent(in) :: there

      has = there .or. self%way == listing
      if (self%way == reading) has = self%groups(self%here)%place(name, .false., self%next) > 0
   end function has

   !> Whether to visit values that follow from other values, and are therefore not read.
   pure logical function derives(self)
      class(fields_type), intent(in) :: self

      derives = self%way == writing .or. self%way == listing .or. self%way == measuring
   end function derives

   !> Writes a text attribute of the group, which is not read.
   subroutine describe(self, name, text)
      class(fields_type), intent(inout) :: self
      !> Name of the attribute; its value.
      character(*), intent(in) :: name, text

      if (self%way /= writing) return
      associate (group => self%groups(self%here))
         call group%add(field_type(name), kind_text, [integer ::])
         group%fields(group%count)%texts(1)%text = text
      end associate
   end subroutine describe

   !> Visits an axis whose places are numbered from 1.
   subroutine index_axis(self, name, length, description)
      class(fields_type), intent(inout) :: self
      !> Name of the dimension; meaning, as the file tells it.
      character(*), intent(in) :: name, description
      !> Number of places; set by reading.
      integer, intent(inout) :: length
      integer :: i, place

      if (self%way == reading) then
         place = self%find(field_type(name, name))
         if (place == 0) return
         length = product(self%groups(self%here)%fields(place)%extents)
         ! Lists get an item for each place before it is known whether the file has the values of the items.
         self%no_room = .not. (length < few_items .or. has_room(item_bytes*length))
         call self%check(.not. self%no_room, name)
         if (self%no_room) length = 0
         call self%say_length(name, length)
         return
      end if
      if (self%way == arranging .and. self%length_of(name) >= 0) return
      call self%say_length(name, length)
      self%bytes = self%bytes + bytes_of(kind_integer)*max(0, length)
      if (self%way == arranging .or. self%way == measuring) return
      associate (group => self%groups(self%here))
         call group%add(field_type(name, name, '1', description), kind_integer, [merge(0, length, self%way == listing)])
         group%fields(group%count)%axis = .true.
         if (self%way == writing) group%fields(group%count)%integers = [(i, i=1, length)]
      end associate
      place = findloc(self%labelled%name, name, 1)
      if (place > 0) call self%add_labels(self%labelled(place), length)
   end subroutine index_axis

   !> Adds the labels of an axis to the group as a coordinate, which is not read.
   subroutine add_labels(self, labelled, length)
      class(fields_type), intent(inout) :: self
      !> The dimension and its labels.
      type(labels_type), intent(in) :: labelled
      !> Number of places; other than expected where the group has nothing yet.
      integer, intent(in) :: length
      character(:), allocatable :: name, meaning
      integer :: place

      if (length /= size(labelled%labels)) return
      name = trim(labelled%name)//'_label'
      associate (group => self%groups(self%here))
         if (labelled%name == 'held') then
            meaning = 'names of the held bodies'
         else if (labelled%name == 'bearing') then
            meaning = 'names of the bodies on bearings'
         else if (labelled%name == 'planet') then
            meaning = 'names of the bodies that are the planets'
         else
            meaning = 'names of the two bodies that the '//trim(labelled%name)//' joins, such as `pinion - wheel`; in a chain `'// &
                      trim(labelled%name)//' 1`, ...'
         end if
         call group%add(field_type(name, labelled%name, '', meaning), kind_text, [length])
         group%fields(group%count)%texts = labelled%labels
         place = group%place('coordinates', .true., 0)
         if (place == 0) then
            call self%describe('coordinates', name)
         else
            group%fields(place)%texts(1)%text = group%fields(place)%texts(1)%text//' '//name
         end if
      end associate
   end subroutine add_labels

   !> Visits an axis whose places have labels, which are not read.
   subroutine text_axis(self, name, labels, description)
      class(fields_type), intent(inout) :: self
      !> Name of the dimension; label of each place; meaning of the axis, as the file tells it.
      character(*), intent(in) :: name, labels(:), description
      integer :: i

      if (.not. self%derives()) return
      call self%say_length(name, size(labels))
      if (self%way == measuring) return
      associate (group => self%groups(self%here))
         call group%add(field_type(name, name, '', description), kind_text, [merge(0, size(labels), self%way == listing)])
         group%fields(group%count)%axis = .true.
         do i = 1, size(group%fields(group%count)%texts)
            group%fields(group%count)%texts(i)%text = trim(labels(i))
         end do
      end associate
   end subroutine text_axis

   !> Sets the length of a dimension of the present group.
   subroutine say_length(self, name, length)
      class(fields_type), intent(inout) :: self
      character(*), intent(in) :: name
      integer, intent(in) :: length

      if (self%expected%of(name) >= 0 .and. length > 0) call self%check(self%expected%of(name) == length, name)
      call self%lengths%set(name, length)
   end subroutine say_length

   !> Length of a dimension of the present group; -1: not known.
   pure integer function length_of(self, name) result(length)
      class(fields_type), intent(in) :: self
      !> Name of the dimension.
      character(*), intent(in) :: name

      length = self%lengths%of(name)
   end function length_of

   !> Lengths of the dimensions of a field in the order of memory, (rank); -1: not known.
   pure function lengths_of(self, about, rank) result(lengths)
      class(fields_type), intent(in) :: self
      !> The row of the table.
      type(field_type), intent(in) :: about
      !> Number of dimensions of the field.
      integer, intent(in) :: rank
      integer :: lengths(rank), k

      lengths = [(self%length_of(word(about%dimensions, rank + 1 - k)), k=1, rank)]
   end function lengths_of

   !> Begins a list: fields are visited for each item (`visit_item`), until `end_list`, with the dimension `along` before their own.
   subroutine begin_list(self, along)
      class(fields_type), intent(inout) :: self
      !> Name of the dimension along the list.
      character(*), intent(in) :: along

      self%along = along
      self%items = max(0, self%length_of(along))
      if (self%way == listing) self%items = 1
   end subroutine begin_list

   !> Begins an item of the list.
   subroutine visit_item(self, item)
      class(fields_type), intent(inout) :: self
      !> Number of the item, from 1.
      integer, intent(in) :: item

      self%item = item
   end subroutine visit_item

   !> Ends the list.
   subroutine end_list(self)
      class(fields_type), intent(inout) :: self

      self%along = ''
   end subroutine end_list

   !> Reading: keeps the path of the first field that does not fit.
   subroutine check(self, fits, name)
      class(fields_type), intent(inout) :: self
      !> Whether the field is as expected.
      logical, intent(in) :: fits
      !> Name of the field.
      character(*), intent(in) :: name

      if (fits .or. self%way /= reading .or. allocated(self%wrong)) return
      self%wrong = trim(name)
      if (self%here > 0) self%wrong = self%groups(self%here)%path//'/'//self%wrong
   end subroutine check

   !> Number of a field in the group that is read; 0: none, which is an error unless the field is optional.
   integer function find(self, about) result(place)
      class(fields_type), intent(inout) :: self
      type(field_type), intent(in) :: about

      place = 0
      if (allocated(self%wrong)) return
      place = self%groups(self%here)%place(about%name, about%dimensions == '' .and. self%along == '', self%next)
      self%next = place + 1
      if (place > 0 .or. about%optional) return
      self%lacks = .true.
      call self%check(.false., about%name)
   end function find

   !> Finds or adds the field for values of some extents; the values of the present item are those after number `first`.
   subroutine room_for(self, about, kind, extents, place, first, lengths)
      class(fields_type), intent(inout) :: self
      !> The row of the table.
      type(field_type), intent(in) :: about
      !> One of kind_real, kind_integer, kind_logical, kind_text.
      character, intent(in) :: kind
      !> Shape of the array, in the order of memory.
      integer, intent(in) :: extents(:)
      !> Number of the field in the group `here`, 0 where it is only measured; number of values before those of the array.
      integer, intent(out) :: place, first
      !> Extents of the field, without the dimension of the list.
      integer, intent(out) :: lengths(size(extents))
      type(field_type) :: full
      integer :: k, length
      character(24) :: name

      do k = 1, size(extents)
         name = word(about%dimensions, size(extents) + 1 - k)
         length = self%length_of(name)
         if (self%way == listing) length = 0
         if (length < 0) length = extents(k)
         call self%say_length(name, length)
         lengths(k) = length
      end do
      place = 0
      first = 0
      if (self%way == measuring) then
         self%bytes = self%bytes + bytes_of(kind)*product(int(lengths, int64))
         return
      end if
      if (self%along /= '') place = self%groups(self%here)%place(about%name, .false., self%next)
      if (place == 0) then
         full = about
         if (self%along /= '') full%dimensions = trim(self%along)//' '//about%dimensions
         associate (group => self%groups(self%here))
            if (self%along == '') then
               call group%add(full, kind, lengths)
            else
               call group%add(full, kind, [lengths, self%items])
               if (kind == kind_real) group%fields(group%count)%reals = ieee_value(0.0_dp, ieee_quiet_nan)
            end if
            place = group%count
            group%fields(place)%axis = full%dimensions == full%name
         end associate
      end if
      self%next = place + 1
      first = 0
      if (self%along /= '') first = (self%item - 1)*product(lengths)
   end subroutine room_for

   !> Bytes of a value in memory; a text is a short one.
   pure integer(int64) function bytes_of(kind)
      !> One of kind_real, kind_integer, kind_logical, kind_text.
      character, intent(in) :: kind

      bytes_of = 4
      if (kind == kind_real) bytes_of = 8
      if (kind == kind_text) bytes_of = 64
   end function bytes_of

   !> Finds the values of a field, or of the present item in it, for reading.
   subroutine take(self, about, kind, extents, place, first, n)
      class(fields_type), intent(inout) :: self
      !> The row of the table.
      type(field_type), intent(in) :: about
      !> One of kind_real, kind_integer, kind_logical, kind_text.
      character, intent(in) :: kind
      !> Shape of the array, in the order of memory; the size of `extents` is its rank.
      integer, intent(out) :: extents(:)
      !> Number of the field in the group `here`; number of values before those of the array; size of the array, -1: no array.
      integer, intent(out) :: place, first, n
      integer :: k, length, rank
      logical :: fits

      n = -1
      first = 0
      extents = 0
      place = self%find(about)
      if (place == 0) return
      associate (field => self%groups(self%here)%fields(place))
         rank = size(extents)
         fits = (field%kind == kind .or. field%kind == kind_integer .and. kind == kind_logical .and. about%dimensions == '') .and. &
                size(field%extents) == rank + merge(1, 0, self%along /= '')
         if (fits .and. self%along /= '') fits = field%extents(rank + 1) == self%items .and. self%item <= self%items
         if (fits) then
            do k = 1, rank
               extents(k) = field%extents(k)
               length = self%length_of(word(about%dimensions, rank + 1 - k))
               if (length < 0) call self%say_length(word(about%dimensions, rank + 1 - k), extents(k))
               fits = fits .and. (length < 0 .or. length == extents(k)) .and. extents(k) >= 0
            end do
         end if
         call self%check(fits, about%name)
         if (.not. fits) return
         n = product(extents)
         if (self%along /= '') first = (self%item - 1)*n
         ! A field that another program made may have fewer values than its extents tell.
         if (kind == kind_real) fits = size(field%reals) >= first + n
         if (kind == kind_integer .or. kind == kind_logical) fits = size(field%integers) >= first + n
         if (kind == kind_text) fits = size(field%texts) >= first + n
         call self%check(fits, about%name)
         if (.not. fits) n = -1
      end associate
   end subroutine take

end module geartrain_base_fields
