!> The Taylor flow against closed forms.
module unit_flow
   use fixtures, only: long_train, single_pair
   use geartrain, only: dp, train_type
   use geartrain_base_kinds, only: pi
   use geartrain_base_random, only: begin_random, generator_type
   use geartrain_floquet_propagator, only: propagator_type
   use geartrain_floquet_time_reversal, only: time_reversal_type
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_orbit, only: propagate
   use geartrain_flow_start_state, only: resting_state
   use geartrain_flow_tangent_flight, only: tangent_flight_type
   use geartrain_flow_wall_event, only: first_wall
   use geartrain_network_system, only: build_system, system_type
   use networks, only: draw_laws, random_network
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: flow_tests

contains

   subroutine flow_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('bouncing')) call bouncing(tests)
      if (tests%runs('on_the_wall')) call on_the_wall(tests)
      if (tests%runs('tangents')) call tangents(tests)
      if (tests%runs('carried_tangents')) call carried_tangents(tests)
      if (tests%runs('interrupted')) call interrupted(tests)
      if (tests%runs('along_contacts')) call along_contacts(tests)
      if (tests%runs('half_an_interval')) call half_an_interval(tests)
   end subroutine flow_tests

   !> x'' + g(x) = f without damping: from rest at x0 > b the mass leaves contact, flies through the gap under the constant
   !> force f, and returns; phases are arcs and parabolas in closed form.
   subroutine bouncing(tests)
      class(tests_type), intent(inout) :: tests
      type(system_type), target :: system
      type(flow_type) :: flow
      real(dp), parameter :: f = 0.4_dp, amplitude = 0.7_dp
      real(dp) :: leave, speed, flight

      call build_system(single_pair(0.0_dp, 0.0_dp, f), system)
      call flow%setup(system, 1, 20, 1e-15_dp)
      ! In contact x = 1 + f + amplitude cos t: it leaves at cos t = -f/amplitude with speed -amplitude sin t.
      flow%x(1, :) = [1 + f + amplitude, 0.0_dp]
      call flow%start(1.0_dp, 0.0_dp)
      leave = acos(-f/amplitude)
      speed = amplitude*sin(leave)
      ! Free: x = 1 - speed t + f t^2/2 is back at the wall after 2 speed/f, then the arc repeats mirrored.
      flight = 2*speed/f
      call flow%advance(leave + flight/2)
      call tests%is_close(flow%x(1, 1), 1 - speed**2/(2*f), 1e-13_dp, 'flight: deepest point')
      call tests%is_close(flow%x(1, 2), 0.0_dp, 1e-13_dp, 'flight: at rest there')
      call flow%advance(2*leave + flight)
      call tests%is_close(flow%x(1, 1), 1 + f + amplitude, 2e-13_dp, 'back where it began')
      call tests%is_close(flow%x(1, 2), 0.0_dp, 2e-13_dp, 'at rest')
      call tests%is_true(flow%events == 2, 'two events')
   end subroutine bouncing

   !> A mesh that lies on its wall to rounding, with a velocity of rounding, leaves by the first term that is more: into its region
   !> without an event, though it may come back, or across the wall at once. One that stays there has none.
   subroutine on_the_wall(tests)
      class(tests_type), intent(inout) :: tests
      type(system_type), target :: system
      real(dp), parameter :: tiny_ = 2e-16_dp
      integer, parameter :: order = 6
      real(dp) :: p(1, 1, 0:order), h
      integer :: contact, last, place, speed, mesh, wall
      logical :: found

      call build_system(single_pair(0.0_dp, 0.0_dp, 0.4_dp), system)
      do contact = 0, 1
         do last = 0, 1
            do place = -1, 1
               do speed = -1, 1
                  p = 0
                  p(1, 1, :1) = [1 + place*tiny_, speed*tiny_]
                  call look()
                  call tests%is_true(.not. found, 'at rest on the wall')
                  p(1, 1, 3) = merge(0.1_dp, -0.1_dp, contact == 1)
                  call look()
                  call tests%is_true(.not. found, 'away from the wall')
                  p(1, 1, 4) = -p(1, 1, 3)/0.5_dp
                  call look()
                  call tests%is_true(found, 'comes back')
                  call tests%is_close(h, 0.5_dp, 1e-12_dp, 'where it comes back')
                  p(1, 1, 3:) = -p(1, 1, 3:)
                  call look()
                  call tests%is_true(found .and. h <= 0, 'across the wall at once')
               end do
            end do
         end do
      end do

   contains

      subroutine look()
         h = 1
         call first_wall(system, [contact], p, last, 0, h, found, mesh, wall)
      end subroutine look

   end subroutine on_the_wall

   !> The monodromy matrix through contact events against differences of the flow itself.
   subroutine tangents(tests)
      class(tests_type), intent(inout) :: tests
      type(system_type), target :: system
      real(dp), allocatable :: state(:), final(:), up(:), down(:), monodromy(:, :), unused(:, :)
      real(dp), parameter :: h = 1e-5_dp
      real(dp) :: worst
      integer :: i, n

      call build_system(long_train(4), system)
      n = 2*system%elements
      allocate (state(n), final(n), up(n), down(n), monodromy(n, n), unused(n, n))
      state = 0
      state(system%mesh_element) = [1.5_dp, 0.3_dp, -0.2_dp]
      call propagate(system, 0.8_dp, 1, state, final, monodromy)
      worst = 0
      do i = 1, n
         state(i) = state(i) + h
         call propagate(system, 0.8_dp, 1, state, up, unused)
         state(i) = state(i) - 2*h
         call propagate(system, 0.8_dp, 1, state, down, unused)
         state(i) = state(i) + h
         worst = max(worst, maxval(abs((up - down)/(2*h) - monodromy(:, i))))
      end do
      ! The flow is C^1: the difference quotient is right to O(h) times the jump of curvature at an event.
      call tests%is_close(worst/maxval(abs(monodromy)), 0.0_dp, 1e-4_dp, 'monodromy against differences')
   end subroutine tangents

   !> Tangents carried along the contacts of a flight against those of the flow, which are exact to rounding: on random trees and
   !> loops with stages of stiffness and damping in contact, from random states that rattle.
   subroutine carried_tangents(tests)
      class(tests_type), intent(inout) :: tests
      type(system_type), target :: system
      type(train_type) :: train
      type(tangent_flight_type) :: flight
      type(generator_type) :: generator
      real(dp), allocatable :: rest(:), state(:), final(:), carried(:), monodromy(:, :), tangents(:, :)
      integer :: seed, start, i, n
      character(2) :: number

      do seed = 1, 12
         write (number, '(i2)') seed
         call random_network(5 + mod(seed, 4), mod(seed, 3), seed + 1000*tests%seed, train)
         call draw_laws(seed + 1000*tests%seed, train)
         train%bodies(1)%damping_to_ground = 0.02_dp*mod(seed, 2)
         call build_system(train, system)
         rest = resting_state(system)
         n = size(rest)
         allocate (final(n), carried(n), monodromy(n, n), tangents(n, n))
         call flight%setup(system)
         generator = begin_random(seed + tests%seed, 1)
         do start = 1, 3
            state = rest + [(3*maxval(abs(rest))*(2*generator%uniform() - 1), i=1, n)]
            call propagate(system, 0.4_dp + 0.1_dp*seed, start, state, final, monodromy)
            call flight%fly(0.4_dp + 0.1_dp*seed, start, state, carried, tangents)
            ! One column against many: the steps are cut elsewhere, and a flight between walls multiplies rounding.
            call tests%is_close(maxval(abs(carried - final))/maxval(abs(final)), 0.0_dp, 1e-9_dp, 'train '//number//': state')
            ! A step of the propagator is right to 5e-10 of the state, and most are better.
            call tests%is_close(maxval(abs(tangents - monodromy))/maxval(abs(monodromy)), 0.0_dp, 1e-8_dp, &
                                'train '//number//': tangents')
         end do
         deallocate (final, carried, monodromy, tangents)
      end do
   end subroutine carried_tangents

   !> A step that is cut short must not make the next one less exact: one way in one go, and with a stop after a tiny step.
   subroutine interrupted(tests)
      class(tests_type), intent(inout) :: tests
      type(system_type), target :: system
      type(flow_type) :: flow
      real(dp), allocatable :: state(:)
      integer :: run

      call build_system(long_train(4), system)
      call flow%setup(system, 1, 20, 1e-15_dp)
      allocate (state(2*system%elements))
      do run = 1, 2
         flow%x = 0
         flow%x(1, system%mesh_element) = [1.5_dp, 0.3_dp, -0.2_dp]
         call flow%start(0.8_dp, 0.0_dp)
         call flow%advance(1.0_dp)
         if (run == 2) call flow%advance(1.0_dp + 1e-5_dp)
         call flow%advance(4.0_dp)
         if (run == 1) state = flow%x(1, :)
      end do
      call tests%is_close(maxval(abs(flow%x(1, :) - state)), 0.0_dp, 1e-12_dp, 'a short step does no harm')
   end subroutine interrupted

   !> The propagator of monodromy matrices, given the contacts that the flow met, against the flow's own tangents: separation,
   !> both flanks, a linear mesh, harmonics and orders of kappa.
   subroutine along_contacts(tests)
      class(tests_type), intent(inout) :: tests
      type(system_type), target :: system
      type(flow_type) :: flow
      type(propagator_type) :: propagator
      real(dp), allocatable :: state(:), final(:), monodromy(:, :), transposed(:, :)
      integer, allocatable :: contact(:)
      real(dp), parameter :: frequencies(*) = [0.15_dp, 0.8_dp, 3.0_dp]
      real(dp) :: time, period
      integer :: i, n

      call build_system(long_train(4), system)
      n = 2*system%elements
      allocate (state(n), final(n), monodromy(n, n), transposed(n, n), contact(system%meshes))
      state = 0
      state(system%mesh_element) = [4.0_dp, -3.5_dp, 2.0_dp]
      call flow%setup(system, 1, 20, 1e-15_dp)
      call propagator%setup(system)
      do i = 1, size(frequencies)
         period = 2*pi/frequencies(i)
         call propagate(system, frequencies(i), 1, state, final, monodromy)
         flow%x(1, :) = state
         call flow%start(frequencies(i), 0.0_dp)
         call propagator%start(frequencies(i), 1.0_dp)
         time = 0
         contact = flow%contact
         do while (flow%time < period)
            call flow%step(period)
            if (flow%time < period .and. .not. flow%event) cycle
            call propagator%advance(time, flow%time, contact)
            time = flow%time
            contact = flow%contact
         end do
         call propagator%get(transposed)
         call tests%is_true(flow%events > 0, 'the motion meets events')
         call tests%is_close(maxval(abs(transpose(transposed) - monodromy))/maxval(abs(monodromy)), 0.0_dp, 1e-8_dp, &
                             'propagator along the contacts of the flow')
      end do
   end subroutine along_contacts

   !> The matrix over an interval from its second half, where every kappa is even about the middle: against the whole interval,
   !> harmonics and orders of kappa, damping, a linear mesh, a mesh apart.
   subroutine half_an_interval(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(system_type), target :: system
      type(propagator_type) :: propagator
      type(time_reversal_type) :: mirror
      real(dp), allocatable :: half(:, :), whole(:, :), made(:, :), work(:, :)
      integer, parameter :: contacts(3, 3) = reshape([1, 1, 1, 0, 1, -1, 0, 1, 0], [3, 3])
      real(dp), parameter :: frequency_ratio = 0.7_dp, lead = 0.4_dp, reach = 5
      real(dp) :: middle
      integer :: i, j, n

      train = long_train(4)
      call build_system(train, system)
      call mirror%setup(system)
      call tests%is_true(size(mirror%centre) == 0, 'kappa that is even about no instant')
      train%meshes(3)%order = 1
      train%meshes(3)%damping_acts = 'contact'
      do j = 1, 3, 2
         associate (mesh => train%meshes(j))
            mesh%stiffness_cos = [0.12_dp*cos(mesh%order*lead), 0.03_dp*cos(2*mesh%order*lead)]
            mesh%stiffness_sin = [-0.12_dp*sin(mesh%order*lead), -0.03_dp*sin(2*mesh%order*lead)]
         end associate
      end do
      call build_system(train, system)
      call mirror%setup(system)
      call propagator%setup(system)
      call tests%is_close(minval(mirror%centre), pi - lead, 1e-12_dp, 'kappa that is even about an instant')
      call tests%is_close(maxval(mirror%centre), 2*pi - lead, 1e-12_dp, 'and half a period later')
      n = 2*system%elements
      allocate (half(n, n), whole(n, n), made(n, n), work(n, n))
      do i = 1, size(contacts, 2)
         middle = mirror%centre_near(contacts(:, i), frequency_ratio, 7.0_dp)
         if (i < 3) call tests%is_close(middle, (2*pi - lead)/frequency_ratio, 1e-12_dp, 'the nearest such instant')
         if (i == 3) call tests%is_close(middle, 7.0_dp, 0.0_dp, 'any instant while the meshes of varying stiffness are apart')
         call propagator%start(frequency_ratio, 1.0_dp)
         call propagator%advance(middle, middle + reach, contacts(:, i))
         call propagator%get(half)
         call propagator%start(frequency_ratio, 1.0_dp)
         call propagator%advance(middle - reach, middle + reach, contacts(:, i))
         call propagator%get(whole)
         call mirror%complete(contacts(:, i), half, made, work)
         call tests%is_close(maxval(abs(made - whole))/maxval(abs(whole)), 0.0_dp, 1e-8_dp, 'a whole interval from its half')
      end do
   end subroutine half_an_interval

end module unit_flow
