!> An audit as a table, a line a row, and a line that sums it up.
module geartrain_branch_audit_text
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_branch_audit_result, only: audit_row_type, audit_type
   implicit none (type, external)
   private
   public :: audit_text

   character(*), parameter :: newline = new_line('a')

contains

   !> The lines, without a newline after the last.
   function audit_text(audit) result(lines)
      type(audit_type), intent(in) :: audit
      character(:), allocatable :: lines
      integer :: i

      lines = '      Lambda  what              estimate     error  ratio  balance    shooting   '
      do i = 1, size(audit%rows)
         lines = lines//newline//line(audit%rows(i))
      end do
      lines = lines//newline//summary(audit)
   end function audit_text

   !> One row of the table.
   function line(row)
      type(audit_row_type), intent(in) :: row
      character(:), allocatable :: line
      character(120) :: buffer

      write (buffer, '(f12.6, 2x, a16, 3(1x, a), 2(2x, a9))') row%frequency, row%kind, number(row%estimate, '(es9.1)', 9), &
         number(row%error, '(es9.1)', 9), number(row%ratio(), '(f6.2)', 6), row%verdict, row%exact_verdict
      line = trim(buffer)
      if (row%exact_frequency > 0) then
         write (buffer, '(sp, es9.1)') row%exact_frequency - row%frequency
         line = line//'  exact at '//text(row%exact_frequency)//' ('//trim(adjustl(buffer))//')'
      end if
      if (row%finding /= '') line = line//'  '//trim(row%finding)
   end function line

   !> '-' for a negative number, which stands for none.
   function number(value, form, width)
      real(dp), intent(in) :: value
      character(*), intent(in) :: form
      integer, intent(in) :: width
      character(width) :: number

      number = repeat(' ', width - 1)//'-'
      if (value >= 0) write (number, form) value
   end function number

   !> '20 of 20 as estimated, 0 verdicts wrong', and what else there is to be said.
   function summary(audit)
      type(audit_type), intent(in) :: audit
      character(:), allocatable :: summary

      summary = text(audit%as_estimated)//' of '//text(audit%points)//' as estimated, '
      if (audit%doubtful > 0) summary = summary//text(audit%doubtful)//' doubtful, '
      summary = summary//text(audit%wrong_verdicts)//trim(merge(' verdict  ', ' verdicts ', audit%wrong_verdicts == 1))//' wrong'
      if (audit%special_points > 0) summary = summary//'; '//text(audit%confirmed)//' of '//text(audit%special_points)// &
                                              ' special points confirmed'
      if (audit%cancelled) summary = summary//'; cancelled'
   end function summary

end module geartrain_branch_audit_text
