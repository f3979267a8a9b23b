!> Where a branch bifurcates by its own balance, near a special point of it, and the direction in which the other branch leaves.
!>
!> A truncated balance and the monodromy along it do not place a doubling alike: with few harmonics they are far enough apart that
!> a step from the place of the one misses the branch of the other. So the balance's own solution point is found:
!> where a matrix is singular that is regular elsewhere (geartrain_continuation_singular).
module geartrain_continuation_critical_point
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp
   use geartrain_continuation_branch, only: branch_type, response_settings_type
   use geartrain_continuation_corrector, only: solution_point_type
   use geartrain_continuation_singular, only: singular_type
   use geartrain_continuation_singular_search, only: find_nearest
   use geartrain_continuation_special_points, only: locate_half_period
   use geartrain_continuation_start, only: begin_trace, solution_of
   use geartrain_continuation_step_geometry, only: passes_half_period
   use geartrain_continuation_tracer, only: tracer_type
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: find_critical, find_meeting, harmonics_at

   !> First step away from it, at most.
   real(dp), parameter :: first_step = 0.01_dp

contains

   !> The solution point of the balance's own nearest to special point number `special` of `branch`, the unit critical vector as its
   !> tangent: for a doubling a solution point of the balance of twice the period, all its odd harmonics 0.
   subroutine find_critical(train, settings, branch, special, solution, success, harmonics, taken, again)
      type(train_type), intent(in) :: train
      !> Those that `branch` was traced with.
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: special
      type(solution_point_type), intent(out) :: solution
      logical, intent(out) :: success
      !> Of the branch's balance, where `settings` leaves them to the program; else those of the branch there.
      integer, intent(in), optional :: harmonics
      !> Places that belong to other special points of the branch.
      type(solution_point_type), intent(in), optional :: taken(:)
      !> It is one of those.
      logical, intent(out), optional :: again
      type(singular_type) :: matrix
      type(tracer_type) :: tracer
      type(solution_point_type) :: from
      real(dp) :: h
      integer :: highest

      if (present(again)) again = .false.
      call begin_trace(train, settings, tracer)
      highest = settings%harmonics
      if (highest == 0) then
         highest = harmonics_at(branch, special)
         if (present(harmonics)) highest = harmonics
         call tracer%prepare(highest)
      end if
      ! The way along the branch is what counts here, whatever the control of the trace.
      tracer%corrector%local_control = .false.
      call told_place(tracer, branch, special, from, h, success)
      if (.not. success) return
      call matrix%setup(tracer%corrector, branch%special_points(special)%kind == 'period doubling')
      call find_nearest(matrix, from, h, solution, success, taken, again)
   end subroutine find_critical

   !> Where a branch of even period ends at the branch of half its period, if it does: the solution point at which its odd harmonics
   !> vanish, with their direction as its tangent.
   subroutine find_meeting(train, settings, branch, solution, met)
      type(train_type), intent(in) :: train
      !> Those that `branch` was traced with.
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: branch
      type(solution_point_type), intent(inout) :: solution
      logical, intent(out) :: met
      type(tracer_type) :: tracer
      type(solution_point_type) :: here, next
      real(dp) :: chord
      integer :: k
      logical :: success

      met = .false.
      if (branch%points < 2) return
      call begin_trace(train, settings, tracer)
      tracer%corrector%local_control = .false.
      associate (n => branch%points - 1)
         ! An even number, so that a balance of half the period has half as many.
         if (settings%harmonics == 0) call tracer%prepare(2*((maxval(branch%point_harmonics(n:n + 1)) + 1)/2))
         call span(tracer, branch, n, here, next, chord)
      end associate
      if (settings%harmonics == 0) then
         next%tangent = here%tangent
         next%tangent_frequency = here%tangent_frequency
         call tracer%corrector%correct(here, success)
         if (success) call tracer%corrector%correct(next, success)
         if (success) then
            call point_at(tracer, here, next, chord)
         else
            call span(tracer, branch, branch%points - 1, here, next, chord)
         end if
      end if
      met = passes_half_period(here, next, branch%subharmonic)
      if (.not. met) return
      call locate_half_period(tracer%corrector, here, next, chord, solution)
      solution%tangent = here%u
      solution%tangent(1, :) = 0
      do k = 2, (size(here%u, 1) - 1)/2, 2
         solution%tangent(2*k:2*k + 1, :) = 0
      end do
      solution%tangent = solution%tangent/tracer%corrector%length_of(solution%tangent)
   end subroutine find_meeting

   !> Points n and n+1 of a branch as solution points; `here` has the unit vector along the chord as its tangent.
   subroutine span(tracer, branch, n, here, next, chord)
      type(tracer_type), intent(in) :: tracer
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: n
      type(solution_point_type), intent(out) :: here, next
      real(dp), intent(out) :: chord
      type(motion_type) :: motion

      motion%period = branch%subharmonic
      motion%frequency_ratio = branch%frequency_ratio(n)
      motion%coefficients = branch%coefficients(:, :, n)
      here = solution_of(tracer, motion)
      motion%frequency_ratio = branch%frequency_ratio(n + 1)
      motion%coefficients = branch%coefficients(:, :, n + 1)
      next = solution_of(tracer, motion)
      call point_at(tracer, here, next, chord)
   end subroutine span

   !> Makes the tangent of `here` the unit vector along the chord to `next`.
   subroutine point_at(tracer, here, next, chord)
      type(tracer_type), intent(in) :: tracer
      type(solution_point_type), intent(inout) :: here
      type(solution_point_type), intent(in) :: next
      real(dp), intent(out) :: chord

      here%tangent = next%u - here%u
      here%tangent_frequency = next%frequency_ratio - here%frequency_ratio
      chord = tracer%corrector%length_of(here%tangent, here%tangent_frequency)
      if (.not. chord > 0) return
      here%tangent = here%tangent/chord
      here%tangent_frequency = here%tangent_frequency/chord
   end subroutine point_at

   !> Harmonics of the points next to the special point: the more of the two.
   pure integer function harmonics_at(branch, special)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: special

      associate (point => branch%special_points(special)%point)
         harmonics_at = maxval(branch%point_harmonics(point:point + 1))
      end associate
   end function harmonics_at

   !> The branch solved next to the special point, the tangent included, and a first step `h` from there.
   subroutine told_place(single, branch, special, solution, h, success)
      type(tracer_type), intent(inout) :: single
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: special
      type(solution_point_type), intent(out) :: solution
      real(dp), intent(out) :: h
      logical, intent(out) :: success
      type(solution_point_type) :: after
      real(dp) :: share, chord

      call span(single, branch, branch%special_points(special)%point, solution, after, chord)
      h = min(first_step, chord/4)
      success = chord > 0
      if (.not. success) return
      share = 0
      if (abs(after%frequency_ratio - solution%frequency_ratio) > 0) &
         share = (branch%special_points(special)%frequency_ratio - solution%frequency_ratio)/(after%frequency_ratio &
              - solution%frequency_ratio)
      ! At a branch point itself Newton's method fails; the points next to it are near enough.
      if (branch%special_points(special)%kind == 'branch point') share = 0
      ! Next to a fold the frequency tells little.
      share = max(0.0_dp, min(1.0_dp, share))
      solution%u = solution%u + share*chord*solution%tangent
      solution%frequency_ratio = solution%frequency_ratio + share*chord*solution%tangent_frequency
      call single%corrector%correct(solution, success)
   end subroutine told_place

end module geartrain_continuation_critical_point
