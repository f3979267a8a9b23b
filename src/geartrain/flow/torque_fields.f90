!> Fields of torques: those of the shafts, then the reaction torques of held bodies and the torques of couplings, which stand behind
!> them in one array.
module geartrain_flow_torque_fields
   use geartrain_base_carry, only: carry
   use geartrain_base_field, only: row => field_type
   use geartrain_base_fields, only: arranging, fields_type, listing, measuring, reading
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: about_coupling, about_held, carry_torque, coupling_row, loss_row

   character(*), parameter :: about_held = 'held body, in the order of the train', about_coupling = 'coupling, in the order of the &
      &train'
   character(*), parameter :: dimensions(*) = [character(8) :: 'shaft', 'held', 'coupling']

   !> Carries an array with the torques of the shafts, then of the held bodies, then of the couplings, as three fields. The axes
   !> `shaft` and, where there are such, `held` and `coupling` have been visited.
   interface carry_torque
      module procedure :: carry_torque_1, carry_torque_2
   end interface carry_torque

contains

   subroutine carry_torque_1(fields, about, values)
      class(fields_type), intent(inout) :: fields
      !> The rows of the three fields.
      type(row), intent(in) :: about(3)
      !> Torques [N m], (shaft, held body and coupling); not allocated: none.
      real(dp), allocatable, intent(inout) :: values(:)
      real(dp), allocatable :: part(:), whole(:)
      integer :: i, first, n
      logical :: none

      if (fields%way == measuring .or. .not. (there(fields, 'held') .or. there(fields, 'coupling'))) then
         call carry(fields, about(1), values)
         return
      end if
      allocate (whole(0))
      none = .true.
      first = 1
      do i = 1, 3
         if (.not. there(fields, dimensions(i))) cycle
         if (allocated(part)) deallocate (part)
         n = max(0, fields%length_of(dimensions(i)))
         if (allocated(values) .and. fields%way /= reading) part = values(first:min(size(values), first + n - 1))
         first = first + n
         call carry(fields, about(i), part)
         if (.not. allocated(part)) cycle
         none = .false.
         whole = [whole, part]
      end do
      if (fields%way /= reading .and. fields%way /= arranging) return
      if (.not. none) values = whole
   end subroutine carry_torque_1

   subroutine carry_torque_2(fields, about, values)
      class(fields_type), intent(inout) :: fields
      !> The rows of the three fields.
      type(row), intent(in) :: about(3)
      !> Torques [N m], (shaft, held body and coupling, place); not allocated: none.
      real(dp), allocatable, intent(inout) :: values(:, :)
      real(dp), allocatable :: part(:, :), whole(:, :), longer(:, :)
      integer :: i, first, n

      ! Without a copy: the arrays of a long run-up are large, and measured from step to step.
      if (fields%way == measuring .or. .not. (there(fields, 'held') .or. there(fields, 'coupling'))) then
         call carry(fields, about(1), values)
         return
      end if
      first = 1
      do i = 1, 3
         if (.not. there(fields, dimensions(i))) cycle
         if (allocated(part)) deallocate (part)
         n = max(0, fields%length_of(dimensions(i)))
         if (allocated(values) .and. fields%way /= reading) part = values(first:min(size(values, 1), first + n - 1), :)
         first = first + n
         call carry(fields, about(i), part)
         if (.not. allocated(part)) cycle
         if (.not. allocated(whole)) allocate (whole(0, size(part, 2)))
         call fields%check(size(part, 2) == size(whole, 2), about(i)%name)
         if (size(part, 2) /= size(whole, 2)) return
         allocate (longer(size(whole, 1) + size(part, 1), size(part, 2)))
         longer(:size(whole, 1), :) = whole
         longer(size(whole, 1) + 1:, :) = part
         call move_alloc(longer, whole)
      end do
      if (fields%way /= reading .and. fields%way /= arranging) return
      if (allocated(whole)) call move_alloc(whole, values)
   end subroutine carry_torque_2

   !> Row of a torque of couplings.
   pure type(row) function coupling_row(name, along, which) result(about)
      !> Name of the field; dimension before that of the couplings, blank: none; which torque it is.
      character(*), intent(in) :: name, along, which

      about = row(name, trim(adjustl(along//' coupling')), 'N m', which//' torque of a coupling', 'with a coupling', &
                  optional=.true.)
   end function coupling_row

   !> Row of the energy that couplings lose.
   pure type(row) function loss_row(along) result(about)
      !> Dimension before that of the couplings, blank: none.
      character(*), intent(in) :: along

      about = row('coupling_energy_loss', trim(adjustl(along//' coupling')), 'J', 'energy that damping and friction of a &
         &coupling take in a period of the fundamental; times the fundamental frequency a power', 'with a coupling', &
                  optional=.true.)
   end function loss_row

   !> Whether a dimension of torques has places.
   pure logical function there(fields, dimension)
      class(fields_type), intent(in) :: fields
      character(*), intent(in) :: dimension

      there = fields%length_of(dimension) > 0 .or. fields%way == listing .or. dimension == 'shaft'
   end function there

end module geartrain_flow_torque_fields
