!> Sorting.
module geartrain_base_sorting
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: ascending

contains

   !> Order in which keys ascend: keys(order(1)) is the smallest. Equal keys keep their order. By merging.
   pure function ascending(keys) result(order)
      !> Any numbers; -keys for the descending order.
      real(dp), intent(in) :: keys(:)
      integer :: order(size(keys)), merged(size(keys)), first, i, j, k, last, length, middle

      order = [(i, i=1, size(keys))]
      length = 1
      do while (length < size(keys))
         do first = 1, size(keys), 2*length
            middle = min(first + length, size(keys) + 1)
            last = min(first + 2*length, size(keys) + 1)
            i = first
            j = middle
            do k = first, last - 1
               if (takes_left(i, j)) then
                  merged(k) = order(i)
                  i = i + 1
               else
                  merged(k) = order(j)
                  j = j + 1
               end if
            end do
         end do
         order = merged
         length = 2*length
      end do

   contains

      pure logical function takes_left(i, j)
         integer, intent(in) :: i, j

         takes_left = i < middle
         if (takes_left .and. j < last) takes_left = .not. keys(order(j)) < keys(order(i))
      end function takes_left

   end function ascending

end module geartrain_base_sorting
