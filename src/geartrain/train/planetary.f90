!> A planetary set in short form, in SI units. It stands for its planets, as bodies, and for their meshes with sun and ring.
module geartrain_train_planetary
   use geartrain_base_kinds, only: dp
   use geartrain_train_body, only: name_length
   implicit none (type, external)
   private
   public :: planetary_type

   type :: planetary_type
      !> Name of the set: its planets are the bodies 'NAME planet 1', ..., its meshes 'NAME sun 1', ..., 'NAME ring 1', ...
      character(:), allocatable :: name
      !> Names of the bodies that are its sun, its ring and its carrier; a sun or a ring that the set lacks is blank.
      character(name_length) :: sun = '', ring = '', carrier = ''
      !> Member that drives the planets, seen from the carrier: 'sun' or 'ring'.
      character(4) :: driving = 'sun'
      !> Numbers of teeth of sun, planet and ring, 0 for a member that the set lacks, (3).
      real(dp), allocatable :: teeth(:)
      !> Number of planets that are equally spaced, 0: not given; else their angles [degree], in the sense in which the sun turns
      !> seen from the carrier, (planet).
      integer :: planets = 0
      real(dp), allocatable :: angles(:)
      !> From the drawing, as of a mesh: normal module [m], normal pressure angle and helix angle [degree], face width [m], profile
      !> shifts of sun, planet and ring [1], (3), centre distance [m], tip diameters [m], (3), dedendum of the rack [1].
      real(dp) :: normal_module = 0, pressure_angle = 20, helix_angle = 0, face_width = 0, centre_distance = 0, dedendum = 1.25_dp
      real(dp), allocatable :: profile_shift(:), tip_diameter(:)
      !> Face width of the ring meshes, 0: `face_width` [m]; moduli of elasticity of sun, planet and ring [N/m^2], (3).
      real(dp) :: ring_face_width = 0
      real(dp), allocatable :: elastic_modulus(:)
      !> Errors of the places of the planets along the lines of action of both their meshes, positive against the force of the
      !> driving member, (planet) [m].
      real(dp), allocatable :: planet_errors(:)
      !> Of a planet: inertia [kg m^2] and mass [kg], negative: by the drawing; bore [m] and density [kg/m^3] of the disc.
      real(dp) :: planet_inertia = -1, planet_mass = -1, planet_bore = 0, density = 7850
      !> Of sun meshes and ring meshes, one value for both, (1 or 2): circumferential backlash [m], half of the backlash along the
      !> line of action [m], mean stiffness [N/m], damping ratio [1], damping [N s/m], loss factor [1], contact ratio [1].
      real(dp), allocatable :: backlash(:), half_backlash(:), stiffness(:), damping_ratio(:), damping(:), loss_factor(:), &
         contact_ratio(:)
      !> 'always' or 'contact', as of a mesh.
      character(8) :: damping_acts = 'always'
      !> Harmonics of kappa [1] and of the transmission error [m], as of a mesh.
      real(dp), allocatable :: sun_stiffness_cos(:), sun_stiffness_sin(:), ring_stiffness_cos(:), ring_stiffness_sin(:)
      real(dp), allocatable :: sun_error_cos(:), sun_error_sin(:), ring_error_cos(:), ring_error_sin(:)
      !> Harmonics that are taken of the rectangular wave of the stiffness.
      integer :: stiffness_harmonics = 5
      !> Lag of each ring mesh behind the sun mesh of its planet [rad of the mesh cycle], in force when `ring_phase_given`.
      real(dp) :: ring_phase = 0
      logical :: ring_phase_given = .false.
      !> Mesh frequency as a multiple of the fundamental, as of a mesh.
      integer :: order = 0
   end type planetary_type

end module geartrain_train_planetary
