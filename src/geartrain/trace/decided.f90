!> Whether results read off a branch rest on points whose stability is decided. Points next to a fold or a change of stability are
!> usually undecided, because a multiplier is near the unit circle: the nearest decided points count.
module geartrain_trace_decided
   use geartrain_trace_branch, only: branch_type
   implicit none (type, external)
   private
   public :: is_undecided, joined, nearest_decided, rests_on_undecided, reach

   !> Number of points on either side of a special point that are searched for a decided point.
   integer, parameter :: reach = 5

contains

   !> Whether the stability of a point is undecided; false for a branch without stability.
   pure logical function is_undecided(branch, i)
      type(branch_type), intent(in) :: branch
      !> Index of the point.
      integer, intent(in) :: i

      is_undecided = .false.
      if (allocated(branch%undecided)) is_undecided = branch%undecided(i)
   end function is_undecided

   !> Whether a special point has no decided point on one of its sides, see nearest_decided.
   pure logical function rests_on_undecided(branch, s)
      !> A branch with special points.
      type(branch_type), intent(in) :: branch
      !> Number of the special point.
      integer, intent(in) :: s

      rests_on_undecided = .false.
      if (allocated(branch%undecided)) &
         rests_on_undecided = nearest_decided(branch, s, -1) == 0 .or. nearest_decided(branch, s, 1) == 0
   end function rests_on_undecided

   !> Index of the nearest decided point on one side of a special point; 0 where another special point or the end of the segment
   !> comes first, or `reach` points are undecided.
   pure integer function nearest_decided(branch, s, side) result(i)
      !> A branch with special points.
      type(branch_type), intent(in) :: branch
      !> Number of the special point; side to search: -1 before it, +1 after it.
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
         if (.not. undecided_for(branch, s, i)) return
         i = i + side
      end do
      i = 0
   end function nearest_decided

   !> Whether point i is undecided for special point s: for a fold where its stability is, for other kinds where the number of
   !> multipliers outside the unit circle is.
   pure logical function undecided_for(branch, s, i)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: s, i

      undecided_for = is_undecided(branch, i)
      if (branch%special_points(s)%kind /= 'fold' .and. allocated(branch%count_undecided)) &
         undecided_for = branch%count_undecided(i)
   end function undecided_for

   !> Whether a special point other than s lies between points i and i + 1, or is a fold at one of the two points.
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

   !> Whether points i and i + 1 are neighbours on the branch: of one segment.
   pure logical function joined(branch, i)
      type(branch_type), intent(in) :: branch
      !> Index of the first point, less than branch%points.
      integer, intent(in) :: i

      joined = .true.
      if (allocated(branch%segment)) joined = branch%segment(i) == branch%segment(i + 1)
   end function joined

end module geartrain_trace_decided
