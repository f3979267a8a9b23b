!> What the teeth bear: largest mesh force, dynamic factor, shares of separation and back contact.
module validation_mesh_load
   use fixtures, only: linear_pair, paper_train, settings_of, single_pair
   use geartrain, only: branch_type, dp, error_type, integrate, integration_settings_type, motion_type, refine, response, &
                        response_settings_type, solutions_at, train_type, waveform
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: mesh_load_tests

contains

   subroutine mesh_load_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('balance_against_shooting')) call balance_against_shooting(tests)
      if (tests%runs('shares_by_counting')) call shares_by_counting(tests)
      if (tests%runs('extremes_by_sampling')) call extremes_by_sampling(tests)
      if (tests%runs('closed_form')) call closed_form(tests)
      if (tests%runs('constant_load')) call constant_load(tests)
      if (tests%runs('turned_round')) call turned_round(tests)
      if (tests%runs('without_static_force')) call without_static_force(tests)
   end subroutine mesh_load_tests

   !> Three solutions at 0.6, one of them with back collision: shooting as the reference, which integrates event by event.
   subroutine balance_against_shooting(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: harmonics(*) = [6, 48, 96]
      !> The waveform's error falls as R^-3; the mode at 15.9 is excited by harmonic 26 at 0.6, hence no R in between.
      real(dp), parameter :: force(*) = [4e-3_dp, 1e-5_dp, 1e-6_dp], share(*) = [6e-3_dp, 2e-5_dp, 2e-6_dp]
      type(response_settings_type) :: settings
      type(branch_type) :: branch
      type(motion_type), allocatable :: motions(:)
      type(motion_type) :: exact
      type(error_type), allocatable :: error
      integer :: i, j, n
      character(32) :: name

      do i = 1, size(harmonics)
         settings = settings_of(0.4_dp, 1.0_dp, harmonics(i))
         settings%stability = .false.
         call response(paper_train(), settings, branch, error)
         call solutions_at(paper_train(), settings, branch, 0.6_dp, motions, error)
         call tests%is_true(size(motions) == 3, 'three solutions at 0.6')
         do n = 1, size(motions)
            exact = motions(n)
            call refine(paper_train(), exact, error)
            call tests%is_true(.not. allocated(error), 'shooting converges')
            do j = 1, 2
               write (name, '(3(a, i0))') 'R = ', harmonics(i), ', motion ', n, ', mesh ', j
               associate (found => motions(n)%mesh_load(j), load => exact%mesh_load(j))
                  call tests%is_close(found%force_maximum/load%force_maximum, 1.0_dp, force(i), 'largest force, '//name)
                  call tests%is_close(found%separation, load%separation, share(i), 'separation, '//name)
                  call tests%is_close(found%back_contact, load%back_contact, share(i), 'back contact, '//name)
                  ! 150 N m at a base circle of 50 mm, then twice that: the mean mesh forces.
                  call tests%is_close(load%dynamic_factor, load%force_maximum/(3000.0_dp*j), 1e-12_dp, 'factor, '//name)
               end associate
            end do
         end do
      end do
   end subroutine balance_against_shooting

   !> Smallest and largest displacement at every point of figure 3 against 4000 samples, which miss an extreme by
   !> curvature/2 (pi/4000)^2 at most; maxima of nearly the same height are among them.
   subroutine extremes_by_sampling(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: samples = 4000
      real(dp), parameter :: pi = acos(-1.0_dp)
      type(branch_type) :: branch
      type(response_settings_type) :: settings
      type(error_type), allocatable :: error
      real(dp) :: p(samples), theta(samples), curvature, off
      integer :: i, j, k

      settings = settings_of(0.5_dp, 0.8_dp, 6)
      settings%step = 0.03_dp
      call response(paper_train(), settings, branch, error)
      theta = [(2*pi*k/samples, k=0, samples - 1)]
      off = 0
      do i = 1, branch%points
         do j = 1, 2
            associate (c => branch%coefficients(:, j, i))
               p = c(1)
               curvature = 0
               do k = 1, 6
                  p = p + c(2*k)*cos(k*theta) + c(2*k + 1)*sin(k*theta)
                  curvature = curvature + k**2*norm2(c(2*k:2*k + 1))
               end do
            end associate
            off = max(off, (abs(branch%maximum(j, i) - maxval(p)) - 0.5_dp*curvature*(pi/samples)**2), &
                      (abs(branch%minimum(j, i) - minval(p)) - 0.5_dp*curvature*(pi/samples)**2))
         end do
      end do
      call tests%is_true(branch%points > 100, 'extremes: many points')
      call tests%is_true(off < 1e-12_dp, 'extremes: as sampled, at every point')
   end subroutine extremes_by_sampling

   !> Integration from rest at 0.72, and the large motion with back collision: shares against counts, maxima against samples.
   subroutine shares_by_counting(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: samples = 20000
      type(motion_type) :: motion
      type(response_settings_type) :: settings
      type(branch_type) :: branch
      type(motion_type), allocatable :: motions(:)
      type(error_type), allocatable :: error
      real(dp), allocatable :: time(:), displacement(:, :), force(:, :)
      integer :: j

      settings = settings_of(0.4_dp, 1.0_dp, 12)
      call response(paper_train(), settings, branch, error)
      call solutions_at(paper_train(), settings, branch, 0.72_dp, motions, error)
      motion = motions(maxloc([(motions(j)%rms(2), j=1, size(motions))], 1))
      call refine(paper_train(), motion, error)
      allocate (time(samples), displacement(samples, 2), force(samples, 2))
      call waveform(paper_train(), motion, samples, time, displacement, force)
      call tests%is_true(motion%mesh_load(2)%back_contact > 0.1_dp, 'back collision at 0.72')
      do j = 1, 2
         associate (load => motion%mesh_load(j), p => displacement(:, j))
            ! Each of the few crossings is missed by at most one sample.
            call tests%is_close(load%separation, count(abs(p) < 1)/real(samples, dp), 4.0_dp/samples, 'separation counted')
            call tests%is_close(load%back_contact, count(p < -1)/real(samples, dp), 2.0_dp/samples, 'back contact counted')
            call tests%is_close(load%force_maximum/maxval(force(:, j)), 1.0_dp, 1e-6_dp, 'largest force among samples')
            ! In a periodic motion the mean of the force is the static one.
            call tests%is_close(sum(force(:, j))/samples, 3000.0_dp*j, 0.1_dp, 'mean force')
         end associate
      end do
   end subroutine shares_by_counting

   !> p'' + 0.2 p' + p = 0.4 + 0.5 cos(Lambda t): F = 0.4 + Re((1 + 0.2 i Lambda) A exp(i Lambda t)); in N, as k b_c = 1 N.
   subroutine closed_form(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: branch
      type(motion_type) :: motion
      type(error_type), allocatable :: error
      real(dp) :: largest, lambda
      integer :: i

      train = linear_pair(0.4_dp)
      call response(train, settings_of(0.5_dp, 1.5_dp, 3), branch, error)
      do i = 1, branch%points, 7
         lambda = branch%frequency_ratio(i)
         largest = 0.4_dp + transmitted(lambda)
         call tests%is_close(branch%mesh_load(1, i)%force_maximum, largest, 1e-12_dp, 'largest force of a linear mesh')
         call tests%is_close(branch%mesh_load(1, i)%dynamic_factor, largest/0.4_dp, 1e-11_dp, 'its dynamic factor')
         call tests%is_true(branch%mesh_load(1, i)%separation <= 0 .and. branch%mesh_load(1, i)%back_contact <= 0, &
                            'a mesh without backlash has no separation')
      end do
      call integrate(train, 0.9_dp, integration_settings_type(), motion, error)
      call tests%is_close(motion%mesh_load(1)%force_maximum, 0.4_dp + transmitted(0.9_dp), 1e-8_dp, 'the same by integration')
   end subroutine closed_form

   !> Amplitude of the force that a torque of amplitude 1 N m on gear 1 (I = 2 kg m^2) transmits.
   pure real(dp) function transmitted(lambda)
      real(dp), intent(in) :: lambda

      transmitted = 0.5_dp*abs(cmplx(1, 0.2_dp*lambda, dp)/cmplx(1 - lambda**2, 0.2_dp*lambda, dp))
   end function transmitted

   !> Without excitation the factor is 1 and the teeth stay together.
   subroutine constant_load(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(error_type), allocatable :: error

      call response(single_pair(0.05_dp, 0.0_dp, 0.4_dp), settings_of(0.5_dp, 0.6_dp, 4), branch, error)
      call tests%is_close(maxval(abs(branch%mesh_load%dynamic_factor - 1)), 0.0_dp, 1e-12_dp, 'a constant load: factor 1')
      call tests%is_close(maxval(branch%mesh_load%separation), 0.0_dp, 0.0_dp, 'a constant load: no separation')
   end subroutine constant_load

   !> The torque turned round: p becomes -p, the flanks change their parts, the force and the factor stay.
   subroutine turned_round(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: branch, other
      type(error_type), allocatable :: error
      integer :: n

      train = paper_train()
      call response(train, settings_of(0.6_dp, 0.9_dp, 8), branch, error)
      train%input_torque = -train%input_torque
      call response(train, settings_of(0.6_dp, 0.9_dp, 8), other, error)
      call tests%is_true(branch%points == other%points, 'as many points')
      n = min(branch%points, other%points)
      associate (a => branch%mesh_load(:, :n), b => other%mesh_load(:, :n))
         call tests%is_close(maxval(abs(a%dynamic_factor - b%dynamic_factor)), 0.0_dp, 1e-9_dp, 'the same factors')
         call tests%is_close(maxval(abs(a%separation - b%separation)), 0.0_dp, 1e-9_dp, 'the same shares of separation')
         call tests%is_close(maxval(abs(1 - b%back_contact - b%separation - a%back_contact)), 0.0_dp, 1e-9_dp, &
                             'the back flanks bear what the drive flanks bore')
      end associate
   end subroutine turned_round

   !> No torque: no static force, hence no factor; the largest force counts in either direction.
   subroutine without_static_force(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: branch
      type(motion_type) :: motion
      type(error_type), allocatable :: error
      integer :: n

      train = linear_pair(0.0_dp)
      call response(train, settings_of(0.5_dp, 0.9_dp, 3), branch, error)
      n = branch%points
      call tests%is_true(.not. allocated(error) .and. branch%complete, 'a train without torque is traced')
      call tests%is_close(branch%mesh_load(1, n)%force_maximum, transmitted(0.9_dp), 1e-12_dp, 'its largest force')
      call tests%is_true(branch%mesh_load(1, n)%dynamic_factor < 0, 'and no dynamic factor')
      call integrate(train, 0.9_dp, integration_settings_type(), motion, error)
      call tests%is_close(motion%mesh_load(1)%force_maximum, transmitted(0.9_dp), 1e-8_dp, 'the same by integration')
      call tests%is_true(motion%mesh_load(1)%dynamic_factor < 0, 'no factor by integration')
      train%meshes(1)%half_backlash = 1
      call response(train, settings_of(0.5_dp, 0.9_dp, 3), branch, error)
      call integrate(train, 0.9_dp, integration_settings_type(), motion, error)
      call tests%is_true(motion%mesh_load(1)%dynamic_factor < 0, 'with backlash')
   end subroutine without_static_force

end module validation_mesh_load
