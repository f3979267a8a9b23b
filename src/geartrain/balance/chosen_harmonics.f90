!> How many harmonics a balance may have where their number is left to the program.
module geartrain_balance_chosen_harmonics
   use geartrain_model_excitation, only: excited_harmonics, reach_of_sources
   use geartrain_model_system, only: system_type
   implicit none (type, external)
   private
   public :: fewest_harmonics, first_harmonics, most_harmonics

   !> Of those that the excitation reaches: to begin with and fewest, of Lambda; most, of Lambda/subharmonic.
   integer, parameter :: begin = 6, fewest = 4, most = 384

contains

   !> Harmonics of Lambda/subharmonic to begin with where their number is left to the program.
   pure integer function first_harmonics(system, subharmonic)
      type(system_type), intent(in) :: system
      integer, intent(in) :: subharmonic

      first_harmonics = at_least(begin, system, subharmonic)
   end function first_harmonics

   !> Fewest harmonics of Lambda/subharmonic.
   pure integer function fewest_harmonics(system, subharmonic)
      type(system_type), intent(in) :: system
      integer, intent(in) :: subharmonic

      fewest_harmonics = at_least(fewest, system, subharmonic)
   end function fewest_harmonics

   !> Most harmonics of Lambda/subharmonic.
   pure integer function most_harmonics(system, subharmonic)
      type(system_type), intent(in) :: system
      integer, intent(in) :: subharmonic

      most_harmonics = max(most*apart(system, subharmonic), fewest_harmonics(system, subharmonic))
   end function most_harmonics

   !> `harmonics` of Lambda, of those that the excitation reaches, in harmonics of Lambda/subharmonic; or as many as leave no source
   !> of excitation out, where these are more. Meshes that are no unknowns are excited by what is carried alone.
   pure integer function at_least(harmonics, system, subharmonic)
      integer, intent(in) :: harmonics, subharmonic
      type(system_type), intent(in) :: system

      at_least = max(harmonics*apart(system, subharmonic), reach_of_sources(system))
      if (system%cut%unknowns < system%meshes) at_least = maxval([at_least, excited_harmonics(system)])
      at_least = at_least*subharmonic
   end function at_least

   !> How far apart the harmonics of Lambda/subharmonic are that the excitation reaches.
   pure integer function apart(system, subharmonic)
      type(system_type), intent(in) :: system
      integer, intent(in) :: subharmonic

      apart = merge(system%excitation_order, 1, subharmonic == 1)
   end function apart

end module geartrain_balance_chosen_harmonics
