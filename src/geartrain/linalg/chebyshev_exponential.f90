!> Economised power series of exp(z) on ellipses along the imaginary axis; a Taylor series of equal accuracy has half as many terms
!> again. With f the focal length, exp(z) = J_0(f) + 2 sum over k of J_k(f) U_k(z), U_(k+1) = (2 z/f) U_k + U_(k-1) (Chebyshev
!> polynomials of z/(i f)), cut where the terms fall below a tolerance everywhere on the ellipse.
module geartrain_linalg_chebyshev_exponential
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: chebyshev_exponential_type

   type :: chebyshev_exponential_type
      !> Largest |Im z| of each series [1], ascending, (series).
      real(dp), allocatable :: reach(:)
      !> Degree of the polynomial of each series, (series).
      integer, allocatable :: degree(:)
      !> Coefficients of the powers of z, (0:highest degree or more, series).
      real(dp), allocatable :: coefficient(:, :)
   contains
      procedure :: setup
      procedure :: index_of
   end type chebyshev_exponential_type

contains

   !> Makes a series for each ellipse.
   pure subroutine setup(self, reach, aspect, tolerance)
      class(chebyshev_exponential_type), intent(inout) :: self
      !> Largest |Im z| of each series [1], ascending, (series); largest |Re z| over |Im z|, from 0 to below 1; absolute error [1].
      real(dp), intent(in) :: reach(:), aspect, tolerance
      real(dp), allocatable :: bessel(:)
      real(dp) :: growth, focus
      integer :: i, k, most

      self%reach = reach
      growth = (1 + aspect)/sqrt(1 - aspect**2)
      most = 60 + ceiling(4*maxval(reach))
      if (allocated(self%coefficient)) deallocate (self%coefficient, self%degree)
      allocate (self%coefficient(0:most, size(reach)), self%degree(size(reach)), bessel(0:most))
      self%coefficient = 0
      do i = 1, size(reach)
         focus = reach(i)*sqrt(1 - aspect**2)
         bessel = bessel_jn(0, most, focus)
         do k = ceiling(focus), most - 1
            if (2*abs(bessel(k + 1))*growth**(k + 1) < tolerance) exit
         end do
         self%degree(i) = k
         call sum_up(k, focus, bessel, self%coefficient(:, i))
      end do
   end subroutine setup

   !> Adds up the Chebyshev polynomials in powers of z.
   pure subroutine sum_up(degree, focus, bessel, coefficient)
      integer, intent(in) :: degree
      real(dp), intent(in) :: focus, bessel(0:)
      real(dp), intent(inout) :: coefficient(0:)
      real(dp), dimension(0:degree) :: before, now, next
      integer :: k

      now = 0
      now(0) = 1
      before = 0
      coefficient(0) = bessel(0)
      do k = 1, degree
         next = before
         next(1:) = next(1:) + merge(1, 2, k == 1)/focus*now(:degree - 1)
         before = now
         now = next
         coefficient(:degree) = coefficient(:degree) + 2*bessel(k)*now
      end do
   end subroutine sum_up

   !> Number of the first series whose ellipse reaches as far as `reach`; else the last series.
   pure integer function index_of(self, reach)
      class(chebyshev_exponential_type), intent(in) :: self
      !> Largest |Im z| [1].
      real(dp), intent(in) :: reach

      do index_of = 1, size(self%reach) - 1
         if (self%reach(index_of) >= reach) exit
      end do
   end function index_of

end module geartrain_linalg_chebyshev_exponential
