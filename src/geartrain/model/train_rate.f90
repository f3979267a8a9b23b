!> Derivatives of the numbers of a plain train with respect to a parameter.
module geartrain_model_train_rate
   use geartrain_base_kinds, only: dp
   use geartrain_model_drawing, only: plain_train, reduce_light_loads
   use geartrain_model_modal_damping, only: resolve_damping
   use geartrain_model_parameter, only: variation
   use geartrain_model_parameter_table, only: add_to_parameter, parameter_type, table_type
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: find_train_rate, has_effect

   !> Change of a parameter for differences of the derivation from the drawing, relative, or absolute where the parameter is 0.
   real(dp), parameter :: drawing_step = 1e-5_dp

contains

   !> Adds the derivative of every number of the plain train with respect to a parameter: 1 at the parameter itself; where the
   !> parameter is one of the drawing, or turned by `phase`, by differences of the derivation, at an end of its range one-sided.
   subroutine find_train_rate(train, plain, parameter, rate, differentiable)
      !> The train as described; its plain train, with the stiffnesses for its loads.
      type(train_type), intent(in) :: train, plain
      !> The parameter.
      type(parameter_type), intent(in) :: parameter
      !> `plain` with the sums so far for all numbers, 0 at first [1/unit of the parameter]; its lists may get longer.
      type(train_type), intent(inout) :: rate
      !> False where the derivation from the drawing gives other numbers on both sides of the parameter, or lists of other lengths.
      logical, intent(out) :: differentiable
      type(train_type) :: side
      type(table_type) :: above, below, here, further
      real(dp) :: step
      logical :: up, down
      integer :: j

      differentiable = .true.
      if (parameter%variable == variation) then
         do j = 1, size(plain%meshes)
            associate (mesh => plain%meshes(j))
               if (allocated(mesh%stiffness_cos)) rate%meshes(j)%stiffness_cos = mesh%stiffness_cos/parameter%value
               if (allocated(mesh%stiffness_sin)) rate%meshes(j)%stiffness_sin = mesh%stiffness_sin/parameter%value
            end associate
         end do
         return
      end if
      if (parameter%direct) then
         call add_to_parameter(rate, parameter, 1.0_dp)
         return
      end if
      if (parameter%variable == 'phase') then
         associate (mesh => plain%meshes(parameter%index), d => rate%meshes(parameter%index))
            call turn(mesh%stiffness_cos, mesh%stiffness_sin, d%stiffness_cos, d%stiffness_sin)
            call turn(mesh%error_cos, mesh%error_sin, d%error_cos, d%error_sin)
         end associate
         return
      end if
      step = step_of(parameter)
      call derive(train, parameter, step, above, side, up)
      call derive(train, parameter, -step, below, side, down)
      if (up .and. down) then
         differentiable = above%numbers == below%numbers
         if (differentiable) below%number = (above%number(:above%numbers) - below%number(:below%numbers))/(2*step)
      else
         if (down) step = -step
         if (down) above = below
         call derive(train, parameter, 0.0_dp, here, side, up)
         call derive(train, parameter, 2*step, further, side, down)
         differentiable = up .and. down .and. above%numbers == here%numbers .and. above%numbers == further%numbers
         if (differentiable) below%number = (4*above%number(:above%numbers) - 3*here%number(:above%numbers) &
                                             - further%number(:above%numbers))/(2*step)
      end if
      if (.not. differentiable) return
      call here%take(rate)
      if (here%numbers == above%numbers) below%number = below%number + here%number(:here%numbers)
      rate = side
      call below%give(rate)

   contains

      !> Derivative of harmonics with respect to the phase by which they lag.
      subroutine turn(cosine, sine, d_cosine, d_sine)
         real(dp), allocatable, intent(in) :: cosine(:), sine(:)
         real(dp), allocatable, intent(inout) :: d_cosine(:), d_sine(:)
         integer :: h

         if (allocated(sine)) d_cosine = [(-h*sine(h), h=1, size(sine))]
         if (allocated(cosine)) d_sine = [(h*cosine(h), h=1, size(cosine))]
      end subroutine turn

   end subroutine find_train_rate

   !> Whether anything follows from a parameter of the drawing: not where what would follow from it is given.
   logical function has_effect(train, parameter)
      !> The train as described.
      type(train_type), intent(in) :: train
      !> The parameter.
      type(parameter_type), intent(in) :: parameter
      type(train_type) :: side
      type(table_type) :: here, changed
      logical :: there
      integer :: way

      has_effect = .true.
      if (parameter%plain .or. parameter%variable == variation .or. parameter%variable == 'phase') return
      call derive(train, parameter, 0.0_dp, here, side, there)
      do way = 1, -1, -2
         call derive(train, parameter, way*step_of(parameter), changed, side, there)
         if (.not. there) cycle
         if (changed%holds_more_than(here, parameter)) return
      end do
      has_effect = .false.
   end function has_effect

   !> Change of a parameter for differences [unit of the parameter].
   pure real(dp) function step_of(parameter)
      !> The parameter.
      type(parameter_type), intent(in) :: parameter

      step_of = drawing_step*merge(abs(parameter%value), 1.0_dp, abs(parameter%value) > 0)
   end function step_of

   !> Takes the numbers of the plain train at a changed parameter.
   subroutine derive(train, parameter, change, table, side, allowed)
      !> The train as described.
      type(train_type), intent(in) :: train
      !> The parameter.
      type(parameter_type), intent(in) :: parameter
      !> The change [unit of the parameter].
      real(dp), intent(in) :: change
      !> Gets the numbers.
      type(table_type), intent(inout) :: table
      !> Gets the plain train, where the change is allowed.
      type(train_type), intent(inout) :: side
      !> Whether the changed value is in the range of its variable.
      logical, intent(out) :: allowed
      type(train_type) :: changed

      changed = train
      call add_to_parameter(changed, parameter, change, allowed)
      if (.not. allowed) return
      call plain_train(changed, side)
      call reduce_light_loads(side)
      call resolve_damping(side)
      call table%take(side)
   end subroutine derive

end module geartrain_model_train_rate
