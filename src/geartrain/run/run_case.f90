!> Computes what a case asks for and writes it.
module geartrain_run_run_case
   use geartrain_analyses_case, only: case_type
   use geartrain_analyses_stability_map, only: stability_map
   use geartrain_base_error, only: error_type, fatal, status_ended_early
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_continuation_bifurcations, only: follow_bifurcations
   use geartrain_continuation_branch, only: branch_type
   use geartrain_continuation_islands, only: follow_attractors
   use geartrain_continuation_refinement, only: refine_branch
   use geartrain_continuation_response, only: response
   use geartrain_flow_attractors, only: attractors
   use geartrain_flow_sweep, only: sweep
   use geartrain_input_check, only: check_case
   use geartrain_model_modes, only: natural_modes
   use geartrain_results_file, only: check_place
   use geartrain_run_checkpoint, only: check_partial, checkpoint_type, take_up_checkpoint
   use geartrain_run_edges, only: locate_edges
   use geartrain_run_results, only: results_type, write_results
   implicit none (type, external)
   private
   public :: run_case

contains

   !> Runs the analyses of the case in the order modes, response with the branches that bifurcate from it, integration, attractors
   !> with the branches through them, stability map, refinement, and writes `path`. Meanwhile path.partial holds what there is so
   !> far, every 2 s or so; a file of that name that the run does not go on from is told as an error, and stays. An analysis that
   !> ends early is told by an error of status_ended_early after everything has been written; bad input and a place that cannot be
   !> written to are told before anything is computed.
   subroutine run_case(case, path, results, error, observer, resume)
      type(case_type), intent(in), target :: case
      !> The HDF5 file; empty: write nothing.
      character(*), intent(in) :: path
      type(results_type), intent(out), target :: results
      type(error_type), allocatable, intent(out) :: error
      class(observer_type), intent(inout), target, optional :: observer
      !> The checkpoint of another run of this case, path.partial of that time, to go on from; empty: begin anew.
      character(*), intent(in), optional :: resume
      type(checkpoint_type) :: checkpoint
      type(error_type), allocatable :: early
      logical :: resumed

      call check_case(case, error)
      if (allocated(error)) return
      resumed = .false.
      if (present(resume)) resumed = resume == path//'.partial'
      if (path /= '') call check_place(path, error)
      if (path /= '' .and. .not. (resumed .or. allocated(error))) call check_partial(path//'.partial', error)
      if (allocated(error)) return
      if (present(resume)) then
         if (resume /= '') call take_up_checkpoint(resume, case, results, error)
         if (allocated(error)) return
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
      if (allocated(early)) call fatal(error, early%message, early%status)
   end subroutine run_case

   !> Goes on from where `results` are, analysis by analysis; a branch of the list that was under way is traced again.
   !> `early` tells which analyses ended early and why, `error` that the input is bad.
   subroutine compute(case, results, early, error, checkpoint)
      type(case_type), intent(in) :: case
      type(results_type), intent(inout), target :: results
      type(error_type), allocatable, intent(inout) :: early, error
      type(checkpoint_type), intent(inout) :: checkpoint
      type(branch_type), allocatable :: known(:)
      logical :: followed
      integer :: i

      ! Refinement comes last: where it has begun, all branches are there, and following would see points that it changed.
      followed = .false.
      if (allocated(results%response)) followed = allocated(results%response%correction)
      if (.not. followed) call known_branches(results, known)
      if (case%modes) then
         allocate (results%modes)
         call natural_modes(case%train, results%modes, error)
         if (ended_early(error)) deallocate (results%modes)
         call set_aside(error, early)
         if (allocated(error)) return
      end if
      if (allocated(case%response)) then
         if (.not. allocated(results%response)) allocate (results%response)
         if (.not. is_done(results%response)) then
            call response(case%train, case%response, results%response, error, observer=checkpoint)
            call set_aside(error, early)
            if (allocated(error)) return
            call note_end(results%response, checkpoint)
         end if
         call tell('response', results%response%complete, results%response%ended, early)
         if ((case%response%period_doublings > 0 .or. case%response%branch_points) &
             .and. .not. (followed .or. checkpoint%is_cancelled())) &
            call follow_bifurcations(case%train, case%response, results%response, results%branches, error, checkpoint, known)
         if (allocated(error)) return
      end if
      if (allocated(case%integration) .and. .not. checkpoint%is_cancelled()) then
         ! A sweep can be long: what came before it is safe from here on.
         call checkpoint%write_now()
         if (.not. allocated(results%integration)) allocate (results%integration)
         if (.not. allocated(results%integration%ended)) &
            call sweep(case%train, case%integration, results%integration, error, checkpoint)
         call set_aside(error, early)
         if (allocated(error)) return
         call tell('integration', results%integration%complete, results%integration%ended, early)
      end if
      if (allocated(case%attractors) .and. .not. checkpoint%is_cancelled()) then
         call checkpoint%write_now()
         if (.not. allocated(results%attractors)) allocate (results%attractors)
         if (.not. allocated(results%attractors%ended)) &
            call attractors(case%train, case%attractors, results%attractors, error, checkpoint)
         if (allocated(error)) return
         call tell('attractors', results%attractors%complete, results%attractors%ended, early)
         if (case%attractors%follow .and. .not. (followed .or. checkpoint%is_cancelled())) &
            call follow_attractors(case%train, case%response, results%attractors, results%response, results%branches, error, &
                                   checkpoint, known)
         if (allocated(error)) return
      end if
      if (allocated(case%stability_map) .and. .not. checkpoint%is_cancelled()) then
         call checkpoint%write_now()
         if (.not. allocated(results%stability_map)) allocate (results%stability_map)
         if (.not. allocated(results%stability_map%ended)) &
            call stability_map(case%train, case%stability_map, results%stability_map, error, checkpoint)
         if (allocated(error)) return
         call tell('stability map', results%stability_map%complete, results%stability_map%ended, early)
      end if
      call refine_all(case, results, early, error, checkpoint)
      if (allocated(error)) return
      if (.not. checkpoint%is_cancelled()) call locate_edges(case, results, checkpoint)
      if (.not. allocated(results%branches)) return
      do i = 1, size(results%branches)
         associate (branch => results%branches(i))
            call tell('branch '//text(i)//', '//branch%origin//',', branch%complete, branch%ended, early)
         end associate
      end do
   end subroutine compute

   !> What a trace does after its last step belongs to the response, for whoever keeps time.
   subroutine note_end(response, checkpoint)
      type(branch_type), intent(in) :: response
      type(checkpoint_type), intent(inout) :: checkpoint
      logical :: keep_going

      if (checkpoint%is_cancelled() .or. response%points == 0) return
      keep_going = .true.
      call checkpoint%on_step('response', response%points, response%frequency_ratio(response%points), keep_going)
   end subroutine note_end

   !> The branches of the list that another run has traced to their end. The last one may be under way.
   subroutine known_branches(results, known)
      type(results_type), intent(inout) :: results
      type(branch_type), allocatable, intent(out) :: known(:)

      allocate (known(0))
      if (.not. allocated(results%branches)) return
      if (size(results%branches) > 0) known = results%branches(:size(results%branches) - 1)
      deallocate (results%branches)
   end subroutine known_branches

   !> Whether another run has traced a response to its end.
   pure logical function is_done(branch)
      type(branch_type), intent(in) :: branch

      is_done = allocated(branch%ended) .and. .not. allocated(branch%trace)
   end function is_done

   !> Last, since branches are followed and told apart by their balances.
   subroutine refine_all(case, results, early, error, checkpoint)
      type(case_type), intent(in) :: case
      type(results_type), intent(inout), target :: results
      type(error_type), allocatable, intent(inout) :: early, error
      type(checkpoint_type), intent(inout) :: checkpoint
      integer :: i

      if (.not. allocated(case%response) .or. checkpoint%is_cancelled()) return
      if (.not. case%response%refine) return
      call checkpoint%write_now()
      call refine_branch(case%train, results%response, error, checkpoint)
      if (allocated(error)) return
      if (checkpoint%is_cancelled()) call tell('response', .false., results%response%ended, early)
      if (.not. allocated(results%branches)) return
      do i = 1, size(results%branches)
         if (allocated(error) .or. checkpoint%is_cancelled()) return
         call refine_branch(case%train, results%branches(i), error, checkpoint)
      end do
   end subroutine refine_all

   !> Adds to `early` why an analysis is not complete.
   subroutine tell(name, complete, ended, early)
      character(*), intent(in) :: name, ended
      logical, intent(in) :: complete
      type(error_type), allocatable, intent(inout) :: early

      if (.not. complete) call fatal(early, name//' ended early: '//ended, status_ended_early)
   end subroutine tell

   logical function ended_early(error)
      type(error_type), allocatable, intent(in) :: error

      ended_early = .false.
      if (allocated(error)) ended_early = error%status == status_ended_early
   end function ended_early

   !> An analysis that could not go on does not keep the next from running.
   subroutine set_aside(error, early)
      type(error_type), allocatable, intent(inout) :: error, early

      if (.not. ended_early(error)) return
      call fatal(early, error%message, status_ended_early)
      deallocate (error)
   end subroutine set_aside

end module geartrain_run_run_case
