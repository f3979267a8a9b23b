!> Cases from REXS files, which the Python package reads.
module rexs
   use geartrain, only: status_input
   use terminal, only: complain
   implicit none (type, external)
   private
   public :: print_case

   !> What a shell says of a command that it does not find.
   integer, parameter :: not_found = 127

contains

   !> Prints the case of a REXS file by the command geartrain-rexs, or says what is missing.
   subroutine print_case(file, status)
      character(*), intent(in) :: file
      !> Exit status.
      integer, intent(out) :: status
      integer :: failed

      status = 0
      call execute_command_line('if command -v geartrain-rexs > /dev/null; then geartrain-rexs -- '//quoted(file)// &
                                '; else exit 127; fi', exitstat=status, cmdstat=failed)
      if (failed /= 0 .or. status == not_found) then
         call complain('geartrain: error: --from-rexs needs geartrain-rexs of the Python package, which is not on PATH: &
                       &install the package, or activate its environment')
         status = status_input
      end if
   end subroutine print_case

   !> A word of a shell, whatever characters it has.
   pure function quoted(word) result(text)
      character(*), intent(in) :: word
      character(:), allocatable :: text
      integer :: i

      text = "'"
      do i = 1, len(word)
         if (word(i:i) == "'") then
            text = text//"'\''"
         else
            text = text//word(i:i)
         end if
      end do
      text = text//"'"
   end function quoted

end module rexs
