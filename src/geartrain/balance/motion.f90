!> A periodic motion of a train: what every method (balance, integration, shooting) gives.
module geartrain_balance_motion
   use geartrain_base_kinds, only: dp
   use geartrain_mesh_law_mesh_load, only: mesh_load_type
   implicit none (type, external)
   private
   public :: motion_type

   type :: motion_type
      !> Lambda [1].
      real(dp) :: frequency_ratio = 0
      !> Period in fundamental mesh periods (the sub-harmonic index eta); 0 where none was found.
      integer :: period = 1
      !> Mesh displacement over characteristic length, (1 + 2*harmonics, mesh): mean, cos 1, sin 1, cos 2, ...
      !> of the fundamental frequency Lambda/period, equation (7d).
      real(dp), allocatable :: coefficients(:, :)
      !> Per mesh, over characteristic length: the paper's rms (square root of the sum of squared harmonic
      !> amplitudes, which is sqrt(2) times the true AC rms), mean, minimum and maximum.
      real(dp), allocatable :: rms(:), mean(:), minimum(:), maximum(:)
      !> Largest force, dynamic factor, shares of separation and back contact, (mesh).
      type(mesh_load_type), allocatable :: mesh_load(:)
      !> State at time 0: displacement of every element, then its velocity; allocated where integration gave it.
      real(dp), allocatable :: state(:)
      !> Floquet multipliers over one period of the motion; allocated where they were asked for.
      complex(dp), allocatable :: multipliers(:)
      logical :: stable = .false.
      !> `stable` is a guess: the largest multiplier is as near to the unit circle as it is uncertain.
      logical :: undecided = .false.
      !> Some mesh bears on neither flank of its gap and nothing holds it there: its mean position is not unique.
      logical :: floating = .false.
      !> 'periodic'; where integration found no period 'chaotic', 'quasi-periodic', 'still settling' (or of a longer period than is
      !> looked for), 'undecided' or, of what has no figures, 'unbounded'.
      character(14) :: kind = 'periodic'
      !> Largest Lyapunov exponent [1], per unit of time: positive where neighbours part; of a periodic motion ln|multiplier|/time.
      !> Allocated where integration gave the motion.
      real(dp), allocatable :: lyapunov_exponent
      !> What it is uncertain by at 95 %; 0 for a periodic motion.
      real(dp) :: lyapunov_error = 0
      !> Relative error of the waveform, as estimated; negative where there is no estimate.
      real(dp) :: error_estimate = -1
      !> Share of random starts that settled on this motion; negative where it was not counted.
      real(dp) :: share = -1
   end type motion_type

end module geartrain_balance_motion
