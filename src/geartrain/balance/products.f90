!> Products of a periodic function, given by its two-sided Fourier coefficients w(0:), with a motion on a list of harmonics, given
!> by its coefficients mean, cos, sin, ...: as a matrix, or by FFT. Products with a tail of further harmonics, given by complex
!> amplitudes, and products at the harmonics of a tail.
module geartrain_balance_products
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: sample
   implicit none (type, external)
   private
   public :: add_coefficients, driven, find_wave, multiply, sparse_product, tail_force, toeplitz, transform_tail, wave_product

contains

   !> Makes the matrix of the product.
   pure subroutine toeplitz(harmonic, w, t)
      !> Carried harmonics.
      integer, intent(in) :: harmonic(:)
      !> Two-sided coefficients of the function, (0:).
      complex(dp), intent(in) :: w(0:)
      !> Matrix, (1 + 2*harmonics, 1 + 2*harmonics).
      real(dp), intent(out) :: t(:, :)
      complex(dp) :: difference, total
      integer :: k, l, m

      associate (r => harmonic)
         t(1, 1) = real(w(0), dp)
         do k = 1, size(r)
            t(1, 2*k) = real(w(r(k)), dp)
            t(1, 2*k + 1) = -aimag(w(r(k)))
            t(2*k, 1) = 2*t(1, 2*k)
            t(2*k + 1, 1) = 2*t(1, 2*k + 1)
         end do
         do l = 1, size(r)
            do m = 1, size(r)
               difference = w(abs(r(m) - r(l)))
               if (r(m) < r(l)) difference = conjg(difference)
               total = w(r(m) + r(l))
               t(2*m, 2*l) = difference%re + total%re
               t(2*m + 1, 2*l) = -difference%im - total%im
               t(2*m, 2*l + 1) = difference%im - total%im
               t(2*m + 1, 2*l + 1) = difference%re - total%re
            end do
         end do
      end associate
   end subroutine toeplitz

   !> Adds a multiple of the function to the coefficients of another function.
   pure subroutine add_coefficients(harmonic, factor, w, f)
      !> Carried harmonics.
      integer, intent(in) :: harmonic(:)
      !> Multiple of the function.
      real(dp), intent(in) :: factor
      !> Two-sided coefficients of the function, (0:).
      complex(dp), intent(in) :: w(0:)
      !> Coefficients mean, cos, sin, ..., (1 + 2*harmonics).
      real(dp), intent(inout) :: f(:)
      integer :: k

      f(1) = f(1) + factor*real(w(0), dp)
      do k = 1, size(harmonic)
         f(2*k) = f(2*k) + 2*factor*real(w(harmonic(k)), dp)
         f(2*k + 1) = f(2*k + 1) - 2*factor*aimag(w(harmonic(k)))
      end do
   end subroutine add_coefficients

   !> Samples the function, with its coefficients up to twice the highest harmonic.
   subroutine find_wave(harmonic, w, transform, wave)
      !> Carried harmonics.
      integer, intent(in) :: harmonic(:)
      !> Two-sided coefficients of the function, (0:).
      complex(dp), intent(in) :: w(0:)
      !> Plan with as many samples as `wave` has; overwritten.
      type(transform_type), intent(inout) :: transform
      !> Samples of the function over a period, (sample).
      real(dp), intent(out) :: wave(:)

      transform%coefficient = 0
      associate (n => 2*maxval(harmonic))
         transform%coefficient(:n + 1) = w(:n)
      end associate
      call transform%to_samples()
      wave = transform%sample
   end subroutine find_wave

   !> Product of the function, given by samples, with a motion; exact where there are more samples than four times the highest
   !> harmonic.
   subroutine wave_product(harmonic, wave, x, transform, f)
      !> Carried harmonics.
      integer, intent(in) :: harmonic(:)
      !> Samples of the function, (sample); coefficients of the motion, (1 + 2*harmonics).
      real(dp), intent(in) :: wave(:), x(:)
      !> Plan with as many samples as `wave` has; overwritten.
      type(transform_type), intent(inout) :: transform
      !> Coefficients of the product, (1 + 2*harmonics).
      real(dp), intent(out) :: f(:)
      integer :: k

      call sample(x, harmonic, transform)
      transform%sample = wave*transform%sample
      call transform%to_coefficients()
      f(1) = real(transform%coefficient(1), dp)/transform%samples
      do k = 1, size(harmonic)
         f(2*k) = 2*real(transform%coefficient(harmonic(k) + 1), dp)/transform%samples
         f(2*k + 1) = -2*aimag(transform%coefficient(harmonic(k) + 1))/transform%samples
      end do
   end subroutine wave_product

   !> Product of a function of few harmonics with a motion.
   subroutine sparse_product(harmonic, index, mean, w, x, f)
      !> Carried harmonics, ascending; harmonics of the function.
      integer, intent(in) :: harmonic(:), index(:)
      !> Mean of the function.
      real(dp), intent(in) :: mean
      !> Its two-sided coefficients at its harmonics, (index).
      complex(dp), intent(in) :: w(:)
      !> Coefficients of the motion, (1 + 2*harmonics).
      real(dp), intent(in) :: x(:)
      !> Coefficients of the product, (1 + 2*harmonics).
      real(dp), intent(out) :: f(:)
      integer :: i, j, k, n

      n = size(harmonic)
      f = mean*x
      do i = 1, size(index)
         associate (r => index(i))
            ! Harmonics that are r apart make one another.
            j = 1
            do k = 1, n
               do while (j < n .and. harmonic(j) < harmonic(k) + r)
                  j = j + 1
               end do
               if (harmonic(j) < harmonic(k) + r) exit
               if (harmonic(j) > harmonic(k) + r) cycle
               call add(k, conjg(w(i))*amplitude(j))
               call add(j, w(i)*amplitude(k))
            end do
            ! Harmonics that add up to r make one another, and r and the mean.
            j = n
            do k = 1, n
               if (harmonic(k) > r) exit
               if (harmonic(k) == r) then
                  f(1) = f(1) + real(conjg(w(i))*amplitude(k), dp)
                  call add(k, 2*w(i)*x(1))
                  exit
               end if
               do while (j > 1 .and. harmonic(j) > r - harmonic(k))
                  j = j - 1
               end do
               if (harmonic(j) == r - harmonic(k)) call add(k, w(i)*conjg(amplitude(j)))
            end do
         end associate
      end do

   contains

      !> Complex amplitude of the motion at carried harmonic m.
      pure complex(dp) function amplitude(m)
         integer, intent(in) :: m

         amplitude = cmplx(x(2*m), -x(2*m + 1), dp)
      end function amplitude

      !> Adds to the product at carried harmonic m.
      subroutine add(m, term)
         integer, intent(in) :: m
         complex(dp), intent(in) :: term

         f(2*m) = f(2*m) + term%re
         f(2*m + 1) = f(2*m + 1) - term%im
      end subroutine add

   end subroutine sparse_product

   !> Multiplies the waveform in wide%sample with the function; the coefficients of the product are in wide%coefficient.
   subroutine multiply(wide, w)
      !> Samples of a waveform, then coefficients of the product.
      type(transform_type), intent(inout) :: wide
      !> Two-sided coefficients of the function from coefficient 0 on.
      complex(dp), intent(in) :: w(:)
      real(dp) :: waveform(wide%samples)

      waveform = wide%sample/wide%samples
      wide%coefficient = 0
      wide%coefficient(:size(w)) = w
      call wide%to_samples()
      wide%sample = waveform*wide%sample
      call wide%to_coefficients()
   end subroutine multiply

   !> Complex amplitudes of the product at some harmonics, without the product with the mean.
   pure subroutine driven(kept, harmonic, w, u, product)
      !> Harmonics of the motion, ascending; harmonics of the product.
      integer, intent(in) :: kept(:), harmonic(:)
      !> Two-sided coefficients of the function, (0:); higher ones count as 0.
      complex(dp), intent(in) :: w(0:)
      !> Coefficients of the motion, (1 + 2*harmonics).
      real(dp), intent(in) :: u(:)
      !> Amplitudes of the product, (harmonic).
      complex(dp), intent(out) :: product(:)
      complex(dp) :: difference, total
      real(dp) :: re, im
      integer :: k, m, within

      do m = 1, size(harmonic)
         re = 0
         im = 0
         within = size(kept)
         do while (within > 0)
            if (harmonic(m) + kept(within) <= ubound(w, 1)) exit
            within = within - 1
         end do
         do k = 1, size(kept)
            difference = w(abs(harmonic(m) - kept(k)))
            if (harmonic(m) < kept(k)) difference%im = -difference%im
            total = 0
            if (k <= within) total = w(harmonic(m) + kept(k))
            re = re + (difference%re + total%re)*u(2*k) + (difference%im - total%im)*u(2*k + 1)
            im = im + (difference%im + total%im)*u(2*k) + (total%re - difference%re)*u(2*k + 1)
         end do
         product(m) = cmplx(re, im, dp)
      end do
   end subroutine driven

   !> Product of the function with a tail, at the carried harmonics.
   pure subroutine tail_force(kept, harmonic, w, tail, d_phi)
      !> Carried harmonics; harmonics of the tail.
      integer, intent(in) :: kept(:), harmonic(:)
      !> Two-sided coefficients of the function, (0:); complex amplitudes of the tail, (tail).
      complex(dp), intent(in) :: w(0:), tail(:)
      !> Coefficients of the product, (1 + 2*harmonics).
      real(dp), intent(out) :: d_phi(:)
      complex(dp) :: difference, total
      integer :: k, m

      d_phi = 0
      do m = 1, size(harmonic)
         associate (x => tail(m)%re, y => tail(m)%im)
            d_phi(1) = d_phi(1) + w(harmonic(m))%re*x + w(harmonic(m))%im*y
            do k = 1, size(kept)
               difference = w(abs(harmonic(m) - kept(k)))
               if (harmonic(m) < kept(k)) difference%im = -difference%im
               total = w(harmonic(m) + kept(k))
               d_phi(2*k) = d_phi(2*k) + (difference%re + total%re)*x + (difference%im + total%im)*y
               d_phi(2*k + 1) = d_phi(2*k + 1) + (difference%im - total%im)*x + (total%re - difference%re)*y
            end do
         end associate
      end do
   end subroutine tail_force

   !> `tail_force` by FFT.
   subroutine transform_tail(kept, harmonic, w, tail, wide, d_phi)
      !> Carried harmonics; harmonics of the tail.
      integer, intent(in) :: kept(:), harmonic(:)
      !> Two-sided coefficients of the function, (0:); complex amplitudes of the tail, (tail).
      complex(dp), intent(in) :: w(0:), tail(:)
      !> Plan with room for the product; overwritten.
      type(transform_type), intent(inout) :: wide
      !> Coefficients of the product, (1 + 2*harmonics).
      real(dp), intent(out) :: d_phi(:)
      integer :: k

      wide%coefficient = 0
      wide%coefficient(harmonic + 1) = tail/2
      call wide%to_samples()
      call multiply(wide, w)
      d_phi(1) = real(wide%coefficient(1), dp)
      do k = 1, size(kept)
         d_phi(2*k) = 2*real(wide%coefficient(kept(k) + 1), dp)
         d_phi(2*k + 1) = -2*aimag(wide%coefficient(kept(k) + 1))
      end do
   end subroutine transform_tail

end module geartrain_balance_products
