!> Fields of torques: those of the shafts, and the reaction torques of held bodies, which stand behind them in one array.
module geartrain_flow_torque_fields
   use geartrain_base_carry, only: carry
   use geartrain_base_field, only: row => field_type
   use geartrain_base_fields, only: arranging, fields_type, listing, reading
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: about_held, carry_torque

   character(*), parameter :: about_held = 'held body, in the order of the train'

   !> Carries an array with the torques of the shafts, then of the held bodies, as two fields. The axes `shaft` and `held`, where
   !> there are any, have been visited.
   interface carry_torque
      module procedure :: carry_torque_1, carry_torque_2
   end interface carry_torque

contains

   subroutine carry_torque_1(fields, of_shafts, of_held, values)
      !> Lists, writes or reads each field.
      class(fields_type), intent(inout) :: fields
      !> The rows of the two fields.
      type(row), intent(in) :: of_shafts, of_held
      !> Torques [N m], (shaft and held body); not allocated: none.
      real(dp), allocatable, intent(inout) :: values(:)
      real(dp), allocatable :: shafts(:), held(:)
      integer :: n

      if (allocated(values) .and. fields%way /= reading) then
         n = min(size(values), max(0, fields%length_of('shaft')))
         if (there(fields, 'shaft')) shafts = values(:n)
         if (there(fields, 'held')) held = values(n + 1:)
      end if
      if (there(fields, 'shaft')) call carry(fields, of_shafts, shafts)
      if (there(fields, 'held')) call carry(fields, of_held, held)
      if (fields%way /= reading .and. fields%way /= arranging) return
      if (.not. (allocated(shafts) .or. allocated(held))) return
      if (.not. allocated(shafts)) allocate (shafts(0))
      if (.not. allocated(held)) allocate (held(0))
      values = [shafts, held]
   end subroutine carry_torque_1

   subroutine carry_torque_2(fields, of_shafts, of_held, values)
      !> Lists, writes or reads each field.
      class(fields_type), intent(inout) :: fields
      !> The rows of the two fields.
      type(row), intent(in) :: of_shafts, of_held
      !> Torques [N m], (shaft and held body, place); not allocated: none.
      real(dp), allocatable, intent(inout) :: values(:, :)
      real(dp), allocatable :: shafts(:, :), held(:, :)
      integer :: n

      if (allocated(values) .and. fields%way /= reading) then
         n = min(size(values, 1), max(0, fields%length_of('shaft')))
         if (there(fields, 'shaft')) shafts = values(:n, :)
         if (there(fields, 'held')) held = values(n + 1:, :)
      end if
      if (there(fields, 'shaft')) call carry(fields, of_shafts, shafts)
      if (there(fields, 'held')) call carry(fields, of_held, held)
      if (fields%way /= reading .and. fields%way /= arranging) return
      if (.not. (allocated(shafts) .or. allocated(held))) return
      if (.not. allocated(shafts)) allocate (shafts(0, size(held, 2)))
      if (.not. allocated(held)) allocate (held(0, size(shafts, 2)))
      call fields%check(size(shafts, 2) == size(held, 2), of_held%name)
      if (size(shafts, 2) /= size(held, 2)) return
      if (allocated(values)) deallocate (values)
      allocate (values(size(shafts, 1) + size(held, 1), size(shafts, 2)))
      values(:size(shafts, 1), :) = shafts
      values(size(shafts, 1) + 1:, :) = held
   end subroutine carry_torque_2

   !> Whether a dimension of torques has places.
   pure logical function there(fields, dimension)
      class(fields_type), intent(in) :: fields
      character(*), intent(in) :: dimension

      there = fields%length_of(dimension) > 0 .or. fields%way == listing
   end function there

end module geartrain_flow_torque_fields
