!> The edges of separation and back collision of all branches of a case, located before they are reported or written.
module geartrain_run_edges
   use geartrain_analyses_case, only: case_type
   use geartrain_base_observer, only: observer_type
   use geartrain_continuation_contact_edges, only: locate_contact_edges
   use geartrain_continuation_variables, only: settings_for
   use geartrain_run_results, only: results_type
   implicit none (type, external)
   private
   public :: locate_edges

contains

   subroutine locate_edges(case, results, observer)
      type(case_type), intent(in) :: case
      type(results_type), intent(inout), target :: results
      !> Once it has answered no, what is left is interpolated.
      class(observer_type), intent(inout), optional :: observer
      integer :: i

      if (.not. (allocated(case%response) .and. allocated(results%response))) return
      call locate_contact_edges(case%train, case%response, results%response, observer)
      if (.not. allocated(results%branches)) return
      do i = 1, size(results%branches)
         associate (branch => results%branches(i))
            call locate_contact_edges(case%train, settings_for(case%response, branch%subharmonic), branch, observer)
         end associate
      end do
   end subroutine locate_edges

end module geartrain_run_edges
