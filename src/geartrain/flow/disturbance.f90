!> A small disturbance of a state. Without one a flow that begins on an unstable orbit, or on the symmetric motions of a symmetric
!> train, stays there, which no machine does.
module geartrain_flow_disturbance
   use geartrain_base_kinds, only: dp
   use geartrain_network_system, only: system_type
   use geartrain_network_units, only: units_of, units_type
   implicit none (type, external)
   private
   public :: disturb

   !> Largest part of the disturbance over the unit of displacement or velocity of the train [1]: small beside a motion, and large
   !> beside the tolerance of a settled one, so that an orbit with a multiplier of 1.02 is left in some hundred periods.
   real(dp), parameter :: share = 1e-4_dp
   !> The golden section: its multiples, less whole numbers, are all different, so that no symmetry of a train keeps them.
   real(dp), parameter :: golden = 0.6180339887498949_dp

contains

   !> Moves a state by a small amount, another one in each coordinate.
   pure subroutine disturb(system, state)
      type(system_type), intent(in) :: system
      !> State [1], (state).
      real(dp), intent(inout) :: state(:)
      type(units_type) :: units
      real(dp) :: unit
      integer :: i

      units = units_of(system)
      do i = 1, size(state)
         unit = units%length
         if (i > system%displacements) unit = units%length*units%frequency_ratio
         state(i) = state(i) + share*unit*(2*modulo(i*golden, 1.0_dp) - 1)
      end do
   end subroutine disturb

end module geartrain_flow_disturbance
