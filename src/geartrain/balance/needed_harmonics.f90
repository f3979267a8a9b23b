!> Which harmonics a balance carries: the harmonics that the excitation reaches. Orders without a common divisor, as of hunting
!> teeth, reach all harmonics in the end, but most of them only by sums of so many orders that the amplitude there is negligible.
module geartrain_balance_needed_harmonics
   use geartrain_network_excitation, only: excited_harmonics
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: needed_harmonics

   !> Terms allowed in a sum, at least. Orders 17 and 23 with 138 harmonics at Lambda = 0.0541: up to 6, 8, 10 and any number of
   !> terms carry 42, 59, 73 and 138 harmonics, with waveform errors of 2e-2, 1e-2, 2e-3 and 6e-4.
   integer, parameter :: fewest_sums = 10

contains

   !> Harmonics of Lambda to carry, ascending: sums and differences of up to `sums` excited harmonics, `sums` being the number of
   !> harmonics up to `highest` of the mesh stiffness of highest order.
   pure function needed_harmonics(system, highest) result(harmonic)
      type(system_type), intent(in) :: system
      !> Highest harmonic to carry.
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
         widest = max(widest, nint(system%law(j)%order))
      end do
      sums = max(fewest_sums, (highest + widest - 1)/widest)
      ! level: terms of the shortest sum that gives a harmonic; intermediate sums may lie above `highest`.
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
      ! A train without excitation may move too, from a seed.
      if (.not. any(excited)) level = 0
      harmonic = pack([(r, r=1, highest)], level(1:highest) <= sums)
   end function needed_harmonics

end module geartrain_balance_needed_harmonics
