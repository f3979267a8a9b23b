!> LU factors of square matrices. Up to 32 rows plain loops are several times faster than LAPACK, whose calls, packing and threads
!> are made for large matrices; LAPACK takes the larger matrices.
module geartrain_linalg_elimination
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_lapack, only: dgetrf, dgetrs
   implicit none (type, external)
   private
   public :: determinant_sign, factor_matrix, solve_factored

   !> Most rows of a matrix that plain loops eliminate; most columns that are solved for at a time.
   integer, parameter :: most_rows = 32, most_columns = 32

contains

   !> LU factors in place, with row exchanges.
   pure subroutine factor_matrix(n, a, pivot, info)
      !> Number of rows.
      integer, intent(in) :: n
      !> The matrix, (row, column), then its factors as LAPACK has them.
      real(dp), intent(inout) :: a(n, n)
      !> Row k was exchanged with row pivot(k), (row); 0: regular, k: pivot k is 0 or not finite.
      integer, intent(out) :: pivot(n), info
      real(dp) :: held, largest
      integer :: i, j, k, p

      if (n > most_rows) then
         call dgetrf(n, n, a, n, pivot, info)
         ! LAPACK does not look for NaN, of which some libraries make pivots that are no rows.
         if (info == 0) info = findloc([(abs(a(k, k)) <= huge(held), k=1, n)], .false., 1)
         return
      end if
      info = 0
      do k = 1, n
         p = k
         largest = abs(a(k, k))
         do i = k + 1, n
            if (abs(a(i, k)) > largest) then
               largest = abs(a(i, k))
               p = i
            end if
         end do
         pivot(k) = p
         if (.not. largest > tiny(largest)) then
            info = k
            return
         end if
         if (p /= k) then
            do j = 1, n
               held = a(k, j)
               a(k, j) = a(p, j)
               a(p, j) = held
            end do
         end if
         held = 1/a(k, k)
         do i = k + 1, n
            a(i, k) = held*a(i, k)
         end do
         do j = k + 1, n
            do i = k + 1, n
               a(i, j) = a(i, j) - a(k, j)*a(i, k)
            end do
         end do
      end do
   end subroutine factor_matrix

   !> Sign of the determinant of a matrix factored by `factor_matrix`.
   pure integer function determinant_sign(a, pivot)
      !> Its factors.
      real(dp), intent(in) :: a(:, :)
      !> Exchanges of rows, (row).
      integer, intent(in) :: pivot(:)
      integer :: i

      determinant_sign = 1
      do i = 1, size(pivot)
         if ((pivot(i) /= i) .neqv. (a(i, i) < 0)) determinant_sign = -determinant_sign
      end do
   end function determinant_sign

   !> Solves in place with the factors of `factor_matrix`.
   pure subroutine solve_factored(n, columns, a, pivot, b)
      !> Number of rows; number of right-hand sides; row exchanges of `factor_matrix`.
      integer, intent(in) :: n, columns, pivot(n)
      !> Factors of `factor_matrix`.
      real(dp), intent(in) :: a(n, n)
      !> Right-hand sides, then solutions, (row, column).
      real(dp), intent(inout) :: b(n, columns)
      integer :: first, info

      if (n > most_rows) then
         call dgetrs('N', n, columns, a, n, pivot, b, n, info)
         return
      end if
      if (columns == 1) then
         call solve_column(n, a, pivot, b)
         return
      end if
      do first = 1, columns, most_columns
         call solve_columns(n, min(most_columns, columns - first + 1), a, pivot, b(1, first))
      end do
   end subroutine solve_factored

   !> Solves for several columns: the inner loops run over the columns.
   pure subroutine solve_columns(n, columns, a, pivot, b)
      integer, intent(in) :: n, columns, pivot(n)
      real(dp), intent(in) :: a(n, n)
      real(dp), intent(inout) :: b(n, columns)
      real(dp) :: rows(most_columns, most_rows), held
      integer :: i, k

      rows(:columns, :n) = transpose(b)
      do k = 1, n
         if (pivot(k) == k) cycle
         do i = 1, columns
            held = rows(i, k)
            rows(i, k) = rows(i, pivot(k))
            rows(i, pivot(k)) = held
         end do
      end do
      do k = 1, n - 1
         do i = k + 1, n
            call subtract(columns, a(i, k), rows(:, k), rows(:, i))
         end do
      end do
      do k = n, 1, -1
         held = 1/a(k, k)
         rows(:columns, k) = held*rows(:columns, k)
         do i = 1, k - 1
            call subtract(columns, a(i, k), rows(:, k), rows(:, i))
         end do
      end do
      b = transpose(rows(:columns, :n))
   end subroutine solve_columns

   !> from := from - factor row.
   pure subroutine subtract(columns, factor, row, from)
      integer, intent(in) :: columns
      real(dp), intent(in) :: factor, row(columns)
      real(dp), intent(inout) :: from(columns)
      integer :: i

      !GCC$ unroll 1
      do i = 1, columns
         from(i) = from(i) - factor*row(i)
      end do
   end subroutine subtract

   !> Solves for one column.
   pure subroutine solve_column(n, a, pivot, b)
      integer, intent(in) :: n, pivot(n)
      real(dp), intent(in) :: a(n, n)
      real(dp), intent(inout) :: b(n)
      real(dp) :: held
      integer :: i, k

      do k = 1, n
         held = b(k)
         b(k) = b(pivot(k))
         b(pivot(k)) = held
      end do
      do k = 1, n - 1
         do i = k + 1, n
            b(i) = b(i) - b(k)*a(i, k)
         end do
      end do
      do k = n, 1, -1
         b(k) = b(k)/a(k, k)
         do i = 1, k - 1
            b(i) = b(i) - b(k)*a(i, k)
         end do
      end do
   end subroutine solve_column

end module geartrain_linalg_elimination
