!> The lowest natural modes of a linear train of any size, by block Lanczos with the inverse of its stiffness matrix. On a tree each
!> product costs the number of nodes. The eigenvalues are counted beside (`system_spectrum.f90`): no mode is missed, however often
!> its frequency is there.
module geartrain_network_lowest_modes
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_band_eigenvalues, only: band_eigenvalues
   use geartrain_linalg_graph, only: factor_scalars, solve_scalars
   use geartrain_linalg_lapack, only: dgemm
   use geartrain_network_system, only: system_type
   use geartrain_network_system_spectrum, only: count_above, make_pencil, pencil_type
   implicit none (type, external)
   private
   public :: lowest_modes_type

   !> Vectors of a block, an even number: a frequency is found as often as it is there, up to so many times.
   integer, parameter :: block = 12
   !> Dimensions of the space over the number of modes, and beside it, at which a search is given up.
   integer, parameter :: most_share = 6, most_beside = 120
   !> The projection is solved at first at the dimension `first_look` number + 2 `looks` block, then every `looks` blocks: each
   !> costs as much as some blocks.
   integer, parameter :: first_look = 2, looks = 2
   !> Residual of a mode, relative to its eigenvalue, at which the mode is found: the error of the frequency is its square.
   real(dp), parameter :: tolerance = 1e-4_dp
   !> Shift over the lowest eigenvalue, which makes the stiffness matrix regular.
   real(dp), parameter :: shift = 0.25_dp

   type :: lowest_modes_type
      !> Stiffness and inertia of the train.
      type(pencil_type) :: pencil
      !> Natural frequencies over the characteristic frequency [1], ascending, (mode).
      real(dp), allocatable :: frequency(:)
      !> Displacements of the elements per sqrt(kg m^2) in modes of unit modal mass [m], (element, mode).
      real(dp), allocatable :: shape(:, :)
   contains
      procedure :: begin
      procedure :: below
      procedure :: find
   end type lowest_modes_type

contains

   !> Takes a train; no modes are known.
   pure subroutine begin(self, system, factor)
      class(lowest_modes_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Stiffness of each element over its mean stiffness, > 0 [1], (element).
      real(dp), intent(in) :: factor(:)
      type(pencil_type) :: pencil

      call make_pencil(system, factor, pencil)
      self%pencil = pencil
      self%frequency = [real(dp) ::]
      self%shape = reshape([real(dp) ::], [system%elements, 0])
   end subroutine begin

   !> Number of natural frequencies up to a frequency.
   pure integer function below(self, frequency)
      class(lowest_modes_type), intent(in) :: self
      !> The frequency over the characteristic frequency [1].
      real(dp), intent(in) :: frequency

      below = size(self%pencil%inertia) - 1 - count_above(self%pencil, max(frequency**2, self%pencil%lowest))
   end function below

   !> Finds the lowest modes. No success: they do not converge.
   subroutine find(self, system, number, success)
      class(lowest_modes_type), intent(inout) :: self
      !> The train that was begun with.
      type(system_type), intent(in) :: system
      !> Number of modes, fewer than there are.
      integer, intent(in) :: number
      !> The modes were found.
      logical, intent(out) :: success
      complex(dp) :: factors(self%pencil%graph%entries)
      real(dp), allocatable :: basis(:, :), projected(:, :), value(:), vector(:, :), theta(:, :)
      real(dp) :: root(size(self%pencil%inertia)), moved
      integer :: i, look, m, most, n

      n = size(root)
      root = sqrt(self%pencil%inertia)
      most = min(block*((most_share*number + most_beside)/block), block*((n - 1)/block - 1))
      success = .false.
      if (most < number + block .or. size(system%network%rigid, 2) /= 1) return
      moved = shift*lowest_eigenvalue(self)
      associate (graph => self%pencil%graph, k => self%pencil%stiffness)
         associate (upper => graph%nodes, lower => graph%nodes + graph%slots)
            factors = k
            factors(lower + 1:) = k(upper + 1:lower)
            factors(:upper) = factors(:upper) + moved*self%pencil%inertia
            call factor_scalars(graph, factors)
         end associate
      end associate
      ! The first vector is the turning of the whole train, to which all others are orthogonal.
      allocate (basis(n, 0:most + block), projected(most + block, most + block))
      projected = 0
      basis(:, 0) = root*system%network%rigid(:, 1)
      basis(:, 0) = basis(:, 0)/norm2(basis(:, 0))
      do m = 1, block
         basis(:, m) = [(modulo(real(i, dp)*(sqrt(2.0_dp) + m)*sqrt(3.0_dp)*(i + 7*m), 1.0_dp) - 0.5_dp, i=1, n)]
      end do
      call orthonormalise(basis, projected, 0)
      look = min(most, first_look*number + 2*looks*block)
      m = 0
      do while (m < most)
         do i = m + 1, m + block, 2
            call multiply(self%pencil, factors, root, basis(:, i:i + 1), basis(:, block + i:block + i + 1))
         end do
         m = m + block
         call orthonormalise(basis, projected, m)
         if (m < look) cycle
         call solve_projected()
         if (success) exit
         look = m + looks*block
      end do
      if (.not. success) return
      ! As many frequencies as there are below the last one.
      self%frequency = sqrt(max(0.0_dp, 1/value(m:m - number + 1:-1) - moved))
      success = self%below(self%frequency(number)*(1 + 1e-6_dp)) >= number .and. &
                self%below(self%frequency(number)*(1 - 1e-6_dp)) < number
      allocate (theta(n, number))
      call dgemm('N', 'N', n, number, m, 1.0_dp, basis(:, 1:), n, vector(:, m - number + 1:), m, 0.0_dp, theta, n)
      theta = theta(:, number:1:-1)/spread(root, 2, number)
      deallocate (self%shape)
      allocate (self%shape(system%elements, number))
      do i = 1, system%elements
         associate (element => system%network%elements(i))
            self%shape(i, :) = matmul(element%entry, theta(element%node, :))
         end associate
      end do

   contains

      !> Eigenvalues of the projection, which has 2 block - 1 diagonals beside the main diagonal.
      subroutine solve_projected()
         integer, parameter :: width = 2*block - 1
         real(dp) :: band(width + 1, m)
         integer :: info, j, l

         band = 0
         do j = 1, m
            do l = max(1, j - width), j
               band(width + 1 - j + l, j) = (projected(l, j) + projected(j, l))/2
            end do
         end do
         if (allocated(value)) deallocate (value, vector)
         allocate (value(m), vector(m, m))
         call band_eigenvalues(band, value, info, vector)
         success = info == 0
         do j = m, m - number + 1, -1
            success = success .and. norm2(matmul(projected(m + 1:m + block, m - block + 1:m), vector(m - block + 1:, j))) &
                      <= tolerance*value(j)
         end do
      end subroutine solve_projected
   end subroutine find

   !> The lowest eigenvalue to a factor of two.
   pure real(dp) function lowest_eigenvalue(modes) result(above)
      type(lowest_modes_type), intent(in) :: modes
      real(dp) :: middle, place
      integer :: all

      all = count_above(modes%pencil, modes%pencil%lowest)
      place = modes%pencil%lowest
      above = modes%pencil%highest
      do while (above > 2*place)
         middle = sqrt(place)*sqrt(above)
         if (count_above(modes%pencil, middle) == all) then
            place = middle
         else
            above = middle
         end if
      end do
   end function lowest_eigenvalue

   !> Multiplies a pair of vectors by the inverse, as one complex vector.
   pure subroutine multiply(pencil, factors, root, vectors, products)
      type(pencil_type), intent(in) :: pencil
      complex(dp), intent(in), contiguous :: factors(:)
      real(dp), intent(in) :: root(:), vectors(:, :)
      real(dp), intent(out) :: products(:, :)
      complex(dp) :: x(size(root))

      x = cmplx(root*vectors(:, 1), root*vectors(:, 2), dp)
      call solve_scalars(pencil%graph, factors, x)
      products(:, 1) = root*x%re
      products(:, 2) = root*x%im
   end subroutine multiply

   !> Makes the block after vector m orthonormal to all vectors before it, twice, which is enough; products go into the projection.
   subroutine orthonormalise(basis, projected, m)
      real(dp), intent(inout), contiguous :: basis(:, 0:), projected(:, :)
      integer, intent(in) :: m
      real(dp) :: factor(0:m, block), length
      integer :: j, k, n, turn

      n = size(basis, 1)
      do turn = 1, 2
         call dgemm('T', 'N', m + 1, block, n, 1.0_dp, basis, n, basis(:, m + 1:), n, 0.0_dp, factor, m + 1)
         call dgemm('N', 'N', n, block, m + 1, -1.0_dp, basis, n, factor, m + 1, 1.0_dp, basis(:, m + 1:), n)
         if (m > 0 .and. turn == 1) projected(:m, m - block + 1:m) = factor(1:, :)
         do k = m + 1, m + block
            do j = m + 1, k - 1
               length = dot_product(basis(:, j), basis(:, k))
               basis(:, k) = basis(:, k) - length*basis(:, j)
               if (m > 0 .and. turn == 1) projected(j, k - block) = projected(j, k - block) + length
            end do
            length = norm2(basis(:, k))
            basis(:, k) = basis(:, k)/max(length, tiny(length))
            if (m > 0 .and. turn == 1) projected(k, k - block) = length
         end do
      end do
   end subroutine orthonormalise

end module geartrain_network_lowest_modes
