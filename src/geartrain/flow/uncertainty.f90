!> What a longer window would change of the figures of a window, from how the figures of its parts differ.
module geartrain_flow_uncertainty
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: figure_uncertainty_type, uncertainty_of

   !> Parts of a window; Student's t at 95 % for parts - 1 degrees of freedom.
   integer, parameter :: parts = 8
   real(dp), parameter :: student = 2.36_dp
   !> Growth of an extreme over a window ten times as long, over the standard deviation of the extremes of the parts: the 95 %
   !> quantile of Gumbel's distribution for 80 parts, less its mean for 8 (ln 80 + 2.97 - ln 8 - 0.58 over pi/sqrt(6), 3.7), and a
   !> fifth more, since the deviation of eight parts is uncertain itself.
   real(dp), parameter :: growth = 4.4_dp

   !> Uncertainty of the mean, the root of twice the mean square less the mean, the smallest and the largest value of a signal.
   type :: figure_uncertainty_type
      real(dp) :: mean = 0, rms = 0, minimum = 0, maximum = 0
   end type figure_uncertainty_type

contains

   !> Uncertainty of the figures of a signal.
   pure type(figure_uncertainty_type) function uncertainty_of(signal) result(uncertainty)
      !> Equidistant samples of the signal, in any unit.
      real(dp), intent(in) :: signal(:)
      real(dp), dimension(parts) :: mean, square, low, high
      real(dp) :: middle
      integer :: i, n, first, last

      n = size(signal)
      middle = sum(signal)/n
      do i = 1, parts
         first = ((i - 1)*n)/parts + 1
         last = (i*n)/parts
         associate (part => signal(first:max(first, last)))
            mean(i) = sum(part)/size(part)
            square(i) = sum((part - middle)**2)/size(part)
            low(i) = minval(part)
            high(i) = maxval(part)
         end associate
      end do
      uncertainty%mean = student*deviation(mean)/sqrt(real(parts, dp))
      associate (whole => sum(square)/parts, change => student*deviation(square)/sqrt(real(parts, dp)))
         uncertainty%rms = sqrt(2*whole) - sqrt(2*max(whole - change, 0.0_dp))
      end associate
      uncertainty%minimum = growth*deviation(low)
      uncertainty%maximum = growth*deviation(high)
   end function uncertainty_of

   !> Standard deviation of the values of the parts.
   pure real(dp) function deviation(values)
      real(dp), intent(in) :: values(:)

      deviation = sqrt(sum((values - sum(values)/size(values))**2)/(size(values) - 1))
   end function deviation

end module geartrain_flow_uncertainty
