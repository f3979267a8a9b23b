!> Whether what is read off a branch rests on points whose stability is decided. Next to a fold or a change of stability points are
!> undecided as a rule, because a multiplier is near the unit circle there: what counts is whether decided points follow soon.
module geartrain_continuation_decided
   use geartrain_continuation_branch, only: branch_type
   implicit none (type, external)
   private
   public :: is_undecided, joined, nearest_decided, rests_on_undecided, reach

   !> Points to either side of a special point that tell what happens there.
   integer, parameter :: reach = 5

contains

   !> Whether the stability of point i is a guess; false where stability was not asked for.
   pure logical function is_undecided(branch, i)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: i

      is_undecided = .false.
      if (allocated(branch%undecided)) is_undecided = branch%undecided(i)
   end function is_undecided

   !> Whether special point s has only undecided points on one of its sides, up to the next special point or the end of the part.
   pure logical function rests_on_undecided(branch, s)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: s

      rests_on_undecided = .false.
      if (allocated(branch%undecided)) &
         rests_on_undecided = nearest_decided(branch, s, -1) == 0 .or. nearest_decided(branch, s, 1) == 0
   end function rests_on_undecided

   !> Index of the nearest point before (side = -1) or after (+1) special point s that tells, being decided, what happens there;
   !> 0 where another special point or an end of the part comes first, or there is none in reach.
   pure integer function nearest_decided(branch, s, side) result(i)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: s, side
      integer :: k, from

      ! A fold is a point of the branch; another special point lies between `point` and the next one.
      from = branch%special_points(s)%point
      if (branch%special_points(s)%kind /= 'fold' .and. side > 0) from = from + 1
      i = from
      if (branch%special_points(s)%kind == 'fold') i = from + side
      do k = 1, reach
         if (i < 1 .or. i > branch%points) exit
         if (i /= from) then
            if (.not. joined(branch, min(i, i - side))) exit
            if (another_between(branch, s, min(i, i - side))) exit
         end if
         if (.not. tells_nothing(branch, s, i)) return
         i = i + side
      end do
      i = 0
   end function nearest_decided

   !> Whether point i says nothing of special point s: a fold is there whatever else passes the circle, the others are told by the
   !> number of multipliers outside it.
   pure logical function tells_nothing(branch, s, i)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: s, i

      tells_nothing = is_undecided(branch, i)
      if (branch%special_points(s)%kind /= 'fold' .and. allocated(branch%count_undecided)) &
         tells_nothing = branch%count_undecided(i)
   end function tells_nothing

   !> Whether another special point than s lies between points i and i + 1, or is one of them but not the fold s.
   pure logical function another_between(branch, s, i) result(another)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: s, i
      integer :: k

      another = .false.
      do k = 1, size(branch%special_points)
         if (k == s) cycle
         associate (special => branch%special_points(k))
            if (special%kind == 'fold') then
               another = another .or. special%point == i .or. special%point == i + 1
            else
               another = another .or. special%point == i
            end if
         end associate
      end do
   end function another_between

   !> Points i and i + 1 follow one another on the branch: they are of one part.
   pure logical function joined(branch, i)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: i

      joined = .true.
      if (allocated(branch%segment)) joined = branch%segment(i) == branch%segment(i + 1)
   end function joined

end module geartrain_continuation_decided
