!> Locates what a reader looks for on a branch between two neighbouring points: folds and changes of stability.
module geartrain_branch_special_points
   use geartrain_base_kinds, only: dp
   use geartrain_branch_bend, only: odd_product
   use geartrain_branch_branch, only: branch_type, special_point_type
   use geartrain_branch_path, only: path_type, place_type
   use geartrain_stability_monodromy, only: monodromy_type, neutral
   implicit none (type, external)
   private
   public :: locate_fold, locate_half_period, add_special_point, add_stability_change
   public :: between, shrink

   integer, parameter :: max_steps = 30

contains

   !> The place between `here` and the point a distance h further where Lambda turns, to 1e-6 of the step, and how far it is.
   subroutine locate_fold(path, here, next, h, fold, s, success)
      type(path_type), intent(inout) :: path
      type(place_type), intent(in) :: here, next
      real(dp), intent(in) :: h
      type(place_type), intent(inout) :: fold
      real(dp), intent(out) :: s
      logical, intent(out) :: success
      real(dp) :: a, b, fa, fb
      integer :: i, kept

      kept = 0
      a = 0
      b = h
      fa = here%tangent_frequency
      fb = next%tangent_frequency
      do i = 1, max_steps
         s = between(a, b, fa, fb)
         call path%advance(here, s, fold, success)
         if (.not. success) return
         if (abs(fold%tangent_frequency) < 1e-7_dp*path%units%frequency) return
         call shrink(a, b, fa, fb, s, fold%tangent_frequency, kept)
         if (b - a < 1e-6_dp*h) return
      end do
   end subroutine locate_fold

   !> The place between `here` and the point `next` a distance h further where the odd harmonics vanish: there the branch meets that
   !> of half its period. Newton's method fails next to it, since the matrix is singular there: then the rest is a straight line.
   subroutine locate_half_period(path, here, next, h, place)
      type(path_type), intent(inout) :: path
      type(place_type), intent(in) :: here, next
      real(dp), intent(in) :: h
      type(place_type), intent(inout) :: place
      type(place_type) :: first, last
      real(dp) :: a, b, fa, fb, f, s, share
      integer :: i, kept
      logical :: success

      kept = 0
      a = 0
      b = h
      fa = odd_product(here, here)
      fb = odd_product(here, next)
      first = here
      last = next
      do i = 1, max_steps
         s = between(a, b, fa, fb)
         call path%advance(here, s, place, success)
         if (.not. success) exit
         f = odd_product(here, place)
         if (f > 0) then
            first = place
         else
            last = place
         end if
         call shrink(a, b, fa, fb, s, f, kept)
         if (b - a < 1e-6_dp*h) exit
      end do
      share = odd_product(here, first)/(odd_product(here, first) - odd_product(here, last))
      place = first
      place%u = first%u + share*(last%u - first%u)
      place%frequency = first%frequency + share*(last%frequency - first%frequency)
   end subroutine locate_half_period

   !> Where the stability changed between point `before` of the branch and the next one, other than by a fold at either of them:
   !> locates the change and puts it on the list. They lie the distances `a` and `b` from `here`, along its tangent.
   subroutine add_stability_change(path, monodromy, here, a, b, before, branch)
      type(path_type), intent(inout) :: path
      type(monodromy_type), intent(inout) :: monodromy
      type(place_type), intent(in) :: here
      real(dp), intent(in) :: a, b
      integer, intent(in) :: before
      type(branch_type), intent(inout), target :: branch
      type(place_type) :: place
      character(16) :: kind
      integer :: change
      logical :: success, next_to_fold

      associate (first => branch%multipliers(:, before), last => branch%multipliers(:, before + 1))
         change = unstable_count(last) - unstable_count(first)
         if (doubling_test(first)*doubling_test(last) >= 0) then
            if (change == 0) return
            next_to_fold = any(branch%special_points%kind == 'fold' .and. (branch%special_points%point == before &
                                                                           .or. branch%special_points%point == before + 1))
            ! Of the fold.
            if (next_to_fold .and. abs(change) == 1) return
         end if
         call locate_stability_change(path, monodromy, here, a, b, first, last, place, kind, success)
      end associate
      if (.not. success) return
      if (kind == 'symmetry') then
         ! A truncated balance and its monodromy place one fold slightly apart: that is no change of its own.
         if (any(branch%special_points%kind == 'fold' .and. branch%special_points%point > branch%points - 6)) return
         if (abs(place%tangent_frequency) < 0.1_dp*path%units%frequency) return
      end if
      call add_special_point(branch, kind, place%frequency, before, branch%rms(:, before + 1))
   end subroutine add_stability_change

   !> Number of multipliers outside the unit circle.
   pure integer function unstable_count(multipliers)
      complex(dp), intent(in) :: multipliers(:)

      unstable_count = count(abs(multipliers) >= 1 - neutral)
   end function unstable_count

   !> det(M + I) but for complex multipliers, of which a leading one may lack its conjugate: changes sign where a real multiplier
   !> passes -1, whatever the others do.
   pure real(dp) function doubling_test(multipliers)
      complex(dp), intent(in) :: multipliers(:)

      doubling_test = product(merge(1 + multipliers%re, abs(1 + multipliers), abs(multipliers%im) <= 0))
   end function doubling_test

   !> The place at a distance between `from` and `to` from `here` where a multiplier passes -1, or else where the number of
   !> multipliers outside the unit circle changes, to 1e-4 of the way, and what kind of change it is.
   subroutine locate_stability_change(path, monodromy, here, from, to, multipliers_from, multipliers_to, place, kind, success)
      type(path_type), intent(inout) :: path
      type(monodromy_type), intent(inout) :: monodromy
      type(place_type), intent(in) :: here
      real(dp), intent(in) :: from, to
      complex(dp), intent(in) :: multipliers_from(:), multipliers_to(:)
      type(place_type), intent(inout) :: place
      character(*), intent(out) :: kind
      logical, intent(out) :: success
      complex(dp) :: multipliers(size(multipliers_from)), crossing
      real(dp) :: a, b, fa, fb, f, s
      integer :: i, critical, kept
      logical :: doubles

      ! Sorted by magnitude, the multiplier with this index is the one that crosses.
      critical = max(unstable_count(multipliers_from), unstable_count(multipliers_to))
      doubles = doubling_test(multipliers_from)*doubling_test(multipliers_to) < 0
      kept = 0
      a = from
      b = to
      fa = passing(multipliers_from, critical, doubles)
      fb = passing(multipliers_to, critical, doubles)
      do i = 1, max_steps
         s = between(a, b, fa, fb)
         call path%advance(here, s, place, success)
         if (.not. success) return
         call monodromy%integrate(path%balance, place%frequency)
         call monodromy%multipliers(multipliers)
         f = passing(multipliers, critical, doubles)
         call shrink(a, b, fa, fb, s, f, kept)
         if (abs(f) < 1e-7_dp .or. b - a < 1e-4_dp*(to - from)) exit
      end do
      kind = 'period doubling'
      if (doubles) return
      crossing = multipliers(critical)
      if (abs(crossing%im) < 1e-6_dp .and. crossing%re < 0) return
      kind = 'torus'
      if (abs(crossing%im) < 1e-6_dp) kind = 'symmetry'
   end subroutine locate_stability_change

   !> Zero at the change: how far the multiplier number `critical` is outside the unit circle, or the test of a doubling.
   pure real(dp) function passing(multipliers, critical, doubles)
      complex(dp), intent(in) :: multipliers(:)
      integer, intent(in) :: critical
      logical, intent(in) :: doubles

      if (doubles) then
         passing = doubling_test(multipliers)
      else
         passing = abs(multipliers(critical)) - (1 - neutral)
      end if
   end function passing

   !> Where the chord crosses zero, kept off the ends of the bracket.
   pure real(dp) function between(a, b, fa, fb)
      real(dp), intent(in) :: a, b, fa, fb

      between = a + (b - a)*min(0.999_dp, max(0.001_dp, fa/(fa - fb)))
   end function between

   !> Illinois' variant of regula falsi: the value at an end that stays a second time is halved. `kept` is the end that stayed
   !> before, -1 for a and +1 for b, 0 at first.
   pure subroutine shrink(a, b, fa, fb, s, f, kept)
      real(dp), intent(inout) :: a, b, fa, fb
      real(dp), intent(in) :: s, f
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

   !> Puts it on the list of the branch, which goes along it; `point` is the index of the point before it, or of the fold itself.
   subroutine add_special_point(branch, kind, frequency, point, rms)
      type(branch_type), intent(inout) :: branch
      character(*), intent(in) :: kind
      real(dp), intent(in) :: frequency, rms(:)
      integer, intent(in) :: point
      type(special_point_type) :: special
      integer :: n

      special%kind = kind
      special%frequency = frequency
      special%point = point
      special%rms = rms
      n = count(branch%special_points%point <= point)
      branch%special_points = [branch%special_points(:n), special, branch%special_points(n + 1:)]
   end subroutine add_special_point

end module geartrain_branch_special_points
