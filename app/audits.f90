!> Audits case files: what their branches say is checked by shooting. Writes no results.
module audits
   use arguments, only: file_name_type
   use geartrain, only: audit_branch, audit_text, audit_type, branch_type, case_type, dp, error_type, read_case, results_type, &
                        run_case, status_ended_early, status_input
   use geartrain_analyses_dependencies, only: keep_branches
   use geartrain_readings_frequency_text, only: frequency_text, frequency_text_type
   use geartrain_base_plain_text, only: escaped
   use geartrain_exact_exact_point, only: branch_with_multipliers
   use geartrain_network_long_period, only: refuse_long_period
   use progress, only: begin_progress, progress_type
   use terminal, only: complain, say
   implicit none (type, external)
   private
   public :: audit_cases

   !> Points of each branch, and what draws them.
   integer, parameter :: points = 20, random_seed = 0

contains

   !> Audits the cases, one thread a case where there are several; one alone has all threads to itself. `status` is the largest of
   !> their exit statuses.
   subroutine audit_cases(files, status)
      type(file_name_type), intent(in) :: files(:)
      integer, intent(out) :: status
      type(case_type) :: cases(size(files))
      type(error_type), allocatable :: error
      integer :: statuses(size(files)), i

      statuses = 0
      do i = 1, size(files)
         call read_case(files(i)%name, cases(i), error)
         if (.not. allocated(error) .and. .not. allocated(cases(i)%response)) then
            allocate (error)
            error%message = escaped(files(i)%name)//': error: nothing to audit: add &response'
            error%status = status_input
         end if
         if (.not. allocated(error)) call check_audit(cases(i), files(i)%name, error)
         if (.not. allocated(error)) cycle
         call complain(error%message, lines=.true.)
         statuses(i) = error%status
      end do
      !$omp parallel do schedule(dynamic) if (size(files) > 1)
      do i = 1, size(files)
         if (statuses(i) == 0) call audit(files(i)%name, size(files) == 1, cases(i), statuses(i))
      end do
      !$omp end parallel do
      status = maxval(statuses)
   end subroutine audit_cases

   !> Makes it an error, before the branches are computed, where their audit would be refused.
   subroutine check_audit(case, name, error)
      type(case_type), intent(in) :: case
      !> Name of the case file.
      character(*), intent(in) :: name
      type(error_type), allocatable, intent(inout) :: error

      call refuse_long_period(case%train, 'audit: solves anew over whole periods', 'take '//branch_with_multipliers, &
                              case%response%stability .and. case%response%multipliers, error)
      if (allocated(error)) error%message = escaped(name)//': error: '//error%message
   end subroutine check_audit

   !> Computes the branches of a case and audits them, then tells what came of it in one piece.
   subroutine audit(name, alone, case, status)
      character(*), intent(in) :: name
      !> It is the only one: its progress is shown, and its tables need no name above them.
      logical, intent(in) :: alone
      type(case_type), intent(inout) :: case
      integer, intent(out) :: status
      type(results_type) :: results
      type(error_type), allocatable :: error
      type(progress_type) :: progress
      type(frequency_text_type) :: told
      character(:), allocatable :: lines, origin
      integer :: i

      call keep_branches(case)
      call begin_progress(progress, case, shown=alone)
      call run_case(case, '', results, error, progress)
      status = 0
      if (allocated(error)) status = error%status
      lines = ''
      if (allocated(results%response)) call audit_one(case, results%response, 'Response', progress, lines, status)
      if (allocated(results%branches)) then
         told = frequency_text(case%train, case%response%unit, 0.0_dp)
         do i = 1, size(results%branches)
            call told%of_words(results%branches(i)%origin, origin)
            call audit_one(case, results%branches(i), 'Branch '//number(i)//', period '//number(results%branches(i)%subharmonic) &
                           //': '//origin, progress, lines, status)
         end do
      end if
      !$omp critical (terminal)
      call progress%clear()
      if (.not. alone) call say(escaped(name)//':'//new_line('a'))
      call say(lines)
      if (allocated(error)) then
         if (index(error%message, ': error: ') == 0) error%message = escaped(name)//': error: '//error%message
         call complain(error%message, lines=.true.)
      end if
      !$omp end critical (terminal)
   end subroutine audit

   !> Adds the table of a branch to `lines`.
   subroutine audit_one(case, branch, title, progress, lines, status)
      type(case_type), intent(in) :: case
      type(branch_type), intent(in) :: branch
      character(*), intent(in) :: title
      type(progress_type), intent(inout) :: progress
      character(:), allocatable, intent(inout) :: lines
      integer, intent(inout) :: status
      type(audit_type) :: found
      type(error_type), allocatable :: error
      character(:), allocatable :: table

      if (branch%points == 0) return
      associate (rows => progress%forecast%audit_rows)
         rows = min(points, branch%points)
         if (allocated(branch%special_points)) rows = rows + size(branch%special_points)
      end associate
      call audit_branch(case%train, branch, points, random_seed, found, error, progress)
      lines = lines//title//new_line('a')
      if (allocated(error)) then
         lines = lines//error%message//new_line('a')
         status = max(status, error%status)
      else
         call audit_text(found, case%train, case%response%unit, table)
         lines = lines//table//new_line('a')
         if (.not. found%ok) status = max(status, status_ended_early)
      end if
   end subroutine audit_one

   function number(i) result(text)
      integer, intent(in) :: i
      character(:), allocatable :: text
      character(12) :: buffer

      write (buffer, '(i0)') i
      text = trim(buffer)
   end function number

end module audits
