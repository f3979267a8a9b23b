!> The short period on which contacts of long periods are found: places of harmonics, and coefficients against the whole period.
module unit_winding
   use fixtures, only: body, paper_train, planetary_stage, update_contact
   use geartrain, only: dp, error_type, train_type
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_bordered_system, only: bordered_system_type
   use geartrain_balance_fixed_space, only: fixed_space_type
   use geartrain_balance_mesh_load, only: force_reader_type, load_resolution, mesh_load_type
   use geartrain_balance_planet_turn, only: planet_turn_type
   use geartrain_balance_symmetric_space, only: find_symmetric_space
   use geartrain_balance_torus_extremes, only: find_torus_extremes
   use geartrain_balance_whole_contacts, only: find_whole_contacts
   use geartrain_balance_winding, only: find_winding, winding_type
   use geartrain_drawing_planetary_expansion, only: expand_planetaries
   use geartrain_floquet_motion_contacts, only: motion_contacts_type
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: fine_samples, sample
   use geartrain_mesh_law_contact, only: contact_type
   use geartrain_mesh_law_law, only: law_type
   use geartrain_network_equal_branches, only: equal_branches_type
   use geartrain_network_planet_symmetry, only: find_symmetries, symmetry_type
   use geartrain_network_system, only: build_system, system_type
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: winding_tests

   !> Orders of three planetary stages in line.
   integer, parameter :: order(3) = [8980, 1573, 277]

contains

   subroutine winding_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('places')) call places(tests)
      if (tests%runs('no_winding')) call no_winding(tests)
      if (tests%runs('coefficients')) call coefficients(tests)
      if (tests%runs('balance')) call same_balance(tests)
      if (tests%runs('whole_contacts')) call whole_contacts(tests)
      if (tests%runs('extremes')) call extremes(tests)
      if (tests%runs('planets')) call planets(tests)
   end subroutine winding_tests

   !> A train that has no more than the excitation of meshes of these orders, three harmonics each.
   subroutine build_sources(orders, system)
      integer, intent(in) :: orders(:)
      type(system_type), intent(out) :: system
      integer :: j

      system%meshes = size(orders)
      system%excitation_order = 1
      allocate (system%torque(0), system%law(size(orders)), system%transmission_error(size(orders)))
      do j = 1, size(orders)
         system%law(j)%order = orders(j)
         call system%law(j)%begin(0, [1.0_dp], orders(j)*[1, 2, 3])
         system%law(j)%amplitude = 0.1_dp
         system%law(j)%stiffness(1) = 1
         system%law(j)%origin(1) = 1
         call system%law(j)%complete(0.05_dp)
         allocate (system%transmission_error(j)%harmonic(0), system%transmission_error(j)%amplitude(0))
      end do
   end subroutine build_sources

   !> Sums of the sources have places of their own up to the weight, in the same ratios; places and harmonics are inverse; the place
   !> of a sum is the sum of the places, which products of spectra need.
   subroutine places(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: weight = 12
      type(system_type) :: system
      type(winding_type) :: winding
      integer :: short(3), k(3), h, p, q, wrong, off(2)
      integer, allocatable :: found(:)

      call build_sources(order, system)
      call find_winding(system, weight, winding)
      call tests%is_true(winding%cycles > 0 .and. 15*winding%cycles < order(1), 'a fifteenth of the cycles at most')
      if (winding%cycles == 0) return
      short = winding%place_of(order)
      call tests%is_true(short(1) == winding%cycles .and. all(abs(short - winding%cycles*order/real(order(1), dp)) < 1), &
                         'orders of the winding')
      wrong = 0
      off = 0
      allocate (found(0))
      do h = 0, 40
         do p = -weight, weight
            do q = -weight + abs(p), weight - abs(p)
               k = [h, p, q]
               if (dot_product(k, order) < 1) cycle
               associate (harmonic => dot_product(k, order), place => dot_product(k, short))
                  if (winding%place_of(harmonic) /= place .or. place < 1) wrong = wrong + 1
                  if (winding%harmonic_at(max(1, place)) /= harmonic) off(1) = off(1) + 1
                  if (h == 20) found = [found, place]
               end associate
            end do
         end do
      end do
      call tests%is_true(wrong == 0 .and. off(1) == 0, 'places of sums, and harmonics of places')
      call tests%is_true(size(found) == 2*weight**2 + 2*weight + 1 .and. &
                         all([(count(found == found(p)), p=1, size(found))] == 1), 'places of their own')
      ! Further places: none has the harmonic of another.
      off(2) = 0
      do p = 1, 3*winding%cycles
         h = winding%harmonic_at(p)
         if (h == 0) cycle
         if (winding%place_of(h) /= p) off(2) = off(2) + 1
      end do
      call tests%is_true(off(2) == 0, 'harmonics of further places')
      found = [(winding%harmonic_at(p), p=1, winding%cycles)]
      call tests%is_true(count(found > 0) > 9*winding%cycles/10, 'nearly all places have harmonics')
   end subroutine places

   !> No winding: of one source, of too many, and where it would hardly be shorter than the period.
   subroutine no_winding(tests)
      class(tests_type), intent(inout) :: tests
      type(system_type) :: one, five, short, double
      type(winding_type) :: winding

      call build_sources([8980], one)
      call find_winding(one, 12, winding)
      call tests%is_true(winding%cycles == 0, 'one source')
      call build_sources([8980, 5651, 3331, 1573, 277], five)
      call find_winding(five, 4, winding)
      call tests%is_true(winding%cycles == 0, 'five sources')
      call build_sources([811, 503, 22], short)
      call find_winding(short, 12, winding)
      call tests%is_true(winding%cycles == 0, 'a period of 811 cycles')
      ! A source of twice the order of another adds no sums of its own.
      call build_sources([8980, 2*277, 277], double)
      call find_winding(double, 12, winding)
      call tests%is_true(winding%cycles > 0 .and. winding%place_of(2*277) == 2*winding%place_of(277), 'a multiple of a source')
   end subroutine no_winding

   !> Coefficients of contact of a motion of three sources that parts in some of the cycles: those of the whole period, the nearer
   !> the longer the winding.
   subroutine coefficients(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: harmonic(*) = [277, 1108, 1573, 7407, 8703, 8980, 9257, 10553, 17960, 26940]
      real(dp), parameter :: depth(3) = [1.05_dp, 0.9_dp, 0.4_dp]
      integer, parameter :: weight(3) = [8, 12, 18]
      type(system_type) :: system
      type(winding_type) :: winding
      type(contact_type) :: whole, short
      type(law_type) :: law
      real(dp) :: u(1 + 2*size(harmonic)), off(3, 3), amplitude
      integer :: place(size(harmonic)), i, j

      call build_sources(order, system)
      u = 0
      do j = 1, size(harmonic)
         amplitude = 0.1_dp
         if (mod(harmonic(j), 8980) == 0) amplitude = 1/(harmonic(j)/8980.0_dp)**3
         u(2*j:2*j + 1) = amplitude*[cos(2.0_dp*j), sin(2.0_dp*j)]
      end do
      do i = 1, 3
         u(1) = 1 + depth(i)
         call whole%setup(system%law(1), 1, harmonic, 2*maxval(harmonic), 0)
         call update_contact(whole, u)
         do j = 1, 3
            call find_winding(system, weight(j), winding)
            place = winding%place_of(harmonic)
            law = system%law(1)
            call winding%wind(law)
            call short%setup(law, 1, place, 2*maxval(place), 0)
            call update_contact(short, u)
            off(j, i) = maxval(abs(short%spectra%stiffness(place) - whole%spectra%stiffness(harmonic)))
            off(j, i) = max(off(j, i), maxval(abs(short%spectra%offset([0, place]) - whole%spectra%offset([0, harmonic]))))
            call tests%is_true(short%events > 0 .and. short%events < whole%events/10, 'fewer events')
         end do
      end do
      ! Where teeth part in one of hundred cycles (the first depth) up to most of them.
      call tests%is_close(maxval(off(1, :)), 0.0_dp, 4e-3_dp, 'coefficients of the shortest winding')
      call tests%is_close(maxval(off(2, :)), 0.0_dp, 1e-3_dp, 'coefficients')
      call tests%is_close(maxval(off(3, :)), 0.0_dp, 8e-4_dp, 'coefficients of a longer one')
   end subroutine coefficients

   !> Residual of a balance on a winding, and its derivative: those of the whole period.
   subroutine same_balance(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: harmonic(*) = [4, 1005, 1009, 1013, 1017, 2018, 2022, 2026, 3027, 3039]
      type(train_type) :: train
      type(system_type), target :: system
      type(winding_type) :: winding
      type(balance_type) :: whole, short
      real(dp), allocatable :: u(:, :)
      integer :: k

      train = paper_train(0.1_dp)
      train%meshes%order = [1009, 1013]
      call build_system(train, system)
      call find_winding(system, 12, winding)
      call tests%is_true(winding%cycles > 0 .and. winding%cycles < 120, 'a winding of two sources')
      if (winding%cycles == 0) return
      call whole%setup(system, 3039, 1, 0, harmonic)
      call short%setup(system, 3039, 1, 0, harmonic, winding=winding)
      allocate (u(whole%block, whole%unknowns), source=0.0_dp)
      do k = 1, whole%block
         u(k, :) = [0.1_dp*cos(3.0_dp*k), 0.1_dp*sin(2.0_dp*k)]
      end do
      u(6:8:2, :) = 1.2_dp
      u(1, :) = system%half_backlash(whole%mesh) + [1.3_dp, 1.1_dp]
      call whole%evaluate(u, 0.8_dp/1009)
      call short%evaluate(u, 0.8_dp/1009)
      call tests%is_true(whole%parts() .and. short%parts(), 'teeth part')
      call tests%is_close(maxval(abs(short%residual - whole%residual))/maxval(abs(whole%residual)), 0.0_dp, 1e-4_dp, 'residual')
      call tests%is_close(maxval(abs(short%tangent - whole%tangent)), 0.0_dp, 1e-3_dp, 'derivative of the forces')
      call tests%is_close(maxval(abs(short%d_frequency - whole%d_frequency))/maxval(abs(whole%d_frequency)), 0.0_dp, 1e-4_dp, &
                          'derivative with respect to Lambda')
   end subroutine same_balance

   !> Contacts over the period of a motion whose balance is on a winding: those of the balance without.
   subroutine whole_contacts(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: harmonic(*) = [4, 1009, 1013, 2018, 2026]
      type(train_type) :: train
      type(system_type), target :: system
      type(winding_type) :: winding
      type(balance_type) :: whole, short
      type(motion_contacts_type) :: motion
      type(transform_type) :: transform
      real(dp), allocatable :: u(:, :)
      integer :: i

      train = paper_train(0.1_dp)
      train%meshes%order = [1009, 1013]
      call build_system(train, system)
      call find_winding(system, 12, winding)
      call whole%setup(system, 2026, 1, 0, harmonic)
      call short%setup(system, 2026, 1, 0, harmonic, winding=winding)
      allocate (u(whole%block, whole%unknowns), source=0.0_dp)
      u(4, :) = 0.9_dp
      u(6, :) = 0.3_dp
      u(1, :) = system%half_backlash(whole%mesh) + [1.15_dp, 1.0_dp]
      call whole%evaluate(u, 0.8_dp/1009)
      call short%evaluate(u, 0.8_dp/1009)
      call find_whole_contacts(short, u, transform, motion)
      do i = 1, 2
         associate (a => whole%contact(i), b => motion%contact(i))
            call tests%is_true(a%events > 0 .and. a%events == b%events, 'number of events')
            if (a%events /= b%events) cycle
            call tests%is_close(maxval(abs(a%instant(:a%events) - b%instant(:b%events))), 0.0_dp, 1e-9_dp, 'instants')
            call tests%is_true(all(a%contact(:a%events) == b%contact(:b%events)), 'regions')
         end associate
      end do
   end subroutine whole_contacts

   !> Extremes over all phases of two sources, of a waveform with flat tops, in closed form but for a search over one phase. The
   !> period of 8009 cycles has nearly all phases.
   subroutine extremes(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: order(2) = [8009, 8013], harmonic(3) = [order, 3*order(1)], searched = 100000
      real(dp), parameter :: pi = acos(-1.0_dp), frequency_ratio = 0.8_dp/order(1), amplitude(3) = [0.5_dp, 0.3_dp, -0.12_dp]
      type(train_type) :: train
      type(system_type), target :: system
      type(winding_type) :: winding, none
      type(force_reader_type) :: reader
      type(mesh_load_type) :: of_period, of_phases
      type(transform_type) :: transform
      real(dp) :: u(7), smallest, largest, swing, top, phase, kappa, rate(2)
      integer :: i

      train = paper_train(0.3_dp)
      train%meshes%order = order
      call build_system(train, system)
      call find_winding(system, 12, winding)
      call tests%is_true(system%static_force(system%mesh_element(1)) > 0, 'the drive flank bears')
      u = [system%half_backlash(1) + 1.2_dp, amplitude(1), 0.0_dp, amplitude(2)*cos(1.0_dp), amplitude(2)*sin(1.0_dp), &
           amplitude(3), 0.0_dp]
      associate (law => system%law(1))
         rate = law%damping(1)*frequency_ratio*order
         top = 0
         swing = 0
         do i = 1, searched
            phase = 2*pi*i/searched
            swing = max(swing, amplitude(1)*cos(phase) + amplitude(3)*cos(3*phase) + amplitude(2))
            kappa = law%stiffness_at(1, phase/order(1))
            top = max(top, kappa*(u(1) - law%origin(1) + amplitude(1)*cos(phase) + amplitude(3)*cos(3*phase)) &
                      - rate(1)*(amplitude(1)*sin(phase) + 3*amplitude(3)*sin(3*phase)) + amplitude(2)*hypot(kappa, rate(2)))
         end do
      end associate
      call find_torus_extremes(winding, u, harmonic, transform, smallest, largest)
      call tests%is_close(largest, u(1) + swing, 1e-8_dp, 'largest displacement')
      call tests%is_close(smallest, u(1) - swing, 1e-8_dp, 'smallest displacement')
      call read(winding, of_phases)
      call read(none, of_period)
      call tests%is_close(of_phases%force_maximum/(top*system%load_unit(1)), 1.0_dp, 1e-8_dp, 'largest force')
      call tests%is_close(of_period%force_maximum/(top*system%load_unit(1)), 1.0_dp, 1e-6_dp, 'largest force of the period')
      call tests%is_true(of_period%force_maximum < of_phases%force_maximum*(1 + 1e-10_dp), 'the period has some of the phases')

   contains

      subroutine read(winding, load)
         type(winding_type), intent(in) :: winding
         type(mesh_load_type), intent(inout) :: load

         call transform%plan(fine_samples(winding%shortened( &
            load_resolution(system%law(1), 1, frequency_ratio, u, harmonic, norm2(amplitude)))))
         call reader%setup(system, 1, 1, winding, transform)
         call sample(u, winding%place_of(harmonic), transform)
         call reader%read(system, 1, frequency_ratio, u, harmonic, transform, load)
      end subroutine read

   end subroutine extremes

   !> Two sets in line whose meshes repeat together after thousands of cycles: on the torus of their phases the planets of each move
   !> one after the other. The balance leaves these motions to themselves, and one planet of each set stands for all.
   subroutine planets(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(system_type), target :: system
      type(symmetry_type), allocatable :: symmetries(:)
      type(balance_type) :: balance
      type(bordered_system_type) :: matrix
      type(fixed_space_type) :: fixed
      type(planet_turn_type) :: turn
      type(winding_type) :: winding
      type(equal_branches_type) :: none(0)
      type(error_type), allocatable :: error
      real(dp), allocatable :: u(:, :), rest(:, :), x(:, :), whole(:, :)
      integer, allocatable :: harmonic(:)
      real(dp) :: y
      logical :: regular
      integer :: k, l, order(2)

      train = planetary_stage([19, 29, 77], 4)
      train%bodies = [train%bodies(:2), body('arm', 0.085_dp), body('ring 2', 0.0_dp), body('arm 2', 0.4_dp, balances=.true.)]
      train%bodies(4)%held = .true.
      train%planetaries = [train%planetaries, train%planetaries]
      associate (set => train%planetaries(2))
         set%name = 't'
         set%sun = 'arm'
         set%ring = 'ring 2'
         set%carrier = 'arm 2'
         set%teeth = [17.0_dp, 25.0_dp, 67.0_dp]
      end associate
      call expand_planetaries(train, error)
      call tests%is_true(.not. allocated(error), 'two sets in order')
      if (allocated(error)) return
      call build_system(train, system)
      call find_symmetries(train, system, symmetries)
      call tests%is_true(size(symmetries) == 2, 'both are symmetric')
      if (size(symmetries) /= 2) return
      order = symmetries%order
      call tests%is_true(all(order == [6468, 1139]) .and. all(abs(symmetries%shift) > 0), 'by a shift of their own phase')
      call find_winding(system, 12, winding)
      call tests%is_true(winding%cycles > 0, 'a winding')
      if (winding%cycles == 0) return
      harmonic = [(k*order(2), k=1, 4), ((l*order(1) + k*order(2), k=-4, 4), l=1, 2)]
      call balance%setup(system, maxval(harmonic), 1, 0, harmonic, winding=winding)
      call matrix%setup(balance)
      allocate (u(balance%block, balance%unknowns), source=0.0_dp)
      allocate (rest, x, whole, mold=u)
      call find_symmetric_space(balance, none, symmetries, u, u, fixed, turn)
      call tests%is_true(allocated(turn%orbit) .and. balance%independent == 4, 'four meshes stand for sixteen')
      call random_seed(put=[(k, k=1, 64)])
      call random_number(u)
      u = 0.1_dp*(u - 0.5_dp)
      u(1, :) = system%half_backlash(balance%mesh) + 0.8_dp
      call turn%project(u)
      call tests%is_true(count(turn%still) > 0 .and. maxval(abs(u(2:, :))) > 0.01_dp, 'some harmonics have no amplitude')
      call balance%evaluate(u, 0.9_dp/order(1))
      call tests%is_true(.not. balance%parts(), 'in contact')
      rest = balance%residual
      call matrix%linearize(balance)
      matrix%row = 0
      matrix%corner = 1
      call matrix%factor(balance, regular, fixed, turn)
      x = rest
      call turn%project(x)
      call tests%is_close(maxval(abs(x(2:, :) - rest(2:, :)))/maxval(abs(rest)), 0.0_dp, 1e-12_dp, 'the residual has the symmetry')
      x = rest
      y = 0
      call matrix%solve(balance, x, y)
      call tests%is_true(regular, 'a regular matrix')
      call matrix%linearize(balance)
      matrix%row = 0
      matrix%corner = 1
      call matrix%factor(balance, regular)
      whole = rest
      y = 0
      call matrix%solve(balance, whole, y)
      call tests%is_close(maxval(abs(x - whole)), 0.0_dp, 1e-11_dp*maxval(abs(x)), 'the solution is that of the whole matrix')
      ! Where teeth part the coefficients of the winding have small errors.
      u(1, :) = system%half_backlash(balance%mesh) + 0.05_dp
      u(2:, :) = 4*u(2:, :)
      call balance%evaluate(u, 0.9_dp/order(1))
      rest = balance%residual
      call turn%project(rest)
      call tests%is_true(balance%parts(), 'teeth part')
      call tests%is_close(maxval(abs(balance%residual(2:, :) - rest(2:, :)))/maxval(abs(rest)), 0.0_dp, 1e-3_dp, &
                          'the symmetry of a residual where teeth part')
   end subroutine planets

end module unit_winding
