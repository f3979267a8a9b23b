!> Puts the first motion of a branch onto the harmonics that the tolerance needs.
module geartrain_trace_first_harmonics
   use geartrain_balance_chosen_harmonics, only: most_harmonics
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_observer, only: observer_type
   use geartrain_flow_integration_settings, only: integration_settings_type
   use geartrain_flow_settling, only: settle
   use geartrain_flow_start_state, only: state_of
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_trace_start, only: motion_at, solution_of
   use geartrain_trace_tracer, only: tracer_type
   implicit none (type, external)
   private
   public :: adapt_first

   !> Most unknowns of a balance that a branch begins with in this way: a point of more takes seconds.
   integer, parameter :: most_unknowns = 3200

contains

   !> Raises the number of harmonics as `adapt` does. Where Newton's method does not lead from few harmonics to more, as where many
   !> ring in a lightly damped mode, the flow from the motion of few settles on the exact one, which solves the balance with four
   !> times as many, and so on. Where none of those allowed holds the tolerance, the few stay.
   subroutine adapt_first(tracer, direction, solution, stopped, observer)
      type(tracer_type), intent(inout) :: tracer
      !> Sense of Lambda along the branch, 1 or -1.
      integer, intent(in) :: direction
      !> The motion, with its tangent.
      type(solution_point_type), intent(inout) :: solution
      !> The observer or an interrupt ended the flow.
      logical, intent(out) :: stopped
      !> Told of 'settling'; may end the flow.
      class(observer_type), intent(inout), optional :: observer
      type(integration_settings_type) :: integration
      type(solution_point_type) :: few
      type(motion_type) :: motion
      real(dp) :: state(tracer%system%states)
      integer :: fewest, highest, most, allowed
      logical :: success

      stopped = .false.
      call tracer%adapt(solution, success, fixed=.true.)
      if (success .or. tracer%chooses_sets .or. tracer%settings%coefficients == 'sampled') return
      associate (settings => tracer%settings, balance => tracer%corrector%balance)
         if (allocated(balance%path) .or. balance%has_long_period()) return
         fewest = balance%highest
         allowed = most_harmonics(tracer%system, settings%subharmonic, settings%repeats)
         most = min(allowed, most_unknowns/(2*max(1, balance%unknowns)))
         if (most <= fewest) return
         few = solution
         call state_of(tracer%system, motion_at(tracer, solution), state)
         integration%harmonics = 1 + most/settings%subharmonic
         call settle(tracer%system, solution%frequency_ratio, integration, state, motion, observer, stopped)
         if (stopped .or. motion%period == 0) return
         if (mod(settings%subharmonic, motion%period) /= 0) return
         highest = fewest
         do while (highest < most)
            highest = min(most, 4*highest)
            call tracer%prepare(highest)
            solution = solution_of(tracer, motion)
            call tracer%corrector%solve_at(solution, success)
            if (.not. success) cycle
            call tracer%corrector%orient(solution, direction)
            call tracer%estimate_error(solution)
            if (tracer%estimate%limited <= settings%tolerance .or. highest == allowed) return
         end do
      end associate
      call tracer%prepare(fewest)
      solution = few
      call tracer%corrector%solve_at(solution, success)
      call tracer%corrector%orient(solution, direction)
   end subroutine adapt_first

end module geartrain_trace_first_harmonics
