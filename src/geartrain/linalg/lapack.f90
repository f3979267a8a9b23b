!> Interfaces of the LAPACK and BLAS routines in use (fpm refuses implicit interfaces).
module geartrain_linalg_lapack
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: dgeev, dgehrd, dgels, dgemm, dgemv, dgetrf, dgetrs, dhsein, dhseqr, dormhr, dsbevd

   interface
      !> LU factors of a general matrix.
      pure subroutine dgetrf(m, n, a, lda, ipiv, info)
         import :: dp
         implicit none (type, external)
         !> Rows, columns, leading dimension.
         integer, intent(in) :: m, n, lda
         !> The matrix, then its factors.
         real(dp), intent(inout) :: a(lda, *)
         !> Row exchanges; 0: regular.
         integer, intent(out) :: ipiv(*), info
      end subroutine dgetrf

      !> Solves with the factors of dgetrf.
      pure subroutine dgetrs(trans, n, nrhs, a, lda, ipiv, b, ldb, info)
         import :: dp
         implicit none (type, external)
         !> 'N': a x = b, 'T': transpose(a) x = b.
         character, intent(in) :: trans
         !> Rows, right-hand sides, leading dimensions, row exchanges.
         integer, intent(in) :: n, nrhs, lda, ldb, ipiv(*)
         !> Factors of dgetrf.
         real(dp), intent(in) :: a(lda, *)
         !> Right-hand sides, then solutions.
         real(dp), intent(inout) :: b(ldb, *)
         !> 0: the arguments are valid.
         integer, intent(out) :: info
      end subroutine dgetrs

      !> Eigenvalues and eigenvectors of a general matrix.
      pure subroutine dgeev(jobvl, jobvr, n, a, lda, wr, wi, vl, ldvl, vr, ldvr, work, lwork, info)
         import :: dp
         implicit none (type, external)
         !> 'V': left, right eigenvectors are wanted, 'N': not.
         character, intent(in) :: jobvl, jobvr
         !> Rows, leading dimensions, size of `work`.
         integer, intent(in) :: n, lda, ldvl, ldvr, lwork
         !> The matrix, destroyed; left and right eigenvectors; work space.
         real(dp), intent(inout) :: a(lda, *), vl(ldvl, *), vr(ldvr, *), work(*)
         !> Real and imaginary parts of the eigenvalues, (n).
         real(dp), intent(out) :: wr(*), wi(*)
         !> 0: converged.
         integer, intent(out) :: info
      end subroutine dgeev

      !> Least squares or least norm of a matrix of full rank.
      pure subroutine dgels(trans, m, n, nrhs, a, lda, b, ldb, work, lwork, info)
         import :: dp
         implicit none (type, external)
         !> 'N': a x = b, 'T': transpose(a) x = b.
         character, intent(in) :: trans
         !> Rows, columns, right-hand sides, leading dimensions, size of `work`.
         integer, intent(in) :: m, n, nrhs, lda, ldb, lwork
         !> The matrix, destroyed; right-hand sides, then solutions; work space.
         real(dp), intent(inout) :: a(lda, *), b(ldb, *), work(*)
         !> 0: full rank.
         integer, intent(out) :: info
      end subroutine dgels

      !> Reduces a general matrix to Hessenberg form.
      pure subroutine dgehrd(n, ilo, ihi, a, lda, tau, work, lwork, info)
         import :: dp
         implicit none (type, external)
         !> Rows; first and last row of what is to be reduced, leading dimension, size of `work`.
         integer, intent(in) :: n, ilo, ihi, lda, lwork
         !> The matrix, then its Hessenberg form and, below it, reflections; work space.
         real(dp), intent(inout) :: a(lda, *), work(*)
         !> Factors of the reflections, (n - 1).
         real(dp), intent(out) :: tau(*)
         !> 0: the arguments are valid.
         integer, intent(out) :: info
      end subroutine dgehrd

      !> Eigenvalues of a Hessenberg matrix.
      pure subroutine dhseqr(job, compz, n, ilo, ihi, h, ldh, wr, wi, z, ldz, work, lwork, info)
         import :: dp
         implicit none (type, external)
         !> 'E': eigenvalues alone; 'N': no Schur vectors.
         character, intent(in) :: job, compz
         !> Rows; first and last row of what is not yet triangular, leading dimensions, size of `work`.
         integer, intent(in) :: n, ilo, ihi, ldh, ldz, lwork
         !> The matrix, destroyed; Schur vectors; work space.
         real(dp), intent(inout) :: h(ldh, *), z(ldz, *), work(*)
         !> Real and imaginary parts of the eigenvalues, (n).
         real(dp), intent(out) :: wr(*), wi(*)
         !> 0: converged.
         integer, intent(out) :: info
      end subroutine dhseqr

      !> Some eigenvectors of a Hessenberg matrix by inverse iteration.
      pure subroutine dhsein(side, eigsrc, initv, select, n, h, ldh, wr, wi, vl, ldvl, vr, ldvr, mm, m, work, ifaill, ifailr, info)
         import :: dp
         implicit none (type, external)
         !> 'R': right eigenvectors; 'Q': of eigenvalues that dhseqr found; 'N': from any vectors.
         character, intent(in) :: side, eigsrc, initv
         !> Of which eigenvalues: of a pair, the first, (n).
         logical, intent(inout) :: select(*)
         !> Rows, leading dimensions, room for columns of vectors.
         integer, intent(in) :: n, ldh, ldvl, ldvr, mm
         !> The matrix; imaginary parts of the eigenvalues, (n).
         real(dp), intent(in) :: h(ldh, *), wi(*)
         !> Real parts, those of close eigenvalues moved apart, (n); left and right vectors; work space, (n*(n + 2)).
         real(dp), intent(inout) :: wr(*), vl(ldvl, *), vr(ldvr, *), work(*)
         !> Columns in use; 0: the left, the right vector converged, (mm); 0: all did.
         integer, intent(out) :: m, ifaill(*), ifailr(*), info
      end subroutine dhsein

      !> Multiplies a matrix by the reflections of dgehrd.
      pure subroutine dormhr(side, trans, m, n, ilo, ihi, a, lda, tau, c, ldc, work, lwork, info)
         import :: dp
         implicit none (type, external)
         !> 'L': from the left; 'N': as they are, 'T': transposed.
         character, intent(in) :: side, trans
         !> Rows and columns of c, then as in dgehrd.
         integer, intent(in) :: m, n, ilo, ihi, lda, ldc, lwork
         !> Reflections and their factors.
         real(dp), intent(in) :: a(lda, *), tau(*)
         !> The matrix; work space.
         real(dp), intent(inout) :: c(ldc, *), work(*)
         !> 0: the arguments are valid.
         integer, intent(out) :: info
      end subroutine dormhr

      !> c := alpha a b + beta c
      pure subroutine dgemm(transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
         import :: dp
         implicit none (type, external)
         !> 'N': the matrix, 'T': its transpose.
         character, intent(in) :: transa, transb
         !> Rows and columns of c, columns of a, leading dimensions.
         integer, intent(in) :: m, n, k, lda, ldb, ldc
         !> Factors and matrices.
         real(dp), intent(in) :: alpha, beta, a(lda, *), b(ldb, *)
         !> (m, n)
         real(dp), intent(inout) :: c(ldc, *)
      end subroutine dgemm

      !> y := alpha a x + beta y
      pure subroutine dgemv(trans, m, n, alpha, a, lda, x, incx, beta, y, incy)
         import :: dp
         implicit none (type, external)
         !> 'N': the matrix, 'T': its transpose.
         character, intent(in) :: trans
         !> Rows and columns of a, leading dimension, strides of x and y.
         integer, intent(in) :: m, n, lda, incx, incy
         !> Factors, matrix, vector.
         real(dp), intent(in) :: alpha, beta, a(lda, *), x(*)
         !> Vector.
         real(dp), intent(inout) :: y(*)
      end subroutine dgemv

      !> Eigenvalues and eigenvectors of a symmetric band matrix.
      pure subroutine dsbevd(jobz, uplo, n, kd, ab, ldab, w, z, ldz, work, lwork, iwork, liwork, info)
         import :: dp
         implicit none (type, external)
         !> 'V': eigenvectors are wanted, 'N': not; 'U': the upper, 'L': the lower triangle is given.
         character, intent(in) :: jobz, uplo
         !> Rows, diagonals beside the main diagonal, leading dimensions, sizes of the work space.
         integer, intent(in) :: n, kd, ldab, ldz, lwork, liwork
         !> Diagonals of the matrix, destroyed, (kd + 1, n); eigenvectors, (n, n); work space.
         real(dp), intent(inout) :: ab(ldab, *), z(ldz, *), work(*)
         !> Whole numbers of the work space.
         integer, intent(inout) :: iwork(*)
         !> Eigenvalues, ascending, (n).
         real(dp), intent(out) :: w(*)
         !> 0: converged.
         integer, intent(out) :: info
      end subroutine dsbevd
   end interface

end module geartrain_linalg_lapack
