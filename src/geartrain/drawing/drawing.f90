!> From the drawing to plain numbers: a train with teeth, diameters and discs becomes a train with radii, stiffnesses, inertias and
!> orders.
!>
!> What is given directly wins over what would be derived. All that computes takes the plain train; files and messages show the
!> train as given.
module geartrain_drawing_drawing
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_numbers, only: whole
   use geartrain_base_variable, only: largest, smallest
   use geartrain_drawing_gear_pair, only: find_geometry, find_stiffness, gear_pair_type, light_load, pair_geometry_type, &
      pair_stiffness_type, rectangular_wave
   use geartrain_train_bearing_rows, only: put_rows
   use geartrain_train_bodies, only: find_ends
   use geartrain_train_body, only: body_type, follows_speed, plain_torque
   use geartrain_train_gear_error, only: gear_error_type, make_plain
   use geartrain_train_kinematics, only: all_toothed, find_kinematics, kinematics_type
   use geartrain_train_mesh, only: has_table, is_given, mesh_type, plain_coupling, plain_mesh
   use geartrain_train_shaft, only: shaft_type
   use geartrain_train_train, only: train_type
   use geartrain_train_turning, only: find_locked
   implicit none (type, external)
   private
   public :: drop_drawing, gears_of, has_discs, has_geometry, has_sections, has_stiffness, pair_of, plain_train

   !> A gear as a disc.
   type :: gear_type
      !> Pitch diameter, face width, bore [m], density [kg/m^3]; number of teeth.
      real(dp) :: diameter = 0, width = 0, bore = 0, density = 0, teeth = 0
   end type gear_type

contains

   !> Makes the plain train, with mesh stiffnesses for full loads; a plain train stays as it is. Values that lack what they would be
   !> derived from stay as given.
   pure subroutine plain_train(train, plain)
      !> The train as given; its values may be out of range.
      type(train_type), intent(in) :: train
      !> The train in plain numbers.
      type(train_type), intent(out) :: plain
      integer :: i

      plain = train
      if (.not. allocated(train%meshes) .or. .not. allocated(train%shafts)) return
      if (allocated(train%bodies)) then
         do i = 1, size(train%bodies)
            call plain_torque(plain%bodies(i))
         end do
      end if
      call put_orders(train, plain)
      call put_inertias(train, plain)
      do i = 1, size(train%shafts)
         if (.not. abs(train%shafts(i)%stiffness) > 0 .and. has_sections(train%shafts(i))) &
            plain%shafts(i)%stiffness = section_stiffness(train%shafts(i))
      end do
      do i = 1, size(train%meshes)
         if (train%meshes(i)%is_coupling) then
            call plain_coupling(plain%meshes(i))
         else if (train%meshes(i)%is_pair()) then
            call put_pair(train%meshes(i), plain%meshes(i))
            if (plain%meshes(i)%locked) call still(plain%meshes(i))
         end if
      end do
      call put_rows(plain%meshes)
   end subroutine plain_train

   !> Removes the dimensions of the gears from a plain train, whose radii, stiffnesses and inertias were derived from them:
   !> `check_train` then accepts the train, and nothing is derived anew when a derived value is changed to 0.
   elemental subroutine drop_drawing(mesh)
      !> A mesh of a plain train.
      type(mesh_type), intent(inout) :: mesh

      if (allocated(mesh%teeth)) deallocate (mesh%teeth)
      if (allocated(mesh%profile_shift)) deallocate (mesh%profile_shift)
      if (allocated(mesh%tip_diameter)) deallocate (mesh%tip_diameter)
      if (allocated(mesh%bore)) deallocate (mesh%bore)
      mesh%normal_module = 0
      mesh%helix_angle = 0
      mesh%face_width = 0
      mesh%centre_distance = 0
      mesh%backlash = 0
   end subroutine drop_drawing

   !> Sets orders of meshes and bodies, the speed and, where they are not given, the characteristic values.
   pure subroutine put_orders(train, plain)
      type(train_type), intent(in) :: train
      type(train_type), intent(inout) :: plain
      type(kinematics_type) :: found
      logical :: excites(size(plain%meshes))
      integer :: i, gear

      if (all_toothed(train)) call find_kinematics(train, found)
      call find_locked(train, found%turning, plain%meshes%locked)
      if (all_toothed(train)) then
         if (found%known) then
            where (train%meshes%order == 0) plain%meshes%order = found%order
            ! With speed_ratio = 0 gears may stand still without a carrier.
            where (train%meshes%is_pair() .and. found%order == 0) plain%meshes%locked = .true.
            do i = 1, size(train%meshes)
               if (.not. train%meshes(i)%is_pair()) cycle
               do gear = 1, 2
                  plain%meshes(i)%gear_error(gear)%order = max(1, found%order(i)/whole(train%meshes(i)%teeth(gear)))
               end do
            end do
            if (allocated(plain%bodies)) plain%bodies%revolution_order = max(1, found%revolution_order)
            plain%speed_ratio = found%speed_ratio
            if (allocated(plain%bodies)) then
               where (follows_speed(plain%bodies)) plain%bodies%turns = abs(found%turning%speed)*found%speed_ratio
            end if
            if (.not. abs(train%characteristic_frequency) > 0) &
               plain%characteristic_frequency = 2*pi/60/found%speed_ratio
         end if
         if (.not. abs(train%characteristic_length) > 0) plain%characteristic_length = 1e-6_dp
      end if
      where (plain%meshes%order == 0 .and. .not. plain%meshes%locked) plain%meshes%order = 1
      ! A coupling, a bearing or a mesh whose teeth stand still excites nothing: its order is one that there is.
      excites = plain%meshes%is_pair() .and. .not. plain%meshes%locked
      where (.not. excites) plain%meshes%order = merge(minval(plain%meshes%order, excites), 1, any(excites))
   end subroutine put_orders

   !> Leaves the means of a mesh whose teeth stand still in each other: at which place of the cycle they do is not known.
   elemental subroutine still(mesh)
      !> A plain mesh.
      type(mesh_type), intent(inout) :: mesh
      integer :: gear

      mesh%stiffness_cos = [real(dp) ::]
      mesh%stiffness_sin = [real(dp) ::]
      mesh%error_cos = [real(dp) ::]
      mesh%error_sin = [real(dp) ::]
      if (allocated(mesh%stage_cos)) mesh%stage_cos(:, :) = 0
      if (allocated(mesh%stage_sin)) mesh%stage_sin(:, :) = 0
      do gear = 1, 2
         mesh%stiffness = mesh%stiffness*mesh%gear_error(gear)%factor_mean
         mesh%gear_error(gear) = gear_error_type()
      end do
   end subroutine still

   !> Sets radii, half backlash, stiffness and harmonics of a mesh.
   pure subroutine put_pair(mesh, plain)
      !> The mesh as given.
      type(mesh_type), intent(in) :: mesh
      !> The mesh; its order is set.
      type(mesh_type), intent(inout) :: plain
      type(gear_pair_type) :: pair
      type(pair_geometry_type) :: geometry
      type(pair_stiffness_type) :: stiffness
      real(dp) :: mean, ratio, smoothing, overlap
      integer :: h

      ratio = mesh%contact_ratio
      overlap = 0
      if (has_geometry(mesh)) then
         pair = pair_of(mesh)
         call find_geometry(pair, geometry)
         if (.not. abs(mesh%driving_radius) > 0) plain%driving_radius = geometry%base_radius(1)
         if (.not. abs(mesh%driven_radius) > 0) plain%driven_radius = geometry%base_radius(2)
         if (.not. abs(mesh%half_backlash) > 0) plain%half_backlash = geometry%half_backlash
         if (mesh%contact_ratio > 0) geometry%contact_ratio = mesh%contact_ratio
         ratio = geometry%contact_ratio
         overlap = geometry%overlap_ratio
         if (has_stiffness(mesh)) then
            call find_stiffness(pair, geometry, 0.0_dp, stiffness)
            plain%stiffness = stiffness%mesh*mesh%face_width
            plain%light_force = light_load*mesh%face_width/cos(geometry%transverse_angle)
         end if
         if (.not. (is_given(mesh%stiffness_cos) .or. is_given(mesh%stiffness_sin) .or. has_table(mesh))) then
            plain%stiffness_cos = [(rectangular_wave(h, geometry%contact_ratio, geometry%overlap_ratio), &
                                    h=1, mesh%stiffness_harmonics)]
            plain%contact_ratio = 0
         end if
      end if
      smoothing = 0
      if (mesh%pitch_error_form == 'steps') smoothing = ratio
      if (allocated(plain%teeth)) then
         if (size(plain%teeth) == 2) then
            do h = 1, 2
               call make_plain(plain%gear_error(h), max(1.0_dp, plain%teeth(h)), plain%phase, &
                               middle_of_contact(ratio), smoothing, overlap, plain%stiffness_harmonics, mean)
               plain%error_mean = plain%error_mean + mean
            end do
         end if
         deallocate (plain%teeth)
      end if
      plain%backlash = 0
      call plain_mesh(plain)
   end subroutine put_pair

   !> Middle of the contact of the first tooth [mesh cycles]: at phase 0 is the middle of the time with the extra tooth pair, in
   !> which a tooth comes into contact; of two pairs one bears alone half a cycle later.
   pure real(dp) function middle_of_contact(contact_ratio) result(middle)
      !> Contact ratio [1]; 0: not known, 1 to 2.
      real(dp), intent(in) :: contact_ratio

      middle = 0.5_dp
      if (contact_ratio > 0) middle = modulo(int(contact_ratio), 2)/2.0_dp
   end function middle_of_contact

   !> The drawing of a gear pair, with angles in rad.
   pure type(gear_pair_type) function pair_of(mesh) result(pair)
      !> A mesh that `has_geometry`.
      type(mesh_type), intent(in) :: mesh

      pair%teeth = whole(mesh%teeth)
      pair%internal = mesh%internal
      pair%normal_module = mesh%normal_module
      pair%face_width = mesh%face_width
      pair%pressure_angle = mesh%pressure_angle*pi/180
      pair%helix_angle = mesh%helix_angle*pi/180
      if (is_given(mesh%profile_shift)) pair%profile_shift = mesh%profile_shift
      pair%centre_distance = mesh%centre_distance
      if (is_given(mesh%tip_diameter)) pair%tip_diameter = mesh%tip_diameter
      pair%dedendum = mesh%dedendum
      pair%backlash = mesh%backlash
      if (is_given(mesh%elastic_modulus)) pair%elastic_modulus = mesh%elastic_modulus
   end function pair_of

   !> Whether teeth and module of a gear pair are given, no list of its drawing has a wrong number of values, and all values are in
   !> the ranges of their variables.
   pure logical function has_geometry(mesh)
      !> The mesh as given.
      type(mesh_type), intent(in) :: mesh

      has_geometry = is_given(mesh%teeth) .and. mesh%normal_module >= smallest
      if (has_geometry) has_geometry = size(mesh%teeth) == 2 .and. pair(mesh%profile_shift) .and. pair(mesh%tip_diameter) .and. &
                                       pair(mesh%elastic_modulus) .and. pair(mesh%bore)
      if (has_geometry) has_geometry = all(mesh%teeth >= 1 .and. mesh%teeth <= 1e5_dp) .and. &
         mesh%pressure_angle >= 10 .and. mesh%pressure_angle <= 35 .and. mesh%helix_angle >= 0 .and. mesh%helix_angle <= 60 .and. &
         all([mesh%normal_module, mesh%centre_distance, mesh%backlash, mesh%face_width, mesh%density] >= 0 .and. &
             [mesh%normal_module, mesh%centre_distance, mesh%backlash, mesh%face_width, mesh%density] <= largest) .and. &
         mesh%dedendum >= 1 .and. mesh%dedendum <= 2 .and. within(mesh%profile_shift, -2.0_dp, 2.0_dp) .and. &
         within(mesh%tip_diameter, 0.0_dp, largest) .and. within(mesh%bore, 0.0_dp, largest) .and. &
         within(mesh%elastic_modulus, smallest, largest)
      if (has_geometry .and. mesh%internal) has_geometry = whole(mesh%teeth(1)) /= whole(mesh%teeth(2))

   contains

      pure logical function pair(list)
         real(dp), allocatable, intent(in) :: list(:)

         pair = .true.
         if (is_given(list)) pair = size(list) == 2
      end function pair

   end function has_geometry

   !> Whether the stiffness of a mesh follows from its drawing.
   pure logical function has_stiffness(mesh)
      !> The mesh as given.
      type(mesh_type), intent(in) :: mesh

      has_stiffness = has_geometry(mesh) .and. mesh%face_width > 0 .and. .not. (abs(mesh%stiffness) > 0 .or. has_table(mesh))
   end function has_stiffness

   !> Whether diameters and lengths of the sections of a shaft are given, as many of each.
   pure logical function has_sections(shaft)
      !> The shaft as given.
      type(shaft_type), intent(in) :: shaft

      has_sections = is_given(shaft%diameter) .and. is_given(shaft%length)
      if (has_sections) has_sections = size(shaft%diameter) == size(shaft%length)
      if (has_sections) has_sections = fits(shaft%bore, size(shaft%diameter)) .and. within(shaft%diameter, smallest, largest) &
         .and. within(shaft%length, smallest, largest) .and. within(shaft%bore, 0.0_dp, largest) .and. &
         shaft%shear_modulus > 0 .and. shaft%shear_modulus <= largest
      if (has_sections) has_sections = all(values_of(shaft%bore, size(shaft%diameter), 0.0_dp) < shaft%diameter)
   end function has_sections

   !> Torsional stiffness of sections in series [N m/rad]: 1/k = sum of 32 l/(pi G (D^4 - d^4)).
   pure real(dp) function section_stiffness(shaft) result(stiffness)
      !> A shaft that `has_sections`.
      type(shaft_type), intent(in) :: shaft

      associate (d => values_of(shaft%bore, size(shaft%diameter), 0.0_dp))
         stiffness = pi*shaft%shear_modulus/32/sum(shaft%length/(shaft%diameter**4 - d**4))
      end associate
   end function section_stiffness

   !> Whether discs of a body are given, as many diameters as widths.
   pure logical function has_discs(body)
      !> The body as given.
      type(body_type), intent(in) :: body

      has_discs = is_given(body%outer_diameter) .and. is_given(body%width)
      if (has_discs) has_discs = size(body%outer_diameter) == size(body%width)
      if (has_discs) has_discs = fits(body%bore, size(body%width)) .and. fits(body%density, size(body%width)) .and. &
         within(body%outer_diameter, 0.0_dp, largest) .and. within(body%width, 0.0_dp, largest) .and. &
         within(body%bore, 0.0_dp, largest) .and. within(body%density, 0.0_dp, largest)
      if (has_discs) has_discs = all(values_of(body%bore, size(body%width), 0.0_dp) < body%outer_diameter)
   end function has_discs

   !> Whether all values of a list are in a range; true without values.
   pure logical function within(list, least, most)
      real(dp), allocatable, intent(in) :: list(:)
      real(dp), intent(in) :: least, most

      within = .true.
      if (is_given(list)) within = all(list >= least .and. list <= most)
   end function within

   !> Whether a list has no value, one value for all or n values.
   pure logical function fits(list, n)
      real(dp), allocatable, intent(in) :: list(:)
      integer, intent(in) :: n

      fits = .true.
      if (is_given(list)) fits = size(list) == 1 .or. size(list) == n
   end function fits

   !> The n values of a list that `fits`.
   pure function values_of(list, n, default) result(values)
      real(dp), allocatable, intent(in) :: list(:)
      integer, intent(in) :: n
      real(dp), intent(in) :: default
      real(dp) :: values(n)

      values = default
      if (.not. is_given(list)) return
      if (size(list) == 1) values = list(1)
      if (size(list) == n) values = list
   end function values_of

   !> Polar moment of inertia of a disc with a bore [kg m^2]: pi rho b (D^4 - d^4)/32.
   elemental real(dp) function disc_inertia(outer_diameter, bore, width, density)
      !> Diameters and width [m], density [kg/m^3].
      real(dp), intent(in) :: outer_diameter, bore, width, density

      disc_inertia = pi*density*width*(outer_diameter**4 - bore**4)/32
   end function disc_inertia

   !> Inertia of the discs of a body [kg m^2].
   pure real(dp) function drawn_inertia(body) result(inertia)
      !> A body that `has_discs`.
      type(body_type), intent(in) :: body

      associate (n => size(body%width))
         inertia = sum(disc_inertia(body%outer_diameter, values_of(body%bore, n, 0.0_dp), body%width, &
                                    values_of(body%density, n, 7850.0_dp)))
      end associate
   end function drawn_inertia

   !> Sets the inertias that are not given: of a body by its discs, else by its gears, with what it carries; of a
   !> gear in a chain by its own disc.
   pure subroutine put_inertias(train, plain)
      type(train_type), intent(in) :: train
      type(train_type), intent(inout) :: plain
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      real(dp) :: inertia(2)
      integer :: i

      if (.not. allocated(train%bodies)) then
         do i = 1, size(train%meshes)
            inertia = gear_inertias(train%meshes(i))
            if (.not. abs(train%meshes(i)%driving_inertia) > 0) plain%meshes(i)%driving_inertia = inertia(1)
            if (.not. abs(train%meshes(i)%driven_inertia) > 0) plain%meshes(i)%driven_inertia = inertia(2)
         end do
         return
      end if
      call find_ends(train, shaft_ends, mesh_ends)
      do i = 1, size(train%bodies)
         if (.not. train%bodies(i)%inertia < 0) cycle
         if (has_discs(train%bodies(i))) then
            plain%bodies(i)%inertia = drawn_inertia(train%bodies(i))
         else
            associate (gears => gears_of(train, mesh_ends, i))
               if (size(gears, 2) > 0) plain%bodies(i)%inertia = sum(disc_inertia(gears(1, :), gears(2, :), gears(3, :), &
                                                                                  gears(4, :)))
            end associate
         end if
      end do
      where (.not. plain%bodies%inertia < 0)
         plain%bodies%inertia = plain%bodies%inertia + plain%bodies%added_inertia
         plain%bodies%added_inertia = 0
      end where
   end subroutine put_inertias

   !> The gears on a body as discs: pitch diameter, bore, width [m] and density [kg/m^3], (4, gear). A gear of a body in two meshes
   !> counts once: the same number of teeth, module, helix angle, width, bore and density.
   pure function gears_of(train, mesh_ends, body) result(discs)
      !> The train as given.
      type(train_type), intent(in) :: train
      !> Bodies that each mesh joins, (2, mesh).
      integer, intent(in) :: mesh_ends(:, :)
      !> Number of the body.
      integer, intent(in) :: body
      real(dp), allocatable :: discs(:, :)
      type(gear_type) :: gears(2), gear
      real(dp) :: list(4, 2*size(train%meshes)), teeth(2*size(train%meshes))
      integer :: h, i, k, n

      n = 0
      do i = 1, size(train%meshes)
         if (.not. any(mesh_ends(:, i) == body)) cycle
         if (.not. has_geometry(train%meshes(i)) .or. .not. train%meshes(i)%face_width > 0) cycle
         call find_gears(train%meshes(i), gears)
         do k = 1, 2
            if (mesh_ends(k, i) /= body .or. is_ring(train%meshes(i), k)) cycle
            gear = gears(k)
            associate (disc => [gear%diameter, gear%bore, gear%width, gear%density])
               if (any([(all(abs(list(:, h) - disc) <= 1e-9_dp*abs(disc)) .and. whole(teeth(h)) == whole(gear%teeth), &
                         h=1, n)])) cycle
               n = n + 1
               list(:, n) = disc
               teeth(n) = gear%teeth
            end associate
         end do
      end do
      discs = list(:, :n)
   end function gears_of

   !> The two gears of a mesh that `has_geometry` as discs.
   pure subroutine find_gears(mesh, gears)
      type(mesh_type), intent(in) :: mesh
      type(gear_type), intent(out) :: gears(2)

      gears%teeth = mesh%teeth
      gears%diameter = mesh%teeth*mesh%normal_module/cos(mesh%helix_angle*pi/180)
      gears%width = mesh%face_width
      gears%density = mesh%density
      if (is_given(mesh%bore)) gears%bore = mesh%bore
   end subroutine find_gears

   !> Inertias of the two gears of a mesh as discs [kg m^2]; 0: not drawn.
   pure function gear_inertias(mesh) result(inertia)
      !> The mesh as given.
      type(mesh_type), intent(in) :: mesh
      real(dp) :: inertia(2)
      type(gear_type) :: gears(2)

      inertia = 0
      if (.not. has_geometry(mesh) .or. .not. mesh%face_width > 0) return
      call find_gears(mesh, gears)
      inertia = disc_inertia(gears%diameter, gears%bore, gears%width, gears%density)
      where ([is_ring(mesh, 1), is_ring(mesh, 2)]) inertia = 0
   end function gear_inertias

   !> Whether gear k of a mesh is an internal gear, which is no disc.
   pure logical function is_ring(mesh, k)
      type(mesh_type), intent(in) :: mesh
      integer, intent(in) :: k

      is_ring = mesh%internal .and. mesh%teeth(k) > mesh%teeth(3 - k)
   end function is_ring

end module geartrain_drawing_drawing
