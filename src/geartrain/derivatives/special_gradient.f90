!> Derivatives of Lambda of a special point of a branch with respect to parameters of the train: of the Lambda that the branch
!> lists, by the conditions that the listed point fulfils.
!>
!> On a branch of the balance a fold is where Lambda turns: with the border (t, 0), t the tangent, the solution of
!> [dS/du, dS/dLambda; t] (du, dLambda) = (-dS, 0) has dLambda of the fold, whatever the border. A period doubling and a
!> Neimark-Sacker point are where a multiplier of the balanced motion crosses the unit circle, f = 0. With (du, dLambda) as above,
!> f changes by f_q along (du, dLambda, dq) and by f_t along the tangent: dLambda - t_Lambda f_q/f_t belongs to the crossing.
!> f_q and f_t are differences. A refined branch lists special points of the exact motion (exact_gradient.f90).
module geartrain_derivatives_special_gradient
   use geartrain_balance_balance, only: balance_type
   use geartrain_base_error, only: error_type, fatal, status_ended_early
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_derivatives_crossing_multiplier, only: crossing_multiplier_type
   use geartrain_derivatives_exact_gradient, only: exact_gradient
   use geartrain_derivatives_listed_point, only: listed_point_type
   use geartrain_exact_exact_point, only: check_whole_period
   use geartrain_linalg_differences, only: differences_type
   use geartrain_network_check_coupling, only: refuse_friction_of
   use geartrain_network_gradient, only: begin_gradient, gradient_type, parameters_type, reason_length, sides_type
   use geartrain_network_system, only: system_type
   use geartrain_trace_branch, only: branch_type
   use geartrain_trace_linearized_motion, only: factor, grazes, residual_rate, step_of_residual
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: special_gradient

   !> Longest step of a difference: as a share of the step of the branch and at most [units_type], and relative to the parameter.
   real(dp), parameter :: share = 0.1_dp, longest = 5e-4_dp, relative = 1e-2_dp
   !> Share of the longest step at which differences are given up where the multipliers are not known.
   real(dp), parameter :: least = 1e-4_dp
   character(*), parameter :: abrupt = 'the multipliers change too abruptly next to the special point'
   !> Error of a derivative, relative to its two parts, above which there is none.
   real(dp), parameter :: unsettled = 1e-5_dp
   !> Error up to which a derivative is known however small it is: change of Lambda over Lambda, per change of the parameter over
   !> the parameter. The two parts of a derivative that is 0 are rounding of multipliers (1e-12) over steps of some 1e-4.
   real(dp), parameter :: settled = 1e-7_dp

contains

   !> Finds dLambda of a special point of a branch.
   subroutine special_gradient(train, branch, special, names, gradient, error)
      type(train_type), intent(in) :: train
      type(branch_type), intent(in) :: branch
      !> Number of the special point.
      integer, intent(in) :: special
      !> Names of the parameters, (parameter).
      character(*), intent(in) :: names(:)
      !> The derivatives, (1, parameter), and Lambda of the point at which they hold.
      type(gradient_type), intent(out) :: gradient
      type(error_type), allocatable, intent(out) :: error
      type(parameters_type), target :: given
      type(listed_point_type) :: listed
      character(reason_length) :: reason
      logical :: found

      call given%setup(train, names, error)
      if (.not. allocated(error)) call refuse_friction_of(train, 'gradient: special points', error)
      if (.not. allocated(error) .and. allocated(branch%parameter)) &
         call fatal(error, 'gradient: of special points of a branch over a frequency, not over a parameter')
      if (allocated(error)) return
      call begin_gradient(gradient, 1, size(names))
      ! The fold of a balance needs no multipliers.
      if (branch%special_points(special)%kind /= 'fold' .or. .not. branch%special_points(special)%correction < 0) &
         call check_whole_period(train, branch, branch%special_points(special), 'gradient', error)
      if (allocated(error)) return
      associate (point => branch%special_points(special))
         if (point%multiplicity > 1) then
            call fatal(error, 'gradient: '//text(point%multiplicity)//' multipliers pass the unit circle together at this '// &
                       trim(point%kind)//', as equal branches begin to move differently: it has no derivatives', status_ended_early)
            return
         end if
         if (.not. point%correction < 0) then
            call exact_gradient(train, branch, special, given, gradient, error)
            return
         end if
         if (point%kind == 'branch point') then
            call fatal(error, 'gradient: there are no derivatives of a branch point but of a refined branch', status_ended_early)
            return
         end if
         call listed%find(given%system, branch, special, found, reason)
         if (found) gradient%frequency_ratio = listed%solution%frequency_ratio
         gradient%reason = reason
         if (found .and. reason == '') call find_rates(given, listed, point%kind == 'fold', point%kind == 'period doubling', &
                                                       gradient)
      end associate
   end subroutine special_gradient

   !> Finds the derivatives of a point of the balance.
   subroutine find_rates(given, listed, folds, doubles, gradient)
      type(parameters_type), target, intent(inout) :: given
      type(listed_point_type), intent(inout) :: listed
      !> The point is a fold; it is a period doubling.
      logical, intent(in) :: folds, doubles
      type(gradient_type), intent(inout) :: gradient
      real(dp), dimension(listed%corrector%balance%block, listed%corrector%balance%unknowns) :: row, s
      type(balance_type) :: beside
      type(sides_type) :: sides
      type(differences_type) :: along, across
      real(dp) :: corner, y
      integer :: n
      logical :: success, known(2)

      associate (corrector => listed%corrector, solution => listed%solution)
         call corrector%across(solution, row, corner)
         call factor(corrector, solution, row, corner, success)
         if (.not. success) gradient%reason = 'the balance is singular there'
         if (.not. success) return
         if (grazes(corrector%balance, solution%u)) then
            gradient%reason = 'the motion grazes the edge of a gap'
            return
         end if
         if (.not. folds) then
            call go_along_tangent()
            if (.not. along%error < unsettled*abs(along%value)) gradient%reason = abrupt
            if (.not. along%error < unsettled*abs(along%value)) return
         end if
         associate (system => given%system)
            call listed%plan%apply(system, beside)
         end associate
         do n = 1, size(gradient%reason)
            call given%find_sides(n, step_of_residual, sides, gradient%reason(n))
            if (gradient%reason(n) /= '') cycle
            call residual_rate(beside, corrector%balance, sides, solution, s)
            s = -s
            y = 0
            call corrector%matrix%solve(corrector%balance, s, y)
            if (folds) gradient%values(1, n) = y
            if (.not. folds) call go_along_parameter()
         end do
      end associate

   contains

      !> Derivative of the crossing multiplier along the branch.
      subroutine go_along_tangent()
         real(dp) :: f(2)

         associate (u => listed%solution%u, t => listed%solution%tangent, frequency_ratio => listed%solution%frequency_ratio, &
                    t_frequency => listed%solution%tangent_frequency)
            call along%begin(min(share*listed%length, longest), one_sided=.false.)
            do while (.not. along%done)
               associate (h => along%step)
                  call listed%crossing%value_at(u + h*t, frequency_ratio + h*t_frequency, listed%multiplier, f(1), known(1))
                  call listed%crossing%value_at(u - h*t, frequency_ratio - h*t_frequency, listed%multiplier, f(2), known(2))
                  if (all(known)) then
                     call along%add((f(1) - f(2))/(2*h))
                  else
                     call along%begin(h/2, one_sided=.false.)
                     if (h < least*listed%length) return
                  end if
               end associate
            end do
         end associate
      end subroutine go_along_tangent

      !> Derivative of the crossing multiplier with the parameter, and of Lambda at which it crosses. At an end of the range of the
      !> parameter the differences are one-sided.
      subroutine go_along_parameter()
         real(dp) :: f(2), begun, h, ratio, off
         integer :: side
         logical :: allowed(2)

         begun = min(share*listed%length, longest)/max(listed%corrector%length_of(s, y), 1e-100_dp)
         begun = min(begun, merge(relative*given%value_of(n), 1.0_dp, given%value_of(n) > 0))
         call value_at(-begun, f(1), allowed(1), known(1))
         call value_at(begun, f(2), allowed(2), known(2))
         side = 0
         if (.not. allowed(1)) side = 1
         if (.not. allowed(2)) side = -1
         call across%begin(begun, one_sided=side /= 0)
         do while (.not. across%done)
            h = across%step
            f = 0
            known = .true.
            if (side <= 0) call value_at(-h, f(1), allowed(1), known(1))
            if (side >= 0) call value_at(h, f(2), allowed(2), known(2))
            if (all(known)) then
               call across%add((f(2) - f(1))/(h*merge(2, 1, side == 0)))
            else
               call across%begin(h/2, one_sided=side /= 0)
               if (h < least*begun) exit
            end if
         end do
         ratio = listed%solution%tangent_frequency/along%value
         off = abs(ratio)*(across%error + abs(across%value/along%value)*along%error)
         if (off <= max(unsettled*(abs(y) + abs(ratio*across%value)), floor_of(n))) then
            gradient%values(1, n) = y - ratio*across%value
            gradient%uncertainty(1, n) = off
         else
            gradient%reason(n) = abrupt
         end if
      end subroutine go_along_parameter

      !> Error of a derivative at which it is settled, however small it is; 0 for a parameter of value 0, which has no scale.
      real(dp) function floor_of(n)
         integer, intent(in) :: n

         floor_of = 0
         if (given%value_of(n) > 0) floor_of = settled*listed%solution%frequency_ratio/given%value_of(n)
      end function floor_of

      !> What is 0 at the crossing, of the train with another value of the parameter.
      subroutine value_at(change, f, allowed, known)
         real(dp), intent(in) :: change
         real(dp), intent(out) :: f
         !> Whether the value is in the range of the parameter; whether the multiplier is known.
         logical, intent(out) :: allowed, known
         type(system_type), target :: system
         type(crossing_multiplier_type) :: crossing

         f = 0
         call given%changed_system(n, change, system, allowed)
         known = allowed
         if (.not. allowed) return
         call crossing%setup(system, listed%plan, doubles)
         call crossing%value_at(listed%solution%u + change*s, listed%solution%frequency_ratio + change*y, listed%multiplier, &
                                f, known)
      end subroutine value_at

   end subroutine find_rates

end module geartrain_derivatives_special_gradient
