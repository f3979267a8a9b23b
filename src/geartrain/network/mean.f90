!> The equations of the mean: in a tree the mean force of each mesh is its load. An unknown mesh that closes a loop takes its force
!> from the other elements of the loop, and its mean displacement agrees with theirs.
!>
!> With loop matrix C (geartrain_network_network) and means:
!>    F_n + sum over c of C_cn (F_c - load_c) = load_n          an unknown mesh n of the tree
!>    p_c - sum over unknown n of C_cn p_n = sum over linear n of C_cn p_n + misfit_c    an unknown mesh c that closes a loop
module geartrain_network_mean
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
   use geartrain_network_cut, only: cut_type
   use geartrain_network_network, only: network_type
   implicit none (type, external)
   private
   public :: mean_type, mean_rows

   !> The equations sum over j of (force_ij phi_j + displacement_ij p_j) = static_force_i, i and j unknowns.
   type :: mean_type
      !> Coefficients of phi and p [1], (entry of the graph of the cut); right sides [1], (unknown).
      real(dp), allocatable :: force(:), displacement(:), static_force(:)
      !> Unknowns that close loops, (loop).
      integer, allocatable :: closing(:)
      !> Mean displacement of each linear element per phi of each closing unknown beyond its load [1], (element, loop).
      real(dp), allocatable :: follow(:, :)
   contains
      procedure :: linear_displacement
   end type mean_type

contains

   !> Makes the mean equations of a network.
   pure subroutine mean_rows(network, cut, load, misfit, mean)
      !> Network of the train.
      type(network_type), intent(in) :: network
      !> The network cut at its unknown meshes.
      type(cut_type), intent(in) :: cut
      !> Force of each element at rest over k b_c [1], (element); misfit of each loop by constant errors over b_c [1], (loop).
      real(dp), intent(in) :: load(:), misfit(:)
      !> The equations.
      type(mean_type), intent(out) :: mean
      integer :: c, i, j, n

      allocate (mean%force(cut%graph%entries), mean%displacement(cut%graph%entries), source=0.0_dp)
      mean%force(:cut%unknowns) = 1
      mean%static_force = load(cut%element)
      mean%closing = pack([(i, i=1, cut%unknowns)], cut%element > network%coordinates)
      allocate (mean%follow(size(load), size(mean%closing)))
      if (size(mean%closing) == 0) return
      call find_following(network, cut, mean)
      do i = 1, size(mean%closing)
         associate (unknown => mean%closing(i))
            c = cut%element(unknown)
            mean%force(unknown) = 0
            mean%displacement(unknown) = 1
            mean%static_force(unknown) = misfit(c - network%coordinates)
            do j = 1, cut%unknowns
               n = cut%element(j)
               if (n > network%coordinates) cycle
               associate (ratio => network%loop(c - network%coordinates, n))
                  if (.not. abs(ratio) > 0) cycle
                  mean%displacement(cut%graph%entry_of(unknown, j)) = -ratio
                  associate (entry => cut%graph%entry_of(j, unknown))
                     mean%force(entry) = ratio*network%elements(c)%stiffness/network%elements(n)%stiffness
                     mean%static_force(j) = mean%static_force(j) + mean%force(entry)*load(c)
                  end associate
               end associate
            end do
            ! Linear elements of the loop deflect by their loads and by the change of the closing forces.
            do n = 1, network%coordinates
               if (network%elements(n)%unknown) cycle
               associate (ratio => network%loop(c - network%coordinates, n))
                  mean%static_force(unknown) = mean%static_force(unknown) + ratio*load(n)
                  do j = 1, size(mean%closing)
                     associate (entry => cut%graph%entry_of(unknown, mean%closing(j)), twist => ratio*mean%follow(n, j))
                        mean%force(entry) = mean%force(entry) - twist
                        mean%static_force(unknown) = mean%static_force(unknown) - twist*load(cut%element(mean%closing(j)))
                     end associate
                  end do
               end associate
            end do
         end associate
      end do
   end subroutine mean_rows

   !> Sets `follow`: how linear elements, in the tree or closing loops of linear elements, deflect under the closing forces.
   pure subroutine find_following(network, cut, mean)
      type(network_type), intent(in) :: network
      type(cut_type), intent(in) :: cut
      type(mean_type), intent(inout) :: mean
      integer, allocatable :: linear(:)
      real(dp), allocatable :: flexibility(:, :), taken(:, :)
      integer, allocatable :: pivot(:)
      real(dp) :: taken_from
      integer :: i, info, l, n

      associate (tree => network%coordinates, elements => network%elements)
         linear = pack([(n, n=1, size(elements))], .not. elements%unknown .and. elements%elastic)
         linear = pack(linear, linear > tree)
         allocate (flexibility(size(linear), size(linear)), taken(size(linear), size(mean%closing)), source=0.0_dp)
         allocate (pivot(size(linear)))
         ! Forces of the linear closing elements per force of the unknown closing elements.
         do n = 1, tree
            if (elements(n)%unknown) cycle
            do i = 1, size(linear)
               associate (ratio => network%loop(linear(i) - tree, n)/elements(n)%stiffness)
                  flexibility(i, :) = flexibility(i, :) + ratio*network%loop(linear - tree, n)
                  taken(i, :) = taken(i, :) - ratio*network%loop(cut%element(mean%closing) - tree, n)
               end associate
            end do
         end do
         do i = 1, size(linear)
            flexibility(i, i) = flexibility(i, i) + 1/elements(linear(i))%stiffness
         end do
         if (size(linear) > 0) then
            call factor_matrix(size(linear), flexibility, pivot, info)
            call solve_factored(size(linear), size(mean%closing), flexibility, pivot, taken)
         end if
         mean%follow = 0
         do i = 1, size(mean%closing)
            associate (c => cut%element(mean%closing(i)))
               do n = 1, tree
                  if (elements(n)%unknown) cycle
                  taken_from = network%loop(c - tree, n)
                  do l = 1, size(linear)
                     taken_from = taken_from + network%loop(linear(l) - tree, n)*taken(l, i)
                  end do
                  mean%follow(n, i) = -taken_from*elements(c)%stiffness/elements(n)%stiffness
               end do
               mean%follow(linear, i) = taken(:, i)*elements(c)%stiffness/elements(linear)%stiffness
            end associate
         end do
      end associate
   end subroutine find_following

   !> Mean displacement over b_c [1] of a linear element due to the closing forces, without the deflection under its load at rest.
   pure real(dp) function linear_displacement(self, cut, element, force, load)
      class(mean_type), intent(in) :: self
      !> The network cut at its unknown meshes.
      type(cut_type), intent(in) :: cut
      !> Number of the linear element.
      integer, intent(in) :: element
      !> Mean phi of the unknown meshes [1], (unknown); force of each element at rest over k b_c [1], (element).
      real(dp), intent(in) :: force(:), load(:)
      integer :: i

      linear_displacement = 0
      do i = 1, size(self%closing)
         linear_displacement = linear_displacement &
                               + self%follow(element, i)*(force(self%closing(i)) - load(cut%element(self%closing(i))))
      end do
   end function linear_displacement

end module geartrain_network_mean
