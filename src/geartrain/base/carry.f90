!> Carries one component of a result, of any type and rank, between the result and its field, see geartrain_base_fields. An array
!> that is not allocated has no field, and without a field an array is not allocated.
module geartrain_base_carry
   use geartrain_base_carry_values, only: arrange, carry_integers, carry_reals, carry_texts
   use geartrain_base_field, only: field_type, kind_integer, kind_logical, text_type
   use geartrain_base_fields, only: arranging, fields_type, reading
   use geartrain_base_kinds, only: dp
   use geartrain_base_words, only: place_type, words_type
   implicit none (type, external)
   private
   public :: carry, carry_text, carry_words

   !> Carries a component between the result and its field.
   !>
   !> fields: the fields of the results, in the group of the component.
   !> about: the row of the table; the dimensions of the row are those of the component in reverse order.
   !> value: the component; of names, the blanks at their ends do not count.
   interface carry
      module procedure :: real_0, real_1, real_2, real_3, complex_1, complex_2, integer_0, integer_1, integer_2, logical_0, &
         logical_1, word_0, word_1
   end interface carry

contains

   subroutine real_0(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      real(dp), intent(inout) :: value
      real(dp), allocatable :: values(:)
      integer :: extents(0)
      logical :: changed

      call carry_reals(fields, about, extents, [value], values, changed)
      if (changed) value = values(1)
   end subroutine real_0

   subroutine real_1(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      real(dp), allocatable, intent(inout) :: value(:)
      real(dp), allocatable :: values(:), arranged(:)
      integer :: extents(1), lengths(1)
      logical :: changed

      extents = 0
      if (allocated(value)) extents = shape(value)
      if (fields%way == arranging) then
         lengths = fields%lengths_of(about, 1)
         allocate (arranged(lengths(1)))
         call arrange(fields%order, extents, lengths, value, arranged)
         call move_alloc(arranged, value)
         return
      end if
      call carry_reals(fields, about, extents, value, values, changed)
      if (changed) value = values
   end subroutine real_1

   subroutine real_2(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      real(dp), allocatable, intent(inout) :: value(:, :)
      real(dp), allocatable :: values(:), arranged(:, :)
      integer :: extents(2), lengths(2)
      logical :: changed

      extents = 0
      if (allocated(value)) extents = shape(value)
      if (fields%way == arranging) then
         lengths = fields%lengths_of(about, 2)
         allocate (arranged(lengths(1), lengths(2)))
         call arrange(fields%order, extents, lengths, value, arranged)
         call move_alloc(arranged, value)
         return
      end if
      call carry_reals(fields, about, extents, value, values, changed)
      if (changed) value = reshape(values, extents)
   end subroutine real_2

   subroutine real_3(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      real(dp), allocatable, intent(inout) :: value(:, :, :)
      real(dp), allocatable :: values(:), arranged(:, :, :)
      integer :: extents(3), lengths(3)
      logical :: changed

      extents = 0
      if (allocated(value)) extents = shape(value)
      if (fields%way == arranging) then
         lengths = fields%lengths_of(about, 3)
         allocate (arranged(lengths(1), lengths(2), lengths(3)))
         call arrange(fields%order, extents, lengths, value, arranged)
         call move_alloc(arranged, value)
         return
      end if
      call carry_reals(fields, about, extents, value, values, changed)
      if (changed) value = reshape(values, extents)
   end subroutine real_3

   !> In the row, `complex` is the last dimension.
   subroutine complex_1(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      complex(dp), allocatable, intent(inout) :: value(:)
      real(dp), allocatable :: parts(:, :)

      if (allocated(value) .and. fields%way /= reading) then
         allocate (parts(2, size(value)))
         parts(1, :) = value%re
         parts(2, :) = value%im
      end if
      call complex_axis(fields)
      call carry(fields, about, parts)
      if (fields%way /= reading .and. fields%way /= arranging .or. .not. allocated(parts)) return
      call fields%check(size(parts, 1) == 2, about%name)
      if (size(parts, 1) == 2) value = cmplx(parts(1, :), parts(2, :), dp)
   end subroutine complex_1

   !> In the row, `complex` is the last dimension.
   subroutine complex_2(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      complex(dp), allocatable, intent(inout) :: value(:, :)
      complex(dp), allocatable :: arranged(:, :)
      real(dp), allocatable :: parts(:, :, :)
      integer :: lengths(3), rows

      if (fields%way == arranging) then
         lengths = fields%lengths_of(about, 3)
         allocate (arranged(lengths(2), lengths(3)))
         rows = 0
         if (allocated(value)) rows = min(lengths(2), size(value, 1))
         if (rows > 0) arranged(:rows, :size(fields%order)) = value(:rows, fields%order)
         arranged(rows + 1:, :) = 0
         call move_alloc(arranged, value)
         return
      end if
      if (allocated(value) .and. fields%way /= reading) then
         allocate (parts(2, size(value, 1), size(value, 2)))
         parts(1, :, :) = value%re
         parts(2, :, :) = value%im
      end if
      call complex_axis(fields)
      call carry(fields, about, parts)
      if (fields%way /= reading .or. .not. allocated(parts)) return
      call fields%check(size(parts, 1) == 2, about%name)
      if (size(parts, 1) == 2) value = cmplx(parts(1, :, :), parts(2, :, :), dp)
   end subroutine complex_2

   !> Visits the axis `complex` of a group once.
   subroutine complex_axis(fields)
      class(fields_type), intent(inout) :: fields

      if (fields%way == arranging) call fields%expect('complex', 2)
      if (fields%length_of('complex') < 0) &
         call fields%text_axis('complex', ['real     ', 'imaginary'], 'part of a complex number')
   end subroutine complex_axis

   subroutine integer_0(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      integer, intent(inout) :: value
      integer, allocatable :: values(:)
      integer :: extents(0)
      logical :: changed

      values = [value]
      call carry_integers(fields, about, kind_integer, extents, values, changed)
      if (changed) value = values(1)
   end subroutine integer_0

   subroutine integer_1(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      integer, allocatable, intent(inout) :: value(:)
      integer :: extents(1)
      logical :: changed

      extents = 0
      if (allocated(value)) extents = shape(value)
      call carry_integers(fields, about, kind_integer, extents, value, changed)
   end subroutine integer_1

   subroutine integer_2(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      integer, allocatable, intent(inout) :: value(:, :)
      integer, allocatable :: values(:)
      integer :: extents(2)
      logical :: changed

      extents = 0
      if (allocated(value)) extents = shape(value)
      if (allocated(value)) values = reshape(value, [size(value)])
      call carry_integers(fields, about, kind_integer, extents, values, changed)
      if (changed) value = reshape(values, extents)
   end subroutine integer_2

   subroutine logical_0(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      logical, intent(inout) :: value
      integer, allocatable :: values(:)
      integer :: extents(0)
      logical :: changed

      values = [merge(1, 0, value)]
      call carry_integers(fields, about, kind_logical, extents, values, changed)
      if (changed) value = values(1) == 1
   end subroutine logical_0

   subroutine logical_1(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      logical, allocatable, intent(inout) :: value(:)
      integer, allocatable :: values(:)
      integer :: extents(1)
      logical :: changed

      extents = 0
      if (allocated(value)) extents = shape(value)
      if (allocated(value)) values = merge(1, 0, value)
      call carry_integers(fields, about, kind_logical, extents, values, changed)
      if (changed) value = values == 1
   end subroutine logical_1

   !> A name, which has blanks at its end.
   subroutine word_0(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      character(*), intent(inout) :: value
      type(text_type), allocatable :: values(:)
      integer :: extents(0)
      logical :: changed

      allocate (values(1))
      values(1)%text = trim(value)
      call carry_texts(fields, about, extents, values, changed)
      if (changed) value = values(1)%text
   end subroutine word_0

   !> Names, which have blanks at their ends.
   subroutine word_1(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      character(*), allocatable, intent(inout) :: value(:)
      type(text_type), allocatable :: values(:)
      integer :: extents(1), i
      logical :: changed

      extents = 0
      if (allocated(value)) then
         extents = shape(value)
         allocate (values(size(value)))
         do i = 1, size(value)
            values(i)%text = trim(value(i))
         end do
      end if
      call carry_texts(fields, about, extents, values, changed)
      if (.not. changed) return
      if (allocated(value)) deallocate (value)
      allocate (value(size(values)))
      do i = 1, size(values)
         value(i) = values(i)%text
      end do
   end subroutine word_1

   !> Carries a text of any length.
   subroutine carry_text(fields, about, value, none)
      class(fields_type), intent(inout) :: fields
      !> The row of the table.
      type(field_type), intent(in) :: about
      !> The text; not allocated: no field.
      character(:), allocatable, intent(inout) :: value
      !> Text that stands in the field for a `value` that is not allocated.
      character(*), intent(in), optional :: none
      type(text_type), allocatable :: values(:)
      integer :: extents(0)
      logical :: changed

      if (allocated(value) .or. present(none)) allocate (values(1))
      if (present(none)) values(1)%text = none
      if (allocated(value)) values(1)%text = value
      call carry_texts(fields, about, extents, values, changed)
      if (.not. changed) return
      if (allocated(value)) deallocate (value)
      if (present(none)) then
         if (values(1)%text == none) return
      end if
      call move_alloc(values(1)%text, value)
   end subroutine carry_text

   !> Carries a sentence as its text and, where it states frequencies, the field NAME_places.
   subroutine carry_words(fields, about, value, none)
      class(fields_type), intent(inout) :: fields
      !> The row of the table for the text.
      type(field_type), intent(in) :: about
      !> The sentence; not allocated: no fields.
      type(words_type), allocatable, intent(inout) :: value
      !> Text that stands in the field for a `value` that is not allocated.
      character(*), intent(in), optional :: none
      character(:), allocatable :: text
      real(dp), allocatable :: places(:)
      character(:), allocatable :: name
      integer :: i

      if (allocated(value)) then
         text = value%text
         if (size(value%places) > 0) then
            places = [(value%places(i)%from, value%places(i)%to, real(value%places(i)%first, dp), &
                       real(value%places(i)%last, dp), i=1, size(value%places))]
         end if
      end if
      call carry_text(fields, about, text, none)
      name = trim(about%name)//'_places'
      call carry(fields, field_type(name, name, '1', 'of each Lambda in the text: from, to, first and last letter', about%only, &
                                    optional=.true.), places)
      if (fields%way /= reading .or. .not. allocated(text)) return
      value = words_type(text)
      if (.not. allocated(places)) return
      value%places = [(place_type(nint(places(i + 2)), nint(places(i + 3)), places(i), places(i + 1)), i=1, size(places) - 3, 4)]
      associate (first => value%places%first, last => value%places%last)
         call fields%check(all(first >= 1 .and. last >= first .and. last <= len(text)), name)
      end associate
   end subroutine carry_words

end module geartrain_base_carry
