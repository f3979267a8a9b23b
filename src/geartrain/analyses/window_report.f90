!> What a report tells of motions whose figures are those of a window: their kinds, what a longer window would change, and idle
!> meshes that rattle.
module geartrain_analyses_window_report
   use geartrain_analyses_analysis, only: fixed
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_flow_time_constants, only: negligible
   use geartrain_model_labels, only: label_length, mesh_labels
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: report_windows

   character(*), parameter :: kinds(4) = [character(14) :: 'stationary', 'chaotic', 'still settling', 'undecided']

contains

   !> Writes some lines; none where no motion has a window.
   subroutine report_windows(train, motions, unit)
      !> The train as given.
      type(train_type), intent(in) :: train
      !> The motions.
      type(motion_type), intent(in) :: motions(:)
      !> Unit to write to.
      integer, intent(in) :: unit
      character(label_length) :: labels(size(train%meshes))
      logical :: windowed(size(motions)), rattles(size(train%meshes))
      real(dp) :: rms, force, ringing
      integer :: i, j

      windowed = motions%window > 0 .and. [(allocated(motions(i)%mesh_load), i=1, size(motions))]
      if (.not. any(windowed)) return
      do i = 1, size(kinds)
         if (any(windowed .and. motions%kind == kinds(i))) write (unit, '(4a)') '    ', trim(kinds(i)), ', figures of a window: ', &
            text(count(windowed .and. motions%kind == kinds(i)))
      end do
      rms = 0
      force = 0
      ringing = 0
      rattles = .false.
      do i = 1, size(motions)
         if (.not. windowed(i)) cycle
         associate (motion => motions(i))
            rms = max(rms, maxval(motion%uncertainty%rms/max(motion%rms, tiny(1.0_dp))))
            force = max(force, maxval(motion%uncertainty%force_maximum/max(abs(motion%mesh_load%force_maximum), tiny(1.0_dp))))
            rattles = rattles .or. (motion%mesh_load%dynamic_factor < 0 .and. motion%mesh_load%separation > 0)
            ringing = merge(-1.0_dp, max(ringing, motion%ringing), ringing < 0 .or. motion%ringing < 0)
         end associate
      end do
      write (unit, '(5a)') '    a window ten times as long would change an rms by up to ', fixed(100*rms, 2), &
         ' %, a largest force by up to ', fixed(100*force, 2), ' %'
      if (ringing < 0) then
         write (unit, '(a)') '    whether free vibrations have died out is not known: a natural vibration is too slow to be read'
      else if (ringing > negligible) then
         write (unit, '(3a)') '    slow free vibrations were left with up to ', fixed(100*ringing, 2), &
            ' % of an alternating displacement'
      end if
      labels = mesh_labels(train)
      do j = 1, size(labels)
         if (rattles(j)) write (unit, '(3a)') '    mesh ', trim(labels(j)), ' without a mean force rattles'
      end do
   end subroutine report_windows

end module geartrain_analyses_window_report
