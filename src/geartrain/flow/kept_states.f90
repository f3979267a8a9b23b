!> Multipliers and verdict of an orbit. The twist of a coupling that sticks throughout the period may be any that its friction can
!> hold: the orbit is one of many, and its multiplier 1 along them says nothing of whether a disturbance dies out or grows.
module geartrain_flow_kept_states
   use geartrain_base_kinds, only: dp
   use geartrain_floquet_multipliers, only: is_neutral, is_stable, multipliers_of
   implicit none (type, external)
   private
   public :: judge, keeps

contains

   !> Which values of a state the period leaves as they are: their rows are those of the unit matrix, without rounding.
   pure function keeps(monodromy) result(kept)
      !> Monodromy matrix [1], (state, state).
      real(dp), intent(in) :: monodromy(:, :)
      logical :: kept(size(monodromy, 1))
      integer :: k

      do k = 1, size(kept)
         kept(k) = count(abs(monodromy(k, :)) > 0) == 1 .and. .not. abs(monodromy(k, k) - 1) > 0
      end do
   end function keeps

   !> Finds the multipliers, and whether all are inside the unit circle but for those of values that are kept.
   subroutine judge(monodromy, multipliers, stable, undecided)
      !> Monodromy matrix [1], (state, state).
      real(dp), intent(in) :: monodromy(:, :)
      !> Its eigenvalues, largest magnitude first.
      complex(dp), intent(out) :: multipliers(:)
      !> Whether the orbit is stable, and whether this is a guess.
      logical, intent(out) :: stable, undecided
      complex(dp), allocatable :: others(:)
      integer, allocatable :: moving(:)
      integer :: k

      multipliers = multipliers_of(monodromy)
      moving = pack([(k, k=1, size(multipliers))], .not. keeps(monodromy))
      others = multipliers
      if (size(moving) < size(multipliers)) others = multipliers_of(monodromy(moving, moving))
      stable = .true.
      undecided = .false.
      if (size(moving) == 0) return
      stable = is_stable(others)
      undecided = is_neutral(others)
   end subroutine judge

end module geartrain_flow_kept_states
