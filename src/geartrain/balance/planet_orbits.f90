!> Motions that are one orbit up to the symmetry of planetary sets: a turn of the planets makes one of the other.
module geartrain_balance_planet_orbits
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_same_motion, only: is_same_motion
   use geartrain_base_kinds, only: dp
   use geartrain_network_planet_symmetry, only: find_symmetries, symmetry_type
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: number_orbits

contains

   !> Numbers the orbits of motions of one train, from 1: motions that differ by a turn of the planets of a symmetric set have one
   !> number. Motions without period have numbers of their own.
   subroutine number_orbits(train, motions, orbit)
      !> A train that has passed `check_train`.
      type(train_type), intent(in) :: train
      !> Motions at one Lambda.
      type(motion_type), intent(in) :: motions(:)
      !> Number of the orbit of each motion, (motion).
      integer, intent(out) :: orbit(:)
      type(system_type) :: system
      type(symmetry_type), allocatable :: symmetries(:)
      integer :: i, j, orbits

      orbit = [(i, i=1, size(motions))]
      if (size(motions) < 2 .or. .not. any(train%meshes%carrier /= '')) return
      call build_system(train, system)
      call find_symmetries(train, system, symmetries)
      if (size(symmetries) == 0) return
      orbits = 0
      do i = 1, size(motions)
         orbit(i) = 0
         do j = 1, i - 1
            if (motions(i)%period == 0 .or. motions(i)%period /= motions(j)%period) cycle
            if (.not. (allocated(motions(i)%rms) .and. allocated(motions(j)%rms))) cycle
            if (.not. is_turned(symmetries, motions(i), motions(j))) cycle
            orbit(i) = orbit(j)
            exit
         end do
         if (orbit(i) > 0) cycle
         orbits = orbits + 1
         orbit(i) = orbits
      end do
   end subroutine number_orbits

   !> Whether a turn of planets makes `other` of `one`, by their figures, which no shift in time changes.
   pure logical function is_turned(symmetries, one, other)
      type(symmetry_type), intent(in) :: symmetries(:)
      type(motion_type), intent(in) :: one, other
      type(motion_type) :: turned
      integer :: place(size(one%rms)), i, k, m, n, nearest
      real(dp) :: distance, least
      integer, allocatable :: moved(:, :)

      place = [(i, i=1, size(place))]
      do i = 1, size(symmetries)
         associate (mesh => symmetries(i)%mesh)
            if (symmetries(i)%order > 0) cycle
            n = size(mesh, 2)
            moved = mesh
            if (abs(symmetries(i)%shift) > 0) then
               least = huge(least)
               nearest = 0
               do k = 0, n - 1
                  distance = apart(cshift(mesh, k, 2), mesh)
                  if (distance >= least) cycle
                  least = distance
                  nearest = k
               end do
               moved = cshift(mesh, nearest, 2)
            else
               ! Any two planets may change places: each takes the nearest of those that are left.
               do k = 1, n - 1
                  nearest = k - 1 + minloc([(apart(moved(:, m:m), mesh(:, k:k)), m=k, n)], 1)
                  moved(:, [k, nearest]) = moved(:, [nearest, k])
               end do
            end if
            place(reshape(mesh, [size(mesh)])) = reshape(moved, [size(mesh)])
         end associate
      end do
      turned%rms = one%rms(place)
      turned%mean = one%mean(place)
      turned%minimum = one%minimum(place)
      turned%maximum = one%maximum(place)
      is_turned = is_same_motion(turned, other)

   contains

      !> Difference of the figures of meshes of `one` and of meshes of `other` [1].
      pure real(dp) function apart(of_one, of_other)
         integer, intent(in) :: of_one(:, :), of_other(:, :)
         integer :: a(size(of_one)), b(size(of_other))

         a = reshape(of_one, [size(of_one)])
         b = reshape(of_other, [size(of_other)])
         apart = sum(abs(one%rms(a) - other%rms(b)) + abs(one%mean(a) - other%mean(b)) + abs(one%maximum(a) - other%maximum(b)))
      end function apart

   end function is_turned

end module geartrain_balance_planet_orbits
