!> Steps towards a root in a bracket [a, b], at whose ends a function has different signs: Newton's method where there is a
!> derivative, else regula falsi.
module geartrain_linalg_bracket
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: between, newton_in_bracket, shrink

contains

   !> A step of Newton's method; the middle of the bracket where the slope has the wrong sign or the step would leave the bracket.
   pure subroutine newton_in_bracket(x, f, slope, falls, a, b, next)
      !> Place in the bracket; function and derivative there.
      real(dp), intent(in) :: x, f, slope
      !> Whether the function is positive at a, else at b.
      logical, intent(in) :: falls
      !> The bracket, which is narrowed to [x, b] or [a, x].
      real(dp), intent(inout) :: a, b
      !> Next place.
      real(dp), intent(out) :: next

      if (merge(f, -f, falls) > 0) then
         a = x
      else
         b = x
      end if
      next = (a + b)/2
      if (merge(-slope, slope, falls) > 0) next = x - f/slope
      if (next < a .or. next > b) next = (a + b)/2
   end subroutine newton_in_bracket

   !> Place where the chord crosses zero, kept off the ends of the bracket.
   pure real(dp) function between(a, b, fa, fb)
      !> The bracket, and the function at its ends as `shrink` has changed it.
      real(dp), intent(in) :: a, b, fa, fb

      between = a + (b - a)*min(0.999_dp, max(0.001_dp, fa/(fa - fb)))
   end function between

   !> Narrows the bracket by Illinois' variant of regula falsi: the value at an end that stays for the second time is halved.
   pure subroutine shrink(a, b, fa, fb, s, f, kept)
      !> The bracket, and the function at its ends.
      real(dp), intent(inout) :: a, b, fa, fb
      !> Place in the bracket; function there.
      real(dp), intent(in) :: s, f
      !> End of the bracket that stayed in the step before: -1: a, 1: b, 0 at first.
      integer, intent(inout) :: kept

      if ((f > 0) .eqv. (fa > 0)) then
         a = s
         fa = f
         if (kept == 1) fb = fb/2
         kept = 1
      else
         b = s
         fb = f
         if (kept == -1) fa = fa/2
         kept = -1
      end if
   end subroutine shrink

end module geartrain_linalg_bracket
