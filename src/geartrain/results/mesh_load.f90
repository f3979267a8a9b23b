!> What the meshes bear, in the group of a branch, of a sweep or of a search for attractors.
module geartrain_results_mesh_load
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use geartrain_base_kinds, only: dp
   use geartrain_motion_mesh_load, only: mesh_load_type
   use geartrain_results_store, only: store_type
   implicit none (type, external)
   private
   public :: write_mesh_loads

contains

   !> Writes the loads (mesh, along) into the group `home`, along the dimension `along`; NaN where `known` is false.
   subroutine write_mesh_loads(store, home, along, loads, known)
      type(store_type), intent(inout) :: store
      character(*), intent(in) :: home, along
      type(mesh_load_type), intent(in) :: loads(:, :)
      logical, intent(in) :: known(:)
      character(6) :: by_mesh(2)
      real(dp) :: values(size(loads, 1), size(loads, 2), 4), nan
      integer :: i

      by_mesh(1) = along
      by_mesh(2) = 'mesh'
      nan = ieee_value(1.0_dp, ieee_quiet_nan)
      values(:, :, 1) = loads%force_maximum
      values(:, :, 2) = loads%dynamic_factor
      values(:, :, 3) = loads%separation
      values(:, :, 4) = loads%back_contact
      where (values(:, :, 2) < 0) values(:, :, 2) = nan
      do i = 1, size(known)
         if (.not. known(i)) values(:, i, :) = nan
      end do
      call store%put(home//'/mesh_force_maximum', values(:, :, 1), by_mesh, 'N', &
                     'largest mesh force over the period, damping included, in the direction of the static force')
      call store%put(home//'/dynamic_factor', values(:, :, 2), by_mesh, '1', &
                     'largest mesh force / static (mean) mesh force; NaN where there is no static force')
      call store%put(home//'/separation_fraction', values(:, :, 3), by_mesh, '1', &
                     'share of the period with the teeth apart, |p| < half_backlash; 0 without backlash')
      call store%put(home//'/back_contact_fraction', values(:, :, 4), by_mesh, '1', &
                     'share of the period with the back flanks in contact, p < -half_backlash; 0 without backlash')
   end subroutine write_mesh_loads

end module geartrain_results_mesh_load
