!> Units in which a branch measures its way: the powers of ten nearest to what the train itself moves by and vibrates at. Steps,
!> tolerances and guards then do not depend on the characteristic values that a train is given, nor on how large it is.
module geartrain_continuation_units
   use geartrain_base_kinds, only: dp
   use geartrain_model_network, only: stiffening
   use geartrain_model_system, only: system_type
   implicit none (type, external)
   private
   public :: units_type, units_of, largest_unit

   !> A train that rattles under a small load moves by a few times its deflection and does not reach the other flank.
   real(dp), parameter :: rattle = 5

   type :: units_type
      !> Of mesh displacement over characteristic length, and of Lambda; both 1 where the characteristic values fit the train.
      real(dp) :: length = 1, frequency_ratio = 1
   end type units_type

contains

   pure type(units_type) function units_of(system) result(units)
      type(system_type), intent(in) :: system
      real(dp) :: drive, gap, stiff(system%elements)

      drive = max(largest_load(system), largest_error(system))
      gap = maxval(system%half_backlash)
      if (drive > 0) gap = min(gap, rattle*drive)
      units%length = decade(max(drive, gap))
      stiff = stiffening(system%network)
      units%frequency_ratio = decade(sqrt(minval(system%own(system%mesh_element)*stiff(system%mesh_element))))
   end function units_of

   !> Unit of length of motions that cross the gap, which amplitude limits are multiples of.
   pure real(dp) function largest_unit(system)
      type(system_type), intent(in) :: system

      largest_unit = decade(max(largest_load(system), maxval(system%half_backlash)))
   end function largest_unit

   !> Deflection under the mean load.
   pure real(dp) function largest_load(system)
      type(system_type), intent(in) :: system

      largest_load = maxval(abs(system%static_force(system%mesh_element)))
   end function largest_load

   !> Bound of the transmission errors.
   pure real(dp) function largest_error(system)
      type(system_type), intent(in) :: system
      integer :: j

      largest_error = 0
      do j = 1, system%meshes
         largest_error = max(largest_error, sum(abs(system%transmission_error(j)%amplitude)))
      end do
   end function largest_error

   !> The nearest power of ten; 1 for 0.
   pure real(dp) function decade(x)
      real(dp), intent(in) :: x

      decade = 1
      if (x > 0) decade = 10.0_dp**nint(log10(x))
   end function decade

end module geartrain_continuation_units
