!> Settling by the time constants of a train: slow free vibrations are read and taken out, the observer hears of it and may end it.
module unit_time_constants
   use fixtures, only: paper_train
   use geartrain, only: dp, error_type, integrate, integration_settings_type, motion_type, observer_type, train_type
   use geartrain_base_kinds, only: pi
   use geartrain_flow_slow_modes, only: slow_modes_type
   use geartrain_flow_start_state, only: resting_state
   use geartrain_flow_time_constants, only: settle_by_time, settled_type
   use geartrain_flow_uncertainty, only: figure_uncertainty_type, uncertainty_of
   use geartrain_flow_window, only: cycle_time, goes_by_windows, window_of
   use geartrain_network_system, only: build_system, system_type
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: time_constants_tests

   !> Counts what it is told of, and says no from some call on.
   type, extends(observer_type) :: counter_type
      integer :: calls = 0, latest = 0, last = huge(0)
      logical :: rises = .true.
   contains
      procedure :: on_step
   end type counter_type

contains

   subroutine time_constants_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('taken_out')) call taken_out(tests)
      if (tests%runs('observer')) call told(tests)
      if (tests%runs('windows')) call windows(tests)
      if (tests%runs('uncertainty')) call uncertainty(tests)
   end subroutine time_constants_tests

   subroutine on_step(self, analysis, done, frequency_ratio, keep_going)
      class(counter_type), intent(inout) :: self
      character(*), intent(in) :: analysis
      integer, intent(in) :: done
      real(dp), intent(in) :: frequency_ratio
      logical, intent(inout) :: keep_going

      if (analysis /= 'settling by time') return
      self%calls = self%calls + 1
      self%rises = self%rises .and. (done >= self%latest .or. done < 2)
      self%latest = done
      if (self%calls >= self%last) keep_going = .false.
   end subroutine on_step

   !> The paper's train without any excitation, between two inertias on soft shafts of almost no damping.
   subroutine slow_system(system)
      type(system_type), intent(out) :: system
      type(train_type) :: train
      integer :: j

      train = paper_train()
      train%prime_mover_inertia = 0.02_dp
      train%load_inertia = 0.02_dp
      do j = 1, 3
         train%shafts(j)%damping_ratio = 1e-3_dp
      end do
      do j = 1, 2
         train%meshes(j)%stiffness_cos = [0.0_dp]
      end do
      call build_system(train, system)
   end subroutine slow_system

   !> A free vibration that would take thousands of cycles to die out is gone after the time of sixteen of its own.
   subroutine taken_out(tests)
      class(tests_type), intent(inout) :: tests
      type(system_type) :: system
      type(slow_modes_type) :: slow
      type(settled_type) :: settled
      real(dp), allocatable :: state(:), rest(:)
      real(dp) :: moved

      call slow_system(system)
      rest = resting_state(system)
      call slow%setup(system, 50*cycle_time(system, 0.9_dp), 1000*cycle_time(system, 0.9_dp))
      call tests%is_true(slow%count > 0 .and. .not. slow%unread, 'the train has modes that do not die out in time')
      state = rest
      ! The twists of the outer shafts, by a tenth of the gap: the teeth stay in contact.
      state([1, 5]) = state([1, 5]) + [0.1_dp, -0.07_dp]
      moved = maxval(abs(state - rest))
      call settle_by_time(system, 0.9_dp, 2000, state, settled)
      call tests%is_true(settled%time < 1000.5_dp*cycle_time(system, 0.9_dp), 'within a thousand cycles')
      call tests%is_close(maxval(abs(state - rest)), 0.0_dp, 3e-3_dp*moved, 'at rest')
      call tests%is_true(.not. (settled%stopped .or. settled%unbounded .or. settled%lost), 'nothing else was wrong')
   end subroutine taken_out

   !> A call for each cycle of settling and of the window, in both; at a no it ends.
   subroutine told(tests)
      class(tests_type), intent(inout) :: tests
      type(counter_type) :: counter
      type(motion_type) :: motion
      type(error_type), allocatable :: error
      integer :: last

      call integrate(paper_train(), 0.9_dp, integration_settings_type(window=40), motion, error, observer=counter)
      call tests%is_true(.not. allocated(error) .and. motion%window >= 40, 'a window of 40 cycles')
      call tests%is_true(counter%calls >= 85, 'a call for each cycle of settling and of the window')
      call tests%is_true(counter%rises, 'the number of cycles rises')
      do last = 1, 81, 40
         counter = counter_type(last=last)
         call integrate(paper_train(), 0.9_dp, integration_settings_type(window=40), motion, error, observer=counter)
         call tests%is_true(allocated(error), 'a no ends it')
         call tests%is_true(counter%calls <= last + 1, 'at once')
      end do
   end subroutine told

   !> Which trains go by windows, and how long these are.
   subroutine windows(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(system_type) :: system
      real(dp) :: cycles

      train = paper_train()
      call build_system(train, system)
      call tests%is_true(.not. goes_by_windows(system, 0) .and. goes_by_windows(system, 7), 'short: where asked for')
      call tests%is_close(window_of(system, 7), 7.0_dp, 1e-12_dp, 'seven cycles')
      train%meshes(1)%order = 483
      train%meshes(2)%order = 1886
      call build_system(train, system)
      call tests%is_true(goes_by_windows(system, 0), 'long')
      cycles = 483*window_of(system, 0)
      call tests%is_close(cycles, anint(cycles), 1e-9_dp, 'whole cycles of the slower mesh')
      call tests%is_true(cycles >= 100 .and. cycles <= 300, '100 to 300 of them')
      associate (other => cycles*1886/483)
         call tests%is_true(abs(other - anint(other)) < 0.02_dp, 'nearly whole cycles of the faster mesh')
      end associate
   end subroutine windows

   !> Signals of known figures: the uncertainty of a beat covers what its whole gives; a constant has none.
   subroutine uncertainty(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: n = 4000
      real(dp) :: signal(n)
      type(figure_uncertainty_type) :: of
      integer :: i

      signal = 3
      of = uncertainty_of(signal)
      call tests%is_close(maxval([of%mean, of%rms, of%minimum, of%maximum]), 0.0_dp, 1e-12_dp, 'of a constant')
      signal = [(sin(2*pi*100.37_dp*i/n) + 0.3_dp*sin(2*pi*231.71_dp*i/n), i=1, n)]
      of = uncertainty_of(signal)
      call tests%is_true(abs(sum(signal)/n) <= of%mean .and. of%mean < 0.02_dp, 'of the mean of two frequencies, which is 0')
      call tests%is_true(abs(sqrt(2*sum((signal - sum(signal)/n)**2)/n) - sqrt(1.09_dp)) <= of%rms .and. of%rms < 0.05_dp, &
                         'of the root of the sum of their squares')
      call tests%is_true(1.3_dp - maxval(signal) <= of%maximum .and. of%maximum < 0.1_dp, 'of their sum, the largest value')
   end subroutine uncertainty

end module unit_time_constants
