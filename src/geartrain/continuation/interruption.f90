!> A branch that was interrupted in the midst of a step: what belongs to that step may be wrong and goes.
module geartrain_continuation_interruption
   use geartrain_base_numbers, only: text
   use geartrain_continuation_branch, only: branch_type
   use geartrain_continuation_tracer, only: tracer_type
   implicit none (type, external)
   private
   public :: drop_step

contains

   !> Where the work was interrupted, cuts the branch back to what was there before the latest step, and says so.
   subroutine drop_step(tracer, branch)
      type(tracer_type), intent(in) :: tracer
      type(branch_type), intent(inout) :: branch

      if (.not. tracer%system%interrupt%raised()) return
      branch%points = min(branch%points, tracer%kept(1))
      if (allocated(branch%special_points)) &
         branch%special_points = branch%special_points(:min(size(branch%special_points), tracer%kept(2)))
      branch%ended = 'cancelled before its first point'
      if (branch%points > 0) branch%ended = 'cancelled at Lambda = '//text(branch%frequency_ratio(branch%points))
      branch%complete = .false.
      branch%closed = .false.
      branch%cancelled = .true.
   end subroutine drop_step

end module geartrain_continuation_interruption
