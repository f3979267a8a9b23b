!> Whether a case can be run: the same for one that is read, which `--check` does no more than, and for one that a program has made.
module geartrain_input_check
   use geartrain_analyses_case, only: case_type
   use geartrain_analyses_stability_map_variables, only: check_stability_map_consistency
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: real_text
   use geartrain_continuation_variables, only: check_response_consistency
   use geartrain_flow_variables, only: check_attractors_consistency, check_integration_consistency
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
      type(case_type), intent(in) :: case
      !> The response may start from a motion that is given.
      logical, intent(in) :: seeded
      class(checker_type), intent(inout) :: checker

      if (allocated(case%response)) call check_response_consistency(case%train, case%response, seeded, checker)
      if (allocated(case%integration)) call check_integration_consistency(case%train, case%integration, checker)
      if (allocated(case%attractors)) call check_attractors_consistency(case%train, case%attractors, checker)
      if (allocated(case%stability_map)) call check_stability_map_consistency(case%train, case%stability_map, checker)
      call check_agreement(case, checker)
   end subroutine check_analyses

   !> What single groups cannot say; the problems are added to those of `checker`.
   subroutine check_agreement(case, checker)
      type(case_type), intent(in) :: case
      class(checker_type), intent(inout) :: checker
      real(dp) :: low, high

      if (.not. allocated(case%attractors)) return
      if (.not. case%attractors%follow .or. checker%problems%in_group('response')) return
      call checker%enter('attractors', 1)
      if (.not. allocated(case%response)) then
         call checker%complain('follow', '.true.', 'needs &response: its range and settings are those of the branches')
      else
         low = min(case%response%start, case%response%stop)
         high = max(case%response%start, case%response%stop)
         if (case%attractors%frequency_ratio < low .or. case%attractors%frequency_ratio > high) &
            call checker%complain('frequency', real_text(case%attractors%frequency_ratio), &
                                  'must lie in the range of &response, '// &
                                  real_text(low)//' to '//real_text(high)//', where follow = .true.')
      end if
      call checker%leave()
   end subroutine check_agreement

end module geartrain_input_check
