!> The steps of the flow of the linearised train (geartrain_balance_linear_flow). A step waits for the step before, so the period is
!> cut into segments whose steps are taken side by side.
module geartrain_balance_flow_steps
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: add_influence, segments, take_steps

   !> Number of segments of a period.
   integer, parameter :: segments = 8

contains

   !> Steps of all segments side by side.
   pure subroutine take_steps(e, unknowns, steps, element, h, own, first, neighbour, coupling, spring, damper, stiffness, drive, &
                              y, p_start, v_start)
      !> Numbers of elements, of unknown meshes and of steps of a segment; element of each unknown mesh.
      integer, intent(in) :: e, unknowns, steps, element(unknowns)
      !> Length of a step; W as in system_type.
      real(dp), intent(in) :: h, own(:), coupling(:)
      !> Neighbours as in system_type.
      integer, intent(in) :: first(:), neighbour(:)
      !> Stiffness of the linear elements and damping of all, (element); stiffness of the unknown meshes along the motion and their
      !> force besides, (step, segment, unknown); displacements and velocities at the beginning of each segment, (segment, element).
      real(dp), intent(in) :: spring(e), damper(e), stiffness(steps, segments, unknowns), drive(steps, segments, unknowns), &
                              p_start(segments, e), v_start(segments, e)
      !> Displacements of the unknown meshes, (step, segment, unknown).
      real(dp), intent(out) :: y(steps, segments, unknowns)
      real(dp) :: p(segments, e), v(segments, e), force(segments, e), kick(segments)
      integer :: i, k, l, m, n

      p = p_start
      v = v_start
      do k = 1, steps
         do n = 1, e
            do l = 1, segments
               force(l, n) = spring(n)*p(l, n) + damper(n)*v(l, n)
            end do
         end do
         do i = 1, unknowns
            n = element(i)
            do l = 1, segments
               y(k, l, i) = p(l, n)
               force(l, n) = force(l, n) + stiffness(k, l, i)*p(l, n) + drive(k, l, i)
            end do
         end do
         do n = 1, e
            do l = 1, segments
               kick(l) = own(n)*force(l, n)
            end do
            do m = first(n), first(n + 1) - 1
               do l = 1, segments
                  kick(l) = kick(l) + coupling(m)*force(l, neighbour(m))
               end do
            end do
            do l = 1, segments
               v(l, n) = v(l, n) - h*kick(l)
               p(l, n) = p(l, n) + h*v(l, n)
            end do
         end do
      end do
   end subroutine take_steps

   !> Adds what forces at the steps of a segment add to its end state.
   pure subroutine add_influence(n, steps, influence, force, added)
      !> Length of the state; number of steps, a multiple of 4.
      integer, intent(in) :: n, steps
      !> End state per force at a step, (state, step); force, (step).
      real(dp), intent(in) :: influence(n, steps), force(steps)
      !> End state, (state).
      real(dp), intent(inout) :: added(n)
      integer :: k, l

      do k = 1, steps, 4
         do l = 1, n
            added(l) = added(l) + force(k)*influence(l, k) + force(k + 1)*influence(l, k + 1) &
                       + force(k + 2)*influence(l, k + 2) + force(k + 3)*influence(l, k + 3)
         end do
      end do
   end subroutine add_influence

end module geartrain_balance_flow_steps
