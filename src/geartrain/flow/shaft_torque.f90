!> Torques of shafts and of what holds bodies, along the flow.
module geartrain_flow_shaft_torque
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use geartrain_base_kinds, only: dp
   use geartrain_base_series, only: wave_value
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_taylor, only: series_value
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: add_torques, linear_forces

contains

   !> Sets the forces of shafts and of damping to ground, at present or within the latest step; those of meshes stay.
   pure subroutine linear_forces(flow, phi, tau)
      !> The flow, started; with `tau` after a step.
      type(flow_type), intent(in) :: flow
      !> Forces over k b_c [1], (element).
      real(dp), intent(inout) :: phi(:)
      !> Time since the beginning of the step, 0 to `length` [1]; absent: at present.
      real(dp), intent(in), optional :: tau
      real(dp) :: p, v
      integer :: n

      associate (system => flow%system)
         do n = 1, system%elements
            if (system%element_mesh(n) > 0) cycle
            if (present(tau)) then
               p = series_value(flow%p(1, n, :), tau)
               v = series_value(flow%v(1, n, :), tau)
            else
               call flow%element_now(n, p, v)
            end if
            phi(n) = system%static_force(n) + system%spring(n)*p + system%damping(n)*v
         end do
      end associate
   end subroutine linear_forces

   !> Adds up the torques of shafts at equidistant instants from time 0 on.
   pure subroutine add_torques(system, frequency_ratio, spacing, phi, torque)
      type(system_type), intent(in) :: system
      !> Lambda [1]; phase of the fundamental between two instants [rad].
      real(dp), intent(in) :: frequency_ratio, spacing
      !> Forces of the elements over k b_c [1], (samples, element).
      real(dp), intent(in) :: phi(:, :)
      !> Torques [N m], (samples, shaft, then held body), those asked for; NaN where nothing determines it.
      real(dp), intent(out) :: torque(:, :)
      integer :: i, q, s

      associate (paths => system%torque_paths, length => system%characteristic_length)
         do s = 1, size(torque, 2)
            torque(:, s) = paths%constant(s)
            if (allocated(system%speed_loads)) then
               associate (loads => system%speed_loads)
                  torque(:, s) = torque(:, s) + sum(loads%constant(s, :)*(loads%factors_at(frequency_ratio) - loads%factor))
               end associate
            end if
            do i = paths%first(s), paths%first(s + 1) - 1
               torque(:, s) = torque(:, s) + (paths%gain(i)*system%stiffness(paths%element(i))*length)*phi(:, paths%element(i))
            end do
            do i = paths%torque_first(s), paths%torque_first(s + 1) - 1
               associate (series => system%torque(paths%torque(i)))
                  torque(:, s) = torque(:, s) + paths%torque_gain(i)*length &
                                 *[(wave_value(series%harmonic, series%amplitude, spacing*(q - 1)), q=1, size(torque, 1))]
               end associate
            end do
            if (.not. paths%known(s)) torque(:, s) = ieee_value(1.0_dp, ieee_quiet_nan)
         end do
      end associate
   end subroutine add_torques

end module geartrain_flow_shaft_torque
