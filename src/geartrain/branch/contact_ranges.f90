!> Ranges of Lambda over which a mesh separates, or its back flanks collide, somewhere in the period.
module geartrain_branch_contact_ranges
   use geartrain_base_kinds, only: dp
   use geartrain_branch_branch, only: branch_type
   use geartrain_branch_summary, only: band_type, change, joined
   implicit none (type, external)
   private
   public :: separation_ranges, back_collision_ranges

contains

   !> Where |p| < b at some instant, ascending: at any level of the branch, or at a stable one. An edge is where the smallest
   !> displacement touches b, interpolated between two points.
   pure function separation_ranges(branch, mesh, stable_only) result(ranges)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: mesh
      logical, intent(in) :: stable_only
      type(band_type), allocatable :: ranges(:)

      allocate (ranges(0))
      if (.not. has_backlash(branch, mesh)) return
      associate (n => branch%points, b => branch%backlash(mesh))
         ranges = ranges_below_zero(branch, max(branch%minimum(mesh, :n) - b, -b - branch%maximum(mesh, :n)), stable_only)
      end associate
   end function separation_ranges

   !> Where p < -b at some instant, likewise.
   pure function back_collision_ranges(branch, mesh, stable_only) result(ranges)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: mesh
      logical, intent(in) :: stable_only
      type(band_type), allocatable :: ranges(:)

      allocate (ranges(0))
      if (.not. has_backlash(branch, mesh)) return
      ranges = ranges_below_zero(branch, branch%minimum(mesh, :branch%points) + branch%backlash(mesh), stable_only)
   end function back_collision_ranges

   pure logical function has_backlash(branch, mesh)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: mesh

      has_backlash = .false.
      if (allocated(branch%backlash)) has_backlash = branch%backlash(mesh) > 0
   end function has_backlash

   !> Union of the pieces of the branch on which `distance` (point) is negative, linear between points.
   pure function ranges_below_zero(branch, distance, stable_only) result(ranges)
      type(branch_type), intent(in) :: branch
      real(dp), intent(in) :: distance(:)
      logical, intent(in) :: stable_only
      type(band_type), allocatable :: ranges(:)
      !> Shares of the way from point i to point i + 1.
      real(dp) :: from, to, edge
      real(dp) :: ends(2)
      integer :: i

      allocate (ranges(0))
      if (stable_only .and. .not. allocated(branch%stable)) return
      do i = 1, branch%points - 1
         if (.not. joined(branch, i) .or. .not. any(distance(i:i + 1) < 0)) cycle
         from = 0
         to = 1
         if (.not. all(distance(i:i + 1) < 0)) then
            edge = distance(i)/(distance(i) - distance(i + 1))
            if (distance(i) < 0) to = edge
            if (.not. distance(i) < 0) from = edge
         end if
         associate (a => branch%frequency(i), b => branch%frequency(i + 1))
            if (stable_only) then
               if (.not. any(branch%stable(i:i + 1))) cycle
               edge = 0.5_dp
               if (abs(b - a) > 0) edge = (change(branch, i) - a)/(b - a)
               if (.not. branch%stable(i)) from = max(from, edge)
               if (.not. branch%stable(i + 1)) to = min(to, edge)
               if (from >= to) cycle
            end if
            ends = [(1 - from)*a + from*b, (1 - to)*a + to*b]
         end associate
         call add(ranges, band_type(minval(ends), maxval(ends)))
      end do
   end function ranges_below_zero

   !> Adds a piece to ascending ranges that do not touch; what it touches becomes one with it.
   pure subroutine add(ranges, piece)
      type(band_type), allocatable, intent(inout) :: ranges(:)
      type(band_type), intent(in) :: piece
      type(band_type) :: whole
      logical :: below(size(ranges)), above(size(ranges))
      real(dp) :: slack

      whole = piece
      ! Neighbouring pieces share their end to the last bit; a fold is a point of the branch.
      slack = 1e-12_dp*piece%to
      below = ranges%to < piece%from - slack
      above = ranges%from > piece%to + slack
      if (.not. all(below .or. above)) then
         whole%from = min(piece%from, minval(ranges%from, .not. (below .or. above)))
         whole%to = max(piece%to, maxval(ranges%to, .not. (below .or. above)))
      end if
      ranges = [pack(ranges, below), whole, pack(ranges, above)]
   end subroutine add

end module geartrain_branch_contact_ranges
