!> Traces a branch through its excursions above the amplitude limit, which are followed unrecorded until the branch comes back.
!>
!> At infinite amplitude the gap no longer matters: the branch climbs along s phi, phi an eigenfunction of the linear train with
!> multiplier +1, and comes back along -s phi, as every resonance of a linear train without loss does. So the branch is followed
!> with steps in proportion to its amplitude until s is large; there its sign is changed, and Lambda follows from the balance.
module geartrain_trace_large_amplitude
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_base_words, only: lambda, operator(//), words_type
   use geartrain_linalg_trigonometric, only: inner, rms
   use geartrain_trace_branch, only: branch_type
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_trace_step_geometry, only: odd_product
   use geartrain_trace_step_length, only: acceptable, next_step
   use geartrain_trace_tracer, only: came_back, closed_loop, left_by_amplitude, met_half_period, reached_end, &
      tracer_type, went_round
   implicit none (type, external)
   private
   public :: followed_out, trace_through

   !> Outcomes of a trace in addition to the outcomes of the tracer: above the amplitude limit the branch left the range of Lambda;
   !> it comes back as its own mirror image, shifted by half its period.
   integer, parameter :: left_range = 101, came_mirrored = 102
   !> Further outcomes above the limit: below the limit again; not to be followed further.
   integer, parameter :: came_down = 103, lost = 104

   !> Amplitude over the amplitude limit at which the sign is changed: the neglected terms are of the order of its inverse [1].
   real(dp), parameter :: far = 1e4_dp
   !> Largest step over the amplitude [1], smallest step [units_type], largest number of steps.
   real(dp), parameter :: largest_step = 0.2_dp, smallest_step = 1e-9_dp
   integer, parameter :: most_steps = 5000
   !> Most traces of the same piece of a branch, each with shorter steps.
   integer, parameter :: most_traces = 3

contains

   !> Whether a branch is complete: followed out of the range of Lambda, or to where only known motions follow.
   pure logical function followed_out(outcome)
      !> Outcome of `trace_through`.
      integer, intent(in) :: outcome

      followed_out = any(outcome == [reached_end, came_back, closed_loop, met_half_period, left_range, came_mirrored])
   end function followed_out

   !> Traces as the tracer does, and goes on wherever the branch comes back from above the amplitude limit, with a new segment.
   subroutine trace_through(tracer, solution, target, branch, outcome, reason, observer, began, point)
      !> A tracer for the branch.
      type(tracer_type), intent(inout) :: tracer
      !> Where the trace begins: solved, oriented, a point of the branch; changed on return.
      type(solution_point_type), intent(inout) :: solution
      !> The bound of the range of Lambda at which the trace ends as `reached_end`; at the other bound: `came_back` [1].
      real(dp), intent(in) :: target
      !> The points are appended to it. A target: an observer may read it through a pointer.
      type(branch_type), intent(inout), target :: branch
      !> How the trace ended: an outcome of the tracer or of this module, see `followed_out`.
      integer, intent(out) :: outcome
      !> Why the trace ended.
      type(words_type), allocatable, intent(out) :: reason
      !> Is told of each step, and may cancel.
      class(observer_type), intent(inout), optional :: observer
      !> First point of the branch, at which it may close; then on the harmonics in use.
      type(solution_point_type), intent(inout) :: began
      !> Index of the point `solution` on the branch; absent: the latest point.
      integer, intent(in), optional :: point
      type(words_type) :: before
      real(dp) :: left_at, low, high
      integer :: passage, first
      logical :: success

      low = min(tracer%settings%start, tracer%settings%stop)
      high = max(tracer%settings%start, tracer%settings%stop)
      before = words_type('')
      ! The response may have been above the limit in the run before a resumed one.
      if (allocated(branch%trace)) before = branch%trace%before
      first = branch%points
      if (present(point)) first = point
      do
         call trace_on()
         reason = before//reason
         if (outcome /= left_by_amplitude) return
         left_at = solution%frequency_ratio
         call pass_large_amplitude(tracer, solution, low, high, passage)
         if (passage == left_range) reason = reason//' and left the range of Lambda beyond it'
         if (passage == came_mirrored) reason = reason//' and comes back as its own mirror image, shifted by half its period'
         if (any(passage == [left_range, came_mirrored])) outcome = passage
         if (passage == lost) reason = reason//' and could not be followed beyond it; &
            &a larger amplitude_limit traces it there as usual'
         if (passage /= came_down) return
         call tracer%adapt(solution, success, origin=began)
         before = before//'beyond the amplitude limit '//text(tracer%amplitude_limit)//' from ' &
                  //lambda(left_at, solution%frequency_ratio)//'; '
         if (allocated(branch%trace)) branch%trace%before = before
         tracer%segment = tracer%segment + 1
         call tracer%record(solution, branch)
         first = branch%points
      end do

   contains

      !> Traces up to where the branch rises above the limit, anew with shorter steps where one of them led to a closed branch. The
      !> motion with which a resumed run began is not known.
      subroutine trace_on()
         type(solution_point_type) :: start, began_before
         real(dp) :: step
         integer :: points, special, missed, highest, k
         logical :: resumed

         start = solution
         began_before = began
         points = branch%points
         special = size(branch%special_points)
         missed = tracer%missed
         highest = tracer%corrector%balance%highest
         step = tracer%settings%step
         resumed = tracer%resumes
         if (resumed) tracer%settings%step = branch%trace%longest
         do k = 1, most_traces
            call tracer%trace(solution, low, high, target, branch, outcome, reason, observer, began, first)
            if (outcome /= went_round .or. resumed .or. k == most_traces) exit
            branch%points = points
            branch%special_points = branch%special_points(:special)
            tracer%missed = missed
            call tracer%prepare(highest, start%harmonic)
            solution = start
            began = began_before
            call tracer%corrector%correct(solution, success)
            tracer%settings%step = tracer%settings%step/3
         end do
         tracer%settings%step = step
      end subroutine trace_on

   end subroutine trace_through

   !> Follows the branch above the amplitude limit, unrecorded.
   subroutine pass_large_amplitude(tracer, solution, low, high, outcome)
      type(tracer_type), intent(inout) :: tracer
      !> Where the branch passed the limit; then, with `came_down`, the last point above the limit, so that nothing below it is
      !> left out.
      type(solution_point_type), intent(inout) :: solution
      !> Range of Lambda [1].
      real(dp), intent(in) :: low, high
      !> `came_down`, `left_range`, `came_mirrored` or `lost`.
      integer, intent(out) :: outcome
      type(solution_point_type) :: next
      real(dp) :: h, size
      integer :: steps
      logical :: success

      outcome = lost
      next = solution
      h = tracer%settings%step
      do steps = 1, most_steps
         call tracer%corrector%advance(solution, h, next, success)
         if (success) success = acceptable(tracer%corrector, solution, next, h)
         ! The last step, to below the limit, is not longer than a step of a recorded branch.
         if (success) success = h <= tracer%settings%step .or. amplitude(tracer, next) > tracer%amplitude_limit
         if (.not. success) then
            h = h/3
            if (h < smallest_step) return
            cycle
         end if
         h = next_step(tracer%corrector, solution, next, h, largest_step*tracer%corrector%length_of(next%u))
         size = amplitude(tracer, next)
         if (next%frequency_ratio < low .or. next%frequency_ratio > high) outcome = left_range
         if (outcome == lost .and. size <= tracer%amplitude_limit) then
            call tracer%corrector%correct(solution, success)
            if (success) outcome = came_down
            return
         end if
         solution = next
         if (outcome /= lost) return
         if (size < far*tracer%amplitude_limit .or. inner(solution%tangent, solution%u) < 0) cycle
         ! A shift by half the period changes the sign of the odd harmonics; phi has only odd or only even harmonics.
         if (mod(tracer%corrector%balance%waves(), 2) == 0 .and. 2*odd_product(solution, solution) > sum(solution%u**2)) then
            outcome = came_mirrored
            return
         end if
         solution%u = -solution%u
         solution%tangent = -solution%u/tracer%corrector%length_of(solution%u)
         solution%tangent_frequency = 0
         call tracer%corrector%correct(solution, success)
         if (.not. success) return
      end do
   end subroutine pass_large_amplitude

   !> Largest rms of any mesh over characteristic length [1].
   real(dp) function amplitude(tracer, solution)
      type(tracer_type), intent(inout) :: tracer
      type(solution_point_type), intent(in) :: solution
      real(dp) :: coefficients(tracer%corrector%balance%block, tracer%system%meshes)
      integer :: j

      call tracer%corrector%balance%full_coefficients(solution%u, coefficients)
      amplitude = 0
      do j = 1, tracer%system%meshes
         amplitude = max(amplitude, rms(coefficients(:, j)))
      end do
   end function amplitude

end module geartrain_trace_large_amplitude
