!> A branch of orbits, each found by shooting: of trains with dry friction, whose motions have no harmonic balance, because
!> harmonics do not represent sticking. The exact branch is followed step by step like the branch of a balance: by its tangent,
!> through folds, with changes of stability located within the steps. Where a coupling begins or ceases to stick or to slip, or
!> teeth meet, the branch has a corner or a sharp bend. A step may go over a corner if the tangents at its ends meet.
module geartrain_exact_orbit_branch
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_base_sorting, only: ascending
   use geartrain_base_words, only: lambda, operator(//), words_type
   use geartrain_exact_orbit_corrector, only: orbit_corrector_type, orbit_test_type, orbit_type
   use geartrain_exact_orbit_tests, only: choose_test
   use geartrain_exact_refinement, only: replace_point
   use geartrain_floquet_multipliers, only: side_of_fold
   use geartrain_flow_orbit, only: measure
   use geartrain_network_system, only: system_type
   use geartrain_trace_branch, only: arrange_points, branch_type
   use geartrain_trace_special_points, only: add_special_point
   implicit none (type, external)
   private
   public :: orbit_tracer_type
   public :: cancelled, came_back, closed_loop, left_by_amplitude, reached_end

   !> Outcomes of a trace: it reached the target; came back to the other bound; closed where it began; passed the amplitude limit;
   !> had max_points; was ended by the observer; failed with the smallest step.
   integer, parameter :: reached_end = 1, came_back = 2, closed_loop = 3, left_by_amplitude = 4, full = 5, cancelled = 6, stuck = 7
   integer, parameter :: under_way = 0
   !> Length of the first step, of the smallest one, and of one in which another branch may cross [units_type].
   real(dp), parameter :: first_step = 0.01_dp, smallest_step = 1e-8_dp, short = 1e-5_dp
   !> Least cosine of the angle between the tangents at the ends of the step that closes a branch [1].
   real(dp), parameter :: straight = 0.995_dp
   !> Angle between the tangents at the ends of a step [rad], and distance from its guess over its length [1], aimed at: as a rule,
   !> and in steps shorter than `unseen` of the largest displacement, as next to a corner, too short to show the bend.
   real(dp), parameter :: angle_aim(2) = [0.8_dp, 1.2_dp], correction_aim(2) = [0.3_dp, 0.6_dp], unseen = 0.01_dp
   !> Least and largest length of a step over that of the step before [1].
   real(dp), parameter :: least_factor = 0.4_dp, largest_factor = 3
   !> Largest displacement above which the largest step grows in proportion to it [units_type].
   real(dp), parameter :: large = 5
   !> Special points that change the stability without a fold.
   character(*), parameter :: kinds(3) = [character(15) :: 'period doubling', 'neimark-sacker', 'branch point']

   type :: orbit_tracer_type
      type(orbit_corrector_type) :: corrector
      !> The train of the latest flight.
      type(system_type), pointer :: system => null()
      !> Value of a parameter, or Lambda, at 0 of what the corrector takes for Lambda, and its slope; a parameter varies.
      real(dp) :: origin = 0, slope = 1
      logical :: over_parameter = .false.
      !> Lambda of all motions over a parameter [1].
      real(dp) :: constant_frequency = 0
      !> Largest step [units_type]; largest rms over characteristic length [1]; most points.
      real(dp) :: step = 0.2_dp, amplitude_limit = huge(1.0_dp)
      integer :: max_points = 20000
      !> Number of the segment.
      integer :: segment = 1
      !> Whether stability is wanted.
      logical :: stability = .true.
   contains
      procedure :: value_of
      procedure :: trace
      procedure :: record
      procedure, private :: land, add_changes, measured, next_step
   end type orbit_tracer_type

contains

   !> Lambda of an orbit, or value of the parameter.
   pure real(dp) function value_of(self, orbit) result(value)
      class(orbit_tracer_type), intent(in) :: self
      !> The orbit.
      type(orbit_type), intent(in) :: orbit

      value = self%origin + self%slope*orbit%frequency_ratio
   end function value_of

   !> Follows the branch from an orbit within the bounds.
   subroutine trace(self, here, low, high, target, branch, outcome, reason, observer, analysis)
      class(orbit_tracer_type), intent(inout) :: self
      !> The latest point of the branch, with its tangent; then the latest orbit.
      type(orbit_type), intent(inout) :: here
      !> Bounds of what the corrector takes for Lambda, and which of the two is the end.
      real(dp), intent(in) :: low, high, target
      !> The branch.
      type(branch_type), intent(inout), target :: branch
      !> How the trace ended: a constant of this module.
      integer, intent(out) :: outcome
      !> Why the trace ended.
      type(words_type), allocatable, intent(out) :: reason
      !> Told of each step; may end the trace.
      class(observer_type), intent(inout), optional :: observer
      !> Name of the analysis that the observer is told.
      character(*), intent(in) :: analysis
      type(orbit_type) :: next, began
      real(dp) :: h, cosine, wall, longest
      integer :: steps, mesh
      logical :: success, at_bound, keep_going, closing

      began = here
      h = min(first_step, self%step)
      wall = 0
      steps = 0
      outcome = under_way
      do
         closing = .false.
         call self%corrector%advance(here, h, next, success)
         if (self%system%interrupt%raised()) then
            outcome = cancelled
            reason = 'cancelled at '//lambda(self%value_of(here))
            return
         end if
         if (success .and. h > short .and. self%stability) success = .not. leaves(here, next)
         at_bound = .false.
         if (success) at_bound = next%frequency_ratio <= low .or. next%frequency_ratio >= high
         if (success .and. steps > 3) closing = passes(self%corrector, here, began, h)
         if (closing) next = began
         if (at_bound .and. .not. closing) call self%land(merge(high, low, next%frequency_ratio >= high), here, next, success)
         if (.not. success) then
            wall = h
            h = h/3
            if (h >= smallest_step) cycle
            outcome = stuck
            reason = 'shooting finds no further motion at '//lambda(self%value_of(here))//', where the branch may have a sharp &
                     &corner: dry friction or contact begins or ends there'
            return
         end if
         cosine = self%corrector%cosine(here, next)
         call self%add_changes(here, h, next, branch)
         call self%record(next, branch)
         if (self%system%interrupt%raised()) cycle
         steps = steps + 1
         here = next
         mesh = maxloc(branch%rms(:, branch%points), 1)
         if (closing) then
            outcome = closed_loop
            reason = 'closed where it began, at '//lambda(self%value_of(began))
         else if (at_bound) then
            outcome = merge(reached_end, came_back, abs(next%frequency_ratio - target) <= 0)
            reason = 'reached '//lambda(self%value_of(here))
            if (outcome == came_back) reason = 'came back to '//lambda(self%value_of(here))
         else if (branch%rms(mesh, branch%points) > self%amplitude_limit) then
            outcome = left_by_amplitude
            reason = 'rms of '//trim(self%system%mesh_name(mesh))//' passed the amplitude limit '//text(self%amplitude_limit) &
                     //' at '//lambda(self%value_of(here))
         else if (branch%points >= self%max_points) then
            outcome = full
            reason = 'max_points = '//text(self%max_points)//' reached at '//lambda(self%value_of(here))
         end if
         if (outcome == under_way .and. present(observer)) then
            keep_going = .true.
            call observer%on_step(analysis, branch%points, self%value_of(here), keep_going)
            if (.not. keep_going) then
               outcome = cancelled
               reason = 'cancelled at '//lambda(self%value_of(here))
            end if
         end if
         if (outcome /= under_way) return
         ! Half of the way to where a step was refused, at most.
         wall = wall - h
         longest = huge(1.0_dp)
         if (wall > h) longest = wall/2
         h = min(self%next_step(here, h, cosine), longest)
      end do
   end subroutine trace

   !> Length of the next step [units_type]: aims at an angle between the tangents and at a correction of the guess.
   real(dp) function next_step(self, here, h, cosine)
      class(orbit_tracer_type), intent(in) :: self
      !> The latest orbit.
      type(orbit_type), intent(in) :: here
      !> Length of the step to it [units_type]; cosine of the angle between the tangents at its ends [1].
      real(dp), intent(in) :: h, cosine
      real(dp) :: factor, size
      integer :: i

      size = maxval(abs(here%states(:self%system%displacements, :)))/self%corrector%units%length
      i = merge(2, 1, h < unseen*size)
      factor = min(angle_aim(i)/max(acos(max(-1.0_dp, min(1.0_dp, cosine))), 1e-8_dp), &
                   correction_aim(i)/max(here%correction, 1e-8_dp))
      next_step = min(h*max(least_factor, min(largest_factor, factor)), &
                      self%step*max(1.0_dp, size/large))
   end function next_step

   !> Whether a step leads to another branch: along a branch the number of real multipliers above 1 is even or odd, and changes this
   !> where Lambda turns and at a branch point alone.
   pure logical function leaves(here, next)
      type(orbit_type), intent(in) :: here, next
      logical :: turns, changes

      turns = here%tangent_frequency*next%tangent_frequency < 0
      changes = side_of_fold(here%multipliers) /= side_of_fold(next%multipliers)
      leaves = turns .neqv. changes
   end function leaves

   !> Whether a step passes the orbit at which the branch began.
   logical function passes(corrector, here, began, h)
      type(orbit_corrector_type), intent(inout) :: corrector
      type(orbit_type), intent(in) :: here, began
      real(dp), intent(in) :: h
      ! Distance from the chord, over the length of the step, at most.
      real(dp), parameter :: aside = 0.2_dp
      real(dp) :: way, along

      way = corrector%distance(here, began)
      passes = .false.
      if (way > h .or. .not. way > 0) return
      along = corrector%along(here, began)
      passes = along > 0 .and. way**2 - along**2 < (aside*way)**2 .and. corrector%cosine(here, began) > straight
   end function passes

   !> Ends a step at a bound.
   subroutine land(self, bound, here, next, success)
      class(orbit_tracer_type), intent(inout) :: self
      real(dp), intent(in) :: bound
      !> Beginning of the step.
      type(orbit_type), intent(in) :: here
      !> End of the step, beyond the bound; then the orbit at the bound.
      type(orbit_type), intent(inout) :: next
      logical, intent(out) :: success
      type(orbit_type) :: end
      real(dp) :: share, way

      success = .true.
      if (abs(next%frequency_ratio - bound) <= 0) return
      end = next
      share = (bound - here%frequency_ratio)/(end%frequency_ratio - here%frequency_ratio)
      next%states = here%states + share*(end%states - here%states)
      next%frequency_ratio = bound
      call self%corrector%solve_at(next, success)
      way = self%corrector%distance(here, end)
      ! Else it may be a motion of another branch.
      if (success) success = max(self%corrector%distance(here, next), self%corrector%distance(next, end)) <= 1.1_dp*way
   end subroutine land

   !> Adds the folds and the changes of stability within a step to the branch, whose latest point is its beginning.
   subroutine add_changes(self, here, h, next, branch)
      class(orbit_tracer_type), intent(inout) :: self
      !> Beginning of the step, its length, and its end.
      type(orbit_type), intent(in) :: here
      real(dp), intent(in) :: h
      type(orbit_type), intent(inout) :: next
      type(branch_type), intent(inout), target :: branch
      class(orbit_test_type), allocatable :: test
      type(orbit_type) :: fold

      call choose_test('fold', 1, self%corrector%units%frequency_ratio, here, next, test)
      if (.not. allocated(test)) then
         call add_bifurcations(self, here, h, next, branch)
         return
      end if
      call locate(self%corrector, test, here, h, next, fold)
      call add_bifurcations(self, here, self%corrector%distance(here, fold), fold, branch)
      call self%record(fold, branch)
      associate (n => branch%points)
         call add_special_point(branch, 'fold', branch%frequency_ratio(n), n, branch%rms(:, n))
      end associate
      call add_bifurcations(self, fold, self%corrector%distance(fold, next), next, branch)
   end subroutine add_changes

   !> Adds the changes of stability without a fold within a step.
   subroutine add_bifurcations(self, here, h, next, branch)
      class(orbit_tracer_type), intent(inout) :: self
      type(orbit_type), intent(in) :: here, next
      real(dp), intent(in) :: h
      type(branch_type), intent(inout), target :: branch
      class(orbit_test_type), allocatable :: test
      type(orbit_type) :: orbit
      type(motion_type) :: motion
      integer :: i

      if (.not. self%stability) return
      do i = 1, size(kinds)
         call choose_test(trim(kinds(i)), 1, self%corrector%units%frequency_ratio, here, next, test)
         if (.not. allocated(test)) cycle
         call locate(self%corrector, test, here, h, next, orbit)
         call self%measured(orbit, 1, motion)
         if (self%system%interrupt%raised()) return
         call add_special_point(branch, trim(kinds(i)), self%value_of(orbit), branch%points, motion%rms)
      end do
   end subroutine add_bifurcations

   !> Finds the orbit within a step at which a test function is 0; where shooting fails, as beside a corner, the nearer end of it.
   subroutine locate(corrector, test, here, h, next, orbit)
      type(orbit_corrector_type), intent(inout) :: corrector
      class(orbit_test_type), intent(in) :: test
      type(orbit_type), intent(in) :: here, next
      real(dp), intent(in) :: h
      type(orbit_type), intent(out) :: orbit
      logical :: success

      call corrector%find_zero(test, here, h, next, orbit, success)
      if (success) return
      orbit = next
      if (abs(test%value(here)) < abs(test%value(next))) orbit = here
   end subroutine locate

   !> Appends an orbit to the branch.
   subroutine record(self, orbit, branch)
      class(orbit_tracer_type), intent(inout) :: self
      !> The orbit.
      type(orbit_type), intent(in) :: orbit
      !> The branch.
      type(branch_type), intent(inout), target :: branch
      type(motion_type) :: motion
      integer :: n, k

      call self%measured(orbit, branch%harmonics/branch%subharmonic, motion)
      if (self%system%interrupt%raised()) return
      n = branch%points + 1
      if (n > size(branch%frequency_ratio)) call arrange_points(branch, [(k, k=1, branch%points)], 2*branch%points)
      branch%frequency_ratio(n) = self%value_of(orbit)
      if (allocated(branch%half_backlash_at)) branch%half_backlash_at(:, n) = self%system%half_backlash
      branch%coefficients(:, :, n) = 0
      branch%point_harmonics(n) = branch%harmonics
      branch%segment(n) = self%segment
      branch%state(:, n) = motion%state
      call replace_point(motion, n, branch)
      if (allocated(branch%stable)) then
         branch%undecided(n) = motion%undecided
         branch%second_estimate(n) = -1
         associate (largest => max(abs(orbit%multipliers(1)), tiny(1.0_dp)))
            branch%growth_rate(n) = log(largest)*motion%frequency_ratio/(2*pi*branch%subharmonic) &
                                    *self%system%characteristic_frequency
         end associate
      end if
      branch%points = n
   end subroutine record

   !> An orbit as a motion, with all figures.
   subroutine measured(self, orbit, harmonics, motion)
      class(orbit_tracer_type), intent(inout) :: self
      type(orbit_type), intent(in) :: orbit
      !> Harmonics of Lambda in the coefficients.
      integer, intent(in) :: harmonics
      type(motion_type), intent(out) :: motion
      real(dp) :: frequency_ratio
      integer :: n

      call self%corrector%take_train(orbit, frequency_ratio)
      motion%frequency_ratio = frequency_ratio
      motion%period = self%corrector%period
      motion%state = orbit%states(:, 1)
      call measure(self%system, harmonics, motion)
      motion%error_estimate = orbit%accuracy
      motion%multipliers = orbit%multipliers
      n = size(motion%multipliers)
      ! Those of twists that stay as they are, which the corrector counts as 0, are 1.
      motion%multipliers(n - orbit%kept + 1:) = 1
      motion%multipliers = motion%multipliers(ascending(-abs(motion%multipliers)))
      motion%stable = orbit%stable
      motion%undecided = orbit%undecided
   end subroutine measured

end module geartrain_exact_orbit_branch
