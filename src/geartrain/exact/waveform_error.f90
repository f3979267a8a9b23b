!> The true error of a waveform: distance of the coefficients of a balance from the coefficients of the orbit found by shooting.
module geartrain_exact_waveform_error
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
   pure real(dp) function waveform_error(coefficients, orbit, carried)
      !> Coefficients of the balance and of the orbit [1], (1 + 2*harmonics, mesh).
      real(dp), intent(in) :: coefficients(:, :), orbit(:, :)
      !> Harmonics that the balance has, which alone are compared; absent: all harmonics of both.
      integer, intent(in), optional :: carried(:)
      real(dp) :: missing, harmonic(0:max(size(coefficients, 1), size(orbit, 1))/2)
      integer :: n

      harmonic = 0
      n = min(size(coefficients, 1), size(orbit, 1))
      harmonic(0) = 2*sum((orbit(1, :) - coefficients(1, :))**2)
      call add(orbit(2:n, :) - coefficients(2:n, :), harmonic(1:))
      call add(orbit(n + 1:, :), harmonic(n/2 + 1:))
      missing = sum(harmonic)
      if (present(carried)) missing = harmonic(0) + sum(harmonic(carried))
      waveform_error = sqrt(missing/max(sum(orbit(2:, :)**2), tiny(missing)))

   contains

      !> Adds the squares of both coefficients of each harmonic.
      pure subroutine add(difference, squares)
         real(dp), intent(in) :: difference(:, :)
         real(dp), intent(inout) :: squares(:)
         integer :: r

         do r = 1, size(difference, 1)/2
            squares(r) = squares(r) + sum(difference(2*r - 1:2*r, :)**2)
         end do
      end subroutine add

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

end module geartrain_exact_waveform_error
