!> One point of a branch against the exact motion: error over estimate, and stability of the point against stability of the orbit.
!>
!> The exact motion is the nearest orbit at the Lambda of the point. Where shooting from the point does not find an orbit at about
!> the estimated distance, the exact branch is met across the point and followed in both directions: to the orbits at the Lambda of
!> the point, or to a fold at which the exact branch turns before.
module geartrain_exact_audit_point
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_repetition, only: repeat_motion
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_exact_audit_result, only: audit_row_type, within
   use geartrain_exact_exact_search, only: guess_from_point, neighbours
   use geartrain_exact_orbit_corrector, only: orbit_corrector_type, orbit_test_type, orbit_type, resolution
   use geartrain_exact_orbit_tests, only: fold_test_type
   use geartrain_exact_waveform_error, only: harmonics_told, rounding_of, waveform_error
   use geartrain_floquet_multipliers, only: is_neutral, is_stable
   use geartrain_flow_orbit, only: measure
   use geartrain_trace_branch, only: branch_type, coefficients_of
   implicit none (type, external)
   private
   public :: audit_point

   !> An orbit is another motion if its relative distance is more than `another` times the estimate and more than `far`.
   real(dp), parameter :: another = 10, far = 1
   !> First step along the exact branch and longest way along it, in the units of units_type.
   real(dp), parameter :: first_step = 1e-4_dp, longest_way = 0.5_dp
   !> Least Lambda on the way over Lambda of the point: towards 0 the integration takes ever longer.
   real(dp), parameter :: slowest = 0.5_dp
   integer, parameter :: max_steps = 100

   !> Test function: Lambda less a given Lambda.
   type, extends(orbit_test_type) :: reach_test_type
      !> The given Lambda [1].
      real(dp) :: frequency_ratio = 0
   contains
      procedure :: value => value_of_reach
   end type reach_test_type

contains

   pure real(dp) function value_of_reach(self, orbit) result(value)
      class(reach_test_type), intent(in) :: self
      type(orbit_type), intent(in) :: orbit

      value = orbit%frequency_ratio - self%frequency_ratio
   end function value_of_reach

   !> Fills in the row of a point: estimate, error, stability and what is wrong.
   subroutine audit_point(corrector, branch, row)
      !> The corrector of the exact branch.
      type(orbit_corrector_type), intent(inout) :: corrector
      !> The branch.
      type(branch_type), intent(in) :: branch
      !> The row; `point` is given.
      type(audit_row_type), intent(inout) :: row
      type(orbit_type) :: orbit
      logical :: found

      associate (i => row%point)
         row%frequency_ratio = branch%frequency_ratio(i)
         row%estimate = branch%error_estimate(i)
         row%doubtful = branch%estimate_doubtful(i)
         call guess_from_point(corrector, branch, i, orbit)
         call corrector%solve_at(orbit, found)
         if (corrector%system%interrupt%raised()) return
         if (found) call compare(corrector, branch, orbit, .false., row)
         if (allocated(branch%stable)) then
            row%verdict = merge('stable  ', 'unstable', branch%stable(i))
            if (branch%undecided(i)) row%verdict = 'undecided'
         end if
         ! Next to a fold the orbit found may lie on the other side of the fold.
         if (.not. agrees(row) .or. contradicts(row)) call follow_exact(corrector, branch, row)
         call judge_estimate(row)
         row%verdict_wrong = contradicts(row)
         if (row%verdict_wrong) call tell('stability wrong', row)
      end associate
   end subroutine audit_point

   !> Enters an orbit, or the fold of the exact branch, in the row, unless the row has a nearer orbit already.
   subroutine compare(corrector, branch, orbit, at_fold, row)
      type(orbit_corrector_type), intent(inout) :: corrector
      type(branch_type), intent(in) :: branch
      type(orbit_type), intent(in) :: orbit
      logical, intent(in) :: at_fold
      type(audit_row_type), intent(inout) :: row
      type(motion_type) :: motion
      real(dp) :: error, rounding
      integer :: told
      logical :: refined

      refined = .false.
      if (allocated(branch%correction)) refined = branch%correction(row%point) >= 0
      motion%frequency_ratio = orbit%frequency_ratio
      motion%period = corrector%period
      motion%state = orbit%states(:, 1)
      associate (balance => coefficients_of(branch, row%point))
         told = harmonics_told(balance, corrector%period*corrector%times)
         call measure(corrector%system, told, motion)
         if (corrector%times > 1) call repeat_motion(corrector%times, corrector%times*told, motion)
         if (refined) then
            error = waveform_error(balance, motion%coefficients, branch%orders)
         else
            error = waveform_error(balance, motion%coefficients)
         end if
      end associate
      rounding = rounding_of(motion%coefficients)
      ! A motion without excitation is nothing but its mean and rounding.
      if (error > max(far, another*row%estimate, rounding) .or. (row%error >= 0 .and. error > row%error)) return
      row%error = error
      row%rounding = rounding
      row%finding = ''
      if (at_fold) then
         row%exact_verdict = 'fold'
         row%finding = 'beyond the fold at '//text(orbit%frequency_ratio/corrector%times)
      else if (is_neutral(orbit%multipliers)) then
         row%exact_verdict = 'neutral'
      else
         row%exact_verdict = merge('stable  ', 'unstable', is_stable(orbit%multipliers))
      end if
   end subroutine compare

   !> Meets the exact branch across the point and follows it to the Lambda of the point.
   subroutine follow_exact(corrector, branch, row)
      type(orbit_corrector_type), intent(inout) :: corrector
      type(branch_type), intent(in) :: branch
      type(audit_row_type), intent(inout) :: row
      type(orbit_type) :: before, orbit, after, reached
      real(dp) :: way
      integer :: ends(2), sense
      logical :: success, at_fold

      ends = neighbours(branch, row%point)
      call guess_from_point(corrector, branch, row%point, orbit)
      call guess_from_point(corrector, branch, ends(1), before)
      call guess_from_point(corrector, branch, ends(2), after)
      call corrector%point_at(before, after, orbit, way)
      if (.not. way > 0) return
      call corrector%correct(orbit, success)
      if (.not. success) return
      do sense = 1, -1, -2
         orbit%tangent = sense*orbit%tangent
         orbit%tangent_frequency = sense*orbit%tangent_frequency
         call walk(corrector, orbit, corrector%times*row%frequency_ratio, reached, at_fold, success)
         if (success) call compare(corrector, branch, reached, at_fold, row)
      end do
   end subroutine follow_exact

   !> Follows the exact branch from `from` along its tangent to the orbit at Lambda = `frequency_ratio`, or to a fold before it.
   subroutine walk(corrector, from, frequency_ratio, reached, at_fold, success)
      type(orbit_corrector_type), intent(inout) :: corrector
      type(orbit_type), intent(in) :: from
      real(dp), intent(in) :: frequency_ratio
      type(orbit_type), intent(inout) :: reached
      logical, intent(out) :: at_fold, success
      type(orbit_type) :: here, next
      type(reach_test_type) :: reach
      type(fold_test_type) :: fold
      real(dp) :: gap, h, way
      integer :: i

      at_fold = .false.
      reach%frequency_ratio = frequency_ratio
      here = from
      reached = here
      success = abs(here%frequency_ratio - frequency_ratio) < resolution*corrector%units%frequency_ratio
      if (success) return
      h = first_step
      way = 0
      do i = 1, max_steps
         gap = frequency_ratio - here%frequency_ratio
         call corrector%advance(here, h, next, success)
         if (.not. success) then
            h = h/3
            if (h < resolution) return
            cycle
         end if
         if (here%tangent_frequency*gap > 0 .and. here%tangent_frequency*next%tangent_frequency < 0) then
            call corrector%find_zero(fold, here, h, next, reached, success)
            if (.not. success) return
            at_fold = (frequency_ratio - reached%frequency_ratio)*gap > 0
            if (at_fold) return
            h = corrector%distance(here, reached)
            next = reached
         end if
         if ((frequency_ratio - next%frequency_ratio)*gap <= 0) then
            call corrector%find_zero(reach, here, h, next, reached, success)
            if (.not. success) return
            reached%frequency_ratio = frequency_ratio
            call corrector%solve_at(reached, success)
            return
         end if
         way = way + h
         if (way > longest_way .or. next%frequency_ratio < slowest*frequency_ratio) exit
         here = next
         h = 2*h
      end do
      success = .false.
   end subroutine walk

   !> Whether an error was found that is as estimated, up to the factor `within`.
   pure logical function agrees(row)
      type(audit_row_type), intent(in) :: row

      agrees = row%ratio() > 1/within .and. row%ratio() < within
   end function agrees

   !> Whether the branch calls the point stable and shooting unstable, or the reverse.
   pure logical function contradicts(row)
      type(audit_row_type), intent(in) :: row

      contradicts = (row%verdict == 'stable' .and. row%exact_verdict == 'unstable') .or. &
                    (row%verdict == 'unstable' .and. row%exact_verdict == 'stable')
   end function contradicts

   !> Sets `estimate_wrong` and adds what is to be said of the estimate.
   subroutine judge_estimate(row)
      type(audit_row_type), intent(inout) :: row

      if (agrees(row)) return
      row%estimate_wrong = .not. row%doubtful
      if (row%error < 0) then
         call tell('no orbit found near it', row)
      else if (row%estimate < 0) then
         call tell('no estimate', row)
      else
         call tell('error '//text(row%ratio())//' times the estimate', row)
      end if
      if (row%doubtful) call tell('doubtful', row)
   end subroutine judge_estimate

   !> Adds words to the finding of a row.
   pure subroutine tell(what, row)
      character(*), intent(in) :: what
      type(audit_row_type), intent(inout) :: row

      if (row%finding /= '') row%finding = trim(row%finding)//', '//what
      if (row%finding == '') row%finding = what
   end subroutine tell

end module geartrain_exact_audit_point
