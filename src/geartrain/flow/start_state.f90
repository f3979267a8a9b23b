!> States at time 0: at rest under the mean load, at random, or of a motion given by its Fourier coefficients.
module geartrain_flow_start_state
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_balance_of_motion, only: setup_for_motion
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_random, only: begin_random, generator_type
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: sample
   use geartrain_network_receptance, only: linear_displacements
   use geartrain_network_system, only: system_type
   use geartrain_network_units, only: mesh_frequencies
   implicit none (type, external)
   private
   public :: random_state, resting_state, state_of, states_of

contains

   !> State at rest [1], (state), see geartrain_flow_flow: every mesh is on the flank that bears its mean load.
   pure function resting_state(system) result(state)
      type(system_type), intent(in) :: system
      real(dp) :: state(system%states)
      integer :: j

      state = 0
      do j = 1, system%meshes
         associate (n => system%mesh_element(j))
            if (n > system%coordinates) cycle
            state(n) = system%law(j)%rest(system%static_force(n))
         end associate
      end do
   end function resting_state

   !> State of a motion: `motion%state`, at time 0, where it is allocated; else from the coefficients.
   subroutine state_of(system, motion, state, begin)
      type(system_type), intent(in) :: system
      !> Motion with a state or with coefficients.
      type(motion_type), intent(in) :: motion
      !> The state [1], (state).
      real(dp), intent(out) :: state(:)
      !> The instant, where the coefficients tell it [rad of the fundamental]; absent: 0.
      real(dp), intent(in), optional :: begin
      real(dp) :: states(size(state), 1), first

      if (allocated(motion%state)) then
         state = motion%state
         return
      end if
      first = 0
      if (present(begin)) first = begin/motion%period
      call states_of(system, motion, states, first)
      state = states(:, 1)
   end subroutine state_of

   !> States of a motion at equidistant instants of its period, from its coefficients. The twists of shafts follow from the mesh
   !> forces.
   subroutine states_of(system, motion, states, begin)
      type(system_type), target, intent(in) :: system
      !> Motion with coefficients.
      type(motion_type), intent(in) :: motion
      !> States [1], (state, instant).
      real(dp), intent(out) :: states(:, :)
      !> The first instant [rad of the period]; absent: 0.
      real(dp), intent(in), optional :: begin
      type(balance_type) :: balance
      type(system_type), target, allocatable :: own
      type(system_type), pointer :: at_speed
      real(dp), allocatable :: u(:, :)
      complex(dp), allocatable :: amplitudes(:, :)
      complex(dp) :: now
      real(dp), allocatable :: own_coefficients(:)
      type(transform_type) :: transform
      real(dp) :: mean(system%elements)
      real(dp) :: first
      integer :: i, k

      first = 0
      if (present(begin)) first = modulo(begin, 2*pi)
      at_speed => system
      if (allocated(system%speed_loads)) then
         ! The balance takes the mean torques at the speed.
         own = system
         at_speed => own
      end if
      call setup_for_motion(balance, at_speed, motion)
      allocate (u(balance%block, balance%unknowns), source=0.0_dp)
      allocate (amplitudes(system%elements, size(balance%harmonic)))
      do i = 1, balance%unknowns
         u(1, i) = motion%coefficients(1, balance%mesh(i))
         do k = 1, size(balance%harmonic)
            associate (r => balance%harmonic(k))
               if (2*r < size(motion%coefficients, 1)) u(2*k:2*k + 1, i) = motion%coefficients(2*r:2*r + 1, balance%mesh(i))
            end associate
         end do
      end do
      call balance%evaluate(u, motion%frequency_ratio)
      do k = 1, size(balance%harmonic)
         amplitudes(system%cut%element, k) = cmplx(u(2*k, :), -u(2*k + 1, :), dp)
         call linear_displacements(system, motion%frequency_ratio, balance%harmonic(k), motion%period, &
                                   cmplx(balance%force(2*k, :), -balance%force(2*k + 1, :), dp), amplitudes(:, k))
      end do
      ! The twist of a shaft is relative to the twist at rest.
      do i = 1, system%elements
         mean(i) = at_speed%static_force(i) - merge(0.0_dp, system%static_force(i), system%element_mesh(i) > 0) &
                   + system%mean%linear_displacement(system%cut, i, balance%force(1, :), at_speed%static_force)
      end do
      mean(system%cut%element) = u(1, :)
      call transform%plan(size(states, 2))
      allocate (own_coefficients(1 + 2*size(balance%harmonic)))
      do i = 1, system%coordinates
         own_coefficients(1) = mean(i)
         do k = 1, size(balance%harmonic)
            now = amplitudes(i, k)*exp(cmplx(0, balance%harmonic(k)*first, dp))
            own_coefficients(2*k:2*k + 1) = [now%re, -now%im]
         end do
         if (i <= system%displacements) then
            call sample(own_coefficients, balance%harmonic, transform)
            states(i, :) = transform%sample
         end if
         call sample(own_coefficients, balance%harmonic, transform, derivative=.true.)
         states(system%displacements + i, :) = transform%sample*(motion%frequency_ratio/motion%period)
      end do
   end subroutine states_of

   !> A state with uniformly distributed mesh displacements, up to three times the larger of resting displacement and half backlash,
   !> and velocities, up to this amplitude times the frequency of the mesh vibrating alone. Shafts are untwisted.
   function random_state(system, seed, start) result(state)
      type(system_type), intent(in) :: system
      !> Seed of the random numbers; number of the start.
      integer, intent(in) :: seed, start
      real(dp), allocatable :: state(:)
      real(dp) :: reach, frequency(system%meshes)
      type(generator_type) :: generator
      integer :: j

      generator = begin_random(seed, start)
      allocate (state(system%states))
      state = resting_state(system)
      frequency = mesh_frequencies(system)
      do j = 1, system%meshes
         associate (n => system%mesh_element(j))
            ! The displacement of a mesh that closes a loop follows from the other meshes.
            if (n > system%coordinates) cycle
            reach = 3*max(abs(state(n)), system%half_backlash(j))
            state(n) = reach*(2*generator%uniform() - 1)
            state(system%displacements + n) = reach*frequency(j)*(2*generator%uniform() - 1)
         end associate
      end do
   end function random_state

end module geartrain_flow_start_state
