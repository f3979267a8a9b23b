!> The dimensionless system of a train: elastic elements (shafts that are not rigid, and meshes) between nodes. Displacements are
!> over characteristic length, time is times characteristic frequency.
!>
!> Element n: p_n = r_from theta_from - r_to theta_to + e_n (geartrain_network_network). Each force is over k_n b_c: phi = kappa
!> g(p) + gamma p' in a mesh. From I theta'' + B^T F = T and p = B theta + e:
!>    p'' = -W phi + s(t) + e''      (equations (5) with their signs and indices put right)
!> with W = B I^-1 B^T K; W_nm is not 0 only where the elements n and m have a node in common.
module geartrain_network_system
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_base_interrupt, only: interrupt_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_series, only: add_series, make_series, series_type
   use geartrain_mesh_law_law, only: law_type
   use geartrain_network_cut, only: cut_network, cut_type
   use geartrain_train_kinematics, only: find_kinematics, greatest_divisor, kinematics_type
   use geartrain_network_load_sharing, only: find_sharing, sharing_type
   use geartrain_network_mean, only: mean_rows, mean_type
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_network_light_loads, only: reduce_light_loads
   use geartrain_train_mesh_groups, only: mesh_word
   use geartrain_train_body, only: pulses
   use geartrain_train_mesh, only: coupling_radius, put_law
   use geartrain_network_modal_damping, only: resolve_damping
   use geartrain_network_network, only: accelerate, build_network, network_type
   use geartrain_network_rest, only: rest_forces
   use geartrain_network_speed_loads, only: find_speed_loads, speed_loads_type
   use geartrain_network_torque_paths, only: find_torque_paths, torque_paths_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: system_type, build_system, put_excitation, put_speed, shear, static_forces_at

   type :: system_type
      !> Number of meshes and of elements. The displacements of the first `coordinates` elements are the coordinates of the train;
      !> the other elements close loops. A state has the displacements of the first `displacements` coordinates and the velocities
      !> of all coordinates, `states` values: with damping to ground the last coordinate is the vibration of a body, and no force
      !> depends on its displacement.
      integer :: meshes = 0, elements = 0, coordinates = 0, displacements = 0, states = 0
      !> Element of each mesh, (mesh); mesh and shaft of each element, 0 where the element is none, (element).
      integer, allocatable :: mesh_element(:), element_mesh(:), element_shaft(:)
      !> Mean stiffness along the line of action [N/m]; 1, but 0 for damping to ground, whose stiffness is only the unit of its
      !> force [1], (element).
      real(dp), allocatable :: stiffness(:), spring(:)
      !> W_nn [1], (element); W_nm [1] of each neighbour m of element n, (neighbour).
      real(dp), allocatable :: own(:), coupling(:)
      !> neighbour(first(n):first(n + 1) - 1) are the elements with a node in common with element n, ascending.
      integer, allocatable :: first(:), neighbour(:)
      !> gamma = c omega_c/k [1], for a mesh on its drive flank; static force over k b_c [1], (element).
      real(dp), allocatable :: damping(:), static_force(:)
      !> Misfit of the static displacements round loops [1], see `rest_forces`.
      real(dp) :: rest_residual = 0
      !> Displacement of each element that closes a loop where the coordinates and the fluctuating errors are 0 [1], (loop): the
      !> coordinates leave out the static twists of shafts and springs to ground.
      real(dp), allocatable :: loop_offset(:)
      !> Rate at which the determinant of the monodromy decays, every mesh on its drive flank [1].
      real(dp) :: decay = 0
      !> b/b_c [1]; what phi = 1 is: a force [N], or of a coupling a torque [N m]; what phi = 1 does over p = 1 [J], (mesh).
      real(dp), allocatable :: half_backlash(:), load_unit(:), energy_unit(:)
      !> Dry friction over k b_c [1], (mesh).
      real(dp), allocatable :: friction(:)
      !> 'mesh 1', ..., 'coupling 1', ..., (mesh).
      character(20), allocatable :: mesh_name(:)
      !> Force law of each mesh, (mesh).
      type(law_type), allocatable :: law(:)
      !> e/b_c, (mesh).
      type(series_type), allocatable :: transmission_error(:)
      !> Fluctuating torques T/b_c [N m/m] and the bodies on which they act, (torque); dimensionless acceleration of each element
      !> per torque [m/(N m)], (element, torque).
      type(series_type), allocatable :: torque(:)
      integer, allocatable :: torque_body(:)
      real(dp), allocatable :: torque_gain(:, :)
      !> The train as a network; the network cut at its unknown meshes, with backlash or a varying stiffness; the equations of the
      !> mean.
      type(network_type) :: network
      type(cut_type) :: cut
      type(mean_type) :: mean
      !> Planets whose load shares are results.
      type(sharing_type) :: sharing
      !> How the torque of each shaft follows from forces and torques.
      type(torque_paths_type) :: torque_paths
      !> Mean torques that follow the speed; not allocated where all are constant.
      type(speed_loads_type), allocatable :: speed_loads
      !> omega_c [rad/s] and b_c [m].
      real(dp) :: characteristic_frequency = 0, characteristic_length = 0
      !> Greatest common divisor of the excited harmonics of Lambda: a motion of period 1 has only multiples of it.
      integer :: excitation_order = 1
      !> Interrupt of the train, for long work that has a system at hand.
      type(interrupt_type) :: interrupt
   end type system_type

contains

   !> Makes the dimensionless system of a train.
   pure subroutine build_system(given, system, acceleration, unknown, like)
      !> A train that has passed `check_train`.
      type(train_type), intent(in) :: given
      type(system_type), intent(out) :: system
      !> Rate of change of Lambda over time times characteristic frequency [1]; absent: 0. The mean torques are less by what
      !> accelerates the inertias where the teeth tell how fast the bodies turn. The meshes keep their stiffness, which follows the
      !> given torques.
      real(dp), intent(in), optional :: acceleration
      !> Meshes that are unknowns of a balance even without backlash and variation of their stiffness, (mesh).
      logical, intent(in), optional :: unknown(:)
      !> Network of a train that differs in numbers only: the elements are taken in the same order.
      type(network_type), intent(in), optional :: like
      type(train_type) :: train
      type(kinematics_type) :: kinematics
      integer :: i, j, n

      call plain_train(given, train)
      call reduce_light_loads(train)
      call resolve_damping(train)
      system%interrupt = train%interrupt
      system%characteristic_frequency = train%characteristic_frequency
      system%characteristic_length = train%characteristic_length
      system%half_backlash = train%meshes%half_backlash/train%characteristic_length
      call put_excitation(train, system)
      call build_network(train, system%network, unknown, like)
      if (present(acceleration)) then
         call find_kinematics(given, kinematics)
         if (kinematics%known) call accelerate(system%network, abs(kinematics%turning%speed)*kinematics%speed_ratio &
                                               *acceleration*train%characteristic_frequency**2)
      end if
      associate (elements => system%network%elements)
         system%elements = size(elements)
         system%coordinates = system%network%coordinates
         system%displacements = system%network%displacements
         system%states = system%displacements + system%coordinates
         system%spring = merge(1.0_dp, 0.0_dp, elements%elastic)
         system%element_mesh = elements%mesh
         system%element_shaft = elements%shaft
         system%stiffness = elements%stiffness
         system%damping = elements%damping*system%characteristic_frequency/elements%stiffness
      end associate
      allocate (system%mesh_element(system%meshes))
      do n = 1, system%elements
         if (system%element_mesh(n) == 0) cycle
         system%mesh_element(system%element_mesh(n)) = n
         call system%law(system%element_mesh(n))%complete(system%damping(n))
      end do
      system%mesh_name = [(mesh_word(train%meshes, i), i=1, system%meshes)]
      system%load_unit = system%stiffness(system%mesh_element)*system%characteristic_length &
                         *merge(coupling_radius, 1.0_dp, train%meshes%is_coupling)
      system%friction = train%meshes%friction_torque/system%load_unit
      system%energy_unit = system%stiffness(system%mesh_element)*system%characteristic_length**2
      call couple(system%network, system)
      allocate (system%static_force(system%elements))
      call find_sharing(train, system%sharing)
      call find_torque_paths(train, system%network, system%torque_body, system%torque_paths)
      call cut_network(system%network, system%cut)
      call put_rest(system)
      call find_speed_loads(train, system%network, system%torque_body, system%torque_gain, system%torque_paths, system%speed_loads)
      if (allocated(system%speed_loads)) call find_mean_rates(system)
      do i = 1, size(system%torque)
         associate (node => system%network%node(system%torque_body(i)))
            if (node > 0 .and. size(system%torque(i)%amplitude) > 0) system%cut%part(system%cut%home(node))%excited = .true.
         end associate
      end do
      do n = 1, size(system%cut%part)
         associate (part => system%cut%part(n))
            do i = 1, size(part%element) + size(part%ground_element)
               if (i <= size(part%element)) then
                  j = system%element_mesh(part%element(i))
               else
                  j = system%element_mesh(part%ground_element(i - size(part%element)))
               end if
               if (j == 0) cycle
               if (size(system%transmission_error(j)%amplitude) > 0) part%excited = .true.
            end do
         end associate
      end do
   end subroutine build_system

   !> Sets the forces at rest and what follows from them, of the present torques.
   pure subroutine put_rest(system)
      type(system_type), intent(inout) :: system

      call rest_forces(system%network, system%law, system%characteristic_length, system%static_force, &
                       system%rest_residual)
      system%static_force = system%static_force/(system%stiffness*system%characteristic_length)
      system%loop_offset = matmul(system%network%loop, merge(system%static_force(:system%coordinates), 0.0_dp, &
                                                             system%element_mesh(:system%coordinates) == 0)) &
                           + system%network%misfit/system%characteristic_length
      call mean_rows(system%network, system%cut, system%static_force, &
                     system%network%misfit/system%characteristic_length, system%mean)
   end subroutine put_rest

   !> Takes the mean torques at a speed, where torques follow it: all static forces become those at this speed.
   pure subroutine put_speed(system, frequency_ratio)
      type(system_type), intent(inout) :: system
      !> Lambda [1], > 0.
      real(dp), intent(in) :: frequency_ratio

      if (.not. allocated(system%speed_loads)) return
      call put_factors(system, system%speed_loads%factors_at(frequency_ratio))
   end subroutine put_speed

   !> Force of each element at rest under the mean torques at a speed, over k b_c [1], (element).
   pure function static_forces_at(system, frequency_ratio) result(force)
      type(system_type), intent(in) :: system
      !> Lambda [1], > 0.
      real(dp), intent(in) :: frequency_ratio
      real(dp) :: force(system%elements)
      type(system_type), allocatable :: there

      force = system%static_force
      if (.not. allocated(system%speed_loads)) return
      there = system
      call put_speed(there, frequency_ratio)
      force = there%static_force
   end function static_forces_at

   !> Takes the mean torques with a factor of each load that follows the speed.
   pure subroutine put_factors(system, factor)
      type(system_type), intent(inout) :: system
      real(dp), intent(in) :: factor(:)

      associate (loads => system%speed_loads)
         if (all(abs(factor - loads%factor) <= 0)) return
         loads%factor = factor
         system%network%torque = loads%all_torque + matmul(loads%torque, factor - 1)
         system%network%magnitude = loads%magnitude + matmul(abs(loads%torque), abs(factor - 1))
         system%torque_paths%constant = loads%all_constant + matmul(loads%constant, factor - 1)
      end associate
      call put_rest(system)
   end subroutine put_factors

   !> Sets the effects of the loads that follow the speed on the mean equations, which are linear in the torques.
   pure subroutine find_mean_rates(system)
      type(system_type), intent(inout) :: system
      real(dp) :: factor(size(system%speed_loads%factor)), given(size(system%mean%static_force))
      integer :: k

      given = system%mean%static_force
      allocate (system%speed_loads%mean(size(given), size(factor)))
      do k = 1, size(factor)
         factor = 1
         factor(k) = 2
         call put_factors(system, factor)
         system%speed_loads%mean(:, k) = system%mean%static_force - given
      end do
      factor = 1
      call put_factors(system, factor)
   end subroutine find_mean_rates

   !> Sets W and the accelerations by torques.
   pure subroutine couple(network, system)
      type(network_type), intent(in) :: network
      type(system_type), intent(inout) :: system
      real(dp) :: w
      integer :: n, m, count
      !> Which elements are at each node, (element, node); which of them have a node in common with an element, (element).
      logical, allocatable :: at(:, :), near(:)

      allocate (at(system%elements, size(network%inertia)), source=.false.)
      do m = 1, system%elements
         at(m, network%elements(m)%node) = .true.
      end do
      allocate (system%own(system%elements), system%first(system%elements + 1), &
                system%torque_gain(system%elements, size(system%torque)))
      allocate (system%neighbour(4*system%elements), system%coupling(4*system%elements))
      count = 0
      do n = 1, system%elements
         system%first(n) = count + 1
         do m = 1, size(system%torque)
            associate (node => network%node(system%torque_body(m)))
               system%torque_gain(n, m) = 0
               if (node > 0) system%torque_gain(n, m) = network%elements(n)%entry_at(node) &
                                                        /(network%inertia(node)*system%characteristic_frequency**2)
            end associate
         end do
         near = any(at(:, network%elements(n)%node), 2)
         do m = 1, system%elements
            if (.not. near(m)) cycle
            w = inverse_inertia(n, m)*system%stiffness(m)/system%characteristic_frequency**2
            if (m == n) then
               system%own(n) = w
               cycle
            end if
            count = count + 1
            if (count > size(system%neighbour)) then
               system%neighbour = [system%neighbour, system%neighbour]
               system%coupling = [system%coupling, system%coupling]
            end if
            system%neighbour(count) = m
            system%coupling(count) = w
         end do
      end do
      system%first(system%elements + 1) = count + 1
      system%neighbour = system%neighbour(:count)
      system%coupling = system%coupling(:count)
      ! The trace of W diag(gamma) over all elements is the trace of the damping matrix of the coordinates.
      system%decay = sum(system%own*system%damping)

   contains

      !> B_n I^-1 B_m [1/kg].
      pure real(dp) function inverse_inertia(n, m)
         integer, intent(in) :: n, m
         integer :: i

         inverse_inertia = 0
         associate (a => network%elements(n))
            do i = 1, size(a%node)
               inverse_inertia = inverse_inertia + a%entry(i)*network%elements(m)%entry_at(a%node(i))/network%inertia(a%node(i))
            end do
         end associate
      end function inverse_inertia

   end subroutine couple

   !> Saltation of tangents where the damping of a mesh changes by `jump` at a wall: subtracts column `element` of W times `jump`
   !> times the displacement of the element from the velocities. (The force jumps by `jump` times the mesh velocity, and the
   !> saltation matrix divides by this velocity.)
   pure subroutine shear(system, element, jump, displacement, velocity)
      type(system_type), intent(in) :: system
      !> Element of the mesh.
      integer, intent(in) :: element
      !> Damping gamma after the wall less damping before the wall [1].
      real(dp), intent(in) :: jump
      !> Displacements of the tangents [1], (column, displacement).
      real(dp), intent(in) :: displacement(:, :)
      !> Velocities of the tangents [1], (column, coordinate).
      real(dp), intent(inout) :: velocity(:, :)
      real(dp) :: change(size(displacement, 1))
      integer :: i, k, m

      if (element <= system%coordinates) then
         change = jump*displacement(:, element)
         velocity(:, element) = velocity(:, element) - system%own(element)*change
      else
         change = jump*matmul(displacement, system%network%loop(element - system%coordinates, :size(displacement, 2)))
      end if
      do i = system%first(element), system%first(element + 1) - 1
         m = system%neighbour(i)
         if (m > system%coordinates) cycle
         do k = system%first(m), system%first(m + 1) - 1
            if (system%neighbour(k) == element) velocity(:, m) = velocity(:, m) - system%coupling(k)*change
         end do
      end do
   end subroutine shear

   !> Sets the excitation of a system: torques, force laws of the meshes, transmission errors, excitation_order.
   pure subroutine put_excitation(train, system)
      !> A plain train (geartrain_drawing_drawing) that is in order (geartrain_network_limits).
      type(train_type), intent(in) :: train
      !> Gets the excitation and the number of meshes; nothing else is set.
      type(system_type), intent(inout) :: system
      integer, allocatable :: turning(:)
      integer :: j, n

      system%meshes = size(train%meshes)
      allocate (system%law(system%meshes), system%transmission_error(system%meshes))
      associate (bc => train%characteristic_length)
         if (allocated(train%bodies)) then
            n = size(train%bodies)
            turning = pack([(j, j=1, n)], pulses(train%bodies))
            system%torque_body = [(j, j=1, n), turning]
            allocate (system%torque(n + size(turning)))
            do j = 1, n
               system%torque(j) = make_series(train%bodies(j)%torque_cos, train%bodies(j)%torque_sin, 1/bc, 1)
            end do
            do j = 1, size(turning)
               associate (body => train%bodies(turning(j)))
                  system%torque(n + j) = make_series(body%revolution_torque_cos, body%revolution_torque_sin, 1/bc, &
                                                     body%revolution_order)
               end associate
            end do
         else
            system%torque_body = [1]
            allocate (system%torque(1))
            system%torque(1) = make_series(train%torque_cos, train%torque_sin, 1/bc, 1)
         end if
         do j = 1, system%meshes
            associate (mesh => train%meshes(j))
               call put_law(mesh, bc, system%law(j))
               system%transmission_error(j) = make_series(mesh%error_cos, mesh%error_sin, 1/bc, mesh%order)
               do n = 1, 2
                  associate (gear => mesh%gear_error(n))
                     call add_series(make_series(gear%cosine, gear%sine, 1/bc, gear%order), system%transmission_error(j))
                  end associate
               end do
            end associate
         end do
      end associate
      system%excitation_order = common_order(system)
   end subroutine put_excitation

   !> Greatest common divisor of the excited harmonics of Lambda; 1 without excitation.
   pure integer function common_order(system)
      type(system_type), intent(in) :: system
      integer :: j

      common_order = 0
      do j = 1, size(system%torque)
         call add(system%torque(j), common_order)
      end do
      do j = 1, system%meshes
         call add(system%law(j)%variation(), common_order)
         call add(system%transmission_error(j), common_order)
      end do
      if (common_order == 0) common_order = 1

   contains

      pure subroutine add(series, divisor)
         type(series_type), intent(in) :: series
         integer, intent(inout) :: divisor
         integer :: h

         do h = 1, size(series%amplitude)
            if (abs(series%amplitude(h)) > 0) divisor = int(greatest_divisor(int(divisor, int64), int(series%harmonic(h), int64)))
         end do
      end subroutine add

   end function common_order

end module geartrain_network_system
