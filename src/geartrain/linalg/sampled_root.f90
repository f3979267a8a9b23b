!> Roots of a smooth function between two of its samples, by the polynomial through the values and slopes of six samples: as exact
!> as the function itself where there are eight samples in a period of its highest harmonic, and its high harmonics are small.
module geartrain_linalg_sampled_root
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: sampled_root

   !> Nodes of the polynomial, each twice: with value and slope.
   integer, parameter :: node(*) = [-2, -2, -1, -1, 0, 0, 1, 1, 2, 2, 3, 3]
   integer, parameter :: terms = size(node)

contains

   !> The root in [0, 1], in spacings of the samples from the third node on, by Newton's method kept in the bracket by bisection.
   pure real(dp) function sampled_root(value, slope) result(t)
      !> Values, those of the third and fourth node of different signs; slopes per spacing of the samples, (6).
      real(dp), intent(in) :: value(:), slope(:)
      real(dp) :: c(terms), f, rate, low, high, new
      integer :: i

      call find_polynomial(value, slope, c)
      low = 0
      high = 1
      t = value(3)/(value(3) - value(4))
      do i = 1, 60
         call evaluate_polynomial(c, t, f, rate)
         if ((f > 0) .eqv. (value(3) > 0)) then
            low = t
         else
            high = t
         end if
         new = (low + high)/2
         if (abs(rate)*(high - low) > abs(f)) new = t - f/rate
         if (new < low .or. new > high) new = (low + high)/2
         if (abs(new - t) < 1e-14_dp) exit
         t = new
      end do
   end function sampled_root

   !> Coefficients of Newton's form, by divided differences over nodes that count twice each.
   pure subroutine find_polynomial(value, slope, c)
      real(dp), intent(in) :: value(:), slope(:)
      real(dp), intent(out) :: c(:)
      integer :: k, order, gap

      c = [(value(k), value(k), k=1, size(value))]
      do order = 1, terms - 1
         do k = terms, order + 1, -1
            gap = node(k) - node(k - order)
            if (gap == 0) then
               c(k) = slope(k/2)
            else
               c(k) = (c(k) - c(k - 1))/gap
            end if
         end do
      end do
   end subroutine find_polynomial

   pure subroutine evaluate_polynomial(c, t, f, rate)
      real(dp), intent(in) :: c(:), t
      real(dp), intent(out) :: f, rate
      integer :: k

      f = c(terms)
      rate = 0
      do k = terms - 1, 1, -1
         rate = f + rate*(t - node(k))
         f = c(k) + f*(t - node(k))
      end do
   end subroutine evaluate_polynomial

end module geartrain_linalg_sampled_root
