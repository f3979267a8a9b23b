!> The force of a mesh over a step of the flow as a Taylor series, and its integral.
module geartrain_flow_force_series
   use geartrain_base_kinds, only: dp
   use geartrain_flow_flow, only: flow_type
   implicit none (type, external)
   private
   public :: force_series, impulse

contains

   !> Taylor coefficients of the force of a mesh over the latest step [N], of the torque of a coupling [N m].
   pure subroutine force_series(flow, mesh, region, force)
      !> The flow, after a step.
      type(flow_type), intent(in) :: flow
      !> Number of the mesh; region of its law during the step.
      integer, intent(in) :: mesh, region
      !> The coefficients, (0:order).
      real(dp), intent(out) :: force(0:)
      real(dp) :: stretch(0:flow%order)
      integer :: k, n

      n = flow%system%mesh_element(mesh)
      associate (law => flow%system%law(mesh))
         stretch = flow%p(1, n, :)
         stretch(0) = stretch(0) - law%origin(region)
         force = law%damping(region)*flow%v(1, n, :)
         if (law%varies(region)) then
            do k = 0, flow%order
               force(k:) = force(k:) + flow%kappa(k, mesh)*stretch(:flow%order - k)
            end do
         else
            force = force + law%stiffness(region)*stretch
         end if
      end associate
      force = flow%system%load_unit(mesh)*force
   end subroutine force_series

   !> Integral of the force of a mesh over the latest step, by time times characteristic frequency [N].
   pure real(dp) function impulse(flow, mesh, region)
      !> The flow, after a step.
      type(flow_type), intent(in) :: flow
      !> Number of the mesh; region of its law during the step.
      integer, intent(in) :: mesh, region
      real(dp) :: force(0:flow%order)
      integer :: k

      call force_series(flow, mesh, region, force)
      impulse = 0
      do k = flow%order, 0, -1
         impulse = impulse*flow%length + force(k)/(k + 1)
      end do
      impulse = impulse*flow%length
   end function impulse

end module geartrain_flow_force_series
