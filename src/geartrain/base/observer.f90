!> Progress of long work, and the way to stop it; the library itself prints nothing.
module geartrain_base_observer
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: observer_type

   !> Extend this type by an `on_step` that is called for every point, and by an `on_trouble` that shows failures on the way.
   type, abstract :: observer_type
   contains
      procedure(on_step_interface), deferred :: on_step
      procedure :: on_trouble
   end type observer_type

   abstract interface
      !> Called after each point of an analysis.
      subroutine on_step_interface(self, analysis, done, frequency_ratio, keep_going)
         import :: observer_type, dp
         implicit none (type, external)
         class(observer_type), intent(inout) :: self
         !> Name of the analysis: 'response', 'branch' (a further branch), 'integration', 'attractors', 'stability map',
         !> 'random starts' (of basins), 'basins', 'run up', 'refinement', 'audit', or, of one motion, 'settling', or 'settling by
         !> time' (and its window).
         character(*), intent(in) :: analysis
         !> Points, starts, rows of the map or periods of the fundamental done so far; of 'settling by time' cycles of the
         !> slowest mesh.
         integer, intent(in) :: done
         !> Lambda [1] of the latest point; in a stability map the parameter of the latest row.
         real(dp), intent(in) :: frequency_ratio
         !> .true. on entry; set it to .false. to end the analysis, whose points so far are kept.
         logical, intent(inout) :: keep_going
      end subroutine on_step_interface
   end interface

contains

   !> Called when something failed that does not end the work, as the writing of a checkpoint. Does nothing unless it is overridden.
   subroutine on_trouble(self, message)
      class(observer_type), intent(inout) :: self
      !> What failed and why.
      character(*), intent(in) :: message
   end subroutine on_trouble

end module geartrain_base_observer
