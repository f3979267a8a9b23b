!> Ranges of Lambda in which a mesh separates, or its back flanks collide, at some instant of the period.
module geartrain_readings_contact_ranges
   use geartrain_base_kinds, only: dp
   use geartrain_mesh_law_law, only: depth_below
   use geartrain_readings_curve, only: way_between
   use geartrain_readings_summary, only: band_type, change
   use geartrain_trace_branch, only: branch_type, gap_along
   use geartrain_trace_decided, only: joined
   use geartrain_trace_stages, only: no_stage
   implicit none (type, external)
   private
   public :: back_collision_ranges, drive_collision_ranges, separation_ranges

   real(dp), parameter :: none = huge(1.0_dp)

contains

   !> Ranges of Lambda with |p| < b at some instant, ascending. Their ends are where the smallest displacement is b: as
   !> locate_contact_edges found them, or interpolated between two points.
   pure function separation_ranges(branch, mesh, stable_only) result(ranges)
      type(branch_type), intent(in) :: branch
      !> Number of the mesh.
      integer, intent(in) :: mesh
      !> Counts stable motions only; else all motions of the branch.
      logical, intent(in) :: stable_only
      !> Empty for a mesh without backlash.
      type(band_type), allocatable :: ranges(:)

      ranges = ranges_below_zero(branch, mesh, .false., stable_only)
   end function separation_ranges

   !> Ranges of Lambda with p < -b at some instant, ascending.
   pure function back_collision_ranges(branch, mesh, stable_only) result(ranges)
      type(branch_type), intent(in) :: branch
      !> Number of the mesh.
      integer, intent(in) :: mesh
      !> Counts stable motions only; else all motions of the branch.
      logical, intent(in) :: stable_only
      !> Empty for a mesh without backlash.
      type(band_type), allocatable :: ranges(:)

      ranges = ranges_below_zero(branch, mesh, .true., stable_only)
   end function back_collision_ranges

   !> Ranges of Lambda with p > b at some instant, ascending: where a mesh loaded on its coast flank hits its drive flank. Their
   !> ends are interpolated between two points.
   pure function drive_collision_ranges(branch, mesh, stable_only) result(ranges)
      type(branch_type), intent(in) :: branch
      !> Number of the mesh.
      integer, intent(in) :: mesh
      !> Counts stable motions only; else all motions of the branch.
      logical, intent(in) :: stable_only
      !> Empty for a mesh without backlash.
      type(band_type), allocatable :: ranges(:)

      ranges = ranges_below_zero(branch, mesh, .true., stable_only, mirrored=.true.)
   end function drive_collision_ranges

   !> Union of the pieces of the branch on which depth_below of a mesh is negative.
   pure function ranges_below_zero(branch, mesh, back, stable_only, mirrored) result(ranges)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: mesh
      logical, intent(in) :: back, stable_only
      !> Present: of the other flank, whose edges are not located.
      logical, intent(in), optional :: mirrored
      type(band_type), allocatable :: ranges(:)
      real(dp) :: from, to, edge, distance(branch%points), gap(branch%points)
      integer :: i

      allocate (ranges(0))
      gap = gap_along(branch, mesh)
      if (.not. any(gap > 0)) return
      associate (n => branch%points)
         distance = depth_below(branch%minimum(mesh, :n), branch%maximum(mesh, :n), gap, back)
         if (present(mirrored)) distance = depth_below(-branch%maximum(mesh, :n), -branch%minimum(mesh, :n), gap, back)
         ! A mesh without backlash neither separates nor collides.
         where (.not. gap > 0) distance = max(distance, 0.0_dp)
      end associate
      if (stable_only .and. .not. allocated(branch%stable)) return
      do i = 1, branch%points - 1
         if (.not. joined(branch, i) .or. .not. any(distance(i:i + 1) < 0)) cycle
         from = branch%frequency_ratio(i)
         to = branch%frequency_ratio(i + 1)
         if (distance(i)*distance(i + 1) < 0) then
            edge = none
            if (.not. present(mirrored)) edge = located_edge(branch, mesh, back, i)
            if (edge >= none) edge = crossing(branch, distance, i)
            if (distance(i) < 0) to = edge
            if (distance(i + 1) < 0) from = edge
         end if
         if (stable_only) then
            if (.not. any(branch%stable(i:i + 1))) cycle
            if (.not. branch%stable(i)) call cut(from, to, change(branch, i))
            if (.not. branch%stable(i + 1)) call cut(to, from, change(branch, i))
            if ((to - from)*(branch%frequency_ratio(i + 1) - branch%frequency_ratio(i)) <= 0) cycle
         end if
         call add(ranges, band_type(min(from, to), max(from, to)))
      end do
      ! A closed branch ends at its first motion. With other harmonics the Lambda of the last point differs slightly.
      associate (n => branch%points)
         if (.not. branch%closed .or. n < 2) return
         if (distance(1) >= 0 .or. distance(n) >= 0) return
         if (stable_only) then
            if (.not. (branch%stable(1) .and. branch%stable(n))) return
         end if
         from = min(branch%frequency_ratio(1), branch%frequency_ratio(n))
         to = max(branch%frequency_ratio(1), branch%frequency_ratio(n))
      end associate
      call add(ranges, band_type(from, to))
   end function ranges_below_zero

   !> Lambda of the edge that locate_contact_edges found between points i and i + 1; or `none`.
   pure real(dp) function located_edge(branch, mesh, back, i)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: mesh, i
      logical, intent(in) :: back
      integer :: k

      located_edge = none
      if (.not. allocated(branch%contact_edges)) return
      do k = 1, size(branch%contact_edges)
         associate (edge => branch%contact_edges(k))
            if (edge%point == i .and. edge%mesh == mesh .and. (edge%back .eqv. back) .and. edge%stage == no_stage) &
               located_edge = edge%frequency_ratio
         end associate
      end do
   end function located_edge

   !> Moves `end` to `edge` where `edge` lies in the direction from `end` to `other`.
   elemental subroutine cut(end, other, edge)
      real(dp), intent(inout) :: end
      real(dp), intent(in) :: other, edge

      if ((edge - end)*(other - end) > 0) end = edge
   end subroutine cut

   !> Lambda between points i and i + 1 where `distance` crosses zero.
   !>
   !> Beyond the edge the time without contact grows with the square root of the depth: `distance` has no second derivative
   !> there. On the near side of the edge the curve is smooth. So parabolas over the chord length, through three points on the near
   !> side, are extrapolated to the edge. Where they have no root between the points i and i + 1, or there are no three points, the
   !> chord is taken.
   pure real(dp) function crossing(branch, distance, i)
      type(branch_type), intent(in) :: branch
      real(dp), intent(in) :: distance(:)
      integer, intent(in) :: i
      real(dp) :: s(4), left, right, middle
      integer :: k, along, point(4)

      associate (f => branch%frequency_ratio, d1 => distance(i), d2 => distance(i + 1))
         crossing = f(i) + (f(i + 1) - f(i))*d1/(d1 - d2)
         ! From the point on the far side of the edge to the near side.
         along = merge(1, -1, d1 < 0)
         point = merge(i, i + 1, d1 < 0) + along*[0, 1, 2, 3]
         if (minval(point) < 1 .or. maxval(point) > branch%points) return
         if (any(distance(point(2:)) < 0)) return
         s(1) = 0
         do k = 2, 4
            if (.not. joined(branch, min(point(k - 1), point(k)))) return
            s(k) = s(k - 1) + way_between(branch, point(k - 1), point(k))
         end do
         if (s(4) - s(2) < s(2) - s(1)) return
         left = s(1)
         right = s(2)
         if (interpolated(s(2:), distance(point(2:)), left) > 0) return
         do k = 1, 50
            middle = (left + right)/2
            if (interpolated(s(2:), distance(point(2:)), middle) < 0) then
               left = middle
            else
               right = middle
            end if
         end do
         middle = interpolated(s(2:), f(point(2:)), middle)
         if ((middle - f(i))*(middle - f(i + 1)) < 0) crossing = middle
      end associate
   end function crossing

   !> Lagrange's polynomial through (s, f) at x.
   pure real(dp) function interpolated(s, f, x)
      real(dp), intent(in) :: s(:), f(:), x
      real(dp) :: factor
      integer :: j, k

      interpolated = 0
      do k = 1, size(s)
         factor = 1
         do j = 1, size(s)
            if (j /= k) factor = factor*(x - s(j))/(s(k) - s(j))
         end do
         interpolated = interpolated + f(k)*factor
      end do
   end function interpolated

   !> Adds a piece to ascending ranges that do not touch each other; joins the ranges that `piece` touches.
   pure subroutine add(ranges, piece)
      type(band_type), allocatable, intent(inout) :: ranges(:)
      type(band_type), intent(in) :: piece
      type(band_type) :: whole
      logical :: below(size(ranges)), above(size(ranges))
      real(dp) :: slack

      whole = piece
      ! Neighbouring pieces of the branch have an equal end, but for rounding.
      slack = 1e-12_dp*max(abs(piece%from), abs(piece%to))
      below = ranges%to < piece%from - slack
      above = ranges%from > piece%to + slack
      if (count(.not. (below .or. above)) == 1) then
         ! As a rule.
         where (.not. (below .or. above))
            ranges%from = min(ranges%from, piece%from)
            ranges%to = max(ranges%to, piece%to)
         end where
         return
      end if
      if (.not. all(below .or. above)) then
         whole%from = min(piece%from, minval(ranges%from, .not. (below .or. above)))
         whole%to = max(piece%to, maxval(ranges%to, .not. (below .or. above)))
      end if
      ranges = [pack(ranges, below), whole, pack(ranges, above)]
   end subroutine add

end module geartrain_readings_contact_ranges
