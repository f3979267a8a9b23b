!> The table of input variables as a list of rows with kinds and defaults; messages about unknown groups and variables.
module geartrain_input_table
   use geartrain_analyses_analysis, only: analysis_type
   use geartrain_analyses_list, only: analyses, case_type, find_analysis, results_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_nearest, only: nearest_name
   use geartrain_base_numbers, only: integer_text, real_text
   use geartrain_base_variable, only: variable_type, visitor_type
   use geartrain_input_cursor, only: shortened
   use geartrain_input_variables, only: groups, visit_case
   use geartrain_train_mesh, only: new_bearing, new_coupling
   implicit none (type, external)
   private
   public :: row_type, is_variable, list_variables, take_keyword, unknown_group, unknown_variable

   !> A variable of the table.
   type :: row_type
      !> Name of the group.
      character(24) :: group = ''
      !> 'real', 'integer', 'logical', 'text', 'reals' (a list) or 'names' (of bodies).
      character(12) :: kind = ''
      !> Default as a case file would give it; blank: none.
      character(24) :: default = ''
      !> Name, unit, range and description.
      type(variable_type) :: variable
   end type row_type

   !> The visitor that lists the variables.
   type, extends(visitor_type) :: collector_type
      !> The first `count` elements are in use.
      type(row_type), allocatable :: rows(:)
      integer :: count = 0
   contains
      procedure :: on_real
      procedure :: on_integer
      procedure :: on_logical
      procedure :: on_text
      procedure :: on_list
      procedure :: on_names
      procedure, private :: collect
   end type collector_type

contains

   !> Lists every variable of every group.
   subroutine list_variables(rows, chain)
      !> The variables in the order of a case file.
      type(row_type), allocatable, intent(out) :: rows(:)
      !> List the variables of a chain, which has no &body; absent: of a train with bodies.
      logical, intent(in), optional :: chain
      type(collector_type) :: collector
      type(case_type), target :: case
      type(results_type), target :: none
      class(analysis_type), allocatable :: analysis
      integer :: i

      allocate (collector%rows(64), case%train%bodies(1), case%train%planetaries(1), case%train%shafts(1), &
                case%train%meshes(4))
      case%train%meshes(2) = new_coupling()
      case%train%meshes(3) = new_bearing(1)
      case%train%meshes(4) = new_bearing(2)
      do i = 1, size(analyses)
         call find_analysis(i, case, none, analysis, ask=.true.)
      end do
      if (present(chain)) then
         if (chain) deallocate (case%train%bodies)
      end if
      call visit_case(case, collector)
      rows = collector%rows(:collector%count)
   end subroutine list_variables

   !> Adds a row.
   subroutine collect(self, variable, kind, default)
      class(collector_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      character(*), intent(in) :: kind, default
      type(row_type) :: row

      row%group = self%group
      row%kind = kind
      if (.not. variable%required) row%default = default
      row%variable = variable
      if (self%count == size(self%rows)) self%rows = [self%rows, self%rows]
      self%count = self%count + 1
      self%rows(self%count) = row
   end subroutine collect

   subroutine on_real(self, variable, value, in_force)
      class(collector_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      real(dp), intent(inout) :: value
      logical, intent(inout), optional :: in_force
      character(:), allocatable :: default

      default = ''
      if (variable%allows(value)) default = real_text(value)
      if (present(in_force) .and. variable%excludes /= '') default = ''
      call self%collect(variable, 'real', default)
   end subroutine on_real

   subroutine on_integer(self, variable, value)
      class(collector_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      integer, intent(inout) :: value

      call self%collect(variable, 'integer', integer_text(value))
   end subroutine on_integer

   subroutine on_logical(self, variable, value)
      class(collector_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      logical, intent(inout) :: value

      call self%collect(variable, 'logical', trim(merge('.true. ', '.false.', value)))
   end subroutine on_logical

   subroutine on_text(self, variable, value)
      class(collector_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      character(:), allocatable, intent(inout) :: value

      if (allocated(value)) then
         call self%collect(variable, 'text', "'"//value//"'")
      else
         call self%collect(variable, 'text', "''")
      end if
   end subroutine on_text

   subroutine on_list(self, variable, value)
      class(collector_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      real(dp), allocatable, intent(inout) :: value(:)

      call self%collect(variable, 'reals', 'none')
   end subroutine on_list

   subroutine on_names(self, variable, value)
      class(collector_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      character(*), intent(inout) :: value(:)

      call self%collect(variable, 'names', 'none')
   end subroutine on_names

   !> Whether the table has a variable of this name in the group.
   pure logical function is_variable(name, group, rows)
      !> Name of the variable; name of the group.
      character(*), intent(in) :: name, group
      !> All variables, see list_variables.
      type(row_type), intent(in) :: rows(:)
      integer :: i

      is_variable = any([(rows(i)%group == group .and. rows(i)%variable%name == name, i = 1, size(rows))])
   end function is_variable

   !> Replaces the keyword of a call by the name in the table. Python cannot have a keyword `from`: `start` and `stop` stand for
   !> `from` and `to`, also at the end of a name.
   subroutine take_keyword(name, group, rows)
      !> Keyword, then name; a name that is in the table, or a keyword without a name in the table, stays.
      character(:), allocatable, intent(inout) :: name
      !> Name of the group.
      character(*), intent(in) :: group
      !> All variables, see list_variables.
      type(row_type), intent(in) :: rows(:)
      character(:), allocatable :: meant
      integer :: at

      if (is_variable(name, group, rows)) return
      meant = name
      at = index(name, 'start', back=.true.)
      if (at > 0 .and. at == len(name) - 4) meant = name(:at - 1)//'from'
      at = index(name, 'stop', back=.true.)
      if (at > 0 .and. at == len(name) - 3) meant = name(:at - 1)//'to'
      if (is_variable(meant, group, rows)) name = meant
   end subroutine take_keyword

   !> Makes the message about an unknown group.
   subroutine unknown_group(name, text)
      !> The name that is no group.
      character(*), intent(in) :: name
      !> The message, with the nearest group or with all groups.
      character(:), allocatable, intent(out) :: text
      integer :: i, best

      best = nearest_name(name, [(groups(i)%name, i = 1, size(groups))])
      text = 'unknown group &'//shortened(name)
      if (best > 0) then
         text = text//' (did you mean &'//trim(groups(best)%name)//'?)'
      else
         text = text//' (there are'
         do i = 1, size(groups)
            text = text//' &'//trim(groups(i)%name)
         end do
         text = text//')'
      end if
   end subroutine unknown_group

   !> Makes the message about an unknown variable.
   subroutine unknown_variable(name, group, rows, text, meant)
      !> The name that is no variable of the group; name of the group.
      character(*), intent(in) :: name, group
      !> All variables, see list_variables.
      type(row_type), intent(in) :: rows(:)
      !> The message; the nearest name, '' if no name is near.
      character(:), allocatable, intent(out) :: text, meant
      character(24), allocatable :: names(:)
      integer :: i, best

      names = pack([(rows(i)%variable%name, i = 1, size(rows))], [(rows(i)%group == group, i = 1, size(rows))])
      text = 'unknown variable "'//shortened(name)//'" in &'//group
      meant = ''
      best = nearest_name(name, names)
      if (best > 0) then
         meant = trim(names(best))
         text = text//' (did you mean "'//meant//'"?)'
         return
      end if
      do i = 1, size(rows)
         if (rows(i)%variable%name == name) then
            text = text//' (it belongs to &'//trim(rows(i)%group)//')'
            return
         end if
      end do
      if (size(names) == 0) then
         text = text//' (the group has no variables)'
         return
      end if
      text = text//' (there are '
      do i = 1, size(names)
         if (i > 1) text = text//', '
         text = text//trim(names(i))
      end do
      text = text//')'
   end subroutine unknown_variable

end module geartrain_input_table
