!> Verdicts of large trains without a flight: the slow multipliers are those of the monodromy matrix, and no motion is taken for
!> stable that is not.
module unit_slow_multipliers
   use geartrain, only: dp, train_type
   use geartrain_base_kinds, only: pi
   use geartrain_base_numbers, only: integer_text
   use geartrain_floquet_monodromy, only: monodromy_type
   use geartrain_floquet_motion_contacts, only: motion_contacts_type
   use geartrain_floquet_slow_multipliers, only: slow_multipliers_type
   use geartrain_network_lowest_modes, only: lowest_modes_type
   use geartrain_network_system, only: build_system, system_type
   use geartrain_network_system_spectrum, only: eigenvalues_of
   use testing, only: full, tests_type
   use unit_scale, only: chain, equal_branches, joined
   implicit none (type, external)
   private
   public :: slow_multipliers_tests

contains

   subroutine slow_multipliers_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('lowest_modes')) then
         call lowest_modes(tests, chain(60), 'a chain')
         call lowest_modes(tests, equal_branches(10, 5), '10 equal branches')
         call lowest_modes(tests, joined(equal_branches(2, 30), 30), 'a loop')
      end if
      if (tests%runs('slow_multipliers')) then
         call slow_multipliers(tests, varied(chain(60), 0.02_dp, .false.), 'a chain')
         call slow_multipliers(tests, varied(chain(60), 0.02_dp, .true.), 'a chain, phases and harmonics')
         call slow_multipliers(tests, varied(equal_branches(3, 24), 0.02_dp, .true.), 'equal branches')
         call slow_multipliers(tests, varied(joined(equal_branches(2, 30), 30), 0.02_dp, .true.), 'a loop')
         call slow_multipliers(tests, ordered(varied(chain(60), 0.01_dp, .true.)), 'orders 2 and 3')
      end if
      if (tests%runs('never_wrong', full)) call never_wrong(tests)
   end subroutine slow_multipliers_tests

   !> The lowest modes are those that LAPACK finds.
   subroutine lowest_modes(tests, train, name)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      character(*), intent(in) :: name
      integer, parameter :: number = 20
      type(system_type) :: system
      type(lowest_modes_type) :: modes
      real(dp), allocatable :: values(:)
      real(dp) :: overlap
      integer :: i, info, j
      logical :: success

      call build_system(train, system)
      allocate (values(system%displacements))
      call eigenvalues_of(system, system%spring, values, info)
      call modes%begin(system, system%spring)
      call modes%find(system, number, success)
      call tests%is_true(success, name//': found')
      if (.not. success) return
      call tests%is_close(maxval(abs(modes%frequency/sqrt(values(:number)) - 1)), 0.0_dp, 1e-7_dp, name//': frequencies')
      ! Elastic energies: orthogonal, as the modes are.
      do i = 1, number
         do j = 1, i
            overlap = sum(system%stiffness*modes%shape(:, i)*modes%shape(:, j))/system%characteristic_frequency**2
            if (i == j) overlap = overlap - values(i)
            if (abs(overlap) > 1e-5_dp*sqrt(values(i)*values(j))) call tests%is_true(.false., name//': shapes')
         end do
      end do
   end subroutine lowest_modes

   !> Largest multiplier by slow modes and by the whole matrix at several Lambda.
   subroutine slow_multipliers(tests, train, name)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      character(*), intent(in) :: name
      real(dp), parameter :: speeds(*) = [0.9_dp, 1.2_dp, 2.5_dp]
      type(system_type), target :: system
      type(slow_multipliers_type) :: slow
      real(dp) :: rate, exact
      integer :: i
      logical :: success

      call build_system(train, system)
      call begin(slow, system)
      do i = 1, size(speeds)
         call rate_of(slow, system, speeds(i), rate, success)
         call tests%is_true(success, name//': decided at speed '//integer_text(i))
         if (.not. success) cycle
         exact = exact_rate(system, speeds(i))
         call tests%is_close(rate/exact, 1.0_dp, 2e-3_dp, name//': growth rate at speed '//integer_text(i))
      end do
   end subroutine slow_multipliers

   !> Variations from weak to strong at principal and combination resonances: what is decided is stable.
   subroutine never_wrong(tests)
      class(tests_type), intent(inout) :: tests
      real(dp), parameter :: variation(*) = [0.01_dp, 0.02_dp, 0.04_dp, 0.08_dp, 0.2_dp, 0.4_dp]
      type(system_type), target :: system
      type(lowest_modes_type) :: modes
      type(slow_multipliers_type) :: slow
      real(dp) :: exact, rate, speed
      integer :: decided, i, k, unstable
      logical :: success

      decided = 0
      unstable = 0
      do i = 1, size(variation)
         call build(system)
         call modes%begin(system, system%spring)
         call modes%find(system, 40, success)
         do k = 1, 12
            speed = modes%frequency(3*k) + modes%frequency(merge(3*k, 40 - 3*k, mod(k, 2) == 0))
            call rate_of(slow, system, speed, rate, success)
            exact = exact_rate(system, speed)
            if (exact > 0) unstable = unstable + 1
            if (.not. success) cycle
            decided = decided + 1
            call tests%is_true(exact < 0 .and. abs(rate - exact) < 0.02_dp*abs(exact), 'variation '//integer_text(i)// &
                               ', resonance '//integer_text(k))
         end do
      end do
      call tests%is_true(decided > 15 .and. unstable > 15, 'many are decided, and many are unstable')

   contains

      !> The next train; allocated components begin anew.
      subroutine build(system)
         type(system_type), intent(out), target :: system
         type(slow_multipliers_type) :: fresh

         call build_system(varied(chain(50), variation(i), mod(i, 2) == 0), system)
         slow = fresh
         call begin(slow, system)
      end subroutine build
   end subroutine never_wrong

   subroutine begin(slow, system)
      type(slow_multipliers_type), intent(inout) :: slow
      type(system_type), target, intent(in) :: system
      type(system_type), pointer :: train

      train => system
      call slow%setup(train)
   end subroutine begin

   !> Growth rate by the slow modes [1].
   subroutine rate_of(slow, system, frequency_ratio, rate, success)
      type(slow_multipliers_type), intent(inout) :: slow
      type(system_type), intent(in) :: system
      real(dp), intent(in) :: frequency_ratio
      real(dp), intent(out) :: rate
      logical, intent(out) :: success
      complex(dp) :: values(16)
      integer :: contact(system%meshes)

      contact = 1
      associate (period => 2*pi/(frequency_ratio*system%excitation_order))
         call slow%find(contact, frequency_ratio, period, values, success)
         rate = 0
         if (success) rate = log(abs(values(1)))/period
      end associate
   end subroutine rate_of

   !> Growth rate by the multipliers of all states, every mesh in contact [1].
   real(dp) function exact_rate(system, frequency_ratio)
      type(system_type), target, intent(in) :: system
      real(dp), intent(in) :: frequency_ratio
      type(system_type), pointer :: train
      type(motion_contacts_type) :: motion
      type(monodromy_type) :: whole
      complex(dp), allocatable :: multipliers(:)

      train => system
      motion%system => train
      motion%repeats = system%excitation_order
      allocate (motion%mesh(0), motion%contact(0))
      call whole%setup(train, all_of_them=.true.)
      call whole%integrate(motion, frequency_ratio)
      allocate (multipliers(whole%given))
      call whole%multipliers(multipliers)
      exact_rate = log(abs(multipliers(1)))*frequency_ratio*system%excitation_order/(2*pi)
   end function exact_rate

   !> The train with another variation of all stiffnesses: all in phase, or phases and two harmonics that differ.
   function varied(given, variation, spread_out) result(train)
      type(train_type), intent(in) :: given
      real(dp), intent(in) :: variation
      logical, intent(in) :: spread_out
      type(train_type) :: train
      integer :: j

      train = given
      do j = 1, size(train%meshes)
         associate (mesh => train%meshes(j), phase => merge(real(j*j, dp), 0.0_dp, spread_out))
            mesh%stiffness_cos = [variation*cos(phase)]
            mesh%stiffness_sin = [variation*sin(phase)]
            if (.not. spread_out) cycle
            mesh%stiffness_cos = [mesh%stiffness_cos, variation/4]
         end associate
      end do
   end function varied

   !> The train with meshes of orders 2 and 3.
   function ordered(given) result(train)
      type(train_type), intent(in) :: given
      type(train_type) :: train
      integer :: j

      train = given
      train%meshes%order = [(2 + mod(j, 2), j=1, size(train%meshes))]
   end function ordered

end module unit_slow_multipliers
