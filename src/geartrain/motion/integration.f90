!> Time integration to a steady motion, and its period: 1 to 16 mesh periods, else none found.
module geartrain_motion_integration
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type, fatal, status_ended_early
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_observer, only: observer_type
   use geartrain_base_numbers, only: real_text, text
   use geartrain_model_check, only: check_train
   use geartrain_model_limits, only: check_frequency
   use geartrain_model_system, only: build_system, system_type
   use geartrain_model_train, only: train_type
   use geartrain_motion_flow, only: flow_type
   use geartrain_motion_integration_settings, only: integration_settings_type
   use geartrain_motion_lyapunov, only: exponent_periods, largest_exponent
   use geartrain_motion_motion, only: motion_type
   use geartrain_motion_orbit, only: flow_order, flow_tolerance, measure, propagate
   use geartrain_motion_start_state, only: resting_state, state_of
   use geartrain_motion_variables, only: check_integration
   use geartrain_stability_monodromy, only: eigenvalues, is_neutral, is_stable
   implicit none (type, external)
   private
   public :: add_exponent, integrate, settle

   !> Longest period looked for, in mesh periods.
   integer, parameter :: longest_period = 16
   !> Sections that differ by less than this (relative) may still be the same motion converging slowly.
   real(dp), parameter :: clearly_different = 1e-5_dp
   !> State over the largest of the characteristic length, the resting state and the start beyond which a motion is given up: it
   !> runs away, in a range of Lambda where the train without separation is unstable.
   real(dp), parameter :: unbounded = 1e6_dp
   !> Time between two looks at the observer [1].
   real(dp), parameter :: between_looks = 200

contains

   !> Integrates from `start` (default: at rest under the mean load) until the motion is steady. motion%period is 0 where no
   !> period was found within settings%max_periods, and its figures are then those of the last 16 mesh periods. Fails where the
   !> motion grows without bound.
   subroutine integrate(train, frequency, settings, motion, error, start, observer)
      type(train_type), intent(in) :: train
      !> Lambda [1], > 0.
      real(dp), intent(in) :: frequency
      type(integration_settings_type), intent(in) :: settings
      type(motion_type), intent(out) :: motion
      type(error_type), allocatable, intent(out) :: error
      type(motion_type), intent(in), optional :: start
      class(observer_type), intent(inout), optional :: observer
      type(system_type) :: system
      real(dp), allocatable :: state(:)

      call check_train(train, error)
      if (allocated(error)) return
      call check_single(train, settings, frequency, error)
      if (allocated(error)) return
      call build_system(train, system)
      allocate (state(2*system%elements))
      state = resting_state(system)
      if (present(start)) then
         call check_start(system, start, error)
         if (allocated(error)) return
         call state_of(system, start, state)
      end if
      call settle(system, frequency, settings, state, motion, observer)
      if (system%interrupt%raised()) then
         call fatal(error, 'interrupted before the motion was steady', status_ended_early)
         return
      else if (.not. allocated(motion%coefficients)) then
         call fatal(error, 'the motion grows without bound at Lambda = '//text(frequency)//': it was given up at a displacement &
                    &of '//text(maxval(abs(state(:system%elements))))//' characteristic lengths', status_ended_early)
         return
      end if
      call add_exponent(system, settings, motion, observer)
   end subroutine integrate

   !> The Lyapunov exponent of a motion for which no period was found, unless it ran away.
   subroutine add_exponent(system, settings, motion, observer)
      type(system_type), intent(in) :: system
      type(integration_settings_type), intent(in) :: settings
      type(motion_type), intent(inout) :: motion
      class(observer_type), intent(inout), optional :: observer

      if (motion%period > 0 .or. .not. allocated(motion%coefficients)) return
      call largest_exponent(system, motion%frequency, motion%state, &
                            exponent_periods(motion%frequency, settings%max_periods), motion%lyapunov_exponent, observer)
   end subroutine add_exponent

   !> Settings for a single frequency, which takes the place of the range.
   subroutine check_single(train, settings, frequency, error)
      type(train_type), intent(in) :: train
      type(integration_settings_type), intent(in) :: settings
      real(dp), intent(in) :: frequency
      type(error_type), allocatable, intent(inout) :: error
      type(integration_settings_type) :: single
      type(checker_type) :: checker

      if (.not. (frequency > 0 .and. frequency <= huge(1.0_dp))) then
         call checker%complain('frequency', real_text(frequency), 'must be a finite number > 0')
      else
         call check_frequency(train, 'frequency', frequency, checker)
      end if
      call checker%problems%raise('', error)
      if (allocated(error)) return
      single = settings
      single%start = frequency
      single%stop = frequency
      single%points = 1
      call check_integration(train, single, error)
   end subroutine check_single

   subroutine check_start(system, start, error)
      type(system_type), intent(in) :: system
      type(motion_type), intent(in) :: start
      type(error_type), allocatable, intent(inout) :: error

      if (allocated(start%state)) then
         if (size(start%state) /= 2*system%elements) call fatal(error, 'start: a state of '//text(size(start%state)) &
            //' values: must have '//text(2*system%elements)//' (displacement of each elastic element, then the velocities)')
      else if (.not. allocated(start%coefficients)) then
         call fatal(error, 'start: has neither a state nor coefficients')
      else if (size(start%coefficients, 2) /= system%meshes) then
         call fatal(error, 'start: a motion of '//text(size(start%coefficients, 2))//' meshes: the train has ' &
                    //text(system%meshes))
      else if (start%period < 1) then
         call fatal(error, 'start: a motion of period '//text(start%period)//' without a state: must be >= 1')
      end if
   end subroutine check_start

   !> Integrates mesh period by mesh period until the section at phase 0 repeats itself; `state` is carried along. A motion that
   !> grows without bound has a state, but neither coefficients nor figures.
   subroutine settle(system, frequency, settings, state, motion, observer, stopped)
      type(system_type), intent(in) :: system
      real(dp), intent(in) :: frequency
      type(integration_settings_type), intent(in) :: settings
      real(dp), intent(inout) :: state(:)
      type(motion_type), intent(out), target :: motion
      class(observer_type), intent(inout), optional :: observer
      !> The observer or an interrupt ended it before the motion was steady.
      logical, intent(out), optional :: stopped
      type(flow_type) :: flow
      real(dp) :: section(size(state), 0:2*longest_period)
      real(dp) :: limit
      integer :: k, period, look
      logical :: keep_going

      if (present(stopped)) stopped = .false.
      call flow%setup(system, 1, flow_order, flow_tolerance)
      flow%x(1, :) = state
      section = huge(1.0_dp)
      section(:, 0) = state
      period = 0
      limit = unbounded*max(1.0_dp, maxval(abs(resting_state(system))), maxval(abs(state)))
      look = max(1, nint(between_looks*frequency/(2*pi)))
      do k = 1, settings%max_periods
         call flow%start(frequency, 0.0_dp)
         call flow%advance(2*pi/frequency)
         section = eoshift(section, -1, dim=2)
         section(:, 0) = flow%x(1, :)
         if (system%interrupt%raised()) exit
         if (.not. all(abs(section(:, 0)) < limit)) exit
         call find_period(section, k, settings%tolerance, period)
         if (period > 0) exit
         if (.not. present(observer) .or. mod(k, look) /= 0) cycle
         keep_going = .true.
         call observer%on_step('settling', k, frequency, keep_going)
         if (keep_going) cycle
         if (present(stopped)) stopped = .true.
         exit
      end do
      state = section(:, 0)
      call describe(system, frequency, settings, state, period, all(abs(state) < limit), motion)
      if (present(stopped)) stopped = stopped .or. system%interrupt%raised()
   end subroutine settle

   !> The smallest period whose section repeats itself to `tolerance`, the remaining error being judged by the rate at
   !> which the differences fall; 0 if there is none yet. A multiple of a period that still converges is not taken for one.
   pure subroutine find_period(section, k, tolerance, period)
      real(dp), intent(in) :: section(:, 0:), tolerance
      integer, intent(in) :: k
      integer, intent(out) :: period
      real(dp) :: scale, now, before, rate, error, shorter
      integer :: n, m

      scale = maxval(abs(section(:, 0)))
      shorter = huge(1.0_dp)
      do n = 1, longest_period
         period = 0
         if (k < 2*n) return
         now = maxval(abs(section(:, 0) - section(:, n)))/scale
         before = maxval(abs(section(:, n) - section(:, 2*n)))/scale
         error = now
         if (now > 1e-13_dp) then
            rate = now/before
            if (rate >= 1) cycle
            error = now/(1 - rate)
         end if
         if (error > tolerance) cycle
         period = n
         do m = 1, n - 1
            if (mod(n, m) /= 0) cycle
            if (maxval(abs(section(:, 0) - section(:, m)))/scale < clearly_different) period = 0
         end do
         return
      end do
      period = 0
   end subroutine find_period

   !> The motion that starts at `state`.
   subroutine describe(system, frequency, settings, state, period, bounded, motion)
      type(system_type), intent(in) :: system
      real(dp), intent(in) :: frequency, state(:)
      type(integration_settings_type), intent(in) :: settings
      integer, intent(in) :: period
      logical, intent(in) :: bounded
      type(motion_type), intent(inout) :: motion
      real(dp) :: final(size(state)), monodromy(size(state), size(state))

      motion%frequency = frequency
      motion%state = state
      motion%period = merge(period, longest_period, period > 0)
      if (bounded .and. .not. system%interrupt%raised()) call measure(system, settings%harmonics, motion)
      motion%period = period
      if (system%interrupt%raised()) motion%period = 0
      if (motion%period == 0) return
      motion%error_estimate = settings%tolerance
      if (.not. settings%stability) return
      call propagate(system, frequency, period, state, final, monodromy)
      if (system%interrupt%raised()) return
      allocate (motion%multipliers(size(state)))
      call eigenvalues(monodromy, motion%multipliers)
      motion%stable = is_stable(motion%multipliers)
      motion%undecided = is_neutral(motion%multipliers)
   end subroutine describe

end module geartrain_motion_integration
