!> A branch traced through what lies beyond the amplitude limit, and one traced both ways from where it is first known.
module geartrain_continuation_through
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_continuation_branch, only: branch_type
   use geartrain_continuation_corrector, only: solution_point_type
   use geartrain_continuation_interruption, only: drop_step
   use geartrain_continuation_large_amplitude, only: came_down, left_range, lost, mirrored, pass_beyond
   use geartrain_continuation_points, only: put_in_front
   use geartrain_continuation_special_points, only: add_special_point
   use geartrain_continuation_tracer, only: came_back, cancelled, closed_loop, left_by_amplitude, met_half_period, reached_end, &
                                      tracer_type
   implicit none (type, external)
   private
   public :: trace_through, trace_both_ways, followed_out

   !> Outcomes beyond the amplitude limit, beside those of the tracer: it left the range of Lambda there; it comes back as its own
   !> mirror image.
   integer, parameter :: left_beyond = 101, mirrored_beyond = 102

contains

   !> Whether a branch was followed to where it leaves the range, or to where only what is known already follows.
   pure logical function followed_out(outcome)
      integer, intent(in) :: outcome

      followed_out = any(outcome == [reached_end, came_back, closed_loop, met_half_period, left_beyond, mirrored_beyond])
   end function followed_out

   !> Traces from `solution`, as the tracer does, and goes on wherever the branch comes back from beyond the amplitude limit. The
   !> pieces are parts of their own.
   subroutine trace_through(tracer, solution, target, branch, outcome, reason, observer, began, point)
      type(tracer_type), intent(inout) :: tracer
      type(solution_point_type), intent(inout) :: solution
      !> The bound of the range that is the end; the other one is a return.
      real(dp), intent(in) :: target
      type(branch_type), intent(inout), target :: branch
      integer, intent(out) :: outcome
      character(:), allocatable, intent(out) :: reason
      class(observer_type), intent(inout), optional :: observer
      !> Where the branch began, and closes; on the present harmonics.
      type(solution_point_type), intent(inout) :: began
      !> The point of the branch that `solution` is; the latest one unless it is given.
      integer, intent(in), optional :: point
      character(:), allocatable :: before
      real(dp) :: left_at, low, high
      integer :: beyond, first
      logical :: success

      low = min(tracer%settings%start, tracer%settings%stop)
      high = max(tracer%settings%start, tracer%settings%stop)
      before = ''
      ! A response under way may have come back already, in another run.
      if (allocated(branch%trace)) before = branch%trace%before
      first = branch%points
      if (present(point)) first = point
      do
         call tracer%trace(solution, low, high, target, branch, outcome, reason, observer, began, first)
         reason = before//reason
         if (outcome /= left_by_amplitude) return
         left_at = solution%frequency_ratio
         call pass_beyond(tracer, solution, low, high, beyond)
         if (beyond == left_range) then
            outcome = left_beyond
            reason = reason//' and left the range of Lambda beyond it'
         end if
         if (beyond == mirrored) then
            outcome = mirrored_beyond
            reason = reason//' and comes back as its own mirror image, shifted by half its period'
         end if
         if (beyond == lost) reason = reason//' and could not be followed beyond it; &
            &a larger amplitude_limit traces it there as usual'
         if (beyond /= came_down) return
         call tracer%adapt(solution, success, origin=began)
         before = before//'beyond the amplitude limit '//text(tracer%amplitude_limit)//' from Lambda = '//text(left_at) &
                  //' to '//text(solution%frequency_ratio)//'; '
         if (allocated(branch%trace)) branch%trace%before = before
         tracer%segment = tracer%segment + 1
         call tracer%record(solution, branch)
         first = branch%points
      end do
   end subroutine trace_through

   !> From `forward`, the only point of the branch so far, and, unless it closes, from `backward` the other way; the backward part
   !> is put in front, so that the branch is one curve.
   subroutine trace_both_ways(tracer, forward, backward, branch, where_from, observer, between)
      type(tracer_type), intent(inout) :: tracer
      type(solution_point_type), intent(inout) :: forward, backward
      type(branch_type), intent(inout), target :: branch
      !> Words for the place where it begins.
      character(*), intent(in) :: where_from
      class(observer_type), intent(inout), optional :: observer
      !> Lambda of the branch point between the two, where they are on either side of one; else they are the same point.
      real(dp), intent(in), optional :: between
      type(solution_point_type) :: began
      character(:), allocatable :: reason
      integer :: outcome, first_outcome, first_points
      logical :: success

      began = forward
      call trace_through(tracer, forward, tracer%settings%stop, branch, outcome, branch%ended, observer, began)
      call drop_step(tracer, branch)
      if (branch%cancelled) return
      branch%closed = outcome == closed_loop
      branch%complete = branch%closed
      if (branch%closed .or. outcome == cancelled) return
      first_outcome = outcome
      first_points = branch%points
      call tracer%corrector%refit(backward)
      call tracer%corrector%correct(backward, success)
      if (.not. success) then
         branch%ended = 'forwards from '//where_from//': '//branch%ended//'; backwards: Newton does not converge'
         return
      end if
      began = backward
      tracer%segment = tracer%segment + 1
      if (present(between)) then
         call add_special_point(branch, 'branch point', between, branch%points, branch%rms(:, 1))
         call tracer%record(backward, branch)
         call trace_through(tracer, backward, tracer%settings%stop, branch, outcome, reason, observer, began)
      else
         call trace_through(tracer, backward, tracer%settings%stop, branch, outcome, reason, observer, began, point=1)
      end if
      call drop_step(tracer, branch)
      call put_in_front(branch, first_points)
      branch%complete = followed_out(first_outcome) .and. followed_out(outcome)
      branch%ended = 'forwards from '//where_from//': '//branch%ended//'; backwards: '//reason
   end subroutine trace_both_ways

end module geartrain_continuation_through
