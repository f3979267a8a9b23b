!> Where the balance itself doubles its period near a period doubling that the multipliers told, and the vector in which it does.
!>
!> A truncated balance and the monodromy along it do not place a doubling alike: with few harmonics they are far enough apart that
!> a step from the place of the one misses the branch of the other. So the balance's own doubling is found: with J the Jacobian of
!> the balance of twice the period, at a motion of the single one, the solution v, g of
!>    [J b; c 0] [v; g] = [0; 1],   b and c on the odd harmonics, which the motion lacks,
!> has g = 0 exactly where J is singular on the odd harmonics, and v is the critical vector there. Where the bordered matrix is
!> singular g has a pole; it is far away when b and c are near to the left and right critical vectors.
module geartrain_branch_doubling_point
   use geartrain_base_kinds, only: dp, pi
   use geartrain_branch_bend, only: cosine, passes_half_period
   use geartrain_branch_branch, only: branch_type, response_settings_type
   use geartrain_branch_path, only: place_type
   use geartrain_branch_special_points, only: between, locate_half_period, shrink
   use geartrain_branch_start, only: begin_trace, place_of
   use geartrain_branch_tracer, only: tracer_type
   use geartrain_branch_units, only: units_type
   use geartrain_branch_variables, only: settings_for
   use geartrain_model_train, only: train_type
   use geartrain_motion_motion, only: motion_type
   implicit none (type, external)
   private
   public :: find_doubling, find_meeting, harmonics_at, same_doubling

   !> Farthest from the doubling that the multipliers told, in the metric of the branch, and most steps there.
   real(dp), parameter :: farthest = 0.25_dp
   integer, parameter :: max_steps = 60
   !> First step away from it, at most.
   real(dp), parameter :: first_step = 0.01_dp
   !> Doublings closer than this in the metric of the branch are one. Two ways to the same one agree to some 1e-6.
   real(dp), parameter :: same_place = 1e-3_dp

contains

   !> The balance's own doubling nearest to special point number `special` of `branch`, as a place of the balance of twice the
   !> period (all its odd harmonics 0), the unit critical vector as its tangent.
   subroutine find_doubling(train, settings, branch, special, place, success, harmonics)
      type(train_type), intent(in) :: train
      !> Those that `branch` was traced with.
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: special
      type(place_type), intent(out) :: place
      logical, intent(out) :: success
      !> Of the balance of the single period, where `settings` leaves them to the program; else those of the branch there.
      integer, intent(in), optional :: harmonics
      type(tracer_type) :: single, double
      type(place_type) :: side(2), next
      real(dp), allocatable :: border(:, :, :)
      real(dp) :: g(2), step(2), way(2), g_next, h
      logical :: open_end(2)
      integer :: i, k, highest

      call begin_trace(train, settings, single)
      call begin_trace(train, settings_for(settings, 2*settings%subharmonic), double)
      if (settings%harmonics == 0) then
         highest = harmonics_at(branch, special)
         if (present(harmonics)) highest = harmonics
         call single%prepare(highest)
         call double%prepare(2*highest)
      end if
      ! The way along the branch is what counts here, whatever the control of the trace.
      single%path%local_control = .false.
      call told_place(single, branch, special, side(1), h, success)
      if (.not. success) return
      side(2) = side(1)
      side(2)%tangent = -side(1)%tangent
      side(2)%tangent_frequency = -side(1)%tangent_frequency
      call find_borders(double, single, side(1), border)
      call test_function(double, single, side(1), border, g(1), place)
      g(2) = g(1)
      step = h
      way = 0
      open_end = .true.
      ! Outwards on both sides in turn, so that the nearest zero is found first.
      do i = 1, max_steps
         k = minloc(way, 1, open_end)
         if (k == 0) exit
         call single%path%advance(side(k), step(k), next, success)
         if (success) success = cosine(side(k), next, single%path%units) > 0.8_dp
         if (.not. success) then
            step(k) = step(k)/3
            open_end(k) = step(k) > 1e-6_dp
            cycle
         end if
         call test_function(double, single, next, border, g_next, place)
         if (g_next*g(k) <= 0) then
            call find_zero(double, single, border, side(k), step(k), g(k), g_next, place, success)
            if (success) return
         end if
         way(k) = way(k) + step(k)
         open_end(k) = way(k) < farthest
         step(k) = 1.5_dp*step(k)
         side(k) = next
         g(k) = g_next
      end do
      success = .false.
   end subroutine find_doubling

   !> Where a branch of even period ends at the branch of half its period, if it does: the place at which its odd harmonics vanish.
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
      if (met) call locate_half_period(tracer%path, here, next, chord, place)
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
      ! Next to a fold the frequency tells little.
      share = max(0.0_dp, min(1.0_dp, share))
      place%u = place%u + share*chord*place%tangent
      place%frequency = place%frequency + share*chord*place%tangent_frequency
      call single%path%correct(place, success)
   end subroutine told_place

   !> The zero of g between `here` and the place `h` further.
   subroutine find_zero(double, single, border, here, h, g_here, g_next, place, success)
      type(tracer_type), intent(inout) :: double, single
      real(dp), intent(in) :: border(:, :, :)
      type(place_type), intent(in) :: here
      real(dp), intent(in) :: h, g_here, g_next
      type(place_type), intent(inout) :: place
      logical, intent(out) :: success
      type(place_type) :: middle
      real(dp) :: a, b, ga, gb, g, s, scale
      integer :: i, kept

      a = 0
      b = h
      ga = g_here
      gb = g_next
      scale = max(abs(ga), abs(gb))
      kept = 0
      do i = 1, max_steps
         s = between(a, b, ga, gb)
         call single%path%advance(here, s, middle, success)
         if (.not. success) return
         call test_function(double, single, middle, border, g, place)
         success = abs(g) < 1e-10_dp*scale
         if (success) return
         call shrink(a, b, ga, gb, s, g, kept)
         if (b - a < 1e-12_dp) exit
      end do
      ! A pole changes sign as well.
      success = abs(g) < 1e-3_dp*scale
   end subroutine find_zero

   !> b and c for the test function near `here`, (block, unknowns, 2): unit vectors, made from the bordered matrix with two others.
   subroutine find_borders(double, single, here, border)
      type(tracer_type), intent(inout) :: double, single
      type(place_type), intent(in) :: here
      real(dp), allocatable, intent(out) :: border(:, :, :)
      type(place_type) :: place
      real(dp) :: g, unit(double%path%balance%block, double%path%balance%unknowns)
      integer :: i, k, l

      associate (balance => double%path%balance)
         allocate (border(balance%block, balance%unknowns, 2), source=0.0_dp)
         do k = 1, size(balance%harmonic), 2
            border(2*k, :, :) = 1.0_dp/balance%harmonic(k)
            border(2*k + 1, :, :) = 0.7_dp/balance%harmonic(k)
         end do
         call test_function(double, single, here, border, g, place)
         if (.not. g < huge(1.0_dp)) return
         ! The last unknown, for each unit vector on the right, is the left vector's component.
         border = 0
         do i = 1, balance%unknowns
            do k = 1, size(balance%harmonic), 2
               do l = 2*k, 2*k + 1
                  unit = 0
                  unit(l, i) = 1
                  call double%path%matrix%solve(balance, unit, border(l, i, 1))
               end do
               border(2*k:2*k + 1, i, 2) = place%tangent(2*k:2*k + 1, i)
            end do
         end do
      end associate
      border(:, :, 1) = border(:, :, 1)/norm2(border(:, :, 1))
      border(:, :, 2) = border(:, :, 2)/norm2(border(:, :, 2))
   end subroutine find_borders

   !> g and, in `place`, the motion `here` in the balance of twice the period with the vector v of unit length as its tangent.
   !> Where the bordered matrix is singular g is huge.
   subroutine test_function(double, single, here, border, g, place)
      type(tracer_type), intent(inout) :: double, single
      type(place_type), intent(in) :: here
      !> b and c.
      real(dp), intent(in) :: border(:, :, :)
      real(dp), intent(out) :: g
      type(place_type), intent(inout) :: place
      integer :: k, r
      logical :: regular

      associate (balance => double%path%balance, matrix => double%path%matrix, harmonic => single%path%balance%harmonic)
         if (allocated(place%u)) deallocate (place%u, place%tangent)
         allocate (place%u(balance%block, balance%unknowns), place%tangent(balance%block, balance%unknowns), source=0.0_dp)
         place%u(1, :) = here%u(1, :)
         do k = 1, size(harmonic)
            r = 2*harmonic(k)
            place%u(2*r:2*r + 1, :) = here%u(2*k:2*k + 1, :)
         end do
         place%frequency = here%frequency
         place%tangent_frequency = 0
         place%orientation = 0
         call balance%evaluate(place%u, place%frequency)
         call matrix%linearize(balance)
         matrix%column = border(:, :, 1)
         matrix%row = border(:, :, 2)
         matrix%corner = 0
         call matrix%factor(balance, regular)
         g = huge(1.0_dp)
         if (.not. regular) return
         g = 1
         call matrix%solve(balance, place%tangent, g)
      end associate
      place%tangent = place%tangent/double%path%length_of(place%tangent)
   end subroutine test_function

   !> Whether two motions of the balance of twice the period `period` (odd harmonics aside) are one, or the same some mesh periods
   !> later.
   pure logical function same_doubling(one, other, period, units)
      type(place_type), intent(in) :: one, other
      !> Of the single motion, in mesh periods.
      integer, intent(in) :: period
      type(units_type), intent(in) :: units
      real(dp) :: difference
      complex(dp) :: a, b
      integer :: i, k, shift, orders

      same_doubling = .false.
      orders = (max(size(one%u, 1), size(other%u, 1)) - 1)/2
      do shift = 0, period - 1
         difference = ((one%frequency - other%frequency)/units%frequency)**2
         do i = 1, size(one%u, 2)
            difference = difference + ((one%u(1, i) - other%u(1, i))/units%length)**2
            do k = 2, orders, 2
               a = harmonic_of(one%u(:, i), k)
               b = harmonic_of(other%u(:, i), k)*exp(cmplx(0, pi*k*shift/period, dp))
               difference = difference + 0.5_dp*(abs(a - b)/units%length)**2
            end do
         end do
         same_doubling = difference < same_place**2
         if (same_doubling) return
      end do
   end function same_doubling

   !> Harmonic k of a set of coefficients as a complex amplitude, 0 beyond the last.
   pure complex(dp) function harmonic_of(u, k)
      real(dp), intent(in) :: u(:)
      integer, intent(in) :: k

      harmonic_of = 0
      if (2*k + 1 <= size(u)) harmonic_of = cmplx(u(2*k), -u(2*k + 1), dp)
   end function harmonic_of

end module geartrain_branch_doubling_point
