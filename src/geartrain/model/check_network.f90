!> Checks that bodies, shafts and meshes make one network: every name is known, all bodies are joined, no loop locks, one body
!> balances the torques.
module geartrain_model_check_network
   use geartrain_base_checker, only: checker_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_nearest, only: nearest_name
   use geartrain_base_numbers, only: integer_text, real_text, text
   use geartrain_mesh_law_law, only: law_type
   use geartrain_model_bodies, only: find_ends
   use geartrain_model_mesh, only: is_given, put_law
   use geartrain_model_network, only: build_network, network_type
   use geartrain_model_nodes, only: join_rigid, nodes_type
   use geartrain_model_rest, only: largest_residual, rest_forces
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: check_network

   !> Largest difference from 1 of the product of the ratios round a loop [1].
   real(dp), parameter :: rounding = 1e-9_dp

contains

   !> Adds every problem of the network; the range of each value is checked elsewhere.
   subroutine check_network(train, checker)
      !> The plain train, with bodies, shafts and meshes.
      type(train_type), intent(in) :: train
      !> Gets the problems.
      class(checker_type), intent(inout) :: checker
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      integer :: before

      before = checker%problems%count
      call check_chain_values(train, checker)
      call check_names(train, checker)
      call check_balance(train, checker)
      if (size(train%meshes) == 0) call checker%problems%add('the train has no &mesh', 'train', 1, names_group=.true.)
      if (checker%problems%count > before) return
      ! The checks below need the names; a value that is out of range has been told with its variable.
      call find_ends(train, shaft_ends, mesh_ends)
      if (any(shaft_ends == 0) .or. any(mesh_ends == 0)) return
      call check_inertias(train, shaft_ends, mesh_ends, checker)
      if (.not. all(train%meshes%driving_radius > 0 .and. train%meshes%driven_radius > 0)) return
      call check_joints(train, shaft_ends, mesh_ends, checker)
      call check_elastic(train, shaft_ends, mesh_ends, checker)
      ! Numbers that a wrong drawing gave have no rest.
      if (checker%problems%count == 0) call check_rest(train, checker)
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
         call checker%enter('mesh', i)
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
         call checker%enter('mesh', i)
         call check_ends(train, train%meshes(i)%between, checker)
         call checker%leave()
      end do
   end subroutine check_names

   subroutine check_ends(train, between, checker)
      type(train_type), intent(in) :: train
      character(*), intent(in) :: between(2)
      class(checker_type), intent(inout) :: checker
      character(len(between)) :: names(size(train%bodies))
      integer :: i, best

      if (all(between == '')) then
         call checker%lacks('between', 'the names of the two bodies that it joins')
         return
      end if
      names = ''
      do i = 1, size(names)
         if (allocated(train%bodies(i)%name)) names(i) = train%bodies(i)%name
      end do
      do i = 1, 2
         if (any(names == between(i))) cycle
         ! A name that could not be read may be this name.
         if (any(checker%problems%reported('body', [(best, best=1, size(names))], 'name'))) return
         best = nearest_name(trim(between(i)), names)
         if (best > 0) then
            call checker%complain('between', "'"//trim(between(i))//"'", "is the name of no &body (did you mean '" &
                                  //trim(names(best))//"'?)")
         else
            call checker%complain('between', "'"//trim(between(i))//"'", 'is the name of no &body')
         end if
         return
      end do
      if (between(1) == between(2)) call checker%complain('between', "'"//trim(between(1))//"' twice", 'must be two bodies')
   end subroutine check_ends

   !> Exactly one body balances the others, and has no given mean torque.
   subroutine check_balance(train, checker)
      type(train_type), intent(in) :: train
      class(checker_type), intent(inout) :: checker
      integer :: i, first

      first = findloc(train%bodies%balances, .true., 1)
      if (any(train%bodies%held .or. train%bodies%stiffness_to_ground > 0)) then
         if (first == 0) return
         call checker%enter('body', first)
         call checker%complain('balances', '.true.', 'is not for a train that a held body or a spring to ground holds: they bear &
                               &the mean torques')
         call checker%leave()
         return
      end if
      if (first == 0) call checker%problems%add('no &body has balances = .true.: the mean torque of one of them, the load, &
         &balances that of all others', 'train', 1, names_group=.true.)
      do i = first + 1, size(train%bodies)
         if (.not. train%bodies(i)%balances .or. first == 0) cycle
         call checker%enter('body', i)
         call checker%complain('balances', '.true.', 'is that of &body '//integer_text(first)//' already: one balances the others')
         call checker%leave()
      end do
      if (first == 0) return
      if (.not. abs(train%bodies(first)%torque) > 0) return
      call checker%enter('body', first)
      call checker%complain('torque', real_text(train%bodies(first)%torque), 'contradicts balances = .true.: its mean torque &
                            &follows from the others')
      call checker%leave()
   end subroutine check_balance

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
            call checker%complain('inertia', real_text(train%bodies(i)%inertia), 'must be > 0 kg m^2 on a mesh or an elastic &
                                  &shaft')
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
            if (.not. train%meshes(j)%internal) cycle
            k = merge(1, 2, train%meshes(j)%driving_radius > train%meshes(j)%driven_radius)
            carries_ring = carries_ring .or. mesh_ends(k, j) == body
         end do
      end function carries_ring

   end subroutine check_inertias

   !> No mesh and no elastic shaft joins two bodies that rigid shafts make one.
   subroutine check_elastic(train, shaft_ends, mesh_ends, checker)
      type(train_type), intent(in) :: train
      integer, intent(in) :: shaft_ends(:, :), mesh_ends(:, :)
      class(checker_type), intent(inout) :: checker
      type(nodes_type) :: nodes
      integer :: i

      call join_rigid(train, nodes)
      do i = 1, size(train%shafts)
         if (.not. train%shafts(i)%rigid) call check_one('shaft', train%shafts(i)%between, shaft_ends(:, i))
      end do
      do i = 1, size(train%meshes)
         call check_one('mesh', train%meshes(i)%between, mesh_ends(:, i))
      end do

   contains

      subroutine check_one(group, between, ends)
         character(*), intent(in) :: group, between(2)
         integer, intent(in) :: ends(2)

         if (nodes%node(ends(1)) /= nodes%node(ends(2))) return
         call checker%enter(group, i)
         if (nodes%node(ends(1)) == 0) call checker%complain('between', "'"//trim(between(1))//"', '"//trim(between(2))//"'", &
            'are both held, directly or by rigid shafts: nothing moves in between')
         if (nodes%node(ends(1)) == 0) call checker%leave()
         if (nodes%node(ends(1)) == 0) return
         call checker%complain('between', "'"//trim(between(1))//"', '"//trim(between(2))//"'", &
                               'are made one body by '//trim(rigid_way(train, shaft_ends, ends))//': nothing moves in between')
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
   subroutine check_rest(train, checker)
      type(train_type), intent(in) :: train
      class(checker_type), intent(inout) :: checker
      type(network_type) :: network
      type(law_type) :: law(size(train%meshes))
      real(dp), allocatable :: force(:)
      real(dp) :: residual
      integer :: i

      do i = 1, size(law)
         call put_law(train%meshes(i), train%characteristic_length, law(i))
      end do
      call build_network(train, network)
      allocate (force(size(network%elements)))
      call rest_forces(network, law, train%characteristic_length, force, residual)
      if (residual < largest_residual) return
      call checker%problems%add('how the loops share the mean torque was not found: the displacements round them agree to '// &
                                text(residual)//' only, 1e-10 is asked: are the stiffnesses in SI units?', 'train', 1, &
                                names_group=.true.)
   end subroutine check_rest

   !> Every body is joined with the first body, and round every loop the ratios multiply to 1. A search from the first body visits
   !> each body once; every further joint closes a loop.
   subroutine check_joints(train, shaft_ends, mesh_ends, checker)
      type(train_type), intent(in) :: train
      !> Bodies that each shaft and each mesh joins, (2, shaft) and (2, mesh).
      integer, intent(in) :: shaft_ends(:, :), mesh_ends(:, :)
      class(checker_type), intent(inout) :: checker
      !> Reduced radius [1] and sense of rotation of each body, and the body from which the search came, (body).
      real(dp) :: radius(size(train%bodies))
      integer :: sense(size(train%bodies)), came(size(train%bodies)), ends(2), i
      logical :: met(size(train%bodies)), changed

      met = .false.
      met(1) = .true.
      radius = 1
      sense = 1
      came = 0
      changed = .true.
      do while (changed)
         changed = .false.
         do i = 1, size(train%shafts)
            call pass(shaft_ends(:, i), [1.0_dp, 1.0_dp], 1)
         end do
         do i = 1, size(train%meshes)
            associate (mesh => train%meshes(i))
               call pass(mesh_ends(:, i), [mesh%driving_radius, mesh%driven_radius], merge(1, -1, mesh%internal))
            end associate
         end do
      end do
      do i = 1, size(train%bodies)
         if (met(i)) cycle
         call checker%enter('body', i)
         call checker%problems%add("'"//train%bodies(i)%name//"' is joined with '"//train%bodies(1)%name// &
                                   "' by no shaft and no mesh", 'body', i, 'name')
         call checker%leave()
      end do
      if (.not. all(met)) return
      do i = 1, size(train%shafts)
         ends = shaft_ends(:, i)
         call close_loop(ends, radius(ends(2))/radius(ends(1)), sense(ends(1)) == sense(ends(2)), 'shaft')
      end do
      do i = 1, size(train%meshes)
         ends = mesh_ends(:, i)
         associate (mesh => train%meshes(i))
            call close_loop(ends, radius(ends(2))/radius(ends(1))*(mesh%driving_radius/mesh%driven_radius), &
                            (sense(ends(1)) == sense(ends(2))) .eqv. mesh%internal, 'mesh')
         end associate
      end do

   contains

      subroutine pass(ends, radii, turn)
         integer, intent(in) :: ends(2), turn
         real(dp), intent(in) :: radii(2)

         if (met(ends(1)) .eqv. met(ends(2))) return
         if (met(ends(1))) then
            radius(ends(2)) = radius(ends(1))*(radii(2)/radii(1))
            came(ends(2)) = ends(1)
         else
            radius(ends(1)) = radius(ends(2))*(radii(1)/radii(2))
            came(ends(1)) = ends(2)
         end if
         if (.not. met(ends(2))) sense(ends(2)) = turn*sense(ends(1))
         if (.not. met(ends(1))) sense(ends(1)) = turn*sense(ends(2))
         met(ends) = .true.
         changed = .true.
      end subroutine pass

      !> Adds a problem where a joint closes a loop that locks: `ratio` is not 1, or the senses of rotation do not agree.
      subroutine close_loop(ends, ratio, agree, group)
         integer, intent(in) :: ends(2)
         real(dp), intent(in) :: ratio
         logical, intent(in) :: agree
         character(*), intent(in) :: group
         character(:), allocatable :: why

         if (abs(ratio - 1) <= rounding .and. agree) return
         why = 'these gears lock: '
         if (.not. agree) why = why//'there is an odd number of external pairs in the loop '
         if (agree) why = why//'the ratios multiply to '//text(ratio)//', not 1, round the loop '
         call checker%problems%add(why//trim(loop_of(ends)), group, i, 'between')
      end subroutine close_loop

      !> The bodies of a loop in words, 'a - b - c - a': along the search tree from one end of the joint to the other.
      function loop_of(ends) result(words)
         integer, intent(in) :: ends(2)
         character(400) :: words
         integer :: first, second

         words = train%bodies(ends(1))%name
         first = ends(1)
         do
            if (is_before(first, ends(2))) exit
            first = came(first)
            words = trim(words)//' - '//train%bodies(first)%name
         end do
         second = ends(2)
         do while (second /= first)
            words = trim(words)//' - '//train%bodies(lower(first, second))%name
            first = lower(first, second)
         end do
         words = trim(words)//' - '//train%bodies(ends(1))%name
      end function loop_of

      !> Whether the search came to `body` by way of `before`, or `before` is `body`.
      logical function is_before(before, body)
         integer, intent(in) :: before, body
         integer :: now

         now = body
         do while (now /= 0 .and. now /= before)
            now = came(now)
         end do
         is_before = now == before
      end function is_before

      !> The body after `before` on the way of the search to `body`.
      integer function lower(before, body)
         integer, intent(in) :: before, body

         lower = body
         do while (came(lower) /= before)
            lower = came(lower)
         end do
      end function lower

   end subroutine check_joints

end module geartrain_model_check_network
