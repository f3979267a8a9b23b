!> The largest value of a smooth function from its samples.
module geartrain_flow_sampled_peak
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: peak

contains

   !> Largest value of a sequence, by the polynomial through the largest sample and two neighbours on each side, where all five are
   !> in one region.
   pure real(dp) function peak(p, open, region)
      !> Values at equidistant instants.
      real(dp), intent(in) :: p(:)
      !> The sequence is that of a window; else it repeats itself after its end.
      logical, intent(in) :: open
      !> Number of the region of each value.
      integer, intent(in), optional :: region(:)
      !> Differences from the largest sample.
      real(dp) :: d(-2:2), c(4), x, slope, curvature
      integer :: i, k, n

      n = size(p)
      i = maxloc(p, 1)
      peak = p(i)
      if (open .and. (i < 3 .or. i > n - 2)) return
      if (present(region)) then
         if (any(region([(modulo(i - 1 + k, n) + 1, k=-2, 2)]) /= region(i))) return
      end if
      do k = -2, 2
         d(k) = p(modulo(i - 1 + k, n) + 1) - p(i)
      end do
      ! c(1) x + c(2) x**2 + c(3) x**3 + c(4) x**4, x counting samples from the largest.
      c(1) = (8*(d(1) - d(-1)) - (d(2) - d(-2)))/12
      c(2) = (16*(d(1) + d(-1)) - (d(2) + d(-2)))/24
      c(3) = ((d(2) - d(-2)) - 2*(d(1) - d(-1)))/12
      c(4) = ((d(2) + d(-2)) - 4*(d(1) + d(-1)))/24
      x = 0
      do k = 1, 4
         slope = c(1) + x*(2*c(2) + x*(3*c(3) + x*4*c(4)))
         curvature = 2*c(2) + x*(6*c(3) + x*12*c(4))
         if (.not. curvature < 0) return
         x = max(-1.0_dp, min(1.0_dp, x - slope/curvature))
      end do
      peak = max(peak, p(i) + x*(c(1) + x*(c(2) + x*(c(3) + x*c(4)))))
   end function peak

end module geartrain_flow_sampled_peak
