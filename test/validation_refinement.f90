!> Whole branches refined by shooting, against figures measured independently and against the estimates of the balance.
module validation_refinement
   use fixtures, only: paper_train, settings_of
   use geartrain, only: branch_type, dp, error_type, motion_type, refine_branch, response, solutions_at
   use geartrain_readings_summary, only: folds
   use omp_lib, only: omp_get_max_threads, omp_set_num_threads
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: refinement_tests

contains

   subroutine refinement_tests(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch, refined(3)
      type(motion_type), allocatable :: motions(:)
      type(error_type), allocatable :: error
      integer :: before, threads, n

      if (.not. tests%runs('figure_3')) return
      call response(paper_train(), settings_of(0.4_dp, 0.9_dp, 6), branch, error)
      n = branch%points
      before = omp_get_max_threads()
      do threads = 1, 3
         call omp_set_num_threads(threads)
         refined(threads) = branch
         call refine_branch(paper_train(), refined(threads), error)
      end do
      call omp_set_num_threads(before)
      do threads = 2, 3
         call tests%is_true(all(abs(refined(threads)%coefficients - refined(1)%coefficients) <= 0), 'the same bits: coefficients')
         call tests%is_true(all(abs(refined(threads)%multipliers - refined(1)%multipliers) <= 0), 'the same bits: multipliers')
         call tests%is_true(all(abs(refined(threads)%correction - refined(1)%correction) <= 0), 'the same bits: corrections')
      end do
      associate (r => refined(1))
         call tests%is_true(all(abs(r%frequency_ratio - branch%frequency_ratio) <= 0), 'Lambda stays')
         ! rms at 0.4 and 0.9 of time integration by another program: see validation_paper_train.
         call tests%is_close(r%rms(1, 1), 0.14980128_dp, 1e-8_dp, 'mesh 1 at 0.4')
         call tests%is_close(r%rms(2, 1), 0.18767890_dp, 1e-8_dp, 'mesh 2 at 0.4')
         call tests%is_close(r%rms(1, n), 0.41003761_dp, 1e-8_dp, 'mesh 1 at 0.9')
         call tests%is_close(r%rms(2, n), 0.71440160_dp, 1e-8_dp, 'mesh 2 at 0.9')
         call tests%is_true(maxval(r%error_estimate, mask=r%correction >= 0) < 2e-11_dp, 'Newton to 1e-11')
         ! Beside folds, where the balance moves too far for Newton's method.
         call tests%is_true(count(r%correction < 0) <= 4*size(folds(branch)), 'few points are left as they were')
         call tests%is_true(all(pack(r%rms(1, :) - branch%rms(1, :), r%correction < 0) == 0), 'and those are as they were')
         ! The issue's own demand on the estimate, here of all points of the branch: within a factor 6.
         call tests%is_true(count(r%correction > 6*branch%error_estimate .and. r%correction > 1e-8_dp) < n/50, &
                            'corrections are what the estimates said')
         refined(2) = r
         call refine_branch(paper_train(), refined(2), error)
         call tests%is_true(all(abs(refined(2)%coefficients - r%coefficients) <= 0), 'refined points stay as they are')
         call tests%is_true(all(abs(refined(2)%correction - r%correction) <= 0), 'and so do their corrections')
         call solutions_at(paper_train(), settings_of(0.4_dp, 0.9_dp, 6), r, 0.6_dp, motions, error)
         call tests%is_true(size(motions) == 3, 'all solutions are found from refined points as well')
      end associate
   end subroutine refinement_tests

end module validation_refinement
