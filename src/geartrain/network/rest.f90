!> The network at rest under its mean torques: the force of each shaft and each mesh.
!>
!> An element without load, or between torques that cancel, has a force of exactly 0: a force by rounding would count as a load
!> beside which every other force is large.
module geartrain_network_rest
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
   use geartrain_mesh_law_law, only: law_type
   use geartrain_network_elements, only: element_type
   use geartrain_network_network, only: network_type
   implicit none (type, external)
   private
   public :: rest_forces, largest_residual

   !> Largest misfit of the displacements round a loop over the sum of their magnitudes that counts as rounding [1].
   real(dp), parameter :: largest_residual = 1e-10_dp
   !> Largest force of an element of a loop that counts as rounding, over the largest force or the force that closes the gaps of the
   !> loop [1].
   real(dp), parameter :: nothing = 1e-13_dp

contains

   !> Computes the forces of the elements at rest.
   pure subroutine rest_forces(network, law, length, force, residual)
      type(network_type), intent(in) :: network
      !> Force law of each mesh, (mesh).
      type(law_type), intent(in) :: law(:)
      !> Unit of the displacements in the laws, b_c [m].
      real(dp), intent(in) :: length
      !> Force of each element [N], (element); 0 for damping to ground.
      real(dp), intent(out) :: force(:)
      !> Largest misfit of the displacements round a loop, beyond the gaps of unloaded meshes, over the sum of their magnitudes [1].
      !> The forces are valid where it is below `largest_residual`.
      real(dp), intent(out) :: residual
      integer, allocatable :: elastic(:)
      real(dp), allocatable :: own(:)
      !> gfortran 12 does not free the copies of an argument with a vector subscript.
      type(element_type), allocatable :: elements(:)
      integer :: n

      elastic = pack([(n, n=1, size(force))], network%elements%elastic)
      residual = 0
      force = 0
      associate (tree => network%displacements)
         force(:tree) = tree_forces(network)
         if (size(elastic) == tree) return
         own = force(elastic)
         elements = network%elements(elastic)
         call share_force(network%loop(:size(elastic) - tree, :tree), network%misfit(:size(elastic) - tree), &
                          elements, law, length, own, residual)
         force(elastic) = own
      end associate
   end subroutine rest_forces

   !> Finds the compliance [m/N] of each element on the flank that bears its force, and the displacement at which this flank begins
   !> to bear, in the direction of the force [m], (element). Where the law has stages, the line of the stage that bears the force
   !> begins elsewhere: further by `apart` [m], (element).
   pure subroutine find_compliance(elements, law, length, force, compliance, gap, apart)
      type(element_type), intent(in) :: elements(:)
      type(law_type), intent(in) :: law(:)
      !> Unit of the displacements in the laws [m]; forces [N], (element).
      real(dp), intent(in) :: length, force(:)
      real(dp), intent(out) :: compliance(:), gap(:), apart(:)
      integer :: n, s

      compliance = 1/elements%stiffness
      gap = 0
      apart = 0
      do n = 1, size(elements)
         if (elements(n)%mesh == 0) cycle
         associate (own => law(elements(n)%mesh))
            s = own%bearing(force(n)/(elements(n)%stiffness*length))
            compliance(n) = compliance(n)/own%stiffness(s)
            if (own%lowest < 0) gap(n) = own%wall(0)*length
            apart(n) = own%origin(s)*length - merge(-gap(n), gap(n), force(n) < 0)
         end associate
      end do
   end subroutine find_compliance

   !> Finds the forces of least complementary energy in a network with loops. The energy is the sum of F^2/(2 k) + b |F| over all
   !> elements, less the sum of F times misfit over the elements that close loops, with |F| replaced by a smooth function that comes
   !> nearer and nearer to |F|; the energy of stages is convex as well, since a force has one displacement.
   pure subroutine share_force(loop, misfit, elements, law, length, force, residual)
      real(dp), intent(in) :: loop(:, :), length
      !> By constant errors [m], (loop).
      real(dp), intent(in) :: misfit(:)
      type(element_type), intent(in) :: elements(:)
      type(law_type), intent(in) :: law(:)
      !> Forces of the tree alone, then of the network [N], (element).
      real(dp), intent(inout) :: force(:)
      real(dp), intent(out) :: residual
      real(dp), dimension(size(loop, 1)) :: gaping, change, magnitude
      real(dp) :: hessian(size(loop, 1), size(loop, 1)), taken(size(loop, 1), size(force)), smooth, step, unit
      real(dp), dimension(size(force)) :: root, least, way, compliance, gap, apart
      integer :: pivot(size(loop, 1)), i, info, n, round

      residual = 0
      n = size(loop, 2)
      ! Force of each element per force of each closing element.
      taken = 0
      taken(:, :n) = -loop
      do i = 1, size(loop, 1)
         taken(i, n + i) = 1
      end do
      ! Without torques the errors of linear elements alone make forces.
      call find_compliance(elements, law, length, force, compliance, gap, apart)
      unit = max(maxval(abs(force)), maxval(abs(misfit)/matmul(taken**2, compliance)))
      if (.not. unit > 0) return
      smooth = unit
      do round = 1, 16
         smooth = 0.1_dp*smooth
         do i = 1, 50
            call find_compliance(elements, law, length, force, compliance, gap, apart)
            root = sqrt(force**2 + smooth**2)
            change = matmul(taken, force*compliance + apart + gap*force/root) - misfit
            hessian = matmul(taken*spread(compliance + gap*smooth**2/root**3, 1, size(loop, 1)), transpose(taken))
            call factor_matrix(size(change), hessian, pivot, info)
            if (info /= 0) exit
            call solve_factored(size(change), 1, hessian, pivot, change)
            way = -matmul(change, taken)
            step = length_of()
            force = force + step*way
            if (maxval(abs(step*way)) < 1e-3_dp*smooth) exit
         end do
      end do
      call find_compliance(elements, law, length, force, compliance, gap, apart)
      magnitude = matmul(abs(taken), abs(force)*compliance + gap + abs(apart)) + abs(misfit)
      unit = maxval(abs(force))
      least = 0
      do i = 1, size(loop, 1)
         where (abs(taken(i, :)) > 0) least = max(least, unit, magnitude(i)/sum(taken(i, :)**2*compliance))
      end do
      where (abs(force) <= nothing*least) force = 0
      ! An unloaded mesh may stand anywhere in its gap.
      gaping = abs(matmul(taken, force*compliance + apart + sign(gap, force)*merge(1, 0, abs(force) > 0)) - misfit) &
               - matmul(abs(taken), merge(0.0_dp, gap, abs(force) > 0))
      ! A path without backlash that bears nothing has no magnitude.
      residual = max(0.0_dp, maxval(gaping/max(magnitude, tiny(unit))))

   contains

      !> Share of the Newton step at which the energy is least: beyond a kink of |F| a whole step may raise the energy.
      pure real(dp) function length_of() result(middle)
         real(dp) :: left, right
         integer :: k

         middle = 1
         if (.not. slope(middle) > 0) return
         left = 0
         right = 1
         do k = 1, 60
            middle = (left + right)/2
            if (slope(middle) > 0) then
               right = middle
            else
               left = middle
            end if
         end do
      end function length_of

      !> Derivative of the energy along the Newton step.
      pure real(dp) function slope(share)
         real(dp), intent(in) :: share
         real(dp), dimension(size(force)) :: there, soft, free, beyond

         there = force + share*way
         call find_compliance(elements, law, length, there, soft, free, beyond)
         slope = sum(way*(there*soft + beyond + free*there/sqrt(there**2 + smooth**2))) + sum(change*misfit)
      end function slope

   end subroutine share_force

   !> Mean forces of the independent elements [N], (displacement): a node with a single open element gives the force of this
   !> element. Elements that no such node is left for are solved for together.
   pure function tree_forces(network) result(force)
      type(network_type), intent(in) :: network
      real(dp) :: force(network%displacements), torque(size(network%torque)), magnitude(size(network%torque))
      integer :: open_elements(size(network%torque)), waiting(size(network%torque)), i, n, node, last
      logical :: done(size(force)), free(size(network%torque))

      torque = network%torque
      magnitude = network%magnitude
      force = 0
      done = .false.
      free = .true.
      free(pack(network%node(network%balancing), network%node(network%balancing) > 0)) = .false.
      open_elements = 0
      do n = 1, size(force)
         associate (nodes => network%elements(n)%node)
            open_elements(nodes) = open_elements(nodes) + 1
         end associate
      end do
      waiting(:count(free .and. open_elements == 1)) = pack([(i, i=1, size(free))], free .and. open_elements == 1)
      last = count(free .and. open_elements == 1)
      do while (last > 0)
         node = waiting(last)
         last = last - 1
         if (open_elements(node) /= 1) cycle
         if (abs(torque(node)) <= 4*size(torque)*epsilon(1.0_dp)*magnitude(node)) torque(node) = 0
         do n = 1, size(force)
            if (.not. done(n) .and. any(network%elements(n)%node == node)) exit
         end do
         done(n) = .true.
         associate (element => network%elements(n))
            force(n) = torque(node)/element%entry_at(node)
            do i = 1, size(element%node)
               associate (other => element%node(i))
                  open_elements(other) = open_elements(other) - 1
                  if (other == node) cycle
                  torque(other) = torque(other) - force(n)*element%entry(i)
                  magnitude(other) = magnitude(other) + abs(element%entry(i)/element%entry_at(node))*magnitude(node)
                  if (open_elements(other) /= 1 .or. .not. free(other)) cycle
                  last = last + 1
                  waiting(last) = other
               end associate
            end do
         end associate
         free(node) = .false.
      end do
      if (.not. all(done)) call solve_rest(network, done, free .and. open_elements > 0, torque, magnitude, force)
   end function tree_forces

   !> Solves for the forces of the elements that are left; below the rounding of the torques they are 0.
   pure subroutine solve_rest(network, done, free, torque, magnitude, force)
      type(network_type), intent(in) :: network
      !> Elements whose forces are known; nodes whose torques are used.
      logical, intent(in) :: done(:), free(:)
      !> Torques that the elements bear [N m], and the scale of their rounding, (node).
      real(dp), intent(in) :: torque(:), magnitude(:)
      real(dp), intent(inout) :: force(:)
      real(dp) :: matrix(count(free), count(.not. done)), solved(count(free), count(free) + 1)
      integer :: nodes(count(free)), elements(count(.not. done)), pivot(count(free)), i, info, n

      ! Gears that lock, which `check_train` refuses, leave more forces than torques.
      if (size(nodes) /= size(elements)) return
      nodes = pack([(i, i=1, size(free))], free)
      elements = pack([(i, i=1, size(done))], .not. done)
      do n = 1, size(elements)
         matrix(:, n) = [(network%elements(elements(n))%entry_at(nodes(i)), i=1, size(nodes))]
      end do
      ! The inverse tells how the rounding of each torque gets into each force.
      solved = 0
      do i = 1, size(nodes)
         solved(i, i) = 1
      end do
      solved(:, size(nodes) + 1) = torque(nodes)
      call factor_matrix(size(nodes), matrix, pivot, info)
      call solve_factored(size(nodes), size(nodes) + 1, matrix, pivot, solved)
      do n = 1, size(elements)
         force(elements(n)) = solved(n, size(nodes) + 1)
         if (abs(force(elements(n))) <= 16*size(torque)*epsilon(1.0_dp)*sum(abs(solved(n, :size(nodes)))*magnitude(nodes))) &
            force(elements(n)) = 0
      end do
   end subroutine solve_rest

end module geartrain_network_rest
