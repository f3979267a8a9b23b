!> The curve of a special point of the exact motion over Lambda and a parameter of the train, with the points on it at which two
!> conditions meet.
module geartrain_curves_locus_trace
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_repetition, only: repetitions_of
   use geartrain_base_error, only: error_type, fatal, status_ended_early
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: real_text, text
   use geartrain_base_observer, only: observer_type
   use geartrain_base_words, only: lambda, operator(//)
   use geartrain_exact_augmented_point, only: augmented_point_type, scale_tangent, trains_type
   use geartrain_exact_augmented_system, only: augmented_system_type
   use geartrain_curves_locus_result, only: locus_type
   use geartrain_curves_locus_side, only: side_type, trace_side
   use geartrain_flow_multiple_shooting, only: most_parts, section_states
   use geartrain_floquet_multipliers, only: multipliers_of, power
   use geartrain_flow_sections, only: sections_type
   use geartrain_flow_start_state, only: state_of
   use geartrain_network_check_train, only: check_train
   use geartrain_network_long_period, only: long_period
   use geartrain_network_parameter_path, only: parameter_path_type
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: find_path, refusal_of, trace_locus

   !> Distance of the parameter from an end of its range that is rounding, over the length of the range.
   real(dp), parameter :: rounding = 1e-13_dp
   !> Most cycles of the fastest mesh in a motion: the time of a curve grows as their square, see docs/numerics.md.
   integer, parameter :: most_cycles = 32

   !> Distance of multipliers from +1, or -1, up to which they pass together [1].
   real(dp), parameter :: on_circle = 1e-5_dp

contains

   !> Traces the curve of a special point both ways, as long as the parameter is between two values.
   subroutine trace_locus(train, motion, kind, mesh, name, start, stop, locus, error, observer)
      type(train_type), intent(in) :: train
      !> A motion near the special point, with a state or coefficients.
      type(motion_type), intent(in) :: motion
      !> Kind of the special point: 'fold', 'period doubling', 'neimark-sacker', 'branch point', 'separation' or
      !> 'back contact'.
      character(*), intent(in) :: kind
      !> Of a contact onset the number of the mesh, else 0.
      integer, intent(in) :: mesh
      !> Name of the parameter.
      character(*), intent(in) :: name
      !> Ends of the range of the parameter, the train's own value between them [unit of the parameter].
      real(dp), intent(in) :: start, stop
      !> The curve.
      type(locus_type), intent(out) :: locus
      !> Bad input, or no special point (status_ended_early).
      type(error_type), allocatable, intent(out) :: error
      !> Told of each point of 'locus'; may end it.
      class(observer_type), intent(inout), optional :: observer
      type(parameter_path_type) :: path
      type(trains_type), target :: trains, own_trains(2)
      type(augmented_system_type) :: augmented, own(2)
      type(augmented_point_type) :: first, begin(2)
      type(side_type) :: side(2)
      type(system_type), target :: system
      type(sections_type) :: sections
      type(motion_type) :: guess
      real(dp), allocatable :: state(:)
      integer :: info, k, done
      logical :: success, keep_going

      call check_train(train, error)
      if (allocated(error)) return
      call find_path(train, name, motion%frequency_ratio, start, stop, path, error)
      if (allocated(error)) return
      call build_system(train, system)
      guess = motion
      path%repeats = repetitions_of(system, motion)
      call check_cycles(system, motion%period, path%repeats, kind, error)
      if (allocated(error)) return
      if (path%repeats > 1) then
         allocate (state(system%states))
         call state_of(system, motion, state)
         associate (n => system%displacements)
            guess%state = [state(:n), state(n + 1:)/path%repeats]
         end associate
         call path%system_at(path%own_value, system)
      end if
      call augmented%setup(trains, system, motion%period, kind, mesh, path, path%own_value)
      call sections%setup(system, motion%period, most_parts(system, motion%period), moves=.false.)
      call section_states(system, guess, sections, first%states)
      first%frequency_ratio = motion%frequency_ratio
      call augmented%find_borders(first, info)
      if (info == 0 .and. count_critical() > 1) then
         call fatal(error, 'locus: several multipliers pass the unit circle together at '//lambda(motion%frequency_ratio)// &
                    ', as where equal branches begin to move differently: curves of such points are not followed', &
                    status_ended_early)
         return
      end if
      if (info == 0 .and. kind == 'branch point' .and. .not. augmented%is_symmetric) then
         call fatal(error, 'locus: the motions at '//lambda(motion%frequency_ratio)//' are symmetric neither at every &
                    &instant nor with a shift by half a period: curves of their branch points are not followed', status_ended_early)
         return
      end if
      call augmented%solve(first, .false., success)
      if (.not. success) then
         call fatal(error, 'locus: Newton''s method finds no '//trim(kind)//' at '//lambda(motion%frequency_ratio), &
                    status_ended_early)
         return
      end if
      if ((first%tangent_parameter < 0) .neqv. (stop < start)) call scale_tangent(first, -1.0_dp)
      ! Each side on a thread of its own.
      begin = first
      call scale_tangent(begin(1), -1.0_dp)
      do k = 1, 2
         call own(k)%setup(own_trains(k), system, motion%period, kind, mesh, path, path%own_value)
         call own(k)%continue_from(augmented, first)
      end do
      keep_going = .true.
      done = 0
      !$omp parallel do schedule(static, 1)
      do k = 2, 1, -1
         call trace_side(own(k), begin(k), start, stop, side(k), keep_going, done, locus%covered(k), observer)
         locus%covered(k) = 1
      end do
      !$omp end parallel do
      ! A side that closes is the whole curve.
      do k = 1, 2
         if (.not. side(k)%closed) cycle
         side(3 - k)%points = 0
         side(3 - k)%specials = 0
         side(3 - k)%closed = .false.
         side(3 - k)%ended = side(k)%ended
         side(3 - k)%end_kind = side(k)%end_kind
      end do
      call gather(augmented, first, [min(start, stop), max(start, stop)], side, path%repeats, system%displacements, locus)
      locus%kind = kind
      locus%mesh = mesh
      locus%name = trim(adjustl(name))
      locus%unit = path%unit
      locus%period = motion%period
      locus%start_frequency = first%frequency_ratio
      locus%closed = any(side%closed)
      locus%complete = locus%closed .or. side(1)%at_end .and. side(2)%at_end
      locus%ends = side%end_kind
      locus%ended = side(1)%ended
      if (side(1)%ended%text /= side(2)%ended%text) locus%ended = locus%ended//'; '//side(2)%ended

   contains

      !> Number of multipliers at +1, of a branch point, or at -1, of a period doubling.
      integer function count_critical()
         count_critical = 0
         if (kind == 'branch point') count_critical = count(abs(multipliers_of(augmented%moving%monodromy) - 1) < on_circle)
         if (kind == 'period doubling') count_critical = count(abs(multipliers_of(augmented%moving%monodromy) + 1) < on_circle)
      end function count_critical

   end subroutine trace_locus

   !> Refuses motions of too many cycles of a mesh.
   subroutine check_cycles(system, period, repeats, kind, error)
      type(system_type), intent(in) :: system
      !> Period of the motions [periods of the fundamental]; how often they go through their waveform in it.
      integer, intent(in) :: period, repeats
      !> Kind of the special point.
      character(*), intent(in) :: kind
      type(error_type), allocatable, intent(inout) :: error
      character(:), allocatable :: words
      integer :: cycles

      cycles = nint(period*maxval(system%law%order)/repeats)
      call refusal_of(cycles, 'the period is '//text(cycles)//' cycles of mesh '// &
                      text(maxloc(system%law%order, 1)), kind, words)
      if (words /= '') call fatal(error, 'locus: '//words)
   end subroutine check_cycles

   !> Why the curve of a special point is not followed where motions have too many cycles of a mesh, else ''.
   subroutine refusal_of(cycles, period, kind, words)
      !> Cycles of the fastest mesh in a period.
      integer, intent(in) :: cycles
      !> The period in words; kind of the special point.
      character(*), intent(in) :: period, kind
      !> The reason and what to do instead.
      character(:), allocatable, intent(out) :: words

      words = ''
      if (cycles <= most_cycles) return
      words = period//'. A curve of special points is followed for motions of up to '//text(most_cycles)//' mesh cycles: each &
              &cycle may touch a wall of the gap and make a corner of the curve. Instead compute &response with harmonics = 0 at &
              &several values of the parameter, and take the '//trim(kind)//' from the special points or jumps of each'
      if (cycles <= long_period) words = words//'; or &stability_map over the parameter'
   end subroutine refusal_of

   !> The path of the train over the parameter, on which the train itself lies.
   subroutine find_path(train, name, frequency_ratio, start, stop, path, error)
      !> A train that has passed `check_train`.
      type(train_type), intent(in) :: train
      !> Name of the parameter.
      character(*), intent(in) :: name
      !> Lambda at the beginning of the curve [1]; ends of the range of the parameter [unit of the parameter].
      real(dp), intent(in) :: frequency_ratio, start, stop
      !> The path.
      type(parameter_path_type), intent(out) :: path
      !> There is no such parameter, or the curve would not begin on the path.
      type(error_type), allocatable, intent(inout) :: error

      call path%setup(train, name, frequency_ratio, start, stop, error)
      if (allocated(error)) return
      associate (origin => path%own_value)
         if (.not. path%holds_train) then
            call fatal(error, 'locus: "'//trim(name)//'" has more than one value in the train: name one of them, or give the &
                       &train one value first, for the curve to begin at')
         else if (.not. (min(start, stop) <= origin .and. origin <= max(start, stop) .and. path%length > 0)) then
            call fatal(error, 'locus: from '//real_text(start)//' to '//real_text(stop)//': the value of "'//trim(name)// &
                       '" in the train, '//real_text(origin)//', must lie between them')
         end if
      end associate
   end subroutine find_path

   !> Puts both sides together.
   subroutine gather(augmented, first, range, side, repeats, displacements, locus)
      type(augmented_system_type), intent(in) :: augmented
      type(augmented_point_type), intent(in) :: first
      !> Ends of the range of the parameter [its unit]: a point at one is exactly there.
      real(dp), intent(in) :: range(2)
      type(side_type), intent(in) :: side(2)
      !> Of the path; number of the displacements in a state.
      integer, intent(in) :: repeats, displacements
      type(locus_type), intent(inout) :: locus
      integer :: i, n

      n = side(1)%points + 1 + side(2)%points
      allocate (locus%frequency_ratio(n), locus%parameter(n), locus%state(size(first%states, 1), n), &
                locus%multipliers(size(first%states, 1), n))
      do i = 1, side(1)%points
         call put(side(1)%points + 1 - i, side(1)%point(i))
      end do
      call put(side(1)%points + 1, first)
      do i = 1, side(2)%points
         call put(side(1)%points + 1 + i, side(2)%point(i))
      end do
      allocate (locus%special_points(side(1)%specials + side(2)%specials))
      do i = 1, side(1)%specials
         associate (special => locus%special_points(side(1)%specials + 1 - i))
            special = side(1)%special(i)
            ! A special point is in the step after its point; of the first side in the step that now comes before it.
            special%point = max(1, side(1)%points - special%point)
         end associate
      end do
      do i = 1, side(2)%specials
         associate (special => locus%special_points(side(1)%specials + i))
            special = side(2)%special(i)
            special%point = special%point + side(1)%points + 1
         end associate
      end do

   contains

      subroutine put(k, point)
         integer, intent(in) :: k
         type(augmented_point_type), intent(in) :: point

         locus%frequency_ratio(k) = point%frequency_ratio
         locus%parameter(k) = augmented%origin + augmented%scale*point%parameter
         if (minval(abs(locus%parameter(k) - range)) < rounding*augmented%scale) &
            locus%parameter(k) = range(minloc(abs(locus%parameter(k) - range), 1))
         locus%state(:, k) = point%states(:, 1)
         locus%state(displacements + 1:, k) = repeats*locus%state(displacements + 1:, k)
         locus%multipliers(:, k) = power(point%multipliers, repeats)
      end subroutine put

   end subroutine gather

end module geartrain_curves_locus_trace
