!> Run-ups: against steady motions at constant speed, against the jumps of slow sweeps, against the inertias by hand. Another code
!> of the same equations follows ramps in validation_random_networks.
module validation_run_up
   use fixtures, only: body, long_train, paper_train, reducer, settings_of, single_pair
   use geartrain, only: branch_type, dp, error_type, folds, integrate, integration_settings_type, motion_type, observer_type, &
      response, run_up, run_up_settings_type, run_up_type, train_type
   use geartrain_base_kinds, only: pi
   use geartrain_flow_ramp, only: make_ramp, ramp_type
   use geartrain_network_system, only: build_system, system_type
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: run_up_tests

   !> Stops a run-up after five windows.
   type, extends(observer_type) :: stopper_type
      integer :: steps = 0
   contains
      procedure :: on_step
   end type stopper_type

contains

   subroutine run_up_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('windows')) call windows(tests)
      if (tests%runs('constant_speed')) call constant_speed(tests)
      if (tests%runs('static_torques')) call static_torques(tests)
      if (tests%runs('acceleration')) call acceleration(tests)
      if (tests%runs('rate')) call rate(tests)
      if (tests%runs('taken_up')) call taken_up(tests)
      if (tests%runs('jumps')) call slow_jumps(tests)
      if (tests%runs('hertz')) call hertz(tests)
      if (tests%runs('where_it_begins')) call where_it_begins(tests)
      if (tests%runs('without_bound')) call without_bound(tests)
   end subroutine run_up_tests

   !> The windows of a ramp: each takes its share of the phase 2 pi, by the phase as a function of time.
   subroutine windows(tests)
      class(tests_type), intent(inout) :: tests
      type(ramp_type) :: ramp
      real(dp) :: phase, origin, first, begin, end
      integer :: i, n

      do i = 1, 4
         ramp = make_ramp(merge(0.2_dp, 2.6_dp, mod(i, 2) == 1), merge(2.6_dp, 0.2_dp, mod(i, 2) == 1), 1e4_dp, (i + 1)/2)
         call tests%is_true(ramp%windows == ceiling(1.4e4_dp/(2*pi)*ramp%parts), 'number of windows')
         do n = 1, ramp%windows, 100
            call ramp%place(n, origin, first, begin, end)
            call tests%is_close(origin + begin, ramp%begin_of(n), 1e-11_dp, 'a window in its period')
            associate (t => ramp%begin_of(n), speed => ramp%speed_of(n), length => end - begin)
               phase = ramp%start*t + ramp%acceleration*t**2/2
               call tests%is_close(phase, 2*pi*(n - 1)/ramp%parts, 1e-9_dp, 'phase at the beginning of a window')
               call tests%is_close(speed, ramp%start + ramp%acceleration*t, 1e-13_dp, 'speed there')
               call tests%is_close(speed*length + ramp%acceleration*length**2/2, 2*pi/ramp%parts, 1e-13_dp, 'phase over a window')
            end associate
         end do
         associate (w => ramp%windows)
            call ramp%place(w, origin, first, begin, end)
            call tests%is_close(origin + end, 1e4_dp, 1e-9_dp, 'the last window ends with the ramp')
            call tests%is_true(first*end + ramp%acceleration*end**2/2 <= 2*pi, 'and is cut short')
         end associate
      end do
   end subroutine windows

   !> A ramp between equal frequencies is the steady motion, window by window, with separation and with everything that the model
   !> has.
   subroutine constant_speed(tests)
      class(tests_type), intent(inout) :: tests

      call one(paper_train(), 0.9_dp, 'paper')
      call one(long_train(4), 0.8_dp, 'everything')

   contains

      subroutine one(train, frequency_ratio, name)
         type(train_type), intent(in) :: train
         real(dp), intent(in) :: frequency_ratio
         character(*), intent(in) :: name
         type(motion_type) :: motion
         type(run_up_type) :: found
         type(error_type), allocatable :: error
         integer :: j, w

         call integrate(train, frequency_ratio, integration_settings_type(), motion, error)
         call tests%is_true(.not. allocated(error) .and. motion%period == 1, name//': steady')
         call run_up(train, run_up_settings_type(frequency_ratio, frequency_ratio, samples=512, &
                     duration=6*2*pi/(frequency_ratio*train%characteristic_frequency)), found, error)
         call tests%is_true(.not. allocated(error), name//': no error')
         if (allocated(error)) return
         call tests%is_true(found%complete .and. found%windows == 6 .and. found%samples == 6*512 + 1, name//': six windows')
         call tests%is_true(found%start_period == 1, name//': begins with the steady motion')
         call tests%is_close(maxval(abs(found%displacement(:, 1) - found%displacement(:, found%samples))), 0.0_dp, 1e-7_dp, &
                             name//': six periods later')
         call tests%is_close(maxval(abs(found%state - motion%state)), 0.0_dp, 1e-7_dp, name//': the state of the motion')
         do j = 1, size(train%meshes)
            do w = 1, 6
               call tests%is_close(found%force_maximum(j, w)/motion%mesh_load(j)%force_maximum, 1.0_dp, 1e-8_dp, &
                                   name//': largest force')
            end do
            call tests%is_close(maxval(found%displacement(j, :)), motion%maximum(j), 1e-3_dp, name//': largest displacement')
            call tests%is_close(sum(found%displacement(j, :3072))/3072, motion%mean(j), 1e-7_dp, name//': mean displacement')
         end do
      end subroutine one

   end subroutine constant_speed

   !> Without excitation shafts carry the static torques, which gears multiply by their ratios, rigid shafts too.
   subroutine static_torques(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(run_up_type) :: found
      type(error_type), allocatable :: error
      real(dp) :: torque
      integer :: i

      train = long_train(4)
      train%torque_cos = [real(dp) ::]
      train%torque_sin = [real(dp) ::]
      do i = 1, 3
         train%meshes(i)%stiffness_cos = [real(dp) ::]
         train%meshes(i)%stiffness_sin = [real(dp) ::]
         train%meshes(i)%error_cos = [real(dp) ::]
         train%meshes(i)%error_sin = [real(dp) ::]
      end do
      call run_up(train, run_up_settings_type(0.5_dp, 0.9_dp, duration=0.01_dp), found, error)
      call tests%is_true(.not. allocated(error), 'no error')
      if (allocated(error)) return
      torque = train%input_torque
      do i = 1, 4
         call tests%is_close(maxval(abs(found%shaft_torque(i, :) - torque)), 0.0_dp, 1e-9_dp, 'static torque')
         call tests%is_close(found%torque_minimum(i, 1), torque, 1e-9_dp, 'least torque')
         if (i < 4) torque = torque*train%meshes(i)%driven_radius/train%meshes(i)%driving_radius
      end do
   end subroutine static_torques

   !> With teeth shafts and meshes carry what accelerates the inertias beyond them: by hand, motor to load, for run-up and
   !> coast-down; with a rigid shaft; with the motor as the body that balances; with a load that is reversed.
   subroutine acceleration(tests)
      class(tests_type), intent(inout) :: tests
      real(dp) :: reached(3)

      call one('up', 0.2_dp, 4.0_dp, 5.0_dp, .false., .false.)
      call one('down', 4.0_dp, 0.2_dp, 5.0_dp, .false., .false.)
      call one('rigid', 0.2_dp, 4.0_dp, 1.0_dp, .true., .false.)
      call one('motor balances', 0.2_dp, 4.0_dp, 1.0_dp, .false., .true.)
      call one('reversed', 0.2_dp, 4.0_dp, 0.1_dp, .false., .false., reached)
      call tests%is_true(all(reached*[1, -1, -1] > 0), 'reversed behind the first shaft')

   contains

      !> Speeds in 1000 rpm of the motor, with and without backlash.
      subroutine one(name, from, to, duration, rigid, motor_balances, reached)
         character(*), intent(in) :: name
         real(dp), intent(in) :: from, to, duration
         logical, intent(in) :: rigid, motor_balances
         real(dp), intent(out), optional :: reached(3)
         type(train_type) :: train
         type(run_up_type) :: found
         type(error_type), allocatable :: error
         type(system_type) :: system
         !> Inertias of both ends of each shaft [kg m^2], angular acceleration [rad/s^2] and torque [N m] of each shaft.
         real(dp) :: inertia(2, 3), speed(3), torque(3), force(2), more(3)
         integer :: i, j

         train = toothed_reducer(motor_balances)
         if (rigid) train%shafts(2)%stiffness = 0
         if (rigid) train%shafts(2)%damping_ratio = 0
         train%shafts(2)%rigid = rigid
         inertia = reshape(train%bodies%inertia, [2, 3])
         speed = (to - from)*1000*2*pi/60/duration*[1.0_dp, 23/71.0_dp, 23*19/(71*80.0_dp)]
         if (motor_balances) then
            torque(3) = 1170 + inertia(2, 3)*speed(3)
            do i = 3, 2, -1
               force(i - 1) = (torque(i) + inertia(1, i)*speed(i))/train%meshes(i - 1)%driven_radius
               torque(i - 1) = force(i - 1)*train%meshes(i - 1)%driving_radius + inertia(2, i - 1)*speed(i - 1)
            end do
         else
            torque(1) = 90 - inertia(1, 1)*speed(1)
            do i = 2, 3
               force(i - 1) = (torque(i - 1) - inertia(2, i - 1)*speed(i - 1))/train%meshes(i - 1)%driving_radius
               torque(i) = force(i - 1)*train%meshes(i - 1)%driven_radius - inertia(1, i)*speed(i)
            end do
         end if
         do j = 1, 2
            if (j == 2) train%meshes%half_backlash = 0
            call run_up(train, run_up_settings_type(from, to, duration=duration, samples=71), found, error)
            call tests%is_true(.not. allocated(error), name//': no error')
            if (allocated(error)) return
            do i = 1, 3
               call tests%is_close(maxval(abs(found%shaft_torque(i, :) - torque(i))), 0.0_dp, 1e-8_dp*abs(torque(i)), &
                                   name//': torque of a shaft')
            end do
            do i = 1, 2
               call tests%is_close(maxval(abs(found%mesh_force(i, :) - force(i))), 0.0_dp, 1e-8_dp*abs(force(i)), &
                                   name//': force of a mesh')
               call tests%is_close(maxval(abs(found%displacement(i, :) - (force(i)/train%meshes(i)%stiffness + &
                                   sign(train%meshes(i)%half_backlash, force(i)))/1e-6_dp)), 0.0_dp, 1e-7_dp, &
                                   name//': deflection on the flank that bears')
            end do
         end do
         if (present(reached)) reached = found%shaft_torque(:, 1)
         if (rigid .or. motor_balances) return
         ! A state has the twists less those at constant speed.
         call build_system(train, system)
         more = (torque - 90*[1.0_dp, 71/23.0_dp, 71*80/(23*19.0_dp)])/train%shafts%stiffness
         do i = 1, system%displacements
            if (system%element_shaft(i) > 0) &
               call tests%is_close(found%state(i), more(system%element_shaft(i))*system%network%elements(i)%radius/1e-6_dp, &
                                   1e-7_dp, name//': twist of a shaft')
         end do
      end subroutine one

   end subroutine acceleration

   !> The reducer with its teeth and without excitation, its bodies named.
   function toothed_reducer(motor_balances) result(train)
      logical, intent(in) :: motor_balances
      type(train_type) :: train
      character(8), parameter :: name(6) = ['motor   ', 'pinion 1', 'wheel 1 ', 'pinion 2', 'wheel 2 ', 'load    ']
      integer :: i

      train = reducer()
      associate (mesh => train%meshes)
         train%bodies = [body(name(1), 0.02_dp, 90.0_dp, balances=motor_balances), body(name(2), mesh(1)%driving_inertia), &
                         body(name(3), mesh(1)%driven_inertia), body(name(4), mesh(2)%driving_inertia), &
                         body(name(5), mesh(2)%driven_inertia), body(name(6), 1.5_dp, -1170.0_dp, .not. motor_balances)]
      end associate
      if (motor_balances) train%bodies(1)%torque = 0
      if (.not. motor_balances) train%bodies(6)%torque = 0
      train%prime_mover_inertia = 0
      train%load_inertia = 0
      train%input_torque = 0
      do i = 1, 3
         train%shafts(i)%between = name(2*i - 1:2*i)
      end do
      do i = 1, 2
         train%meshes(i)%between = name(2*i:2*i + 1)
         train%meshes(i)%driving_inertia = 0
         train%meshes(i)%driven_inertia = 0
         train%meshes(i)%stiffness_cos = [real(dp) ::]
         train%meshes(i)%error_cos = [real(dp) ::]
      end do
      train%meshes(1)%teeth = [23, 71]
      train%meshes(2)%teeth = [19, 80]
   end function toothed_reducer

   !> The difference that the teeth make, and with them the acceleration of the inertias, is proportional to the rate of the ramp:
   !> a slow ramp is the sweep without them. Waveforms are compared at the same speed and phase, of a train in contact throughout.
   subroutine rate(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: toothed, smooth
      type(run_up_type) :: with, without
      type(error_type), allocatable :: error
      real(dp) :: change(2, 3)
      integer :: i

      toothed = toothed_reducer(.false.)
      do i = 1, 2
         toothed%meshes(i)%stiffness_cos = [0.02_dp]
         toothed%meshes(i)%error_cos = [1e-7_dp]
      end do
      smooth = toothed
      do i = 1, 2
         deallocate (smooth%meshes(i)%teeth)
      end do
      do i = 1, 3
         associate (settings => run_up_settings_type(0.5_dp, 0.6_dp, duration=0.4_dp*2**i))
            call run_up(toothed, settings, with, error)
            call run_up(smooth, settings, without, error)
         end associate
         change(:, i) = maxval(with%mesh_force - without%mesh_force, 2)
         call tests%is_true(minval(with%force_minimum) > 0, 'in contact throughout')
         call tests%is_close(maxval(abs(with%mesh_force - without%mesh_force))/maxval(without%mesh_force), 0.0_dp, 0.02_dp/2**i, &
                             'a small change')
         if (i > 1) call tests%is_close(maxval(abs(change(:, i - 1)/change(:, i) - 2)), 0.0_dp, 1e-3_dp, &
                                        'half of it at half the rate')
      end do
   end subroutine rate

   !> An accelerated run-up that was stopped goes on to the same bits.
   subroutine taken_up(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(run_up_type) :: whole, found
      type(run_up_settings_type) :: settings
      type(stopper_type) :: stopper
      type(error_type), allocatable :: error

      train = toothed_reducer(.false.)
      train%meshes(1)%error_cos = [1e-6_dp]
      settings = run_up_settings_type(0.5_dp, 1.0_dp, duration=0.5_dp)
      call run_up(train, settings, whole, error)
      call run_up(train, settings, found, error, observer=stopper)
      call tests%is_true(found%windows > 0 .and. found%windows < whole%windows, 'stopped')
      deallocate (found%ended)
      call run_up(train, settings, found, error)
      call tests%is_true(found%complete .and. .not. any(abs(found%mesh_force - whole%mesh_force) > 0) .and. &
                         .not. any(abs(found%state - whole%state) > 0), 'the same bits')
   end subroutine taken_up

   subroutine on_step(self, analysis, done, frequency_ratio, keep_going)
      class(stopper_type), intent(inout) :: self
      character(*), intent(in) :: analysis
      integer, intent(in) :: done
      real(dp), intent(in) :: frequency_ratio
      logical, intent(inout) :: keep_going

      self%steps = self%steps + 1
      if (analysis == 'run up' .and. done == 5 .and. frequency_ratio > 0) keep_going = .false.
   end subroutine on_step

   !> The paper's train jumps up behind the fold at 0.792 and down behind the fold at 0.566, the later the faster the ramp is: in
   !> slow passage through a fold the delay goes as the rate to the power 2/3 (R. Haberman, SIAM J. Appl. Math. 37 (1979) 69-106).
   subroutine slow_jumps(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(error_type), allocatable :: error
      real(dp), allocatable :: found(:)
      real(dp) :: up, down, fast, slow

      call response(paper_train(), settings_of(0.5_dp, 0.9_dp, 24), branch, error)
      found = folds(branch)
      up = maxval(found)
      down = minval(found)
      call tests%is_close(up, 0.7923_dp, 1e-4_dp, 'the fold of the way up')
      call tests%is_close(down, 0.5657_dp, 1e-4_dp, 'the fold of the way down')
      slow = jump(0.5_dp, 0.9_dp, 6.4_dp, 13000.0_dp) - up
      fast = jump(0.5_dp, 0.9_dp, 0.8_dp, 13000.0_dp) - up
      call tests%is_true(slow > 0 .and. slow < 1.5e-3_dp, 'a slow ramp up jumps next to the fold')
      call tests%is_close(fast/slow, 4.0_dp, 0.6_dp, 'an eightfold rate delays the jump up four times as much')
      slow = down - jump(0.9_dp, 0.4_dp, 8.0_dp, 11000.0_dp)
      fast = down - jump(0.9_dp, 0.4_dp, 1.0_dp, 11000.0_dp)
      call tests%is_true(slow > 0 .and. slow < 1.5e-3_dp, 'a slow ramp down likewise')
      call tests%is_true(fast > 3*slow, 'and a fast ramp down later')

   contains

      !> Lambda at which the largest force of mesh 2 over a period passes a level.
      real(dp) function jump(from, to, duration, level)
         real(dp), intent(in) :: from, to, duration, level
         type(run_up_type) :: ramp
         integer :: w

         call run_up(paper_train(), run_up_settings_type(from, to, duration=duration), ramp, error)
         w = findloc((ramp%force_maximum(2, :) > level) .eqv. to > from, .true., 1)
         jump = from + (to - from)*ramp%window_time(w)/duration
      end function jump

   end subroutine slow_jumps

   !> The same ramp with its frequencies in Hz.
   subroutine hertz(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(run_up_type) :: one, other
      type(error_type), allocatable :: error
      real(dp) :: unit

      train = paper_train()
      unit = train%characteristic_frequency/(2*pi)
      call run_up(train, run_up_settings_type(0.5_dp, 0.9_dp, duration=0.05_dp), one, error)
      call run_up(train, run_up_settings_type(0.5_dp*unit, 0.9_dp*unit, 'Hz', 0.05_dp), other, error)
      call tests%is_true(size(one%time) == size(other%time), 'as many samples')
      call tests%is_close(maxval(abs(one%displacement - other%displacement)), 0.0_dp, 1e-8_dp, 'the same motion')
      call tests%is_close(other%frequency_ratio(1), 0.5_dp, 1e-12_dp, 'at the beginning')
   end subroutine hertz

   !> A run-up begins with the steady motion that the flow from `start` goes to; with what it reached, which is told; or with
   !> `start`.
   subroutine where_it_begins(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(motion_type) :: before, low, high
      type(run_up_type) :: found
      type(system_type) :: system
      type(error_type), allocatable :: error
      integer :: j

      train = paper_train()
      call build_system(train, system)
      ! At 0.75 two motions are stable.
      call integrate(train, 0.75_dp, integration_settings_type(), high, error)
      call integrate(train, 0.5_dp, integration_settings_type(), low, error)
      do j = 1, 5
         before = low
         call integrate(train, 0.5_dp + 0.05_dp*j, integration_settings_type(), low, error, before)
      end do
      call tests%is_true(high%rms(2) > 2*low%rms(2), 'two motions')
      call run_up(train, run_up_settings_type(0.75_dp, 0.76_dp, duration=0.01_dp), found, error, low)
      call tests%is_close(found%force_maximum(2, 1)/low%mesh_load(2)%force_maximum, 1.0_dp, 1e-2_dp, 'from the lower motion')
      call tests%is_text(found%ended%text, 'reached Lambda = 0.76', 'nothing to tell')
      call run_up(train, run_up_settings_type(0.75_dp, 0.76_dp, duration=0.01_dp, max_periods=3), found, error)
      call tests%is_true(found%complete .and. found%start_period == 0, 'not settled')
      call tests%is_text(found%ended%text, 'reached Lambda = 0.76; no steady motion was found at Lambda = 0.75: the run-up begins &
                         &with the state after 3 periods of the fundamental', 'which is told')
      call run_up(train, run_up_settings_type(0.75_dp, 0.76_dp, duration=0.01_dp, max_periods=0), found, error, low)
      do j = 1, 2
         call tests%is_close(found%displacement(j, 1), low%state(system%mesh_element(j)), 1e-14_dp, 'from the state as it is')
      end do
      low%state = [0.0_dp]
      call run_up(train, run_up_settings_type(0.75_dp, 0.76_dp, duration=0.01_dp), found, error, low)
      call tests%is_true(allocated(error), 'a state of another train is refused')
   end subroutine where_it_begins

   !> A pair without backlash in its first parametric resonance grows: the run-up ends there, and is not complete.
   subroutine without_bound(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(run_up_type) :: found
      type(error_type), allocatable :: error

      train = single_pair(0.001_dp, 0.6_dp, 1.0_dp)
      train%meshes(1)%half_backlash = 0
      call run_up(train, run_up_settings_type(1.6_dp, 2.4_dp, duration=1000.0_dp), found, error)
      call tests%is_true(.not. allocated(error) .and. .not. found%complete, 'not complete')
      call tests%is_true(index(found%ended%text, 'the motion grows without bound at Lambda = ') == 1, 'which is told')
      call tests%is_true(all(abs(found%displacement(:, :found%samples)) < 1e7_dp), 'what is there is finite')
      call run_up(train, run_up_settings_type(2.0_dp, 2.4_dp, duration=1000.0_dp), found, error)
      call tests%is_true(allocated(error), 'and nothing where it begins like that')
   end subroutine without_bound

end module validation_run_up
