!> Where a branch bifurcates by its own balance, near a special point of it, and the direction in which the other branch leaves.
!>
!> A truncated balance and the monodromy along it do not place a doubling alike: with few harmonics they are far enough apart that
!> a step from the place of the one misses the branch of the other. So the balance's own place is found:
!> where a matrix is singular that is regular elsewhere (geartrain_branch_singular).
module geartrain_branch_critical_point
   use geartrain_base_kinds, only: dp
   use geartrain_branch_bend, only: cosine, passes_half_period
   use geartrain_branch_branch, only: branch_type, response_settings_type
   use geartrain_branch_path, only: place_type
   use geartrain_branch_same_place, only: same_place
   use geartrain_branch_singular, only: singular_type
   use geartrain_branch_special_points, only: between, go_along, locate_half_period, shrink
   use geartrain_branch_start, only: begin_trace, place_of
   use geartrain_branch_tracer, only: tracer_type
   use geartrain_branch_variables, only: settings_for
   use geartrain_model_train, only: train_type
   use geartrain_motion_motion, only: motion_type
   implicit none (type, external)
   private
   public :: find_critical, find_meeting, harmonics_at

   !> Farthest from the special point, in the metric of the branch, and most steps there.
   real(dp), parameter :: farthest = 0.25_dp
   integer, parameter :: max_steps = 60
   !> First step away from it, at most.
   real(dp), parameter :: first_step = 0.01_dp
   !> Length of a piece of a branch on which the cubic through its ends is as exact as its points.
   real(dp), parameter :: cubic = 2e-4_dp

contains

   !> The place of the balance's own nearest to special point number `special` of `branch`, the unit critical vector as its tangent:
   !> for a doubling a place of the balance of twice the period, all its odd harmonics 0.
   subroutine find_critical(train, settings, branch, special, place, success, harmonics, taken)
      type(train_type), intent(in) :: train
      !> Those that `branch` was traced with.
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: special
      type(place_type), intent(out) :: place
      logical, intent(out) :: success
      !> Of the branch's balance, where `settings` leaves them to the program; else those of the branch there.
      integer, intent(in), optional :: harmonics
      !> Places that belong to other special points of the branch.
      type(place_type), intent(in), optional :: taken(:)
      type(singular_type) :: matrix
      type(place_type) :: side(2), next
      real(dp), allocatable :: u(:, :, :), y(:), f(:, :), f_next(:)
      real(dp) :: step(2), way(2), h
      logical :: open_end(2)
      integer :: i, j, k, l, highest, period

      matrix%doubles = branch%special_points(special)%kind == 'period doubling'
      period = merge(2, 1, matrix%doubles)*settings%subharmonic
      call begin_trace(train, settings, matrix%single)
      if (matrix%doubles) call begin_trace(train, settings_for(settings, 2*settings%subharmonic), matrix%double)
      if (settings%harmonics == 0) then
         highest = harmonics_at(branch, special)
         if (present(harmonics)) highest = harmonics
         call matrix%single%prepare(highest)
         if (matrix%doubles) call matrix%double%prepare(2*highest)
      end if
      ! The way along the branch is what counts here, whatever the control of the trace.
      matrix%single%path%local_control = .false.
      call told_place(matrix%single, branch, special, side(1), h, success)
      if (.not. success) return
      side(2) = side(1)
      side(2)%tangent = -side(1)%tangent
      side(2)%tangent_frequency = -side(1)%tangent_frequency
      call matrix%find_modes(side(1), u, y)
      allocate (f(size(y), 2), f_next(size(y)))
      call matrix%test(side(1), u, y, f(:, 1))
      f(:, 2) = f(:, 1)
      step = h
      way = 0
      open_end = .true.
      ! Outwards on both sides in turn, so that the nearest zero is found first.
      do i = 1, max_steps
         k = minloc(way, 1, open_end)
         if (k == 0) exit
         call matrix%single%path%advance(side(k), step(k), next, success)
         if (success) success = cosine(side(k), next, matrix%single%path%units) > 0.8_dp
         if (.not. success) then
            step(k) = step(k)/3
            open_end(k) = step(k) > 1e-6_dp
            cycle
         end if
         call matrix%test(next, u, y, f_next)
         do j = 1, size(y)
            if (f_next(j)*f(j, k) > 0) cycle
            call find_zero(matrix, u(:, :, j:j), y(j:j), side(k), next, step(k), f(j, k), f_next(j), place, success)
            if (success .and. present(taken)) then
               do l = 1, size(taken)
                  if (same_place(place, taken(l), period, matrix%single%path%units, .true.)) success = .false.
               end do
            end if
            if (success) return
         end do
         way(k) = way(k) + step(k)
         open_end(k) = way(k) < farthest
         step(k) = 1.5_dp*step(k)
         side(k) = next
         f(:, k) = f_next
      end do
      success = .false.
   end subroutine find_critical

   !> The zero of the test function of a vector between `here` and `next`, a distance h further, and the critical vector there.
   subroutine find_zero(matrix, u, y, here, next, h, f_here, f_next, place, success)
      type(singular_type), intent(inout) :: matrix
      !> One vector.
      real(dp), intent(in) :: u(:, :, :), y(:)
      type(place_type), intent(in) :: here, next
      real(dp), intent(in) :: h, f_here, f_next
      type(place_type), intent(inout) :: place
      logical, intent(out) :: success
      type(place_type) :: first, last, middle
      real(dp) :: a, b, fa, fb, f(1), s, length, scale, x(size(u, 1), size(u, 2)), xy
      integer :: i, kept

      first = here
      last = next
      middle = here
      length = h
      fa = f_here
      fb = f_next
      scale = max(abs(fa), abs(fb))
      s = 0
      ! Next to a branch point Newton's method fails on the branch itself: the last piece is a cubic.
      do while (length > cubic)
         length = length/2
         call matrix%single%path%advance(here, s + length, middle, success)
         if (.not. success) return
         call matrix%test(middle, u, y, f)
         if ((f(1) > 0) .eqv. (fa > 0)) then
            first = middle
            s = s + length
            fa = f(1)
         else
            last = middle
            fb = f(1)
         end if
      end do
      a = 0
      b = length
      kept = 0
      do i = 1, max_steps
         s = between(a, b, fa, fb)
         call go_along(first, last, length, s, middle)
         call matrix%test(middle, u, y, f)
         if (abs(f(1)) < 1e-10_dp*scale) exit
         call shrink(a, b, fa, fb, s, f(1), kept)
         if (b - a < 1e-12_dp) exit
      end do
      x = u(:, :, 1)
      xy = y(1)
      call matrix%solve(x, xy)
      length = matrix%single%path%length_of(x, xy)
      ! A pole changes sign as well.
      success = abs(f(1)) < 1e-3_dp*scale .and. length > 0 .and. length < huge(1.0_dp)
      if (.not. success) return
      if (matrix%doubles) then
         call matrix%lift(middle, place)
      else
         place = middle
      end if
      place%tangent = x/length
      place%tangent_frequency = xy/length
      place%orientation = 0
   end subroutine find_zero

   !> Where a branch of even period ends at the branch of half its period, if it does: the place at which its odd harmonics vanish,
   !> with their direction as its tangent.
   subroutine find_meeting(train, settings, branch, place, met)
      type(train_type), intent(in) :: train
      !> Those that `branch` was traced with.
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: branch
      type(place_type), intent(inout) :: place
      logical, intent(out) :: met
      type(tracer_type) :: tracer
      type(place_type) :: here, next
      real(dp) :: chord
      integer :: k
      logical :: success

      met = .false.
      if (branch%points < 2) return
      call begin_trace(train, settings, tracer)
      tracer%path%local_control = .false.
      associate (n => branch%points - 1)
         ! An even number, so that a balance of half the period has half as many.
         if (settings%harmonics == 0) call tracer%prepare(2*((maxval(branch%point_harmonics(n:n + 1)) + 1)/2))
         call span(tracer, branch, n, here, next, chord)
      end associate
      if (settings%harmonics == 0) then
         next%tangent = here%tangent
         next%tangent_frequency = here%tangent_frequency
         call tracer%path%correct(here, success)
         if (success) call tracer%path%correct(next, success)
         if (success) then
            call point_at(tracer, here, next, chord)
         else
            call span(tracer, branch, branch%points - 1, here, next, chord)
         end if
      end if
      met = passes_half_period(here, next, branch%subharmonic)
      if (.not. met) return
      call locate_half_period(tracer%path, here, next, chord, place)
      allocate (place%tangent, mold=here%u)
      place%tangent = here%u
      place%tangent(1, :) = 0
      do k = 2, (size(here%u, 1) - 1)/2, 2
         place%tangent(2*k:2*k + 1, :) = 0
      end do
      place%tangent = place%tangent/tracer%path%length_of(place%tangent)
   end subroutine find_meeting

   !> Points n and n+1 of a branch as places; `here` has the unit vector along the chord as its tangent.
   subroutine span(tracer, branch, n, here, next, chord)
      type(tracer_type), intent(in) :: tracer
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: n
      type(place_type), intent(out) :: here, next
      real(dp), intent(out) :: chord
      type(motion_type) :: motion

      motion%period = branch%subharmonic
      motion%frequency = branch%frequency(n)
      motion%coefficients = branch%coefficients(:, :, n)
      here = place_of(tracer, motion)
      motion%frequency = branch%frequency(n + 1)
      motion%coefficients = branch%coefficients(:, :, n + 1)
      next = place_of(tracer, motion)
      call point_at(tracer, here, next, chord)
   end subroutine span

   !> Makes the tangent of `here` the unit vector along the chord to `next`.
   subroutine point_at(tracer, here, next, chord)
      type(tracer_type), intent(in) :: tracer
      type(place_type), intent(inout) :: here
      type(place_type), intent(in) :: next
      real(dp), intent(out) :: chord

      here%tangent = next%u - here%u
      here%tangent_frequency = next%frequency - here%frequency
      chord = tracer%path%length_of(here%tangent, here%tangent_frequency)
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
   subroutine told_place(single, branch, special, place, h, success)
      type(tracer_type), intent(inout) :: single
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: special
      type(place_type), intent(out) :: place
      real(dp), intent(out) :: h
      logical, intent(out) :: success
      type(place_type) :: after
      real(dp) :: share, chord

      call span(single, branch, branch%special_points(special)%point, place, after, chord)
      h = min(first_step, chord/4)
      success = chord > 0
      if (.not. success) return
      share = 0
      if (abs(after%frequency - place%frequency) > 0) &
         share = (branch%special_points(special)%frequency - place%frequency)/(after%frequency - place%frequency)
      ! At a branch point itself Newton's method fails; the points next to it are near enough.
      if (branch%special_points(special)%kind == 'branch point') share = 0
      ! Next to a fold the frequency tells little.
      share = max(0.0_dp, min(1.0_dp, share))
      place%u = place%u + share*chord*place%tangent
      place%frequency = place%frequency + share*chord*place%tangent_frequency
      call single%path%correct(place, success)
   end subroutine told_place

end module geartrain_branch_critical_point
