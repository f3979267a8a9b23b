!> A matrix of square blocks on a graph, bordered by one row and one column. The elimination goes along the order of the graph, on a
!> tree in time linear in the number of blocks. The border is factored together with the last block, so the bordered matrix is
!> regular at folds, where the matrix without border is singular.
module geartrain_linalg_bordered
   use geartrain_base_interrupt, only: interrupt_type
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_elimination, only: determinant_sign, factor_matrix, solve_factored
   use geartrain_linalg_graph, only: graph_type
   use geartrain_linalg_lapack, only: dgemm, dgemv
   implicit none (type, external)
   private
   public :: bordered_type

   type :: bordered_type
      !> Rows of a block.
      integer :: block = 0
      !> Graph whose nodes are the block rows.
      type(graph_type) :: graph
      !> Blocks, (block, block, graph%entries), set before `factor`, which overwrites them and clears the blocks of the fill.
      real(dp), allocatable :: entry(:, :, :)
      !> Border column and border row, (block, nodes), set before `factor`, which overwrites them.
      real(dp), allocatable :: column(:, :), row(:, :)
      !> Corner of the border, set before `factor`, which overwrites it.
      real(dp) :: corner = 0
      !> Sign of the determinant, set by `factor`: constant along a smooth branch that is followed in one direction.
      integer :: orientation = 1
      !> Ends `factor` between two blocks.
      type(interrupt_type) :: interrupt
      !> Last block with the border, factored, (block + 1, block + 1); right-hand side of the last block, (block + 1).
      real(dp), allocatable, private :: last(:, :), joint(:)
      integer, allocatable, private :: pivot(:, :), last_pivot(:)
   contains
      procedure :: resize
      procedure :: factor
      procedure :: solve
   end type bordered_type

contains

   !> Allocates the arrays, unless they have the right shape.
   subroutine resize(self, block, graph)
      class(bordered_type), intent(inout) :: self
      !> Rows of a block.
      integer, intent(in) :: block
      !> Graph whose nodes are the block rows.
      type(graph_type), intent(in) :: graph

      if (allocated(self%entry)) then
         if (self%block == block .and. self%graph%nodes == graph%nodes) return
         deallocate (self%entry, self%column, self%row, self%last, self%joint, self%pivot, self%last_pivot)
      end if
      self%block = block
      self%graph = graph
      allocate (self%entry(block, block, graph%entries), self%column(block, graph%nodes), self%row(block, graph%nodes), &
                self%last(block + 1, block + 1), self%joint(block + 1), self%pivot(block, graph%nodes), &
                self%last_pivot(block + 1))
   end subroutine resize

   !> Block elimination; afterwards the upper entries and `column` hold D^-1 U and D^-1 g (D, U: diagonal and upper blocks, g:
   !> border column).
   subroutine factor(self, info)
      class(bordered_type), intent(inout) :: self
      !> 0: regular; else singular or interrupted.
      integer, intent(out) :: info
      integer :: i, k, m, n, s, t

      n = self%block
      info = 0
      self%orientation = 1
      associate (graph => self%graph, nodes => self%graph%nodes, slots => self%graph%slots)
         if (nodes == 0) return
         do s = 1, size(graph%fill)
            self%entry(:, :, graph%fill(s)) = 0
         end do
         do k = 1, nodes - 1
            info = 1
            if (self%interrupt%raised()) return
            i = graph%order(k)
            call factor_matrix(n, self%entry(:, :, i), self%pivot(:, i), info)
            if (info /= 0) return
            self%orientation = self%orientation*determinant_sign(self%entry(:, :, i), self%pivot(:, i))
            call solve_factored(n, 1, self%entry(:, :, i), self%pivot(:, i), self%column(:, i))
            self%corner = self%corner - dot_product(self%row(:, i), self%column(:, i))
            do s = graph%first(k), graph%first(k + 1) - 1
               call solve_factored(n, n, self%entry(:, :, i), self%pivot(:, i), self%entry(:, :, nodes + s))
            end do
            m = graph%update(k)
            do s = graph%first(k), graph%first(k + 1) - 1
               associate (lower => self%entry(:, :, nodes + slots + s), j => graph%later(s))
                  do t = graph%first(k), graph%first(k + 1) - 1
                     m = m + 1
                     call dgemm('N', 'N', n, n, n, -1.0_dp, lower, n, self%entry(:, :, nodes + t), n, 1.0_dp, &
                                self%entry(:, :, graph%target(m)), n)
                  end do
                  call dgemv('N', n, n, -1.0_dp, lower, n, self%column(:, i), 1, 1.0_dp, self%column(:, j), 1)
                  call dgemv('T', n, n, -1.0_dp, self%entry(:, :, nodes + s), n, self%row(:, i), 1, 1.0_dp, self%row(:, j), 1)
               end associate
            end do
         end do
         i = graph%order(nodes)
      end associate
      self%last(:n, :n) = self%entry(:, :, i)
      self%last(:n, n + 1) = self%column(:, i)
      self%last(n + 1, :n) = self%row(:, i)
      self%last(n + 1, n + 1) = self%corner
      call factor_matrix(n + 1, self%last, self%last_pivot, info)
      self%orientation = self%orientation*determinant_sign(self%last, self%last_pivot)
   end subroutine factor

   !> Solves in place, after `factor`.
   subroutine solve(self, x, y)
      class(bordered_type), intent(inout) :: self
      !> Right-hand side, then solution: of the blocks, (block, nodes), and of the border.
      real(dp), intent(inout) :: x(:, :), y
      integer :: i, k, n, s

      n = self%block
      associate (graph => self%graph, nodes => self%graph%nodes, slots => self%graph%slots)
         if (nodes == 0) then
            y = y/self%corner
            return
         end if
         do k = 1, nodes - 1
            i = graph%order(k)
            call solve_factored(n, 1, self%entry(:, :, i), self%pivot(:, i), x(:, i))
            do s = graph%first(k), graph%first(k + 1) - 1
               call dgemv('N', n, n, -1.0_dp, self%entry(:, :, nodes + slots + s), n, x(:, i), 1, 1.0_dp, x(:, graph%later(s)), 1)
            end do
            y = y - dot_product(self%row(:, i), x(:, i))
         end do
         i = graph%order(nodes)
         self%joint(:n) = x(:, i)
         self%joint(n + 1) = y
         call solve_factored(n + 1, 1, self%last, self%last_pivot, self%joint)
         x(:, i) = self%joint(:n)
         y = self%joint(n + 1)
         do k = nodes - 1, 1, -1
            i = graph%order(k)
            do s = graph%first(k), graph%first(k + 1) - 1
               call dgemv('N', n, n, -1.0_dp, self%entry(:, :, nodes + s), n, x(:, graph%later(s)), 1, 1.0_dp, x(:, i), 1)
            end do
            x(:, i) = x(:, i) - y*self%column(:, i)
         end do
      end associate
   end subroutine solve

end module geartrain_linalg_bordered
