!> The long part of a report on a branch: every peak, fold, jump and range.
module geartrain_analyses_branch_details
   use geartrain_analyses_load_sentences, only: load_sides
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: significant, text
   use geartrain_base_sheet, only: in_details, sheet_type
   use geartrain_readings_contact_ranges, only: back_collision_ranges, drive_collision_ranges, separation_ranges
   use geartrain_readings_frequency_text, only: frequency_text_type, in_width
   use geartrain_readings_jumps, only: jump_type, jumps
   use geartrain_readings_length_text, only: length_text, length_text_type
   use geartrain_readings_range_sentences, only: range_words
   use geartrain_readings_summary, only: band_type, folds, peak_type, peaks
   use geartrain_trace_branch, only: branch_type, carried_by, has_sets
   use geartrain_trace_decided, only: rests_on_undecided
   use geartrain_train_mesh_groups, only: group_length, mesh_word
   use geartrain_train_names, only: mesh_names, name_length
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: put_details

contains

   !> Adds the details of a branch.
   subroutine put_details(branch, title, train, told, sheet)
      !> The branch, with points.
      type(branch_type), intent(in) :: branch
      !> What it is called.
      character(*), intent(in) :: title
      !> The train of the branch.
      type(train_type), intent(in) :: train
      !> How frequencies are stated.
      type(frequency_text_type), intent(in) :: told
      type(sheet_type), intent(inout) :: sheet
      real(dp), allocatable :: at_fold(:)
      integer, allocatable :: carried(:)
      character(:), allocatable :: words
      integer :: i

      call sheet%say(in_details, title)
      if (allocated(branch%ended)) then
         call told%of_words(branch%ended, words)
         call sheet%say(in_details, 'ended: '//words)
      end if
      if (has_sets(branch)) then
         carried = [(size(carried_by(branch, i, i)), i=1, branch%points)]
         call sheet%say(in_details, 'harmonics carried, each because it matters: '//text(minval(carried))//' to '// &
                        text(maxval(carried))//', the highest '//text(branch%harmonics))
      else
         call sheet%say(in_details, 'harmonics: '//text(branch%harmonics))
      end if
      call put_peaks(branch, train, told, sheet)
      at_fold = folds(branch)
      if (size(at_fold) > 0) then
         words = 'folds at '//trim(told%unit)
         do i = 1, size(at_fold)
            words = words//' '//trim(told%number(at_fold(i)))
         end do
         call sheet%say(in_details, words)
      end if
      call put_jumps(branch, told, length_text(train), sheet)
      call put_special_points(branch, told, sheet)
      call put_contact(branch, train, told, sheet)
   end subroutine put_details

   !> A row for each peak of each mesh.
   subroutine put_peaks(branch, train, told, sheet)
      type(branch_type), intent(in) :: branch
      type(train_type), intent(in) :: train
      type(frequency_text_type), intent(in) :: told
      type(sheet_type), intent(inout) :: sheet
      type(peak_type), allocatable :: found(:)
      type(length_text_type) :: lengths
      character(:), allocatable :: line, swing, force
      character(group_length + 12) :: words(branch%meshes)
      integer :: mesh, i, name_width, widths(4)

      lengths = length_text(train)
      swing = trim('peak to peak '//lengths%unit)
      force = 'largest force [N]'
      if (any(train%meshes%is_coupling)) force = 'largest force [N, N m]'
      widths = [18, max(18, len_trim(lengths%name) + 2), max(19, len(swing) + 2), max(20, len(force) + 2)]
      line = in_width('peak at '//told%unit, widths(1))//in_width(lengths%name, widths(2))
      line = line//in_width(swing, widths(3))//in_width(force, widths(4))
      words = [(mesh_word(train%meshes, i), i=1, branch%meshes)]
      name_width = maxval([len('mesh'), len_trim(words)])  ! a train of shafts alone has no mesh
      call sheet%add(in_details, 'mesh'//repeat(' ', name_width - len('mesh'))//line)
      do mesh = 1, branch%meshes
         found = peaks(branch, mesh)
         do i = 1, size(found)
            associate (peak => found(i))
               line = words(mesh)(:name_width)//in_width(told%number(peak%frequency_ratio), widths(1))// &
                      in_width(lengths%rms(peak%rms), widths(2))//in_width(significant(lengths%per_length* &
                      (branch%maximum(mesh, peak%point) - branch%minimum(mesh, peak%point))), widths(3))// &
                      in_width(significant(branch%mesh_load(mesh, peak%point)%force_maximum), widths(4))
               if (allocated(branch%stable)) line = line//'  '//merge('undecided', merge('stable   ', 'unstable ', peak%stable), &
                                                                      peak%undecided)
               call sheet%add(in_details, line)
            end associate
         end do
      end do
   end subroutine put_peaks

   !> A line for each jump, with all meshes.
   subroutine put_jumps(branch, told, lengths, sheet)
      type(branch_type), intent(in) :: branch
      type(frequency_text_type), intent(in) :: told
      type(length_text_type), intent(in) :: lengths
      type(sheet_type), intent(inout) :: sheet
      type(jump_type), allocatable :: found(:)
      character(:), allocatable :: words
      integer :: i

      found = jumps(branch)
      if (size(found) > 0) call sheet%say(in_details, 'jumps, '//trim(lengths%name)//' of all meshes')
      do i = 1, size(found)
         words = merge('up   ', 'down ', found(i)%rising)//in_width(told%number(found(i)%frequency_ratio), 10)//'  '
         if (found(i)%kind == 'leaves') then
            words = words//'to a motion that is not on this curve ('//trim(found(i)%cause)//')'
         else
            words = words//found(i)%kind
            call add_all(found(i)%before)
            words = words//' ->'
            call add_all(found(i)%after)
            if (found(i)%candidates > 1) words = words//'  nearest of '//text(found(i)%candidates)
         end if
         if (found(i)%undecided) words = words//' (undecided)'
         call sheet%say(in_details, '  '//words)
      end do

   contains

      subroutine add_all(rms)
         real(dp), intent(in) :: rms(:)
         integer :: mesh

         do mesh = 1, size(rms)
            words = words//' '//trim(lengths%rms(rms(mesh)))
         end do
      end subroutine add_all

   end subroutine put_jumps

   !> A line for each special point that is no fold, and for each special point that rests on undecided motions.
   subroutine put_special_points(branch, told, sheet)
      type(branch_type), intent(in) :: branch
      type(frequency_text_type), intent(in) :: told
      type(sheet_type), intent(inout) :: sheet
      character(:), allocatable :: words
      logical :: rests
      integer :: i

      if (.not. allocated(branch%special_points)) return
      do i = 1, size(branch%special_points)
         rests = rests_on_undecided(branch, i)
         if (branch%special_points(i)%kind == 'fold' .and. .not. rests) cycle
         call told%with_unit(told%number(branch%special_points(i)%frequency_ratio), words)
         words = trim(branch%special_points(i)%kind)//' at '//words
         if (rests) words = words//' rests on undecided motions'
         call sheet%say(in_details, words)
      end do
   end subroutine put_special_points

   !> Lines on the contact of each mesh: ranges of all motions.
   subroutine put_contact(branch, train, told, sheet)
      type(branch_type), intent(in) :: branch
      type(train_type), intent(in) :: train
      type(frequency_text_type), intent(in) :: told
      type(sheet_type), intent(inout) :: sheet
      character(name_length) :: names(branch%meshes)
      integer :: mesh

      names = mesh_names(train)
      associate (sides => load_sides(train))
         do mesh = 1, branch%meshes
            call put(trim(names(mesh))//' separates at ', separation_ranges(branch, mesh, .false.))
            if (sides(mesh) < 0) then
               call put(trim(names(mesh))//', loaded on its coast flanks, hits its drive flanks at ', &
                        drive_collision_ranges(branch, mesh, .false.))
            else
               call put(trim(names(mesh))//' hits its coast flanks at ', back_collision_ranges(branch, mesh, .false.))
            end if
         end do
      end associate

   contains

      subroutine put(what, ranges)
         character(*), intent(in) :: what
         type(band_type), intent(in) :: ranges(:)
         character(:), allocatable :: words

         call range_words(ranges, told, .true., words)
         if (words == '') return
         if (allocated(branch%stable)) words = words//', unstable motions included'
         call sheet%say(in_details, what//words)
      end subroutine put

   end subroutine put_contact

end module geartrain_analyses_branch_details
