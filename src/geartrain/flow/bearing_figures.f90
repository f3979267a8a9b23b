!> Forces of bearings over a motion.
module geartrain_flow_bearing_figures
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp
   use geartrain_flow_sampled_peak, only: peak
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: measure_bearings

contains

   !> Sets the forces of the bearings.
   subroutine measure_bearings(system, torque, motion)
      !> The train.
      type(system_type), intent(in) :: system
      !> Rows of the torque paths, the forces of bearings last [N], (samples, row).
      real(dp), intent(in) :: torque(:, :)
      !> Gets the forces.
      type(motion_type), intent(inout) :: motion
      integer :: form(2), j, q

      q = size(torque, 1)
      form = [2, system%torque_paths%bearings]
      associate (force => torque(:, system%torque_paths%torques + 1:), open => motion%window > 0)
         motion%bearing_force_mean = reshape(sum(force, 1)/q, form)
         motion%bearing_force_rms = reshape([(sqrt(sum((force(:, j) - sum(force(:, j))/q)**2)/q), j=1, size(force, 2))], form)
         motion%bearing_force_minimum = reshape([(-peak(-force(:, j), open), j=1, size(force, 2))], form)
         motion%bearing_force_maximum = reshape([(peak(force(:, j), open), j=1, size(force, 2))], form)
      end associate
   end subroutine measure_bearings

end module geartrain_flow_bearing_figures
