!> A periodic motion as its stability sees it: when each mesh is in which contact.
module geartrain_floquet_motion_contacts
   use geartrain_base_kinds, only: dp
   use geartrain_mesh_law_contact, only: contact_type
   use geartrain_network_long_period, only: long_period
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: motion_contacts_type

   type :: motion_contacts_type
      !> The train.
      type(system_type), pointer :: system => null()
      !> The train is another one from motion to motion.
      logical :: varies = .false.
      !> Sub-harmonic index: theta = Lambda t/eta.
      integer :: eta = 1
      !> How often the motions go through their waveform within the period.
      integer :: repeats = 1
      !> Number of unknown meshes, and their numbers in the train, (unknown).
      integer :: unknowns = 0
      integer, allocatable :: mesh(:)
      !> Contact of each unknown mesh over the period, (unknown).
      type(contact_type), allocatable :: contact(:)
   contains
      procedure :: waves
      procedure :: has_long_period
   end type motion_contacts_type

contains

   !> Period of the motions in periods of the excitation.
   pure integer function waves(self)
      class(motion_contacts_type), intent(in) :: self

      waves = self%eta*(self%system%excitation_order/self%repeats)
   end function waves

   !> Whether the period is so long that nothing should be done for each of its cycles that can be done for fewer.
   pure logical function has_long_period(self)
      class(motion_contacts_type), intent(in) :: self

      has_long_period = self%eta*maxval([1.0_dp, self%system%law%order]) > long_period*self%repeats
   end function has_long_period

end module geartrain_floquet_motion_contacts
