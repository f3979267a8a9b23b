!> Errors as values: what went wrong, in words, and the exit status that it means.
module geartrain_base_error
   implicit none (type, external)
   private
   public :: error_type, fatal, status_input, status_ended_early, status_file

   !> Exit statuses of the executable: bad input, an analysis that ended early, a failure of the file system.
   integer, parameter :: status_input = 2, status_ended_early = 3, status_file = 4

   type :: error_type
      integer :: status = status_input
      !> One message a line; each says place, value, expectation, cure.
      character(:), allocatable :: message
   end type error_type

contains

   !> Makes `error`; a second call on the same `error` adds a line, so that all problems are told at once.
   subroutine fatal(error, message, status)
      type(error_type), allocatable, intent(inout) :: error
      character(*), intent(in) :: message
      !> One of status_input (the default), status_ended_early, status_file.
      integer, intent(in), optional :: status

      if (allocated(error)) then
         error%message = error%message//new_line('a')//message
      else
         allocate (error)
         error%message = message
         if (present(status)) error%status = status
      end if
   end subroutine fatal

end module geartrain_base_error
