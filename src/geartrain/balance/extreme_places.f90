!> Where a periodic function is largest or smallest, and the derivative of the extreme with respect to a parameter: to first order
!> that of the function there. Where two extremes are equal and their derivatives are not, there is none.
module geartrain_balance_extreme_places
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use geartrain_base_kinds, only: dp, pi
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: evaluate, least_height, next_maximum, sample
   implicit none (type, external)
   private
   public :: place_type, agreed, find_places, most_places, rate_at

   !> Difference of two extremes relative to their magnitude, and of their derivatives, up to which they count as equal.
   real(dp), parameter :: equal = 1e-9_dp, equal_rate = 1e-6_dp
   integer, parameter :: most_places = 64

   !> Where a function is extreme.
   type :: place_type
      !> Number of places whose values are equal; the value.
      integer :: count = 0
      real(dp) :: value = -huge(1.0_dp)
      !> theta = Lambda t/eta [rad]; of a mesh force the region of the law, and the contact event, 0: none.
      real(dp) :: theta(most_places) = 0
      integer :: region(most_places) = 0, event(most_places) = 0
   contains
      procedure :: add
   end type place_type

contains

   !> Takes up a place where the value is largest so far, or equal to the largest.
   pure subroutine add(self, value, theta, region, event)
      class(place_type), intent(inout) :: self
      !> Value, and theta [rad].
      real(dp), intent(in) :: value, theta
      !> Region of the law and number of the contact event, of a mesh force.
      integer, intent(in) :: region, event

      if (value > self%value + equal*abs(value)) self%count = 0
      if (value < self%value - equal*abs(value) .or. self%count == most_places) return
      self%count = self%count + 1
      self%value = value
      self%theta(self%count) = theta
      self%region(self%count) = region
      self%event(self%count) = event
   end subroutine add

   !> Finds the places of the largest side*f, f by its coefficients.
   subroutine find_places(u, harmonic, transform, side, places)
      !> Coefficients, (1 + 2*harmonics).
      real(dp), intent(in) :: u(:)
      !> Orders, ascending, (harmonics).
      integer, intent(in) :: harmonic(:)
      !> Planned for `fine_samples`; its samples are overwritten.
      type(transform_type), intent(inout) :: transform
      !> +1 for the largest, -1 for the smallest value.
      integer, intent(in) :: side
      !> The places; none where f is constant.
      type(place_type), intent(out) :: places
      real(dp) :: theta, value(0:2), correction, least
      integer :: i, q

      call sample(u, harmonic, transform)
      least = least_height(transform%sample, side)
      q = 0
      do
         call next_maximum(transform%sample, side, least, q, theta)
         if (q == 0) exit
         do i = 1, 12
            call evaluate(u, harmonic, theta, value(0), value(1), value(2))
            if (side*value(2) >= 0) exit
            correction = -value(1)/value(2)
            theta = theta + max(-2*pi/transform%samples, min(2*pi/transform%samples, correction))
            if (abs(correction) < 1e-9_dp) exit
         end do
         call evaluate(u, harmonic, theta, value(0), value(1), value(2))
         call places%add(side*value(0), theta, 0, 0)
      end do
   end subroutine find_places

   !> Derivative of side*f where side*f is largest, times side.
   real(dp) function rate_at(places, harmonic, d)
      !> Places from `find_places`.
      type(place_type), intent(in) :: places
      !> Orders, ascending, (harmonics).
      integer, intent(in) :: harmonic(:)
      !> Derivative of the coefficients, (1 + 2*harmonics).
      real(dp), intent(in) :: d(:)
      real(dp) :: value(most_places), slope, curvature
      integer :: i

      do i = 1, places%count
         call evaluate(d, harmonic, places%theta(i), value(i), slope, curvature)
      end do
      ! A constant: what begins to alternate has its extremes anywhere.
      if (places%count == 0) value(:2) = d(1) + [1, -1]*norm2(d(2:))
      rate_at = agreed(value(:merge(places%count, 2, places%count > 0)), norm2(d))
   end function rate_at

   !> The derivative at equal extremes; NaN where they do not agree.
   pure real(dp) function agreed(value, scale)
      !> Derivatives; magnitude of what they are made of.
      real(dp), intent(in) :: value(:), scale

      agreed = sum(value)/size(value)
      if (maxval(value) - minval(value) > equal_rate*max(scale, maxval(abs(value)))) agreed = ieee_value(agreed, ieee_quiet_nan)
   end function agreed

end module geartrain_balance_extreme_places
