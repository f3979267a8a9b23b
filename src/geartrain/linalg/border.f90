!> A square matrix plus a multiple of the identity, bordered by a column and a row: regular where the matrix itself is singular.
module geartrain_linalg_border
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
   implicit none (type, external)
   private
   public :: border_type

   type :: border_type
      !> Borders: column and row, (row).
      real(dp), allocatable :: column(:), row(:)
      !> Null vectors, right and left, (row), whose products with row and column are 1; the last unknown, 0 where the matrix is
      !> singular.
      real(dp), allocatable :: right(:), left(:)
      real(dp) :: value = 0
      !> Product of the null vectors over their lengths, 0 where the eigenvalue 0 is double.
      real(dp) :: product = 0
   contains
      procedure :: begin
      procedure :: fill
      procedure :: find
      procedure :: renew
   end type border_type

contains

   !> Takes borders without any symmetry, so that they are orthogonal to no null vector.
   pure subroutine begin(self, n)
      class(border_type), intent(inout) :: self
      !> Rows of the matrix.
      integer, intent(in) :: n
      integer :: i

      ! Fractions of multiples of irrational numbers spread evenly.
      self%column = [(modulo(i*0.6180339887498949_dp, 1.0_dp) - 0.5_dp, i=1, n)]
      self%row = [(modulo(i*0.4142135623730951_dp, 1.0_dp) - 0.5_dp, i=1, n)]
   end subroutine begin

   !> Makes the bordered matrix.
   pure subroutine fill(self, a, shift, matrix)
      class(border_type), intent(in) :: self
      !> The matrix, and the multiple of the identity that is added.
      real(dp), intent(in) :: a(:, :), shift
      !> With a row and a column more.
      real(dp), intent(out) :: matrix(:, :)
      integer :: k, n

      n = size(a, 1)
      matrix(:n, :n) = a
      do k = 1, n
         matrix(k, k) = matrix(k, k) + shift
      end do
      matrix(:n, n + 1) = self%column
      matrix(n + 1, :n) = self%row
      matrix(n + 1, n + 1) = 0
   end subroutine fill

   !> Finds the null vectors and the last unknown.
   pure subroutine find(self, a, shift, info)
      class(border_type), intent(inout) :: self
      !> The matrix, and the multiple of the identity that is added.
      real(dp), intent(in) :: a(:, :), shift
      !> 0: found; else the bordered matrix is singular.
      integer, intent(out) :: info
      real(dp), dimension(size(a, 1) + 1, size(a, 1) + 1) :: matrix, adjoint
      real(dp) :: x(size(a, 1) + 1)
      integer :: pivot(size(a, 1) + 1), n

      n = size(a, 1)
      call self%fill(a, shift, matrix)
      adjoint = transpose(matrix)
      x = 0
      x(n + 1) = 1
      call factor_matrix(n + 1, matrix, pivot, info)
      if (info /= 0) return
      call solve_factored(n + 1, 1, matrix, pivot, x)
      self%right = x(:n)
      self%value = x(n + 1)
      x = 0
      x(n + 1) = 1
      call factor_matrix(n + 1, adjoint, pivot, info)
      if (info /= 0) return
      call solve_factored(n + 1, 1, adjoint, pivot, x)
      self%left = x(:n)
   end subroutine find

   !> Takes the null vectors as the next borders.
   pure subroutine renew(self)
      class(border_type), intent(inout) :: self

      self%row = self%right/norm2(self%right)
      self%column = self%left/norm2(self%left)
      self%product = dot_product(self%row, self%column)
   end subroutine renew

end module geartrain_linalg_border
