!> The force of a mesh whose stiffness is known at several loads: at each instant of the cycle a polygon over the displacement. All
!> instants have their corners at equal displacements, the mean deflections under the loads, so that the walls of the law stand
!> still; between them the force is proportional to a stiffness that varies over the cycle.
module geartrain_mesh_law_loaded_contact
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: falling_instant, find_stages

contains

   !> Computes walls and stiffnesses of the stages.
   pure subroutine find_stages(load, table, wall, stiffness, error)
      !> Loads [N], ascending, (load); stiffness (load over deflection) at the instants of a cycle [N/m], those of a load side by
      !> side.
      real(dp), intent(in) :: load(:), table(:)
      !> Deflections between the stages [m], (stage - 1); stiffness of the stages, change of force over change of deflection [N/m],
      !> (instant, stage).
      real(dp), allocatable, intent(out) :: wall(:), stiffness(:, :)
      !> Largest difference between the force of the polygon and a load at the deflection of the table, over the load [1].
      real(dp), intent(out) :: error
      real(dp) :: given(size(table)/size(load), size(load)), deflection(size(table)/size(load), size(load)), corner(0:size(load)), &
                  force(0:size(load))
      integer :: i, l, n

      n = size(load)
      given = reshape(table, shape(given))
      do l = 1, n
         deflection(:, l) = load(l)/given(:, l)
      end do
      corner(0) = 0
      corner(1:) = sum(deflection, 1)/size(deflection, 1)
      allocate (stiffness(size(deflection, 1), n))
      error = 0
      do i = 1, size(deflection, 1)
         force(0) = 0
         do l = 1, n
            force(l) = force_at(load, deflection(i, :), corner(l))
         end do
         stiffness(i, :) = (force(1:) - force(:n - 1))/(corner(1:) - corner(:n - 1))
         do l = 1, n
            error = max(error, abs(polygon(deflection(i, l), corner, stiffness(i, :)) - load(l))/load(l))
         end do
      end do
      wall = corner(1:n - 1)
   end subroutine find_stages

   !> Force at a deflection by the loads and deflections of an instant: proportional up to the first load, then a power of the
   !> deflection from load to load, which the contact of Hertz is throughout.
   pure real(dp) function force_at(load, deflection, x)
      real(dp), intent(in) :: load(:), deflection(:), x
      integer :: l

      if (x <= deflection(1) .or. size(load) == 1) then
         force_at = load(1)*x/deflection(1)
         return
      end if
      l = min(count(deflection < x), size(load) - 1)
      force_at = load(l)*(x/deflection(l))**(log(load(l + 1)/load(l))/log(deflection(l + 1)/deflection(l)))
   end function force_at

   !> Force of the polygon at a deflection.
   pure real(dp) function polygon(x, corner, stiffness)
      real(dp), intent(in) :: x, corner(0:), stiffness(:)
      integer :: l

      polygon = 0
      do l = 1, size(stiffness)
         polygon = polygon + stiffness(l)*(merge(x, min(x, corner(l)), l == size(stiffness)) - min(x, corner(l - 1)))
      end do
   end function polygon

   !> First instant at which the stiffness between two loads is not 0.01 to 100 times that under the larger one; 0: none. A step of
   !> the flow follows the stiffest stage.
   pure integer function falling_instant(load, table) result(instant)
      !> Loads [N], ascending, (load); stiffness at the instants [N/m], those of a load side by side.
      real(dp), intent(in) :: load(:), table(:)
      real(dp) :: change
      integer :: l, n

      n = size(table)/size(load)
      do instant = 1, n
         do l = 2, size(load)
            change = (load(l)/table((l - 1)*n + instant) - load(l - 1)/table((l - 2)*n + instant)) &
                     *table((l - 1)*n + instant)/(load(l) - load(l - 1))
            if (.not. (change >= 0.01_dp .and. change <= 100)) return
         end do
      end do
      instant = 0
   end function falling_instant

end module geartrain_mesh_law_loaded_contact
