!> Nodes of a train: bodies, or several bodies on rigid shafts. A body that is held, with all that rigid shafts join to it, is none.
!> A body on a bearing has two nodes more, its displacements x and y, whose inertia is its mass.
module geartrain_network_nodes
   use geartrain_base_kinds, only: dp
   use geartrain_train_bodies, only: bodies_of, body_count, find_ends
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: nodes_type, join_rigid

   type :: nodes_type
      !> Node of each body of the train (geartrain_train_bodies), 0 of a held body, (body).
      integer, allocatable :: node(:)
      !> Nodes of the displacements x and y of each body, 0 without a bearing, (2, body).
      integer, allocatable :: moves(:, :)
      !> Inertia [kg m^2], of a displacement mass [kg], (node).
      real(dp), allocatable :: inertia(:)
      !> Mean angular acceleration [rad/s^2], 0 but in a run-up; given mean torque less the torque that accelerates the inertia
      !> [N m], (node).
      real(dp), allocatable :: acceleration(:), torque(:)
      !> Sum of the magnitudes of the torques on the bodies of a node [N m], (node): the scale of the rounding of `torque`.
      real(dp), allocatable :: magnitude(:)
      !> Damping to ground [N m s/rad] and stiffness to ground [N m/rad], (node).
      real(dp), allocatable :: damping(:), support(:)
      !> Bodies whose mean torques balance the torques on all others, (body).
      integer, allocatable :: balancing(:)
   end type nodes_type

contains

   !> Makes the nodes, numbered in the order of their first bodies.
   pure subroutine join_rigid(train, nodes)
      type(train_type), intent(in) :: train
      class(nodes_type), intent(inout) :: nodes
      real(dp), dimension(body_count(train)) :: inertia, torque
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      integer, allocatable :: balancing(:)
      integer :: root(body_count(train)), i, number
      logical :: held(body_count(train))

      call bodies_of(train, inertia, torque, balancing, held)
      call find_ends(train, shaft_ends, mesh_ends)
      root = [(i, i=1, size(root))]
      do i = 1, size(train%shafts)
         if (.not. train%shafts(i)%rigid) cycle
         associate (ends => shaft_ends(:, i))
            where (root == maxval(root(ends))) root = minval(root(ends))
         end associate
      end do
      allocate (nodes%node(size(root)), source=0)
      number = 0
      do i = 1, size(root)
         if (any(held .and. root == root(i))) cycle
         if (root(i) == i) number = number + 1
         nodes%node(i) = merge(number, nodes%node(root(i)), root(i) == i)
      end do
      allocate (nodes%moves(2, size(root)), source=0)
      do i = 1, size(train%meshes)
         associate (axis => train%meshes(i)%axis, body => mesh_ends(1, i))
            if (axis == 0 .or. axis > 2 .or. body == 0) cycle
            number = number + 1
            nodes%moves(axis, body) = number
         end associate
      end do
      allocate (nodes%inertia(number), nodes%acceleration(number), nodes%torque(number), nodes%magnitude(number), &
                nodes%damping(number), nodes%support(number), source=0.0_dp)
      do i = 1, size(root)
         associate (node => nodes%node(i))
            if (node == 0) cycle
            nodes%inertia(node) = nodes%inertia(node) + inertia(i)
            nodes%torque(node) = nodes%torque(node) + torque(i)
            nodes%magnitude(node) = nodes%magnitude(node) + abs(torque(i))
            if (.not. allocated(train%bodies)) cycle
            nodes%damping(node) = nodes%damping(node) + train%bodies(i)%damping_to_ground
            nodes%support(node) = nodes%support(node) + train%bodies(i)%stiffness_to_ground
         end associate
      end do
      do i = 1, size(train%meshes)
         associate (axis => train%meshes(i)%axis, body => mesh_ends(1, i))
            if (axis == 0 .or. axis > 2 .or. body == 0) cycle
            nodes%inertia(nodes%moves(axis, body)) = train%meshes(i)%mass
         end associate
      end do
      nodes%balancing = balancing
   end subroutine join_rigid

end module geartrain_network_nodes
