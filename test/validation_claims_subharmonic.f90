!> The claims of the paper's section 4.4 (figures 12 and 13); docs/claims.md has the table.
module validation_claims_subharmonic
   use fixtures, only: paper_train, settings_of
   use geartrain, only: attractors, attractors_settings_type, attractors_type, branch_type, dp, error_type, integrate, &
                        integration_settings_type, motion_type, response, solutions_at, train_type
   use readings, only: is_band, smallest_between, traced
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: claims_subharmonic_tests

contains

   subroutine claims_subharmonic_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('unstable_ranges')) call unstable_ranges(tests)
      if (tests%runs('period_two')) call period_two(tests)
      if (tests%runs('period_three')) call period_three(tests)
   end subroutine claims_subharmonic_tests

   !> Claims 65 and 66.
   subroutine unstable_ranges(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch

      branch = traced(tests, paper_train(), 4.5_dp, 1.4_dp, 6, 'period 1')
      call tests%is_true(is_band(branch, 1.7492_dp, 2.0439_dp, 1e-3_dp), 'claim 65: unstable around 2 w_a = 1.914')
      call tests%is_true(is_band(branch, 3.5143_dp, 3.9310_dp, 1e-3_dp), 'claim 66: unstable around 2 w_b = 3.732, not 3.92')
   end subroutine unstable_ranges

   !> Claims 67 to 70: stable period-2 motions at every frequency of the unstable ranges.
   subroutine period_two(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(motion_type) :: motion, diverging, far
      type(motion_type), allocatable :: motions(:)
      type(train_type) :: train
      type(integration_settings_type) :: settings
      type(error_type), allocatable :: error
      real(dp), parameter :: inside_a(7) = [1.752_dp, 1.80_dp, 1.85_dp, 1.90_dp, 1.95_dp, 2.00_dp, 2.04_dp]
      real(dp), parameter :: inside_b(5) = [3.52_dp, 3.6_dp, 3.7_dp, 3.8_dp, 3.92_dp]
      real(dp) :: deepest
      integer :: i, k

      settings%tolerance = 1e-7_dp
      call integrate(paper_train(), 1.92_dp, settings, motion, error)
      call response(paper_train(), settings_of(1.2_dp, 2.6_dp, 12, 2), branch, error, seed=motion)
      deepest = 1
      do i = 1, size(inside_a)
         call solutions_at(paper_train(), settings_of(1.2_dp, 2.6_dp, 12, 2), branch, inside_a(i), motions, error)
         call tests%is_true(any(motions%stable), 'claim 69: a stable period-2 motion in the range of 2 w_a')
         do k = 1, size(motions)
            if (motions(k)%stable) deepest = min(deepest, minval(motions(k)%minimum))
         end do
      end do
      call tests%is_true(deepest > -1, 'claim 68: the stable period-2 motions of the unstable range have no back collision')
      call tests%is_close(minval(branch%frequency_ratio(:branch%points)), 1.2526_dp, 2e-3_dp, 'claim 69: they reach down to 1.253')
      call tests%is_true(smallest_between(branch, 2, 1.2_dp, 1.6_dp) < -1, 'claim 68: below the range they collide')
      call tests%is_true(any(branch%stable .and. branch%minimum(2, :branch%points) < -1), 'claim 68: and are stable there')

      call integrate(paper_train(), 3.7_dp, settings, motion, error)
      call response(paper_train(), settings_of(2.6_dp, 4.6_dp, 12, 2), branch, error, seed=motion)
      call tests%is_close(maxval(branch%frequency_ratio(:branch%points)), 3.931_dp, 1e-3_dp, &
                          'claim 67: the period-2 branch leaves where the period-1 motion becomes unstable')
      do i = 1, size(inside_b)
         call solutions_at(paper_train(), settings_of(2.6_dp, 4.6_dp, 12, 2), branch, inside_b(i), motions, error)
         call tests%is_true(any(motions%stable), 'claim 69: a stable period-2 motion in the range of 2 w_b')
      end do

      ! Without backlash nothing holds the motion back.
      train = paper_train()
      train%meshes%half_backlash = 0
      settings%max_periods = 400
      call integrate(train, 1.92_dp, settings, diverging, error)
      call tests%is_true(allocated(error) .and. diverging%period == 0 .and. maxval(abs(diverging%state)) > 1e3_dp, &
                         'claim 70: without backlash it grows without bound')

      ! With it too, from far beyond the gap: there the train is the linear one, and the largest multiplier of that is beyond 1.
      settings%max_periods = 150
      call integrate(paper_train(), 1.9_dp, settings, motion, error)
      call tests%is_true(maxval(abs(motion%state)) < 5, 'claim 70: with backlash it stays within some half backlashes from rest')
      far = motion
      far%state(4) = 5
      call integrate(paper_train(), 1.9_dp, settings, motion, error, start=far)
      call tests%is_true(maxval(abs(motion%state)) < 5, 'claim 70: and from mesh 2 at 5 b_c')
      far%state(4) = 20
      call integrate(paper_train(), 1.9_dp, settings, motion, error, start=far)
      call tests%is_true(maxval(abs(motion%state)) > 1e6_dp, 'claim 70: from mesh 2 at 20 b_c it grows without bound')
   end subroutine period_two

   !> Claims 71 to 74.
   subroutine period_three(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: island
      type(attractors_type) :: found
      type(motion_type), allocatable :: island_motions(:)
      type(error_type), allocatable :: error
      integer :: i, k

      call attractors(paper_train(), attractors_settings_type(frequency=2.2_dp, starts=32, random_seed=1, &
                                                              tolerance=1e-7_dp), &
                      found, error)
      k = findloc(found%motions%period, 3, 1)
      call tests%is_true(k > 0, 'claim 71: random starts settle on a period-3 motion at 2.2')
      if (k == 0) return
      call tests%is_true(found%motions(k)%share < 0.5_dp, 'claim 74: few starts lead to it')
      i = findloc(found%motions%period, 1, 1)
      call tests%is_true(i > 0, 'claim 72: a stable period-1 motion beside it')
      if (i > 0) call tests%is_true(found%motions(i)%stable, 'claim 72: a stable period-1 motion beside it')
      call response(paper_train(), settings_of(1.2_dp, 3.6_dp, 18, 3), island, error, seed=found%motions(k))
      call tests%is_true(island%closed, 'claim 73: an island: '//island%ended%text)
      call tests%is_close(minval(island%frequency_ratio(:island%points)), 1.7687_dp, 2e-3_dp, 'claim 71: its lower end')
      call tests%is_close(maxval(island%frequency_ratio(:island%points)), 2.4981_dp, 2e-3_dp, 'claim 71: it ends far below 3 w_a')
      call solutions_at(paper_train(), settings_of(1.2_dp, 3.6_dp, 18, 3), island, 2.3_dp, island_motions, error)
      call tests%is_true(size(island_motions) == 2 .and. count(island_motions%stable) == 1, &
                         'claim 72: one stable and one unstable period-3 motion at 2.3')
   end subroutine period_three

end module validation_claims_subharmonic
