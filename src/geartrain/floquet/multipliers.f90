!> Floquet multipliers of a monodromy matrix, and what they say of a motion.
module geartrain_floquet_multipliers
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_eigenvalues, only: find_eigenvalues
   implicit none (type, external)
   private
   public :: are_numbers, eigenvalues, is_neutral, is_stable, neutral, power

   !> A multiplier as near as this to the unit circle counts as neutral, which is not stable.
   real(dp), parameter :: neutral = 1e-9_dp

contains

   !> Eigenvalues of a matrix (destroyed), largest magnitude first; NaN where they do not converge.
   subroutine eigenvalues(matrix, values)
      real(dp), intent(inout) :: matrix(:, :)
      complex(dp), intent(out) :: values(:)
      complex(dp) :: held
      real(dp) :: magnitude(size(values)), held_magnitude
      integer :: info, i, j

      call find_eigenvalues(size(values), matrix, values, info)
      if (info /= 0) then
         values = ieee_value(0.0_dp, ieee_quiet_nan)
         return
      end if
      magnitude = abs(values)
      do i = 2, size(values)
         held = values(i)
         held_magnitude = magnitude(i)
         do j = i - 1, 1, -1
            if (magnitude(j) >= held_magnitude) exit
            values(j + 1) = values(j)
            magnitude(j + 1) = magnitude(j)
         end do
         values(j + 1) = held
         magnitude(j + 1) = held_magnitude
      end do
   end subroutine eigenvalues

   !> The largest multiplier, that is the first, is on the unit circle as far as rounding tells; or it is not a number.
   pure logical function is_neutral(multipliers)
      complex(dp), intent(in) :: multipliers(:)

      is_neutral = .not. are_numbers(multipliers)
      if (.not. is_neutral) is_neutral = abs(abs(multipliers(1)) - 1) <= neutral
   end function is_neutral

   !> All multipliers inside the unit circle, by more than their rounding.
   pure logical function is_stable(multipliers)
      complex(dp), intent(in) :: multipliers(:)

      is_stable = are_numbers(multipliers)
      if (is_stable) is_stable = all(abs(multipliers) < 1 - neutral)
   end function is_stable

   !> Whether the multipliers were found: those of an interrupted flight, or of a matrix that does not converge, are NaN, on
   !> which any comparison is an invalid operation.
   pure logical function are_numbers(multipliers)
      complex(dp), intent(in) :: multipliers(:)

      are_numbers = .not. any(ieee_is_nan(multipliers%re) .or. ieee_is_nan(multipliers%im))
   end function are_numbers

   !> An integer power, whose magnitude stays a number.
   elemental complex(dp) function power(value, exponent)
      complex(dp), intent(in) :: value
      integer, intent(in) :: exponent
      real(dp), parameter :: highest = 700
      real(dp) :: magnitude, angle

      power = value
      magnitude = abs(value)
      if (.not. magnitude > 0) return
      magnitude = exp(max(-highest, min(highest, exponent*log(magnitude))))
      if (abs(value%im) > 0) then
         angle = exponent*atan2(value%im, value%re)
         power = magnitude*cmplx(cos(angle), sin(angle), dp)
      else
         power = magnitude*sign(1.0_dp, value%re)**exponent
      end if
   end function power

end module geartrain_floquet_multipliers
