!> Where the displacement of a mesh, a trigonometric polynomial (geartrain_linalg_trigonometric), crosses a wall of its force law or
!> turns back.
module geartrain_mesh_law_wall_crossing
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_trigonometric, only: evaluate
   implicit none (type, external)
   private
   public :: crossing, turning

contains

   !> Root of p - wall in [left, right] by Newton's method, kept in the bracket by bisection, from the root of the cubic with the
   !> values `f` of p - wall and the slopes at both ends. The values have different signs.
   pure real(dp) function crossing(u, harmonic, wall, left, right, f, slopes) result(theta)
      !> Coefficients, (1 + 2*harmonics); the wall; ends of the interval [rad]; values of p - wall and slopes there.
      real(dp), intent(in) :: u(:), wall, left, right, f(2), slopes(2)
      !> Harmonics, (harmonics).
      integer, intent(in) :: harmonic(:)
      real(dp) :: a, b, p, slope, curvature, new
      integer :: i

      a = left
      b = right
      theta = left + (right - left)*cubic_root(f, (right - left)*slopes)
      do i = 1, 60
         call evaluate(u, harmonic, theta, p, slope, curvature)
         if ((p - wall > 0) .eqv. (f(1) > 0)) then
            a = theta
         else
            b = theta
         end if
         new = (a + b)/2
         if (abs(slope)*(b - a) > abs(p - wall)) new = theta - (p - wall)/slope
         if (new < a .or. new > b) new = (a + b)/2
         if (abs(new - theta) < 4e-15_dp*(1 + abs(theta))) exit
         theta = new
      end do
   end function crossing

   !> Approximate root in [0, 1] of the cubic that has values of different signs, and slopes, at 0 and 1.
   pure real(dp) function cubic_root(f, slopes) result(x)
      real(dp), intent(in) :: f(2), slopes(2)
      real(dp) :: value, slope, second, third
      integer :: i

      second = 3*(f(2) - f(1)) - 2*slopes(1) - slopes(2)
      third = slopes(1) + slopes(2) - 2*(f(2) - f(1))
      x = f(1)/(f(1) - f(2))
      do i = 1, 3
         value = f(1) + x*(slopes(1) + x*(second + x*third))
         slope = slopes(1) + x*(2*second + 3*x*third)
         if (.not. abs(slope) > abs(value)) return
         x = min(max(x - value/slope, 0.0_dp), 1.0_dp)
      end do
   end function cubic_root

   !> Finds the extreme of p in [left, right], at whose ends the slope has different signs, and p - wall at the extreme.
   pure subroutine turning(u, harmonic, wall, left, right, theta, f)
      !> Coefficients, (1 + 2*harmonics); the wall; ends of the interval [rad].
      real(dp), intent(in) :: u(:), wall, left, right
      !> Harmonics, (harmonics).
      integer, intent(in) :: harmonic(:)
      !> The extreme [rad], and p - wall there.
      real(dp), intent(out) :: theta, f
      real(dp) :: a, b, p, slope, curvature, slope_left, new
      integer :: i

      a = left
      b = right
      call evaluate(u, harmonic, a, p, slope_left, curvature)
      theta = (a + b)/2
      do i = 1, 60
         call evaluate(u, harmonic, theta, p, slope, curvature)
         f = p - wall
         if ((slope > 0) .eqv. (slope_left > 0)) then
            a = theta
         else
            b = theta
         end if
         new = (a + b)/2
         if (abs(curvature)*(b - a) > abs(slope)) new = theta - slope/curvature
         if (new < a .or. new > b) new = (a + b)/2
         if (abs(new - theta) < 1e-12_dp) exit
         theta = new
      end do
   end subroutine turning

end module geartrain_mesh_law_wall_crossing
