!> The variables of &attractors and what a search for attractors gives.
module geartrain_flow_attractors_settings
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: attractors_settings_type, attractors_type

   type :: attractors_settings_type
      !> Lambda [1].
      real(dp) :: frequency_ratio = 0
      !> Random starts, and what makes them: the same seed gives the same starts.
      integer :: starts = 200, random_seed = 0
      !> Each motion found on no branch of the case is followed with the settings of &response.
      logical :: follow = .false.
      !> As in &integration.
      integer :: harmonics = 0, max_periods = 2000
      real(dp) :: tolerance = 1e-9_dp
      logical :: stability = .true.
   end type attractors_settings_type

   type :: attractors_type
      !> The motions found, each with its share, largest share first.
      type(motion_type), allocatable :: motions(:)
      real(dp) :: frequency_ratio = 0
      !> Starts done.
      integer :: starts = 0, random_seed = 0
      !> Share of the starts that were not steady after max_periods, or ran away; with the shares of the motions it sums to 1.
      real(dp) :: unsettled = 0
      !> 'all starts done', or why not; and that the train floats in its gaps, where it does.
      character(:), allocatable :: ended
      logical :: complete = .false.
   end type attractors_type

end module geartrain_flow_attractors_settings
