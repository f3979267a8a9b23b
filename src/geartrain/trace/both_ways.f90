!> Traces a branch in both directions from a point in its midst: from a seed or a branch point.
module geartrain_trace_both_ways
   use geartrain_base_kinds, only: dp
   use geartrain_base_observer, only: observer_type
   use geartrain_base_words, only: lambda, operator(//), words_type
   use geartrain_trace_branch, only: branch_type
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_trace_interruption, only: drop_step
   use geartrain_trace_large_amplitude, only: followed_out, trace_through
   use geartrain_trace_points, only: put_in_front
   use geartrain_trace_special_points, only: add_special_point
   use geartrain_trace_step_geometry, only: sense_of
   use geartrain_trace_step_length, only: carries_same
   use geartrain_trace_tracer, only: came_back, cancelled, closed_loop, reached_end, tracer_type
   implicit none (type, external)
   private
   public :: trace_both_ways

   !> Distance of a seed from a bound at which it is at the bound, over the bound: rounding of a change of units.
   real(dp), parameter :: at_bound = 1e-12_dp

contains

   !> Traces a branch from its first point in both directions. The points of the backward way are put in front, so that the branch
   !> is one curve. A branch that closes is traced once round.
   subroutine trace_both_ways(tracer, forward, backward, branch, where_from, observer, between, multiplicity)
      !> A tracer for the branch.
      type(tracer_type), intent(inout) :: tracer
      !> First points of the two ways: solved, with tangents that point away from each other; changed on return.
      type(solution_point_type), intent(inout) :: forward, backward
      !> Has one point, `forward`. A target: an observer may read it through a pointer.
      type(branch_type), intent(inout), target :: branch
      !> What the branch begins at, in words.
      character(*), intent(in) :: where_from
      !> Is told of each step, and may cancel.
      class(observer_type), intent(inout), optional :: observer
      !> Lambda of the branch point that lies between `forward` and `backward` [1]; absent: the two are one point.
      real(dp), intent(in), optional :: between
      !> Number of multipliers that pass +1 together there.
      integer, intent(in), optional :: multiplicity
      type(solution_point_type) :: began, first
      type(words_type), allocatable :: reason
      real(dp) :: gap
      integer :: outcome, first_outcome, first_points
      logical :: success

      began = forward
      first = forward
      call trace_way(tracer, forward, branch, outcome, branch%ended, observer, began)
      call drop_step(tracer, branch)
      if (branch%cancelled) return
      branch%closed = outcome == closed_loop
      branch%complete = branch%closed
      if (branch%closed .or. outcome == cancelled) return
      first_outcome = outcome
      first_points = branch%points
      ! With the harmonics that it was solved with: with others a fold beside it may lie on its other side, and be on neither way.
      call tracer%prepare(backward%harmonic(size(backward%harmonic)), backward%harmonic)
      call tracer%corrector%correct(backward, success)
      if (.not. success) then
         branch%ended = 'forwards from '//where_from//': '//branch%ended//'; backwards: Newton does not converge'
         return
      end if
      began = backward
      tracer%segment = tracer%segment + 1
      if (present(between)) then
         if (.not. carries_same(first, backward)) call tracer%corrector%refit(first)
         gap = tracer%corrector%length_of(backward%u - first%u, backward%frequency_ratio - first%frequency_ratio)
         call add_special_point(branch, 'branch point', between, branch%points, branch%rms(:, 1), multiplicity, gap/2)
         call tracer%record(backward, branch)
         branch%arclength(branch%points) = gap
         call trace_way(tracer, backward, branch, outcome, reason, observer, began)
      else
         call trace_way(tracer, backward, branch, outcome, reason, observer, began, point=1)
      end if
      call drop_step(tracer, branch)
      call put_in_front(branch, first_points)
      branch%complete = followed_out(first_outcome) .and. followed_out(outcome)
      branch%ended = 'forwards from '//where_from//': '//branch%ended//'; backwards: '//reason
   end subroutine trace_both_ways

   !> Traces one way; of the two ways of a seed at a bound of the range one leads out of it, and ends where it begins.
   subroutine trace_way(tracer, solution, branch, outcome, reason, observer, began, point)
      type(tracer_type), intent(inout) :: tracer
      !> As of `trace_through`.
      type(solution_point_type), intent(inout) :: solution, began
      type(branch_type), intent(inout), target :: branch
      integer, intent(out) :: outcome
      type(words_type), allocatable, intent(out) :: reason
      class(observer_type), intent(inout), optional :: observer
      integer, intent(in), optional :: point
      real(dp) :: bound

      bound = min(tracer%settings%start, tracer%settings%stop)
      if (sense_of(solution, tracer%corrector%units) > 0) bound = max(tracer%settings%start, tracer%settings%stop)
      if (abs(solution%frequency_ratio - bound) > at_bound*abs(bound)) then
         call trace_through(tracer, solution, tracer%settings%stop, branch, outcome, reason, observer, began, point)
         return
      end if
      outcome = merge(reached_end, came_back, abs(bound - tracer%settings%stop) <= 0)
      reason = lambda(bound)//' is the end of the range'
      tracer%kept = [branch%points, size(branch%special_points)]
   end subroutine trace_way

end module geartrain_trace_both_ways
