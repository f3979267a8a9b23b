!> Events of couplings with dry friction: their modes change, and with them what the flow makes of small changes of the state.
!>
!> Where friction forces change by D at an instant at which a function of the state passes 0, a tangent along which this function
!> grows by g loses W D g/r of its velocities, r being the rate of the function (saltation). Where a coupling comes to stick, no
!> tangent has a velocity of it left: the matrix is singular, and the motion forgets how it came to stick.
module geartrain_flow_friction_events
   use geartrain_base_kinds, only: dp
   use geartrain_flow_dry_friction, only: friction_type, sticks, undecided
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: begin_friction, change_mode, meet_jump

contains

   !> Chooses the modes of the couplings that have no velocity at the beginning of a flight.
   pure subroutine begin_friction(friction, system, acceleration, x)
      !> Friction after `begin`.
      type(friction_type), intent(inout) :: friction
      type(system_type), intent(in) :: system
      !> Accelerations of all elements without the friction of the undecided couplings [1], (element).
      real(dp), intent(in) :: acceleration(:)
      !> State and tangents [1], (column, state).
      real(dp), intent(inout) :: x(:, :)
      real(dp) :: force(friction%count)

      call friction%choose(acceleration(friction%element), force)
      call friction%prepare()
      call friction%stop(x(:1, system%displacements + 1:))
      call friction%hold(system, x(2:, system%displacements + 1:))
   end subroutine begin_friction

   !> A coupling ceases to slip, and then sticks or slips the other way, or ceases to stick.
   pure subroutine change_mode(friction, system, i, velocity, h, x)
      !> Friction after a step that ended at the event.
      type(friction_type), intent(inout) :: friction
      type(system_type), intent(in) :: system
      !> Number of the coupling.
      integer, intent(in) :: i
      !> Taylor coefficients of the velocities of all elements over the step [1], (element, 0:order); length of the step [1].
      real(dp), intent(in) :: velocity(:, 0:), h
      !> State and tangents at the event [1], (column, state).
      real(dp), intent(inout) :: x(:, :)
      real(dp) :: force(friction%count), acceleration(friction%count)

      force = friction%forces_at(h)
      if (friction%mode(i) == sticks) then
         ! The force is continuous, so nothing changes for the tangents.
         call friction%release(i, force(i))
         return
      end if
      acceleration = friction%accelerations_at(velocity, h)
      friction%mode(i) = sticks
      associate (a => acceleration(i), d => system%displacements)
         call choose_again(friction, system, acceleration, force, &
                           friction%rates(system, i, x(2:, d + 1:))/sign(max(abs(a), tiny(a)), a), x)
      end associate
   end subroutine change_mode

   !> The damping of a mesh changes at a wall of its law: the forces of couplings that stick change too, and may exceed their
   !> limits.
   pure subroutine meet_jump(friction, system, element, jump, speed, velocity, h, x)
      !> Friction after a step that ended at the event.
      type(friction_type), intent(inout) :: friction
      type(system_type), intent(in) :: system
      !> Element of the mesh.
      integer, intent(in) :: element
      !> Damping after the wall less damping before it [1]; velocity of the mesh [1].
      real(dp), intent(in) :: jump, speed
      !> Taylor coefficients of the velocities of all elements over the step [1], (element, 0:order); length of the step [1].
      real(dp), intent(in) :: velocity(:, 0:), h
      !> State and tangents at the event, which have passed the wall [1], (column, state).
      real(dp), intent(inout) :: x(:, :)
      real(dp) :: force(friction%count), acceleration(friction%count), distance(size(x, 1) - 1)
      integer :: i, k

      if (.not. (any(friction%mode == sticks) .and. abs(speed) > 0)) return
      force = friction%forces_at(h)
      acceleration = friction%accelerations_at(velocity, h)
      do i = 1, friction%count
         associate (n => friction%element(i))
            if (n == element) acceleration(i) = acceleration(i) - system%own(n)*jump*speed
            do k = system%first(n), system%first(n + 1) - 1
               if (system%neighbour(k) == element) acceleration(i) = acceleration(i) - system%coupling(k)*jump*speed
            end do
         end associate
      end do
      associate (d => system%displacements, c => system%coordinates)
         if (element <= c) then
            distance = x(2:, element)
         else
            distance = matmul(x(2:, :d), system%network%loop(element - c, :d))
         end if
      end associate
      call choose_again(friction, system, acceleration, force, distance/speed, x)
   end subroutine meet_jump

   !> Chooses the modes of all couplings that stick anew.
   pure subroutine choose_again(friction, system, acceleration, before, later, x)
      type(friction_type), intent(inout) :: friction
      type(system_type), intent(in) :: system
      !> Accelerations with the friction forces `before` [1], (coupling).
      real(dp), intent(in) :: acceleration(:), before(:)
      !> By how much earlier a tangent meets the event [1], (column).
      real(dp), intent(in) :: later(:)
      real(dp), intent(inout) :: x(:, :)
      real(dp) :: free(friction%count), after(friction%count)
      integer, allocatable :: open(:)
      integer :: i

      open = pack([(i, i=1, friction%count)], friction%mode == sticks)
      friction%mode(open) = undecided
      free = acceleration + matmul(friction%gain(:, open), before(open))
      call friction%choose(free, after)
      call friction%prepare()
      associate (d => system%displacements)
         do i = 1, system%coordinates
            x(2:, d + i) = x(2:, d + i) - dot_product(friction%column(i, :), after - before)*later
         end do
         call friction%stop(x(:1, d + 1:))
         call friction%hold(system, x(2:, d + 1:))
      end associate
   end subroutine choose_again

end module geartrain_flow_friction_events
