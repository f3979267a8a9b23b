!> Branch points in a step along a branch: where the determinant of the motions that keep their symmetry changes sign, and where
!> that of a part does in which equal branches cease to move as they do.
module geartrain_trace_crossings
   use geartrain_base_kinds, only: dp
   use geartrain_trace_branch, only: branch_type
   use geartrain_trace_corrector, only: corrector_type, solution_point_type
   use geartrain_trace_singular_search, only: find_crossing
   use geartrain_trace_special_points, only: add_special_point
   implicit none (type, external)
   private
   public :: add_branch_point, crossing_type, find_crossings

   !> Relative distance in Lambda of branch points that are one.
   real(dp), parameter :: together = 1e-6_dp

   !> A branch point in a step.
   type :: crossing_type
      !> Lambda [1].
      real(dp) :: frequency_ratio = 0
      !> Number of multipliers that pass +1 together.
      integer :: multiplicity = 1
      !> Rms over characteristic length [1], (mesh).
      real(dp), allocatable :: rms(:)
      !> Where in the step, as a share of its length [1]: the search may end a little outside the step.
      real(dp) :: share = 0
   end type crossing_type

contains

   !> Finds the branch points in a step, and those at which equal branches begin to move differently.
   !> Where motions of unequal branches cross one of equal branches both are there: they count as one.
   subroutine find_crossings(corrector, here, next, h, crosses, success, found)
      type(corrector_type), intent(in) :: corrector
      !> Ends of the step.
      type(solution_point_type), intent(in) :: here, next
      !> Length of the step, in the metric of the branch [1].
      real(dp), intent(in) :: h
      !> The bordered determinant changes sign; the step succeeded, else nothing is sought.
      logical, intent(in) :: crosses, success
      !> The branch points.
      type(crossing_type), allocatable, intent(out) :: found(:)
      type(crossing_type) :: one
      real(dp) :: way
      logical :: located, same
      integer :: g, changed

      allocate (found(0))
      if (.not. success) return
      changed = 0
      if (min(here%differences, next%differences) >= 0) changed = ieor(here%differences, next%differences)
      do g = 0, bit_size(changed) - 1
         if (g == 0 .and. .not. crosses) cycle
         if (g > 0) then
            if (.not. btest(changed, g - 1)) cycle
            one%multiplicity = corrector%fixed%modes_of(g)
         end if
         call find_crossing(corrector, here, h, g, one%frequency_ratio, one%rms, way, located)
         if (.not. located) cycle
         one%share = way/h
         same = .false.
         if (size(found) > 0) same = abs(found(1)%frequency_ratio - one%frequency_ratio) < together*abs(one%frequency_ratio)
         if (same) then
            found(1)%multiplicity = found(1)%multiplicity + one%multiplicity
         else
            found = [found, one]
         end if
      end do
   end subroutine find_crossings

   !> Lists a branch point of the latest step, unless it is listed already: the sign of the determinant, found by the
   !> lowest harmonics alone, may change repeatedly near a branch point.
   subroutine add_branch_point(branch, before, crossing)
      !> Branch whose `special_points` grow.
      type(branch_type), intent(inout), target :: branch
      !> Number of the point at which the step began; a fold within the step is a point as well.
      integer, intent(in) :: before
      !> The branch point.
      type(crossing_type), intent(in) :: crossing
      integer, parameter :: nearby = 50
      real(dp) :: arclength
      integer :: point

      associate (special => branch%special_points, n => branch%points, frequency_ratio => crossing%frequency_ratio)
         if (any(special%kind == 'branch point' .and. special%point > n - nearby &
                 .and. abs(special%frequency_ratio - frequency_ratio) < 1e-8_dp*abs(frequency_ratio))) return
         arclength = branch%arclength(before) + crossing%share*(branch%arclength(n) - branch%arclength(before))
         point = n - 1
         if (arclength < branch%arclength(point)) point = before
         call add_special_point(branch, 'branch point', frequency_ratio, point, crossing%rms, crossing%multiplicity, arclength)
      end associate
   end subroutine add_branch_point

end module geartrain_trace_crossings
