!> The linearised balance of a motion in which equal branches move equally, in the coefficients of one branch of each kind: the
!> blocks of three equal planets become those of one, which may move a share of the cycle later. The solution is that of the whole
!> system for right sides of the same symmetry.
!>
!> The equations of the mean are those of a tree and its loops. Multiplied with their inverse they are exchanged as the
!> others are (geartrain_balance_fixed_space), and one of each kind is enough.
module geartrain_balance_equal_system
   use geartrain_balance_planet_turn, only: planet_turn_type
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_bordered, only: bordered_type
   use geartrain_linalg_graph, only: graph_type
   implicit none (type, external)
   private
   public :: equal_system_type

   type :: equal_system_type
      !> Node of each unknown in the smaller system, (unknown), and unknown that stands for each node, (node).
      integer, allocatable, private :: node(:), unknown(:)
      !> Factors of the equations of the mean, (equation, unknown).
      real(dp), allocatable, private :: inverse(:, :)
      !> How much later unknowns move than those that stand for them; not allocated within: all move at once.
      type(planet_turn_type), private :: turn
      !> Couplings of the nodes; the smaller system.
      type(graph_type), private :: graph
      type(bordered_type), private :: matrix
   contains
      procedure :: setup
      procedure :: factor
      procedure :: solve
      procedure :: orientation
   end type equal_system_type

contains

   !> Takes which unknowns move equally.
   subroutine setup(self, orbit, inverse, turn, whole)
      class(equal_system_type), intent(inout) :: self
      !> Unknown that stands for each, (unknown).
      integer, intent(in) :: orbit(:)
      !> Inverse of the equations of the mean, (equation, unknown).
      real(dp), intent(in) :: inverse(:, :)
      !> How much later each moves.
      type(planet_turn_type), intent(in) :: turn
      !> Couplings of the unknowns.
      type(graph_type), intent(in) :: whole
      type(graph_type) :: graph
      type(bordered_type) :: matrix
      integer, allocatable :: node(:), pairs(:, :)
      integer :: i, j, k

      self%unknown = pack([(i, i=1, size(orbit))], [(orbit(i) == i, i=1, size(orbit))])
      node = [(findloc(self%unknown, orbit(i), 1), i=1, size(orbit))]
      self%inverse = inverse
      self%turn = turn
      if (allocated(self%node)) then
         if (all(self%node == node)) return
      end if
      self%node = node
      allocate (pairs(2, 0))
      do k = 1, size(self%unknown)
         do j = 1, whole%nodes
            if (node(j) == k .or. .not. couples(self, whole, self%unknown(k), j)) cycle
            pairs = reshape([pairs, k, node(j)], [2, size(pairs, 2) + 1])
         end do
      end do
      call graph%setup(size(self%unknown), pairs)
      self%graph = graph
      self%matrix = matrix
   end subroutine setup

   !> Whether the equations of an unknown have an entry in a column.
   pure logical function couples(self, whole, row, column)
      type(equal_system_type), intent(in) :: self
      type(graph_type), intent(in) :: whole
      integer, intent(in) :: row, column
      integer :: n

      couples = whole%entry_of(row, column) > 0
      do n = whole%row(column), whole%row(column + 1) - 1
         couples = couples .or. abs(self%inverse(row, whole%column(n))) > 0
      end do
   end function couples

   !> Factors the smaller system.
   subroutine factor(self, whole, column, row, corner, info)
      class(equal_system_type), intent(inout) :: self
      !> The whole system, not factored; its border is not used.
      type(bordered_type), intent(in) :: whole
      !> Border column and row, (block, unknown), and their corner.
      real(dp), intent(in) :: column(:, :), row(:, :), corner
      !> 0: regular; else singular or interrupted.
      integer, intent(out) :: info
      real(dp) :: part(whole%block, whole%block)
      integer :: entry, from, j, k, l, m, n

      call self%matrix%resize(whole%block, self%graph)
      self%matrix%interrupt = whole%interrupt
      self%matrix%entry = 0
      self%matrix%row = 0
      self%matrix%corner = corner
      self%matrix%column = column(:, self%unknown)
      self%matrix%column(1, :) = matmul(self%inverse(self%unknown, :), column(1, :))
      associate (graph => whole%graph)
         do j = 1, graph%nodes
            part(1, :) = row(:, j)
            call turned(1)
            self%matrix%row(:, self%node(j)) = self%matrix%row(:, self%node(j)) + part(1, :)
            ! What the column is coupled with, the diagonal included.
            do m = self%graph%row(self%node(j)), self%graph%row(self%node(j) + 1) - 1
               k = self%graph%column(m)
               entry = self%graph%entry_of(k, self%node(j))
               from = graph%entry_of(self%unknown(k), j)
               part = 0
               if (from > 0) part(2:, :) = whole%entry(2:, :, from)
               ! The rows that are coupled with the column.
               do n = graph%row(j), graph%row(j + 1) - 1
                  l = graph%column(n)
                  part(1, :) = part(1, :) + self%inverse(self%unknown(k), l)*whole%entry(1, :, graph%entry_of(l, j))
               end do
               call turned(whole%block)
               self%matrix%entry(:, :, entry) = self%matrix%entry(:, :, entry) + part
            end do
         end do
      end associate
      call self%matrix%factor(info)

   contains

      !> Makes the first rows of a part of column j those of the unknown that stands for it.
      subroutine turned(rows)
         integer, intent(in) :: rows

         if (allocated(self%turn%orbit)) call self%turn%turn_columns(j, part(:rows, :))
      end subroutine turned

   end subroutine factor

   !> Solves in place.
   subroutine solve(self, x, y)
      class(equal_system_type), intent(inout) :: self
      !> Right-hand side of the whole system, afterwards its solution, (block, unknown), and the entry in the border row.
      real(dp), intent(inout) :: x(:, :), y
      real(dp) :: one(size(x, 1), size(self%unknown))

      one = x(:, self%unknown)
      one(1, :) = matmul(self%inverse(self%unknown, :), x(1, :))
      call self%matrix%solve(one, y)
      x = one(:, self%node)
      if (allocated(self%turn%orbit)) call self%turn%turn(1, x)
   end subroutine solve

   !> Sign of the determinant of the smaller system.
   pure integer function orientation(self)
      class(equal_system_type), intent(in) :: self

      orientation = self%matrix%orientation
   end function orientation

end module geartrain_balance_equal_system
