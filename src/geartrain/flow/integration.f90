!> Time integration to a steady motion at one frequency.
module geartrain_flow_integration
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type, fatal, status_ended_early
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: real_text, text
   use geartrain_base_observer, only: observer_type
   use geartrain_flow_integration_settings, only: integration_settings_type
   use geartrain_flow_lyapunov, only: find_exponent, kind_of
   use geartrain_flow_settling, only: is_leaving, settle
   use geartrain_flow_start_state, only: resting_state, state_of
   use geartrain_flow_variables, only: check_integration
   use geartrain_model_check, only: check_train
   use geartrain_model_limits, only: check_frequency
   use geartrain_model_system, only: build_system, system_type
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: add_exponent, integrate

contains

   !> Integrates from `start` (default: at rest under the mean load) until the motion is steady. motion%period is 0 where no
   !> period was found within settings%max_periods, and its figures are then those of the last 16 mesh periods. Fails where the
   !> motion grows without bound.
   subroutine integrate(train, frequency_ratio, settings, motion, error, start, observer)
      type(train_type), intent(in) :: train
      !> Lambda [1], > 0.
      real(dp), intent(in) :: frequency_ratio
      type(integration_settings_type), intent(in) :: settings
      type(motion_type), intent(out) :: motion
      type(error_type), allocatable, intent(out) :: error
      type(motion_type), intent(in), optional :: start
      class(observer_type), intent(inout), optional :: observer
      type(system_type) :: system
      real(dp), allocatable :: state(:)

      call check_train(train, error)
      if (allocated(error)) return
      call check_single(train, settings, frequency_ratio, error)
      if (allocated(error)) return
      call build_system(train, system)
      allocate (state(system%states))
      state = resting_state(system)
      if (present(start)) then
         call check_start(system, start, error)
         if (allocated(error)) return
         call state_of(system, start, state)
      end if
      call settle(system, frequency_ratio, settings, state, motion, observer)
      if (system%interrupt%raised()) then
         call fatal(error, 'interrupted before the motion was steady', status_ended_early)
         return
      else if (.not. allocated(motion%coefficients)) then
         call fatal(error, 'the motion grows without bound at Lambda = '// &
                    text(frequency_ratio)//': it was given up at a displacement &
                    &of '//text(maxval(abs(state(:system%displacements))))//' characteristic lengths', status_ended_early)
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
      call find_exponent(system, motion%frequency_ratio, motion%state, settings%max_periods, motion%lyapunov_exponent, &
                         motion%lyapunov_error, observer)
      if (.not. allocated(motion%lyapunov_exponent)) return
      motion%kind = kind_of(motion%frequency_ratio, motion%lyapunov_exponent, motion%lyapunov_error)
      ! What has not yet left an orbit that repels has the exponent of the orbit, which tells nothing of where it goes.
      if (motion%kind /= 'chaotic') return
      if (is_leaving(system, motion%frequency_ratio, motion%state, motion%lyapunov_exponent)) motion%kind = 'still settling'
   end subroutine add_exponent

   !> Settings for a single frequency, which takes the place of the range.
   subroutine check_single(train, settings, frequency_ratio, error)
      type(train_type), intent(in) :: train
      type(integration_settings_type), intent(in) :: settings
      real(dp), intent(in) :: frequency_ratio
      type(error_type), allocatable, intent(inout) :: error
      type(integration_settings_type) :: single
      type(checker_type) :: checker

      if (.not. (frequency_ratio > 0 .and. frequency_ratio <= huge(1.0_dp))) then
         call checker%complain('frequency', real_text(frequency_ratio), 'must be a finite number > 0')
      else
         call check_frequency(train, 'frequency', frequency_ratio, checker)
      end if
      call checker%problems%raise('', error)
      if (allocated(error)) return
      single = settings
      single%start = frequency_ratio
      single%stop = frequency_ratio
      single%points = 1
      call check_integration(train, single, error)
   end subroutine check_single

   subroutine check_start(system, start, error)
      type(system_type), intent(in) :: system
      type(motion_type), intent(in) :: start
      type(error_type), allocatable, intent(inout) :: error

      if (allocated(start%state)) then
         if (size(start%state) /= system%states) call fatal(error, 'start: a state of '//text(size(start%state)) &
            //' values: must have '//text(system%states)//' (displacement of each elastic element, then the velocities)')
      else if (.not. allocated(start%coefficients)) then
         call fatal(error, 'start: has neither a state nor coefficients')
      else if (size(start%coefficients, 2) /= system%meshes) then
         call fatal(error, 'start: a motion of '//text(size(start%coefficients, 2))//' meshes: the train has ' &
                    //text(system%meshes))
      else if (start%period < 1) then
         call fatal(error, 'start: a motion of period '//text(start%period)//' without a state: must be >= 1')
      end if
   end subroutine check_start

end module geartrain_flow_integration
