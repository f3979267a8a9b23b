!> Harmonic balance in mesh displacements: with phi the whole mesh force over k b_c, projected by Galerkin,
!>    S_j0 = phi_j0 - load_j,     S_jr = p_jr + sum over i = j-1, j, j+1 of H_ji(r Lambda/eta) phi_ir - a_jr(Lambda).
!> Identity plus compact: well conditioned for any number of harmonics. Equations (8) to (10) put right, shafts condensed.
module geartrain_motion_balance
   use geartrain_base_kinds, only: dp
   use geartrain_model_receptance, only: find_receptance, is_unknown, receptance_type, recover_meshes
   use geartrain_model_system, only: system_type
   use geartrain_motion_bordered, only: bordered_type
   use geartrain_motion_contact, only: contact_type
   implicit none (type, external)
   private
   public :: balance_type

   type :: balance_type
      type(system_type) :: system
      !> Sub-harmonic index; harmonics of Lambda/eta that are carried; coefficients of a mesh, 1 + 2*size(harmonic).
      integer :: eta = 1
      integer, allocatable :: harmonic(:)
      integer :: block = 1
      !> Highest harmonic asked for (harmonics 1..highest that the excitation reaches are carried).
      integer :: highest = 0
      !> Meshes that are unknowns, and which they are.
      integer :: unknowns = 0
      integer, allocatable :: mesh(:)
      logical, allocatable :: unknown(:)
      !> Contact of each unknown mesh at the last `evaluate`.
      type(contact_type), allocatable :: contact(:)
      !> Residual S and dS/dLambda, (block, unknowns).
      real(dp), allocatable :: residual(:, :), d_frequency(:, :)
      !> Mesh forces phi (block, unknowns) and their derivatives (block, block, unknowns).
      real(dp), allocatable :: force(:, :), tangent(:, :, :)
      !> Of the harmonics that are carried.
      type(receptance_type), allocatable :: receptance(:)
   contains
      procedure :: setup
      procedure :: evaluate
      procedure :: jacobian
      procedure :: full_coefficients
      procedure :: damping_of
      procedure, private :: mesh_force
   end type balance_type

contains

   !> Prepares the balance of `system` with `highest` harmonics of Lambda/eta; samples = 0: exact coefficients.
   subroutine setup(self, system, highest, eta, samples)
      class(balance_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: highest, eta, samples
      integer :: i, r, step

      self%system = system
      self%eta = eta
      self%highest = highest
      step = 1
      if (eta == 1) step = system%excitation_order
      self%harmonic = [(r, r=step, highest, step)]
      self%block = 1 + 2*size(self%harmonic)
      self%unknown = is_unknown(system)
      self%mesh = pack([(i, i=1, system%meshes)], self%unknown)
      self%unknowns = size(self%mesh)
      if (.not. allocated(self%contact)) allocate (self%contact(self%unknowns))
      do i = 1, self%unknowns
         associate (j => self%mesh(i))
            call self%contact(i)%setup(system%backlash(j), system%mesh_stiffness(j), eta, self%harmonic, 2*highest, samples)
         end associate
      end do
      if (allocated(self%residual)) deallocate (self%residual, self%d_frequency, self%force, self%tangent, self%receptance)
      allocate (self%residual(self%block, self%unknowns), self%d_frequency(self%block, self%unknowns), &
                self%force(self%block, self%unknowns), self%tangent(self%block, self%block, self%unknowns), &
                self%receptance(size(self%harmonic)))
   end subroutine setup

   !> Forces, residual and dS/dLambda at the coefficients u (block, unknowns), mean, cos, sin, ...
   subroutine evaluate(self, u, frequency)
      class(balance_type), intent(inout) :: self
      real(dp), intent(in) :: u(:, :), frequency
      integer :: i, k, r, neighbour
      complex(dp) :: s, ds, force, d_force

      do i = 1, self%unknowns
         call self%mesh_force(i, u(:, i), frequency)
         self%residual(1, i) = self%force(1, i) - self%system%load(self%system%mesh_element(self%mesh(i)))
         self%d_frequency(1, i) = 0
      end do
      do k = 1, size(self%harmonic)
         r = self%harmonic(k)
         call find_receptance(self%system, self%unknown, frequency, r, self%eta, self%receptance(k))
         associate (h => self%receptance(k)%h, dh => self%receptance(k)%dh)
            do i = 1, self%unknowns
               associate (j => self%mesh(i))
                  s = cmplx(u(2*k, i), -u(2*k + 1, i), dp) - self%receptance(k)%a(j)
                  ds = -self%receptance(k)%da(j)
                  do neighbour = max(1, i - 1), min(self%unknowns, i + 1)
                     force = cmplx(self%force(2*k, neighbour), -self%force(2*k + 1, neighbour), dp)
                     d_force = cmplx(0, self%damping_of(neighbour)*r/self%eta, dp) &
                               *cmplx(u(2*k, neighbour), -u(2*k + 1, neighbour), dp)
                     s = s + h(neighbour - i + 2, j)*force
                     ds = ds + dh(neighbour - i + 2, j)*force + h(neighbour - i + 2, j)*d_force
                  end do
                  self%residual(2*k, i) = s%re
                  self%residual(2*k + 1, i) = -s%im
                  self%d_frequency(2*k, i) = ds%re
                  self%d_frequency(2*k + 1, i) = -ds%im
               end associate
            end do
         end associate
      end do
   end subroutine evaluate

   !> Damping of unknown mesh i over its stiffness, gamma.
   pure real(dp) function damping_of(self, i)
      class(balance_type), intent(in) :: self
      integer, intent(in) :: i

      damping_of = self%system%damping(self%system%mesh_element(self%mesh(i)))
   end function damping_of

   !> phi and d phi/du of unknown mesh i: Toeplitz(w) p - b sigma + gamma p' by the spectra of its contact.
   subroutine mesh_force(self, i, u, frequency)
      class(balance_type), intent(inout) :: self
      integer, intent(in) :: i
      real(dp), intent(in) :: u(:), frequency
      complex(dp) :: difference, total
      real(dp) :: rate
      integer :: k, l, m

      call self%contact(i)%update(u)
      associate (w => self%contact(i)%stiffness, t => self%tangent(:, :, i), f => self%force(:, i), &
                 sigma => self%contact(i)%offset, b => self%contact(i)%backlash, r => self%harmonic)
         t(1, 1) = real(w(0), dp)
         do k = 1, size(r)
            t(1, 2*k) = real(w(r(k)), dp)
            t(1, 2*k + 1) = -aimag(w(r(k)))
            t(2*k, 1) = 2*t(1, 2*k)
            t(2*k + 1, 1) = 2*t(1, 2*k + 1)
         end do
         do l = 1, size(r)
            do m = 1, size(r)
               difference = w(abs(r(m) - r(l)))
               if (r(m) < r(l)) difference = conjg(difference)
               total = w(r(m) + r(l))
               t(2*m, 2*l) = difference%re + total%re
               t(2*m + 1, 2*l) = -difference%im - total%im
               t(2*m, 2*l + 1) = difference%im - total%im
               t(2*m + 1, 2*l + 1) = difference%re - total%re
            end do
         end do
         f = matmul(t, u)
         f(1) = f(1) - b*real(sigma(0), dp)
         do k = 1, size(r)
            f(2*k) = f(2*k) - 2*b*real(sigma(r(k)), dp)
            f(2*k + 1) = f(2*k + 1) + 2*b*aimag(sigma(r(k)))
            rate = self%damping_of(i)*r(k)*frequency/self%eta
            f(2*k) = f(2*k) + rate*u(2*k + 1)
            f(2*k + 1) = f(2*k + 1) - rate*u(2*k)
            t(2*k, 2*k + 1) = t(2*k, 2*k + 1) + rate
            t(2*k + 1, 2*k) = t(2*k + 1, 2*k) - rate
         end do
      end associate
   end subroutine mesh_force

   !> dS/du at the last `evaluate`, and dS/dLambda as the border column.
   subroutine jacobian(self, matrix)
      class(balance_type), intent(in) :: self
      type(bordered_type), intent(inout) :: matrix
      integer :: i, l

      call matrix%resize(self%block, self%unknowns)
      do i = 1, self%unknowns
         call fill(matrix%diagonal(:, :, i), i, 2, self%tangent(:, :, i))
         matrix%diagonal(1, :, i) = self%tangent(1, :, i)
         do l = 2, self%block
            matrix%diagonal(l, l, i) = matrix%diagonal(l, l, i) + 1
         end do
         if (i > 1) call fill(matrix%lower(:, :, i), i, 1, self%tangent(:, :, i - 1))
         if (i < self%unknowns) call fill(matrix%upper(:, :, i), i, 3, self%tangent(:, :, i + 1))
      end do
      matrix%column = self%d_frequency

   contains

      !> Rows of harmonic k: the complex receptance times the rows of the force's derivative.
      pure subroutine fill(a, i, neighbour, t)
         real(dp), intent(inout) :: a(:, :)
         integer, intent(in) :: i, neighbour
         real(dp), intent(in) :: t(:, :)
         complex(dp) :: h(size(self%harmonic))
         integer :: k, column

         do k = 1, size(h)
            h(k) = self%receptance(k)%h(neighbour, self%mesh(i))
         end do
         do column = 1, size(t, 2)
            a(1, column) = 0
            do k = 1, size(h)
               a(2*k, column) = h(k)%re*t(2*k, column) + h(k)%im*t(2*k + 1, column)
               a(2*k + 1, column) = h(k)%re*t(2*k + 1, column) - h(k)%im*t(2*k, column)
            end do
         end do
      end subroutine fill

   end subroutine jacobian

   !> Coefficients of every mesh at harmonics 1..highest, (1 + 2*highest, mesh), and the mesh forces alike, from those of the
   !> unknown meshes at the last `evaluate`.
   pure subroutine full_coefficients(self, u, frequency, coefficients, forces)
      class(balance_type), intent(in) :: self
      real(dp), intent(in) :: u(:, :), frequency
      real(dp), intent(out) :: coefficients(:, :)
      real(dp), intent(out), optional :: forces(:, :)
      complex(dp) :: phi(self%system%meshes), p(self%system%meshes)
      type(receptance_type) :: local
      integer :: i, k, r

      coefficients = 0
      coefficients(1, :) = self%system%load(self%system%mesh_element)
      if (present(forces)) forces = coefficients
      do i = 1, self%unknowns
         coefficients(1, self%mesh(i)) = u(1, i)
      end do
      do k = 1, size(self%harmonic)
         r = self%harmonic(k)
         do i = 1, self%unknowns
            phi(self%mesh(i)) = cmplx(self%force(2*k, i), -self%force(2*k + 1, i), dp)
            p(self%mesh(i)) = cmplx(u(2*k, i), -u(2*k + 1, i), dp)
         end do
         if (self%unknowns < self%system%meshes) then
            call find_receptance(self%system, self%unknown, frequency, r, self%eta, local)
            call recover_meshes(self%system, self%unknown, frequency*r/self%eta, local, phi, p)
         end if
         coefficients(2*r, :) = real(p, dp)
         coefficients(2*r + 1, :) = -aimag(p)
         if (present(forces)) then
            forces(2*r, :) = real(phi, dp)
            forces(2*r + 1, :) = -aimag(phi)
         end if
      end do
   end subroutine full_coefficients

end module geartrain_motion_balance
