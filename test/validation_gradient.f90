!> Derivatives of the figures of motions by the implicit function theorem beside differences of whole solutions.
module validation_gradient
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use, intrinsic :: iso_fortran_env, only: int64
   use fixtures, only: body, long_train, paper_train, random_train, settings_of, uniform
   use geartrain, only: branch_type, dp, error_type, gradient_type, mesh_type, motion_gradient, motion_type, response, &
      response_settings_type, shaft_type, train_type
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_figure_rates, only: figure_names
   use geartrain_base_kinds, only: pi
   use geartrain_base_numbers, only: integer_text
   use geartrain_trace_branch, only: dense_coefficients
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_trace_points, only: motion_of
   use geartrain_trace_start, only: begin_trace, solution_of
   use geartrain_trace_tracer, only: tracer_type
   use geartrain_linalg_trigonometric, only: evaluate
   use geartrain_network_check_train, only: check_train
   use geartrain_network_parameter_table, only: parameter_type
   use networks, only: draw_laws, random_network
   use parameters_of_trains, only: all_parameters, change, name_length, parameter_of
   use testing, only: full, nightly, tests_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: gradient_tests

   !> Room for the largest of thousands of derivatives over their estimated errors.
   real(dp), parameter :: room = 30

contains

   subroutine gradient_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('figure_3')) call figure_3(tests)
      if (tests%runs('random_chains', full)) call random_chains(tests)
      if (tests%runs('random_networks', full)) call random_networks(tests)
      if (tests%runs('rigid_shafts_of_damped_bodies')) call rigid_shafts_of_damped_bodies(tests)
      if (tests%runs('random_rigid_shafts', full)) call random_rigid_shafts(tests)
      if (tests%runs('hunting')) call hunting(tests)
      if (tests%runs('drawing')) call drawing(tests)
   end subroutine gradient_tests

   !> Orders 3 and 7 with a torque of order 1; a motion of period 2.
   subroutine hunting(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train

      train = paper_train()
      train%meshes%order = [3, 7]
      call compare(tests, 'orders 3 and 7', train, settings_of(0.2_dp, 0.21_dp, 28))
      train = paper_train()
      train%meshes%order = [1, 2]
      train%torque_cos = [20.0_dp]
      call compare(tests, 'torque', train, settings_of(0.55_dp, 0.56_dp, 20))
   end subroutine hunting

   !> Numbers of the drawing, through the derivation.
   subroutine drawing(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      integer :: j

      train%input_torque = 300
      train%prime_mover_inertia = 0.02_dp
      train%load_inertia = 0.5_dp
      allocate (train%shafts(2), train%meshes(1))
      do j = 1, 2
         train%shafts(j)%diameter = [0.03_dp, 0.04_dp]
         train%shafts(j)%length = [0.1_dp, 0.12_dp]
         train%shafts(j)%damping_ratio = 0.02_dp
      end do
      associate (mesh => train%meshes(1))
         mesh%teeth = [23.0_dp, 71.0_dp]
         mesh%normal_module = 2.5e-3_dp
         mesh%helix_angle = 12
         mesh%face_width = 0.04_dp
         mesh%profile_shift = [0.2_dp, -0.1_dp]
         mesh%backlash = 8e-5_dp
         mesh%damping_ratio = 0.05_dp
         mesh%phase = 0.4_dp
      end associate
      call compare(tests, 'drawing', train, settings_of(900.0_dp, 905.0_dp, 10))
      train%input_torque = 60
      call compare(tests, 'light load', train, settings_of(900.0_dp, 905.0_dp, 10))
   end subroutine drawing

   subroutine figure_3(tests)
      class(tests_type), intent(inout) :: tests

      call compare(tests, 'figure 3 at 0.9', paper_train(), settings_of(0.9_dp, 0.91_dp, 12))
      call compare(tests, 'everything', long_train(4), settings_of(0.9_dp, 0.91_dp, 12))
   end subroutine figure_3

   subroutine random_chains(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(response_settings_type) :: settings
      integer :: i

      do i = 1, merge(12, 1, tests%tier(nightly))
         call random_train(i + 1000*tests%seed, train, settings)
         call compare(tests, 'chain '//integer_text(i), train, settings)
      end do
   end subroutine random_chains

   subroutine random_networks(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: bodies(*) = [4, 5, 6, 8, 10, 5, 8], loops(*) = [0, 1, 0, 2, 1, 0, 1], dragged(*) = [0, 0, 2, 0, 0, 1, 3]
      type(train_type) :: train
      integer :: i, j

      do i = 1, size(bodies)
         ! By day those of five bodies: one with a loop and drawn laws, one with a body that is dragged along.
         if (bodies(i) /= 5 .and. .not. tests%tier(nightly)) cycle
         call random_network(bodies(i), loops(i), i + 1000*tests%seed, train)
         if (mod(i, 2) == 0) call draw_laws(i + 1000*tests%seed, train)
         train%bodies(bodies(i) - dragged(i) + 1:)%damping_to_ground = [(0.3_dp*j, j=1, dragged(i))]
         ! Without idle gears, which may float in their gaps.
         do j = 2, bodies(i) - 1
            train%bodies(j)%torque = -2.0_dp*j
         end do
         if (i > 4 .and. size(train%shafts) > 0) train%shafts(1) = shaft_type(between=train%shafts(1)%between, rigid=.true.)
         call compare(tests, 'network '//integer_text(i), train, settings_of(0.8_dp, 0.81_dp, 10))
      end do
   end subroutine random_networks

   !> A rigid shaft bears what damping to ground takes from the vibration of two nodes: of the mesh's pinion and of its wheel.
   subroutine rigid_shafts_of_damped_bodies(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train

      train%characteristic_frequency = 1e4_dp
      train%bodies = [body('motor', 0.002_dp, 100.0_dp), body('pinion', 0.001_dp), body('wheel', 0.02_dp), body('fan', 0.03_dp), &
                      body('load', 0.05_dp, balances=.true.)]
      train%bodies([1, 3])%damping_to_ground = [1.0_dp, 2.0_dp]
      train%shafts = [shaft_type(between=[character(64) :: 'motor', 'pinion'], stiffness=2e4_dp, damping_ratio=0.02_dp), &
                      shaft_type(between=[character(64) :: 'wheel', 'fan'], rigid=.true.), &
                      shaft_type(between=[character(64) :: 'fan', 'load'], stiffness=1e5_dp)]
      train%meshes = [mesh_type(between=[character(64) :: 'pinion', 'wheel'], driving_radius=0.04_dp, driven_radius=0.08_dp, &
                                stiffness=2e8_dp, damping_ratio=0.05_dp, half_backlash=30e-6_dp)]
      ! Not above: gfortran 12 does not free an allocatable component of what is made within an array constructor.
      train%meshes(1)%stiffness_cos = [0.2_dp]
      train%characteristic_length = 30e-6_dp
      call compare(tests, 'two damped nodes', train, settings_of(0.51_dp, 0.52_dp, 20))
      ! The damping of two equal bodies on a rigid shaft does not load it: its gain is 0, the derivative of the gain is not.
      train%bodies(4) = train%bodies(3)
      train%bodies(4)%name = 'fan'
      call compare(tests, 'two equal bodies', train, settings_of(0.51_dp, 0.52_dp, 12))
   end subroutine rigid_shafts_of_damped_bodies

   !> Discs on rigid shafts at two bodies of a random network, one of them on a shaft of two parts, nearly all bodies damped.
   subroutine random_rigid_shafts(tests)
      class(tests_type), intent(inout) :: tests
      integer :: i

      do i = 1, merge(40, 1, tests%tier(nightly))
         call compare_discs(i, tests%seed)
      end do
      ! A damping that is 0 couples meshes where it is not: their receptance has more entries.
      call compare_discs(3, 20)
      ! A wall is nearer to the motion than a half backlash changes by for its differences: 196 came out for a derivative of 0.
      call compare_discs(24, 4)

   contains

      subroutine compare_discs(i, seed)
         integer, intent(in) :: i, seed
         type(train_type) :: train
         integer(int64) :: generator
         integer :: j, n

         n = 3 + mod(i, 5)
         call random_network(n, mod(i, 2), i + 1000*seed, train)
         if (mod(i, 3) == 0) call draw_laws(i + 1000*seed, train)
         generator = 31*i + 1000*seed
         ! Without idle gears, which may float in their gaps.
         do j = 2, n - 1
            train%bodies(j)%torque = -2.0_dp*j
         end do
         do j = 1, 3
            train%bodies = [train%bodies, body('disc '//integer_text(j), uniform(generator, 1e-3_dp, 5e-3_dp))]
         end do
         train%shafts = [train%shafts, rigid(train%bodies(2)%name, 'disc 1'), rigid('disc 2', train%bodies(n - 1)%name), &
                         rigid('disc 2', 'disc 3')]
         do j = 1, size(train%bodies)
            if (uniform(generator, 0.0_dp, 1.0_dp) < 0.8_dp) train%bodies(j)%damping_to_ground = uniform(generator, 0.1_dp, 2.0_dp)
         end do
         call compare(tests, 'discs '//integer_text(i), train, settings_of(0.8_dp, 0.81_dp, 10), cancels=.true.)
      end subroutine compare_discs

      pure type(shaft_type) function rigid(first, second)
         character(*), intent(in) :: first, second

         rigid%between = [character(64) :: first, second]
         rigid%rigid = .true.
      end function rigid

   end subroutine random_rigid_shafts

   !> All figures by all parameters at the first point of a response.
   subroutine compare(tests, what, train, settings, cancels)
      class(tests_type), intent(inout) :: tests
      character(*), intent(in) :: what
      type(train_type), intent(in) :: train
      type(response_settings_type), intent(in) :: settings
      !> Some bodies bear no torque: the torque of a shaft to them is a sum that cancels, whose error is that of its terms, the
      !> torques of other bodies.
      logical, intent(in), optional :: cancels
      type(response_settings_type) :: plain
      type(branch_type) :: branch
      type(error_type), allocatable :: error
      type(motion_type) :: motion
      type(gradient_type) :: gradient
      type(parameter_type) :: parameter
      character(name_length), allocatable :: names(:)
      !> Error of a derivative of the library [1]: rounding over the relative change of its differences (network/gradient.f90), of
      !> what the figure changes by with the parameter, in proportion, that changes it most. What makes the figure, as the forces at
      !> rest, has that error, whichever parameter it follows.
      real(dp), parameter :: exact = epsilon(1.0_dp)/3e-6_dp
      real(dp), allocatable :: coarse(:, :), middle(:, :), fine(:, :), finest(:, :), value(:, :), derivative(:, :, :), &
                               share(:, :, :)
      real(dp) :: h, off, worst, size_of, apart
      integer :: f, i, n
      logical :: ok(4)

      plain = settings
      plain%stability = .false.
      plain%max_points = 2
      call response(train, plain, branch, error)
      call tests%is_true(.not. allocated(error) .and. branch%points > 0 .or. tests%seed > 0, what//': a motion')
      if (allocated(error) .or. branch%points == 0) return
      motion = motion_of(branch, 1)
      call all_parameters(train, names)
      call figures_of(train, plain, motion, value, ok(1))
      allocate (derivative(size(value, 1), size(figure_names), size(names)), source=0.0_dp)
      do f = 1, size(figure_names)
         call motion_gradient(train, motion, trim(figure_names(f)), names, gradient, error)
         if (allocated(error)) exit
         derivative(:size(gradient%values, 1), f, :) = gradient%values
      end do
      call tests%is_true(.not. allocated(error), what//': a gradient')
      if (allocated(error)) return
      allocate (share, source=derivative)
      do n = 1, size(names)
         call parameter_of(train, trim(names(n)), parameter, error)
         share(:, :, n) = derivative(:, :, n)*parameter%value
      end do
      where (ieee_is_nan(share)) share = 0
      worst = 0
      do n = 1, size(names)
         call parameter_of(train, trim(names(n)), parameter, error)
         h = 1e-4_dp*merge(abs(parameter%value), 0.1_dp, abs(parameter%value) > 0)
         if (index(names(n), 'error') > 0 .and. .not. abs(parameter%value) > 0) h = 1e-10_dp
         call difference(train, plain, motion, parameter, h, coarse, ok(1))
         call difference(train, plain, motion, parameter, h/2, middle, ok(2))
         call difference(train, plain, motion, parameter, h/4, fine, ok(3))
         call difference(train, plain, motion, parameter, h/8, finest, ok(4))
         if (.not. all(ok)) cycle
         ! Thrice extrapolated to h = 0: how far they are apart tells the error of the differences. Two may agree by chance.
         coarse = (4*middle - coarse)/3
         middle = (4*fine - middle)/3
         finest = (4*finest - fine)/3
         do f = 1, size(figure_names)
            do i = 1, size(value, 1)
               associate (g => derivative(i, f, n))
                  if (ieee_is_nan(value(i, f)) .or. ieee_is_nan(g)) cycle
                  ! Without a static force either direction counts.
                  if (f >= 5 .and. f <= 6 .and. .not. abs(value(i, f)) > 0) cycle
                  size_of = max(maxval(abs(share(i, f, :)))/max(abs(parameter%value), 1e3_dp*h), tiny(h))
                  if (present(cancels) .and. f >= 7) &
                     size_of = max(size_of, maxval(abs(train%bodies%torque))/max(abs(parameter%value), 1e3_dp*h))
                  apart = max(abs(middle(i, f) - coarse(i, f)), abs(finest(i, f) - middle(i, f)))
                  off = abs(g - middle(i, f))/(exact*size_of + apart)
                  worst = max(worst, off)
               end associate
            end do
         end do
      end do
      call tests%is_close(worst, 0.0_dp, room, what//': derivatives as differences have them, over their errors')
   end subroutine compare

   !> Central difference of all figures.
   subroutine difference(train, settings, motion, parameter, h, slope, ok)
      type(train_type), intent(in) :: train
      type(response_settings_type), intent(in) :: settings
      type(motion_type), intent(in) :: motion
      type(parameter_type), intent(in) :: parameter
      real(dp), intent(in) :: h
      real(dp), allocatable, intent(out) :: slope(:, :)
      logical, intent(out) :: ok
      type(train_type) :: changed
      real(dp), allocatable :: above(:, :), below(:, :)
      logical :: side

      call change(train, parameter, h, changed)
      call figures_of(changed, settings, motion, above, ok)
      call change(train, parameter, -h, changed)
      call figures_of(changed, settings, motion, below, side)
      ok = ok .and. side
      if (.not. (allocated(above) .and. allocated(below))) return
      slope = (above - below)/(2*h)
   end subroutine difference

   !> Figures of the balance's solution near a motion, as a branch has them, (mesh or shaft, figure).
   subroutine figures_of(train, settings, motion, value, ok)
      type(train_type), intent(in) :: train
      type(response_settings_type), intent(in) :: settings
      type(motion_type), intent(in) :: motion
      real(dp), allocatable, intent(out) :: value(:, :)
      logical, intent(out) :: ok
      type(system_type), target :: systems(2)
      type(tracer_type) :: tracer
      type(solution_point_type) :: solution
      type(branch_type) :: found
      type(error_type), allocatable :: error
      real(dp) :: largest
      integer :: i, side

      ! Another radius or number of a loop would lock its gears.
      call check_train(train, error)
      ok = .not. allocated(error)
      if (.not. ok) return
      call begin_trace(train, settings, systems, tracer)
      solution = solution_of(tracer, motion)
      ! Torques are made of forces that lag the coefficients by a Newton step: by 5e-13 after the second solution, which differences
      ! see, by rounding alone after the third.
      do i = 1, 3
         call tracer%corrector%solve_at(solution, ok)
         if (.not. ok) return
      end do
      call tracer%corrector%orient(solution, 1)
      call tracer%recorder%setup(tracer%corrector%balance, .false., found, shaft_torque=.true.)
      call tracer%record(solution, found)
      allocate (value(max(found%meshes, found%shafts), size(figure_names)), source=0.0_dp)
      associate (m => found%meshes, s => found%shafts)
         value(:m, 1) = found%rms(:, 1)
         value(:m, 2) = found%mean(:, 1)
         value(:m, 3) = found%minimum(:, 1)
         value(:m, 4) = found%maximum(:, 1)
         do i = 1, m
            associate (system => tracer%corrector%balance%system, static => found%mesh_load(i, 1))
               if (.not. abs(system%static_force(system%mesh_element(i))) > 0) cycle
               side = merge(-1, 1, system%static_force(system%mesh_element(i)) < 0)
               call find_largest(tracer%corrector%balance, i, dense_coefficients(found, found%coefficients(:, :, 1)), side, largest)
               value(i, 5) = largest*system%stiffness(system%mesh_element(i))*train%characteristic_length
               value(i, 6) = largest/abs(system%static_force(system%mesh_element(i)))
               ok = ok .and. abs(value(i, 5) - static%force_maximum) <= 1e-6_dp*abs(value(i, 5))
            end associate
         end do
         value(:s, 7) = found%shaft_torque_mean(:, 1)
         value(:s, 8) = found%shaft_torque_minimum(:, 1)
         value(:s, 9) = found%shaft_torque_maximum(:, 1)
      end associate
   end subroutine figures_of

   !> The largest force of a mesh, in the direction of a side: golden section about the best of many samples. The branch has it to
   !> 1e-8 only. Where the damping jumps, the sides of the contact events count as well.
   subroutine find_largest(balance, mesh, coefficients, side, largest)
      type(balance_type), intent(in) :: balance
      integer, intent(in) :: mesh
      real(dp), intent(in) :: coefficients(:, :)
      integer, intent(in) :: side
      real(dp), intent(out) :: largest
      real(dp), parameter :: golden = 0.6180339887498949_dp
      integer, parameter :: samples = 4096, by_place = huge(1)
      real(dp) :: a, b, c, d, phi(0:2), p(0:3)
      integer, allocatable :: harmonic(:)
      integer :: best, i, k, s

      harmonic = [(k, k=1, size(coefficients, 1)/2)]
      best = maxloc([(side*force(2*pi*k/samples, by_place), k=1, samples)], 1)
      a = 2*pi*(best - 1)/samples
      b = 2*pi*(best + 1)/samples
      do i = 1, 60
         c = b - golden*(b - a)
         d = a + golden*(b - a)
         if (side*force(c, by_place) > side*force(d, by_place)) then
            b = d
         else
            a = c
         end if
      end do
      largest = side*force((a + b)/2, by_place)
      if (.not. balance%system%law(mesh)%jumps) return
      associate (contact => balance%contact(findloc(balance%mesh, mesh, 1)))
         do i = 1, contact%events
            largest = max(largest, side*force(contact%instant(i), contact%contact(i)), &
                          side*force(contact%instant(i), contact%contact(merge(i, contact%events + 1, i > 1) - 1)))
         end do
      end associate

   contains

      real(dp) function force(theta, region)
         real(dp), intent(in) :: theta
         integer, intent(in) :: region

         call evaluate(coefficients(:, mesh), harmonic, theta, p(0), p(1), p(2), p(3))
         s = region
         associate (law => balance%system%law(mesh))
            if (region == by_place) s = law%region_at(p(0))
            call law%along(s, balance%eta, theta, balance%frequency_ratio, p, phi)
         end associate
         force = phi(0)
      end function force

   end subroutine find_largest

end module validation_gradient
