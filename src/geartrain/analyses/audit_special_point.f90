!> A special point of a branch against the exact branch: whether that has one of its kind there, where, and how many multipliers
!> pass the unit circle at it.
!>
!> The exact branch is met across the special point and followed both ways in turn until a number changes sign that does so at this
!> kind alone; so the nearest one is found first.
module geartrain_analyses_audit_special_point
   use geartrain_analyses_audit_point, only: audit_point, fold_test_type, neighbours, place_on
   use geartrain_analyses_audit_result, only: audit_row_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_continuation_branch, only: branch_type
   use geartrain_continuation_decided, only: nearest_decided
   use geartrain_continuation_orbit_corrector, only: orbit_corrector_type, orbit_test_type, orbit_type
   implicit none (type, external)
   private
   public :: audit_special_point

   !> First step and longest way along the exact branch, in units of the train's own.
   real(dp), parameter :: first_step = 2e-4_dp, longest_way = 0.25_dp
   !> Least Lambda on the way, relative: flights take ever longer towards 0.
   real(dp), parameter :: slowest = 0.5_dp
   integer, parameter :: max_steps = 100
   !> From a special point to either side, where multipliers are counted.
   real(dp), parameter :: beside = 1e-4_dp
   !> A complex multiplier is out by more than this; what counts as 0 for the direction of Lambda.
   real(dp), parameter :: neutral = 1e-8_dp, level = 1e-8_dp

   !> det(M + I) but for complex multipliers.
   type, extends(orbit_test_type) :: doubling_test_type
   contains
      procedure :: value => value_of_doubling
   end type doubling_test_type

   !> det(M - I) over the direction of Lambda, but for complex multipliers: both vanish at a fold.
   type, extends(orbit_test_type) :: branching_test_type
   contains
      procedure :: value => value_of_branching
   end type branching_test_type

   !> How far the complex pair number `pair`, by magnitude, is outside the unit circle.
   type, extends(orbit_test_type) :: neimark_sacker_test_type
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

   !> Fills in the row of special point number `special`: where the exact one is, the counts, and what is wrong.
   subroutine audit_special_point(corrector, branch, special, row, exact)
      type(orbit_corrector_type), intent(inout) :: corrector
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: special
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
         ! Of a fold only the estimate counts: its multiplier +1 is neither in nor out.
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

   !> Whether the branch says at its point i, next to a special point, what is not so for the orbit next to the exact one, and that
   !> for the multipliers that change there: others may before the point is reached. i = 0: the branch does not say.
   pure logical function contradicts(branch, kind, i, orbit)
      type(branch_type), intent(in) :: branch
      character(*), intent(in) :: kind
      integer, intent(in) :: i
      type(orbit_type), intent(in) :: orbit

      contradicts = .false.
      if (i == 0) return
      ! A refined point is an orbit itself, next to a fold perhaps of the other side.
      if (allocated(branch%correction)) then
         if (branch%correction(i) >= 0) return
      end if
      contradicts = (branch%stable(i) .neqv. outside(orbit%multipliers) == 0) &
                    .and. critical(kind, branch%multipliers(:, i)) /= critical(kind, orbit%multipliers)
   end function contradicts

   !> Whether another special point lies between this one and the point before, or after it: the list goes along the branch.
   pure function shares_step(branch, special) result(shares)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: special
      logical :: shares(2)

      shares = .false.
      associate (all_of_them => branch%special_points)
         if (special > 1) shares(1) = all_of_them(special - 1)%point == all_of_them(special)%point
         if (special < size(all_of_them)) shares(2) = all_of_them(special + 1)%point == all_of_them(special)%point
      end associate
   end function shares_step

   !> A first guess of the orbit at a special point, between the points next to it, along the chord of these.
   subroutine stand_at(corrector, branch, row, start, ends, found)
      type(orbit_corrector_type), intent(inout) :: corrector
      type(branch_type), intent(in) :: branch
      type(audit_row_type), intent(in) :: row
      type(orbit_type), intent(out) :: start
      !> These points.
      integer, intent(out) :: ends(2)
      logical, intent(out) :: found
      type(orbit_type) :: first, last
      real(dp) :: way, share

      ends = [row%point, min(row%point + 1, branch%points)]
      if (row%kind == 'fold') ends = neighbours(branch, row%point)
      call place_on(corrector, branch, ends(1), first)
      call place_on(corrector, branch, ends(2), last)
      if (row%kind == 'fold') then
         call place_on(corrector, branch, row%point, start)
      else
         share = 0
         if (abs(last%frequency_ratio - first%frequency_ratio) > 0) &
            share = (corrector%times*row%frequency_ratio - first%frequency_ratio)/(last%frequency_ratio - first%frequency_ratio)
         ! Next to a fold Lambda tells little.
         share = max(0.0_dp, min(1.0_dp, share))
         start = first
         start%states = (1 - share)*first%states + share*last%states
         start%frequency_ratio = (1 - share)*first%frequency_ratio + share*last%frequency_ratio
      end if
      call corrector%point_at(first, last, start, way)
      found = way > 0
   end subroutine stand_at

   !> Which way the number that tells the kind goes between two points of the branch: +1 up, -1 down, 0 where they do not tell.
   pure integer function sense_of(branch, row, ends, change) result(sense)
      type(branch_type), intent(in) :: branch
      type(audit_row_type), intent(in) :: row
      integer, intent(in) :: ends(2)
      !> Of what `critical` counts.
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

   !> The special point of a kind on the exact branch that is nearest to `start`.
   subroutine search(corrector, start, kind, sense, exact, found)
      type(orbit_corrector_type), intent(inout) :: corrector
      type(orbit_type), intent(in) :: start
      character(*), intent(in) :: kind
      !> See `sense_of`; 0: either.
      integer, intent(in) :: sense
      type(orbit_type), intent(inout) :: exact
      logical, intent(out) :: found
      type(orbit_type) :: side(2), next
      real(dp) :: rise
      class(orbit_test_type), allocatable :: test
      real(dp) :: step(2), way(2)
      logical :: open_end(2)
      integer :: i, k

      ! From a little before it: at the special point itself the sign is rounding.
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
            ! On the way back all is in reverse, the direction of Lambda twice.
            if (k == 2 .and. kind /= 'fold') rise = -rise
            if (rise*sense < 0) deallocate (test)
         end if
         if (allocated(test)) then
            call corrector%find_zero(test, side(k), step(k), next, exact, found)
            if (found) then
               ! In the sense of the branch.
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

   !> The number that changes sign between two orbits if a special point of the kind lies between; not allocated if none does.
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
         ! On a vertical segment the direction is rounding.
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

   !> Multipliers beyond the unit circle that are of a kind: complex pairs; else 1 where the number of real ones beyond +1 or -1 is
   !> odd, as each one that passes changes that, whatever pairs become real.
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

   !> Multipliers outside the unit circle.
   pure integer function outside(multipliers)
      complex(dp), intent(in) :: multipliers(:)

      outside = count(abs(multipliers) > 1 + neutral)
   end function outside

   !> Complex pairs outside the unit circle.
   pure integer function pairs_outside(multipliers)
      complex(dp), intent(in) :: multipliers(:)

      pairs_outside = count(multipliers%im > 0 .and. abs(multipliers) > 1 + neutral)
   end function pairs_outside

   elemental logical function is_real(multiplier)
      complex(dp), intent(in) :: multiplier

      is_real = abs(multiplier%im) <= 0
   end function is_real

end module geartrain_analyses_audit_special_point
