!> The analysis &integration: time integration to steady motions over a range of frequencies, a sweep, in which each frequency
!> begins with the last state of the frequency before; and to a steady motion at one frequency.
module geartrain_analyses_integration
   use geartrain_analyses_analysis, only: analysis_type, group_row_type
   use geartrain_analyses_steady_motion, only: check_start, find_steady, need_to_find, time_before
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_carry, only: carry, carry_words
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type, fatal, status_ended_early
   use geartrain_base_field, only: field => field_type
   use geartrain_base_fields, only: fields_type, listing, reading
   use geartrain_base_kinds, only: dp
   use geartrain_base_memory, only: need
   use geartrain_base_numbers, only: integer_text, real_text, text
   use geartrain_base_observer, only: observer_type
   use geartrain_base_variable, only: row => variable_type, visitor_type
   use geartrain_base_words, only: lambda, operator(//), words_type
   use geartrain_flow_motion_fields, only: visit_motions
   use geartrain_flow_floating, only: note_of
   use geartrain_flow_integration_settings, only: integration_settings_type
   use geartrain_flow_orbit, only: stored_harmonics
   use geartrain_flow_window, only: goes_by_windows, window_of
   use geartrain_flow_start_state, only: resting_state, state_of
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_network_check_train, only: check_train
   use geartrain_network_frequency_unit, only: check_unit, lambda_per, visit_unit
   use geartrain_network_limits, only: check_frequency, check_harmonics
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_train, only: train_type
   use geartrain_analyses_sweep_report, only: report_sweep
   use geartrain_base_sheet, only: sheet_type
   use geartrain_analyses_torque_table, only: torque_table_type
   implicit none (type, external)
   private
   public :: check_integration, integrate, integration_analysis_type, integration_row, most_harmonics, sweep, &
      sweep_type

   type(group_row_type), parameter :: integration_row = group_row_type('integration', &
      'Asks for steady motions over frequency by time integration, a sweep.')

   real(dp), parameter :: zero = 0, one = 1
   !> Most harmonics that are stored of a motion.
   integer, parameter :: most_harmonics = 20000

   !> The motions of a sweep over frequency.
   type :: sweep_type
      !> One motion for each frequency, in the order visited; period 0: no period found; Lambda 0: still to be done.
      type(motion_type), allocatable :: motions(:)
      !> Direction of the sweep at each motion, 'up' or 'down', (motion).
      character(4), allocatable :: direction(:)
      !> 'all points done', or why not; and a note where the train floats in its gaps. Not allocated: the sweep is under way.
      type(words_type), allocatable :: ended
      !> Whether all frequencies are done.
      logical :: complete = .false.
   end type sweep_type

   type, extends(analysis_type) :: integration_analysis_type
      type(integration_settings_type), pointer :: settings => null()
      type(sweep_type), pointer :: result => null()
   contains
      procedure :: visit_variables
      procedure :: check
      procedure :: run
      procedure :: tell_end
      procedure :: visit_fields
      procedure :: report
   end type integration_analysis_type

contains

   subroutine visit_variables(self, v)
      class(integration_analysis_type), intent(inout) :: self
      class(visitor_type), intent(inout) :: v
      type(integration_settings_type), pointer :: settings
      character(:), allocatable :: word

      settings => self%settings
      call v%enter('integration', 1)
      call v%on_real(row('from', '', 'one end of the frequency range', required=.true., above=zero), &
                     settings%start)
      call v%on_real(row('to', '', 'other end of the frequency range', required=.true., above=zero), settings%stop)
      call visit_unit(settings%unit, v)
      call v%on_integer(row('points', '', 'frequencies in the range, both ends included', least=one, most=1e5*one), settings%points)
      word = trim(settings%direction)
      call v%on_text(row('direction', '', 'order of the frequencies; each starts from the motion before', &
                         choices='up down both'), word)
      settings%direction = word
      call v%on_integer(row('harmonics', '', 'harmonics of Lambda to store; 0: 16 times the highest mesh order', &
                            least=one, most=most_harmonics*one, automatic=zero), settings%harmonics)
      call v%on_integer(row('max_periods', '', 'periods of the fundamental after which an unsettled motion is given up; with a &
                            &window at most 1000 cycles of the slowest mesh; 0: 2000, or 40000 cycles of the fastest mesh if &
                            &fewer, but 100', least=one, automatic=zero), settings%max_periods)
      call v%on_integer(row('window', '', 'window of the results in cycles of the slowest mesh, after settling by time constants; &
                            &0: at least 100 where the period has more than 200 such cycles, or 10 with an idle mesh; else one &
                            &period', least=one, most=1e6*one, &
                            automatic=zero), settings%window)
      call v%on_real(row('tolerance', '', 'relative change per period at which a motion counts as settled', &
                         above=zero, most=one), settings%tolerance)
      call v%on_logical(row('stability', '', 'Floquet multipliers of every settled motion'), settings%stability)
      call v%leave()
   end subroutine visit_variables

   !> Checks the settings of a sweep; the error tells every problem, one a line.
   subroutine check_integration(train, settings, error)
      !> The train as described.
      type(train_type), intent(in) :: train
      !> The settings.
      type(integration_settings_type), intent(in) :: settings
      type(error_type), allocatable, intent(out) :: error
      type(integration_settings_type), target :: copy
      type(integration_analysis_type) :: analysis

      copy = settings
      analysis%settings => copy
      call analysis%check_alone(train, error)
   end subroutine check_integration

   subroutine check(self, train, seeded, checker)
      class(integration_analysis_type), intent(in) :: self
      type(train_type), intent(in) :: train
      logical, intent(in) :: seeded
      class(checker_type), intent(inout) :: checker
      type(train_type) :: plain

      associate (settings => self%settings)
         if (checker%problems%in_group('integration')) return
         call checker%enter('integration', 1)
         if (abs(settings%start - settings%stop) <= 0 .and. settings%points /= 1) &
            call checker%complain('points', integer_text(settings%points), 'must be 1 where "from" and "to" are equal')
         call check_unit(train, settings%unit, checker)
         call plain_train(train, plain)
         call check_frequency(plain, ['from', 'to  '], [settings%start, settings%stop], checker, settings%unit)
         if (settings%harmonics > 0) call check_harmonics(plain, settings%harmonics, 1, most_harmonics, checker)
         call checker%leave()
      end associate
   end subroutine check

   subroutine run(self, train, error, observer, start)
      class(integration_analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      type(error_type), allocatable, intent(out) :: error
      class(observer_type), intent(inout) :: observer
      type(motion_type), intent(in), optional :: start

      if (.not. allocated(self%result%ended)) call sweep(train, self%settings, self%result, error, observer)
   end subroutine run

   subroutine tell_end(self, early)
      class(integration_analysis_type), intent(in) :: self
      type(words_type), allocatable, intent(out) :: early

      if (.not. self%result%complete) early = self%result%ended
   end subroutine tell_end

   !> Visits settings%points frequencies between start and stop, upwards, downwards or both. A frequency without a steady motion has
   !> period 0; the sweep goes on from the last state, or from rest where the motion grew without bound.
   subroutine sweep(train, settings, result, error, observer)
      !> The train as described.
      type(train_type), intent(in) :: train
      !> Range, direction and what else &integration asks for.
      type(integration_settings_type), intent(in) :: settings
      !> The motions. A sweep under way, with `motions` but without `ended` as in a checkpoint of the same case, is taken up after
      !> its last motion. A target: an observer may read the motions so far through a pointer.
      type(sweep_type), intent(inout), target :: result
      type(error_type), allocatable, intent(out) :: error
      !> Told of 'integration' after each frequency and of 'settling' meanwhile; may end the sweep.
      class(observer_type), intent(inout), optional :: observer
      type(sweep_type) :: empty
      type(motion_type) :: motion
      type(system_type) :: system
      real(dp), allocatable :: state(:)
      real(dp) :: low, high, frequency_ratio
      ! Numbers of a motion for each mesh beside its coefficients; number of copies: the motions, the fields, the file that HDF5
      ! makes of them and its bytes.
      integer, parameter :: figures = 8, times = 4
      integer :: i, n, done, total
      logical :: keep_going, stopped, resumed

      total = motions_of(settings)
      resumed = allocated(result%motions) .and. .not. allocated(result%ended)
      if (resumed) resumed = size(result%motions) == total
      if (.not. resumed) result = empty
      call check_integration(train, settings, error)
      if (allocated(error)) return
      call build_system(train, system)
      call need_to_find(system, settings, error)
      if (allocated(error)) return
      allocate (state(system%states))
      state = resting_state(system)
      low = min(settings%start, settings%stop)*lambda_per(train, settings%unit)
      high = max(settings%start, settings%stop)*lambda_per(train, settings%unit)
      n = settings%points
      if (.not. resumed) then
         n = settings%harmonics
         if (n == 0) n = stored_harmonics(system)
         if (goes_by_windows(system, settings%window)) n = ceiling(n*window_of(system, settings%window))
         call need(real(total, dp)*(storage_size(motion)/8 + 8*times*(2*n + 1 + figures)*system%meshes), &
                   'integration: no memory for '//text(total)//' motions', 'take fewer points', error)
         n = settings%points
         if (allocated(error)) return
         allocate (result%motions(total), result%direction(total))
      end if
      result%direction = 'up'
      if (settings%direction == 'down') result%direction = 'down'
      if (settings%direction == 'both') result%direction(n + 1:) = 'down'
      done = count(result%motions%frequency_ratio > 0)
      if (done > 0) then
         if (allocated(result%motions(done)%coefficients)) state = result%motions(done)%state
      end if
      do i = done + 1, total
         frequency_ratio = low
         if (n > 1) frequency_ratio = low + (high - low)*(mod(i - 1, n)/real(n - 1, dp))
         if (mod(i, n) == 0 .and. n > 1) frequency_ratio = high
         if (result%direction(i) == 'down') frequency_ratio = low + high - frequency_ratio
         call find_steady(system, frequency_ratio, settings, state, motion, observer, stopped)
         if (stopped) exit
         ! Only a complete motion is stored: a motion with a frequency counts as done where the sweep is taken up again.
         result%motions(i) = motion
         if (.not. allocated(motion%coefficients)) state = resting_state(system)
         done = i
         if (.not. present(observer)) cycle
         keep_going = .true.
         call observer%on_step('integration', i, frequency_ratio, keep_going)
         if (.not. keep_going) exit
      end do
      result%complete = done == total
      result%ended = words_type('all points done')
      if (.not. result%complete) result%ended = 'cancelled at '//lambda(frequency_ratio)
      result%ended = result%ended//note_of(any(result%motions%floating))
      if (result%complete) return
      result%motions = result%motions(:done)
      result%direction = result%direction(:done)
   end subroutine sweep

   !> Number of motions of a complete sweep.
   pure integer function motions_of(settings)
      type(integration_settings_type), intent(in) :: settings

      motions_of = settings%points*merge(2, 1, settings%direction == 'both')
   end function motions_of

   !> Integrates until the motion is steady. Fails where the motion grows without bound.
   subroutine integrate(train, frequency_ratio, settings, motion, error, start, observer)
      !> The train as described.
      type(train_type), intent(in) :: train
      !> Lambda [1], > 0.
      real(dp), intent(in) :: frequency_ratio
      !> Settings, of which the range, `points` and `direction` are not used.
      type(integration_settings_type), intent(in) :: settings
      !> The motion; period 0: no period was found within max_periods, and the figures are those of the last 16 periods of the
      !> fundamental, or of `window`.
      type(motion_type), intent(out) :: motion
      type(error_type), allocatable, intent(out) :: error
      !> Motion to start from, with a state or coefficients; absent: at rest under the mean load.
      type(motion_type), intent(in), optional :: start
      !> Told of 'settling'; may end it.
      class(observer_type), intent(inout), optional :: observer
      type(system_type) :: system
      real(dp), allocatable :: state(:)
      logical :: stopped

      call check_train(train, error)
      if (allocated(error)) return
      call check_single(train, settings, frequency_ratio, error)
      if (allocated(error)) return
      call build_system(train, system)
      call need_to_find(system, settings, error)
      if (allocated(error)) return
      allocate (state(system%states))
      state = resting_state(system)
      if (present(start)) then
         call check_start(system, start, error)
         if (allocated(error)) return
         call state_of(system, start, state, -frequency_ratio*time_before(system, frequency_ratio, settings))
      end if
      call find_steady(system, frequency_ratio, settings, state, motion, observer, stopped)
      if (stopped .or. system%interrupt%raised()) then
         call fatal(error, 'interrupted before the motion was steady', status_ended_early)
         return
      else if (.not. allocated(motion%coefficients)) then
         call fatal(error, 'the motion grows without bound at '//lambda(frequency_ratio)// &
                    ': it was given up at a displacement of '//text(maxval(abs(state(:system%displacements))))// &
                    ' characteristic lengths', status_ended_early)
      end if
   end subroutine integrate

   !> Checks a single frequency and the settings, whose range is not used.
   subroutine check_single(train, settings, frequency_ratio, error)
      type(train_type), intent(in) :: train
      type(integration_settings_type), intent(in) :: settings
      real(dp), intent(in) :: frequency_ratio
      type(error_type), allocatable, intent(inout) :: error
      type(integration_settings_type) :: single
      type(checker_type) :: checker
      type(train_type) :: plain

      if (.not. (frequency_ratio > 0 .and. frequency_ratio <= huge(1.0_dp))) then
         call checker%complain('frequency', real_text(frequency_ratio), 'must be a finite number > 0')
      else
         call plain_train(train, plain)
         call check_frequency(plain, ['frequency'], [frequency_ratio], checker)
      end if
      call checker%problems%raise('', error)
      if (allocated(error)) return
      single = settings
      single%unit = 'Lambda'
      single%start = frequency_ratio
      single%stop = frequency_ratio
      single%points = 1
      call check_integration(train, single, error)
   end subroutine check_single

   subroutine visit_fields(self, train, fields, summary)
      class(integration_analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      class(fields_type), intent(inout) :: fields
      logical, intent(in) :: summary
      integer :: points

      points = 0
      if (self%asked) points = motions_of(self%settings)
      call visit_sweep(self%result, points, fields)
   end subroutine visit_fields

   !> Visits the motions of a sweep that are done.
   subroutine visit_sweep(sweep, points, fields)
      type(sweep_type), intent(inout) :: sweep
      !> Number of motions of the complete sweep; 0: the case does not ask for integration.
      integer, intent(in) :: points
      class(fields_type), intent(inout) :: fields
      type(motion_type), allocatable :: motions(:)
      character(4), allocatable :: direction(:)
      integer :: n, i

      if (.not. fields%enter('/integration', 'steady motions by time integration over a range of frequencies; each starts from the &
         &final state before', .true.)) return
      n = 0
      if (allocated(sweep%motions)) n = count(sweep%motions%frequency_ratio > 0)
      if (n > 0) call fields%describe('coordinates', 'frequency direction')
      call carry_words(fields, field('ended', '', '', 'why it ended, in words'), &
                       sweep%ended, 'not yet: these are the points so far')
      call carry(fields, field('complete', '', '', '1 = all points are done'), sweep%complete)
      call fields%index_axis('point', n, 'point, in the order visited')
      if (allocated(fields%wrong)) return
      if (fields%way == reading) then
         call fields%check(n <= points .and. (n == points .or. .not. sweep%complete), 'point')
         if (allocated(fields%wrong)) return
         ! A sweep that has not ended goes on: it gets room for all motions.
         allocate (sweep%motions(merge(n, points, allocated(sweep%ended))))
         allocate (sweep%direction(size(sweep%motions)), source='    ')
         allocate (direction(n), source='    ')
      else if (allocated(sweep%motions)) then
         direction = sweep%direction(:n)
      end if
      if (n == 0 .and. fields%way /= listing) return
      call move_alloc(sweep%motions, motions)
      call visit_motions(motions, 'point', fields)
      call move_alloc(motions, sweep%motions)
      if (fields%way == reading) &
         call fields%check(all([(allocated(sweep%motions(i)%state) .and. sweep%motions(i)%frequency_ratio > 0, i=1, n)]), &
                           'initial_state')
      call carry(fields, field('direction', 'point', '', 'direction of the sweep: up or down'), direction)
      if (fields%way == reading .and. .not. allocated(fields%wrong)) sweep%direction(:n) = direction
   end subroutine visit_sweep

   subroutine report(self, train, sheet, torques)
      class(integration_analysis_type), intent(in) :: self
      type(train_type), intent(in) :: train
      type(sheet_type), intent(inout) :: sheet
      type(torque_table_type), intent(inout) :: torques

      call report_sweep(self%result%motions, self%result%ended, self%settings, train, sheet, torques)
   end subroutine report

end module geartrain_analyses_integration
