!> Keeps a readable file of the results so far while long work goes on, and takes them up again in another run.
module geartrain_run_checkpoint
   use, intrinsic :: iso_fortran_env, only: int64, int8
   use geartrain_analyses_list, only: case_type, results_type
   use geartrain_base_error, only: error_type, fatal, status_file
   use geartrain_base_fields, only: fields_type
   use geartrain_base_kinds, only: dp, version
   use geartrain_base_observer, only: observer_type
   use geartrain_input_text, only: case_text
   use geartrain_results_file, only: exists, remove_file
   use geartrain_results_seal, only: read_seal
   use geartrain_run_results, only: open_results, take_results, write_results
   implicit none (type, external)
   private
   public :: checkpoint_type, take_up_checkpoint, check_partial

   !> Passes every step on to the caller's observer and writes the results so far when it is time. Once the caller has
   !> cancelled it answers no to every further step.
   type, extends(observer_type) :: checkpoint_type
      !> The caller's observer, if any.
      class(observer_type), pointer :: observer => null()
      type(case_type), pointer :: case => null()
      type(results_type), pointer :: results => null()
      !> File to write; empty: none.
      character(:), allocatable :: path
      !> Time before the first checkpoint and between two [s]; at the beginning no more than the run has taken so far, however long
      !> the writing takes, so that a run that is killed again and again gets on.
      real(dp) :: first = 0.3_dp, interval = 2
      !> Time that the latest one took [s]: where writing is slow, a tenth of the time at most goes into it.
      real(dp), private :: cost = 0
      !> Steps were done since the latest one.
      logical, private :: news = .false.
      logical, private :: cancelled = .false.
      integer(int64), private :: begin = -1, last = -1
      !> Of the file at `path` that this run has written or goes on from; not allocated: there is none. Another file is not touched.
      integer(int8), allocatable, private :: seal(:)
   contains
      procedure :: start
      procedure :: on_step
      procedure :: is_cancelled
      procedure :: write_now
      procedure :: remove
      procedure, private :: owns_place
   end type checkpoint_type

contains

   !> Begins to count the time.
   subroutine start(self, resumed)
      class(checkpoint_type), intent(inout) :: self
      !> The run goes on from the file at `path`, which becomes its own.
      logical, intent(in) :: resumed

      call system_clock(self%begin)
      self%last = self%begin
      if (resumed) call read_seal(self%path, self%seal)
   end subroutine start

   subroutine on_step(self, analysis, done, frequency_ratio, keep_going)
      class(checkpoint_type), intent(inout) :: self
      character(*), intent(in) :: analysis
      integer, intent(in) :: done
      real(dp), intent(in) :: frequency_ratio
      logical, intent(inout) :: keep_going
      integer(int64) :: now, rate
      real(dp) :: pause

      if (associated(self%observer)) call self%observer%on_step(analysis, done, frequency_ratio, keep_going)
      if (.not. keep_going) self%cancelled = .true.
      keep_going = .not. self%is_cancelled()
      ! After an interrupt in the midst of a step not all there is is whole.
      if (self%path == '' .or. self%case%train%interrupt%raised()) return
      self%news = .true.
      call system_clock(now, rate)
      pause = min(max(self%interval, 9*self%cost), max(self%first, real(self%last - self%begin, dp)/rate))
      if (real(now - self%last, dp)/rate < pause) return
      call self%write_now()
   end subroutine on_step

   !> Whether the caller has ended the work, by his observer or by the interrupt of the train.
   logical function is_cancelled(self)
      class(checkpoint_type), intent(in) :: self

      is_cancelled = self%cancelled .or. self%case%train%interrupt%raised()
   end function is_cancelled

   !> Where there is news. A checkpoint that cannot be written is no reason to lose the work: the final file tells. Nor is a file of
   !> another run in its place, which stays.
   subroutine write_now(self)
      class(checkpoint_type), intent(inout) :: self
      type(error_type), allocatable :: error
      integer(int64) :: begin, rate

      if (self%path == '' .or. .not. self%news) return
      self%news = .false.
      call system_clock(begin, rate)
      if (self%owns_place()) call write_results(self%path, self%case, self%results, error, self%seal)
      call system_clock(self%last)
      self%cost = real(self%last - begin, dp)/real(rate, dp)
   end subroutine write_now

   !> Removes the file, if it is this run's.
   subroutine remove(self)
      class(checkpoint_type), intent(inout) :: self

      if (self%path == '' .or. .not. allocated(self%seal)) return
      if (self%owns_place()) call remove_file(self%path)
   end subroutine remove

   !> Whether the file at `path` is this run's, or none is there.
   logical function owns_place(self)
      class(checkpoint_type), intent(in) :: self
      integer(int8), allocatable :: seal(:)

      owns_place = .not. exists(self%path)
      if (owns_place .or. .not. allocated(self%seal)) return
      call read_seal(self%path, seal)
      if (allocated(seal)) owns_place = all(seal == self%seal)
   end function owns_place

   !> A file at the place of the checkpoint that the run does not go on from is not its own: a run that was killed left it, or one
   !> is at work on it.
   subroutine check_partial(path, error)
      character(*), intent(in) :: path
      type(error_type), allocatable, intent(inout) :: error

      if (exists(path)) call fatal(error, path//': error: a run that was killed, or that is still at work, keeps its results &
                                   &there: go on with it (--resume), or remove or rename that file, or name another file with &
                                   &--output')
   end subroutine check_partial

   !> The results so far of a run of the same case, from its checkpoint.
   subroutine take_up_checkpoint(path, case, results, error)
      character(*), intent(in) :: path
      type(case_type), intent(in) :: case
      type(results_type), intent(out) :: results
      type(error_type), allocatable, intent(inout) :: error
      character(:), allocatable :: input, asked, written_by, wrong
      type(fields_type) :: fields

      call case_text(case, asked)
      call open_results(path, fields, input, written_by, wrong)
      if (wrong == '' .and. written_by /= version) wrong = 'it was written by another version of geartrain, '//written_by
      if (fields%count == 0) then
         call fatal(error, path//': error: cannot be resumed: it is no readable checkpoint of geartrain ('//wrong// &
                    '); it stays as it is', status_file)
      else if (wrong /= '') then
         call fatal(error, path//': error: cannot be resumed: '//wrong, status_file)
      else if (without_output(input) /= without_output(asked)) then
         call fatal(error, path//': error: cannot be resumed: it is the checkpoint of another case or of other settings; '// &
                    'begin anew, or name another file with --output')
      else
         call take_results(fields, case, results, wrong)
         if (wrong /= '') call fatal(error, path//': error: cannot be resumed: '//wrong//' in it does not agree with the rest', &
                                     status_file)
      end if
   end subroutine take_up_checkpoint

   pure integer function kept_length(text) result(length)
      character(*), intent(in) :: text

      length = index(text, new_line('a')//'&output', back=.true.)
      if (length == 0) length = len(text)
   end function kept_length

   !> The resolved case without its last group, which names the file alone.
   pure function without_output(text) result(rest)
      character(*), intent(in) :: text
      character(kept_length(text)) :: rest

      rest = text
   end function without_output

end module geartrain_run_checkpoint
