!> Trains that many tests use.
module fixtures
   use geartrain, only: dp, mesh_type, motion_type, response_settings_type, shaft_type, train_type
   implicit none (type, external)
   private
   public :: paper_train, single_pair, settings_of, long_train, closest

contains

   !> Table 1 of Al-shyyab and Kahraman (2007), k3 = 1e8 N m/rad, 150 N m.
   function paper_train(kappa) result(train)
      !> First harmonic of both mesh stiffnesses [1]; default 0.3.
      real(dp), intent(in), optional :: kappa
      type(train_type) :: train
      real(dp) :: amplitude

      amplitude = 0.3_dp
      if (present(kappa)) amplitude = kappa
      train%title = 'Al-shyyab and Kahraman 2007'
      train%input_torque = 150
      train%prime_mover_inertia = 2.3e-7_dp
      train%load_inertia = 2.3e-7_dp
      train%characteristic_length = 30e-6_dp
      train%characteristic_frequency = 9870
      train%shafts = [shaft_type(stiffness=1e3_dp, damping_ratio=0.01_dp), &
                      shaft_type(stiffness=1e8_dp, damping_ratio=0.01_dp), &
                      shaft_type(stiffness=1e3_dp, damping_ratio=0.01_dp)]
      allocate (train%meshes(2))
      train%meshes%driving_radius = 0.05_dp
      train%meshes%driven_radius = 0.1_dp
      train%meshes%driving_inertia = [0.0023_dp, 0.0046_dp]
      train%meshes%driven_inertia = [0.037_dp, 0.074_dp]
      train%meshes%stiffness = [2.5e8_dp, 5e8_dp]
      train%meshes%damping_ratio = 0.05_dp
      train%meshes%half_backlash = 30e-6_dp
      train%meshes(1)%stiffness_cos = [amplitude]
      train%meshes(2)%stiffness_cos = [amplitude]
   end function paper_train

   !> x'' + 2 zeta x' + (1 + kappa cos Lambda t) g(x) = f with b = 1: two gears on rigid shafts without machines; r = 1 m,
   !> I = 2 kg m^2 each (mass 1 kg along the line of action), k = 1 N/m, b = 1 m, torque f N m.
   function single_pair(zeta, kappa, f) result(train)
      real(dp), intent(in) :: zeta, kappa, f
      type(train_type) :: train

      train%title = 'single gear pair'
      train%input_torque = f
      train%characteristic_length = 1
      train%characteristic_frequency = 1
      train%shafts = [shaft_type(rigid=.true.), shaft_type(rigid=.true.)]
      allocate (train%meshes(1))
      train%meshes(1)%driving_radius = 1
      train%meshes(1)%driven_radius = 1
      train%meshes(1)%driving_inertia = 2
      train%meshes(1)%driven_inertia = 2
      train%meshes(1)%stiffness = 1
      train%meshes(1)%damping_ratio = zeta
      train%meshes(1)%half_backlash = 1
      train%meshes(1)%stiffness_cos = [kappa]
   end function single_pair

   !> A train of M shafts with everything that the model has: torque harmonics, transmission errors with phases, sin terms,
   !> unequal backlash, one linear mesh with constant stiffness, one rigid shaft, orders 1 and 2.
   function long_train(shafts) result(train)
      integer, intent(in) :: shafts
      type(train_type) :: train
      integer :: j

      train%title = 'everything'
      train%input_torque = 120
      train%torque_cos = [5.0_dp]
      train%torque_sin = [-3.0_dp, 2.0_dp]
      train%prime_mover_inertia = 0.004_dp
      train%load_inertia = 0.02_dp
      train%characteristic_length = 20e-6_dp
      train%characteristic_frequency = 9000
      allocate (train%shafts(shafts), train%meshes(shafts - 1))
      do j = 1, shafts
         train%shafts(j)%stiffness = 2e5_dp*j
         train%shafts(j)%damping_ratio = 0.03_dp
      end do
      if (shafts > 2) train%shafts(2) = shaft_type(rigid=.true.)
      do j = 1, shafts - 1
         associate (mesh => train%meshes(j))
            mesh%driving_radius = 0.05_dp + 0.003_dp*j
            mesh%driven_radius = 0.08_dp - 0.002_dp*j
            mesh%driving_inertia = 0.002_dp + 0.001_dp*j
            mesh%driven_inertia = 0.01_dp + 0.002_dp*j
            mesh%stiffness = 3e8_dp + 2e7_dp*j
            mesh%damping_ratio = 0.05_dp
            mesh%half_backlash = 20e-6_dp + 5e-6_dp*j
            mesh%stiffness_cos = [0.12_dp, 0.03_dp]
            mesh%stiffness_sin = [0.05_dp]
            mesh%error_cos = [1e-6_dp*j]
            mesh%error_sin = [0.5e-6_dp, -0.3e-6_dp]
            mesh%order = 1 + mod(j, 2)
            if (j == 2) then
               mesh%half_backlash = 0
               mesh%stiffness_cos = [real(dp) ::]
               mesh%stiffness_sin = [real(dp) ::]
            end if
         end associate
      end do
   end function long_train

   !> Settings of a response.
   function settings_of(start, stop, harmonics, subharmonic) result(settings)
      real(dp), intent(in) :: start, stop
      integer, intent(in) :: harmonics
      integer, intent(in), optional :: subharmonic
      type(response_settings_type) :: settings

      settings%start = start
      settings%stop = stop
      settings%harmonics = harmonics
      if (present(subharmonic)) settings%subharmonic = subharmonic
   end function settings_of

   !> Index of the motion whose rms of mesh 1 is closest to a value; 0 if there is none.
   integer function closest(motions, rms)
      type(motion_type), intent(in) :: motions(:)
      real(dp), intent(in) :: rms
      integer :: i

      closest = 0
      do i = 1, size(motions)
         if (closest == 0) then
            closest = i
         else if (abs(motions(i)%rms(1) - rms) < abs(motions(closest)%rms(1) - rms)) then
            closest = i
         end if
      end do
   end function closest

end module fixtures
