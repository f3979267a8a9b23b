!> How the planets of a planetary set share its load: the force of the mesh of each planet with the sun, or with the ring where the
!> set has no sun, over the sum of the mean forces of all its planets.
module geartrain_network_load_sharing
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use geartrain_base_kinds, only: dp
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_train_labels, only: label_length
   use geartrain_train_planetary_sets, only: find_sets, planetary_set_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: find_sharing, mesh_load_factor, planet_labels, sharing_type

   !> Sum of the mean forces of a set that counts as rounding, over the sum of their magnitudes [1].
   real(dp), parameter :: rounding = 1e-9_dp
   !> This sum of a set that rattles without load, over the sum of its largest forces [1]: what a finite time leaves of 0.
   real(dp), parameter :: idle = 1e-5_dp

   type :: sharing_type
      !> Mesh whose force is the load of each planet, number of its set, and body that is the planet, (planet): all planets of the
      !> first set, then those of the second, ...
      integer, allocatable :: mesh(:), set(:), body(:)
   contains
      procedure :: find_shares
   end type sharing_type

contains

   !> Names of the planets of all planetary sets, (planet).
   pure function planet_labels(train) result(labels)
      !> A train that is in order.
      type(train_type), intent(in) :: train
      character(label_length), allocatable :: labels(:)
      type(train_type) :: plain
      type(sharing_type) :: sharing
      integer :: i

      allocate (labels(0))
      if (.not. allocated(train%bodies)) return
      call plain_train(train, plain)
      call find_sharing(plain, sharing)
      deallocate (labels)
      allocate (labels(size(sharing%body)))
      do i = 1, size(labels)
         labels(i) = train%bodies(sharing%body(i))%name
      end do
   end function planet_labels

   !> Finds the planets of a train; none where it has no planetary set.
   pure subroutine find_sharing(train, sharing)
      !> A plain train that has passed `check_train`.
      type(train_type), intent(in) :: train
      !> Its planets.
      type(sharing_type), intent(out) :: sharing
      type(planetary_set_type), allocatable :: sets(:)
      integer :: i, n

      allocate (sharing%mesh(0), sharing%set(0), sharing%body(0))
      if (.not. allocated(train%bodies)) return
      call find_sets(train, sets)
      do i = 1, size(sets)
         sharing%mesh = [sharing%mesh, sets(i)%meshes(1, :)]
         sharing%set = [sharing%set, [(i, n=1, size(sets(i)%planets))]]
         sharing%body = [sharing%body, sets(i)%planets]
      end do
   end subroutine find_sharing

   !> Sets the shares of the planets of all sets; NaN of a set without load.
   pure subroutine find_shares(self, mean, largest, share, share_maximum)
      class(sharing_type), intent(in) :: self
      !> Mean and largest force of the mesh of each planet [N], (planet): the largest as a magnitude, in the direction of the load.
      real(dp), intent(in) :: mean(:), largest(:)
      !> Mean and largest force over the sum of the mean forces of the set [1], (planet).
      real(dp), intent(out) :: share(:), share_maximum(:)
      real(dp) :: total(size(mean))
      integer :: n

      total = [(sum(mean, self%set == self%set(n)), n=1, size(mean))]
      where (abs(total) <= rounding*[(sum(abs(mean), self%set == self%set(n)), n=1, size(mean))] .or. &
             abs(total) <= idle*[(sum(largest, self%set == self%set(n)), n=1, size(mean))]) &
         total = ieee_value(1.0_dp, ieee_quiet_nan)
      share = mean/total
      share_maximum = largest/abs(total)
   end subroutine find_shares

   !> Mesh load factor K_gamma of a set [1]: the largest share over the share of a planet of a set that shares evenly.
   pure real(dp) function mesh_load_factor(share)
      !> Shares of the planets of the set [1], (planet).
      real(dp), intent(in) :: share(:)

      mesh_load_factor = size(share)*maxval(share)
   end function mesh_load_factor

end module geartrain_network_load_sharing
