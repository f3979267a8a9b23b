!> One step along a branch: predictor along the tangent, corrector by Newton's method on the balance with one more equation. Metric:
!> square of the mean plus half of each squared amplitude, summed over the unknown meshes, in units_type%length squared, plus the
!> square of Lambda in units_type%frequency_ratio squared.
module geartrain_trace_corrector
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_bordered_system, only: bordered_system_type
   use geartrain_balance_fixed_space, only: fixed_space_type
   use geartrain_balance_planet_turn, only: planet_turn_type
   use geartrain_balance_symmetric_space, only: find_symmetric_space, note_equal
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_trigonometric, only: inner
   use geartrain_network_equal_branches, only: equal_branches_type
   use geartrain_network_planet_symmetry, only: symmetry_type
   use geartrain_network_units, only: units_type
   use geartrain_trace_condition, only: condition_type
   implicit none (type, external)
   private
   public :: corrector_type, solution_point_type

   !> Most iterations, and of damped ones; least share of a step.
   integer, parameter :: max_iterations = 10, max_damped = 20
   real(dp), parameter :: least_share = 0.05_dp
   !> Newton step at which a point counts as solved, relative to the motion; its floor, relative to the coefficients [1].
   real(dp), parameter :: converged = 1e-10_dp, rounding = 16*epsilon(1.0_dp)
   !> Relative accuracy of the iterative solution of a Newton step: of the first step, and as a share of the residual that the step
   !> is expected to leave [1]; the least residual to solve for [units_type].
   real(dp), parameter :: first_accuracy = 1e-4_dp, accuracy_share = 0.01_dp, least_residual = 1e-13_dp
   !> The same of a balance that carries a set of harmonics, whose iterative solutions cost most of its time: the harmonics left out
   !> are an error of 1e-6 or more. Accuracy of a distance [1].
   real(dp), parameter :: converged_set = 1e-8_dp, first_accuracy_set = 1e-2_dp, least_residual_set = 1e-10_dp, rough = 0.1_dp

   !> A point of a branch: a solution of the balance, or a guess, and the unit tangent of the branch.
   type :: solution_point_type
      !> Coefficients of the unknown meshes over characteristic length [1] and their part of the tangent, (block, unknowns).
      real(dp), allocatable :: u(:, :), tangent(:, :)
      !> Harmonics of Lambda/eta of the coefficients, ascending; not allocated until the point is solved.
      integer, allocatable :: harmonic(:)
      !> Lambda and its part of the tangent [1].
      real(dp) :: frequency_ratio = 0, tangent_frequency = 0
      !> Sign of the bordered determinant, in the space in which equal branches move equally: changes along a branch only at a
      !> branch point or by a jump to another branch; 0: unknown; +-2: of the linearised train in time, not comparable with +-1.
      integer :: orientation = 0
      !> Signs of the determinants of the parts of the motions in which equal branches do not move so, as bits; negative: unknown.
      integer :: differences = -1
   end type solution_point_type

   type :: corrector_type
      !> The equations S(u, Lambda) = 0.
      type(balance_type) :: balance
      !> dS/du with a border row and column, factored at the last Newton step.
      type(bordered_system_type) :: matrix
      !> Units of the metric.
      type(units_type) :: units
      !> Equal branches of the train; not allocated: none. Which of them move equally on the branch that is followed.
      type(equal_branches_type), allocatable :: sets(:)
      type(fixed_space_type) :: fixed
      !> Planetary sets whose planets may move one after the other; not allocated: none. Whether they do on that branch.
      type(symmetry_type), allocatable :: symmetries(:)
      type(planet_turn_type) :: turn
      !> Prescribes the unknown that changes fastest instead of the arclength, equation (11).
      logical :: local_control = .false.
      !> First Newton step over predictor step [1] and number of Newton steps, at the latest solution.
      real(dp) :: correction = 0
      integer :: iterations = 0
      !> Evaluations of the balance so far: unchanged while the corrector is at one solution point.
      integer :: evaluations = 0
      real(dp), allocatable, private :: step(:, :)
      !> Signs of these determinants at the latest Newton step.
      integer, private :: differences = 0
   contains
      procedure :: setup
      procedure :: keep_equal
      procedure :: solve_at
      procedure :: solve_beside
      procedure :: correct
      procedure :: newton
      procedure :: find_distance
      procedure :: orient
      procedure :: advance
      procedure :: refit
      procedure :: length_of
      procedure :: across
      procedure, private :: tolerance_at
      procedure, private :: find_tangent
   end type corrector_type

contains

   !> Prepares the matrix; to be called after each `balance%setup`.
   subroutine setup(self)
      class(corrector_type), intent(inout) :: self

      call self%matrix%setup(self%balance)
      call self%fixed%half_period%take_harmonics(self%balance%harmonic/self%balance%repeats, self%balance%waves())
      if (self%balance%waves() == 1) call self%turn%take_harmonics(self%balance%harmonic/self%balance%eta, self%balance%winding)
      call note_equal(self%balance, self%fixed, self%turn)
      if (allocated(self%step)) deallocate (self%step)
      allocate (self%step(self%balance%block, self%balance%unknowns))
   end subroutine setup

   !> Keeps to motions in which those equal branches move equally, at once or half a period later, that do so on a branch.
   subroutine keep_equal(self, solution)
      class(corrector_type), intent(inout) :: self
      !> Solution point of the branch, with its tangent.
      type(solution_point_type), intent(in) :: solution

      if (allocated(self%turn%orbit)) deallocate (self%turn%orbit)
      if (.not. allocated(self%sets)) return
      call find_symmetric_space(self%balance, self%sets, self%symmetries, solution%u, solution%tangent, self%fixed, self%turn)
   end subroutine keep_equal

   !> Solves at constant Lambda.
   subroutine solve_at(self, solution, success)
      class(corrector_type), intent(inout) :: self
      !> A guess with Lambda; then the solution, the tangent unchanged.
      type(solution_point_type), intent(inout) :: solution
      !> Newton's method has converged.
      logical, intent(out) :: success
      type(condition_type) :: constant

      allocate (constant%row, mold=solution%u)
      constant%row = 0
      constant%row_frequency = 1
      call self%newton(solution, constant, huge(1.0_dp), success)
   end subroutine solve_at

   !> Solves for Lambda too: in the hyperplane through the guess normal to the branches that pass it. At a fold of the exact motion
   !> the balance may have no solution at its Lambda.
   subroutine solve_beside(self, solution, success)
      class(corrector_type), intent(inout) :: self
      !> A guess with Lambda; then the solution, with its tangent.
      type(solution_point_type), intent(inout) :: solution
      !> Newton's method has converged.
      logical, intent(out) :: success

      call self%balance%evaluate(solution%u, solution%frequency_ratio)
      self%evaluations = self%evaluations + 1
      call self%matrix%linearize(self%balance)
      self%matrix%row = 0
      self%matrix%corner = 1
      if (.not. self%matrix%keeps(self%fixed)) self%differences = self%matrix%difference_signs(self%balance, self%fixed)
      call self%matrix%factor(self%balance, success, self%fixed, self%turn)
      if (.not. success) return
      call self%orient(solution, 1)
      call self%correct(solution, success)
   end subroutine solve_beside

   !> Solves in the hyperplane through `solution` normal to its tangent.
   subroutine correct(self, solution, success, damped)
      class(corrector_type), intent(inout) :: self
      !> A guess with tangent; then the solution, with the tangent of the branch in the direction of the former tangent.
      type(solution_point_type), intent(inout) :: solution
      !> Newton's method has converged.
      logical, intent(out) :: success
      !> Shortens steps that enlarge the residual, see `newton`.
      logical, intent(in), optional :: damped
      type(condition_type) :: plane

      allocate (plane%row, mold=solution%u)
      call self%across(solution, plane%row, plane%row_frequency)
      call self%newton(solution, plane, huge(1.0_dp), success, damped)
      if (success) call self%find_tangent(solution)
   end subroutine correct

   !> Finds how far a guess is from the branch, by a step of Newton's method with the factors at hand, of a point next to it. The
   !> balance is left as it is at the guess.
   subroutine find_distance(self, guess, distance)
      class(corrector_type), intent(inout) :: self
      !> The guess.
      type(solution_point_type), intent(in) :: guess
      !> The distance, in the metric of the branch [1].
      real(dp), intent(out) :: distance
      real(dp) :: y

      call self%balance%evaluate(guess%u, guess%frequency_ratio)
      self%evaluations = self%evaluations + 1
      self%step = -self%balance%residual
      y = 0
      call self%matrix%solve(self%balance, self%step, y, rough)
      call self%fixed%project(self%step)
      call self%turn%project(self%step)
      distance = self%length_of(self%step, y)
   end subroutine find_distance

   !> Finds the tangent of a point at which the matrix was factored with Lambda prescribed.
   subroutine orient(self, solution, direction)
      class(corrector_type), intent(inout) :: self
      !> The point, as `solve_at` gives it; gets its tangent.
      type(solution_point_type), intent(inout) :: solution
      !> Lambda grows along the tangent, +1, or falls, -1.
      integer, intent(in) :: direction

      if (.not. allocated(solution%tangent)) allocate (solution%tangent, mold=solution%u)
      solution%tangent = 0
      solution%tangent_frequency = direction
      call self%find_tangent(solution)
   end subroutine orient

   !> One step along the branch: predictor and corrector.
   subroutine advance(self, from, h, to, success, guess)
      class(corrector_type), intent(inout) :: self
      !> A solution with tangent.
      type(solution_point_type), intent(in) :: from
      !> Length of the predictor step [units_type].
      real(dp), intent(in) :: h
      !> The next solution, with its tangent; no solution unless `success`.
      type(solution_point_type), intent(inout) :: to
      !> Newton's method has converged, with no step longer than h.
      logical, intent(out) :: success
      !> Guess of the solution, at the distance h from `from` along the tangent there; absent: on the tangent.
      type(solution_point_type), intent(in), optional :: guess
      type(condition_type) :: plane
      integer :: largest(2)

      if (present(guess)) then
         to%u = guess%u
         to%frequency_ratio = guess%frequency_ratio
      else
         to%u = from%u + h*from%tangent
         to%frequency_ratio = from%frequency_ratio + h*from%tangent_frequency
      end if
      allocate (plane%row, mold=to%u)
      call self%across(from, plane%row, plane%row_frequency)
      if (self%local_control) then
         largest = 1
         if (size(plane%row) > 0) largest = maxloc(abs(from%tangent))
         plane%row = 0
         plane%row_frequency = 0
         if (size(plane%row) == 0 .or. abs(from%tangent_frequency)/self%units%frequency_ratio &
             > maxval(abs(from%tangent))/self%units%length) then
            plane%row_frequency = 1
         else
            plane%row(largest(1), largest(2)) = 1
         end if
      end if
      call self%newton(to, plane, h, success)
      if (.not. success) return
      to%tangent = from%tangent
      to%tangent_frequency = from%tangent_frequency
      if (present(guess)) then
         ! The correction of a guess on a curve through points and tangents grows with the third to fourth power of the length.
         call self%find_tangent(to, guess%tangent + (3/h)*(to%u - guess%u), &
                                guess%tangent_frequency + (3/h)*(to%frequency_ratio - guess%frequency_ratio))
      else
         call self%find_tangent(to)
      end if
   end subroutine advance

   !> Newton's method on S = 0 with a condition, as that a solution is in a plane through the guess. Fails when it stops
   !> contracting, needs too many iterations, is interrupted, or when a step is longer than `longest`: the solution may then lie on
   !> another branch. A step that is expected to be the last one, by the ratio of the steps before, uses the factors at hand.
   !> Each step is solved for only as accurately as its linearisation error asks for (inexact Newton: S. C. Eisenstat and H. F.
   !> Walker, SIAM J. Sci. Comput. 17 (1996) 16-32).
   !> Damped, a step is halved while it enlarges the residual, as steps across a first contact do, and contraction is not asked for.
   subroutine newton(self, solution, condition, longest, success, damped)
      class(corrector_type), intent(inout) :: self
      !> A guess; then the solution, the tangent unchanged.
      type(solution_point_type), intent(inout) :: solution
      class(condition_type), intent(inout) :: condition
      !> Longest step, in the metric of the branch [1].
      real(dp), intent(in) :: longest
      !> Newton's method has converged.
      logical, intent(out) :: success
      !> Shortens steps that enlarge the residual.
      logical, intent(in), optional :: damped
      real(dp) :: y, length, before, tolerance, defect, defect_before, accuracy, first, least, share
      integer :: iteration
      logical :: last, regular, halves
      real(dp), allocatable :: whole(:, :)

      halves = .false.
      if (present(damped)) halves = damped
      share = 1
      success = .false.
      last = .false.
      before = huge(1.0_dp)
      ! A guess beyond points known is a difference of them that multiplies their rounding, from step to step.
      call self%fixed%project(solution%u)
      call self%turn%project(solution%u)
      first = merge(first_accuracy_set, first_accuracy, self%balance%chosen)
      least = merge(least_residual_set, least_residual, self%balance%chosen)
      accuracy = first
      defect_before = 0
      do iteration = 1, merge(max_damped, max_iterations, halves)
         if (self%balance%system%interrupt%raised()) return
         if (allocated(self%balance%path)) then
            if (.not. self%balance%reaches(solution%frequency_ratio)) return
         end if
         self%iterations = iteration
         call self%balance%evaluate(solution%u, solution%frequency_ratio)
         self%evaluations = self%evaluations + 1
         self%step = -self%balance%residual
         defect = self%length_of(self%step)
         if (halves .and. iteration > 1 .and. defect > defect_before .and. share > least_share) then
            share = share/2
            solution%u = solution%u - share*whole
            solution%frequency_ratio = solution%frequency_ratio - share*y
            cycle
         end if
         ! A residual that asks for a step shorter than the tolerance, by the step before.
         success = iteration > 1 .and. self%balance%chosen .and. .not. (self%balance%is_direct() .or. condition%varies)
         if (success) success = defect*before < tolerance*defect_before .and. self%balance%reaches(solution%frequency_ratio)
         if (success) then
            solution%harmonic = self%balance%harmonic
            return
         end if
         if (condition%varies) then
            call condition%evaluate(self%balance, solution%u, solution%frequency_ratio)
            call self%fixed%project(condition%row)
            call self%turn%project(condition%row)
         end if
         if (.not. last) then
            call self%matrix%linearize(self%balance)
            self%matrix%row = condition%row
            self%matrix%corner = condition%row_frequency
            if (.not. self%matrix%keeps(self%fixed)) self%differences = self%matrix%difference_signs(self%balance, self%fixed)
            call self%matrix%factor(self%balance, regular, self%fixed, self%turn)
            if (.not. regular) return
         end if
         y = -condition%value
         ! The residual is expected to shrink by the square of its last ratio.
         if (iteration > 1) accuracy = min(first, accuracy_share*(defect/defect_before)**2)
         accuracy = max(accuracy, min(first, least/max(defect, converged)))
         defect_before = defect
         call self%matrix%solve(self%balance, self%step, y, accuracy)
         call self%fixed%project(self%step)
         call self%turn%project(self%step)
         length = self%length_of(self%step, y)
         if (.not. length <= longest) return
         if (iteration == 1) self%correction = length/longest
         if (length > 0.7_dp*before .and. iteration > 2 .and. .not. halves) return
         if (halves) whole = self%step
         solution%u = solution%u + self%step
         solution%frequency_ratio = solution%frequency_ratio + y
         tolerance = self%tolerance_at(solution%u)
         success = length < tolerance .and. self%balance%reaches(solution%frequency_ratio)
         if (success) then
            solution%harmonic = self%balance%harmonic
            return
         end if
         ! Quadratic convergence: the ratio of a step to the square of the step before stays about constant.
         last = iteration > 1 .and. .not. share < 1 .and. length*(length/before)**2 < 0.1_dp*tolerance
         before = length
         share = 1
      end do
   end subroutine newton

   !> Unit tangent, with the factors of the last Newton step, in the direction of the tangent that `solution` holds.
   subroutine find_tangent(self, solution, near, near_frequency)
      class(corrector_type), intent(inout) :: self
      type(solution_point_type), intent(inout) :: solution
      !> A guess of the tangent; the former tangent unless it is given.
      real(dp), intent(in), optional :: near(:, :), near_frequency
      real(dp) :: y, length

      if (present(near)) then
         call self%matrix%solve_border(self%balance, near, near_frequency, self%step, y)
      else
         call self%matrix%solve_border(self%balance, solution%tangent, solution%tangent_frequency, self%step, y)
      end if
      call self%fixed%project(self%step)
      call self%turn%project(self%step)
      length = self%length_of(self%step, y)
      if (inner(self%step, solution%tangent)/self%units%length**2 &
          + y*solution%tangent_frequency/self%units%frequency_ratio**2 < 0) length = -length
      solution%tangent = self%step/length
      solution%orientation = self%matrix%orientation
      if (.not. self%fixed%is_whole()) then
         if (self%matrix%keeps(self%fixed)) self%differences = self%matrix%difference_signs(self%balance, self%fixed)
         solution%differences = self%differences
         if (.not. self%matrix%equal) solution%orientation = self%fixed%restricted(self%matrix%orientation, self%differences)
      end if
      if (length < 0) solution%orientation = -solution%orientation
      if (self%matrix%oriented_in_time) solution%orientation = 2*solution%orientation
      solution%tangent_frequency = y/length
   end subroutine find_tangent

   !> Moves the coefficients and the tangent of a solution point to the harmonics of the present balance, by harmonic: a smaller set
   !> of harmonics is not always the beginning of a larger set (needed_harmonics.f90).
   pure subroutine refit(self, solution)
      class(corrector_type), intent(in) :: self
      !> A point solved with other harmonics; harmonics that it lacks become 0.
      type(solution_point_type), intent(inout) :: solution
      real(dp) :: u(self%balance%block, size(solution%u, 2)), tangent(self%balance%block, size(solution%u, 2))
      integer :: i, k

      u = 0
      tangent = 0
      u(1, :) = solution%u(1, :)
      tangent(1, :) = solution%tangent(1, :)
      do k = 1, size(self%balance%harmonic)
         i = findloc(solution%harmonic, self%balance%harmonic(k), 1)
         if (i == 0) cycle
         u(2*k:2*k + 1, :) = solution%u(2*i:2*i + 1, :)
         tangent(2*k:2*k + 1, :) = solution%tangent(2*i:2*i + 1, :)
      end do
      solution%harmonic = self%balance%harmonic
      solution%u = u
      solution%tangent = tangent
      solution%orientation = 0
      solution%differences = -1
   end subroutine refit

   !> Length of a change in the metric [units_type].
   pure real(dp) function length_of(self, u, frequency_ratio)
      class(corrector_type), intent(in) :: self
      !> Change of the coefficients [1], (block, unknowns).
      real(dp), intent(in) :: u(:, :)
      !> Change of Lambda [1]; absent: 0.
      real(dp), intent(in), optional :: frequency_ratio

      length_of = inner(u, u)/self%units%length**2
      if (present(frequency_ratio)) length_of = length_of + (frequency_ratio/self%units%frequency_ratio)**2
      length_of = sqrt(length_of)
   end function length_of

   !> Border row of the equation that a correction is normal to the tangent.
   pure subroutine across(self, solution, row, row_frequency)
      class(corrector_type), intent(in) :: self
      !> A point with tangent.
      type(solution_point_type), intent(in) :: solution
      !> Factors of the coefficients [1], (block, unknowns), and of Lambda [1].
      real(dp), intent(out) :: row(:, :), row_frequency

      row = 0.5_dp*solution%tangent/self%units%length
      if (size(row) > 0) row(1, :) = solution%tangent(1, :)/self%units%length
      row_frequency = solution%tangent_frequency*(self%units%length/self%units%frequency_ratio**2)
   end subroutine across

   !> Newton step at which u counts as solved: relative to the motion, whose mean is counted from the nearer edge of the gap,
   !> because a lightly loaded train moves by much less than its gap. Not below the rounding of u.
   pure real(dp) function tolerance_at(self, u) result(tolerance)
      class(corrector_type), intent(in) :: self
      real(dp), intent(in) :: u(:, :)
      real(dp) :: squares
      integer :: i

      squares = 0
      do i = 1, size(u, 2)
         squares = squares + (abs(u(1, i)) - self%balance%system%half_backlash(self%balance%mesh(i)))**2 + 0.5_dp*sum(u(2:, i)**2)
      end do
      tolerance = merge(converged_set, converged, self%balance%chosen)*(2 + sqrt(squares)/self%units%length)
      tolerance = max(tolerance, rounding*self%length_of(u))
   end function tolerance_at

end module geartrain_trace_corrector
