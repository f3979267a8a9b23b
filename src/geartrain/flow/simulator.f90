!> A train under torques from outside, step by step, as a part of a larger simulation has it.
!>
!> The rotation of body i is v_i phi + u_i: phase phi of the fundamental times what the body turns meanwhile, and vibration. From
!> I theta'' = T + dT - B^T F, with mean torques T in balance and what differs from them, dT:
!>    phi'' = v . dT/(v . I v),   I u'' = T + (dT - I v phi'') - B^T F
!> The torques are constant over a step, and so is the acceleration.
module geartrain_flow_simulator
   use geartrain_base_error, only: error_type, fatal, status_ended_early, status_input
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_numbers, only: text
   use geartrain_balance_motion, only: motion_type
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_force_series, only: force_series
   use geartrain_flow_orbit, only: flow_order, flow_tolerance
   use geartrain_flow_shaft_torque, only: torque_series
   use geartrain_flow_start_state, only: resting_state, state_of
   use geartrain_flow_taylor, only: add_waves
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
   use geartrain_network_network, only: balance_torques
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_bodies, only: bodies_of
   use geartrain_train_kinematics, only: find_kinematics, kinematics_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: simulator_type

   !> Most mesh cycles of a step, minutes of computing: a torque that leads to more is mostly one in another unit.
   real(dp), parameter :: most_cycles = 1e7_dp

   type :: simulator_type
      !> The train.
      type(system_type) :: system
      !> Time [s]; Lambda [1]; phase of the fundamental [1], 0 to 2 pi.
      real(dp) :: time = 0, frequency_ratio = 0, phase = 0
      !> Mean torques of the train, in balance [N m], (body).
      real(dp), allocatable :: torque(:)
      type(flow_type), private :: flow
      !> Rotation per phase of the fundamental v [1] and inertia [kg m^2], (body); v . I v [kg m^2].
      real(dp), allocatable, private :: turns(:), inertia(:)
      real(dp), private :: whole_inertia = 0
      !> Highest order of a mesh [1].
      integer, private :: highest_order = 1
      !> Velocity of each node per velocity of each coordinate [1/m], (node, coordinate).
      real(dp), allocatable, private :: vibration(:, :)
   contains
      procedure :: begin
      procedure :: advance
      procedure :: look
      procedure :: state
      procedure, private :: node_velocities
      procedure, private :: take_drift
   end type simulator_type

contains

   !> Begins at rest under the mean torques, or with a motion, at phase 0.
   subroutine begin(self, train, frequency_ratio, error, start)
      class(simulator_type), target, intent(inout) :: self
      !> A train that has passed `check_train`.
      type(train_type), intent(in) :: train
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> The train has no such speeds, or its torques follow the speed.
      type(error_type), allocatable, intent(inout) :: error
      !> Motion whose state it begins with.
      type(motion_type), intent(in), optional :: start
      type(kinematics_type) :: kinematics
      type(train_type) :: plain
      integer, allocatable :: balancing(:)
      logical, allocatable :: held(:)

      if (.not. allocated(train%bodies)) then
         call fatal(error, 'simulator: needs a train of bodies: give &body, and the names of bodies in between', status_input)
         return
      end if
      call find_kinematics(train, kinematics)
      if (.not. kinematics%known) then
         call fatal(error, 'simulator: needs the teeth of every mesh, from which the speeds of the bodies follow', status_input)
         return
      end if
      call build_system(train, self%system)
      if (size(self%system%network%rigid, 2) /= 1) then
         call fatal(error, 'simulator: the train has '//text(size(self%system%network%rigid, 2))//' rigid motions, and must have &
                    &one, whose speed follows from the torques', status_input)
      else if (allocated(self%system%speed_loads)) then
         call fatal(error, 'simulator: torque_speed_exponent: must be 0: the torques come from outside', status_input)
      end if
      if (allocated(error)) return
      call plain_train(train, plain)
      allocate (self%inertia(size(plain%bodies)), self%torque(size(plain%bodies)), held(size(plain%bodies)))
      call bodies_of(plain, self%inertia, self%torque, balancing, held)
      call balance_torques(self%system%network, self%torque)
      self%highest_order = maxval([1, plain%meshes%order])
      self%turns = merge(0.0_dp, abs(kinematics%turning%speed)*kinematics%speed_ratio, held)
      self%whole_inertia = sum(self%inertia*self%turns**2)
      call find_vibration(self)
      call self%flow%setup(self%system, 1, flow_order, flow_tolerance)
      allocate (self%flow%push(size(self%system%torque)), source=0.0_dp)
      self%flow%x(1, :) = resting_state(self%system)
      if (present(start)) call state_of(self%system, start, self%flow%x(1, :))
      self%frequency_ratio = frequency_ratio
      call self%advance(self%torque, 0.0_dp, error)
   end subroutine begin

   !> Goes on under constant torques; less far where the interrupt of the system is raised.
   subroutine advance(self, torque, duration, error)
      class(simulator_type), target, intent(inout) :: self
      !> Torque on each body besides the alternating torques of the train [N m], (body), positive in its sense of rotation.
      real(dp), intent(in) :: torque(:)
      !> Time [s], >= 0.
      real(dp), intent(in) :: duration
      !> The motion grows without bound, too many contact events fell on one instant, or the step has too many mesh cycles.
      type(error_type), allocatable, intent(inout) :: error
      real(dp) :: excess(size(torque)), acceleration, cycles

      excess = torque - self%torque
      associate (omega => self%system%characteristic_frequency, flow => self%flow)
         acceleration = dot_product(self%turns, excess)/self%whole_inertia
         cycles = (abs(self%frequency_ratio)*omega + abs(acceleration)*duration/2)*duration/(2*pi)*self%highest_order
         if (.not. cycles < most_cycles) then
            call fatal(error, 'simulator: '//text(cycles)//' mesh cycles in one step, at speeds to which the torques lead: &
                       &must be below '//text(most_cycles)//': a shorter duration, or smaller torques', status_input)
            return
         end if
         flow%system => self%system
         flow%push(:size(torque)) = (excess - self%inertia*self%turns*acceleration)/self%system%characteristic_length
         flow%phase = self%phase
         acceleration = acceleration/omega**2
         call flow%start(self%frequency_ratio, 0.0_dp, acceleration)
         call flow%advance(duration*omega)
         self%time = self%time + flow%time/omega
         self%phase = modulo(self%phase + (self%frequency_ratio + acceleration/2*flow%time)*flow%time, 2*pi)
         self%frequency_ratio = self%frequency_ratio + acceleration*flow%time
         if (.not. all(abs(flow%x(1, :)) < huge(1.0_dp))) then
            call fatal(error, 'simulator: the motion grows without bound', status_ended_early)
         else if (flow%lost) then
            call fatal(error, 'simulator: too many contact events fell on one instant: the motion after it would be a guess', &
                       status_ended_early)
         end if
         if (allocated(error)) return
         if (self%system%coordinates > self%system%displacements) call self%take_drift()
         flow%phase = self%phase
         call flow%start(self%frequency_ratio, 0.0_dp, acceleration)
         call flow%expand()
      end associate
   end subroutine advance

   !> What there is at present.
   subroutine look(self, speed, displacement, force, torque)
      class(simulator_type), intent(in) :: self
      !> Speed of each body, positive in its sense of rotation [rad/s], (body).
      real(dp), intent(out) :: speed(:)
      !> Displacement over b_c [1] and force [N], of a coupling torque [N m], of each mesh, (mesh).
      real(dp), intent(out) :: displacement(:), force(:)
      !> Torques of shafts and of what holds bodies [N m], (row); NaN where nothing determines it.
      real(dp), intent(out) :: torque(:)
      real(dp) :: series(0:self%flow%order, self%system%meshes), torques(0:self%flow%order, size(torque)), &
         velocity(size(self%system%network%inertia))
      integer :: i

      associate (system => self%system, flow => self%flow)
         do i = 1, system%meshes
            displacement(i) = flow%p(1, system%mesh_element(i), 0)
            call force_series(flow, i, flow%contact(i), series(:, i))
         end do
         force = series(0, :)
         call torque_series(flow, 0.0_dp, series, torques)
         torque = torques(0, :)
         velocity = self%node_velocities()
         speed = self%turns*self%frequency_ratio*system%characteristic_frequency
         do i = 1, size(speed)
            associate (node => system%network%node(i))
               if (node > 0) speed(i) = speed(i) + velocity(node)
            end associate
         end do
      end associate
   end subroutine look

   !> The state, as a motion has it [1], (state).
   pure function state(self)
      class(simulator_type), intent(in) :: self
      real(dp) :: state(self%system%states)

      state = self%flow%x(1, :)
   end function state

   !> Finds I^-1 B^T (B I^-1 B^T)^-1 of the coordinates: the vibration has no momentum in a rigid motion unless the ground damps it.
   subroutine find_vibration(self)
      class(simulator_type), intent(inout) :: self
      real(dp), allocatable :: mass(:, :), row(:, :)
      integer, allocatable :: pivot(:)
      integer :: info, k, n

      associate (network => self%system%network, count => self%system%coordinates)
         allocate (row(count, size(network%inertia)), pivot(count))
         do k = 1, size(row, 2)
            row(:, k) = [(network%elements(n)%entry_at(k), n=1, count)]
         end do
         allocate (mass(count, count), source=0.0_dp)
         do k = 1, size(row, 2)
            do n = 1, count
               mass(:, n) = mass(:, n) + row(:, k)*(row(n, k)/network%inertia(k))
            end do
         end do
         call factor_matrix(count, mass, pivot, info)
         call solve_factored(count, size(row, 2), mass, pivot, row)
         allocate (self%vibration(size(row, 2), count))
         do k = 1, size(row, 2)
            self%vibration(k, :) = row(:, k)/network%inertia(k)
         end do
      end associate
   end subroutine find_vibration

   !> Velocities of the nodes in the vibration [rad/s], (node).
   pure function node_velocities(self) result(velocity)
      class(simulator_type), intent(in) :: self
      real(dp) :: velocity(size(self%vibration, 1))

      associate (system => self%system)
         velocity = matmul(self%vibration, self%flow%x(1, system%displacements + 1:) &
                           - error_rates(self, self%frequency_ratio))*(system%characteristic_length*system%characteristic_frequency)
      end associate
   end function node_velocities

   !> Rates of the transmission errors of the coordinates [1], (coordinate), at a Lambda.
   pure function error_rates(self, frequency_ratio) result(rate)
      class(simulator_type), intent(in) :: self
      real(dp), intent(in) :: frequency_ratio
      real(dp) :: rate(self%system%coordinates), wave(0:1)
      integer :: j

      rate = 0
      do j = 1, self%system%meshes
         associate (n => self%system%mesh_element(j), error => self%system%transmission_error(j))
            if (n > self%system%coordinates) cycle
            wave = 0
            call add_waves(error%harmonic, error%amplitude, self%phase, frequency_ratio, 0.0_dp, 0.0_dp, wave)
            rate(n) = wave(1)
         end associate
      end do
   end function error_rates

   !> Turns the drift by damping to ground, a rigid motion among the vibration, into speed.
   subroutine take_drift(self)
      class(simulator_type), intent(inout) :: self
      real(dp) :: turns(size(self%system%network%inertia)), drift
      integer :: i, n

      turns = 0
      associate (system => self%system, network => self%system%network)
         do i = 1, size(self%turns)
            if (network%node(i) > 0) turns(network%node(i)) = self%turns(i)
         end do
         drift = sum(network%inertia*turns*self%node_velocities())/self%whole_inertia
         self%frequency_ratio = self%frequency_ratio + drift/system%characteristic_frequency
         ! The bodies turn as before, and the errors pass at the new speed.
         self%flow%x(1, system%displacements + 1:) = self%flow%x(1, system%displacements + 1:) &
                                                     + error_rates(self, drift/system%characteristic_frequency)
         do n = system%displacements + 1, system%coordinates
            associate (element => network%elements(n), x => self%flow%x(1, system%displacements + n))
               x = x - drift*sum(element%entry*turns(element%node))/(system%characteristic_length*system%characteristic_frequency)
            end associate
         end do
      end associate
   end subroutine take_drift

end module geartrain_flow_simulator
