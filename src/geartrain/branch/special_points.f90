!> Locates what a reader looks for on a branch between two neighbouring points: folds and changes of stability.
module geartrain_branch_special_points
   use geartrain_base_kinds, only: dp
   use geartrain_branch_bend, only: odd_product
   use geartrain_branch_branch, only: branch_type, special_point_type
   use geartrain_branch_path, only: path_type, place_type
   use geartrain_stability_monodromy, only: monodromy_type, neutral
   implicit none (type, external)
   private
   public :: locate_fold, locate_half_period, locate_stability_change, add_special_point, unstable_count
   public :: between, shrink

   integer, parameter :: max_steps = 30

contains

   !> The place between `here` and the point a distance h further where Lambda turns, to 1e-6 of the step.
   subroutine locate_fold(path, here, next, h, fold, success)
      type(path_type), intent(inout) :: path
      type(place_type), intent(in) :: here, next
      real(dp), intent(in) :: h
      type(place_type), intent(inout) :: fold
      logical, intent(out) :: success
      real(dp) :: a, b, fa, fb, s
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

   !> The place between `here` and the point a distance h further where the odd harmonics vanish: there the branch meets that of
   !> half its period, to 1e-6 of what they are `here`.
   subroutine locate_half_period(path, here, next, h, place, success)
      type(path_type), intent(inout) :: path
      type(place_type), intent(in) :: here, next
      real(dp), intent(in) :: h
      type(place_type), intent(inout) :: place
      logical, intent(out) :: success
      real(dp) :: a, b, fa, fb, f, s, scale
      integer :: i, kept

      kept = 0
      a = 0
      b = h
      scale = odd_product(here, here)
      fa = scale
      fb = odd_product(here, next)
      do i = 1, max_steps
         s = between(a, b, fa, fb)
         call path%advance(here, s, place, success)
         if (.not. success) return
         f = odd_product(here, place)
         if (abs(f) < 1e-6_dp*scale) return
         call shrink(a, b, fa, fb, s, f, kept)
      end do
   end subroutine locate_half_period

   !> Number of multipliers outside the unit circle.
   pure integer function unstable_count(multipliers)
      complex(dp), intent(in) :: multipliers(:)

      unstable_count = count(abs(multipliers) >= 1 - neutral)
   end function unstable_count

   !> The place where the number of multipliers outside the unit circle changes from `count_here` to `count_next`, to 1e-4 of the
   !> step, and what kind of change it is.
   subroutine locate_stability_change(path, monodromy, here, h, multipliers_here, multipliers_next, place, kind, success)
      type(path_type), intent(inout) :: path
      type(monodromy_type), intent(inout) :: monodromy
      type(place_type), intent(in) :: here
      real(dp), intent(in) :: h
      complex(dp), intent(in) :: multipliers_here(:), multipliers_next(:)
      type(place_type), intent(inout) :: place
      character(*), intent(out) :: kind
      logical, intent(out) :: success
      complex(dp) :: multipliers(size(multipliers_here)), crossing
      real(dp) :: a, b, fa, fb, f, s
      integer :: i, critical, kept

      ! Sorted by magnitude, the multiplier with this index is the one that crosses.
      critical = max(unstable_count(multipliers_here), unstable_count(multipliers_next))
      kept = 0
      a = 0
      b = h
      fa = abs(multipliers_here(critical)) - (1 - neutral)
      fb = abs(multipliers_next(critical)) - (1 - neutral)
      do i = 1, max_steps
         s = between(a, b, fa, fb)
         call path%advance(here, s, place, success)
         if (.not. success) return
         call monodromy%integrate(path%balance, place%frequency)
         call monodromy%multipliers(multipliers)
         crossing = multipliers(critical)
         f = abs(crossing) - (1 - neutral)
         call shrink(a, b, fa, fb, s, f, kept)
         if (abs(f) < 1e-7_dp .or. b - a < 1e-4_dp*h) exit
      end do
      kind = 'torus'
      if (abs(crossing%im) < 1e-6_dp .and. crossing%re < 0) kind = 'period doubling'
      if (abs(crossing%im) < 1e-6_dp .and. crossing%re > 0) kind = 'symmetry'
   end subroutine locate_stability_change

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

   !> Appends to the list of the branch; `point` is the index of the point before it, or of the fold itself.
   subroutine add_special_point(branch, kind, frequency, point, rms)
      type(branch_type), intent(inout) :: branch
      character(*), intent(in) :: kind
      real(dp), intent(in) :: frequency, rms(:)
      integer, intent(in) :: point
      type(special_point_type) :: special

      special%kind = kind
      special%frequency = frequency
      special%point = point
      special%rms = rms
      branch%special_points = [branch%special_points, special]
   end subroutine add_special_point

end module geartrain_branch_special_points
