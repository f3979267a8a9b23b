!> Kinds of the nodes and elements of a network. Two of one kind have equal numbers, and neighbours of the same kinds. What may
!> change places without a change of the train is of one kind.
module geartrain_network_node_kinds
   use geartrain_base_kinds, only: dp
   use geartrain_base_series, only: series_type
   use geartrain_mesh_law_law, only: law_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: find_kinds, same_nodes

   !> Relative difference of two numbers that are equal but for rounding.
   real(dp), parameter :: rounding = 1e-12_dp

   !> What touches each node and element; elements come after the nodes.
   type :: neighbours_type
      !> Number of nodes; most neighbours of a node or element.
      integer :: nodes = 0, most = 0
      !> Neighbours of i: item(first(i):first(i + 1) - 1); of a node with the number of its entry in the element.
      integer, allocatable :: first(:), item(:), entry(:)
   contains
      procedure :: setup
      procedure :: look_around
   end type neighbours_type

contains

   !> Numbers the kinds of the nodes and elements: first by their own numbers, then by the kinds of their neighbours too. A kind is
   !> parted where some of its members have other neighbours than the rest, and then the neighbours of these are looked at: along a
   !> chain a few at a time, from its ends.
   subroutine find_kinds(system, kind)
      type(system_type), intent(in) :: system
      !> Kind of each node, then of each element, in the order of their first members.
      integer, intent(out) :: kind(:)
      type(neighbours_type) :: neighbours
      !> Kinds around each node and element when it was looked at last; around those that are looked at now.
      integer, allocatable :: around(:, :), fresh(:, :)
      integer, dimension(size(kind)) :: changed, first, looked, members, next, seen, see
      integer :: c, i, j, k, kinds, last, looks, round

      call neighbours%setup(system)
      call find_own_kinds(system, kind, kinds)
      allocate (around(neighbours%most, size(kind)), fresh(neighbours%most, size(kind)), source=0)
      members = 0
      do i = 1, size(kind)
         members(kind(i)) = members(kind(i)) + 1
      end do
      looks = size(kind)
      see = [(i, i=1, looks)]
      seen = 0
      looked = 0
      first = 0
      round = 0
      do while (looks > 0)
         do k = 1, looks
            call neighbours%look_around(see(k), kind, fresh(:, k))
            looked(kind(see(k))) = looked(kind(see(k))) + 1
         end do
         do k = 1, looks
            i = see(k)
            c = kind(i)
            changed(k) = c
            ! Members that are not looked at have the neighbours that all had before.
            if (looked(c) < members(c)) then
               if (all(fresh(:, k) == around(:, i))) cycle
            end if
            ! Groups with the same neighbours now, each known by its first member: j is that of the own group, 0: there is none.
            last = 0
            j = first(c)
            do while (j > 0)
               if (all(fresh(:, j) == fresh(:, k))) exit
               last = j
               j = next(j)
            end do
            if (j > 0) then
               changed(k) = changed(j)
               cycle
            end if
            next(k) = 0
            if (last > 0) next(last) = k
            if (last == 0) first(c) = k
            ! The first group stays of the kind where none else does.
            if (last == 0 .and. looked(c) == members(c)) cycle
            kinds = kinds + 1
            changed(k) = kinds
         end do
         looked(kind(see(:looks))) = 0
         first(kind(see(:looks))) = 0
         last = 0
         do k = 1, looks
            i = see(k)
            around(:, i) = fresh(:, k)
            if (changed(k) == kind(i)) cycle
            members(kind(i)) = members(kind(i)) - 1
            members(changed(k)) = members(changed(k)) + 1
            kind(i) = changed(k)
            last = last + 1
            changed(last) = i
         end do
         round = round + 1
         looks = 0
         do k = 1, last
            do j = neighbours%first(changed(k)), neighbours%first(changed(k) + 1) - 1
               i = neighbours%item(j)
               if (seen(i) == round) cycle
               seen(i) = round
               looks = looks + 1
               see(looks) = i
            end do
         end do
      end do
      call number_by_first(kind)
   end subroutine find_kinds

   !> Numbers the kinds in the order of their first members.
   pure subroutine number_by_first(kind)
      integer, intent(inout) :: kind(:)
      integer :: number(size(kind)), i, kinds

      number = 0
      kinds = 0
      do i = 1, size(kind)
         if (number(kind(i)) == 0) then
            kinds = kinds + 1
            number(kind(i)) = kinds
         end if
         kind(i) = number(kind(i))
      end do
   end subroutine number_by_first

   !> Numbers the kinds by the numbers of the nodes and of the elements alone.
   subroutine find_own_kinds(system, kind, kinds)
      type(system_type), intent(in) :: system
      integer, intent(out) :: kind(:), kinds
      integer :: one(size(kind)), i, k, nodes

      nodes = size(system%network%inertia)
      kinds = 0
      do i = 1, size(kind)
         do k = 1, kinds
            if ((one(k) > nodes) .neqv. (i > nodes)) cycle
            if (i > nodes) then
               if (same_elements(system, i - nodes, one(k) - nodes)) exit
            else
               if (same_nodes(system, i, one(k))) exit
            end if
         end do
         kind(i) = k
         if (k <= kinds) cycle
         kinds = k
         one(k) = i
      end do
   end subroutine find_own_kinds

   !> Lists the neighbours.
   pure subroutine setup(self, system)
      class(neighbours_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer, allocatable :: next(:)
      integer :: i, n

      associate (elements => system%network%elements)
         self%nodes = size(system%network%inertia)
         allocate (self%first(self%nodes + size(elements) + 1), source=0)
         do n = 1, size(elements)
            associate (node => elements(n)%node)
               self%first(node + 1) = self%first(node + 1) + 1
               self%first(self%nodes + n + 1) = size(node)
            end associate
         end do
         self%most = maxval(self%first)
         self%first(1) = 1
         do i = 2, size(self%first)
            self%first(i) = self%first(i - 1) + self%first(i)
         end do
         allocate (self%item(self%first(size(self%first)) - 1), self%entry(self%first(self%nodes + 1) - 1))
         next = self%first
         do n = 1, size(elements)
            do i = 1, size(elements(n)%node)
               associate (node => elements(n)%node(i))
                  self%item(next(node)) = self%nodes + n
                  self%entry(next(node)) = i
                  next(node) = next(node) + 1
                  self%item(self%first(self%nodes + n) + i - 1) = node
               end associate
            end do
         end do
      end associate
   end subroutine setup

   !> Kinds of the neighbours: of a node of the elements there, with the numbers of its entries, ascending; of an element of its
   !> nodes in their order.
   pure subroutine look_around(self, i, kind, around)
      class(neighbours_type), intent(in) :: self
      !> Number of the node, or of the element after the nodes.
      integer, intent(in) :: i
      !> Kind of each node, then of each element.
      integer, intent(in) :: kind(:)
      !> 0 behind the last.
      integer, intent(out) :: around(:)
      integer :: k, n, own

      around = 0
      associate (item => self%item(self%first(i):self%first(i + 1) - 1))
         if (i > self%nodes) then
            around(:size(item)) = kind(item)
            return
         end if
         do n = 1, size(item)
            own = self%most*kind(item(n)) + self%entry(self%first(i) + n - 1)
            do k = n, 2, -1
               if (around(k - 1) <= own) exit
               around(k) = around(k - 1)
            end do
            around(k) = own
         end do
      end associate
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

end module geartrain_network_node_kinds
