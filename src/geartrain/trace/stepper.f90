!> Steps along a branch, from a solution point to the next, and the points recorded: what a trace is made of.
module geartrain_trace_stepper
   use geartrain_balance_whole_contacts, only: find_whole_contacts
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_words, only: operator(//)
   use geartrain_floquet_motion_contacts, only: motion_contacts_type
   use geartrain_linalg_cubic, only: share_at
   use geartrain_trace_branch, only: branch_type
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_trace_reading_extremes, only: cut_at_reading, values_type
   use geartrain_trace_recorder, only: recorder_type
   use geartrain_trace_resonance_stepper, only: resonance_stepper_type
   use geartrain_trace_step_extremes, only: cut_at_extreme, quantities_type
   use geartrain_trace_step_geometry, only: arc_length, cosine, cosine_limit, go_along, hides_folds
   use geartrain_trace_step_length, only: acceptable, carries_same, crosses_branch, curve_error, jump_step, &
      next_step, predict
   implicit none (type, external)
   private
   public :: stepper_type

   !> Largest change of Lambda in a step with sets of harmonics, over the range [1].
   real(dp), parameter :: widest = 0.01_dp
   !> Number of steps one after another whose end is not found with the harmonics that the tolerance needs, after which ends are
   !> kept with fewer, as points that miss the tolerance, until more are found again.
   integer, parameter :: most_refusals = 3
   !> Relative error of a mesh over the tolerance above which `ended` names the mesh.
   real(dp), parameter :: named_from = 3

   type, extends(resonance_stepper_type) :: stepper_type
      type(recorder_type) :: recorder
      !> Number of the segment of the branch that is traced.
      integer :: segment = 1
      !> Points that miss the tolerance, where harmonics = 0.
      integer :: missed = 0
      !> Latest steps whose end was not found with the harmonics that the tolerance needs.
      integer :: refusals = 0
      !> The point before the latest one, from which the next one is guessed; its coefficients are not allocated where there is
      !> none.
      type(solution_point_type) :: before
      !> Quantities of the meshes at the solution point of the latest `read`, and the evaluations of the balance until then.
      type(quantities_type) :: quantities
      integer, private :: read_at = -1
      !> Forces and torques where they were looked at latest.
      type(values_type), private :: readings
      !> Contacts over the period, where those of the balance are of a winding.
      type(motion_contacts_type), private :: whole
   contains
      procedure, private :: cut_at_other_readings
      procedure :: record, read, keep_equal, cut_step, shown_step, take_step, stop_at, adapt_end, tell_missed
   end type stepper_type

contains

   !> Adds a solution point to the branch.
   subroutine record(self, solution, branch, from, point)
      class(stepper_type), intent(inout) :: self
      !> Solution point that `corrector` worked on last.
      type(solution_point_type), intent(in) :: solution
      !> Branch that `recorder` was set up for.
      type(branch_type), intent(inout), target :: branch
      !> Solution point of the branch before it; absent: a segment begins.
      type(solution_point_type), intent(in), optional :: from
      !> Number of that point.
      integer, intent(in), optional :: point
      real(dp) :: arclength

      if (self%shows) call self%estimate_error(solution)
      call self%read(solution)
      arclength = 0
      if (present(from)) arclength = branch%arclength(point) + arc_length(from, solution, self%corrector%units)
      if (self%settings%harmonics == 0 .and. self%estimate%limited > self%settings%tolerance) self%missed = self%missed + 1
      associate (balance => self%corrector%balance)
         if (balance%is_wound()) then
            call find_whole_contacts(balance, solution%u, self%recorder%transform, self%whole)
            call self%recorder%add(balance, self%whole, solution, self%estimate, self%segment, branch)
         else
            call self%recorder%add(balance, balance, solution, self%estimate, self%segment, branch)
         end if
      end associate
      associate (n => branch%points)
         branch%arclength(n) = arclength
         branch%free_slope(n) = solution%tangent_frequency
         branch%rms_slope(:, n) = self%quantities%rms_slope
      end associate
   end subroutine record

   !> Finds the quantities of the meshes at the solution point that `corrector` worked on last, unless they are known already.
   subroutine read(self, solution)
      class(stepper_type), intent(inout) :: self
      !> Solution point with its tangent.
      type(solution_point_type), intent(in) :: solution

      if (self%read_at == self%corrector%evaluations) return
      self%read_at = self%corrector%evaluations
      call self%quantities%find(self%corrector, self%recorder%transform, solution)
   end subroutine read

   !> Keeps to motions in which equal branches move equally as they do at the beginning of the branch, and solves `here` there.
   subroutine keep_equal(self, here, origin)
      class(stepper_type), intent(inout) :: self
      !> Where a trace begins.
      type(solution_point_type), intent(inout) :: here
      !> First point of the branch.
      type(solution_point_type), intent(in) :: origin
      type(solution_point_type) :: before
      logical :: success

      call self%corrector%keep_equal(origin)
      if (self%corrector%fixed%is_whole() .and. .not. allocated(self%corrector%turn%orbit)) return
      before = here
      call self%corrector%correct(here, success)
      if (.not. success) here = before
      if (.not. success) here%orientation = 0
   end subroutine keep_equal

   !> Cuts a step at the first point within it that readings need, see geartrain_trace_step_extremes.
   subroutine cut_step(self, here, at_here, next, cut)
      class(stepper_type), intent(inout) :: self
      !> Beginning of the step.
      type(solution_point_type), intent(in) :: here
      !> Quantities of the meshes at `here`.
      type(quantities_type), intent(in) :: at_here
      !> End of the step, which `corrector` worked on last.
      type(solution_point_type), intent(inout) :: next
      !> `next` became a point within the step.
      logical, intent(out) :: cut

      cut = .false.
      call self%read(next)
      if (self%shows) call cut_at_extreme(self%corrector, self%recorder%transform, here, at_here, next, self%quantities, cut)
      if (self%shows) call self%cut_at_other_readings(here, next, cut)
      self%read_at = self%corrector%evaluations
   end subroutine cut_step

   !> Cuts a step in which a mode is in resonance where the force of a mesh or a bearing, or a torque, is highest.
   subroutine cut_at_other_readings(self, here, next, cut)
      class(stepper_type), intent(inout) :: self
      !> As of `cut_step`.
      type(solution_point_type), intent(in) :: here
      type(solution_point_type), intent(inout) :: next
      logical, intent(inout) :: cut
      logical :: again, near
      integer :: k

      if (.not. carries_same(here, next)) return
      associate (c => self%corrector, ends => [here%frequency_ratio, next%frequency_ratio])
         near = .false.
         do k = 1, size(next%harmonic)
            near = near .or. self%resonances%any_near(c%balance, next%harmonic(k), ends)
         end do
         if (.not. near) return
         call cut_at_reading(c, self%recorder%transform, here, next, self%quantities, &
                             self%recorder%shaft_torque, self%readings, again)
         cut = cut .or. again
      end associate
   end subroutine cut_at_other_readings

   !> Length of a step [1], shortened where a curve of rms drawn over it would miss dips: with sets of harmonics long steps follow a
   !> branch that is nearly straight in its coefficients.
   pure real(dp) function shown_step(self, h, here, low, high) result(step)
      class(stepper_type), intent(in) :: self
      !> Length of the step [1]; bounds of Lambda [1].
      real(dp), intent(in) :: h, low, high
      !> Where it begins.
      type(solution_point_type), intent(in) :: here

      step = h
      if (self%corrector%balance%chosen .and. h*abs(here%tangent_frequency) > widest*(high - low)) &
         step = widest*(high - low)/abs(here%tangent_frequency)
   end function shown_step

   !> Solves the next point: a distance h from `here`, or `origin` itself where the branch is closing. Where the tangent leads to or
   !> beyond the end of a path in a parameter, where there may be no train, the next point is at this end.
   subroutine take_step(self, here, origin, closing, h, low, high, next, off_curve, shorter, success)
      class(stepper_type), intent(inout) :: self
      !> Latest and first point of the branch.
      type(solution_point_type), intent(in) :: here, origin
      !> The step closes the branch.
      logical, intent(in) :: closing
      !> Length of the step [1]; bounds of Lambda [1].
      real(dp), intent(in) :: h, low, high
      !> The next point.
      type(solution_point_type), intent(inout) :: next
      !> Distance of the branch from the cubic through both points, where it is estimated [1].
      real(dp), intent(out) :: off_curve
      !> Length of the step to be tried where this one fails, over its length [1].
      real(dp), intent(out) :: shorter
      !> There is one, and the step stayed on the branch.
      logical, intent(out) :: success
      type(solution_point_type) :: guess
      real(dp) :: ahead, bound, base

      off_curve = 0
      shorter = 1/3.0_dp
      ahead = here%frequency_ratio + h*here%tangent_frequency
      if (closing) then
         next = origin
         call self%corrector%solve_at(next, success)
         if (success) call self%corrector%orient(next, merge(1, -1, origin%tangent_frequency > 0))
      else if (allocated(self%corrector%balance%path) .and. .not. (ahead > low .and. ahead < high)) then
         bound = merge(low, high, ahead <= low)
         next = here
         next%u = here%u + (bound - here%frequency_ratio)/here%tangent_frequency*here%tangent
         next%frequency_ratio = bound
         call self%corrector%solve_at(next, success)
         if (success) success = self%corrector%length_of(next%u - here%u) < 2*h
         if (success) call self%corrector%orient(next, merge(1, -1, here%tangent_frequency > 0))
         if (success) success = cosine(here, next, self%corrector%units) > cosine_limit
      else
         call predict(self%corrector, self%before, here, h, guess, base)
         call self%corrector%advance(here, h, next, success, guess)
         off_curve = curve_error(self%corrector, h, base)
         ! Another branch crosses: the step ends next to it.
         if (success .and. base > 0 .and. .not. crosses_branch(here, next)) &
            shorter = min(0.6_dp, next_step(self%corrector, here, next, h, h, off_curve)/h)
         if (success) success = acceptable(self%corrector, here, next, h, guess, off_curve)
         if (success) success = h < jump_step .or. .not. hides_folds(here, next, self%corrector%units, &
                                                                               merge(abs(next%tangent_frequency &
                                                                               - guess%tangent_frequency), 0.0_dp, base > 0))
      end if
   end subroutine take_step

   !> Puts the end of a step onto the harmonics that the tolerance needs.
   subroutine adapt_end(self, next, here, origin, fixed, success)
      class(stepper_type), intent(inout) :: self
      !> End and beginning of the step; first point of the branch: see `adapt`.
      type(solution_point_type), intent(inout) :: next, here, origin
      !> Keeps Lambda of `next`.
      logical, intent(in) :: fixed
      !> False where a shorter step may find them.
      logical, intent(out) :: success
      logical :: kept

      call self%adapt(next, success, here, origin, fixed, kept, step_end=.true.)
      self%refusals = merge(0, self%refusals + 1, success)
      ! Near a fold or a first contact the motion of more harmonics may lie too far away, however short the step.
      success = success .or. kept .and. self%refusals > most_refusals
   end subroutine adapt_end

   !> Makes `next` the solution point at exactly `bound`, a Lambda between `here` and `next`.
   subroutine stop_at(self, bound, here, next, h, success)
      class(stepper_type), intent(inout) :: self
      !> The bound [1]; length of the step [1].
      real(dp), intent(in) :: bound, h
      !> Beginning of the step.
      type(solution_point_type), intent(in) :: here
      !> Its end, which becomes the point at the bound.
      type(solution_point_type), intent(inout) :: next
      !> Newton's method has converged near the step.
      logical, intent(out) :: success
      type(solution_point_type) :: guess
      real(dp) :: length

      length = arc_length(here, next, self%corrector%units)
      guess = next
      call go_along(here, next, share_at([here%frequency_ratio, next%frequency_ratio], &
                                         length*[here%tangent_frequency, next%tangent_frequency], bound), &
                    self%corrector%units, guess)
      guess%frequency_ratio = bound
      next = guess
      call self%corrector%solve_at(next, success)
      if (.not. success) return
      success = self%corrector%length_of(next%u - guess%u) < max(h, 1e-8_dp)
      if (success) call self%corrector%orient(next, merge(1, -1, bound > here%frequency_ratio))
   end subroutine stop_at

   !> Adds to the reason for the end how many points miss the tolerance; a branch whose points all miss it is not complete. Where a
   !> branch is nearly vertical a small error of Lambda is a large error at constant Lambda, which more harmonics hardly reduce.
   !> A mesh of small amplitude, and its force, may have a large relative error where the error of all meshes together is small.
   subroutine tell_missed(self, branch)
      class(stepper_type), intent(in) :: self
      !> Traced branch; gets `ended` and `complete`.
      type(branch_type), intent(inout) :: branch
      integer :: steep, worst(2)

      if (self%settings%harmonics /= 0) return
      if (branch%points > 0) then
         worst = maxloc(branch%mesh_error_estimate(:, :branch%points), &
                        spread(branch%error_estimate(:branch%points) <= self%settings%tolerance, 1, branch%meshes))
         if (all(worst > 0)) then
            associate (error => branch%mesh_error_estimate(worst(1), worst(2)))
               if (error > named_from*self%settings%tolerance) branch%ended = branch%ended//'; '// &
                  trim(self%system%mesh_name(worst(1)))//' has a small amplitude: its relative error is up to '//text(error)// &
                  ', above the tolerance'
            end associate
         end if
      end if
      steep = count(branch%error_estimate(:branch%points) > self%settings%tolerance) - self%missed
      if (steep == 1) branch%ended = branch%ended//'; one point where it is nearly vertical misses the tolerance'
      if (steep > 1) branch%ended = branch%ended//'; '//text(steep)//' points where it is nearly vertical miss the tolerance'
      if (self%missed == 0) return
      if (self%missed >= branch%points) branch%complete = .false.
      branch%ended = branch%ended//'; '//text(min(self%missed, branch%points))//' of '//text(branch%points) &
                     //' points miss the tolerance '//text(self%settings%tolerance)//' with '//text(branch%harmonics) &
                     //' harmonics at most'
   end subroutine tell_missed

end module geartrain_trace_stepper
