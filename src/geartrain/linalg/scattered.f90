!> Fourier coefficients of pulses at scattered instants, by one FFT: each pulse is spread over the samples around it as a Gaussian,
!> whose own coefficients are then divided out (L. Greengard and J.-Y. Lee, SIAM Review 46 (2004) 443-454).
module geartrain_linalg_scattered
   use geartrain_base_kinds, only: dp, pi
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: transform_length
   implicit none (type, external)
   private
   public :: scattered_coefficients

   !> Samples on either side of a pulse over which it is spread: errors of 1e-13 of the sum of the pulses.
   integer, parameter :: reach = 14
   !> Samples over twice the highest index, at least.
   integer, parameter :: finer = 2

contains

   !> Sums over all pulses of weight exp(-i k theta), from k = 0 on.
   subroutine scattered_coefficients(theta, weight, coefficient)
      !> Instant of each pulse in [0, 2 pi] [rad]; its weight [1]; 0 is skipped.
      real(dp), intent(in) :: theta(:), weight(:)
      !> The sums [1], (0:).
      complex(dp), intent(out) :: coefficient(0:)
      type(transform_type) :: transform
      real(dp) :: width, x, first, ratio, gauss(-reach:reach), up, down
      integer :: i, k, n, q

      n = transform_length(2*finer*max(size(coefficient), reach))
      call transform%plan(n)
      ! exp(-x**2/width) at a distance of x samples.
      width = reach*n/(pi*(n - size(coefficient)))
      do k = -reach, reach
         gauss(k) = exp(-real(k, dp)**2/width)
      end do
      transform%sample = 0
      do i = 1, size(theta)
         if (.not. abs(weight(i)) > 0) cycle
         x = theta(i)/(2*pi)*n
         q = nint(x)
         x = x - q
         ! exp(-(k - x)**2/width) is a product of three factors, of which one is a power.
         first = weight(i)*exp(-x**2/width)
         ratio = exp(2*x/width)
         up = first
         down = first
         transform%sample(1 + modulo(q, n)) = transform%sample(1 + modulo(q, n)) + first
         do k = 1, reach
            up = up*ratio
            down = down/ratio
            associate (right => transform%sample(1 + modulo(q + k, n)))
               right = right + up*gauss(k)
            end associate
            associate (left => transform%sample(1 + modulo(q - k, n)))
               left = left + down*gauss(k)
            end associate
         end do
      end do
      call transform%to_coefficients()
      do k = 0, ubound(coefficient, 1)
         coefficient(k) = transform%coefficient(k + 1)*(exp(width*(pi*k/n)**2)/sqrt(pi*width))
      end do
   end subroutine scattered_coefficients

end module geartrain_linalg_scattered
