!> Random trees and loops of gears against another code of the same equations.
module validation_random_networks
   use geartrain, only: dp, error_type, integrate, integration_settings_type, motion_type, run_up, &
      run_up_settings_type, run_up_type, train_type
   use geartrain_base_kinds, only: pi
   use geartrain_flow_orbit, only: propagate
   use geartrain_flow_start_state, only: resting_state
   use geartrain_linalg_lapack, only: dgeev
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_bodies, only: find_ends
   use independent, only: accelerate, build_machine, contacts, displacements, fly, joint_forces, machine_type
   use networks, only: draw_laws, random_network
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: random_networks_tests

contains

   subroutine random_networks_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('another_code')) call random_networks(tests)
      if (tests%runs('damping_to_ground')) call dragged_networks(tests)
      if (tests%runs('run_ups')) call run_ups(tests)
      if (tests%runs('accelerated')) call accelerated(tests)
      if (tests%runs('from_walls')) call from_walls(tests)
   end subroutine random_networks_tests

   !> Random trees and loops of up to 12 meshes: their settled motions close in the other code over a period, with the rms and
   !> the multipliers that it finds.
   subroutine random_networks(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: bodies(*) = [4, 5, 6, 8, 10, 12], loops(*) = [0, 1, 0, 2, 1, 0]
      integer :: i

      do i = 1, size(bodies)
         call one_network(tests, bodies(i), loops(i), i, dragged=0, laws=.false.)
         call one_network(tests, bodies(i), loops(i), i, dragged=0, laws=.true.)
      end do
   end subroutine random_networks

   !> With damping to ground of one body or of several, and of bodies without a mean torque.
   subroutine dragged_networks(tests)
      class(tests_type), intent(inout) :: tests

      call one_network(tests, 4, 0, 1, dragged=1, laws=.false.)
      call one_network(tests, 5, 1, 2, dragged=5, laws=.false.)
      call one_network(tests, 6, 0, 3, dragged=3, laws=.false.)
      call one_network(tests, 8, 2, 4, dragged=4, laws=.false.)
      call one_network(tests, 5, 1, 2, dragged=2, laws=.true.)
      call one_network(tests, 8, 2, 4, dragged=1, laws=.true.)
   end subroutine dragged_networks

   !> Ramps of the speed, up and down, from rest: without backlash; with backlash, laws, loops and damping to ground.
   subroutine run_ups(tests)
      class(tests_type), intent(inout) :: tests

      call one_run_up(tests, 4, 0, 1, dragged=0, laws=.false., linear=.true., to=1.6_dp)
      call one_run_up(tests, 8, 2, 4, dragged=2, laws=.false., linear=.true., to=0.3_dp)
      call one_run_up(tests, 6, 0, 3, dragged=0, laws=.false., linear=.false., to=1.6_dp)
      call one_run_up(tests, 8, 2, 4, dragged=1, laws=.true., linear=.false., to=1.6_dp)
      call one_run_up(tests, 5, 1, 2, dragged=2, laws=.true., linear=.false., to=0.3_dp)
   end subroutine run_ups

   !> Likewise with teeth, by which the inertias accelerate with the speed: so fast that loads are reversed on
   !> the way up.
   subroutine accelerated(tests)
      class(tests_type), intent(inout) :: tests

      call one_run_up(tests, 4, 0, 1, dragged=0, laws=.false., linear=.true., to=1.6_dp, toothed=.true.)
      call one_run_up(tests, 8, 2, 4, dragged=2, laws=.false., linear=.false., to=1.6_dp, toothed=.true.)
      call one_run_up(tests, 6, 0, 3, dragged=0, laws=.false., linear=.false., to=1.6_dp, toothed=.true.)
      call one_run_up(tests, 8, 2, 4, dragged=1, laws=.true., linear=.false., to=0.3_dp, toothed=.true.)
   end subroutine accelerated

   !> Idle meshes rest on their walls, and leave them together without any velocity at first: rounding puts each on either side of
   !> its wall and gives it any small velocity. The motions differ by no more than that, and no contact event is passed over.
   subroutine from_walls(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: trials = 12
      real(dp), parameter :: from = 0.8_dp, to = 1.6_dp
      type(train_type) :: train
      type(system_type) :: system
      type(run_up_type) :: found, first
      type(error_type), allocatable :: error
      type(motion_type) :: start
      real(dp), allocatable :: rest(:), noise(:)
      real(dp) :: duration, scale, worst
      integer :: j, trial, on_walls, lost

      call random_network(8, 2, 4 + 1000*tests%seed, train)
      call draw_laws(4 + 1000*tests%seed, train)
      train%bodies(8)%damping_to_ground = 0.3_dp
      call build_system(train, system)
      duration = 2*2*pi/(0.5_dp*(from + to)*train%characteristic_frequency)
      rest = resting_state(system)
      scale = maxval(abs(rest))
      on_walls = count(abs(rest(pack(system%mesh_element, system%mesh_element <= system%displacements)) - &
                           pack(system%half_backlash, system%mesh_element <= system%displacements)) < 1e-12_dp*scale)
      call tests%is_true(on_walls > 1, 'meshes rest on their walls')
      worst = 0
      lost = 0
      do trial = 1, trials
         start%state = rest
         start%state(system%states) = start%state(system%states) + scale
         if (trial > 1) then
            ! Of either sign, from two units in the last place down; in every second trial of velocities alone.
            noise = [(real(mod(7919*(j + 37*trial), 5) - 2, dp), j=1, size(rest))]
            if (mod(trial, 2) == 0) noise(:system%displacements) = 0
            start%state = start%state + noise*epsilon(scale)/2*scale/10.0_dp**mod(trial, 6)
         end if
         call run_up(train, run_up_settings_type(from, to, duration=duration, samples=64, max_periods=0), found, error, start)
         call tests%is_true(.not. allocated(error), 'it runs')
         if (allocated(error)) return
         if (index(found%ended%text, 'guess') > 0) lost = lost + 1
         if (trial == 1) first = found
         worst = max(worst, maxval(abs(found%displacement - first%displacement))/maxval(abs(first%displacement)))
      end do
      call tests%is_true(lost == 0, 'no contact event is passed over')
      call tests%is_close(worst, 0.0_dp, 1e-9_dp, 'the same motion from either side of the walls')
   end subroutine from_walls

   !> Displacements, mesh forces and shaft torques at every sample as the other code has them, extremes of the windows.
   subroutine one_run_up(tests, bodies, loops, seed, dragged, laws, linear, to, toothed)
      class(tests_type), intent(inout) :: tests
      integer, intent(in) :: bodies, loops, seed, dragged
      logical, intent(in) :: laws, linear
      !> Lambda at the end.
      real(dp), intent(in) :: to
      !> The meshes have teeth.
      logical, intent(in), optional :: toothed
      real(dp), parameter :: from = 0.8_dp
      type(train_type) :: train
      type(system_type) :: system
      type(machine_type) :: machine
      type(run_up_type) :: found
      type(error_type), allocatable :: error
      type(motion_type) :: start
      real(dp), allocatable :: y(:), p(:), v(:), force(:), worst(:), displacement(:, :), mesh_force(:, :), torque(:, :)
      real(dp) :: duration, turns(bodies)
      character(60) :: name
      integer, allocatable :: contact(:)
      integer :: i, n

      write (name, '(3(a, i0))') 'run-up of ', bodies, ' bodies, loops: ', loops, ', drags: ', dragged
      if (laws) name = trim(name)//', laws'
      call random_network(bodies, loops, seed + 1000*tests%seed, train)
      if (laws) call draw_laws(seed + 1000*tests%seed, train)
      if (linear) train%meshes%half_backlash = 0
      if (present(toothed)) name = trim(name)//', teeth'
      if (present(toothed)) call give_teeth(train, turns)
      train%bodies(bodies - dragged + 1:)%damping_to_ground = [(0.3_dp*i, i=1, dragged)]
      call build_system(train, system)
      duration = 6.4_dp*2*pi/(0.5_dp*(from + to)*train%characteristic_frequency)
      start%state = resting_state(system)
      start%state(system%states) = start%state(system%states) + maxval(abs(start%state))
      call run_up(train, run_up_settings_type(from, to, duration=duration, samples=256, max_periods=0), found, error, start)
      call tests%is_true(.not. allocated(error), trim(name)//': runs')
      if (allocated(error)) return
      call tests%is_true(found%complete .and. found%windows == 7, trim(name)//': all of it')
      call build_machine(train, from, machine)
      allocate (p(size(machine%joint)), v(size(machine%joint)))
      n = size(found%time)
      allocate (displacement(size(train%meshes), n), mesh_force(size(train%meshes), n), torque(size(train%shafts), n))
      y = bodies_of_state(train, system, machine, start%state)
      machine%acceleration = (to - from)*train%characteristic_frequency/duration
      if (present(toothed)) call accelerate(train, turns, machine%acceleration, machine, y)
      do i = 1, n
         if (i > 1) call fly(machine, found%time(i - 1), found%time(i), y)
         call displacements(machine, found%time(i), y, p, v)
         contact = contacts(machine, p)
         force = joint_forces(machine, contact, found%time(i), y)
         displacement(:, i) = p(size(train%shafts) + 1:)/train%characteristic_length
         mesh_force(:, i) = force(size(train%shafts) + 1:)
         torque(:, i) = force(:size(train%shafts))
      end do
      call tests%is_true(linear .or. any(abs(displacement)*train%characteristic_length < spread(train%meshes%half_backlash, 2, &
                                                                                                n)), trim(name)//': teeth separate')
      if (present(toothed)) call tests%is_true(to < from .or. any(sum(mesh_force, 2) < 0), trim(name)//': a load is reversed')
      worst = [maxval(abs(found%displacement - displacement))/maxval(abs(displacement)), &
               maxval(abs(found%mesh_force - mesh_force))/maxval(abs(mesh_force)), &
               maxval([0.0_dp, abs(found%shaft_torque - torque)/maxval(abs(torque))])]
      call tests%is_close(worst(1), 0.0_dp, 1e-8_dp, trim(name)//': displacements')
      call tests%is_close(worst(2), 0.0_dp, 1e-7_dp, trim(name)//': mesh forces')
      call tests%is_close(worst(3), 0.0_dp, 1e-8_dp, trim(name)//': shaft torques')
      ! The samples reach an extreme that is not at a jump of the force to the square of their distance.
      call tests%is_close(maxval(found%force_maximum)/maxval(mesh_force), 1.0_dp, 1e-3_dp, trim(name)//': largest force')
      call tests%is_true(all(maxval(found%torque_maximum, 2) >= maxval(found%shaft_torque, 2)) .and. &
                         all(minval(found%force_minimum, 2) <= minval(found%mesh_force, 2)), trim(name)//': extremes')
   end subroutine one_run_up

   !> Gives every mesh teeth and the radii that go with them, the meshes in turn frequencies of 1 and 2 times the fundamental.
   subroutine give_teeth(train, turns)
      type(train_type), intent(inout) :: train
      !> Of each body per cycle of the fundamental.
      real(dp), intent(out) :: turns(:)
      integer, parameter :: teeth(*) = [24, 45, 30, 72, 36, 60, 40, 48]
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      integer :: i

      call find_ends(train, shaft_ends, mesh_ends)
      turns = 1.0_dp/teeth(:size(turns))
      do i = 1, size(train%shafts)
         turns(shaft_ends(2, i)) = turns(shaft_ends(1, i))
      end do
      do i = 1, size(train%meshes)
         associate (mesh => train%meshes(i))
            mesh%order = 1 + mod(i + 1, 2)
            mesh%teeth = anint(mesh%order/turns(mesh_ends(:, i)))
            mesh%driven_radius = mesh%driving_radius*mesh%teeth(2)/mesh%teeth(1)
         end associate
      end do
   end subroutine give_teeth

   subroutine one_network(tests, bodies, loops, seed, dragged, laws)
      class(tests_type), intent(inout) :: tests
      integer, intent(in) :: bodies, loops, seed
      !> Bodies, the last ones, that are damped to ground.
      integer, intent(in) :: dragged
      !> The meshes have laws of their own.
      logical, intent(in) :: laws
      type(train_type) :: train
      type(system_type) :: system
      type(machine_type) :: machine
      type(motion_type) :: motion
      type(error_type), allocatable :: error
      real(dp), parameter :: frequency_ratio = 0.83_dp
      integer, parameter :: samples = 1024
      real(dp), parameter :: step = 1e-5_dp
      real(dp), allocatable :: y(:), begin(:), p(:), v(:), history(:, :)
      !> The map of small changes by steps of 1 and 2, of 2 and 4, and to one side, (state, state, estimate).
      real(dp), allocatable :: map(:, :, :)
      real(dp) :: period, rms, scale, error_of_map, largest(3), leading(3)
      real(dp), allocatable :: final(:), tangents(:, :), after(:), ahead(:), behind(:), change(:, :), bend(:, :)
      complex(dp), allocatable :: multipliers(:)
      character(60) :: name
      integer :: i, n, first, periods, j

      write (name, '(3(a, i0))') 'network of ', bodies, ' bodies, loops: ', loops, ', drags: ', dragged
      if (laws) name = trim(name)//', laws'
      call random_network(bodies, loops, seed + 1000*tests%seed, train)
      if (laws) call draw_laws(seed + 1000*tests%seed, train)
      train%bodies(bodies - dragged + 1:)%damping_to_ground = [(0.3_dp*i, i=1, dragged)]
      call integrate(train, frequency_ratio, integration_settings_type(stability=.not. laws .or. dragged > 0), motion, error)
      call tests%is_true(.not. allocated(error), trim(name)//': runs')
      if (allocated(error)) then
         call tests%is_text(error%message, '', trim(name)//': message')
         return
      end if
      ! Of those with laws of their own, and of those of other seeds, some rattle without end: one period of that is compared.
      call tests%is_true(motion%period > 0 .or. laws .or. tests%seed > 0, trim(name)//': settles')
      periods = max(1, motion%period)
      call build_system(train, system)
      call build_machine(train, frequency_ratio, machine)
      period = 2*pi*periods/(frequency_ratio*train%characteristic_frequency)
      n = system%states
      allocate (final(n), tangents(n, n))
      call propagate(system, frequency_ratio, periods, motion%state, final, tangents)
      allocate (p(size(machine%joint)), v(size(machine%joint)))
      y = bodies_of_state(train, system, machine, motion%state)
      begin = y
      first = size(train%shafts)
      allocate (history(samples, size(train%meshes)))
      do i = 1, samples
         call displacements(machine, (i - 1)*period/samples, y, p, v)
         history(i, :) = p(first + 1:)/train%characteristic_length
         call fly(machine, (i - 1)*period/samples, i*period/samples, y)
      end do
      scale = maxval(abs(motion%state(:system%displacements)))
      call tests%is_close(maxval(abs(state_of_bodies(system, machine, train, y, period) - final))/scale, 0.0_dp, 1e-8_dp, &
                          trim(name)//': the other code comes as far')
      if (motion%period > 0) call tests%is_close(maxval(abs(final - motion%state))/scale, 0.0_dp, 1e-8_dp, trim(name)//': and back')
      do i = 1, size(train%meshes)
         if (.not. motion%period > 0) cycle
         rms = sqrt(2*sum((history(:, i) - sum(history(:, i))/samples)**2)/samples)
         call tests%is_close(motion%rms(i), rms, 1e-8_dp, trim(name)//': rms')
      end do
      if (allocated(motion%multipliers)) call tests%is_true(size(motion%multipliers) == n, trim(name)//': number of multipliers')
      allocate (map(n, n, 3), change(n, 3), bend(n, 3))
      after = flown(motion%state)
      do i = 1, n
         ! Of fourth order, so that the steps can be long: the rounding of the other code counts less. Twice the step tells the
         ! error. Where a mesh touches its wall the map bends: halves of the steps do not bend half as much.
         do j = 1, 3
            ahead = flown(moved(i, 2.0_dp**(j - 1)))
            behind = flown(moved(i, -2.0_dp**(j - 1)))
            change(:, j) = (ahead - behind)/(2**j*step*scale)
            bend(:, j) = (ahead - 2*after + behind)/(2**j*step*scale)
         end do
         map(:, i, 1) = (4*change(:, 1) - change(:, 2))/3
         map(:, i, 2) = (4*change(:, 2) - change(:, 3))/3
         map(:, i, 3) = map(:, i, 1) + 2*bend(:, 1) - bend(:, 2)
      end do
      error_of_map = maxval(abs(map - spread(map(:, :, 1), 3, 3)))/maxval(abs(tangents))
      call tests%is_close(maxval(abs(map(:, :, 1) - tangents))/maxval(abs(tangents)), 0.0_dp, 1e-7_dp + 8*error_of_map, &
                          trim(name)//': tangents')
      if (.not. allocated(motion%multipliers)) return
      do j = 1, 3
         call eigenvalues_of(map(:, :, j), multipliers)
         largest(j) = maxval(abs(multipliers))
         leading(j) = real(product(multipliers(:2)), dp)
      end do
      call tests%is_close(largest(1), maxval(abs(motion%multipliers)), 1e-7_dp + 8*maxval(abs(largest - largest(1))), &
                          trim(name)//': largest multiplier')
      call tests%is_close(leading(1), real(product(motion%multipliers(:2)), dp), 1e-6_dp + 8*maxval(abs(leading - leading(1))), &
                          trim(name)//': the leading two')

   contains

      !> The state with component i moved by so many steps.
      function moved(i, steps) result(state)
         integer, intent(in) :: i
         real(dp), intent(in) :: steps
         real(dp) :: state(size(motion%state))

         state = motion%state
         state(i) = state(i) + steps*step*scale
      end function moved

      function flown(state) result(end_)
         real(dp), intent(in) :: state(:)
         real(dp) :: end_(size(state))
         real(dp), allocatable :: z(:)
         integer, parameter :: pieces = 64
         integer :: k

         z = bodies_of_state(train, system, machine, state)
         do k = 1, pieces
            call fly(machine, (k - 1)*period/pieces, k*period/pieces, z)
         end do
         end_ = state_of_bodies(system, machine, train, z, period)
      end function flown

   end subroutine one_network

   !> Angles and speeds of the bodies, the first node at rest, at time 0, from a state of the library.
   function bodies_of_state(train, system, machine, state) result(y)
      type(train_type), intent(in) :: train
      type(system_type), intent(in) :: system
      type(machine_type), intent(in) :: machine
      real(dp), intent(in) :: state(:)
      real(dp), allocatable :: y(:)
      real(dp) :: p(size(machine%joint)), v(size(p)), moved, speed
      logical :: known(size(machine%inertia))
      integer :: b, i, n

      b = size(machine%inertia)
      allocate (y(2*b), source=0.0_dp)
      call displacements(machine, 0.0_dp, y, p, v)
      known = .false.
      do n = 1, system%displacements
         associate (element => system%network%elements(n))
            i = element%mesh + size(train%shafts)
            if (element%shaft > 0) i = element%shaft
            associate (joint => machine%joint(i))
               moved = state(n)
               if (element%shaft > 0) moved = moved + system%static_force(n)
               ! A shaft is measured along a radius, the other code counts its twist.
               moved = moved*train%characteristic_length*joint%ra/element%entry(1) - p(i)
               speed = state(system%displacements + n)*train%characteristic_length*train%characteristic_frequency &
                       *joint%ra/element%entry(1) - v(i)
               if (n == 1) known(joint%a) = .true.
               if (known(joint%a)) then
                  y(joint%b) = (joint%ra*y(joint%a) - moved)/joint%rb
                  y(b + joint%b) = (joint%ra*y(b + joint%a) - speed)/joint%rb
               else
                  y(joint%a) = (joint%rb*y(joint%b) + moved)/joint%ra
                  y(b + joint%a) = (joint%rb*y(b + joint%b) + speed)/joint%ra
               end if
               known([joint%a, joint%b]) = .true.
            end associate
         end associate
      end do
      if (system%coordinates == system%displacements) return
      ! All of them turn so that the body whose vibration is a state has it.
      i = system%network%elements(system%coordinates)%node(1)
      speed = state(system%states)*train%characteristic_length*train%characteristic_frequency - y(b + i)*system%network%radius(i)
      y(b + 1:) = y(b + 1:) + speed/system%network%radius
   end function bodies_of_state

   function state_of_bodies(system, machine, train, y, t) result(state)
      type(system_type), intent(in) :: system
      type(machine_type), intent(in) :: machine
      type(train_type), intent(in) :: train
      real(dp), intent(in) :: y(:), t
      real(dp) :: state(system%states), p(size(machine%joint)), v(size(p))
      integer :: i, n

      call displacements(machine, t, y, p, v)
      associate (grounded => system%network%elements(system%coordinates)%node(1), b => size(machine%inertia))
         state(system%states) = y(b + grounded)*system%network%radius(grounded) &
                                /(train%characteristic_length*train%characteristic_frequency)
      end associate
      do n = 1, system%displacements
         associate (element => system%network%elements(n))
            i = element%mesh + size(train%shafts)
            if (element%shaft > 0) i = element%shaft
            associate (joint => machine%joint(i), e => system%displacements)
               state(n) = p(i)*element%entry(1)/joint%ra/train%characteristic_length
               if (element%shaft > 0) state(n) = state(n) - system%static_force(n)
               state(e + n) = v(i)*element%entry(1)/joint%ra/(train%characteristic_length*train%characteristic_frequency)
            end associate
         end associate
      end do
   end function state_of_bodies

   subroutine eigenvalues_of(matrix, values)
      real(dp), intent(in) :: matrix(:, :)
      complex(dp), allocatable, intent(out) :: values(:)
      real(dp) :: a(size(matrix, 1), size(matrix, 1)), wr(size(matrix, 1)), wi(size(matrix, 1)), work(16*size(matrix, 1)), &
                  none(1, 1)
      complex(dp) :: held
      integer :: i, info, j, n

      n = size(matrix, 1)
      a = matrix
      call dgeev('N', 'N', n, a, n, wr, wi, none, 1, none, 1, work, size(work), info)
      values = cmplx(wr, wi, dp)
      do i = 1, n
         j = i - 1 + maxloc(abs(values(i:)), 1)
         held = values(i)
         values(i) = values(j)
         values(j) = held
      end do
   end subroutine eigenvalues_of

end module validation_random_networks
