!> All variables of a train in a table with their numbers, and one of them, a parameter, by its place.
module geartrain_network_parameter_table
   use geartrain_base_kinds, only: dp
   use geartrain_base_variable, only: variable_type, visitor_type
   use geartrain_train_bearing_variables, only: visit_bearing
   use geartrain_train_coupling_variables, only: visit_coupling
   use geartrain_train_mesh_groups, only: group_length, place_of
   use geartrain_train_train, only: train_type
   use geartrain_train_train_variables, only: visit_body, visit_mesh, visit_model, visit_shaft, visit_train
   implicit none (type, external)
   private
   public :: add_to_parameter, entry_type, parameter_type, settings_length, table_type

   !> Characters that settings hold of the name of a parameter; names are shorter.
   integer, parameter :: settings_length = 400

   type :: parameter_type
      !> Group 'train', 'body', 'shaft', 'mesh', 'coupling' or 'bearing'; the variable; number of the group; value of a list, 0: no
      !> list.
      character(group_length) :: group = ''
      character(24) :: variable = ''
      integer :: index = 0, item = 0
      !> Value [unit of the variable]; the unit, blank for a dimensionless one.
      real(dp) :: value = 0
      character(12) :: unit = ''
      !> A number of the plain train that the drawing gives: the derivative is as if it were given.
      logical :: derived = .false.
      !> A number of the plain train, not one that another number is derived from.
      logical :: plain = .false.
      !> In the plain train as it is given, and nothing else is derived from it.
      logical :: direct = .false.
   end type parameter_type

   !> A variable of a train.
   type :: entry_type
      character(group_length) :: group = ''
      character(24) :: variable = ''
      character(12) :: unit = ''
      !> Number of the group; number of values, -1: no list; place of the first among all numbers.
      integer :: index = 0, values = -1, first = 0
      logical :: in_force = .true., continuous = .true.
   end type entry_type

   !> All variables of a train with their numbers; or adds to a variable.
   type, extends(visitor_type) :: table_type
      !> Whether it adds to a variable; else it takes all of them.
      logical :: adds = .false.
      !> The variables and their numbers in the order of the visits; how many there are.
      type(entry_type), allocatable :: row(:)
      real(dp), allocatable :: number(:)
      integer :: rows = 0, numbers = 0
      !> To add: the variable, the value of a list, what is added, and whether the sum is in the range of the variable.
      character(24) :: variable = ''
      integer :: item = 0
      real(dp) :: change = 0
      logical :: allowed = .true.
   contains
      procedure :: on_real
      procedure :: on_integer
      procedure :: on_logical
      procedure :: on_text
      procedure :: on_list
      procedure :: on_names
      procedure :: take
      procedure :: find
      procedure :: holds_more_than
      procedure, private :: meet
      procedure, private :: carry
   end type table_type

contains

   !> Adds to a parameter.
   subroutine add_to_parameter(train, parameter, change, allowed)
      type(train_type), intent(inout) :: train
      !> Its parameter, a variable.
      type(parameter_type), intent(in) :: parameter
      !> What is added [unit of the parameter].
      real(dp), intent(in) :: change
      !> Whether the new values are in the range of the variable.
      logical, intent(out), optional :: allowed
      type(table_type) :: table

      table%adds = .true.
      table%variable = parameter%variable
      table%item = parameter%item
      table%change = change
      associate (i => parameter%index)
         select case (parameter%group)
         case ('train')
            call visit_train(train, table)
         case ('body')
            call visit_body(train%bodies(i), i, table)
         case ('shaft')
            call visit_shaft(train%shafts(i), i, table)
         case ('mesh')
            call visit_mesh(train%meshes(i), i, table)
         case ('coupling')
            call visit_coupling(train%meshes(place_of(train%meshes, 'coupling', i)), i, table)
         case ('bearing')
            associate (first => place_of(train%meshes, 'bearing', i))
               call visit_bearing(train%meshes(first:first + 1), i, table)
            end associate
         end select
      end associate
      if (present(allowed)) allowed = table%allowed
   end subroutine add_to_parameter

   !> Takes all variables of a train.
   subroutine take(self, train)
      class(table_type), intent(inout) :: self
      !> The train; it is left as it is.
      type(train_type), intent(inout) :: train

      self%adds = .false.
      self%rows = 0
      self%numbers = 0
      if (.not. allocated(self%row)) allocate (self%row(256), self%number(256))
      call visit_model(train, self)
   end subroutine take

   !> Finds the variable of a parameter.
   pure subroutine find(self, parameter, found, row, value)
      class(table_type), intent(in) :: self
      !> The parameter; its value is not looked at.
      type(parameter_type), intent(in) :: parameter
      !> Number of the row, 0: there is none.
      integer, intent(out) :: found
      !> The row, where there is one.
      type(entry_type), intent(out) :: row
      !> The number; 0 where the parameter is none of the values of a list.
      real(dp), intent(out) :: value
      integer :: item

      value = 0
      do found = 1, self%rows
         if (self%row(found)%index /= parameter%index) cycle
         if (self%row(found)%group == parameter%group .and. self%row(found)%variable == parameter%variable) exit
      end do
      if (found > self%rows) found = 0
      if (found == 0) return
      row = self%row(found)
      item = merge(1, parameter%item, row%values < 0)
      if (row%first > 0 .and. item > 0 .and. item <= abs(row%values)) value = self%number(row%first + item - 1)
   end subroutine find

   !> Whether the table has other numbers than another one, but for those of the variable of a parameter itself.
   pure logical function holds_more_than(self, other, parameter) result(more)
      class(table_type), intent(in) :: self
      !> Of a train of the same groups.
      type(table_type), intent(in) :: other
      type(parameter_type), intent(in) :: parameter
      integer :: i

      more = self%numbers /= other%numbers
      if (more) return
      do i = 1, self%rows
         associate (row => self%row(i))
            if (row%first == 0 .or. row%values == 0) cycle
            if (row%group == parameter%group .and. row%index == parameter%index .and. row%variable == parameter%variable) cycle
            associate (a => row%first, b => row%first + abs(row%values) - 1)
               more = any(abs(self%number(a:b) - other%number(a:b)) > 0)
            end associate
         end associate
         if (more) return
      end do
   end function holds_more_than

   !> Takes a variable without its numbers.
   subroutine meet(self, variable, continuous)
      class(table_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      logical, intent(in) :: continuous

      if (self%adds) return
      if (self%rows == size(self%row)) self%row = [self%row, self%row]
      self%rows = self%rows + 1
      self%row(self%rows) = entry_type(self%group(:group_length), variable%name, variable%unit, self%index, continuous=continuous)
   end subroutine meet

   subroutine on_real(self, variable, value, in_force)
      class(table_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      real(dp), intent(inout) :: value
      logical, intent(inout), optional :: in_force
      real(dp) :: values(1)

      values = value
      call self%meet(variable, .not. variable%whole)
      call self%carry(variable, values)
      if (present(in_force) .and. .not. self%adds) self%row(self%rows)%in_force = in_force
      value = values(1)
   end subroutine on_real

   subroutine on_list(self, variable, value)
      class(table_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      real(dp), allocatable, intent(inout) :: value(:)

      call self%meet(variable, .not. variable%whole)
      if (.not. self%adds) self%row(self%rows)%values = 0
      if (.not. allocated(value)) return
      if (.not. self%adds) self%row(self%rows)%values = size(value)
      call self%carry(variable, value)
   end subroutine on_list

   !> Takes the numbers of a variable, or adds to the number that is wanted.
   subroutine carry(self, variable, values)
      class(table_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      real(dp), intent(inout) :: values(:)
      integer :: n

      n = size(values)
      if (self%adds) then
         if (variable%name /= self%variable .or. self%item > n) return
         n = max(1, self%item)
         values(n) = values(n) + self%change
         self%allowed = self%allowed .and. variable%allows(values(n))
         return
      end if
      if (self%numbers + n > size(self%number)) self%number = [self%number, self%number, values]
      self%row(self%rows)%first = self%numbers + 1
      self%number(self%numbers + 1:self%numbers + n) = values
      self%numbers = self%numbers + n
   end subroutine carry

   subroutine on_integer(self, variable, value)
      class(table_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      integer, intent(inout) :: value

      call self%meet(variable, .false.)
   end subroutine on_integer

   subroutine on_logical(self, variable, value)
      class(table_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      logical, intent(inout) :: value

      call self%meet(variable, .false.)
   end subroutine on_logical

   subroutine on_text(self, variable, value)
      class(table_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      character(:), allocatable, intent(inout) :: value

      call self%meet(variable, .false.)
   end subroutine on_text

   subroutine on_names(self, variable, value)
      class(table_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      character(*), intent(inout) :: value(:)

      call self%meet(variable, .false.)
   end subroutine on_names

end module geartrain_network_parameter_table
