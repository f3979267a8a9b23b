!> Contact that just begins or ends, exact tangency, many short contacts, multipliers near the unit circle.
module hard_grazing
   use fixtures, only: paper_train, settings_of, single_pair, update_contact
   use geartrain, only: band_type, branch_type, dp, error_type, motion_type, refine, separation_ranges, &
      solutions_at, train_type
   use geartrain_base_kinds, only: pi
   use geartrain_flow_flow, only: flow_type
   use geartrain_mesh_law_contact, only: contact_type
   use geartrain_network_system, only: build_system, system_type
   use readings, only: solution, solve
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: grazing_cases

contains

   subroutine grazing_cases(tests)
      class(tests_type), intent(inout) :: tests

      call tests%heading('Grazing and verdicts')
      if (tests%runs('tangent_wall')) call tangent_wall(tests)
      if (tests%runs('short_contacts')) call short_contacts(tests)
      if (tests%runs('touching_flight')) call touching_flight(tests)
      if (tests%runs('onset')) call onset(tests)
      if (tests%runs('verdicts')) call verdicts(tests)
   end subroutine grazing_cases

   !> p = 2 - depth + cos theta with b = 1 separates for 2 acos(1 - depth) of 2 pi, or not at all. Rounding of p moves the events by
   !> epsilon over the slope there, sqrt(2 depth).
   subroutine tangent_wall(tests)
      class(tests_type), intent(inout) :: tests
      type(system_type) :: system
      type(contact_type) :: contact
      real(dp), parameter :: depth(*) = [1e-3_dp, 1e-8_dp, 1e-13_dp]
      character(12) :: text
      real(dp) :: expected
      integer :: i

      call build_system(single_pair(0.05_dp, 0.0_dp, 1.0_dp), system)
      call contact%setup(system%law(1), 1, [1], 4, 0)
      do i = 1, size(depth)
         ! From the same rounded mean as the contact, as the depth would be rounding otherwise.
         associate (mean => 2 - depth(i))
            call update_contact(contact, [mean, 1.0_dp, 0.0_dp])
            expected = 1 - 2*asin(sqrt((2 - mean)/2))/pi
         end associate
         write (text, '(es7.0)') depth(i)
         call tests%measured('gap entered by '//trim(adjustl(text))//' of the amplitude', 'share of contact in closed form', &
                             abs(real(contact%spectra%stiffness(0), dp) - expected), 4*epsilon(expected)/sqrt(2*depth(i)))
      end do
      call update_contact(contact, [2.0_dp, 1.0_dp, 0.0_dp])
      call tests%measured('motion tangent to the wall', 'share of contact 1', &
                          abs(real(contact%spectra%stiffness(0), dp) - 1), 1e-7_dp)
      call update_contact(contact, [2 + 1e-15_dp, 1.0_dp, 0.0_dp])
      call tests%measured('motion 1e-15 from the wall', 'share of contact 1', &
                          abs(real(contact%spectra%stiffness(0), dp) - 1), 1e-7_dp)
   end subroutine tangent_wall

   !> p = 0.02 + cos(24 theta) with b = 1 touches the drive flank 24 times a period, for 2 acos(0.98)/(2 pi) of it.
   subroutine short_contacts(tests)
      class(tests_type), intent(inout) :: tests
      type(system_type) :: system
      type(contact_type) :: contact
      real(dp) :: u(49)
      integer :: k

      call build_system(single_pair(0.05_dp, 0.0_dp, 1.0_dp), system)
      call contact%setup(system%law(1), 1, [(k, k=1, 24)], 96, 0)
      u = 0
      u(1) = 0.02_dp
      u(48) = 1
      call update_contact(contact, u)
      call tests%measured('24 short contacts a period', 'share of contact in closed form', &
                          abs(real(contact%spectra%stiffness(0), dp) - acos(0.98_dp)/pi) + abs(contact%events - 48), 1e-13_dp)
   end subroutine short_contacts

   !> Thrown off the drive flank just hard enough to touch the back flank with no speed: x = 1 + f + A cos t in contact, then a
   !> parabola of depth s^2/(2 f) = 2; f = 1/2, s = sqrt 2. Back after 2 (arc + flight) as if nothing had been there.
   subroutine touching_flight(tests)
      class(tests_type), intent(inout) :: tests
      type(system_type), target :: system
      type(flow_type) :: flow
      real(dp), parameter :: f = 0.5_dp, speed = sqrt(2.0_dp), amplitude = sqrt(f**2 + speed**2)
      real(dp) :: leave

      call build_system(single_pair(0.0_dp, 0.0_dp, f), system)
      call flow%setup(system, 1, 20, 1e-15_dp)
      flow%x(1, :) = [1 + f + amplitude, 0.0_dp]
      call flow%start(1.0_dp, 0.0_dp)
      leave = acos(-f/amplitude)
      call flow%advance(2*leave + 2*speed/f)
      call tests%measured('flight that touches the back flank with no speed', 'the way in closed form', &
                          maxval(abs(flow%x(1, :) - [1 + f + amplitude, 0.0_dp])), 1e-7_dp)
   end subroutine touching_flight

   !> Where mesh 2 stops separating on figure 3 (0.4950): the motion there touches the wall.
   subroutine onset(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: branch
      type(motion_type) :: motion, exact
      type(error_type), allocatable :: error
      type(band_type), allocatable :: ranges(:)
      real(dp) :: edge

      train = paper_train()
      branch = solve(train, settings_of(0.2_dp, 2.6_dp, 12))
      ranges = separation_ranges(branch, 2, .false.)
      edge = ranges(1)%to
      motion = solution(train, settings_of(edge, edge + 0.001_dp, 12))
      exact = solution(train, settings_of(edge + 0.001_dp, edge + 0.002_dp, 12))
      call tests%measured('the speed up to which mesh 2 separates (figure 3)', 'Lambda at which the smallest displacement is b', &
                          abs(motion%minimum(2) - 1)*0.001_dp/abs(exact%minimum(2) - motion%minimum(2)), 1e-4_dp)
      exact = motion
      call refine(train, exact, error)
      if (allocated(error)) exact%rms = huge(1.0_dp)
      call tests%measured('the motion there', 'shooting through the grazing contact, rms', maxval(abs(motion%rms - exact%rms)), &
                          1e-6_dp)
   end subroutine onset

   !> Where the verdict is not `undecided`, shooting agrees with it; a fold is undecided; the second estimate tells the error.
   subroutine verdicts(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train, conservative
      type(branch_type) :: branch
      type(motion_type), allocatable :: motions(:)
      type(error_type), allocatable :: error
      real(dp) :: first, known, off(2)
      real(dp), allocatable :: half(:)
      integer :: compared, i, j, k, wrong

      train = paper_train()
      branch = solve(train, settings_of(0.2_dp, 2.6_dp, 6))
      compared = 0
      wrong = 0
      off = 0
      do i = 2, branch%points - 1
         if (branch%second_estimate(i) < 0 .or. branch%undecided(i)) cycle
         call solutions_at(train, settings_of(0.2_dp, 2.6_dp, 6), branch, branch%frequency_ratio(i), motions, error)
         do k = 1, size(motions)
            if (maxval(abs(motions(k)%rms - branch%rms(:, i))) > 1e-6_dp) cycle
            first = abs(motions(k)%multipliers(1))
            call refine(train, motions(k), error)
            if (allocated(error)) cycle
            ! Next to a fold shooting may find the orbit of its other side, whose solution is then nearer.
            if (maxval(abs(motions(k)%rms - branch%rms(:, i))) > 3*branch%error_estimate(i)*norm2(branch%rms(:, i))) cycle
            if (any([(norm2(motions(k)%rms - motions(j)%rms) < norm2(motions(k)%rms - branch%rms(:, i)) .and. j /= k, &
                      j=1, size(motions))])) cycle
            known = abs(motions(k)%multipliers(1))
            compared = compared + 1
            if ((known < 1) .neqv. branch%stable(i)) wrong = wrong + 1
            off = off + abs([first, branch%second_estimate(i)] - known)
         end do
      end do
      call tests%holds('a second estimate of the largest multiplier, figure 3 at R = 6', &
                       'shooting: no verdict wrong that is not undecided', wrong == 0 .and. compared > 15)
      call tests%measured('the same', 'shooting: mean error of the second estimate over that of the first', off(2)/off(1), 0.5_dp)
      wrong = 0
      do i = 1, size(branch%special_points)
         associate (special => branch%special_points(i))
            if (special%kind == 'fold' .and. .not. branch%undecided(special%point)) wrong = wrong + 1
         end associate
      end do
      call tests%holds('the folds of figure 3 at R = 6', 'undecided, all of them', wrong == 0)
      ! Half of each step counts with the point at its end: points are closer together next to folds, where motions are undecided.
      associate (s => branch%arclength, n => branch%points)
         half = (s(2:n) - s(:n - 1))/2
         call tests%holds('all of figure 3 at R = 6', 'at most a tenth of the branch undecided', &
                          10*(sum(half, branch%undecided(2:n)) + sum(half, branch%undecided(:n - 1))) < s(n) - s(1))
      end associate
      conservative = single_pair(0.0_dp, 0.3_dp, 1.0_dp)
      conservative%meshes%half_backlash = 0
      branch = solve(conservative, settings_of(1.2_dp, 1.3_dp, 6))
      call tests%holds('no damping, multipliers on the unit circle', 'undecided, all points', &
                       all(branch%undecided) .and. branch%points > 1)
      call tests%measured('the same', 'Liouville: the product of the multipliers is 1', &
                          maxval(abs(product(branch%multipliers, 1) - 1)), 1e-9_dp)
   end subroutine verdicts

end module hard_grazing
