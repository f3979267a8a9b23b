!> A list of the problems of the input, which are all told at once, in the order of the file.
module geartrain_base_problems
   use geartrain_base_error, only: error_type, fatal
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text
   use geartrain_base_plain_text, only: escaped
   use geartrain_base_sorting, only: ascending
   implicit none (type, external)
   private
   public :: problems_type, group_label, parts_of_train

   !> Groups of which a case may have several: what the train is made of.
   character(*), parameter :: parts_of_train(*) = [character(9) :: 'body', 'planetary', 'shaft', 'mesh', 'coupling', 'bearing']

   type :: problem_type
      !> Group, number of the group among the groups of its name, and variable; blank and 0: none.
      character(24) :: group = ''
      integer :: index = 0
      character(64) :: name = ''
      !> Index of the value in a list; 0: the whole variable.
      integer :: place = 0
      !> Line and column in the file; 0: none.
      integer :: line = 0, column = 0
      !> The text itself names the group.
      logical :: names_group = .false.
      character(:), allocatable :: text
   end type problem_type

   !> Problems that are kept; further problems are only counted.
   integer, parameter :: most_told = 200

   type :: problems_type
      !> Number of problems in `list`, and of further problems.
      integer :: count = 0, untold = 0
      !> (most_told) from the first problem on.
      type(problem_type), allocatable :: list(:)
   contains
      procedure :: add
      procedure :: reported
      procedure :: in_group
      procedure :: of_train
      procedure :: raise
   end type problems_type

contains

   !> Adds a problem.
   subroutine add(self, text, group, index, name, line, column, names_group, place)
      class(problems_type), intent(inout) :: self
      !> The message, without the place in the file.
      character(*), intent(in) :: text
      !> Group and variable.
      character(*), intent(in), optional :: group, name
      !> Number of the group among the groups of its name; line and column in the file; index of the value in a list.
      integer, intent(in), optional :: index, line, column, place
      !> The text itself names the group.
      logical, intent(in), optional :: names_group

      if (self%count == most_told) then
         self%untold = self%untold + 1
         return
      end if
      if (.not. allocated(self%list)) allocate (self%list(most_told))
      self%count = self%count + 1
      associate (problem => self%list(self%count))
         problem%text = text
         if (present(group)) problem%group = group
         if (present(index)) problem%index = index
         if (present(name)) problem%name = name
         if (present(line)) problem%line = line
         if (present(column)) problem%column = column
         if (present(names_group)) problem%names_group = names_group
         if (present(place)) problem%place = place
      end associate
   end subroutine add

   !> Whether there is a problem with a variable already; its consequences need not be told.
   elemental logical function reported(self, group, index, name)
      class(problems_type), intent(in) :: self
      !> Group and variable.
      character(*), intent(in) :: group, name
      !> Number of the group among the groups of its name.
      integer, intent(in) :: index
      integer :: i

      reported = .false.
      do i = 1, self%count
         reported = self%list(i)%group == group .and. self%list(i)%index == index .and. self%list(i)%name == name
         if (reported) return
      end do
   end function reported

   !> Whether there is a problem with a group of this name already.
   pure logical function in_group(self, group)
      class(problems_type), intent(in) :: self
      !> Name of the group.
      character(*), intent(in) :: group
      integer :: i

      in_group = any([(self%list(i)%group == group, i = 1, self%count)])
   end function in_group

   !> Whether there is a problem with the train already: what an analysis needs of it may be anything.
   pure logical function of_train(self)
      class(problems_type), intent(in) :: self
      integer :: i

      of_train = self%in_group('train') .or. any([(self%in_group(trim(parts_of_train(i))), i=1, size(parts_of_train))])
   end function of_train

   !> Makes the error that tells all problems, one a line, in the order of the file; no error where there is no problem.
   subroutine raise(self, file, error)
      class(problems_type), intent(in) :: self
      !> Name of the file in messages; '': none, messages start with the group and keep their order.
      character(*), intent(in) :: file
      type(error_type), allocatable, intent(inout) :: error
      character(:), allocatable :: text
      real(dp) :: place(self%count)
      integer :: order(self%count), i

      place = 0
      ! A file has at most 10 million columns; problems without a line come last.
      if (file /= '' .and. self%count > 0) place = merge(1e8_dp*self%list(:self%count)%line + self%list(:self%count)%column, &
                                                         huge(1.0_dp), self%list(:self%count)%line > 0)
      order = ascending(place)
      do i = 1, self%count
         call message(self%list(order(i)), file, text)
         call fatal(error, text)
      end do
      if (self%untold > 0) call fatal(error, 'and '//integer_text(self%untold)//' more')
   end subroutine raise

   !> The message of a problem with its place: 'file:line:column: error: &group: text'.
   pure subroutine message(problem, file, text)
      type(problem_type), intent(in) :: problem
      character(*), intent(in) :: file
      character(:), allocatable, intent(out) :: text

      text = escaped(problem%text)
      if (problem%group /= '' .and. .not. problem%names_group) then
         text = group_label(problem%group, problem%index)//': '//text
      end if
      if (file == '') return
      if (problem%line > 0) then
         text = escaped(file)//':'//integer_text(problem%line)//':'//integer_text(problem%column)//': error: '//text
      else
         text = escaped(file)//': error: '//text
      end if
   end subroutine message

   !> Whether a case may have several groups of this name.
   pure logical function is_numbered(group)
      character(*), intent(in) :: group

      is_numbered = any(group == parts_of_train)
   end function is_numbered

   !> Label of a group in messages: '&mesh 2', or '&train' where a case has only one group of this name.
   pure function group_label(group, index) result(text)
      !> Name of the group.
      character(*), intent(in) :: group
      !> Number of the group among the groups of its name.
      integer, intent(in) :: index
      character(1 + len_trim(group) + merge(1 + len(integer_text(index)), 0, is_numbered(group))) :: text

      text = '&'//trim(group)
      if (is_numbered(group)) text = '&'//trim(group)//' '//integer_text(index)
   end function group_label

end module geartrain_base_problems
