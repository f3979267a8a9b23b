!> Finds the steady motion of 1 to 16 periods of the fundamental that the flow from a state settles on, if there is such a motion.
!>
!> The flow is integrated period of the fundamental by period of the fundamental. Slow modes would need thousands of periods of the
!> fundamental; therefore Newton's method is tried now and then from the state reached, and the flow is followed until it is clear
!> that it goes to the attracting orbit found.
module geartrain_flow_settling
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_observer, only: observer_type
   use geartrain_base_sorting, only: ascending
   use geartrain_floquet_multipliers, only: eigenvalues, is_neutral, is_stable
   use geartrain_flow_attraction, only: attraction_type
   use geartrain_flow_bound, only: bound_type
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_integration_settings, only: integration_settings_type
   use geartrain_flow_orbit, only: begin_tangents, flow_order, flow_tolerance, measure, propagate
   use geartrain_flow_shooting, only: find_orbit, newton_step
   use geartrain_model_system, only: system_type
   implicit none (type, external)
   private
   public :: is_leaving, most_states, settle

   !> Longest period that is found [periods of the fundamental].
   integer, parameter :: longest_period = 16
   !> Least relative difference between sections that certainly is no slow convergence.
   real(dp), parameter :: clearly_different = 1e-5_dp
   !> Relative difference between sections at which Newton's method is tried with their distance as the period.
   real(dp), parameter :: nearly_repeated = 1e-3_dp
   !> Time between two calls of the observer [1].
   real(dp), parameter :: between_looks = 200
   !> Mesh periods before the first try of Newton's method; the number is doubled after each try.
   integer, parameter :: first_try = 4
   !> Most Newton steps of a try; most tries with periods other than 1 from a section.
   integer, parameter :: most_steps = 7, most_others = 2
   !> Work of the tries over work of the flow, at most, beyond a first allowance [periods of the fundamental].
   real(dp), parameter :: share = 0.3_dp, allowance = 12
   !> Number of tangents that cost as much as a state without tangents.
   real(dp), parameter :: states_a_state = 6
   !> Most states of a train for tries of Newton's method: for larger trains the tangents cost more than they save.
   integer, parameter :: most_states = 160
   !> Relative difference of states up to which an orbit repeats itself within its period. Smaller than the difference of two
   !> motions (geartrain_balance_same_motion): the halves of a period-doubled orbit next to its period doubling differ little, and
   !> the orbit is known to about 1e-11.
   real(dp), parameter :: repeated_to = 1e-8_dp

   !> The search for the orbit that the flow goes to.
   type :: search_type
      !> The attracting orbit found, if any.
      type(attraction_type) :: orbit
      !> Mesh periods at which the orbit was found; periods of the fundamental at which Newton's method is tried next.
      integer :: found_at = 0, next = first_try
      !> Mesh periods before which repeated sections do not count: they are near an orbit that repels.
      integer :: repels_until = 0
      !> The latest try found an orbit that repels.
      logical :: repels = .false.
      !> Work of the tries [periods of the fundamental].
      real(dp) :: spent = 0
   contains
      procedure, private :: look
      procedure, private :: attempt
      procedure, private :: attempt_others
   end type search_type

contains

   !> Integrates period of the fundamental by period of the fundamental until it is known which motion the flow settles on.
   subroutine settle(system, frequency_ratio, settings, state, motion, observer, stopped)
      !> The train.
      type(system_type), target, intent(in) :: system
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Of which max_periods, tolerance, harmonics and stability are used.
      type(integration_settings_type), intent(in) :: settings
      !> Start, then state of the motion [1], (state) at phase 0.
      real(dp), intent(inout) :: state(:)
      !> The motion; period 0: none found. A motion that grows without bound has a state, but neither coefficients nor figures.
      type(motion_type), intent(out), target :: motion
      !> Called about every 200 units of time, as 'settling'.
      class(observer_type), intent(inout), optional :: observer
      !> Whether the observer or an interrupt ended the flow before the motion was known.
      logical, intent(out), optional :: stopped
      type(flow_type) :: flow
      type(bound_type) :: bound
      type(search_type) :: search
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
      look = max(1, nint(between_looks*frequency_ratio/(2*pi)))
      do k = 1, settings%max_periods
         call flow%pass_period(frequency_ratio)
         section = eoshift(section, -1, dim=2)
         section(:, 0) = flow%x(1, :)
         period = 0
         if (system%interrupt%raised()) exit
         if (.not. bound%holds(section(:, 0), limit)) exit
         call find_period(section, k, settings%tolerance, period)
         call search%look(system, frequency_ratio, section, k, settings%tolerance, period, settled)
         if (settled .or. system%interrupt%raised()) exit
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

      if (orbit%period > 0) then
         multipliers = orbit%multipliers
      else
         if (size(motion%state) > most_states .and. .not. stability) return
         call propagate(system, motion%frequency_ratio, motion%period, motion%state, final, monodromy)
         call eigenvalues(monodromy, multipliers)
      end if
      motion%stable = is_stable(multipliers)
      motion%undecided = is_neutral(multipliers)
      motion%lyapunov_exponent = rate_of(multipliers, motion%frequency_ratio, motion%period)
      if (stability .or. .not. motion%stable) motion%multipliers = multipliers
   end subroutine assess

   !> Smallest period after which the sections repeat themselves to `tolerance`, 0: none. The remaining error is estimated by the
   !> rate at which the differences fall. A multiple of a period whose sections still converge is refused.
   pure subroutine find_period(section, k, tolerance, period)
      real(dp), intent(in) :: section(:, 0:), tolerance
      integer, intent(in) :: k
      integer, intent(out) :: period
      real(dp) :: scale, now, before, rate, error, shorter
      integer :: n, m

      scale = maxval(abs(section(:, 0)))
      shorter = huge(1.0_dp)
      do n = 1, longest_period
         period = 0
         if (k < 2*n) return
         now = maxval(abs(section(:, 0) - section(:, n)))/scale
         before = maxval(abs(section(:, n) - section(:, 2*n)))/scale
         error = now
         if (now > 1e-13_dp) then
            rate = now/before
            if (rate >= 1) cycle
            error = now/(1 - rate)
         end if
         if (error > tolerance) cycle
         period = n
         do m = 1, n - 1
            if (mod(n, m) /= 0) cycle
            if (maxval(abs(section(:, 0) - section(:, m)))/scale < clearly_different) period = 0
         end do
         return
      end do
      period = 0
   end subroutine find_period

   !> Follows the flow towards the known orbit, or searches for an orbit, after `k` periods of the fundamental.
   subroutine look(self, system, frequency_ratio, section, k, tolerance, repeated, settled)
      class(search_type), intent(inout) :: self
      type(system_type), pointer, intent(in) :: system
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> The latest sections of the flow [1], the newest first, (state, 0:).
      real(dp), intent(in) :: section(:, 0:)
      !> Mesh periods so far.
      integer, intent(in) :: k
      !> Relative change over a period at which a motion counts as settled.
      real(dp), intent(in) :: tolerance
      !> Period after which the sections repeat themselves to the tolerance [periods of the fundamental]; 0: none.
      integer, intent(in) :: repeated
      !> The flow goes to the orbit, or repeats itself where neither an attracting nor a repelling orbit is known.
      logical, intent(out) :: settled
      integer :: period

      settled = .false.
      if (size(section, 1) > most_states) then
         settled = repeated > 0
         return
      end if
      if (self%orbit%period > 0) then
         if (mod(k - self%found_at, self%orbit%period) == 0) call self%orbit%follow(section(:, 0), tolerance, settled)
         if (settled) return
      end if
      if (repeated > 0 .and. k >= self%repels_until) then
         call self%attempt(system, frequency_ratio, section, k, repeated, tolerance, settled)
         if (settled .or. self%orbit%period > 0) return
         settled = .not. self%repels
         self%repels_until = k + k/4
      end if
      if (settled .or. self%orbit%comes_near .or. self%spent > allowance + share*k) return
      call find_period(section, k, nearly_repeated, period)
      if (k < self%next .and. (period == 0 .or. k < self%repels_until)) return
      if (k >= self%next) self%next = 2*k
      call self%attempt(system, frequency_ratio, section, k, max(period, 1), tolerance, settled)
      if (self%repels) self%repels_until = k + k/4
      if (settled .or. self%orbit%period > 0 .or. period > 0) return
      call self%attempt_others(system, frequency_ratio, section, k, tolerance, settled)
   end subroutine look

   !> Tries Newton's method from the newest section for an orbit of `period` periods of the fundamental; the older sections tell
   !> whether the flow goes to this orbit.
   subroutine attempt(self, system, frequency_ratio, section, k, period, tolerance, settled)
      class(search_type), intent(inout) :: self
      type(system_type), pointer, intent(in) :: system
      real(dp), intent(in) :: frequency_ratio, section(:, 0:), tolerance
      integer, intent(in) :: k, period
      logical, intent(out) :: settled
      real(dp) :: state(size(section, 1)), monodromy(size(section, 1), size(section, 1)), length
      type(attraction_type) :: orbit
      integer :: flights, shortest, i
      logical :: found

      settled = .false.
      self%repels = .false.
      state = section(:, 0)
      shortest = period
      call find_orbit(system, frequency_ratio, period, most_steps, state, monodromy, length, found, flights)
      self%spent = self%spent + work(period*flights, size(state))
      if (found .and. period > 1) then
         shortest = shortest_period(system, frequency_ratio, period, state)
         if (shortest < period) call find_orbit(system, frequency_ratio, shortest, most_steps, state, monodromy, length, found)
      end if
      if (.not. found) return
      call orbit%setup(system, frequency_ratio, shortest, state, monodromy, length)
      self%repels = orbit%repels
      if (orbit%period == 0) return
      self%orbit = orbit
      self%found_at = k
      do i = min(k, ubound(section, 2))/shortest, 0, -1
         call self%orbit%follow(section(:, i*shortest), tolerance, settled)
         if (settled) return
      end do
   end subroutine attempt

   !> Tries Newton's method for the likeliest periods other than 1.
   subroutine attempt_others(self, system, frequency_ratio, section, k, tolerance, settled)
      class(search_type), intent(inout) :: self
      type(system_type), pointer, intent(in) :: system
      real(dp), intent(in) :: frequency_ratio, section(:, 0:), tolerance
      integer, intent(in) :: k
      logical, intent(out) :: settled
      integer :: period(longest_period), i

      settled = .false.
      if (self%spent + work(longest_period, size(section, 1)) > allowance + share*k) return
      self%spent = self%spent + work(longest_period, size(section, 1))
      period = likely_periods(system, frequency_ratio, section(:, 0))
      period = [pack(period, period /= 1), 1]
      do i = 1, most_others
         call self%attempt(system, frequency_ratio, section, k, period(i), tolerance, settled)
         if (self%orbit%period > 0) return
      end do
   end subroutine attempt_others

   !> The periods 1 to 16, the likeliest period of an orbit near `state` first, by length of the first Newton step times period.
   function likely_periods(system, frequency_ratio, state) result(period)
      type(system_type), target, intent(in) :: system
      real(dp), intent(in) :: frequency_ratio, state(:)
      integer :: period(longest_period)
      type(flow_type) :: flow
      real(dp) :: merit(longest_period), step(size(state))
      integer :: n, info

      call flow%setup(system, size(step) + 1, flow_order, flow_tolerance)
      call begin_tangents(flow, state)
      merit = huge(1.0_dp)
      do n = 1, longest_period
         call flow%pass_period(frequency_ratio)
         if (system%interrupt%raised() .or. .not. all(abs(flow%x) < 1e100_dp)) exit
         call newton_step(state, flow%x(1, :), transpose(flow%x(2:, :)), step, info)
         if (info == 0 .and. maxval(abs(step)) < 1e100_dp) merit(n) = n*maxval(abs(step))
      end do
      period = ascending(merit)
   end function likely_periods

   !> Whether the flow from a state is still linear next to an orbit that repels: then the flow does not yet tell its steady motion.
   logical function is_leaving(system, frequency_ratio, state, exponent)
      !> The train.
      type(system_type), target, intent(in) :: system
      !> Lambda [1]; state at phase 0 [1], (state); largest Lyapunov exponent of the flow, per unit of time [1].
      real(dp), intent(in) :: frequency_ratio, state(:), exponent
      type(flow_type) :: flow
      real(dp) :: orbit(size(state)), monodromy(size(state), size(state)), power(size(state), size(state)), length
      complex(dp) :: multipliers(size(state))
      integer :: period(longest_period), i, n
      logical :: found

      is_leaving = .false.
      if (size(state) > most_states) return
      period = likely_periods(system, frequency_ratio, state)
      call flow%setup(system, 1, flow_order, flow_tolerance)
      do i = 1, most_others
         orbit = state
         call find_orbit(system, frequency_ratio, period(i), most_steps, orbit, monodromy, length, found)
         if (.not. found) cycle
         power = monodromy
         call eigenvalues(power, multipliers)
         if (abs(rate_of(multipliers, frequency_ratio, period(i)) - exponent) > 0.2_dp*exponent) cycle
         flow%x(1, :) = state
         do n = 1, period(i)
            call flow%pass_period(frequency_ratio)
         end do
         is_leaving = maxval(abs(flow%x(1, :) - orbit - matmul(monodromy, state - orbit))) < 0.1_dp*maxval(abs(state - orbit))
         if (is_leaving) return
      end do
   end function is_leaving

   !> Rate of growth of the direction of the largest multiplier, per unit of time [1].
   pure real(dp) function rate_of(multipliers, frequency_ratio, period)
      !> Multipliers [1], largest magnitude first.
      complex(dp), intent(in) :: multipliers(:)
      real(dp), intent(in) :: frequency_ratio
      integer, intent(in) :: period

      rate_of = log(max(abs(multipliers(1)), tiny(1.0_dp)))*frequency_ratio/(2*pi*period)
   end function rate_of

   !> Work of the flow of a state and its tangents [periods of the fundamental of a state alone].
   pure real(dp) function work(periods, states)
      integer, intent(in) :: periods, states

      work = periods*(1 + states/states_a_state)
   end function work

   !> Shortest period of an orbit that repeats itself after `period` periods of the fundamental.
   integer function shortest_period(system, frequency_ratio, period, state) result(n)
      type(system_type), target, intent(in) :: system
      real(dp), intent(in) :: frequency_ratio, state(:)
      integer, intent(in) :: period
      type(flow_type) :: flow

      call flow%setup(system, 1, flow_order, flow_tolerance)
      flow%x(1, :) = state
      do n = 1, period - 1
         call flow%pass_period(frequency_ratio)
         if (system%interrupt%raised()) return
         if (mod(period, n) == 0 .and. maxval(abs(flow%x(1, :) - state)) < repeated_to*maxval(abs(state))) return
      end do
   end function shortest_period

end module geartrain_flow_settling
