!> The variables of &stability_map and what a stability map (stability chart, of a linear train an Ince-Strutt diagram) gives.
module geartrain_branch_stability_map_settings
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: stability_map_settings_type, stability_map_type

   !> from, to, parameter_from and parameter_to are `start`, `stop`, `parameter_start` and `parameter_stop`.
   type :: stability_map_settings_type
      !> Range of Lambda and how many there are in it, both ends included.
      real(dp) :: start = 0, stop = 0
      integer :: points = 200
      !> What varies from row to row: 'stiffness_variation', 'mesh_damping_ratio', 'input_torque' or 'half_backlash'.
      character(24) :: parameter = 'stiffness_variation'
      real(dp) :: parameter_start = 0, parameter_stop = 0
      integer :: parameter_points = 200
      !> The train without backlash, all teeth in contact.
      logical :: linear = .false.
      !> Of the branch of each row, as in &response.
      integer :: harmonics = 6
   end type stability_map_settings_type

   !> The grid over Lambda (first index) and the parameter (second).
   type :: stability_map_type
      !> 'stiffness_variation', ..., and its unit.
      character(:), allocatable :: name, unit
      logical :: linear = .false.
      !> Lambda, (point); values of the parameter, (row).
      real(dp), allocatable :: frequency(:), parameter(:)
      !> Motions of the mesh period and how many of them are stable, (point, row); -1 where not done yet.
      integer, allocatable :: motions(:, :), stable_motions(:, :)
      !> Floquet multiplier of largest magnitude of the motion that has it smallest, (point, row); NaN where there is no motion.
      complex(dp), allocatable :: multiplier(:, :)
      !> Largest rms of the stable motions, see motion_type, (mesh, point, row); NaN where there is none. Not of the linear train.
      real(dp), allocatable :: rms(:, :, :)
      !> Rows done, and among them those whose branch got from one end to the other, (row).
      logical, allocatable :: done(:), whole(:)
      !> 'all rows done', or what is missing.
      character(:), allocatable :: ended
      logical :: complete = .false.
   end type stability_map_type

end module geartrain_branch_stability_map_settings
