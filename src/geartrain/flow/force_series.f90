!> Taylor series over a step of the flow: of the force of a mesh; extremes and integrals of any.
module geartrain_flow_force_series
   use geartrain_base_kinds, only: dp
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_taylor, only: series_value
   use geartrain_linalg_first_root, only: polynomial, root_between
   implicit none (type, external)
   private
   public :: energy_loss, force_series, include, integral, integral_of_square

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

   !> Integral of a Taylor series over a step.
   pure real(dp) function integral(series, length)
      !> Taylor coefficients, (0:order); length of the step [1].
      real(dp), intent(in) :: series(0:), length
      integer :: k

      integral = 0
      do k = ubound(series, 1), 0, -1
         integral = integral*length + series(k)/(k + 1)
      end do
      integral = integral*length
   end function integral

   !> Integral of the square of a Taylor series over a step.
   pure real(dp) function integral_of_square(series, length) result(total)
      !> Taylor coefficients, (0:order); length of the step [1].
      real(dp), intent(in) :: series(0:), length
      real(dp) :: term(0:ubound(series, 1))
      integer :: k, l, n

      n = ubound(series, 1)
      ! Times powers of the length: products of the coefficients alone overflow where a step is short.
      term = series*length**[(k, k=0, n)]
      total = 0
      do k = 2*n, 0, -1
         total = total + sum([(term(l)*term(k - l), l=max(0, k - n), min(k, n))])/(k + 1)
      end do
      total = length*total
   end function integral_of_square

   !> Energy that a mesh loses over the latest step [J].
   pure real(dp) function energy_loss(flow, mesh, region)
      !> The flow, after a step.
      type(flow_type), intent(in) :: flow
      !> Number of the mesh; region of its law during the step.
      integer, intent(in) :: mesh, region
      integer :: i

      energy_loss = flow%system%law(mesh)%damping(region) &
                    *integral_of_square(flow%v(1, flow%system%mesh_element(mesh), :), flow%length)
      ! A force that sticks does no work, and a slipping one is constant.
      do i = 1, flow%friction%count
         if (flow%friction%mesh(i) /= mesh) cycle
         energy_loss = energy_loss + flow%friction%force(0, i)*(flow%displacement(mesh, flow%length) &
                                                                - flow%displacement(mesh, 0.0_dp))
      end do
      energy_loss = flow%system%energy_unit(mesh)*energy_loss
   end function energy_loss

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
