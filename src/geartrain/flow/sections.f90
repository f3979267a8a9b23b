!> A linearized flight over the period of an orbit, for shooting in sections of the period: the states at the beginnings of the
!> sections, and how the gaps between the sections depend on the first state and on Lambda.
!>
!> Newton's method changes the state at time 0 by y and Lambda by l; the states at the other beginnings follow, so that all gaps but
!> the last close:
!>    change of state k = transfer(k) y + drift(k) l + missed(k);   the orbit is closed where state sections + 1 changes as state 1.
module geartrain_flow_sections
   use geartrain_base_kinds, only: dp, pi
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_orbit, only: begin_tangents, flow_order, flow_tolerance
   use geartrain_linalg_bracket, only: between, shrink
   use geartrain_network_parameter_path, only: parameter_path_type
   use geartrain_network_system, only: system_type
   use geartrain_network_units, only: units_of, units_type
   implicit none (type, external)
   private
   public :: sections_type

   !> Relative change of Lambda in the difference for the drift. Rounding makes a relative error of 1e-6, small enough for Newton
   !> steps.
   real(dp), parameter :: difference = 1e-7_dp
   !> Change of a parameter in place of Lambda in the difference for the drift, over the length of its path.
   real(dp), parameter :: parameter_difference = 1e-6_dp
   !> Pieces of a step in each of which a mesh velocity has at most one zero; most steps towards it.
   integer, parameter :: pieces = 8, max_steps = 60

   type :: sections_type
      !> Period of the orbit [periods of the fundamental]; sections of the period.
      integer :: period = 1, sections = 1
      !> Lambda is variable.
      logical, private :: moves = .false.
      !> Units of displacements and velocities; number of displacements of a state.
      type(units_type), private :: units
      integer, private :: displacements = 0
      !> Derivatives of state k with respect to state 1 [1], (state, state, 2:sections); derivatives with respect to
      !> Lambda and accumulated gaps [1], (state, 2:sections + 1).
      real(dp), allocatable :: transfer(:, :, :), drift(:, :), missed(:, :)
      !> Transfer over all sections [1], (state, state).
      real(dp), allocatable :: monodromy(:, :)
      !> Where a parameter of the train is variable, derivatives of state k with respect to it [1/unit of the parameter],
      !> (state, 2:sections + 1).
      real(dp), allocatable :: parameter_drift(:, :)
      !> What each section by itself adds to drift and parameter_drift, of the latest flight that computed it.
      real(dp), allocatable, private :: own_drift(:, :), own_parameter_drift(:, :)
      !> Contact events of the latest flight; smallest mesh speed at one of them [1].
      integer :: events = 0
      real(dp) :: slowest_event = huge(1.0_dp)
      !> Flow with all tangents and with few, both set up when first flown; flow of a state alone; that of the train with
      !> a larger value of the parameter.
      type(flow_type), private :: flow, few, single, above
      !> By how much the parameter is larger there [unit of the parameter].
      real(dp), private :: apart = 0
      !> Where it is associated, a parameter of the train varies at constant Lambda, and what stands for Lambda everywhere is 1 at
      !> the value `origin` of the parameter and grows by 1 over the path. The train of the latest flight is that of `single`; the
      !> train beside it.
      type(parameter_path_type), pointer, private :: path => null()
      type(system_type), pointer, private :: beside => null()
      real(dp), private :: origin = 0
   contains
      procedure :: setup
      procedure :: size_of
      procedure :: fly
      procedure :: guess
      procedure :: step_at
      procedure :: extremes
      procedure :: vary
      procedure :: vary_along
      procedure :: reaches
      procedure :: parameter_at
      procedure :: lambda_at
      procedure :: stand_at
      procedure :: carry_vectors
      procedure :: interrupted
      procedure :: is_lost
   end type sections_type

contains

   !> Prepares flights over the period of an orbit.
   subroutine setup(self, system, period, parts, moves)
      class(sections_type), intent(inout) :: self
      type(system_type), pointer, intent(in) :: system
      !> Period of the orbit [periods of the fundamental]; sections of a period of the fundamental.
      integer, intent(in) :: period, parts
      !> Whether Lambda is variable: `drift` is computed.
      logical, intent(in) :: moves

      self%period = period
      self%sections = period*parts
      self%moves = moves
      self%units = units_of(system)
      self%displacements = system%displacements
      self%flow%columns = 0
      self%few%columns = 0
      call self%single%setup(system, 1, flow_order, flow_tolerance)
   end subroutine setup

   !> Largest displacement or velocity of states, each in its unit [1]; not below the smallest positive number.
   pure real(dp) function size_of(self, states)
      class(sections_type), intent(in) :: self
      !> States, or their changes [1], (state, section).
      real(dp), intent(in) :: states(:, :)

      size_of = max(self%units%size_of(self%displacements, states), tiny(1.0_dp))
   end function size_of

   !> Makes a parameter of the train variable; before `setup`.
   subroutine vary(self, above, apart)
      class(sections_type), intent(inout) :: self
      !> The train with a larger value of the parameter.
      type(system_type), pointer, intent(in) :: above
      !> By how much it is larger [unit of the parameter].
      real(dp), intent(in) :: apart

      self%apart = apart
      call self%above%setup(above, 1, flow_order, flow_tolerance)
   end subroutine vary

   !> Makes a parameter of the train variable in place of Lambda; before `setup`, whose train then changes with every flight.
   subroutine vary_along(self, path, origin, beside)
      class(sections_type), intent(inout) :: self
      !> The trains.
      type(parameter_path_type), pointer, intent(in) :: path
      !> Value of the parameter at which what stands for Lambda is 1 [unit of the parameter].
      real(dp), intent(in) :: origin
      !> Room for a train with another value.
      type(system_type), pointer, intent(in) :: beside

      self%path => path
      self%origin = origin
      self%beside => beside
   end subroutine vary_along

   !> Whether there is a train.
   pure logical function reaches(self, frequency_ratio)
      class(sections_type), intent(in) :: self
      !> Lambda, or what stands for it [1].
      real(dp), intent(in) :: frequency_ratio

      reaches = frequency_ratio > 0
      if (.not. associated(self%path)) return
      associate (value => self%parameter_at(frequency_ratio))
         reaches = value >= self%path%low .and. value <= self%path%high
      end associate
   end function reaches

   !> Lambda, or value of the parameter that varies in its place.
   pure real(dp) function parameter_at(self, frequency_ratio) result(value)
      class(sections_type), intent(in) :: self
      !> Lambda, or what stands for it [1].
      real(dp), intent(in) :: frequency_ratio

      value = frequency_ratio
      if (associated(self%path)) value = self%origin + (frequency_ratio - 1)*self%path%length
   end function parameter_at

   !> Lambda of a flight [1].
   pure real(dp) function lambda_at(self, frequency_ratio) result(lambda)
      class(sections_type), intent(in) :: self
      !> Lambda, or what stands for it [1].
      real(dp), intent(in) :: frequency_ratio

      lambda = frequency_ratio
      if (associated(self%path)) lambda = self%path%frequency_ratio
   end function lambda_at

   !> Takes the train of a flight where a parameter varies, and finds Lambda.
   subroutine stand_at(self, frequency_ratio, lambda)
      class(sections_type), intent(inout) :: self
      !> Lambda, or what stands for it [1].
      real(dp), intent(in) :: frequency_ratio
      !> Lambda [1].
      real(dp), intent(out) :: lambda

      lambda = self%lambda_at(frequency_ratio)
      if (.not. associated(self%path)) return
      call self%path%system_at(self%parameter_at(frequency_ratio), self%single%system)
      call self%single%setup(self%single%system, 1, flow_order, flow_tolerance)
      if (self%flow%columns > 0) &
         call self%flow%setup(self%single%system, self%single%system%states + 1, flow_order, flow_tolerance)
   end subroutine stand_at

   !> Carries the first state to the beginnings of the other sections.
   subroutine guess(self, frequency_ratio, states)
      class(sections_type), intent(inout) :: self
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> States at the beginnings of the sections [1], (state, section); the first is given.
      real(dp), intent(inout) :: states(:, :)
      real(dp) :: lambda
      integer :: k

      call self%stand_at(frequency_ratio, lambda)
      do k = 1, self%sections - 1
         states(:, k + 1) = states(:, k)
         call carry(self%single, k, self%sections/self%period, lambda, states(:, k + 1))
      end do
   end subroutine guess

   !> Flies all sections: sets transfer, drift, missed and monodromy.
   subroutine fly(self, frequency_ratio, states, nearby)
      class(sections_type), intent(inout) :: self
      !> Lambda [1]; states at the beginnings of the sections [1], (state, section).
      real(dp), intent(in) :: frequency_ratio, states(:, :)
      !> Whether the latest flight was so near that what it found of the drifts will do; default no.
      logical, intent(in), optional :: nearby
      real(dp) :: ahead(size(states, 1)), own(size(states, 1), size(states, 1)), lambda, other
      integer :: k, n, parts
      logical :: anew

      n = size(states, 1)
      call self%stand_at(frequency_ratio, lambda)
      other = difference*lambda
      if (self%moves .and. associated(self%path)) then
         other = parameter_difference
         if (.not. self%reaches(frequency_ratio + other)) other = -other
         call self%path%system_at(self%parameter_at(frequency_ratio + other), self%beside)
         call self%above%setup(self%beside, 1, flow_order, flow_tolerance)
      end if
      if (self%flow%columns == 0) then
         call self%flow%setup(self%single%system, n + 1, flow_order, flow_tolerance)
         associate (m => self%sections)
            if (allocated(self%transfer)) deallocate (self%transfer, self%drift, self%missed, self%monodromy)
            allocate (self%transfer(n, n, 2:m), self%drift(n, 2:m + 1), self%missed(n, 2:m + 1), self%monodromy(n, n))
         end associate
      end if
      anew = .true.
      if (present(nearby)) anew = .not. nearby
      if (anew) then
         if (allocated(self%own_drift)) deallocate (self%own_drift, self%own_parameter_drift)
         allocate (self%own_drift(n, self%sections), self%own_parameter_drift(n, self%sections))
         if (.not. self%moves) self%own_drift = 0
      end if
      parts = self%sections/self%period
      self%flow%lost = .false.
      self%single%lost = .false.
      self%events = 0
      self%slowest_event = huge(1.0_dp)
      if (self%apart > 0) then
         if (allocated(self%parameter_drift)) deallocate (self%parameter_drift)
         allocate (self%parameter_drift(n, 2:self%sections + 1))
      end if
      do k = 1, self%sections
         call begin_tangents(self%flow, states(:, k))
         call fly_section(self%flow, k, parts, lambda)
         self%events = self%events + self%flow%events
         self%slowest_event = min(self%slowest_event, self%flow%slowest_event)
         own = transpose(self%flow%x(2:, :))
         self%missed(:, k + 1) = self%flow%x(1, :) - states(:, mod(k, self%sections) + 1)
         if (self%moves .and. anew) then
            ahead = states(:, k)
            if (associated(self%path)) then
               call carry(self%above, k, parts, lambda, ahead)
            else
               call carry(self%single, k, parts, (1 + difference)*lambda, ahead)
            end if
            self%own_drift(:, k) = (ahead - self%flow%x(1, :))/other
         end if
         if (self%apart > 0 .and. anew) then
            ahead = states(:, k)
            call carry(self%above, k, parts, frequency_ratio, ahead)
            self%own_parameter_drift(:, k) = (ahead - self%flow%x(1, :))/self%apart
         end if
         self%drift(:, k + 1) = self%own_drift(:, k)
         if (self%apart > 0) self%parameter_drift(:, k + 1) = self%own_parameter_drift(:, k)
         self%monodromy = own
         ! In a train of 300 meshes the products of all sections take seconds. After an interrupt the flight is of no use.
         if (k > 1 .and. .not. self%interrupted()) then
            self%monodromy = matmul(own, self%transfer(:, :, k))
            self%missed(:, k + 1) = self%missed(:, k + 1) + matmul(own, self%missed(:, k))
            self%drift(:, k + 1) = self%drift(:, k + 1) + matmul(own, self%drift(:, k))
            if (self%apart > 0) &
               self%parameter_drift(:, k + 1) = self%parameter_drift(:, k + 1) + matmul(own, self%parameter_drift(:, k))
         end if
         if (k < self%sections) self%transfer(:, :, k + 1) = self%monodromy
      end do
   end subroutine fly

   !> Whether an interrupt may have ended the flight early.
   logical function interrupted(self)
      class(sections_type), intent(in) :: self

      interrupted = self%single%system%interrupt%raised()
   end function interrupted

   !> Whether too many events fell on one instant in the latest `fly`, so that the flight is no motion.
   pure logical function is_lost(self)
      class(sections_type), intent(in) :: self

      is_lost = self%flow%lost .or. self%single%lost
   end function is_lost

   !> Change of state k [1], (state), without the gap missed(k).
   pure function step_at(self, k, first, frequency_ratio, parameter) result(step)
      class(sections_type), intent(in) :: self
      !> Number of the section, from 1.
      integer, intent(in) :: k
      !> Changes of the first state [1], (state), and of Lambda [1].
      real(dp), intent(in) :: first(:), frequency_ratio
      !> Change of the variable parameter of the train, if there is one [unit of the parameter].
      real(dp), intent(in), optional :: parameter
      real(dp) :: step(size(first))

      step = first
      if (k == 1) return
      step = matmul(self%transfer(:, :, k), first) + frequency_ratio*self%drift(:, k)
      if (present(parameter) .and. self%apart > 0) step = step + parameter*self%parameter_drift(:, k)
   end function step_at

   !> Carries tangents over the period of an orbit: the product of the monodromy matrix with vectors, quicker than the matrix.
   subroutine carry_vectors(self, frequency_ratio, states, vectors, from)
      class(sections_type), intent(inout) :: self
      !> Lambda [1]; states at the beginnings of the sections [1], (state, section).
      real(dp), intent(in) :: frequency_ratio, states(:, :)
      !> Tangents at the beginning, then at the end of the period [1], (state, vector).
      real(dp), intent(inout) :: vectors(:, :)
      !> Number of the section at whose beginning the tangents are given; default 1.
      integer, intent(in), optional :: from
      integer :: k, first

      if (self%few%columns /= 1 + size(vectors, 2)) &
         call self%few%setup(self%single%system, 1 + size(vectors, 2), flow_order, flow_tolerance)
      self%few%x(2:, :) = transpose(vectors)
      self%events = 0
      first = 1
      if (present(from)) first = from
      do k = first, self%sections
         self%few%x(1, :) = states(:, k)
         call fly_section(self%few, k, self%sections/self%period, frequency_ratio)
         self%events = self%events + self%few%events
      end do
      vectors = transpose(self%few%x(2:, :))
   end subroutine carry_vectors

   !> Extremes of the displacement of a mesh over the period.
   subroutine extremes(self, frequency_ratio, states, mesh, smallest, largest, wall, nearest)
      class(sections_type), intent(inout) :: self
      !> Lambda [1]; states at the beginnings of the sections [1], (state, section).
      real(dp), intent(in) :: frequency_ratio, states(:, :)
      !> Number of the mesh.
      integer, intent(in) :: mesh
      !> Smallest and largest displacement over b_c [1].
      real(dp), intent(out) :: smallest, largest
      !> Displacement of a wall [1].
      real(dp), intent(in), optional :: wall
      !> Least distance of any extreme, of a part of the period too, from the wall or its mirror image [1].
      real(dp), intent(out), optional :: nearest
      real(dp) :: end_time, at, closest, lambda
      integer :: k, part, parts

      call self%stand_at(frequency_ratio, lambda)
      smallest = huge(1.0_dp)
      largest = -smallest
      closest = smallest
      at = 0
      if (present(wall)) at = wall
      parts = self%sections/self%period
      do k = 1, self%sections
         part = mod(k - 1, parts)
         self%single%x(1, :) = states(:, k)
         call self%single%start(lambda, 2*pi/lambda*part/parts)
         end_time = 2*pi/lambda*(part + 1)/parts
         do while (self%single%time < end_time)
            if (self%interrupted()) return
            call self%single%step(end_time)
            call extremes_of_step(self%single, mesh, at, smallest, largest, closest)
         end do
      end do
      if (present(nearest)) nearest = closest
   end subroutine extremes

   !> Takes the displacement of a mesh over the latest step into its extremes, and into their least distance from +-wall.
   subroutine extremes_of_step(flow, mesh, wall, smallest, largest, nearest)
      type(flow_type), intent(in) :: flow
      integer, intent(in) :: mesh
      real(dp), intent(in) :: wall
      real(dp), intent(inout) :: smallest, largest, nearest
      real(dp) :: a, b, fa, fb, f, t, before, v
      integer :: i, k, kept

      before = flow%velocity(mesh, 0.0_dp)
      call take(0.0_dp)
      do i = 1, pieces
         b = i*flow%length/pieces
         v = flow%velocity(mesh, b)
         call take(b)
         if (before*v < 0) then
            a = b - flow%length/pieces
            fa = before
            fb = v
            kept = 0
            do k = 1, max_steps
               t = between(a, b, fa, fb)
               f = flow%velocity(mesh, t)
               call shrink(a, b, fa, fb, t, f, kept)
               if (b - a < 1e-9_dp*flow%length .or. abs(f) < 1e-10_dp*abs(before - v)) exit
            end do
            call take(t)
            nearest = min(nearest, abs(abs(flow%displacement(mesh, t)) - wall))
         end if
         before = v
      end do

   contains

      subroutine take(time)
         real(dp), intent(in) :: time

         associate (p => flow%displacement(mesh, time))
            smallest = min(smallest, p)
            largest = max(largest, p)
         end associate
      end subroutine take

   end subroutine extremes_of_step

   !> Carries a state over section k.
   subroutine carry(flow, k, parts, frequency_ratio, state)
      type(flow_type), intent(inout) :: flow
      integer, intent(in) :: k, parts
      real(dp), intent(in) :: frequency_ratio
      real(dp), intent(inout) :: state(:)

      flow%x(1, :) = state
      call fly_section(flow, k, parts, frequency_ratio)
      state = flow%x(1, :)
   end subroutine carry

   !> Advances all columns of a flow over section k; a period of the fundamental has `parts` sections.
   subroutine fly_section(flow, k, parts, frequency_ratio)
      type(flow_type), intent(inout) :: flow
      integer, intent(in) :: k, parts
      real(dp), intent(in) :: frequency_ratio
      integer :: part

      part = mod(k - 1, parts)
      call flow%start(frequency_ratio, 2*pi/frequency_ratio*part/parts)
      call flow%advance(2*pi/frequency_ratio*(part + 1)/parts)
   end subroutine fly_section

end module geartrain_flow_sections
