!> The true error of a waveform: distance of the coefficients of a balance from the coefficients of the orbit found by shooting.
module geartrain_continuation_waveform_error
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: waveform_error, rounding_of, harmonics_told

contains

   !> Number of harmonics of Lambda that show the error of a balance when they are known of the orbit: more than the balance has.
   pure integer function harmonics_told(coefficients, period)
      !> Coefficients of the balance [1], (1 + 2*harmonics, mesh).
      real(dp), intent(in) :: coefficients(:, :)
      !> Period in periods of the fundamental.
      integer, intent(in) :: period

      harmonics_told = max(255, 2*((size(coefficients, 1) - 1)/2)/period)
   end function harmonics_told

   !> Relative error of the coefficients [1], defined as the error estimate of a balance is: norm of the error over norm of the
   !> alternating part, all meshes together; the error of a mean counts sqrt(2) times.
   pure real(dp) function waveform_error(coefficients, orbit, kept_only)
      !> Coefficients of the balance and of the orbit [1], (1 + 2*harmonics, mesh).
      real(dp), intent(in) :: coefficients(:, :), orbit(:, :)
      !> Leaves out the harmonics of the orbit above the highest harmonic of the balance.
      logical, intent(in) :: kept_only
      real(dp) :: missing
      integer :: n

      n = min(size(coefficients, 1), size(orbit, 1))
      missing = 2*sum((orbit(1, :) - coefficients(1, :))**2) + sum((orbit(2:n, :) - coefficients(2:n, :))**2)
      if (.not. kept_only) missing = missing + sum(orbit(n + 1:, :)**2)
      waveform_error = sqrt(missing/max(sum(orbit(2:, :)**2), tiny(missing)))
   end function waveform_error

   !> Error of shooting, a share `shooting` of the whole motion with its mean, relative to the alternating part [1].
   pure real(dp) function rounding_of(orbit)
      !> Coefficients of the orbit [1], (1 + 2*harmonics, mesh).
      real(dp), intent(in) :: orbit(:, :)
      real(dp), parameter :: shooting = 1e-11_dp
      real(dp) :: alternating

      alternating = max(sum(orbit(2:, :)**2), tiny(alternating))
      rounding_of = shooting*sqrt((2*sum(orbit(1, :)**2) + alternating)/alternating)
   end function rounding_of

end module geartrain_continuation_waveform_error
