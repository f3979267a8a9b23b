!> What is computed in other ways over a period of thousands of mesh cycles, against the ways of short periods.
module unit_long_period
   use fixtures, only: paper_train, settings_of, update_contact
   use geartrain, only: branch_type, dp, error_type, response, response_settings_type, train_type
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_needed_harmonics, only: needed_harmonics
   use geartrain_flow_start_state, only: states_of
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: evaluate, extremes, fine_samples, own_resolution
   use geartrain_balance_bordered_system, only: bordered_system_type
   use geartrain_base_words, only: words_type
   use geartrain_balance_products, only: sparse_product, toeplitz
   use geartrain_mesh_law_contact, only: contact_type
   use geartrain_mesh_law_law, only: law_type
   use geartrain_train_nearby_orders, only: find_nearby_orders
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_mesh, only: mesh_type, put_law
   use geartrain_trace_out_of_reach, only: find_out_of_reach
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: long_period_tests

contains

   subroutine long_period_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('many_events')) call many_events(tests)
      if (tests%runs('few_harmonics')) call few_harmonics(tests)
      if (tests%runs('no_multipliers')) call no_multipliers(tests)
      if (tests%runs('teeth_part')) call teeth_part(tests)
      if (tests%runs('nearby_orders')) call nearby_orders(tests)
      if (tests%runs('out_of_reach')) call out_of_reach(tests)
      if (tests%runs('states_of_sets')) call states_of_sets(tests)
      if (tests%runs('states_of_few')) call states_of_few(tests)
      if (tests%runs('extremes_of_sets')) call extremes_of_sets(tests)
   end subroutine long_period_tests

   !> Extremes of waveforms with a maximum in each of hundreds of mesh cycles, all of them nearly as high, from few samples.
   subroutine extremes_of_sets(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: harmonic(*) = [22, 308, 352, 503, 811, 833, 1006, 1314, 1622, 2433]
      integer, parameter :: dense = 48*2433
      real(dp), parameter :: pi = acos(-1.0_dp)
      type(transform_type) :: transform
      real(dp) :: u(1 + 2*size(harmonic)), smallest, largest, ends(2), off, p(3), t
      real(dp) :: values(0:dense - 1)
      integer :: i, k, q

      call seed_randomly()
      off = 0
      do i = 1, tests%times(40)
         call random_number(u)
         u = u - 0.5_dp
         ! The mesh of 811 cycles dominates; its harmonics fall, the others are small.
         do k = 1, size(harmonic)
            if (mod(harmonic(k), 811) == 0) u(2*k:2*k + 1) = u(2*k:2*k + 1)/(harmonic(k)/811)**4
            if (mod(harmonic(k), 811) /= 0) u(2*k:2*k + 1) = u(2*k:2*k + 1)*10.0_dp**(-mod(i, 5))*(503.0_dp/harmonic(k))**3
         end do
         call transform%plan(fine_samples(own_resolution(u, harmonic)))
         call extremes(u, harmonic, transform, smallest, largest)
         do q = 0, dense - 1
            call evaluate(u, harmonic, 2*pi*q/dense, values(q), p(1), p(2))
         end do
         ends = [huge(t), -huge(t)]
         do q = 0, dense - 1
            p = values(modulo(q + [-1, 0, 1], dense))
            t = (p(3) - p(1))**2/(8*(2*p(2) - p(1) - p(3)))
            if (p(2) >= max(p(1), p(3))) ends(2) = max(ends(2), p(2) + t)
            if (p(2) <= min(p(1), p(3))) ends(1) = min(ends(1), p(2) + t)
         end do
         off = max(off, maxval(abs([smallest, largest] - ends))/(ends(2) - ends(1)))
      end do
      ! Vertices of parabolas through 48 samples a period of the highest harmonic, which has a sixteenth of the amplitude at most.
      call tests%is_close(off, 0.0_dp, 1e-6_dp, 'extremes of sets of harmonics')

   contains

      subroutine seed_randomly()
         integer :: n

         call random_seed(size=n)
         call random_seed(put=[(2433 + 811*k, k=1, n)])
      end subroutine seed_randomly

   end subroutine extremes_of_sets

   !> The states of a motion have all its harmonics: a chosen set has some that few sums of tooth frequencies reach.
   subroutine states_of_sets(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: highest = 138
      type(train_type) :: train
      type(system_type), target :: system
      type(motion_type) :: motion
      real(dp), allocatable :: states(:, :)
      integer, allocatable :: rare(:)
      integer :: k, r

      train = paper_train(0.1_dp)
      train%meshes%order = [17, 23]
      call build_system(train, system)
      associate (needed => needed_harmonics(system, highest))
         rare = pack([(r, r=1, highest)], [(all(needed /= r), r=1, highest)])
      end associate
      call tests%is_true(size(rare) > 10, 'harmonics that are rarely needed')
      allocate (motion%coefficients(1 + 2*highest, system%meshes), source=0.0_dp)
      motion%frequency_ratio = 0.5_dp/23
      motion%period = 1
      motion%coefficients(1, :) = [3.0_dp, 4.0_dp]
      motion%coefficients(2*rare, :) = 0.01_dp
      motion%coefficients(2*rare + 1, :) = -0.02_dp
      allocate (states(system%states, 5))
      call states_of(system, motion, states)
      do k = 1, 5
         associate (phase => 2*acos(-1.0_dp)*(k - 1)/5*rare)
            call tests%is_close(maxval(abs(states(system%mesh_element, k) - [3, 4] &
                                           - sum(0.01_dp*cos(phase) - 0.02_dp*sin(phase)))), 0.0_dp, 1e-12_dp, 'displacements')
         end associate
      end do
   end subroutine states_of_sets

   !> The states of a motion with few of ten thousands of harmonics. A balance with all of them needs more memory than there is.
   subroutine states_of_few(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: harmonic(4) = [1573, 7407, 8980, 36*8980]
      type(train_type) :: train
      type(system_type), target :: system
      type(motion_type) :: motion
      real(dp), allocatable :: states(:, :)
      integer :: k

      train = paper_train(0.1_dp)
      train%meshes%order = [8980, 1573]
      call build_system(train, system)
      allocate (motion%coefficients(1 + 2*maxval(harmonic), system%meshes), source=0.0_dp)
      motion%frequency_ratio = 0.5_dp/8980
      motion%period = 1
      motion%coefficients(1, :) = [3.0_dp, 4.0_dp]
      motion%coefficients(2*harmonic, :) = 0.01_dp
      allocate (states(system%states, 5))
      call states_of(system, motion, states)
      do k = 1, 5
         call tests%is_close(maxval(abs(states(system%mesh_element, k) - [3, 4] &
                                        - sum(0.01_dp*cos(2*acos(-1.0_dp)*(k - 1)/5*harmonic)))), 0.0_dp, 1e-9_dp, 'displacements')
      end do
   end subroutine states_of_few

   !> A branch ends after twenty motions with an error above 0.1, or five in a long period. There 25 that miss the tolerance end it
   !> too, or 15 in a row. Motions of the trace from the other end are not counted.
   subroutine out_of_reach(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      integer :: i

      branch%points = 60
      branch%error_estimate = [(merge(0.2_dp, 2e-3_dp, i <= 30 .or. i > 36), i=1, 60)]
      branch%frequency_ratio = [(real(i, dp), i=1, 60)]
      branch%segment = [(merge(1, 2, i <= 30), i=1, 60)]
      call tests%is_true(ends(60, .false.) .and. .not. ends(54, .false.), 'twenty motions')
      call tests%is_true(ends(41, .true.) .and. .not. ends(40, .true.), 'five motions of hunting teeth')
      branch%error_estimate = 2e-3_dp
      branch%segment = 1
      call tests%is_true(ends(15, .true.) .and. .not. (ends(14, .true.) .or. ends(60, .false.)), 'fifteen in a row')
      branch%error_estimate(10) = 5e-4_dp
      branch%error_estimate(20) = 5e-4_dp
      call tests%is_true(ends(27, .true.) .and. .not. ends(26, .true.), 'twenty-five missed by little')

   contains

      logical function ends(points, long)
         integer, intent(in) :: points
         logical, intent(in) :: long
         type(words_type), allocatable :: reason

         branch%points = points
         call find_out_of_reach(branch, 1e-3_dp, long, reason)
         ends = allocated(reason)
      end function ends

   end subroutine out_of_reach

   !> A turbine's orders of 288,640 cycles, with nearby orders by a search written apart; orders that are low enough, which stay;
   !> orders of a simple ratio, which keep the ratio; orders without a neighbour of the allowed error.
   subroutine nearby_orders(tests)
      class(tests_type), intent(inout) :: tests
      integer :: nearby(3), four(4), seven(7), two(2)
      real(dp) :: scale, error

      call find_nearby_orders([15939, 75440, 288640], nearby, scale, error)
      call tests%is_true(all(nearby == [266, 1259, 4817]), 'nearby orders')
      call tests%is_close(error, 4.513e-6_dp, 1e-9_dp, 'error')
      call tests%is_close(maxval(abs(nearby/(scale*[15939, 75440, 288640]) - 1)), error, 1e-12_dp, 'of the frequencies')
      call find_nearby_orders([345, 1886, 7216], nearby, scale, error)
      call tests%is_true(all(nearby == [345, 1886, 7216]) .and. .not. abs(error) > 0, 'low orders')
      call tests%is_close(scale, 1.0_dp, 0.0_dp, 'scale of low orders')
      call find_nearby_orders([10160, 5080, 2921, 1748], four, scale, error)
      call tests%is_true(four(1) == 2*four(2) .and. four(1) < 10000 .and. error > 0, 'a simple ratio')
      call find_nearby_orders([659227, 124013, 19703, 9367], four, scale, error)
      call tests%is_true(error > 1e-5_dp .and. error < 1e-4_dp, 'a further neighbour where there is none near')
      call tests%is_close(maxval(abs(four/(scale*[659227, 124013, 19703, 9367]) - 1)), error, 1e-12_dp, 'of all frequencies')
      call find_nearby_orders([659227, 124013, 19703, 9367, 7919, 6131, 5003], seven, scale, error)
      call tests%is_true(all(seven == [659227, 124013, 19703, 9367, 7919, 6131, 5003]) .and. .not. abs(error) > 0, 'no neighbour')
      ! A pinion of 21 teeth whose errors come with its revolution: the order of its mesh is a multiple of them.
      call find_nearby_orders([16653, 5124, 1596], nearby, scale, error, [21, 1, 1])
      call tests%is_true(mod(nearby(1), 21) == 0 .and. nearby(1) < 10000 .and. error < 1e-4_dp, 'whole revolutions')
      ! Gears of 19 and of 71 teeth, two stages apart, both with errors: the fewest cycles within 5e-4.
      call find_nearby_orders([111967, 22933], two, scale, error, [19, 71])
      call tests%is_true(all(two == [1387, 284]), 'revolutions of two shafts')
      call tests%is_close(error, (73*323/4.0_dp/5893 - 1)/(73*323/4.0_dp/5893 + 1), 1e-12_dp, 'their frequencies')
   end subroutine nearby_orders

   !> A cycle repeated 5000 times has 20,000 events, found from samples alone, and spectra by FFT: those of the cycle, found by
   !> Newton's method and sums over the events, at every 5000th harmonic, and 0 elsewhere. With eight samples in a period of the
   !> highest harmonic, which has a quarter of the amplitude, the polynomial of degree 11 is off by up to 1e-9.
   subroutine many_events(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: cycles = 5000, highest = 3
      real(dp), parameter :: u(5) = [0.1_dp, 2.5_dp, -1.0_dp, 0.6_dp, 0.4_dp]
      type(contact_type) :: one, many
      complex(dp) :: expected(0:cycles*highest)

      call prepare(one, 1)
      call prepare(many, cycles)
      call tests%is_true(one%events > 0 .and. many%events == cycles*one%events, 'each cycle has its events')
      call tests%is_close(maxval(abs(many%instant(:one%events)*cycles - one%instant(:one%events))), 0.0_dp, 1e-9_dp, &
                          'events of the first cycle')
      expected = 0
      expected(::cycles) = one%spectra%stiffness(:highest)
      call tests%is_close(maxval(abs(many%spectra%stiffness(:cycles*highest) - expected)), 0.0_dp, 1e-10_dp, 'stiffness')
      expected(::cycles) = one%spectra%offset(:highest)
      call tests%is_close(maxval(abs(many%spectra%offset(:cycles*highest) - expected)), 0.0_dp, 1e-10_dp, 'offset')

   contains

      subroutine prepare(contact, order)
         type(contact_type), intent(inout) :: contact
         integer, intent(in) :: order
         type(law_type) :: law

         call put_law(mesh_type(order=order, stiffness=1.0_dp, half_backlash=1.0_dp, stiffness_cos=[0.3_dp, -0.05_dp], &
                                stiffness_sin=[-0.1_dp, -0.2_dp]), 1.0_dp, law)
         call law%complete(0.0_dp)
         call contact%setup(law, 1, order*[1, 2], order*highest, 0)
         call update_contact(contact, u)
      end subroutine prepare

   end subroutine many_events

   !> A branch over a long period has growth rates and no multipliers: nothing that ends the trace looks for them, which the bounds
   !> of the debug build show.
   subroutine no_multipliers(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(response_settings_type) :: settings
      type(branch_type) :: branch
      type(error_type), allocatable :: error

      train = paper_train(0.1_dp)
      train%meshes%order = [503, 509]
      train%meshes%half_backlash = 0
      settings = settings_of(0.9_dp/503, 0.92_dp/503, 0)
      settings%tolerance = 1e-2_dp
      settings%max_points = 6
      call response(train, settings, branch, error)
      call tests%is_true(.not. allocated(error) .and. branch%points > 2 .and. branch%states == 0, 'a branch without multipliers')
      if (allocated(error)) return
      call tests%is_true(all(branch%growth_rate(:branch%points) < 0 .and. branch%stable(:branch%points)), 'growth rates')
   end subroutine no_multipliers

   !> Where teeth part between two motions the factors of one do not fit the other, whose harmonics are all explicit: a solution is
   !> one of the linearised balance of the motion that was evaluated last.
   subroutine teeth_part(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(system_type), target :: system
      type(balance_type) :: balance
      type(bordered_system_type) :: matrix
      real(dp), allocatable :: u(:, :), b(:, :), x(:, :), product(:, :)
      real(dp) :: y
      logical :: regular
      integer :: change, k

      train = paper_train(0.1_dp)
      train%meshes%order = [503, 509]
      call build_system(train, system)
      call balance%setup(system, 200, 1, 0, [(k, k=1, 200)])
      call matrix%setup(balance)
      allocate (u(balance%block, balance%unknowns), source=0.0_dp)
      allocate (b, x, product, mold=u)
      do change = 1, 2
         u(1, :) = system%half_backlash(balance%mesh) + 0.5_dp
         u(2:3, 1) = merge(0.0_dp, 1.0_dp, change == 1)
         call balance%evaluate(u, 0.9_dp/503)
         call matrix%linearize(balance)
         matrix%row = 0
         matrix%corner = 1
         call matrix%factor(balance, regular)
         u(2:3, 1) = merge(1.0_dp, 0.0_dp, change == 1)
         call balance%evaluate(u, 0.9_dp/503)
         call random_number(b)
         x = b
         y = 0
         call matrix%solve(balance, x, y)
         call balance%apply(x, product)
         call tests%is_true(regular .and. (balance%parts() .eqv. change == 1), 'teeth part in the motion evaluated last')
         call tests%is_close(maxval(abs(product + y*matrix%column - b)), 0.0_dp, 1e-3_dp, 'solution of the linearised balance')
      end do
   end subroutine teeth_part

   !> A stiffness of two harmonics times a motion: the matrix of the product and the product by neighbours.
   subroutine few_harmonics(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: harmonic(8) = [2, 3, 5, 7, 10, 12, 14, 17], stiffness(2) = [7, 14]
      complex(dp) :: w(0:34)
      real(dp) :: x(17), f(17), matrix(17, 17)

      w = 0
      w(0) = 0.8_dp
      w(stiffness) = [(0.3_dp, -0.2_dp), (-0.1_dp, 0.05_dp)]
      call random_number(x)
      call toeplitz(harmonic, w, matrix)
      call sparse_product(harmonic, stiffness, w(0)%re, w(stiffness), x, f)
      call tests%is_close(maxval(abs(f - matmul(matrix, x))), 0.0_dp, 1e-14_dp, 'product by neighbours')
   end subroutine few_harmonics

end module unit_long_period
