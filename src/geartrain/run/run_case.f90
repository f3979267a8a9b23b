!> Computes what a case asks for and writes it.
module geartrain_run_run_case
   use geartrain_analyses_analysis, only: analysis_type, spoken
   use geartrain_analyses_dependencies, only: asks_refinement, follow_branches, locate_edges, refine_branches, take_known
   use geartrain_base_words, only: operator(//), words_type
   use geartrain_readings_frequency_text, only: frequency_text, frequency_text_type
   use geartrain_analyses_list, only: analyses, case_type, find_analysis, leave_out, number_of, results_type
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_error, only: error_type, fatal, status_ended_early, status_input, status_memory, words_of
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_trace_branch, only: branch_type
   use geartrain_input_check_case, only: check_case
   use geartrain_results_file, only: check_place, remove_temporary_files
   use geartrain_results_seal, only: check_replaceable
   use geartrain_run_checkpoint, only: check_partial, checkpoint_type, take_up_checkpoint
   use geartrain_run_results, only: write_results
   implicit none (type, external)
   private
   public :: out_of_memory, run_analysis, run_case

contains

   !> Runs the analyses of the case in the order of the list, each with the branches that follow from it, then refinement, and
   !> writes the results. Meanwhile the checkpoint path.partial is written about every 2 s; an existing file of this name is an
   !> error unless the run goes on from it. Bad input and a path that cannot be written are told before anything is computed; an
   !> analysis that ends early is told, with status_ended_early, after the results are written.
   subroutine run_case(case, path, results, error, observer, resume)
      type(case_type), intent(in), target :: case
      !> The HDF5 file; empty: write nothing.
      character(*), intent(in) :: path
      type(results_type), intent(out), target :: results
      type(error_type), allocatable, intent(out) :: error
      !> Told of each step; may end the work.
      class(observer_type), intent(inout), target, optional :: observer
      !> Checkpoint of another run of this case to go on from; empty: begin anew.
      character(*), intent(in), optional :: resume
      type(checkpoint_type) :: checkpoint
      type(error_type), allocatable :: early
      type(frequency_text_type) :: told
      character(:), allocatable :: message
      logical :: resumed

      call check_case(case, error)
      if (allocated(error)) return
      resumed = .false.
      if (present(resume)) resumed = resume == path//'.partial'
      if (path /= '') call check_place(path, error)
      if (path /= '' .and. .not. allocated(error)) call check_replaceable(path, error)
      if (path /= '' .and. .not. (resumed .or. allocated(error))) call check_partial(path//'.partial', error)
      if (allocated(error)) return
      if (present(resume)) then
         if (resume /= '') call take_up_checkpoint(resume, case, results, error)
         if (allocated(error)) return
      end if
      if (resumed) then
         call remove_temporary_files(path)
         call remove_temporary_files(path//'.partial')
      end if
      if (present(observer)) checkpoint%observer => observer
      checkpoint%case => case
      checkpoint%results => results
      checkpoint%path = ''
      if (path /= '') checkpoint%path = path//'.partial'
      call checkpoint%start(resumed)
      call compute(case, results, early, error, checkpoint)
      if (allocated(error)) return
      if (path /= '') call write_results(path, case, results, error)
      if (.not. allocated(error)) call checkpoint%remove()
      if (path /= '') call remove_temporary_files(path//'.partial')
      if (checkpoint%room%lacks) call out_of_memory(early)
      if (.not. allocated(early)) return
      told = frequency_text(case%train, 'Lambda', 0.0_dp)
      if (allocated(case%response)) told = frequency_text(case%train, case%response%unit, 0.0_dp)
      call told%of_words(words_of(early), message)
      call fatal(error, message, early%status, lines=.true.)
   end subroutine run_case

   !> Runs analysis by analysis, from the results so far on; a further branch that was under way is traced again. `early` tells
   !> which analyses ended early and why, `error` that the input is bad.
   subroutine compute(case, results, early, error, checkpoint)
      type(case_type), intent(in), target :: case
      type(results_type), intent(inout), target :: results
      type(error_type), allocatable, intent(inout) :: early, error
      type(checkpoint_type), intent(inout) :: checkpoint
      class(analysis_type), allocatable :: analysis
      type(branch_type), allocatable :: known(:)
      logical :: begun, whole
      integer :: i

      call take_known(results, known)
      begun = .false.
      do i = 1, size(analyses)
         call find_analysis(i, case, results, analysis)
         if (.not. analysis%asked .or. begun .and. checkpoint%is_cancelled()) cycle
         begun = .true.
         ! An analysis can take long: the results before it are saved first.
         call checkpoint%write_now()
         call find_analysis(i, case, results, analysis, begin=.true.)
         call analysis%run(case%train, error, checkpoint)
         if (ended_early(error)) then
            ! The next analysis runs although this analysis has no result.
            call fatal(early, words_of(error), error%status, lines=.true.)
            early%status = max(early%status, error%status)
            deallocate (error)
            call leave_out(i, results)
            cycle
         end if
         if (allocated(error)) return
         call tell(spoken(analyses(i)%name), analysis, early)
         if (allocated(known) .and. .not. checkpoint%is_cancelled()) &
            call follow_branches(trim(analyses(i)%name), case, results, error, checkpoint, known)
         if (allocated(error)) return
      end do
      if (asks_refinement(case) .and. .not. checkpoint%is_cancelled()) then
         call checkpoint%write_now()
         call refine_branches(case, results, error, checkpoint, whole)
         if (allocated(error)) return
         if (.not. whole) call fatal(early, 'response ended early: '//results%response%ended, status_ended_early)
      end if
      if (.not. checkpoint%is_cancelled()) call locate_edges(case, results, checkpoint)
      if (.not. allocated(results%branches)) return
      do i = 1, size(results%branches)
         associate (branch => results%branches(i))
            if (.not. branch%complete) call fatal(early, 'branch '//text(i)//', '//branch%origin//', ended early: '//branch%ended, &
                                                  status_ended_early)
         end associate
      end do
   end subroutine compute

   !> Runs one analysis of a case, with the branches that follow from it; the branches of a response are refined if the case asks
   !> for refinement.
   subroutine run_analysis(name, case, results, error, observer, start)
      !> Name of the analysis.
      character(*), intent(in) :: name
      type(case_type), intent(in), target :: case
      !> The results; a result of the analysis under way is taken up.
      type(results_type), intent(inout), target :: results
      type(error_type), allocatable, intent(out) :: error
      !> Told of each step; may end the work.
      class(observer_type), intent(inout) :: observer
      !> A motion to start from; ignored by an analysis that does not start from a motion.
      type(motion_type), intent(in), optional :: start
      class(analysis_type), allocatable :: analysis
      logical :: whole

      if (number_of(name) == 0) then
         call fatal(error, "analysis = '"//name//"': there is none of this name", status_input)
         return
      end if
      call find_analysis(number_of(name), case, results, analysis, begin=.true.)
      call analysis%run(case%train, error, observer, start)
      if (allocated(error) .or. case%train%interrupt%raised()) return
      call follow_branches(name, case, results, error, observer)
      if (allocated(error) .or. case%train%interrupt%raised() .or. name /= 'response') return
      call refine_branches(case, results, error, observer, whole)
   end subroutine run_analysis

   !> Adds to `early` that the run was ended for want of memory.
   subroutine out_of_memory(early)
      !> Gets status_memory.
      type(error_type), allocatable, intent(inout) :: early

      call fatal(early, 'there is no memory for more results; those so far are kept: compute fewer points, or allow more memory')
      early%status = status_memory
   end subroutine out_of_memory

   !> Adds to `early` why an analysis is not complete.
   subroutine tell(name, analysis, early)
      character(*), intent(in) :: name
      class(analysis_type), intent(in) :: analysis
      type(error_type), allocatable, intent(inout) :: early
      type(words_type), allocatable :: ended

      call analysis%tell_end(ended)
      if (allocated(ended)) call fatal(early, name//' ended early: '//ended, status_ended_early)
   end subroutine tell

   !> Whether an analysis ended early or has no memory, after which others can run.
   logical function ended_early(error)
      type(error_type), allocatable, intent(in) :: error

      ended_early = .false.
      if (allocated(error)) ended_early = error%status == status_ended_early .or. error%status == status_memory
   end function ended_early

end module geartrain_run_run_case
