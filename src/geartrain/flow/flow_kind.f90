!> Kind of a motion without known period, by its largest Lyapunov exponent and the trend of its sections.
!>
!> The exponent alone does not separate a torus from a slow vibration that dies out: its uncertainty over N periods often is several
!> times 1/N. An undamped vibration that nothing excites even has the exponent 0 while others die out. The sections show both.
module geartrain_flow_flow_kind
   use geartrain_base_kinds, only: dp, pi
   use geartrain_floquet_multipliers, only: eigenvalues, is_neutral
   use geartrain_flow_attractor_search, only: most_states, most_steps
   use geartrain_flow_lyapunov, only: largest_neutral, outgrows
   use geartrain_flow_section_trend, only: section_trend_type
   use geartrain_flow_settling, only: is_leaving, is_linear
   use geartrain_flow_shooting, only: find_orbit
   use geartrain_flow_tangent_flight, only: tangent_flight_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: flow_kind

   !> Magnitude of an exponent over Lambda that is rounding [1]: tangents of a motion without damping keep their length to this.
   real(dp), parameter :: rounding = 1e-13_dp
   !> Change of the logarithm of the energy of differences that no torus shows: of 100 flights on tori the largest was 0.36.
   real(dp), parameter :: large = 0.7_dp
   !> Largest change on a torus, over a flight that is long enough to tell.
   real(dp), parameter :: small = 0.2_dp
   !> Least change over the change that the multipliers of the orbit predict.
   real(dp), parameter :: least_share = 0.5_dp

contains

   !> Kind of a motion, see `kind` of geartrain_balance_motion.
   character(14) function flow_kind(system, frequency_ratio, state, exponent, error, trend) result(kind)
      type(system_type), target, intent(in) :: system
      !> Lambda [1]; state at phase 0 of the flight [1], (state).
      real(dp), intent(in) :: frequency_ratio, state(:)
      !> Largest Lyapunov exponent and its uncertainty, per unit of time [1].
      real(dp), intent(in) :: exponent, error
      !> Trend of the sections of the flight over which the exponent was averaged.
      type(section_trend_type), intent(inout) :: trend

      call trend%measure()
      kind = 'undecided'
      if (error < largest_neutral*frequency_ratio/(2*pi)) kind = 'quasi-periodic'
      if (exponent > max(error, rounding*frequency_ratio) .and. outgrows(frequency_ratio, exponent, trend%periods)) &
         kind = 'chaotic'
      if (exponent < -max(error, rounding*frequency_ratio)) kind = 'still settling'
      ! A motion that has not yet left an unstable orbit has the exponent of the orbit, and may still settle on a regular motion.
      if (kind == 'chaotic') then
         if (is_leaving(system, frequency_ratio, state, exponent)) kind = 'still settling'
      end if
      if (kind == 'quasi-periodic') call check_trend(system, frequency_ratio, trend%last(), trend, kind)
   end function flow_kind

   !> Changes the kind of a motion that looks quasi-periodic by its exponent, where the sections shrink or grow.
   subroutine check_trend(system, frequency_ratio, state, trend, kind)
      type(system_type), target, intent(in) :: system
      !> Lambda [1]; last state of the flight [1], (state).
      real(dp), intent(in) :: frequency_ratio, state(:)
      type(section_trend_type), intent(inout) :: trend
      character(*), intent(inout) :: kind
      integer :: n

      kind = 'undecided'
      if (size(trend%change) == 0) return
      kind = 'still settling'
      associate (change => trend%change, error => trend%error)
         if (any(abs(change) > large .and. error < abs(change)/2)) return
         if (size(state) <= most_states) then
            ! The orbit of the clearest change, or of period 1, from which all changes may come.
            n = maxloc(abs(change)/max(error, tiny(1.0_dp)), 1)
            if (nears(n)) return
            if (n > 1) then
               if (nears(1)) return
            end if
         end if
         kind = 'quasi-periodic'
         if (abs(change(1)) + error(1) > small) kind = 'undecided'
      end associate

   contains

      !> Whether the flight comes to an orbit of n periods, or leaves it, at the rate that its sections show.
      logical function nears(n)
         integer, intent(in) :: n
         real(dp) :: orbit(size(state)), monodromy(size(state), size(state)), power(size(state), size(state)), length, predicted
         complex(dp) :: multipliers(size(state))
         type(tangent_flight_type) :: flight
         logical :: found

         nears = .false.
         if (.not. trend%error(n) < abs(trend%change(n))/2) return
         orbit = state
         call flight%setup(system)
         call find_orbit(flight, frequency_ratio, n, most_steps, orbit, monodromy, length, found)
         if (.not. found) return
         power = monodromy
         call eigenvalues(power, multipliers)
         if (is_neutral(multipliers)) return
         predicted = 2*log(max(abs(multipliers(1)), tiny(1.0_dp)))*trend%periods/n
         if (.not. trend%change(n)/predicted > least_share) return
         nears = is_linear(system, frequency_ratio, n, state, orbit, monodromy)
      end function nears

   end subroutine check_trend

end module geartrain_flow_flow_kind
