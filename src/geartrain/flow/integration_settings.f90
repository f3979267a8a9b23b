!> The variables of &integration, which every settling uses.
module geartrain_flow_integration_settings
   use geartrain_base_kinds, only: dp
   use geartrain_network_frequency_unit, only: unit_length
   implicit none (type, external)
   private
   public :: integration_settings_type

   type :: integration_settings_type
      !> Range, `from` and `to` in a case file, by default of Lambda; number of frequencies.
      real(dp) :: start = 0, stop = 0
      !> Unit of these frequencies: 'Lambda', 'rpm' or 'Hz'.
      character(unit_length) :: unit = 'Lambda'
      integer :: points = 121
      !> Order in which the frequencies are visited: 'up', 'down' or 'both'.
      character(16) :: direction = 'up'
      !> Number of harmonics of Lambda that are stored; 0: see `stored_harmonics`.
      integer :: harmonics = 0
      !> Mesh periods after which an unsettled motion is abandoned.
      integer :: max_periods = 2000
      !> Window over which the figures are taken [cycles of the slowest mesh]; 0: see geartrain_flow_window.
      integer :: window = 0
      !> Relative change over a period at which a motion counts as settled [1].
      real(dp) :: tolerance = 1e-9_dp
      !> Compute the Floquet multipliers of each settled motion.
      logical :: stability = .false.
   end type integration_settings_type

end module geartrain_flow_integration_settings
