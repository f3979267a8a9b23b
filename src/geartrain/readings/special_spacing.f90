!> Points that readings of a branch need once its trace ended: between special points that lie within one step, so that each change
!> of stability has a point on either side, and where a jump leads to.
module geartrain_readings_special_spacing
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_cubic, only: share_at
   use geartrain_readings_jumps, only: jump_type, jumps
   use geartrain_trace_branch, only: arrange_points, branch_type, carried_by
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_trace_decided, only: joined
   use geartrain_trace_points, only: motion_of
   use geartrain_trace_start, only: solution_of
   use geartrain_trace_step_geometry, only: arc_length, go_along
   use geartrain_trace_tracer, only: tracer_type
   implicit none (type, external)
   private
   public :: add_points_between

   !> Distance of special points below which they are one, in the metric of the branch.
   real(dp), parameter :: together = 1e-7_dp
   !> Points added at most.
   integer, parameter :: most_points = 500

contains

   !> Adds the points.
   subroutine add_points_between(tracer, branch)
      !> Tracer of the branch.
      type(tracer_type), intent(inout) :: tracer
      !> A branch whose trace ended.
      type(branch_type), intent(inout), target :: branch
      real(dp), allocatable :: places(:)
      real(dp) :: length
      type(jump_type), allocatable :: found(:)
      integer :: traced, i, k

      if (.not. tracer%recorder%stability .or. branch%cancelled) return
      traced = branch%points
      do i = 1, traced - 1
         if (.not. joined(branch, i)) cycle
         places = places_in(branch, i)
         do k = 1, size(places) - 1
            if (places(k + 1) - places(k) < together .or. branch%points - traced == most_points) cycle
            call add_point(tracer, branch, i, ((places(k) + places(k + 1))/2 - branch%arclength(i)) &
                           /(branch%arclength(i + 1) - branch%arclength(i)))
         end do
      end do
      if (branch%points > traced) call sort_in(branch, traced)
      traced = branch%points
      ! Not by associate: gfortran 12 does not free the result of a function there.
      found = jumps(branch)
      do k = 1, size(found)
         i = found(k)%point
         if (i == 0) cycle
         if (any(abs(branch%frequency_ratio(i:i + 1) - found(k)%frequency_ratio) <= 0)) cycle
         length = branch%arclength(i + 1) - branch%arclength(i)
         call add_point(tracer, branch, i, share_at(branch%frequency_ratio(i:i + 1), length*branch%free_slope(i:i + 1), &
                                                    found(k)%frequency_ratio), found(k)%frequency_ratio)
      end do
      if (branch%points > traced) call sort_in(branch, traced)
   end subroutine add_points_between

   !> Lengths of the branch up to the special points in the step from point i, folds at its ends included, ascending.
   pure function places_in(branch, i) result(places)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: i
      real(dp), allocatable :: places(:)
      integer :: k

      allocate (places(0))
      associate (special => branch%special_points, along => branch%arclength)
         if (any(special%kind == 'fold' .and. special%point == i)) places = [along(i)]
         do k = 1, size(special)
            if (special(k)%point /= i .or. special(k)%arclength <= along(i) .or. special(k)%arclength >= along(i + 1)) cycle
            places = [pack(places, places <= special(k)%arclength), special(k)%arclength, &
                      pack(places, places > special(k)%arclength)]
         end do
         if (any(special%kind == 'fold' .and. special%point == i + 1)) places = [places, along(i + 1)]
      end associate
   end function places_in

   !> Appends a point of a step; none where Newton's method fails.
   subroutine add_point(tracer, branch, i, share, frequency_ratio)
      type(tracer_type), intent(inout) :: tracer
      type(branch_type), intent(inout), target :: branch
      integer, intent(in) :: i
      !> Where, as a share of the step.
      real(dp), intent(in) :: share
      !> Lambda that the point is to have [1].
      real(dp), intent(in), optional :: frequency_ratio
      type(solution_point_type) :: ends(2), solved, point
      integer :: j
      logical :: success

      if (tracer%settings%harmonics == 0) call tracer%prepare(maxval(branch%point_harmonics(i:i + 1)), carried_by(branch, i, i + 1))
      do j = 1, 2
         ends(j) = solution_of(tracer, motion_of(branch, i + j - 1))
      end do
      do j = 1, 2
         ends(j)%tangent = ends(2)%u - ends(1)%u
         ends(j)%tangent_frequency = ends(2)%frequency_ratio - ends(1)%frequency_ratio
         solved = ends(j)
         call tracer%corrector%correct(solved, success)
         if (success) ends(j) = solved
         if (.not. success) return
      end do
      point = ends(1)
      call go_along(ends(1), ends(2), share, tracer%corrector%units, point)
      solved = point
      if (present(frequency_ratio)) then
         solved%frequency_ratio = frequency_ratio
         call tracer%corrector%solve_at(solved, success)
         if (success) call tracer%corrector%orient(solved, merge(1, -1, point%tangent_frequency > 0))
      else
         call tracer%corrector%correct(solved, success)
      end if
      if (success) success = tracer%corrector%length_of(solved%u - point%u) < arc_length(ends(1), ends(2), tracer%corrector%units)
      if (.not. success) return
      ! The error estimate needs the curvature of this step, not that of the step which the trace took last.
      tracer%curvature = (ends(2)%tangent_frequency - ends(1)%tangent_frequency)/arc_length(ends(1), ends(2), &
                                                                                            tracer%corrector%units)
      call tracer%record(solved, branch)
      branch%arclength(branch%points) = branch%arclength(i) + share*(branch%arclength(i + 1) - branch%arclength(i))
      branch%segment(branch%points) = branch%segment(i)
   end subroutine add_point

   !> Puts the points after number `traced` where they belong.
   subroutine sort_in(branch, traced)
      type(branch_type), intent(inout), target :: branch
      integer, intent(in) :: traced
      integer :: order(branch%points), i, k, n

      n = 0
      do i = 1, traced
         n = n + 1
         order(n) = i
         if (i == traced) exit
         do k = traced + 1, branch%points
            if (branch%segment(k) /= branch%segment(i) .or. branch%segment(i + 1) /= branch%segment(i)) cycle
            if (branch%arclength(k) <= branch%arclength(i) .or. branch%arclength(k) >= branch%arclength(i + 1)) cycle
            n = n + 1
            order(n) = k
         end do
      end do
      call renumber(branch, order)
      call arrange_points(branch, order, size(branch%frequency_ratio))
   end subroutine sort_in

   !> Gives the special points the numbers of their points in the new order: a change of stability lies after the last point before
   !> it.
   subroutine renumber(branch, order)
      type(branch_type), intent(inout) :: branch
      integer, intent(in) :: order(:)
      integer :: position(size(order)), i, k

      position(order) = [(i, i=1, size(order))]
      do k = 1, size(branch%special_points)
         associate (special => branch%special_points(k))
            i = position(special%point)
            if (special%arclength < huge(1.0_dp)) then
               do while (i < size(order))
                  if (branch%arclength(order(i + 1)) >= special%arclength) exit
                  if (branch%segment(order(i + 1)) /= branch%segment(order(i))) exit
                  i = i + 1
               end do
            end if
            special%point = i
         end associate
      end do
   end subroutine renumber

end module geartrain_readings_special_spacing
