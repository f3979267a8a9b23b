!> Errors as values: a message and an exit status.
module geartrain_base_error
   use geartrain_base_plain_text, only: escaped, escaped_lines
   use geartrain_base_words, only: operator(//), place_type, words_type
   implicit none (type, external)
   private
   public :: error_type, fatal, in_a_line, status_input, status_ended_early, status_file, status_memory, words_of

   !> Exit statuses of the executable: bad input, an analysis that ended early, a failure of the file system.
   integer, parameter :: status_input = 2, status_ended_early = 3, status_file = 4
   !> No memory: a MemoryError in Python, for the executable as a failure of the file system.
   integer, parameter :: status_memory = 5

   type :: error_type
      integer :: status = status_input
      !> One problem a line, with its place, value, expectation and cure.
      character(:), allocatable :: message
      !> The frequencies that it states.
      type(place_type), allocatable :: places(:)
   end type error_type

   interface fatal
      module procedure fatal_text
      module procedure fatal_words
   end interface fatal

contains

   !> Allocates `error`, or adds a line to an allocated one, so that all problems are told at once. The message is escaped here:
   !> names of files and texts read from files may contain anything.
   subroutine fatal_text(error, message, status, lines)
      type(error_type), allocatable, intent(inout) :: error
      !> A line of text; with `lines` the message of another error.
      character(*), intent(in) :: message
      !> Exit status of a new error: status_input (where absent), status_ended_early, status_file or
      !> status_memory.
      integer, intent(in), optional :: status
      !> Whether the message has several lines, whose newlines stay; absent: .false.
      logical, intent(in), optional :: lines
      character(:), allocatable :: text
      logical :: several

      several = .false.
      if (present(lines)) several = lines
      if (several) then
         text = escaped_lines(message)
      else
         text = escaped(message)
      end if
      if (allocated(error)) then
         error%message = error%message//new_line('a')//text
      else
         allocate (error)
         allocate (error%places(0))
         error%message = text
         if (present(status)) error%status = status
      end if
   end subroutine fatal_text

   !> `fatal` of a message that states frequencies.
   subroutine fatal_words(error, message, status, lines)
      type(error_type), allocatable, intent(inout) :: error
      type(words_type), intent(in) :: message
      integer, intent(in), optional :: status
      logical, intent(in), optional :: lines
      type(words_type) :: whole
      integer :: before

      call fatal_text(error, message%text, status, lines)
      before = len(error%message) - len(message%text)
      ! Not where characters were escaped before the places.
      if (before < 0) return
      if (error%message(before + 1:) /= message%text) return
      whole = error%message(:before)//message
      error%places = [error%places, whole%places]
   end subroutine fatal_words

   !> Message of an error with the frequencies that it states.
   pure type(words_type) function words_of(error)
      type(error_type), intent(in) :: error

      words_of%text = error%message
      words_of%places = error%places
   end function words_of

   !> The further lines of a message in words, with blanks at the end: ' (and 2 more)', or blank.
   pure character(24) function more_lines(message)
      character(*), intent(in) :: message
      character(12) :: number
      integer :: i, n

      more_lines = ''
      n = count([(message(i:i) == new_line('a'), i=1, len(message))])
      write (number, '(i0)') n
      if (n > 0) more_lines = ' (and '//trim(number)//' more)'
   end function more_lines

   !> Message of an error as part of a sentence: the first of its lines, and how many there are beside it.
   pure function in_a_line(message) result(line)
      !> The message, one problem a line.
      character(*), intent(in) :: message
      character(index(message//new_line('a'), new_line('a')) - 1 + len_trim(more_lines(message))) :: line

      line = message(:index(message//new_line('a'), new_line('a')) - 1)//more_lines(message)
   end function in_a_line

end module geartrain_base_error
