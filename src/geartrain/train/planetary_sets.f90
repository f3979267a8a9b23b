!> The planetary sets of a train, found in its meshes: planets on one carrier that mesh with a common sun or ring, as written by
!> hand or expanded from &planetary.
module geartrain_train_planetary_sets
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_numbers, only: integer_text
   use geartrain_train_bodies, only: find_carriers, find_ends
   use geartrain_train_body, only: name_length
   use geartrain_train_mesh, only: mesh_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: find_sets, planetary_set_type, same_gears, torsion_share

   !> Difference of the radii of equal gears that counts as rounding [1].
   real(dp), parameter :: rounding = 1e-9_dp

   !> Meshes of equal planets with one gear.
   type :: group_type
      !> The common gear and the carrier; whether the common gear is a ring.
      integer :: gear = 0, carrier = 0
      logical :: ring = .false.
      !> The meshes; the planets, (mesh).
      integer, allocatable :: meshes(:), planets(:)
   end type group_type

   !> A planetary set.
   type :: planetary_set_type
      !> Name of the set of which the names of its meshes tell, else 'planetary 1', ...
      character(name_length) :: name = ''
      !> Bodies: sun and ring, 0: none; carrier; planets, (planet).
      integer :: sun = 0, ring = 0, carrier = 0
      integer, allocatable :: planets(:)
      !> Meshes with sun and ring; of no value where there is none, (planet).
      integer, allocatable :: sun_meshes(:), ring_meshes(:)
      !> All meshes, the one with the sun first where there is one, (mesh of a planet, planet).
      integer, allocatable :: meshes(:, :)
   end type planetary_set_type

contains

   !> Finds the planetary sets of at least two planets.
   pure subroutine find_sets(train, sets)
      !> A plain train that has passed `check_train`.
      type(train_type), intent(in) :: train
      !> The sets, in the order of their first meshes.
      type(planetary_set_type), allocatable, intent(out) :: sets(:)
      type(group_type), allocatable :: groups(:)
      type(planetary_set_type) :: set
      logical, allocatable :: left(:)
      integer :: i, j, k

      allocate (sets(0))
      call find_groups(train, groups)
      allocate (left(size(groups)), source=.true.)
      do i = 1, size(groups)
         if (.not. left(i)) cycle
         left(i) = .false.
         set = planetary_set_type()
         call take(groups(i), set)
         do j = i + 1, size(groups)
            if (.not. left(j) .or. groups(j)%carrier /= groups(i)%carrier .or. (groups(j)%ring .eqv. groups(i)%ring)) cycle
            if (size(groups(j)%planets) /= size(groups(i)%planets)) cycle
            if (.not. all([(any(groups(j)%planets == set%planets(k)), k=1, size(set%planets))])) cycle
            left(j) = .false.
            call take(groups(j), set)
            exit
         end do
         call join_meshes(set)
         call find_name(train, size(sets) + 1, set)
         sets = [sets, set]
      end do
   end subroutine find_sets

   !> Takes the meshes of a group into a set, in the order of its planets.
   pure subroutine take(group, set)
      type(group_type), intent(in) :: group
      type(planetary_set_type), intent(inout) :: set
      integer, allocatable :: meshes(:)
      integer :: k

      set%carrier = group%carrier
      if (.not. allocated(set%planets)) set%planets = group%planets
      allocate (meshes(size(set%planets)))
      do k = 1, size(meshes)
         meshes(k) = group%meshes(findloc(group%planets, set%planets(k), 1))
      end do
      if (group%ring) then
         set%ring = group%gear
         set%ring_meshes = meshes
      else
         set%sun = group%gear
         set%sun_meshes = meshes
      end if
   end subroutine take

   !> Sets the meshes of each planet.
   pure subroutine join_meshes(set)
      type(planetary_set_type), intent(inout) :: set

      allocate (set%meshes(count([set%sun, set%ring] > 0), size(set%planets)))
      if (set%sun > 0) set%meshes(1, :) = set%sun_meshes
      if (set%ring > 0) set%meshes(size(set%meshes, 1), :) = set%ring_meshes
   end subroutine join_meshes

   !> Finds meshes of equal numbers on one carrier with a common gear.
   pure subroutine find_groups(train, groups)
      type(train_type), intent(in) :: train
      type(group_type), allocatable, intent(out) :: groups(:)
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      integer :: carrier(size(train%meshes)), m, side, j, found(size(train%meshes)), n
      logical :: used(size(train%meshes))
      type(group_type) :: group

      allocate (groups(0))
      call find_ends(train, shaft_ends, mesh_ends)
      call find_carriers(train, carrier)
      used = .false.
      do m = 1, size(train%meshes)
         if (used(m) .or. carrier(m) <= 0) cycle
         do side = 1, 2
            n = 0
            do j = m, size(train%meshes)
               if (used(j) .or. carrier(j) /= carrier(m)) cycle
               if (mesh_ends(side, j) /= mesh_ends(side, m) .or. &
                   .not. same_gears(train%meshes(m), train%meshes(j))) cycle
               n = n + 1
               found(n) = j
            end do
            if (n < 2) cycle
            group%gear = mesh_ends(side, m)
            group%carrier = carrier(m)
            group%meshes = found(:n)
            group%planets = mesh_ends(3 - side, found(:n))
            associate (radii => [train%meshes(m)%driving_radius, train%meshes(m)%driven_radius])
               group%ring = train%meshes(m)%internal .and. radii(side) > radii(3 - side)
            end associate
            groups = [groups, group]
            used(found(:n)) = .true.
            exit
         end do
      end do

   end subroutine find_groups

   !> Whether two meshes have equal gears.
   pure logical function same_gears(one, other)
      !> The meshes.
      type(mesh_type), intent(in) :: one, other

      same_gears = (one%internal .eqv. other%internal) .and. &
                   abs(one%driving_radius - other%driving_radius) <= rounding*one%driving_radius .and. &
                   abs(one%driven_radius - other%driven_radius) <= rounding*one%driven_radius
   end function same_gears

   !> Sets the name of a set: what the names of its meshes begin with, 'stage 1 sun 2'.
   pure subroutine find_name(train, number, set)
      type(train_type), intent(in) :: train
      !> Number of the set.
      integer, intent(in) :: number
      type(planetary_set_type), intent(inout) :: set

      set%name = 'planetary '//integer_text(number)
      if (allocated(set%sun_meshes)) call read_name(train%meshes(set%sun_meshes(1))%name, ' sun 1', set%name)
      if (allocated(set%ring_meshes)) call read_name(train%meshes(set%ring_meshes(1))%name, ' ring 1', set%name)
   end subroutine find_name

   !> Takes the name of a set from the name of its first mesh.
   pure subroutine read_name(mesh, ending, name)
      !> Name of the mesh; ending of the name of a mesh that was expanded.
      character(*), intent(in) :: mesh, ending
      !> Name of the set; left as it is where the mesh has another name.
      character(*), intent(inout) :: name

      if (len_trim(mesh) <= len(ending)) return
      if (mesh(len_trim(mesh) - len(ending) + 1:) == ending) name = mesh(:len_trim(mesh) - len(ending))
   end subroutine read_name

   !> Share of a harmonic that reaches the torsion of the common gear [1]: |sum over the planets of exp(i h phase)|/planets, where
   !> all planets have equal amplitudes. 1: the forces of all planets add up; 0: they cancel.
   pure real(dp) function torsion_share(harmonic, phase)
      !> Harmonic of the mesh frequency.
      integer, intent(in) :: harmonic
      !> Lags of the meshes [rad of the mesh cycle], (planet).
      real(dp), intent(in) :: phase(:)

      torsion_share = abs(sum(exp(cmplx(0.0_dp, modulo(harmonic*phase, 2*pi), dp))))/size(phase)
   end function torsion_share

end module geartrain_train_planetary_sets
