!> Carries one component of a result, of whatever type and rank, between itself and its field, see geartrain_base_fields. An array
!> that is not allocated is no field, and stays so where there is none.
module geartrain_base_carry
   use geartrain_base_field, only: field_type, kind_integer, kind_logical, text_type
   use geartrain_base_fields, only: arranging, fields_type, reading
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: carry, carry_text

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
      logical :: found

      values = [value]
      call fields%carry_reals(about, extents, values, found)
      if (found) value = values(1)
   end subroutine real_0

   subroutine real_1(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      real(dp), allocatable, intent(inout) :: value(:)
      integer :: extents(1)
      logical :: found
      real(dp), allocatable :: arranged(:)
      integer :: n(1)

      if (fields%way == arranging) then
         n = fields%lengths_of(about, 1)
         allocate (arranged(n(1)), source=0.0_dp)
         if (allocated(value)) arranged(:size(fields%order)) = value(fields%order)
         call move_alloc(arranged, value)
         return
      end if
      extents = 0
      if (allocated(value)) extents = shape(value)
      call fields%carry_reals(about, extents, value, found)
   end subroutine real_1

   subroutine real_2(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      real(dp), allocatable, intent(inout) :: value(:, :)
      real(dp), allocatable :: values(:)
      integer :: extents(2)
      logical :: found
      real(dp), allocatable :: arranged(:, :)
      integer :: n(2)

      if (fields%way == arranging) then
         n = fields%lengths_of(about, 2)
         allocate (arranged(n(1), n(2)), source=0.0_dp)
         if (allocated(value)) arranged(:, :size(fields%order)) = value(:, fields%order)
         call move_alloc(arranged, value)
         return
      end if
      extents = 0
      if (allocated(value)) extents = shape(value)
      if (allocated(value) .and. fields%way /= reading) values = reshape(value, [size(value)])
      call fields%carry_reals(about, extents, values, found)
      if (found) value = reshape(values, extents)
   end subroutine real_2

   subroutine real_3(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      real(dp), allocatable, intent(inout) :: value(:, :, :)
      real(dp), allocatable :: values(:)
      integer :: extents(3)
      logical :: found
      real(dp), allocatable :: arranged(:, :, :)
      integer :: n(3)

      if (fields%way == arranging) then
         n = fields%lengths_of(about, 3)
         allocate (arranged(n(1), n(2), n(3)), source=0.0_dp)
         if (allocated(value)) arranged(:min(n(1), size(value, 1)), :, :size(fields%order)) = &
            value(:min(n(1), size(value, 1)), :, fields%order)
         call move_alloc(arranged, value)
         return
      end if
      extents = 0
      if (allocated(value)) extents = shape(value)
      if (allocated(value) .and. fields%way /= reading) values = reshape(value, [size(value)])
      call fields%carry_reals(about, extents, values, found)
      if (found) value = reshape(values, extents)
   end subroutine real_3

   !> The row names the dimension `complex` last.
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
      if (fields%length_of('complex') < 0) &
         call fields%text_axis('complex', ['real     ', 'imaginary'], 'part of a complex number')
      call carry(fields, about, parts)
      if (.not. (fields%way == reading .and. allocated(parts))) return
      call fields%check(size(parts, 1) == 2, about%name)
      if (size(parts, 1) == 2) value = cmplx(parts(1, :), parts(2, :), dp)
   end subroutine complex_1

   subroutine complex_2(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      complex(dp), allocatable, intent(inout) :: value(:, :)
      real(dp), allocatable :: parts(:, :, :)
      complex(dp), allocatable :: arranged(:, :)
      integer :: n(3)

      if (fields%way == arranging) then
         n = fields%lengths_of(about, 3)
         allocate (arranged(n(2), n(3)), source=(0.0_dp, 0.0_dp))
         if (allocated(value)) arranged(:, :size(fields%order)) = value(:, fields%order)
         call move_alloc(arranged, value)
         return
      end if
      if (allocated(value) .and. fields%way /= reading) then
         allocate (parts(2, size(value, 1), size(value, 2)))
         parts(1, :, :) = value%re
         parts(2, :, :) = value%im
      end if
      if (fields%length_of('complex') < 0) &
         call fields%text_axis('complex', ['real     ', 'imaginary'], 'part of a complex number')
      call carry(fields, about, parts)
      if (.not. (fields%way == reading .and. allocated(parts))) return
      call fields%check(size(parts, 1) == 2, about%name)
      if (size(parts, 1) == 2) value = cmplx(parts(1, :, :), parts(2, :, :), dp)
   end subroutine complex_2

   subroutine integer_0(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      integer, intent(inout) :: value
      integer, allocatable :: values(:)
      integer :: extents(0)
      logical :: found

      values = [value]
      call fields%carry_integers(about, kind_integer, extents, values, found)
      if (found) value = values(1)
   end subroutine integer_0

   subroutine integer_1(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      integer, allocatable, intent(inout) :: value(:)
      integer :: extents(1)
      logical :: found
      integer, allocatable :: arranged(:)
      integer :: n(1)

      if (fields%way == arranging) then
         n = fields%lengths_of(about, 1)
         allocate (arranged(n(1)), source=0)
         if (allocated(value)) arranged(:size(fields%order)) = value(fields%order)
         call move_alloc(arranged, value)
         return
      end if
      extents = 0
      if (allocated(value)) extents = shape(value)
      call fields%carry_integers(about, kind_integer, extents, value, found)
   end subroutine integer_1

   subroutine integer_2(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      integer, allocatable, intent(inout) :: value(:, :)
      integer, allocatable :: values(:)
      integer :: extents(2)
      logical :: found

      extents = 0
      if (allocated(value)) extents = shape(value)
      if (allocated(value) .and. fields%way /= reading) values = reshape(value, [size(value)])
      call fields%carry_integers(about, kind_integer, extents, values, found)
      if (found) value = reshape(values, extents)
   end subroutine integer_2

   subroutine logical_0(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      logical, intent(inout) :: value
      integer, allocatable :: values(:)
      integer :: extents(0)
      logical :: found

      values = [merge(1, 0, value)]
      call fields%carry_integers(about, kind_logical, extents, values, found)
      if (found) value = values(1) == 1
   end subroutine logical_0

   subroutine logical_1(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      logical, allocatable, intent(inout) :: value(:)
      integer, allocatable :: values(:)
      integer :: extents(1)
      logical :: found
      logical, allocatable :: arranged(:)
      integer :: n(1)

      if (fields%way == arranging) then
         n = fields%lengths_of(about, 1)
         allocate (arranged(n(1)), source=.false.)
         if (allocated(value)) arranged(:size(fields%order)) = value(fields%order)
         call move_alloc(arranged, value)
         return
      end if
      extents = 0
      if (allocated(value)) extents = shape(value)
      if (allocated(value)) values = merge(1, 0, value)
      call fields%carry_integers(about, kind_logical, extents, values, found)
      if (found) value = values == 1
   end subroutine logical_1

   !> A text of a length of its own kind, as a name of some sort.
   subroutine word_0(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      character(*), intent(inout) :: value
      type(text_type), allocatable :: values(:)
      integer :: extents(0)
      logical :: found

      allocate (values(1))
      values(1)%text = trim(value)
      call fields%carry_texts(about, extents, values, found)
      if (found) value = values(1)%text
   end subroutine word_0

   subroutine word_1(fields, about, value)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      character(*), allocatable, intent(inout) :: value(:)
      type(text_type), allocatable :: values(:)
      integer :: extents(1), i
      logical :: found

      extents = 0
      if (allocated(value)) then
         extents = shape(value)
         allocate (values(size(value)))
         do i = 1, size(value)
            values(i)%text = trim(value(i))
         end do
      end if
      call fields%carry_texts(about, extents, values, found)
      if (.not. found) return
      if (allocated(value)) deallocate (value)
      allocate (value(size(values)))
      do i = 1, size(values)
         value(i) = values(i)%text
      end do
   end subroutine word_1

   !> A text of any length. Where it is not allocated `none` stands for it.
   subroutine carry_text(fields, about, value, none)
      class(fields_type), intent(inout) :: fields
      type(field_type), intent(in) :: about
      character(:), allocatable, intent(inout) :: value
      character(*), intent(in), optional :: none
      type(text_type), allocatable :: values(:)
      integer :: extents(0)
      logical :: found

      if (allocated(value) .or. present(none)) allocate (values(1))
      if (present(none)) values(1)%text = none
      if (allocated(value)) values(1)%text = value
      call fields%carry_texts(about, extents, values, found)
      if (.not. found) return
      if (allocated(value)) deallocate (value)
      if (present(none)) then
         if (values(1)%text == none) return
      end if
      call move_alloc(values(1)%text, value)
   end subroutine carry_text

end module geartrain_base_carry
