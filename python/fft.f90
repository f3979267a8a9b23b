!> Real Fourier transforms without FFTW, for wheels: takes the place of src/geartrain/linalg/fftw.f90, with the same names, where
!> meson is told -Dfft=own, since FFTW would put a wheel under the GPL. Stockham's method with factors 4, 2, 3 and 5
!> (python/fft_kernels.c), others by their definition; an even number of samples as one complex transform of half the length.
module geartrain_linalg_fftw
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use geartrain_base_kinds, only: dp, pi
   implicit none (type, external)
   private
   public :: transform_type

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
      !> exp(-2 pi i k/samples), (0:samples-1).
      complex(dp), allocatable, private :: root(:)
      !> From one to the other and back the stages go: real and imaginary parts, (0:length-1, 2, 2).
      real(dp), allocatable, private :: work(:, :, :)
   contains
      procedure :: plan
      procedure :: to_samples
      procedure :: to_coefficients
      procedure, private :: transform
   end type transform_type

   interface
      !> A stage of a factor r from 2 to 5: m transforms of r values, for every one of s interleaved series.
      pure subroutine split_fast(r, s, m, step, root, x, y) bind(c, name='geartrain_split')
         import :: c_double, c_int, dp
         !> Factor; interleaved series; transforms; places in `root` from one root of the complex transform to the next.
         integer(c_int), value :: r, s, m, step
         !> exp(-2 pi i k/samples).
         complex(dp), intent(in) :: root(*)
         !> Values before and after, real and imaginary parts: x(s, m, r, 2), y(s, r, m, 2).
         real(c_double), intent(in) :: x(*)
         real(c_double), intent(out) :: y(*)
      end subroutine split_fast

      !> Coefficients of 2 n samples from the transform of their pairs.
      pure subroutine part(n, root, pairs, coefficient) bind(c, name='geartrain_part')
         import :: c_double, c_int, dp
         !> Half the number of samples.
         integer(c_int), value :: n
         !> exp(-2 pi i k/samples).
         complex(dp), intent(in) :: root(*)
         !> The transform, real and imaginary parts, (n, 2).
         real(c_double), intent(in) :: pairs(*)
         !> (n + 1)
         complex(dp), intent(out) :: coefficient(*)
      end subroutine part

      !> What a transform forward gives the conjugates of 2 n samples in pairs from; arguments as those of `part`.
      pure subroutine join(n, root, coefficient, pairs) bind(c, name='geartrain_join')
         import :: c_double, c_int, dp
         integer(c_int), value :: n
         complex(dp), intent(in) :: root(*), coefficient(*)
         real(c_double), intent(out) :: pairs(*)
      end subroutine join
   end interface

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
      allocate (self%sample(samples), self%coefficient(samples/2 + 1), self%root(0:samples - 1), self%work(0:self%length - 1, 2, 2))
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
      integer :: n, side

      n = self%length
      associate (c => self%coefficient, w => self%work)
         ! The conjugate of what a transform backward starts from: its result is the conjugate of that of one forward.
         if (n == self%samples) then
            w(0, :, 1) = [c(1)%re, 0.0_dp]
            w(1:n/2, 1, 1) = c(2:)%re
            w(1:n/2, 2, 1) = -c(2:)%im
            w(n - 1:n - n/2:-1, 1, 1) = c(2:)%re
            w(n - 1:n - n/2:-1, 2, 1) = c(2:)%im
            call self%transform(side)
            self%sample(:) = w(:, 1, side)
         else
            call join(n, self%root, c, w)
            call self%transform(side)
            self%sample(1::2) = w(:, 1, side)
            self%sample(2::2) = -w(:, 2, side)
         end if
      end associate
   end subroutine to_samples

   !> coefficient(k+1) = sum over q of sample(q) exp(-2 pi i k (q-1)/samples).
   subroutine to_coefficients(self)
      class(transform_type), intent(inout) :: self
      integer :: n, side

      n = self%length
      associate (c => self%coefficient, w => self%work)
         if (n == self%samples) then
            w(:, 1, 1) = self%sample
            w(:, 2, 1) = 0
            call self%transform(side)
            c(:) = cmplx(w(:n/2, 1, side), w(:n/2, 2, side), dp)
         else
            w(:, 1, 1) = self%sample(1::2)
            w(:, 2, 1) = self%sample(2::2)
            call self%transform(side)
            call part(n, self%root, w(:, :, side), c)
         end if
      end associate
   end subroutine to_coefficients

   !> The complex transform forward of work(:, :, 1), into work(:, :, side): each stage splits off one factor.
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
            if (self%factor(j) <= 5) then
               call split_fast(self%factor(j), s, m, step, self%root, w(:, :, side), w(:, :, 3 - side))
            else
               call split(self%factor(j), s, m, step, self%root, w(:, :, side), w(:, :, 3 - side))
            end if
            s = s*self%factor(j)
            side = 3 - side
         end do
      end associate
   end subroutine transform

   !> A stage of any factor r, by the definition; arguments as those of `split_fast`.
   pure subroutine split(r, s, m, step, root, x, y)
      integer, intent(in) :: r, s, m, step
      complex(dp), intent(in) :: root(0:*)
      real(dp), intent(in) :: x(s, 0:m - 1, 0:r - 1, 2)
      real(dp), intent(out) :: y(s, 0:r - 1, 0:m - 1, 2)
      complex(dp) :: total
      integer :: j, k, p, q

      do p = 0, m - 1
         do k = 0, r - 1
            do q = 1, s
               total = 0
               do j = 0, r - 1
                  total = total + cmplx(x(q, p, j, 1), x(q, p, j, 2), dp)*root(int(mod(int(j, 8)*k, int(r, 8)))*m*s*step)
               end do
               total = total*root(p*k*s*step)
               y(q, k, p, :) = [total%re, total%im]
            end do
         end do
      end do
   end subroutine split

end module geartrain_linalg_fftw
