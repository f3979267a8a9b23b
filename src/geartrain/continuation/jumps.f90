!> Where a sweep in speed jumps: the stable motion that it follows ends, and it goes over to another one.
module geartrain_continuation_jumps
   use geartrain_base_kinds, only: dp
   use geartrain_continuation_branch, only: branch_type
   use geartrain_continuation_decided, only: is_undecided, joined, nearest_decided, reach
   use geartrain_continuation_summary, only: change
   implicit none (type, external)
   private
   public :: jump_type, jumps

   type :: jump_type
      !> 'jump up' and 'jump down': to a larger or smaller amplitude (all meshes together); 'leaves': this branch has no other
      !> stable motion there.
      character(9) :: kind = ''
      !> Whether the sweep that jumps here goes up in speed, or down.
      logical :: rising = .true.
      !> Lambda.
      real(dp) :: frequency_ratio = 0
      !> Kind of the special point at which the stable motion ends.
      character(16) :: cause = ''
      !> rms before and after, (mesh); after a jump that leaves the branch it is negative.
      real(dp), allocatable :: before(:), after(:)
      !> Other stable motions of the branch at this Lambda: where there are more than one, `after` is a guess, the nearest one.
      integer :: candidates = 0
      !> It rests on undecided points: no decided one near it is stable on one side and none unstable on the other, or the
      !> motion after it is undecided.
      logical :: undecided = .false.
   end type jump_type

contains

   !> The jumps of a branch with stability, by Lambda.
   !>
   !> At a fold with one stable side a sweep along that side has nowhere to go; it falls to another stable motion at that
   !> Lambda. Of those on this branch the one with the nearest rms (all meshes) is taken: which of several a sweep reaches the
   !> branch alone does not tell. Where stability is lost without a fold the motion that takes over lies on another branch.
   pure function jumps(branch) result(found)
      type(branch_type), intent(in) :: branch
      type(jump_type), allocatable :: found(:)
      type(jump_type) :: jump
      integer :: s, i, side

      allocate (found(0))
      if (.not. allocated(branch%stable) .or. .not. allocated(branch%special_points)) return
      do s = 1, size(branch%special_points)
         associate (special => branch%special_points(s))
            side = stable_side(branch, s)
            if (side == 0) cycle
            i = special%point
            if (special%kind == 'fold') i = min(max(1, i + side), branch%points)
            if (special%kind /= 'fold' .and. side > 0) i = i + 1
            jump%frequency_ratio = special%frequency_ratio
            jump%cause = special%kind
            jump%rising = branch%frequency_ratio(i) < special%frequency_ratio
            jump%before = special%rms
            call find_destination(branch, s, jump%after, jump%candidates, jump%undecided)
            if (.not. is_decided(branch, s, side)) jump%undecided = .true.
            jump%kind = 'leaves'
            if (all(jump%after >= 0)) jump%kind = merge('jump up  ', 'jump down', norm2(jump%after) > norm2(jump%before))
         end associate
         if (.not. is_known(jump, found)) call insert(jump, found)
      end do
   end function jumps

   !> Whether decided points to both sides of special point s say that the branch is stable on side `side` of it alone.
   pure logical function is_decided(branch, s, side)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: s, side
      integer :: on, off

      on = nearest_decided(branch, s, side)
      off = nearest_decided(branch, s, -side)
      is_decided = on > 0 .and. off > 0
      if (is_decided) is_decided = branch%stable(on) .and. .not. branch%stable(off)
   end function is_decided

   !> -1 where the branch is stable before a special point and not after it, +1 the other way round, else 0.
   pure integer function stable_side(branch, s) result(side)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: s
      integer :: before, after, first, most, k

      side = 0
      ! A fold is a point of the branch; another special point lies between `point` and the next one.
      first = merge(1, 0, branch%special_points(s)%kind == 'fold')
      ! A truncated balance and its monodromy place one fold slightly apart, and one branch point.
      most = merge(reach, 1, first == 1 .or. branch%special_points(s)%kind == 'branch point')
      do k = 1, most
         before = branch%special_points(s)%point - first - (k - 1)
         after = branch%special_points(s)%point + k
         if (before < 1 .or. after > branch%points) return
         if (.not. joined(branch, before) .or. .not. joined(branch, after - 1)) return
         ! Seen from the branch that leaves there Lambda turns at a branch point: both its sides are alike.
         if (branch%special_points(s)%kind == 'branch point' .and. (branch%frequency_ratio(before) &
                                                                    - branch%special_points(s)%frequency_ratio) &
             *(branch%frequency_ratio(after) - branch%special_points(s)%frequency_ratio) >= 0) return
         if (branch%stable(before) .eqv. branch%stable(after)) then
            if (another_between(branch, s, before - 1, after + 1)) return
            cycle
         end if
         side = merge(-1, 1, branch%stable(before))
         return
      end do
   end function stable_side

   !> Whether another special point lies in the range of points, and may be why stability changes there.
   pure logical function another_between(branch, s, before, after) result(another)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: s, before, after
      integer :: i

      another = .false.
      do i = 1, size(branch%special_points)
         if (i /= s) another = another .or. (branch%special_points(i)%point >= before .and. branch%special_points(i)%point <= after)
      end do
   end function another_between

   !> rms of the nearest other stable motion at the frequency of special point `s`, -1 where there is none, how many there are, and
   !> whether the stability of that motion is undecided.
   pure subroutine find_destination(branch, s, nearest, candidates, undecided)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: s
      real(dp), allocatable, intent(out) :: nearest(:)
      integer, intent(out) :: candidates
      logical, intent(out) :: undecided
      real(dp) :: rms(branch%meshes), share
      integer :: i

      candidates = 0
      undecided = .false.
      allocate (nearest(branch%meshes), source=-1.0_dp)
      if (branch%special_points(s)%kind /= 'fold') return
      associate (f => branch%special_points(s)%frequency_ratio, point => branch%special_points(s)%point)
         do i = 1, branch%points - 1
            if (i == point - 1 .or. i == point .or. .not. joined(branch, i)) cycle
            associate (a => branch%frequency_ratio(i), b => branch%frequency_ratio(i + 1))
               if ((a - f)*(b - f) > 0 .or. abs(b - a) <= 0) cycle
               if (.not. any(branch%stable(i:i + 1))) cycle
               if (turns_at(branch, i, f)) cycle
               if (.not. branch%stable(i) .and. abs(f - a) < abs(change(branch, i) - a)) cycle
               if (.not. branch%stable(i + 1) .and. abs(f - a) > abs(change(branch, i) - a)) cycle
               share = (f - a)/(b - a)
            end associate
            rms = (1 - share)*branch%rms(:, i) + share*branch%rms(:, i + 1)
            candidates = candidates + 1
            if (all(nearest >= 0) .and. norm2(rms - branch%special_points(s)%rms) &
                >= norm2(nearest - branch%special_points(s)%rms)) cycle
            nearest = rms
            undecided = is_undecided(branch, i) .and. is_undecided(branch, i + 1)
         end do
      end associate
   end subroutine find_destination

   !> Whether the branch turns at point i or i + 1, at this frequency to rounding, as it does at the mirror image of a fold
   !> where the stages are equal: the motion there ends as well.
   pure logical function turns_at(branch, i, frequency_ratio)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: i
      real(dp), intent(in) :: frequency_ratio

      associate (special => branch%special_points)
         turns_at = any(special%kind == 'fold' .and. (special%point == i .or. special%point == i + 1) &
                        .and. abs(special%frequency_ratio - frequency_ratio) < 1e-9_dp*frequency_ratio)
      end associate
   end function turns_at

   !> Two parts of a branch may pass the same fold.
   pure logical function is_known(jump, found)
      type(jump_type), intent(in) :: jump, found(:)
      integer :: i

      is_known = .false.
      do i = 1, size(found)
         if (abs(found(i)%frequency_ratio - jump%frequency_ratio) > 1e-6_dp*jump%frequency_ratio) cycle
         if (found(i)%rising .neqv. jump%rising) cycle
         if (norm2(found(i)%before - jump%before) < 1e-3_dp*norm2(jump%before)) is_known = .true.
      end do
   end function is_known

   !> In the order of Lambda.
   pure subroutine insert(jump, found)
      type(jump_type), intent(in) :: jump
      type(jump_type), allocatable, intent(inout) :: found(:)
      integer :: n

      n = count(found%frequency_ratio <= jump%frequency_ratio)
      found = [found(:n), jump, found(n + 1:)]
   end subroutine insert

end module geartrain_continuation_jumps
