!> What loops do to the elements of a network: they stiffen soft elements, and lock where ratios do not agree.
module geartrain_model_network_loops
   use geartrain_base_kinds, only: dp
   use geartrain_model_network, only: network_type
   implicit none (type, external)
   private
   public :: locks, stiffening

   !> Largest difference from 1 of the product of the ratios round a loop [1].
   real(dp), parameter :: rounding = 1e-9_dp

contains

   !> Factor >= 1 by which loops stiffen each element, (element): a soft element beside stiff elements follows their motion.
   pure function stiffening(network) result(factor)
      !> Network from `build_network`.
      type(network_type), intent(in) :: network
      real(dp) :: factor(size(network%elements)), share(size(network%elements)), others
      integer :: i, m, n

      factor = 1
      do i = 1, size(network%loop, 1)
         if (network%elements(network%coordinates + i)%grounded) cycle
         share = 0
         share(:network%coordinates) = -network%loop(i, :)
         share(network%coordinates + i) = 1
         do n = 1, size(share)
            if (.not. abs(share(n)) > 0) cycle
            ! Compliance of the other elements of the loop over the compliance of this element.
            others = sum(share**2*(network%elements(n)%stiffness/network%elements%stiffness), [(m, m=1, size(share))] /= n)
            factor(n) = max(factor(n), 1 + share(n)**2/max(others, tiny(others)))
         end do
      end do
   end function stiffening

   !> Whether the ratios round a loop do not multiply to 1: its gears lock.
   pure logical function locks(network)
      !> Network from `build_network`.
      type(network_type), intent(in) :: network
      integer :: n

      locks = .false.
      do n = network%displacements + 1, size(network%elements)
         associate (element => network%elements(n), radius => network%radius)
            if (element%grounded) cycle
            locks = locks .or. abs(element%radius(1)*radius(element%to)/(element%radius(2)*radius(element%from)) - 1) > rounding
         end associate
      end do
   end function locks

end module geartrain_model_network_loops
