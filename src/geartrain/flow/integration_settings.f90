!> The variables of &integration, which every settling uses.
module geartrain_flow_integration_settings
   use geartrain_base_kinds, only: dp
   use geartrain_network_excitation, only: highest_order
   use geartrain_network_frequency_unit, only: unit_length
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: integration_settings_type, most_periods

   !> Periods after which an unsettled motion is given up: many, or where they are long as many as these cycles of the fastest mesh,
   !> but some. Each cycle costs the same, and slow modes settle in fewer (geartrain_flow_settling).
   integer, parameter :: many = 2000, some = 100
   real(dp), parameter :: most_cycles = 40000

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
      !> Periods of the fundamental after which an unsettled motion is given up; 0: see `most_periods`.
      integer :: max_periods = 0
      !> Window over which the figures are taken [cycles of the slowest mesh]; 0: see geartrain_flow_window.
      integer :: window = 0
      !> Relative change over a period at which a motion counts as settled [1].
      real(dp) :: tolerance = 1e-9_dp
      !> Compute the Floquet multipliers of each settled motion.
      logical :: stability = .false.
   end type integration_settings_type

contains

   !> Periods of the fundamental after which an unsettled motion is given up.
   pure integer function most_periods(system, asked)
      type(system_type), intent(in) :: system
      !> As asked for; 0: chosen by the length of a period.
      integer, intent(in) :: asked

      most_periods = asked
      if (asked == 0) most_periods = max(some, min(many, nint(most_cycles/highest_order(system))))
   end function most_periods

end module geartrain_flow_integration_settings
