!> Sets of harmonics that a balance carries because they matter, not because they come next: where the fundamental is that of
!> hunting teeth, 71 and 19 of them a turn, a motion lives on sums k 71 + l 19, few of the thousands of harmonics below the highest.
module geartrain_balance_harmonic_set
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_error_estimate, only: error_estimate_type
   use geartrain_balance_tail_harmonics, only: busiest
   use geartrain_base_kinds, only: dp
   use geartrain_network_excitation, only: excited_harmonics, reach_of_sources
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: first_set, has_sparse_motions, next_set

   !> Lowest harmonic of a source of excitation, over the greatest common divisor of all orders, above which motions are sparse.
   integer, parameter :: lowest_sparse = 6
   !> A set grows to at most twice its size, and by `least_growth` anyhow: the tail beyond is known to first order only.
   integer, parameter :: least_growth = 24

contains

   !> Whether balances of a train carry sets of harmonics where the program chooses their number.
   pure logical function has_sparse_motions(system, subharmonic, repeats)
      type(system_type), intent(in) :: system
      !> Sub-harmonic index, period over mesh period; how often the motions go through their waveform within it.
      integer, intent(in) :: subharmonic, repeats

      has_sparse_motions = subharmonic == 1 .and. repeats == system%excitation_order .and. &
                           reach_of_sources(system) > lowest_sparse*repeats
   end function has_sparse_motions

   !> Harmonics to begin with, ascending: the excitation, and sums and differences of two of its harmonics.
   pure function first_set(system) result(harmonic)
      type(system_type), intent(in) :: system
      integer, allocatable :: harmonic(:)
      integer, allocatable :: excited(:)
      logical, allocatable :: carried(:)
      integer :: i, r

      excited = excited_harmonics(system)
      allocate (carried(0:2*maxval(excited)), source=.false.)
      carried(excited) = .true.
      do i = 1, size(excited)
         carried(abs(excited - excited(i))) = .true.
         carried(excited + excited(i)) = .true.
      end do
      harmonic = pack([(r, r=1, ubound(carried, 1))], carried(1:))
   end function first_set

   !> The carried harmonics and, of the tail, the harmonics of largest amplitude, ascending: what is left out afterwards is `share`
   !> of what is left out now. Above 1 carried harmonics of small amplitude are left out; of a set that is as large as it may be
   !> they make room for larger ones of the tail.
   pure function next_set(balance, u, estimate, share, most) result(harmonic)
      !> Balance, solved.
      type(balance_type), intent(in) :: balance
      !> Its solution [1], (block, unknown).
      real(dp), intent(in) :: u(:, :)
      !> Error estimate of the solution.
      type(error_estimate_type), intent(in) :: estimate
      !> Root of the sum of squares left out afterwards over the present one [1].
      real(dp), intent(in) :: share
      !> Most harmonics to carry, besides those of the excitation; absent: any number.
      integer, intent(in), optional :: most
      integer, allocatable :: harmonic(:)
      integer :: room
      real(dp) :: square(max(balance%highest, maxval([0, estimate%harmonic(:estimate%count)]))), left
      logical :: carried(size(square))
      integer :: k, r

      square = 0
      do k = 1, estimate%count
         square(estimate%harmonic(k)) = estimate%square_of(k)
      end do
      left = sum(square)
      carried = .false.
      room = size(square)
      if (present(most)) room = most
      if (share > 1) then
         square = 0
         call add_carried(balance, u, estimate, square)
         carried = busiest(square, (share**2 - 1)*left, room)
      else if (size(balance%harmonic) >= room) then
         call add_carried(balance, u, estimate, square)
         carried = busiest(square, share**2*left, room)
      else
         room = room - size(balance%harmonic)
         carried = busiest(square, share**2*left, min(room, max(size(balance%harmonic), least_growth)))
         carried(balance%harmonic) = .true.
      end if
      call carry_sources(balance%system, carried)
      harmonic = pack([(r, r=1, size(carried))], carried)
   end function next_set

   !> Adds the squared amplitudes of the carried harmonics, as they count [1].
   pure subroutine add_carried(balance, u, estimate, square)
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: u(:, :)
      type(error_estimate_type), intent(in) :: estimate
      !> By harmonic.
      real(dp), intent(inout) :: square(:)
      integer :: k

      do k = 1, size(balance%harmonic)
         square(balance%harmonic(k)) = sum(u(2*k:2*k + 1, :)**2)
         if (allocated(estimate%felt)) square(balance%harmonic(k)) = max(square(balance%harmonic(k)), estimate%felt(k)**2)
      end do
   end subroutine add_carried

   !> Adds the sources of excitation, because a linear mesh moves at the carried harmonics only.
   pure subroutine carry_sources(system, carried)
      type(system_type), intent(in) :: system
      !> Which harmonics are carried, (harmonic).
      logical, intent(inout) :: carried(:)
      integer, allocatable :: sources(:)

      sources = excited_harmonics(system)
      carried(pack(sources, sources <= size(carried))) = .true.
   end subroutine carry_sources

end module geartrain_balance_harmonic_set
