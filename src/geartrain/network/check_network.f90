!> Checks that bodies, shafts and meshes make one network: every name is known, what moves has inertia, all bodies are joined.
module geartrain_network_check_network
   use geartrain_base_checker, only: checker_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_nearest, only: nearest_name
   use geartrain_base_numbers, only: integer_text, real_text, text
   use geartrain_mesh_law_law, only: law_type
   use geartrain_network_check_bearing, only: check_bodies_on_bearings, check_flanks, check_lines
   use geartrain_network_check_coupling, only: check_friction, check_middles
   use geartrain_network_check_turning, only: check_joints, check_turning
   use geartrain_train_mesh_groups, only: enter_mesh, group_name
   use geartrain_network_network, only: network_type
   use geartrain_network_nodes, only: join_rigid, nodes_type
   use geartrain_network_rest, only: largest_residual, rest_forces
   use geartrain_train_bodies, only: find_carriers, find_ends
   use geartrain_train_mesh, only: is_given, put_law
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: check_network

contains

   !> Adds every problem of the network; the range of each value is checked elsewhere.
   subroutine check_network(train, checker)
      !> The plain train, with bodies, shafts and meshes.
      type(train_type), intent(in) :: train
      class(checker_type), intent(inout) :: checker
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      type(network_type) :: network
      integer :: before, carrier(size(train%meshes))

      before = checker%problems%count
      call check_chain_values(train, checker)
      call check_names(train, checker)
      if (all(train%meshes%axis > 0)) call checker%problems%add('the train has no &mesh and no &coupling', 'train', &
                                                                1, names_group=.true.)
      if (checker%problems%count > before) return
      ! The checks below need the names; a value that is out of range has been told with its variable.
      call find_ends(train, shaft_ends, mesh_ends)
      if (any(shaft_ends == 0) .or. any(mesh_ends == 0)) return
      call check_inertias(train, shaft_ends, mesh_ends, checker)
      if (.not. all(train%meshes%driving_radius > 0 .and. train%meshes%driven_radius > 0)) return
      call find_carriers(train, carrier)
      if (any(carrier < 0)) return
      call check_joints(train, shaft_ends, mesh_ends, carrier, checker)
      call check_elastic(train, shaft_ends, mesh_ends, carrier, checker)
      if (any(train%meshes%axis > 0 .or. train%meshes%line_given)) then
         if (checker%problems%count == before) call check_bodies_on_bearings(train, mesh_ends, carrier, checker)
         if (checker%problems%count == before) call check_lines(train, mesh_ends, carrier, checker)
      end if
      if (checker%problems%count == before) call check_turning(train, mesh_ends, carrier, network, checker)
      ! Numbers that a wrong drawing gave have no rest.
      if (checker%problems%count == 0) call check_rest(train, network, checker)
   end subroutine check_network

   !> A train with bodies has no values of the variables of a chain.
   subroutine check_chain_values(train, checker)
      type(train_type), intent(in) :: train
      class(checker_type), intent(inout) :: checker
      character(*), parameter :: cure = 'is for a chain without &body groups: give it in a &body'
      integer :: i

      call checker%enter('train', 1)
      if (abs(train%input_torque) > 0) call checker%complain('input_torque', real_text(train%input_torque), cure//', as torque')
      if (abs(train%prime_mover_inertia) > 0) &
         call checker%complain('prime_mover_inertia', real_text(train%prime_mover_inertia), cure//', as inertia')
      if (abs(train%load_inertia) > 0) &
         call checker%complain('load_inertia', real_text(train%load_inertia), cure//', as inertia')
      if (is_given(train%torque_cos)) call checker%complain('torque_cos', '...', cure)
      if (is_given(train%torque_sin)) call checker%complain('torque_sin', '...', cure)
      call checker%leave()
      do i = 1, size(train%meshes)
         call enter_mesh(checker, train%meshes, i)
         associate (mesh => train%meshes(i))
            if (abs(mesh%driving_inertia) > 0) &
               call checker%complain('driving_inertia', real_text(mesh%driving_inertia), cure//', as inertia')
            if (abs(mesh%driven_inertia) > 0) &
               call checker%complain('driven_inertia', real_text(mesh%driven_inertia), cure//', as inertia')
         end associate
         call checker%leave()
      end do
   end subroutine check_chain_values

   !> Every body has a name of its own, and every end is the name of a body.
   subroutine check_names(train, checker)
      type(train_type), intent(in) :: train
      class(checker_type), intent(inout) :: checker
      character(:), allocatable :: name
      logical :: joined
      integer :: i, j

      do i = 1, size(train%bodies)
         call checker%enter('body', i)
         name = ''
         if (allocated(train%bodies(i)%name)) name = train%bodies(i)%name
         if (name == '') then
            call checker%lacks('name', '')
         else
            do j = 1, i - 1
               if (.not. allocated(train%bodies(j)%name)) cycle
               if (train%bodies(j)%name /= name) cycle
               call checker%complain('name', "'"//name//"'", 'is that of &body '//integer_text(j)//' already')
               exit
            end do
         end if
         call checker%leave()
      end do
      do i = 1, size(train%shafts)
         call checker%enter('shaft', i)
         call check_ends(train, train%shafts(i)%between, checker)
         call checker%leave()
      end do
      do i = 1, size(train%meshes)
         call enter_mesh(checker, train%meshes, i)
         if (train%meshes(i)%axis == 0) then
            call check_ends(train, train%meshes(i)%between, checker)
         else if (train%meshes(i)%axis == 1) then
            joined = is_body(train, 'body', train%meshes(i)%between(1), checker)
         end if
         if (train%meshes(i)%carrier /= '') call check_carrier(train, train%meshes(i)%between, train%meshes(i)%carrier, checker)
         call checker%leave()
      end do
   end subroutine check_names

   subroutine check_ends(train, between, checker)
      type(train_type), intent(in) :: train
      character(*), intent(in) :: between(2)
      class(checker_type), intent(inout) :: checker
      integer :: i

      if (all(between == '')) then
         call checker%lacks('between', 'the names of the two bodies that it joins')
         return
      end if
      do i = 1, 2
         if (.not. is_body(train, 'between', between(i), checker)) return
      end do
      if (between(1) == between(2)) call checker%complain('between', "'"//trim(between(1))//"' twice", 'must be two bodies')
   end subroutine check_ends

   subroutine check_carrier(train, between, carrier, checker)
      type(train_type), intent(in) :: train
      character(*), intent(in) :: between(2), carrier
      class(checker_type), intent(inout) :: checker

      if (.not. is_body(train, 'carrier', carrier, checker)) return
      if (any(between == carrier)) call checker%complain('carrier', "'"//trim(carrier)//"'", 'is a gear of this mesh: the body &
         &on which both gears ride is meant')
   end subroutine check_carrier

   !> Whether a name is that of a body; else adds a problem, unless it may be a name that could not be read.
   logical function is_body(train, variable, name, checker)
      type(train_type), intent(in) :: train
      !> Variable that has the name.
      character(*), intent(in) :: variable, name
      class(checker_type), intent(inout) :: checker
      character(len(name)), allocatable :: names(:)
      integer :: i, best

      is_body = .false.
      do i = 1, size(train%bodies)
         if (allocated(train%bodies(i)%name)) is_body = train%bodies(i)%name == name
         if (is_body) return
      end do
      allocate (names(size(train%bodies)))
      names = ''
      do i = 1, size(names)
         if (allocated(train%bodies(i)%name)) names(i) = train%bodies(i)%name
      end do
      if (any(checker%problems%reported('body', [(i, i=1, size(names))], 'name'))) return
      best = nearest_name(trim(name), names)
      if (best > 0) then
         call checker%complain(variable, "'"//trim(name)//"'", "is the name of no &body (did you mean '"//trim(names(best))//"'?)")
      else
         call checker%complain(variable, "'"//trim(name)//"'", 'is the name of no &body')
      end if
   end function is_body

   !> A body on a mesh or an elastic shaft has inertia; a body with rigid shafts only may have none.
   subroutine check_inertias(train, shaft_ends, mesh_ends, checker)
      type(train_type), intent(in) :: train
      !> Bodies that each shaft and each mesh joins, (2, shaft) and (2, mesh).
      integer, intent(in) :: shaft_ends(:, :), mesh_ends(:, :)
      class(checker_type), intent(inout) :: checker
      logical :: needed(size(train%bodies))
      integer :: i, j

      needed = .false.
      do i = 1, size(train%shafts)
         if (.not. train%shafts(i)%rigid) needed(shaft_ends(:, i)) = .true.
      end do
      do i = 1, size(train%meshes)
         needed(mesh_ends(:, i)) = .true.
      end do
      do i = 1, size(train%bodies)
         if (train%bodies(i)%held) cycle
         if (.not. needed(i) .or. train%bodies(i)%inertia > 0 .or. checker%drawing_is_wrong('body', i)) cycle
         ! The gears of a wrong drawing give no inertia.
         if (any([(any(mesh_ends(:, j) == i) .and. checker%drawing_is_wrong('mesh', j), j=1, size(train%meshes))])) cycle
         call checker%enter('body', i)
         if (train%bodies(i)%inertia < 0) then
            if (carries_ring(i)) then
               call checker%lacks('inertia', '> 0 kg m^2', " or outer_diameter, bore and width of '"//train%bodies(i)%name// &
                                  "': an internal gear is a ring, whose inertia does not follow from its teeth")
            else
               call checker%lacks('inertia', '> 0 kg m^2', ' or outer_diameter and width, or gears with teeth, normal_module &
                                  &and face_width')
            end if
         else
            call checker%complain('inertia', real_text(train%bodies(i)%inertia), 'must be > 0 kg m^2 on a mesh, a coupling or &
                                  &an elastic shaft')
         end if
         call checker%leave()
      end do

   contains

      !> Whether a body is the larger gear of an internal pair.
      pure logical function carries_ring(body)
         integer, intent(in) :: body
         integer :: j, k

         carries_ring = .false.
         do j = 1, size(train%meshes)
            if (.not. train%meshes(j)%internal .or. .not. train%meshes(j)%is_pair()) cycle
            k = merge(1, 2, train%meshes(j)%driving_radius > train%meshes(j)%driven_radius)
            carries_ring = carries_ring .or. mesh_ends(k, j) == body
         end do
      end function carries_ring

   end subroutine check_inertias

   !> No mesh and no elastic shaft joins two bodies that rigid shafts make one.
   subroutine check_elastic(train, shaft_ends, mesh_ends, carrier, checker)
      type(train_type), intent(in) :: train
      integer, intent(in) :: shaft_ends(:, :), mesh_ends(:, :), carrier(:)
      class(checker_type), intent(inout) :: checker
      character(*), parameter :: lock = '; a set that turns as one is locked by a &shaft with a stiffness'
      type(nodes_type) :: nodes
      integer :: i

      call join_rigid(train, nodes)
      do i = 1, size(train%shafts)
         if (.not. train%shafts(i)%rigid) call check_one('shaft', train%shafts(i)%between, shaft_ends(:, i))
      end do
      do i = 1, size(train%meshes)
         if (train%meshes(i)%axis > 0) cycle
         call check_one(trim(group_name(train%meshes, i)), train%meshes(i)%between, mesh_ends(:, i))
         if (carrier(i) == 0) cycle
         associate (names => train%meshes(i)%between, arm => train%meshes(i)%carrier)
            if (nodes%node(carrier(i)) == 0) cycle
            call check_one('mesh', [names(1), arm], [mesh_ends(1, i), carrier(i)], lock)
            call check_one('mesh', [names(2), arm], [mesh_ends(2, i), carrier(i)], lock)
         end associate
      end do

   contains

      subroutine check_one(group, between, ends, advice)
         character(*), intent(in) :: group, between(2)
         integer, intent(in) :: ends(2)
         character(*), intent(in), optional :: advice
         character(:), allocatable :: words

         if (nodes%node(ends(1)) /= nodes%node(ends(2))) return
         if (group == 'shaft') call checker%enter(group, i)
         if (group /= 'shaft') call enter_mesh(checker, train%meshes, i)
         if (nodes%node(ends(1)) == 0) call checker%complain('between', "'"//trim(between(1))//"', '"//trim(between(2))//"'", &
            'are both held, directly or by rigid shafts: nothing moves in between')
         if (nodes%node(ends(1)) == 0) call checker%leave()
         if (nodes%node(ends(1)) == 0) return
         words = ': nothing moves in between'
         if (present(advice)) words = words//advice
         call checker%complain('between', "'"//trim(between(1))//"', '"//trim(between(2))//"'", &
                               'are made one body by '//trim(rigid_way(train, shaft_ends, ends))//words)
         call checker%leave()
      end subroutine check_one

   end subroutine check_elastic

   !> The rigid shafts from one body to another: 'the rigid &shaft 1, &shaft 3'.
   function rigid_way(train, shaft_ends, ends) result(words)
      type(train_type), intent(in) :: train
      integer, intent(in) :: shaft_ends(:, :), ends(2)
      character(400) :: words
      !> Rigid shaft by which the search from the second end came to each body; 0: not met; -1: the second end.
      integer :: by(size(train%bodies)), pair(2), body, i, round

      by = 0
      by(ends(2)) = -1
      do round = 1, size(by)
         do i = 1, size(train%shafts)
            if (.not. train%shafts(i)%rigid) cycle
            pair = shaft_ends(:, i)
            if (by(pair(1)) /= 0 .neqv. by(pair(2)) /= 0) by(merge(pair(2), pair(1), by(pair(1)) /= 0)) = i
         end do
      end do
      words = ''
      body = ends(1)
      do while (body /= ends(2))
         i = by(body)
         words = trim(words)//', &shaft '//integer_text(i)
         body = sum(shaft_ends(:, i)) - body
      end do
      words = 'the rigid '//words(3:)
   end function rigid_way

   !> The mean torques of loops can be computed: with stiffnesses too far apart they are lost in rounding.
   subroutine check_rest(train, network, checker)
      type(train_type), intent(in) :: train
      type(network_type), intent(in) :: network
      class(checker_type), intent(inout) :: checker
      type(law_type) :: law(size(train%meshes))
      real(dp), allocatable :: force(:)
      real(dp) :: residual
      integer :: i

      do i = 1, size(law)
         call put_law(train%meshes(i), train%characteristic_length, law(i))
      end do
      call check_middles(train%meshes, network, checker)
      call check_friction(train%meshes, network, checker)
      allocate (force(size(network%elements)))
      call rest_forces(network, law, train%characteristic_length, force, residual)
      if (any(train%meshes%axis > 0)) call check_flanks(train, network, force, checker)
      if (residual < largest_residual) return
      call checker%problems%add('how the loops share the mean torque was not found: the displacements round them agree to '// &
                                text(residual)//' only, 1e-10 is asked: are the stiffnesses in SI units?', 'train', 1, &
                                names_group=.true.)
   end subroutine check_rest

end module geartrain_network_check_network
