!> A short period in place of a long one, for the contacts of a motion: where the teeth of three meshes stand as they stood only
!> after thousands of cycles, what happens in a cycle depends on the phases of the slower sources of excitation in it, and a few
!> hundred cycles have all of their combinations as densely as matters.
!>
!> The motion lives on sums k1 g1 + k2 g2 + .. of the orders g of the sources, so the mesh forces are functions on the torus of the
!> phases of the sources, and their Fourier coefficients are integrals over it. A line that winds round the torus with other
!> orders, s1 < g1, s2, .. nearly in the same ratio, covers it as well. A harmonic has a place: the same sum of these orders.
!> Frequencies stay those of the harmonics, so it is the same train. Coefficients of two sums that have one place add up: how short
!> the period may be follows from the distance of such sums. In circuits: K. S. Kundert, G. B. Sorkin and A.
!> Sangiovanni-Vincentelli, IEEE Trans. Microwave Theory Tech. 36 (1988) 366-378.
module geartrain_balance_winding
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_sorting, only: ascending
   use geartrain_mesh_law_law, only: law_type
   use geartrain_network_excitation, only: excited_harmonics
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: find_winding, winding_type

   !> Most sources: the cycles that are needed grow with a power of their number.
   integer, parameter :: most_sources = 4
   !> Most cycles over the sums that have places of their own; least cycles of the period over those of a winding worth having.
   integer, parameter :: sparsest = 4, worth_having = 8
   !> Weight of the sums of two, three and four sources over that of three: the fewer there are, the less a longer winding costs.
   real(dp), parameter :: share(most_sources - 1) = [3.0_dp, 1.0_dp, 0.6_dp]

   type :: winding_type
      !> Cycles of the fastest source in the short period, 0: no winding; its order in the period.
      integer :: cycles = 0, whole = 0
      !> Sums of three sources have places of their own up to this sum of the magnitudes of k2 and k3; of others see `share`.
      integer :: weight = 0
      !> Harmonic less than `whole` of each place c less than `cycles`, and the place of each such harmonic; -1: none.
      integer, allocatable, private :: harmonic(:), place(:)
      !> Orders of the slower sources in the period and in the winding, (source); numbers k of them in the sum that each place less
      !> than `cycles` is of, (source, place).
      integer, allocatable, private :: source(:), order(:), number(:, :)
   contains
      procedure :: place_of
      procedure :: harmonic_at
      procedure :: last_place
      procedure :: shortened
      procedure :: sources
      procedure :: source_of
      procedure :: numbers_of
      procedure :: phases_at
      procedure :: wind
      procedure, private :: try
      procedure, private :: fill
   end type winding_type

contains

   !> Finds the shortest winding in which sums of the sources up to a weight have places of their own, with the signs of the
   !> harmonics. None where it is not worth having.
   subroutine find_winding(system, weight, winding)
      type(system_type), intent(in) :: system
      !> The weight for three sources.
      integer, intent(in) :: weight
      type(winding_type), intent(out) :: winding
      integer, allocatable :: source(:), order(:), sums(:, :)
      integer :: n, cycles, least, choice, i

      call find_sources(system, source)
      n = size(source) - 1
      if (n < 1 .or. n > most_sources - 1) return
      winding%whole = source(1)
      winding%weight = weight
      call list_sums(n, nint(share(n)*weight), sums)
      least = size(sums, 2)
      do cycles = least, min(sparsest*least, source(1)/(worth_having*system%excitation_order))
         order = [(int(int(cycles, int64)*source(i + 1)/source(1)), i=1, n)]
         do choice = 0, 2**n - 1
            call winding%try(cycles, source(2:), order + [(ibits(choice, i, 1), i=0, n - 1)], sums)
            if (winding%cycles > 0) return
         end do
      end do
   end subroutine find_winding

   !> Lists the orders of which all excited harmonics are multiples, the greatest first: frequencies of meshes and, as of errors of
   !> the gears, lower ones.
   pure subroutine find_sources(system, source)
      type(system_type), intent(in) :: system
      integer, allocatable, intent(out) :: source(:)
      integer, allocatable :: excited(:)
      integer :: i, j, order

      excited = excited_harmonics(system)
      allocate (source(0))
      do j = 1, system%meshes
         order = nint(system%law(j)%order)
         if (order < 1 .or. any(source == order)) cycle
         if (any(excited == order)) source = [source, order]
      end do
      do i = 1, size(excited)
         if (all(mod(excited(i), source) /= 0)) source = [source, excited(i)]
      end do
      if (size(source) == 0) return
      i = maxloc(source, 1)
      source([1, i]) = source([i, 1])
   end subroutine find_sources

   !> Lists the numbers k of all sums of n sources up to a weight, the least weight first.
   pure subroutine list_sums(n, weight, sums)
      integer, intent(in) :: n, weight
      !> The numbers, (source, sum).
      integer, allocatable, intent(out) :: sums(:, :)
      integer, allocatable :: found(:, :)
      integer :: k(n), count, code, rest, i

      allocate (found(n, (2*weight + 1)**n))
      count = 0
      do code = 0, size(found, 2) - 1
         rest = code
         do i = 1, n
            k(i) = mod(rest, 2*weight + 1) - weight
            rest = rest/(2*weight + 1)
         end do
         if (sum(abs(k)) > weight) cycle
         count = count + 1
         found(:, count) = k
      end do
      sums = found(:, ascending(real(sum(abs(found(:, :count)), 1), dp)))
   end subroutine list_sums

   !> Takes a number of cycles and the orders of the slower sources in them, if all sums have places of their own.
   pure subroutine try(self, cycles, source, order, sums)
      class(winding_type), intent(inout) :: self
      !> Cycles of the fastest source; orders of the others in the period and in the winding; numbers k, (source, sum).
      integer, intent(in) :: cycles, source(:), order(:), sums(:, :)
      integer :: harmonic(0:cycles - 1), number(size(source), 0:cycles - 1), i, place, remainder
      integer, allocatable :: more(:, :)

      harmonic = -1
      number = 0
      do i = 1, size(sums, 2)
         call put(sums(:, i), source, order, cycles, self%whole, place, remainder)
         if (harmonic(place) == remainder) cycle
         if (harmonic(place) >= 0 .or. .not. is_between(place, remainder, self%whole)) return
         harmonic(place) = remainder
         number(:, place) = sums(:, i)
      end do
      self%harmonic = harmonic
      allocate (self%place(0:self%whole - 1), source=-1)
      do place = 0, cycles - 1
         if (harmonic(place) < 0) cycle
         ! One harmonic is two sums, as where a source has twice the order of another, and they have two places.
         if (self%place(harmonic(place)) >= 0) then
            deallocate (self%place)
            return
         end if
         self%place(harmonic(place)) = place
      end do
      self%cycles = cycles
      self%source = source
      self%order = order
      allocate (self%number(size(source), 0:cycles - 1), source=number)
      call list_sums(size(source), nint(2*share(size(source))*self%weight), more)
      call self%fill(source, order, more)
   end subroutine try

   !> Gives free places to further sums.
   pure subroutine fill(self, source, order, sums)
      class(winding_type), intent(inout) :: self
      integer, intent(in) :: source(:), order(:), sums(:, :)
      integer :: i, place, remainder

      do i = 1, size(sums, 2)
         call put(sums(:, i), source, order, self%cycles, self%whole, place, remainder)
         if (.not. is_between(place, remainder, self%whole)) cycle
         if (self%harmonic(place) >= 0 .or. self%place(remainder) >= 0) cycle
         self%harmonic(place) = remainder
         self%place(remainder) = place
         self%number(:, place) = sums(:, i)
      end do
   end subroutine fill

   !> Place of a sum within the first cycles, and its harmonic less as many orders of the fastest source.
   pure subroutine put(k, source, order, cycles, whole, place, remainder)
      integer, intent(in) :: k(:), source(:), order(:), cycles, whole
      integer, intent(out) :: place, remainder
      integer :: whole_place

      whole_place = dot_product(k, order)
      place = modulo(whole_place, cycles)
      remainder = dot_product(k, source) - (whole_place - place)/cycles*whole
   end subroutine put

   !> Whether a harmonic lies between the same multiples of the fastest source as its place does: so signs are kept.
   pure logical function is_between(place, remainder, whole)
      integer, intent(in) :: place, remainder, whole

      is_between = remainder > 0 .and. remainder < whole
      if (place == 0) is_between = remainder == 0
   end function is_between

   !> Place of a harmonic; 0: none. Without a winding the harmonic.
   elemental integer function place_of(self, harmonic) result(place)
      class(winding_type), intent(in) :: self
      !> Number of the harmonic of Lambda, at least 1.
      integer, intent(in) :: harmonic

      place = harmonic
      if (self%cycles == 0) return
      place = self%place(mod(harmonic, self%whole))
      if (place >= 0) then
         place = place + harmonic/self%whole*self%cycles
      else
         place = 0
      end if
   end function place_of

   !> Harmonic of Lambda at a place; 0: none. Without a winding the place.
   elemental integer function harmonic_at(self, place) result(harmonic)
      class(winding_type), intent(in) :: self
      !> The place, at least 1.
      integer, intent(in) :: place

      harmonic = place
      if (self%cycles == 0) return
      harmonic = self%harmonic(mod(place, self%cycles))
      if (harmonic >= 0) then
         harmonic = harmonic + place/self%cycles*self%whole
      else
         harmonic = 0
      end if
   end function harmonic_at

   !> A place that no harmonic up to a given one is beyond.
   pure integer function last_place(self, harmonic)
      class(winding_type), intent(in) :: self
      !> Number of the harmonic of Lambda.
      integer, intent(in) :: harmonic

      last_place = harmonic
      if (self%cycles > 0) last_place = (harmonic/self%whole + 1)*self%cycles
   end function last_place

   !> What a harmonic of the period is along the winding, rounded up: as many samples are to show it.
   pure integer function shortened(self, harmonic)
      class(winding_type), intent(in) :: self
      !> Number of the harmonic of Lambda.
      integer, intent(in) :: harmonic

      shortened = harmonic
      if (self%cycles > 0) shortened = ceiling(real(harmonic, dp)*self%cycles/self%whole)
   end function shortened

   !> Number of sources: of dimensions of the torus. Without a winding 1.
   pure integer function sources(self)
      class(winding_type), intent(in) :: self

      sources = 1
      if (self%cycles > 0) sources = size(self%source) + 1
   end function sources

   !> Number of the source of an order; 0: there is none.
   pure integer function source_of(self, order)
      class(winding_type), intent(in) :: self
      !> Order of a mesh.
      integer, intent(in) :: order

      source_of = findloc([self%whole, self%source], order, 1)
   end function source_of

   !> Numbers k of the sources in the sum that a harmonic with a place is, the fastest first.
   pure function numbers_of(self, harmonic) result(numbers)
      class(winding_type), intent(in) :: self
      !> Number of the harmonic of Lambda.
      integer, intent(in) :: harmonic
      integer :: numbers(size(self%source) + 1)

      numbers(2:) = self%number(:, self%place(mod(harmonic, self%whole)))
      numbers(1) = (harmonic - dot_product(numbers(2:), self%source))/self%whole
   end function numbers_of

   !> Phases of the sources at a place along the winding [rad], the fastest first.
   pure function phases_at(self, part, parts) result(phases)
      class(winding_type), intent(in) :: self
      !> The place: so many of the equal parts of the winding after its beginning.
      integer, intent(in) :: part, parts
      real(dp) :: phases(size(self%source) + 1)

      phases = 2*pi*modulo(int([self%cycles, self%order], int64)*part, int(parts, int64))/parts
   end function phases_at

   !> Puts the harmonics of a force law at their places. Those without a place have no amplitude and are dropped.
   pure subroutine wind(self, law)
      class(winding_type), intent(in) :: self
      type(law_type), intent(inout) :: law
      complex(dp), allocatable :: rows(:, :)
      integer, allocatable :: place(:), kept(:)
      integer :: h

      if (self%cycles == 0) return
      place = self%place_of(law%harmonic)
      kept = pack([(h, h=1, size(place))], place > 0)
      law%harmonic = place(kept)
      allocate (rows(size(kept), law%lowest:law%highest))
      rows(:, :) = law%amplitude(kept, :)
      call move_alloc(rows, law%amplitude)
      if (.not. allocated(law%offset)) return
      allocate (rows(size(kept), law%lowest:law%highest))
      rows(:, :) = law%offset(kept, :)
      call move_alloc(rows, law%offset)
   end subroutine wind

end module geartrain_balance_winding
