!> The analysis &response: the branch of periodic motions over frequency, which geartrain_continuation_response traces.
module geartrain_analyses_response
   use geartrain_analyses_analysis, only: analysis_type, fixed, group_row_type
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type
   use geartrain_base_fields, only: fields_type, listing, reading
   use geartrain_base_kinds, only: dp
   use geartrain_base_observer, only: observer_type
   use geartrain_base_variable, only: visitor_type
   use geartrain_continuation_branch, only: branch_type, carried_by, has_sets, response_settings_type
   use geartrain_continuation_contact_ranges, only: back_collision_ranges, separation_ranges
   use geartrain_continuation_decided, only: rests_on_undecided
   use geartrain_continuation_fields, only: visit_branch
   use geartrain_continuation_jumps, only: jump_type, jumps
   use geartrain_continuation_response, only: response
   use geartrain_continuation_summary, only: band_type, bands_without_stability, folds, peak_type, peaks
   use geartrain_continuation_summary_fields, only: visit_summary
   use geartrain_continuation_variables, only: check_response_consistency, visit_response
   use geartrain_model_drawing, only: plain_train
   use geartrain_model_labels, only: label_length, mesh_labels
   use geartrain_model_network, only: state_count
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: report_branches, response_analysis_type, response_row, visit_whole_branch

   type(group_row_type), parameter :: response_row = group_row_type('response', &
      'Asks for the branch of periodic motions over frequency, by harmonic balance.')

   type, extends(analysis_type) :: response_analysis_type
      type(response_settings_type), pointer :: settings => null()
      type(branch_type), pointer :: result => null()
   contains
      procedure :: visit_variables
      procedure :: check
      procedure :: give_example
      procedure :: run
      procedure :: tell_end
      procedure :: visit_fields
      procedure :: report
   end type response_analysis_type

contains

   subroutine visit_variables(self, v)
      class(response_analysis_type), intent(inout) :: self
      class(visitor_type), intent(inout) :: v

      call visit_response(self%settings, v)
   end subroutine visit_variables

   subroutine check(self, train, seeded, checker)
      class(response_analysis_type), intent(in) :: self
      type(train_type), intent(in) :: train
      logical, intent(in) :: seeded
      class(checker_type), intent(inout) :: checker

      call check_response_consistency(train, self%settings, seeded, checker)
   end subroutine check

   subroutine give_example(self)
      class(response_analysis_type), intent(inout) :: self

      self%settings%start = 0.2_dp
      self%settings%stop = 2.6_dp
   end subroutine give_example

   subroutine run(self, train, error, observer, start)
      class(response_analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      type(error_type), allocatable, intent(out) :: error
      class(observer_type), intent(inout) :: observer
      type(motion_type), intent(in), optional :: start
      logical :: keep_going

      associate (branch => self%result)
         if (allocated(branch%ended) .and. .not. allocated(branch%trace)) return
         call response(train, self%settings, branch, error, start, observer)
         if (allocated(error) .or. branch%cancelled .or. branch%points == 0 .or. train%interrupt%raised()) return
         ! The time after the last step of the trace counts as time of the response.
         keep_going = .true.
         call observer%on_step('response', branch%points, branch%frequency_ratio(branch%points), keep_going)
      end associate
   end subroutine run

   subroutine tell_end(self, complete, ended)
      class(response_analysis_type), intent(in) :: self
      logical, intent(out) :: complete
      character(:), allocatable, intent(out) :: ended

      complete = self%result%complete
      ended = ''
      if (allocated(self%result%ended)) ended = self%result%ended
   end subroutine tell_end

   subroutine visit_fields(self, train, fields, summary)
      class(response_analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      class(fields_type), intent(inout) :: fields
      logical, intent(in) :: summary

      call visit_whole_branch(self%result, '/response', train, fields, summary)
   end subroutine visit_fields

   !> Visits the fields of a branch and of its figures.
   subroutine visit_whole_branch(branch, home, train, fields, summary)
      !> The branch; set by reading.
      type(branch_type), intent(inout) :: branch
      !> Path of the group.
      character(*), intent(in) :: home
      !> The train of the branch.
      type(train_type), intent(in) :: train
      !> The fields of the results.
      class(fields_type), intent(inout) :: fields
      !> Whether the figures (peaks, jumps, ...) are computed and visited as well.
      logical, intent(in) :: summary
      type(train_type) :: plain

      call visit_branch(branch, home, fields)
      if (fields%way == reading) then
         call fields%check(branch%states <= state_count(train), home)
         call plain_train(train, plain)
         branch%half_backlash = plain%meshes%half_backlash/plain%characteristic_length
      else if (summary .and. (branch%points > 0 .or. fields%way == listing)) then
         call visit_summary(branch, home, fields)
      end if
   end subroutine visit_whole_branch

   subroutine report(self, train, unit, seconds)
      class(response_analysis_type), intent(in) :: self
      type(train_type), intent(in) :: train
      integer, intent(in) :: unit
      real(dp), intent(in) :: seconds

      write (unit, '(a, i0, 3a)') 'Response: ', self%result%points, ' points in ', fixed(seconds, 2), ' s'
      call report_branch(self%result, train, unit)
   end subroutine report

   !> Writes the lines about further branches that the executable prints.
   subroutine report_branches(branches, train, unit, seconds)
      !> The branches.
      type(branch_type), intent(in) :: branches(:)
      !> Their train.
      type(train_type), intent(in) :: train
      !> An open unit for formatted text.
      integer, intent(in) :: unit
      !> Time that all of them took [s].
      real(dp), intent(in) :: seconds
      integer :: i

      write (unit, '(a, i0, a, i0, 3a)') 'Further branches: ', size(branches), ', ', sum(branches%points), ' points in ', &
         fixed(seconds, 2), ' s'
      do i = 1, size(branches)
         write (unit, '(a, i0, a, i0, 2a)') 'Branch ', i, ', period ', branches(i)%subharmonic, ': ', branches(i)%origin
         call report_branch(branches(i), train, unit)
      end do
   end subroutine report_branches

   subroutine report_branch(branch, train, unit)
      type(branch_type), intent(in) :: branch
      type(train_type), intent(in) :: train
      integer, intent(in) :: unit
      type(band_type), allocatable :: bands(:)
      real(dp), allocatable :: at_fold(:)
      character(label_length + 24) :: column(0:size(train%meshes)), name
      integer :: mesh, i, first
      integer, allocatable :: carried(:)

      if (branch%points > 0) then
         if (has_sets(branch)) then
            carried = [(size(carried_by(branch, i, i)), i=1, branch%points)]
            write (unit, '(a, i0, a, i0, a, i0)') '    harmonics carried, each because it matters: ', minval(carried), ' to ', &
               maxval(carried), ', the highest ', branch%harmonics
         end if
         call name_meshes(train, column)
         first = len(column) + 1 - max(8, 4 + maxval(len_trim(column)))
         column = adjustr(column)
         write (unit, '(2a)') column(0)(first:), '  peak at Lambda         rms'
         do mesh = 1, branch%meshes
            call report_peaks(branch, mesh, column(mesh)(first:), unit)
         end do
         at_fold = folds(branch)
         if (size(at_fold) > 0) write (unit, '(a, *(f10.4))') '    folds at Lambda', at_fold
         call report_branch_points(branch, unit)
         call report_jumps(branch, unit)
         bands = bands_without_stability(branch)
         do i = 1, size(bands)
            ! A band without width in the digits printed; the file has it.
            if (fixed(bands(i)%from, 4) == fixed(bands(i)%to, 4)) cycle
            write (unit, '(5a)') '    without a stable motion for Lambda ', fixed(bands(i)%from, 4), ' to ', &
               fixed(bands(i)%to, 4), trim(merge(' (undecided)', '            ', bands(i)%undecided))
         end do
         call report_undecided(branch, unit)
         do mesh = 1, branch%meshes
            name = adjustl(column(mesh))
            call report_ranges('mesh '//trim(name)//' separates', separation_ranges(branch, mesh, .false.), &
                               separation_ranges(branch, mesh, .true.), allocated(branch%stable), unit)
            call report_ranges('mesh '//trim(name)//' back collision', &
                               back_collision_ranges(branch, mesh, .false.), &
                               back_collision_ranges(branch, mesh, .true.), allocated(branch%stable), unit)
         end do
         call report_loads(branch, column(:)(first:), unit)
      end if
      if (allocated(branch%ended)) write (unit, '(2a)') '    ended: ', branch%ended
   end subroutine report_branch

   !> The column of meshes in a table: its head, then each by its number, and by its bodies where they have names.
   subroutine name_meshes(train, column)
      type(train_type), intent(in) :: train
      character(*), intent(out) :: column(0:)
      character(label_length) :: labels(size(train%meshes))
      integer :: i

      labels = mesh_labels(train)
      column(0) = 'mesh'
      do i = 1, size(labels)
         write (column(i), '(i0)') i
         if (allocated(train%bodies)) column(i) = trim(column(i))//' ('//trim(labels(i))//')'
      end do
   end subroutine name_meshes

   !> Lines about branch points, at which other branches of the same period cross.
   subroutine report_branch_points(branch, unit)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: unit
      integer :: i

      do i = 1, size(branch%special_points)
         associate (special => branch%special_points(i))
            if (special%kind /= 'branch point') cycle
            write (unit, '(2a)') '    branch point at Lambda ', fixed(special%frequency_ratio, 4)
         end associate
      end do
   end subroutine report_branch_points

   subroutine report_peaks(branch, mesh, name, unit)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: mesh, unit
      !> What the mesh is called, as wide as its column.
      character(*), intent(in) :: name
      type(peak_type), allocatable :: found(:)
      integer :: i

      found = peaks(branch, mesh)
      do i = 1, size(found)
         write (unit, '(a, f16.4, f12.5)', advance='no') name, found(i)%frequency_ratio, found(i)%rms
         if (allocated(branch%stable)) write (unit, '(2x, a)', advance='no') &
            trim(merge('undecided', merge('stable   ', 'unstable ', found(i)%stable), found(i)%undecided))
         write (unit, '()')
      end do
   end subroutine report_peaks

   subroutine report_jumps(branch, unit)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: unit
      type(jump_type), allocatable :: found(:)
      character(20) :: form
      integer :: i

      found = jumps(branch)
      form = '(4x, a, f9.4, 2x)'
      if (any(found%frequency_ratio >= 1000)) form = '(4x, a, f13.4, 2x)'
      if (size(found) > 0) write (unit, '(a)') '    speed    Lambda  to the nearest stable motion, rms of the meshes'
      do i = 1, size(found)
         write (unit, form, advance='no') merge('rising ', 'falling', found(i)%rising), found(i)%frequency_ratio
         if (found(i)%kind == 'leaves') then
            write (unit, '(3a)', advance='no') 'leaves the branch (', trim(found(i)%cause), ')'
         else
            write (unit, '(a, *(f9.5))', advance='no') found(i)%kind, found(i)%before
            write (unit, '(a, *(f9.5))', advance='no') ' ->', found(i)%after
            if (found(i)%candidates > 1) write (unit, '(a, i0)', advance='no') '  nearest of ', found(i)%candidates
         end if
         write (unit, '(a)') trim(merge(' (undecided)', '            ', found(i)%undecided))
      end do
   end subroutine report_jumps

   !> Lines about points whose stability is a guess, and about special points that rest on such points alone.
   subroutine report_undecided(branch, unit)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: unit
      integer :: i

      if (.not. allocated(branch%undecided)) return
      if (.not. any(branch%undecided(:branch%points))) return
      write (unit, '(a, i0, a)') '    stability of ', count(branch%undecided(:branch%points)), ' points is undecided'
      do i = 1, size(branch%special_points)
         if (rests_on_undecided(branch, i)) write (unit, '(4a)') '    rests on undecided points: ', &
            trim(branch%special_points(i)%kind), ' at Lambda ', fixed(branch%special_points(i)%frequency_ratio, 4)
      end do
   end subroutine report_undecided

   subroutine report_ranges(what, ranges, stable, known, unit)
      character(*), intent(in) :: what
      !> Ranges of all motions; ranges of stable motions, used where stability is known.
      type(band_type), intent(in) :: ranges(:), stable(:)
      logical, intent(in) :: known
      integer, intent(in) :: unit
      character(:), allocatable :: of_all, of_stable

      if (size(ranges) == 0) return
      call list(ranges, of_all)
      write (unit, '(5a)', advance='no') '    ', what, ' at Lambda ', of_all
      if (known) then
         call list(stable, of_stable)
         if (size(stable) == 0) then
            write (unit, '(a)', advance='no') '; at no stable motion'
         else if (of_stable /= of_all) then
            write (unit, '(2a)', advance='no') '; stable: ', of_stable
         end if
      end if
      write (unit, '()')
   end subroutine report_ranges

   !> Ranges as text with four decimals: ranges that touch in these digits are joined, and of several ranges those without width in
   !> these digits are left out.
   subroutine list(ranges, text)
      type(band_type), intent(in) :: ranges(:)
      character(:), allocatable, intent(out) :: text
      type(band_type) :: shown(size(ranges))
      integer :: i, n

      n = 0
      do i = 1, size(ranges)
         if (n > 0) then
            if (fixed(ranges(i)%from, 4) == fixed(shown(n)%to, 4)) then
               shown(n)%to = ranges(i)%to
               cycle
            end if
         end if
         n = n + 1
         shown(n) = ranges(i)
      end do
      text = ''
      do i = 1, n
         if (n > 1 .and. fixed(shown(i)%from, 4) == fixed(shown(i)%to, 4)) cycle
         if (text /= '') text = text//', '
         text = text//fixed(shown(i)%from, 4)//' to '//fixed(shown(i)%to, 4)
      end do
   end subroutine list

   !> Lines about the largest force of each mesh over the branch: of stable motions where stability is known, else of all motions.
   subroutine report_loads(branch, column, unit)
      type(branch_type), intent(in) :: branch
      !> Head of the column of meshes, and what each is called, (0:mesh).
      character(*), intent(in) :: column(0:)
      integer, intent(in) :: unit
      logical :: counts(branch%points)
      integer :: mesh, i

      counts = .true.
      if (allocated(branch%stable)) counts = branch%stable(:branch%points)
      if (.not. any(counts)) return
      write (unit, '(3a)') column(0), '  largest force [N]  dynamic factor  at Lambda', &
         trim(merge(', stable motions', '                ', allocated(branch%stable)))
      do mesh = 1, branch%meshes
         i = maxloc(branch%mesh_load(mesh, :branch%points)%force_maximum, 1, counts)
         associate (load => branch%mesh_load(mesh, i))
            write (unit, '(a, f19.1)', advance='no') column(mesh), load%force_maximum
            if (load%dynamic_factor < 0) write (unit, '(a16)', advance='no') '-'
            if (load%dynamic_factor >= 0) write (unit, '(f16.3)', advance='no') load%dynamic_factor
            write (unit, '(f11.4)') branch%frequency_ratio(i)
         end associate
      end do
   end subroutine report_loads

end module geartrain_analyses_response
