!> Derivatives of the mesh forces of a balance, and of their derivatives by the coefficients, with respect to a parameter.
module geartrain_balance_force_rates
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_products, only: add_coefficients, toeplitz
   use geartrain_base_kinds, only: dp, pi
   use geartrain_linalg_trigonometric, only: evaluate
   use geartrain_mesh_law_law, only: law_type
   use geartrain_mesh_law_spectra, only: find_spectra, spectra_type
   use geartrain_model_system_rate, only: system_rate_type
   implicit none (type, external)
   private
   public :: along_frequency, force_rates, tangent_rates

contains

   !> Derivative of phi of each unknown mesh at constant coefficients. The force is continuous at the walls, so their motion adds
   !> nothing: what is left are the spectra of the derivatives of the rows of the law.
   subroutine force_rates(balance, rate, u, f, linear)
      !> The balance, evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> Derivatives of the system.
      type(system_rate_type), intent(in) :: rate
      !> Coefficients [1], (block, unknown).
      real(dp), intent(in) :: u(:, :)
      !> Derivative of phi, (block, unknown).
      real(dp), intent(out) :: f(:, :)
      !> Of what a change `u` of the coefficients adds to phi, without offset and impulse.
      logical, intent(in), optional :: linear
      logical :: whole
      integer :: i

      whole = .true.
      if (present(linear)) whole = .not. linear
      f = 0
      do i = 1, balance%unknowns
         associate (n => balance%system%cut%element(i))
            if (rate%law_changes(balance%mesh(i))) then
               call add_law(balance, rate, u, i, whole, f(:, i))
            else if (abs(rate%damping(n)) > 0) then
               call add_derivative(balance, rate%damping(n)*u(:, i), f(:, i))
            end if
         end associate
      end do
   end subroutine force_rates

   !> Adds the derivative of phi of an unknown mesh whose law changes.
   subroutine add_law(balance, rate, u, i, whole, f)
      type(balance_type), intent(in) :: balance
      type(system_rate_type), intent(in) :: rate
      real(dp), intent(in) :: u(:, :)
      !> Number of the unknown.
      integer, intent(in) :: i
      !> With offset and impulse.
      logical, intent(in) :: whole
      real(dp), intent(inout) :: f(:)
      type(spectra_type) :: spectra
      type(law_type) :: law
      real(dp) :: matrix(balance%block, balance%block), integral(balance%block)

      associate (contact => balance%contact(i), j => balance%mesh(i))
         integral = rate%damping(balance%system%cut%element(i))*u(:, i)
         law = rate%law(j)
         law%origin(:) = contact%law%origin
         call find(law)
         call toeplitz(balance%harmonic, spectra%stiffness, matrix)
         f = f + matmul(matrix, u(:, i))
         if (whole) call add_coefficients(balance%harmonic, -1.0_dp, spectra%offset, f)
         if (law%jumps) then
            call toeplitz(balance%harmonic, spectra%damping, matrix)
            integral = matmul(matrix, u(:, i))
            if (whole) call add_coefficients(balance%harmonic, 1.0_dp, spectra%impulse, integral)
         end if
         if (whole .and. any(abs(rate%law(j)%origin) > 0)) then
            law = contact%law
            law%origin(:) = rate%law(j)%origin
            call find(law)
            call add_coefficients(balance%harmonic, -1.0_dp, spectra%offset, f)
         end if
         call add_derivative(balance, integral, f)
      end associate

   contains

      subroutine find(law)
         type(law_type), intent(in) :: law

         associate (contact => balance%contact(i))
            call spectra%reserve(law, 2*balance%highest)
            call find_spectra(law, balance%eta, contact%first_contact, contact%instant(:contact%events), &
                              contact%contact(:contact%events), spectra)
         end associate
      end subroutine find

   end subroutine add_law

   !> Adds the time derivative of a periodic function.
   pure subroutine add_derivative(balance, integral, f)
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: integral(:)
      real(dp), intent(inout) :: f(:)
      real(dp) :: rate
      integer :: k

      do k = 1, size(balance%harmonic)
         rate = balance%harmonic(k)*balance%frequency_ratio/balance%eta
         f(2*k) = f(2*k) + rate*integral(2*k + 1)
         f(2*k + 1) = f(2*k + 1) - rate*integral(2*k)
      end do
   end subroutine add_derivative

   !> Derivative of (dS/du) x with respect to Lambda, the coefficients changing along.
   subroutine along_frequency(balance, u, d_u, x, force, s)
      !> The balance, evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> Coefficients, their derivative with respect to Lambda, and a change of them [1], with (d phi/du) x, (block, unknown).
      real(dp), intent(in) :: u(:, :), d_u(:, :), x(:, :), force(:, :)
      !> Derivative of (dS/du) x, (block, unknown).
      real(dp), intent(out) :: s(:, :)
      real(dp) :: f(balance%block, balance%unknowns), matrix(balance%block, balance%block), integral(balance%block)
      complex(dp) :: total
      integer :: i, k, n

      f = 0
      do i = 1, balance%unknowns
         integral = balance%damping_of(i)*x(:, i)
         if (balance%contact(i)%law%jumps) then
            call toeplitz(balance%harmonic, balance%contact(i)%spectra%damping, matrix)
            integral = matmul(matrix, x(:, i))
         end if
         call add_derivative(balance, integral/balance%frequency_ratio, f(:, i))
      end do
      call tangent_rates(balance, u, d_u, x, f)
      call balance%mean_product(f(1, :), 0*f(1, :), s(1, :))
      associate (graph => balance%system%cut%graph)
         do k = 1, size(balance%harmonic)
            do i = 1, balance%unknowns
               total = 0
               do n = graph%row(i), graph%row(i + 1) - 1
                  associate (j => graph%column(n), h => balance%receptance(k)%h(graph%entry(n)), &
                             dh => balance%receptance(k)%dh(graph%entry(n)))
                     total = total + dh*cmplx(force(2*k, j), -force(2*k + 1, j), dp) + h*cmplx(f(2*k, j), -f(2*k + 1, j), dp)
                  end associate
               end do
               s(2*k:2*k + 1, i) = [total%re, -total%im]
            end do
         end do
      end associate
   end subroutine along_frequency

   !> Adds to the derivative of (d phi/du) x what the motion of the contact events does: each moves by
   !> d theta = -(dp - d wall)/(dp/dtheta), and stiffness and damping jump there.
   subroutine tangent_rates(balance, u, d_u, x, f, rate)
      !> The balance, evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> Coefficients, their whole derivative, and a change of them [1], (block, unknown).
      real(dp), intent(in) :: u(:, :), d_u(:, :), x(:, :)
      !> Derivative of (d phi/du) x, (block, unknown).
      real(dp), intent(inout) :: f(:, :)
      !> Derivatives of the system, where walls move.
      type(system_rate_type), intent(in), optional :: rate
      real(dp) :: integral(balance%block), weight, shift, value, slope, unused
      integer :: i, m, before, after

      do i = 1, balance%unknowns
         associate (contact => balance%contact(i), law => balance%contact(i)%law, j => balance%mesh(i))
            integral = 0
            do m = 1, contact%events
               after = contact%contact(m)
               before = contact%first_contact
               if (m > 1) before = contact%contact(m - 1)
               associate (theta => contact%instant(m), phase => contact%instant(m)*balance%eta)
                  call evaluate(d_u(:, i), balance%harmonic, theta, shift, value, unused)
                  if (present(rate)) then
                     if (rate%law_changes(j)) shift = shift - rate%law(j)%wall(min(before, after))
                  end if
                  call evaluate(u(:, i), balance%harmonic, theta, value, slope, unused)
                  call evaluate(x(:, i), balance%harmonic, theta, value, weight, unused)
                  weight = -shift/slope*value/(2*pi)
                  call add_impulse(weight*(law%stiffness_at(before, phase) - law%stiffness_at(after, phase)), theta, f(:, i))
                  call add_impulse(weight*(law%damping(before) - law%damping(after)), theta, integral)
               end associate
            end do
            if (law%jumps) call add_derivative(balance, integral, f(:, i))
         end associate
      end do

   contains

      !> Adds the coefficients of 2 pi weight times the unit impulse at theta.
      pure subroutine add_impulse(weight, theta, f)
         real(dp), intent(in) :: weight, theta
         real(dp), intent(inout) :: f(:)
         integer :: k

         f(1) = f(1) + weight
         do k = 1, size(balance%harmonic)
            f(2*k) = f(2*k) + 2*weight*cos(balance%harmonic(k)*theta)
            f(2*k + 1) = f(2*k + 1) + 2*weight*sin(balance%harmonic(k)*theta)
         end do
      end subroutine add_impulse

   end subroutine tangent_rates

end module geartrain_balance_force_rates
