!> Derivatives of figures of a motion with respect to parameters of the train, by the implicit function theorem: the residual
!> S(u, Lambda, parameter) is 0, so du = -(dS/du)^-1 dS. One factorization serves all parameters; dS, and the figures along du, are
!> differences of trains beside the train.
module geartrain_derivatives_motion_gradient
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_figure_rates, only: figure_names, figures_type
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_error, only: error_type, fatal
   use geartrain_base_kinds, only: dp
   use geartrain_base_nearest, only: nearest_name
   use geartrain_base_series, only: series_type
   use geartrain_network_check_coupling, only: has_friction
   use geartrain_network_gradient, only: begin_gradient, gradient_type, parameters_type, reason_length, sides_type
   use geartrain_network_system, only: system_type
   use geartrain_trace_corrector, only: corrector_type, solution_point_type
   use geartrain_trace_linearized_motion, only: factor, grazes, prepare, prepare_balance, residual_rate, solution_on, &
      step_of_residual
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: motion_gradient

   !> Part of Lambda in the unit tangent below which a motion is at a fold; relative Newton step at which a motion counts as a
   !> solution.
   real(dp), parameter :: at_fold = 1e-5_dp, solved = 1e-10_dp

contains

   !> Finds the derivatives of a figure of a motion at constant speed, those of the balance with the harmonics of the motion.
   subroutine motion_gradient(train, motion, figure, names, gradient, error)
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
      type(parameters_type), target :: given
      type(corrector_type) :: corrector
      type(solution_point_type) :: solution
      type(balance_type) :: beside
      type(figures_type) :: figures
      type(sides_type), target :: sides
      type(system_type), pointer :: side
      character(reason_length) :: reason
      real(dp), allocatable :: s(:, :), u(:, :)
      real(dp) :: y
      integer :: i, n

      call given%setup(train, names, error)
      if (has_friction(train)) call fatal(error, 'gradient: friction_torque: derivatives of motions are those of the harmonic &
                                          &balance, which does not have dry friction; take differences of refined motions')
      if (.not. any(figure_names == figure)) then
         i = nearest_name(figure, figure_names)
         if (i > 0) call fatal(error, 'gradient: figure "'//figure//'": unknown (did you mean "'//trim(figure_names(i))//'"?)')
         if (i == 0) call fatal(error, 'gradient: figure "'//figure//'": there are no derivatives but of rms, mean, minimum, '// &
                                'maximum, mesh_force_maximum, dynamic_factor and shaft_torque_mean, _minimum and _maximum')
      end if
      if (motion%period < 1 .or. .not. allocated(motion%coefficients)) &
         call fatal(error, 'gradient: the motion has no period or no coefficients')
      if (.not. motion%frequency_ratio > 0) call fatal(error, 'gradient: the frequency of the motion must be > 0')
      if (allocated(error)) return
      n = given%system%meshes
      if (index(figure, 'shaft') == 1) n = size(train%shafts)
      call begin_gradient(gradient, n, size(names))
      call prepare(corrector, given%system, motion)
      solution = solution_on(corrector%balance, motion)
      call settle(corrector, solution, reason)
      gradient%reason = reason
      if (reason /= '') return
      allocate (s, u, mold=solution%u)
      side => given%system
      call prepare_balance(beside, side, motion)
      associate (balance => corrector%balance)
         call figures%setup(balance, solution%u, figure)
         do n = 1, size(names)
            if (given%system%interrupt%raised()) return
            call given%find_sides(n, step_of_residual, sides, gradient%reason(n))
            if (gradient%reason(n) /= '') cycle
            if (excites_others(sides%system(1), balance)) &
               gradient%reason(n) = 'it is 0, and its order is not among the harmonics of the motion'
            if (gradient%reason(n) /= '') cycle
            call residual_rate(beside, balance, sides, solution, s)
            s = -s
            y = 0
            call corrector%matrix%solve(balance, s, y)
            call figures%begin()
            do i = 1, size(sides%system)
               side => sides%system(i)
               call beside%take(side, balance)
               u = solution%u + sides%change(i)*s
               call beside%evaluate(u, solution%frequency_ratio)
               call figures%add(beside, u, sides%weight(i))
            end do
            call figures%rates(balance, gradient%values(:, n))
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

   !> Whether a train with a little of a parameter has excitation at harmonics that the balance could carry and does not.
   pure logical function excites_others(side, balance)
      type(system_type), intent(in) :: side
      type(balance_type), intent(in) :: balance
      integer :: j

      excites_others = .false.
      do j = 1, size(side%torque)
         excites_others = excites_others .or. excites(side%torque(j), balance%system%torque(j))
      end do
      do j = 1, balance%system%meshes
         excites_others = excites_others .or. excites(side%transmission_error(j), balance%system%transmission_error(j)) .or. &
                          excites(side%law(j)%variation(), balance%system%law(j)%variation())
      end do

   contains

      pure logical function excites(series, known)
         type(series_type), intent(in) :: series, known
         integer :: h, r

         excites = .false.
         do h = 1, size(series%amplitude)
            r = series%harmonic(h)*balance%eta
            if (.not. abs(series%amplitude(h)) > 0 .or. r > balance%highest) cycle
            if (any(known%harmonic == series%harmonic(h) .and. abs(known%amplitude) > 0)) cycle
            if (.not. any(balance%harmonic == r)) excites = .true.
         end do
      end function excites

   end function excites_others

end module geartrain_derivatives_motion_gradient
