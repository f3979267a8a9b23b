!> Settling by Newton's method: random trains with slow modes, and where a response of a random train begins.
module hard_settling
   use, intrinsic :: iso_fortran_env, only: int64
   use fixtures, only: rattling_pair, slow_train, uniform
   use geartrain, only: branch_type, dp, error_type, integrate, integration_settings_type, motion_type, response, &
                        response_settings_type, train_type
   use geartrain_flow_lyapunov, only: largest_exponent
   use geartrain_flow_start_state, only: resting_state
   use geartrain_network_system, only: build_system, system_type
   use readings, only: nearest_approach
   use testing, only: full, tests_type
   implicit none (type, external)
   private
   public :: settling_cases

contains

   subroutine settling_cases(tests)
      class(tests_type), intent(inout) :: tests

      call tests%heading('Slow modes and starts')
      if (tests%runs('slow_modes', full)) call slow_modes(tests)
      if (tests%runs('starts', full)) call starts(tests)
      if (tests%runs('rattling_starts', full)) call rattling_starts(tests)
   end subroutine settling_cases

   !> What integration with its defaults says of 90 random trains. Where the plain flow goes is the judge of what settles, an
   !> average ten times as long that of what does not.
   subroutine slow_modes(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: longest = 20000
      type(train_type) :: train
      type(system_type) :: system
      type(motion_type) :: motion
      type(integration_settings_type) :: settings
      type(error_type), allocatable :: error
      integer(int64) :: generator
      real(dp) :: frequency_ratio, uncertain
      real(dp), allocatable :: longer
      integer :: i, trains, settled, unbounded, told, elsewhere, refuted

      trains = tests%times(90)
      settled = 0
      unbounded = 0
      told = 0
      elsewhere = 0
      refuted = 0
      generator = 1 + 1000*tests%seed
      do i = 1, trains
         call slow_train(generator, train, frequency_ratio)
         call integrate(train, frequency_ratio, settings, motion, error)
         if (allocated(error)) then
            unbounded = unbounded + 1
            cycle
         end if
         call build_system(train, system)
         if (motion%period > 0) then
            settled = settled + 1
            if (nearest_approach(system, resting_state(system), motion, 0.02_dp, longest) > 0.02_dp) &
               elsewhere = elsewhere + 1
         else if (motion%kind == 'chaotic' .or. motion%kind == 'quasi-periodic') then
            call largest_exponent(system, frequency_ratio, motion%state, longest, longer, uncertain)
            if (.not. allocated(longer)) cycle
            if (motion%kind == 'chaotic' .eqv. longer > uncertain) told = told + 1
            if (motion%kind == 'quasi-periodic' .and. abs(longer) > motion%lyapunov_error) refuted = refuted + 1
         end if
      end do
      call tests%holds('Random trains with slow modes', 'settle, run away, or are told to be chaotic or quasi-periodic, as ten &
                       &times as long an average confirms: 85 of 90', settled + unbounded + told - refuted >= (85*trains)/90)
      call tests%holds('those that settle', &
                       'come near the motion without Newton''s method within 20000 periods, all of them', elsewhere == 0)
   end subroutine slow_modes

   !> A response of each of 200 random trains over a range at random, of each period from 1 to 3.
   subroutine starts(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: branch
      type(response_settings_type) :: settings
      type(error_type), allocatable :: error
      integer(int64) :: generator
      real(dp) :: frequency_ratio
      integer :: i, trains, failed

      trains = tests%times(200)
      failed = 0
      generator = 77 + 1000*tests%seed
      do i = 1, trains
         call slow_train(generator, train, frequency_ratio)
         settings%start = uniform(generator, 0.2_dp, 2.2_dp)
         settings%stop = settings%start + 0.3_dp
         if (mod(i, 3) == 0) then
            ! Rattle: a mean torque that the fluctuation outweighs.
            train%torque_cos = [uniform(generator, 5.0_dp, 60.0_dp)]
            train%input_torque = uniform(generator, 0.5_dp, 20.0_dp)
         end if
         settings%subharmonic = 1 + mod(i, 4)/2
         settings%harmonics = 10*settings%subharmonic
         settings%stability = .false.
         settings%max_points = 100
         call response(train, settings, branch, error)
         if (index(branch%ended%text, 'found to start from') > 0) failed = failed + 1
      end do
      call tests%holds('responses of random trains', 'a motion to start from at both ends, each time', failed == 0)
   end subroutine starts

   subroutine rattling_starts(tests)
      class(tests_type), intent(inout) :: tests
      real(dp), parameter :: torque(*) = [0.2_dp, 1.0_dp, 5.0_dp]
      type(branch_type) :: branch
      type(response_settings_type) :: settings
      type(error_type), allocatable :: error
      integer :: i, j, failed

      failed = 0
      settings%harmonics = 0
      settings%stability = .false.
      settings%max_points = 100
      do i = 1, size(torque)
         do j = 1, 20, 20/tests%times(20)
            settings%start = 0.1_dp*j
            settings%stop = 0.1_dp*j + 0.25_dp
            call response(rattling_pair(torque(i)), settings, branch, error)
            if (index(branch%ended%text, 'found to start from') > 0) failed = failed + 1
         end do
      end do
      call tests%holds('a pair that rattles under 10 N m about 0.2, 1 and 5, Lambda from 0.1 to 2.25, harmonics by tolerance', &
                       'a motion to start from at both ends, each time', failed == 0)
      settings%harmonics = 12
      settings%start = 0.1_dp
      settings%stop = 0.15_dp
      call response(rattling_pair(1.0_dp), settings, branch, error)
      call tests%holds('the same with 12 harmonics at 0.1, too few for it', 'told, and how many do', &
                       index(branch%ended%text, 'found to start from with 12 harmonics: there is one with') > 0)
   end subroutine rattling_starts

end module hard_settling
