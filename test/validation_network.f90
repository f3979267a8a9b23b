!> Trains of any shape: trees and loops of gears against chains, closed forms and another code of the same equations.
module validation_network
   use fixtures, only: body, long_train, paper_train, ring, settings_of
   use geartrain, only: branch_type, case_type, dp, error_type, mesh_type, modes_type, motion_type, natural_modes, read_case_text, &
                        response, shaft_type, solutions_at, train_type
   use geartrain_base_kinds, only: pi
   use independent, only: build_machine, machine_type
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: network_tests

contains

   subroutine network_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('chain_in_names')) call chain_in_names(tests)
      if (tests%runs('equal_branches')) call equal_branches(tests)
      if (tests%runs('idler_in_halves')) call idler_in_halves(tests)
      if (tests%runs('weak_loop')) call weak_loop(tests)
      if (tests%runs('branched_modes')) call branched_modes(tests)
      if (tests%runs('linear_network')) call linear_network(tests)
      if (tests%runs('messages')) call messages(tests)
   end subroutine network_tests

   !> A chain written down as a network, its groups in reverse.
   function named(chain) result(train)
      type(train_type), intent(in) :: chain
      type(train_type) :: train
      character(8) :: name(2*size(chain%shafts))
      integer :: i, m

      m = size(chain%meshes)
      do i = 1, size(name)
         write (name(i), '(a, i0)') 'body ', i
      end do
      train = chain
      train%input_torque = 0
      train%prime_mover_inertia = 0
      train%load_inertia = 0
      allocate (train%bodies(size(name)))
      train%bodies(size(name)) = body(name(1), chain%prime_mover_inertia, chain%input_torque)
      train%bodies(1) = body(name(size(name)), chain%load_inertia, balances=.true.)
      associate (motor => train%bodies(size(name)))
         if (allocated(chain%torque_cos)) motor%torque_cos = chain%torque_cos
         if (allocated(chain%torque_sin)) motor%torque_sin = chain%torque_sin
      end associate
      if (allocated(train%torque_cos)) deallocate (train%torque_cos)
      if (allocated(train%torque_sin)) deallocate (train%torque_sin)
      do i = 1, m
         train%bodies(size(name) + 1 - 2*i) = body(name(2*i), chain%meshes(i)%driving_inertia)
         train%bodies(size(name) - 2*i) = body(name(2*i + 1), chain%meshes(i)%driven_inertia)
         train%meshes(i)%between = name(2*i:2*i + 1)
         train%meshes(i)%driving_inertia = 0
         train%meshes(i)%driven_inertia = 0
      end do
      do i = 1, m + 1
         train%shafts(i)%between = name(2*i - 1:2*i)
      end do
      train%shafts = train%shafts(m + 1:1:-1)
   end function named

   !> The chain is the short form of the same network: the same numbers but for rounding.
   subroutine chain_in_names(tests)
      class(tests_type), intent(inout) :: tests

      call compare(paper_train(), 0.7_dp, 0.9_dp, 6, 'the paper''s train')
      call compare(long_train(6), 0.31_dp, 0.33_dp, 8, 'a long train')

   contains

      subroutine compare(chain, from, to, harmonics, name)
         type(train_type), intent(in) :: chain
         real(dp), intent(in) :: from, to
         integer, intent(in) :: harmonics
         character(*), intent(in) :: name
         integer :: i
         type(branch_type) :: a, b
         type(motion_type), allocatable :: of_chain(:), of_network(:)
         type(error_type), allocatable :: error

         call response(chain, settings_of(from, to, harmonics), a, error)
         call response(named(chain), settings_of(from, to, harmonics), b, error)
         call tests%is_true(.not. allocated(error), name//': runs as a network')
         if (allocated(error)) return
         call solutions_at(chain, settings_of(from, to, harmonics), a, (from + to)/2, of_chain, error)
         call solutions_at(named(chain), settings_of(from, to, harmonics), b, (from + to)/2, of_network, error)
         call tests%is_true(size(of_chain) > 0 .and. size(of_chain) == size(of_network), name//': as many motions')
         do i = 1, min(size(of_chain), size(of_network))
            call tests%is_close(maxval(abs(of_network(i)%rms - of_chain(i)%rms)), 0.0_dp, 1e-12_dp, name//': rms')
            call tests%is_close(maxval(abs(of_network(i)%coefficients - of_chain(i)%coefficients)), 0.0_dp, 1e-12_dp, &
                                name//': coefficients')
            call tests%is_close(abs(of_network(i)%multipliers(1)), abs(of_chain(i)%multipliers(1)), 1e-9_dp, &
                                name//': largest multiplier')
         end do
      end subroutine compare

   end subroutine chain_in_names

   !> One gear that drives two equal branches moves as a chain does whose mesh, shaft, gear and load are those of both together.
   subroutine equal_branches(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train, chain
      type(branch_type) :: a, b
      type(error_type), allocatable :: error

      train%characteristic_length = 3e-5_dp
      train%characteristic_frequency = 9870
      train%bodies = [body('motor', 2.3e-4_dp, 150.0_dp), body('pinion', 2.3e-3_dp), body('wheel 1', 0.037_dp), &
                      body('wheel 2', 0.037_dp), body('load 1', 0.02_dp, torque=-150.0_dp), &
                      body('load 2', 0.02_dp, balances=.true.)]
      train%shafts = [shaft_type(between=[character(64) :: 'motor', 'pinion'], stiffness=1e4_dp, damping_ratio=0.02_dp), &
                      shaft_type(between=[character(64) :: 'wheel 1', 'load 1'], stiffness=5e3_dp, damping_ratio=0.02_dp), &
                      shaft_type(between=[character(64) :: 'wheel 2', 'load 2'], stiffness=5e3_dp, damping_ratio=0.02_dp)]
      allocate (train%meshes(2))
      train%meshes%driving_radius = 0.05_dp
      train%meshes%driven_radius = 0.1_dp
      train%meshes%stiffness = 2.5e8_dp
      train%meshes%damping = 1500
      train%meshes%damping_given = .true.
      train%meshes%half_backlash = 3e-5_dp
      train%meshes(1)%between = [character(64) :: 'pinion', 'wheel 1']
      train%meshes(2)%between = [character(64) :: 'pinion', 'wheel 2']
      train%meshes(1)%stiffness_cos = [0.3_dp]
      train%meshes(2)%stiffness_cos = [0.3_dp]

      chain%characteristic_length = train%characteristic_length
      chain%characteristic_frequency = train%characteristic_frequency
      chain%input_torque = 150
      chain%prime_mover_inertia = 2.3e-4_dp
      chain%load_inertia = 0.04_dp
      chain%shafts = [shaft_type(stiffness=1e4_dp, damping_ratio=0.02_dp), shaft_type(stiffness=1e4_dp, damping_ratio=0.02_dp)]
      chain%meshes = train%meshes(:1)
      chain%meshes(1)%between = ''
      chain%meshes(1)%driving_inertia = 2.3e-3_dp
      chain%meshes(1)%driven_inertia = 0.074_dp
      chain%meshes(1)%stiffness = 5e8_dp
      chain%meshes(1)%damping = 3000

      call response(chain, settings_of(0.9_dp, 2.6_dp, 10), a, error)
      call response(train, settings_of(0.9_dp, 2.6_dp, 10), b, error)
      call tests%is_true(.not. allocated(error), 'two branches: runs')
      if (allocated(error)) return
      call tests%is_true(any(a%minimum(1, :) < 1), 'two branches: teeth separate')
      call compare(1.1_dp)
      call compare(1.5_dp)
      call compare(2.0_dp)

   contains

      subroutine compare(frequency_ratio)
         real(dp), intent(in) :: frequency_ratio
         type(motion_type), allocatable :: of_chain(:), of_train(:)
         integer :: i

         call solutions_at(chain, settings_of(0.9_dp, 2.6_dp, 10), a, frequency_ratio, of_chain, error)
         call solutions_at(train, settings_of(0.9_dp, 2.6_dp, 10), b, frequency_ratio, of_train, error)
         call tests%is_true(size(of_chain) > 0 .and. size(of_chain) == size(of_train), 'two branches: as many motions')
         do i = 1, min(size(of_chain), size(of_train))
            call tests%is_close(of_train(i)%rms(1), of_chain(i)%rms(1), 1e-10_dp, 'two branches: rms of the first')
            call tests%is_close(of_train(i)%rms(2), of_chain(i)%rms(1), 1e-10_dp, 'two branches: rms of the second')
            call tests%is_close(of_train(i)%mean(1), of_chain(i)%mean(1), 1e-10_dp, 'two branches: mean')
         end do
      end subroutine compare

   end subroutine equal_branches

   !> An idler in two meshes is one body, or two halves on a rigid shaft.
   subroutine idler_in_halves(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: one, two
      type(branch_type) :: a, b
      type(error_type), allocatable :: error

      one%characteristic_length = 3e-5_dp
      one%characteristic_frequency = 9870
      one%bodies = [body('driver', 2.3e-3_dp, 150.0_dp), body('idler', 4e-3_dp), body('driven', 0.037_dp, balances=.true.)]
      allocate (one%shafts(0), one%meshes(2))
      one%meshes%driving_radius = 0.05_dp
      one%meshes%driven_radius = 0.05_dp
      one%meshes%stiffness = 2.5e8_dp
      one%meshes%damping = 4000
      one%meshes%damping_given = .true.
      one%meshes%half_backlash = 3e-5_dp
      one%meshes(1)%between = [character(64) :: 'driver', 'idler']
      one%meshes(2)%between = [character(64) :: 'idler', 'driven']
      one%meshes(1)%stiffness_cos = [0.3_dp]
      one%meshes(2)%stiffness_cos = [0.1_dp]
      one%meshes(2)%stiffness_sin = [0.2_dp]
      two = one
      two%bodies = [body('driver', 2.3e-3_dp, 150.0_dp), body('idler', 1e-3_dp), body('other half', 3e-3_dp), &
                    body('driven', 0.037_dp, balances=.true.)]
      two%shafts = [shaft_type(between=[character(64) :: 'other half', 'idler'], rigid=.true.)]
      two%meshes(2)%between(1) = 'other half'
      call response(one, settings_of(1.0_dp, 2.6_dp, 8), a, error)
      call response(two, settings_of(1.0_dp, 2.6_dp, 8), b, error)
      call tests%is_true(.not. allocated(error) .and. a%points == b%points, 'idler: as many points')
      if (allocated(error) .or. a%points /= b%points) return
      call tests%is_close(maxval(abs(a%rms - b%rms)), 0.0_dp, 1e-12_dp, 'idler: rms')
   end subroutine idler_in_halves

   !> Four gears in a ring, one mesh of which is next to nothing: the tree without it.
   subroutine weak_loop(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: looped, tree
      type(branch_type) :: a, b
      type(error_type), allocatable :: error
      type(motion_type), allocatable :: of_ring(:), of_tree(:)
      integer :: k
      real(dp) :: off(2)

      looped = ring()
      ! Without the fourth mesh gear c would float in its gap.
      looped%meshes(4)%damping_ratio = 0
      looped%bodies(1)%torque = 400
      looped%bodies(4)%torque = -150
      tree = looped
      tree%meshes = looped%meshes(:3)
      call response(tree, settings_of(1.0_dp, 1.4_dp, 8), b, error)
      call solutions_at(tree, settings_of(1.0_dp, 1.4_dp, 8), b, 1.2_dp, of_tree, error)
      do k = 1, 2
         looped%meshes(4)%stiffness = 10.0_dp**(6 - 2*k)
         call response(looped, settings_of(1.0_dp, 1.4_dp, 8), a, error)
         call tests%is_true(.not. allocated(error), 'weak loop: runs')
         if (allocated(error)) return
         call solutions_at(looped, settings_of(1.0_dp, 1.4_dp, 8), a, 1.2_dp, of_ring, error)
         call tests%is_true(size(of_ring) == size(of_tree) .and. size(of_ring) > 0, 'weak loop: as many motions')
         if (size(of_ring) /= size(of_tree) .or. size(of_ring) == 0) return
         off(k) = maxval(abs(of_ring(1)%rms(:3) - of_tree(1)%rms))
      end do
      call tests%is_close(off(1), 0.0_dp, 1e-3_dp, 'weak loop: 1e4 N/m')
      call tests%is_close(off(2)/off(1), 0.01_dp, 1e-3_dp, 'weak loop: goes to the tree in proportion')
   end subroutine weak_loop

   !> Natural frequencies of a branched train whose meshes are as good as rigid [Hz]: 425.4, 634.1 and 3247.2, those of motor, gears
   !> and rotors in one sense, and of the rotors against one another.
   subroutine branched_modes(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(modes_type) :: modes
      type(error_type), allocatable :: error
      real(dp), parameter :: expected(3) = [425.4_dp, 634.1_dp, 3247.2_dp]

      train%characteristic_length = 1e-6_dp
      train%characteristic_frequency = 2*pi
      train%bodies = [body('motor', 400e-6_dp, 10.0_dp), body('gear 1', 25e-6_dp), body('gear 2', 25e-6_dp), &
                      body('rotor 1', 700e-6_dp, -5.0_dp), body('rotor 2', 700e-6_dp, balances=.true.)]
      train%shafts = [shaft_type(between=[character(64) :: 'motor', 'gear 1'], stiffness=1e4_dp), &
                      shaft_type(between=[character(64) :: 'gear 1', 'rotor 1'], stiffness=5e3_dp), &
                      shaft_type(between=[character(64) :: 'gear 2', 'rotor 2'], stiffness=5e3_dp)]
      train%meshes = [mesh_type(between=[character(64) :: 'gear 1', 'gear 2'], driving_radius=0.05_dp, driven_radius=0.05_dp, &
                                stiffness=1e13_dp)]
      call natural_modes(train, modes, error)
      call tests%is_true(.not. allocated(error), 'branched train: runs')
      if (allocated(error)) return
      call tests%is_close(maxval(abs(modes%natural_frequency(:3) - expected)), 0.0_dp, 0.05_dp, 'branched train: Hz')
   end subroutine branched_modes

   !> A ring of linear meshes under torques and errors: the balance against the equations of the bodies solved as they are.
   subroutine linear_network(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: branch
      type(error_type), allocatable :: error
      complex(dp) :: p(4)
      integer :: j

      train = ring()
      do j = 1, 4
         train%meshes(j)%half_backlash = 0
         deallocate (train%meshes(j)%stiffness_cos)
      end do
      train%bodies(1)%torque_cos = [20.0_dp]
      train%bodies(5)%torque_sin = [7.0_dp]
      call response(train, settings_of(0.8_dp, 1.3_dp, 3), branch, error)
      call tests%is_true(.not. allocated(error), 'linear ring: runs')
      if (allocated(error)) return
      do j = 1, branch%points, 5
         call solve_bodies(train, branch%frequency_ratio(j)*train%characteristic_frequency, p)
         call tests%is_close(maxval(abs(p/train%characteristic_length - cmplx(branch%coefficients(2, :, j), &
                             -branch%coefficients(3, :, j), dp)))/maxval(abs(p/train%characteristic_length)), 0.0_dp, 1e-10_dp, &
                             'linear ring: amplitudes')
      end do
   end subroutine linear_network

   !> (K + i omega C - omega^2 I) theta = T - what the errors do, by Gauss' elimination.
   subroutine solve_bodies(train, omega, p)
      type(train_type), intent(in) :: train
      real(dp), intent(in) :: omega
      complex(dp), intent(out) :: p(:)
      type(machine_type) :: machine
      complex(dp) :: z(size(train%bodies), size(train%bodies)), x(size(train%bodies)), k, e
      real(dp) :: b(size(train%bodies))
      integer :: i, j, n

      call build_machine(train, omega/train%characteristic_frequency, machine)
      n = size(x)
      z = 0
      x = 0
      do i = 1, n
         z(i, i) = -omega**2*machine%inertia(i)
         if (allocated(train%bodies(i)%torque_cos)) x(i) = x(i) + train%bodies(i)%torque_cos(1)
         if (allocated(train%bodies(i)%torque_sin)) x(i) = x(i) - (0, 1)*train%bodies(i)%torque_sin(1)
      end do
      do j = 1, size(machine%joint)
         associate (joint => machine%joint(j))
            k = cmplx(joint%stiffness, omega*joint%damping, dp)
            b = 0
            b(joint%a) = joint%ra
            b(joint%b) = -joint%rb
            e = 0
            if (size(joint%error, 2) > 0) e = cmplx(joint%error(1, 1), -joint%error(2, 1), dp)
            do i = 1, n
               z(:, i) = z(:, i) + k*b*b(i)
            end do
            x = x - k*e*b
         end associate
      end do
      do i = 1, n
         do j = i + 1, n
            k = z(j, i)/z(i, i)
            z(j, :) = z(j, :) - k*z(i, :)
            x(j) = x(j) - k*x(i)
         end do
      end do
      do i = n, 1, -1
         x(i) = (x(i) - sum(z(i, i + 1:)*x(i + 1:)))/z(i, i)
      end do
      do j = 1, size(p)
         associate (joint => machine%joint(size(train%shafts) + j))
            p(j) = joint%ra*x(joint%a) - joint%rb*x(joint%b)
            if (size(joint%error, 2) > 0) p(j) = p(j) + cmplx(joint%error(1, 1), -joint%error(2, 1), dp)
         end associate
      end do
   end subroutine solve_bodies

   !> Wrong networks are told in the words of the case.
   subroutine messages(tests)
      class(tests_type), intent(inout) :: tests
      character(*), parameter :: n = new_line('a')
      character(*), parameter :: head = '&train characteristic_length = 1e-5, characteristic_frequency = 1e4 /'//n
      character(*), parameter :: a = "&body name = 'a', inertia = 1.0, torque = 1.0 /"//n, &
                                 b = "&body name = 'b', inertia = 1.0 /"//n, &
                                 c = "&body name = 'c', inertia = 1.0, balances = .true. /"//n
      character(*), parameter :: ab = "&mesh between = 'a', 'b', driving_radius = 1.0, driven_radius = 2.0, stiffness = 1e8 /"//n, &
                                 bc = "&mesh between = 'b', 'c', driving_radius = 2.0, driven_radius = 2.0, stiffness = 1e8 /"//n, &
                                 ca = "&mesh between = 'c', 'a', driving_radius = 2.0, driven_radius = 1.1, stiffness = 1e8 /"//n, &
                                 turns = "&mesh between = 'c', 'a', driving_radius = 2.0, driven_radius = 1.0, internal = .true., &
                                         &stiffness = 1e8 /"//n

      call told(head//a//b//c//ab, "x.nml:4:14: error: &body 3: 'c' is joined with 'a' by no shaft, mesh or coupling")
      call told(head//a//b//c//ab//bc//ca, 'x.nml:7:17: error: &mesh 3: these gears lock: there is an odd number of &
                &external pairs in the loop c - b - a - c')
      call told(head//a//b//c//ab//bc//turns, '')
      call told(head//a//b//ab, 'x.nml:1:1: error: no &body has balances = .true.: the mean torque of one of them, the load, &
                &balances that of all others')
      call told(head//a//c//c//ab//bc, "x.nml:4:14: error: &body 3: name = 'c': is that of &body 2 already")
      call told(head//a//b//c//ab//"&shaft between = 'b', 'cc', stiffness = 1e5 /"//n, &
                "x.nml:6:18: error: &shaft 1: between = 'cc': is the name of no &body (did you mean 'c'?)")

   contains

      !> The first line of what is said of a text; '' where all is well.
      subroutine told(text, message)
         character(*), intent(in) :: text, message
         type(case_type) :: case
         type(error_type), allocatable :: error

         call read_case_text(text//'&modes /'//n, 'x.nml', case, error)
         if (.not. allocated(error)) then
            call tests%is_text('', message, 'messages of networks')
         else
            call tests%is_text(error%message(:index(error%message//n, n) - 1), message, 'messages of networks')
         end if
      end subroutine told

   end subroutine messages

end module validation_network
