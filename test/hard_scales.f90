!> Trains of very small and very large parts, and units that do not fit: scaling laws and the limits that they lead to.
module hard_scales
   use fixtures, only: paper_train, settings_of
   use geartrain, only: branch_type, dp, error_type, motion_type, refine, response_settings_type, shaft_type, solutions_at, &
      train_type
   use geartrain_readings_summary, only: folds
   use readings, only: solution, solve
   use testing, only: full, tests_type
   implicit none (type, external)
   private
   public :: scales_cases

   !> Frequencies with one motion and with several.
   real(dp), parameter :: frequency_ratio(*) = [0.47_dp, 0.6_dp, 0.72_dp, 0.9_dp, 1.6_dp]

contains

   subroutine scales_cases(tests)
      class(tests_type), intent(inout) :: tests

      call tests%heading('Scales')
      if (tests%runs('homogeneous', full)) call homogeneous(tests)
      if (tests%runs('units', full)) call units(tests)
      if (tests%runs('light_load', full)) call light_load(tests)
      if (tests%runs('heavy_load', full)) call heavy_load(tests)
      if (tests%runs('gaps', full)) call gaps(tests)
      if (tests%runs('soft_shaft', full)) call soft_shaft(tests)
      if (tests%runs('stiff_shaft', full)) call stiff_shaft(tests)
      if (tests%runs('end_inertias', full)) call end_inertias(tests)
      if (tests%runs('between', full)) call between(tests)
   end subroutine scales_cases

   !> Torque, gap and transmission error times s: every displacement times s, the same folds.
   subroutine homogeneous(tests)
      class(tests_type), intent(inout) :: tests
      real(dp), parameter :: factor(*) = [1e-8_dp, 1e-4_dp, 3.7e-2_dp, 40.0_dp, 1e4_dp, 1e7_dp]
      character(12) :: text
      integer :: i

      do i = 1, size(factor)
         write (text, '(es8.1)') factor(i)
         call same_curve(tests, scaled(factor(i)), 1.0_dp, factor(i), &
                         'torque, gap and error times '//trim(adjustl(text))//', figure 3')
      end do
   end subroutine homogeneous

   function scaled(factor) result(train)
      real(dp), intent(in) :: factor
      type(train_type) :: train
      integer :: j

      train = paper_train()
      train%input_torque = factor*train%input_torque
      do j = 1, 2
         train%meshes(j)%half_backlash = factor*train%meshes(j)%half_backlash
         train%meshes(j)%error_cos = [factor*2e-6_dp]
      end do
   end function scaled

   !> Characteristic values that are off.
   subroutine units(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train

      train = scaled(1.0_dp)
      train%characteristic_length = 1e6_dp*train%characteristic_length
      call same_curve(tests, train, 1.0_dp, 1e-6_dp, 'characteristic length 1e6 times too large, figure 3')
      train = scaled(1.0_dp)
      train%characteristic_length = 1e-6_dp*train%characteristic_length
      call same_curve(tests, train, 1.0_dp, 1e6_dp, 'characteristic length 1e6 times too small, figure 3')
      train = scaled(1.0_dp)
      train%characteristic_frequency = 1e-6_dp*train%characteristic_frequency
      call same_curve(tests, train, 1e6_dp, 1.0_dp, 'characteristic frequency 1e6 times too small, figure 3')
      train = scaled(1.0_dp)
      train%characteristic_frequency = 1e3_dp*train%characteristic_frequency
      call same_curve(tests, train, 1e-3_dp, 1.0_dp, 'characteristic frequency 1e3 times too large, figure 3')
      train%characteristic_frequency = 1e3_dp*train%characteristic_frequency
      call same_curve(tests, train, 1e-6_dp, 1.0_dp, 'characteristic frequency 1e6 times too large, figure 3')
   end subroutine units

   !> Figure 3 (with a transmission error) in other units: Lambda times `fast`, displacements times `large`.
   subroutine same_curve(tests, train, fast, large, name)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      real(dp), intent(in) :: fast, large
      character(*), intent(in) :: name
      type(branch_type) :: known, branch
      type(response_settings_type) :: settings
      type(motion_type), allocatable :: expected(:), motions(:)
      type(error_type), allocatable :: error
      real(dp), allocatable :: at(:), expected_at(:)
      real(dp) :: worst, off
      integer :: i, k

      known = solve(scaled(1.0_dp), settings_of(0.2_dp, 2.6_dp, 6))
      settings = settings_of(0.2_dp*fast, 2.6_dp*fast, 6)
      branch = solve(train, settings)
      at = folds(branch)
      expected_at = folds(known)
      worst = 0
      off = 0
      if (.not. (branch%complete .and. size(at) == size(expected_at))) worst = huge(1.0_dp)
      do i = 1, size(frequency_ratio)
         call solutions_at(scaled(1.0_dp), settings_of(0.2_dp, 2.6_dp, 6), known, frequency_ratio(i), expected, error)
         call solutions_at(train, settings, branch, frequency_ratio(i)*fast, motions, error)
         if (size(motions) /= size(expected) .or. size(motions) == 0) worst = huge(1.0_dp)
         do k = 1, min(size(motions), size(expected))
            worst = max(worst, maxval(abs(motions(k)%rms/large - expected(k)%rms)/expected(k)%rms))
            off = max(off, maxval(abs(abs(motions(k)%multipliers) - abs(expected(k)%multipliers))))
         end do
      end do
      call tests%measured(name, 'rms of the same train in fitting units', worst, 1e-10_dp)
      ! Both are integrated with series cut at 5e-10 (floquet/step_rule.f90).
      call tests%measured(name, 'multipliers of the same train in fitting units', off, 2*5e-10_dp)
   end subroutine same_curve

   !> A light load never reaches the other flank: displacements in proportion to the torque.
   subroutine light_load(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(response_settings_type) :: settings
      type(branch_type) :: branch
      type(motion_type), allocatable :: expected(:), motions(:)
      type(error_type), allocatable :: error
      real(dp), parameter :: torque(*) = [1.0_dp, 1e-3_dp, 1e-6_dp], allowed(*) = [1e-12_dp, 1e-8_dp, 1e-5_dp]
      character(12) :: text
      real(dp) :: worst
      integer :: i, j, k

      settings = settings_of(0.2_dp, 2.6_dp, 6)
      worst = 0
      do j = 1, size(torque)
         train = paper_train()
         train%input_torque = torque(j)
         branch = solve(train, settings)
         if (.not. branch%complete) worst = huge(1.0_dp)
         do i = 1, 4
            call solutions_at(train, settings, branch, frequency_ratio(i), motions, error)
            if (j == 1) then
               ! Shooting knows of no scale.
               if (i /= 4) cycle
               expected = motions
               call refine(train, expected(1), error)
               cycle
            end if
         end do
         if (j == 1) cycle
         k = 1
         call refine(train, motions(k), error)
         if (allocated(error)) worst = huge(1.0_dp)
         write (text, '(es7.0)') torque(j)
         call tests%measured('torque '//trim(adjustl(text))//' N m in a gap of 30 um', &
                             'shooting at 0.9: rms per torque as at 1 N m', &
                             max(worst, maxval(abs(motions(k)%rms/torque(j) - expected(1)%rms)/expected(1)%rms)), allowed(j))
      end do
   end subroutine light_load

   !> Under a heavy load the gap is nothing: the same motion per torque.
   subroutine heavy_load(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train, no_gap
      type(motion_type) :: motion, expected
      real(dp), parameter :: torque(*) = [1e6_dp, 1e9_dp]
      character(12) :: text
      integer :: i

      do i = 1, size(torque)
         train = paper_train()
         train%input_torque = torque(i)
         no_gap = train
         no_gap%meshes%half_backlash = 0
         motion = solution(train, settings_of(0.4_dp, 0.41_dp, 12))
         expected = solution(no_gap, settings_of(0.4_dp, 0.41_dp, 12))
         write (text, '(es7.0)') torque(i)
         call tests%measured('torque '//trim(adjustl(text))//' N m', 'the train without backlash, per torque', &
                             maxval(abs(motion%rms/expected%rms - 1)), 1e-10_dp)
      end do
   end subroutine heavy_load

   !> A gap much smaller than the deflection is none; one much larger is a shift.
   subroutine gaps(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(motion_type) :: motion, expected

      train = paper_train()
      train%meshes%half_backlash = 0
      expected = solution(train, settings_of(0.9_dp, 0.91_dp, 12))
      train%meshes%half_backlash = 1e-12_dp
      motion = solution(train, settings_of(0.9_dp, 0.91_dp, 12))
      call tests%measured('half backlash 1e-12 m', 'no backlash (they differ by the order of the gap, 1e-7)', &
                          maxval(abs(motion%rms/expected%rms - 1)), 1e-6_dp)
      train%meshes%half_backlash = 30e-6_dp
      expected = solution(train, settings_of(0.9_dp, 0.91_dp, 12))
      train%meshes%half_backlash = 1
      motion = solution(train, settings_of(0.9_dp, 0.91_dp, 12))
      call tests%measured('half backlash 1 m', 'the same motion with 30 um, which does not reach the other flank', &
                          maxval(abs(motion%rms/expected%rms - 1)), 1e-9_dp)
   end subroutine gaps

   !> k3 small: each pair moves as if the other were not there.
   subroutine soft_shaft(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train, pair
      type(motion_type) :: motion, alone
      real(dp), parameter :: stiffness(*) = [1.0_dp, 1e-2_dp, 1e-4_dp], allowed(*) = [1e-4_dp, 1e-5_dp, 1e-6_dp]
      character(12) :: text
      integer :: i, j

      do i = 1, size(stiffness)
         train = paper_train()
         train%shafts(2)%stiffness = stiffness(i)
         motion = solution(train, settings_of(0.9_dp, 0.91_dp, 24))
         write (text, '(es7.0)') stiffness(i)
         do j = 1, 2
            pair = paper_train()
            pair%meshes = [pair%meshes(j)]
            if (j == 1) then
               pair%shafts = [pair%shafts(1), shaft_type(rigid=.true.)]
               pair%load_inertia = 0
            else
               pair%shafts = [shaft_type(rigid=.true.), pair%shafts(3)]
               pair%prime_mover_inertia = 0
               pair%input_torque = 2*pair%input_torque
            end if
            alone = solution(pair, settings_of(0.9_dp, 0.91_dp, 24))
            call tests%measured('k3 = '//trim(adjustl(text))//' N m/rad, mesh '//achar(iachar('0') + j), &
                                'the pair alone (they differ by the damping of the shaft, the root of k3)', &
                                abs(motion%rms(j)/alone%rms(1) - 1), allowed(i))
         end do
      end do
   end subroutine soft_shaft

   !> k3 large: the model with a rigid shaft, from which it differs in proportion to 1/k3.
   subroutine stiff_shaft(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train, rigid
      type(motion_type) :: motion, expected
      real(dp), parameter :: stiffness(*) = [1e10_dp, 1e12_dp, 1e14_dp], allowed(*) = [1e-2_dp, 1e-4_dp, 1e-6_dp]
      type(response_settings_type) :: settings
      character(12) :: text
      integer :: i

      settings = settings_of(0.9_dp, 0.91_dp, 12)
      settings%stability = .false.
      rigid = paper_train()
      rigid%shafts(2) = shaft_type(rigid=.true.)
      expected = solution(rigid, settings)
      do i = 1, size(stiffness)
         train = paper_train()
         train%shafts(2)%stiffness = stiffness(i)
         motion = solution(train, settings)
         write (text, '(es7.0)') stiffness(i)
         call tests%measured('k3 = '//trim(adjustl(text))//' N m/rad', 'the rigid shaft (they differ by the order of 1/k3)', &
                             maxval(abs(motion%rms/expected%rms - 1)), allowed(i))
      end do
      settings%stability = .true.
      expected = solution(rigid, settings)
      train%shafts(2)%stiffness = 1e10_dp
      motion = solution(train, settings)
      call tests%measured('k3 = 1e10 N m/rad, largest multiplier', 'the rigid shaft', &
                          abs(abs(motion%multipliers(1)) - abs(expected%multipliers(1))), 1e-3_dp)
   end subroutine stiff_shaft

   !> Between the limits, where nothing but the other method is known.
   subroutine between(tests)
      class(tests_type), intent(inout) :: tests
      real(dp), parameter :: stiffness(*) = [1e2_dp, 1e4_dp, 1e6_dp], gap(*) = [1e-9_dp, 1e-7_dp, 1e-5_dp, 1e-3_dp]
      type(train_type) :: train
      character(12) :: text
      integer :: i

      do i = 1, size(stiffness)
         train = paper_train()
         train%shafts(2)%stiffness = stiffness(i)
         write (text, '(es7.0)') stiffness(i)
         call against_shooting(tests, train, 'k3 = '//trim(adjustl(text))//' N m/rad')
      end do
      do i = 1, size(gap)
         train = paper_train()
         train%meshes%half_backlash = gap(i)
         write (text, '(es7.0)') gap(i)
         call against_shooting(tests, train, 'half backlash '//trim(adjustl(text))//' m')
      end do
      train = paper_train()
      train%prime_mover_inertia = 1e-9_dp
      train%load_inertia = 1e-9_dp
      call against_shooting(tests, train, 'end inertias 1.E-09 kg m^2')
   end subroutine between

   subroutine against_shooting(tests, train, name)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      character(*), intent(in) :: name
      type(motion_type) :: motion, exact
      type(error_type), allocatable :: error
      type(response_settings_type) :: settings

      settings = settings_of(0.9_dp, 0.91_dp, 48)
      settings%stability = .false.
      motion = solution(train, settings)
      exact = motion
      call refine(train, exact, error)
      if (allocated(error)) exact%rms = 0
      call tests%measured(name, 'shooting at 0.9: rms at R = 48, relative', maxval(abs(motion%rms/exact%rms - 1)), 1e-6_dp)
   end subroutine against_shooting

   !> From nothing, where the shaft might as well not be there, to a wall.
   subroutine end_inertias(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(motion_type) :: motion, expected
      type(error_type), allocatable :: error
      type(response_settings_type) :: settings
      real(dp), parameter :: inertia(*) = [1e-6_dp, 1e-3_dp, 1.0_dp, 1e3_dp]
      character(12) :: text
      integer :: i

      settings = settings_of(0.9_dp, 0.91_dp, 24)
      settings%stability = .false.
      train = paper_train()
      train%shafts(1) = shaft_type(rigid=.true.)
      train%shafts(3) = shaft_type(rigid=.true.)
      train%prime_mover_inertia = 0
      train%load_inertia = 0
      expected = solution(train, settings)
      train = paper_train()
      train%prime_mover_inertia = 1e-12_dp
      train%load_inertia = 1e-12_dp
      motion = solution(train, settings)
      call tests%measured('end inertias 1e-12 kg m^2', 'no shaft and no inertia at the ends', &
                          maxval(abs(motion%rms/expected%rms - 1)), 1e-8_dp)
      do i = 1, size(inertia)
         train%prime_mover_inertia = inertia(i)
         train%load_inertia = inertia(i)
         motion = solution(train, settings)
         expected = motion
         call refine(train, expected, error)
         if (allocated(error)) expected%rms = 0
         write (text, '(es7.0)') inertia(i)
         call tests%measured('end inertias '//trim(adjustl(text))//' kg m^2', 'shooting at 0.9, rms at R = 24', &
                             maxval(abs(motion%rms - expected%rms)), 1e-5_dp)
      end do
   end subroutine end_inertias

end module hard_scales
