!> The natural modes in a report: frequency, damping ratio and where the mode deflects most.
module geartrain_report_modes_table
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: counted, significant, text
   use geartrain_model_drawing, only: plain_train
   use geartrain_model_frequency_unit, only: hertz_per_lambda
   use geartrain_model_modes, only: modes_type
   use geartrain_model_train, only: train_type
   use geartrain_report_frequency_text, only: frequency_text, frequency_text_type, in_width
   use geartrain_report_sheet, only: in_modes, sheet_type
   implicit none (type, external)
   private
   public :: put_modes

   !> Most modes of a short report.
   integer, parameter :: most = 8

contains

   !> Adds the table of modes.
   subroutine put_modes(modes, train, sheet)
      !> The modes.
      type(modes_type), intent(in) :: modes
      !> The train as given.
      type(train_type), intent(in) :: train
      !> The report.
      type(sheet_type), intent(inout) :: sheet
      type(train_type) :: plain
      type(frequency_text_type) :: told
      character(:), allocatable :: line
      integer :: i, n, largest

      if (.not. allocated(modes%natural_frequency)) return
      call plain_train(train, plain)
      told = frequency_text(train, 'Lambda', 0.0_dp)
      n = size(modes%natural_frequency)
      if (.not. sheet%verbose) n = min(n, most)
      if (n == size(modes%natural_frequency) - 1) n = n + 1
      line = 'mode'
      if (told%unit == 'Lambda') line = line//'    Lambda'
      call sheet%add(in_modes, line//'          Hz  damping ratio [%]  deflects most')
      associate (hertz => hertz_per_lambda(plain))
         do i = 1, n
            line = in_width(text(i), 4)
            if (told%unit == 'Lambda') line = line//in_width(significant(modes%natural_frequency(i)), 10)
            largest = maxloc(abs(modes%shape(:, i)), 1)
            line = line//in_width(significant(modes%natural_frequency(i)*hertz), 12)// &
                   in_width(significant(100*modes%damping_ratio(i)), 19)//'  '//trim(modes%element(largest))
            if (modes%element_label(largest) /= modes%element(largest)) line = line//' ('//trim(modes%element_label(largest))//')'
            call sheet%add(in_modes, line)
         end do
         if (n == size(modes%natural_frequency)) return
         call sheet%say(in_modes, 'and '//counted(size(modes%natural_frequency) - n, 'mode', 'modes')//' up to '// &
                        significant(hertz*modes%natural_frequency(size(modes%natural_frequency)))//' Hz')
      end associate
   end subroutine put_modes

end module geartrain_report_modes_table
