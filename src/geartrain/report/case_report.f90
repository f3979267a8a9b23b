!> The report of a case: what its results say, in the order in which it is read, and in the same words from the executable and from
!> Python.
module geartrain_report_case_report
   use geartrain_analyses_analysis, only: analysis_type, spoken
   use geartrain_analyses_list, only: analyses, case_type, find_analysis, results_type
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: fixed
   use geartrain_report_explain, only: speed_text
   use geartrain_network_natural_modes, only: modes_type, natural_modes
   use geartrain_analyses_branch_report, only: report_further
   use geartrain_network_network, only: state_count
   use geartrain_report_case_notes, only: say_error_phase, say_warnings
   use geartrain_readings_frequency_text, only: text_for
   use geartrain_analyses_load_sentences, only: say_load
   use geartrain_analyses_modes_table, only: put_modes
   use geartrain_report_resonances, only: find_resonances, put_resonances, resonance_type
   use geartrain_base_sheet, only: in_files, in_head, in_result, sheet_type
   use geartrain_analyses_torque_table, only: torque_table_type
   implicit none (type, external)
   private
   public :: report_text, time_text

   !> Most values of a state of a train whose modes are computed for the report where the case does not ask for them.
   integer, parameter :: most_states = 400

contains

   !> The report as text.
   subroutine report_text(case, results, verbose, text, time, path)
      !> The case and its results, which may be under way: targets. They have no intent, as for find_analysis.
      type(case_type), target :: case
      !> See `case`.
      type(results_type), target :: results
      !> Whether the report has all details.
      logical, intent(in) :: verbose
      !> The lines, each with a newline.
      character(:), allocatable, intent(out) :: text
      !> Time of the run in words, as time_text gives it; absent: not known.
      character(*), intent(in), optional :: time
      !> Results file that was written; absent or empty: none.
      character(*), intent(in), optional :: path
      class(analysis_type), allocatable :: analysis
      type(sheet_type) :: sheet
      type(torque_table_type) :: torques
      type(modes_type) :: modes
      character(:), allocatable :: words
      integer :: i

      sheet%verbose = verbose
      if (allocated(case%train%title)) then
         if (case%train%title /= '') call sheet%add(in_head, case%train%title)
      end if
      call say_load(case%train, words)
      call sheet%add(in_head, words)
      call speed_text(case%train, words)
      if (words /= '') call sheet%add(in_head, words)
      do i = 1, size(analyses)
         if (analyses(i)%name == 'modes') cycle
         call find_analysis(i, case, results, analysis)
         if (analysis%begun .and. analysis%asked) call analysis%report(case%train, sheet, torques)
      end do
      if (allocated(results%branches) .and. allocated(case%response)) &
         call report_further(results%branches, case%response, case%train, sheet, torques)
      if (.not. sheet%is_empty(in_result)) then
         call say_error_phase(case%train, sheet)
         call say_warnings(case%train, sheet)
      end if
      if (present(time)) then
         if (time /= '') call sheet%add(in_head, time)
      end if
      call find_modes(case, results, modes)
      call put_modes(modes, case%train, sheet)
      call say_resonances(case, results, modes, sheet)
      call torques%put(case%train, sheet)
      if (present(path)) then
         if (path /= '') call say_files(path, sheet)
      end if
      call sheet%put_together(text)
   end subroutine report_text

   !> The modes of the results; of a train that is not large they are computed where the case does not ask for them.
   subroutine find_modes(case, results, modes)
      type(case_type), intent(in) :: case
      type(results_type), intent(in) :: results
      type(modes_type), intent(out) :: modes
      type(error_type), allocatable :: error

      if (allocated(results%modes)) then
         modes = results%modes
      else if (state_count(case%train) <= most_states) then
         call natural_modes(case%train, modes, error)
      end if
   end subroutine find_modes

   !> Adds the resonances of the response, if it goes over frequency.
   subroutine say_resonances(case, results, modes, sheet)
      type(case_type), intent(in) :: case
      type(results_type), intent(in) :: results
      type(modes_type), intent(in) :: modes
      type(sheet_type), intent(inout) :: sheet
      type(resonance_type), allocatable :: found(:)

      if (.not. (allocated(results%response) .and. allocated(case%response))) return
      if (allocated(results%response%parameter) .or. results%response%points == 0) return
      call find_resonances(results%response, found)
      call put_resonances(found, modes, case%train, text_for(results%response, case%train, case%response%unit), sheet)
   end subroutine say_resonances

   !> Adds the results file and the next command.
   subroutine say_files(path, sheet)
      !> Path of the file.
      character(*), intent(in) :: path
      type(sheet_type), intent(inout) :: sheet

      call sheet%add(in_files, 'Written: '//path)
      call sheet%add(in_files, 'Next: geartrain-page '//path//' makes a page for a browser')
      if (.not. sheet%verbose) call sheet%add(in_files, 'Every peak, jump and range: --verbose')
   end subroutine say_files

   !> Time of a run in words: 'Time: response 0.14 s, integration 3.94 s'.
   subroutine time_text(case, results, seconds, branch_seconds, text)
      !> The case and its results, as in report_text.
      type(case_type), target :: case
      !> See `case`.
      type(results_type), target :: results
      !> Time of each analysis of the list [s], (analysis); time of the further branches [s].
      real(dp), intent(in) :: seconds(:), branch_seconds
      !> The words; '' where no analysis took time.
      character(:), allocatable, intent(out) :: text
      class(analysis_type), allocatable :: analysis
      integer :: i

      text = ''
      do i = 1, size(analyses)
         if (analyses(i)%name == 'modes' .or. .not. seconds(i) > 0) cycle
         call find_analysis(i, case, results, analysis)
         if (analysis%begun) text = text//', '//spoken(analyses(i)%name)//' '//fixed(seconds(i), 2)//' s'
      end do
      if (branch_seconds > 0) text = text//', further branches '//fixed(branch_seconds, 2)//' s'
      if (text /= '') text = 'Time: '//text(3:)
   end subroutine time_text

end module geartrain_report_case_report
