!> Warnings of planetary sets: places and phases that cannot be, and how planets bear at rest.
module geartrain_report_planetary_warnings
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_base_field, only: text_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_numbers, only: counted, integer_text, real_text, short => text
   use geartrain_drawing_drawing, only: has_geometry, pair_of
   use geartrain_drawing_gear_pair, only: find_geometry, pair_geometry_type
   use geartrain_network_system, only: system_type
   use geartrain_report_add_warning, only: add_warning
   use geartrain_train_bodies, only: find_carriers, find_ends
   use geartrain_train_kinematics, only: greatest_divisor
   use geartrain_train_labels, only: label_length, mesh_labels
   use geartrain_train_mesh, only: is_given, mesh_type
   use geartrain_train_planetary_sets, only: find_sets, planetary_set_type, same_gears
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: warn_of_planet_loads, warn_of_planets

   !> Difference of lags that is no rounding of given decimals [cycles].
   real(dp), parameter :: least_difference = 0.01_dp
   !> Difference of two centre distances that is no rounding [1]; inertia of a part over a disc that is in another unit [1]; density
   !> of steel [kg/m^3].
   real(dp), parameter :: near = 2e-3_dp, heavy = 50, steel = 7850

contains

   !> Warns of places of planets, and of phases, that cannot be.
   subroutine warn_of_planets(train, plain, warnings)
      !> The train as given, and the plain train.
      type(train_type), intent(in) :: train, plain
      !> A sentence each.
      type(text_type), allocatable, intent(inout) :: warnings(:)
      type(planetary_set_type), allocatable :: sets(:)

      call find_sets(plain, sets)
      call warn_of_locked(plain, warnings)
      call warn_of_phases(train, plain, sets, warnings)
      call warn_of_places(train, plain, sets, warnings)
   end subroutine warn_of_planets

   !> Warns of teeth that stand still: at which place of their cycle is not known.
   subroutine warn_of_locked(plain, warnings)
      type(train_type), intent(in) :: plain
      type(text_type), allocatable, intent(inout) :: warnings(:)
      character(label_length) :: labels(size(plain%meshes))
      character(:), allocatable :: words
      integer :: i

      labels = mesh_labels(plain)
      do i = 1, size(plain%meshes)
         if (.not. plain%meshes(i)%locked .or. any(plain%meshes(:i - 1)%carrier == plain%meshes(i)%carrier)) cycle
         words = ' stand still'
         if (plain%meshes(i)%carrier /= '') words = " turn as one with their carrier '"//trim(plain%meshes(i)%carrier)//"'"
         call add_warning(warnings, 'mesh', i, 'the gears of '//trim(labels(i))//words//': here and in its other meshes teeth &
                          &stand still, at a place of the cycle that is not known, and bear with their mean stiffness')
      end do
   end subroutine warn_of_locked

   !> Warns of planets that are at two distances from the axis of their carrier by the drawings of their meshes, and of planets that
   !> are far heavier than full discs of steel.
   subroutine warn_of_places(train, plain, sets, warnings)
      type(train_type), intent(in) :: train, plain
      type(planetary_set_type), intent(in) :: sets(:)
      type(text_type), allocatable, intent(inout) :: warnings(:)
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      integer :: s, t

      call find_ends(plain, shaft_ends, mesh_ends)
      do s = 1, size(sets)
         if (sets(s)%sun > 0 .and. sets(s)%ring > 0) call compare(sets(s)%sun_meshes(1), sets(s)%ring_meshes(1))
         if (sets(s)%sun > 0) call weigh(sets(s), sets(s)%sun_meshes(1))
         do t = s + 1, size(sets)
            if (sets(t)%carrier == sets(s)%carrier .and. on_one_axis(shaft_ends, sets(s)%planets(1), sets(t)%planets(1))) &
               call compare(sets(s)%meshes(1, 1), sets(t)%meshes(1, 1))
         end do
      end do

   contains

      subroutine compare(one, other)
         integer, intent(in) :: one, other
         character(label_length) :: labels(size(train%meshes))
         type(pair_geometry_type) :: geometry(2)

         if (.not. (has_geometry(train%meshes(one)) .and. has_geometry(train%meshes(other)))) return
         call find_geometry(pair_of(train%meshes(one)), geometry(1))
         call find_geometry(pair_of(train%meshes(other)), geometry(2))
         if (abs(geometry(1)%centre_distance - geometry(2)%centre_distance) <= near*geometry(1)%centre_distance) return
         labels = mesh_labels(train)
         call add_warning(warnings, 'mesh', other, 'the drawing of '//trim(labels(other))//' has the axes '// &
                          short(geometry(2)%centre_distance)//' m apart, and the drawing of '//trim(labels(one))//' '// &
                          short(geometry(1)%centre_distance)//' m: a planet is at one distance from the axis of its carrier')
      end subroutine compare

      !> Compares the inertia of a planet, and the mass that the carrier has of all, with discs of the pitch diameter.
      subroutine weigh(set, mesh)
         type(planetary_set_type), intent(in) :: set
         integer, intent(in) :: mesh
         type(pair_geometry_type) :: geometry
         real(dp) :: mass, diameter

         if (.not. has_geometry(train%meshes(mesh)) .or. .not. train%meshes(mesh)%face_width > 0) return
         call find_geometry(pair_of(train%meshes(mesh)), geometry)
         diameter = geometry%reference_diameter(findloc(mesh_ends(:, mesh), set%planets(1), 1))
         mass = steel*train%meshes(mesh)%face_width*pi/4*diameter**2
         call tell(set%planets(1), 'inertia', plain%bodies(set%planets(1))%inertia, mass*diameter**2/8)
         call tell(set%carrier, 'added_inertia', train%bodies(set%carrier)%added_inertia, &
                   size(set%planets)*mass*geometry%centre_distance**2)
      end subroutine weigh

      subroutine tell(body, name, value, disc)
         integer, intent(in) :: body
         character(*), intent(in) :: name
         real(dp), intent(in) :: value, disc

         if (value > heavy*disc) call add_warning(warnings, 'body', body, name//' = '//real_text(value)//' of '//"'"// &
            train%bodies(body)%name//"'"//': planets that are full discs of steel, as wide as their teeth, have '//short(disc)// &
            '; the units are kg and kg m^2')
      end subroutine tell

   end subroutine warn_of_places

   !> Whether two bodies are one, or joined by a shaft.
   pure logical function on_one_axis(shaft_ends, one, other)
      !> Bodies at the ends of the shafts, (2, shaft).
      integer, intent(in) :: shaft_ends(:, :)
      integer, intent(in) :: one, other
      integer :: i

      on_one_axis = one == other .or. any([(all(shaft_ends(:, i) == [one, other] .or. shaft_ends(:, i) == [other, one]), &
                                           i=1, size(shaft_ends, 2))])
   end function on_one_axis

   !> Warns of phases that no angles of planets give. Turned from one planet to another, a set is the same a while later: by that
   !> all meshes of the planet lag behind their likes, z_s psi cycles by the angle psi [turns]. Places that fit are 1/(z_s + z_r)
   !> turns apart, and gcd(z_s, z_r) of them have the same lag.
   subroutine warn_of_phases(train, plain, sets, warnings)
      type(train_type), intent(in) :: train, plain
      type(planetary_set_type), intent(in) :: sets(:)
      type(text_type), allocatable, intent(inout) :: warnings(:)
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :), own(:)
      integer :: carrier(size(train%meshes)), i, k, s, like
      logical :: told(size(train%meshes))

      call find_ends(plain, shaft_ends, mesh_ends)
      call find_carriers(plain, carrier)
      told = .false.
      do s = 1, size(sets)
         own = sets(s)%meshes(1, :)
         do i = 1, size(train%meshes)
            if (carrier(i) /= sets(s)%carrier .or. any(own == i) .or. told(i)) cycle
            if (.not. varies(plain%meshes(i))) cycle
            if (.not. any(abs(plain%meshes(own)%order - plain%meshes(i)%order) == 0)) cycle
            k = findloc([(any(mesh_ends(:, i) == sets(s)%planets(k)), k=1, size(own))], .true., 1)
            if (k < 2) cycle
            like = alike_at_first(i, findloc(mesh_ends(:, i), sets(s)%planets(k), 1))
            if (like == 0) cycle
            call compare(i, like, own(k), own(1))
         end do
         if (sets(s)%sun > 0 .and. sets(s)%ring > 0) call count_places(sets(s))
      end do

   contains

      !> The only mesh of the first planet that has the gears of mesh i; 0: none.
      integer function alike_at_first(i, side)
         integer, intent(in) :: i, side
         integer :: j

         alike_at_first = 0
         do j = 1, size(carrier)
            if (carrier(j) /= carrier(i) .or. mesh_ends(side, j) /= sets(s)%planets(1)) cycle
            if (.not. same_gears(plain%meshes(i), plain%meshes(j))) cycle
            if (alike_at_first > 0) then
               alike_at_first = 0
               return
            end if
            alike_at_first = j
         end do
      end function alike_at_first

      !> Compares how far a mesh lags behind its like with how far another of the same planet does.
      subroutine compare(i, like, other, first)
         integer, intent(in) :: i, like, other, first
         character(label_length) :: labels(size(train%meshes))
         real(dp) :: wanted

         wanted = (train%meshes(other)%phase - train%meshes(first)%phase)/(2*pi)
         associate (found => (train%meshes(i)%phase - train%meshes(like)%phase)/(2*pi))
            if (abs(modulo(found - wanted + 0.5_dp, 1.0_dp) - 0.5_dp) < least_difference) return
            told(i) = .true.
            labels = mesh_labels(train)
            call add_warning(warnings, 'mesh', i, 'phase: '//trim(labels(i))//' lags '//short(modulo(found, 1.0_dp))// &
                             ' cycles behind '//trim(labels(like))//', but '//trim(labels(other))//' lags '// &
                             short(modulo(wanted, 1.0_dp))//' behind '//trim(labels(first))//': by the place of the planet both &
                             &are equal, as with phase = '//short(modulo(train%meshes(like)%phase + 2*pi*wanted, 2*pi)))
         end associate
      end subroutine compare

      !> More planets with the same lag than there are such places.
      subroutine count_places(set)
         type(planetary_set_type), intent(in) :: set
         real(dp) :: lag(size(set%planets))
         integer :: teeth(2), k, alike, places

         associate (sun => train%meshes(set%sun_meshes), ring => train%meshes(set%ring_meshes(1)))
            if (.not. (is_given(sun(1)%teeth) .and. is_given(ring%teeth)) .or. .not. varies(plain%meshes(set%sun_meshes(1)))) return
            teeth = nint([sun(1)%teeth(findloc(mesh_ends(:, set%sun_meshes(1)), set%sun, 1)), maxval(ring%teeth)])
            places = int(greatest_divisor(int(teeth(1), int64), int(teeth(2), int64)))
            lag = (sun%phase - sun(1)%phase)/(2*pi)
            do k = 1, size(lag)
               alike = count(abs(modulo(lag - lag(k) + 0.5_dp, 1.0_dp) - 0.5_dp) < least_difference)
               if (alike <= places) cycle
               call add_warning(warnings, 'mesh', set%sun_meshes(k), 'phase: '//integer_text(alike)// &
                                ' planets have this phase, but with '//integer_text(teeth(1))//' and '//integer_text(teeth(2))// &
                                ' teeth '//counted(places, 'place has', 'places have')// &
                                ' it: a planet psi turns further on lags by '//integer_text(teeth(1))//' psi cycles')
               return
            end do
         end associate
      end subroutine count_places

   end subroutine warn_of_phases

   !> Warns of how planets bear at rest, where meshes have a drawing.
   subroutine warn_of_planet_loads(train, plain, system, agreed, warnings)
      !> The train as given, and the plain train.
      type(train_type), intent(in) :: train, plain
      !> Its system.
      type(system_type), intent(in) :: system
      !> Whether mesh stiffnesses and light loads were found together.
      logical, intent(in) :: agreed
      !> A sentence each.
      type(text_type), allocatable, intent(inout) :: warnings(:)

      type(planetary_set_type), allocatable :: sets(:)

      if (.not. agreed) call add_warning(warnings, 'train', 0, 'the mesh stiffnesses of light loads and the loads that follow from &
         &them do not agree within 200 passes, and load shares are uncertain; give stiffness [N/m]')
      call find_sets(plain, sets)
      call warn_of_coast_flanks(train, plain, sets, system, warnings)
      call warn_of_pulling_planets(plain, sets, system, warnings)
   end subroutine warn_of_planet_loads

   !> Warns of planets whose teeth pull at rest, as they have no backlash in which they would be unloaded.
   subroutine warn_of_pulling_planets(plain, sets, system, warnings)
      type(train_type), intent(in) :: plain
      type(planetary_set_type), intent(in) :: sets(:)
      type(system_type), intent(in) :: system
      type(text_type), allocatable, intent(inout) :: warnings(:)
      integer, allocatable :: meshes(:)
      integer :: i, k

      do i = 1, size(sets)
         meshes = sets(i)%meshes(1, :)
         if (any(plain%meshes(meshes)%half_backlash > 0)) cycle
         associate (force => system%static_force(system%mesh_element(meshes)))
            if (.not. (minval(force) < 0 .and. maxval(force) > 0)) cycle
            k = merge(minloc(force, 1), maxloc(force, 1), sum(force) > 0)
         end associate
         call add_warning(warnings, 'mesh', meshes(k), 'the teeth of this planet of '//trim(sets(i)%name)//' pull at rest, as they &
            &have no backlash in which they part: a set with backlash has other load shares')
      end do
   end subroutine warn_of_pulling_planets

   !> Warns of planetary sets whose drawing has the phases of the flanks that do not bear.
   subroutine warn_of_coast_flanks(train, plain, sets, system, warnings)
      type(train_type), intent(in) :: train, plain
      type(planetary_set_type), intent(in) :: sets(:)
      type(system_type), intent(in) :: system
      type(text_type), allocatable, intent(inout) :: warnings(:)
      integer, allocatable :: meshes(:)
      integer :: i, k

      do i = 1, size(sets)
         if (sets(i)%sun == 0 .or. sets(i)%ring == 0) cycle
         meshes = reshape(sets(i)%meshes, [size(sets(i)%meshes)])
         if (.not. all([(has_geometry(train%meshes(meshes(k))), k=1, size(meshes))])) cycle
         associate (force => system%static_force(system%mesh_element(meshes)))
            if (maxval(force) > 0 .or. .not. minval(force) < 0) cycle
         end associate
         if (.not. any([(varies(plain%meshes(meshes(k))), k=1, size(meshes))])) cycle
         call add_warning(warnings, 'mesh', meshes(1), 'all meshes of '//trim(sets(i)%name)//' bear on their coast flanks: the &
            &default of ring_phase, and the sign of planet_errors, are those of the flanks on which the member that is &
            &''driving'' pushes: name the other member')
      end do
   end subroutine warn_of_coast_flanks

   !> Whether the stiffness or the transmission error of a mesh varies, or displaces it.
   pure logical function varies(mesh)
      type(mesh_type), intent(in) :: mesh

      varies = abs(mesh%error_mean) > 0
      if (allocated(mesh%stiffness_cos)) varies = varies .or. any(abs(mesh%stiffness_cos) > 0)
      if (allocated(mesh%stiffness_sin)) varies = varies .or. any(abs(mesh%stiffness_sin) > 0)
      if (allocated(mesh%error_cos)) varies = varies .or. any(abs(mesh%error_cos) > 0)
      if (allocated(mesh%error_sin)) varies = varies .or. any(abs(mesh%error_sin) > 0)
   end function varies

end module geartrain_report_planetary_warnings
