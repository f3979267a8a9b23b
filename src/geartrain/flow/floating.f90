!> Meshes with backlash and without a mean force, as all of a train without a mean torque: nothing holds the teeth together, and the
!> mesh floats in its gap.
module geartrain_flow_floating
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_rows, only: rows_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: can_float, is_floating, note_of

   !> Note that follows the words on how an analysis ended.
   character(*), parameter :: note = ' (a train with backlash in a mesh that bears no mean force floats in its gaps, where its &
      &mean position is not unique)'
   !> Largest penetration of a flank by a floating mesh over the half backlash [1]: a motion settles to a tolerance.
   real(dp), parameter :: slack = 1e-6_dp

contains

   !> Whether some mesh with backlash has no static force.
   pure logical function can_float(system)
      type(system_type), intent(in) :: system

      can_float = any(system%half_backlash > 0 .and. .not. abs(system%static_force(system%mesh_element)) > 0)
   end function can_float

   !> Whether some mesh touches no flank during a motion, and no other mesh or shaft holds its mean position in the gap: without the
   !> meshes that touch no flank the train has more rigid motions. (A steady motion that touches one flank touches the other flank
   !> too, because the forces have no mean.)
   pure logical function is_floating(system, motion)
      type(system_type), intent(in) :: system
      !> Motion with its extremes.
      type(motion_type), intent(in) :: motion
      logical :: apart(system%meshes), independent
      type(rows_type) :: rows
      integer :: n

      is_floating = .false.
      if (.not. can_float(system)) return
      associate (b => system%half_backlash, elements => system%network%elements)
         apart = b > 0 .and. motion%maximum <= b + slack*b .and. motion%minimum >= -b - slack*b
         if (.not. any(apart)) return
         call rows%setup(size(system%network%inertia), 0)
         do n = 1, size(elements)
            if (.not. elements(n)%elastic) cycle
            if (elements(n)%mesh > 0) then
               if (apart(elements(n)%mesh)) cycle
            end if
            call rows%add(elements(n)%row_type, independent)
         end do
         is_floating = count(rows%free) > size(system%network%rigid, 2)
      end associate
   end function is_floating

   !> The note on floating; '' for a motion that does not float.
   pure function note_of(floating) result(text)
      !> A motion floats, or may float.
      logical, intent(in) :: floating
      character(merge(len(note), 0, floating)) :: text

      text = note
   end function note_of

end module geartrain_flow_floating
