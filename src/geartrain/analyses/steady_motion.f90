!> The steady motion that time integration settles on: from period to period where the common period of all meshes is short, else
!> by the time constants of the train, with figures over a window.
module geartrain_analyses_steady_motion
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_error, only: error_type, fatal
   use geartrain_base_kinds, only: dp
   use geartrain_base_memory, only: need
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_flow_integration_settings, only: integration_settings_type, most_periods
   use geartrain_flow_flow_kind, only: flow_kind
   use geartrain_flow_lyapunov, only: find_exponent
   use geartrain_flow_orbit, only: memory_to_measure
   use geartrain_flow_section_trend, only: section_trend_type
   use geartrain_flow_settling, only: need_to_settle, settle
   use geartrain_flow_time_constants, only: find_in_window, settling_time
   use geartrain_flow_window, only: goes_by_windows, window_of
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: check_start, find_steady, need_to_find, time_before

contains

   !> Makes it an error if there is no memory for the figures of a motion.
   subroutine need_to_find(system, settings, error)
      type(system_type), intent(in) :: system
      !> Of which window and harmonics are used.
      type(integration_settings_type), intent(in) :: settings
      !> No memory.
      type(error_type), allocatable, intent(inout) :: error

      if (goes_by_windows(system, settings%window)) then
         call need(window_of(system, settings%window)*memory_to_measure(system, 1, settings%harmonics), &
                   'no memory for the figures of a window', 'take a shorter window', error)
      else
         call need_to_settle(system, settings%harmonics, error)
      end if
   end subroutine need_to_find

   !> Integrates until it is known which motion the flow settles on.
   subroutine find_steady(system, frequency_ratio, settings, state, motion, observer, stopped)
      type(system_type), target, intent(in) :: system
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Settings, of which the range is not used.
      type(integration_settings_type), intent(in) :: settings
      !> State where settling begins, which is `time_before` earlier than phase 0; then the state at phase 0 [1], (state).
      real(dp), intent(inout) :: state(:)
      !> The motion; period 0: none found. A motion that grows without bound has a state, but neither coefficients nor figures.
      type(motion_type), intent(out) :: motion
      !> Told of 'settling', or of 'settling by time'; may end it.
      class(observer_type), intent(inout), optional :: observer
      !> Whether the observer or an interrupt ended the flow before the motion was known.
      logical, intent(out) :: stopped

      if (goes_by_windows(system, settings%window)) then
         call find_in_window(system, frequency_ratio, settings, state, motion, observer, stopped)
      else
         call settle(system, frequency_ratio, settings, state, motion, observer, stopped)
         if (.not. stopped) call add_exponent(system, settings, motion, observer)
         stopped = stopped .or. system%interrupt%raised()
      end if
   end subroutine find_steady

   !> Time before phase 0 at which settling begins [1]: 0 where it goes from period to period.
   real(dp) function time_before(system, frequency_ratio, settings)
      type(system_type), intent(in) :: system
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Settings, of which window and max_periods are used.
      type(integration_settings_type), intent(in) :: settings

      time_before = 0
      if (goes_by_windows(system, settings%window)) &
         time_before = settling_time(system, frequency_ratio, most_periods(system, settings%max_periods))
   end function time_before

   !> Adds Lyapunov exponent and kind to a motion without a period, unless the motion grew without bound.
   subroutine add_exponent(system, settings, motion, observer)
      type(system_type), intent(in) :: system
      type(integration_settings_type), intent(in) :: settings
      type(motion_type), intent(inout) :: motion
      class(observer_type), intent(inout), optional :: observer
      type(section_trend_type) :: trend

      if (motion%period > 0 .or. .not. allocated(motion%coefficients)) return
      call find_exponent(system, motion%frequency_ratio, motion%state, most_periods(system, settings%max_periods), &
                         motion%lyapunov_exponent, motion%lyapunov_error, trend, observer)
      if (.not. allocated(motion%lyapunov_exponent)) return
      motion%kind = flow_kind(system, motion%frequency_ratio, motion%state, motion%lyapunov_exponent, motion%lyapunov_error, &
                              trend)
   end subroutine add_exponent

   !> Whether a motion to start from has a state or coefficients of the right size.
   subroutine check_start(system, start, error)
      type(system_type), intent(in) :: system
      !> The motion.
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

end module geartrain_analyses_steady_motion
