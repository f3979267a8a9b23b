!> Checks that a train can turn, with speeds that are determined: all bodies are joined, no loop of gears locks, and as many bodies
!> balance the torques as there are independent speeds.
module geartrain_network_check_turning
   use geartrain_base_checker, only: checker_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: counted, integer_text, real_text, text
   use geartrain_train_body, only: body_type
   use geartrain_train_mesh_groups, only: group_name, group_number
   use geartrain_network_network, only: balances, build_network, network_type
   use geartrain_train_train, only: train_type
   use geartrain_train_turning, only: find_turning, lock_by_teeth, turning_type
   implicit none (type, external)
   private
   public :: check_joints, check_turning

   !> Largest difference from 1 of the product of the ratios round a loop [1].
   real(dp), parameter :: rounding = 1e-9_dp

contains

   !> Speed ratios tell what the gears leave free, gears on carriers turn, and as many bodies balance the torques as there are
   !> independent speeds.
   subroutine check_turning(train, mesh_ends, carrier, network, checker)
      !> The plain train, with bodies.
      type(train_type), intent(in) :: train
      !> Bodies of each mesh, (2, mesh), and its carrier, 0: none, (mesh).
      integer, intent(in) :: mesh_ends(:, :), carrier(:)
      !> Of a train without a problem.
      type(network_type), intent(out) :: network
      class(checker_type), intent(inout) :: checker
      type(turning_type) :: turning
      character(:), allocatable :: why
      integer :: i, ratios
      logical :: by_teeth

      call find_turning(train, turning)
      ratios = count(train%bodies%ratio_given)
      if (ratios /= max(0, turning%motions - 1)) then
         i = findloc(train%bodies%ratio_given, .true., 1)
         if (ratios > max(0, turning%motions - 1)) then
            call checker%enter('body', i)
            call checker%complain('speed_ratio', real_text(train%bodies(i)%speed_ratio), 'is one of '//integer_text(ratios)// &
               ', but beside that of '//"'"//train%bodies(max(1, turning%reference))%name// &
               "' shafts and gears leave "//counted(max(0, turning%motions - 1), 'speed', 'speeds')//' free')
            call checker%leave()
         else
            call checker%problems%add('shafts and gears leave '//integer_text(turning%motions)//' speeds free: give speed_ratio &
               &of '//counted(turning%motions - 1 - ratios, 'more body', 'more bodies')//', its speed over that of '//"'"// &
               train%bodies(max(1, turning%reference))%name//"', or held = .true. of a body that stands still", 'train', 1, &
               names_group=.true.)
         end if
         return
      end if
      if (turning%motions == 1 .and. .not. turning%determined .and. turning%reference > 0) then
         call checker%enter('train', 1)
         call checker%complain('speed_of', "'"//train%bodies(turning%reference)%name//"'", 'stands still: name a body that turns')
         call checker%leave()
         return
      end if
      if (turning%motions > 1 .and. .not. turning%determined) then
         i = findloc(train%bodies%ratio_given, .true., 1)
         call checker%enter('body', i)
         call checker%complain('speed_ratio', real_text(train%bodies(i)%speed_ratio), 'leaves some speed free, or stops '//"'"// &
            train%bodies(max(1, turning%reference))%name//"'"//': give that of another body')
         call checker%leave()
         return
      end if
      do i = 1, size(carrier)
         if (carrier(i) == 0 .or. abs(turning%relative(i)) > 0) cycle
         if (any(train%bodies%stiffness_to_ground > 0) .or. all(train%bodies([mesh_ends(:, i), carrier(i)])%held)) cycle
         by_teeth = lock_by_teeth(train, mesh_ends(1, i), carrier(i))
         if (turning%locked(i) .and. .not. by_teeth) cycle
         call checker%enter('mesh', i)
         if (by_teeth .or. .not. any(train%bodies%held)) then
            why = 'they lock, as teeth that do not fit do'
         else
            call name_bodies(train%bodies, train%bodies%held, why)
            why = why//' held'
         end if
         call checker%complain('carrier', "'"//trim(train%meshes(i)%carrier)//"'", 'is a carrier against which its gears do not &
            &turn: '//why)
         call checker%leave()
         return
      end do
      call check_balance(train, turning, checker)
      ! Numbers out of their ranges make no network.
      if (checker%problems%count > 0) return
      call build_network(train, network)
      if (balances(network)) return
      i = findloc(train%bodies%balances, .true., 1)
      if (i == 0) return
      call checker%enter('body', i)
      if (count(train%bodies%balances) == 1) then
         call checker%complain('balances', '.true.', 'is that of a body that stands still: its torque does no work')
      else
         call checker%complain('balances', '.true.', 'leaves torques unbalanced: choose a body of another speed')
      end if
      call checker%leave()
   end subroutine check_turning

   !> Bodies with their verb: "'sun' is", "'sun' and 'ring' are", "'sun', 'ring' and 3 more are".
   pure subroutine name_bodies(bodies, which, words)
      type(body_type), intent(in) :: bodies(:)
      logical, intent(in) :: which(:)
      character(:), allocatable, intent(out) :: words
      integer, parameter :: most_named = 4
      integer :: place(count(which)), i

      place = pack([(i, i=1, size(bodies))], which)
      words = "'"//bodies(place(1))%name//"'"
      do i = 2, size(place)
         if (i > most_named) then
            words = words//' and '//integer_text(size(place) - most_named)//' more'
            exit
         end if
         if (i == size(place)) then
            words = words//' and '
         else
            words = words//', '
         end if
         words = words//"'"//bodies(place(i))%name//"'"
      end do
      if (size(place) == 1) then
         words = words//' is'
      else
         words = words//' are'
      end if
   end subroutine name_bodies

   !> As many bodies balance the others as there are independent speeds, and have no given mean torque.
   subroutine check_balance(train, turning, checker)
      type(train_type), intent(in) :: train
      type(turning_type), intent(in) :: turning
      class(checker_type), intent(inout) :: checker
      integer, allocatable :: balancing(:)
      integer :: i, first

      balancing = pack([(i, i=1, size(train%bodies))], train%bodies%balances)
      if (size(balancing) > turning%motions) then
         first = balancing(1)
         call checker%enter('body', balancing(turning%motions + 1))
         if (turning%motions == 0) then
            call checker%complain('balances', '.true.', 'is not for a train that cannot turn, held by a body or a spring to &
               &ground: they bear the mean torques')
         else if (turning%motions == 1) then
            call checker%complain('balances', '.true.', 'is that of &body '//integer_text(first)//' already: one balances the &
               &others')
         else
            call checker%complain('balances', '.true.', 'is one of '//integer_text(size(balancing))//': of this train '// &
               integer_text(turning%motions)//' bodies balance the others, one for each independent speed')
         end if
         call checker%leave()
         return
      end if
      if (size(balancing) < turning%motions) then
         if (turning%motions == 1) then
            call checker%problems%add('no &body has balances = .true.: the mean torque of one of them, the load, balances that of &
               &all others', 'train', 1, names_group=.true.)
         else
            call checker%problems%add(integer_text(size(balancing))//' &body has balances = .true., '// &
               integer_text(turning%motions)//' are needed, one for each independent speed', 'train', 1, names_group=.true.)
         end if
         return
      end if
      do i = 1, size(balancing)
         if (.not. abs(train%bodies(balancing(i))%torque) > 0) cycle
         call checker%enter('body', balancing(i))
         call checker%complain('torque', real_text(train%bodies(balancing(i))%torque), 'contradicts balances = .true.: its mean &
            &torque follows from the others')
         call checker%leave()
      end do
   end subroutine check_balance

   !> Every body is joined with the first body, and round every loop without carriers the ratios multiply to 1. A search visits each
   !> body once; every further joint closes a loop.
   subroutine check_joints(train, shaft_ends, mesh_ends, carrier, checker)
      !> The plain train, with bodies.
      type(train_type), intent(in) :: train
      !> Bodies that each shaft and each mesh joins, (2, shaft) and (2, mesh).
      integer, intent(in) :: shaft_ends(:, :), mesh_ends(:, :)
      !> Carrier of each mesh, 0: none, (mesh). Loops with carriers are not walked round.
      integer, intent(in) :: carrier(:)
      class(checker_type), intent(inout) :: checker
      !> Reduced radius [1] and sense of rotation of each body, and the body from which the search came, (body).
      real(dp) :: radius(size(train%bodies))
      integer :: sense(size(train%bodies)), came(size(train%bodies)), ends(2), i
      !> Number of the search that came to each body, 0: none has; whether it is joined with the first body, (body).
      integer :: tree(size(train%bodies)), trees
      logical, dimension(size(train%bodies)) :: joined, part
      logical :: whole, changed
      character(:), allocatable :: words

      tree = 0
      radius = 1
      sense = 1
      came = 0
      trees = 0
      do while (any(tree == 0))
         trees = trees + 1
         tree(findloc(tree, 0, 1)) = trees
         changed = .true.
         do while (changed)
            changed = .false.
            do i = 1, size(shaft_ends, 2)
               call pass(shaft_ends(:, i), [1.0_dp, 1.0_dp], 1)
            end do
            do i = 1, size(mesh_ends, 2)
               if (carrier(i) > 0) cycle
               associate (mesh => train%meshes(i))
                  call pass(mesh_ends(:, i), [mesh%driving_radius, mesh%driven_radius], merge(1, -1, mesh%internal))
               end associate
            end do
         end do
      end do
      joined = tree == 1
      call spread(joined)
      whole = all(joined)
      do while (.not. all(joined))
         i = findloc(joined, .false., 1)
         part = tree == tree(i)
         call spread(part)
         call checker%enter('body', i)
         call name_bodies(train%bodies, part, words)
         call checker%problems%add(words//' joined with '//"'"//train%bodies(1)%name// &
                                   "' by no shaft, mesh or coupling", 'body', i, 'name')
         call checker%leave()
         joined = joined .or. part
      end do
      if (.not. whole) return
      do i = 1, size(train%shafts)
         ends = shaft_ends(:, i)
         call close_loop(ends, radius(ends(2))/radius(ends(1)), sense(ends(1)) == sense(ends(2)), 'shaft')
      end do
      do i = 1, size(train%meshes)
         ends = mesh_ends(:, i)
         if (carrier(i) > 0) cycle
         associate (mesh => train%meshes(i))
            call close_loop(ends, radius(ends(2))/radius(ends(1))*(mesh%driving_radius/mesh%driven_radius), &
                            (sense(ends(1)) == sense(ends(2))) .eqv. mesh%internal, trim(group_name(train%meshes, i)))
         end associate
      end do

   contains

      !> Adds the bodies that are joined by meshes on carriers.
      subroutine spread(joined)
         logical, intent(inout) :: joined(:)
         integer :: n

         changed = .true.
         do while (changed)
            changed = .false.
            do n = 1, size(carrier)
               if (carrier(n) == 0) cycle
               associate (here => [mesh_ends(:, n), carrier(n)])
                  if (.not. any(joined(here)) .or. all(joined(here))) cycle
                  joined = joined .or. tree == tree(here(1)) .or. tree == tree(here(2)) .or. tree == tree(here(3))
                  changed = .true.
               end associate
            end do
         end do
      end subroutine spread

      subroutine pass(ends, radii, turn)
         integer, intent(in) :: ends(2), turn
         real(dp), intent(in) :: radii(2)

         if (tree(ends(1)) == 0 .eqv. tree(ends(2)) == 0) return
         if (tree(ends(1)) > 0) then
            radius(ends(2)) = radius(ends(1))*(radii(2)/radii(1))
            came(ends(2)) = ends(1)
         else
            radius(ends(1)) = radius(ends(2))*(radii(1)/radii(2))
            came(ends(1)) = ends(2)
         end if
         if (tree(ends(2)) == 0) sense(ends(2)) = turn*sense(ends(1))
         if (tree(ends(1)) == 0) sense(ends(1)) = turn*sense(ends(2))
         tree(ends) = trees
         changed = .true.
      end subroutine pass

      !> Adds a problem where a joint closes a loop that locks: `ratio` is not 1, or the senses of rotation do not agree.
      subroutine close_loop(ends, ratio, agree, group)
         integer, intent(in) :: ends(2)
         real(dp), intent(in) :: ratio
         logical, intent(in) :: agree
         character(*), intent(in) :: group
         character(:), allocatable :: why
         integer :: number

         if (abs(ratio - 1) <= rounding .and. agree) return
         why = 'these gears lock: '
         if (.not. agree) why = why//'there is an odd number of external pairs in the loop '
         if (agree) why = why//'the ratios multiply to '//text(ratio)//', not 1, round the loop '
         number = i
         if (group /= 'shaft') number = group_number(train%meshes, i)
         call checker%problems%add(why//trim(loop_of(ends)), group, number, 'between')
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

end module geartrain_network_check_turning
