!> The program's place among its surroundings: standard output that may be lost, and signals.
!>
!> What is told is put together first and handed over in one piece, so that nobody reading any more, or a full disk behind it, is an
!> exit status and not the end of cases that are still at work.
module terminal
   use, intrinsic :: iso_c_binding, only: c_char, c_funloc, c_int, c_intptr_t, c_null_char, c_ptrdiff_t, c_size_t
   use geartrain_base_plain_text, only: escaped, escaped_lines
   implicit none (type, external)
   private
   public :: complain, leave_at_once, output_lost, say, stand_firm, tell_of_interrupts

   !> Some text for standard output could not be handed over.
   logical :: lost = .false.

   !> As Linux and macOS number them on x86 and ARM; and what C calls SIG_DFL and SIG_IGN.
   integer(c_int), parameter :: sigint = 2, sigpipe = 13, sigxfsz = 25
   integer(c_intptr_t), parameter :: sig_dfl = 0, sig_ign = 1

   character(*), parameter :: on_interrupt_told = new_line('a')//'geartrain: interrupted: FILE.h5.partial, where a checkpoint was &
      &written, holds what there is; --resume goes on with it'//new_line('a')

   interface
      integer(c_intptr_t) function c_signal(number, handler) bind(c, name='signal')
         import :: c_int, c_intptr_t
         implicit none (type, external)
         integer(c_int), value :: number
         integer(c_intptr_t), value :: handler
      end function c_signal

      integer(c_int) function c_raise(number) bind(c, name='raise')
         import :: c_int
         implicit none (type, external)
         integer(c_int), value :: number
      end function c_raise

      !> How many bytes were written, -1 for a failure (ssize_t is as wide as ptrdiff_t).
      integer(c_ptrdiff_t) function c_write(descriptor, bytes, count) bind(c, name='write')
         import :: c_char, c_int, c_ptrdiff_t, c_size_t
         implicit none (type, external)
         integer(c_int), value :: descriptor
         character(kind=c_char), intent(in) :: bytes(*)
         integer(c_size_t), value :: count
      end function c_write

      integer(c_int) function c_dup(descriptor) bind(c, name='dup')
         import :: c_int
         implicit none (type, external)
         integer(c_int), value :: descriptor
      end function c_dup

      integer(c_int) function c_close(descriptor) bind(c, name='close')
         import :: c_int
         implicit none (type, external)
         integer(c_int), value :: descriptor
      end function c_close

      !> The flags say for reading.
      integer(c_int) function c_open(path, flags) bind(c, name='open')
         import :: c_char, c_int
         implicit none (type, external)
         character(kind=c_char), intent(in) :: path(*)
         integer(c_int), value :: flags
      end function c_open

      !> Without what is done at the end of a program.
      subroutine c_exit(status) bind(c, name='_exit')
         import :: c_int
         implicit none (type, external)
         integer(c_int), value :: status
      end subroutine c_exit
   end interface

contains

   !> To be called first of all.
   subroutine stand_firm()
      integer(c_intptr_t) :: before
      integer(c_int) :: descriptor, copy

      ! A standard stream that is closed must not become that of the next file to be opened.
      do descriptor = 0, 2
         copy = c_dup(descriptor)
         if (copy < 0) copy = c_open('/dev/null'//c_null_char, 0_c_int)
         if (copy > 2) copy = c_close(copy)
      end do
      ! Beyond a limit on the size of files (ulimit -f) writing then fails, as on a full disk, rather than ends the program; so does
      ! writing to a pipe that nobody reads.
      before = c_signal(sigxfsz, sig_ign)
      before = c_signal(sigpipe, sig_ign)
   end subroutine stand_firm

   !> Writes lines to standard output at once, escaped: texts of results may contain anything.
   subroutine say(text)
      character(*), intent(in) :: text

      if (.not. written(1_c_int, escaped_lines(text))) lost = .true.
   end subroutine say

   !> Writes a line to standard error, if there is one, escaped: names of files may contain anything.
   subroutine complain(text, lines)
      character(*), intent(in) :: text
      !> Whether the text has several lines; absent: .false.
      logical, intent(in), optional :: lines
      logical :: several, ignored

      several = .false.
      if (present(lines)) several = lines
      if (several) then
         ignored = written(2_c_int, escaped_lines(text)//new_line('a'))
      else
         ignored = written(2_c_int, escaped(text)//new_line('a'))
      end if
   end subroutine complain

   logical function written(descriptor, text)
      integer(c_int), intent(in) :: descriptor
      character(*), intent(in) :: text
      integer(c_ptrdiff_t) :: n
      integer :: done

      done = 0
      written = .true.
      do while (done < len(text) .and. written)
         n = c_write(descriptor, text(done + 1:), int(len(text) - done, c_size_t))
         written = n > 0
         if (written) done = done + int(n)
      end do
   end function written

   !> Whether standard output did not take everything.
   logical function output_lost()

      output_lost = lost
   end function output_lost

   !> From here on Ctrl-C, unless it is ignored as in a job of the background, ends the program with a word on what there is.
   subroutine tell_of_interrupts()
      integer(c_intptr_t) :: before

      before = c_signal(sigint, transfer(c_funloc(on_interrupt), before))
      if (before == sig_ign) before = c_signal(sigint, sig_ign)
   end subroutine tell_of_interrupts

   !> Ends the program by the signal itself: a shell's loop over cases then ends as well. Nothing here but what a handler may call.
   subroutine on_interrupt(number) bind(c)
      integer(c_int), value :: number
      integer(c_ptrdiff_t) :: ignored
      integer(c_intptr_t) :: before
      integer(c_int) :: status

      ignored = c_write(2_c_int, on_interrupt_told, len(on_interrupt_told, c_size_t))
      before = c_signal(number, sig_dfl)
      status = c_raise(number)
   end subroutine on_interrupt

   !> Ends the program without the parting of its libraries.
   subroutine leave_at_once(status)
      integer, intent(in) :: status

      call c_exit(int(status, c_int))
   end subroutine leave_at_once

end module terminal
