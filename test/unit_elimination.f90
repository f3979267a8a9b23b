!> LU factors against the products they are made of, for sizes on both sides of the change to LAPACK.
module unit_elimination
   use geartrain, only: dp
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
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
      if (tests%runs('singular')) then
         singular = reshape(1.0_dp*[1, 2, 3, 2, 4, 6, 0, 1, 0], [3, 3])
         call factor_matrix(3, singular, pivot, info)
         call tests%is_true(info /= 0, 'a singular matrix is told')
      end if
   end subroutine elimination_tests

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
