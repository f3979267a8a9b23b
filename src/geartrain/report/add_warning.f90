!> Adds a warning to a list.
module geartrain_report_add_warning
   use geartrain_base_field, only: text_type
   use geartrain_base_problems, only: group_label
   implicit none (type, external)
   private
   public :: add_warning

contains

   !> Adds '&mesh 1: sentence'.
   subroutine add_warning(warnings, group, i, sentence)
      !> The list.
      type(text_type), allocatable, intent(inout) :: warnings(:)
      !> Name of the group, and what to say of it.
      character(*), intent(in) :: group, sentence
      !> Number of the group; 0: there is one of it.
      integer, intent(in) :: i
      type(text_type) :: warning

      warning%text = group_label(group, i)//': '//sentence
      warnings = [warnings, warning]
   end subroutine add_warning

end module geartrain_report_add_warning
