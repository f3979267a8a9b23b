!> Parameters of a train by name: 'input_torque', 'shaft 2 stiffness', 'mesh * half_backlash' (of all meshes alike), 'body motor
!> inertia', 'mesh 1 stiffness_cos 2' (a value of a list) or 'stiffness_variation' (the largest amplitude of kappa, all others in
!> proportion).
module geartrain_model_parameter
   use geartrain_base_error, only: error_type, fatal
   use geartrain_base_kinds, only: dp
   use geartrain_base_nearest, only: nearest_name
   use geartrain_base_numbers, only: integer_text
   use geartrain_base_series, only: make_series, series_type
   use geartrain_base_variable, only: variable_type, visitor_type
   use geartrain_model_mesh, only: mesh_type
   use geartrain_model_train, only: train_type
   use geartrain_model_variables, only: visit_body, visit_mesh, visit_model, visit_shaft, visit_train
   implicit none (type, external)
   private
   public :: parameter_type, table_type, add_to_parameter, find_parameter, largest_variation, own_value, variation

   !> Variables that are in the plain train as they are given.
   character(*), parameter :: plain_variables(*) = [character(24) :: 'input_torque', 'torque_cos', 'torque_sin', &
      'prime_mover_inertia', 'load_inertia', 'inertia', 'torque', 'damping_to_ground', 'stiffness', 'damping_ratio', 'damping', &
      'driving_radius', 'driven_radius', 'driving_inertia', 'driven_inertia', 'half_backlash', 'back_stiffness', 'back_phase', &
      'stiffness_cos', 'stiffness_sin', 'error_cos', 'error_sin']
   !> Those among them that `phase` turns.
   character(*), parameter :: turned_variables(*) = [character(24) :: 'stiffness_cos', 'stiffness_sin', 'error_cos', 'error_sin']
   !> Name of the parameter that scales all mesh stiffness variations.
   character(*), parameter :: variation = 'stiffness_variation'

   type :: parameter_type
      !> Group 'train', 'body', 'shaft' or 'mesh'; the variable; number of the group, 0: all; value of a list, 0: no list.
      character(5) :: group = ''
      character(24) :: variable = ''
      integer :: index = 0, item = 0
      !> Value [unit of the variable]; of several groups that of the first. The unit, blank for a dimensionless one.
      real(dp) :: value = 0
      character(12) :: unit = ''
      !> A number of the plain train that the drawing gives: the derivative is as if it were given.
      logical :: derived = .false.
      !> In the plain train as it is given, and nothing else is derived from it.
      logical :: direct = .false.
   end type parameter_type

   !> A variable of a train.
   type :: entry_type
      character(5) :: group = ''
      character(24) :: variable = ''
      character(12) :: unit = ''
      !> Number of the group; number of values, -1: no list; place of the first among all numbers.
      integer :: index = 0, values = -1, first = 0
      logical :: in_force = .true., continuous = .true.
   end type entry_type

   !> All variables of a train with their numbers, taken from it or given to it; or adds to a variable.
   type, extends(visitor_type) :: table_type
      !> 'take', 'give' or 'add'.
      character(4) :: way = 'take'
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
      procedure :: give
      procedure, private :: find
      procedure, private :: meet
      procedure, private :: carry
   end type table_type

contains

   !> Finds the parameter of a name.
   subroutine find_parameter(train, plain, given, derived, name, parameter, error)
      !> A train that has passed `check_train`, and its plain train.
      type(train_type), intent(in) :: train, plain
      !> Their tables.
      type(table_type), intent(in) :: given, derived
      !> The name.
      character(*), intent(in) :: name
      !> The parameter.
      type(parameter_type), intent(out) :: parameter
      !> Added to where the train has no such parameter.
      type(error_type), allocatable, intent(inout) :: error
      type(entry_type) :: row, of_plain
      character(:), allocatable :: rest, which
      character(24), allocatable :: names(:)
      real(dp) :: value
      integer :: at, best, found

      rest = trim(adjustl(name))
      if (rest == variation) then
         parameter%variable = rest
         parameter%value = largest_variation(plain%meshes)
         if (.not. parameter%value > 0) call refuse('no mesh stiffness varies')
         return
      end if
      at = index(rest, ' ', back=.true.)
      if (at > 0 .and. whole_number(rest(at + 1:)) >= 0) then
         parameter%item = whole_number(rest(at + 1:))
         rest = trim(rest(:at))
         at = index(rest, ' ', back=.true.)
      end if
      parameter%variable = rest(at + 1:)
      rest = trim(rest(:at))
      parameter%group = 'train'
      parameter%index = 1
      if (is_body(rest)) then
         parameter%group = 'body'
         which = rest
         call find_group()
      else if (rest /= '') then
         at = index(rest//' ', ' ')
         parameter%group = rest(:at - 1)
         which = trim(adjustl(rest(at:)))
         call find_group()
         if (parameter%index < 0) return
      end if
      call given%find(parameter, found, row, parameter%value)
      if (found > 0 .and. row%values == 1 .and. parameter%item == 0) then
         parameter%item = 1
         call given%find(parameter, found, row, parameter%value)
      end if
      parameter%unit = row%unit
      parameter%direct = any(plain_variables == parameter%variable)
      if (parameter%direct .and. .not. (is_given(row) .and. abs(parameter%value) > 0)) then
         call derived%find(parameter, found, of_plain, value)
         parameter%derived = is_given(of_plain) .and. (.not. is_given(row) .or. abs(value) > 0)
         if (parameter%derived) row = of_plain
         if (parameter%derived) parameter%value = value
      end if
      ! A face width may mean a stiffness that depends on the loads.
      if (any(train%meshes%face_width > 0)) parameter%direct = .false.
      if (any(turned_variables == parameter%variable) .and. any(abs(train%meshes%phase) > 0)) parameter%direct = .false.
      parameter%direct = parameter%direct .or. parameter%derived
      if (found == 0) then
         names = pack(given%row(:given%rows)%variable, given%row(:given%rows)%continuous &
                                                       .and. given%row(:given%rows)%group == parameter%group)
         best = nearest_name(trim(parameter%variable), names)
         if (best > 0) then
            call refuse('no variable of &'//trim(parameter%group)//' (did you mean "'//trim(names(best))//'"?)')
         else
            call refuse('no variable of &'//trim(parameter%group))
         end if
      else if (.not. row%continuous) then
         call refuse('no continuous parameter')
      else if (index(parameter%variable, 'characteristic_') == 1) then
         call refuse('a unit of the results, no property of the train')
      else if (row%values < 0 .and. parameter%item > 0) then
         call refuse('one number, no list')
      else if (.not. is_given(row)) then
         call refuse('not in force in this train: it is not given')
      else if (row%values > 0 .and. (parameter%item < 1 .or. parameter%item > row%values)) then
         call refuse('a list: its values are named by their numbers, 1 to '//integer_text(row%values)//', as in "'// &
                     trim(parameter%variable)//' 1"')
      end if

   contains

      subroutine refuse(why)
         character(*), intent(in) :: why

         call fatal(error, 'parameter "'//trim(adjustl(name))//'": '//why)
      end subroutine refuse

      !> Whether a body has this name.
      logical function is_body(text)
         character(*), intent(in) :: text
         integer :: i

         is_body = .false.
         if (.not. allocated(train%bodies) .or. text == '') return
         do i = 1, size(train%bodies)
            is_body = is_body .or. train%bodies(i)%name == text
         end do
      end function is_body

      !> Sets the number of the group, 0: all; -1: refused.
      subroutine find_group()
         integer :: groups, i

         groups = -1
         if (parameter%group == 'train') groups = 1
         if (parameter%group == 'shaft') groups = size(train%shafts)
         if (parameter%group == 'mesh') groups = size(train%meshes)
         if (parameter%group == 'body' .and. allocated(train%bodies)) groups = size(train%bodies)
         parameter%index = merge(0, whole_number(which), which == '*')
         if (groups < 0) then
            parameter%index = -1
            call refuse('must begin with "mesh", "shaft" or, in a network, "body" or its name, or be a variable of &train')
            return
         end if
         if (parameter%group == 'train' .and. which == '') parameter%index = 1
         if (parameter%group == 'body') then
            do i = 1, groups
               if (train%bodies(i)%name == which) parameter%index = i
            end do
         end if
         if (parameter%index >= 0 .and. parameter%index <= groups .and. (parameter%index > 0 .or. which == '*')) return
         parameter%index = -1
         call refuse('must tell which &'//trim(parameter%group)//': 1 to '//integer_text(groups)//', or * for all'// &
                     trim(merge(', or its name', '             ', parameter%group == 'body')))
      end subroutine find_group

   end subroutine find_parameter

   !> Value of a text of up to eight digits; -1: it is none.
   pure integer function whole_number(text)
      character(*), intent(in) :: text
      integer :: i

      whole_number = -1
      if (verify(text, '0123456789') > 0 .or. text == '' .or. len(text) > 8) return
      whole_number = 0
      do i = 1, len(text)
         whole_number = 10*whole_number + index('123456789', text(i:i))
      end do
   end function whole_number

   !> Adds to a parameter, of all its groups.
   subroutine add_to_parameter(train, parameter, change, allowed)
      !> The train.
      type(train_type), intent(inout) :: train
      !> Its parameter, a variable.
      type(parameter_type), intent(in) :: parameter
      !> What is added [unit of the parameter].
      real(dp), intent(in) :: change
      !> Whether the new values are in the range of the variable.
      logical, intent(out), optional :: allowed
      type(table_type) :: table
      integer :: i, groups

      table%way = 'add'
      table%variable = parameter%variable
      table%item = parameter%item
      table%change = change
      groups = 1
      if (parameter%group == 'shaft') groups = size(train%shafts)
      if (parameter%group == 'mesh') groups = size(train%meshes)
      if (parameter%group == 'body') groups = size(train%bodies)
      do i = max(1, parameter%index), merge(groups, parameter%index, parameter%index == 0)
         select case (parameter%group)
         case ('train')
            call visit_train(train, table)
         case ('body')
            call visit_body(train%bodies(i), i, table)
         case ('shaft')
            call visit_shaft(train%shafts(i), i, table)
         case ('mesh')
            call visit_mesh(train%meshes(i), i, table)
         end select
      end do
      if (present(allowed)) allowed = table%allowed
   end subroutine add_to_parameter

   !> Largest amplitude of any harmonic of kappa of any mesh of a plain train.
   pure real(dp) function largest_variation(meshes) result(largest)
      !> Meshes of a plain train.
      type(mesh_type), intent(in) :: meshes(:)
      type(series_type) :: kappa
      integer :: j

      largest = 0
      do j = 1, size(meshes)
         kappa = make_series(meshes(j)%stiffness_cos, meshes(j)%stiffness_sin, 1.0_dp, 1)
         largest = maxval([largest, abs(kappa%amplitude)])
      end do
   end function largest_variation

   !> Takes all variables of a train.
   subroutine take(self, train)
      class(table_type), intent(inout) :: self
      !> The train; it is left as it is.
      type(train_type), intent(inout) :: train

      self%way = 'take'
      self%rows = 0
      self%numbers = 0
      if (.not. allocated(self%row)) allocate (self%row(256), self%number(256))
      call visit_model(train, self)
   end subroutine take

   !> Sets all numbers of a train.
   subroutine give(self, train)
      class(table_type), intent(inout) :: self
      !> The train that they were taken from, or another with lists of such lengths.
      type(train_type), intent(inout) :: train

      self%way = 'give'
      self%numbers = 0
      call visit_model(train, self)
   end subroutine give

   !> Finds the variable of a parameter, of several groups that of the first.
   pure subroutine find(self, parameter, found, row, value)
      class(table_type), intent(in) :: self
      type(parameter_type), intent(in) :: parameter
      !> Number of the row, 0: there is none.
      integer, intent(out) :: found
      type(entry_type), intent(out) :: row
      !> The number; 0 where the parameter is none of the values of a list.
      real(dp), intent(out) :: value
      integer :: item

      value = 0
      do found = 1, self%rows
         if (self%row(found)%index /= max(1, parameter%index)) cycle
         if (self%row(found)%group == parameter%group .and. self%row(found)%variable == parameter%variable) exit
      end do
      if (found > self%rows) found = 0
      if (found == 0) return
      row = self%row(found)
      item = merge(1, parameter%item, row%values < 0)
      if (row%first > 0 .and. item > 0 .and. item <= abs(row%values)) value = self%number(row%first + item - 1)
   end subroutine find

   !> Value of a parameter in a train, of several groups that of the first [unit of the variable].
   pure real(dp) function own_value(table, parameter)
      !> Variables of the train.
      type(table_type), intent(in) :: table
      !> A variable.
      type(parameter_type), intent(in) :: parameter
      type(entry_type) :: row
      integer :: found

      call table%find(parameter, found, row, own_value)
   end function own_value

   !> Whether a variable has a value that is used.
   pure logical function is_given(row)
      type(entry_type), intent(in) :: row

      is_given = row%in_force .and. row%values /= 0
   end function is_given

   !> Takes a variable without its numbers.
   subroutine meet(self, variable, continuous)
      class(table_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      logical, intent(in) :: continuous

      if (self%way /= 'take') return
      if (self%rows == size(self%row)) self%row = [self%row, self%row]
      self%rows = self%rows + 1
      self%row(self%rows) = entry_type(self%group(:5), variable%name, variable%unit, self%index, continuous=continuous)
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
      if (self%way == 'take' .and. present(in_force)) self%row(self%rows)%in_force = in_force
      value = values(1)
   end subroutine on_real

   subroutine on_list(self, variable, value)
      class(table_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      real(dp), allocatable, intent(inout) :: value(:)

      call self%meet(variable, .not. variable%whole)
      if (self%way == 'take') self%row(self%rows)%values = 0
      if (.not. allocated(value)) return
      if (self%way == 'take') self%row(self%rows)%values = size(value)
      call self%carry(variable, value)
   end subroutine on_list

   !> Takes or gives the numbers of a variable, or adds to the number that is wanted.
   subroutine carry(self, variable, values)
      class(table_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      real(dp), intent(inout) :: values(:)
      integer :: n

      n = size(values)
      if (self%way == 'add') then
         if (variable%name /= self%variable .or. self%item > n) return
         n = max(1, self%item)
         values(n) = values(n) + self%change
         self%allowed = self%allowed .and. variable%allows(values(n))
         return
      end if
      if (self%way == 'take') then
         if (self%numbers + n > size(self%number)) self%number = [self%number, self%number, values]
         self%row(self%rows)%first = self%numbers + 1
         self%number(self%numbers + 1:self%numbers + n) = values
      else
         values = self%number(self%numbers + 1:self%numbers + n)
      end if
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

end module geartrain_model_parameter
