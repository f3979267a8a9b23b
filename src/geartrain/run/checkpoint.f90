!> Keeps a readable file of the results so far while long work goes on, from which another run can go on.
module geartrain_run_checkpoint
   use, intrinsic :: iso_fortran_env, only: int64, int8
   use geartrain_analyses_list, only: case_type, results_type
   use geartrain_base_error, only: error_type, fatal, in_a_line, status_file
   use geartrain_base_fields, only: fields_type
   use geartrain_base_kinds, only: dp, version
   use geartrain_base_observer, only: observer_type
   use geartrain_input_text, only: case_text
   use geartrain_results_file, only: exists, remove_file
   use geartrain_results_seal, only: read_seal
   use geartrain_run_room, only: room_type
   use geartrain_run_results, only: open_results, take_results, write_results
   implicit none (type, external)
   private
   public :: checkpoint_type, take_up_checkpoint, check_partial

   !> Passes every step on to the caller's observer and writes the results so far from time to time. Once the caller has ended
   !> the work, `keep_going` is .false. at every further step.
   type, extends(observer_type) :: checkpoint_type
      !> The caller's observer, if any.
      class(observer_type), pointer :: observer => null()
      !> The case that runs.
      type(case_type), pointer :: case => null()
      !> The results so far.
      type(results_type), pointer :: results => null()
      !> File to write; empty: none.
      character(:), allocatable :: path
      !> Time before the first checkpoint [s], and between two checkpoints [s]. At the beginning a pause lasts no longer than the
      !> run so far, however long writing takes, so that a run that is killed again and again makes progress.
      real(dp) :: first = 0.3_dp, interval = 2
      !> Time that writing the latest checkpoint took [s]; at most a tenth of the time goes into writing.
      real(dp), private :: cost = 0
      !> Whether steps were done since the latest checkpoint.
      logical, private :: news = .false.
      !> Whether the caller's observer, or want of memory, has ended the work.
      logical, private :: cancelled = .false.
      !> Whether there is memory for more results.
      type(room_type) :: room
      !> Whether the latest checkpoint could not be written, which the observer has been told.
      logical, private :: failed = .false.
      !> Clock at the start of the run and at the latest checkpoint.
      integer(int64), private :: begin = -1, last = -1
      !> Seal of the file at `path` that this run has written or goes on from; not allocated: no such file. A file with another seal
      !> is not touched.
      integer(int8), allocatable, private :: seal(:)
   contains
      procedure :: start
      procedure :: on_step
      procedure :: is_cancelled
      procedure :: write_now
      procedure :: remove
      procedure, private :: owns_path
   end type checkpoint_type

contains

   !> Begins to count the time.
   subroutine start(self, resumed)
      class(checkpoint_type), intent(inout) :: self
      !> Whether the run goes on from the file at `path`, which it may then replace and remove.
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
      if (.not. self%case%train%interrupt%raised()) call self%room%look(analysis, self%case, self%results, keep_going)
      if (.not. keep_going) self%cancelled = .true.
      keep_going = .not. self%is_cancelled()
      ! An interrupt in the midst of a step leaves incomplete results. Modes are found again as fast as they are read.
      if (self%path == '' .or. analysis == 'modes' .or. self%case%train%interrupt%raised()) return
      self%news = .true.
      call system_clock(now, rate)
      pause = min(max(self%interval, 9*self%cost), max(self%first, real(self%last - self%begin, dp)/rate))
      if (real(now - self%last, dp)/rate < pause) return
      call self%write_now()
   end subroutine on_step

   !> Whether the caller has ended the work, by the observer or by the interrupt of the train.
   logical function is_cancelled(self)
      class(checkpoint_type), intent(in) :: self

      is_cancelled = self%cancelled .or. self%case%train%interrupt%raised()
   end function is_cancelled

   !> Writes a checkpoint if steps were done since the latest checkpoint. If the checkpoint cannot be written the observer is told,
   !> once until a checkpoint is written again, and the work goes on; so it does if `path` is a file of another run, which stays.
   subroutine write_now(self)
      class(checkpoint_type), intent(inout) :: self
      type(error_type), allocatable :: error
      integer(int64) :: begin, rate

      if (self%path == '' .or. .not. self%news) return
      self%news = .false.
      call system_clock(begin, rate)
      if (self%owns_path()) call write_results(self%path, self%case, self%results, error, self%seal)
      call system_clock(self%last)
      self%cost = real(self%last - begin, dp)/real(rate, dp)
      if (allocated(error) .and. .not. self%failed .and. associated(self%observer)) &
         call self%observer%on_trouble(in_a_line(error%message)//'; the run goes on without this checkpoint')
      self%failed = allocated(error)
   end subroutine write_now

   !> Removes the checkpoint, if this run has written it or goes on from it.
   subroutine remove(self)
      class(checkpoint_type), intent(inout) :: self

      if (self%path == '' .or. .not. allocated(self%seal)) return
      if (self%owns_path()) call remove_file(self%path)
   end subroutine remove

   !> Whether the file at `path` is of this run, or there is no file.
   logical function owns_path(self)
      class(checkpoint_type), intent(in) :: self
      integer(int8), allocatable :: seal(:)

      owns_path = .not. exists(self%path)
      if (owns_path .or. .not. allocated(self%seal)) return
      call read_seal(self%path, seal)
      if (allocated(seal)) owns_path = all(seal == self%seal)
   end function owns_path

   !> Tells as an error that there is a file at the path of the checkpoint, which a killed run left or another run is writing.
   subroutine check_partial(path, error)
      !> Path of the checkpoint, from which the run does not go on.
      character(*), intent(in) :: path
      type(error_type), allocatable, intent(inout) :: error

      if (exists(path)) call fatal(error, path//': error: a run that was killed, or that is still at work, keeps its results &
                                   &there: --resume goes on with it, --force removes it and begins anew, --output names another &
                                   &file')
   end subroutine check_partial

   !> Reads the results so far of another run of the same case.
   subroutine take_up_checkpoint(path, case, results, error)
      !> Path of the checkpoint.
      character(*), intent(in) :: path
      type(case_type), intent(in) :: case
      !> The results so far.
      type(results_type), intent(out) :: results
      type(error_type), allocatable, intent(inout) :: error
      character(:), allocatable :: input, asked, written_by, wrong
      type(fields_type) :: fields
      integer :: status

      call case_text(case, asked)
      call open_results(path, fields, input, written_by, wrong, status)
      if (wrong == '' .and. written_by /= version) wrong = 'it was written by another version of geartrain, '//written_by
      if (fields%count == 0) then
         call fatal(error, path//': error: cannot be resumed: it is no readable checkpoint of geartrain ('//wrong// &
                    '); it stays as it is', status)
      else if (wrong /= '') then
         call fatal(error, path//': error: cannot be resumed: '//wrong, status)
      else if (without_output(input) /= without_output(asked)) then
         call fatal(error, path//': error: cannot be resumed: it is the checkpoint of another case or of other settings; '// &
                    'begin anew, or name another file with --output')
      else
         call take_results(fields, case, results, wrong)
         if (wrong /= '') call fatal(error, path//': error: cannot be resumed: '//wrong, status_file)
      end if
   end subroutine take_up_checkpoint

   !> Length of the text of a case without its last group, &output.
   pure integer function kept_length(text) result(length)
      character(*), intent(in) :: text

      length = index(text, new_line('a')//'&output', back=.true.)
      if (length == 0) length = len(text)
   end function kept_length

   !> The text of a case without its last group, &output, which only names the file.
   pure function without_output(text) result(rest)
      character(*), intent(in) :: text
      character(kept_length(text)) :: rest

      rest = text
   end function without_output

end module geartrain_run_checkpoint
