!> Derivatives of figures of a motion, of special points of a branch and of natural frequencies with respect to parameters of the
!> train, by the implicit function theorem: the residual S(u, Lambda, parameter) is 0, so du = -(dS/du)^-1 dS. One factorization
!> serves all parameters.
!>
!> A fold: with the border (t, 0), t the tangent, the solution of [dS/du, dS/dLambda; t] (du, dLambda) = (-dS, 0) has dLambda of
!> the fold, whatever the border. A period doubling: dS/du of the balance of twice the period is singular. With [J b; c 0] (v, g)
!> = (0, 1) the fold of symmetry is at g = 0, and dg is the last entry of [J b; c 0]^-1 (-dJ v, 0); dLambda = -dg/(dg/dLambda).
module geartrain_continuation_gradient
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_balance_rate, only: balance_rate_type
   use geartrain_balance_figure_rates, only: figure_names, figures_type
   use geartrain_balance_force_rates, only: along_frequency, force_rates, tangent_rates
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_needed_harmonics, only: needed_harmonics
   use geartrain_base_error, only: error_type, fatal, status_ended_early
   use geartrain_base_kinds, only: dp
   use geartrain_base_nearest, only: nearest_name
   use geartrain_base_series, only: series_type
   use geartrain_continuation_branch, only: branch_type, response_settings_type
   use geartrain_continuation_corrector, only: corrector_type, solution_point_type
   use geartrain_continuation_critical_point, only: find_critical, harmonics_at
   use geartrain_continuation_points, only: motion_of
   use geartrain_continuation_special_points, only: generic_vector
   use geartrain_continuation_units, only: units_of
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: evaluate, fine_samples, next_maximum, sample
   use geartrain_model_gradient, only: begin_gradient, gradient_type, parameters_type, reason_length
   use geartrain_model_system, only: system_type
   use geartrain_model_system_rate, only: system_rate_type
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: motion_gradient, special_gradient

   !> Carried harmonics up to which the matrix is eliminated as a whole.
   integer, parameter :: most_explicit = 128
   !> Part of Lambda in the unit tangent below which a motion is at a fold; distance of an extreme from a wall, relative to the
   !> amplitude, below which it grazes; relative Newton step at which a motion counts as a solution.
   real(dp), parameter :: at_fold = 1e-5_dp, at_wall = 1e-7_dp, solved = 1e-10_dp

contains

   !> Finds the derivatives of a figure of a motion at constant speed, those of the balance with the harmonics of the motion.
   subroutine motion_gradient(train, motion, figure, names, gradient, error)
      !> The train.
      type(train_type), intent(in) :: train
      !> A periodic motion with its coefficients.
      type(motion_type), intent(in) :: motion
      !> Name of the figure, one of `figure_names`.
      character(*), intent(in) :: figure
      !> Names of the parameters, (parameter).
      character(*), intent(in) :: names(:)
      !> The derivatives, (mesh or shaft, parameter).
      type(gradient_type), intent(out) :: gradient
      type(error_type), allocatable, intent(out) :: error
      type(parameters_type) :: given
      type(corrector_type) :: corrector
      type(solution_point_type) :: solution
      type(balance_rate_type) :: parts
      type(figures_type) :: figures
      type(system_rate_type) :: rate
      character(reason_length) :: reason
      real(dp), allocatable :: s(:, :), force(:, :)
      real(dp) :: y
      integer :: i, n

      call given%setup(train, names, error)
      if (.not. any(figure_names == figure)) then
         i = max(1, nearest_name(figure, figure_names))
         call fatal(error, 'gradient: figure "'//figure//'": unknown (did you mean "'//trim(figure_names(i))//'"?)')
      end if
      if (motion%period < 1 .or. .not. allocated(motion%coefficients)) &
         call fatal(error, 'gradient: the motion has no period or no coefficients')
      if (allocated(error)) return
      n = given%system%meshes
      if (index(figure, 'shaft') == 1) n = size(train%shafts)
      call begin_gradient(gradient, n, size(names))
      call prepare(corrector, given%system, motion)
      solution = solution_on(corrector%balance, motion)
      call settle(corrector, solution, reason)
      gradient%reason = reason
      if (reason /= '') return
      allocate (s, force, mold=solution%u)
      associate (balance => corrector%balance)
         call parts%setup(balance, balance%force, excited=.true.)
         call figures%setup(balance, parts, solution%u, figure)
         do n = 1, size(names)
            if (given%system%interrupt%raised()) return
            call given%rate_of(n, rate, gradient%reason(n))
            if (gradient%reason(n) /= '') cycle
            if (excites_others(rate, balance)) &
               gradient%reason(n) = 'it is 0, and its order is not among the harmonics of the motion'
            if (gradient%reason(n) /= '') cycle
            call force_rates(balance, rate, solution%u, force)
            call parts%residual(balance, rate, solution%u, force, s)
            s = -s
            y = 0
            call corrector%matrix%solve(balance, s, y)
            call add_tangent(balance, s, force)
            call figures%rates(balance, rate, s, force, gradient%values(:, n))
            do i = 1, size(gradient%values, 1)
               if (ieee_is_nan(gradient%values(i, n)) .and. figures%is_told(balance, i)) &
                  gradient%reason(n) = 'two extremes are equal, and their derivatives are not'
            end do
         end do
      end associate
   end subroutine motion_gradient

   !> Solves the balance at a motion, and factors dS/du there.
   subroutine settle(corrector, solution, reason)
      type(corrector_type), intent(inout) :: corrector
      type(solution_point_type), intent(inout) :: solution
      !> Why there are no derivatives; blank where there are.
      character(*), intent(out) :: reason
      real(dp), dimension(corrector%balance%block, corrector%balance%unknowns) :: row, s
      real(dp) :: y
      logical :: success

      reason = 'the balance has no solution at the motion, or not one alone: at a fold, or where the mean is free'
      row = 0
      call factor(corrector, solution, row, 1.0_dp, success)
      if (.not. success) return
      s = -corrector%balance%residual
      y = 0
      call corrector%matrix%solve(corrector%balance, s, y)
      ! A point of a branch is solved to better than this.
      if (.not. corrector%length_of(s) < solved*corrector%length_of(solution%u)) then
         call corrector%solve_at(solution, success)
         if (success) call factor(corrector, solution, row, 1.0_dp, success)
         if (.not. success) return
      end if
      s = 0
      y = 1
      call corrector%matrix%solve(corrector%balance, s, y)
      reason = ''
      if (1/corrector%length_of(s, y) < at_fold) reason = 'the motion is at a fold'
      if (grazes(corrector%balance, solution%u)) reason = 'the motion grazes the edge of a gap'
   end subroutine settle

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
      type(parameters_type) :: given
      type(corrector_type) :: corrector
      type(solution_point_type) :: solution
      integer :: highest
      logical :: success

      call given%setup(train, names, error)
      if (allocated(error)) return
      call begin_gradient(gradient, 1, size(names))
      associate (point => branch%special_points(special))
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
               call corrector%balance%setup(given%system, 2*highest, 2*branch%subharmonic, 0)
               call corrector%setup()
               call doubling_rates()
            end if
         case default
            call fatal(error, 'gradient: a '//trim(point%kind)//' has none; there are those of folds and period doublings', &
                       status_ended_early)
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

   !> Whether a parameter that is 0 excites harmonics that the balance could carry and does not.
   pure logical function excites_others(rate, balance)
      type(system_rate_type), intent(in) :: rate
      type(balance_type), intent(in) :: balance
      integer :: j

      excites_others = .false.
      do j = 1, size(rate%torque)
         call look(rate%torque(j), balance%system%torque(j))
      end do
      do j = 1, balance%system%meshes
         call look(rate%transmission_error(j), balance%system%transmission_error(j))
         if (rate%law_changes(j)) call look(rate%law(j)%variation(), balance%system%law(j)%variation())
      end do

   contains

      pure subroutine look(series, known)
         type(series_type), intent(in) :: series, known
         integer :: h, r

         do h = 1, size(series%amplitude)
            r = h*series%order*balance%eta
            if (.not. abs(series%amplitude(h)) > 0 .or. r > balance%highest) cycle
            if (h <= size(known%amplitude)) then
               if (abs(known%amplitude(h)) > 0) cycle
            end if
            if (.not. any(balance%harmonic == r)) excites_others = .true.
         end do
      end subroutine look

   end function excites_others

   !> Plans the balance with the harmonics of a motion.
   subroutine prepare(corrector, system, motion)
      type(corrector_type), intent(inout) :: corrector
      type(system_type), intent(in) :: system
      type(motion_type), intent(in) :: motion
      integer, allocatable :: carried(:)
      integer :: k, highest

      highest = max(1, (size(motion%coefficients, 1) - 1)/2)
      carried = pack([(k, k=1, highest)], [(any(abs(motion%coefficients(2*k:2*k + 1, :)) > 0), k=1, highest)])
      corrector%units = units_of(system)
      ! Of many harmonics only those that the motion has: the rest of a set is not carried.
      if (size(carried) > 0 .and. motion%period == 1 .and. size(needed_harmonics(system, highest)) > most_explicit) then
         call corrector%balance%setup(system, highest, motion%period, 0, carried)
      else
         call corrector%balance%setup(system, highest, motion%period, 0)
      end if
      call corrector%setup()
   end subroutine prepare

   !> A motion as a guess of a solution on the harmonics of a balance.
   function solution_on(balance, motion) result(solution)
      type(balance_type), intent(in) :: balance
      type(motion_type), intent(in) :: motion
      type(solution_point_type) :: solution
      integer :: k

      allocate (solution%u(balance%block, balance%unknowns), source=0.0_dp)
      solution%frequency_ratio = motion%frequency_ratio
      solution%u(1, :) = motion%coefficients(1, balance%mesh)
      do k = 1, size(balance%harmonic)
         associate (r => balance%harmonic(k))
            if (2*r < size(motion%coefficients, 1)) solution%u(2*k:2*k + 1, :) = motion%coefficients(2*r:2*r + 1, balance%mesh)
         end associate
      end do
   end function solution_on

   !> Evaluates the balance and factors dS/du, bordered.
   subroutine factor(corrector, solution, row, corner, regular, column)
      type(corrector_type), intent(inout) :: corrector
      type(solution_point_type), intent(in) :: solution
      real(dp), intent(in) :: row(:, :), corner
      logical, intent(out) :: regular
      !> In place of dS/dLambda.
      real(dp), intent(in), optional :: column(:, :)

      associate (balance => corrector%balance, matrix => corrector%matrix)
         call balance%evaluate(solution%u, solution%frequency_ratio)
         if (size(balance%harmonic) <= most_explicit) call balance%make_explicit(size(balance%harmonic))
         call matrix%linearize(balance)
         if (present(column)) matrix%column = column
         matrix%row = row
         matrix%corner = corner
         call matrix%factor(balance, regular)
      end associate
   end subroutine factor

   !> Adds (d phi/du) x.
   subroutine add_tangent(balance, x, force)
      type(balance_type), intent(inout) :: balance
      real(dp), intent(in) :: x(:, :)
      real(dp), intent(inout) :: force(:, :)
      real(dp) :: f(balance%block)
      integer :: i

      do i = 1, balance%unknowns
         if (balance%is_direct()) then
            f = matmul(balance%tangent(:, :, i), x(:, i))
         else
            call balance%tangent_product(i, x(:, i), f)
         end if
         force(:, i) = force(:, i) + f
      end do
   end subroutine add_tangent

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

   !> Whether an extreme of a displacement lies on a wall.
   logical function grazes(balance, u)
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: u(:, :)
      type(transform_type) :: transform
      real(dp) :: theta, p, slope, curvature, range
      integer :: i, q, side, step

      grazes = .false.
      do i = 1, balance%unknowns
         range = norm2(u(2:, i))
         if (balance%contact(i)%clearance() > 0.1_dp*range) cycle
         call transform%plan(fine_samples(maxval([1, balance%harmonic])))
         call sample(u(:, i), balance%harmonic, transform)
         do side = -1, 1, 2
            q = 0
            do
               call next_maximum(transform%sample, side, -huge(1.0_dp), q, theta)
               if (q == 0) exit
               do step = 1, 8
                  call evaluate(u(:, i), balance%harmonic, theta, p, slope, curvature)
                  if (.not. abs(curvature) > 0) exit
                  theta = theta - max(-0.1_dp, min(0.1_dp, slope/curvature))
               end do
               grazes = grazes .or. any(abs(p - balance%contact(i)%law%wall) < at_wall*range)
            end do
         end do
      end do
   end function grazes

end module geartrain_continuation_gradient
