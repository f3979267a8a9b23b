!> Results as fields by name, and back. One routine for each type of result (`visit_NAME` in the modules `geartrain_*_fields`) goes
!> over its components with `carry`, which takes a row that describes the field and the component that holds it. The results file,
!> the checkpoint, reading either back, the arrays of Python and the reference page all come of these routines.
!>
!> A type has groups; `enter` begins one. Its axes come first, since they say how long the dimensions are: arrays that have room to
!> spare in the last index are cut, arrays that are shorter in the first index filled with NaN.
module geartrain_base_fields
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
   use geartrain_base_field, only: field_type, groups_type, kind_integer, kind_logical, kind_real, kind_text, &
      lengths_type, text_type, word
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: arranging, fields_type, listing, reading, writing

   !> What `carry` does: makes fields of results; makes results of fields; notes every field that there can be, without values; or,
   !> without any fields, gives each array the lengths that are expected of its dimensions and the last index the order `order`.
   integer, parameter :: writing = 0, reading = 1, listing = 2, arranging = 3

   type, extends(groups_type) :: fields_type
      integer :: way = writing
      !> The first thing found that does not fit; not allocated while all does.
      character(:), allocatable :: wrong
      !> Arranging: where in the last dimension the values were that come first, second, ...; beyond these there is 0.
      integer, allocatable :: order(:)
      !> The group that is visited, and the field of it that is probably the next.
      integer, private :: here = 0, next = 0
      !> Lengths of the dimensions of the group; and of those that are to be the same in every group.
      type(lengths_type), private :: lengths, expected
      !> Where a list is visited item by item: the dimension along it, how many there are, and which is visited; '' and 0 elsewhere.
      character(24), private :: along = ''
      integer, private :: items = 0, item = 0
   contains
      procedure :: expect
      procedure :: enter
      procedure :: has
      procedure :: derives
      procedure :: describe
      procedure :: index_axis
      procedure :: text_axis
      procedure :: length_of
      procedure :: lengths_of
      procedure :: begin_list
      procedure :: visit_item
      procedure :: end_list
      procedure :: check
      procedure :: carry_reals
      procedure :: carry_integers
      procedure :: carry_texts
      procedure, private :: find, room_for, say_length
   end type fields_type

contains

   !> Says how long a dimension is in every group that has it and more than nothing in it.
   subroutine expect(self, name, length)
      class(fields_type), intent(inout) :: self
      character(*), intent(in) :: name
      integer, intent(in) :: length

      call self%expected%set(name, length)
      call self%lengths%set(name, length)
   end subroutine expect

   !> Enters a group; false where there is nothing of it: writing where `there` is false, reading where it is not among the fields.
   logical function enter(self, path, description, there)
      class(fields_type), intent(inout) :: self
      character(*), intent(in) :: path, description
      logical, intent(in) :: there

      self%lengths = self%expected
      self%next = 1
      self%here = 0
      if (self%way == reading) then
         self%here = self%find_group(path)
      else if (there .or. self%way == listing) then
         call self%add_group(path, description)
         self%here = self%count
      end if
      enter = self%here > 0 .and. .not. allocated(self%wrong)
   end function enter

   !> Whether a field that not all results have is to be visited: writing where `there` is true, reading where it is found.
   logical function has(self, name, there)
      class(fields_type), intent(inout) :: self
      character(*), intent(in) :: name
      logical, intent(in) :: there

      has = there .or. self%way == listing
      if (self%way == reading) has = self%groups(self%here)%place(name, .false., self%next) > 0
   end function has

   !> Whether values are visited that others tell, which are not taken back.
   pure logical function derives(self)
      class(fields_type), intent(in) :: self

      derives = self%way == writing .or. self%way == listing
   end function derives

   !> A text attribute of the group that is not taken back.
   subroutine describe(self, name, text)
      class(fields_type), intent(inout) :: self
      character(*), intent(in) :: name, text

      if (self%way /= writing) return
      associate (group => self%groups(self%here))
         call group%add(field_type(name), kind_text, [integer ::])
         group%fields(group%count)%texts(1)%text = text
      end associate
   end subroutine describe

   !> A dimension whose places are numbered from 1; `length` is how many there are.
   subroutine index_axis(self, name, length, description)
      class(fields_type), intent(inout) :: self
      character(*), intent(in) :: name, description
      integer, intent(inout) :: length
      integer :: i, place

      if (self%way == reading) then
         place = self%find(field_type(name, name))
         if (place == 0) return
         length = product(self%groups(self%here)%fields(place)%extents)
         call self%say_length(name, length)
         return
      end if
      if (self%way == arranging .and. self%length_of(name) >= 0) return
      call self%say_length(name, length)
      if (self%way == arranging) return
      associate (group => self%groups(self%here))
         call group%add(field_type(name, name, '1', description), kind_integer, [merge(0, length, self%way == listing)])
         group%fields(group%count)%axis = .true.
         if (self%way == writing) group%fields(group%count)%integers = [(i, i=1, length)]
      end associate
   end subroutine index_axis

   !> A dimension whose places have labels, which are not taken back.
   subroutine text_axis(self, name, labels, description)
      class(fields_type), intent(inout) :: self
      character(*), intent(in) :: name, labels(:), description
      integer :: i

      if (.not. self%derives()) return
      call self%say_length(name, size(labels))
      associate (group => self%groups(self%here))
         call group%add(field_type(name, name, '', description), kind_text, [merge(0, size(labels), self%way == listing)])
         group%fields(group%count)%axis = .true.
         do i = 1, size(group%fields(group%count)%texts)
            group%fields(group%count)%texts(i)%text = trim(labels(i))
         end do
      end associate
   end subroutine text_axis

   !> Sets how long a dimension of this group is.
   subroutine say_length(self, name, length)
      class(fields_type), intent(inout) :: self
      character(*), intent(in) :: name
      integer, intent(in) :: length

      if (self%expected%of(name) >= 0 .and. length > 0) call self%check(self%expected%of(name) == length, name)
      call self%lengths%set(name, length)
   end subroutine say_length

   !> Length of a dimension, -1 where it is not known.
   pure integer function length_of(self, name) result(length)
      class(fields_type), intent(in) :: self
      character(*), intent(in) :: name

      length = self%lengths%of(name)
   end function length_of

   !> Lengths of the dimensions of a field in the order of memory.
   pure function lengths_of(self, about, rank) result(lengths)
      class(fields_type), intent(in) :: self
      type(field_type), intent(in) :: about
      integer, intent(in) :: rank
      integer :: lengths(rank), k

      lengths = [(self%length_of(word(about%dimensions, rank + 1 - k)), k=1, rank)]
   end function lengths_of

   !> From here on the fields are those of the items of a list, which `visit_item` tells one by one, each with the dimension `along`
   !> before its own ones.
   subroutine begin_list(self, along)
      class(fields_type), intent(inout) :: self
      character(*), intent(in) :: along

      self%along = along
      self%items = max(0, self%length_of(along))
      if (self%way == listing) self%items = 1
   end subroutine begin_list

   subroutine visit_item(self, item)
      class(fields_type), intent(inout) :: self
      integer, intent(in) :: item

      self%item = item
   end subroutine visit_item

   subroutine end_list(self)
      class(fields_type), intent(inout) :: self

      self%along = ''
   end subroutine end_list

   !> Keeps the name of the first thing read that does not fit.
   subroutine check(self, fits, name)
      class(fields_type), intent(inout) :: self
      logical, intent(in) :: fits
      character(*), intent(in) :: name

      if (fits .or. self%way /= reading .or. allocated(self%wrong)) return
      self%wrong = trim(name)
      if (self%here > 0) self%wrong = self%groups(self%here)%path//'/'//self%wrong
   end subroutine check

   !> Number of a field in the group that is read, 0 where it is not there; what is not optional is missed then.
   integer function find(self, about) result(place)
      class(fields_type), intent(inout) :: self
      type(field_type), intent(in) :: about

      place = 0
      if (allocated(self%wrong)) return
      place = self%groups(self%here)%place(about%name, about%dimensions == '' .and. self%along == '', self%next)
      self%next = place + 1
      call self%check(place > 0 .or. about%optional, about%name)
   end function find

   !> Finds or makes the field that values of these extents go to, and where in it: they are item `first`/size of it.
   subroutine room_for(self, about, kind, extents, place, first, lengths)
      class(fields_type), intent(inout) :: self
      type(field_type), intent(in) :: about
      character, intent(in) :: kind
      integer, intent(in) :: extents(:)
      integer, intent(out) :: place, first
      !> Extents of the room.
      integer, intent(out) :: lengths(size(extents))
      type(field_type) :: full
      integer :: k, length
      character(24) :: name

      do k = 1, size(extents)
         name = word(about%dimensions, size(extents) + 1 - k)
         length = self%length_of(name)
         if (self%way == listing) length = 0
         if (length < 0) length = extents(k)
         call self%say_length(name, length)
         lengths(k) = length
      end do
      place = 0
      if (self%along /= '') place = self%groups(self%here)%place(about%name, .false., self%next)
      if (place == 0) then
         full = about
         if (self%along /= '') full%dimensions = trim(self%along)//' '//about%dimensions
         associate (group => self%groups(self%here))
            if (self%along == '') then
               call group%add(full, kind, lengths)
            else
               call group%add(full, kind, [lengths, self%items])
               if (kind == kind_real) group%fields(group%count)%reals = ieee_value(0.0_dp, ieee_quiet_nan)
            end if
            place = group%count
            group%fields(place)%axis = full%dimensions == full%name
         end associate
      end if
      self%next = place + 1
      first = 0
      if (self%along /= '') first = (self%item - 1)*product(lengths)
   end subroutine room_for

   !> Carries real numbers in the order of memory.
   subroutine carry_reals(self, about, extents, values, found)
      class(fields_type), intent(inout) :: self
      type(field_type), intent(in) :: about
      !> Of the array; of what was found.
      integer, intent(inout) :: extents(:)
      !> Not allocated: none, which is NaN in a list of known lengths.
      real(dp), allocatable, intent(inout) :: values(:)
      !> Whether `values` are those of a field; writing is none.
      logical, intent(out) :: found
      integer :: place, first, lengths(size(extents)), short, i, n

      found = .false.
      if (self%way == reading) then
         place = self%find(about)
         if (place == 0) return
         call take(self, about, place, kind_real, extents, first, n)
         if (n < 0) return
         values = self%groups(self%here)%fields(place)%reals(first + 1:first + n)
         if (about%none_is_negative) then
            where (ieee_is_nan(values)) values = -1
         else if (self%along /= '' .and. size(extents) > 0) then
            call shorten(values, extents)
            if (product(extents) == 0) deallocate (values)
            if (product(extents) == 0) return
         end if
         found = .true.
         return
      end if
      if (.not. allocated(values) .and. self%way == writing) then
         if (self%along == '' .or. any(self%lengths_of(about, size(extents)) < 0)) return
         call self%room_for(about, kind_real, extents, place, first, lengths)
         return
      end if
      call self%room_for(about, kind_real, extents, place, first, lengths)
      if (self%way == listing) return
      associate (all => self%groups(self%here)%fields(place)%reals)
         n = product(lengths)
         short = min(n, product(extents))
         if (size(extents) == 0) then
            all(first + 1) = values(1)
         else if (lengths(1) == extents(1)) then
            all(first + 1:first + short) = values(:short)
         else
            short = min(lengths(1), extents(1))
            all(first + 1:first + n) = ieee_value(0.0_dp, ieee_quiet_nan)
            do i = 0, min(product(lengths(2:)), product(extents(2:))) - 1
               all(first + i*lengths(1) + 1:first + i*lengths(1) + short) = values(i*extents(1) + 1:i*extents(1) + short)
            end do
         end if
         if (about%none_is_negative) then
            do i = first + 1, first + n
               if (all(i) < 0) all(i) = ieee_value(0.0_dp, ieee_quiet_nan)
            end do
         end if
      end associate
   end subroutine carry_reals

   !> Drops what is NaN in the first index throughout, at its end.
   pure subroutine shorten(values, extents)
      real(dp), allocatable, intent(inout) :: values(:)
      integer, intent(inout) :: extents(:)
      integer :: i, k, last

      associate (n => extents(1))
         do last = n, 1, -1
            if (.not. all(ieee_is_nan(values(last::n)))) exit
         end do
         if (last < n) values = [((values((k - 1)*n + i), i=1, last), k=1, product(extents(2:)))]
      end associate
      extents(1) = last
   end subroutine shorten

   !> Carries whole numbers, likewise; those of a list are one an item.
   subroutine carry_integers(self, about, kind, extents, values, found)
      class(fields_type), intent(inout) :: self
      type(field_type), intent(in) :: about
      !> Of numbers or of logical values, 0 and 1.
      character, intent(in) :: kind
      integer, intent(inout) :: extents(:)
      integer, allocatable, intent(inout) :: values(:)
      logical, intent(out) :: found
      integer :: place, first, lengths(size(extents)), n

      found = .false.
      if (self%way == reading) then
         place = self%find(about)
         if (place == 0) return
         call take(self, about, place, kind, extents, first, n)
         if (n < 0) return
         values = self%groups(self%here)%fields(place)%integers(first + 1:first + n)
         found = all(values >= about%least .and. values <= about%most) .and. &
                 (kind == kind_integer .or. all(values == 0 .or. values == 1))
         call self%check(found, about%name)
         return
      end if
      if (.not. allocated(values) .and. self%way == writing) return
      call self%room_for(about, kind, extents, place, first, lengths)
      if (self%way == listing) return
      n = product(lengths)
      self%groups(self%here)%fields(place)%integers(first + 1:first + n) = values(:n)
   end subroutine carry_integers

   !> Carries texts, likewise.
   subroutine carry_texts(self, about, extents, values, found)
      class(fields_type), intent(inout) :: self
      type(field_type), intent(in) :: about
      integer, intent(inout) :: extents(:)
      type(text_type), allocatable, intent(inout) :: values(:)
      logical, intent(out) :: found
      integer :: place, first, lengths(size(extents)), i, n

      found = .false.
      if (self%way == reading) then
         place = self%find(about)
         if (place == 0) return
         call take(self, about, place, kind_text, extents, first, n)
         if (n < 0) return
         values = self%groups(self%here)%fields(place)%texts(first + 1:first + n)
         found = all([(allocated(values(i)%text), i=1, n)])
         call self%check(found, about%name)
         return
      end if
      if (.not. allocated(values) .and. self%way == writing) return
      call self%room_for(about, kind_text, extents, place, first, lengths)
      if (self%way == listing) return
      do i = 1, product(lengths)
         self%groups(self%here)%fields(place)%texts(first + i)%text = values(i)%text
      end do
   end subroutine carry_texts

   !> Where in a field its values or those of the item visited are: the n after the first ones; n is -1 where the field is no such
   !> one.
   subroutine take(self, about, place, kind, extents, first, n)
      class(fields_type), intent(inout) :: self
      type(field_type), intent(in) :: about
      integer, intent(in) :: place
      character, intent(in) :: kind
      integer, intent(out) :: extents(:), first, n
      integer :: k, length, rank
      logical :: fits

      n = -1
      first = 0
      associate (field => self%groups(self%here)%fields(place))
         rank = size(extents)
         fits = (field%kind == kind .or. field%kind == kind_integer .and. kind == kind_logical .and. about%dimensions == '') .and. &
                size(field%extents) == rank + merge(1, 0, self%along /= '')
         if (fits .and. self%along /= '') fits = field%extents(rank + 1) == self%items .and. self%item <= self%items
         if (fits) then
            do k = 1, rank
               extents(k) = field%extents(k)
               length = self%length_of(word(about%dimensions, rank + 1 - k))
               if (length < 0) call self%say_length(word(about%dimensions, rank + 1 - k), extents(k))
               fits = fits .and. (length < 0 .or. length == extents(k)) .and. extents(k) >= 0
            end do
         end if
         call self%check(fits, about%name)
         if (.not. fits) return
         n = product(extents)
         if (self%along /= '') first = (self%item - 1)*n
         ! A field put together by hand may be shorter than it says.
         if (kind == kind_real) fits = size(field%reals) >= first + n
         if (kind == kind_integer .or. kind == kind_logical) fits = size(field%integers) >= first + n
         if (kind == kind_text) fits = size(field%texts) >= first + n
         call self%check(fits, about%name)
         if (.not. fits) n = -1
      end associate
   end subroutine take

end module geartrain_base_fields
