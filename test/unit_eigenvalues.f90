!> Eigenvalues of matrices that are made from known ones, for sizes on both sides of the change to LAPACK.
module unit_eigenvalues
   use geartrain, only: dp
   use geartrain_linalg_eigenvalues, only: find_eigenvalues
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: eigenvalues_tests

   !> Computed eigenvalues are those of a matrix that differs by a small multiple of n epsilon |a| (J. H. Wilkinson, The Algebraic
   !> Eigenvalue Problem, 1965, chapter 8): that multiple. Measured: 0.4 at most, whatever the kernels of the BLAS.
   real(dp), parameter :: rounding = 2
   !> Roundings of an entry by which the matrix itself is off: of two reflections, three products each.
   integer, parameter :: reflections = 6

   interface
      !> Singular value decomposition of a general matrix (LAPACK).
      subroutine dgesvd(jobu, jobvt, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork, info)
         import :: dp
         implicit none (type, external)
         character, intent(in) :: jobu, jobvt
         integer, intent(in) :: m, n, lda, ldu, ldvt, lwork
         real(dp), intent(inout) :: a(lda, *)
         real(dp), intent(out) :: s(*), u(ldu, *), vt(ldvt, *), work(*)
         integer, intent(out) :: info
      end subroutine dgesvd
   end interface

contains

   subroutine eigenvalues_tests(tests)
      class(tests_type), intent(inout) :: tests
      real(dp) :: a(4, 4)
      complex(dp) :: values(4)
      integer :: info

      if (tests%runs('known')) then
         call known(tests, 1)
         call known(tests, 2)
         call known(tests, 3)
         call known(tests, 10)
         call known(tests, 32)
         call known(tests, 33)
      end if
      if (tests%runs('cyclic_permutation')) then
         ! A cyclic permutation: all roots of 1, on which unshifted steps would turn for ever.
         a = 0
         a(2, 1) = 1
         a(3, 2) = 1
         a(4, 3) = 1
         a(1, 4) = 1
         call find_eigenvalues(4, a, values, info)
         call tests%is_true(info == 0, 'cyclic permutation converges')
         call tests%is_close(maxval(abs(values**4 - 1)), 0.0_dp, 1e-14_dp, 'its eigenvalues are the roots of 1')
      end if
   end subroutine eigenvalues_tests

   !> A reflection of a block triangular matrix: pairs on the unit circle and inside, real ones between, couplings above.
   subroutine known(tests, n)
      class(tests_type), intent(inout) :: tests
      integer, intent(in) :: n
      real(dp) :: a(n, n), kept(n, n), v(n)
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
      kept = a
      call find_eigenvalues(n, a, values, info)
      call tests%is_true(info == 0, 'converges')
      worst = 0
      do i = 1, n
         worst = max(worst, minval(abs(values - expected(i)))/condition(kept, expected(i)))
      end do
      call tests%is_close(worst, 0.0_dp, rounding*(n + reflections)*epsilon(worst)*norm2(kept), &
                          'known eigenvalues, over their condition numbers, n = '//achar(48 + n/10)//achar(48 + mod(n, 10)))
   end subroutine known

   !> Condition number of a simple eigenvalue [1]: 1/|x^H y|, x and y its left and right eigenvectors of unit length (G. W. Stewart
   !> and J. Sun, Matrix Perturbation Theory, 1990, section IV.2), which are the singular vectors of a - value I at its smallest
   !> singular value. As a real matrix of twice the size: OpenBLAS 0.3.21 reads beyond complex arrays in its kernels for AVX-512
   !> (zgemv), and crashes now and then.
   real(dp) function condition(a, value)
      real(dp), intent(in) :: a(:, :)
      complex(dp), intent(in) :: value
      real(dp), dimension(2*size(a, 1), 2*size(a, 1)) :: shifted, left, right
      real(dp) :: work(20*size(a, 1)), singular(2*size(a, 1)), products(2, 2)
      integer :: i, n, info

      n = size(a, 1)
      shifted = 0
      shifted(:n, :n) = a
      shifted(n + 1:, n + 1:) = a
      do i = 1, n
         shifted(i, i) = shifted(i, i) - value%re
         shifted(n + i, n + i) = shifted(n + i, n + i) - value%re
         shifted(i, n + i) = value%im
         shifted(n + i, i) = -value%im
      end do
      call dgesvd('A', 'A', 2*n, 2*n, shifted, 2*n, singular, left, 2*n, right, 2*n, work, size(work), info)
      condition = huge(condition)
      if (info /= 0) return
      ! Each complex vector is a plane of real ones: the products of two bases are |x^H y| times a rotation.
      products = matmul(transpose(left(:, 2*n - 1:)), transpose(right(2*n - 1:, :)))
      condition = sqrt(2.0_dp)/norm2(products)
   end function condition

end module unit_eigenvalues
