!> Whether a parameter of a train has an effect.
module geartrain_network_parameter_effect
   use geartrain_base_kinds, only: dp
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_network_light_loads, only: reduce_light_loads
   use geartrain_network_modal_damping, only: resolve_damping
   use geartrain_network_parameter, only: variation
   use geartrain_network_parameter_table, only: add_to_parameter, parameter_type, table_type
   use geartrain_train_mesh, only: has_loads
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: has_effect

   !> Change of a parameter that shows an effect, relative, or absolute where the parameter is 0.
   real(dp), parameter :: drawing_step = 1e-5_dp

contains

   !> Whether anything follows from a parameter of the drawing: not where what would follow from it is given.
   logical function has_effect(train, parameter)
      !> The train as described.
      type(train_type), intent(in) :: train
      type(parameter_type), intent(in) :: parameter
      type(table_type) :: here, changed
      real(dp) :: step
      logical :: there
      integer :: i, way

      ! A train with dry friction is one of another kind than a train without, whatever the amount.
      has_effect = .not. parameter%variable == 'friction_torque' .or. abs(parameter%value) > 0
      if (.not. has_effect) return
      if (parameter%plain .or. parameter%variable == variation .or. parameter%variable == 'phase') return
      ! The factors of the teeth are no variables of the plain train.
      if (index(parameter%variable, '_tooth_stiffness') > 0) return
      ! Nor are the stages of a mesh.
      if (any(parameter%variable == [character(15) :: 'stiffness_table', 'table_loads']) &
          .and. any([(has_loads(train%meshes(i)), i=1, size(train%meshes))])) return
      step = drawing_step*merge(abs(parameter%value), 1.0_dp, abs(parameter%value) > 0)
      call derive(train, parameter, 0.0_dp, here, there)
      do way = 1, -1, -2
         call derive(train, parameter, way*step, changed, there)
         if (.not. there) cycle
         if (changed%holds_more_than(here, parameter)) return
      end do
      has_effect = .false.
   end function has_effect

   !> Takes the numbers of the plain train at a changed parameter.
   subroutine derive(train, parameter, change, table, allowed)
      !> The train as described.
      type(train_type), intent(in) :: train
      type(parameter_type), intent(in) :: parameter
      !> The change [unit of the parameter].
      real(dp), intent(in) :: change
      !> Gets the numbers.
      type(table_type), intent(inout) :: table
      !> Whether the changed value is in the range of its variable.
      logical, intent(out) :: allowed
      type(train_type) :: changed, side

      changed = train
      call add_to_parameter(changed, parameter, change, allowed)
      if (.not. allowed) return
      call plain_train(changed, side)
      call reduce_light_loads(side)
      call resolve_damping(side)
      call table%take(side)
   end subroutine derive

end module geartrain_network_parameter_effect
