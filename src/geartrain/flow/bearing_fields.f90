!> Fields of the forces of bearings.
module geartrain_flow_bearing_fields
   use geartrain_base_carry, only: carry
   use geartrain_base_field, only: row => field_type
   use geartrain_base_fields, only: arranging, fields_type
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: bearing_axes, bearing_forces_type, carry_bearings, visit_bearings

   character(*), parameter :: over_period = ' over the period, positive where the body pushes in the positive direction'
   type(row), parameter :: forces(4) = [ &
      row('bearing_force_mean', 'bearing axis', 'N', 'mean force of a bearing'//over_period, 'with a bearing', &
          optional=.true.), &
      row('bearing_force_rms', 'bearing axis', 'N', 'root mean square over time of the force of a bearing without its mean', &
          'with a bearing', optional=.true.), &
      row('bearing_force_minimum', 'bearing axis', 'N', 'smallest force of a bearing'//over_period, 'with a bearing', &
          optional=.true.), &
      row('bearing_force_maximum', 'bearing axis', 'N', 'largest force of a bearing'//over_period, 'with a bearing', &
          optional=.true.)]

   !> Forces of the bearings at the points of a branch.
   type :: bearing_forces_type
      !> Number of bearings whose forces are wanted.
      integer :: bearings = 0
      !> Mean, root mean square without the mean, and extremes of each force over the period [N], (axis, bearing, point).
      real(dp), allocatable :: mean(:, :, :), rms(:, :, :), minimum(:, :, :), maximum(:, :, :)
   end type bearing_forces_type

contains

   !> Visits the axes of the forces.
   subroutine bearing_axes(bearings, fields)
      !> Number of bearings; set by reading.
      integer, intent(inout) :: bearings
      !> Lists, writes or reads each field.
      class(fields_type), intent(inout) :: fields

      call fields%index_axis('bearing', bearings, 'bearing, in the order of the train')
      if (fields%way == arranging) call fields%expect('axis', 2)
      if (fields%length_of('axis') < 0) call fields%text_axis('axis', ['x', 'y'], 'direction of the transverse plane')
   end subroutine bearing_axes

   !> Carries the forces of a motion, whose axes have been visited.
   subroutine carry_bearings(fields, mean, rms, minimum, maximum)
      !> Lists, writes or reads each field.
      class(fields_type), intent(inout) :: fields
      !> Forces [N], (axis, bearing); not allocated: none.
      real(dp), allocatable, intent(inout) :: mean(:, :), rms(:, :), minimum(:, :), maximum(:, :)

      call carry(fields, forces(1), mean)
      call carry(fields, forces(2), rms)
      call carry(fields, forces(3), minimum)
      call carry(fields, forces(4), maximum)
   end subroutine carry_bearings

   !> Visits the forces at the points of a branch.
   subroutine visit_bearings(force, fields)
      !> The forces.
      type(bearing_forces_type), intent(inout) :: force
      !> Lists, writes or reads each field.
      class(fields_type), intent(inout) :: fields
      type(row) :: about(4)

      if (.not. fields%has('bearing_force_mean', force%bearings > 0)) return
      call bearing_axes(force%bearings, fields)
      about = forces
      about%dimensions = 'point bearing axis'
      call carry(fields, about(1), force%mean)
      call carry(fields, about(2), force%rms)
      call carry(fields, about(3), force%minimum)
      call carry(fields, about(4), force%maximum)
   end subroutine visit_bearings

end module geartrain_flow_bearing_fields
