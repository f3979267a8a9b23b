!> States at time 0: at rest under the mean load, or of a motion given by its Fourier coefficients.
module geartrain_motion_start_state
   use geartrain_base_kinds, only: dp, pi
   use geartrain_model_system, only: system_type
   use geartrain_motion_balance, only: balance_type
   use geartrain_motion_motion, only: motion_type
   implicit none (type, external)
   private
   public :: resting_state, state_of, states_of

contains

   !> At rest, every mesh in contact under its mean load (see geartrain_motion_flow for what a state is), (2*elements).
   pure function resting_state(system) result(state)
      type(system_type), intent(in) :: system
      real(dp) :: state(2*system%elements)
      integer :: j

      state = 0
      do j = 1, system%meshes
         associate (n => system%mesh_element(j))
            state(n) = system%load(n) + sign(system%backlash(j), system%load(n))
         end associate
      end do
   end function resting_state

   !> State at time 0 of a motion: its own where integration gave one, else from its coefficients.
   subroutine state_of(system, motion, state)
      type(system_type), intent(in) :: system
      type(motion_type), intent(in) :: motion
      real(dp), intent(out) :: state(:)
      real(dp) :: states(size(state), 1)

      if (allocated(motion%state)) then
         state = motion%state
         return
      end if
      call states_of(system, motion, states)
      state = states(:, 1)
   end subroutine state_of

   !> States of a motion at equidistant instants of its period from time 0 on, (2*elements, instant), from its coefficients, with
   !> the shafts' twists recovered from the mesh forces.
   subroutine states_of(system, motion, states)
      type(system_type), intent(in) :: system
      type(motion_type), intent(in) :: motion
      real(dp), intent(out) :: states(:, :)
      type(balance_type) :: balance
      real(dp), allocatable :: u(:, :), coefficients(:, :), forces(:, :)
      integer :: highest, i, k

      highest = (size(motion%coefficients, 1) - 1)/2
      call balance%setup(system, highest, motion%period, 0)
      allocate (u(balance%block, balance%unknowns), coefficients(1 + 2*highest, system%meshes), &
                forces(1 + 2*highest, system%meshes))
      do i = 1, balance%unknowns
         u(1, i) = motion%coefficients(1, balance%mesh(i))
         do k = 1, size(balance%harmonic)
            associate (r => balance%harmonic(k))
               u(2*k:2*k + 1, i) = motion%coefficients(2*r:2*r + 1, balance%mesh(i))
            end associate
         end do
      end do
      call balance%evaluate(u, motion%frequency)
      call balance%full_coefficients(u, motion%frequency, coefficients, forces)
      do i = 1, size(states, 2)
         call sum_harmonics(system, motion%frequency/motion%period, motion%period, 2*pi*(i - 1)/size(states, 2), coefficients, &
                            forces, states(:, i))
      end do
   end subroutine states_of

   pure subroutine sum_harmonics(system, rate, eta, phase, coefficients, forces, state)
      type(system_type), intent(in) :: system
      !> Lambda/eta [1]; of the period [rad].
      real(dp), intent(in) :: rate, phase, coefficients(:, :), forces(:, :)
      integer, intent(in) :: eta
      real(dp), intent(out) :: state(:)
      complex(dp) :: p, left, right, turn((size(coefficients, 1) - 1)/2)
      integer :: j, n, r, e

      e = system%elements
      turn = 1
      if (phase > 0) turn = [(exp(cmplx(0, r*phase, dp)), r=1, size(turn))]
      state = 0
      do j = 1, system%meshes
         n = system%mesh_element(j)
         state(n) = coefficients(1, j)
         do r = 1, (size(coefficients, 1) - 1)/2
            p = turn(r)*cmplx(coefficients(2*r, j), -coefficients(2*r + 1, j), dp)
            state(n) = state(n) + p%re
            state(e + n) = state(e + n) - r*rate*p%im
         end do
      end do
      do j = 1, size(system%bodies)
         n = system%body_element(j)
         if (n == 0) cycle
         do r = 1, (size(coefficients, 1) - 1)/2
            left = 0
            right = 0
            if (j > 1) left = system%right_radius(n - 1)*mesh_force(j - 1)
            if (j == 1 .and. mod(r, eta) == 0 .and. r/eta <= size(system%torque%amplitude)) &
               left = system%torque%amplitude(r/eta)
            if (j <= system%meshes) right = -system%left_radius(n + 1)*mesh_force(j)
            p = turn(r)*system%left_radius(n)*system%bodies(j)%twist(r*rate*system%characteristic_frequency, left, right)
            state(n) = state(n) + p%re
            state(e + n) = state(e + n) - r*rate*p%im
         end do
      end do

   contains

      !> Force of a mesh at harmonic r over characteristic length [N/m].
      pure complex(dp) function mesh_force(mesh)
         integer, intent(in) :: mesh

         mesh_force = system%stiffness(system%mesh_element(mesh))*cmplx(forces(2*r, mesh), -forces(2*r + 1, mesh), dp)
      end function mesh_force

   end subroutine sum_harmonics

end module geartrain_motion_start_state
