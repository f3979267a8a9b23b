!> A train as a network, in SI units: bodies that turn as one, and the elastic elements, shafts and meshes, that join them.
!>
!> Rotations are counted positive in the sense in which a body turns when the train runs. Then all bodies turn as one where
!> theta_b = x/radius_b with one x and reduced radii; with x_b = radius_b theta_b every element is a spring between two masses.
module geartrain_model_network
   use geartrain_base_kinds, only: dp
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: network_type, element_type, build_network

   !> A shaft or a mesh: its force is F, its displacement p = radius(1) theta_from - radius(2) theta_to.
   type :: element_type
      !> Number of the shaft or of the mesh in the train; the other is 0.
      integer :: shaft = 0, mesh = 0
      !> The bodies it joins; that of the driving gear first.
      integer :: from = 0, to = 0
      !> [m]; those of a shaft are equal, any radius does.
      real(dp) :: radius(2) = 0
      !> Along the line of action, [N/m] and [N s/m].
      real(dp) :: stiffness = 0, damping = 0
   end type element_type

   type :: network_type
      !> [kg m^2] and mean torque [N m], but for the body that balances all others, (body).
      real(dp), allocatable :: inertia(:), torque(:)
      !> The body whose mean torque balances all others'.
      integer :: balancing = 0
      !> The body on which the fluctuating torque acts.
      integer :: driven = 0
      !> Reduced radii [m], (body).
      real(dp), allocatable :: radius(:)
      !> In an order in which each but the first has a body in common with one before it, and no two have both.
      type(element_type), allocatable :: elements(:)
   end type network_type

contains

   !> The network of a train that is in order: a chain of shafts and meshes.
   pure subroutine build_network(train, network)
      type(train_type), intent(in) :: train
      type(network_type), intent(out) :: network
      integer :: j, m, n, body
      type(element_type) :: element

      m = size(train%meshes)
      allocate (network%elements(m + count(.not. train%shafts%rigid)))
      allocate (network%inertia(size(network%elements) + 1), network%torque(size(network%elements) + 1), source=0.0_dp)
      n = 0
      body = 1
      network%inertia(1) = train%prime_mover_inertia
      network%torque(1) = train%input_torque
      do j = 1, m + 1
         if (.not. train%shafts(j)%rigid) then
            element = shaft_element(train, j, body)
            n = n + 1
            network%elements(n) = element
            body = body + 1
         end if
         if (j > m) exit
         associate (mesh => train%meshes(j))
            network%inertia(body) = network%inertia(body) + mesh%driving_inertia
            n = n + 1
            network%elements(n) = mesh_element(train, j, body)
            body = body + 1
            network%inertia(body) = mesh%driven_inertia
         end associate
      end do
      network%inertia(body) = network%inertia(body) + train%load_inertia
      network%driven = 1
      network%balancing = body
      call damp_shafts(train, network)
      call find_radii(network)
   end subroutine build_network

   !> Shaft j from `body` to the next.
   pure function shaft_element(train, j, body) result(element)
      type(train_type), intent(in) :: train
      integer, intent(in) :: j, body
      type(element_type) :: element

      ! The twist of a shaft is measured along the base circle of a gear on it.
      if (j <= size(train%meshes)) then
         element%radius = train%meshes(j)%driving_radius
      else
         element%radius = train%meshes(j - 1)%driven_radius
      end if
      element%shaft = j
      element%from = body
      element%to = body + 1
      element%stiffness = train%shafts(j)%stiffness/element%radius(1)**2
   end function shaft_element

   !> Mesh j from `body` to the next.
   pure function mesh_element(train, j, body) result(element)
      type(train_type), intent(in) :: train
      integer, intent(in) :: j, body
      type(element_type) :: element
      real(dp) :: equivalent

      associate (mesh => train%meshes(j))
         element%mesh = j
         element%from = body
         element%to = body + 1
         element%radius = [mesh%driving_radius, mesh%driven_radius]
         element%stiffness = mesh%stiffness
         equivalent = 1/(mesh%driving_radius**2/mesh%driving_inertia + mesh%driven_radius**2/mesh%driven_inertia)
         element%damping = 2*mesh%damping_ratio*sqrt(mesh%stiffness*equivalent)
         if (mesh%damping_given) element%damping = mesh%damping
      end associate
   end function mesh_element

   !> The damping ratio of a shaft takes the inertias at its ends, those of rigid shafts beyond them included.
   pure subroutine damp_shafts(train, network)
      type(train_type), intent(in) :: train
      type(network_type), intent(inout) :: network
      integer :: n

      do n = 1, size(network%elements)
         associate (element => network%elements(n))
            if (element%shaft == 0) cycle
            associate (shaft => train%shafts(element%shaft))
               element%damping = 2*shaft%damping_ratio &
                                 *sqrt(shaft%stiffness/(1/network%inertia(element%from) + 1/network%inertia(element%to)))
               if (shaft%damping_given) element%damping = shaft%damping
               element%damping = element%damping/element%radius(1)**2
            end associate
         end associate
      end do
   end subroutine damp_shafts

   !> Reduced radii of all bodies: the first element has its own on either side.
   pure subroutine find_radii(network)
      type(network_type), intent(inout) :: network
      integer :: n

      allocate (network%radius(size(network%inertia)), source=0.0_dp)
      network%radius(network%elements(1)%from) = network%elements(1)%radius(1)
      do n = 1, size(network%elements)
         associate (element => network%elements(n), radius => network%radius)
            if (.not. radius(element%to) > 0) then
               radius(element%to) = radius(element%from)*(element%radius(2)/element%radius(1))
            else if (.not. radius(element%from) > 0) then
               radius(element%from) = radius(element%to)*(element%radius(1)/element%radius(2))
            end if
         end associate
      end do
   end subroutine find_radii

end module geartrain_model_network
