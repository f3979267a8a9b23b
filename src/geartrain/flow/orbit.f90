!> A periodic orbit of the flow, given by its state: monodromy matrix, waveform, and the figures of the motion, or of a window of a
!> motion whose period is too long.
module geartrain_flow_orbit
   use geartrain_balance_mesh_load, only: put_force
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_observer, only: observer_type
   use geartrain_flow_figures, only: figures_type
   use geartrain_flow_floating, only: is_floating
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_force_series, only: force_series
   use geartrain_flow_shaft_torque, only: torque_series
   use geartrain_flow_taylor, only: series_values
   use geartrain_flow_uncertainty, only: figure_uncertainty_type, uncertainty_of
   use geartrain_flow_window, only: cycle_time
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: transform_length
   use geartrain_network_excitation, only: excited_harmonics, reach_of_sources
   use geartrain_network_system, only: static_forces_at, system_type
   implicit none (type, external)
   private
   public :: begin_tangents, measure, memory_to_measure, stored_harmonics, sample_orbit, propagate, flow_order, flow_tolerance

   !> Order of the Taylor series and relative error of a step, for states and shooting.
   integer, parameter :: flow_order = 28
   real(dp), parameter :: flow_tolerance = 1e-15_dp
   !> Least samples of a period of the fundamental, of a period of the fastest mesh, of a period of the highest stored harmonic. The
   !> coefficients of a motion with contact events fall as k^-4, so aliasing is near 1e-12.
   integer, parameter :: samples_per_period = 1024, samples_per_tooth = 256, samples_per_harmonic = 4
   !> Harmonics that are stored by default: of the frequency of the fastest mesh, and of the highest excited harmonic.
   integer, parameter :: harmonics_per_tooth = 16, harmonics_per_source = 2
   !> Where a period of the fundamental has a great many periods of the fastest mesh: samples and stored harmonics of a period of
   !> the fundamental up to which those above are taken; fewest samples and harmonics of a period of the fastest mesh beyond.
   integer, parameter :: many_samples = 4000000, many_harmonics = 200000, fewest_samples = 32, fewest_harmonics = 2

contains

   !> Carries a state and its tangents over a period.
   subroutine propagate(system, frequency_ratio, period, state, final, monodromy)
      type(system_type), target, intent(in) :: system
      !> Lambda [1]; state at phase 0 [1], (state).
      real(dp), intent(in) :: frequency_ratio, state(:)
      !> Number of periods of the fundamental.
      integer, intent(in) :: period
      !> State after the period [1], (state).
      real(dp), intent(out) :: final(:)
      !> Monodromy matrix [1], (state, state).
      real(dp), intent(out), optional :: monodromy(:, :)
      type(flow_type) :: flow
      integer :: i, n

      n = 0
      if (present(monodromy)) n = size(state)
      call flow%setup(system, n + 1, flow_order, flow_tolerance)
      flow%x(1, :) = state
      if (n > 0) call begin_tangents(flow, state)
      do i = 1, period
         call flow%pass_period(frequency_ratio)
      end do
      final = flow%x(1, :)
      if (n > 0) monodromy = transpose(flow%x(2:, :))
   end subroutine propagate

   !> Sets the columns of a flow: the state, then the columns of the identity as tangents.
   pure subroutine begin_tangents(flow, state)
      !> Set up with a column for each state and one more.
      type(flow_type), intent(inout) :: flow
      !> State [1], (state).
      real(dp), intent(in) :: state(:)
      integer :: i

      flow%x = 0
      flow%x(1, :) = state
      do i = 1, size(state)
         flow%x(i + 1, i) = 1
      end do
   end subroutine begin_tangents

   !> Samples a period of an orbit, or a window of a flow, at equidistant instants, the first at phase 0.
   subroutine sample_orbit(system, frequency_ratio, period, state, displacement, force, torque, rate, window, figures, &
                           observer, stopped)
      type(system_type), target, intent(in) :: system
      !> Lambda [1]; state at phase 0 [1], (state).
      real(dp), intent(in) :: frequency_ratio, state(:)
      !> Period of the orbit [periods of the fundamental].
      integer, intent(in) :: period
      !> Mesh displacements over characteristic length [1], (samples, mesh); 0, as all samples, where the flow was ended early.
      real(dp), intent(out) :: displacement(:, :)
      !> Mesh forces [N], of couplings [N m], damping included, (samples, mesh).
      real(dp), intent(out), optional :: force(:, :)
      !> Torques of the shafts and what follows them in the torque paths [N m], (samples, row).
      real(dp), intent(out), optional :: torque(:, :)
      !> Mesh velocities, displacement derived by time [1], (samples, mesh).
      real(dp), intent(out), optional :: rate(:, :)
      !> Window in place of the period [periods of the fundamental]; absent or 0: the period.
      real(dp), intent(in), optional :: window
      !> Gets extremes and means over all instants; 0 where the flow was ended early.
      type(figures_type), intent(out), optional :: figures
      !> Told of 'settling by time' after each cycle of the slowest mesh of a window; may end the flow.
      class(observer_type), intent(inout), optional :: observer
      !> Whether the observer ended the flow.
      logical, intent(out), optional :: stopped
      type(flow_type) :: flow
      real(dp) :: spacing, stretch, begun, next_look, forces(0:flow_order, system%meshes), &
         torques(0:flow_order, system%torque_paths%rows)
      real(dp), allocatable :: tau(:)
      integer :: i, j, k, q, last, stretches, contact(system%meshes)
      logical :: keep_going, open

      call flow%setup(system, 1, flow_order, flow_tolerance)
      flow%x(1, :) = state
      ! A period is flown over period of the fundamental by period of the fundamental, a window as a whole.
      stretch = 2*pi/frequency_ratio
      stretches = period
      open = .false.
      if (present(window)) open = window > 0
      if (open) then
         stretch = window*stretch
         stretches = 1
      end if
      spacing = stretches*stretch/size(displacement, 1)
      if (present(figures)) call figures%setup(system)
      next_look = 0
      keep_going = .true.
      q = 1
      do i = 1, stretches
         call flow%start(frequency_ratio, 0.0_dp)
         do while (flow%time < stretch)
            if (system%interrupt%raised() .or. .not. keep_going) exit
            begun = flow%time
            contact = flow%contact
            call flow%step(stretch)
            if (present(figures) .or. present(force) .or. present(torque)) then
               do j = 1, system%meshes
                  call force_series(flow, j, contact(j), forces(:, j))
               end do
               if (present(figures) .or. present(torque)) call torque_series(flow, begun, forces, torques)
            end if
            if (present(figures)) call figures%follow(flow, contact, forces, torques)
            last = q - 1
            do while (last < size(displacement, 1))
               if (last*spacing - (i - 1)*stretch - begun > flow%length) exit
               last = last + 1
            end do
            if (last >= q) then
               tau = [((k - 1)*spacing - (i - 1)*stretch - begun, k=q, last)]
               do j = 1, system%meshes
                  associate (n => system%mesh_element(j))
                     displacement(q:last, j) = series_values(flow%p(1, n, :), tau)
                     if (present(rate)) rate(q:last, j) = series_values(flow%v(1, n, :), tau)
                  end associate
                  if (present(force)) force(q:last, j) = series_values(forces(:, j), tau)
               end do
               if (present(torque)) then
                  do j = 1, size(torque, 2)
                     torque(q:last, j) = series_values(torques(:, j), tau)
                  end do
               end if
               q = last + 1
            end if
            if (.not. present(observer) .or. flow%time < next_look) cycle
            next_look = flow%time + cycle_time(system, frequency_ratio)
            call observer%on_step('settling by time', int(flow%time/cycle_time(system, frequency_ratio)), frequency_ratio, &
                                  keep_going)
         end do
      end do
      if (present(stopped)) stopped = .not. keep_going
      if (q > size(displacement, 1)) return
      ! Nobody looks at the samples of a window that ended early, and there are many.
      if (open) return
      displacement(q:, :) = 0
      if (present(rate)) rate(q:, :) = 0
      if (present(force)) force(q:, :) = 0
      if (present(torque)) torque(q:, :) = 0
      if (present(figures)) call figures%clear()
   end subroutine sample_orbit

   !> Number of harmonics of Lambda that are stored by default.
   pure integer function stored_harmonics(system)
      type(system_type), intent(in) :: system

      associate (reach => reach_of_sources(system))
         stored_harmonics = maxval([harmonics_per_tooth*reach, &
                                    harmonics_per_source*min(many_harmonics, excited_harmonics(system))])
         stored_harmonics = min(stored_harmonics, max(many_harmonics, fewest_harmonics*reach))
      end associate
   end function stored_harmonics

   !> Number of samples of a period of the fundamental from which the figures of a motion are computed.
   pure integer function measured_samples(system, harmonics) result(samples)
      type(system_type), intent(in) :: system
      !> Harmonics of Lambda that are stored.
      integer, intent(in) :: harmonics
      integer :: per_tooth

      associate (reach => reach_of_sources(system))
         per_tooth = max(fewest_samples, min(samples_per_tooth, many_samples/reach))
         samples = transform_length(max(samples_per_period, per_tooth*reach, samples_per_harmonic*harmonics))
      end associate
   end function measured_samples

   !> Memory that `measure` takes beside its result [bytes].
   pure real(dp) function memory_to_measure(system, periods, harmonics) result(bytes)
      type(system_type), intent(in) :: system
      !> Periods of the fundamental; harmonics of Lambda that are stored, 0: `stored_harmonics`.
      integer, intent(in) :: periods, harmonics
      integer :: stored

      stored = harmonics
      if (stored == 0) stored = stored_harmonics(system)
      ! Displacements and, of a window, forces of meshes and torques; the transform and its spectrum.
      bytes = 8.0_dp*periods*measured_samples(system, stored)*(2*system%meshes + system%torque_paths%torques + 2)
   end function memory_to_measure

   !> Computes the figures of a motion from its frequency, period and state.
   subroutine measure(system, wanted, motion, observer, stopped)
      type(system_type), intent(in) :: system
      !> Number of harmonics of Lambda in the coefficients, which are those of Lambda/period or Lambda/window; 0:
      !> `stored_harmonics`.
      integer, intent(in) :: wanted
      !> Given: frequency_ratio, period or window, state, ringing. Set: all figures, and undecided where the flow passed over an
      !> event.
      type(motion_type), intent(inout) :: motion
      !> Told of the flow over a window; may end it, and there are then no figures.
      class(observer_type), intent(inout), optional :: observer
      !> Whether the observer ended the flow.
      logical, intent(out), optional :: stopped
      type(transform_type) :: transform
      type(figures_type) :: figures
      real(dp), allocatable :: p(:, :), force(:, :), torque(:, :)
      real(dp) :: periods
      integer :: harmonics, lines, j, k, q
      logical :: ended

      harmonics = wanted
      if (wanted == 0) harmonics = stored_harmonics(system)
      periods = motion%period
      if (motion%window > 0) periods = motion%window
      lines = nint(harmonics*periods)
      q = ceiling(periods*measured_samples(system, harmonics))
      if (motion%window > 0) then
         q = transform_length(q)
         ! From these comes what a longer window would change.
         allocate (force(q, system%meshes), torque(q, system%torque_paths%torques))
      end if
      allocate (p(q, system%meshes))
      call sample_orbit(system, motion%frequency_ratio, motion%period, motion%state, p, force, torque, window=motion%window, &
                        figures=figures, observer=observer, stopped=ended)
      if (present(stopped)) stopped = ended
      ! Figures of long windows take a second that nobody waits for any more.
      if (motion%window > 0 .and. (ended .or. system%interrupt%raised())) return
      call put_figures(system, figures, motion)
      motion%undecided = motion%undecided .or. figures%lost
      if (motion%window > 0) then
         call find_uncertainty(system, p, force, torque, motion)
         if (system%interrupt%raised()) return
      end if
      call transform%plan(q)
      if (allocated(motion%coefficients)) deallocate (motion%coefficients)
      allocate (motion%coefficients(1 + 2*lines, system%meshes))
      motion%mean = sum(p, 1)/q
      motion%rms = [(sqrt(2*sum((p(:, j) - motion%mean(j))**2)/q), j=1, system%meshes)]
      motion%floating = is_floating(system, motion)
      do j = 1, system%meshes
         transform%sample = p(:, j)
         call transform%to_coefficients()
         motion%coefficients(1, j) = motion%mean(j)
         do k = 1, lines
            motion%coefficients(2*k, j) = 2*real(transform%coefficient(k + 1), dp)/q
            motion%coefficients(2*k + 1, j) = -2*aimag(transform%coefficient(k + 1))/q
         end do
      end do
   end subroutine measure

   !> Sets extremes of displacements and forces, shares of contact, torques, forces of bearings, losses and load shares.
   subroutine put_figures(system, figures, motion)
      type(system_type), intent(in) :: system
      type(figures_type), intent(in) :: figures
      type(motion_type), intent(inout) :: motion
      real(dp) :: static(system%elements), share(-1:1, system%meshes), mean_force(size(system%sharing%mesh))
      integer :: form(2), j

      motion%minimum = figures%displacement%low
      motion%maximum = figures%displacement%high
      share = figures%spent/figures%length
      if (allocated(motion%mesh_load)) deallocate (motion%mesh_load)
      allocate (motion%mesh_load(system%meshes))
      static = static_forces_at(system, motion%frequency_ratio)
      do j = 1, system%meshes
         associate (force => figures%force(j), load => motion%mesh_load(j), unit => system%load_unit(j))
            call put_force(system, static, j, force%high/unit, -force%low/unit, load)
            if (.not. system%half_backlash(j) > 0) cycle
            load%separation = share(0, j)
            load%back_contact = share(-1, j)
         end associate
      end do
      motion%held = system%torque_paths%held
      motion%couplings = system%torque_paths%couplings
      if (motion%couplings > 0) motion%coupling_energy_loss = figures%loss/figures%length*(2*pi/motion%frequency_ratio)
      associate (torque => figures%torque(:system%torque_paths%torques))
         motion%shaft_torque_mean = torque%integral/figures%length
         motion%shaft_torque_minimum = torque%low
         motion%shaft_torque_maximum = torque%high
      end associate
      if (system%torque_paths%bearings > 0) then
         form = [2, system%torque_paths%bearings]
         associate (force => figures%torque(system%torque_paths%torques + 1:))
            motion%bearing_force_mean = reshape(force%integral/figures%length, form)
            motion%bearing_force_rms = reshape(figures%bearing_rms(), form)
            motion%bearing_force_minimum = reshape(force%low, form)
            motion%bearing_force_maximum = reshape(force%high, form)
         end associate
      end if
      if (size(mean_force) == 0) return
      mean_force = figures%force(system%sharing%mesh)%integral/figures%length
      motion%load_share = mean_force
      motion%load_share_maximum = mean_force
      call system%sharing%find_shares(mean_force, motion%mesh_load(system%sharing%mesh)%force_maximum, motion%load_share, &
                                      motion%load_share_maximum)
   end subroutine put_figures

   !> Sets what a longer window would change of the figures.
   subroutine find_uncertainty(system, p, force, torque, motion)
      type(system_type), intent(in) :: system
      !> Displacements [1] and forces [N], of couplings [N m], (sample, mesh); torques [N m], (sample, shaft).
      real(dp), intent(in) :: p(:, :), force(:, :), torque(:, :)
      type(motion_type), intent(inout) :: motion
      type(figure_uncertainty_type) :: of_p(size(p, 2)), of_force(size(p, 2)), of_torque(size(torque, 2))
      real(dp) :: static(system%elements)
      integer :: j

      static = static_forces_at(system, motion%frequency_ratio)
      do j = 1, size(p, 2)
         of_p(j) = uncertainty_of(p(:, j))
         of_force(j) = uncertainty_of(force(:, j))
      end do
      do j = 1, size(torque, 2)
         of_torque(j) = uncertainty_of(torque(:, j))
      end do
      associate (u => motion%uncertainty, load => static(system%mesh_element))
         u%rms = of_p%rms
         u%mean = of_p%mean
         u%minimum = of_p%minimum
         u%maximum = of_p%maximum
         u%force_maximum = max(of_force%maximum, of_force%minimum)
         where (load > 0) u%force_maximum = of_force%maximum
         where (load < 0) u%force_maximum = of_force%minimum
         u%torque_mean = of_torque%mean
         u%torque_minimum = of_torque%minimum
         u%torque_maximum = of_torque%maximum
      end associate
   end subroutine find_uncertainty

end module geartrain_flow_orbit
