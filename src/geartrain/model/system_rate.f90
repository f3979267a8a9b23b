!> Derivatives of the dimensionless system with respect to a parameter of its train, at constant units.
!>
!> Radii, inertias, stiffnesses and dampings go through the network in closed form. The rows of the mesh laws, the forces at rest,
!> the equations of the mean of loops and the paths of the torques through rigid shafts are differences of what makes them: each is
!> a short smooth formula, of which a difference over a relative change of 3e-6 is exact to about 1e-10.
module geartrain_model_system_rate
   use geartrain_base_kinds, only: dp
   use geartrain_base_series, only: make_series, series_type
   use geartrain_mesh_law_law, only: law_type
   use geartrain_model_mean, only: mean_rows, mean_type
   use geartrain_model_mesh, only: mesh_type, put_law
   use geartrain_model_network, only: network_type
   use geartrain_model_network_rate, only: find_network_rate, network_rate_type, shifted
   use geartrain_model_rest, only: rest_forces
   use geartrain_model_system, only: system_type
   use geartrain_model_torque_paths, only: find_torque_paths, torque_paths_type
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: system_rate_type, find_system_rate

   !> Relative change of the numbers of the train for differences.
   real(dp), parameter :: small = 3e-6_dp

   !> Derivatives [1/unit of the parameter], shapes as in system_type.
   type :: system_rate_type
      type(network_rate_type) :: network
      !> Of the forces at rest over k b_c, and of gamma of each element on its drive flank, (element).
      real(dp), allocatable :: static_force(:), damping(:)
      !> Rows of the derivative of each law, whose regions and origins are those of the law; whether there is any, (mesh).
      type(law_type), allocatable :: law(:)
      logical, allocatable :: law_changes(:)
      type(series_type), allocatable :: transmission_error(:), torque(:)
      type(mean_type) :: mean
      type(torque_paths_type) :: paths
   end type system_rate_type

contains

   !> Finds the derivatives.
   pure subroutine find_system_rate(train, rate, system, d)
      !> A plain train; the derivatives of its numbers.
      type(train_type), intent(in) :: train, rate
      !> System of the train.
      type(system_type), intent(in) :: system
      !> The derivatives; of the same system from call to call.
      type(system_rate_type), intent(inout) :: d
      type(law_type) :: above(system%meshes), below(system%meshes)
      real(dp) :: step, fastest
      integer :: j

      call find_network_rate(train, rate, system%network, d%network)
      if (d%network%locks) return
      if (.not. allocated(d%damping)) call begin(system, d)
      associate (network => d%network, bc => system%characteristic_length)
         d%damping = (network%element_damping - system%network%elements%damping*network%stiffness/system%stiffness) &
                     *system%characteristic_frequency/system%stiffness
         fastest = network%fastest
         do j = 1, system%meshes
            associate (n => system%mesh_element(j))
               fastest = max(fastest, speed_of(train%meshes(j), rate%meshes(j)), &
                             abs(d%damping(n))/merge(system%damping(n), huge(step), system%damping(n) > 0))
            end associate
         end do
         step = 1
         if (fastest > 0) step = small/fastest
         do j = 1, system%meshes
            associate (n => system%mesh_element(j), mesh => rate%meshes(j))
               d%law_changes(j) = speed_of(train%meshes(j), mesh) > 0 .or. system%law(j)%jumps .and. abs(d%damping(n)) > 0
               if (d%law_changes(j)) then
                  call put_law(shifted_mesh(train%meshes(j), mesh, step), bc, above(j))
                  call above(j)%complete(system%damping(n) + step*d%damping(n))
                  call put_law(shifted_mesh(train%meshes(j), mesh, -step), bc, below(j))
                  call below(j)%complete(system%damping(n) - step*d%damping(n))
                  call difference_of_laws(system%law(j), above(j), below(j), 2*step, d%law(j))
               end if
               call put_series(mesh%error_cos, mesh%error_sin, 1/bc, train%meshes(j)%order, d%transmission_error(j))
            end associate
         end do
         call put_torques(train, rate, system, d)
         call put_means(system, above, below, step, d)
         d%paths%known = system%torque_paths%known
         d%paths%constant = 0
         d%paths%torque_gain = 0
         d%paths%gain = network%element_radius(1, system%torque_paths%element)
         if (any(train%shafts%rigid)) call put_rigid(train, rate, system, step, d)
      end associate
   end subroutine find_system_rate

   !> Makes room.
   pure subroutine begin(system, d)
      type(system_type), intent(in) :: system
      type(system_rate_type), intent(inout) :: d
      integer :: j

      allocate (d%static_force, d%damping, mold=system%damping)
      allocate (d%law(system%meshes), d%law_changes(system%meshes), d%transmission_error(system%meshes))
      allocate (d%torque(size(system%torque)))
      do j = 1, system%meshes
         allocate (d%transmission_error(j)%harmonic(0), d%transmission_error(j)%amplitude(0))
      end do
      do j = 1, size(d%torque)
         allocate (d%torque(j)%harmonic(0), d%torque(j)%amplitude(0))
      end do
      allocate (d%mean%force, d%mean%displacement, mold=system%mean%force)
      allocate (d%mean%follow, mold=system%mean%follow)
      allocate (d%paths%constant(system%torque_paths%shafts))
      allocate (d%paths%torque_gain, mold=system%torque_paths%torque_gain)
   end subroutine begin

   !> Series of cos and sin amplitudes; most parameters have none.
   pure subroutine put_series(cosine, sine, factor, order, series)
      real(dp), allocatable, intent(in) :: cosine(:), sine(:)
      real(dp), intent(in) :: factor
      integer, intent(in) :: order
      type(series_type), intent(inout) :: series
      logical :: some

      some = size(series%amplitude) > 0
      if (allocated(cosine)) some = some .or. any(abs(cosine) > 0)
      if (allocated(sine)) some = some .or. any(abs(sine) > 0)
      if (some) series = make_series(cosine, sine, factor, order)
   end subroutine put_series

   !> Largest relative rate of what makes the law of a mesh; kappa is of order 1, a phase likewise.
   pure real(dp) function speed_of(mesh, rate)
      type(mesh_type), intent(in) :: mesh, rate

      speed_of = abs(rate%back_phase)
      if (mesh%half_backlash > 0) speed_of = max(speed_of, abs(rate%half_backlash)/mesh%half_backlash)
      if (mesh%back_stiffness > 0) &
         speed_of = max(speed_of, abs(rate%back_stiffness)/mesh%back_stiffness, abs(rate%stiffness)/mesh%stiffness)
      if (allocated(rate%stiffness_cos)) speed_of = max(speed_of, maxval(abs(rate%stiffness_cos)))
      if (allocated(rate%stiffness_sin)) speed_of = max(speed_of, maxval(abs(rate%stiffness_sin)))
   end function speed_of

   !> A mesh with the parameter changed, as far as its law goes.
   pure type(mesh_type) function shifted_mesh(mesh, rate, step) result(changed)
      type(mesh_type), intent(in) :: mesh, rate
      real(dp), intent(in) :: step

      changed = mesh
      changed%stiffness = mesh%stiffness + step*rate%stiffness
      changed%half_backlash = mesh%half_backlash + step*rate%half_backlash
      changed%back_stiffness = mesh%back_stiffness + step*rate%back_stiffness
      changed%back_phase = mesh%back_phase + step*rate%back_phase
      call shift(changed%stiffness_cos, rate%stiffness_cos)
      call shift(changed%stiffness_sin, rate%stiffness_sin)

   contains

      !> Adds to a list. Either list may lack values that are 0.
      pure subroutine shift(list, rates)
         real(dp), allocatable, intent(inout) :: list(:)
         real(dp), allocatable, intent(in) :: rates(:)

         if (.not. allocated(rates)) return
         if (.not. allocated(list)) allocate (list(0))
         if (size(list) < size(rates)) list = [list, spread(0.0_dp, 1, size(rates) - size(list))]
         list(:size(rates)) = list(:size(rates)) + step*rates
      end subroutine shift

   end function shifted_mesh

   !> Rows of (above - below)/step.
   pure subroutine difference_of_laws(law, above, below, step, d)
      type(law_type), intent(in) :: law, above, below
      real(dp), intent(in) :: step
      type(law_type), intent(out) :: d
      integer :: h

      d = law
      d%wall(:) = (above%wall - below%wall)/step
      d%stiffness(:) = (above%stiffness - below%stiffness)/step
      d%origin(:) = (above%origin - below%origin)/step
      d%damping(:) = (above%damping - below%damping)/step
      d%impulse(:) = (above%impulse - below%impulse)/step
      ! An amplitude that is 0 may be missing in one of them.
      d%harmonic = [above%harmonic, pack(below%harmonic, [(all(above%harmonic /= below%harmonic(h)), h=1, size(below%harmonic))])]
      deallocate (d%amplitude)
      allocate (d%amplitude(size(d%harmonic), law%lowest:law%highest), source=(0.0_dp, 0.0_dp))
      d%amplitude(:size(above%harmonic), :) = above%amplitude/step
      do h = 1, size(below%harmonic)
         associate (row => d%amplitude(findloc(d%harmonic, below%harmonic(h), 1), :))
            row = row - below%amplitude(h, :)/step
         end associate
      end do
   end subroutine difference_of_laws

   !> Sets the derivatives of the fluctuating torques.
   pure subroutine put_torques(train, rate, system, d)
      type(train_type), intent(in) :: train, rate
      type(system_type), intent(in) :: system
      type(system_rate_type), intent(inout) :: d
      integer :: j

      associate (factor => 1/system%characteristic_length)
         if (.not. allocated(train%bodies)) call put_series(rate%torque_cos, rate%torque_sin, factor, 1, d%torque(1))
         if (.not. allocated(train%bodies)) return
         do j = 1, size(d%torque)
            associate (body => rate%bodies(system%torque_body(j)))
               if (j <= size(train%bodies)) then
                  call put_series(body%torque_cos, body%torque_sin, factor, 1, d%torque(j))
               else
                  call put_series(body%revolution_torque_cos, body%revolution_torque_sin, factor, &
                                  train%bodies(system%torque_body(j))%revolution_order, d%torque(j))
               end if
            end associate
         end do
      end associate
   end subroutine put_torques

   !> Sets the derivatives of the forces at rest and of the equations of the mean.
   pure subroutine put_means(system, above, below, step, d)
      type(system_type), intent(in) :: system
      type(law_type), intent(in) :: above(:), below(:)
      real(dp), intent(in) :: step
      type(system_rate_type), intent(inout) :: d
      type(network_type) :: network
      type(law_type), allocatable :: law(:)
      type(mean_type) :: mean(2)
      real(dp) :: force(system%elements, 2), residual
      logical :: loops
      integer :: i, j

      loops = size(system%network%loop, 1) > count(system%network%elements%grounded) - (system%coordinates - system%displacements)
      d%mean%force = 0
      d%mean%displacement = 0
      d%mean%follow = 0
      if (loops .or. any(abs(d%network%torque) > 0) .or. any(abs(d%network%element_radius) > 0)) then
         do i = 1, 2
            network = shifted(system%network, d%network, merge(step, -step, i == 1))
            law = system%law
            do j = 1, system%meshes
               if (.not. d%law_changes(j)) cycle
               law(j) = below(j)
               if (i == 1) law(j) = above(j)
            end do
            call rest_forces(network, law, system%characteristic_length, force(:, i), residual)
            force(:, i) = force(:, i)/(network%elements%stiffness*system%characteristic_length)
            if (loops) call mean_rows(network, system%cut, force(:, i), mean(i))
         end do
         d%static_force = (force(:, 1) - force(:, 2))/(2*step)
      else
         d%static_force = -system%static_force*d%network%stiffness/system%stiffness
      end if
      d%mean%static_force = d%static_force(system%cut%element)
      if (.not. loops) return
      d%mean%force = (mean(1)%force - mean(2)%force)/(2*step)
      d%mean%displacement = (mean(1)%displacement - mean(2)%displacement)/(2*step)
      d%mean%static_force = (mean(1)%static_force - mean(2)%static_force)/(2*step)
      d%mean%follow = (mean(1)%follow - mean(2)%follow)/(2*step)
   end subroutine put_means

   !> Sets the derivatives of the paths of torques, with rigid shafts.
   pure subroutine put_rigid(train, rate, system, step, d)
      type(train_type), intent(in) :: train, rate
      type(system_type), intent(in) :: system
      real(dp), intent(in) :: step
      type(system_rate_type), intent(inout) :: d
      type(train_type) :: changed
      type(network_type) :: network
      type(torque_paths_type) :: paths(2)
      real(dp) :: h
      integer :: i, j

      do i = 1, 2
         h = merge(step, -step, i == 1)
         changed = train
         changed%input_torque = train%input_torque + h*rate%input_torque
         changed%prime_mover_inertia = train%prime_mover_inertia + h*rate%prime_mover_inertia
         changed%load_inertia = train%load_inertia + h*rate%load_inertia
         do j = 1, size(train%meshes)
            changed%meshes(j)%driving_inertia = train%meshes(j)%driving_inertia + h*rate%meshes(j)%driving_inertia
            changed%meshes(j)%driven_inertia = train%meshes(j)%driven_inertia + h*rate%meshes(j)%driven_inertia
         end do
         if (allocated(train%bodies)) then
            do j = 1, size(train%bodies)
               changed%bodies(j)%inertia = train%bodies(j)%inertia + h*rate%bodies(j)%inertia
               changed%bodies(j)%torque = train%bodies(j)%torque + h*rate%bodies(j)%torque
               changed%bodies(j)%damping_to_ground = train%bodies(j)%damping_to_ground + h*rate%bodies(j)%damping_to_ground
            end do
         end if
         network = shifted(system%network, d%network, h)
         call find_torque_paths(changed, network, system%torque_body, paths(i))
      end do
      d%paths%constant = (paths(1)%constant - paths(2)%constant)/(2*step)
      ! A path may end where a gain is 0: an inertia of 0 on a rigid shaft that gets some.
      if (size(paths(1)%gain) /= size(d%paths%gain) .or. size(paths(2)%gain) /= size(d%paths%gain) .or. &
          size(paths(1)%torque_gain) /= size(d%paths%torque_gain) .or. size(paths(2)%torque_gain) /= size(d%paths%torque_gain)) then
         d%paths%known = .false.
         return
      end if
      d%paths%gain = (paths(1)%gain - paths(2)%gain)/(2*step)
      d%paths%torque_gain = (paths(1)%torque_gain - paths(2)%torque_gain)/(2*step)
   end subroutine put_rigid

end module geartrain_model_system_rate
