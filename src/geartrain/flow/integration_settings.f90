!> The variables of &integration, by which every settling goes.
module geartrain_flow_integration_settings
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: integration_settings_type

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

end module geartrain_flow_integration_settings
