!> The error estimate of every point, and the harmonics chosen by it, against shooting at the same Lambda.
module validation_error_estimate
   use fixtures, only: paper_train, settings_of
   use geartrain, only: branch_type, dp, error_type, motion_type, refine, response, response_settings_type, solutions_at, &
                        train_type
   use geartrain_trace_branch, only: coefficients_of
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: error_estimate_tests

   !> Harmonics that the motion to be refined is padded to, so that the result holds the tail that the balance cuts off.
   integer, parameter :: padded = 300

contains

   subroutine error_estimate_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('against_shooting')) call against_shooting(tests)
      if (tests%runs('of_sampled_coefficients')) call of_sampled_coefficients(tests)
      if (tests%runs('by_tolerance')) call by_tolerance(tests)
      if (tests%runs('hunting_teeth')) call hunting_teeth(tests)
   end subroutine error_estimate_tests

   !> Figure 3 between 0.9 and 0.65, separation, back contact and folds: at R = 6 a harmonic that meets the highest natural
   !> frequency, 22 times 0.73, moves the branch by more than all below it. The exact motions are those of a branch with 60
   !> harmonics, refined.
   subroutine against_shooting(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: harmonics(3) = [6, 12, 24]
      real(dp), parameter :: floor = 1e-10_dp
      type(branch_type) :: reference, branch
      type(error_type), allocatable :: error
      type(response_settings_type) :: settings
      real(dp) :: ratio, true
      integer :: i, k, points, within_3, within_6, all_within_3
      character(2) :: name

      settings = settings_of(0.9_dp, 0.65_dp, 60)
      settings%stability = .false.
      call response(paper_train(), settings, reference, error)
      call tests%is_true(reference%complete, 'reference complete: '//reference%ended%text)
      do k = 1, size(harmonics)
         write (name, '(i2)') harmonics(k)
         call response(paper_train(), settings_for(harmonics(k)), branch, error)
         points = 0
         within_3 = 0
         within_6 = 0
         all_within_3 = 0
         do i = 3, branch%points - 1
            true = true_error(settings, reference, branch, i)
            ! Shooting is as exact as `floor`, no better.
            ratio = max(min(true, fold_distance(reference, branch, i)), floor)/max(branch%error_estimate(i), floor)
            if (ratio > 1/3.0_dp .and. ratio < 3) all_within_3 = all_within_3 + 1
            if (branch%estimate_doubtful(i)) cycle
            ratio = max(true, floor)/max(branch%error_estimate(i), floor)
            points = points + 1
            if (ratio > 1/3.0_dp .and. ratio < 3) within_3 = within_3 + 1
            if (ratio > 1/6.0_dp .and. ratio < 6) within_6 = within_6 + 1
         end do
         call tests%is_true(points > 20, 'R = '//name//': points that are not doubtful')
         call tests%is_true(within_3 >= 0.95_dp*points, 'R = '//name//': a factor of 3 for 95 %')
         call tests%is_true(within_6 == points, 'R = '//name//': a factor of 6 for all')
         call tests%is_true(all_within_3 >= 0.95_dp*(branch%points - 3), &
                            'R = '//name//': a factor of 3 for 95 %, doubtful ones too')
         call tests%is_true(count(branch%estimate_doubtful) <= 0.15_dp*branch%points, 'R = '//name//': few are doubtful')
      end do
   end subroutine against_shooting

   !> Coefficients from samples, with so many harmonics that the sampling is nearly all of the error: teeth part at both meshes.
   subroutine of_sampled_coefficients(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: samples(2) = [1024, 4096]
      type(branch_type) :: branch
      type(error_type), allocatable :: error
      type(response_settings_type) :: settings
      real(dp) :: ratio
      integer :: i, k, points, within_3
      character(4) :: name

      do k = 1, size(samples)
         write (name, '(i0)') samples(k)
         settings = settings_of(0.86_dp, 0.98_dp, 48)
         settings%coefficients = 'sampled'
         settings%samples = samples(k)
         settings%stability = .false.
         call response(paper_train(), settings, branch, error)
         points = 0
         within_3 = 0
         do i = 2, branch%points
            if (branch%estimate_doubtful(i)) cycle
            points = points + 1
            ratio = true_error(settings, branch, branch, i)/branch%error_estimate(i)
            if (ratio > 1/3.0_dp .and. ratio < 3) within_3 = within_3 + 1
         end do
         call tests%is_true(points >= 3, name//' samples: points that are not doubtful')
         call tests%is_true(within_3 == points, name//' samples: a factor of 3 for all')
      end do
   end subroutine of_sampled_coefficients

   pure function settings_for(harmonics) result(settings)
      integer, intent(in) :: harmonics
      type(response_settings_type) :: settings

      settings%start = 0.9_dp
      settings%stop = 0.65_dp
      settings%harmonics = harmonics
      settings%stability = .false.
   end function settings_for

   !> Tolerance 1e-8 in, harmonics out: where the teeth stay in contact a dozen do, where they separate it takes far more.
   subroutine by_tolerance(tests)
      class(tests_type), intent(inout) :: tests
      type(response_settings_type) :: settings
      type(branch_type) :: branch
      type(error_type), allocatable :: error
      integer :: i

      settings = settings_of(1.3_dp, 1.24_dp, 0)
      settings%tolerance = 1e-8_dp
      settings%stability = .false.
      call response(paper_train(), settings, branch, error)
      call tests%is_true(branch%complete .and. index(branch%ended%text, 'miss') == 0, 'tolerance 1e-8: '//branch%ended%text)
      call tests%is_true(all(branch%error_estimate <= 1e-8_dp), 'tolerance 1e-8: every estimate is within it')
      do i = 1, branch%points, max(1, branch%points/5)
         call tests%is_close(true_error(settings, branch, branch, i), 0.0_dp, 1e-8_dp, 'tolerance 1e-8: true waveform error')
      end do
      settings = settings_of(0.3_dp, 0.6_dp, 0)
      settings%tolerance = 1e-4_dp
      settings%stability = .false.
      call response(paper_train(), settings, branch, error)
      call tests%is_true(branch%complete, 'tolerance 1e-4: '//branch%ended%text)
      call tests%is_true(minval(branch%point_harmonics) < 12 .and. maxval(branch%point_harmonics) > 18, &
                         'harmonics are raised and lowered along the branch')
   end subroutine by_tolerance

   !> Orders 17 and 23, where harmonics are added between those that are carried already: the branch goes on, and its end is
   !> as near to shooting as it says.
   subroutine hunting_teeth(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(response_settings_type) :: settings
      type(branch_type) :: branch
      type(motion_type) :: exact
      type(error_type), allocatable :: error
      real(dp), allocatable :: difference(:, :)
      integer :: n

      train = paper_train()
      train%meshes%order = [17, 23]
      settings = settings_of(0.02_dp, 0.0205_dp, 0)
      settings%stability = .false.
      call response(train, settings, branch, error)
      call tests%is_true(branch%complete, 'orders 17 and 23: '//branch%ended%text)
      n = branch%points
      exact%frequency_ratio = branch%frequency_ratio(n)
      exact%period = 1
      exact%coefficients = coefficients_of(branch, n)
      call refine(train, exact, error)
      call tests%is_true(.not. allocated(error), 'orders 17 and 23: refined')
      difference = coefficients_of(branch, n)
      difference = exact%coefficients(:size(difference, 1), :) - difference
      call tests%is_true(norm2(difference) < 3*branch%error_estimate(n)*norm2(exact%coefficients(2:, :)), &
                         'orders 17 and 23: shooting within a factor of 3 of the estimate')
   end subroutine hunting_teeth

   !> Distance of point i to the nearest fold of the reference before which its Lambda lies, so that the branch has no motion there.
   pure real(dp) function fold_distance(reference, branch, i)
      type(branch_type), intent(in) :: reference, branch
      integer, intent(in) :: i
      real(dp) :: difference(size(reference%coefficients, 1), branch%meshes)
      integer :: k, n

      fold_distance = huge(1.0_dp)
      do k = 1, size(reference%special_points)
         if (reference%special_points(k)%kind /= 'fold') cycle
         n = reference%special_points(k)%point
         associate (f => reference%frequency_ratio)
            if ((branch%frequency_ratio(i) - f(n))*(f(n - 1) - f(n)) > 0) cycle
         end associate
         difference = -reference%coefficients(:, :, n)
         associate (u => branch%coefficients(:, :, i))
            difference(:size(u, 1), :) = difference(:size(u, 1), :) + u
         end associate
         fold_distance = min(fold_distance, sqrt((2*sum(difference(1, :)**2) + sum(difference(2:, :)**2)) &
                                                 /sum(reference%coefficients(2:, :, n)**2)))
      end do
   end function fold_distance

   !> Relative waveform error of point i of `branch`: the distance to the nearest motion of `reference` at its Lambda, refined.
   real(dp) function true_error(settings, reference, branch, i)
      !> Those of the reference.
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: reference, branch
      integer, intent(in) :: i
      type(motion_type), allocatable :: motions(:)
      type(motion_type) :: exact
      type(error_type), allocatable :: error
      real(dp) :: difference(1 + 2*padded, branch%meshes)
      integer :: k

      true_error = huge(1.0_dp)
      call solutions_at(paper_train(), settings, reference, branch%frequency_ratio(i), motions, error)
      do k = 1, size(motions)
         exact = motions(k)
         deallocate (exact%coefficients)
         allocate (exact%coefficients(1 + 2*padded, branch%meshes), source=0.0_dp)
         exact%coefficients(:size(motions(k)%coefficients, 1), :) = motions(k)%coefficients
         call refine(paper_train(), exact, error)
         if (allocated(error)) cycle
         difference = -exact%coefficients
         difference(:size(branch%coefficients, 1), :) = difference(:size(branch%coefficients, 1), :) &
                                                        + branch%coefficients(:, :, i)
         true_error = min(true_error, sqrt((2*sum(difference(1, :)**2) + sum(difference(2:, :)**2)) &
                                           /sum(exact%coefficients(2:, :)**2)))
      end do
   end function true_error

end module validation_error_estimate
