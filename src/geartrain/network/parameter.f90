!> Parameters of a train by name: 'input_torque', 'shaft 2 stiffness', 'mesh * half_backlash' (of all meshes alike), 'body motor
!> inertia', 'mesh 1 stiffness_cos 2' (a value of a list) or 'stiffness_variation' (the largest amplitude of kappa, all others in
!> proportion). Several, separated by commas, take the same value, as the errors of both meshes of a planet that is out of place.
module geartrain_network_parameter
   use geartrain_base_error, only: error_type, fatal
   use geartrain_base_kinds, only: dp
   use geartrain_base_nearest, only: nearest_name
   use geartrain_base_numbers, only: integer_text
   use geartrain_base_series, only: make_series, series_type
   use geartrain_network_modal_damping, only: damps_by_modes
   use geartrain_network_parameter_table, only: entry_type, parameter_type, settings_length, table_type
   use geartrain_train_body, only: has_table_of_torque
   use geartrain_train_gear_error, only: has_gear_error
   use geartrain_train_mesh, only: has_loads, mesh_type
   use geartrain_train_mesh_groups, only: place_of
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: find_parameter, find_parameters, largest_variation, variation

   !> Variables that are in the plain train as they are given.
   character(*), parameter :: plain_variables(*) = [character(24) :: 'input_torque', 'torque_cos', 'torque_sin', &
      'prime_mover_inertia', 'load_inertia', 'inertia', 'torque', 'damping_to_ground', 'stiffness', 'damping_ratio', 'damping', &
      'driving_radius', 'driven_radius', 'driving_inertia', 'driven_inertia', 'half_backlash', 'half_play', 'angle', &
      'back_stiffness', 'back_phase', 'mass', 'half_clearance', 'line_of_action', 'position', 'friction_torque', &
      'stiffness_cos', 'stiffness_sin', 'error_cos', 'error_sin', 'error_mean', 'revolution_torque_cos', 'revolution_torque_sin', &
      'driving_error_cos', 'driving_error_sin', 'driven_error_cos', 'driven_error_sin', 'torque_speed_exponent', 'torque_speed']
   !> Those among them that `phase` turns.
   character(*), parameter :: turned_variables(*) = [character(24) :: 'stiffness_cos', 'stiffness_sin', 'error_cos', 'error_sin', &
      'driving_error_cos', 'driving_error_sin', 'driven_error_cos', 'driven_error_sin']
   !> Those among them that errors of the teeth add to.
   character(*), parameter :: summed_variables(*) = [character(24) :: 'error_mean', 'driving_error_cos', 'driving_error_sin', &
      'driven_error_cos', 'driven_error_sin']
   !> Those among them that the damping depends on where it follows from the modes.
   character(*), parameter :: modal_variables(*) = [character(24) :: 'input_torque', 'prime_mover_inertia', 'load_inertia', &
      'inertia', 'torque', 'damping_to_ground', 'stiffness', 'damping_ratio', 'damping', 'driving_radius', 'driven_radius', &
      'driving_inertia', 'driven_inertia', 'back_stiffness', 'half_play', 'angle', 'mass', 'half_clearance', &
      'line_of_action', 'position']
   !> Name of the parameter that scales all mesh stiffness variations.
   character(*), parameter :: variation = 'stiffness_variation'
   !> Number of a value that no list has.
   integer, parameter :: beyond_any = 10**8

contains

   !> Finds the parameters of a name. Each part between commas is one parameter; with * it is one of each group in which it is
   !> in force.
   subroutine find_parameters(train, plain, given, derived, name, parameters, error)
      !> A train that has passed `check_train`, and its plain train.
      type(train_type), intent(in) :: train, plain
      !> Their tables.
      type(table_type), intent(in) :: given, derived
      !> The name.
      character(*), intent(in) :: name
      !> The parameters; none where the name is refused.
      type(parameter_type), allocatable, intent(out) :: parameters(:)
      !> Added to where the train has no such parameter.
      type(error_type), allocatable, intent(inout) :: error
      type(parameter_type), allocatable :: found(:)
      character(:), allocatable :: why
      integer :: begin, last, i

      allocate (parameters(0))
      if (len_trim(name) >= settings_length) call fatal(error, 'parameter "'//name(:20)//'...": at most '// &
                                                        integer_text(settings_length - 1)//' characters')
      if (allocated(error)) return
      last = -1
      do
         begin = last + 2
         last = begin - 2 + index(name(begin:)//',', ',')
         call find_part(train, plain, given, derived, name(begin:last), found, error)
         if (allocated(error)) exit
         do i = 1, size(found)
            if (any(are_same(parameters, found(i)))) why = 'names one number twice'
            if (any(parameters%unit /= found(i)%unit)) why = 'numbers that take the same value have the same unit'
         end do
         parameters = [parameters, found]
         if (last >= len_trim(name)) exit
      end do
      if (size(parameters) > 1 .and. any(parameters%variable == variation)) why = variation//' stands for all harmonics by itself'
      if (allocated(why) .and. .not. allocated(error)) call fatal(error, 'parameter "'//trim(adjustl(name))//'": '//why)
      if (allocated(error)) parameters = parameters(:0)
   end subroutine find_parameters

   !> Whether two parameters are the same number.
   elemental logical function are_same(one, other)
      type(parameter_type), intent(in) :: one, other

      are_same = one%group == other%group .and. one%variable == other%variable .and. one%index == other%index .and. &
                 one%item == other%item
   end function are_same

   !> Finds the parameters of a part of a name between commas.
   subroutine find_part(train, plain, given, derived, name, parameters, error)
      type(train_type), intent(in) :: train, plain
      type(table_type), intent(in) :: given, derived
      character(*), intent(in) :: name
      type(parameter_type), allocatable, intent(out) :: parameters(:)
      type(error_type), allocatable, intent(inout) :: error
      type(parameter_type) :: parameter
      type(error_type), allocatable :: refused, first
      integer :: at, groups, i

      allocate (parameters(0))
      at = index(name, ' * ')
      groups = 0
      if (at > 0) groups = group_count(train, adjustl(name(:at)))
      if (groups == 0) then
         call find_parameter(train, plain, given, derived, name, parameter, error)
         if (.not. allocated(error)) parameters = [parameter]
         return
      end if
      do i = 1, groups
         if (allocated(refused)) deallocate (refused)
         call find_parameter(train, plain, given, derived, name(:at)//integer_text(i)//name(at + 2:), parameter, refused)
         if (.not. allocated(refused)) then
            parameters = [parameters, parameter]
         else if (.not. allocated(first)) then
            first = refused
         end if
      end do
      if (size(parameters) == 0) call fatal(error, first%message, lines=.true.)
   end subroutine find_part

   !> Number of groups of a kind; 0 also for the group &train.
   pure integer function group_count(train, group)
      type(train_type), intent(in) :: train
      !> 'body', 'shaft', 'mesh', 'coupling' or 'bearing'.
      character(*), intent(in) :: group

      group_count = 0
      if (group == 'shaft') group_count = size(train%shafts)
      if (group == 'mesh') group_count = count(train%meshes%is_pair())
      if (group == 'bearing') group_count = count(train%meshes%axis == 1)
      if (group == 'coupling') group_count = count(train%meshes%is_coupling)
      if (group == 'body' .and. allocated(train%bodies)) group_count = size(train%bodies)
   end function group_count

   !> Finds the parameter of a name.
   subroutine find_parameter(train, plain, given, derived, name, parameter, error)
      !> A train that has passed `check_train`, and its plain train.
      type(train_type), intent(in) :: train, plain
      !> Their tables.
      type(table_type), intent(in) :: given, derived
      !> The name.
      character(*), intent(in) :: name
      type(parameter_type), intent(out) :: parameter
      !> Added to where the train has no such parameter.
      type(error_type), allocatable, intent(inout) :: error
      type(entry_type) :: row
      integer :: found

      if (adjustl(name) == variation) then
         parameter%variable = variation
         parameter%value = largest_variation(plain%meshes)
         if (.not. parameter%value > 0) call refuse('no mesh stiffness varies')
         if (any([(has_loads(train%meshes(found)), found=1, size(train%meshes))])) &
            call refuse('the variation of a mesh with table_loads is given at each load: change stiffness_table')
         return
      end if
      call read_name()
      if (parameter%index < 0) return
      call given%find(parameter, found, row, parameter%value)
      if (found > 0 .and. row%values == 1 .and. parameter%item == 0) then
         parameter%item = 1
         call given%find(parameter, found, row, parameter%value)
      end if
      parameter%unit = row%unit
      call find_kind()
      if (found == 0) then
         call refuse('no variable of &'//trim(parameter%group)//trim(suggestion()))
      else if (.not. row%continuous) then
         call refuse('no continuous parameter')
      else if (index(parameter%variable, 'characteristic_') == 1) then
         call refuse('a unit of the results, no property of the train')
      else if (row%values < 0 .and. parameter%item > 0) then
         call refuse('one number, no list')
      else if (parameter%variable == 'input_torque' .and. allocated(train%bodies)) then
         call refuse('not in force in this train: it is that of a chain; bodies have torques, as in "'// &
                     trim(train%bodies(1)%name)//' torque"')
      else if (.not. is_given(row)) then
         call refuse('not in force in this train: it is not given')
      else if (parameter%derived .and. damps_by_modes(train) .and. any(modal_variables == parameter%variable)) then
         call refuse('not in force in this train: the drawing gives it, and loss_factor or modal_damping the damping that goes &
                     &with it: name a number of the drawing, or give it in the case')
      else if (is_of_first_stage()) then
         call refuse('not in force in this train: table_loads give the variation at each load: name a value of stiffness_table')
      else if (is_of_flats()) then
         call refuse('not in force in this train alone: with more than four flats it is the same in x and y')
      else if (balances_others()) then
         call refuse('not in force in this train: the torque of this body balances those of all others')
      else if (is_toothed_radius()) then
         call refuse('not in force in this train: the numbers of teeth tell the ratio of the radii')
      else if (row%values > 0 .and. (parameter%item < 1 .or. parameter%item > row%values)) then
         call refuse('a list: its values are named by their numbers, 1 to '//integer_text(row%values)//', as in "'// &
                     trim(parameter%variable)//' 1"')
      end if

   contains

      !> Whether it is the variation of the first stage of a mesh with several.
      logical function is_of_first_stage()
         integer :: i

         is_of_first_stage = .false.
         if (parameter%group /= 'mesh' .or. index(parameter%variable, 'stiffness_') /= 1) return
         if (all(parameter%variable /= [character(13) :: 'stiffness_cos', 'stiffness_sin'])) return
         is_of_first_stage = any([(has_loads(train%meshes(i)) .and. any(parameter%index == [0, i]), i=1, size(train%meshes))])
      end function is_of_first_stage

      !> Reads group, number, variable and value of a list from the name; the number is -1 where it is refused.
      subroutine read_name()
         character(:), allocatable :: rest
         integer :: at

         rest = trim(adjustl(name))
         at = index(rest, ' ', back=.true.)
         if (at > 0 .and. whole_number(rest(at + 1:)) >= 0) then
            parameter%item = whole_number(rest(at + 1:))
            ! They are numbered from 1; 0 tells that no number is given.
            if (parameter%item == 0) parameter%item = beyond_any
            rest = trim(rest(:at))
            at = index(rest, ' ', back=.true.)
         end if
         parameter%variable = rest(at + 1:)
         rest = trim(rest(:at))
         parameter%group = 'train'
         parameter%index = 1
         if (is_body(rest)) then
            parameter%group = 'body'
            call find_group(rest)
         else if (rest /= '') then
            at = index(rest//' ', ' ')
            parameter%group = rest(:at - 1)
            call find_group(trim(adjustl(rest(at:))))
         end if
      end subroutine read_name

      !> Finds whether the parameter is a number of the plain train, and whether other numbers follow from it.
      subroutine find_kind()
         type(entry_type) :: of_plain
         real(dp) :: value
         integer :: i

         associate (variable => parameter%variable, direct => parameter%direct)
            parameter%plain = any(plain_variables == variable)
            direct = parameter%plain .and. .not. adds_to_table()
            if (direct .and. .not. (is_given(row) .and. abs(parameter%value) > 0)) then
               call derived%find(parameter, found, of_plain, value)
               parameter%derived = is_given(of_plain) .and. (.not. is_given(row) .or. abs(value) > 0)
               if (parameter%derived) row = of_plain
               if (parameter%derived) parameter%value = value
            end if
            ! A face width may mean a stiffness that depends on the loads.
            if (any(train%meshes%face_width > 0)) direct = .false.
            if (any(turned_variables == variable) .and. any(abs(train%meshes%phase) > 0)) direct = .false.
            if (any(summed_variables == variable)) then
               if (any(has_gear_error(train%meshes%gear_error(1)) .or. has_gear_error(train%meshes%gear_error(2)) .or. &
                       [(allocated(train%meshes(i)%error_table), i=1, size(train%meshes))])) direct = .false.
            end if
            ! Further rows of a bearing follow from x.
            if (parameter%group == 'bearing' .and. any(train%meshes%flats > 4)) direct = .false.
            ! Damping that follows from the modes changes with every number that they follow from.
            if (damps_by_modes(train) .and. any(modal_variables == variable)) direct = .false.
            direct = direct .or. parameter%derived
         end associate
      end subroutine find_kind

      !> Whether it is a stiffness or damping of a bearing with more than four flats.
      logical function is_of_flats()
         is_of_flats = .false.
         if (parameter%group /= 'bearing' .or. all(parameter%variable /= [character(9) :: 'stiffness', 'damping'])) return
         is_of_flats = train%meshes(place_of(train%meshes, 'bearing', parameter%index))%flats > 4
      end function is_of_flats

      !> Whether the torque of a table adds to the parameter.
      logical function adds_to_table()
         adds_to_table = .false.
         if (parameter%group /= 'body' .or. index(parameter%variable, 'torque') == 0) return
         adds_to_table = any(has_table_of_torque(train%bodies))
      end function adds_to_table

      subroutine refuse(why)
         character(*), intent(in) :: why

         call fatal(error, 'parameter "'//trim(adjustl(name))//'": '//why)
      end subroutine refuse

      !> A name that may be meant where there is none of this: of a mesh, shaft or body that &train has not, or one like it.
      character(80) function suggestion()
         integer :: i, best

         suggestion = ''
         associate (rows => given%row(:given%rows))
            i = 0
            if (parameter%group == 'train') then
               i = findloc(rows%variable == parameter%variable .and. rows%continuous .and. rows%group == 'mesh', .true., 1)
               if (i == 0) i = findloc(rows%variable == parameter%variable .and. rows%continuous, .true., 1)
            end if
            if (i > 0) suggestion = trim(rows(i)%group)//' * '//trim(parameter%variable) &
                                    //trim(merge(' 1', '  ', rows(i)%values > 0))
            if (suggestion == '') then
               best = nearest_name(trim(parameter%variable), pack(rows%variable, is_near(rows)))
               if (best == 0) best = findloc(index(pack(rows%variable, is_near(rows)), trim(parameter%variable)) > 0, .true., 1)
               do i = 1, merge(size(rows), 0, best > 0)
                  best = best - merge(1, 0, is_near(rows(i)))
                  if (best > 0) cycle
                  suggestion = rows(i)%variable
                  exit
               end do
            end if
         end associate
         if (suggestion /= '') suggestion = ' (did you mean "'//trim(suggestion)//'"?)'
      end function suggestion

      !> Whether a row is a number of the group of the parameter.
      elemental logical function is_near(row)
         type(entry_type), intent(in) :: row

         is_near = row%continuous .and. row%group == parameter%group
      end function is_near

      !> Whether the parameter is the mean torque that is not given but balances all others.
      logical function balances_others()
         balances_others = parameter%group == 'body' .and. parameter%variable == 'torque'
         if (balances_others) balances_others = train%bodies(parameter%index)%balances
      end function balances_others

      !> Whether the parameter is the radius of a gear whose ratio the teeth tell.
      logical function is_toothed_radius()
         is_toothed_radius = parameter%variable == 'driving_radius' .or. parameter%variable == 'driven_radius'
         if (is_toothed_radius) is_toothed_radius = allocated(train%meshes(parameter%index)%teeth)
      end function is_toothed_radius

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
      subroutine find_group(which)
         !> Number or name of the group.
         character(*), intent(in) :: which
         integer :: groups, i

         groups = group_count(train, parameter%group)
         parameter%index = whole_number(which)
         if (parameter%group == 'train' .and. which == '') parameter%index = 1
         if (parameter%group == 'train') groups = 1
         if (all(parameter%group /= [character(8) :: 'train', 'mesh', 'coupling', 'bearing', 'shaft', 'body']) .or. &
             parameter%group == 'body' .and. .not. allocated(train%bodies)) then
            parameter%index = -1
            call refuse('must begin with "mesh", "shaft" or, in a network, "coupling", "bearing", "body" or its name, or &
                        &be a variable of &train')
            return
         end if
         if (parameter%group == 'body') then
            do i = 1, groups
               if (train%bodies(i)%name == which) parameter%index = i
            end do
         else if (parameter%index < 0 .and. which /= '' .and. all(parameter%group /= [character(5) :: 'train', 'shaft'])) then
            do i = 1, groups
               if (train%meshes(place_of(train%meshes, trim(parameter%group), i))%name == which) parameter%index = i
            end do
         end if
         if (parameter%index > 0 .and. parameter%index <= groups) return
         parameter%index = -1
         call refuse('must tell which &'//trim(parameter%group)//': 1 to '//integer_text(groups)//', or * for all'// &
                     trim(merge('             ', ', or its name', any(parameter%group == [character(5) :: 'train', 'shaft']))))
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

   !> Whether a variable has a value that is used.
   pure logical function is_given(row)
      type(entry_type), intent(in) :: row

      is_given = row%in_force .and. row%values /= 0
   end function is_given

end module geartrain_network_parameter
