!> Floquet multipliers of a monodromy matrix, and what they say of a motion.
module geartrain_floquet_multipliers
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
   use geartrain_base_kinds, only: dp
   use geartrain_base_sorting, only: ascending
   use geartrain_linalg_eigenvalues, only: find_eigenvalues
   implicit none (type, external)
   private
   public :: are_numbers, eigenvalues, is_neutral, is_stable, multipliers_of, neutral, power, side_of_fold

   !> A multiplier as near as this to the unit circle counts as neutral, which is not stable.
   real(dp), parameter :: neutral = 1e-9_dp

contains

   !> Eigenvalues of a matrix (destroyed), largest magnitude first; NaN where they do not converge.
   subroutine eigenvalues(matrix, values)
      !> Square matrix.
      real(dp), intent(inout) :: matrix(:, :)
      !> Its eigenvalues, (row).
      complex(dp), intent(out) :: values(:)
      integer :: info

      call find_eigenvalues(size(values), matrix, values, info)
      if (info /= 0) then
         values = ieee_value(0.0_dp, ieee_quiet_nan)
         return
      end if
      values = values(ascending(-abs(values)))
   end subroutine eigenvalues

   !> Eigenvalues of a monodromy matrix, largest magnitude first.
   function multipliers_of(monodromy) result(multipliers)
      !> Square matrix.
      real(dp), intent(in) :: monodromy(:, :)
      complex(dp) :: multipliers(size(monodromy, 1))
      real(dp) :: matrix(size(monodromy, 1), size(monodromy, 1))

      matrix = monodromy
      call eigenvalues(matrix, multipliers)
   end function multipliers_of

   !> The largest multiplier, that is the first, is on the unit circle as far as rounding tells; or it is not a number.
   pure logical function is_neutral(multipliers)
      !> Largest magnitude first.
      complex(dp), intent(in) :: multipliers(:)

      is_neutral = .not. are_numbers(multipliers)
      if (.not. is_neutral) is_neutral = abs(abs(multipliers(1)) - 1) <= neutral
   end function is_neutral

   !> All multipliers inside the unit circle, by more than their rounding.
   pure logical function is_stable(multipliers)
      !> Largest magnitude first.
      complex(dp), intent(in) :: multipliers(:)

      is_stable = are_numbers(multipliers)
      if (is_stable) is_stable = all(abs(multipliers) < 1 - neutral)
   end function is_stable

   !> 1 where an odd number of real multipliers is above +1, else 0: the two sides of a fold differ in it. Complex pairs that become
   !> real leave it as it is.
   pure integer function side_of_fold(multipliers)
      !> Multipliers of a motion, (state).
      complex(dp), intent(in) :: multipliers(:)

      side_of_fold = mod(count(abs(multipliers%im) <= 0 .and. multipliers%re > 1), 2)
   end function side_of_fold

   !> Whether the multipliers were found: those of an interrupted flight, or of a matrix that does not converge, are NaN, on
   !> which any comparison is an invalid operation.
   pure logical function are_numbers(multipliers)
      !> Largest magnitude first.
      complex(dp), intent(in) :: multipliers(:)

      are_numbers = .not. any(ieee_is_nan(multipliers%re) .or. ieee_is_nan(multipliers%im))
   end function are_numbers

   !> An integer power, whose magnitude stays a number.
   elemental complex(dp) function power(value, exponent)
      !> Base.
      complex(dp), intent(in) :: value
      !> Exponent of at least 1.
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
