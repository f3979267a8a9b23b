!> A branch of periodic motions over frequency: what continuation gives, point by point, through the folds.
module geartrain_branch_branch
   use geartrain_base_kinds, only: dp
   use geartrain_branch_path, only: place_type
   use geartrain_motion_mesh_load, only: mesh_load_type
   use geartrain_motion_motion, only: motion_type
   implicit none (type, external)
   private
   public :: branch_type, contact_edge_type, response_settings_type, special_point_type, trace_state_type

   !> The variables of &response; from and to are `start` and `stop`.
   type :: response_settings_type
      real(dp) :: start = 0, stop = 0
      !> Harmonics of Lambda/subharmonic; 0 lets the program choose for `tolerance`.
      integer :: harmonics = 6
      integer :: subharmonic = 1
      logical :: stability = .true.
      !> Largest rms over characteristic length; negative: 12 with backlash, none for a linear train.
      real(dp) :: amplitude_limit = -1
      !> 'exact' or 'sampled' (the paper's DFT, with `samples` points a period; 0: chosen).
      character(16) :: coefficients = 'exact'
      integer :: samples = 0
      !> 'arclength' or 'local' (the paper's switching of the control parameter, equation (11)).
      character(16) :: control = 'arclength'
      !> Relative error of the waveform aimed at where harmonics = 0.
      real(dp) :: tolerance = 1e-4_dp
      !> Largest step along the branch, in Lambda and mesh displacement together.
      real(dp) :: step = 0.05_dp
      integer :: max_points = 20000
      !> Generations of branches that follow from period doublings, and whether those that cross at branch points are followed, see
      !> follow_bifurcations.
      integer :: period_doublings = 0
      logical :: branch_points = .false.
      !> The points are polished by shooting, see refine_branch.
      logical :: refine = .false.
   end type response_settings_type

   !> A place on the branch that a reader looks for.
   type :: special_point_type
      !> 'fold', 'period doubling', 'torus' (a pair of multipliers leaves the unit circle) or 'branch point' (another branch of the
      !> same period crosses; a multiplier passes +1 without a fold).
      character(16) :: kind = ''
      real(dp) :: frequency = 0
      !> Index of the point before it.
      integer :: point = 0
      real(dp), allocatable :: rms(:)
   end type special_point_type

   !> Where a mesh begins or ceases to separate, or its back flanks to collide.
   type :: contact_edge_type
      !> The point of the branch before it.
      integer :: point = 0
      integer :: mesh = 0
      !> Of the back flanks.
      logical :: back = .false.
      !> Lambda.
      real(dp) :: frequency = 0
   end type contact_edge_type

   !> Where the trace of a response stands: all that its next step depends on, so that another run can go on with it.
   type :: trace_state_type
      !> It is traced from `stop`; the trace from `start` is done, and branch%ended says why it ended.
      logical :: from_stop = .false.
      !> That one was followed to where it leaves the range.
      logical :: whole = .false.
      !> Points that it has.
      integer :: first_points = 0
      !> Steps done; 0: the trace from this end has not begun.
      integer :: steps = 0
      !> Harmonics in use.
      integer :: harmonics = 0
      !> Length of the next step, and the tracer's measure of curvature.
      real(dp) :: step = 0, bend = 0
      !> Points so far that miss the tolerance.
      integer :: missed = 0
      !> Of Lambda along the branch before it became vertical, if it is: +1 or -1.
      integer :: sense = 0
      type(place_type) :: here, origin
      !> What the reason for its end begins with.
      character(:), allocatable :: before
   end type trace_state_type

   type :: branch_type
      !> states: multipliers of a point, of a train of many states the leading ones.
      integer :: points = 0, meshes = 0, states = 0, harmonics = 0, subharmonic = 1
      !> Lambda, (point).
      real(dp), allocatable :: frequency(:)
      !> (1 + 2*harmonics, mesh, point), see motion_type.
      real(dp), allocatable :: coefficients(:, :, :)
      !> (mesh, point), see motion_type.
      real(dp), allocatable :: rms(:, :), mean(:, :), minimum(:, :), maximum(:, :)
      type(mesh_load_type), allocatable :: mesh_load(:, :)
      !> Half backlash over characteristic length, (mesh).
      real(dp), allocatable :: backlash(:)
      !> (state, point) and (point); not allocated when stability was not asked for.
      complex(dp), allocatable :: multipliers(:, :)
      logical, allocatable :: stable(:)
      !> Where `stable` is a guess, because the largest multiplier is as near to the unit circle as it is uncertain; its magnitude
      !> by a second estimate, negative where none was needed; (point), see geartrain_branch_verdict.
      logical, allocatable :: undecided(:)
      real(dp), allocatable :: second_estimate(:)
      !> Where the number of multipliers outside the unit circle is a guess, (point).
      logical, allocatable :: count_undecided(:)
      !> Relative error of the waveform as estimated, against the motion at the same Lambda or, where the branch turns before it,
      !> that of its fold, (point).
      real(dp), allocatable :: error_estimate(:)
      !> Relative change of the waveform by refine_branch, which is the error that the point had, (point); negative where it was
      !> not refined; not allocated where that was not asked for.
      real(dp), allocatable :: correction(:)
      !> Where that may be off by more than a small factor: a fold as near as it is itself misplaced, a contact that begins or
      !> ends within the error, or an error beyond 0.1, (point).
      logical, allocatable :: estimate_doubtful(:)
      !> Harmonics that each point was solved with, at most `harmonics`, (point).
      integer, allocatable :: point_harmonics(:)
      !> Number of the part that a point belongs to, (point): a new one begins where the branch comes back from beyond the
      !> amplitude limit, and with the points traced from `stop` where those from `start` do not get there.
      integer, allocatable :: part(:)
      type(special_point_type), allocatable :: special_points(:)
      !> Not allocated until locate_contact_edges fills it.
      type(contact_edge_type), allocatable :: contact_edges(:)
      !> Why it ended, in words; complete is .true. where it got to the other end or closed.
      character(:), allocatable :: ended
      logical :: complete = .false., closed = .false.
      !> The observer ended it.
      logical :: cancelled = .false.
      !> Where it comes from, in words; not allocated for the response itself.
      character(:), allocatable :: origin
      !> Allocated while the response is under way.
      type(trace_state_type), allocatable :: trace
   end type branch_type

end module geartrain_branch_branch
