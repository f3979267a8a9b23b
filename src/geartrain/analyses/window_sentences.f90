!> What a report tells of motions whose figures are those of a window: their kinds, what a longer window would change, and idle
!> meshes that rattle.
module geartrain_analyses_window_sentences
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: counted, significant, text
   use geartrain_base_sheet, only: in_quality, in_result, sheet_type
   use geartrain_flow_time_constants, only: negligible
   use geartrain_train_names, only: list_numbers
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: say_windows

   character(*), parameter :: kinds(4) = [character(14) :: 'stationary', 'chaotic', 'still settling', 'undecided']

contains

   !> Adds sentences; none where no motion has a window.
   subroutine say_windows(train, motions, sheet)
      !> The train as given.
      type(train_type), intent(in) :: train
      !> The motions.
      type(motion_type), intent(in) :: motions(:)
      type(sheet_type), intent(inout) :: sheet
      logical :: windowed(size(motions)), rattles(size(train%meshes))
      character(:), allocatable :: words
      real(dp) :: rms, force, ringing
      integer :: i

      windowed = motions%window > 0 .and. [(allocated(motions(i)%mesh_load), i=1, size(motions))]
      if (.not. any(windowed)) return
      words = ''
      do i = 1, size(kinds)
         associate (number => count(windowed .and. motions%kind == kinds(i)))
            if (number > 0) words = words//', '//text(number)//' '//trim(kinds(i))
         end associate
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
      if (words == '') words = ', '//counted(count(windowed), 'motion', 'motions')
      call sheet%say(in_quality, 'Figures of a window of time:'//words(2:)//'; a window ten times as long would change an rms by &
                     &up to '//significant(100*rms)//' %, a largest force by up to '//significant(100*force)//' %.')
      if (ringing < 0) then
         call sheet%say(in_quality, 'Whether free vibrations have died out is not known: a natural vibration is too slow to be &
                        &seen.')
      else if (ringing > negligible) then
         call sheet%say(in_quality, 'Slow free vibrations were left, up to '//significant(100*ringing)// &
                        ' % of an alternating displacement.')
      end if
      call list_numbers(rattles, 'mesh', 'meshes', words)
      if (words /= '') call sheet%say(in_result, 'Without a mean force, and rattling: '//words//'.')
   end subroutine say_windows

end module geartrain_analyses_window_sentences
