!> Forces of the unknown meshes at the harmonics of a balance, over k b_c, and their derivatives by the coefficients u of p:
!>    phi = Toeplitz(w) p - b sigma + gamma p'    with the spectra w and sigma of the contact of each mesh.
module geartrain_balance_mesh_forces
   use geartrain_balance_needed_harmonics, only: needed_harmonics
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: fine_samples, sample, transform_length
   use geartrain_mesh_law_contact, only: contact_type
   use geartrain_model_system, only: system_type
   implicit none (type, external)
   private
   public :: mesh_forces_type

   !> With at most `most_direct` harmonics d phi/du is a matrix. With more only its block of the lowest `explicit_of_many`
   !> harmonics is, and the whole derivative is applied by FFT.
   integer, parameter :: most_direct = 16, explicit_of_many = 10

   type :: mesh_forces_type
      type(system_type) :: system
      !> Sub-harmonic index; carried harmonics of Lambda/eta, ascending; coefficients of a mesh, 1 + 2*size(harmonic).
      integer :: eta = 1
      integer, allocatable :: harmonic(:)
      integer :: block = 1
      !> Highest harmonic asked for; carried are all of 1..highest where eta > 1, else those that the excitation reaches.
      integer :: highest = 0
      !> Samples a period by which the coefficients are found; 0: the coefficients are exact.
      integer :: samples = 0
      !> Number of unknown meshes, and their numbers in the train, (unknown).
      integer :: unknowns = 0
      integer, allocatable :: mesh(:)
      !> Contact of each unknown mesh at the last `find_forces`, (unknown).
      type(contact_type), allocatable :: contact(:)
      !> phi [1], (block, unknown), and d phi/du [1], (1 + 2*explicit, 1 + 2*explicit, unknown), of the mean and the lowest
      !> `explicit` carried harmonics.
      real(dp), allocatable :: force(:, :), tangent(:, :, :)
      integer :: explicit = 0
      !> Lambda [1] at the last `find_forces`.
      real(dp), private :: frequency_ratio = 0
      !> Plan of the waveforms of the meshes; where not all harmonics are explicit also the plan of products, and the stiffness in
      !> contact [1], (sample, unknown).
      type(transform_type), private :: fine, products
      real(dp), allocatable, private :: wave(:, :)
   contains
      procedure :: setup
      procedure :: find_forces
      procedure :: is_direct
      procedure :: make_explicit
      procedure :: tangent_product
      procedure :: damping_of
      procedure :: mean_stiffness
      procedure, private :: find_force
      procedure, private :: find_tangent
      procedure, private :: damp_tangent
      procedure, private :: damping_rate
      procedure, private :: product
   end type mesh_forces_type

contains

   !> Chooses the carried harmonics and prepares work space and plans for `find_forces`.
   subroutine setup(self, system, highest, eta, samples)
      class(mesh_forces_type), intent(inout) :: self
      !> Dimensionless system of the train.
      type(system_type), intent(in) :: system
      !> Highest harmonic of Lambda/eta to carry; sub-harmonic index; samples a period by which coefficients are found, 0: exact.
      integer, intent(in) :: highest, eta, samples
      integer :: i, r

      self%system = system
      self%eta = eta
      self%highest = highest
      self%samples = samples
      self%harmonic = [(r, r=1, highest)]
      if (eta == 1) self%harmonic = needed_harmonics(system, highest)
      self%block = 1 + 2*size(self%harmonic)
      self%mesh = system%cut%mesh
      self%unknowns = size(self%mesh)
      if (.not. allocated(self%contact)) allocate (self%contact(self%unknowns))
      do i = 1, self%unknowns
         associate (j => self%mesh(i))
            call self%contact(i)%setup(system%half_backlash(j), system%mesh_stiffness(j), eta, self%harmonic, 2*highest, samples)
         end associate
      end do
      call self%fine%plan(fine_samples(maxval([1, self%harmonic])))
      if (allocated(self%force)) deallocate (self%force, self%wave, self%tangent)
      allocate (self%force(self%block, self%unknowns))
      self%explicit = size(self%harmonic)
      if (self%explicit > most_direct) self%explicit = explicit_of_many
      ! No alias of a product with spectra up to twice the highest harmonic reaches a carried harmonic.
      if (.not. self%is_direct()) call self%products%plan(transform_length(4*self%harmonic(size(self%harmonic)) + 1))
      allocate (self%wave(merge(0, self%products%samples, self%is_direct()), self%unknowns))
      allocate (self%tangent(1 + 2*self%explicit, 1 + 2*self%explicit, self%unknowns))
   end subroutine setup

   !> Forces and derivatives of all unknown meshes.
   subroutine find_forces(self, u, frequency_ratio)
      class(mesh_forces_type), intent(inout) :: self
      !> Coefficients of the unknown meshes over b_c [1], (block, unknown): mean, cos, sin, ...; Lambda [1].
      real(dp), intent(in) :: u(:, :), frequency_ratio
      integer :: i

      self%frequency_ratio = frequency_ratio
      do i = 1, self%unknowns
         call self%find_force(i, u(:, i))
      end do
   end subroutine find_forces

   !> Damping over stiffness, gamma [1], of an unknown mesh.
   pure real(dp) function damping_of(self, i)
      class(mesh_forces_type), intent(in) :: self
      !> Number of the unknown mesh.
      integer, intent(in) :: i

      damping_of = self%system%damping(self%system%mesh_element(self%mesh(i)))
   end function damping_of

   !> Mean dynamic stiffness of an unknown mesh over its stiffness [1] at the last `find_forces`: mean stiffness in contact plus i
   !> times gamma times the frequency of a harmonic.
   pure complex(dp) function mean_stiffness(self, i, harmonic)
      class(mesh_forces_type), intent(in) :: self
      !> Number of the unknown mesh; harmonic of Lambda/eta.
      integer, intent(in) :: i, harmonic

      mean_stiffness = cmplx(real(self%contact(i)%stiffness(0), dp), self%damping_of(i)*harmonic*self%frequency_ratio/self%eta, dp)
   end function mean_stiffness

   !> Whether `tangent` holds the derivatives at all carried harmonics.
   pure logical function is_direct(self)
      class(mesh_forces_type), intent(in) :: self

      is_direct = self%explicit == size(self%harmonic)
   end function is_direct

   !> Makes `tangent` hold the derivatives at more harmonics, at the last `find_forces`.
   subroutine make_explicit(self, harmonics)
      class(mesh_forces_type), intent(inout) :: self
      !> Number of explicit harmonics, the lowest carried ones; all where fewer are carried.
      integer, intent(in) :: harmonics
      integer :: i

      self%explicit = min(harmonics, size(self%harmonic))
      deallocate (self%tangent)
      allocate (self%tangent(1 + 2*self%explicit, 1 + 2*self%explicit, self%unknowns))
      do i = 1, self%unknowns
         call self%find_tangent(i)
         call self%damp_tangent(i)
      end do
   end subroutine make_explicit

   !> Force and derivative of unknown mesh i by the spectra of its contact.
   subroutine find_force(self, i, u)
      class(mesh_forces_type), intent(inout) :: self
      integer, intent(in) :: i
      real(dp), intent(in) :: u(:)
      real(dp) :: rate
      integer :: k

      call self%contact(i)%update(u, self%fine)
      call self%find_tangent(i)
      if (self%is_direct()) then
         self%force(:, i) = 0
         do k = 1, self%block
            self%force(:, i) = self%force(:, i) + u(k)*self%tangent(:, k, i)
         end do
      else
         self%products%coefficient = 0
         associate (n => 2*self%harmonic(size(self%harmonic)))
            self%products%coefficient(:n + 1) = self%contact(i)%stiffness(:n)
         end associate
         call self%products%to_samples()
         self%wave(:, i) = self%products%sample
         call self%product(i, u, self%force(:, i))
      end if
      associate (f => self%force(:, i), sigma => self%contact(i)%offset, b => self%contact(i)%half_backlash, r => self%harmonic)
         f(1) = f(1) - b*real(sigma(0), dp)
         do k = 1, size(r)
            f(2*k) = f(2*k) - 2*b*real(sigma(r(k)), dp)
            f(2*k + 1) = f(2*k + 1) + 2*b*aimag(sigma(r(k)))
            rate = self%damping_rate(i, k)
            f(2*k) = f(2*k) + rate*u(2*k + 1)
            f(2*k + 1) = f(2*k + 1) - rate*u(2*k)
         end do
      end associate
      call self%damp_tangent(i)
   end subroutine find_force

   !> Sets `tangent` of unknown mesh i to Toeplitz(w), d phi/du without damping.
   subroutine find_tangent(self, i)
      class(mesh_forces_type), intent(inout) :: self
      integer, intent(in) :: i
      complex(dp) :: difference, total
      integer :: k, l, m

      associate (w => self%contact(i)%stiffness, t => self%tangent(:, :, i), r => self%harmonic)
         t(1, 1) = real(w(0), dp)
         do k = 1, self%explicit
            t(1, 2*k) = real(w(r(k)), dp)
            t(1, 2*k + 1) = -aimag(w(r(k)))
            t(2*k, 1) = 2*t(1, 2*k)
            t(2*k + 1, 1) = 2*t(1, 2*k + 1)
         end do
         do l = 1, self%explicit
            do m = 1, self%explicit
               difference = w(abs(r(m) - r(l)))
               if (r(m) < r(l)) difference = conjg(difference)
               total = w(r(m) + r(l))
               t(2*m, 2*l) = difference%re + total%re
               t(2*m + 1, 2*l) = -difference%im - total%im
               t(2*m, 2*l + 1) = difference%im - total%im
               t(2*m + 1, 2*l + 1) = difference%re - total%re
            end do
         end do
      end associate
   end subroutine find_tangent

   !> Adds gamma dp'/du to `tangent` of unknown mesh i.
   subroutine damp_tangent(self, i)
      class(mesh_forces_type), intent(inout) :: self
      integer, intent(in) :: i
      real(dp) :: rate
      integer :: k

      do k = 1, self%explicit
         rate = self%damping_rate(i, k)
         self%tangent(2*k, 2*k + 1, i) = self%tangent(2*k, 2*k + 1, i) + rate
         self%tangent(2*k + 1, 2*k, i) = self%tangent(2*k + 1, 2*k, i) - rate
      end do
   end subroutine damp_tangent

   !> gamma times the frequency of the k-th carried harmonic [1], for unknown mesh i.
   pure real(dp) function damping_rate(self, i, k)
      class(mesh_forces_type), intent(in) :: self
      integer, intent(in) :: i, k

      damping_rate = self%damping_of(i)*self%harmonic(k)*self%frequency_ratio/self%eta
   end function damping_rate

   !> (d phi/du) x of an unknown mesh at all carried harmonics, where these are not all explicit.
   subroutine tangent_product(self, i, x, f)
      class(mesh_forces_type), intent(inout) :: self
      !> Number of the unknown mesh.
      integer, intent(in) :: i
      !> Change of the coefficients of the mesh [1], (block).
      real(dp), intent(in) :: x(:)
      !> Change of its force [1], (block).
      real(dp), intent(out) :: f(:)
      real(dp) :: rate
      integer :: k

      call self%product(i, x, f)
      do k = 1, size(self%harmonic)
         rate = self%damping_rate(i, k)
         f(2*k) = f(2*k) + rate*x(2*k + 1)
         f(2*k + 1) = f(2*k + 1) - rate*x(2*k)
      end do
   end subroutine tangent_product

   !> Toeplitz(w) x of unknown mesh i at all carried harmonics, by samples of its stiffness in contact: exact, because there are
   !> more than four samples per period of the highest harmonic.
   subroutine product(self, i, x, f)
      class(mesh_forces_type), intent(inout) :: self
      integer, intent(in) :: i
      real(dp), intent(in) :: x(:)
      real(dp), intent(out) :: f(:)
      integer :: k

      associate (products => self%products, r => self%harmonic)
         call sample(x, r, products)
         products%sample = self%wave(:, i)*products%sample
         call products%to_coefficients()
         f(1) = real(products%coefficient(1), dp)/products%samples
         do k = 1, size(r)
            f(2*k) = 2*real(products%coefficient(r(k) + 1), dp)/products%samples
            f(2*k + 1) = -2*aimag(products%coefficient(r(k) + 1))/products%samples
         end do
      end associate
   end subroutine product

end module geartrain_balance_mesh_forces
