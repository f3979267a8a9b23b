!> A position in the text of a case file, and steps through the text.
module geartrain_input_cursor
   use geartrain_base_plain_text, only: is_utf_8
   implicit none (type, external)
   private
   public :: cursor_type, lower, shortened, blanks, digits, letters, newline

   character(*), parameter :: newline = achar(10), blanks = ' '//achar(9)//achar(13)
   character(*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ', digits = '0123456789'
   character(*), parameter :: in_names = letters//digits//'_'
   !> Characters that end a value without quotes.
   character(*), parameter :: delimiters = blanks//newline//',/!&='//"'"//'"'

   !> A position in a text.
   type :: cursor_type
      !> The text, with a newline at its end.
      character(:), allocatable :: text
      !> Position in bytes, line, and column in characters, each from 1.
      integer :: at = 1, line = 1, column = 1
   contains
      procedure :: ended
      procedure :: peek
      procedure :: shown
      procedure :: advance
      procedure :: skip_space
      procedure :: skip_to_group
      procedure :: take_name
      procedure :: take_bare
      procedure :: take_quoted
   end type cursor_type

contains

   !> Moves past blanks, newlines and comments.
   subroutine skip_space(self)
      class(cursor_type), intent(inout) :: self

      do while (.not. self%ended())
         if (self%peek() == '!') then
            do while (self%peek() /= newline)
               call self%advance()
            end do
         end if
         if (scan(self%peek(), blanks//newline) == 0) exit
         call self%advance()
      end do
   end subroutine skip_space

   !> Moves to the next & that is the first character of its line.
   subroutine skip_to_group(self)
      class(cursor_type), intent(inout) :: self

      do while (.not. self%ended())
         do while (self%peek() /= newline)
            call self%advance()
         end do
         call self%skip_space()
         if (self%peek() == '&') exit
      end do
   end subroutine skip_to_group

   !> Takes a name and moves past it.
   subroutine take_name(self, name)
      class(cursor_type), intent(inout) :: self
      !> Letters, digits and underscores from the cursor on; '': there are none.
      character(:), allocatable, intent(out) :: name
      integer :: length

      length = verify(self%text(self%at:), in_names) - 1
      name = self%text(self%at:self%at + length - 1)
      call self%advance(length)
   end subroutine take_name

   !> Takes a value without quotes and moves past it.
   subroutine take_bare(self, text)
      class(cursor_type), intent(inout) :: self
      !> The characters up to the next of `delimiters`.
      character(:), allocatable, intent(out) :: text
      integer :: length

      length = scan(self%text(self%at:), delimiters) - 1
      text = self%text(self%at:self%at + length - 1)
      call self%advance(length)
   end subroutine take_bare

   !> Takes a value in quotes and moves past it.
   subroutine take_quoted(self, text, status)
      class(cursor_type), intent(inout) :: self
      !> The value, without its quotes; a doubled quote inside it is one quote.
      character(:), allocatable, intent(out) :: text
      !> 0: well; else the line ends before the closing quote.
      integer, intent(out) :: status
      character(1) :: quote
      integer :: length, first

      quote = self%peek()
      text = ''
      status = 0
      call self%advance()
      do
         first = self%at
         length = scan(self%text(first:), quote//newline) - 1
         call self%advance(length)
         text = text//self%text(first:first + length - 1)
         if (self%peek() == newline) then
            status = 1
            return
         end if
         call self%advance()
         if (self%peek() /= quote) return
         text = text//quote
         call self%advance()
      end do
   end subroutine take_quoted

   !> Whether the cursor is behind the last character.
   pure logical function ended(self)
      class(cursor_type), intent(in) :: self

      ended = self%at > len(self%text)
   end function ended

   !> The character at the cursor; a newline behind the last character.
   pure character(1) function peek(self)
      class(cursor_type), intent(in) :: self

      peek = newline
      if (self%at <= len(self%text)) peek = self%text(self%at:self%at)
   end function peek

   !> The character at the cursor as a message shows it, with blanks at the end: in quotes, with its code point if it is not ASCII
   !> (it may look like a blank); a byte that is not UTF-8 as a number.
   pure function shown(self) result(text)
      class(cursor_type), intent(in) :: self
      character(64) :: text
      character(8) :: code
      integer :: first, last, point, i

      text = '"'//self%peek()//'"'
      first = iachar(self%peek())
      if (first < 128) return
      last = min(len(self%text), self%at + count(first >= [192, 224, 240]))
      if (is_utf_8(self%text(self%at:last))) then
         point = iand(first, 63/2**(last - self%at))
         do i = self%at + 1, last
            point = 64*point + iand(iachar(self%text(i:i)), 63)
         end do
         write (code, '(a, z0.4)') 'U+', point
         text = '"'//self%text(self%at:last)//'" ('//trim(code)//')'
      else
         write (code, '(z2)') first
         text = 'the byte '//trim(code)//' (hexadecimal), which is not UTF-8'
      end if
   end function shown

   !> Moves on. Columns count characters, as editors do, not the bytes of UTF-8.
   subroutine advance(self, steps)
      class(cursor_type), intent(inout) :: self
      !> Bytes to move, default 1.
      integer, intent(in), optional :: steps
      integer :: i, last

      last = 1
      if (present(steps)) last = steps
      do i = 1, last
         if (self%ended()) return
         if (self%peek() == newline) then
            self%line = self%line + 1
            self%column = 1
         else if (self%at == len(self%text)) then
            continue
         else if (iand(iachar(self%text(self%at + 1:self%at + 1)), 192) /= 128) then
            self%column = self%column + 1
         end if
         self%at = self%at + 1
      end do
   end subroutine advance

   !> A text with its letters A to Z in lower case.
   pure function lower(text) result(lowered)
      !> Any bytes.
      character(*), intent(in) :: text
      character(len(text)) :: lowered
      integer :: i

      lowered = text
      do i = 1, len(text)
         if (text(i:i) >= 'A' .and. text(i:i) <= 'Z') lowered(i:i) = achar(iachar(text(i:i)) + 32)
      end do
   end function lower

   !> Length of `shortened`.
   pure integer function shortened_length(text) result(length)
      character(*), intent(in) :: text
      integer :: last

      length = len(text)
      if (length <= 60) return
      ! The end must not split a character of UTF-8.
      last = 57
      do while (last > 53 .and. iand(iachar(text(last + 1:last + 1)), 192) == 128)
         last = last - 1
      end do
      length = last + 3
   end function shortened_length

   !> A word as a message shows it: whole, or its beginning and '...' if it is longer than 60 bytes.
   pure function shortened(text) result(start)
      !> The word.
      character(*), intent(in) :: text
      character(shortened_length(text)) :: start

      start = text
      if (len(text) > len(start)) start(len(start) - 2:) = '...'
   end function shortened

end module geartrain_input_cursor
