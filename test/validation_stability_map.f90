!> Stability maps against Mathieu's equation in closed form and by a plain Runge-Kutta method, against the branches of the same
!> train, and against themselves with other numbers of threads.
module validation_stability_map
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use, intrinsic :: iso_fortran_env, only: int64
   use fixtures, only: paper_train, settings_of, single_pair
   use geartrain, only: branch_type, dp, error_type, motion_type, observer_type, response, solutions_at, stability_map, &
      stability_map_settings_type, stability_map_type, train_type
   use omp_lib, only: omp_get_max_threads, omp_set_num_threads
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: stability_map_tests

   !> Ends the work at the first row.
   type, extends(observer_type) :: stopper_type
      integer :: calls = 0
   contains
      procedure :: on_step
   end type stopper_type

contains

   subroutine stability_map_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('mathieu_boundaries')) call mathieu_boundaries(tests)
      if (tests%runs('damped_mathieu')) call damped_mathieu(tests)
      if (tests%runs('tongues_of_paper_train')) call tongues_of_paper_train(tests)
      if (tests%runs('against_linear_branch')) call against_linear_branch(tests)
      if (tests%runs('no_holes')) call no_holes(tests)
      if (tests%runs('coexisting_motions')) call coexisting_motions(tests)
      if (tests%runs('any_number_of_threads')) call any_number_of_threads(tests)
      if (tests%runs('other_parameters')) call other_parameters(tests)
      if (tests%runs('stopped')) call stopped(tests)
      if (tests%runs('bad_input')) call bad_input(tests)
   end subroutine stability_map_tests

   subroutine on_step(self, analysis, done, frequency_ratio, keep_going)
      class(stopper_type), intent(inout) :: self
      character(*), intent(in) :: analysis
      integer, intent(in) :: done
      real(dp), intent(in) :: frequency_ratio
      logical, intent(inout) :: keep_going

      associate (unused_1 => analysis, unused_2 => done, unused_3 => frequency_ratio)
      end associate
      self%calls = self%calls + 1
      keep_going = .false.
   end subroutine on_step

   function chart(start, stop, points, low, high, rows, linear) result(settings)
      real(dp), intent(in) :: start, stop, low, high
      integer, intent(in) :: points, rows
      logical, intent(in) :: linear
      type(stability_map_settings_type) :: settings

      settings%start = start
      settings%stop = stop
      settings%points = points
      settings%parameter_start = low
      settings%parameter_stop = high
      settings%parameter_points = rows
      settings%linear = linear
   end function chart

   !> x'' + (1 + kappa cos Lambda t) x = 0 is y'' + (a - 2 q cos 2 tau) y = 0 with a = 4/Lambda**2, q = 2 kappa/Lambda**2; its
   !> boundaries a_1, b_1, a_2, b_2 (NIST DLMF 28.6.2 to 28.6.5) at kappa = 0.1 to better than 1e-8.
   subroutine mathieu_boundaries(tests)
      class(tests_type), intent(inout) :: tests
      real(dp), parameter :: kappa = 0.1_dp
      real(dp) :: edge(4)
      integer :: i

      do i = 1, 4
         edge(i) = boundary(i, kappa)
      end do
      ! A larger a is a smaller Lambda.
      call straddles(tests, kappa, edge(1), -1.0_dp, 'a_1')
      call straddles(tests, kappa, edge(2), 1.0_dp, 'b_1')
      call straddles(tests, kappa, edge(3), -1.0_dp, 'a_2')
      call straddles(tests, kappa, edge(4), 1.0_dp, 'b_2')
   end subroutine mathieu_boundaries

   !> Lambda of the boundary a_1, b_1, a_2 or b_2.
   real(dp) function boundary(which, kappa) result(lambda)
      integer, intent(in) :: which
      real(dp), intent(in) :: kappa
      real(dp) :: a, q
      integer :: i

      lambda = merge(2, 1, which <= 2)
      do i = 1, 50
         q = 2*kappa/lambda**2
         select case (which)
         case (1)
            a = 1 + q - q**2/8 - q**3/64 - q**4/1536
         case (2)
            a = 1 - q - q**2/8 + q**3/64 - q**4/1536
         case (3)
            a = 4 + 5*q**2/12 - 763*q**4/13824
         case default
            a = 4 - q**2/12 + 5*q**4/13824
         end select
         lambda = 2/sqrt(a)
      end do
   end function boundary

   !> Unstable a little inside the boundary, neutral a little outside; `outside` is the sense in which Lambda leaves the tongue.
   subroutine straddles(tests, kappa, edge, outside, name)
      class(tests_type), intent(inout) :: tests
      real(dp), intent(in) :: kappa, edge, outside
      character(*), intent(in) :: name
      real(dp), parameter :: little = 2e-6_dp
      type(stability_map_type) :: map
      type(error_type), allocatable :: error

      call stability_map(single_pair(0.0_dp, kappa, 1.0_dp), &
                         chart(edge - outside*little, edge + outside*little, 2, kappa, kappa, 1, .true.), map, error)
      call tests%is_true(abs(map%multiplier(1, 1)) > 1 + 1e-5_dp, 'inside '//name)
      call tests%is_close(abs(map%multiplier(2, 1)), 1.0_dp, 1e-8_dp, 'outside '//name)
      call tests%is_true(all(map%motions == 1) .and. map%stable_motions(1, 1) == 0, 'counts at '//name)
   end subroutine straddles

   !> Multipliers of the damped equation by the classical Runge-Kutta method with 4000 steps a period.
   subroutine damped_mathieu(tests)
      class(tests_type), intent(inout) :: tests
      type(stability_map_type) :: map
      type(error_type), allocatable :: error
      real(dp), parameter :: zeta = 0.05_dp
      real(dp) :: worst
      integer :: i, k

      call stability_map(single_pair(zeta, 0.3_dp, 1.0_dp), chart(0.6_dp, 2.4_dp, 7, 0.1_dp, 0.7_dp, 4, .true.), map, error)
      worst = 0
      do i = 1, 4
         do k = 1, 7
            worst = max(worst, abs(abs(map%multiplier(k, i)) - runge_kutta(zeta, map%parameter(i), map%frequency_ratio(k))))
         end do
      end do
      call tests%is_close(worst, 0.0_dp, 1e-8_dp, 'damped Mathieu, 28 points against Runge-Kutta')
      call tests%is_true(map%complete .and. map%ended == 'all rows done', 'complete')
   end subroutine damped_mathieu

   real(dp) function runge_kutta(zeta, kappa, lambda) result(radius)
      real(dp), intent(in) :: zeta, kappa, lambda
      integer, parameter :: steps = 4000
      real(dp) :: x(2, 2), k1(2, 2), k2(2, 2), k3(2, 2), h, t, trace, determinant
      integer :: i

      h = 8*atan(1.0_dp)/lambda/steps
      x = reshape([1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], [2, 2])
      do i = 1, steps
         t = (i - 1)*h
         k1 = rate(x, t)
         k2 = rate(x + h/2*k1, t + h/2)
         k3 = rate(x + h/2*k2, t + h/2)
         x = x + h/6*(k1 + 2*k2 + 2*k3 + rate(x + h*k3, t + h))
      end do
      trace = x(1, 1) + x(2, 2)
      determinant = x(1, 1)*x(2, 2) - x(1, 2)*x(2, 1)
      radius = sqrt(determinant)
      if (trace**2 > 4*determinant) radius = (abs(trace) + sqrt(trace**2 - 4*determinant))/2

   contains

      function rate(state, time)
         real(dp), intent(in) :: state(2, 2), time
         real(dp) :: rate(2, 2)

         rate(1, :) = state(2, :)
         rate(2, :) = -2*zeta*state(2, :) - (1 + kappa*cos(lambda*time))*state(1, :)
      end function rate

   end function runge_kutta

   !> Unstable from 1.777 to 2.044 at kappa = 0.3 by a doubling of the period: the figures of validation_claims_excitation.
   subroutine tongues_of_paper_train(tests)
      class(tests_type), intent(inout) :: tests
      type(stability_map_type) :: map
      type(error_type), allocatable :: error

      call stability_map(paper_train(), chart(1.776_dp, 1.778_dp, 2, 0.3_dp, 0.3_dp, 1, .true.), map, error)
      call tests%is_true(map%stable_motions(1, 1) == 1 .and. map%stable_motions(2, 1) == 0, 'lower edge at 1.777')
      call tests%is_close(real(map%multiplier(2, 1)), -1.0_dp, 0.02_dp, 'a doubling of the period')
      call stability_map(paper_train(), chart(2.043_dp, 2.045_dp, 2, 0.3_dp, 0.3_dp, 1, .true.), map, error)
      call tests%is_true(map%stable_motions(1, 1) == 0 .and. map%stable_motions(2, 1) == 1, 'upper edge at 2.044')
   end subroutine tongues_of_paper_train

   !> The multipliers of the forced motion of the linear train, with its balance.
   subroutine against_linear_branch(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: branch
      type(motion_type), allocatable :: motions(:)
      type(stability_map_type) :: map
      type(error_type), allocatable :: error
      integer :: k

      train = paper_train(0.2_dp)
      call stability_map(train, chart(0.5_dp, 1.5_dp, 5, 0.2_dp, 0.2_dp, 1, .true.), map, error)
      train%meshes%half_backlash = 0
      call response(train, settings_of(0.4_dp, 1.6_dp, 6), branch, error)
      do k = 1, 5
         call solutions_at(train, settings_of(0.4_dp, 1.6_dp, 6), branch, map%frequency_ratio(k), motions, error)
         call tests%is_true(size(motions) == 1, 'one motion of the linear train')
         call tests%is_close(abs(map%multiplier(k, 1)), abs(motions(1)%multipliers(1)), 1e-12_dp, 'as on the branch')
      end do
   end subroutine against_linear_branch

   !> Lambda = 4.2 - 0.2/1.1 or so, where the double steps of the eigenvalues turn in circles for some kappa.
   subroutine no_holes(tests)
      class(tests_type), intent(inout) :: tests
      type(stability_map_type) :: map
      type(error_type), allocatable :: error

      call stability_map(paper_train(), chart(0.2_dp + 4.0_dp*189/199, 0.2_dp + 4.0_dp*191/199, 3, 0.0_dp, 0.2_dp, 200, .true.), &
                         map, error)
      call tests%is_true(all(abs(map%multiplier) < 1) .and. all(map%stable_motions == 1), 'stable below the second tongue')
   end subroutine no_holes

   !> Figure 3 at Lambda 0.6 has three motions, two of them stable; at 1.92 one, unstable: the same solutions as at(Lambda).
   subroutine coexisting_motions(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(motion_type), allocatable :: motions(:)
      type(stability_map_type) :: map
      type(error_type), allocatable :: error
      integer :: k

      call stability_map(paper_train(), chart(0.4_dp, 1.92_dp, 77, 0.1_dp, 0.3_dp, 2, .false.), map, error)
      call tests%is_true(map%motions(11, 2) == 3 .and. map%stable_motions(11, 2) == 2, 'three motions at 0.6, two stable')
      call tests%is_true(map%motions(77, 2) == 1 .and. map%stable_motions(77, 2) == 0, 'one motion at 1.92, unstable')
      call tests%is_true(all(ieee_is_nan(map%rms(:, 77, 2))) .and. .not. any(ieee_is_nan(map%rms(:, 11, :))), &
                         'rms where there is a stable motion')
      call response(paper_train(), settings_of(0.4_dp, 1.92_dp, 6), branch, error)
      call solutions_at(paper_train(), settings_of(0.4_dp, 1.92_dp, 6), branch, map%frequency_ratio(11), motions, error)
      call tests%is_true(size(motions) == 3, 'three solutions on the branch')
      if (size(motions) /= 3) return
      do k = 1, 2
         call tests%is_close(map%rms(k, 11, 2), maxval([motions(1)%rms(k), motions(3)%rms(k)]), 1e-8_dp, 'largest stable rms')
      end do
      call tests%is_close(abs(map%multiplier(11, 2)), minval([(abs(motions(k)%multipliers(1)), k=1, 3)]), 1e-6_dp, &
                          'multiplier of the most stable motion')
   end subroutine coexisting_motions

   !> The same bits with 1, 2 and 3 threads.
   subroutine any_number_of_threads(tests)
      class(tests_type), intent(inout) :: tests
      type(stability_map_type) :: map(3)
      type(error_type), allocatable :: error
      integer :: before, threads

      before = omp_get_max_threads()
      do threads = 1, 3
         call omp_set_num_threads(threads)
         call stability_map(paper_train(), chart(0.4_dp, 2.2_dp, 19, 0.0_dp, 0.4_dp, 7, .false.), map(threads), error)
      end do
      call omp_set_num_threads(before)
      do threads = 2, 3
         call tests%is_true(all(map(threads)%motions == map(1)%motions) .and. &
                            all(map(threads)%stable_motions == map(1)%stable_motions), 'counts with more threads')
         call tests%is_true(all(abs(map(threads)%multiplier - map(1)%multiplier) <= 0), 'multipliers with more threads')
         ! Bits, of NaN as well.
         call tests%is_true(all(transfer(map(threads)%rms, [0_int64]) == transfer(map(1)%rms, [0_int64])), 'rms with more threads')
      end do
   end subroutine any_number_of_threads

   !> The parameter reaches the train: a row equals the map of a train that has that value from the beginning.
   subroutine other_parameters(tests)
      class(tests_type), intent(inout) :: tests
      character(20), parameter :: names(6) = [character(20) :: 'mesh_damping_ratio', 'input_torque', 'half_backlash', &
                                              'shaft 2 stiffness', 'load_inertia', 'mesh 2 half_backlash']
      real(dp), parameter :: values(6) = [0.08_dp, 100.0_dp, 20e-6_dp, 5e7_dp, 3e-7_dp, 25e-6_dp]
      type(stability_map_settings_type) :: settings
      type(stability_map_type) :: map, same
      type(train_type) :: train
      type(error_type), allocatable :: error
      integer :: i

      do i = 1, size(names)
         train = paper_train()
         settings = chart(0.5_dp, 0.9_dp, 5, values(i), values(i), 1, .false.)
         settings%parameter = names(i)
         call stability_map(train, settings, map, error)
         if (i == 1) train%meshes%damping_ratio = values(i)
         if (i == 2) train%input_torque = values(i)
         if (i == 3) train%meshes%half_backlash = values(i)
         if (i == 4) train%shafts(2)%stiffness = values(i)
         if (i == 5) train%load_inertia = values(i)
         if (i == 6) train%meshes(2)%half_backlash = values(i)
         call stability_map(train, chart(0.5_dp, 0.9_dp, 5, 0.3_dp, 0.3_dp, 1, .false.), same, error)
         call tests%is_true(all(map%motions == same%motions), trim(names(i))//': motions')
         call tests%is_close(maxval(abs(map%multiplier - same%multiplier)), 0.0_dp, 1e-12_dp, trim(names(i))//': multipliers')
      end do
   end subroutine other_parameters

   subroutine stopped(tests)
      class(tests_type), intent(inout) :: tests
      type(stability_map_type) :: map
      type(stopper_type) :: stopper
      type(error_type), allocatable :: error

      call stability_map(paper_train(), chart(0.5_dp, 1.5_dp, 3, 0.1_dp, 0.3_dp, 50, .true.), map, error, stopper)
      call tests%is_true(stopper%calls == 1, 'told once')
      call tests%is_true(.not. map%complete .and. index(map%ended, 'cancelled after') == 1, 'says that it was cancelled')
      call tests%is_true(size(map%done) > 0 .and. size(map%done) < 50 .and. all(map%done), 'it holds the rows done')
      call tests%is_true(all(shape(map%motions) == [3, size(map%done)]) .and. all(map%motions == 1) .and. &
                         size(map%parameter) == size(map%done), 'and no others')
   end subroutine stopped

   subroutine bad_input(tests)
      class(tests_type), intent(inout) :: tests
      type(stability_map_settings_type) :: settings
      type(stability_map_type) :: map
      type(train_type) :: train
      type(error_type), allocatable :: error

      settings = chart(0.5_dp, 0.5_dp, 3, 0.1_dp, 0.1_dp, 2, .true.)
      settings%parameter = 'input_torque'
      call stability_map(paper_train(), settings, map, error)
      call tests%is_text(error%message, '&stability_map: to = 0.5: must differ from "from"'//new_line('a')// &
                         '&stability_map: parameter_points = 2: must be 1 where "parameter_from" and "parameter_to" are equal, and &
                         &only there'//new_line('a')//"&stability_map: parameter = 'input_torque': has no influence on the &
                         &stability of the linear train: leave out linear = .true.", 'three problems')
      train = paper_train(0.0_dp)
      call stability_map(train, chart(0.5_dp, 1.0_dp, 3, 0.1_dp, 0.2_dp, 2, .true.), map, error)
      call tests%is_text(error%message, "&stability_map: parameter = 'stiffness_variation': needs a mesh with stiffness_cos or &
                         &stiffness_sin, which give the shape that is scaled", 'no shape')
   end subroutine bad_input

end module validation_stability_map
