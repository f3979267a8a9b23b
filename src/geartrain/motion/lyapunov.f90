!> The largest Lyapunov exponent of a motion that did not settle: positive is chaos, about zero a quasi-periodic motion (or one of a
!> train without damping), negative one that is still settling.
module geartrain_motion_lyapunov
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_observer, only: observer_type
   use geartrain_model_system, only: system_type
   use geartrain_motion_flow, only: flow_type
   use geartrain_motion_orbit, only: flow_order, flow_tolerance
   implicit none (type, external)
   private
   public :: largest_exponent, exponent_periods

   !> Share of the periods in which the tangent turns to the direction that grows fastest, not counted.
   real(dp), parameter :: settling = 0.2_dp
   !> Time over which growth is averaged [1] and fewest mesh periods.
   real(dp), parameter :: average_over = 3000
   integer, parameter :: fewest = 200

contains

   !> Mesh periods that an exponent takes, at most `most`.
   pure integer function exponent_periods(frequency, most)
      real(dp), intent(in) :: frequency
      integer, intent(in) :: most

      exponent_periods = min(most, max(fewest, ceiling(min(1e8_dp, average_over*frequency/(2*pi)))))
   end function exponent_periods

   !> Mean rate of growth per unit of time of a tangent that is carried along from `state` for some mesh periods and made
   !> a unit vector after each (Benettin). Not allocated where the observer or the state, which ran away, ended it.
   subroutine largest_exponent(system, frequency, state, periods, exponent, observer)
      type(system_type), intent(in) :: system
      real(dp), intent(in) :: frequency
      !> (2*elements) at phase 0.
      real(dp), intent(in) :: state(:)
      integer, intent(in) :: periods
      real(dp), allocatable, intent(out) :: exponent
      class(observer_type), intent(inout), optional :: observer
      type(flow_type) :: flow
      real(dp) :: growth, length
      integer :: k, first
      logical :: keep_going

      call flow%setup(system, 2, flow_order, flow_tolerance)
      flow%x(1, :) = state
      flow%x(2, :) = 1/sqrt(real(size(state), dp))
      first = int(settling*periods)
      growth = 0
      do k = 1, periods
         call flow%start(frequency, 0.0_dp)
         call flow%advance(2*pi/frequency)
         if (.not. all(abs(flow%x) < 1e100_dp)) return
         length = norm2(flow%x(2, :))
         if (.not. length > 0) return
         if (k > first) growth = growth + log(length)
         flow%x(2, :) = flow%x(2, :)/length
         if (.not. present(observer)) cycle
         keep_going = .true.
         call observer%on_step('settling', k, frequency, keep_going)
         if (.not. keep_going) return
      end do
      exponent = growth/((periods - first)*2*pi/frequency)
   end subroutine largest_exponent

end module geartrain_motion_lyapunov
