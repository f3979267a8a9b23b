!> A gear pair in SI units; or a coupling, which is a gear pair of equal radii for all that computes; or one direction of a
!> bearing, which for the rotations is a gear pair of a body with itself: nothing.
module geartrain_train_mesh
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_series, only: delay, make_series, multiply_series, series_type, table_harmonics
   use geartrain_base_variable, only: largest
   use geartrain_mesh_law_law, only: law_type
   use geartrain_mesh_law_characteristic, only: characteristic_type, find_characteristic
   use geartrain_mesh_law_loaded_contact, only: falling_instant, find_stages
   use geartrain_train_body, only: name_length
   use geartrain_train_gear_error, only: gear_error_type, has_tooth_factors
   implicit none (type, external)
   private
   public :: mesh_type, coupling_radius, has_loads, has_table, is_given, most_order, new_bearing, new_coupling, plain_coupling, &
      plain_mesh, put_law, straighten

   !> Displacement of a coupling per twist [m/rad]: 1 um stands for 1 mrad.
   real(dp), parameter :: coupling_radius = 1e-3_dp

   !> Highest mesh frequency over the fundamental [1].
   integer, parameter :: most_order = 1000000

   type :: mesh_type
      !> Label in results; blank: by the names of the bodies.
      character(name_length) :: name = ''
      !> Names of the bodies of the driving and the driven gear; blank in a chain.
      character(name_length) :: between(2) = ''
      !> Name of the body on which both gears ride; blank: their axes stand still.
      character(name_length) :: carrier = ''
      !> An internal gear pair: both gears turn in one sense.
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
      !> Loss factor [1], in place of both; 0: not given.
      real(dp) :: loss_factor = 0
      !> 'always' or 'contact': not while the teeth are apart.
      character(8) :: damping_acts = 'always'
      !> Half of the backlash [m]; 0 makes the mesh linear.
      real(dp) :: half_backlash = 0
      !> Mean stiffness of the back flanks [N/m], 0: equal to `stiffness`; lag of kappa of the back flanks behind kappa of the drive
      !> flanks [rad of the mesh cycle].
      real(dp) :: back_stiffness = 0, back_phase = 0
      !> Harmonics 1..K of kappa(t) = 1 + ... [1], equation (7a); empty where there are none.
      real(dp), allocatable :: stiffness_cos(:), stiffness_sin(:)
      !> In place of stiffness and its harmonics: stiffness at equidistant instants of a mesh cycle from its beginning [N/m].
      real(dp), allocatable :: stiffness_table(:)
      !> Loads at which the table gives the stiffness, load over deflection [N], ascending, (load); those of a load stand side by
      !> side. Not given: the stiffness does not depend on the load.
      real(dp), allocatable :: table_loads(:)
      !> Derived of a plain mesh with loads: deflections between the stages [m], (stage - 1); of the stages from the second on the
      !> mean over `stiffness` [1], (stage - 1), and harmonics 1, 2, ... over `stiffness` [1], (harmonic, stage - 1); the largest
      !> difference to a load of the table, over the load [1].
      real(dp), allocatable :: stage_wall(:), stage_mean(:), stage_cos(:, :), stage_sin(:, :)
      real(dp) :: stage_error = 0
      !> In place of the harmonics: contact ratio of a rectangular wave of the stiffness [1], 0: not given; harmonics of this wave.
      real(dp) :: contact_ratio = 0
      integer :: stiffness_harmonics = 5
      !> Lag of kappa and of the transmission error [rad of the mesh cycle].
      real(dp) :: phase = 0
      !> Harmonics 1.. of the static transmission error [m], equation (7b), which adds to the mesh displacement.
      real(dp), allocatable :: error_cos(:), error_sin(:)
      !> In place of them: transmission error at equidistant instants of a mesh cycle from its beginning [m].
      real(dp), allocatable :: error_table(:)
      !> Constant part of the transmission error [m], by placement of axes and thickness of teeth.
      real(dp) :: error_mean = 0
      !> Errors of the driving and of the driven gear, once a revolution; 'polynomial' or 'steps' through the pitch errors.
      type(gear_error_type) :: gear_error(2)
      character(10) :: pitch_error_form = 'polynomial'
      !> Mesh frequency as a multiple of the fundamental, m_n [1]; 0: by the teeth where every mesh has them, else 1.
      integer :: order = 0
      !> Derived of a plain mesh: its gears turn as one with their carrier, so that its teeth stand still in each other.
      logical :: locked = .false.
      !> From the drawing, see geartrain_drawing_gear_pair: numbers of teeth, (2); normal module [m]; normal pressure angle and
      !> helix angle at the reference circle [degree]; face width [m]; profile shifts [1], (2); centre distance [m], 0: without
      !> backlash; tip diameters [m], (2); dedendum of the basic rack over the module [1]; backlash along the working pitch circles
      !> [m]; moduli of elasticity [N/m^2], (2).
      real(dp), allocatable :: teeth(:), profile_shift(:), tip_diameter(:), elastic_modulus(:)
      real(dp) :: normal_module = 0, pressure_angle = 20, helix_angle = 0, face_width = 0, centre_distance = 0, dedendum = 1.25_dp
      real(dp) :: backlash = 0
      !> Of the gears as discs: bores [m], (2), and density [kg/m^3].
      real(dp), allocatable :: bore(:)
      real(dp) :: density = 7850
      !> Derived: static force [N] below which the stiffness by ISO 6336-1 falls; 0: the stiffness is given.
      real(dp) :: light_force = 0
      !> A coupling: its variables are name, between, damping_ratio, damping_given, loss_factor, damping_acts and those below.
      !> Couplings stand after the gear pairs of a train.
      logical :: is_coupling = .false.
      !> Stiffness [N m/rad], damping [N m s/rad] and half of the play [rad]; or corners of a polygon, (corner): twists [rad] and
      !> torques [N m].
      real(dp) :: torsional_stiffness = 0, torsional_damping = 0, half_play = 0
      real(dp), allocatable :: angle(:), torque(:)
      !> Of a gear pair on bearings: direction in which the driving gear pushes the driven gear [degree from the x axis to the y
      !> axis], in force when `line_given`; else by the positions of the axes.
      real(dp) :: line_of_action = 0
      logical :: line_given = .false.
      !> Row of a bearing, 1: x, 2: y, above: see geartrain_train_bearing_rows; 0: no bearing. Bearings stand after the couplings, x
      !> before y, further rows at the end. Their variables are between (the body twice), stiffness, damping and half_backlash
      !> (half of the clearance [m]) of the direction, `mass` and `flats`.
      integer :: axis = 0
      !> Mass of the body that the bearing carries [kg]; number of flats of the clearance, two of each row; share of a row in the
      !> stiffness that the bearing has in its direction, 1 in a train as given.
      real(dp) :: mass = 0
      integer :: flats = 4
      real(dp) :: share = 1
      !> Dry friction of a coupling, largest torque [N m].
      real(dp) :: friction_torque = 0
   contains
      procedure :: is_bent
      procedure :: is_pair
   end type mesh_type

contains

   !> Whether the stiffness is given by a table.
   pure logical function has_table(mesh)
      !> The mesh as given.
      type(mesh_type), intent(in) :: mesh

      has_table = is_given(mesh%stiffness_table)
   end function has_table

   !> Whether the stiffness is given at several loads by a table that is in order.
   pure logical function has_loads(mesh)
      !> The mesh as given.
      type(mesh_type), intent(in) :: mesh

      has_loads = has_table(mesh) .and. is_given(mesh%table_loads)
      if (.not. has_loads) return
      associate (n => size(mesh%table_loads))
         has_loads = n > 1 .and. modulo(size(mesh%stiffness_table), n) == 0 .and. size(mesh%stiffness_table) >= 4*n &
                     .and. all(mesh%table_loads > 0) .and. all(mesh%table_loads(2:) > mesh%table_loads(:n - 1))
      end associate
      if (has_loads) has_loads = all(mesh%stiffness_table > 0 .and. mesh%stiffness_table <= largest)
      if (has_loads) has_loads = falling_instant(mesh%table_loads, mesh%stiffness_table) == 0
   end function has_loads

   !> Whether a list is given: an empty list is not.
   pure logical function is_given(list)
      !> Values in any unit; may be unallocated.
      real(dp), allocatable, intent(in) :: list(:)

      is_given = .false.
      if (allocated(list)) is_given = size(list) > 0
   end function is_given

   !> A coupling without values.
   pure type(mesh_type) function new_coupling() result(coupling)
      coupling%is_coupling = .true.
      coupling%internal = .true.
      coupling%driving_radius = coupling_radius
      coupling%driven_radius = coupling_radius
   end function new_coupling

   !> A direction of a bearing without values.
   pure type(mesh_type) function new_bearing(axis) result(bearing)
      !> 1: x, 2: y, above: a row beside them.
      integer, intent(in) :: axis

      bearing%axis = axis
      bearing%internal = .true.
      bearing%driving_radius = 1
      bearing%driven_radius = 1
      bearing%damping_given = .true.
   end function new_bearing

   !> Whether it is a gear pair.
   elemental logical function is_pair(self)
      class(mesh_type), intent(in) :: self

      is_pair = .not. (self%is_coupling .or. self%axis > 0)
   end function is_pair

   !> Whether the force is not proportional to the displacement: there is a gap, or a coupling has stages.
   pure logical function is_bent(self)
      class(mesh_type), intent(in) :: self

      is_bent = self%half_backlash > 0
      if (self%is_coupling .and. is_given(self%angle)) is_bent = is_bent .or. size(self%angle) > 2
   end function is_bent

   !> Removes the gap of a mesh, and the stages of a coupling: what is left has the stiffness beside the gap.
   elemental subroutine straighten(mesh)
      !> A mesh of a plain train.
      type(mesh_type), intent(inout) :: mesh

      mesh%half_backlash = 0
      if (allocated(mesh%stage_wall)) deallocate (mesh%stage_wall)
      if (.not. mesh%is_coupling) return
      mesh%torsional_stiffness = mesh%stiffness*coupling_radius**2
      mesh%half_play = 0
      if (allocated(mesh%angle)) deallocate (mesh%angle)
      if (allocated(mesh%torque)) deallocate (mesh%torque)
   end subroutine straighten

   !> Makes the gear pair of a coupling.
   pure subroutine plain_coupling(coupling)
      !> The coupling; gets stiffness, damping and half backlash.
      type(mesh_type), intent(inout) :: coupling
      type(characteristic_type) :: found

      call find_characteristic(coupling%torsional_stiffness, coupling%half_play, coupling%angle, coupling%torque, found)
      coupling%stiffness = found%stiffness/coupling_radius**2
      coupling%damping = coupling%torsional_damping/coupling_radius**2
      coupling%half_backlash = found%half_play*coupling_radius
   end subroutine plain_coupling

   !> Replaces tables, contact ratio and phase of a mesh by mean stiffness and harmonics of an equal force.
   pure subroutine plain_mesh(mesh)
      !> The mesh as given; gets mean stiffness and harmonics only.
      type(mesh_type), intent(inout) :: mesh
      real(dp), allocatable :: loads(:), table(:)
      real(dp) :: mean
      integer :: h
      logical :: with_loads

      if (mesh%contact_ratio > 0) then
         ! A rectangular wave: one more tooth pair is in contact during the share contact_ratio - 1 of the cycle.
         mesh%stiffness_cos = [(2*sin(h*pi*(mesh%contact_ratio - 1))/(h*pi*mesh%contact_ratio), h=1, mesh%stiffness_harmonics)]
      else if (has_table(mesh)) then
         with_loads = has_loads(mesh)
         call move_alloc(mesh%stiffness_table, table)
         call move_alloc(mesh%table_loads, loads)
         if (with_loads) then
            call take_loads(loads, table, (mesh%phase), mesh)
         else if (all(table > 0 .and. table <= largest)) then
            call transform(table, mesh)
         end if
      end if
      mesh%contact_ratio = 0
      if (allocated(mesh%stiffness_table)) deallocate (mesh%stiffness_table)
      if (allocated(mesh%table_loads)) deallocate (mesh%table_loads)
      if (is_given(mesh%error_table)) then
         call table_harmonics(mesh%error_table, mean, mesh%error_cos, mesh%error_sin)
         mesh%error_mean = mesh%error_mean + mean
         deallocate (mesh%error_table)
      end if
      if (.not. abs(mesh%phase) > 0) return
      call delay(mesh%phase, mesh%stiffness_cos, mesh%stiffness_sin)
      call delay(mesh%phase, mesh%error_cos, mesh%error_sin)
      mesh%phase = 0
   end subroutine plain_mesh

   !> Makes the force law of a plain mesh. Its damping is relative to the damping of the mesh until `law_type%complete`.
   pure subroutine put_law(mesh, length, law)
      !> A mesh from `plain_mesh`.
      type(mesh_type), intent(in) :: mesh
      !> Unit of displacements in the law, b_c [m].
      real(dp), intent(in) :: length
      !> Walls, stiffness, origin, amplitudes and relative damping of the regions.
      type(law_type), intent(out) :: law
      type(series_type) :: kappa, back_kappa
      real(dp) :: mean, back, back_mean
      integer :: h

      if (mesh%is_coupling) then
         call put_stages(mesh, length, law)
         return
      else if (allocated(mesh%stage_wall)) then
         call put_loaded_stages(mesh, length, law)
         return
      end if
      kappa = make_series(mesh%stiffness_cos, mesh%stiffness_sin, 1.0_dp, mesh%order)
      back_kappa = kappa
      back_kappa%amplitude = [(kappa%amplitude(h)*exp(cmplx(0, -h*mesh%back_phase, dp)), h=1, size(kappa%amplitude))]
      mean = 1
      back_mean = 1
      call take_teeth(mesh, mean, kappa)
      associate (b => mesh%half_backlash/length)
         if (b > 0) then
            call take_teeth(mesh, back_mean, back_kappa)
            call law%begin(-1, [-b, b], kappa%harmonic)
         else
            call law%begin(1, [real(dp) ::], kappa%harmonic)
         end if
         law%order = mesh%order
         law%damping(:) = 1
         ! The drive flank.
         law%stiffness(1) = mean
         law%origin(1) = b
         law%amplitude(:, 1) = kappa%amplitude
         if (.not. b > 0) return
         ! The gap.
         if (mesh%damping_acts == 'contact') law%damping(0) = 0
         ! The back flank.
         back = 1
         if (mesh%back_stiffness > 0) back = mesh%back_stiffness/mesh%stiffness
         law%stiffness(-1) = back*back_mean
         law%origin(-1) = -b
         law%amplitude(:, -1) = back*back_kappa%amplitude
      end associate
   end subroutine put_law

   !> Multiplies kappa by the factors of the teeth of both gears.
   pure subroutine take_teeth(mesh, mean, kappa)
      type(mesh_type), intent(in) :: mesh
      !> Mean of kappa and its harmonics of Lambda.
      real(dp), intent(inout) :: mean
      type(series_type), intent(inout) :: kappa
      integer :: gear

      do gear = 1, 2
         associate (error => mesh%gear_error(gear))
            if (has_tooth_factors(error)) call multiply_series(error%factor_mean, make_series(error%factor_cos, error%factor_sin, &
                                                                                    1.0_dp, error%order), mean, kappa)
         end associate
      end do
   end subroutine take_teeth

   !> Makes the force law of a coupling, a region for each part of its characteristic.
   pure subroutine put_stages(mesh, length, law)
      type(mesh_type), intent(in) :: mesh
      real(dp), intent(in) :: length
      type(law_type), intent(out) :: law
      type(characteristic_type) :: found

      call find_characteristic(mesh%torsional_stiffness, mesh%half_play, mesh%angle, mesh%torque, found)
      call law%begin(found%lowest, found%corner*coupling_radius/length, [integer ::])
      law%order = mesh%order
      law%damping(:) = 1
      law%stiffness(:) = found%slope/found%stiffness
      law%origin(:) = found%origin*coupling_radius/length
      if (mesh%damping_acts == 'contact' .and. found%half_play > 0) law%damping(0) = 0
   end subroutine put_stages

   !> Makes the force law of a mesh whose stiffness depends on the load: a region for each stage, of the back flanks as well.
   pure subroutine put_loaded_stages(mesh, length, law)
      type(mesh_type), intent(in) :: mesh
      real(dp), intent(in) :: length
      type(law_type), intent(out) :: law
      type(series_type) :: kappa
      complex(dp), allocatable :: amplitude(:, :)
      real(dp), allocatable :: wall(:)
      real(dp) :: back
      integer :: h, n, s

      n = size(mesh%stage_wall) + 1
      wall = [mesh%half_backlash, mesh%half_backlash + mesh%stage_wall]/length
      allocate (amplitude(size(mesh%stage_cos, 1), n), source=(0.0_dp, 0.0_dp))
      kappa = make_series(mesh%stiffness_cos, mesh%stiffness_sin, 1.0_dp, mesh%order)
      amplitude(:size(kappa%amplitude), 1) = kappa%amplitude
      amplitude(:, 2:) = cmplx(mesh%stage_cos, -mesh%stage_sin, dp)
      call law%begin(-n, [-wall(n:1:-1), wall], [(mesh%order*h, h=1, size(amplitude, 1))])
      law%order = mesh%order
      law%damping(:) = 1
      if (mesh%damping_acts == 'contact') law%damping(0) = 0
      back = 1
      if (mesh%back_stiffness > 0) back = mesh%back_stiffness/mesh%stiffness
      law%stiffness(1:) = [1.0_dp, mesh%stage_mean]
      law%amplitude(:, 1:) = amplitude
      law%origin(1) = wall(1)
      law%origin(-1) = -wall(1)
      do s = 1, n
         law%stiffness(-s) = back*law%stiffness(s)
         do h = 1, size(amplitude, 1)
            law%amplitude(h, -s) = back*amplitude(h, s)*exp(cmplx(0, -h*mesh%back_phase, dp))
         end do
      end do
      call law%join()
   end subroutine put_loaded_stages

   !> Sets mean stiffness, harmonics and stages to those of a table at several loads.
   pure subroutine take_loads(load, table, phase, mesh)
      real(dp), intent(in) :: load(:), table(:), phase
      type(mesh_type), intent(inout) :: mesh
      real(dp), allocatable :: wall(:), stiffness(:, :), cosine(:), sine(:)
      integer :: s

      call find_stages(load, table, wall, stiffness, mesh%stage_error)
      call transform(stiffness(:, 1), mesh)
      mesh%stage_wall = wall
      allocate (mesh%stage_mean(size(wall)))
      do s = 2, size(load)
         call table_harmonics(stiffness(:, s), mesh%stage_mean(s - 1), cosine, sine)
         if (abs(phase) > 0) call delay(phase, cosine, sine)
         if (s == 2) allocate (mesh%stage_cos(size(cosine), size(wall)), mesh%stage_sin(size(cosine), size(wall)))
         mesh%stage_cos(:, s - 1) = cosine/mesh%stiffness
         mesh%stage_sin(:, s - 1) = sine/mesh%stiffness
      end do
      mesh%stage_mean = mesh%stage_mean/mesh%stiffness
   end subroutine take_loads

   !> Sets mean stiffness and harmonics to the trigonometric polynomial of least degree through the values of a table.
   pure subroutine transform(table, mesh)
      real(dp), intent(in) :: table(:)
      type(mesh_type), intent(inout) :: mesh

      call table_harmonics(table, mesh%stiffness, mesh%stiffness_cos, mesh%stiffness_sin)
      mesh%stiffness_cos = mesh%stiffness_cos/mesh%stiffness
      mesh%stiffness_sin = mesh%stiffness_sin/mesh%stiffness
   end subroutine transform

end module geartrain_train_mesh
