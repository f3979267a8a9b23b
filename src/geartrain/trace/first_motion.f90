!> The motion at which the trace of a response begins.
module geartrain_trace_first_motion
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_repetition, only: repeat_motion
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_observer, only: observer_type
   use geartrain_base_words, only: words_type
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_flow_integration_settings, only: integration_settings_type, most_periods
   use geartrain_flow_orbit_search, only: orbit_search_type
   use geartrain_flow_settling, only: settle
   use geartrain_flow_start_state, only: resting_state
   use geartrain_network_divide_orders, only: divide_orders
   use geartrain_network_excitation, only: highest_order
   use geartrain_network_lowest_modes, only: lowest_modes_type
   use geartrain_network_parameter, only: largest_variation, variation
   use geartrain_network_parameter_path, only: parameter_path_type
   use geartrain_network_system, only: system_type
   use geartrain_trace_branch, only: branch_type, coefficients_of, response_settings_type
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_trace_start, only: add_harmonics, begin_trace, motion_at, resting, solution_of
   use geartrain_trace_tracer, only: reached_end, tracer_type
   use geartrain_trace_window_start, only: solve_in_window
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: find_start, flies_over_periods

   !> Largest number of harmonics that an exact motion is solved with, over the number asked for.
   integer, parameter :: most_times = 8
   !> Most sections of the flow from which an orbit is looked for, at the Lambda of the start, fewer for trains of more than 10
   !> states; and at each of some others. A section of a train of n states takes 15 flights of n tangents.
   integer, parameter :: sections_here = 128, sections_elsewhere = 8
   !> Most mesh cycles of a flow that is to settle. Most mesh cycles of a period that is flown over in a train that goes by windows.
   real(dp), parameter :: most_cycles = 20000, longest_period = 50
   !> Most mesh cycles of a period in which orbits are looked for beside the one that the flow settles on.
   real(dp), parameter :: longest_search = 8
   !> Most points of a branch that leads to the start, and of one in the period of hunting teeth, where a point may take a second.
   integer, parameter :: most_points = 2000, most_points_of_long = 100
   !> Stiffness variation at which a branch over it begins, over that of the train [1]: a resonance is then too weak for a second
   !> motion, so that the branch cannot come back.
   real(dp), parameter :: hardly = 1.0_dp/64

contains

   !> Finds a motion at one end of the range: at a given Lambda or, on a path in a parameter, at a value of it. Tried in this order:
   !> - Newton's method from rest under the mean load;
   !> - of a train with several tooth frequencies, the motion on a window of time integration from rest;
   !> - the motion that time integration from rest settles on; after the next where free vibrations of the train outlast it;
   !> - the branch of a solution from rest at another Lambda, outside the range that ends at `other` or within;
   !> - the branch over the stiffness variation, from a train whose stiffness hardly varies;
   !> - an orbit, stable or not, near the flow from rest;
   !> - the branch of such an orbit at another Lambda.
   !> A motion of long period takes minutes to fly over, and is not looked for in flights over whole periods. The motions of a
   !> branch may repeat themselves within the period of the fundamental. Then flights are those of the train with divided orders.
   !> Flights over the whole period would also come to motions that do not repeat themselves.
   recursive subroutine find_start(train, tracer, frequency_ratio, other, solution, success, enough, settled, stopped, observer)
      !> The train as described.
      type(train_type), intent(in) :: train
      !> Of `train`, from begin_trace.
      type(tracer_type), intent(inout) :: tracer
      !> Lambda, or value of the parameter, to start at, and the other end of the range [1 or unit of the parameter].
      real(dp), intent(in) :: frequency_ratio, other
      !> The solution where `success`.
      type(solution_point_type), intent(out) :: solution
      !> A motion was found.
      logical, intent(out) :: success
      !> Harmonics of a solution that was found, where there is none with settings%harmonics; 0: no such case.
      integer, intent(out) :: enough
      !> No motion was found, though time integration settles on one: its harmonics are too few.
      logical, intent(out) :: settled
      !> The observer or an interrupt ended the search before a motion was found.
      logical, intent(out) :: stopped
      !> Is told of the periods of the fundamental of time integration, and may cancel.
      class(observer_type), intent(inout), optional :: observer
      type(motion_type) :: motion
      type(system_type), target :: divided
      type(integration_settings_type) :: integration
      real(dp), allocatable :: state(:)
      real(dp), parameter :: times(*) = [0.5_dp, 2.0_dp, 0.2_dp, 5.0_dp], share(*) = [0.25_dp, 0.5_dp, 0.75_dp, 1.0_dp]
      real(dp), allocatable :: elsewhere(:)
      real(dp) :: cycles
      integer :: i, round, sections
      logical :: flies, settles

      if (allocated(tracer%corrector%balance%path)) then
         call find_start_at(tracer, frequency_ratio, solution, success, enough, settled, stopped, observer)
         return
      end if
      enough = 0
      settled = .false.
      stopped = .false.
      solution = resting(tracer, frequency_ratio)
      call tracer%corrector%solve_at(solution, success)
      if (success) return
      cycles = highest_order(tracer%system)/tracer%settings%repeats
      flies = flies_over_periods(tracer)
      integration%max_periods = max(1, min(most_periods(tracer%system, 0), nint(most_cycles/cycles)))
      if (tracer%chooses_sets) then
         call solve_in_window(tracer, frequency_ratio, solution, success, stopped, observer)
         if (success .or. stopped) return
      end if
      settles = .false.
      if (flies) settles = decay_of_train(tracer%system) &
                           > tracer%settings%repeats*frequency_ratio/(2*pi*integration%max_periods)
      if (settles) call solve_where_flow_settles()
      elsewhere = frequency_ratio + share*(other - frequency_ratio)
      ! From far away several stages have too many resonances on the way.
      if (.not. tracer%chooses_sets) elsewhere = [times*frequency_ratio, elsewhere]
      do round = 1, 2
         do i = 1, size(elsewhere)
            stopped = stopped .or. tracer%system%interrupt%raised()
            if (success .or. stopped) return
            call follow_branch(train, tracer%settings, elsewhere(i), frequency_ratio, round == 1, motion, success, stopped, &
                               observer)
            if (.not. success) cycle
            solution = solution_of(tracer, motion)
            call tracer%corrector%solve_at(solution, success)
         end do
         if (success .or. round == 2) exit
         if (flies .and. .not. settles) call solve_where_flow_settles()
         if (success .or. stopped) return
         ! Where an exact motion needs more harmonics than asked for, their number is worth more than another motion.
         if (enough == 0) call follow_variation(train, tracer%settings, frequency_ratio, motion, success)
         if (success) then
            solution = solution_of(tracer, motion)
            call tracer%corrector%solve_at(solution, success)
         end if
         ! The orbit nearest to the flow is the one that it settles on; looking for others takes minutes.
         if (.not. flies .or. settled .and. .not. success .and. cycles > longest_search) exit
         sections = min(sections_here, 10*sections_here/tracer%system%states)
         if (cycles > longest_search) sections = min(sections, max(sections_elsewhere/2, nint(sections_here/cycles)))
         if (.not. success) call solve_near_flow(tracer, frequency_ratio, sections, solution, success, enough, stopped, observer)
      end do

   contains

      subroutine solve_where_flow_settles()
         type(motion_type) :: motion

         associate (times => tracer%settings%repeats)
            divided = tracer%system
            call divide_orders(times, divided)
            state = resting_state(divided)
            integration%harmonics = exact_harmonics(tracer)
            call settle(divided, times*frequency_ratio, integration, state, motion, observer, stopped)
            if (stopped) return
            if (motion%period > 0 .and. mod(tracer%settings%subharmonic, max(1, motion%period)) == 0) then
               call repeat_waveform(times, motion)
               call solve_near(tracer, motion, solution, success, enough)
               settled = .not. success
            end if
         end associate
      end subroutine solve_where_flow_settles
   end subroutine find_start

   !> Whether motions are looked for in flights over whole periods, which are not too long.
   logical function flies_over_periods(tracer)
      !> From begin_trace.
      type(tracer_type), intent(in) :: tracer

      flies_over_periods = .not. tracer%corrector%balance%has_long_period()
      if (tracer%chooses_sets) flies_over_periods = flies_over_periods .and. &
                                                    highest_order(tracer%system)/tracer%settings%repeats <= longest_period
   end function flies_over_periods

   !> Slowest decay of the lowest modes of a large train, all meshes on the drive flank [1]; huge: the train is small, or they are
   !> not known.
   real(dp) function decay_of_train(system) result(decay)
      type(system_type), intent(in) :: system
      integer, parameter :: number = 4
      type(lowest_modes_type) :: modes
      real(dp) :: stiffness(system%elements), damping(system%elements)
      integer :: i, j
      logical :: success

      decay = huge(decay)
      stiffness = system%spring
      damping = system%damping
      do j = 1, system%meshes
         associate (n => system%mesh_element(j), law => system%law(j))
            stiffness(n) = law%stiffness(1)
            damping(n) = law%damping(1)
         end associate
      end do
      if (system%displacements < system%coordinates .or. .not. all(stiffness > 0)) return
      call modes%begin(system, stiffness)
      call modes%find(system, number, success)
      if (.not. success) return
      associate (weight => system%stiffness/system%characteristic_frequency**2*damping)
         decay = minval([(sum(weight*modes%shape(:, i)**2)/2, i=1, number)])
      end associate
   end function decay_of_train

   !> Finds a motion at a value of the parameter of a path: a motion of the train with this value, at the Lambda of the path.
   recursive subroutine find_start_at(tracer, value, solution, success, enough, settled, stopped, observer)
      type(tracer_type), intent(inout) :: tracer
      real(dp), intent(in) :: value
      type(solution_point_type), intent(out) :: solution
      logical, intent(out) :: success, settled, stopped
      integer, intent(out) :: enough
      class(observer_type), intent(inout), optional :: observer
      type(train_type) :: train
      type(system_type), target :: systems(2)
      type(tracer_type) :: fixed
      type(response_settings_type) :: settings
      type(motion_type) :: motion
      integer :: first

      settings = tracer%settings
      settings%parameter = ''
      associate (path => tracer%corrector%balance%path)
         call path%train_at(value, train)
         call begin_trace(train, settings, systems, fixed)
         first = fixed%corrector%balance%highest
         call find_start(train, fixed, path%frequency_ratio, 2*path%frequency_ratio, solution, success, enough, settled, stopped, &
                         observer)
      end associate
      if (.not. success) return
      motion = motion_at(fixed, solution)
      motion%frequency_ratio = value
      ! A motion that took more harmonics to solve takes them here as well.
      associate (highest => fixed%corrector%balance%highest)
         if (highest > max(first, tracer%corrector%balance%highest)) call tracer%prepare(highest)
      end associate
      solution = solution_of(tracer, motion)
      call tracer%corrector%solve_at(solution, success)
   end subroutine find_start_at

   !> A solution near an orbit that the flow from rest passes.
   subroutine solve_near_flow(tracer, frequency_ratio, most_sections, solution, success, enough, stopped, observer)
      type(tracer_type), intent(inout) :: tracer
      real(dp), intent(in) :: frequency_ratio
      !> Most sections of the flow from which an orbit is looked for.
      integer, intent(in) :: most_sections
      type(solution_point_type), intent(inout) :: solution
      logical, intent(out) :: success
      integer, intent(inout) :: enough
      logical, intent(out) :: stopped
      class(observer_type), intent(inout), optional :: observer
      type(system_type), target :: divided
      type(orbit_search_type) :: orbits
      type(motion_type) :: motion
      logical :: found

      success = .false.
      associate (times => tracer%settings%repeats)
         divided = tracer%system
         call divide_orders(times, divided)
         call orbits%begin(divided, times*frequency_ratio, tracer%settings%subharmonic, exact_harmonics(tracer), most_sections)
      end associate
      do while (.not. success)
         call orbits%next(motion, found, stopped, observer)
         if (.not. found) return
         call repeat_waveform(tracer%settings%repeats, motion)
         call solve_near(tracer, motion, solution, success, enough)
      end do
   end subroutine solve_near_flow

   !> Solves the balance next to an exact motion. Where Newton's method fails, the number of harmonics is doubled, repeatedly. If
   !> the user gave the number of harmonics, the solution is then followed down to this number.
   subroutine solve_near(tracer, motion, solution, success, enough)
      type(tracer_type), intent(inout) :: tracer
      type(motion_type), intent(in) :: motion
      type(solution_point_type), intent(inout) :: solution
      logical, intent(out) :: success
      integer, intent(inout) :: enough
      integer :: wanted, highest

      wanted = tracer%corrector%balance%highest
      if (tracer%chooses_sets) call add_harmonics(tracer, motion)
      solution = solution_of(tracer, motion)
      call tracer%corrector%solve_at(solution, success)
      ! A set has the harmonics that matter already.
      if (tracer%chooses_sets) return
      highest = wanted
      do while (.not. success .and. highest < most_times*wanted)
         highest = 2*highest
         call tracer%prepare(highest)
         solution = solution_of(tracer, motion)
         call tracer%corrector%solve_at(solution, success)
      end do
      if (success .and. tracer%settings%harmonics == 0) return
      do while (success .and. highest > wanted)
         if (enough == 0) enough = highest
         enough = min(enough, highest)
         call tracer%corrector%orient(solution, 1)
         highest = max(wanted, (3*highest)/4)
         call tracer%prepare(highest)
         call tracer%corrector%refit(solution)
         call tracer%corrector%solve_at(solution, success)
      end do
      if (success) enough = 0
      if (tracer%corrector%balance%highest /= wanted) call tracer%prepare(wanted)
   end subroutine solve_near

   !> Harmonics of Lambda in one waveform of an exact motion: as many as `solve_near` may need.
   pure integer function exact_harmonics(tracer)
      type(tracer_type), intent(in) :: tracer

      exact_harmonics = 1 + most_times*tracer%corrector%balance%highest/(tracer%settings%subharmonic*tracer%settings%repeats)
   end function exact_harmonics

   !> Turns a motion of the train with divided orders into a motion of the train, which repeats itself.
   pure subroutine repeat_waveform(times, motion)
      !> Divisor of the orders.
      integer, intent(in) :: times
      type(motion_type), intent(inout) :: motion

      if (times == 1) return
      call repeat_motion(times, times*((size(motion%coefficients, 1) - 1)/2), motion)
   end subroutine repeat_waveform

   !> Follows a branch from one Lambda to another, for its last motion only.
   subroutine follow_branch(train, settings, from, to, from_rest, motion, success, stopped, observer)
      type(train_type), intent(in) :: train
      type(response_settings_type), intent(in) :: settings
      !> Lambda at the beginning and at the end [1].
      real(dp), intent(in) :: from, to
      !> Begins at the solution from rest; else at an orbit near the flow from rest.
      logical, intent(in) :: from_rest
      !> The motion at `to`, where `success`.
      type(motion_type), intent(out) :: motion
      !> A motion at `to` was found; the observer or an interrupt ended the flow from rest.
      logical, intent(out) :: success, stopped
      class(observer_type), intent(inout), optional :: observer
      type(system_type), target :: systems(2)
      type(tracer_type) :: tracer
      type(solution_point_type) :: solution
      integer :: enough

      stopped = .false.
      call begin_trace(train, only_motions(settings), systems, tracer)
      if (from_rest) then
         solution = resting(tracer, from)
         call tracer%corrector%solve_at(solution, success)
      else
         enough = 0
         call solve_near_flow(tracer, from, sections_elsewhere, solution, success, enough, stopped, observer)
      end if
      if (.not. success) return
      call follow(tracer, solution, from, to, motion, success)
   end subroutine follow_branch

   !> Follows the branch over the stiffness variation at constant Lambda, from a train whose stiffness hardly varies to the train as
   !> it is. Where both have one motion or any odd number, the branch goes through, however many folds it has on its way.
   subroutine follow_variation(train, settings, frequency_ratio, motion, success)
      type(train_type), intent(in) :: train
      !> Settings in Lambda.
      type(response_settings_type), intent(in) :: settings
      real(dp), intent(in) :: frequency_ratio
      !> The motion of the train, where `success`.
      type(motion_type), intent(out) :: motion
      logical, intent(out) :: success
      type(response_settings_type) :: over_variation
      type(parameter_path_type) :: path
      type(system_type), target :: systems(2)
      type(train_type) :: plain
      type(tracer_type) :: tracer
      type(solution_point_type) :: solution
      type(error_type), allocatable :: none

      success = .false.
      call plain_train(train, plain)
      associate (own => largest_variation(plain%meshes))
         if (.not. own > 0) return
         over_variation = only_motions(settings)
         over_variation%max_points = most_points
         over_variation%parameter = variation
         over_variation%frequency = frequency_ratio
         over_variation%start = hardly*own
         over_variation%stop = own
      end associate
      call path%setup(train, variation, frequency_ratio, over_variation%start, over_variation%stop, none)
      if (allocated(none)) return
      call begin_trace(train, over_variation, systems, tracer)
      solution = resting(tracer, over_variation%start)
      call tracer%corrector%solve_at(solution, success)
      if (.not. success) return
      call follow(tracer, solution, over_variation%start, over_variation%stop, motion, success)
      motion%frequency_ratio = frequency_ratio
   end subroutine follow_variation

   !> Settings for a branch of which motions alone are wanted.
   pure type(response_settings_type) function only_motions(settings) result(plain)
      type(response_settings_type), intent(in) :: settings

      plain = settings
      plain%stability = .false.
      plain%max_points = min(most_points, settings%max_points)
   end function only_motions

   !> Follows a branch from a solution at one end to the other end, for its last motion only.
   subroutine follow(tracer, solution, from, to, motion, success)
      type(tracer_type), intent(inout) :: tracer
      type(solution_point_type), intent(inout) :: solution
      !> Lambda or parameter at the beginning and at the end.
      real(dp), intent(in) :: from, to
      type(motion_type), intent(out) :: motion
      logical, intent(out) :: success
      type(branch_type), target :: way
      type(words_type), allocatable :: reason
      integer :: i, outcome

      ! The number of harmonics stays constant along the way.
      tracer%settings%harmonics = tracer%corrector%balance%highest
      tracer%shows = .false.
      tracer%estimate%mesh = [(0.0_dp, i=1, tracer%system%meshes)]
      if (tracer%corrector%balance%has_long_period()) &
         tracer%settings%max_points = min(tracer%settings%max_points, most_points_of_long)
      call tracer%corrector%orient(solution, merge(1, -1, to > from))
      call tracer%recorder%setup(tracer%corrector%balance, .false., way)
      call tracer%record(solution, way)
      call tracer%trace(solution, min(from, to), max(from, to), to, way, outcome, reason)
      success = outcome == reached_end
      motion%frequency_ratio = to
      motion%period = tracer%settings%subharmonic
      motion%coefficients = coefficients_of(way, way%points)
   end subroutine follow

end module geartrain_trace_first_motion
