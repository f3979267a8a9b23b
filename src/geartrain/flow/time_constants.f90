!> Settling by the time constants of a train, where its common period is too long to settle from period to period.
!>
!> A free vibration of the mean system falls to a ten-thousandth of its size in 9 of its time constants. Where all do in a moderate
!> time, the flow is followed for that time. Slower ones, as of a rotor against a generator on soft shafts, whose damping is a
!> thousandth, are taken out of the state (geartrain_flow_slow_modes) at four instants on the way. The result has
!> their amplitude at the last instant beside its figures. Modes have no dry friction. A second flow then begins beside the first,
!> and the share of their distance that remains takes the place of the amplitude.
!>
!> Settling begins before phase 0, so that it ends there. The figures are then those of a window from phase 0 on
!> (geartrain_flow_window), with what a longer window would change (geartrain_flow_uncertainty). In the time of settling all meshes
!> go through nearly whole cycles. So a state of phase 0, as a sweep hands on, is nearly on its orbit where settling begins.
module geartrain_flow_time_constants
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_observer, only: observer_type
   use geartrain_flow_bound, only: bound_type
   use geartrain_flow_disturbance, only: disturb
   use geartrain_flow_energy, only: energy_type
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_integration_settings, only: integration_settings_type, most_periods
   use geartrain_flow_lyapunov, only: exponent_of, settled_part
   use geartrain_flow_orbit, only: flow_order, flow_tolerance, measure
   use geartrain_flow_slow_modes, only: slow_modes_type, stretches
   use geartrain_flow_window, only: cycle_time, window_of
   use geartrain_network_excitation, only: highest_order, nearest_return
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: find_in_window, negligible, settle_by_time, settled_type, settling_time

   !> Limits of the time to settle [cycles of the slowest mesh].
   integer, parameter :: fewest_cycles = 50, most_cycles = 1000
   !> What may be left of slow free vibrations of a motion that has settled, over its alternating displacement [1].
   real(dp), parameter :: negligible = 1e-3_dp

   !> How much longer settling may take for the meshes to go through nearly whole cycles [1].
   real(dp), parameter :: longer = 0.25_dp

   !> Difference of two means that is none, over the alternating displacement [1].
   real(dp), parameter :: beside = 0.02_dp

   !> How settling ended.
   type :: settled_type
      !> The state has settled: what is left of slow free vibrations is negligible.
      logical :: steady = .false.
      !> Amplitude of slow free vibrations when they were last read over the alternating displacement (root of twice the mean
      !> square), the largest of all meshes [1]; negative: some mode is too slow to be read.
      real(dp) :: ringing = 0
      !> Mean of each mesh displacement over the last quarter of settling [1], (mesh).
      real(dp), allocatable :: mean(:)
      !> Time of settling [1].
      real(dp) :: time = 0
      !> The motion grows without bound.
      logical :: unbounded = .false.
      !> The observer or an interrupt ended it.
      logical :: stopped = .false.
      !> Too many contact events fell on one instant: the state is a guess.
      logical :: lost = .false.
   end type settled_type

contains

   !> Time for which the flow settles [1]: it begins at minus this time.
   real(dp) function settling_time(system, frequency_ratio, max_periods)
      type(system_type), intent(in) :: system
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Most periods of the fundamental.
      integer, intent(in) :: max_periods
      type(slow_modes_type) :: slow

      call find_slow_modes(system, frequency_ratio, max_periods, slow)
      settling_time = slow%time
   end function settling_time

   !> Finds the time to settle and the modes that do not die out within it.
   subroutine find_slow_modes(system, frequency_ratio, max_periods, slow)
      type(system_type), intent(in) :: system
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Most periods of the fundamental.
      integer, intent(in) :: max_periods
      type(slow_modes_type), intent(out) :: slow
      real(dp) :: cycle, fastest, limit, longest
      integer :: least, most

      cycle = cycle_time(system, frequency_ratio)
      limit = max_periods*minval(system%law%order)*cycle
      longest = min(most_cycles*cycle, limit)
      call slow%setup(system, min(longest, fewest_cycles*cycle), longest)
      fastest = 2*pi/(frequency_ratio*highest_order(system))
      least = nint(slow%time/fastest)
      most = max(least, floor(min((1 + longer)*slow%time, limit)/fastest))
      slow%time = fastest*nearest_return(system, least, most)
   end subroutine find_slow_modes

   !> Follows the flow for some time constants, up to phase 0.
   subroutine settle_by_time(system, frequency_ratio, max_periods, state, settled, observer)
      type(system_type), target, intent(in) :: system
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Most periods of the fundamental.
      integer, intent(in) :: max_periods
      !> State to begin with, then at phase 0 [1], (state).
      real(dp), intent(inout) :: state(:)
      !> How it ended.
      type(settled_type), intent(out) :: settled
      !> Told of 'settling by time' after each cycle of the slowest mesh; may end the flow.
      class(observer_type), intent(inout), optional :: observer
      type(flow_type) :: flow
      type(bound_type) :: bound
      type(slow_modes_type) :: slow
      type(energy_type) :: energy
      real(dp) :: cycle, limit, origin, moment(2, system%meshes), alternating(system%meshes)
      !> Logarithms of the largest distance of a neighbouring flow, by its kinetic energy, in the first and in the present stretch,
      !> and of what it was divided by.
      real(dp) :: first, distance, divided
      integer :: i
      logical :: two_flows

      cycle = cycle_time(system, frequency_ratio)
      call find_slow_modes(system, frequency_ratio, max_periods, slow)
      settled%time = slow%time
      call bound%setup(system, frequency_ratio)
      limit = bound%limit(state)
      two_flows = any(system%friction > 0)
      call flow%setup(system, merge(2, 1, two_flows), flow_order, flow_tolerance)
      ! The symmetric motion of a symmetric train may repel, and a flow without any disturbance would stay on it.
      call disturb(system, state)
      flow%x(1, :) = state
      if (two_flows) then
         call energy%setup(system)
         flow%x(2, :) = energy%state(spread(1.0_dp, 1, size(state)))
         divided = 0
      end if
      do i = 1, stretches
         origin = -slow%time*(stretches - i + 1)/stretches
         distance = -huge(1.0_dp)
         call fly(origin, -slow%time*(stretches - i)/stretches)
         if (settled%stopped) exit
         settled%unbounded = .not. bound%holds(flow%x(1, :), limit)
         if (settled%unbounded) exit
         if (i == 1) first = distance
         call slow%take_out(flow%x(1, :))
      end do
      state = flow%x(1, :)
      settled%lost = flow%lost
      if (settled%stopped .or. settled%unbounded) return
      settled%mean = moment(1, :)
      alternating = sqrt(2*max(moment(2, :) - moment(1, :)**2, 0.0_dp))
      settled%ringing = maxval(slow%ringing(system)/max(alternating, tiny(1.0_dp)))
      if (two_flows) settled%ringing = exp(min(0.0_dp, max(-100.0_dp, distance - first)))
      settled%steady = settled%ringing <= negligible .and. (two_flows .or. .not. slow%unread)
      if (slow%unread .and. .not. two_flows) settled%ringing = -1

   contains

      !> Flies over a stretch; reads slow modes and the mean and mean square of mesh displacements.
      subroutine fly(begin, end)
         real(dp), intent(in) :: begin, end
         real(dp) :: next, value
         integer :: j, k
         logical :: keep_going

         moment = 0
         keep_going = .true.
         call slow%begin_reading(begin, end)
         call flow%start(frequency_ratio, begin)
         next = begin
         do while (flow%time < end)
            call flow%step(end)
            settled%stopped = system%interrupt%raised() .or. .not. keep_going
            if (settled%stopped .or. flow%x(1, 1) >= huge(1.0_dp)) return
            call slow%read_step(flow)
            if (two_flows) call measure_distance()
            do j = 1, system%meshes
               do k = 1, 2
                  value = flow%displacement(j, flow%length*(k - 0.5_dp)/2)
                  moment(:, j) = moment(:, j) + flow%length/2/(end - begin)*[value, value**2]
               end do
            end do
            if (.not. present(observer) .or. flow%time < next) cycle
            next = flow%time + cycle
            call observer%on_step('settling by time', int((flow%time + slow%time)/cycle), frequency_ratio, keep_going)
         end do
      end subroutine fly

      !> Takes the distance of the neighbouring flow; a coupling that sticks keeps its twist for good, which has no kinetic energy.
      subroutine measure_distance()
         real(dp) :: length

         associate (y => energy%coordinates(flow%x(2, :)))
            length = norm2(y(system%displacements + 1:))
         end associate
         if (.not. length > 0) return
         distance = max(distance, log(length) + divided)
         if (length < 1e100_dp .and. length > 1e-100_dp) return
         flow%x(2, :) = flow%x(2, :)/length
         divided = divided + log(length)
      end subroutine measure_distance

   end subroutine settle_by_time

   !> Settles by the time constants, and finds the figures of a window.
   subroutine find_in_window(system, frequency_ratio, settings, state, motion, observer, stopped)
      type(system_type), target, intent(in) :: system
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Of which max_periods, window and harmonics are used.
      type(integration_settings_type), intent(in) :: settings
      !> Start, then state of the motion at phase 0 [1], (state).
      real(dp), intent(inout) :: state(:)
      !> The motion, of period 0; one that grows without bound has a state, but neither coefficients nor figures.
      type(motion_type), intent(out) :: motion
      !> Told of 'settling by time' after each cycle of the slowest mesh; may end the flow.
      class(observer_type), intent(inout), optional :: observer
      !> Whether the observer or an interrupt ended the flow before the motion was known.
      logical, intent(out) :: stopped
      type(settled_type) :: settled
      logical :: regular, drifts

      call settle_by_time(system, frequency_ratio, most_periods(system, settings%max_periods), state, settled, observer)
      motion%frequency_ratio = frequency_ratio
      motion%period = 0
      motion%state = state
      motion%undecided = settled%lost
      motion%kind = 'unbounded'
      stopped = settled%stopped
      if (stopped .or. settled%unbounded) return
      motion%window = window_of(system, settings%window)
      call measure(system, settings%harmonics, motion, observer, stopped)
      stopped = stopped .or. system%interrupt%raised()
      if (stopped) return
      motion%ringing = settled%ringing
      call include_ringing(motion)
      call include_drift(system, settled%mean, motion, drifts)
      regular = .not. any((motion%mesh_load%separation > 0 .and. motion%mesh_load%separation < 1) .or. &
                          (motion%mesh_load%back_contact > 0 .and. motion%mesh_load%back_contact < 1)) &
                .and. .not. any(system%friction > 0)
      motion%kind = 'still settling'
      settled%steady = settled%steady .and. .not. drifts
      if (settled%steady) motion%kind = 'stationary'
      ! A flow that passed over an event is a guess from there on.
      if (motion%undecided) motion%kind = 'undecided'
      if (motion%undecided) return
      ! While all teeth stay in contact the equations are linear, and neighbouring flows approach one another as the flow settles.
      if (regular) return
      call find_growth(system, motion, observer, stopped)
      if (stopped .or. .not. allocated(motion%lyapunov_exponent)) return
      if (motion%lyapunov_exponent > motion%lyapunov_error) then
         motion%kind = 'chaotic'
      else if (.not. (settled%steady .or. motion%lyapunov_exponent < -motion%lyapunov_error)) then
         motion%kind = 'undecided'
      end if
   end subroutine find_in_window

   !> Adds what is left of slow free vibrations to the uncertainty of the displacements.
   pure subroutine include_ringing(motion)
      type(motion_type), intent(inout) :: motion

      associate (u => motion%uncertainty, left => max(motion%ringing, 0.0_dp)*motion%rms)
         u%rms = u%rms + left
         u%minimum = u%minimum + left
         u%maximum = u%maximum + left
      end associate
   end subroutine include_ringing

   !> Whether some mesh has another mean than at the end of settling, by more than is uncertain, as an idle gear that drifts in its
   !> gap. The uncertainty of mean and extremes then includes what such a drift makes of a window ten times as long, but for the
   !> width of the gap.
   pure subroutine include_drift(system, before, motion, drifts)
      type(system_type), intent(in) :: system
      !> Mean of each displacement at the end of settling [1], (mesh).
      real(dp), intent(in) :: before(:)
      type(motion_type), intent(inout) :: motion
      logical, intent(out) :: drifts
      real(dp) :: change(system%meshes), width(system%meshes)

      associate (u => motion%uncertainty)
         change = abs(motion%mean - before)
         where (change <= 2*u%mean + beside*motion%rms) change = 0
         drifts = any(change > 0)
         width = 2*system%half_backlash + motion%rms
         change = min(10*change, width)
         u%mean = u%mean + change
         u%minimum = u%minimum + change
         u%maximum = u%maximum + change
      end associate
   end subroutine include_drift

   !> Finds the rate at which a neighbouring flow leaves or approaches over the window, with its uncertainty.
   subroutine find_growth(system, motion, observer, stopped)
      type(system_type), target, intent(in) :: system
      !> Given: frequency_ratio, window and state. Gets lyapunov_exponent, unless the state runs away, and lyapunov_error.
      type(motion_type), intent(inout) :: motion
      class(observer_type), intent(inout), optional :: observer
      logical, intent(out) :: stopped
      type(flow_type) :: flow
      type(energy_type) :: energy
      real(dp), allocatable :: growth(:)
      real(dp) :: cycle, length, exponent
      integer :: k, first
      logical :: keep_going

      stopped = .false.
      cycle = cycle_time(system, motion%frequency_ratio)
      allocate (growth(max(6, nint(motion%window*minval(system%law%order)))))
      call energy%setup(system)
      call flow%setup(system, 2, flow_order, flow_tolerance)
      flow%x(1, :) = motion%state
      flow%x(2, :) = 1
      flow%x(2, :) = flow%x(2, :)/norm2(energy%coordinates(flow%x(2, :)))
      call flow%start(motion%frequency_ratio, 0.0_dp)
      do k = 1, size(growth)
         call flow%advance(k*cycle)
         keep_going = .true.
         if (present(observer)) call observer%on_step('settling by time', k, motion%frequency_ratio, keep_going)
         stopped = system%interrupt%raised() .or. .not. keep_going
         if (stopped .or. .not. all(abs(flow%x) < 1e100_dp)) return
         length = norm2(energy%coordinates(flow%x(2, :)))
         if (.not. length > 0) return
         growth(k) = log(length)/cycle
         flow%x(2, :) = flow%x(2, :)/length
      end do
      first = size(growth)/5 + 1
      first = first + settled_part(growth(first:), motion%frequency_ratio*minval(system%law%order)) - 1
      call exponent_of(growth(first:), exponent, motion%lyapunov_error)
      motion%lyapunov_exponent = exponent
   end subroutine find_growth

end module geartrain_flow_time_constants
