!> Adds a warning to a list.
module geartrain_report_add_warning
   use geartrain_base_field, only: text_type
   use geartrain_base_numbers, only: integer_text
   use geartrain_base_problems, only: group_label
   implicit none (type, external)
   private
   public :: add_warning

contains

   !> Adds '&mesh 1: sentence'; of several groups the same sentence once, '&mesh 1 to 3, 5: sentence'.
   subroutine add_warning(warnings, group, i, sentence)
      !> The list.
      type(text_type), allocatable, intent(inout) :: warnings(:)
      !> Name of the group, and what to say of it.
      character(*), intent(in) :: group, sentence
      !> Number of the group; 0: there is one of it.
      integer, intent(in) :: i
      type(text_type) :: warning
      integer :: j, n

      do j = 1, size(warnings)
         n = len(warnings(j)%text) - len(sentence) - 2
         if (n < 1) cycle
         if (warnings(j)%text(n + 1:) /= ': '//sentence .or. index(warnings(j)%text, '&'//group//' ') /= 1) cycle
         warning%text = trim(joined(warnings(j)%text(:n), i))//': '//sentence
         warnings(j) = warning
         return
      end do
      warning%text = group_label(group, i)//': '//sentence
      warnings = [warnings, warning]
   end subroutine add_warning

   !> Numbers and one more: '&mesh 1, 2' and 3 are '&mesh 1 to 3'.
   pure function joined(numbers, next) result(words)
      character(*), intent(in) :: numbers
      integer, intent(in) :: next
      character(len(numbers) + 12) :: words
      character(:), allocatable :: last

      last = integer_text(next - 1)
      if (ends(integer_text(next))) then
         words = numbers
      else if (ends(' to '//last)) then
         words = numbers(:len(numbers) - len(last))//integer_text(next)
      else if (ends(integer_text(next - 2)//', '//last)) then
         words = numbers(:len(numbers) - len(last) - 2)//' to '//integer_text(next)
      else
         words = numbers//', '//integer_text(next)
      end if

   contains

      !> Whether the numbers end with some, and not with the end of a larger one.
      pure logical function ends(tail)
         character(*), intent(in) :: tail
         integer :: before

         before = len(numbers) - len(tail)
         ends = before > 0
         if (ends) ends = numbers(before + 1:) == tail .and. (tail(1:1) == ' ' .or. numbers(before:before) == ' ')
      end function ends

   end function joined

end module geartrain_report_add_warning
