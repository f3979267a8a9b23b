! Results over the border, out and in, as fields by name: whatever a type of result has, these routines carry.

! Number of bytes of a text of the box: 'message', 'case' (the resolved namelist), 'version', 'audit' (its table), 'explanation' and
! 'warnings' (of the train), 'report' and 'verbose report' (of the results), or 'fields': the fields that the box shows, a line
! each: path of the group, name, kind (r, i, l or t), bytes of a text, extents in the order of memory, dimensions in the reverse
! order, unit and description, parted by tabs. An attribute has no dimensions.
subroutine text_size(handle, name, bytes)
   use geartrain_python_box, only: box_type, box_of, get_text
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: name
   integer, intent(out) :: bytes
   type(box_type), pointer :: box
   character(:), allocatable :: text

   box => box_of(handle)
   call get_text(box, name, text)
   bytes = len(text)
   call move_alloc(text, box%text)
end subroutine text_size

! The text whose size was asked for last.
subroutine copy_text(handle, bytes, text)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: bytes
   integer(1), intent(out) :: text(bytes)
   type(box_type), pointer :: box

   box => box_of(handle)
   text = transfer(box%text, text)
end subroutine copy_text

! Makes the box show fields: 'results', 'train' (its names and units), 'explanation' (of the train), 'motions' (those on their own),
! 'audit', what is read off its response ('peaks', 'jumps', 'bands', 'separation', 'back collision'), or 'listing': all that there
! can be in a results file, without values.
subroutine show_fields(handle, what, status)
   use geartrain, only: error_type
   use geartrain_python_box, only: box_of, close_with, show
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: what
   integer, intent(out) :: status
   type(error_type), allocatable :: error

   call show(box_of(handle), what, error)
   status = close_with(box_of(handle), error)
end subroutine show_fields

! The values of a field by its line in the text 'fields', counted from 1 through all groups.
subroutine copy_reals(handle, line, items, values)
   use geartrain_base_field, only: values_type
   use geartrain_python_box, only: box_of, field_at
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: line, items
   double precision, intent(out) :: values(items)
   type(values_type), pointer :: field

   field => field_at(box_of(handle), line)
   values = field%reals
end subroutine copy_reals

subroutine copy_integers(handle, line, items, values)
   use geartrain_base_field, only: values_type
   use geartrain_python_box, only: box_of, field_at
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: line, items
   integer, intent(out) :: values(items)
   type(values_type), pointer :: field

   field => field_at(box_of(handle), line)
   values = field%integers
end subroutine copy_integers

! Texts, each closed by a null.
subroutine copy_texts(handle, line, bytes, values)
   use geartrain_base_field, only: values_type
   use geartrain_python_box, only: box_of, field_at
   use geartrain_python_field_text, only: joined
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: line, bytes
   integer(1), intent(out) :: values(bytes)
   type(values_type), pointer :: field
   character(:), allocatable :: text

   field => field_at(box_of(handle), line)
   call joined(field%texts, text)
   values = transfer(text, values)
end subroutine copy_texts

! Adds a field to those that the box is going to take; without memory for the field, taking them is an error. Of the extents, in the
! order of memory, there are `rank`: 0 for an attribute.
! f2py passes no empty array: where an extent is 0 there is one value, which is not read.
subroutine put_reals(handle, path, name, rank, extents, values, items)
   use geartrain_base_field, only: kind_real, values_type
   use geartrain_python_box, only: box_of, new_field
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: path, name
   integer, intent(in) :: rank, extents(4), items
   double precision, intent(in) :: values(items)
   type(values_type), pointer :: field

   field => new_field(box_of(handle), path, name, kind_real, extents(:rank))
   if (associated(field)) field%reals = values(:product(extents(:rank)))
end subroutine put_reals

! flags: 1 for logical values.
subroutine put_integers(handle, path, name, rank, extents, flags, values, items)
   use geartrain_base_field, only: kind_integer, kind_logical, values_type
   use geartrain_python_box, only: box_of, new_field
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: path, name
   integer, intent(in) :: rank, extents(4), flags, items, values(items)
   type(values_type), pointer :: field

   field => new_field(box_of(handle), path, name, merge(kind_logical, kind_integer, flags == 1), extents(:rank))
   if (associated(field)) field%integers = values(:product(extents(:rank)))
end subroutine put_integers

! Texts, each closed by a null.
subroutine put_texts(handle, path, name, rank, extents, values, bytes)
   use geartrain_base_field, only: kind_text, values_type
   use geartrain_python_box, only: box_of, new_field
   use geartrain_python_field_text, only: parted
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: path, name
   integer, intent(in) :: rank, extents(4), bytes
   integer(1), intent(in) :: values(bytes)
   type(values_type), pointer :: field

   field => new_field(box_of(handle), path, name, kind_text, extents(:rank))
   if (associated(field)) call parted(transfer(values, repeat(' ', bytes)), field%texts)
end subroutine put_texts

! The fields put become what they are of: 'results', 'motions', or 'variables': groups of the names of analyses, which the case asks
! for then.
subroutine take_fields(handle, what, status)
   use geartrain, only: error_type
   use geartrain_python_box, only: ask, box_of, close_with, take
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: what
   integer, intent(out) :: status
   type(error_type), allocatable :: error

   if (what == 'variables') call ask(box_of(handle), error)
   if (what /= 'variables') call take(box_of(handle), what, error)
   status = close_with(box_of(handle), error)
end subroutine take_fields
