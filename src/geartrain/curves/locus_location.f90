!> Where the motions of the curve of a special point change their kind: they graze a wall of a gap, or become motions of half the
!> period. Newton's method fails there, so that the place is extrapolated to.
module geartrain_curves_locus_location
   use geartrain_base_kinds, only: dp
   use geartrain_curves_locus_half_period, only: change_after_half, way_to_half
   use geartrain_curves_locus_walls, only: from_wall
   use geartrain_exact_augmented_point, only: augmented_point_type
   use geartrain_exact_augmented_system, only: augmented_system_type
   implicit none (type, external)
   private
   public :: locate_grazing, locate_half, located, most_steps, nearest_half

   !> Most steps towards a point where two conditions meet, and its error.
   integer, parameter :: most_steps = 60
   real(dp), parameter :: located = 1e-10_dp
   !> Length of the piece of the curve before a grazing by which is extrapolated to it.
   real(dp), parameter :: extrapolated = 1e-4_dp
   !> Half the length of the bracket of a grazing from which on is extrapolated to it.
   real(dp), parameter :: beside_grazing = extrapolated/20
   !> Way before motions of half the period from which is extrapolated to them at first, and the least.
   real(dp), parameter :: beside_half = 0.016_dp, nearest_half = 1e-4_dp
   !> Difference of two such extrapolations that is small enough, in Lambda and in the parameter over the way of the curve.
   real(dp), parameter :: agreed = 1e-6_dp
   !> Error of the squares of a change that is taken as an even function of the way, over their value.
   real(dp), parameter :: even = 0.05_dp

contains

   !> Locates where the number of contact events changes between `here` and `next`, from the side with the fewer: on the other
   !> one the motion leaves the wall by the square of the way, and its first events are lost in rounding.
   subroutine locate_grazing(augmented, here, next, point)
      !> The system of the special point.
      type(augmented_system_type), intent(inout) :: augmented
      !> Points of the curve on either side, with their tangents.
      type(augmented_point_type), intent(in) :: here, next
      !> Lambda and parameter of the grazing.
      type(augmented_point_type), intent(inout) :: point
      type(augmented_point_type) :: base
      real(dp) :: a, b
      integer :: sense
      logical :: success

      sense = merge(1, -1, here%events < next%events)
      base = here
      if (sense < 0) base = next
      a = 0
      b = augmented%metric%distance(here, next)
      point = base
      call narrow(augmented, base, sense, beside_grazing, a, b, point)
      call extrapolate(augmented, base, sense*a, sense*extrapolated, point, success, by_half=.false.)
      if (.not. success) call narrow(augmented, base, sense, located, a, b, point)
   end subroutine locate_grazing

   !> Narrows the bracket of a grazing: by the way at which the distance from the wall would be 0, else and every third time by
   !> half, as another extreme may be the nearest.
   subroutine narrow(augmented, base, sense, width, a, b, last)
      type(augmented_system_type), intent(inout) :: augmented
      !> Point with the fewer events, with its tangent; sense in which the grazing is.
      type(augmented_point_type), intent(in) :: base
      integer, intent(in) :: sense
      !> Half the length of the bracket that is wanted.
      real(dp), intent(in) :: width
      !> The bracket, ways from the base; the point at a.
      real(dp), intent(inout) :: a, b
      type(augmented_point_type), intent(inout) :: last
      type(augmented_point_type) :: middle
      real(dp) :: way(2), gap(2), s, aim
      integer :: i
      logical :: success

      way = 0
      gap = 0
      do i = 1, most_steps
         if (b - a <= 2*width) exit
         s = (a + b)/2
         if (gap(1) > gap(2) .and. mod(i, 3) > 0) then
            aim = way(2) + gap(2)*(way(2) - way(1))/(gap(1) - gap(2))
            aim = aim + merge(width, -width, aim - a < width)
            if (aim > a .and. aim < b) s = aim
         end if
         call augmented%advance(base, sense*s, middle, success, roughly=.true.)
         if (success) success = middle%events == base%events
         if (.not. success) then
            b = s
            cycle
         end if
         a = s
         last = middle
         way = [way(2), a]
         gap = [gap(2), from_wall(augmented, middle)]
      end do
   end subroutine narrow

   !> Lambda and parameter of a grazing, a way from a point with the fewer events, by points before it, each a step from the
   !> other, as polynomials in their distance from the wall. Unchanged where these do not lead to the wall, or to one far away:
   !> then another extreme is nearer to a wall than the one that grazes. Or those of a doubling of half the period, as
   !> polynomials in the square of the change after half the period.
   subroutine extrapolate(augmented, base, way, step, point, success, by_half)
      type(augmented_system_type), intent(inout) :: augmented
      type(augmented_point_type), intent(in) :: base
      real(dp), intent(in) :: way, step
      type(augmented_point_type), intent(inout) :: point
      logical, intent(out) :: success
      logical, intent(in) :: by_half
      type(augmented_point_type) :: before(3)
      real(dp) :: aside(3), weight(3), frequency_ratio, parameter
      integer :: i

      do i = 1, 3
         call augmented%advance(base, way - i*step, before(i), success, roughly=.not. by_half)
         if (success) success = before(i)%events == base%events
         if (.not. success) return
         if (by_half) then
            aside(i) = sum(change_after_half(before(i)%states)**2)
         else
            aside(i) = from_wall(augmented, before(i))
         end if
      end do
      success = aside(1) < aside(2) .and. aside(2) < aside(3)
      if (by_half) success = all(abs(aside(2:)/aside(1) - [4, 9]) < even*[4, 9])
      if (.not. success) return
      do i = 1, 3
         weight(i) = product(pack(aside, [1, 2, 3] /= i)/(pack(aside, [1, 2, 3] /= i) - aside(i)))
      end do
      frequency_ratio = dot_product(weight, before%frequency_ratio)
      parameter = dot_product(weight, before%parameter)
      success = abs(parameter - before(1)%parameter) < 2*abs(step) .and. &
                abs(frequency_ratio - before(1)%frequency_ratio) < 2*abs(step)*augmented%metric%units%frequency_ratio
      if (.not. success) return
      if (by_half) point = before(1)
      point%frequency_ratio = frequency_ratio
      point%parameter = parameter
   end subroutine extrapolate

   !> Locates where the motions of a curve of folds of an even period become those of half the period, at a doubling of these. Both
   !> curves meet there, and Newton's method fails. Beyond it are the same motions half a period later, so that Lambda and the
   !> parameter are even functions of the way, unless the motion grazes a wall there.
   subroutine locate_half(augmented, here, point, success)
      !> The system of the special point.
      type(augmented_system_type), intent(inout) :: augmented
      !> A fold before, with its tangent.
      type(augmented_point_type), intent(in) :: here
      !> Lambda and parameter of the doubling; the states are those of a fold next to it.
      type(augmented_point_type), intent(inout) :: point
      !> Whether it is located.
      logical, intent(out) :: success
      type(augmented_point_type) :: beside, nearer, met
      real(dp) :: step, before(2), change, least

      beside = here
      step = beside_half
      before = huge(1.0_dp)
      least = agreed
      ! From afar the way is no parabola, next to it Newton's method is not exact: where it changes least from step to step.
      do while (step > nearest_half)
         call augmented%advance(beside, way_to_half(beside) - step, nearer, success)
         if (.not. success) exit
         beside = nearer
         call extrapolate(augmented, beside, way_to_half(beside), step, met, success, by_half=.true.)
         if (success) then
            change = maxval(abs([met%frequency_ratio, met%parameter] - before))
            if (change < least) point = met
            least = min(least, change)
            before = [met%frequency_ratio, met%parameter]
         end if
         step = step/2
      end do
      success = least < agreed
   end subroutine locate_half

end module geartrain_curves_locus_location
