!> Approximate solution of the linearised balance of many harmonics in time: the flow of the linearised train over the period, in
!> equal steps, and the state that it brings back to itself.
!>
!> With rho the waveform of the right-hand side without its mean, the solution is y + rho, where y is the displacement of the
!> meshes of a train whose unknown meshes have the force w(t) (y + rho) + gamma (y + rho)' less the mean of the right-hand side, w
!> the stiffness along the motion. Exact for all harmonics and infinitely small steps, so as preconditioner of GMRES it leaves
!> what the carried harmonics and the steps differ from that. Harmonics up to the natural frequencies of the meshes are coupled
!> strongly where teeth separate; eliminated together they would cost the cube of their number, here they cost their number.
module geartrain_balance_linear_flow
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_products, only: find_wave
   use geartrain_base_kinds, only: dp, pi
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: sample, transform_length
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: linear_flow_type, suits

   !> Longest step over the time in which the fastest mesh vibrates by 1 rad.
   real(dp), parameter :: longest = 0.8_dp
   !> Number of segments of a period (flow_steps.c); fours of steps fill them.
   integer, parameter :: segments = 8
   integer, parameter :: least_samples = 1024
   !> A step costs the square of the number of elements, and flow_steps.c has room for so many.
   integer, parameter :: most_elements = 24

   type :: linear_flow_type
      !> Numbers of elements and of steps of a segment.
      integer :: elements = 0, steps = 0
      !> Length of a step, dimensionless time.
      real(dp) :: h = 0
      !> Element of each unknown mesh, (unknown).
      integer, allocatable :: element(:)
      !> Stiffness of the linear elements, 0 of unknown meshes, and damping, (element).
      real(dp), allocatable :: spring(:), damper(:)
      !> Velocity that a force on the second element takes from the first in a step, (element, element).
      real(dp), allocatable :: mass(:, :)
      !> Damping of each unknown mesh over twice the length of a step, (unknown).
      real(dp), allocatable :: drag(:)
      !> Stiffness along the motion, (sample, unknown); force on an unknown mesh, (sample).
      real(dp), allocatable :: wave(:, :), drive(:)
      !> The same, and border row as weights of the samples of y, (segment, step, unknown).
      real(dp), allocatable :: stiffness(:, :, :), row(:, :, :)
      !> Force by the right-hand side and by the border column, and the displacement y, (segment, step, unknown).
      real(dp), allocatable :: force(:, :, :), column_force(:, :, :), y(:, :, :)
      !> End state of a segment and entry in the border row per force on an unknown mesh at a step,
      !> (segment, 2*elements + 1, step, unknown); by the state at its beginning, (segment, 2*elements + 1, 2*elements).
      real(dp), allocatable :: influence(:, :, :, :), map(:, :, :)
      !> End states and entries in the border row by `column_force`, (segment, 2*elements + 1).
      real(dp), allocatable :: column_added(:, :)
      !> Factors of the equations of state at the beginning and the entry in the border row.
      real(dp), allocatable :: matrix(:, :)
      integer, allocatable :: pivot(:)
      !> Sign of the determinant of these equations.
      integer :: orientation = 1
      type(transform_type) :: transform
   contains
      procedure :: factor
      procedure :: solve
      procedure :: solve_tail
      procedure, private :: prepare
      procedure, private :: close_period
      procedure, private :: add_path
      procedure, private :: carry
      procedure, private :: carry_back
      procedure, private :: find_force
      procedure, private :: press
      procedure, private :: join
   end type linear_flow_type

   ! flow_steps.c
   interface
      pure subroutine transpose_steps(rows, columns, from, to) bind(c, name='geartrain_transpose')
         import :: c_double, c_int
         implicit none (type, external)
         integer(c_int), value :: rows, columns
         real(c_double), intent(in) :: from(*)
         real(c_double), intent(inout) :: to(*)
      end subroutine transpose_steps

      pure subroutine take_steps(elements, unknowns, steps, element, h, mass, spring, damper, stiffness, drive, p, v, y) &
         bind(c, name='geartrain_flow_steps')
         import :: c_double, c_int
         implicit none (type, external)
         integer(c_int), value :: elements, unknowns, steps
         real(c_double), value :: h
         integer(c_int), intent(in) :: element(*)
         real(c_double), intent(in), dimension(*) :: mass, spring, damper, stiffness, drive
         real(c_double), intent(inout), dimension(*) :: p, v, y
      end subroutine take_steps

      pure subroutine add_influence(states, steps, influence, force, added) bind(c, name='geartrain_add_influence')
         import :: c_double, c_int
         implicit none (type, external)
         integer(c_int), value :: states, steps
         real(c_double), intent(in), dimension(*) :: influence, force
         real(c_double), intent(inout), dimension(*) :: added
      end subroutine add_influence

      pure subroutine take_steps_back(elements, unknowns, steps, functionals, element, h, mass, spring, damper, stiffness, row, p, &
                                      v, force, influence) bind(c, name='geartrain_carry_back')
         import :: c_double, c_int
         implicit none (type, external)
         integer(c_int), value :: elements, unknowns, steps, functionals
         real(c_double), value :: h
         integer(c_int), intent(in) :: element(*)
         real(c_double), intent(in), dimension(*) :: mass, spring, damper, stiffness, row
         real(c_double), intent(inout), dimension(*) :: p, v, force, influence
      end subroutine take_steps_back
   end interface

contains

   !> Whether the flow is written for a train: no loops, no damping to ground, no damping that changes with the contact, few
   !> elements.
   pure logical function suits(system)
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
      real(dp) :: u(size(row, 1)), added(2*balance%system%elements + 1)
      integer :: i, info, n

      call self%prepare(balance)
      n = 2*self%elements
      do i = 1, balance%unknowns
         u = 2*row(:, i)
         u(1) = row(1, i)
         call sample(u, balance%harmonic, self%transform)
         self%transform%sample = self%transform%sample/self%transform%samples
         call transpose_steps(self%steps, segments, self%transform%sample, self%row(:, :, i))
      end do
      call self%carry_back()
      self%matrix = 0
      do i = 1, n
         added = 0
         added(i) = 1
         call self%join(added)
         self%matrix(:n, i) = -added(:n)
         self%matrix(n + 1, i) = added(n + 1)
         self%matrix(i, i) = self%matrix(i, i) + 1
      end do
      call self%find_force(balance, column, self%column_force, self%column_added)
      added = 0
      call self%join(added, self%column_added)
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
      real(dp) :: added(segments, 2*self%elements + 1)
      integer :: i

      call self%find_force(balance, x, self%force, added)
      y = y - sum(row(2:, :)*x(2:, :))
      call self%close_period(added, y)
      x = x - y*column
      x(1, :) = 0
      do i = 1, balance%unknowns
         call self%add_path(balance%harmonic, i, x(:, i))
      end do
   end subroutine solve

   !> Error of the balance to first order, by the residual at the harmonics of a tail: of all harmonics coupled, not of the carried
   !> ones alone.
   subroutine solve_tail(self, balance, column, harmonic, tail, x, y)
      class(linear_flow_type), intent(inout) :: self
      !> Balance as at `factor`.
      type(balance_type), intent(in) :: balance
      !> Border column as at `factor`.
      real(dp), intent(in) :: column(:, :)
      !> Harmonics of the tail.
      integer, intent(in) :: harmonic(:)
      !> Right-hand side at the tail, afterwards the solution as far as there are samples for the harmonic, (tail, unknown).
      complex(dp), intent(inout) :: tail(:, :)
      !> Solution at the carried harmonics, (block, unknown), and the entry in the border row.
      real(dp), intent(out) :: x(:, :), y
      real(dp) :: added(segments, 2*self%elements + 1)
      integer :: i, known

      known = count(harmonic < self%transform%samples/2)
      added = 0
      do i = 1, balance%unknowns
         associate (t => self%transform)
            t%coefficient = 0
            t%coefficient(harmonic(:known) + 1) = tail(:known, i)/2
            call t%to_samples()
         end associate
         call self%press(i, 0.0_dp, self%force(:, :, i), added)
      end do
      y = 0
      call self%close_period(added, y)
      x = -y*column
      x(1, :) = 0
      do i = 1, balance%unknowns
         call self%add_path(balance%harmonic, i, x(:, i))
         tail(:known, i) = tail(:known, i) + 2*self%transform%coefficient(harmonic(:known) + 1)
      end do
   end subroutine solve_tail

   !> Adds the coefficients of the displacement y of an unknown mesh, which are in `transform` afterwards.
   subroutine add_path(self, harmonic, i, x)
      class(linear_flow_type), intent(inout) :: self
      integer, intent(in) :: harmonic(:), i
      real(dp), intent(inout) :: x(:)
      integer :: k

      associate (t => self%transform)
         call transpose_steps(segments, self%steps, self%y(:, :, i), t%sample)
         t%sample = t%sample/t%samples
         call t%to_coefficients()
         x(1) = x(1) + t%coefficient(1)%re
         do k = 1, size(harmonic)
            x(2*k) = x(2*k) + 2*t%coefficient(harmonic(k) + 1)%re
            x(2*k + 1) = x(2*k + 1) - 2*t%coefficient(harmonic(k) + 1)%im
         end do
      end associate
   end subroutine add_path

   !> Finds the displacement under `force` that the period brings back to itself.
   subroutine close_period(self, added, y)
      class(linear_flow_type), intent(inout) :: self
      !> What the force adds in each segment, (segment, 2*elements + 1).
      real(dp), intent(inout) :: added(:, :)
      !> Right-hand side of the border row without the part of `force`, afterwards the multiple of the border column.
      real(dp), intent(inout) :: y
      real(dp) :: b(2*self%elements + 1, 1)
      integer :: n

      n = 2*self%elements
      b = 0
      call self%join(b(:, 1), added)
      b(n + 1, 1) = y - b(n + 1, 1)
      call solve_factored(n + 1, 1, self%matrix, self%pivot, b)
      y = b(n + 1, 1)
      self%force = self%force - y*self%column_force
      added = added - y*self%column_added
      call self%carry(b(:n, 1), added)
   end subroutine close_period

   !> Chooses the steps and finds what they need. Steps of finite length change frequency and decay of a vibration: `mass` corrects
   !> the frequencies of the train in contact, `damper` the decay of each element vibrating alone.
   subroutine prepare(self, balance)
      class(linear_flow_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      real(dp) :: fastest, period, decay, omega
      integer :: i, n, samples

      associate (system => balance%system, e => balance%system%elements, u => balance%unknowns)
         self%elements = e
         self%element = system%cut%element
         period = 2*pi*balance%eta/balance%frequency_ratio
         fastest = 0
         do i = 1, u
            fastest = max(fastest, sqrt(system%own(self%element(i))*balance%contact(i)%law%stiffest()))
         end do
         samples = max(transform_length(max(4*balance%highest + 2, ceiling(period*fastest/longest))), least_samples)
         if (self%transform%samples /= samples .or. .not. allocated(self%force)) then
            call self%transform%plan(samples)
            self%steps = samples/segments
            if (allocated(self%force)) deallocate (self%wave, self%drive, self%force, self%column_force, self%y, self%stiffness, &
                                                   self%row, self%influence)
            allocate (self%wave(samples, u), self%drive(samples), self%influence(segments, 2*e + 1, self%steps, u))
            allocate (self%force(segments, self%steps, u), self%column_force(segments, self%steps, u), &
                      self%y(segments, self%steps, u), self%stiffness(segments, self%steps, u), self%row(segments, self%steps, u))
         end if
         if (.not. allocated(self%matrix)) then
            allocate (self%spring(e), self%damper(e), self%matrix(2*e + 1, 2*e + 1), self%pivot(2*e + 1))
            allocate (self%map(segments, 2*e + 1, 2*e), self%column_added(segments, 2*e + 1))
         end if
         self%h = period/samples
         self%mass = mass_of_steps(system, self%h)
         self%spring = system%spring
         do n = 1, e
            decay = system%own(n)*system%damping(n)*self%h
            omega = sqrt(system%own(n)*system%spring(n))*self%h
            self%damper(n) = (1 - exp(-decay))/(system%own(n)*self%h)
            if (omega > 0) self%damper(n) = self%damper(n)*omega**2/(2 - 2*cos(omega))*exp(decay/2)
         end do
         self%drag = system%damping(self%element)/(2*self%h)
         do i = 1, u
            self%spring(self%element(i)) = 0
            call find_wave(balance%harmonic, balance%contact(i)%spectra%stiffness, self%transform, self%wave(:, i))
            call transpose_steps(self%steps, segments, self%wave(:, i), self%stiffness(:, :, i))
         end do
      end associate
   end subroutine prepare

   !> Velocity that forces take in a step: h W for infinitely small steps, and such that the modes of the train in contact keep
   !> their frequencies: 2 - 2 cos(h omega) in place of (h omega)**2, by its power series.
   pure function mass_of_steps(system, h) result(mass)
      type(system_type), intent(in) :: system
      real(dp), intent(in) :: h
      real(dp), dimension(system%elements, system%elements) :: mass, w, stiff, drag, term
      integer, parameter :: terms = 12
      integer :: j, k, n

      w = 0
      do n = 1, system%elements
         w(n, n) = system%own(n)
         do k = system%first(n), system%first(n + 1) - 1
            w(n, system%neighbour(k)) = w(n, system%neighbour(k)) + system%coupling(k)
         end do
      end do
      do n = 1, system%elements
         stiff(n, :) = h**2*system%spring(n)*w(n, :)
         drag(:, n) = h/2*w(:, n)*system%damping(n)
      end do
      term = h*w
      mass = term
      do j = 0, terms
         term = -matmul(term, stiff)/((2*j + 3)*(2*j + 4))
         mass = mass + term
      end do
      ! Damping acts by the velocity half a step before.
      mass = mass - matmul(drag, mass - matmul(drag, mass)/2)
   end function mass_of_steps

   !> Force on the unknown meshes by the waveform of coefficients without their means, less the means.
   subroutine find_force(self, balance, x, force, added)
      class(linear_flow_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: x(:, :)
      !> Force at each step, (segment, step, unknown).
      real(dp), intent(inout) :: force(:, :, :)
      !> What it adds to the end state of each segment and to the entry in the border row, (segment, 2*elements + 1).
      real(dp), intent(out) :: added(:, :)
      real(dp) :: u(size(x, 1))
      integer :: i

      added = 0
      do i = 1, size(x, 2)
         u = x(:, i)
         u(1) = 0
         call sample(u, balance%harmonic, self%transform)
         call self%press(i, x(1, i), force(:, :, i), added)
      end do
   end subroutine find_force

   !> Force on an unknown mesh by the waveform in `transform`, less a mean.
   subroutine press(self, i, mean, force, added)
      class(linear_flow_type), intent(inout) :: self
      integer, intent(in) :: i
      real(dp), intent(in) :: mean
      real(dp), intent(inout) :: force(:, :), added(:, :)
      integer :: n

      n = self%transform%samples
      associate (rho => self%transform%sample, drive => self%drive)
         drive(2:n - 1) = self%wave(2:n - 1, i)*rho(2:n - 1) - mean + self%drag(i)*(rho(3:) - rho(:n - 2))
         drive(1) = self%wave(1, i)*rho(1) - mean + self%drag(i)*(rho(2) - rho(n))
         drive(n) = self%wave(n, i)*rho(n) - mean + self%drag(i)*(rho(1) - rho(n - 1))
      end associate
      call transpose_steps(self%steps, segments, self%drive, force)
      call add_influence(2*self%elements + 1, self%steps, self%influence(:, :, :, i), force, added)
   end subroutine press

   !> State at the end of the period and entry in the border row, from the state at its beginning and what forces add.
   pure subroutine join(self, state, added, start)
      class(linear_flow_type), intent(in) :: self
      !> Displacements, velocities, entry in the border row, (2*elements + 1).
      real(dp), intent(inout) :: state(:)
      !> What forces add in each segment, (segment, 2*elements + 1); 0 unless they are given.
      real(dp), intent(in), optional :: added(:, :)
      !> State at the beginning of each segment, (segment, 2*elements).
      real(dp), intent(out), optional :: start(:, :)
      real(dp) :: before
      integer :: j, n

      n = 2*self%elements
      do j = 1, segments
         if (present(start)) start(j, :) = state(:n)
         before = state(n + 1)
         state = matmul(self%map(j, :, :), state(:n))
         state(n + 1) = state(n + 1) + before
         if (present(added)) state = state + added(j, :)
      end do
   end subroutine join

   !> Finds y under `force`, from a state at the beginning.
   subroutine carry(self, state, added)
      class(linear_flow_type), intent(inout) :: self
      !> Displacements, then velocities, (2*elements); what the force adds in each segment, (segment, 2*elements + 1).
      real(dp), intent(in) :: state(:), added(:, :)
      real(dp) :: start(segments, 2*self%elements), joined(2*self%elements + 1)

      joined = [state, 0.0_dp]
      call self%join(joined, added, start)
      associate (e => self%elements)
         call take_steps(e, size(self%element), self%steps, self%element, self%h, self%mass, self%spring, self%damper, &
                         self%stiffness, self%force, start(:, :e), start(:, e + 1:), self%y)
      end associate
   end subroutine carry

   !> Carries the functionals that give the end state of a segment and the entry in the border row back over the segment, and keeps
   !> what a force on an unknown mesh at any step and the state at the beginning add to them.
   subroutine carry_back(self)
      class(linear_flow_type), intent(inout) :: self
      real(dp), dimension(segments, 2*self%elements + 1, self%elements) :: p, v, force
      integer :: n

      associate (e => self%elements)
         p = 0
         v = 0
         do n = 1, e
            p(:, n, n) = 1
            v(:, e + n, n) = 1
         end do
         call take_steps_back(e, size(self%element), self%steps, 2*e + 1, self%element, self%h, self%mass, self%spring, &
                              self%damper, self%stiffness, self%row, p, v, force, self%influence)
         self%map(:, :, :e) = p
         self%map(:, :, e + 1:) = v
      end associate
   end subroutine carry_back

end module geartrain_balance_linear_flow
