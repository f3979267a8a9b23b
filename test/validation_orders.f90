!> Excitation at high harmonics of Lambda: none is lost, whether the harmonics are given or chosen, and what is left out is in the
!> error estimate.
module validation_orders
   use fixtures, only: paper_train, settings_of, single_pair
   use geartrain, only: branch_type, dp, error_type, integrate, integration_settings_type, motion_type, refine, response, &
                        response_settings_type, solutions_at, train_type
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: orders_tests

   !> The estimate may be off by this factor from the true error (docs/numerics.md).
   real(dp), parameter :: factor = 3

contains

   subroutine orders_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('one_order')) call one_order(tests)
      if (tests%runs('two_orders')) call two_orders(tests)
      if (tests%runs('above_the_tail')) call above_the_tail(tests)
      if (tests%runs('linear_meshes')) call linear_meshes(tests)
      if (tests%runs('integrated')) call integrated(tests)
   end subroutine orders_tests

   !> A single pair of order m at Lambda/m is the pair of order 1 at Lambda, with the number of harmonics left to the program:
   !> the first two ranges and the curve with its two folds and its peak.
   subroutine one_order(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: one, many
      integer, parameter :: orders(*) = [5, 19, 50, 71]
      type(error_type), allocatable :: error
      character(24) :: name
      integer :: i

      train = single_pair(0.05_dp, 0.3_dp, 0.4_dp)
      call response(train, settings_of(0.6_dp, 1.6_dp, 0), one, error)
      call tests%is_true(size(one%special_points) == 2, 'order 1: two folds')
      do i = 1, size(orders)
         write (name, '(a, i0)') 'order ', orders(i)
         train%meshes(1)%order = orders(i)
         call response(train, settings_of(0.6_dp/orders(i), 1.6_dp/orders(i), 0), many, error)
         call tests%is_true(many%complete, trim(name)//': '//many%ended%text)
         call tests%is_true(size(many%special_points) == 2, trim(name)//': two folds')
         if (size(many%special_points) /= 2) cycle
         ! Both hold the tolerance of 1e-4, not with the same numbers of harmonics.
         call tests%is_close(maxval(abs(many%special_points%frequency_ratio*orders(i) - one%special_points%frequency_ratio)), &
                             0.0_dp, 1e-4_dp, &
                             trim(name)//': the folds at Lambda over the order')
         call tests%is_close(maxval(many%rms(1, :many%points)), maxval(one%rms(1, :one%points)), 5e-3_dp, trim(name)//': the peak')
      end do
      ! Well below resonance, where only the excitation moves the mesh: the first part of figure 3's train.
      train = paper_train()
      train%shafts = train%shafts(:2)
      train%shafts(2) = train%shafts(1)
      train%meshes = train%meshes(:1)
      call response(train, settings_of(0.05_dp, 0.06_dp, 0), one, error)
      train%meshes%order = 19
      call response(train, settings_of(0.05_dp/19, 0.06_dp/19, 0), many, error)
      call tests%is_close(many%rms(1, 1), one%rms(1, 1), 1e-6_dp, 'figure 3, first pair, order 19: rms at 0.05/19')
      call tests%is_true(many%rms(1, 1) > 0.13_dp, 'figure 3, first pair, order 19: it moves')
   end subroutine one_order

   !> Orders without a common divisor, at random: every solution that is chosen by tolerance has its estimate, and moves as shooting
   !> says.
   subroutine two_orders(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: branch
      type(motion_type), allocatable :: motions(:)
      type(motion_type) :: exact
      type(response_settings_type) :: settings
      type(error_type), allocatable :: error
      integer, parameter :: orders(2, 4) = reshape([1, 23, 17, 5, 80, 3, 7, 29], [2, 4])
      character(24) :: name
      real(dp) :: at, off
      integer :: i

      train = paper_train(kappa=0.1_dp)
      do i = 1, size(orders, 2)
         write (name, '(a, i0, a, i0)') 'orders ', orders(1, i), ' and ', orders(2, i)
         train%meshes%order = orders(:, i)
         at = 0.3_dp/maxval(orders(:, i))
         settings = settings_of(at, 1.05_dp*at, 0)
         settings%tolerance = 1e-3_dp
         settings%stability = .false.
         call response(train, settings, branch, error)
         call solutions_at(train, settings, branch, 1.02_dp*at, motions, error)
         call tests%is_true(size(motions) == 1, trim(name)//': a motion')
         if (size(motions) /= 1) cycle
         exact = motions(1)
         call refine(train, exact, error)
         call tests%is_true(.not. allocated(error), trim(name)//': shooting converges')
         off = difference(motions(1)%coefficients, exact%coefficients)
         call tests%is_true(off < factor*motions(1)%error_estimate + 1e-6_dp, trim(name)//': the estimate holds')
         call tests%is_close(maxval(abs(motions(1)%rms/exact%rms - 1)), 0.0_dp, 3e-3_dp, trim(name)//': rms of both meshes')
      end do
   end subroutine two_orders

   !> Stiffness with harmonics 1 and 30: a balance of 6 harmonics, whose tail ends at 18, tells that it lacks the other one; chosen
   !> by tolerance it is carried.
   subroutine above_the_tail(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: branch
      type(error_type), allocatable :: error
      type(motion_type), allocatable :: motions(:)
      type(motion_type) :: exact
      type(response_settings_type) :: settings
      real(dp), allocatable :: kappa(:)
      real(dp) :: off
      integer :: harmonics

      train = single_pair(0.05_dp, 0.1_dp, 2.0_dp)
      allocate (kappa(30), source=0.0_dp)
      kappa([1, 30]) = 0.1_dp
      train%meshes(1)%stiffness_cos = kappa
      do harmonics = 0, 6, 6
         settings = settings_of(0.032_dp, 0.033_dp, harmonics)
         call response(train, settings, branch, error)
         call solutions_at(train, settings, branch, 0.0325_dp, motions, error)
         exact = motions(1)
         call refine(train, exact, error)
         off = difference(motions(1)%coefficients, exact%coefficients)
         if (harmonics == 0) then
            call tests%is_true(off < 1e-4_dp .and. motions(1)%error_estimate < 1e-4_dp, 'harmonic 30 is carried')
         else
            call tests%is_true(off > 0.5_dp .and. motions(1)%error_estimate > off .and. all(branch%estimate_doubtful), &
                               'harmonic 30 is left out, and the estimate says so')
         end if
      end do
   end subroutine above_the_tail

   !> Meshes that are no unknowns of the balance, all of them or one beside a mesh with backlash: what excites them counts as well.
   subroutine linear_meshes(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: branch
      type(error_type), allocatable :: error
      type(motion_type) :: exact, none
      real(dp), allocatable :: amplitudes(:)
      integer :: meshes

      allocate (amplitudes(20), source=0.0_dp)
      amplitudes([1, 20]) = 1e-6_dp
      do meshes = 1, 2
         train = paper_train()
         train%meshes(2)%half_backlash = 0
         deallocate (train%meshes(2)%stiffness_cos)
         train%meshes(2)%error_cos = amplitudes
         if (meshes == 1) then
            train%shafts = train%shafts(:2)
            train%meshes = train%meshes(2:)
         end if
         ! At R = 6 most of the motion of the linear mesh is missing; the harmonics that are chosen carry all of it.
         call response(train, settings_of(0.05_dp, 0.052_dp, 6), branch, error)
         call tests%is_true(all(branch%estimate_doubtful .and. branch%error_estimate > 1), 'linear mesh: harmonic 20 is missed')
         call response(train, settings_of(0.05_dp, 0.052_dp, 0), branch, error)
         exact = none
         exact%frequency_ratio = branch%frequency_ratio(1)
         exact%coefficients = branch%coefficients(:, :, 1)
         call refine(train, exact, error)
         call tests%is_true(.not. allocated(error), 'linear mesh: shooting converges')
         call tests%is_close(maxval(abs(branch%rms(:, 1)/exact%rms - 1)), 0.0_dp, 1e-6_dp, 'linear mesh: rms')
      end do
   end subroutine linear_meshes

   !> The harmonics that integration stores tell the motion, and its extremes are resolved: the same as order 1 at the same speed.
   subroutine integrated(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(motion_type) :: one, many
      type(error_type), allocatable :: error
      integer, parameter :: orders(*) = [19, 71]
      integer :: i

      train = single_pair(0.05_dp, 0.3_dp, 0.4_dp)
      call integrate(train, 0.8_dp, integration_settings_type(), one, error)
      do i = 1, size(orders)
         train%meshes%order = orders(i)
         call integrate(train, 0.8_dp/orders(i), integration_settings_type(), many, error)
         call tests%is_true(.not. allocated(error), 'integrated: settles')
         call tests%is_close(sqrt(sum(many%coefficients(2:, 1)**2)), many%rms(1), 1e-4_dp, 'integrated: spectrum holds all')
         call tests%is_close(many%rms(1), one%rms(1), 1e-8_dp, 'integrated: rms')
         call tests%is_close(many%maximum(1), one%maximum(1), 1e-6_dp, 'integrated: largest displacement')
         call tests%is_close(many%minimum(1), one%minimum(1), 1e-6_dp, 'integrated: smallest displacement')
         call tests%is_close(many%mesh_load(1)%force_maximum, one%mesh_load(1)%force_maximum, 1e-5_dp, 'integrated: largest force')
      end do
   end subroutine integrated

   !> Relative difference of the waveforms of two sets of coefficients, of all meshes together.
   pure real(dp) function difference(a, b)
      real(dp), intent(in) :: a(:, :), b(:, :)
      integer :: n

      n = min(size(a, 1), size(b, 1))
      difference = sqrt((2*sum((b(1, :) - a(1, :))**2) + sum((b(2:n, :) - a(2:n, :))**2) + sum(b(n + 1:, :)**2) &
                         + sum(a(n + 1:, :)**2))/sum(b(2:, :)**2))
   end function difference

end module validation_orders
