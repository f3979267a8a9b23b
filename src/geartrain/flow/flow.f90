!> The flow of the equations of motion by Taylor series with located contact events.
!>
!> Between contact events the equations are linear with analytic coefficients, so the Taylor coefficients of the solution follow
!> from a recurrence, to any order. The events are found in the series itself. The elastic force is continuous at an event, so
!> tangents pass an event unchanged unless the damping force jumps (`shear`).
!>
!> A state has the displacements of the elements that are coordinates (of a mesh p, of a shaft its twist less the twist at rest),
!> then their velocities; of a body with damping to ground only the velocity. The elements that close loops follow from the
!> coordinates.
module geartrain_flow_flow
   use geartrain_base_kinds, only: dp, pi
   use geartrain_flow_dry_friction, only: friction_type, undecided
   use geartrain_flow_friction_events, only: begin_friction, change_mode, meet_jump
   use geartrain_flow_taylor, only: accelerate, add_waves, last_term, recur, series_value, sum_series
   use geartrain_flow_wall_event, only: first_wall
   use geartrain_network_system, only: shear, system_type
   implicit none (type, external)
   private
   public :: flow_type

   !> Most successive events at one instant besides one of each mesh; the next event is passed over. Time between two events, over
   !> a step without events, up to which they count as of one instant: equal planets meet their flanks together, to rounding.
   integer, parameter :: most_stuck = 3
   real(dp), parameter :: at_once = 1e-10_dp

   type :: flow_type
      !> The train.
      type(system_type), pointer :: system => null()
      !> Phase of the fundamental [1] and Lambda [1] at time 0; its rate of change [1], 0 at constant speed.
      real(dp) :: phase = 0, frequency_ratio = 1, acceleration = 0
      !> Constant torques over b_c that add to the torques of the train [N m/m], (torque); not allocated: none.
      real(dp), allocatable :: push(:)
      !> Number of columns of `x`: the state, then tangents to the flow.
      integer :: columns = 1
      !> Time times characteristic frequency [1]; state and tangents [1], (column, state).
      real(dp) :: time = 0
      real(dp), allocatable :: x(:, :)
      !> Region of the force law of each mesh, (mesh): 1 drive flank, 0 separation, -1 back flank; 1 for a mesh without backlash.
      integer, allocatable :: contact(:)
      !> Dry friction of couplings.
      type(friction_type) :: friction
      !> The latest `step` ended at an event; since `start` the smallest mesh speed at an event [1] and the number of events.
      logical :: event = .false.
      real(dp) :: slowest_event = huge(1.0_dp)
      integer :: events = 0
      !> Length of the latest step [1]; Taylor coefficients of displacement and velocity over the step [1], (column, element,
      !> 0:order).
      real(dp) :: length = 0
      real(dp), allocatable :: p(:, :, :), v(:, :, :)
      !> Least size of a state in the relative error of a step [1].
      real(dp) :: smallest = 1e-3_dp
      !> Order of the Taylor series; relative error of a step [1].
      integer :: order = 20
      real(dp) :: tolerance = 1e-15_dp
      !> Taylor coefficients of kappa over the latest step where kappa varies in the contact of the mesh [1], (0:order, mesh).
      real(dp), allocatable :: kappa(:, :)
      !> Work space of `recur`, (column and element, 4); Taylor coefficients of the acceleration by excitation, (0:order, element).
      real(dp), allocatable, private :: work(:, :), excitation(:, :)
      !> In the present contacts: constant stiffness over mean stiffness, 0 where kappa varies, and damping, (element); displacement
      !> at which the elastic force is 0 [1], (mesh); last Taylor coefficient of kappa that counts, negative: constant, (mesh).
      real(dp), allocatable, private :: spring(:), damping(:), origin(:)
      integer, allocatable, private :: terms(:)
      !> Taylor coefficients of the displacements of the elements that close loops where the coordinates are 0 [1], (0:order + 1,
      !> loop).
      real(dp), allocatable, private :: loop(:, :)
      !> Taylor coefficients of the offsets of laws that have them [1], (0:order, mesh).
      real(dp), allocatable :: offset(:, :)
      !> Mesh and wall of the event at the present time, 0: none; number of successive events at the present time.
      integer, private :: event_mesh = 0, event_wall = 0, stuck = 0
      !> The state is not valid: since `setup` an event was passed over because too many events fell on one instant, or the step
      !> of an unbounded state became 0.
      logical :: lost = .false.
      !> Largest length of the next step [1], for which the series of kappa is cut off; 0: no limit, all terms.
      real(dp), private :: reach = 0
   contains
      procedure :: setup
      procedure :: start
      procedure :: step
      procedure :: advance
      procedure :: pass_period
      procedure :: displacement
      procedure :: velocity
      procedure :: element_now
      procedure :: expand
      procedure, private :: expand_loops
      procedure :: step_length
   end type flow_type

contains

   !> Makes the work space.
   subroutine setup(self, system, columns, order, tolerance)
      class(flow_type), intent(inout) :: self
      type(system_type), pointer, intent(in) :: system
      !> Number of columns: the state and tangents.
      integer, intent(in) :: columns
      !> Order of the Taylor series.
      integer, intent(in) :: order
      !> Relative error of a step [1].
      real(dp), intent(in) :: tolerance

      self%system => system
      self%columns = columns
      self%order = order
      self%tolerance = tolerance
      if (allocated(self%x)) deallocate (self%x, self%p, self%v, self%work, self%kappa, self%excitation, self%contact, &
                                         self%loop, self%spring, self%damping, self%origin, self%terms, self%offset)
      associate (n => system%elements)
         allocate (self%x(columns, system%states), self%p(columns, n, 0:order), self%v(columns, n, 0:order), &
                   self%work(columns*n, 4), self%kappa(0:order, system%meshes), self%excitation(0:order, n), &
                   self%contact(system%meshes), self%loop(0:order + 1, n - system%coordinates), self%spring(n), self%damping(n), &
                   self%origin(system%meshes), self%terms(system%meshes), self%offset(0:order, system%meshes))
      end associate
      call self%friction%setup(system, order)
      self%contact = 1
      self%lost = .false.
      self%smallest = 1e-3_dp*maxval(abs(system%static_force(system%mesh_element)) + system%half_backlash)
      if (.not. self%smallest > 0) self%smallest = sqrt(tiny(1.0_dp))
   end subroutine setup

   !> Begins a flight from the state and tangents `x`, which the caller has set; finds the contacts of the state.
   subroutine start(self, frequency_ratio, time, acceleration)
      class(flow_type), intent(inout) :: self
      !> Lambda at time 0 [1]; time, 0 at phase 0 [1].
      real(dp), intent(in) :: frequency_ratio, time
      !> Rate of change of Lambda [1]; absent: 0.
      real(dp), intent(in), optional :: acceleration
      real(dp) :: p, v, speed(self%friction%count)
      integer :: j

      self%frequency_ratio = frequency_ratio
      self%acceleration = 0
      if (present(acceleration)) self%acceleration = acceleration
      self%time = time
      self%length = 0
      self%reach = 0
      self%event_mesh = 0
      self%stuck = 0
      self%events = 0
      self%slowest_event = huge(1.0_dp)
      do j = 1, self%system%meshes
         call self%element_now(self%system%mesh_element(j), p, v)
         self%contact(j) = self%system%law(j)%region_at(p, v)
      end do
      if (self%friction%count == 0) return
      do j = 1, self%friction%count
         call self%element_now(self%friction%element(j), p, speed(j))
      end do
      call self%friction%begin(speed, maxval(abs(self%x(1, self%system%displacements + 1:))))
      if (.not. any(self%friction%mode == undecided)) return
      call self%expand()
      call begin_friction(self%friction, self%system, self%v(1, :, 1), self%x)
   end subroutine start

   !> Flies over a period of the fundamental from phase 0; less far where the interrupt is raised.
   subroutine pass_period(self, frequency_ratio)
      class(flow_type), intent(inout) :: self
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio

      call self%start(frequency_ratio, 0.0_dp)
      call self%advance(2*pi/frequency_ratio)
   end subroutine pass_period

   !> Advances to a time; less far where the interrupt is raised.
   subroutine advance(self, end_time)
      class(flow_type), intent(inout) :: self
      !> Time to fly to [1].
      real(dp), intent(in) :: end_time

      do while (self%time < end_time)
         if (self%system%interrupt%raised()) return
         call self%step(end_time)
      end do
   end subroutine advance

   !> Makes one step, which ends at the first contact event.
   subroutine step(self, end_time)
      class(flow_type), intent(inout) :: self
      !> Time that the step must not pass [1].
      real(dp), intent(in) :: end_time
      real(dp) :: h, whole
      integer :: d, n, mesh, wall, rubbing
      logical :: reaches_end

      call self%expand()
      h = self%step_length()
      whole = h
      if (self%friction%count > 0) call self%friction%limit_step(h)
      if (self%reach > 0) h = min(h, self%reach)
      ! The next step is at most twice as long, also where an event or the end of the flight shortens this step.
      self%reach = 2*h
      reaches_end = h >= end_time - self%time
      if (.not. (reaches_end .or. self%time + h > self%time)) then
         self%lost = .true.
         self%x = huge(1.0_dp)
         self%time = end_time
         return
      end if
      if (reaches_end) h = end_time - self%time
      self%event = .false.
      rubbing = 0
      ! Where too many events fell on one instant, the next event is passed over.
      if (self%stuck <= most_stuck + self%system%meshes) then
         call first_wall(self%system, self%contact, self%p, self%event_mesh, self%event_wall, h, self%event, mesh, wall)
         if (self%friction%count > 0) call self%friction%first_event(self%v(1, :, :), h, rubbing)
      end if
      d = self%system%displacements
      n = self%system%coordinates
      call sum_series(self%columns*d, self%columns*self%system%elements, self%order, self%p, h, self%x(:, :d))
      call sum_series(self%columns*n, self%columns*self%system%elements, self%order, self%v, h, self%x(:, d + 1:))
      self%length = h
      self%time = self%time + h
      if (self%friction%count > 0 .and. h > 0) call self%friction%pass()
      if (rubbing > 0) then
         self%event = .true.
         self%event_mesh = 0
         call change_mode(self%friction, self%system, rubbing, self%v(1, :, :), h, self%x)
      else if (self%event) then
         call enter(self, mesh, wall, h)
      else
         self%event_mesh = 0
         self%stuck = 0
         if (reaches_end) self%time = end_time
         return
      end if
      self%events = self%events + 1
      self%stuck = merge(0, self%stuck + 1, h > at_once*whole)
      if (self%stuck > most_stuck + self%system%meshes) self%lost = .true.
   end subroutine step

   !> Changes the contact of a mesh at a wall of its law, after a step of length h.
   subroutine enter(self, mesh, wall, h)
      class(flow_type), intent(inout) :: self
      integer, intent(in) :: mesh, wall
      real(dp), intent(in) :: h
      real(dp) :: p, v
      integer :: before

      associate (n => self%system%mesh_element(mesh), e => self%system%displacements, law => self%system%law(mesh))
         if (n <= e) self%x(1, n) = law%wall(wall)
         before = self%contact(mesh)
         self%contact(mesh) = merge(wall + 1, wall, before == wall)
         if (law%jumps .and. self%columns > 1) call shear(self%system, n, law%damping(self%contact(mesh)) - law%damping(before), &
                                                          self%x(2:, :e), self%x(2:, e + 1:))
         call self%element_now(self%system%mesh_element(mesh), p, v)
         self%slowest_event = min(self%slowest_event, abs(v))
         if (law%jumps .and. self%friction%count > 0) &
            call meet_jump(self%friction, self%system, n, law%damping(self%contact(mesh)) - law%damping(before), v, &
                           self%v(1, :, :), h, self%x)
      end associate
      self%event_mesh = mesh
      self%event_wall = wall
   end subroutine enter

   !> Computes the Taylor coefficients of all columns at the present time.
   subroutine expand(self)
      class(flow_type), intent(inout) :: self
      real(dp) :: reach
      integer :: j, n

      associate (system => self%system)
         n = system%coordinates
         associate (d => system%displacements)
            self%p(:, d + 1:n, 0) = 0
            self%p(:, :d, 0) = self%x(:, :d)
            self%v(:, :n, 0) = self%x(:, d + 1:)
         end associate
         if (system%elements > n) call self%expand_loops(self%order + 1, self%loop)
         self%spring(:) = system%spring
         self%damping(:) = system%damping
         self%terms = -1
         reach = huge(1.0_dp)
         if (self%reach > 0) reach = self%reach
         do j = 1, system%meshes
            n = system%mesh_element(j)
            associate (law => system%law(j), s => self%contact(j))
               self%spring(n) = law%stiffness(s)
               self%damping(n) = law%damping(s)
               self%origin(j) = law%origin(s)
               if (.not. law%varies(s)) cycle
               self%spring(n) = 0
               self%kappa(:, j) = 0
               self%kappa(0, j) = law%stiffness(s)
               call add_series(self, law%harmonic, law%amplitude(:, s), self%kappa(:, j))
            end associate
            self%terms(j) = last_term(self%kappa(:, j), reach, 0.01_dp*self%tolerance)
         end do
         call expand_excitation(self)
         if (self%friction%count > 0) call self%friction%begin_series()
         call recur(self%columns, system%elements, system%meshes, self%order, self%spring, self%damping, self%terms, &
                    self%kappa, system, self%origin, self%excitation, self%loop, self%friction, self%work, self%p, self%v)
      end associate
   end subroutine expand

   !> Adds the Taylor coefficients of a series at the present time.
   pure subroutine add_series(self, harmonic, amplitude, coefficient)
      class(flow_type), intent(in) :: self
      integer, intent(in) :: harmonic(:)
      complex(dp), intent(in) :: amplitude(:)
      real(dp), intent(inout) :: coefficient(0:)

      call add_waves(harmonic, amplitude, self%phase, self%frequency_ratio, self%acceleration, self%time, coefficient)
   end subroutine add_series

   !> Computes the Taylor coefficients of the displacements of the elements that close loops, where the coordinates are 0,
   !> (0:highest, loop).
   pure subroutine expand_loops(self, highest, coefficient)
      class(flow_type), intent(in) :: self
      integer, intent(in) :: highest
      real(dp), intent(out) :: coefficient(0:, :)
      real(dp) :: error(0:highest)
      integer :: i, j

      associate (system => self%system)
         coefficient = 0
         coefficient(0, :) = system%loop_offset
         do j = 1, system%meshes
            if (size(system%transmission_error(j)%amplitude) == 0) cycle
            error = 0
            associate (series => system%transmission_error(j), n => system%mesh_element(j))
               call add_series(self, series%harmonic, series%amplitude, error)
               do i = 1, size(coefficient, 2)
                  if (n > system%coordinates) then
                     if (n == system%coordinates + i) coefficient(:, i) = coefficient(:, i) + error
                  else
                     coefficient(:, i) = coefficient(:, i) - system%network%loop(i, n)*error
                  end if
               end do
            end associate
         end do
         do i = 1, size(coefficient, 2)
            associate (n => system%coordinates + i)
               if (system%element_mesh(n) == 0) coefficient(0, i) = coefficient(0, i) - system%static_force(n)
            end associate
         end do
      end associate
   end subroutine expand_loops

   !> Displacement and velocity of an element at present; of a shaft relative to rest.
   pure subroutine element_now(self, n, p, v)
      class(flow_type), intent(in) :: self
      !> Number of the element.
      integer, intent(in) :: n
      !> Displacement over b_c, 0 for the damping to ground that is a coordinate, and velocity [1].
      real(dp), intent(out) :: p, v
      real(dp), allocatable :: loop(:, :)

      associate (e => self%system%coordinates, d => self%system%displacements)
         if (n <= e) then
            p = 0
            if (n <= d) p = self%x(1, n)
            v = self%x(1, d + n)
         else
            allocate (loop(0:1, self%system%elements - e))
            call self%expand_loops(1, loop)
            p = dot_product(self%system%network%loop(n - e, :d), self%x(1, :d)) + loop(0, n - e)
            v = dot_product(self%system%network%loop(n - e, :), self%x(1, d + 1:)) + loop(1, n - e)
         end if
      end associate
   end subroutine element_now

   !> Computes the Taylor coefficients of the accelerations by torques and transmission errors.
   subroutine expand_excitation(self)
      class(flow_type), intent(inout) :: self
      real(dp) :: torque(0:self%order), error(0:self%order + 2)
      integer :: j, k, n

      self%excitation = 0
      associate (system => self%system)
         do j = 1, size(system%torque)
            if (size(system%torque(j)%amplitude) == 0 .and. .not. allocated(self%push)) cycle
            torque = 0
            if (allocated(self%push)) torque(0) = self%push(j)
            call add_series(self, system%torque(j)%harmonic, system%torque(j)%amplitude, torque)
            do n = 1, system%elements
               self%excitation(:, n) = self%excitation(:, n) + system%torque_gain(n, j)*torque
            end do
         end do
         if (allocated(system%speed_loads)) call system%speed_loads%accelerate(self%frequency_ratio &
                                                         + self%acceleration*self%time, self%acceleration, self%excitation)
         do j = 1, system%meshes
            if (allocated(system%law(j)%offset)) then
               self%offset(:, j) = 0
               call add_series(self, system%law(j)%harmonic, system%law(j)%offset(:, self%contact(j)), self%offset(:, j))
               call accelerate(system, system%mesh_element(j), self%offset(:, j), self%excitation)
            end if
            if (size(system%transmission_error(j)%amplitude) == 0) cycle
            error = 0
            associate (series => system%transmission_error(j))
               call add_series(self, series%harmonic, series%amplitude, error)
            end associate
            n = system%mesh_element(j)
            self%excitation(:, n) = self%excitation(:, n) + [(k*(k - 1)*error(k), k=2, self%order + 2)]
         end do
      end associate
   end subroutine expand_excitation

   !> Step length at which the last two terms of the series fall below the tolerance, for the state and for the tangents [1].
   pure real(dp) function step_length(self) result(h)
      class(flow_type), intent(in) :: self

      h = huge(1.0_dp)
      call limit(1, 1, self%smallest, h)
      if (self%columns > 1) call limit(2, self%columns, sqrt(tiny(1.0_dp)), h)

   contains

      pure subroutine limit(from, to, floor_, step)
         integer, intent(in) :: from, to
         real(dp), intent(in) :: floor_
         real(dp), intent(inout) :: step
         real(dp) :: size_, last
         integer :: k

         size_ = max(maxval(abs(self%x(from:to, :))), floor_)
         do k = self%order - 1, self%order
            last = max(maxval(abs(self%p(from:to, :, k))), maxval(abs(self%v(from:to, :, k))))
            if (last > 0) step = min(step, (self%tolerance*size_/last)**(1.0_dp/k))
         end do
      end subroutine limit

   end function step_length

   !> Displacement over b_c of a mesh within the latest step [1].
   pure real(dp) function displacement(self, mesh, tau)
      class(flow_type), intent(in) :: self
      !> Number of the mesh.
      integer, intent(in) :: mesh
      !> Time since the beginning of the step, 0 to `length` [1].
      real(dp), intent(in) :: tau

      displacement = series_value(self%p(1, self%system%mesh_element(mesh), :), tau)
   end function displacement

   !> Velocity of a mesh within the latest step [1].
   pure real(dp) function velocity(self, mesh, tau)
      class(flow_type), intent(in) :: self
      !> Number of the mesh.
      integer, intent(in) :: mesh
      !> Time since the beginning of the step, 0 to `length` [1].
      real(dp), intent(in) :: tau

      velocity = series_value(self%v(1, self%system%mesh_element(mesh), :), tau)
   end function velocity

end module geartrain_flow_flow
