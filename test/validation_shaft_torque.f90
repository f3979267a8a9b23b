!> Torques of shafts: balance, shooting and sampled waveform against one another; a rigid shaft against a stiff one; closed forms.
module validation_shaft_torque
   use fixtures, only: paper_train, settings_of
   use geartrain, only: branch_type, dp, error_type, integrate, integration_settings_type, mesh_type, motion_type, refine, &
      response, shaft_type, solutions_at, train_type, waveform
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: shaft_torque_tests

contains

   subroutine shaft_torque_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('methods')) call methods(tests)
      if (tests%runs('rigid')) call rigid(tests)
      if (tests%runs('dragged')) call dragged(tests)
      if (tests%runs('closed_form')) call closed_form(tests)
   end subroutine shaft_torque_tests

   !> Figure 3 at Lambda = 0.9, where mesh 2 separates: the balance tends to the shooting's torques; so do the sampled waveforms.
   subroutine methods(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: branch
      type(error_type), allocatable :: error
      type(motion_type), allocatable :: motions(:)
      type(motion_type) :: exact
      real(dp) :: time(512), p(512, 2), force(512, 2), torque(512, 3)

      train = paper_train()
      call response(train, settings_of(0.85_dp, 0.95_dp, 96), branch, error)
      call solutions_at(train, settings_of(0.85_dp, 0.95_dp, 96), branch, 0.9_dp, motions, error)
      call tests%is_true(size(motions) == 1, 'a motion at 0.9')
      if (size(motions) /= 1) return
      exact = motions(1)
      call refine(train, exact, error)
      call tests%is_close(maxval(abs(motions(1)%shaft_torque_maximum - exact%shaft_torque_maximum)), 0.0_dp, 4e-3_dp, &
                          'largest torques of balance and shooting [N m]')
      call tests%is_close(maxval(abs(motions(1)%shaft_torque_minimum - exact%shaft_torque_minimum)), 0.0_dp, 4e-3_dp, &
                          'smallest torques')
      call tests%is_close(maxval(abs(exact%shaft_torque_mean/[150, 300, 600] - 1)), 0.0_dp, 1e-10_dp, 'mean torques are static')
      call waveform(train, exact, 512, time, p, force, torque)
      call tests%is_close(maxval(abs(maxval(torque, 1) - exact%shaft_torque_maximum)), 0.0_dp, 0.1_dp, 'of the samples')
      call waveform(train, motions(1), 512, time, p, force, torque)
      call tests%is_close(maxval(abs(maxval(torque, 1) - exact%shaft_torque_maximum)), 0.0_dp, 0.1_dp, &
                          'of the samples of the balance')
   end subroutine methods

   !> A rigid shaft bears what a stiff shaft bears in the limit, both with a torque that fluctuates on one side.
   subroutine rigid(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(error_type), allocatable :: error
      type(motion_type) :: stiff, stiffer, without
      real(dp) :: extrapolated(3)

      train = small_train()
      train%shafts(2)%stiffness = 2e7_dp
      call integrate(train, 0.6_dp, integration_settings_type(), stiff, error)
      train%shafts(2)%stiffness = 4e7_dp
      call integrate(train, 0.6_dp, integration_settings_type(), stiffer, error)
      train%shafts(2)%stiffness = 0
      train%shafts(2)%damping_ratio = 0
      train%shafts(2)%rigid = .true.
      call integrate(train, 0.6_dp, integration_settings_type(), without, error)
      call tests%is_true(.not. allocated(error), 'a rigid shaft')
      if (allocated(error)) return
      extrapolated = 2*stiffer%shaft_torque_maximum - stiff%shaft_torque_maximum
      call tests%is_close(maxval(abs(without%shaft_torque_maximum/extrapolated - 1)), 0.0_dp, 1e-3_dp, &
                          'largest torques in the limit of a stiff shaft')
      call tests%is_true(maxval(abs(without%shaft_torque_maximum/stiffer%shaft_torque_mean)) > 1.02_dp, 'which vibrate')
      call tests%is_close(maxval(abs(without%shaft_torque_mean - stiffer%shaft_torque_mean)), 0.0_dp, 1e-6_dp, 'mean torques')
   end subroutine rigid

   !> A rigid shaft bears the damping to ground of the bodies behind it: balance against shooting, with three damped bodies.
   subroutine dragged(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: branch
      type(error_type), allocatable :: error
      type(motion_type), allocatable :: motions(:)
      type(motion_type) :: exact

      train = small_train()
      train%bodies([1, 4, 5])%damping_to_ground = [1.0_dp, 20.0_dp, 30.0_dp]
      train%shafts(2)%rigid = .true.
      train%shafts(2)%stiffness = 0
      train%shafts(2)%damping_ratio = 0
      call response(train, settings_of(0.55_dp, 0.65_dp, 48), branch, error)
      call solutions_at(train, settings_of(0.55_dp, 0.65_dp, 48), branch, 0.6_dp, motions, error)
      call tests%is_true(size(motions) == 1, 'damped bodies: a motion at 0.6')
      if (size(motions) /= 1) return
      exact = motions(1)
      call refine(train, exact, error)
      ! In contact throughout: the balance is as exact as the shooting. Without the damping of the load 0.13 N m are missing.
      call tests%is_close(maxval(abs(motions(1)%shaft_torque_maximum - exact%shaft_torque_maximum)), 0.0_dp, 1e-7_dp, &
                          'largest torques of shafts between damped bodies [N m]')
      call tests%is_close(maxval(abs(motions(1)%shaft_torque_minimum - exact%shaft_torque_minimum)), 0.0_dp, 1e-7_dp, &
                          'smallest torques of shafts between damped bodies [N m]')
   end subroutine dragged

   !> Two rotors on a shaft beside a linear mesh so stiff that its gears move as one: a cosine torque T on the first rotor at omega
   !> twists the shaft by T (k - J omega^2 ... ) as two masses on a spring do.
   subroutine closed_form(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(motion_type) :: motion
      type(error_type), allocatable :: error
      real(dp) :: omega, j1, j2, k, amplitude

      train = small_train()
      ! No fluctuation but that of the torque; the gears after shaft 1 are one rotor with the load, by a mesh of 1e12 N/m.
      deallocate (train%meshes(1)%stiffness_cos, train%meshes(1)%error_cos)
      train%meshes(1)%half_backlash = 0
      train%meshes(1)%damping_ratio = 0
      train%meshes(1)%stiffness = 1e11_dp
      train%shafts(1)%damping_ratio = 0.2_dp
      train%shafts(2:)%rigid = .true.
      train%shafts(2:)%stiffness = 0
      train%shafts(2:)%damping_ratio = 0
      call integrate(train, 0.6_dp, integration_settings_type(tolerance=1e-11_dp), motion, error)
      call tests%is_true(.not. allocated(error), 'a linear train')
      if (allocated(error)) return
      omega = 0.6_dp*2000
      j1 = 0.02_dp
      ! Gear ratio 2: what lies behind the mesh counts a quarter.
      j2 = 0.003_dp + (0.01_dp + 0.05_dp + 0.02_dp)/4
      k = 5e3_dp
      ! With c = 2 zeta sqrt(k m), 1/m = 1/J1 + 1/J2' of the bodies at its ends (the first gear alone).
      associate (c => 2*0.2_dp*sqrt(k/(1/j1 + 1/0.003_dp)), m => 1/(1/j1 + 1/j2))
         amplitude = 10/j1*abs(cmplx(k, c*omega, dp)/cmplx(k/m - omega**2, c*omega/m, dp))
      end associate
      call tests%is_close((motion%shaft_torque_maximum(1) - motion%shaft_torque_minimum(1))/2, amplitude, 1e-4_dp*amplitude, &
                          'alternating torque of two rotors on a shaft')
   end subroutine closed_form

   !> motor - pinion = wheel - flange - load, with a torque of the first order on the motor.
   type(train_type) function small_train() result(train)
      train%characteristic_length = 1e-5_dp
      train%characteristic_frequency = 2000
      allocate (train%bodies(5), train%shafts(3), train%meshes(1))
      train%bodies(1)%name = 'motor'
      train%bodies(2)%name = 'pinion'
      train%bodies(3)%name = 'wheel'
      train%bodies(4)%name = 'flange'
      train%bodies(5)%name = 'load'
      train%bodies%inertia = [0.02_dp, 0.003_dp, 0.01_dp, 0.05_dp, 0.02_dp]
      train%bodies(1)%torque = 100
      train%bodies(1)%torque_cos = [10.0_dp]
      train%bodies(5)%balances = .true.
      train%shafts = [shaft_type(between=[character(64) :: 'motor', 'pinion'], stiffness=5e3_dp, damping_ratio=0.05_dp), &
                      shaft_type(between=[character(64) :: 'wheel', 'flange'], stiffness=1e7_dp, damping_ratio=0.05_dp), &
                      shaft_type(between=[character(64) :: 'flange', 'load'], stiffness=2e4_dp, damping_ratio=0.05_dp)]
      train%meshes(1) = mesh_type(between=[character(64) :: 'pinion', 'wheel'], driving_radius=0.05_dp, driven_radius=0.1_dp, &
                                  stiffness=2e8_dp, damping_ratio=0.05_dp, half_backlash=2e-5_dp)
      train%meshes(1)%stiffness_cos = [0.2_dp]
      train%meshes(1)%error_cos = [2e-6_dp]
   end function small_train

end module validation_shaft_torque
