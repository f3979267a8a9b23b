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

   !> Largest change of a factor at which the factors and the loads agree [1]; passes in all, and without halving their steps.
   real(dp), parameter :: agree = 1e-12_dp
   integer, parameter :: most_passes = 200, whole_steps = 20

contains

   !> Reduces the mesh stiffnesses of light loads: ISO 6336-1 has c' fall with the fourth root of the line load below 100 N/mm. In
   !> loops, as between planets, the loads follow from the stiffnesses, and both are found together. A mesh without load keeps its
   !> stiffness.
   pure subroutine reduce_light_loads(train, factor, agreed)
      !> A plain train that has passed all checks.
      type(train_type), intent(inout) :: train
      !> Factor of the stiffness of each mesh [1], (mesh).
      real(dp), allocatable, intent(out), optional :: factor(:)
      !> Whether stiffnesses and loads were found together.
      logical, intent(out), optional :: agreed
      type(network_type) :: network
      type(law_type) :: law(size(train%meshes))
      type(train_type) :: reduced
      real(dp), allocatable :: force(:)
      real(dp) :: share(size(train%meshes)), next(size(train%meshes)), residual
      integer :: i, n, pass

      share = 1
      pass = 0
      if (any(train%meshes%light_force > 0)) then
         reduced = train
         do pass = 1, most_passes
            reduced%meshes%stiffness = share*train%meshes%stiffness
            call build_network(reduced, network)
            do i = 1, size(law)
               call put_law(reduced%meshes(i), train%characteristic_length, law(i))
            end do
            if (.not. allocated(force)) allocate (force(size(network%elements)))
            call rest_forces(network, law, train%characteristic_length, force, residual)
            next = 1
            do n = 1, size(force)
               i = network%elements(n)%mesh
               if (i == 0) cycle
               if (train%meshes(i)%light_force > 0 .and. abs(force(n)) > 0) &
                  next(i) = min(1.0_dp, abs(force(n))/train%meshes(i)%light_force)**0.25_dp
            end do
            if (all(abs(next - share) < agree)) exit
            if (pass > whole_steps) next = sqrt(share*next)
            share = next
         end do
         train%meshes%stiffness = reduced%meshes%stiffness
         train%meshes%light_force = 0
      end if
      if (present(factor)) factor = share
      if (present(agreed)) agreed = pass <= most_passes
   end subroutine reduce_light_loads

end module geartrain_network_light_loads
