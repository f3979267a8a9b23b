!> Switches from a branch to a bifurcating branch, without a seed: at a period doubling to the branch of twice the period, at a
!> branch point to the crossing branch of equal period.
!>
!> The system is exactly linear until a tooth separates, so a branch may leave vertically: Lambda is constant and the amplitude
!> grows until contact is lost. Steps along the critical vector of the balance follow a vertical branch like any other.
module geartrain_bifurcation_switching
   use geartrain_base_error, only: error_type, fatal
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_base_words, only: lambda, operator(//)
   use geartrain_bifurcation_critical_point, only: find_critical, harmonics_at
   use geartrain_network_check_coupling, only: has_friction
   use geartrain_network_check_train, only: check_train
   use geartrain_network_system, only: system_type
   use geartrain_readings_special_spacing, only: add_points_between
   use geartrain_trace_both_ways, only: trace_both_ways
   use geartrain_trace_branch, only: branch_type, response_settings_type
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_trace_interruption, only: drop_step
   use geartrain_trace_large_amplitude, only: followed_out, trace_through
   use geartrain_trace_start, only: begin_trace, doubled_settings
   use geartrain_trace_tracer, only: tracer_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: period_doubled, trace_switched

   !> Length of the step along the critical vector to the first point, in the metric of the branch, and the least length tried.
   real(dp), parameter :: first_step = 1e-3_dp, least_step = 1e-5_dp

contains

   !> Follows the period-doubled branch from a period doubling until it meets the branch of half its period again or leaves the
   !> range of Lambda.
   subroutine period_doubled(train, settings, branch, special, doubled, error, observer)
      !> Train of the branch.
      type(train_type), intent(in) :: train
      !> Settings with which `branch` was traced: the period-doubled branch has twice as many harmonics.
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: branch
      !> Number of the special point, a period doubling.
      integer, intent(in) :: special
      !> Becomes the period-doubled branch.
      type(branch_type), intent(inout), target :: doubled
      type(error_type), allocatable, intent(out) :: error
      !> Told of each step; may end the trace.
      class(observer_type), intent(inout), optional :: observer
      type(solution_point_type) :: solution
      logical :: success

      call check_train(train, error)
      if (.not. allocated(error) .and. has_friction(train)) &
         call fatal(error, 'period_doubled: a train with friction_torque has no harmonic balance to begin with; find a motion of &
                           &twice the period by time integration, and begin a response of this period with it')
      if (allocated(error)) return
      if (special < 1 .or. special > size(branch%special_points)) then
         call fatal(error, 'special = '//text(special)//': the branch has '//text(size(branch%special_points)) &
                    //' special points')
         return
      end if
      if (branch%special_points(special)%kind /= 'period doubling') then
         call fatal(error, 'special = '//text(special)//': a '//trim(branch%special_points(special)%kind) &
                    //', not a period doubling')
         return
      end if
      call find_critical(train, settings, branch, special, solution, success)
      call trace_switched(train, settings, branch, special, solution, success, doubled, observer)
   end subroutine period_doubled

   !> Follows the branch that bifurcates at a special point: one way from a period doubling, because the other way gives the same
   !> motions shifted by half their period; both ways from a branch point.
   subroutine trace_switched(train, settings, branch, special, critical, found, switched, observer)
      !> Checked train of the branch.
      type(train_type), intent(in) :: train
      !> Settings with which `branch` was traced.
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: branch
      !> Number of the special point, a period doubling or a branch point.
      integer, intent(in) :: special
      !> Critical point of the balance as `find_critical` gives it, with the critical vector as its tangent.
      type(solution_point_type), intent(in) :: critical
      !> Whether there is a critical point.
      logical, intent(in) :: found
      !> Becomes the bifurcating branch; its `origin` is kept.
      type(branch_type), intent(inout), target :: switched
      !> Told of each step; may end the trace.
      class(observer_type), intent(inout), optional :: observer
      type(system_type), target :: systems(2)
      type(tracer_type) :: tracer
      type(branch_type) :: empty
      type(solution_point_type) :: solution, other, began
      integer :: outcome
      logical :: success, doubles

      ! Everything but `origin` is new.
      call move_alloc(switched%origin, empty%origin)
      switched = empty
      associate (kind => branch%special_points(special)%kind, at => branch%special_points(special)%frequency_ratio)
         doubles = kind == 'period doubling'
         if (doubles) then
            call begin_trace(train, doubled_settings(train, settings, branch), systems, tracer)
         else
            call begin_trace(train, settings, systems, tracer, branch)
         end if
         tracer%analysis = 'branch'
         if (settings%harmonics == 0) &
            call tracer%prepare(harmonics_at(branch, special)*(tracer%settings%subharmonic/settings%subharmonic))
         call tracer%recorder%setup(tracer%corrector%balance, settings%stability, switched, settings%shaft_torque, &
                                      settings%multipliers)
         if (.not. found) then
            switched%ended = 'the balance has no '//trim(kind)//' of its own near '//lambda(at) &
                             //' (more harmonics place it more exactly)'
            call drop_step(tracer, switched)
            call tracer%recorder%finish(switched)
            return
         end if
      end associate
      ! Branches that move equally along the critical vector go on to do so.
      call tracer%corrector%keep_equal(critical)
      call step_off(tracer, critical, 1, solution, success)
      if (success .and. .not. doubles) call step_off(tracer, critical, -1, other, success)
      if (.not. success) then
         call tracer%recorder%finish(switched)
         switched%ended = 'no branch found along the critical vector at '//lambda(critical%frequency_ratio)
         call drop_step(tracer, switched)
         return
      end if
      call tracer%adapt(solution, success)
      call tracer%record(solution, switched)
      if (doubles) then
         began = solution
         call trace_through(tracer, solution, tracer%settings%stop, switched, outcome, switched%ended, observer, began)
         switched%complete = followed_out(outcome)
      else
         call trace_both_ways(tracer, solution, other, switched, 'the branch point', observer, between=critical%frequency_ratio, &
                              multiplicity=branch%special_points(special)%multiplicity)
      end if
      call drop_step(tracer, switched)
      call add_points_between(tracer, switched)
      call tracer%tell_missed(switched)
      call tracer%recorder%finish(switched)
   end subroutine trace_switched

   !> The first point of the bifurcating branch, a short step along the critical vector or against it: the critical point itself is
   !> singular.
   subroutine step_off(tracer, critical, direction, solution, success)
      type(tracer_type), intent(inout) :: tracer
      type(solution_point_type), intent(in) :: critical
      integer, intent(in) :: direction
      type(solution_point_type), intent(inout) :: solution
      logical, intent(out) :: success
      type(solution_point_type) :: from
      real(dp) :: h

      from = critical
      from%tangent = direction*critical%tangent
      from%tangent_frequency = direction*critical%tangent_frequency
      h = first_step
      do
         call tracer%corrector%advance(from, h, solution, success)
         h = h/3
         if (success .or. h < least_step) return
      end do
   end subroutine step_off

end module geartrain_bifurcation_switching
