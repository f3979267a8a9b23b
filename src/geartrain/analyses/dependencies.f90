!> What one analysis needs of another: branches that follow from the response and from attractors. Once all branches are traced they
!> are refined and the edges of contact are located.
module geartrain_analyses_dependencies
   use geartrain_analyses_attractor_branches, only: follow_attractors
   use geartrain_base_words, only: words_type
   use geartrain_readings_frequency_text, only: frequency_text_type, text_for
   use geartrain_analyses_list, only: case_type, results_type
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: real_text
   use geartrain_base_observer, only: observer_type
   use geartrain_bifurcation_bifurcations, only: follow_bifurcations
   use geartrain_trace_branch, only: branch_type
   use geartrain_readings_contact_edges, only: locate_contact_edges
   use geartrain_exact_exact_point, only: refine_special_points
   use geartrain_exact_refinement, only: refine_branch
   use geartrain_trace_response_variables, only: settings_for
   use geartrain_network_frequency_unit, only: lambda_per
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: asks_refinement, check_agreement, follow_branches, keep_branches, locate_edges, name_parameter, refine_branches, &
      take_known

contains

   !> Checks the groups of a case against one another.
   subroutine check_agreement(case, seeded, checker)
      type(case_type), intent(in) :: case
      !> Whether an analysis may start from a given motion.
      logical, intent(in) :: seeded
      class(checker_type), intent(inout) :: checker

      if (checker%problems%in_group('response')) return
      if (allocated(case%locus) .and. .not. seeded) then
         call checker%enter('locus', 1)
         call need_response('near', real_text(case%locus%near), ', which has the special point', 'near', case%locus%near, &
                            case%locus%unit, '')
         call checker%leave()
      end if
      if (.not. allocated(case%attractors)) return
      if (.not. case%attractors%follow) return
      call checker%enter('attractors', 1)
      call need_response('follow', '.true.', ': its range and settings are those of the branches', 'frequency', &
                         case%attractors%frequency, case%attractors%unit, ', where follow = .true.')
      call checker%leave()

   contains

      !> Complains where there is no response over frequency, or a frequency lies outside its range.
      subroutine need_response(asks, value, why, name, frequency, unit, where_)
         !> Variable that asks for it, its value, and what it is needed for, with a mark before it.
         character(*), intent(in) :: asks, value, why
         !> Name of the frequency.
         character(*), intent(in) :: name
         !> The frequency, in its unit.
         real(dp), intent(in) :: frequency
         character(*), intent(in) :: unit
         !> Words at the end of what is said of the frequency.
         character(*), intent(in) :: where_
         real(dp) :: low, high, at, factor

         if (.not. allocated(case%response)) then
            call checker%complain(asks, value, 'needs &response'//why)
         else if (case%response%parameter /= '') then
            call checker%complain(asks, value, 'needs a &response over frequency, not over a parameter')
         else
            low = min(case%response%start, case%response%stop)
            high = max(case%response%start, case%response%stop)
            at = frequency*lambda_per(case%train, unit)
            factor = lambda_per(case%train, case%response%unit)
            ! That it lacks, or has a unit that the train does not tell, is told elsewhere.
            if (.not. (at > 0 .and. factor > 0)) return
            if (at < low*factor .or. at > high*factor) &
               call checker%complain(name, real_text(frequency), 'must lie in the range of &response, '//real_text(low)//' to '// &
                                     real_text(high)//where_)
         end if
      end subroutine need_response

   end subroutine check_agreement

   !> Leaves out of a case every analysis that no branch comes from.
   subroutine keep_branches(case)
      type(case_type), intent(inout) :: case
      type(case_type) :: kept

      kept%train = case%train
      call move_alloc(case%response, kept%response)
      if (allocated(case%attractors)) then
         if (case%attractors%follow) call move_alloc(case%attractors, kept%attractors)
      end if
      call move_alloc(case%output_file, kept%output_file)
      case = kept
   end subroutine keep_branches

   !> Moves the further branches that another run has traced out of its results, and drops the last branch, which may be under way.
   subroutine take_known(results, known)
      !> Results of the other run, then without further branches; as they are where `known` is not allocated.
      type(results_type), intent(inout) :: results
      !> The branches. Not allocated: refinement has begun, hence all branches are traced, and none may be followed from refined
      !> points.
      type(branch_type), allocatable, intent(out) :: known(:)

      if (allocated(results%response)) then
         if (allocated(results%response%correction)) return
      end if
      allocate (known(0))
      if (.not. allocated(results%branches)) return
      if (size(results%branches) > 0) known = results%branches(:size(results%branches) - 1)
      deallocate (results%branches)
   end subroutine take_known

   !> Adds the branches that follow from the result of an analysis. `error` tells that the input is bad.
   subroutine follow_branches(name, case, results, error, observer, known)
      !> Name of the analysis.
      character(*), intent(in) :: name
      type(case_type), intent(in) :: case
      !> The results; `branches` becomes longer.
      type(results_type), intent(inout), target :: results
      type(error_type), allocatable, intent(out) :: error
      !> Told of each point of 'branch'; may end the trace.
      class(observer_type), intent(inout) :: observer
      !> The first branches, if another run has traced them already.
      type(branch_type), intent(in), optional :: known(:)
      integer :: i

      select case (name)
      case ('response')
         if (case%response%period_doublings > 0 .or. case%response%branch_points) &
            call follow_bifurcations(case%train, case%response, results%response, results%branches, error, observer, known)
         if (.not. allocated(results%branches)) return
         do i = 1, size(results%branches)
            call name_parameter(case%train, results%branches(i))
         end do
      case ('attractors')
         if (case%attractors%follow) &
            call follow_attractors(case%train, case%response, results%attractors, results%response, results%branches, error, &
                                   observer, known)
      end select
   end subroutine follow_branches

   !> Names the parameter in the words of a branch over it, which else speak of Lambda.
   subroutine name_parameter(train, branch)
      !> The train of the branch.
      type(train_type), intent(in) :: train
      !> The branch; one over Lambda stays as it is.
      type(branch_type), intent(inout) :: branch
      type(frequency_text_type) :: told
      character(:), allocatable :: words

      if (.not. allocated(branch%parameter)) return
      told = text_for(branch, train, 'Lambda')
      if (allocated(branch%origin)) then
         call told%of_words(branch%origin, words)
         branch%origin = words_type(words)
      end if
      if (allocated(branch%ended)) then
         call told%of_words(branch%ended, words)
         branch%ended = words_type(words)
      end if
   end subroutine name_parameter

   !> Refines the response and the further branches if the case asks for refinement. Refinement comes last, because branches are
   !> followed and compared by their harmonic balances.
   subroutine refine_branches(case, results, error, observer, whole)
      type(case_type), intent(in) :: case
      !> The results with all branches.
      type(results_type), intent(inout), target :: results
      type(error_type), allocatable, intent(out) :: error
      !> Told of each point of 'refinement'; may end it.
      class(observer_type), intent(inout) :: observer
      !> .false.: the observer or an interrupt ended refinement before the last point.
      logical, intent(out) :: whole
      integer :: i

      whole = .true.
      if (.not. asks_refinement(case)) return
      call refine_all(case%train, results%response, error, observer, whole)
      if (.not. allocated(results%branches)) return
      do i = 1, size(results%branches)
         if (allocated(error) .or. .not. whole) return
         call refine_all(case%train, results%branches(i), error, observer, whole)
      end do
   end subroutine refine_branches

   !> Whether a case asks for refinement of its branches.
   pure logical function asks_refinement(case)
      type(case_type), intent(in) :: case

      asks_refinement = .false.
      if (allocated(case%response)) asks_refinement = case%response%refine
   end function asks_refinement

   !> Refines the points and the special points of a branch.
   subroutine refine_all(train, branch, error, observer, whole)
      type(train_type), intent(in) :: train
      type(branch_type), intent(inout) :: branch
      type(error_type), allocatable, intent(out) :: error
      class(observer_type), intent(inout) :: observer
      !> Whether each of them has been tried.
      logical, intent(out) :: whole

      whole = .false.
      call refine_branch(train, branch, error, observer)
      if (allocated(error) .or. branch%cancelled) return
      call refine_special_points(train, branch, observer)
      whole = .not. branch%cancelled
   end subroutine refine_all

   !> Locates the edges of separation and back collision of all branches of a case, to be reported and written.
   subroutine locate_edges(case, results, observer)
      type(case_type), intent(in) :: case
      !> The results with all branches.
      type(results_type), intent(inout), target :: results
      !> Once it asks to end, the edges that are left are interpolated.
      class(observer_type), intent(inout), optional :: observer
      integer :: i

      if (.not. (allocated(case%response) .and. allocated(results%response))) return
      ! Those of a branch that was traced to its end are known, unless it was refined.
      if (.not. allocated(results%response%contact_edges)) &
         call locate_contact_edges(case%train, case%response, results%response, observer)
      if (.not. allocated(results%branches)) return
      do i = 1, size(results%branches)
         associate (branch => results%branches(i))
            if (.not. allocated(branch%contact_edges)) &
               call locate_contact_edges(case%train, settings_for(case%response, branch%subharmonic), branch, observer)
         end associate
      end do
   end subroutine locate_edges

end module geartrain_analyses_dependencies
