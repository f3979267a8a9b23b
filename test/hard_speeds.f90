!> Very slow and very fast meshing, loads that do not hold the teeth together, stiffness that vanishes, orders without a common
!> divisor.
module hard_speeds
   use fixtures, only: paper_train, settings_of, single_pair
   use geartrain, only: branch_type, dp, error_type, integrate, integration_settings_type, motion_type, refine, &
      response_settings_type, sweep, sweep_type, train_type
   use readings, only: solution, solve
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: speeds_cases

contains

   subroutine speeds_cases(tests)
      class(tests_type), intent(inout) :: tests

      call tests%heading('Speeds, loads, stiffness, orders')
      if (tests%runs('quasi_static')) call quasi_static(tests)
      if (tests%runs('fast')) call fast(tests)
      if (tests%runs('no_torque')) call no_torque(tests)
      if (tests%runs('soft_mesh')) call soft_mesh(tests)
      if (tests%runs('hunting_teeth')) call hunting_teeth(tests)
   end subroutine speeds_cases

   !> So slow that p - b = f/kappa(t) at every instant: with kappa = 1 + a cos, harmonic n has the amplitude
   !> 2 f/sqrt(1 - a^2) ((1 - sqrt(1 - a^2))/a)^n, up to the order of Lambda^2.
   subroutine quasi_static(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(motion_type) :: motion
      type(integration_settings_type) :: settings
      type(error_type), allocatable :: error
      real(dp), parameter :: a = 0.3_dp, load = 0.4_dp
      real(dp) :: root, rho, expected

      root = sqrt(1 - a**2)
      rho = (1 - root)/a
      expected = 2*load/root*rho/sqrt(1 - rho**2)
      train = paper_train(a)
      motion = solution(train, settings_of(1e-3_dp, 1.001e-3_dp, 12))
      call tests%measured('Lambda = 1e-3, balance', 'the quasi-static rms in closed form', &
                          maxval(abs(motion%rms/expected - 1)), 1e-5_dp)
      call tests%holds('Lambda = 1e-3, balance', 'stable, though the multipliers are below the smallest number that counts', &
                       motion%stable .and. .not. motion%undecided)
      call integrate(train, 1e-3_dp, settings, motion, error)
      call tests%measured('Lambda = 1e-3, integration from rest (16000 periods of ringing in a period of the fundamental)', &
                          'the quasi-static rms in closed form', maxval(abs(motion%rms/expected - 1)) + abs(motion%period - 1), &
                          1e-5_dp)
   end subroutine quasi_static

   subroutine fast(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(motion_type) :: motion, exact
      type(integration_settings_type) :: settings
      type(response_settings_type) :: range
      type(error_type), allocatable :: error
      type(branch_type) :: branch

      train = paper_train()
      range = settings_of(100.0_dp, 20.0_dp, 6)
      range%step = 5
      branch = solve(train, range)
      call tests%holds('Lambda from 100 down to 20', 'complete and stable throughout', branch%complete .and. all(branch%stable))
      motion = solution(train, settings_of(100.0_dp, 99.9_dp, 6))
      exact = motion
      call refine(train, exact, error)
      if (allocated(error)) exact%rms = huge(1.0_dp)
      call tests%measured('Lambda = 100, balance', 'shooting, relative', maxval(abs(motion%rms/exact%rms - 1)), 1e-9_dp)
      settings%max_periods = 1000
      call integrate(train, 100.0_dp, settings, motion, error)
      if (motion%period /= 1) motion%rms = huge(1.0_dp)
      call tests%measured('Lambda = 100, integration for 1000 periods of the fundamental, not a tenth of what the slow modes take &
         &to decay', &
                          'shooting, relative', maxval(abs(motion%rms/exact%rms - 1)), 1e-9_dp)
   end subroutine fast

   subroutine no_torque(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: branch
      type(motion_type) :: motion, exact
      type(error_type), allocatable :: error

      train = paper_train()
      train%input_torque = 0
      branch = solve(train, settings_of(0.2_dp, 2.6_dp, 6))
      call tests%holds('no torque', 'told: the train floats in its gaps, its mean position is not unique', &
                       .not. branch%complete .and. index(branch%ended%text, 'floats in its gaps') > 0)
      train%meshes(1)%error_cos = [5e-6_dp]
      train%meshes(2)%error_cos = [5e-6_dp]
      call floating(tests, train)
      train%meshes%half_backlash = 0
      motion = solution(train, settings_of(0.9_dp, 0.91_dp, 12))
      exact = motion
      call refine(train, exact, error)
      if (allocated(error)) exact%rms = huge(1.0_dp)
      call tests%measured('no torque, no gap, transmission error', 'shooting, relative', &
                          maxval(abs(motion%rms/exact%rms - 1)), 1e-10_dp)
   end subroutine no_torque

   !> Time integration of a train without torque, with an error that keeps within the gaps and with one that does not.
   subroutine floating(tests, train)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      type(train_type) :: rough
      type(motion_type) :: motion, start, other
      type(sweep_type) :: swept
      type(integration_settings_type) :: settings
      type(error_type), allocatable :: error
      real(dp), parameter :: shift = -0.2_dp
      integer :: j

      call integrate(train, 0.9_dp, settings, motion, error)
      call tests%holds('no torque, integration', 'told: settled, but floating', motion%period == 1 .and. motion%floating)
      start = motion
      ! The meshes are elements 2 and 4 of 5; they do not touch, so that nothing brings them back.
      start%state([2, 4]) = start%state([2, 4]) + shift
      call integrate(train, 0.9_dp, settings, other, error, start)
      call tests%measured('the same from 0.2 further back in the gap', 'the same motion 0.2 further back, all means and extremes', &
                          maxval([(abs([other%mean(j) - motion%mean(j), other%maximum(j) - motion%maximum(j), &
                                        other%minimum(j) - motion%minimum(j)] - shift), j=1, 2)]), 1e-9_dp)
      settings%start = 0.9_dp
      settings%stop = 0.95_dp
      settings%points = 2
      call sweep(train, settings, swept, error)
      call tests%holds('no torque, a sweep', 'told: the train floats in its gaps, its mean position is not unique', &
                       swept%complete .and. index(swept%ended%text, 'floats in its gaps') > 0)
      rough = train
      rough%meshes(1)%error_cos = [200e-6_dp]
      rough%meshes(2)%error_cos = [200e-6_dp]
      call integrate(rough, 0.5_dp, settings, motion, error)
      call tests%holds('no torque, both flanks of both meshes hit', 'not said to float', motion%period > 0 .and. &
                       .not. motion%floating .and. all(motion%maximum > 1 .and. motion%minimum < -1))
   end subroutine floating

   !> Mean stiffness 1, in part of the period none or less; contact is lost, and at the last of these the back flanks collide.
   subroutine soft_mesh(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(motion_type) :: motion, exact
      type(error_type), allocatable :: error
      real(dp), parameter :: kappa(*) = [1.0_dp, 1.2_dp, 2.0_dp], frequency_ratio(*) = [1.1_dp, 1.1_dp, 0.9_dp]
      character(8) :: text
      integer :: i

      do i = 1, size(kappa)
         train = single_pair(0.05_dp, kappa(i), 1.0_dp)
         motion = solution(train, settings_of(frequency_ratio(i), frequency_ratio(i) + 0.001_dp, 48))
         exact = motion
         call refine(train, exact, error)
         if (allocated(error)) exact%rms = huge(1.0_dp)
         write (text, '(f4.1)') 1 - kappa(i)
         call tests%measured('stiffness down to '//trim(adjustl(text))//' of its mean', 'shooting: rms at R = 48', &
                             maxval(abs(motion%rms/exact%rms - 1)), 1e-8_dp)
         if (.not. allocated(motion%multipliers)) cycle
         call tests%measured('the same', 'shooting: largest multiplier at R = 48, relative', &
                             abs(abs(motion%multipliers(1)/exact%multipliers(1)) - 1), 1e-4_dp)
      end do
   end subroutine soft_mesh

   !> Orders 17 and 23: only sums of few of them are carried, and the error estimate covers the rest.
   subroutine hunting_teeth(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(motion_type) :: motion, exact
      type(error_type), allocatable :: error
      type(response_settings_type) :: settings
      real(dp) :: difference
      integer :: carried, n

      train = paper_train()
      train%meshes%order = [17, 23]
      settings = settings_of(0.0541_dp, 0.0542_dp, 138)
      settings%stability = .false.
      motion = solution(train, settings)
      carried = count(abs(motion%coefficients(2::2, 1)) + abs(motion%coefficients(3::2, 1)) > 0)
      exact = motion
      call refine(train, exact, error)
      if (allocated(error)) exact%rms = huge(1.0_dp)
      call tests%measured('orders 17 and 23, contact lost, R = 138', 'shooting: rms', maxval(abs(motion%rms - exact%rms)), 2e-5_dp)
      n = min(size(motion%coefficients, 1), size(exact%coefficients, 1))
      difference = sqrt(sum((motion%coefficients(:n, :) - exact%coefficients(:n, :))**2)/sum(exact%coefficients(2:, :)**2))
      call tests%measured('the same', 'shooting: error of the waveform over its estimate', difference/motion%error_estimate, &
                          2.0_dp)
      call tests%holds('the same', 'fewer than 80 of the 138 harmonics are carried', carried < 80)
      train%meshes%order = [17, 17]
      settings%harmonics = 102
      motion = solution(train, settings)
      carried = count(abs(motion%coefficients(2::2, 1)) + abs(motion%coefficients(3::2, 1)) > 0)
      train%meshes%order = [1, 1]
      settings = settings_of(17*0.0541_dp, 17*0.0542_dp, 6)
      settings%stability = .false.
      exact = solution(train, settings)
      call tests%measured('orders 17 and 17, R = 102', 'orders 1 and 1 at 17 times the speed, R = 6 (six harmonics carried)', &
                          maxval(abs(motion%rms - exact%rms)) + abs(carried - 6), 1e-12_dp)
   end subroutine hunting_teeth

end module hard_speeds
