!> Networks: how they rest under their mean torques, what of them is refused, and which of their meshes sets the scale.
module unit_network
   use fixtures, only: body, ring, settings_of
   use geartrain, only: branch_type, dp, error_type, mesh_type, response, shaft_type, train_type
   use geartrain_network_check_train, only: check_train
   use geartrain_network_network, only: build_network, network_type
   use geartrain_network_rest, only: largest_residual, rest_forces
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_labels, only: mesh_labels, shaft_labels
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: network_checks

contains

   subroutine network_checks(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('idle')) call idle(tests)
      if (tests%runs('shared')) call shared(tests)
      if (tests%runs('one_body')) call one_body(tests)
      if (tests%runs('soft_mesh')) call soft_mesh(tests)
      if (tests%runs('labels')) call labels(tests)
   end subroutine network_checks

   !> Gear a drives gear b; a wheel hangs on a further mesh of gear b.
   function with_wheel() result(train)
      type(train_type) :: train

      train%characteristic_length = 1e-5_dp
      train%characteristic_frequency = 1e4_dp
      train%bodies = [body('a', 1e-3_dp, 0.6_dp), body('b', 2e-3_dp, balances=.true.), body('wheel', 3e-3_dp), &
                      body('rim', 1e-3_dp)]
      train%shafts = [shaft_type(between=[character(64) :: 'wheel', 'rim'], stiffness=1e5_dp, damping_ratio=0.1_dp)]
      train%meshes = [mesh_type(between=[character(64) :: 'a', 'b'], driving_radius=0.05_dp, driven_radius=0.07_dp, &
                                stiffness=1e8_dp, half_backlash=1e-5_dp), &
                      mesh_type(between=[character(64) :: 'b', 'wheel'], driving_radius=0.07_dp, driven_radius=0.03_dp, &
                                stiffness=1e8_dp, half_backlash=1e-5_dp)]
   end function with_wheel

   !> The bodies at the ends name a mesh or a shaft, no two of them alike, whatever the bodies are called.
   subroutine labels(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train

      train = with_wheel()
      train%meshes = [train%meshes, train%meshes, train%meshes(2)]
      train%meshes(4)%between(2) = 'wheel (2)'
      call tests%is_true(all(shaft_labels(train) == 'wheel - rim'), 'a shaft')
      call tests%is_true(all(mesh_labels(train) == [character(24) :: 'a - b', 'b - wheel', 'a - b (2)', 'b - wheel (2)', &
                                                    'b - wheel (3)']), 'equal pairs, and a body called wheel (2)')
      deallocate (train%bodies)
      train%meshes%between(1) = ''
      train%shafts%between(1) = ''
      call tests%is_true(all(mesh_labels(train) == [character(24) :: 'mesh 1', 'mesh 2', 'mesh 3', 'mesh 4', 'mesh 5']) .and. &
                         all(shaft_labels(train) == 'shaft 1'), 'a chain')
   end subroutine labels

   !> Nothing drives the wheel, or its torques cancel, by their sum or up to the rounding of it: it bears no force at all.
   subroutine idle(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(system_type) :: system

      train = with_wheel()
      call build_system(train, system)
      call tests%is_true(.not. abs(system%static_force(system%mesh_element(2))) > 0, 'an idle wheel')
      train%bodies(3:4)%torque = [7.1_dp, -7.1_dp]
      call build_system(train, system)
      call tests%is_true(.not. abs(system%static_force(system%mesh_element(2))) > 0, 'two torques that cancel')
      call tests%is_close(system%static_force(system%mesh_element(1)), 0.6_dp/0.05_dp/(1e8_dp*1e-5_dp), 1e-15_dp, &
                          'the mesh that drives')
      train%bodies = [train%bodies, body('third', 1e-3_dp, -0.3_dp)]
      train%shafts = [train%shafts, shaft_type(between=[character(64) :: 'third', 'wheel'], rigid=.true.)]
      train%bodies(3:4)%torque = [0.1_dp, 0.2_dp]
      call tests%is_true(abs(0.1_dp + 0.2_dp - 0.3_dp) > 0, 'torques that cancel but for their rounding')
      call build_system(train, system)
      call tests%is_true(.not. abs(system%static_force(system%mesh_element(2))) > 0, &
                         'torques that cancel but for their rounding: none')
      train%bodies(4)%torque = 0.2_dp + 1e-13_dp
      call build_system(train, system)
      call tests%is_true(abs(system%static_force(system%mesh_element(2))) > 0, 'a small torque is one')
   end subroutine idle

   !> How a ring of four meshes shares its torque, whatever its stiffnesses: displacements round the ring agree, forces balance.
   subroutine shared(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(network_type) :: network
      real(dp), allocatable :: force(:)
      real(dp) :: residual
      integer :: i, k

      do i = 1, 4
         do k = -8, 8, 4
            train = ring()
            train%meshes(i)%stiffness = 1e8_dp*10.0_dp**k
            call share('one mesh unlike the others')
            train%meshes%half_backlash = 0
            call share('linear meshes')
            train%meshes(5 - i)%stiffness = 1e8_dp*10.0_dp**(-k)
            call share('two unlike the others')
         end do
      end do
      ! The ring is the same on both sides: a mesh from one side to the other bears nothing.
      train = ring()
      train%bodies(3)%inertia = train%bodies(4)%inertia
      train%meshes%stiffness = 2e8_dp
      train%meshes(2)%driven_radius = 0.06_dp
      train%meshes(4)%driving_radius = 0.06_dp
      train%meshes = [train%meshes, train%meshes(4)]
      train%meshes(5)%between = [character(64) :: 'b', 'c']
      train%meshes(5)%driven_radius = 0.06_dp
      train%meshes(5)%internal = .true.
      call share('a mesh across')
      do i = 1, size(force)
         if (network%elements(i)%mesh == 5) call tests%is_true(.not. abs(force(i)) > 0, 'a mesh across: no force')
         if (network%elements(i)%mesh == 1) call tests%is_close(force(i), 150/0.05_dp/2, 1e-11_dp, 'a mesh across: half of it')
      end do

   contains

      subroutine share(name)
         character(*), intent(in) :: name
         type(system_type) :: system
         real(dp) :: pair(2)
         integer :: j

         call build_network(train, network)
         call build_system(train, system)
         if (allocated(force)) deallocate (force)
         allocate (force(size(network%elements)))
         call rest_forces(network, system%law, train%characteristic_length, force, residual)
         call tests%is_true(residual < largest_residual, name//': displacements agree')
         do j = 1, size(force)
            if (any(network%elements(j)%mesh == [1, 2])) pair(network%elements(j)%mesh) = force(j)
         end do
         call tests%is_close(sum(pair)*0.05_dp, 150.0_dp, 1e-10_dp, name//': forces balance')
      end subroutine share

   end subroutine shared

   !> What joins two bodies that rigid shafts make one is refused.
   subroutine one_body(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(error_type), allocatable :: error

      train = with_wheel()
      train%shafts = [shaft_type(between=[character(64) :: 'b', 'rim'], rigid=.true.), train%shafts, &
                      shaft_type(between=[character(64) :: 'rim', 'wheel'], rigid=.true.)]
      train%meshes(2)%internal = .true.
      train%meshes(2)%driven_radius = train%meshes(2)%driving_radius
      call check_train(train, error)
      call tests%is_true(allocated(error), 'one body: refused')
      if (.not. allocated(error)) return
      call tests%is_text(error%message, "&shaft 2: between = 'wheel', 'rim': are made one body by the rigid &shaft 3: nothing &
                         &moves in between"//new_line('a')//"&mesh 2: between = 'b', 'wheel': are made one body by the rigid &
                         &&shaft 1, &shaft 3: nothing moves in between", 'one body')
   end subroutine one_body

   !> A mesh far softer than those beside it in a loop moves with them: a branch takes no shorter steps for it.
   subroutine soft_mesh(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: usual, soft
      type(error_type), allocatable :: error

      train = ring()
      train%bodies(1)%torque = 400
      train%bodies(4)%torque = -150
      train%meshes(4)%damping_ratio = 0
      train%meshes(4)%stiffness = 1e4_dp
      call response(train, settings_of(1.0_dp, 1.4_dp, 6), usual, error)
      train%meshes(4)%stiffness = 1
      call response(train, settings_of(1.0_dp, 1.4_dp, 6), soft, error)
      call tests%is_true(.not. allocated(error) .and. usual%points > 5, 'a soft mesh in a loop: runs')
      call tests%is_close(real(soft%points, dp), real(usual%points, dp), 3.0_dp, 'a soft mesh in a loop: as many points')
   end subroutine soft_mesh

end module unit_network
