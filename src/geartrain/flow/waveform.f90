!> Time history of a motion, over a period or longer.
module geartrain_flow_waveform
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_force_series, only: force_series
   use geartrain_flow_orbit, only: flow_tolerance, sample_orbit
   use geartrain_flow_shaft_torque, only: torque_series
   use geartrain_flow_start_state, only: states_of
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: sample
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: waveform

contains

   !> Samples a motion at equidistant instants, the first at phase 0: a period, or its window, or 16 periods of the fundamental
   !> where it has neither.
   subroutine waveform(train, motion, samples, time, displacement, force, torque, velocity, periods)
      !> The train, which has been checked.
      type(train_type), intent(in) :: train
      !> The motion: integrated where it has a state, else summed from its coefficients.
      type(motion_type), intent(in) :: motion
      !> Number of instants.
      integer, intent(in) :: samples
      !> Time times characteristic frequency [1], (samples); mesh displacements over characteristic length [1], (samples, mesh).
      real(dp), intent(out) :: time(:), displacement(:, :)
      !> Mesh force [N], damping included, (samples, mesh).
      real(dp), intent(out), optional :: force(:, :)
      !> Torque of the shafts [N m], (samples, shaft).
      real(dp), intent(out), optional :: torque(:, :)
      !> Mesh velocities, displacement derived by time [1], (samples, mesh).
      real(dp), intent(out), optional :: velocity(:, :)
      !> Periods of the fundamental to sample instead of a period of the motion, which has a state.
      integer, intent(in), optional :: periods
      type(system_type) :: system
      real(dp) :: window, length
      integer :: period, q

      call build_system(train, system)
      period = merge(motion%period, 16, motion%period > 0)
      window = motion%window
      if (present(periods)) then
         period = periods
         window = 0
      end if
      length = period
      if (window > 0) length = window
      time = [(2*pi*length/motion%frequency_ratio*(q - 1)/samples, q=1, samples)]
      if (allocated(motion%state)) then
         call sample_orbit(system, motion%frequency_ratio, period, motion%state, displacement, force, torque, velocity, window)
      else
         call sum_series(system, motion, period, displacement, force, velocity)
         if (present(torque)) call find_torques(system, motion, time, torque)
      end if
   end subroutine waveform

   !> Mesh displacements over characteristic length, mesh forces [N], of couplings [N m], and mesh velocities from the coefficients.
   subroutine sum_series(system, motion, period, displacement, force, velocity)
      type(system_type), intent(in) :: system
      type(motion_type), intent(in) :: motion
      integer, intent(in) :: period
      real(dp), intent(out) :: displacement(:, :)
      real(dp), intent(out), optional :: force(:, :), velocity(:, :)
      integer, allocatable :: harmonic(:)
      type(transform_type) :: transform
      integer :: samples, q, j, k

      samples = size(displacement, 1)
      call transform%plan(samples)
      harmonic = [(k, k=1, (size(motion%coefficients, 1) - 1)/2)]
      do j = 1, system%meshes
         call sample(motion%coefficients(:, j), harmonic, transform)
         displacement(:, j) = transform%sample
         if (.not. (present(velocity) .or. present(force))) cycle
         call sample(motion%coefficients(:, j), harmonic, transform, derivative=.true.)
         associate (slope => transform%sample*(motion%frequency_ratio/period))
            if (present(velocity)) velocity(:, j) = slope
            if (.not. present(force)) cycle
            do q = 1, samples
               force(q, j) = system%load_unit(j)*system%law(j)%force(period*(2*pi*(q - 1)/samples), displacement(q, j), slope(q))
            end do
         end associate
      end do
   end subroutine sum_series

   !> Torques of the shafts from the coefficients, by the states along the period.
   subroutine find_torques(system, motion, time, torque)
      type(system_type), target, intent(in) :: system
      type(motion_type), intent(in) :: motion
      !> Instants [1].
      real(dp), intent(in) :: time(:)
      real(dp), intent(out) :: torque(:, :)
      !> The values at an instant are the first terms of their series.
      integer, parameter :: order = 1
      real(dp) :: states(system%states, size(time)), force(0:order, system%meshes), series(0:order, size(torque, 2))
      type(flow_type) :: flow
      integer :: j, q

      call states_of(system, motion, states)
      call flow%setup(system, 1, order, flow_tolerance)
      do q = 1, size(time)
         flow%x(1, :) = states(:, q)
         call flow%start(motion%frequency_ratio, time(q))
         call flow%expand()
         do j = 1, system%meshes
            call force_series(flow, j, flow%contact(j), force(:, j))
         end do
         call torque_series(flow, time(q), force, series)
         torque(q, :) = series(0, :)
      end do
   end subroutine find_torques

end module geartrain_flow_waveform
