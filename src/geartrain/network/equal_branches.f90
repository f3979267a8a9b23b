!> Equal branches of a train: parts of its network between the same nodes, such as the planets of a star gear or parallel meshes,
!> that may change places without a change of the dimensionless system.
!>
!> A node that is alone in its kind (geartrain_network_node_kinds) keeps its place. What is left without these nodes falls into
!> pieces, and pieces of the same kinds at the same nodes are equal branches. Within a branch the search goes on: a planet may have
!> two equal meshes.
module geartrain_network_equal_branches
   use geartrain_base_kinds, only: dp
   use geartrain_base_sorting, only: ascending
   use geartrain_network_node_kinds, only: find_kinds
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: equal_branches_type, find_equal_branches, same_branches

   !> Relative difference of two static forces that are equal but for the error of the iteration that finds them.
   real(dp), parameter :: rest_error = 1e-8_dp

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

end module geartrain_network_equal_branches
