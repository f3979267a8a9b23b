!> Reads a case file. All problems of the file are told at once; with any problem no case is given.
module geartrain_input_reader
   use geartrain_analyses_analysis, only: analysis_type
   use geartrain_analyses_list, only: case_type, find_analysis, number_of, results_type
   use geartrain_base_error, only: error_type, fatal
   use geartrain_base_numbers, only: integer_text
   use geartrain_base_problems, only: parts_of_train, problems_type
   use geartrain_base_regular_file, only: is_regular_file
   use geartrain_drawing_planetary_expansion, only: expand_sets, expansion_type
   use geartrain_input_assigner, only: assigner_type
   use geartrain_input_check_case, only: check_analyses
   use geartrain_input_expansion, only: name_sets
   use geartrain_input_order, only: check_order
   use geartrain_input_scanner, only: group_type, scan_text
   use geartrain_input_table, only: is_variable, list_variables, row_type, take_keyword, unknown_variable
   use geartrain_input_variables, only: groups, visit_output
   use geartrain_network_check_train, only: check_consistency
   use geartrain_train_bearing_variables, only: visit_bearing
   use geartrain_train_coupling_variables, only: visit_coupling
   use geartrain_train_mesh, only: new_bearing, new_coupling
   use geartrain_train_planetary_variables, only: visit_planetary
   use geartrain_train_train_variables, only: visit_body, visit_mesh, visit_shaft, visit_train
   implicit none (type, external)
   private
   public :: read_case, read_case_text

   integer, parameter :: most_bytes = 10000000

contains

   !> Reads a case file.
   subroutine read_case(path, case, error)
      !> Path of the file.
      character(*), intent(in) :: path
      !> The case; default values where there is an error.
      type(case_type), intent(out) :: case
      type(error_type), allocatable, intent(out) :: error
      character(:), allocatable :: text

      call load(path, text, error)
      if (allocated(error)) return
      call read_case_text(text, path, case, error)
   end subroutine read_case

   !> Reads a case from text.
   subroutine read_case_text(text, name, case, error)
      !> Text of a case file.
      character(*), intent(in) :: text
      !> Name of the file in messages, 'fig03.nml:14:4: error: ...'; '': messages name the group only, '&mesh 2: ...'.
      character(*), intent(in) :: name
      !> The case; default values where there is an error.
      type(case_type), intent(out) :: case
      type(error_type), allocatable, intent(out) :: error
      type(assigner_type) :: reader
      type(case_type) :: found
      type(row_type), allocatable :: rows(:)
      type(expansion_type) :: expansion
      integer :: i
      logical :: in_order

      call scan_text(text, reader%groups, reader%problems)
      if (reader%problems%count > 0 .and. size(reader%groups) == 0) then
         call reader%problems%raise(name, error)
         return
      end if
      call check_order(reader%groups, reader%problems)
      in_order = reader%problems%count == 0
      call list_variables(rows)
      do i = 1, size(reader%groups)
         call check_names(reader%groups(i), rows, reader%problems)
      end do
      call read_groups(found, reader)
      ! Groups that are not those of a train are not looked at together.
      if (in_order) call expand_sets(found%train, reader, expansion)
      if (in_order .and. .not. expansion%failed) then
         call check_consistency(found%train, reader)
         ! The text of a call from Python has no name. Such a call may have a seed, and checks the settings with it.
         call check_analyses(found, name == '', reader)
         call name_sets(expansion, reader%problems)
      end if
      call reader%locate()
      call reader%problems%raise(name, error)
      if (.not. allocated(error)) case = found
   end subroutine read_case_text

   !> Checks that every variable belongs to its group and is given once.
   subroutine check_names(group, rows, problems)
      type(group_type), intent(inout) :: group
      type(row_type), intent(in) :: rows(:)
      type(problems_type), intent(inout) :: problems
      character(:), allocatable :: text, meant
      integer :: i, j

      if (.not. any(groups%name == group%name)) return
      do i = 1, size(group%assignments)
         associate (this => group%assignments(i))
            call take_keyword(this%name, group%name, rows)
            if (.not. is_variable(this%name, group%name, rows)) then
               call unknown_variable(this%name, group%name, rows, text, meant)
               call problems%add(text, group%name, group%index, meant, this%line, this%column, names_group=.true.)
               this%bad = .true.
               cycle
            end if
            do j = 1, i - 1
               if (group%assignments(j)%name /= this%name) cycle
               call problems%add(this%name//' is given twice; the first is on line '// &
                                 integer_text(group%assignments(j)%line), group%name, group%index, &
                                 line=this%line, column=this%column)
               this%bad = .true.
               exit
            end do
         end associate
      end do
   end subroutine check_names

   !> Leads the reader over the groups of the file, each with the component of the case that the group sets.
   subroutine read_groups(case, reader)
      type(case_type), intent(inout), target :: case
      type(assigner_type), intent(inout) :: reader
      type(results_type), target :: none
      class(analysis_type), allocatable :: analysis
      integer :: i, number, gears, first

      gears = reader%count_of('mesh')
      first = gears + reader%count_of('coupling') + 1
      allocate (case%train%shafts(reader%count_of('shaft')), case%train%meshes(first - 1 + 2*reader%count_of('bearing')))
      do i = gears + 1, first - 1
         case%train%meshes(i) = new_coupling()
      end do
      do i = first, size(case%train%meshes)
         case%train%meshes(i) = new_bearing(1 + mod(i - first, 2))
      end do
      if (reader%count_of('body') > 0) allocate (case%train%bodies(reader%count_of('body')))
      if (reader%count_of('planetary') > 0) allocate (case%train%planetaries(reader%count_of('planetary')))
      case%output_file = ''
      case%train%title = ''
      do i = 1, size(reader%groups)
         associate (n => reader%groups(i)%index)
            if (n > 1 .and. .not. any(reader%groups(i)%name == parts_of_train)) cycle
            select case (reader%groups(i)%name)
            case ('train')
               call visit_train(case%train, reader)
            case ('body')
               call visit_body(case%train%bodies(n), n, reader)
            case ('planetary')
               call visit_planetary(case%train%planetaries(n), n, reader)
            case ('shaft')
               call visit_shaft(case%train%shafts(n), n, reader)
            case ('mesh')
               call visit_mesh(case%train%meshes(n), n, reader)
            case ('coupling')
               call visit_coupling(case%train%meshes(gears + n), n, reader)
            case ('bearing')
               call visit_bearing(case%train%meshes(first + 2*n - 2:first + 2*n - 1), n, reader)
            case ('output')
               call visit_output(case%output_file, reader)
            case default
               number = number_of(reader%groups(i)%name)
               if (number == 0) cycle
               call find_analysis(number, case, none, analysis, ask=.true.)
               call analysis%visit_variables(reader)
            end select
         end associate
      end do
   end subroutine read_groups

   !> Reads a whole file as text.
   subroutine load(path, text, error)
      character(*), intent(in) :: path
      character(:), allocatable, intent(out) :: text
      type(error_type), allocatable, intent(out) :: error
      character(200) :: why
      integer :: unit, status, bytes
      logical :: exists

      inquire (file=path, exist=exists)
      if (.not. exists) then
         call fatal(error, path//': error: there is no such file')
         return
      end if
      bytes = -1
      if (is_regular_file(path)) inquire (file=path, size=bytes)
      if (bytes < 0 .or. bytes > most_bytes) then
         call fatal(error, path//': error: a case file must be a regular file of at most 10 MB')
         return
      end if
      open (newunit=unit, file=path, access='stream', form='unformatted', status='old', action='read', iostat=status, iomsg=why)
      if (status /= 0) then
         call fatal(error, path//': error: cannot be opened: '//trim(why))
         return
      end if
      allocate (character(bytes) :: text)
      read (unit, iostat=status, iomsg=why) text
      close (unit)
      if (status /= 0) call fatal(error, path//': error: cannot be read: '//trim(why))
   end subroutine load

end module geartrain_input_reader
