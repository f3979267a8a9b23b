!> Warnings of a drawing: where a formula is used outside the range that its source gives, where teeth are cut or meet as no
!> involute, where the magnitude of a number is that of another unit, and where parts do not fit one another.
module geartrain_report_drawing_warnings
   use geartrain_base_field, only: text_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_numbers, only: integer_text, real_text, short => text
   use geartrain_mesh_law_law, only: law_type
   use geartrain_train_bodies, only: find_ends
   use geartrain_train_body, only: body_type, follows_speed
   use geartrain_report_add_warning, only: add_warning
   use geartrain_report_damping_warnings, only: warn_of_damping_of_modes, warn_of_joined_inertias
   use geartrain_drawing_drawing, only: has_discs, has_geometry, has_sections, has_stiffness, pair_of, plain_train
   use geartrain_drawing_gear_pair, only: find_geometry, find_stiffness, light_load, pair_geometry_type, pair_stiffness_type
   use geartrain_network_light_loads, only: reduce_light_loads
   use geartrain_train_gear_error, only: gear_words, has_tooth_factors
   use geartrain_train_kinematics, only: all_toothed, find_kinematics, kinematics_type
   use geartrain_train_mesh, only: is_given, mesh_type, put_law
   use geartrain_report_planetary_warnings, only: warn_of_planet_loads, warn_of_planets
   use geartrain_train_shaft, only: shaft_type
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: find_warnings, warnings_text

   !> Largest line load of ISO 6336-1, method B [N/m].
   real(dp), parameter :: heavy_load = 1.6e6_dp
   !> Modules of gears [m]; ISO 54 lists 1 to 50 mm, watches have 0.05 mm.
   real(dp), parameter :: least_module = 5e-5_dp, most_module = 0.1_dp
   !> Diameters of shafts, of other discs, and lengths of shafts that are larger than those of ships and hydroelectric plants [m].
   real(dp), parameter :: most_diameter = 3, most_disc = 25, most_length = 100
   !> Densities beyond those of wood and of heavy metal [kg/m^3].
   real(dp), parameter :: least_density = 500, most_density = 25000
   !> Damping ratio from which on nothing oscillates.
   real(dp), parameter :: critical = 1
   !> Factor by which a given mesh stiffness is hardly ever off that of the drawing [1].
   real(dp), parameter :: far_off = 20
   !> Overlap of flanks at the given centre distance that is no rounding, over the normal module [1].
   real(dp), parameter :: least_thinning = 1e-3_dp
   !> Samples of a mesh stiffness for each harmonic.
   integer, parameter :: samples_per_harmonic = 32
   character(*), parameter :: in_metres = 'the unit is the metre '

contains

   !> The warnings as text, a line each.
   subroutine warnings_text(train, text)
      !> A train that has passed `check_train`.
      type(train_type), intent(in) :: train
      !> Lines; '' without warnings.
      character(:), allocatable, intent(out) :: text
      type(text_type), allocatable :: warnings(:)
      integer :: i

      call find_warnings(train, warnings)
      text = ''
      do i = 1, size(warnings)
         text = text//warnings(i)%text//new_line('a')
      end do
   end subroutine warnings_text

   !> Lists where a formula is used outside the range that its source gives, where teeth are cut or meet as no involute, where the
   !> magnitude of a number is that of another unit, and where parts do not fit one another.
   subroutine find_warnings(train, warnings)
      !> A train that has passed `check_train`.
      type(train_type), intent(in) :: train
      !> A sentence each.
      type(text_type), allocatable, intent(out) :: warnings(:)
      type(train_type) :: plain
      logical :: slips
      integer :: i

      allocate (warnings(0))
      if (allocated(train%bodies)) then
         do i = 1, size(train%bodies)
            if (has_discs(train%bodies(i))) call warn_of_body(train%bodies(i), i, warnings)
         end do
      end if
      do i = 1, size(train%shafts)
         if (has_sections(train%shafts(i))) call warn_of_shaft(train%shafts(i), i, warnings)
      end do
      call plain_train(train, plain)
      call warn_of_degrees(train, warnings)
      call warn_of_negative_stiffness(plain, warnings)
      slips = size(warnings) > 0
      call warn_of_joined_inertias(train, plain, warnings)
      if (any([(has_geometry(train%meshes(i)), i=1, size(train%meshes))])) call warn_of_drawing(train, plain, slips, warnings)
      ! Modes follow from the numbers: where these may be in another unit, they say nothing.
      if (.not. slips) call warn_of_damping_of_modes(train, warnings)
      call warn_of_planets(train, plain, warnings)
      if (all_toothed(train)) call warn_of_nearby_orders(train, warnings)
      if (.not. allocated(train%bodies)) return
      do i = 1, size(train%bodies)
         ! The exponent may be 0 on purpose, as at a point of a study, or forgotten.
         if (train%bodies(i)%torque_speed > 0 .and. .not. follows_speed(train%bodies(i))) call add_warning(warnings, 'body', i, &
            'torque_speed has no effect where torque_speed_exponent is 0: the mean torque is the same at all speeds')
      end do
   end subroutine find_warnings

   !> Warns of phases that are whole numbers of degrees.
   subroutine warn_of_degrees(train, warnings)
      type(train_type), intent(in) :: train
      type(text_type), allocatable, intent(inout) :: warnings(:)
      integer :: i

      do i = 1, size(train%meshes)
         call warn('phase', train%meshes(i)%phase)
         call warn('back_phase', train%meshes(i)%back_phase)
      end do

   contains

      subroutine warn(name, phase)
         character(*), intent(in) :: name
         real(dp), intent(in) :: phase

         if (abs(phase) > 2*pi .and. abs(phase - anint(phase)) <= 0) call add_warning(warnings, 'mesh', i, name//' = '// &
            real_text(phase)//': the unit is the radian of the mesh cycle (180 degrees are 3.14159)')
      end subroutine warn

   end subroutine warn_of_degrees

   !> Warns where the mesh frequencies are not quite those of the teeth.
   subroutine warn_of_nearby_orders(train, warnings)
      type(train_type), intent(in) :: train
      type(text_type), allocatable, intent(inout) :: warnings(:)
      type(kinematics_type) :: found
      character(:), allocatable :: words
      integer :: fastest

      call find_kinematics(train, found)
      if (.not. found%order_error > 0) return
      fastest = maxloc(found%order, 1)
      if (found%exact_order(fastest) == 0) then
         words = 'by the teeth all meshes together repeat themselves after millions of cycles of this mesh'
         if (allocated(train%bodies)) then
            if (any(train%bodies%ratio_given)) words = 'by speed_ratio the meshes have no common period'
         end if
      else
         words = 'by the teeth all meshes together repeat themselves after '//integer_text(found%exact_order(fastest))// &
                 ' cycles of this mesh'
      end if
      call add_warning(warnings, 'mesh', fastest, words//'; the mesh frequencies are taken '// &
                       short(found%order_error)//' off at most (relative), by which they repeat themselves after '// &
                       integer_text(found%order(fastest)))
   end subroutine warn_of_nearby_orders

   !> Warns of meshes that are given by their drawing.
   subroutine warn_of_drawing(train, plain, slips, warnings)
      type(train_type), intent(in) :: train
      !> The plain train; its mesh stiffnesses get those of their loads.
      type(train_type), intent(inout) :: plain
      !> Whether the magnitude of some number is that of another unit; set where it is one of a mesh.
      logical, intent(inout) :: slips
      type(text_type), allocatable, intent(inout) :: warnings(:)
      type(system_type) :: system
      real(dp), allocatable :: light(:)
      logical :: unloaded, agreed
      integer :: i, before

      before = size(warnings)
      call warn_of_shafts_in_gears(train, warnings)
      slips = slips .or. size(warnings) > before
      call warn_of_gaps(plain, warnings)
      call reduce_light_loads(plain, light, agreed)
      call build_system(train, system)
      unloaded = .not. any(abs(system%static_force(system%mesh_element)) > 0)
      if (unloaded .and. any([(has_stiffness(train%meshes(i)), i=1, size(train%meshes))])) call add_warning(warnings, 'train', 0, &
         'no mesh carries a load, as no body has a mean torque: teeth float in their gaps, and stiffnesses by ISO 6336-1 are those &
         &at 100 N/mm; give the torque of the driving body')
      do i = 1, size(train%meshes)
         if (.not. has_geometry(train%meshes(i))) cycle
         before = size(warnings)
         call warn_of_units(train%meshes(i), i, warnings)
         slips = slips .or. size(warnings) > before
         call warn_of_mesh(train%meshes(i), i, system, light(i), warnings)
      end do
      call warn_of_planet_loads(train, plain, system, agreed, warnings)
   end subroutine warn_of_drawing

   !> Warns of a mesh stiffness that becomes negative: its amplitudes may be in N/m instead of shares of the mean stiffness.
   subroutine warn_of_negative_stiffness(plain, warnings)
      type(train_type), intent(in) :: plain
      type(text_type), allocatable, intent(inout) :: warnings(:)
      type(law_type) :: law
      real(dp) :: least
      integer :: i, k, s, samples, cycle_order

      do i = 1, size(plain%meshes)
         ! The unit of displacement does not matter for kappa.
         call put_law(plain%meshes(i), 1.0_dp, law)
         if (size(law%harmonic) == 0) cycle
         ! With equal teeth a cycle is enough: all harmonics are multiples of its order. That of a missing tooth falls below 0.
         cycle_order = merge(1, nint(law%order), any(has_tooth_factors(plain%meshes(i)%gear_error)))
         samples = samples_per_harmonic*maxval(law%harmonic)/cycle_order
         do s = law%lowest, law%highest
            if (.not. law%stiffness(s) > 0) cycle
            least = minval([(law%stiffness_at(s, 2*pi*k/(real(samples, dp)*cycle_order)), k=1, samples)])/law%stiffness(s)
            if (least > merge(-0.01_dp, 0.0_dp, any(has_tooth_factors(plain%meshes(i)%gear_error)))) cycle
            call add_warning(warnings, 'mesh', i, 'the mesh stiffness falls to '//short(least)//' times its mean: &
                             &stiffness_cos and stiffness_sin are shares of the mean stiffness')
            exit
         end do
      end do
   end subroutine warn_of_negative_stiffness

   subroutine warn_of_body(body, i, warnings)
      type(body_type), intent(in) :: body
      integer, intent(in) :: i
      type(text_type), allocatable, intent(inout) :: warnings(:)

      if (any(body%outer_diameter > most_disc)) call add_warning(warnings, 'body', i, 'outer_diameter = '// &
         real_text(maxval(body%outer_diameter))//': '//in_metres//'(300 mm are 0.3)')
      if (any(body%width > most_disc)) call add_warning(warnings, 'body', i, 'width = '//real_text(maxval(body%width))//': '// &
                                                        in_metres//'(50 mm are 0.05)')
      if (is_given(body%density)) call warn_of_density(body%density, 'body', i, warnings)
   end subroutine warn_of_body

   subroutine warn_of_shaft(shaft, i, warnings)
      type(shaft_type), intent(in) :: shaft
      integer, intent(in) :: i
      type(text_type), allocatable, intent(inout) :: warnings(:)

      if (any(shaft%diameter > most_diameter)) call add_warning(warnings, 'shaft', i, 'diameter = '// &
         real_text(maxval(shaft%diameter))//': '//in_metres//'(30 mm are 0.03)')
      if (any(shaft%length > most_length)) call add_warning(warnings, 'shaft', i, 'length = '// &
                                                            real_text(maxval(shaft%length))//': '//in_metres//'(150 mm are 0.15)')
      if (.not. (shaft%rigid .or. shaft%damping_given)) call warn_of_damping(shaft%damping_ratio, 'shaft', i, warnings)
   end subroutine warn_of_shaft

   !> Shafts that are thicker than a gear on either end.
   subroutine warn_of_shafts_in_gears(train, warnings)
      type(train_type), intent(in) :: train
      type(text_type), allocatable, intent(inout) :: warnings(:)
      type(pair_geometry_type) :: geometry
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      integer :: i, j, k

      call find_ends(train, shaft_ends, mesh_ends)
      do i = 1, size(train%shafts)
         associate (shaft => train%shafts(i))
            if (.not. has_sections(shaft)) cycle
            ! Told as beyond any shaft.
            if (any(shaft%diameter > most_diameter)) cycle
            gears: do j = 1, size(train%meshes)
               if (.not. has_geometry(train%meshes(j))) cycle
               call find_geometry(pair_of(train%meshes(j)), geometry)
               do k = 1, 2
                  if (.not. any(shaft_ends(:, i) == mesh_ends(k, j))) cycle
                  if (train%meshes(j)%internal .and. train%meshes(j)%teeth(k) > train%meshes(j)%teeth(3 - k)) cycle
                  if (.not. minval(shaft%diameter) > geometry%tip_diameter(k)) cycle
                  call add_warning(warnings, 'shaft', i, 'diameter = '//real_text(minval(shaft%diameter))//': thicker than the &
                     &gear of '//integer_text(nint(train%meshes(j)%teeth(k)))//' teeth at its end, whose tip diameter is '// &
                     short(geometry%tip_diameter(k))//' m (28 mm are 0.028)')
                  exit gears
               end do
            end do gears
         end associate
      end do
   end subroutine warn_of_shafts_in_gears

   !> Meshes without backlash beside meshes that have it.
   subroutine warn_of_gaps(plain, warnings)
      !> The plain train.
      type(train_type), intent(in) :: plain
      type(text_type), allocatable, intent(inout) :: warnings(:)
      integer :: i

      if (.not. any(plain%meshes%half_backlash > 0 .and. plain%meshes%is_pair())) return
      do i = 1, size(plain%meshes)
         if (.not. plain%meshes(i)%is_pair()) cycle
         if (.not. plain%meshes(i)%half_backlash > 0) call add_warning(warnings, 'mesh', i, 'has no backlash, although other &
            &meshes have it: its teeth cannot separate (60 um are backlash = 60e-6)')
      end do
   end subroutine warn_of_gaps

   subroutine warn_of_density(density, group, i, warnings)
      real(dp), intent(in) :: density(:)
      character(*), intent(in) :: group
      integer, intent(in) :: i
      type(text_type), allocatable, intent(inout) :: warnings(:)
      integer :: bad

      bad = findloc(density >= least_density .and. density <= most_density, .false., 1)
      if (bad > 0) call add_warning(warnings, group, i, 'density = '//real_text(density(bad))// &
                                    ': the unit is kg/m^3 (steel: 7850)')
   end subroutine warn_of_density

   subroutine warn_of_damping(ratio, group, i, warnings)
      real(dp), intent(in) :: ratio
      character(*), intent(in) :: group
      integer, intent(in) :: i
      type(text_type), allocatable, intent(inout) :: warnings(:)

      if (ratio >= critical) call add_warning(warnings, group, i, 'damping_ratio = '//real_text(ratio)//': from 1 on nothing &
                                              &oscillates (5 % are 0.05)')
   end subroutine warn_of_damping

   !> Numbers of a mesh whose magnitude is that of another unit.
   subroutine warn_of_units(mesh, i, warnings)
      type(mesh_type), intent(in) :: mesh
      integer, intent(in) :: i
      type(text_type), allocatable, intent(inout) :: warnings(:)
      type(pair_geometry_type) :: geometry
      type(pair_stiffness_type) :: stiffness
      real(dp), allocatable :: mean(:)
      real(dp) :: gap
      integer :: gear

      if (mesh%helix_angle > 0 .and. mesh%helix_angle < 1) call add('helix_angle', mesh%helix_angle, 'the unit is the degree')
      if (.not. mesh%damping_given) call warn_of_damping(mesh%damping_ratio, 'mesh', i, warnings)
      call warn_of_density([mesh%density], 'mesh', i, warnings)
      associate (module => mesh%normal_module)
         if (module < least_module .or. module > most_module) then
            ! The other lengths are compared with the module.
            call add('normal_module', module, in_metres//'(2.5 mm are 2.5e-3)')
            return
         end if
         call find_geometry(pair_of(mesh), geometry)
         if (mesh%face_width > 5*minval(geometry%reference_diameter) .or. mesh%face_width > 0 .and. mesh%face_width < module/10) &
            call add('face_width', mesh%face_width, 'beside a pitch diameter of '//short(minval(geometry%reference_diameter))// &
                     ' m; '//in_metres//'(40 mm are 0.04)')
         gap = 2*geometry%half_backlash
         if (mesh%half_backlash > 0) gap = 2*mesh%half_backlash
         if (gap > module/2) then
            if (mesh%half_backlash > 0) then
               call add('half_backlash', mesh%half_backlash, 'the backlash is more than half a module; '//in_metres// &
                        '(30 um are 30e-6)')
            else if (mesh%backlash > 0) then
               call add('backlash', mesh%backlash, 'more than half a module; '//in_metres//'(60 um are 60e-6)')
            else
               call add('centre_distance', mesh%centre_distance, 'makes a backlash of more than half a module: '//short(gap)// &
                        ' m along the line of action')
            end if
         end if
         if (mesh%stiffness > 0 .and. mesh%face_width > 0) then
            call find_stiffness(pair_of(mesh), geometry, 0.0_dp, stiffness)
            associate (drawn => stiffness%mesh*mesh%face_width)
               if (mesh%stiffness > far_off*drawn .or. mesh%stiffness < drawn/far_off) call add('stiffness', mesh%stiffness, &
                  'by ISO 6336-1 the teeth as drawn have '//short(drawn)//'; N/m are meant (600 N/um are 600e6)')
            end associate
         end if
         mean = [mesh%error_mean]
         call warn_of_error('error_mean', mean)
         call warn_of_error('error_cos', mesh%error_cos)
         call warn_of_error('error_sin', mesh%error_sin)
         call warn_of_error('error_table', mesh%error_table)
         do gear = 1, 2
            associate (error => mesh%gear_error(gear))
               call warn_of_error(trim(gear_words(gear))//'_pitch_error', error%pitch)
               call warn_of_error(trim(gear_words(gear))//'_error_cos', error%cosine)
               call warn_of_error(trim(gear_words(gear))//'_error_sin', error%sine)
               if (error%runout > max(gap, mesh%normal_module/10)) call add(trim(gear_words(gear))//'_runout', error%runout, &
                  'more than the backlash and a tenth of the module; '//in_metres//'(10 um are 10e-6)')
            end associate
         end do
      end associate

   contains

      subroutine warn_of_error(name, amplitudes)
         character(*), intent(in) :: name
         real(dp), allocatable, intent(in) :: amplitudes(:)

         if (.not. is_given(amplitudes)) return
         if (maxval(abs(amplitudes)) > max(gap, mesh%normal_module/10)) &
            call add(name, amplitudes(maxloc(abs(amplitudes), 1)), 'more than the backlash and a tenth of the module; '// &
                     in_metres//'(3 um are 3e-6)')
      end subroutine warn_of_error

      subroutine add(name, value, sentence)
         character(*), intent(in) :: name, sentence
         real(dp), intent(in) :: value

         call add_warning(warnings, 'mesh', i, name//' = '//real_text(value)//': '//sentence)
      end subroutine add

   end subroutine warn_of_units

   subroutine warn_of_mesh(mesh, i, system, light, warnings)
      type(mesh_type), intent(in) :: mesh
      integer, intent(in) :: i
      type(system_type), intent(in) :: system
      !> Factor of the mesh stiffness by a light load [1].
      real(dp), intent(in) :: light
      type(text_type), allocatable, intent(inout) :: warnings(:)
      type(pair_geometry_type) :: geometry
      real(dp) :: shift(2), line_load
      integer :: k, n

      n = system%mesh_element(i)
      associate (g => geometry)
         call find_geometry(pair_of(mesh), geometry)
         do k = 1, 2
            if (g%undercut(k) > 0) call add('the gear of '//integer_text(nint(mesh%teeth(k)))//' teeth is undercut: its profile &
               &shift is '//short(g%undercut(k))//' below the smallest one without undercut; contact ratio and stiffness &
               &hold for complete involutes')
         end do
         if (g%clear_of_base < 0) call add('the tip of a gear reaches '//short(-g%clear_of_base)//' m beyond the base circle of &
            &its mate along the line of action: the flanks interfere')
         if (g%distance_backlash < -least_thinning*mesh%normal_module) call add('centre_distance = '// &
            real_text(mesh%centre_distance)//': teeth of full thickness touch at '//short(g%tight_distance)// &
            ' m already: the backlash takes teeth that are thinner by '//short(-g%distance_backlash)//' m on top of it')
         if (.not. has_stiffness(mesh)) return
         shift = 0
         if (is_given(mesh%profile_shift)) shift = mesh%profile_shift
         if (mesh%teeth(1) > mesh%teeth(2)) shift = shift([2, 1])
         if (shift(1) < shift(2)) call add('the stiffness by ISO 6336-1 holds where the profile shift of the pinion is not &
            &smaller than the profile shift of the wheel; here they are '//short(shift(1))//' and '//short(shift(2)))
         call add_outside(sum(shift) < -0.5_dp .or. sum(shift) > 2, 'profile shifts with a sum from -0.5 to 2', sum(shift), '')
         call add_outside(abs(mesh%helix_angle) > 30, 'helix angles up to 30 degrees', mesh%helix_angle, '')
         call add_outside(g%contact_ratio < 1.2_dp, 'contact ratios from 1.2 on', g%contact_ratio, '')
         line_load = abs(system%static_force(n)*system%stiffness(n)*system%characteristic_length)*cos(g%transverse_angle) &
                     /mesh%face_width
         call add_outside(line_load > heavy_load, 'line loads up to 1600 N/mm', line_load/1000, ' N/mm')
         if (.not. any(abs(system%static_force(system%mesh_element)) > 0)) return
         if (.not. line_load > 0) then
            call add('it carries no load, and ISO 6336-1 has no stiffness without load: the value at 100 N/mm is used; give &
               &stiffness [N/m], or a drag torque on the unloaded body; a planet is unloaded by its place, planet_errors')
         else if (line_load < 0.01_dp*light_load) then
            call add('its line load is '//short(line_load/1000)//' N/mm, far below the loads for which ISO 6336-1 holds: the &
               &stiffness by its rule for light loads, (load/100 N/mm)^0.25 = '//short(light)// &
               ' of the full value, is uncertain; give stiffness [N/m] if it is known')
         end if
      end associate

   contains

      subroutine add(sentence)
         character(*), intent(in) :: sentence

         call add_warning(warnings, 'mesh', i, sentence)
      end subroutine add

      subroutine add_outside(outside, range, value, unit)
         logical, intent(in) :: outside
         character(*), intent(in) :: range, unit
         real(dp), intent(in) :: value

         if (outside) call add('the mesh stiffness by ISO 6336-1 is for '//range//', and it is '//short(value)//unit)
      end subroutine add_outside

   end subroutine warn_of_mesh

end module geartrain_report_drawing_warnings
