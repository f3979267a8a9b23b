!> One step along a branch: predictor along the tangent, Newton corrector on the balance with one more equation, in a metric
!> of mesh displacements (mean squared plus half of each squared amplitude) and Lambda, each in a unit of the train's own.
module geartrain_continuation_corrector
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_bordered_system, only: bordered_system_type
   use geartrain_base_kinds, only: dp
   use geartrain_continuation_units, only: units_type
   implicit none (type, external)
   private
   public :: corrector_type, solution_point_type, inner

   integer, parameter :: max_iterations = 10
   real(dp), parameter :: converged = 1e-10_dp, rounding = 16*epsilon(1.0_dp)
   !> Accuracy of a Newton step that is solved for by iteration: at first, and as a share of what the step is going to leave; what
   !> may be left of the residual, in units of the train's own.
   real(dp), parameter :: first_accuracy = 1e-4_dp, accuracy_share = 0.01_dp, least_residual = 1e-13_dp

   !> A point of the branch and the unit tangent there: coefficients of the unknown meshes (block, unknowns) and Lambda.
   type :: solution_point_type
      real(dp), allocatable :: u(:, :), tangent(:, :)
      !> Harmonics of the coefficients, once it is solved.
      integer, allocatable :: harmonic(:)
      real(dp) :: frequency_ratio = 0, tangent_frequency = 0
      !> Sign of the bordered determinant: it changes along a branch only at another branch or by a jump.
      integer :: orientation = 0
   end type solution_point_type

   type :: corrector_type
      type(balance_type) :: balance
      type(bordered_system_type) :: matrix
      type(units_type) :: units
      !> Equation (11): the unknown that changes fastest is prescribed, instead of the arclength.
      logical :: local_control = .false.
      !> Of the latest corrector: first Newton step over predictor step, iterations.
      real(dp) :: correction = 0
      integer :: iterations = 0
      !> Evaluations of the balance so far: the same number means the same solution point.
      integer :: evaluations = 0
      real(dp), allocatable, private :: step(:, :)
   contains
      procedure :: setup
      procedure :: solve_at
      procedure :: correct
      procedure :: orient
      procedure :: advance
      procedure :: refit
      procedure :: length_of
      procedure :: across
      procedure, private :: tolerance_at
      procedure, private :: newton
      procedure, private :: find_tangent
   end type corrector_type

contains

   !> To be called after each `balance%setup`.
   subroutine setup(self)
      class(corrector_type), intent(inout) :: self

      call self%matrix%setup(self%balance)
      if (allocated(self%step)) deallocate (self%step)
      allocate (self%step(self%balance%block, self%balance%unknowns))
   end subroutine setup

   !> Solves at exactly the frequency of `solution`, from its coefficients.
   subroutine solve_at(self, solution, success)
      class(corrector_type), intent(inout) :: self
      type(solution_point_type), intent(inout) :: solution
      logical, intent(out) :: success
      real(dp) :: row(self%balance%block, self%balance%unknowns)

      row = 0
      call self%newton(solution, row, 1.0_dp, huge(1.0_dp), success)
   end subroutine solve_at

   !> Solves a solution point that is nearly a solution, across its tangent; renews the tangent.
   subroutine correct(self, solution, success)
      class(corrector_type), intent(inout) :: self
      type(solution_point_type), intent(inout) :: solution
      logical, intent(out) :: success
      real(dp) :: row(self%balance%block, self%balance%unknowns), row_frequency

      call self%across(solution, row, row_frequency)
      call self%newton(solution, row, row_frequency, huge(1.0_dp), success)
      if (success) call self%find_tangent(solution)
   end subroutine correct

   !> Tangent at a solution point (after `solve_at`), Lambda growing or falling with `direction` = +1 or -1.
   subroutine orient(self, solution, direction)
      class(corrector_type), intent(inout) :: self
      type(solution_point_type), intent(inout) :: solution
      integer, intent(in) :: direction

      if (.not. allocated(solution%tangent)) allocate (solution%tangent, mold=solution%u)
      solution%tangent = 0
      solution%tangent_frequency = direction
      call self%find_tangent(solution)
   end subroutine orient

   !> From `from` a distance h along its tangent to `to`, tangent included.
   subroutine advance(self, from, h, to, success)
      class(corrector_type), intent(inout) :: self
      type(solution_point_type), intent(in) :: from
      real(dp), intent(in) :: h
      type(solution_point_type), intent(inout) :: to
      logical, intent(out) :: success
      real(dp) :: row(self%balance%block, self%balance%unknowns), row_frequency
      integer :: largest(2)

      to%u = from%u + h*from%tangent
      to%frequency_ratio = from%frequency_ratio + h*from%tangent_frequency
      if (self%local_control) then
         row = 0
         row_frequency = 0
         largest = 1
         if (size(row) > 0) largest = maxloc(abs(from%tangent))
         if (size(row) == 0 .or. abs(from%tangent_frequency)/self%units%frequency_ratio &
             > maxval(abs(from%tangent))/self%units%length) then
            row_frequency = 1
         else
            row(largest(1), largest(2)) = 1
         end if
      else
         call self%across(from, row, row_frequency)
      end if
      call self%newton(to, row, row_frequency, h, success)
      if (.not. success) return
      to%tangent = from%tangent
      to%tangent_frequency = from%tangent_frequency
      call self%find_tangent(to)
   end subroutine advance

   !> Newton on S = 0 with row . (U - U_predicted) = 0. It fails when it stops contracting, needs too many iterations, is
   !> interrupted, or when the first correction is longer than `longest` (then the solution may lie on another branch). Where the
   !> next step is going to be the last one, going by how the steps shrink, it is made with the factors at hand.
   !> No step is solved for more exactly than its own error of linearisation is worth (inexact Newton: S. C. Eisenstat and H. F.
   !> Walker, SIAM J. Sci. Comput. 17 (1996) 16-32).
   subroutine newton(self, solution, row, row_frequency, longest, success)
      class(corrector_type), intent(inout) :: self
      type(solution_point_type), intent(inout) :: solution
      real(dp), intent(in) :: row(:, :), row_frequency, longest
      logical, intent(out) :: success
      real(dp) :: y, length, before, tolerance, defect, defect_before, accuracy
      integer :: iteration
      logical :: last, regular

      success = .false.
      last = .false.
      before = huge(1.0_dp)
      accuracy = first_accuracy
      defect_before = 0
      do iteration = 1, max_iterations
         if (self%balance%system%interrupt%raised()) return
         self%iterations = iteration
         call self%balance%evaluate(solution%u, solution%frequency_ratio)
         self%evaluations = self%evaluations + 1
         if (.not. last) then
            call self%matrix%linearize(self%balance)
            self%matrix%row = row
            self%matrix%corner = row_frequency
            call self%matrix%factor(self%balance, regular)
            if (.not. regular) return
         end if
         self%step = -self%balance%residual
         y = 0
         defect = self%length_of(self%step)
         ! The residual shrinks by the square of what it shrank by before.
         if (iteration > 1) accuracy = min(first_accuracy, accuracy_share*(defect/defect_before)**2)
         accuracy = max(accuracy, least_residual/max(defect, converged))
         defect_before = defect
         call self%matrix%solve(self%balance, self%step, y, accuracy)
         length = self%length_of(self%step, y)
         if (.not. length <= longest) return
         if (iteration == 1) self%correction = length/longest
         if (length > 0.7_dp*before .and. iteration > 2) return
         solution%u = solution%u + self%step
         solution%frequency_ratio = solution%frequency_ratio + y
         tolerance = self%tolerance_at(solution%u)
         success = length < tolerance .and. solution%frequency_ratio > 0
         if (success) then
            solution%harmonic = self%balance%harmonic
            return
         end if
         ! Quadratic convergence: the ratio of a step to the square of the one before stays about the same.
         last = iteration > 1 .and. length*(length/before)**2 < 0.1_dp*tolerance
         before = length
      end do
   end subroutine newton

   !> Unit tangent with the factors of the last Newton step, keeping the sense of the tangent that `solution` holds.
   subroutine find_tangent(self, solution)
      class(corrector_type), intent(inout) :: self
      type(solution_point_type), intent(inout) :: solution
      real(dp) :: y, length

      self%step = 0
      y = 1
      call self%matrix%solve(self%balance, self%step, y)
      length = self%length_of(self%step, y)
      if (inner(self%step, solution%tangent)/self%units%length**2 &
          + y*solution%tangent_frequency/self%units%frequency_ratio**2 < 0) length = -length
      solution%tangent = self%step/length
      solution%orientation = self%matrix%orientation
      if (length < 0) solution%orientation = -solution%orientation
      solution%tangent_frequency = y/length
   end subroutine find_tangent

   !> Puts the coefficients of a solution point onto the present harmonics. Not by their order: fewer harmonics of Lambda are
   !> not always the first ones of more (needed_harmonics.f90).
   pure subroutine refit(self, solution)
      class(corrector_type), intent(in) :: self
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
   end subroutine refit

   !> Length in the metric of a change of the coefficients and, where given, of Lambda.
   pure real(dp) function length_of(self, u, frequency_ratio)
      class(corrector_type), intent(in) :: self
      real(dp), intent(in) :: u(:, :)
      real(dp), intent(in), optional :: frequency_ratio

      length_of = inner(u, u)/self%units%length**2
      if (present(frequency_ratio)) length_of = length_of + (frequency_ratio/self%units%frequency_ratio)**2
      length_of = sqrt(length_of)
   end function length_of

   !> Border row of the equation that a correction of `solution` is across its tangent.
   pure subroutine across(self, solution, row, row_frequency)
      class(corrector_type), intent(in) :: self
      type(solution_point_type), intent(in) :: solution
      real(dp), intent(out) :: row(:, :), row_frequency

      row = weighted(solution%tangent)/self%units%length
      row_frequency = solution%tangent_frequency*(self%units%length/self%units%frequency_ratio**2)
   end subroutine across

   !> Newton step at which u counts as solved: relative to the motion, the mean counted from the wall it leans on, because a
   !> lightly loaded train moves by much less than its gap. Rounding of the mean is the floor.
   pure real(dp) function tolerance_at(self, u) result(tolerance)
      class(corrector_type), intent(in) :: self
      real(dp), intent(in) :: u(:, :)
      real(dp) :: beyond
      integer :: i

      beyond = 0
      do i = 1, size(u, 2)
         beyond = beyond + (abs(u(1, i)) - self%balance%system%half_backlash(self%balance%mesh(i)))**2 + 0.5_dp*sum(u(2:, i)**2)
      end do
      tolerance = max(converged*(2 + sqrt(beyond)/self%units%length), rounding*self%length_of(u))
   end function tolerance_at

   !> Inner product of two sets of coefficients; the metric's is this over the square of the unit of length.
   pure real(dp) function inner(a, b)
      real(dp), intent(in) :: a(:, :), b(:, :)

      inner = 0
      if (size(a) > 0) inner = 0.5_dp*(sum(a*b) + sum(a(1, :)*b(1, :)))
   end function inner

   !> Covector of the metric.
   pure function weighted(a)
      real(dp), intent(in) :: a(:, :)
      real(dp) :: weighted(size(a, 1), size(a, 2))

      weighted = 0.5_dp*a
      if (size(a) > 0) weighted(1, :) = a(1, :)
   end function weighted

end module geartrain_continuation_corrector
