!> How many harmonics a balance begins with, and has at least and at most, where the program chooses their number (harmonics = 0).
module geartrain_balance_chosen_harmonics
   use geartrain_network_excitation, only: excited_harmonics, reach_of_sources
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: fewest_harmonics, first_harmonics, most_harmonics

   !> Counted are harmonics that the excitation reaches: `begin` and `fewest` of Lambda, `most` of Lambda/subharmonic.
   integer, parameter :: begin = 6, fewest = 4, most = 384

contains

   !> Harmonics of Lambda/subharmonic to begin with.
   pure integer function first_harmonics(system, subharmonic, repeats)
      type(system_type), intent(in) :: system
      !> Sub-harmonic index, period over period of the fundamental; how often the motions go through their waveform within it.
      integer, intent(in) :: subharmonic, repeats

      first_harmonics = at_least(begin, system, subharmonic, repeats)
   end function first_harmonics

   !> Fewest harmonics of Lambda/subharmonic.
   pure integer function fewest_harmonics(system, subharmonic, repeats)
      type(system_type), intent(in) :: system
      !> Sub-harmonic index, period over period of the fundamental; how often the motions go through their waveform within it.
      integer, intent(in) :: subharmonic, repeats

      fewest_harmonics = at_least(fewest, system, subharmonic, repeats)
   end function fewest_harmonics

   !> Most harmonics of Lambda/subharmonic.
   pure integer function most_harmonics(system, subharmonic, repeats)
      type(system_type), intent(in) :: system
      !> Sub-harmonic index, period over period of the fundamental; how often the motions go through their waveform within it.
      integer, intent(in) :: subharmonic, repeats

      most_harmonics = max(most*repeats, fewest_harmonics(system, subharmonic, repeats))
   end function most_harmonics

   !> Harmonics of Lambda/subharmonic that hold `harmonics` harmonics of Lambda reached by the excitation, and the lowest harmonic
   !> of every source of excitation; all harmonics of every source where some meshes are no unknowns, because a linear mesh moves
   !> at the carried harmonics only.
   pure integer function at_least(harmonics, system, subharmonic, repeats)
      integer, intent(in) :: harmonics, subharmonic, repeats
      type(system_type), intent(in) :: system

      at_least = max(harmonics*repeats, reach_of_sources(system))
      if (system%cut%unknowns < system%meshes) at_least = maxval([at_least, excited_harmonics(system)])
      at_least = at_least*subharmonic
   end function at_least

end module geartrain_balance_chosen_harmonics
