!> Motions that repeat themselves within their period. If only multiples of an order g excite a train, a motion of period 1 goes
!> g times through its waveform. A train with all orders divided by g goes through the waveform once, at g times the Lambda.
!> Shooting over one waveform multiplies an error by its multiplier, over the whole period by the multiplier to the power g.
module geartrain_balance_repetition
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_series, only: series_type
   use geartrain_floquet_multipliers, only: power
   use geartrain_mesh_law_law, only: law_type
   use geartrain_model_system, only: system_type
   implicit none (type, external)
   private
   public :: repetitions_of, divide_orders, take_one, repeat_motion

   !> Share of the amplitude at harmonics that are no multiple of g, up to which a motion repeats itself [1].
   real(dp), parameter :: negligible = 1e-9_dp

contains

   !> How often a motion goes through its waveform within its period; 1 where `motion` has no coefficients.
   pure integer function repetitions_of(system, motion) result(times)
      !> Dimensionless system of the train.
      type(system_type), intent(in) :: system
      !> Motion with its coefficients and period.
      type(motion_type), intent(in) :: motion
      real(dp) :: others
      integer :: r

      times = 1
      if (motion%period /= 1 .or. system%excitation_order == 1 .or. .not. allocated(motion%coefficients)) return
      others = 0
      do r = 1, (size(motion%coefficients, 1) - 1)/2
         if (mod(r, system%excitation_order) /= 0) others = others + sum(motion%coefficients(2*r:2*r + 1, :)**2)
      end do
      if (sqrt(others) <= negligible*norm2(motion%coefficients(2:, :))) times = system%excitation_order
   end function repetitions_of

   !> Divides all orders of a train; harmonics without an amplitude, which need not be multiples of the divisor, are dropped.
   pure subroutine divide_orders(times, system)
      !> Common divisor of the orders.
      integer, intent(in) :: times
      !> Dimensionless system of the train.
      type(system_type), intent(inout) :: system
      integer :: j

      if (times == 1) return
      do j = 1, size(system%torque)
         call divide(times, system%torque(j))
      end do
      do j = 1, system%meshes
         call divide_law(times, system%law(j))
         call divide(times, system%transmission_error(j))
      end do
      system%excitation_order = system%excitation_order/times
   end subroutine divide_orders

   !> Turns a motion of period 1 into the motion of the train with divided orders: Lambda and coefficients.
   pure subroutine take_one(times, motion)
      !> Divisor of the orders.
      integer, intent(in) :: times
      !> Motion that goes `times` times through its waveform; afterwards once.
      type(motion_type), intent(inout) :: motion
      real(dp), allocatable :: coefficients(:, :)
      integer :: r

      motion%frequency_ratio = times*motion%frequency_ratio
      allocate (coefficients(1 + 2*((size(motion%coefficients, 1) - 1)/2/times), size(motion%coefficients, 2)))
      coefficients(1, :) = motion%coefficients(1, :)
      do r = 1, (size(coefficients, 1) - 1)/2
         coefficients(2*r:2*r + 1, :) = motion%coefficients(2*r*times:2*r*times + 1, :)
      end do
      call move_alloc(coefficients, motion%coefficients)
   end subroutine take_one

   pure subroutine divide_law(times, law)
      integer, intent(in) :: times
      type(law_type), intent(inout) :: law
      complex(dp), allocatable :: amplitude(:, :)
      logical :: kept(size(law%harmonic))
      integer :: s

      kept = any(abs(law%amplitude) > 0, 2)
      allocate (amplitude(count(kept), law%lowest:law%highest))
      do s = law%lowest, law%highest
         amplitude(:, s) = pack(law%amplitude(:, s), kept)
      end do
      call move_alloc(amplitude, law%amplitude)
      law%harmonic = pack(law%harmonic, kept)/times
      law%order = law%order/times
   end subroutine divide_law

   pure subroutine divide(times, series)
      integer, intent(in) :: times
      type(series_type), intent(inout) :: series

      series%harmonic = pack(series%harmonic, abs(series%amplitude) > 0)/times
      series%amplitude = pack(series%amplitude, abs(series%amplitude) > 0)
   end subroutine divide

   !> The inverse of `take_one`: Lambda, coefficients and multipliers.
   pure subroutine repeat_motion(times, highest, motion)
      !> Divisor of the orders; highest harmonic of the coefficients afterwards.
      integer, intent(in) :: times, highest
      !> Motion that goes once through its waveform; afterwards `times` times.
      type(motion_type), intent(inout) :: motion
      real(dp), allocatable :: coefficients(:, :)
      integer :: r

      motion%frequency_ratio = motion%frequency_ratio/times
      allocate (coefficients(1 + 2*highest, size(motion%coefficients, 2)), source=0.0_dp)
      coefficients(1, :) = motion%coefficients(1, :)
      do r = 1, min(highest/times, (size(motion%coefficients, 1) - 1)/2)
         coefficients(2*r*times:2*r*times + 1, :) = motion%coefficients(2*r:2*r + 1, :)
      end do
      call move_alloc(coefficients, motion%coefficients)
      if (allocated(motion%multipliers)) motion%multipliers = power(motion%multipliers, times)
   end subroutine repeat_motion

end module geartrain_balance_repetition
