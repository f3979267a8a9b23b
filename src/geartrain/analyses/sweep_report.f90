!> What a report says of a sweep by time integration: periods, contact, largest forces and torques, and what did not settle.
module geartrain_analyses_sweep_report
   use geartrain_analyses_load_sentences, only: load_sides, unloaded_side
   use geartrain_analyses_mesh_sentences, only: say_meshes
   use geartrain_analyses_torque_table, only: say_reversals, torque_table_type
   use geartrain_analyses_window_sentences, only: say_windows
   use geartrain_balance_mesh_load, only: mesh_load_type
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_field, only: text_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_numbers, only: counted, text
   use geartrain_base_sheet, only: in_head, in_quality, in_result, sheet_type
   use geartrain_base_words, only: words_type
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_flow_integration_settings, only: integration_settings_type
   use geartrain_readings_frequency_text, only: frequency_text, frequency_text_type
   use geartrain_readings_range_sentences, only: range_words, ranges_of_points
   use geartrain_analyses_planet_loads, only: say_sharing
   use geartrain_train_names, only: mesh_names, name_length, torque_names
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: report_sweep

contains

   !> Adds a sweep to the report.
   subroutine report_sweep(motions, ended, settings, train, sheet, torques)
      !> The motions; Lambda 0: still to be done.
      type(motion_type), intent(in) :: motions(:)
      !> Why the sweep ended; not allocated: it is under way.
      type(words_type), allocatable, intent(in) :: ended
      !> What the integration asks for.
      type(integration_settings_type), intent(in) :: settings
      !> The train as given.
      type(train_type), intent(in) :: train
      type(sheet_type), intent(inout) :: sheet
      !> Torques of the shafts over all motions so far.
      type(torque_table_type), intent(inout) :: torques
      type(frequency_text_type) :: told
      character(:), allocatable :: from, to, words
      real(dp) :: at(size(motions))
      integer :: period, n

      at = motions%frequency_ratio
      n = count(at > 0)
      told = frequency_text(train, settings%unit, maxval([0.0_dp, at]), minval([maxval([0.0_dp, at]), pack(at, at > 0)]))
      from = text(minval([maxval([0.0_dp, at]), pack(at, at > 0)])*told%per_lambda)
      to = text(maxval([0.0_dp, at])*told%per_lambda)
      call told%with_unit(from, words)
      if (from /= to) call told%with_unit(from//' to '//to, words)
      words = 'Time integration: '//words
      if (settings%direction == 'both' .and. n > 1) words = words//' up and down'
      if (settings%direction == 'down' .and. n > 1) words = words//' down'
      call sheet%add(in_head, words//', '//counted(n, 'motion', 'motions'))
      words = ''
      do period = 1, maxval([0, motions%period])
         if (any(motions%period == period)) words = words//', '//text(count(motions%period == period))//' of period '//text(period)
      end do
      call sheet%say(in_result, 'Time integration, motions'//words//':')
      call say_motions(motions, told, train, sheet, torques)
      call say_quality(motions, sheet)
      call say_windows(train, motions, sheet)
      if (.not. allocated(ended)) return
      call told%of_words(ended, words)
      if (words /= 'all points done' .or. sheet%verbose) call sheet%say(in_quality, 'The integration ended: '//words//'.')
   end subroutine report_sweep

   !> Adds contact, forces and torques.
   subroutine say_motions(motions, told, train, sheet, torques)
      type(motion_type), intent(in) :: motions(:)
      type(frequency_text_type), intent(in) :: told
      type(train_type), intent(in) :: train
      type(sheet_type), intent(inout) :: sheet
      type(torque_table_type), intent(inout) :: torques
      type(mesh_load_type) :: load(size(train%meshes), size(motions))
      type(text_type), dimension(size(train%meshes)) :: contact, nothing
      type(train_type) :: plain
      character(name_length) :: names(size(train%meshes))
      real(dp), dimension(size(torque_names(train)), size(motions)) :: mean, low, high
      real(dp) :: smallest(size(motions)), largest(size(motions))
      real(dp), allocatable :: share(:, :), share_maximum(:, :)
      logical, dimension(size(motions)) :: counts, has_torque, connected, hits
      integer :: sides(size(train%meshes)), strongest(size(train%meshes)), i, mesh

      counts = [(allocated(motions(i)%mesh_load), i=1, size(counts))]
      if (.not. any(counts)) return
      has_torque = [(allocated(motions(i)%shaft_torque_mean), i=1, size(counts))] .and. counts
      connected = .true.
      low = 0
      high = 0
      mean = 0
      do i = 1, size(motions)
         if (counts(i)) load(:, i) = motions(i)%mesh_load
         if (.not. has_torque(i)) cycle
         mean(:, i) = motions(i)%shaft_torque_mean
         low(:, i) = motions(i)%shaft_torque_minimum
         high(:, i) = motions(i)%shaft_torque_maximum
      end do
      names = mesh_names(train)
      sides = load_sides(train)
      call plain_train(train, plain)
      associate (at => motions%frequency_ratio, gap => plain%meshes%half_backlash/plain%characteristic_length)
         do mesh = 1, size(names)
            contact(mesh)%text = ''
            if (.not. gap(mesh) > 0) cycle
            contact(mesh)%text = 'keeps contact'
            hits = counts .and. load(mesh, :)%separation > 0
            if (any(hits)) call describe('loses contact', hits, contact(mesh)%text)
            smallest = 0
            largest = 0
            do i = 1, size(motions)
               if (counts(i)) smallest(i) = motions(i)%minimum(mesh)
               if (counts(i)) largest(i) = motions(i)%maximum(mesh)
            end do
            if (sides(mesh) < 0) hits = largest > gap(mesh)
            if (sides(mesh) >= 0) hits = smallest < -gap(mesh)
            if (any(hits)) call describe(contact(mesh)%text//'; '//trim(unloaded_side(train%meshes(mesh), sides(mesh))), &
                                         hits, contact(mesh)%text)
         end do
         strongest = [(maxloc(load(mesh, :)%force_maximum, 1, counts), mesh=1, size(strongest))]
         nothing = text_type('')
         call say_meshes(load, strongest, at, [(.false., i=1, size(at))], nothing, nothing, contact, names, told, sheet)
         i = findloc([(allocated(motions(i)%load_share), i=1, size(counts))], .true., 1)
         if (i > 0) then
            allocate (share(size(motions(i)%load_share), size(motions)), source=0.0_dp)
            share_maximum = share
            do i = 1, size(motions)
               if (.not. (counts(i) .and. allocated(motions(i)%load_share))) cycle
               share(:, i) = motions(i)%load_share
               share_maximum(:, i) = motions(i)%load_share_maximum
            end do
            call say_sharing(share, share_maximum, at, counts, train, told, sheet)
         end if
         if (.not. any(has_torque)) return
         call say_reversals(train, low, high, at, has_torque, connected, told, sheet)
         call torques%take(mean, low, high, at, has_torque, told)
      end associate

   contains

      !> Words on the speeds at which something holds.
      subroutine describe(what, holds, words)
         character(*), intent(in) :: what
         logical, intent(in) :: holds(:)
         character(:), allocatable, intent(inout) :: words
         character(:), allocatable :: list

         call range_words(ranges_of_points(motions%frequency_ratio, holds, connected), told, sheet%verbose, list)
         if (list == '') call told%with_unit(told%number(motions(findloc(holds, .true., 1))%frequency_ratio), list)
         if (size(motions) == 1) words = what
         if (size(motions) > 1) words = what//' at '//list
      end subroutine describe

   end subroutine say_motions

   !> Adds what did not settle.
   subroutine say_quality(motions, sheet)
      type(motion_type), intent(in) :: motions(:)
      type(sheet_type), intent(inout) :: sheet
      character(14), parameter :: kinds(5) = [character(14) :: 'quasi-periodic', 'chaotic', 'still settling', 'undecided', &
                                              'unbounded']
      character(:), allocatable :: words
      integer :: done, left, i

      done = count(motions%frequency_ratio > 0)
      left = count(motions%frequency_ratio > 0 .and. motions%period <= 0 .and. motions%kind /= 'stationary')
      if (left == 0) then
         if (done == 1) call sheet%say(in_quality, 'Integration: the motion settled.')
         if (done > 1) call sheet%say(in_quality, 'Integration: all '//text(done)//' motions settled.')
         return
      end if
      words = ''
      do i = 1, size(kinds)
         associate (number => count(motions%kind == kinds(i) .and. motions%period <= 0))
            if (number > 0) words = words//', '//text(number)//' '//trim(kinds(i))
         end associate
      end do
      if (done == 1) words = 'Integration: the motion did not settle on a period: '//words(5:)//'; its forces and torques count'
      if (done > 1) words = 'Integration: '//text(left)//' of '//text(done)//' motions did not settle on a period'//words// &
                            '; their forces and torques count'
      if (any(motions%kind == 'unbounded')) words = words//', but for those without bound'
      call add_longer(motions, words)
      call sheet%say(in_quality, words//'.')
   end subroutine say_quality

   !> Adds how much longer motions that are still settling need.
   pure subroutine add_longer(motions, words)
      type(motion_type), intent(in) :: motions(:)
      character(:), allocatable, intent(inout) :: words
      ! Fall of a vibration over the further periods that are named.
      real(dp), parameter :: fall = 1e-6_dp
      real(dp) :: periods
      logical :: known, any_settles
      integer :: i

      any_settles = .false.
      known = .true.
      periods = 0
      do i = 1, size(motions)
         associate (motion => motions(i))
            if (motion%kind /= 'still settling' .or. motion%period > 0 .or. motion%window > 0) cycle
            any_settles = .true.
            known = known .and. allocated(motion%lyapunov_exponent)
            if (.not. known) cycle
            known = motion%lyapunov_exponent < -motion%lyapunov_error
            if (known) periods = max(periods, log(fall)*motion%frequency_ratio/(2*pi*motion%lyapunov_exponent))
         end associate
      end do
      if (.not. any_settles) return
      words = words//'; more max_periods may let what is still settling come to rest'
      if (known .and. periods < 1e8_dp) words = words//', some '//text(nint(periods))//' more'
   end subroutine add_longer

end module geartrain_analyses_sweep_report
