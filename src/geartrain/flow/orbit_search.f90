!> Finds periodic orbits near the flow from rest, attracting or repelling, as starts of a branch where the flow does not settle on a
!> motion of the wanted period.
module geartrain_flow_orbit_search
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_same_motion, only: is_same_motion
   use geartrain_base_kinds, only: dp
   use geartrain_base_observer, only: observer_type
   use geartrain_flow_attractor_search, only: most_states
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_orbit, only: flow_order, flow_tolerance, measure
   use geartrain_flow_shooting, only: find_orbit
   use geartrain_flow_start_state, only: resting_state
   use geartrain_flow_tangent_flight, only: tangent_flight_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: orbit_search_type

   !> Most Newton steps of a try.
   integer, parameter :: most_steps = 15

   type :: orbit_search_type
      !> Lambda [1].
      real(dp), private :: frequency_ratio = 1
      !> Longest period [periods of the fundamental]; harmonics of Lambda in the coefficients of an orbit.
      integer, private :: longest = 1, harmonics = 1
      !> Most sections from which Newton's method is tried.
      integer, private :: most_sections = 0
      !> Mesh periods so far; number of the next try from the present section: tries 2*n - 1 and 2*n are for period n.
      integer, private :: periods = 0, trial = 1
      !> The latest sections [1], the newest first, (state, 0:longest).
      real(dp), allocatable, private :: section(:, :)
      !> States of the orbits found, (state, orbit).
      real(dp), allocatable, private :: known(:, :)
      type(flow_type), private :: flow
      type(tangent_flight_type), private :: flight
   contains
      procedure :: begin
      procedure :: next
   end type orbit_search_type

contains

   !> Begins a search from rest.
   subroutine begin(self, system, frequency_ratio, longest, harmonics, most_sections)
      class(orbit_search_type), intent(inout) :: self
      type(system_type), pointer, intent(in) :: system
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Periods [periods of the fundamental] of the orbits are divisors of `longest`; harmonics of Lambda in their coefficients.
      integer, intent(in) :: longest, harmonics
      !> Most sections from which Newton's method is tried: of a train of eight meshes 128 take two seconds.
      integer, intent(in) :: most_sections

      self%frequency_ratio = frequency_ratio
      self%longest = longest
      self%harmonics = harmonics
      self%most_sections = most_sections
      self%periods = 0
      self%trial = 2*longest + 1
      call self%flow%setup(system, 1, flow_order, flow_tolerance)
      call self%flight%setup(system)
      self%flow%x(1, :) = resting_state(system)
      if (allocated(self%section)) deallocate (self%section)
      allocate (self%section(size(self%flow%x, 2), 0:longest))
      self%section = spread(self%flow%x(1, :), 2, longest + 1)
      if (allocated(self%known)) deallocate (self%known)
      allocate (self%known(size(self%flow%x, 2), 0))
   end subroutine begin

   !> Finds the next orbit that was not found before.
   subroutine next(self, motion, found, stopped, observer)
      class(orbit_search_type), intent(inout) :: self
      !> The orbit, without multipliers.
      type(motion_type), intent(out) :: motion
      !> .false.: all sections are used, the flow ran away, the train has too many states, or the search was stopped.
      logical, intent(out) :: found
      !> The observer or an interrupt ended the search.
      logical, intent(out) :: stopped
      !> Called after each period of the fundamental, as 'settling'.
      class(observer_type), intent(inout), optional :: observer
      real(dp) :: state(size(self%flow%x, 2)), monodromy(size(self%flow%x, 2), size(self%flow%x, 2)), length
      logical :: keep_going
      integer :: i

      found = .false.
      stopped = .false.
      if (size(state) > most_states) return
      do
         if (self%trial > 2*self%longest) then
            if (self%periods == self%most_sections) return
            self%periods = self%periods + 1
            self%trial = 1
            call self%flow%pass_period(self%frequency_ratio)
            stopped = self%flow%system%interrupt%raised()
            if (stopped .or. .not. all(abs(self%flow%x) < 1e100_dp)) return
            self%section = eoshift(self%section, -1, dim=2)
            self%section(:, 0) = self%flow%x(1, :)
            keep_going = .true.
            if (present(observer)) call observer%on_step('settling', self%periods, self%frequency_ratio, keep_going)
            stopped = .not. keep_going
            if (stopped) return
         end if
         motion%period = (self%trial + 1)/2
         self%trial = self%trial + 1
         if (mod(self%longest, motion%period) /= 0) cycle
         state = self%section(:, 0)
         ! An orbit that became unstable by a period doubling lies between the two halves of the period-doubled orbit.
         if (mod(self%trial, 2) > 0) state = (state + self%section(:, motion%period))/2
         call find_orbit(self%flight, self%frequency_ratio, motion%period, most_steps, state, monodromy, length, found)
         if (.not. found) cycle
         found = .not. any([(is_same_motion(state, self%known(:, i)), i=1, size(self%known, 2))])
         if (.not. found) cycle
         self%known = reshape([self%known, state], [size(state), size(self%known, 2) + 1])
         motion%frequency_ratio = self%frequency_ratio
         motion%state = state
         motion%error_estimate = length
         call measure(self%flow%system, self%harmonics, motion)
         return
      end do
   end subroutine next

end module geartrain_flow_orbit_search
