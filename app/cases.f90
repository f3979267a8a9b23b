!> Runs case files, several of them side by side, and tells what came of each.
module cases
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_null_char, c_ptr
   use arguments, only: file_name_type
   use geartrain, only: case_type, error_type, explanation_text, read_case, results_type, run_case, &
      status_ended_early, status_file, status_input, warnings_text
   use geartrain_analyses_analysis, only: analysis_type
   use geartrain_analyses_list, only: analyses, find_analysis
   use geartrain_base_numbers, only: counted
   use geartrain_base_plain_text, only: escaped
   use geartrain_input_new_case, only: new_case_text
   use geartrain_report_case_report, only: report_text, time_text
   use geartrain_results_seal, only: check_replaceable
   use progress, only: begin_progress, progress_type
   use terminal, only: complain, say, tell_of_interrupts
   implicit none (type, external)
   private
   public :: check_cases, explain_cases, new_case, run_cases

   !> A case file that is to be run.
   type :: job_type
      type(case_type) :: case
      !> Where the results go.
      character(:), allocatable :: path
      !> 0: it can be run.
      integer :: status = 0
   end type job_type

   interface
      !> `resolved` has room for PATH_MAX bytes; NULL where there is no such file.
      type(c_ptr) function c_realpath(path, resolved) bind(c, name='realpath')
         import :: c_char, c_ptr
         implicit none (type, external)
         character(kind=c_char), intent(in) :: path(*)
         character(kind=c_char), intent(inout) :: resolved(*)
      end function c_realpath
   end interface

contains

   !> Writes a case to begin with into a file that is not there yet; `status` is the exit status.
   subroutine new_case(file, status)
      character(*), intent(in) :: file
      integer, intent(out) :: status
      character(:), allocatable :: text
      character(256) :: why
      logical :: exists
      integer :: unit, failed

      call new_case_text(file, text)
      status = status_file
      open (newunit=unit, file=file, access='stream', form='unformatted', status='new', action='write', iostat=failed, iomsg=why)
      if (failed /= 0) then
         inquire (file=file, exist=exists)
         if (exists) why = 'it is there already, and --new overwrites nothing: give another name'
         if (exists) status = status_input
         call complain('geartrain: error: '//file//' cannot be written: '//trim(why))
         return
      end if
      write (unit, iostat=failed, iomsg=why) text
      if (failed == 0) close (unit, iostat=failed, iomsg=why)
      if (failed /= 0) then
         call complain('geartrain: error: '//file//' cannot be written: '//trim(why))
         close (unit, status='delete', iostat=failed)
         return
      end if
      status = 0
      call say('Written: '//escaped(file)//'; geartrain '//escaped(file)//' runs it'//new_line('a'))
   end subroutine new_case

   !> Says what is wrong with the cases; `status` is the largest of their exit statuses.
   subroutine check_cases(files, status)
      type(file_name_type), intent(in) :: files(:)
      integer, intent(out) :: status
      type(case_type) :: case
      type(error_type), allocatable :: error
      character(:), allocatable :: warnings
      integer :: i

      status = 0
      do i = 1, size(files)
         call read_case(files(i)%name, case, error)
         if (allocated(error)) then
            call complain(error%message, lines=.true.)
            status = max(status, error%status)
         else
            call warnings_text(case%train, warnings)
            call say(escaped(files(i)%name)//trim(merge(': no problems            ', ': no errors, but warnings', warnings == '')) &
                     //': '//counted(size(case%train%shafts), 'shaft', 'shafts')//', '// &
                     counted(size(case%train%meshes), 'mesh', 'meshes')//new_line('a'))
            call warn(files(i)%name, case)
         end if
      end do
   end subroutine check_cases

   !> Tells every number of the trains of the cases; `status` is the largest of their exit statuses.
   subroutine explain_cases(files, status)
      type(file_name_type), intent(in) :: files(:)
      integer, intent(out) :: status
      type(case_type) :: case
      type(error_type), allocatable :: error
      character(:), allocatable :: text
      integer :: i

      status = 0
      do i = 1, size(files)
         call read_case(files(i)%name, case, error)
         if (allocated(error)) then
            call complain(error%message, lines=.true.)
            status = max(status, error%status)
            cycle
         end if
         if (size(files) > 1) call say(escaped(files(i)%name)//new_line('a'))
         call explanation_text(case%train, text)
         call say(text)
      end do
   end subroutine explain_cases

   !> Tells where formulas of the drawing are used outside their range.
   subroutine warn(file, case)
      character(*), intent(in) :: file
      type(case_type), intent(in) :: case
      character(:), allocatable :: text
      integer :: first, next

      call warnings_text(case%train, text)
      first = 1
      do while (first <= len(text))
         next = index(text(first:), new_line('a'))
         call complain(file//': warning: '//text(first:first + next - 2))
         first = first + next
      end do
   end subroutine warn

   !> Runs the cases, one thread a case where there are several; one alone has all threads to itself. A case that fails does not
   !> keep the others from running; `status` is the largest of their exit statuses.
   subroutine run_cases(files, output_file, resume, force, verbose, status)
      type(file_name_type), intent(in) :: files(:)
      !> As given by --output; ''.
      character(*), intent(in) :: output_file
      !> Go on from the checkpoint of a run that was killed; of one case only.
      logical, intent(in) :: resume
      !> Remove checkpoints of runs that were killed; reports with all details.
      logical, intent(in) :: force, verbose
      integer, intent(out) :: status
      type(job_type) :: jobs(size(files))
      integer :: i

      call find_repeated(files, status)
      if (status /= 0) return
      do i = 1, size(files)
         call prepare(files, i, output_file, jobs)
      end do
      call tell_of_interrupts()
      !$omp parallel do schedule(dynamic) if (size(files) > 1)
      do i = 1, size(files)
         if (jobs(i)%status == 0) call run(files(i)%name, size(files) == 1, resume, force, verbose, jobs(i))
      end do
      !$omp end parallel do
      status = maxval(jobs%status)
   end subroutine run_cases

   !> `status` is not 0 where a case is given twice: nothing is run then, since a slip is more likely than a wish.
   subroutine find_repeated(files, status)
      type(file_name_type), intent(in) :: files(:)
      integer, intent(out) :: status
      integer :: i, k

      status = 0
      do i = 2, size(files)
         do k = 1, i - 1
            if (place(files(k)%name) /= place(files(i)%name)) cycle
            call complain(files(i)%name//': error: the case is given twice: give it once; nothing was run')
            status = status_input
            exit
         end do
      end do
   end subroutine find_repeated

   !> Reads case i and finds the place of its results, which must not be that of a case or of other results.
   subroutine prepare(files, i, output_file, jobs)
      type(file_name_type), intent(in) :: files(:)
      integer, intent(in) :: i
      character(*), intent(in) :: output_file
      type(job_type), intent(inout) :: jobs(:)
      type(error_type), allocatable :: error
      character(:), allocatable :: path, names
      integer :: k

      call read_case(files(i)%name, jobs(i)%case, error)
      if (allocated(error)) then
         call complain(error%message, lines=.true.)
         jobs(i)%status = error%status
         return
      end if
      if (.not. asks_for_something(jobs(i)%case)) then
         ! A file of nothing must not take the place of results.
         names = ''
         do k = 1, size(analyses)
            if (k > 1) names = names//trim(merge(' or', ',  ', k == size(analyses)))//' '
            names = names//'&'//trim(analyses(k)%name)
         end do
         call complain(files(i)%name//': error: nothing to compute, nothing is written: add '//names)
         jobs(i)%status = status_input
         return
      end if
      call warn(files(i)%name, jobs(i)%case)
      path = output_path(files(i)%name, output_file, jobs(i)%case)
      jobs(i)%path = path
      if (any([(is_case(path, files(k)%name), k=1, size(files))]) .or. index(path//' ', '.nml ') > 0) then
         call complain(path//': error: the results would overwrite a case: name another file with --output')
         jobs(i)%status = status_input
      else if (any([(is_case(path//'.partial', files(k)%name), k=1, size(files))])) then
         call complain(path//': error: '//path//'.partial, where the results are kept meanwhile, is a case: name another file with &
                       &--output')
         jobs(i)%status = status_input
      end if
      do k = 1, i - 1
         if (jobs(k)%status /= 0 .or. jobs(i)%status /= 0) cycle
         if (place(jobs(k)%path) /= place(path) .and. place(jobs(k)%path) /= place(path//'.partial') .and. &
             place(jobs(k)%path//'.partial') /= place(path)) cycle
         call complain(files(i)%name//': error: its results would overwrite those of '//files(k)%name//', '//path// &
                       ': name another file in &output')
         jobs(i)%status = status_input
      end do
   end subroutine prepare

   !> Whether a file put in place at `path` would take that of a case, be it a link or the file that the link leads to.
   logical function is_case(path, case_file)
      character(*), intent(in) :: path, case_file

      is_case = place(path) == place(case_file) .or. place(path) == resolved(case_file)
   end function is_case

   !> The place that a path names, whichever way its folder is written; a link at its end is a file in its own right.
   function place(path)
      character(*), intent(in) :: path
      character(:), allocatable :: place
      integer :: slash

      slash = index(path, '/', back=.true.)
      place = resolved(path(:slash)//'.')//'/'//path(slash + 1:)
   end function place

   !> The path without links, '.' and '..'; as it is where there is no such file.
   function resolved(path)
      character(*), intent(in) :: path
      character(:), allocatable :: resolved
      character(kind=c_char) :: buffer(4097)
      integer :: i

      resolved = path
      buffer = c_null_char
      if (.not. c_associated(c_realpath(path//c_null_char, buffer))) return
      resolved = ''
      do i = 1, findloc(buffer, c_null_char, dim=1) - 1
         resolved = resolved//buffer(i)
      end do
   end function resolved

   !> Runs a case, then tells what came of it in one piece.
   subroutine run(name, alone, resume, force, verbose, job)
      character(*), intent(in) :: name
      !> It is the only one: its progress is shown, and its results need no name above them.
      logical, intent(in) :: alone
      !> As of run_cases.
      logical, intent(in) :: resume, force, verbose
      type(job_type), intent(inout), target :: job
      type(results_type), target :: results
      type(error_type), allocatable :: error
      type(progress_type) :: progress
      character(:), allocatable :: checkpoint
      logical :: exists

      checkpoint = ''
      if (force) then
         call remove_checkpoint(job%path//'.partial', error)
         if (allocated(error)) then
            job%status = error%status
            call complain(error%message, lines=.true.)
            return
         end if
      end if
      if (resume) then
         inquire (file=job%path//'.partial', exist=exists)
         if (exists) checkpoint = job%path//'.partial'
         if (.not. exists) call say('Nothing to resume: there is no '//escaped(job%path)//'.partial; the run begins anew'// &
                                    new_line('a'))
      end if
      call begin_progress(progress, job%case, shown=alone, results=results, resumed=checkpoint /= '')
      call run_case(job%case, job%path, results, error, progress, checkpoint)
      if (allocated(error)) job%status = error%status
      !$omp critical (terminal)
      call progress%clear()
      if (.not. alone) call say(escaped(name)//':'//new_line('a'))
      call report(job, results, progress, verbose)
      if (allocated(error)) then
         if (index(error%message, ': error: ') == 0) then
            if (alone) error%message = 'geartrain: error: '//error%message
            if (.not. alone) error%message = escaped(name)//': error: '//error%message
         end if
         call complain(error%message, lines=.true.)
      end if
      !$omp end critical (terminal)
   end subroutine run

   !> Removes the checkpoint of a run that was killed; an error where the file is none, or cannot be removed.
   subroutine remove_checkpoint(path, error)
      character(*), intent(in) :: path
      type(error_type), allocatable, intent(out) :: error
      integer :: unit, failed

      call check_replaceable(path, error)
      if (allocated(error)) return
      open (newunit=unit, file=path, status='old', iostat=failed)
      if (failed == 0) close (unit, status='delete', iostat=failed)
   end subroutine remove_checkpoint

   subroutine report(job, results, progress, verbose)
      type(job_type), intent(in), target :: job
      type(results_type), intent(in), target :: results
      type(progress_type), intent(in) :: progress
      !> Whether the report has all details.
      logical, intent(in) :: verbose
      character(:), allocatable :: text, time, path

      if (job%status /= 0 .and. .not. has_results(job%case, results)) return
      path = ''
      if (job%status == 0 .or. job%status == status_ended_early) path = escaped(job%path)
      call time_text(job%case, results, progress%seconds, progress%branch_seconds, time)
      call report_text(job%case, results, verbose, text, time, path)
      call say(text)
   end subroutine report

   !> Whether any analysis has begun.
   logical function has_results(case, results)
      type(case_type), intent(in), target :: case
      type(results_type), intent(in), target :: results
      class(analysis_type), allocatable :: analysis
      integer :: i

      has_results = .false.
      do i = 1, size(analyses)
         call find_analysis(i, case, results, analysis)
         has_results = has_results .or. analysis%begun
      end do
   end function has_results

   logical function asks_for_something(case)
      type(case_type), intent(in), target :: case
      type(results_type), target :: none
      class(analysis_type), allocatable :: analysis
      integer :: i

      asks_for_something = .false.
      do i = 1, size(analyses)
         call find_analysis(i, case, none, analysis)
         asks_for_something = asks_for_something .or. analysis%asked
      end do
   end function asks_for_something

   !> --output, else &output, else the name of the case with .h5, in the working directory.
   function output_path(case_file, output_file, case) result(path)
      character(*), intent(in) :: case_file, output_file
      type(case_type), intent(in) :: case
      character(:), allocatable :: path

      path = output_file
      if (path == '' .and. allocated(case%output_file)) path = case%output_file
      if (path /= '') return
      path = case_file(index(case_file, '/', back=.true.) + 1:)
      if (len(path) > 4) then
         if (path(len(path) - 3:) == '.nml') path = path(:len(path) - 4)
      end if
      path = path//'.h5'
   end function output_path

end module cases
