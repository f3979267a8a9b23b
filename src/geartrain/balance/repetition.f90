!> Motions that repeat themselves within their period. If only multiples of an order g excite a train, a motion of period 1 goes
!> g times through its waveform, or after period doublings g/2 times, and so on. A train with all orders divided by this number goes
!> through the waveform once, at so many times the Lambda.
!> Shooting over one waveform multiplies an error by its multiplier, over the whole period by the multiplier to the power g.
module geartrain_balance_repetition
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp
   use geartrain_train_kinematics, only: greatest_divisor
   use geartrain_floquet_multipliers, only: power
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: repetitions_in, repetitions_of, take_one, repeat_motion

   !> Share of the amplitude at a harmonic that is no multiple of g, up to which a motion repeats itself [1]: above the error of a
   !> motion that integration settled on. A branch of twice the period has such shares within 1e-12 of its beginning only.
   real(dp), parameter :: negligible = 1e-6_dp

contains

   !> How often motions go through their waveform within the period of the fundamental: the greatest common divisor of the harmonics
   !> that they have and that the train excites.
   pure integer function repetitions_in(system, harmonic, coefficients) result(times)
      type(system_type), intent(in) :: system
      !> Harmonics of Lambda of the coefficients, (harmonic).
      integer, intent(in) :: harmonic(:)
      !> Coefficients of the motions [1], (1 + 2*harmonics, mesh, motion).
      real(dp), intent(in) :: coefficients(:, :, :)
      integer :: i, k

      times = system%excitation_order
      do i = 1, size(coefficients, 3)
         if (times == 1) return
         associate (least => negligible*norm2(coefficients(2:, :, i)))
            do k = 1, size(harmonic)
               if (mod(harmonic(k), times) == 0) cycle
               if (norm2(coefficients(2*k:2*k + 1, :, i)) > least) &
                  times = int(greatest_divisor(int(times, int64), int(harmonic(k), int64)))
            end do
         end associate
      end do
   end function repetitions_in

   !> How often a motion goes through its waveform within its period; 1 where `motion` has no coefficients, or a period of several
   !> periods of the fundamental.
   pure integer function repetitions_of(system, motion) result(times)
      type(system_type), intent(in) :: system
      !> Motion with its coefficients and period.
      type(motion_type), intent(in) :: motion
      integer :: r

      times = 1
      if (motion%period /= 1 .or. system%excitation_order == 1 .or. .not. allocated(motion%coefficients)) return
      associate (c => motion%coefficients)
         times = repetitions_in(system, [(r, r=1, (size(c, 1) - 1)/2)], reshape(c, [size(c, 1), size(c, 2), 1]))
      end associate
   end function repetitions_of

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
      if (.not. allocated(motion%multipliers)) return
      motion%repetition_multipliers = motion%multipliers
      motion%multipliers = power(motion%repetition_multipliers, times)
   end subroutine repeat_motion

end module geartrain_balance_repetition
