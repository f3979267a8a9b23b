!> Searches a branch for the nearest solution point at which it bifurcates: a zero of the test functions of a singular matrix.
module geartrain_trace_singular_search
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_bracket, only: between, shrink
   use geartrain_network_system, only: system_type
   use geartrain_trace_corrector, only: corrector_type, solution_point_type
   use geartrain_trace_same_solution, only: same_solution
   use geartrain_trace_singular, only: singular_type
   use geartrain_trace_special_points, only: rms_of
   use geartrain_trace_step_geometry, only: cosine, go_along, odd_share, way_to
   implicit none (type, external)
   private
   public :: find_nearest, find_crossing

   !> Length of branch searched on each side, in the metric of the branch, and most steps of a search.
   real(dp), parameter :: farthest = 0.25_dp
   integer, parameter :: max_steps = 60
   !> Longer steps that are tried, each three times the one before, where a step fails.
   integer, parameter :: most_leaps = 3
   !> Length of a piece of a branch on which the cubic through the ends is as exact as the points.
   real(dp), parameter :: cubic = 2e-4_dp
   !> Value of a test function, of a matrix of the size of 1, that tells a regular matrix from a singular one.
   real(dp), parameter :: regular = 1e-9_dp
   !> Share of a motion below which odd harmonics are 0 within the accuracy of a critical point [1].
   real(dp), parameter :: half_period = 1e-5_dp

contains

   !> Finds the branch point near a point of a branch.
   subroutine find_crossing(corrector, here, h, group, frequency_ratio, rms, way, success)
      type(corrector_type), intent(in) :: corrector
      !> Point of the branch from which to search.
      type(solution_point_type), intent(in) :: here
      !> Length of the step from `here` in which the determinant changes sign, in the metric of the branch [1].
      real(dp), intent(in) :: h
      !> Number of the group of equal branches that begin to move differently there; 0: none.
      integer, intent(in) :: group
      !> Lambda of the branch point [1], where there is success.
      real(dp), intent(out) :: frequency_ratio
      !> Its rms over characteristic length [1], (mesh).
      real(dp), allocatable, intent(out) :: rms(:)
      !> Its distance from `here` along the tangent, in the metric of the branch [1]; negative behind `here`.
      real(dp), intent(out) :: way
      !> A branch point was found.
      logical, intent(out) :: success
      type(system_type), target :: systems(2)
      type(singular_type) :: matrix
      type(solution_point_type) :: solution

      call matrix%setup(corrector, systems, .false., group)
      if (group > 0) then
         call find_nearest(matrix, here, h, solution, success, within=h)
      else
         call find_nearest(matrix, here, h, solution, success)
      end if
      if (.not. success) return
      frequency_ratio = solution%frequency_ratio
      rms = rms_of(matrix%single, solution)
      way = way_to(here, solution, matrix%single%units)
   end subroutine find_crossing

   !> Finds the nearest critical point of a branch, searching both ways.
   subroutine find_nearest(matrix, from, h, solution, success, taken, again, within)
      !> Matrix after `setup`, for period doublings or branch points.
      type(singular_type), intent(inout) :: matrix
      !> Solution point of the branch from which to search, with its tangent.
      type(solution_point_type), intent(in) :: from
      !> Length of the first step, in the metric of the branch [1].
      real(dp), intent(in) :: h
      !> Critical point with the unit critical vector as its tangent: of a period doubling on the balance of twice the period.
      type(solution_point_type), intent(inout) :: solution
      !> A critical point was found.
      logical, intent(out) :: success
      !> Critical points to pass over.
      type(solution_point_type), intent(in), optional :: taken(:)
      !> Becomes true where a critical point was passed over.
      logical, intent(inout), optional :: again
      !> Length of branch that is searched on each side, in the metric of the branch; `farthest` unless it is given.
      real(dp), intent(in), optional :: within
      type(solution_point_type) :: side(2), next
      real(dp), allocatable :: f(:, :), f_next(:)
      real(dp) :: step(2), way(2), longest
      logical :: open_end(2)
      integer :: i, j, k, l

      side = from
      side(2)%tangent = -from%tangent
      side(2)%tangent_frequency = -from%tangent_frequency
      call matrix%find_modes(from)
      call matrix%test(from, f_next)
      f = spread(f_next, 2, 2)
      step = h
      way = 0
      open_end = .true.
      longest = farthest
      if (present(within)) longest = within
      ! On both sides in turn, so that the nearest zero is found first.
      do i = 1, max_steps
         k = minloc(way, 1, open_end)
         if (k == 0) exit
         ! Newton's method fails next to a branch point, but not beyond it.
         do j = 0, most_leaps
            call matrix%single%advance(side(k), 3.0_dp**j*step(k), next, success)
            if (success) success = cosine(side(k), next, matrix%single%units) > 0.8_dp
            if (success) exit
         end do
         if (success) step(k) = 3.0_dp**j*step(k)
         if (.not. success) then
            step(k) = step(k)/3
            open_end(k) = step(k) > 1e-6_dp
            cycle
         end if
         call matrix%test(next, f_next)
         do j = 1, size(f_next)
            if (f_next(j)*f(j, k) > 0) cycle
            ! Along a vertical branch the matrix may stay singular, and signs are rounding.
            if (max(abs(f_next(j)), abs(f(j, k))) < regular) cycle
            call find_zero(matrix, j, side(k), next, step(k), f(j, k), f_next(j), solution, success)
            if (matrix%doubles) solution%harmonic = matrix%double%balance%harmonic
            ! A branch of even period crosses the branch of half its period where it begins and ends.
            if (success .and. .not. matrix%doubles .and. mod(matrix%single%balance%waves(), 2) == 0) &
               success = odd_share(solution%u) > half_period**2
            ! A fold next to a period doubling is a zero of the doubled balance too; the critical vector tells them apart.
            if (success .and. matrix%doubles) success = odd_share(solution%tangent) > 0.5_dp
            if (success .and. present(taken)) then
               do l = 1, size(taken)
                  if (same_solution(solution, taken(l), matrix%period(), matrix%single%units, .true.)) success = .false.
               end do
               if (present(again) .and. .not. success) again = .true.
            end if
            if (success) return
         end do
         way(k) = way(k) + step(k)
         open_end(k) = way(k) < longest
         step(k) = 1.5_dp*step(k)
         side(k) = next
         f(:, k) = f_next
      end do
      success = .false.
   end subroutine find_nearest

   !> The zero of test function number `mode` between `here` and `next`, a distance h apart, with the critical vector as tangent.
   subroutine find_zero(matrix, mode, here, next, h, f_here, f_next, solution, success)
      type(singular_type), intent(inout) :: matrix
      integer, intent(in) :: mode
      type(solution_point_type), intent(in) :: here, next
      real(dp), intent(in) :: h, f_here, f_next
      type(solution_point_type), intent(inout) :: solution
      logical, intent(out) :: success
      type(solution_point_type) :: first, last, middle
      real(dp), allocatable :: f(:), x(:, :)
      real(dp) :: a, b, fa, fb, s, length, scale, y
      real(dp), parameter :: share(*) = [0.5_dp, 0.37_dp, 0.67_dp, 0.21_dp, 0.83_dp]
      integer :: i, kept

      first = here
      last = next
      middle = here
      length = h
      fa = f_here
      fb = f_next
      scale = max(abs(fa), abs(fb))
      s = 0
      ! Next to a branch point Newton's method fails on the branch itself: the last piece is taken as a cubic.
      do while (length > cubic)
         do i = 1, size(share)
            call matrix%single%advance(here, s + share(i)*length, middle, success)
            if (success) exit
         end do
         if (.not. success) return
         call matrix%test(middle, f)
         if ((f(mode) > 0) .eqv. (fa > 0)) then
            first = middle
            s = s + share(i)*length
            length = (1 - share(i))*length
            fa = f(mode)
         else
            last = middle
            length = share(i)*length
            fb = f(mode)
         end if
      end do
      a = 0
      b = length
      kept = 0
      do i = 1, max_steps
         s = between(a, b, fa, fb)
         call go_along(first, last, s/length, matrix%single%units, middle)
         call matrix%test(middle, f)
         if (abs(f(mode)) < 1e-10_dp*scale) exit
         call shrink(a, b, fa, fb, s, f(mode), kept)
         if (b - a < 1e-12_dp) exit
      end do
      if (matrix%doubles) then
         call matrix%lift(middle, solution)
      else
         solution = middle
      end if
      x = solution%u
      call matrix%solution(mode, x, y)
      length = matrix%single%length_of(x, y)
      ! The test function changes sign at a pole as well.
      success = abs(f(mode)) < 1e-3_dp*scale .and. length > 0 .and. length < huge(1.0_dp)
      solution%tangent = x/length
      solution%tangent_frequency = y/length
      solution%orientation = 0
   end subroutine find_zero

end module geartrain_trace_singular_search
