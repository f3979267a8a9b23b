!> Trigonometric polynomials p(theta) = u(1) + sum over k of u(2k) cos(h_k theta) + u(2k+1) sin(h_k theta) on a list of
!> harmonics h: values, samples by FFT, extremes.
module geartrain_linalg_trigonometric
   use geartrain_base_kinds, only: dp, pi
   use geartrain_linalg_fftw, only: transform_type
   implicit none (type, external)
   private
   public :: evaluate, sample, extremes, next_maximum, least_height, rms, fine_samples, transform_length

contains

   !> Samples that resolve harmonics up to `highest`, at least eight a period of the highest.
   pure integer function fine_samples(highest)
      integer, intent(in) :: highest

      fine_samples = max(32, transform_length(8*highest))
   end function fine_samples

   !> The least power of two from `least` on: transforms of other lengths take longer to plan than they save.
   pure integer function transform_length(least) result(length)
      integer, intent(in) :: least

      length = 1
      do while (length < least)
         length = 2*length
      end do
   end function transform_length

   !> Value, slope, curvature and, where asked for, the third derivative with respect to theta.
   pure subroutine evaluate(u, harmonic, theta, p, slope, curvature, third)
      real(dp), intent(in) :: u(:), theta
      integer, intent(in) :: harmonic(:)
      real(dp), intent(out) :: p, slope, curvature
      real(dp), intent(out), optional :: third
      complex(dp) :: z, power, advance, term
      integer :: k, step

      z = exp(cmplx(0, theta, dp))
      power = 1
      step = 0
      advance = 1
      p = u(1)
      slope = 0
      curvature = 0
      if (present(third)) third = 0
      do k = 1, size(harmonic)
         if (k == 1) then
            step = harmonic(1)
            advance = z**step
         else if (harmonic(k) - harmonic(k - 1) /= step) then
            step = harmonic(k) - harmonic(k - 1)
            advance = z**step
         end if
         power = power*advance
         term = cmplx(u(2*k), -u(2*k + 1), dp)*power
         p = p + term%re
         slope = slope - harmonic(k)*term%im
         curvature = curvature - real(harmonic(k), dp)**2*term%re
         if (present(third)) third = third + real(harmonic(k), dp)**3*term%im
      end do
   end subroutine evaluate

   !> Values at theta = 2 pi (q-1)/samples of p, or of dp/dtheta with `derivative`, into transform%sample.
   subroutine sample(u, harmonic, transform, derivative)
      real(dp), intent(in) :: u(:)
      integer, intent(in) :: harmonic(:)
      type(transform_type), intent(inout) :: transform
      logical, intent(in), optional :: derivative
      integer :: k
      logical :: slope

      slope = .false.
      if (present(derivative)) slope = derivative
      transform%coefficient = 0
      if (.not. slope) transform%coefficient(1) = u(1)
      do k = 1, size(harmonic)
         if (slope) then
            transform%coefficient(harmonic(k) + 1) = 0.5_dp*harmonic(k)*cmplx(u(2*k + 1), u(2*k), dp)
         else
            transform%coefficient(harmonic(k) + 1) = 0.5_dp*cmplx(u(2*k), -u(2*k + 1), dp)
         end if
      end do
      call transform%to_samples()
   end subroutine sample

   !> Smallest and largest value over a period. Leaves the samples in transform%sample.
   subroutine extremes(u, harmonic, transform, smallest, largest)
      real(dp), intent(in) :: u(:)
      integer, intent(in) :: harmonic(:)
      type(transform_type), intent(inout) :: transform
      real(dp), intent(out) :: smallest, largest

      call sample(u, harmonic, transform)
      largest = extreme(1)
      smallest = extreme(-1)

   contains

      !> Newton on the slope from each of the highest maxima of side*p among the samples.
      real(dp) function extreme(side)
         integer, intent(in) :: side
         real(dp) :: least, spacing, theta, p, slope, curvature, correction
         integer :: i, q

         spacing = 2*pi/transform%samples
         extreme = side*maxval(side*transform%sample)
         least = least_height(transform%sample, side)
         q = 0
         do
            call next_maximum(transform%sample, side, least, q, theta)
            if (q == 0) exit
            do i = 1, 6
               call evaluate(u, harmonic, theta, p, slope, curvature)
               extreme = side*max(side*extreme, side*p)
               if (side*curvature >= 0) exit
               correction = -slope/curvature
               if (abs(correction) < 1e-9_dp) exit
               theta = theta + max(-spacing, min(spacing, correction))
            end do
         end do
      end function extreme

   end subroutine extremes

   !> The next maximum of side*values after sample q (0: the first of all) whose height is at least `least`, and its angle; by the
   !> parabola through the sample and its neighbours. q = 0: there is none.
   pure subroutine next_maximum(values, side, least, q, place)
      real(dp), intent(in) :: values(:), least
      integer, intent(in) :: side
      integer, intent(inout) :: q
      real(dp), intent(out) :: place
      real(dp) :: height
      integer :: first

      first = q + 1
      do q = first, size(values)
         if (.not. is_maximum(values, side, q)) cycle
         call find_vertex(values, side, q, place, height)
         if (height >= least) return
      end do
      q = 0
   end subroutine next_maximum

   !> Height from which on a maximum may be the greatest: near it by so much that the error of the parabola could hide it.
   pure real(dp) function least_height(values, side)
      real(dp), intent(in) :: values(:)
      integer, intent(in) :: side
      !> Share of the range of the values that counts as near.
      real(dp), parameter :: near = 0.03_dp
      real(dp) :: place, height, greatest
      integer :: q

      greatest = -huge(greatest)
      do q = 1, size(values)
         if (.not. is_maximum(values, side, q)) cycle
         call find_vertex(values, side, q, place, height)
         greatest = max(greatest, height)
      end do
      least_height = greatest - near*(maxval(values) - minval(values))
   end function least_height

   pure logical function is_maximum(values, side, q)
      real(dp), intent(in) :: values(:)
      integer, intent(in) :: side, q

      associate (n => size(values))
         is_maximum = side*values(q) >= side*values(merge(n, q - 1, q == 1)) &
                      .and. side*values(q) > side*values(merge(1, q + 1, q == n))
      end associate
   end function is_maximum

   pure subroutine find_vertex(values, side, q, place, height)
      real(dp), intent(in) :: values(:)
      integer, intent(in) :: side, q
      real(dp), intent(out) :: place, height
      real(dp) :: left, here, right, offset

      associate (n => size(values))
         here = side*values(q)
         left = side*values(merge(n, q - 1, q == 1))
         right = side*values(merge(1, q + 1, q == n))
         offset = 0.5_dp*(right - left)/(2*here - left - right)
         height = here + 0.25_dp*(right - left)*offset
         place = (q - 1 + offset)*2*pi/n
      end associate
   end subroutine find_vertex

   !> The paper's rms: square root of the sum of squared harmonic amplitudes, mean left out.
   pure real(dp) function rms(u)
      real(dp), intent(in) :: u(:)

      rms = norm2(u(2:))
   end function rms

end module geartrain_linalg_trigonometric
