!> The paper's train, Table 1: figures measured independently by time integration (all digits given hold).
module validation_paper_train
   use fixtures, only: closest, paper_train, settings_of
   use geartrain, only: branch_type, dp, error_type, integrate, integration_settings_type, modes_type, motion_type, &
                        natural_modes, refine, response, response_settings_type, solutions_at, train_type
   use geartrain_trace_points, only: motion_of
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: paper_train_tests

   real(dp), parameter :: rms_04(2) = [0.14980128_dp, 0.18767890_dp], rms_09(2) = [0.41003761_dp, 0.71440160_dp]

contains

   subroutine paper_train_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('frequencies')) call frequencies(tests)
      if (tests%runs('response_curve')) call response_curve(tests)
      if (tests%runs('options_agree')) call options_agree(tests)
      if (tests%runs('convergence')) call convergence(tests)
      if (tests%runs('integrated')) call integrated(tests)
      if (tests%runs('period_two')) call period_two(tests)
      if (tests%runs('without_backlash')) call without_backlash(tests)
      if (tests%runs('seed_at_fold')) call seed_at_fold(tests)
   end subroutine paper_train_tests

   !> Independently computed natural frequencies, six decimals.
   subroutine frequencies(tests)
      class(tests_type), intent(inout) :: tests
      type(modes_type) :: modes
      type(error_type), allocatable :: error
      real(dp), parameter :: expected(5) = [0.957059_dp, 1.866211_dp, 6.680664_dp, 6.681010_dp, 15.920627_dp]
      integer :: i

      call natural_modes(paper_train(), modes, error)
      call tests%is_true(.not. allocated(error), 'modes without error')
      do i = 1, 5
         call tests%is_close(modes%natural_frequency(i), expected(i), 6e-7_dp, 'natural frequency')
      end do
   end subroutine frequencies

   !> The whole curve, R = 6: rms at 0.4 (exact: only two harmonics matter) and 0.9 (truncated: 1e-3), Floquet multipliers,
   !> the eight folds of the curve and the two period doublings, the same from either end.
   subroutine response_curve(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: up, down
      type(error_type), allocatable :: error
      type(motion_type), allocatable :: motions(:)
      type(response_settings_type) :: settings
      ! The eight folds of the curve, found independently of this library, four digits.
      real(dp), parameter :: folds(8) = [0.4621_dp, 0.4586_dp, 0.7923_dp, 0.5657_dp, 0.7312_dp, 0.6161_dp, 1.6646_dp, &
                                         1.5483_dp]
      ! Where the period-1 motion loses and regains stability, found independently, three decimals.
      real(dp), parameter :: doublings(2) = [1.749_dp, 2.044_dp]
      integer :: i, n

      settings = settings_of(0.2_dp, 2.6_dp, 6)
      call response(paper_train(), settings, up, error)
      call tests%is_true(.not. allocated(error) .and. up%complete, 'curve reaches 2.6: '//up%ended%text)
      n = 0
      do i = 1, size(up%special_points)
         if (up%special_points(i)%kind /= 'fold') cycle
         n = n + 1
         ! R = 6 places the folds of separated motions to about 2e-3.
         if (n <= 8) call tests%is_close(up%special_points(i)%frequency_ratio, folds(n), 2e-3_dp, 'fold')
      end do
      call tests%is_true(n == 8, 'eight folds')
      n = 0
      do i = 1, size(up%special_points)
         if (up%special_points(i)%kind /= 'period doubling') cycle
         n = n + 1
         if (n <= 2) call tests%is_close(up%special_points(i)%frequency_ratio, doublings(n), 1e-3_dp, 'period doubling')
      end do
      call tests%is_true(n == 2, 'two period doublings')

      call at(0.4_dp, up, rms_04(1))
      call tests%is_true(size(motions) == 1, 'one solution at 0.4')
      call tests%is_close(motions(1)%rms(1), rms_04(1), 1e-8_dp, 'rms of mesh 1 at 0.4')
      call tests%is_close(motions(1)%rms(2), rms_04(2), 1e-8_dp, 'rms of mesh 2 at 0.4')
      call tests%is_close(abs(motions(1)%multipliers(1)), 0.6827_dp, 6e-5_dp, 'multiplier at 0.4')
      call at(0.9_dp, up, rms_09(1))
      call tests%is_true(size(motions) == 1, 'one solution at 0.9')
      call tests%is_close(motions(1)%rms(1), rms_09(1), 1e-3_dp, 'rms of mesh 1 at 0.9')
      call tests%is_close(motions(1)%rms(2), rms_09(2), 1e-3_dp, 'rms of mesh 2 at 0.9')
      call tests%is_close(abs(motions(1)%multipliers(1)), 0.8286_dp, 1e-4_dp, 'multiplier at 0.9')
      call at(1.5_dp, up, 0.0_dp)
      call tests%is_close(abs(motions(closest(motions, 0.0_dp))%multipliers(1)), 0.9032_dp, 6e-5_dp, 'multiplier at 1.5')
      call at(0.7_dp, up, 0.0_dp)
      call tests%is_true(mod(size(motions), 2) == 1 .and. size(motions) > 1, 'an odd number of solutions at 0.7')

      settings = settings_of(2.6_dp, 0.2_dp, 6)
      call response(paper_train(), settings, down, error)
      call tests%is_true(down%complete, 'curve reaches 0.2 from 2.6')
      call tests%is_close(down%rms(2, down%points), up%rms(2, 1), 1e-9_dp, 'both directions end in the same motion')
      call tests%is_close(maxval(down%rms), maxval(up%rms), 1e-3_dp, 'both directions have the same peak')

   contains

      subroutine at(frequency_ratio, branch, unused)
         real(dp), intent(in) :: frequency_ratio, unused
         type(branch_type), intent(in) :: branch

         call solutions_at(paper_train(), settings, branch, frequency_ratio, motions, error)
         call tests%is_true(size(motions) > 0 .and. unused >= 0, 'the branch has solutions there')
      end subroutine at

   end subroutine response_curve

   !> The paper's control by switching the prescribed unknown, and its sampled DFT, give the same motion at 0.9 on a piece of
   !> curve without folds; sampling with 1024 points costs accuracy of order Q^-2.
   subroutine options_agree(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: exact, local, sampled
      type(error_type), allocatable :: error
      type(response_settings_type) :: settings

      settings = settings_of(1.3_dp, 0.9_dp, 6)
      call response(paper_train(), settings, exact, error)
      settings%control = 'local'
      call response(paper_train(), settings, local, error)
      call tests%is_true(local%complete, 'local control arrives')
      call tests%is_close(local%rms(2, local%points), exact%rms(2, exact%points), 1e-9_dp, 'local control: same motion')
      settings%control = 'arclength'
      settings%coefficients = 'sampled'
      settings%samples = 1024
      call response(paper_train(), settings, sampled, error)
      call tests%is_true(sampled%complete, 'sampled coefficients arrive')
      call tests%is_close(sampled%rms(2, sampled%points), exact%rms(2, exact%points), 1e-4_dp, 'sampled: same motion')
      call tests%is_true(abs(sampled%rms(2, sampled%points) - exact%rms(2, exact%points)) > 1e-12_dp, &
                         'sampled coefficients are not the exact ones')
   end subroutine options_agree

   !> rms at 0.9 converges to the time-integrated value: about 1e-3 at R = 6, 1e-6 at R = 24; the waveform error falls as R^-3
   !> (transversal contact), the rms error faster.
   subroutine convergence(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: harmonics(4) = [6, 12, 24, 48]
      real(dp) :: rms_error(4), waveform_error(4)
      type(branch_type) :: branch
      type(motion_type) :: motion, reference
      type(error_type), allocatable :: error
      integer :: i, r, n
      real(dp) :: order

      do i = 4, 1, -1
         call response(paper_train(), settings_of(1.3_dp, 0.9_dp, harmonics(i)), branch, error)
         n = branch%points
         if (i == 4) then
            motion%frequency_ratio = 0.9_dp
            ! Padded with zeros, so that the reference holds the tail that the balance cuts off.
            allocate (motion%coefficients(1 + 2*200, 2), source=0.0_dp)
            motion%coefficients(:2*harmonics(i) + 1, :) = branch%coefficients(:, :, n)
            call refine(paper_train(), motion, error)
            reference = motion
            call tests%is_true(.not. allocated(error), 'shooting converges')
            call tests%is_close(reference%rms(1), rms_09(1), 6e-9_dp, 'shooting, rms of mesh 1')
            call tests%is_close(reference%rms(2), rms_09(2), 6e-9_dp, 'shooting, rms of mesh 2')
         end if
         rms_error(i) = maxval(abs(branch%rms(:, n) - reference%rms))
         r = min(size(branch%coefficients, 1), size(reference%coefficients, 1))
         waveform_error(i) = sqrt(sum((branch%coefficients(:r, :, n) - reference%coefficients(:r, :))**2) &
                                  + sum(reference%coefficients(r + 1:, :)**2))/norm2(reference%coefficients(2:, :))
         call tests%is_close(log(branch%error_estimate(n)/waveform_error(i)), 0.0_dp, log(3.0_dp), &
                             'logarithm of error estimate over true error (a factor of 3)')
      end do
      call tests%is_close(rms_error(1), 0.0_dp, 1e-3_dp, 'rms error at R = 6')
      call tests%is_close(rms_error(3), 0.0_dp, 2e-6_dp, 'rms error at R = 24')
      call tests%is_true(rms_error(4) < rms_error(3)/8, 'R = 48 is nearer still')
      order = log(waveform_error(1)/waveform_error(4))/log(8.0_dp)
      call tests%is_true(order > 2.5_dp, 'the waveform converges at least as R^-2.5 on average')
   end subroutine convergence

   !> Time integration by itself, from rest.
   subroutine integrated(tests)
      class(tests_type), intent(inout) :: tests
      type(integration_settings_type) :: settings
      type(motion_type) :: motion, start
      type(error_type), allocatable :: error

      settings%stability = .true.
      call integrate(paper_train(), 0.4_dp, settings, motion, error)
      call tests%is_true(motion%period == 1 .and. motion%stable, 'period 1 at 0.4')
      call tests%is_close(motion%rms(1), rms_04(1), 6e-9_dp, 'integrated rms of mesh 1 at 0.4')
      call tests%is_close(motion%rms(2), rms_04(2), 6e-9_dp, 'integrated rms of mesh 2 at 0.4')
      call integrate(paper_train(), 0.9_dp, settings, motion, error)
      call tests%is_true(motion%period == 1, 'period 1 at 0.9')
      call tests%is_close(motion%rms(1), rms_09(1), 6e-9_dp, 'integrated rms of mesh 1 at 0.9')
      call tests%is_close(motion%rms(2), rms_09(2), 6e-9_dp, 'integrated rms of mesh 2 at 0.9')
      call tests%is_close(abs(motion%multipliers(1)), 0.8286_dp, 6e-5_dp, 'multiplier of the integrated motion at 0.9')
      ! From nothing at all: every displacement and velocity zero, in the middle of the gap.
      start%state = 0*motion%state
      call integrate(paper_train(), 0.9_dp, settings, motion, error, start=start)
      call tests%is_close(motion%rms(2), rms_09(2), 6e-9_dp, 'integrated from a zero state')
   end subroutine integrated

   !> Period 2 at 1.92 by integration, shooting and balance.
   subroutine period_two(tests)
      class(tests_type), intent(inout) :: tests
      real(dp), parameter :: expected(2) = [0.45639898_dp, 0.54946446_dp]
      type(integration_settings_type) :: integration
      type(response_settings_type) :: settings
      type(motion_type) :: motion
      type(motion_type), allocatable :: motions(:)
      type(branch_type) :: branch
      type(error_type), allocatable :: error
      integer :: i

      call integrate(paper_train(), 1.92_dp, integration, motion, error)
      call tests%is_true(motion%period == 2, 'period 2 at 1.92')
      call tests%is_close(motion%rms(1), expected(1), 6e-9_dp, 'integrated rms of mesh 1 at 1.92')
      call tests%is_close(motion%rms(2), expected(2), 6e-9_dp, 'integrated rms of mesh 2 at 1.92')
      settings = settings_of(1.9_dp, 1.95_dp, 24, 2)
      call response(paper_train(), settings, branch, error, seed=motion)
      call tests%is_true(branch%points > 2, 'balance from the integrated motion: '//branch%ended%text)
      call solutions_at(paper_train(), settings, branch, 1.92_dp, motions, error)
      i = closest(motions, expected(1))
      call tests%is_true(i > 0, 'period 2 on the branch at 1.92')
      if (i == 0) return
      call tests%is_true(motions(i)%stable, 'stable over two periods of the fundamental')
      ! 24 harmonics of Lambda/2 are 12 of Lambda: about 1e-5.
      call tests%is_close(motions(i)%rms(1), expected(1), 1e-4_dp, 'balance, rms of mesh 1 at 1.92')
      call tests%is_close(motions(i)%rms(2), expected(2), 1e-4_dp, 'balance, rms of mesh 2 at 1.92')
      call refine(paper_train(), motions(i), error)
      call tests%is_close(motions(i)%rms(2), expected(2), 6e-9_dp, 'shooting from the balance, rms of mesh 2 at 1.92')
   end subroutine period_two

   !> A seed at a fold in a range that ends before the point that the response would begin with beside it: what is told of the
   !> seed itself is that of the motion.
   subroutine seed_at_fold(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch, near
      type(motion_type) :: motion
      type(error_type), allocatable :: error
      integer :: folds, i, k, p

      call response(paper_train(), settings_of(0.5_dp, 0.85_dp, 12), branch, error)
      folds = 0
      do i = 1, size(branch%special_points)
         if (branch%special_points(i)%kind /= 'fold') cycle
         p = branch%special_points(i)%point
         motion = motion_of(branch, p)
         call response(paper_train(), settings_of((1 - 1e-9_dp)*motion%frequency_ratio, (1 + 1e-9_dp)*motion%frequency_ratio, &
                                                  branch%point_harmonics(p)), near, error, seed=motion)
         k = 0
         if (near%points > 0) k = minloc(abs(near%rms(1, :near%points) - branch%rms(1, p)), 1)
         call tests%is_true(k > 0, 'a response from the fold: '//near%ended%text)
         if (k == 0) cycle
         folds = folds + 1
         ! At the fold Lambda tells the place along the branch to the root of its rounding, 1e-8.
         call tests%is_close(near%rms(1, k), branch%rms(1, p), 1e-7_dp, 'rms at the fold')
         call tests%is_close(maxval(abs(near%mesh_load(:, k)%separation - branch%mesh_load(:, p)%separation)), 0.0_dp, 1e-7_dp, &
                             'separation at the fold')
         call tests%is_close(abs(near%multipliers(1, k)), abs(branch%multipliers(1, p)), 1e-6_dp, 'multiplier at the fold')
      end do
      call tests%is_true(folds > 1, 'folds of figure 3')
   end subroutine seed_at_fold

   subroutine without_backlash(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: branch
      type(motion_type) :: motion
      type(integration_settings_type) :: integration
      type(error_type), allocatable :: error

      train = paper_train()
      train%meshes%half_backlash = 0
      call response(train, settings_of(1.3_dp, 0.9_dp, 16), branch, error)
      call tests%is_close(branch%rms(1, branch%points), 0.50993678_dp, 6e-9_dp, 'linear, rms of mesh 1 at 0.9')
      call tests%is_close(branch%rms(2, branch%points), 1.40266149_dp, 6e-9_dp, 'linear, rms of mesh 2 at 0.9')
      call integrate(train, 0.9_dp, integration, motion, error)
      call tests%is_close(motion%rms(2), 1.40266149_dp, 1e-8_dp, 'linear, integrated rms of mesh 2 at 0.9')
   end subroutine without_backlash

end module validation_paper_train
