!> Expands the planetary sets of a train: each becomes the bodies of its planets, and their meshes with sun and ring. The train then
!> has bodies, shafts and meshes only.
module geartrain_drawing_planetary_expansion
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_numbers, only: integer_text, whole
   use geartrain_drawing_check_planetary, only: check_rows, check_set
   use geartrain_drawing_planetary_meshes, only: planet_name, ring_lag, ring_meshes, set_type, sun_meshes
   use geartrain_train_bearing_rows, only: add_rows
   use geartrain_train_body, only: body_type
   use geartrain_train_mesh, only: is_given, mesh_type
   use geartrain_train_planetary, only: planetary_type
   use geartrain_train_planetary_variables, only: visit_planetary
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: expand_planetaries, expansion_type, expand_sets

   !> Where the bodies and meshes of an expanded train come from.
   type :: expansion_type
      !> Number of the planetary set of each body and each gear pair, 0: as given, (body), (mesh).
      integer, allocatable :: set_of_body(:), set_of_mesh(:)
      !> Kind of each gear pair: `sun_meshes`, `ring_meshes` or 0, (mesh).
      integer, allocatable :: kind_of_mesh(:)
      !> Whether a set could not be expanded.
      logical :: failed = .false.
   end type expansion_type

contains

   !> Checks and expands the planetary sets of a train that a program made, and adds rows of bearings with more than four flats.
   !> `check_train` wants a train without sets, with all rows.
   subroutine expand_planetaries(train, error)
      !> The train; it then has no planetary sets.
      type(train_type), intent(inout) :: train
      type(error_type), allocatable, intent(out) :: error
      type(checker_type) :: checker
      type(expansion_type) :: expansion
      integer :: i

      if (.not. allocated(train%planetaries)) then
         if (allocated(train%meshes)) call add_rows(train%meshes)
         return
      end if
      do i = 1, size(train%planetaries)
         call visit_planetary(train%planetaries(i), i, checker)
      end do
      call expand_sets(train, checker, expansion)
      call checker%problems%raise('', error)
   end subroutine expand_planetaries

   !> Expands the planetary sets and the bearings of a train. The range of each value is checked elsewhere.
   subroutine expand_sets(train, checker, expansion)
      !> The train; it then has no planetary sets. A set with problems is left out.
      type(train_type), intent(inout) :: train
      !> Gets the problems of the sets.
      class(checker_type), intent(inout) :: checker
      !> Where bodies and meshes come from.
      type(expansion_type), intent(out) :: expansion
      type(planetary_type), allocatable :: sets(:)
      type(set_type) :: numbers
      integer :: i, before

      if (.not. allocated(train%bodies)) expansion%set_of_body = [integer ::]
      if (allocated(train%bodies)) allocate (expansion%set_of_body(size(train%bodies)), source=0)
      if (.not. allocated(train%meshes)) allocate (train%meshes(0))
      if (.not. allocated(train%shafts)) allocate (train%shafts(0))
      allocate (expansion%set_of_mesh(count(train%meshes%is_pair())), source=0)
      allocate (expansion%kind_of_mesh(size(expansion%set_of_mesh)), source=0)
      call add_rows(train%meshes)
      if (.not. allocated(train%planetaries)) return
      call move_alloc(train%planetaries, sets)
      do i = 1, size(sets)
         before = checker%problems%count
         call numbers%setup(sets(i))
         call check_set(sets, i, numbers, train, checker)
         expansion%failed = checker%problems%in_group('planetary')
         if (checker%problems%count == before .and. .not. expansion%failed) then
            call check_rows(sets, i, numbers, train, checker)
            call put_set(i)
         end if
      end do

   contains

      !> Adds the bodies and meshes of a set.
      subroutine put_set(i)
         !> Number of the set.
         integer, intent(in) :: i
         integer :: n

         associate (set => sets(i), bodies => train%bodies)
            do n = 1, size(bodies)
               if (bodies(n)%name == set%carrier) bodies(n)%added_inertia = bodies(n)%added_inertia + carried_inertia(set, numbers)
            end do
            call place_meshes(set, numbers, train)
            call add_planets(set, numbers%planets, train)
            expansion%set_of_body = [expansion%set_of_body, [(i, n=1, numbers%planets)]]
            if (numbers%has(sun_meshes)) call add_meshes(set, numbers, sun_meshes, train)
            if (numbers%has(ring_meshes)) call add_meshes(set, numbers, ring_meshes, train)
            if (numbers%has(sun_meshes)) call note(sun_meshes)
            if (numbers%has(ring_meshes)) call note(ring_meshes)
         end associate
      end subroutine put_set

      subroutine note(kind)
         integer, intent(in) :: kind
         integer :: n

         expansion%set_of_mesh = [expansion%set_of_mesh, [(i, n=1, numbers%planets)]]
         expansion%kind_of_mesh = [expansion%kind_of_mesh, [(kind, n=1, numbers%planets)]]
      end subroutine note

   end subroutine expand_sets

   !> Inertia of the masses of the planets about the axis of the carrier [kg m^2].
   pure real(dp) function carried_inertia(set, numbers) result(inertia)
      type(planetary_type), intent(in) :: set
      type(set_type), intent(in) :: numbers
      real(dp) :: mass

      mass = set%planet_mass
      if (mass < 0) mass = pi*set%density*set%face_width*max(0.0_dp, pitch_diameter(set)**2 - set%planet_bore**2)/4
      inertia = numbers%planets*mass*numbers%centre_distance**2
   end function carried_inertia

   !> Pitch diameter of the planets [m].
   pure real(dp) function pitch_diameter(set)
      type(planetary_type), intent(in) :: set

      pitch_diameter = set%teeth(2)*set%normal_module/cos(set%helix_angle*pi/180)
   end function pitch_diameter

   !> Sets the phases of meshes of planets that were written by hand, as those between the planets of two sets, where they have
   !> none: the mesh of a planet lags behind the mesh of the first planet as its mesh with the sun does.
   pure subroutine place_meshes(set, numbers, train)
      type(planetary_type), intent(in) :: set
      type(set_type), intent(in) :: numbers
      type(train_type), intent(inout) :: train
      integer :: kind, i, j, n, side, like, alike, end_of_first

      kind = merge(sun_meshes, ring_meshes, numbers%has(sun_meshes))
      do i = 1, size(train%meshes)
         if (train%meshes(i)%carrier /= set%carrier .or. abs(train%meshes(i)%phase) > 0) cycle
         do side = 1, 2
            n = findloc([(planet_name(set, j) == train%meshes(i)%between(side), j=1, numbers%planets)], .true., 1)
            if (n < 2) cycle
            alike = 0
            do j = 1, size(train%meshes)
               end_of_first = findloc(train%meshes(j)%between == planet_name(set, 1), .true., 1)
               if (end_of_first == 0) cycle
               if (.not. same_teeth(train%meshes(i), train%meshes(j), end_of_first /= side)) cycle
               like = j
               alike = alike + 1
            end do
            if (alike /= 1) cycle
            train%meshes(i)%phase = train%meshes(like)%phase + &
                                    2*pi*numbers%lag(kind, n, whole(set%teeth(merge(1, 3, kind == sun_meshes))))
         end do
      end do
   end subroutine place_meshes

   !> Whether two meshes have gears of equal teeth, and a common carrier.
   pure logical function same_teeth(one, other, turned)
      type(mesh_type), intent(in) :: one, other
      !> The driving gear of one is the driven gear of the other.
      logical, intent(in) :: turned

      same_teeth = one%carrier == other%carrier .and. is_given(one%teeth) .and. is_given(other%teeth)
      if (same_teeth) same_teeth = size(one%teeth) == size(other%teeth)
      if (.not. same_teeth) return
      if (turned) same_teeth = all(abs(one%teeth(size(one%teeth):1:-1) - other%teeth) <= 0)
      if (.not. turned) same_teeth = all(abs(one%teeth - other%teeth) <= 0)
   end function same_teeth

   subroutine add_planets(set, planets, train)
      type(planetary_type), intent(in) :: set
      !> Number of planets.
      integer, intent(in) :: planets
      type(train_type), intent(inout) :: train
      type(body_type) :: bodies(size(train%bodies) + planets)
      integer :: n, given

      given = size(train%bodies)
      bodies(:given) = train%bodies
      do n = 1, planets
         bodies(given + n)%name = trim(planet_name(set, n))
         bodies(given + n)%inertia = set%planet_inertia
      end do
      train%bodies = bodies
   end subroutine add_planets

   !> Adds the meshes of the planets with the sun or with the ring.
   subroutine add_meshes(set, numbers, kind, train)
      type(planetary_type), intent(in) :: set
      type(set_type), intent(in) :: numbers
      !> `sun_meshes` or `ring_meshes`.
      integer, intent(in) :: kind
      type(train_type), intent(inout) :: train
      type(mesh_type) :: meshes(size(train%meshes) + numbers%planets)
      real(dp) :: lag
      integer :: n, given

      ! Couplings and bearings stay the last.
      given = count(train%meshes%is_pair())
      meshes(:given) = train%meshes(:given)
      meshes(given + numbers%planets + 1:) = train%meshes(given + 1:)
      do n = 1, numbers%planets
         associate (mesh => meshes(given + n))
            mesh = numbers%mesh(kind)
            mesh%name = set%name//trim(merge(' sun  ', ' ring ', kind == sun_meshes))//' '//integer_text(n)
            where (mesh%between == planet_name(set, 1)) mesh%between = planet_name(set, n)
            lag = numbers%lag(kind, n, whole(set%teeth(2*kind - 1)))
            if (kind == ring_meshes .and. numbers%has(sun_meshes)) then
               if (set%ring_phase_given) lag = lag + set%ring_phase/(2*pi)
               if (.not. set%ring_phase_given) lag = lag + ring_lag(set, numbers)
            end if
            mesh%phase = 2*pi*modulo(lag, 1.0_dp)
            ! A planet that sits back against the push has both its meshes deflected more.
            if (is_given(set%planet_errors)) mesh%error_mean = set%planet_errors(n)
         end associate
      end do
      train%meshes = meshes
   end subroutine add_meshes

end module geartrain_drawing_planetary_expansion
