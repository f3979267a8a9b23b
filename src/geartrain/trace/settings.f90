!> What the trace of a branch is asked for.
module geartrain_trace_settings
   use geartrain_base_kinds, only: dp
   use geartrain_network_frequency_unit, only: unit_length
   use geartrain_network_parameter_table, only: settings_length
   implicit none (type, external)
   private
   public :: response_settings_type

   !> The variables of &response; from and to are `start` and `stop`.
   type :: response_settings_type
      !> First and last end of the range, by default of Lambda.
      real(dp) :: start = 0, stop = 0
      !> Unit of frequencies: 'Lambda', 'rpm' or 'Hz'.
      character(unit_length) :: unit = 'Lambda'
      !> Name of a parameter of the train: the range is one of its values, at the constant `frequency`; blank: of frequencies.
      character(settings_length) :: parameter = ''
      real(dp) :: frequency = 0
      !> Harmonics of Lambda/subharmonic; 0 lets the program choose for `tolerance`.
      integer :: harmonics = 6
      !> Period of the motions in periods of the fundamental.
      integer :: subharmonic = 1
      !> How often the motions go through their waveform within the period, a divisor of `excitation_order` of the train; 0: as
      !> often as a motion that is given, else as the excitation where subharmonic is 1, else once. No variable of &response.
      integer :: repeats = 0
      !> Whether the torque of every shaft is computed at each point.
      logical :: shaft_torque = .true.
      !> Whether stability is computed at each point; whether by multipliers even where the period is long.
      logical :: stability = .true., multipliers = .false.
      !> Largest rms over characteristic length; negative: 12 with backlash, none for a linear train.
      real(dp) :: amplitude_limit = -1
      !> 'exact' or 'sampled' (the paper's DFT, with `samples` points a period; 0: chosen).
      character(16) :: coefficients = 'exact'
      integer :: samples = 0
      !> 'arclength' or 'local' (the paper's switching of the control parameter, equation (11)).
      character(16) :: control = 'arclength'
      !> Relative error of the waveform aimed at where harmonics = 0.
      real(dp) :: tolerance = 1e-4_dp
      !> Largest step along the branch [1], in Lambda and mesh displacement together.
      real(dp) :: step = 0.2_dp
      !> Points after which the trace ends.
      integer :: max_points = 20000
      !> Generations of period-doubled branches that are followed, see follow_bifurcations.
      integer :: period_doublings = 0
      !> Whether the branches that cross at branch points are followed, see follow_bifurcations.
      logical :: branch_points = .false.
      !> Whether shooting refines the points, see refine_branch.
      logical :: refine = .false.
   end type response_settings_type

end module geartrain_trace_settings
