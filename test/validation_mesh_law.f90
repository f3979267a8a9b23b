!> Mesh laws beyond one stiffness and damping at all times: damping in contact only, back flanks of their own. Checked by
!> integration, shooting and balance against one another, and where the law is an ordinary one in another form.
module validation_mesh_law
   use fixtures, only: paper_train, settings_of, single_pair
   use geartrain, only: audit_branch, audit_type, branch_type, dp, error_type, integrate, integration_settings_type, modes_type, &
      motion_type, natural_modes, refine, response, response_settings_type, train_type
   use geartrain_balance_balance, only: balance_type
   use geartrain_base_kinds, only: pi
   use geartrain_floquet_monodromy, only: monodromy_type
   use geartrain_flow_orbit, only: propagate
   use geartrain_linalg_bordered, only: bordered_type
   use geartrain_mesh_law_law, only: law_type
   use geartrain_network_system, only: build_system, system_type
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: mesh_law_tests

contains

   subroutine mesh_law_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('damping_in_contact')) call damping_in_contact(tests)
      if (tests%runs('convergence')) call convergence(tests)
      if (tests%runs('derivatives')) then
         call derivatives(tests, system_of(.false.))
         call derivatives(tests, system_of(.true.))
      end if
      if (tests%runs('tangents')) then
         call tangents(tests, system_of(.false.))
         call tangents(tests, system_of(.true.))
      end if
      if (tests%runs('branch')) call a_branch(tests)
      if (tests%runs('multipliers')) call multipliers(tests)
      if (tests%runs('like_ordinary_meshes')) call like_ordinary_meshes(tests)
      if (tests%runs('mirrored_train')) call mirrored_train(tests)
   end subroutine mesh_law_tests

   !> p'' + 0.1 chi p' + (1 + 0.3 cos t) g(p) = 0.4: damping in contact only.
   function pair() result(train)
      type(train_type) :: train

      train = single_pair(0.05_dp, 0.3_dp, 0.4_dp)
      train%meshes(1)%damping_acts = 'contact'
   end function pair

   !> Two meshes with all that a law has, at which both flanks touch.
   function rich_train() result(train)
      type(train_type) :: train

      train = paper_train()
      train%input_torque = 40
      train%meshes%damping_acts = 'contact'
      train%meshes(1)%back_stiffness = 1.7e8_dp
      train%meshes(1)%back_phase = 0.8_dp
      train%meshes(2)%back_stiffness = 6e8_dp
      train%meshes(2)%phase = 0.4_dp
   end function rich_train

   !> The rich train; with stages, mesh 1 has regions beyond twice its gap, with a stiffness and a damping of their own.
   function system_of(stages) result(system)
      logical, intent(in) :: stages
      type(system_type) :: system
      type(law_type) :: law

      call build_system(rich_train(), system)
      if (.not. stages) return
      associate (old => system%law(1))
         call law%begin(-2, [-2.0_dp, -1.0_dp, 1.0_dp, 2.0_dp], old%harmonic)
         law%stiffness(:) = [1.5_dp*old%stiffness(-1), old%stiffness, 1.8_dp]
         law%amplitude(:, -1:1) = old%amplitude
         law%amplitude(:, 2) = 1.8_dp*old%amplitude(:, 1)
         law%amplitude(:, -2) = 1.5_dp*old%amplitude(:, -1)
         law%origin(:) = [-2 + 1/1.5_dp, old%origin, 2 - 1/1.8_dp]
         law%damping(:) = [0.7_dp, 1.0_dp, 0.0_dp, 1.0_dp, 1.4_dp]
         call law%complete(old%damping(1))
      end associate
      system%law(1) = law
   end function system_of

   pure real(dp) function ac_rms(motion)
      type(motion_type), intent(in) :: motion

      ac_rms = motion%rms(1)/sqrt(2.0_dp)
   end function ac_rms

   !> Issue 11: mean 1.282976703, true AC rms 0.403882668 (all digits given).
   subroutine damping_in_contact(tests)
      class(tests_type), intent(inout) :: tests
      type(motion_type) :: motion
      type(error_type), allocatable :: error

      call integrate(pair(), 1.0_dp, integration_settings_type(), motion, error)
      call tests%is_true(.not. allocated(error), 'integration runs')
      call tests%is_close(motion%mean(1), 1.282976703_dp, 1e-9_dp, 'mean by integration')
      call tests%is_close(ac_rms(motion), 0.403882668_dp, 1e-9_dp, 'AC rms by integration')
      call refine(pair(), motion, error)
      call tests%is_true(.not. allocated(error), 'shooting converges')
      call tests%is_close(motion%mean(1), 1.282976703_dp, 1e-9_dp, 'mean by shooting')
      call tests%is_close(ac_rms(motion), 0.403882668_dp, 1e-9_dp, 'AC rms by shooting')
   end subroutine damping_in_contact

   !> The force jumps at events, p'' with it: |p_k| falls as k^-3 and the error of the waveform, a sum of these, as R^-2, that of
   !> the rms at least as fast.
   subroutine convergence(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: harmonics(*) = [8, 16, 32, 64]
      type(motion_type) :: exact
      type(branch_type) :: branch
      type(error_type), allocatable :: error
      real(dp) :: waveform_error(size(harmonics)), rms_error(size(harmonics))
      real(dp), allocatable :: gap(:)
      integer :: i, n

      call integrate(pair(), 1.0_dp, integration_settings_type(), exact, error)
      call refine(pair(), exact, error, harmonics=256)
      do i = 1, size(harmonics)
         call solve_at(pair(), 1.0_dp, harmonics(i), exact, branch)
         n = 1 + 2*harmonics(i)
         gap = exact%coefficients(:, 1)
         gap(:n) = gap(:n) - branch%coefficients(:n, 1, 1)
         waveform_error(i) = largest(gap)
         rms_error(i) = abs(branch%rms(1, 1) - exact%rms(1))
         call tests%is_true(branch%error_estimate(1) > 0.2_dp*norm2(gap)/norm2(exact%coefficients(2:, 1)) .and. &
                            branch%error_estimate(1) < 5*norm2(gap)/norm2(exact%coefficients(2:, 1)), &
                            'the estimate tells the error')
      end do
      call tests%is_close(abs(branch%mean(1, 1) - 1.282976703_dp), 0.0_dp, 1e-5_dp, 'mean by a balance of 64 harmonics')
      call tests%is_close(branch%rms(1, 1)/sqrt(2.0_dp), 0.403882668_dp, 1e-5_dp, 'AC rms by a balance of 64 harmonics')
      associate (order => log(waveform_error(1)/waveform_error(size(harmonics)))/log(8.0_dp))
         call tests%is_close(order, 2.0_dp, 0.35_dp, 'order of the waveform')
      end associate
      associate (order => log(rms_error(1)/rms_error(size(harmonics)))/log(8.0_dp))
         call tests%is_true(order > 1.8_dp, 'order of the rms is at least that')
      end associate

   contains

      pure real(dp) function largest(u)
         real(dp), intent(in) :: u(:)
         integer :: k, q
         integer, parameter :: samples = 1000

         largest = 0
         do q = 1, samples
            largest = max(largest, abs(u(1) + sum([(u(2*k)*cos(2*pi*k*q/samples) + u(2*k + 1)*sin(2*pi*k*q/samples), &
                                                    k=1, (size(u) - 1)/2)])))
         end do
      end function largest

   end subroutine convergence

   !> A branch of a point or few at `frequency_ratio`, from a motion.
   subroutine solve_at(train, frequency_ratio, harmonics, start, branch)
      type(train_type), intent(in) :: train
      real(dp), intent(in) :: frequency_ratio
      integer, intent(in) :: harmonics
      type(motion_type), intent(in) :: start
      type(branch_type), intent(out) :: branch
      type(response_settings_type) :: settings
      type(error_type), allocatable :: error

      settings = settings_of(frequency_ratio, frequency_ratio + 0.01_dp, harmonics)
      settings%stability = .true.
      call response(train, settings, branch, error, seed=start)
   end subroutine solve_at

   !> dS/du and dS/dLambda against central differences, 3e-7 of the largest entry, at motions that touch both flanks; few harmonics
   !> and, by products, many.
   subroutine derivatives(tests, system)
      class(tests_type), intent(inout) :: tests
      type(system_type), target, intent(in) :: system
      type(balance_type) :: balance
      type(bordered_type) :: matrix
      integer, parameter :: harmonics(*) = [5, 20]
      real(dp), parameter :: frequency_ratio = 0.83_dp, slow = 0.05_dp, h = 1e-6_dp
      real(dp), allocatable :: u(:, :), x(:, :), change(:, :), difference(:, :)
      integer :: i, k, n

      do i = 1, size(harmonics)
         call balance%setup(system, harmonics(i), 1, 0)
         n = balance%block
         u = reshape([(0.5_dp*sin(1.3_dp*k)/(1 + 0.2_dp*k), k=1, n*2)], [n, 2])
         u(1, :) = [0.2_dp, -0.1_dp]
         u(2, :) = [1.9_dp, 1.6_dp]
         x = reshape([(cos(0.7_dp*k), k=1, n*2)], [n, 2])
         call balance%evaluate(u + h*x, frequency_ratio)
         call tests%is_true(all(balance%contact%events >= 4), 'both flanks touch')
         difference = balance%residual
         call balance%evaluate(u - h*x, frequency_ratio)
         difference = (difference - balance%residual)/(2*h)
         ! At a low frequency all harmonics are eliminated. The products must not keep anything of the motion there.
         call balance%evaluate(2*u, slow)
         call tests%is_true(balance%is_direct(), 'low frequencies couple all harmonics strongly')
         call balance%evaluate(u, frequency_ratio)
         call tests%is_true(balance%is_direct() .eqv. harmonics(i) < 16, 'as many harmonics are eliminated as before')
         allocate (change, mold=x)
         if (balance%is_direct()) then
            call balance%jacobian(matrix)
            change = 0
                  do k = 1, 2
               change(:, k) = matmul(matrix%entry(:, :, k), x(:, k)) &
                              + matmul(matrix%entry(:, :, balance%system%cut%graph%entry_of(k, 3 - k)), x(:, 3 - k))
            end do
         else
            call balance%apply(x, change)
         end if
         call tests%is_close(maxval(abs(change - difference))/maxval(abs(difference)), 0.0_dp, 3e-7_dp, 'dS/du')
         change = balance%d_frequency
         call balance%evaluate(u, frequency_ratio + h)
         difference = balance%residual
         call balance%evaluate(u, frequency_ratio - h)
         difference = (difference - balance%residual)/(2*h)
         call tests%is_close(maxval(abs(change - difference))/maxval(abs(difference)), 0.0_dp, 3e-7_dp, 'dS/dLambda')
         deallocate (change)
      end do
   end subroutine derivatives

   !> What the flow carries against central differences of the flow, over periods with both flanks touching.
   subroutine tangents(tests, system)
      class(tests_type), intent(inout) :: tests
      type(system_type), target, intent(in) :: system
      real(dp), parameter :: h = 1e-6_dp, frequency_ratio = 0.83_dp
      real(dp), allocatable :: state(:), ahead(:), behind(:), monodromy(:, :), ignored(:, :)
      integer :: k, n

      n = system%states
      allocate (state(n), ahead(n), behind(n), monodromy(n, n), ignored(n, n))
      state = 0
      state(system%mesh_element) = [2.5_dp, -1.2_dp]
      call propagate(system, frequency_ratio, 1, state, ahead, monodromy)
      do k = 1, n
         state(k) = state(k) + h
         call propagate(system, frequency_ratio, 1, state, ahead, ignored)
         state(k) = state(k) - 2*h
         call propagate(system, frequency_ratio, 1, state, behind, ignored)
         state(k) = state(k) + h
         call tests%is_close(maxval(abs((ahead - behind)/(2*h) - monodromy(:, k)))/maxval(abs(monodromy)), 0.0_dp, 1e-7_dp, &
                             'tangent of the flow')
      end do
   end subroutine tangents

   !> Multipliers of one motion by the monodromy between the balance's events, and by the flow along the orbit: they differ by the
   !> balance's error. Liouville's determinant holds to 1e-7 (confirmed).
   subroutine multipliers(tests)
      class(tests_type), intent(inout) :: tests
      type(motion_type) :: motion
      type(error_type), allocatable :: error
      type(system_type), target :: system
      type(balance_type) :: balance
      type(monodromy_type) :: monodromy
      complex(dp), allocatable :: values(:)
      real(dp) :: apart
      integer :: i, k

      call integrate(rich_train(), 0.9_dp, integration_settings_type(), motion, error)
      call tests%is_true(.not. allocated(error) .and. motion%period > 0, 'a motion of the rich train')
      call refine(rich_train(), motion, error, harmonics=400)
      call tests%is_true(.not. allocated(error), 'its orbit')
      call tests%is_true(any(motion%mesh_load%separation > 0), 'it separates')
      call build_system(rich_train(), system)
      call balance%setup(system, 400*motion%period, motion%period, 0)
      call monodromy%setup(system)
      block
         real(dp) :: u(balance%block, balance%unknowns)

         u(1, :) = motion%coefficients(1, balance%mesh)
         do k = 1, size(balance%harmonic)
            u(2*k:2*k + 1, :) = motion%coefficients(2*balance%harmonic(k):2*balance%harmonic(k) + 1, balance%mesh)
         end do
         call balance%evaluate(u, motion%frequency_ratio)
      end block
      call monodromy%integrate(balance, motion%frequency_ratio)
      allocate (values(size(motion%multipliers)))
      call monodromy%multipliers(values)
      call tests%is_true(monodromy%confirmed, "Liouville's determinant")
      apart = 0
      do i = 1, size(values)
         apart = max(apart, minval(abs(values - motion%multipliers(i))))
      end do
      ! Events of 400 harmonics are off by about 1e-6.
      call tests%is_close(apart, 0.0_dp, 1e-5_dp, 'multipliers between events and by shooting')
   end subroutine multipliers

   !> The train of figure 3 with damping in contact only, through its folds: the branch goes through, its multipliers are confirmed,
   !> and an audit of its points finds no verdict wrong and no estimate that is not doubtful off by more than it allows.
   subroutine a_branch(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: branch
      type(response_settings_type) :: settings
      type(audit_type) :: audit
      type(error_type), allocatable :: error
      character(24) :: kinds
      integer :: i, folds, doublings

      train = paper_train()
      train%meshes%damping_acts = 'contact'
      settings = settings_of(0.4_dp, 1.1_dp, 12)
      settings%stability = .true.
      call response(train, settings, branch, error)
      call tests%is_true(.not. allocated(error) .and. branch%complete, 'the branch of figure 3 with damping in contact only')
      folds = 0
      doublings = 0
      do i = 1, size(branch%special_points)
         kinds = branch%special_points(i)%kind
         if (kinds == 'fold') folds = folds + 1
         if (kinds == 'period doubling') doublings = doublings + 1
      end do
      call tests%is_true(folds >= 2 .and. doublings >= 2, 'folds and period doublings')
      call audit_branch(train, branch, 12, 0, audit, error)
      call tests%is_true(.not. allocated(error), 'audit runs')
      call tests%is_true(audit%points == 12 .and. audit%wrong_verdicts == 0, 'no verdict is wrong')
      call tests%is_true(audit%confirmed == audit%special_points, 'the exact motion has the special points')
      call tests%is_true(.not. any(audit%rows%estimate_wrong .and. audit%rows%kind == 'point'), 'no estimate is wrong')
   end subroutine a_branch

   !> A back flank with the stiffness of the drive flank and no phase, and damping in contact only where nothing separates, are the
   !> ordinary mesh.
   subroutine like_ordinary_meshes(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: plain, branch

      train = paper_train()
      call trace(0.45_dp, 0.62_dp, plain)
      train%meshes%back_stiffness = train%meshes%stiffness
      call trace(0.45_dp, 0.62_dp, branch)
      call tests%is_true(branch%points == plain%points, 'back_stiffness = stiffness: points')
      if (branch%points == plain%points) call tests%is_close(maxval(abs(branch%coefficients(:, :, :branch%points) &
         - plain%coefficients(:, :, :plain%points))), 0.0_dp, 1e-14_dp, 'back_stiffness = stiffness: the motions')
      train = paper_train()
      call trace(1.6_dp, 1.65_dp, plain)
      call tests%is_true(all(plain%minimum(:, :plain%points) > 1), 'nothing separates')
      train%meshes%damping_acts = 'contact'
      call trace(1.6_dp, 1.65_dp, branch)
      call tests%is_true(branch%points == plain%points, 'damping in contact without separation: points')
      if (branch%points == plain%points) call tests%is_close(maxval(abs(branch%coefficients(:, :, :branch%points) &
         - plain%coefficients(:, :, :plain%points))), 0.0_dp, 1e-12_dp, 'damping in contact without separation: the motions')
      call tests%is_close(maxval(abs(branch%multipliers(:, :plain%points) - plain%multipliers(:, :plain%points))), 0.0_dp, &
                          1e-8_dp, 'damping in contact without separation: multipliers')

   contains

      subroutine trace(from, to, branch)
         real(dp), intent(in) :: from, to
         type(branch_type), intent(out) :: branch
         type(response_settings_type) :: settings
         type(error_type), allocatable :: error

         settings = settings_of(from, to, 8)
         settings%stability = .true.
         call response(train, settings, branch, error)
         call tests%is_true(.not. allocated(error), 'a branch')
      end subroutine trace

   end subroutine like_ordinary_meshes

   !> Driven backwards a train bears on its back flanks: it moves as the train driven forwards that has them as drive flanks, the
   !> other way: its modes, its motion by the balance and by shooting, multipliers, forces, shares of contact.
   subroutine mirrored_train(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train, mirror
      type(motion_type) :: one, other
      type(branch_type) :: branch, reflected
      type(modes_type) :: modes, others
      type(error_type), allocatable :: error
      integer :: j

      train = rich_train()
      train%input_torque = -150
      do j = 1, 2
         ! One damping on both flanks.
         train%meshes(j)%damping = 900*j
         train%meshes(j)%damping_given = .true.
      end do
      mirror = train
      mirror%input_torque = 150
      do j = 1, 2
         associate (mesh => train%meshes(j), back => mirror%meshes(j))
            back%stiffness = mesh%back_stiffness
            back%back_stiffness = mesh%stiffness
            back%phase = mesh%phase + mesh%back_phase
            back%back_phase = -mesh%back_phase
         end associate
      end do
      call natural_modes(train, modes, error)
      call natural_modes(mirror, others, error)
      call tests%is_close(maxval(abs(modes%natural_frequency/others%natural_frequency - 1)), 0.0_dp, 1e-12_dp, 'modes')
      call tests%is_close(maxval(abs(modes%damping_ratio - others%damping_ratio)), 0.0_dp, 1e-12_dp, 'their damping')
      call response(train, settings_of(0.8_dp, 0.9_dp, 12), branch, error)
      call response(mirror, settings_of(0.8_dp, 0.9_dp, 12), reflected, error)
      call tests%is_true(branch%points == reflected%points, 'points of the branches')
      if (branch%points == reflected%points) then
         call tests%is_close(maxval(abs(branch%mean(:, :branch%points) + reflected%mean(:, :branch%points))), 0.0_dp, 1e-8_dp, &
                             'means on the branch')
         call tests%is_close(maxval(abs(branch%mesh_load(:, :branch%points)%dynamic_factor &
                                        - reflected%mesh_load(:, :branch%points)%dynamic_factor)), 0.0_dp, 1e-7_dp, &
                             'dynamic factors on the branch')
      end if
      call integrate(train, 0.85_dp, integration_settings_type(), one, error)
      call integrate(mirror, 0.85_dp, integration_settings_type(), other, error)
      call refine(train, one, error)
      call refine(mirror, other, error)
      call tests%is_true(any(other%mesh_load%separation > 0), 'it separates')
      call tests%is_close(maxval(abs(one%mean + other%mean)), 0.0_dp, 1e-10_dp, 'mean')
      call tests%is_close(maxval(abs(one%rms - other%rms)), 0.0_dp, 1e-10_dp, 'rms')
      call tests%is_close(maxval(abs(one%multipliers - other%multipliers)), 0.0_dp, 1e-8_dp, 'multipliers')
      call tests%is_close(maxval(abs(one%mesh_load%force_maximum/other%mesh_load%force_maximum - 1)), 0.0_dp, 1e-6_dp, 'forces')
      call tests%is_close(maxval(abs(one%mesh_load%back_contact - 1 + other%mesh_load%back_contact &
                                     + other%mesh_load%separation)), 0.0_dp, 1e-9_dp, 'shares of contact')
   end subroutine mirrored_train

end module validation_mesh_law
