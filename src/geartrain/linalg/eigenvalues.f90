!> Eigenvalues of real matrices, without vectors. Up to 32 rows: balancing by powers of two (Parlett and Reinsch 1969, for matrices
!> whose rows have different units), Householder's reduction to Hessenberg form, then Francis's double steps (Martin, Peters and
!> Wilkinson 1970, procedure hqr), in plain loops that take a sixth of the time of LAPACK, which spends most of it on calls. LAPACK
!> takes larger matrices, and the few matrices on which the double steps do not converge.
module geartrain_linalg_eigenvalues
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_lapack, only: dgeev
   implicit none (type, external)
   private
   public :: find_eigenvalues

   integer, parameter :: most_rows = 32, most_steps = 30, most_sweeps = 30

contains

   !> All eigenvalues of a matrix.
   pure subroutine find_eigenvalues(n, a, values, info)
      !> Number of rows.
      integer, intent(in) :: n
      !> The matrix, (row, column); destroyed.
      real(dp), intent(inout) :: a(n, n)
      !> Eigenvalues in no particular order.
      complex(dp), intent(out) :: values(n)
      !> 0: converged.
      integer, intent(out) :: info
      real(dp) :: copy(most_rows, most_rows), wr(most_rows), wi(most_rows)

      if (n > most_rows) then
         call ask_library(n, a, values, info)
         return
      end if
      copy(:n, :n) = a
      call balance(n, a)
      call reduce(n, a)
      call find_roots(n, a, wr, wi, info)
      values = cmplx(wr(:n), wi(:n), dp)
      if (info == 0) return
      ! LAPACK chooses other shifts. One monodromy matrix of 8000 came here.
      a = copy(:n, :n)
      if (sum(abs(a)) < huge(1.0_dp)) call ask_library(n, a, values, info)
   end subroutine find_eigenvalues

   !> Eigenvalues by LAPACK.
   pure subroutine ask_library(n, a, values, info)
      integer, intent(in) :: n
      real(dp), intent(inout) :: a(n, n)
      complex(dp), intent(out) :: values(n)
      integer, intent(out) :: info
      ! Room for the blocks of 32 columns that dgehrd reduces at a time.
      real(dp) :: wr(n), wi(n), work(34*n + 4300), empty(1, 1)

      call dgeev('N', 'N', n, a, n, wr, wi, empty, 1, empty, 1, work, size(work), info)
      values = cmplx(wr, wi, dp)
   end subroutine ask_library

   !> Scales rows and columns by powers of two, without rounding, until row i and column i have about equal norms.
   pure subroutine balance(n, a)
      integer, intent(in) :: n
      real(dp), intent(inout) :: a(n, n)
      real(dp) :: row, column, factor, total
      integer :: i, sweep
      logical :: done

      do sweep = 1, most_sweeps
         done = .true.
         do i = 1, n
            column = sum(abs(a(:, i))) - abs(a(i, i))
            row = sum(abs(a(i, :))) - abs(a(i, i))
            if (.not. (min(row, column) > 0 .and. max(row, column) < huge(row))) cycle
            factor = row/column
            if (factor >= 0.5_dp .and. factor < 2) cycle
            total = row + column
            factor = scale(1.0_dp, shifta(exponent(factor), 1))
            if (column*factor + row/factor > 0.95_dp*total) cycle
            done = .false.
            a(i, :) = a(i, :)/factor
            a(:, i) = a(:, i)*factor
         end do
         if (done) return
      end do
   end subroutine balance

   !> Reduces a matrix to upper Hessenberg form by reflections I - v v^T with |v|^2 = 2.
   pure subroutine reduce(n, a)
      integer, intent(in) :: n
      real(dp), intent(inout) :: a(n, n)
      real(dp) :: v(most_rows), u(most_rows), length
      integer :: i, j, k

      do k = 1, n - 2
         length = norm2(a(k + 1:, k))
         if (.not. length > tiny(length)) cycle
         v(:k) = 0
         v(k + 1:n) = a(k + 1:, k)/length
         v(k + 1) = v(k + 1) + sign(1.0_dp, v(k + 1))
         v(k + 1:n) = v(k + 1:n)/sqrt(abs(v(k + 1)))
         a(k + 1, k) = -sign(length, v(k + 1))
         a(k + 2:, k) = 0
         do j = k + 1, n
            length = dot_product(v(k + 1:n), a(k + 1:, j))
            do i = k + 1, n
               a(i, j) = a(i, j) - length*v(i)
            end do
         end do
         u(:n) = 0
         do j = k + 1, n
            u(:n) = u(:n) + v(j)*a(:, j)
         end do
         do j = k + 1, n
            a(:, j) = a(:, j) - v(j)*u(:n)
         end do
      end do
   end subroutine reduce

   !> Eigenvalues of a Hessenberg matrix from the last to the first, one or two at a time.
   pure subroutine find_roots(n, a, wr, wi, info)
      integer, intent(in) :: n
      real(dp), intent(inout) :: a(n, n)
      real(dp), intent(out) :: wr(n), wi(n)
      integer, intent(out) :: info
      real(dp) :: shift, size_, x, y, w
      integer :: first, i, last, steps

      info = 0
      wr = 0
      wi = 0
      size_ = sum(abs(a))
      shift = 0
      last = n
      steps = 0
      do while (last >= 1)
         first = first_row(n, a, last, size_)
         x = a(last, last)
         if (first == last) then
            wr(last) = x + shift
            last = last - 1
            steps = 0
            cycle
         end if
         y = a(last - 1, last - 1)
         w = a(last, last - 1)*a(last - 1, last)
         if (first == last - 1) then
            call split(x, y, w, shift, wr(last - 1:last), wi(last - 1:last))
            last = last - 2
            steps = 0
            cycle
         end if
         ! A matrix with a NaN or an infinite element ends here as well.
         if (steps == most_steps .or. .not. size_ < huge(size_)) then
            info = last
            return
         end if
         if (steps == 10 .or. steps == 20) then
            shift = shift + x
            do i = 1, last
               a(i, i) = a(i, i) - x
            end do
            x = 0.75_dp*(abs(a(last, last - 1)) + abs(a(last - 1, last - 2)))
            y = x
            w = -0.4375_dp/0.5625_dp*x**2
         end if
         steps = steps + 1
         call double_step(n, a, first, last, x, y, w)
      end do
   end subroutine find_roots

   !> First row of the last block whose subdiagonal elements are not negligible.
   pure integer function first_row(n, a, last, size_) result(first)
      integer, intent(in) :: n, last
      real(dp), intent(in) :: a(n, n), size_
      real(dp) :: scale

      do first = last, 2, -1
         scale = abs(a(first - 1, first - 1)) + abs(a(first, first))
         if (.not. scale > 0) scale = size_
         if (abs(a(first, first - 1)) <= epsilon(scale)*scale) exit
      end do
   end function first_row

   !> Eigenvalues of the block [y, .; ., x] whose other two entries have the product w.
   pure subroutine split(x, y, w, shift, wr, wi)
      real(dp), intent(in) :: x, y, w, shift
      real(dp), intent(out) :: wr(2), wi(2)
      real(dp) :: half, square, root

      half = (y - x)/2
      square = half**2 + w
      root = sqrt(abs(square))
      wi = 0
      wr = x + shift + half
      if (square < 0) then
         wi = [root, -root]
         return
      end if
      root = half + sign(root, half)
      wr = x + shift + root
      if (abs(root) > 0) wr(2) = x + shift - w/root
   end subroutine split

   !> One double step on rows first..last, with the shifts that are the eigenvalues of the block (x, y, w).
   pure subroutine double_step(n, a, first, last, x, y, w)
      integer, intent(in) :: n, first, last
      real(dp), intent(inout) :: a(n, n)
      real(dp), intent(in) :: x, y, w
      real(dp) :: p, q, r, s, z, scale, alpha, beta, delta
      integer :: i, j, k, m, rows

      do m = last - 2, first, -1
         z = a(m, m)
         r = x - z
         s = y - z
         p = (r*s - w)/a(m + 1, m) + a(m, m + 1)
         q = a(m + 1, m + 1) - z - r - s
         r = a(m + 2, m + 1)
         scale = 1/(abs(p) + abs(q) + abs(r))
         p = p*scale
         q = q*scale
         r = r*scale
         if (m == first) exit
         if (abs(a(m, m - 1))*(abs(q) + abs(r)) <= epsilon(p)*abs(p)*(abs(a(m - 1, m - 1)) + abs(z) + abs(a(m + 1, m + 1)))) exit
      end do
      do i = m + 2, last
         a(i, i - 2) = 0
         if (i > m + 2) a(i, i - 3) = 0
      end do
      do k = m, last - 1
         rows = min(3, last - k + 1)
         if (k > m) then
            p = a(k, k - 1)
            q = a(k + 1, k - 1)
            r = 0
            if (rows == 3) r = a(k + 2, k - 1)
            scale = abs(p) + abs(q) + abs(r)
            if (.not. scale > tiny(scale)) cycle
            s = 1/scale
            p = p*s
            q = q*s
            r = r*s
         end if
         s = sign(sqrt(p**2 + q**2 + r**2), p)
         if (k > m) then
            a(k, k - 1) = -s*scale
         else if (first /= m) then
            a(k, k - 1) = -a(k, k - 1)
         end if
         p = p + s
         s = 1/s
         alpha = p*s
         beta = q*s
         delta = r*s
         s = 1/p
         q = q*s
         r = r*s
         if (rows == 3) then
            do j = k, last
               s = a(k, j) + q*a(k + 1, j) + r*a(k + 2, j)
               a(k, j) = a(k, j) - s*alpha
               a(k + 1, j) = a(k + 1, j) - s*beta
               a(k + 2, j) = a(k + 2, j) - s*delta
            end do
            do i = first, min(last, k + 3)
               s = alpha*a(i, k) + beta*a(i, k + 1) + delta*a(i, k + 2)
               a(i, k) = a(i, k) - s
               a(i, k + 1) = a(i, k + 1) - s*q
               a(i, k + 2) = a(i, k + 2) - s*r
            end do
         else
            do j = k, last
               s = a(k, j) + q*a(k + 1, j)
               a(k, j) = a(k, j) - s*alpha
               a(k + 1, j) = a(k + 1, j) - s*beta
            end do
            do i = first, last
               s = alpha*a(i, k) + beta*a(i, k + 1)
               a(i, k) = a(i, k) - s
               a(i, k + 1) = a(i, k + 1) - s*q
            end do
         end if
      end do
   end subroutine double_step

end module geartrain_linalg_eigenvalues
