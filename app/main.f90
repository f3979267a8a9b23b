!> The executable: arguments in, exit status out.
program main
   use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
   use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
   use arguments, only: arguments_type, help_text, read_arguments
   use cases, only: check_cases, run_cases
   use geartrain, only: status_input, template_text, version
   use geartrain_case_text, only: reference_text
   implicit none (type, external)
   !> As Linux and macOS number it on x86 and ARM; and what C calls SIG_IGN.
   integer(c_int), parameter :: sigxfsz = 25
   integer(c_intptr_t), parameter :: sig_ign = 1
   integer(c_intptr_t) :: default
   type(arguments_type) :: asked
   integer :: status

   interface
      integer(c_intptr_t) function c_signal(number, handler) bind(c, name='signal')
         import :: c_int, c_intptr_t
         implicit none (type, external)
         integer(c_int), value :: number
         integer(c_intptr_t), value :: handler
      end function c_signal
   end interface

   ! Beyond a limit on the size of files (ulimit -f) writing then fails, as on a full disk, rather than ends the program.
   default = c_signal(sigxfsz, sig_ign)
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
   case ('check')
      call check_cases(asked%case_files, status)
   case default
      call run_cases(asked%case_files, asked%output_file, asked%resume, status)
   end select
   call leave(status)

contains

   !> Ends the program with the exit status.
   subroutine leave(status)
      integer, intent(in) :: status

      flush (output_unit)
      if (status /= 0) stop status, quiet=.true.
   end subroutine leave

end program main
