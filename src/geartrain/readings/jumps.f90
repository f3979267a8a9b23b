!> Jumps of a slow sweep in speed: the stable motion that the sweep follows ends, and another stable motion takes over.
module geartrain_readings_jumps
   use geartrain_base_kinds, only: dp
   use geartrain_readings_curve, only: rms_at
   use geartrain_readings_summary, only: change
   use geartrain_trace_branch, only: branch_type, special_point_type
   use geartrain_trace_decided, only: is_undecided, joined, nearest_decided, reach
   implicit none (type, external)
   private
   public :: jump_type, jumps

   type :: jump_type
      !> 'jump up', 'jump down': to a larger or smaller amplitude (all meshes together); 'leaves': the branch has no other stable
      !> motion at this Lambda, or stability is lost without a fold, and the sweep may go on beside the branch.
      character(9) :: kind = ''
      !> The sweep that jumps goes up in speed; else down.
      logical :: rising = .true.
      !> Lambda [1].
      real(dp) :: frequency_ratio = 0
      !> Kind of the special point at which the stable motion ends.
      character(24) :: cause = ''
      !> rms before and after the jump over characteristic length [1], (mesh); `after` is negative for 'leaves'.
      real(dp), allocatable :: before(:), after(:)
      !> Number of the point of the branch before the motion after the jump; 0: there is none.
      integer :: point = 0
      !> Number of other stable motions of the branch at this Lambda: if more than 1, `after` is a guess.
      integer :: candidates = 0
      !> The jump is a guess: the nearest decided points are not stable on one side and unstable on the other, or the motion after
      !> the jump is undecided, or another stable motion ends within the estimated errors of both folds.
      logical :: undecided = .false.
   end type jump_type

contains

   !> The jumps of a branch, ascending in Lambda; none without stability.
   !>
   !> At a fold with one stable side, a sweep along this side jumps to another stable motion at the Lambda of the fold. If the
   !> branch has several, the motion of nearest rms (all meshes) is taken: which motion a sweep reaches, the branch does not tell.
   !> Where stability is lost without a fold, the next motion lies on another branch, unless the sweep jumps.
   pure function jumps(branch) result(found)
      !> A branch, with or without stability.
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
            if (special%kind == 'fold') jump%rising = is_top(branch, s)
            jump%before = special%rms
            call find_destination(branch, s, jump%after, jump%point, jump%candidates, jump%undecided)
            if (.not. is_decided(branch, s, side)) jump%undecided = .true.
            jump%kind = 'leaves'
            if (all(jump%after >= 0)) jump%kind = merge('jump up  ', 'jump down', norm2(jump%after) > norm2(jump%before))
         end associate
         if (.not. is_known(jump, found)) call insert(jump, found)
      end do
   end function jumps

   !> Whether the nearest decided points of special point s are stable on side `side` and unstable on the other side.
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
      if (branch%special_points(s)%kind == 'fold') then
         ! Next to a fold a multiplier is near to 1, and verdicts there are guesses.
         before = nearest_decided(branch, s, -1)
         after = nearest_decided(branch, s, 1)
         if (before > 0 .and. after > 0) then
            if (branch%stable(before) .neqv. branch%stable(after)) side = merge(-1, 1, branch%stable(before))
            if (side /= 0) return
         end if
      end if
      ! A fold is a point of the branch; another special point lies between `point` and the next one.
      first = merge(1, 0, branch%special_points(s)%kind == 'fold')
      ! The balance and the monodromy matrix place a fold, or a branch point, slightly apart.
      most = merge(reach, 1, first == 1 .or. branch%special_points(s)%kind == 'branch point')
      do k = 1, most
         before = branch%special_points(s)%point - first - (k - 1)
         after = branch%special_points(s)%point + k
         if (before < 1 .or. after > branch%points) return
         if (.not. joined(branch, before) .or. .not. joined(branch, after - 1)) return
         ! At a branch point Lambda turns along the branch that leaves: its two sides are alike.
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

   !> Whether Lambda is largest at fold s: by several points on both sides, since points with other harmonics may lie beyond the
   !> fold.
   pure logical function is_top(branch, s)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: s
      real(dp) :: turn
      integer :: i, k, side

      turn = 0
      associate (fold => branch%special_points(s))
         do side = -1, 1, 2
            do k = 1, reach
               i = fold%point + k*side
               if (i < 1 .or. i > branch%points) exit
               if (.not. joined(branch, min(i, i - side))) exit
               turn = turn + branch%frequency_ratio(i) - fold%frequency_ratio
               if (any(branch%special_points%kind == 'fold' .and. branch%special_points%point == i)) exit
            end do
         end do
      end associate
      is_top = turn < 0
   end function is_top

   !> Whether a special point other than s, which may change stability too, lies between the points `before` and `after`.
   pure logical function another_between(branch, s, before, after) result(another)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: s, before, after
      integer :: i

      another = .false.
      do i = 1, size(branch%special_points)
         if (i /= s) another = another .or. (branch%special_points(i)%point >= before .and. branch%special_points(i)%point <= after)
      end do
   end function another_between

   !> Other stable motions at the Lambda of special point s.
   pure subroutine find_destination(branch, s, nearest, point, candidates, undecided)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: s
      !> rms of the motion nearest in rms, (mesh); -1: none.
      real(dp), allocatable, intent(out) :: nearest(:)
      !> Number of the point before it, 0: none; number of motions.
      integer, intent(out) :: point, candidates
      !> Stability of the nearest motion is undecided, or which motions there are is.
      logical, intent(out) :: undecided
      real(dp) :: rms(branch%meshes)
      integer :: i, own(2)

      candidates = 0
      point = 0
      undecided = .false.
      allocate (nearest(branch%meshes), source=-1.0_dp)
      own = branch%special_points(s)%point + [0, 1]
      if (branch%special_points(s)%kind == 'fold') own = own_points(branch, s)
      associate (f => branch%special_points(s)%frequency_ratio)
         do i = 1, branch%points - 1
            if (i >= own(1) .and. i < own(2) .or. .not. joined(branch, i)) cycle
            associate (a => branch%frequency_ratio(i), b => branch%frequency_ratio(i + 1))
               if ((a - f)*(b - f) > 0 .or. abs(b - a) <= 0) cycle
               ! A point at this Lambda counts once.
               if (abs(b - f) <= 0 .and. .not. ends_at(branch, i + 1)) cycle
               if (.not. any(branch%stable(i:i + 1))) cycle
               if (turns_at(branch, i, f)) cycle
               if (.not. branch%stable(i) .and. abs(f - a) < abs(change(branch, i) - a)) cycle
               if (.not. branch%stable(i + 1) .and. abs(f - a) > abs(change(branch, i) - a)) cycle
            end associate
            rms = rms_at(branch, i, f)
            candidates = candidates + 1
            if (all(nearest >= 0) .and. norm2(rms - branch%special_points(s)%rms) &
                >= norm2(nearest - branch%special_points(s)%rms)) cycle
            nearest = rms
            point = i
            undecided = is_undecided(branch, i) .and. is_undecided(branch, i + 1)
         end do
      end associate
      if (branch%special_points(s)%kind /= 'fold') then
         nearest = -1
         point = 0
         undecided = .false.
         return
      end if
      do i = 1, size(branch%special_points)
         if (i /= s .and. .not. undecided) undecided = ends_near(branch, s, i)
      end do
   end subroutine find_destination

   !> Whether a segment of the branch ends at point i.
   pure logical function ends_at(branch, i)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: i

      ends_at = i == branch%points
      if (.not. ends_at) ends_at = .not. joined(branch, i)
   end function ends_at

   !> First and last of the points next to fold s that are no motions after a jump: the exact fold lies off the point where the
   !> balance turns, the points between the two are beyond the exact fold, and up to the nearest decided points the branch is at
   !> the fold still.
   pure function own_points(branch, s) result(own)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: s
      integer :: own(2)
      integer :: i, side, turn

      associate (special => branch%special_points(s))
         own = special%point
         turn = merge(-1, 1, is_top(branch, s))
         do side = 1, 2
            associate (at => own(side), step => 2*side - 3)
               do
                  if (at + step < 1 .or. at + step > branch%points) exit
                  if (.not. joined(branch, min(at, at + step))) exit
                  at = at + step
                  ! On the side of the fold on which its motions are.
                  if (turn*(branch%frequency_ratio(at) - special%frequency_ratio) > 0) exit
               end do
            end associate
            i = nearest_decided(branch, s, 2*side - 3)
            if (side == 1 .and. i > 0) own(1) = min(own(1), i)
            if (side == 2 .and. i > 0) own(2) = max(own(2), i)
         end do
      end associate
   end function own_points

   !> Whether a stable motion ends at fold i so near to the Lambda of fold s that the errors of the two decide whether it is there.
   pure logical function ends_near(branch, s, i)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: s, i

      ends_near = .false.
      associate (fold => branch%special_points(s), other => branch%special_points(i))
         if (other%kind /= 'fold') return
         if (abs(other%frequency_ratio - fold%frequency_ratio) >= error_of(branch, fold) + error_of(branch, other)) return
         if (turns_at(branch, other%point, fold%frequency_ratio)) return
         ends_near = stable_side(branch, i) /= 0
      end associate
   end function ends_near

   !> Estimated error of the Lambda of a special point: none where it was made exact.
   pure real(dp) function error_of(branch, special) result(error)
      type(branch_type), intent(in) :: branch
      type(special_point_type), intent(in) :: special

      error = 0
      if (special%correction >= 0) return
      if (allocated(branch%error_estimate)) error = branch%error_estimate(special%point)
      if (allocated(branch%correction)) error = max(error, branch%correction(special%point))
      error = error*special%frequency_ratio
   end function error_of

   !> Whether point i or i + 1 is a fold at this Lambda, up to rounding, as the mirror image of a fold of a train with equal stages:
   !> the stable motion ends there as well.
   pure logical function turns_at(branch, i, frequency_ratio)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: i
      real(dp), intent(in) :: frequency_ratio

      associate (special => branch%special_points)
         turns_at = any(special%kind == 'fold' .and. (special%point == i .or. special%point == i + 1) &
                        .and. abs(special%frequency_ratio - frequency_ratio) < 1e-9_dp*abs(frequency_ratio))
      end associate
   end function turns_at

   !> Whether `found` has this jump already: two segments of a branch may pass one fold.
   pure logical function is_known(jump, found)
      type(jump_type), intent(in) :: jump, found(:)
      integer :: i

      is_known = .false.
      do i = 1, size(found)
         if (abs(found(i)%frequency_ratio - jump%frequency_ratio) > 1e-6_dp*abs(jump%frequency_ratio)) cycle
         if (found(i)%rising .neqv. jump%rising) cycle
         if (norm2(found(i)%before - jump%before) < 1e-3_dp*norm2(jump%before)) is_known = .true.
      end do
   end function is_known

   !> Inserts a jump into a list ascending in Lambda.
   pure subroutine insert(jump, found)
      type(jump_type), intent(in) :: jump
      type(jump_type), allocatable, intent(inout) :: found(:)
      type(jump_type) :: longer(size(found) + 1)
      integer :: n

      ! Not by an array constructor: gfortran 12 does not free the allocatable components of its elements.
      n = count(found%frequency_ratio <= jump%frequency_ratio)
      longer(:n) = found(:n)
      longer(n + 1) = jump
      longer(n + 2:) = found(n + 1:)
      found = longer
   end subroutine insert

end module geartrain_readings_jumps
