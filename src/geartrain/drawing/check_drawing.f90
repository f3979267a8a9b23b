!> Checks of what is read off a drawing: lists that belong together, and numbers that contradict one another.
module geartrain_drawing_check_drawing
   use geartrain_base_checker, only: checker_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_numbers, only: integer_text, ordinal, real_text, text, whole
   use geartrain_drawing_drawing, only: has_discs, has_geometry, has_sections, pair_of
   use geartrain_drawing_gear_pair, only: find_geometry, pair_geometry_type
   use geartrain_train_body, only: body_type, follows_speed, has_table_of_torque, pulses
   use geartrain_train_gear_error, only: first_variable, gear_words, has_gear_error
   use geartrain_train_kinematics, only: all_toothed, find_kinematics, kinematics_type
   use geartrain_train_mesh, only: is_given, mesh_type, most_order
   use geartrain_train_shaft, only: shaft_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: check_drawing

   !> Rounding of a drawing: by how much the flanks may overlap, over the module, and relative to a ratio of radii [1].
   real(dp), parameter :: rounding = 1e-3_dp
   !> Mean of a table that is rounding, over its largest value [1].
   real(dp), parameter :: rounding_of_mean = 1e-9_dp
   !> Beyond it no gear is made [m]; ISO 54 ends at 0.05.
   real(dp), parameter :: largest_module = 1
   !> Sum of profile shifts that gears are hardly made with [1].
   real(dp), parameter :: most_shift = 2

contains

   !> Adds every problem of the drawing.
   subroutine check_drawing(train, checker)
      !> The train as given, with any values.
      type(train_type), intent(in) :: train
      class(checker_type), intent(inout) :: checker
      integer :: i

      if (allocated(train%bodies)) then
         do i = 1, size(train%bodies)
            call checker%enter('body', i)
            call check_body(train%bodies(i), checker)
            call checker%leave()
         end do
      end if
      if (.not. allocated(train%shafts) .or. .not. allocated(train%meshes)) return
      do i = 1, size(train%shafts)
         call checker%enter('shaft', i)
         call check_shaft(train%shafts(i), checker)
         call checker%leave()
      end do
      do i = 1, size(train%meshes)
         if (.not. train%meshes(i)%is_pair()) cycle
         call checker%enter('mesh', i)
         call check_pair(train%meshes(i), checker)
         call checker%leave()
      end do
      call check_units(train, checker)
   end subroutine check_drawing

   subroutine check_body(body, checker)
      type(body_type), intent(in) :: body
      class(checker_type), intent(inout) :: checker

      if (is_given(body%outer_diameter) .neqv. is_given(body%width)) then
         call checker%lacks(trim(merge('width         ', 'outer_diameter', is_given(body%outer_diameter))), '> 0 m', &
                            ': as many as of the other')
      else if (is_given(body%width) .and. .not. has_discs(body)) then
         call checker%complain('outer_diameter', integer_text(size(body%outer_diameter))//' values', 'must have as many values as &
                               &width; bore and density one value or as many, each bore less than its outer_diameter')
      else if (.not. is_given(body%width) .and. (is_given(body%bore) .or. is_given(body%density))) then
         call checker%lacks('outer_diameter', '> 0 m', ' and width, to which bore and density belong')
      end if
      if (follows_speed(body)) then
         if (.not. body%torque_speed > 0) call checker%lacks('torque_speed', '> 0 rpm', ', the speed at which the torque is as &
                                                                                        &given')
         if (body%balances) call checker%complain('torque_speed_exponent', real_text(body%torque_speed_exponent), 'contradicts &
            &balances = .true.: its mean torque follows from the others; let the body at the other end of the train balance')
      end if
      if (.not. has_table_of_torque(body)) then
         if (body%torque_revolutions /= 1) call checker%lacks('torque_table', 'N m', ', to which torque_revolutions belongs')
         return
      end if
      associate (table => body%torque_table)
         if (size(table) < 4) call checker%complain('torque_table', integer_text(size(table))//' values', 'must be at least 4')
         if (.not. body%balances .or. abs(sum(table)) <= size(table)*rounding_of_mean*maxval(abs(table))) return
         call checker%complain('torque_table', 'with a mean of '//text(sum(table)/size(table))//' N m', 'contradicts balances = &
                               &.true.: its mean torque follows from the others; subtract the mean from the table')
      end associate
   end subroutine check_body

   subroutine check_shaft(shaft, checker)
      type(shaft_type), intent(in) :: shaft
      class(checker_type), intent(inout) :: checker

      if (is_given(shaft%diameter) .neqv. is_given(shaft%length)) then
         call checker%lacks(trim(merge('length  ', 'diameter', is_given(shaft%diameter))), '> 0 m', ': as many as of the other')
      else if (is_given(shaft%length) .and. .not. has_sections(shaft)) then
         call checker%complain('diameter', integer_text(size(shaft%diameter))//' values', 'must have as many values as length; &
                               &bore one value or as many, each less than its diameter')
      else if (is_given(shaft%bore) .and. .not. is_given(shaft%diameter)) then
         call checker%lacks('diameter', '> 0 m', ' and length, to which bore belongs')
      end if
   end subroutine check_shaft

   !> A gear pair can be made as it is drawn, and its flanks meet.
   subroutine check_pair(mesh, checker)
      type(mesh_type), intent(in) :: mesh
      class(checker_type), intent(inout) :: checker
      type(pair_geometry_type) :: geometry
      real(dp) :: pitch, gap
      integer :: i

      call check_alone()
      if (mesh%normal_module > largest_module) then
         call checker%complain('normal_module', real_text(mesh%normal_module), 'must be <= 1 m; the unit is the metre &
                               &(2.5 mm are 2.5e-3)')
         return
      end if
      call check_ratio()
      call check_errors()
      if (mesh%backlash > 0 .and. mesh%half_backlash > 0) call checker%complain('backlash', real_text(mesh%backlash), &
         'contradicts half_backlash, along the line of action: leave out one of the two')
      if (.not. has_geometry(mesh)) then
         if (is_given(mesh%teeth) .and. mesh%internal) then
            if (size(mesh%teeth) == 2) then
               if (abs(mesh%teeth(1) - mesh%teeth(2)) <= 0) &
                  call checker%complain('teeth', integer_text(whole(mesh%teeth(1)))//' twice', 'must differ in an internal pair')
            end if
         end if
         return
      end if
      call find_geometry(pair_of(mesh), geometry)
      if (is_given(mesh%bore)) then
         do i = 1, 2
            if (mesh%bore(i) < geometry%reference_diameter(i)) cycle
            call checker%complain('bore', real_text(mesh%bore(i)), 'must be < '//text(geometry%reference_diameter(i))// &
                                  ' m, the reference diameter of the gear of '//integer_text(whole(mesh%teeth(i)))// &
                                  ' teeth; the unit is the metre (28 mm are 0.028)', i)
         end do
      end if
      associate (g => geometry)
         ! Both along the working pitch circles.
         pitch = 2*pi*g%base_radius(1)/(mesh%teeth(1)*cos(g%working_angle))
         gap = mesh%backlash
         if (mesh%half_backlash > 0) gap = 2*mesh%half_backlash/cos(g%working_angle)
         do i = 1, 2
            if (g%tip_diameter(i) <= 2*g%base_radius(i)) then
               call checker%complain('tip_diameter', text(g%tip_diameter(i)), 'must be > '//text(2*g%base_radius(i))// &
                                     ' m, the base circle of the gear of '//integer_text(whole(mesh%teeth(i)))//' teeth')
            else if (g%tip_thickness(i) <= 0) then
               call checker%complain('tip_diameter', text(g%tip_diameter(i)), 'must be smaller: the flanks of the gear of '// &
                                     integer_text(whole(mesh%teeth(i)))//' teeth meet below it')
            end if
         end do
         if (.not. g%working_angle > 0 .and. .not. abs(mesh%centre_distance) > 0) then
            ! inv(alpha_wt) > 0, see `find_geometry`; without shifts there is always such a distance.
            pitch = tan(mesh%pressure_angle*pi/180)
            gap = (tan(g%transverse_angle) - g%transverse_angle)/(2*pitch)*merge(abs(mesh%teeth(2) - mesh%teeth(1)), &
                                                                                -sum(mesh%teeth), mesh%internal)
            call checker%complain('profile_shift', real_text(mesh%profile_shift(1))//', '//real_text(mesh%profile_shift(2)), &
               'must have a sum '//trim(merge('<', '>', mesh%internal))//' '//text(gap)// &
               ': otherwise the flanks touch without backlash at no centre distance')
         else if (.not. g%working_angle > 0) then
            call checker%complain('centre_distance', real_text(mesh%centre_distance), 'must be larger than that of the base &
               &circles, '//text(g%reference_distance*cos(g%transverse_angle))//' m')
         else if (g%distance_backlash*cos(g%working_angle) < -rounding*mesh%normal_module .and. -g%distance_backlash > gap) then
            ! Up to a backlash that is given, the teeth may be thinner by as much.
            call checker%complain('centre_distance', real_text(mesh%centre_distance), 'contradicts teeth and profile_shift: the &
               &flanks touch without backlash at '//text(g%tight_distance)//' m already'//trim(fitting()))
         else if (mesh%backlash > 0 .and. mesh%backlash < g%distance_backlash - rounding*mesh%normal_module) then
            call too_far('teeth, profile_shift and backlash')
         else if (g%distance_backlash > 0.5_dp*mesh%normal_module .and. .not. g%contact_ratio > 1) then
            call too_far('teeth and profile_shift')
         else if (.not. gap < pitch) then
            call checker%complain(trim(merge('half_backlash', 'backlash     ', mesh%half_backlash > 0)), &
               real_text(max(mesh%half_backlash, mesh%backlash)), 'must be < '//text(merge(cos(g%working_angle)/2, 1.0_dp, &
               mesh%half_backlash > 0)*pitch)//' m: it leaves nothing of the teeth, whose pitch at the working pitch circle is '// &
               text(pitch)//' m; the unit is the metre (60 um is 60e-6)')
         else if (.not. g%contact_ratio > 1 .and. .not. mesh%contact_ratio > 0) then
            call checker%complain('teeth', integer_text(whole(mesh%teeth(1)))//', '//integer_text(whole(mesh%teeth(2))), &
                                  'must give a transverse contact ratio > 1: it is '//text(g%contact_ratio)// &
                                  ' with tip diameters '//text(g%tip_diameter(1))//' and '//text(g%tip_diameter(2))//' m')
         end if
      end associate

   contains

      !> Adds the problem that the flanks are further apart than the drawing says elsewhere.
      subroutine too_far(others)
         character(*), intent(in) :: others
         character(:), allocatable :: words

         words = 'contradicts '//others//': the flanks touch without backlash at '//text(geometry%tight_distance)//' m'
         associate (factor => mesh%centre_distance/geometry%tight_distance)
            if (factor > 500 .and. factor < 2000) then
               words = words//'; the unit is the metre: is it in millimetres?'
            else
               words = words//', and have '//text(geometry%distance_backlash)//' m of it here'//trim(fitting())
            end if
         end associate
         call checker%complain('centre_distance', real_text(mesh%centre_distance), words)
      end subroutine too_far

      !> The profile shifts that have no backlash at the given centre distance, in words, where teeth are made with such.
      function fitting() result(words)
         character(64) :: words
         real(dp) :: total

         total = 0
         if (is_given(mesh%profile_shift)) total = sum(mesh%profile_shift)
         total = total + geometry%distance_backlash*(mesh%teeth(2) + merge(-1, 1, mesh%internal)*mesh%teeth(1)) &
                         /(4*mesh%centre_distance*tan(mesh%pressure_angle*pi/180))
         words = ''
         if (abs(total) < most_shift) words = '; profile shifts with a sum of '//text(total)//' would fit'
      end function fitting

      !> Given radii have the ratio of the teeth: else speeds and orders would be of another train than forces.
      subroutine check_ratio()
         real(dp) :: radius(2)

         if (.not. is_given(mesh%teeth)) return
         if (size(mesh%teeth) /= 2) return
         radius = [mesh%driving_radius, mesh%driven_radius]
         if (has_geometry(mesh)) then
            call find_geometry(pair_of(mesh), geometry)
            where (.not. abs(radius) > 0) radius = geometry%base_radius
         end if
         if (.not. all(radius > 0 .and. mesh%teeth > 0)) return
         if (abs(radius(1)/radius(2)*(mesh%teeth(2)/mesh%teeth(1)) - 1) <= rounding) return
         if (abs(mesh%driving_radius) > 0 .and. abs(mesh%driven_radius) > 0) then
            call checker%complain('driving_radius', real_text(radius(1)), 'contradicts teeth: with driven_radius = '// &
                                  text(radius(2))//' m the ratio must be '//integer_text(whole(mesh%teeth(1)))//'/'// &
                                  integer_text(whole(mesh%teeth(2))))
         else if (abs(mesh%driving_radius) > 0) then
            call checker%complain('driving_radius', real_text(radius(1)), 'contradicts teeth and normal_module, by which it is '// &
                                  text(geometry%base_radius(1))//' m: leave it out')
         else
            call checker%complain('driven_radius', real_text(radius(2)), 'contradicts teeth and normal_module, by which it is '// &
                                  text(geometry%base_radius(2))//' m: leave it out')
         end if
      end subroutine check_ratio

      !> Every tooth has a pitch error, or none has.
      subroutine check_errors()
         integer :: gear

         if (.not. is_given(mesh%teeth)) return
         if (size(mesh%teeth) /= 2) return
         if (mesh%pitch_error_form == 'steps' .and. .not. (mesh%contact_ratio > 0 .or. has_geometry(mesh))) &
            call checker%lacks('contact_ratio', '> 1', ', over which pitch errors as steps are smoothed, or the drawing')
         do gear = 1, 2
            ! Teeth out of range, which are told by themselves, may have no place in an integer.
            associate (error => mesh%gear_error(gear), teeth => mesh%teeth(gear))
               if (is_given(error%tooth_stiffness)) then
                  if (.not. abs(size(error%tooth_stiffness) - teeth) < 0.5_dp) &
                     call checker%complain(trim(gear_words(gear))//'_tooth_stiffness', &
                                           integer_text(size(error%tooth_stiffness))//' values', 'must have a value for each &
                                           &of the '//text(teeth)//' teeth')
                  if (.not. any(error%tooth_stiffness > 0)) call checker%complain(trim(gear_words(gear))//'_tooth_stiffness', &
                     '0', 'must be > 0 for some teeth: else no tooth bears')
               end if
               if (.not. is_given(error%pitch)) cycle
               if (abs(size(error%pitch) - teeth) < 0.5_dp) cycle
               call checker%complain(trim(gear_words(gear))//'_pitch_error', integer_text(size(error%pitch))//' values', &
                                     'must have a value for each of the '//text(teeth)//' teeth')
            end associate
         end do
      end subroutine check_errors

      !> Values that belong to a gear pair with teeth and module have these.
      subroutine check_alone()
         logical :: used

         used = is_given(mesh%profile_shift) .or. is_given(mesh%tip_diameter) .or. abs(mesh%centre_distance) > 0 .or. &
                abs(mesh%backlash) > 0 .or. abs(mesh%normal_module) > 0 .or. abs(mesh%helix_angle) > 0
         if (used .and. .not. is_given(mesh%teeth)) call checker%lacks('teeth', '', ', to which the rest of the drawing belongs')
         used = is_given(mesh%profile_shift) .or. is_given(mesh%tip_diameter) .or. abs(mesh%centre_distance) > 0 .or. &
                abs(mesh%backlash) > 0 .or. abs(mesh%face_width) > 0 .or. abs(mesh%helix_angle) > 0
         if (used .and. .not. abs(mesh%normal_module) > 0) &
            call checker%lacks('normal_module', '> 0 m', ', to which the rest of the drawing belongs')
      end subroutine check_alone

   end subroutine check_pair

   !> Orders agree with the teeth; characteristic values and the speed are known where they are needed.
   subroutine check_units(train, checker)
      type(train_type), intent(in) :: train
      class(checker_type), intent(inout) :: checker
      type(kinematics_type) :: found
      character(24) :: name
      character(:), allocatable :: words
      logical :: toothed, unknown
      integer :: i, gear

      toothed = all_toothed(train)
      if (toothed) then
         call find_kinematics(train, found)
      end if
      ! Whether all meshes have teeth is not known while those of a mesh are wrong.
      unknown = any(checker%problems%reported('mesh', [(i, i=1, size(train%meshes))], 'teeth'))
      call checker%enter('train', 1)
      if (.not. (abs(train%characteristic_length) > 0 .or. toothed .or. unknown)) &
         call checker%lacks('characteristic_length', '> 0 m', ': it may be left out where every mesh has teeth')
      if (.not. (abs(train%characteristic_frequency) > 0 .or. toothed .or. unknown)) &
         call checker%lacks('characteristic_frequency', '> 0 rad/s', ': it may be left out where every mesh has teeth')
      if (train%speed_of /= '') call check_speed()
      call checker%leave()
      if (allocated(train%bodies)) then
         do i = 1, size(train%bodies)
            ! A plain train has no teeth any more, but the speed that followed from them.
            if (toothed .or. unknown .or. train%speed_ratio > 0) cycle
            if (.not. (pulses(train%bodies(i)) .or. follows_speed(train%bodies(i)))) cycle
            call checker%enter('body', i)
            name = 'revolution_torque_sin'
            if (.not. pulses(train%bodies(i))) name = 'torque_speed_exponent'
            if (is_given(train%bodies(i)%revolution_torque_cos)) name = 'revolution_torque_cos'
            if (has_table_of_torque(train%bodies(i))) name = 'torque_table'
            call checker%complain(trim(name), '...', &
                                  'must be left out unless every mesh has teeth, which tell how often the body turns')
            call checker%leave()
         end do
      end if
      do i = 1, size(train%meshes)
         if (toothed .or. unknown .or. train%speed_ratio > 0) cycle
         call checker%enter('mesh', i)
         do gear = 1, 2
            associate (error => train%meshes(i)%gear_error(gear))
               if (has_gear_error(error)) call checker%complain(trim(first_variable(error, gear)), '...', 'must be left out unless &
                  &every mesh has teeth, which tell how often the gear turns')
            end associate
         end do
         call checker%leave()
      end do
      if (.not. toothed) return
      if (.not. found%known) then
         if (checker%problems%in_group('body') .or. checker%problems%in_group('train') .or. &
             checker%problems%in_group('mesh')) return
         words = 'the ratios of the teeth make a fundamental whose orders are beyond '//integer_text(most_order)// &
                 ': give order and the radii in place of the teeth'
         if (allocated(train%bodies)) then
            if (any(train%bodies%ratio_given)) words = words//', or a speed_ratio of small whole numbers, as 1/3, by which errors &
               &of gears and torques of revolutions repeat themselves with the meshes'
         end if
         if (found%turning%determined) call checker%problems%add(words, 'train', 1, names_group=.true.)
         return
      end if
      do i = 1, merge(size(found%turning%speed), 0, allocated(train%bodies))
         if (.not. follows_speed(train%bodies(i)) .or. abs(found%turning%speed(i)) > 0) cycle
         call checker%enter('body', i)
         call checker%complain('torque_speed_exponent', real_text(train%bodies(i)%torque_speed_exponent), 'must be left out: the &
            &body stands still')
         call checker%leave()
      end do
      do i = 1, size(train%meshes)
         if (.not. train%meshes(i)%is_pair()) cycle
         call checker%enter('mesh', i)
         if (train%meshes(i)%order /= 0 .and. train%meshes(i)%order /= found%order(i)) then
            call checker%complain('order', integer_text(train%meshes(i)%order), 'contradicts the teeth, by which it is '// &
                                  integer_text(found%order(i)))
         else if (found%order(i) > most_order) then
            call checker%complain('teeth', integer_text(whole(train%meshes(i)%teeth(1)))//', '// &
                                  integer_text(whole(train%meshes(i)%teeth(2))), 'make the mesh frequency the '// &
                                  ordinal(found%order(i))//' multiple of the fundamental, at most '// &
                                  integer_text(most_order)//' is allowed')
         end if
         call checker%leave()
      end do

   contains

      subroutine check_speed()
         if (.not. allocated(train%bodies)) then
            call checker%complain('speed_of', "'"//trim(train%speed_of)//"'", 'names a body, but a chain has none by name: leave &
                                  &out speed_of, the speed is that of the driving end')
            return
         end if
         do i = 1, size(train%bodies)
            if (.not. allocated(train%bodies(i)%name)) cycle
            if (train%bodies(i)%name == train%speed_of) return
         end do
         call checker%complain('speed_of', "'"//trim(train%speed_of)//"'", 'must be the name of a &body')
      end subroutine check_speed

   end subroutine check_units

end module geartrain_drawing_check_drawing
