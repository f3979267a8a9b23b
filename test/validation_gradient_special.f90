!> Derivatives of special points and natural frequencies beside differences and closed forms; where there are none.
module validation_gradient_special
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use fixtures, only: paper_train, random_train, ring, settings_of, single_pair
   use geartrain, only: branch_type, dp, error_type, frequency_gradient, gradient_type, modes_type, motion_gradient, &
      natural_modes, response, response_settings_type, special_gradient, train_type
   use geartrain_base_numbers, only: integer_text
   use geartrain_continuation_points, only: motion_of
   use geartrain_model_parameter, only: parameter_type
   use networks, only: draw_laws, random_network
   use parameters_of_trains, only: all_parameters, change, name_length, parameter_of
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: gradient_special_tests

contains

   subroutine gradient_special_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('special_points')) call special_points(tests)
      if (tests%runs('modes')) call modes_of_trains(tests)
      if (tests%runs('nowhere')) call nowhere(tests)
   end subroutine gradient_special_tests

   !> Folds and period doublings: Lambda of the changed train beside the derivative.
   subroutine special_points(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(response_settings_type) :: settings
      integer :: i, found(2)

      found = 0
      call compare_special(tests, 'figure 3', paper_train(), settings_of(0.4_dp, 4.2_dp, 8), found)
      call compare_special(tests, 'pair', single_pair(0.05_dp, 0.3_dp, 0.4_dp), settings_of(0.3_dp, 3.0_dp, 10), found)
      do i = 1, 8
         call random_train(i, train, settings)
         call compare_special(tests, 'chain '//integer_text(i), train, settings, found)
      end do
      call tests%is_true(all(found >= [10, 4]), 'folds and period doublings compared: '//integer_text(found(1))//' and ' &
                         //integer_text(found(2)))
   end subroutine special_points

   subroutine compare_special(tests, what, train, settings, found)
      class(tests_type), intent(inout) :: tests
      character(*), intent(in) :: what
      type(train_type), intent(in) :: train
      type(response_settings_type), intent(in) :: settings
      integer, intent(inout) :: found(2)
      type(branch_type) :: branch
      type(error_type), allocatable :: error
      type(gradient_type) :: gradient, changed(4)
      type(parameter_type) :: parameter
      type(train_type) :: other
      character(name_length), allocatable :: names(:)
      real(dp) :: h, slope, off, worst
      integer :: i, k, n, kind

      call response(train, settings, branch, error)
      if (allocated(error)) return
      call all_parameters(train, names)
      do i = 1, size(branch%special_points)
         kind = findloc(['fold           ', 'period doubling'], branch%special_points(i)%kind, 1)
         if (kind == 0) cycle
         call special_gradient(train, settings, branch, i, names, gradient, error)
         worst = 0
         do n = 1, size(names)
            if (gradient%reason(n) /= '') cycle
            call parameter_of(train, trim(names(n)), parameter, error)
            h = 4e-4_dp*merge(abs(parameter%value), 0.1_dp, abs(parameter%value) > 0)
            do k = 1, 4
               call change(train, parameter, h*(3 - k - merge(1, 0, k > 2))/2, other)
               call special_gradient(other, settings, branch, i, names(:0), changed(k), error)
               if (allocated(error)) exit
            end do
            if (allocated(error)) cycle
            associate (l => changed%frequency_ratio)
               slope = (8*(l(2) - l(3)) - (l(1) - l(4)))/(6*h)
            end associate
            off = abs(gradient%values(1, n) - slope)/max(abs(slope), 1e-3_dp*gradient%frequency_ratio/max(abs(parameter%value), &
                                                                                                            1e3_dp*h))
            worst = max(worst, off)
            if (.not. off >= 0) worst = huge(worst)
         end do
         if (all(gradient%reason == '')) found(kind) = found(kind) + 1
         call tests%is_true(worst < 1e-6_dp, what//': '//trim(branch%special_points(i)%kind)//' as differences have it')
      end do
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
      do i = 1, 6
         call random_train(i, train, settings)
         call compare_modes(tests, 'chain '//integer_text(i), train)
         call random_network(4 + i, mod(i, 3), i, train)
         call draw_laws(i, train)
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
      type(modes_type) :: modes(4)
      type(gradient_type) :: gradient
      type(error_type), allocatable :: error
      type(parameter_type) :: parameter
      type(train_type) :: other
      character(name_length), allocatable :: names(:)
      real(dp), allocatable :: slope(:)
      real(dp) :: h, worst, off
      integer :: k, n

      call all_parameters(train, names)
      call frequency_gradient(train, names, gradient, error)
      worst = 0
      do n = 1, size(names)
         if (gradient%reason(n) /= '') cycle
         call parameter_of(train, trim(names(n)), parameter, error)
         h = 1e-3_dp*merge(abs(parameter%value), 0.1_dp, abs(parameter%value) > 0)
         do k = 1, 4
            call change(train, parameter, h*(3 - k - merge(1, 0, k > 2))/2, other)
            call natural_modes(other, modes(k), error)
            if (allocated(error)) exit
         end do
         if (allocated(error)) cycle
         slope = (8*(modes(2)%natural_frequency - modes(3)%natural_frequency) &
                  - (modes(1)%natural_frequency - modes(4)%natural_frequency))/(6*h)
         off = maxval(abs(gradient%values(:, n) - slope)/max(abs(slope), 1e-3_dp*modes(1)%natural_frequency &
                                                                             /max(abs(parameter%value), 1e2_dp*h)))
         worst = max(worst, off)
      end do
      call tests%is_true(worst < 1e-6_dp, what//': natural frequencies as differences have them')
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
      call refused('mesh 1 stiffness_cos', 'a list')
      call refused('mesh 1 back_stiffness', 'not in force')
      call refused('shaft 1 damping', 'not in force')
      call refused('body 1 inertia', 'must begin with')
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
