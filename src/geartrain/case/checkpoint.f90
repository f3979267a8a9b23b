!> Keeps a readable file of the results so far while long work goes on.
module geartrain_case_checkpoint
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_observer, only: observer_type
   use geartrain_case_case, only: case_type
   use geartrain_results_results, only: results_type, write_results
   implicit none (type, external)
   private
   public :: checkpoint_type

   !> Passes every step on to the caller's observer and writes the results so far when it is time. Once the caller has
   !> cancelled it answers no to every further step.
   type, extends(observer_type) :: checkpoint_type
      !> The caller's observer, if any.
      class(observer_type), pointer :: observer => null()
      type(case_type), pointer :: case => null()
      type(results_type), pointer :: results => null()
      !> File to write; empty: none.
      character(:), allocatable :: path
      !> Least time between two checkpoints, and before the first one [s].
      real(dp) :: interval = 5, first = 0.5_dp
      logical :: cancelled = .false.
      integer(int64), private :: last = -1
      logical, private :: written = .false.
   contains
      procedure :: on_step
      procedure :: write_now
   end type checkpoint_type

contains

   subroutine on_step(self, analysis, done, frequency, keep_going)
      class(checkpoint_type), intent(inout) :: self
      character(*), intent(in) :: analysis
      integer, intent(in) :: done
      real(dp), intent(in) :: frequency
      logical, intent(inout) :: keep_going
      integer(int64) :: now, rate

      if (associated(self%observer)) call self%observer%on_step(analysis, done, frequency, keep_going)
      if (.not. keep_going) self%cancelled = .true.
      keep_going = .not. self%cancelled
      if (self%path == '') return
      call system_clock(now, rate)
      if (self%last < 0) self%last = now
      if (real(now - self%last, dp)/rate < merge(self%interval, min(self%first, self%interval), self%written)) return
      call self%write_now()
   end subroutine on_step

   !> A checkpoint that cannot be written is no reason to lose the work: the final file tells.
   subroutine write_now(self)
      class(checkpoint_type), intent(inout) :: self
      type(error_type), allocatable :: error

      if (self%path == '') return
      call write_results(self%path, self%case, self%results, error)
      call system_clock(self%last)
      self%written = .true.
   end subroutine write_now

end module geartrain_case_checkpoint
