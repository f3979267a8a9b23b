!> What a coupling is in numbers.
module geartrain_report_explain_coupling
   use geartrain_base_carry, only: carry
   use geartrain_base_field, only: field_type
   use geartrain_base_fields, only: fields_type
   use geartrain_base_kinds, only: dp
   use geartrain_mesh_law_characteristic, only: characteristic_type, find_characteristic
   use geartrain_train_mesh_groups, only: mesh_word
   use geartrain_network_system, only: system_type
   use geartrain_report_explain_bearing, only: explain_bearing
   use geartrain_report_explain_damping, only: damping_explanation_type
   use geartrain_train_labels, only: label_length, mesh_labels
   use geartrain_train_mesh, only: is_given
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: explain_coupling

contains

   !> Adds the group of a coupling, or of a bearing.
   subroutine explain_coupling(train, system, damping, i, fields)
      !> The train as given.
      type(train_type), intent(in) :: train
      type(system_type), intent(in) :: system
      !> Its damping.
      type(damping_explanation_type), intent(in) :: damping
      !> Number of the coupling, or of a direction of a bearing, among all meshes.
      integer, intent(in) :: i
      class(fields_type), intent(inout) :: fields
      character(label_length) :: labels(size(train%meshes))
      type(characteristic_type) :: found
      character(:), allocatable :: words
      real(dp), allocatable :: list(:)
      real(dp) :: torque

      if (train%meshes(i)%axis > 0) then
         if (train%meshes(i)%axis == 1) call explain_bearing(train, system, i, fields)
         return
      end if
      labels = mesh_labels(train)
      if (.not. fields%enter(trim(mesh_word(train%meshes, i)), trim(labels(i)), .true.)) return
      associate (coupling => train%meshes(i))
         call find_characteristic(coupling%torsional_stiffness, coupling%half_play, coupling%angle, coupling%torque, found)
         words = 'as given'
         if (is_given(coupling%angle)) words = 'slope of the polygon beside the play on the side of positive torques or, without &
            &play, where the torque is 0'
         call carry(fields, field_type('stiffness', '', 'N m/rad', words), found%stiffness)
         call damping%explain_element('coupling', i, fields)
         words = 'as given'
         if (is_given(coupling%angle)) words = 'of the part without torque'
         call carry(fields, field_type('half_play', '', 'rad', words), found%half_play)
         if (is_given(coupling%angle)) then
            call carry(fields, field_type('middle', '', 'rad', 'angle from which the displacement in results is counted: the &
               &middle of the play, or the angle without torque'), found%middle)
            list = found%corner
            call carry(fields, field_type('corners', 'corner', 'rad', 'where the slope changes, counted from the middle'), list)
            list = found%slope
            call carry(fields, field_type('stages', 'stage', 'N m/rad', 'slopes, from the lowest torque to the highest'), list)
         end if
         if (coupling%friction_torque > 0) then
            torque = coupling%friction_torque
            call carry(fields, field_type('friction_torque', '', 'N m', 'as given; modes and limits are without it'), torque)
         end if
         torque = system%static_force(system%mesh_element(i))*system%load_unit(i)
         call carry(fields, field_type('mean_torque', '', 'N m', 'static, from the mean torques of the bodies'), torque)
      end associate
   end subroutine explain_coupling

end module geartrain_report_explain_coupling
