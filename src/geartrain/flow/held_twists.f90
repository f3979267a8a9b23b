!> The twist of a coupling that sticks throughout the period. Its dry friction holds any twist at which the spring takes a torque of
!> a range, and the train moves alike with all of them. The middle twist, the mean over this range, changes continuously along a
!> branch, over plays too, and is there as long as any is.
module geartrain_flow_held_twists
   use geartrain_base_kinds, only: dp, pi
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_force_series, only: force_series, include
   use geartrain_flow_kept_states, only: keeps
   use geartrain_flow_orbit, only: flow_order, flow_tolerance
   use geartrain_flow_sections, only: sections_type
   use geartrain_mesh_law_law, only: law_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: centre_twists

   !> Distance of a twist from its middle that is left, in the unit of length [1].
   real(dp), parameter :: off_centre = 1e-9_dp

contains

   !> Moves the twists of couplings that stick throughout the period of an orbit to their middle.
   subroutine centre_twists(system, sections, frequency_ratio, length, states, moved)
      type(system_type), pointer, intent(in) :: system
      !> Flown over the orbit.
      type(sections_type), intent(in) :: sections
      !> Lambda, or what stands for it in `sections`; unit of length [1].
      real(dp), intent(in) :: frequency_ratio, length
      !> States at the beginnings of the sections [1], (state, section).
      real(dp), intent(inout) :: states(:, :)
      !> Whether a twist was not in its middle.
      logical, intent(out) :: moved
      real(dp) :: change(size(states, 1))
      logical :: held(size(states, 1))

      held = keeps(sections%monodromy)
      moved = any(held)
      if (.not. moved) return
      call find_middle_twists(system, sections%lambda_at(frequency_ratio), sections%period, states(:, 1), held, change)
      moved = maxval(abs(change)) > off_centre*length
      if (moved) states = states + spread(change, 2, size(states, 2))
   end subroutine centre_twists

   !> Finds how far the twists of couplings that stick throughout are from their middle.
   subroutine find_middle_twists(system, frequency_ratio, period, state, held, change)
      type(system_type), pointer, intent(in) :: system
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Period of the orbit [periods of the fundamental].
      integer, intent(in) :: period
      !> Its state at phase 0 [1], (state).
      real(dp), intent(in) :: state(:)
      !> Which displacements stay as they are, (state).
      logical, intent(in) :: held(:)
      !> Middle twist less twist [1], (state); 0 of all else.
      real(dp), intent(out) :: change(:)
      type(flow_type) :: flow
      real(dp), dimension(system%meshes) :: low, high
      real(dp) :: end_time, series(0:flow_order)
      integer :: contact(system%meshes), i, j

      change = 0
      low = huge(1.0_dp)
      high = -huge(1.0_dp)
      call flow%setup(system, 1, flow_order, flow_tolerance)
      flow%x(1, :) = state
      end_time = 2*pi/frequency_ratio
      do i = 1, period
         call flow%start(frequency_ratio, 0.0_dp)
         do while (flow%time < end_time)
            if (system%interrupt%raised()) return
            contact = flow%contact
            call flow%step(end_time)
            do j = 1, system%meshes
               if (.not. system%friction(j) > 0) cycle
               call force_series(flow, j, contact(j), series)
               call include(series/system%load_unit(j), flow%length, low(j), high(j))
            end do
         end do
      end do
      do j = 1, system%meshes
         associate (n => system%mesh_element(j))
            if (.not. system%friction(j) > 0 .or. n > system%coordinates) cycle
            if (held(n)) change(n) = mean_twist(system%law(j), high(j) - system%friction(j), &
                                                low(j) + system%friction(j)) - state(n)
         end associate
      end do
   end subroutine find_middle_twists

   !> Mean twist over a range of torques of the spring [1].
   pure real(dp) function mean_twist(law, low, high) result(twist)
      !> Law of the coupling.
      type(law_type), intent(in) :: law
      !> The range over k b_c [1].
      real(dp), intent(in) :: low, high
      real(dp) :: from, to
      integer :: s

      twist = law%rest((low + high)/2)
      if (.not. high > low) return
      twist = 0
      from = low
      do s = law%lowest, law%highest
         ! The torque at the upper wall of the region, which ascends from region to region. In a play it is 0.
         to = high
         if (s < law%highest) to = max(from, min(high, law%stiffness(s)*(law%wall(s) - law%origin(s))))
         ! The twist is linear in the torque between two walls.
         twist = twist + (to - from)/(high - low)*law%rest((from + to)/2)
         from = to
      end do
   end function mean_twist

end module geartrain_flow_held_twists
