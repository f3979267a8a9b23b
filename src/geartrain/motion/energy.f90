!> The energy of a vibration of the mean train (every mesh in contact, at its mean stiffness) as a norm of states: free vibration
!> without damping keeps it, where a plain norm swings between displacements and velocities.
module geartrain_motion_energy
   use geartrain_base_kinds, only: dp
   use geartrain_model_system, only: system_type
   implicit none (type, external)
   private
   public :: energy_type

   !> Coordinates whose sum of squares is twice the energy over the largest stiffness of the train.
   type :: energy_type
      !> Elastic elements.
      integer, private :: elements = 0
      !> Root of the stiffness of each element over the largest, (element).
      real(dp), allocatable, private :: root(:)
      !> Cholesky factor of the inverse inertia of the elements, bidiagonal: velocities = factor*coordinates, (element).
      real(dp), allocatable, private :: diagonal(:), below(:)
   contains
      procedure :: setup
      procedure :: coordinates
      procedure :: state
      procedure :: transform
   end type energy_type

contains

   pure subroutine setup(self, system)
      class(energy_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      real(dp) :: stiffness(system%elements)
      integer :: n

      self%elements = system%elements
      stiffness = system%stiffness/maxval(system%stiffness)
      self%root = sqrt(stiffness)
      if (allocated(self%diagonal)) deallocate (self%diagonal, self%below)
      allocate (self%diagonal(system%elements), self%below(system%elements), source=0.0_dp)
      ! p'' = -C K p: C is the coupling over the stiffness, symmetric, between neighbours only.
      do n = 1, system%elements
         if (n > 1) self%below(n) = system%coupling(1, n)/stiffness(n - 1)/self%diagonal(n - 1)
         self%diagonal(n) = sqrt(max(system%coupling(2, n)/stiffness(n) - self%below(n)**2, tiny(1.0_dp)))
      end do
   end subroutine setup

   !> Energy coordinates of a difference of two states, (2*elements).
   pure function coordinates(self, difference) result(y)
      class(energy_type), intent(in) :: self
      real(dp), intent(in) :: difference(:)
      real(dp) :: y(size(difference))
      integer :: n

      associate (e => self%elements)
         y(:e) = self%root*difference(:e)
         do n = 1, e
            y(e + n) = difference(e + n)
            if (n > 1) y(e + n) = y(e + n) - self%below(n)*y(e + n - 1)
            y(e + n) = y(e + n)/self%diagonal(n)
         end do
      end associate
   end function coordinates

   !> The inverse of `coordinates`.
   pure function state(self, y) result(difference)
      class(energy_type), intent(in) :: self
      real(dp), intent(in) :: y(:)
      real(dp) :: difference(size(y))

      associate (e => self%elements)
         difference(:e) = y(:e)/self%root
         difference(e + 1:) = self%diagonal*y(e + 1:) + self%below*eoshift(y(e + 1:), -1)
      end associate
   end function state

   !> A linear map of states in energy coordinates.
   pure function transform(self, map) result(transformed)
      class(energy_type), intent(in) :: self
      real(dp), intent(in) :: map(:, :)
      real(dp) :: transformed(size(map, 1), size(map, 2)), unit(size(map, 1))
      integer :: i

      do i = 1, size(map, 2)
         unit = 0
         unit(i) = 1
         transformed(:, i) = self%coordinates(matmul(map, self%state(unit)))
      end do
   end function transform

end module geartrain_motion_energy
