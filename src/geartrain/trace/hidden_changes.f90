!> Changes of stability that come in pairs between two neighbouring points of a branch: multipliers that cross the unit circle and
!> come back within a step, so that both ends have as many outside.
!>
!> Of each kind of crossing the distance from the circle of the multiplier next to it is a function along the branch, known at the
!> two points and at the points before and after them. Parabolas through three of the four points estimate how near to the circle it
!> comes within the step. Where the circle is within reach of the estimate and its uncertainty, the multipliers are computed at the
!> place of the estimate, a few times at most. The uncertainty is a share of what the function varies by at the four points.
module geartrain_trace_hidden_changes
   use geartrain_base_kinds, only: dp
   use geartrain_floquet_monodromy, only: monodromy_type
   use geartrain_floquet_multipliers, only: are_numbers
   use geartrain_trace_branch, only: branch_type, multipliers_at, special_point_type
   use geartrain_trace_circle_samples, only: distance_of, far, most_places, none, samples_type
   use geartrain_trace_corrector, only: corrector_type, solution_point_type
   use geartrain_trace_linearized_motion, only: solution_on
   use geartrain_trace_points, only: motion_of
   use geartrain_trace_stability_changes, only: doubling, find_multipliers, largest_multiplier, neimark_sacker, outside, &
      piece_type, separate
   implicit none (type, external)
   private
   public :: add_hidden_changes

   !> Uncertainty of the estimate, as a share of the variation of the function at the four points.
   real(dp), parameter :: uncertain = 0.25_dp

contains

   !> Lists the pairs of changes of stability in some steps of a branch. An interrupt drops them: the run that goes on finds them.
   subroutine add_hidden_changes(corrector, monodromy, first, last, branch, kept)
      type(corrector_type), intent(inout) :: corrector
      !> Monodromy matrix set up for the system; work space.
      type(monodromy_type), intent(inout) :: monodromy
      !> Numbers of the points before the first and the last step.
      integer, intent(in) :: first, last
      !> Branch with multipliers; its `special_points` grow.
      type(branch_type), intent(inout), target :: branch
      !> Number of special points that an interrupt of the next steps leaves; grows likewise.
      integer, intent(inout) :: kept
      type(special_point_type), allocatable :: listed(:)
      integer :: i

      if (branch%states == 0) return
      listed = branch%special_points
      do i = max(1, first), min(last, branch%points - 1)
         call add_in_step(corrector, monodromy, i, branch)
      end do
      if (corrector%balance%system%interrupt%raised()) branch%special_points = listed
      kept = kept + size(branch%special_points) - size(listed)
   end subroutine add_hidden_changes

   !> Lists the pairs of changes of stability between point i and point i + 1 of a branch.
   subroutine add_in_step(corrector, monodromy, i, branch)
      type(corrector_type), intent(inout) :: corrector
      !> Monodromy matrix set up for the system; work space.
      type(monodromy_type), intent(inout) :: monodromy
      !> Number of the point before the step.
      integer, intent(in) :: i
      !> Branch with multipliers; its `special_points` grow.
      type(branch_type), intent(inout), target :: branch
      complex(dp) :: multipliers(branch%states, -1:2)
      real(dp) :: f(-1:2)
      logical :: known(-1:2), found
      real(dp) :: apart(-1:1)
      integer :: counted(3), changed(3), k, kind, number, sense
      type(samples_type) :: samples
      type(piece_type) :: piece
      type(solution_point_type) :: chord

      if (branch%segment(i) /= branch%segment(i + 1)) return
      do k = -1, 2
         known(k) = i + k >= 1 .and. i + k <= branch%points
         if (known(k)) known(k) = branch%segment(i + k) == branch%segment(i)
         if (.not. known(k)) cycle
         multipliers(:, k) = multipliers_at(branch, i + k)
         known(k) = are_numbers(multipliers(:, k))
      end do
      if (.not. (known(0) .and. known(1)) .or. count(known) < 3) return
      if (max(abs(multipliers(1, 0)), abs(multipliers(1, 1))) > largest_multiplier) return
      counted = outside(multipliers(:, 0))
      changed = outside(multipliers(:, 1)) - counted
      ! The step was looked at before, as where a run was interrupted.
      if (any(branch%special_points%point == i .and. (branch%special_points%kind == 'period doubling' .or. &
                                                      branch%special_points%kind == 'neimark-sacker'))) return
      apart = 0
      do k = -1, 1
         if (known(k) .and. known(k + 1)) apart(k) = branch%arclength(i + k + 1) - branch%arclength(i + k)
      end do
      do kind = doubling, neimark_sacker
         ! Next to a fold a multiplier passes 1, which is no change of these kinds.
         if (changed(kind) /= 0) cycle
         do sense = 1, -1, -2
            ! The next one to leave the circle, and the last one that has left it.
            number = counted(kind) + merge(1, 0, sense > 0)
            if (number == 0) cycle
            f = none
            do k = -1, 2
               if (known(k)) f(k) = sense*distance_of(multipliers(:, k), kind, number)
               if (abs(f(k)) >= -none) f(k) = none
            end do
            if (any(f(0:1) <= none) .or. all(f(0:1) < -far) .or. any(f(0:1) >= 0)) cycle
            call begin_samples()
            if (.not. samples%reach_circle(apart(0), uncertain, .false.)) cycle
            call look(found)
            if (found) return
         end do
      end do

   contains

      subroutine begin_samples()
         samples%taken = 0
         if (f(-1) > none) call samples%insert(-apart(-1), f(-1))
         call samples%insert(0.0_dp, f(0))
         call samples%insert(apart(0), f(1))
         if (f(2) > none) call samples%insert(apart(0) + apart(1), f(2))
      end subroutine begin_samples

      !> Computes multipliers where the function may be highest.
      subroutine look(found)
         logical, intent(out) :: found
         type(solution_point_type) :: solution
         complex(dp) :: between(branch%states)
         real(dp) :: s, peak, value
         integer :: n, counts(3)
         logical :: success

         found = .false.
         call orient_ends()
         do n = 1, most_places
            call samples%highest(piece%length, s, peak)
            call find_multipliers(corrector, monodromy, piece, 0.0_dp, piece%length, .true., s, solution, between, success)
            if (.not. success) return
            counts = outside(between)
            found = counts(kind) /= counted(kind)
            if (found) then
               call separate(corrector, monodromy, piece, 0.0_dp, s, multipliers(:, 0), between, i + 1, branch)
               call separate(corrector, monodromy, piece, s, piece%length, between, multipliers(:, 1), i + 1, branch)
               return
            end if
            value = sense*distance_of(between, kind, number)
            if (abs(value) >= -none) return
            call samples%insert(s, value)
            if (.not. samples%reach_circle(piece%length, uncertain, .true.)) return
         end do
      end subroutine look

      !> Finds the ends of the step with their tangents.
      subroutine orient_ends()
         if (allocated(chord%tangent)) return
         piece%here = solution_on(corrector%balance, motion_of(branch, i))
         piece%next = solution_on(corrector%balance, motion_of(branch, i + 1))
         piece%start = branch%arclength(i)
         piece%length = apart(0)
         chord%tangent = (piece%next%u - piece%here%u)/piece%length
         chord%tangent_frequency = (piece%next%frequency_ratio - piece%here%frequency_ratio)/piece%length
         call orient(piece%here)
         call orient(piece%next)
      end subroutine orient_ends

      !> Solves an end of the step, for its tangent along the step. Where Newton's method fails the tangent is the chord.
      subroutine orient(point)
         type(solution_point_type), intent(inout) :: point
         type(solution_point_type) :: solved
         logical :: success

         point%tangent = chord%tangent
         point%tangent_frequency = chord%tangent_frequency
         solved = point
         call corrector%correct(solved, success)
         if (success) point = solved
      end subroutine orient

   end subroutine add_in_step

end module geartrain_trace_hidden_changes
