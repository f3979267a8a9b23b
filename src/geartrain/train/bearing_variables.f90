!> The table of input variables of bearings.
module geartrain_train_bearing_variables
   use geartrain_base_kinds, only: dp
   use geartrain_base_variable, only: row => variable_type, visitor_type
   use geartrain_train_mesh, only: mesh_type
   implicit none (type, external)
   private
   public :: visit_bearing

   real(dp), parameter :: zero = 0, one = 1

contains

   !> Visits the variables of a group &bearing.
   subroutine visit_bearing(bearing, index, v)
      !> The directions x and y; the visitor may change them.
      type(mesh_type), intent(inout) :: bearing(2)
      !> Number of the bearing in the train.
      integer, intent(in) :: index
      !> Reads, checks, sets or lists each variable.
      class(visitor_type), intent(inout) :: v
      character(:), allocatable :: word
      real(dp), allocatable :: list(:)

      call v%enter('bearing', index)
      word = trim(bearing(1)%between(1))
      call v%on_text(row('body', '', 'name of the body, which the bearing lets move in its transverse plane', required=.true.), &
                     word)
      bearing(1)%between = word
      call v%on_real(row('mass', 'kg', 'mass of the body with what moves with it', required=.true., above=zero), bearing(1)%mass)
      if (any(abs(bearing%stiffness) > 0)) list = bearing%stiffness
      call v%on_list(row('stiffness', 'N/m', 'stiffnesses in the directions x and y, of all bearings of the body together', &
                         above=zero, values=2), list)
      call put(list, bearing%stiffness, bearing(1)%stiffness, bearing(2)%stiffness)
      if (allocated(list)) deallocate (list)
      if (any(abs(bearing%damping) > 0)) list = bearing%damping
      call v%on_list(row('damping', 'N s/m', 'damping coefficients in the directions x and y, within the clearance as well; none: &
                         &0', least=zero, values=2), list)
      call put(list, bearing%damping, bearing(1)%damping, bearing(2)%damping)
      call v%on_real(row('half_clearance', 'm', 'half of the clearance in each direction; 0: none', least=zero), &
                     bearing(1)%half_backlash)
      call v%on_integer(row('flats', '', 'flats of the clearance, 4, 8, 12, 16 or 24; above 4, of equal stiffness and damping in x &
                            &and y, the clearance is nearly round', least=4*one, most=24*one), bearing(1)%flats)
      bearing(2)%between = bearing(1)%between
      bearing(2)%mass = bearing(1)%mass
      bearing(2)%half_backlash = bearing(1)%half_backlash
      bearing(2)%flats = bearing(1)%flats
      call v%leave()
   end subroutine visit_bearing

   !> Puts a list of two values, where it is given, in place of the values before.
   pure subroutine put(list, before, x, y)
      real(dp), allocatable, intent(in) :: list(:)
      real(dp), intent(in) :: before(2)
      real(dp), intent(out) :: x, y

      x = before(1)
      y = before(2)
      if (.not. allocated(list)) return
      if (size(list) /= 2) return
      x = list(1)
      y = list(2)
   end subroutine put

end module geartrain_train_bearing_variables
