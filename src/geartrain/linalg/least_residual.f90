!> Least residual in a Krylov space, the part of GMRES that does not depend on what a vector is: Givens rotations keep the
!> Hessenberg matrix triangular, so that the residual is known before the solution.
!>
!> Source: Y. Saad, M. H. Schultz, SIAM Journal on Scientific and Statistical Computing 7 (1986) 856-869.
module geartrain_linalg_least_residual
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: least_residual_type

   type :: least_residual_type
      !> Number of vectors.
      integer :: count = 0
      real(dp), allocatable, private :: h(:, :), g(:), cosine(:), sine(:)
   contains
      procedure :: begin
      procedure :: add
      procedure :: weights
   end type least_residual_type

contains

   !> Begins with no vector.
   pure subroutine begin(self, most, length)
      class(least_residual_type), intent(inout) :: self
      !> Highest number of vectors.
      integer, intent(in) :: most
      !> Length of the right-hand side.
      real(dp), intent(in) :: length

      if (allocated(self%g)) then
         if (size(self%g) /= most + 1) deallocate (self%h, self%g, self%cosine, self%sine)
      end if
      if (.not. allocated(self%g)) allocate (self%h(most + 1, most), self%g(most + 1), self%cosine(most), self%sine(most))
      self%count = 0
      self%g = 0
      self%g(1) = length
   end subroutine begin

   !> Adds a vector.
   pure subroutine add(self, product, rest, residual)
      class(least_residual_type), intent(inout) :: self
      !> Products of the image of the vector with all vectors, (vector); length of what is orthogonal to them.
      real(dp), intent(in) :: product(:), rest
      !> Length of the least residual; -1 where the vector adds nothing.
      real(dp), intent(out) :: residual
      real(dp) :: held
      integer :: j, n

      n = self%count + 1
      associate (h => self%h, g => self%g)
         h(:n, n) = product
         h(n + 1, n) = rest
         do j = 1, n - 1
            held = self%cosine(j)*h(j, n) + self%sine(j)*h(j + 1, n)
            h(j + 1, n) = self%cosine(j)*h(j + 1, n) - self%sine(j)*h(j, n)
            h(j, n) = held
         end do
         held = hypot(h(n, n), h(n + 1, n))
         residual = -1
         if (.not. held > 0) return
         self%count = n
         self%cosine(n) = h(n, n)/held
         self%sine(n) = h(n + 1, n)/held
         h(n, n) = held
         g(n + 1) = -self%sine(n)*g(n)
         g(n) = self%cosine(n)*g(n)
         residual = abs(g(n + 1))
      end associate
   end subroutine add

   !> Weights of the vectors in the solution, (vector).
   pure function weights(self) result(g)
      class(least_residual_type), intent(in) :: self
      real(dp), allocatable :: g(:)
      integer :: i

      associate (n => self%count, h => self%h)
         g = self%g(:n)
         do i = n, 1, -1
            g(i) = (g(i) - dot_product(h(i, i + 1:n), g(i + 1:n)))/h(i, i)
         end do
      end associate
   end function weights

end module geartrain_linalg_least_residual
