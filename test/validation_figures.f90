!> Figures 6 to 11: the whole curve, whichever end one starts from.
!>
!> A curve that runs from end to end has an odd number of solutions at every frequency. One that leaves by the amplitude limit
!> (the resonance of the linear train is unbounded there) is traced from both ends: its two parts have together an odd number
!> outside the gap between the frequencies at which they leave, and one less within, where the missing one is beyond the limit.
module validation_figures
   use fixtures, only: paper_train, settings_of
   use geartrain, only: attractors, attractors_settings_type, attractors_type, branch_type, dp, error_type, &
                        motion_type, response, response_settings_type, solutions_at, train_type
   use geartrain_branch_summary, only: jumps
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: figures_tests

contains

   subroutine figures_tests(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train

      call tests%begin('figures 6 to 11')
      train = paper_train()
      call both_ends(tests, train, 6, 'figure 6, 150 N m')
      train%input_torque = 100
      call both_ends(tests, train, 6, 'figure 6, 100 N m')
      train%input_torque = 50
      call both_ends(tests, train, 6, 'figure 6, 50 N m')
      call both_ends(tests, paper_train(0.42_dp), 6, 'figure 7, kappa 0.42')
      call both_ends(tests, paper_train(0.2_dp), 6, 'figure 7, kappa 0.2')
      call both_ends(tests, paper_train(0.1_dp), 6, 'figure 7, kappa 0.1')
      call both_ends(tests, rectangular(-0.085_dp), 6, 'figure 8 as printed')
      call both_ends(tests, rectangular(0.084_dp), 6, 'figure 8, rectangular wave')
      train = paper_train()
      train%meshes%damping_ratio = 0.03_dp
      call both_ends(tests, train, 6, 'figure 9, zeta 0.03')
      train%meshes%damping_ratio = 0.01_dp
      call three_pieces(tests, train)
      train = paper_train()
      train%meshes(2)%order = 2
      call both_ends(tests, train, 6, 'figure 10')
      train%meshes%order = [3, 2]
      call both_ends(tests, train, 6, 'figure 11')
   end subroutine figures_tests

   !> The same folds, the same solutions and an odd number of them.
   subroutine both_ends(tests, train, harmonics, name)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      integer, intent(in) :: harmonics
      character(*), intent(in) :: name
      real(dp), parameter :: frequency(7) = [0.301_dp, 0.463_dp, 0.613_dp, 0.727_dp, 0.787_dp, 1.603_dp, 2.311_dp]
      type(branch_type) :: up, down
      type(error_type), allocatable :: error
      type(motion_type), allocatable :: from_below(:), from_above(:)
      real(dp), allocatable :: folds_up(:), folds_down(:)
      integer :: i, k

      call response(train, unjudged(0.2_dp, 2.6_dp, harmonics), up, error)
      call response(train, unjudged(2.6_dp, 0.2_dp, harmonics), down, error)
      call tests%is_true(up%complete .and. down%complete, name//': complete from either end')
      folds_up = jumps(up)
      folds_down = jumps(down)
      call tests%is_true(size(folds_up) == size(folds_down), name//': as many folds from either end')
      if (size(folds_up) == size(folds_down)) &
         call tests%is_close(maxval(abs(folds_up - folds_down)), 0.0_dp, 1e-7_dp, name//': the same folds')
      do i = 1, size(frequency)
         call solutions_at(train, unjudged(0.2_dp, 2.6_dp, harmonics), up, frequency(i), from_below, error)
         call solutions_at(train, unjudged(2.6_dp, 0.2_dp, harmonics), down, frequency(i), from_above, error)
         call tests%is_true(size(from_below) == size(from_above), name//': as many solutions from either end')
         call tests%is_true(mod(size(from_below), 2) == 1, name//': an odd number of solutions')
         do k = 1, size(from_below)
            call tests%is_true(nearest_motion(from_below(k), from_above) < 1e-7_dp, name//': the same solutions')
         end do
      end do
   end subroutine both_ends

   !> Figure 9, zeta 0.01: the linear train is unbounded at w_a and at w_b, so the branch from below leaves at w_a, the one from
   !> above at w_b, and between them lies a third piece that comes from and goes to beyond the limit. It needs a seed.
   subroutine three_pieces(tests, train)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      type(branch_type) :: outer, middle
      type(motion_type), allocatable :: motions(:), more(:)
      type(attractors_settings_type) :: settings
      type(attractors_type) :: found
      type(error_type), allocatable :: error
      real(dp), parameter :: frequency(4) = [0.301_dp, 1.003_dp, 1.407_dp, 2.311_dp]
      integer :: i

      call response(train, unjudged(0.2_dp, 2.6_dp, 6), outer, error)
      call tests%is_true(index(outer%ended, 'mesh 2 passed') > 0 .and. index(outer%ended, 'mesh 1 passed') > 0, &
                         'figure 9, zeta 0.01: leaves by mesh 2 at w_a and by mesh 1 at w_b')
      call tests%is_true(.not. outer%complete .and. index(outer%ended, 'between these two') > 0, &
                         'figure 9, zeta 0.01: not called complete')
      settings = attractors_settings_type(frequency=1.0_dp, starts=4, random_seed=1, tolerance=1e-7_dp)
      call attractors(train, settings, found, error)
      i = findloc(found%motions%period, 1, 1)
      call tests%is_true(i > 0, 'figure 9, zeta 0.01: a period-1 motion at 1.0')
      if (i == 0) return
      call response(train, unjudged(0.2_dp, 2.6_dp, 6), middle, error, seed=found%motions(i))
      call tests%is_true(index(middle%ended, 'mesh 2 passed') > 0 .and. index(middle%ended, 'mesh 1 passed') > 0, &
                         'figure 9, zeta 0.01: the middle piece joins the two: '//middle%ended)
      do i = 1, size(frequency)
         call solutions_at(train, unjudged(0.2_dp, 2.6_dp, 6), outer, frequency(i), motions, error)
         call solutions_at(train, unjudged(0.2_dp, 2.6_dp, 6), middle, frequency(i), more, error)
         call tests%is_true(mod(size(motions) + size(more), 2) == 1, 'figure 9, zeta 0.01: odd with the middle piece')
      end do
   end subroutine three_pieces

   !> Settings without stability, which these checks do not need.
   function unjudged(start, stop, harmonics) result(settings)
      real(dp), intent(in) :: start, stop
      integer, intent(in) :: harmonics
      type(response_settings_type) :: settings

      settings = settings_of(start, stop, harmonics)
      settings%stability = .false.
   end function unjudged

   !> Mesh stiffness of five harmonics with a given fifth.
   function rectangular(fifth) result(train)
      real(dp), intent(in) :: fifth
      type(train_type) :: train

      train = paper_train()
      train%meshes(1)%stiffness_cos = [0.42_dp, 0.0_dp, -0.141_dp, 0.0_dp, fifth]
      train%meshes(2)%stiffness_cos = train%meshes(1)%stiffness_cos
   end function rectangular

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
