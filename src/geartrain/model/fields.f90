!> The fields of the natural modes: the group /modes.
module geartrain_model_fields
   use geartrain_base_carry, only: carry
   use geartrain_base_field, only: row => field_type
   use geartrain_base_fields, only: fields_type
   use geartrain_model_modes, only: modes_type
   implicit none (type, external)
   private
   public :: visit_modes

contains

   subroutine visit_modes(modes, fields)
      type(modes_type), allocatable, intent(inout) :: modes
      class(fields_type), intent(inout) :: fields
      integer :: n

      if (.not. fields%enter('/modes', 'natural modes of the mean system: contact everywhere, mean mesh stiffness', &
                             allocated(modes))) return
      if (.not. allocated(modes)) allocate (modes)
      n = 0
      if (allocated(modes%natural_frequency)) n = size(modes%natural_frequency)
      call fields%index_axis('mode', n, 'elastic mode, by frequency; a rigid mode is left out')
      call carry(fields, row('element', 'element', '', 'elastic element, in the order of the train: `shaft 1`, `mesh 1`, ...'), &
                 modes%element)
      call carry(fields, row('natural_frequency', 'mode', '1', &
                             'undamped natural frequency / characteristic_frequency, mean mesh stiffness, teeth in contact'), &
                 modes%natural_frequency)
      call carry(fields, row('damped_frequency', 'mode', '1', &
                             'imaginary part of the damped eigenvalue / characteristic_frequency; 0 = overdamped'), &
                 modes%damped_frequency)
      call carry(fields, row('damping_ratio', 'mode', '1', 'damping ratio of the mode'), modes%damping_ratio)
      call carry(fields, row('shape', 'mode element', '1', 'displacement of each element (a mesh: along the line of action; a &
                             &shaft: twist times base radius), largest 1'), modes%shape)
   end subroutine visit_modes

end module geartrain_model_fields
