!> What the executable prints of a branch: peaks, folds, jumps, ranges, largest forces, and why it ended.
module geartrain_analyses_branch_report
   use geartrain_analyses_analysis, only: fixed
   use geartrain_analyses_frequency_text, only: frequency_text_type, in_width, length_unit, text_for
   use geartrain_analyses_load_report, only: beyond, column_length, name_meshes, report_loads
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_sorting, only: ascending
   use geartrain_continuation_branch, only: branch_type, carried_by, gap_along, has_sets, response_settings_type
   use geartrain_continuation_contact_ranges, only: back_collision_ranges, separation_ranges
   use geartrain_continuation_decided, only: rests_on_undecided
   use geartrain_continuation_jumps, only: jump_type, jumps
   use geartrain_continuation_summary, only: band_type, bands_without_stability, folds, gaps, peak_type, peaks
   use geartrain_model_frequency_unit, only: lambda_per
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: report_branch, report_branches

   !> Most lines about peaks of a mesh, and about special points.
   integer, parameter :: most_lines = 20
   !> Said of a table where a part of the range was not computed.
   character(*), parameter :: of_computed = '  of the computed ranges', of_all = repeat(' ', len(of_computed))

contains

   !> Writes the lines about further branches that the executable prints.
   subroutine report_branches(branches, settings, train, unit, seconds)
      !> The branches.
      type(branch_type), intent(in) :: branches(:)
      !> What the response asks for.
      type(response_settings_type), intent(in) :: settings
      !> Their train.
      type(train_type), intent(in) :: train
      !> An open unit for formatted text.
      integer, intent(in) :: unit
      !> Time that all of them took [s].
      real(dp), intent(in) :: seconds
      type(frequency_text_type) :: told
      character(:), allocatable :: origin
      integer :: i

      write (unit, '(a, i0, a, i0, 3a)') 'Further branches: ', size(branches), ', ', sum(branches%points), ' points in ', &
         fixed(seconds, 2), ' s'
      do i = 1, size(branches)
         told = text_for(branches(i), train, settings%unit)
         call told%of_words(branches(i)%origin, origin)
         write (unit, '(a, i0, a, i0, 2a)') 'Branch ', i, ', period ', branches(i)%subharmonic, ': ', origin
         call report_branch(branches(i), settings, train, unit, whole=.false.)
      end do
   end subroutine report_branches

   !> Writes the lines about a branch.
   subroutine report_branch(branch, settings, train, unit, whole)
      !> The branch.
      type(branch_type), intent(in) :: branch
      !> What the response asks for.
      type(response_settings_type), intent(in) :: settings
      !> The train of the branch.
      type(train_type), intent(in) :: train
      !> An open unit for formatted text.
      integer, intent(in) :: unit
      !> Whether the branch is to span the range asked for.
      logical, intent(in) :: whole
      type(frequency_text_type) :: told
      type(band_type), allocatable :: bands(:)
      real(dp), allocatable :: at_fold(:)
      character(column_length) :: column(0:size(train%meshes)), name
      character(:), allocatable :: words, missing
      logical, allocatable :: at_end(:)
      integer :: mesh, i, first
      integer, allocatable :: carried(:)

      told = text_for(branch, train, settings%unit)
      if (told%parameter /= '') write (unit, '(6a)') '    over ', trim(told%parameter), ' [', trim(branch%parameter_unit), &
         '] at Lambda ', trim(fixed(branch%constant_frequency, 4))
      if (branch%points > 0) then
         if (has_sets(branch)) then
            carried = [(size(carried_by(branch, i, i)), i=1, branch%points)]
            write (unit, '(a, i0, a, i0, a, i0)') '    harmonics carried, each because it matters: ', minval(carried), ' to ', &
               maxval(carried), ', the highest ', branch%harmonics
         end if
         bands = gaps(branch, ends_of(settings, train))
         bands = pack(bands, [(whole .and. told%number(bands(i)%from) /= told%number(bands(i)%to), i=1, size(bands))])
         call list(bands, told, missing)
         if (missing /= '') then
            call told%with_unit(missing, words)
            write (unit, '(2a)') '    not computed for ', words
         end if
         at_end = ends_range(branch, settings, train)
         call name_meshes(train, column, first)
         write (unit, '(4a)') column(0)(first:), in_width('peak at '//told%unit, 16), in_width('rms'//length_unit(train), 12), &
            trim(merge(of_all, of_computed, missing == ''))
         do mesh = 1, branch%meshes
            call report_peaks(branch, mesh, column(mesh)(first:), told, at_end, unit)
         end do
         at_fold = folds(branch)
         if (size(at_fold) > 0) then
            write (unit, '(2a)', advance='no') '    folds at ', trim(told%unit)
            do i = 1, size(at_fold)
               write (unit, '(a)', advance='no') in_width(told%number(at_fold(i)), 10)
            end do
            write (unit, '()')
         end if
         call report_branch_points(branch, told, unit)
         call report_jumps(branch, told, length_unit(train), unit)
         bands = bands_without_stability(branch)
         ! Those without width in the digits printed are left out; the file has them.
         bands = pack(bands, [(told%number(bands(i)%from) /= told%number(bands(i)%to), i=1, size(bands))])
         do i = 1, size(bands)
            call told%with_unit(trim(told%number(bands(i)%from))//' to '//told%number(bands(i)%to), words)
            write (unit, '(3a)') '    without a stable motion for ', words, &
               trim(merge(' (undecided)', '            ', bands(i)%undecided))
         end do
         call report_undecided(branch, told, unit)
         do mesh = 1, branch%meshes
            name = adjustl(column(mesh))
            call report_ranges('mesh '//trim(name)//' separates', separation_ranges(branch, mesh, .false.), &
                               separation_ranges(branch, mesh, .true.), allocated(branch%stable), told, unit)
            call report_ranges('mesh '//trim(name)//' back collision', &
                               back_collision_ranges(branch, mesh, .false.), &
                               back_collision_ranges(branch, mesh, .true.), allocated(branch%stable), told, unit)
            call report_pulling(branch, mesh, trim(name), told, unit)
         end do
         call report_forces(branch, column(:)(first:), told, at_end, trim(merge(of_all, of_computed, missing == '')), bands, unit)
      end if
      if (.not. allocated(branch%ended)) return
      call told%of_words(branch%ended, words)
      write (unit, '(2a)') '    ended: ', words
   end subroutine report_branch

   !> Whether each point lies at an end of the range asked for, beyond which there may be more, (point).
   pure function ends_range(branch, settings, train) result(at_end)
      type(branch_type), intent(in) :: branch
      type(response_settings_type), intent(in) :: settings
      type(train_type), intent(in) :: train
      logical :: at_end(branch%points)
      real(dp) :: ends(2), slack

      ends = ends_of(settings, train)
      slack = 1e-9_dp*maxval(abs(ends))
      associate (at => branch%frequency_ratio(:branch%points))
         at_end = abs(at - ends(1)) <= slack .or. abs(at - ends(2)) <= slack
      end associate
   end function ends_range

   !> Ends of the range, as the branch has them.
   pure function ends_of(settings, train) result(ends)
      type(response_settings_type), intent(in) :: settings
      type(train_type), intent(in) :: train
      real(dp) :: ends(2)

      ends = [settings%start, settings%stop]
      if (settings%parameter == '') ends = ends*lambda_per(train, settings%unit)
   end function ends_of

   !> A line about a mesh without backlash whose force changes sign, which no teeth can do.
   subroutine report_pulling(branch, mesh, name, told, unit)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: mesh
      character(*), intent(in) :: name
      type(frequency_text_type), intent(in) :: told
      integer, intent(in) :: unit
      character(:), allocatable :: words
      logical :: pulls(branch%points)

      associate (n => branch%points)
         ! Without a mean the train is not loaded: that is a linear study.
         pulls = .not. gap_along(branch, mesh) > 0 .and. branch%minimum(mesh, :n) < 0 .and. branch%maximum(mesh, :n) > 0 &
                 .and. abs(branch%mean(mesh, :n)) > 1e-9_dp*branch%rms(mesh, :n)
         if (.not. any(pulls)) return
         call told%with_unit(trim(told%number(minval(branch%frequency_ratio(:n), pulls)))//' to '// &
                             told%number(maxval(branch%frequency_ratio(:n), pulls)), words)
      end associate
      write (unit, '(5a)') '    mesh ', name, ' has no backlash, and its teeth pull for some of ', words, &
         ': with half_backlash, or backlash, they part'
   end subroutine report_pulling

   !> Lines about branch points, at which other branches of the same period cross.
   subroutine report_branch_points(branch, told, unit)
      type(branch_type), intent(in) :: branch
      type(frequency_text_type), intent(in) :: told
      integer, intent(in) :: unit
      character(:), allocatable :: words
      integer :: i

      do i = 1, size(branch%special_points)
         associate (special => branch%special_points(i))
            if (special%kind /= 'branch point') cycle
            call told%with_unit(told%number(special%frequency_ratio), words)
            if (special%multiplicity > 1) words = words//', '//text(special%multiplicity)// &
                                                  ' multipliers together: equal branches begin to move differently'
            write (unit, '(2a)') '    branch point at ', words
         end associate
      end do
   end subroutine report_branch_points

   !> Lines about the peaks of a mesh, and about an end of the range where the rms is larger than anywhere within.
   subroutine report_peaks(branch, mesh, name, told, at_end, unit)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: mesh, unit
      !> What the mesh is called, as wide as its column.
      character(*), intent(in) :: name
      type(frequency_text_type), intent(in) :: told
      logical, intent(in) :: at_end(:)
      type(peak_type), allocatable :: found(:)
      type(peak_type) :: at_the_end
      real(dp) :: lowest
      integer, allocatable :: order(:)
      integer :: i

      found = peaks(branch, mesh)
      lowest = 0
      if (size(found) > most_lines) then
         order = ascending(-found%rms)
         lowest = found(order(most_lines))%rms
      end if
      do i = 1, size(found)
         if (found(i)%rms >= lowest) call tell(found(i), '')
      end do
      if (lowest > 0) write (unit, '(2a, i0, a)') name, '  and ', count(found%rms < lowest), ' lower peaks, in the file'
      i = maxloc(branch%rms(mesh, :branch%points), 1)
      if (.not. at_end(i)) return
      at_the_end = peak_type(branch%frequency_ratio(i), branch%rms(mesh, i), i)
      if (allocated(branch%stable)) at_the_end%stable = branch%stable(i)
      if (allocated(branch%undecided)) at_the_end%undecided = branch%undecided(i)
      call tell(at_the_end, beyond)

   contains

      subroutine tell(peak, note)
         type(peak_type), intent(in) :: peak
         character(*), intent(in) :: note

         write (unit, '(3a)', advance='no') name, in_width(told%number(peak%frequency_ratio), 16), &
            in_width(fixed(peak%rms, 5), 12)
         if (allocated(branch%stable)) write (unit, '(2x, a)', advance='no') &
            trim(merge('undecided', merge('stable   ', 'unstable ', peak%stable), peak%undecided))
         write (unit, '(a)') note
      end subroutine tell

   end subroutine report_peaks

   subroutine report_jumps(branch, told, unit_of_length, unit)
      type(branch_type), intent(in) :: branch
      type(frequency_text_type), intent(in) :: told
      character(*), intent(in) :: unit_of_length
      integer, intent(in) :: unit
      type(jump_type), allocatable :: found(:)
      integer :: i

      found = jumps(branch)
      if (size(found) > 0) write (unit, '(6a)') merge('    speed ', '    value ', told%parameter == ''), &
         in_width(told%unit, 9), '  to the nearest stable motion, rms', &
         trim(unit_of_length), ' of the meshes'
      do i = 1, size(found)
         write (unit, '(4x, 2a, 2x)', advance='no') merge('rising ', 'falling', found(i)%rising), &
            in_width(told%number(found(i)%frequency_ratio), 9)
         if (found(i)%kind == 'leaves') then
            write (unit, '(3a)', advance='no') 'leaves the branch (', trim(found(i)%cause), ')'
         else
            write (unit, '(a)', advance='no') found(i)%kind
            call write_all(found(i)%before)
            write (unit, '(a)', advance='no') ' ->'
            call write_all(found(i)%after)
            if (found(i)%candidates > 1) write (unit, '(a, i0)', advance='no') '  nearest of ', found(i)%candidates
         end if
         write (unit, '(a)') trim(merge(' (undecided)', '            ', found(i)%undecided))
      end do

   contains

      subroutine write_all(rms)
         real(dp), intent(in) :: rms(:)
         integer :: mesh

         do mesh = 1, size(rms)
            write (unit, '(a)', advance='no') in_width(fixed(rms(mesh), 5), 9)
         end do
      end subroutine write_all

   end subroutine report_jumps

   !> Lines about points whose stability is a guess, and about special points that rest on such points alone.
   subroutine report_undecided(branch, told, unit)
      type(branch_type), intent(in) :: branch
      type(frequency_text_type), intent(in) :: told
      integer, intent(in) :: unit
      character(:), allocatable :: words
      integer :: i, n

      if (.not. allocated(branch%undecided)) return
      if (.not. any(branch%undecided(:branch%points))) return
      write (unit, '(a, i0, a)') '    stability of ', count(branch%undecided(:branch%points)), ' points is undecided'
      n = 0
      do i = 1, size(branch%special_points)
         if (.not. rests_on_undecided(branch, i)) cycle
         n = n + 1
         if (n > most_lines) cycle
         call told%with_unit(told%number(branch%special_points(i)%frequency_ratio), words)
         write (unit, '(4a)') '    rests on undecided points: ', trim(branch%special_points(i)%kind), ' at ', words
      end do
      if (n > most_lines) write (unit, '(a, i0, a)') '    and ', n - most_lines, ' other special points likewise'
   end subroutine report_undecided

   subroutine report_ranges(what, ranges, stable, known, told, unit)
      character(*), intent(in) :: what
      !> Ranges of all motions; ranges of stable motions, used where stability is known.
      type(band_type), intent(in) :: ranges(:), stable(:)
      logical, intent(in) :: known
      type(frequency_text_type), intent(in) :: told
      integer, intent(in) :: unit
      character(:), allocatable :: of_all, of_stable, words

      if (size(ranges) == 0) return
      call list(ranges, told, of_all)
      call told%with_unit(of_all, words)
      write (unit, '(4a)', advance='no') '    ', what, ' at ', words
      if (known) then
         call list(stable, told, of_stable)
         if (size(stable) == 0) then
            write (unit, '(a)', advance='no') '; at no stable motion'
         else if (of_stable /= of_all) then
            write (unit, '(2a)', advance='no') '; stable: ', of_stable
         end if
      end if
      write (unit, '()')
   end subroutine report_ranges

   !> Ranges as text: ranges that touch in the digits told are joined, and of several ranges those without width in these digits are
   !> left out.
   subroutine list(ranges, told, text)
      type(band_type), intent(in) :: ranges(:)
      type(frequency_text_type), intent(in) :: told
      character(:), allocatable, intent(out) :: text
      type(band_type) :: shown(size(ranges))
      integer :: i, n

      n = 0
      do i = 1, size(ranges)
         if (n > 0) then
            if (told%number(ranges(i)%from) == told%number(shown(n)%to)) then
               shown(n)%to = ranges(i)%to
               cycle
            end if
         end if
         n = n + 1
         shown(n) = ranges(i)
      end do
      text = ''
      do i = 1, n
         if (n > 1 .and. told%number(shown(i)%from) == told%number(shown(i)%to)) cycle
         if (text /= '') text = text//', '
         text = text//trim(told%number(shown(i)%from))//' to '//trim(told%number(shown(i)%to))
      end do
   end subroutine list

   !> Lines about the largest force of each mesh over the branch: of stable motions where stability is known, else of all motions.
   subroutine report_forces(branch, column, told, at_end, note, unstable, unit)
      type(branch_type), intent(in) :: branch
      !> Head of the column of meshes, and what each is called, (0:mesh).
      character(*), intent(in) :: column(0:)
      type(frequency_text_type), intent(in) :: told
      logical, intent(in) :: at_end(:)
      !> Said of the table.
      character(*), intent(in) :: note
      !> Ranges without a stable motion.
      type(band_type), intent(in) :: unstable(:)
      integer, intent(in) :: unit
      logical :: counts(branch%points)
      character(:), allocatable :: left_out, words

      counts = .true.
      if (allocated(branch%stable)) counts = branch%stable(:branch%points)
      if (.not. any(counts)) return
      associate (n => branch%points)
         call report_loads(branch%mesh_load(:, :n), branch%frequency_ratio(:n), counts, at_end, told, column, &
                           trim(merge(', stable motions', '                ', allocated(branch%stable)))//note, unit)
      end associate
      call list(unstable, told, left_out)
      if (left_out == '') return
      call told%with_unit(left_out, words)
      write (unit, '(3a)') '    these forces leave out ', words, ', where no motion of the branch is stable: &integration there &
         &tells what happens'
   end subroutine report_forces

end module geartrain_analyses_branch_report
