!> First root of a polynomial in an interval, as where a Taylor series of the flow meets a wall.
module geartrain_linalg_first_root
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_bracket, only: newton_in_bracket
   implicit none (type, external)
   private
   public :: first_root, polynomial, root_between

   !> Parts of the interval at whose ends signs of value and slope are compared; a step of the flow spans about one oscillation.
   integer, parameter :: subdivisions = 8

contains

   !> First root in [0, h] at which a polynomial falls through zero; 0 where the polynomial is negative at 0.
   pure subroutine first_root(f, h, root, hit)
      !> Coefficients of the powers, (0:degree), degree at least 1; end of the interval.
      real(dp), intent(in) :: f(0:), h
      !> The root, 0 where there is none.
      real(dp), intent(out) :: root
      !> Whether there is a root.
      logical, intent(out) :: hit
      real(dp) :: a, b, fa, da, fb, db, t, ft, dt, span, most
      integer :: i

      root = 0
      hit = .true.
      if (f(0) < 0) return
      hit = .false.
      ! What all other terms together come to at most.
      most = abs(f(ubound(f, 1)))
      do i = ubound(f, 1) - 1, 1, -1
         most = most*h + abs(f(i))
      end do
      if (f(0) > most*h) return
      span = h/subdivisions
      a = 0
      fa = f(0)
      da = f(1)
      do i = 1, subdivisions
         b = i*span
         call polynomial(f, b, fb, db)
         if (fb < 0) then
            call root_between(f, a, b, .false., root)
            hit = .true.
            return
         end if
         if (da < 0 .and. db > 0 .and. min(fa, fb) < span*max(-da, db)) then
            call root_between(f, a, b, .true., t)
            call polynomial(f, t, ft, dt)
            if (ft < 0) then
               call root_between(f, a, t, .false., root)
               hit = .true.
               return
            end if
         end if
         a = b
         fa = fb
         da = db
      end do
   end subroutine first_root

   !> Root in [left, right] of f, which falls through zero in between, or of the slope of f, which rises through zero.
   pure subroutine root_between(f, left, right, of_slope, root)
      !> Coefficients of the powers, (0:degree); the bracket.
      real(dp), intent(in) :: f(0:), left, right
      !> Whether the root is that of the slope.
      logical, intent(in) :: of_slope
      !> The root.
      real(dp), intent(out) :: root
      real(dp) :: a, b, value, slope, curvature, new
      integer :: i

      a = left
      b = right
      root = (a + b)/2
      do i = 1, 60
         call polynomial(f, root, value, slope, curvature)
         if (of_slope) then
            call newton_in_bracket(root, slope, curvature, .false., a, b, new)
         else
            call newton_in_bracket(root, value, slope, .true., a, b, new)
         end if
         if (abs(new - root) <= 1e-16_dp + 2e-16_dp*abs(root)) exit
         root = new
      end do
   end subroutine root_between

   !> Value, slope and curvature of a polynomial by Horner's rule.
   pure subroutine polynomial(f, t, value, slope, curvature)
      !> Coefficients of the powers, (0:degree); argument.
      real(dp), intent(in) :: f(0:), t
      !> Value and derivatives.
      real(dp), intent(out) :: value, slope
      !> Second derivative.
      real(dp), intent(out), optional :: curvature
      real(dp) :: second
      integer :: k

      value = f(ubound(f, 1))
      slope = 0
      second = 0
      do k = ubound(f, 1) - 1, 0, -1
         second = second*t + slope
         slope = slope*t + value
         value = value*t + f(k)
      end do
      if (present(curvature)) curvature = 2*second
   end subroutine polynomial

end module geartrain_linalg_first_root
