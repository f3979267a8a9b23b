!> A special point of a branch against the exact branch: whether and where the exact branch has a special point of the kind, and how
!> many multipliers pass the unit circle there.
!>
!> The exact branch is met across the special point and followed both ways in turn, until a test function changes sign that changes
!> sign at this kind alone; so the nearest special point is found first.
module geartrain_analyses_audit_special_point
   use geartrain_analyses_audit_point, only: audit_point, fold_test_type, neighbours, guess_from_point
   use geartrain_analyses_audit_result, only: audit_row_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_continuation_branch, only: branch_type
   use geartrain_continuation_decided, only: nearest_decided
   use geartrain_continuation_orbit_corrector, only: orbit_corrector_type, orbit_test_type, orbit_type
   implicit none (type, external)
   private
   public :: audit_special_point

   !> First step and longest way along the exact branch, in the units of units_type.
   real(dp), parameter :: first_step = 2e-4_dp, longest_way = 0.25_dp
   !> Least Lambda on the way over Lambda at its beginning: towards 0 the integration takes ever longer.
   real(dp), parameter :: slowest = 0.5_dp
   integer, parameter :: max_steps = 100
   !> Distance from a special point to the orbits on either side whose multipliers are counted, in the units of units_type.
   real(dp), parameter :: beside = 1e-4_dp
   !> A multiplier is outside the unit circle if its magnitude is larger than 1 + neutral; a part of Lambda in the unit tangent
   !> below `level` counts as 0.
   real(dp), parameter :: neutral = 1e-8_dp, level = 1e-8_dp

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

   !> Test function: magnitude of a complex pair of multipliers, less 1.
   type, extends(orbit_test_type) :: neimark_sacker_test_type
      !> Number of the pair, by descending magnitude.
      integer :: pair = 1
   contains
      procedure :: value => value_of_neimark_sacker
   end type neimark_sacker_test_type

contains

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

   !> Fills in the row of a special point: Lambda of the exact special point, multipliers on both sides, and what is wrong.
   subroutine audit_special_point(corrector, branch, special, row, exact)
      !> The corrector of the exact branch.
      type(orbit_corrector_type), intent(inout) :: corrector
      !> The branch.
      type(branch_type), intent(in) :: branch
      !> Number of the special point.
      integer, intent(in) :: special
      !> The row, with defaults only.
      type(audit_row_type), intent(inout) :: row
      !> The special point of the exact branch; without states where none was found.
      type(orbit_type), intent(out) :: exact
      type(orbit_type) :: start, first, last
      integer :: ends(2), sides(2), change
      logical :: found

      row%kind = branch%special_points(special)%kind
      row%frequency_ratio = branch%special_points(special)%frequency_ratio
      row%point = branch%special_points(special)%point
      if (row%kind == 'fold') then
         call audit_point(corrector, branch, row)
         ! Of a fold only the estimate counts: its multiplier +1 is neither inside nor outside the unit circle.
         if (.not. row%estimate_wrong) row%finding = ''
         row%verdict_wrong = .false.
         row%verdict = ''
         row%exact_verdict = ''
      end if
      call stand_at(corrector, branch, row, start, ends, found)
      change = 0
      sides = 0
      if (allocated(branch%stable)) then
         sides = [nearest_decided(branch, special, -1), nearest_decided(branch, special, 1)]
         associate (before => branch%multipliers(:, merge(sides(1), ends(1), sides(1) > 0)), &
                    after => branch%multipliers(:, merge(sides(2), ends(2), sides(2) > 0)))
            change = critical(row%kind, after) - critical(row%kind, before)
            row%verdict = counts(before, after)
         end associate
      end if
      if (found) call corrector%correct(start, found)
      if (found) call search(corrector, start, row%kind, sense_of(branch, row, ends, change), exact, found)
      if (found) then
         row%exact_frequency = exact%frequency_ratio/corrector%times
         call corrector%advance(exact, -beside, first, found)
         if (found) call corrector%advance(exact, beside, last, found)
      end if
      if (found) then
         row%exact_verdict = counts(first%multipliers, last%multipliers)
         ! Between two special points of one step no point tells how many multipliers are outside.
         where (shares_step(branch, special)) sides = 0
         row%verdict_wrong = contradicts(branch, row%kind, sides(1), first) .or. contradicts(branch, row%kind, sides(2), last)
         if (row%verdict_wrong) row%finding = 'verdict wrong'
      else
         row%finding = 'no '//trim(row%kind)//' found near it'
         row%verdict_wrong = row%kind == 'fold' .or. all(sides > 0)
         if (.not. row%verdict_wrong) row%finding = trim(row%finding)//', undecided'
      end if
   end subroutine audit_special_point

   !> Whether stability at point i of the branch, next to a special point, differs from the stability of an orbit next to the exact
   !> special point, and so does the number of the multipliers that pass at this kind (other multipliers may pass between the
   !> special point and point i). i = 0: no decided point.
   pure logical function contradicts(branch, kind, i, orbit)
      type(branch_type), intent(in) :: branch
      character(*), intent(in) :: kind
      integer, intent(in) :: i
      type(orbit_type), intent(in) :: orbit

      contradicts = .false.
      if (i == 0) return
      ! A refined point is an orbit; next to a fold it may be an orbit of the other side.
      if (allocated(branch%correction)) then
         if (branch%correction(i) >= 0) return
      end if
      contradicts = (branch%stable(i) .neqv. outside(orbit%multipliers) == 0) &
                    .and. critical(kind, branch%multipliers(:, i)) /= critical(kind, orbit%multipliers)
   end function contradicts

   !> Whether a special point shares its step of the branch with the special point before it, and with the special point after it.
   pure function shares_step(branch, special) result(shares)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: special
      logical :: shares(2)

      shares = .false.
      associate (point => branch%special_points%point)
         if (special > 1) shares(1) = point(special - 1) == point(special)
         if (special < size(point)) shares(2) = point(special + 1) == point(special)
      end associate
   end function shares_step

   !> First guess of the orbit at a special point, on the chord of the points on both sides, with the chord as tangent.
   subroutine stand_at(corrector, branch, row, start, ends, found)
      type(orbit_corrector_type), intent(inout) :: corrector
      type(branch_type), intent(in) :: branch
      type(audit_row_type), intent(in) :: row
      type(orbit_type), intent(out) :: start
      !> Indices of the points on both sides.
      integer, intent(out) :: ends(2)
      logical, intent(out) :: found
      type(orbit_type) :: first, last
      real(dp) :: way, share

      ends = [row%point, min(row%point + 1, branch%points)]
      if (row%kind == 'fold') ends = neighbours(branch, row%point)
      call guess_from_point(corrector, branch, ends(1), first)
      call guess_from_point(corrector, branch, ends(2), last)
      if (row%kind == 'fold') then
         call guess_from_point(corrector, branch, row%point, start)
      else
         share = 0
         if (abs(last%frequency_ratio - first%frequency_ratio) > 0) &
            share = (corrector%times*row%frequency_ratio - first%frequency_ratio)/(last%frequency_ratio - first%frequency_ratio)
         ! Next to a fold Lambda may lie outside the range of the two points.
         share = max(0.0_dp, min(1.0_dp, share))
         start = first
         start%states = (1 - share)*first%states + share*last%states
         start%frequency_ratio = (1 - share)*first%frequency_ratio + share*last%frequency_ratio
      end if
      call corrector%point_at(first, last, start, way)
      found = way > 0
   end subroutine stand_at

   !> Sign of the change of the test function of the kind between two points of the branch; 0: not known.
   pure integer function sense_of(branch, row, ends, change) result(sense)
      type(branch_type), intent(in) :: branch
      type(audit_row_type), intent(in) :: row
      integer, intent(in) :: ends(2)
      !> Change of the number that `critical` counts.
      integer, intent(in) :: change

      select case (row%kind)
      case ('fold')
         associate (here => branch%frequency_ratio(row%point), before => branch%frequency_ratio(ends(1)), &
                    after => branch%frequency_ratio(ends(2)))
            sense = 0
            if (here > max(before, after)) sense = -1
            if (here < min(before, after)) sense = 1
         end associate
      case ('period doubling')
         sense = -change
      case ('neimark-sacker')
         sense = max(-1, min(1, change))
      case default
         sense = 0
      end select
   end function sense_of

   !> Finds the special point of a kind on the exact branch that is nearest to `start`.
   subroutine search(corrector, start, kind, sense, exact, found)
      type(orbit_corrector_type), intent(inout) :: corrector
      type(orbit_type), intent(in) :: start
      character(*), intent(in) :: kind
      !> Sign of the change of the test function, see `sense_of`; 0: any.
      integer, intent(in) :: sense
      type(orbit_type), intent(inout) :: exact
      logical, intent(out) :: found
      type(orbit_type) :: side(2), next
      real(dp) :: rise
      class(orbit_test_type), allocatable :: test
      real(dp) :: step(2), way(2)
      logical :: open_end(2)
      integer :: i, k

      ! The search begins a little before `start`: at the special point itself the sign of the test function is rounding.
      call corrector%advance(start, -0.5_dp*first_step, next, found)
      side = start
      if (found) side = next
      side(2)%tangent = -side(1)%tangent
      side(2)%tangent_frequency = -side(1)%tangent_frequency
      step = first_step
      way = 0
      open_end = .true.
      found = .false.
      do i = 1, max_steps
         k = minloc(way, 1, open_end)
         if (k == 0) exit
         call corrector%advance(side(k), step(k), next, found)
         if (.not. found) then
            step(k) = step(k)/3
            open_end(k) = step(k) > 1e-7_dp
            cycle
         end if
         call choose_test(kind, side(k), next, test)
         if (allocated(test)) then
            rise = test%value(next)
            ! On the way back the change has the opposite sign; for a fold the test function has the opposite sign as well.
            if (k == 2 .and. kind /= 'fold') rise = -rise
            if (rise*sense < 0) deallocate (test)
         end if
         if (allocated(test)) then
            call corrector%find_zero(test, side(k), step(k), next, exact, found)
            if (found) then
               ! The tangent gets the sense of the branch.
               if (k == 2) exact%tangent = -exact%tangent
               if (k == 2) exact%tangent_frequency = -exact%tangent_frequency
               return
            end if
         end if
         way(k) = way(k) + step(k)
         open_end(k) = way(k) < longest_way .and. next%frequency_ratio > slowest*start%frequency_ratio
         step(k) = 1.5_dp*step(k)
         side(k) = next
      end do
      found = .false.
   end subroutine search

   !> Allocates the test function of the kind if it changes sign between two orbits.
   subroutine choose_test(kind, first, last, test)
      character(*), intent(in) :: kind
      type(orbit_type), intent(in) :: first, last
      class(orbit_test_type), allocatable, intent(out) :: test
      integer :: pairs(2)
      logical :: changes

      changes = .true.
      select case (kind)
      case ('fold')
         allocate (fold_test_type :: test)
         ! On a vertical curve the sign of the part of Lambda is rounding.
         changes = min(abs(first%tangent_frequency), abs(last%tangent_frequency)) > level
      case ('period doubling')
         allocate (doubling_test_type :: test)
      case ('neimark-sacker')
         pairs = [pairs_outside(first%multipliers), pairs_outside(last%multipliers)]
         allocate (test, source=neimark_sacker_test_type(maxval(pairs)))
         changes = pairs(1) /= pairs(2)
      case default
         allocate (branching_test_type :: test)
         changes = first%tangent_frequency*last%tangent_frequency > 0
      end select
      if (changes) changes = test%value(first)*test%value(last) < 0
      if (.not. changes) deallocate (test)
   end subroutine choose_test

   !> Number that changes where multipliers pass at a special point of a kind: complex pairs outside the unit circle for a
   !> Neimark-Sacker point; else 1 if the number of real multipliers above +1, or below -1, is odd. Complex pairs that become real
   !> leave the parity as it is.
   pure integer function critical(kind, multipliers)
      character(*), intent(in) :: kind
      complex(dp), intent(in) :: multipliers(:)

      select case (kind)
      case ('neimark-sacker')
         critical = pairs_outside(multipliers)
      case ('period doubling')
         critical = mod(count(is_real(multipliers) .and. multipliers%re < -1), 2)
      case default
         critical = mod(count(is_real(multipliers) .and. multipliers%re > 1), 2)
      end select
   end function critical

   !> Multipliers outside the unit circle before and after a special point, in words.
   pure function counts(before, after) result(words)
      complex(dp), intent(in) :: before(:), after(:)
      character(16) :: words

      words = text(outside(before))//' -> '//text(outside(after))
   end function counts

   !> Number of multipliers outside the unit circle.
   pure integer function outside(multipliers)
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

end module geartrain_analyses_audit_special_point
