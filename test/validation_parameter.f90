!> Branches over a parameter of the train at constant speed against responses of the train with each value, and closed forms.
module validation_parameter
   use branches_over_parameters, only: compare, over
   use fixtures, only: linear_pair, long_train, paper_train, random_train, ring, settings_of, single_pair
   use geartrain, only: branch_type, case_type, dp, error_type, folds, gradient_type, motion_gradient, motion_type, &
      period_doubled, read_case, refine, refine_branch, response, response_settings_type, train_type
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_network_parameter, only: largest_variation
   use geartrain_trace_points, only: motion_of
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: parameter_tests

contains

   subroutine parameter_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('torque')) call torque(tests)
      if (tests%runs('every_kind')) call every_kind(tests)
      if (tests%runs('random')) call random(tests)
      if (tests%runs('closed_forms')) call closed_forms(tests)
      if (tests%runs('fold')) call fold(tests)
      if (tests%runs('estimate')) call estimate(tests)
      if (tests%runs('slopes')) call slopes(tests)
      if (tests%runs('doubling')) call doubling(tests)
      if (tests%runs('drawing')) call drawing(tests)
      if (tests%runs('constant')) call constant(tests)
      if (tests%runs('ends')) call ends(tests)
   end subroutine parameter_tests

   !> A single pair over its torque: some points.
   subroutine torque(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(train_type) :: train
      integer :: i

      train = single_pair(0.05_dp, 0.2_dp, 0.5_dp)
      branch = over(tests, train, 'input_torque', 0.05_dp, 1.0_dp, 0.9_dp, 8)
      if (branch%points == 0) return
      call tests%is_true(branch%parameter == 'input_torque' .and. branch%parameter_unit == 'N m', 'name and unit')
      call tests%is_close(branch%frequency_ratio(1), 0.05_dp, 0.0_dp, 'begins at from')
      do i = 1, branch%points, max(1, branch%points/8)
         train%input_torque = branch%frequency_ratio(i)
         call compare(tests, train, branch, i, 'torque')
      end do
   end subroutine torque

   !> Every kind of parameter of a train that has everything.
   subroutine every_kind(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: branch
      character(*), parameter :: name(*) = [character(24) :: 'input_torque', 'mesh 1 half_backlash', 'mesh * damping_ratio', &
         'shaft 1 stiffness', 'shaft 3 damping_ratio', 'stiffness_variation', 'mesh 1 error_sin 2', 'torque_sin 1', &
         'load_inertia', 'mesh 2 stiffness', 'mesh 1 driving_radius', 'mesh 1 driven_inertia', 'mesh 1 phase', &
         'mesh 1 stiffness_cos 2']
      real(dp), parameter :: from(*) = [60.0_dp, 10e-6_dp, 0.03_dp, 1e5_dp, 0.01_dp, 0.06_dp, -1e-6_dp, -8.0_dp, 0.01_dp, 2e8_dp, &
                                        0.05_dp, 0.008_dp, 0.0_dp, -0.03_dp]
      real(dp), parameter :: to(*) = [160.0_dp, 40e-6_dp, 0.09_dp, 4e5_dp, 0.05_dp, 0.2_dp, 1e-6_dp, 8.0_dp, 0.03_dp, 4e8_dp, &
                                      0.06_dp, 0.015_dp, 1.0_dp, 0.05_dp]
      integer :: n, i, j

      do n = 1, size(name)
         train = long_train(3)
         branch = over(tests, train, trim(name(n)), from(n), to(n), 0.55_dp, 6)
         if (branch%points == 0) cycle
         do j = 0, 2
            i = 1 + (j*(branch%points - 1))/2
            train = long_train(3)
            associate (value => branch%frequency_ratio(i), mesh => train%meshes(1))
               select case (name(n))
               case ('input_torque')
                  train%input_torque = value
               case ('mesh 1 half_backlash')
                  mesh%half_backlash = value
               case ('mesh * damping_ratio')
                  train%meshes%damping_ratio = value
               case ('shaft 1 stiffness')
                  train%shafts(1)%stiffness = value
               case ('shaft 3 damping_ratio')
                  train%shafts(3)%damping_ratio = value
               case ('stiffness_variation')
                  ! The largest amplitude of long_train: |0.12 - 0.05 i|.
                  mesh%stiffness_cos = value/0.13_dp*mesh%stiffness_cos
                  mesh%stiffness_sin = value/0.13_dp*mesh%stiffness_sin
               case ('mesh 1 error_sin 2')
                  mesh%error_sin(2) = value
               case ('torque_sin 1')
                  train%torque_sin(1) = value
               case ('load_inertia')
                  train%load_inertia = value
               case ('mesh 2 stiffness')
                  train%meshes(2)%stiffness = value
               case ('mesh 1 driving_radius')
                  mesh%driving_radius = value
               case ('mesh 1 driven_inertia')
                  mesh%driven_inertia = value
               case ('mesh 1 phase')
                  mesh%phase = value
               case ('mesh 1 stiffness_cos 2')
                  mesh%stiffness_cos(2) = value
               end select
            end associate
            call compare(tests, train, branch, i, trim(name(n)))
         end do
      end do
   end subroutine every_kind

   !> Random trains over their torque and over the damping of all meshes.
   subroutine random(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train, changed
      type(response_settings_type) :: settings
      type(branch_type) :: branch
      integer :: seed, j

      do seed = 1, 5
         call random_train(seed + 1000*tests%seed, train, settings)
         branch = over(tests, train, 'input_torque', 0.7_dp*train%input_torque, 1.3_dp*train%input_torque, settings%start, &
                       settings%harmonics)
         do j = 1, branch%points, max(1, branch%points/3)
            ! At a fold the motion is no function of the torque, nor of Lambda: rounding moves it by its root.
            if (abs(branch%free_slope(j)) < 1e-3_dp*maxval(abs(branch%free_slope(:branch%points)))) cycle
            changed = train
            changed%input_torque = branch%frequency_ratio(j)
            call compare(tests, changed, branch, j, 'random, torque')
         end do
         branch = over(tests, train, 'mesh * damping_ratio', 0.02_dp, 0.08_dp, settings%start, settings%harmonics)
         do j = 1, branch%points, max(1, branch%points/3)
            changed = train
            changed%meshes%damping_ratio = branch%frequency_ratio(j)
            call compare(tests, changed, branch, j, 'random, damping')
         end do
      end do
   end subroutine random

   !> x'' + 2 zeta x' + x = f + e cos Lambda t without backlash: the amplitude is e over |1 - Lambda^2 + 2 i zeta Lambda|.
   subroutine closed_forms(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(train_type) :: train
      complex(dp) :: response_factor
      integer :: i

      ! A torque of 1 N m gives 0.5 (geartrain's linear_pair).
      train = linear_pair(0.5_dp)
      branch = over(tests, train, 'torque_cos', 0.0_dp, 2.0_dp, 0.8_dp, 3)
      response_factor = 1/cmplx(1 - 0.64_dp, 2*0.1_dp*0.8_dp, dp)
      do i = 1, branch%points
         call tests%is_close(branch%rms(1, i), 0.5_dp*branch%frequency_ratio(i)*abs(response_factor), 1e-12_dp, 'linear in torque')
      end do
      branch = over(tests, train, 'mesh 1 damping_ratio', 0.0_dp, 0.3_dp, 0.8_dp, 3)
      do i = 1, branch%points
         call tests%is_close(branch%rms(1, i), &
                             0.5_dp/abs(cmplx(1 - 0.64_dp, 2*branch%frequency_ratio(i)*0.8_dp, dp)), 1e-12_dp, 'damping')
      end do
      ! In contact with a small variation, which goes to 0: the motion goes to rest.
      train = single_pair(0.05_dp, 0.2_dp, 0.5_dp)
      branch = over(tests, train, 'stiffness_variation', 0.2_dp, 0.0_dp, 0.4_dp, 6)
      if (branch%points > 0) then
         call tests%is_close(branch%frequency_ratio(branch%points), 0.0_dp, 0.0_dp, 'kappa = 0')
         call tests%is_close(branch%rms(1, branch%points), 0.0_dp, 1e-12_dp, 'kappa = 0: at rest')
         call tests%is_close(branch%mean(1, branch%points), 1.5_dp, 1e-12_dp, 'kappa = 0: on the flank')
      end if
      ! The backlash goes to 0: then the pair is linear.
      train = linear_pair(0.1_dp)
      train%meshes(1)%half_backlash = 1
      branch = over(tests, train, 'mesh 1 half_backlash', 0.5_dp, 0.0_dp, 0.8_dp, 9)
      if (branch%points > 0) then
         call tests%is_close(branch%rms(1, branch%points), 0.5_dp*abs(response_factor), 1e-11_dp, 'no backlash')
         call tests%is_close(branch%mean(1, branch%points), 0.1_dp, 1e-11_dp, 'no backlash: mean')
         call tests%is_close(branch%mesh_load(1, branch%points)%separation, 0.0_dp, 0.0_dp, 'no backlash: no separation')
      end if
   end subroutine closed_forms

   !> A single pair, driven by its stiffness and by its torque, just below its resonance.
   function driven_pair() result(train)
      type(train_type) :: train

      train = single_pair(0.05_dp, 0.2_dp, 0.5_dp)
      train%torque_cos = [0.1_dp]
   end function driven_pair

   !> A train with a value of the torque, the largest stiffness variation or the damping ratio.
   function with_value(name, value) result(train)
      character(*), intent(in) :: name
      real(dp), intent(in) :: value
      type(train_type) :: train

      train = driven_pair()
      if (name == 'input_torque') train%input_torque = value
      if (name == 'stiffness_variation') train%meshes(1)%stiffness_cos = [value]
      if (name == 'mesh 1 damping_ratio') train%meshes(1)%damping_ratio = value
      if (name == 'mesh 1 half_backlash') train%meshes(1)%half_backlash = value
   end function with_value

   !> Where the branch over a parameter turns, the response over Lambda of the train with this value turns at the Lambda of the
   !> branch: dS/du is singular for either. From the other end the folds are the same.
   subroutine fold(tests)
      class(tests_type), intent(inout) :: tests

      call turns('input_torque', 0.05_dp, 1.0_dp, 0.9_dp)
      call turns('stiffness_variation', 0.0_dp, 0.3_dp, 0.9_dp)
      call turns('mesh 1 damping_ratio', 0.02_dp, 0.1_dp, 0.95_dp)

   contains

      subroutine turns(name, from, to, frequency)
         character(*), intent(in) :: name
         real(dp), intent(in) :: from, to, frequency
         type(branch_type) :: branch, back, near
         type(motion_type) :: motion
         type(error_type), allocatable :: error
         real(dp), allocatable :: at(:), there(:)
         integer :: i, side

         branch = over(tests, driven_pair(), name, from, to, frequency, 9)
         back = over(tests, driven_pair(), name, to, from, frequency, 9)
         at = folds(branch)
         call tests%is_true(size(at) == 2 .and. size(folds(back)) == 2, name//': two folds')
         if (size(at) /= 2 .or. size(folds(back)) /= 2) return
         call tests%is_close(maxval(abs(folds(back) - at)/at), 0.0_dp, 1e-9_dp, name//': the same folds from the other end')
         do i = 1, size(branch%special_points)
            associate (special => branch%special_points(i))
               if (special%kind /= 'fold') cycle
               motion = motion_of(branch, special%point)
               ! Newton's method fails at the fold itself: the seed is solved next to it, on the side where there are motions.
               do side = -1, 1, 2
                  motion%frequency_ratio = (1 + side*1e-3_dp)*frequency
                  call response(with_value(name, special%frequency_ratio), &
                                settings_of(0.98_dp*frequency, 1.02_dp*frequency, 9), near, error, seed=motion)
                  if (allocated(error)) exit
                  if (size(folds(near)) > 0) exit
               end do
               call tests%is_true(.not. allocated(error), name//': a response')
               if (allocated(error)) cycle
               there = folds(near)
               call tests%is_true(size(there) > 0, name//': a fold over Lambda')
               if (size(there) > 0) call tests%is_close(minval(abs(there - frequency)), 0.0_dp, 1e-9_dp, name//': at this Lambda')
            end associate
         end do
      end subroutine turns

   end subroutine fold

   !> The error estimate against motions of the same trains with many more harmonics; derivatives against slopes of the branch.
   subroutine estimate(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch, exact
      type(motion_type) :: motion, finer
      type(error_type), allocatable :: error
      real(dp), allocatable :: fine(:, :), coarse(:, :)
      real(dp) :: ratio
      integer :: i, k, checked

      branch = over(tests, driven_pair(), 'stiffness_variation', 0.1_dp, 0.3_dp, 0.9_dp, 4)
      checked = 0
      do i = 2, branch%points - 1
         if (branch%estimate_doubtful(i) .or. branch%error_estimate(i) < 1e-9_dp) cycle
         motion = motion_of(branch, i)
         motion%frequency_ratio = branch%constant_frequency
         call response(with_value('stiffness_variation', branch%frequency_ratio(i)), settings_of(0.8999_dp, 0.9001_dp, 40), exact, &
                       error, seed=motion)
         if (exact%points == 0) cycle
         k = minloc(abs(exact%frequency_ratio(:exact%points) - 0.9_dp), 1)
         finer = motion_of(exact, k)
         fine = finer%coefficients
         coarse = 0*fine
         coarse(:size(motion%coefficients, 1), :) = motion%coefficients
         ratio = sqrt(2*sum((fine(1, :) - coarse(1, :))**2) + sum((fine(2:, :) - coarse(2:, :))**2))/norm2(coarse(2:, :)) &
                 /branch%error_estimate(i)
         ! The estimate is of first order in the error; near a fold of this branch the motion at the same value is far.
         if (ratio > 1.5_dp .or. ratio < 1/1.5_dp) call tests%is_close(ratio, 1.0_dp, 0.5_dp, 'error over estimate')
         checked = checked + 1
      end do
      call tests%is_true(checked > 8, 'estimates were checked')
   end subroutine estimate

   !> Derivatives of motions are the slopes along the branch.
   subroutine slopes(tests)
      class(tests_type), intent(inout) :: tests
      character(*), parameter :: name(*) = [character(24) :: 'input_torque', 'stiffness_variation', 'mesh 1 damping_ratio', &
                                            'mesh 1 half_backlash']
      real(dp), parameter :: value(*) = [0.4_dp, 0.25_dp, 0.06_dp, 0.8_dp]
      type(branch_type) :: branch
      type(motion_type) :: motion
      type(gradient_type) :: gradient
      type(error_type), allocatable :: error
      type(train_type) :: train
      real(dp) :: h
      integer :: n

      do n = 1, size(name)
         h = 1e-4_dp*value(n)
         branch = over(tests, with_value(trim(name(n)), value(n)), trim(name(n)), value(n) - h, value(n) + h, 0.95_dp, 9)
         if (branch%points == 0) cycle
         train = with_value(trim(name(n)), value(n))
         motion = motion_of(branch, (1 + branch%points)/2)
         motion%frequency_ratio = 0.95_dp
         call motion_gradient(train, motion, 'rms', [trim(name(n))], gradient, error)
         call tests%is_true(.not. allocated(error), 'a gradient')
         if (allocated(error)) cycle
         call tests%is_close((branch%rms(1, branch%points) - branch%rms(1, 1))/(2*h), gradient%values(1, 1), &
                             1e-6_dp*(1 + abs(gradient%values(1, 1))), trim(name(n))//': slope')
      end do
   end subroutine slopes

   !> A period doubling over the stiffness variation: the train with this value has a multiplier -1. The branch of twice the period
   !> and refined points are those of the trains by themselves.
   subroutine doubling(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch, near, twice
      type(motion_type) :: motion
      type(error_type), allocatable :: error
      type(response_settings_type) :: settings
      integer :: i, k

      branch = over(tests, driven_pair(), 'stiffness_variation', 0.1_dp, 0.5_dp, 1.9_dp, 9)
      k = findloc(branch%special_points%kind, 'period doubling', 1)
      call tests%is_true(k > 0, 'a period doubling')
      if (k == 0) return
      associate (special => branch%special_points(k))
         motion = motion_of(branch, special%point)
         motion%frequency_ratio = 1.9_dp
         call response(with_value('stiffness_variation', special%frequency_ratio), settings_of(1.899_dp, 1.901_dp, 9), near, &
                       error, seed=motion)
         i = minloc(abs(near%frequency_ratio(:near%points) - 1.9_dp), 1)
         call tests%is_close(minval(abs(near%multipliers(:, i) + 1)), 0.0_dp, 1e-6_dp, 'a multiplier -1')
      end associate
      settings = settings_of(0.1_dp, 0.5_dp, 9)
      settings%parameter = 'stiffness_variation'
      settings%frequency = 1.9_dp
      call period_doubled(driven_pair(), settings, branch, k, twice, error)
      call tests%is_true(.not. allocated(error) .and. twice%points > 5, 'the branch of twice the period')
      if (allocated(error) .or. twice%points == 0) return
      ! Below separation the equations are linear: motions of every amplitude lie at the value of the doubling, none is isolated.
      do i = findloc(twice%mesh_load(1, :twice%points)%separation > 1e-3_dp, .true., 1), twice%points, max(1, twice%points/3)
         call compare(tests, with_value('stiffness_variation', twice%frequency_ratio(i)), twice, i, 'twice the period')
      end do
      call refine_branch(driven_pair(), branch, error)
      call tests%is_true(.not. allocated(error), 'refined')
      i = branch%points/2
      call tests%is_true(branch%correction(i) > 0 .and. branch%correction(i) < 1e-3_dp, 'a correction')
      motion = motion_of(branch, i)
      motion%frequency_ratio = 1.9_dp
      call refine(with_value('stiffness_variation', branch%frequency_ratio(i)), motion, error)
      call tests%is_close(motion%rms(1), branch%rms(1, i), 1e-11_dp, 'a refined point is an orbit')
   end subroutine doubling

   !> Parameters of a drawing, and what follows from it, against the train described with the value.
   subroutine drawing(tests)
      class(tests_type), intent(inout) :: tests
      character(*), parameter :: name(*) = [character(24) :: 'motor torque', 'mesh 1 backlash', 'mesh 1 stiffness', &
                                            'stiffness_variation']
      real(dp), parameter :: from(*) = [60.0_dp, 40e-6_dp, 6e8_dp, 0.02_dp], to(*) = [140.0_dp, 80e-6_dp, 9e8_dp, 0.2_dp]
      type(case_type) :: case
      type(train_type) :: train, plain
      type(branch_type) :: branch
      type(error_type), allocatable :: error
      integer :: i, j, n

      call read_case('namelists/reducer.nml', case, error)
      call tests%is_true(.not. allocated(error), 'a drawing')
      if (allocated(error)) return
      call plain_train(case%train, plain)
      do n = 1, size(name)
         ! Lambda is the speed in rpm.
         branch = over(tests, case%train, trim(name(n)), from(n), to(n), 1500.0_dp, 75)
         if (branch%points == 0) cycle
         i = branch%points/2
         train = case%train
         associate (value => branch%frequency_ratio(i), mesh => train%meshes(1))
            select case (name(n))
            case ('motor torque')
               train%bodies(1)%torque = value
            case ('mesh 1 backlash')
               mesh%backlash = value
            case ('mesh 1 stiffness')
               mesh%stiffness = value
            case ('stiffness_variation')
               do j = 1, 2
                  train%meshes(j)%stiffness_cos = value/largest_variation(plain%meshes)*plain%meshes(j)%stiffness_cos
               end do
            end select
         end associate
         call compare(tests, train, branch, i, trim(name(n)))
      end do
   end subroutine drawing

   !> Over the backlash of a mesh whose teeth never part the rms is constant but for rounding, in which no peak is looked for: the
   !> branch has as many points as one over a torque.
   subroutine constant(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch

      branch = over(tests, paper_train(), 'mesh 2 half_backlash', 10e-6_dp, 40e-6_dp, 0.7_dp, 9)
      call tests%is_true(branch%complete .and. branch%points <= 15, 'constant motion: no points in rounding')
      call tests%is_close(maxval(abs(branch%rms(:, :branch%points)/spread(branch%rms(:, 1), 2, branch%points) - 1)), 0.0_dp, &
                          1e-12_dp, 'constant motion: rms')
   end subroutine constant

   !> What is refused, and that a branch ends at the end of the range of its parameter.
   subroutine ends(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: grounded

      call refused(driven_pair(), 'mesh 1 damping_ratio', -0.1_dp, 0.1_dp, 0.9_dp, 'must be >= 0')
      call refused(driven_pair(), 'mesh 1 damping', 0.0_dp, 0.1_dp, 0.9_dp, 'not given')
      call refused(driven_pair(), 'input_torqe', 0.1_dp, 0.2_dp, 0.9_dp, 'did you mean "input_torque"?')
      call refused(driven_pair(), 'mesh 2 stiffness', 0.1_dp, 0.2_dp, 0.9_dp, 'must tell which &mesh')
      call refused(driven_pair(), 'mesh 1 order', 1.0_dp, 2.0_dp, 0.9_dp, 'no continuous parameter')
      call refused(driven_pair(), 'input_torque', 0.1_dp, 0.2_dp, 0.0_dp, 'frequency')
      call refused(driven_pair(), 'mesh 1 pressure_angle', 15.0_dp, 20.0_dp, 0.9_dp, 'not in force')
      call refused(driven_pair(), 'input_torque', 0.1_dp, 0.1_dp, 0.9_dp, 'must differ')
      call refused(driven_pair(), '', -0.1_dp, 0.1_dp, 0.0_dp, 'must be > 0')
      grounded = ring()
      grounded%bodies(2)%damping_to_ground = 0.1_dp
      call refused(grounded, 'body 2 damping_to_ground', 0.0_dp, 1.0_dp, 1.0_dp, 'of another kind')

   contains

      subroutine refused(train, parameter, from, to, frequency, words)
         type(train_type), intent(in) :: train
         character(*), intent(in) :: parameter, words
         real(dp), intent(in) :: from, to, frequency
         type(response_settings_type) :: settings
         type(branch_type) :: branch
         type(error_type), allocatable :: error

         settings = settings_of(from, to, 6)
         settings%parameter = parameter
         settings%frequency = frequency
         call response(train, settings, branch, error)
         call tests%is_true(allocated(error), parameter//': refused')
         if (.not. allocated(error)) return
         if (index(error%message, words) == 0) call tests%is_text(error%message, words, parameter//': words')
      end subroutine refused

   end subroutine ends

end module validation_parameter
