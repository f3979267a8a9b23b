!> The response of a train with dry friction: branches of orbits from the motions that time integration settles on at both ends of
!> the range, or from a given motion.
module geartrain_exact_friction_response
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_base_words, only: lambda, operator(//), words_type
   use geartrain_exact_orbit_branch, only: came_back, cancelled, closed_loop, left_by_amplitude, orbit_tracer_type, reached_end
   use geartrain_exact_orbit_corrector, only: orbit_type
   use geartrain_flow_integration_settings, only: integration_settings_type
   use geartrain_flow_orbit, only: stored_harmonics
   use geartrain_flow_settling, only: settle
   use geartrain_flow_start_state, only: resting_state
   use geartrain_network_frequency_unit, only: lambda_per
   use geartrain_network_natural_modes, only: modes_type, natural_modes
   use geartrain_network_parameter_path, only: parameter_path_type
   use geartrain_network_system, only: build_system, system_type
   use geartrain_network_units, only: largest_unit
   use geartrain_trace_branch, only: arrange_points, branch_type, response_settings_type, special_point_type
   use geartrain_trace_points, only: drop_first, is_same_point
   use geartrain_trace_recorder, only: begin_branch
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: friction_response

   !> Amplitude limit where the settings give none, in the unit of motions that cross the gap [1].
   real(dp), parameter :: default_amplitude_limit = 12

contains

   !> Traces the response of a train with dry friction. A branch that ends early says why in branch%ended.
   subroutine friction_response(train, settings, branch, error, seed, observer)
      !> A checked train.
      type(train_type), intent(in) :: train
      !> Checked settings.
      type(response_settings_type), intent(in) :: settings
      !> A branch without points; then the response.
      type(branch_type), intent(inout), target :: branch
      !> The parameter has no such range.
      type(error_type), allocatable, intent(inout) :: error
      !> A motion to start from, with a state or coefficients.
      type(motion_type), intent(in), optional :: seed
      !> Told of each point of 'response', or of 'branch' with a seed; may end the trace.
      class(observer_type), intent(inout), optional :: observer
      type(orbit_tracer_type) :: tracer
      type(system_type), target :: system, beside
      type(parameter_path_type), allocatable, target :: path
      type(system_type), pointer :: moving, second
      type(parameter_path_type), pointer :: way
      real(dp) :: ends(2)
      integer :: i

      moving => system
      second => beside
      call begin()
      if (allocated(error)) return
      if (present(seed)) then
         call from_seed()
      else
         call from_both_ends()
      end if
      call arrange_points(branch, [(i, i=1, branch%points)], branch%points)
      if (.not. tracer%over_parameter) call note_passed(branch, train)

   contains

      !> Prepares tracer and branch.
      subroutine begin()
         integer :: harmonics
         real(dp) :: factor

         tracer%system => moving
         if (settings%parameter == '') then
            call build_system(train, system)
            factor = lambda_per(train, settings%unit)
            ends = factor*[settings%start, settings%stop]
            call tracer%corrector%setup(moving, settings%subharmonic, 1, corners=.true.)
         else
            allocate (path)
            way => path
            factor = lambda_per(train, settings%unit)
            tracer%constant_frequency = settings%frequency*factor
            call path%setup(train, settings%parameter, tracer%constant_frequency, settings%start, settings%stop, error)
            if (allocated(error)) return
            call path%system_at(path%amid, system)
            tracer%over_parameter = .true.
            ! What stands for Lambda is 1 at the lower end and 2 at the upper end.
            tracer%slope = path%length
            tracer%origin = min(settings%start, settings%stop) - path%length
            ends = merge([1, 2], [2, 1], settings%start < settings%stop)
            call tracer%corrector%setup(moving, settings%subharmonic, 1, way, min(settings%start, settings%stop), second, &
                                        corners=.true.)
         end if
         tracer%step = settings%step
         tracer%max_points = settings%max_points
         tracer%stability = settings%stability
         tracer%amplitude_limit = default_amplitude_limit*largest_unit(system)
         if (settings%amplitude_limit > 0) tracer%amplitude_limit = settings%amplitude_limit
         harmonics = settings%subharmonic*max(stored_harmonics(system), ceiling(settings%harmonics/real(settings%subharmonic, dp)))
         call begin_branch(system, settings%subharmonic, harmonics, settings%shaft_torque, branch, path)
         if (settings%stability) then
            branch%states = system%states
            allocate (branch%stable(0))
         end if
         allocate (branch%state(system%states, 0))
         call arrange_points(branch, [integer ::], 16)
      end subroutine begin

      !> Traces from `start` towards `stop`, then from `stop` towards `start`, unless both are one branch.
      subroutine from_both_ends()
         type(orbit_type) :: here
         type(words_type), allocatable :: reason
         integer :: outcome, first_points
         logical :: whole, found, stopped

         ! Both traces end at a bound or beyond the amplitude limit.
         whole = .false.
         call find_start(ends(1), here, found, reason, stopped)
         if (found) then
            call turn(here, ends(2) > ends(1))
            call tracer%record(here, branch)
            call tracer%trace(here, minval(ends), maxval(ends), ends(2), branch, outcome, reason, observer, 'response')
            branch%complete = outcome == reached_end
            whole = any(outcome == [reached_end, came_back, left_by_amplitude])
            stopped = outcome == cancelled
         end if
         branch%ended = reason
         if (stopped) then
            branch%cancelled = .true.
            return
         end if
         first_points = branch%points
         call find_start(ends(2), here, found, reason, stopped)
         outcome = 0
         if (found) then
            tracer%segment = 1
            if (first_points > 0) tracer%segment = branch%segment(first_points) + 1
            call turn(here, ends(1) > ends(2))
            call tracer%record(here, branch)
            if (branch%points > max(1, first_points)) then
               if (is_same_point(branch, first_points, branch%points)) then
                  branch%points = first_points
                  return
               end if
            end if
            call tracer%trace(here, minval(ends), maxval(ends), ends(1), branch, outcome, reason, observer, 'response')
            stopped = outcome == cancelled
         end if
         branch%cancelled = stopped
         branch%complete = outcome == reached_end .or. whole .and. any(outcome == [came_back, left_by_amplitude])
         branch%ended = 'from '//lambda(settings_value(ends(1)))//': '//branch%ended//'; from '//lambda(settings_value(ends(2))) &
                        //': '//reason
         ! The trace from `stop` reached the first point of the trace from `start`: it holds all points of the trace from `start`.
         if (outcome == reached_end .and. first_points > 0) then
            if (is_same_point(branch, 1, branch%points)) call drop_first(branch, first_points)
         end if
      end subroutine from_both_ends

      !> Traces both ways from a motion.
      subroutine from_seed()
         type(orbit_type) :: here, first
         type(motion_type) :: own
         type(words_type), allocatable :: reason
         integer :: outcome(2), i, k, n
         logical :: found

         own = seed
         if (seed%period < 1 .or. mod(settings%subharmonic, max(1, seed%period)) /= 0) then
            branch%ended = words_type('the seed has period '//text(seed%period)//', which does not divide subharmonic = ' &
                                      //text(settings%subharmonic))
            return
         end if
         if (tracer%over_parameter) then
            if (abs(seed%frequency_ratio - tracer%constant_frequency) > 1e-9_dp*tracer%constant_frequency &
                .or. .not. path%holds_train) then
               branch%ended = words_type('the seed is no motion of this train at the frequency '//text(tracer%constant_frequency))
               return
            end if
            own%frequency_ratio = (path%own_value - tracer%origin)/tracer%slope
         end if
         if (own%frequency_ratio < minval(ends) .or. own%frequency_ratio > maxval(ends)) then
            branch%ended = 'the seed at '//lambda(settings_value(own%frequency_ratio))//' lies outside '// &
                           text(min(settings%start, settings%stop))//' to '//text(max(settings%start, settings%stop))
            return
         end if
         call start_from(own, first, found)
         if (.not. found) then
            branch%ended = 'shooting does not converge from the seed at '//lambda(settings_value(own%frequency_ratio))
            return
         end if
         do i = 1, 2
            here = first
            call turn(here, (ends(2) > ends(1)) .eqv. i == 2)
            if (i == 1) call tracer%record(here, branch)
            call tracer%trace(here, minval(ends), maxval(ends), ends(3 - i), branch, outcome(i), reason, observer, 'branch')
            if (i == 1) then
               branch%ended = reason
               branch%closed = outcome(1) == closed_loop
               branch%complete = branch%closed
               branch%cancelled = outcome(1) == cancelled
               if (branch%closed .or. branch%cancelled) return
               ! The points of the first way come first, in reverse.
               n = branch%points
               call arrange_points(branch, [(k, k=n, 1, -1)], n)
               call reverse_special_points(branch)
            end if
         end do
         branch%cancelled = outcome(2) == cancelled
         branch%complete = all(outcome == reached_end .or. outcome == came_back .or. outcome == left_by_amplitude)
         branch%ended = 'backwards from the seed: '//branch%ended//'; forwards: '//reason
      end subroutine from_seed

      !> The motion that time integration from rest settles on, else an orbit near where it ends.
      subroutine find_start(at, orbit, found, reason, stopped)
         !> Lambda, or what stands for it.
         real(dp), intent(in) :: at
         type(orbit_type), intent(out) :: orbit
         logical, intent(out) :: found, stopped
         !> Why there is none.
         type(words_type), allocatable, intent(out) :: reason
         type(motion_type) :: motion
         type(integration_settings_type) :: integration
         real(dp), allocatable :: state(:)
         real(dp) :: frequency_ratio

         orbit%frequency_ratio = at
         call tracer%corrector%take_train(orbit, frequency_ratio)
         state = resting_state(system)
         call settle(system, frequency_ratio, integration, state, motion, observer, stopped)
         found = .false.
         reason = 'cancelled at '//lambda(settings_value(at))
         if (stopped .or. system%interrupt%raised()) then
            stopped = .true.
            return
         end if
         motion = motion_type(frequency_ratio=at, period=settings%subharmonic, state=state)
         call start_from(motion, orbit, found)
         if (found) return
         reason = words_type('no motion of period '//text(settings%subharmonic)//' found to start from, by time integration from &
                             &rest and shooting from where it ends')
      end subroutine find_start

      !> Shoots for an orbit near a motion.
      subroutine start_from(motion, orbit, found)
         type(motion_type), intent(in) :: motion
         type(orbit_type), intent(out) :: orbit
         logical, intent(out) :: found

         call tracer%corrector%first_guess(motion, orbit)
         call tracer%corrector%solve_at(orbit, found)
      end subroutine start_from

      !> Finds the tangent of an orbit, in the sense of growing or falling Lambda.
      subroutine turn(orbit, up)
         type(orbit_type), intent(inout) :: orbit
         logical, intent(in) :: up
         type(orbit_type) :: solved
         logical :: success

         orbit%tangent = 0*orbit%states
         orbit%tangent_frequency = merge(1, -1, up)*tracer%corrector%units%frequency_ratio
         solved = orbit
         call tracer%corrector%correct(solved, success)
         if (success) orbit = solved
      end subroutine turn

      !> Lambda, or the value of the parameter.
      real(dp) function settings_value(at)
         real(dp), intent(in) :: at

         settings_value = tracer%origin + tracer%slope*at
      end function settings_value

   end subroutine friction_response

   !> Adds to the reason for the end the resonances that the points may have passed, since shooting does not look for them: narrower
   !> than the distance of the points beside, of harmonics that the motion has. Couplings stick there.
   subroutine note_passed(branch, train)
      type(branch_type), intent(inout) :: branch
      type(train_type), intent(in) :: train
      !> A harmonic counts where its amplitude over the amplitude of the motion is larger [1].
      real(dp), parameter :: least = 1e-3_dp
      !> Most places that are named.
      integer, parameter :: most_named = 4
      type(modes_type) :: modes
      type(error_type), allocatable :: error
      real(dp) :: at, above, below
      integer :: k, mode, number

      call natural_modes(train, modes, error)
      if (allocated(error)) return
      number = 0
      associate (x => branch%frequency_ratio(:branch%points))
         do mode = 1, size(modes%natural_frequency)
            do k = 1, size(branch%orders)
               at = branch%subharmonic*modes%natural_frequency(mode)/branch%orders(k)
               if (.not. (any(x < at) .and. any(x > at))) cycle
               below = maxval(x, x <= at)
               above = minval(x, x > at)
               if (2*modes%damping_ratio(mode)*at > above - below) cycle
               associate (u => branch%coefficients(:, :, minloc(abs(x - at), 1)))
                  if (norm2(u(2*k:2*k + 1, :)) <= least*norm2(u(2:, :))) cycle
               end associate
               number = number + 1
               if (number == 1) branch%ended = branch%ended//'; resonances narrower than the distance of the motions are not &
                                               &looked for with friction_torque: what is read may be higher near '
               if (number > 1 .and. number <= most_named) branch%ended = branch%ended//', '
               if (number <= most_named) branch%ended = branch%ended//lambda(at)
            end do
         end do
      end associate
      if (number > most_named) branch%ended = branch%ended//' and '//text(number - most_named)//' more'
      if (number > 0) branch%ended = branch%ended//', as a response over a narrow range about one shows'
   end subroutine note_passed

   !> Numbers the special points of a branch whose points were reversed.
   subroutine reverse_special_points(branch)
      type(branch_type), intent(inout) :: branch
      type(special_point_type), allocatable :: reversed(:)
      integer :: i, n

      n = size(branch%special_points)
      allocate (reversed(n))
      do i = 1, n
         reversed(i) = branch%special_points(n + 1 - i)
         associate (special => reversed(i))
            special%point = branch%points + merge(1, 0, special%kind == 'fold') - special%point
         end associate
      end do
      call move_alloc(reversed, branch%special_points)
   end subroutine reverse_special_points

end module geartrain_exact_friction_response
