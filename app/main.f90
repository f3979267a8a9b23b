!> The executable: arguments in, exit status out.
program main
   use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
   use arguments, only: arguments_type, help_text, read_arguments
   use geartrain, only: case_type, error_type, read_case, results_type, run_case, status_ended_early, status_input, &
      template_text, version
   use geartrain_case_text, only: reference_text
   use progress, only: begin_progress, progress_type
   use report, only: report_attractors, report_branches, report_integration, report_modes, report_response
   implicit none (type, external)
   type(arguments_type) :: asked
   type(case_type) :: case
   type(error_type), allocatable :: error
   integer :: status

   status = 0
   call read_arguments(asked)
   if (asked%wrong /= '') then
      write (error_unit, '(3a)') 'geartrain: error: ', asked%wrong, '; geartrain --help tells the usage'
      call leave(status_input)
   end if
   select case (asked%action)
   case ('help')
      write (output_unit, '(a)') help_text
   case ('version')
      write (output_unit, '(2a)') 'geartrain ', version
   case ('template')
      write (output_unit, '(a)', advance='no') template_text()
   case ('reference')
      write (output_unit, '(a)', advance='no') reference_text()
   case default
      call read_case(asked%case_file, case, error)
      if (allocated(error)) then
         write (error_unit, '(a)') error%message
         status = error%status
      else if (asked%action == 'check') then
         write (output_unit, '(a, 2(a, i0), a)') asked%case_file, ': no problems: ', size(case%train%shafts), ' shafts, ', &
            size(case%train%meshes), ' meshes'
      else
         call run(case, status)
      end if
   end select
   call leave(status)

contains

   !> Runs the case and tells what came of it.
   subroutine run(case, status)
      type(case_type), intent(in) :: case
      integer, intent(out) :: status
      type(results_type) :: results
      type(progress_type) :: progress
      character(:), allocatable :: path, resume
      logical :: exists

      path = output_path(case)
      if (path == asked%case_file .or. index(path//' ', '.nml ') > 0) then
         write (error_unit, '(2a)') path, ': error: the results would overwrite a case: name another file with --output'
         status = status_input
         return
      end if
      resume = ''
      if (asked%resume) then
         inquire (file=path//'.partial', exist=exists)
         if (exists) resume = path//'.partial'
         if (.not. exists) write (output_unit, '(3a)') 'Nothing to resume: there is no ', path, '.partial; the run begins anew'
      end if
      call begin_progress(progress)
      call run_case(case, path, results, error, progress, resume)
      call progress%clear()
      status = 0
      if (allocated(results%modes)) call report_modes(results%modes)
      if (allocated(results%response)) call report_response(results%response, progress%response_seconds)
      if (allocated(results%integration)) call report_integration(results%integration, progress%integration_seconds)
      if (allocated(results%attractors)) call report_attractors(results%attractors, progress%attractors_seconds)
      if (allocated(results%branches)) call report_branches(results%branches, progress%branch_seconds)
      if (.not. (case%modes .or. allocated(case%response) .or. allocated(case%integration) .or. allocated(case%attractors))) &
         write (output_unit, '(a)') 'Nothing to compute: the case has no &modes, &response, &integration or &attractors'
      if (allocated(error)) status = error%status
      if (status == 0 .or. status == status_ended_early) write (output_unit, '(2a)') 'Written: ', path
      flush (output_unit)
      if (.not. allocated(error)) return
      if (index(error%message, ': error: ') == 0) error%message = 'geartrain: error: '//error%message
      write (error_unit, '(a)') error%message
   end subroutine run

   !> --output, else &output, else the name of the case with .h5, in the working directory.
   function output_path(case) result(path)
      type(case_type), intent(in) :: case
      character(:), allocatable :: path

      path = asked%output_file
      if (path == '' .and. allocated(case%output_file)) path = case%output_file
      if (path /= '') return
      path = asked%case_file(index(asked%case_file, '/', back=.true.) + 1:)
      if (len(path) > 4) then
         if (path(len(path) - 3:) == '.nml') path = path(:len(path) - 4)
      end if
      path = path//'.h5'
   end function output_path

   !> Ends the program with the exit status.
   subroutine leave(status)
      integer, intent(in) :: status

      flush (output_unit)
      if (status /= 0) stop status, quiet=.true.
   end subroutine leave

end program main
