!> The analysis &basins: which steady motion each start reaches, over displacement and velocity of a mesh at phase 0.
!>
!> The steady motions are found by random starts first (geartrain_analyses_attractors). Each start of the grid then flies by a
!> tabulated map from section to section until it is in a ball about a known motion (geartrain_flow_recognition), or, without
!> tables, until it clearly goes to one (geartrain_flow_approach). What has come to none after `max_periods` is compared with the
!> motions without period that are known (geartrain_flow_aperiodic), or else settled the long way, where it may find a further
!> motion.
module geartrain_analyses_basins
   use geartrain_analyses_analysis, only: analysis_type, group_row_type
   use geartrain_analyses_attractors, only: attractors, attractors_settings_type, attractors_type, collect, error_share
   use geartrain_analyses_basin_grid, only: basins_settings_type, basins_type, check_basins, not_done, ran_away, unsettled, &
      visit_basins
   use geartrain_base_words, only: words_type
   use geartrain_readings_frequency_text, only: frequency_text, frequency_text_type
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type
   use geartrain_base_fields, only: fields_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_memory, only: need
   use geartrain_base_numbers, only: fixed, text
   use geartrain_base_observer, only: observer_type
   use geartrain_base_shared_observer, only: shared_observer_type
   use geartrain_base_variable, only: visitor_type
   use geartrain_flow_aperiodic, only: aperiodic_type
   use geartrain_flow_approach, only: approach_type
   use geartrain_flow_bound, only: bound_type
   use geartrain_flow_integration_settings, only: integration_settings_type
   use geartrain_flow_recognition, only: recognition_type
   use geartrain_flow_section_map, only: section_map_type
   use geartrain_flow_settling, only: settle
   use geartrain_flow_start_state, only: resting_state, state_of
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_train, only: train_type
   use geartrain_network_units, only: mesh_frequencies
   use geartrain_analyses_planet_loads, only: say_orbits
   use geartrain_base_sheet, only: in_quality, in_result, sheet_type
   use geartrain_analyses_torque_table, only: torque_table_type
   implicit none (type, external)
   private
   public :: basins, basins_analysis_type, basins_row

   type(group_row_type), parameter :: basins_row = group_row_type('basins', 'Asks for the basins of attraction at one frequency: &
      &which steady motion each start reaches.', steps='rows', set_aside=.true.)

   !> Starts over the resting displacement of the mesh, unless the range is given.
   real(dp), parameter :: reach = 3
   !> Least starts between two calls of the observer, which fly in parallel: whole rows.
   integer, parameter :: batch = 256
   !> Periods of the fundamental after which the long way gives up, beyond `max_periods`.
   integer, parameter :: long_way = 64
   !> Periods of the fundamental between two calls of the observer in a flight.
   integer, parameter :: between_looks = 64
   !> Periods of the fundamental over which motions without period are averaged, and starts that are compared with them.
   integer, parameter :: average = 2000, short_average = 300

   type, extends(analysis_type) :: basins_analysis_type
      type(basins_settings_type), pointer :: settings => null()
      type(basins_type), pointer :: result => null()
   contains
      procedure :: visit_variables
      procedure :: check
      procedure :: run
      procedure :: tell_end
      procedure :: visit_fields
      procedure :: report
   end type basins_analysis_type

contains

   subroutine visit_variables(self, v)
      class(basins_analysis_type), intent(inout) :: self
      class(visitor_type), intent(inout) :: v

      call visit_basins(self%settings, v)
   end subroutine visit_variables

   subroutine check(self, train, seeded, checker)
      class(basins_analysis_type), intent(in) :: self
      type(train_type), intent(in) :: train
      logical, intent(in) :: seeded
      class(checker_type), intent(inout) :: checker

      call check_basins(train, self%settings, checker)
   end subroutine check

   subroutine run(self, train, error, observer, start)
      class(basins_analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      type(error_type), allocatable, intent(out) :: error
      class(observer_type), intent(inout) :: observer
      type(motion_type), intent(in), optional :: start

      if (.not. allocated(self%result%ended)) call basins(train, self%settings, self%result, error, observer, start)
   end subroutine run

   subroutine tell_end(self, early)
      class(basins_analysis_type), intent(in) :: self
      type(words_type), allocatable, intent(out) :: early

      if (self%result%complete) return
      early = words_type('cancelled while motions were sought by random starts')
      if (allocated(self%result%ended)) early = words_type(self%result%ended)
   end subroutine tell_end

   !> Finds the motion that each start of a grid reaches, in parallel; the results do not depend on the number of threads.
   subroutine basins(train, settings, found, error, observer, start)
      !> The train as described.
      type(train_type), intent(in) :: train
      !> Frequency, grid and what else &basins asks for.
      type(basins_settings_type), intent(in) :: settings
      !> The basins. Those under way, with `label` but without `ended` as in a checkpoint of the same case, are taken up. A target:
      !> an observer may read the rows so far through a pointer.
      type(basins_type), intent(inout), target :: found
      type(error_type), allocatable, intent(out) :: error
      !> Told of 'random starts' while motions are sought, then of 'basins', after each start, and meanwhile; may end the work,
      !> which then holds the rows of whole batches.
      class(observer_type), intent(inout), optional, target :: observer
      !> Motion whose state at phase 0 the starts have but for the displacement and the velocity of the mesh; absent: at rest.
      type(motion_type), intent(in), optional :: start
      type(basins_settings_type), target :: copy
      type(basins_analysis_type) :: analysis
      type(system_type), target :: system
      type(section_map_type) :: map
      type(recognition_type), allocatable :: known(:)
      type(aperiodic_type), allocatable :: wandering(:)
      integer, allocatable :: hits(:)
      type(shared_observer_type) :: shared
      integer :: done, rows, i
      logical :: keep_going

      copy = settings
      analysis%settings => copy
      call analysis%check_alone(train, error)
      if (allocated(error)) return
      call build_system(train, system)
      if (allocated(found%ended) .or. .not. allocated(found%label)) &
         call begin(train, system, settings, found, error, start, observer)
      if (allocated(error) .or. .not. allocated(found%label)) return
      call map%setup(system, found%frequency_ratio)
      allocate (known(0), wandering(size(found%motions)))
      do i = 1, size(wandering)
         if (found%motions(i)%period == 0) call wandering(i)%find(system, map, found%motions(i)%state, average)
      end do
      hits = [(0, i=1, size(found%motions))]
      keep_going = .true.
      shared%name = 'basins'
      if (present(observer)) shared%observer => observer
      shared%frequency_ratio = found%frequency_ratio
      shared%pieces = settings%displacement_points
      rows = max(1, batch/settings%displacement_points)
      done = count(found%label(1, :) /= not_done)
      do while (done < settings%velocity_points .and. keep_going)
         call recognise_more(system, map, found%motions, known)
         i = min(done + rows, settings%velocity_points)
         shared%done = done
         shared%pieces_done = 0
         call label_rows(system, settings, map, known, wandering, done + 1, i, found, hits, shared)
         if (train%interrupt%raised() .or. .not. shared%keep_going) then
            found%label(:, done + 1:i) = not_done
            exit
         end if
         done = i
         if (present(observer)) call observer%on_step('basins', done, found%frequency_ratio, keep_going)
      end do
      call found%conclude(done)
   end subroutine basins

   !> Finds motions by random starts, and makes the grid.
   subroutine begin(train, system, settings, found, error, start, observer)
      type(train_type), intent(in) :: train
      type(system_type), intent(in) :: system
      type(basins_settings_type), intent(in) :: settings
      type(basins_type), intent(inout) :: found
      type(error_type), allocatable, intent(inout) :: error
      type(motion_type), intent(in), optional :: start
      class(observer_type), intent(inout), optional :: observer
      type(attractors_settings_type) :: random
      type(attractors_type) :: by_chance
      ! Number of copies: the labels, the fields, a field on its way, the file that HDF5 makes of them and its bytes.
      integer, parameter :: times = 5
      type(basins_type) :: empty
      real(dp) :: farthest, frequency(system%meshes)

      found = empty
      call need(4.0_dp*times*settings%displacement_points*settings%velocity_points, 'basins: no memory for '// &
                text(settings%displacement_points)//' times '//text(settings%velocity_points)//' starts', 'take fewer', error)
      if (allocated(error)) return
      random%frequency = settings%frequency
      random%unit = settings%unit
      random%starts = settings%starts
      random%random_seed = settings%random_seed
      random%long_period = settings%long_period
      call attractors(train, random, by_chance, error, observer, 'random starts')
      if (allocated(error) .or. .not. by_chance%complete) return
      found%frequency_ratio = by_chance%frequency_ratio
      found%mesh = settings%mesh
      found%starts = settings%starts
      found%random_seed = settings%random_seed
      found%motions = by_chance%motions
      found%displacement_place = system%mesh_element(settings%mesh)
      found%velocity_place = system%displacements + found%displacement_place
      found%base = resting_state(system)
      farthest = reach*max(abs(found%base(found%displacement_place)), system%half_backlash(settings%mesh))
      frequency = mesh_frequencies(system)
      if (present(start)) call state_of(system, start, found%base)
      associate (s => settings)
         found%displacement = spaced(s%displacement_start, s%displacement_stop, s%displacement_points, farthest)
         found%velocity = spaced(s%velocity_start, s%velocity_stop, s%velocity_points, frequency(s%mesh)*farthest)
         allocate (found%label(s%displacement_points, s%velocity_points), source=not_done)
      end associate

   contains

      !> Equally spaced values, ends exact; by default over the range of the random starts.
      pure function spaced(from, to, points, farthest) result(values)
         real(dp), intent(in) :: from, to, farthest
         integer, intent(in) :: points
         real(dp) :: values(points), first, last
         integer :: i

         first = from
         last = to
         if (.not. (abs(from) > 0 .or. abs(to) > 0)) then
            first = -farthest
            last = farthest
         end if
         values = [(first + (last - first)*(i - 1)/max(1, points - 1), i=1, points)]
         if (points > 1) values(points) = last
      end function spaced

   end subroutine begin

   !> Appends the balls of motions that have none yet.
   subroutine recognise_more(system, map, motions, known)
      type(system_type), intent(in) :: system
      type(section_map_type), intent(in) :: map
      type(motion_type), intent(in) :: motions(:)
      type(recognition_type), allocatable, intent(inout) :: known(:)
      type(recognition_type), allocatable :: more(:)
      integer :: i, n

      n = size(known)
      if (n == size(motions)) return
      allocate (more(size(motions)))
      more(:n) = known
      do i = n + 1, size(motions)
         call more(i)%setup(system, map, motions(i)%period, motions(i)%state)
      end do
      call move_alloc(more, known)
   end subroutine recognise_more

   !> Labels the starts of some rows.
   subroutine label_rows(system, settings, map, known, wandering, first, last, found, hits, shared)
      type(system_type), intent(in) :: system
      type(basins_settings_type), intent(in) :: settings
      type(section_map_type), intent(in) :: map
      type(recognition_type), intent(in) :: known(:)
      !> What the motions without period do, (motion).
      type(aperiodic_type), allocatable, intent(inout) :: wandering(:)
      !> First and last row.
      integer, intent(in) :: first, last
      type(basins_type), intent(inout) :: found
      integer, allocatable, intent(inout) :: hits(:)
      !> Told of each start that is labelled, and meanwhile.
      type(shared_observer_type), intent(inout) :: shared
      type(bound_type) :: bound
      type(approach_type) :: approach
      type(integration_settings_type) :: integration
      type(motion_type), allocatable :: settled(:)
      type(aperiodic_type), allocatable :: these(:)
      real(dp) :: state(size(found%base)), states(size(found%base), (last - first + 1)*size(found%displacement))
      integer :: label((last - first + 1)*size(found%displacement)), i
      integer, allocatable :: left(:)

      call bound%setup(system, found%frequency_ratio)
      do i = 1, size(known)
         if (allocated(known(i)%attraction)) call approach%add(known(i)%attraction, i)
      end do
      associate (points => size(found%displacement))
         !$omp parallel do private(state) schedule(dynamic, 8)
         do i = 1, size(label)
            state = found%base
            state(found%displacement_place) = found%displacement(mod(i - 1, points) + 1)
            state(found%velocity_place) = found%velocity(first + (i - 1)/points)
            call label_start(system, settings%max_periods, map, bound, known, approach, state, label(i), shared)
            states(:, i) = state
            if (label(i) /= unsettled) call shared%add()
         end do
         !$omp end parallel do
         left = pack([(i, i=1, size(label))], label == unsettled)
         allocate (settled(size(left)), these(size(left)))
         integration%max_periods = long_way
         integration%stability = .true.
         !$omp parallel do private(state) schedule(dynamic)
         do i = 1, size(left)
            if (.not. shared%keep_going) cycle
            state = states(:, left(i))
            call these(i)%find(system, map, state, short_average)
            label(left(i)) = place_of(these(i), wandering)
            if (label(left(i)) == unsettled) call settle(system, found%frequency_ratio, integration, state, settled(i), shared)
            call shared%add()
         end do
         !$omp end parallel do
         if (system%interrupt%raised() .or. .not. shared%keep_going) return
         do i = 1, size(left)
            if (label(left(i)) > 0) cycle
            if (settled(i)%kind == 'undecided') then
               ! The first such start of a batch adds the motion, the others are the same.
               settled(i)%kind = these(i)%kind
               settled(i)%lyapunov_exponent = these(i)%exponent
               settled(i)%lyapunov_error = these(i)%error
            end if
            settled(i)%share = 0
            call collect(settled(i), error_share*integration%tolerance, found%motions, hits, label(left(i)), these(i), wandering)
            if (settled(i)%kind == 'unbounded') label(left(i)) = ran_away
         end do
         found%label(:, first:last) = reshape(label, [points, last - first + 1])
      end associate
   end subroutine label_rows

   !> Number of the motion without period that a start is on; `unsettled`: none.
   pure integer function place_of(this, wandering) result(place)
      type(aperiodic_type), intent(in) :: this, wandering(:)

      do place = 1, size(wandering)
         if (this%kind == 'still settling') exit
         if (wandering(place)%kind /= 'chaotic' .and. wandering(place)%kind /= 'quasi-periodic') cycle
         if (this%is_same(wandering(place))) return
      end do
      place = unsettled
   end function place_of

   !> Flies one start until it is recognised.
   subroutine label_start(system, max_periods, map, bound, known, watches, state, label, shared)
      type(system_type), intent(in) :: system
      integer, intent(in) :: max_periods
      type(section_map_type), intent(in) :: map
      type(bound_type), intent(in) :: bound
      type(recognition_type), intent(in) :: known(:)
      !> Watches of the motions that have no balls.
      type(approach_type), intent(in) :: watches
      !> The start, then the latest state [1], (state).
      real(dp), intent(inout) :: state(:)
      !> Number of the motion, or `ran_away`, or `unsettled`.
      integer, intent(out) :: label
      !> Told that the flight goes on.
      type(shared_observer_type), intent(inout) :: shared
      type(approach_type) :: approach
      type(integration_settings_type) :: integration
      real(dp) :: limit
      integer :: i, k
      logical :: lost, keep_going

      limit = bound%limit(state)
      lost = .false.
      label = unsettled
      approach = watches
      do k = 1, max_periods
         do i = 1, size(known)
            if (.not. known(i)%holds(state)) cycle
            label = i
            return
         end do
         call approach%look(state, k - 1, integration%tolerance, i)
         if (i > 0) label = i
         if (i > 0) return
         call map%pass_period(state, lost)
         if (lost .or. system%interrupt%raised()) return
         if (.not. bound%holds(state, limit)) then
            label = ran_away
            return
         end if
         if (mod(k, between_looks) > 0) cycle
         keep_going = .true.
         call shared%on_step('settling', k, map%frequency_ratio, keep_going)
         if (.not. keep_going) return
      end do
   end subroutine label_start

   subroutine visit_fields(self, train, fields, summary)
      class(basins_analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      class(fields_type), intent(inout) :: fields
      logical, intent(in) :: summary

      call self%result%visit(fields)
   end subroutine visit_fields

   subroutine report(self, train, sheet, torques)
      class(basins_analysis_type), intent(in) :: self
      type(train_type), intent(in) :: train
      type(sheet_type), intent(inout) :: sheet
      type(torque_table_type), intent(inout) :: torques
      type(frequency_text_type) :: told
      character(:), allocatable :: words
      character(80) :: line
      integer :: i

      associate (found => self%result, unused => torques)
         told = frequency_text(train, self%settings%unit, 0.0_dp)
         call told%rounded(found%frequency_ratio, words)
         call sheet%say(in_result, 'Basins at '//words//': '//text(size(found%displacement))//' x '// &
                        text(size(found%velocity))//' starts; '//fixed(100*found%unsettled, 1)// &
                        ' % did not settle, '//fixed(100*found%unbounded, 1)//' % grew without bound.')
         if (size(found%motions) > 0) call sheet%add(in_result, 'motion  period   of the grid   of random starts')
         do i = 1, size(found%motions)
            if (.not. allocated(found%grid_share)) exit
            write (line, '(i6, i8, 2(f9.2, a, f5.2, a))') i, found%motions(i)%period, 100*found%grid_share(i), ' +-', &
               100*found%grid_share_error(i), ' %', 100*found%motions(i)%share, ' +-', 100*found%share_error(i), ' %'
            call sheet%add(in_result, line)
         end do
         if (allocated(found%motions)) call say_orbits(train, found%motions, sheet)
         if (.not. allocated(found%ended)) return
         if (found%ended /= 'all starts done' .or. sheet%verbose) &
            call sheet%say(in_quality, 'The basins ended: '//found%ended//'.')
      end associate
   end subroutine report

end module geartrain_analyses_basins
