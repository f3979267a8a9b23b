!> The true error of a waveform: how far the coefficients of a balance are from those of the orbit that shooting gives.
module geartrain_continuation_waveform_error
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: waveform_error, rounding_of, harmonics_told

contains

   !> Harmonics of Lambda that an orbit is to be given with, so that what a balance leaves out is told as well.
   pure integer function harmonics_told(coefficients, period)
      !> Those of the balance, (1 + 2*harmonics, mesh), and the period in mesh periods.
      real(dp), intent(in) :: coefficients(:, :)
      integer, intent(in) :: period

      harmonics_told = max(255, 2*((size(coefficients, 1) - 1)/2)/period)
   end function harmonics_told

   !> Relative error of the coefficients, as that of the estimate: root of the sum of squares over the alternating part, all meshes
   !> together. The orbit's harmonics above those of the balance count as well, unless the kept ones alone are asked for.
   pure real(dp) function waveform_error(coefficients, orbit, kept_only)
      !> (1 + 2*harmonics, mesh), those of the orbit with at least as many harmonics.
      real(dp), intent(in) :: coefficients(:, :), orbit(:, :)
      logical, intent(in) :: kept_only
      real(dp) :: missing
      integer :: n

      n = min(size(coefficients, 1), size(orbit, 1))
      missing = 2*sum((orbit(1, :) - coefficients(1, :))**2) + sum((orbit(2:n, :) - coefficients(2:n, :))**2)
      if (.not. kept_only) missing = missing + sum(orbit(n + 1:, :)**2)
      waveform_error = sqrt(missing/max(sum(orbit(2:, :)**2), tiny(missing)))
   end function waveform_error

   !> What shooting leaves of the whole motion, its mean included, relative to the alternating part.
   pure real(dp) function rounding_of(orbit)
      real(dp), intent(in) :: orbit(:, :)
      real(dp), parameter :: shooting = 1e-11_dp
      real(dp) :: alternating

      alternating = max(sum(orbit(2:, :)**2), tiny(alternating))
      rounding_of = shooting*sqrt((2*sum(orbit(1, :)**2) + alternating)/alternating)
   end function rounding_of

end module geartrain_continuation_waveform_error
