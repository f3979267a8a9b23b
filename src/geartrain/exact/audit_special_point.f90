!> A special point of a branch against the exact branch: whether and where the exact branch has a special point of the kind, and how
!> many multipliers pass the unit circle there.
module geartrain_exact_audit_special_point
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_exact_audit_point, only: audit_point
   use geartrain_exact_audit_result, only: audit_row_type
   use geartrain_exact_exact_search, only: change_at, ends_of, find_exact
   use geartrain_exact_orbit_corrector, only: orbit_corrector_type, orbit_type
   use geartrain_exact_orbit_tests, only: critical, outside
   use geartrain_trace_branch, only: branch_type, multipliers_at
   use geartrain_trace_decided, only: nearest_decided
   implicit none (type, external)
   private
   public :: audit_special_point

   !> Distance from a special point to the orbits on either side whose multipliers are counted, in the units of units_type.
   real(dp), parameter :: beside = 1e-4_dp

contains

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
      type(orbit_type) :: first, last
      integer :: ends(2), sides(2)
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
      ends = ends_of(branch, branch%special_points(special))
      sides = 0
      if (allocated(branch%stable)) then
         sides = [nearest_decided(branch, special, -1), nearest_decided(branch, special, 1)]
         associate (before => multipliers_at(branch, merge(sides(1), ends(1), sides(1) > 0)), &
                    after => multipliers_at(branch, merge(sides(2), ends(2), sides(2) > 0)))
            row%verdict = counts(before, after)
         end associate
      end if
      associate (listed => branch%special_points(special))
         call find_exact(corrector, branch, listed, change_at(branch, special, listed), exact, found)
      end associate
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
         if (row%verdict_wrong) row%finding = 'stability wrong'
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
                    .and. critical(kind, multipliers_at(branch, i)) /= critical(kind, orbit%multipliers)
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

   !> Multipliers outside the unit circle before and after a special point, in words.
   pure function counts(before, after) result(words)
      complex(dp), intent(in) :: before(:), after(:)
      character(16) :: words

      words = text(outside(before))//' -> '//text(outside(after))
   end function counts

end module geartrain_exact_audit_special_point
