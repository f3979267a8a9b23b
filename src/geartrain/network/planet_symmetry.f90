!> Symmetric planetary sets: a turn of the planets by one place leaves the train as it is, but for a shift in time where the meshes
!> of neighbouring planets are not in phase. Where other meshes of the train forbid this shift, it may be one of the phase of the
!> meshes of the set alone: so it is of motions that live on the torus of the phases of all sources of excitation.
module geartrain_network_planet_symmetry
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_series, only: series_type
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_mesh_law_law, only: law_type
   use geartrain_network_node_kinds, only: same_nodes
   use geartrain_network_system, only: system_type
   use geartrain_train_planetary_sets, only: find_sets, planetary_set_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: find_symmetries, symmetry_type

   !> Relative difference of two numbers that are equal but for rounding.
   real(dp), parameter :: rounding = 1e-9_dp

   !> A symmetric planetary set.
   type :: symmetry_type
      !> Meshes of each planet, planets in their order on the carrier, (mesh of a planet, planet).
      integer, allocatable :: mesh(:, :)
      !> Shift that goes with a turn by one place [rad of Lambda]; 0: all planets move alike, and any two may change places.
      real(dp) :: shift = 0
      !> The shift is one of the phase of meshes of this order alone; 0: in time.
      integer :: order = 0
   end type symmetry_type

contains

   !> Finds the symmetric sets of a train.
   subroutine find_symmetries(train, system, symmetries)
      !> A train that has passed `check_train`.
      type(train_type), intent(in) :: train
      type(system_type), intent(in) :: system
      !> The symmetric sets.
      type(symmetry_type), allocatable, intent(out) :: symmetries(:)
      type(train_type) :: plain
      type(planetary_set_type), allocatable :: sets(:)
      type(symmetry_type) :: symmetry
      integer :: i, k, order
      real(dp) :: cycle_of_mesh

      allocate (symmetries(0))
      if (.not. allocated(train%bodies)) return
      call plain_train(train, plain)
      call find_sets(plain, sets)
      do i = 1, size(sets)
         symmetry%mesh = sets(i)%meshes
         if (.not. equal_planets(system, sets(i)%planets, symmetry%mesh)) cycle
         cycle_of_mesh = 2*pi/system%law(symmetry%mesh(1, 1))%order
         own: do order = 0, 1
            symmetry%order = order*nint(system%law(symmetry%mesh(1, 1))%order)
            do k = 0, size(symmetry%mesh, 2) - 1
               symmetry%shift = k*cycle_of_mesh/size(symmetry%mesh, 2)
               if (.not. is_invariant(system, symmetry)) cycle
               symmetries = [symmetries, symmetry]
               exit own
            end do
         end do own
      end do
   end subroutine find_symmetries

   !> Whether the planets are equal in all but the phases of their meshes, and in no other mesh or shaft.
   pure logical function equal_planets(system, planets, mesh)
      type(system_type), intent(in) :: system
      !> Bodies that are planets, (planet); their meshes, (mesh of a planet, planet).
      integer, intent(in) :: planets(:), mesh(:, :)
      integer :: first, node, k, n, touching

      equal_planets = .false.
      first = system%network%node(planets(1))
      do n = 1, size(planets)
         node = system%network%node(planets(n))
         if (first == 0 .or. node == 0) return
         touching = 0
         do k = 1, system%elements
            associate (nodes => system%network%elements(k)%node)
               if (size(nodes) > 1 .and. any(nodes == node)) touching = touching + 1
            end associate
         end do
         if (touching /= size(mesh, 1)) return
         if (n == 1) cycle
         if (.not. same_nodes(system, first, node)) return
         do k = 1, size(mesh, 1)
            associate (one => system%network%elements(system%mesh_element(mesh(k, 1))), &
                       other => system%network%elements(system%mesh_element(mesh(k, n))))
               if (size(one%node) /= size(other%node)) return
               if (any(one%node /= other%node .and. .not. (one%node == first .and. other%node == node))) return
               if (.not. all(near([one%entry, one%stiffness, one%damping, one%error_mean], &
                                  [other%entry, other%stiffness, other%damping, other%error_mean]))) return
            end associate
         end do
      end do
      equal_planets = .true.
   end function equal_planets

   !> Whether a turn of the planets by one place, with its shift, leaves all laws of meshes, errors and torques as they are.
   pure logical function is_invariant(system, symmetry)
      type(system_type), intent(in) :: system
      type(symmetry_type), intent(in) :: symmetry
      integer :: image(system%meshes), j, n

      image = [(j, j=1, system%meshes)]
      n = size(symmetry%mesh, 2)
      do j = 1, n
         image(symmetry%mesh(:, j)) = symmetry%mesh(:, modulo(j, n) + 1)
      end do
      is_invariant = .false.
      if (symmetry%order > 0) then
         ! Harmonics of the order have the phase of the set, and no others.
         do j = 1, system%meshes
            if (any(symmetry%mesh == j)) then
               if (.not. all(mod([system%law(j)%harmonic, system%transmission_error(j)%harmonic], symmetry%order) == 0)) return
               if (.not. same_law(system%law(j), system%law(image(j)), symmetry%shift)) return
               if (.not. same_series(system%transmission_error(j), system%transmission_error(image(j)), symmetry%shift)) return
            else
               if (any(mod([system%law(j)%harmonic, system%transmission_error(j)%harmonic], symmetry%order) == 0)) return
            end if
         end do
         is_invariant = all([(all(mod(system%torque(j)%harmonic, symmetry%order) > 0), j=1, size(system%torque))])
         return
      end if
      do j = 1, system%meshes
         if (.not. same_law(system%law(j), system%law(image(j)), symmetry%shift)) return
         if (.not. same_series(system%transmission_error(j), system%transmission_error(image(j)), symmetry%shift)) return
      end do
      is_invariant = all([(same_series(system%torque(j), system%torque(j), symmetry%shift), j=1, size(system%torque))])
   end function is_invariant

   pure logical function same_law(one, other, shift)
      type(law_type), intent(in) :: one, other
      real(dp), intent(in) :: shift
      integer :: s

      same_law = one%lowest == other%lowest .and. one%highest == other%highest .and. size(one%harmonic) == size(other%harmonic)
      if (.not. same_law) return
      same_law = all(near(one%wall, other%wall)) .and. all(near(one%stiffness, other%stiffness)) .and. &
                 all(near(one%origin, other%origin)) .and. all(near(one%damping, other%damping))
      do s = one%lowest, one%highest
         same_law = same_law .and. same_series(series_type(one%harmonic, one%amplitude(:, s)), &
                                               series_type(other%harmonic, other%amplitude(:, s)), shift)
      end do
   end function same_law

   !> Whether a series is another one delayed by a shift [rad of Lambda].
   pure logical function same_series(one, other, shift)
      type(series_type), intent(in) :: one, other
      real(dp), intent(in) :: shift
      complex(dp) :: delayed(size(one%harmonic))
      integer :: h

      same_series = size(one%harmonic) == size(other%harmonic)
      if (.not. same_series) return
      delayed = [(one%amplitude(h)*exp(cmplx(0, -one%harmonic(h)*shift, dp)), h=1, size(delayed))]
      same_series = all(one%harmonic == other%harmonic) .and. &
                    all(abs(delayed - other%amplitude) <= rounding*maxval([0.0_dp, abs(delayed)]))
   end function same_series

   elemental logical function near(a, b)
      real(dp), intent(in) :: a, b

      near = abs(a - b) <= rounding*max(abs(a), abs(b))
   end function near

end module geartrain_network_planet_symmetry
