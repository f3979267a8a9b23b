!> Eigenvalues of matrices that are made from known ones, for sizes on both sides of the change to LAPACK.
module unit_eigenvalues
   use geartrain, only: dp
   use geartrain_base_eigenvalues, only: find_eigenvalues
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: eigenvalues_tests

contains

   subroutine eigenvalues_tests(tests)
      class(tests_type), intent(inout) :: tests
      real(dp) :: a(4, 4)
      complex(dp) :: values(4)
      integer :: info

      call tests%begin('eigenvalues')
      call known(tests, 1)
      call known(tests, 2)
      call known(tests, 3)
      call known(tests, 10)
      call known(tests, 32)
      call known(tests, 33)
      ! A cyclic permutation: all roots of 1, on which unshifted steps would turn for ever.
      a = 0
      a(2, 1) = 1
      a(3, 2) = 1
      a(4, 3) = 1
      a(1, 4) = 1
      call find_eigenvalues(4, a, values, info)
      call tests%is_true(info == 0, 'cyclic permutation converges')
      call tests%is_close(maxval(abs(values**4 - 1)), 0.0_dp, 1e-14_dp, 'its eigenvalues are the roots of 1')
   end subroutine eigenvalues_tests

   !> A reflection of a block triangular matrix: pairs on the unit circle and inside, real ones between, couplings above.
   subroutine known(tests, n)
      class(tests_type), intent(inout) :: tests
      integer, intent(in) :: n
      real(dp) :: a(n, n), v(n)
      complex(dp) :: expected(n), values(n)
      real(dp) :: worst
      integer :: i, j, info

      do j = 1, n
         do i = 1, n
            a(i, j) = merge(sin(real(i + 5*j, dp)), 0.0_dp, j > i)
         end do
         a(j, j) = 1 - 0.9_dp*j/n
         expected(j) = a(j, j)
      end do
      do i = 1, n - 1, 3
         a(i:i + 1, i:i + 1) = (1 - 0.5_dp*i/n)*reshape([0.6_dp, -0.8_dp, 0.8_dp, 0.6_dp], [2, 2])
         expected(i:i + 1) = (1 - 0.5_dp*i/n)*[(0.6_dp, 0.8_dp), (0.6_dp, -0.8_dp)]
      end do
      ! Couplings that grow with n would make the eigenvalues ill-conditioned: that is not what is tried here.
      do j = 1, n
         do i = 1, j - 2
            a(i, j) = a(i, j)/n
         end do
      end do
      v = [(cos(real(i, dp)), i=1, n)]
      v = v/norm2(v)
      a = a - 2*spread(v, 2, n)*spread(matmul(v, a), 1, n)
      a = a - 2*spread(matmul(a, v), 2, n)*spread(v, 1, n)
      call find_eigenvalues(n, a, values, info)
      call tests%is_true(info == 0, 'converges')
      worst = 0
      do i = 1, n
         worst = max(worst, minval(abs(values - expected(i))))
      end do
      call tests%is_close(worst, 0.0_dp, 1e-12_dp, 'known eigenvalues')
   end subroutine known

end module unit_eigenvalues
