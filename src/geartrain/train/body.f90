!> A body that turns as one, in SI units: a gear, a rotor, a flange.
module geartrain_train_body
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: body_type, name_length

   !> Most characters of a name.
   integer, parameter :: name_length = 64

   type :: body_type
      !> Name by which shafts and meshes refer to the body.
      character(:), allocatable :: name
      !> Polar moment of inertia [kg m^2]; 0 is allowed where a rigid shaft joins it with others; negative: by the drawing.
      real(dp) :: inertia = -1
      !> Inertia [kg m^2] that adds to `inertia` or to that of the drawing: of masses that the body carries, as a carrier its
      !> planets.
      real(dp) :: added_inertia = 0
      !> From the drawing: discs whose inertias are added, diameters and widths [m] and densities [kg/m^3]; one bore or density
      !> holds for all discs.
      real(dp), allocatable :: outer_diameter(:), bore(:), width(:), density(:)
      !> Mean torque on the body [N m], positive in its sense of rotation; 0 for the body that balances the others.
      real(dp) :: torque = 0
      !> Amplitudes of the torque at the harmonics 1, 2, ... of Lambda [N m], (harmonic).
      real(dp), allocatable :: torque_cos(:), torque_sin(:)
      !> Amplitudes of the torque at the harmonics 1, 2, ... of the revolution of the body [N m], (harmonic).
      real(dp), allocatable :: revolution_torque_cos(:), revolution_torque_sin(:)
      !> Derived: revolution of the body as a multiple of the fundamental, where it has such a torque.
      integer :: revolution_order = 1
      !> Damping to ground of the vibration of the body [N m s/rad]; none of its mean rotation.
      real(dp) :: damping_to_ground = 0
      !> Stiffness to ground [N m/rad].
      real(dp) :: stiffness_to_ground = 0
      !> The body stands still.
      logical :: held = .false.
      !> Mean speed over that of the body whose revolutions are the speed [1], signed in one sense of all; in force when
      !> `ratio_given`, where the gears alone do not determine all speeds.
      real(dp) :: speed_ratio = 0
      logical :: ratio_given = .false.
      !> Position of the axis in the transverse plane, x and y [m]; empty: not given.
      real(dp), allocatable :: position(:)
      !> The mean torque of the body balances the mean torques of all others.
      logical :: balances = .false.
   end type body_type

end module geartrain_train_body
