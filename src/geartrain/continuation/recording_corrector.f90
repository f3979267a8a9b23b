!> A corrector that records the solution points of a branch, with their error estimates.
module geartrain_continuation_recording_corrector
   use geartrain_continuation_adaptive_corrector, only: adaptive_corrector_type
   use geartrain_continuation_branch, only: branch_type
   use geartrain_continuation_corrector, only: solution_point_type
   use geartrain_continuation_recorder, only: recorder_type
   implicit none (type, external)
   private
   public :: recording_corrector_type

   type, extends(adaptive_corrector_type) :: recording_corrector_type
      type(recorder_type) :: recorder
      !> Number of the segment of the branch that is traced.
      integer :: segment = 1
      !> Points that miss the tolerance, where harmonics = 0.
      integer :: missed = 0
   contains
      procedure :: record
   end type recording_corrector_type

contains

   !> Adds a solution point to the branch.
   subroutine record(self, solution, branch)
      class(recording_corrector_type), intent(inout) :: self
      !> Solution point that `corrector` worked on last.
      type(solution_point_type), intent(in) :: solution
      !> Branch that `recorder` was set up for.
      type(branch_type), intent(inout), target :: branch

      call self%estimate_error(solution)
      if (self%settings%harmonics == 0 .and. self%estimate%limited > self%settings%tolerance) self%missed = self%missed + 1
      call self%recorder%add(self%corrector%balance, solution, self%estimate, self%segment, branch)
   end subroutine record

end module geartrain_continuation_recording_corrector
