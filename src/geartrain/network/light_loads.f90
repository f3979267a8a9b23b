!> Mesh stiffnesses of light loads.
module geartrain_network_light_loads
   use geartrain_base_kinds, only: dp
   use geartrain_mesh_law_law, only: law_type
   use geartrain_network_network, only: build_network, network_type
   use geartrain_network_rest, only: rest_forces
   use geartrain_train_mesh, only: put_law
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: reduce_light_loads

contains

   !> Reduces the mesh stiffnesses of light loads: ISO 6336-1 has c' fall with the fourth root of the line load below 100 N/mm. The
   !> loads are the static forces with the stiffnesses for full loads, which matters in loops only. A mesh without load keeps its
   !> stiffness.
   pure subroutine reduce_light_loads(train, factor)
      !> A plain train that has passed all checks.
      type(train_type), intent(inout) :: train
      !> Factor of the stiffness of each mesh [1], (mesh).
      real(dp), allocatable, intent(out), optional :: factor(:)
      type(network_type) :: network
      type(law_type) :: law(size(train%meshes))
      real(dp), allocatable :: force(:)
      real(dp) :: share(size(train%meshes)), residual
      integer :: i, n

      share = 1
      if (any(train%meshes%light_force > 0)) then
         call build_network(train, network)
         do i = 1, size(law)
            call put_law(train%meshes(i), train%characteristic_length, law(i))
         end do
         allocate (force(size(network%elements)))
         call rest_forces(network, law, train%characteristic_length, force, residual)
         do n = 1, size(force)
            i = network%elements(n)%mesh
            if (i == 0) cycle
            if (train%meshes(i)%light_force > 0 .and. abs(force(n)) > 0) &
               share(i) = min(1.0_dp, abs(force(n))/train%meshes(i)%light_force)**0.25_dp
         end do
         train%meshes%stiffness = share*train%meshes%stiffness
         train%meshes%light_force = 0
      end if
      if (present(factor)) factor = share
   end subroutine reduce_light_loads

end module geartrain_network_light_loads
