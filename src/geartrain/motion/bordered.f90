!> A block-tridiagonal matrix with one border row and column: factors and solves, cost linear in the number of blocks.
!> The border closes the last block, so the whole stays regular at folds, where the matrix without it is singular.
module geartrain_motion_bordered
   use geartrain_base_elimination, only: factor_matrix, solve_factored
   use geartrain_base_interrupt, only: interrupt_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_lapack, only: dgemm, dgemv
   implicit none (type, external)
   private
   public :: bordered_type

   type :: bordered_type
      integer :: block = 0, blocks = 0
      !> Fill these before `factor`, which overwrites them: (block, block, blocks), lower(:, :, j) multiplies unknowns j-1.
      real(dp), allocatable :: lower(:, :, :), diagonal(:, :, :), upper(:, :, :)
      !> Border column and row, (block, blocks), and their corner.
      real(dp), allocatable :: column(:, :), row(:, :)
      real(dp) :: corner = 0
      !> Sign of the determinant, set by `factor`: constant along a smooth branch that keeps its sense.
      integer :: orientation = 1
      !> Looked at between the blocks.
      type(interrupt_type) :: interrupt
      real(dp), allocatable, private :: last(:, :), joint(:)
      integer, allocatable, private :: pivot(:, :), last_pivot(:)
   contains
      procedure :: resize
      procedure :: factor
      procedure :: solve
   end type bordered_type

contains

   subroutine resize(self, block, blocks)
      class(bordered_type), intent(inout) :: self
      integer, intent(in) :: block, blocks

      if (self%block == block .and. self%blocks == blocks) return
      if (allocated(self%lower)) deallocate (self%lower, self%diagonal, self%upper, self%column, self%row, self%last, &
                                             self%joint, self%pivot, self%last_pivot)
      self%block = block
      self%blocks = blocks
      allocate (self%lower(block, block, blocks), self%diagonal(block, block, blocks), self%upper(block, block, blocks), &
                self%column(block, blocks), self%row(block, blocks), self%last(block + 1, block + 1), &
                self%joint(block + 1), self%pivot(block, blocks), self%last_pivot(block + 1))
   end subroutine resize

   !> Block elimination downwards; afterwards `upper` and `column` hold D^-1 U and D^-1 g. info = 0 when regular, which it is not
   !> where it is interrupted.
   subroutine factor(self, info)
      class(bordered_type), intent(inout) :: self
      integer, intent(out) :: info
      integer :: j, n

      n = self%block
      info = 0
      self%orientation = 1
      if (self%blocks == 0) return
      do j = 1, self%blocks - 1
         info = 1
         if (self%interrupt%raised()) return
         associate (d => self%diagonal(:, :, j), pivot => self%pivot(:, j))
            call factor_matrix(n, d, pivot, info)
            if (info /= 0) return
            self%orientation = self%orientation*determinant_sign(d, pivot)
            call solve_factored(n, n, d, pivot, self%upper(:, :, j))
            call solve_factored(n, 1, d, pivot, self%column(:, j))
         end associate
         call dgemm('N', 'N', n, n, n, -1.0_dp, self%lower(:, :, j + 1), n, self%upper(:, :, j), n, 1.0_dp, &
                    self%diagonal(:, :, j + 1), n)
         call dgemv('N', n, n, -1.0_dp, self%lower(:, :, j + 1), n, self%column(:, j), 1, 1.0_dp, self%column(:, j + 1), 1)
         call dgemv('T', n, n, -1.0_dp, self%upper(:, :, j), n, self%row(:, j), 1, 1.0_dp, self%row(:, j + 1), 1)
         self%corner = self%corner - dot_product(self%row(:, j), self%column(:, j))
      end do
      j = self%blocks
      self%last(:n, :n) = self%diagonal(:, :, j)
      self%last(:n, n + 1) = self%column(:, j)
      self%last(n + 1, :n) = self%row(:, j)
      self%last(n + 1, n + 1) = self%corner
      call factor_matrix(n + 1, self%last, self%last_pivot, info)
      self%orientation = self%orientation*determinant_sign(self%last, self%last_pivot)
   end subroutine factor

   !> Sign of the determinant of a matrix factored by `factor_matrix`.
   pure integer function determinant_sign(a, pivot)
      real(dp), intent(in) :: a(:, :)
      integer, intent(in) :: pivot(:)
      integer :: i

      determinant_sign = 1
      do i = 1, size(pivot)
         if ((pivot(i) /= i) .neqv. (a(i, i) < 0)) determinant_sign = -determinant_sign
      end do
   end function determinant_sign

   !> Solves in place for the right-hand side x (block, blocks) and y of the border row.
   subroutine solve(self, x, y)
      class(bordered_type), intent(inout) :: self
      real(dp), intent(inout) :: x(:, :), y
      integer :: j, n

      if (self%blocks == 0) then
         y = y/self%corner
         return
      end if
      n = self%block
      do j = 1, self%blocks - 1
         call solve_factored(n, 1, self%diagonal(:, :, j), self%pivot(:, j), x(:, j))
         call dgemv('N', n, n, -1.0_dp, self%lower(:, :, j + 1), n, x(:, j), 1, 1.0_dp, x(:, j + 1), 1)
         y = y - dot_product(self%row(:, j), x(:, j))
      end do
      j = self%blocks
      self%joint(:n) = x(:, j)
      self%joint(n + 1) = y
      call solve_factored(n + 1, 1, self%last, self%last_pivot, self%joint)
      x(:, j) = self%joint(:n)
      y = self%joint(n + 1)
      do j = self%blocks - 1, 1, -1
         call dgemv('N', n, n, -1.0_dp, self%upper(:, :, j), n, x(:, j + 1), 1, 1.0_dp, x(:, j), 1)
         x(:, j) = x(:, j) - y*self%column(:, j)
      end do
   end subroutine solve

end module geartrain_motion_bordered
