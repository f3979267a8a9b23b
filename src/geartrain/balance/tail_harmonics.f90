!> Harmonics of the tail of a balance, those that it leaves out and may not neglect.
module geartrain_balance_tail_harmonics
   use geartrain_balance_balance, only: balance_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_sorting, only: ascending
   implicit none (type, external)
   private
   public :: busiest, far, near, resonance_ratio, tail_harmonics

   !> The tail has the harmonics up to `near` times the highest carried harmonic, and up to `far` times the highest carried harmonic
   !> those near a natural frequency: within these ratios to a natural frequency of the train in contact, which separation lowers.
   integer, parameter :: near = 3, far = 8
   real(dp), parameter :: lowest_resonance = 0.7_dp, highest_resonance = 1.15_dp
   !> Natural frequencies nearer to each other than this ratio have a range of harmonics near them in common.
   real(dp), parameter :: resonance_ratio = highest_resonance/lowest_resonance

   !> Steps of bisection for the least amplitude of a set: a factor of 2 in 2**64 within 3e-3.
   integer, parameter :: halvings = 14

contains

   !> The harmonics of Lambda/eta in the tail, ascending: all that the balance misses up to `near`, those near a natural frequency
   !> up to `far`, and all of the excitation; where no teeth part, those of them that anything drives.
   pure function tail_harmonics(balance, frequency_ratio, resonance) result(harmonic)
      !> The balance, evaluated.
      type(balance_type), intent(in) :: balance
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Ranges of natural frequencies over characteristic frequency [1], (2, range); absent: none is looked at.
      real(dp), intent(in), optional :: resonance(:, :)
      integer, allocatable :: harmonic(:)
      logical, allocatable :: taken(:)
      real(dp) :: r(2)
      integer :: k, least

      ! Linear: harmonics do not make others.
      harmonic = balance%left_out
      if (balance%unknowns == 0) return
      if (balance%is_wound() .and. balance%parts()) then
         harmonic = placed_harmonics(balance, frequency_ratio, resonance)
         return
      end if
      if (.not. any(balance%contact%events > 0)) then
         taken = driven_harmonics(balance)
      else
         allocate (taken(far*balance%highest), source=.false.)
         taken(balance%missing) = .true.
         if (present(resonance)) then
            do k = 1, size(resonance, 2)
               r = resonance(:, k)*balance%eta/frequency_ratio
               least = int(min(lowest_resonance*r(1), real(size(taken), dp))) + 1
               taken(max(least, near*balance%highest + 1):int(min(highest_resonance*r(2), real(size(taken), dp)))) = .true.
            end do
         end if
      end if
      taken(pack(balance%left_out, balance%left_out <= size(taken))) = .true.
      harmonic = pack([(k, k=balance%repeats, size(taken), balance%repeats)], taken(balance%repeats::balance%repeats))
      harmonic = [harmonic, pack(balance%left_out, balance%left_out > size(taken))]
      harmonic = pack(harmonic, balance%winding%place_of(harmonic) > 0)
   end function tail_harmonics

   !> The harmonics of the tail that have places in the winding of the balance, ascending.
   pure function placed_harmonics(balance, frequency_ratio, resonance) result(harmonic)
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: frequency_ratio
      real(dp), intent(in), optional :: resonance(:, :)
      integer, allocatable :: harmonic(:)
      logical, allocatable :: taken(:)
      real(dp) :: r(2)
      integer :: highest, k, p

      highest = maxval(balance%place)
      harmonic = balance%winding%harmonic_at([(p, p=1, far*highest)])
      allocate (taken(far*highest), source=.false.)
      taken(:near*highest) = .true.
      if (present(resonance)) then
         do k = 1, size(resonance, 2)
            r = resonance(:, k)/frequency_ratio
            taken = taken .or. harmonic > lowest_resonance*r(1) .and. harmonic <= highest_resonance*r(2)
         end do
      end if
      do k = 1, size(balance%left_out)
         p = balance%winding%place_of(balance%left_out(k))
         if (p <= size(taken)) taken(p) = .true.
      end do
      taken(balance%place) = .false.
      harmonic = pack(harmonic, taken .and. harmonic > 0)
      harmonic = harmonic(ascending(real(harmonic, dp)))
   end function placed_harmonics

   !> Which harmonics the carried ones times kappa drive and are not carried: where no teeth part the force has no others. Of
   !> hunting teeth these are some hundred of a hundred thousand.
   pure function driven_harmonics(balance) result(driven)
      type(balance_type), intent(in) :: balance
      logical, allocatable :: driven(:)
      integer :: h, i

      allocate (driven(far*balance%highest), source=.false.)
      do i = 1, balance%unknowns
         associate (law => balance%contact(i)%law)
            if (.not. law%varies(balance%contact(i)%first_contact)) cycle
            do h = 1, size(law%harmonic)
               associate (r => balance%eta*balance%winding%harmonic_at(law%harmonic(h)))
                  call mark([r, balance%harmonic + r, abs(balance%harmonic - r)])
               end associate
            end do
         end associate
      end do
      driven(balance%harmonic) = .false.

   contains

      pure subroutine mark(harmonic)
         integer, intent(in) :: harmonic(:)

         driven(pack(harmonic, harmonic > 0 .and. harmonic <= size(driven))) = .true.
      end subroutine mark

   end function driven_harmonics

   !> Which harmonics have the largest amplitudes.
   pure function busiest(square, left, most) result(carried)
      !> Squared amplitude of every harmonic [1], (harmonic); sum of the squares that may be left out.
      real(dp), intent(in) :: square(:), left
      !> Most harmonics.
      integer, intent(in) :: most
      logical :: carried(size(square))
      real(dp) :: above, below, middle
      integer :: i

      ! Between `below`, above which there are too many or leave out no more than is allowed, and `above`.
      above = 2*maxval([tiny(left), square])
      below = 2.0_dp**(-128)*above
      do i = 1, halvings
         middle = sqrt(above*below)
         if (sum(square, square <= middle) > left .and. count(square > middle) < most) then
            above = middle
         else
            below = middle
         end if
      end do
      carried = square > merge(below, above, count(square > below) <= most)
   end function busiest

end module geartrain_balance_tail_harmonics
