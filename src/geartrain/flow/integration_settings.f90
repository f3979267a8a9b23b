!> The variables of &integration and what a sweep gives.
module geartrain_flow_integration_settings
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: integration_settings_type, sweep_type

   !> from and to are `start` and `stop`.
   type :: integration_settings_type
      real(dp) :: start = 0, stop = 0
      integer :: points = 121
      !> 'up', 'down' or 'both': the order in which the frequencies between from and to are visited.
      character(16) :: direction = 'up'
      !> Harmonics of Lambda that are stored; 0: as many as tell what the motion is made of, 16 of the highest mesh order.
      integer :: harmonics = 0
      !> Mesh periods after which an unsettled motion is given up.
      integer :: max_periods = 2000
      !> Relative change over a period of the motion at which it counts as settled.
      real(dp) :: tolerance = 1e-9_dp
      !> Floquet multipliers of each settled motion.
      logical :: stability = .false.
   end type integration_settings_type

   type :: sweep_type
      !> One motion a frequency visited, in that order; period 0 where none was found.
      type(motion_type), allocatable :: motions(:)
      !> 'up' or 'down', one a motion.
      character(4), allocatable :: direction(:)
      !> 'all points done', or why not; and that the train floats in its gaps, where it does.
      character(:), allocatable :: ended
      logical :: complete = .false.
   end type sweep_type

end module geartrain_flow_integration_settings
