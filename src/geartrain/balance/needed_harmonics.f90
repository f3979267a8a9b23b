!> Which harmonics a balance carries: those that the excitation reaches. Orders without a common divisor, as hunting teeth have,
!> reach all of them in the end, but most only by sums of so many orders that nothing is left there.
module geartrain_balance_needed_harmonics
   use geartrain_model_excitation, only: excited_harmonics
   use geartrain_model_system, only: system_type
   implicit none (type, external)
   private
   public :: needed_harmonics

   !> Orders in a sum, at least. Orders 17 and 23 with 138 harmonics at Lambda = 0.0541: sums of 6, 8, 10 or any make a waveform
   !> error of 2e-2, 1e-2, 2e-3, 6e-4 with 42, 59, 73, 138 harmonics.
   integer, parameter :: fewest_sums = 10

contains

   !> Harmonics of Lambda, ascending, at most `highest`: sums and differences of as many excited orders as the highest order has
   !> harmonics among them.
   pure function needed_harmonics(system, highest) result(harmonic)
      type(system_type), intent(in) :: system
      integer, intent(in) :: highest
      integer, allocatable :: harmonic(:)
      integer, allocatable :: level(:), sources(:)
      logical, allocatable :: excited(:)
      integer :: j, k, r, widest, sums

      widest = 1
      allocate (excited(highest), source=.false.)
      sources = excited_harmonics(system)
      excited(pack(sources, sources <= highest)) = .true.
      do j = 1, system%meshes
         widest = max(widest, system%law(j)%order)
      end do
      sums = max(fewest_sums, (highest + widest - 1)/widest)
      ! level: orders in the shortest sum that gives a harmonic; intermediate sums may lie beyond the highest.
      allocate (level(0:highest + widest), source=huge(1))
      level(0) = 0
      do k = 1, sums
         do r = 0, ubound(level, 1)
            if (level(r) /= k - 1) cycle
            do j = 1, highest
               if (.not. excited(j)) cycle
               if (r + j <= ubound(level, 1)) level(r + j) = min(level(r + j), k)
               level(abs(r - j)) = min(level(abs(r - j)), k)
            end do
         end do
      end do
      ! What nothing excites may move all the same, from a seed.
      if (.not. any(excited)) level = 0
      harmonic = pack([(r, r=1, highest)], level(1:highest) <= sums)
   end function needed_harmonics

end module geartrain_balance_needed_harmonics
