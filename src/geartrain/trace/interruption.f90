!> Removes from a branch the step in which the trace was interrupted: its points may be wrong.
module geartrain_trace_interruption
   use geartrain_base_words, only: lambda, operator(//), words_type
   use geartrain_trace_branch, only: branch_type
   use geartrain_trace_tracer, only: tracer_type
   implicit none (type, external)
   private
   public :: drop_step

contains

   !> If the interrupt is raised, cuts the branch back to the points before the latest step and marks the branch as cancelled.
   subroutine drop_step(tracer, branch)
      !> The tracer of the branch: interrupt, and number of points before the step.
      type(tracer_type), intent(in) :: tracer
      !> Branch under way; unchanged unless interrupted.
      type(branch_type), intent(inout) :: branch

      if (.not. tracer%system%interrupt%raised()) return
      branch%points = min(branch%points, tracer%kept(1))
      if (allocated(branch%special_points)) &
         branch%special_points = branch%special_points(:min(size(branch%special_points), tracer%kept(2)))
      branch%ended = words_type('cancelled before its first point')
      if (branch%points > 0) branch%ended = 'cancelled at '//lambda(branch%frequency_ratio(branch%points))
      branch%complete = .false.
      branch%closed = .false.
      branch%cancelled = .true.
   end subroutine drop_step

end module geartrain_trace_interruption
