!> Derivatives of special points and natural frequencies beside differences and closed forms; where there are none.
module validation_gradient_special
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use fixtures, only: paper_train, random_train, ring, settings_of, single_pair
   use geartrain, only: branch_type, dp, error_type, frequency_gradient, gradient_type, modes_type, motion_gradient, &
      natural_modes, response, response_settings_type, special_gradient, train_type
   use geartrain_base_numbers, only: integer_text
   use geartrain_network_parameter_table, only: parameter_type
   use geartrain_trace_points, only: motion_of
   use networks, only: draw_laws, random_network
   use parameters_of_trains, only: all_parameters, change, name_length, parameter_of
   use testing, only: full, nightly, tests_type
   implicit none (type, external)
   private
   public :: gradient_special_tests

   !> Most special points of a branch that are compared.
   integer, parameter :: most_points = 12
   !> Error of a derivative of the library, relative [1]; room for the largest of many derivatives over their estimated errors.
   real(dp), parameter :: exact = 5e-8_dp, room = 20
   !> In place of a difference of Lambda [1] where the point of a changed train is not found: it agrees with no other difference.
   real(dp), parameter :: unknown = 1e30_dp

contains

   subroutine gradient_special_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('special_points', full)) call special_points(tests)
      if (tests%runs('modes', full)) call modes_of_trains(tests)
      if (tests%runs('nowhere')) call nowhere(tests)
   end subroutine gradient_special_tests

   !> Folds and period doublings: Lambda of the changed train beside the derivative.
   subroutine special_points(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(response_settings_type) :: settings
      integer :: i, found(3)

      found = 0
      call compare_special(tests, 'figure 3', paper_train(), settings_of(0.4_dp, 4.2_dp, 8), found)
      call compare_special(tests, 'pair', single_pair(0.05_dp, 0.3_dp, 0.4_dp), settings_of(0.3_dp, 3.0_dp, 10), found)
      call random_train(8, train, settings)
      call compare_special(tests, 'a pair leaves the circle', train, settings, found)
      ! How many points the random chains below have is a matter of rounding: branches through chaos differ from one another.
      ! These three branches have few points, far from one another, and all of them are compared: 8, 2 and 1 folds, 4 and 2 period
      ! doublings, 3 Neimark-Sacker points.
      call tests%is_true(all(found >= [11, 6, 3]), 'folds, period doublings and Neimark-Sacker points compared: ' &
                         //integer_text(found(1))//', '//integer_text(found(2))//' and '//integer_text(found(3)))
      do i = 1, tests%times(8)
         call random_train(i + 1000*tests%seed, train, settings)
         call compare_special(tests, 'chain '//integer_text(i), train, settings, found)
      end do
   end subroutine special_points

   subroutine compare_special(tests, what, train, settings, found)
      class(tests_type), intent(inout) :: tests
      character(*), intent(in) :: what
      type(train_type), intent(in) :: train
      type(response_settings_type), intent(in) :: settings
      integer, intent(inout) :: found(3)
      type(branch_type) :: branch
      type(error_type), allocatable :: error
      type(gradient_type) :: gradient
      type(parameter_type) :: parameter
      character(name_length), allocatable :: names(:)
      character(name_length) :: name
      real(dp) :: slope, least, off, worst, spread
      integer :: i, n, kind

      call response(train, settings, branch, error)
      if (allocated(error)) return
      call all_parameters(train, names)
      ! A branch through chaos has dozens.
      do i = 1, min(most_points, size(branch%special_points))
         kind = findloc(['fold           ', 'period doubling', 'neimark-sacker '], branch%special_points(i)%kind, 1)
         if (kind == 0) cycle
         call special_gradient(train, branch, i, names, gradient, error)
         worst = 0
         name = ''
         do n = 1, size(names)
            if (gradient%reason(n) /= '') cycle
            call parameter_of(train, trim(names(n)), parameter, error)
            call find_slope()
            if (allocated(error)) cycle
            off = abs(gradient%values(1, n) - slope)/(exact*max(abs(slope), least) + spread + gradient%uncertainty(1, n))
            if (.not. off >= 0) off = huge(off)
            if (off > worst) name = names(n)
            worst = max(worst, off)
         end do
         if (all(gradient%reason == '')) found(kind) = found(kind) + 1
         call tests%is_close(worst, 0.0_dp, room, what//': '//trim(branch%special_points(i)%kind)// &
                             ' as differences have it, over their errors')
      end do

   contains

      !> Differences of fourth order, with half the change until three of them agree, of which two may by chance: folds of long
      !> chains lie so close to one another that a change by 4e-4 would go beyond the next fold. Where none agree, the one of least
      !> error: by how much it differs from the one before, or the rounding of Lambda over its change. That rounding is the largest
      !> of the last four, which is not small by chance.
      subroutine find_slope()
         real(dp) :: wide, narrow
         real(dp), dimension(8) :: h, slopes, errors
         integer :: k

         h = 4e-4_dp*merge(abs(parameter%value), 0.1_dp, abs(parameter%value) > 0)*0.5_dp**[(k, k=0, size(h) - 1)]
         least = 1e-3_dp*gradient%frequency_ratio/max(abs(parameter%value), 1e3_dp*h(1))
         errors = huge(errors)
         call find_difference(h(1), wide)
         do k = 1, size(h)
            if (allocated(error)) return
            call find_difference(h(k)/2, narrow)
            slopes(k) = (8*narrow - wide)/(6*h(k))
            wide = narrow
            slope = slopes(k)
            if (k > 1) errors(k) = abs(slope - slopes(k - 1))
            spread = maxval(errors(max(1, k - 1):k))
            if (spread < 2*exact*max(abs(slope), least)) return
         end do
         errors = max(errors, maxval(errors(5:)*h(5:))/h)
         spread = minval(errors)
         slope = slopes(minloc(errors, 1))
      end subroutine find_slope

      !> Lambda of the special point with the parameter greater by h, less Lambda with the parameter less by h.
      subroutine find_difference(h, difference)
         real(dp), intent(in) :: h
         real(dp), intent(out) :: difference
         type(train_type) :: other
         type(gradient_type) :: changed(2)

         difference = 0
         call change(train, parameter, h, other)
         call special_gradient(other, branch, i, names(:0), changed(1), error)
         if (allocated(error)) return
         call change(train, parameter, -h, other)
         call special_gradient(other, branch, i, names(:0), changed(2), error)
         if (allocated(error)) return
         difference = changed(1)%frequency_ratio - changed(2)%frequency_ratio
         if (.not. min(changed(1)%frequency_ratio, changed(2)%frequency_ratio) > 0) difference = unknown
      end subroutine find_difference

   end subroutine compare_special

   !> Natural frequencies in closed form and by differences.
   subroutine modes_of_trains(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(response_settings_type) :: settings
      type(gradient_type) :: gradient
      type(error_type), allocatable :: error
      integer :: i, j

      ! omega = sqrt(k (r^2/I_1 + r^2/I_2)) = 1.
      call frequency_gradient(single_pair(0.05_dp, 0.3_dp, 0.4_dp), [character(24) :: 'mesh 1 stiffness', &
                              'mesh 1 driving_inertia', 'mesh 1 driven_radius', 'input_torque'], gradient, error)
      call tests%is_close(maxval(abs(gradient%values(1, :) - [0.5_dp, -0.125_dp, 0.5_dp, 0.0_dp])), 0.0_dp, 1e-12_dp, &
                          'a pair in closed form')
      ! The larger networks by night.
      do i = 1, merge(6, 2, tests%tier(nightly))
         call random_train(i + 1000*tests%seed, train, settings)
         call compare_modes(tests, 'chain '//integer_text(i), train)
         call random_network(4 + i, mod(i, 3), i + 1000*tests%seed, train)
         call draw_laws(i + 1000*tests%seed, train)
         train%bodies(2)%damping_to_ground = 0.2_dp
         do j = 2, 3 + i
            train%bodies(j)%torque = -2.0_dp*j
         end do
         call compare_modes(tests, 'network '//integer_text(i), train)
      end do
   end subroutine modes_of_trains

   subroutine compare_modes(tests, what, train)
      class(tests_type), intent(inout) :: tests
      character(*), intent(in) :: what
      type(train_type), intent(in) :: train
      type(gradient_type) :: gradient
      type(error_type), allocatable :: error
      type(parameter_type) :: parameter
      type(modes_type) :: modes
      character(name_length), allocatable :: names(:)
      real(dp), allocatable :: slope(:), least(:), spread(:)
      real(dp) :: worst
      integer :: n

      call natural_modes(train, modes, error)
      allocate (slope, least, spread, mold=modes%natural_frequency)
      call all_parameters(train, names)
      call frequency_gradient(train, names, gradient, error)
      worst = 0
      do n = 1, size(names)
         if (gradient%reason(n) /= '') cycle
         call parameter_of(train, trim(names(n)), parameter, error)
         call find_slope()
         if (allocated(error)) cycle
         worst = max(worst, maxval(abs(gradient%values(:, n) - slope)/(exact*max(abs(slope), least) + spread)))
      end do
      call tests%is_close(worst, 0.0_dp, room, what//': natural frequencies as differences have them, over their errors')

   contains

      !> Differences of fourth order with the change that suits each frequency, where half the change alters them least: a low
      !> frequency has the rounding errors of the highest, and two frequencies that are close to one another bend away. The first
      !> change is a quarter of the distance between them. Their error is that of the next halving, which alters them more: the
      !> least alteration may be small by chance.
      subroutine find_slope()
         real(dp), dimension(size(modes%natural_frequency)) :: wide, narrow, before, now, off
         real(dp) :: relative, h
         logical :: begun(size(off)), better(size(off)), improved(size(off))
         integer :: halving

         relative = 4e-2_dp
         h = relative*merge(abs(parameter%value), 0.1_dp, abs(parameter%value) > 0)
         least = 1e-3_dp*modes%natural_frequency/merge(abs(parameter%value), 0.01_dp, abs(parameter%value) > 0)
         off = huge(off)
         better = .true.
         slope = sqrt(huge(slope))
         spread = 1
         before = slope
         call find_difference(h, wide)
         do halving = 1, 16
            if (allocated(error)) return
            call find_difference(h/2, narrow)
            now = (8*narrow - wide)/(6*h)
            begun = relative <= distance()/4
            improved = abs(now - before) < off
            where (begun)
               off = abs(now - before)
               where (better) spread = off
               better = better .and. improved
               where (better) slope = now
               before = now
            end where
            wide = narrow
            h = h/2
            relative = relative/2
         end do
      end subroutine find_slope

      !> Smallest distance of each natural frequency from another, relative; at most 1.
      function distance()
         real(dp) :: distance(size(modes%natural_frequency))
         integer :: i

         associate (omega => modes%natural_frequency)
            distance = [(minval(abs(omega - omega(i))/omega(i), mask=[(n /= i, n=1, size(omega))]), i=1, size(omega))]
         end associate
         distance = min(distance, 1.0_dp)
      end function distance

      !> Natural frequencies with the parameter greater by h less those with the parameter less by h.
      subroutine find_difference(h, difference)
         real(dp), intent(in) :: h
         real(dp), intent(out) :: difference(:)
         type(train_type) :: other
         type(modes_type) :: above, below

         difference = 0
         call change(train, parameter, h, other)
         call natural_modes(other, above, error)
         if (allocated(error)) return
         call change(train, parameter, -h, other)
         call natural_modes(other, below, error)
         if (.not. allocated(error)) difference = above%natural_frequency - below%natural_frequency
      end subroutine find_difference

   end subroutine compare_modes

   !> Where there is no derivative the reason is told, and nothing but NaN.
   subroutine nowhere(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(response_settings_type) :: settings
      type(branch_type) :: branch
      type(error_type), allocatable :: error
      type(gradient_type) :: gradient
      integer :: i

      train = paper_train()
      settings = settings_of(0.5_dp, 0.85_dp, 6)
      call response(train, settings, branch, error)
      do i = 1, size(branch%special_points)
         if (branch%special_points(i)%kind /= 'fold') cycle
         call motion_gradient(train, motion_of(branch, branch%special_points(i)%point), 'rms', ['input_torque'], gradient, error)
         call tests%is_true(all(ieee_is_nan(gradient%values)) .and. index(gradient%reason(1), 'fold') > 0, 'at a fold')
      end do
      call refused('mesh 3 stiffness', 'must tell which &mesh: 1 to 2')
      call refused('mesh 1 stifness', 'did you mean "stiffness"?')
      call refused('mesh 1 order', 'no continuous parameter')
      call refused('characteristic_length', 'a unit')
      call refused('mesh 1 stiffness_cos 2', 'a list')
      call refused('mesh 1 back_stiffness', 'not in force')
      call refused('shaft 1 damping', 'not in force')
      call refused('body 1 inertia', 'must begin with')
      call motion_gradient(train, motion_of(branch, 1), 'separation_fraction', ['input_torque'], gradient, error)
      call tests%is_true(allocated(error), 'separation fraction: refused')
      if (allocated(error)) call tests%is_true(index(error%message, 'no derivatives but of rms') > 0, 'separation fraction: told')
      ! A point that is none of its kind: the nearest one is another special point.
      branch%special_points(1)%kind = 'neimark-sacker'
      call special_gradient(train, branch, 1, ['input_torque'], gradient, error)
      call tests%is_true(all(ieee_is_nan(gradient%values)) .and. index(gradient%reason(1), 'Newton') > 0, 'no Neimark-Sacker point')
      branch%special_points(1)%kind = 'branch point'
      call special_gradient(train, branch, 1, ['input_torque'], gradient, error)
      call tests%is_true(allocated(error), 'branch point: refused')
      if (allocated(error)) call tests%is_true(index(error%message, 'but of a refined branch') > 0, 'branch point: told')
      train = ring()
      settings = settings_of(0.9_dp, 0.91_dp, 6)
      settings%max_points = 2
      call response(train, settings, branch, error)
      call motion_gradient(train, motion_of(branch, 1), 'rms', ['mesh 1 driven_radius'], gradient, error)
      call tests%is_true(index(gradient%reason(1), 'lock') > 0, 'gears lock')

   contains

      subroutine refused(name, words)
         character(*), intent(in) :: name, words

         call frequency_gradient(train, [name], gradient, error)
         call tests%is_true(allocated(error), name//': refused')
         if (allocated(error)) call tests%is_true(index(error%message, words) > 0, name//': '//error%message)
      end subroutine refused

   end subroutine nowhere

end module validation_gradient_special
