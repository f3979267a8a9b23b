!> Leading eigenvalues of a matrix known by its products alone: block Arnoldi, driven from outside: multiply the vectors of
!> `latest`, hand the products to `extend`, ask `ritz` now and then. An eigenvalue is found as often as it is there, up to `block`
!> times.
module geartrain_linalg_arnoldi
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_lapack, only: dgehrd, dhsein, dhseqr, dormhr
   implicit none (type, external)
   private
   public :: arnoldi_type

   !> What orthogonalisation may leave of a product before the space counts as exhausted.
   real(dp), parameter :: nothing = 1e-13_dp
   !> Vectors that are made orthogonal to the others together.
   integer, parameter :: pair = 2

   type :: arnoldi_type
      !> Dimension of the space whose products are known.
      integer :: dimension = 0
      !> Vectors that are multiplied at a time, an even number.
      integer :: block = 0
      integer, private :: n = 0
      !> Orthonormal basis, (n, most + block); products of the basis in it, (most + block, most).
      real(dp), allocatable, private :: basis(:, :), projected(:, :)
      !> Real and imaginary part of the eigenvector of the projection for the first value of the latest `ritz`, (dimension, part).
      real(dp), allocatable, private :: vector(:, :)
   contains
      procedure :: begin
      procedure :: begin_with
      procedure :: latest
      procedure :: extend
      procedure :: ritz
      procedure :: leading_vector
   end type arnoldi_type

   !> In project_out.c, where its arguments are described.
   interface
      pure subroutine project_out(n, m, basis, pair, factor, again) bind(c, name='geartrain_project_out')
         import :: c_double, c_int
         implicit none (type, external)
         integer(c_int), value :: n, m
         real(c_double), intent(in) :: basis(n, *)
         real(c_double), intent(inout) :: pair(n, *), factor(m, *), again(m, *)
      end subroutine project_out
   end interface

contains

   !> Begins a space with the same vectors every time.
   subroutine begin(self, n, most, block)
      class(arnoldi_type), intent(inout) :: self
      !> Rows of the matrix; most dimensions, a multiple of `block`; vectors that are multiplied at a time, an even number.
      integer, intent(in) :: n, most, block
      integer :: i, k
      logical :: independent

      if (allocated(self%basis)) then
         if (any(shape(self%basis) /= [n, most + block])) deallocate (self%basis, self%projected)
      end if
      if (.not. allocated(self%basis)) allocate (self%basis(n, most + block), self%projected(most + block, most))
      self%n = n
      self%block = block
      self%dimension = 0
      self%projected = 0
      ! Any vectors will do that have a share of every eigenvector; always the same, so that results do not depend on history.
      do k = 1, block
         do i = 1, n
            self%basis(i, k) = modulo(real(i, dp)*(sqrt(2.0_dp) + k)*sqrt(3.0_dp)*(i + 7*k), 1.0_dp) - 0.5_dp
         end do
      end do
      call orthonormalise(self, 0, independent)
   end subroutine begin

   !> Begins with other vectors, as products of the matrix with those that it began with.
   subroutine begin_with(self, vectors)
      class(arnoldi_type), intent(inout) :: self
      !> Independent vectors, (n, block).
      real(dp), intent(in) :: vectors(:, :)
      logical :: independent

      self%basis(:, :self%block) = vectors
      call orthonormalise(self, 0, independent)
   end subroutine begin_with

   !> The vectors whose products are wanted.
   pure subroutine latest(self, vectors)
      class(arnoldi_type), intent(in) :: self
      !> Orthonormal vectors, (n, block).
      real(dp), intent(out) :: vectors(:, :)

      vectors = self%basis(:, self%dimension + 1:self%dimension + self%block)
   end subroutine latest

   !> Takes the products of the latest vectors. Not independent: the space cannot be extended.
   subroutine extend(self, products, independent)
      class(arnoldi_type), intent(inout) :: self
      !> Products of the matrix with the vectors of `latest`, (n, block).
      real(dp), intent(in) :: products(:, :)
      !> The products do not lie in the space.
      logical, intent(out) :: independent
      integer :: m

      m = self%dimension + self%block
      self%basis(:, m + 1:m + self%block) = products
      self%dimension = m
      call orthonormalise(self, m, independent)
   end subroutine extend

   !> Makes the block of vectors after the first m orthonormal to them and to each other; the factors go into the projection.
   !> Twice is enough (Kahan and Parlett), and needed: what is left of a long product grows from block to block.
   subroutine orthonormalise(self, m, independent)
      class(arnoldi_type), intent(inout) :: self
      integer, intent(in) :: m
      logical, intent(out) :: independent
      real(dp) :: factors(m, pair), again(m, pair), length, before
      integer :: i, j, k, turn

      independent = .true.
      associate (v => self%basis, h => self%projected, block => self%block)
         if (m > 0) then
            do k = m + 1, m + block, pair
               call project_out(self%n, m, v, v(:, k:k + 1), factors, again)
               h(:m, k - block:k - block + 1) = factors
            end do
         end if
         do k = m + 1, m + block
            before = norm2(v(:, k))
            do turn = 1, 2
               do j = m + 1, k - 1
                  length = dot_product(v(:, j), v(:, k))
                  v(:, k) = v(:, k) - length*v(:, j)
                  if (m > 0) h(j, k - block) = h(j, k - block) + length
               end do
            end do
            length = norm2(v(:, k))
            independent = independent .and. length > nothing*before .and. length > nothing
            if (.not. independent) return
            do i = 1, self%n
               v(i, k) = v(i, k)/length
            end do
            if (m > 0) h(k, k - block) = length
         end do
      end associate
   end subroutine orthonormalise

   !> The eigenvalues of largest magnitude in the space, largest first, and of each the residual |A x - value x| of a unit vector x.
   !> Of all eigenvectors of the projection only those are found, by inverse iteration.
   subroutine ritz(self, values, residuals)
      class(arnoldi_type), intent(inout) :: self
      !> Eigenvalues, as many as are wanted, (value).
      complex(dp), intent(out) :: values(:)
      !> Residual of each value, (value); huge where there are not so many values yet, or LAPACK fails.
      real(dp), intent(out) :: residuals(:)
      real(dp), dimension(self%dimension, self%dimension) :: h, copy
      real(dp) :: vectors(self%dimension, size(values) + 1), work((self%dimension + 40)*self%dimension), empty(1, 1), length
      real(dp), dimension(self%dimension) :: re, im, factors
      complex(dp) :: tail(self%block)
      logical :: left(self%dimension), wanted(self%dimension)
      integer :: column(self%dimension), place(size(values)), unused(1), failed(size(values) + 1), i, k, m, info

      m = self%dimension
      values = 0
      residuals = huge(1.0_dp)
      if (m < size(values)) return
      h = self%projected(:m, :m)
      call dgehrd(m, 1, m, h, m, factors, work, size(work), info)
      copy = h
      call dhseqr('E', 'N', m, 1, m, copy, m, re, im, empty, 1, work, size(work), info)
      if (info /= 0) return
      left = .true.
      wanted = .false.
      do i = 1, size(values)
         k = maxloc(hypot(re, im), 1, left)
         left(k) = .false.
         values(i) = cmplx(re(k), im(k), dp)
         ! A pair has its real part in one column and the imaginary part in the next.
         place(i) = merge(k - 1, k, im(k) < 0)
         wanted(place(i)) = .true.
      end do
      k = 1
      do i = 1, m
         column(i) = k
         if (wanted(i)) k = k + merge(2, 1, abs(im(i)) > 0)
      end do
      call dhsein('R', 'Q', 'N', wanted, m, h, m, re, im, empty, 1, vectors, m, size(vectors, 2), k, work, unused, failed, info)
      if (info /= 0) return
      call dormhr('L', 'N', m, k, 1, m, h, m, factors, vectors, m, work, size(work), info)
      associate (last => vectors(m - self%block + 1:, :), &
                 next => self%projected(m + 1:m + self%block, m - self%block + 1:m))
         do i = 1, size(values)
            k = column(place(i))
            if (abs(values(i)%im) > 0) then
               length = norm2(vectors(:, k:k + 1))
               tail = cmplx(last(:, k), last(:, k + 1), dp)
            else
               length = norm2(vectors(:, k))
               tail = last(:, k)
            end if
            residuals(i) = norm2(abs(matmul(next, tail)))/length
            if (i > 1) cycle
            self%vector = vectors(:, k:k + 1)/length
            if (.not. abs(values(i)%im) > 0) self%vector(:, 2) = 0
         end do
      end associate
   end subroutine ritz

   !> Real and imaginary part of the eigenvector of the first value of the latest `ritz` (or of its conjugate).
   subroutine leading_vector(self, vector)
      class(arnoldi_type), intent(in) :: self
      !> Real and imaginary part of a unit vector, (n, part).
      real(dp), intent(out) :: vector(:, :)

      vector = matmul(self%basis(:, :self%dimension), self%vector)
   end subroutine leading_vector

end module geartrain_linalg_arnoldi
