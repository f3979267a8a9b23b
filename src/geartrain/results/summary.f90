!> What one reads off a branch, as groups beside its points: peaks, jumps, bands, ranges of separation and back collision. A group
!> is there where there is something to put into it.
module geartrain_results_summary
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use geartrain_base_kinds, only: dp
   use geartrain_branch_branch, only: branch_type
   use geartrain_branch_contact_ranges, only: back_collision_ranges, separation_ranges
   use geartrain_branch_jumps, only: jump_type, jumps
   use geartrain_branch_summary, only: band_type, bands_without_stability, peak_type, peaks
   use geartrain_results_labels, only: about_rms, frequency_description
   use geartrain_results_store, only: store_type
   implicit none (type, external)
   private
   public :: write_summary

contains

   !> `home` is the group of the branch.
   subroutine write_summary(store, home, branch)
      type(store_type), intent(inout) :: store
      character(*), intent(in) :: home
      type(branch_type), intent(in) :: branch
      type(band_type), allocatable :: bands(:)

      call write_peaks(store, home//'/peaks', branch)
      call write_jumps(store, home//'/jumps', branch)
      bands = bands_without_stability(branch)
      call write_ranges(store, home//'/bands_without_stability', 'ranges of Lambda without a stable motion at any level of &
                        &the branch', bands)
      if (size(bands) > 0) call store%put(home//'/bands_without_stability/undecided', (bands%undecided), ['range'], &
                                          '1 = the range is there by the guess of undecided points alone')
      call write_by_mesh(store, home//'/separation_ranges', branch, .false.)
      call write_by_mesh(store, home//'/back_collision_ranges', branch, .true.)
   end subroutine write_summary

   subroutine write_peaks(store, room, branch)
      type(store_type), intent(inout) :: store
      character(*), intent(in) :: room
      type(branch_type), intent(in) :: branch
      type(peak_type), allocatable :: found(:), more(:)
      integer, allocatable :: mesh(:)
      integer :: j, k

      allocate (found(0), mesh(0))
      do j = 1, branch%meshes
         more = peaks(branch, j)
         found = [found, more]
         mesh = [mesh, [(j, k=1, size(more))]]
      end do
      if (size(found) == 0) return
      call store%group(room)
      call store%attribute(room, 'description', 'local maxima of the rms of a mesh along the branch, at its points')
      call store%attribute(room, 'coordinates', 'frequency mesh')
      call store%axis(room//'/peak', size(found), 'peak, mesh by mesh, in the order along the branch')
      call store%put(room//'/mesh', mesh, ['peak'], '1', 'the mesh whose rms has the peak')
      call store%put(room//'/frequency', (found%frequency), ['peak'], '1', frequency_description)
      call store%put(room//'/rms', (found%rms), ['peak'], '1', about_rms)
      call store%put(room//'/point', (found%point), ['peak'], '1', 'the point of the branch')
      if (.not. allocated(branch%stable)) return
      call store%put(room//'/stable', (found%stable), ['peak'], '1 = that point is stable')
      call store%put(room//'/undecided', (found%undecided), ['peak'], '1 = the stability of that point is a guess')
   end subroutine write_peaks

   subroutine write_jumps(store, room, branch)
      type(store_type), intent(inout) :: store
      character(*), intent(in) :: room
      type(branch_type), intent(in) :: branch
      type(jump_type), allocatable :: found(:)
      real(dp), allocatable :: before(:, :), after(:, :)
      character(7), allocatable :: speed(:)
      integer :: i

      found = jumps(branch)
      if (size(found) == 0) return
      allocate (before(branch%meshes, size(found)), after(branch%meshes, size(found)), speed(size(found)))
      do i = 1, size(found)
         before(:, i) = found(i)%before
         after(:, i) = found(i)%after
         speed(i) = merge('rising ', 'falling', found(i)%rising)
      end do
      where (after < 0) after = ieee_value(1.0_dp, ieee_quiet_nan)
      call store%group(room)
      call store%attribute(room, 'description', 'where a sweep in speed jumps: the stable motion that it follows ends there')
      call store%attribute(room, 'coordinates', 'frequency kind speed')
      call store%axis(room//'/jump', size(found), 'jump, by frequency')
      call store%put(room//'/frequency', (found%frequency), ['jump'], '1', frequency_description)
      call store%put(room//'/kind', (found%kind), ['jump'], '', 'jump up, jump down: to a larger or smaller amplitude, all &
                     &meshes together; leaves: the branch has no other stable motion there')
      call store%put(room//'/speed', speed, ['jump'], '', 'rising or falling: the way in which the sweep goes that jumps here')
      call store%put(room//'/cause', (found%cause), ['jump'], '', 'the special point at which the stable motion ends')
      call store%put(room//'/rms_before', before, ['jump', 'mesh'], '1', about_rms)
      call store%put(room//'/rms_after', after, ['jump', 'mesh'], '1', about_rms// &
                     '; of the stable motion of the branch with the nearest rms; NaN for a jump that leaves the branch')
      call store%put(room//'/candidates', (found%candidates), ['jump'], '1', 'other stable motions of the branch at this Lambda: &
                     &where there are more than one, rms_after is a guess')
      call store%put(room//'/undecided', (found%undecided), ['jump'], '1 = it rests on undecided points: no decided one near it &
                     &is stable on one side and none unstable on the other, or the motion after it is undecided')
   end subroutine write_jumps

   !> Ranges of every mesh, at any level of the branch and, where stability is known, at a stable one.
   subroutine write_by_mesh(store, room, branch, back)
      type(store_type), intent(inout) :: store
      character(*), intent(in) :: room
      type(branch_type), intent(in) :: branch
      logical, intent(in) :: back
      type(band_type), allocatable :: found(:), more(:)
      integer, allocatable :: mesh(:)
      logical, allocatable :: stable(:)
      character(:), allocatable :: description
      integer :: j, k, pass

      allocate (found(0), mesh(0), stable(0))
      do pass = 1, 2
         do j = 1, branch%meshes
            if (back) more = back_collision_ranges(branch, j, pass == 2)
            if (.not. back) more = separation_ranges(branch, j, pass == 2)
            found = [found, more]
            mesh = [mesh, [(j, k=1, size(more))]]
            stable = [stable, [(pass == 2, k=1, size(more))]]
         end do
      end do
      description = 'ranges of Lambda in which the teeth separate, |p| < half_backlash at an instant'
      if (back) description = 'ranges of Lambda in which the back flanks collide, p < -half_backlash at an instant'
      call write_ranges(store, room, description, found)
      if (size(found) == 0) return
      call store%put(room//'/mesh', mesh, ['range'], '1', 'the mesh')
      call store%put(room//'/stable', stable, ['range'], '1 = at stable motions; 0 = at any motion of the branch, stable or not')
   end subroutine write_by_mesh

   subroutine write_ranges(store, room, description, ranges)
      type(store_type), intent(inout) :: store
      character(*), intent(in) :: room, description
      type(band_type), intent(in) :: ranges(:)

      if (size(ranges) == 0) return
      call store%group(room)
      call store%attribute(room, 'description', description)
      call store%axis(room//'/range', size(ranges), 'range, ascending')
      call store%put(room//'/from', (ranges%from), ['range'], '1', 'lower end; '//frequency_description)
      call store%put(room//'/to', (ranges%to), ['range'], '1', 'upper end; '//frequency_description)
   end subroutine write_ranges

end module geartrain_results_summary
