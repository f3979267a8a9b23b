!> Whether the state of a flow at phase 0 will go to a known attracting orbit, told from the state alone: a ball about each of the
!> orbit's states.
!>
!> A distance d from the state becomes M d + e over a period of the orbit (M: monodromy matrix). With the weight Q = sum over k of
!> M^k' M^k the Lyapunov function v = d'Q d falls by |d|^2 where e = 0. Where v falls by at least half of it everywhere on the ball
!> v <= r^2, no flow leaves the ball and v goes to 0. The fall is measured by flights from many points of many nested shells, and a
!> ball of half the radius is used.
!>
!> Without tables (geartrain_flow_section_map) the flights that measure a ball take longer than those it would shorten, the more so
!> where slow modes make the ball small. The orbit is then handed on as an `attraction_type`, and flights are watched.
module geartrain_flow_recognition
   use geartrain_base_kinds, only: dp
   use geartrain_base_random, only: begin_random, generator_type
   use geartrain_floquet_multipliers, only: eigenvalues, is_stable
   use geartrain_flow_attraction, only: attraction_type
   use geartrain_flow_energy, only: energy_type
   use geartrain_flow_section_map, only: section_map_type
   use geartrain_flow_shooting, only: find_orbit
   use geartrain_flow_tangent_flight, only: tangent_flight_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: recognition_type

   !> Least fall of v over the predicted fall.
   real(dp), parameter :: least_fall = 0.5_dp
   !> Shells of a ball, radii over that of the ball; random directions of a shell for each state.
   real(dp), parameter :: shells(7) = [1.0_dp, 0.8_dp, 0.6_dp, 0.4_dp, 0.2_dp, 0.1_dp, 0.03_dp]
   integer, parameter :: directions = 12
   !> Most halvings of the first radius, which is the size of the orbit's state; radius used over radius measured.
   integer, parameter :: halvings = 24
   real(dp), parameter :: used = 0.5_dp
   !> Most Newton steps towards the orbit.
   integer, parameter :: most_steps = 7

   type :: recognition_type
      !> Period of the orbit [periods of the fundamental]; 0: no orbit is known, or it does not attract.
      integer :: period = 0
      !> States of the orbit at phase 0 of each period of the fundamental [1], (state, period).
      real(dp), allocatable :: states(:, :)
      !> Radii of the balls as lengths weight*d, (period).
      real(dp), allocatable :: radius(:)
      !> In place of the balls, of a train without tables.
      type(attraction_type), allocatable :: attraction
      !> Factors of Q: v = |weight d|^2, (state, state, period).
      real(dp), allocatable, private :: weight(:, :, :)
   contains
      procedure :: setup
      procedure :: holds
   end type recognition_type

contains

   !> Finds the balls of an orbit.
   subroutine setup(self, system, map, period, state)
      class(recognition_type), intent(out) :: self
      type(system_type), target, intent(in) :: system
      !> The map from section to section.
      type(section_map_type), intent(in) :: map
      !> Period of the orbit [periods of the fundamental]; 0: there is no orbit.
      integer, intent(in) :: period
      !> A state near the orbit at phase 0 [1], (state).
      real(dp), intent(in) :: state(:)
      type(energy_type) :: energy
      complex(dp) :: multipliers(size(state))
      real(dp) :: monodromy(size(state), size(state)), now(size(state)), to_energy(size(state), size(state)), length
      type(tangent_flight_type) :: flight
      integer :: i, j
      logical :: found, lost

      if (period == 0) return
      now = state
      call flight%setup(system)
      call find_orbit(flight, map%frequency_ratio, period, most_steps, now, monodromy, length, found)
      if (.not. found) return
      if (map%intervals == 0) then
         allocate (self%attraction)
         call self%attraction%setup(system, map%frequency_ratio, period, now, monodromy, length)
         if (self%attraction%period == 0) deallocate (self%attraction)
         if (allocated(self%attraction)) self%period = period
         return
      end if
      call eigenvalues(monodromy, multipliers)
      if (.not. is_stable(multipliers)) return
      call energy%setup(system)
      do i = 1, size(state)
         to_energy(:, i) = energy%coordinates([(merge(1.0_dp, 0.0_dp, j == i), j=1, size(state))])
      end do
      allocate (self%states(size(state), period), self%radius(period), self%weight(size(state), size(state), period))
      lost = .false.
      do i = 1, period
         self%states(:, i) = now
         call find_ball(self, energy, to_energy, map, period, i)
         call map%pass_period(now, lost)
      end do
      if (.not. lost) self%period = period
   end subroutine setup

   !> Finds the weight and the radius of the ball about state i.
   subroutine find_ball(self, energy, to_energy, map, period, i)
      class(recognition_type), intent(inout) :: self
      type(energy_type), intent(in) :: energy
      !> Matrix of the energy coordinates, (state, state).
      real(dp), intent(in) :: to_energy(:, :)
      type(section_map_type), intent(in) :: map
      integer, intent(in) :: period, i
      real(dp), dimension(size(to_energy, 1), size(to_energy, 1)) :: tangents, power, q, inverse
      real(dp) :: state(size(to_energy, 1)), unit(size(to_energy, 1), directions*size(to_energy, 1))
      real(dp) :: norm
      type(generator_type) :: generator
      integer :: n, k, l
      logical :: lost, falls

      n = size(state)
      self%radius(i) = 0
      self%weight(:, :, i) = 0
      tangents = 0
      do k = 1, n
         tangents(k, k) = 1
      end do
      q = tangents
      state = self%states(:, i)
      lost = .false.
      do k = 1, period
         call map%pass_period(state, lost, tangents)
      end do
      power = energy%transform(tangents)
      do k = 1, 64
         q = q + matmul(transpose(power), matmul(q, power))
         power = matmul(power, power)
         if (maxval(abs(power)) < 1e-9_dp) exit
      end do
      call factor(q)
      self%weight(:, :, i) = matmul(q, to_energy)
      ! Directions on the unit shell, as differences of states: weight*unit has length 1.
      generator = begin_random(period, i)
      do k = 1, n
         do l = 1, n
            inverse(l, k) = merge(1.0_dp, 0.0_dp, l == k)
         end do
         ! The triangular factor, solved backwards.
         do l = n, 1, -1
            inverse(l, k) = (inverse(l, k) - dot_product(q(l, l + 1:), inverse(l + 1:, k)))/q(l, l)
         end do
      end do
      do k = 1, size(unit, 2)
         do
            do l = 1, n
               state(l) = 2*generator%uniform() - 1
            end do
            norm = norm2(state)
            if (norm > 0.1_dp .and. norm < 1) exit
         end do
         unit(:, k) = energy%state(matmul(inverse, state/norm))
      end do
      norm = norm2(matmul(self%weight(:, :, i), self%states(:, i)))
      do k = 0, halvings
         call measure_fall(self, to_energy, map, period, i, norm/2**k, unit, falls)
         if (falls) then
            self%radius(i) = used*norm/2**k
            return
         end if
      end do
   end subroutine find_ball

   !> Cholesky's factor of a matrix q = r'r, upper triangular; q is at least the identity.
   pure subroutine factor(q)
      real(dp), intent(inout) :: q(:, :)
      integer :: k, l

      do k = 1, size(q, 1)
         do l = 1, k - 1
            q(l, k) = (q(l, k) - dot_product(q(:l - 1, l), q(:l - 1, k)))/q(l, l)
         end do
         q(k, k) = sqrt(q(k, k) - sum(q(:k - 1, k)**2))
         q(k + 1:, k) = 0
      end do
   end subroutine factor

   !> Whether v falls as it must on all shells of a ball about state i.
   subroutine measure_fall(self, to_energy, map, period, i, radius, unit, falls)
      class(recognition_type), intent(in) :: self
      real(dp), intent(in) :: to_energy(:, :)
      type(section_map_type), intent(in) :: map
      integer, intent(in) :: period, i
      real(dp), intent(in) :: radius
      !> Differences of states of length 1, (state, direction).
      real(dp), intent(in) :: unit(:, :)
      logical, intent(out) :: falls
      real(dp) :: state(size(unit, 1)), length
      integer :: k, l, s, side
      logical :: lost

      falls = .false.
      lost = .false.
      do s = 1, size(shells)
         length = shells(s)*radius
         do l = 1, size(unit, 2)
            do side = -1, 1, 2
               state = self%states(:, i) + side*length*unit(:, l)
               do k = 1, period
                  call map%pass_period(state, lost)
               end do
               state = state - self%states(:, i)
               if (.not. length**2 - sum(matmul(self%weight(:, :, i), state)**2) >= &
                   least_fall*length**2*sum(matmul(to_energy, unit(:, l))**2)) return
            end do
         end do
      end do
      falls = .not. lost
   end subroutine measure_fall

   !> Whether a state at phase 0 lies in one of the balls.
   pure logical function holds(self, state)
      class(recognition_type), intent(in) :: self
      !> The state [1], (state).
      real(dp), intent(in) :: state(:)
      real(dp) :: sum_, part
      integer :: i, k

      holds = .false.
      if (.not. allocated(self%weight)) return
      do i = 1, self%period
         sum_ = 0
         do k = 1, size(state)
            part = dot_product(self%weight(k, :, i), state - self%states(:, i))
            sum_ = sum_ + part**2
            if (sum_ >= self%radius(i)**2) exit
         end do
         holds = sum_ < self%radius(i)**2
         if (holds) return
      end do
   end function holds

end module geartrain_flow_recognition
