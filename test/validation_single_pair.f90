!> The single gear pair x'' + 2 zeta x' + (1 + kappa cos Lambda t) g(x) = f, b = 1.
module validation_single_pair
   use, intrinsic :: omp_lib, only: omp_get_max_threads, omp_set_num_threads
   use fixtures, only: closest, linear_pair, settings_of, single_pair
   use geartrain, only: attractors, attractors_settings_type, attractors_type, branch_type, dp, error_type, motion_type, &
                        refine, response, response_settings_type, solutions_at, train_type
   use geartrain_base_kinds, only: pi
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: single_pair_tests

   !> Coexisting period-1 motions at zeta 0.05, kappa 0.3, f 0.4, Lambda 0.8: true AC rms, time-integrated.
   real(dp), parameter :: small = 0.251372945_dp, large = 0.716758700_dp

contains

   subroutine single_pair_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('coexisting')) call coexisting(tests)
      if (tests%runs('found_from_random_starts')) call found_from_random_starts(tests)
      if (tests%runs('linear_constant')) call linear_constant(tests)
   end subroutine single_pair_tests

   !> Both by continuation and shooting.
   subroutine coexisting(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: branch
      type(response_settings_type) :: settings
      type(motion_type), allocatable :: motions(:)
      type(error_type), allocatable :: error
      real(dp), parameter :: expected(2) = [small, large]*sqrt(2.0_dp)
      integer :: i, k

      train = single_pair(0.05_dp, 0.3_dp, 0.4_dp)
      settings = settings_of(1.6_dp, 0.6_dp, 16)
      call response(train, settings, branch, error)
      call tests%is_true(branch%complete, 'the curve of the single pair: '//branch%ended%text)
      call solutions_at(train, settings, branch, 0.8_dp, motions, error)
      do i = 1, 2
         k = closest(motions, expected(i))
         call tests%is_true(k > 0, 'solutions at 0.8')
         if (k == 0) return
         call tests%is_true(motions(k)%stable, 'stable at 0.8')
         call tests%is_close(motions(k)%rms(1), expected(i), 1e-4_dp, 'balance at 0.8')
         call refine(train, motions(k), error)
         call tests%is_true(.not. allocated(error), 'shooting converges')
         call tests%is_close(motions(k)%rms(1), expected(i), 2e-9_dp, 'shooting at 0.8')
      end do
   end subroutine coexisting

   subroutine found_from_random_starts(tests)
      class(tests_type), intent(inout) :: tests
      type(attractors_type) :: found, again
      type(attractors_settings_type) :: settings
      type(error_type), allocatable :: error
      integer :: i, threads

      settings%frequency = 0.8_dp
      settings%starts = 40
      settings%random_seed = 1
      threads = omp_get_max_threads()
      call omp_set_num_threads(1)
      call attractors(single_pair(0.05_dp, 0.3_dp, 0.4_dp), settings, found, error)
      call omp_set_num_threads(3)
      call attractors(single_pair(0.05_dp, 0.3_dp, 0.4_dp), settings, again, error)
      call omp_set_num_threads(threads)
      call tests%is_true(found%complete .and. found%starts == 40, 'all starts are done')
      call tests%is_close(found%unsettled, 0.0_dp, 0.0_dp, 'every start settles')
      call tests%is_close(sum(found%motions%share), 1.0_dp, 1e-12_dp, 'the shares sum to 1')
      call tests%is_true(size(again%motions) == size(found%motions), 'as many motions with three threads as with one')
      do i = 1, min(size(found%motions), size(again%motions))
         associate (one => found%motions(i), three => again%motions(i))
            call tests%is_true(all(abs(three%coefficients - one%coefficients) <= 0) .and. all(abs(three%state - one%state) <= 0) &
                               .and. abs(three%share - one%share) <= 0, 'the same bits with any number of threads')
         end associate
      end do
      i = closest(found%motions, small*sqrt(2.0_dp))
      call tests%is_close(found%motions(i)%rms(1), small*sqrt(2.0_dp), 3e-9_dp, 'the small motion is an attractor')
      i = closest(found%motions, large*sqrt(2.0_dp))
      call tests%is_close(found%motions(i)%rms(1), large*sqrt(2.0_dp), 3e-9_dp, 'the large motion is an attractor')

      ! Nothing settles within a single period of the fundamental: that is told, not dropped.
      settings%max_periods = 1
      call attractors(single_pair(0.05_dp, 0.3_dp, 0.4_dp), settings, found, error)
      call tests%is_true(size(found%motions) == 0 .and. found%complete, 'one period of the fundamental is too short')
      call tests%is_close(found%unsettled, 1.0_dp, 0.0_dp, 'no start settles in one period of the fundamental')
      settings%starts = 0
      call attractors(single_pair(0.05_dp, 0.3_dp, 0.4_dp), settings, found, error)
      call tests%is_true(allocated(error), 'no starts: an error')
      if (allocated(error)) call tests%is_text(error%message, '&attractors: starts = 0: must be >= 1 and <= 1.0e6', 'message')
   end subroutine found_from_random_starts

   !> Constant stiffness, no backlash, torque harmonic: every mesh is condensed away; the closed form of an oscillator.
   subroutine linear_constant(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: branch
      type(error_type), allocatable :: error
      complex(dp) :: amplitude
      integer :: n

      train = linear_pair(0.4_dp)
      call response(train, settings_of(0.5_dp, 1.5_dp, 3), branch, error)
      n = branch%points
      ! The torque drives gear 1 (I = 2): x'' + 0.2 x' + x = 0.5 cos(Lambda t).
      amplitude = 0.5_dp/cmplx(1 - 1.5_dp**2, 0.2_dp*1.5_dp, dp)
      call tests%is_true(branch%complete, 'a train with nothing to iterate: '//branch%ended%text)
      call tests%is_close(branch%coefficients(2, 1, n), amplitude%re, 1e-13_dp, 'cos part')
      call tests%is_close(branch%coefficients(3, 1, n), -amplitude%im, 1e-13_dp, 'sin part')
      ! Multipliers of a damped oscillator: exp(T (-zeta +- i sqrt(1 - zeta^2))).
      call tests%is_close(abs(branch%multipliers(1, n)), exp(-0.1_dp*2*pi/1.5_dp), 1e-10_dp, 'multiplier of the oscillator')
   end subroutine linear_constant

end module validation_single_pair
