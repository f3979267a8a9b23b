!> Phase of a transmission error: with its sign it decides whether the error and the variation of the stiffness add up or cancel,
!> and so the mesh forces and the loss of contact.
module geartrain_drawing_error_phase
   use geartrain_base_kinds, only: dp
   use geartrain_train_mesh, only: is_given, mesh_type
   implicit none (type, external)
   private
   public :: lacks_phase

   !> Amplitudes below this share of the largest one are rounding [1].
   real(dp), parameter :: rounding = 1e-12_dp

contains

   !> Whether a mesh has a transmission error beside a varying stiffness, and its description gives amplitudes (error_cos) alone.
   pure logical function lacks_phase(given, plain)
      !> The mesh as described, and its plain numbers.
      type(mesh_type), intent(in) :: given, plain

      lacks_phase = has_amplitude(given%error_cos) .and. .not. has_amplitude(given%error_sin) .and. &
                    (has_amplitude(plain%stiffness_cos) .or. has_amplitude(plain%stiffness_sin))
   end function lacks_phase

   pure logical function has_amplitude(list)
      real(dp), allocatable, intent(in) :: list(:)

      has_amplitude = .false.
      if (is_given(list)) has_amplitude = any(abs(list) > rounding*maxval(abs(list)))
   end function has_amplitude

end module geartrain_drawing_error_phase
