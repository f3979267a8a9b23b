!> Refinement of a branch by shooting: each point becomes an orbit to integration accuracy. Points are spread over threads and do
!> not depend on one another, so that the numbers do not depend on how many threads there are.
module geartrain_exact_refinement
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_observer, only: observer_type
   use geartrain_base_words, only: operator(//)
   use geartrain_exact_fold_sides, only: sides_of
   use geartrain_exact_waveform_error, only: harmonics_told, waveform_error
   use geartrain_flow_shooting, only: refine
   use geartrain_network_check_coupling, only: has_friction
   use geartrain_network_check_train, only: check_train
   use geartrain_network_parameter_path, only: parameter_path_type
   use geartrain_network_system, only: build_system, system_type
   use geartrain_trace_branch, only: branch_type, coefficients_of
   use geartrain_trace_points, only: repeats_of
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: cancel_refinement, refine_branch, replace_point, refine_motions

   !> An orbit that differs from the point by more than `another` times the estimated error of the point is another orbit; one that
   !> differs by more than `as_estimated` times may be that on the other side of a fold.
   real(dp), parameter :: another = 10, as_estimated = 3
   !> Correction of a point that is still to be tried; -1: shooting found no orbit.
   real(dp), parameter :: untried = -2
   !> Relative difference that is always accepted: the estimate of a smaller difference may be rounding.
   real(dp), parameter :: rounding = 1e-6_dp

contains

   !> Replaces every point by the orbit near it, accurate to about 1e-11, and sets branch%correction to the change of each waveform.
   !> Lambda and the special points stay as they are; `refine_special_points` replaces the latter. A point near which shooting finds
   !> no orbit stays as it is, with a negative correction; this happens next to a fold, because the fold of the exact branch lies
   !> elsewhere. Where there is one, it is on the point's side of the fold.
   subroutine refine_branch(train, branch, error, observer)
      !> The train as described.
      type(train_type), intent(in) :: train
      !> The branch; if it was refined in part, as in a checkpoint, only the points not tried before are refined.
      type(branch_type), intent(inout), target :: branch
      type(error_type), allocatable, intent(out) :: error
      !> Told of each point of 'refinement', by one thread at a time; may end it.
      class(observer_type), intent(inout), optional :: observer
      type(motion_type) :: motion
      integer :: i, done, repeats
      integer, allocatable :: side(:)
      logical :: keep_going, go
      type(parameter_path_type) :: path
      type(system_type) :: system
      real(dp) :: correction

      call check_train(train, error)
      if (.not. allocated(error) .and. allocated(branch%parameter) .and. branch%points > 0) then
         associate (at => branch%frequency_ratio(:branch%points))
            call path%setup(train, branch%parameter, branch%constant_frequency, minval(at), maxval(at), error)
         end associate
      end if
      if (allocated(error)) return
      if (has_friction(train)) then
         ! Its points are orbits already.
         branch%correction = [(0.0_dp, i=1, branch%points)]
         return
      end if
      ! The edges are those of the points as they were.
      if (allocated(branch%contact_edges)) deallocate (branch%contact_edges)
      call build_system(train, system)
      repeats = repeats_of(branch, system)
      side = sides_of(branch)
      if (.not. allocated(branch%correction)) allocate (branch%correction(branch%points), source=untried)
      done = count(branch%correction > untried)
      keep_going = .true.
      !$omp parallel do private(motion, correction, go) schedule(dynamic)
      do i = 1, branch%points
         !$omp atomic read
         go = keep_going
         if (.not. go .or. branch%correction(i) > untried) cycle
         call refine_point(train, path, branch, i, repeats, side(i), motion, correction)
         if (train%interrupt%raised()) then
            !$omp atomic write
            keep_going = .false.
            cycle
         end if
         ! The observer may read the branch: no other thread changes a point at this time.
         !$omp critical (geartrain_refinement)
         branch%correction(i) = correction
         if (.not. correction < 0) then
            call replace_point(motion, i, branch)
            if (allocated(branch%stable)) &
               branch%growth_rate(i) = growth_rate_of(motion, repeats)*system%characteristic_frequency
         end if
         done = done + 1
         go = keep_going
         if (go .and. present(observer)) call observer%on_step('refinement', done, branch%frequency_ratio(i), go)
         !$omp atomic write
         keep_going = go
         !$omp end critical (geartrain_refinement)
      end do
      !$omp end parallel do
      if (.not. keep_going .or. train%interrupt%raised()) call cancel_refinement(branch)
   end subroutine refine_branch

   !> Growth rate of the slowest perturbation of a refined motion, by its multipliers [1/dimensionless time].
   pure real(dp) function growth_rate_of(motion, repeats) result(rate)
      type(motion_type), intent(in) :: motion
      !> How often the motion goes through its waveform in its period.
      integer, intent(in) :: repeats
      real(dp) :: largest

      largest = abs(motion%multipliers(1))
      if (allocated(motion%repetition_multipliers)) largest = abs(motion%repetition_multipliers(1))
      rate = log(max(largest, tiny(largest)))*motion%frequency_ratio/(2*pi*motion%period)
      if (allocated(motion%repetition_multipliers)) rate = repeats*rate
   end function growth_rate_of

   !> Tells in a branch that its refinement was cancelled.
   subroutine cancel_refinement(branch)
      !> The branch.
      type(branch_type), intent(inout) :: branch

      branch%cancelled = .true.
      branch%complete = .false.
      branch%ended = 'refinement cancelled; before it: '//branch%ended
   end subroutine cancel_refinement

   !> Refines motions of a branch at one Lambda, or at one value of its parameter; one that shooting does not find stays as it is.
   subroutine refine_motions(train, branch, value, motions, error)
      !> The train as described.
      type(train_type), intent(in) :: train
      !> The branch.
      type(branch_type), intent(in) :: branch
      !> Value of its free parameter [1, or unit of the parameter].
      real(dp), intent(in) :: value
      !> Motions of the branch there.
      type(motion_type), intent(inout) :: motions(:)
      type(error_type), allocatable, intent(out) :: error
      type(error_type), allocatable :: not_found
      type(parameter_path_type) :: path
      type(train_type) :: own
      integer :: i

      own = train
      if (allocated(branch%parameter)) then
         call path%setup(train, branch%parameter, branch%constant_frequency, value, value, error)
         if (allocated(error)) return
         call path%train_at(value, own)
      end if
      do i = 1, size(motions)
         call refine(own, motions(i), not_found)
      end do
   end subroutine refine_motions

   !> Finds the orbit near point i, on its side of the folds; a negative correction means that there is none.
   subroutine refine_point(given, path, branch, i, repeats, side, motion, correction)
      type(train_type), intent(in) :: given
      !> Trains of a branch over a parameter.
      type(parameter_path_type), intent(in) :: path
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: i, repeats, side
      type(motion_type), intent(out) :: motion
      real(dp), intent(out) :: correction
      type(error_type), allocatable :: error
      type(train_type) :: train
      type(motion_type) :: orbit
      real(dp) :: frequency_ratio, difference
      integer :: attempt

      if (allocated(branch%parameter)) then
         call path%train_at(branch%frequency_ratio(i), train)
         frequency_ratio = branch%constant_frequency
      else
         train = given
         frequency_ratio = branch%frequency_ratio(i)
      end if
      correction = -1
      ! First by single shooting, which is quicker and is enough as a rule, then by multiple shooting, except where the estimate is
      ! doubtful: there may be no orbit. Of a strongly unstable motion near a fold single shooting finds the orbit on the other
      ! side of the fold too: of two orbits the nearer one is meant.
      do attempt = 1, 2
         if (attempt == 2 .and. correction < 0 .and. branch%estimate_doubtful(i)) exit
         orbit = motion_type(frequency_ratio=frequency_ratio, period=branch%subharmonic)
         orbit%coefficients = coefficients_of(branch, i)
         call refine(train, orbit, error, attempt == 2, &
                     harmonics_told(coefficients_of(branch, i), branch%subharmonic), repeats, side)
         if (allocated(error)) cycle
         difference = waveform_error(coefficients_of(branch, i), orbit%coefficients)
         if (difference > max(another*branch%error_estimate(i), rounding)) cycle
         if (correction < 0 .or. difference < correction) then
            correction = difference
            motion = orbit
         end if
         if (correction <= max(as_estimated*branch%error_estimate(i), rounding)) return
      end do
   end subroutine refine_point

   !> Puts an orbit in the place of point i; rms, extremes and loads are those of the whole waveform of the orbit.
   subroutine replace_point(motion, i, branch)
      !> The orbit, with all figures.
      type(motion_type), intent(in) :: motion
      !> Number of the point.
      integer, intent(in) :: i
      !> The branch, which has room for the point.
      type(branch_type), intent(inout), target :: branch
      integer :: k

      branch%coefficients(1, :, i) = motion%coefficients(1, :)
      do k = 1, size(branch%orders)
         associate (r => branch%orders(k))
            if (2*r < size(motion%coefficients, 1)) branch%coefficients(2*k:2*k + 1, :, i) = motion%coefficients(2*r:2*r + 1, :)
         end associate
      end do
      branch%rms(:, i) = motion%rms
      branch%mean(:, i) = motion%mean
      branch%minimum(:, i) = motion%minimum
      branch%maximum(:, i) = motion%maximum
      branch%mesh_load(:, i) = motion%mesh_load
      if (allocated(branch%shaft_torque_mean)) then
         branch%shaft_torque_mean(:, i) = motion%shaft_torque_mean
         branch%shaft_torque_minimum(:, i) = motion%shaft_torque_minimum
         branch%shaft_torque_maximum(:, i) = motion%shaft_torque_maximum
      end if
      if (branch%bearing_force%bearings > 0) then
         branch%bearing_force%mean(:, :, i) = motion%bearing_force_mean
         branch%bearing_force%rms(:, :, i) = motion%bearing_force_rms
         branch%bearing_force%minimum(:, :, i) = motion%bearing_force_minimum
         branch%bearing_force%maximum(:, :, i) = motion%bearing_force_maximum
      end if
      if (allocated(branch%coupling_energy_loss)) branch%coupling_energy_loss(:, i) = motion%coupling_energy_loss
      if (allocated(branch%load_share)) then
         branch%load_share(:, i) = motion%load_share
         branch%load_share_maximum(:, i) = motion%load_share_maximum
      end if
      branch%error_estimate(i) = motion%error_estimate
      branch%mesh_error_estimate(:, i) = motion%error_estimate
      if (allocated(branch%reading_error_estimate)) branch%reading_error_estimate(i) = motion%error_estimate
      branch%estimate_doubtful(i) = .false.
      if (.not. allocated(branch%stable)) return
      ! Multipliers are in descending order; of a train of many states a branch has the leading multipliers only.
      if (branch%states > 0) branch%multipliers(:, i) = motion%multipliers(:branch%states)
      if (allocated(branch%repetition_multipliers)) &
         branch%repetition_multipliers(:, i) = motion%repetition_multipliers(:branch%states)
      branch%stable(i) = motion%stable
      branch%undecided(i) = .false.
      branch%count_undecided(i) = .false.
   end subroutine replace_point

end module geartrain_exact_refinement
