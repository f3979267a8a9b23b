!> The pair of multipliers that is on the unit circle at a Neimark-Sacker point.
module geartrain_floquet_critical_pair
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: pair_of

contains

   !> The two multipliers whose product is nearest to 1, or, with a known sum, those nearest to it as well.
   pure function pair_of(multipliers, known) result(pair)
      !> Multipliers, (state).
      complex(dp), intent(in) :: multipliers(:)
      !> Sum of the pair of a neighbouring motion; huge: not known.
      real(dp), intent(in) :: known
      complex(dp) :: pair(2)
      real(dp) :: off, least
      integer :: i, k

      least = huge(1.0_dp)
      pair = 0
      do i = 1, size(multipliers)
         do k = i + 1, size(multipliers)
            associate (total => multipliers(i) + multipliers(k), both => multipliers(i)*multipliers(k))
               if (abs(both%im) > 1e-9_dp*abs(both) .or. abs(total%im) > 1e-9_dp*abs(total)) cycle
               off = abs(both - 1)
               if (known < huge(1.0_dp)) then
                  off = off + abs(total%re - known)
               else if (.not. abs(multipliers(i)%im) > 0) then
                  cycle
               end if
               if (off < least) pair = [multipliers(i), multipliers(k)]
               least = min(off, least)
            end associate
         end do
      end do
   end function pair_of

end module geartrain_floquet_critical_pair
