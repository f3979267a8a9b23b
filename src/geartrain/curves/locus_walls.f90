!> Motions of the curve of a special point and the walls of the gaps: how near they come to one, and whether they reach any.
module geartrain_curves_locus_walls
   use geartrain_base_kinds, only: dp
   use geartrain_exact_augmented_point, only: augmented_point_type
   use geartrain_exact_augmented_system, only: augmented_system_type
   implicit none (type, external)
   private
   public :: find_grazing_mesh, floats, from_wall, touches

   !> Distance of an extreme of the displacement from a wall that counts as touching, over the size of the motion.
   real(dp), parameter :: touching = 1e-3_dp
   !> Mean force of a mesh over the largest one at which it bears none but for rounding.
   real(dp), parameter :: unloaded = 1e-9_dp

contains

   !> Whether a mesh just touches a wall of its gap, at an extreme of its displacement, or comes to one with hardly any speed.
   logical function touches(augmented, point)
      !> The system.
      type(augmented_system_type), intent(inout) :: augmented
      !> A special point.
      type(augmented_point_type), intent(in) :: point
      real(dp) :: nearest, size

      call look(augmented, point, nearest, size)
      touches = nearest < touching .or. &
                point%slowest_event < sqrt(touching)*size*augmented%metric%units%frequency_ratio
   end function touches

   !> Least distance of an extreme of the displacement of any mesh from a wall of its gap, over the size of its motion.
   real(dp) function from_wall(augmented, point)
      !> The system.
      type(augmented_system_type), intent(inout) :: augmented
      !> A special point.
      type(augmented_point_type), intent(in) :: point
      real(dp) :: size

      call look(augmented, point, from_wall, size)
   end function from_wall

   !> Finds the mesh of which an extreme is nearest to a wall of its gap.
   subroutine find_grazing_mesh(augmented, point, mesh)
      !> The system.
      type(augmented_system_type), intent(inout) :: augmented
      !> A special point.
      type(augmented_point_type), intent(in) :: point
      !> Number of the mesh.
      integer, intent(out) :: mesh
      real(dp) :: nearest, size

      call look(augmented, point, nearest, size, mesh)
   end subroutine find_grazing_mesh

   !> Distance from the walls. The size of a motion is half the backlash where it is larger than the gap, else half its own range: a
   !> motion beside one flank knows no gap.
   subroutine look(augmented, point, nearest, size, mesh)
      type(augmented_system_type), intent(inout) :: augmented
      type(augmented_point_type), intent(in) :: point
      !> Least distance of an extreme of any mesh from a wall, over the size of its motion; largest such size.
      real(dp), intent(out) :: nearest, size
      !> Mesh of the least distance.
      integer, intent(out), optional :: mesh
      real(dp) :: smallest, largest, distance, range
      integer :: j

      ! The latest solution may have failed far away.
      call augmented%stand_at(point%parameter, .true.)
      nearest = huge(1.0_dp)
      if (present(mesh)) mesh = 1
      size = 0
      do j = 1, augmented%system%meshes
         associate (b => augmented%system%half_backlash(j))
            if (.not. b > 0) cycle
            call augmented%probe%extremes(point%frequency_ratio, point%states, j, smallest, largest, b, distance)
            range = max((largest - smallest)/2, tiny(1.0_dp))
            ! A smooth minimum, as places are extrapolated to by this distance.
            range = range*b/(range + b)
            if (present(mesh) .and. distance/range < nearest) mesh = j
            nearest = min(nearest, distance/range)
            size = max(size, range)
         end associate
      end do
   end subroutine look

   !> Whether a mesh that bears no mean force stays within its gap: its mean position is arbitrary, and a multiplier is 1 for any
   !> such motion.
   logical function floats(augmented, point, load)
      !> The system, with the train of the point.
      type(augmented_system_type), intent(inout) :: augmented
      !> A special point.
      type(augmented_point_type), intent(in) :: point
      !> Largest mean force of a mesh over its stiffness at the beginning of the curve [1].
      real(dp), intent(in) :: load
      real(dp) :: smallest, largest
      integer :: j

      floats = .false.
      associate (system => augmented%system)
         do j = 1, system%meshes
            if (.not. system%half_backlash(j) > 0) cycle
            if (abs(system%static_force(system%mesh_element(j))) > unloaded*load) cycle
            call augmented%probe%extremes(point%frequency_ratio, point%states, j, smallest, largest)
            floats = largest <= system%half_backlash(j) .and. smallest >= -system%half_backlash(j)
            if (floats) return
         end do
      end associate
   end function floats

end module geartrain_curves_locus_walls
