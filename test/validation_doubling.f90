!> Branch switching at period doublings: to period 2 and on to period 4, without a seed.
module validation_doubling
   use fixtures, only: closest, paper_train, settings_of
   use geartrain, only: branch_type, dp, error_type, integrate, integration_settings_type, motion_type, period_doubled, refine, &
                        response, response_settings_type, solutions_at
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: doubling_tests

contains

   subroutine doubling_tests(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: once, twice, four
      type(response_settings_type) :: settings
      type(motion_type), allocatable :: motions(:)
      type(error_type), allocatable :: error
      integer :: i, last

      call tests%begin('period doubling')
      settings = settings_of(1.2_dp, 2.6_dp, 12)
      call response(paper_train(), settings, once, error)
      last = findloc(once%special_points%kind, 'period doubling ', dim=1, back=.true.)
      call tests%is_true(last > 0, 'the period-1 branch doubles its period')
      if (last == 0) return
      ! The upper doubling, where contact is never lost: the branch leaves vertically.
      ! Found independently: 2.044; the fourth decimal is this library's own.
      call tests%is_close(once%special_points(last)%frequency, 2.0438_dp, 2e-4_dp, 'upper doubling')
      call period_doubled(paper_train(), settings, once, last, twice, error)
      call tests%is_true(twice%complete .and. twice%points > 10, 'period 2: '//twice%ended)
      call tests%is_close(twice%frequency(1), once%special_points(last)%frequency, 1e-6_dp, 'it leaves vertically')

      settings%subharmonic = 2
      settings%harmonics = 24
      call solutions_at(paper_train(), settings, twice, 1.92_dp, motions, error)
      i = closest(motions, 0.45639898_dp)
      call tests%is_true(i > 0, 'period 2 at 1.92')
      if (i == 0) return
      call tests%is_true(motions(i)%stable, 'stable at 1.92')
      call refine(paper_train(), motions(i), error)
      ! Time-integrated values.
      call tests%is_close(motions(i)%rms(1), 0.45639898_dp, 6e-9_dp, 'rms of mesh 1 at 1.92')
      call tests%is_close(motions(i)%rms(2), 0.54946446_dp, 6e-9_dp, 'rms of mesh 2 at 1.92')

      i = findloc(twice%special_points%kind, 'period doubling ', dim=1)
      call tests%is_true(i > 0, 'the period-2 branch doubles again')
      if (i == 0) return
      call period_doubled(paper_train(), settings, twice, i, four, error)
      call tests%is_true(four%complete .and. four%subharmonic == 4, 'period 4: '//four%ended)
      call period_four_is_genuine(tests, four)
      call period_doubled(paper_train(), settings, twice, size(twice%special_points) + 1, four, error)
      call tests%is_true(allocated(error), 'no such special point: an error')
   end subroutine doubling_tests

   !> Shooting over four mesh periods from a point of the branch converges to an orbit that does not repeat after two.
   subroutine period_four_is_genuine(tests, four)
      class(tests_type), intent(inout) :: tests
      type(branch_type), intent(in) :: four
      type(motion_type) :: motion
      type(error_type), allocatable :: error
      integer :: middle, k
      real(dp) :: odd

      middle = four%points/2
      motion%frequency = four%frequency(middle)
      motion%period = 4
      motion%coefficients = four%coefficients(:, :, middle)
      call refine(paper_train(), motion, error)
      call tests%is_true(.not. allocated(error), 'shooting on period 4 converges')
      if (allocated(error)) return
      call tests%is_close(maxval(abs(motion%rms - four%rms(:, middle))), 0.0_dp, 2e-3_dp, 'period 4: shooting and balance')
      odd = 0
      do k = 1, (size(motion%coefficients, 1) - 1)/2, 2
         odd = max(odd, maxval(abs(motion%coefficients(2*k:2*k + 1, :))))
      end do
      call tests%is_true(odd > 1e-2_dp, 'odd harmonics of Lambda/4 are there')
   end subroutine period_four_is_genuine

end module validation_doubling
