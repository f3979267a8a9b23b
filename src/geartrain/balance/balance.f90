!> Harmonic balance in mesh displacements: with phi the whole mesh force over k b_c, projected by Galerkin,
!>    S_j0 = phi_j0 - load_j,     S_jr = p_jr + sum over i of H_ji(r Lambda/eta) phi_ir - a_jr(Lambda).
!> Identity plus compact: well conditioned for any number of harmonics. Equations (8) to (10) put right, shafts condensed.
module geartrain_balance_balance
   use geartrain_balance_needed_harmonics, only: needed_harmonics
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_bordered, only: bordered_type
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: fine_samples, transform_length
   use geartrain_mesh_law_contact, only: contact_type
   use geartrain_model_excitation, only: excited_harmonics
   use geartrain_model_receptance, only: find_receptance, linear_displacements, receptance_type
   use geartrain_model_system, only: system_type
   use geartrain_motion_products, only: add_coefficients, find_wave, toeplitz, wave_product
   implicit none (type, external)
   private
   public :: balance_type

   !> Up to so many harmonics the derivatives of the mesh forces are matrices; beyond, those of the lowest ones are, and the whole
   !> is applied by FFT.
   integer, parameter :: most_direct = 16, explicit_of_many = 10

   type :: balance_type
      type(system_type) :: system
      !> Sub-harmonic index; harmonics of Lambda/eta that are carried; coefficients of a mesh, 1 + 2*size(harmonic).
      integer :: eta = 1
      integer, allocatable :: harmonic(:)
      integer :: block = 1
      !> Those that are not, up to three times the highest, in which the error shows.
      integer, allocatable :: missing(:)
      !> Harmonics of Lambda/eta that excite the train and are higher than all that are carried.
      integer, allocatable :: left_out(:)
      !> Highest harmonic asked for (harmonics 1..highest that the excitation reaches are carried).
      integer :: highest = 0
      !> Of a period, where the coefficients are sampled; 0: they are exact.
      integer :: samples = 0
      !> Meshes that are unknowns, and which they are.
      integer :: unknowns = 0
      integer, allocatable :: mesh(:)
      !> Contact of each unknown mesh at the last `evaluate`.
      type(contact_type), allocatable :: contact(:)
      !> Residual S and dS/dLambda, (block, unknowns).
      real(dp), allocatable :: residual(:, :), d_frequency(:, :)
      !> Mesh forces phi (block, unknowns) and their derivatives (1 + 2*explicit, 1 + 2*explicit, unknowns) at the mean and the
      !> lowest `explicit` of the harmonics that are carried: all of them, where they are few.
      real(dp), allocatable :: force(:, :), tangent(:, :, :)
      !> d phi/dLambda at constant coefficients, (block, unknowns).
      real(dp), allocatable, private :: force_rate(:, :)
      integer :: explicit = 0
      !> Of the harmonics that are carried.
      type(receptance_type), allocatable :: receptance(:)
      !> Lambda at the last `evaluate`.
      real(dp), private :: frequency_ratio = 0
      !> Plan of the meshes' waveforms; where not all harmonics are explicit, that of products, and stiffness in contact (sample,
      !> unknowns), with damping where that changes with the contact.
      type(transform_type), private :: fine, products
      real(dp), allocatable, private :: wave(:, :), damping_wave(:, :)
   contains
      procedure :: setup
      procedure :: evaluate
      procedure :: jacobian
      procedure :: is_direct
      procedure :: make_explicit
      procedure :: apply
      procedure :: full_coefficients
      procedure :: damping_of
      procedure :: mean_stiffness
      procedure :: mean_matrix
      procedure, private :: mesh_force
      procedure, private :: damp_tangent
      procedure, private :: rate_of
      procedure :: mean_product
   end type balance_type

contains

   !> Prepares the balance of `system` with `highest` harmonics of Lambda/eta; samples = 0: exact coefficients.
   subroutine setup(self, system, highest, eta, samples)
      class(balance_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: highest, eta, samples
      integer :: i, r

      self%system = system
      self%eta = eta
      self%highest = highest
      self%samples = samples
      self%harmonic = [(r, r=1, highest)]
      if (eta == 1) self%harmonic = needed_harmonics(system, highest)
      self%missing = pack([(r, r=1, 3*highest)], [(.not. any(self%harmonic == r), r=1, 3*highest)])
      if (eta == 1) self%missing = pack(self%missing, mod(self%missing, system%excitation_order) == 0)
      self%left_out = eta*excited_harmonics(system)
      self%left_out = pack(self%left_out, self%left_out > highest)
      self%block = 1 + 2*size(self%harmonic)
      self%mesh = system%cut%mesh
      self%unknowns = size(self%mesh)
      if (.not. allocated(self%contact)) allocate (self%contact(self%unknowns))
      do i = 1, self%unknowns
         associate (j => self%mesh(i))
            call self%contact(i)%setup(system%law(j), eta, self%harmonic, 2*highest, samples)
         end associate
      end do
      call self%fine%plan(fine_samples(maxval([1, self%harmonic])))
      if (allocated(self%residual)) deallocate (self%residual, self%d_frequency, self%force, self%force_rate, self%receptance, &
                                                self%wave, self%damping_wave, self%tangent)
      allocate (self%residual(self%block, self%unknowns), self%receptance(size(self%harmonic)))
      allocate (self%d_frequency, self%force, self%force_rate, mold=self%residual)
      self%explicit = size(self%harmonic)
      if (self%explicit > most_direct) self%explicit = explicit_of_many
      ! No alias of a product with spectra up to twice the highest harmonic reaches a harmonic that is carried.
      if (.not. self%is_direct()) call self%products%plan(transform_length(4*self%harmonic(size(self%harmonic)) + 1))
      allocate (self%wave(merge(0, self%products%samples, self%is_direct()), self%unknowns))
      allocate (self%damping_wave(merge(size(self%wave, 1), 0, any(system%law(self%mesh)%jumps)), self%unknowns))
      allocate (self%tangent(1 + 2*self%explicit, 1 + 2*self%explicit, self%unknowns))
   end subroutine setup

   !> Forces, residual and dS/dLambda at the coefficients u (block, unknowns), mean, cos, sin, ...
   subroutine evaluate(self, u, frequency_ratio)
      class(balance_type), intent(inout) :: self
      real(dp), intent(in) :: u(:, :), frequency_ratio
      complex(dp) :: s, ds, force, d_force
      integer :: i, k, r, n

      self%frequency_ratio = frequency_ratio
      do i = 1, self%unknowns
         call self%mesh_force(i, u(:, i))
      end do
      call self%mean_product(self%force(1, :), u(1, :), self%residual(1, :))
      self%residual(1, :) = self%residual(1, :) - self%system%mean%static_force
      self%d_frequency(1, :) = 0
      do k = 1, size(self%harmonic)
         r = self%harmonic(k)
         call find_receptance(self%system, frequency_ratio, r, self%eta, self%receptance(k))
         associate (h => self%receptance(k)%h, dh => self%receptance(k)%dh, graph => self%system%cut%graph)
            do i = 1, self%unknowns
               s = cmplx(u(2*k, i), -u(2*k + 1, i), dp) - self%receptance(k)%a(i)
               ds = -self%receptance(k)%da(i)
               do n = graph%row(i), graph%row(i + 1) - 1
                  associate (j => graph%column(n), entry => graph%entry(n))
                     force = cmplx(self%force(2*k, j), -self%force(2*k + 1, j), dp)
                     d_force = cmplx(self%force_rate(2*k, j), -self%force_rate(2*k + 1, j), dp)
                     s = s + h(entry)*force
                     ds = ds + dh(entry)*force + h(entry)*d_force
                  end associate
               end do
               self%residual(2*k, i) = s%re
               self%residual(2*k + 1, i) = -s%im
               self%d_frequency(2*k, i) = ds%re
               self%d_frequency(2*k + 1, i) = -ds%im
            end do
         end associate
      end do
   end subroutine evaluate

   !> The rows of the mean, of mean forces and displacements, (unknown).
   pure subroutine mean_product(self, force, displacement, product)
      class(balance_type), intent(in) :: self
      real(dp), intent(in) :: force(:), displacement(:)
      real(dp), intent(out) :: product(:)
      integer :: i, n

      product = force
      if (size(self%system%mean%closing) == 0) return
      associate (graph => self%system%cut%graph, mean => self%system%mean)
         do i = 1, self%unknowns
            product(i) = 0
            do n = graph%row(i), graph%row(i + 1) - 1
               associate (j => graph%column(n), entry => graph%entry(n))
                  product(i) = product(i) + mean%force(entry)*force(j) + mean%displacement(entry)*displacement(j)
               end associate
            end do
         end do
      end associate
   end subroutine mean_product

   !> Mean damping of unknown mesh i over its stiffness at the last `evaluate`.
   pure real(dp) function damping_of(self, i)
      class(balance_type), intent(in) :: self
      integer, intent(in) :: i

      damping_of = self%contact(i)%spectra%mean_damping(self%contact(i)%law)
   end function damping_of

   !> Mean stiffness of unknown mesh i in contact at the last `evaluate`, with its damping at a harmonic, over its stiffness.
   pure complex(dp) function mean_stiffness(self, i, harmonic)
      class(balance_type), intent(in) :: self
      integer, intent(in) :: i, harmonic

      mean_stiffness = cmplx(real(self%contact(i)%spectra%stiffness(0), dp), &
                             self%damping_of(i)*harmonic*self%frequency_ratio/self%eta, dp)
   end function mean_stiffness

   !> Derivative of the residual at one harmonic by itself, the meshes with their mean stiffness, (entries of the cut's graph).
   pure subroutine mean_matrix(self, harmonic, receptance, matrix)
      class(balance_type), intent(in) :: self
      integer, intent(in) :: harmonic
      !> At `harmonic`.
      type(receptance_type), intent(in) :: receptance
      complex(dp), intent(out) :: matrix(:)
      integer :: n

      matrix = merge(1, 0, [(n <= self%unknowns, n=1, size(matrix))])
      associate (entry => self%system%cut%graph%entry, column => self%system%cut%graph%column)
         do n = 1, size(entry)
            matrix(entry(n)) = matrix(entry(n)) + receptance%h(entry(n))*self%mean_stiffness(column(n), harmonic)
         end do
      end associate
   end subroutine mean_matrix

   !> Whether the derivatives of the forces are matrices for all harmonics.
   pure logical function is_direct(self)
      class(balance_type), intent(in) :: self

      is_direct = self%explicit == size(self%harmonic)
   end function is_direct

   !> Makes the derivatives matrices for more harmonics, at the last `evaluate`.
   subroutine make_explicit(self, harmonics)
      class(balance_type), intent(inout) :: self
      integer, intent(in) :: harmonics
      integer :: i

      self%explicit = min(harmonics, size(self%harmonic))
      deallocate (self%tangent)
      allocate (self%tangent(1 + 2*self%explicit, 1 + 2*self%explicit, self%unknowns))
      do i = 1, self%unknowns
         call toeplitz(self%harmonic(:self%explicit), self%contact(i)%spectra%stiffness, self%tangent(:, :, i))
         call self%damp_tangent(i)
      end do
   end subroutine make_explicit

   !> phi of unknown mesh i by the spectra of its contact, and its derivatives (geartrain_mesh_law_spectra).
   subroutine mesh_force(self, i, u)
      class(balance_type), intent(inout) :: self
      integer, intent(in) :: i
      real(dp), intent(in) :: u(:)
      integer :: k

      call self%contact(i)%update(u, self%fine)
      call toeplitz(self%harmonic(:self%explicit), self%contact(i)%spectra%stiffness, self%tangent(:, :, i))
      associate (f => self%force(:, i), spectra => self%contact(i)%spectra)
         if (self%is_direct()) then
            f = 0
            do k = 1, self%block
               f = f + u(k)*self%tangent(:, k, i)
            end do
         else
            call find_wave(self%harmonic, spectra%stiffness, self%products, self%wave(:, i))
            if (self%contact(i)%law%jumps) &
               call find_wave(self%harmonic, spectra%damping, self%products, self%damping_wave(:, i))
            call wave_product(self%harmonic, self%wave(:, i), u, self%products, f)
         end if
         call add_coefficients(self%harmonic, -1.0_dp, spectra%offset, f)
      end associate
      call self%damp_tangent(i)
      call self%rate_of(i, u, self%force_rate(:, i))
      self%force(:, i) = self%force(:, i) + self%frequency_ratio*self%force_rate(:, i)
   end subroutine mesh_force

   !> Derivative of damping p + impulse with respect to time per Lambda, of unknown mesh i at the coefficients x; `linear`: of what
   !> a change x adds.
   subroutine rate_of(self, i, x, rate, linear)
      class(balance_type), intent(inout) :: self
      integer, intent(in) :: i
      real(dp), intent(in) :: x(:)
      real(dp), intent(out) :: rate(:)
      logical, intent(in), optional :: linear
      real(dp) :: gamma
      real(dp), allocatable :: integral(:), matrix(:, :)
      integer :: k

      rate(1) = 0
      if (self%contact(i)%law%jumps) then
         associate (spectra => self%contact(i)%spectra)
            allocate (integral(self%block))
            if (self%is_direct()) then
               allocate (matrix(self%block, self%block))
               call toeplitz(self%harmonic, spectra%damping, matrix)
               integral = matmul(matrix, x)
            else
               call wave_product(self%harmonic, self%damping_wave(:, i), x, self%products, integral)
            end if
            if (.not. present(linear)) call add_coefficients(self%harmonic, 1.0_dp, spectra%impulse, integral)
         end associate
         do k = 1, size(self%harmonic)
            gamma = real(self%harmonic(k), dp)/self%eta
            rate(2*k) = gamma*integral(2*k + 1)
            rate(2*k + 1) = -gamma*integral(2*k)
         end do
      else
         gamma = self%damping_of(i)/self%eta
         do k = 1, size(self%harmonic)
            rate(2*k) = gamma*self%harmonic(k)*x(2*k + 1)
            rate(2*k + 1) = -gamma*self%harmonic(k)*x(2*k)
         end do
      end if
   end subroutine rate_of

   !> Adds what damping does to the tangent of unknown mesh i: gamma dp'/du.
   subroutine damp_tangent(self, i)
      class(balance_type), intent(inout) :: self
      integer, intent(in) :: i
      real(dp), allocatable :: matrix(:, :)
      real(dp) :: rate, gamma
      integer :: k

      gamma = self%damping_of(i)
      if (self%contact(i)%law%jumps) then
         allocate (matrix(1 + 2*self%explicit, 1 + 2*self%explicit))
         call toeplitz(self%harmonic(:self%explicit), self%contact(i)%spectra%damping, matrix)
      end if
      associate (tangent => self%tangent(:, :, i))
         do k = 1, self%explicit
            rate = self%harmonic(k)*self%frequency_ratio/self%eta
            if (self%contact(i)%law%jumps) then
               tangent(2*k, :) = tangent(2*k, :) + rate*matrix(2*k + 1, :)
               tangent(2*k + 1, :) = tangent(2*k + 1, :) - rate*matrix(2*k, :)
            else
               tangent(2*k, 2*k + 1) = tangent(2*k, 2*k + 1) + gamma*rate
               tangent(2*k + 1, 2*k) = tangent(2*k + 1, 2*k) - gamma*rate
            end if
         end do
      end associate
   end subroutine damp_tangent

   !> (dS/du) x at the last `evaluate`, for harmonics that are not all explicit; x and s are (block, unknowns).
   subroutine apply(self, x, s)
      class(balance_type), intent(inout) :: self
      real(dp), intent(in) :: x(:, :)
      real(dp), intent(out) :: s(:, :)
      real(dp) :: force(self%block, self%unknowns), rate(self%block)
      complex(dp) :: total
      integer :: i, k, n

      do i = 1, self%unknowns
         call wave_product(self%harmonic, self%wave(:, i), x(:, i), self%products, force(:, i))
         call self%rate_of(i, x(:, i), rate, linear=.true.)
         force(:, i) = force(:, i) + self%frequency_ratio*rate
      end do
      call self%mean_product(force(1, :), x(1, :), s(1, :))
      do k = 1, size(self%harmonic)
         associate (h => self%receptance(k)%h, graph => self%system%cut%graph)
            do i = 1, self%unknowns
               total = cmplx(x(2*k, i), -x(2*k + 1, i), dp)
               do n = graph%row(i), graph%row(i + 1) - 1
                  associate (j => graph%column(n))
                     total = total + h(graph%entry(n))*cmplx(force(2*k, j), -force(2*k + 1, j), dp)
                  end associate
               end do
               s(2*k, i) = total%re
               s(2*k + 1, i) = -total%im
            end do
         end associate
      end do
   end subroutine apply

   !> dS/du at the last `evaluate`, and dS/dLambda as the border column, at the explicit harmonics.
   subroutine jacobian(self, matrix)
      class(balance_type), intent(in) :: self
      type(bordered_type), intent(inout) :: matrix
      integer :: i, l, n, block

      block = 1 + 2*self%explicit
      associate (graph => self%system%cut%graph)
         call matrix%resize(block, graph)
         matrix%interrupt = self%system%interrupt
         do i = 1, self%unknowns
            do n = graph%row(i), graph%row(i + 1) - 1
               call fill(matrix%entry(:, :, graph%entry(n)), graph%entry(n), self%tangent(:, :, graph%column(n)))
            end do
            do l = 2, block
               matrix%entry(l, l, i) = matrix%entry(l, l, i) + 1
            end do
         end do
      end associate
      matrix%column = self%d_frequency(:block, :)

   contains

      !> Rows of harmonic k: the complex receptance times the rows of the force's derivative.
      pure subroutine fill(a, entry, t)
         real(dp), intent(inout) :: a(:, :)
         integer, intent(in) :: entry
         real(dp), intent(in) :: t(:, :)
         complex(dp) :: h
         integer :: k, column

         a(1, :) = self%system%mean%force(entry)*t(1, :)
         a(1, 1) = a(1, 1) + self%system%mean%displacement(entry)
         do k = 1, self%explicit
            h = self%receptance(k)%h(entry)
            do column = 1, size(t, 2)
               a(2*k, column) = h%re*t(2*k, column) + h%im*t(2*k + 1, column)
               a(2*k + 1, column) = h%re*t(2*k + 1, column) - h%im*t(2*k, column)
            end do
         end do
      end subroutine fill

   end subroutine jacobian

   !> Coefficients of every mesh at harmonics 1..highest, (1 + 2*highest, mesh), from those of the unknown meshes at the last
   !> `evaluate`.
   pure subroutine full_coefficients(self, u, frequency_ratio, coefficients)
      class(balance_type), intent(in) :: self
      real(dp), intent(in) :: u(:, :), frequency_ratio
      real(dp), intent(out) :: coefficients(:, :)
      complex(dp) :: p(self%system%elements)
      integer :: i, k, r

      coefficients = 0
      associate (system => self%system)
         do i = 1, system%meshes
            associate (n => system%mesh_element(i))
               coefficients(1, i) = system%static_force(n)
               if (.not. system%network%elements(n)%unknown) coefficients(1, i) = coefficients(1, i) &
                  + system%mean%linear_displacement(system%cut, n, self%force(1, :), system%static_force)
            end associate
         end do
         coefficients(1, self%mesh) = u(1, :)
         do k = 1, size(self%harmonic)
            r = self%harmonic(k)
            do i = 1, self%unknowns
               p(system%cut%element(i)) = cmplx(u(2*k, i), -u(2*k + 1, i), dp)
            end do
            if (self%unknowns < system%meshes) &
               call linear_displacements(system, frequency_ratio, r, self%eta, cmplx(self%force(2*k, :), -self%force(2*k + 1, &
                    :), dp), p)
            coefficients(2*r, :) = real(p(system%mesh_element), dp)
            coefficients(2*r + 1, :) = -aimag(p(system%mesh_element))
         end do
      end associate
   end subroutine full_coefficients

end module geartrain_balance_balance
