!> Small numerical tools: LU factors against the products they are made of, for sizes on both sides of the change to LAPACK; blocks
!> along a graph; first roots of polynomials; sorting.
module unit_elimination
   use, intrinsic :: ieee_arithmetic, only: ieee_get_halting_mode, ieee_invalid, ieee_quiet_nan, ieee_set_flag, &
      ieee_set_halting_mode, ieee_value
   use geartrain_base_kinds, only: dp
   use geartrain_base_sorting, only: ascending
   use geartrain_linalg_bordered, only: bordered_type
   use geartrain_linalg_elimination, only: determinant_sign, factor_matrix, solve_factored
   use geartrain_linalg_first_root, only: first_root
   use geartrain_linalg_graph, only: graph_type
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: elimination_tests

contains

   subroutine elimination_tests(tests)
      class(tests_type), intent(inout) :: tests
      real(dp) :: singular(3, 3)
      integer :: pivot(3), info

      if (tests%runs('solves')) then
         call solves(tests, 1)
         call solves(tests, 2)
         call solves(tests, 13)
         call solves(tests, 32)
         call solves(tests, 33)
      end if
      if (tests%runs('blocks')) then
         call blocks(tests, [integer ::], .false.)
         ! The first to be eliminated, one that others change before, and one that is singular.
         call blocks(tests, [6], .false.)
         call blocks(tests, [2, 4, 6], .false.)
         call blocks(tests, [6, 1], .true.)
      end if
      if (tests%runs('singular')) then
         ! All quotients are powers of two: the elimination is exact, also with products that are not rounded.
         singular = reshape(1.0_dp*[4, 2, 1, 8, 4, 2, 0, 1, 0], [3, 3])
         call factor_matrix(3, singular, pivot, info)
         call tests%is_true(info /= 0, 'a singular matrix is told')
         call not_a_number(tests, 3)
         call not_a_number(tests, 40)
      end if
      if (tests%runs('first_roots')) call first_roots(tests)
      if (tests%runs('sorting')) then
         call tests%is_true(all(ascending([3.0_dp, 1.0_dp, 2.0_dp, 1.0_dp]) == [2, 4, 3, 1]), 'equal keys keep their order')
         call tests%is_true(size(ascending([real(dp) ::])) == 0, 'no keys')
      end if
   end subroutine elimination_tests

   !> Five blocks that are all coupled, as those of planets, and one that is coupled with the first: solution and sign of the
   !> determinant are those of the whole matrix.
   subroutine blocks(tests, uncoupled, singular)
      class(tests_type), intent(inout) :: tests
      !> Blocks whose columns couple each harmonic with itself alone.
      integer, intent(in) :: uncoupled(:)
      !> The diagonal block of the last node is singular.
      logical, intent(in) :: singular
      integer, parameter :: n = 5, nodes = 6, rows = n*nodes + 1
      type(graph_type) :: graph
      type(bordered_type) :: matrix
      real(dp) :: whole(rows, rows), factors(rows, rows), right(n, nodes), x(n, nodes), solution(rows), y
      integer :: pairs(2, 2*11), i, j, k, info, pivot(rows)

      k = 0
      do i = 1, nodes
         do j = 1, nodes
            if (i == j .or. (max(i, j) == nodes .and. min(i, j) > 1)) cycle
            k = k + 1
            pairs(:, k) = [i, j]
         end do
      end do
      call graph%setup(nodes, pairs)
      call matrix%resize(n, graph)
      call random_number(whole)
      call random_number(right)
      whole = whole - 0.5_dp
      matrix%uncoupled(uncoupled) = .true.
      do j = 1, nodes
         if (.not. matrix%uncoupled(j)) cycle
         do i = 1, rows - 1
            do k = 1, n
               if ((mod(i - 1, n) + 1)/2 /= k/2) whole(i, (j - 1)*n + k) = 0
            end do
         end do
      end do
      if (singular) whole(rows - n, rows - n) = 0
      do i = 1, nodes
         do j = 1, nodes
            associate (a => (i - 1)*n, b => (j - 1)*n)
               if (graph%entry_of(i, j) > 0) then
                  matrix%entry(:, :, graph%entry_of(i, j)) = whole(a + 1:a + n, b + 1:b + n)
               else
                  whole(a + 1:a + n, b + 1:b + n) = 0
               end if
            end associate
         end do
      end do
      matrix%column = reshape(whole(:rows - 1, rows), [n, nodes])
      matrix%row = reshape(whole(rows, :rows - 1), [n, nodes])
      matrix%corner = whole(rows, rows)
      call matrix%factor(info)
      call tests%is_true(info == 0, 'blocks are regular')
      x = right
      y = 0.7_dp
      call matrix%solve(x, y)
      factors = whole
      call factor_matrix(rows, factors, pivot, info)
      solution = [right, 0.7_dp]
      call solve_factored(rows, 1, factors, pivot, solution)
      ! Rounding times a condition number of some ten thousand at most.
      call tests%is_close(maxval(abs([x, y] - solution))/maxval(abs(solution)), 0.0_dp, 1e-11_dp, 'blocks: solution')
      call tests%is_true(matrix%orientation == determinant_sign(factors, pivot), 'blocks: sign of the determinant')
   end subroutine blocks

   !> Polynomials with known roots.
   subroutine first_roots(tests)
      class(tests_type), intent(inout) :: tests
      real(dp) :: root
      logical :: hit

      ! (0.3 - t)(1.1 - t)
      call first_root([0.33_dp, -1.4_dp, 1.0_dp], 2.0_dp, root, hit)
      call tests%is_true(hit, 'the first of two roots')
      call tests%is_close(root, 0.3_dp, 1e-15_dp, 'the first of two roots')
      ! (t - 0.7)**2 - 1e-6, below zero within a small part of the interval only
      call first_root([0.49_dp - 1e-6_dp, -1.4_dp, 1.0_dp], 2.0_dp, root, hit)
      call tests%is_true(hit, 'a brief fall below zero')
      call tests%is_close(root, 0.699_dp, 1e-12_dp, 'a brief fall below zero')
      call first_root([0.49_dp + 1e-6_dp, -1.4_dp, 1.0_dp], 2.0_dp, root, hit)
      call tests%is_true(.not. hit, 'a minimum above zero')
   end subroutine first_roots

   !> A matrix with NaN has no factors, and its row exchanges may lead out of it.
   subroutine not_a_number(tests, n)
      class(tests_type), intent(inout) :: tests
      integer, intent(in) :: n
      real(dp) :: a(n, n)
      integer :: pivot(n), info, i, j
      logical :: halts

      ! Any comparison with NaN is an invalid operation, at which the debug build halts.
      call ieee_get_halting_mode(ieee_invalid, halts)
      call ieee_set_halting_mode(ieee_invalid, .false.)
      do i = 1, n
         do j = 1, n
            a(i, j) = 1/real(i + j - 1, dp)
         end do
      end do
      a(n/2, :) = ieee_value(1.0_dp, ieee_quiet_nan)
      call factor_matrix(n, a, pivot, info)
      call tests%is_true(info > 0 .and. info <= n, 'a row of NaN is told')
      a = ieee_value(1.0_dp, ieee_quiet_nan)
      call factor_matrix(n, a, pivot, info)
      call tests%is_true(info > 0 .and. info <= n, 'a matrix of NaN is told')
      call ieee_set_flag(ieee_invalid, .false.)
      call ieee_set_halting_mode(ieee_invalid, halts)
   end subroutine not_a_number

   !> a x = b with a known x, one column and three; zeros on the diagonal make rows change places.
   subroutine solves(tests, n)
      class(tests_type), intent(inout) :: tests
      integer, intent(in) :: n
      real(dp) :: a(n, n), x(n, 3), b(n, 3), alone(n)
      integer :: pivot(n), info, i, j

      do j = 1, n
         do i = 1, n
            a(i, j) = sin(real(7*i + 3*j*j + i*j, dp))
            if (i == j .and. n > 1) a(i, j) = 0
         end do
      end do
      x = reshape([(cos(real(i, dp)), i=1, 3*n)], [n, 3])
      b = matmul(a, x)
      alone = b(:, 2)
      call factor_matrix(n, a, pivot, info)
      call tests%is_true(info == 0, 'a regular matrix')
      call solve_factored(n, 3, a, pivot, b)
      call tests%is_close(maxval(abs(b - x)), 0.0_dp, 1e-11_dp, 'three columns')
      call solve_factored(n, 1, a, pivot, alone)
      call tests%is_close(maxval(abs(alone - x(:, 2))), 0.0_dp, 1e-11_dp, 'one column')
   end subroutine solves

end module unit_elimination
