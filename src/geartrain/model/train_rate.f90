!> Derivatives of the numbers of a plain train with respect to a parameter.
module geartrain_model_train_rate
   use geartrain_base_kinds, only: dp
   use geartrain_model_drawing, only: plain_train, reduce_light_loads
   use geartrain_model_parameter, only: add_to_parameter, parameter_type, table_type, variation
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: find_train_rate

   !> Change of a parameter for differences of the derivation from the drawing, relative, or absolute where the parameter is 0.
   real(dp), parameter :: drawing_step = 1e-5_dp

contains

   !> Finds the derivative of every number of the plain train with respect to a parameter: 1 at the parameter itself; where the
   !> parameter is one of the drawing, or turned by `phase`, by differences of the derivation.
   subroutine find_train_rate(train, plain, parameter, rate, differentiable)
      !> The train as described; its plain train, with the stiffnesses for its loads.
      type(train_type), intent(in) :: train, plain
      !> The parameter.
      type(parameter_type), intent(in) :: parameter
      !> `plain` with 0 for all numbers; gets the derivatives [1/unit of the parameter], lists perhaps longer.
      type(train_type), intent(inout) :: rate
      !> False at the end of the range of the parameter, where the derivation from the drawing cannot go on.
      logical, intent(out) :: differentiable
      type(train_type) :: changed, side
      type(table_type) :: above, below
      real(dp) :: step
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
         do j = 1, size(plain%meshes)
            if (parameter%index /= 0 .and. parameter%index /= j) cycle
            associate (mesh => plain%meshes(j), d => rate%meshes(j))
               call turn(mesh%stiffness_cos, mesh%stiffness_sin, d%stiffness_cos, d%stiffness_sin)
               call turn(mesh%error_cos, mesh%error_sin, d%error_cos, d%error_sin)
            end associate
         end do
         return
      end if
      step = drawing_step*merge(abs(parameter%value), 1.0_dp, abs(parameter%value) > 0)
      call derive(step, above)
      call derive(-step, below)
      if (differentiable) differentiable = above%numbers == below%numbers
      if (.not. differentiable) return
      below%number = (above%number(:above%numbers) - below%number(:below%numbers))/(2*step)
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

      !> Takes the numbers of the plain train at a changed parameter.
      subroutine derive(change, table)
         real(dp), intent(in) :: change
         type(table_type), intent(inout) :: table
         logical :: allowed

         changed = train
         call add_to_parameter(changed, parameter, change, allowed)
         differentiable = differentiable .and. allowed
         if (.not. allowed) return
         call plain_train(changed, side)
         call reduce_light_loads(side)
         call table%take(side)
      end subroutine derive

   end subroutine find_train_rate

end module geartrain_model_train_rate
