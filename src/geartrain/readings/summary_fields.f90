!> The fields of the figures of a branch: peaks, jumps, bands, ranges of separation and back collision. Each is a group of its own,
!> which exists if it is not empty. The figures follow from the branch and are therefore not read back.
module geartrain_readings_summary_fields
   use geartrain_base_carry, only: carry
   use geartrain_base_field, only: row => field_type
   use geartrain_base_fields, only: fields_type, listing
   use geartrain_flow_motion_fields, only: on_stability
   use geartrain_readings_contact_ranges, only: back_collision_ranges, separation_ranges
   use geartrain_readings_jumps, only: jump_type, jumps
   use geartrain_readings_summary, only: band_type, bands_without_stability, peak_type, peaks
   use geartrain_trace_branch, only: branch_type
   use geartrain_trace_free_fields, only: about_ends, carry_free, free_name, free_unit
   implicit none (type, external)
   private
   public :: visit_bands, visit_jumps, visit_peaks, visit_ranges, visit_summary

contains

   !> Visits all groups of figures of a branch.
   subroutine visit_summary(branch, home, fields)
      type(branch_type), intent(in) :: branch
      !> Path of the group of the branch.
      character(*), intent(in) :: home
      class(fields_type), intent(inout) :: fields

      call visit_peaks(branch, home, fields)
      call visit_jumps(branch, home, fields)
      call visit_bands(branch, home, fields)
      call visit_ranges(branch, home, .false., fields)
      call visit_ranges(branch, home, .true., fields)
   end subroutine visit_summary

   !> Visits the peaks of all meshes.
   subroutine visit_peaks(branch, home, fields)
      type(branch_type), intent(in) :: branch
      !> Path of the group of the branch.
      character(*), intent(in) :: home
      class(fields_type), intent(inout) :: fields
      type(peak_type), allocatable :: found(:)
      type(peak_type) :: peak
      integer :: mesh, i, k, n

      n = 0
      if (fields%way /= listing) n = sum([(size(peaks(branch, mesh)), mesh=1, branch%meshes)])
      if (.not. fields%enter(home//'/peaks', 'local maxima of the rms of a mesh along the branch', n > 0)) return
      call fields%describe('coordinates', trim(free_name(branch))//' mesh')
      call fields%index_axis('peak', n, 'peak, mesh by mesh, in the order along the branch')
      call fields%begin_list('peak')
      if (fields%way == listing) call visit_peak(peak, 1)
      k = 0
      do mesh = 1, merge(0, branch%meshes, fields%way == listing)
         found = peaks(branch, mesh)
         do i = 1, size(found)
            k = k + 1
            call fields%visit_item(k)
            call visit_peak(found(i), mesh)
         end do
      end do
      call fields%end_list()

   contains

      subroutine visit_peak(peak, mesh)
         type(peak_type), intent(inout) :: peak
         integer, value :: mesh

         call carry(fields, row('mesh', '', '1', 'mesh with the peak'), mesh)
         call carry_free(branch, fields, peak%frequency_ratio)
         call carry(fields, row('rms', '', '1', '`rms` of the mesh at the peak'), peak%rms)
         call carry(fields, row('point', '', '1', 'point of the branch at the peak or nearest to it'), peak%point)
         if (.not. fields%has('stable', allocated(branch%stable))) return
         call carry(fields, row('stable', '', '1', '1 = the peak is stable', on_stability), peak%stable)
         call carry(fields, row('undecided', '', '1', '1 = the stability of the peak is a guess', on_stability), peak%undecided)
      end subroutine visit_peak

   end subroutine visit_peaks

   !> Visits the jumps of a sweep in speed.
   subroutine visit_jumps(branch, home, fields)
      type(branch_type), intent(in) :: branch
      !> Path of the group of the branch.
      character(*), intent(in) :: home
      class(fields_type), intent(inout) :: fields
      type(jump_type), allocatable :: found(:)
      integer :: i, n

      if (fields%way == listing) then
         allocate (found(1))
      else
         found = jumps(branch)
      end if
      n = size(found)
      if (.not. fields%enter(home//'/jumps', 'jumps of a sweep in speed, where a stable motion ends; only with `stability`', n > &
         0)) return
      call fields%describe('coordinates', trim(free_name(branch))//' kind direction')
      call fields%index_axis('jump', n, 'jump, by frequency')
      call fields%begin_list('jump')
      do i = 1, n
         call fields%visit_item(i)
         call visit_jump(found(i), branch, fields)
      end do
      call fields%end_list()
   end subroutine visit_jumps

   subroutine visit_jump(jump, branch, fields)
      type(jump_type), intent(inout) :: jump
      type(branch_type), intent(in) :: branch
      class(fields_type), intent(inout) :: fields
      character(7) :: direction

      direction = merge('rising ', 'falling', jump%rising)
      call carry_free(branch, fields, jump%frequency_ratio)
      call carry(fields, row('kind', '', '', 'jump up, jump down: to a larger or smaller amplitude of all meshes together; leaves: &
                             &the branch has no other stable motion there, or stability is lost without a fold'), jump%kind)
      call carry(fields, row('direction', '', '', 'rising or falling speed in the sweep'), &
                 direction)
      call carry(fields, row('cause', '', '', 'kind of the special point at which the stable motion ends'), jump%cause)
      call carry(fields, row('rms_before', 'mesh', '1', '`rms` of the branch before the jump'), jump%before)
      call carry(fields, row('rms_after', 'mesh', '1', '`rms` of the stable motion of the branch nearest in rms; NaN: the sweep &
                             &leaves the branch', none_is_negative=.true.), jump%after)
      call carry(fields, row('candidates', '', '1', 'number of other stable motions of the branch at this Lambda; above 1 &
                             &rms_after is a guess'), &
                 jump%candidates)
      call carry(fields, row('undecided', '', '1', '1 = the jump is a guess: the nearest decided points (at most five away) are &
                             &not stable on one side and unstable on the other, or the motion after the jump is undecided, or &
                             &another stable motion ends within the estimated errors of both folds'), jump%undecided)
   end subroutine visit_jump

   !> Visits the ranges of Lambda without a stable motion.
   subroutine visit_bands(branch, home, fields)
      type(branch_type), intent(in) :: branch
      !> Path of the group of the branch.
      character(*), intent(in) :: home
      class(fields_type), intent(inout) :: fields
      type(band_type), allocatable :: found(:)
      integer :: i, n

      if (fields%way == listing) then
         allocate (found(1))
      else
         found = bands_without_stability(branch)
      end if
      n = size(found)
      if (.not. fields%enter(home//'/bands_without_stability', 'ranges of Lambda in which the branch has no stable motion; only &
         &with `stability`', n > 0)) return
      call fields%index_axis('range', n, 'range, ascending')
      call fields%begin_list('range')
      do i = 1, n
         call fields%visit_item(i)
         call visit_ends(found(i), branch, fields)
         call carry(fields, row('undecided', '', '1', '1 = the range is a guess: it vanishes if its undecided points are stable'), &
                                found(i)%undecided)
      end do
      call fields%end_list()
   end subroutine visit_bands

   !> Visits the ranges of separation or back collision of every mesh: of all motions and, where stability is known, of the stable
   !> motions.
   subroutine visit_ranges(branch, home, back, fields)
      type(branch_type), intent(in) :: branch
      !> Path of the group of the branch.
      character(*), intent(in) :: home
      !> .true.: ranges of back collision; .false.: of separation.
      logical, intent(in) :: back
      class(fields_type), intent(inout) :: fields
      type(band_type), allocatable :: found(:), more(:)
      integer, allocatable :: mesh(:)
      logical, allocatable :: stable(:)
      integer :: i, j, k, n, pass

      allocate (found(0), mesh(0), stable(0))
      do pass = 1, merge(0, 2, fields%way == listing)
         do j = 1, branch%meshes
            if (back) more = back_collision_ranges(branch, j, pass == 2)
            if (.not. back) more = separation_ranges(branch, j, pass == 2)
            found = [found, more]
            mesh = [mesh, [(j, k=1, size(more))]]
            stable = [stable, [(pass == 2, k=1, size(more))]]
         end do
      end do
      if (fields%way == listing) then
         allocate (more(1))
         found = more
         mesh = [1]
         stable = [.true.]
      end if
      n = size(found)
      if (back) then
         if (.not. fields%enter(home//'/back_collision_ranges', 'ranges of Lambda in which the back flanks touch, p < &
            &-half_backlash at an instant; everywhere under a negative torque', &
                                n > 0)) return
      else
         if (.not. fields%enter(home//'/separation_ranges', 'ranges of Lambda in which the teeth separate, |p| < half_backlash &
                                &at an instant', n > 0)) return
      end if
      call fields%index_axis('range', n, 'range, ascending')
      call fields%begin_list('range')
      do i = 1, n
         call fields%visit_item(i)
         call visit_ends(found(i), branch, fields)
         call carry(fields, row('mesh', '', '1', 'number of the mesh'), mesh(i))
         call carry(fields, row('stable', '', '1', '1 = range of the stable motions; 0 = range of all motions of the branch'), &
                    stable(i))
      end do
      call fields%end_list()
   end subroutine visit_ranges

   subroutine visit_ends(range, branch, fields)
      type(band_type), intent(inout) :: range
      type(branch_type), intent(in) :: branch
      class(fields_type), intent(inout) :: fields

      call carry(fields, row('from', '', free_unit(branch), 'lower end of the range: '//about_ends), range%from)
      call carry(fields, row('to', '', free_unit(branch), 'upper end of the range: '//about_ends), range%to)
   end subroutine visit_ends

end module geartrain_readings_summary_fields
