!> Damping to ground against closed forms; the multipliers of loops and of damping to ground against shooting.
module validation_ground
   use fixtures, only: body, ring, settings_of
   use geartrain, only: branch_type, dp, error_type, integrate, integration_settings_type, mesh_type, modes_type, motion_type, &
                        natural_modes, refine, response, solutions_at, train_type
   use geartrain_base_kinds, only: pi
   use geartrain_floquet_time_reversal, only: time_reversal_type
   use geartrain_linalg_lapack, only: dgeev
   use geartrain_network_system, only: build_system, system_type
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: ground_tests

contains

   subroutine ground_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('two_discs')) call two_discs(tests)
      if (tests%runs('rigid_parts')) call rigid_parts(tests)
      if (tests%runs('mirror')) call mirrored(tests)
   end subroutine ground_tests

   !> Two discs on a linear mesh, each damped to ground, under a torque and a transmission error.
   function discs() result(train)
      type(train_type) :: train

      train%characteristic_length = 1e-5_dp
      train%characteristic_frequency = 1e4_dp
      train%bodies = [body('a', 2e-3_dp, 40.0_dp), body('b', 7e-3_dp, balances=.true.)]
      train%bodies%damping_to_ground = [0.8_dp, 2.5_dp]
      train%bodies(2)%torque_cos = [3.0_dp]
      train%bodies(2)%torque_sin = [-2.0_dp]
      allocate (train%shafts(0))
      train%meshes = [mesh_type(between=[character(64) :: 'a', 'b'], driving_radius=0.05_dp, driven_radius=0.08_dp, &
                                stiffness=1e8_dp, damping_ratio=0.05_dp)]
      train%meshes(1)%error_cos = [4e-6_dp]
   end function discs

   !> Amplitudes by two complex equations, multipliers and damped frequencies by the eigenvalues of the equations of the discs.
   subroutine two_discs(tests)
      class(tests_type), intent(inout) :: tests
      real(dp), parameter :: frequency_ratio = 0.7_dp
      type(train_type) :: train
      type(branch_type) :: branch
      type(motion_type) :: motion
      type(modes_type) :: modes
      type(error_type), allocatable :: error
      type(motion_type), allocatable :: motions(:)
      complex(dp) :: z(2, 2), force(2), k, theta(2), p, expected(3), value
      real(dp) :: a(4, 4), wr(4), wi(4), work(64), none(1, 1), b(2), c, omega, period
      integer :: i, info, n

      train = discs()
      b = [0.05_dp, -0.08_dp]
      associate (inertia => train%bodies%inertia, drag => train%bodies%damping_to_ground, mesh => train%meshes(1))
         c = 2*mesh%damping_ratio*sqrt(mesh%stiffness/sum(b**2/inertia))
         omega = frequency_ratio*train%characteristic_frequency
         k = cmplx(mesh%stiffness, omega*c, dp)
         z = k*reshape([b(1)*b, b(2)*b], [2, 2])
         force = [cmplx(0, 0, dp), cmplx(3, 2, dp)] - k*b*4e-6_dp
         do i = 1, 2
            z(i, i) = z(i, i) + cmplx(-omega**2*inertia(i), omega*drag(i), dp)
         end do
         theta = [z(2, 2)*force(1) - z(1, 2)*force(2), z(1, 1)*force(2) - z(2, 1)*force(1)]/(z(1, 1)*z(2, 2) - z(1, 2)*z(2, 1))
         p = (sum(b*theta) + 4e-6_dp)/train%characteristic_length
         a = 0
         do i = 1, 2
            a(i, 2 + i) = 1
            a(2 + i, :2) = -mesh%stiffness*b(i)*b/inertia(i)
            a(2 + i, 3:) = -c*b(i)*b/inertia(i)
            a(2 + i, 2 + i) = a(2 + i, 2 + i) - drag(i)/inertia(i)
         end do
      end associate
      call dgeev('N', 'N', 4, a, 4, wr, wi, none, 1, none, 1, work, size(work), info)
      period = 2*pi/omega
      ! The angle of both together, which nothing depends on, has an eigenvalue of 0.
      i = minloc(hypot(wr, wi), 1)
      expected = exp(period*pack(cmplx(wr, wi, dp), [1, 2, 3, 4] /= i))

      call response(train, settings_of(0.6_dp, 0.8_dp, 3), branch, error)
      call tests%is_true(.not. allocated(error), 'two discs: response')
      call solutions_at(train, settings_of(0.6_dp, 0.8_dp, 3), branch, frequency_ratio, motions, error)
      call integrate(train, frequency_ratio, integration_settings_type(stability=.true.), motion, error)
      call tests%is_true(.not. allocated(error) .and. size(motions) == 1, 'two discs: motions')
      if (allocated(error) .or. size(motions) /= 1) return
      call tests%is_close(abs(cmplx(motions(1)%coefficients(2, 1), -motions(1)%coefficients(3, 1), dp) - p), 0.0_dp, 1e-12_dp, &
                          'two discs: amplitude')
      call tests%is_close(motion%rms(1), abs(p), 1e-9_dp, 'two discs: integration')
      call tests%is_close(motion%mean(1), 40/0.05_dp/1e8_dp/1e-5_dp, 1e-10_dp, 'two discs: no drag on the mean')
      call tests%is_true(size(motions(1)%multipliers) == 3, 'two discs: three multipliers')
      do n = 1, size(motions(1)%multipliers)
         value = motions(1)%multipliers(n)
         call tests%is_close(minval(abs(expected - value)), 0.0_dp, 1e-8_dp, 'two discs: multiplier of the balance')
         call tests%is_close(minval(abs(expected - motion%multipliers(n))), 0.0_dp, 1e-9_dp, 'two discs: of integration')
      end do
      call natural_modes(train, modes, error)
      call tests%is_true(size(modes%natural_frequency) == 1 .and. all(shape(modes%shape) == [1, 1]), 'two discs: one mode')
      call tests%is_close(modes%damped_frequency(1), maxval(wi)/1e4_dp, 1e-12_dp, 'two discs: damped frequency')
      i = maxloc(wi, 1)
      call tests%is_close(modes%damping_ratio(1), -wr(i)/hypot(wr(i), wi(i)), 1e-12_dp, 'two discs: damping ratio')
   end subroutine two_discs

   !> A body that is damped to ground may as well be two on a rigid shaft that share inertia and damping.
   subroutine rigid_parts(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: one, two
      type(branch_type) :: a, b
      type(error_type), allocatable :: error
      integer :: i

      one = ring()
      one%bodies(2)%damping_to_ground = 0.4_dp
      two = one
      two%bodies(1)%inertia = 0.5_dp*one%bodies(1)%inertia
      two%bodies = [two%bodies, two%bodies(1)]
      two%bodies(7)%name = 'flange'
      two%bodies(7)%torque = 0
      two%shafts = [two%shafts, two%shafts(1)]
      two%shafts(3)%between = [character(64) :: 'flange', 'motor']
      two%shafts(3)%rigid = .true.
      two%shafts(3)%stiffness = 0
      two%shafts(3)%damping_ratio = 0
      ! A damping ratio refers to the body at the end of the shaft alone: the same damping is more of it.
      associate (shaft => two%shafts(1), whole => one%bodies(1)%inertia, other => one%bodies(2)%inertia)
         shaft%damping_ratio = shaft%damping_ratio*sqrt((2/whole + 1/other)/(1/whole + 1/other))
      end associate
      one%bodies(1)%damping_to_ground = 0.9_dp
      two%bodies([1, 7])%damping_to_ground = [0.3_dp, 0.6_dp]
      call response(one, settings_of(0.9_dp, 1.3_dp, 6), a, error)
      call response(two, settings_of(0.9_dp, 1.3_dp, 6), b, error)
      call tests%is_true(.not. allocated(error) .and. a%points == b%points, 'damping on a rigid shaft: as many points')
      if (allocated(error) .or. a%points /= b%points) return
      ! Steps end where rounding lets them: compared is the branch, not the place on it.
      do i = 1, a%meshes
         b%rms(i, :) = b%rms(i, :) + b%rms_slope(i, :)*(a%arclength - b%arclength)
      end do
      call tests%is_close(maxval(abs(a%rms(:, :a%points) - b%rms(:, :b%points))), 0.0_dp, 1e-11_dp, 'damping on a rigid shaft: rms')
      call tests%is_true(a%states == 11, 'damping on a rigid shaft: twice five coordinates and one')
   end subroutine rigid_parts

   !> Where every kappa is a cosine, half of the monodromy matrix makes the whole: on loops, and with damping to ground.
   subroutine mirrored(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train

      train = ring()
      call compare('a ring')
      train%bodies([2, 4, 6])%damping_to_ground = [0.7_dp, 0.2_dp, 1.1_dp]
      call compare('a ring damped to ground')
      train%meshes%half_backlash = 0
      call compare('a linear ring damped to ground')

   contains

      subroutine compare(name)
         character(*), intent(in) :: name
         type(system_type), target :: system
         type(time_reversal_type) :: mirror
         type(branch_type) :: branch
         type(motion_type), allocatable :: motions(:)
         type(error_type), allocatable :: error
         complex(dp), allocatable :: found(:)
         real(dp) :: accuracy
         integer :: i, n

         call build_system(train, system)
         call mirror%setup(system)
         call tests%is_true(size(mirror%centre) > 0, name//': kappa is even')
         accuracy = merge(2e-5_dp, 1e-8_dp, any(train%meshes%half_backlash > 0))
         call response(train, settings_of(0.88_dp, 0.92_dp, 40), branch, error)
         call solutions_at(train, settings_of(0.88_dp, 0.92_dp, 40), branch, 0.9_dp, motions, error)
         call tests%is_true(.not. allocated(error) .and. size(motions) > 0, name//': motions')
         do i = 1, size(motions)
            found = motions(i)%multipliers
            call refine(train, motions(i), error)
            call tests%is_true(.not. allocated(error), name//': shooting')
            if (allocated(error)) return
            call tests%is_true(size(found) == system%states, name//': number of multipliers')
            do n = 1, size(found)
               call tests%is_close(minval(abs(motions(i)%multipliers - found(n))), 0.0_dp, accuracy, name//': multipliers')
            end do
         end do
      end subroutine compare

   end subroutine mirrored

end module validation_ground
