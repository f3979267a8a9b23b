!> The labels and the wording that the groups of a results file have in common.
module geartrain_results_labels
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: about_coefficients, about_doubtful, about_multipliers, about_rms, about_stable, about_true_ac_rms, &
      about_undecided, as_parts, coefficient_labels, frequency_description

   character(*), parameter :: frequency_description = 'Lambda: fundamental mesh frequency [rad/s] / characteristic_frequency'
   character(*), parameter :: about_rms = 'mesh displacement / characteristic_length, the rms of Al-shyyab and Kahraman &
      &(2007): square root of the sum of squared harmonic amplitudes, mean left out; sqrt(2) times the true AC rms'
   character(*), parameter :: about_true_ac_rms = 'mesh displacement / characteristic_length, root mean square over time &
      &of the displacement less its mean; rms / sqrt(2)'
   character(*), parameter :: about_coefficients = 'Fourier coefficients of mesh displacement / characteristic_length: &
      &mean, cos 1, sin 1, cos 2, ... of the fundamental frequency Lambda/period'
   character(*), parameter :: about_multipliers = 'Floquet multipliers over one period of the motion'
   character(*), parameter :: about_stable = '1 = stable: every Floquet multiplier lies inside the unit circle; 0 = not'
   character(*), parameter :: about_undecided = '1 = undecided, stable is a guess: the largest multiplier is as near to the unit &
      &circle as it is uncertain, or the error of the motion is itself doubtful; 0 = not'
   character(*), parameter :: about_doubtful = '1 = error_estimate may be off by more than a small factor: a fold as near as it is &
      &itself misplaced, a contact that begins or ends within the error, or an error beyond 0.1; 0 = not'

contains

   !> 'mean', 'cos 1', 'sin 1', 'cos 2', ...: `length` of them.
   function coefficient_labels(length) result(labels)
      integer, intent(in) :: length
      character(16) :: labels(length)
      integer :: i

      do i = 1, length
         write (labels(i), '(a, i0)') merge('cos ', 'sin ', mod(i, 2) == 0), i/2
      end do
      if (length > 0) labels(1) = 'mean'
   end function coefficient_labels

   !> Real and imaginary part as an array dimension, as not every reader knows complex numbers; (2, state, point).
   function as_parts(z) result(parts)
      complex(dp), intent(in) :: z(:, :)
      real(dp) :: parts(2, size(z, 1), size(z, 2))

      parts(1, :, :) = real(z)
      parts(2, :, :) = aimag(z)
   end function as_parts

end module geartrain_results_labels
