!> Energy that couplings lose to damping, of a motion of the harmonic balance.
module geartrain_balance_coupling_loss
   use geartrain_balance_balance, only: balance_type
   use geartrain_base_kinds, only: dp, pi
   implicit none (type, external)
   private
   public :: find_coupling_losses

contains

   !> Finds the energy that each coupling loses in a period of the fundamental [J], (coupling): the integral of its torque over its
   !> twist, in which the elastic torque has no part. Both have finitely many harmonics in common, so the sum is exact.
   pure subroutine find_coupling_losses(balance, coefficients, loss)
      !> The balance, last evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> Coefficients of the displacements over b_c [1], (block, mesh).
      real(dp), intent(in) :: coefficients(:, :)
      !> The losses.
      real(dp), intent(out) :: loss(:)
      integer :: first, i, j, k, n

      associate (system => balance%system)
         first = system%torque_paths%pairs
         do i = 1, size(loss)
            j = first + i
            n = findloc(balance%mesh, j, 1)
            loss(i) = 0
            do k = 1, size(balance%harmonic)
               associate (r => real(balance%harmonic(k), dp), a => coefficients(2*k, j), b => coefficients(2*k + 1, j))
                  if (n > 0) then
                     loss(i) = loss(i) + r*(balance%force(2*k, n)*b - balance%force(2*k + 1, n)*a)
                  else
                     loss(i) = loss(i) + system%damping(system%mesh_element(j))*balance%frequency_ratio/balance%eta*r**2 &
                               *(a**2 + b**2)
                  end if
               end associate
            end do
            loss(i) = pi/balance%eta*system%energy_unit(j)*loss(i)
         end do
      end associate
   end subroutine find_coupling_losses

end module geartrain_balance_coupling_loss
