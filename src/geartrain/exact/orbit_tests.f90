!> Test functions of the exact branch: each changes sign at special points of one kind alone.
module geartrain_exact_orbit_tests
   use geartrain_base_kinds, only: dp
   use geartrain_exact_orbit_corrector, only: orbit_test_type, orbit_type
   use geartrain_floquet_multipliers, only: side_of_fold
   use geartrain_trace_stages, only: no_stage, stage_of
   implicit none (type, external)
   private
   public :: back_contact, choose_test, critical, fold_test_type, is_onset, outside, separation

   !> Kinds of contact onsets: a mesh begins to separate, its back flanks begin to touch; `stage_kind` has the third.
   character(*), parameter :: separation = 'separation', back_contact = 'back contact'
   !> A multiplier is outside the unit circle if its magnitude is larger than 1 + neutral; a part of Lambda in the unit tangent
   !> below `level`, in the unit of Lambda of the metric, counts as 0.
   real(dp), parameter :: neutral = 1e-8_dp, level = 1e-11_dp

   !> Test function: the part of Lambda in the unit tangent, which changes sign at a fold.
   type, extends(orbit_test_type) :: fold_test_type
   contains
      procedure :: value => value_of_fold
   end type fold_test_type

   !> Test function: det(M + I) up to the positive factors of complex multipliers.
   type, extends(orbit_test_type) :: doubling_test_type
   contains
      procedure :: value => value_of_doubling
   end type doubling_test_type

   !> Test function: det(M - I), up to the positive factors of complex multipliers, over the part of Lambda in the unit tangent; the
   !> quotient has no zero at a fold, where both vanish.
   type, extends(orbit_test_type) :: branching_test_type
   contains
      procedure :: value => value_of_branching
   end type branching_test_type

   !> Test function: mean of the real multipliers that pass +1, or -1, together, less 1. They belong to differences of equal
   !> branches. Next to the special point rounding moves the orbit along these differences, which parts the multipliers but leaves
   !> their mean, to first order.
   type, extends(orbit_test_type) :: multiple_test_type
      !> 1: the multipliers pass +1; -1: they pass -1.
      integer :: side = 1
      !> The multipliers by descending distance beyond it: first and last.
      integer :: first = 1, last = 1
   contains
      procedure :: value => value_of_multiple
   end type multiple_test_type

   !> Test function: magnitude of a complex pair of multipliers, less 1.
   type, extends(orbit_test_type) :: neimark_sacker_test_type
      !> Number of the pair, by descending magnitude.
      integer :: pair = 1
   contains
      procedure :: value => value_of_neimark_sacker
   end type neimark_sacker_test_type

   !> Test function: distance of the displacement of the watched mesh from the contact that begins.
   type, extends(orbit_test_type) :: onset_test_type
   contains
      procedure :: value => value_of_onset
   end type onset_test_type

contains

   pure real(dp) function value_of_fold(self, orbit) result(value)
      class(fold_test_type), intent(in) :: self
      type(orbit_type), intent(in) :: orbit

      value = orbit%tangent_frequency
   end function value_of_fold

   pure real(dp) function value_of_doubling(self, orbit) result(value)
      class(doubling_test_type), intent(in) :: self
      type(orbit_type), intent(in) :: orbit

      associate (m => orbit%multipliers)
         value = product(merge(1 + m%re, abs(1 + m), is_real(m)))
      end associate
   end function value_of_doubling

   pure real(dp) function value_of_branching(self, orbit) result(value)
      class(branching_test_type), intent(in) :: self
      type(orbit_type), intent(in) :: orbit

      value = 0
      if (.not. abs(orbit%tangent_frequency) > 0) return
      associate (m => orbit%multipliers)
         value = product(merge(1 - m%re, abs(1 - m), is_real(m)))/orbit%tangent_frequency
      end associate
   end function value_of_branching

   pure real(dp) function value_of_multiple(self, orbit) result(value)
      class(multiple_test_type), intent(in) :: self
      type(orbit_type), intent(in) :: orbit
      real(dp) :: beyond(size(orbit%multipliers))
      integer :: i

      beyond = beyond_one(orbit%multipliers, self%side)
      value = 0
      do i = 1, self%last
         associate (largest => maxloc(beyond, 1))
            if (i >= self%first) value = value + beyond(largest)/(self%last - self%first + 1)
            beyond(largest) = -1
         end associate
      end do
   end function value_of_multiple

   !> Distance of each multiplier beyond +1, or beyond -1; -1 of a complex one. Two that are equal may come as a pair.
   elemental real(dp) function beyond_one(multiplier, side)
      complex(dp), intent(in) :: multiplier
      !> 1: beyond +1; -1: beyond -1.
      integer, intent(in) :: side
      real(dp), parameter :: real_enough = 1e-6_dp

      beyond_one = merge(side*multiplier%re - 1, -1.0_dp, abs(multiplier%im) <= real_enough*abs(multiplier))
   end function beyond_one

   pure real(dp) function value_of_neimark_sacker(self, orbit) result(value)
      class(neimark_sacker_test_type), intent(in) :: self
      type(orbit_type), intent(in) :: orbit
      integer :: i, n

      value = -1
      n = 0
      do i = 1, size(orbit%multipliers)
         if (orbit%multipliers(i)%im > 0) n = n + 1
         if (n < self%pair) cycle
         value = abs(orbit%multipliers(i)) - 1
         return
      end do
   end function value_of_neimark_sacker

   pure real(dp) function value_of_onset(self, orbit) result(value)
      class(onset_test_type), intent(in) :: self
      type(orbit_type), intent(in) :: orbit

      value = orbit%depth
   end function value_of_onset

   !> Whether a kind is that of a contact onset.
   pure logical function is_onset(kind)
      !> Kind of a special point.
      character(*), intent(in) :: kind

      is_onset = kind == separation .or. kind == back_contact .or. stage_of(kind) /= no_stage
   end function is_onset

   !> Allocates the test function of the kind if it changes sign between two orbits.
   subroutine choose_test(kind, multiplicity, frequency_unit, first, last, test)
      !> Kind of the special point.
      character(*), intent(in) :: kind
      !> Number of multipliers that pass the unit circle together.
      integer, intent(in) :: multiplicity
      !> Unit of Lambda in the metric [1].
      real(dp), intent(in) :: frequency_unit
      !> Two orbits of a step.
      type(orbit_type), intent(in) :: first, last
      !> The test function; not allocated where it does not change sign.
      class(orbit_test_type), allocatable, intent(out) :: test
      character(len(kind) + len(separation)) :: word
      integer :: pairs(2), side
      logical :: changes

      word = kind
      if (is_onset(kind)) word = separation
      changes = .true.
      if (multiplicity > 1 .and. (kind == 'branch point' .or. kind == 'period doubling')) then
         side = merge(1, -1, kind == 'branch point')
         pairs = [count(beyond_one(first%multipliers, side) > 0), count(beyond_one(last%multipliers, side) > 0)]
         allocate (test, source=multiple_test_type(blurred=kind == 'branch point', side=side, &
                  first=maxval(pairs) - multiplicity + 1, last=maxval(pairs)))
         changes = abs(pairs(1) - pairs(2)) == multiplicity
      else
         select case (word)
         case ('fold')
            allocate (fold_test_type :: test)
            ! On a vertical curve the sign of the part of Lambda is rounding.
            changes = min(abs(first%tangent_frequency), abs(last%tangent_frequency)) > level*frequency_unit
         case ('period doubling')
            allocate (doubling_test_type :: test)
         case ('neimark-sacker')
            pairs = [pairs_outside(first%multipliers), pairs_outside(last%multipliers)]
            allocate (test, source=neimark_sacker_test_type(pair=maxval(pairs)))
            changes = pairs(1) /= pairs(2)
         case (separation)
            allocate (onset_test_type :: test)
         case default
            allocate (test, source=branching_test_type(singular=.true.))
            changes = first%tangent_frequency*last%tangent_frequency > 0
         end select
      end if
      if (changes) changes = test%value(first)*test%value(last) < 0
      if (.not. changes) deallocate (test)
   end subroutine choose_test

   !> Number that changes where multipliers pass at a special point of a kind: complex pairs outside the unit circle for a
   !> Neimark-Sacker point; else 1 if the number of real multipliers above +1, or below -1, is odd. Complex pairs that become real
   !> leave the parity as it is.
   pure integer function critical(kind, multipliers)
      !> Kind of the special point.
      character(*), intent(in) :: kind
      !> Multipliers of a motion, (state).
      complex(dp), intent(in) :: multipliers(:)

      select case (kind)
      case ('neimark-sacker')
         critical = pairs_outside(multipliers)
      case ('period doubling')
         critical = mod(count(is_real(multipliers) .and. multipliers%re < -1), 2)
      case default
         critical = side_of_fold(multipliers)
      end select
   end function critical

   !> Number of multipliers outside the unit circle.
   pure integer function outside(multipliers)
      !> Multipliers of a motion, (state).
      complex(dp), intent(in) :: multipliers(:)

      outside = count(abs(multipliers) > 1 + neutral)
   end function outside

   !> Number of complex pairs outside the unit circle.
   pure integer function pairs_outside(multipliers)
      complex(dp), intent(in) :: multipliers(:)

      pairs_outside = count(multipliers%im > 0 .and. abs(multipliers) > 1 + neutral)
   end function pairs_outside

   elemental logical function is_real(multiplier)
      complex(dp), intent(in) :: multiplier

      is_real = abs(multiplier%im) <= 0
   end function is_real

end module geartrain_exact_orbit_tests
