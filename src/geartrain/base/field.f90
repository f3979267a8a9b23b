!> A field: a result with its name, the row that describes it, and its values as all readers and writers of results take them.
module geartrain_base_field
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: field_type, group_type, groups_type, kind_integer, kind_logical, kind_real, kind_text, lengths_type, &
      text_type, values_type, word

   !> A row of the tables of fields (the modules `geartrain_*_fields`).
   type :: field_type
      !> Name of the dataset, or of the attribute.
      character(24) :: name = ''
      !> Dimensions in the order of the file, the last varying fastest, separated by blanks; blank: an attribute of its group.
      character(40) :: dimensions = ''
      !> '1' for a dimensionless value; blank for text.
      character(12) :: unit = ''
      !> Meaning, as the file and the reference page tell it.
      character(480) :: description = ''
      !> When the field exists, in words that follow "Only"; blank: always.
      character(64) :: only = ''
      !> A file may lack the field.
      logical :: optional = .false.
      !> Smallest and largest whole number that is accepted from a file.
      integer :: least = -huge(0), most = huge(0)
      !> A negative value means none, and is NaN in the field.
      logical :: none_is_negative = .false.
   end type field_type

   !> Kinds of values.
   character, parameter :: kind_real = 'r', kind_integer = 'i', kind_logical = 'l', kind_text = 't'

   !> An element of a list of texts of different lengths.
   type :: text_type
      character(:), allocatable :: text
   end type text_type

   !> A field with its values. Complex numbers have the further dimension `complex`: real and imaginary part.
   type :: values_type
      !> The row of the table.
      type(field_type) :: about
      !> One of kind_real, kind_integer, kind_logical, kind_text.
      character :: kind = ''
      !> The field is an axis: it numbers or names the places of the dimension of the same name.
      logical :: axis = .false.
      !> Lengths of the dimensions in the order of memory, the first varying fastest: the reverse of `about%dimensions`.
      integer, allocatable :: extents(:)
      !> Values in the order of memory; only the array of this `kind` is allocated. Logical values are the integers 0 and 1.
      real(dp), allocatable :: reals(:)
      integer, allocatable :: integers(:)
      type(text_type), allocatable :: texts(:)
   end type values_type

   !> A group of fields: attributes and datasets; an attribute and a dataset may have equal names.
   type :: group_type
      !> Absolute path in the file, such as /response/special_points.
      character(:), allocatable :: path
      !> Meaning, as the file tells it.
      character(160) :: description = ''
      !> Number of fields.
      integer :: count = 0
      !> The first `count` elements are in use.
      type(values_type), allocatable :: fields(:)
   contains
      procedure :: place
      procedure :: add
   end type group_type

   !> The groups of a results file; a group stands before the groups inside it.
   type :: groups_type
      !> Number of groups.
      integer :: count = 0
      !> The first `count` elements are in use.
      type(group_type), allocatable :: groups(:)
   contains
      procedure :: find_group
      procedure :: add_group
   end type groups_type

   !> Lengths of dimensions by their names.
   type :: lengths_type
      character(24), allocatable, private :: name(:)
      integer, allocatable, private :: length(:)
      !> The first `count` elements are in use.
      integer, private :: count = 0
   contains
      procedure :: set
      procedure :: of
   end type lengths_type

contains

   !> Length of a dimension; -1: not known.
   pure integer function of(self, name) result(length)
      class(lengths_type), intent(in) :: self
      !> Name of the dimension.
      character(*), intent(in) :: name
      integer :: i

      length = -1
      if (.not. allocated(self%name)) return
      i = findloc(self%name(:self%count), name, 1)
      if (i > 0) length = self%length(i)
   end function of

   !> Sets the length of a dimension.
   pure subroutine set(self, name, length)
      class(lengths_type), intent(inout) :: self
      !> Name of the dimension.
      character(*), intent(in) :: name
      !> Number of places of the dimension.
      integer, intent(in) :: length
      integer :: i

      if (.not. allocated(self%name)) allocate (self%name(16), self%length(16))
      i = findloc(self%name(:self%count), name, 1)
      if (i == 0) then
         if (self%count == size(self%name)) then
            self%name = [self%name, self%name]
            self%length = [self%length, self%length]
         end if
         self%count = self%count + 1
         i = self%count
         self%name(i) = name
      end if
      self%length(i) = length
   end subroutine set

   !> Number of the group of this path; 0: none.
   pure integer function find_group(self, path) result(number)
      class(groups_type), intent(in) :: self
      !> Absolute path in the file.
      character(*), intent(in) :: path

      do number = self%count, 1, -1
         if (self%groups(number)%path == path) return
      end do
   end function find_group

   !> Adds an empty group at the end.
   subroutine add_group(self, path, description)
      class(groups_type), intent(inout) :: self
      !> Absolute path in the file; meaning, as the file tells it.
      character(*), intent(in) :: path, description
      type(group_type), allocatable :: longer(:)
      integer :: i

      if (.not. allocated(self%groups)) allocate (self%groups(16))
      if (self%count == size(self%groups)) then
         ! The components are moved: a copy would double the memory of large results.
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

   !> Number of a field in the group; 0: none.
   pure integer function place(self, name, attribute, guess)
      class(group_type), intent(in) :: self
      !> Name of the field.
      character(*), intent(in) :: name
      !> Whether an attribute is looked for, else a dataset.
      logical, intent(in) :: attribute
      !> Number that is tried first, any integer.
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

   !> Adds a field at the end, with the values 0.
   subroutine add(self, about, kind, extents, status)
      class(group_type), intent(inout) :: self
      !> The row of the table.
      type(field_type), intent(in) :: about
      !> One of kind_real, kind_integer, kind_logical, kind_text.
      character, intent(in) :: kind
      !> Lengths of the dimensions in the order of memory; none for a scalar.
      integer, intent(in) :: extents(:)
      !> Not 0: there is no memory for the values, and no field is added. Absent: the memory was asked for before.
      integer, intent(out), optional :: status
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
         if (present(status)) then
            select case (kind)
            case (kind_real)
               allocate (new%reals(product(extents)), source=0.0_dp, stat=status)
            case (kind_text)
               allocate (new%texts(product(extents)), stat=status)
            case default
               allocate (new%integers(product(extents)), source=0, stat=status)
            end select
            if (status /= 0) self%count = self%count - 1
            return
         end if
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

   !> Moves a field without a copy of its values.
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

   !> Word number n of a text whose words are separated by single blanks.
   pure character(24) function word(text, n)
      !> At least n words.
      character(*), intent(in) :: text
      !> Number of the word, from 1.
      integer, intent(in) :: n
      integer :: i, first, next

      first = 1
      do i = 1, n - 1
         first = first + index(text(first:), ' ')
      end do
      next = index(text(first:), ' ')
      if (next == 0) next = len(text) - first + 2
      word = text(first:first + next - 2)
   end function word

end module geartrain_base_field
