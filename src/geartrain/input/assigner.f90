!> The visitor that gives each variable its value from a scanned case file, and collects the problems of the values.
module geartrain_input_assigner
   use geartrain_base_checker, only: checker_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text
   use geartrain_base_variable, only: variable_type
   use geartrain_input_cursor, only: letters, shortened
   use geartrain_input_scanner, only: group_type, token_type
   use geartrain_input_values, only: read_integer, read_logical, read_real, read_text
   implicit none (type, external)
   private
   public :: assigner_type

   type, extends(checker_type) :: assigner_type
      !> Groups of the file.
      type(group_type), allocatable :: groups(:)
      !> Index in `groups` of the present group; 0: the file does not have the group.
      integer, private :: visited = 0
   contains
      procedure :: enter
      procedure :: on_real => assign_real
      procedure :: on_integer => assign_integer
      procedure :: on_logical => assign_logical
      procedure :: on_text => assign_text
      procedure :: on_list => assign_list
      procedure :: on_names => assign_names
      procedure :: count_of
      procedure :: locate
      procedure, private :: find
      procedure, private :: find_one
   end type assigner_type

contains

   subroutine enter(self, group, index)
      class(assigner_type), intent(inout) :: self
      character(*), intent(in) :: group
      integer, intent(in) :: index
      integer :: i

      call self%checker_type%enter(group, index)
      self%visited = 0
      do i = 1, size(self%groups)
         if (self%groups(i)%name /= group .or. self%groups(i)%index /= index) cycle
         self%visited = i
         return
      end do
   end subroutine enter

   subroutine assign_real(self, variable, value, in_force)
      class(assigner_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      real(dp), intent(inout) :: value
      logical, intent(inout), optional :: in_force
      type(token_type) :: token
      character(:), allocatable :: wrong
      logical :: found
      integer :: group, other

      call self%find_one(variable, token, found)
      if (.not. found) return
      call read_real(token, value, wrong)
      if (wrong == '' .and. .not. variable%allows_number(value)) wrong = trim(variable%expectation(value))
      if (wrong /= '') call self%complain(variable%name, shown(token), wrong)
      if (present(in_force)) in_force = .true.
      if (variable%excludes == '') return
      call self%find(variable%excludes, group, other)
      if (other > 0) call self%complain(variable%name, shown(token), 'is given together with '//trim(variable%excludes)// &
                                        ': leave out one of the two')
   end subroutine assign_real

   subroutine assign_integer(self, variable, value)
      class(assigner_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      integer, intent(inout) :: value
      type(token_type) :: token
      character(:), allocatable :: wrong
      logical :: found

      call self%find_one(variable, token, found)
      if (.not. found) return
      call read_integer(token, value, wrong)
      if (wrong == '' .and. .not. variable%allows(real(value, dp))) wrong = trim(variable%expectation())
      if (wrong /= '') call self%complain(variable%name, shown(token), wrong)
   end subroutine assign_integer

   subroutine assign_logical(self, variable, value)
      class(assigner_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      logical, intent(inout) :: value
      type(token_type) :: token
      character(:), allocatable :: wrong
      logical :: found

      call self%find_one(variable, token, found)
      if (.not. found) return
      call read_logical(token, value, wrong)
      if (wrong /= '') call self%complain(variable%name, shown(token), wrong)
   end subroutine assign_logical

   subroutine assign_text(self, variable, value)
      class(assigner_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      character(:), allocatable, intent(inout) :: value
      type(token_type) :: token
      character(:), allocatable :: wrong
      logical :: found

      call self%find_one(variable, token, found)
      if (.not. found) return
      call read_text(token, value, wrong)
      if (wrong /= '') then
         call self%complain(variable%name, shown(token), wrong)
      else
         call self%checker_type%on_text(variable, value)
      end if
   end subroutine assign_text

   subroutine assign_list(self, variable, value)
      class(assigner_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      real(dp), allocatable, intent(inout) :: value(:)
      character(:), allocatable :: wrong
      integer :: group, assignment, i

      call self%find(variable%name, group, assignment)
      if (assignment == 0) return
      associate (given => self%groups(group)%assignments(assignment))
         if (given%bad) return
         if (allocated(value)) deallocate (value)
         allocate (value(size(given%values)), source=0.0_dp)
         do i = 1, size(value)
            call read_real(given%values(i), value(i), wrong)
            if (wrong == '' .and. .not. variable%allows(value(i))) wrong = trim(variable%expectation(value(i)))
            if (wrong == '') cycle
            call self%complain(trim(variable%name), shown(given%values(i)), wrong, i)
            return
         end do
      end associate
      call self%checker_type%on_list(variable, value)
   end subroutine assign_list

   subroutine assign_names(self, variable, value)
      class(assigner_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      character(*), intent(inout) :: value(:)
      character(:), allocatable :: word, wrong
      integer :: group, assignment, i

      call self%find(variable%name, group, assignment)
      if (assignment == 0) then
         if (variable%required) call self%lacks(variable%name, trim(variable%description))
         return
      end if
      associate (given => self%groups(group)%assignments(assignment))
         if (given%bad) return
         if (size(given%values) /= size(value)) then
            call self%complain(variable%name, trim(shown(given%values(1))), 'takes '//integer_text(size(value))//' names, not '// &
                               integer_text(size(given%values)))
            return
         end if
         do i = 1, size(value)
            call read_text(given%values(i), word, wrong)
            if (wrong == '' .and. len(word) > len(value)) wrong = 'must have at most '//integer_text(len(value))//' bytes'
            if (wrong == '' .and. word == '') wrong = 'must not be blank'
            if (wrong /= '') then
               call self%complain(variable%name, trim(shown(given%values(i))), wrong)
               return
            end if
            value(i) = word
         end do
      end associate
      call self%checker_type%on_names(variable, value)
   end subroutine assign_names

   !> Finds the value of a variable that takes one value; several values, or none of a required variable, are problems.
   subroutine find_one(self, variable, token, found)
      class(assigner_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      type(token_type), intent(out) :: token
      logical, intent(out) :: found
      character(:), allocatable :: text
      integer :: group, assignment, i

      found = .false.
      call self%find(variable%name, group, assignment)
      if (assignment == 0) then
         if (variable%required) call self%lacks(variable%name, trim(variable%range())//' '//variable%unit)
         return
      end if
      associate (given => self%groups(group)%assignments(assignment))
         if (given%bad) return
         found = size(given%values) == 1
         token = given%values(1)
         if (found) return
         do i = 2, size(given%values)
            associate (word => given%values(i))
               if (word%quoted .or. word%line == token%line .or. scan(word%text, letters) /= 1) cycle
               if (self%problems%reported(self%group, self%index, variable%name)) return
               call self%problems%add('expected "=" after "'//shown(word)//'": it is no value of '//trim(variable%name), &
                                      self%group, self%index, variable%name, word%line, word%column)
               return
            end associate
         end do
         text = shown(token)
         do i = 2, min(size(given%values), 4)
            text = text//', '//shown(given%values(i))
         end do
         if (size(given%values) > 4) text = text//', ...'
         call self%complain(variable%name, text, 'takes one value, not '//integer_text(size(given%values))// &
                            ' (a text needs quotes, a decimal is written with a point)')
      end associate
   end subroutine find_one

   !> Index of the present group in `groups`, and index of the assignment to `name` in the group; 0: none.
   subroutine find(self, name, group, assignment)
      class(assigner_type), intent(in) :: self
      character(*), intent(in) :: name
      integer, intent(out) :: group, assignment

      group = self%visited
      assignment = 0
      if (group == 0) return
      do assignment = 1, size(self%groups(group)%assignments)
         if (self%groups(group)%assignments(assignment)%name == name) return
      end do
      assignment = 0
   end subroutine find

   !> Number of groups of a name in the file.
   pure integer function count_of(self, name)
      class(assigner_type), intent(in) :: self
      !> Name of the groups.
      character(*), intent(in) :: name
      integer :: i

      count_of = count([(self%groups(i)%name == name, i = 1, size(self%groups))])
   end function count_of

   !> Gives each problem without line and column those of its value, else of its variable, else of its group.
   subroutine locate(self)
      class(assigner_type), intent(inout) :: self
      integer :: i, group, assignment

      do i = 1, self%problems%count
         associate (problem => self%problems%list(i))
            if (problem%line > 0 .or. problem%group == '') cycle
            call self%enter(trim(problem%group), problem%index)
            call self%find(trim(problem%name), group, assignment)
            if (group == 0) cycle
            problem%line = self%groups(group)%line
            problem%column = self%groups(group)%column
            if (assignment == 0) cycle
            associate (given => self%groups(group)%assignments(assignment))
               problem%line = given%line
               problem%column = given%column
               if (size(given%values) == 0) cycle
               associate (token => given%values(min(max(1, problem%place), size(given%values))))
                  problem%line = token%line
                  problem%column = token%column
               end associate
            end associate
         end associate
      end do
      call self%leave()
   end subroutine locate

   !> A value as messages show it: in quotes if it is quoted, and shortened.
   pure function shown(token) result(text)
      type(token_type), intent(in) :: token
      character(len(shortened(token%text)) + merge(2, 0, token%quoted)) :: text

      text = shortened(token%text)
      if (token%quoted) text = "'"//shortened(token%text)//"'"
   end function shown

end module geartrain_input_assigner
