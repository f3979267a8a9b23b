!> What a report says of a branch of periodic motions: contact, jumps, largest forces and torques, and how far it can be trusted.
module geartrain_analyses_branch_report
   use geartrain_analyses_branch_details, only: put_details
   use geartrain_analyses_branch_quality, only: say_quality
   use geartrain_analyses_load_sentences, only: load_sides, unloaded_side
   use geartrain_analyses_mesh_sentences, only: say_meshes
   use geartrain_analyses_torque_table, only: say_reversals, torque_table_type
   use geartrain_base_field, only: text_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: counted, significant, text
   use geartrain_base_sheet, only: in_head, in_result, sheet_type
   use geartrain_network_frequency_unit, only: lambda_per
   use geartrain_readings_contact_ranges, only: back_collision_ranges, drive_collision_ranges, separation_ranges
   use geartrain_readings_force_remarks, only: add_edges, find_errors, find_sweeps
   use geartrain_readings_frequency_text, only: frequency_text, frequency_text_type, text_for
   use geartrain_readings_jump_sentences, only: say_jumps
   use geartrain_readings_range_sentences, only: range_words, ranges_of_points
   use geartrain_readings_stability_edges, only: edges_of, with_edges
   use geartrain_readings_summary, only: band_type, bands_without_stability
   use geartrain_analyses_planet_loads, only: say_sharing
   use geartrain_trace_branch, only: branch_type, gap_along, response_settings_type
   use geartrain_trace_decided, only: joined
   use geartrain_train_names, only: list_meshes, mesh_names, name_length
   use geartrain_train_mesh, only: mesh_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: report_branch, report_further

   !> Most further branches of a short report.
   integer, parameter :: most_branches = 4

contains

   !> Adds a response to the report.
   subroutine report_branch(branch, settings, train, sheet, torques)
      type(branch_type), intent(in) :: branch
      !> What the response asks for.
      type(response_settings_type), intent(in) :: settings
      !> The train of the branch.
      type(train_type), intent(in) :: train
      type(sheet_type), intent(inout) :: sheet
      !> Torques of the shafts over all motions so far.
      type(torque_table_type), intent(inout) :: torques
      type(frequency_text_type) :: told, constant
      character(:), allocatable :: words, place
      real(dp) :: ends(2)

      told = text_for(branch, train, settings%unit)
      ends = ends_of(settings, train)
      call told%with_unit(text(ends(1)*told%per_lambda)//' to '//text(ends(2)*told%per_lambda), words)
      words = 'Response: '//words
      if (told%parameter /= '') then
         constant = frequency_text(train, settings%unit, branch%constant_frequency)
         call constant%with_unit(text(branch%constant_frequency*constant%per_lambda), place)
         words = 'Response: '//trim(told%parameter)//' '//words(11:)//' at '//place
      end if
      call sheet%add(in_head, words//', '//counted(branch%points, 'motion', 'motions')//' of period '//text(branch%subharmonic))
      if (branch%points > 0) then
         call say_motions(branch, ends, train, told, .true., sheet, torques)
         if (sheet%verbose) call put_details(branch, 'Response', train, told, sheet)
      end if
      call say_quality(branch, count(train%meshes%is_pair()), 'Response', settings, ends, .true., told, sheet)
   end subroutine report_branch

   !> Adds the branches that follow from a response and from attractors.
   subroutine report_further(branches, settings, train, sheet, torques)
      !> The branches.
      type(branch_type), intent(in) :: branches(:)
      !> What the response asks for.
      type(response_settings_type), intent(in) :: settings
      !> Their train.
      type(train_type), intent(in) :: train
      type(sheet_type), intent(inout) :: sheet
      !> Torques of the shafts over all motions so far.
      type(torque_table_type), intent(inout) :: torques
      type(frequency_text_type) :: told
      character(:), allocatable :: origin, words, place
      real(dp) :: ends(2)
      integer :: i, mesh

      ends = ends_of(settings, train)
      do i = 1, size(branches)
         associate (branch => branches(i))
            told = text_for(branch, train, settings%unit)
            origin = ''
            if (allocated(branch%origin)) call told%of_words(branch%origin, origin)
            words = 'Branch '//text(i)//', period '//text(branch%subharmonic)//': '//origin
            if (branch%points > 0) then
               associate (at => branch%frequency_ratio(:branch%points), n => branch%points)
                  call told%with_unit(trim(told%number(minval(at)))//' to '//told%number(maxval(at)), place)
                  words = words//'; '//place
                  if (allocated(branch%stable)) then
                     if (any(branch%stable(:n))) then
                        words = words//'; largest force of stable motions '
                        do mesh = 1, min(branch%meshes, 4)
                           if (mesh > 1) words = words//', '
                           words = words//significant(maxval(branch%mesh_load(mesh, :n)%force_maximum, branch%stable(:n)))
                        end do
                        words = words//' N'
                        if (branch%meshes > 1) words = words//' of meshes 1 to '//text(min(branch%meshes, 4))
                        if (allocated(branch%shaft_torque_mean)) call torques%take(branch%shaft_torque_mean(:, :n), &
                           branch%shaft_torque_minimum(:, :n), branch%shaft_torque_maximum(:, :n), at, branch%stable(:n), told)
                     else
                        words = words//'; no motion is stable'
                     end if
                  end if
               end associate
            end if
            if (sheet%verbose .or. i <= most_branches) call sheet%say(in_result, words//'.')
            call say_quality(branch, count(train%meshes%is_pair()), 'Branch '//text(i), settings, ends, .false., told, &
                             sheet)
            if (sheet%verbose .and. branch%points > 0) call put_details(branch, words, train, told, sheet)
         end associate
      end do
      if (size(branches) > most_branches .and. .not. sheet%verbose) call sheet%say(in_result, 'and '// &
         counted(size(branches) - most_branches, 'further branch', 'further branches')//'.')
   end subroutine report_further

   !> Ends of the range asked for, as the branch has them.
   pure function ends_of(settings, train) result(ends)
      type(response_settings_type), intent(in) :: settings
      type(train_type), intent(in) :: train
      real(dp) :: ends(2)

      ends = [settings%start, settings%stop]
      if (settings%parameter == '') ends = ends*lambda_per(train, settings%unit)
   end function ends_of

   !> Adds what the motions of a branch are like.
   subroutine say_motions(branch, ends, train, told, whole, sheet, torques)
      type(branch_type), intent(in) :: branch
      real(dp), intent(in) :: ends(2)
      type(train_type), intent(in) :: train
      type(frequency_text_type), intent(in) :: told
      !> Whether the branch is to span the range.
      logical, intent(in) :: whole
      type(sheet_type), intent(inout) :: sheet
      type(torque_table_type), intent(inout) :: torques
      type(band_type), allocatable :: bands(:)
      type(text_type), dimension(branch%meshes) :: contact, error, sweep
      character(name_length) :: names(branch%meshes)
      character(:), allocatable :: words
      logical :: counts(branch%points), at_end(branch%points), connected(branch%points), known
      integer :: sides(branch%meshes), largest(branch%meshes), mesh, i
      integer, allocatable :: edges(:)

      known = allocated(branch%stable)
      counts = .true.
      sweep = text_type('')
      if (known) counts = branch%stable(:branch%points)
      associate (at => branch%frequency_ratio(:branch%points), n => branch%points)
         at_end = whole .and. (abs(at - ends(1)) <= 1e-9_dp*maxval(abs(ends)) .or. abs(at - ends(2)) <= 1e-9_dp*maxval(abs(ends)))
         connected = [.false., (joined(branch, i), i=1, n - 1)]
         sides = load_sides(train)
         if (told%parameter /= '') then
            ! A parameter may turn the load over: the flank is that of the mean displacement of all motions.
            sides = 1
            where (maxval(branch%mean(:, :n), 2) < 0) sides = -1
         end if
         names = mesh_names(train)
         if (known .and. .not. any(counts)) then
            call sheet%say(in_result, 'Response: no motion is stable; the figures are those of unstable motions.')
            counts = .true.
            known = .false.
         else
            call sheet%say(in_result, 'Response'//trim(merge(', stable motions:', ':                ', known)))
         end if
         largest = [(maxloc(branch%mesh_load(mesh, :n)%force_maximum, 1, counts), mesh=1, branch%meshes)]
         edges = edges_of(branch, counts)
         if (known) call find_sweeps(branch, largest, sweep)
         call add_edges(branch, train, edges, largest, told, sweep)
         do mesh = 1, branch%meshes
            call find_contact(branch, mesh, train%meshes(mesh), sides(mesh), told, sheet%verbose, contact(mesh)%text)
         end do
         call find_errors(branch, train, largest, error)
         call say_meshes(branch%mesh_load(:, :n), largest, at, at_end, error, sweep, contact, names, told, sheet)
         call say_ends(branch, train, largest, at_end, sheet)
         if (allocated(branch%load_share)) call say_sharing(branch%load_share(:, :n), branch%load_share_maximum(:, :n), at, &
                                                            counts, train, told, sheet)
         if (allocated(branch%shaft_torque_mean)) then
            call say_reversals(train, branch%shaft_torque_minimum(:, :n), branch%shaft_torque_maximum(:, :n), at, counts, &
                               connected, told, sheet)
            call torques%take(with_edges(branch, edges, branch%shaft_torque_mean(:, :n)), &
                              with_edges(branch, edges, branch%shaft_torque_minimum(:, :n)), &
                              with_edges(branch, edges, branch%shaft_torque_maximum(:, :n)), &
                              [at, branch%special_points(edges)%frequency_ratio], [counts, (.true., i=1, size(edges))], told, &
                              [(.false., i=1, n), (.true., i=1, size(edges))])
         end if
      end associate
      bands = bands_without_stability(branch)
      ! Ranges without width in the digits printed are left out; the file has them.
      bands = pack(bands, [(told%number(bands(i)%from) /= told%number(bands(i)%to), i=1, size(bands))])
      call range_words(bands, told, sheet%verbose, words)
      if (words /= '' .and. any(counts)) then
         words = 'At '//words//' no motion of period '//text(branch%subharmonic)//' is stable'
         if (all(bands%undecided)) words = words//' (undecided)'
         if (any(bands%undecided) .and. .not. all(bands%undecided)) words = words//' (partly undecided)'
         call sheet%say(in_result, words//': not in these figures, use &integration.')
      end if
      call say_sticking(branch, train, told, sheet)
      call say_jumps(branch, train, told, sheet)
      call say_branch_points(branch, told, sheet)
   end subroutine say_motions

   !> What is said of the contact of a mesh: where it separates and where its unloaded flanks hit; '' for a mesh without backlash.
   subroutine find_contact(branch, mesh, given, side, told, all, words)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: mesh
      !> The mesh as given; flank that bears the load, as load_sides gives it.
      type(mesh_type), intent(in) :: given
      integer, intent(in) :: side
      type(frequency_text_type), intent(in) :: told
      !> Whether all ranges are listed.
      logical, intent(in) :: all
      character(:), allocatable, intent(out) :: words
      character(:), allocatable :: hits

      words = ''
      if (.not. any(gap_along(branch, mesh) > 0)) return
      call say_ranges('loses contact at', separation_ranges(branch, mesh, .false.), separation_ranges(branch, mesh, .true.), words)
      if (words == '') words = 'keeps contact'
      if (side >= 0) then
         call say_ranges(trim(unloaded_side(given, side))//' at', back_collision_ranges(branch, mesh, .false.), &
                         back_collision_ranges(branch, mesh, .true.), hits)
      else
         call say_ranges(trim(unloaded_side(given, side))//' at', drive_collision_ranges(branch, mesh, .false.), &
                         drive_collision_ranges(branch, mesh, .true.), hits)
      end if
      if (hits /= '') words = words//'; '//hits

   contains

      subroutine say_ranges(what, ranges, stable, sentence)
         character(*), intent(in) :: what
         type(band_type), intent(in) :: ranges(:), stable(:)
         character(:), allocatable, intent(out) :: sentence
         character(:), allocatable :: list

         sentence = ''
         if (size(ranges) == 0) return
         if (allocated(branch%stable)) then
            call range_words(stable, told, all, list)
            if (list /= '') then
               sentence = what//' '//list
               return
            end if
            call range_words(ranges, told, all, list)
            if (list /= '') sentence = what//' '//list//' (unstable motions alone)'
         else
            call range_words(ranges, told, all, list)
            if (list /= '') sentence = what//' '//list
         end if
      end subroutine say_ranges

   end subroutine find_contact

   !> Adds a sentence on meshes, couplings and bearings whose vibration or force is largest at an end of the range.
   subroutine say_ends(branch, train, largest, at_end, sheet)
      type(branch_type), intent(in) :: branch
      type(train_type), intent(in) :: train
      !> Index of the point with the largest force of each mesh, (mesh).
      integer, intent(in) :: largest(:)
      !> Whether a motion lies at an end of the range, (point).
      logical, intent(in) :: at_end(:)
      type(sheet_type), intent(inout) :: sheet
      logical :: is_there(branch%meshes)
      character(:), allocatable :: list
      integer :: mesh

      do mesh = 1, branch%meshes
         is_there(mesh) = at_end(largest(mesh)) .or. at_end(maxloc(branch%rms(mesh, :branch%points), 1))
      end do
      call list_meshes(train, is_there, list)
      if (list /= '') call sheet%say(in_result, 'The largest force or vibration of '//list//' is at the end of the range; a larger &
                                     &one may lie beyond.')
   end subroutine say_ends

   !> Adds a sentence for each coupling whose dry friction lets it stick throughout the period.
   subroutine say_sticking(branch, train, told, sheet)
      type(branch_type), intent(in) :: branch
      type(train_type), intent(in) :: train
      type(frequency_text_type), intent(in) :: told
      type(sheet_type), intent(inout) :: sheet
      !> Rounding of the rms of a displacement that does not change, over the displacement and the largest rms [1].
      real(dp), parameter :: rounding = 1e-13_dp
      character(name_length) :: names(branch%meshes)
      character(:), allocatable :: words
      logical :: sticks(branch%points)
      integer :: mesh, i

      names = mesh_names(train)
      associate (n => branch%points)
         do mesh = 1, branch%meshes
            if (.not. train%meshes(mesh)%friction_torque > 0) cycle
            sticks = branch%rms(mesh, :n) <= rounding*(abs(branch%mean(mesh, :n)) + maxval(branch%rms(:, :n)))
            if (.not. any(sticks)) cycle
            call range_words(ranges_of_points(branch%frequency_ratio(:n), sticks, [(.true., i=1, n)]), told, sheet%verbose, words)
            if (words == '') call told%with_unit(told%number(branch%frequency_ratio(findloc(sticks, .true., 1))), words)
            call sheet%say(in_result, trim(names(mesh))//' sticks throughout at '//words//': its displacement is the mean of &
                           &those that its friction holds.')
         end do
      end associate
   end subroutine say_sticking

   !> Adds sentences on branch points, at which other branches of the same period cross.
   subroutine say_branch_points(branch, told, sheet)
      type(branch_type), intent(in) :: branch
      type(frequency_text_type), intent(in) :: told
      type(sheet_type), intent(inout) :: sheet
      character(:), allocatable :: words
      integer :: i

      if (.not. allocated(branch%special_points)) return
      do i = 1, size(branch%special_points)
         associate (special => branch%special_points(i))
            if (special%kind /= 'branch point') cycle
            call told%with_unit(told%number(special%frequency_ratio), words)
            words = 'Branch point at '//words//': another branch of the same period crosses'
            if (special%multiplicity > 1) words = words//', and equal parts of the train begin to move differently ('// &
                                                  text(special%multiplicity)//' multipliers together)'
            call sheet%say(in_result, words//'.')
         end associate
      end do
   end subroutine say_branch_points

end module geartrain_analyses_branch_report
