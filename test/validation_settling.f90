!> Settling by Newton's method gives the motion that the flow goes to, exactly, and says what does not settle.
module validation_settling
   use, intrinsic :: iso_fortran_env, only: int64
   use fixtures, only: paper_train, rattling_pair, single_pair, slow_train
   use geartrain, only: branch_type, dp, error_type, integrate, integration_settings_type, motion_type, refine, response, &
                        response_settings_type, train_type
   use geartrain_base_kinds, only: pi
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_flow_kind, only: flow_kind
   use geartrain_flow_lyapunov, only: largest_exponent
   use geartrain_flow_orbit, only: flow_order, flow_tolerance
   use geartrain_flow_section_trend, only: section_trend_type
   use geartrain_flow_settling, only: settle
   use geartrain_flow_start_state, only: resting_state
   use geartrain_network_system, only: build_system, system_type
   use readings, only: nearest_approach
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: settling_tests

contains

   subroutine settling_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('slow_decay')) call slow_decay(tests)
      if (tests%runs('slow_modes')) call slow_modes(tests)
      if (tests%runs('basins')) call basins(tests)
      if (tests%runs('chaos')) call chaos(tests)
      if (tests%runs('rattle')) call rattle(tests)
      if (tests%runs('trend')) call trend_of_sections(tests)
      if (tests%runs('kind_by_trend')) call kind_by_trend(tests)
   end subroutine settling_tests

   !> Sections in closed form: an orbit of period 3, and about it a vibration whose amplitude is q**k at section k. The energy of
   !> differences three sections apart changes by q**2 a section, that of neighbouring ones keeps the size of the orbit.
   subroutine trend_of_sections(tests)
      class(tests_type), intent(inout) :: tests
      real(dp), parameter :: decay(*) = [0.999_dp, 0.9995_dp, 0.99999_dp, 1.0_dp, 1.0005_dp], turn = 0.6_dp
      type(section_trend_type) :: trend
      type(system_type) :: system
      real(dp) :: state(2)
      integer :: i, k

      call build_system(single_pair(0.05_dp, 0.3_dp, 1.0_dp), system)
      do i = 1, size(decay)
         call trend%begin(system)
         do k = 1, 700
            state = [mod(k, 3) + 1e-3_dp*decay(i)**k*cos(turn*k), 1e-3_dp*decay(i)**k*sin(turn*k)]
            call trend%add(state)
         end do
         trend%first = 101
         call trend%measure()
         call tests%is_true(trend%periods == 600 .and. size(trend%change) == 16, 'sections of a trend')
         ! The middles of two blocks are 99 sections apart. The turns of the vibration do not average out quite.
         call tests%is_close(trend%change(3), 6*99*2*log(decay(i)), 1e-3_dp, 'trend: three sections apart')
         call tests%is_true(abs(trend%change(3) - 6*99*2*log(decay(i))) <= 1e-6_dp + trend%error(3), 'trend: as near as it says')
         call tests%is_close(trend%change(1), 0.0_dp, 1e-5_dp, 'trend: neighbouring sections keep the size of the orbit')
         call tests%is_true(maxval(abs(trend%last() - state)) < 1e-12_dp, 'trend: the last state')
      end do
      call trend%begin(system)
      do k = 1, 50
         call trend%add([real(k, dp), 0.0_dp])
      end do
      call trend%measure()
      call tests%is_true(size(trend%change) == 0, 'trend: too few sections')
   end subroutine trend_of_sections

   !> An exponent of 0 within its uncertainty is that of a torus only where the sections keep their size. The pair is at rest but
   !> for a vibration which dies out, keeps its size or grows by its damping, x'' + 2 z x' + x = f.
   subroutine kind_by_trend(tests)
      class(tests_type), intent(inout) :: tests
      real(dp), parameter :: damping(*) = [1e-3_dp, 1e-4_dp, 1e-5_dp, 0.0_dp]
      character(14), parameter :: kinds(*) = [character(14) :: 'still settling', 'still settling', 'still settling', &
                                              'quasi-periodic']
      type(section_trend_type) :: trend
      type(system_type), target :: system
      type(flow_type) :: flow
      integer :: i, k

      do i = 1, size(damping)
         call build_system(single_pair(damping(i), 0.05_dp, 1.0_dp), system)
         call flow%setup(system, 1, flow_order, flow_tolerance)
         flow%x(1, :) = resting_state(system)
         call trend%begin(system)
         do k = 1, 300
            call flow%pass_period(1.3_dp)
            call trend%add(flow%x(1, :))
         end do
         call tests%is_text(trim(flow_kind(system, 1.3_dp, flow%x(1, :), 0.0_dp, 1e-4_dp, trend)), trim(kinds(i)), &
                            'a pair that rings down, with an exponent too near to 0')
         ! Of a parametric vibration with complex multipliers the damping is its decay.
         call tests%is_close(trend%change(1), -2*damping(i)*2*pi/1.3_dp*6*49, 1e-2_dp*damping(i)/1e-3_dp + 1e-4_dp, &
                             'a pair that rings down: change of its sections')
      end do
   end subroutine kind_by_trend

   !> Figure 4, k3 = 2e4 N m/rad, at 1.62: disturbances decay by 0.999256 a period of the fundamental, so that averages over
   !> hundreds of periods have shown growth.
   subroutine slow_decay(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(motion_type) :: motion, exact
      type(integration_settings_type) :: settings
      type(error_type), allocatable :: error
      type(system_type) :: system
      real(dp), allocatable :: exponent
      real(dp) :: uncertain

      train = paper_train()
      train%shafts(2)%stiffness = 2e4_dp
      call integrate(train, 1.62_dp, settings, motion, error)
      call tests%is_true(motion%period == 1, 'figure 4, k3 = 2e4 at 1.62: settles on period 1')
      if (motion%period /= 1) return
      exact = motion
      call refine(train, exact, error)
      call tests%is_close(maxval(abs(motion%rms - exact%rms)), 0.0_dp, 1e-11_dp, 'figure 4: rms as by shooting')
      call tests%is_true(motion%error_estimate < 1e-10_dp, 'figure 4: exact, and says so')
      call tests%is_close(motion%lyapunov_exponent*2*pi/1.62_dp, log(0.999256_dp), 1e-6_dp, 'figure 4: the exponent is ln(rho)/T')
      ! The average itself: from a state on its way, it must not tell of growth.
      call build_system(train, system)
      call largest_exponent(system, 1.62_dp, resting_state(system), 2000, exponent, uncertain)
      call tests%is_true(exponent < uncertain, 'figure 4: no growth by the average from rest')
      call tests%is_true(abs(exponent - motion%lyapunov_exponent) < max(uncertain, 1e-4_dp), &
                         'figure 4: the average from rest is as near as it says')
   end subroutine slow_decay

   !> The first of the random trains with slow modes; hard_settling has ninety.
   subroutine slow_modes(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(system_type) :: system
      type(motion_type) :: motion
      type(integration_settings_type) :: settings
      type(error_type), allocatable :: error
      integer(int64) :: generator
      real(dp) :: frequency_ratio
      integer :: i, settled

      generator = 1
      settled = 0
      do i = 1, 10
         call slow_train(generator, train, frequency_ratio)
         call integrate(train, frequency_ratio, settings, motion, error)
         if (motion%period == 0) cycle
         settled = settled + 1
         call build_system(train, system)
         call tests%is_true(nearest_approach(system, resting_state(system), motion, 0.05_dp, 2000) <= 0.05_dp, &
                            'random trains: the plain flow comes near the motion')
      end do
      call tests%is_true(settled >= 8, 'random trains: 8 of 10 settle')
   end subroutine slow_modes

   !> Two motions of a pair at 0.8, of rms 0.355 and 1.014: each start of a grid settles on the one that the plain flow reaches.
   subroutine basins(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(system_type) :: system
      type(motion_type) :: motion
      type(integration_settings_type) :: settings
      real(dp) :: state(2), start(2)
      integer :: i, j, wrong, kinds(2)

      train = single_pair(0.05_dp, 0.3_dp, 0.4_dp)
      call build_system(train, system)
      wrong = 0
      kinds = 0
      do i = -4, 4
         do j = -4, 4
            start = [i*0.9_dp, j*0.8_dp]
            state = start
            call settle(system, 0.8_dp, settings, state, motion)
            if (motion%period == 0) wrong = wrong + 1
            if (motion%period == 0) cycle
            kinds(merge(1, 2, motion%rms(1) < 0.6_dp)) = kinds(merge(1, 2, motion%rms(1) < 0.6_dp)) + 1
            if (nearest_approach(system, start, motion, 1e-6_dp, 2000) > 1e-6_dp) wrong = wrong + 1
         end do
      end do
      call tests%is_true(wrong == 0, 'two motions at 0.8: every start settles where the plain flow goes')
      call tests%is_true(all(kinds > 0), 'two motions at 0.8: both are reached')
   end subroutine basins

   !> A pair with kappa = 0.6 at 1.9 is chaotic, one without damping quasi-periodic, and each is told so.
   subroutine chaos(tests)
      class(tests_type), intent(inout) :: tests
      type(motion_type) :: motion
      type(integration_settings_type) :: settings
      type(error_type), allocatable :: error

      settings%max_periods = 1000
      call integrate(single_pair(0.05_dp, 0.6_dp, 1.0_dp), 1.9_dp, settings, motion, error)
      call tests%is_text(trim(motion%kind), 'chaotic', 'a pair between its period doublings')
      call integrate(single_pair(0.0_dp, 0.3_dp, 1.0_dp), 3.3_dp, settings, motion, error)
      call tests%is_text(trim(motion%kind), 'quasi-periodic', 'a pair without damping')
      call integrate(single_pair(0.05_dp, 0.3_dp, 1.0_dp), 0.4_dp, settings, motion, error)
      call tests%is_text(trim(motion%kind), 'periodic', 'a pair in contact')
   end subroutine chaos

   !> A pair that rattles begins its response at a motion which only time integration knows; one that is unstable does as well.
   subroutine rattle(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(response_settings_type) :: settings
      type(error_type), allocatable :: error

      settings%start = 0.1_dp
      settings%stop = 0.12_dp
      settings%harmonics = 0
      settings%stability = .false.
      settings%max_points = 20
      call response(rattling_pair(0.2_dp), settings, branch, error)
      call tests%is_true(branch%points > 0 .and. index(branch%ended%text, 'found to start from') == 0, &
                         'rattling pair: '//branch%ended%text)
      settings%harmonics = 12
      call response(rattling_pair(1.0_dp), settings, branch, error)
      call tests%is_true(index(branch%ended%text, 'found to start from with 12 harmonics: there is one with') > 0, &
                         'too few harmonics: '//branch%ended%text)
   end subroutine rattle

end module validation_settling
