!> Derivatives of the mesh forces of a balance, and of their derivatives by the coefficients, with respect to a parameter.
module geartrain_balance_force_rates
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_products, only: add_coefficients, toeplitz
   use geartrain_base_kinds, only: dp
   use geartrain_mesh_law_law, only: law_type
   use geartrain_mesh_law_spectra, only: find_spectra, spectra_type
   use geartrain_model_system_rate, only: system_rate_type
   implicit none (type, external)
   private
   public :: force_rates

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

end module geartrain_balance_force_rates
