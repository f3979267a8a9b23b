!> What the paper's print gets wrong, and what holds instead; docs/claims.md has the table.
module validation_errata
   use fixtures, only: paper_train, settings_of
   use geartrain, only: branch_type, dp, error_type, motion_type, response, solutions_at, train_type, waveform
   use geartrain_balance_balance, only: balance_type
   use geartrain_base_kinds, only: pi
   use geartrain_network_system, only: build_system, system_type
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: errata_tests

contains

   subroutine errata_tests(tests)
      class(tests_type), intent(inout) :: tests
      type(system_type) :: system
      type(train_type) :: train

      train = paper_train()
      call build_system(train, system)
      if (tests%runs('assembly')) call assembly(tests, train, system)
      if (tests%runs('forces')) call forces(tests, train, system)
      if (tests%runs('projection')) call projection(tests, system)
      if (tests%runs('root_mean_square')) call root_mean_square(tests)
      if (tests%runs('rectangular_wave')) call rectangular_wave(tests)
      if (tests%runs('resonances_of_other_orders')) call resonances_of_other_orders(tests)
   end subroutine errata_tests

   !> (1c), (5b), (5d): W = B I^-1 B^T K/omega_c^2, assembled here as full matrices, has positive diagonals and negative
   !> neighbours, and nothing else.
   subroutine assembly(tests, train, system)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      type(system_type), intent(in) :: system
      real(dp) :: b(5, 6), w(5, 5), inertia(6)
      integer :: i, n

      inertia = [train%prime_mover_inertia, train%meshes(1)%driving_inertia, train%meshes(1)%driven_inertia, &
                 train%meshes(2)%driving_inertia, train%meshes(2)%driven_inertia, train%load_inertia]
      b = 0
      do n = 1, 5
         b(n, n) = system%network%elements(n)%entry(1)
         b(n, n + 1) = system%network%elements(n)%entry(2)
      end do
      do n = 1, 5
         do i = 1, 5
            w(n, i) = sum(b(n, :)*b(i, :)/inertia)*system%stiffness(i)/train%characteristic_frequency**2
         end do
      end do
      do n = 1, 5
         call tests%is_close(system%own(n)/w(n, n), 1.0_dp, 1e-12_dp, '(5): own term')
         do i = system%first(n), system%first(n + 1) - 1
            associate (m => system%neighbour(i))
               call tests%is_close(system%coupling(i)/w(n, m), 1.0_dp, 1e-12_dp, '(5): neighbour')
               call tests%is_true(w(n, m) < 0, '(5): neighbours are negative')
               w(n, m) = 0
            end associate
         end do
         w(n, n) = 0
      end do
      call tests%is_true(all(abs(w) <= 0), '(5): nothing else')
      call tests%is_close(sqrt(system%own(2)), 1.8663_dp, 5e-5_dp, '(6d): frequency of the first pair')
   end subroutine assembly

   !> (4), (6): the quoted 11,000; (6a, b): the load opposes; mesh 2 rests on its drive flank, at +1.4.
   subroutine forces(tests, train, system)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      type(system_type), intent(in) :: system
      real(dp) :: printed, scaled
      type(branch_type) :: branch
      type(error_type), allocatable :: error

      printed = train%input_torque/(train%characteristic_frequency**2*train%prime_mover_inertia)
      scaled = printed*train%meshes(1)%driving_radius/train%characteristic_length
      call tests%is_close(printed, 6.69_dp, 0.01_dp, '(6a): f1 as printed')
      call tests%is_close(scaled, 11158.0_dp, 1.0_dp, 'claim 34, (6a): f1 with shaft angles scaled by r/b_c, 150 N m')
      call tests%is_close(scaled*100/150, 7439.0_dp, 1.0_dp, 'claim 34, (6a): 100 N m')
      call tests%is_close(scaled*50/150, 3719.0_dp, 1.0_dp, 'claim 34, (6a): 50 N m')
      call tests%is_true(all(system%static_force > 0), '(6b): every element carries a positive load')
      call tests%is_close(system%static_force(5)*system%stiffness(5)*train%characteristic_length &
                          *system%network%elements(5)%radius, 600.0_dp, 1e-9_dp, '(6b): the output shaft carries 4 T1')
      call response(train, settings_of(0.05_dp, 0.1_dp, 6), branch, error)
      call tests%is_close(branch%mean(2, 1), 1.4_dp, 0.03_dp, 'mesh 2 swings about +1.4')
      call tests%is_close(branch%mean(1, 1), 1.4_dp, 0.03_dp, 'and so does mesh 1')
   end subroutine forces

   !> (9), (10): the balance projects kappa g as a whole. The paper cuts g off at R harmonics before the product with kappa,
   !> which drops the share of harmonic R + 1 of g in harmonic R of the force; here 4096 samples stand for the integral.
   subroutine projection(tests, system)
      class(tests_type), intent(inout) :: tests
      type(system_type), target, intent(in) :: system
      type(balance_type) :: balance
      integer, parameter :: samples = 4096
      real(dp), parameter :: frequency_ratio = 0.8_dp
      real(dp) :: theta(samples), g(samples), damping(samples), kappa(samples), cut(samples), whole, truncated
      real(dp), allocatable :: u(:, :)
      integer :: q, r

      call balance%setup(system, 2, 1, 0)
      allocate (u(balance%block, balance%unknowns), source=0.0_dp)
      u(:, 1) = [1.1_dp, 0.6_dp, -0.2_dp, 0.3_dp, 0.1_dp]
      u(:, 2) = u(:, 1)
      call balance%evaluate(u, frequency_ratio)
      theta = [(2*pi*q/samples, q=0, samples - 1)]
      kappa = 1 + 0.3_dp*cos(theta)
      g = u(1, 1)
      damping = 0
      do r = 1, 2
         g = g + u(2*r, 1)*cos(r*theta) + u(2*r + 1, 1)*sin(r*theta)
         damping = damping + system%damping(2)*frequency_ratio*r*(u(2*r + 1, 1)*cos(r*theta) - u(2*r, 1)*sin(r*theta))
      end do
      g = sign(max(abs(g) - 1, 0.0_dp), g)
      cut = sum(g)/samples
      do r = 1, 2
         cut = cut + 2*sum(g*cos(r*theta))/samples*cos(r*theta) + 2*sum(g*sin(r*theta))/samples*sin(r*theta)
      end do
      whole = 2*sum((kappa*g + damping)*cos(2*theta))/samples
      truncated = 2*sum((kappa*cut + damping)*cos(2*theta))/samples
      call tests%is_close(balance%force(4, 1), whole, 1e-5_dp, '(9): kappa g projected as a whole')
      call tests%is_true(abs(truncated - whole) > 1e-3_dp, '(9): cutting g off first drops a term')
   end subroutine projection

   !> The paper's rms is sqrt(2) times the root mean square of the alternating part.
   subroutine root_mean_square(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(motion_type), allocatable :: motions(:)
      type(error_type), allocatable :: error
      real(dp) :: time(64), displacement(64, 2), mean
      integer :: j

      call response(paper_train(), settings_of(1.3_dp, 0.9_dp, 6), branch, error)
      call solutions_at(paper_train(), settings_of(1.3_dp, 0.9_dp, 6), branch, 0.95_dp, motions, error)
      call waveform(paper_train(), motions(1), 64, time, displacement)
      do j = 1, 2
         mean = sum(displacement(:, j))/64
         call tests%is_close(motions(1)%rms(j)/sqrt(sum((displacement(:, j) - mean)**2)/64), sqrt(2.0_dp), 1e-12_dp, &
                             'rms over the true AC rms')
      end do
   end subroutine root_mean_square

   !> Figure 8: harmonics of a rectangular wave of contact ratio 1.5 (half of the period with two pairs in contact).
   subroutine rectangular_wave(tests)
      class(tests_type), intent(inout) :: tests
      real(dp), parameter :: duty = 0.5_dp
      real(dp) :: harmonic(5)
      integer :: h

      harmonic = [(sin(pi*h*duty)/h, h=1, 5)]/sin(pi*duty)*0.42_dp
      call tests%is_close(harmonic(3), -0.141_dp, 2e-3_dp, 'figure 8: third harmonic as printed')
      call tests%is_close(harmonic(5), 0.084_dp, 1e-12_dp, 'figure 8: fifth harmonic +0.084, printed -0.085')
      call tests%is_close(maxval(abs(harmonic([2, 4]))), 0.0_dp, 1e-12_dp, 'figure 8: even harmonics vanish')
   end subroutine rectangular_wave

   !> Section 4.3 prints w_b/3 = 0.65 and w_b/2 = 0.98, section 4.4 prints 2 w_b = 3.92.
   subroutine resonances_of_other_orders(tests)
      class(tests_type), intent(inout) :: tests
      real(dp), parameter :: w_b = 1.866211_dp

      call tests%is_close(w_b/3, 0.622_dp, 5e-4_dp, 'w_b/3 is 0.622, printed 0.65')
      call tests%is_close(w_b/2, 0.933_dp, 5e-4_dp, 'w_b/2 is 0.933, printed 0.98 (and 0.93 elsewhere)')
      call tests%is_close(2*w_b, 3.732_dp, 5e-4_dp, '2 w_b is 3.732, printed 3.92')
   end subroutine resonances_of_other_orders

end module validation_errata
