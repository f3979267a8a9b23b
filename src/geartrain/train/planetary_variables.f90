!> The table of input variables of a planetary set.
module geartrain_train_planetary_variables
   use geartrain_base_kinds, only: dp
   use geartrain_base_variable, only: row => variable_type, visitor_type
   use geartrain_train_mesh, only: most_order
   use geartrain_train_planetary, only: planetary_type
   implicit none (type, external)
   private
   public :: visit_planetary

   real(dp), parameter :: zero = 0, one = 1

contains

   !> Visits the variables of a group &planetary.
   subroutine visit_planetary(set, index, v)
      !> The planetary set; the visitor may change it.
      type(planetary_type), intent(inout) :: set
      !> Number of the set in the train.
      integer, intent(in) :: index
      !> Reads, checks, sets or lists each variable.
      class(visitor_type), intent(inout) :: v

      call v%enter('planetary', index)
      call v%on_text(row('name', '', "name of the set: its planets are the bodies 'NAME planet 1', ..., its meshes are named &
                         &'NAME sun 1', ..., 'NAME ring 1', ...", required=.true.), set%name)
      call on_body('sun', 'body that is the sun; none: no sun', set%sun)
      call on_body('ring', 'body that is the ring; none: no ring', set%ring)
      call on_body('carrier', 'body on which the planets ride', set%carrier)
      call visit_gears(set, v)
      call visit_planets(set, v)
      call visit_meshes(set, v)
      call v%leave()

   contains

      subroutine on_body(name, meaning, value)
         character(*), intent(in) :: name, meaning
         character(*), intent(inout) :: value
         character(:), allocatable :: word

         word = trim(value)
         call v%on_text(row(name, '', meaning), word)
         value = word
      end subroutine on_body

   end subroutine visit_planetary

   !> Visits the variables of the gears.
   subroutine visit_gears(set, v)
      type(planetary_type), intent(inout) :: set
      class(visitor_type), intent(inout) :: v
      logical :: given
      character(:), allocatable :: word

      call v%on_list(row('teeth', '', 'numbers of teeth of sun, planet and ring; 0 for a sun or ring that the set lacks', &
                         least=zero, most=1e5*one, values=3, whole=.true.), set%teeth)
      call v%on_integer(row('planets', '', 'number of planets, equally spaced; or angles', least=2*one, most=1000*one, &
                            automatic=zero), set%planets)
      call v%on_list(row('angles', 'degree', 'angles of the planets on the carrier, in the sense in which the sun turns seen from &
                         &the carrier; in place of planets'), set%angles)
      word = trim(set%driving)
      call v%on_text(row('driving', '', 'member that drives the planets, seen from the carrier: ring where the sun is driven, as &
                         &in a wind turbine', choices='sun ring'), word)
      set%driving = word
      given = .not. abs(set%normal_module) <= 0
      call v%on_real(row('normal_module', 'm', 'normal module', required=.true., above=zero), set%normal_module, given)
      call v%on_real(row('pressure_angle', 'degree', 'normal pressure angle of the basic rack', least=10*one, most=35*one), &
                     set%pressure_angle)
      call v%on_real(row('helix_angle', 'degree', 'helix angle at the reference circle', least=zero, most=60*one), set%helix_angle)
      given = .not. abs(set%face_width) <= 0
      call v%on_real(row('face_width', 'm', 'common face width of the gears', above=zero), set%face_width, given)
      given = .not. abs(set%ring_face_width) <= 0
      call v%on_real(row('ring_face_width', 'm', 'common face width of planets and ring, where it is not face_width', above=zero), &
                     set%ring_face_width, given)
      call v%on_list(row('profile_shift', '', 'profile shift coefficients of sun, planet and ring, as of a mesh', &
                         least=-2*one, most=2*one, values=3), set%profile_shift)
      given = .not. abs(set%centre_distance) <= 0
      call v%on_real(row('centre_distance', 'm', 'distance of the axes of sun and planets; default: the flanks touch without &
                         &backlash', above=zero), set%centre_distance, given)
      call v%on_list(row('tip_diameter', 'm', 'tip diameters of sun, planet and ring, as of a mesh', above=zero, values=3), &
                     set%tip_diameter)
      call v%on_real(row('dedendum', '', 'dedendum of the basic rack over the module', least=one, most=2*one), set%dedendum)
      call v%on_list(row('elastic_modulus', 'N/m^2', 'moduli of elasticity of sun, planet and ring; none: steel, 2.06e11', &
                         above=zero, values=3), set%elastic_modulus)
   end subroutine visit_gears

   !> Visits the variables of the planets as bodies.
   subroutine visit_planets(set, v)
      type(planetary_type), intent(inout) :: set
      class(visitor_type), intent(inout) :: v
      logical :: given

      given = .not. abs(set%planet_inertia + 1) <= 0
      call v%on_real(row('planet_inertia', 'kg m^2', 'polar moment of inertia of a planet; default: of a disc of its pitch &
                         &diameter, with face_width, planet_bore and density', above=zero), set%planet_inertia, given)
      given = .not. abs(set%planet_mass + 1) <= 0
      call v%on_real(row('planet_mass', 'kg', 'mass of a planet; at the centre distance the masses of all planets add to the &
                         &inertia of the carrier. Default: of the disc; 0 without face_width', least=zero), set%planet_mass, given)
      call v%on_real(row('planet_bore', 'm', 'bore of the planets', least=zero), set%planet_bore)
      call v%on_list(row('planet_errors', 'm', 'errors of the places of the planets along the line of action, a value a planet: &
                         &the error_mean of both its meshes. Positive: against the push of the driving member; the planet bears &
                         &more'), set%planet_errors)
      call v%on_real(row('density', 'kg/m^3', 'density of the planets', above=zero), set%density)
   end subroutine visit_planets

   !> Visits the variables of the meshes.
   subroutine visit_meshes(set, v)
      type(planetary_type), intent(inout) :: set
      class(visitor_type), intent(inout) :: v
      character(*), parameter :: both = ' of sun and ring meshes; one value: both'
      character(:), allocatable :: word

      call v%on_list(row('backlash', 'm', 'circumferential backlash at the working pitch circles'//both//'; without it teeth &
                         &never part, and pull where they would', least=zero), set%backlash)
      call v%on_list(row('half_backlash', 'm', 'half of the backlash along the line of action'//both//', in place of backlash', &
                         least=zero), set%half_backlash)
      call v%on_list(row('stiffness', 'N/m', 'mean mesh stiffness'//both//'; none: from the drawing by ISO 6336-1', above=zero), &
                     set%stiffness)
      call v%on_list(row('damping_ratio', '', 'damping ratio, as of a mesh,'//both, least=zero), set%damping_ratio)
      call v%on_list(row('damping', 'N s/m', 'damping coefficient'//both//', in place of damping_ratio', least=zero), set%damping)
      call v%on_list(row('loss_factor', '', 'structural damping, as of a mesh,'//both//', in place of damping_ratio', least=zero, &
                         most=2*one), set%loss_factor)
      word = trim(set%damping_acts)
      call v%on_text(row('damping_acts', '', 'always, or only in contact: no damping while the teeth are apart', &
                         choices='always contact'), word)
      set%damping_acts = word
      call v%on_list(row('contact_ratio', '', 'contact ratio'//both//', which gives kappa as of a mesh; none: from the drawing', &
                         above=one, most=10*one), set%contact_ratio)
      call v%on_integer(row('stiffness_harmonics', '', 'number of harmonics taken of the rectangular wave', least=one, &
                            most=1000*one), set%stiffness_harmonics)
      call on_series('sun_stiffness', '', 'kappa of the sun meshes, in place of contact_ratio', &
                     set%sun_stiffness_cos, set%sun_stiffness_sin)
      call on_series('ring_stiffness', '', 'kappa of the ring meshes, in place of contact_ratio', &
                     set%ring_stiffness_cos, set%ring_stiffness_sin)
      call on_series('sun_error', 'm', 'the transmission error of the sun meshes', set%sun_error_cos, set%sun_error_sin)
      call on_series('ring_error', 'm', 'the transmission error of the ring meshes', set%ring_error_cos, set%ring_error_sin)
      call v%on_real(row('ring_phase', 'rad', 'lag of kappa and transmission error of each ring mesh behind those of the sun &
                         &mesh of its planet, in the mesh cycle; default: from tooth thickness and tips of the drawing, for kappa &
                         &as contact_ratio gives it', least=-6.2832_dp, most=6.2832_dp), set%ring_phase, set%ring_phase_given)
      call v%on_integer(row('order', '', 'mesh frequency over the fundamental frequency, as of a mesh', least=one, &
                            most=most_order*one, automatic=zero), set%order)

   contains

      !> Visits the harmonics of a series: NAME_cos and NAME_sin.
      subroutine on_series(name, unit, meaning, cosine, sine)
         character(*), intent(in) :: name, unit, meaning
         real(dp), allocatable, intent(inout) :: cosine(:), sine(:)

         call v%on_list(row(name//'_cos', unit, 'cosine amplitudes, harmonics 1, 2, ..., of '//meaning), cosine)
         call v%on_list(row(name//'_sin', unit, 'sine amplitudes, harmonics 1, 2, ...'), sine)
      end subroutine on_series

   end subroutine visit_meshes

end module geartrain_train_planetary_variables
