!> What an analysis is: all that the reader, the table of variables, the runner, the results file, the report and Python ask of it.
!> An analysis extends `analysis_type` in a file of its own and is registered in geartrain_analyses_list.
module geartrain_analyses_analysis
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type
   use geartrain_base_fields, only: fields_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_observer, only: observer_type
   use geartrain_base_variable, only: visitor_type
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: analysis_type, fixed, group_row_type, spoken

   !> A group of a case file: of an analysis also the group of the results file and the name by which Python runs it.
   type :: group_row_type
      character(16) :: name = ''
      character(200) :: description = ''
      !> What the observer of the analysis counts.
      character(8) :: steps = 'points'
      !> Whether the template has it as comments: it takes long, for those who ask for it.
      logical :: set_aside = .false.
   end type group_row_type

   !> An extension has a pointer to what a case asks of it and one to what was found, `settings` and `result`; the list associates
   !> each where it is there.
   type, abstract :: analysis_type
      !> Whether the case asks for it; whether there is a result, be it of work under way.
      logical :: asked = .false., begun = .false.
   contains
      procedure(visit_variables_interface), deferred :: visit_variables
      procedure :: check
      procedure :: check_alone
      procedure :: give_example
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
         class(visitor_type), intent(inout) :: v
      end subroutine visit_variables_interface

      !> Does the work as asked for, on from where the result is; nothing where that has ended.
      subroutine run_interface(self, train, error, observer, start)
         import :: analysis_type, error_type, motion_type, observer_type, train_type
         implicit none (type, external)
         class(analysis_type), intent(inout) :: self
         type(train_type), intent(in) :: train
         !> Bad input; or of status_ended_early where there is no result at all.
         type(error_type), allocatable, intent(out) :: error
         !> Told of each step under `spoken` of the name; it may read the result so far through a pointer.
         class(observer_type), intent(inout) :: observer
         !> A motion to start from, for an analysis that can.
         type(motion_type), intent(in), optional :: start
      end subroutine run_interface

      !> Whether the result is all that was asked for, and why the work ended, in words; '' where nothing was said yet.
      subroutine tell_end_interface(self, complete, ended)
         import :: analysis_type
         implicit none (type, external)
         class(analysis_type), intent(in) :: self
         logical, intent(out) :: complete
         character(:), allocatable, intent(out) :: ended
      end subroutine tell_end_interface

      !> The fields of the result, see geartrain_base_fields.
      subroutine visit_fields_interface(self, train, fields, summary)
         import :: analysis_type, fields_type, train_type
         implicit none (type, external)
         class(analysis_type), intent(inout) :: self
         type(train_type), intent(in) :: train
         class(fields_type), intent(inout) :: fields
         !> Whether what one reads off the result is computed as well.
         logical, intent(in) :: summary
      end subroutine visit_fields_interface

      !> Writes the lines that the executable prints of the result.
      subroutine report_interface(self, train, unit, seconds)
         import :: analysis_type, dp, train_type
         implicit none (type, external)
         class(analysis_type), intent(in) :: self
         type(train_type), intent(in) :: train
         !> An open unit for formatted text.
         integer, intent(in) :: unit
         !> Time taken [s].
         real(dp), intent(in) :: seconds
      end subroutine report_interface
   end interface

contains

   !> What single values of the group cannot say; the problems are added to those of `checker`. Here: nothing.
   subroutine check(self, train, seeded, checker)
      class(analysis_type), intent(in) :: self
      type(train_type), intent(in) :: train
      !> It may start from a motion that is given.
      logical, intent(in) :: seeded
      class(checker_type), intent(inout) :: checker

      associate (unused_self => self, unused_train => train, unused_seeded => seeded, unused_checker => checker)
      end associate
   end subroutine check

   !> Checks what is asked for a train that is in order; the error tells every problem, one a line.
   subroutine check_alone(self, train, error)
      class(analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      type(error_type), allocatable, intent(out) :: error
      type(checker_type) :: checker

      call self%visit_variables(checker)
      call self%check(train, .false., checker)
      call checker%problems%raise('', error)
   end subroutine check_alone

   !> Sets the variables that the template shows for the paper's train. Here: none.
   subroutine give_example(self)
      class(analysis_type), intent(inout) :: self

      associate (unused => self)
      end associate
   end subroutine give_example

   !> The name of a group as observers and messages have it, 'stability map'.
   pure function spoken(name) result(words)
      character(*), intent(in) :: name
      character(len_trim(name)) :: words
      integer :: i

      words = name
      do i = 1, len(words)
         if (words(i:i) == '_') words(i:i) = ' '
      end do
   end function spoken

   !> A number of a report with so many decimals, to be trimmed; with the zero before the point that f0.d leaves out.
   pure function padded(value, decimals) result(text)
      real(dp), intent(in) :: value
      integer, intent(in) :: decimals
      character(32) :: text
      character(8) :: form

      write (form, '(a, i0, a)') '(f24.', decimals, ')'
      write (text, form) value
      text = adjustl(text)
   end function padded

   !> A number of a report with so many decimals.
   pure function fixed(value, decimals) result(text)
      real(dp), intent(in) :: value
      integer, intent(in) :: decimals
      character(len_trim(padded(value, decimals))) :: text

      text = padded(value, decimals)
   end function fixed

end module geartrain_analyses_analysis
