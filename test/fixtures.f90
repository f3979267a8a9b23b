!> Trains of the tests, and what their settings are made from; random ones are the same on every machine.
module fixtures
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain, only: body_type, case_type, dp, mesh_type, motion_type, response_settings_type, shaft_type, train_type
   use geartrain_base_kinds, only: pi
   use geartrain_input_template, only: paper_case
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: fine_samples
   use geartrain_mesh_law_contact, only: contact_type
   implicit none (type, external)
   private
   public :: body, closest, linear_pair, long_train, paper_train, planetary_stage, random_train, rattling_pair, rectangular, &
             reducer, ring, settings_of, single_pair, slow_train, uniform, update_contact

contains

   pure type(body_type) function body(name, inertia, torque, balances)
      character(*), intent(in) :: name
      real(dp), intent(in) :: inertia
      real(dp), intent(in), optional :: torque
      logical, intent(in), optional :: balances

      body%name = name
      body%inertia = inertia
      if (present(torque)) body%torque = torque
      if (present(balances)) body%balances = balances
   end function body

   !> Table 1 of Al-shyyab and Kahraman (2007), k3 = 1e8 N m/rad, 150 N m.
   function paper_train(kappa) result(train)
      !> First harmonic of both mesh stiffnesses [1]; default 0.3.
      real(dp), intent(in), optional :: kappa
      type(train_type) :: train
      type(case_type) :: case
      integer :: j

      case = paper_case()
      train = case%train
      if (.not. present(kappa)) return
      do j = 1, size(train%meshes)
         train%meshes(j)%stiffness_cos = [kappa]
      end do
   end function paper_train

   !> A set with its ring held, driven at the sun, in short form.
   function planetary_stage(teeth, planets) result(train)
      integer, intent(in) :: teeth(3), planets
      type(train_type) :: train

      train%characteristic_length = 1e-5_dp
      train%characteristic_frequency = 2e4_dp
      train%bodies = [body('sun', 8.2e-4_dp, 300.0_dp), body('ring', 0.0_dp), body('arm', 0.085_dp, balances=.true.)]
      train%bodies(2)%held = .true.
      allocate (train%shafts(0), train%meshes(0), train%planetaries(1))
      associate (set => train%planetaries(1))
         set%name = 's'
         set%sun = 'sun'
         set%ring = 'ring'
         set%carrier = 'arm'
         set%teeth = real(teeth, dp)
         set%planets = planets
         set%normal_module = 4e-3_dp
         set%planet_inertia = 2.2e-3_dp
         set%stiffness = [1e9_dp, 1.2e9_dp]
         set%half_backlash = [20e-6_dp, 25e-6_dp]
         set%damping_ratio = [0.03_dp]
         set%stiffness_harmonics = 2
      end associate
   end function planetary_stage

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

   !> The paper's train with a mesh stiffness of five harmonics, about a rectangular wave (figure 8).
   function rectangular(fifth) result(train)
      !> Fifth harmonic of both mesh stiffnesses [1].
      real(dp), intent(in) :: fifth
      type(train_type) :: train

      train = paper_train()
      train%meshes(1)%stiffness_cos = [0.42_dp, 0.0_dp, -0.141_dp, 0.0_dp, fifth]
      train%meshes(2)%stiffness_cos = train%meshes(1)%stiffness_cos
   end function rectangular

   !> x'' + 0.2 x' + x = f + 0.5 cos Lambda t: the pair without backlash, of constant stiffness.
   function linear_pair(load) result(train)
      !> Static mesh force [N].
      real(dp), intent(in) :: load
      type(train_type) :: train

      train = single_pair(0.1_dp, 0.0_dp, load)
      train%meshes(1)%half_backlash = 0
      train%torque_cos = [1.0_dp]
   end function linear_pair

   !> The first pair of the paper's train alone, under a torque that swings by 10 N m.
   function rattling_pair(torque) result(train)
      !> Mean torque [N m].
      real(dp), intent(in) :: torque
      type(train_type) :: train

      train = paper_train()
      train%title = 'rattling pair'
      train%input_torque = torque
      train%torque_cos = [10.0_dp]
      train%prime_mover_inertia = 0
      train%load_inertia = 0
      train%shafts = [shaft_type(rigid=.true.), shaft_type(rigid=.true.)]
      train%meshes = train%meshes(:1)
   end function rattling_pair

   !> 23/71 and 19/80 teeth, modules of 2.5 and 4 mm, faces of 40 and 70 mm, 20 and 15 degrees, solid discs, steel shafts; Lambda
   !> counts 1000 rpm of the first shaft.
   function reducer() result(train)
      type(train_type) :: train
      real(dp), parameter :: degree = pi/180, teeth(2, 2) = reshape([23, 71, 19, 80], [2, 2]), &
                             module_(2) = [2.5e-3_dp, 4e-3_dp], face(2) = [0.04_dp, 0.07_dp], &
                             diameter(3) = [0.03_dp, 0.04_dp, 0.06_dp], length(3) = [0.15_dp, 0.12_dp, 0.2_dp]
      real(dp) :: pitch(2), transverse
      integer :: j

      train%input_torque = 90
      train%prime_mover_inertia = 0.02_dp
      train%load_inertia = 1.5_dp
      train%characteristic_length = 1e-6_dp
      train%characteristic_frequency = 2*pi*1000/60*23/71
      allocate (train%shafts(3), train%meshes(2))
      train%shafts%stiffness = 8e10_dp*pi*diameter**4/32/length
      train%shafts%damping_ratio = 0.01_dp
      transverse = atan(tan(20*degree)/cos(15*degree))
      do j = 1, 2
         pitch = module_(j)*teeth(:, j)/cos(15*degree)
         associate (mesh => train%meshes(j))
            mesh%driving_radius = pitch(1)/2*cos(transverse)
            mesh%driven_radius = pitch(2)/2*cos(transverse)
            mesh%driving_inertia = 7850*face(j)*pi*pitch(1)**4/32
            mesh%driven_inertia = 7850*face(j)*pi*pitch(2)**4/32
            mesh%stiffness = 14e9_dp*face(j)
            mesh%damping_ratio = 0.05_dp
            mesh%half_backlash = 28e-6_dp
            mesh%stiffness_cos = [0.1_dp, 0.05_dp, 0.02_dp]
            mesh%error_cos = [3e-6_dp]
         end associate
      end do
      train%meshes%order = [71, 19]
   end function reducer

   !> Motor, a ring of four gears with two ways from gear a to gear d, and a load.
   function ring() result(train)
      type(train_type) :: train
      integer :: j

      train%characteristic_length = 3e-5_dp
      train%characteristic_frequency = 9870
      train%bodies = [body('motor', 2.3e-3_dp, 150.0_dp), body('a', 2.3e-3_dp), body('b', 4.6e-3_dp), body('c', 4e-3_dp), &
                      body('d', 0.037_dp), body('load', 0.023_dp, balances=.true.)]
      train%shafts = [shaft_type(between=[character(64) :: 'motor', 'a'], stiffness=1e4_dp, damping_ratio=0.1_dp), &
                      shaft_type(between=[character(64) :: 'd', 'load'], stiffness=2e4_dp, damping_ratio=0.1_dp)]
      allocate (train%meshes(4))
      train%meshes(1) = mesh_type(between=[character(64) :: 'a', 'b'], driving_radius=0.05_dp, driven_radius=0.06_dp)
      train%meshes(2) = mesh_type(between=[character(64) :: 'a', 'c'], driving_radius=0.05_dp, driven_radius=0.055_dp)
      train%meshes(3) = mesh_type(between=[character(64) :: 'b', 'd'], driving_radius=0.06_dp, driven_radius=0.1_dp)
      train%meshes(4) = mesh_type(between=[character(64) :: 'c', 'd'], driving_radius=0.055_dp, driven_radius=0.1_dp)
      do j = 1, 4
         train%meshes(j)%stiffness = 2e8_dp + 2e7_dp*j
         train%meshes(j)%damping_ratio = 0.05_dp
         train%meshes(j)%half_backlash = 3e-5_dp
         train%meshes(j)%stiffness_cos = [0.3_dp - 0.05_dp*j]
         train%meshes(j)%error_sin = [1e-6_dp*j]
      end do
   end function ring

   !> One to three pairs: equal stages or not, orders 1, alike up to 80 or unlike up to 7, shafts with and without damping, torque
   !> of either sign; a range below, at or above the first resonance; few harmonics. Each statement draws one number: in which order
   !> an expression calls functions, and whether it calls all of them, depends on the compiler's flags, and so would the train.
   subroutine random_train(seed, train, settings)
      integer, intent(in) :: seed
      type(train_type), intent(out) :: train
      type(response_settings_type), intent(out) :: settings
      integer(int64) :: generator
      integer :: i, j, meshes, order, highest
      logical :: equal, damped
      real(dp) :: sense, start

      generator = 7919_int64*seed + 17
      do i = 1, 10
         start = share()
      end do
      meshes = 1 + int(3*share())
      equal = share() < 0.3_dp
      damped = share() < 0.7_dp
      sense = share()
      train%input_torque = merge(1, -1, sense < 0.75_dp)*(50 + 250*share())
      train%prime_mover_inertia = 0.001_dp*(0.2_dp + 3*share())
      train%load_inertia = 0.001_dp*(0.2_dp + 3*share())
      train%characteristic_length = 30e-6_dp
      train%characteristic_frequency = 1e4_dp
      allocate (train%shafts(meshes + 1), train%meshes(meshes))
      do j = 1, meshes + 1
         train%shafts(j) = shaft_type(stiffness=10**(3 + 3*share()), damping_ratio=merge(0.02_dp, 0.0_dp, damped))
         if (share() < 0.3_dp) train%shafts(j) = shaft_type(rigid=.true.)
      end do
      order = 1
      if (share() < 0.4_dp) order = 2 + int(79*share())
      highest = order
      do j = 1, meshes
         associate (mesh => train%meshes(j))
            mesh%driving_radius = 0.03_dp + 0.04_dp*share()
            mesh%driven_radius = 0.03_dp + 0.08_dp*share()
            mesh%driving_inertia = 0.001_dp + 0.006_dp*share()
            mesh%driven_inertia = 0.002_dp + 0.04_dp*share()
            mesh%stiffness = 1e8_dp + 4e8_dp*share()
            mesh%damping_ratio = 0.02_dp + 0.06_dp*share()
            mesh%half_backlash = 10e-6_dp + 50e-6_dp*share()
            mesh%stiffness_cos = [0.05_dp + 0.3_dp*share()]
            mesh%stiffness_sin = [0.1_dp*share()]
            mesh%error_cos = [5e-6_dp*share()]
            mesh%order = order
            if (order == 1 .and. j > 1) then
               if (share() < 0.5_dp) mesh%order = 1 + int(7*share())
            end if
            highest = max(highest, mesh%order)
         end associate
         if (equal .and. j > 1) train%meshes(j) = train%meshes(1)
      end do
      if (equal) highest = train%meshes(1)%order
      start = (0.2_dp + 1.8_dp*share())/highest
      settings = settings_of(start, 1.3_dp*start, highest*(2 + int(6*share())))
      settings%max_points = 400

   contains

      real(dp) function share()
         share = uniform(generator, 0.0_dp, 1.0_dp)
      end function share

   end subroutine random_train

   !> The next train of a list, and Lambda, in the natural frequency of the first mesh alone: 2 to 5 flexible shafts of damping
   !> ratio .005 to .04, meshes with backlash, of damping ratio .01 to .06.
   subroutine slow_train(generator, train, frequency_ratio)
      !> State of the generator; 1 begins the list.
      integer(int64), intent(inout) :: generator
      type(train_type), intent(out) :: train
      real(dp), intent(out) :: frequency_ratio
      real(dp) :: inverse
      integer :: i, m

      m = min(4, 1 + int(uniform(generator, 0.0_dp, 4.0_dp)))
      train%title = 'random'
      train%input_torque = uniform(generator, 40.0_dp, 250.0_dp)
      train%prime_mover_inertia = logarithmic(generator, 1e-3_dp, 0.03_dp)
      train%load_inertia = logarithmic(generator, 1e-3_dp, 0.03_dp)
      train%characteristic_length = 30e-6_dp
      allocate (train%shafts(m + 1), train%meshes(m))
      do i = 1, m + 1
         train%shafts(i)%stiffness = logarithmic(generator, 3e4_dp, 3e6_dp)
         train%shafts(i)%damping_ratio = uniform(generator, 0.005_dp, 0.04_dp)
      end do
      do i = 1, m
         associate (mesh => train%meshes(i))
            mesh%driving_radius = uniform(generator, 0.03_dp, 0.08_dp)
            mesh%driven_radius = mesh%driving_radius*uniform(generator, 1.0_dp, 2.5_dp)
            mesh%driving_inertia = 0.002_dp*(mesh%driving_radius/0.05_dp)**4*uniform(generator, 0.5_dp, 2.0_dp)
            mesh%driven_inertia = 0.002_dp*(mesh%driven_radius/0.05_dp)**4*uniform(generator, 0.5_dp, 2.0_dp)
            mesh%stiffness = uniform(generator, 1e8_dp, 6e8_dp)
            mesh%damping_ratio = uniform(generator, 0.01_dp, 0.06_dp)
            mesh%half_backlash = uniform(generator, 10e-6_dp, 50e-6_dp)
            mesh%stiffness_cos = [uniform(generator, 0.1_dp, 0.4_dp)]
            mesh%stiffness_sin = [uniform(generator, -0.2_dp, 0.2_dp)]
            mesh%order = 1 + int(uniform(generator, 0.0_dp, 2.5_dp))
         end associate
      end do
      associate (mesh => train%meshes(1))
         inverse = mesh%driving_radius**2/mesh%driving_inertia + mesh%driven_radius**2/mesh%driven_inertia
         train%characteristic_frequency = sqrt(mesh%stiffness*inverse)
      end associate
      frequency_ratio = uniform(generator, 0.3_dp, 2.0_dp)
   end subroutine slow_train

   !> Park and Miller's minimal standard generator, from `least` to `most`.
   real(dp) function uniform(generator, least, most)
      integer(int64), intent(inout) :: generator
      real(dp), intent(in) :: least, most

      generator = mod(48271_int64*generator, 2147483647_int64)
      uniform = least + (most - least)*real(generator, dp)/2147483647.0_dp
   end function uniform

   real(dp) function logarithmic(generator, least, most)
      integer(int64), intent(inout) :: generator
      real(dp), intent(in) :: least, most

      logarithmic = least*exp(uniform(generator, 0.0_dp, log(most/least)))
   end function logarithmic

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

   !> The contact of a mesh under the displacement of coefficients u.
   subroutine update_contact(contact, u)
      type(contact_type), intent(inout) :: contact
      real(dp), intent(in) :: u(:)
      type(transform_type) :: fine

      call fine%plan(fine_samples(maxval(contact%harmonic)))
      call contact%update(u, fine)
   end subroutine update_contact

end module fixtures
