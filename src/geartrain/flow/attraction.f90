!> Whether the flow from a state goes to a known attracting orbit, decided long before the flow is there.
!>
!> Near the orbit a distance d becomes M d + e over a period of the orbit (M: monodromy matrix, e: nonlinear remainder). With the
!> weight Q = sum over k of M^k' M^k the Lyapunov function v = d'Q d falls by |d|^2 a period where e = 0. The flow counts as caught
!> where v has fallen over some periods by at least half of the predicted |d|^2, by several times the largest effect of e, and at
!> most at 1.5 times the rate of the slowest multiplier: then no slow direction, along which another orbit might lie, hides behind a
!> fast direction. The largest e is found by trial flights along the way that M predicts, where slow vibrations may add up and open
!> a mesh.
!>
!> Under a slow vibration v falls for the orbits next to the right one too. There d must also be near M^n d of the first of these
!> periods, for the flow leaves the way to a wrong orbit little by little. And Newton's method is tried along the way that M
!> predicts: where it finds another orbit that attracts, the flow must come nearer than that one is.
module geartrain_flow_attraction
   use geartrain_base_kinds, only: dp
   use geartrain_floquet_multipliers, only: eigenvalues, is_neutral, is_stable
   use geartrain_flow_energy, only: energy_type
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_orbit, only: flow_order, flow_tolerance
   use geartrain_flow_shooting, only: find_orbit
   use geartrain_flow_tangent_flight, only: tangent_flight_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: attraction_type

   !> Least fall of v: as a share of the predicted fall, and, of log v, as a multiple of the largest |e|/|d|.
   real(dp), parameter :: least_share = 0.5_dp, least_fall = 8
   !> Largest rate at which v may fall over the rate of the slowest multiplier.
   real(dp), parameter :: largest_rate = 1.5_dp
   !> Share of v that the slowest direction loses in a period below which the following is asked for too.
   real(dp), parameter :: slow = 0.3_dp
   !> Largest distance of the flow from the way that M predicts over that from the orbit: of 120 flights between two orbits with
   !> multipliers of 0.99 those that went to the other one had 0.26 and more, the others 0.11 and less.
   real(dp), parameter :: largest_drift = 0.12_dp
   !> Most steps of Newton's method, and the relative difference of states that are equal.
   integer, parameter :: most_steps = 7
   real(dp), parameter :: equal = 1e-6_dp
   !> Where another orbit attracts too: a flow is caught when it is nearer to this orbit than this share of their distance.
   real(dp), parameter :: near = 0.5_dp
   !> Largest |e|/|d| over the decay of the slowest direction in a period that cannot stop the decay.
   real(dp), parameter :: harmless = 0.25_dp
   !> The way is predicted over 1 + 2 + ... + 2**octaves periods.
   integer, parameter :: octaves = 10

   type :: attraction_type
      !> Period of the orbit [periods of the fundamental]; 0: no orbit is known.
      integer :: period = 0
      !> State of the orbit at phase 0 [1], (state).
      real(dp), allocatable :: state(:)
      !> Multipliers of the orbit [1], largest magnitude first, (state).
      complex(dp), allocatable :: multipliers(:)
      !> Last Newton step that found the orbit, relative [1].
      real(dp) :: accuracy = 0
      !> Some multiplier lies outside the unit circle.
      logical :: repels = .false.
      !> Fewest periods of a watch that tell that the flow is caught.
      integer :: least_watched = 1
      !> v has fallen since the beginning of the watch.
      logical :: comes_near = .false.
      type(energy_type), private :: energy
      type(flow_type), private :: flow
      real(dp), private :: frequency_ratio = 1
      !> M and Q in energy coordinates, (state, state).
      real(dp), allocatable, private :: monodromy(:, :), weight(:, :)
      !> Share of v that the slowest direction loses in a period.
      real(dp), private :: slowest = 0
      !> Distance at the section before, in energy coordinates; not allocated at the first section.
      real(dp), allocatable, private :: before(:)
      !> Where M predicts it from that at the beginning of the watch.
      real(dp), allocatable, private :: way(:)
      !> Periods of the orbit in the present watch; periods after which a new watch begins, which forgets the past.
      integer, private :: watched = 0, watch = 1
      !> v of the nearest other orbit that attracts; negative: not looked for yet.
      real(dp), private :: rival = -1
      !> Of the present watch: v at the beginning, sum of v over the periods, predicted fall of v, largest |e|/|d|.
      real(dp), private :: first = 0, total = 0, predicted = 0, largest = 0
      !> Largest |e|/|d| along the predicted way; negative: not known yet.
      real(dp), private :: ahead = -1
   contains
      procedure :: setup
      procedure :: follow
      procedure, private :: value
      procedure, private :: look_ahead
      procedure, private :: find_rival
   end type attraction_type

contains

   !> Sets the orbit; self%period stays 0 where the orbit does not attract.
   subroutine setup(self, system, frequency_ratio, period, state, monodromy, accuracy)
      class(attraction_type), intent(out) :: self
      type(system_type), pointer, intent(in) :: system
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Period of the orbit [periods of the fundamental].
      integer, intent(in) :: period
      !> State of the orbit at phase 0 [1], (state); monodromy matrix [1], (state, state).
      real(dp), intent(in) :: state(:), monodromy(:, :)
      !> Last Newton step that found the orbit, relative [1].
      real(dp), intent(in) :: accuracy
      real(dp), allocatable :: power(:, :)
      integer :: i

      power = monodromy
      allocate (self%multipliers(size(state)))
      call eigenvalues(power, self%multipliers)
      self%state = state
      self%accuracy = accuracy
      self%repels = .not. (is_stable(self%multipliers) .or. is_neutral(self%multipliers))
      if (.not. is_stable(self%multipliers)) return
      self%period = period
      self%frequency_ratio = frequency_ratio
      self%slowest = 1 - abs(self%multipliers(1))**2
      call self%energy%setup(system)
      call self%flow%setup(system, 1, flow_order, flow_tolerance)
      self%monodromy = self%energy%transform(monodromy)
      allocate (self%weight(size(state), size(state)), source=0.0_dp)
      do i = 1, size(state)
         self%weight(i, i) = 1
      end do
      power = self%monodromy
      do i = 1, 64
         self%weight = self%weight + matmul(transpose(power), matmul(self%weight, power))
         power = matmul(power, power)
         if (maxval(abs(power)) < 1e-9_dp) exit
      end do
   end subroutine setup

   !> Takes the next section of the flow, a period of the orbit after the section before.
   subroutine follow(self, section, tolerance, caught)
      class(attraction_type), intent(inout) :: self
      !> State of the flow at phase 0 [1], (state); relative distance at which the flow is at the orbit [1].
      real(dp), intent(in) :: section(:), tolerance
      !> The flow goes to this orbit.
      logical, intent(out) :: caught
      real(dp) :: distance(size(section)), v, v_before, fall

      caught = maxval(abs(section - self%state)) <= tolerance*maxval(abs(self%state))
      if (caught) return
      distance = self%energy%coordinates(section - self%state)
      v = self%value(distance)
      if (allocated(self%before)) then
         v_before = self%value(self%before)
         self%watched = self%watched + 1
         self%way = matmul(self%monodromy, self%way)
         self%total = self%total + v_before
         self%predicted = self%predicted + sum(self%before**2)
         self%largest = max(self%largest, sqrt(self%value(distance - matmul(self%monodromy, self%before))/v_before))
         self%comes_near = v < self%first
         fall = log(self%first/v)
         if (self%watched >= self%least_watched .and. may_be_caught()) then
            if (self%ahead < 0) call self%look_ahead(distance)
            self%largest = max(self%largest, self%ahead)
            caught = may_be_caught()
            if (caught .and. self%slowest <= slow .and. self%largest > harmless*self%slowest/2) then
               if (self%rival < 0) call self%find_rival(distance)
               caught = v < near**2*self%rival
            end if
            if (caught) return
         end if
         if (self%watched >= self%watch) then
            self%watch = 2*self%watch
            self%watched = 0
         end if
      end if
      self%before = distance
      if (self%watched > 0) return
      self%first = v
      self%way = distance
      self%total = 0
      self%predicted = 0
      self%largest = 0
      self%ahead = -1

   contains

      !> Whether v has fallen as it must, with the largest |e|/|d| known so far.
      logical function may_be_caught()

         may_be_caught = self%largest <= harmless*self%slowest/2
         if (may_be_caught) return
         may_be_caught = self%first - v >= least_share*self%predicted .and. fall >= least_fall*self%largest &
                         .and. self%predicted <= largest_rate*self%slowest*self%total
         if (self%slowest <= slow) may_be_caught = may_be_caught .and. self%value(distance - self%way) <= largest_drift**2*v
      end function may_be_caught

   end subroutine follow

   !> v of a distance in energy coordinates.
   pure real(dp) function value(self, distance)
      class(attraction_type), intent(in) :: self
      real(dp), intent(in) :: distance(:)

      value = max(dot_product(distance, matmul(self%weight, distance)), tiny(1.0_dp))
   end function value

   !> Sets `rival` by Newton's method from each octave of periods of the way that M predicts.
   subroutine find_rival(self, distance)
      class(attraction_type), intent(inout) :: self
      !> From the orbit, in energy coordinates, (state).
      real(dp), intent(in) :: distance(:)
      real(dp) :: now(size(distance)), state(size(distance)), monodromy(size(distance), size(distance)), length
      complex(dp) :: multipliers(size(distance))
      type(tangent_flight_type) :: flight
      integer :: k, octave
      logical :: found

      self%rival = huge(1.0_dp)
      call flight%setup(self%flow%system)
      now = distance
      do octave = 0, octaves
         do k = 1, 2**octave
            now = matmul(self%monodromy, now)
            if (mod(4*k, 2**octave) /= 0) cycle
            state = self%state + self%energy%state(now)
            call find_orbit(flight, self%frequency_ratio, self%period, most_steps, state, monodromy, length, found)
            if (found) found = maxval(abs(state - self%state)) > equal*maxval(abs(self%state))
            if (.not. found) cycle
            call eigenvalues(monodromy, multipliers)
            if (is_stable(multipliers)) self%rival = min(self%rival, self%value(self%energy%coordinates(state - self%state)))
         end do
         if (self%value(now) < 1e-3_dp*self%value(distance)) exit
      end do
   end subroutine find_rival

   !> Sets `ahead` by a trial flight in each octave of periods, from where M predicts the largest displacement of a mesh.
   subroutine look_ahead(self, distance)
      class(attraction_type), intent(inout) :: self
      !> From the orbit, in energy coordinates, (state).
      real(dp), intent(in) :: distance(:)
      real(dp) :: now(size(distance)), worst(size(distance)), state(size(distance)), largest, reach
      integer :: i, k, octave

      self%ahead = 0
      now = distance
      do octave = 0, octaves
         largest = -1
         do k = 1, 2**octave
            now = matmul(self%monodromy, now)
            state = self%energy%state(now)
            associate (system => self%flow%system)
               reach = maxval(abs(state(pack(system%mesh_element, system%mesh_element <= system%coordinates))))
            end associate
            if (reach <= largest) cycle
            largest = reach
            worst = now
         end do
         self%flow%x(1, :) = self%state + self%energy%state(worst)
         do i = 1, self%period
            call self%flow%pass_period(self%frequency_ratio)
         end do
         state = self%energy%coordinates(self%flow%x(1, :) - self%state) - matmul(self%monodromy, worst)
         self%ahead = max(self%ahead, sqrt(self%value(state)/self%value(worst)))
         if (self%value(now) < 1e-3_dp*self%value(distance)) exit
      end do
   end subroutine look_ahead

end module geartrain_flow_attraction
