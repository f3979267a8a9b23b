!> The torque of each shaft, of what holds each held body, and of each coupling, and the force of each bearing in x and in y, as a
!> sum over the forces of elements and the torques on bodies. An elastic shaft and a coupling bear their own force times its
!> radius. A rigid shaft joins two sides of one node with the inertias I_1 and I_2; its torque is what side 1 hands over:
!> S_1 - I_1/(I_1 + I_2) (S_1 + S_2), S the sum of the torques on the bodies of a side.
module geartrain_network_torque_paths
   use geartrain_base_kinds, only: dp
   use geartrain_network_network, only: balance_torques, network_type
   use geartrain_train_bearing_rows, only: row_direction
   use geartrain_train_bodies, only: bodies_of, body_count, find_ends
   use geartrain_train_mesh, only: coupling_radius
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: torque_paths_type, find_torque_paths

   type :: torque_paths_type
      !> Number of torques and forces, and of shafts, held bodies, couplings and bearings, which have two rows: in this order.
      integer :: rows = 0, shafts = 0, held = 0, couplings = 0, bearings = 0
      !> Number of gear pairs, which stand before the couplings among the meshes.
      integer :: pairs = 0
      !> Number of rows that are torques.
      integer :: torques = 0
      !> .false.: nothing determines the torque, as of a rigid shaft beside other rigid shafts between the same bodies, (row).
      logical, allocatable :: known(:)
      !> Mean torque of the bodies, less what accelerates their inertias [N m], (row): 0 for an elastic shaft.
      real(dp), allocatable :: constant(:)
      !> Elements and gains of row s stand at first(s):first(s + 1) - 1: numbers of the elements; torque per force of the
      !> element [m].
      integer, allocatable :: first(:), element(:)
      real(dp), allocatable :: gain(:)
      !> Mesh, coupling or direction of a bearing whose force alone, times the gain, is the torque or force, 0: none, (row).
      integer, allocatable :: alone(:)
      !> Likewise of the fluctuating torques of the system: torque_first, numbers of the torques, gains [1].
      integer, allocatable :: torque_first(:), torque(:)
      real(dp), allocatable :: torque_gain(:)
   end type torque_paths_type

contains

   !> Finds the paths; the torque of a shaft is positive where its first body drives the second.
   pure subroutine find_torque_paths(train, network, torque_body, paths)
      !> The plain train.
      type(train_type), intent(in) :: train
      type(network_type), intent(in) :: network
      !> Body of each fluctuating torque, (torque).
      integer, intent(in) :: torque_body(:)
      !> The paths.
      type(torque_paths_type), intent(out) :: paths
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :), element_of(:), held_body(:), coupling(:)
      real(dp), allocatable :: radius(:)
      real(dp), dimension(body_count(train)) :: inertia, torque, weight
      integer, allocatable :: balancing(:)
      logical :: held(size(inertia))
      integer :: i, s, n

      call bodies_of(train, inertia, torque, balancing, held)
      where (network%node > 0) torque = torque - inertia*network%acceleration(max(1, network%node))
      call balance_torques(network, torque)
      call find_ends(train, shaft_ends, mesh_ends)
      held_body = pack([(i, i=1, size(held))], held)
      paths%held = size(held_body)
      ! Elements of the couplings and bearings, and torque or force per force of each.
      coupling = pack([(n, n=1, size(train%meshes))], .not. train%meshes%is_pair() .and. train%meshes%axis < 3)
      radius = merge(coupling_radius, 1.0_dp, train%meshes(coupling)%is_coupling)
      coupling = [(findloc(network%elements%mesh, coupling(n), 1), n=1, size(coupling))]
      paths%shafts = size(train%shafts)
      paths%pairs = count(train%meshes%is_pair())
      paths%couplings = count(train%meshes%is_coupling)
      paths%bearings = count(train%meshes%axis == 1)
      paths%torques = paths%shafts + paths%held + paths%couplings
      paths%rows = paths%torques + 2*paths%bearings
      allocate (element_of(size(train%shafts)), source=0)
      do n = 1, size(network%elements)
         if (network%elements(n)%shaft > 0) element_of(network%elements(n)%shaft) = n
      end do
      allocate (paths%known(paths%rows), source=.true.)
      allocate (paths%constant(paths%rows), source=0.0_dp)
      allocate (paths%first(paths%rows + 1), paths%torque_first(paths%rows + 1))
      allocate (paths%element(0), paths%gain(0), paths%torque(0), paths%torque_gain(0))
      do s = 1, paths%rows
         paths%first(s) = size(paths%element) + 1
         paths%torque_first(s) = size(paths%torque) + 1
         if (s > paths%shafts + paths%held) then
            paths%element = [paths%element, coupling(s - paths%shafts - paths%held)]
            paths%gain = [paths%gain, radius(s - paths%shafts - paths%held)]
            if (s > paths%torques) call add_row_forces(train, network, coupling(s - paths%shafts - paths%held), paths)
         else if (s > size(element_of)) then
            call add_reaction(train, network, shaft_ends, held_body(s - size(element_of)), held, torque, torque_body, s, paths)
         else if (element_of(s) > 0) then
            paths%element = [paths%element, element_of(s)]
            paths%gain = [paths%gain, network%elements(element_of(s))%radius]
         else
            call find_weights(train, network, shaft_ends, s, inertia, weight, paths%known(s))
            paths%constant(s) = sum(weight*torque)
            if (paths%known(s)) call add_rigid(train, network, torque_body, weight, paths)
         end if
      end do
      paths%first(paths%rows + 1) = size(paths%element) + 1
      paths%torque_first(paths%rows + 1) = size(paths%torque) + 1
      allocate (paths%alone(paths%rows), source=0)
      do s = 1, paths%rows
         if (paths%first(s + 1) - paths%first(s) == 1 .and. paths%torque_first(s + 1) == paths%torque_first(s) .and. &
             .not. abs(paths%constant(s)) > 0) paths%alone(s) = network%elements(paths%element(paths%first(s)))%mesh
      end do
   end subroutine find_torque_paths

   !> Adds to the force of a bearing in x or y those of its further rows in this direction.
   pure subroutine add_row_forces(train, network, element, paths)
      type(train_type), intent(in) :: train
      type(network_type), intent(in) :: network
      !> Number of the element of the direction.
      integer, intent(in) :: element
      type(torque_paths_type), intent(inout) :: paths
      real(dp) :: direction(2)
      integer :: i

      associate (row => train%meshes(network%elements(element)%mesh))
         do i = 1, size(train%meshes)
            if (train%meshes(i)%axis < 3 .or. train%meshes(i)%between(1) /= row%between(1)) cycle
            direction = row_direction(train%meshes(i))
            paths%element = [paths%element, findloc(network%elements%mesh, i, 1)]
            paths%gain = [paths%gain, direction(row%axis)]
         end do
      end associate
   end subroutine add_row_forces

   !> Adds what acts on the bodies of the node of a rigid shaft.
   pure subroutine add_rigid(train, network, torque_body, weight, paths)
      type(train_type), intent(in) :: train
      type(network_type), intent(in) :: network
      !> Body of each fluctuating torque.
      integer, intent(in) :: torque_body(:)
      !> See `find_weights`, (body).
      real(dp), intent(in) :: weight(:)
      type(torque_paths_type), intent(inout) :: paths
      real(dp) :: gain(size(network%elements))
      !> Whether an element is a path. One whose gain is 0 by the numbers of the train is: its gain has a derivative.
      logical :: acts(size(gain))
      integer :: k

      do k = 1, size(gain)
         associate (element => network%elements(k))
            if (element%shaft + element%mesh > 0) then
               gain(k) = -sum(element%entry(:size(element%body))*weight(element%body))
               acts(k) = abs(gain(k)) > 0
            else
               ! What holds or damps a node holds or damps its bodies.
               associate (node => element%node(1))
                  gain(k) = -element%entry(1)*sum(weight*merge(train%bodies%stiffness_to_ground, train%bodies%damping_to_ground, &
                     element%elastic), network%node == node)/merge(network%support(node), network%damping(node), element%elastic)
                  acts(k) = any(network%node == node .and. abs(weight) > 0)
               end associate
            end if
         end associate
      end do
      paths%element = [paths%element, pack([(k, k=1, size(gain))], acts)]
      paths%gain = [paths%gain, pack(gain, acts)]
      do k = 1, size(torque_body)
         if (.not. abs(weight(torque_body(k))) > 0) cycle
         paths%torque = [paths%torque, k]
         paths%torque_gain = [paths%torque_gain, weight(torque_body(k))]
      end do
   end subroutine add_rigid

   !> Adds what acts on a held body and on all that rigid shafts join to it.
   pure subroutine add_reaction(train, network, shaft_ends, body, held, torque, torque_body, row, paths)
      type(train_type), intent(in) :: train
      type(network_type), intent(in) :: network
      !> Bodies that each shaft joins, (2, shaft); number of the held body; body of each fluctuating torque; row of the paths.
      integer, intent(in) :: shaft_ends(:, :), body, torque_body(:), row
      !> Whether each body is held; mean torques [N m], (body).
      logical, intent(in) :: held(:)
      real(dp), intent(in) :: torque(:)
      type(torque_paths_type), intent(inout) :: paths
      logical :: here(size(held))
      real(dp) :: gain
      integer :: k

      here = .false.
      here(body) = .true.
      call spread_rigid(train, shaft_ends, 0, here)
      paths%known(row) = count(here .and. held) == 1
      if (.not. paths%known(row)) return
      paths%constant(row) = -sum(torque, here)
      do k = 1, size(network%elements)
         associate (element => network%elements(k))
            gain = sum(element%held_entry, here(element%held_body))
            if (.not. abs(gain) > 0) cycle
            paths%element = [paths%element, k]
            paths%gain = [paths%gain, gain]
         end associate
      end do
      do k = 1, size(torque_body)
         if (.not. here(torque_body(k))) cycle
         paths%torque = [paths%torque, k]
         paths%torque_gain = [paths%torque_gain, -1.0_dp]
      end do
   end subroutine add_reaction

   !> Adds all bodies that rigid shafts, but for one, join to those that are there.
   pure subroutine spread_rigid(train, shaft_ends, without, here)
      type(train_type), intent(in) :: train
      !> Bodies that each shaft joins, (2, shaft); number of the shaft that does not count, 0: all count.
      integer, intent(in) :: shaft_ends(:, :), without
      logical, intent(inout) :: here(:)
      logical :: changed
      integer :: i

      changed = .true.
      do while (changed)
         changed = .false.
         do i = 1, size(train%shafts)
            if (i == without .or. .not. train%shafts(i)%rigid) cycle
            associate (ends => shaft_ends(:, i))
               if (here(ends(1)) .eqv. here(ends(2))) cycle
               here(ends) = .true.
               changed = .true.
            end associate
         end do
      end do
   end subroutine spread_rigid

   !> Weight of the torque on each body in the torque of a rigid shaft, (body): 1 on the side of its first body, less the share of
   !> the inertia of this side in the inertia of the node.
   pure subroutine find_weights(train, network, shaft_ends, shaft, inertia, weight, known)
      type(train_type), intent(in) :: train
      type(network_type), intent(in) :: network
      !> Bodies that each shaft joins, (2, shaft); number of the rigid shaft.
      integer, intent(in) :: shaft_ends(:, :), shaft
      !> Of the bodies [kg m^2], (body).
      real(dp), intent(in) :: inertia(:)
      real(dp), intent(out) :: weight(:)
      logical, intent(out) :: known
      logical :: side(size(inertia)), here(size(inertia))

      weight = 0
      known = network%node(shaft_ends(1, shaft)) > 0
      if (.not. known) return
      here = network%node == network%node(shaft_ends(1, shaft))
      side = .false.
      side(shaft_ends(1, shaft)) = .true.
      call spread_rigid(train, shaft_ends, shaft, side)
      known = .not. side(shaft_ends(2, shaft))
      where (here) weight = merge(1.0_dp, 0.0_dp, side) - sum(inertia, side)/sum(inertia, here)
   end subroutine find_weights

end module geartrain_network_torque_paths
