!> The state with which a run-up begins: of the steady motion at its first speed under the mean torques of the ramp.
module geartrain_analyses_run_up_start
   use geartrain_analyses_steady_motion, only: check_start
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_error, only: error_type, fatal, status_ended_early
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_base_words, only: lambda, operator(//), words_type
   use geartrain_flow_integration_settings, only: integration_settings_type
   use geartrain_flow_ramped_flow, only: run_up_type
   use geartrain_flow_settling, only: need_to_settle, settle
   use geartrain_flow_start_state, only: resting_state, state_of
   use geartrain_flow_time_constants, only: negligible, settle_by_time, settled_type, settling_time
   use geartrain_flow_window, only: goes_by_windows
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: find_start, tell_start

contains

   !> Finds the state: from period to period where the common period of all meshes is short, else by the time constants of the
   !> train.
   subroutine find_start(steady, system, shift, max_periods, frequency_ratio, result, error, stopped, start, observer)
      !> The train at constant speed, and under the mean torques of the ramp.
      type(system_type), intent(in) :: steady, system
      !> State of the latter less the state as it is told [1], (state).
      real(dp), intent(in) :: shift(:)
      !> Most periods of the fundamental to settle; 0: the state is that at rest, or of `start`.
      integer, intent(in) :: max_periods
      !> Lambda at the beginning [1].
      real(dp), intent(in) :: frequency_ratio
      !> Gets state, start_period, start_settling and start_ringing.
      type(run_up_type), intent(inout) :: result
      !> The motion grows without bound, or `start` does not fit.
      type(error_type), allocatable, intent(inout) :: error
      !> Whether the observer or an interrupt ended the search.
      logical, intent(out) :: stopped
      !> Motion to settle from; absent: at rest.
      type(motion_type), intent(in), optional :: start
      !> Told of 'settling' or 'settling by time'; may end the search.
      class(observer_type), intent(inout), optional :: observer
      type(integration_settings_type) :: settling
      type(settled_type) :: settled
      type(motion_type) :: motion
      !> Time of settling before phase 0 [1].
      real(dp) :: before
      real(dp) :: state(system%states)
      logical :: unbounded

      stopped = .false.
      unbounded = .false.
      before = 0
      if (max_periods > 0 .and. goes_by_windows(system, 0)) before = settling_time(system, frequency_ratio, max_periods)
      state = resting_state(system)
      if (present(start)) then
         call check_start(system, start, error)
         if (allocated(error)) return
         call state_of(steady, start, state, -frequency_ratio*before)
         state = state + shift
      end if
      if (before > 0) then
         call settle_by_time(system, frequency_ratio, max_periods, state, settled, observer)
         stopped = settled%stopped
         unbounded = settled%unbounded
         result%start_settling = settled%time/system%characteristic_frequency
         result%start_ringing = settled%ringing
      else if (max_periods > 0) then
         settling%max_periods = max_periods
         ! The state is all that is used of the motion.
         settling%harmonics = 1
         call need_to_settle(system, settling%harmonics, error)
         if (allocated(error)) return
         call settle(system, frequency_ratio, settling, state, motion, observer, stopped)
         unbounded = .not. allocated(motion%coefficients)
         result%start_period = motion%period
      end if
      if (stopped) return
      if (unbounded) then
         call fatal(error, 'run up: the motion grows without bound at '//lambda(frequency_ratio)//', where the run-up &
                    &begins', status_ended_early)
         return
      end if
      result%state = state - shift
   end subroutine find_start

   !> Tells of the beginning, where it was not a steady motion, after why the run-up ended.
   subroutine tell_start(max_periods, frequency_ratio, result)
      !> Most periods of the fundamental to settle; 0: it did not.
      integer, intent(in) :: max_periods
      !> Lambda at the beginning [1].
      real(dp), intent(in) :: frequency_ratio
      !> The run-up, of which `ended` is completed.
      type(run_up_type), intent(inout) :: result
      type(words_type) :: note

      note = words_type('')
      if (max_periods == 0 .or. result%start_period > 0) return
      if (.not. result%start_settling > 0) then
         note = '; no steady motion was found at '//lambda(frequency_ratio)//': the run-up begins with the state after ' &
                //text(max_periods)//' periods of the fundamental'
      else if (result%start_ringing < 0) then
         note = '; whether the motion was steady at '//lambda(frequency_ratio)//', where the run-up begins, is not known: &
                &some natural vibration is too slow to be read within '//text(result%start_settling)//' s of settling'
      else if (result%start_ringing > negligible) then
         note = '; no steady motion was reached at '//lambda(frequency_ratio)//', where the run-up begins: after ' &
                //text(result%start_settling)//' s free vibrations were still '//text(result%start_ringing)//' of the alternating &
                &displacement'
      end if
      result%ended = result%ended//note
   end subroutine tell_start

end module geartrain_analyses_run_up_start
