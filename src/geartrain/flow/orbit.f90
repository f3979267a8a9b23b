!> A periodic orbit of the flow, given by its state: monodromy matrix, waveform, and the figures of the motion, or of a window of a
!> motion whose period is too long.
module geartrain_flow_orbit
   use geartrain_balance_mesh_load, only: put_force
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_observer, only: observer_type
   use geartrain_flow_floating, only: is_floating
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_bearing_figures, only: measure_bearings
   use geartrain_flow_friction_figures, only: correct_torques
   use geartrain_flow_force_series, only: energy_loss, extend_range, force_series, impulse
   use geartrain_flow_sampled_peak, only: peak
   use geartrain_flow_shaft_torque, only: add_torques, linear_forces
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
   subroutine sample_orbit(system, frequency_ratio, period, state, displacement, force, share, largest, torque, rate, window, &
                           observer, stopped, mean, loss, piece, reach_of)
      type(system_type), target, intent(in) :: system
      !> Lambda [1]; state at phase 0 [1], (state).
      real(dp), intent(in) :: frequency_ratio, state(:)
      !> Period of the orbit [periods of the fundamental].
      integer, intent(in) :: period
      !> Mesh displacements over characteristic length [1], (samples, mesh); 0, as all samples, where the flow was ended early.
      real(dp), intent(out) :: displacement(:, :)
      !> Mesh forces over k b_c [1], damping included, (samples, mesh).
      real(dp), intent(out), optional :: force(:, :)
      !> Shares of the period on the back flank, in separation and on the drive flank [1], (-1:1, mesh).
      real(dp), intent(out), optional :: share(-1:, :)
      !> Largest force and largest opposite force on either side of events [1], (2, mesh); 0 for a mesh without events.
      real(dp), intent(out), optional :: largest(:, :)
      !> Torques of the shafts [N m], (samples, shaft); `force` must be present too.
      real(dp), intent(out), optional :: torque(:, :)
      !> Mesh velocities, displacement derived by time [1], (samples, mesh).
      real(dp), intent(out), optional :: rate(:, :)
      !> Window in place of the period [periods of the fundamental]; absent or 0: the period.
      real(dp), intent(in), optional :: window
      !> Told of 'settling by time' after each cycle of the slowest mesh of a window; may end the flow.
      class(observer_type), intent(inout), optional :: observer
      !> Whether the observer ended the flow.
      logical, intent(out), optional :: stopped
      !> Mean force of the mesh of each planet, `system%sharing`, by integration [N], (planet).
      real(dp), intent(out), optional :: mean(:)
      !> Energy that each coupling loses in a period of the fundamental [J], (coupling).
      real(dp), intent(out), optional :: loss(:)
      !> Number of the part of the period between changes of dry friction, (samples).
      integer, intent(out), optional :: piece(:)
      !> Of a train with dry friction, whose changes may be extremes: largest p and largest -p [1], and mean force [N, of a
      !> coupling N m], (3, mesh).
      real(dp), intent(inout), optional :: reach_of(:, :)
      type(flow_type) :: flow
      real(dp), allocatable :: phi(:, :), rubbing(:, :)
      real(dp) :: spacing, stretch, begun, next_look, spent(-1:1, system%meshes), velocity(size(displacement, 1), system%meshes)
      integer :: i, j, q, stretches, contact(system%meshes), changes
      integer, allocatable :: mode(:)
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
      next_look = 0
      keep_going = .true.
      call flow%start(frequency_ratio, 0.0_dp)
      do j = 1, system%meshes
         call flow%element_now(system%mesh_element(j), displacement(1, j), velocity(1, j))
      end do
      if (present(torque)) then
         allocate (phi(size(displacement, 1), system%elements))
         call linear_forces(flow, phi(1, :))
      end if
      spent = 0
      if (present(largest)) then
         largest = 0
         if (flow%friction%count > 0) largest = -huge(1.0_dp)
      end if
      if (present(reach_of)) reach_of = spread([-huge(1.0_dp), -huge(1.0_dp), 0.0_dp], 2, system%meshes)
      if (present(mean)) mean = 0
      if (present(loss)) loss = 0
      allocate (rubbing(merge(size(displacement, 1), 0, present(force)), flow%friction%count))
      mode = flow%friction%mode
      changes = 0
      if (present(piece)) piece(1) = 0
      q = 2
      do i = 1, stretches
         call flow%start(frequency_ratio, 0.0_dp)
         do while (flow%time < stretch)
            if (system%interrupt%raised() .or. .not. keep_going) exit
            begun = flow%time
            contact = flow%contact
            call flow%step(stretch)
            if (present(mean)) then
               do j = 1, size(mean)
                  associate (mesh => system%sharing%mesh(j))
                     mean(j) = mean(j) + impulse(flow, mesh, contact(mesh))/(stretches*stretch)
                  end associate
               end do
            end if
            if (present(loss)) then
               do j = 1, size(loss)
                  associate (mesh => system%torque_paths%pairs + j)
                     loss(j) = loss(j) + energy_loss(flow, mesh, contact(mesh))*(2*pi/frequency_ratio)/(stretches*stretch)
                  end associate
               end do
            end if
            do j = 1, system%meshes
               associate (region => max(-1, min(1, contact(j))))
                  spent(region, j) = spent(region, j) + flow%length
               end associate
               if (flow%contact(j) == contact(j) .or. .not. present(largest)) cycle
               call reach(contact(j))
               call reach(flow%contact(j))
            end do
            do while (q <= size(displacement, 1))
               associate (t => (q - 1)*spacing - (i - 1)*stretch)
                  if (t > flow%time) exit
                  do j = 1, system%meshes
                     displacement(q, j) = flow%displacement(j, t - begun)
                     velocity(q, j) = flow%velocity(j, t - begun)
                  end do
                  if (present(torque)) call linear_forces(flow, phi(q, :), t - begun)
                  if (present(piece)) piece(q) = changes
                  if (size(rubbing) > 0) rubbing(q, :) = flow%friction%forces_at(t - begun)
               end associate
               q = q + 1
            end do
            if (flow%friction%count > 0) call follow_friction()
            if (.not. present(observer) .or. flow%time < next_look) cycle
            next_look = flow%time + cycle_time(system, frequency_ratio)
            call observer%on_step('settling by time', int(flow%time/cycle_time(system, frequency_ratio)), frequency_ratio, &
                                  keep_going)
         end do
      end do
      if (present(stopped)) stopped = .not. keep_going
      if (present(share)) share = spent/(stretches*stretch)
      if (system%interrupt%raised() .or. .not. keep_going) then
         ! Nobody looks at the samples of a window that ended early, and there are many.
         if (open) return
         displacement = 0
         if (present(rate)) rate = 0
         if (present(force)) force = 0
         if (present(torque)) torque = 0
         return
      end if
      if (present(rate)) rate = velocity
      if (.not. present(force)) return
      do j = 1, system%meshes
         if (open .and. system%interrupt%raised()) return
         force(:, j) = [(system%law(j)%force(frequency_ratio*spacing*(q - 1), displacement(q, j), velocity(q, j)), q=1, &
                         size(force, 1))]
      end do
      do j = 1, flow%friction%count
         force(:, flow%friction%mesh(j)) = force(:, flow%friction%mesh(j)) + rubbing(:, j)
      end do
      if (.not. present(torque) .or. (open .and. system%interrupt%raised())) return
      phi(:, system%mesh_element) = force
      call add_torques(system, frequency_ratio, frequency_ratio*spacing, phi, torque)

   contains

      !> Takes the force of mesh j at the event just met as it is in a region beside it.
      subroutine reach(region)
         integer, intent(in) :: region
         real(dp) :: p, v, phi

         call flow%element_now(system%mesh_element(j), p, v)
         associate (law => system%law(j))
            phi = law%damping(region)*v
            if (law%stiffness(region) > 0) &
               phi = phi + law%stiffness_at(region, frequency_ratio*flow%time)*(p - law%origin(region)) &
                     + law%offset_at(region, frequency_ratio*flow%time)
         end associate
         largest(:, j) = max(largest(:, j), [phi, -phi])
      end subroutine reach

      !> Takes the ranges of a train with friction over the latest step; counts changes of friction.
      subroutine follow_friction()
         real(dp) :: series(0:flow%order)
         integer :: k

         if (i == 1 .and. .not. begun > 0 .and. size(rubbing) > 0) rubbing(1, :) = flow%friction%forces_at(0.0_dp)
         if (any(flow%friction%mode /= mode)) changes = changes + 1
         mode = flow%friction%mode
         if (.not. present(largest)) return
         do k = 1, system%meshes
            call force_series(flow, k, contact(k), series)
            call extend_range(series/system%load_unit(k), flow%length, largest(:, k))
            if (.not. present(reach_of)) cycle
            call extend_range(flow%p(1, system%mesh_element(k), :), flow%length, reach_of(:2, k))
            reach_of(3, k) = reach_of(3, k) + impulse(flow, k, contact(k))/(stretches*stretch)
         end do
      end subroutine follow_friction

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
      ! Displacements, velocities and forces of meshes, forces of all elements, torques; the transform and its spectrum.
      bytes = 8.0_dp*periods*measured_samples(system, stored) &
              *(3*system%meshes + system%elements + system%torque_paths%rows + 2)
   end function memory_to_measure

   !> Computes the figures of a motion from its frequency, period and state.
   subroutine measure(system, wanted, motion, observer, stopped)
      type(system_type), intent(in) :: system
      !> Number of harmonics of Lambda in the coefficients, which are those of Lambda/period or Lambda/window; 0:
      !> `stored_harmonics`.
      integer, intent(in) :: wanted
      !> Given: frequency_ratio, period or window, state, ringing. Set: all figures.
      type(motion_type), intent(inout) :: motion
      !> Told of the flow over a window; may end it, and there are then no figures.
      class(observer_type), intent(inout), optional :: observer
      !> Whether the observer ended the flow.
      logical, intent(out), optional :: stopped
      type(transform_type) :: transform
      real(dp), allocatable :: p(:, :), force(:, :), torque(:, :)
      real(dp) :: share(-1:1, system%meshes), largest(2, system%meshes), mean_force(size(system%sharing%mesh)), &
         loss(system%torque_paths%couplings), extreme(3, system%meshes)
      real(dp) :: periods, static(system%elements)
      integer :: harmonics, lines, j, k, q
      integer, allocatable :: piece(:)
      logical :: ended

      harmonics = wanted
      if (wanted == 0) harmonics = stored_harmonics(system)
      periods = motion%period
      if (motion%window > 0) periods = motion%window
      lines = nint(harmonics*periods)
      q = ceiling(periods*measured_samples(system, harmonics))
      if (motion%window > 0) q = transform_length(q)
      allocate (p(q, system%meshes), force(q, system%meshes), torque(q, system%torque_paths%rows), &
                piece(q))
      call sample_orbit(system, motion%frequency_ratio, motion%period, motion%state, p, force, share, largest, torque, &
                        window=motion%window, observer=observer, stopped=ended, mean=mean_force, loss=loss, &
                        piece=piece, reach_of=extreme)
      if (present(stopped)) stopped = ended
      ! Figures of long windows take a second that nobody waits for any more.
      if (motion%window > 0 .and. (ended .or. system%interrupt%raised())) return
      motion%held = system%torque_paths%held
      motion%couplings = system%torque_paths%couplings
      if (size(loss) > 0) motion%coupling_energy_loss = loss
      associate (torques => system%torque_paths%torques)
         motion%shaft_torque_mean = sum(torque(:, :torques), 1)/q
         motion%shaft_torque_minimum = [(-peak(-torque(:, j), motion%window > 0, piece), j=1, torques)]
         motion%shaft_torque_maximum = [(peak(torque(:, j), motion%window > 0, piece), j=1, torques)]
      end associate
      if (any(system%friction > 0)) call correct_torques(system, extreme, largest, sum(force, 1)/q, motion)
      if (system%torque_paths%bearings > 0) call measure_bearings(system, torque, motion)
      if (motion%window > 0) then
         call find_uncertainty(system, p, force, torque(:, :system%torque_paths%torques), motion)
         if (system%interrupt%raised()) return
      end if
      call transform%plan(q)
      if (allocated(motion%coefficients)) deallocate (motion%coefficients)
      allocate (motion%coefficients(1 + 2*lines, system%meshes))
      motion%mean = sum(p, 1)/q
      motion%rms = [(sqrt(2*sum((p(:, j) - motion%mean(j))**2)/q), j=1, system%meshes)]
      motion%minimum = [(-peak(-p(:, j), motion%window > 0), j=1, system%meshes)]
      motion%maximum = [(peak(p(:, j), motion%window > 0), j=1, system%meshes)]
      if (any(system%friction > 0)) then
         motion%minimum = -extreme(2, :)
         motion%maximum = extreme(1, :)
      end if
      if (allocated(motion%mesh_load)) deallocate (motion%mesh_load)
      allocate (motion%mesh_load(system%meshes))
      static = static_forces_at(system, motion%frequency_ratio)
      do j = 1, system%meshes
         if (any(system%friction > 0)) then
            continue
         else if (system%law(j)%peaks) then
            associate (region => [(system%law(j)%region_at(p(k, j)), k=1, q)])
               largest(:, j) = max(largest(:, j), [peak(force(:, j), motion%window > 0, region), &
                                                      peak(-force(:, j), motion%window > 0, region)])
            end associate
         else
            largest(:, j) = [peak(force(:, j), motion%window > 0), peak(-force(:, j), motion%window > 0)]
         end if
         call put_force(system, static, j, largest(1, j), largest(2, j), motion%mesh_load(j))
         if (.not. system%half_backlash(j) > 0) cycle
         motion%mesh_load(j)%separation = share(0, j)
         motion%mesh_load(j)%back_contact = share(-1, j)
      end do
      if (size(mean_force) > 0) then
         motion%load_share = mean_force
         motion%load_share_maximum = mean_force
         call system%sharing%find_shares(mean_force, motion%mesh_load(system%sharing%mesh)%force_maximum, motion%load_share, &
                                         motion%load_share_maximum)
      end if
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

   !> Sets what a longer window would change of the figures.
   subroutine find_uncertainty(system, p, force, torque, motion)
      type(system_type), intent(in) :: system
      !> Displacements [1] and forces over k b_c [1], (sample, mesh); torques [N m], (sample, shaft).
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
      associate (u => motion%uncertainty, unit => system%load_unit, &
                 load => static(system%mesh_element))
         u%rms = of_p%rms
         u%mean = of_p%mean
         u%minimum = of_p%minimum
         u%maximum = of_p%maximum
         u%force_maximum = max(of_force%maximum, of_force%minimum)
         where (load > 0) u%force_maximum = of_force%maximum
         where (load < 0) u%force_maximum = of_force%minimum
         u%force_maximum = unit*u%force_maximum
         u%torque_mean = of_torque%mean
         u%torque_minimum = of_torque%minimum
         u%torque_maximum = of_torque%maximum
      end associate
   end subroutine find_uncertainty

end module geartrain_flow_orbit
