!> The linearised balance of a motion in which equal branches move equally, in the coefficients of one branch of each kind: the
!> blocks of three equal planets become those of one, which may move a share of the cycle later. The solution is that of the whole
!> system for right sides of the same symmetry.
!>
!> The equations of the mean are those of a tree and its loops. Multiplied with their inverse they are exchanged as the
!> others are (geartrain_balance_fixed_space), and one of each kind is enough.
module geartrain_balance_equal_system
   use geartrain_balance_fixed_space, only: average_equal
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
      !> Equations of the mean and their inverse, (equation, unknown).
      real(dp), allocatable, private :: mean(:, :), inverse(:, :)
      !> How much later unknowns move than those that stand for them; not allocated within: all move at once.
      type(planet_turn_type), private :: turn
      !> Couplings of the nodes; the smaller system.
      type(graph_type), private :: graph
      type(bordered_type), private :: matrix
      !> The system of the motions that each of an even number of planets has with the other sign than the one before.
      type(bordered_type), private :: alternating
      !> Sign of the determinant of the whole system, as far as it changes: other motions come in pairs, whose parts are conjugate.
      integer :: orientation = 0
   contains
      procedure :: setup
      procedure :: factor
      procedure :: solve
      procedure :: project
      procedure, private :: fill
      procedure, private :: clear
   end type equal_system_type

contains

   !> Takes which unknowns move equally.
   subroutine setup(self, orbit, mean, inverse, turn, whole)
      class(equal_system_type), intent(inout) :: self
      !> Unknown that stands for each, (unknown).
      integer, intent(in) :: orbit(:)
      !> Equations of the mean and their inverse, (equation, unknown).
      real(dp), intent(in) :: mean(:, :), inverse(:, :)
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
      self%mean = mean
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
      self%alternating = matrix
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
      real(dp) :: part(1, whole%block)
      integer :: j, regular

      call self%fill(whole, .false., self%matrix)
      self%matrix%corner = corner
      self%matrix%column = column(:, self%unknown)
      self%matrix%column(1, :) = matmul(self%inverse(self%unknown, :), column(1, :))
      call self%clear(self%matrix%column)
      do j = 1, whole%graph%nodes
         part(1, :) = row(:, j)
         if (allocated(self%turn%orbit)) call self%turn%turn_columns(j, part)
         self%matrix%row(:, self%node(j)) = self%matrix%row(:, self%node(j)) + part(1, :)
      end do
      call self%matrix%factor(info)
      self%orientation = self%matrix%orientation
      if (info /= 0 .or. .not. allocated(self%turn%other)) return
      call self%fill(whole, .true., self%alternating)
      self%alternating%corner = 1
      self%alternating%column = 0
      call self%alternating%factor(regular)
      self%orientation = self%orientation*merge(self%alternating%orientation, 0, regular == 0)
   end subroutine factor

   !> Makes the smaller matrix, without a border.
   subroutine fill(self, whole, alternates, matrix)
      class(equal_system_type), intent(in) :: self
      !> The whole system.
      type(bordered_type), intent(in) :: whole
      !> For motions that each planet has with the other sign than the one before.
      logical, intent(in) :: alternates
      !> The smaller matrix.
      type(bordered_type), intent(inout) :: matrix
      real(dp) :: part(whole%block, whole%block)
      integer :: entry, from, j, k, l, m, n

      call matrix%resize(whole%block, self%graph)
      matrix%interrupt = whole%interrupt
      matrix%entry = 0
      matrix%row = 0
      associate (graph => whole%graph)
         do j = 1, graph%nodes
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
               if (allocated(self%turn%orbit)) call self%turn%turn_columns(j, part)
               if (alternates) then
                  if (self%turn%other(j)) part = -part
               end if
               matrix%entry(:, :, entry) = matrix%entry(:, :, entry) + part
            end do
         end do
      end associate
      if (.not. allocated(self%turn%orbit)) return
      do j = 1, self%graph%nodes
         do k = 1, (whole%block - 1)/2
            if (.not. self%turn%still(k, self%unknown(j))) cycle
            ! Harmonics without amplitude, whose columns are 0, have equations of their own.
            do m = self%graph%row(j), self%graph%row(j + 1) - 1
               matrix%entry(2*k:2*k + 1, :, self%graph%entry_of(j, self%graph%column(m))) = 0
            end do
            matrix%entry(2*k, 2*k, self%graph%entry_of(j, j)) = 1
            matrix%entry(2*k + 1, 2*k + 1, self%graph%entry_of(j, j)) = 1
         end do
      end do
   end subroutine fill

   !> Clears harmonics that have no amplitude.
   pure subroutine clear(self, x)
      class(equal_system_type), intent(in) :: self
      !> Right-hand side of the smaller system, (block, node).
      real(dp), intent(inout) :: x(:, :)
      integer :: k

      if (.not. allocated(self%turn%orbit)) return
      do k = 1, (size(x, 1) - 1)/2
         where (spread(self%turn%still(k, self%unknown), 1, 2)) x(2*k:2*k + 1, :) = 0
      end do
   end subroutine clear

   !> Solves in place.
   subroutine solve(self, x, y)
      class(equal_system_type), intent(inout) :: self
      !> Right-hand side of the whole system, afterwards its solution, (block, unknown), and the entry in the border row.
      real(dp), intent(inout) :: x(:, :), y
      real(dp) :: one(size(x, 1), size(self%unknown))

      one = x(:, self%unknown)
      one(1, :) = matmul(self%inverse(self%unknown, :), x(1, :))
      call self%clear(one)
      call self%matrix%solve(one, y)
      x = one(:, self%node)
      if (allocated(self%turn%orbit)) call self%turn%turn(1, x)
   end subroutine solve

   !> Takes the part of a right-hand side of the whole system that has the symmetry: `solve` leaves nothing of the rest, which is
   !> rounding.
   subroutine project(self, x)
      class(equal_system_type), intent(in) :: self
      !> Right-hand side, (block, unknown).
      real(dp), intent(inout) :: x(:, :)

      x(1, :) = matmul(self%inverse, x(1, :))
      if (allocated(self%turn%orbit)) call self%turn%turn(-1, x)
      call average_equal(self%unknown(self%node), x)
      if (allocated(self%turn%orbit)) call self%turn%turn(1, x)
      x(1, :) = matmul(self%mean, x(1, :))
   end subroutine project

end module geartrain_balance_equal_system
