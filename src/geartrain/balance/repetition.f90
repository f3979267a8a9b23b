!> A motion that repeats itself within its period: of a train that is excited by multiples of an order g alone, a motion of period 1
!> is g times the same. The train whose orders are divided by g has it at g times the Lambda, once: a flight over that is short
!> enough for shooting, where the whole period multiplies an error by the multiplier to the power g.
module geartrain_balance_repetition
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_series, only: series_type
   use geartrain_floquet_multipliers, only: power
   use geartrain_model_system, only: system_type
   implicit none (type, external)
   private
   public :: repetitions_of, divide_orders, take_one, repeat_motion

   !> Largest share of a motion's amplitude at harmonics that a repetition cannot have.
   real(dp), parameter :: negligible = 1e-9_dp

contains

   !> How often a motion repeats itself within its period; 1 where its coefficients do not tell.
   pure integer function repetitions_of(system, motion) result(times)
      type(system_type), intent(in) :: system
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

   !> Makes of a train the one with the `times`-th part of its orders.
   pure subroutine divide_orders(times, system)
      integer, intent(in) :: times
      type(system_type), intent(inout) :: system
      integer :: j

      do j = 1, size(system%torque)
         call divide(times, system%torque(j))
      end do
      do j = 1, system%meshes
         if (size(system%law(j)%amplitude, 1) > 0) system%law(j)%order = system%law(j)%order/times
         call divide(times, system%transmission_error(j))
      end do
      system%excitation_order = system%excitation_order/times
   end subroutine divide_orders

   !> Makes of a motion of period 1 that of the other train, at `times` Lambda.
   pure subroutine take_one(times, motion)
      integer, intent(in) :: times
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

   pure subroutine divide(times, series)
      integer, intent(in) :: times
      type(series_type), intent(inout) :: series

      if (size(series%amplitude) > 0) series%order = series%order/times
   end subroutine divide

   !> The inverse for a motion, with coefficients up to harmonic `highest` of Lambda.
   pure subroutine repeat_motion(times, highest, motion)
      integer, intent(in) :: times, highest
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
