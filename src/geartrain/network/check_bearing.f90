!> Checks of bearings: what they carry moves, and the lines of action of its meshes are known.
module geartrain_network_check_bearing
   use geartrain_base_checker, only: checker_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text, real_text, text
   use geartrain_network_network, only: network_type
   use geartrain_network_nodes, only: join_rigid, nodes_type
   use geartrain_train_bearing_rows, only: flats_known
   use geartrain_train_line_of_action, only: find_line, is_far, is_near, is_unplaced
   use geartrain_train_mesh, only: mesh_type
   use geartrain_train_mesh_groups, only: group_number
   use geartrain_train_train, only: train_type
   use geartrain_train_turning, only: find_turning, turning_type
   implicit none (type, external)
   private
   public :: check_bearing, check_bodies_on_bearings, check_flanks, check_lines

contains

   !> Adds every problem of a direction of a bearing, whose group has been entered.
   subroutine check_bearing(meshes, i, checker)
      !> The meshes as given.
      type(mesh_type), intent(in) :: meshes(:)
      !> Number of the direction among them.
      integer, intent(in) :: i
      !> Gets the problems.
      class(checker_type), intent(inout) :: checker
      integer :: n

      if (meshes(i)%axis == 1) then
         n = count(meshes(:i)%axis > 0)
         if (.not. any(meshes(i:min(i + 1, size(meshes)))%axis == 2)) &
            call checker%problems%add('has no direction y: new_bearing(2) stands behind new_bearing(1)', 'bearing', (n + 1)/2)
         if (.not. all(abs(meshes(i:min(i + 1, size(meshes)))%stiffness) > 0)) &
            call checker%lacks('stiffness', 'two values > 0 N/m, in the directions x and y')
         call check_rows(meshes, i, checker)
      end if
      if (i == 1) return
      if (meshes(i)%axis == 2 .and. meshes(i - 1)%axis /= 1) &
         call checker%problems%add('has no direction x: new_bearing(1) stands before new_bearing(2)', 'bearing', 1)
   end subroutine check_bearing

   !> A bearing with more than four flats is the same in all directions.
   subroutine check_rows(meshes, i, checker)
      type(mesh_type), intent(in) :: meshes(:)
      !> Number of the direction x among them.
      integer, intent(in) :: i
      class(checker_type), intent(inout) :: checker

      associate (x => meshes(i), y => meshes(min(i + 1, size(meshes))))
         if (.not. any(x%flats == flats_known)) then
            call checker%complain('flats', integer_text(x%flats), 'must be 4, 8, 12, 16 or 24')
         else if (x%flats > 4) then
            if (.not. x%half_backlash > 0) call checker%complain('flats', integer_text(x%flats), &
                                                                 'has no effect without half_clearance')
            if (abs(x%stiffness - y%stiffness) > 0 .or. abs(x%damping - y%damping) > 0) call checker%complain('flats', &
               integer_text(x%flats), 'needs equal stiffness, and equal damping, in the directions x and y')
            if (count(meshes%axis > 2 .and. meshes%between(1) == x%between(1)) /= x%flats/2 - 2) &
               call checker%problems%add('lacks its further rows: call expand_planetaries', 'bearing', group_number(meshes, i))
         end if
      end associate
   end subroutine check_rows

   !> A bearing carries a body that turns and meshes, and no body has two.
   subroutine check_bodies_on_bearings(train, mesh_ends, carrier, checker)
      !> The plain train, whose names are known.
      type(train_type), intent(in) :: train
      !> Bodies of each mesh, (2, mesh), and its carrier, 0: none, (mesh).
      integer, intent(in) :: mesh_ends(:, :), carrier(:)
      !> Gets the problems.
      class(checker_type), intent(inout) :: checker
      type(nodes_type) :: nodes
      character(:), allocatable :: name
      integer :: i, j

      call join_rigid(train, nodes)
      do i = 1, size(train%meshes)
         if (train%meshes(i)%axis /= 1) cycle
         associate (body => mesh_ends(1, i))
            name = trim(train%meshes(i)%between(1))
            call checker%enter('bearing', group_number(train%meshes, i))
            j = findloc(mesh_ends(1, :i - 1) == body .and. train%meshes(:i - 1)%axis == 1, .true., 1)
            if (j > 0) then
               call checker%complain('body', "'"//name//"'", 'is on &bearing '//integer_text(group_number(train%meshes, j))// &
                                     ' already: add the stiffnesses of all bearings of a body')
            else if (nodes%node(body) == 0) then
               call checker%complain('body', "'"//name//"'", 'is held, directly or by rigid shafts: a bearing is for a body that &
                                     &turns')
            else if (.not. any((mesh_ends(1, :) == body .or. mesh_ends(2, :) == body) .and. train%meshes%is_pair())) then
               call checker%complain('body', "'"//name//"'", 'is on no &mesh: no force acts on its bearing, leave it out')
            else if (any(carrier == body)) then
               call checker%complain('body', "'"//name//"'", 'is the carrier of a mesh: it turns about an axis that stands still, &
                                     &leave out the bearing')
            end if
            call checker%leave()
         end associate
      end do
   end subroutine check_bodies_on_bearings

   !> Every mesh of a body on a bearing has a line of action.
   subroutine check_lines(train, mesh_ends, carrier, checker)
      !> The plain train, whose bearings are in order.
      type(train_type), intent(in) :: train
      !> Bodies of each mesh, (2, mesh), and its carrier, 0: none, (mesh).
      integer, intent(in) :: mesh_ends(:, :), carrier(:)
      !> Gets the problems.
      class(checker_type), intent(inout) :: checker
      type(turning_type) :: turning
      character(:), allocatable :: axes
      real(dp) :: direction(2), base
      integer :: i, lacks

      call find_turning(train, turning)
      do i = 1, size(train%meshes)
         associate (mesh => train%meshes(i))
            if (.not. mesh%is_pair()) cycle
            call checker%enter('mesh', i)
            if (.not. any(train%meshes%axis == 1 .and. (mesh_ends(1, :) == mesh_ends(1, i) .or. &
                                                         mesh_ends(1, :) == mesh_ends(2, i)))) then
               if (mesh%line_given) call checker%complain('line_of_action', real_text(mesh%line_of_action), 'has no effect: &
                  &neither body is on a &bearing')
            else if (carrier(i) > 0) then
               call checker%complain('carrier', "'"//trim(mesh%carrier)//"'", 'carries the line of action round with it, and a &
                  &body of this mesh is on a &bearing, whose directions stand still: leave out the bearing')
            else
               axes = "'"//trim(mesh%between(1))//"' and '"//trim(mesh%between(2))//"'"
               call find_line(train, mesh_ends(:, i), turning%sense(mesh_ends(1, i)), i, direction, lacks)
               base = mesh%driving_radius + mesh%driven_radius
               if (mesh%internal) base = abs(mesh%driving_radius - mesh%driven_radius)
               select case (lacks)
               case (is_unplaced)
                  call checker%lacks('line_of_action', 'degrees: a body is on a &bearing', ' or position of '//axes)
               case (is_near)
                  call checker%complain('between', axes, 'are too near by their positions: the distance of their axes must be &
                                        &> '//text(base)//' m, by the base radii')
               case (is_far)
                  call checker%complain('between', axes, 'are too far apart by their positions: at a distance of more than '// &
                                        text(2*base)//' m the pressure angle, by the base radii, is above 60 degrees; are &
                                        &positions and radii in m?')
               end select
            end if
            call checker%leave()
         end associate
      end do
   end subroutine check_lines

   !> The line of action by positions is that of the drive flanks, which bear the mean load.
   subroutine check_flanks(train, network, force, checker)
      !> The plain train, whose lines of action are known.
      type(train_type), intent(in) :: train
      !> Its network.
      type(network_type), intent(in) :: network
      !> Force of each element at rest [N], (element).
      real(dp), intent(in) :: force(:)
      !> Gets the problems.
      class(checker_type), intent(inout) :: checker
      integer :: i, n

      do n = 1, size(force)
         i = network%elements(n)%mesh
         if (i == 0 .or. .not. force(n) < 0) cycle
         if (.not. train%meshes(i)%is_pair() .or. train%meshes(i)%line_given) cycle
         if (size(network%elements(n)%node) == size(network%elements(n)%body)) cycle
         call checker%enter('mesh', i)
         call checker%complain('between', "'"//trim(train%meshes(i)%between(1))//"', '"//trim(train%meshes(i)%between(2))//"'", &
            'bears the mean load on its back flanks, whose line of action is another: name the body that drives first, or give &
            &line_of_action')
         call checker%leave()
      end do
   end subroutine check_flanks

end module geartrain_network_check_bearing
