!> A matrix of square blocks on a graph, bordered by one row and one column. The elimination goes along the order of the graph, on a
!> tree in time linear in the number of blocks. The border is factored together with the last block, so the bordered matrix is
!> regular at folds, where the matrix without border is singular.
!>
!> A diagonal block may be singular in a regular matrix: the mean force of a mesh that never touches in a loop of meshes does not
!> depend on its own mean displacement, which the rest of the loop prescribes. From such a block on all blocks that are left are
!> factored together, with row exchanges among them.
!>
!> The blocks of a column may have no entries but those that couple a harmonic with itself, as of a bearing that stays in contact:
!> the mean, and pairs of rows. Such a column is eliminated harmonic by harmonic.
module geartrain_linalg_bordered
   use geartrain_base_interrupt, only: interrupt_type
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_elimination, only: determinant_sign, factor_matrix, solve_factored
   use geartrain_linalg_graph, only: graph_type
   use geartrain_linalg_lapack, only: dgemm, dgemv
   implicit none (type, external)
   private
   public :: bordered_type

   !> Least pivot of a block over its largest at which the block counts as regular [1].
   real(dp), parameter :: least_pivot = 1e-10_dp
   !> Most rows that are factored together: a second on one core.
   integer, parameter :: most_together = 2500
   !> Least blocks that follow a block and are coupled with it, for which all are factored together: fewer gain nothing.
   integer, parameter :: least_together = 3

   type :: bordered_type
      !> Rows of a block.
      integer :: block = 0
      !> Graph whose nodes are the block rows.
      type(graph_type) :: graph
      !> Blocks, (block, block, graph%entries), set before `factor`, which overwrites them and clears the blocks of the fill.
      real(dp), allocatable :: entry(:, :, :)
      !> Border column and border row, (block, nodes), set before `factor`, which overwrites them.
      real(dp), allocatable :: column(:, :), row(:, :)
      !> Whether the blocks of a column couple each harmonic with itself alone, (node), set before `factor`.
      logical, allocatable :: uncoupled(:)
      !> Corner of the border, set before `factor`, which overwrites it.
      real(dp) :: corner = 0
      !> Sign of the determinant, set by `factor`: constant along a smooth branch that is followed in one direction.
      integer :: orientation = 1
      !> Ends `factor` between two blocks.
      type(interrupt_type) :: interrupt
      !> Number of blocks that are eliminated one by one.
      integer, private :: single = 0
      !> The blocks that are left, usually the last one, with the border, factored, and their right-hand side, (rows of these blocks
      !> + 1).
      real(dp), allocatable, private :: last(:, :), joint(:)
      integer, allocatable, private :: pivot(:, :), last_pivot(:)
      !> Whether a block was eliminated harmonic by harmonic, (node): its diagonal block is the inverse then.
      logical, allocatable, private :: inverted(:)
   contains
      procedure :: resize
      procedure :: factor
      procedure :: solve
      procedure, private :: factor_rest
      procedure, private :: eliminate_by_harmonic
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
         deallocate (self%entry, self%column, self%row, self%pivot, self%uncoupled, self%inverted)
      end if
      self%block = block
      self%graph = graph
      allocate (self%entry(block, block, graph%entries), self%column(block, graph%nodes), self%row(block, graph%nodes), &
                self%pivot(block, graph%nodes), self%inverted(graph%nodes))
      allocate (self%uncoupled(graph%nodes), source=.false.)
   end subroutine resize

   !> Block elimination; afterwards the upper entries and `column` hold D^-1 U and D^-1 g (D, U: diagonal and upper blocks, g:
   !> border column).
   subroutine factor(self, info)
      class(bordered_type), intent(inout) :: self
      !> 0: regular; else singular or interrupted.
      integer, intent(out) :: info
      real(dp) :: held(self%block, self%block)
      logical :: touched(self%graph%nodes)
      integer :: i, k, m, n, s, t

      n = self%block
      info = 0
      self%orientation = 1
      associate (graph => self%graph, nodes => self%graph%nodes, slots => self%graph%slots)
         if (nodes == 0) then
            if (self%corner < 0) self%orientation = -1
            return
         end if
         do s = 1, size(graph%fill)
            self%entry(:, :, graph%fill(s)) = 0
         end do
         touched = .false.
         self%inverted = .false.
         do k = 1, nodes - 1
            info = 1
            if (self%interrupt%raised()) return
            i = graph%order(k)
            if (self%uncoupled(i) .and. .not. touched(i)) call self%eliminate_by_harmonic(k)
            touched(graph%later(graph%first(k):graph%first(k + 1) - 1)) = .true.
            if (self%inverted(i)) cycle
            if (all_coupled(graph, k) .and. n*(nodes - k + 1) < most_together) then
               call self%factor_rest(k - 1, info)
               return
            end if
            held = self%entry(:, :, i)
            call factor_matrix(n, self%entry(:, :, i), self%pivot(:, i), info)
            if (info == 0) info = merge(0, 1, is_regular(self%entry(:, :, i)))
            if (info /= 0) then
               self%entry(:, :, i) = held
               call self%factor_rest(k - 1, info)
               return
            end if
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
         call self%factor_rest(nodes - 1, info)
      end associate
   end subroutine factor

   !> Eliminates a block whose column is uncoupled, unless it is singular.
   subroutine eliminate_by_harmonic(self, k)
      class(bordered_type), intent(inout) :: self
      !> Place of the block in the order of elimination.
      integer, intent(in) :: k
      real(dp), allocatable :: held(:, :)
      real(dp) :: determinant, factor, pivot, least, largest
      integer :: i, m, n, s, t, orientation

      n = self%block
      i = self%graph%order(k)
      associate (d => self%entry(:, :, i), graph => self%graph, nodes => self%graph%nodes, slots => self%graph%slots)
         held = d
         least = abs(d(1, 1))
         largest = least
         orientation = 1
         if (d(1, 1) < 0) orientation = -1
         do m = 2, n, 2
            determinant = d(m, m)*d(m + 1, m + 1) - d(m, m + 1)*d(m + 1, m)
            pivot = max(abs(d(m, m)), abs(d(m + 1, m)))
            largest = max(largest, pivot)
            least = min(least, abs(determinant)/max(pivot, tiny(pivot)))
            if (determinant < 0) orientation = -orientation
         end do
         if (.not. least > least_pivot*largest) return
         d(1, 1) = 1/d(1, 1)
         do m = 2, n, 2
            factor = 1/(held(m, m)*held(m + 1, m + 1) - held(m, m + 1)*held(m + 1, m))
            d(m, m) = factor*held(m + 1, m + 1)
            d(m + 1, m + 1) = factor*held(m, m)
            d(m, m + 1) = -factor*held(m, m + 1)
            d(m + 1, m) = -factor*held(m + 1, m)
         end do
         self%inverted(i) = .true.
         self%orientation = self%orientation*orientation
         held(:, 1) = self%column(:, i)
         self%column(:, i) = 0
         call add_product(1.0_dp, d, held(:, :1), self%column(:, i:i))
         self%corner = self%corner - dot_product(self%row(:, i), self%column(:, i))
         do s = graph%first(k), graph%first(k + 1) - 1
            held = self%entry(:, :, nodes + s)
            self%entry(:, :, nodes + s) = 0
            call add_product(1.0_dp, d, held, self%entry(:, :, nodes + s))
         end do
         m = graph%update(k)
         do s = graph%first(k), graph%first(k + 1) - 1
            associate (lower => self%entry(:, :, nodes + slots + s), j => graph%later(s))
               do t = graph%first(k), graph%first(k + 1) - 1
                  m = m + 1
                  call add_product(-1.0_dp, lower, self%entry(:, :, nodes + t), self%entry(:, :, graph%target(m)))
               end do
               call add_product(-1.0_dp, lower, self%column(:, i:i), self%column(:, j:j))
               call dgemv('T', n, n, -1.0_dp, self%entry(:, :, nodes + s), n, self%row(:, i), 1, 1.0_dp, self%row(:, j), 1)
            end associate
         end do
      end associate
   end subroutine eliminate_by_harmonic

   !> Adds factor a x to y, where a couples each harmonic with itself alone.
   pure subroutine add_product(factor, a, x, y)
      real(dp), intent(in) :: factor
      real(dp), contiguous, intent(in) :: a(:, :), x(:, :)
      real(dp), contiguous, intent(inout) :: y(:, :)
      real(dp) :: own(size(a, 1)), other(size(a, 1))
      integer :: l, m

      own(1) = factor*a(1, 1)
      do m = 2, size(a, 1), 2
         own(m:m + 1) = factor*[a(m, m), a(m + 1, m + 1)]
         other(m:m + 1) = factor*[a(m, m + 1), a(m + 1, m)]
      end do
      do l = 1, size(x, 2)
         y(1, l) = y(1, l) + own(1)*x(1, l)
         do m = 2, size(a, 1), 2
            y(m, l) = y(m, l) + own(m)*x(m, l) + other(m)*x(m + 1, l)
            y(m + 1, l) = y(m + 1, l) + own(m + 1)*x(m + 1, l) + other(m + 1)*x(m, l)
         end do
      end do
   end subroutine add_product

   !> Whether the blocks from number k on are several and all coupled, as those of the planets of a set: the matrix of them has no
   !> zeros, and one elimination is faster than that of block after block.
   pure logical function all_coupled(graph, k)
      type(graph_type), intent(in) :: graph
      integer, intent(in) :: k

      all_coupled = graph%nodes - k >= least_together .and. graph%first(k + 1) - graph%first(k) == graph%nodes - k
   end function all_coupled

   !> Factors the blocks that are left, with the border, as one matrix.
   subroutine factor_rest(self, single, info)
      class(bordered_type), intent(inout) :: self
      !> Number of blocks that were eliminated one by one.
      integer, intent(in) :: single
      !> 0: regular; else singular or too large.
      integer, intent(out) :: info
      integer :: place(self%graph%nodes), i, j, k, n, rows, s

      self%single = single
      n = self%block
      rows = n*(self%graph%nodes - single) + 1
      info = 1
      if (single < self%graph%nodes - 1 .and. rows > most_together) return
      if (allocated(self%last)) then
         if (size(self%joint) /= rows) deallocate (self%last, self%joint, self%last_pivot)
      end if
      if (.not. allocated(self%last)) allocate (self%last(rows, rows), self%joint(rows), self%last_pivot(rows))
      associate (graph => self%graph, nodes => self%graph%nodes, slots => self%graph%slots)
         if (single < nodes - 1) self%last = 0
         ! Rows of each block that is left.
         do k = single + 1, nodes
            place(graph%order(k)) = n*(k - single - 1)
         end do
         do k = single + 1, nodes
            i = graph%order(k)
            associate (a => place(i))
               self%last(a + 1:a + n, a + 1:a + n) = self%entry(:, :, i)
               self%last(a + 1:a + n, rows) = self%column(:, i)
               self%last(rows, a + 1:a + n) = self%row(:, i)
               do s = graph%first(k), graph%first(k + 1) - 1
                  j = place(graph%later(s))
                  self%last(a + 1:a + n, j + 1:j + n) = self%entry(:, :, nodes + s)
                  self%last(j + 1:j + n, a + 1:a + n) = self%entry(:, :, nodes + slots + s)
               end do
            end associate
         end do
      end associate
      self%last(rows, rows) = self%corner
      call factor_matrix(rows, self%last, self%last_pivot, info)
      self%orientation = self%orientation*determinant_sign(self%last, self%last_pivot)
   end subroutine factor_rest

   !> Whether a factored block is far from singular.
   pure logical function is_regular(factors)
      real(dp), intent(in) :: factors(:, :)
      real(dp) :: least, largest
      integer :: i

      least = huge(least)
      largest = 0
      do i = 1, size(factors, 1)
         least = min(least, abs(factors(i, i)))
         largest = max(largest, abs(factors(i, i)))
      end do
      is_regular = least > least_pivot*largest
   end function is_regular

   !> Solves in place, after `factor`.
   subroutine solve(self, x, y)
      class(bordered_type), intent(inout) :: self
      !> Right-hand side, then solution: of the blocks, (block, nodes), and of the border.
      real(dp), intent(inout) :: x(:, :), y
      real(dp) :: held(self%block, 1)
      integer :: i, k, m, n, s

      n = self%block
      associate (graph => self%graph, nodes => self%graph%nodes, slots => self%graph%slots)
         if (nodes == 0) then
            y = y/self%corner
            return
         end if
         do k = 1, self%single
            i = graph%order(k)
            if (self%inverted(i)) then
               held = x(:, i:i)
               x(:, i) = 0
               call add_product(1.0_dp, self%entry(:, :, i), held, x(:, i:i))
            else
               call solve_factored(n, 1, self%entry(:, :, i), self%pivot(:, i), x(:, i))
            end if
            do s = graph%first(k), graph%first(k + 1) - 1
               call dgemv('N', n, n, -1.0_dp, self%entry(:, :, nodes + slots + s), n, x(:, i), 1, 1.0_dp, x(:, graph%later(s)), 1)
            end do
            y = y - dot_product(self%row(:, i), x(:, i))
         end do
         m = size(self%joint)
         do k = self%single + 1, nodes
            self%joint(n*(k - self%single - 1) + 1:n*(k - self%single)) = x(:, graph%order(k))
         end do
         self%joint(m) = y
         call solve_factored(m, 1, self%last, self%last_pivot, self%joint)
         do k = self%single + 1, nodes
            x(:, graph%order(k)) = self%joint(n*(k - self%single - 1) + 1:n*(k - self%single))
         end do
         y = self%joint(m)
         do k = self%single, 1, -1
            i = graph%order(k)
            do s = graph%first(k), graph%first(k + 1) - 1
               call dgemv('N', n, n, -1.0_dp, self%entry(:, :, nodes + s), n, x(:, graph%later(s)), 1, 1.0_dp, x(:, i), 1)
            end do
            x(:, i) = x(:, i) - y*self%column(:, i)
         end do
      end associate
   end subroutine solve

end module geartrain_linalg_bordered
