!> The cubic through two values with their derivatives.
module geartrain_linalg_cubic
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: highest_share, share_at, value_on

contains

   !> Where between its ends a cubic has a maximum, as a share of the interval; -1: nowhere.
   pure real(dp) function highest_share(y, slope) result(share)
      !> Values at both ends, and derivatives times the length of the interval.
      real(dp), intent(in) :: y(2), slope(2)
      real(dp) :: square, linear, discriminant

      ! The derivative is square t**2 + linear t + slope(1).
      square = 3*(slope(1) + slope(2)) - 6*(y(2) - y(1))
      linear = 6*(y(2) - y(1)) - 4*slope(1) - 2*slope(2)
      discriminant = linear**2 - 4*square*slope(1)
      share = -1
      if (discriminant <= 0) return
      if (linear < 0) then
         share = 2*slope(1)/(sqrt(discriminant) - linear)
      else if (abs(square) > 0) then
         share = -(linear + sqrt(discriminant))/(2*square)
      end if
      if (share > 1 .or. share < 0) share = -1
   end function highest_share

   !> Value of a cubic at a share of the interval.
   pure real(dp) function value_on(y, slope, share) result(value)
      !> Values at both ends, and derivatives times the length of the interval; share of the interval.
      real(dp), intent(in) :: y(2), slope(2), share

      associate (t => share)
         value = (1 - t)**2*((1 + 2*t)*y(1) + t*slope(1)) + t**2*((3 - 2*t)*y(2) - (1 - t)*slope(2))
      end associate
   end function value_on

   !> Share of the interval at which a cubic has a value that lies between those at its ends.
   pure real(dp) function share_at(y, slope, value) result(share)
      !> Values at both ends, and derivatives times the length of the interval; the value.
      real(dp), intent(in) :: y(2), slope(2), value
      real(dp) :: low, high
      integer :: i

      low = 0
      high = 1
      do i = 1, digits(1.0_dp)
         share = (low + high)/2
         if ((value_on(y, slope, share) < value) .eqv. (y(1) < y(2))) then
            low = share
         else
            high = share
         end if
      end do
      if (abs(value - y(1)) <= 0) share = 0
      if (abs(value - y(2)) <= 0) share = 1
   end function share_at

end module geartrain_linalg_cubic
