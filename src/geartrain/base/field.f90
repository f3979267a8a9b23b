!> A result by its name: the row that describes it, and its values as every reader and writer of results takes them.
module geartrain_base_field
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: field_type, group_type, groups_type, kind_integer, kind_logical, kind_real, kind_text, lengths_type, &
      text_type, values_type, word

   !> A row of the tables of fields (the modules `geartrain_*_fields`): all that is said of a result that is no number.
   type :: field_type
      character(24) :: name = ''
      !> In the order of the file, the last one varying fastest, separated by blanks; blank: an attribute of its group.
      character(40) :: dimensions = ''
      !> '1' for a dimensionless value; blank for text.
      character(8) :: unit = ''
      character(480) :: description = ''
      !> When it is there, in words that follow "Only"; blank: always.
      character(64) :: only = ''
      !> Whether results without it are whole.
      logical :: optional = .false.
      !> Range of the whole numbers that are taken back.
      integer :: least = -huge(0), most = huge(0)
      !> Whether a negative value stands for none, which is NaN outside of the program.
      logical :: none_is_negative = .false.
   end type field_type

   character, parameter :: kind_real = 'r', kind_integer = 'i', kind_logical = 'l', kind_text = 't'

   type :: text_type
      character(:), allocatable :: text
   end type text_type

   !> The values of a field. Complex numbers have one dimension more, `complex`: real and imaginary part.
   type :: values_type
      type(field_type) :: about
      character :: kind = ''
      !> Whether it numbers or names the places of the dimension of its own name.
      logical :: axis = .false.
      !> In the order of memory, the first one varying fastest, hence the reverse of the names of the dimensions.
      integer, allocatable :: extents(:)
      !> The one that belongs to `kind` is allocated, logical values as the integers 0 and 1.
      real(dp), allocatable :: reals(:)
      integer, allocatable :: integers(:)
      type(text_type), allocatable :: texts(:)
   end type values_type

   !> A group of fields: attributes and datasets, which may have a name in common.
   type :: group_type
      !> Absolute, such as /response/special_points.
      character(:), allocatable :: path
      character(160) :: description = ''
      integer :: count = 0
      type(values_type), allocatable :: fields(:)
   contains
      procedure :: place
      procedure :: add
   end type group_type

   !> The groups of a results file, those that hold others before them.
   type :: groups_type
      integer :: count = 0
      type(group_type), allocatable :: groups(:)
   contains
      procedure :: find_group
      procedure :: add_group
   end type groups_type

   !> How long dimensions are.
   type :: lengths_type
      integer, private :: known = 0
      character(24), private :: name(16) = ''
      integer, private :: length(16) = 0
   contains
      procedure :: set
      procedure :: of
   end type lengths_type

contains

   !> Length of a dimension, -1 where it is not known.
   pure integer function of(self, name) result(length)
      class(lengths_type), intent(in) :: self
      character(*), intent(in) :: name
      integer :: i

      length = -1
      do i = 1, self%known
         if (self%name(i) == name) length = self%length(i)
      end do
   end function of

   !> Sets how long a dimension is.
   pure subroutine set(self, name, length)
      class(lengths_type), intent(inout) :: self
      character(*), intent(in) :: name
      integer, intent(in) :: length
      integer :: i

      do i = 1, self%known
         if (self%name(i) == name) exit
      end do
      self%name(i) = name
      self%length(i) = length
      self%known = max(self%known, i)
   end subroutine set

   !> Number of the group of this path, 0 where there is none.
   pure integer function find_group(self, path) result(number)
      class(groups_type), intent(in) :: self
      character(*), intent(in) :: path

      do number = self%count, 1, -1
         if (self%groups(number)%path == path) return
      end do
   end function find_group

   !> Makes room for one group more, which is the last one then.
   subroutine add_group(self, path, description)
      class(groups_type), intent(inout) :: self
      character(*), intent(in) :: path, description
      type(group_type), allocatable :: longer(:)
      integer :: i

      if (.not. allocated(self%groups)) allocate (self%groups(16))
      if (self%count == size(self%groups)) then
         allocate (longer(2*self%count))
         do i = 1, self%count
            call move_alloc(self%groups(i)%path, longer(i)%path)
            longer(i)%description = self%groups(i)%description
            longer(i)%count = self%groups(i)%count
            call move_alloc(self%groups(i)%fields, longer(i)%fields)
         end do
         call move_alloc(longer, self%groups)
      end if
      self%count = self%count + 1
      self%groups(self%count)%path = path
      self%groups(self%count)%description = description
   end subroutine add_group

   !> Number of the field, 0 where there is none; `guess` is tried first.
   pure integer function place(self, name, attribute, guess)
      class(group_type), intent(in) :: self
      character(*), intent(in) :: name
      logical, intent(in) :: attribute
      integer, intent(in) :: guess
      integer :: i

      place = 0
      if (guess >= 1 .and. guess <= self%count) then
         if (fits(guess)) place = guess
      end if
      if (place > 0) return
      do i = 1, self%count
         if (.not. fits(i)) cycle
         place = i
         return
      end do

   contains

      pure logical function fits(i)
         integer, intent(in) :: i

         fits = self%fields(i)%about%name == name .and. (self%fields(i)%about%dimensions == '' .eqv. attribute)
      end function fits

   end function place

   !> Makes room for one field more, which is the last one then.
   subroutine add(self, about, kind, extents)
      class(group_type), intent(inout) :: self
      type(field_type), intent(in) :: about
      character, intent(in) :: kind
      integer, intent(in) :: extents(:)
      type(values_type), allocatable :: longer(:)
      integer :: i

      if (.not. allocated(self%fields)) allocate (self%fields(32))
      if (self%count == size(self%fields)) then
         allocate (longer(2*self%count))
         do i = 1, self%count
            call move_values(self%fields(i), longer(i))
         end do
         call move_alloc(longer, self%fields)
      end if
      self%count = self%count + 1
      associate (new => self%fields(self%count))
         new%about = about
         new%kind = kind
         new%extents = extents
         select case (kind)
         case (kind_real)
            allocate (new%reals(product(extents)), source=0.0_dp)
         case (kind_text)
            allocate (new%texts(product(extents)))
         case default
            allocate (new%integers(product(extents)), source=0)
         end select
      end associate
   end subroutine add

   subroutine move_values(from, to)
      type(values_type), intent(inout) :: from, to

      to%about = from%about
      to%kind = from%kind
      to%axis = from%axis
      call move_alloc(from%extents, to%extents)
      call move_alloc(from%reals, to%reals)
      call move_alloc(from%integers, to%integers)
      call move_alloc(from%texts, to%texts)
   end subroutine move_values

   !> Word number n of a text, words being parted by single blanks.
   pure character(24) function word(text, n)
      character(*), intent(in) :: text
      integer, intent(in) :: n
      integer :: i, first, next

      first = 1
      do i = 1, n - 1
         first = first + index(text(first:), ' ')
      end do
      next = index(text(first:)//' ', ' ')
      word = text(first:first + next - 2)
   end function word

end module geartrain_base_field
