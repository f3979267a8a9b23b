!> A periodic motion as its stability sees it: when each mesh is in which contact.
module geartrain_floquet_motion_contacts
   use geartrain_mesh_law_contact, only: contact_type
   use geartrain_model_system, only: system_type
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
      !> Number of unknown meshes, and their numbers in the train, (unknown).
      integer :: unknowns = 0
      integer, allocatable :: mesh(:)
      !> Contact of each unknown mesh over the period, (unknown).
      type(contact_type), allocatable :: contact(:)
   end type motion_contacts_type

end module geartrain_floquet_motion_contacts
