!> Interfaces of the LAPACK and BLAS routines in use (fpm refuses implicit interfaces).
module geartrain_linalg_lapack
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: dgetrf, dgetrs, dgeev, dgemm, dgemv, dsbev

   interface
      !> LU factors of a general matrix.
      pure subroutine dgetrf(m, n, a, lda, ipiv, info)
         import :: dp
         implicit none (type, external)
         integer, intent(in) :: m, n, lda
         real(dp), intent(inout) :: a(lda, *)
         integer, intent(out) :: ipiv(*), info
      end subroutine dgetrf

      !> Solves with the factors of dgetrf.
      pure subroutine dgetrs(trans, n, nrhs, a, lda, ipiv, b, ldb, info)
         import :: dp
         implicit none (type, external)
         character, intent(in) :: trans
         integer, intent(in) :: n, nrhs, lda, ldb, ipiv(*)
         real(dp), intent(in) :: a(lda, *)
         real(dp), intent(inout) :: b(ldb, *)
         integer, intent(out) :: info
      end subroutine dgetrs

      !> Eigenvalues of a general matrix.
      pure subroutine dgeev(jobvl, jobvr, n, a, lda, wr, wi, vl, ldvl, vr, ldvr, work, lwork, info)
         import :: dp
         implicit none (type, external)
         character, intent(in) :: jobvl, jobvr
         integer, intent(in) :: n, lda, ldvl, ldvr, lwork
         real(dp), intent(inout) :: a(lda, *), vl(ldvl, *), vr(ldvr, *), work(*)
         real(dp), intent(out) :: wr(*), wi(*)
         integer, intent(out) :: info
      end subroutine dgeev

      !> c := alpha a b + beta c
      pure subroutine dgemm(transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
         import :: dp
         implicit none (type, external)
         character, intent(in) :: transa, transb
         integer, intent(in) :: m, n, k, lda, ldb, ldc
         real(dp), intent(in) :: alpha, beta, a(lda, *), b(ldb, *)
         real(dp), intent(inout) :: c(ldc, *)
      end subroutine dgemm

      !> y := alpha a x + beta y
      pure subroutine dgemv(trans, m, n, alpha, a, lda, x, incx, beta, y, incy)
         import :: dp
         implicit none (type, external)
         character, intent(in) :: trans
         integer, intent(in) :: m, n, lda, incx, incy
         real(dp), intent(in) :: alpha, beta, a(lda, *), x(*)
         real(dp), intent(inout) :: y(*)
      end subroutine dgemv

      !> Eigenvalues, ascending, and where asked for eigenvectors of a symmetric band matrix.
      pure subroutine dsbev(jobz, uplo, n, kd, ab, ldab, w, z, ldz, work, info)
         import :: dp
         implicit none (type, external)
         character, intent(in) :: jobz, uplo
         integer, intent(in) :: n, kd, ldab, ldz
         real(dp), intent(inout) :: ab(ldab, *), z(ldz, *), work(*)
         real(dp), intent(out) :: w(*)
         integer, intent(out) :: info
      end subroutine dsbev
   end interface

end module geartrain_linalg_lapack
