!> The group /modes of a results file.
module geartrain_results_modes
   use geartrain_model_modes, only: modes_type
   use geartrain_results_store, only: store_type
   implicit none (type, external)
   private
   public :: write_modes

contains

   subroutine write_modes(store, modes)
      type(store_type), intent(inout) :: store
      type(modes_type), intent(in) :: modes

      call store%group('/modes')
      call store%axis('/modes/mode', size(modes%natural_frequency), 'elastic mode, by frequency; a rigid mode is left out')
      call store%axis('/modes/element', modes%element, 'elastic element, in the order of the train')
      call store%put('/modes/natural_frequency', modes%natural_frequency, ['mode'], '1', &
                     'undamped natural frequency / characteristic_frequency, mean mesh stiffness, teeth in contact')
      call store%put('/modes/damped_frequency', modes%damped_frequency, ['mode'], '1', &
                     'imaginary part of the damped eigenvalue / characteristic_frequency; 0 = overdamped')
      call store%put('/modes/damping_ratio', modes%damping_ratio, ['mode'], '1', 'damping ratio of the mode')
      call store%put('/modes/shape', modes%shape, ['mode   ', 'element'], '1', &
                     'displacement of each element (a mesh: along the line of action; a shaft: twist times base radius), &
                     &largest 1')
   end subroutine write_modes

end module geartrain_results_modes
