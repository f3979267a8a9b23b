!> From any state to the steady motion that the flow settles on, its period 1 to 16 mesh periods, else none found.
!>
!> The flow is carried mesh period by mesh period. Slow modes would need thousands of them: now and then Newton's method is tried
!> on the state reached, for an orbit that attracts, and the flow is watched until it is plain that it goes there.
module geartrain_flow_settling
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_observer, only: observer_type
   use geartrain_floquet_multipliers, only: eigenvalues, is_neutral, is_stable
   use geartrain_flow_attraction, only: attraction_type
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_integration_settings, only: integration_settings_type
   use geartrain_flow_orbit, only: begin_tangents, flow_order, flow_tolerance, measure, propagate
   use geartrain_flow_shooting, only: find_orbit, newton_step
   use geartrain_flow_start_state, only: resting_state
   use geartrain_model_system, only: system_type
   implicit none (type, external)
   private
   public :: is_leaving, most_states, settle

   !> Longest period looked for, in mesh periods.
   integer, parameter :: longest_period = 16
   !> Sections that differ by less than this (relative) may still be the same motion converging slowly.
   real(dp), parameter :: clearly_different = 1e-5_dp
   !> Sections that repeat themselves this well (relative) tell the period to try.
   real(dp), parameter :: nearly_repeated = 1e-3_dp
   !> State over the largest of the characteristic length, the resting state and the start beyond which a motion is given up: it
   !> runs away, in a range of Lambda where the train without separation is unstable.
   real(dp), parameter :: unbounded = 1e6_dp
   !> Time between two looks at the observer [1].
   real(dp), parameter :: between_looks = 200
   !> Newton's method is tried after so many mesh periods first, then after twice as many, and so on.
   integer, parameter :: first_try = 4
   !> Newton steps of one try, tries with other periods than 1 at a time.
   integer, parameter :: most_steps = 7, most_others = 2
   !> Work of the tries over that of the mesh periods so far, at most, after a first allowance [mesh periods].
   real(dp), parameter :: share = 0.3_dp, allowance = 12
   !> States whose tangents cost as much as a state without.
   real(dp), parameter :: states_a_state = 6
   !> Trains of more states settle without tries: their tangents cost more than they save.
   integer, parameter :: most_states = 160
   !> States of one orbit agree to this (relative).
   real(dp), parameter :: same = 1e-8_dp

   !> The search for the orbit that the flow goes to.
   type :: search_type
      type(attraction_type) :: orbit
      !> Mesh periods after which the orbit was found, after which Newton's method is tried again.
      integer :: found_at = 0, next = first_try
      !> Before so many, sections that repeat themselves do not count: they are near an orbit that repels.
      integer :: repels_until = 0
      !> The latest try found an orbit that repels.
      logical :: repels = .false.
      !> Work of the tries [mesh periods].
      real(dp) :: spent = 0
   contains
      procedure, private :: look
      procedure, private :: attempt
      procedure, private :: attempt_others
   end type search_type

contains

   !> Integrates mesh period by mesh period until it is known which motion the flow settles on; `state` is carried along. A motion
   !> that grows without bound has a state, but neither coefficients nor figures.
   subroutine settle(system, frequency_ratio, settings, state, motion, observer, stopped)
      type(system_type), intent(in) :: system
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      type(integration_settings_type), intent(in) :: settings
      !> (state) at phase 0.
      real(dp), intent(inout) :: state(:)
      type(motion_type), intent(out), target :: motion
      class(observer_type), intent(inout), optional :: observer
      !> The observer or an interrupt ended it before the motion was steady.
      logical, intent(out), optional :: stopped
      type(flow_type) :: flow
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
      limit = unbounded*max(1.0_dp, maxval(abs(resting_state(system))), maxval(abs(state)))
      look = max(1, nint(between_looks*frequency_ratio/(2*pi)))
      do k = 1, settings%max_periods
         call flow%start(frequency_ratio, 0.0_dp)
         call flow%advance(2*pi/frequency_ratio)
         section = eoshift(section, -1, dim=2)
         section(:, 0) = flow%x(1, :)
         period = 0
         if (system%interrupt%raised()) exit
         if (.not. all(abs(section(:, 0)) < limit)) exit
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
      if (all(abs(state) < limit)) call measure(system, settings%harmonics, motion)
      motion%period = period
      if (period == 0) motion%kind = 'undecided'
      if (.not. allocated(motion%coefficients)) motion%kind = 'unbounded'
      if (period > 0) call assess(system, settings%stability, search%orbit, motion)
      if (flow%lost) motion%undecided = .true.
   end subroutine settle

   !> Multipliers and what they tell of a motion whose period was found.
   subroutine assess(system, stability, orbit, motion)
      type(system_type), intent(in) :: system
      !> The multipliers are asked for.
      logical, intent(in) :: stability
      !> Known from the search where its period is not 0.
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

   !> The smallest period whose section repeats itself to `tolerance`, the remaining error being judged by the rate at
   !> which the differences fall; 0 if there is none yet. A multiple of a period that still converges is not taken for one.
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

   !> Watches the flow towards the orbit known, or looks for one, after `k` mesh periods.
   subroutine look(self, system, frequency_ratio, section, k, tolerance, repeated, settled)
      class(search_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> The latest sections of the flow, the last one first, (state, 0:).
      real(dp), intent(in) :: section(:, 0:)
      !> Mesh periods so far.
      integer, intent(in) :: k
      !> Relative change over a period at which a motion counts as settled.
      real(dp), intent(in) :: tolerance
      !> Period after which the sections repeat themselves to the tolerance; 0: they do not.
      integer, intent(in) :: repeated
      !> The flow goes to the orbit, or repeats itself where no orbit is known that attracts or repels.
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

   !> Newton's method from the latest section for an orbit of `period` mesh periods; the sections before tell whether the flow
   !> goes there.
   subroutine attempt(self, system, frequency_ratio, section, k, period, tolerance, settled)
      class(search_type), intent(inout) :: self
      type(system_type), intent(in) :: system
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

   !> The same for other periods than 1.
   subroutine attempt_others(self, system, frequency_ratio, section, k, tolerance, settled)
      class(search_type), intent(inout) :: self
      type(system_type), intent(in) :: system
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

   !> The periods 1 to 16, the likeliest ones of an orbit near `state` first: by the length of Newton's first step, and its cost.
   function likely_periods(system, frequency_ratio, state) result(period)
      type(system_type), intent(in) :: system
      real(dp), intent(in) :: frequency_ratio, state(:)
      integer :: period(longest_period)
      type(flow_type) :: flow
      real(dp) :: merit(longest_period), step(size(state))
      integer :: n, info
      logical :: left(longest_period)

      call flow%setup(system, size(step) + 1, flow_order, flow_tolerance)
      call begin_tangents(flow, state)
      merit = huge(1.0_dp)
      do n = 1, longest_period
         call flow%start(frequency_ratio, 0.0_dp)
         call flow%advance(2*pi/frequency_ratio)
         if (system%interrupt%raised() .or. .not. all(abs(flow%x) < 1e100_dp)) exit
         call newton_step(state, flow%x(1, :), transpose(flow%x(2:, :)), step, info)
         if (info == 0 .and. maxval(abs(step)) < 1e100_dp) merit(n) = n*maxval(abs(step))
      end do
      left = .true.
      do n = 1, longest_period
         period(n) = minloc(merit, 1, left)
         left(period(n)) = .false.
      end do
   end function likely_periods

   !> Whether the flow from a state is still next to an orbit that repels at the rate `exponent`, where it is linear: it says
   !> nothing of what it will settle on.
   logical function is_leaving(system, frequency_ratio, state, exponent)
      type(system_type), intent(in) :: system
      !> Lambda, (state) at phase 0, largest Lyapunov exponent [1].
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
            call flow%start(frequency_ratio, 0.0_dp)
            call flow%advance(2*pi/frequency_ratio)
         end do
         is_leaving = maxval(abs(flow%x(1, :) - orbit - matmul(monodromy, state - orbit))) < 0.1_dp*maxval(abs(state - orbit))
         if (is_leaving) return
      end do
   end function is_leaving

   !> Rate at which the slowest direction decays, or the fastest grows, per unit of time [1].
   pure real(dp) function rate_of(multipliers, frequency_ratio, period)
      !> Largest magnitude first.
      complex(dp), intent(in) :: multipliers(:)
      real(dp), intent(in) :: frequency_ratio
      integer, intent(in) :: period

      rate_of = log(max(abs(multipliers(1)), tiny(1.0_dp)))*frequency_ratio/(2*pi*period)
   end function rate_of

   !> Work of carrying a state and its tangents [mesh periods of a state alone].
   pure real(dp) function work(periods, states)
      integer, intent(in) :: periods, states

      work = periods*(1 + states/states_a_state)
   end function work

   !> The shortest period of an orbit that repeats itself after `period` mesh periods.
   integer function shortest_period(system, frequency_ratio, period, state) result(n)
      type(system_type), intent(in) :: system
      real(dp), intent(in) :: frequency_ratio, state(:)
      integer, intent(in) :: period
      type(flow_type) :: flow

      call flow%setup(system, 1, flow_order, flow_tolerance)
      flow%x(1, :) = state
      do n = 1, period - 1
         call flow%start(frequency_ratio, 0.0_dp)
         call flow%advance(2*pi/frequency_ratio)
         if (system%interrupt%raised()) return
         if (mod(period, n) == 0 .and. maxval(abs(flow%x(1, :) - state)) < same*maxval(abs(state))) return
      end do
   end function shortest_period

end module geartrain_flow_settling
