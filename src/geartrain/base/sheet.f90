!> The report under construction: sections in the order in which they are read, each with its lines.
module geartrain_base_sheet
   use geartrain_base_field, only: text_type
   implicit none (type, external)
   private
   public :: in_details, in_files, in_head, in_modes, in_quality, in_resonances, in_result, in_run_up, in_shafts, sheet_type

   !> Numbers of the sections.
   integer, parameter :: in_head = 1, in_result = 2, in_modes = 3, in_resonances = 4, in_shafts = 5, in_run_up = 6, &
                         in_quality = 7, in_files = 8, in_details = 9
   character(*), parameter :: headings(9) = [character(10) :: '', 'RESULT', 'MODES', 'RESONANCES', 'SHAFTS', 'RUN-UP', &
                                             'QUALITY', 'FILES', 'DETAILS']
   !> Columns of a line of text; blanks before a line, and before the next lines of a sentence.
   integer, parameter :: columns = 104, indent = 2, hanging = 4

   type :: sheet_type
      !> Whether the report has everything: longer lists, and the section DETAILS.
      logical :: verbose = .false.
      !> Lines of each section; not allocated: none.
      type(text_type) :: sections(size(headings))
   contains
      procedure :: add
      procedure :: say
      procedure :: is_empty
      procedure :: put_together
   end type sheet_type

contains

   !> Adds a line as it stands, such as a row of a table.
   subroutine add(self, section, line)
      class(sheet_type), intent(inout) :: self
      !> Number of the section.
      integer, intent(in) :: section
      !> The line.
      character(*), intent(in) :: line

      associate (part => self%sections(section))
         if (.not. allocated(part%text)) part%text = ''
         part%text = part%text//repeat(' ', merge(0, indent, section == in_head))//trim(line)//new_line('a')
      end associate
   end subroutine add

   !> Adds a sentence, in lines of limited length.
   subroutine say(self, section, sentence)
      class(sheet_type), intent(inout) :: self
      !> Number of the section.
      integer, intent(in) :: section
      !> The sentence.
      character(*), intent(in) :: sentence
      integer :: first, last, room

      first = 1
      room = columns - indent
      do while (len_trim(sentence) - first + 1 > room)
         last = index(sentence(first:first + room), ' ', back=.true.)
         if (last <= 1) last = index(sentence(first:), ' ')
         if (last <= 1) exit
         call self%add(section, repeat(' ', merge(0, hanging - indent, first == 1))//sentence(first:first + last - 2))
         first = first + last
         room = columns - hanging
      end do
      call self%add(section, repeat(' ', merge(0, hanging - indent, first == 1))//sentence(first:))
   end subroutine say

   !> Whether a section has no line.
   pure logical function is_empty(self, section)
      class(sheet_type), intent(in) :: self
      !> Number of the section.
      integer, intent(in) :: section

      is_empty = .not. allocated(self%sections(section)%text)
   end function is_empty

   !> Puts the sections together, each under its heading.
   subroutine put_together(self, text)
      class(sheet_type), intent(in) :: self
      !> The lines, each with a newline.
      character(:), allocatable, intent(out) :: text
      integer :: i

      text = ''
      do i = 1, size(headings)
         if (self%is_empty(i)) cycle
         if (headings(i) /= '') text = text//trim(headings(i))//new_line('a')
         text = text//self%sections(i)%text
      end do
   end subroutine put_together

end module geartrain_base_sheet
