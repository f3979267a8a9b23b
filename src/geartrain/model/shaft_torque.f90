!> Torques of elastic shafts: stiffness times twist and damping times twist rate, the static torque included.
module geartrain_model_shaft_torque
   use geartrain_base_kinds, only: dp
   use geartrain_model_system, only: system_type
   implicit none (type, external)
   private
   public :: dynamic_torque, static_torque

contains

   !> Torque of a shaft at rest [N m], positive where the first body of the shaft drives.
   pure real(dp) function static_torque(system, element)
      !> The train.
      type(system_type), intent(in) :: system
      !> Element of the shaft, `element_shaft` of which is not 0.
      integer, intent(in) :: element

      static_torque = torque_unit(system, element)*system%static_force(element)
   end function static_torque

   !> Torque of a shaft less its torque at rest [N m]; of Taylor coefficients the Taylor coefficients.
   pure elemental real(dp) function dynamic_torque(system, element, displacement, velocity)
      !> The train.
      type(system_type), intent(in) :: system
      !> Element of the shaft, `element_shaft` of which is not 0.
      integer, intent(in) :: element
      !> Displacement of the element less its displacement at rest, as in a state, over b_c [1]; its derivative by time [1].
      real(dp), intent(in) :: displacement, velocity

      dynamic_torque = torque_unit(system, element)*(displacement + system%damping(element)*velocity)
   end function dynamic_torque

   !> Torque of a shaft per dimensionless force phi [N m].
   pure real(dp) function torque_unit(system, element)
      type(system_type), intent(in) :: system
      integer, intent(in) :: element

      torque_unit = system%stiffness(element)*system%characteristic_length*system%network%elements(element)%radius(1)
   end function torque_unit

end module geartrain_model_shaft_torque
