!> Periodic functions as pairs of a harmonic and its complex amplitude.
module geartrain_base_series
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: series_type, make_series, wave_value

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
