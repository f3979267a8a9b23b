!> Keeps a readable file of the results so far while long work goes on, and takes them up again in another run.
module geartrain_case_checkpoint
   use, intrinsic :: iso_fortran_env, only: int64, int8
   use geartrain_base_error, only: error_type, fatal, status_file
   use geartrain_base_kinds, only: dp
   use geartrain_base_observer, only: observer_type
   use geartrain_case_case, only: case_type
   use geartrain_case_text, only: case_text
   use geartrain_results_reading, only: read_state
   use geartrain_results_results, only: results_type, write_results
   use geartrain_results_state, only: pack_state, unpack_state
   implicit none (type, external)
   private
   public :: checkpoint_type, take_up_checkpoint

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
      real(dp) :: interval = 2, first = 0.5_dp
      !> Time that the latest one took [s]: where writing is slow, a tenth of the time at most goes into it.
      real(dp), private :: cost = 0
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
      if (real(now - self%last, dp)/rate < merge(max(self%interval, 9*self%cost), min(self%first, self%interval), &
                                                 self%written)) return
      call self%write_now()
   end subroutine on_step

   !> A checkpoint that cannot be written is no reason to lose the work: the final file tells.
   subroutine write_now(self)
      class(checkpoint_type), intent(inout) :: self
      type(error_type), allocatable :: error
      integer(int8), allocatable :: state(:)
      integer(int64) :: begin, rate

      if (self%path == '') return
      call system_clock(begin, rate)
      call pack_state(case_text(self%case), self%results, state)
      call write_results(self%path, self%case, self%results, error, state)
      call system_clock(self%last)
      self%cost = real(self%last - begin, dp)/real(rate, dp)
      self%written = .true.
   end subroutine write_now

   !> The results so far of a run of the same case, from its checkpoint.
   subroutine take_up_checkpoint(path, case, results, error)
      character(*), intent(in) :: path
      type(case_type), intent(in) :: case
      type(results_type), intent(inout) :: results
      type(error_type), allocatable, intent(inout) :: error
      character(:), allocatable :: input, wrong
      integer(int8), allocatable :: bytes(:)
      type(results_type) :: found

      call read_state(path, bytes)
      if (.not. allocated(bytes)) then
         call fatal(error, path//': error: cannot be resumed: it is no readable checkpoint of geartrain', status_file)
         return
      end if
      call unpack_state(bytes, input, found, wrong)
      if (wrong == '') then
         if (without_output(input) /= without_output(case_text(case))) then
            call fatal(error, path//': error: cannot be resumed: it is the checkpoint of another case or of other settings; '// &
                       'begin anew, or name another file with --output')
            return
         end if
      else
         call fatal(error, path//': error: cannot be resumed: '//wrong, status_file)
         return
      end if
      results = found
   end subroutine take_up_checkpoint

   !> The resolved case without its last group, which names the file alone.
   pure function without_output(text) result(rest)
      character(*), intent(in) :: text
      character(:), allocatable :: rest
      integer :: at

      at = index(text, new_line('a')//'&output', back=.true.)
      rest = text
      if (at > 0) rest = text(:at)
   end function without_output

end module geartrain_case_checkpoint
