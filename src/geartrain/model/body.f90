!> A body that turns as one, in SI units: a gear, a rotor, a flange.
module geartrain_model_body
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: body_type, name_length

   !> Most characters of a name.
   integer, parameter :: name_length = 64

   type :: body_type
      !> By which shafts and meshes call it.
      character(:), allocatable :: name
      !> Polar moment of inertia [kg m^2]; 0 is allowed where a rigid shaft joins it with others.
      real(dp) :: inertia = 0
      !> Mean torque on it [N m], positive in the sense in which it turns; 0 for the body that balances the others.
      real(dp) :: torque = 0
      !> Harmonics 1.. of the torque [N m], orders of Lambda.
      real(dp), allocatable :: torque_cos(:), torque_sin(:)
      !> Damping of its vibration, which has no mean, against the ground [N m s/rad].
      real(dp) :: damping_to_ground = 0
      !> Its mean torque is such that all of them balance.
      logical :: balances = .false.
   end type body_type

end module geartrain_model_body
