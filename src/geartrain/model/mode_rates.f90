!> Derivatives of the natural frequencies: with a mode x of x . M x = 1, d omega^2 = x . (dK - omega^2 dM) x. Equal natural
!> frequencies have derivatives only where dK - omega^2 dM is alike in all of their modes.
module geartrain_model_mode_rates
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use geartrain_base_kinds, only: dp
   use geartrain_model_modes, only: stiffness_at_rest
   use geartrain_model_spectrum, only: eigenvalues_of
   use geartrain_model_system, only: system_type
   use geartrain_model_system_rate, only: system_rate_type
   implicit none (type, external)
   private
   public :: mode_shapes_type

   !> Relative difference of natural frequencies that count as equal, and of their derivatives.
   real(dp), parameter :: equal = 1e-9_dp, equal_rate = 1e-6_dp

   type :: mode_shapes_type
      !> Natural frequencies over omega_c [1], ascending, (mode).
      real(dp), allocatable :: frequency(:)
      !> Stiffness of each element at rest over its mean stiffness [1], (element).
      real(dp), allocatable, private :: factor(:)
      !> Displacement of each element, (element, mode), and reduced displacement of each node, (node, mode) [1/sqrt(kg)].
      real(dp), allocatable, private :: p(:, :), x(:, :)
   contains
      procedure :: setup
      procedure :: rates
   end type mode_shapes_type

contains

   !> Finds the modes.
   subroutine setup(self, system, info)
      class(mode_shapes_type), intent(inout) :: self
      !> The train.
      type(system_type), intent(in) :: system
      !> 0: LAPACK converged.
      integer, intent(out) :: info
      real(dp) :: root(system%elements), pull
      integer :: i, n

      allocate (self%frequency(system%displacements), self%p(system%elements, system%displacements))
      allocate (self%x(size(system%network%inertia), system%displacements), source=0.0_dp)
      self%factor = stiffness_at_rest(system)
      call eigenvalues_of(system, self%factor, self%frequency, info, self%p)
      if (info /= 0) return
      self%frequency = sqrt(max(self%frequency, 0.0_dp))
      root = sqrt(system%stiffness*self%factor)
      associate (network => system%network, omega => self%frequency*system%characteristic_frequency)
         do i = 1, size(omega)
            do n = 1, system%elements
               if (network%elements(n)%grounded) cycle
               ! The eigenvector is root*p/omega, and M x = B^T root*eigenvector/omega.
               associate (from => network%elements(n)%from, to => network%elements(n)%to)
                  pull = network%elements(n)%radius(1)/network%radius(from)*root(n)*self%p(n, i)/omega(i)
                  self%x(from, i) = self%x(from, i) + pull*network%radius(from)**2/network%inertia(from)
                  self%x(to, i) = self%x(to, i) - pull*network%radius(to)**2/network%inertia(to)
               end associate
            end do
            self%p(:, i) = self%p(:, i)*omega(i)/merge(root, 1.0_dp, root > 0)
         end do
      end associate
   end subroutine setup

   !> Finds the derivatives of the natural frequencies over omega_c; NaN where there is none.
   subroutine rates(self, system, rate, d_frequency)
      class(mode_shapes_type), intent(in) :: self
      !> The train.
      type(system_type), intent(in) :: system
      !> Derivatives of the system.
      type(system_rate_type), intent(in) :: rate
      !> Derivatives [1/unit of the parameter], (mode).
      real(dp), intent(out) :: d_frequency(:)
      real(dp) :: d_stiffness(system%elements), cross
      integer :: i, j, k

      associate (network => system%network, d => rate%network, omega => self%frequency*system%characteristic_frequency)
         d_stiffness = self%factor*(d%stiffness + 2*d%gain*system%stiffness)
         do j = 1, system%meshes
            if (.not. rate%law_changes(j)) cycle
            associate (n => system%mesh_element(j))
               d_stiffness(n) = d_stiffness(n) + system%stiffness(n) &
                                *rate%law(j)%stiffness(system%law(j)%bearing(system%static_force(n)))
            end associate
         end do
         do i = 1, size(omega)
            d_frequency(i) = along(i, i)
         end do
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

      !> (x_i . dK x_k - omega^2 x_i . dM x_k)/(2 omega) over omega_c.
      real(dp) function along(i, k)
         integer, intent(in) :: i, k

         associate (frequency => self%frequency(i)*system%characteristic_frequency)
            along = (sum(d_stiffness*self%p(:, i)*self%p(:, k)) - frequency**2*sum(rate%network%mass*self%x(:, i)*self%x(:, k))) &
                      /(2*frequency*system%characteristic_frequency)
         end associate
      end function along

   end subroutine rates

end module geartrain_model_mode_rates
