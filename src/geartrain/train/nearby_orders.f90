!> Orders of a nearby train whose meshes repeat themselves together after fewer cycles. Three stages of hunting teeth repeat
!> themselves after hundreds of thousands of cycles, which nothing in their motion shows: mesh frequencies that differ by a few
!> millionths give the same motion, after some thousand cycles.
module geartrain_train_nearby_orders
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: find_nearby_orders, most_cycles

   !> Most cycles of a mesh in a period of the fundamental that a harmonic balance or a monodromy matrix is made for.
   integer, parameter :: most_cycles = 10000
   !> Relative error of the frequencies that is wanted, and that is allowed, further where there are no such orders, as with gears
   !> of many teeth, or on several shafts, that have errors: an amplitude on the flank of a resonance of 0.4 % of critical damping
   !> changes by 1/0.008 times as much.
   real(dp), parameter :: wanted(3) = [5e-6_dp, 5e-6_dp, 2e-4_dp], allowed(3) = [1e-5_dp, 1e-4_dp, 5e-4_dp]
   !> Fewest cycles of the fastest mesh.
   integer, parameter :: fewest = 1000
   !> Orders whose ratio is one of whole numbers up to this one keep their ratio: sums of few harmonics of one are harmonics of the
   !> other.
   integer, parameter :: simple = 32

contains

   !> Finds the orders of fewest cycles with the wanted error or, where there are none, of the smallest error.
   pure subroutine find_nearby_orders(order, nearby, scale, error, multiple)
      !> Orders of the fundamental, > 0.
      integer, intent(in) :: order(:)
      !> Nearby orders; those given where there are none.
      integer, intent(out) :: nearby(:)
      !> Nearby orders over orders, the mean of the smallest and the largest ratio [1]; 1 where there are none.
      real(dp), intent(out) :: scale
      !> Largest relative error of a frequency [1].
      real(dp), intent(out) :: error
      !> Numbers of which the orders must be multiples; absent: 1.
      integer, intent(in), optional :: multiple(:)
      integer :: rounded(size(order)), unit(size(order)), cycles, k
      real(dp) :: ratio(size(order)), off

      nearby = order
      scale = 1
      error = 0
      unit = 1
      if (present(multiple)) unit = multiple
      if (.not. maxval(order) > most_cycles) return
      do k = 1, size(allowed)
         error = allowed(k)
         do cycles = fewest, most_cycles
            rounded = max(1, nint(order*(real(cycles, dp)/maxval(order))/unit))*unit
            ratio = real(rounded, dp)/order
            off = (maxval(ratio) - minval(ratio))/(maxval(ratio) + minval(ratio))
            if (.not. off < error) cycle
            if (.not. keeps_simple_ratios(order, rounded)) cycle
            nearby = rounded
            scale = (maxval(ratio) + minval(ratio))/2
            error = off
            if (error < wanted(k)) return
         end do
         if (any(nearby /= order)) return
      end do
      error = 0
   end subroutine find_nearby_orders

   !> Whether orders of simple ratios have the same ratios nearby.
   pure logical function keeps_simple_ratios(order, nearby) result(keeps)
      integer, intent(in) :: order(:), nearby(:)
      integer :: i, j, k

      keeps = .true.
      do i = 1, size(order)
         do j = i + 1, size(order)
            do k = 1, simple
               ! order(j)/order(i) = l/k with a whole number l.
               if (mod(int(k, int64)*order(j), int(order(i), int64)) /= 0) cycle
               associate (l => int(k, int64)*order(j)/order(i))
                  if (l <= simple) keeps = l*nearby(i) == int(k, int64)*nearby(j)
               end associate
               exit
            end do
            if (.not. keeps) return
         end do
      end do
   end function keeps_simple_ratios

end module geartrain_train_nearby_orders
