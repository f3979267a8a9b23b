!> Figures 6 to 11: the whole curve, whichever end one starts from.
!>
!> A curve that runs from end to end has an odd number of solutions at every frequency. So has one that leaves by the amplitude
!> limit and comes back from beyond it, save between the frequencies at which it does.
module validation_figures
   use fixtures, only: paper_train, rectangular, settings_of
   use geartrain, only: branch_type, dp, error_type, motion_type, response, response_settings_type, solutions_at, train_type
   use geartrain_readings_summary, only: folds
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: figures_tests

contains

   subroutine figures_tests(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train

      if (tests%runs('within_a_resonance')) then
         call within_a_resonance(tests, paper_train(), 1.101_dp, 0.751_dp)
         call within_a_resonance(tests, paper_train(), 1.954_dp, 1.604_dp)
      end if
      if (tests%runs('ends_beyond_the_limit')) call ends_beyond_the_limit(tests)
      if (tests%runs('figure_6')) then
         train = paper_train()
         call both_ends(tests, train, 6, 'figure 6, 150 N m')
         train%input_torque = 100
         call both_ends(tests, train, 6, 'figure 6, 100 N m')
         train%input_torque = 50
         call both_ends(tests, train, 6, 'figure 6, 50 N m')
      end if
      if (tests%runs('figure_7')) then
         call both_ends(tests, paper_train(0.42_dp), 6, 'figure 7, kappa 0.42')
         call both_ends(tests, paper_train(0.2_dp), 6, 'figure 7, kappa 0.2')
         call both_ends(tests, paper_train(0.1_dp), 6, 'figure 7, kappa 0.1')
      end if
      if (tests%runs('figure_8')) then
         call both_ends(tests, rectangular(-0.085_dp), 6, 'figure 8 as printed')
         call both_ends(tests, rectangular(0.084_dp), 6, 'figure 8, rectangular wave')
      end if
      if (tests%runs('figure_9')) then
         train = paper_train()
         train%meshes%damping_ratio = 0.03_dp
         call both_ends(tests, train, 6, 'figure 9, zeta 0.03')
         train%meshes%damping_ratio = 0.01_dp
         call both_ends(tests, train, 6, 'figure 9, zeta 0.01')
         call through_infinity(tests, train, 4, 'figure 9, zeta 0.01')
      end if
      if (tests%runs('figure_10')) then
         train = paper_train()
         train%meshes(2)%order = 2
         call both_ends(tests, train, 6, 'figure 10')
         call through_infinity(tests, train, 2, 'figure 10')
      end if
      if (tests%runs('figure_11')) then
         train = paper_train()
         train%meshes%order = [3, 2]
         call both_ends(tests, train, 6, 'figure 11')
      end if
   end subroutine figures_tests

   !> The same folds, the same solutions and an odd number of them.
   subroutine both_ends(tests, train, harmonics, name)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      integer, intent(in) :: harmonics
      character(*), intent(in) :: name
      real(dp), parameter :: frequency_ratio(7) = [0.301_dp, 0.463_dp, 0.613_dp, 0.727_dp, 0.787_dp, 1.603_dp, 2.311_dp]
      type(branch_type) :: up, down
      type(error_type), allocatable :: error
      type(motion_type), allocatable :: from_below(:), from_above(:)
      real(dp), allocatable :: folds_up(:), folds_down(:)
      integer :: i, k

      call response(train, unjudged(0.2_dp, 2.6_dp, harmonics), up, error)
      call response(train, unjudged(2.6_dp, 0.2_dp, harmonics), down, error)
      call tests%is_true(up%complete .and. down%complete, name//': complete from either end')
      folds_up = folds(up)
      folds_down = folds(down)
      call tests%is_true(size(folds_up) == size(folds_down), name//': as many folds from either end')
      if (size(folds_up) == size(folds_down)) &
         call tests%is_close(maxval(abs(folds_up - folds_down)), 0.0_dp, 1e-7_dp, name//': the same folds')
      do i = 1, size(frequency_ratio)
         call solutions_at(train, unjudged(0.2_dp, 2.6_dp, harmonics), up, frequency_ratio(i), from_below, error)
         call solutions_at(train, unjudged(2.6_dp, 0.2_dp, harmonics), down, frequency_ratio(i), from_above, error)
         call tests%is_true(size(from_below) == size(from_above), name//': as many solutions from either end')
         call tests%is_true(mod(size(from_below), 2) == 1, name//': an odd number of solutions')
         do k = 1, size(from_below)
            call tests%is_true(nearest_motion(from_below(k), from_above) < 1e-7_dp, name//': the same solutions')
         end do
      end do
   end subroutine both_ends

   !> A range that ends between two folds: the curve that passes them is not the one from the other end. At its end, too, there are
   !> as many motions as on the whole curve.
   subroutine within_a_resonance(tests, train, high, low)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      real(dp), intent(in) :: high, low
      type(branch_type) :: whole, branch
      type(error_type), allocatable :: error
      type(motion_type), allocatable :: all(:), some(:)
      real(dp) :: frequency_ratio
      integer :: direction, i, k

      call response(train, unjudged(0.2_dp, 2.6_dp, 6), whole, error)
      do direction = 1, 2
         if (direction == 1) call response(train, unjudged(high, low, 6), branch, error)
         if (direction == 2) call response(train, unjudged(low, high, 6), branch, error)
         call tests%is_true(branch%complete, 'range that ends within a resonance: complete')
         do i = 0, 4
            frequency_ratio = low + 0.25_dp*i*(high - low)
            call solutions_at(train, unjudged(0.2_dp, 2.6_dp, 6), whole, frequency_ratio, all, error)
            call solutions_at(train, unjudged(high, low, 6), branch, frequency_ratio, some, error)
            call tests%is_true(size(some) == size(all), 'range that ends within a resonance: as many solutions')
            do k = 1, size(all)
               call tests%is_true(nearest_motion(all(k), some) < 1e-7_dp, 'range that ends within a resonance: the same solutions')
            end do
         end do
      end do
   end subroutine within_a_resonance

   !> A linear train has one motion at each frequency, also where the range ends beyond the amplitude limit.
   subroutine ends_beyond_the_limit(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: linear
      type(response_settings_type) :: settings(2)
      type(branch_type) :: branch
      type(error_type), allocatable :: error
      type(motion_type), allocatable :: motions(:)
      integer :: i

      linear = paper_train()
      linear%meshes%half_backlash = 0
      settings = [unjudged(0.2_dp, 0.95_dp, 6), unjudged(0.95_dp, 0.2_dp, 6)]
      settings%amplitude_limit = 2
      do i = 1, 2
         call response(linear, settings(i), branch, error)
         call tests%is_true(branch%complete, 'range that ends beyond the amplitude limit: complete')
         call solutions_at(linear, settings(i), branch, 0.3_dp, motions, error)
         call tests%is_true(size(motions) == 1, 'range that ends beyond the amplitude limit: nothing twice')
      end do
   end subroutine ends_beyond_the_limit

   !> Where a branch goes to infinity and comes back with the other sign, the train without backlash has a multiplier +1: the
   !> edges of a range of parametric instability. `edges` are those that the branch passes, in its order.
   subroutine through_infinity(tests, train, edges, name)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      integer, intent(in) :: edges
      character(*), intent(in) :: name
      real(dp), parameter :: limit = 2e4_dp
      type(train_type) :: linear
      type(response_settings_type) :: settings
      type(branch_type) :: branch
      type(error_type), allocatable :: error
      real(dp), allocatable :: infinite(:)
      real(dp) :: before, now
      integer :: i, found

      linear = train
      linear%meshes%half_backlash = 0
      call response(linear, settings_of(0.8_dp, 2.0_dp, 12), branch, error)
      infinite = [real(dp) ::]
      before = real(product(branch%multipliers(:, 1) - 1), dp)
      do i = 2, branch%points
         now = real(product(branch%multipliers(:, i) - 1), dp)
         if (before*now < 0) infinite = [infinite, (branch%frequency_ratio(i - 1)*now - branch%frequency_ratio(i)* &
                                                    before)/(now - before)]
         before = now
      end do
      settings = unjudged(0.2_dp, 2.6_dp, 12)
      settings%amplitude_limit = limit
      settings%step = 20
      call response(train, settings, branch, error)
      found = 0
      do i = 1, branch%points - 1
         if (branch%segment(i) == branch%segment(i + 1)) cycle
         found = found + 1
         ! What is neglected is of the order of the gap over the limit.
         call tests%is_close(minval(abs(infinite - branch%frequency_ratio(i))), 0.0_dp, 100/limit, &
                             name//': multiplier +1 at infinity')
         call tests%is_close(branch%frequency_ratio(i + 1), branch%frequency_ratio(i), 100/limit, name//': back where it left')
      end do
      call tests%is_true(found == edges, name//': as many passages as edges')
   end subroutine through_infinity

   !> Settings without stability, which these checks do not need.
   function unjudged(start, stop, harmonics) result(settings)
      real(dp), intent(in) :: start, stop
      integer, intent(in) :: harmonics
      type(response_settings_type) :: settings

      settings = settings_of(start, stop, harmonics)
      settings%stability = .false.
   end function unjudged

   !> Distance of a motion to the nearest_motion of several, in coefficients.
   pure real(dp) function nearest_motion(motion, motions)
      type(motion_type), intent(in) :: motion, motions(:)
      integer :: i

      nearest_motion = huge(1.0_dp)
      do i = 1, size(motions)
         nearest_motion = min(nearest_motion, maxval(abs(motion%coefficients - motions(i)%coefficients)))
      end do
   end function nearest_motion

end module validation_figures
