!> Ends work in time, while there is still memory to keep and to write its results.
module geartrain_run_room
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_analyses_list, only: case_type, results_type
   use geartrain_base_memory, only: has_room
   use geartrain_run_results, only: results_bytes
   implicit none (type, external)
   private
   public :: room_type

   !> Memory that must be there for each byte of the results: their arrays may double, and to be written they are copied as fields,
   !> as an HDF5 file in memory and as its bytes, with a field on its way and a copy of a map under way.
   integer(int64), parameter :: times = 6

   !> Fewest steps between two looks: results of so few are small beside the memory that is kept free.
   integer, parameter :: fewest = 32

   !> Looks now and then whether there is memory for the results.
   type :: room_type
      !> There is no memory for more results; the work was ended for this reason.
      logical :: lacks = .false.
      !> Name of the analysis under way.
      character(24), private :: analysis = ''
      !> Steps of the analysis so far; number of the step after which the results are measured next.
      integer, private :: steps = 0, next = fewest
   contains
      procedure :: look
   end type room_type

contains

   !> Ends the work where there is no memory for results that grow on. The results are measured each time that the number of steps
   !> has grown by a quarter, and by `fewest`, so that measuring takes no time and large results cannot double unseen.
   subroutine look(self, analysis, case, results, keep_going)
      class(room_type), intent(inout) :: self
      !> Name of the analysis, as an observer gets it.
      character(*), intent(in) :: analysis
      type(case_type), intent(in) :: case
      !> The results so far; unchanged.
      type(results_type), intent(inout) :: results
      !> Set to .false. where the work must end.
      logical, intent(inout) :: keep_going

      ! The periods of a motion that settles add nothing to the results.
      if (analysis == 'settling' .or. analysis == 'settling by time') return
      if (analysis /= self%analysis) then
         self%analysis = analysis
         self%steps = 0
         self%next = fewest
      end if
      self%steps = self%steps + 1
      if (self%steps >= self%next) then
         self%next = self%steps + max(fewest, self%steps/4)
         self%lacks = .not. has_room(times*results_bytes(results, case))
      end if
      if (self%lacks) keep_going = .false.
   end subroutine look

end module geartrain_run_room
