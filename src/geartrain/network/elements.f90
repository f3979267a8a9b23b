!> The elements of a train as rows of its nodes: shafts, meshes (couplings and bearings among them), springs and dampers to ground.
!> A new kind of element is one more procedure here.
module geartrain_network_elements
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_rows, only: row_type
   use geartrain_network_nodes, only: nodes_type
   use geartrain_train_line_of_action, only: find_line
   use geartrain_train_bearing_rows, only: row_direction
   use geartrain_train_bodies, only: bodies_of, body_count, find_carriers, find_ends
   use geartrain_train_gear_error, only: has_tooth_factors
   use geartrain_train_mesh, only: mesh_type
   use geartrain_train_train, only: train_type
   use geartrain_train_turning, only: find_turning, turning_type
   implicit none (type, external)
   private
   public :: element_type, list_elements, radius_at, vibrating

   !> A shaft, a mesh, or a spring or damper to ground.
   type, extends(row_type) :: element_type
      !> Number of the shaft or of the mesh in the train; 0 where the element is none.
      integer :: shaft = 0, mesh = 0
      !> Bodies of the entries of a shaft or mesh, (entry); entries of displacements follow.
      integer, allocatable :: body(:)
      !> Bodies that stand still, and the displacement that a rotation of them would be [m], (held entry).
      integer, allocatable :: held_body(:)
      real(dp), allocatable :: held_entry(:)
      !> Torque of a shaft per force along the line of action [m].
      real(dp) :: radius = 0
      !> Stiffness [N/m] and damping [N s/m] along the line of action.
      real(dp) :: stiffness = 0, damping = 0
      !> Constant part of the displacement, which no rotation causes [m].
      real(dp) :: error_mean = 0
      !> An unknown of the harmonic balance: a mesh with backlash or a varying stiffness, or an element of more than two entries.
      logical :: unknown = .false.
      !> .false.: a damper to ground. Its displacement is the vibration of the node; the stiffness only is the unit of the force.
      logical :: elastic = .true.
   end type element_type

contains

   !> Lists elastic shafts and meshes in the order shaft 1, mesh 1, shaft 2, ..., then springs and dampers to ground.
   pure subroutine list_elements(train, nodes, elements)
      !> The plain train.
      type(train_type), intent(in) :: train
      !> Its nodes.
      class(nodes_type), intent(in) :: nodes
      !> The elements.
      type(element_type), allocatable, intent(out) :: elements(:)
      real(dp), dimension(body_count(train)) :: inertia, torque
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :), balancing(:)
      integer :: carrier(size(train%meshes)), i, n
      type(turning_type) :: turning

      call bodies_of(train, inertia, torque, balancing)
      call find_ends(train, shaft_ends, mesh_ends)
      call find_carriers(train, carrier)
      if (any(carrier > 0) .or. any(train%meshes%axis > 0)) call find_turning(train, turning)
      allocate (elements(size(train%meshes) + count(.not. train%shafts%rigid) + count(nodes%support > 0) &
                         + count(nodes%damping > 0)))
      n = 0
      do i = 1, max(size(train%shafts), size(train%meshes))
         if (i <= size(train%shafts)) then
            if (.not. train%shafts(i)%rigid) then
               n = n + 1
               call make_shaft(train, nodes, i, shaft_ends(:, i), mesh_ends, inertia, elements(n))
            end if
         end if
         if (i > size(train%meshes)) cycle
         n = n + 1
         if (train%meshes(i)%axis > 0) then
            call make_bearing(train%meshes(i), nodes%moves(:, mesh_ends(1, i)), i, elements(n))
            cycle
         end if
         call make_mesh(train, nodes, i, mesh_ends(:, i), inertia, elements(n))
         if (carrier(i) > 0) call put_carrier(train%meshes(i), nodes, [mesh_ends(:, i), carrier(i)], turning, i, elements(n))
         if (train%meshes(i)%is_pair() .and. any(nodes%moves(:, mesh_ends(:, i)) > 0)) &
            call put_displacements(train, nodes, mesh_ends(:, i), turning%sense(mesh_ends(1, i)), i, elements(n))
      end do
      do i = 1, size(nodes%inertia)
         if (.not. nodes%support(i) > 0) cycle
         n = n + 1
         elements(n)%node = [i]
         ! Along the line of action of an element there, as far as any is.
         elements(n)%entry = [radius_at(elements(:n - 1), i)]
         call touch_ground(elements(n))
         elements(n)%stiffness = nodes%support(i)/elements(n)%entry(1)**2
      end do
      do i = 1, size(nodes%inertia)
         if (.not. nodes%damping(i) > 0) cycle
         n = n + 1
         elements(n)%node = [i]
         elements(n)%entry = [1.0_dp]
         call touch_ground(elements(n))
         elements(n)%elastic = .false.
      end do
   end subroutine list_elements

   !> A spring or damper to ground has no other body.
   pure subroutine touch_ground(element)
      type(element_type), intent(inout) :: element

      element%body = [integer ::]
      element%held_body = [integer ::]
      element%held_entry = [real(dp) ::]
   end subroutine touch_ground

   !> Magnitude of the first entry at a node that is not 0 [m]; 1 where there is none.
   pure real(dp) function radius_at(elements, node)
      !> The elements.
      type(element_type), intent(in) :: elements(:)
      !> Number of the node.
      integer, intent(in) :: node
      integer :: i, n

      radius_at = 1
      do n = 1, size(elements)
         i = findloc(elements(n)%node, node, 1)
         if (i == 0) cycle
         if (.not. abs(elements(n)%entry(i)) > 0) cycle
         radius_at = abs(elements(n)%entry(i))
         return
      end do
   end function radius_at

   !> Sets the row of an element from its bodies: the bodies of a node share an entry, and a held body has none.
   pure subroutine put_row(nodes, bodies, entries, element)
      class(nodes_type), intent(in) :: nodes
      !> Bodies, and displacement per rotation of each [m], (entry).
      integer, intent(in) :: bodies(:)
      real(dp), intent(in) :: entries(:)
      type(element_type), intent(inout) :: element
      logical :: moves(size(bodies))

      moves = nodes%node(bodies) > 0
      element%body = pack(bodies, moves)
      element%node = nodes%node(element%body)
      element%entry = pack(entries, moves)
      element%held_body = pack(bodies, .not. moves)
      element%held_entry = pack(entries, .not. moves)
      element%unknown = element%unknown .or. size(element%node) > 2
   end subroutine put_row

   pure subroutine make_shaft(train, nodes, i, ends, mesh_ends, inertia, element)
      type(train_type), intent(in) :: train
      class(nodes_type), intent(in) :: nodes
      !> Number of the shaft; its two bodies; the two bodies of each mesh, (2, mesh).
      integer, intent(in) :: i, ends(2), mesh_ends(:, :)
      !> Of the bodies [kg m^2], (body).
      real(dp), intent(in) :: inertia(:)
      type(element_type), intent(inout) :: element

      element%shaft = i
      element%radius = base_radius(train, measuring_gear(nodes%node, mesh_ends, nodes%node(ends)))
      call put_row(nodes, ends, element%radius*[1, -1], element)
      associate (shaft => train%shafts(i))
         element%damping = damping_of(shaft%damping_ratio, shaft%stiffness, [1.0_dp, 1.0_dp], &
                                      vibrating(nodes, inertia, ends, allocated(train%bodies)))
         if (shaft%damping_given) element%damping = shaft%damping
         ! A train that is not in order may have radii of 0.
         if (.not. element%radius > 0) return
         element%stiffness = shaft%stiffness/element%radius**2
         element%damping = element%damping/element%radius**2
      end associate
   end subroutine make_shaft

   pure subroutine make_mesh(train, nodes, i, ends, inertia, element)
      type(train_type), intent(in) :: train
      class(nodes_type), intent(in) :: nodes
      !> Number of the mesh; its two bodies.
      integer, intent(in) :: i, ends(2)
      !> Of the bodies [kg m^2], (body).
      real(dp), intent(in) :: inertia(:)
      type(element_type), intent(inout) :: element

      element%mesh = i
      associate (mesh => train%meshes(i), radii => [train%meshes(i)%driving_radius, train%meshes(i)%driven_radius])
         element%unknown = mesh%is_bent() .or. varies(mesh%stiffness_cos) .or. varies(mesh%stiffness_sin) .or. &
                           any(has_tooth_factors(mesh%gear_error))
         call put_row(nodes, ends, radii*[1, -1], element)
         element%stiffness = mesh%stiffness
         element%error_mean = mesh%error_mean
         element%damping = damping_of(mesh%damping_ratio, mesh%stiffness, radii, vibrating(nodes, inertia, ends, .true.))
         if (mesh%damping_given) element%damping = mesh%damping
      end associate

   contains

      pure logical function varies(amplitude)
         real(dp), allocatable, intent(in) :: amplitude(:)

         varies = .false.
         if (allocated(amplitude)) varies = any(abs(amplitude) > 0)
      end function varies

   end subroutine make_mesh

   !> Makes one row of a bearing.
   pure subroutine make_bearing(bearing, nodes, i, element)
      type(mesh_type), intent(in) :: bearing
      !> Nodes of the displacements x and y; number of the mesh.
      integer, intent(in) :: nodes(2), i
      type(element_type), intent(inout) :: element

      element%mesh = i
      if (bearing%axis < 3) then
         element%node = [nodes(bearing%axis)]
         element%entry = [1.0_dp]
      else
         element%node = nodes
         element%entry = row_direction(bearing)
      end if
      call touch_ground(element)
      element%stiffness = bearing%stiffness
      element%damping = bearing%damping
      element%unknown = bearing%is_bent()
   end subroutine make_bearing

   !> Adds to the row of a gear pair the displacements of its bodies: along the line of action the driving gear comes nearer to the
   !> driven gear.
   pure subroutine put_displacements(train, nodes, ends, sense, i, element)
      type(train_type), intent(in) :: train
      class(nodes_type), intent(in) :: nodes
      !> Driving and driven body; sense in which the driving body turns; number of the mesh.
      integer, intent(in) :: ends(2), sense, i
      type(element_type), intent(inout) :: element
      real(dp) :: direction(2)
      integer :: lacks

      call find_line(train, ends, sense, i, direction, lacks)
      associate (driving => nodes%moves(:, ends(1)), driven => nodes%moves(:, ends(2)))
         if (driving(1) > 0) element%node = [element%node, driving]
         if (driving(1) > 0) element%entry = [element%entry, direction]
         if (driven(1) > 0) element%node = [element%node, driven]
         if (driven(1) > 0) element%entry = [element%entry, -direction]
      end associate
      element%unknown = .true.
   end subroutine put_displacements

   !> Sets the row of a mesh on a carrier: s [r_a (theta_a - theta_c) + q r_b (theta_b - theta_c)] in rotations of one sense, with
   !> q = 1 for an external and -1 for an internal pair, and s such that the drive flanks bear where the driving gear leads.
   pure subroutine put_carrier(mesh, nodes, bodies, turning, i, element)
      type(mesh_type), intent(in) :: mesh
      class(nodes_type), intent(in) :: nodes
      !> Driving gear, driven gear, carrier.
      integer, intent(in) :: bodies(3)
      !> Speeds and senses of the bodies.
      type(turning_type), intent(in) :: turning
      !> Number of the mesh.
      integer, intent(in) :: i
      type(element_type), intent(inout) :: element
      real(dp) :: entries(3)

      entries(:2) = [mesh%driving_radius, merge(-1, 1, mesh%internal)*mesh%driven_radius]
      entries(3) = -sum(entries(:2))
      if (abs(turning%relative(i)) > 0) entries = sign(1.0_dp, turning%relative(i))*entries
      call put_row(nodes, bodies, turning%sense(bodies)*entries, element)
   end subroutine put_carrier

   !> Damping coefficient by a damping ratio, 2 ratio sqrt(k m) with 1/m = sum of r^2/I; 0 where the numbers are not in order.
   pure real(dp) function damping_of(ratio, stiffness, radii, inertia) result(damping)
      real(dp), intent(in) :: ratio, stiffness
      !> Of the two ends.
      real(dp), intent(in) :: radii(2), inertia(2)

      damping = 0
      if (all(inertia > 0) .and. any(abs(radii) > 0) .and. stiffness > 0) damping = 2*ratio*sqrt(stiffness/sum(radii**2/inertia))
   end function damping_of

   !> Inertias at the ends of an element to which its damping ratio refers [kg m^2]: the inertia of each body as given. A body
   !> without inertia, and a shaft end of a train without &body, counts with all bodies that are rigidly joined to it; a held body
   !> does not move.
   pure function vibrating(nodes, inertia, ends, own)
      class(nodes_type), intent(in) :: nodes
      !> Of the bodies [kg m^2], (body).
      real(dp), intent(in) :: inertia(:)
      !> The two bodies.
      integer, intent(in) :: ends(2)
      !> The inertias of the bodies themselves count.
      logical, intent(in) :: own
      real(dp) :: vibrating(2)
      integer :: i

      vibrating = huge(1.0_dp)
      do i = 1, 2
         if (nodes%node(ends(i)) > 0) vibrating(i) = nodes%inertia(nodes%node(ends(i)))
         if (own .and. nodes%node(ends(i)) > 0 .and. inertia(ends(i)) > 0) vibrating(i) = inertia(ends(i))
      end do
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
            if (any(nodes > 0 .and. nodes == node(mesh_ends(side, i)))) gear = [i, side]
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

end module geartrain_network_elements
