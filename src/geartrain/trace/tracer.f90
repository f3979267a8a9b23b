!> Follows a branch from one solution point until it reaches a bound, closes, leaves by the amplitude limit or cannot go on: step
!> control, guard against jumps, folds as points of the branch, branch points and changes of stability.
module geartrain_trace_tracer
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_base_words, only: lambda, operator(//), words_type
   use geartrain_trace_branch, only: branch_type, trace_state_type
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_trace_crossings, only: add_branch_point, crossing_type, find_crossings
   use geartrain_trace_growth_changes, only: add_growth_change
   use geartrain_trace_hidden_changes, only: add_hidden_changes
   use geartrain_trace_out_of_reach, only: find_out_of_reach
   use geartrain_trace_probed_changes, only: add_stability_changes
   use geartrain_trace_special_points, only: add_special_point, is_known_fold, locate_fold
   use geartrain_trace_stability_changes, only: jumped
   use geartrain_trace_step_extremes, only: quantities_type
   use geartrain_trace_step_geometry, only: passes_half_period, sense_of, way_to
   use geartrain_trace_step_length, only: carries_same, closes, crosses_branch, large, next_step
   use geartrain_trace_stepper, only: stepper_type
   implicit none (type, external)
   private
   public :: tracer_type, reached_end, came_back, closed_loop, left_by_amplitude, cancelled, met_half_period, went_round

   !> Outcomes of a trace: it reached the target bound; came back to the other bound; closed where it began; passed the amplitude
   !> limit; was ended by the observer; failed with the smallest step; had max_points, or motions out of reach; met the branch
   !> of half its period; goes round a closed branch on which it did not begin.
   integer, parameter :: reached_end = 1, came_back = 2, closed_loop = 3, left_by_amplitude = 4, cancelled = 5, stuck = 6, &
                         full = 7, met_half_period = 8, went_round = 9
   !> The trace goes on.
   integer, parameter :: under_way = 0

   !> Length of the first step, and of the smallest one, in the metric of the branch.
   real(dp), parameter :: first_step = 0.01_dp, smallest_step = 1e-9_dp
   !> Length of a step that is as good as the fold in it.
   real(dp), parameter :: fold_itself = 1e-6_dp

   type, extends(stepper_type) :: tracer_type
      !> Largest rms of a mesh over characteristic length [1].
      real(dp) :: amplitude_limit = huge(1.0_dp)
      !> Name of the analysis told to the observer: 'response', or 'branch' for a further branch.
      character(8) :: analysis = 'response'
      !> Points and special points of the branch before the step under way.
      integer :: kept(2) = 0
      !> The next trace goes on from branch%trace.
      logical :: resumes = .false.
   contains
      procedure :: trace, note_state, restore_state
      procedure, private :: find_end, add_fold, add_changes
   end type tracer_type

contains

   !> Follows the branch within the bounds.
   subroutine trace(self, here, low, high, target, branch, outcome, reason, observer, began, point)
      class(tracer_type), intent(inout) :: self
      !> Where to begin: solved, oriented and a point of the branch already. Afterwards, where the branch passed the amplitude
      !> limit, the first point above the limit.
      type(solution_point_type), intent(inout) :: here
      !> Bounds of Lambda [1], and which of the two is the end: at the other bound the branch has come back.
      real(dp), intent(in) :: low, high, target
      !> Gets the points, special points and, where allocated, the state of the trace.
      type(branch_type), intent(inout), target :: branch
      !> How the trace ended: a constant of this module.
      integer, intent(out) :: outcome
      !> Why the trace ended.
      type(words_type), allocatable, intent(out) :: reason
      !> Told of each step; may end the trace.
      class(observer_type), intent(inout), optional :: observer
      !> Where the branch began, and closes: `here` unless it is given. Put onto the present harmonics where the branch passes the
      !> amplitude limit.
      type(solution_point_type), intent(inout), optional :: began
      !> Number of the point of the branch that `here` is: the latest point unless it is given.
      integer, intent(in), optional :: point
      type(solution_point_type) :: next, origin, fold
      type(quantities_type) :: at_here
      real(dp) :: h, way, longer, shorter, gap, fold_at, off_curve, stop
      integer :: steps, before, sense, i, missed
      logical :: success, keep_going, meets, crosses, at_bound, closing, cut, known, lost, hidden, passes, stops
      type(crossing_type), allocatable :: crossings(:)
      character(:), allocatable :: trouble

      before = branch%points
      if (present(point)) before = point
      next = here
      origin = here
      if (present(began)) origin = began
      sense = sense_of(here, self%corrector%units)
      h = self%shown_step(min(first_step, self%settings%step), here, low, high)
      steps = 0
      closing = .false.
      if (allocated(self%before%u)) deallocate (self%before%u)
      if (self%resumes) then
         self%resumes = .false.
         here = branch%trace%here
         self%before = branch%trace%earlier
         origin = branch%trace%origin
         h = branch%trace%step
         steps = branch%trace%steps
         sense = branch%trace%sense
         call self%corrector%keep_equal(origin)
      else
         self%refusals = 0
         call self%keep_equal(here, origin)
      end if
      call at_here%find(self%corrector, self%recorder%transform, here)
      do
         ! After an interrupt `drop_step` cuts the branch back to `kept`: an interrupted first step takes the first point with it.
         if (.not. self%system%interrupt%raised()) self%kept = [branch%points, size(branch%special_points)]
         missed = self%missed
         call self%take_step(here, origin, closing, h, low, high, next, off_curve, shorter, success)
         way = h
         longer = h
         at_bound = success .and. .not. closing .and. .not. (next%frequency_ratio > low .and. next%frequency_ratio < high)
         crosses = .false.
         if (at_bound) then
            call self%stop_at(merge(high, low, next%frequency_ratio > low), here, next, h, success)
            way = way_to(here, next, self%corrector%units)
         else if (success .and. .not. closing) then
            longer = next_step(self%corrector, here, next, h, &
                               self%settings%step*max(1.0_dp, self%corrector%length_of(next%u)/large), off_curve)
            longer = self%shown_step(longer, next, low, high)
            self%curvature = (next%tangent_frequency - here%tangent_frequency)/h
            crosses = crosses_branch(here, next)
         end if
         if (success .and. self%shows .and. sense_of(here, self%corrector%units)*sense_of(next, self%corrector%units) > 0) then
            call self%pass_resonances(here, next, self%recorder%shaft_torque, passes, stop, stops)
            if (passes) then
               h = min(h, way)/3
               closing = .false.
               cycle
            end if
            if (stops .and. .not. crosses) then
               call self%stop_at(stop, here, next, h, success)
               way = way_to(here, next, self%corrector%units)
               at_bound = .false.
               closing = .false.
            end if
         end if
         if (success .and. .not. (crosses .or. self%vanishes())) then
            call self%cut_step(here, at_here, next, cut)
            if (cut) way = way_to(here, next, self%corrector%units)
            at_bound = at_bound .and. .not. cut
            closing = closing .and. .not. cut
         end if
         call find_crossings(self%corrector, here, next, way, crosses, success, crossings)
         if (success) call self%adapt_end(next, here, origin, at_bound .or. closing, success)
         if (closing .and. .not. success) exit
         if (.not. success) then
            h = h*shorter
            if (h >= smallest_step) cycle
            outcome = stuck
            call self%tell_trouble(trouble)
            reason = 'step below '//text(smallest_step)//' at '//lambda(here%frequency_ratio)//': '//trouble
            return
         end if
         fold_at = 0
         ! A branch that meets the branch of half its period goes on as its own mirror image: Lambda only seems to turn there.
         meets = passes_half_period(here, next, self%corrector%balance%waves())
         if (sense*sense_of(next, self%corrector%units) < 0 .and. .not. (meets .or. crosses)) then
            call self%add_fold(here, next, origin, way, at_bound, before, fold, fold_at, branch, success)
            if (.not. success) then
               h = h/3
               ! `here` may have been put onto more harmonics.
               call self%corrector%correct(here, success)
               if (success .and. h >= smallest_step) cycle
               outcome = stuck
               reason = 'turned back where no fold is found, at '//lambda(here%frequency_ratio)
               return
            end if
         end if
         if (fold_at > 0) then
            if (is_known_fold(branch)) then
               reason = 'came to the fold at '//lambda(fold%frequency_ratio)//' again, so an earlier step led to another branch'
               branch%points = self%kept(1)
               branch%special_points = branch%special_points(:self%kept(2))
               outcome = went_round
               return
            end if
            call self%record(next, branch, fold, branch%points)
         else
            call self%record(next, branch, here, before)
         end if
         ! Nearer to a fold than that balance and multipliers may place it on different sides.
         known = way <= first_step .or. meets .or. crosses .and. size(crossings) == 0
         lost = .false.
         if (.not. known .and. self%recorder%stability .and. .not. self%vanishes() .and. &
             sense_of(here, self%corrector%units)*sense_of(next, self%corrector%units) /= 0) &
            lost = jumped(branch, before, sum(crossings%multiplicity) + merge(1, 0, fold_at > 0))
         if (.not. lost) then
            do i = 1, size(crossings)
               if (.not. meets) call add_branch_point(branch, before, crossings(i))
            end do
            hidden = .false.
            call self%add_changes(here, next, fold, fold_at, before, branch, hidden)
            lost = hidden .and. .not. known .and. size(crossings) == 0
         end if
         if (lost) then
            branch%points = self%kept(1)
            branch%special_points = branch%special_points(:self%kept(2))
            self%missed = missed
            closing = .false.
            h = min(h, way)/3
            call self%corrector%correct(here, success)
            if (success) cycle
            outcome = stuck
            reason = 'the branch is lost at '//lambda(here%frequency_ratio)
            return
         end if
         if (self%recorder%stability .and. .not. self%vanishes()) then
            ! Of the steps that now have a point after them, the one to a fold included.
            associate (n => branch%points)
               call add_hidden_changes(self%corrector, self%recorder%monodromy, max(before, n - 2) - 1, n - 2, branch, self%kept(2))
            end associate
         end if
         if (sense_of(next, self%corrector%units) /= 0) sense = sense_of(next, self%corrector%units)
         at_here = self%quantities
         steps = steps + 1
         if (closing) exit
         call self%find_end(at_bound, meets, target, before, branch, outcome, reason)
         if (outcome /= under_way .and. self%recorder%stability .and. .not. self%vanishes()) &
            call add_hidden_changes(self%corrector, self%recorder%monodromy, branch%points - 1, branch%points - 1, branch, &
                                    self%kept(2))
         if (outcome == left_by_amplitude) then
            here = next
            if (present(began)) began = origin
         end if
         if (outcome /= under_way) return

         h = longer
         self%before = here
         here = next
         before = branch%points
         call self%relax(here, origin, h)
         if (.not. carries_same(here, next)) call at_here%find(self%corrector, self%recorder%transform, here)
         if (steps > 3) closing = closes(self%corrector, self%before, here, origin, branch%frequency_ratio(:branch%points), h, gap)
         if (closing) h = gap

         ! Last in the loop: the observer may write the branch to a checkpoint, from which another run goes on by branch%trace.
         if (.not. present(observer) .or. closing) cycle
         if (allocated(branch%trace)) then
            call self%note_state(branch%trace)
            branch%trace%steps = steps
            branch%trace%step = h
            branch%trace%longest = self%settings%step
            branch%trace%sense = sense
            branch%trace%here = here
            branch%trace%earlier = self%before
            branch%trace%origin = origin
         end if
         keep_going = .true.
         call observer%on_step(trim(self%analysis), branch%points, here%frequency_ratio, keep_going)
         if (keep_going) cycle
         outcome = cancelled
         branch%cancelled = .true.
         reason = 'cancelled at '//lambda(here%frequency_ratio)
         return
      end do
      outcome = closed_loop
      reason = 'closed where it began, at '//lambda(origin%frequency_ratio)
   end subroutine trace

   !> Whether and how the trace ends at the latest point of the branch; the step began at point number `before`.
   subroutine find_end(self, at_bound, meets, target, before, branch, outcome, reason)
      class(tracer_type), intent(in) :: self
      logical, intent(in) :: at_bound, meets
      real(dp), intent(in) :: target
      integer, intent(in) :: before
      type(branch_type), intent(in) :: branch
      integer, intent(out) :: outcome
      type(words_type), allocatable, intent(inout) :: reason
      integer :: mesh

      associate (n => branch%points, frequency_ratio => branch%frequency_ratio(branch%points))
         mesh = maxloc(branch%rms(:, n), 1)
         outcome = under_way
         if (at_bound) then
            outcome = merge(reached_end, came_back, abs(frequency_ratio - target) <= 0)
            reason = 'reached '//lambda(frequency_ratio)
            if (outcome == came_back) reason = 'came back to '//lambda(frequency_ratio)
         else if (meets) then
            outcome = met_half_period
            reason = 'met the branch of half its period at '//lambda(frequency_ratio)
         else if (branch%rms(mesh, n) > max(self%amplitude_limit, branch%rms(mesh, before))) then
            ! Not where the rms falls: a branch may begin above the limit.
            outcome = left_by_amplitude
            reason = 'rms of '//trim(self%system%mesh_name(mesh))//' passed the amplitude limit '//text(self%amplitude_limit) &
                     //' at '//lambda(frequency_ratio)
         else if (n >= self%settings%max_points) then
            outcome = full
            reason = 'max_points = '//text(self%settings%max_points)//' reached at '//lambda(frequency_ratio)
         else if (self%chooses_sets) then
            call find_out_of_reach(branch, self%settings%tolerance, self%corrector%balance%has_long_period(), reason)
            if (allocated(reason)) outcome = full
         end if
      end associate
   end subroutine find_end

   !> Notes what the next trace, from the other end, takes over from the trace so far.
   pure subroutine note_state(self, state)
      class(tracer_type), intent(in) :: self
      !> Gets harmonics, curvature and missed points.
      type(trace_state_type), intent(inout) :: state

      state%harmonics = self%corrector%balance%highest
      state%curvature = self%curvature
      state%missed = self%missed
      state%refusals = self%refusals
   end subroutine note_state

   !> Takes back what `note_state` noted.
   subroutine restore_state(self, state)
      class(tracer_type), intent(inout) :: self
      !> State with harmonics, curvature and missed points.
      type(trace_state_type), intent(in) :: state

      if (self%chooses_sets .and. state%steps > 0) then
         call self%prepare(state%harmonics, state%here%harmonic)
      else if (self%corrector%balance%highest /= state%harmonics .and. .not. self%chooses_sets) then
         call self%prepare(state%harmonics)
      end if
      self%curvature = state%curvature
      self%missed = state%missed
      self%refusals = state%refusals
   end subroutine restore_state

   !> Records the fold between `here` and `next`, a distance h apart, as a point of the branch, and solves `next` again, so that the
   !> corrector worked on `next` last.
   subroutine add_fold(self, here, next, origin, h, at_bound, point, fold, fold_at, branch, success)
      class(tracer_type), intent(inout) :: self
      type(solution_point_type), intent(inout) :: here, next, origin
      real(dp), intent(in) :: h
      !> Lambda of `next` is a bound.
      logical, intent(in) :: at_bound
      !> Number of the point of the branch that `here` is.
      integer, intent(in) :: point
      !> The fold and its distance from `here`; fold_at = 0: it is no point of its own.
      type(solution_point_type), intent(inout) :: fold
      real(dp), intent(out) :: fold_at
      type(branch_type), intent(inout), target :: branch
      !> False where there is no fold between `here` and `next`, or no `next`, with the harmonics that the fold needs: nothing is
      !> recorded, and a shorter step shows where Lambda turns.
      logical, intent(out) :: success
      type(solution_point_type) :: guess, first(3)
      integer :: kept(2), turned, highest
      logical :: enough

      kept = [branch%points, size(branch%special_points)]
      first = [here, next, origin]
      highest = self%corrector%balance%highest
      turned = sense_of(next, self%corrector%units)
      fold_at = 0
      if (sense_of(here, self%corrector%units) == 0) then
         call add_special_point(branch, 'fold', here%frequency_ratio, point, branch%rms(:, point))
         success = .true.
         return
      end if
      do
         fold = next
         call locate_fold(self%corrector, here, next, h, fold, fold_at, success)
         if (.not. success) exit
         call self%adapt(fold, enough, here, origin)
         if (carries_same(fold, next)) exit
         ! With more harmonics the fold lies elsewhere.
         call self%corrector%refit(next)
      end do
      if (.not. (success .or. carries_same(here, first(1)))) then
         ! A shorter step finds it, unless the motion of more harmonics lies too far away: then the fold misses the tolerance.
         call self%corrector%correct(here, enough)
         if (.not. enough) then
            call self%prepare(highest, first(1)%harmonic)
            here = first(1)
            next = first(2)
            origin = first(3)
            fold = next
            call locate_fold(self%corrector, here, next, h, fold, fold_at, success)
         end if
      end if
      if (success) then
         call self%record(fold, branch, here, point)
         call add_special_point(branch, 'fold', fold%frequency_ratio, branch%points, branch%rms(:, branch%points))
      else
         fold_at = 0
         if (h < fold_itself) call add_special_point(branch, 'fold', here%frequency_ratio, point, branch%rms(:, point))
         success = h < fold_itself
      end if
      if (success .and. at_bound) then
         call self%corrector%solve_at(next, success)
         if (success) call self%corrector%orient(next, turned)
      else if (success) then
         guess = next
         call self%corrector%advance(here, h, next, success, guess)
         if (success) success = sense_of(next, self%corrector%units)*turned >= 0
      end if
      if (success) return
      fold_at = 0
      branch%points = kept(1)
      branch%special_points = branch%special_points(:kept(2))
   end subroutine add_fold

   !> Lists the changes of stability in the latest step, from `here` to `next`: before and after its fold, if any.
   subroutine add_changes(self, here, next, fold, fold_at, before, branch, hidden)
      class(tracer_type), intent(inout) :: self
      type(solution_point_type), intent(in) :: here, next, fold
      real(dp), intent(in) :: fold_at
      !> Number of the point of the branch that `here` is.
      integer, intent(in) :: before
      type(branch_type), intent(inout), target :: branch
      !> Becomes true where it hides folds or a narrow resonance.
      logical, intent(inout) :: hidden

      ! A train at rest at a wall of its gaps has no multipliers.
      if (.not. self%recorder%stability .or. self%vanishes()) return
      associate (corrector => self%corrector, monodromy => self%recorder%monodromy, n => branch%points)
         if (branch%states == 0) then
            call add_growth_change(corrector, monodromy, here, next, before, n, branch)
            return
         end if
         if (fold_at > 0) then
            call add_stability_changes(corrector, monodromy, here, fold, before, n - 1, branch, hidden)
            call add_stability_changes(corrector, monodromy, fold, next, n - 1, n, branch, hidden)
         else
            call add_stability_changes(corrector, monodromy, here, next, before, n, branch, hidden)
         end if
      end associate
   end subroutine add_changes

end module geartrain_trace_tracer
