!> The group /attractors of a results file: the motions that random starts settled on.
module geartrain_results_attractors
   use geartrain_motion_attractors_settings, only: attractors_type
   use geartrain_results_integration, only: write_motions
   use geartrain_results_store, only: store_type
   implicit none (type, external)
   private
   public :: write_attractors

   character(*), parameter :: home = '/attractors'

contains

   !> Writes the motions found so far; `ended` may still be unknown.
   subroutine write_attractors(store, found)
      type(store_type), intent(inout) :: store
      type(attractors_type), intent(in) :: found
      integer :: n

      n = 0
      if (allocated(found%motions)) n = size(found%motions)
      call store%group(home)
      call store%attribute(home, 'description', 'steady motions that random starts settled on at one frequency')
      if (allocated(found%ended)) then
         call store%attribute(home, 'ended', found%ended)
      else
         call store%attribute(home, 'ended', 'not yet: these are the motions so far')
      end if
      call store%attribute(home, 'complete', merge(1, 0, found%complete))
      call store%attribute(home, 'starts', found%starts)
      call store%attribute(home, 'random_seed', found%random_seed)
      call store%attribute(home, 'unsettled', found%unsettled)
      call store%axis(home//'/motion', n, 'motion, largest share first')
      if (n == 0) return
      call write_motions(store, home, 'motion', found%motions)
      call store%put(home//'/share', (found%motions%share), ['motion'], '1', 'share of the starts that settled on the motion')
   end subroutine write_attractors

end module geartrain_results_attractors
