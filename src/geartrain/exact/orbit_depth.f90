!> How far a mesh is from a contact over the period of an orbit.
module geartrain_exact_orbit_depth
   use geartrain_base_kinds, only: dp
   use geartrain_flow_sections, only: sections_type
   use geartrain_mesh_law_law, only: depth_below
   implicit none (type, external)
   private
   public :: depth_of

contains

   !> Least distance of the displacement of a mesh from separation, or from a contact of its back flanks, over characteristic length
   !> [1]; see depth_below.
   real(dp) function depth_of(flight, frequency_ratio, states, mesh, half_backlash, back)
      !> Flights of the train.
      type(sections_type), intent(inout) :: flight
      !> Lambda [1]; states at the beginnings of the sections [1], (state, section).
      real(dp), intent(in) :: frequency_ratio, states(:, :)
      !> Number of the mesh.
      integer, intent(in) :: mesh
      !> Half of its backlash over characteristic length [1].
      real(dp), intent(in) :: half_backlash
      !> Contact of the back flanks; else separation.
      logical, intent(in) :: back
      real(dp) :: smallest, largest

      call flight%extremes(frequency_ratio, states, mesh, smallest, largest)
      depth_of = depth_below(smallest, largest, half_backlash, back)
   end function depth_of

end module geartrain_exact_orbit_depth
