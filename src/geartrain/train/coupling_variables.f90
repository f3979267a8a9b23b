!> The table of input variables of couplings.
module geartrain_train_coupling_variables
   use geartrain_base_kinds, only: dp
   use geartrain_base_variable, only: row => variable_type, visitor_type
   use geartrain_train_mesh, only: mesh_type
   implicit none (type, external)
   private
   public :: visit_coupling

   real(dp), parameter :: zero = 0, one = 1

contains

   !> Visits the variables of a group &coupling.
   subroutine visit_coupling(coupling, index, v)
      !> The coupling; the visitor may change it.
      type(mesh_type), intent(inout) :: coupling
      !> Number of the coupling in the train.
      integer, intent(in) :: index
      !> Reads, checks, sets or lists each variable.
      class(visitor_type), intent(inout) :: v
      logical :: given, by_ratio
      character(:), allocatable :: word

      call v%enter('coupling', index)
      call v%on_names(row('between', '', 'names of the two bodies'), &
                      coupling%between)
      word = trim(coupling%name)
      call v%on_text(row('name', '', 'label in results; none: by the names of the bodies'), word)
      coupling%name = word
      given = abs(coupling%torsional_stiffness) > 0
      call v%on_real(row('stiffness', 'N m/rad', 'torsional stiffness, in place of angle and torque', above=zero), &
                     coupling%torsional_stiffness, given)
      call v%on_real(row('half_play', 'rad', 'half of the play; 0: none', least=zero), &
                     coupling%half_play)
      call v%on_list(row('angle', 'rad', 'in place of stiffness and half_play: twists at the corners of a polygon, whose ends &
                         &go on'), coupling%angle)
      call v%on_list(row('torque', 'N m', 'torques at the corners, ascending; 0 within a play'), &
                     coupling%torque)
      by_ratio = .not. (coupling%damping_given .or. coupling%loss_factor > 0)
      call v%on_real(row('damping_ratio', '', 'c/(2 sqrt(k m)) as of a shaft, with the slope k beside the play on the side of &
                         &positive torques or, without play, at the torque 0', least=zero), &
                     coupling%damping_ratio, by_ratio)
      call v%on_real(row('damping', 'N m s/rad', 'damping coefficient, in place of damping_ratio', least=zero, &
                         excludes='damping_ratio'), coupling%torsional_damping, coupling%damping_given)
      given = coupling%loss_factor > 0
      call v%on_real(row('loss_factor', '', 'structural damping, in place of damping_ratio, as of a mesh', least=zero, &
                         most=2*one), coupling%loss_factor, given)
      call v%on_real(row('friction_torque', 'N m', 'dry friction, beside stiffness and damping: up to this torque the coupling &
                         &sticks', least=zero), coupling%friction_torque)
      word = trim(coupling%damping_acts)
      call v%on_text(row('damping_acts', '', 'always, or only in contact: no damping within the play', &
                         choices='always contact'), word)
      coupling%damping_acts = word
      call v%leave()
   end subroutine visit_coupling

end module geartrain_train_coupling_variables
