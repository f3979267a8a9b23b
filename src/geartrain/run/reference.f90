!> Lists every field that a results file can hold, for the reference page of the output and for readers that look fields up.
module geartrain_run_reference
   use geartrain_analyses_list, only: case_type, results_type
   use geartrain_base_field, only: field_type, group_type, kind_integer, values_type
   use geartrain_base_fields, only: fields_type, listing
   use geartrain_input_text, only: add_cell
   use geartrain_run_results, only: visit_results, visit_root
   implicit none (type, external)
   private
   public :: list_results, output_reference

   character(*), parameter :: newline = new_line('a')
   !> Groups whose items are motions.
   character(*), parameter :: of_motions(4) = [character(12) :: '/response', '/integration', '/attractors', '/basins']
   !> Datasets that stand beside others in every group: the page says beside which.
   character(*), parameter :: companions(*) = [character(24) :: 'mesh_label', 'shaft_label', 'held_label', 'coupling_label', &
      'complex', 'speed', 'fundamental_frequency', 'speed_from', 'speed_to', 'ended_places']
   !> Description of an attribute that the page states for all groups.
   character(*), parameter :: of_all = 'why it ended, in words'
   !> Tables that describe a field, see share_of.
   integer, parameter :: own = 0, motions = 1, common = 2

contains

   !> Lists all groups with their fields, without values.
   subroutine list_results(fields)
      !> The fields; empty on entry.
      type(fields_type), intent(inout) :: fields
      type(results_type) :: results
      type(case_type) :: case

      allocate (case%train%shafts(0), case%train%meshes(0))
      fields%way = listing
      call visit_root(case, fields)
      call visit_results(results, case, fields, summary=.true.)
   end subroutine list_results

   !> Writes the tables of docs/output.md: datasets that many groups have, datasets of motions, then the rest of each group.
   subroutine output_reference(text)
      !> Markdown.
      character(:), allocatable, intent(out) :: text
      type(fields_type) :: fields
      integer :: i

      call list_results(fields)
      text = ''
      call add_common(fields, text)
      call add_motions(fields, text)
      do i = 1, fields%count
         call add_group(fields, i, text)
      end do
   end subroutine output_reference

   !> Adds the table of the datasets that many groups have.
   subroutine add_common(fields, text)
      class(fields_type), intent(in) :: fields
      character(:), allocatable, intent(inout) :: text
      integer :: i, j

      text = text//'### Datasets of many groups'//newline//newline//'| Dataset | Unit | What |'//newline//'|---|---|---|'//newline
      do i = 1, fields%count
         do j = 1, fields%groups(i)%count
            associate (field => fields%groups(i)%fields(j))
               if (share_of(fields, i, j) /= common .or. has_before(fields, i, field, motions_only=.false.)) cycle
               text = text//'| `'//trim(field%about%name)//'` |'
               call add_unit(field%about%unit, text)
               text = text//' '
               call add_meaning(field%about, text)
               text = text//' |'//newline
            end associate
         end do
      end do
   end subroutine add_common

   !> Adds the table of the datasets of motions, with a column for each group that holds motions.
   subroutine add_motions(fields, text)
      class(fields_type), intent(in) :: fields
      character(:), allocatable, intent(inout) :: text
      integer :: i, j, k, group

      text = text//newline//'### Datasets of motions'//newline//newline//'| Dataset | Dimensions | Unit | What |'
      do k = 1, size(of_motions)
         text = text//' `'//trim(of_motions(k))//'` |'
      end do
      text = text//newline//'|---|---|---|---|'//repeat('---|', size(of_motions))//newline
      do i = 1, fields%count
         do j = 1, fields%groups(i)%count
            associate (field => fields%groups(i)%fields(j))
               if (share_of(fields, i, j) /= motions .or. has_before(fields, i, field, motions_only=.true.)) cycle
               call add_row(field%about, as_points(field%about%dimensions), text)
               do k = 1, size(of_motions)
                  group = fields%find_group(trim(of_motions(k)))
                  text = text//trim(merge('x|', '| ', has(fields%groups(group), field)))
               end do
               text = text//newline
            end associate
         end do
      end do
   end subroutine add_motions

   !> Adds the section of a group: its description, the names of its shared datasets, its own datasets and its attributes.
   subroutine add_group(fields, number, text)
      class(fields_type), intent(in) :: fields
      !> Number of the group.
      integer, intent(in) :: number
      character(:), allocatable, intent(inout) :: text
      character(:), allocatable :: rows, attributes
      integer :: i

      associate (group => fields%groups(number))
         text = text//newline//'### `'//group%path//'`'//newline
         if (group%description /= '') then
            text = text//newline
            call add_with(capital(trim(group%description)), '|', '\|', text)
            text = text//'.'
            call add_names(fields, number, text)
            text = text//newline
         end if
         rows = ''
         attributes = ''
         do i = 1, group%count
            associate (about => group%fields(i)%about)
               if (about%dimensions == '') then
                  if (any(companions == about%name) .or. about%description == of_all) cycle
                  attributes = attributes//'- `'//trim(about%name)//'`'
                  if (about%unit /= '' .and. about%unit /= '1') attributes = attributes//' ['//trim(about%unit)//']'
                  attributes = attributes//': '
                  call add_meaning(about, attributes)
                  attributes = attributes//newline
               else if (.not. is_numbered(group%fields(i)) .and. share_of(fields, number, i) == own) then
                  call add_row(about, about%dimensions, rows)
                  rows = rows//newline
               end if
            end associate
         end do
         if (rows /= '') text = text//newline//'| Dataset | Dimensions | Unit | What |'//newline//'|---|---|---|---|'//newline//rows
         if (attributes /= '') text = text//newline//'Attributes:'//newline//newline//attributes
      end associate
   end subroutine add_group

   !> Adds the names of the datasets of a group that other tables describe, those with equal dimensions together.
   subroutine add_names(fields, number, text)
      class(fields_type), intent(in) :: fields
      !> Number of the group.
      integer, intent(in) :: number
      character(:), allocatable, intent(inout) :: text
      character(:), allocatable :: words, names
      logical, allocatable :: done(:)
      integer :: i, j

      associate (group => fields%groups(number))
         words = ''
         if (any(of_motions == group%path)) words = 'It has the datasets of motions.'
         allocate (done(group%count), source=.false.)
         names = ''
         do i = 1, group%count
            if (done(i) .or. .not. is_named(i)) cycle
            do j = i, group%count
               if (.not. is_named(j)) cycle
               if (group%fields(j)%about%dimensions /= group%fields(i)%about%dimensions) cycle
               done(j) = .true.
               if (names /= '') names = names//', '
               names = names//'`'//trim(group%fields(j)%about%name)//'`'
            end do
            names = names//' ('//trim(group%fields(i)%about%dimensions)//')'
         end do
         if (names /= '') words = trim(words//' From the first table: '//names//'.')
         if (words /= '') text = text//newline//trim(adjustl(words))
      end associate

   contains

      logical function is_named(place)
         integer, intent(in) :: place

         is_named = share_of(fields, number, place) == common .and. .not. &
                    any(companions == fields%groups(number)%fields(place)%about%name)
      end function is_named

   end subroutine add_names

   !> Adds the first cells of a row: name, dimensions, unit and meaning.
   subroutine add_row(about, dimensions, text)
      type(field_type), intent(in) :: about
      character(*), intent(in) :: dimensions
      character(:), allocatable, intent(inout) :: text

      text = text//'| `'//trim(about%name)//'` | '
      call add_with(trim(dimensions), ' ', ', ', text)
      text = text//' |'
      call add_unit(about%unit, text)
      text = text//' '
      call add_meaning(about, text)
      text = text//' |'
   end subroutine add_row

   !> Adds the cell of a unit; none where the field is dimensionless.
   subroutine add_unit(unit, text)
      character(*), intent(in) :: unit
      character(:), allocatable, intent(inout) :: text

      if (unit == '1') call add_cell('', text)
      if (unit /= '1') call add_cell(unit, text)
   end subroutine add_unit

   !> Adds the description of a field and when it exists.
   subroutine add_meaning(about, text)
      type(field_type), intent(in) :: about
      character(:), allocatable, intent(inout) :: text

      ! A bar within a cell of a table.
      call add_with(trim(about%description), '|', '\|', text)
      if (about%only /= '') text = text//'. Only '//trim(about%only)
   end subroutine add_meaning

   !> Where a field is described: `common`, `motions` or `own`. A common dataset is in three groups or more, not all of motions; a
   !> dataset of motions is in two groups of motions or more.
   integer function share_of(fields, number, place)
      class(fields_type), intent(in) :: fields
      !> Number of the group; place of the field in it.
      integer, intent(in) :: number, place
      integer :: i, found, found_in_motions

      share_of = own
      associate (field => fields%groups(number)%fields(place))
         if (field%about%dimensions == '' .or. is_numbered(field)) return
         found = 0
         found_in_motions = 0
         do i = 1, fields%count
            if (.not. has(fields%groups(i), field)) cycle
            found = found + 1
            if (any(of_motions == fields%groups(i)%path)) found_in_motions = found_in_motions + 1
         end do
      end associate
      if (any(of_motions == fields%groups(number)%path) .and. found_in_motions > 1) share_of = motions
      if (found > 2 .and. found > found_in_motions) share_of = common
   end function share_of

   !> Whether a group before the given one has the same dataset.
   logical function has_before(fields, number, field, motions_only)
      class(fields_type), intent(in) :: fields
      !> Number of the given group.
      integer, intent(in) :: number
      type(values_type), intent(in) :: field
      !> Whether only groups of motions count.
      logical, intent(in) :: motions_only
      integer :: i

      has_before = .false.
      do i = 1, number - 1
         if (motions_only .and. .not. any(of_motions == fields%groups(i)%path)) cycle
         if (has(fields%groups(i), field)) has_before = .true.
      end do
   end function has_before

   !> Whether a group has a dataset with the name, unit and meaning of a given field.
   pure logical function has(group, field)
      type(group_type), intent(in) :: group
      type(values_type), intent(in) :: field
      integer :: i

      has = .false.
      do i = 1, group%count
         associate (a => group%fields(i)%about, b => field%about)
            if (a%dimensions /= '' .and. a%name == b%name .and. a%unit == b%unit .and. a%description == b%description .and. &
                a%only == b%only) has = .true.
         end associate
      end do
   end function has

   !> Whether a field is an axis with the values 1, 2, ...
   pure logical function is_numbered(field)
      type(values_type), intent(in) :: field

      is_numbered = field%axis .and. field%kind == kind_integer
   end function is_numbered

   !> Dimensions with `point` in place of `motion`.
   pure function as_points(dimensions) result(words)
      character(*), intent(in) :: dimensions
      character(len(dimensions)) :: words

      words = dimensions
      if (index(words, 'motion') == 1) words = 'point'//words(7:)
   end function as_points

   pure function capital(text)
      character(*), intent(in) :: text
      character(len(text)) :: capital

      capital = text
      if (lge(text(1:1), 'a') .and. lle(text(1:1), 'z')) capital(1:1) = achar(iachar(text(1:1)) - 32)
   end function capital

   !> Adds `words` to `text`, with `instead` in place of each `mark`.
   subroutine add_with(words, mark, instead, text)
      character(*), intent(in) :: words, instead
      character, intent(in) :: mark
      character(:), allocatable, intent(inout) :: text
      integer :: i

      do i = 1, len(words)
         if (words(i:i) == mark) text = text//instead
         if (words(i:i) /= mark) text = text//words(i:i)
      end do
   end subroutine add_with

end module geartrain_run_reference
