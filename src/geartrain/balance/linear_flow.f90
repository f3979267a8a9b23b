!> Approximate solution of the linearised balance of many harmonics in time: the flow of the linearised train over the period, in
!> equal steps, and the state that it brings back to itself.
!>
!> With rho the waveform of the right-hand side without its mean, the solution is y + rho, where y is the displacement of the
!> meshes of a train whose unknown meshes have the force w(t) (y + rho) + gamma (y + rho)' less the mean of the right-hand side, w
!> the stiffness along the motion. Exact for all harmonics and infinitely small steps, so as preconditioner of GMRES it leaves
!> what the carried harmonics and the steps differ from that. Harmonics up to the natural frequencies of the meshes are coupled
!> strongly where teeth separate; eliminated together they would cost the cube of their number, here they cost their number.
!>
!> All elements take the steps, also elements that close loops: they begin as the coordinates demand and stay so.
module geartrain_balance_linear_flow
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_fixed_space, only: mean_equations
   use geartrain_balance_flow_steps, only: add_influence, mass_of_steps, take_steps, take_steps_back, transpose_steps
   use geartrain_balance_products, only: find_wave
   use geartrain_base_kinds, only: dp, pi
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: sample, transform_length
   implicit none (type, external)
   private
   public :: linear_flow_type

   !> Longest step over the time in which the fastest mesh vibrates by 1 rad.
   real(dp), parameter :: longest = 0.8_dp
   !> Number of segments of a period (flow_steps.c); fours of steps fill them.
   integer, parameter :: segments = 8
   integer, parameter :: least_samples = 1024

   type :: linear_flow_type
      !> Numbers of elements, of coordinates and of steps of a segment.
      integer :: elements = 0, coordinates = 0, steps = 0
      !> Displacement of each element that closes a loop by the coordinates, (loop, coordinate).
      real(dp), allocatable :: loop(:, :)
      !> Where meshes close loops, displacements and forces of the meshes with their mean stiffness by the equations of the mean,
      !> (unknown, equation); else the equations are those of the forces.
      real(dp), allocatable :: inverse(:, :)
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
      !> End states and entries in the border row by `column_force`, (segment, 2*elements + 1), and mean displacements that go with
      !> this force, (unknown).
      real(dp), allocatable :: column_added(:, :), column_offset(:)
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
      procedure, private :: whole
      procedure, private :: part
      procedure, private :: add_path
      procedure, private :: carry
      procedure, private :: carry_back
      procedure, private :: find_force
      procedure, private :: press
      procedure, private :: join
   end type linear_flow_type

contains

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
      integer :: i, info, k, n

      call self%prepare(balance)
      n = 2*self%coordinates
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
         added = self%whole([(merge(1.0_dp, 0.0_dp, k == i), k=1, n)])
         call self%join(added)
         self%matrix(:, i) = self%part(added)*[(-1.0_dp, k=1, n), 1.0_dp]
         self%matrix(i, i) = self%matrix(i, i) + 1
      end do
      call self%find_force(balance, column, self%column_force, self%column_added, self%column_offset)
      added = 0
      call self%join(added, self%column_added)
      self%matrix(:, n + 1) = self%part(added)
      self%matrix(n + 1, n + 1) = corner - self%matrix(n + 1, n + 1) - border_entry(row, column, self%column_offset)
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
      real(dp) :: added(segments, 2*self%elements + 1), offset(balance%unknowns)
      integer :: i

      call self%find_force(balance, x, self%force, added, offset)
      y = y - border_entry(row, x, offset)
      call self%close_period(added, y)
      x = x - y*column
      x(1, :) = offset - y*self%column_offset
      do i = 1, balance%unknowns
         call self%add_path(balance%harmonic, i, x(:, i))
      end do
   end subroutine solve

   !> Entry in the border row by a waveform with other means.
   pure real(dp) function border_entry(row, x, means)
      !> Border row and coefficients, (block, unknown).
      real(dp), intent(in) :: row(:, :), x(:, :)
      !> The means, (unknown).
      real(dp), intent(in) :: means(:)

      border_entry = sum(row(2:, :)*x(2:, :)) + sum(row(1, :)*means)
   end function border_entry

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
      x(1, :) = -y*self%column_offset
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
      real(dp) :: b(2*self%coordinates + 1, 1), end_(2*self%elements + 1)
      integer :: n

      n = 2*self%coordinates
      end_ = 0
      call self%join(end_, added)
      b(:, 1) = self%part(end_)
      b(n + 1, 1) = y - b(n + 1, 1)
      call solve_factored(n + 1, 1, self%matrix, self%pivot, b)
      y = b(n + 1, 1)
      self%force = self%force - y*self%column_force
      added = added - y*self%column_added
      end_ = self%whole(b(:n, 1))
      call self%carry(end_(:2*self%elements), added)
   end subroutine close_period

   !> State of all elements, and 0 for the entry in the border row, (2*elements + 1).
   pure function whole(self, state)
      class(linear_flow_type), intent(in) :: self
      !> State of the coordinates, (2*coordinates).
      real(dp), intent(in) :: state(:)
      real(dp) :: whole(2*self%elements + 1)

      whole = 0
      associate (c => self%coordinates, e => self%elements)
         whole(:c) = state(:c)
         whole(c + 1:e) = matmul(self%loop, state(:c))
         whole(e + 1:e + c) = state(c + 1:)
         whole(e + c + 1:2*e) = matmul(self%loop, state(c + 1:))
      end associate
   end function whole

   !> State of the coordinates and entry in the border row, (2*coordinates + 1).
   pure function part(self, state)
      class(linear_flow_type), intent(in) :: self
      !> State of all elements and the entry, (2*elements + 1).
      real(dp), intent(in) :: state(:)
      real(dp) :: part(2*self%coordinates + 1)

      associate (c => self%coordinates, e => self%elements)
         part = [state(:c), state(e + 1:e + c), state(2*e + 1)]
      end associate
   end function part

   !> Chooses the steps and finds what they need. Steps of finite length change frequency and decay of a vibration: `mass` corrects
   !> the frequencies of the train in contact, `damper` the decay of each element vibrating alone.
   subroutine prepare(self, balance)
      class(linear_flow_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      real(dp), allocatable :: mean(:, :)
      real(dp) :: fastest, period, decay, omega
      integer :: i, n, samples

      associate (system => balance%system, e => balance%system%elements, u => balance%unknowns)
         self%elements = e
         self%coordinates = system%coordinates
         self%element = system%cut%element
         self%loop = system%network%loop
         if (size(system%mean%closing) > 0) call mean_equations(system, mean, self%inverse)
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
            allocate (self%spring(e), self%damper(e), self%pivot(2*self%coordinates + 1))
            allocate (self%matrix(2*self%coordinates + 1, 2*self%coordinates + 1))
            allocate (self%map(segments, 2*e + 1, 2*e), self%column_added(segments, 2*e + 1), self%column_offset(u))
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

   !> Force on the unknown meshes by the waveform of coefficients with other means, less the mean forces that belong to them: both
   !> satisfy the equations of the mean.
   subroutine find_force(self, balance, x, force, added, means)
      class(linear_flow_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: x(:, :)
      !> Force at each step, (segment, step, unknown).
      real(dp), intent(inout) :: force(:, :, :)
      !> What it adds to the end state of each segment and to the entry in the border row, (segment, 2*elements + 1).
      real(dp), intent(out) :: added(:, :)
      !> The means, (unknown).
      real(dp), intent(out) :: means(:)
      real(dp) :: u(size(x, 1)), mean_force(size(means))
      integer :: i

      means = 0
      mean_force = x(1, :)
      if (allocated(self%inverse)) then
         means = matmul(self%inverse, x(1, :))
         mean_force = means
      end if
      added = 0
      do i = 1, size(x, 2)
         u = x(:, i)
         u(1) = means(i)
         call sample(u, balance%harmonic, self%transform)
         call self%press(i, mean_force(i), force(:, :, i), added)
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
