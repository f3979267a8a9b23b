!> Changes of stability within a step of a branch: by how many multipliers are outside the unit circle at both ends and, within long
!> steps, at places between them; and, where they are as many, by how near to the circle they come between those places. The first
!> place is the middle; more follow on a side of it where multipliers are not as far from the circle as the ends of that side tell.
module geartrain_trace_probed_changes
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_base_kinds, only: dp
   use geartrain_floquet_monodromy, only: monodromy_type
   use geartrain_floquet_multipliers, only: are_numbers, side_of_fold
   use geartrain_trace_branch, only: branch_type, multipliers_at
   use geartrain_trace_circle_samples, only: distance_of, far, none, samples_type
   use geartrain_trace_corrector, only: corrector_type, solution_point_type
   use geartrain_trace_stability_changes, only: above_one, doubling, find_multipliers, hides_pair, &
      largest_multiplier, neimark_sacker, outside, piece_type, separate
   use geartrain_trace_step_geometry, only: arc_length, cosine, go_along, sense_of
   use geartrain_trace_step_length, only: curve_limit
   implicit none (type, external)
   private
   public :: add_stability_changes

   !> Distance in Lambda of places in a step [units_type], length of the branch between them [1], and angle by which it turns [rad],
   !> at which multipliers are computed if at an end of the step one is within `far` of the circle; most places.
   real(dp), parameter :: spacing = 0.025_dp, length_between = 0.05_dp, turn = 0.25_dp
   integer, parameter :: most_probes = 63
   !> Distance of a multiplier in the middle from the mean of both ends, over its distance from the circle, up to which no further
   !> places are looked at [1].
   real(dp), parameter :: as_told = 0.25_dp
   !> Uncertainty of an estimate between these places, as a share of the variation of the distance from the circle: a pair that
   !> becomes real moves with the square root of the length from there.
   real(dp), parameter :: uncertain = 0.5_dp
   !> Distance of the branch from the cubic from which on a step is refused that was accepted by its estimate, over the estimate up
   !> to which it is.
   real(dp), parameter :: off_cubic = 5
   !> Most places at which multipliers are computed to see whether they cross the circle between those places, for each kind and
   !> sense, and in all.
   integer, parameter :: looks = 6, most_looks = 6*looks

   !> Places along a step.
   type :: places_type
      integer :: taken = 0
      !> Distances from the beginning of the step [1], ascending.
      real(dp), allocatable :: at(:)
      !> Multipliers there, (state, place).
      complex(dp), allocatable :: multipliers(:, :)
      !> They are those of the cubic through the ends of the step, not of a solution.
      logical, allocatable :: rough(:)
   contains
      procedure :: insert
      procedure :: drop
   end type places_type

contains

   !> Lists the changes of stability between two neighbouring points of a branch as special points.
   subroutine add_stability_changes(corrector, monodromy, here, next, before, after, branch, hidden)
      type(corrector_type), intent(inout) :: corrector
      !> Monodromy matrix set up for the system; work space.
      type(monodromy_type), intent(inout) :: monodromy
      !> The two points with their tangents.
      type(solution_point_type), intent(in) :: here, next
      !> Numbers of the two points; the special points are listed after point `after` - 1.
      integer, intent(in) :: before, after
      !> Branch with the multipliers of both points; its `special_points` grow.
      type(branch_type), intent(inout), target :: branch
      !> Becomes true where the branch is off the cubic through both points between them, as in a narrow resonance, or a real
      !> multiplier is above 1 between them alone: two folds, or branch points, are within the step.
      logical, intent(inout) :: hidden
      type(piece_type) :: piece
      type(solution_point_type) :: solution
      type(places_type) :: places
      complex(dp), dimension(branch%states) :: first, last
      integer(int64) :: began, now, rate
      integer :: probes, i, side(most_probes + most_looks + 2)
      logical :: success

      first = multipliers_at(branch, before)
      last = multipliers_at(branch, after)
      if (.not. (are_numbers(first) .and. are_numbers(last))) return
      if (max(abs(first(1)), abs(last(1))) > largest_multiplier) return
      ! Of a large train only the leading ones are known, and more may be outside: the counts are undecided.
      if (monodromy%is_partial() .and. max(abs(first(size(first))), abs(last(size(last)))) > 1) return
      call system_clock(began, rate)
      piece = piece_type(here, next, arc_length(here, next, corrector%units), branch%arclength(before))
      probes = 0
      ! Where teeth stay in contact the motion hardly changes over a range in which a mode or two resonate with the mesh stiffness.
      if (minval(abs(abs([first, last]) - 1)) < far) &
         probes = max(int(acos(max(-1.0_dp, min(1.0_dp, cosine(here, next, corrector%units))))/turn), &
                      int(piece%length/length_between), &
                      int(abs(next%frequency_ratio - here%frequency_ratio)/(spacing*corrector%units%frequency_ratio)))
      probes = min(probes, most_probes)
      allocate (places%at(most_probes + most_looks + 2), places%multipliers(branch%states, most_probes + most_looks + 2))
      allocate (places%rough(most_probes + most_looks + 2), source=.false.)
      call places%insert(0.0_dp, first)
      call places%insert(piece%length, last)
      call look_within(0.0_dp, piece%length, first, last)
      call solve_beside_changes()
      if (places%taken > 2) then
         call look_between(corrector, monodromy, piece, doubling, places)
         call look_between(corrector, monodromy, piece, neimark_sacker, places)
         ! At a fold itself a multiplier is 1 to rounding.
         associate (sense => [sense_of(here, corrector%units), sense_of(next, corrector%units)])
            if (all(sense /= 0)) call look_between(corrector, monodromy, piece, above_one, places)
            side(:places%taken) = [(side_of_fold(places%multipliers(:, i)), i=1, places%taken)]
            if (sense(1) == 0) side(1) = side(places%taken)
            if (sense(2) == 0) side(places%taken) = side(1)
            if (any(sense /= 0) .and. side(1) == side(places%taken)) &
               hidden = hidden .or. any(side(:places%taken) /= side(1))
         end associate
      end if
      call solve_beside_changes()
      do i = 1, places%taken - 1
         associate (at => places%at, known => places%multipliers)
            if (differ(known(:, i), known(:, i + 1))) &
               call separate(corrector, monodromy, piece, at(i), at(i + 1), known(:, i), known(:, i + 1), after, branch)
         end associate
      end do
      call system_clock(now)
      branch%verdict_seconds = branch%verdict_seconds + real(now - began, dp)/real(rate, dp)

   contains

      !> Finds multipliers in the middle of a part of the step, and on both sides of it unless they are as both ends tell.
      recursive subroutine look_within(from, to, before, after)
         real(dp), intent(in) :: from, to
         complex(dp), intent(in) :: before(:), after(:)
         complex(dp) :: multipliers(size(before))
         real(dp) :: distance, middle

         if ((to - from)*(probes + 1) < 1.001_dp*piece%length) return
         middle = (from + to)/2
         ! The motion on the cubic is near enough where they count as at the places beside.
         solution = here
         call go_along(here, next, middle/piece%length, corrector%units, solution)
         call corrector%find_distance(solution, distance)
         hidden = hidden .or. distance > off_cubic*curve_limit(corrector, solution)
         call monodromy%integrate(corrector%balance, corrector%balance%frequency_ratio, verdict=.true.)
         call monodromy%multipliers(multipliers)
         if (.not. are_numbers(multipliers)) return
         call places%insert(middle, multipliers, .true.)
         if (are_as_told(abs(before), abs(multipliers), abs(after))) return
         call look_within(from, middle, before, multipliers)
         call look_within(middle, to, multipliers, after)
      end subroutine look_within

      !> Multipliers at a place of the step; as they are where Newton's method fails.
      subroutine find_at(at, multipliers, success)
         real(dp), intent(in) :: at
         complex(dp), intent(inout) :: multipliers(:)
         logical, intent(out) :: success
         complex(dp) :: found(size(multipliers))
         real(dp) :: place

         place = at
         call find_multipliers(corrector, monodromy, piece, at, at, .true., place, solution, found, success)
         if (success) multipliers = found
      end subroutine find_at

      !> Solves at the rough places beside a change, which else may lie on the other side of such a place. Places without a solution
      !> are dropped.
      subroutine solve_beside_changes()
         integer :: k

         k = 2
         do while (k < places%taken)
            associate (known => places%multipliers)
               if (.not. places%rough(k)) then
                  k = k + 1
               else if (.not. (differ(known(:, k - 1), known(:, k)) .or. differ(known(:, k), known(:, k + 1)))) then
                  k = k + 1
               else
                  call find_at(places%at(k), known(:, k), success)
                  places%rough(k) = .false.
                  if (.not. success) call places%drop(k)
                  ! The place before may now be beside a change.
                  k = max(2, k - 1)
               end if
            end associate
         end do
      end subroutine solve_beside_changes

   end subroutine add_stability_changes

   !> Adds a place.
   pure subroutine insert(self, at, multipliers, rough)
      class(places_type), intent(inout) :: self
      !> Distance from the beginning of the step [1].
      real(dp), intent(in) :: at
      !> Multipliers there, (state).
      complex(dp), intent(in) :: multipliers(:)
      !> They are those of the cubic; absent: of a solution.
      logical, intent(in), optional :: rough
      integer :: n

      n = count(self%at(:self%taken) < at)
      self%at(n + 2:self%taken + 1) = self%at(n + 1:self%taken)
      self%multipliers(:, n + 2:self%taken + 1) = self%multipliers(:, n + 1:self%taken)
      self%rough(n + 2:self%taken + 1) = self%rough(n + 1:self%taken)
      self%at(n + 1) = at
      self%multipliers(:, n + 1) = multipliers
      self%rough(n + 1) = .false.
      if (present(rough)) self%rough(n + 1) = rough
      self%taken = self%taken + 1
   end subroutine insert

   !> Removes a place.
   pure subroutine drop(self, n)
      class(places_type), intent(inout) :: self
      !> Its number.
      integer, intent(in) :: n

      self%at(n:self%taken - 1) = self%at(n + 1:self%taken)
      self%multipliers(:, n:self%taken - 1) = self%multipliers(:, n + 1:self%taken)
      self%rough(n:self%taken - 1) = self%rough(n + 1:self%taken)
      self%taken = self%taken - 1
   end subroutine drop

   !> Adds a place at which multipliers of a kind have crossed the circle, if there is one between places at all of which as many
   !> are outside.
   subroutine look_between(corrector, monodromy, piece, kind, places)
      type(corrector_type), intent(inout) :: corrector
      type(monodromy_type), intent(inout) :: monodromy
      type(piece_type), intent(in) :: piece
      integer, intent(in) :: kind
      type(places_type), intent(inout) :: places
      type(samples_type) :: samples
      type(solution_point_type) :: solution
      complex(dp) :: multipliers(size(places%multipliers, 1))
      real(dp) :: f(places%taken), s, peak, value
      integer :: counts(3, places%taken + 1), sense, number, n, i
      logical :: success

      n = places%taken
      do i = 1, n
         counts(:, i) = outside(places%multipliers(:, i))
      end do
      if (any(counts(kind, 2:n) /= counts(kind, 1))) return
      do sense = 1, -1, -2
         ! The next one to leave the circle, and the last one that has left it.
         number = counts(kind, 1) + merge(1, 0, sense > 0)
         if (number == 0) cycle
         f = [(sense*distance_of(places%multipliers(:, i), kind, number), i=1, n)]
         if (any(abs(f) >= -none) .or. any(f >= 0) .or. all(f < -far)) cycle
         samples%taken = 0
         do i = 1, n
            call samples%insert(places%at(i), f(i))
         end do
         do i = 1, looks
            if (.not. samples%reach_circle(piece%length, uncertain, i > 1)) exit
            call samples%highest(piece%length, s, peak)
            call find_multipliers(corrector, monodromy, piece, 0.0_dp, piece%length, .true., s, solution, multipliers, success)
            if (.not. success) exit
            counts(:, n + 1) = outside(multipliers)
            if (counts(kind, n + 1) /= counts(kind, 1)) then
               call places%insert(s, multipliers)
               return
            end if
            value = sense*distance_of(multipliers, kind, number)
            if (abs(value) >= -none) exit
            call samples%insert(s, value)
         end do
      end do
   end subroutine look_between

   !> Whether magnitudes in a middle that matter are nearly the means of both ends.
   pure logical function are_as_told(before, middle, after)
      !> Magnitudes, the largest first.
      real(dp), intent(in), dimension(:) :: before, middle, after
      real(dp), dimension(size(middle)) :: distance

      distance = min(abs(before - 1), abs(middle - 1), abs(after - 1))
      are_as_told = all(distance > far .or. abs(middle - (before + after)/2) < as_told*distance)
   end function are_as_told

   !> Whether multipliers pass the circle, or may, between two places.
   pure logical function differ(first, last)
      complex(dp), intent(in) :: first(:), last(:)

      ! The multipliers are sorted by magnitude: none is outside, which is the rule.
      differ = .not. max(abs(first(1)), abs(last(1))) <= 1
      if (differ) differ = any(outside(first) /= outside(last)) .or. hides_pair(first, last)
   end function differ

end module geartrain_trace_probed_changes
