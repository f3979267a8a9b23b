!> The abstract type of all analyses: what the reader, the table of variables, the runner, the results file, the report and Python
!> ask of an analysis. An analysis extends `analysis_type` in a file of its own and is registered in geartrain_analyses_list.
module geartrain_analyses_analysis
   use geartrain_analyses_torque_table, only: torque_table_type
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type
   use geartrain_base_fields, only: fields_type
   use geartrain_base_observer, only: observer_type
   use geartrain_base_sheet, only: sheet_type
   use geartrain_base_variable, only: visitor_type
   use geartrain_base_words, only: words_type
   use geartrain_network_check_train, only: check_train
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: analysis_type, group_row_type, spoken

   !> A group of a case file: of an analysis also the group of the results file and the name by which Python runs it.
   type :: group_row_type
      !> Name of the group, without &.
      character(24) :: name = ''
      !> Meaning, as the template and the reference page print it.
      character(200) :: description = ''
      !> What the observer of the analysis counts.
      character(8) :: steps = 'points'
      !> Whether the template has the group as comments, because the analysis takes long or writes much.
      logical :: set_aside = .false.
   end type group_row_type

   !> An extension has the pointers `settings`, to the group of a case, and `result`; find_analysis in geartrain_analyses_list
   !> associates both with components of a case and of results.
   type, abstract :: analysis_type
      !> Whether the case asks for the analysis; whether there is a result, complete or of work under way.
      logical :: asked = .false., begun = .false.
   contains
      procedure(visit_variables_interface), deferred :: visit_variables
      procedure :: check
      procedure :: check_alone
      procedure(run_interface), deferred :: run
      procedure(tell_end_interface), deferred :: tell_end
      procedure(visit_fields_interface), deferred :: visit_fields
      procedure(report_interface), deferred :: report
   end type analysis_type

   abstract interface
      !> Leads a visitor over the variables of the group.
      subroutine visit_variables_interface(self, v)
         import :: analysis_type, visitor_type
         implicit none (type, external)
         class(analysis_type), intent(inout) :: self
         !> The visitor.
         class(visitor_type), intent(inout) :: v
      end subroutine visit_variables_interface

      !> Does the work. A result under way is taken up; nothing is done where the result has ended.
      subroutine run_interface(self, train, error, observer, start)
         import :: analysis_type, error_type, motion_type, observer_type, train_type
         implicit none (type, external)
         class(analysis_type), intent(inout) :: self
         !> The train as described.
         type(train_type), intent(in) :: train
         !> Bad input, or no result at all (status_ended_early).
         type(error_type), allocatable, intent(out) :: error
         !> Told of each step under the name that `spoken` gives; may read the result so far through a pointer, and end the work.
         class(observer_type), intent(inout) :: observer
         !> A motion to start from; ignored by an analysis that does not start from a motion.
         type(motion_type), intent(in), optional :: start
      end subroutine run_interface

      !> Tells why the work ended early.
      subroutine tell_end_interface(self, early)
         import :: analysis_type, words_type
         implicit none (type, external)
         class(analysis_type), intent(in) :: self
         !> Why; not allocated: the result is all that was asked for.
         type(words_type), allocatable, intent(out) :: early
      end subroutine tell_end_interface

      !> Visits the fields of the result, see geartrain_base_fields.
      subroutine visit_fields_interface(self, train, fields, summary)
         import :: analysis_type, fields_type, train_type
         implicit none (type, external)
         class(analysis_type), intent(inout) :: self
         !> The train that the result is of.
         type(train_type), intent(in) :: train
         class(fields_type), intent(inout) :: fields
         !> Whether the figures that follow from the result (of a branch: peaks, jumps, ...) are visited as well.
         logical, intent(in) :: summary
      end subroutine visit_fields_interface

      !> Adds the sections on the result to a report.
      subroutine report_interface(self, train, sheet, torques)
         import :: analysis_type, sheet_type, torque_table_type, train_type
         implicit none (type, external)
         class(analysis_type), intent(in) :: self
         !> The train of the case.
         type(train_type), intent(in) :: train
         type(sheet_type), intent(inout) :: sheet
         !> Torques of the shafts over all motions so far.
         type(torque_table_type), intent(inout) :: torques
      end subroutine report_interface
   end interface

contains

   !> Checks the values of the group against one another and against the train. Default: nothing to check.
   subroutine check(self, train, seeded, checker)
      class(analysis_type), intent(in) :: self
      type(train_type), intent(in) :: train
      !> Whether the analysis may start from a given motion.
      logical, intent(in) :: seeded
      !> Collects the problems; nothing is checked if it has a problem of this group.
      class(checker_type), intent(inout) :: checker
   end subroutine check

   !> Checks the train, then the values of the group; the error tells every problem, one a line.
   subroutine check_alone(self, train, error)
      class(analysis_type), intent(inout) :: self
      !> The train as described.
      type(train_type), intent(in) :: train
      type(error_type), allocatable, intent(out) :: error
      type(checker_type) :: checker

      call check_train(train, error)
      if (allocated(error)) return
      call self%visit_variables(checker)
      call self%check(train, .false., checker)
      call checker%problems%raise('', error)
   end subroutine check_alone

   !> Name of an analysis for observers and messages, 'stability map'.
   pure function spoken(name) result(words)
      !> Name of the group, 'stability_map'.
      character(*), intent(in) :: name
      character(len_trim(name)) :: words
      integer :: i

      words = name
      do i = 1, len(words)
         if (words(i:i) == '_') words(i:i) = ' '
      end do
   end function spoken

end module geartrain_analyses_analysis
