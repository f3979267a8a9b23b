!> Lists every field that a results file can hold, for the reference page of the output and for readers that look fields up.
module geartrain_run_reference
   use geartrain_analyses_list, only: case_type, results_type
   use geartrain_base_field, only: group_type, kind_integer
   use geartrain_base_fields, only: fields_type, listing
   use geartrain_run_results, only: visit_results, visit_root
   implicit none (type, external)
   private
   public :: list_results, output_reference

   character(*), parameter :: newline = new_line('a')

contains

   !> Lists all groups with their fields, without values.
   subroutine list_results(fields)
      !> The fields; empty on entry.
      type(fields_type), intent(inout) :: fields
      type(results_type) :: results
      type(case_type) :: case

      allocate (case%train%shafts(0), case%train%meshes(0))
      fields%way = listing
      call visit_root(case, fields)
      call visit_results(results, case, fields, summary=.true.)
   end subroutine list_results

   !> Writes the tables of docs/output.md.
   subroutine output_reference(text)
      !> Markdown.
      character(:), allocatable, intent(out) :: text
      type(fields_type) :: fields
      integer :: i

      call list_results(fields)
      text = ''
      do i = 1, fields%count
         call add_group(fields%groups(i), text)
      end do
   end subroutine output_reference

   subroutine add_group(group, text)
      type(group_type), intent(in) :: group
      character(:), allocatable, intent(inout) :: text

      if (text /= '') text = text//newline
      text = text//'### `'//group%path//'`'//newline
      if (group%description /= '') then
         text = text//newline
         call add_with(capital(trim(group%description)), '|', '\|', text)
         text = text//'.'//newline
      end if
      call add_table(group, .false., newline//'| Dataset | Dimensions | Unit | What |'//newline//'|---|---|---|---|'//newline, text)
      call add_table(group, .true., newline//'| Attribute | What |'//newline//'|---|---|'//newline, text)
   end subroutine add_group

   !> Adds the rows of the attributes or of the datasets, without axes whose values are only 1, 2, ...
   subroutine add_table(group, attributes, head, text)
      type(group_type), intent(in) :: group
      logical, intent(in) :: attributes
      character(*), intent(in) :: head
      character(:), allocatable, intent(inout) :: text
      character(:), allocatable :: rows
      integer :: i

      rows = ''
      do i = 1, group%count
         associate (about => group%fields(i)%about)
            if ((about%dimensions == '') .neqv. attributes) cycle
            if (group%fields(i)%axis .and. group%fields(i)%kind == kind_integer) cycle
            rows = rows//'| `'//trim(about%name)//'` | '
            if (.not. attributes) then
               call add_with(trim(about%dimensions), ' ', ', ', rows)
               rows = rows//' | '//trim(about%unit)//' | '
            end if
            ! A bar within a cell of a table.
            call add_with(trim(about%description), '|', '\|', rows)
            if (about%only /= '') rows = rows//'. Only '//trim(about%only)
            rows = rows//' |'//newline
         end associate
      end do
      if (rows /= '') text = text//head//rows
   end subroutine add_table

   pure function capital(text)
      character(*), intent(in) :: text
      character(len(text)) :: capital

      capital = text
      if (lge(text(1:1), 'a') .and. lle(text(1:1), 'z')) capital(1:1) = achar(iachar(text(1:1)) - 32)
   end function capital

   !> Adds `words` to `text`, with `instead` in place of each `mark`.
   subroutine add_with(words, mark, instead, text)
      character(*), intent(in) :: words, instead
      character, intent(in) :: mark
      character(:), allocatable, intent(inout) :: text
      integer :: i

      do i = 1, len(words)
         if (words(i:i) == mark) text = text//instead
         if (words(i:i) /= mark) text = text//words(i:i)
      end do
   end subroutine add_with

end module geartrain_run_reference
