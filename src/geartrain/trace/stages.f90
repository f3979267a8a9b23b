!> Stages of a coupling: the regions of its law beside gap and flanks, and how near a motion comes to one of them.
module geartrain_trace_stages
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: depth_of_stage, no_stage, rest_of, stage_kind, stage_of, stages_of

   !> In place of the number of a stage: none.
   integer, parameter :: no_stage = -huge(1)
   character(*), parameter :: begins = 'stage ', ends = ' reached'

contains

   !> Stages that a vibration may reach: all but that of rest, the gap, and the flanks where the gap ends.
   pure function stages_of(system, mesh) result(stages)
      type(system_type), intent(in) :: system
      !> Number of the mesh.
      integer, intent(in) :: mesh
      integer, allocatable :: stages(:)
      integer :: s, rest

      stages = [integer ::]
      rest = rest_of(system, mesh)
      associate (law => system%law(mesh))
         do s = law%lowest, law%highest
            if (s == rest .or. s == 0) cycle
            if (law%lowest < 0 .and. any(wall_to(s, rest) == [-1, 0])) cycle
            stages = [stages, s]
         end do
      end associate
   end function stages_of

   !> Region of rest.
   pure integer function rest_of(system, mesh)
      type(system_type), intent(in) :: system
      !> Number of the mesh.
      integer, intent(in) :: mesh

      associate (law => system%law(mesh))
         rest_of = law%region_at(law%rest(system%static_force(system%mesh_element(mesh))))
      end associate
   end function rest_of

   !> Number of the wall that is passed last from the region of rest to a region.
   pure integer function wall_to(stage, rest)
      integer, intent(in) :: stage, rest

      wall_to = merge(stage - 1, stage, stage > rest)
   end function wall_to

   !> Least distance of a motion from a stage over characteristic length [1]; negative: the stage is reached.
   pure real(dp) function depth_of_stage(system, mesh, stage, smallest, largest) result(depth)
      type(system_type), intent(in) :: system
      !> Number of the mesh; number of the stage.
      integer, intent(in) :: mesh, stage
      !> Extremes of the displacement over characteristic length [1].
      real(dp), intent(in) :: smallest, largest
      integer :: rest

      rest = rest_of(system, mesh)
      associate (wall => system%law(mesh)%wall(wall_to(stage, rest)))
         depth = merge(wall - largest, smallest - wall, stage > rest)
      end associate
   end function depth_of_stage

   !> Kind of the onset at a stage, 'stage 2 reached'.
   pure function stage_kind(stage) result(kind)
      !> Number of the stage.
      integer, intent(in) :: stage
      character(24) :: kind

      kind = begins//integer_text(stage)//ends
   end function stage_kind

   !> Number of the stage of a kind of onset; `no_stage` where it is of another kind.
   pure integer function stage_of(kind) result(stage)
      !> The kind.
      character(*), intent(in) :: kind
      integer :: last, status

      stage = no_stage
      last = index(kind, ends) - 1
      if (index(kind, begins) /= 1 .or. last <= len(begins)) return
      read (kind(len(begins) + 1:last), *, iostat=status) stage
      if (status /= 0) stage = no_stage
   end function stage_of

end module geartrain_trace_stages
