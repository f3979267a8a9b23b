!> The tabulated map from section to section against the flow that it stands for.
module unit_section_map
   use fixtures, only: paper_train, random_train, rattling_pair
   use geartrain, only: dp, response_settings_type, train_type
   use geartrain_base_kinds, only: pi
   use geartrain_base_random, only: begin_random, generator_type
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_orbit, only: flow_order, flow_tolerance
   use geartrain_flow_section_map, only: section_map_type
   use geartrain_flow_start_state, only: resting_state
   use geartrain_network_system, only: build_system, system_type
   use networks, only: draw_laws, random_network
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: section_map_tests

   !> Neighbouring flights by which the growth of errors is found, displaced one after the other at instants of the period.
   integer, parameter :: neighbours = 8

contains

   subroutine section_map_tests(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(response_settings_type) :: settings
      integer :: seed
      character(2) :: number

      if (tests%runs('paper')) call compare(tests, paper_train(), 0.7_dp, 40, 'paper')
      if (tests%runs('rattle')) call compare(tests, rattling_pair(1.0_dp), 0.6_dp, 20, 'rattle')
      if (tests%runs('random')) then
         do seed = 1, 8
            write (number, '(i2)') seed
            call random_train(seed + 1000*tests%seed, train, settings)
            call compare(tests, train, settings%start, 4, 'random train '//number)
         end do
      end if
      if (tests%runs('network')) then
         do seed = 1, 6
            write (number, '(i2)') seed
            call random_network(4, mod(seed, 2), seed + 1000*tests%seed, train)
            call draw_laws(seed + 1000*tests%seed, train)
            call compare(tests, train, 0.4_dp + 0.1_dp*seed, 4, 'network '//number)
         end do
      end if
   end subroutine section_map_tests

   !> A period from random states, with tangents: by tables and by the flow. Both round in each of their steps; a rounding error
   !> grows along the flight as the distance of a neighbouring flight does, most where a mesh grazes a wall.
   subroutine compare(tests, train, frequency_ratio, starts, name)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      real(dp), intent(in) :: frequency_ratio
      integer, intent(in) :: starts
      character(*), intent(in) :: name
      !> Roundings in a step: 20 terms of the flow and 30 of the tables, each of an element and two neighbours; size of the
      !> displacement of a neighbouring flight, relative [1].
      real(dp), parameter :: roundings = 150, displacement = 1e-8_dp
      type(system_type), target :: system
      type(section_map_type) :: map
      type(flow_type) :: flow, neighbour
      type(generator_type) :: generator
      real(dp), allocatable :: state(:), rest(:), tangents(:, :)
      real(dp) :: size_of_state, rounding, growth(2), off(2)
      logical :: lost
      integer :: i, j, k

      call build_system(train, system)
      call map%setup(system, frequency_ratio)
      if (name == 'paper') call tests%is_true(map%intervals > 0, name//': has tables')
      call flow%setup(system, 3, flow_order, flow_tolerance)
      call neighbour%setup(system, 3, flow_order, flow_tolerance)
      rest = resting_state(system)
      generator = begin_random(1 + tests%seed, 1)
      off = 0
      lost = .false.
      do i = 1, starts
         state = rest + [(3*maxval(abs(rest))*(2*generator%uniform() - 1), j=1, size(rest))]
         tangents = reshape([(2*generator%uniform() - 1, j=1, 2*size(rest))], [size(rest), 2])
         flow%x(1, :) = state
         flow%x(2:, :) = transpose(tangents)
         call flow%pass_period(frequency_ratio)
         size_of_state = max(maxval(abs(state)), maxval(abs(flow%x(1, :))))
         rounding = roundings*epsilon(1.0_dp)*(map%intervals + flow%events)
         growth = 1
         do k = 1, neighbours
            neighbour%x(1, :) = state
            neighbour%x(2:, :) = transpose(tangents)
            call neighbour%start(frequency_ratio, 0.0_dp)
            call neighbour%advance(2*pi/frequency_ratio*(k - 1)/neighbours)
            neighbour%x(1, :) = neighbour%x(1, :) + displacement*size_of_state*[(2*generator%uniform() - 1, j=1, size(rest))]
            call neighbour%start(frequency_ratio, neighbour%time)
            call neighbour%advance(2*pi/frequency_ratio)
            associate (apart => abs(neighbour%x - flow%x)/displacement)
               growth = max(growth, [maxval(apart(1, :))/size_of_state, maxval(apart(2:, :))/maxval(abs(flow%x(2:, :)))])
            end associate
         end do
         call map%pass_period(state, lost, tangents)
         off = max(off, [maxval(abs(state - flow%x(1, :)))/size_of_state, &
                         maxval(abs(transpose(tangents) - flow%x(2:, :)))/maxval(abs(flow%x(2:, :)))]/(rounding*growth))
      end do
      call tests%is_true(.not. lost, name//': no event passed over')
      call tests%is_close(off(1), 0.0_dp, 1.0_dp, name//': states')
      call tests%is_close(off(2), 0.0_dp, 1.0_dp, name//': tangents')
   end subroutine compare

end module unit_section_map
