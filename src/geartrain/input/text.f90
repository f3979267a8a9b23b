!> A case as text: the resolved namelist with every default, the commented template, and the reference tables.
module geartrain_input_text
   use geartrain_analyses_list, only: case_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text, real_text
   use geartrain_base_variable, only: largest, smallest, variable_type, visitor_type
   use geartrain_input_table, only: list_variables, row_type
   use geartrain_input_variables, only: groups, visit_case
   implicit none (type, external)
   private
   public :: add_cell, case_text, commented_text, reference_text

   !> The visitor that writes groups and variables as text.
   type, extends(visitor_type) :: writer_type
      !> The text so far.
      character(:), allocatable :: text
      !> Whether groups are explained where they first occur; whether the present group is explained: with unit, range and
      !> description behind each variable, and with the variables not in force as comments.
      logical :: commented = .false., explain = .false.
   contains
      procedure :: enter => begin_group
      procedure :: leave => end_group
      procedure :: on_real => write_real
      procedure :: on_integer => write_integer
      procedure :: on_logical => write_logical
      procedure :: on_text => write_text
      procedure :: on_list => write_list
      procedure :: on_names => write_names
      procedure, private :: write_line
   end type writer_type

   character(*), parameter :: newline = new_line('a')

contains

   !> Writes a case as a namelist with every default.
   subroutine case_text(case, text)
      type(case_type), intent(in) :: case
      !> The namelist; numbers have as many digits, up to 17, as needed to read back identical bits.
      character(:), allocatable, intent(out) :: text
      type(writer_type) :: writer
      type(case_type) :: copy

      copy = case
      writer%text = ''
      call visit_case(copy, writer)
      call move_alloc(writer%text, text)
   end subroutine case_text

   !> Writes a case as a namelist with every variable explained where it first occurs.
   subroutine commented_text(case, text)
      type(case_type), intent(in) :: case
      !> The namelist, with comments.
      character(:), allocatable, intent(out) :: text
      type(writer_type) :: writer
      type(case_type) :: copy

      copy = case
      writer%text = ''
      writer%commented = .true.
      call visit_case(copy, writer)
      call move_alloc(writer%text, text)
   end subroutine commented_text

   !> Writes the tables of groups and variables of docs/reference.md.
   subroutine reference_text(text)
      !> Markdown.
      character(:), allocatable, intent(out) :: text
      type(row_type), allocatable :: rows(:), of_chain(:)
      integer :: i, j

      call list_variables(rows)
      call list_variables(of_chain, chain=.true.)
      text = 'A real number that is not 0 has a magnitude from '//real_text(smallest)//' to '//real_text(largest)// &
             '; numbers of a list may be smaller.'//newline//newline//'In calls `from` and `to` are named `start` and `stop`, also &
                &at the end of a name. A case file takes both names.'//newline
      do i = 1, size(groups)
         text = text//newline//'## `&'//trim(groups(i)%name)//'`'//newline//newline//trim(groups(i)%description)//newline
         if (.not. any(rows%group == groups(i)%name)) cycle
         text = text//newline//'| Variable | Type | Default | Allowed | Meaning |'//newline// &
                '|---|---|---|---|---|'//newline
         do j = 1, size(rows)
            if (rows(j)%group == groups(i)%name) call add_row(rows(j), any(of_chain%group == rows(j)%group .and. &
               of_chain%variable%name == rows(j)%variable%name .and. of_chain%variable%required), text)
         end do
      end do
   end subroutine reference_text

   !> Adds the row of a Markdown table.
   subroutine add_row(row, chain_requires, text)
      type(row_type), intent(in) :: row
      !> Whether a chain must give the variable.
      logical, intent(in) :: chain_requires
      character(:), allocatable, intent(inout) :: text
      character(:), allocatable :: default

      default = trim(row%default)
      if (chain_requires) default = 'required in a chain'
      if (row%variable%required) default = 'required'
      text = text//'| `'//trim(row%variable%name)//'` |'
      if (row%variable%unit == '') call add_cell(row%kind, text)
      if (row%variable%unit /= '') call add_cell(trim(row%kind)//' ['//trim(row%variable%unit)//']', text)
      call add_cell(default, text)
      call add_cell(in_short(row%variable%range()), text)
      call add_cell(row%variable%description, text)
      text = text//newline
   end subroutine add_row

   !> A range '>= 1 and <= 5, or 0' as '1 to 5, or 0'; any other range as it is.
   pure function in_short(range)
      character(*), intent(in) :: range
      character(len(range)) :: in_short
      character(*), parameter :: between = ' and <= '
      integer :: at

      in_short = range
      at = index(range, between)
      if (index(range, '>= ') == 1 .and. at > 0) in_short = range(4:at - 1)//' to '//range(at + len(between):)
   end function in_short

   !> Adds a cell of a Markdown table with the bar after it.
   subroutine add_cell(words, text)
      !> Text of the cell.
      character(*), intent(in) :: words
      !> The table so far.
      character(:), allocatable, intent(inout) :: text

      if (words /= '') text = text//' '//trim(words)//' '
      text = text//'|'
   end subroutine add_cell

   subroutine begin_group(self, group, index)
      class(writer_type), intent(inout) :: self
      character(*), intent(in) :: group
      integer, intent(in) :: index
      integer :: i

      self%group = group
      self%index = index
      self%explain = self%commented .and. index == 1
      if (self%explain) then
         i = findloc(groups%name == group, .true., dim=1)
         self%text = self%text//newline//'! '//trim(groups(i)%description)//newline
      end if
      self%text = self%text//'&'//group//newline
   end subroutine begin_group

   subroutine end_group(self)
      class(writer_type), intent(inout) :: self

      self%text = self%text//'/'//newline
      self%group = ''
   end subroutine end_group

   subroutine write_real(self, variable, value, in_force)
      class(writer_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      real(dp), intent(inout) :: value
      logical, intent(inout), optional :: in_force

      if (present(in_force)) then
         call self%write_line(variable, real_text(value), in_force)
      else
         call self%write_line(variable, real_text(value), .true.)
      end if
   end subroutine write_real

   subroutine write_integer(self, variable, value)
      class(writer_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      integer, intent(inout) :: value

      call self%write_line(variable, integer_text(value), .true.)
   end subroutine write_integer

   subroutine write_logical(self, variable, value)
      class(writer_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      logical, intent(inout) :: value

      call self%write_line(variable, trim(merge('.true. ', '.false.', value)), .true.)
   end subroutine write_logical

   subroutine write_text(self, variable, value)
      class(writer_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      character(:), allocatable, intent(inout) :: value
      character(:), allocatable :: word

      word = "''"
      if (allocated(value)) call quote(value, word)
      call self%write_line(variable, word, .true.)
   end subroutine write_text

   !> Puts a text in quotes; a quote inside the text is doubled.
   pure subroutine quote(value, quoted)
      character(*), intent(in) :: value
      character(:), allocatable, intent(out) :: quoted
      integer :: i

      quoted = "'"
      do i = 1, len(value)
         quoted = quoted//value(i:i)
         if (value(i:i) == "'") quoted = quoted//"'"
      end do
      quoted = quoted//"'"
   end subroutine quote

   subroutine write_names(self, variable, value)
      class(writer_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      character(*), intent(inout) :: value(:)
      character(:), allocatable :: joined, word
      integer :: i

      joined = ''
      do i = 1, size(value)
         call quote(trim(value(i)), word)
         if (i > 1) joined = joined//', '
         joined = joined//word
      end do
      call self%write_line(variable, joined, any(value /= ''))
   end subroutine write_names

   !> An empty list is left out, because a namelist cannot write it; in an explained group it is a comment with the value 0.0.
   subroutine write_list(self, variable, value)
      class(writer_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      real(dp), allocatable, intent(inout) :: value(:)
      character(:), allocatable :: joined
      integer :: i

      joined = ''
      if (allocated(value)) then
         do i = 1, size(value)
            if (i > 1) joined = joined//', '
            joined = joined//real_text(value(i))
         end do
      end if
      if (joined == '') then
         call self%write_line(variable, '0.0', .false.)
      else
         call self%write_line(variable, joined, .true.)
      end if
   end subroutine write_list

   !> Writes name = value, in an explained group with ! unit, range: description.
   subroutine write_line(self, variable, value, in_force)
      class(writer_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      character(*), intent(in) :: value
      logical, intent(in) :: in_force
      character(:), allocatable :: line, note

      if (.not. in_force .and. .not. self%explain) return
      line = '   '
      if (.not. in_force) line = '   ! '
      line = line//trim(variable%name)//' = '//value
      if (self%explain) then
         note = trim(variable%unit)
         if (variable%range() /= '') then
            if (note /= '') note = note//', '
            note = note//trim(variable%range())
         end if
         if (note /= '') note = note//': '
         if (len(line) < 40) line = line//repeat(' ', 40 - len(line))
         line = line//' ! '//note//trim(variable%description)
      end if
      self%text = self%text//line//newline
   end subroutine write_line

end module geartrain_input_text
