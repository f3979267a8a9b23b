!> Torques of shafts, of what holds bodies and of couplings, and forces of bearings, along the flow.
module geartrain_flow_shaft_torque
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use geartrain_base_kinds, only: dp
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_taylor, only: add_waves
   implicit none (type, external)
   private
   public :: torque_series

contains

   !> Taylor coefficients of the torques of the shafts and of what follows them in the torque paths, over the latest step, as many
   !> as are asked for [N m]; NaN where nothing determines it.
   pure subroutine torque_series(flow, begun, mesh_force, torque)
      type(flow_type), intent(in) :: flow
      !> Time at which the step begins [1].
      real(dp), intent(in) :: begun
      !> Taylor coefficients of the mesh forces [N], of couplings [N m], (0:order, mesh).
      real(dp), intent(in) :: mesh_force(0:, :)
      !> (0:order, row).
      real(dp), intent(out) :: torque(0:, :)
      real(dp) :: force(0:flow%order, flow%system%elements), wave(0:flow%order)
      integer :: i, n, s

      associate (system => flow%system, paths => flow%system%torque_paths, length => flow%system%characteristic_length)
         do n = 1, system%elements
            if (system%element_mesh(n) > 0) then
               associate (j => system%element_mesh(n))
                  force(:, n) = system%stiffness(n)*length/system%load_unit(j)*mesh_force(:, j)
               end associate
            else
               force(:, n) = system%spring(n)*flow%p(1, n, :) + system%damping(n)*flow%v(1, n, :)
               force(0, n) = force(0, n) + system%static_force(n)
               force(:, n) = system%stiffness(n)*length*force(:, n)
            end if
         end do
         do s = 1, size(torque, 2)
            torque(:, s) = 0
            torque(0, s) = paths%constant(s)
            if (allocated(system%speed_loads)) then
               associate (loads => system%speed_loads)
                  do i = 1, size(loads%factor)
                     torque(:, s) = torque(:, s) + loads%constant(s, i)*loads%series_of(i, flow%frequency_ratio &
                                                                  + flow%acceleration*begun, flow%acceleration, flow%order)
                  end do
               end associate
            end if
            do i = paths%first(s), paths%first(s + 1) - 1
               torque(:, s) = torque(:, s) + paths%gain(i)*force(:, paths%element(i))
            end do
            do i = paths%torque_first(s), paths%torque_first(s + 1) - 1
               wave = 0
               if (allocated(flow%push)) wave(0) = flow%push(paths%torque(i))
               associate (series => system%torque(paths%torque(i)))
                  call add_waves(series%harmonic, series%amplitude, flow%phase, flow%frequency_ratio, flow%acceleration, &
                                 begun, wave)
               end associate
               torque(:, s) = torque(:, s) + paths%torque_gain(i)*length*wave
            end do
            if (.not. paths%known(s)) torque(:, s) = ieee_value(1.0_dp, ieee_quiet_nan)
         end do
      end associate
   end subroutine torque_series

end module geartrain_flow_shaft_torque
