!> A train as a network, in SI units: nodes, and the elastic elements, shafts and meshes, that join them. A node is a body, or
!> several bodies on rigid shafts.
!>
!> A rotation theta is positive in the sense in which the body turns when the train runs. With x = radius theta and the reduced
!> radii of the nodes, all x are equal where the train turns without deflection, and every element is a spring between two masses.
module geartrain_model_network
   use geartrain_base_kinds, only: dp
   use geartrain_model_bodies, only: bodies_of, body_count, find_ends
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: network_type, element_type, accelerate, build_network, join_rigid, state_count, vibrating

   !> A shaft or a mesh with the displacement p = radius(1) theta_from - radius(2) theta_to; or damping to ground.
   type :: element_type
      !> Number of the shaft or of the mesh in the train; 0 where the element is none.
      integer :: shaft = 0, mesh = 0
      !> The nodes that the element joins; of a mesh `from` has the driving gear.
      integer :: from = 0, to = 0
      !> Radii at the two nodes [m]: base radii of the gears; two equal ones for a shaft, of any length.
      real(dp) :: radius(2) = 0
      !> Stiffness [N/m] and damping [N s/m] along the line of action.
      real(dp) :: stiffness = 0, damping = 0
      !> A mesh with backlash or a varying stiffness: an unknown of the harmonic balance.
      logical :: unknown = .false.
      !> Damping to ground of the node `from`; `to` is this node too, at radius 0. The displacement is the vibration of the node;
      !> the stiffness only is the unit of the force.
      logical :: grounded = .false.
   end type element_type

   type :: network_type
      !> Node of each body of the train (geartrain_model_bodies), (body).
      integer, allocatable :: node(:)
      !> Inertia [kg m^2] and reduced radius [m], (node).
      real(dp), allocatable :: inertia(:), radius(:)
      !> Mean angular acceleration [rad/s^2], 0 but in a run-up; given mean torque less the torque that accelerates the inertia
      !> [N m], (node).
      real(dp), allocatable :: acceleration(:), torque(:)
      !> Sum of the magnitudes of the torques on the bodies of a node [N m], (node): the scale of the rounding of `torque`.
      real(dp), allocatable :: magnitude(:)
      !> Damping to ground [N m s/rad], (node).
      real(dp), allocatable :: damping(:)
      !> The node whose mean torque balances the torques on all others.
      integer :: balancing = 0
      !> In this order: the elements of a tree that joins all nodes, each with a node in common with an element before it; where
      !> there is damping to ground, one grounded element; the elements that close loops, unknown meshes wherever a loop has one;
      !> the other grounded elements. The displacements of the tree and of the first grounded element are the coordinates of the
      !> network.
      type(element_type), allocatable :: elements(:)
      !> Number of coordinates; number of coordinates without the grounded element, of which only the velocity matters.
      integer :: coordinates = 0, displacements = 0
      !> Loop matrix C: displacement of each element after the coordinates per displacement of each coordinate [1], (loop,
      !> coordinate). A force in such an element is taken, times C, from the forces of the tree.
      real(dp), allocatable :: loop(:, :)
      !> Number of each element but those with damping to ground in the order shaft 1, mesh 1, shaft 2, ...
      integer, allocatable :: order(:)
   end type network_type

contains

   !> Makes the network of a train.
   pure subroutine build_network(train, network, unknown, order)
      !> A plain train (geartrain_model_drawing) that has passed `check_train`.
      type(train_type), intent(in) :: train
      !> The network.
      type(network_type), intent(out) :: network
      !> Meshes that are unknowns in any case, (mesh).
      logical, intent(in), optional :: unknown(:)
      !> `order` of the network of a train that differs in numbers only: its elements are taken in the same order.
      integer, intent(in), optional :: order(:)
      type(element_type), allocatable :: elements(:)
      integer :: n

      call join_rigid(train, network)
      call list_elements(train, network, elements)
      if (present(unknown)) then
         do n = 1, size(elements)
            if (elements(n)%mesh > 0) elements(n)%unknown = elements(n)%unknown .or. unknown(elements(n)%mesh)
         end do
      end if
      network%displacements = size(network%inertia) - 1
      network%coordinates = network%displacements
      if (present(order)) then
         network%order = order
      else
         call sort_elements(elements, in_tree(elements, size(network%inertia)), size(network%inertia), network%order)
      end if
      network%elements = elements(network%order)
      call find_radii(network)
      if (any(network%damping > 0)) call add_grounded(network)
      call find_loops(network)
   end subroutine build_network

   !> Lets the whole train accelerate: the torques that accelerate the inertias are taken from the mean torques.
   pure subroutine accelerate(network, body, rate)
      !> The network of a train at constant speed.
      type(network_type), intent(inout) :: network
      !> A body of the train.
      integer, intent(in) :: body
      !> Its mean angular acceleration [rad/s^2].
      real(dp), intent(in) :: rate

      network%acceleration = rate*network%radius(network%node(body))/network%radius
      associate (taken => network%inertia*network%acceleration)
         network%torque = network%torque - taken
         network%magnitude = network%magnitude + abs(taken)
      end associate
   end subroutine accelerate

   !> Number of values of a state: displacements and velocities of the elements of the tree and, with damping to ground, one more
   !> velocity. 0 for a train without bodies.
   pure integer function state_count(train)
      !> The train; its shafts are allocated.
      type(train_type), intent(in) :: train
      type(network_type) :: network

      state_count = 0
      if (body_count(train) == 0) return
      call join_rigid(train, network)
      state_count = 2*(size(network%inertia) - 1) + merge(1, 0, any(network%damping > 0))
   end function state_count

   !> Makes the nodes, numbered in the order of their first bodies.
   pure subroutine join_rigid(train, network)
      !> The train.
      type(train_type), intent(in) :: train
      !> Gets node, inertia, acceleration, torque, magnitude, damping and balancing.
      type(network_type), intent(out) :: network
      real(dp), dimension(body_count(train)) :: inertia, torque
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      integer :: root(body_count(train)), balancing, i, nodes

      call bodies_of(train, inertia, torque, balancing)
      call find_ends(train, shaft_ends, mesh_ends)
      root = [(i, i=1, size(root))]
      do i = 1, size(train%shafts)
         if (.not. train%shafts(i)%rigid) cycle
         associate (ends => shaft_ends(:, i))
            where (root == maxval(root(ends))) root = minval(root(ends))
         end associate
      end do
      allocate (network%node(size(root)))
      nodes = 0
      do i = 1, size(root)
         if (root(i) == i) nodes = nodes + 1
         network%node(i) = merge(nodes, network%node(root(i)), root(i) == i)
      end do
      allocate (network%inertia(nodes), network%acceleration(nodes), network%torque(nodes), network%magnitude(nodes), &
                network%damping(nodes), source=0.0_dp)
      do i = 1, size(root)
         associate (node => network%node(i))
            network%inertia(node) = network%inertia(node) + inertia(i)
            network%torque(node) = network%torque(node) + torque(i)
            network%magnitude(node) = network%magnitude(node) + abs(torque(i))
            if (allocated(train%bodies)) network%damping(node) = network%damping(node) + train%bodies(i)%damping_to_ground
         end associate
      end do
      network%balancing = network%node(max(1, balancing))
   end subroutine join_rigid

   !> Lists elastic shafts and meshes in the order shaft 1, mesh 1, shaft 2, ...
   pure subroutine list_elements(train, network, elements)
      type(train_type), intent(in) :: train
      type(network_type), intent(in) :: network
      type(element_type), allocatable, intent(out) :: elements(:)
      real(dp), dimension(body_count(train)) :: inertia, torque
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      integer :: balancing, i, n

      call bodies_of(train, inertia, torque, balancing)
      call find_ends(train, shaft_ends, mesh_ends)
      allocate (elements(size(train%meshes) + count(.not. train%shafts%rigid)))
      n = 0
      do i = 1, max(size(train%shafts), size(train%meshes))
         if (i <= size(train%shafts)) then
            if (.not. train%shafts(i)%rigid) then
               n = n + 1
               call make_shaft(train, network, i, shaft_ends(:, i), mesh_ends, inertia, elements(n))
            end if
         end if
         if (i > size(train%meshes)) cycle
         n = n + 1
         call make_mesh(train, network, i, mesh_ends(:, i), inertia, elements(n))
      end do
   end subroutine list_elements

   pure subroutine make_shaft(train, network, i, ends, mesh_ends, inertia, element)
      type(train_type), intent(in) :: train
      type(network_type), intent(in) :: network
      !> Number of the shaft; its two bodies; the two bodies of each mesh, (2, mesh).
      integer, intent(in) :: i, ends(2), mesh_ends(:, :)
      !> Of the bodies [kg m^2], (body).
      real(dp), intent(in) :: inertia(:)
      type(element_type), intent(inout) :: element

      element%shaft = i
      element%from = network%node(ends(1))
      element%to = network%node(ends(2))
      element%radius = base_radius(train, measuring_gear(network%node, mesh_ends, [element%from, element%to]))
      associate (shaft => train%shafts(i))
         element%stiffness = shaft%stiffness/element%radius(1)**2
         element%damping = 2*shaft%damping_ratio*sqrt(shaft%stiffness/sum(1/vibrating(network, inertia, ends, &
                                                                                                  allocated(train%bodies))))
         if (shaft%damping_given) element%damping = shaft%damping
         element%damping = element%damping/element%radius(1)**2
      end associate
   end subroutine make_shaft

   pure subroutine make_mesh(train, network, i, ends, inertia, element)
      type(train_type), intent(in) :: train
      type(network_type), intent(in) :: network
      !> Number of the mesh; its two bodies.
      integer, intent(in) :: i, ends(2)
      !> Of the bodies [kg m^2], (body).
      real(dp), intent(in) :: inertia(:)
      type(element_type), intent(inout) :: element

      element%mesh = i
      element%from = network%node(ends(1))
      element%to = network%node(ends(2))
      associate (mesh => train%meshes(i))
         element%radius = [mesh%driving_radius, mesh%driven_radius]
         element%stiffness = mesh%stiffness
         element%damping = 2*mesh%damping_ratio*sqrt(mesh%stiffness/sum(element%radius**2/vibrating(network, inertia, ends, &
                                                                                                    .true.)))
         if (mesh%damping_given) element%damping = mesh%damping
         element%unknown = mesh%half_backlash > 0 .or. varies(mesh%stiffness_cos) .or. varies(mesh%stiffness_sin)
      end associate

   contains

      pure logical function varies(amplitude)
         real(dp), allocatable, intent(in) :: amplitude(:)

         varies = .false.
         if (allocated(amplitude)) varies = any(abs(amplitude) > 0)
      end function varies

   end subroutine make_mesh

   !> Inertias at the ends of an element to which its damping ratio refers [kg m^2]: the inertia of each body as given. A body
   !> without inertia, and a shaft end of a train without &body, counts with all bodies that are rigidly joined to it.
   pure function vibrating(network, inertia, ends, own)
      !> Network with its nodes.
      type(network_type), intent(in) :: network
      !> Of the bodies [kg m^2], (body).
      real(dp), intent(in) :: inertia(:)
      !> The two bodies.
      integer, intent(in) :: ends(2)
      !> The inertias of the bodies themselves count.
      logical, intent(in) :: own
      real(dp) :: vibrating(2)

      vibrating = network%inertia(network%node(ends))
      if (own) vibrating = merge(inertia(ends), vibrating, inertia(ends) > 0)
   end function vibrating

   !> The gear along whose base radius the twist of a shaft is measured, as mesh and end (1: driving): a driving gear on one of the
   !> nodes of the shaft; else a driven gear there; else the first driving gear.
   pure function measuring_gear(node, mesh_ends, nodes) result(gear)
      !> Node of each body; the two bodies of each mesh, (2, mesh); the two nodes of the shaft.
      integer, intent(in) :: node(:), mesh_ends(:, :), nodes(2)
      integer :: gear(2), i, side

      gear = 1
      do side = 2, 1, -1
         do i = size(mesh_ends, 2), 1, -1
            if (any(nodes == node(mesh_ends(side, i)))) gear = [i, side]
         end do
      end do
   end function measuring_gear

   !> Base radius [m] of a gear that `measuring_gear` gives.
   pure real(dp) function base_radius(train, gear)
      !> A plain train.
      type(train_type), intent(in) :: train
      !> Mesh and end.
      integer, intent(in) :: gear(2)

      base_radius = train%meshes(gear(1))%driving_radius
      if (gear(2) == 2) base_radius = train%meshes(gear(1))%driven_radius
   end function base_radius

   !> Chooses the elements of a tree: linear elements first, in order of falling stiffness.
   pure function in_tree(given, nodes) result(chosen)
      type(element_type), intent(in) :: given(:)
      integer, intent(in) :: nodes
      logical :: chosen(size(given)), left(size(given))
      integer :: root(nodes), i, n

      root = [(i, i=1, nodes)]
      chosen = .false.
      left = .true.
      if (size(given) == nodes - 1) chosen = .true.
      do while (count(chosen) < nodes - 1)
         n = maxloc(given%stiffness, 1, left .and. .not. given%unknown)
         if (n == 0) n = findloc(left, .true., 1)
         left(n) = .false.
         associate (ends => root([given(n)%from, given(n)%to]))
            if (ends(1) == ends(2)) cycle
            chosen(n) = .true.
            where (root == maxval(ends)) root = minval(ends)
         end associate
      end do
   end function in_tree

   !> Sorts the elements: first the tree in the order of a search from a node at an end, so a chain from one end to the other; then
   !> the rest.
   pure subroutine sort_elements(given, chosen, nodes, order)
      type(element_type), intent(in) :: given(:)
      logical, intent(in) :: chosen(:)
      integer, intent(in) :: nodes
      !> Numbers of the elements, sorted.
      integer, allocatable, intent(out) :: order(:)
      integer :: place(nodes), degree(nodes), depth, i, n
      logical :: met(nodes)

      degree = 0
      do i = 1, size(given)
         degree(given(i)%from) = degree(given(i)%from) + 1
         degree(given(i)%to) = degree(given(i)%to) + 1
      end do
      allocate (order(size(given)))
      met = .false.
      depth = 1
      place(1) = max(1, findloc(degree, 1, 1))
      met(place(1)) = .true.
      n = 0
      search: do while (depth > 0)
         do i = 1, size(given)
            if (.not. chosen(i)) cycle
            associate (here => place(depth), from => given(i)%from, to => given(i)%to)
               if (.not. (from == here .and. .not. met(to) .or. to == here .and. .not. met(from))) cycle
               n = n + 1
               order(n) = i
               place(depth + 1) = merge(to, from, from == here)
            end associate
            depth = depth + 1
            met(place(depth)) = .true.
            cycle search
         end do
         depth = depth - 1
      end do search
      order(n + 1:) = pack([(i, i=1, size(given))], .not. chosen)
   end subroutine sort_elements

   !> Adds an element for each node with damping to ground.
   pure subroutine add_grounded(network)
      type(network_type), intent(inout) :: network
      type(element_type) :: grounded(count(network%damping > 0))
      integer :: i

      grounded%grounded = .true.
      grounded%from = pack([(i, i=1, size(network%damping))], network%damping > 0)
      grounded%to = grounded%from
      grounded%radius(1) = network%radius(grounded%from)
      grounded%damping = network%damping(grounded%from)/grounded%radius(1)**2
      grounded%stiffness = network%elements(1)%stiffness
      associate (d => network%displacements)
         network%elements = [network%elements(:d), grounded(1), network%elements(d + 1:), grounded(2:)]
         network%coordinates = d + 1
      end associate
   end subroutine add_grounded

   !> Sets the loop matrix: the coordinates give x of every node along the tree, and x of two nodes the displacement of an element.
   pure subroutine find_loops(network)
      type(network_type), intent(inout) :: network
      !> x of each node per displacement of the coordinates.
      real(dp), allocatable :: x(:, :)
      integer :: i, n
      logical :: met(size(network%inertia))

      allocate (network%loop(size(network%elements) - network%coordinates, network%coordinates))
      if (size(network%loop, 1) == 0) return
      allocate (x(network%coordinates, size(network%inertia)), source=0.0_dp)
      met = .false.
      met(network%elements(1)%from) = .true.
      do n = 1, network%displacements
         associate (element => network%elements(n))
            if (met(element%from)) then
               x(:, element%to) = x(:, element%from)
               x(n, element%to) = -1/gain(element)
            else
               x(:, element%from) = x(:, element%to)
               x(n, element%from) = 1/gain(element)
            end if
            met([element%from, element%to]) = .true.
         end associate
      end do
      if (network%coordinates > network%displacements) then
         ! x relative to the node whose vibration is the last coordinate.
         x = x - spread(x(:, network%elements(network%coordinates)%from), 2, size(x, 2))
         x(network%coordinates, :) = 1
      end if
      do i = 1, size(network%loop, 1)
         associate (element => network%elements(network%coordinates + i))
            network%loop(i, :) = gain(element)*x(:, element%from)
            if (.not. element%grounded) network%loop(i, :) = network%loop(i, :) - gain(element)*x(:, element%to)
         end associate
      end do

   contains

      !> Displacement of an element per difference of x.
      pure real(dp) function gain(element)
         type(element_type), intent(in) :: element

         gain = element%radius(1)/network%radius(element%from)
      end function gain

   end subroutine find_loops

   !> Finds the reduced radii; the first node of the first element has the radius of this element.
   pure subroutine find_radii(network)
      type(network_type), intent(inout) :: network
      integer :: n

      allocate (network%radius(size(network%inertia)), source=0.0_dp)
      network%radius(network%elements(1)%from) = network%elements(1)%radius(1)
      do n = 1, size(network%elements)
         associate (element => network%elements(n), radius => network%radius)
            if (.not. radius(element%to) > 0) then
               radius(element%to) = radius(element%from)*(element%radius(2)/element%radius(1))
            else if (.not. radius(element%from) > 0) then
               radius(element%from) = radius(element%to)*(element%radius(1)/element%radius(2))
            end if
         end associate
      end do
   end subroutine find_radii

end module geartrain_model_network
