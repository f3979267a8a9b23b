!> Checks whether a case can be run: a case that was read, to which `--check` is limited, or a case that a program made.
module geartrain_input_check_case
   use geartrain_analyses_analysis, only: analysis_type
   use geartrain_analyses_dependencies, only: check_agreement
   use geartrain_analyses_list, only: analyses, case_type, find_analysis, results_type
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type
   use geartrain_input_variables, only: visit_case
   use geartrain_network_check_train, only: check_consistency
   implicit none (type, external)
   private
   public :: check_case, check_analyses

contains

   !> Checks a case; the error tells every problem, one a line.
   subroutine check_case(case, error)
      !> The case, read or made by a program.
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

   !> Checks the values of the analyses against one another and against the train.
   subroutine check_analyses(case, seeded, checker)
      type(case_type), intent(in), target :: case
      !> Whether an analysis may start from a given motion.
      logical, intent(in) :: seeded
      class(checker_type), intent(inout) :: checker
      type(results_type), target :: none
      class(analysis_type), allocatable :: analysis
      integer :: i

      do i = 1, size(analyses)
         call find_analysis(i, case, none, analysis)
         if (analysis%asked) call analysis%check(case%train, seeded, checker)
      end do
      call check_agreement(case, seeded, checker)
   end subroutine check_analyses

end module geartrain_input_check_case
