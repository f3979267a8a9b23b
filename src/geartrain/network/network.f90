!> A train as a network, in SI units: nodes, and the elastic elements, shafts and meshes, between them. A node is a body, or several
!> bodies on rigid shafts. Every element is a row of B: its displacement is the sum of entries times the rotations of nodes.
!>
!> A rotation theta is positive in the sense in which the body turns when the train runs. Elements with two entries are springs
!> between masses: with x = radius theta and the reduced radii of the nodes, x is equal at both ends where the element is not
!> displaced.
module geartrain_network_network
   use geartrain_base_kinds, only: dp
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
   use geartrain_linalg_rows, only: rows_type
   use geartrain_network_elements, only: element_type, list_elements, radius_at
   use geartrain_network_nodes, only: join_rigid, nodes_type
   use geartrain_train_bodies, only: body_count
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: network_type, accelerate, balance_torques, balances, build_network, locks, state_count, stiffening

   type, extends(nodes_type) :: network_type
      !> Reduced radius [m], (node).
      real(dp), allocatable :: radius(:)
      !> Rotation of the nodes in the rigid motions, which displace no elastic element, (node, motion).
      real(dp), allocatable :: rigid(:, :)
      !> In this order: independent elastic elements; dampers to ground that are independent of them; the elastic elements that
      !> follow, which close loops, unknown meshes wherever a loop has one; the other dampers to ground. The displacements of the
      !> independent elements are the coordinates of the network.
      type(element_type), allocatable :: elements(:)
      !> Number of coordinates; number of coordinates without dampers, of which only the velocities matter.
      integer :: coordinates = 0, displacements = 0
      !> Loop matrix C: displacement of each element after the coordinates per displacement of each coordinate [1], (loop,
      !> coordinate). A force in such an element is taken, times C, from the forces of the coordinates.
      real(dp), allocatable :: loop(:, :)
      !> Displacement of each element after the coordinates where the coordinates are 0, by constant errors [m], (loop).
      real(dp), allocatable :: misfit(:)
      !> Number of each element of `elements` in the order shaft 1, mesh 1, shaft 2, ..., springs, dampers.
      integer, allocatable :: order(:)
   end type network_type

contains

   !> Makes the network of a train.
   pure subroutine build_network(train, network, unknown, like)
      !> A plain train (geartrain_drawing_drawing) that has passed `check_train`.
      type(train_type), intent(in) :: train
      type(network_type), intent(out) :: network
      !> Meshes that are unknowns in any case, (mesh).
      logical, intent(in), optional :: unknown(:)
      !> Network of a train that differs in numbers only: its elements are taken in the same order.
      type(network_type), intent(in), optional :: like
      type(element_type), allocatable :: elements(:)
      integer :: n

      call join_rigid(train, network)
      call list_elements(train, network, elements)
      if (present(unknown)) then
         do n = 1, size(elements)
            if (elements(n)%mesh > 0) elements(n)%unknown = elements(n)%unknown .or. unknown(elements(n)%mesh)
         end do
      end if
      call sort_elements(elements, network, like)
      network%elements = elements(network%order)
      call find_radii(network)
      do n = 1, size(network%elements)
         associate (element => network%elements(n))
            if (.not. element%elastic) call put_damper(network, element)
         end associate
      end do
      call find_loops(network)
   end subroutine build_network

   !> Lets the whole train accelerate: the torques that accelerate the inertias are taken from the mean torques.
   pure subroutine accelerate(network, rate)
      !> The network of a train at constant speed.
      type(network_type), intent(inout) :: network
      !> Mean angular acceleration of each body in its sense [rad/s^2], (body).
      real(dp), intent(in) :: rate(:)
      integer :: i

      do i = 1, size(rate)
         if (network%node(i) > 0) network%acceleration(network%node(i)) = rate(i)
      end do
      associate (taken => network%inertia*network%acceleration)
         network%torque = network%torque - taken
         network%magnitude = network%magnitude + abs(taken)
      end associate
   end subroutine accelerate

   !> Sets the mean torques of the balancing bodies: the torques do no work on a rigid motion.
   pure subroutine balance_torques(network, torque)
      type(network_type), intent(in) :: network
      !> Mean torques on the bodies [N m], (body).
      real(dp), intent(inout) :: torque(:)
      real(dp) :: work(size(network%balancing), size(network%balancing)), needed(size(network%balancing))
      integer :: pivot(size(network%balancing)), i, info, k

      torque(network%balancing) = 0
      needed = 0
      do i = 1, size(torque)
         if (network%node(i) > 0) needed = needed - torque(i)*network%rigid(network%node(i), :)
      end do
      if (size(needed) == 1) then
         torque(network%balancing) = needed/network%rigid(network%node(network%balancing(1)), 1)
      else if (size(needed) > 1) then
         do k = 1, size(needed)
            work(:, k) = network%rigid(network%node(network%balancing(k)), :)
         end do
         call factor_matrix(size(needed), work, pivot, info)
         call solve_factored(size(needed), 1, work, pivot, needed)
         torque(network%balancing) = needed
      end if
   end subroutine balance_torques

   !> Whether the torques of the balancing bodies can balance all others: they do work on every rigid motion.
   pure logical function balances(network)
      type(network_type), intent(in) :: network
      real(dp) :: work(size(network%balancing), size(network%balancing)), scale(size(network%balancing))
      integer :: pivot(size(network%balancing)), i, info

      balances = size(network%rigid, 2) == size(network%balancing) .and. all(network%node(network%balancing) > 0)
      if (.not. balances) return
      scale = maxval(abs(network%rigid), 1)
      do i = 1, size(scale)
         work(:, i) = network%rigid(network%node(network%balancing(i)), :)/scale
      end do
      ! No motion without work of one of them.
      call factor_matrix(size(scale), work, pivot, info)
      balances = info == 0
      if (balances) balances = all([(abs(work(i, i)) > 1e-12_dp, i=1, size(scale))])
   end function balances

   !> Sets radius, stiffness and damping of a damper, whose displacement is the reduced displacement of its node.
   pure subroutine put_damper(network, element)
      type(network_type), intent(in) :: network
      type(element_type), intent(inout) :: element

      associate (node => element%node(1))
         element%entry = [network%radius(node)]
         element%damping = network%damping(node)/network%radius(node)**2
      end associate
      element%stiffness = network%elements(1)%stiffness
   end subroutine put_damper

   !> Sorts the elements (network_type), and sets the numbers of coordinates.
   pure subroutine sort_elements(given, network, like)
      type(element_type), intent(in) :: given(:)
      !> Network with its nodes; gets `order`, `coordinates`, `displacements` and `rigid`.
      type(network_type), intent(inout) :: network
      type(network_type), intent(in), optional :: like
      logical, dimension(size(given)) :: chosen, elastic, left, known
      logical :: same, loops
      type(rows_type) :: rows
      integer :: n, next, nodes

      nodes = size(network%inertia)
      call rows%setup(nodes, 0)
      same = present(like)
      if (same) same = size(given) == size(like%order)
      if (same) then
         network%order = like%order
         network%coordinates = like%coordinates
         network%displacements = like%displacements
         do n = 1, network%displacements
            call rows%add(given(network%order(n))%row_type, chosen(n))
         end do
         call put_rigid(rows, given, network)
         return
      end if
      chosen = .false.
      elastic = given%elastic
      left = elastic
      known = .not. given%unknown
      loops = count(elastic) >= nodes
      next = 1
      do
         do while (next <= size(given))
            if (left(next)) exit
            next = next + 1
         end do
         if (next > size(given)) exit
         n = next
         if (loops) then
            if (any(left .and. known)) n = maxloc(given%stiffness, 1, left .and. known)
         end if
         left(n) = .false.
         call rows%add(given(n)%row_type, chosen(n))
      end do
      network%displacements = count(chosen)
      call put_rigid(rows, given, network)
      do n = 1, size(given)
         if (.not. given(n)%elastic) call rows%add(given(n)%row_type, chosen(n))
      end do
      network%coordinates = count(chosen)
      call search(given, chosen .and. given%elastic, nodes, network%order)
      network%order = [network%order, pack([(n, n=1, size(given))], chosen .and. .not. given%elastic), &
                       pack([(n, n=1, size(given))], .not. chosen .and. given%elastic), &
                       pack([(n, n=1, size(given))], .not. (chosen .or. given%elastic))]
   end subroutine sort_elements

   !> Sets the rigid motions; one alone turns all nodes in their senses, a node of the first element by 1 over its entry.
   pure subroutine put_rigid(rows, given, network)
      type(rows_type), intent(in) :: rows
      type(element_type), intent(in) :: given(:)
      type(network_type), intent(inout) :: network
      integer :: f

      network%rigid = rows%motion(:, pack([(f, f=1, size(rows%free))], rows%free))
      if (size(network%rigid, 2) /= 1) return
      associate (node => given(1)%node(1))
         if (abs(network%rigid(node, 1)) > 0) network%rigid = network%rigid/network%rigid(node, 1)/given(1)%entry(1)
      end associate
   end subroutine put_rigid

   !> Elements in the order of a search from a node at an end: of a chain from one end to the other. Elements that share nodes are
   !> near to one another, and matrices narrow.
   pure subroutine search(given, wanted, nodes, order)
      type(element_type), intent(in) :: given(:)
      logical, intent(in) :: wanted(:)
      integer, intent(in) :: nodes
      !> Numbers of the wanted elements.
      integer, allocatable, intent(out) :: order(:)
      integer :: place(nodes + size(given)), degree(nodes), depth, i, k, n
      logical :: met(nodes), taken(size(given))
      !> Elements at each node, at(first(node):first(node + 1) - 1); the first of them that may be left.
      integer, allocatable :: at(:)
      integer :: first(nodes + 1), next(nodes)

      degree = 0
      first = 0
      do i = 1, size(given)
         if (given(i)%elastic) degree(given(i)%node) = degree(given(i)%node) + 1
         do k = 1, size(given(i)%node)
            first(given(i)%node(k) + 1) = first(given(i)%node(k) + 1) + 1
         end do
      end do
      first(1) = 1
      do k = 1, nodes
         first(k + 1) = first(k) + first(k + 1)
      end do
      allocate (at(first(nodes + 1) - 1))
      next = first(:nodes)
      do i = 1, size(given)
         do k = 1, size(given(i)%node)
            at(next(given(i)%node(k))) = i
            next(given(i)%node(k)) = next(given(i)%node(k)) + 1
         end do
      end do
      next = first(:nodes)
      allocate (order(count(wanted)))
      met = .false.
      taken = .not. wanted
      n = 0
      depth = 0
      do while (n < size(order))
         if (depth == 0) then
            ! A node at an end; else any node of an element that is left.
            place(1) = findloc(degree == 1 .and. .not. met, .true., 1)
            if (n > 0 .or. place(1) == 0) place(1) = given(findloc(taken, .false., 1))%node(1)
            depth = 1
            met(place(1)) = .true.
         end if
         associate (k => next(place(depth)), end => first(place(depth) + 1))
            do while (k < end)
               if (.not. taken(at(k))) exit
               k = k + 1
            end do
            if (k == end) then
               depth = depth - 1
               cycle
            end if
            i = at(k)
         end associate
         taken(i) = .true.
         n = n + 1
         order(n) = i
         if (all(met(given(i)%node))) cycle
         depth = depth + 1
         place(depth) = given(i)%node(findloc(met(given(i)%node), .false., 1))
         met(given(i)%node) = .true.
      end do
   end subroutine search

   !> Sets the loop matrix, and the misfit of each loop.
   pure subroutine find_loops(network)
      type(network_type), intent(inout) :: network
      type(rows_type) :: rows
      logical :: independent
      integer :: i, n

      allocate (network%loop(size(network%elements) - network%coordinates, network%coordinates))
      network%misfit = network%elements(network%coordinates + 1:)%error_mean
      if (size(network%loop, 1) == 0) return
      call rows%setup(size(network%inertia), network%coordinates)
      do n = 1, network%coordinates
         call rows%add(network%elements(n)%row_type, independent)
      end do
      do i = 1, size(network%loop, 1)
         network%loop(i, :) = rows%follow(network%elements(network%coordinates + i)%row_type)
         network%misfit(i) = network%misfit(i) - dot_product(network%loop(i, :), network%elements(:network%coordinates)%error_mean)
      end do
   end subroutine find_loops

   !> Whether the coordinates do not determine the displacements of all elements, or not alone: gears lock.
   pure logical function locks(network)
      !> Network from `build_network` with the order of another train.
      type(network_type), intent(in) :: network
      type(rows_type) :: rows
      logical :: independent
      integer :: n

      locks = .false.
      if (size(network%loop, 1) == 0) return
      call rows%setup(size(network%inertia), 0)
      do n = 1, size(network%elements)
         call rows%add(network%elements(n)%row_type, independent)
         locks = locks .or. (independent .neqv. n <= network%coordinates)
      end do
   end function locks

   !> Factor >= 1 by which loops stiffen each element, (element): a soft element beside stiff elements follows their motion.
   pure function stiffening(network) result(factor)
      !> Network from `build_network`.
      type(network_type), intent(in) :: network
      real(dp) :: factor(size(network%elements)), share(size(network%elements)), others
      integer :: i, m, n

      factor = 1
      do i = 1, size(network%loop, 1)
         if (.not. network%elements(network%coordinates + i)%elastic) cycle
         share = 0
         share(:network%coordinates) = -network%loop(i, :)
         share(network%coordinates + i) = 1
         do n = 1, size(share)
            if (.not. abs(share(n)) > 0) cycle
            ! Compliance of the other elements of the loop over the compliance of this element.
            others = sum(share**2*(network%elements(n)%stiffness/network%elements%stiffness), [(m, m=1, size(share))] /= n)
            factor(n) = max(factor(n), 1 + share(n)**2/max(others, tiny(others)))
         end do
      end do
   end function stiffening

   !> Finds the reduced radii: along elements of two entries x is equal at both ends. A node without such an element has the radius
   !> of an entry there.
   pure subroutine find_radii(network)
      type(network_type), intent(inout) :: network
      integer :: begun, n
      logical :: changed

      allocate (network%radius(size(network%inertia)), source=0.0_dp)
      ! Displacements are what they are.
      network%radius(pack(network%moves, network%moves > 0)) = 1
      begun = network%elements(1)%node(1)
      if (network%radius(begun) > 0) begun = findloc(abs(network%radius) > 0, .false., 1)
      do while (begun > 0)
         network%radius(begun) = radius_at(network%elements, begun)
         changed = .true.
         do while (changed)
            changed = .false.
            do n = 1, size(network%elements)
               if (size(network%elements(n)%node) /= 2) cycle
               associate (a => network%elements(n)%node(1), b => network%elements(n)%node(2), entry => network%elements(n)%entry, &
                          radius => network%radius)
                  if ((abs(radius(a)) > 0) .eqv. (abs(radius(b)) > 0)) cycle
                  if (.not. all(abs(entry) > 0)) cycle
                  changed = .true.
                  if (abs(radius(a)) > 0) then
                     radius(b) = -radius(a)*(entry(2)/entry(1))
                  else
                     radius(a) = -radius(b)*(entry(1)/entry(2))
                  end if
               end associate
            end do
         end do
         begun = findloc(abs(network%radius) > 0, .false., 1)
      end do
   end subroutine find_radii

   !> Number of values of a state: displacements and velocities of the coordinates. 0 for a train without bodies.
   pure integer function state_count(train)
      !> The train as given or plain; its shafts are allocated.
      type(train_type), intent(in) :: train
      type(train_type) :: plain
      type(network_type) :: network

      state_count = 0
      if (body_count(train) == 0) return
      call plain_train(train, plain)
      call build_network(plain, network)
      state_count = network%displacements + network%coordinates
   end function state_count

end module geartrain_network_network
