!> The motion of a train while Lambda goes linearly in time from one value to another.
module geartrain_flow_ramped_flow
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_base_error, only: error_type, fatal, status_memory
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_memory, only: need
   use geartrain_base_numbers, only: integer_text, text
   use geartrain_base_observer, only: observer_type
   use geartrain_base_words, only: lambda, operator(//), words_type
   use geartrain_flow_bound, only: bound_type
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_force_series, only: force_series, include
   use geartrain_flow_orbit, only: flow_order, flow_tolerance
   use geartrain_flow_ramp, only: ramp_type
   use geartrain_flow_shaft_torque, only: torque_series
   use geartrain_flow_taylor, only: series_values
   use geartrain_network_excitation, only: excited_harmonics, reach_of_sources
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: automatic_samples, follow_ramp, make_room, most_samples, run_up_type

   !> Samples by default: of a period of the fastest mesh, of the highest excited harmonic, of the fastest vibration of a mesh
   !> alone.
   integer, parameter :: samples_per_tooth = 32, samples_per_harmonic = 4, samples_per_vibration = 8
   !> Most samples of a run-up.
   integer, parameter :: most_samples = 100000000

   !> A run-up as far as it is computed; the arrays have room for the whole run-up.
   type :: run_up_type
      !> Numbers of equidistant samples and of windows that are done (geartrain_flow_ramp).
      integer :: samples = 0, windows = 0
      !> Period of the steady motion with which the run-up begins [periods of the fundamental]; 0: no steady motion was found.
      integer :: start_period = 0
      !> Time for which it settled by the time constants of the train before it begins [s]; 0: it did not.
      real(dp) :: start_settling = 0
      !> Amplitude of slow free vibrations as it begins, over the alternating displacement [1]; negative: not known.
      real(dp) :: start_ringing = -1
      !> Time [s] and Lambda [1], (sample).
      real(dp), allocatable :: time(:), frequency_ratio(:)
      !> Mesh displacements over b_c [1] and mesh forces with damping [N], (mesh, sample); torques of the shafts [N m], (shaft,
      !> sample), NaN where rigid shafts side by side leave it undetermined.
      real(dp), allocatable :: displacement(:, :), mesh_force(:, :), shaft_torque(:, :)
      !> Time of the middle of each window [s], (window).
      real(dp), allocatable :: window_time(:)
      !> Extremes over each window, not only of the samples, of the mesh forces [N], (mesh, window), and of the torques of the
      !> shafts [N m], (shaft, window).
      real(dp), allocatable :: force_minimum(:, :), force_maximum(:, :), torque_minimum(:, :), torque_maximum(:, :)
      !> State at the end of the last window that is done [1], (state); the twists of shafts are less those at rest at constant
      !> speed.
      real(dp), allocatable :: state(:)
      !> Why the run-up ended; not allocated: it is under way.
      type(words_type), allocatable :: ended
      !> Whether the end of the ramp was reached.
      logical :: complete = .false.
   end type run_up_type

contains

   !> Number of samples of a period of the fundamental at the highest speed that shows what a train does.
   pure integer function automatic_samples(system, ramp) result(samples)
      type(system_type), intent(in) :: system
      type(ramp_type), intent(in) :: ramp
      real(dp) :: vibration
      integer :: j

      vibration = sqrt(maxval([(system%own(system%mesh_element(j))*system%law(j)%stiffest(), j=1, system%meshes)]))
      samples = max(samples_per_tooth*reach_of_sources(system), &
                    samples_per_harmonic*min(most_samples, maxval([1, excited_harmonics(system)])), &
                    ceiling(min(1e8_dp, samples_per_vibration*vibration/max(ramp%start, ramp%stop))))
   end function automatic_samples

   !> Makes room for a whole run-up and keeps what is done. Whether memory will suffice is found out here, not after hours.
   subroutine make_room(system, ramp, samples, shafts, result, error)
      type(system_type), intent(in) :: system
      type(ramp_type), intent(in) :: ramp
      !> Samples of a period of the fundamental at the highest speed; number of shafts, rigid ones included, and of held bodies.
      integer, intent(in) :: samples, shafts
      !> Gets its arrays.
      type(run_up_type), intent(inout) :: result
      type(error_type), allocatable, intent(inout) :: error
      ! Number of copies: the result, the fields, a field on its way and the bytes of the file.
      integer(int64), parameter :: times = 4
      character(*), parameter :: cure = 'take fewer samples or a shorter duration'
      real(dp) :: intervals, bytes
      integer :: n

      intervals = ceiling(ramp%duration*max(ramp%start, ramp%stop)/(2*pi)*samples*(1 - 1e-12_dp), int64)
      if (intervals >= most_samples) then
         call fatal(error, 'run up: '//text(intervals)//' samples are too many, at most '//integer_text(most_samples)//': '//cure, &
                    status_memory)
         return
      end if
      bytes = 8*times*((intervals + 1)*(3 + 2*system%meshes + shafts) + ramp%windows*real(1 + 2*system%meshes + 2*shafts, dp))
      call need(bytes, 'run up: no memory for '//text(intervals)//' samples', cure, error)
      if (allocated(error)) return
      n = int(intervals) + 1
      call lengthen(result%time, n)
      call lengthen(result%frequency_ratio, n)
      call widen(result%displacement, system%meshes, n)
      call widen(result%mesh_force, system%meshes, n)
      call widen(result%shaft_torque, shafts, n)
      call lengthen(result%window_time, ramp%windows)
      call widen(result%force_minimum, system%meshes, ramp%windows)
      call widen(result%force_maximum, system%meshes, ramp%windows)
      call widen(result%torque_minimum, shafts, ramp%windows)
      call widen(result%torque_maximum, shafts, ramp%windows)
   end subroutine make_room

   subroutine lengthen(values, length)
      real(dp), allocatable, intent(inout) :: values(:)
      integer, intent(in) :: length
      real(dp), allocatable :: longer(:)

      allocate (longer(length))
      if (allocated(values)) longer(:size(values)) = values
      call move_alloc(longer, values)
   end subroutine lengthen

   subroutine widen(values, rows, length)
      real(dp), allocatable, intent(inout) :: values(:, :)
      integer, intent(in) :: rows, length
      real(dp), allocatable :: wider(:, :)

      allocate (wider(rows, length))
      if (allocated(values)) wider(:, :size(values, 2)) = values
      call move_alloc(wider, values)
   end subroutine widen

   !> Follows the ramp window by window, from the windows done on, and says why it ended.
   subroutine follow_ramp(system, shift, ramp, result, observer)
      !> The train, accelerating.
      type(system_type), target, intent(in) :: system
      !> State of the system less the state as it is told [1], (state).
      real(dp), intent(in) :: shift(:)
      type(ramp_type), intent(in) :: ramp
      !> With room for all samples, and the state at the end of the windows done.
      type(run_up_type), intent(inout) :: result
      !> Told of 'run up' after each window; may end the run-up.
      class(observer_type), intent(inout), optional :: observer
      type(flow_type) :: flow
      type(bound_type) :: bound
      real(dp) :: limit, reached
      integer :: window, first
      logical :: keep_going

      call flow%setup(system, 1, flow_order, flow_tolerance)
      flow%x(1, :) = result%state + shift
      call bound%setup(system, max(ramp%start, ramp%stop))
      limit = bound%limit()  ! not of the state, so that a run-up that is taken up ends where it would have ended
      reached = ramp%speed_of(result%windows + 1)
      keep_going = .true.
      do window = result%windows + 1, ramp%windows
         if (.not. keep_going) exit
         first = result%samples
         call pass_window(flow, ramp, window, result)
         if (system%interrupt%raised() .or. .not. bound%holds(flow%x(1, :), limit)) then
            result%samples = first
            exit
         end if
         result%windows = window
         result%state = flow%x(1, :) - shift
         ! To the bits with which a checkpoint goes on.
         flow%x(1, :) = result%state + shift
         reached = merge(ramp%speed_of(window + 1), ramp%stop, window < ramp%windows)
         if (present(observer)) call observer%on_step('run up', window, reached, keep_going)
      end do
      result%complete = result%windows == ramp%windows
      if (result%complete) then
         result%ended = 'reached '//lambda(ramp%stop)
      else if (system%interrupt%raised() .or. .not. keep_going) then
         result%ended = 'cancelled at '//lambda(reached)
      else
         result%ended = 'the motion grows without bound at '//lambda(reached)
      end if
      if (flow%lost) result%ended = result%ended//'; too many contact events fell on one instant: the motion after it is a guess'
   end subroutine follow_ramp

   !> Flies over a window and records it; less far where the interrupt is raised.
   subroutine pass_window(flow, ramp, window, result)
      type(flow_type), intent(inout) :: flow
      type(ramp_type), intent(in) :: ramp
      integer, intent(in) :: window
      type(run_up_type), intent(inout) :: result
      real(dp) :: force(0:flow%order, flow%system%meshes), torque(0:flow%order, size(result%shaft_torque, 1)), origin, speed, &
         begun, end
      integer :: contact(flow%system%meshes), i

      call ramp%place(window, origin, speed, begun, end)
      associate (w => window, system => flow%system)
         result%window_time(w) = (origin + (begun + end)/2)/system%characteristic_frequency
         result%force_minimum(:, w) = huge(1.0_dp)
         result%force_maximum(:, w) = -huge(1.0_dp)
         result%torque_minimum(:, w) = huge(1.0_dp)
         result%torque_maximum(:, w) = -huge(1.0_dp)
         torque = ieee_value(origin, ieee_quiet_nan)
         call flow%start(speed, begun, ramp%acceleration)
         do while (flow%time < end)
            if (system%interrupt%raised()) return
            begun = flow%time
            contact = flow%contact
            call flow%step(end)
            if (flow%x(1, 1) >= huge(1.0_dp)) return
            do i = 1, system%meshes
               call force_series(flow, i, contact(i), force(:, i))
               call include(force(:, i), flow%length, result%force_minimum(i, w), result%force_maximum(i, w))
            end do
            call torque_series(flow, begun, force, torque)
            do i = 1, system%torque_paths%torques
               if (system%torque_paths%known(i)) &
                  call include(torque(:, i), flow%length, result%torque_minimum(i, w), result%torque_maximum(i, w))
            end do
            call sample(flow, ramp, origin, begun, force, torque, result)
         end do
         where (result%torque_minimum(:, w) > result%torque_maximum(:, w))
            result%torque_minimum(:, w) = torque(0, :)
            result%torque_maximum(:, w) = torque(0, :)
         end where
      end associate
   end subroutine pass_window

   !> Records the samples within the latest step.
   subroutine sample(flow, ramp, origin, begun, force, torque, result)
      type(flow_type), intent(in) :: flow
      type(ramp_type), intent(in) :: ramp
      !> Time since the beginning of the ramp at which the period of the fundamental begins; time since then at which the step
      !> begins [1].
      real(dp), intent(in) :: origin, begun
      !> Taylor coefficients of mesh forces [N], (0:order, mesh), and torques of shafts [N m], (0:order, shaft).
      real(dp), intent(in) :: force(0:, :), torque(0:, :)
      type(run_up_type), intent(inout) :: result
      real(dp), allocatable :: time(:), tau(:)
      integer :: first, last, i, k

      associate (n => size(result%time))
         first = result%samples + 1
         last = result%samples
         do while (last < n)
            if (ramp%duration*(real(last, dp)/(n - 1)) - origin > flow%time) exit
            last = last + 1
         end do
         if (last < first) return
         result%samples = last
         time = [(ramp%duration*(real(k - 1, dp)/(n - 1)), k=first, last)]
         tau = time - origin - begun
         result%time(first:last) = time/flow%system%characteristic_frequency
         result%frequency_ratio(first:last) = ramp%start + ramp%acceleration*time
         do i = 1, size(force, 2)
            result%displacement(i, first:last) = series_values(flow%p(1, flow%system%mesh_element(i), :), tau)
            result%mesh_force(i, first:last) = series_values(force(:, i), tau)
         end do
         do i = 1, size(torque, 2)
            result%shaft_torque(i, first:last) = series_values(torque(:, i), tau)
         end do
      end associate
   end subroutine sample

end module geartrain_flow_ramped_flow
