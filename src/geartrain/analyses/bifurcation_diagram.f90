!> The analysis &bifurcation_diagram: what the flow does in the long run over frequency: sections of the attractor, its period, its
!> Lyapunov exponents and its rotation number, each frequency begun with the last state of the frequency before.
module geartrain_analyses_bifurcation_diagram
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
   use geartrain_analyses_analysis, only: analysis_type, group_row_type
   use geartrain_base_words, only: words_type
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_carry, only: carry, carry_text
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type
   use geartrain_base_field, only: field => field_type
   use geartrain_base_fields, only: fields_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_memory, only: need
   use geartrain_base_numbers, only: counted, integer_text, text
   use geartrain_base_observer, only: observer_type
   use geartrain_base_variable, only: row => variable_type, visitor_type
   use geartrain_flow_motion_fields, only: about_frequency, about_mesh
   use geartrain_flow_long_run, only: find_long_run
   use geartrain_flow_start_state, only: resting_state, state_of
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_network_frequency_unit, only: check_unit, lambda_per, unit_length, visit_unit
   use geartrain_network_limits, only: check_frequency
   use geartrain_network_long_period, only: check_long_period, visit_long_period
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_train, only: train_type
   use geartrain_base_sheet, only: in_quality, in_result, sheet_type
   use geartrain_analyses_torque_table, only: torque_table_type
   implicit none (type, external)
   private
   public :: bifurcation_diagram, bifurcation_diagram_analysis_type, bifurcation_diagram_row, bifurcation_diagram_settings_type, &
      bifurcation_diagram_type

   type(group_row_type), parameter :: bifurcation_diagram_row = group_row_type('bifurcation_diagram', &
      'Asks for a bifurcation diagram: sections of the attractors over frequency, with their Lyapunov exponents.', set_aside=.true.)

   real(dp), parameter :: zero = 0, one = 1
   !> Most sections of one frequency.
   real(dp), parameter :: most_sections = 1e5_dp

   !> The variables of &bifurcation_diagram.
   type :: bifurcation_diagram_settings_type
      !> Ends of the range, by default of Lambda.
      real(dp) :: start = 0, stop = 0
      !> Unit of these frequencies: 'Lambda', 'rpm' or 'Hz'.
      character(unit_length) :: unit = 'Lambda'
      !> Frequencies in the range, both ends included.
      integer :: points = 200
      !> Order in which the frequencies are visited: 'up', 'down' or 'both'.
      character(16) :: direction = 'both'
      !> Periods of the fundamental before the sections of a frequency; sections.
      integer :: transient = 500, sections = 200
      !> Whether it is computed even where the period is long.
      logical :: long_period = .false.
   end type bifurcation_diagram_settings_type

   !> A bifurcation diagram; a row is a frequency of a direction, in the order visited.
   type :: bifurcation_diagram_type
      !> Lambda [1], (row).
      real(dp), allocatable :: frequency_ratio(:)
      !> 'up' or 'down', (row); as of motion_type, but without 'still settling', or '' where the row is not done, (row).
      character(14), allocatable :: direction(:), kind(:)
      !> Period [periods of the fundamental]; 0: none found, (row).
      integer, allocatable :: period(:)
      !> Displacements and velocities of the meshes at phase 0 of successive periods [1], (mesh, section, row).
      real(dp), allocatable :: displacement(:, :, :), velocity(:, :, :)
      !> Lyapunov exponents per unit of time, largest first, and their uncertainty at 95 % [1], (state, row).
      real(dp), allocatable :: exponents(:, :), errors(:, :)
      !> Rotation number [1], (row), see geartrain_flow_spectrum; NaN: not quasi-periodic.
      real(dp), allocatable :: rotation(:)
      !> Last state at phase 0 [1], (state, row), with which the next frequency begins.
      real(dp), allocatable :: state(:, :)
      !> 'all points done', or why not; not allocated: the diagram is under way.
      character(:), allocatable :: ended
      !> Whether all frequencies are done.
      logical :: complete = .false.
   end type bifurcation_diagram_type

   type, extends(analysis_type) :: bifurcation_diagram_analysis_type
      type(bifurcation_diagram_settings_type), pointer :: settings => null()
      type(bifurcation_diagram_type), pointer :: result => null()
   contains
      procedure :: visit_variables
      procedure :: check
      procedure :: run
      procedure :: tell_end
      procedure :: visit_fields
      procedure :: report
   end type bifurcation_diagram_analysis_type

contains

   subroutine visit_variables(self, v)
      class(bifurcation_diagram_analysis_type), intent(inout) :: self
      class(visitor_type), intent(inout) :: v
      character(:), allocatable :: word

      associate (settings => self%settings)
         call v%enter('bifurcation_diagram', 1)
         call v%on_real(row('from', '', 'one end of the frequency range', required=.true., above=zero), &
                        settings%start)
         call v%on_real(row('to', '', 'other end of the frequency range', required=.true., above=zero), settings%stop)
         call visit_unit(settings%unit, v)
         call v%on_integer(row('points', '', 'frequencies in the range, both ends included', least=one, most=1e5*one), &
                           settings%points)
         word = trim(settings%direction)
         call v%on_text(row('direction', '', 'order of the frequencies; each starts from the last state before', choices='up down &
                            &both'), word)
         settings%direction = word
         call v%on_integer(row('transient', '', 'periods of the fundamental that are left out before the sections', least=zero), &
                           settings%transient)
         call v%on_integer(row('sections', '', 'sections at each frequency, one at phase 0 of each period of the fundamental', &
                               least=10*one, most=most_sections), settings%sections)
         call visit_long_period(settings%long_period, v)
         call v%leave()
      end associate
   end subroutine visit_variables

   subroutine check(self, train, seeded, checker)
      class(bifurcation_diagram_analysis_type), intent(in) :: self
      type(train_type), intent(in) :: train
      logical, intent(in) :: seeded
      class(checker_type), intent(inout) :: checker
      logical :: at_one
      type(train_type) :: plain

      associate (settings => self%settings)
         if (checker%problems%in_group('bifurcation_diagram')) return
         call checker%enter('bifurcation_diagram', 1)
         at_one = abs(settings%start - settings%stop) <= 0
         if (at_one .and. settings%points > 1) call checker%complain('points', integer_text(settings%points), &
            'must be 1, as "from" and "to" are equal')
         if (.not. at_one .and. settings%points == 1) call checker%complain('points', '1', &
            'must be 2 or more, as "from" and "to" differ')
         call check_unit(train, settings%unit, checker)
         call plain_train(train, plain)
         call check_frequency(plain, ['from', 'to  '], [settings%start, settings%stop], checker, settings%unit)
         call check_long_period(train, 'bifurcation_diagram', 'every section is a period later', settings%long_period, checker)
         call checker%leave()
      end associate
   end subroutine check

   subroutine run(self, train, error, observer, start)
      class(bifurcation_diagram_analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      type(error_type), allocatable, intent(out) :: error
      class(observer_type), intent(inout) :: observer
      type(motion_type), intent(in), optional :: start

      if (.not. allocated(self%result%ended)) &
         call bifurcation_diagram(train, self%settings, self%result, error, observer, start)
   end subroutine run

   subroutine tell_end(self, early)
      class(bifurcation_diagram_analysis_type), intent(in) :: self
      type(words_type), allocatable, intent(out) :: early

      if (.not. self%result%complete) early = words_type(self%result%ended)
   end subroutine tell_end

   !> Follows the attractor over frequency; the directions in parallel.
   subroutine bifurcation_diagram(train, settings, found, error, observer, start)
      !> The train as described.
      type(train_type), intent(in) :: train
      !> Frequencies, directions and what else &bifurcation_diagram asks for.
      type(bifurcation_diagram_settings_type), intent(in) :: settings
      !> The diagram. A diagram under way, with `kind` but without `ended` as in a checkpoint of the same case, is taken up. A
      !> target: an observer may read the rows so far through a pointer.
      type(bifurcation_diagram_type), intent(inout), target :: found
      type(error_type), allocatable, intent(out) :: error
      !> Told of 'bifurcation diagram' after each frequency, by one thread at a time; may end the work.
      class(observer_type), intent(inout), optional :: observer
      !> Motion to begin with; absent: at rest.
      type(motion_type), intent(in), optional :: start
      type(bifurcation_diagram_settings_type), target :: copy
      type(bifurcation_diagram_analysis_type) :: analysis
      type(system_type) :: system
      real(dp), allocatable :: first(:)
      integer :: way
      logical :: keep_going

      copy = settings
      analysis%settings => copy
      call analysis%check_alone(train, error)
      if (allocated(error)) return
      call build_system(train, system)
      if (allocated(found%ended) .or. .not. allocated(found%kind)) call make_room(train, system, settings, found, error)
      if (allocated(error)) return
      first = resting_state(system)
      if (present(start)) call state_of(system, start, first)
      keep_going = .true.
      !$omp parallel do schedule(dynamic)
      do way = 1, size(found%kind)/settings%points
         call follow(system, settings, first, (way - 1)*settings%points + 1, way*settings%points, found, keep_going, observer)
      end do
      !$omp end parallel do
      associate (done => count(found%kind /= ''), all_ => size(found%kind))
         found%complete = done == all_
         found%ended = 'all points done'
         if (done < all_) found%ended = 'cancelled after '//text(done)//' of '//text(all_)//' points'
      end associate
   end subroutine bifurcation_diagram

   !> Makes an empty diagram.
   subroutine make_room(train, system, settings, found, error)
      type(train_type), intent(in) :: train
      type(system_type), intent(in) :: system
      type(bifurcation_diagram_settings_type), intent(in) :: settings
      type(bifurcation_diagram_type), intent(inout) :: found
      type(error_type), allocatable, intent(inout) :: error
      type(bifurcation_diagram_type) :: empty
      ! Number of copies: the diagram, the fields, the file that HDF5 makes of them and its bytes.
      integer, parameter :: times = 4
      real(dp) :: low, high, nan
      integer :: rows, i

      nan = ieee_value(nan, ieee_quiet_nan)
      found = empty
      associate (points => settings%points)
         rows = points*merge(2, 1, settings%direction == 'both')
         low = min(settings%start, settings%stop)
         high = max(settings%start, settings%stop)
         call need(8.0_dp*times*rows*(2.0_dp*system%meshes*settings%sections + 3*system%states), &
                   'bifurcation diagram: no memory for '//text(rows)//' times '//text(settings%sections)//' sections', &
                   'take fewer', error)
         if (allocated(error)) then
            found = empty
            return
         end if
         allocate (found%displacement(system%meshes, settings%sections, rows), &
                   found%velocity(system%meshes, settings%sections, rows), source=nan)
         allocate (found%exponents(system%states, rows), found%errors(system%states, rows), found%state(system%states, rows), &
                   found%rotation(rows), source=nan)
         found%frequency_ratio = [(low + (high - low)*(i - 1)/max(1, points - 1), i=1, points)]
         if (points > 1) found%frequency_ratio(points) = high
         if (settings%direction == 'down') found%frequency_ratio = found%frequency_ratio(points:1:-1)
         if (settings%direction == 'both') found%frequency_ratio = [found%frequency_ratio, found%frequency_ratio(points:1:-1)]
         found%frequency_ratio = found%frequency_ratio*lambda_per(train, settings%unit)
         allocate (found%direction(rows), found%kind(rows), found%period(rows))
         found%kind = ''
         found%period = 0
         found%direction = 'up'
         if (settings%direction /= 'up') found%direction(rows - points + 1:) = 'down'
      end associate
   end subroutine make_room

   !> Follows the attractor over the rows of one direction.
   subroutine follow(system, settings, first_state, first, last, found, keep_going, observer)
      type(system_type), intent(in) :: system
      type(bifurcation_diagram_settings_type), intent(in) :: settings
      real(dp), intent(in) :: first_state(:)
      integer, intent(in) :: first, last
      type(bifurcation_diagram_type), intent(inout) :: found
      logical, intent(inout) :: keep_going
      class(observer_type), intent(inout), optional :: observer
      real(dp) :: state(size(first_state))
      integer :: i
      logical :: go

      state = first_state
      do i = first, last
         if (found%kind(i) /= '') then
            state = found%state(:, i)
            cycle
         end if
         !$omp atomic read
         go = keep_going
         if (.not. go) return
         if (.not. all(abs(state) < huge(one))) state = resting_state(system)
         call settle_row(system, settings, state, i, found)
         if (system%interrupt%raised()) then
            found%kind(i) = ''
            return
         end if
         if (.not. present(observer)) cycle
         !$omp critical (geartrain_diagram)
         go = keep_going
         if (go) call observer%on_step('bifurcation diagram', count(found%kind /= ''), found%frequency_ratio(i), go)
         !$omp atomic write
         keep_going = go
         !$omp end critical (geartrain_diagram)
      end do
   end subroutine follow

   !> Finds what one row has.
   subroutine settle_row(system, settings, state, i, found)
      type(system_type), target, intent(in) :: system
      type(bifurcation_diagram_settings_type), intent(in) :: settings
      !> State to begin with, then the last one [1], (state).
      real(dp), intent(inout) :: state(:)
      !> The row.
      integer, intent(in) :: i
      type(bifurcation_diagram_type), intent(inout) :: found
      real(dp) :: sections(size(state), settings%sections)
      integer :: j

      call find_long_run(system, found%frequency_ratio(i), settings%transient, state, sections, found%exponents(:, i), &
                         found%errors(:, i), found%period(i), found%kind(i), found%rotation(i))
      found%state(:, i) = state
      if (ieee_is_nan(sections(1, 1))) return
      do j = 1, system%meshes
         associate (n => system%mesh_element(j), d => system%displacements)
            if (n > system%coordinates) cycle
            found%displacement(j, :, i) = sections(n, :)
            found%velocity(j, :, i) = sections(d + n, :)
         end associate
      end do
   end subroutine settle_row

   subroutine visit_fields(self, train, fields, summary)
      class(bifurcation_diagram_analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      class(fields_type), intent(inout) :: fields
      logical, intent(in) :: summary
      integer :: meshes, rows, sections, states

      associate (found => self%result)
         if (.not. fields%enter('/bifurcation_diagram', 'sections of the attractors over frequency', .true.)) return
         call carry_text(fields, field('ended', '', '', 'why it ended, in words'), found%ended, &
                         'not yet: these are the points so far')
         call carry(fields, field('complete', '', '', '1 = all points are done'), found%complete)
         meshes = 0
         rows = 0
         sections = 0
         states = 0
         if (allocated(found%displacement)) then
            meshes = size(found%displacement, 1)
            sections = size(found%displacement, 2)
            rows = size(found%displacement, 3)
            states = size(found%state, 1)
         end if
         call fields%index_axis('point', rows, 'point, in the order visited')
         call fields%index_axis('section', sections, 'section: phase 0 of successive periods of the fundamental')
         call fields%index_axis('mesh', meshes, about_mesh)
         call fields%index_axis('state', states, 'number of the exponent, or of the coordinate of the state')
         call carry(fields, field('frequency', 'point', '1', about_frequency), found%frequency_ratio)
         call carry(fields, field('direction', 'point', '', 'direction of the sweep: up or down'), found%direction)
         call carry(fields, field('kind', 'point', '', 'periodic, quasi-periodic, chaotic, still settling (or a period above half &
                                  &the sections), undecided, unbounded; blank: not done'), found%kind)
         call carry(fields, field('period', 'point', '1', 'period in periods of the fundamental; 0 = none found', least=0), &
                    found%period)
         call carry(fields, field('displacement', 'point section mesh', '1', 'mesh displacement at phase 0 / characteristic_length&
                                &; NaN: of a mesh that closes a loop, or not done'), found%displacement)
         call carry(fields, field('velocity', 'point section mesh', '1', 'mesh velocity at phase 0 / (characteristic_length times &
                                  &characteristic_frequency)'), found%velocity)
         call carry(fields, field('lyapunov_exponents', 'point state', '1', 'Lyapunov exponents / characteristic_frequency, &
                                  &largest first'), found%exponents)
         call carry(fields, field('lyapunov_errors', 'point state', '1', 'uncertainties of lyapunov_exponents at 95 %'), &
                                  found%errors)
         call carry(fields, field('rotation_number', 'point', '1', 'of a quasi-periodic motion: turns of the sections about their &
                                  &centre per period of the fundamental, 0 to 1/2, or 0 to 1/(2n) on n curves; NaN of any other &
                                  &motion'), found%rotation)
         call carry(fields, field('final_state', 'point state', '1', 'state at phase 0 after the last section; the next point &
                                  &starts from it'), found%state)
      end associate
   end subroutine visit_fields

   subroutine report(self, train, sheet, torques)
      class(bifurcation_diagram_analysis_type), intent(in) :: self
      type(train_type), intent(in) :: train
      type(sheet_type), intent(inout) :: sheet
      type(torque_table_type), intent(inout) :: torques
      character(14), parameter :: kinds(6) = [character(14) :: 'periodic', 'quasi-periodic', 'chaotic', 'still settling', &
                                              'undecided', 'unbounded']
      character(:), allocatable :: words
      integer :: i

      associate (found => self%result, unused => torques, unused_train => train)
         words = 'Bifurcation diagram: '//counted(size(found%kind), 'motion', 'motions')
         do i = 1, size(kinds)
            if (any(found%kind == kinds(i))) words = words//', '//text(count(found%kind == kinds(i)))//' '//trim(kinds(i))
         end do
         call sheet%say(in_result, words//'.')
         if (.not. allocated(found%ended)) return
         if (found%ended /= 'all points done' .or. sheet%verbose) &
            call sheet%say(in_quality, 'The bifurcation diagram ended: '//found%ended//'.')
      end associate
   end subroutine report

end module geartrain_analyses_bifurcation_diagram
