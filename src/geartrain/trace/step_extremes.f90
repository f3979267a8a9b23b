!> Points within a step that readings of a branch need: where the rms of a mesh is highest, and where a mesh separates, touches or
!> collides at its back flanks for less than the step.
!>
!> Of each quantity the values at both ends of the step and the derivatives along the branch make a cubic: it says where to look.
!> The balance is solved there, and the step is cut at the first such point: it becomes a point of the branch.
module geartrain_trace_step_extremes
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_bracket, only: between, shrink
   use geartrain_linalg_cubic, only: highest_share, value_on
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: evaluate, extremes, fine_samples, own_resolution, rms
   use geartrain_mesh_law_law, only: depth_below
   use geartrain_trace_corrector, only: corrector_type, solution_point_type
   use geartrain_trace_step_geometry, only: arc_length, go_along
   implicit none (type, external)
   private
   public :: cut_at_extreme, quantities_type, solve_within

   !> Least distance of a point from the ends of a step, as a share of the step: an end may be the extreme itself.
   real(dp), parameter :: off_ends = 1e-3_dp
   !> Derivative of an rms at its maximum, over the derivatives at the ends of the step; of a balance whose tangents are iterative
   !> solutions.
   real(dp), parameter :: located = 1e-9_dp, located_iteratively = 1e-3_dp
   integer, parameter :: most_places = 30, smooth_places = 3
   !> The same of meshes whose peak the peak of another mesh is, as of two directions of a bearing, and of a peak that is met where
   !> a dip is within the step as well.
   real(dp), parameter :: flat = 1e-6_dp
   !> Times that a step is cut at a peak: where the derivative is not smooth, the cubic may show one in each piece.
   integer, parameter :: most_cuts = 3
   !> Height of a maximum above the ends of a step at which the rms rises, or falls, at both, over the rms: less is no maximum.
   real(dp), parameter :: least_height = 1e-6_dp
   !> Change of an rms over a step by its slopes at the ends, over the rms: less is rounding, in which there is no maximum to find.
   real(dp), parameter :: constant = 1e-9_dp
   !> Distance of the mean from the edge of the gap over the sum of the amplitudes above which that sum bounds the depth of a mesh,
   !> where the period is long: without samples of all its cycles.
   real(dp), parameter :: far_off = 1.3_dp
   !> How near a depth comes to 0, over what it varies by in the step, for the balance to be solved there.
   real(dp), parameter :: near = 0.1_dp
   !> Largest distance of a point from the cubic, as a share of the length of the cubic.
   real(dp), parameter :: off_cubic = 0.2_dp
   !> Part of the unit of length of the branch over which coefficients of linear meshes are differentiated.
   real(dp), parameter :: difference = 1e-7_dp
   !> Rounding of these coefficients over the rms.
   real(dp), parameter :: rounding = 256*epsilon(1.0_dp)

   !> Quantities of the meshes at a solution point, and their derivatives along the branch.
   type :: quantities_type
      !> Rms over characteristic length [1], (mesh).
      real(dp), allocatable :: rms(:), rms_slope(:)
      !> Depth of separation and of back collision, see depth_below, over characteristic length [1], (mesh, 2); half backlash [1].
      real(dp), allocatable :: depth(:, :), depth_slope(:, :), gap(:)
   contains
      procedure :: find
   end type quantities_type

contains

   !> Finds the quantities of a solution point.
   subroutine find(self, corrector, transform, solution)
      class(quantities_type), intent(inout) :: self
      type(corrector_type), intent(inout) :: corrector
      !> Work space.
      type(transform_type), intent(inout) :: transform
      !> The point with its tangent.
      type(solution_point_type), intent(in) :: solution
      real(dp) :: u(corrector%balance%block, corrector%balance%system%meshes), rate(size(u, 1), size(u, 2))
      real(dp) :: extreme(2), at(2), slope(2), unused(2)
      integer :: highest, i, j

      call find_rates(corrector, solution, u, rate)
      associate (harmonic => corrector%balance%harmonic, system => corrector%balance%system)
         self%rms = [(rms(u(:, j)), j=1, system%meshes)]
         self%rms_slope = [(dot_product(u(2:, j), rate(2:, j)), j=1, system%meshes)]
         where (self%rms > 0) self%rms_slope = self%rms_slope/self%rms
         self%gap = system%half_backlash
         if (.not. allocated(self%depth)) allocate (self%depth(system%meshes, 2), self%depth_slope(system%meshes, 2))
         do j = 1, system%meshes
            if (.not. self%gap(j) > 0) cycle
            if (corrector%balance%has_long_period()) then
               call find_bounds(u(:, j), rate(:, j), extreme, slope)
               if (abs(u(1, j)) - self%gap(j) > far_off*(extreme(2) - u(1, j))) then
                  call put(j)
                  cycle
               end if
            end if
            highest = corrector%balance%highest
            if (corrector%balance%chosen) highest = own_resolution(u(:, j), harmonic)
            call transform%plan(fine_samples(highest))
            call extremes(u(:, j), harmonic, transform, extreme(1), extreme(2), at)
            do i = 1, 2
               call evaluate(rate(:, j), harmonic, at(i), slope(i), unused(1), unused(2))
            end do
            call put(j)
         end do
      end associate

   contains

      subroutine put(mesh)
         integer, intent(in) :: mesh

         associate (gap => self%gap(mesh))
            self%depth(mesh, 1) = depth_below(extreme(1), extreme(2), gap, .false.)
            self%depth(mesh, 2) = depth_below(extreme(1), extreme(2), gap, .true.)
            self%depth_slope(mesh, :) = slope(1)
            if (-gap - extreme(2) > extreme(1) - gap) self%depth_slope(mesh, 1) = -slope(2)
         end associate
      end subroutine put

   end subroutine find

   !> Bounds of a displacement by the sum of its amplitudes, and their derivatives along the branch: far from all walls they do for
   !> its extremes.
   pure subroutine find_bounds(u, rate, bound, slope)
      !> Coefficients and their derivatives, (1 + 2*harmonics).
      real(dp), intent(in) :: u(:), rate(:)
      !> Lower and upper bound, and derivatives.
      real(dp), intent(out) :: bound(2), slope(2)
      real(dp) :: amplitude
      integer :: k

      bound = u(1)
      slope = rate(1)
      do k = 2, size(u) - 1, 2
         amplitude = hypot(u(k), u(k + 1))
         bound = bound + [-1, 1]*amplitude
         if (amplitude > 0) slope = slope + [-1, 1]*dot_product(u(k:k + 1), rate(k:k + 1))/amplitude
      end do
   end subroutine find_bounds

   !> Coefficients of all meshes and their derivatives along the branch, those of linear meshes by a difference.
   subroutine find_rates(corrector, solution, u, rate)
      type(corrector_type), intent(inout) :: corrector
      type(solution_point_type), intent(in) :: solution
      real(dp), intent(out) :: u(:, :), rate(:, :)
      real(dp) :: h

      associate (balance => corrector%balance)
         if (balance%unknowns < size(u, 2)) then
            h = difference
            if (.not. balance%reaches(solution%frequency_ratio + h*solution%tangent_frequency)) h = -h
            call balance%evaluate(solution%u + h*solution%tangent, solution%frequency_ratio + h*solution%tangent_frequency)
            call balance%full_coefficients(solution%u + h*solution%tangent, rate)
         end if
         ! Newton's method evaluates the balance before its last step.
         if (allocated(balance%path) .or. balance%unknowns < size(u, 2)) &
            call balance%evaluate(solution%u, solution%frequency_ratio)
         call balance%full_coefficients(solution%u, u)
         if (balance%unknowns < size(u, 2)) rate = (rate - u)/h
         rate(:, balance%mesh) = solution%tangent
      end associate
   end subroutine find_rates

   !> Cuts a step at the first point that readings need, if any.
   subroutine cut_at_extreme(corrector, transform, here, at_here, next, at_next, cut)
      !> Corrector of the branch; it worked on `next` last.
      type(corrector_type), intent(inout) :: corrector
      !> Work space.
      type(transform_type), intent(inout) :: transform
      !> Beginning of the step.
      type(solution_point_type), intent(in) :: here
      !> Quantities of the meshes there.
      type(quantities_type), intent(in) :: at_here
      !> End of the step.
      type(solution_point_type), intent(inout) :: next
      !> Quantities of the meshes there.
      type(quantities_type), intent(inout) :: at_next
      !> `next` became a point within the step.
      logical, intent(out) :: cut
      type(solution_point_type) :: end
      integer :: evaluated, i
      logical :: found

      end = next
      evaluated = corrector%evaluations
      call cut_at_contact(corrector, transform, here, at_here, next, at_next, cut)
      do i = 1, most_cuts
         call cut_at_peak(corrector, transform, here, at_here, next, at_next, found)
         if (.not. found) exit
         cut = .true.
      end do
      if (cut .or. evaluated == corrector%evaluations) return
      ! The point is recorded by what the corrector worked on last.
      call corrector%correct(next, found)
      next = end
   end subroutine cut_at_extreme

   !> Cuts a step where a mesh loses or finds contact for less than the step.
   subroutine cut_at_contact(corrector, transform, here, at_here, next, at_next, cut)
      type(corrector_type), intent(inout) :: corrector
      type(transform_type), intent(inout) :: transform
      type(solution_point_type), intent(in) :: here
      type(quantities_type), intent(in) :: at_here
      type(solution_point_type), intent(inout) :: next
      type(quantities_type), intent(inout) :: at_next
      logical, intent(out) :: cut
      type(solution_point_type) :: point
      type(quantities_type) :: at_point
      real(dp) :: length, y(2), slope(2), share, sense, widens
      integer :: j, k
      logical :: success

      cut = .false.
      length = arc_length(here, next, corrector%units)
      do k = 1, 2
         do j = 1, size(at_here%gap)
            if (.not. min(at_here%gap(j), at_next%gap(j)) > 0) cycle
            y = [at_here%depth(j, k), at_next%depth(j, k)]
            if (.not. y(1)*y(2) > 0) cycle
            ! A depth above 0 may have a minimum below 0 within the step; one below 0 a maximum above.
            sense = merge(-1, 1, y(1) > 0)
            widens = merge(-1, 1, k == 1)*(at_next%gap(j) - at_here%gap(j))/length
            slope = [at_here%depth_slope(j, k), at_next%depth_slope(j, k)] + widens
            y = sense*y
            slope = sense*slope*length
            share = highest_share(y, slope)
            if (share < off_ends .or. share > 1 - off_ends) cycle
            if (value_on(y, slope, share) < -near*(value_on(y, slope, share) - minval(y))) cycle
            call solve_within(corrector, transform, here, next, share, point, at_point, success)
            if (.not. success) cycle
            if (sense*at_point%depth(j, k) <= 0) cycle
            next = point
            at_next = at_point
            cut = .true.
            return
         end do
      end do
   end subroutine cut_at_contact

   !> Cuts a step where the rms of a mesh is highest, at the first mesh.
   subroutine cut_at_peak(corrector, transform, here, at_here, next, at_next, cut)
      type(corrector_type), intent(inout) :: corrector
      type(transform_type), intent(inout) :: transform
      type(solution_point_type), intent(in) :: here
      type(quantities_type), intent(in) :: at_here
      type(solution_point_type), intent(inout) :: next
      type(quantities_type), intent(inout) :: at_next
      logical, intent(out) :: cut
      type(solution_point_type) :: first, last, point
      type(quantities_type) :: at_first, at_last, at_point
      !> Place and slope at the latest two places.
      real(dp) :: known(2, 2)
      real(dp) :: length, share, least, steepest, enough, a, b, fa, fb
      integer :: j, mesh, i, kept
      logical :: turns

      cut = .false.
      least = 1 - off_ends
      mesh = 0
      length = arc_length(here, next, corrector%units)
      do j = 1, size(at_here%rms)
         share = peak_share(at_here, at_next, j, length)
         if (share < off_ends .or. share >= least) cycle
         least = share
         mesh = j
      end do
      if (mesh == 0) return
      first = here
      last = next
      at_first = at_here
      at_last = at_next
      steepest = max(abs(at_here%rms_slope(mesh)), abs(at_next%rms_slope(mesh)))
      enough = steepest*merge(located_iteratively, located, corrector%balance%chosen .and. .not. corrector%balance%is_direct())
      ! The slope of a linear mesh is a difference, and no more exact than its rounding.
      if (.not. any(corrector%balance%mesh == mesh)) enough = max(enough, rounding/difference*at_here%rms(mesh))
      turns = at_here%rms_slope(mesh) > 0 .and. at_next%rms_slope(mesh) <= 0
      share = least
      known = 0
      kept = 0
      a = 0
      b = 1
      fa = at_here%rms_slope(mesh)
      fb = at_next%rms_slope(mesh)
      do i = 1, most_places
         call solve_within(corrector, transform, first, last, share, point, at_point, cut)
         if (.not. cut) return
         if (.not. turns .or. abs(at_point%rms_slope(mesh)) < enough) exit
         known(:, 1) = known(:, 2)
         known(:, 2) = [a + share*(b - a), at_point%rms_slope(mesh)]
         call shrink(a, b, fa, fb, known(1, 2), known(2, 2), kept)
         if (at_point%rms_slope(mesh) > 0) then
            first = point
            at_first = at_point
         else
            last = point
            at_last = at_point
         end if
         ! The chord through the latest two places, where it does well. Where a mesh begins to separate the derivative has a kink,
         ! at which the cubic is no help.
         share = -1
         if (i > 1 .and. 2*abs(known(2, 2)) < abs(known(2, 1))) &
            share = (known(1, 2) - known(2, 2)*(known(1, 2) - known(1, 1))/(known(2, 2) - known(2, 1)) - a)/(b - a)
         if (.not. (share > 0 .and. share < 1)) then
            if (i > smooth_places) then
               share = (between(a, b, fa, fb) - a)/(b - a)
            else
               share = peak_share(at_first, at_last, mesh, arc_length(first, last, corrector%units))
            end if
         end if
         share = max(1e-9_dp, min(1 - 1e-9_dp, share))
         if (b - a < off_ends*located) exit
      end do
      next = point
      ! Rounding would let a peak be one of the step before or of the next step; other meshes may have theirs there too.
      where (abs(at_point%rms_slope) < flat*max(abs(at_here%rms_slope), abs(at_next%rms_slope))) at_point%rms_slope = 0
      if (turns) at_point%rms_slope(mesh) = 0
      at_next = at_point
   end subroutine cut_at_peak

   !> Share of a step at which the rms of a mesh is highest by the cubic; -1: at none.
   pure real(dp) function peak_share(first, last, mesh, length) result(share)
      !> Quantities at both ends.
      type(quantities_type), intent(in) :: first, last
      integer, intent(in) :: mesh
      !> Length of the step [1].
      real(dp), intent(in) :: length
      real(dp) :: y(2), slope(2)

      y = [first%rms(mesh), last%rms(mesh)]
      slope = [first%rms_slope(mesh), last%rms_slope(mesh)]*length
      share = -1
      if (maxval(abs(slope)) < constant*maxval(y)) return
      share = highest_share(y, slope)
      if (slope(1) > 0 .and. slope(2) <= 0 .or. share < 0) return
      ! Between two points on one side of a peak: a peak and a dip within the step.
      if (value_on(y, slope, share) - maxval(y) < least_height*maxval(y) .and. minval(slope)*maxval(slope) > 0) share = -1
      if (slope(1) <= 0 .and. slope(2) > 0) share = -1
   end function peak_share

   !> Solves the balance at a share of a step, where the cubic leads.
   subroutine solve_within(corrector, transform, first, last, share, point, at_point, success)
      type(corrector_type), intent(inout) :: corrector
      !> Work space.
      type(transform_type), intent(inout) :: transform
      !> Ends of the step.
      type(solution_point_type), intent(in) :: first, last
      !> The share.
      real(dp), intent(in) :: share
      !> The solution.
      type(solution_point_type), intent(inout) :: point
      !> Quantities of the meshes there.
      type(quantities_type), intent(inout) :: at_point
      !> Newton's method has converged next to the cubic.
      logical, intent(out) :: success
      type(solution_point_type) :: guess

      guess = last
      call go_along(first, last, share, corrector%units, guess)
      point = guess
      call corrector%correct(point, success)
      if (success) success = corrector%length_of(point%u - guess%u, point%frequency_ratio - guess%frequency_ratio) &
                             < off_cubic*arc_length(first, last, corrector%units)
      if (success) call at_point%find(corrector, transform, point)
   end subroutine solve_within

end module geartrain_trace_step_extremes
