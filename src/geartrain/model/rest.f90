!> The network at rest under its mean torques: the force of each shaft and each mesh.
!>
!> An element without load, or between torques that cancel, has a force of exactly 0: a force by rounding would count as a load
!> beside which every other force is large.
module geartrain_model_rest
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
   use geartrain_mesh_law_law, only: law_type
   use geartrain_model_network, only: element_type, network_type
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
      !> The network.
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
      type(element_type) :: elements(count(.not. network%elements%grounded))
      real(dp) :: elastic(size(elements))

      elements = pack(network%elements, .not. network%elements%grounded)
      residual = 0
      associate (tree => network%displacements)
         elastic(:tree) = tree_forces(network)
         elastic(tree + 1:) = 0
         if (size(elements) > tree) &
            call share_force(network%loop(:size(elements) - tree, :tree), elements, law, length, elastic, residual)
      end associate
      force = unpack(elastic, .not. network%elements%grounded, 0.0_dp)
   end subroutine rest_forces

   !> Finds the compliance [m/N] of each element on the flank that bears its force, and the displacement at which this flank begins
   !> to bear, in the direction of the force [m], (element).
   pure subroutine find_compliance(elements, law, length, force, compliance, gap)
      type(element_type), intent(in) :: elements(:)
      type(law_type), intent(in) :: law(:)
      !> Unit of the displacements in the laws [m]; forces [N], (element).
      real(dp), intent(in) :: length, force(:)
      real(dp), intent(out) :: compliance(:), gap(:)
      integer :: n, s

      compliance = 1/elements%stiffness
      gap = 0
      do n = 1, size(elements)
         if (elements(n)%mesh == 0) cycle
         associate (own => law(elements(n)%mesh))
            s = own%bearing(force(n)/(elements(n)%stiffness*length))
            compliance(n) = compliance(n)/own%stiffness(s)
            gap(n) = abs(own%origin(s))*length
         end associate
      end do
   end subroutine find_compliance

   !> Finds the forces of least complementary energy in a network with loops. The energy is the sum of F^2/(2 k) + b |F|, with |F|
   !> replaced by a smooth function that comes nearer and nearer to |F|.
   pure subroutine share_force(loop, elements, law, length, force, residual)
      real(dp), intent(in) :: loop(:, :), length
      type(element_type), intent(in) :: elements(:)
      type(law_type), intent(in) :: law(:)
      !> Forces of the tree alone, then of the network [N], (element).
      real(dp), intent(inout) :: force(:)
      real(dp), intent(out) :: residual
      real(dp), dimension(size(loop, 1)) :: misfit, change, magnitude
      real(dp) :: hessian(size(loop, 1), size(loop, 1)), taken(size(loop, 1), size(force)), smooth, step, unit
      real(dp), dimension(size(force)) :: root, least, way, compliance, gap
      integer :: pivot(size(loop, 1)), i, info, n, round

      residual = 0
      n = size(loop, 2)
      unit = maxval(abs(force))
      if (.not. unit > 0) return
      ! Force of each element per force of each closing element.
      taken = 0
      taken(:, :n) = -loop
      do i = 1, size(loop, 1)
         taken(i, n + i) = 1
      end do
      smooth = unit
      do round = 1, 16
         smooth = 0.1_dp*smooth
         do i = 1, 50
            call find_compliance(elements, law, length, force, compliance, gap)
            root = sqrt(force**2 + smooth**2)
            change = matmul(taken, force*compliance + gap*force/root)
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
      call find_compliance(elements, law, length, force, compliance, gap)
      magnitude = matmul(abs(taken), abs(force)*compliance + gap)
      unit = maxval(abs(force))
      least = 0
      do i = 1, size(loop, 1)
         where (abs(taken(i, :)) > 0) least = max(least, unit, magnitude(i)/sum(taken(i, :)**2*compliance))
      end do
      where (abs(force) <= nothing*least) force = 0
      ! An unloaded mesh may stand anywhere in its gap.
      misfit = abs(matmul(taken, force*compliance + sign(gap, force)*merge(1, 0, abs(force) > 0))) &
               - matmul(abs(taken), merge(0.0_dp, gap, abs(force) > 0))
      ! A path without backlash that bears nothing has no magnitude.
      residual = max(0.0_dp, maxval(misfit/max(magnitude, tiny(unit))))

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
         real(dp), dimension(size(force)) :: there, soft, free

         there = force + share*way
         call find_compliance(elements, law, length, there, soft, free)
         slope = sum(way*(there*soft + free*there/sqrt(there**2 + smooth**2)))
      end function slope

   end subroutine share_force

   !> Mean forces of the elements of the tree [N], (displacement): a node with a single open element gives the force of this
   !> element.
   pure function tree_forces(network) result(force)
      type(network_type), intent(in) :: network
      real(dp) :: force(network%displacements), torque(size(network%torque)), magnitude(size(network%torque)), ratio
      integer :: open_elements(size(network%torque)), waiting(size(network%torque)), n, other, last
      logical :: done(size(force))

      torque = network%torque
      magnitude = network%magnitude
      force = 0
      done = .false.
      open_elements = 0
      do n = 1, size(force)
         associate (element => network%elements(n))
            open_elements([element%from, element%to]) = open_elements([element%from, element%to]) + 1
         end associate
      end do
      last = 0
      do n = 1, size(torque)
         if (open_elements(n) /= 1 .or. n == network%balancing) cycle
         last = last + 1
         waiting(last) = n
      end do
      do while (last > 0)
         associate (body => waiting(last))
            if (abs(torque(body)) <= 4*size(torque)*epsilon(1.0_dp)*magnitude(body)) torque(body) = 0
            do n = 1, size(force)
               if (.not. done(n) .and. any([network%elements(n)%from, network%elements(n)%to] == body)) exit
            end do
            associate (element => network%elements(n))
               if (element%from == body) then
                  other = element%to
                  ratio = element%radius(2)/element%radius(1)
                  force(n) = torque(body)/element%radius(1)
                  torque(other) = torque(other) + force(n)*element%radius(2)
               else
                  other = element%from
                  ratio = element%radius(1)/element%radius(2)
                  force(n) = -torque(body)/element%radius(2)
                  torque(other) = torque(other) - force(n)*element%radius(1)
               end if
               magnitude(other) = magnitude(other) + ratio*magnitude(body)
            end associate
         end associate
         done(n) = .true.
         open_elements(other) = open_elements(other) - 1
         if (open_elements(other) == 1 .and. other /= network%balancing) then
            waiting(last) = other
         else
            last = last - 1
         end if
      end do
   end function tree_forces

end module geartrain_model_rest
