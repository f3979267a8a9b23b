!> A gear pair in SI units.
module geartrain_model_mesh
   use geartrain_base_kinds, only: dp
   use geartrain_model_body, only: name_length
   implicit none (type, external)
   private
   public :: mesh_type

   type :: mesh_type
      !> Names of the bodies that the gears are on, that of the driving one first; blank in a chain.
      character(name_length) :: between(2) = ''
      !> The pair is an internal one: both gears turn in one sense.
      logical :: internal = .false.
      !> Base circle radii [m].
      real(dp) :: driving_radius = 0, driven_radius = 0
      !> Of a chain: polar moments of inertia of the gears [kg m^2].
      real(dp) :: driving_inertia = 0, driven_inertia = 0
      !> Mean mesh stiffness [N/m].
      real(dp) :: stiffness = 0
      !> Damping ratio [1], c/(2 sqrt(k m_eq)), m_eq = I_a I_b/(r_a^2 I_b + r_b^2 I_a); or `damping`.
      real(dp) :: damping_ratio = 0
      !> Damping coefficient [N s/m], in force when `damping_given`.
      real(dp) :: damping = 0
      logical :: damping_given = .false.
      !> Half of the backlash [m]; 0 makes the mesh linear.
      real(dp) :: half_backlash = 0
      !> Harmonics 1..K of kappa(t) = 1 + ... [1], equation (7a); empty where there are none.
      real(dp), allocatable :: stiffness_cos(:), stiffness_sin(:)
      !> Harmonics 1.. of the static transmission error [m], equation (7b); it adds to the mesh displacement.
      real(dp), allocatable :: error_cos(:), error_sin(:)
      !> Mesh frequency as a multiple of the fundamental, m_n [1].
      integer :: order = 1
   end type mesh_type

end module geartrain_model_mesh
