!> Means over a flight in which oscillations average out.
module geartrain_flow_smooth_mean
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: weighted_mean

contains

   !> Mean with the weights exp(-1/(t (1 - t))), t from 0 to 1: the weights, with all derivatives, are 0 at the ends.
   pure real(dp) function weighted_mean(values) result(mean)
      !> The values in their order.
      real(dp), intent(in) :: values(:)
      real(dp) :: weight(size(values)), t
      integer :: i

      mean = 0
      if (size(values) == 0) return
      do i = 1, size(values)
         t = (i - 0.5_dp)/size(values)
         weight(i) = exp(4 - 1/(t*(1 - t)))
      end do
      mean = sum(weight*values)/sum(weight)
   end function weighted_mean

end module geartrain_flow_smooth_mean
