!> A branch between neighbouring points, as readings see it: Lambda and the rms of a mesh as cubics along the branch, through the
!> values and derivatives at the points. Without derivatives, as of results of an earlier version, those of parabolas through three
!> points, over the chord length.
module geartrain_readings_curve
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_cubic, only: highest_share, share_at, value_on
   use geartrain_trace_branch, only: branch_type
   use geartrain_trace_decided, only: joined
   implicit none (type, external)
   private
   public :: arc_type, arc_between, rms_at, way_between

   !> Slope at one end over that at the other up to which a curve is flat there.
   real(dp), parameter :: flat = 1e-6_dp

   !> Branch between two neighbouring points.
   type :: arc_type
      !> Lambda at both points, and its derivatives times the length of the branch between the points [1].
      real(dp) :: free(2) = 0, free_slope(2) = 0
      !> Likewise the rms of a mesh [1].
      real(dp) :: rms(2) = 0, rms_slope(2) = 0
   contains
      procedure :: peak
   end type arc_type

contains

   !> The branch between points i and i + 1.
   pure type(arc_type) function arc_between(branch, mesh, i) result(arc)
      type(branch_type), intent(in) :: branch
      !> Number of the mesh; index of the point.
      integer, intent(in) :: mesh, i
      real(dp) :: length
      integer :: k

      arc%free = branch%frequency_ratio(i:i + 1)
      arc%rms = branch%rms(mesh, i:i + 1)
      if (has_slopes(branch)) then
         length = branch%arclength(i + 1) - branch%arclength(i)
         arc%free_slope = branch%free_slope(i:i + 1)
         arc%rms_slope = branch%rms_slope(mesh, i:i + 1)
      else
         length = way_between(branch, i, i + 1)
         arc%free_slope = [(slope_at(branch, branch%frequency_ratio, k), k=i, i + 1)]
         arc%rms_slope = [(slope_at(branch, branch%rms(mesh, :), k), k=i, i + 1)]
      end if
      arc%free_slope = arc%free_slope*length
      arc%rms_slope = arc%rms_slope*length
   end function arc_between

   pure logical function has_slopes(branch)
      type(branch_type), intent(in) :: branch

      has_slopes = allocated(branch%arclength)
      if (has_slopes) has_slopes = size(branch%arclength) >= branch%points
   end function has_slopes

   !> Finds where the rms has a maximum between the points, its end included: where it rises at the first point and falls at the
   !> second, or against the slopes at both. A flat slope at the second point means that this point was solved at a maximum.
   pure subroutine peak(self, share, found)
      class(arc_type), intent(in) :: self
      !> Where, as a share of the length between the points.
      real(dp), intent(out) :: share
      !> There is one.
      logical, intent(out) :: found

      share = 0
      associate (slope => self%rms_slope, rise => self%rms(2) - self%rms(1), level => flat*maxval(abs(self%rms_slope)))
         found = slope(1) > level .and. slope(2) <= level .or. slope(1) < -level .and. slope(2) < -level .and. rise > 0 .or. &
                 slope(1) > level .and. slope(2) > level .and. rise < 0
         if (.not. found) return
         if (abs(slope(2)) <= level) then
            share = 1
         else
            share = highest_share(self%rms, slope)
            if (share < 0) share = merge(1, 0, rise > 0)
         end if
      end associate
   end subroutine peak

   !> Rms of each mesh at a value of Lambda between points i and i + 1 [1], (mesh).
   pure function rms_at(branch, i, frequency_ratio) result(rms)
      type(branch_type), intent(in) :: branch
      !> Index of the first point.
      integer, intent(in) :: i
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      real(dp) :: rms(branch%meshes)
      type(arc_type) :: arc
      integer :: j

      do j = 1, branch%meshes
         arc = arc_between(branch, j, i)
         if (.not. has_slopes(branch)) then
            ! The chord.
            arc%free_slope = arc%free(2) - arc%free(1)
            arc%rms_slope = arc%rms(2) - arc%rms(1)
         end if
         rms(j) = value_on(arc%rms, arc%rms_slope, share_at(arc%free, arc%free_slope, frequency_ratio))
      end do
   end function rms_at

   !> Length of the chord between two points of a branch, in Lambda and rms [1]; over a parameter in its share of the branch and the
   !> share of the largest rms.
   pure real(dp) function way_between(branch, i, j) result(way)
      type(branch_type), intent(in) :: branch
      !> Indices of the points.
      integer, intent(in) :: i, j
      real(dp) :: units(2)

      units = 1
      if (allocated(branch%parameter)) then
         associate (at => branch%frequency_ratio(:branch%points))
            units = [max(maxval(at) - minval(at), tiny(1.0_dp)), max(maxval(branch%rms(:, :branch%points)), tiny(1.0_dp))]
         end associate
      end if
      way = norm2([(branch%frequency_ratio(j) - branch%frequency_ratio(i))/units(1), &
                   (branch%rms(:, j) - branch%rms(:, i))/units(2)])
   end function way_between

   !> Derivative of y, (point), by the chord length at point i: of the parabola through it and its neighbours.
   pure real(dp) function slope_at(branch, y, i) result(slope)
      type(branch_type), intent(in) :: branch
      real(dp), intent(in) :: y(:)
      integer, intent(in) :: i
      real(dp) :: way(2), chord(2)
      logical :: there(2)

      there = .false.
      if (i > 1) there(1) = joined(branch, i - 1)
      if (i < branch%points) there(2) = joined(branch, i)
      way = 0
      chord = 0
      if (there(1)) way(1) = way_between(branch, i - 1, i)
      if (there(2)) way(2) = way_between(branch, i, i + 1)
      if (way(1) > 0) chord(1) = (y(i) - y(i - 1))/way(1)
      if (way(2) > 0) chord(2) = (y(i + 1) - y(i))/way(2)
      slope = 0
      if (all(way > 0)) then
         slope = (chord(1)*way(2) + chord(2)*way(1))/sum(way)
      else if (any(way > 0)) then
         slope = sum(chord)
      end if
   end function slope_at

end module geartrain_readings_curve
