!> Derivatives of the network of a train with respect to a parameter: of nodes, elements and loops.
module geartrain_model_network_rate
   use geartrain_base_kinds, only: dp
   use geartrain_model_bodies, only: bodies_of, body_count, find_ends
   use geartrain_model_network, only: base_radius, measuring_gear, network_type, vibrating
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: network_rate_type, find_network_rate, shifted

   type :: network_rate_type
      !> Of inertia [kg m^2], mean torque [N m], damping to ground [N m s/rad], and of the logarithm of the reduced radius, (node).
      real(dp), allocatable :: inertia(:), torque(:), damping(:), radius(:)
      !> Of inertia over reduced radius squared [kg] and damping to ground over reduced radius squared [N s/m], (node).
      real(dp), allocatable :: mass(:), drag(:)
      !> Of the radii [m], (2, element); of stiffness [N/m] and damping [N s/m]; of the logarithm of the displacement over the
      !> difference of the reduced displacements x, (element).
      real(dp), allocatable :: element_radius(:, :), stiffness(:), element_damping(:), gain(:)
      !> Of the loop matrix.
      real(dp), allocatable :: loop(:, :)
      !> The ratios round a loop would not multiply to 1 any more: the gears would lock.
      logical :: locks = .false.
      !> Largest relative rate of anything.
      real(dp) :: fastest = 0
      !> The two bodies of each shaft, (2, shaft), and of each mesh, (2, mesh).
      integer, allocatable, private :: shaft_ends(:, :), mesh_ends(:, :)
   end type network_rate_type

contains

   !> Finds the derivatives.
   pure subroutine find_network_rate(train, rate, network, d)
      !> A plain train; the derivatives of its numbers.
      type(train_type), intent(in) :: train, rate
      !> Network of the train.
      type(network_type), intent(in) :: network
      !> The derivatives [1/unit of the parameter]; of the same network from call to call.
      type(network_rate_type), intent(inout) :: d
      real(dp), dimension(body_count(train)) :: inertia, d_inertia, torque, d_torque
      real(dp) :: middle, d_middle, own(2), d_own(2)
      integer :: balancing, b, n

      call bodies_of(train, inertia, torque, balancing)
      call bodies_of(rate, d_inertia, d_torque, balancing)
      if (.not. allocated(d%inertia)) call begin(train, network, d)
      d%inertia = 0
      d%torque = 0
      d%damping = 0
      d%element_radius = 0
      d%stiffness = 0
      d%element_damping = 0
      do b = 1, size(inertia)
         associate (node => network%node(b))
            d%inertia(node) = d%inertia(node) + d_inertia(b)
            d%torque(node) = d%torque(node) + d_torque(b)
            if (allocated(rate%bodies)) d%damping(node) = d%damping(node) + rate%bodies(b)%damping_to_ground
         end associate
      end do
      do n = 1, size(network%elements)
         associate (element => network%elements(n), ends => [network%elements(n)%from, network%elements(n)%to], &
                    c => network%elements(n)%damping, dr => d%element_radius(:, n), dk => d%stiffness(n), &
                    dc => d%element_damping(n))
            if (element%shaft > 0) then
               associate (shaft => train%shafts(element%shaft), d_shaft => rate%shafts(element%shaft))
                  dr = base_radius(rate, measuring_gear(network%node, d%mesh_ends, ends))
                  dk = d_shaft%stiffness/element%radius(1)**2
                  ! Twice the root of stiffness times equivalent inertia is damping over damping ratio.
                  own = vibrating(network, inertia, d%shaft_ends(:, element%shaft), allocated(train%bodies))
                  d_own = rate_of(d%shaft_ends(:, element%shaft), allocated(train%bodies))
                  middle = sum(1/own)
                  d_middle = -sum(d_own/own**2)
                  dc = 2*d_shaft%damping_ratio*sqrt(shaft%stiffness/middle)/element%radius(1)**2 &
                       + 0.5_dp*c*(d_shaft%stiffness/shaft%stiffness - d_middle/middle)
                  if (shaft%damping_given) dc = d_shaft%damping/element%radius(1)**2
                  dk = dk - 2*element%stiffness*dr(1)/element%radius(1)
                  dc = dc - 2*c*dr(1)/element%radius(1)
               end associate
            else if (element%mesh > 0) then
               associate (mesh => train%meshes(element%mesh), d_mesh => rate%meshes(element%mesh))
                  own = vibrating(network, inertia, d%mesh_ends(:, element%mesh), .true.)
                  d_own = rate_of(d%mesh_ends(:, element%mesh), .true.)
                  dr = [d_mesh%driving_radius, d_mesh%driven_radius]
                  dk = d_mesh%stiffness
                  middle = sum(element%radius**2/own)
                  d_middle = sum(2*element%radius*dr/own - element%radius**2*d_own/own**2)
                  dc = 2*d_mesh%damping_ratio*sqrt(mesh%stiffness/middle) + 0.5_dp*c*(dk/mesh%stiffness - d_middle/middle)
                  if (mesh%damping_given) dc = d_mesh%damping
               end associate
            end if
         end associate
      end do
      call find_radii(network, d)
      call find_gains(network, d)
      d%mass = d%inertia/network%radius**2 - 2*network%inertia/network%radius**2*d%radius
      d%drag = d%damping/network%radius**2 - 2*network%damping/network%radius**2*d%radius
      associate (elements => network%elements)
         d%fastest = max(maxval(abs(d%radius)), maxval(abs(d%inertia)/network%inertia), &
                         maxval(abs(d%torque))/merge(maxval(abs(network%torque)), 1.0_dp, any(abs(network%torque) > 0)))
         do n = 1, size(elements)
            d%fastest = max(d%fastest, abs(d%stiffness(n))/elements(n)%stiffness)
            if (elements(n)%damping > 0) d%fastest = max(d%fastest, abs(d%element_damping(n))/elements(n)%damping)
         end do
      end associate

   contains

      !> Of what `vibrating` gives.
      pure function rate_of(bodies, own)
         integer, intent(in) :: bodies(2)
         logical, intent(in) :: own
         real(dp) :: rate_of(2)

         rate_of = d%inertia(network%node(bodies))
         if (own) rate_of = merge(d_inertia(bodies), rate_of, inertia(bodies) > 0)
      end function rate_of

   end subroutine find_network_rate

   !> Makes room.
   pure subroutine begin(train, network, d)
      type(train_type), intent(in) :: train
      type(network_type), intent(in) :: network
      type(network_rate_type), intent(inout) :: d

      call find_ends(train, d%shaft_ends, d%mesh_ends)
      allocate (d%inertia, d%torque, d%damping, d%radius, d%mass, d%drag, mold=network%inertia)
      associate (n => size(network%elements))
         allocate (d%element_radius(2, n), d%stiffness(n), d%element_damping(n), d%gain(n))
      end associate
      d%radius = 0
      d%gain = 0
      d%loop = network%loop
   end subroutine begin

   !> Reduced radii, as `build_network` finds them.
   pure subroutine find_radii(network, d)
      type(network_type), intent(in) :: network
      type(network_rate_type), intent(inout) :: d
      logical :: known(size(d%radius))
      real(dp) :: ratio
      integer :: n

      known = .false.
      associate (first => network%elements(1))
         d%radius(first%from) = d%element_radius(1, 1)/first%radius(1)
         known(first%from) = .true.
      end associate
      do n = 1, network%displacements
         associate (element => network%elements(n))
            ratio = d%element_radius(2, n)/element%radius(2) - d%element_radius(1, n)/element%radius(1)
            if (known(element%from)) then
               d%radius(element%to) = d%radius(element%from) + ratio
            else
               d%radius(element%from) = d%radius(element%to) - ratio
            end if
            known([element%from, element%to]) = .true.
         end associate
      end do
   end subroutine find_radii

   !> Gains of the elements, the loop matrix, whether gears lock; damping to ground as an element.
   pure subroutine find_gains(network, d)
      type(network_type), intent(in) :: network
      type(network_rate_type), intent(inout) :: d
      real(dp) :: other
      integer :: i, n

      d%locks = .false.
      do n = 1, size(network%elements)
         associate (element => network%elements(n))
            if (element%grounded) then
               d%element_radius(1, n) = element%radius(1)*d%radius(element%from)
               d%element_damping(n) = d%damping(element%from)/element%radius(1)**2 - 2*element%damping*d%radius(element%from)
               d%stiffness(n) = d%stiffness(1)
               cycle
            end if
            d%gain(n) = d%element_radius(1, n)/element%radius(1) - d%radius(element%from)
            other = d%element_radius(2, n)/element%radius(2) - d%radius(element%to)
            if (abs(d%gain(n) - other) > 1e-9_dp*maxval(abs(d%radius))) d%locks = .true.
         end associate
      end do
      do i = 1, size(d%loop, 1)
         d%loop(i, :) = network%loop(i, :)*(d%gain(network%coordinates + i) - d%gain(:network%coordinates))
      end do
   end subroutine find_gains

   !> The network with the parameter changed, to first order.
   pure function shifted(network, d, step) result(changed)
      !> The network.
      type(network_type), intent(in) :: network
      !> Its derivatives.
      type(network_rate_type), intent(in) :: d
      !> Change of the parameter.
      real(dp), intent(in) :: step
      type(network_type) :: changed

      changed = network
      changed%inertia = network%inertia + step*d%inertia
      changed%torque = network%torque + step*d%torque
      changed%damping = network%damping + step*d%damping
      changed%radius = network%radius*(1 + step*d%radius)
      changed%loop = network%loop + step*d%loop
      changed%elements%radius(1) = network%elements%radius(1) + step*d%element_radius(1, :)
      changed%elements%radius(2) = network%elements%radius(2) + step*d%element_radius(2, :)
      changed%elements%stiffness = network%elements%stiffness + step*d%stiffness
      changed%elements%damping = network%elements%damping + step*d%element_damping
   end function shifted

end module geartrain_model_network_rate
