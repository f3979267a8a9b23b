!> What a report says of the case itself: its warnings, and transmission errors without a phase.
module geartrain_report_case_notes
   use geartrain_base_field, only: text_type
   use geartrain_base_numbers, only: counted
   use geartrain_base_sheet, only: in_quality, sheet_type
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_drawing_error_phase, only: lacks_phase
   use geartrain_report_drawing_warnings, only: find_warnings
   use geartrain_train_names, only: list_numbers
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: say_error_phase, say_warnings

   !> Most warnings of a short report.
   integer, parameter :: most = 3

contains

   !> Adds the warnings of the train, such as numbers whose magnitude is that of another unit.
   subroutine say_warnings(train, sheet)
      !> A train that has passed `check_train`.
      type(train_type), intent(in) :: train
      type(sheet_type), intent(inout) :: sheet
      type(text_type), allocatable :: warnings(:)
      integer :: i

      call find_warnings(train, warnings)
      do i = 1, size(warnings)
         if (i > most .and. .not. sheet%verbose) exit
         call sheet%say(in_quality, 'Warning: '//warnings(i)%text)
      end do
      if (size(warnings) > most .and. .not. sheet%verbose) call sheet%say(in_quality, &
         counted(size(warnings) - most, 'more warning', 'more warnings')//': --check lists them.')
   end subroutine say_warnings

   !> Adds a sentence where transmission errors have no phase against the stiffness.
   subroutine say_error_phase(train, sheet)
      !> The train as given.
      type(train_type), intent(in) :: train
      type(sheet_type), intent(inout) :: sheet
      type(train_type) :: plain
      character(:), allocatable :: list
      integer :: i

      call plain_train(train, plain)
      call list_numbers([(lacks_phase(train%meshes(i), plain%meshes(i)), i=1, size(train%meshes))], 'mesh', 'meshes', list)
      if (list /= '') call sheet%say(in_quality, 'The transmission error of '//list//' has no phase against the stiffness. Compute &
                                     &error_cos of the other sign too: forces and loss of contact may differ.')
   end subroutine say_error_phase

end module geartrain_report_case_notes
