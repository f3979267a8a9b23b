!> Equal branches of a train: parts of its network between the same nodes, such as the planets of a star gear or parallel meshes,
!> that may change places without a change of the dimensionless system.
!>
!> Nodes and elements get a kind by their own numbers, then again and again by the kinds of their neighbours, as long as there are
!> more kinds. A node that is alone in its kind keeps its place. What is left without these nodes falls into pieces, and pieces of
!> the same kinds at the same nodes are equal branches. Within a branch the search goes on: a planet may have two equal meshes.
module geartrain_network_equal_branches
   use geartrain_base_kinds, only: dp
   use geartrain_base_series, only: series_type
   use geartrain_base_sorting, only: ascending
   use geartrain_mesh_law_law, only: law_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: equal_branches_type, find_equal_branches, same_branches, same_nodes

   !> Relative difference of two numbers that are equal but for rounding; of two static forces, which an iteration finds.
   real(dp), parameter :: rounding = 1e-12_dp, rest_error = 1e-8_dp

   !> A set of equal branches.
   type :: equal_branches_type
      !> Unknown mesh number i of each branch, an unknown of the balance, (mesh of a branch, branch).
      integer, allocatable :: unknown(:, :)
   end type equal_branches_type

contains

   !> Finds the equal branches that have unknown meshes.
   subroutine find_equal_branches(system, sets)
      type(system_type), intent(in) :: system
      !> The sets, each of two branches or more.
      type(equal_branches_type), allocatable, intent(out) :: sets(:)
      !> Nodes come first, then elements.
      integer :: kind(size(system%network%inertia) + system%elements), piece(size(kind)), nodes, n
      integer, allocatable :: member(:, :), length(:), total(:), begin(:), by_kind(:), by_piece(:)
      logical :: fixed(size(system%network%inertia)), changed(size(fixed)), alone
      logical, allocatable :: listed(:)
      integer :: i, j, pieces
      real(dp) :: least
      type(equal_branches_type) :: set

      allocate (sets(0))
      ! Torques that are equal at one speed may differ at others.
      if (allocated(system%speed_loads)) return
      nodes = size(fixed)
      least = rest_error*maxval(abs(system%static_force))
      call find_kinds(system, kind)
      by_kind = ascending(real(kind, dp))
      by_piece = by_kind
      fixed = [(count(kind == kind(n)) == 1, n=1, nodes)]
      do
         call find_pieces(system, fixed, kind, piece, pieces)
         allocate (listed(pieces), source=.false.)
         allocate (length(pieces), total(pieces), source=0)
         do n = 1, size(kind)
            if (piece(n) == 0) cycle
            length(piece(n)) = length(piece(n)) + 1
            total(piece(n)) = total(piece(n)) + kind(n)
         end do
         ! Nodes and elements of each piece in the order of their kinds: by_piece(begin(i) + 1:begin(i) + length(i)).
         allocate (begin(pieces), source=0)
         do i = 2, pieces
            begin(i) = begin(i - 1) + length(i - 1)
         end do
         length = 0
         do n = 1, size(kind)
            associate (k => by_kind(n))
               if (piece(k) == 0) cycle
               length(piece(k)) = length(piece(k)) + 1
               by_piece(begin(piece(k)) + length(piece(k))) = k
            end associate
         end do
         do i = 1, pieces
            if (listed(i)) cycle
            ! The sum of the kinds tells most pieces apart without a look at their members.
            if (all(length(i + 1:) /= length(i) .or. total(i + 1:) /= total(i))) cycle
            member = reshape(by_piece(begin(i) + 1:begin(i) + length(i)), [length(i), 1])
            do j = i + 1, pieces
               if (length(j) /= length(i) .or. total(j) /= total(i)) cycle
               associate (other => by_piece(begin(j) + 1:begin(j) + length(j)))
                  if (.not. are_equal(system, fixed, kind, least, member(:, 1), other)) cycle
                  member = reshape([member, other], [size(member, 1), size(member, 2) + 1])
               end associate
               listed(j) = .true.
            end do
            if (size(member, 2) == 1) cycle
            call take_unknowns(system, member, set%unknown)
            if (size(set%unknown) > 0) sets = [sets, set]
         end do
         ! Next the search goes on within the pieces: a node that is alone in its kind within its piece keeps its place there.
         changed = fixed
         do i = 1, pieces
            associate (own => by_piece(begin(i) + 1:begin(i) + length(i)))
               do n = 1, size(own)
                  alone = own(n) <= nodes
                  if (n > 1) alone = alone .and. kind(own(n - 1)) /= kind(own(n))
                  if (n < size(own)) alone = alone .and. kind(own(n + 1)) /= kind(own(n))
                  if (alone) fixed(own(n)) = .true.
               end do
            end associate
         end do
         deallocate (listed, length, total, begin)
         if (all(changed .eqv. fixed)) exit
      end do
   end subroutine find_equal_branches

   !> Whether two lists of sets are the same.
   pure logical function same_branches(one, other)
      !> The lists.
      type(equal_branches_type), intent(in) :: one(:), other(:)
      integer :: i

      same_branches = size(one) == size(other)
      do i = 1, size(one)
         if (same_branches) same_branches = all(shape(one(i)%unknown) == shape(other(i)%unknown))
         if (same_branches) same_branches = all(one(i)%unknown == other(i)%unknown)
      end do
   end function same_branches

   !> Unknown meshes of the members, (mesh, branch).
   pure subroutine take_unknowns(system, member, unknown)
      type(system_type), intent(in) :: system
      integer, intent(in) :: member(:, :)
      integer, allocatable, intent(out) :: unknown(:, :)
      integer :: number(size(member, 1), size(member, 2)), i, j

      do j = 1, size(member, 2)
         do i = 1, size(member, 1)
            number(i, j) = findloc(system%cut%element, member(i, j) - size(system%network%inertia), 1)
         end do
      end do
      unknown = number(pack([(i, i=1, size(number, 1))], number(:, 1) > 0), :)
   end subroutine take_unknowns

   !> Numbers the pieces that are left without the fixed nodes; 0 of a fixed node.
   pure subroutine find_pieces(system, fixed, kind, piece, pieces)
      type(system_type), intent(in) :: system
      logical, intent(in) :: fixed(:)
      integer, intent(in) :: kind(:)
      integer, intent(out) :: piece(:), pieces
      integer, allocatable :: ends(:)
      integer :: i, n, nodes, least, number(size(kind))
      logical :: done

      nodes = size(fixed)
      piece = [(i, i=1, size(kind))]
      where (fixed) piece(:nodes) = 0
      do
         done = .true.
         do n = 1, system%elements
            ends = system%network%elements(n)%node
            do i = 1, size(ends)
               if (fixed(ends(i))) cycle
               least = min(piece(nodes + n), piece(ends(i)))
               if (piece(nodes + n) == least .and. piece(ends(i)) == least) cycle
               piece(nodes + n) = least
               piece(ends(i)) = least
               done = .false.
            end do
         end do
         if (done) exit
      end do
      ! The first member of a piece has the number of the piece.
      pieces = 0
      do i = 1, size(piece)
         if (piece(i) == 0) cycle
         if (piece(i) == i) then
            pieces = pieces + 1
            number(i) = pieces
         end if
         piece(i) = number(piece(i))
      end do
   end subroutine find_pieces

   !> Whether two pieces, in the order of their kinds, may change places.
   pure logical function are_equal(system, fixed, kind, least, one, other)
      type(system_type), intent(in) :: system
      logical, intent(in) :: fixed(:)
      integer, intent(in) :: kind(:), one(:), other(:)
      !> Static forces that differ by less are equal.
      real(dp), intent(in) :: least
      integer :: i, k, n(2), nodes

      are_equal = all(kind(one) == kind(other))
      nodes = size(fixed)
      do i = 1, size(one)
         if (.not. are_equal) return
         n = [one(i), other(i)] - nodes
         if (n(1) <= 0) cycle
         associate (a => system%network%elements(n(1))%node, b => system%network%elements(n(2))%node)
            do k = 1, size(a)
               if (fixed(a(k))) then
                  are_equal = are_equal .and. a(k) == b(k)
               else
                  are_equal = are_equal .and. findloc(one, a(k), 1) == findloc(other, b(k), 1)
               end if
            end do
         end associate
         associate (force => system%static_force(n))
            are_equal = are_equal .and. abs(force(1) - force(2)) <= least
         end associate
      end do
   end function are_equal

   !> Numbers the kinds of the nodes and elements: first by their own numbers, then by the kinds of their neighbours too.
   subroutine find_kinds(system, kind)
      type(system_type), intent(in) :: system
      integer, intent(out) :: kind(:)
      integer, allocatable :: around(:, :), ends(:, :)
      integer :: before(size(kind)), first(size(kind)), next(size(kind)), length(system%elements), i, j, kinds, last, nodes

      nodes = size(system%network%inertia)
      ! A long chain is looked round hundreds of times.
      length = [(size(system%network%elements(i)%node), i=1, system%elements)]
      allocate (ends(maxval([0, length]), system%elements), source=0)
      do i = 1, system%elements
         ends(:length(i), i) = system%network%elements(i)%node
      end do
      kind = 1
      kind(nodes + 1:) = 2
      kinds = 0
      do
         last = kinds
         before = kind
         if (last > 0) call look_around(nodes, ends, length, before, around)
         kinds = 0
         ! The first of each new kind, and the first of the next new kind that was of the same kind before; 0: none.
         first = 0
         next = 0
         do i = 1, size(kind)
            kind(i) = 0
            j = first(before(i))
            do while (j > 0)
               if (alike(i, j)) kind(i) = kind(j)
               if (kind(i) > 0 .or. next(j) == 0) exit
               j = next(j)
            end do
            if (kind(i) > 0) cycle
            kinds = kinds + 1
            kind(i) = kinds
            if (j == 0) then
               first(before(i)) = i
            else
               next(j) = i
            end if
         end do
         if (kinds == last) exit
      end do

   contains

      !> Whether two nodes, or two elements, that were of one kind are of one kind still.
      logical function alike(one, other)
         integer, intent(in) :: one, other

         if (last > 0) then
            alike = all(around(:, one) == around(:, other))
         else if (one > nodes) then
            alike = same_elements(system, one - nodes, other - nodes)
         else
            alike = same_nodes(system, one, other)
         end if
      end function alike

   end subroutine find_kinds

   !> Kinds of what touches each node and element, (neighbour, node or element): of a node the kinds of the elements there and the
   !> numbers of their entries, ascending, of an element the kinds of its nodes.
   pure subroutine look_around(nodes, ends, length, kind, around)
      !> Number of nodes; nodes of each element, (entry, element), and how many they are.
      integer, intent(in) :: nodes, ends(:, :), length(:)
      integer, intent(in) :: kind(:)
      !> Allocated by the first call.
      integer, allocatable, intent(inout) :: around(:, :)
      integer :: touching(size(kind)), i, k, most, n

      most = size(ends, 1)
      if (.not. allocated(around)) then
         touching = most
         touching(:nodes) = 0
         do n = 1, size(length)
            touching(ends(:length(n), n)) = touching(ends(:length(n), n)) + 1
         end do
         allocate (around(maxval(touching), size(kind)))
      end if
      around = 0
      touching = 0
      do n = 1, size(length)
         around(:length(n), nodes + n) = kind(ends(:length(n), n))
         do i = 1, length(n)
            associate (list => around(:, ends(i, n)), last => touching(ends(i, n)), own => most*kind(nodes + n) + i)
               k = count(list(:last) <= own)
               list(k + 2:last + 1) = list(k + 1:last)
               list(k + 1) = own
               last = last + 1
            end associate
         end do
      end do
   end subroutine look_around

   !> Whether two nodes have the same reduced mass, torques and damping, and neither balances the torques.
   pure logical function same_nodes(system, a, b)
      type(system_type), intent(in) :: system
      !> Numbers of the nodes.
      integer, intent(in) :: a, b
      real(dp) :: difference
      integer :: i

      associate (network => system%network)
         same_nodes = .false.
         if (any([(any([a, b] == network%node(network%balancing(i))), i=1, size(network%balancing))])) return
         associate (r => network%radius([a, b]))
            same_nodes = equal(network%inertia([a, b])/r**2) .and. equal(network%damping([a, b])/r**2) .and. &
                         equal(network%support([a, b])/r**2)
            difference = abs(network%torque(a)/r(1) - network%torque(b)/r(2))
            if (difference > 0) same_nodes = same_nodes .and. &
                                             difference <= rounding*maxval(abs(network%magnitude/network%radius))
            if (same_nodes) same_nodes = same_torques(r)
         end associate
      end associate

   contains

      !> Whether the fluctuating torques over the radius are the same.
      pure logical function same_torques(r)
         real(dp), intent(in) :: r(2)
         complex(dp), allocatable :: amplitude(:, :)
         integer :: i, k, highest

         same_torques = .true.
         highest = 0
         do i = 1, size(system%torque)
            if (all(system%network%node(system%torque_body(i)) /= [a, b])) cycle
            if (size(system%torque(i)%harmonic) > 0) highest = max(highest, maxval(system%torque(i)%harmonic))
         end do
         if (highest == 0) return
         allocate (amplitude(highest, 2), source=(0.0_dp, 0.0_dp))
         do i = 1, size(system%torque)
            do k = 1, 2
               if (system%network%node(system%torque_body(i)) /= merge(a, b, k == 1)) cycle
               associate (h => system%torque(i)%harmonic)
                  amplitude(h, k) = amplitude(h, k) + system%torque(i)%amplitude/r(k)
               end associate
            end do
         end do
         same_torques = all(equal_amplitudes(amplitude(:, 1), amplitude(:, 2)))
      end function same_torques

   end function same_nodes

   !> Whether two elements have the same numbers. Radii count over the reduced radii of their nodes.
   pure logical function same_elements(system, a, b)
      type(system_type), intent(in) :: system
      integer, intent(in) :: a, b

      associate (one => system%network%elements(a), other => system%network%elements(b), radius => system%network%radius)
         same_elements = (one%mesh > 0 .eqv. other%mesh > 0) .and. (one%unknown .eqv. other%unknown) .and. &
            (one%elastic .eqv. other%elastic) .and. size(one%node) == size(other%node) .and. &
            equal([one%stiffness, other%stiffness]) .and. equal([one%damping, other%damping]) .and. &
            equal([one%error_mean, other%error_mean])
         if (same_elements) same_elements = all(equal_numbers(one%entry/radius(one%node), other%entry/radius(other%node)))
         if (.not. same_elements .or. one%mesh == 0) return
         same_elements = same_laws(system%law(one%mesh), system%law(other%mesh)) .and. &
            same_series(system%transmission_error(one%mesh), system%transmission_error(other%mesh))
      end associate
   end function same_elements

   pure logical function same_laws(a, b)
      type(law_type), intent(in) :: a, b

      same_laws = a%lowest == b%lowest .and. a%highest == b%highest .and. size(a%harmonic) == size(b%harmonic)
      if (.not. same_laws) return
      same_laws = all(a%harmonic == b%harmonic) .and. all(equal_numbers(a%wall, b%wall)) .and. &
                  all(equal_numbers(a%stiffness, b%stiffness)) .and. all(equal_numbers(a%origin, b%origin)) .and. &
                  all(equal_numbers(a%damping, b%damping)) .and. all(equal_amplitudes(a%amplitude, b%amplitude))
      ! Offsets follow from stiffnesses and walls.
      same_laws = same_laws .and. (allocated(a%offset) .eqv. allocated(b%offset))
   end function same_laws

   pure logical function same_series(a, b)
      type(series_type), intent(in) :: a, b

      same_series = size(a%harmonic) == size(b%harmonic)
      if (same_series) same_series = all(a%harmonic == b%harmonic)
      if (same_series) same_series = all(equal_amplitudes(a%amplitude, b%amplitude))
   end function same_series

   pure logical function equal(pair)
      real(dp), intent(in) :: pair(2)

      equal = equal_numbers(pair(1), pair(2))
   end function equal

   elemental logical function equal_numbers(a, b)
      real(dp), intent(in) :: a, b

      equal_numbers = abs(a - b) <= rounding*max(abs(a), abs(b))
   end function equal_numbers

   elemental logical function equal_amplitudes(a, b)
      complex(dp), intent(in) :: a, b

      equal_amplitudes = abs(a - b) <= rounding*max(abs(a), abs(b))
   end function equal_amplitudes

end module geartrain_network_equal_branches
