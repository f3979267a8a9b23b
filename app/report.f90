!> The short table at the end of a run.
module report
   use geartrain, only: attractors_type, branch_type, dp, modes_type, stability_map_type, sweep_type
   use geartrain_continuation_contact_ranges, only: back_collision_ranges, separation_ranges
   use geartrain_continuation_decided, only: rests_on_undecided
   use geartrain_continuation_jumps, only: jump_type, jumps
   use geartrain_continuation_summary, only: band_type, bands_without_stability, folds, peak_type, peaks
   use terminal, only: output_unit
   implicit none (type, external)
   private
   public :: report_modes, report_response, report_branches, report_integration, report_attractors, report_stability_map

contains

   subroutine report_modes(modes)
      type(modes_type), intent(in) :: modes

      write (output_unit, '(a)') 'Natural frequencies, Lambda'
      write (output_unit, '(4x, 6f12.4)') modes%natural_frequency
   end subroutine report_modes

   subroutine report_response(branch, seconds)
      type(branch_type), intent(in) :: branch
      !> Time taken [s].
      real(dp), intent(in) :: seconds

      write (output_unit, '(a, i0, 3a)') 'Response: ', branch%points, ' points in ', fixed(seconds, 2), ' s'
      call report_branch(branch)
   end subroutine report_response

   subroutine report_branches(branches, seconds)
      type(branch_type), intent(in) :: branches(:)
      !> Time taken by all of them [s].
      real(dp), intent(in) :: seconds
      integer :: i

      write (output_unit, '(a, i0, a, i0, 3a)') 'Further branches: ', size(branches), ', ', sum(branches%points), ' points in ', &
         fixed(seconds, 2), ' s'
      do i = 1, size(branches)
         write (output_unit, '(a, i0, a, i0, 2a)') 'Branch ', i, ', period ', branches(i)%subharmonic, ': ', branches(i)%origin
         call report_branch(branches(i))
      end do
   end subroutine report_branches

   subroutine report_branch(branch)
      type(branch_type), intent(in) :: branch
      type(band_type), allocatable :: bands(:)
      real(dp), allocatable :: at_fold(:)
      character(16) :: name
      integer :: mesh, i

      if (branch%points > 0) then
         write (output_unit, '(a)') '    mesh  peak at Lambda         rms'
         do mesh = 1, branch%meshes
            call report_peaks(branch, mesh)
         end do
         at_fold = folds(branch)
         if (size(at_fold) > 0) write (output_unit, '(a, *(f10.4))') '    folds at Lambda', at_fold
         call report_branch_points(branch)
         call report_jumps(branch)
         bands = bands_without_stability(branch)
         do i = 1, size(bands)
            ! Narrower than what is printed: the file has it.
            if (fixed(bands(i)%from, 4) == fixed(bands(i)%to, 4)) cycle
            write (output_unit, '(5a)') '    without a stable motion for Lambda ', fixed(bands(i)%from, 4), ' to ', &
               fixed(bands(i)%to, 4), trim(merge(' (undecided)', '            ', bands(i)%undecided))
         end do
         call report_undecided(branch)
         do mesh = 1, branch%meshes
            write (name, '(a, i0)') 'mesh ', mesh
            call report_ranges(trim(name)//' separates', separation_ranges(branch, mesh, .false.), &
                               separation_ranges(branch, mesh, .true.), allocated(branch%stable))
            call report_ranges(trim(name)//' back collision', back_collision_ranges(branch, mesh, .false.), &
                               back_collision_ranges(branch, mesh, .true.), allocated(branch%stable))
         end do
         call report_loads(branch)
      end if
      if (allocated(branch%ended)) write (output_unit, '(2a)') '    ended: ', branch%ended
   end subroutine report_branch

   !> Where other branches of the same period cross.
   subroutine report_branch_points(branch)
      type(branch_type), intent(in) :: branch
      integer :: i

      do i = 1, size(branch%special_points)
         associate (special => branch%special_points(i))
            if (special%kind /= 'branch point') cycle
            write (output_unit, '(2a)') '    branch point at Lambda ', fixed(special%frequency_ratio, 4)
         end associate
      end do
   end subroutine report_branch_points

   subroutine report_peaks(branch, mesh)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: mesh
      type(peak_type), allocatable :: found(:)
      integer :: i

      found = peaks(branch, mesh)
      do i = 1, size(found)
         write (output_unit, '(i8, f16.4, f12.5)', advance='no') mesh, found(i)%frequency_ratio, found(i)%rms
         if (allocated(branch%stable)) write (output_unit, '(2x, a)', advance='no') &
            trim(merge('undecided', merge('stable   ', 'unstable ', found(i)%stable), found(i)%undecided))
         write (output_unit, '()')
      end do
   end subroutine report_peaks

   subroutine report_jumps(branch)
      type(branch_type), intent(in) :: branch
      type(jump_type), allocatable :: found(:)
      integer :: i

      found = jumps(branch)
      if (size(found) > 0) write (output_unit, '(a)') '    speed    Lambda  to the nearest stable motion, rms of the meshes'
      do i = 1, size(found)
         write (output_unit, '(4x, a, f9.4, 2x)', advance='no') merge('rising ', 'falling', found(i)%rising), &
              found(i)%frequency_ratio
         if (found(i)%kind == 'leaves') then
            write (output_unit, '(3a)', advance='no') 'leaves the branch (', trim(found(i)%cause), ')'
         else
            write (output_unit, '(a, *(f9.5))', advance='no') found(i)%kind, found(i)%before
            write (output_unit, '(a, *(f9.5))', advance='no') ' ->', found(i)%after
            if (found(i)%candidates > 1) write (output_unit, '(a, i0)', advance='no') '  nearest of ', found(i)%candidates
         end if
         write (output_unit, '(a)') trim(merge(' (undecided)', '            ', found(i)%undecided))
      end do
   end subroutine report_jumps

   !> Points whose stability is a guess, and the special points that rest on such points alone.
   subroutine report_undecided(branch)
      type(branch_type), intent(in) :: branch
      integer :: i

      if (.not. allocated(branch%undecided)) return
      if (.not. any(branch%undecided(:branch%points))) return
      write (output_unit, '(a, i0, a)') '    stability of ', count(branch%undecided(:branch%points)), ' points is undecided'
      do i = 1, size(branch%special_points)
         if (rests_on_undecided(branch, i)) write (output_unit, '(4a)') '    rests on undecided points: ', &
            trim(branch%special_points(i)%kind), ' at Lambda ', fixed(branch%special_points(i)%frequency_ratio, 4)
      end do
   end subroutine report_undecided

   subroutine report_ranges(what, ranges, stable, known)
      character(*), intent(in) :: what
      !> At any level of the branch; at a stable one, where that is known.
      type(band_type), intent(in) :: ranges(:), stable(:)
      logical, intent(in) :: known

      if (size(ranges) == 0) return
      write (output_unit, '(5a)', advance='no') '    ', what, ' at Lambda ', list(ranges)
      if (known) then
         if (size(stable) == 0) then
            write (output_unit, '(a)', advance='no') '; at no stable motion'
         else if (list(stable) /= list(ranges)) then
            write (output_unit, '(2a)', advance='no') '; stable: ', list(stable)
         end if
      end if
      write (output_unit, '()')
   end subroutine report_ranges

   !> As printed: without the gaps, and the ranges beside others, that four decimals do not show.
   function list(ranges) result(text)
      type(band_type), intent(in) :: ranges(:)
      character(:), allocatable :: text
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
   end function list

   !> The largest mesh force of all motions of the branch, the stable ones where stability is known.
   subroutine report_loads(branch)
      type(branch_type), intent(in) :: branch
      logical :: counts(branch%points)
      integer :: mesh, i

      counts = .true.
      if (allocated(branch%stable)) counts = branch%stable(:branch%points)
      if (.not. any(counts)) return
      write (output_unit, '(2a)') '    mesh  largest force [N]  dynamic factor  at Lambda', &
         trim(merge(', stable motions', '                ', allocated(branch%stable)))
      do mesh = 1, branch%meshes
         i = maxloc(branch%mesh_load(mesh, :branch%points)%force_maximum, 1, counts)
         associate (load => branch%mesh_load(mesh, i))
            write (output_unit, '(i8, f19.1)', advance='no') mesh, load%force_maximum
            if (load%dynamic_factor < 0) write (output_unit, '(a16)', advance='no') '-'
            if (load%dynamic_factor >= 0) write (output_unit, '(f16.3)', advance='no') load%dynamic_factor
            write (output_unit, '(f11.4)') branch%frequency_ratio(i)
         end associate
      end do
   end subroutine report_loads

   subroutine report_integration(sweep, seconds)
      type(sweep_type), intent(in) :: sweep
      !> Time taken [s].
      real(dp), intent(in) :: seconds
      integer :: settled, period

      settled = count(sweep%motions%period > 0)
      write (output_unit, '(a, i0, 3a, i0, a, i0, a)') 'Integration: ', size(sweep%motions), ' points in ', &
         fixed(seconds, 2), ' s, ', settled, ' settled, ', size(sweep%motions) - settled, ' did not'
      do period = 1, maxval([0, sweep%motions%period])
         if (any(sweep%motions%period == period)) write (output_unit, '(a, i0, a, i0)') '    of period ', period, ': ', &
            count(sweep%motions%period == period)
      end do
      if (allocated(sweep%ended)) write (output_unit, '(2a)') '    ended: ', sweep%ended
   end subroutine report_integration

   subroutine report_attractors(found, seconds)
      type(attractors_type), intent(in) :: found
      !> Time taken [s].
      real(dp), intent(in) :: seconds
      integer :: i

      write (output_unit, '(3a, i0, a, i0, 5a)') 'Attractors at Lambda = ', fixed(found%frequency_ratio, 4), ': ', &
           size(found%motions), &
         ' from ', found%starts, ' starts in ', fixed(seconds, 2), ' s, ', fixed(100*found%unsettled, 1), ' % did not settle'
      if (size(found%motions) > 0) write (output_unit, '(a)') '    motion  period     share            rms of each mesh'
      do i = 1, size(found%motions)
         associate (motion => found%motions(i))
            write (output_unit, '(i10, i8, f8.1, a, 2x, a)', advance='no') i, motion%period, 100*motion%share, ' %', &
               merge('stable  ', merge('unstable', '        ', allocated(motion%multipliers)), motion%stable)
            write (output_unit, '(*(f12.5))') motion%rms
         end associate
      end do
      if (allocated(found%ended)) write (output_unit, '(2a)') '    ended: ', found%ended
   end subroutine report_attractors

   subroutine report_stability_map(map, seconds)
      type(stability_map_type), intent(in) :: map
      !> Time taken [s].
      real(dp), intent(in) :: seconds
      integer :: points

      write (output_unit, '(a, 2(i0, a), 5a)') 'Stability map: ', size(map%parameter), ' values of ', size(map%frequency_ratio), &
         ' frequencies each, ', map%name, ' and Lambda, in ', fixed(seconds, 2), ' s'
      points = size(map%frequency_ratio)*count(map%done)
      if (points > 0) then
         call report_share('no stable motion', count(map%stable_motions == 0), points)
         call report_share('several stable motions', count(map%stable_motions > 1), points)
      end if
      if (allocated(map%ended)) write (output_unit, '(2a)') '    ended: ', map%ended
   end subroutine report_stability_map

   subroutine report_share(what, part, whole)
      character(*), intent(in) :: what
      integer, intent(in) :: part, whole

      if (part > 0) write (output_unit, '(6a)') '    ', what, ' on ', fixed(100*real(part, dp)/whole, 2), ' % of the map'
   end subroutine report_share

   !> A number with a zero before the point, which f0.d leaves out.
   function fixed(value, decimals) result(text)
      real(dp), intent(in) :: value
      integer, intent(in) :: decimals
      character(:), allocatable :: text
      character(32) :: buffer
      character(8) :: form

      write (form, '(a, i0, a)') '(f24.', decimals, ')'
      write (buffer, form) value
      text = trim(adjustl(buffer))
   end function fixed

end module report
