!> Checks the order of the groups of a case file.
module geartrain_input_order
   use geartrain_base_numbers, only: integer_text
   use geartrain_base_problems, only: group_label, parts_of_train, problems_type
   use geartrain_input_scanner, only: group_type
   use geartrain_input_table, only: unknown_group
   use geartrain_input_variables, only: known => groups
   implicit none (type, external)
   private
   public :: check_order

contains

   !> Checks that &train comes first, then &shaft and &mesh by turns (with &body all, &planetary, &coupling and &bearing too, in any
   !> order),
   !> then the analyses and &output, and that no other group is given twice.
   subroutine check_order(groups, problems)
      !> Groups of the file.
      type(group_type), intent(in) :: groups(:)
      !> Collects the problems.
      type(problems_type), intent(inout) :: problems
      ! Last group of the train, and first group after the train; '': none.
      character(:), allocatable :: last, after
      character(:), allocatable :: text
      integer :: i, j, first(size(known))
      logical :: chain

      chain = count(groups_named(groups, 'body')) + count(groups_named(groups, 'planetary')) == 0
      last = ''
      after = ''
      first = 0
      do i = 1, size(groups)
         associate (group => groups(i))
            j = findloc(known%name == group%name, .true., dim=1)
            if (j == 0) then
               call unknown_group(group%name, text)
               call problems%add(text, group%name, line=group%line, column=group%column, names_group=.true.)
               cycle
            end if
            if (first(j) == 0) first(j) = group%line
            if (any(group%name == parts_of_train)) then
               call check_turn(group, chain, last, after, problems)
               last = group%name
            else if (group%index > 1) then
               call problems%add('stands twice; the first is on line '//integer_text(first(j)), group%name, 1, &
                                 line=group%line, column=group%column)
            else if (group%name == 'train') then
               if (last /= '' .or. after /= '') call problems%add('must be the first group', group%name, 1, &
                                                                 line=group%line, column=group%column)
            else
               after = group%name
            end if
         end associate
      end do
      if (first(1) == 0) call problems%add('there is no &train group: it comes first in the file')
      if (.not. chain) return
      if (count(groups_named(groups, 'mesh')) == 0 .or. count(groups_named(groups, 'shaft')) == 0) then
         call problems%add('there are '//integer_text(count(groups_named(groups, 'shaft')))//' &shaft and '// &
                           integer_text(count(groups_named(groups, 'mesh')))// &
                           ' &mesh groups: a train needs &shaft, &mesh, &shaft at least')
      else if (last == 'mesh') then
         j = findloc(groups_named(groups, 'mesh'), .true., dim=1, back=.true.)
         call problems%add('is the last group of the train: a &shaft must follow it', 'mesh', groups(j)%index, &
                           line=groups(j)%line, column=groups(j)%column)
      end if
   end subroutine check_order

   !> Checks the position of a group &body, &shaft or &mesh after the groups before it.
   subroutine check_turn(group, chain, last, after, problems)
      type(group_type), intent(in) :: group
      logical, intent(in) :: chain
      character(*), intent(in) :: last, after
      type(problems_type), intent(inout) :: problems
      character(:), allocatable :: text

      if (after /= '') then
         text = 'stands after &'//after//': the train comes before the analyses'
      else if (.not. chain) then
         return
      else if (group%name == 'coupling') then
         text = 'joins bodies by name, but there is no &body'
      else if (group%name == 'bearing') then
         text = 'carries a body by name, but there is no &body'
      else if (last == group%name) then
         text = 'follows '//group_label(last, group%index - 1)//': a &'//trim(merge('mesh ', 'shaft', last == 'shaft'))// &
                ' must stand between them'
      else if (last == '' .and. group%name == 'mesh') then
         text = 'stands before any &shaft: the train begins with a shaft'
      else
         return
      end if
      call problems%add(text, group%name, group%index, line=group%line, column=group%column)
   end subroutine check_turn

   pure function groups_named(groups, name) result(is)
      type(group_type), intent(in) :: groups(:)
      character(*), intent(in) :: name
      logical :: is(size(groups))
      integer :: i

      is = [(groups(i)%name == name, i = 1, size(groups))]
   end function groups_named

end module geartrain_input_order
