!> A branch of periodic motions over frequency: what continuation gives, point by point, through the folds.
module geartrain_trace_branch
   use geartrain_balance_mesh_load, only: mesh_load_type
   use geartrain_base_carry, only: carry
   use geartrain_base_field, only: row => field_type
   use geartrain_base_fields, only: arranging, fields_type, listing, reading, writing
   use geartrain_base_kinds, only: dp
   use geartrain_base_words, only: words_type
   use geartrain_flow_bearing_fields, only: bearing_forces_type, visit_bearings
   use geartrain_flow_load_share_fields, only: about_planet, carry_shares
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_trace_settings, only: response_settings_type
   use geartrain_flow_motion_fields, only: about_coefficients, about_frequency, about_growth_rate, about_maximum, about_mean, &
      about_reading_error, about_mesh, about_minimum, about_multipliers, about_rms, about_shaft, about_stable, &
      about_true_ac_rms, about_undecided, carry_loads, carry_states, carry_torques, coefficient_axis, on_stability
   use geartrain_trace_stages, only: no_stage
   use geartrain_flow_torque_fields, only: about_coupling, about_held, loss_row
   implicit none (type, external)
   private
   public :: arrange_points, branch_type, carried_by, coefficients_of, contact_edge_type, dense_coefficients, gap_along, has_sets, &
      multipliers_at, response_settings_type, special_point_type, trace_state_type, visit_points, widen

   !> A fold or a bifurcation on the branch.
   type :: special_point_type
      !> 'fold', 'period doubling', 'neimark-sacker' (a pair of multipliers leaves the unit circle) or 'branch point' (another
      !> branch of the same period crosses; a multiplier passes +1 without a fold); of a contact onset 'separation' (a mesh begins
      !> or ceases to separate), 'back contact' (its back flanks begin or cease to touch) or 'stage 2 reached'.
      character(24) :: kind = ''
      !> Lambda [1].
      real(dp) :: frequency_ratio = 0
      !> Index of the point of the branch before the special point; of a fold the point itself.
      integer :: point = 0
      !> Root mean square displacement over characteristic length [1], (mesh).
      real(dp), allocatable :: rms(:)
      !> Length of the branch up to it, of a change of stability [1]; huge where it is not known.
      real(dp) :: arclength = huge(1.0_dp)
      !> Number of multipliers, or of pairs, that pass the unit circle there together: N - 1 where N equal branches begin to move
      !> differently.
      integer :: multiplicity = 1
      !> Of a contact onset the number of the mesh.
      integer :: mesh = 0
      !> Change of Lambda by refine_special_points [1]; -1: shooting finds none of its kind near it; -2: not refined.
      real(dp) :: correction = -2
   end type special_point_type

   !> Where a mesh begins or ceases to separate, or its back flanks to collide.
   type :: contact_edge_type
      !> Index of the point of the branch before the edge.
      integer :: point = 0
      !> Number of the mesh.
      integer :: mesh = 0
      !> .true.: edge of a range of back collision; .false.: of separation.
      logical :: back = .false.
      !> Whether it was interpolated between solutions, and is no solution.
      logical :: interpolated = .false.
      !> Number of the stage of a coupling that is reached or left there; `no_stage`: none.
      integer :: stage = no_stage
      !> Lambda [1]; rms over characteristic length [1], (mesh).
      real(dp) :: frequency_ratio = 0
      real(dp), allocatable :: rms(:)
   end type contact_edge_type

   !> State of the trace of a response: all that the next step depends on, so that another run can go on with the trace.
   type :: trace_state_type
      !> The trace from `start` is done, branch%ended says why it ended, and the trace from `stop` is under way.
      logical :: from_stop = .false.
      !> The trace from `start` was followed to where the branch leaves the range.
      logical :: whole = .false.
      !> Number of points of the trace from `start`.
      integer :: first_points = 0
      !> Steps done; 0: the trace from this end has not begun.
      integer :: steps = 0
      !> Harmonics in use.
      integer :: harmonics = 0
      !> Length of the next step, and of the longest [1]; the tracer's measure of curvature.
      real(dp) :: step = 0, longest = 0, curvature = 0
      !> Points so far that miss the tolerance.
      integer :: missed = 0
      !> Latest steps whose end was not found with the harmonics that the tolerance needs.
      integer :: refusals = 0
      !> Direction of Lambda, +1 or -1, before the branch became vertical; 0: the branch is not vertical.
      integer :: sense = 0
      !> Latest solution point; solution point before it; solution point with which the trace began.
      type(solution_point_type) :: here, earlier, origin
      !> Beginning of the words that will say why the trace ended.
      type(words_type), allocatable :: before
   end type trace_state_type

   !> A branch of periodic motions; arrays over the points may be longer than `points`.
   type :: branch_type
      !> Numbers of points, meshes, shafts, held bodies, couplings, planets, multipliers of a point (of many states the leading
      !> ones; 0 where the period is long) and harmonics in use; period of the motions in periods of the fundamental.
      integer :: points = 0, meshes = 0, shafts = 0, held = 0, couplings = 0, planets = 0, states = 0, harmonics = 0, &
         subharmonic = 1
      !> Lambda, (point).
      real(dp), allocatable :: frequency_ratio(:)
      !> Harmonics of Lambda/subharmonic that `coefficients` has room for, ascending: 1 .. harmonics; where balances carry sets of
      !> harmonics, those that any point carries.
      integer, allocatable :: orders(:)
      !> (1 + 2*orders, mesh, point), mean, cos and sin of each order, see motion_type.
      real(dp), allocatable :: coefficients(:, :, :)
      !> Length of the branch from where its trace began [1], in the metric of the branch (docs/numerics.md), (point); derivatives
      !> of frequency_ratio, (point), and of the rms, (mesh, point), of the balance by this length.
      real(dp), allocatable :: arclength(:), free_slope(:), rms_slope(:, :)
      !> (mesh, point), see motion_type.
      real(dp), allocatable :: rms(:, :), mean(:, :), minimum(:, :), maximum(:, :)
      !> Mesh forces, (mesh, point).
      type(mesh_load_type), allocatable :: mesh_load(:, :)
      !> Torque of each shaft, then of what holds each held body, then of each coupling, over the period [N m], (shaft, then held
      !> body, then coupling, point); NaN where nothing determines it; forces of bearings. Allocated where asked for.
      real(dp), allocatable :: shaft_torque_mean(:, :), shaft_torque_minimum(:, :), shaft_torque_maximum(:, :)
      type(bearing_forces_type) :: bearing_force
      !> Energy that each coupling loses in a period of the fundamental [J], (coupling, point); allocated with the torques.
      real(dp), allocatable :: coupling_energy_loss(:, :)
      !> Share of each planet in the mean load of its planetary set, by its mean and its largest force [1], (planet, point); not
      !> allocated: no planets.
      real(dp), allocatable :: load_share(:, :), load_share_maximum(:, :)
      !> Half backlash over characteristic length, (mesh).
      real(dp), allocatable :: half_backlash(:)
      !> Of a branch over a parameter of the train, whose values are in `frequency_ratio` everywhere in this type: name of the
      !> parameter, its unit ('1' for a dimensionless one), Lambda of all motions, and half backlash at each point, (mesh, point).
      character(:), allocatable :: parameter, parameter_unit
      real(dp) :: constant_frequency = 0
      real(dp), allocatable :: half_backlash_at(:, :)
      !> Floquet multipliers, (state, point); not allocated: stability was not asked for. Where the period is long: no states.
      complex(dp), allocatable :: multipliers(:, :)
      !> Floquet multipliers over one repetition of the waveform, (state, point), of which `multipliers` are powers; allocated where
      !> the motions repeat themselves within the period and stability was asked for.
      complex(dp), allocatable :: repetition_multipliers(:, :)
      !> Whether all perturbations die out, (point); whether this is a guess, see geartrain_trace_stability_assessment; not
      !> allocated: stability was not asked for.
      logical, allocatable :: stable(:), undecided(:)
      !> Rate of the slowest of them, the real part of the largest Floquet exponent [1/s], (point).
      real(dp), allocatable :: growth_rate(:)
      !> Second estimate of the largest magnitude of a multiplier, (point); negative: not needed.
      real(dp), allocatable :: second_estimate(:)
      !> Whether the number of multipliers outside the unit circle is a guess, (point).
      logical, allocatable :: count_undecided(:)
      !> Estimated relative error of the waveform [1], (point), and of each mesh by itself, (mesh, point): distance to the exact
      !> motion at the same Lambda, or to the fold of the exact branch where the exact branch turns before this Lambda.
      real(dp), allocatable :: error_estimate(:), mesh_error_estimate(:, :)
      !> As of a motion, (point); not allocated where shooting takes the place of the balance.
      real(dp), allocatable :: reading_error_estimate(:)
      !> States at time 0 [1], (coordinate, point); allocated where dry friction takes shooting in place of balance.
      real(dp), allocatable :: state(:, :)
      !> Relative change of the waveform by refine_branch [1], (point), the error before it; negative: not refined; not allocated:
      !> refinement was not asked for.
      real(dp), allocatable :: correction(:)
      !> Whether `error_estimate` may be off by more than a small factor, (point), as near a fold, near grazing, or above 0.1.
      logical, allocatable :: estimate_doubtful(:)
      !> Harmonics that each point was solved with, at most `harmonics`, (point).
      integer, allocatable :: point_harmonics(:)
      !> Number of the segment of a point, (point). A new segment begins where the branch comes back from above the amplitude limit,
      !> and with the points traced from `stop` where the trace from `start` does not reach `stop`.
      integer, allocatable :: segment(:)
      !> Time spent so far on the stability of its points [s]; no result.
      real(dp) :: verdict_seconds = 0
      !> Folds and bifurcations, in the order found.
      type(special_point_type), allocatable :: special_points(:)
      !> Edges of separation and back collision; filled by locate_contact_edges.
      type(contact_edge_type), allocatable :: contact_edges(:)
      !> Why the trace ended; not allocated: the trace is under way.
      type(words_type), allocatable :: ended
      !> Whether the branch got to the other end of the range or closed; whether it closed; whether the observer ended the trace.
      logical :: complete = .false., closed = .false., cancelled = .false.
      !> What the branch follows from, in words; not allocated for the response itself.
      type(words_type), allocatable :: origin
      !> State of the trace; allocated while the response is under way.
      type(trace_state_type), allocatable :: trace
   end type branch_type

contains

   !> Allocates the arrays of the points anew and puts chosen points into them, in a chosen order.
   subroutine arrange_points(branch, order, room)
      !> The branch; special points and other components stay as they are.
      type(branch_type), intent(inout), target :: branch
      !> Old index of each point that is kept, in the new order.
      integer, intent(in) :: order(:)
      !> Number of points that the new arrays have room for.
      integer, intent(in) :: room
      type(fields_type) :: fields

      fields%way = arranging
      fields%order = order
      call fields%expect('point', room)
      call fields%expect('coefficient', 1 + 2*size(branch%orders))
      call visit_points(branch, fields)
   end subroutine arrange_points

   !> Makes room for the coefficients of further harmonics.
   subroutine widen(branch, orders)
      type(branch_type), intent(inout) :: branch
      !> Harmonics of Lambda/subharmonic, ascending.
      integer, intent(in) :: orders(:)
      real(dp), allocatable :: wider(:, :, :)
      integer, allocatable :: both(:)
      logical :: listed(maxval([0, branch%orders, orders]))
      integer :: place(size(listed)), row(1 + 2*size(branch%orders)), i, k, n

      listed = .false.
      listed(branch%orders) = .true.
      listed(orders) = .true.
      if (count(listed) == size(branch%orders)) return
      both = pack([(k, k=1, size(listed))], listed)
      place(both) = [(k, k=1, size(both))]
      row = [1, (2*place(branch%orders(i)), 2*place(branch%orders(i)) + 1, i=1, size(branch%orders))]
      ! The room of points to come stays as it is: a branch is widened hundreds of times.
      allocate (wider(1 + 2*size(both), branch%meshes, size(branch%frequency_ratio)))
      do n = 1, branch%points
         wider(:, :, n) = 0
         wider(row, :, n) = branch%coefficients(:, :, n)
      end do
      call move_alloc(wider, branch%coefficients)
      call move_alloc(both, branch%orders)
      branch%harmonics = size(listed)
   end subroutine widen

   !> Whether the balances of the branch carry sets of harmonics.
   pure logical function has_sets(branch)
      type(branch_type), intent(in) :: branch

      has_sets = size(branch%orders) < branch%harmonics
   end function has_sets

   !> Half backlash of a mesh at each point, over characteristic length [1], (point).
   pure function gap_along(branch, mesh) result(gap)
      type(branch_type), intent(in) :: branch
      !> Number of the mesh.
      integer, intent(in) :: mesh
      real(dp) :: gap(branch%points)

      gap = 0
      if (allocated(branch%half_backlash_at)) then
         gap = branch%half_backlash_at(mesh, :branch%points)
      else if (allocated(branch%half_backlash)) then
         gap = branch%half_backlash(mesh)
      end if
   end function gap_along

   !> Harmonics that either of two points carries, ascending.
   pure function carried_by(branch, i, j) result(harmonic)
      type(branch_type), intent(in) :: branch
      !> Indices of the points.
      integer, intent(in) :: i, j
      integer, allocatable :: harmonic(:)
      integer :: k

      harmonic = pack(branch%orders, [(any(abs(branch%coefficients(2*k:2*k + 1, :, i)) > 0) .or. &
                                       any(abs(branch%coefficients(2*k:2*k + 1, :, j)) > 0), k=1, size(branch%orders))])
   end function carried_by

   !> Multipliers of a point over one repetition of its waveform [1], (state).
   pure function multipliers_at(branch, i) result(multipliers)
      !> A branch with stability.
      type(branch_type), intent(in) :: branch
      !> Index of the point.
      integer, intent(in) :: i
      complex(dp) :: multipliers(branch%states)

      if (allocated(branch%repetition_multipliers)) then
         multipliers = branch%repetition_multipliers(:, i)
      else
         multipliers = branch%multipliers(:, i)
      end if
   end function multipliers_at

   !> Coefficients of every harmonic up to the highest, (1 + 2*harmonics, mesh), from those of `orders`.
   pure function dense_coefficients(branch, coefficients) result(dense)
      type(branch_type), intent(in) :: branch
      !> Coefficients of its orders, (1 + 2*orders, mesh).
      real(dp), intent(in) :: coefficients(:, :)
      real(dp) :: dense(1 + 2*branch%harmonics, size(coefficients, 2))
      integer :: k

      dense = 0
      dense(1, :) = coefficients(1, :)
      do k = 1, size(branch%orders)
         dense(2*branch%orders(k):2*branch%orders(k) + 1, :) = coefficients(2*k:2*k + 1, :)
      end do
   end function dense_coefficients

   !> Coefficients of every harmonic of a point up to the highest harmonic of the branch, (1 + 2*harmonics, mesh).
   pure function coefficients_of(branch, i) result(dense)
      type(branch_type), intent(in) :: branch
      !> Index of the point.
      integer, intent(in) :: i
      real(dp) :: dense(1 + 2*branch%harmonics, size(branch%coefficients, 2))

      dense = dense_coefficients(branch, branch%coefficients(:, :, i))
   end function coefficients_of

   !> Visits the fields of the points, in the order along the branch: to write, to read, to enlarge or to reorder the arrays.
   subroutine visit_points(branch, fields)
      !> The branch; set by reading and arranging.
      type(branch_type), intent(inout) :: branch
      !> The fields of the results, in the group of the branch.
      class(fields_type), intent(inout) :: fields
      real(dp), allocatable :: ac(:, :)
      logical, allocatable :: untried(:)
      integer, allocatable :: orders(:)
      integer :: k
      logical :: none

      call fields%index_axis('point', branch%points, 'point, in the order along the branch')
      call fields%index_axis('mesh', branch%meshes, about_mesh)
      if (fields%way == reading) then
         branch%orders = [(k, k=1, branch%harmonics)]
      else if (.not. allocated(branch%orders)) then
         branch%orders = [(k, k=1, branch%harmonics)]
      end if
      if (fields%way /= arranging) then
         if (fields%has('orders', has_sets(branch))) then
            orders = branch%orders
            k = size(orders)
            call fields%index_axis('carried', k, 'harmonic that points carry, ascending')
            call carry(fields, row('orders', 'carried', '1', 'harmonics of Lambda/subharmonic that the coefficients have', &
                                   'where the program chooses them', least=1, &
                                   most=branch%harmonics), orders)
            if (fields%way == reading .and. allocated(orders)) branch%orders = orders
         end if
      end if
      if (allocated(branch%coefficients) .or. fields%way == listing) call coefficient_axis(branch%orders, fields)
      none = branch%points == 0   ! only the origin is known so far
      call visit_free(branch, fields, none)
      call carry(fields, row('rms', 'point mesh', '1', about_rms, optional=none), branch%rms)
      if (fields%derives()) then
         if (allocated(branch%rms)) ac = branch%rms(:, :branch%points)/sqrt(2.0_dp)
         call carry(fields, row('true_ac_rms', 'point mesh', '1', about_true_ac_rms), ac)
      end if
      if (fields%has('arclength', allocated(branch%arclength))) then
         call carry(fields, row('arclength', 'point', '1', 'length of the branch up to the point, in scaled Lambda and mesh &
                                &displacement together', optional=none), branch%arclength)
         call carry(fields, row('free_slope', 'point', '1', 'derivative of frequency or parameter with respect to arclength', &
                                optional=none), branch%free_slope)
         call carry(fields, row('rms_slope', 'point mesh', '1', 'derivative of rms with respect to arclength', optional=none), &
                    branch%rms_slope)
      end if
      call carry(fields, row('mean', 'point mesh', '1', about_mean, optional=none), branch%mean)
      call carry(fields, row('minimum', 'point mesh', '1', about_minimum, optional=none), branch%minimum)
      call carry(fields, row('maximum', 'point mesh', '1', about_maximum, optional=none), branch%maximum)
      call carry_loads(fields, branch%mesh_load, branch%points)
      if (fields%has('shaft_torque_mean', allocated(branch%shaft_torque_mean))) then
         call fields%index_axis('shaft', branch%shafts, about_shaft)
         if (fields%has('reaction_torque_mean', branch%held > 0)) call fields%index_axis('held', branch%held, about_held)
         if (fields%has('coupling_torque_mean', branch%couplings > 0)) &
            call fields%index_axis('coupling', branch%couplings, about_coupling)
         call carry_torques(fields, branch%shaft_torque_mean, branch%shaft_torque_minimum, branch%shaft_torque_maximum)
         if (fields%has('coupling_energy_loss', allocated(branch%coupling_energy_loss))) &
            call carry(fields, loss_row('point'), branch%coupling_energy_loss)
      end if
      call visit_bearings(branch%bearing_force, fields)
      call carry_states(fields, branch%state)
      if (fields%has('load_share', allocated(branch%load_share))) then
         call fields%index_axis('planet', branch%planets, about_planet)
         call carry_shares(fields, branch%load_share, branch%load_share_maximum)
      end if
      call carry(fields, row('coefficients', 'point mesh coefficient', '1', about_coefficients, optional=none), &
                 branch%coefficients)
      call carry(fields, row('error_estimate', 'point', '1', 'estimated relative error of the waveform without rounding (1e-14), &
                             &against the exact motion at this Lambda or, where the branch turns before it, at the fold', &
                             optional=none), branch%error_estimate)
      call carry(fields, row('mesh_error_estimate', 'point mesh', '1', 'estimated error of the waveform of a mesh over its &
           &amplitude; not below error_estimate for a mesh without backlash', optional=none), branch%mesh_error_estimate)
      if (fields%has('reading_error_estimate', allocated(branch%reading_error_estimate))) &
         call carry(fields, row('reading_error_estimate', 'point', '1', about_reading_error, 'where a balance gives the motions'), &
                    branch%reading_error_estimate)
      call carry(fields, row('estimate_doubtful', 'point', '1', '1 = error_estimate may be wrong by more than a small factor: a &
                             &fold within its own error, a contact that begins or ends within the error, or an error above 0.1', &
                             optional=none), branch%estimate_doubtful)
      call carry(fields, row('harmonics', 'point', '1', 'number of harmonics of Lambda/subharmonic of the point', &
                             optional=none, most=branch%harmonics), branch%point_harmonics)
      call carry(fields, row('segment', 'point', '1', &
                             'number of the segment. A segment begins where the branch returns from above amplitude_limit, or with &
                                &the points traced from `to`, where the points from `from` end earlier or at another motion', &
                                optional=none, least=1), branch%segment)
      if (fields%has('correction', allocated(branch%correction))) then
         if (allocated(branch%correction)) untried = branch%correction(:branch%points) < -1
         call carry(fields, row('correction', 'point', '1', 'relative change of the waveform by refinement, the error before it; &
                                &NaN: shooting finds no orbit near the point', &
                                'with `refine`', none_is_negative=.true.), branch%correction)
         if (fields%has('untried', count_of(untried) > 0)) &
            call carry(fields, row('untried', 'point', '1', '1 = refinement has not reached the point yet', &
                                   'where refinement is not finished'), untried)
         if (fields%way == reading .and. allocated(untried) .and. .not. allocated(fields%wrong)) &
            where (untried) branch%correction = -2
      end if
      if (fields%has('stable', allocated(branch%stable))) call visit_stability(branch, fields)
      if (fields%way /= reading .or. allocated(fields%wrong) .or. .not. allocated(branch%coefficients)) return
      call fields%check(size(branch%coefficients, 1) == 1 + 2*size(branch%orders), 'coefficients')
   end subroutine visit_points

   !> Visits the free parameter of the branch: Lambda; or the values of a parameter of the train, and the constant Lambda.
   subroutine visit_free(branch, fields, none)
      type(branch_type), intent(inout) :: branch
      class(fields_type), intent(inout) :: fields
      !> The branch has no points.
      logical, intent(in) :: none
      real(dp), allocatable :: constant(:)
      character(12) :: unit
      integer :: k

      if (allocated(branch%parameter) .and. fields%way /= arranging) then
         if (fields%way == writing) constant = [(branch%constant_frequency, k=1, branch%points)]
         call carry(fields, row('frequency', 'point', '1', about_frequency, optional=none), constant)
         if (fields%way == reading .and. allocated(constant) .and. .not. none) branch%constant_frequency = constant(1)
      else
         call carry(fields, row('frequency', 'point', '1', about_frequency, optional=none), branch%frequency_ratio)
      end if
      if (.not. (allocated(branch%parameter) .or. fields%way == listing)) return
      unit = merge(' ', '1', fields%way == listing)
      if (allocated(branch%parameter_unit)) unit = branch%parameter_unit
      if (fields%way /= arranging) call carry(fields, row('parameter', 'point', unit, 'value of the parameter `parameter_name`', &
                                        'with `parameter`', optional=none), branch%frequency_ratio)
      call carry(fields, row('half_backlash', 'point mesh', '1', 'half of the backlash / characteristic_length', &
                             'with `parameter`', optional=none), branch%half_backlash_at)
   end subroutine visit_free

   pure integer function count_of(flags)
      logical, allocatable, intent(in) :: flags(:)

      count_of = 0
      if (allocated(flags)) count_of = count(flags)
   end function count_of

   subroutine visit_stability(branch, fields)
      type(branch_type), intent(inout) :: branch
      class(fields_type), intent(inout) :: fields

      if (fields%has('multipliers', branch%states > 0)) call fields%index_axis('state', branch%states, &
         'number of the multiplier, in no order that holds between points')
      call carry(fields, row('stable', 'point', '1', about_stable, on_stability), branch%stable)
      call carry(fields, row('undecided', 'point', '1', about_undecided, on_stability), branch%undecided)
      call carry(fields, row('growth_rate', 'point', '1/s', about_growth_rate, on_stability), branch%growth_rate)
      call carry(fields, row('count_undecided', 'point', '1', '1 = the number of multipliers outside the unit circle is a guess: &
                             &one is nearer to it than its error', on_stability), branch%count_undecided)
      call carry(fields, row('second_estimate', 'point', '1', 'largest magnitude of a multiplier of the motion corrected by its &
                             &estimated error; NaN: not needed', on_stability, none_is_negative=.true.), &
                 branch%second_estimate)
      if (fields%has('multipliers', branch%states > 0)) call carry(fields, row('multipliers', 'point state complex', '1', &
         about_multipliers//'; from 160 states (41 flexible shafts) on the 16 largest, rough inside the unit circle unless &
            &`multipliers` is set', on_stability//' and a short period, or `multipliers`'), &
         branch%multipliers)
      if (fields%has('repetition_multipliers', allocated(branch%repetition_multipliers))) &
         call carry(fields, row('repetition_multipliers', 'point state complex', '1', 'Floquet multipliers over one repetition of &
                                &the waveform; `multipliers` are powers of them', on_stability//', where all orders have a common &
                               &divisor', optional=.true.), branch%repetition_multipliers)
   end subroutine visit_stability

end module geartrain_trace_branch
