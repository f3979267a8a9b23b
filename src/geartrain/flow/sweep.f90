!> Time integration over a range of frequencies, each begun with the state that the last one ended in.
module geartrain_flow_sweep
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_error, only: error_type, fatal, status_ended_early
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_flow_floating, only: note_of
   use geartrain_flow_integration, only: add_exponent
   use geartrain_flow_integration_settings, only: integration_settings_type, sweep_type
   use geartrain_flow_settling, only: settle
   use geartrain_flow_start_state, only: resting_state
   use geartrain_flow_variables, only: check_integration
   use geartrain_model_check, only: check_train
   use geartrain_model_system, only: build_system, system_type
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: sweep

contains

   !> Visits settings%points frequencies between start and stop, upwards, downwards or both. A frequency without a steady
   !> motion has period 0; the sweep goes on from the state reached, or from rest where the motion grew without bound. A sweep under
   !> way (its motions are there, why it ended is not, as in a checkpoint of the same case) is taken up after its last motion.
   subroutine sweep(train, settings, result, error, observer)
      type(train_type), intent(in) :: train
      type(integration_settings_type), intent(in) :: settings
      type(sweep_type), intent(inout), target :: result
      type(error_type), allocatable, intent(out) :: error
      class(observer_type), intent(inout), optional :: observer
      type(sweep_type) :: empty
      type(motion_type) :: motion
      type(system_type) :: system
      real(dp), allocatable :: state(:)
      real(dp) :: low, high, frequency_ratio
      integer :: i, n, done, total, status
      logical :: keep_going, stopped, resumed

      total = merge(2*settings%points, settings%points, settings%direction == 'both')
      resumed = allocated(result%motions) .and. .not. allocated(result%ended)
      if (resumed) resumed = size(result%motions) == total
      if (.not. resumed) result = empty
      call check_train(train, error)
      if (allocated(error)) return
      call check_integration(train, settings, error)
      if (allocated(error)) return
      call build_system(train, system)
      allocate (state(system%states))
      state = resting_state(system)
      low = min(settings%start, settings%stop)
      high = max(settings%start, settings%stop)
      n = settings%points
      if (.not. resumed) then
         allocate (result%motions(total), result%direction(total), stat=status)
         if (status /= 0) then
            call fatal(error, 'integration: no memory for '//text(total)//' motions: take fewer points', status_ended_early)
            return
         end if
      end if
      result%direction = 'up'
      if (settings%direction == 'down') result%direction = 'down'
      if (settings%direction == 'both') result%direction(n + 1:) = 'down'
      done = count(result%motions%frequency_ratio > 0)
      if (done > 0) then
         if (allocated(result%motions(done)%coefficients)) state = result%motions(done)%state
      end if
      do i = done + 1, total
         frequency_ratio = low
         if (n > 1) frequency_ratio = low + (high - low)*(mod(i - 1, n)/real(n - 1, dp))
         if (mod(i, n) == 0 .and. n > 1) frequency_ratio = high
         if (result%direction(i) == 'down') frequency_ratio = low + high - frequency_ratio
         call settle(system, frequency_ratio, settings, state, motion, observer, stopped)
         if (stopped) exit
         call add_exponent(system, settings, motion, observer)
         if (system%interrupt%raised()) exit
         ! A whole motion or none: what has a frequency counts as done where the sweep is taken up again.
         result%motions(i) = motion
         if (.not. allocated(motion%coefficients)) state = resting_state(system)
         done = i
         if (.not. present(observer)) cycle
         keep_going = .true.
         call observer%on_step('integration', i, frequency_ratio, keep_going)
         if (.not. keep_going) exit
      end do
      result%complete = done == total
      result%ended = 'all points done'
      if (.not. result%complete) result%ended = 'cancelled at Lambda = '//text(frequency_ratio)
      result%ended = result%ended//note_of(any(result%motions%floating))
      if (result%complete) return
      result%motions = result%motions(:done)
      result%direction = result%direction(:done)
   end subroutine sweep

end module geartrain_flow_sweep
