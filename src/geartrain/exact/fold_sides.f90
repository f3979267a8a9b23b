!> On which side of its folds each point of a branch is. Along a branch the number of real multipliers above 1 changes by one at a
!> fold and at a branch point, and by pairs elsewhere: whether it is odd tells the two sides of a fold apart, also where the points
!> are so near to the fold that their own multipliers do not.
module geartrain_exact_fold_sides
   use geartrain_base_kinds, only: dp
   use geartrain_floquet_multipliers, only: are_numbers, side_of_fold
   use geartrain_trace_branch, only: branch_type, multipliers_at
   use geartrain_trace_decided, only: joined
   implicit none (type, external)
   private
   public :: sides_of

contains

   !> The side of each point as `side_of_fold` counts it; -1: not known, as without stability, (point).
   pure function sides_of(branch) result(side)
      !> The branch.
      type(branch_type), intent(in) :: branch
      integer :: side(branch%points)
      integer :: first, last

      side = -1
      if (.not. allocated(branch%stable) .or. .not. allocated(branch%special_points) .or. branch%states == 0) return
      first = 1
      do last = 1, branch%points
         if (last < branch%points) then
            if (.not. turns(branch, last)) cycle
         end if
         side(first:last) = side_between(branch, first, last)
         first = last + 1
      end do
   end function sides_of

   !> Whether the side changes between point i and the next one. A fold is a point of the branch; it counts to the side before it.
   pure logical function turns(branch, i)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: i

      associate (special => branch%special_points)
         turns = any(special%point == i .and. (special%kind == 'fold' .or. special%kind == 'branch point'))
         turns = turns .or. .not. joined(branch, i)
      end associate
   end function turns

   !> The side of a piece of a branch without turns: that of its point whose multipliers are farthest from +1.
   pure integer function side_between(branch, first, last) result(side)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: first, last
      complex(dp) :: multipliers(branch%states)
      real(dp) :: distance, farthest
      integer :: i

      side = -1
      farthest = 0
      do i = first, last
         if (branch%count_undecided(i)) cycle
         multipliers = multipliers_at(branch, i)
         if (.not. are_numbers(multipliers)) cycle
         distance = minval([1.0_dp, pack(abs(multipliers%re - 1), abs(multipliers%im) <= 0)])
         if (distance <= farthest) cycle
         farthest = distance
         side = side_of_fold(multipliers)
      end do
   end function side_between

end module geartrain_exact_fold_sides
