!> Contacts over the period of a motion whose balance has those of a winding: for what follows the motion in time.
module geartrain_balance_whole_contacts
   use geartrain_balance_balance, only: balance_type
   use geartrain_base_kinds, only: dp
   use geartrain_floquet_motion_contacts, only: motion_contacts_type
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: fine_samples, own_resolution
   use geartrain_mesh_law_contact, only: most_polished
   implicit none (type, external)
   private
   public :: find_whole_contacts

contains

   !> Finds the contact events of the motion, without spectra.
   subroutine find_whole_contacts(balance, u, transform, motion)
      !> The balance, evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> Coefficients of the unknown meshes [1], (block, unknown).
      real(dp), intent(in) :: u(:, :)
      !> Work space.
      type(transform_type), intent(inout) :: transform
      !> The contacts.
      type(motion_contacts_type), intent(inout) :: motion
      integer :: i, highest

      motion%system => balance%system
      motion%eta = balance%eta
      motion%repeats = balance%repeats
      motion%unknowns = balance%unknowns
      motion%mesh = balance%mesh
      if (allocated(motion%contact)) then
         if (size(motion%contact) /= balance%unknowns) deallocate (motion%contact)
      end if
      if (.not. allocated(motion%contact)) allocate (motion%contact(balance%unknowns))
      do i = 1, balance%unknowns
         call motion%contact(i)%setup(balance%system%law(balance%mesh(i)), balance%eta, balance%harmonic, 0, 0)
         ! Crossings are polished: samples only have to show them.
         highest = maxval([1, balance%harmonic])
         if (size(balance%harmonic) <= most_polished) highest = min(highest, own_resolution(u(:, i), balance%harmonic))
         call transform%plan(fine_samples(highest))
         call motion%contact(i)%update(u(:, i), transform, events_only=.true.)
      end do
   end subroutine find_whole_contacts

end module geartrain_balance_whole_contacts
