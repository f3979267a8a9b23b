!> Torques of a motion with dry friction, which jump between two samples.
module geartrain_flow_friction_figures
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: correct_torques

contains

   !> Replaces the part of couplings with friction in the means of torques, and their own extremes.
   pure subroutine correct_torques(system, exact, largest, sampled, motion)
      type(system_type), intent(in) :: system
      !> Mean force of each mesh [N, of a coupling N m] in row 3; largest phi and largest -phi [1]; mean of the samples of phi [1];
      !> (row, mesh) and (mesh).
      real(dp), intent(in) :: exact(:, :), largest(:, :), sampled(:)
      !> Has the torques by their samples.
      type(motion_type), intent(inout) :: motion
      integer :: i, j, n, s

      associate (paths => system%torque_paths)
         n = paths%torques - paths%couplings - paths%pairs
         do j = 1, system%meshes
            if (.not. system%friction(j) > 0) cycle
            do s = 1, paths%torques
               do i = paths%first(s), paths%first(s + 1) - 1
                  if (paths%element(i) /= system%mesh_element(j)) cycle
                  motion%shaft_torque_mean(s) = motion%shaft_torque_mean(s) + paths%gain(i)*system%stiffness(paths%element(i)) &
                                                *system%characteristic_length*(exact(3, j)/system%load_unit(j) - sampled(j))
               end do
            end do
            motion%shaft_torque_minimum(n + j) = -system%load_unit(j)*largest(2, j)
            motion%shaft_torque_maximum(n + j) = system%load_unit(j)*largest(1, j)
         end do
      end associate
   end subroutine correct_torques

end module geartrain_flow_friction_figures
