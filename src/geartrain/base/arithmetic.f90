!> Whether the compiler left the arithmetic as IEEE 754 has it.
module geartrain_base_arithmetic
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan, ieee_positive_inf, ieee_quiet_nan, ieee_value
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: tells_nan

contains

   !> Whether NaN and infinity are told from numbers. Compiled with -Ofast, -ffast-math or -ffinite-math-only they are not, and
   !> what should be refused or told as failed would pass for a result.
   logical function tells_nan()
      ! Volatile, so that the compiler may not know what they hold.
      real(dp), volatile :: nan, infinity

      nan = ieee_value(1.0_dp, ieee_quiet_nan)
      infinity = ieee_value(1.0_dp, ieee_positive_inf)
      tells_nan = ieee_is_nan(nan) .and. .not. ieee_is_finite(infinity)
   end function tells_nan

end module geartrain_base_arithmetic
