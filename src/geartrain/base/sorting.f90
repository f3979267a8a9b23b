!> Sorting.
module geartrain_base_sorting
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: ascending

contains

   !> Order in which keys ascend: keys(order(1)) is the smallest. Equal keys keep their order. By insertion, for some hundred keys.
   pure function ascending(keys) result(order)
      !> Any numbers; -keys for the descending order.
      real(dp), intent(in) :: keys(:)
      integer :: order(size(keys)), i, j

      do i = 1, size(keys)
         do j = i - 1, 1, -1
            if (keys(order(j)) <= keys(i)) exit
            order(j + 1) = order(j)
         end do
         order(j + 1) = i
      end do
   end function ascending

end module geartrain_base_sorting
