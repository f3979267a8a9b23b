!> Follows a branch from one place until it reaches a bound, closes, leaves by the amplitude limit or cannot go on:
!> step control, guard against jumps, harmonics by tolerance, folds put on the branch as points of their own.
module geartrain_branch_tracer
   use geartrain_base_kinds, only: dp
   use geartrain_base_observer, only: observer_type
   use geartrain_base_numbers, only: text
   use geartrain_branch_branch, only: branch_type, response_settings_type, trace_state_type
   use geartrain_branch_path, only: inner, path_type, place_type
   use geartrain_branch_recorder, only: recorder_type
   use geartrain_branch_special_points, only: add_special_point, locate_fold, locate_stability_change, unstable_count
   use geartrain_model_system, only: system_type
   use geartrain_motion_truncation, only: truncation_error
   implicit none (type, external)
   private
   public :: tracer_type, acceptable, next_step
   public :: reached_end, came_back, closed_loop, left_by_amplitude, cancelled, stuck, full, met_half_period, left_beyond

   !> How a trace ended; left_beyond: out of the range of Lambda beyond the amplitude limit.
   integer, parameter :: reached_end = 1, came_back = 2, closed_loop = 3, left_by_amplitude = 4, cancelled = 5, stuck = 6, &
                         full = 7, met_half_period = 8, left_beyond = 9

   real(dp), parameter :: first_step = 0.01_dp, smallest_step = 1e-9_dp
   !> Cosine of the largest angle between tangents of neighbouring points, and the angle aimed at [rad].
   real(dp), parameter :: cosine_limit = 0.85_dp, angle_aim = 0.2_dp
   !> Newton's first correction over the step: aimed at, and refused.
   real(dp), parameter :: correction_aim = 0.05_dp, correction_limit = 0.35_dp
   !> A change of orientation is a jump to another branch, unless it persists below this step: then branches cross here.
   real(dp), parameter :: jump_step = 1e-4_dp
   !> Amplitude above which the largest step grows in proportion to it.
   real(dp), parameter :: large = 5
   integer, parameter :: fewest_harmonics = 4, most_harmonics = 256

   type :: tracer_type
      type(response_settings_type) :: settings
      type(system_type) :: system
      real(dp) :: amplitude_limit = huge(1.0_dp)
      type(path_type) :: path
      type(recorder_type) :: recorder
      !> What the observer is told: 'response', or 'branch' for a further one.
      character(8) :: analysis = 'response'
      !> Number of the part of the branch that is traced.
      integer :: part = 1
      !> The next trace goes on from branch%trace.
      logical :: resumes = .false.
      real(dp), private :: estimate = 0
      !> Change of the tangent's Lambda part along the branch, at the latest step.
      real(dp), private :: bend = 0
   contains
      procedure :: prepare
      procedure :: record
      procedure :: trace
      procedure :: adapt
      procedure, private :: relax
      procedure, private :: take_up
      procedure :: estimate_error
      procedure :: refit
      procedure, private :: stop_at
      procedure, private :: add_fold
      procedure, private :: add_stability_change
   end type tracer_type

contains

   !> Plans the balance for `harmonics` harmonics.
   subroutine prepare(self, harmonics)
      class(tracer_type), intent(inout) :: self
      integer, intent(in) :: harmonics
      integer :: samples

      samples = 0
      if (self%settings%coefficients == 'sampled') then
         samples = self%settings%samples
         if (samples == 0) then
            samples = 1024
            do while (samples < 16*harmonics)
               samples = 2*samples
            end do
         end if
      end if
      call self%path%balance%setup(self%system, harmonics, self%settings%subharmonic, samples)
      call self%path%setup()
      self%path%local_control = self%settings%control == 'local'
   end subroutine prepare

   !> Adds a solved place, the last one that `path` worked on, to the branch.
   subroutine record(self, place, branch)
      class(tracer_type), intent(inout) :: self
      type(place_type), intent(in) :: place
      type(branch_type), intent(inout), target :: branch

      call self%estimate_error(place)
      call self%recorder%add(self%path%balance, place, self%estimate, self%part, branch)
   end subroutine record

   !> Error estimate of a solved place, the last one that `path` worked on.
   subroutine estimate_error(self, place)
      class(tracer_type), intent(inout) :: self
      type(place_type), intent(in) :: place

      call truncation_error(self%path%balance, place%u, place%frequency, place%tangent, place%tangent_frequency, self%bend, &
                            self%path%matrix, self%estimate)
   end subroutine estimate_error

   !> Follows the branch from `here` (solved, oriented, already a point of the branch) within [low, high]. Of the two bounds
   !> `target` is the end and the other one a return. `here` becomes the place where the
   !> branch left by the amplitude limit, if it did.
   subroutine trace(self, here, low, high, target, branch, outcome, reason, observer)
      class(tracer_type), intent(inout) :: self
      type(place_type), intent(inout) :: here
      real(dp), intent(in) :: low, high, target
      type(branch_type), intent(inout), target :: branch
      integer, intent(out) :: outcome
      character(:), allocatable, intent(out) :: reason
      class(observer_type), intent(inout), optional :: observer
      type(place_type) :: next, origin
      real(dp) :: h, longer, gap
      integer :: steps, mesh
      logical :: success, keep_going, begins_at_latest

      begins_at_latest = abs(branch%frequency(branch%points) - here%frequency) <= 0
      next = here
      origin = here
      h = min(first_step, self%settings%step)
      steps = 0
      outcome = 0
      if (self%resumes) call self%take_up(branch%trace, here, origin, h, steps)
      do
         call self%path%advance(here, h, next, success)
         if (success) success = acceptable(self, here, next, h)
         if (success) success = h < jump_step .or. .not. hides_folds(here, next, h)
         if (success .and. (next%frequency < low .or. next%frequency > high)) then
            call self%stop_at(merge(low, high, next%frequency < low), here, next, h, success)
            if (success) then
               call self%record(next, branch)
               outcome = came_back
               if (abs(next%frequency - target) <= 0) outcome = reached_end
               reason = 'reached Lambda = '//text(next%frequency)
               if (outcome == came_back) reason = 'came back to Lambda = '//text(next%frequency)
               return
            end if
         end if
         if (.not. success) then
            h = h/3
            if (h >= smallest_step) cycle
            outcome = stuck
            reason = 'step below '//text(smallest_step)//' at Lambda = '//text(here%frequency)
            return
         end if

         longer = next_step(self, here, next, h, self%settings%step*max(1.0_dp, sqrt(inner(next%u, next%u))/large))
         self%bend = (next%tangent_frequency - here%tangent_frequency)/h
         if (self%settings%harmonics == 0) call self%adapt(next, here, origin)
         if (turns(here, next)) call self%add_fold(here, next, h, branch)
         call self%record(next, branch)
         steps = steps + 1
         if (self%recorder%stability .and. (steps > 1 .or. begins_at_latest)) &
            call self%add_stability_change(here, next, h, branch)

         if (passes_half_period(self, here, next)) then
            outcome = met_half_period
            reason = 'met the branch of half its period at Lambda = '//text(next%frequency)
            return
         end if
         mesh = maxloc(branch%rms(:, branch%points), 1)
         ! It may begin beyond the limit and fall.
         if (branch%rms(mesh, branch%points) > max(self%amplitude_limit, branch%rms(mesh, branch%points - 1))) then
            outcome = left_by_amplitude
            reason = 'rms of mesh '//text(mesh)//' passed the amplitude limit '//text(self%amplitude_limit) &
                     //' at Lambda = '//text(next%frequency)
            here = next
            return
         end if
         if (branch%points >= self%settings%max_points) then
            outcome = full
            reason = 'max_points = '//text(self%settings%max_points)//' reached at Lambda = '//text(next%frequency)
            return
         end if

         h = longer
         here = next
         if (self%settings%harmonics == 0) call self%relax(here, origin)
         if (steps > 3) then
            if (closes(here, origin, h, gap)) then
               call self%path%advance(here, gap, next, success)
               if (success) call self%record(next, branch)
               outcome = closed_loop
               reason = 'closed where it began, at Lambda = '//text(origin%frequency)
               return
            end if
         end if

         ! Last in the loop: the observer may keep the branch, and another run go on from branch%trace.
         if (.not. present(observer)) cycle
         if (allocated(branch%trace)) then
            branch%trace%steps = steps
            branch%trace%harmonics = self%path%balance%highest
            branch%trace%step = h
            branch%trace%bend = self%bend
            branch%trace%here = here
            branch%trace%origin = origin
         end if
         keep_going = .true.
         call observer%on_step(trim(self%analysis), branch%points, here%frequency, keep_going)
         if (keep_going) cycle
         outcome = cancelled
         branch%cancelled = .true.
         reason = 'cancelled at Lambda = '//text(here%frequency)
         return
      end do
   end subroutine trace

   !> Goes back to where a trace of another run stood.
   subroutine take_up(self, state, here, origin, h, steps)
      class(tracer_type), intent(inout) :: self
      type(trace_state_type), intent(in) :: state
      type(place_type), intent(out) :: here, origin
      real(dp), intent(out) :: h
      integer, intent(out) :: steps

      self%resumes = .false.
      if (self%path%balance%highest /= state%harmonics) call self%prepare(state%harmonics)
      self%bend = state%bend
      here = state%here
      origin = state%origin
      h = state%step
      steps = state%steps
   end subroutine take_up

   !> Whether a step stayed on the branch: a small correction, a small turn, the same orientation.
   logical function acceptable(self, here, next, h)
      class(tracer_type), intent(in) :: self
      type(place_type), intent(in) :: here, next
      real(dp), intent(in) :: h

      acceptable = self%path%correction < correction_limit .and. cosine(here, next) > cosine_limit
      if (self%path%local_control) return
      acceptable = acceptable .and. (here%orientation == next%orientation .or. here%orientation == 0 .or. h < jump_step)
   end function acceptable

   !> Whether the odd harmonics of a motion of even period change sign between two points: the branch passes through one of
   !> half its period there, and goes on as its own mirror image, shifted by half a period.
   pure logical function passes_half_period(self, here, next)
      class(tracer_type), intent(in) :: self
      type(place_type), intent(in) :: here, next
      real(dp) :: product
      integer :: k

      passes_half_period = .false.
      if (mod(self%settings%subharmonic, 2) /= 0) return
      product = 0
      do k = 1, size(self%path%balance%harmonic), 2
         product = product + sum(here%u(2*k:2*k + 1, :)*next%u(2*k:2*k + 1, :))
      end do
      passes_half_period = product < 0
   end function passes_half_period

   !> Whether Lambda turns between two points. Where a branch leaves vertically (a period-2 branch does, until contact is lost)
   !> the sign of the tangent's Lambda part is rounding: that is no fold.
   pure logical function turns(here, next)
      type(place_type), intent(in) :: here, next

      turns = here%tangent_frequency*next%tangent_frequency < 0 &
              .and. max(abs(here%tangent_frequency), abs(next%tangent_frequency)) > 1e-6_dp
   end function turns

   !> Whether Lambda seems to turn twice between two points: whether the cubic through them, with their slopes, does.
   pure logical function hides_folds(here, next, h)
      type(place_type), intent(in) :: here, next
      real(dp), intent(in) :: h
      real(dp) :: bend, share, chord

      hides_folds = .false.
      chord = (next%frequency - here%frequency)/h
      associate (first => here%tangent_frequency, last => next%tangent_frequency)
         if (first*last <= 0) return
         bend = first + last - 2*chord
         if (abs(bend) <= 0) return
         share = (2*first + last - 3*chord)/(3*bend)
         if (share <= 0 .or. share >= 1) return
         hides_folds = first*(first - 3*bend*share**2) < 0
      end associate
   end function hides_folds

   !> Of the angle between two tangents.
   pure real(dp) function cosine(here, next)
      type(place_type), intent(in) :: here, next

      cosine = inner(here%tangent, next%tangent) + here%tangent_frequency*next%tangent_frequency
   end function cosine

   !> Aims at a certain turn and a certain first Newton correction (which goes with the square of the step); at most `longest`.
   real(dp) function next_step(self, here, next, h, longest)
      class(tracer_type), intent(in) :: self
      type(place_type), intent(in) :: here, next
      real(dp), intent(in) :: h, longest
      real(dp) :: angle

      angle = acos(max(-1.0_dp, min(1.0_dp, cosine(here, next))))
      next_step = h*max(0.4_dp, min(1.8_dp, angle_aim/max(angle, 1e-8_dp), &
                                    sqrt(correction_aim/max(self%path%correction, 1e-8_dp))))
      next_step = min(next_step, longest)
   end function next_step

   !> Whether `origin` lies ahead, within the next step and close to the tangent; `gap` is the way there.
   logical function closes(here, origin, h, gap)
      type(place_type), intent(in) :: here, origin
      real(dp), intent(in) :: h
      real(dp), intent(out) :: gap
      real(dp) :: du(size(here%u, 1), size(here%u, 2)), df

      du = origin%u - here%u
      df = origin%frequency - here%frequency
      gap = inner(du, here%tangent) + df*here%tangent_frequency
      closes = gap > 0 .and. gap <= h .and. inner(du, du) + df**2 < 1.1_dp*gap**2 .and. cosine(here, origin) > cosine_limit
   end function closes

   !> Solves at exactly `bound`, which lies between `here` and `next`; `next` becomes that place.
   subroutine stop_at(self, bound, here, next, h, success)
      class(tracer_type), intent(inout) :: self
      real(dp), intent(in) :: bound, h
      type(place_type), intent(in) :: here
      type(place_type), intent(inout) :: next
      logical, intent(out) :: success
      type(place_type) :: guess
      real(dp) :: share

      share = (bound - here%frequency)/(next%frequency - here%frequency)
      guess = next
      guess%u = here%u + share*(next%u - here%u)
      guess%frequency = bound
      next = guess
      call self%path%solve_at(next, success)
      if (.not. success) return
      success = sqrt(inner(next%u - guess%u, next%u - guess%u)) < max(h, 1e-8_dp)
      if (success) call self%path%orient(next, merge(1, -1, bound > here%frequency))
   end subroutine stop_at

   !> Puts the fold between `here` and `next` on the branch, and solves `next` again, which comes after it.
   subroutine add_fold(self, here, next, h, branch)
      class(tracer_type), intent(inout) :: self
      type(place_type), intent(in) :: here
      type(place_type), intent(inout) :: next
      real(dp), intent(in) :: h
      type(branch_type), intent(inout), target :: branch
      type(place_type) :: fold
      logical :: success

      fold = next
      call locate_fold(self%path, here, next, h, fold, success)
      if (success) then
         call self%record(fold, branch)
         call add_special_point(branch, 'fold', fold%frequency, branch%points, branch%rms(:, branch%points))
      end if
      call self%path%advance(here, h, next, success)
   end subroutine add_fold

   !> Where the number of unstable multipliers changed since `here`, other than by a fold: locates the change.
   subroutine add_stability_change(self, here, next, h, branch)
      class(tracer_type), intent(inout) :: self
      type(place_type), intent(in) :: here, next
      real(dp), intent(in) :: h
      type(branch_type), intent(inout), target :: branch
      type(place_type) :: place
      character(16) :: kind
      integer :: n, before, last
      logical :: success, fold

      n = branch%points
      fold = turns(here, next)
      before = n - 1
      if (fold) before = n - 2
      if (before < 1) return
      if (unstable_count(branch%multipliers(:, before)) == unstable_count(branch%multipliers(:, n))) return
      if (fold) return
      place = next
      call locate_stability_change(self%path, self%recorder%monodromy, here, h, branch%multipliers(:, before), &
                                   branch%multipliers(:, n), place, kind, success)
      if (.not. success) return
      ! A truncated balance and its monodromy place one fold slightly apart: that is no change of its own.
      last = size(branch%special_points)
      if (kind == 'symmetry' .and. last > 0) then
         if (branch%special_points(last)%kind == 'fold' .and. branch%special_points(last)%point > n - 6) return
      end if
      if (kind == 'symmetry' .and. abs(place%tangent_frequency) < 0.1_dp) return
      call add_special_point(branch, kind, place%frequency, before, branch%rms(:, n))
   end subroutine add_stability_change

   !> Raises the number of harmonics until the error estimate of `place`, just solved, is within the tolerance; the places that
   !> go with it are padded alike.
   subroutine adapt(self, place, here, origin)
      class(tracer_type), intent(inout) :: self
      type(place_type), intent(inout) :: place, here, origin
      integer :: highest
      logical :: success

      do
         call self%estimate_error(place)
         highest = self%path%balance%highest
         if (self%estimate <= self%settings%tolerance .or. highest >= most_harmonics) return
         call self%prepare(min(most_harmonics, (3*highest + 1)/2))
         call self%refit(here)
         call self%refit(origin)
         call self%refit(place)
         call self%path%correct(place, success)
         if (.not. success) return
      end do
   end subroutine adapt

   !> Lowers the number of harmonics for the points to come where the latest estimate leaves room.
   subroutine relax(self, here, origin)
      class(tracer_type), intent(inout) :: self
      type(place_type), intent(inout) :: here, origin
      integer :: highest
      logical :: success

      highest = self%path%balance%highest
      if (self%estimate > 0.02_dp*self%settings%tolerance .or. highest <= fewest_harmonics) return
      call self%prepare(max(fewest_harmonics, (3*highest)/4))
      call self%refit(here)
      call self%refit(origin)
      call self%path%correct(here, success)
   end subroutine relax

   !> Cuts or pads the coefficients of a place to the present number of harmonics.
   pure subroutine refit(self, place)
      class(tracer_type), intent(in) :: self
      type(place_type), intent(inout) :: place
      real(dp) :: u(self%path%balance%block, size(place%u, 2)), tangent(self%path%balance%block, size(place%u, 2))
      integer :: n

      n = min(size(u, 1), size(place%u, 1))
      u = 0
      tangent = 0
      u(:n, :) = place%u(:n, :)
      tangent(:n, :) = place%tangent(:n, :)
      place%u = u
      place%tangent = tangent
      place%orientation = 0
   end subroutine refit

end module geartrain_branch_tracer
