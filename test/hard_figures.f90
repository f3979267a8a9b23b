!> The figures of the paper on which continuation is hardest: complete from both ends, the same solutions at every step size, their
!> number odd (a branch beyond the amplitude limit counts where it passes).
module hard_figures
   use fixtures, only: paper_train, rectangular, settings_of
   use geartrain, only: branch_type, dp, error_type, motion_type, response_settings_type, solutions_at, train_type
   use geartrain_readings_summary, only: folds
   use readings, only: solve
   use testing, only: full, nightly, tests_type
   implicit none (type, external)
   private
   public :: figures_cases

   !> Motions beyond it may or may not be recorded.
   real(dp), parameter :: limit = 12

contains

   subroutine figures_cases(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train

      call tests%heading('Figures, each from both ends and at several step sizes')
      if (tests%runs('figure_6', full)) then
         train = paper_train()
         train%input_torque = 100
         call figure(tests, train, 'figure 6, 100 N m')
      end if
      if (tests%runs('figure_7', full)) call figure(tests, paper_train(0.42_dp), 'figure 7, kappa 0.42')
      if (tests%runs('figure_8', full)) then
         call figure(tests, rectangular(-0.085_dp), 'figure 8 as printed')
         call figure(tests, rectangular(0.084_dp), 'figure 8, rectangular wave')
      end if
      if (tests%runs('figure_9', full)) then
         train = paper_train()
         train%meshes%damping_ratio = 0.03_dp
         call figure(tests, train, 'figure 9, zeta 0.03')
         train%meshes%damping_ratio = 0.01_dp
         call figure(tests, train, 'figure 9, zeta 0.01')
      end if
      if (tests%runs('figure_10', full)) then
         train = paper_train()
         train%meshes(2)%order = 2
         call figure(tests, train, 'figure 10')
      end if
      if (tests%runs('figure_11', full)) then
         train = paper_train()
         train%meshes%order = [3, 2]
         call figure(tests, train, 'figure 11')
      end if
   end subroutine figures_cases

   !> A figure at several numbers of harmonics, by day at the first two: most of the time goes into the most harmonics.
   subroutine figure(tests, train, name)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      character(*), intent(in) :: name
      integer, parameter :: harmonics(*) = [6, 12, 24, 48]
      character(8) :: number
      integer :: i

      do i = 1, merge(size(harmonics), 2, tests%tier(nightly))
         write (number, '(a, i0)') ', R = ', harmonics(i)
         call one_figure(tests, train, harmonics(i), name//trim(number))
      end do
   end subroutine figure

   subroutine one_figure(tests, train, harmonics, name)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      integer, intent(in) :: harmonics
      character(*), intent(in) :: name
      real(dp), parameter :: frequency_ratio(*) = [0.253_dp, 0.301_dp, 0.463_dp, 0.571_dp, 0.613_dp, 0.661_dp, 0.727_dp, 0.787_dp, &
                                                   0.8385_dp, 0.901_dp, 0.943_dp, 1.013_dp, 1.277_dp, 1.555_dp, 1.603_dp, &
                                                        1.727_dp, &
                                                   1.901_dp, 2.311_dp]
      real(dp), parameter :: step(*) = [0.05_dp, 0.05_dp, 0.2_dp, 0.02_dp]
      type(response_settings_type) :: settings
      type(branch_type) :: branch
      type(motion_type), allocatable :: motions(:), reference(:)
      type(error_type), allocatable :: error
      real(dp) :: worst
      integer :: i, k, run, turns
      logical :: complete, odd, turned
      type :: list_type
         type(motion_type), allocatable :: motions(:)
      end type list_type
      type(list_type) :: first(size(frequency_ratio))

      complete = .true.
      odd = .true.
      turned = .true.
      worst = 0
      do run = 1, size(step)
         settings = settings_of(0.2_dp, 2.6_dp, harmonics)
         if (run == 2) settings = settings_of(2.6_dp, 0.2_dp, harmonics)
         settings%stability = .false.
         settings%step = step(run)
         branch = solve(train, settings)
         complete = complete .and. branch%complete
         if (run == 1) turns = size(folds(branch))
         turned = turned .and. size(folds(branch)) == turns
         do i = 1, size(frequency_ratio)
            call solutions_at(train, settings, branch, frequency_ratio(i), motions, error)
            odd = odd .and. mod(size(motions) + passages(branch, frequency_ratio(i)), 2) == 1
            call drop_large(motions)
            if (run == 1) then
               first(i)%motions = motions
               cycle
            end if
            reference = first(i)%motions
            if (size(motions) /= size(reference)) worst = huge(1.0_dp)
            do k = 1, size(motions)
               worst = max(worst, distance(motions(k), reference))
            end do
         end do
      end do
      call tests%holds(name, 'complete from either end, an odd number of solutions', complete .and. odd)
      call tests%holds(name, 'it turns back as often, whatever end and step', turned)
      call tests%measured(name, 'the same solutions from the other end, at steps 0.2 and 0.02', worst, 1e-10_dp)
   end subroutine one_figure

   !> How often the branch passes the frequency beyond the amplitude limit, up to an even number.
   integer function passages(branch, frequency_ratio)
      type(branch_type), intent(in) :: branch
      real(dp), intent(in) :: frequency_ratio
      integer :: i

      passages = 0
      do i = 1, branch%points - 1
         if (branch%segment(i) == branch%segment(i + 1)) cycle
         if ((branch%frequency_ratio(i) < frequency_ratio) .neqv. (branch%frequency_ratio(i &
              + 1) < frequency_ratio)) passages = passages + 1
      end do
   end function passages

   subroutine drop_large(motions)
      type(motion_type), allocatable, intent(inout) :: motions(:)
      integer :: i
      logical :: large(size(motions))

      do i = 1, size(motions)
         large(i) = any(motions(i)%rms > limit)
      end do
      motions = pack(motions, .not. large)
   end subroutine drop_large

   pure real(dp) function distance(motion, motions)
      type(motion_type), intent(in) :: motion, motions(:)
      integer :: i

      distance = huge(1.0_dp)
      do i = 1, size(motions)
         distance = min(distance, maxval(abs(motion%coefficients - motions(i)%coefficients)))
      end do
   end function distance

end module hard_figures
