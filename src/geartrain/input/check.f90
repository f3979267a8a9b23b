!> Whether a case can be run: the same for one that is read, which `--check` does no more than, and for one that a program has made.
module geartrain_input_check
   use geartrain_analyses_analysis, only: analysis_type
   use geartrain_analyses_dependencies, only: check_agreement
   use geartrain_analyses_list, only: analyses, case_type, find_analysis, results_type
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type
   use geartrain_input_variables, only: visit_case
   use geartrain_model_check, only: check_consistency
   implicit none (type, external)
   private
   public :: check_case, check_analyses

contains

   !> Checks a case however it was made; the error tells every problem, one a line.
   subroutine check_case(case, error)
      type(case_type), intent(in) :: case
      type(error_type), allocatable, intent(out) :: error
      type(case_type) :: copy
      type(checker_type) :: checker

      copy = case
      call visit_case(copy, checker)
      call check_consistency(case%train, checker)
      call check_analyses(case, .false., checker)
      call checker%problems%raise('', error)
   end subroutine check_case

   !> What single values of the analyses cannot say; the problems are added to those of `checker`.
   subroutine check_analyses(case, seeded, checker)
      type(case_type), intent(in), target :: case
      !> The response may start from a motion that is given.
      logical, intent(in) :: seeded
      class(checker_type), intent(inout) :: checker
      type(results_type), target :: none
      class(analysis_type), allocatable :: analysis
      integer :: i

      do i = 1, size(analyses)
         call find_analysis(i, case, none, analysis)
         if (analysis%asked) call analysis%check(case%train, seeded, checker)
      end do
      call check_agreement(case, checker)
   end subroutine check_analyses

end module geartrain_input_check
