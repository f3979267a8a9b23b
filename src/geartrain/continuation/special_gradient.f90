!> Derivatives of Lambda of special points of a branch with respect to parameters of the train.
!>
!> A fold: with the border (t, 0), t the tangent, the solution of [dS/du, dS/dLambda; t] (du, dLambda) = (-dS, 0) has dLambda of
!> the fold, whatever the border. A period doubling: dS/du of the balance of twice the period is singular. With [J b; c 0] (v, g)
!> = (0, 1) the fold of symmetry is at g = 0, and dg is the last entry of [J b; c 0]^-1 (-dJ v, 0); dLambda = -dg/(dg/dLambda).
module geartrain_continuation_special_gradient
   use geartrain_balance_balance_rate, only: balance_rate_type
   use geartrain_balance_force_rates, only: along_frequency, force_rates, tangent_rates
   use geartrain_base_error, only: error_type, fatal, status_ended_early
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_continuation_branch, only: branch_type, response_settings_type
   use geartrain_continuation_corrector, only: corrector_type, solution_point_type
   use geartrain_continuation_critical_point, only: find_critical, harmonics_at
   use geartrain_continuation_linearized_motion, only: add_tangent, factor, grazes, prepare, solution_on
   use geartrain_continuation_points, only: motion_of
   use geartrain_continuation_special_points, only: generic_vector
   use geartrain_continuation_start, only: doubled_settings
   use geartrain_model_units, only: units_of
   use geartrain_model_gradient, only: begin_gradient, gradient_type, parameters_type
   use geartrain_model_system_rate, only: system_rate_type
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: special_gradient

contains

   !> Finds dLambda of a special point of a branch: a fold, or the period doubling of the balance that is nearest to it.
   subroutine special_gradient(train, settings, branch, special, names, gradient, error)
      !> The train.
      type(train_type), intent(in) :: train
      !> Settings that the branch was traced with.
      type(response_settings_type), intent(in) :: settings
      !> The branch.
      type(branch_type), intent(in) :: branch
      !> Number of the special point.
      integer, intent(in) :: special
      !> Names of the parameters, (parameter).
      character(*), intent(in) :: names(:)
      !> The derivatives, (1, parameter).
      type(gradient_type), intent(out) :: gradient
      type(error_type), allocatable, intent(out) :: error
      type(parameters_type), target :: given
      type(corrector_type) :: corrector
      type(solution_point_type) :: solution
      type(response_settings_type) :: doubled
      integer :: highest
      logical :: success

      call given%setup(train, names, error)
      if (.not. allocated(error) .and. allocated(branch%parameter)) &
         call fatal(error, 'gradient: of special points of a branch over a frequency, not over a parameter')
      if (allocated(error)) return
      call begin_gradient(gradient, 1, size(names))
      associate (point => branch%special_points(special))
         if (point%multiplicity > 1) then
            call fatal(error, 'gradient: '//text(point%multiplicity)//' multipliers pass the unit circle together at this '// &
                       trim(point%kind)//', as equal branches begin to move differently: it has no derivatives', status_ended_early)
            return
         end if
         select case (point%kind)
         case ('fold')
            call prepare(corrector, given%system, motion_of(branch, point%point))
            call find_fold(corrector, branch, point%point, solution, success)
            if (success) call fold_rates()
         case ('period doubling')
            call find_critical(train, settings, branch, special, solution, success)
            if (success) then
               highest = merge(settings%harmonics, harmonics_at(branch, special), settings%harmonics > 0)
               corrector%units = units_of(given%system)
               doubled = doubled_settings(train, settings, branch)
               call corrector%balance%setup(given%system, highest*(doubled%subharmonic/branch%subharmonic), doubled%subharmonic, &
                                            0, repeats=max(1, doubled%repeats))
               call corrector%setup()
               call doubling_rates()
            end if
         case default
            call fatal(error, 'gradient: there are no derivatives of a special point of kind "'//trim(point%kind)// &
                       '", only of folds and period doublings', status_ended_early)
            return
         end select
      end associate
      gradient%frequency_ratio = solution%frequency_ratio
      if (.not. success) gradient%reason = 'the balance has no such point near the special point'

   contains

      subroutine fold_rates()
         real(dp), dimension(corrector%balance%block, corrector%balance%unknowns) :: row, s, force
         type(balance_rate_type) :: parts
         type(system_rate_type) :: rate
         real(dp) :: corner, y
         integer :: n

         call corrector%across(solution, row, corner)
         call factor(corrector, solution, row, corner, success)
         if (.not. success) return
         if (grazes(corrector%balance, solution%u)) then
            gradient%reason = 'the motion grazes the edge of a gap'
            return
         end if
         call parts%setup(corrector%balance, corrector%balance%force, excited=.true.)
         do n = 1, size(names)
            call given%rate_of(n, rate, gradient%reason(n))
            if (gradient%reason(n) /= '') cycle
            call force_rates(corrector%balance, rate, solution%u, force)
            call parts%residual(corrector%balance, rate, solution%u, force, s)
            s = -s
            y = 0
            call corrector%matrix%solve(corrector%balance, s, y)
            gradient%values(1, n) = y
         end do
      end subroutine fold_rates

      subroutine doubling_rates()
         real(dp), dimension(corrector%balance%block, corrector%balance%unknowns) :: b, v, s, x, force, forced
         type(balance_rate_type) :: parts, critical
         type(system_rate_type) :: rate
         real(dp) :: g, g_frequency, y
         integer :: i, k, n

         call generic_vector(1, b, y)
         b(1, :) = 0
         do k = 2, size(corrector%balance%harmonic), 2
            b(2*k:2*k + 1, :) = 0
         end do
         ! Newton's method on g, the motion corrected along; then all at the critical point.
         do i = 1, 4
            call factor(corrector, solution, solution%tangent, 0.0_dp, success, b)
            if (.not. success) return
            v = 0
            g = 1
            call corrector%matrix%solve(corrector%balance, v, g)
            forced = 0
            call add_tangent(corrector%balance, v, forced)
            x = -corrector%balance%d_frequency
            y = 0
            call corrector%matrix%solve(corrector%balance, x, y)
            call along_frequency(corrector%balance, solution%u, x, v, forced, s)
            s = -s
            g_frequency = 0
            call corrector%matrix%solve(corrector%balance, s, g_frequency)
            if (i == 4) exit
            s = -corrector%balance%residual
            y = 0
            call corrector%matrix%solve(corrector%balance, s, y)
            solution%u = solution%u + s - g/g_frequency*x
            solution%frequency_ratio = solution%frequency_ratio - g/g_frequency
         end do
         if (grazes(corrector%balance, solution%u)) then
            gradient%reason = 'the motion grazes the edge of a gap'
            return
         end if
         call parts%setup(corrector%balance, corrector%balance%force, excited=.true.)
         call critical%setup(corrector%balance, forced, excited=.false.)
         do n = 1, size(names)
            call given%rate_of(n, rate, gradient%reason(n))
            if (gradient%reason(n) /= '') cycle
            call force_rates(corrector%balance, rate, solution%u, force)
            call parts%residual(corrector%balance, rate, solution%u, force, x)
            x = -x
            y = 0
            call corrector%matrix%solve(corrector%balance, x, y)
            call force_rates(corrector%balance, rate, v, force, linear=.true.)
            call tangent_rates(corrector%balance, solution%u, x, v, force, rate)
            call critical%residual(corrector%balance, rate, v, force, s)
            s = -s
            y = 0
            call corrector%matrix%solve(corrector%balance, s, y)
            gradient%values(1, n) = -y/g_frequency
         end do
      end subroutine doubling_rates

   end subroutine special_gradient

   !> Finds the point at which Lambda turns: the zero of its part of the tangent, from the point of the branch.
   subroutine find_fold(corrector, branch, point, solution, success)
      type(corrector_type), intent(inout) :: corrector
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: point
      type(solution_point_type), intent(out) :: solution
      logical, intent(out) :: success
      type(solution_point_type) :: next
      real(dp), parameter :: step = 1e-4_dp
      real(dp) :: slope
      integer :: i

      solution = solution_on(corrector%balance, motion_of(branch, point))
      next = solution_on(corrector%balance, motion_of(branch, merge(point - 1, point + 1, point == branch%points)))
      solution%tangent = next%u - solution%u
      solution%tangent_frequency = next%frequency_ratio - solution%frequency_ratio
      solution%tangent = solution%tangent/corrector%length_of(solution%tangent, solution%tangent_frequency)
      call corrector%correct(solution, success)
      do i = 1, 5
         if (.not. success) return
         call corrector%advance(solution, step, next, success)
         if (.not. success) return
         slope = (next%tangent_frequency - solution%tangent_frequency)/step
         slope = -solution%tangent_frequency/slope
         success = abs(slope) < 0.1_dp
         if (.not. success) return
         solution%u = solution%u + slope*solution%tangent
         solution%frequency_ratio = solution%frequency_ratio + slope*solution%tangent_frequency
         call corrector%correct(solution, success)
         if (abs(slope) < 1e-8_dp) return
      end do
   end subroutine find_fold

end module geartrain_continuation_special_gradient
