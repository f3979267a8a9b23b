!> How near multipliers come to the unit circle between places along a branch at which they are known.
!>
!> Of each kind of crossing the distance from the circle of the multiplier next to it is a function along the branch. Parabolas
!> through three samples estimate how near to the circle it comes between them. The uncertainty of the estimate is a share of what
!> the function varies by at the samples.
module geartrain_trace_circle_samples
   use geartrain_base_kinds, only: dp
   use geartrain_trace_stability_changes, only: doubling, neimark_sacker
   implicit none (type, external)
   private
   public :: distance_of, far, most_places, none, samples_type

   !> Distance from the circle of a multiplier at both ends of a step beyond which it does not cross within the step.
   real(dp), parameter :: far = 0.3_dp
   !> Most multipliers that are computed within a step for each kind and sense; places at which a parabola is looked at; samples.
   integer, parameter :: most_places = 4, places = 16, most_samples = 60
   !> Least distance of a place from the ends, as a share of the interval.
   real(dp), parameter :: off_ends = 0.1_dp
   !> Value of the function where there is no multiplier of the kind.
   real(dp), parameter :: none = -huge(1.0_dp)

   !> The function at places along a step.
   type :: samples_type
      integer :: taken = 0
      !> Distance from the beginning of the step; value, ascending by distance.
      real(dp) :: at(most_samples) = 0, f(most_samples) = 0
   contains
      procedure :: insert
      procedure :: highest
      procedure :: reach_circle
   end type samples_type

contains

   !> Adds a sample.
   pure subroutine insert(self, at, f)
      class(samples_type), intent(inout) :: self
      !> Distance from the beginning of the step [1].
      real(dp), intent(in) :: at
      !> Value.
      real(dp), intent(in) :: f
      integer :: n

      n = count(self%at(:self%taken) < at)
      self%at(n + 2:self%taken + 1) = self%at(n + 1:self%taken)
      self%f(n + 2:self%taken + 1) = self%f(n + 1:self%taken)
      self%at(n + 1) = at
      self%f(n + 1) = f
      self%taken = self%taken + 1
   end subroutine insert

   !> The place in the step at which the parabolas through three samples in a row are highest.
   pure subroutine highest(self, length, s, peak, varies)
      class(samples_type), intent(in) :: self
      !> Length of the step [1].
      real(dp), intent(in) :: length
      !> Distance of the place from the beginning of the step [1]; value there.
      real(dp), intent(out) :: s, peak
      !> By how much the two samples on both sides of the place differ.
      real(dp), intent(out), optional :: varies
      real(dp) :: x, value
      integer :: j, k, n

      peak = none
      s = length/2
      do j = 1, self%taken - 1
         associate (a => self%at(j), b => self%at(j + 1))
            if (a < 0 .or. b > length .or. .not. b > a) cycle
            do n = 1, places - 1
               x = a + (b - a)*(off_ends + (1 - 2*off_ends)*n/places)
               do k = max(1, j - 1), min(j, self%taken - 2)
                  value = parabola(self%at(k:k + 2), self%f(k:k + 2), x)
                  if (value <= peak) cycle
                  peak = value
                  s = x
                  if (present(varies)) varies = abs(self%f(j + 1) - self%f(j))
               end do
            end do
         end associate
      end do
   end subroutine highest

   !> The parabola through three points.
   pure real(dp) function parabola(at, f, x)
      real(dp), intent(in) :: at(3), f(3), x
      real(dp) :: first, second

      first = (f(2) - f(1))/(at(2) - at(1))
      second = ((f(3) - f(2))/(at(3) - at(2)) - first)/(at(3) - at(1))
      parabola = f(1) + (x - at(1))*(first + (x - at(2))*second)
   end function parabola

   !> How far a multiplier is outside the circle, negative inside; the farthest one has number 1; -none: there is none. Where a real
   !> one crosses a pair counts as well, with its distance from -1, or +1: it may become real between two points.
   pure real(dp) function distance_of(multipliers, kind, number) result(distance)
      !> Multipliers, (state).
      complex(dp), intent(in) :: multipliers(:)
      !> Kind of the crossing, `doubling`, `neimark_sacker` or `above_one`; number of the multiplier.
      integer, intent(in) :: kind, number
      real(dp) :: value(size(multipliers)), place
      integer :: i, n

      n = number
      if (kind == neimark_sacker) n = 2*number - 1
      place = merge(-1, 1, kind == doubling)
      do i = 1, size(multipliers)
         associate (mu => multipliers(i))
            if (abs(mu%im) <= 0) then
               value(i) = place*mu%re - 1
               if (kind == neimark_sacker) value(i) = none
            else if (kind == neimark_sacker) then
               value(i) = abs(mu) - 1
            else
               value(i) = -abs(mu - place)
            end if
         end associate
      end do
      do i = 1, n - 1
         value(maxloc(value, 1)) = none
      end do
      distance = maxval(value)
   end function distance_of

   !> Whether the circle may be reached within the step.
   pure logical function reach_circle(self, length, uncertain, near)
      class(samples_type), intent(in) :: self
      !> Length of the step [1]; uncertainty of the estimate, as a share of what the function varies by [1].
      real(dp), intent(in) :: length, uncertain
      !> The function was computed where it may be highest: it varies by what the samples next to the place differ by, else by what
      !> all do.
      logical, intent(in) :: near
      real(dp) :: s, peak, varies

      reach_circle = self%taken > 2 .and. length > 0
      if (.not. reach_circle) return
      varies = 0
      call self%highest(length, s, peak, varies)
      if (.not. near) varies = maxval(self%f(:self%taken)) - minval(self%f(:self%taken))
      reach_circle = peak + uncertain*varies > 0
   end function reach_circle

end module geartrain_trace_circle_samples
