!> Motions in which some of the equal branches move half a period later as others do, and the rest of the train has half the period.
!> Planets that double against one another move so. A shift by half the period leaves the train as it is where the period is even in
!> periods of the excitation.
module geartrain_balance_half_period
   use geartrain_base_kinds, only: dp
   use geartrain_network_equal_branches, only: equal_branches_type
   implicit none (type, external)
   private
   public :: half_period_type

   type :: half_period_type
      !> Unknown that moves half a period later as unknown i does, (unknown); not allocated: the motions have no such symmetry.
      integer, allocatable :: later(:)
      !> Sign that each coefficient takes half a period later, (block); not allocated: the train is then another.
      integer, allocatable :: sign(:)
   contains
      procedure :: take_harmonics
      procedure :: find
      procedure :: keep
   end type half_period_type

contains

   !> Takes the harmonics of the coefficients; to be called whenever they change.
   subroutine take_harmonics(self, harmonic, waves)
      class(half_period_type), intent(inout) :: self
      !> Harmonics as multiples of the lowest frequency that the motions may have, ascending.
      integer, intent(in) :: harmonic(:)
      !> Period of the motions in periods of the excitation.
      integer, intent(in) :: waves
      integer :: k

      if (allocated(self%sign)) deallocate (self%sign)
      if (mod(waves, 2) == 0) self%sign = [1, (merge([1, 1], [-1, -1], mod(harmonic(k), 2) == 0), k=1, size(harmonic))]
   end subroutine take_harmonics

   !> Finds the branches that move half a period later as others do.
   subroutine find(self, sets, u, tangent, same)
      class(half_period_type), intent(inout) :: self
      !> Equal branches of the train.
      type(equal_branches_type), intent(in) :: sets(:)
      !> A motion, and a direction in which it is to be followed: coefficients of the unknown meshes [1], (block, unknown).
      real(dp), intent(in) :: u(:, :), tangent(:, :)
      !> Largest difference of two branches that move equally, over the largest coefficient.
      real(dp), intent(in) :: same
      integer :: later(size(u, 2)), i, j, k
      logical :: known

      if (allocated(self%later)) deallocate (self%later)
      if (.not. allocated(self%sign)) return
      later = [(i, i=1, size(later))]
      do i = 1, size(sets)
         associate (unknown => sets(i)%unknown)
            do j = 1, size(unknown, 2)
               ! This branch may be a part of branches that have changed places already.
               if (any(later(unknown(:, j)) /= unknown(:, j)) .or. follows(unknown(:, j), unknown(:, j))) cycle
               do k = j + 1, size(unknown, 2)
                  if (any(later(unknown(:, k)) /= unknown(:, k)) .or. .not. follows(unknown(:, j), unknown(:, k))) cycle
                  later(unknown(:, j)) = unknown(:, k)
                  later(unknown(:, k)) = unknown(:, j)
                  exit
               end do
            end do
         end associate
      end do
      known = any(later /= [(i, i=1, size(later))])
      if (known) known = follows([(i, i=1, size(later))], later)
      if (known) self%later = later

   contains

      !> Whether unknowns b move half a period later as unknowns a do, and their parts of the direction likewise.
      logical function follows(a, b)
         integer, intent(in) :: a(:), b(:)
         integer :: n

         follows = .true.
         do n = 1, size(a)
            if (.not. follows) return
            follows = maxval(abs(u(:, b(n)) - self%sign*u(:, a(n)))) <= same*maxval(abs(u)) .and. &
                      maxval(abs(tangent(:, b(n)) - self%sign*tangent(:, a(n)))) <= same*maxval(abs(tangent))
         end do
      end function follows

   end subroutine find

   !> Takes the part of coefficients that has the symmetry, or the part that changes its sign.
   pure subroutine keep(self, sense, x)
      class(half_period_type), intent(in) :: self
      !> 1: the part that has the symmetry; -1: the part that changes its sign.
      integer, intent(in) :: sense
      !> Coefficients [1], (block, unknown).
      real(dp), intent(inout) :: x(:, :)
      real(dp), allocatable :: shifted(:, :)
      integer :: i

      if (.not. allocated(self%later)) return
      allocate (shifted, mold=x)
      do i = 1, size(x, 2)
         shifted(:, self%later(i)) = self%sign*x(:, i)
      end do
      x = (x + sense*shifted)/2
   end subroutine keep

end module geartrain_balance_half_period
