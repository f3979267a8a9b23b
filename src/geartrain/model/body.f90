!> The free linear body between two meshes: two inertias on a flexible shaft, or one on a rigid shaft.
!> Shafts are condensed into its receptance, so that mesh displacements are the only unknowns of the balance.
module geartrain_model_body
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: body_type

   type :: body_type
      logical :: rigid = .false.
      !> Inertias at the left and right end [kg m^2]; a rigid body has their sum in both.
      real(dp) :: left_inertia = 0, right_inertia = 0
      !> Torsional stiffness [N m/rad] and damping [N m s/rad] of the shaft between them.
      real(dp) :: stiffness = 0, damping = 0
   contains
      procedure :: receptance
      procedure :: twist
   end type body_type

contains

   !> Angles per torque [rad/(N m)] at the angular frequency omega [rad/s], and their derivative with respect to omega:
   !> ends (left, left), (left, right) = (right, left), (right, right).
   pure subroutine receptance(self, omega, alpha, d_alpha)
      class(body_type), intent(in) :: self
      real(dp), intent(in) :: omega
      complex(dp), intent(out) :: alpha(3), d_alpha(3)
      complex(dp) :: spring, d_spring, inverse, d_denominator, numerator(3), d_numerator(3)
      real(dp) :: both, product

      if (self%rigid) then
         alpha = -1/(omega**2*self%left_inertia)
         d_alpha = -2*alpha/omega
         return
      end if
      spring = cmplx(self%stiffness, omega*self%damping, dp)
      d_spring = cmplx(0, self%damping, dp)
      both = self%left_inertia + self%right_inertia
      product = self%left_inertia*self%right_inertia
      inverse = 1/(omega**2*(omega**2*product - spring*both))
      d_denominator = 4*omega**3*product - 2*omega*spring*both - omega**2*d_spring*both
      numerator = [spring - omega**2*self%right_inertia, spring, spring - omega**2*self%left_inertia]
      d_numerator = [d_spring - 2*omega*self%right_inertia, d_spring, d_spring - 2*omega*self%left_inertia]
      alpha = numerator*inverse
      d_alpha = (d_numerator - alpha*d_denominator)*inverse
   end subroutine receptance

   !> Complex amplitude of the twist left - right [rad] under harmonic torques on its ends [N m], omega > 0.
   pure complex(dp) function twist(self, omega, left_torque, right_torque)
      class(body_type), intent(in) :: self
      real(dp), intent(in) :: omega
      complex(dp), intent(in) :: left_torque, right_torque

      twist = (self%left_inertia*right_torque - self%right_inertia*left_torque) &
              /(omega**2*self%left_inertia*self%right_inertia &
                - cmplx(self%stiffness, omega*self%damping, dp)*(self%left_inertia + self%right_inertia))
   end function twist

end module geartrain_model_body
