!> A train without a mean torque: nothing holds the teeth of a mesh with backlash together, and it floats in its gap.
module geartrain_flow_floating
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp
   use geartrain_model_system, only: system_type
   implicit none (type, external)
   private
   public :: can_float, is_floating, note_of

   !> What is said of it, after the word on how an analysis ended.
   character(*), parameter :: note = ' (without a mean torque a train with backlash floats in its gaps, where its mean position is &
      &not unique)'
   !> By how much of the half backlash a floating mesh may seem to touch a flank: a motion settles to a tolerance.
   real(dp), parameter :: slack = 1e-6_dp

contains

   !> Whether nothing holds the teeth of some mesh together at rest.
   pure logical function can_float(system)
      type(system_type), intent(in) :: system

      can_float = any(system%half_backlash > 0 .and. .not. abs(system%static_force(system%mesh_element)) > 0)
   end function can_float

   !> Whether a motion bears on no flank of some mesh: any other mean position of that mesh in its gap does as well. A steady motion
   !> that touches one flank touches the other, too, since the forces have no mean.
   pure logical function is_floating(system, motion)
      type(system_type), intent(in) :: system
      !> Its extremes are known.
      type(motion_type), intent(in) :: motion

      is_floating = .false.
      if (.not. can_float(system)) return
      associate (b => system%half_backlash)
         is_floating = any(b > 0 .and. motion%maximum <= b + slack*b .and. motion%minimum >= -b - slack*b)
      end associate
   end function is_floating

   !> The note where it applies, else ''.
   pure function note_of(floating) result(text)
      logical, intent(in) :: floating
      character(merge(len(note), 0, floating)) :: text

      text = note
   end function note_of

end module geartrain_flow_floating
