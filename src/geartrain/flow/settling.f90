!> Finds the steady motion of 1 to 16 periods of the fundamental that the flow from a state settles on, if there is such a motion.
!>
!> The flow is integrated period of the fundamental by period of the fundamental. Slow modes would need thousands of periods of the
!> fundamental; therefore Newton's method is tried now and then from the state reached, and the flow is followed until it is clear
!> that it goes to the attracting orbit found. A flow that rests on an orbit that repels is disturbed.
module geartrain_flow_settling
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_memory, only: need
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_floquet_multipliers, only: eigenvalues, is_neutral, is_stable
   use geartrain_flow_attraction, only: attraction_type
   use geartrain_flow_attractor_search, only: attractor_search_type, find_period, likely_periods, longest_period, most_others, &
      most_states, most_steps
   use geartrain_flow_bound, only: bound_type
   use geartrain_flow_disturbance, only: disturb
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_kept_states, only: judge
   use geartrain_flow_integration_settings, only: integration_settings_type, most_periods
   use geartrain_flow_orbit, only: flow_order, flow_tolerance, measure, memory_to_measure, propagate
   use geartrain_flow_shooting, only: find_orbit
   use geartrain_flow_tangent_flight, only: tangent_flight_type
   use geartrain_network_system, only: system_type
   use geartrain_network_units, only: mesh_frequencies
   implicit none (type, external)
   private
   public :: is_leaving, is_linear, need_to_settle, settle

   !> Time between two calls of the observer, in which the slowest mesh vibrates alone by so many radians [1].
   real(dp), parameter :: between_looks = 200

contains

   !> Integrates period of the fundamental by period of the fundamental until it is known which motion the flow settles on.
   subroutine settle(system, frequency_ratio, settings, state, motion, observer, stopped)
      type(system_type), target, intent(in) :: system
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Of which max_periods, tolerance, harmonics and stability are used.
      type(integration_settings_type), intent(in) :: settings
      !> Start, then state of the motion [1], (state) at phase 0.
      real(dp), intent(inout) :: state(:)
      !> The motion; period 0: none found. A motion that grows without bound has a state, but neither coefficients nor figures.
      type(motion_type), intent(out), target :: motion
      !> Called some 30 vibrations of the slowest mesh after the call before, but not before the end of a period, as 'settling'.
      class(observer_type), intent(inout), optional :: observer
      !> Whether the observer or an interrupt ended the flow before the motion was known.
      logical, intent(out), optional :: stopped
      type(flow_type) :: flow
      type(bound_type) :: bound
      type(attractor_search_type) :: search
      real(dp) :: section(size(state), 0:2*longest_period)
      real(dp) :: limit
      integer :: k, period, look
      logical :: keep_going, settled

      if (present(stopped)) stopped = .false.
      call flow%setup(system, 1, flow_order, flow_tolerance)
      flow%x(1, :) = state
      section = huge(1.0_dp)
      section(:, 0) = state
      settled = .false.
      period = 0
      call bound%setup(system, frequency_ratio)
      limit = bound%limit(state)
      look = max(1, nint(min(1e4_dp, between_looks*frequency_ratio/(2*pi*minval(mesh_frequencies(system))))))
      do k = 1, most_periods(system, settings%max_periods)
         call flow%pass_period(frequency_ratio)
         section = eoshift(section, -1, dim=2)
         section(:, 0) = flow%x(1, :)
         period = 0
         if (system%interrupt%raised()) exit
         if (.not. bound%holds(section(:, 0), limit)) exit
         call find_period(section, k, settings%tolerance, period)
         call search%look(system, frequency_ratio, section, k, settings%tolerance, period, settled)
         if (settled .or. system%interrupt%raised()) exit
         ! On an orbit that repels, as on the symmetric one of a symmetric train, a flow without any disturbance stays for ever.
         if (search%rests) call disturb(system, flow%x(1, :))
         if (.not. present(observer) .or. mod(k, look) /= 0) cycle
         keep_going = .true.
         call observer%on_step('settling', k, frequency_ratio, keep_going)
         if (keep_going) cycle
         if (present(stopped)) stopped = .true.
         exit
      end do
      state = section(:, 0)
      motion%frequency_ratio = frequency_ratio
      motion%period = longest_period
      if (system%interrupt%raised()) then
         if (present(stopped)) stopped = .true.
         motion%state = state
         motion%period = 0
         return
      end if
      if (settled .and. search%orbit%period > 0) then
         state = search%orbit%state
         period = search%orbit%period
         motion%error_estimate = search%orbit%accuracy
      else if (search%repels .and. .not. settled) then
         period = 0
      else if (period > 0) then
         motion%error_estimate = settings%tolerance
      end if
      if (period > 0) motion%period = period
      motion%state = state
      if (bound%holds(state, limit)) call measure(system, settings%harmonics, motion)
      motion%period = period
      if (period == 0) motion%kind = 'undecided'
      if (.not. allocated(motion%coefficients)) motion%kind = 'unbounded'
      if (period > 0) call assess(system, settings%stability, search%orbit, motion)
      if (flow%lost) motion%undecided = .true.
   end subroutine settle

   !> Makes it an error if there is no memory for the figures of a motion that `settle` finds, or does not.
   subroutine need_to_settle(system, harmonics, error)
      type(system_type), intent(in) :: system
      !> Harmonics that are stored; 0: as many as the train needs.
      integer, intent(in) :: harmonics
      !> No memory.
      type(error_type), allocatable, intent(inout) :: error

      call need(memory_to_measure(system, longest_period, harmonics), 'no memory for the figures of '//text(longest_period)// &
                ' periods of the fundamental, each with '//text(maxval(system%law%order))//' cycles of the fastest mesh', &
                'give fewer harmonics', error)
   end subroutine need_to_settle

   !> Multipliers, stability and Lyapunov exponent of a motion with known period.
   subroutine assess(system, stability, orbit, motion)
      type(system_type), intent(in) :: system
      !> Whether the multipliers are wanted.
      logical, intent(in) :: stability
      !> The orbit of the search; period 0: none.
      type(attraction_type), intent(in) :: orbit
      type(motion_type), intent(inout) :: motion
      real(dp) :: final(size(motion%state)), monodromy(size(motion%state), size(motion%state))
      complex(dp) :: multipliers(size(motion%state))

      ! The search knows the multipliers to about 1e-9: enough for the verdict.
      if (orbit%period > 0 .and. .not. stability) then
         multipliers = orbit%multipliers
         motion%stable = is_stable(multipliers)
         motion%undecided = is_neutral(multipliers)
      else
         if (size(motion%state) > most_states .and. .not. stability) return
         call propagate(system, motion%frequency_ratio, motion%period, motion%state, final, monodromy)
         call judge(monodromy, multipliers, motion%stable, motion%undecided)
      end if
      motion%lyapunov_exponent = rate_of(multipliers, motion%frequency_ratio, motion%period)
      if (stability .or. .not. motion%stable) motion%multipliers = multipliers
   end subroutine assess

   !> Whether the flow from a state is still linear next to an orbit that repels: then the flow does not yet tell its steady motion.
   logical function is_leaving(system, frequency_ratio, state, exponent)
      type(system_type), target, intent(in) :: system
      !> Lambda [1]; state at phase 0 [1], (state); largest Lyapunov exponent of the flow, per unit of time [1].
      real(dp), intent(in) :: frequency_ratio, state(:), exponent
      real(dp) :: orbit(size(state)), monodromy(size(state), size(state)), power(size(state), size(state)), length
      complex(dp) :: multipliers(size(state))
      type(tangent_flight_type) :: flight
      integer :: period(longest_period), i
      logical :: found

      is_leaving = .false.
      if (size(state) > most_states) return
      period = likely_periods(system, frequency_ratio, state)
      call flight%setup(system)
      do i = 1, most_others
         orbit = state
         call find_orbit(flight, frequency_ratio, period(i), most_steps, orbit, monodromy, length, found)
         if (.not. found) cycle
         power = monodromy
         call eigenvalues(power, multipliers)
         if (abs(rate_of(multipliers, frequency_ratio, period(i)) - exponent) > 0.2_dp*exponent) cycle
         is_leaving = is_linear(system, frequency_ratio, period(i), state, orbit, monodromy)
         if (is_leaving) return
      end do
   end function is_leaving

   !> Whether the flow from a state is linear next to an orbit.
   logical function is_linear(system, frequency_ratio, period, state, orbit, monodromy)
      type(system_type), target, intent(in) :: system
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Period of the orbit [periods of the fundamental].
      integer, intent(in) :: period
      !> State, and state of the orbit, at phase 0 [1], (state); monodromy matrix of the orbit [1], (state, state).
      real(dp), intent(in) :: state(:), orbit(:), monodromy(:, :)
      type(flow_type) :: flow
      integer :: n

      call flow%setup(system, 1, flow_order, flow_tolerance)
      flow%x(1, :) = state
      do n = 1, period
         call flow%pass_period(frequency_ratio)
      end do
      is_linear = maxval(abs(flow%x(1, :) - orbit - matmul(monodromy, state - orbit))) < 0.1_dp*maxval(abs(state - orbit))
   end function is_linear

   !> Rate of growth of the direction of the largest multiplier, per unit of time [1].
   pure real(dp) function rate_of(multipliers, frequency_ratio, period)
      !> Multipliers [1], largest magnitude first.
      complex(dp), intent(in) :: multipliers(:)
      real(dp), intent(in) :: frequency_ratio
      integer, intent(in) :: period

      rate_of = log(max(abs(multipliers(1)), tiny(1.0_dp)))*frequency_ratio/(2*pi*period)
   end function rate_of

end module geartrain_flow_settling
