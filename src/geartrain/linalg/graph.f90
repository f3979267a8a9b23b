!> Structure of a sparse matrix: which unknowns are coupled, and the order of elimination. The node with the fewest neighbours comes
!> first, so a tree is eliminated from its leaves without fill, and a chain from its first node.
!>
!> The entries of a matrix on a graph are numbered: entry i is the diagonal element of node i. A slot s is a pair of coupled nodes;
!> entry nodes + s is in the row of the node eliminated earlier and the column of the node eliminated later, entry
!> nodes + slots + s in the row of the later and the column of the earlier node.
module geartrain_linalg_graph
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: graph_type, factor_scalars, solve_scalars

   type :: graph_type
      !> Number of nodes.
      integer :: nodes = 0
      !> Number of pairs of coupled nodes, fill included; number of entries of a matrix, nodes + 2*slots.
      integer :: slots = 0, entries = 0
      !> Node that is eliminated k-th, (nodes).
      integer, allocatable :: order(:)
      !> Slots first(k):first(k + 1) - 1 couple order(k) with the nodes later(first(k):first(k + 1) - 1), (nodes + 1) and (slots).
      integer, allocatable :: first(:), later(:)
      !> Elimination of order(k) changes, for its slots s and t in turn (t runs faster), the entry target(update(k) + ...) in row
      !> later(s) and column later(t), (nodes + 1) and (updates).
      integer, allocatable :: update(:), target(:)
      !> Entries entry(row(i):row(i + 1) - 1) are in row i, in the columns column(row(i):row(i + 1) - 1), ascending, without fill.
      integer, allocatable :: row(:), column(:), entry(:)
      !> Entries of the fill.
      integer, allocatable :: fill(:)
   contains
      procedure :: setup
      procedure :: entry_of
   end type graph_type

contains

   !> Makes a graph; may be called once.
   pure subroutine setup(self, nodes, pairs)
      class(graph_type), intent(inout) :: self
      !> Number of nodes; pairs of coupled nodes, (2, pair), in any order and as often as one likes.
      integer, intent(in) :: nodes, pairs(:, :)
      logical :: joined(nodes, nodes), left(nodes)
      integer :: degree(nodes), given(nodes), i, j, k, s, t

      self%nodes = nodes
      joined = .false.
      do i = 1, size(pairs, 2)
         joined(pairs(1, i), pairs(2, i)) = .true.
         joined(pairs(2, i), pairs(1, i)) = .true.
      end do
      do i = 1, nodes
         joined(i, i) = .false.
         degree(i) = count(joined(:, i))
      end do
      given = degree
      allocate (self%order(nodes), self%first(nodes + 1), self%later(sum(degree)/2), self%update(nodes + 1))
      call list_rows(self, joined)
      left = .true.
      self%slots = 0
      do k = 1, nodes
         ! The mesh between two bearings comes after both, whose columns are sparse.
         i = minloc((nodes + 1)*degree + given, 1, left)
         self%order(k) = i
         self%first(k) = self%slots + 1
         left(i) = .false.
         do j = 1, nodes
            if (.not. (left(j) .and. joined(j, i))) cycle
            if (self%slots == size(self%later)) self%later = [self%later, self%later, 0]
            self%slots = self%slots + 1
            self%later(self%slots) = j
            degree(j) = degree(j) - 1
         end do
         do s = self%first(k), self%slots
            do t = self%first(k), s - 1
               associate (a => self%later(s), b => self%later(t))
                  if (joined(a, b)) cycle
                  joined(a, b) = .true.
                  joined(b, a) = .true.
                  degree(a) = degree(a) + 1
                  degree(b) = degree(b) + 1
               end associate
            end do
         end do
      end do
      self%first(nodes + 1) = self%slots + 1
      self%later = self%later(:self%slots)
      self%entries = nodes + 2*self%slots
      call find_entries(self)
   end subroutine setup

   !> Columns of each row, without fill.
   pure subroutine list_rows(self, joined)
      type(graph_type), intent(inout) :: self
      logical, intent(in) :: joined(:, :)
      integer :: i, j, n

      allocate (self%row(self%nodes + 1), self%column(self%nodes + count(joined)))
      n = 0
      do i = 1, self%nodes
         self%row(i) = n + 1
         do j = 1, self%nodes
            if (.not. (joined(j, i) .or. i == j)) cycle
            n = n + 1
            self%column(n) = j
         end do
      end do
      self%row(self%nodes + 1) = n + 1
   end subroutine list_rows

   !> Numbers the entries of the rows, and the entries that each elimination changes.
   pure subroutine find_entries(self)
      type(graph_type), intent(inout) :: self
      integer :: number(self%nodes, self%nodes), i, j, k, n, s, t

      number = 0
      n = 0
      do k = 1, self%nodes
         i = self%order(k)
         number(i, i) = i
         do s = self%first(k), self%first(k + 1) - 1
            number(i, self%later(s)) = self%nodes + s
            number(self%later(s), i) = self%nodes + self%slots + s
         end do
         self%update(k) = n
         n = n + (self%first(k + 1) - self%first(k))**2
      end do
      self%update(self%nodes + 1) = n
      allocate (self%target(n), self%entry(size(self%column)))
      n = 0
      do k = 1, self%nodes
         do s = self%first(k), self%first(k + 1) - 1
            do t = self%first(k), self%first(k + 1) - 1
               n = n + 1
               self%target(n) = number(self%later(s), self%later(t))
            end do
         end do
      end do
      do i = 1, self%nodes
         do j = self%row(i), self%row(i + 1) - 1
            self%entry(j) = number(i, self%column(j))
            number(i, self%column(j)) = 0
         end do
      end do
      self%fill = pack(number, number > 0)
   end subroutine find_entries

   !> Number of the entry in a row and a column; 0: the nodes are not coupled.
   pure integer function entry_of(self, i, j)
      class(graph_type), intent(in) :: self
      !> Row and column.
      integer, intent(in) :: i, j
      integer :: n

      entry_of = 0
      do n = self%row(i), self%row(i + 1) - 1
         if (self%column(n) == j) entry_of = self%entry(n)
      end do
   end function entry_of

   !> Factors a matrix of numbers on a graph in place. The diagonal has to dominate: no rows are exchanged.
   pure subroutine factor_scalars(graph, a)
      !> Structure of the matrix.
      type(graph_type), intent(in) :: graph
      !> Entries, (graph%entries); then inverse pivots on the diagonal, and upper entries times the inverse pivot of their row.
      complex(dp), intent(inout), contiguous :: a(:)
      integer :: k, n, s, t

      associate (upper => graph%nodes, lower => graph%nodes + graph%slots)
         do k = 1, graph%nodes
            a(graph%order(k)) = 1/a(graph%order(k))
            n = graph%update(k)
            do s = graph%first(k), graph%first(k + 1) - 1
               a(upper + s) = a(graph%order(k))*a(upper + s)
            end do
            do s = graph%first(k), graph%first(k + 1) - 1
               do t = graph%first(k), graph%first(k + 1) - 1
                  n = n + 1
                  a(graph%target(n)) = a(graph%target(n)) - a(lower + s)*a(upper + t)
               end do
            end do
         end do
      end associate
   end subroutine factor_scalars

   !> Solves in place with the factors of `factor_scalars`.
   pure subroutine solve_scalars(graph, a, x)
      !> Structure of the matrix.
      type(graph_type), intent(in) :: graph
      !> Factors, (graph%entries).
      complex(dp), intent(in), contiguous :: a(:)
      !> Right-hand side, then solution, (nodes).
      complex(dp), intent(inout), contiguous :: x(:)
      integer :: i, k, s

      associate (upper => graph%nodes, lower => graph%nodes + graph%slots)
         do k = 1, graph%nodes
            i = graph%order(k)
            x(i) = a(i)*x(i)
            do s = graph%first(k), graph%first(k + 1) - 1
               x(graph%later(s)) = x(graph%later(s)) - a(lower + s)*x(i)
            end do
         end do
         do k = graph%nodes, 1, -1
            i = graph%order(k)
            do s = graph%first(k), graph%first(k + 1) - 1
               x(i) = x(i) - a(upper + s)*x(graph%later(s))
            end do
         end do
      end associate
   end subroutine solve_scalars

end module geartrain_linalg_graph
