!> The analysis &attractors: the steady motions that random starts reach at one frequency, and the share of each. Motions
!> without a period are kept where they are chaotic or quasi-periodic.
module geartrain_analyses_attractors
   use geartrain_analyses_analysis, only: analysis_type, group_row_type
   use geartrain_analyses_integration, only: most_harmonics
   use geartrain_analyses_torque_table, only: torque_table_type
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_same_motion, only: is_same_motion
   use geartrain_base_carry, only: carry, carry_text
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type
   use geartrain_base_field, only: field => field_type
   use geartrain_base_fields, only: fields_type, listing, reading
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: counted, fixed, text
   use geartrain_base_observer, only: observer_type
   use geartrain_base_shared_observer, only: shared_observer_type
   use geartrain_base_sheet, only: in_quality, in_result, sheet_type
   use geartrain_base_variable, only: row => variable_type, visitor_type
   use geartrain_base_words, only: words_type
   use geartrain_flow_aperiodic, only: aperiodic_type
   use geartrain_flow_floating, only: note_of
   use geartrain_flow_integration_settings, only: integration_settings_type, most_periods
   use geartrain_flow_motion_fields, only: visit_motions
   use geartrain_flow_section_map, only: section_map_type
   use geartrain_flow_settling, only: need_to_settle, settle
   use geartrain_flow_start_state, only: random_state
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_network_check_coupling, only: has_friction
   use geartrain_network_frequency_unit, only: check_unit, lambda_per, unit_length, visit_unit
   use geartrain_network_limits, only: check_frequency, check_harmonics
   use geartrain_network_long_period, only: check_long_period, visit_long_period
   use geartrain_network_system, only: build_system, system_type
   use geartrain_readings_frequency_text, only: frequency_text, frequency_text_type, in_width
   use geartrain_readings_length_text, only: length_text, length_text_type
   use geartrain_analyses_planet_loads, only: say_orbits
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: attractors, attractors_analysis_type, attractors_row, attractors_settings_type, attractors_type, check_attractors, &
      collect, error_share

   type(group_row_type), parameter :: attractors_row = group_row_type('attractors', 'Asks for the steady motions that random &
      &starts reach at one frequency, and their shares.', steps='starts', set_aside=.true.)

   real(dp), parameter :: zero = 0, one = 1
   !> Relative error of the figures of a settled motion over the tolerance of its settling, at most.
   real(dp), parameter :: error_share = 10
   !> Starts between two calls of the observer, which run in parallel.
   integer, parameter :: batch = 32
   !> Least periods of the fundamental over which a motion without period is averaged.
   integer, parameter :: least_average = 500

   !> The variables of &attractors.
   type :: attractors_settings_type
      !> Frequency, by default Lambda.
      real(dp) :: frequency = 0
      !> Unit of the frequency: 'Lambda', 'rpm' or 'Hz'.
      character(unit_length) :: unit = 'Lambda'
      !> Number of random starts; seed of the random numbers: equal seeds give equal starts.
      integer :: starts = 200, random_seed = 0
      !> Whether a branch is traced, with the settings of &response, through each attractor that lies on no branch of the case.
      logical :: follow = .false.
      !> Harmonics stored of each motion; periods of the fundamental after which a start is given up; 0: chosen.
      integer :: harmonics = 0, max_periods = 0
      !> Relative change over a period at which a motion counts as settled [1].
      real(dp) :: tolerance = 1e-9_dp
      !> Whether the Floquet multipliers of each motion are computed.
      logical :: stability = .true.
      !> Whether they are looked for even where the period is long.
      logical :: long_period = .false.
   end type attractors_settings_type

   !> The attractors that random starts settled on.
   type :: attractors_type
      !> The motions found, each with its share, largest share first.
      type(motion_type), allocatable :: motions(:)
      !> Lambda [1].
      real(dp) :: frequency_ratio = 0
      !> Number of starts done; seed of the random numbers.
      integer :: starts = 0, random_seed = 0
      !> Share of the starts that were not steady after max_periods, or grew without bound; 1 less the shares of the motions.
      real(dp) :: unsettled = 0
      !> 'all starts done', or why not; and a note where the train floats in its gaps. Not allocated: the search is under way.
      character(:), allocatable :: ended
      !> Whether all starts are done.
      logical :: complete = .false.
   end type attractors_type

   type, extends(analysis_type) :: attractors_analysis_type
      type(attractors_settings_type), pointer :: settings => null()
      type(attractors_type), pointer :: result => null()
   contains
      procedure :: visit_variables
      procedure :: check
      procedure :: run
      procedure :: tell_end
      procedure :: visit_fields
      procedure :: report
   end type attractors_analysis_type

contains

   subroutine visit_variables(self, v)
      class(attractors_analysis_type), intent(inout) :: self
      class(visitor_type), intent(inout) :: v
      type(attractors_settings_type), pointer :: settings

      settings => self%settings
      call v%enter('attractors', 1)
      call v%on_real(row('frequency', '', 'frequency, in `unit`', required=.true., above=zero), settings%frequency)
      call visit_unit(settings%unit, v)
      call v%on_integer(row('starts', '', 'number of random starts: displacements up to three times the static displacement, &
                            &velocities up to this displacement times the natural frequency of the mesh alone', least=one, &
                            most=1e6*one), settings%starts)
      call v%on_integer(row('random_seed', '', 'the same seed gives the same starts'), settings%random_seed)
      call v%on_logical(row('follow', '', 'follow each motion that lies on no branch of the case as a further branch, over the &
                            &range of &response and with its settings'), settings%follow)
      call v%on_integer(row('harmonics', '', 'harmonics of Lambda to store; 0: 16 times the highest mesh order', &
                            least=one, most=most_harmonics*one, automatic=zero), settings%harmonics)
      call v%on_integer(row('max_periods', '', 'periods of the fundamental after which an unsettled start is given up; 0: as &
                            &in an integration', least=one, automatic=zero), &
                        settings%max_periods)
      call v%on_real(row('tolerance', '', 'relative change per period at which a motion counts as settled', &
                         above=zero, most=one), settings%tolerance)
      call v%on_logical(row('stability', '', 'Floquet multipliers of every motion'), settings%stability)
      call visit_long_period(settings%long_period, v)
      call v%leave()
   end subroutine visit_variables

   !> Checks the train and the settings of a search; the error tells every problem, one a line.
   subroutine check_attractors(train, settings, error)
      !> The train as described.
      type(train_type), intent(in) :: train
      !> The settings.
      type(attractors_settings_type), intent(in) :: settings
      type(error_type), allocatable, intent(out) :: error
      type(attractors_settings_type), target :: copy
      type(attractors_analysis_type) :: analysis

      copy = settings
      analysis%settings => copy
      call analysis%check_alone(train, error)
   end subroutine check_attractors

   subroutine check(self, train, seeded, checker)
      class(attractors_analysis_type), intent(in) :: self
      type(train_type), intent(in) :: train
      logical, intent(in) :: seeded
      class(checker_type), intent(inout) :: checker
      type(train_type) :: plain

      associate (settings => self%settings)
         if (checker%problems%in_group('attractors')) return
         call checker%enter('attractors', 1)
         call check_unit(train, settings%unit, checker)
         call plain_train(train, plain)
         call check_frequency(plain, ['frequency'], [settings%frequency], checker, settings%unit)
         if (settings%follow .and. has_friction(train)) call checker%complain('follow', '.true.', 'must be .false. for a train &
            &with friction_torque: begin a response with a motion found here')
         if (settings%harmonics > 0) call check_harmonics(plain, settings%harmonics, 1, most_harmonics, checker)
         call check_long_period(train, 'attractors', 'every start flies over many periods', settings%long_period, checker)
         call checker%leave()
      end associate
   end subroutine check

   subroutine run(self, train, error, observer, start)
      class(attractors_analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      type(error_type), allocatable, intent(out) :: error
      class(observer_type), intent(inout) :: observer
      type(motion_type), intent(in), optional :: start

      if (.not. allocated(self%result%ended)) call attractors(train, self%settings, self%result, error, observer)
   end subroutine run

   subroutine tell_end(self, early)
      class(attractors_analysis_type), intent(in) :: self
      type(words_type), allocatable, intent(out) :: early

      if (.not. self%result%complete) early = words_type(self%result%ended)
   end subroutine tell_end

   !> Settles settings%starts random states, in parallel; the results do not depend on the number of threads.
   subroutine attractors(train, settings, found, error, observer, spoken)
      !> The train as described.
      type(train_type), intent(in) :: train
      !> Frequency, starts and what else &attractors asks for.
      type(attractors_settings_type), intent(in) :: settings
      !> The attractors. A search under way, with `motions` but without `ended` as in a checkpoint of the same case, is taken up. A
      !> target: an observer may read the motions so far through a pointer.
      type(attractors_type), intent(inout), target :: found
      type(error_type), allocatable, intent(out) :: error
      !> Told of 'attractors' after each start, and meanwhile; may end the search, which then holds the starts of whole batches.
      class(observer_type), intent(inout), optional, target :: observer
      !> What the observer is told of in place of 'attractors', where the search is a part of other work.
      character(*), intent(in), optional :: spoken
      type(shared_observer_type) :: shared
      type(attractors_type) :: empty
      type(integration_settings_type) :: integration
      type(system_type), target :: system
      type(motion_type) :: settled(batch)
      type(section_map_type) :: map
      type(aperiodic_type) :: wandering(batch)
      type(aperiodic_type), allocatable :: known(:)
      real(dp), allocatable :: state(:)
      integer, allocatable :: hits(:)
      integer :: first, last, i
      logical :: keep_going, stopped

      if (allocated(found%ended) .or. .not. allocated(found%motions)) found = empty
      call check_attractors(train, settings, error)
      if (allocated(error)) return
      call build_system(train, system)
      integration%harmonics = settings%harmonics
      integration%max_periods = settings%max_periods
      integration%tolerance = settings%tolerance
      integration%stability = settings%stability
      found%frequency_ratio = settings%frequency*lambda_per(train, settings%unit)
      found%random_seed = settings%random_seed
      call need_to_settle(system, settings%harmonics, error)
      if (allocated(error)) return
      if (.not. allocated(found%motions)) allocate (found%motions(0))
      hits = nint(found%motions%share*found%starts)
      call map%setup(system, found%frequency_ratio)
      allocate (known(size(found%motions)))
      do i = 1, size(known)
         if (found%motions(i)%period == 0) call wander(found%motions(i), known(i))
      end do
      keep_going = .true.
      shared%name = 'attractors'
      if (present(spoken)) shared%name = spoken
      if (present(observer)) shared%observer => observer
      shared%frequency_ratio = found%frequency_ratio
      do first = found%starts + 1, settings%starts, batch
         last = first + min(batch - 1, settings%starts - first)
         shared%done = found%starts
         shared%pieces_done = 0
         !$omp parallel do private(state, stopped) schedule(dynamic)
         do i = first, last
            state = random_state(system, settings%random_seed, i)
            call settle(system, found%frequency_ratio, integration, state, settled(i - first + 1), shared, stopped)
            if (stopped) cycle
            if (settled(i - first + 1)%kind == 'undecided') call wander(settled(i - first + 1), wandering(i - first + 1))
            call shared%add()
         end do
         !$omp end parallel do
         if (train%interrupt%raised() .or. .not. shared%keep_going) exit
         do i = 1, last - first + 1
            call collect(settled(i), error_share*settings%tolerance, found%motions, hits, wandering=wandering(i), known=known)
         end do
         call sort_by_hits(found%motions, hits, known)
         found%starts = last
         found%motions%share = hits/real(last, dp)
         found%unsettled = (last - sum(hits))/real(last, dp)
         if (present(observer)) call observer%on_step(shared%name, last, found%frequency_ratio, keep_going)
         if (.not. keep_going) exit
      end do
      found%complete = found%starts == settings%starts
      found%ended = 'all starts done'
      if (.not. found%complete) found%ended = 'cancelled after '//text(found%starts)//' of '//text(settings%starts)//' starts'
      found%ended = found%ended//note_of(any(found%motions%floating))

   contains

      !> Finds what a motion without period does in the long run.
      subroutine wander(motion, wandering)
         type(motion_type), intent(inout) :: motion
         type(aperiodic_type), intent(out) :: wandering

         call wandering%find(system, map, motion%state, max(most_periods(system, settings%max_periods), least_average))
         motion%kind = wandering%kind
         motion%lyapunov_exponent = wandering%exponent
         motion%lyapunov_error = wandering%error
      end subroutine wander

   end subroutine attractors

   !> Counts a settled motion as one of `motions`, or adds the motion to the list.
   subroutine collect(motion, uncertainty, motions, hits, place, wandering, known)
      !> The motion; without a period it counts only where `wandering` tells what it does.
      type(motion_type), intent(in) :: motion
      !> Relative error of the figures [1].
      real(dp), intent(in) :: uncertainty
      !> The motions so far.
      type(motion_type), allocatable, intent(inout) :: motions(:)
      !> Starts that settled on each motion.
      integer, allocatable, intent(inout) :: hits(:)
      !> Its place among the motions; 0: it does not count.
      integer, intent(out), optional :: place
      !> What a motion without period does in the long run.
      type(aperiodic_type), intent(in), optional :: wandering
      !> The same of each of `motions`.
      type(aperiodic_type), allocatable, intent(inout), optional :: known(:)
      type(aperiodic_type), allocatable :: more(:)
      integer :: i
      logical :: same

      if (present(place)) place = 0
      if (motion%period == 0) then
         if (.not. present(wandering)) return
         if (motion%kind /= 'chaotic' .and. motion%kind /= 'quasi-periodic') return
      end if
      do i = 1, size(motions)
         if (motions(i)%period /= motion%period) cycle
         if (motion%period > 0) then
            same = is_same_motion(motion, motions(i), uncertainty)
         else
            same = motion%kind == motions(i)%kind .and. wandering%is_same(known(i))
         end if
         if (.not. same) cycle
         hits(i) = hits(i) + 1
         if (present(place)) place = i
         return
      end do
      motions = [motions, motion]
      hits = [hits, 1]
      if (present(known)) then
         allocate (more(size(motions)))
         do i = 1, size(known)
            more(i) = known(i)
         end do
         more(size(motions)) = wandering
         call move_alloc(more, known)
      end if
      if (present(place)) place = size(motions)
   end subroutine collect

   !> Sorts motions by number of starts, descending.
   pure subroutine sort_by_hits(motions, hits, known)
      type(motion_type), intent(inout) :: motions(:)
      integer, intent(inout) :: hits(:)
      type(aperiodic_type), intent(inout) :: known(:)
      type(motion_type) :: held
      type(aperiodic_type) :: held_too
      integer :: i, j, count

      do i = 2, size(motions)
         held = motions(i)
         held_too = known(i)
         count = hits(i)
         do j = i - 1, 1, -1
            if (hits(j) >= count) exit
            motions(j + 1) = motions(j)
            known(j + 1) = known(j)
            hits(j + 1) = hits(j)
         end do
         motions(j + 1) = held
         known(j + 1) = held_too
         hits(j + 1) = count
      end do
   end subroutine sort_by_hits

   subroutine visit_fields(self, train, fields, summary)
      class(attractors_analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      class(fields_type), intent(inout) :: fields
      logical, intent(in) :: summary
      integer :: starts

      starts = 0
      if (self%asked) starts = self%settings%starts
      call visit_found(self%result, starts, fields)
   end subroutine visit_fields

   subroutine visit_found(found, starts, fields)
      type(attractors_type), intent(inout) :: found
      !> Number of starts of the whole search; 0: the case does not ask for attractors.
      integer, intent(in) :: starts
      class(fields_type), intent(inout) :: fields
      integer :: n

      if (.not. fields%enter('/attractors', 'steady motions that random starts reach at one frequency', &
                             .true.)) return
      n = 0
      if (allocated(found%motions)) n = size(found%motions)
      call carry_text(fields, field('ended', '', '', 'why it ended, in words'), &
                      found%ended, 'not yet: these are the motions so far')
      call carry(fields, field('complete', '', '', '1 = all starts are done'), found%complete)
      call carry(fields, field('frequency', '', '', 'Lambda'), found%frequency_ratio)
      call carry(fields, field('starts', '', '', 'number of starts done', least=0, most=starts), found%starts)
      call carry(fields, field('random_seed', '', '', 'seed of the random starts'), found%random_seed)
      call carry(fields, field('unsettled', '', '', 'share of the starts that did not settle within `max_periods` or grew without &
                               &bound; with all `share` it sums to 1'), found%unsettled)
      call fields%index_axis('motion', n, 'motion, largest share first')
      if (allocated(fields%wrong)) return
      if (fields%way == reading) then
         call fields%check(.not. found%complete .or. found%starts == starts, 'starts')
         allocate (found%motions(n))
      end if
      if (n > 0 .or. fields%way == listing) call visit_motions(found%motions, 'motion', fields)
   end subroutine visit_found

   !> What the report says of a motion.
   pure character(14) function word_of(motion)
      type(motion_type), intent(in) :: motion

      word_of = ''
      if (allocated(motion%multipliers)) word_of = merge('stable  ', 'unstable', motion%stable)
      if (motion%period == 0) word_of = motion%kind
   end function word_of

   subroutine report(self, train, sheet, torques)
      class(attractors_analysis_type), intent(in) :: self
      type(train_type), intent(in) :: train
      type(sheet_type), intent(inout) :: sheet
      type(torque_table_type), intent(inout) :: torques
      type(frequency_text_type) :: told
      type(length_text_type) :: lengths
      character(:), allocatable :: words, line
      integer :: i, mesh

      associate (found => self%result, unused => torques)
         told = frequency_text(train, self%settings%unit, 0.0_dp)
         lengths = length_text(train)
         call told%rounded(found%frequency_ratio, words)
         call sheet%say(in_result, 'Attractors at '//words//': '// &
                        counted(size(found%motions), 'steady motion', 'steady motions')//' from '// &
                        counted(found%starts, 'random start', 'random starts')//'; '//fixed(100*found%unsettled, 1)// &
                        ' % did not settle.')
         if (size(found%motions) > 0) call sheet%add(in_result, 'motion  period   share [%]  state           '// &
                                                     trim(lengths%name)//' of each mesh')
         do i = 1, size(found%motions)
            associate (motion => found%motions(i))
               line = in_width(text(i), 6)//in_width(text(motion%period), 8)//in_width(fixed(100*motion%share, 1), 12)//'  '// &
                      word_of(motion)
               do mesh = 1, size(motion%rms)
                  line = line//in_width(lengths%rms(motion%rms(mesh)), 11)
               end do
               call sheet%add(in_result, line)
            end associate
         end do
         if (allocated(found%motions)) call say_orbits(train, found%motions, sheet)
         if (.not. allocated(found%ended)) return
         if (found%ended /= 'all starts done' .or. sheet%verbose) &
            call sheet%say(in_quality, 'The search for attractors ended: '//found%ended//'.')
      end associate
   end subroutine report

end module geartrain_analyses_attractors
