!> Largest Lyapunov exponent of a motion without known period, and its uncertainty.
module geartrain_flow_lyapunov
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_observer, only: observer_type
   use geartrain_flow_energy, only: energy_type
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_orbit, only: flow_order, flow_tolerance
   use geartrain_flow_section_trend, only: section_trend_type
   use geartrain_flow_smooth_mean, only: weighted_mean
   use geartrain_network_system, only: system_type
   use geartrain_network_units, only: mesh_frequencies
   implicit none (type, external)
   private
   public :: exponent_of, find_exponent, largest_exponent, largest_neutral, outgrows, settled_part

   !> Share of the periods that is not averaged: the tangent turns to the direction that grows fastest.
   real(dp), parameter :: turning = 0.2_dp
   !> Length of the first average: time, in which the slowest mesh vibrates alone by so many radians [1], and fewest periods of the
   !> fundamental.
   real(dp), parameter :: average_over = 3000
   integer, parameter :: fewest = 200
   !> Uncertainty times period of the fundamental [1]: largest that tells a quasi-periodic motion, and change of the exponent over
   !> an average that is small; smallest that is worth a longer
   !> average.
   real(dp), parameter :: largest_neutral = 2e-3_dp, precise = 1e-4_dp
   !> Fewest periods of a half of an average that is looked at alone.
   integer, parameter :: shortest_half = 60
   !> Blocks whose averages give the uncertainty; Student's t at 95 % for blocks - 1 degrees of freedom.
   integer, parameter :: blocks = 6
   real(dp), parameter :: student = 2.57_dp

contains

   !> Averages over 500 vibrations of the slowest mesh or 200 periods of the fundamental, whichever is longer, then over twice the
   !> time, and so on, until the sign of the exponent is known, or the exponent is known to be about 0.
   subroutine find_exponent(system, frequency_ratio, state, most, exponent, error, trend, observer)
      type(system_type), intent(in) :: system
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> State at phase 0 [1], (state).
      real(dp), intent(in) :: state(:)
      !> Most periods of the fundamental.
      integer, intent(in) :: most
      !> Exponent per unit of time [1]; not allocated where the observer or an interrupt ended the flow, or the state ran away.
      real(dp), allocatable, intent(out) :: exponent
      !> Uncertainty of the exponent at 95 %, per unit of time [1].
      real(dp), intent(out) :: error
      !> Trend of the sections of the flow.
      type(section_trend_type), intent(out) :: trend
      !> Called after each period of the fundamental, as 'settling'.
      class(observer_type), intent(inout), optional :: observer
      integer :: first

      first = max(fewest, ceiling(min(1e8_dp, average_over*frequency_ratio/(2*pi*minval(mesh_frequencies(system))))))
      call average(system, frequency_ratio, state, min(first, most), most, exponent, error, trend, observer)
   end subroutine find_exponent

   !> Averages over a given number of periods of the fundamental.
   subroutine largest_exponent(system, frequency_ratio, state, periods, exponent, error, observer)
      type(system_type), intent(in) :: system
      !> Lambda [1]; state at phase 0 [1], (state).
      real(dp), intent(in) :: frequency_ratio, state(:)
      !> Number of periods of the fundamental.
      integer, intent(in) :: periods
      !> See `find_exponent`.
      real(dp), allocatable, intent(out) :: exponent
      !> Uncertainty of the exponent at 95 %, per unit of time [1].
      real(dp), intent(out) :: error
      !> Called after each period of the fundamental, as 'settling'.
      class(observer_type), intent(inout), optional :: observer
      type(section_trend_type) :: trend

      call average(system, frequency_ratio, state, periods, periods, exponent, error, trend, observer)
   end subroutine largest_exponent

   !> Carries a tangent along with the flow and scales the tangent to unit energy after each period of the fundamental (Benettin's
   !> method).
   subroutine average(system, frequency_ratio, state, least, most, exponent, error, trend, observer)
      type(system_type), target, intent(in) :: system
      real(dp), intent(in) :: frequency_ratio, state(:)
      !> Mesh periods after which the average may end; periods of the fundamental after which it ends.
      integer, intent(in) :: least, most
      real(dp), allocatable, intent(out) :: exponent
      real(dp), intent(out) :: error
      type(section_trend_type), intent(out) :: trend
      class(observer_type), intent(inout), optional :: observer
      type(flow_type) :: flow
      type(energy_type) :: energy
      real(dp), allocatable :: growth(:)
      real(dp) :: length, value
      integer :: first, k, next
      logical :: keep_going

      error = 0
      call energy%setup(system)
      call trend%begin(system)
      call flow%setup(system, 2, flow_order, flow_tolerance)
      flow%x(1, :) = state
      flow%x(2, :) = 1
      flow%x(2, :) = flow%x(2, :)/norm2(energy%coordinates(flow%x(2, :)))
      next = least
      allocate (growth(next), source=0.0_dp)
      do k = 1, most
         call flow%pass_period(frequency_ratio)
         if (system%interrupt%raised() .or. .not. all(abs(flow%x) < 1e100_dp)) return
         length = norm2(energy%coordinates(flow%x(2, :)))
         if (.not. length > 0) return
         growth(k) = log(length)*frequency_ratio/(2*pi)
         flow%x(2, :) = flow%x(2, :)/length
         call trend%add(flow%x(1, :))
         if (k >= next) then
            first = int(turning*k) + 1
            first = first + settled_part(growth(first:k), frequency_ratio) - 1
            trend%first = first
            call exponent_of(growth(first:k), value, error)
            if (k == most .or. value < -error .or. error < precise*frequency_ratio/(2*pi)) exit
            if (value > error .and. outgrows(frequency_ratio, value, k - first + 1)) exit
            next = min(2*next, most)
            growth = [growth, spread(0.0_dp, 1, next - k)]
         end if
         if (.not. present(observer)) cycle
         keep_going = .true.
         call observer%on_step('settling', k, frequency_ratio, keep_going)
         if (.not. keep_going) return
      end do
      exponent = value
   end subroutine average

   !> Whether tangents grow by more than on a torus, where neighbouring flows may part in proportion to time.
   pure logical function outgrows(frequency_ratio, exponent, periods)
      !> Lambda [1]; exponent per unit of time [1].
      real(dp), intent(in) :: frequency_ratio, exponent
      !> Periods of the fundamental that the exponent is averaged over.
      integer, intent(in) :: periods

      outgrows = exponent*periods*2*pi/frequency_ratio > log(real(periods, dp))
   end function outgrows

   !> First period of the last part whose halves agree: the motion may come to its attractor long after the average begins.
   pure integer function settled_part(growth, frequency_ratio) result(first)
      !> Rate of growth over each period of the fundamental [1]; Lambda [1].
      real(dp), intent(in) :: growth(:), frequency_ratio
      real(dp) :: early, late, error_early, error_late
      integer :: middle

      first = 1
      do
         middle = (first + size(growth))/2 + 1
         if (size(growth) - middle < shortest_half) return
         call exponent_of(growth(first:middle - 1), early, error_early)
         call exponent_of(growth(middle:), late, error_late)
         ! The uncertainty of the early half may be that of its approach.
         if (abs(early - late) <= max(sqrt(2.0_dp)*error_late, largest_neutral*frequency_ratio/(2*pi))) return
         first = middle
      end do
   end function settled_part

   !> Mean rate of growth and its uncertainty at 95 %, from the means of six blocks. The weights of the means, with all derivatives,
   !> are 0 at the ends, so that oscillations average out.
   pure subroutine exponent_of(growth, exponent, error)
      !> Rate of growth over each period of the fundamental [1].
      real(dp), intent(in) :: growth(:)
      !> The mean and its uncertainty [1].
      real(dp), intent(out) :: exponent, error
      real(dp) :: part(blocks)
      integer :: i, n

      n = max(1, size(growth)/blocks)
      part = [(weighted_mean(growth((i - 1)*n + 1:min(i*n, size(growth)))), i=1, blocks)]
      exponent = weighted_mean(growth)
      error = student*sqrt(sum((part - sum(part)/blocks)**2)/(blocks*(blocks - 1)))
   end subroutine exponent_of

end module geartrain_flow_lyapunov
