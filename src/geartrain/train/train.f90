!> A gear train as given, in SI units: bodies joined by shafts and gear pairs; or, without bodies, a chain of M shafts and the M - 1
!> gear pairs between them.
module geartrain_train_train
   use geartrain_base_interrupt, only: interrupt_type
   use geartrain_base_kinds, only: dp
   use geartrain_train_body, only: body_type, name_length
   use geartrain_train_mesh, only: mesh_type
   use geartrain_train_planetary, only: planetary_type
   use geartrain_train_shaft, only: shaft_type
   implicit none (type, external)
   private
   public :: train_type

   type :: train_type
      !> A line of text that is kept with the results.
      character(:), allocatable :: title
      !> Bodies, which the shafts and meshes name by `between`; not allocated for a chain.
      type(body_type), allocatable :: bodies(:)
      !> Of a chain: mean input torque [N m]; the output torque balances it by itself.
      real(dp) :: input_torque = 0
      !> Of a chain: harmonics 1.. of the input torque [N m], orders of Lambda, equation (7c).
      real(dp), allocatable :: torque_cos(:), torque_sin(:)
      !> Of a chain: inertias at the two ends [kg m^2]; 0 is allowed on a rigid shaft.
      real(dp) :: prime_mover_inertia = 0, load_inertia = 0
      !> Unit of mesh displacement, b_c [m], and of frequency, omega_c [rad/s], equation (4); 0: 1 um, and Lambda is the speed in
      !> rpm.
      real(dp) :: characteristic_length = 0, characteristic_frequency = 0
      !> Damping ratios of the modes [1], the last one for all higher modes; empty: damping is that of shafts and meshes.
      real(dp), allocatable :: modal_damping(:)
      !> Name of the body whose revolutions are the speed; blank: the first body, the prime mover of a chain.
      character(name_length) :: speed_of = ''
      !> Derived: revolutions of this body per period of the fundamental [1]; 0: not known.
      real(dp) :: speed_ratio = 0
      type(shaft_type), allocatable :: shafts(:)
      !> Gear pairs, then couplings.
      type(mesh_type), allocatable :: meshes(:)
      !> Planetary sets in short form; not allocated once they are expanded (geartrain_drawing_planetary_expansion).
      type(planetary_type), allocatable :: planetaries(:)
      !> When raised, ends work on this train even within a step; not a variable of a case.
      type(interrupt_type) :: interrupt
   end type train_type

end module geartrain_train_train
