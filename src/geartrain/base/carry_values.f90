!> Carries values of one kind, in the order of memory, between an array and its field, see geartrain_base_fields.
module geartrain_base_carry_values
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
   use geartrain_base_field, only: field_type, kind_integer, kind_real, kind_text, text_type
   use geartrain_base_fields, only: arranging, fields_type, listing, reading
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: arrange, carry_integers, carry_reals, carry_texts

contains

   !> Real numbers.
   subroutine carry_reals(fields, about, extents, given, values, changed)
      class(fields_type), intent(inout) :: fields
      !> The row of the table.
      type(field_type), intent(in) :: about
      !> Shape of the array; set by reading.
      integer, intent(inout) :: extents(:)
      !> Values of the array. Absent: no field, or NaN where it is an item of a list and the lengths are known.
      real(dp), intent(in), optional :: given(*)
      !> Values read from a field.
      real(dp), allocatable, intent(out) :: values(:)
      !> Whether `values` and `extents` were read from a field.
      logical, intent(out) :: changed
      integer :: place, first, lengths(size(extents)), rows, width, i, n

      changed = .false.
      select case (fields%way)
      case (reading)
         call fields%take(about, kind_real, extents, place, first, n)
         if (n < 0) return
         values = fields%groups(fields%here)%fields(place)%reals(first + 1:first + n)
         if (about%none_is_negative) then
            where (ieee_is_nan(values)) values = -1
         else if (fields%along /= '' .and. size(extents) > 0) then
            call shorten(values, extents)
            if (product(extents) == 0) deallocate (values)
            if (product(extents) == 0) return
         end if
         changed = .true.
      case default
         if (.not. present(given) .and. fields%way /= listing) then
            if (fields%along == '' .or. any(fields%lengths_of(about, size(extents)) < 0)) return
         end if
         call fields%room_for(about, kind_real, extents, place, first, lengths)
         if (.not. present(given) .or. place == 0 .or. fields%way == listing) return
         n = product(lengths)
         rows = 1
         width = 1
         if (size(extents) > 0) then
            rows = lengths(1)
            width = extents(1)
         end if
         associate (all => fields%groups(fields%here)%fields(place)%reals(first + 1:first + n))
            if (rows == width) then
               n = min(n, product(extents))
               all(:n) = given(:n)
            else
               all = ieee_value(0.0_dp, ieee_quiet_nan)
               do i = 0, min(product(lengths(2:)), product(extents(2:))) - 1
                  all(i*rows + 1:i*rows + min(rows, width)) = given(i*width + 1:i*width + min(rows, width))
               end do
            end if
            if (about%none_is_negative) then
               where (all < 0) all = ieee_value(0.0_dp, ieee_quiet_nan)
            end if
         end associate
      end select
   end subroutine carry_reals

   !> Puts the last index of an array into another order; values that the array does not have are 0, those of further places of the
   !> last index are not set. Without an array the values of old places are NaN: a file from before the field was thought of.
   pure subroutine arrange(order, from, to, values, arranged)
      !> Old index of each place of the last index.
      integer, intent(in) :: order(:)
      !> Shape of the array; shape of the arranged array.
      integer, intent(in) :: from(:), to(:)
      !> The array; absent: none.
      real(dp), intent(in), optional :: values(*)
      !> The arranged array.
      real(dp), intent(inout) :: arranged(*)
      integer :: i, k, rows, columns, rank

      if (.not. present(values)) then
         arranged(:product(to)) = 0
         arranged(:product(to(:size(to) - 1))*size(order)) = ieee_value(0.0_dp, ieee_quiet_nan)
         return
      end if
      rank = size(to)
      rows = min(to(1), from(1))
      columns = product(to(2:rank - 1))
      if (rank == 1) then
         arranged(:size(order)) = values(order)
         return
      end if
      do k = 1, size(order)
         do i = 0, columns - 1
            associate (new => ((k - 1)*columns + i)*to(1), old => ((order(k) - 1)*columns + i)*from(1))
               arranged(new + 1:new + rows) = values(old + 1:old + rows)
               arranged(new + rows + 1:new + to(1)) = 0
            end associate
         end do
      end do
   end subroutine arrange

   !> Drops the places at the end of the first index where all values are NaN.
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

   !> Whole numbers, or logical values.
   subroutine carry_integers(fields, about, kind, extents, values, changed)
      class(fields_type), intent(inout) :: fields
      !> The row of the table.
      type(field_type), intent(in) :: about
      !> kind_integer, or kind_logical (values 0 and 1).
      character, intent(in) :: kind
      !> Shape of the array, a list for arranging; set by reading and arranging.
      integer, intent(inout) :: extents(:)
      !> Values of the array. Not allocated: no field.
      integer, allocatable, intent(inout) :: values(:)
      !> Whether `values` and `extents` are new: read from a field and in its range, or arranged.
      logical, intent(out) :: changed
      integer, allocatable :: arranged(:)
      integer :: place, first, lengths(size(extents)), n

      changed = fields%way == arranging
      select case (fields%way)
      case (arranging)
         extents = fields%lengths_of(about, size(extents))
         allocate (arranged(product(extents)), source=0)
         if (allocated(values)) arranged(:size(fields%order)) = values(fields%order)
         call move_alloc(arranged, values)
      case (reading)
         call fields%take(about, kind, extents, place, first, n)
         if (n < 0) return
         values = fields%groups(fields%here)%fields(place)%integers(first + 1:first + n)
         changed = all(values >= about%least .and. values <= about%most) .and. &
                   (kind == kind_integer .or. all(values == 0 .or. values == 1))
         call fields%check(changed, about%name)
      case default
         if (.not. allocated(values) .and. fields%way /= listing) return
         call fields%room_for(about, kind, extents, place, first, lengths)
         if (place == 0 .or. fields%way == listing) return
         n = product(lengths)
         fields%groups(fields%here)%fields(place)%integers(first + 1:first + n) = values(:n)
      end select
   end subroutine carry_integers

   !> Texts, which are not arranged.
   subroutine carry_texts(fields, about, extents, values, changed)
      class(fields_type), intent(inout) :: fields
      !> The row of the table.
      type(field_type), intent(in) :: about
      !> Shape of the array; set by reading.
      integer, intent(inout) :: extents(:)
      !> Values of the array. Not allocated: no field.
      type(text_type), allocatable, intent(inout) :: values(:)
      !> Whether `values` and `extents` were read from a field.
      logical, intent(out) :: changed
      integer :: place, first, lengths(size(extents)), i, n

      changed = .false.
      if (fields%way == reading) then
         call fields%take(about, kind_text, extents, place, first, n)
         if (n < 0) return
         values = fields%groups(fields%here)%fields(place)%texts(first + 1:first + n)
         changed = all([(allocated(values(i)%text), i=1, n)])
         call fields%check(changed, about%name)
         return
      end if
      if (.not. allocated(values) .and. fields%way /= listing) return
      call fields%room_for(about, kind_text, extents, place, first, lengths)
      if (place == 0 .or. fields%way == listing) return
      do i = 1, product(lengths)
         fields%groups(fields%here)%fields(place)%texts(first + i)%text = values(i)%text
      end do
   end subroutine carry_texts

end module geartrain_base_carry_values
