!> Approximate solution of the linearised balance of many harmonics in time: the flow of the linearised train over the period, in
!> equal steps, and the state that it brings back to itself.
!>
!> With rho the waveform of the right-hand side without its mean, the solution is y + rho, where y is the displacement of the
!> meshes of a train whose unknown meshes have the force w(t) (y + rho) + gamma (y + rho)' less the mean of the right-hand side, w
!> the stiffness along the motion. Exact for all harmonics and infinitely small steps, so as preconditioner of GMRES it leaves
!> what the carried harmonics and the steps differ from that. Harmonics up to the natural frequencies of the meshes are coupled
!> strongly where teeth separate; eliminated together they would cost the cube of their number, here they cost their number.
module geartrain_balance_linear_flow
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_products, only: find_wave
   use geartrain_base_kinds, only: dp, pi
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_lapack, only: dgemv
   use geartrain_linalg_trigonometric, only: sample, transform_length
   use geartrain_model_system, only: system_type
   implicit none (type, external)
   private
   public :: linear_flow_type, suits

   !> Longest step over the time in which the fastest mesh vibrates by 1 rad.
   real(dp), parameter :: longest = 0.8_dp
   !> Elements are taken in blocks of this width. A step costs the square of their number.
   integer, parameter :: width = 4, most_elements = 24

   type :: linear_flow_type
      integer :: elements = 0
      !> Length of a step, dimensionless time.
      real(dp) :: h = 0
      !> Element of each unknown mesh, (unknown).
      integer, allocatable :: element(:)
      !> h W, (element in blocks, element); stiffness of the linear elements, 0 of unknown meshes, and damping, (element in blocks).
      real(dp), allocatable :: kick(:, :, :), spring(:, :), damper(:, :)
      !> Damping of each unknown mesh over twice the length of a step, (unknown).
      real(dp), allocatable :: drag(:)
      !> Stiffness along the motion and border row as weights of the samples of y, (unknown, sample).
      real(dp), allocatable :: stiffness(:, :), row(:, :)
      !> Right-hand side and border column without their means, their means, force by the right-hand side, and the displacement y,
      !> (unknown, sample).
      real(dp), allocatable :: rho(:, :), column(:, :), force(:, :), y(:, :)
      real(dp), allocatable :: rho_mean(:), column_mean(:)
      !> End state and entry in the border row per force on an unknown mesh at a step, (2*elements + 1, unknown, sample).
      real(dp), allocatable :: influence(:, :, :)
      !> Factors of the equations of state at the beginning and the entry in the border row.
      real(dp), allocatable :: matrix(:, :)
      integer, allocatable :: pivot(:)
      !> Sign of the determinant of these equations.
      integer :: orientation = 1
      type(transform_type) :: transform
   contains
      procedure :: factor
      procedure :: solve
      procedure, private :: prepare
      procedure, private :: carry
      procedure, private :: carry_back
      procedure, private :: find_force
      procedure, private :: find_waveform
   end type linear_flow_type

contains

   !> Whether the flow is written for a train: no loops, no damping to ground, no damping that changes with the contact, few
   !> elements.
   pure logical function suits(system)
      !> Dimensionless system of the train.
      type(system_type), intent(in) :: system

      suits = system%elements <= most_elements .and. system%coordinates == system%elements .and. &
              system%displacements == system%elements .and. .not. any(system%law%jumps)
   end function suits

   !> Prepares for the motion of the latest `evaluate` and a border.
   subroutine factor(self, balance, column, row, corner, regular)
      class(linear_flow_type), intent(inout) :: self
      !> Balance after `evaluate`.
      type(balance_type), intent(in) :: balance
      !> Border column and row, (block, unknown), and their corner.
      real(dp), intent(in) :: column(:, :), row(:, :), corner
      !> Whether the flow determines a solution.
      logical, intent(out) :: regular
      real(dp) :: functionals(2*balance%system%elements + 1, 2*balance%system%elements), u(size(row, 1)), &
                  added(2*balance%system%elements + 1)
      integer :: i, info, n

      call self%prepare(balance)
      n = 2*self%elements
      do i = 1, balance%unknowns
         u = 2*row(:, i)
         u(1) = row(1, i)
         call sample(u, balance%harmonic, self%transform)
         self%row(i, :) = self%transform%sample/self%transform%samples
      end do
      call self%carry_back(functionals)
      self%matrix(:, :n) = functionals
      self%matrix(:n, :n) = -functionals(:n, :)
      do i = 1, n
         self%matrix(i, i) = self%matrix(i, i) + 1
      end do
      call self%find_waveform(balance, column, self%column, self%column_mean)
      self%rho = self%column
      self%rho_mean = self%column_mean
      call self%find_force(added)
      self%matrix(:n, n + 1) = added(:n)
      self%matrix(n + 1, n + 1) = corner - added(n + 1) - sum(row(2:, :)*column(2:, :))
      call factor_matrix(n + 1, self%matrix, self%pivot, info)
      regular = info == 0
      self%orientation = 1
      do i = 1, n + 1
         if ((self%matrix(i, i) < 0) .neqv. (self%pivot(i) /= i)) self%orientation = -self%orientation
      end do
   end subroutine factor

   !> Solves approximately, in place.
   subroutine solve(self, balance, column, row, x, y)
      class(linear_flow_type), intent(inout) :: self
      !> Balance as at `factor`.
      type(balance_type), intent(in) :: balance
      !> Border as at `factor`.
      real(dp), intent(in) :: column(:, :), row(:, :)
      !> Right-hand side, afterwards the solution, (block, unknown), and its entry in the border row.
      real(dp), intent(inout) :: x(:, :), y
      real(dp) :: added(2*self%elements + 1), b(2*self%elements + 1, 1)
      integer :: i, k, n

      n = 2*self%elements
      call self%find_waveform(balance, x, self%rho, self%rho_mean)
      call self%find_force(added)
      b(:n, 1) = added(:n)
      b(n + 1, 1) = y - added(n + 1) - sum(row(2:, :)*x(2:, :))
      call solve_factored(n + 1, 1, self%matrix, self%pivot, b)
      y = b(n + 1, 1)
      self%rho = self%rho - y*self%column
      self%rho_mean = self%rho_mean - y*self%column_mean
      call self%find_force()
      call self%carry(b(:n, 1))
      x = x - y*column
      x(1, :) = 0
      do i = 1, balance%unknowns
         associate (t => self%transform)
            t%sample = self%y(i, :)/t%samples
            call t%to_coefficients()
            x(1, i) = t%coefficient(1)%re
            do k = 1, size(balance%harmonic)
               x(2*k, i) = x(2*k, i) + 2*t%coefficient(balance%harmonic(k) + 1)%re
               x(2*k + 1, i) = x(2*k + 1, i) - 2*t%coefficient(balance%harmonic(k) + 1)%im
            end do
         end associate
      end do
   end subroutine solve

   !> Chooses the steps and finds what they need. Steps of this length change frequency and decay of a vibration: stiffness and
   !> damping of each element are such that the element by itself has its own.
   subroutine prepare(self, balance)
      class(linear_flow_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      real(dp) :: fastest, period, share(balance%system%elements), decay, omega
      real(dp), allocatable :: wave(:)
      integer :: i, k, n, samples, blocks

      associate (system => balance%system, e => balance%system%elements, u => balance%unknowns)
         self%elements = e
         self%element = system%cut%element
         period = 2*pi*balance%eta/balance%frequency_ratio
         fastest = 0
         do i = 1, u
            fastest = max(fastest, sqrt(system%own(self%element(i))*balance%contact(i)%law%stiffest()))
         end do
         samples = transform_length(max(4*balance%highest + 2, ceiling(period*fastest/longest)))
         blocks = (e + width - 1)/width
         if (self%transform%samples /= samples .or. .not. allocated(self%rho)) then
            call self%transform%plan(samples)
            if (allocated(self%rho)) deallocate (self%rho, self%column, self%force, self%y, self%stiffness, self%row, &
                                               self%influence)
            allocate (self%rho(u, samples), self%column(u, samples), self%force(u, samples), self%y(u, samples), &
                      self%stiffness(u, samples), self%row(u, samples), self%influence(2*e + 1, u, samples))
         end if
         if (.not. allocated(self%kick)) then
            allocate (self%kick(width, blocks, e), self%spring(width, blocks), self%damper(width, blocks), source=0.0_dp)
            allocate (self%matrix(2*e + 1, 2*e + 1), self%pivot(2*e + 1))
         end if
         self%h = period/samples
         do n = 1, e
            self%kick(mod(n - 1, width) + 1, (n - 1)/width + 1, n) = self%h*system%own(n)
            do k = system%first(n), system%first(n + 1) - 1
               self%kick(mod(n - 1, width) + 1, (n - 1)/width + 1, system%neighbour(k)) = self%h*system%coupling(k)
            end do
            decay = system%own(n)*system%damping(n)*self%h
            omega = sqrt(max(system%own(n)*system%spring(n)*self%h**2 - decay**2/4, 0.0_dp))
            share(n) = 1
            if (omega > 0) share(n) = (1 + exp(-decay) - 2*exp(-decay/2)*cos(omega))/(system%own(n)*self%h**2)
            self%spring(mod(n - 1, width) + 1, (n - 1)/width + 1) = share(n)*system%spring(n)
            self%damper(mod(n - 1, width) + 1, (n - 1)/width + 1) = (1 - exp(-decay))/(system%own(n)*self%h)
         end do
         self%drag = system%damping(self%element)/(2*self%h)
         allocate (wave(samples))
         do i = 1, u
            associate (n => self%element(i))
               self%spring(mod(n - 1, width) + 1, (n - 1)/width + 1) = 0
               call find_wave(balance%harmonic, balance%contact(i)%spectra%stiffness, self%transform, wave)
               self%stiffness(i, :) = share(n)*wave
            end associate
         end do
      end associate
   end subroutine prepare

   !> Samples of coefficients without their means, and the means.
   subroutine find_waveform(self, balance, x, rho, mean)
      class(linear_flow_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: x(:, :)
      real(dp), intent(inout) :: rho(:, :)
      real(dp), allocatable, intent(inout) :: mean(:)
      real(dp) :: u(size(x, 1))
      integer :: i

      mean = x(1, :)
      do i = 1, size(x, 2)
         u = x(:, i)
         u(1) = 0
         call sample(u, balance%harmonic, self%transform)
         rho(i, :) = self%transform%sample
      end do
   end subroutine find_waveform

   !> Force on the unknown meshes by `rho`.
   subroutine find_force(self, added)
      class(linear_flow_type), intent(inout) :: self
      !> What it adds to the end state and to the entry in the border row, (2*elements + 1).
      real(dp), intent(out), optional :: added(:)
      integer :: i, n

      n = self%transform%samples
      associate (rho => self%rho)
         do i = 1, size(self%element)
            self%force(i, :) = self%stiffness(i, :)*rho(i, :) - self%rho_mean(i)
            self%force(i, 2:n - 1) = self%force(i, 2:n - 1) + self%drag(i)*(rho(i, 3:) - rho(i, :n - 2))
            self%force(i, 1) = self%force(i, 1) + self%drag(i)*(rho(i, 2) - rho(i, n))
            self%force(i, n) = self%force(i, n) + self%drag(i)*(rho(i, 1) - rho(i, n - 1))
         end do
      end associate
      if (.not. present(added)) return
      call dgemv('N', size(added), size(self%force), 1.0_dp, self%influence, size(added), self%force, 1, 0.0_dp, added, 1)
   end subroutine find_force

   !> Finds y under `force`, from a state at the beginning.
   subroutine carry(self, state)
      class(linear_flow_type), intent(inout) :: self
      !> Displacements, then velocities, (2*elements).
      real(dp), intent(in) :: state(:)
      real(dp), dimension(width*size(self%kick, 2)) :: p, v

      associate (e => self%elements)
         p = 0
         v = 0
         p(:e) = state(:e)
         v(:e) = state(e + 1:)
         call take_steps(size(self%kick, 2), e, size(self%element), self%transform%samples, self%element, self%h, self%kick, &
                         self%spring, self%damper, self%stiffness, self%force, self%y, p, v)
      end associate
   end subroutine carry

   !> The steps of `carry`.
   pure subroutine take_steps(blocks, e, unknowns, samples, element, h, kick, spring, damper, stiffness, drive, y, p, v)
      integer, intent(in) :: blocks, e, unknowns, samples, element(unknowns)
      real(dp), intent(in) :: h, kick(width*blocks, e), spring(width*blocks), damper(width*blocks), &
                              stiffness(unknowns, samples), drive(unknowns, samples)
      real(dp), intent(out) :: y(unknowns, samples)
      real(dp), intent(inout) :: p(width*blocks), v(width*blocks)
      real(dp) :: force(width*blocks)
      integer :: i, k, l, m, n

      do k = 1, samples
         do l = 0, width*(blocks - 1), width
            do n = 1, width
               force(l + n) = spring(l + n)*p(l + n) + damper(l + n)*v(l + n)
            end do
         end do
         do i = 1, unknowns
            n = element(i)
            y(i, k) = p(n)
            force(n) = force(n) + stiffness(i, k)*p(n) + drive(i, k)
         end do
         do l = 0, width*(blocks - 1), width
            do m = 1, e
               do n = 1, width
                  v(l + n) = v(l + n) - kick(l + n, m)*force(m)
               end do
            end do
            do n = 1, width
               p(l + n) = p(l + n) + h*v(l + n)
            end do
         end do
      end do
   end subroutine take_steps

   !> Carries the functionals that give the end state and the entry in the border row back over the period, and keeps what a force
   !> on an unknown mesh at any step adds to them.
   pure subroutine carry_back(self, functionals)
      class(linear_flow_type), intent(inout) :: self
      !> End state and entry in the border row, (2*elements + 1), by the state at the beginning, (2*elements).
      real(dp), intent(out) :: functionals(:, :)
      real(dp), dimension(2*self%elements + 1, self%elements) :: p, v, force
      real(dp), dimension(self%elements, self%elements) :: kick
      real(dp), dimension(self%elements) :: spring, damper
      integer :: i, k, m, n

      associate (e => self%elements)
         do n = 1, e
            spring(n) = self%spring(mod(n - 1, width) + 1, (n - 1)/width + 1)
            damper(n) = self%damper(mod(n - 1, width) + 1, (n - 1)/width + 1)
            do m = 1, e
               kick(m, n) = self%kick(mod(m - 1, width) + 1, (m - 1)/width + 1, n)
            end do
         end do
         p = 0
         v = 0
         do n = 1, e
            p(n, n) = 1
            v(e + n, n) = 1
         end do
         do k = self%transform%samples, 1, -1
            do n = 1, e
               v(:, n) = v(:, n) + self%h*p(:, n)
            end do
            do m = 1, e
               force(:, m) = 0
               do n = 1, e
                  if (abs(kick(n, m)) > 0) force(:, m) = force(:, m) - kick(n, m)*v(:, n)
               end do
            end do
            do n = 1, e
               p(:, n) = p(:, n) + spring(n)*force(:, n)
               v(:, n) = v(:, n) + damper(n)*force(:, n)
            end do
            do i = 1, size(self%element)
               associate (n => self%element(i))
                  p(:, n) = p(:, n) + self%stiffness(i, k)*force(:, n)
                  p(2*e + 1, n) = p(2*e + 1, n) + self%row(i, k)
                  self%influence(:, i, k) = force(:, n)
               end associate
            end do
         end do
         functionals(:, :e) = p
         functionals(:, e + 1:) = v
      end associate
   end subroutine carry_back

end module geartrain_balance_linear_flow
