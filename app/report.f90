!> The short table at the end of a run.
module report
   use, intrinsic :: iso_fortran_env, only: output_unit
   use geartrain, only: attractors_type, branch_type, dp, modes_type, sweep_type
   use geartrain_branch_summary, only: band_type, bands_without_stability, jumps, peak_type, peaks
   implicit none (type, external)
   private
   public :: report_modes, report_response, report_branches, report_integration, report_attractors

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
      real(dp), allocatable :: folds(:)
      integer :: mesh, i

      if (branch%points > 0) then
         write (output_unit, '(a)') '    mesh  peak at Lambda         rms'
         do mesh = 1, branch%meshes
            call report_peaks(branch, mesh)
         end do
         folds = jumps(branch)
         if (size(folds) > 0) write (output_unit, '(a, *(f10.4))') '    jumps (folds) at Lambda', folds
         bands = bands_without_stability(branch)
         do i = 1, size(bands)
            write (output_unit, '(4a)') '    without a stable motion for Lambda ', &
               fixed(bands(i)%from, 4), ' to ', fixed(bands(i)%to, 4)
         end do
      end if
      if (allocated(branch%ended)) write (output_unit, '(2a)') '    ended: ', branch%ended
   end subroutine report_branch

   subroutine report_peaks(branch, mesh)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: mesh
      type(peak_type), allocatable :: found(:)
      integer :: i

      found = peaks(branch, mesh)
      do i = 1, size(found)
         write (output_unit, '(i8, f16.4, f12.5)', advance='no') mesh, found(i)%frequency, found(i)%rms
         if (allocated(branch%stable)) write (output_unit, '(2x, a)', advance='no') trim(merge('stable  ', 'unstable', &
                                                                                               found(i)%stable))
         write (output_unit, '()')
      end do
   end subroutine report_peaks

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

      write (output_unit, '(3a, i0, a, i0, 5a)') 'Attractors at Lambda = ', fixed(found%frequency, 4), ': ', size(found%motions), &
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
