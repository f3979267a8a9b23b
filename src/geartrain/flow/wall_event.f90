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
      real(dp) :: f(0:ubound(p, 3)), root, span, smallest
      integer :: j, k, n, w
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
            smallest = rounding*(span + abs(system%law(j)%wall(w)))
            if ((j == last_mesh .and. w == last_wall) .or. abs(f(0)) <= smallest) then
               k = leading_term(f, h, smallest)
               if (k == 0) cycle
               ! The mesh moves away from the wall: divide by the known root 0. Else it crosses the wall at once.
               if (f(k) > 0) then
                  f = eoshift(f, k)
               else
                  f(0) = -smallest
               end if
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

   !> First power of a series whose term is more than rounding within a step; 0: there is none. Meshes that lie on their walls at
   !> rest, or meet them at one instant, leave by it: rounding puts them on either side, and may give them any velocity.
   pure integer function leading_term(f, h, smallest) result(k)
      !> Coefficients of the powers, (0:degree); length of the step; largest rounding.
      real(dp), intent(in) :: f(0:), h, smallest
      real(dp) :: power

      power = 1
      do k = 1, ubound(f, 1)
         power = power*h
         if (abs(f(k))*power > smallest) return
      end do
      k = 0
   end function leading_term

end module geartrain_flow_wall_event
