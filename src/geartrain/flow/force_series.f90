!> The force of a mesh over a step of the flow as a Taylor series, and its integral.
module geartrain_flow_force_series
   use geartrain_base_kinds, only: dp
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_taylor, only: series_value
   use geartrain_linalg_first_root, only: polynomial, root_between
   implicit none (type, external)
   private
   public :: energy_loss, extend_range, force_series, impulse, include

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
      integer :: i, k, n

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
         if (allocated(law%offset)) force = force + flow%offset(:, mesh)
      end associate
      do i = 1, flow%friction%count
         if (flow%friction%mesh(i) == mesh) force = force + flow%friction%force(:, i)
      end do
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

   !> Energy that a mesh loses over the latest step [J].
   pure real(dp) function energy_loss(flow, mesh, region)
      !> The flow, after a step.
      type(flow_type), intent(in) :: flow
      !> Number of the mesh; region of its law during the step.
      integer, intent(in) :: mesh, region
      real(dp) :: velocity(0:flow%order), total
      integer :: i, k, l

      ! Times powers of the length: products of the coefficients alone overflow where a step is short.
      velocity = flow%v(1, flow%system%mesh_element(mesh), :)*flow%length**[(k, k=0, flow%order)]
      ! The integral of the square, term by term.
      energy_loss = 0
      do k = 2*flow%order, 0, -1
         total = 0
         do l = max(0, k - flow%order), min(k, flow%order)
            total = total + velocity(l)*velocity(k - l)
         end do
         energy_loss = energy_loss + total/(k + 1)
      end do
      energy_loss = flow%system%law(mesh)%damping(region)*flow%length*energy_loss
      ! A force that sticks does no work, and a slipping one is constant.
      do i = 1, flow%friction%count
         if (flow%friction%mesh(i) /= mesh) cycle
         energy_loss = energy_loss + flow%friction%force(0, i)*(flow%displacement(mesh, flow%length) &
                                                                - flow%displacement(mesh, 0.0_dp))
      end do
      energy_loss = flow%system%energy_unit(mesh)*energy_loss
   end function energy_loss

   !> Extends the largest value, and the largest value of the other sign, by those of a Taylor series over a step.
   pure subroutine extend_range(series, length, largest)
      !> Taylor coefficients, (0:order); length of the step [1].
      real(dp), intent(in) :: series(0:), length
      !> Largest value and largest value of the negative.
      real(dp), intent(inout) :: largest(2)
      real(dp) :: low

      low = -largest(2)
      call include(series, length, low, largest(1))
      largest(2) = -low
   end subroutine extend_range

   !> Includes the values of a Taylor series over a step in a range. A step is shorter than a period of the fastest vibration: in
   !> either half of it the slope changes sign once at most.
   pure subroutine include(series, length, low, high)
      !> Taylor coefficients, (0:order); length of the step [1].
      real(dp), intent(in) :: series(0:), length
      !> The range.
      real(dp), intent(inout) :: low, high
      real(dp) :: value, left, right, a, b, t
      integer :: i

      low = min(low, series(0))
      high = max(high, series(0))
      left = series(1)
      do i = 1, 2
         a = (i - 1)*length/2
         b = i*length/2
         call polynomial(series, b, value, right)
         low = min(low, value)
         high = max(high, value)
         if (left < 0 .and. right > 0) then
            call root_between(series, a, b, .true., t)
            low = min(low, series_value(series, t))
         else if (left > 0 .and. right < 0) then
            call root_between(-series, a, b, .true., t)
            high = max(high, series_value(series, t))
         end if
         left = right
      end do
   end subroutine include

end module geartrain_flow_force_series
