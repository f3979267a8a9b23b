!> The special point of the exact branch that is nearest to a special point of a branch: the exact branch is met across it and
!> followed both ways in turn, until a test function changes sign that changes sign at this kind alone.
module geartrain_exact_exact_search
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp
   use geartrain_exact_orbit_corrector, only: orbit_corrector_type, orbit_test_type, orbit_type
   use geartrain_exact_orbit_tests, only: back_contact, choose_test, critical, is_onset, outside
   use geartrain_linalg_cubic, only: share_at, value_on
   use geartrain_network_equal_branches, only: equal_branches_type, find_equal_branches
   use geartrain_network_system, only: system_type
   use geartrain_trace_branch, only: branch_type, coefficients_of, multipliers_at, special_point_type
   use geartrain_trace_decided, only: nearest_decided
   use geartrain_trace_stages, only: stage_of
   implicit none (type, external)
   private
   public :: change_at, ends_of, find_exact, guess_from_point, neighbours

   !> First step along the exact branch, and the length of the search in each direction, in the units of units_type. The search is
   !> longer where the points on both sides are further apart: their motions may be as inaccurate.
   real(dp), parameter :: first_step = 2e-4_dp, usual_way = 0.25_dp
   !> Least Lambda on the way over Lambda at its beginning: towards 0 the integration takes ever longer.
   real(dp), parameter :: slowest = 0.5_dp
   integer, parameter :: max_steps = 100
   !> Distance in Lambda of a branch point of the balance from that of the exact motion, in the unit of Lambda, up to which the two
   !> are one.
   real(dp), parameter :: near = 0.01_dp
   !> Distance of the guesses by which a tangent is guessed from that of an orbit, as a share of a step of the branch [1].
   real(dp), parameter :: beside = 0.01_dp

contains

   !> Finds the special point of the exact branch, with the tangent in the sense of the branch.
   subroutine find_exact(corrector, branch, special, change, exact, found)
      !> The corrector of the exact branch.
      type(orbit_corrector_type), intent(inout) :: corrector
      !> The branch.
      type(branch_type), intent(in) :: branch
      !> A special point or a contact onset of the branch.
      type(special_point_type), intent(in) :: special
      !> Change of what `critical` counts at the special point, along the branch; 0: not known.
      integer, intent(in) :: change
      !> The special point of the exact branch.
      type(orbit_type), intent(out) :: exact
      !> Whether one was found.
      logical, intent(out) :: found
      type(orbit_type) :: start
      real(dp) :: way_between

      call stand_at(corrector, branch, special, start, way_between, found)
      corrector%watched_mesh = 0
      if (is_onset(special%kind)) corrector%watched_mesh = special%mesh
      corrector%watches_back = special%kind == back_contact
      corrector%watched_stage = stage_of(special%kind)
      if (found) call corrector%correct(start, found)
      if (.not. found) return
      call search(corrector, start, special%kind, special%multiplicity, sense_of(branch, special, change), &
                  way_between, exact, found)
      if (.not. found .and. special%kind == 'branch point' .and. special%multiplicity > 1) &
         call search_equal(corrector, branch, special, exact, found)
      if (found .or. special%kind /= 'branch point' .or. special%multiplicity > 1) return
      ! On a branch that begins and ends there, as its own mirror image, Lambda turns and no test function tells it from a fold: the
      ! branch point is solved for from beside it.
      exact = start
      found = .true.
   end subroutine find_exact

   !> Finds the branch point at which a branch of unequal motions crosses one on which equal branches move equally. Only on the
   !> latter do as many multipliers pass +1 together as the branch point has; the orbit gets the tangent of the latter.
   subroutine search_equal(corrector, branch, special, exact, found)
      type(orbit_corrector_type), intent(inout) :: corrector
      type(branch_type), intent(in) :: branch
      type(special_point_type), intent(in) :: special
      type(orbit_type), intent(inout) :: exact
      logical, intent(out) :: found
      type(equal_branches_type), allocatable :: sets(:)
      type(orbit_type) :: ends(2), start
      type(motion_type) :: motion
      real(dp) :: way
      integer :: i, points(2)

      found = .false.
      call find_equal_branches(corrector%system, sets)
      if (size(sets) == 0) return
      points = ends_of(branch, special)
      do i = 1, 2
         motion%frequency_ratio = branch%frequency_ratio(points(i))
         motion%period = branch%subharmonic
         motion%coefficients = coefficients_of(branch, points(i))
         call make_equal(corrector%system, sets, motion%coefficients)
         call corrector%first_guess(motion, ends(i))
         call corrector%solve_at(ends(i), found)
         if (.not. found) return
      end do
      start = ends(1)
      call corrector%point_at(ends(1), ends(2), start, way)
      found = way > 0
      if (found) call corrector%correct(start, found)
      if (found) call search(corrector, start, special%kind, special%multiplicity, 0, usual_way, exact, found)
      if (found) found = abs(exact%frequency_ratio/corrector%times - special%frequency_ratio) &
                         < near*corrector%units%frequency_ratio/corrector%times
   end subroutine search_equal

   !> Gives equal branches the mean of their motions.
   subroutine make_equal(system, sets, coefficients)
      type(system_type), intent(in) :: system
      type(equal_branches_type), intent(in) :: sets(:)
      !> Coefficients [1], (coefficient, mesh).
      real(dp), intent(inout) :: coefficients(:, :)
      integer :: i, j, l
      integer, allocatable :: mesh(:)

      do i = 1, size(sets)
         do l = 1, size(sets(i)%unknown, 1)
            mesh = system%network%elements(system%cut%element(sets(i)%unknown(l, :)))%mesh
            do j = 1, size(coefficients, 1)
               coefficients(j, mesh) = sum(coefficients(j, mesh))/size(mesh)
            end do
         end do
      end do
   end subroutine make_equal

   !> Indices of the points of the branch on both sides of a special point.
   pure function ends_of(branch, special) result(ends)
      !> The branch.
      type(branch_type), intent(in) :: branch
      !> Its special point.
      type(special_point_type), intent(in) :: special
      integer :: ends(2)

      ends = [special%point, min(special%point + 1, branch%points)]
      if (special%kind == 'fold') ends = neighbours(branch, special%point)
   end function ends_of

   !> Change of the number that `critical` counts at a special point of a branch; 0: not known.
   integer function change_at(branch, number, special) result(change)
      !> The branch.
      type(branch_type), intent(in) :: branch
      !> Number of the special point; 0: a contact onset.
      integer, intent(in) :: number
      !> The special point or the contact onset.
      type(special_point_type), intent(in) :: special
      integer :: sides(2), ends(2), first
      logical :: pair(size(branch%special_points))

      change = 0
      if (is_onset(special%kind) .or. .not. allocated(branch%stable) .or. branch%states == 0) return
      ends = ends_of(branch, special)
      sides = [nearest_decided(branch, number, -1), nearest_decided(branch, number, 1)]
      sides = merge(sides, ends, sides > 0)
      first = critical(special%kind, multipliers_at(branch, sides(1)))
      change = critical(special%kind, multipliers_at(branch, sides(2))) - first
      ! Both ends of a step with a pair of changes count the same: the first of the two begins with what there is before.
      associate (listed => branch%special_points)
         pair = listed%point == special%point .and. listed%kind == special%kind .and. special%kind /= 'fold'
         if (change == 0 .and. count(pair) > 1 .and. (special%kind == 'period doubling' .or. first == 0)) &
            change = merge(1, -1, first == 0)*merge(1, -1, mod(count(pair(:number - 1)), 2) == 0)
         ! A pair that passes alone may have become real by the end of the step.
         if (change == 0 .and. special%kind == 'neimark-sacker' .and. count(pair) == 1) &
            change = (outside(multipliers_at(branch, sides(2))) - outside(multipliers_at(branch, sides(1))))/2
      end associate
   end function change_at

   !> First guess of an orbit from a point of the branch.
   subroutine guess_from_point(corrector, branch, i, orbit)
      !> The corrector of the exact branch.
      type(orbit_corrector_type), intent(inout) :: corrector
      !> The branch.
      type(branch_type), intent(in) :: branch
      !> Index of the point.
      integer, intent(in) :: i
      !> The guess.
      type(orbit_type), intent(out) :: orbit
      type(motion_type) :: motion

      motion%frequency_ratio = branch%frequency_ratio(i)
      motion%period = branch%subharmonic
      motion%coefficients = coefficients_of(branch, i)
      call corrector%first_guess(motion, orbit)
   end subroutine guess_from_point

   !> Indices of the points before and after a point; at an end of a segment the index of the point itself.
   pure function neighbours(branch, i) result(ends)
      !> The branch.
      type(branch_type), intent(in) :: branch
      !> Index of the point.
      integer, intent(in) :: i
      integer :: ends(2)

      ends = i
      if (i > 1) then
         if (branch%segment(i - 1) == branch%segment(i)) ends(1) = i - 1
      end if
      if (i < branch%points) then
         if (branch%segment(i + 1) == branch%segment(i)) ends(2) = i + 1
      end if
   end function neighbours

   !> First guess of the orbit at a special point, with its tangent.
   subroutine stand_at(corrector, branch, special, start, way_between, found)
      type(orbit_corrector_type), intent(inout) :: corrector
      type(branch_type), intent(in) :: branch
      !> The special point.
      type(special_point_type), intent(in) :: special
      type(orbit_type), intent(out) :: start
      !> Distance of the points of the branch on both sides [units_type].
      real(dp), intent(out) :: way_between
      logical, intent(out) :: found
      type(orbit_type) :: first, last
      real(dp) :: way, share, sides(2)
      integer :: ends(2)

      ends = ends_of(branch, special)
      call guess_from_point(corrector, branch, ends(1), first)
      call guess_from_point(corrector, branch, ends(2), last)
      way_between = corrector%distance(first, last)
      select case (special%kind)
      case ('fold')
         call guess_from_point(corrector, branch, special%point, start)
         ! The steps on both sides may differ much in length.
         sides = 1
         if (allocated(branch%arclength)) sides = abs(branch%arclength(ends) - branch%arclength(special%point))
         share = beside*minval(sides, sides > 0)
         if (sides(1) > 0) call guess_within(corrector, branch, [ends(1), special%point], 1 - share/sides(1), first)
         if (sides(2) > 0) call guess_within(corrector, branch, [special%point, ends(2)], share/sides(2), last)
      case ('branch point')
         ! At the branch point itself the two tangents leave Newton's method without a solution of its own.
         share = share_of(branch, ends, special%frequency_ratio)
         call guess_within(corrector, branch, ends, merge(0.0_dp, 1.0_dp, share > 0.5_dp), start)
      case default
         share = share_of(branch, ends, special%frequency_ratio)
         call guess_within(corrector, branch, ends, share, start)
         call guess_within(corrector, branch, ends, share - beside, first)
         call guess_within(corrector, branch, ends, share + beside, last)
      end select
      call corrector%point_at(first, last, start, way)
      found = way > 0
   end subroutine stand_at

   !> Where between two points a branch has a value of Lambda that lies between theirs, or the end that is nearer to it, as a share
   !> of the branch between them [1].
   pure real(dp) function share_of(branch, ends, frequency_ratio) result(share)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: ends(2)
      real(dp), intent(in) :: frequency_ratio

      associate (ratio => branch%frequency_ratio(ends))
         ! Next to a fold Lambda may lie outside the range of the two points.
         associate (within => max(minval(ratio), min(maxval(ratio), frequency_ratio)))
            share = share_at(ratio, slopes_of(branch, ends), within)
         end associate
      end associate
   end function share_of

   !> Derivatives of Lambda at two neighbouring points by the share of the branch between them [1]; of the chord where they are not
   !> known.
   pure function slopes_of(branch, ends) result(slopes)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: ends(2)
      real(dp) :: slopes(2)

      slopes = branch%frequency_ratio(ends(2)) - branch%frequency_ratio(ends(1))
      if (allocated(branch%arclength)) slopes = (branch%arclength(ends(2)) - branch%arclength(ends(1)))*branch%free_slope(ends)
   end function slopes_of

   !> First guess of an orbit between two neighbouring points of a branch: the motion of the balance on the cubic through up to four
   !> points. States are those of this motion: they may turn between the points where unknown motions do not, as in a resonance of a
   !> shaft.
   subroutine guess_within(corrector, branch, ends, share, orbit)
      type(orbit_corrector_type), intent(inout) :: corrector
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: ends(2)
      !> Where, as a share of the branch between the points [1].
      real(dp), intent(in) :: share
      type(orbit_type), intent(out) :: orbit
      type(motion_type) :: motion
      integer :: nodes(4), j, k
      real(dp) :: at(4), place, weight
      logical :: counts(4)

      nodes = [neighbours(branch, ends(1)), neighbours(branch, ends(2))]
      nodes = [nodes(1), ends, nodes(4)]
      do j = 1, 4
         at(j) = nodes(j) - ends(1)
         if (allocated(branch%arclength)) at(j) = branch%arclength(nodes(j))
      end do
      ! At an end of a segment a node is one of the two points again.
      counts = [at(1) < at(2), .true., .true., at(4) > at(3)]
      place = at(2) + share*(at(3) - at(2))
      motion%period = branch%subharmonic
      motion%coefficients = 0*coefficients_of(branch, ends(1))
      do j = 1, 4
         if (.not. counts(j)) cycle
         weight = 1
         do k = 1, 4
            if (k /= j .and. counts(k)) weight = weight*(place - at(k))/(at(j) - at(k))
         end do
         motion%coefficients = motion%coefficients + weight*coefficients_of(branch, nodes(j))
      end do
      motion%frequency_ratio = value_on(branch%frequency_ratio(ends), slopes_of(branch, ends), share)
      call corrector%first_guess(motion, orbit)
   end subroutine guess_within

   !> Sign of the change of the test function of the kind between two points of the branch; 0: not known.
   pure integer function sense_of(branch, special, change) result(sense)
      type(branch_type), intent(in) :: branch
      !> The special point.
      type(special_point_type), intent(in) :: special
      !> Change of the number that `critical` counts.
      integer, intent(in) :: change
      integer :: ends(2)

      select case (special%kind)
      case ('fold')
         ends = neighbours(branch, special%point)
         associate (here => branch%frequency_ratio(special%point), before => branch%frequency_ratio(ends(1)), &
                    after => branch%frequency_ratio(ends(2)))
            sense = 0
            if (here > max(before, after)) sense = -1
            if (here < min(before, after)) sense = 1
         end associate
      case ('period doubling')
         sense = merge(-change, 0, special%multiplicity == 1)
      case ('neimark-sacker')
         sense = max(-1, min(1, change))
      case default
         sense = 0
      end select
   end function sense_of

   !> Finds the special point of a kind on the exact branch that is nearest to `start`.
   subroutine search(corrector, start, kind, multiplicity, sense, way_between, exact, found)
      type(orbit_corrector_type), intent(inout) :: corrector
      type(orbit_type), intent(in) :: start
      character(*), intent(in) :: kind
      !> Number of multipliers that pass the unit circle together.
      integer, intent(in) :: multiplicity
      !> Sign of the change of the test function, see `sense_of`; 0: any.
      integer, intent(in) :: sense
      !> Distance of the points of the branch on both sides [units_type].
      real(dp), intent(in) :: way_between
      type(orbit_type), intent(inout) :: exact
      logical, intent(out) :: found
      type(orbit_type) :: side(2), next
      real(dp) :: rise
      class(orbit_test_type), allocatable :: test
      real(dp) :: step(2), way(2)
      logical :: open_end(2)
      integer :: i, k

      ! The search begins a little before `start`: at the special point itself the sign of the test function is rounding.
      call corrector%advance(start, -0.5_dp*first_step, next, found)
      side = start
      if (found) side = next
      side(2)%tangent = -side(1)%tangent
      side(2)%tangent_frequency = -side(1)%tangent_frequency
      step = first_step
      way = 0
      open_end = .true.
      found = .false.
      do i = 1, max_steps
         k = minloc(way, 1, open_end)
         if (k == 0) exit
         call corrector%advance(side(k), step(k), next, found)
         if (.not. found) then
            step(k) = step(k)/3
            open_end(k) = step(k) > 1e-7_dp
            cycle
         end if
         call choose_test(kind, multiplicity, corrector%units%frequency_ratio, side(k), next, test)
         if (allocated(test)) then
            rise = test%value(next)
            ! On the way back the change has the opposite sign; for a fold the test function has the opposite sign as well.
            if (k == 2 .and. kind /= 'fold') rise = -rise
            if (rise*sense < 0) deallocate (test)
         end if
         if (allocated(test)) then
            call corrector%find_zero(test, side(k), step(k), next, exact, found)
            if (found) then
               ! The tangent gets the sense of the branch.
               if (k == 2) exact%tangent = -exact%tangent
               if (k == 2) exact%tangent_frequency = -exact%tangent_frequency
               return
            end if
         end if
         way(k) = way(k) + step(k)
         open_end(k) = way(k) < max(usual_way, way_between) .and. next%frequency_ratio > slowest*start%frequency_ratio
         step(k) = 1.5_dp*step(k)
         side(k) = next
      end do
      found = .false.
   end subroutine search

end module geartrain_exact_exact_search
