!> The fields of a list of motions, as analyses give it.
module geartrain_flow_motion_fields
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
   use geartrain_balance_mesh_load, only: mesh_load_type
   use geartrain_balance_motion, only: motion_type, uncertainty_type
   use geartrain_base_carry, only: carry
   use geartrain_base_field, only: row => field_type
   use geartrain_base_fields, only: fields_type, listing, reading
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text
   use geartrain_flow_bearing_fields, only: bearing_axes, carry_bearings
   use geartrain_flow_load_share_fields, only: about_planet, carry_shares
   use geartrain_flow_torque_fields, only: about_coupling, about_held, carry_torque, coupling_row, loss_row
   implicit none (type, external)
   private
   public :: carry_loads, carry_states, coefficient_axis, visit_motions
   public :: about_coefficients, about_frequency, about_growth_rate, about_maximum, about_mean, about_mesh, about_minimum, &
      about_reading_error, &
      about_multipliers, about_rms, about_shaft, about_stable, about_true_ac_rms, about_undecided, carry_torques, on_stability

   !> Descriptions that several groups of fields share.
   character(*), parameter :: about_frequency = 'Lambda: fundamental frequency [rad/s] / characteristic_frequency'
   character(*), parameter :: about_mesh = 'mesh, in the order of the train; then couplings, with 1 um for 1 mrad of &
      &twist; then bearings, x and y', about_shaft = 'shaft, in the order of the train'
   character(*), parameter :: about_rms = 'rms of the paper, of mesh displacement / characteristic_length: root of the sum of &
      &squared harmonic amplitudes, sqrt(2) times the true AC rms'
   character(*), parameter :: about_true_ac_rms = 'root mean square over time of mesh displacement / characteristic_length without &
      &its mean; rms / sqrt(2)'
   character(*), parameter :: about_reading_error = 'estimated error by harmonics that are not carried, of the torque of a shaft, &
      &force of a bearing or displacement of a mesh without backlash where it is largest, over its alternating part'
   character(*), parameter :: about_mean = 'mean mesh displacement / characteristic_length'
   character(*), parameter :: about_minimum = 'smallest mesh displacement over the period / characteristic_length'
   character(*), parameter :: about_maximum = 'largest mesh displacement over the period / characteristic_length'
   character(*), parameter :: about_coefficients = 'Fourier coefficients of mesh displacement / characteristic_length: mean, cos &
      &1, sin 1, cos 2, ... of the frequency Lambda/period'
   character(*), parameter :: about_multipliers = 'Floquet multipliers over one period of the motion'
   character(*), parameter :: about_stable = '1 = stable: all Floquet multipliers are inside the unit circle; 0 = unstable, or no &
      &period was found'
   character(*), parameter :: about_undecided = '1 = undecided, `stable` is a guess: the largest multiplier is nearer to the unit &
      &circle than its error, the error of the motion is doubtful, or nothing confirms the multipliers'
   character(*), parameter :: about_growth_rate = 'largest real part of a Floquet exponent; negative where the motion is stable'
   character(*), parameter :: on_stability = 'with `stability`'

   type(row), parameter :: loads(4) = [ &
      row('mesh_force_maximum', 'mesh', 'N', &
          'largest mesh force over the period in the direction of the static force, damping included; of a coupling the torque, &
          &N m', optional=.true.), &
      row('dynamic_factor', 'mesh', '1', 'largest mesh force / static (mean) mesh force; NaN where there is no static force', &
          optional=.true., none_is_negative=.true.), &
      row('separation_fraction', 'mesh', '1', &
          'share of the period with the teeth apart, |p| < half_backlash', optional=.true.), &
      row('back_contact_fraction', 'mesh', '1', 'share of the period with the back flanks in contact, p < -half_backlash', &
          optional=.true.)]

   character(*), parameter :: of_torque = ' torque of a shaft over the period'
   type(row), parameter :: torques(3) = [ &
      row('shaft_torque_mean', 'shaft', 'N m', 'mean'//of_torque//', positive where its first body drives the second; NaN: &
          &undetermined, rigid shafts in parallel', 'with `shaft_torque`', optional=.true.), &
      row('shaft_torque_minimum', 'shaft', 'N m', 'smallest'//of_torque//', signed as shaft_torque_mean', 'with `shaft_torque`', &
          optional=.true.), &
      row('shaft_torque_maximum', 'shaft', 'N m', 'largest'//of_torque//', signed as shaft_torque_mean', 'with `shaft_torque`', &
          optional=.true.)]

   character(*), parameter :: as_rms = 'as rms_uncertainty, for ', in_window = 'where `window` > 0'
   type(row), parameter :: of_displacement(5) = [ &
      row('rms_uncertainty', 'mesh', '1', 'change of rms by a window ten times as long, 95 % bound', in_window, optional=.true.), &
      row('mean_uncertainty', 'mesh', '1', as_rms//'mean', in_window, optional=.true.), &
      row('minimum_uncertainty', 'mesh', '1', as_rms//'minimum', in_window, optional=.true.), &
      row('maximum_uncertainty', 'mesh', '1', as_rms//'maximum', in_window, optional=.true.), &
      row('force_uncertainty', 'mesh', 'N', as_rms//'mesh_force_maximum', in_window, optional=.true.)]
   type(row), parameter :: of_torques(3) = [ &
      row('torque_mean_uncertainty', 'shaft', 'N m', as_rms//'shaft_torque_mean', in_window, optional=.true.), &
      row('torque_min_uncertainty', 'shaft', 'N m', as_rms//'shaft_torque_minimum', in_window, optional=.true.), &
      row('torque_max_uncertainty', 'shaft', 'N m', as_rms//'shaft_torque_maximum', in_window, optional=.true.)]

   type(row), parameter :: reactions(3) = [ &
      row('reaction_torque_mean', 'held', 'N m', 'mean torque by which a held body is held, in the sense in which `speed_of` &
          &turns; NaN: undetermined, two held bodies on rigid shafts', &
          'where a body is held', optional=.true.), &
      row('reaction_torque_minimum', 'held', 'N m', 'smallest torque of a held body, signed as reaction_torque_mean', &
          'where a body is held', optional=.true.), &
      row('reaction_torque_maximum', 'held', 'N m', 'largest torque of a held body, signed as reaction_torque_mean', &
          'where a body is held', optional=.true.)]

   !> Carries the fields of the torques of shafts, held bodies and couplings.
   interface carry_torques
      module procedure :: carry_torques_1, carry_torques_2
   end interface carry_torques

   !> Carries the fields of the loads on meshes.
   interface carry_loads
      module procedure :: carry_loads_1, carry_loads_2
   end interface carry_loads

   character(*), parameter :: about_coordinate = 'coordinate of the state: the displacement of every elastic element, then the &
      &velocities; with damping to ground that of a body last', about_state = 'state at time 0: displacement of every elastic &
      &element / characteristic_length, then velocities / (characteristic_length times characteristic_frequency)', &
      from_flow = 'from time integration, or with friction_torque'

contains

   !> Visits a list of motions.
   subroutine visit_motions(motions, along, fields)
      !> The motions; not allocated: none. Before reading as many as the dimension is long.
      type(motion_type), allocatable, intent(inout) :: motions(:)
      !> Dimension of the list, whose axis has been visited.
      character(*), intent(in) :: along
      class(fields_type), intent(inout) :: fields
      type(motion_type), allocatable :: none(:)
      integer :: i, n, meshes, shafts, held, couplings, bearings, planets, terms, coordinates, states
      logical :: torques_there, planets_there, bearings_there

      n = fields%length_of(along)
      meshes = max(0, fields%length_of('mesh'))
      shafts = 0
      held = 0
      planets = 0
      couplings = 0
      bearings = 0
      terms = 0
      coordinates = 0
      states = 0
      ! The list of all fields is made without motions.
      if (.not. allocated(motions)) allocate (motions(0))
      if (fields%way /= reading) then
         do i = 1, min(n, size(motions))
            if (allocated(motions(i)%coefficients)) then
               meshes = size(motions(i)%coefficients, 2)
               terms = max(terms, size(motions(i)%coefficients, 1))
            end if
            if (allocated(motions(i)%shaft_torque_mean)) then
               held = motions(i)%held
               couplings = motions(i)%couplings
               shafts = size(motions(i)%shaft_torque_mean) - held - couplings
            end if
            if (allocated(motions(i)%bearing_force_mean)) bearings = size(motions(i)%bearing_force_mean, 2)
            if (allocated(motions(i)%load_share)) planets = size(motions(i)%load_share)
            if (allocated(motions(i)%state)) coordinates = max(coordinates, size(motions(i)%state))
            if (allocated(motions(i)%multipliers)) states = max(states, size(motions(i)%multipliers))
         end do
         call coefficient_axis([(i, i=1, terms/2)], fields)
      end if
      call fields%index_axis('mesh', meshes, about_mesh)
      torques_there = fields%has('shaft_torque_mean', shafts + held + couplings > 0)
      if (torques_there) call fields%index_axis('shaft', shafts, about_shaft)
      if (fields%has('reaction_torque_mean', held > 0)) call fields%index_axis('held', held, about_held)
      planets_there = fields%has('load_share', planets > 0)
      if (planets_there) call fields%index_axis('planet', planets, about_planet)
      if (fields%has('coupling_torque_mean', couplings > 0)) call fields%index_axis('coupling', couplings, about_coupling)
      bearings_there = fields%has('bearing_force_mean', bearings > 0)
      if (bearings_there) call bearing_axes(bearings, fields)
      if (fields%has('initial_state', coordinates > 0)) call fields%index_axis('coordinate', coordinates, about_coordinate)
      if (fields%has('multipliers', states > 0)) call fields%index_axis('state', states, &
                                                   'number of the multiplier, in no order that holds between '//along//'s')
      call fields%begin_list(along)
      if (fields%way == listing) then
         allocate (none(1))
         call fields%visit_item(1)
         call visit_motion(none(1), along, .true., .true., .true., fields)
      else
         do i = 1, n
            call fields%visit_item(i)
            call visit_motion(motions(i), along, torques_there, planets_there, bearings_there, fields)
         end do
      end if
      call fields%end_list()
   end subroutine visit_motions

   subroutine visit_motion(motion, along, torques_there, planets_there, bearings_there, fields)
      type(motion_type), intent(inout) :: motion
      !> Dimension of the list: 'point' of a sweep, else 'motion'.
      character(*), intent(in) :: along
      !> Whether a motion of the list has torques of shafts, load shares of planets, and forces of bearings.
      logical, intent(in) :: torques_there, planets_there, bearings_there
      class(fields_type), intent(inout) :: fields
      real(dp), allocatable :: ac(:)
      real(dp) :: exponent

      call carry(fields, row('frequency', '', '1', about_frequency), motion%frequency_ratio)
      call carry(fields, row('period', '', '1', 'period in periods of the fundamental, 1 to 16; 0 = none found: values and &
                             &coefficients are of the last 16 periods, or of `window`', least=0), &
                 motion%period)
      if (fields%has('window', motion%window > 0)) then
         call carry(fields, row('window', '', '1', 'window of the values from time 0 on, in periods of the fundamental; 0: the &
                                &values are of periods', in_window), motion%window)
         if (ieee_is_nan(motion%window)) motion%window = 0
      end if
      call carry(fields, row('kind', '', '', 'periodic; stationary: settled, values of a window; without a period: chaotic, &
                             &quasi-periodic, still settling (or a period above 16), undecided, or unbounded (given up, without &
                             &values)'), motion%kind)
      call carry(fields, row('rms', 'mesh', '1', about_rms, optional=.true.), motion%rms)
      if (allocated(motion%rms)) ac = motion%rms/sqrt(2.0_dp)
      if (fields%derives()) call carry(fields, row('true_ac_rms', 'mesh', '1', about_true_ac_rms), ac)
      call carry(fields, row('mean', 'mesh', '1', about_mean, optional=.true.), motion%mean)
      call carry(fields, row('minimum', 'mesh', '1', about_minimum, optional=.true.), motion%minimum)
      call carry(fields, row('maximum', 'mesh', '1', about_maximum, optional=.true.), motion%maximum)
      call carry_loads(fields, motion%mesh_load)
      if (torques_there) call carry_torques(fields, motion%shaft_torque_mean, motion%shaft_torque_minimum, &
                                            motion%shaft_torque_maximum)
      if (bearings_there) call carry_bearings(fields, motion%bearing_force_mean, motion%bearing_force_rms, &
                                              motion%bearing_force_minimum, motion%bearing_force_maximum)
      if (fields%length_of('coupling') > 0 .or. fields%way == listing) &
         call carry(fields, loss_row(''), motion%coupling_energy_loss)
      if (planets_there) call carry_shares(fields, motion%load_share, motion%load_share_maximum)
      if (fields%way == reading) motion%held = max(0, fields%length_of('held'))
      if (fields%way == reading) motion%couplings = max(0, fields%length_of('coupling'))
      if (fields%has('rms_uncertainty', allocated(motion%uncertainty%rms))) &
         call carry_uncertainty(fields, motion%uncertainty, torques_there)
      if (fields%has('ringing', motion%ringing >= 0)) &
         call carry(fields, row('ringing', '', '1', 'amplitude of free vibrations that have not died out over the alternating &
                                &displacement, largest of all meshes; NaN: not known', in_window, &
                                none_is_negative=.true.), motion%ringing)
      call carry(fields, row('coefficients', 'mesh coefficient', '1', about_coefficients, optional=.true.), motion%coefficients)
      if (fields%has('error_estimate', motion%error_estimate >= 0)) &
         call carry(fields, row('error_estimate', '', '1', 'estimated relative error of the waveform', &
                                'where there is an estimate', none_is_negative=.true.), motion%error_estimate)
      if (fields%has('reading_error_estimate', motion%reading_error_estimate >= 0)) &
         call carry(fields, row('reading_error_estimate', '', '1', about_reading_error, 'where there is an estimate', &
                                none_is_negative=.true.), motion%reading_error_estimate)
      exponent = ieee_value(exponent, ieee_quiet_nan)
      if (allocated(motion%lyapunov_exponent)) exponent = motion%lyapunov_exponent
      if (fields%has('lyapunov_exponent', allocated(motion%lyapunov_exponent))) then
         call carry(fields, row('lyapunov_exponent', '', '1', 'largest Lyapunov exponent / characteristic_frequency: &
                                &positive = chaotic, about 0 = quasi-periodic; of a periodic motion &
                                &ln(largest multiplier)/period', &
                                'from time integration'), exponent)
         call carry(fields, row('lyapunov_error', '', '1', 'uncertainty of lyapunov_exponent at 95 %; 0 for a periodic motion', &
                                'from time integration'), motion%lyapunov_error)
         if (ieee_is_nan(motion%lyapunov_error)) motion%lyapunov_error = 0
      end if
      if (fields%way == reading .and. .not. ieee_is_nan(exponent)) motion%lyapunov_exponent = exponent
      if (fields%has('floating', motion%floating)) &
         call carry(fields, row('floating', '', '1', '1 = some mesh touches neither flank and no mean torque holds it: its mean &
                                &position in the gap is arbitrary', 'where there is such a motion'), &
                    motion%floating)
      if (fields%has('multipliers', allocated(motion%multipliers))) then
         call carry(fields, row('stable', '', '1', about_stable, on_stability), motion%stable)
         call carry(fields, row('undecided', '', '1', about_undecided, on_stability), motion%undecided)
         call carry(fields, row('multipliers', 'state complex', '1', about_multipliers//'; NaN where no period was found', &
                                on_stability), motion%multipliers)
      end if
      if (fields%has('initial_state', allocated(motion%state))) &
         call carry(fields, row('initial_state', 'coordinate', '1', about_state, from_flow, optional=.true.), motion%state)
      if (fields%way == reading) call fields%check(all([allocated(motion%rms), allocated(motion%mean), allocated(motion%minimum), &
                                                        allocated(motion%maximum)] .eqv. allocated(motion%coefficients)), 'rms')
      ! Points of a sweep have no share of random starts.
      if (along == 'point') return
      if (fields%has('share', motion%share >= 0)) &
         call carry(fields, row('share', '', '1', 'share of the random starts that settled on the motion', &
                                none_is_negative=.true.), motion%share)
   end subroutine visit_motion

   !> What a longer window would change of the figures of a motion.
   subroutine carry_uncertainty(fields, uncertainty, torques_there)
      class(fields_type), intent(inout) :: fields
      type(uncertainty_type), intent(inout) :: uncertainty
      !> Whether a motion of the list has torques of shafts.
      logical, intent(in) :: torques_there

      call carry(fields, of_displacement(1), uncertainty%rms)
      call carry(fields, of_displacement(2), uncertainty%mean)
      call carry(fields, of_displacement(3), uncertainty%minimum)
      call carry(fields, of_displacement(4), uncertainty%maximum)
      call carry(fields, of_displacement(5), uncertainty%force_maximum)
      if (.not. torques_there) return
      call carry_first(of_torques(1), uncertainty%torque_mean)
      call carry_first(of_torques(2), uncertainty%torque_minimum)
      call carry_first(of_torques(3), uncertainty%torque_maximum)

   contains

      !> Without the reaction torques of held bodies and the torques of couplings.
      subroutine carry_first(about, values)
         type(row), intent(in) :: about
         real(dp), allocatable, intent(inout) :: values(:)
         real(dp), allocatable :: shafts(:)

         if (fields%way == reading) then
            call carry(fields, about, values)
         else
            if (allocated(values)) shafts = values(:min(size(values), max(0, fields%length_of('shaft'))))
            call carry(fields, about, shafts)
         end if
      end subroutine carry_first

   end subroutine carry_uncertainty

   !> Adds the axis of coefficients with the labels mean, cos 1, sin 1, cos 2, ...
   subroutine coefficient_axis(orders, fields)
      !> Harmonics of the coefficients, ascending.
      integer, intent(in) :: orders(:)
      class(fields_type), intent(inout) :: fields
      character(16) :: labels(1 + 2*size(orders))
      integer :: i

      if (.not. fields%derives()) return
      labels(1) = 'mean'
      do i = 1, size(orders)
         labels(2*i) = 'cos '//integer_text(orders(i))
         labels(2*i + 1) = 'sin '//integer_text(orders(i))
      end do
      call fields%text_axis('coefficient', labels, 'order of the coefficient in multiples of Lambda/period')
   end subroutine coefficient_axis

   !> Torques of the shafts, held bodies and couplings of a motion.
   subroutine carry_torques_1(fields, mean, minimum, maximum)
      class(fields_type), intent(inout) :: fields
      !> Torques [N m], (shaft, then held body, then coupling); not allocated: none.
      real(dp), allocatable, intent(inout) :: mean(:), minimum(:), maximum(:)

      call carry_torque(fields, [torques(1), reactions(1), coupling_row('coupling_torque_mean', '', 'mean')], mean)
      call carry_torque(fields, [torques(2), reactions(2), coupling_row('coupling_torque_minimum', '', 'smallest')], minimum)
      call carry_torque(fields, [torques(3), reactions(3), coupling_row('coupling_torque_maximum', '', 'largest')], maximum)
   end subroutine carry_torques_1

   !> Torques of the shafts, held bodies and couplings at each point of a branch.
   subroutine carry_torques_2(fields, mean, minimum, maximum)
      class(fields_type), intent(inout) :: fields
      !> Torques [N m], (shaft, then held body, then coupling, point); not allocated: none.
      real(dp), allocatable, intent(inout) :: mean(:, :), minimum(:, :), maximum(:, :)
      type(row) :: about(3), held(3)

      about = torques
      about%dimensions = 'point shaft'
      held = reactions
      held%dimensions = 'point held'
      call carry_torque(fields, [about(1), held(1), coupling_row('coupling_torque_mean', 'point', 'mean')], mean)
      call carry_torque(fields, [about(2), held(2), coupling_row('coupling_torque_minimum', 'point', 'smallest')], minimum)
      call carry_torque(fields, [about(3), held(3), coupling_row('coupling_torque_maximum', 'point', 'largest')], maximum)
   end subroutine carry_torques_2

   !> Loads on the meshes of a motion.
   subroutine carry_loads_1(fields, load)
      class(fields_type), intent(inout) :: fields
      !> Loads, (mesh); not allocated: none.
      type(mesh_load_type), allocatable, intent(inout) :: load(:)
      real(dp), allocatable :: force(:), factor(:), apart(:), back(:)

      if (allocated(load) .and. fields%way /= reading) then
         force = load%force_maximum
         factor = load%dynamic_factor
         apart = load%separation
         back = load%back_contact
      end if
      call carry(fields, loads(1), force)
      call carry(fields, loads(2), factor)
      call carry(fields, loads(3), apart)
      call carry(fields, loads(4), back)
      if (fields%derives() .or. &
          .not. (allocated(force) .and. allocated(factor) .and. allocated(apart) .and. allocated(back))) return
      if (allocated(load)) deallocate (load)
      allocate (load(size(force)))
      load%force_maximum = force
      load%dynamic_factor = factor
      load%separation = apart
      load%back_contact = back
   end subroutine carry_loads_1

   !> Loads on the meshes at each point of a branch.
   subroutine carry_loads_2(fields, load, points)
      class(fields_type), intent(inout) :: fields
      !> Loads, (mesh, point); not allocated: none.
      type(mesh_load_type), allocatable, intent(inout) :: load(:, :)
      !> Number of points in use.
      integer, intent(in) :: points
      real(dp), allocatable :: force(:, :), factor(:, :), apart(:, :), back(:, :)
      type(row) :: about(4)

      about = loads
      about%dimensions = 'point mesh'
      if (allocated(load) .and. fields%way /= reading) then
         force = load(:, :points)%force_maximum
         factor = load(:, :points)%dynamic_factor
         apart = load(:, :points)%separation
         back = load(:, :points)%back_contact
      end if
      call carry(fields, about(1), force)
      call carry(fields, about(2), factor)
      call carry(fields, about(3), apart)
      call carry(fields, about(4), back)
      if (fields%derives() .or. &
          .not. (allocated(force) .and. allocated(factor) .and. allocated(apart) .and. allocated(back))) return
      if (allocated(load)) deallocate (load)
      allocate (load(size(force, 1), size(force, 2)))
      load%force_maximum = force
      load%dynamic_factor = factor
      load%separation = apart
      load%back_contact = back
   end subroutine carry_loads_2

   !> Carries the states of the points of a branch.
   subroutine carry_states(fields, states)
      class(fields_type), intent(inout) :: fields
      !> States at time 0 [1], (coordinate, point); not allocated: not known.
      real(dp), allocatable, intent(inout) :: states(:, :)
      integer :: coordinates

      coordinates = 0
      if (allocated(states)) coordinates = size(states, 1)
      if (.not. fields%has('initial_state', allocated(states))) return
      call fields%index_axis('coordinate', coordinates, about_coordinate)
      call carry(fields, row('initial_state', 'point coordinate', '1', about_state, from_flow, optional=.true.), states)
   end subroutine carry_states

end module geartrain_flow_motion_fields
