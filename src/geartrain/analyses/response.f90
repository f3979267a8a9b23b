!> The analysis &response: the branch of periodic motions over frequency, which geartrain_analyses_response_branch traces.
module geartrain_analyses_response
   use geartrain_analyses_analysis, only: analysis_type, group_row_type
   use geartrain_base_words, only: words_type
   use geartrain_readings_frequency_text, only: frequency_text_type, text_for
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type
   use geartrain_base_fields, only: fields_type, listing, reading
   use geartrain_base_observer, only: observer_type
   use geartrain_base_variable, only: visitor_type
   use geartrain_trace_branch, only: branch_type, response_settings_type
   use geartrain_trace_branch_fields, only: visit_branch
   use geartrain_analyses_response_branch, only: response
   use geartrain_readings_summary_fields, only: visit_summary
   use geartrain_trace_response_variables, only: check_response_consistency, visit_response
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_network_network, only: state_count
   use geartrain_train_train, only: train_type
   use geartrain_analyses_branch_report, only: report_branch
   use geartrain_base_sheet, only: sheet_type
   use geartrain_analyses_torque_table, only: torque_table_type
   implicit none (type, external)
   private
   public :: response_analysis_type, response_row, visit_whole_branch

   type(group_row_type), parameter :: response_row = group_row_type('response', &
      'Asks for the branch of periodic motions over frequency, by harmonic balance; by shooting for a train with friction_torque.')

   type, extends(analysis_type) :: response_analysis_type
      type(response_settings_type), pointer :: settings => null()
      type(branch_type), pointer :: result => null()
   contains
      procedure :: visit_variables
      procedure :: check
      procedure :: run
      procedure :: tell_end
      procedure :: visit_fields
      procedure :: report
   end type response_analysis_type

contains

   subroutine visit_variables(self, v)
      class(response_analysis_type), intent(inout) :: self
      class(visitor_type), intent(inout) :: v

      call visit_response(self%settings, v)
   end subroutine visit_variables

   subroutine check(self, train, seeded, checker)
      class(response_analysis_type), intent(in) :: self
      type(train_type), intent(in) :: train
      logical, intent(in) :: seeded
      class(checker_type), intent(inout) :: checker

      call check_response_consistency(train, self%settings, seeded, checker)
   end subroutine check

   subroutine run(self, train, error, observer, start)
      class(response_analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      type(error_type), allocatable, intent(out) :: error
      class(observer_type), intent(inout) :: observer
      type(motion_type), intent(in), optional :: start
      type(frequency_text_type) :: told
      character(:), allocatable :: ended
      logical :: keep_going

      associate (branch => self%result)
         if (allocated(branch%ended) .and. .not. allocated(branch%trace)) return
         ! Checks before a run let pass what only a response with a given motion may ask for.
         call response(train, self%settings, branch, error, start, observer, checked=present(start))
         if (allocated(branch%ended)) then
            told = text_for(branch, train, self%settings%unit)
            call told%of_words(branch%ended, ended)
            branch%ended = words_type(ended)
         end if
         if (allocated(error) .or. branch%cancelled .or. branch%points == 0 .or. train%interrupt%raised()) return
         ! The time after the last step of the trace counts as time of the response.
         keep_going = .true.
         call observer%on_step('response', branch%points, branch%frequency_ratio(branch%points), keep_going)
      end associate
   end subroutine run

   subroutine tell_end(self, early)
      class(response_analysis_type), intent(in) :: self
      type(words_type), allocatable, intent(out) :: early

      if (.not. self%result%complete) early = self%result%ended
   end subroutine tell_end

   subroutine visit_fields(self, train, fields, summary)
      class(response_analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      class(fields_type), intent(inout) :: fields
      logical, intent(in) :: summary

      call visit_whole_branch(self%result, '/response', train, fields, summary)
   end subroutine visit_fields

   !> Visits the fields of a branch and of its figures.
   subroutine visit_whole_branch(branch, home, train, fields, summary)
      !> The branch; set by reading.
      type(branch_type), intent(inout) :: branch
      !> Path of the group.
      character(*), intent(in) :: home
      !> The train of the branch.
      type(train_type), intent(in) :: train
      class(fields_type), intent(inout) :: fields
      !> Whether the figures (peaks, jumps, ...) are computed and visited as well.
      logical, intent(in) :: summary
      type(train_type) :: plain

      call visit_branch(branch, home, fields)
      if (fields%way == reading) then
         call fields%check(branch%states <= state_count(train), home)
         call plain_train(train, plain)
         branch%half_backlash = plain%meshes%half_backlash/plain%characteristic_length
      else if (summary .and. (branch%points > 0 .or. fields%way == listing)) then
         call visit_summary(branch, home, fields)
      end if
   end subroutine visit_whole_branch

   subroutine report(self, train, sheet, torques)
      class(response_analysis_type), intent(in) :: self
      type(train_type), intent(in) :: train
      type(sheet_type), intent(inout) :: sheet
      type(torque_table_type), intent(inout) :: torques

      call report_branch(self%result, self%settings, train, sheet, torques)
   end subroutine report

end module geartrain_analyses_response
