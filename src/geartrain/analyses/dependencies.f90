!> What one analysis needs of another: branches that follow from the response and from attractors, refined and searched for the
!> edges of contact once all of them are there.
module geartrain_analyses_dependencies
   use geartrain_analyses_attractors, only: follow_attractors
   use geartrain_analyses_list, only: analyses, case_type, leave_out, results_type
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: real_text
   use geartrain_base_observer, only: observer_type
   use geartrain_continuation_bifurcations, only: follow_bifurcations
   use geartrain_continuation_branch, only: branch_type
   use geartrain_continuation_contact_edges, only: locate_contact_edges
   use geartrain_continuation_refinement, only: refine_branch
   use geartrain_continuation_variables, only: settings_for
   implicit none (type, external)
   private
   public :: asks_refinement, check_agreement, follow_branches, keep_branches, locate_edges, refine_branches, take_known

contains

   !> What single groups cannot say; the problems are added to those of `checker`.
   subroutine check_agreement(case, checker)
      type(case_type), intent(in) :: case
      class(checker_type), intent(inout) :: checker
      real(dp) :: low, high

      if (.not. allocated(case%attractors)) return
      if (.not. case%attractors%follow .or. checker%problems%in_group('response')) return
      call checker%enter('attractors', 1)
      if (.not. allocated(case%response)) then
         call checker%complain('follow', '.true.', 'needs &response: its range and settings are those of the branches')
      else
         low = min(case%response%start, case%response%stop)
         high = max(case%response%start, case%response%stop)
         if (case%attractors%frequency_ratio < low .or. case%attractors%frequency_ratio > high) &
            call checker%complain('frequency', real_text(case%attractors%frequency_ratio), &
                                  'must lie in the range of &response, '// &
                                  real_text(low)//' to '//real_text(high)//', where follow = .true.')
      end if
      call checker%leave()
   end subroutine check_agreement

   !> Leaves out of a case what no branch comes from.
   subroutine keep_branches(case)
      type(case_type), intent(inout) :: case
      integer :: i

      do i = 1, size(analyses)
         if (analyses(i)%name == 'response') cycle
         if (analyses(i)%name == 'attractors' .and. allocated(case%attractors)) then
            if (case%attractors%follow) cycle
         end if
         call leave_out(i, case)
      end do
   end subroutine keep_branches

   !> Takes the further branches that another run has traced to their end out of its results. The last one may be under way. Not
   !> allocated where refinement has begun: all branches are there then, and following would see points that it changed.
   subroutine take_known(results, known)
      type(results_type), intent(inout) :: results
      type(branch_type), allocatable, intent(out) :: known(:)

      if (allocated(results%response)) then
         if (allocated(results%response%correction)) return
      end if
      allocate (known(0))
      if (.not. allocated(results%branches)) return
      if (size(results%branches) > 0) known = results%branches(:size(results%branches) - 1)
      deallocate (results%branches)
   end subroutine take_known

   !> Adds the branches that follow from what the analysis `name` has found. `error` tells that the input is bad.
   subroutine follow_branches(name, case, results, error, observer, known)
      character(*), intent(in) :: name
      type(case_type), intent(in) :: case
      type(results_type), intent(inout), target :: results
      type(error_type), allocatable, intent(out) :: error
      class(observer_type), intent(inout) :: observer
      !> The first of the further branches, where another run has traced these already.
      type(branch_type), intent(in), optional :: known(:)

      select case (name)
      case ('response')
         if (case%response%period_doublings > 0 .or. case%response%branch_points) &
            call follow_bifurcations(case%train, case%response, results%response, results%branches, error, observer, known)
      case ('attractors')
         if (case%attractors%follow) &
            call follow_attractors(case%train, case%response, results%attractors, results%response, results%branches, error, &
                                   observer, known)
      end select
   end subroutine follow_branches

   !> Refines the response and the further branches where that was asked for: last, since branches are followed and told apart by
   !> their balances.
   subroutine refine_branches(case, results, error, observer, whole)
      type(case_type), intent(in) :: case
      type(results_type), intent(inout), target :: results
      type(error_type), allocatable, intent(out) :: error
      class(observer_type), intent(inout) :: observer
      !> False where the observer has ended it.
      logical, intent(out) :: whole
      integer :: i

      whole = .true.
      if (.not. asks_refinement(case)) return
      call refine_branch(case%train, results%response, error, observer)
      if (allocated(error)) return
      whole = is_refined(results%response)
      if (.not. allocated(results%branches)) return
      do i = 1, size(results%branches)
         if (.not. whole) return
         call refine_branch(case%train, results%branches(i), error, observer)
         if (allocated(error)) return
         whole = is_refined(results%branches(i))
      end do
   end subroutine refine_branches

   pure logical function asks_refinement(case)
      type(case_type), intent(in) :: case

      asks_refinement = .false.
      if (allocated(case%response)) asks_refinement = case%response%refine
   end function asks_refinement

   !> Whether refinement has come to every point.
   pure logical function is_refined(branch)
      type(branch_type), intent(in) :: branch

      is_refined = .not. any(branch%correction(:branch%points) < -1)
   end function is_refined

   !> The edges of separation and back collision of all branches of a case, located before they are reported or written.
   subroutine locate_edges(case, results, observer)
      type(case_type), intent(in) :: case
      type(results_type), intent(inout), target :: results
      !> Once it has answered no, what is left is interpolated.
      class(observer_type), intent(inout), optional :: observer
      integer :: i

      if (.not. (allocated(case%response) .and. allocated(results%response))) return
      call locate_contact_edges(case%train, case%response, results%response, observer)
      if (.not. allocated(results%branches)) return
      do i = 1, size(results%branches)
         associate (branch => results%branches(i))
            call locate_contact_edges(case%train, settings_for(case%response, branch%subharmonic), branch, observer)
         end associate
      end do
   end subroutine locate_edges

end module geartrain_analyses_dependencies
