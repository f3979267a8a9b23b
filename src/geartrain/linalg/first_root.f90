!> The first root of a polynomial in an interval: where a Taylor series of the flow meets a wall.
module geartrain_linalg_first_root
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: first_root

   !> Parts of the interval in which signs of value and slope are looked at; a step spans about one oscillation.
   integer, parameter :: subdivisions = 8

contains

   !> The first root in [0, h] of a polynomial that is positive before it.
   pure subroutine first_root(f, h, root, hit)
      real(dp), intent(in) :: f(0:), h
      real(dp), intent(out) :: root
      logical, intent(out) :: hit
      real(dp) :: a, b, fa, da, fb, db, t, ft, dt, span
      integer :: i

      root = 0
      hit = .true.
      if (f(0) < 0) return
      hit = .false.
      span = h/subdivisions
      a = 0
      fa = f(0)
      da = f(1)
      do i = 1, subdivisions
         b = i*span
         call polynomial(f, b, fb, db)
         if (fb < 0) then
            call bracketed(f, a, b, .false., root)
            hit = .true.
            return
         end if
         if (da < 0 .and. db > 0 .and. min(fa, fb) < span*max(-da, db)) then
            call bracketed(f, a, b, .true., t)
            call polynomial(f, t, ft, dt)
            if (ft < 0) then
               call bracketed(f, a, t, .false., root)
               hit = .true.
               return
            end if
         end if
         a = b
         fa = fb
         da = db
      end do
   end subroutine first_root

   !> Root in [left, right] of f, which falls through zero there, or of its slope, which rises through zero there.
   pure subroutine bracketed(f, left, right, of_slope, root)
      real(dp), intent(in) :: f(0:), left, right
      logical, intent(in) :: of_slope
      real(dp), intent(out) :: root
      real(dp) :: a, b, value, slope, curvature, new
      integer :: i

      a = left
      b = right
      root = (a + b)/2
      do i = 1, 60
         if (of_slope) then
            call polynomial(f, root, new, value, slope)
            value = -value
            slope = -slope
         else
            call polynomial(f, root, value, slope, curvature)
         end if
         if (value > 0) then
            a = root
         else
            b = root
         end if
         new = (a + b)/2
         if (slope < 0) new = root - value/slope
         if (new < a .or. new > b) new = (a + b)/2
         if (abs(new - root) <= 1e-16_dp + 2e-16_dp*abs(root)) exit
         root = new
      end do
   end subroutine bracketed

   !> Value, slope and curvature of a polynomial by Horner's rule.
   pure subroutine polynomial(f, t, value, slope, curvature)
      real(dp), intent(in) :: f(0:), t
      real(dp), intent(out) :: value, slope
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
