!> An audit as text: a table with a line for each row, and a line with the sums.
module geartrain_report_audit_text
   use geartrain_exact_audit_result, only: audit_row_type, audit_type
   use geartrain_readings_frequency_text, only: frequency_text, frequency_text_type, in_width
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: counted, text
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: audit_text

   character(*), parameter :: newline = new_line('a')

contains

   !> Writes an audit as text.
   subroutine audit_text(audit, train, unit, lines)
      type(audit_type), intent(in) :: audit
      !> The train of the branch.
      type(train_type), intent(in) :: train
      !> The unit that the branch is asked in: 'Lambda', 'rpm' or 'Hz'.
      character(*), intent(in) :: unit
      !> The lines, without a newline after the last.
      character(:), allocatable, intent(out) :: lines
      type(frequency_text_type) :: told
      integer :: i

      told = frequency_text(train, unit, 0.0_dp)
      told%decimals = 6
      lines = in_width(told%unit, 12)//'  what              estimate     error  ratio  balance    shooting   '//newline
      do i = 1, size(audit%rows)
         call add_row(audit%rows(i), told, lines)
         lines = lines//newline
      end do
      call add_summary(audit, lines)
   end subroutine audit_text

   !> Adds one row of the table.
   subroutine add_row(row, told, lines)
      type(audit_row_type), intent(in) :: row
      type(frequency_text_type), intent(in) :: told
      character(:), allocatable, intent(inout) :: lines
      character(120) :: buffer

      write (buffer, '(a, 2x, a16, 3(1x, a), 2(2x, a9))') in_width(told%number(row%frequency_ratio), 12), row%kind, &
         number(row%estimate, '(es9.1)', 9), number(row%error, '(es9.1)', 9), number(row%ratio(), '(f6.2)', 6), row%verdict, &
         row%exact_verdict
      lines = lines//trim(buffer)
      if (row%exact_frequency > 0) then
         write (buffer, '(sp, es9.1)') told%per_lambda*(row%exact_frequency - row%frequency_ratio)
         lines = lines//'  exact at '//text(told%per_lambda*row%exact_frequency)//' ('//trim(adjustl(buffer))//')'
      end if
      if (row%finding /= '') lines = lines//'  '//trim(row%finding)
   end subroutine add_row

   !> A number as text; '-' for a negative number, which stands for none.
   function number(value, form, width)
      real(dp), intent(in) :: value
      character(*), intent(in) :: form
      integer, intent(in) :: width
      character(width) :: number

      number = repeat(' ', width - 1)//'-'
      if (value >= 0) write (number, form) value
   end function number

   !> Adds the line 'Errors of 20 of 20 points are as estimated; stability is wrong at 0 points; 10 of 10 special points are
   !> confirmed'.
   subroutine add_summary(audit, lines)
      type(audit_type), intent(in) :: audit
      character(:), allocatable, intent(inout) :: lines

      lines = lines//'Errors of '//text(audit%as_estimated)//' of '//counted(audit%points, 'point', 'points')//' are as estimated'
      if (audit%doubtful > 0) lines = lines//', '//text(audit%doubtful)//' called doubtful'
      lines = lines//'; stability is wrong at '//counted(audit%wrong_verdicts, 'point', 'points')
      if (audit%special_points > 0) lines = lines//'; '//text(audit%confirmed)//' of '// &
         counted(audit%special_points, 'special point', 'special points')//' confirmed'
      lines = lines//'; jumps and contact ranges are not audited'
      if (audit%cancelled) lines = lines//'; cancelled'
   end subroutine add_summary

end module geartrain_report_audit_text
