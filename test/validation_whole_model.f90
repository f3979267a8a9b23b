!> Everything that the model has at once: the balance agrees with time integration as harmonics are added.
module validation_whole_model
   use fixtures, only: long_train, paper_train, settings_of
   use geartrain, only: branch_type, dp, error_type, integrate, integration_settings_type, motion_type, refine, response, &
      response_settings_type
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_error_estimate, only: error_estimate_type
   use geartrain_floquet_monodromy, only: monodromy_type
   use geartrain_network_system, only: build_system, system_type
   use geartrain_trace_stability_assessment, only: assess, assessment_type
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: whole_model_tests

contains

   subroutine whole_model_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('agrees')) then
         call agrees(tests, 2)
         call agrees(tests, 3)
         call agrees(tests, 5)
      end if
      if (tests%runs('harmonics_chosen')) call harmonics_chosen(tests)
      if (tests%runs('liouville')) call liouville(tests)
      if (tests%runs('tolerance_missed')) call tolerance_missed(tests)
   end subroutine whole_model_tests

   !> Rigid shaft, linear mesh, torque harmonics, transmission errors with phases, sin terms, unequal backlash, orders 1 and 2:
   !> integration and balance (R = 12 and 36) at one frequency, with the orbit refined from the balance's coefficients.
   subroutine agrees(tests, shafts)
      class(tests_type), intent(inout) :: tests
      integer, intent(in) :: shafts
      type(integration_settings_type) :: settings
      type(branch_type) :: coarse, fine
      type(motion_type) :: motion, refined
      type(error_type), allocatable :: error
      character(16) :: name
      real(dp) :: coarse_error, fine_error

      write (name, '(i0, a)') shafts, ' shafts: '
      call response(long_train(shafts), settings_of(0.35_dp, 0.4_dp, 12), coarse, error)
      call response(long_train(shafts), settings_of(0.35_dp, 0.4_dp, 36), fine, error)
      call tests%is_true(coarse%complete .and. fine%complete, trim(name)//' branch complete')
      refined%frequency_ratio = 0.4_dp
      refined%coefficients = fine%coefficients(:, :, fine%points)
      call refine(long_train(shafts), refined, error)
      call tests%is_true(.not. allocated(error), trim(name)//' shooting from the balance converges')
      call integrate(long_train(shafts), 0.4_dp, settings, motion, error, start=refined)
      call tests%is_true(motion%period == 1, trim(name)//' period 1')
      call tests%is_close(maxval(abs(refined%rms - motion%rms)), 0.0_dp, 1e-8_dp, trim(name)//' shooting and integration')
      coarse_error = maxval(abs(coarse%rms(:, coarse%points) - refined%rms))
      fine_error = maxval(abs(fine%rms(:, fine%points) - refined%rms))
      call tests%is_close(coarse_error, 0.0_dp, 2e-3_dp, trim(name)//' balance, R = 12')
      call tests%is_close(fine_error, 0.0_dp, 2e-5_dp, trim(name)//' balance, R = 36')
      call tests%is_close(maxval(abs(fine%minimum(:, fine%points) - refined%minimum)), 0.0_dp, 1e-3_dp, &
                          trim(name)//' minimum')
      call tests%is_close(maxval(abs(fine%maximum(:, fine%points) - refined%maximum)), 0.0_dp, 1e-3_dp, &
                          trim(name)//' maximum')
      call tests%is_close(abs(abs(fine%multipliers(1, fine%points)) - abs(refined%multipliers(1))), 0.0_dp, 1e-4_dp, &
                          trim(name)//' largest multiplier')
   end subroutine agrees

   !> harmonics = 0: the estimate stays below the tolerance asked for, and the true error with it.
   subroutine harmonics_chosen(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(motion_type) :: refined
      type(error_type), allocatable :: error
      real(dp), parameter :: tolerance = 1e-4_dp
      integer :: r

      associate (settings => settings_of(1.3_dp, 0.9_dp, 0))
         call response(paper_train(), settings, branch, error)
      end associate
      call tests%is_true(branch%complete, 'harmonics = 0: '//branch%ended%text)
      call tests%is_close(branch%frequency_ratio(1), 1.3_dp, 0.0_dp, 'harmonics = 0: it begins at exactly from')
      ! The default tolerance is 1e-4; the true error may be three times its estimate.
      call tests%is_true(all(branch%error_estimate <= 1e-4_dp), 'harmonics = 0: every point within the tolerance')
      refined%frequency_ratio = 0.9_dp
      refined%coefficients = branch%coefficients(:, :, branch%points)
      call refine(paper_train(), refined, error)
      r = size(branch%coefficients, 1)
      r = min(r, size(refined%coefficients, 1))
      call tests%is_close(norm2(branch%coefficients(:r, :, branch%points) - refined%coefficients(:r, :)) &
                          /norm2(refined%coefficients(2:, :)), 0.0_dp, 3*tolerance, 'harmonics = 0: true waveform error')
   end subroutine harmonics_chosen

   !> Liouville's determinant on separated motions, piece by piece.
   subroutine liouville(tests)
      class(tests_type), intent(inout) :: tests
      type(system_type), target :: system
      type(balance_type) :: balance
      type(monodromy_type) :: monodromy
      type(error_estimate_type) :: estimate
      type(assessment_type) :: assessment
      complex(dp) :: multipliers(10)
      real(dp), allocatable :: u(:, :)

      call build_system(paper_train(), system)
      call balance%setup(system, 6, 1, 0)
      allocate (u(balance%block, balance%unknowns), source=0.0_dp)
      u(1, :) = 0.5_dp
      u(2, :) = 2
      u(5, :) = 0.4_dp
      call monodromy%setup(system)
      call balance%evaluate(u, 0.7_dp)
      call tests%is_true(all(balance%contact%events > 2), 'the motion separates and hits the back flank')
      call monodromy%integrate(balance, 0.7_dp)
      call tests%is_close(monodromy%liouville_defect, 0.0_dp, 1e-7_dp, 'determinant of the monodromy matrix')
      call tests%is_true(monodromy%confirmed, 'it confirms the multipliers')
      call monodromy%multipliers(multipliers)
      call tests%is_true(abs(abs(multipliers(1)) - 1) > 0.1_dp, 'which are far from the unit circle')
      ! The damping that the formula counts is another than that of the matrix, as if all three attempts had failed.
      balance%system%decay = 2*balance%system%decay
      call monodromy%integrate(balance, 0.7_dp)
      call tests%is_true(.not. monodromy%confirmed, 'a determinant that does not hold is told')
      call assess(monodromy, balance, balance, u, 0.7_dp, estimate, multipliers, .false., assessment)
      call tests%is_true(assessment%undecided, 'and the verdict is undecided')
   end subroutine liouville

   !> A tolerance that no number of harmonics can hold, as the waveform's third derivative jumps at contact: the branch is not
   !> complete, and says why.
   subroutine tolerance_missed(tests)
      class(tests_type), intent(inout) :: tests
      type(response_settings_type) :: settings
      type(branch_type) :: branch
      type(error_type), allocatable :: error

      settings = settings_of(0.9_dp, 0.901_dp, 0)
      settings%tolerance = 1e-13_dp
      settings%stability = .false.
      call response(paper_train(), settings, branch, error)
      call tests%is_true(branch%points > 1 .and. all(branch%error_estimate > 1e-13_dp), 'tolerance 1e-13: missed everywhere')
      call tests%is_true(index(branch%ended%text, ' points miss the tolerance') > 0, 'tolerance 1e-13: '//branch%ended%text)
      call tests%is_true(.not. branch%complete, 'tolerance 1e-13: the branch is not complete')
   end subroutine tolerance_missed

end module validation_whole_model
