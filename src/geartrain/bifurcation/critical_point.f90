!> Bifurcation points of the balance near the special points of a branch, and the direction in which the other branch leaves.
!>
!> With few harmonics the balance and the monodromy matrix place a period doubling so far apart that a step from the point of
!> the monodromy matrix misses the period-doubled branch of the balance. So the bifurcation point of the balance is solved for: the
!> solution at which a matrix is singular (geartrain_trace_singular).
module geartrain_bifurcation_critical_point
   use geartrain_base_kinds, only: dp
   use geartrain_network_system, only: system_type
   use geartrain_trace_branch, only: branch_type, response_settings_type
   use geartrain_trace_corrector, only: corrector_type, solution_point_type
   use geartrain_trace_points, only: motion_of
   use geartrain_trace_singular, only: singular_type
   use geartrain_trace_singular_search, only: find_nearest
   use geartrain_trace_special_points, only: locate_half_period
   use geartrain_trace_start, only: begin_trace, solution_of
   use geartrain_trace_step_geometry, only: passes_half_period
   use geartrain_trace_tracer, only: tracer_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: find_critical, find_meeting, harmonics_at, patterns_of

   !> First step of the search along the branch, at most [units_type].
   real(dp), parameter :: first_step = 0.01_dp
   !> Relative distance in Lambda of bifurcation points that are one.
   real(dp), parameter :: together = 1e-6_dp

contains

   !> Finds the bifurcation point of the balance nearest to a special point of a branch.
   subroutine find_critical(train, settings, branch, special, solution, success, harmonics, taken, again, pattern, equal)
      !> The train as described.
      type(train_type), intent(in) :: train
      !> Settings that `branch` was traced with.
      type(response_settings_type), intent(in) :: settings
      !> A branch with special points.
      type(branch_type), intent(in) :: branch
      !> Number of the special point: a period doubling or a branch point.
      integer, intent(in) :: special
      !> The bifurcation point, with the unit critical vector as tangent; of a period doubling in the balance of twice the period,
      !> all odd harmonics 0.
      type(solution_point_type), intent(out) :: solution
      !> A bifurcation point was found.
      logical, intent(out) :: success
      !> Harmonics of the balance of the branch, where settings%harmonics is 0; absent: as many as at the points next to the
      !> special point.
      integer, intent(in), optional :: harmonics
      !> Bifurcation points that belong to other special points of the branch.
      type(solution_point_type), intent(in), optional :: taken(:)
      !> The search came to one of `taken`.
      logical, intent(out), optional :: again
      !> Where equal branches begin to move differently, the pattern of their differences (fixed_space_type); 1 unless it is given.
      integer, intent(in), optional :: pattern
      !> Number of equal branches that begin to move differently; 0: none.
      integer, intent(out), optional :: equal
      type(solution_point_type) :: one
      type(system_type), target :: systems(2)
      type(tracer_type) :: tracer
      type(solution_point_type) :: from
      real(dp) :: h
      integer :: g, group, groups, highest
      logical :: found

      if (present(again)) again = .false.
      if (present(equal)) equal = 0
      call begin_trace(train, settings, systems, tracer, branch)
      highest = settings%harmonics
      if (highest == 0) then
         highest = harmonics_at(branch, special)
         if (present(harmonics)) highest = harmonics
         call tracer%prepare(highest)
      end if
      ! The search measures its steps along the branch, whatever the control of the trace, which `prepare` sets.
      tracer%corrector%local_control = .false.
      call solve_next_to(tracer, branch, special, from, h, success)
      if (.not. success) return
      groups = 0
      if (.not. tracer%corrector%fixed%is_whole()) then
         groups = size(tracer%corrector%fixed%group)
         if (branch%special_points(special)%kind == 'branch point') groups = tracer%corrector%fixed%parts()
      end if
      ! The critical direction may have any symmetry: the point that is nearest to the special point has the right one.
      success = .false.
      group = 0
      associate (at => branch%special_points(special)%frequency_ratio)
         do g = 0, groups
            call find_in_group(tracer%corrector, branch%special_points(special)%kind == 'period doubling', g, from, h, one, &
                               found, taken, again)
            if (.not. found) cycle
            if (success) then
               if (abs(one%frequency_ratio - at) > abs(solution%frequency_ratio - at) - together*abs(at)) cycle
            end if
            solution = one
            group = g
            success = .true.
         end do
      end associate
      if (.not. success .or. group == 0) return
      associate (fixed => tracer%corrector%fixed)
         if (group > size(fixed%group)) return
         g = 1
         if (present(pattern)) g = pattern
         solution%tangent = fixed%direction(group, g, solution%tangent)
         solution%tangent = solution%tangent/tracer%corrector%length_of(solution%tangent)
         solution%tangent_frequency = 0
         if (present(equal)) equal = size(fixed%group(group)%unknown, 2)
      end associate
   end subroutine find_critical

   !> Finds the nearest bifurcation point of one symmetry.
   subroutine find_in_group(corrector, doubles, group, from, h, solution, success, taken, again)
      type(corrector_type), intent(in) :: corrector
      !> Searches for a period doubling, else for a branch point.
      logical, intent(in) :: doubles
      !> Number of the part of the fixed space whose symmetry ends there, 0: none.
      integer, intent(in) :: group
      !> As for `find_nearest`.
      type(solution_point_type), intent(in) :: from
      real(dp), intent(in) :: h
      type(solution_point_type), intent(inout) :: solution
      logical, intent(out) :: success
      type(solution_point_type), intent(in), optional :: taken(:)
      logical, intent(inout), optional :: again
      type(system_type), target :: systems(2)
      type(singular_type) :: matrix

      call matrix%setup(corrector, systems, doubles, group)
      call find_nearest(matrix, from, h, solution, success, taken, again)
   end subroutine find_in_group

   !> Number of patterns in which equal branches begin to move differently, up to their renumbering.
   pure integer function patterns_of(equal, doubles)
      !> Number of the branches; 0: none begin to move differently, and there is one pattern.
      integer, intent(in) :: equal
      !> At a period doubling.
      logical, intent(in) :: doubles

      patterns_of = max(1, equal/2)
      if (doubles) patterns_of = patterns_of + max(0, (equal - 1)/2)
   end function patterns_of

   !> Finds the period doubling at which a period-doubled branch ends, if it ends at one.
   subroutine find_meeting(train, settings, branch, solution, met)
      !> The train as described.
      type(train_type), intent(in) :: train
      !> Settings that `branch` was traced with.
      type(response_settings_type), intent(in) :: settings
      !> A branch of even period.
      type(branch_type), intent(in) :: branch
      !> The point at which the odd harmonics of the branch vanish, with their direction as unit tangent.
      type(solution_point_type), intent(inout) :: solution
      !> The odd harmonics vanish between the last two points.
      logical, intent(out) :: met
      type(system_type), target :: systems(2)
      type(tracer_type) :: tracer
      type(solution_point_type) :: here, next
      real(dp) :: chord
      integer :: k
      logical :: success

      met = .false.
      if (branch%points < 2) return
      call begin_trace(train, settings, systems, tracer, branch)
      associate (n => branch%points - 1, step => 2*tracer%settings%repeats)
         ! An even number: the balance of half the period has half as many harmonics.
         if (settings%harmonics == 0) call tracer%prepare(step*((maxval(branch%point_harmonics(n:n + 1)) + step - 1)/step))
         ! The step is measured along the branch, whatever the control of the trace, which `prepare` sets.
         tracer%corrector%local_control = .false.
         call take_chord(tracer, branch, n, here, next, chord)
      end associate
      if (settings%harmonics == 0) then
         next%tangent = here%tangent
         next%tangent_frequency = here%tangent_frequency
         call tracer%corrector%correct(here, success)
         if (success) call tracer%corrector%correct(next, success)
         if (success) then
            call orient_along_chord(tracer, here, next, chord)
         else
            call take_chord(tracer, branch, branch%points - 1, here, next, chord)
         end if
      end if
      met = passes_half_period(here, next, tracer%corrector%balance%waves())
      if (.not. met) return
      call locate_half_period(tracer%corrector, here, next, chord, solution)
      solution%tangent = here%u
      solution%tangent(1, :) = 0
      do k = 2, (size(here%u, 1) - 1)/2, 2
         solution%tangent(2*k:2*k + 1, :) = 0
      end do
      solution%tangent = solution%tangent/tracer%corrector%length_of(solution%tangent)
   end subroutine find_meeting

   !> Points n and n + 1 of a branch as solution points; the tangent of `here` is the unit vector along the chord.
   subroutine take_chord(tracer, branch, n, here, next, chord)
      type(tracer_type), intent(in) :: tracer
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: n
      type(solution_point_type), intent(out) :: here, next
      real(dp), intent(out) :: chord

      here = solution_of(tracer, motion_of(branch, n))
      next = solution_of(tracer, motion_of(branch, n + 1))
      call orient_along_chord(tracer, here, next, chord)
   end subroutine take_chord

   !> Makes the tangent of `here` the unit vector along the chord to `next`.
   subroutine orient_along_chord(tracer, here, next, chord)
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
   end subroutine orient_along_chord

   !> Number of harmonics of the points before and after a special point: the larger of the two.
   pure integer function harmonics_at(branch, special)
      !> A branch with special points.
      type(branch_type), intent(in) :: branch
      !> Number of the special point.
      integer, intent(in) :: special

      associate (point => branch%special_points(special)%point)
         harmonics_at = maxval(branch%point_harmonics(point:point + 1))
      end associate
   end function harmonics_at

   !> Solves the balance on the branch next to a special point, with tangent, and chooses a first step `h` for the search.
   subroutine solve_next_to(tracer, branch, special, solution, h, success)
      type(tracer_type), intent(inout) :: tracer
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: special
      type(solution_point_type), intent(out) :: solution
      real(dp), intent(out) :: h
      logical, intent(out) :: success
      type(solution_point_type) :: after
      real(dp) :: share, chord

      call take_chord(tracer, branch, branch%special_points(special)%point, solution, after, chord)
      h = min(first_step, chord/4)
      success = chord > 0
      if (.not. success) return
      call tracer%corrector%keep_equal(solution)
      share = 0
      if (abs(after%frequency_ratio - solution%frequency_ratio) > 0) &
         share = (branch%special_points(special)%frequency_ratio - solution%frequency_ratio)/(after%frequency_ratio &
              - solution%frequency_ratio)
      ! Newton's method fails at a branch point; the point before it is near enough.
      if (branch%special_points(special)%kind == 'branch point') share = 0
      ! Next to a fold Lambda hardly tells the distance along the branch.
      share = max(0.0_dp, min(1.0_dp, share))
      solution%u = solution%u + share*chord*solution%tangent
      solution%frequency_ratio = solution%frequency_ratio + share*chord*solution%tangent_frequency
      call tracer%corrector%correct(solution, success)
   end subroutine solve_next_to

end module geartrain_bifurcation_critical_point
