!> Follows a branch from one solution point until it reaches a bound, closes, leaves by the amplitude limit or cannot go on:
!> step control, guard against jumps, harmonics by tolerance, folds put on the branch as points of their own.
module geartrain_continuation_tracer
   use geartrain_balance_chosen_harmonics, only: fewest_harmonics, most_harmonics
   use geartrain_balance_error_estimate, only: find_error_estimate, harmonics_for, error_estimate_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_continuation_branch, only: branch_type, response_settings_type, trace_state_type
   use geartrain_continuation_corrector, only: corrector_type, solution_point_type
   use geartrain_continuation_recorder, only: recorder_type
   use geartrain_continuation_singular_search, only: find_crossing
   use geartrain_continuation_special_points, only: add_special_point, locate_fold
   use geartrain_continuation_stability_changes, only: add_stability_changes
   use geartrain_continuation_step_geometry, only: closes, hides_folds, passes_half_period, sense_of, way_to
   use geartrain_continuation_step_length, only: acceptable, crosses_branch, jump_step, large, next_step
   use geartrain_linalg_trigonometric, only: transform_length
   use geartrain_model_system, only: system_type
   implicit none (type, external)
   private
   public :: tracer_type, reached_end, came_back, closed_loop, left_by_amplitude, cancelled, stuck, full, met_half_period

   !> How a trace ended.
   integer, parameter :: reached_end = 1, came_back = 2, closed_loop = 3, left_by_amplitude = 4, cancelled = 5, stuck = 6, &
                         full = 7, met_half_period = 8

   real(dp), parameter :: first_step = 0.01_dp, smallest_step = 1e-9_dp
   !> Share of the tolerance aimed at, so that a few points more keep within it, and how much lower the number of harmonics must be
   !> able to get to be lowered: each change plans the balance anew.
   real(dp), parameter :: tolerance_share = 0.3_dp, worth_lowering = 0.75_dp

   type :: tracer_type
      type(response_settings_type) :: settings
      type(system_type) :: system
      real(dp) :: amplitude_limit = huge(1.0_dp)
      type(corrector_type) :: corrector
      type(recorder_type) :: recorder
      !> What the observer is told: 'response', or 'branch' for a further one.
      character(8) :: analysis = 'response'
      !> Number of the segment of the branch that is traced.
      integer :: segment = 1
      !> Points and special points of the branch before the step under way.
      integer :: kept(2) = 0
      !> The next trace goes on from branch%trace.
      logical :: resumes = .false.
      !> Points that miss the tolerance, where the number of harmonics is left to the program.
      integer :: missed = 0
      type(error_estimate_type) :: estimate
      !> Evaluations at the latest error estimate.
      integer, private :: estimated = -1
      !> Change of the tangent's Lambda part along the branch, at the latest step.
      real(dp), private :: curvature = 0
   contains
      procedure :: prepare, record, trace, adapt, estimate_error, tell_missed, note_state, restore_state
      procedure, private :: relax, solve_again, stop_at, add_fold, add_changes
   end type tracer_type

contains

   !> Plans the balance for `harmonics` harmonics.
   subroutine prepare(self, harmonics)
      class(tracer_type), intent(inout) :: self
      integer, intent(in) :: harmonics
      integer :: samples

      samples = 0
      if (self%settings%coefficients == 'sampled') then
         samples = self%settings%samples
         if (samples == 0) samples = max(1024, transform_length(16*harmonics))
      end if
      call self%corrector%balance%setup(self%system, harmonics, self%settings%subharmonic, samples)
      call self%corrector%setup()
      self%corrector%local_control = self%settings%control == 'local'
   end subroutine prepare

   !> Adds a solution point, the last one that `corrector` worked on, to the branch.
   subroutine record(self, solution, branch)
      class(tracer_type), intent(inout) :: self
      type(solution_point_type), intent(in) :: solution
      type(branch_type), intent(inout), target :: branch

      call self%estimate_error(solution)
      if (self%settings%harmonics == 0 .and. self%estimate%limited > self%settings%tolerance) self%missed = self%missed + 1
      call self%recorder%add(self%corrector%balance, solution, self%estimate, self%segment, branch)
   end subroutine record

   !> Estimates the error of the solution point that `corrector` worked on last, unless it is known.
   subroutine estimate_error(self, solution)
      class(tracer_type), intent(inout) :: self
      type(solution_point_type), intent(in) :: solution

      if (self%estimated == self%corrector%evaluations) return
      self%estimated = self%corrector%evaluations
      associate (c => self%corrector, s => solution)
         call find_error_estimate(c%balance, s%u, s%frequency_ratio, s%tangent, s%tangent_frequency, self%curvature, &
                                  c%units%frequency_ratio, c%matrix, self%estimate)
      end associate
   end subroutine estimate_error

   !> Follows the branch from `here` (solved, oriented, already a point of the branch) within [low, high]. Of the two bounds
   !> `target` is the end and the other one a return. Where the branch passes the amplitude limit `here` becomes that point.
   subroutine trace(self, here, low, high, target, branch, outcome, reason, observer, began, point)
      class(tracer_type), intent(inout) :: self
      type(solution_point_type), intent(inout) :: here
      real(dp), intent(in) :: low, high, target
      type(branch_type), intent(inout), target :: branch
      integer, intent(out) :: outcome
      character(:), allocatable, intent(out) :: reason
      class(observer_type), intent(inout), optional :: observer
      !> Where the branch began, and closes: `here` unless it is given. Kept up to date where the branch leaves by the limit.
      type(solution_point_type), intent(inout), optional :: began
      !> Which point of the branch `here` is: the latest one unless it is given.
      integer, intent(in), optional :: point
      type(solution_point_type) :: next, origin, fold
      real(dp) :: h, way, longer, gap, fold_at, crossing
      integer :: steps, mesh, before, sense
      logical :: success, keep_going, meets, crosses, located, at_bound, closing

      before = branch%points
      if (present(point)) before = point
      next = here
      origin = here
      if (present(began)) origin = began
      sense = sense_of(here, self%corrector%units)
      h = min(first_step, self%settings%step)
      steps = 0
      closing = .false.
      if (self%resumes) then
         self%resumes = .false.
         here = branch%trace%here
         origin = branch%trace%origin
         h = branch%trace%step
         steps = branch%trace%steps
         sense = branch%trace%sense
      end if
      do
         ! What the interrupt came upon goes, the point before the first step as well.
         if (.not. self%system%interrupt%raised()) self%kept = [branch%points, size(branch%special_points)]
         if (closing) then
            next = origin
            call self%corrector%solve_at(next, success)
            if (success) call self%corrector%orient(next, merge(1, -1, origin%tangent_frequency > 0))
         else
            call self%corrector%advance(here, h, next, success)
            if (success) success = acceptable(self%corrector, here, next, h)
            if (success) success = h < jump_step .or. .not. hides_folds(here, next, self%corrector%units, h)
         end if
         way = h
         at_bound = success .and. .not. closing .and. (next%frequency_ratio < low .or. next%frequency_ratio > high)
         crosses = .false.
         located = .false.
         if (at_bound) then
            call self%stop_at(merge(low, high, next%frequency_ratio < low), here, next, h, success)
            way = way_to(here, next, self%corrector%units)
         else if (success .and. .not. closing) then
            longer = next_step(self%corrector, here, next, h, &
                               self%settings%step*max(1.0_dp, self%corrector%length_of(next%u)/large))
            self%curvature = (next%tangent_frequency - here%tangent_frequency)/h
            crosses = crosses_branch(here, next)
            if (crosses) call find_crossing(self%corrector, here, h, crossing, located)
         end if
         if (success) call self%adapt(next, success, here, origin, fixed=at_bound .or. closing)
         if (closing .and. .not. success) exit
         if (.not. success) then
            h = h/3
            if (h >= smallest_step) cycle
            outcome = stuck
            reason = 'step below '//text(smallest_step)//' at Lambda = '//text(here%frequency_ratio)
            return
         end if

         fold_at = 0
         ! It goes on as its own mirror image, so that Lambda seems to turn there.
         meets = passes_half_period(here, next, self%settings%subharmonic)
         if (sense*sense_of(next, self%corrector%units) < 0 .and. .not. (meets .or. crosses)) &
            call self%add_fold(here, next, origin, way, before, fold, fold_at, branch)
         if (sense_of(next, self%corrector%units) /= 0) sense = sense_of(next, self%corrector%units)
         call self%record(next, branch)
         steps = steps + 1
         if (crosses .and. located .and. .not. meets) call add_branch_point(branch, crossing)
         call self%add_changes(here, next, way, fold, fold_at, before, branch)

         if (closing) exit
         if (at_bound) then
            outcome = merge(reached_end, came_back, abs(next%frequency_ratio - target) <= 0)
            reason = 'reached Lambda = '//text(next%frequency_ratio)
            if (outcome == came_back) reason = 'came back to Lambda = '//text(next%frequency_ratio)
            return
         end if
         if (meets) then
            outcome = met_half_period
            reason = 'met the branch of half its period at Lambda = '//text(next%frequency_ratio)
            return
         end if
         mesh = maxloc(branch%rms(:, branch%points), 1)
         ! It may begin beyond the limit and fall.
         if (branch%rms(mesh, branch%points) > max(self%amplitude_limit, branch%rms(mesh, before))) then
            outcome = left_by_amplitude
            reason = 'rms of mesh '//text(mesh)//' passed the amplitude limit '//text(self%amplitude_limit) &
                     //' at Lambda = '//text(next%frequency_ratio)
            here = next
            if (present(began)) began = origin
            return
         end if
         if (branch%points >= self%settings%max_points) then
            outcome = full
            reason = 'max_points = '//text(self%settings%max_points)//' reached at Lambda = '//text(next%frequency_ratio)
            return
         end if

         h = longer
         here = next
         before = branch%points
         call self%relax(here, origin)
         if (steps > 3) closing = closes(here, origin, h, self%corrector%units, gap) .and. .not. crosses_branch(here, origin)
         if (closing) h = gap

         ! Last in the loop: the observer may keep the branch, and another run go on from branch%trace.
         if (.not. present(observer) .or. closing) cycle
         if (allocated(branch%trace)) then
            call self%note_state(branch%trace)
            branch%trace%steps = steps
            branch%trace%step = h
            branch%trace%sense = sense
            branch%trace%here = here
            branch%trace%origin = origin
         end if
         keep_going = .true.
         call observer%on_step(trim(self%analysis), branch%points, here%frequency_ratio, keep_going)
         if (keep_going) cycle
         outcome = cancelled
         branch%cancelled = .true.
         reason = 'cancelled at Lambda = '//text(here%frequency_ratio)
         return
      end do
      outcome = closed_loop
      reason = 'closed where it began, at Lambda = '//text(origin%frequency_ratio)
   end subroutine trace

   !> Notes what outlives a trace: the next one, from the other end, begins with it.
   pure subroutine note_state(self, state)
      class(tracer_type), intent(in) :: self
      type(trace_state_type), intent(inout) :: state

      state%harmonics = self%corrector%balance%highest
      state%curvature = self%curvature
      state%missed = self%missed
   end subroutine note_state

   subroutine restore_state(self, state)
      class(tracer_type), intent(inout) :: self
      type(trace_state_type), intent(in) :: state

      if (self%corrector%balance%highest /= state%harmonics) call self%prepare(state%harmonics)
      self%curvature = state%curvature
      self%missed = state%missed
   end subroutine restore_state

   !> Solves at exactly `bound`, which lies between `here` and `next`; `next` becomes that solution point.
   subroutine stop_at(self, bound, here, next, h, success)
      class(tracer_type), intent(inout) :: self
      real(dp), intent(in) :: bound, h
      type(solution_point_type), intent(in) :: here
      type(solution_point_type), intent(inout) :: next
      logical, intent(out) :: success
      type(solution_point_type) :: guess
      real(dp) :: share

      share = (bound - here%frequency_ratio)/(next%frequency_ratio - here%frequency_ratio)
      guess = next
      guess%u = here%u + share*(next%u - here%u)
      guess%frequency_ratio = bound
      next = guess
      call self%corrector%solve_at(next, success)
      if (.not. success) return
      success = self%corrector%length_of(next%u - guess%u) < max(h, 1e-8_dp)
      if (success) call self%corrector%orient(next, merge(1, -1, bound > here%frequency_ratio))
   end subroutine stop_at

   !> Puts the fold between `here`, a point of the branch, and `next`, a distance `fold_at` from `here`, on the branch, and solves
   !> `next` again, which comes after it. fold_at = 0: it was not found, or is `here` itself.
   subroutine add_fold(self, here, next, origin, h, point, fold, fold_at, branch)
      class(tracer_type), intent(inout) :: self
      type(solution_point_type), intent(inout) :: here, next, origin
      real(dp), intent(in) :: h
      !> Which one `here` is.
      integer, intent(in) :: point
      type(solution_point_type), intent(inout) :: fold
      real(dp), intent(out) :: fold_at
      type(branch_type), intent(inout), target :: branch
      integer :: highest
      logical :: success, enough

      fold_at = 0
      if (sense_of(here, self%corrector%units) == 0) then
         call add_special_point(branch, 'fold', here%frequency_ratio, point, branch%rms(:, point))
         return
      end if
      do
         fold = next
         call locate_fold(self%corrector, here, next, h, fold, fold_at, success)
         if (.not. success) exit
         highest = self%corrector%balance%highest
         call self%adapt(fold, enough, here, origin)
         if (self%corrector%balance%highest == highest) exit
         ! With more harmonics it lies elsewhere.
         call self%corrector%refit(next)
      end do
      if (success) then
         call self%record(fold, branch)
         call add_special_point(branch, 'fold', fold%frequency_ratio, branch%points, branch%rms(:, branch%points))
      else
         fold_at = 0
      end if
      call self%corrector%advance(here, h, next, success)
   end subroutine add_fold

   !> Puts the branch point before the latest point on the list. By the lowest harmonics alone it may seem to be passed repeatedly.
   subroutine add_branch_point(branch, frequency_ratio)
      type(branch_type), intent(inout), target :: branch
      real(dp), intent(in) :: frequency_ratio
      integer, parameter :: nearby = 50

      associate (special => branch%special_points, n => branch%points)
         if (any(special%kind == 'branch point' .and. special%point > n - nearby &
                 .and. abs(special%frequency_ratio - frequency_ratio) < 1e-8_dp*frequency_ratio)) return
         call add_special_point(branch, 'branch point', frequency_ratio, n - 1, branch%rms(:, n))
      end associate
   end subroutine add_branch_point

   !> Changes of stability in the latest step, which began at `here`: before and after the fold, where it has one.
   subroutine add_changes(self, here, next, h, fold, fold_at, before, branch)
      class(tracer_type), intent(inout) :: self
      type(solution_point_type), intent(in) :: here, next, fold
      real(dp), intent(in) :: h, fold_at
      !> The point of the branch that `here` is.
      integer, intent(in) :: before
      type(branch_type), intent(inout), target :: branch

      if (.not. self%recorder%stability) return
      associate (corrector => self%corrector, monodromy => self%recorder%monodromy, n => branch%points)
         if (fold_at > 0) then
            call add_stability_changes(corrector, monodromy, here, fold, fold_at, before, n - 1, branch)
            call add_stability_changes(corrector, monodromy, fold, next, h - fold_at, n - 1, n, branch)
         else
            call add_stability_changes(corrector, monodromy, here, next, h, before, n, branch)
         end if
      end associate
   end subroutine add_changes

   !> With `harmonics = 0`: raises their number until `solution`, just solved, is within the tolerance; `here` and `origin` are
   !> padded alike. Where the balance of more harmonics finds no solution, all is as it was and `success` is false.
   subroutine adapt(self, solution, success, here, origin, fixed)
      class(tracer_type), intent(inout) :: self
      type(solution_point_type), intent(inout) :: solution
      logical, intent(out) :: success
      type(solution_point_type), intent(inout), optional :: here, origin
      !> Keeps Lambda as it is.
      logical, intent(in), optional :: fixed
      type(solution_point_type) :: before(3)
      integer :: highest, most, first

      success = .true.
      if (self%settings%harmonics > 0) return
      first = self%corrector%balance%highest
      most = most_harmonics(self%system, self%settings%subharmonic)
      before(1) = solution
      if (present(here)) before(2) = here
      if (present(origin)) before(3) = origin
      do
         call self%estimate_error(solution)
         highest = self%corrector%balance%highest
         if (self%estimate%limited <= self%settings%tolerance .or. highest >= most) return
         call self%prepare(min(most, max(highest + self%system%excitation_order, harmonics_for(self%estimate, &
                                         tolerance_share*self%settings%tolerance/self%estimate%limited))))
         call self%corrector%refit(solution)
         if (present(here)) call self%corrector%refit(here)
         if (present(origin)) call self%corrector%refit(origin)
         call self%solve_again(solution, success, fixed)
         if (.not. success) exit
      end do
      call self%prepare(first)
      solution = before(1)
      if (present(here)) here = before(2)
      if (present(origin)) origin = before(3)
      call self%solve_again(solution, success, fixed)
      success = .false.
   end subroutine adapt

   !> Solves a solution point that has a tangent after its number of harmonics changed: at the same Lambda if `fixed`.
   subroutine solve_again(self, solution, success, fixed)
      class(tracer_type), intent(inout) :: self
      type(solution_point_type), intent(inout) :: solution
      logical, intent(out) :: success
      logical, intent(in), optional :: fixed
      integer :: direction

      if (present(fixed)) then
         if (fixed) then
            direction = merge(1, -1, solution%tangent_frequency > 0)
            call self%corrector%solve_at(solution, success)
            if (success) call self%corrector%orient(solution, direction)
            return
         end if
      end if
      call self%corrector%correct(solution, success)
   end subroutine solve_again

   !> Lowers the number of harmonics for the points to come where `here`, the latest one, leaves room; never to less than half.
   subroutine relax(self, here, origin)
      class(tracer_type), intent(inout) :: self
      type(solution_point_type), intent(inout) :: here, origin
      type(solution_point_type) :: before(2)
      integer :: highest, fewer
      logical :: success

      if (self%settings%harmonics > 0) return
      highest = self%corrector%balance%highest
      fewer = max(fewest_harmonics(self%system, self%settings%subharmonic), highest/2, harmonics_for(self%estimate, &
                  tolerance_share*self%settings%tolerance/max(self%estimate%limited, tiny(1.0_dp))))
      if (fewer > worth_lowering*highest) return
      before = [here, origin]
      call self%prepare(fewer)
      call self%corrector%refit(here)
      call self%corrector%refit(origin)
      call self%corrector%correct(here, success)
      if (success) return
      call self%prepare(highest)
      here = before(1)
      origin = before(2)
   end subroutine relax

   !> Adds to the reason for the end how many points miss the tolerance; where all do, the branch is not what was asked for. Where
   !> it is nearly vertical a small error in Lambda is a large one at constant Lambda, which more harmonics hardly mend.
   subroutine tell_missed(self, branch)
      class(tracer_type), intent(in) :: self
      type(branch_type), intent(inout) :: branch
      integer :: steep

      if (self%settings%harmonics /= 0) return
      steep = count(branch%error_estimate(:branch%points) > self%settings%tolerance) - self%missed
      if (steep > 0) branch%ended = branch%ended//'; '//text(steep)//' points where it is nearly vertical miss the tolerance'
      if (self%missed == 0) return
      if (self%missed >= branch%points) branch%complete = .false.
      branch%ended = branch%ended//'; '//text(min(self%missed, branch%points))//' of '//text(branch%points) &
                     //' points miss the tolerance '//text(self%settings%tolerance)//' with '//text(branch%harmonics) &
                     //' harmonics at most'
   end subroutine tell_missed

end module geartrain_continuation_tracer
