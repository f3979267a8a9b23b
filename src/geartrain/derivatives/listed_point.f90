!> Solves a special point of a branch once more, to rounding, by the conditions by which the branch lists it: a fold of the balance,
!> or a multiplier of the balanced motion on the unit circle. The point found is compared with the listed point: among many special
!> points close together Newton's method may go to another point.
module geartrain_derivatives_listed_point
   use geartrain_base_kinds, only: dp
   use geartrain_derivatives_crossing_multiplier, only: crossing_multiplier_type, plan_type
   use geartrain_exact_exact_search, only: neighbours
   use geartrain_linalg_bracket, only: between, shrink
   use geartrain_network_system, only: system_type
   use geartrain_network_units, only: units_of
   use geartrain_trace_branch, only: branch_type
   use geartrain_trace_corrector, only: corrector_type, solution_point_type
   use geartrain_trace_linearized_motion, only: solution_on
   use geartrain_trace_points, only: motion_of
   implicit none (type, external)
   private
   public :: listed_point_type

   !> Distance in Lambda from the listed point up to which a point found is the listed one [units_type]; its distance along the
   !> branch, as a share of the step that the listed point was located in. Listed points are exact to 1e-9 of the step.
   real(dp), parameter :: same_frequency = 1e-7_dp, same_place = 1e-3_dp
   !> Longest step of Newton's method [units_type]; step at which it has converged, and at which it must have.
   real(dp), parameter :: longest = 0.1_dp, converged = 1e-10_dp, must_be = 1e-7_dp
   !> Length of a step for a difference, as a share of the step of the branch, and at most [units_type].
   real(dp), parameter :: small = 1e-3_dp, smallest = 1e-5_dp
   integer, parameter :: max_iterations = 10, max_halvings = 60

   type :: listed_point_type
      !> Corrector with the harmonics of the point.
      type(corrector_type) :: corrector
      !> The point with its unit tangent.
      type(solution_point_type) :: solution
      !> Length of the step of the branch next to the point [units_type].
      real(dp) :: length = 0
      !> Harmonics of the point.
      type(plan_type) :: plan
      !> Of a period doubling or a Neimark-Sacker point the multiplier on the unit circle, and what finds it.
      complex(dp) :: multiplier = 0
      type(crossing_multiplier_type) :: crossing
   contains
      procedure :: find
      procedure, private :: find_fold
      procedure, private :: find_crossing
      procedure, private :: start_at
      procedure, private :: move
   end type listed_point_type

contains

   !> Finds a fold, period doubling or Neimark-Sacker point.
   subroutine find(self, system, branch, number, found, reason)
      class(listed_point_type), intent(inout) :: self
      type(system_type), pointer, intent(in) :: system
      type(branch_type), intent(in) :: branch
      !> Number of the special point.
      integer, intent(in) :: number
      !> Newton's method has converged.
      logical, intent(out) :: found
      !> Why the point found is not the listed point; blank where it is.
      character(*), intent(out) :: reason
      logical :: same
      integer :: points(2), k

      associate (special => branch%special_points(number))
         points = special%point
         ! A step is solved with the harmonics of the end that was reached last.
         if (special%kind /= 'fold') points(1) = min(special%point + 1, branch%points)
         self%corrector%units = units_of(system)
         do k = 1, 2
            if (k == 2 .and. points(1) == points(2)) exit
            call self%plan%take(system, branch, points(k))
            call self%plan%apply(system, self%corrector%balance)
            call self%corrector%setup()
            if (special%kind == 'fold') then
               call self%find_fold(branch, special%point, found, same)
            else
               call self%crossing%setup(system, self%plan, special%kind == 'period doubling')
               call self%find_crossing(branch, special%point, special%frequency_ratio, found, same)
            end if
            if (found) same = same .and. abs(self%solution%frequency_ratio - special%frequency_ratio) &
                                         <= same_frequency*self%corrector%units%frequency_ratio
            if (found .and. same) exit
         end do
         reason = ''
         if (.not. found) then
            reason = 'Newton''s method does not find the special point again'
         else if (.not. same) then
            reason = 'Newton''s method finds another special point than the listed one'
         end if
      end associate
   end subroutine find

   !> Moves along the tangent and corrects.
   subroutine move(self, from, s, to, success)
      class(listed_point_type), intent(inout) :: self
      type(solution_point_type), intent(in) :: from
      real(dp), intent(in) :: s
      type(solution_point_type), intent(inout) :: to
      logical, intent(out) :: success

      to = from
      to%u = from%u + s*from%tangent
      to%frequency_ratio = from%frequency_ratio + s*from%tangent_frequency
      success = to%frequency_ratio > 0
      if (success) call self%corrector%correct(to, success)
   end subroutine move

   !> Finds the fold that is a point of the branch: the zero of the Lambda part of the tangent, by the secant method.
   subroutine find_fold(self, branch, point, found, same)
      class(listed_point_type), intent(inout) :: self
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: point
      logical, intent(out) :: found, same
      type(solution_point_type) :: begun, side(2), next
      real(dp) :: s, slope, f, d(2)
      integer :: i, ends(2)

      same = .false.
      ends = neighbours(branch, point)
      begun = solution_on(self%corrector%balance, motion_of(branch, point))
      do i = 1, 2
         side(i) = solution_on(self%corrector%balance, motion_of(branch, ends(i)))
         d(i) = self%corrector%length_of(side(i)%u - begun%u, side(i)%frequency_ratio - begun%frequency_ratio)
      end do
      self%length = sum(d)
      found = self%length > 0
      if (.not. found) return
      self%solution = begun
      self%solution%tangent = side(2)%u - side(1)%u
      self%solution%tangent_frequency = side(2)%frequency_ratio - side(1)%frequency_ratio
      s = self%corrector%length_of(self%solution%tangent, self%solution%tangent_frequency)
      found = s > 0
      if (.not. found) return
      self%solution%tangent = self%solution%tangent/s
      self%solution%tangent_frequency = self%solution%tangent_frequency/s
      call self%corrector%correct(self%solution, found)
      if (.not. found) return
      f = self%solution%tangent_frequency
      s = min(small*self%length, smallest)
      do i = 1, max_iterations
         call self%move(self%solution, s, next, found)
         if (.not. found) return
         slope = (next%tangent_frequency - f)/s
         found = abs(slope) > 0
         if (.not. found) return
         ! From the nearer of the two places.
         if (abs(next%tangent_frequency) < abs(f)) self%solution = next
         f = self%solution%tangent_frequency
         s = -f/slope
         found = abs(s) < longest
         if (.not. found) return
         if (abs(s) <= converged*self%length) exit
      end do
      found = abs(s) <= must_be*max(self%length, smallest)
      same = self%corrector%length_of(self%solution%u - begun%u, self%solution%frequency_ratio - begun%frequency_ratio) &
             <= same_place*self%length
   end subroutine find_fold

   !> Finds the place in the step after a point at which a multiplier crosses the unit circle, by Newton's method.
   subroutine find_crossing(self, branch, point, frequency_ratio, found, same)
      class(listed_point_type), intent(inout) :: self
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: point
      real(dp), intent(in) :: frequency_ratio
      logical, intent(out) :: found, same
      type(solution_point_type) :: begun, next
      real(dp) :: f(-1:1), h, s
      complex(dp) :: multiplier
      integer :: i, k

      same = .false.
      call self%start_at(branch, point, frequency_ratio, found)
      if (.not. found) return
      begun = self%solution
      call self%crossing%choose(begun%u, begun%frequency_ratio, self%multiplier, found)
      if (.not. found) return
      h = min(small*self%length, smallest)
      do i = 1, max_iterations
         associate (here => self%solution)
            call self%crossing%value_at(here%u, here%frequency_ratio, self%multiplier, f(0), found, multiplier)
            if (.not. found) return
            self%multiplier = multiplier
            do k = -1, 1, 2
               call self%crossing%value_at(here%u + k*h*here%tangent, here%frequency_ratio + k*h*here%tangent_frequency, &
                                           self%multiplier, f(k), found)
               if (.not. found) return
            end do
            found = abs(f(1) - f(-1)) > 0
            if (.not. found) return
            s = -2*h*f(0)/(f(1) - f(-1))
            found = abs(s) < longest
            if (.not. found) return
            call self%move(here, s, next, found)
            if (.not. found) return
         end associate
         self%solution = next
         if (abs(s) <= converged*max(self%length, smallest)) exit
      end do
      found = abs(s) <= must_be*max(self%length, smallest)
      same = self%corrector%length_of(self%solution%u - begun%u, self%solution%frequency_ratio - begun%frequency_ratio) &
             <= same_place*self%length
   end subroutine find_crossing

   !> Solves for the point of the branch at the Lambda of the special point; where the step does not reach this Lambda, as with
   !> another train, for one in the step.
   subroutine start_at(self, branch, point, frequency_ratio, found)
      class(listed_point_type), intent(inout) :: self
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: point
      real(dp), intent(in) :: frequency_ratio
      logical, intent(out) :: found
      type(solution_point_type) :: first, last
      real(dp) :: a, b, fa, fb, s
      integer :: i, kept

      found = point < branch%points
      if (.not. found) return
      first = solution_on(self%corrector%balance, motion_of(branch, point))
      last = solution_on(self%corrector%balance, motion_of(branch, point + 1))
      first%tangent = last%u - first%u
      first%tangent_frequency = last%frequency_ratio - first%frequency_ratio
      self%length = self%corrector%length_of(first%tangent, first%tangent_frequency)
      found = self%length > 0
      if (.not. found) return
      first%tangent = first%tangent/self%length
      first%tangent_frequency = first%tangent_frequency/self%length
      a = 0
      b = self%length
      fa = first%frequency_ratio - frequency_ratio
      fb = last%frequency_ratio - frequency_ratio
      kept = 0
      s = self%length/2
      do i = 1, max_halvings
         if (fa*fb < 0) s = between(a, b, fa, fb)
         call self%move(first, s, self%solution, found)
         if (.not. found .or. fa*fb >= 0) return
         if (abs(self%solution%frequency_ratio - frequency_ratio) <= converged*self%corrector%units%frequency_ratio) return
         call shrink(a, b, fa, fb, s, self%solution%frequency_ratio - frequency_ratio, kept)
         if (b - a < converged*self%length) return
      end do
   end subroutine start_at

end module geartrain_derivatives_listed_point
