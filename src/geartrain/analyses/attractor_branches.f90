!> Branches through attractors that lie on no branch so far.
module geartrain_analyses_attractor_branches
   use geartrain_analyses_attractors, only: attractors_type
   use geartrain_analyses_response_branch, only: response
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_error, only: error_type
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_base_words, only: lambda, operator(//)
   use geartrain_bifurcation_bifurcations, only: add_branch
   use geartrain_readings_solutions, only: exceeds_limit, lies_on
   use geartrain_trace_branch, only: branch_type, response_settings_type
   use geartrain_trace_response_variables, only: settings_for
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: follow_attractors

contains

   !> Appends to `branches` a branch through each attractor that lies neither on `branch` nor on any of `branches`. Attractors
   !> above the amplitude limit are left out, because no branch is recorded there, and those without a period.
   subroutine follow_attractors(train, settings, found, branch, branches, error, observer, known)
      !> The train as described.
      type(train_type), intent(in) :: train
      !> Settings that `branch` was traced with; the range of the new branches too.
      type(response_settings_type), intent(in) :: settings
      !> The attractors.
      type(attractors_type), intent(in) :: found
      !> The response.
      type(branch_type), intent(in) :: branch
      !> Branches so far; not allocated: none. A target: an observer may read the branches through a pointer.
      type(branch_type), allocatable, intent(inout), target :: branches(:)
      type(error_type), allocatable, intent(out) :: error
      !> Told of each point of 'branch'; may end the trace.
      class(observer_type), intent(inout), optional :: observer
      !> Branches that another run has traced already: known(n) is copied into branches(n) instead of a new trace.
      type(branch_type), intent(in), optional :: known(:)
      type(response_settings_type) :: in_force
      integer :: i, n, traced

      if (.not. allocated(branches)) allocate (branches(0))
      traced = 0
      if (present(known)) traced = size(known)
      do i = 1, size(found%motions)
         associate (motion => found%motions(i))
            if (motion%period == 0) cycle
            in_force = settings_for(settings, motion%period)
            if (on_a_branch(train, in_force, motion, branch, branches)) cycle
            call add_branch(branches, 'attractor '//text(i)//' at '//lambda(motion%frequency_ratio))
            n = size(branches)
            if (n <= traced) then
               branches(n) = known(n)
               cycle
            end if
            call response(train, in_force, branches(n), error, motion, observer)
            if (allocated(error)) return
            if (branches(n)%cancelled) return
         end associate
      end do
   end subroutine follow_attractors

   !> Whether a motion, shifted by any number of periods of the fundamental, lies on a branch, or lies above the amplitude limit.
   logical function on_a_branch(train, settings, motion, branch, branches)
      type(train_type), intent(in) :: train
      type(response_settings_type), intent(in) :: settings
      type(motion_type), intent(in) :: motion
      type(branch_type), intent(in) :: branch, branches(:)
      integer :: i

      on_a_branch = exceeds_limit(train, settings, motion)
      if (.not. on_a_branch) on_a_branch = lies_on(train, settings, branch, motion)
      do i = 1, size(branches)
         if (on_a_branch) return
         on_a_branch = lies_on(train, settings, branches(i), motion)
      end do
   end function on_a_branch

end module geartrain_analyses_attractor_branches
