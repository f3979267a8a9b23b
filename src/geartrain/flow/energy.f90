!> Energy of a vibration of the mean train (every mesh in contact, at its mean stiffness) as a norm of states. Free vibration
!> without damping keeps the energy, while the Euclidean norm oscillates between displacements and velocities.
module geartrain_flow_energy
   use geartrain_base_kinds, only: dp
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: energy_type

   !> Transforms states into energy coordinates, whose sum of squares is twice the energy over the largest stiffness of the train.
   type :: energy_type
      !> Displacements of a state.
      integer, private :: displacements = 0
      !> Cholesky factor of the stiffness over the largest: its transpose makes coordinates of displacements, (displacement,
      !> displacement); diagonal but for loops.
      real(dp), allocatable, private :: root(:, :)
      !> Cholesky factor of the inverse inertia of the elements: velocities = factor*coordinates, (velocity, velocity), and the
      !> first column of each row that is not 0: next to the diagonal on a chain.
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
      type(system_type), intent(in) :: system
      real(dp) :: stiffness(system%elements)
      integer :: i, n, m

      stiffness = system%stiffness/maxval(system%stiffness)
      self%displacements = system%displacements
      associate (d => system%displacements, c => system%coordinates)
         self%root = matmul(transpose(system%network%loop(:, :d)), &
                            spread(stiffness(c + 1:)*system%spring(c + 1:), 2, d)*system%network%loop(:, :d))
         do n = 1, d
            self%root(n, n) = self%root(n, n) + stiffness(n)
         end do
         do n = 1, d
            do m = 1, n - 1
               self%root(n, m) = (self%root(n, m) - dot_product(self%root(n, :m - 1), self%root(m, :m - 1)))/self%root(m, m)
            end do
            self%root(n, n) = sqrt(max(self%root(n, n) - sum(self%root(n, :n - 1)**2), tiny(1.0_dp)))
            self%root(n, n + 1:) = 0
         end do
      end associate
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

   !> Energy coordinates of a difference of two states, (state).
   pure function coordinates(self, difference) result(y)
      class(energy_type), intent(in) :: self
      !> State, or difference of states [1], (state).
      real(dp), intent(in) :: difference(:)
      real(dp) :: y(size(difference))
      integer :: n

      associate (d => self%displacements, l => self%factor, root => self%root)
         do n = 1, d
            y(n) = dot_product(root(n:, n), difference(n:d))
         end do
         do n = 1, size(l, 1)
            associate (i => self%first(n))
               y(d + n) = (difference(d + n) - dot_product(l(n, i:n - 1), y(d + i:d + n - 1)))/l(n, n)
            end associate
         end do
      end associate
   end function coordinates

   !> The state [1], (state), of energy coordinates: the inverse of `coordinates`.
   pure function state(self, y) result(difference)
      class(energy_type), intent(in) :: self
      !> Energy coordinates, (state).
      real(dp), intent(in) :: y(:)
      real(dp) :: difference(size(y))
      integer :: n

      associate (d => self%displacements, l => self%factor, root => self%root)
         do n = d, 1, -1
            difference(n) = (y(n) - dot_product(root(n + 1:, n), difference(n + 1:d)))/root(n, n)
         end do
         do n = 1, size(l, 1)
            associate (i => self%first(n))
               difference(d + n) = dot_product(l(n, i:n), y(d + i:d + n))
            end associate
         end do
      end associate
   end function state

   !> A linear map of states, transformed to energy coordinates.
   pure function transform(self, map) result(transformed)
      class(energy_type), intent(in) :: self
      !> Matrix of the map of states, (state, state).
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
