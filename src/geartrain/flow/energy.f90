!> Energy of a vibration of the mean train (every mesh in contact, at its mean stiffness) as a norm of states. Free vibration
!> without damping keeps the energy, while the Euclidean norm oscillates between displacements and velocities. Elements that close
!> loops are left out, which leaves a norm.
module geartrain_flow_energy
   use geartrain_base_kinds, only: dp
   use geartrain_model_system, only: system_type
   implicit none (type, external)
   private
   public :: energy_type

   !> Transforms states into energy coordinates, whose sum of squares is twice the energy over the largest stiffness of the train.
   type :: energy_type
      !> Elastic elements that do not close loops.
      integer, private :: elements = 0
      !> Root of the stiffness of each element over the largest, (element).
      real(dp), allocatable, private :: root(:)
      !> Cholesky factor of the inverse inertia of the elements: velocities = factor*coordinates, (element, element); first column
      !> that is not 0 in each row, (element): next to the diagonal on a chain.
      real(dp), allocatable, private :: factor(:, :)
      integer, allocatable, private :: first(:)
   contains
      procedure :: setup
      procedure :: coordinates
      procedure :: state
      procedure :: transform
   end type energy_type

contains

   !> Factors the inverse inertia of a train.
   pure subroutine setup(self, system)
      class(energy_type), intent(inout) :: self
      !> The train.
      type(system_type), intent(in) :: system
      real(dp) :: stiffness(system%coordinates)
      integer :: i, n, m

      self%elements = system%coordinates
      stiffness = system%stiffness(:system%coordinates)/maxval(system%stiffness)
      self%root = sqrt(stiffness)
      if (allocated(self%factor)) deallocate (self%factor, self%first)
      allocate (self%factor(system%coordinates, system%coordinates), source=0.0_dp)
      allocate (self%first(system%coordinates))
      ! p'' = -C K p: C is W over the stiffness, symmetric.
      do n = 1, system%coordinates
         self%first(n) = n
         self%factor(n, n) = system%own(n)/stiffness(n)
         do i = system%first(n), system%first(n + 1) - 1
            m = system%neighbour(i)
            if (m > n) cycle
            self%first(n) = min(self%first(n), m)
            self%factor(n, m) = system%coupling(i)/stiffness(m)
         end do
         associate (l => self%factor)
            do m = self%first(n), n - 1
               i = max(self%first(n), self%first(m))
               l(n, m) = (l(n, m) - dot_product(l(n, i:m - 1), l(m, i:m - 1)))/l(m, m)
            end do
            l(n, n) = sqrt(max(l(n, n) - sum(l(n, self%first(n):n - 1)**2), tiny(1.0_dp)))
         end associate
      end do
   end subroutine setup

   !> Energy coordinates of a difference of two states, (2*coordinates).
   pure function coordinates(self, difference) result(y)
      class(energy_type), intent(in) :: self
      !> State, or difference of states [1], (2*elements).
      real(dp), intent(in) :: difference(:)
      real(dp) :: y(size(difference))
      integer :: n

      associate (e => self%elements, l => self%factor)
         y(:e) = self%root*difference(:e)
         do n = 1, e
            associate (i => self%first(n))
               y(e + n) = (difference(e + n) - dot_product(l(n, i:n - 1), y(e + i:e + n - 1)))/l(n, n)
            end associate
         end do
      end associate
   end function coordinates

   !> The state [1], (2*elements), of energy coordinates: the inverse of `coordinates`.
   pure function state(self, y) result(difference)
      class(energy_type), intent(in) :: self
      !> Energy coordinates, (2*elements).
      real(dp), intent(in) :: y(:)
      real(dp) :: difference(size(y))
      integer :: n

      associate (e => self%elements, l => self%factor)
         difference(:e) = y(:e)/self%root
         do n = 1, e
            associate (i => self%first(n))
               difference(e + n) = dot_product(l(n, i:n), y(e + i:e + n))
            end associate
         end do
      end associate
   end function state

   !> A linear map of states, transformed to energy coordinates.
   pure function transform(self, map) result(transformed)
      class(energy_type), intent(in) :: self
      !> Matrix of the map of states, (2*elements, 2*elements).
      real(dp), intent(in) :: map(:, :)
      real(dp) :: transformed(size(map, 1), size(map, 2)), unit(size(map, 1))
      integer :: i

      do i = 1, size(map, 2)
         unit = 0
         unit(i) = 1
         transformed(:, i) = self%coordinates(matmul(map, self%state(unit)))
      end do
   end function transform

end module geartrain_flow_energy
