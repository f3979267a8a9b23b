!> The frequency response: the branch of periodic motions that begins with the motion from rest at `start`, through its folds, and
!> the branch that begins with the motion from rest at `stop`, unless both are one branch: exchanged ends give equal curves. From a
!> seed the branch is traced in both directions; an island becomes a closed curve.
module geartrain_analyses_response_branch
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_same_motion, only: is_same_motion
   use geartrain_base_error, only: error_type, fatal
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_base_words, only: lambda, operator(//), words_type
   use geartrain_exact_friction_response, only: friction_response
   use geartrain_flow_floating, only: can_float, note_of
   use geartrain_network_check_coupling, only: has_friction
   use geartrain_network_check_train, only: check_train
   use geartrain_network_system, only: system_type
   use geartrain_readings_contact_edges, only: locate_contact_edges
   use geartrain_readings_special_spacing, only: add_points_between
   use geartrain_readings_summary, only: gaps
   use geartrain_trace_both_ways, only: trace_both_ways
   use geartrain_trace_branch, only: branch_type, coefficients_of, response_settings_type
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_trace_first_harmonics, only: adapt_first
   use geartrain_trace_first_motion, only: find_start, flies_over_periods
   use geartrain_trace_interruption, only: drop_step
   use geartrain_trace_large_amplitude, only: followed_out, trace_through
   use geartrain_trace_points, only: drop_first, is_same_point
   use geartrain_trace_response_variables, only: check_response
   use geartrain_trace_start, only: add_harmonics, begin_trace, motion_at, solution_of
   use geartrain_trace_tracer, only: cancelled, closed_loop, reached_end, tracer_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: response

   !> Outcome, beside those of the tracer, of a trace that would begin where the branch so far ends.
   integer, parameter :: known_start = -1
   !> Relative difference of Lambda up to which a seed has the constant Lambda of a branch over a parameter.
   real(dp), parameter :: same_frequency = 1e-9_dp
   !> Part of Lambda in the tangent below which a seed is taken to be a fold, and how far from there the branch begins [units_type].
   real(dp), parameter :: off_fold = 1e-3_dp

contains

   !> Traces the response of a train. Fails on bad input only: a branch that ends early says why in branch%ended.
   subroutine response(train, settings, branch, error, seed, observer, checked)
      !> The train as described.
      type(train_type), intent(in) :: train
      !> Range, harmonics, step and what else &response asks for.
      type(response_settings_type), intent(in) :: settings
      !> The branch. With branch%trace allocated, as in a checkpoint of the same case, the trace goes on; else only branch%origin is
      !> kept. A target here and below: an observer may read the points so far through a pointer.
      type(branch_type), intent(inout), target :: branch
      type(error_type), allocatable, intent(out) :: error
      !> A motion to start from; its period, Lambda and coefficients are used.
      type(motion_type), intent(in), optional :: seed
      !> Told of each point of 'response', or of 'branch' with a seed; may end the trace.
      class(observer_type), intent(inout), optional :: observer
      !> Train and settings have been checked, for a response with such a motion; absent: they have not.
      logical, intent(in), optional :: checked
      type(system_type), target :: systems(2)
      type(tracer_type) :: tracer
      type(branch_type) :: empty
      logical :: checks, resumed

      resumed = .false.
      if (allocated(branch%trace)) resumed = branch%points > 0 .and. (branch%trace%steps > 0 .or. branch%trace%from_stop)
      if (.not. resumed) then
         call move_alloc(branch%origin, empty%origin)
         branch = empty
      end if
      checks = .true.
      if (present(checked)) checks = .not. checked
      if (checks) call check_train(train, error)
      if (checks .and. .not. allocated(error)) call check_response(train, settings, present(seed), error)
      if (.not. allocated(error) .and. present(seed)) call check_seed(train, seed, error)
      if (allocated(error)) return
      if (has_friction(train)) then
         call friction_response(train, settings, branch, error, seed, observer)
         if (.not. (allocated(error) .or. branch%cancelled)) call locate_contact_edges(train, settings, branch)
         return
      end if
      if (present(seed)) then
         call begin_trace(train, settings, systems, tracer, motion=seed)
         call tracer%recorder%setup(tracer%corrector%balance, settings%stability, branch, settings%shaft_torque, &
                                      settings%multipliers)
         tracer%analysis = 'branch'
         call trace_from_seed(tracer, seed, branch, observer)
      else
         call begin_trace(train, settings, systems, tracer)
         if (resumed) then
            ! `branch` has points already: the recorder is set up with an empty branch.
            call tracer%recorder%setup(tracer%corrector%balance, settings%stability, empty, settings%shaft_torque, &
                                      settings%multipliers)
            tracer%segment = branch%segment(branch%points)
            tracer%resumes = branch%trace%steps > 0
            tracer%kept = [branch%points, size(branch%special_points)]
            call tracer%restore_state(branch%trace)
         else
            call tracer%recorder%setup(tracer%corrector%balance, settings%stability, branch, settings%shaft_torque, &
                                      settings%multipliers)
            allocate (branch%trace)
         end if
         call trace_from_both_ends(train, tracer, tracer%settings%start, tracer%settings%stop, branch, observer)
         deallocate (branch%trace)
      end if
      call add_points_between(tracer, branch)
      call tracer%tell_missed(branch)
      call tracer%recorder%finish(branch)
      if (.not. branch%cancelled) call locate_contact_edges(train, settings, branch)
   end subroutine response

   !> Traces from `start` towards `stop`, unless branch%trace tells that this is done, then from `stop` towards `start`.
   subroutine trace_from_both_ends(train, tracer, start, stop, branch, observer)
      type(train_type), intent(in) :: train
      type(tracer_type), intent(inout) :: tracer
      real(dp), intent(in) :: start, stop
      type(branch_type), intent(inout), target :: branch
      class(observer_type), intent(inout), optional :: observer
      integer :: outcome
      type(words_type), allocatable :: reason

      outcome = 0
      if (.not. branch%trace%from_stop) then
         call trace_from_end(train, tracer, start, stop, branch, outcome, branch%ended, observer)
         branch%complete = outcome == reached_end
         branch%trace%whole = followed_out(outcome)
      end if
      call drop_step(tracer, branch)
      if (outcome == cancelled .or. branch%cancelled) return
      if (.not. branch%trace%from_stop) branch%trace%first_points = branch%points
      branch%trace%from_stop = .true.
      call trace_from_end(train, tracer, stop, start, branch, outcome, reason, observer)
      call drop_step(tracer, branch)
      if (branch%cancelled .and. outcome /= cancelled) outcome = known_start
      if (outcome /= known_start) then
         branch%complete = outcome == reached_end .or. branch%trace%whole .and. followed_out(outcome)
         ! Loops round either end need not meet.
         if (outcome == closed_loop) branch%complete = branch%complete .and. size(gaps(branch, [start, stop])) == 0
         branch%ended = 'from '//lambda(start)//': '//branch%ended//'; from '//lambda(stop)//': '//reason
      end if
      ! The trace from `stop` reached the first point of the trace from `start`: it holds all points of the trace from `start`.
      if (outcome == reached_end .and. branch%trace%first_points > 0) then
         if (is_same_point(branch, 1, branch%points)) call drop_first(branch, branch%trace%first_points)
      end if
   end subroutine trace_from_both_ends

   subroutine check_seed(train, seed, error)
      type(train_type), intent(in) :: train
      type(motion_type), intent(in) :: seed
      type(error_type), allocatable, intent(inout) :: error

      if (.not. allocated(seed%coefficients)) then
         call fatal(error, 'seed: has no coefficients')
      else if (size(seed%coefficients, 2) /= size(train%meshes)) then
         call fatal(error, 'seed: a motion of '//text(size(seed%coefficients, 2))//' meshes: the train has ' &
                    //text(size(train%meshes)))
      end if
   end subroutine check_seed

   !> Traces from one end of the range towards the other, and on where the branch rises above the amplitude limit. The outcome is
   !> `known_start` where the branch so far ends at the motion with which the trace would begin.
   subroutine trace_from_end(train, tracer, from, to, branch, outcome, reason, observer)
      type(train_type), intent(in) :: train
      type(tracer_type), intent(inout) :: tracer
      real(dp), intent(in) :: from, to
      type(branch_type), intent(inout), target :: branch
      integer, intent(out) :: outcome
      type(words_type), allocatable, intent(out) :: reason
      class(observer_type), intent(inout), optional :: observer
      type(solution_point_type) :: solution, began
      integer :: enough
      logical :: success, settled, stopped

      outcome = 0
      if (.not. tracer%resumes) then
         branch%trace%steps = 0
         branch%trace%before = words_type('')
         ! Not known yet: that at hand is of the trace from the other end.
         tracer%curvature = 0
         call tracer%note_state(branch%trace)
         call find_start(train, tracer, from, to, solution, success, enough, settled, stopped, observer)
         if (stopped .and. .not. tracer%system%interrupt%raised()) then
            call tell_cancelled()
            return
         end if
         if (.not. success) then
            reason = words_type('no motion of period '//text(tracer%settings%subharmonic)//' found to start from')
            if (enough > 0) then
               reason = reason//' with '//text(tracer%corrector%balance%highest)//' harmonics: there is one with '//text(enough)
            else if (settled) then
               reason = reason//': that on which time integration settles has more harmonics than a response takes, as where teeth &
                        &rattle without a load; follow it by &integration'
               if (tracer%settings%harmonics > 0) reason = reason//', or take harmonics = 0'
            else if (flies_over_periods(tracer)) then
               reason = reason//', neither from rest, by integration, nor by branches from other frequencies or from &
                        &a smaller stiffness variation'
            else
               reason = reason//', neither from rest, in a part of the long period by integration, nor by branches from other &
                        &frequencies or from a smaller stiffness variation: &integration flies on for longer, and may find one, as &
                        &where teeth rattle without a load'
            end if
            reason = reason//note_of(can_float(tracer%system))
            if (can_float(tracer%system) .and. any(abs(tracer%system%static_force(tracer%system%mesh_element)) > 0)) &
               reason = reason//'; without backlash in the meshes that idle, their teeth stay in contact and the others have their &
                        &response'
            return
         end if
         if (branch%points > 0) then
            if (is_last_point(tracer, solution, branch)) then
               outcome = known_start
               ! More harmonics, which the trace did not reach, may bring this motion within the tolerance.
               if (tracer%settings%harmonics > 0 .or. &
                   branch%error_estimate(branch%points) <= tracer%settings%tolerance) return
            end if
            tracer%segment = branch%segment(branch%points) + 1
         end if
         call tracer%corrector%orient(solution, merge(1, -1, to > from))
         call adapt_first(tracer, merge(1, -1, to > from), solution, stopped, observer)
         if (stopped .and. .not. tracer%system%interrupt%raised()) then
            call tell_cancelled()
            return
         end if
         if (outcome == known_start) then
            if (tracer%estimate%limited > tracer%settings%tolerance .or. is_last_point(tracer, solution, branch)) return
         end if
         call tracer%record(solution, branch)
      end if
      began = solution
      call trace_through(tracer, solution, to, branch, outcome, reason, observer, began)

   contains

      subroutine tell_cancelled()
         outcome = cancelled
         branch%cancelled = .true.
         reason = 'cancelled at '//lambda(from)
      end subroutine tell_cancelled

   end subroutine trace_from_end

   !> Whether a solution is the last point of the branch.
   logical function is_last_point(tracer, solution, branch)
      type(tracer_type), intent(inout) :: tracer
      type(solution_point_type), intent(in) :: solution
      type(branch_type), intent(in) :: branch
      type(motion_type) :: motion
      real(dp), allocatable :: last(:, :)
      integer :: n

      is_last_point = .false.
      if (abs(branch%frequency_ratio(branch%points) - solution%frequency_ratio) > 0) return
      motion = motion_at(tracer, solution)
      last = coefficients_of(branch, branch%points)
      n = min(size(motion%coefficients, 1), size(last, 1))
      is_last_point = is_same_motion(last(:n, :), motion%coefficients(:n, :))
   end function is_last_point

   !> Traces both ways from a seed and puts the backward points in front, so that the branch is one curve.
   subroutine trace_from_seed(tracer, seed, branch, observer)
      type(tracer_type), intent(inout) :: tracer
      type(motion_type), intent(in) :: seed
      type(branch_type), intent(inout), target :: branch
      class(observer_type), intent(inout), optional :: observer
      type(solution_point_type) :: solution, backward
      type(motion_type) :: own
      real(dp) :: low, high
      logical :: success, at_its_lambda

      low = min(tracer%settings%start, tracer%settings%stop)
      high = max(tracer%settings%start, tracer%settings%stop)
      if (seed%period < 1 .or. mod(tracer%settings%subharmonic, max(1, seed%period)) /= 0) then
         branch%ended = words_type('the seed has period '//text(seed%period)//', which does not divide subharmonic = ' &
                                   //text(tracer%settings%subharmonic))
         return
      end if
      own = seed
      if (allocated(tracer%corrector%balance%path)) then
         ! The seed is a motion of the train as it is.
         associate (path => tracer%corrector%balance%path)
            if (abs(seed%frequency_ratio - path%frequency_ratio) > same_frequency*path%frequency_ratio) then
               branch%ended = words_type('the seed has another frequency, '//text(seed%frequency_ratio)//' in place of ' &
                                         //text(path%frequency_ratio))
               return
            end if
            own%frequency_ratio = path%own_value
            if (.not. path%holds_train) then
               branch%ended = words_type('"'//path%name//'" has more than one value in the train of the seed, which is on no &
                                         &branch over it')
               return
            end if
         end associate
      end if
      if (own%frequency_ratio < low .or. own%frequency_ratio > high) then
         branch%ended = 'the seed at '//lambda(own%frequency_ratio)//' lies outside '//text(low)//' to '//text(high)
         return
      end if
      call solve_seed(tracer, own, low, high, solution, at_its_lambda, success)
      if (.not. success) then
         branch%ended = 'Newton does not converge from the seed at '//lambda(own%frequency_ratio)
         call drop_step(tracer, branch)
         return
      end if
      if (at_its_lambda) call tracer%corrector%orient(solution, merge(1, -1, tracer%settings%stop > tracer%settings%start))
      call tracer%adapt(solution, success, fixed=at_its_lambda)
      call leave_fold(tracer, low, high, solution)
      call tracer%record(solution, branch)
      backward = solution
      backward%tangent = -solution%tangent
      backward%tangent_frequency = -solution%tangent_frequency
      call trace_both_ways(tracer, solution, backward, branch, 'the seed', observer)
      call drop_step(tracer, branch)
   end subroutine trace_from_seed

   !> Goes a little along the branch from a seed at a fold, so that the fold lies on one of the two ways and is found there.
   subroutine leave_fold(tracer, low, high, solution)
      type(tracer_type), intent(inout) :: tracer
      !> The range, which the solution does not leave.
      real(dp), intent(in) :: low, high
      !> Solution with tangent; moved where the tangent has hardly a part in Lambda.
      type(solution_point_type), intent(inout) :: solution
      type(solution_point_type) :: beside
      logical :: success

      if (abs(solution%tangent_frequency) > off_fold*tracer%corrector%units%frequency_ratio) return
      call tracer%corrector%advance(solution, off_fold, beside, success)
      if (success .and. beside%frequency_ratio >= low .and. beside%frequency_ratio <= high) then
         solution = beside
      else
         ! The point is recorded by what the corrector worked on last.
         call tracer%corrector%correct(solution, success)
      end if
   end subroutine leave_fold

   !> Solves the balance next to a seed: at its Lambda or, where that fails as at a fold, beside it; with the first number of
   !> harmonics or, where the program chooses it, with twice or four times as many; where it chooses sets, with those that matter in
   !> the seed too.
   subroutine solve_seed(tracer, seed, low, high, solution, at_its_lambda, success)
      type(tracer_type), intent(inout) :: tracer
      type(motion_type), intent(in) :: seed
      !> The range, which the solution does not leave.
      real(dp), intent(in) :: low, high
      type(solution_point_type), intent(out) :: solution
      !> The solution has the Lambda of the seed, and no tangent yet.
      logical, intent(out) :: at_its_lambda, success
      integer :: i

      if (tracer%chooses_sets) call add_harmonics(tracer, seed)
      do i = 0, merge(2, 0, tracer%settings%harmonics == 0 .and. .not. tracer%chooses_sets)
         if (i > 0) call tracer%prepare(2*tracer%corrector%balance%highest)
         solution = solution_of(tracer, seed)
         call tracer%corrector%solve_at(solution, success)
         at_its_lambda = success
         if (success) return
         solution = solution_of(tracer, seed)
         call tracer%corrector%solve_beside(solution, success)
         if (success) success = solution%frequency_ratio >= low .and. solution%frequency_ratio <= high
         if (success) return
      end do
   end subroutine solve_seed

end module geartrain_analyses_response_branch
