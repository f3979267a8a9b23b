!> Which slow sweeps in speed, rising or falling, cannot reach a motion of a branch, because its stable curve begins at a fold.
module geartrain_readings_slow_sweeps
   use geartrain_base_kinds, only: dp
   use geartrain_readings_jumps, only: jump_type, jumps
   use geartrain_trace_branch, only: branch_type
   use geartrain_trace_decided, only: is_undecided, joined
   implicit none (type, external)
   private
   public :: is_out_of_reach

   !> Most points between the last stable point and the fold at which stability ends.
   integer, parameter :: near_fold = 3
   !> Relative distance of a fold from its point, by the balance and by stability [1].
   real(dp), parameter :: same = 1e-4_dp
   !> Relative error of the motion at a fold from which on the fold may not exist [1].
   real(dp), parameter :: useless = 0.1_dp

contains

   !> Whether a sweep over the whole range cannot reach a stable motion: against the direction of the sweep the stable curve through
   !> the motion ends in a fold, the branch has another stable motion there, on which the sweep passes, and the sweep does not jump
   !> to the curve before the motion. False where this is not known: where stability ends without a fold, or where a jump leads to
   !> another branch.
   pure logical function is_out_of_reach(branch, point, direction)
      !> A branch with stability.
      type(branch_type), intent(in) :: branch
      !> Index of a stable point.
      integer, intent(in) :: point
      !> Direction of the sweep: +1 rising, -1 falling.
      integer, intent(in) :: direction
      type(jump_type), allocatable :: found(:)
      real(dp) :: fold, low, high
      integer :: last, i

      is_out_of_reach = .false.
      call follow_back(branch, point, direction, last, fold)
      if (last == 0) return
      found = jumps(branch)
      low = min(fold, branch%frequency_ratio(point))
      high = max(fold, branch%frequency_ratio(point))
      do i = 1, size(found)
         associate (jump => found(i))
            if (jump%rising .neqv. direction > 0) cycle
            if (jump%frequency_ratio < low .or. jump%frequency_ratio > high) cycle
            ! A fold at the point itself: the sweep leaves here.
            if (abs(jump%frequency_ratio - branch%frequency_ratio(point)) < same*abs(jump%frequency_ratio)) cycle
            if (jump%kind == 'leaves' .or. jump%candidates > 1) return
            if (jump%point >= min(last, point) - 1 .and. jump%point <= max(last, point)) return
         end associate
      end do
      do i = 1, branch%points - 1
         if (i >= min(last, point) - near_fold .and. i <= max(last, point) + near_fold) cycle
         if (.not. (joined(branch, i) .and. branch%stable(i) .and. branch%stable(i + 1))) cycle
         if ((branch%frequency_ratio(i) - fold)*(branch%frequency_ratio(i + 1) - fold) <= 0) is_out_of_reach = .true.
      end do
   end function is_out_of_reach

   !> Follows the stable curve through a point against the direction of a sweep, up to the fold at which it ends.
   pure subroutine follow_back(branch, point, direction, last, fold)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: point, direction
      !> Index of the last stable point; 0: the curve does not end in a fold, or in one that may not exist.
      integer, intent(out) :: last
      !> Lambda of the fold [1].
      real(dp), intent(out) :: fold
      integer :: step, k

      last = point
      step = merge(1, -1, goes_back(point, 1))
      do while (.not. is_turn(last))
         if (.not. goes_back(last, step)) then
            last = 0
            return
         end if
         if (.not. (branch%stable(last + step) .or. is_undecided(branch, last + step))) exit
         last = last + step
      end do
      ! Stability may end slightly before the fold.
      do k = 0, near_fold
         fold = branch%frequency_ratio(last + k*step)
         if (is_turn(last + k*step)) then
            if (branch%error_estimate(last + k*step) > useless) last = 0
            return
         end if
         if (.not. is_neighbour(last + k*step, step)) exit
      end do
      last = 0

   contains

      pure logical function is_neighbour(j, side)
         integer, intent(in) :: j, side

         is_neighbour = j + side >= 1 .and. j + side <= branch%points
         if (is_neighbour) is_neighbour = joined(branch, min(j, j + side))
      end function is_neighbour

      !> Whether the sweep passes point j + side before point j.
      pure logical function goes_back(j, side)
         integer, intent(in) :: j, side

         goes_back = is_neighbour(j, side)
         if (goes_back) goes_back = direction*(branch%frequency_ratio(j + side) - branch%frequency_ratio(j)) < 0
      end function goes_back

      !> Whether the curve turns at point j: both neighbours come later in the sweep.
      pure logical function is_turn(j)
         integer, intent(in) :: j

         is_turn = is_neighbour(j, 1) .and. is_neighbour(j, -1) .and. .not. (goes_back(j, 1) .or. goes_back(j, -1))
      end function is_turn

   end subroutine follow_back

end module geartrain_readings_slow_sweeps
