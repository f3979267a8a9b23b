!> Periodic functions as pairs of a harmonic and its complex amplitude.
module geartrain_base_series
   use geartrain_base_kinds, only: dp, pi
   implicit none (type, external)
   private
   public :: series_type, add_series, delay, make_series, multiply_series, table_harmonics, wave_value, window_harmonics

   !> Sum over i of Re(amplitude(i) exp(i harmonic(i) Lambda t)).
   type :: series_type
      !> Harmonics of Lambda, ascending, (harmonic).
      integer, allocatable :: harmonic(:)
      !> Complex amplitudes in the unit of the function, (harmonic).
      complex(dp), allocatable :: amplitude(:)
   end type series_type

contains

   !> Series of cos and sin amplitudes, either of which may be absent or shorter; trailing zeros are dropped.
   pure function make_series(cosine, sine, factor, order) result(series)
      !> Amplitudes of the cosines and of the sines, (harmonic); not allocated: 0.
      real(dp), allocatable, intent(in) :: cosine(:), sine(:)
      !> Factor of all amplitudes.
      real(dp), intent(in) :: factor
      !> Frequency of the first cosine over Lambda [1].
      integer, intent(in) :: order
      type(series_type) :: series
      complex(dp), allocatable :: amplitude(:)
      integer :: length, h

      length = 0
      if (allocated(cosine)) length = size(cosine)
      if (allocated(sine)) length = max(length, size(sine))
      allocate (amplitude(length), source=(0.0_dp, 0.0_dp))
      if (allocated(cosine)) amplitude(:size(cosine)) = amplitude(:size(cosine)) + cosine
      if (allocated(sine)) amplitude(:size(sine)) = amplitude(:size(sine)) - (0, 1)*sine
      do h = length, 1, -1
         if (abs(amplitude(h)) > 0) exit
      end do
      series%amplitude = factor*amplitude(:h)
      series%harmonic = [(order*h, h=1, size(series%amplitude))]
   end function make_series

   !> Adds a series to another one.
   pure subroutine add_series(added, series)
      !> What is added.
      type(series_type), intent(in) :: added
      !> The sum.
      type(series_type), intent(inout) :: series
      integer :: harmonic(size(series%harmonic) + size(added%harmonic)), i, j, n
      complex(dp) :: amplitude(size(harmonic))

      if (size(added%harmonic) == 0) return
      harmonic(:size(series%harmonic)) = series%harmonic
      amplitude(:size(series%harmonic)) = series%amplitude
      n = size(series%harmonic)
      do i = 1, size(added%harmonic)
         j = findloc(harmonic(:n), added%harmonic(i), 1)
         if (j > 0) then
            amplitude(j) = amplitude(j) + added%amplitude(i)
            cycle
         end if
         n = n + 1
         do j = n, 2, -1
            if (harmonic(j - 1) < added%harmonic(i)) exit
            harmonic(j) = harmonic(j - 1)
            amplitude(j) = amplitude(j - 1)
         end do
         harmonic(j) = added%harmonic(i)
         amplitude(j) = added%amplitude(i)
      end do
      series%harmonic = harmonic(:n)
      series%amplitude = amplitude(:n)
   end subroutine add_series

   !> Multiplies a function by another one, each a mean and a series.
   pure subroutine multiply_series(factor_mean, factor, mean, series)
      !> Mean of the factor [1].
      real(dp), intent(in) :: factor_mean
      !> Series of the factor [1].
      type(series_type), intent(in) :: factor
      !> Mean of the function, then of the product [unit of the function].
      real(dp), intent(inout) :: mean
      !> Series of the function, then of the product.
      type(series_type), intent(inout) :: series
      type(series_type) :: product, term
      real(dp) :: constant
      integer :: i, j, order

      constant = factor_mean*mean
      product%harmonic = series%harmonic
      product%amplitude = factor_mean*series%amplitude
      call add_series(series_type(factor%harmonic, mean*factor%amplitude), product)
      do i = 1, size(factor%harmonic)
         do j = 1, size(series%harmonic)
            ! cos a cos b is the mean of the cosines of the sum and of the difference.
            term%harmonic = [factor%harmonic(i) + series%harmonic(j)]
            term%amplitude = [factor%amplitude(i)*series%amplitude(j)/2]
            call add_series(term, product)
            order = factor%harmonic(i) - series%harmonic(j)
            term%harmonic = [abs(order)]
            term%amplitude = [factor%amplitude(i)*conjg(series%amplitude(j))/2]
            if (order < 0) term%amplitude = conjg(term%amplitude)
            if (order == 0) then
               constant = constant + term%amplitude(1)%re
            else
               call add_series(term, product)
            end if
         end do
      end do
      mean = constant
      series = product
   end subroutine multiply_series

   !> Harmonics of the sum of equidistant windows, each times its value of a table: window j is centred at the beginning of the part
   !> j of the period and reaches over its neighbours.
   pure subroutine window_harmonics(table, transform, mean, cosine, sine)
      !> Values in any unit, (value).
      real(dp), intent(in) :: table(:)
      !> Fourier transform of the window, whose integral is one part of the period, at the harmonics 1, 2, ... [1], (harmonic).
      real(dp), intent(in) :: transform(:)
      !> Mean value.
      real(dp), intent(out) :: mean
      !> Amplitudes of the harmonics; 0 for those that are rounding, (harmonic).
      real(dp), allocatable, intent(out) :: cosine(:), sine(:)
      real(dp) :: angle
      integer :: h, j, n

      n = size(table)
      mean = sum(table)/n
      allocate (cosine(size(transform)), sine(size(transform)), source=0.0_dp)
      do h = 1, size(transform)
         do j = 1, n
            angle = 2*pi*modulo(h*(j - 1), n)/n
            cosine(h) = cosine(h) + 2*transform(h)*table(j)*cos(angle)/n
            sine(h) = sine(h) + 2*transform(h)*table(j)*sin(angle)/n
         end do
      end do
      where (abs(cosine) <= 4*epsilon(1.0_dp)*maxval(abs(table))) cosine = 0
      where (abs(sine) <= 4*epsilon(1.0_dp)*maxval(abs(table))) sine = 0
   end subroutine window_harmonics

   !> Trigonometric polynomial of least degree through equidistant values of a period, the first at its beginning.
   pure subroutine table_harmonics(table, mean, cosine, sine)
      !> Values in any unit, one or more, (value).
      real(dp), intent(in) :: table(:)
      !> Mean value.
      real(dp), intent(out) :: mean
      !> Amplitudes of the harmonics 1, 2, ...; 0 for those that are rounding, (harmonic).
      real(dp), allocatable, intent(out) :: cosine(:), sine(:)
      real(dp) :: circle(0:size(table) - 1, 2), share, least
      integer :: h, j, k, n

      n = size(table)
      mean = sum(table)/n
      circle(:, 1) = [(cos(2*pi*j/n), j=0, n - 1)]
      circle(:, 2) = [(sin(2*pi*j/n), j=0, n - 1)]
      allocate (cosine(n/2), sine(n/2), source=0.0_dp)
      do h = 1, n/2
         k = 0
         do j = 1, n
            cosine(h) = cosine(h) + table(j)*circle(k, 1)
            sine(h) = sine(h) + table(j)*circle(k, 2)
            k = modulo(k + h, n)
         end do
         ! The highest harmonic of an even number of values is a cosine.
         share = merge(1.0_dp, 2.0_dp, 2*h == n)/n
         cosine(h) = share*cosine(h)
         sine(h) = merge(0.0_dp, share*sine(h), 2*h == n)
      end do
      least = 4*epsilon(1.0_dp)*maxval(abs(table))
      where (abs(cosine) <= least) cosine = 0
      where (abs(sine) <= least) sine = 0
   end subroutine table_harmonics

   !> Delays a function by `phase`, given by its harmonics; either list may be absent or shorter than the other.
   pure subroutine delay(phase, cosine, sine)
      !> The delay [rad of the first harmonic].
      real(dp), intent(in) :: phase
      !> Amplitudes of the cosines and of the sines, (harmonic).
      real(dp), allocatable, intent(inout) :: cosine(:), sine(:)
      real(dp), allocatable :: a(:), b(:)
      integer :: h, n

      n = 0
      if (allocated(cosine)) n = size(cosine)
      if (allocated(sine)) n = max(n, size(sine))
      allocate (a(n), b(n), source=0.0_dp)
      if (allocated(cosine)) a(:size(cosine)) = cosine
      if (allocated(sine)) b(:size(sine)) = sine
      cosine = [(a(h)*cos(h*phase) - b(h)*sin(h*phase), h=1, n)]
      sine = [(a(h)*sin(h*phase) + b(h)*cos(h*phase), h=1, n)]
   end subroutine delay

   !> Sum over i of Re(amplitude(i) exp(i harmonic(i) phase)).
   pure real(dp) function wave_value(harmonic, amplitude, phase)
      !> Harmonics of Lambda, (harmonic).
      integer, intent(in) :: harmonic(:)
      !> Their complex amplitudes, (harmonic).
      complex(dp), intent(in) :: amplitude(:)
      !> Phase Lambda t [rad].
      real(dp), intent(in) :: phase
      integer :: h

      wave_value = 0
      do h = 1, size(amplitude)
         wave_value = wave_value + real(amplitude(h)*exp(cmplx(0, harmonic(h)*phase, dp)), dp)
      end do
   end function wave_value

end module geartrain_base_series
