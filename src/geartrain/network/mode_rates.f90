!> Derivatives of the natural frequencies: with a mode x of x . M x = 1, d omega^2 = x . (dK - omega^2 dM) x. Equal natural
!> frequencies have derivatives only where dK - omega^2 dM is alike in all of their modes.
module geartrain_network_mode_rates
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use geartrain_base_kinds, only: dp
   use geartrain_network_natural_modes, only: stiffness_at_rest
   use geartrain_network_system, only: system_type
   use geartrain_network_system_spectrum, only: eigenvalues_of
   implicit none (type, external)
   private
   public :: mode_shapes_type

   !> Relative difference of natural frequencies that count as equal, and of their derivatives.
   real(dp), parameter :: equal = 1e-9_dp, equal_rate = 1e-6_dp

   type :: mode_shapes_type
      !> Natural frequencies over omega_c [1], ascending, (mode).
      real(dp), allocatable :: frequency(:)
      !> Displacement of each element [m/sqrt(kg m^2)], (element, mode), and rotation of each node [rad/sqrt(kg m^2)], (node, mode).
      real(dp), allocatable, private :: p(:, :), theta(:, :)
   contains
      procedure :: setup
      procedure :: rates
   end type mode_shapes_type

contains

   !> Finds the modes.
   subroutine setup(self, system, info)
      class(mode_shapes_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> 0: LAPACK converged.
      integer, intent(out) :: info
      real(dp) :: root(system%elements), omega
      integer :: i, n

      allocate (self%frequency(system%displacements), self%p(system%elements, system%displacements))
      allocate (self%theta(size(system%network%inertia), system%displacements), source=0.0_dp)
      root = sqrt(system%stiffness*stiffness_at_rest(system))
      call eigenvalues_of(system, stiffness_at_rest(system), self%frequency, info, self%p)
      if (info /= 0) return
      self%frequency = sqrt(max(self%frequency, 0.0_dp))
      associate (network => system%network)
         do i = 1, size(self%frequency)
            ! The eigenvector is root*p/omega, and I theta = B^T root*eigenvector/omega.
            omega = self%frequency(i)*system%characteristic_frequency
            do n = 1, system%elements
               associate (element => network%elements(n))
                  self%theta(element%node, i) = self%theta(element%node, i) + element%entry*(root(n)*self%p(n, i)/omega)
               end associate
            end do
            self%theta(:, i) = self%theta(:, i)/network%inertia
            self%p(:, i) = self%p(:, i)*omega/merge(root, 1.0_dp, root > 0)
         end do
      end associate
   end subroutine setup

   !> Finds the derivatives of the natural frequencies over omega_c; NaN where there is none.
   subroutine rates(self, system, sides, weight, d_frequency)
      class(mode_shapes_type), intent(in) :: self
      !> The train; trains beside it, of which the derivative is a sum with weights.
      type(system_type), intent(in) :: system, sides(:)
      !> The weights [1/unit of the parameter], (side).
      real(dp), intent(in) :: weight(:)
      !> Derivatives [1/unit of the parameter], (mode).
      real(dp), intent(out) :: d_frequency(:)
      !> Displacement of each element, which is exact where rows do not change, (element, mode, side); stiffness at rest [N/m],
      !> (element, side).
      real(dp) :: p(size(self%p, 1), size(self%p, 2), size(sides)), stiffness(size(self%p, 1), size(sides)), cross
      integer :: i, k, n, s

      do s = 1, size(sides)
         stiffness(:, s) = sides(s)%stiffness*stiffness_at_rest(sides(s))
         do n = 1, system%elements
            associate (element => system%network%elements(n))
               p(n, :, s) = self%p(n, :) + matmul(sides(s)%network%elements(n)%entry - element%entry, self%theta(element%node, :))
            end associate
         end do
      end do
      do i = 1, size(self%frequency)
         d_frequency(i) = along(i, i)
      end do
      associate (omega => self%frequency)
         do i = 1, size(omega)
            do k = i + 1, size(omega)
               if (omega(k) - omega(i) > equal*omega(k)) cycle
               cross = maxval(abs([along(i, i), along(k, k)]))
               if (abs(along(i, k)) > equal_rate*cross .or. abs(along(i, i) - along(k, k)) > equal_rate*cross) &
                  d_frequency([i, k]) = ieee_value(cross, ieee_quiet_nan)
            end do
         end do
      end associate

   contains

      !> (theta_i . dK theta_k - omega^2 theta_i . dI theta_k)/(2 omega) over omega_c.
      real(dp) function along(i, k)
         integer, intent(in) :: i, k

         associate (omega => self%frequency(i)*system%characteristic_frequency)
            along = 0
            do s = 1, size(sides)
               along = along + weight(s)*sum(stiffness(:, s)*p(:, i, s)*p(:, k, s) &
                                             - stiffness(:, 1)*p(:, i, 1)*p(:, k, 1)) &
                       - weight(s)*omega**2*sum((sides(s)%network%inertia - sides(1)%network%inertia) &
                                                *self%theta(:, i)*self%theta(:, k))
            end do
            along = along/(2*omega*system%characteristic_frequency)
         end associate
      end function along

   end subroutine rates

end module geartrain_network_mode_rates
