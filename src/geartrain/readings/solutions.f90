!> Every solution of a branch at exactly one frequency, and whether a motion lies on a branch.
module geartrain_readings_solutions
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_repetition, only: repetitions_of
   use geartrain_balance_same_motion, only: is_same_motion
   use geartrain_base_error, only: error_type, fatal
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_linalg_cubic, only: share_at
   use geartrain_linalg_trigonometric, only: inner
   use geartrain_network_check_coupling, only: has_friction
   use geartrain_network_check_train, only: check_train
   use geartrain_network_system, only: system_type
   use geartrain_readings_friction_solutions, only: friction_solutions_at
   use geartrain_trace_branch, only: branch_type, carried_by, coefficients_of, has_sets, &
      response_settings_type
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_trace_same_solution, only: put_figures_in_order
   use geartrain_trace_start, only: begin_trace, solution_of
   use geartrain_trace_step_geometry, only: arc_length, go_along
   use geartrain_trace_tracer, only: tracer_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: solutions_at, record_crossings, lies_on, exceeds_limit

   !> Relative difference of Lambda up to which a point lies at a frequency.
   real(dp), parameter :: at_frequency = 1e-6_dp

contains

   !> Solves every crossing of a branch with a frequency, from the points on either side: folds are points of the branch, so no two
   !> crossings hide between two points.
   subroutine solutions_at(train, settings, branch, frequency_ratio, motions, error)
      !> Train of the branch.
      type(train_type), intent(in) :: train
      !> Settings with which the branch was traced.
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: branch
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> The solutions in the order along the branch; none where the branch does not reach the frequency.
      type(motion_type), allocatable, intent(out) :: motions(:)
      type(error_type), allocatable, intent(out) :: error
      type(system_type), target :: systems(2)
      type(tracer_type) :: tracer
      type(branch_type) :: found

      allocate (motions(0))
      call check_train(train, error)
      if (allocated(error)) return
      if (has_friction(train)) then
         deallocate (motions)
         call friction_solutions_at(train, branch, frequency_ratio, motions, error)
         return
      end if
      call begin_trace(train, settings, systems, tracer, branch)
      if (.not. tracer%corrector%balance%reaches(frequency_ratio)) then
         if (.not. allocated(branch%parameter)) call fatal(error, 'at: frequency = '//text(frequency_ratio)//': must be > 0')
         return
      end if
      call tracer%recorder%setup(tracer%corrector%balance, settings%stability, found, settings%shaft_torque, &
                                      settings%multipliers)
      call record_crossings(tracer, branch, frequency_ratio, found)
      call gather(found, settings, motions)
   end subroutine solutions_at

   !> Records every solution of a branch at exactly one frequency.
   subroutine record_crossings(tracer, branch, frequency_ratio, found)
      !> Tracer after `begin_trace` with the settings of the branch, its recorder set up for `found`.
      type(tracer_type), intent(inout) :: tracer
      type(branch_type), intent(in) :: branch
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Gets the solutions as further points.
      type(branch_type), intent(inout), target :: found
      type(solution_point_type) :: solution
      integer :: i
      logical :: success

      do i = 1, branch%points - 1
         if (branch%segment(i) /= branch%segment(i + 1)) cycle
         if (.not. crosses(branch%frequency_ratio(i), branch%frequency_ratio(i + 1), frequency_ratio, ends(branch, i + 1))) cycle
         if (tracer%settings%harmonics == 0) &
            call tracer%prepare(maxval(branch%point_harmonics(i:i + 1)), carried_by(branch, i, i + 1))
         call solve_between(tracer, branch, i, frequency_ratio, solution, success)
         if (.not. success) cycle
         call tracer%corrector%orient(solution, 1)
         call tracer%adapt(solution, success, fixed=.true.)
         call tracer%record(solution, found)
      end do
   end subroutine record_crossings

   !> Whether a segment of the branch ends at a point. A closed branch has no end: its last point is its first point.
   pure logical function ends(branch, point)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: point

      ends = point == branch%points .and. .not. branch%closed
      if (point < branch%points) ends = branch%segment(point + 1) /= branch%segment(point)
   end function ends

   !> Whether the frequency lies between a and b. The interval is open at b, so that a point exactly at the frequency counts once;
   !> the last interval of a segment is closed.
   pure logical function crosses(a, b, frequency_ratio, last)
      real(dp), intent(in) :: a, b, frequency_ratio
      logical, intent(in) :: last

      crosses = (a <= frequency_ratio .and. frequency_ratio < b) .or. (b < frequency_ratio .and. frequency_ratio <= a)
      if (last) crosses = crosses .or. abs(frequency_ratio - b) <= 0
   end function crosses

   !> Newton from the cubic through the neighbours, if it fails from either neighbour; at last, where a neighbour is at the
   !> frequency, across the branch, because a fold cannot be solved at constant Lambda.
   subroutine solve_between(tracer, branch, i, frequency_ratio, solution, success)
      type(tracer_type), intent(inout) :: tracer
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: i
      real(dp), intent(in) :: frequency_ratio
      type(solution_point_type), intent(out) :: solution
      logical, intent(out) :: success
      type(solution_point_type) :: ends(2)
      real(dp) :: chord, drift
      integer :: attempt

      call find_ends(tracer, branch, i, ends)
      chord = norm2(branch%coefficients(:, :, i + 1) - branch%coefficients(:, :, i))
      ! Refined points lie off the balance's solutions by their corrections.
      drift = 0
      if (allocated(branch%correction)) drift = maxval(branch%correction(i:i + 1))*norm2(branch%coefficients(2:, :, i))
      do attempt = 0, 2
         solution = ends(max(1, attempt))
         if (attempt == 0) call go_to(frequency_ratio)
         solution%frequency_ratio = frequency_ratio
         call tracer%corrector%solve_at(solution, success)
         if (.not. success) cycle
         ! A solution between two neighbours is no farther from each than twice the distance of the two.
         success = sqrt(inner(solution%u - ends(1)%u, solution%u - ends(1)%u)) <= 2*(chord + max(drift, 0.0_dp)) &
                   + 1e-9_dp*tracer%corrector%units%length
         if (success) return
      end do
      if (any(abs(ends%frequency_ratio - frequency_ratio) <= 0)) &
         call solve_across(tracer, ends, frequency_ratio, solution, success)
      if (.not. success) call walk(tracer, ends, drift, frequency_ratio, solution, success)

   contains

      !> Makes `solution` the point of the cubic at this Lambda.
      subroutine go_to(frequency_ratio)
         real(dp), intent(in) :: frequency_ratio
         type(solution_point_type) :: tangents(2)
         real(dp) :: share, length
         integer :: j

         share = 0
         if (abs(ends(2)%frequency_ratio - ends(1)%frequency_ratio) > 0) &
            share = (frequency_ratio - ends(1)%frequency_ratio)/(ends(2)%frequency_ratio - ends(1)%frequency_ratio)
         solution%u = (1 - share)*ends(1)%u + share*ends(2)%u
         tangents = ends
         do j = 1, 2
            if (norm2(ends(2)%u - ends(1)%u) + abs(ends(2)%frequency_ratio - ends(1)%frequency_ratio) <= 0) return
            call tracer%corrector%correct(tangents(j), success)
            if (.not. success) return
            ends(j)%tangent = tangents(j)%tangent
            ends(j)%tangent_frequency = tangents(j)%tangent_frequency
         end do
         length = arc_length(ends(1), ends(2), tracer%corrector%units)
         share = share_at(ends%frequency_ratio, ends%tangent_frequency*length, frequency_ratio)
         call go_along(ends(1), ends(2), share, tracer%corrector%units, solution)
      end subroutine go_to
   end subroutine solve_between

   !> The points i and i + 1 of a branch as guesses, with the chord between them as tangent.
   subroutine find_ends(tracer, branch, i, ends)
      type(tracer_type), intent(in) :: tracer
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: i
      type(solution_point_type), intent(out) :: ends(2)
      type(motion_type) :: motion
      integer :: j

      motion%period = branch%subharmonic
      do j = 1, 2
         motion%frequency_ratio = branch%frequency_ratio(i + j - 1)
         motion%coefficients = coefficients_of(branch, i + j - 1)
         ends(j) = solution_of(tracer, motion)
      end do
      do j = 1, 2
         ends(j)%tangent = ends(2)%u - ends(1)%u
         ends(j)%tangent_frequency = ends(2)%frequency_ratio - ends(1)%frequency_ratio
      end do
   end subroutine find_ends

   !> Solves the end of a step that is at `frequency_ratio`, across the chord between the ends.
   subroutine solve_across(tracer, ends, frequency_ratio, solution, success)
      type(tracer_type), intent(inout) :: tracer
      type(solution_point_type), intent(in) :: ends(2)
      real(dp), intent(in) :: frequency_ratio
      type(solution_point_type), intent(out) :: solution
      logical, intent(out) :: success

      solution = ends(merge(1, 2, abs(frequency_ratio - ends(1)%frequency_ratio) <= 0))
      solution%tangent = ends(2)%u - ends(1)%u
      solution%tangent_frequency = ends(2)%frequency_ratio - ends(1)%frequency_ratio
      call tracer%corrector%correct(solution, success)
      success = success .and. abs(solution%frequency_ratio - frequency_ratio) <= at_frequency*abs(frequency_ratio)
      solution%frequency_ratio = frequency_ratio
   end subroutine solve_across

   !> Solves at a frequency on the way from one neighbour to the other by short steps: between them the branch may pass a resonance
   !> that is much narrower than their distance.
   subroutine walk(tracer, ends, drift, frequency_ratio, solution, success)
      type(tracer_type), intent(inout) :: tracer
      type(solution_point_type), intent(in) :: ends(2)
      !> By how much the ends may lie off solutions of the balance [1].
      real(dp), intent(in) :: drift
      real(dp), intent(in) :: frequency_ratio
      type(solution_point_type), intent(out) :: solution
      !> The way leads to the other neighbour.
      logical, intent(out) :: success
      integer, parameter :: fewest = 16, most = 1024
      type(solution_point_type) :: here
      real(dp), allocatable :: before(:, :), guess(:, :)
      integer :: k, steps
      logical :: passed

      steps = fewest
      do while (steps <= most)
         here = ends(1)
         before = here%u
         passed = .false.
         do k = 0, steps
            ! On along the latest step.
            guess = 2*here%u - before
            before = here%u
            here%u = guess
            here%frequency_ratio = ends(1)%frequency_ratio + k*(ends(2)%frequency_ratio - ends(1)%frequency_ratio)/steps
            call tracer%corrector%solve_at(here, success)
            if (.not. success) exit
            if (passed .or. abs(here%frequency_ratio - ends(1)%frequency_ratio) &
                < abs(frequency_ratio - ends(1)%frequency_ratio)) cycle
            passed = .true.
            solution = here
            solution%frequency_ratio = frequency_ratio
            call tracer%corrector%solve_at(solution, success)
            if (.not. success) exit
         end do
         if (success) success = norm2(here%u - ends(2)%u) <= 0.1_dp*norm2(ends(2)%u - ends(1)%u) + max(drift, 0.0_dp)
         if (success) return
         steps = 4*steps
      end do
   end subroutine walk

   subroutine gather(found, settings, motions)
      type(branch_type), intent(in) :: found
      type(response_settings_type), intent(in) :: settings
      type(motion_type), allocatable, intent(out) :: motions(:)
      integer :: i

      allocate (motions(found%points))
      do i = 1, found%points
         associate (motion => motions(i))
            motion%frequency_ratio = found%frequency_ratio(i)
            if (allocated(found%parameter)) motion%frequency_ratio = found%constant_frequency
            motion%period = settings%subharmonic
            motion%coefficients = coefficients_of(found, i)
            motion%rms = found%rms(:, i)
            motion%mean = found%mean(:, i)
            motion%minimum = found%minimum(:, i)
            motion%maximum = found%maximum(:, i)
            motion%mesh_load = found%mesh_load(:, i)
            if (allocated(found%shaft_torque_mean)) then
               motion%held = found%held
               motion%couplings = found%couplings
               motion%shaft_torque_mean = found%shaft_torque_mean(:, i)
               motion%shaft_torque_minimum = found%shaft_torque_minimum(:, i)
               motion%shaft_torque_maximum = found%shaft_torque_maximum(:, i)
            end if
            if (found%bearing_force%bearings > 0) then
               motion%bearing_force_mean = found%bearing_force%mean(:, :, i)
               motion%bearing_force_rms = found%bearing_force%rms(:, :, i)
               motion%bearing_force_minimum = found%bearing_force%minimum(:, :, i)
               motion%bearing_force_maximum = found%bearing_force%maximum(:, :, i)
            end if
            if (allocated(found%coupling_energy_loss)) motion%coupling_energy_loss = found%coupling_energy_loss(:, i)
            if (allocated(found%load_share)) then
               motion%load_share = found%load_share(:, i)
               motion%load_share_maximum = found%load_share_maximum(:, i)
            end if
            motion%error_estimate = found%error_estimate(i)
            if (allocated(found%reading_error_estimate)) motion%reading_error_estimate = found%reading_error_estimate(i)
            if (.not. settings%stability) cycle
            if (found%states > 0) motion%multipliers = found%multipliers(:, i)
            motion%assessed = found%states == 0
            motion%stable = found%stable(i)
            motion%undecided = found%undecided(i)
         end associate
      end do
   end subroutine gather

   !> Whether a motion, shifted by any number of periods of the fundamental and up to the numbers of equal branches, lies on a
   !> branch. The motion is solved by a balance of as many harmonics as the branch has, so that equal motions agree exactly.
   logical function lies_on(train, settings, branch, motion)
      !> Train of the branch.
      type(train_type), intent(in) :: train
      !> Settings with which the branch was traced.
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: branch
      !> Motion with its coefficients.
      type(motion_type), intent(in) :: motion
      type(response_settings_type) :: same_balance
      type(system_type), target :: systems(2)
      type(tracer_type) :: tracer
      type(solution_point_type) :: solution
      type(branch_type) :: solved
      type(motion_type), allocatable :: motions(:), here(:)
      type(error_type), allocatable :: error
      real(dp) :: uncertainty
      logical :: success
      integer :: i

      lies_on = .false.
      if (branch%subharmonic /= motion%period .or. branch%points < 2) return
      same_balance = settings
      same_balance%stability = .false.
      ! Balances of sets differ by their sets, and so by their errors.
      if (settings%harmonics == 0 .and. .not. has_sets(branch)) same_balance%harmonics = branch%harmonics
      call begin_trace(train, same_balance, systems, tracer, branch)
      if (mod(repetitions_of(tracer%system, motion), tracer%settings%repeats) /= 0) return
      solution = solution_of(tracer, motion)
      call tracer%corrector%solve_at(solution, success)
      if (.not. success) return
      call tracer%corrector%orient(solution, 1)
      call tracer%recorder%setup(tracer%corrector%balance, .false., solved)
      call tracer%record(solution, solved)
      call solutions_at(train, same_balance, branch, motion%frequency_ratio, motions, error)
      call gather(solved, same_balance, here)
      associate (corrector => tracer%corrector)
         call put_figures_in_order(corrector%sets, corrector%balance%mesh, here(1))
         do i = 1, size(motions)
            call put_figures_in_order(corrector%sets, corrector%balance%mesh, motions(i))
         end do
      end associate
      uncertainty = 0
      if (has_sets(branch)) uncertainty = 3*maxval([here%error_estimate, motions%error_estimate])
      lies_on = any([(is_same_motion(here(1), motions(i), uncertainty), i=1, size(motions))])
   end function lies_on

   !> Whether the rms of a motion is above the amplitude limit, where no branch is recorded.
   logical function exceeds_limit(train, settings, motion)
      !> Train of the motion.
      type(train_type), intent(in) :: train
      !> Settings with the amplitude limit.
      type(response_settings_type), intent(in) :: settings
      !> Motion with its rms.
      type(motion_type), intent(in) :: motion
      type(system_type), target :: systems(2)
      type(tracer_type) :: tracer

      call begin_trace(train, settings, systems, tracer)
      exceeds_limit = any(motion%rms > tracer%amplitude_limit)
   end function exceeds_limit

end module geartrain_readings_solutions
