!> One case: a train and the analyses wanted of it, as one namelist file gives them.
module geartrain_analyses_case
   use geartrain_analyses_stability_map_settings, only: stability_map_settings_type
   use geartrain_continuation_branch, only: response_settings_type
   use geartrain_flow_attractors_settings, only: attractors_settings_type
   use geartrain_flow_integration_settings, only: integration_settings_type
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: case_type

   type :: case_type
      type(train_type) :: train
      !> &modes is present.
      logical :: modes = .false.
      !> Allocated when the group is present.
      type(response_settings_type), allocatable :: response
      type(integration_settings_type), allocatable :: integration
      type(attractors_settings_type), allocatable :: attractors
      type(stability_map_settings_type), allocatable :: stability_map
      !> Name of the output file as given in &output; empty: the case's name with .h5.
      character(:), allocatable :: output_file
   end type case_type

end module geartrain_analyses_case
