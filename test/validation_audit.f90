!> The audit: its exact special points against those of a balance of many harmonics, its errors against the corrections of
!> refinement; and that it sees what is wrong with a branch: each kind of mistake is made in one, and must be told as that.
module validation_audit
   use fixtures, only: paper_train, settings_of
   use geartrain, only: audit_branch, audit_text, audit_type, branch_type, dp, error_type, follow_bifurcations, observer_type, &
      refine_branch, response, response_settings_type, train_type
   use geartrain_readings_summary, only: folds
   use omp_lib, only: omp_get_max_threads, omp_set_num_threads
   use testing, only: full, tests_type
   implicit none (type, external)
   private
   public :: audit_tests

   !> Ends the audit after some rows.
   type, extends(observer_type) :: stopper_type
      integer :: rows = 5
   contains
      procedure :: on_step
   end type stopper_type

contains

   subroutine audit_tests(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(error_type), allocatable :: error

      if (tests%runs('figure_3', full)) then
         call response(paper_train(), settings_of(0.4_dp, 0.9_dp, 6), branch, error)
         call a_good_branch_is_confirmed(tests, branch)
         call mistakes_are_seen(tests, branch)
      end if
      if (tests%runs('corrections_count_the_tail')) call corrections_count_the_tail(tests)
      if (tests%runs('other_branches')) call other_branches(tests)
   end subroutine audit_tests

   subroutine a_good_branch_is_confirmed(tests, branch)
      class(tests_type), intent(inout) :: tests
      type(branch_type), intent(in) :: branch
      type(branch_type) :: refined, exact
      type(audit_type) :: audit, other
      type(error_type), allocatable :: error
      type(response_settings_type) :: settings
      character(:), allocatable :: table
      integer :: i, k, threads, before
      real(dp) :: nearest

      before = omp_get_max_threads()
      call audit_branch(paper_train(), branch, 20, 0, audit, error)
      call tests%is_true(audit%ok .and. audit%points == 20 .and. audit%wrong_verdicts == 0, 'nothing is wrong with figure 3')
      call tests%is_true(audit%special_points == 6 .and. audit%confirmed == 6, 'its six folds are confirmed')
      call audit_text(audit, paper_train(), 'Lambda', table)
      ! One of the points is next to the narrow resonance at 0.5822, where the estimate is doubtful.
      call tests%is_true(index(table, new_line('a')//'Errors of 19 of 20 points are as estimated, 1 called &
         &doubtful; stability is wrong at 0 points; 6 of 6 special points confirmed; jumps') > 0, 'the line')
      do threads = 1, 2
         call omp_set_num_threads(threads)
         call audit_branch(paper_train(), branch, 20, 0, other, error)
         call tests%is_true(all(abs(other%rows%error - audit%rows%error) <= 0) .and. &
                            all(abs(other%rows%exact_frequency - audit%rows%exact_frequency) <= 0), 'the same bits')
      end do
      call omp_set_num_threads(before)
      call audit_branch(paper_train(), branch, 20, 1, other, error)
      call tests%is_true(any(other%rows(:20)%point /= audit%rows(:20)%point), 'another seed draws other points')
      ! Two ways to the same figure: shooting in one section and a difference of coefficients.
      refined = branch
      call refine_branch(paper_train(), refined, error)
      do i = 1, 20
         associate (row => audit%rows(i))
            if (row%finding /= '' .or. refined%correction(row%point) < 0) cycle
            call tests%is_close(row%error, refined%correction(row%point), 1e-9_dp + 1e-6_dp*row%error, 'error as the correction')
         end associate
      end do
      ! The folds of a balance whose waveform is good to 1e-7: their places are good to some 1e-8.
      settings = settings_of(0.4_dp, 0.9_dp, 0)
      settings%tolerance = 1e-7_dp
      call response(paper_train(), settings, exact, error)
      do i = 21, 26
         nearest = huge(nearest)
         do k = 1, size(exact%special_points)
            nearest = min(nearest, abs(exact%special_points(k)%frequency_ratio - audit%rows(i)%exact_frequency))
         end do
         call tests%is_close(nearest, 0.0_dp, 2e-7_dp, 'a fold by shooting, where the balance has it with many harmonics')
      end do
   end subroutine a_good_branch_is_confirmed

   !> Each mistake in a copy of the branch, whole otherwise.
   subroutine mistakes_are_seen(tests, branch)
      class(tests_type), intent(inout) :: tests
      type(branch_type), intent(in) :: branch
      type(branch_type) :: forged
      type(audit_type) :: audit
      type(error_type), allocatable :: error
      type(stopper_type) :: stopper

      forged = branch
      forged%error_estimate = 0.1_dp*branch%error_estimate
      forged%estimate_doubtful = .false.
      call audit_branch(paper_train(), forged, 8, 0, audit, error)
      call tests%is_true(.not. audit%ok .and. audit%as_estimated == 0 .and. count(audit%rows%estimate_wrong) >= 8, &
                         'estimates that are too small by a factor of 10')
      forged%estimate_doubtful = .true.
      call audit_branch(paper_train(), forged, 8, 0, audit, error)
      call tests%is_true(audit%ok .and. audit%doubtful == 8, 'the same, where the branch calls them doubtful')
      forged = branch
      forged%stable = .not. branch%stable
      forged%undecided = .false.
      call audit_branch(paper_train(), forged, 8, 0, audit, error)
      call tests%is_true(.not. audit%ok .and. count(audit%rows(:8)%verdict_wrong) >= 7, 'every verdict wrong')
      forged%undecided = .true.
      call audit_branch(paper_train(), forged, 8, 0, audit, error)
      call tests%is_true(audit%ok, 'the same, where the branch calls them undecided')
      forged = branch
      forged%coefficients = 1.5_dp*branch%coefficients
      forged%special_points = branch%special_points(:0)
      call audit_branch(paper_train(), forged, 8, 0, audit, error)
      call tests%is_true(audit%as_estimated == 0 .and. all(audit%rows(:8)%estimate_wrong .or. audit%rows(:8)%doubtful), &
                         'points that are no motions')
      forged = branch
      forged%special_points(1)%kind = 'neimark-sacker'
      forged%special_points(2)%kind = 'period doubling'
      call audit_branch(paper_train(), forged, 0, 0, audit, error)
      call tests%is_true(count(audit%rows%verdict_wrong) == 2 .and. audit%confirmed == size(branch%special_points) - 2, &
                         'changes of stability that are none')
      forged = branch
      forged%special_points = [branch%special_points, branch%special_points(1)]
      forged%special_points(size(forged%special_points))%frequency_ratio = branch%special_points(1)%frequency_ratio + 1e-3_dp
      call audit_branch(paper_train(), forged, 0, 0, audit, error)
      call tests%is_true(count(audit%rows%verdict_wrong) == 1, 'two folds where there is one')
      call audit_branch(paper_train(), branch, -1, 0, audit, error)
      call tests%is_true(allocated(error), 'a negative number of points')
      call audit_branch(paper_train(), branch, 20, 0, audit, error, stopper)
      call tests%is_true(audit%cancelled .and. .not. audit%ok .and. size(audit%rows) < 20, 'stopped by the observer')
   end subroutine mistakes_are_seen

   !> From 17 harmonics on most of the error is in those that the balance leaves out.
   subroutine corrections_count_the_tail(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch, refined
      type(error_type), allocatable :: error
      logical, allocatable :: counts(:)
      real(dp), allocatable :: ratio(:)

      call response(paper_train(), settings_of(0.8_dp, 1.0_dp, 24), branch, error)
      refined = branch
      call refine_branch(paper_train(), refined, error)
      counts = refined%correction > 1e-8_dp .and. .not. branch%estimate_doubtful
      ratio = pack(refined%correction/branch%error_estimate, counts)
      call tests%is_true(size(ratio) > 5, 'corrections to compare')
      call tests%is_true(all(ratio > 1/3.0_dp .and. ratio < 3), 'corrections at R = 24 are as estimated, within a factor of 3')
   end subroutine corrections_count_the_tail

   !> A linear train, branches of twice the period with their vertical segments, a refined branch, one without stability.
   subroutine other_branches(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(branch_type), allocatable :: branches(:)
      type(train_type) :: train
      type(response_settings_type) :: settings
      type(audit_type) :: audit
      type(error_type), allocatable :: error
      integer :: i

      train = paper_train()
      train%meshes%half_backlash = 0
      call response(train, settings_of(0.2_dp, 2.0_dp, 6), branch, error)
      call audit_branch(train, branch, 10*branch%points, 0, audit, error)
      call tests%is_true(audit%ok .and. audit%points == branch%points - size(folds(branch)), &
                         'a linear train, no more points than there are')
      settings = settings_of(1.6_dp, 2.2_dp, 6)
      settings%period_doublings = 1
      call response(paper_train(), settings, branch, error)
      call follow_bifurcations(paper_train(), settings, branch, branches, error)
      call tests%is_true(size(branches) > 0, 'branches of twice the period')
      do i = 1, size(branches)
         call audit_branch(paper_train(), branches(i), 12, 0, audit, error)
         call tests%is_true(audit%as_estimated >= 11 .and. audit%as_estimated + audit%doubtful == 12 .and. &
                            .not. any(audit%rows(:12)%verdict_wrong), 'points of such a branch')
      end do
      call refine_branch(paper_train(), branch, error)
      call audit_branch(paper_train(), branch, 20, 0, audit, error)
      call tests%is_true(audit%ok, 'a refined branch')
      settings = settings_of(0.4_dp, 0.9_dp, 6)
      settings%stability = .false.
      call response(paper_train(), settings, branch, error)
      call audit_branch(paper_train(), branch, 20, 0, audit, error)
      call tests%is_true(audit%ok .and. audit%confirmed == 6 .and. all(audit%rows%verdict == ''), 'without stability')
   end subroutine other_branches

   subroutine on_step(self, analysis, done, frequency_ratio, keep_going)
      class(stopper_type), intent(inout) :: self
      character(*), intent(in) :: analysis
      integer, intent(in) :: done
      real(dp), intent(in) :: frequency_ratio
      logical, intent(inout) :: keep_going

      keep_going = done < self%rows
   end subroutine on_step

end module validation_audit
