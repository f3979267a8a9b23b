! Natural modes, out and in.

! elements, modes
subroutine modes_sizes(handle, sizes)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(out) :: sizes(2)
   type(box_type), pointer :: box

   box => box_of(handle)
   sizes = 0
   if (allocated(box%results%modes)) sizes = shape(box%results%modes%shape)
end subroutine modes_sizes

! values: undamped frequency, damped frequency, damping ratio.
subroutine copy_modes(handle, elements, modes, values, shapes)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: elements, modes
   double precision, intent(out) :: values(modes, 3), shapes(elements, modes)
   type(box_type), pointer :: box

   box => box_of(handle)
   values(:, 1) = box%results%modes%natural_frequency
   values(:, 2) = box%results%modes%damped_frequency
   values(:, 3) = box%results%modes%damping_ratio
   shapes = box%results%modes%shape
end subroutine copy_modes

! names: 16 characters an element.
subroutine put_modes(handle, names, values, shapes, elements, modes)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: elements, modes
   character(*), intent(in) :: names
   double precision, intent(in) :: values(modes, 3), shapes(elements, modes)
   type(box_type), pointer :: box
   integer :: i

   box => box_of(handle)
   allocate (box%results%modes)
   box%results%modes%natural_frequency = values(:, 1)
   box%results%modes%damped_frequency = values(:, 2)
   box%results%modes%damping_ratio = values(:, 3)
   box%results%modes%shape = shapes
   allocate (box%results%modes%element(elements))
   do i = 1, elements
      box%results%modes%element(i) = names(16*(i - 1) + 1:16*i)
   end do
end subroutine put_modes
