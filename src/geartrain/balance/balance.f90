!> Harmonic balance in mesh displacements: with phi the whole mesh force over k b_c, projected by Galerkin,
!>    S_j0 = phi_j0 - load_j,     S_jr = p_jr + sum over i of H_ji(r Lambda/eta) phi_ir - a_jr(Lambda).
!> Identity plus compact: well conditioned for any number of harmonics. Equations (8) to (10) of the paper with their signs and
!> indices put right, shafts condensed.
module geartrain_balance_balance
   use geartrain_balance_mesh_forces, only: mesh_forces_type
   use geartrain_balance_winding, only: winding_type
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_bordered, only: bordered_type
   use geartrain_network_excitation, only: excited_harmonics
   use geartrain_network_parameter_path, only: parameter_path_type
   use geartrain_network_receptance, only: find_receptance, linear_displacements, receptance_type
   use geartrain_network_system, only: put_speed, system_type
   implicit none (type, external)
   private
   public :: balance_type

   !> Step of the differences that give dS/ds, over the length of the path: their error is some 1e-10.
   real(dp), parameter :: difference = 1e-6_dp
   !> Displacement by the forces of a displacement of 1 [1] beyond which harmonics are coupled strongly.
   real(dp), parameter :: strong = 0.5_dp

   type, extends(mesh_forces_type) :: balance_type
      !> Where it is allocated, the free parameter s of the branch is a parameter of the train at constant Lambda: the train is that
      !> of the latest `evaluate`. Else s is Lambda. `setup` leaves it as it is.
      type(parameter_path_type), allocatable :: path
      !> Harmonics of Lambda/eta up to 3*highest that are not carried though excitation may reach them, ascending.
      integer, allocatable :: missing(:)
      !> Harmonics of Lambda/eta above `highest` that a torque, mesh stiffness or transmission error excites, ascending.
      integer, allocatable :: left_out(:)
      !> Residual S [1] and dS/ds [1/unit of s], (block, unknown).
      real(dp), allocatable :: residual(:, :), d_frequency(:, :)
      !> Receptance at each carried harmonic, (carried harmonic).
      type(receptance_type), allocatable :: receptance(:)
   contains
      procedure :: setup
      procedure :: evaluate
      procedure :: take
      procedure :: jacobian
      procedure :: apply
      procedure :: full_coefficients
      procedure :: reaches
      procedure, private :: evaluate_at
      procedure :: mean_matrix
      procedure :: mean_product
      procedure :: residual_change
   end type balance_type

contains

   !> Prepares the balance; samples = 0: exact coefficients.
   subroutine setup(self, system, highest, eta, samples, chosen, repeats, winding)
      class(balance_type), intent(inout) :: self
      type(system_type), pointer, intent(in) :: system
      !> Highest harmonic of Lambda/eta to carry; sub-harmonic index; samples a period by which coefficients are found, 0: exact.
      integer, intent(in) :: highest, eta, samples
      !> Harmonics to carry, ascending, up to `highest`; absent: those that the excitation reaches.
      integer, intent(in), optional :: chosen(:)
      !> How often the motions go through their waveform within the period, see `mesh_forces_type`.
      integer, intent(in), optional :: repeats
      !> Winding in which all harmonics to carry have places; absent: none.
      type(winding_type), intent(in), optional :: winding
      logical :: misses(3*highest)
      integer :: r

      call self%mesh_forces_type%setup(system, highest, eta, samples, chosen, repeats, winding)
      misses = .true.
      misses(self%harmonic) = .false.
      self%missing = pack([(r, r=1, 3*highest)], misses)
      self%missing = pack(self%missing, mod(self%missing, self%repeats) == 0)
      self%left_out = eta*excited_harmonics(system)
      self%left_out = pack(self%left_out, self%left_out > highest)
      if (allocated(self%residual)) deallocate (self%residual, self%d_frequency, self%receptance)
      allocate (self%residual(self%block, self%unknowns), self%receptance(size(self%harmonic)))
      allocate (self%d_frequency, mold=self%residual)
   end subroutine setup

   !> Whether there is a train at a value of the free parameter.
   pure logical function reaches(self, s)
      class(balance_type), intent(in) :: self
      !> Lambda [1], or the parameter of the path [its unit].
      real(dp), intent(in) :: s

      if (allocated(self%path)) then
         reaches = s >= self%path%low .and. s <= self%path%high
      else
         reaches = s > 0
      end if
   end function reaches

   !> Forces, residual and dS/ds at one motion.
   subroutine evaluate(self, u, s)
      class(balance_type), intent(inout) :: self
      !> Coefficients of the unknown meshes over b_c [1], (block, unknown): mean, cos, sin, ...
      real(dp), intent(in) :: u(:, :)
      !> Lambda [1], or the parameter of the path [its unit], which the path must reach.
      real(dp), intent(in) :: s

      if (allocated(self%path)) then
         call evaluate_on_path(self, u, s)
      else
         call self%evaluate_at(u, s)
      end if
   end subroutine evaluate

   !> Forces, residual and its derivative with respect to the parameter of the path, by trains beside the train.
   subroutine evaluate_on_path(self, u, s)
      class(balance_type), intent(inout) :: self
      real(dp), intent(in) :: u(:, :), s
      type(balance_type) :: beside
      type(system_type), target :: side
      real(dp) :: from, to

      associate (path => self%path)
         call path%system_at(s, self%system)
         call self%take(self%system)
         call self%evaluate_at(u, path%frequency_ratio)
         from = max(path%low, s - difference*path%length)
         to = min(path%high, s + difference*path%length)
         call beside%setup(self%system, self%highest, self%eta, self%samples, self%harmonic, self%repeats)
         call find_beside(to)
         self%d_frequency = beside%residual
         call find_beside(from)
         self%d_frequency = (self%d_frequency - beside%residual)/(to - from)
      end associate

   contains

      !> Evaluates the train with another value at the same motion.
      subroutine find_beside(value)
         real(dp), intent(in) :: value
         type(system_type), pointer :: pointer_to_side

         call self%path%system_at(value, side)
         pointer_to_side => side
         call beside%take(pointer_to_side, self)
         call beside%evaluate_at(u, self%path%frequency_ratio)
      end subroutine find_beside

   end subroutine evaluate_on_path

   !> Goes on with another train of the same unknowns.
   subroutine take(self, system, beside)
      class(balance_type), intent(inout) :: self
      type(system_type), pointer, intent(in) :: system
      !> A balance with the same harmonics at its latest `evaluate`, whose contact events are kept: for derivatives of its motion.
      class(balance_type), intent(in), optional :: beside
      integer :: i

      self%varies = .true.
      self%system => system
      do i = 1, self%unknowns
         call self%contact(i)%setup(system%law(self%mesh(i)), self%eta, self%harmonic, 2*self%highest, self%samples)
         if (present(beside)) call self%contact(i)%keep_events(beside%contact(i))
      end do
   end subroutine take

   !> Forces, residual and dS/dLambda of the present train.
   subroutine evaluate_at(self, u, frequency_ratio)
      class(balance_type), intent(inout) :: self
      !> Coefficients of the unknown meshes over b_c [1], (block, unknown): mean, cos, sin, ...; Lambda [1].
      real(dp), intent(in) :: u(:, :), frequency_ratio
      complex(dp) :: s, ds, force, d_force
      integer :: i, k, n

      call put_speed(self%system, frequency_ratio)
      do k = 1, size(self%harmonic)
         call find_receptance(self%system, frequency_ratio, self%harmonic(k), self%eta, self%receptance(k))
      end do
      if (self%least_explicit < size(self%harmonic) .and. .not. self%chosen) then
         if (.not. self%suits_flow()) call self%adjust_explicit(strongly_coupled(self))
      end if
      call self%find_forces(u, frequency_ratio)
      call self%mean_product(self%force(1, :), u(1, :), self%residual(1, :))
      self%residual(1, :) = self%residual(1, :) - self%system%mean%static_force
      self%d_frequency(1, :) = 0
      if (allocated(self%system%speed_loads)) then
         associate (loads => self%system%speed_loads)
            self%d_frequency(1, :) = -matmul(loads%mean, loads%rates_at(frequency_ratio))
         end associate
      end if
      do k = 1, size(self%harmonic)
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
   end subroutine evaluate_at

   !> Number of the lowest harmonics, up to the last one at which the motion of meshes makes forces that move them by half as much.
   !> Above it the matrix is nearly the identity: iterations converge, and the sign of the determinant is that of the lowest ones.
   pure integer function strongly_coupled(self) result(number)
      class(balance_type), intent(in) :: self
      real(dp) :: moved(self%unknowns)
      integer :: i

      associate (graph => self%system%cut%graph)
         do number = size(self%harmonic), self%least_explicit + 1, -1
            associate (h => self%receptance(number)%h)
               do i = 1, self%unknowns
                  moved(i) = sum(abs(h(graph%entry(graph%row(i):graph%row(i + 1) - 1))))
               end do
            end associate
            if (any(moved > strong)) return
         end do
      end associate
      number = self%least_explicit
   end function strongly_coupled

   !> Left sides of the mean equations: the mean forces themselves unless unknown meshes close loops (geartrain_network_mean).
   pure subroutine mean_product(self, force, displacement, product)
      class(balance_type), intent(in) :: self
      !> Mean force phi and mean displacement over b_c of each unknown mesh [1], (unknown).
      real(dp), intent(in) :: force(:), displacement(:)
      !> Left side of each mean equation [1], (unknown).
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

   !> Derivative of the residual at one harmonic by the displacements at that harmonic, each mesh with its mean stiffness.
   pure subroutine mean_matrix(self, harmonic, receptance, matrix)
      class(balance_type), intent(in) :: self
      !> Harmonic of Lambda/eta.
      integer, intent(in) :: harmonic
      !> Receptance at `harmonic`.
      type(receptance_type), intent(in) :: receptance
      !> Derivative [1], (entries of the cut's graph).
      complex(dp), intent(out) :: matrix(:)
      integer :: n

      matrix(:self%unknowns) = 1
      matrix(self%unknowns + 1:) = 0
      associate (entry => self%system%cut%graph%entry, column => self%system%cut%graph%column)
         do n = 1, size(entry)
            matrix(entry(n)) = matrix(entry(n)) + receptance%h(entry(n))*self%mean_stiffness(column(n), harmonic)
         end do
      end associate
   end subroutine mean_matrix

   !> (dS/du) x at the last `evaluate`, where not all harmonics are explicit.
   subroutine apply(self, x, s)
      class(balance_type), intent(inout) :: self
      !> Change of the coefficients [1], (block, unknown).
      real(dp), intent(in) :: x(:, :)
      !> Change of the residual [1], (block, unknown).
      real(dp), intent(out) :: s(:, :)
      real(dp) :: force(self%block, self%unknowns)
      integer :: i

      do i = 1, self%unknowns
         call self%tangent_product(i, x(:, i), force(:, i))
      end do
      call self%residual_change(x, force, s)
   end subroutine apply

   !> Change of the residual by a change of the coefficients and of the forces.
   pure subroutine residual_change(self, x, force, s)
      class(balance_type), intent(in) :: self
      !> Change of the coefficients [1], (block, unknown).
      real(dp), intent(in) :: x(:, :)
      !> Change of the coefficients of the forces [1], (block, unknown).
      real(dp), intent(in) :: force(:, :)
      !> Change of the residual [1], (block, unknown).
      real(dp), intent(out) :: s(:, :)
      complex(dp) :: total
      integer :: i, k, n

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
   end subroutine residual_change

   !> dS/du and, as the border column, dS/dLambda at the last `evaluate`, mean and explicit harmonics only.
   subroutine jacobian(self, matrix)
      class(balance_type), intent(in) :: self
      !> Resized as needed; its border row and corner are left to the caller.
      type(bordered_type), intent(inout) :: matrix
      integer :: i, l, n, block

      block = 1 + 2*self%explicit
      associate (graph => self%system%cut%graph)
         call matrix%resize(block, graph)
         matrix%interrupt = self%system%interrupt
         matrix%uncoupled = self%uncoupled
         do i = 1, self%unknowns
            do n = graph%row(i), graph%row(i + 1) - 1
               if (self%uncoupled(graph%column(n))) then
                  call fill_pairs(matrix%entry(:, :, graph%entry(n)), graph%entry(n), self%tangent(:, :, graph%column(n)))
                  cycle
               end if
               call fill(matrix%entry(:, :, graph%entry(n)), graph%entry(n), self%tangent(:, :, graph%column(n)))
            end do
            do l = 2, block
               matrix%entry(l, l, i) = matrix%entry(l, l, i) + 1
            end do
         end do
      end associate
      matrix%column = self%d_frequency(:block, :)

   contains

      !> Rows of each harmonic: the complex receptance times the rows of t, the derivative of the force.
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

      !> The same where the force of each harmonic depends on that harmonic alone.
      pure subroutine fill_pairs(a, entry, t)
         real(dp), intent(inout) :: a(:, :)
         integer, intent(in) :: entry
         real(dp), intent(in) :: t(:, :)
         complex(dp) :: h
         integer :: k

         a = 0
         a(1, 1) = self%system%mean%force(entry)*t(1, 1) + self%system%mean%displacement(entry)
         do k = 1, self%explicit
            h = self%receptance(k)%h(entry)
            a(2*k, 2*k:2*k + 1) = h%re*t(2*k, 2*k:2*k + 1) + h%im*t(2*k + 1, 2*k:2*k + 1)
            a(2*k + 1, 2*k:2*k + 1) = h%re*t(2*k + 1, 2*k:2*k + 1) - h%im*t(2*k, 2*k:2*k + 1)
         end do
      end subroutine fill_pairs

   end subroutine jacobian

   !> Coefficients of every mesh of the train from the coefficients of the unknown meshes at the last `evaluate`.
   pure subroutine full_coefficients(self, u, coefficients)
      class(balance_type), intent(in) :: self
      !> Coefficients of the unknown meshes over b_c [1], (block, unknown), of the last `evaluate`.
      real(dp), intent(in) :: u(:, :)
      !> Displacements over b_c [1], (block, mesh): mean, cos and sin of each carried harmonic.
      real(dp), intent(out) :: coefficients(:, :)
      complex(dp) :: p(self%system%elements)
      integer :: i, k

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
            do i = 1, self%unknowns
               p(system%cut%element(i)) = cmplx(u(2*k, i), -u(2*k + 1, i), dp)
            end do
            if (self%unknowns < system%meshes) &
               call linear_displacements(system, self%frequency_ratio, self%harmonic(k), self%eta, &
                                         cmplx(self%force(2*k, :), -self%force(2*k + 1, :), dp), p)
            do i = 1, system%meshes
               coefficients(2*k, i) = real(p(system%mesh_element(i)), dp)
               coefficients(2*k + 1, i) = -aimag(p(system%mesh_element(i)))
            end do
         end do
      end associate
   end subroutine full_coefficients

end module geartrain_balance_balance
