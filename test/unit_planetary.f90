!> Planetary sets in short form: what they expand to, how planets share the load at rest, and their symmetry.
module unit_planetary
   use fixtures, only: planetary_stage
   use geartrain, only: dp, error_type, train_type
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_bordered_system, only: bordered_system_type
   use geartrain_balance_fixed_space, only: fixed_space_type
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_planet_orbits, only: number_orbits
   use geartrain_balance_planet_turn, only: planet_turn_type
   use geartrain_base_kinds, only: pi
   use geartrain_base_numbers, only: integer_text
   use geartrain_drawing_planetary_expansion, only: expand_planetaries
   use geartrain_network_equal_branches, only: equal_branches_type, find_equal_branches
   use geartrain_network_load_sharing, only: mesh_load_factor
   use geartrain_network_natural_modes, only: modes_type, natural_modes
   use geartrain_network_planet_symmetry, only: find_symmetries, symmetry_type
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_kinematics, only: find_kinematics, kinematics_type
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: planetary_tests

contains

   subroutine planetary_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('expansion')) call expansion(tests)
      if (tests%runs('refused')) call refused(tests)
      if (tests%runs('sharing')) call sharing(tests)
      if (tests%runs('revolution')) call revolution(tests)
      if (tests%runs('symmetry')) call symmetry(tests)
      if (tests%runs('iterations')) call iterations(tests)
      if (tests%runs('in_time')) call in_time(tests)
      if (tests%runs('orbits')) call orbits(tests)
      if (tests%runs('modes')) call modes_told(tests)
   end subroutine planetary_tests

   !> Bodies, meshes, phases and errors of a set.
   subroutine expansion(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: planets = 3
      type(train_type) :: train
      type(error_type), allocatable :: error
      real(dp) :: lag
      integer :: n

      train = planetary_stage([26, 31, 88], planets)
      train%planetaries(1)%planet_errors = [0.0_dp, 5e-6_dp, -2e-6_dp]
      call expand_planetaries(train, error)
      call tests%is_true(.not. allocated(error), 'a set in order')
      if (allocated(error)) return
      call tests%is_true(size(train%bodies) == 6 .and. size(train%meshes) == 6, 'three planets, six meshes')
      do n = 1, planets
         call tests%is_text(train%bodies(3 + n)%name, 's planet '//integer_text(n), 'name of planet '//integer_text(n))
         call tests%is_text(trim(train%meshes(n)%name), 's sun '//integer_text(n), 'name of a sun mesh')
         call tests%is_text(trim(train%meshes(planets + n)%name), 's ring '//integer_text(n), 'name of a ring mesh')
         lag = train%meshes(n)%phase - 2*pi*26*(n - 1)/planets
         call tests%is_close(abs(exp(cmplx(0, lag, dp)) - 1), 0.0_dp, 1e-13_dp, 'a sun mesh lags by z_s psi')
         lag = train%meshes(planets + n)%phase - train%meshes(planets + 1)%phase + 2*pi*88*(n - 1)/planets
         call tests%is_close(abs(exp(cmplx(0, lag, dp)) - 1), 0.0_dp, 1e-13_dp, 'a ring mesh leads by z_r psi')
      end do
      call tests%is_true(all(abs(train%meshes%error_mean - [0.0_dp, 5e-6_dp, -2e-6_dp, 0.0_dp, 5e-6_dp, -2e-6_dp]) <= 0), &
                         'the error of a planet is that of both its meshes')
   end subroutine expansion

   !> Sets that cannot be made, each with the variable that is told.
   subroutine refused(tests)
      class(tests_type), intent(inout) :: tests

      call check('planets', [27, 36, 99], 4, 'planets that cannot be equally spaced')
      call check('teeth', [27, 36, 98], 3, 'gears that do not fit on one axis')
      call check('teeth', [27, 36, 30], 3, 'a ring that is smaller than its planets')
      call check('planets', [27, 36, 99], 6, 'planets that overlap')
      call check('planets', [27, 36, 99], 1, 'a single planet')

   contains

      subroutine check(variable, teeth, planets, what)
         character(*), intent(in) :: variable, what
         integer, intent(in) :: teeth(3), planets
         type(train_type) :: train
         type(error_type), allocatable :: error

         train = planetary_stage(teeth, planets)
         call expand_planetaries(train, error)
         call tests%is_true(allocated(error), what)
         if (allocated(error)) call tests%is_true(index(error%message, variable) > 0, what//': told by name')
      end subroutine check

   end subroutine refused

   !> Static shares: planets are springs in parallel. One that the load does not reach has a force of exactly 0.
   subroutine sharing(tests)
      class(tests_type), intent(inout) :: tests
      real(dp), parameter :: stiffness = 1/(1/1e9_dp + 1/1.2e9_dp)
      real(dp) :: load, share(3), peak(3)

      call check([0.0_dp, 1e-6_dp, -1e-6_dp])
      call check([0.0_dp, 0.0_dp, -30e-6_dp])
      call check([0.0_dp, -20e-6_dp, -30e-6_dp])

   contains

      subroutine check(place)
         real(dp), intent(in) :: place(3)
         type(train_type) :: train
         type(system_type) :: system
         type(error_type), allocatable :: error
         real(dp) :: level, known(3)
         logical :: bears(3)

         train = planetary_stage([27, 36, 99], 3)
         train%planetaries(1)%planet_errors = place
         call expand_planetaries(train, error)
         call build_system(train, system)
         load = 300/(0.5_dp*27*4e-3_dp*cos(pi/9))
         bears = .true.
         do
            level = (load/stiffness - 2*sum(place, bears))/count(bears)
            if (all(level + 2*place > 0 .or. .not. bears)) exit
            bears(minloc(place, 1, bears)) = .false.
         end do
         known = merge(stiffness*(level + 2*place), 0.0_dp, bears)
         associate (n => system%mesh_element(system%sharing%mesh))
            call system%sharing%find_shares(system%static_force(n)*system%stiffness(n)*system%characteristic_length, &
                                            known, share, peak)
         end associate
         call tests%is_close(maxval(abs(share - known/load)), 0.0_dp, 1e-11_dp, 'static load shares')
         call tests%is_true(all(abs(share) > 0 .eqv. bears), 'a planet apart bears exactly nothing')
         call tests%is_close(mesh_load_factor(share), 3*maxval(known)/load, 1e-11_dp, 'mesh load factor')
         call tests%is_true(system%rest_residual < 1e-12_dp, 'the displacements agree round the loops')
      end subroutine check

   end subroutine sharing

   !> A planet turns z_r/z_p times against the carrier per turn of the carrier: once per z_p meshes.
   subroutine revolution(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(error_type), allocatable :: error
      type(kinematics_type) :: found

      train = planetary_stage([27, 36, 99], 3)
      call expand_planetaries(train, error)
      train%bodies(4)%revolution_torque_cos = [1.0_dp]
      call find_kinematics(train, found)
      call tests%is_true(found%known, 'speeds')
      if (.not. found%known) return
      call tests%is_true(found%order(1) == 36*found%revolution_order(4), 'a turn of a planet against the carrier has z_p meshes')
      call tests%is_close(abs(found%turning%speed(4)), 0.375_dp, 1e-14_dp, 'absolute speed of a planet')
      train%bodies(4)%revolution_torque_cos = [real(dp) ::]
      train%bodies(1)%revolution_torque_cos = [1.0_dp]
      call find_kinematics(train, found)
      ! z_s z_r/(z_s + z_r) = 297/14 meshes per turn of the sun.
      call tests%is_true(14*found%order(1) == 297*found%revolution_order(1), 'the sun turns against the ground')
   end subroutine revolution

   !> Symmetric sets: in phase, sequential, and sets that are not symmetric.
   subroutine symmetry(tests)
      class(tests_type), intent(inout) :: tests

      call check([27, 36, 99], 3, 0, .true., 'in phase')
      call check([26, 31, 88], 3, 0, .true., 'sequential')
      call check([20, 20, 60], 5, 0, .true., 'five planets')
      call check([27, 36, 99], 3, 1, .false., 'a planet with an error')
      call check([26, 31, 88], 3, 2, .false., 'a planet of another inertia')
      call check([26, 31, 88], 3, 3, .false., 'a torque that a shift in time changes')
      call check([27, 36, 99], 3, 3, .true., 'a torque, in phase')

   contains

      subroutine check(teeth, planets, change, wanted, what)
         integer, intent(in) :: teeth(3), planets, change
         logical, intent(in) :: wanted
         character(*), intent(in) :: what
         type(train_type) :: train
         type(system_type) :: system
         type(symmetry_type), allocatable :: symmetries(:)
         type(error_type), allocatable :: error

         train = planetary_stage(teeth, planets)
         if (change == 1) train%planetaries(1)%planet_errors = [0.0_dp, 1e-6_dp, 0.0_dp]
         call expand_planetaries(train, error)
         call tests%is_true(.not. allocated(error), what//': a set in order')
         if (allocated(error)) return
         if (change == 2) train%bodies(5)%inertia = 3e-3_dp
         if (change == 3) train%bodies(1)%torque_cos = [5.0_dp]
         call build_system(train, system)
         call find_symmetries(train, system, symmetries)
         call tests%is_true(size(symmetries) == merge(1, 0, wanted), what)
         if (size(symmetries) == 0) return
         call tests%is_true(abs(symmetries(1)%shift) > 0 .eqv. modulo(teeth(1), planets) /= 0, what//': shift in time')
      end subroutine check

   end subroutine symmetry

   !> Beside the part that has the symmetry a right side has rounding, near a solution as much of it: iterations take the part.
   subroutine iterations(tests)
      class(tests_type), intent(inout) :: tests

      call check([27, 36, 99], 3, 'in phase')
      call check([26, 31, 88], 3, 'sequential')
      call check([19, 21, 61], 5, 'five planets')

   contains

      subroutine check(teeth, planets, what)
         integer, intent(in) :: teeth(3), planets
         character(*), intent(in) :: what
         integer, parameter :: harmonics = 40
         type(train_type) :: train
         type(system_type), target :: system
         type(symmetry_type), allocatable :: symmetries(:)
         type(equal_branches_type), allocatable :: sets(:)
         type(balance_type) :: balance
         type(bordered_system_type) :: matrix
         type(fixed_space_type) :: fixed
         type(planet_turn_type) :: turn
         type(error_type), allocatable :: error
         real(dp), allocatable :: u(:, :), right(:, :), rest(:, :), x(:, :), product(:, :)
         real(dp) :: y
         logical :: regular
         integer :: k

         train = planetary_stage(teeth, planets)
         call expand_planetaries(train, error)
         call build_system(train, system)
         call find_symmetries(train, system, symmetries)
         call find_equal_branches(system, sets)
         call balance%setup(system, harmonics, 1, 0)
         call matrix%setup(balance)
         allocate (u(balance%block, balance%unknowns), source=0.0_dp)
         allocate (right, rest, x, product, mold=u)
         if (size(sets) > 0) call fixed%find(system, sets, u, u)
         if (fixed%is_whole()) call turn%find(system, symmetries, balance%winding, balance%mesh, balance%harmonic, u, u)
         call tests%is_true(fixed%joins() .or. allocated(turn%orbit), what//': planets move alike')
         call random_number(u)
         u = u*spread([1.0_dp, (0.3_dp/(1 + k/2)**2, k=2, balance%block)], 2, balance%unknowns)
         u(1, :) = system%half_backlash(balance%mesh) + 0.5_dp
         call fixed%project(u)
         call turn%project(u)
         balance%equal = .true.
         call balance%evaluate(u, 0.9_dp)
         right = balance%residual
         call matrix%linearize(balance)
         matrix%row = 0
         matrix%corner = 1
         call matrix%factor(balance, regular, fixed, turn)
         call random_number(rest)
         x = right + 0.1_dp*maxval(abs(right))*(rest - 0.5_dp)
         y = 0
         call matrix%solve(balance, x, y, 1e-6_dp)
         call tests%is_true(regular .and. matrix%iterations > 0 .and. balance%explicit < harmonics, what//': by iterations')
         rest = x
         call fixed%project(rest)
         call turn%project(rest)
         call tests%is_close(maxval(abs(x - rest)), 0.0_dp, 1e-12_dp*maxval(abs(x)), what//': planets move alike')
         x = right
         y = 0
         call matrix%solve(balance, x, y, 1e-10_dp)
         call balance%apply(x, product)
         call tests%is_close(maxval(abs(product - right)), 0.0_dp, 1e-9_dp*maxval(abs(right)), what//': solution')
      end subroutine check

   end subroutine iterations

   !> The linearised train in time beside elimination of all harmonics: solutions, and where the determinant changes its sign. With
   !> an error of a planet no symmetry is left; meshes close loops, whose mean displacements fit together.
   subroutine in_time(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: harmonics = 60, motions = 20
      type(train_type) :: train
      type(system_type), target :: system
      type(balance_type) :: balance, direct
      type(bordered_system_type) :: matrix, whole
      type(error_type), allocatable :: error
      real(dp), allocatable :: u(:, :), right(:, :), x(:, :), exact(:, :)
      real(dp) :: y, y_exact
      integer :: k, motion, sign(motions), exact_sign(motions)
      logical :: regular

      train = planetary_stage([26, 31, 88], 3)
      train%planetaries(1)%planet_errors = [0.0_dp, 5e-6_dp, -2e-6_dp]
      call expand_planetaries(train, error)
      call build_system(train, system)
      call balance%setup(system, harmonics, 1, 0)
      call direct%setup(system, harmonics, 1, 0, [(k, k=1, harmonics)])
      call matrix%setup(balance)
      call whole%setup(direct)
      allocate (u(balance%block, balance%unknowns))
      allocate (right, x, exact, mold=u)
      call tests%is_true(direct%is_direct() .and. balance%block == direct%block, 'the same harmonics')
      ! Always the same motions, whatever ran before.
      call random_seed(size=k)
      call random_seed(put=spread(1, 1, k))
      do motion = 1, motions
         call random_number(u)
         u = 20*(u - 0.5_dp)*spread([1.0_dp, (1.0_dp/(1 + k/2)**2, k=2, balance%block)], 2, balance%unknowns)
         u(1, :) = system%half_backlash(balance%mesh) + 0.5_dp
         call random_number(right)
         right = right - 0.5_dp
         call balance%evaluate(u, 0.6_dp)
         call direct%evaluate(u, 0.6_dp)
         call matrix%linearize(balance)
         call whole%linearize(direct)
         matrix%row = 0.01_dp*right
         matrix%corner = 1
         whole%row = matrix%row
         whole%corner = 1
         call matrix%factor(balance, regular)
         call tests%is_true(regular .and. matrix%solves_in_time() .and. balance%parts(), 'in time, where teeth part')
         call whole%factor(direct, regular)
         sign(motion) = matrix%orientation
         exact_sign(motion) = whole%orientation
         x = right
         y = 0.3_dp
         exact = right
         y_exact = y
         call matrix%solve(balance, x, y)
         call whole%solve(direct, exact, y_exact)
         call tests%is_true(matrix%iterations > 0 .and. matrix%iterations < 60, 'by iterations')
         call tests%is_close(maxval(abs(x - exact)) + abs(y - y_exact), 0.0_dp, 0.02_dp*maxval(abs(exact)), 'solution')
      end do
      call tests%is_true(any(exact_sign > 0) .and. any(exact_sign < 0), 'motions on both sides')
      call tests%is_true(all(sign*exact_sign == sign(1)*exact_sign(1)), 'the sign of the determinant')
   end subroutine in_time

   !> Motions whose figures are those of another one, with the planets turned: one orbit.
   subroutine orbits(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(error_type), allocatable :: error
      type(motion_type) :: motions(5)
      real(dp), parameter :: one(6) = [1.0_dp, 2.0_dp, 3.0_dp, 1.5_dp, 2.5_dp, 3.5_dp]
      integer :: i, orbit(5)

      do i = 1, 5
         motions(i)%rms = one
      end do
      motions(2)%rms = one([2, 3, 1, 5, 6, 4])
      motions(3)%rms = one([2, 1, 3, 5, 4, 6])
      motions(4)%rms = one([2, 3, 1, 4, 5, 6])
      motions(5)%period = 2
      do i = 1, 5
         motions(i)%mean = motions(i)%rms
         motions(i)%minimum = -motions(i)%rms
         motions(i)%maximum = motions(i)%rms
      end do
      train = planetary_stage([26, 31, 88], 3)
      call expand_planetaries(train, error)
      call number_orbits(train, motions, orbit)
      call tests%is_true(all(orbit == [1, 1, 2, 3, 4]), 'sequential: a turn of all planets')
      train = planetary_stage([27, 36, 99], 3)
      call expand_planetaries(train, error)
      call number_orbits(train, motions, orbit)
      call tests%is_true(all(orbit == [1, 1, 1, 2, 3]), 'in phase: any order of the planets')
   end subroutine orbits

   !> Of equal planets N - 1 modes move the planets only, the others are torsional.
   subroutine modes_told(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(error_type), allocatable :: error
      type(modes_type) :: modes

      train = planetary_stage([20, 20, 60], 5)
      call expand_planetaries(train, error)
      call natural_modes(train, modes, error)
      call tests%is_true(count(modes%kind == 'torsional') == 2 .and. count(modes%kind == 'planets of s') == 4, 'equal planets')
      train%bodies(4)%inertia = 3e-3_dp
      call natural_modes(train, modes, error)
      call tests%is_true(count(modes%kind == 'planets of s') == 3 .and. count(modes%kind == 'mixed') == 3, 'one planet is heavier')
   end subroutine modes_told

end module unit_planetary
