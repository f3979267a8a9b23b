!> The table of input variables of the train, its bodies, shafts, meshes, couplings and bearings.
!>
!> The initial values of the types are the defaults. A visitor visits the values in the order of a case file.
module geartrain_train_train_variables
   use geartrain_base_kinds, only: dp
   use geartrain_base_variable, only: row => variable_type, visitor_type
   use geartrain_train_bearing_variables, only: visit_bearing
   use geartrain_train_coupling_variables, only: visit_coupling
   use geartrain_train_gear_error, only: visit_gear_error
   use geartrain_train_body, only: body_type, follows_speed
   use geartrain_train_mesh, only: mesh_type, most_order
   use geartrain_train_planetary_variables, only: visit_planetary
   use geartrain_train_shaft, only: shaft_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: visit_model, visit_train, visit_body, visit_shaft, visit_mesh

   real(dp), parameter :: zero = 0, one = 1

contains

   !> Visits the train, its bodies and planetary sets, then shaft 1, mesh 1, shaft 2, ..., then the couplings and
   !> bearings.
   subroutine visit_model(train, visitor)
      !> The train; the visitor may change it.
      type(train_type), intent(inout) :: train
      !> Reads, checks, sets or lists each variable.
      class(visitor_type), intent(inout) :: visitor
      integer :: i, shafts, meshes, first

      call visit_train(train, visitor)
      if (allocated(train%bodies)) then
         do i = 1, size(train%bodies)
            call visit_body(train%bodies(i), i, visitor)
         end do
      end if
      if (allocated(train%planetaries)) then
         do i = 1, size(train%planetaries)
            call visit_planetary(train%planetaries(i), i, visitor)
         end do
      end if
      shafts = 0
      meshes = 0
      if (allocated(train%shafts)) shafts = size(train%shafts)
      if (allocated(train%meshes)) meshes = count(train%meshes%is_pair())
      do i = 1, max(shafts, meshes)
         if (i <= shafts) call visit_shaft(train%shafts(i), i, visitor)
         if (i <= meshes) call visit_mesh(train%meshes(i), i, visitor)
      end do
      if (.not. allocated(train%meshes)) return
      first = size(train%meshes) - count(train%meshes%axis > 0) + 1
      do i = meshes + 1, first - 1
         call visit_coupling(train%meshes(i), i - meshes, visitor)
      end do
      do i = 1, count(train%meshes%axis == 1)
         call visit_bearing(train%meshes(first + 2*i - 2:first + 2*i - 1), i, visitor)
      end do
   end subroutine visit_model

   !> Visits the variables of the group &train.
   subroutine visit_train(train, v)
      !> The train; the visitor may change it.
      type(train_type), intent(inout) :: train
      !> Reads, checks, sets or lists each variable.
      class(visitor_type), intent(inout) :: v
      logical :: chain, given
      character(:), allocatable :: word

      chain = .not. allocated(train%bodies)
      call v%enter('train', 1)
      call v%on_text(row('title', '', 'a line of text that is stored with the results'), train%title)
      call v%on_real(row('input_torque', 'N m', 'mean torque at the driving end of a chain; the load torque balances it', &
                         required=chain), train%input_torque, chain)
      call v%on_list(row('torque_cos', 'N m', 'cosine amplitudes of the input torque, orders 1, 2, ... of Lambda'), &
                     train%torque_cos)
      call v%on_list(row('torque_sin', 'N m', 'sine amplitudes, orders 1, 2, ...'), train%torque_sin)
      chain = .not. allocated(train%bodies)
      call v%on_real(row('prime_mover_inertia', 'kg m^2', 'polar moment of inertia at the driving end of a chain; 0 only if the &
                         &first shaft is rigid', required=chain, least=zero), train%prime_mover_inertia, chain)
      chain = .not. allocated(train%bodies)
      call v%on_real(row('load_inertia', 'kg m^2', 'polar moment of inertia at the driven end of a chain; 0 only if the last &
                         &shaft is rigid', required=chain, least=zero), train%load_inertia, chain)
      given = .not. abs(train%characteristic_length) <= 0
      call v%on_real(row('characteristic_length', 'm', 'unit of the mesh displacements in results, b_c; default where every mesh &
                         &has teeth: 1e-6', above=zero), train%characteristic_length, given)
      given = .not. abs(train%characteristic_frequency) <= 0
      call v%on_real(row('characteristic_frequency', 'rad/s', 'unit of the frequencies in results, omega_c: Lambda is the &
                         &fundamental frequency over omega_c. Default where every mesh has teeth: Lambda is the speed in rpm', &
                         above=zero), train%characteristic_frequency, given)
      call v%on_list(row('modal_damping', '', 'damping ratios of modes 1, 2, ...; the last value holds for all higher modes. &
                         &Shafts and meshes without damping of their own get dampings >= 0 that approximate these ratios', &
                         least=zero, most=one), train%modal_damping)
      word = trim(train%speed_of)
      call v%on_text(row('speed_of', '', 'name of the body whose speed is given in rpm; blank: the first body'), word)
      train%speed_of = word
      call v%leave()
   end subroutine visit_train

   !> Visits the variables of a group &body.
   subroutine visit_body(body, index, v)
      !> The body; the visitor may change it.
      type(body_type), intent(inout) :: body
      !> Number of the body in the train.
      integer, intent(in) :: index
      !> Reads, checks, sets or lists each variable.
      class(visitor_type), intent(inout) :: v
      logical :: given

      call v%enter('body', index)
      call v%on_text(row('name', '', 'name by which shafts and meshes refer to the body', required=.true.), body%name)
      given = .not. abs(body%inertia + 1) <= 0
      call v%on_real(row('inertia', 'kg m^2', 'polar moment of inertia; 0 only where all its connections are rigid shafts. &
                         &Default: from outer_diameter, else of its gears as discs of their pitch diameters', &
                         least=zero), body%inertia, given)
      call v%on_real(row('added_inertia', 'kg m^2', 'adds to the inertia, given or not: of masses that the body carries, as a &
                         &carrier its planets', least=zero), body%added_inertia)
      call v%on_list(row('outer_diameter', 'm', 'diameters of discs; their inertias are added', above=zero), body%outer_diameter)
      call v%on_list(row('bore', 'm', 'bores of the discs; one value: for all; none: 0', least=zero), body%bore)
      call v%on_list(row('width', 'm', 'widths of the discs', above=zero), body%width)
      call v%on_list(row('density', 'kg/m^3', 'densities of the discs; one value: for all; none: 7850', above=zero), body%density)
      call v%on_real(row('torque', 'N m', 'mean torque on the body, positive in its sense of rotation'), body%torque)
      call v%on_list(row('torque_cos', 'N m', 'cosine amplitudes of the torque on the body, orders 1, 2, ... of Lambda'), &
                         body%torque_cos)
      call v%on_list(row('torque_sin', 'N m', 'sine amplitudes, orders 1, 2, ...'), body%torque_sin)
      call v%on_list(row('revolution_torque_cos', 'N m', 'cosine amplitudes of the torque on the body, orders 1, 2, ... of its &
                         &revolution, of a planet against its carrier; every mesh must have teeth'), body%revolution_torque_cos)
      call v%on_list(row('revolution_torque_sin', 'N m', 'sine amplitudes, orders 1, 2, ...'), body%revolution_torque_sin)
      call v%on_list(row('torque_table', 'N m', 'torque at 4 or more equidistant angles of torque_revolutions from the beginning, &
                         &joined by a trigonometric polynomial; adds to the other torques; every mesh must have teeth'), &
                     body%torque_table)
      call v%on_integer(row('torque_revolutions', '', 'revolutions over which torque_table goes; 2: four strokes', least=one, &
                            most=2*one), body%torque_revolutions)
      given = follows_speed(body)
      call v%on_real(row('torque_speed_exponent', '', 'the mean torque is proportional to this power of the speed: 2 of &
                         &propellers and fans, -1 at constant power; 0: the same at all speeds. Every mesh must have teeth, &
                         &whose stiffness stays that of the torque as given; the slope of the torque damps no vibration', &
                         least=-4.0_dp, most=4.0_dp), body%torque_speed_exponent, given)
      given = .not. abs(body%torque_speed) <= 0
      call v%on_real(row('torque_speed', 'rpm', 'speed of the body at which the mean torque is as given, where it follows the &
                         &speed', above=zero), body%torque_speed, given)
      call v%on_real(row('damping_to_ground', 'N m s/rad', 'damping of the vibration of the body against the ground; give a mean &
                         &drag as torque', least=zero), body%damping_to_ground)
      call v%on_real(row('stiffness_to_ground', 'N m/rad', 'stiffness of a spring between the body and the ground; it bears a mean &
                         &torque, and the body cannot turn', least=zero), body%stiffness_to_ground)
      call v%on_logical(row('held', '', 'the body stands still, as a housing; its reaction torque is a result'), body%held)
      call v%on_real(row('speed_ratio', '', 'mean speed of the body over that of the body of speed_of, negative in the opposite &
                         &sense; only where the gears leave it free, as in a differential'), body%speed_ratio, body%ratio_given)
      call v%on_list(row('position', 'm', 'position of the axis in the transverse plane, x and y, where the body of speed_of turns &
                         &from x to y; for meshes of bodies on bearings', values=2), body%position)
      call v%on_logical(row('balances', '', 'the mean torque of the body balances all other torques, in a run-up also the &
                            &acceleration of the inertias; .true. for as many bodies as there are independent speeds, for none &
                            &where a spring to ground holds the train'), body%balances)
      call v%leave()
   end subroutine visit_body

   !> Visits the variables of a group &shaft.
   subroutine visit_shaft(shaft, index, v)
      !> The shaft; the visitor may change it.
      type(shaft_type), intent(inout) :: shaft
      !> Number of the shaft in the train.
      integer, intent(in) :: index
      !> Reads, checks, sets or lists each variable.
      class(visitor_type), intent(inout) :: v
      logical :: given, by_ratio

      call v%enter('shaft', index)
      call v%on_names(row('between', '', 'names of the bodies at its two ends; none in a chain'), shaft%between)
      call v%on_logical(row('rigid', '', 'the bodies at its ends turn as one; a rigid shaft has no stiffness and no damping'), &
                            shaft%rigid)
      ! Where several are given, all are written, so that `check_shaft` finds the contradiction again.
      given = .not. abs(shaft%stiffness) <= 0
      call v%on_real(row('stiffness', 'N m/rad', 'torsional stiffness; else from diameter and length', above=zero), &
                     shaft%stiffness, given)
      call v%on_list(row('diameter', 'm', 'diameters of sections in series, each of stiffness pi G (D^4 - d^4)/(32 l)', &
                         above=zero), shaft%diameter)
      call v%on_list(row('bore', 'm', 'bores of the sections; one value: for all; none: 0', least=zero), shaft%bore)
      call v%on_list(row('length', 'm', 'lengths of the sections', above=zero), shaft%length)
      call v%on_real(row('shear_modulus', 'N/m^2', 'shear modulus, G', above=zero), shaft%shear_modulus)
      by_ratio = .not. (shaft%rigid .or. shaft%damping_given .or. shaft%loss_factor > 0)
      call v%on_real(row('damping_ratio', '', 'c/(2 sqrt(k m)) with 1/m = 1/I_a + 1/I_b of the bodies at its ends; in a chain I_a &
                         &and I_b include rigidly joined inertias', &
                         least=zero), shaft%damping_ratio, by_ratio)
      call v%on_real(row('damping', 'N m s/rad', 'damping coefficient, in place of damping_ratio', least=zero, &
                         excludes='damping_ratio'), shaft%damping, shaft%damping_given)
      given = shaft%loss_factor > 0
      call v%on_real(row('loss_factor', '', 'structural damping, in place of damping_ratio: damping k loss_factor/omega, omega the &
                         &natural frequency of the mode in which the shaft has most strain energy', least=zero, most=2*one), &
                     shaft%loss_factor, given)
      call v%leave()
   end subroutine visit_shaft

   !> Visits the variables of a group &mesh.
   subroutine visit_mesh(mesh, index, v)
      !> The mesh; the visitor may change it.
      type(mesh_type), intent(inout) :: mesh
      !> Number of the mesh in the train.
      integer, intent(in) :: index
      !> Reads, checks, sets or lists each variable.
      class(visitor_type), intent(inout) :: v
      logical :: given, by_ratio, own_gears, plain, rectangular, own_back
      character(:), allocatable :: word

      call v%enter('mesh', index)
      call v%on_names(row('between', '', 'names of the bodies with the driving and the driven gear; none in a chain'), &
                      mesh%between)
      word = trim(mesh%name)
      call v%on_text(row('name', '', 'label of the mesh in results; none: by the names of the bodies'), word)
      mesh%name = word
      word = trim(mesh%carrier)
      call v%on_text(row('carrier', '', 'name of the body on which both gears ride, the arm of a planetary stage; none: their axes &
                         &stand still'), word)
      mesh%carrier = word
      call visit_drawing(mesh, v)
      given = .not. abs(mesh%driving_radius) <= 0
      call v%on_real(row('driving_radius', 'm', 'base circle radius of the driving gear; else from teeth and normal_module', &
                         above=zero), mesh%driving_radius, given)
      given = .not. abs(mesh%driven_radius) <= 0
      call v%on_real(row('driven_radius', 'm', 'base circle radius of the driven gear; else from teeth and normal_module', &
                         above=zero), mesh%driven_radius, given)
      own_gears = .not. abs(mesh%driving_inertia) <= 0
      call v%on_real(row('driving_inertia', 'kg m^2', 'in a chain: polar moment of inertia of the driving gear; else of a disc of &
                         &its pitch diameter', above=zero), mesh%driving_inertia, own_gears)
      own_gears = .not. abs(mesh%driven_inertia) <= 0
      call v%on_real(row('driven_inertia', 'kg m^2', 'in a chain: polar moment of inertia of the driven gear; else of a disc of &
                         &its pitch diameter', above=zero), mesh%driven_inertia, own_gears)
      call v%on_logical(row('internal', '', 'internal gear pair: both gears turn in the same sense'), mesh%internal)
      ! Where both are given, both are written, so that `check_stiffness` finds the contradiction again.
      plain = .not. abs(mesh%stiffness) <= 0
      call v%on_real(row('stiffness', 'N/m', 'mean mesh stiffness along the line of action in the transverse plane; else from &
                         &stiffness_table, or from the drawing by ISO 6336-1, reduced below a line load of 100 N/mm', &
                         above=zero), mesh%stiffness, plain)
      by_ratio = .not. (mesh%damping_given .or. mesh%loss_factor > 0)
      call v%on_real(row('damping_ratio', '', 'c/(2 sqrt(k m)) with m = I_a I_b/(r_a^2 I_b + r_b^2 I_a)', least=zero), &
                     mesh%damping_ratio, by_ratio)
      call v%on_real(row('damping', 'N s/m', 'damping coefficient, in place of damping_ratio', least=zero, &
                         excludes='damping_ratio'), mesh%damping, mesh%damping_given)
      given = mesh%loss_factor > 0
      call v%on_real(row('loss_factor', '', 'structural damping, in place of damping_ratio: damping k loss_factor/omega, omega the &
                         &natural frequency of the mode in which the mesh has most strain energy', least=zero, most=2*one), &
                     mesh%loss_factor, given)
      word = trim(mesh%damping_acts)
      call v%on_text(row('damping_acts', '', 'always, or only in contact: no damping while the teeth are apart', &
                         choices='always contact'), word)
      mesh%damping_acts = word
      call v%on_real(row('half_backlash', 'm', 'half of the backlash along the line of action in the transverse plane, b; 0: &
                         &linear mesh, unless `backlash` is given', least=zero), mesh%half_backlash)
      call v%on_list(row('stiffness_cos', '', 'cosine amplitudes, harmonics 1, 2, ... of kappa(t) = 1 + ..., the mesh stiffness &
                         &over its mean'), mesh%stiffness_cos)
      call v%on_list(row('stiffness_sin', '', 'sine amplitudes, harmonics 1, 2, ...'), mesh%stiffness_sin)
      call v%on_list(row('stiffness_table', 'N/m', 'stiffness at 4 or more equidistant instants of a mesh cycle, joined by a &
                         &trigonometric polynomial; gives the mean stiffness and kappa. With table_loads: load over &
                         &deflection, load after load', above=zero), mesh%stiffness_table)
      call v%on_list(row('table_loads', 'N', 'ascending loads at which stiffness_table gives the stiffness: at each instant the &
                         &force is a polygon over the displacement, with corners at the mean deflections under the loads; &
                         &half_backlash or backlash must be > 0', above=zero), mesh%table_loads)
      own_back = mesh%back_stiffness > 0
      call v%on_real(row('back_stiffness', 'N/m', 'mean stiffness of the back flanks, which touch at p < -half_backlash; default: &
                         &as the drive flanks', above=zero), mesh%back_stiffness, own_back)
      call v%on_real(row('back_phase', 'rad', 'lag of kappa of the back flanks behind kappa of the drive flanks, in the mesh &
                         &cycle'), mesh%back_phase)
      rectangular = mesh%contact_ratio > 0
      call v%on_real(row('contact_ratio', '', 'gives kappa as the rectangular wave of the number of tooth pairs in contact, in &
                         &place of stiffness_cos and stiffness_sin. At phase = 0 the time with the extra pair is centred at the &
                         &beginning of the cycle if the integer part of the ratio is odd, else at half the cycle', above=one, &
                         most=10*one), mesh%contact_ratio, rectangular)
      call v%on_integer(row('stiffness_harmonics', '', 'number of harmonics taken of the rectangular wave', least=one, &
                            most=1000*one), mesh%stiffness_harmonics)
      call v%on_real(row('phase', 'rad', 'lag of kappa and of all errors, in the mesh cycle; 0 of a mesh of planets of a &
                         &set: as their place behind the first planet makes it'), mesh%phase)
      call v%on_list(row('error_cos', 'm', 'cosine amplitudes of the static transmission error, harmonics 1, 2, ...; it adds to &
                         &the mesh displacement; its sign and phase against the stiffness matter'), mesh%error_cos)
      call v%on_list(row('error_sin', 'm', 'sine amplitudes, harmonics 1, 2, ...'), mesh%error_sin)
      call v%on_list(row('error_table', 'm', 'transmission error at 4 or more equidistant instants of a mesh cycle, joined by a &
                         &trigonometric polynomial, in place of error_cos and error_sin; its mean adds to error_mean', &
                         least=-one, most=one), mesh%error_table)
      call v%on_real(row('error_mean', 'm', 'constant part of the transmission error, of placement and tooth thickness; positive: &
                         &towards contact of the drive flanks. It matters in loops of gears alone, as between planets'), &
                     mesh%error_mean)
      call visit_gear_error(mesh%gear_error(1), 1, v)
      call visit_gear_error(mesh%gear_error(2), 2, v)
      word = trim(mesh%pitch_error_form)
      call v%on_text(row('pitch_error_form', '', 'polynomial through the pitch errors, or steps from tooth to tooth, smoothed over &
                         &the time in which two pairs bear by the contact ratio, which must be known, and over the face of helical &
                         &teeth', &
                         choices='polynomial steps'), word)
      mesh%pitch_error_form = word
      call v%on_real(row('line_of_action', 'degree', 'of bodies on bearings: direction in which the driving gear pushes the driven &
                         &gear, from the x axis towards the y axis; default: from the positions of the axes', least=-360*one, &
                         most=360*one), mesh%line_of_action, mesh%line_given)
      call v%on_integer(row('order', '', 'mesh frequency over the fundamental frequency, m_n; 0: from the teeth where every mesh &
                            &has them, else 1', least=one, most=most_order*one, automatic=zero), mesh%order)
      call v%leave()
   end subroutine visit_mesh

   !> Visits the variables of a mesh that are read off a drawing.
   subroutine visit_drawing(mesh, v)
      !> The mesh; the visitor may change it.
      type(mesh_type), intent(inout) :: mesh
      !> Reads, checks, sets or lists each variable.
      class(visitor_type), intent(inout) :: v
      logical :: given

      call v%on_list(row('teeth', '', 'numbers of teeth of the driving and the driven gear', least=3*one, most=1e5*one, values=2, &
                         whole=.true.), mesh%teeth)
      given = .not. abs(mesh%normal_module) <= 0
      call v%on_real(row('normal_module', 'm', 'normal module', above=zero), mesh%normal_module, given)
      call v%on_real(row('pressure_angle', 'degree', 'normal pressure angle of the basic rack', least=10*one, most=35*one), &
                     mesh%pressure_angle)
      call v%on_real(row('helix_angle', 'degree', 'helix angle at the reference circle', least=zero, most=60*one), mesh%helix_angle)
      given = .not. abs(mesh%face_width) <= 0
      call v%on_real(row('face_width', 'm', 'common face width of the two gears', above=zero), mesh%face_width, given)
      call v%on_list(row('profile_shift', '', 'profile shift coefficients, positive towards the tips; none: 0', least=-2*one, &
                         most=2*one, values=2), mesh%profile_shift)
      given = .not. abs(mesh%centre_distance) <= 0
      call v%on_real(row('centre_distance', 'm', 'centre distance; default: the flanks touch without backlash', &
                         above=zero), mesh%centre_distance, given)
      call v%on_list(row('tip_diameter', 'm', 'tip diameters; default: from the basic rack, shortened to keep its clearance &
                         &where flanks without backlash touch', above=zero, values=2), mesh%tip_diameter)
      call v%on_real(row('dedendum', '', 'dedendum of the basic rack over the module', least=one, most=2*one), mesh%dedendum)
      call v%on_real(row('backlash', 'm', 'circumferential backlash at the working pitch circles, in the transverse plane', &
                         least=zero), mesh%backlash)
      call v%on_list(row('bore', 'm', 'bores of the gears, for their inertias; none: 0', least=zero, values=2), mesh%bore)
      call v%on_real(row('density', 'kg/m^3', 'density of the gears, for their inertias', above=zero), mesh%density)
      call v%on_list(row('elastic_modulus', 'N/m^2', 'moduli of elasticity of the gears; none: steel, 2.06e11', above=zero, &
                         values=2), mesh%elastic_modulus)
   end subroutine visit_drawing

end module geartrain_train_train_variables
