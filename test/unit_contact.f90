!> Contact events and the spectra that follow from them, against numerical quadrature.
module unit_contact
   use fixtures, only: update_contact
   use geartrain, only: dp
   use geartrain_base_kinds, only: pi
   use geartrain_linalg_trigonometric, only: evaluate
   use geartrain_mesh_law_contact, only: contact_type
   use geartrain_mesh_law_law, only: law_type
   use geartrain_train_mesh, only: mesh_type, put_law
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: contact_tests

contains

   subroutine contact_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('spectra')) then
         call spectra(tests, [0.9_dp, 0.8_dp, -0.3_dp, 0.1_dp, 0.4_dp], 2, 'separation')
         call spectra(tests, [0.1_dp, 2.5_dp, -1.0_dp, 0.6_dp, 0.4_dp], 8, 'both flanks')
         call spectra(tests, [-3.0_dp, 0.5_dp, 0.0_dp, 0.0_dp, 0.4_dp], 0, 'back flank only')
         call spectra(tests, [0.0_dp, 0.5_dp, 0.0_dp, 0.0_dp, 0.4_dp], 0, 'no contact')
      end if
      if (tests%runs('grazing')) call grazing(tests)
      if (tests%runs('crossing_both_walls')) call crossing_both_walls(tests)
   end subroutine contact_tests

   !> F = Toeplitz(w) p - offset must be the Fourier coefficients of kappa g(p): trapezoidal rule between the events is
   !> replaced by 2e5 equidistant samples, whose error for a kink is near (2 pi/2e5)^2 = 1e-9.
   subroutine spectra(tests, u, highest_events, name)
      class(tests_type), intent(inout) :: tests
      real(dp), intent(in) :: u(:)
      integer, intent(in) :: highest_events
      character(*), intent(in) :: name
      integer, parameter :: n = 200000, highest = 12
      type(contact_type) :: contact
      type(law_type) :: law
      complex(dp) :: w(0:highest), sigma(0:highest), turn
      real(dp) :: theta, p, slope, curvature
      complex(dp) :: force, expected
      integer :: q, k, m, side

      call put_law(mesh_type(order=1, stiffness=1.0_dp, half_backlash=1.0_dp, stiffness_cos=[0.3_dp, -0.05_dp], &
                             stiffness_sin=[-0.1_dp, -0.2_dp]), 1.0_dp, law)
      call law%complete(0.0_dp)
      call contact%setup(law, 1, [1, 2], highest, 0)
      call update_contact(contact, u)
      call tests%is_true(contact%events <= highest_events .and. (contact%events > 0 .eqv. highest_events > 0), &
                         name//': number of events')
      w = 0
      sigma = 0
      expected = 0
      do q = 0, n - 1
         theta = 2*pi*q/n
         call evaluate(u, [1, 2], theta, p, slope, curvature)
         side = 0
         if (p > 1) side = 1
         if (p < -1) side = -1
         if (side == 0) cycle
         turn = exp(cmplx(0, -3*theta, dp))
         expected = expected + law%stiffness_at(side, theta)*(p - side)*turn/n
      end do
      ! Coefficient 3 of the force from the spectra: sum over k of w(3-k) c(k) - offset(3), c two-sided.
      force = contact%spectra%stiffness(3)*u(1) - contact%spectra%offset(3)
      do k = 1, 2
         m = 3 - k
         force = force + contact%spectra%stiffness(m)*cmplx(u(2*k), -u(2*k + 1), dp)/2 &
                 + contact%spectra%stiffness(3 + k)*cmplx(u(2*k), u(2*k + 1), dp)/2
      end do
      call tests%is_close(abs(force - expected), 0.0_dp, 1e-8_dp, name//': third harmonic of the force')
   end subroutine spectra

   !> p = 1 + d + cos(theta) - 1 touches the wall -... : a dip of depth d below the wall between two samples is found.
   subroutine grazing(tests)
      class(tests_type), intent(inout) :: tests
      type(contact_type) :: contact
      type(law_type) :: law
      real(dp), parameter :: depth = 1e-6_dp
      real(dp) :: shift, half_width

      call put_law(mesh_type(order=1, stiffness=1.0_dp, half_backlash=1.0_dp), 1.0_dp, law)
      call law%complete(0.0_dp)
      call contact%setup(law, 1, [1], 3, 0)
      ! The lowest point lies between two samples of the grid of 32.
      shift = pi/32
      call update_contact(contact, [2 - depth, cos(shift), sin(shift)])
      call tests%is_true(contact%events == 2, 'grazing: a dip between two samples has two events')
      half_width = acos(1 - depth)
      call tests%is_close(contact%instant(2) - contact%instant(1), 2*half_width, 1e-9_dp, 'grazing: length of the separation')
      call update_contact(contact, [2 + depth, cos(shift), sin(shift)])
      call tests%is_true(contact%events == 0, 'grazing: no event above the wall')
   end subroutine grazing

   !> p = 50 cos(theta): both walls are crossed between neighbouring samples, in the right order.
   subroutine crossing_both_walls(tests)
      class(tests_type), intent(inout) :: tests
      type(contact_type) :: contact
      type(law_type) :: law

      call put_law(mesh_type(order=1, stiffness=1.0_dp, half_backlash=1.0_dp), 1.0_dp, law)
      call law%complete(0.0_dp)
      call contact%setup(law, 1, [1], 3, 0)
      call update_contact(contact, [0.0_dp, 50*cos(0.05_dp), 50*sin(0.05_dp)])
      call tests%is_true(contact%events == 4, 'both walls: four events')
      call tests%is_true(all(contact%contact(:4) == [0, -1, 0, 1]), 'both walls: order of the contacts')
      call tests%is_close(contact%instant(1), 0.05_dp + acos(1/50.0_dp), 1e-13_dp, 'both walls: first instant')
   end subroutine crossing_both_walls

end module unit_contact
