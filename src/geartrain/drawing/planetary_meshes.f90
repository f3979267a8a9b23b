!> The meshes of a planetary set: their variables, and the phases that follow from the places of the planets and from the teeth.
!>
!> Seen from the carrier all axes stand still. A planet at the angle psi (turns, in the sense of the sun) meets the sun z_s psi mesh
!> cycles later than a planet at the angle 0, and the ring z_r psi cycles earlier, because the ring turns against the sun.
!> Between the two meshes of one planet: see `ring_lag`.
module geartrain_drawing_planetary_meshes
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_numbers, only: integer_text, whole
   use geartrain_drawing_drawing, only: has_geometry, pair_of
   use geartrain_drawing_gear_pair, only: find_geometry, involute, pair_geometry_type
   use geartrain_train_body, only: name_length
   use geartrain_train_mesh, only: is_given, mesh_type
   use geartrain_train_planetary, only: planetary_type
   implicit none (type, external)
   private
   public :: planet_name, ring_lag, ring_meshes, set_type, sun_meshes

   !> The two kinds of meshes.
   integer, parameter :: sun_meshes = 1, ring_meshes = 2
   !> Difference of two tip diameters that counts as rounding [1].
   real(dp), parameter :: rounding = 1e-12_dp

   !> A planetary set in numbers.
   type :: set_type
      !> Whether the set has sun meshes and ring meshes; whether their drawings have a geometry, (2).
      logical :: has(2) = .false., drawn(2) = .false.
      !> A mesh of either kind, of the first planet, without phase; its geometry, (2).
      type(mesh_type) :: mesh(2)
      type(pair_geometry_type) :: geometry(2)
      !> Number of planets.
      integer :: planets = 0
      !> Angles of the planets from the first one [turns], (planet); as step/whole where `whole` > 0.
      real(dp), allocatable :: turn(:)
      integer, allocatable :: step(:)
      integer :: whole = 0
      !> Distance of the axes of sun and planets, tip diameter of a planet [m].
      real(dp) :: centre_distance = 0, planet_tip = 0
   contains
      procedure :: setup
      procedure :: lag
   end type set_type

contains

   !> Sets all numbers; a list with a wrong number of values leaves the numbers that follow from it at 0.
   subroutine setup(self, set)
      class(set_type), intent(out) :: self
      !> The set as given; its values may be out of range.
      type(planetary_type), intent(in) :: set
      real(dp) :: tip(3)
      integer :: k, planet(2)

      self%has = [set%sun /= '', set%ring /= '']
      do k = 1, 2
         if (.not. self%has(k)) cycle
         call make_mesh(set, k, self%mesh(k))
         self%drawn(k) = has_geometry(self%mesh(k))
         if (self%drawn(k)) call find_geometry(pair_of(self%mesh(k)), self%geometry(k))
      end do
      planet = merge([2, 1], [1, 2], set%driving == 'sun')
      if (all(self%drawn) .and. .not. is_given(set%tip_diameter)) then
         ! Either mesh may shorten the tips of the planets: the smaller diameter holds in both.
         associate (one => self%geometry(1)%tip_diameter, two => self%geometry(2)%tip_diameter)
            tip = [one(3 - planet(1)), min(one(planet(1)), two(planet(2))), two(3 - planet(2))]
            if (abs(one(planet(1)) - two(planet(2))) > rounding*tip(2)) then
               self%mesh(1)%tip_diameter = tip(gears(set, 1))
               self%mesh(2)%tip_diameter = tip(gears(set, 2))
               call find_geometry(pair_of(self%mesh(1)), self%geometry(1))
               call find_geometry(pair_of(self%mesh(2)), self%geometry(2))
            end if
         end associate
      end if
      k = findloc(self%drawn, .true., 1)
      if (k > 0) then
         self%centre_distance = self%geometry(k)%centre_distance
         self%planet_tip = self%geometry(k)%tip_diameter(planet(k))
      end if
      call find_places(set, self)
   end subroutine setup

   !> Sets the places of the planets. Planets between sun and ring can only be where both meshes fit: a whole number of steps of
   !> 1/(z_s + z_r) turns apart.
   pure subroutine find_places(set, self)
      type(planetary_type), intent(in) :: set
      class(set_type), intent(inout) :: self
      integer :: n

      if (is_given(set%angles)) then
         self%planets = size(set%angles)
         self%turn = (set%angles - set%angles(1))/360
         if (all(self%drawn) .and. all(abs(self%turn) < 1000)) then
            self%whole = whole(set%teeth(1) + set%teeth(3))
            self%step = nint(self%turn*self%whole)
         end if
      else
         ! A number out of range has been told; so many planets would take minutes to make.
         self%planets = merge(set%planets, 0, set%planets >= 0 .and. set%planets <= 1000)
         self%whole = self%planets
         self%step = [(n, n=0, self%planets - 1)]
         self%turn = [(real(n, dp)/self%planets, n=0, self%planets - 1)]
      end if
   end subroutine find_places

   !> Lag of a mesh of a planet behind that of the first planet, as a share of the mesh cycle, 0 <= lag < 1.
   pure real(dp) function lag(self, kind, planet, teeth)
      class(set_type), intent(in) :: self
      !> `sun_meshes` or `ring_meshes`; number of the planet; number of teeth of the sun or of the ring.
      integer, intent(in) :: kind, planet, teeth
      integer :: sense

      sense = merge(1, -1, kind == sun_meshes)
      if (self%whole > 0) then
         ! By whole numbers, so that meshes in phase have equal phases.
         lag = real(modulo(sense*int(teeth, int64)*self%step(planet), int(self%whole, int64)), dp)/self%whole
      else
         lag = modulo(sense*teeth*self%turn(planet), 1.0_dp)
      end if
   end function lag

   !> Lag of the ring mesh of a planet behind its sun mesh, as a share of the mesh cycle, -1/2 < lag <= 1/2.
   !>
   !> A pair of flanks passes the pitch point of the sun on the trailing side of a tooth of the planet (where the sun drives), and
   !> the pitch point of the ring, half a turn later, on the leading side of a tooth. In between lie z_p/2 pitches less the
   !> thickness of the tooth at the two working pitch circles (Parker and Lin 2004). The contact of a pair is in its middle after
   !> the pitch point, by half of the difference of the paths of driving and driven tip; `contact_ratio` has this instant at half
   !> of the mesh cycle.
   pure real(dp) function ring_lag(set, numbers)
      !> The set as given.
      type(planetary_type), intent(in) :: set
      !> Its numbers; both meshes are drawn.
      type(set_type), intent(in) :: numbers
      real(dp) :: thickness, shift
      integer :: k

      shift = 0
      if (is_given(set%profile_shift)) shift = set%profile_shift(2)
      associate (z => set%teeth(2), angle => numbers%geometry(1)%transverse_angle)
         thickness = 0
         do k = 1, 2
            ! Half of the angle of a tooth at the working pitch circle.
            thickness = thickness + (pi/2 + 2*shift*tan(set%pressure_angle*pi/180))/z + involute(angle) &
                        - involute(numbers%geometry(k)%working_angle)
         end do
         ring_lag = z/2 - thickness*z/(2*pi)
      end associate
      if (set%driving == 'ring') ring_lag = -ring_lag
      ring_lag = ring_lag + middle(numbers%geometry(2), .true.) - middle(numbers%geometry(1), .false.)
      ring_lag = ring_lag - ceiling(ring_lag - 0.5_dp)
   end function ring_lag

   !> Time from the pitch point to the middle of the contact of a pair, in mesh cycles.
   pure real(dp) function middle(geometry, internal)
      type(pair_geometry_type), intent(in) :: geometry
      logical, intent(in) :: internal
      real(dp) :: path(2)

      associate (g => geometry)
         path = sqrt(max(0.0_dp, g%tip_diameter**2/4 - g%base_radius**2)) - g%base_radius*tan(g%working_angle)
         ! The tip circle of an internal gear lies inside its pitch circle.
         if (internal) path(maxloc(g%base_radius, 1)) = -path(maxloc(g%base_radius, 1))
         middle = (path(1) - path(2))/(2*pi*g%transverse_module*cos(g%transverse_angle))
      end associate
   end function middle

   !> Gears of a mesh as members of the set (1: sun, 2: planet, 3: ring), the driving gear first.
   pure function gears(set, kind)
      type(planetary_type), intent(in) :: set
      integer, intent(in) :: kind
      integer :: gears(2)

      gears = [kind, kind + 1]
      if (set%driving == 'ring') gears = gears([2, 1])
   end function gears

   !> Makes the mesh of the first planet, without name and phase.
   pure subroutine make_mesh(set, kind, mesh)
      type(planetary_type), intent(in) :: set
      !> `sun_meshes` or `ring_meshes`.
      integer, intent(in) :: kind
      type(mesh_type), intent(out) :: mesh
      character(name_length) :: names(3)
      real(dp) :: bore(3)

      names = [set%sun, planet_name(set, 1), set%ring]
      bore = [0.0_dp, set%planet_bore, 0.0_dp]
      associate (gear => gears(set, kind))
         mesh%between = names(gear)
         mesh%carrier = set%carrier
         mesh%internal = kind == ring_meshes
         mesh%teeth = of_gears(set%teeth, gear)
         mesh%profile_shift = of_gears(set%profile_shift, gear)
         mesh%tip_diameter = of_gears(set%tip_diameter, gear)
         mesh%elastic_modulus = of_gears(set%elastic_modulus, gear)
         if (set%planet_bore > 0) mesh%bore = bore(gear)
      end associate
      mesh%normal_module = set%normal_module
      mesh%pressure_angle = set%pressure_angle
      mesh%helix_angle = set%helix_angle
      mesh%face_width = set%face_width
      if (kind == ring_meshes .and. set%ring_face_width > 0) mesh%face_width = set%ring_face_width
      mesh%centre_distance = set%centre_distance
      mesh%dedendum = set%dedendum
      mesh%density = set%density
      mesh%backlash = of_kind(set%backlash, kind)
      mesh%half_backlash = of_kind(set%half_backlash, kind)
      mesh%stiffness = of_kind(set%stiffness, kind)
      mesh%damping_ratio = of_kind(set%damping_ratio, kind)
      mesh%damping_given = is_given(set%damping)
      mesh%damping = of_kind(set%damping, kind)
      mesh%loss_factor = of_kind(set%loss_factor, kind)
      mesh%damping_acts = set%damping_acts
      mesh%contact_ratio = of_kind(set%contact_ratio, kind)
      mesh%stiffness_harmonics = set%stiffness_harmonics
      mesh%order = set%order
      if (kind == sun_meshes) then
         if (allocated(set%sun_stiffness_cos)) mesh%stiffness_cos = set%sun_stiffness_cos
         if (allocated(set%sun_stiffness_sin)) mesh%stiffness_sin = set%sun_stiffness_sin
         if (allocated(set%sun_error_cos)) mesh%error_cos = set%sun_error_cos
         if (allocated(set%sun_error_sin)) mesh%error_sin = set%sun_error_sin
      else
         if (allocated(set%ring_stiffness_cos)) mesh%stiffness_cos = set%ring_stiffness_cos
         if (allocated(set%ring_stiffness_sin)) mesh%stiffness_sin = set%ring_stiffness_sin
         if (allocated(set%ring_error_cos)) mesh%error_cos = set%ring_error_cos
         if (allocated(set%ring_error_sin)) mesh%error_sin = set%ring_error_sin
      end if
   end subroutine make_mesh

   !> Values of two gears of a list of three; none of another list.
   pure function of_gears(list, gear) result(values)
      real(dp), allocatable, intent(in) :: list(:)
      integer, intent(in) :: gear(2)
      real(dp), allocatable :: values(:)

      allocate (values(0))
      if (.not. allocated(list)) return
      if (size(list) == 3) values = list(gear)
   end function of_gears

   !> Value of sun meshes or ring meshes of a list of one or two; 0 of another list.
   pure real(dp) function of_kind(list, kind) result(value)
      real(dp), allocatable, intent(in) :: list(:)
      integer, intent(in) :: kind

      value = 0
      if (.not. allocated(list)) return
      if (size(list) == 1) value = list(1)
      if (size(list) == 2) value = list(kind)
   end function of_kind

   !> Name of the body that is a planet: 'stage 1 planet 2'.
   pure function planet_name(set, n) result(name)
      !> The set.
      type(planetary_type), intent(in) :: set
      !> Number of the planet.
      integer, intent(in) :: n
      character(name_length) :: name

      name = ' planet '//integer_text(n)
      if (allocated(set%name)) name = set%name//name
   end function planet_name

end module geartrain_drawing_planetary_meshes
