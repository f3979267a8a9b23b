!> A list of what is wrong with the input, so that all of it is told at once, in the order of the file.
module geartrain_base_problems
   use geartrain_base_error, only: error_type, fatal
   use geartrain_base_numbers, only: integer_text
   use geartrain_base_variable, only: is_utf_8
   implicit none (type, external)
   private
   public :: problems_type, group_label

   type :: problem_type
      !> Group, its number among its kind, and the variable that it is about; blank and 0 where there is none.
      character(16) :: group = ''
      integer :: index = 0
      character(64) :: name = ''
      !> Which of its values, in a list; 0: all of them.
      integer :: place = 0
      !> Place in the file; 0 where it has none.
      integer :: line = 0, column = 0
      !> The text names its group by itself.
      logical :: names_group = .false.
      character(:), allocatable :: text
   end type problem_type

   !> Further ones are counted alone.
   integer, parameter :: most_told = 200

   type :: problems_type
      integer :: count = 0, untold = 0
      type(problem_type), allocatable :: list(:)
   contains
      procedure :: add
      procedure :: reported
      procedure :: in_group
      procedure :: raise
   end type problems_type

contains

   subroutine add(self, text, group, index, name, line, column, names_group, place)
      class(problems_type), intent(inout) :: self
      character(*), intent(in) :: text
      character(*), intent(in), optional :: group, name
      integer, intent(in), optional :: index, line, column, place
      logical, intent(in), optional :: names_group
      type(problem_type), allocatable :: longer(:)
      integer :: i

      if (self%count == most_told) then
         self%untold = self%untold + 1
         return
      end if
      if (.not. allocated(self%list)) allocate (self%list(8))
      if (self%count == size(self%list)) then
         allocate (longer(2*self%count))
         do i = 1, self%count
            longer(i) = self%list(i)
         end do
         call move_alloc(longer, self%list)
      end if
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

   !> There is a problem with this variable already: what follows from it need not be told.
   pure logical function reported(self, group, index, name)
      class(problems_type), intent(in) :: self
      character(*), intent(in) :: group, name
      integer, intent(in) :: index
      integer :: i

      reported = .false.
      do i = 1, self%count
         reported = self%list(i)%group == group .and. self%list(i)%index == index .and. self%list(i)%name == name
         if (reported) return
      end do
   end function reported

   !> There is a problem with a group of this name already.
   pure logical function in_group(self, group)
      class(problems_type), intent(in) :: self
      character(*), intent(in) :: group
      integer :: i

      in_group = any([(self%list(i)%group == group, i = 1, self%count)])
   end function in_group

   !> Makes the error that tells all problems, one a line; none, no error.
   subroutine raise(self, file, error)
      class(problems_type), intent(in) :: self
      !> What messages call the file; '' where there is none: they then start with the group.
      character(*), intent(in) :: file
      type(error_type), allocatable, intent(inout) :: error
      character(:), allocatable :: text
      integer :: order(self%count), i, j, moving

      do i = 1, self%count
         order(i) = i
         if (file == '') cycle
         do j = i - 1, 1, -1
            if (.not. before(self%list(order(j + 1)), self%list(order(j)))) exit
            moving = order(j)
            order(j) = order(j + 1)
            order(j + 1) = moving
         end do
      end do
      do i = 1, self%count
         call message(self%list(order(i)), file, text)
         call fatal(error, text)
      end do
      if (self%untold > 0) call fatal(error, 'and '//integer_text(self%untold)//' more')
   end subroutine raise

   !> The order of the file; what has no place comes last.
   pure logical function before(a, b)
      type(problem_type), intent(in) :: a, b

      if (a%line == 0 .or. b%line == 0) then
         before = a%line > 0 .and. b%line == 0
      else if (a%line /= b%line) then
         before = a%line < b%line
      else
         before = a%column < b%column
      end if
   end function before

   !> The text with a question mark for each byte beyond ASCII where it is not UTF-8, as values of a file in another code are.
   pure function readable(text) result(whole)
      character(*), intent(in) :: text
      character(len(text)) :: whole
      integer :: i

      whole = text
      if (is_utf_8(text)) return
      do i = 1, len(text)
         if (iachar(text(i:i)) >= 128) whole(i:i) = '?'
      end do
   end function readable

   pure subroutine message(problem, file, text)
      type(problem_type), intent(in) :: problem
      character(*), intent(in) :: file
      character(:), allocatable, intent(out) :: text

      text = readable(problem%text)
      if (problem%group /= '' .and. .not. problem%names_group) then
         text = group_label(problem%group, problem%index)//': '//text
      end if
      if (file == '') return
      if (problem%line > 0) then
         text = file//':'//integer_text(problem%line)//':'//integer_text(problem%column)//': error: '//text
      else
         text = file//': error: '//text
      end if
   end subroutine message

   !> Groups that stand several times.
   pure logical function is_numbered(group)
      character(*), intent(in) :: group

      is_numbered = group == 'shaft' .or. group == 'mesh'
   end function is_numbered

   !> '&mesh 2', or '&train' for a group that stands once.
   pure function group_label(group, index) result(text)
      character(*), intent(in) :: group
      integer, intent(in) :: index
      character(1 + len_trim(group) + merge(1 + len(integer_text(index)), 0, is_numbered(group))) :: text

      text = '&'//trim(group)
      if (is_numbered(group)) text = '&'//trim(group)//' '//integer_text(index)
   end function group_label

end module geartrain_base_problems
