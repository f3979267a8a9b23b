!> A branch polished by shooting: its points become orbits to integration accuracy, spread over threads, each by itself, so that
!> the numbers do not depend on how many threads there are.
module geartrain_continuation_refinement
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_observer, only: observer_type
   use geartrain_continuation_branch, only: branch_type
   use geartrain_continuation_waveform_error, only: harmonics_told, waveform_error
   use geartrain_flow_shooting, only: refine
   use geartrain_model_check, only: check_train
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: refine_branch

   !> An orbit that differs from the point by more than this many times the estimated error of the point is another one.
   real(dp), parameter :: another = 10
   !> The correction of a point that is still to be tried; where shooting found nothing it is -1.
   real(dp), parameter :: untried = -2
   !> Least difference that is asked about, relative: below it the estimate may be rounding.
   real(dp), parameter :: rounding = 1e-6_dp

contains

   !> Replaces every point by the orbit near it to about 1e-11 and sets branch%correction, by how much each waveform changed.
   !> Lambda stays. A point near which shooting finds no orbit, as next to a fold, whose true place is elsewhere, stays as it is,
   !> with a negative correction. Special points stay as they are. A branch refined in part, as a checkpoint holds it, is taken up
   !> with the points not tried before.
   subroutine refine_branch(train, branch, error, observer)
      type(train_type), intent(in) :: train
      type(branch_type), intent(inout), target :: branch
      type(error_type), allocatable, intent(out) :: error
      !> Told of 'refinement', by one thread at a time.
      class(observer_type), intent(inout), optional :: observer
      type(motion_type) :: motion
      integer :: i, done
      logical :: keep_going, go
      real(dp) :: correction

      call check_train(train, error)
      if (allocated(error)) return
      if (.not. allocated(branch%correction)) allocate (branch%correction(branch%points), source=untried)
      done = count(branch%correction > untried)
      keep_going = .true.
      !$omp parallel do private(motion, correction, go) schedule(dynamic)
      do i = 1, branch%points
         !$omp atomic read
         go = keep_going
         if (.not. go .or. branch%correction(i) > untried) cycle
         call refine_point(train, branch, i, motion, correction)
         if (train%interrupt%raised()) then
            !$omp atomic write
            keep_going = .false.
            cycle
         end if
         ! Whoever reads the branch meanwhile is the observer, and no point changes while it does.
         !$omp critical (geartrain_refinement)
         branch%correction(i) = correction
         if (.not. correction < 0) call replace_point(motion, i, branch)
         done = done + 1
         go = keep_going
         if (go .and. present(observer)) call observer%on_step('refinement', done, branch%frequency_ratio(i), go)
         !$omp atomic write
         keep_going = go
         !$omp end critical (geartrain_refinement)
      end do
      !$omp end parallel do
      if (keep_going .and. .not. train%interrupt%raised()) return
      branch%cancelled = .true.
      branch%complete = .false.
      branch%ended = 'refinement cancelled; before it: '//branch%ended
   end subroutine refine_branch

   !> The orbit near point i; a negative correction where there is none.
   subroutine refine_point(train, branch, i, motion, correction)
      type(train_type), intent(in) :: train
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: i
      type(motion_type), intent(out) :: motion
      real(dp), intent(out) :: correction
      type(error_type), allocatable :: error
      integer :: attempt

      correction = -1
      ! In one piece, which is enough as a rule and quicker, then in sections: where the estimate is doubtful there
      ! may be no orbit.
      do attempt = 1, merge(1, 2, branch%estimate_doubtful(i))
         motion%frequency_ratio = branch%frequency_ratio(i)
         motion%period = branch%subharmonic
         motion%coefficients = branch%coefficients(:, :, i)
         if (allocated(motion%state)) deallocate (motion%state)
         call refine(train, motion, error, attempt == 2, &
                     harmonics_told(branch%coefficients(:, :, i), branch%subharmonic))
         if (allocated(error)) cycle
         correction = waveform_error(branch%coefficients(:, :, i), motion%coefficients, .false.)
         if (correction <= max(another*branch%error_estimate(i), rounding)) return
         correction = -1
      end do
   end subroutine refine_point

   !> The harmonics that the branch holds are those of the orbit; rms, extremes and loads are those of its whole waveform.
   subroutine replace_point(motion, i, branch)
      type(motion_type), intent(in) :: motion
      integer, intent(in) :: i
      type(branch_type), intent(inout), target :: branch
      integer :: n

      n = min(size(branch%coefficients, 1), size(motion%coefficients, 1))
      branch%coefficients(:n, :, i) = motion%coefficients(:n, :)
      branch%rms(:, i) = motion%rms
      branch%mean(:, i) = motion%mean
      branch%minimum(:, i) = motion%minimum
      branch%maximum(:, i) = motion%maximum
      branch%mesh_load(:, i) = motion%mesh_load
      branch%error_estimate(i) = motion%error_estimate
      branch%estimate_doubtful(i) = .false.
      if (.not. allocated(branch%stable)) return
      ! Largest first; of a train of many states a branch has the leading ones only.
      branch%multipliers(:, i) = motion%multipliers(:size(branch%multipliers, 1))
      branch%stable(i) = motion%stable
      branch%undecided(i) = .false.
      branch%count_undecided(i) = .false.
   end subroutine replace_point

end module geartrain_continuation_refinement
