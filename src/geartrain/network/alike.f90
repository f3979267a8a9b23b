!> Elements of a train that lie alike, as those of equal branches do: motions of their differences decay at equal rates.
module geartrain_network_alike
   use geartrain_base_kinds, only: dp
   use geartrain_base_sorting, only: ascending
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: share_alike

   !> Keys that differ by less are equal but for rounding.
   real(dp), parameter :: same = 1e-9_dp

contains

   !> Share of the elements that lie alike with so many others or more [1]. Elements are told apart by their own numbers, then again
   !> and again by what their neighbours were told apart by, as long as this makes more kinds. Keys of two kinds could be equal by
   !> chance, but hardly are.
   pure real(dp) function share_alike(system, others)
      type(system_type), intent(in) :: system
      !> How many others.
      integer, intent(in) :: others
      integer :: kind(system%elements), order(system%elements), number(system%elements), i, n, kinds
      real(dp) :: key(system%elements), scale

      share_alike = 0
      ! A chain branches nowhere.
      if (all(system%first(2:) - system%first(:system%elements) <= 2)) return
      scale = maxval(system%own)
      order = [(n, n=1, system%elements)]
      kind = 1
      kinds = 0
      do while (kinds < maxval(kind))
         kinds = maxval(kind)
         do n = 1, system%elements
            key(n) = 8*kind(n) + system%own(n)/scale*sin(1 + system%damping(n))
            do i = system%first(n), system%first(n + 1) - 1
               key(n) = key(n) + system%coupling(i)/scale*cos(real(kind(system%neighbour(i)), dp))
            end do
         end do
         order = order(ascending(key(order)))
         kind(order(1)) = 1
         do n = 2, system%elements
            kind(order(n)) = kind(order(n - 1)) + merge(1, 0, key(order(n)) - key(order(n - 1)) > same)
         end do
      end do
      number = 0
      do n = 1, system%elements
         number(kind(n)) = number(kind(n)) + 1
      end do
      share_alike = sum(number, number > others)/real(system%elements, dp)
   end function share_alike

end module geartrain_network_alike
