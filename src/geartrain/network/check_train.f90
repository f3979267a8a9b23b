!> Checks of a train: every value is in its range, and no values contradict each other.
module geartrain_network_check_train
   use geartrain_base_arithmetic, only: tells_nan
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text, real_text
   use geartrain_drawing_check_drawing, only: check_drawing
   use geartrain_drawing_check_distances, only: check_distances
   use geartrain_drawing_drawing, only: has_geometry, has_sections, has_stiffness, plain_train
   use geartrain_network_check_bearing, only: check_bearing
   use geartrain_network_check_coupling, only: check_coupling
   use geartrain_network_check_damping, only: check_damping
   use geartrain_network_check_network, only: check_network
   use geartrain_network_limits, only: check_stiffest
   use geartrain_train_mesh_groups, only: enter_mesh, group_name
   use geartrain_network_scales, only: check_scales
   use geartrain_mesh_law_loaded_contact, only: falling_instant
   use geartrain_train_mesh, only: has_table, is_given, mesh_type
   use geartrain_train_shaft, only: shaft_type
   use geartrain_train_train, only: train_type
   use geartrain_train_train_variables, only: visit_model
   implicit none (type, external)
   private
   public :: check_train, check_consistency

contains

   !> Checks all of a train. The error tells every problem, one a line: '&mesh 2: stiffness = -1.0: must be > 0 N/m'.
   subroutine check_train(train, error)
      !> The train, with any values.
      type(train_type), intent(in) :: train
      type(error_type), allocatable, intent(out) :: error
      type(train_type) :: copy
      type(checker_type) :: checker

      copy = train
      call visit_model(copy, checker)
      call check_consistency(train, checker)
      call checker%problems%raise('', error)
   end subroutine check_train

   !> Checks how the values of a train agree; the range of each value is not checked here.
   subroutine check_consistency(train, checker)
      !> The train, with any values.
      type(train_type), intent(in) :: train
      class(checker_type), intent(inout) :: checker
      type(train_type) :: plain
      real(dp) :: own
      integer :: shafts, meshes, i

      if (.not. tells_nan()) call checker%problems%add('geartrain was compiled with -Ofast, -ffast-math or -ffinite-math-only, &
         &and cannot tell NaN from numbers: its results would be worth nothing; compile it without', 'train', 1, names_group=.true.)
      if (allocated(train%planetaries)) then
         call checker%problems%add('is in short form: expand it first, by expand_planetaries', 'planetary', 1)
         return
      end if
      call check_drawing(train, checker)
      call check_distances(train, checker)
      call plain_train(train, plain)
      shafts = 0
      meshes = 0
      if (allocated(train%shafts)) shafts = size(train%shafts)
      if (allocated(train%meshes)) meshes = size(train%meshes)
      do i = 1, meshes
         call enter_mesh(checker, train%meshes, i)
         if (train%meshes(i)%is_coupling) then
            call check_coupling(train%meshes(i), checker)
         else if (train%meshes(i)%axis > 0) then
            call check_bearing(train%meshes, i, checker)
         else
            call check_stiffness(train%meshes(i), checker%drawing_is_wrong('mesh', i), checker)
            call check_back(train%meshes(i), plain%meshes(i), checker)
            if (i > 1) then
               if (.not. train%meshes(i - 1)%is_pair()) call checker%problems%add('stands after a coupling or a bearing: these &
                                                                                  &are the last', 'mesh', i)
            end if
         end if
         call checker%leave()
      end do
      if (meshes > 0 .and. .not. allocated(train%bodies)) then
         i = findloc(train%meshes%is_pair(), .false., 1)
         if (i > 0) then
            call checker%problems%add('joins bodies, but there is no &body: a chain has shafts and gear pairs alone', &
                                      trim(group_name(train%meshes, i)), 1)
            return
         end if
      end if
      do i = 1, shafts
         call checker%enter('shaft', i)
         call check_shaft(train%shafts(i), checker%drawing_is_wrong('shaft', i), checker)
         call checker%leave()
      end do
      if (allocated(train%bodies)) then
         if (allocated(train%shafts) .and. allocated(train%meshes)) call check_network(plain, checker)
      else if (shafts < 2 .or. meshes /= shafts - 1) then
         call checker%problems%add('the train has '//integer_text(shafts)//' &shaft and '//integer_text(meshes)// &
                                   ' &mesh: a train is shaft, mesh, shaft, ..., shaft, at least 2 shafts and one mesh less &
                                   &than shafts', 'train', 1, names_group=.true.)
      end if
      if (.not. allocated(train%bodies)) then
         call check_names()
         call check_inertias()
         if (shafts == 0) return
         call checker%enter('train', 1)
         call check_end(train%prime_mover_inertia, 'prime_mover_inertia', 'first', train%shafts(1))
         call check_end(train%load_inertia, 'load_inertia', 'last', train%shafts(shafts))
         call checker%leave()
      end if
      call check_damping(plain, checker)
      call check_stiffest(plain, own, checker)
      call check_scales(plain, own, .not. abs(train%characteristic_frequency) > 0, checker)

   contains

      !> In a chain no shaft or mesh names bodies.
      subroutine check_names()
         character(*), parameter :: cure = 'names bodies, but there is no &body: a chain is joined in its order'

         do i = 1, shafts
            call checker%enter('shaft', i)
            if (any(train%shafts(i)%between /= '')) &
               call checker%complain('between', "'"//trim(train%shafts(i)%between(1))//"', ...", cure)
            call checker%leave()
         end do
         do i = 1, meshes
            call checker%enter('mesh', i)
            if (train%meshes(i)%line_given) call checker%complain('line_of_action', real_text(train%meshes(i)%line_of_action), &
               'must be left out: it is for bodies on bearings, and there is no &body')
            if (any(train%meshes(i)%between /= '')) &
               call checker%complain('between', "'"//trim(train%meshes(i)%between(1))//"', ...", cure)
            call checker%leave()
         end do
      end subroutine check_names

      !> In a chain every gear has an inertia.
      subroutine check_inertias()
         character(*), parameter :: instead = ' or teeth, normal_module and face_width'

         do i = 1, meshes
            if (checker%drawing_is_wrong('mesh', i)) cycle
            call checker%enter('mesh', i)
            if (.not. abs(plain%meshes(i)%driving_inertia) > 0) call checker%lacks('driving_inertia', '> 0 kg m^2', instead)
            if (.not. abs(plain%meshes(i)%driven_inertia) > 0) call checker%lacks('driven_inertia', '> 0 kg m^2', instead)
            call checker%leave()
         end do
      end subroutine check_inertias

      !> An elastic shaft with nothing at its end has no equation of motion there.
      subroutine check_end(inertia, name, which, shaft)
         real(dp), intent(in) :: inertia
         character(*), intent(in) :: name, which
         type(shaft_type), intent(in) :: shaft

         if (inertia > 0 .or. shaft%rigid) return
         call checker%complain(name, real_text(inertia), 'must be > 0 kg m^2, or the '//which// &
                               ' shaft must have rigid = .true.')
      end subroutine check_end

   end subroutine check_consistency

   !> A mesh has either stiffness or stiffness_table, and harmonics of the stiffness from one source.
   subroutine check_stiffness(mesh, wrong, checker)
      type(mesh_type), intent(in) :: mesh
      !> Its drawing has a problem: what would follow from the drawing is not missed.
      logical, intent(in) :: wrong
      class(checker_type), intent(inout) :: checker
      character(*), parameter :: instead = ' or teeth and normal_module'
      logical :: harmonics

      harmonics = is_given(mesh%stiffness_cos) .or. is_given(mesh%stiffness_sin)
      if (has_table(mesh)) then
         if (is_given(mesh%table_loads)) then
            call check_loads(mesh, checker)
         else if (size(mesh%stiffness_table) < 4) then
            call checker%complain('stiffness_table', integer_text(size(mesh%stiffness_table))//' values', 'must be at least 4')
         end if
         if (mesh%stiffness > 0) call checker%complain('stiffness', real_text(mesh%stiffness), &
                                                       'contradicts stiffness_table: leave out one of the two')
         if (mesh%contact_ratio > 0) call checker%complain('contact_ratio', real_text(mesh%contact_ratio), &
                                                           'contradicts stiffness_table: leave out one of the two')
         if (harmonics) call checker%complain('stiffness_table', '...', &
                                              'contradicts stiffness_cos, stiffness_sin: leave out one of the two')
      else if (is_given(mesh%table_loads)) then
         call checker%lacks('stiffness_table', 'for each of the table_loads', '')
      else if (mesh%stiffness > 0 .or. has_stiffness(mesh) .or. wrong) then
         continue
      else if (has_geometry(mesh)) then
         call checker%lacks('face_width', '> 0 m', ' or stiffness or stiffness_table')
      else
         call checker%lacks('stiffness', '> 0 N/m', ' or stiffness_table, or teeth, normal_module and face_width')
      end if
      if (is_given(mesh%error_table)) then
         if (size(mesh%error_table) < 4) &
            call checker%complain('error_table', integer_text(size(mesh%error_table))//' values', 'must be at least 4')
         if (is_given(mesh%error_cos) .or. is_given(mesh%error_sin)) &
            call checker%complain('error_table', '...', 'contradicts error_cos, error_sin: leave out one of the two')
      end if
      if (.not. has_geometry(mesh) .and. .not. wrong) then
         if (.not. abs(mesh%driving_radius) > 0) call checker%lacks('driving_radius', '> 0 m', instead)
         if (.not. abs(mesh%driven_radius) > 0) call checker%lacks('driven_radius', '> 0 m', instead)
      end if
      if (mesh%contact_ratio > 0 .and. harmonics) call checker%complain('contact_ratio', real_text(mesh%contact_ratio), &
         'contradicts stiffness_cos, stiffness_sin: leave out one of the two')
   end subroutine check_stiffness

   !> Loads ascend, each has the stiffness at the instants of a cycle, and the deflection grows with the load. Teeth of other
   !> stiffness are not combined with them, and a mesh without backlash has no stages.
   subroutine check_loads(mesh, checker)
      type(mesh_type), intent(in) :: mesh
      class(checker_type), intent(inout) :: checker
      integer :: i, n

      n = size(mesh%table_loads)
      if (n < 2 .or. any(.not. mesh%table_loads(2:) > 1.01_dp*mesh%table_loads(:n - 1))) then
         call checker%complain('table_loads', '...', 'must be two or more loads that ascend by 1 % or more; leave it out where &
                                                     &the stiffness does not depend on the load')
      else if (modulo(size(mesh%stiffness_table), n) /= 0 .or. size(mesh%stiffness_table) < 4*n) then
         call checker%complain('stiffness_table', integer_text(size(mesh%stiffness_table))//' values', 'must be equally many, 4 or &
                                                  &more, for each of the '//integer_text(n)//' table_loads')
      else if (all(mesh%stiffness_table > 0)) then
         i = falling_instant(mesh%table_loads, mesh%stiffness_table)
         if (i > 0) call checker%complain('stiffness_table', '...', 'at instant '//integer_text(i)//' of the cycle the change of &
            &load over the change of deflection (load over stiffness) must be 0.01 to 100 times the stiffness')
      end if
      if (.not. (mesh%half_backlash > 0 .or. mesh%backlash > 0)) &
         call checker%complain('table_loads', '...', 'needs half_backlash or backlash > 0 m: a mesh that never parts has no stages')
      if (any([(is_given(mesh%gear_error(i)%tooth_stiffness), i=1, 2)])) call checker%complain('table_loads', '...', &
         'contradicts driving_tooth_stiffness, driven_tooth_stiffness: leave out one of the two')
   end subroutine check_loads

   !> A mesh without backlash has no variables of back flanks.
   subroutine check_back(mesh, plain, checker)
      !> The mesh as given and in plain numbers.
      type(mesh_type), intent(in) :: mesh, plain
      class(checker_type), intent(inout) :: checker
      character(*), parameter :: cure = 'contradicts half_backlash = 0, of a mesh that never parts and has no back flanks of its &
         &own: leave out one of the two'

      if (plain%half_backlash > 0) return
      if (mesh%back_stiffness > 0) call checker%complain('back_stiffness', real_text(mesh%back_stiffness), cure)
      if (abs(mesh%back_phase) > 0) call checker%complain('back_phase', real_text(mesh%back_phase), cure)
   end subroutine check_back

   !> A rigid shaft has neither stiffness nor damping; an elastic one has stiffness.
   subroutine check_shaft(shaft, wrong, checker)
      type(shaft_type), intent(in) :: shaft
      !> Its drawing has a problem: the stiffness is not missed.
      logical, intent(in) :: wrong
      class(checker_type), intent(inout) :: checker
      character(*), parameter :: cure = 'contradicts rigid = .true.: leave out one of the two'

      if (shaft%rigid) then
         if (abs(shaft%stiffness) > 0) call checker%complain('stiffness', real_text(shaft%stiffness), cure)
         if (abs(shaft%damping_ratio) > 0) call checker%complain('damping_ratio', real_text(shaft%damping_ratio), cure)
         if (shaft%damping_given .or. abs(shaft%damping) > 0) &
            call checker%complain('damping', real_text(shaft%damping), cure)
         if (is_given(shaft%diameter)) call checker%complain('diameter', real_text(shaft%diameter(1)), cure)
      else if (.not. (abs(shaft%stiffness) > 0 .or. has_sections(shaft) .or. wrong)) then
         call checker%lacks('stiffness', '> 0 N m/rad', ' or rigid = .true., or diameter and length')
      end if
   end subroutine check_shaft

end module geartrain_network_check_train
