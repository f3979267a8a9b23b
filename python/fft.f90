!> Real Fourier transforms without FFTW, for wheels: takes the place of src/geartrain/linalg/fftw.f90, with the same names, where
!> meson is told -Dfft=own, since FFTW would put a wheel under the GPL. Stockham's method with factors 4, 2, 3 and 5, others by
!> their definition; an even number of samples as one complex transform of half the length.
module geartrain_linalg_fftw
   use geartrain_base_kinds, only: dp, pi
   implicit none (type, external)
   private
   public :: transform_type

   complex(dp), parameter :: i = (0, 1)

   !> Real transforms of one length, planned once, without scaling: `to_samples` sums coefficients, `to_coefficients` sums samples.
   type :: transform_type
      !> Number of samples; 0: not planned.
      integer :: samples = 0
      !> Samples, (samples); coefficients 0 .. samples/2, (samples/2 + 1).
      real(dp), allocatable :: sample(:)
      complex(dp), allocatable :: coefficient(:)
      !> Length of the complex transform; factors of it.
      integer, private :: length = 0
      integer, allocatable, private :: factor(:)
      !> exp(-2 pi i k/samples), (0:samples-1); from one to the other and back the stages go, (0:length-1, 2).
      complex(dp), allocatable, private :: root(:), work(:, :)
   contains
      procedure :: plan
      procedure :: to_samples
      procedure :: to_coefficients
      procedure, private :: transform
   end type transform_type

contains

   !> Plans both directions, unless they are planned already.
   subroutine plan(self, samples)
      class(transform_type), intent(inout) :: self
      !> Number of samples, at least 1.
      integer, intent(in) :: samples
      integer :: k

      if (self%samples == samples) return
      if (self%samples > 0) deallocate (self%sample, self%coefficient, self%root, self%work)
      self%samples = samples
      self%length = samples
      if (mod(samples, 2) == 0) self%length = samples/2
      self%factor = factors(self%length)
      allocate (self%sample(samples), self%coefficient(samples/2 + 1), self%root(0:samples - 1), self%work(0:self%length - 1, 2))
      do k = 0, samples - 1
         self%root(k) = unit_root(k, samples)
      end do
   end subroutine plan

   !> Factors of n, those with a stage of their own first.
   pure function factors(n) result(list)
      !> Number, at least 1.
      integer, intent(in) :: n
      integer, allocatable :: list(:)
      integer :: rest, r

      allocate (list(0))
      rest = n
      do while (mod(rest, 4) == 0)
         list = [list, 4]
         rest = rest/4
      end do
      r = 2
      do while (rest > 1)
         if (r*r > rest) r = rest
         if (mod(rest, r) == 0) then
            list = [list, r]
            rest = rest/r
         else
            r = r + 1
         end if
      end do
   end function factors

   !> exp(-2 pi i k/n), from an angle of at most pi/4, so that its symmetries hold to the last bit.
   pure complex(dp) function unit_root(k, n) result(z)
      !> 0 <= k < n.
      integer, intent(in) :: k, n
      integer :: quarter, rest

      quarter = 4*k/n
      rest = 4*k - quarter*n
      if (2*rest <= n) then
         z = cmplx(cos(pi/2*rest/n), -sin(pi/2*rest/n), dp)
      else
         z = cmplx(sin(pi/2*(n - rest)/n), -cos(pi/2*(n - rest)/n), dp)
      end if
      if (mod(quarter, 2) == 1) z = cmplx(z%im, -z%re, dp)
      if (quarter >= 2) z = -z
   end function unit_root

   !> sample(q) = sum over k = -samples/2 .. samples/2 of coefficient(|k|) exp(2 pi i k (q-1)/samples).
   subroutine to_samples(self)
      class(transform_type), intent(inout) :: self
      complex(dp) :: even, odd
      integer :: k, n, side

      n = self%length
      associate (c => self%coefficient, w => self%work)
         ! The conjugate of what a transform backward starts from: its result is the conjugate of that of one forward.
         if (n == self%samples) then
            w(0, 1) = c(1)%re
            do k = 1, n/2
               w(k, 1) = conjg(c(k + 1))
               w(n - k, 1) = c(k + 1)
            end do
            call self%transform(side)
            self%sample(:) = w(:, side)%re
         else
            w(0, 1) = cmplx(c(1)%re + c(n + 1)%re, c(n + 1)%re - c(1)%re, dp)
            do k = 1, n - 1
               even = c(k + 1) + conjg(c(n - k + 1))
               odd = (c(k + 1) - conjg(c(n - k + 1)))*conjg(self%root(k))
               w(k, 1) = conjg(even + i*odd)
            end do
            call self%transform(side)
            self%sample(1::2) = w(:, side)%re
            self%sample(2::2) = -w(:, side)%im
         end if
      end associate
   end subroutine to_samples

   !> coefficient(k+1) = sum over q of sample(q) exp(-2 pi i k (q-1)/samples).
   subroutine to_coefficients(self)
      class(transform_type), intent(inout) :: self
      complex(dp) :: even, odd
      integer :: k, n, side

      n = self%length
      associate (c => self%coefficient, w => self%work)
         if (n == self%samples) then
            w(:, 1) = self%sample
            call self%transform(side)
            c(:) = w(:n/2, side)
         else
            w(:, 1) = cmplx(self%sample(1::2), self%sample(2::2), dp)
            call self%transform(side)
            c(1) = w(0, side)%re + w(0, side)%im
            c(n + 1) = w(0, side)%re - w(0, side)%im
            do k = 1, n - 1
               even = (w(k, side) + conjg(w(n - k, side)))/2
               odd = (w(k, side) - conjg(w(n - k, side)))/2
               c(k + 1) = even - i*odd*self%root(k)
            end do
         end if
      end associate
   end subroutine to_coefficients

   !> The complex transform forward of work(:, 1), into work(:, side): each stage splits off one factor.
   subroutine transform(self, side)
      class(transform_type), intent(inout) :: self
      !> Where the result is.
      integer, intent(out) :: side
      integer :: j, m, s, step

      step = self%samples/self%length
      m = self%length
      s = 1
      side = 1
      associate (w => self%work)
         do j = 1, size(self%factor)
            m = m/self%factor(j)
            select case (self%factor(j))
            case (2)
               call split_2(s, m, step, self%root, w(:, side), w(:, 3 - side))
            case (3)
               call split_3(s, m, step, self%root, w(:, side), w(:, 3 - side))
            case (4)
               call split_4(s, m, step, self%root, w(:, side), w(:, 3 - side))
            case (5)
               call split_5(s, m, step, self%root, w(:, side), w(:, 3 - side))
            case default
               call split(s, m, self%factor(j), step, self%root, w(:, side), w(:, 3 - side))
            end select
            s = s*self%factor(j)
            side = 3 - side
         end do
      end associate
   end subroutine transform

   !> A stage of factor 2: m transforms of two values each, for every one of s interleaved series.
   pure subroutine split_2(s, m, step, root, x, y)
      !> Interleaved series; transforms; places in `root` from one root of the complex transform to the next.
      integer, intent(in) :: s, m, step
      !> exp(-2 pi i k/samples).
      complex(dp), intent(in) :: root(0:*)
      !> Values before.
      complex(dp), intent(in) :: x(s, 0:m - 1, 0:1)
      !> Values after.
      complex(dp), intent(out) :: y(s, 0:1, 0:m - 1)
      integer :: p, q

      do p = 0, m - 1
         do q = 1, s
            y(q, 0, p) = x(q, p, 0) + x(q, p, 1)
            y(q, 1, p) = (x(q, p, 0) - x(q, p, 1))*root(p*s*step)
         end do
      end do
   end subroutine split_2

   !> A stage of factor 3; arguments as those of `split_2`.
   pure subroutine split_3(s, m, step, root, x, y)
      integer, intent(in) :: s, m, step
      complex(dp), intent(in) :: root(0:*), x(s, 0:m - 1, 0:2)
      complex(dp), intent(out) :: y(s, 0:2, 0:m - 1)
      real(dp), parameter :: sine = sqrt(3.0_dp)/2
      complex(dp) :: total, middle, turned
      integer :: p, q

      do p = 0, m - 1
         do q = 1, s
            total = x(q, p, 1) + x(q, p, 2)
            turned = sine*(x(q, p, 1) - x(q, p, 2))
            turned = cmplx(turned%im, -turned%re, dp)
            middle = x(q, p, 0) - total/2
            y(q, 0, p) = x(q, p, 0) + total
            y(q, 1, p) = (middle + turned)*root(p*s*step)
            y(q, 2, p) = (middle - turned)*root(2*p*s*step)
         end do
      end do
   end subroutine split_3

   !> A stage of factor 4; arguments as those of `split_2`.
   pure subroutine split_4(s, m, step, root, x, y)
      integer, intent(in) :: s, m, step
      complex(dp), intent(in) :: root(0:*), x(s, 0:m - 1, 0:3)
      complex(dp), intent(out) :: y(s, 0:3, 0:m - 1)
      complex(dp) :: sum_even, sum_odd, difference, turned
      integer :: p, q

      do p = 0, m - 1
         do q = 1, s
            sum_even = x(q, p, 0) + x(q, p, 2)
            sum_odd = x(q, p, 1) + x(q, p, 3)
            difference = x(q, p, 0) - x(q, p, 2)
            turned = x(q, p, 1) - x(q, p, 3)
            turned = cmplx(turned%im, -turned%re, dp)
            y(q, 0, p) = sum_even + sum_odd
            y(q, 1, p) = (difference + turned)*root(p*s*step)
            y(q, 2, p) = (sum_even - sum_odd)*root(2*p*s*step)
            y(q, 3, p) = (difference - turned)*root(3*p*s*step)
         end do
      end do
   end subroutine split_4

   !> A stage of factor 5; arguments as those of `split_2`.
   pure subroutine split_5(s, m, step, root, x, y)
      integer, intent(in) :: s, m, step
      complex(dp), intent(in) :: root(0:*), x(s, 0:m - 1, 0:4)
      complex(dp), intent(out) :: y(s, 0:4, 0:m - 1)
      real(dp), parameter :: cosine(2) = [cos(2*pi/5), cos(4*pi/5)], sine(2) = [sin(2*pi/5), sin(4*pi/5)]
      complex(dp) :: total(2), turned(2), middle, slope
      integer :: p, q

      do p = 0, m - 1
         do q = 1, s
            total = [x(q, p, 1) + x(q, p, 4), x(q, p, 2) + x(q, p, 3)]
            turned = [x(q, p, 1) - x(q, p, 4), x(q, p, 2) - x(q, p, 3)]
            turned = cmplx(turned%im, -turned%re, dp)
            y(q, 0, p) = x(q, p, 0) + total(1) + total(2)
            middle = x(q, p, 0) + cosine(1)*total(1) + cosine(2)*total(2)
            slope = sine(1)*turned(1) + sine(2)*turned(2)
            y(q, 1, p) = (middle + slope)*root(p*s*step)
            y(q, 4, p) = (middle - slope)*root(4*p*s*step)
            middle = x(q, p, 0) + cosine(2)*total(1) + cosine(1)*total(2)
            slope = sine(2)*turned(1) - sine(1)*turned(2)
            y(q, 2, p) = (middle + slope)*root(2*p*s*step)
            y(q, 3, p) = (middle - slope)*root(3*p*s*step)
         end do
      end do
   end subroutine split_5

   !> A stage of any factor r, by the definition; arguments as those of `split_2`.
   pure subroutine split(s, m, r, step, root, x, y)
      integer, intent(in) :: s, m, r, step
      complex(dp), intent(in) :: root(0:*), x(s, 0:m - 1, 0:r - 1)
      complex(dp), intent(out) :: y(s, 0:r - 1, 0:m - 1)
      complex(dp) :: total
      integer :: j, k, p, q

      do p = 0, m - 1
         do k = 0, r - 1
            do q = 1, s
               total = x(q, p, 0)
               do j = 1, r - 1
                  total = total + x(q, p, j)*root(int(mod(int(j, 8)*k, int(r, 8)))*m*s*step)
               end do
               y(q, k, p) = total*root(p*k*s*step)
            end do
         end do
      end do
   end subroutine split

end module geartrain_linalg_fftw
