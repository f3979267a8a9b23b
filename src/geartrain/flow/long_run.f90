!> What a flow does in the long run: sections of its attractor at phase 0, their period, Lyapunov exponents, rotation number.
module geartrain_flow_long_run
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use geartrain_base_kinds, only: dp, pi
   use geartrain_flow_bound, only: bound_type
   use geartrain_flow_disturbance, only: disturb
   use geartrain_flow_flow_kind, only: flow_kind
   use geartrain_flow_kept_states, only: judge, keeps
   use geartrain_flow_orbit, only: propagate
   use geartrain_flow_section_map, only: section_map_type
   use geartrain_flow_section_trend, only: section_trend_type
   use geartrain_flow_shooting, only: find_orbit
   use geartrain_flow_spectrum, only: lyapunov_spectrum, rotation_number
   use geartrain_flow_tangent_flight, only: tangent_flight_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: find_long_run

   !> Relative difference of sections that repeat themselves; of sections that differ, and do not turn about an orbit as they settle
   !> on it.
   real(dp), parameter :: repeated_to = 1e-6_dp, clearly_different = 1e-4_dp
   !> Uncertainty of multipliers relative to the largest: rounding, and its square root where two of them meet. Least size of those
   !> that are known, relative to the largest.
   real(dp), parameter :: rounding = 1e-7_dp, smallest = 1e-6_dp
   !> Most steps of Newton's method to an orbit.
   integer, parameter :: most_steps = 10
   !> Most disturbances of a flow that rests on orbits that repel.
   integer, parameter :: most_disturbances = 3

contains

   !> Flies from a state, and looks at the sections after a transient. A flow that rests on an orbit that repels is disturbed, and
   !> flies anew from there.
   subroutine find_long_run(system, frequency_ratio, transient, state, sections, exponents, errors, period, kind, rotation)
      type(system_type), target, intent(in) :: system
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Periods of the fundamental before the sections.
      integer, intent(in) :: transient
      !> State at phase 0 to begin with, then the last one [1], (state); huge where the motion grew without bound.
      real(dp), intent(inout) :: state(:)
      !> States at phase 0 of successive periods [1], (state, section); NaN where there are none.
      real(dp), intent(out) :: sections(:, :)
      !> Lyapunov exponents per unit of time, largest first, and their uncertainty at 95 % [1], (state); NaN where there are none.
      real(dp), intent(out) :: exponents(:), errors(:)
      !> Period [periods of the fundamental]; 0: none found.
      integer, intent(out) :: period
      !> As of motion_type.
      character(*), intent(out) :: kind
      !> Rotation number [1]; NaN: not quasi-periodic.
      real(dp), intent(out) :: rotation
      type(section_map_type) :: map
      type(bound_type) :: bound
      type(section_trend_type) :: trend
      real(dp) :: limit, turns
      integer :: i
      logical :: lost, repels

      call map%setup(system, frequency_ratio)
      call bound%setup(system, frequency_ratio)
      limit = bound%limit(state)
      rotation = ieee_value(rotation, ieee_quiet_nan)
      period = 0
      do i = 0, most_disturbances
         call fly()
         if (lost) then
            sections = rotation
            exponents = rotation
            errors = rotation
            kind = 'undecided'
            if (bound%holds(state, limit)) return
            kind = 'unbounded'
            state = huge(limit)
            return
         end if
         period = period_of(sections)
         repels = .false.
         if (period > 0) call look_at_orbit(system, frequency_ratio, period, state, exponents, errors, repels)
         if (.not. repels .or. i == most_disturbances) exit
         call disturb(system, state)
      end do
      kind = 'periodic'
      if (repels) then
         kind = 'still settling'
         period = 0
         return
      end if
      if (period == 0) kind = flow_kind(system, frequency_ratio, state, exponents(1), errors(1), trend)
      if (kind == 'quasi-periodic') then
         turns = rotation_number(system, sections)
         if (turns >= 0) rotation = turns
      end if

   contains

      !> Flies the transient, then the sections.
      subroutine fly()
         integer :: k

         lost = .false.
         do k = 1, transient
            call map%pass_period(state, lost)
            lost = lost .or. system%interrupt%raised() .or. .not. bound%holds(state, limit)
            if (lost) return
         end do
         call lyapunov_spectrum(system, map, state, size(sections, 2), exponents, errors, lost, sections, trend)
      end subroutine fly

   end subroutine find_long_run

   !> The multipliers of an orbit give its Lyapunov exponents and replace the averages. Multipliers that are small beside the
   !> largest are rounding: their averages stay.
   subroutine look_at_orbit(system, frequency_ratio, period, state, exponents, errors, repels)
      type(system_type), target, intent(in) :: system
      !> Lambda [1]; a state near the orbit at phase 0 [1], (state).
      real(dp), intent(in) :: frequency_ratio, state(:)
      !> Period [periods of the fundamental].
      integer, intent(in) :: period
      !> See `find_long_run`.
      real(dp), intent(inout) :: exponents(:), errors(:)
      !> Whether a multiplier is outside the unit circle.
      logical, intent(out) :: repels
      type(tangent_flight_type) :: flight
      real(dp) :: orbit(size(state)), monodromy(size(state), size(state)), size_(size(state)), length, rate
      complex(dp) :: multipliers(size(state))
      logical :: found, stable, undecided

      orbit = state
      call flight%setup(system, exact=.true.)
      call find_orbit(flight, frequency_ratio, period, most_steps, orbit, monodromy, length, found)
      ! Newton's method may have gone to another one.
      if (found) found = maxval(abs(orbit - state)) < clearly_different*maxval(abs(state))
      if (.not. found) call propagate(system, frequency_ratio, period, state, orbit, monodromy)
      call judge(monodromy, multipliers, stable, undecided)
      repels = .not. (stable .or. undecided)
      if (.not. found .or. any(keeps(monodromy))) return
      rate = frequency_ratio/(2*pi*period)
      size_ = max(abs(multipliers), tiny(rate))
      where (size_ > smallest*maxval(size_))
         exponents = rate*log(size_)
         errors = rate*rounding*maxval(size_)/size_
      end where
   end subroutine look_at_orbit

   !> Shortest period after which the last half of the sections repeats itself; 0: none, or it is not sure which.
   pure integer function period_of(sections) result(period)
      real(dp), intent(in) :: sections(:, :)
      integer :: n, half
      real(dp) :: size_, difference, smallest

      n = size(sections, 2)
      half = n/2
      size_ = maxval(abs(sections))
      smallest = huge(1.0_dp)
      do period = 1, half
         difference = maxval(abs(sections(:, n - half + 1:) - sections(:, n - half + 1 - period:n - period)))
         if (difference <= repeated_to*size_) then
            if (smallest < clearly_different*size_) exit
            return
         end if
         smallest = min(smallest, difference)
      end do
      period = 0
   end function period_of

end module geartrain_flow_long_run
