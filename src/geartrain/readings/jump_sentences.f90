!> What a report says of the jumps of a slow sweep: in which direction, at which speed, from what to what.
module geartrain_readings_jump_sentences
   use geartrain_base_field, only: text_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_sheet, only: in_result, sheet_type
   use geartrain_base_sorting, only: ascending
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_train_mesh_groups, only: mesh_word
   use geartrain_readings_frequency_text, only: frequency_text_type
   use geartrain_readings_jumps, only: jump_type, jumps
   use geartrain_readings_length_text, only: length_text, length_text_type
   use geartrain_trace_branch, only: branch_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: say_jumps

   !> Most jumps of a short report.
   integer, parameter :: most = 6

contains

   !> Adds a sentence for each jump, one for jumps that read the same; in a short report for the jumps with the largest change of
   !> amplitude.
   subroutine say_jumps(branch, train, told, sheet)
      type(branch_type), intent(in) :: branch
      !> The train as given.
      type(train_type), intent(in) :: train
      !> How frequencies are stated.
      type(frequency_text_type), intent(in) :: told
      type(sheet_type), intent(inout) :: sheet
      type(jump_type), allocatable :: found(:)
      type(length_text_type) :: lengths
      type(text_type), allocatable :: sentences(:)
      integer, allocatable :: order(:), times(:)
      logical, allocatable :: shown(:)
      character(:), allocatable :: words, place
      integer :: i, n, mesh

      found = jumps(branch)
      if (size(found) == 0) return
      lengths = length_text(train)
      allocate (shown(size(found)), source=.true.)
      if (.not. sheet%verbose .and. size(found) > most) then
         order = ascending(-[(size_of(found(i)), i=1, size(found))])
         shown(order(most + 1:)) = .false.
      end if
      if (any(found%kind /= 'leaves')) call sheet%say(in_result, 'Jumps ('//trim(lengths%name)// &
                                                      ', mesh with the largest change):')
      allocate (sentences(size(found)))
      allocate (times(size(found)), source=0)
      do i = 1, size(found)
         if (.not. shown(i)) cycle
         call told%with_unit(told%number(found(i)%frequency_ratio), place)
         if (told%parameter == '') words = merge('speed up: at   ', 'speed down: at ', found(i)%rising)
         if (told%parameter /= '') words = merge('value up: at   ', 'value down: at ', found(i)%rising)
         words = trim(words)//' '//place
         if (found(i)%kind == 'leaves') then
            words = words//' '//trim(ending(found(i)%cause, branch, train))
            if (found(i)%candidates == 1) words = words//', or jumps to the other stable motion of this curve'
            if (found(i)%candidates > 1) words = words//', or jumps to one of '//text(found(i)%candidates) &
                                                 //' other stable motions of this curve'
         else
            mesh = maxloc(abs(found(i)%after - found(i)%before), 1)
            words = words//' '//trim(found(i)%kind)//', '//trim(mesh_word(train%meshes, mesh))//' from '// &
                    trim(lengths%rms(found(i)%before(mesh))) &
                    //' to '//trim(lengths%rms(found(i)%after(mesh)))
            if (found(i)%candidates > 1) words = words//' (the nearest of '//text(found(i)%candidates)//' stable motions)'
         end if
         if (found(i)%undecided) words = words//' (undecided)'
         do n = 1, i - 1
            if (times(n) == 0) cycle
            if (sentences(n)%text == words) exit
         end do
         if (n == i) sentences(i)%text = words
         times(n) = times(n) + 1
      end do
      do i = 1, size(found)
         if (times(i) == 0) cycle
         words = '  '//sentences(i)%text
         if (times(i) > 1) words = words//': '//text(times(i))//' jumps'
         call sheet%say(in_result, words)
      end do
      if (all(shown)) return
      words = '  and '//text(count(.not. shown))//' more with smaller amplitudes'
      i = count(found%undecided .and. .not. shown)
      if (i > 0) words = words//' ('//text(i)//' undecided)'
      call sheet%say(in_result, words)
   end subroutine say_jumps

   !> Change of the rms of all meshes; where the sweep has no other motion of the branch to jump to, the rms.
   pure real(dp) function size_of(jump)
      type(jump_type), intent(in) :: jump

      size_of = norm2(jump%before)
      if (jump%kind /= 'leaves') size_of = norm2(jump%after - jump%before)
   end function size_of

   !> What happens where the stable motion ends and the branch has no other stable motion, with blanks at the end.
   pure function ending(cause, branch, train) result(words)
      !> Kind of the special point.
      character(*), intent(in) :: cause
      type(branch_type), intent(in) :: branch
      type(train_type), intent(in) :: train
      character(88) :: words
      type(train_type) :: plain

      select case (cause)
      case ('period doubling')
         call plain_train(train, plain)
         words = 'vibration switches to half its frequency'
         if (branch%subharmonic == 1 .and. all(plain%meshes%order == 1)) words = 'vibration switches to half the mesh frequency'
      case ('neimark-sacker')
         words = 'vibration becomes quasi-periodic'
      case ('branch point')
         words = 'vibration switches to another motion of the same period'
      case default
         words = 'vibration jumps to a motion that is not on this curve ('//trim(cause)//')'
      end select
   end function ending

end module geartrain_readings_jump_sentences
