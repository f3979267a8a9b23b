!> A motion of a train, as every method gives it: balance, integration, shooting.
module geartrain_balance_motion
   use geartrain_balance_mesh_load, only: mesh_load_type
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: motion_type, uncertainty_type

   !> What a window ten times as long changes of the figures of a motion, in 95 of 100 cases at most. The components are not
   !> allocated where the figures are those of a whole period.
   type :: uncertainty_type
      !> Of the displacements over characteristic length [1] and of the largest force [N], (mesh).
      real(dp), allocatable :: rms(:), mean(:), minimum(:), maximum(:), force_maximum(:)
      !> Of the torques of shafts [N m], (shaft).
      real(dp), allocatable :: torque_mean(:), torque_minimum(:), torque_maximum(:)
   end type uncertainty_type

   type :: motion_type
      !> Lambda [1].
      real(dp) :: frequency_ratio = 0
      !> Period in periods of the fundamental (the sub-harmonic index eta); 0: no period found.
      integer :: period = 1
      !> Window over which the figures are taken, from time 0 on [periods of the fundamental], where the common period is too long
      !> for them; 0: they are those of a period.
      real(dp) :: window = 0
      !> Mesh displacement over characteristic length, (1 + 2*harmonics, mesh): mean, cos 1, sin 1, cos 2, ...
      !> of the fundamental frequency Lambda/period, equation (7d); of a window of Lambda/window.
      real(dp), allocatable :: coefficients(:, :)
      !> Displacement over characteristic length [1], (mesh): the paper's rms (square root of the sum of squared harmonic
      !> amplitudes, which is sqrt(2) times the true AC rms), mean, minimum and maximum.
      real(dp), allocatable :: rms(:), mean(:), minimum(:), maximum(:)
      !> Largest force, dynamic factor, shares of separation and back contact, (mesh).
      type(mesh_load_type), allocatable :: mesh_load(:)
      !> Torque of each shaft, then of what holds each held body, then of each coupling, over the period [N m], (shaft, then held
      !> body, then coupling): mean and extremes; NaN where nothing determines it. Not allocated: not computed.
      real(dp), allocatable :: shaft_torque_mean(:), shaft_torque_minimum(:), shaft_torque_maximum(:)
      !> Numbers of held bodies and of couplings in these lists.
      integer :: held = 0, couplings = 0
      !> Force of each bearing in x and in y [N], (axis, bearing): mean, root mean square without the mean, extremes. Not
      !> allocated: not computed, or no bearings.
      real(dp), allocatable :: bearing_force_mean(:, :), bearing_force_rms(:, :), bearing_force_minimum(:, :), &
         bearing_force_maximum(:, :)
      !> Energy that each coupling loses to damping and friction in a period of the fundamental [J], (coupling); not allocated: no
      !> couplings.
      real(dp), allocatable :: coupling_energy_loss(:)
      !> Share of each planet in the mean load of its planetary set, by its mean and its largest force [1], (planet); not allocated:
      !> no planets.
      real(dp), allocatable :: load_share(:), load_share_maximum(:)
      !> State at time 0 [1]: displacements of the coordinates, then velocities; allocated where integration gave it.
      real(dp), allocatable :: state(:)
      !> Floquet multipliers over one period of the motion [1]; allocated where they were asked for.
      complex(dp), allocatable :: multipliers(:)
      !> Over one repetition of the waveform, of which `multipliers` are powers [1]; allocated where shooting found a motion that
      !> repeats itself within its period.
      complex(dp), allocatable :: repetition_multipliers(:)
      !> All multipliers are inside the unit circle by more than their rounding.
      logical :: stable = .false.
      !> `stable` and `undecided` are known without multipliers, by the growth rate over a part of a long period.
      logical :: assessed = .false.
      !> `stable` is a guess: the largest multiplier is as near to the unit circle as it is uncertain.
      logical :: undecided = .false.
      !> Some mesh bears on neither flank, and no mean torque holds the mesh in its place in the gap: its mean position is not
      !> unique.
      logical :: floating = .false.
      !> Uncertainty of the figures of a window.
      type(uncertainty_type) :: uncertainty
      !> What is left of free vibrations that take too long to die out: amplitude over the alternating displacement, the largest of
      !> all meshes [1]; negative: not known.
      real(dp) :: ringing = -1
      !> 'periodic'; 'stationary' where it has settled and its figures are those of a window; where integration found no period
      !> 'chaotic', 'quasi-periodic', 'still settling' (or of a longer period than is
      !> looked for), 'undecided' or 'unbounded' (without any figures).
      character(14) :: kind = 'periodic'
      !> Largest Lyapunov exponent per dimensionless time [1]: positive where neighbouring states move apart; of a periodic motion
      !> ln|largest multiplier|/period. Allocated where integration gave the motion.
      real(dp), allocatable :: lyapunov_exponent
      !> Uncertainty of `lyapunov_exponent` at 95 % [1]; 0 for a periodic motion.
      real(dp) :: lyapunov_error = 0
      !> Estimated relative error of the waveform [1]; negative: no estimate.
      real(dp) :: error_estimate = -1
      !> Largest part of harmonics that are not carried in a torque of a shaft, a force of a bearing or the displacement of a mesh
      !> without backlash [1]; negative: no estimate.
      real(dp) :: reading_error_estimate = -1
      !> Share of random starts that settled on this motion [1]; negative: not counted.
      real(dp) :: share = -1
   end type motion_type

end module geartrain_balance_motion
