!> Motions that never repeat: no period is found, and the Lyapunov exponent tells why.
module hard_motions
   use fixtures, only: single_pair
   use geartrain, only: dp, error_type, integrate, integration_settings_type, motion_type, train_type
   use geartrain_base_kinds, only: pi
   use geartrain_floquet_multipliers, only: eigenvalues
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_lyapunov, only: largest_exponent
   use geartrain_flow_orbit, only: propagate
   use geartrain_network_system, only: build_system, system_type
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: motions_cases

contains

   subroutine motions_cases(tests)
      class(tests_type), intent(inout) :: tests

      call tests%heading('Chaos and quasi-periodic motion')
      if (tests%runs('known_exponents')) call known_exponents(tests)
      if (tests%runs('quasi_periodic')) call quasi_periodic(tests)
      if (tests%runs('chaos')) call chaos(tests)
   end subroutine motions_cases

   !> Of a linear train the exponent is log |multiplier|/T, whatever the motion.
   subroutine known_exponents(tests)
      class(tests_type), intent(inout) :: tests
      real(dp), parameter :: frequency_ratio(*) = [2.0_dp, 2.4_dp], kappa(*) = [0.6_dp, 0.3_dp], allowed(*) = [1e-9_dp, 1e-3_dp]
      type(train_type) :: train
      type(system_type) :: system
      real(dp) :: final(2), monodromy(2, 2), state(2), uncertain
      real(dp), allocatable :: exponent
      complex(dp) :: multipliers(2)
      integer :: i

      do i = 1, size(frequency_ratio)
         train = single_pair(0.05_dp, kappa(i), 1.0_dp)
         train%meshes%half_backlash = 0
         call build_system(train, system)
         state = [1.0_dp, 0.0_dp]
         call propagate(system, frequency_ratio(i), 1, state, final, monodromy)
         call eigenvalues(monodromy, multipliers)
         call largest_exponent(system, frequency_ratio(i), state, 300, exponent, uncertain)
         if (.not. allocated(exponent)) allocate (exponent, source=huge(1.0_dp))
         call tests%measured('Lyapunov exponent, '//trim(merge('unstable linear train        ', &
                                                               'stable linear train, pair +-i', i == 1)), &
                             'log of the largest multiplier over the period', &
                             abs(exponent - log(abs(multipliers(1)))*frequency_ratio(i)/(2*pi)), allowed(i))
      end do
   end subroutine known_exponents

   !> Without damping the free vibration goes on beside the forced one: two frequencies without a common period.
   subroutine quasi_periodic(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(motion_type) :: motion
      type(integration_settings_type) :: settings
      type(error_type), allocatable :: error

      train = single_pair(0.0_dp, 0.3_dp, 1.0_dp)
      settings%max_periods = 1000
      call integrate(train, 3.3_dp, settings, motion, error)
      call tests%holds('two frequencies, no damping', 'no period found', motion%period == 0)
      if (.not. allocated(motion%lyapunov_exponent)) allocate (motion%lyapunov_exponent, source=huge(1.0_dp))
      call tests%measured('the same', 'largest Lyapunov exponent 0', abs(motion%lyapunov_exponent), 3e-3_dp)
   end subroutine quasi_periodic

   !> A pair with kappa = 0.6 at 1.9, between its period doublings: chaos, by the growth of the distance of two motions as well.
   subroutine chaos(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(motion_type) :: motion
      type(integration_settings_type) :: settings
      type(error_type), allocatable :: error
      type(system_type) :: system
      real(dp), allocatable :: longer
      real(dp) :: pairwise, uncertain
      integer :: periods

      train = single_pair(0.05_dp, 0.6_dp, 1.0_dp)
      settings%max_periods = 1000
      call integrate(train, 1.9_dp, settings, motion, error)
      call tests%holds('chaos', 'no period found', motion%period == 0)
      if (.not. allocated(motion%lyapunov_exponent)) allocate (motion%lyapunov_exponent, source=0.0_dp)
      call tests%holds('the same', 'positive Lyapunov exponent', motion%lyapunov_exponent > 0.01_dp)
      call build_system(train, system)
      periods = 20000
      call largest_exponent(system, 1.9_dp, motion%state, periods, longer, uncertain)
      call tests%measured('the same', 'the exponent over twenty times as long', abs(motion%lyapunov_exponent - longer), 1e-2_dp)
      pairwise = growth_of_distance(system, 1.9_dp, motion%state, periods)
      call tests%measured('the same', 'growth of the distance of two motions, brought back to 1e-8 each period', &
                          abs(pairwise - longer), 1e-2_dp)
   end subroutine chaos

   !> The exponent without tangents: two motions 1e-8 apart, the second brought back to that distance after each period.
   real(dp) function growth_of_distance(system, frequency_ratio, start, periods) result(growth)
      type(system_type), target, intent(in) :: system
      real(dp), intent(in) :: frequency_ratio, start(:)
      integer, intent(in) :: periods
      real(dp), parameter :: apart = 1e-8_dp
      type(flow_type) :: flow
      real(dp) :: one(size(start)), other(size(start)), distance
      integer :: k

      call flow%setup(system, 1, 20, 1e-15_dp)
      one = start
      other = start + apart/sqrt(real(size(start), dp))
      growth = 0
      do k = 1, periods
         call carry(one)
         call carry(other)
         distance = norm2(other - one)
         if (k > periods/5) growth = growth + log(distance/apart)
         other = one + (other - one)*(apart/distance)
      end do
      growth = growth/((periods - periods/5)*2*pi/frequency_ratio)

   contains

      subroutine carry(state)
         real(dp), intent(inout) :: state(:)

         flow%x(1, :) = state
         call flow%start(frequency_ratio, 0.0_dp)
         call flow%advance(2*pi/frequency_ratio)
         state = flow%x(1, :)
      end subroutine carry

   end function growth_of_distance

end module hard_motions
