!> The search for the orbit that a flow goes to, from section to section at phase 0: Newton's method tried now and then from the
!> state reached, and the watch over the flow that goes to the orbit found.
module geartrain_flow_attractor_search
   use geartrain_base_kinds, only: dp
   use geartrain_base_sorting, only: ascending
   use geartrain_flow_attraction, only: attraction_type
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_orbit, only: begin_tangents, flow_order, flow_tolerance
   use geartrain_flow_shooting, only: find_orbit, newton_step
   use geartrain_flow_tangent_flight, only: tangent_flight_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: attractor_search_type, find_period, likely_periods, longest_period, most_others, most_states, most_steps

   !> Longest period that is found [periods of the fundamental].
   integer, parameter :: longest_period = 16
   !> Least relative difference between sections that certainly is no slow convergence.
   real(dp), parameter :: clearly_different = 1e-5_dp
   !> Relative difference between sections at which Newton's method is tried with their distance as the period.
   real(dp), parameter :: nearly_repeated = 1e-3_dp
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
   type :: attractor_search_type
      !> The attracting orbit found, if any.
      type(attraction_type) :: orbit
      !> Mesh periods at which the orbit was found; periods of the fundamental at which Newton's method is tried next.
      integer :: found_at = 0, next = first_try
      !> Mesh periods before which repeated sections do not count: they are near an orbit that repels.
      integer :: repels_until = 0
      !> The latest try found an orbit that repels; the flow repeats itself on this orbit, which it will not leave by itself.
      logical :: repels = .false., rests = .false.
      type(tangent_flight_type), private :: flight
      !> Work of the tries [periods of the fundamental].
      real(dp) :: spent = 0
   contains
      procedure :: look
      procedure, private :: attempt
      procedure, private :: attempt_others
   end type attractor_search_type

contains

   !> Smallest period after which the sections repeat themselves to `tolerance`, 0: none. The remaining error is estimated by the
   !> rate at which the differences fall. A multiple of a period whose sections still converge is refused.
   pure subroutine find_period(section, k, tolerance, period)
      !> The latest sections of the flow [1], the newest first, (state, 0:); relative change of a motion that counts as settled [1].
      real(dp), intent(in) :: section(:, 0:), tolerance
      !> Periods of the fundamental so far.
      integer, intent(in) :: k
      !> The period [periods of the fundamental].
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
      class(attractor_search_type), intent(inout) :: self
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
      self%rests = .false.
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
         self%rests = self%repels
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
      class(attractor_search_type), intent(inout) :: self
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
      if (.not. associated(self%flight%system)) call self%flight%setup(system)
      call find_orbit(self%flight, frequency_ratio, period, most_steps, state, monodromy, length, found, flights)
      self%spent = self%spent + work(period*flights, size(state))
      if (found .and. period > 1) then
         shortest = shortest_period(system, frequency_ratio, period, state)
         if (shortest < period) call find_orbit(self%flight, frequency_ratio, shortest, most_steps, state, monodromy, length, found)
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
      class(attractor_search_type), intent(inout) :: self
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
      !> Lambda [1]; state at phase 0 [1], (state).
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

end module geartrain_flow_attractor_search
