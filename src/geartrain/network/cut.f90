!> A network cut at its unknown meshes: the free linear parts that remain, and the graph of the unknowns that share a part.
module geartrain_network_cut
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_graph, only: graph_type
   use geartrain_network_network, only: network_type
   use geartrain_network_part, only: part_type
   implicit none (type, external)
   private
   public :: cut_type, cut_network

   type :: cut_type
      !> Number of unknown meshes.
      integer :: unknowns = 0
      !> Mesh and element of the network of each unknown, (unknown); whether an element is an unknown mesh, (element).
      integer, allocatable :: mesh(:), element(:)
      logical, allocatable :: is_unknown(:)
      !> Nodes are the unknowns; two are coupled where they touch one part, or where the mean of one depends on the other.
      type(graph_type) :: graph
      !> The free linear parts.
      type(part_type), allocatable :: part(:)
      !> Part of each node of the network, and number of its mass in the part, (node).
      integer, allocatable :: home(:), mass(:)
      !> Slot of each element in the graph of its part, 0 for unknown meshes; displacement of the element over difference of the two
      !> masses of the slot [1], (element).
      integer, allocatable :: slot(:)
      real(dp), allocatable :: scale(:)
   end type cut_type

contains

   !> Cuts a network at its unknown meshes.
   pure subroutine cut_network(network, cut)
      !> Network of a train.
      type(network_type), intent(in) :: network
      !> The parts and the graph of the unknowns.
      type(cut_type), intent(out) :: cut
      integer :: i, n

      cut%is_unknown = network%elements%unknown
      ! The unknowns are in the order of the meshes, not of the elements.
      cut%element = pack([(n, n=1, size(cut%is_unknown))], cut%is_unknown)
      cut%mesh = [(network%elements(cut%element(n))%mesh, n=1, size(cut%element))]
      cut%unknowns = size(cut%mesh)
      call sort_by_mesh(cut%mesh, cut%element)
      call find_parts(network, cut)
      do i = 1, cut%unknowns
         do n = 1, size(network%elements(cut%element(i))%node)
            call add_port(network, cut, i, n)
         end do
      end do
      call join_unknowns(network, cut)
   end subroutine cut_network

   !> Adds the port of an entry of an unknown mesh to the part of its node.
   pure subroutine add_port(network, cut, unknown, i)
      type(network_type), intent(in) :: network
      type(cut_type), intent(inout) :: cut
      integer, intent(in) :: unknown, i

      associate (element => network%elements(cut%element(unknown)), node => network%elements(cut%element(unknown))%node(i))
         associate (part => cut%part(cut%home(node)))
            part%at = [part%at, cut%mass(node)]
            part%weight = [part%weight, element%entry(i)/network%radius(node)]
            part%unknown = [part%unknown, unknown]
         end associate
      end associate
   end subroutine add_port

   pure subroutine sort_by_mesh(mesh, element)
      integer, intent(inout) :: mesh(:), element(:)
      integer :: i, j, held(2)

      do i = 2, size(mesh)
         held = [mesh(i), element(i)]
         do j = i - 1, 1, -1
            if (mesh(j) < held(1)) exit
            mesh(j + 1) = mesh(j)
            element(j + 1) = element(j)
         end do
         mesh(j + 1) = held(1)
         element(j + 1) = held(2)
      end do
   end subroutine sort_by_mesh

   !> Makes the parts, numbered in the order of their first nodes.
   pure subroutine find_parts(network, cut)
      type(network_type), intent(in) :: network
      type(cut_type), intent(inout) :: cut
      integer :: root(size(network%inertia)), ends(2, size(network%elements)), &
                 masses(2, size(network%elements)), bodies, b, n, p, parts
      integer, allocatable :: body(:), inside(:)
      real(dp), allocatable :: drag(:), support(:)

      bodies = size(network%inertia)
      root = [(b, b=1, bodies)]
      do n = 1, size(network%elements)
         ! An element to ground joins its node with itself.
         associate (node => network%elements(n)%node)
            ends(:, n) = [node(1), node(size(node))]
         end associate
         if (.not. cut%is_unknown(n)) where (root == root(ends(2, n))) root = root(ends(1, n))
      end do
      allocate (cut%home(bodies), cut%mass(bodies), source=0)
      allocate (cut%slot(size(network%elements)), source=0)
      allocate (cut%scale(size(network%elements)), source=0.0_dp)
      parts = 0
      do b = 1, bodies
         if (cut%home(b) > 0) cycle
         parts = parts + 1
         where (root == root(b)) cut%home = parts
      end do
      allocate (cut%part(parts))
      do p = 1, parts
         body = pack([(b, b=1, bodies)], cut%home == p)
         cut%mass(body) = [(b, b=1, size(body))]
         masses(1, :) = cut%mass(ends(1, :))
         masses(2, :) = cut%mass(ends(2, :))
         inside = pack([(n, n=1, size(cut%slot))], .not. cut%is_unknown .and. cut%home(ends(1, :)) == p)
         do n = 1, size(inside)
            associate (element => network%elements(inside(n)))
               cut%scale(inside(n)) = element%entry(1)/network%radius(element%node(1))
            end associate
         end do
         associate (part => cut%part(p), element => network%elements)
            part%ground_element = pack(inside, ends(1, inside) == ends(2, inside))
            inside = pack(inside, ends(1, inside) /= ends(2, inside))
            drag = [(0.0_dp, b=1, size(body))]
            support = drag
            do n = 1, size(part%ground_element)
               associate (own => part%ground_element(n), mass => masses(1, part%ground_element(n)))
                  drag(mass) = drag(mass) + cut%scale(own)**2*element(own)%damping
                  if (element(own)%elastic) support(mass) = support(mass) + cut%scale(own)**2*element(own)%stiffness
               end associate
            end do
            call part%setup(body, network%inertia(body)/network%radius(body)**2, drag, support, masses(:, inside), &
                            cut%scale(inside)**2*element(inside)%stiffness, cut%scale(inside)**2*element(inside)%damping)
            part%element = inside
            part%at = [integer ::]
            part%weight = [real(dp) ::]
            part%unknown = [integer ::]
         end associate
         do n = 1, size(inside)
            call find_slot(cut%part(p)%graph, cut%mass(ends(1, inside(n))), cut%mass(ends(2, inside(n))), &
                           cut%slot(inside(n)), cut%scale(inside(n)))
         end do
      end do
   end subroutine find_parts

   !> Finds the slot of two masses; `scale` changes its sign where the mass `to` is eliminated before the mass `from`.
   pure subroutine find_slot(graph, from, to, slot, scale)
      type(graph_type), intent(in) :: graph
      integer, intent(in) :: from, to
      integer, intent(out) :: slot
      real(dp), intent(inout) :: scale

      slot = graph%entry_of(from, to) - graph%nodes
      if (slot <= graph%slots) return
      slot = slot - graph%slots
      scale = -scale
   end subroutine find_slot

   !> Makes the graph of the unknowns: all unknowns at one part are coupled.
   pure subroutine join_unknowns(network, cut)
      type(network_type), intent(in) :: network
      type(cut_type), intent(inout) :: cut
      integer, allocatable :: pairs(:, :)
      integer :: i, j, n, p

      allocate (pairs(2, sum([(size(cut%part(p)%at)**2, p=1, size(cut%part))]) + count(closes(cut%element))*cut%unknowns))
      n = 0
      ! The mean equation of a mesh that closes a loop has the other unknowns of the loop (geartrain_network_mean).
      do i = 1, cut%unknowns
         if (.not. closes(cut%element(i))) cycle
         do j = 1, cut%unknowns
            if (.not. closes(cut%element(j))) then
               if (.not. abs(network%loop(cut%element(i) - network%coordinates, cut%element(j))) > 0) cycle
            end if
            n = n + 1
            pairs(:, n) = [i, j]
         end do
      end do
      do p = 1, size(cut%part)
         associate (unknown => cut%part(p)%unknown)
            do i = 1, size(unknown)
               do j = 1, size(unknown)
                  n = n + 1
                  pairs(:, n) = [unknown(i), unknown(j)]
               end do
            end do
         end associate
      end do
      call cut%graph%setup(cut%unknowns, pairs(:, :n))
      do p = 1, size(cut%part)
         associate (part => cut%part(p))
            allocate (part%entry(size(part%unknown), size(part%unknown)), part%gain(size(part%unknown), size(part%unknown)))
            do i = 1, size(part%unknown)
               do j = 1, size(part%unknown)
                  part%entry(i, j) = cut%graph%entry_of(part%unknown(i), part%unknown(j))
                  part%gain(i, j) = part%weight(i)*part%weight(j)*network%elements(cut%element(part%unknown(j)))%stiffness
               end do
            end do
         end associate
      end do

   contains

      elemental logical function closes(element)
         integer, intent(in) :: element

         closes = element > network%coordinates
      end function closes

   end subroutine join_unknowns

end module geartrain_network_cut
