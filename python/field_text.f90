!> Fields as text, as they travel over the border.
module geartrain_python_field_text
   use, intrinsic :: iso_c_binding, only: c_null_char
   use geartrain_base_field, only: groups_type, text_type
   use geartrain_base_numbers, only: integer_text
   implicit none (type, external)
   private
   public :: joined, list_fields, parted

contains

   !> Length of the texts with a NUL behind each.
   pure integer function length_of(texts)
      type(text_type), intent(in) :: texts(:)
      integer :: i

      length_of = size(texts)
      do i = 1, size(texts)
         length_of = length_of + len(texts(i)%text)
      end do
   end function length_of

   !> A line for each field: path, name, kind, length of its texts, extents, dimensions, unit, description.
   subroutine list_fields(fields, text)
      class(groups_type), intent(in) :: fields
      character(:), allocatable, intent(out) :: text
      character, parameter :: tab = achar(9)
      character(:), allocatable :: list, longer
      integer :: length, used, i, j, k

      allocate (character(16384) :: list)
      used = 0
      do i = 1, fields%count
         do j = 1, fields%groups(i)%count
            associate (field => fields%groups(i)%fields(j))
               length = 0
               if (allocated(field%texts)) length = length_of(field%texts)
               call add(fields%groups(i)%path)
               call add_column(field%about%name)
               call add_column(field%kind)
               call add_column(integer_text(length))
               call add(tab)
               do k = 1, size(field%extents)
                  call add(' ')
                  call add(integer_text(field%extents(k)))
               end do
               call add_column(field%about%dimensions)
               call add_column(field%about%unit)
               call add_column(field%about%description)
               call add(new_line('a'))
            end associate
         end do
      end do
      text = list(:used)

   contains

      !> Adds the next column; blanks at its end do not count.
      subroutine add_column(piece)
         character(*), intent(in) :: piece

         call add(tab)
         call add(piece(:len_trim(piece)))
      end subroutine add_column

      subroutine add(piece)
         character(*), intent(in) :: piece

         if (used + len(piece) > len(list)) then
            allocate (character(2*(used + len(piece))) :: longer)
            longer(:used) = list(:used)
            call move_alloc(longer, list)
         end if
         list(used + 1:used + len(piece)) = piece
         used = used + len(piece)
      end subroutine add

   end subroutine list_fields

   !> Texts one after another, each closed by a null.
   subroutine joined(texts, text)
      type(text_type), intent(in) :: texts(:)
      character(:), allocatable, intent(out) :: text
      integer :: i, at

      allocate (character(length_of(texts)) :: text)
      at = 0
      do i = 1, size(texts)
         text(at + 1:at + len(texts(i)%text)) = texts(i)%text
         at = at + len(texts(i)%text) + 1
         text(at:at) = c_null_char
      end do
   end subroutine joined

   !> The inverse of `joined`.
   subroutine parted(text, texts)
      character(*), intent(in) :: text
      type(text_type), intent(inout) :: texts(:)
      integer :: i, first, length

      first = 1
      do i = 1, size(texts)
         length = index(text(first:), c_null_char) - 1
         if (length < 0) length = len(text) - first + 1
         texts(i)%text = text(first:first + length - 1)
         first = min(len(text) + 1, first + length + 1)
      end do
   end subroutine parted

end module geartrain_python_field_text
