!> Derivatives of Lambda of a special point of the exact motion with respect to parameters of the train: differences of the special
!> points of changed trains, each solved to rounding by the augmented system.
module geartrain_derivatives_exact_gradient
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp
   use geartrain_exact_augmented_point, only: augmented_point_type, trains_type
   use geartrain_exact_augmented_system, only: augmented_system_type
   use geartrain_exact_exact_point, only: exact_point_type, find_exact_point
   use geartrain_flow_multiple_shooting, only: most_parts, section_states
   use geartrain_flow_sections, only: sections_type
   use geartrain_linalg_differences, only: differences_type
   use geartrain_network_divide_orders, only: divide_orders
   use geartrain_network_gradient, only: gradient_type, parameters_type, sides_type
   use geartrain_network_system, only: system_type
   use geartrain_network_units, only: units_of
   use geartrain_trace_branch, only: branch_type
   use geartrain_trace_points, only: repeats_of
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: exact_gradient

   !> Change of Lambda between the listed point and the one that the search finds again up to which they are the same [units_type].
   real(dp), parameter :: same_frequency = 1e-7_dp
   !> Longest step of a difference: relative to the parameter, or 1 unit of a parameter that is 0; and shorter where Lambda of the
   !> special point changes by more than `largest_change` [units_type], in so many tenths at most.
   real(dp), parameter :: relative = 1e-3_dp, largest_change = 1e-2_dp
   integer, parameter :: most_tenths = 12
   !> Error of a derivative above which there is none: relative, and of the change of Lambda over the longest step [units_type].
   real(dp), parameter :: unsettled = 1e-5_dp, rounding = 1e-9_dp

contains

   !> Finds dLambda of a special point of a refined branch.
   subroutine exact_gradient(train, branch, special, given, gradient, error)
      type(train_type), intent(in) :: train
      !> The refined branch.
      type(branch_type), intent(in) :: branch
      !> Number of the special point.
      integer, intent(in) :: special
      !> The parameters.
      type(parameters_type), intent(inout) :: given
      !> Gets the derivatives, (1, parameter), and Lambda of the point at which they hold.
      type(gradient_type), intent(inout) :: gradient
      !> The special point is not found again.
      type(error_type), allocatable, intent(out) :: error
      type(exact_point_type) :: exact
      type(augmented_point_type) :: point
      type(sides_type) :: sides
      type(differences_type) :: across
      real(dp) :: h, change(2)
      integer :: n, side, tenths, times
      logical :: found(2)

      call find_exact_point(train, branch, special, branch%special_points(special), exact, error)
      if (allocated(error)) return
      times = repeats_of(branch, given%system)
      gradient%frequency_ratio = exact%frequency_ratio
      if (abs(exact%frequency_ratio - branch%special_points(special)%frequency_ratio) > same_frequency*unit_of()) then
         gradient%reason = 'Newton''s method finds another special point than the listed one'
         return
      end if
      call begin_point()
      do n = 1, size(gradient%reason)
         call given%find_sides(n, relative, sides, gradient%reason(n))
         if (gradient%reason(n) /= '') cycle
         h = merge(relative*given%value_of(n), 1.0_dp, given%value_of(n) > 0)
         do tenths = 1, most_tenths
            call change_at(h, change(1), found(1))
            if (.not. found(1)) call change_at(-h, change(1), found(1))
            if (found(1) .and. abs(change(1)) <= largest_change*unit_of()) exit
            h = h/10
         end do
         side = 0
         if (.not. given%allows(n, -h)) side = 1
         if (.not. given%allows(n, h)) side = -1
         call across%begin(h, one_sided=side /= 0)
         do while (.not. across%done)
            change = 0
            found = .true.
            if (side <= 0) call change_at(-across%step, change(1), found(1))
            if (side >= 0) call change_at(across%step, change(2), found(2))
            if (.not. all(found)) exit
            call across%add((change(2) - change(1))/(across%step*merge(2, 1, side == 0)))
         end do
         if (.not. all(found)) then
            gradient%reason(n) = 'no such special point with a value of the parameter next to it'
         else if (across%error > unsettled*abs(across%value) + rounding*unit_of()/h) then
            gradient%reason(n) = 'the special point changes too abruptly with it'
         else
            gradient%values(1, n) = across%value
         end if
      end do

   contains

      real(dp) function unit_of()
         associate (units => units_of(given%system))
            unit_of = units%frequency_ratio
         end associate
      end function unit_of

      !> States of the special point at the beginnings of sections.
      subroutine begin_point()
         type(system_type), target :: system
         type(sections_type) :: sections

         system = given%system
         call divide_orders(times, system)
         associate (motion => exact%motion)
            motion%frequency_ratio = times*exact%frequency_ratio
            call sections%setup(system, motion%period, most_parts(system, motion%period), moves=.false.)
            call section_states(system, motion, sections, point%states)
            point%frequency_ratio = motion%frequency_ratio
         end associate
      end subroutine begin_point

      !> Change of Lambda of the special point by a change of the parameter.
      subroutine change_at(step, changed, success)
         real(dp), intent(in) :: step
         real(dp), intent(out) :: changed
         logical, intent(out) :: success
         type(system_type) :: system
         type(trains_type), target :: trains
         type(augmented_system_type) :: augmented
         type(augmented_point_type) :: other

         changed = 0
         call given%changed_system(n, step, system, success)
         if (.not. success) return
         call divide_orders(times, system)
         call augmented%setup(trains, system, exact%motion%period, exact%kind, exact%mesh)
         other = point
         call augmented%solve(other, .false., success)
         changed = other%frequency_ratio/times - exact%frequency_ratio
      end subroutine change_at

   end subroutine exact_gradient

end module geartrain_derivatives_exact_gradient
