!> What a train is in numbers: what is derived from the drawing, each number with its formula and source, and warnings where a
!> formula is used outside the range that its source gives.
module geartrain_report_explain
   use geartrain_base_carry, only: carry, carry_text
   use geartrain_base_field, only: field_type, text_type
   use geartrain_base_fields, only: fields_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_numbers, only: counted, integer_text, short => text
   use geartrain_drawing_drawing, only: gears_of, has_discs, has_geometry, has_sections, has_stiffness, pair_of, plain_train
   use geartrain_drawing_gear_pair, only: find_geometry, find_stiffness, pair_geometry_type, pair_stiffness_type
   use geartrain_network_frequency_unit, only: speed_per_lambda
   use geartrain_network_light_loads, only: reduce_light_loads
   use geartrain_network_system, only: build_system, system_type
   use geartrain_report_drawing_warnings, only: find_warnings
   use geartrain_report_explain_bearing, only: explain_line
   use geartrain_report_explain_coupling, only: explain_coupling
   use geartrain_report_explain_errors, only: explain_errors, explain_series, explain_teeth
   use geartrain_report_explain_damping, only: damping_explanation_type
   use geartrain_report_explain_planetary, only: explain_set
   use geartrain_train_bodies, only: find_ends
   use geartrain_train_body, only: has_table_of_torque
   use geartrain_train_kinematics, only: all_toothed, find_kinematics, kinematics_type
   use geartrain_train_labels, only: label_length, mesh_labels, shaft_labels
   use geartrain_train_mesh, only: has_loads, has_table, is_given, mesh_type
   use geartrain_train_planetary_sets, only: find_sets, planetary_set_type
   use geartrain_train_train, only: train_type
   use geartrain_train_turning, only: find_turning, turning_type
   implicit none (type, external)
   private
   public :: explain_train, explanation_text, speed_text

   character(*), parameter :: as_given = 'as given'

   !> What the parts of an explanation share.
   type :: context_type
      !> The train as given and in plain numbers, mesh stiffnesses reduced for light loads; its system.
      type(train_type) :: given, plain
      type(system_type) :: system
      logical :: toothed = .false.
      type(kinematics_type) :: kinematics
      type(damping_explanation_type) :: damping
   end type context_type

contains

   !> Makes groups of fields: 'train', names of bodies, 'shaft 1', ..., 'mesh 1', 'coupling 1', 'bearing 1', ..., names of sets.
   subroutine explain_train(train, fields)
      !> A train that has passed `check_train`.
      type(train_type), intent(in) :: train
      !> Gets the groups.
      class(fields_type), intent(inout) :: fields
      type(context_type) :: context
      type(planetary_set_type), allocatable :: sets(:)
      type(turning_type) :: turning
      integer :: i

      call prepare(train, context)
      call context%damping%setup(train, context%plain)
      call explain_whole(context, fields)
      if (allocated(train%bodies)) then
         do i = 1, size(train%bodies)
            call explain_body(context, i, fields)
         end do
      end if
      do i = 1, size(train%shafts)
         call explain_shaft(context, i, fields)
      end do
      do i = 1, size(train%meshes)
         if (.not. train%meshes(i)%is_pair()) then
            call explain_coupling(context%given, context%system, context%damping, i, fields)
         else
            call explain_mesh(context, i, fields)
         end if
      end do
      if (.not. any(train%meshes%carrier /= '')) return
      call find_sets(context%plain, sets)
      call find_turning(train, turning)
      do i = 1, size(sets)
         call explain_set(context%system, i, train, sets(i), turning, trim(train%bodies(max(1, turning%reference))%name), fields)
      end do
   end subroutine explain_train

   subroutine prepare(train, context)
      type(train_type), intent(in) :: train
      type(context_type), intent(out) :: context

      context%given = train
      call plain_train(train, context%plain)
      call reduce_light_loads(context%plain)
      call build_system(train, context%system)
      context%toothed = all_toothed(train)
      if (context%toothed) then
         call find_kinematics(train, context%kinematics)
      end if
   end subroutine prepare

   subroutine explain_whole(context, fields)
      type(context_type), intent(inout) :: context
      class(fields_type), intent(inout) :: fields
      character(:), allocatable :: words
      real(dp) :: frequency

      if (.not. fields%enter('train', 'the train as a whole', .true.)) return
      associate (given => context%given, plain => context%plain)
         words = source(given%characteristic_length, 'unit of displacement, default of trains with teeth')
         call carry(fields, field_type('characteristic_length', '', 'm', words), plain%characteristic_length)
         words = source(given%characteristic_frequency, 'unit of frequency, so that Lambda is the speed in rpm')
         call carry(fields, field_type('characteristic_frequency', '', 'rad/s', words), plain%characteristic_frequency)
         if (context%toothed) then
            call tell_fundamental(context, words)
            call carry_text(fields, field_type('fundamental', '', '', 'its frequency is the greatest common divisor of all mesh &
               &frequencies'), words)
            frequency = 1000/60.0_dp/plain%speed_ratio
            call carry(fields, field_type('fundamental_frequency', '', 'Hz', 'at 1000 rpm of '//trim(speed_name(context))//': one &
               &over its period'), frequency)
            call carry(fields, field_type('speed_ratio', '', '1', 'turns of '//trim(speed_name(context))//', whose revolutions are &
               &the speed, per period of the fundamental'), plain%speed_ratio)
         end if
         call context%damping%explain_modes(fields)
      end associate
   end subroutine explain_whole

   !> What speeds and the fundamental are, of a train whose meshes all have teeth, as a line: 'Speeds are those of motor; the period
   !> of the fundamental is one turn of wheel 1'.
   subroutine speed_text(train, text)
      !> A train that has passed `check_train`.
      type(train_type), intent(in) :: train
      !> The line; '' where not every mesh has teeth.
      character(:), allocatable, intent(out) :: text
      type(context_type) :: context
      character(:), allocatable :: period

      text = ''
      if (.not. all_toothed(train)) return
      call prepare(train, context)
      call tell_fundamental(context, period)
      if (abs(train%characteristic_frequency) > 0) then
         text = 'Lambda = 1: '//short(speed_per_lambda(context%plain))//' rpm of '//trim(speed_name(context))
      else
         text = 'Speeds are those of '//trim(speed_name(context))
      end if
      text = text//'; the period of the fundamental is '//period
   end subroutine speed_text

   !> Period of the fundamental in words: 'one turn of wheel 1', or 'the time of 71/23 turns of motor'.
   subroutine tell_fundamental(context, words)
      type(context_type), intent(in) :: context
      character(:), allocatable, intent(out) :: words
      integer :: i

      associate (k => context%kinematics, bodies => context%given%bodies)
         if (all(k%fundamental == 0)) then
            words = short(context%plain%speed_ratio)//' turns of '//trim(speed_name(context))
            if (k%order_error > 0) words = 'about '//words
            return
         end if
         if (k%order_error > 0) then
            words = 'about '//integer_text(nint(context%plain%speed_ratio))//' turns of '//trim(speed_name(context))// &
                    ', by the teeth '//integer_text(int(k%fundamental(2)))
            if (k%fundamental(1) /= 1) words = words//'/'//integer_text(int(k%fundamental(1)))
            return
         end if
         if (allocated(context%given%bodies)) then
            do i = 1, size(bodies)
               if (k%rate(1, i)*k%fundamental(2) /= k%fundamental(1)*k%rate(2, i)) cycle
               words = 'one turn of '//bodies(i)%name
               return
            end do
         end if
         words = counted(int(k%fundamental(2)), 'turn', 'turns')//' of '//trim(speed_name(context))
         if (k%fundamental(1) /= 1) words = integer_text(int(k%fundamental(2)))//'/'//integer_text(int(k%fundamental(1)))// &
                                            ' of a turn of '//trim(speed_name(context))
      end associate
   end subroutine tell_fundamental

   !> Name of the body whose revolutions are the speed.
   pure function speed_name(context) result(name)
      type(context_type), intent(in) :: context
      character(label_length) :: name

      name = 'the driving end'
      if (allocated(context%given%bodies)) name = context%given%bodies(max(1, context%kinematics%speed_body))%name
   end function speed_name

   subroutine explain_body(context, i, fields)
      type(context_type), intent(inout) :: context
      integer, intent(in) :: i
      class(fields_type), intent(inout) :: fields
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      character(:), allocatable :: words
      real(dp) :: turns, added
      integer :: order

      added = context%given%bodies(i)%added_inertia
      associate (body => context%given%bodies(i), k => context%kinematics)
         if (.not. fields%enter(body%name, 'body', .true.)) return
         if (body%held) return
         words = as_given
         if (body%inertia < 0) then
            words = 'of its discs, sum of pi rho b (D^4 - d^4)/32'
            if (.not. has_discs(body)) then
               call find_ends(context%given, shaft_ends, mesh_ends)
               words = 'as discs of the pitch diameters, pi rho b (d^4 - bore^4)/32; gears: '// &
                       integer_text(size(gears_of(context%given, mesh_ends, i), 2))//'; a gear in several meshes counts once'
            end if
         end if
         if (body%added_inertia > 0) words = words//', and added_inertia'
         call carry(fields, field_type('inertia', '', 'kg m^2', words), context%plain%bodies(i)%inertia)
         if (body%added_inertia > 0) &
            call carry(fields, field_type('added_inertia', '', 'kg m^2', 'of masses that the body carries: of planets the number &
                                          &times the mass times the square of the centre distance'), added)
         if (.not. context%toothed) return
         if (.not. k%known) return
         turns = k%turning%speed(i)
         call carry(fields, field_type('turns', '', '1', 'per turn of '//trim(speed_name(context))//', by the teeth; below 0: &
            &the other way round'), turns)
         order = k%revolution_order(i)
         if (has_table_of_torque(body)) order = order*body%torque_revolutions
         if (order > 0) call carry(fields, field_type('revolution_order', '', '1', 'its revolution (of a planet &
            &against its carrier) over the fundamental'), order)
      end associate
   end subroutine explain_body

   subroutine explain_shaft(context, i, fields)
      type(context_type), intent(inout) :: context
      integer, intent(in) :: i
      class(fields_type), intent(inout) :: fields
      character(label_length) :: labels(size(context%given%shafts))
      character(:), allocatable :: words
      real(dp) :: torque
      integer :: n

      labels = shaft_labels(context%given)
      if (.not. fields%enter('shaft '//integer_text(i), trim(labels(i)), .true.)) return
      associate (shaft => context%given%shafts(i), system => context%system)
         if (shaft%rigid) return
         words = as_given
         if (.not. abs(shaft%stiffness) > 0 .and. has_sections(shaft)) &
            words = '1/k = sum of 32 l/(pi G (D^4 - d^4)) over the sections; the inertia of the shaft itself is not counted'
         call carry(fields, field_type('stiffness', '', 'N m/rad', words), context%plain%shafts(i)%stiffness)
         call context%damping%explain_element('shaft', i, fields)
         n = findloc(system%element_shaft, i, 1)
         torque = system%static_force(n)*system%stiffness(n)*system%characteristic_length*system%network%elements(n)%radius
         call carry(fields, field_type('mean_torque', '', 'N m', 'static, from the mean torques of the bodies'), torque)
      end associate
   end subroutine explain_shaft

   subroutine explain_mesh(context, i, fields)
      type(context_type), intent(inout) :: context
      integer, intent(in) :: i
      class(fields_type), intent(inout) :: fields
      character(label_length) :: labels(size(context%given%meshes))
      type(pair_geometry_type) :: geometry
      type(pair_stiffness_type) :: stiffness
      character(:), allocatable :: words
      real(dp), allocatable :: list(:)
      integer, allocatable :: orders(:)
      real(dp) :: force, line_load, angle
      integer :: n, order

      labels = mesh_labels(context%given)
      if (.not. fields%enter('mesh '//integer_text(i), trim(labels(i)), .true.)) return
      n = context%system%mesh_element(i)
      force = context%system%static_force(n)*context%system%load_unit(i)
      associate (mesh => context%given%meshes(i), plain => context%plain%meshes(i), g => geometry)
         list = [plain%driving_radius, plain%driven_radius]
         words = source(mesh%driving_radius, 'z m_t cos(alpha_t)/2, ISO 21771')
         if (abs(mesh%driving_radius) > 0 .neqv. abs(mesh%driven_radius) > 0) words = 'that of the '// &
            trim(merge('driving', 'driven ', abs(mesh%driving_radius) > 0))//' gear as given, the other by the drawing'
         call carry(fields, field_type('base_radius', 'gear', 'm', words), list)
         if (has_geometry(mesh)) then
            call find_geometry(pair_of(mesh), geometry)
            list = g%reference_diameter
            call carry(fields, field_type('reference_diameter', 'gear', 'm', 'z m_n/cos(beta)'), list)
            list = g%tip_diameter
            words = 'reference diameter + 2 m_n (1 + x + k), k <= 0 keeps the clearance of the rack, ISO 21771'
            if (is_given(mesh%tip_diameter)) words = as_given
            call carry(fields, field_type('tip_diameter', 'gear', 'm', words), list)
            words = source(mesh%centre_distance, 'inv(alpha_wt) = inv(alpha_t) + 2 tan(alpha_n) (x1 + x2)/(z1 + z2): the flanks &
               &touch without backlash')
            call carry(fields, field_type('centre_distance', '', 'm', words), g%centre_distance)
            angle = g%transverse_angle*180/pi
            call carry(fields, field_type('transverse_angle', '', 'degree', 'pressure angle in the transverse plane at the &
               &reference circle, tan(alpha_t) = tan(alpha_n)/cos(beta)'), angle)
            angle = g%working_angle*180/pi
            call carry(fields, field_type('working_angle', '', 'degree', 'transverse pressure angle at the working pitch &
               &circle'), angle)
            list = g%virtual_teeth
            call carry(fields, field_type('virtual_teeth', 'gear', '1', 'z/(cos(beta_b)^2 cos(beta)), ISO 6336-1'), list)
            words = 'transverse, path of contact over p_et, ISO 21771'
            if (mesh%contact_ratio > 0) then
               words = 'as given; the drawing has '//short(g%contact_ratio)
               g%contact_ratio = mesh%contact_ratio
            end if
            call carry(fields, field_type('contact_ratio', '', '1', words), g%contact_ratio)
            call carry(fields, field_type('overlap_ratio', '', '1', 'b sin(beta)/(pi m_n), ISO 21771'), g%overlap_ratio)
         end if
         if (has_stiffness(mesh)) then
            line_load = abs(force)*cos(g%transverse_angle)/mesh%face_width
            call find_stiffness(pair_of(mesh), geometry, line_load, stiffness)
            call carry(fields, field_type('line_load', '', 'N/m', 'tangential force at the reference circle by the mean torque &
               &over the face width, F_t/b, with K_A = 1'), line_load)
            words = "c' = c'_th C_M C_R C_B cos(beta) [N/m per m], ISO 6336-1:2006 method B: C_M = 0.8, C_R = 1 (solid), C_B = "// &
                    short(stiffness%rack_factor)
            if (stiffness%load_factor < 1) words = words//', times (F_t/b / 100 N/mm)^0.25 = '//short(stiffness%load_factor)// &
                                                   ' for the light load'
            call carry(fields, field_type('single_stiffness', '', 'N/m^2', words), stiffness%single)
            call carry(fields, field_type('mesh_stiffness', '', 'N/m^2', "c_gamma_alpha = c' (0.75 eps_alpha + 0.25) [N/m per m], &
               &ISO 6336-1:2006"), stiffness%mesh)
         end if
         words = as_given
         if (has_stiffness(mesh)) words = 'c_gamma_alpha b, along the line of action in the transverse plane'
         if (has_table(mesh)) words = 'mean of stiffness_table'
         if (has_loads(mesh)) words = 'mean over the cycle below the first corner, by stiffness_table'
         call carry(fields, field_type('stiffness', '', 'N/m', words), plain%stiffness)
         call context%damping%explain_element('mesh', i, fields)
         words = as_given
         if (has_table(mesh)) words = 'of stiffness_table'
         if (.not. (is_given(mesh%stiffness_cos) .or. is_given(mesh%stiffness_sin) .or. has_table(mesh))) then
            words = '2 sin(n pi (eps - 1))/(n pi eps)'
            if (g%overlap_ratio > 0) &
               words = words//', averaged over the face: times sin(n pi eps_beta)/(n pi eps_beta), phase of the middle of the face'
         end if
         call explain_series('stiffness', 'harmonic', '1', words, plain%stiffness_cos, plain%stiffness_sin, fields)
         if (has_loads(mesh)) then
            call carry(fields, field_type('stage_wall', 'stage', 'm', 'deflections at the corners: mean deflections under all but &
                                          &the last of table_loads'), plain%stage_wall)
            list = plain%stiffness*plain%stage_mean
            call carry(fields, field_type('stage_stiffness', 'stage', 'N/m', 'mean over the cycle beyond the corners, change of &
                                          &force over change of deflection'), list)
            call carry(fields, field_type('stage_error', '', '1', 'largest difference of the force to a load at its deflection in &
                                          &the table, over the load; more loads make it smaller'), plain%stage_error)
         end if
         call explain_errors(mesh, context%plain%meshes(i), fields)
         words = source(mesh%half_backlash, 'half of backlash cos(alpha_wt): along the line of action in the transverse plane; &
            &backlash is along the working pitch circles')
         if (.not. mesh%backlash > 0 .and. g%distance_backlash > 0) words = words//', by the centre distance'
         call carry(fields, field_type('half_backlash', '', 'm', words), plain%half_backlash)
         words = as_given
         if (mesh%order == 0) words = 'mesh frequency over the fundamental frequency, '// &
                                      trim(merge('from the teeth', 'default       ', context%toothed))
         if (context%kinematics%order_error > 0) then
            if (context%kinematics%exact_order(i) == 0) words = words//', nearly: together they repeat themselves &
               &after millions of cycles, or never'
            if (context%kinematics%exact_order(i) > 0) words = words//', which make it the multiple '// &
               integer_text(context%kinematics%exact_order(i))//' of their own fundamental'
         end if
         order = merge(0, plain%order, plain%locked)
         if (plain%locked) words = 'the gears turn as one with the carrier: their teeth stand still in each other, mean stiffness &
                                   &and mean error alone act'
         call carry(fields, field_type('order', '', '1', words), order)
         if (abs(mesh%phase) > 0) call carry(fields, field_type('phase', '', 'rad', 'lag of stiffness and errors in the mesh &
            &cycle, as given, or by the place of a planet'), mesh%phase)
         orders = plain%order*excited(plain)
         if (size(orders) > 0) call carry(fields, field_type('excited_orders', 'harmonic', '1', 'multiples of the fundamental &
            &with an amplitude of its stiffness or transmission error'), orders)
         if (context%toothed) call explain_teeth(mesh, fields)
         words = 'static, from the mean torques of the bodies'
         if (force < 0) words = words//'; negative: the second body drives the first, and the back flanks bear the load'
         call carry(fields, field_type('mean_force', '', 'N', words), force)
         call explain_line(context%plain, i, fields)
      end associate
   end subroutine explain_mesh

   !> Harmonics of the mesh frequency with an amplitude, ascending.
   pure function excited(mesh) result(harmonics)
      type(mesh_type), intent(in) :: mesh
      integer, allocatable :: harmonics(:)
      integer :: h, most

      most = max(count_of(mesh%stiffness_cos), count_of(mesh%stiffness_sin), count_of(mesh%error_cos), count_of(mesh%error_sin))
      harmonics = pack([(h, h=1, most)], [(has(mesh%stiffness_cos, h) .or. has(mesh%stiffness_sin, h) .or. &
                                           has(mesh%error_cos, h) .or. has(mesh%error_sin, h), h=1, most)])
   end function excited

   pure integer function count_of(list)
      real(dp), allocatable, intent(in) :: list(:)

      count_of = 0
      if (allocated(list)) count_of = size(list)
   end function count_of

   !> Whether value h of a list is there and more than the rounding of one that is 0.
   pure logical function has(list, h)
      real(dp), allocatable, intent(in) :: list(:)
      integer, intent(in) :: h

      has = .false.
      if (count_of(list) >= h) has = abs(list(h)) > 1e-12_dp
   end function has

   !> 'as given' for a value that is, else the formula.
   pure function source(given, formula) result(words)
      real(dp), intent(in) :: given
      character(*), intent(in) :: formula
      character(merge(len(as_given), len(formula), abs(given) > 0)) :: words

      words = formula
      if (abs(given) > 0) words = as_given
   end function source

   !> Writes the groups of `explain_train` and the warnings as text.
   subroutine explanation_text(train, text)
      !> A train that has passed `check_train`.
      type(train_type), intent(in) :: train
      !> Lines, with a heading for each group.
      character(:), allocatable, intent(out) :: text
      type(fields_type) :: fields
      type(text_type), allocatable :: warnings(:)
      character(26) :: name
      character(:), allocatable :: values
      integer :: i, j, k

      call explain_train(train, fields)
      text = ''
      do i = 1, fields%count
         associate (group => fields%groups(i))
            text = text//group%path
            if (group%description /= group%path) text = text//': '//trim(group%description)
            text = text//new_line('a')
            do j = 1, group%count
               associate (field => group%fields(j))
                  values = ''
                  if (allocated(field%reals)) then
                     do k = 1, size(field%reals)
                        values = values//', '//short(field%reals(k) + 0)
                     end do
                  else if (allocated(field%integers)) then
                     do k = 1, size(field%integers)
                        values = values//', '//integer_text(field%integers(k))
                     end do
                  else
                     values = ', '//field%texts(1)%text
                  end if
                  name = field%about%name
                  text = text//'   '//name//values(3:)
                  if (field%about%unit /= '1' .and. field%about%unit /= '') text = text//' '//trim(field%about%unit)
                  text = text//'   ('//trim(field%about%description)//')'//new_line('a')
               end associate
            end do
         end associate
      end do
      call find_warnings(train, warnings)
      do i = 1, size(warnings)
         text = text//'Warning: '//warnings(i)%text//new_line('a')
      end do
   end subroutine explanation_text

end module geartrain_report_explain
