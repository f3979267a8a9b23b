!> The free vibrations of a train that take longer to die out than one wants to wait for them: read from the flow, and taken out of
!> its state.
!>
!> In the mean system (every mesh on the flank of its mean load, at its mean stiffness) a mode with the eigenvalue lambda is a
!> coordinate q of the state that goes as a exp(lambda t) beside what the excitation makes of it. The excitation is much faster
!> than a slow mode. So the mean of q exp(-lambda t) over some cycles of the mode, with a weight that is 0 at their ends (Hann's),
!> is a. The state less the mode's share a is that of a train in which the mode has died out, but for what the mean system leaves
!> out; the next reading tells how good that was.
!>
!> Where the excitation comes near to the frequency of a mode, a is what it drives. Two readings tell: from one to the next a free
!> vibration changes by exp(lambda T), and once taken out it does not come back. What is driven stays.
module geartrain_flow_slow_modes
   use geartrain_base_kinds, only: dp, pi
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_start_state, only: resting_state
   use geartrain_linalg_lapack, only: dgeev, dgetrf, dgetrs
   use geartrain_network_natural_modes, only: state_matrix
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: slow_modes_type, stretches

   !> Share to which a free vibration must have fallen where one waits for it [1].
   real(dp), parameter :: died_out = 1e-4_dp
   !> Stretches of the time to settle; a slow mode is read and taken out at the end of each.
   integer, parameter :: stretches = 4
   !> Cycles of the slowest mode in a stretch; fewest cycles from which a mode is read.
   integer, parameter :: cycles = 4, fewest_cycles = 3
   !> Most states of a train whose modes are looked at: beyond, all eigenvectors take seconds.
   integer, parameter :: most_states = 300
   !> Largest deviation of a free vibration from what was expected of it, over its amplitude, or that before it was taken out [1].
   real(dp), parameter :: as_expected = 0.3_dp
   !> Nodes and weights of Gauss's quadrature over a step, which has less than a cycle of the fastest vibration, from 0 to 1.
   real(dp), parameter :: nodes(3) = [0.5_dp - sqrt(0.15_dp), 0.5_dp, 0.5_dp + sqrt(0.15_dp)]
   real(dp), parameter :: weights(3) = [5/18.0_dp, 8/18.0_dp, 5/18.0_dp]

   type :: slow_modes_type
      !> Time to settle [1]; number of slow modes.
      real(dp) :: time = 0
      integer :: count = 0
      !> Some mode neither dies out within the time to settle nor can be read.
      logical :: unread = .false.
      !> Amplitude of each slow mode at the end of the reading [1], (mode).
      complex(dp), allocatable :: amplitude(:)
      !> Eigenvalue lambda of each slow mode [1], (mode).
      complex(dp), allocatable, private :: rate(:)
      !> Share of a mode in a state: 2 Re(shape a), (state, mode). Amplitude of a state: reader x, (mode, state).
      complex(dp), allocatable, private :: shape(:, :), reader(:, :)
      !> Amplitude at rest under the mean load [1], (mode).
      complex(dp), allocatable, private :: resting(:)
      !> Amplitude at the reading before [1], (mode), not allocated before the first; whether it was then taken out, (mode).
      complex(dp), allocatable, private :: before(:)
      logical, allocatable, private :: taken(:)
      !> Amplitude of the free vibration at the latest reading, before it was taken out [1], (mode).
      real(dp), allocatable, private :: left(:)
      !> Begin of the reading and its end [1], (mode).
      real(dp), allocatable, private :: begin(:)
      real(dp), private :: end = 0
   contains
      procedure :: setup
      procedure :: begin_reading
      procedure :: read_step
      procedure :: take_out
      procedure :: ringing
   end type slow_modes_type

contains

   !> Finds the time to settle and the modes that do not die out within it.
   subroutine setup(self, system, shortest, longest)
      class(slow_modes_type), intent(out) :: self
      type(system_type), intent(in) :: system
      !> Limits of the time to settle [1].
      real(dp), intent(in) :: shortest, longest
      real(dp), allocatable :: matrix(:, :), vector(:, :), inverse(:, :), wr(:), wi(:), work(:), none(:, :)
      real(dp), allocatable :: wait(:), read(:)
      integer, allocatable :: exchange(:), slow(:)
      logical, allocatable :: is_slow(:)
      integer :: n, i, info

      n = system%states
      self%time = longest
      allocate (self%amplitude(0), self%rate(0), self%shape(n, 0), self%reader(0, n), self%resting(0), self%left(0), &
                self%taken(0), self%begin(0))
      self%unread = .true.
      if (n > most_states) return
      matrix = state_matrix(system)
      if (any(system%friction > 0)) then
         self%time = longest_wait(matrix)
         call stick(system, matrix)
         self%time = min(longest, max(shortest, self%time, longest_wait(matrix)))
         self%unread = .false.
         return
      end if
      allocate (vector(n, n), inverse(n, n), wr(n), wi(n), work(16*n), none(1, 1), exchange(n))
      call dgeev('N', 'V', n, matrix, n, wr, wi, none, 1, vector, n, work, size(work), info)
      if (info /= 0) return
      matrix = vector
      inverse = 0
      do i = 1, n
         inverse(i, i) = 1
      end do
      call dgetrf(n, n, matrix, n, exchange, info)
      if (info /= 0) return
      call dgetrs('N', n, n, matrix, n, exchange, inverse, n, info)
      ! Only of a vibration, not of the drift against damping to ground, which rest leaves at 0.
      is_slow = wi > 0
      wait = wait_for(wr)
      read = stretches*cycles*2*pi/max(abs(wi), tiny(1.0_dp)/epsilon(1.0_dp))
      self%time = min(longest, max(shortest, maxval(min(wait, read), is_slow)))
      is_slow = is_slow .and. wait > self%time
      self%unread = any(is_slow .and. wi*self%time < 2*pi*fewest_cycles*stretches*(1 - 1e-9_dp))
      slow = pack([(i, i=1, n)], is_slow .and. wi*self%time >= 2*pi*fewest_cycles*stretches*(1 - 1e-9_dp))
      self%count = size(slow)
      ! The real vectors u and v of a pair of eigenvalues make the eigenvector u + i v; x = alpha u + beta v is 2 Re(a (u + i v))
      ! with a = (alpha - i beta)/2.
      self%rate = cmplx(wr(slow), wi(slow), dp)
      self%shape = cmplx(vector(:, slow), vector(:, slow + 1), dp)
      self%reader = cmplx(inverse(slow, :), -inverse(slow + 1, :), dp)/2
      self%resting = matmul(self%reader, resting_state(system))
      deallocate (self%amplitude, self%left, self%taken, self%begin)
      allocate (self%amplitude(size(slow)), source=(0.0_dp, 0.0_dp))
      allocate (self%left(size(slow)), self%begin(size(slow)), source=0.0_dp)
      allocate (self%taken(size(slow)), source=.false.)
   end subroutine setup

   !> Time in which a free vibration dies out [1].
   elemental real(dp) function wait_for(rate)
      !> Real part of its eigenvalue [1].
      real(dp), intent(in) :: rate

      wait_for = -log(died_out)/max(-rate, tiny(1.0_dp)/epsilon(1.0_dp))
   end function wait_for

   !> Time in which all free vibrations die out [1].
   real(dp) function longest_wait(matrix)
      !> Matrix of the equations of motion [1], (state, state).
      real(dp), intent(in) :: matrix(:, :)
      real(dp) :: copy(size(matrix, 1), size(matrix, 1)), none(1, 1), work(16*size(matrix, 1))
      real(dp), dimension(size(matrix, 1)) :: wr, wi
      integer :: info

      copy = matrix
      call dgeev('N', 'N', size(wr), copy, size(wr), wr, wi, none, 1, none, 1, work, size(work), info)
      longest_wait = huge(1.0_dp)
      if (info == 0) longest_wait = maxval(wait_for(wr), wi > 0)
   end function longest_wait

   !> Lets the couplings with dry friction that are coordinates stick: a torque on each keeps its velocity as it is.
   pure subroutine stick(system, matrix)
      type(system_type), intent(in) :: system
      !> Matrix of the equations of motion [1], (state, state).
      real(dp), intent(inout) :: matrix(:, :)
      real(dp) :: reaction(size(matrix, 1)), row(size(matrix, 1))
      integer :: i, j

      do j = 1, system%meshes
         associate (n => system%mesh_element(j), v => system%displacements + system%mesh_element(j))
            if (.not. system%friction(j) > 0 .or. n > system%displacements) cycle
            ! What a twist accelerates, a torque accelerates.
            reaction = matrix(:, n)
            if (.not. abs(reaction(v)) > 0) cycle
            row = matrix(v, :)/reaction(v)
            do i = 1, size(row)
               matrix(:, i) = matrix(:, i) - reaction*row(i)
            end do
         end associate
      end do
   end subroutine stick

   !> Begins to read the slow modes over a flight: each over the last whole cycles of the mode.
   subroutine begin_reading(self, begin, end)
      class(slow_modes_type), intent(inout) :: self
      !> Times between which the flight is [1].
      real(dp), intent(in) :: begin, end

      self%amplitude = 0
      self%end = end
      self%begin = end - 2*pi/self%rate%im*max(1, int((end - begin)*self%rate%im/(2*pi)*(1 + 1e-9_dp)))
   end subroutine begin_reading

   !> Reads the latest step of a flow.
   subroutine read_step(self, flow)
      class(slow_modes_type), intent(inout) :: self
      !> The flow after the step.
      type(flow_type), intent(in) :: flow
      complex(dp) :: series(0:flow%order), value
      real(dp) :: begun, tau, place
      integer :: m, i, k

      begun = flow%time - flow%length
      associate (d => flow%system%displacements, c => flow%system%coordinates)
         do m = 1, self%count
            if (flow%time <= self%begin(m)) cycle
            series = 0
            do k = 0, flow%order
               series(k) = sum(self%reader(m, :d)*flow%p(1, :d, k)) + sum(self%reader(m, d + 1:)*flow%v(1, :c, k))
            end do
            series(0) = series(0) - self%resting(m)
            do i = 1, size(nodes)
               tau = nodes(i)*flow%length
               place = (begun + tau - self%begin(m))/(self%end - self%begin(m))
               if (place <= 0) cycle
               value = series(flow%order)
               do k = flow%order - 1, 0, -1
                  value = value*tau + series(k)
               end do
               self%amplitude(m) = self%amplitude(m) + weights(i)*flow%length*(1 - cos(2*pi*place)) &
                                   *exp(-self%rate(m)*(begun + tau - self%end))*value/(self%end - self%begin(m))
            end do
         end do
      end associate
   end subroutine read_step

   !> Takes the free vibrations out of the state at the end of a reading, the second or a later one.
   subroutine take_out(self, state)
      class(slow_modes_type), intent(inout) :: self
      !> State [1], (state).
      real(dp), intent(inout) :: state(:)
      logical :: free
      integer :: m

      if (.not. allocated(self%before)) then
         self%before = self%amplitude
         self%left = abs(self%amplitude)
         return
      end if
      do m = 1, self%count
         associate (now => self%amplitude(m), before => self%before(m))
            if (self%taken(m)) then
               free = abs(now) < as_expected*abs(before)
               self%left(m) = abs(now)
            else
               free = abs(now - before*exp(self%rate(m)*self%time/stretches)) < as_expected*abs(now)
               ! Of a driven vibration the free part is what makes its amplitude change.
               self%left(m) = merge(abs(now), abs(abs(now) - abs(before)), free)
            end if
            if (free) state = state - 2*real(self%shape(:, m)*now, dp)
            self%taken(m) = free
            before = now
         end associate
      end do
   end subroutine take_out

   !> Amplitude of each mesh displacement in the free vibrations as they were read last [1], (mesh).
   pure function ringing(self, system) result(amplitude)
      class(slow_modes_type), intent(in) :: self
      type(system_type), intent(in) :: system
      real(dp) :: amplitude(system%meshes)
      complex(dp) :: moved
      integer :: j, m

      amplitude = 0
      associate (d => system%displacements, c => system%coordinates)
         do m = 1, self%count
            do j = 1, system%meshes
               associate (n => system%mesh_element(j))
                  if (n <= d) then
                     moved = self%shape(n, m)
                  else
                     moved = sum(system%network%loop(n - c, :d)*self%shape(:d, m))
                  end if
               end associate
               amplitude(j) = amplitude(j) + 2*abs(moved)*self%left(m)
            end do
         end do
      end associate
   end function ringing

end module geartrain_flow_slow_modes
