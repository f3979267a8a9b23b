!> The executable: arguments in, exit status out.
program main
   use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
   use arguments, only: arguments_type, read_arguments
   use audits, only: audit_cases
   use cases, only: check_cases, explain_cases, new_case, run_cases
   use geartrain, only: blas_kernels, blas_threads, status_file, status_input, template_text, version
   use geartrain_base_memory, only: can_begin
   use geartrain_input_text, only: reference_text
   use geartrain_run_reference, only: output_reference
   use options, only: completion_text, help_text
   use rexs, only: print_case
   use terminal, only: complain, leave_at_once, output_lost, say, stand_firm
   implicit none (type, external)
   type(arguments_type) :: asked
   character(:), allocatable :: text
   integer :: status, blas_threads_before

   call stand_firm()
   call blas_kernels()
   blas_threads_before = blas_threads(1)
   if (.not. can_begin()) then
      call complain('geartrain: error: there is not enough memory to begin with, 160 MB beside the program: is there a limit &
                    &(ulimit -v)? With OPENBLAS_NUM_THREADS=1 it needs less')
      call leave_at_once(status_file)
   end if
   status = 0
   call read_arguments(asked)
   if (asked%wrong /= '') then
      call complain('geartrain: error: '//asked%wrong//'; geartrain --help tells the usage')
      call leave(status_input)
   end if
   select case (asked%action)
   case ('help')
      call help_text(text)
      call say(text)
   case ('completion')
      call completion_text(asked%shell, text)
      call say(text)
   case ('new')
      call new_case(asked%case_files(1)%name, status)
   case ('from-rexs')
      call print_case(asked%case_files(1)%name, status)
   case ('version')
      call say('geartrain '//version//new_line('a'))
   case ('template')
      call template_text(text)
      call say(text)
   case ('reference')
      call reference_text(text)
      call say(text)
   case ('output-reference')
      call output_reference(text)
      call say(text)
   case ('check')
      call check_cases(asked%case_files, status)
   case ('explain')
      call explain_cases(asked%case_files, status)
   case ('audit')
      call audit_cases(asked%case_files, status)
   case default
      call run_cases(asked%case_files, asked%output_file, asked%resume, asked%force, asked%verbose, status)
   end select
   call leave(status)

contains

   !> Ends the program with the exit status.
   subroutine leave(status)
      integer, intent(in) :: status
      integer :: whole

      ! Only Python distinguishes status_memory from status_file.
      whole = min(status, status_file)
      if (output_lost()) then
         call complain('geartrain: error: standard output is lost: nobody reads it, or the disk behind it is full')
         whole = max(whole, status_file)
      end if
      flush (output_unit)
      flush (error_unit)
      ! Not to wait for further threads of OpenBLAS, which ask for ever for memory that they do not get.
      if (blas_threads_before > 1) call leave_at_once(whole)
      if (whole /= 0) stop whole, quiet=.true.
   end subroutine leave

end program main
