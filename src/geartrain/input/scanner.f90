!> Splits the text of a case file into groups, names and values with their lines and columns, and collects problems of form.
!>
!> The form is that of a Fortran namelist: `&group`, `name = value, value`, `!` comments, quotes, repeat counts, `/`. Values are not
!> interpreted here. After a mistake the scan goes on, so that all mistakes are told at once.
module geartrain_input_scanner
   use geartrain_base_problems, only: problems_type
   use geartrain_input_cursor, only: blanks, cursor_type, digits, letters, lower, newline, shortened
   implicit none (type, external)
   private
   public :: scan_text, group_type, token_type

   !> A value as written.
   type :: token_type
      !> The value without its quotes.
      character(:), allocatable :: text
      !> Whether the value is in quotes.
      logical :: quoted = .false.
      !> Line and column of the value, from 1.
      integer :: line = 0, column = 0
   end type token_type

   !> A variable and its values.
   type :: assignment_type
      !> Name of the variable, in lower case.
      character(:), allocatable :: name
      !> Line and column of the name, from 1.
      integer :: line = 0, column = 0
      !> The values, repeat counts applied.
      type(token_type), allocatable :: values(:)
      !> Whether a problem of the assignment has been told: its values are not read.
      logical :: bad = .false.
   end type assignment_type

   !> A group of the file.
   type :: group_type
      !> Name of the group, in lower case, without &.
      character(:), allocatable :: name
      !> Number of the group among the groups of its name, from 1.
      integer :: index = 1
      !> Line and column of &, from 1.
      integer :: line = 0, column = 0
      !> The variables of the group.
      type(assignment_type), allocatable :: assignments(:)
   end type group_type

   !> Byte order mark of UTF-8, EF BB BF, which some editors put at the beginning of a file.
   character(*), parameter :: byte_order_mark = char(239)//char(187)//char(191)
   integer, parameter :: most_values = 1000, most_assignments = 100, most_groups = 10000

contains

   !> Splits the text of a case file.
   subroutine scan_text(text, groups, problems)
      !> The text.
      character(*), intent(in) :: text
      !> The groups in the order of the file.
      type(group_type), allocatable, intent(out) :: groups(:)
      !> Collects the problems.
      type(problems_type), intent(inout) :: problems
      type(cursor_type) :: cursor
      type(group_type), allocatable :: room(:)
      integer :: n

      allocate (groups(0), room(16))
      n = 0
      cursor%text = text//newline
      if (index(text, byte_order_mark) == 1) cursor%at = 4
      if (index(text, achar(0)) > 0) then
         call problems%add('this is a binary file, not a namelist')
         return
      end if
      do
         call cursor%skip_space()
         if (cursor%ended()) exit
         if (cursor%peek() == '&') then
            if (n == most_groups) then
               call problems%add('more than 10000 groups', line=cursor%line, column=cursor%column)
               exit
            end if
            if (n == size(room)) call enlarge_groups(room)
            n = n + 1
            call scan_group(cursor, room(:n), problems)
         else
            call problems%add('text outside of a group: a group begins with &name and ends with /', &
                              line=cursor%line, column=cursor%column)
            call cursor%skip_to_group()
         end if
      end do
      groups = room(:n)
   end subroutine scan_text

   !> Scans a group into the last element of `groups`.
   subroutine scan_group(cursor, groups, problems)
      type(cursor_type), intent(inout) :: cursor
      type(group_type), intent(inout) :: groups(:)
      type(problems_type), intent(inout) :: problems
      type(group_type) :: group
      type(assignment_type) :: skipped, room(most_assignments)
      character(:), allocatable :: name
      integer :: i, n

      group%line = cursor%line
      group%column = cursor%column
      call cursor%advance()
      call cursor%take_name(name)
      group%name = lower(name)
      do i = 1, size(groups) - 1
         if (groups(i)%name == group%name) group%index = group%index + 1
      end do
      n = 0
      do
         call cursor%skip_space()
         if (cursor%ended()) exit
         if (cursor%peek() == '/') exit
         if (cursor%peek() == '&') exit
         if (n == most_assignments) then
            call problems%add('more than 100 variables: is a closing / missing?', group%name, group%index, line=cursor%line, &
                              column=cursor%column)
            call cursor%skip_to_group()
            exit
         else if (scan(cursor%peek(), letters) == 1) then
            n = n + 1
            call scan_assignment(cursor, room(n), group, problems)
         else
            call problems%add('expected "name = value" or the closing /, found '//trim(cursor%shown()), group%name, &
                              group%index, line=cursor%line, column=cursor%column)
            skipped%bad = .true.
            call scan_values(cursor, skipped, group, problems)
         end if
      end do
      if (n < most_assignments) call close_group(cursor, group, problems)
      group%assignments = room(:n)
      groups(size(groups)) = group
   end subroutine scan_group

   !> Checks that the group ends with /, followed on its line by nothing but a comment or the next group.
   subroutine close_group(cursor, group, problems)
      type(cursor_type), intent(inout) :: cursor
      type(group_type), intent(in) :: group
      type(problems_type), intent(inout) :: problems

      if (cursor%peek() /= '/') then
         if (lower(cursor%text(cursor%at:min(cursor%at + 3, len(cursor%text)))) == '&end') then
            call problems%add('ends with &end: write / instead', group%name, group%index, line=cursor%line, &
                              column=cursor%column)
            call cursor%advance(4)
         else
            call problems%add('has no closing /', group%name, group%index, line=group%line, column=group%column)
         end if
         return
      end if
      call cursor%advance()
      do while (scan(cursor%peek(), blanks) == 1)
         call cursor%advance()
      end do
      if (scan(cursor%peek(), '!&'//newline) == 1) return
      call problems%add('text after the closing /: it would be ignored (text with a / in it needs quotes)', group%name, &
                        group%index, line=cursor%line, column=cursor%column)
      call cursor%skip_to_group()
   end subroutine close_group

   !> Scans name = value, value, ... up to the next name, / or &.
   subroutine scan_assignment(cursor, assignment, group, problems)
      type(cursor_type), intent(inout) :: cursor
      type(assignment_type), intent(inout) :: assignment
      type(group_type), intent(in) :: group
      type(problems_type), intent(inout) :: problems
      character(:), allocatable :: written

      assignment%line = cursor%line
      assignment%column = cursor%column
      call cursor%take_name(written)
      assignment%name = lower(written)
      call cursor%skip_space()
      if (scan(cursor%peek(), '(%') == 1) then
         call complain('"'//shortened(written)//'" with an index or component: give the whole list, '// &
                       shortened(assignment%name)//' = first, second, ...')
         do while (scan(cursor%peek(), '=/&'//newline) == 0)
            call cursor%advance()
         end do
      end if
      if (cursor%peek() == '=') then
         call cursor%advance()
      else if (.not. assignment%bad) then
         call complain('expected "=" after "'//shortened(written)//'"')
      end if
      call scan_values(cursor, assignment, group, problems)
      if (size(assignment%values) == 0 .and. .not. assignment%bad) &
         call complain(shortened(written)//' has no value: give one, or leave the variable out')

   contains

      subroutine complain(text)
         character(*), intent(in) :: text

         call problems%add(text, group%name, group%index, assignment%name, assignment%line, assignment%column)
         assignment%bad = .true.
      end subroutine complain

   end subroutine scan_assignment

   !> Scans value, value, ... up to the next name, / or &.
   subroutine scan_values(cursor, assignment, group, problems)
      type(cursor_type), intent(inout) :: cursor
      type(assignment_type), intent(inout) :: assignment
      type(group_type), intent(in) :: group
      type(problems_type), intent(inout) :: problems
      type(token_type) :: token
      type(token_type), allocatable :: room(:)
      logical :: after_value
      integer :: repeats, i, n

      allocate (room(8))
      n = 0
      after_value = .false.
      do
         call cursor%skip_space()
         if (cursor%ended() .or. scan(cursor%peek(), '/&') == 1) exit
         if (begins_assignment(cursor)) exit
         token%line = cursor%line
         token%column = cursor%column
         if (cursor%peek() == ',') then
            if (.not. after_value) call complain('an empty value before the comma')
            after_value = .false.
            call cursor%advance()
            cycle
         else if (cursor%peek() == '=') then
            call complain('a second "=": values are separated by commas')
            call cursor%advance()
            cycle
         end if
         repeats = 1
         token%quoted = scan(cursor%peek(), '''"') == 1
         if (token%quoted) then
            call cursor%take_quoted(token%text, i)
            if (i /= 0) call complain('the quote is not closed on its line')
         else
            call cursor%take_bare(token%text)
            call split_repeat(token%text, repeats)
            if (repeats < 1 .or. repeats > most_values) call complain('a repeat count must be 1 to 1000')
            if (token%text == '') call complain('an empty value')
         end if
         after_value = .true.
         if (assignment%bad) cycle
         do i = 1, repeats
            if (n == most_values) then
               call complain('more than 1000 values')
               exit
            end if
            if (n == size(room)) call enlarge_tokens(room)
            n = n + 1
            room(n) = token
         end do
      end do
      assignment%values = room(:n)

   contains

      !> Tells a problem, but only the first problem of an assignment.
      subroutine complain(text)
         character(*), intent(in) :: text

         if (.not. assignment%bad) call problems%add(shortened(assignment%name)//': '//text, group%name, group%index, &
                                                     assignment%name, token%line, token%column)
         assignment%bad = .true.
      end subroutine complain

   end subroutine scan_values

   !> Splits 3*0.0 into 0.0 and 3; a text before * that is not a whole number stays in the text.
   subroutine split_repeat(text, repeats)
      character(:), allocatable, intent(inout) :: text
      integer, intent(inout) :: repeats
      integer :: star, status

      star = index(text, '*')
      if (star < 2) return
      if (verify(text(:star - 1), digits) > 0) return
      read (text(:star - 1), *, iostat=status) repeats
      if (status /= 0) repeats = 0
      text = text(star + 1:)
   end subroutine split_repeat

   !> Whether a name is at the cursor that is followed by = (or by an index, which is refused later).
   logical function begins_assignment(cursor)
      type(cursor_type), intent(inout) :: cursor
      character(:), allocatable :: name
      integer :: at, line, column

      begins_assignment = .false.
      if (scan(cursor%peek(), letters) == 0) return
      at = cursor%at
      line = cursor%line
      column = cursor%column
      call cursor%take_name(name)
      call cursor%skip_space()
      begins_assignment = scan(cursor%peek(), '=(%') == 1
      cursor%at = at
      cursor%line = line
      cursor%column = column
   end function begins_assignment

   !> Doubles the size of a list of groups.
   subroutine enlarge_groups(room)
      type(group_type), allocatable, intent(inout) :: room(:)
      type(group_type), allocatable :: larger(:)
      integer :: i

      allocate (larger(2*size(room)))
      do i = 1, size(room)
         larger(i) = room(i)
      end do
      call move_alloc(larger, room)
   end subroutine enlarge_groups

   !> Doubles the size of a list of values.
   subroutine enlarge_tokens(room)
      type(token_type), allocatable, intent(inout) :: room(:)
      type(token_type), allocatable :: larger(:)
      integer :: i

      allocate (larger(2*size(room)))
      do i = 1, size(room)
         larger(i) = room(i)
      end do
      call move_alloc(larger, room)
   end subroutine enlarge_tokens

end module geartrain_input_scanner
