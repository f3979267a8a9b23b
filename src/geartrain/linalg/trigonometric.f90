!> Trigonometric polynomials p(theta) = u(1) + sum over k of u(2k) cos(h_k theta) + u(2k+1) sin(h_k theta) with a list of
!> harmonics h: values, samples by FFT, extremes.
module geartrain_linalg_trigonometric
   use geartrain_base_kinds, only: dp, pi
   use geartrain_linalg_fftw, only: transform_type
   implicit none (type, external)
   private
   public :: evaluate, inner, sample, extremes, next_maximum, least_height, rms, fine_samples, own_resolution, resolution, &
      transform_length

   !> Distance of neighbouring harmonics beyond which a power of exp(i theta) takes longer than cosine and sine.
   integer, parameter :: far_apart = 32
   !> Powers of exp(i theta) in a table; least number of harmonics, most of them far apart, that are worth the tables.
   integer, parameter :: span = 64, several = 24
   !> Error of a height by `find_vertex` beside what it tells itself, over the range of the samples: 0.0005 for a sine of eight
   !> samples a period.
   real(dp), parameter :: near = 0.004_dp

contains

   !> Number of samples that resolve all harmonics: at least eight in a period of the highest harmonic.
   pure integer function fine_samples(highest)
      !> Highest harmonic.
      integer, intent(in) :: highest

      fine_samples = max(32, transform_length(8*highest))
   end function fine_samples

   !> The harmonic whose `fine_samples` show the extremes of a function: the largest of a sine with the amplitude and the third
   !> derivative of the function, whose parabolas through three samples are as exact. Amplitudes that are small count little.
   pure integer function resolution(amplitude, third, highest)
      !> Root of the sum of squared amplitudes; bound of the third derivative with respect to theta.
      real(dp), intent(in) :: amplitude, third
      !> Highest harmonic, which is enough anyway.
      integer, intent(in) :: highest

      resolution = highest
      if (sqrt(2.0_dp)*third < real(highest, dp)**3*amplitude) resolution = ceiling((sqrt(2.0_dp)*third/amplitude)**(1/3.0_dp))
      resolution = max(1, resolution)
   end function resolution

   !> `resolution` of a trigonometric polynomial.
   pure integer function own_resolution(u, harmonic)
      !> Coefficients, (1 + 2*harmonics).
      real(dp), intent(in) :: u(:)
      !> Orders h, ascending, (harmonics).
      integer, intent(in) :: harmonic(:)
      integer :: k

      own_resolution = resolution(norm2(u(2:)), sum([(hypot(u(2*k), u(2*k + 1))*real(harmonic(k), dp)**3, k=1, size(harmonic))]), &
                                  maxval([1, harmonic]))
   end function own_resolution

   !> Number of samples, at least `least`, whose transforms are fast: a power of two, or 3 or 5 times a power of two where that
   !> saves more than planning takes.
   pure integer function transform_length(least) result(length)
      !> Number of samples needed.
      integer, intent(in) :: least

      length = 1
      do while (length < least)
         length = 2*length
      end do
      if (length <= 1024) return
      if (5*(length/8) >= least) then
         length = 5*(length/8)
      else if (3*(length/4) >= least) then
         length = 3*(length/4)
      end if
   end function transform_length

   !> Value and derivatives of p at an angle.
   pure subroutine evaluate(u, harmonic, theta, p, slope, curvature, third)
      !> Coefficients, (1 + 2*harmonics); angle [rad].
      real(dp), intent(in) :: u(:), theta
      !> Orders h, ascending, (harmonics).
      integer, intent(in) :: harmonic(:)
      !> Value and first and second derivative with respect to theta, in the unit of u.
      real(dp), intent(out) :: p, slope, curvature
      !> Third derivative with respect to theta.
      real(dp), intent(out), optional :: third
      complex(dp) :: z, power, advance, term
      integer :: k, n, step

      n = size(harmonic)
      if (present(third)) third = 0
      p = u(1)
      slope = 0
      curvature = 0
      if (n > several) then
         if (n > span .or. harmonic(n) > far_apart*n) then
            call evaluate_many(u, harmonic, theta, p, slope, curvature, third)
            return
         end if
      end if
      z = cmplx(cos(theta), sin(theta), dp)
      power = 1
      step = 0
      advance = 1
      do k = 1, n
         if (k == 1) then
            step = harmonic(1)
            advance = z**step
         else if (harmonic(k) - harmonic(k - 1) /= step) then
            step = harmonic(k) - harmonic(k - 1)
            if (step <= far_apart) advance = z**step
         end if
         if (step <= far_apart) then
            power = power*advance
         else
            power = cmplx(cos(harmonic(k)*theta), sin(harmonic(k)*theta), dp)
         end if
         term = cmplx(u(2*k), -u(2*k + 1), dp)*power
         p = p + term%re
         slope = slope - harmonic(k)*term%im
         curvature = curvature - real(harmonic(k), dp)**2*term%re
         if (present(third)) third = third + real(harmonic(k), dp)**3*term%im
      end do
   end subroutine evaluate

   !> `evaluate` of many harmonics: the power of each is a product from tables, so none waits for the power before.
   pure subroutine evaluate_many(u, harmonic, theta, p, slope, curvature, third)
      real(dp), intent(in) :: u(:), theta
      integer, intent(in) :: harmonic(:)
      real(dp), intent(inout) :: p, slope, curvature
      real(dp), intent(inout), optional :: third
      complex(dp) :: power, term, low(0:span - 1), middle(0:min(span - 1, maxval(harmonic)/span)), &
                     high(0:maxval(harmonic)/span**2)
      real(dp) :: h
      integer :: k

      call list_powers(theta, low)
      call list_powers(span*theta, middle)
      call list_powers(real(span, dp)**2*theta, high)
      do k = 1, size(harmonic)
         h = harmonic(k)
         power = low(modulo(harmonic(k), span))*middle(modulo(harmonic(k)/span, span))
         if (harmonic(k) >= span**2) power = high(harmonic(k)/span**2)*power
         term = cmplx(u(2*k), -u(2*k + 1), dp)*power
         p = p + term%re
         slope = slope - h*term%im
         curvature = curvature - h**2*term%re
         if (present(third)) third = third + h**3*term%im
      end do
   end subroutine evaluate_many

   !> Powers 0, 1, 2, ... of exp(i angle).
   pure subroutine list_powers(angle, power)
      real(dp), intent(in) :: angle
      complex(dp), intent(out) :: power(0:)
      complex(dp) :: z
      integer :: k

      power(0) = 1
      if (ubound(power, 1) == 0) return
      z = cmplx(cos(angle), sin(angle), dp)
      do k = 1, ubound(power, 1)
         power(k) = power(k - 1)*z
      end do
   end subroutine list_powers

   !> Values of p at theta = 2 pi (q-1)/samples, however few.
   subroutine sample(u, harmonic, transform, derivative)
      !> Coefficients, (1 + 2*harmonics).
      real(dp), intent(in) :: u(:)
      !> Orders h, (harmonics).
      integer, intent(in) :: harmonic(:)
      !> Planned; transform%sample gets the values.
      type(transform_type), intent(inout) :: transform
      !> Whether the values are dp/dtheta; absent: .false.
      logical, intent(in), optional :: derivative
      complex(dp) :: amplitude
      integer :: k, r
      logical :: slope

      slope = .false.
      if (present(derivative)) slope = derivative
      transform%coefficient = 0
      if (.not. slope) transform%coefficient(1) = u(1)
      do k = 1, size(harmonic)
         amplitude = 0.5_dp*cmplx(u(2*k), -u(2*k + 1), dp)
         if (slope) amplitude = 0.5_dp*harmonic(k)*cmplx(u(2*k + 1), u(2*k), dp)
         ! A harmonic beyond half the samples has the values of a lower one.
         r = modulo(harmonic(k), transform%samples)
         if (2*r > transform%samples) then
            r = transform%samples - r
            amplitude = conjg(amplitude)
         end if
         if (r == 0 .or. 2*r == transform%samples) amplitude = 2*amplitude%re
         transform%coefficient(r + 1) = transform%coefficient(r + 1) + amplitude
      end do
      call transform%to_samples()
   end subroutine sample

   !> Smallest and largest value of p over a period.
   subroutine extremes(u, harmonic, transform, smallest, largest, at)
      !> Coefficients, (1 + 2*harmonics).
      real(dp), intent(in) :: u(:)
      !> Orders h, ascending, (harmonics).
      integer, intent(in) :: harmonic(:)
      !> Planned for `fine_samples`; transform%sample gets the samples of p.
      type(transform_type), intent(inout) :: transform
      !> Extremes, in the unit of u.
      real(dp), intent(out) :: smallest, largest
      !> Their angles theta [rad].
      real(dp), intent(out), optional :: at(2)

      integer :: turn(size(transform%sample)), turns, q
      real(dp) :: before, rise

      call sample(u, harmonic, transform)
      turns = 0
      associate (values => transform%sample, n => size(transform%sample))
         ! Where the samples turn: +q at a maximum, -q at a minimum.
         before = values(1) - values(n)
         do q = 1, n
            rise = values(merge(1, q + 1, q == n)) - values(q)
            if (rise < 0 .and. before >= 0 .or. rise > 0 .and. before <= 0) then
               turns = turns + 1
               turn(turns) = merge(q, -q, rise < 0)
            end if
            before = rise
         end do
         largest = maxval(values)
         smallest = minval(values)
         before = largest - smallest
      end associate
      if (present(at)) at = 2*pi*([minloc(transform%sample, 1), maxloc(transform%sample, 1)] - 1)/transform%samples
      call refine(1, near*before, largest)
      call refine(-1, near*before, smallest)

   contains

      !> Newton's method on the slope, from each of the highest maxima of side*p among the samples.
      subroutine refine(side, slack, extreme)
         integer, intent(in) :: side
         !> Error of the heights.
         real(dp), intent(in) :: slack
         real(dp), intent(inout) :: extreme
         real(dp) :: height(turns), place(turns), doubt, error, highest, theta, p, slope, curvature, correction, spacing
         integer :: first, i, k, n

         spacing = 2*pi/transform%samples
         error = error_by_nine(u, harmonic, spacing)
         highest = -huge(highest)
         first = 0
         do k = 1, turns
            if (side*turn(k) < 0) cycle
            call find_vertex(transform%sample, side, abs(turn(k)), place(k), height(k), doubt)
            if (height(k) > highest) first = k
            highest = max(highest, height(k))
            height(k) = height(k) + doubt
         end do
         ! The highest first: of the others most are found lower at the first look.
         do n = 0, turns
            k = merge(first, n, n == 0)
            if (k == 0) exit
            if (side*turn(k) < 0 .or. n == first) cycle
            if (n > 0) then
               if (height(k) < side*extreme - slack) cycle
               if (height_by_nine(transform%sample, side, abs(turn(k)), place(k)) + error < side*extreme) cycle
            end if
            theta = place(k)
            do i = 1, 6
               call evaluate(u, harmonic, theta, p, slope, curvature)
               if (present(at) .and. side*p >= side*extreme) at((3 + side)/2) = theta
               extreme = side*max(side*extreme, side*p)
               if (side*curvature >= 0) exit
               correction = -slope/curvature
               if (abs(correction) < 1e-9_dp) exit
               ! The way up is a parabola, of half this height.
               if (side*p + abs(slope*correction) < side*extreme) exit
               theta = theta + max(-spacing, min(spacing, correction))
            end do
         end do
      end subroutine refine

   end subroutine extremes

   !> The next maximum of side*values, by `find_vertex`.
   pure subroutine next_maximum(values, side, least, q, place)
      !> Samples of a period; least height of the maximum.
      real(dp), intent(in) :: values(:), least
      !> +1 for maxima, -1 for minima.
      integer, intent(in) :: side
      !> Sample of the maximum before, 0 at first; then sample of the maximum found, 0: none.
      integer, intent(inout) :: q
      !> Angle of the maximum found [rad].
      real(dp), intent(out) :: place
      real(dp) :: height, doubt
      integer :: first

      first = q + 1
      do q = first, size(values)
         if (.not. is_maximum(values, side, q)) cycle
         call find_vertex(values, side, q, place, height, doubt)
         if (height + doubt >= least) return
      end do
      q = 0
   end subroutine next_maximum

   !> Height above which a maximum of side*values may be the greatest, given the error of the heights.
   pure real(dp) function least_height(values, side)
      !> Samples of a period.
      real(dp), intent(in) :: values(:)
      !> +1 for maxima, -1 for minima.
      integer, intent(in) :: side
      real(dp) :: place, height, doubt, greatest
      integer :: q

      greatest = -huge(greatest)
      do q = 1, size(values)
         if (.not. is_maximum(values, side, q)) cycle
         call find_vertex(values, side, q, place, height, doubt)
         greatest = max(greatest, height - doubt)
      end do
      least_height = greatest - near*(maxval(values) - minval(values))
   end function least_height

   !> Whether sample q of side*values is at least its neighbour before, and greater than its neighbour after.
   pure logical function is_maximum(values, side, q)
      real(dp), intent(in) :: values(:)
      integer, intent(in) :: side, q

      associate (n => size(values))
         is_maximum = side*values(q) >= side*values(merge(n, q - 1, q == 1)) &
                      .and. side*values(q) > side*values(merge(1, q + 1, q == n))
      end associate
   end function is_maximum

   !> Angle [rad] of the vertex of the parabola through sample q of side*values and its neighbours, the height there of the
   !> polynomial through five samples, and its distance from the parabola: the height is doubtful by as much, as next to a kink.
   pure subroutine find_vertex(values, side, q, place, height, doubt)
      real(dp), intent(in) :: values(:)
      integer, intent(in) :: side, q
      real(dp), intent(out) :: place, height, doubt
      real(dp) :: f(-2:2), t
      integer :: i

      associate (n => size(values))
         f = side*values([(modulo(q + i - 1, n) + 1, i=-2, 2)])
         t = 0.5_dp*(f(1) - f(-1))/(2*f(0) - f(-1) - f(1))
         height = t*(t**2 - 1)/12*(f(2) - 2*f(1) + 2*f(-1) - f(-2) + t/2*(f(2) - 4*f(1) + 6*f(0) - 4*f(-1) + f(-2)))
         doubt = abs(height)
         height = height + f(0) + t*((f(1) - f(-1))/2 + t/2*(f(1) - 2*f(0) + f(-1)))
         place = (q - 1 + t)*2*pi/n
      end associate
   end subroutine find_vertex

   !> Height of the vertex of `find_vertex` by the polynomial through nine samples; huge where that has its vertex elsewhere.
   pure real(dp) function height_by_nine(values, side, q, place) result(height)
      real(dp), intent(in) :: values(:), place
      integer, intent(in) :: side, q
      !> Distance of places at which the polynomial is evaluated, in samples.
      real(dp), parameter :: apart = 0.1_dp
      !> Weights of the barycentric formula for equidistant samples.
      real(dp), parameter :: weight(-4:4) = [1, -8, 28, -56, 70, -56, 28, -8, 1]
      real(dp) :: f(-4:4), share(-4:4), t, at(-1:1), rise, bend
      integer :: i, k

      associate (n => size(values))
         f = side*values([(modulo(q + i - 1, n) + 1, i=-4, 4)])
         t = place*n/(2*pi) - (q - 1)
      end associate
      do i = -1, 1
         share = [(t + apart*i - k, k=-4, 4)]
         share = weight/sign(max(abs(share), 1e-9_dp), share)
         at(i) = dot_product(share, f)/sum(share)
      end do
      rise = (at(1) - at(-1))/2
      bend = 2*at(0) - at(1) - at(-1)
      height = huge(height)
      if (abs(rise) < bend/2) height = at(0) + rise**2/(2*bend)
   end function height_by_nine

   !> Error of `height_by_nine` at most, with the given distance of samples [rad]: of each harmonic by the remainder of the
   !> interpolation half a sample off the middle one, twice for the vertex, and of the parabola there.
   pure real(dp) function error_by_nine(u, harmonic, spacing) result(error)
      real(dp), intent(in) :: u(:), spacing
      integer, intent(in) :: harmonic(:)
      real(dp), parameter :: remainder = 5.4e-4_dp, vertex = 1e-6_dp
      integer :: k

      error = 0
      do k = 1, size(harmonic)
         error = error + hypot(u(2*k), u(2*k + 1))*(2*min(3.0_dp, remainder*(harmonic(k)*spacing)**9) + vertex)
      end do
   end function error_by_nine

   !> The paper's rms: square root of the sum of squared harmonic amplitudes, without the mean.
   pure real(dp) function rms(u)
      !> Coefficients, (1 + 2*harmonics).
      real(dp), intent(in) :: u(:)

      rms = norm2(u(2:))
   end function rms

   !> Inner product of coefficients: products of the means plus half of all other products.
   pure real(dp) function inner(a, b)
      !> Coefficients [1], (block, unknowns).
      real(dp), intent(in) :: a(:, :), b(:, :)

      inner = 0
      if (size(a) > 0) inner = 0.5_dp*(sum(a*b) + sum(a(1, :)*b(1, :)))
   end function inner

end module geartrain_linalg_trigonometric
