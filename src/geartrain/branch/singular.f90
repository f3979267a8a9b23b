!> The matrix that is singular where a branch bifurcates: for a doubling the Jacobian of the balance of twice the period at a motion
!> of the single one, on the odd harmonics, which that motion lacks; for a branch point, where another branch of the same period
!> crosses, that of the balance itself with the tangent as its border.
!>
!> The eigenvectors of its smallest eigenvalues at a place nearby tell the directions apart in which branches may leave: with v one
!> of them, 1/(v . A^-1 v) is smooth along the branch, and zero where that eigenvalue is. They are found from vectors without any
!> symmetry: those of equal stages are orthogonal to any that is alike in all meshes.
module geartrain_branch_singular
   use geartrain_base_eigenvalues, only: find_eigenvalues
   use geartrain_base_elimination, only: factor_matrix, solve_factored
   use geartrain_base_kinds, only: dp
   use geartrain_branch_path, only: place_type
   use geartrain_branch_special_points, only: factor_bordered, generic_vector
   use geartrain_branch_tracer, only: tracer_type
   implicit none (type, external)
   private
   public :: singular_type

   !> Eigenvectors that are looked at, and steps of the iteration that finds them.
   integer, parameter :: most_modes = 3, iterations = 6

   !> The matrix whose singular places are looked for.
   type :: singular_type
      !> The branch's balance, and that of twice the period where it is to double.
      type(tracer_type) :: single, double
      logical :: doubles = .false.
   contains
      procedure :: lift
      procedure :: find_modes
      procedure :: test
      procedure :: solve
      procedure, private :: factor_at
   end type singular_type

contains

   !> Factors of the matrix at a place of the branch. Where it is singular to the last bit its factors are as good as any.
   subroutine factor_at(self, place)
      class(singular_type), intent(inout) :: self
      type(place_type), intent(in) :: place
      type(place_type) :: twice
      logical :: regular

      if (.not. self%doubles) then
         call factor_bordered(self%single%path, place)
         return
      end if
      call self%lift(place, twice)
      associate (path => self%double%path)
         call path%balance%evaluate(twice%u, twice%frequency)
         call path%matrix%linearize(path%balance)
         path%matrix%column = 0
         path%matrix%row = 0
         path%matrix%corner = 1
         call path%matrix%factor(path%balance, regular)
      end associate
   end subroutine factor_at

   !> A motion of the branch as one of twice the period.
   subroutine lift(self, place, twice)
      class(singular_type), intent(in) :: self
      type(place_type), intent(in) :: place
      type(place_type), intent(out) :: twice
      integer :: k, r

      associate (balance => self%double%path%balance, harmonic => self%single%path%balance%harmonic)
         allocate (twice%u(balance%block, balance%unknowns), twice%tangent(balance%block, balance%unknowns), source=0.0_dp)
         twice%u(1, :) = place%u(1, :)
         do k = 1, size(harmonic)
            r = 2*harmonic(k)
            twice%u(2*r:2*r + 1, :) = place%u(2*k:2*k + 1, :)
         end do
         twice%frequency = place%frequency
      end associate
   end subroutine lift

   !> Solves in place with the factors at hand.
   subroutine solve(self, u, y)
      class(singular_type), intent(inout) :: self
      real(dp), intent(inout) :: u(:, :), y

      if (self%doubles) then
         call self%double%path%matrix%solve(self%double%path%balance, u, y)
      else
         call self%single%path%matrix%solve(self%single%path%balance, u, y)
      end if
   end subroutine solve

   !> Unit eigenvectors of the smallest real eigenvalues at a place, smallest first: coefficients (block, unknowns, mode) and Lambda
   !> (mode). Those of a doubling have odd harmonics only.
   subroutine find_modes(self, place, u, y)
      class(singular_type), intent(inout) :: self
      type(place_type), intent(in) :: place
      real(dp), allocatable, intent(out) :: u(:, :, :), y(:)
      real(dp), allocatable :: x(:, :, :), xy(:)
      real(dp) :: reduced(most_modes, most_modes), weight(most_modes, most_modes), length
      integer :: i, j, l, n, rows, columns, found

      call self%factor_at(place)
      if (self%doubles) then
         rows = self%double%path%balance%block
         columns = self%double%path%balance%unknowns
      else
         rows = self%single%path%balance%block
         columns = self%single%path%balance%unknowns
      end if
      n = merge(min(most_modes, 2*columns), most_modes, self%doubles)
      allocate (x(rows, columns, n), xy(n))
      do j = 1, n
         call generic_vector(j, x(:, :, j), xy(j))
         if (self%doubles) call keep_odd(self%double%path%balance%harmonic, x(:, :, j))
         if (self%doubles) xy(j) = 0
      end do
      do i = 0, iterations
         do j = 1, n
            if (i > 0) call self%solve(x(:, :, j), xy(j))
            do l = 1, j - 1
               length = sum(x(:, :, l)*x(:, :, j)) + xy(l)*xy(j)
               x(:, :, j) = x(:, :, j) - length*x(:, :, l)
               xy(j) = xy(j) - length*xy(l)
            end do
            length = sqrt(sum(x(:, :, j)**2) + xy(j)**2)
            x(:, :, j) = x(:, :, j)/length
            xy(j) = xy(j)/length
         end do
      end do
      allocate (u(rows, columns, n), y(n))
      do j = 1, n
         u(:, :, j) = x(:, :, j)
         y(j) = xy(j)
         call self%solve(u(:, :, j), y(j))
         do i = 1, n
            reduced(i, j) = sum(x(:, :, i)*u(:, :, j)) + xy(i)*y(j)
         end do
      end do
      call real_modes(reduced(:n, :n), weight, found)
      do j = 1, found
         u(:, :, j) = 0
         y(j) = 0
         do i = 1, n
            u(:, :, j) = u(:, :, j) + weight(i, j)*x(:, :, i)
            y(j) = y(j) + weight(i, j)*xy(i)
         end do
      end do
      u = u(:, :, :found)
      y = y(:found)
   end subroutine find_modes

   !> Unit eigenvectors of the real eigenvalues of a small matrix, the largest eigenvalue first.
   subroutine real_modes(matrix, vector, found)
      real(dp), intent(in) :: matrix(:, :)
      real(dp), intent(out) :: vector(:, :)
      integer, intent(out) :: found
      complex(dp) :: values(size(matrix, 1))
      real(dp) :: copy(size(matrix, 1), size(matrix, 1)), scale
      integer :: i, j, l, n, info, pivot(size(matrix, 1))

      n = size(matrix, 1)
      copy = matrix
      call find_eigenvalues(n, copy, values, info)
      found = 0
      if (info /= 0) return
      scale = maxval(abs(values))
      do
         i = maxloc(abs(values), 1)
         if (.not. abs(values(i)) > 0) return
         if (abs(values(i)%im) <= 1e-10_dp*scale) then
            found = found + 1
            copy = matrix
            do j = 1, n
               copy(j, j) = copy(j, j) - values(i)%re - 1e-12_dp*scale
            end do
            call factor_matrix(n, copy, pivot, info)
            associate (v => vector(:n, found))
               ! For a double eigenvalue another start gives another vector.
               v = [(cos(real(l*found, dp)), l=1, n)]
               do j = 1, 3
                  call solve_factored(n, 1, copy, pivot, v)
                  v = v/norm2(v)
               end do
            end associate
         end if
         values(i) = 0
      end do
   end subroutine real_modes

   !> Leaves the odd harmonics of a set of coefficients.
   pure subroutine keep_odd(harmonic, u)
      integer, intent(in) :: harmonic(:)
      real(dp), intent(inout) :: u(:, :)
      integer :: k

      u(1, :) = 0
      do k = 1, size(harmonic)
         if (mod(harmonic(k), 2) == 0) u(2*k:2*k + 1, :) = 0
      end do
   end subroutine keep_odd

   !> 1/(v . A^-1 v) at a place for each of the vectors.
   subroutine test(self, place, u, y, f)
      class(singular_type), intent(inout) :: self
      type(place_type), intent(in) :: place
      real(dp), intent(in) :: u(:, :, :), y(:)
      real(dp), intent(out) :: f(:)
      real(dp) :: x(size(u, 1), size(u, 2)), xy
      integer :: j

      call self%factor_at(place)
      do j = 1, size(y)
         x = u(:, :, j)
         xy = y(j)
         call self%solve(x, xy)
         f(j) = 1/(sum(u(:, :, j)*x) + y(j)*xy)
      end do
   end subroutine test

end module geartrain_branch_singular
