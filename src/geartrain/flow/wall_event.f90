!> The first contact event of a step of the flow, in the Taylor series of the displacements.
module geartrain_flow_wall_event
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_first_root, only: first_root
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: first_wall

   !> Rounding of a distance from a wall, over the largest displacement.
   real(dp), parameter :: rounding = 1e-14_dp

contains

   !> Finds the first instant in (0, h] at which a mesh leaves its present contact, and shortens h to this instant.
   pure subroutine first_wall(system, contact, p, last_mesh, last_wall, h, found, mesh, wall)
      type(system_type), intent(in) :: system
      !> Region of the force law of each mesh, (mesh).
      integer, intent(in) :: contact(:)
      !> Taylor coefficients of the displacements of state and tangents [1], (column, element, 0:order).
      real(dp), intent(in) :: p(:, :, 0:)
      !> Mesh and wall of the event with which the step begins, 0: none.
      integer, intent(in) :: last_mesh, last_wall
      !> Length of the step [1].
      real(dp), intent(inout) :: h
      !> Whether there is an event.
      logical, intent(out) :: found
      !> Its mesh and wall.
      integer, intent(out) :: mesh, wall
      real(dp) :: f(0:ubound(p, 3)), root, span
      integer :: j, n, w
      logical :: hit

      found = .false.
      mesh = 0
      wall = 0
      span = maxval(abs(p(1, :, 0)))
      do j = 1, system%meshes
         n = system%mesh_element(j)
         ! Both walls of the region.
         do w = max(contact(j) - 1, system%law(j)%lowest), min(contact(j), system%law(j)%highest - 1)
            ! Distance from the wall, positive in the present region.
            f = p(1, n, :)
            f(0) = f(0) - system%law(j)%wall(w)
            if (w == contact(j)) f = -f
            if (j == last_mesh .and. w == last_wall) then
               ! The mesh has just left this wall: divide by the known root 0.
               f = eoshift(f, 1)
            else if (f(1) > 0 .and. f(0) > -rounding*(span + abs(system%law(j)%wall(w)))) then
               ! Left at the very instant of the event before, as equal stages do: rounding puts the mesh on either side.
               f(0) = max(f(0), 0.0_dp)
            end if
            call first_root(f, h, root, hit)
            if (.not. hit) cycle
            h = root
            found = .true.
            mesh = j
            wall = w
         end do
      end do
   end subroutine first_wall

end module geartrain_flow_wall_event
