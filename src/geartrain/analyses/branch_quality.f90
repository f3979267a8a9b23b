!> How far a branch can be trusted, in sentences: accuracy, undecided stability, what is missing, and why it ended.
module geartrain_analyses_branch_quality
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: counted, significant, text
   use geartrain_base_sheet, only: in_quality, sheet_type
   use geartrain_readings_frequency_text, only: frequency_text_type
   use geartrain_readings_range_sentences, only: place_words, range_words, ranges_of_points
   use geartrain_readings_summary, only: band_type, gaps
   use geartrain_trace_branch, only: branch_type, gap_along, response_settings_type
   use geartrain_trace_decided, only: rests_on_undecided
   implicit none (type, external)
   private
   public :: say_quality

   !> Relative error of the waveform above which a motion counts as inaccurate where the case gives the harmonics [1].
   real(dp), parameter :: usual_tolerance = 1e-3_dp
   !> Share of a reading by harmonics that are not carried above which the reading counts as inaccurate [1].
   real(dp), parameter :: lacking = 1e-2_dp
   !> Kinds of special points that rest on undecided motions.
   character(16), parameter :: kinds(4) = [character(16) :: 'fold', 'period doubling', 'neimark-sacker', 'branch point']

contains

   !> Adds the sentences.
   subroutine say_quality(branch, gears, name, settings, ends, whole, told, sheet)
      type(branch_type), intent(in) :: branch
      !> Number of gear pairs, which come before couplings and bearings.
      integer, intent(in) :: gears
      !> What it is called, at the beginning of a sentence.
      character(*), intent(in) :: name
      !> What the response asks for.
      type(response_settings_type), intent(in) :: settings
      !> Ends of the range asked for.
      real(dp), intent(in) :: ends(2)
      !> Whether the branch is to span the range.
      logical, intent(in) :: whole
      !> How frequencies are stated.
      type(frequency_text_type), intent(in) :: told
      type(sheet_type), intent(inout) :: sheet
      type(band_type), allocatable :: between(:)
      character(:), allocatable :: words

      if (branch%points > 0) then
         call say_accuracy(branch, name, settings, told, whole, sheet)
         if (allocated(branch%undecided)) call say_undecided(branch, name, told, sheet)
         if (whole .and. .not. allocated(branch%stable)) call sheet%say(in_quality, name//': stability was not computed; unstable &
                                                                        &motions count as well.')
         if (whole) then
            between = gaps(branch, ends)
            call range_words(between, told, .true., words)
            if (words /= '' .and. any(told%number_differs(between%from, between%to))) call sheet%say(in_quality, &
               name//': not computed at '//words//', which forces, torques and ranges leave out.')
            call say_pulling(branch, gears, told, sheet)
         end if
      end if
      call say_end(branch, name, told, sheet)
   end subroutine say_quality

   !> Adds how many motions miss the accuracy aimed at, or have torques that lack harmonics, as where a shaft is in resonance with a
   !> harmonic that is not carried, and the cure.
   subroutine say_accuracy(branch, name, settings, told, whole, sheet)
      type(branch_type), intent(in) :: branch
      character(*), intent(in) :: name
      type(response_settings_type), intent(in) :: settings
      type(frequency_text_type), intent(in) :: told
      logical, intent(in) :: whole
      type(sheet_type), intent(inout) :: sheet
      character(:), allocatable :: words, place, places
      real(dp) :: tolerance, error(branch%points), lack(branch%points)
      integer :: missed, lacks, worst

      tolerance = usual_tolerance
      if (settings%harmonics == 0) tolerance = settings%tolerance
      error = branch%error_estimate(:branch%points)
      if (allocated(branch%correction)) then
         ! A refined motion is exact.
         where (branch%correction(:branch%points) >= 0) error = 0
      end if
      missed = count(error > tolerance)
      lack = 0
      if (allocated(branch%reading_error_estimate)) lack = branch%reading_error_estimate(:branch%points)
      lacks = count(lack > lacking)
      if (missed == 0 .and. lacks > 0) then
         call told%with_unit(told%number(branch%frequency_ratio(maxloc(lack, 1))), place)
         call sheet%say(in_quality, name//': torques or bearing forces of '//text(lacks)//' of '// &
                        counted(branch%points, 'motion', 'motions')//' are less accurate than '//significant(lacking)// &
                        ' (estimate; worst '//significant(maxval(lack))//' at '//place//'): use harmonics = 0.')
      end if
      if (missed == 0) then
         if (whole) call sheet%say(in_quality, name//': all '//text(branch%points)//' motions are accurate to '// &
                                   significant(tolerance)//' (estimate).')
         return
      end if
      worst = maxloc(error, 1)
      call told%with_unit(told%number(branch%frequency_ratio(worst)), place)
      words = name//': '//text(missed)//' of '//counted(branch%points, 'motion', 'motions')//trim(merge(' is ', ' are', &
              missed == 1))//' less accurate than '//significant(tolerance)//' (estimate; worst '//significant(error(worst))// &
              ' at '//place//')'
      if (lacks > 0) words = words//', torques of '//text(lacks)//' than '//significant(lacking)//' (worst ' &
                             //significant(maxval(lack))//')'
      if (settings%harmonics > 0) then
         words = words//': '//counted(branch%harmonics, 'harmonic is', 'harmonics are')//' too few, use harmonics = 0'
      else
         call place_words(pack(branch%frequency_ratio(:branch%points), error > tolerance), told, sheet%verbose, places)
         words = words//', near '//places//': refine = .true. makes motions exact whose period is not too long'
      end if
      call sheet%say(in_quality, words//'.')
   end subroutine say_accuracy

   !> Adds how many verdicts on stability are guesses, and the special points that rest on them.
   subroutine say_undecided(branch, name, told, sheet)
      type(branch_type), intent(in) :: branch
      character(*), intent(in) :: name
      type(frequency_text_type), intent(in) :: told
      type(sheet_type), intent(inout) :: sheet
      character(:), allocatable :: words, places
      character(24) :: kind(size(branch%special_points))
      integer :: i, n

      n = count(branch%undecided(:branch%points))
      if (n == 0) return
      call place_words(pack(branch%frequency_ratio(:branch%points), branch%undecided(:branch%points)), told, sheet%verbose, places)
      words = name//': the stability of '//counted(n, 'motion', 'motions')//' is undecided, near '//places
      kind = ''
      do i = 1, size(kind)
         if (rests_on_undecided(branch, i)) kind(i) = branch%special_points(i)%kind
      end do
      if (any(kind /= '')) then
         words = words//', on which rest'
         do i = 1, size(kinds)
            if (any(kind == kinds(i))) words = words//' '//counted(count(kind == kinds(i)), trim(kinds(i)), trim(kinds(i))//'s')// &
                                               ','
         end do
         words = words(:len(words) - 1)
      end if
      call sheet%say(in_quality, words//'.')
   end subroutine say_undecided

   !> Adds a sentence for each mesh without backlash whose force changes sign, which no teeth can do.
   subroutine say_pulling(branch, gears, told, sheet)
      type(branch_type), intent(in) :: branch
      !> Number of gear pairs.
      integer, intent(in) :: gears
      type(frequency_text_type), intent(in) :: told
      type(sheet_type), intent(inout) :: sheet
      character(:), allocatable :: words
      logical :: pulls(branch%points)
      integer :: mesh, i

      associate (n => branch%points)
         do mesh = 1, gears
            ! Without a mean the train is not loaded: that is a linear study.
            pulls = .not. gap_along(branch, mesh) > 0 .and. branch%minimum(mesh, :n) < 0 .and. branch%maximum(mesh, :n) > 0 &
                    .and. abs(branch%mean(mesh, :n)) > 1e-9_dp*branch%rms(mesh, :n)
            if (.not. any(pulls)) cycle
            call range_words(ranges_of_points(branch%frequency_ratio(:n), pulls, [(.true., i=1, n)]), told, sheet%verbose, words)
            if (words == '') call told%with_unit(told%number(branch%frequency_ratio(findloc(pulls, .true., 1))), words)
            call sheet%say(in_quality, 'Mesh '//text(mesh)//' has no backlash, and its teeth pull at '//words//': with &
                           &half_backlash, or backlash, they part.')
         end do
      end associate
   end subroutine say_pulling

   !> Adds why the branch ended, unless it reached the end of the range or closed as it should, and what is noted with it.
   subroutine say_end(branch, name, told, sheet)
      type(branch_type), intent(in) :: branch
      character(*), intent(in) :: name
      type(frequency_text_type), intent(in) :: told
      type(sheet_type), intent(inout) :: sheet
      character(:), allocatable :: words
      integer :: first, last

      if (.not. allocated(branch%ended)) then
         call sheet%say(in_quality, name//' is under way.')
         return
      end if
      call told%of_words(branch%ended, words)
      if (.not. branch%complete) then
         call sheet%say(in_quality, name//trim(merge(' is incomplete:', ' ended early:  ', index(words, 'reached ') == 1))//' ' &
                        //words//'.')
         return
      end if
      ! Of what is noted after the reason for the end, motions that miss the tolerance have been counted.
      first = index(words//'; ', '; ') + 2
      if (index(words, 'reached ') /= 1 .and. index(words, 'from ') == 1) first = 1
      do while (first <= len(words))
         last = first + index(words(first:)//'; ', '; ') - 2
         if (index(words(first:last), ' miss the tolerance') == 0) call sheet%say(in_quality, name//': '//words(first:last)//'.')
         first = last + 3
      end do
   end subroutine say_end

end module geartrain_analyses_branch_quality
