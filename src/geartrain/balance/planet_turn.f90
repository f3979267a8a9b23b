!> Motions of a planetary set in which each planet moves as the one before it, a share of the mesh cycle later: a turn of the
!> planets by one place, with a shift in time, leaves them as they are. The Jacobian of the balance leaves these motions to
!> themselves, and one planet stands for all.
!>
!> The other motions come in pairs, whose parts of the Jacobian are conjugate and have a positive determinant; but with an even
!> number of planets the motions in which each planet moves with the other sign than the one before are a part by themselves.
module geartrain_balance_planet_turn
   use geartrain_balance_fixed_space, only: average_equal, mean_equations
   use geartrain_base_kinds, only: dp
   use geartrain_network_planet_symmetry, only: symmetry_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: planet_turn_type

   !> Largest difference of two planets that move alike, over the largest coefficient.
   real(dp), parameter :: same = 1e-7_dp

   type :: planet_turn_type
      !> Unknown that stands for each, (unknown); not allocated: the motions have no such symmetry.
      integer, allocatable :: orbit(:)
      !> Equations of the mean where every mesh has its mean stiffness, (equation, unknown), and their inverse.
      real(dp), allocatable :: mean(:, :), inverse(:, :)
      !> Cosine and sine of the angle by which each harmonic of an unknown is behind that of the one that stands for it,
      !> (harmonic, unknown).
      real(dp), allocatable :: cosine(:, :), sine(:, :)
      !> Shift of each unknown [rad of Lambda], (unknown).
      real(dp), allocatable, private :: shift(:)
      !> Unknowns of every other planet; allocated for an even number of planets, (unknown).
      logical, allocatable :: other(:)
   contains
      procedure :: find
      procedure :: take_harmonics
      procedure :: project
      procedure :: turn
      procedure :: turn_columns
   end type planet_turn_type

contains

   !> Finds whether the planets of a set move so.
   subroutine find(self, system, symmetries, mesh, harmonic, u, tangent)
      class(planet_turn_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Symmetric sets of the train.
      type(symmetry_type), intent(in) :: symmetries(:)
      !> Mesh of each unknown, (unknown).
      integer, intent(in) :: mesh(:)
      !> Harmonics of the coefficients in multiples of Lambda.
      integer, intent(in) :: harmonic(:)
      !> A motion, and a direction in which it is to be followed: coefficients of the unknown meshes [1], (block, unknown).
      real(dp), intent(in) :: u(:, :), tangent(:, :)
      type(planet_turn_type) :: next
      integer :: at(2), i, k, n

      if (allocated(self%orbit)) deallocate (self%orbit)
      if (allocated(self%other)) deallocate (self%other)
      do i = 1, size(symmetries)
         associate (places => symmetries(i)%mesh, shift => symmetries(i)%shift)
            n = size(places, 2)
            if (size(places) /= size(mesh) .or. .not. abs(shift) > 0) cycle
            if (.not. all([(any(places == mesh(k)), k=1, size(mesh))])) cycle
            next%orbit = mesh
            next%shift = [(0.0_dp, k=1, size(mesh))]
            next%other = [(.false., k=1, size(mesh))]
            do k = 1, size(mesh)
               ! The mesh among those of its planet, and the planet.
               at = findloc(places, mesh(k))
               next%orbit(k) = findloc(mesh, places(at(1), 1), 1)
               next%shift(k) = (at(2) - 1)*shift
               next%other(k) = mod(at(2), 2) == 0
            end do
            call next%take_harmonics(harmonic)
            if (.not. (moves_so(u) .and. moves_so(tangent))) cycle
            call mean_equations(system, next%mean, next%inverse)
            if (.not. allocated(next%inverse)) cycle
            self%orbit = next%orbit
            self%shift = next%shift
            if (mod(n, 2) == 0) self%other = next%other
            self%mean = next%mean
            self%inverse = next%inverse
            self%cosine = next%cosine
            self%sine = next%sine
            return
         end associate
      end do

   contains

      !> Whether all planets move as the first one does, each by its own shift later.
      logical function moves_so(x)
         real(dp), intent(in) :: x(:, :)
         real(dp) :: turned(size(x, 1), size(x, 2))

         turned = x(:, next%orbit)
         call next%turn(1, turned)
         moves_so = maxval(abs(turned - x)) <= same*maxval(abs(x))
      end function moves_so

   end subroutine find

   !> Takes the harmonics of the coefficients; to be called whenever they change.
   pure subroutine take_harmonics(self, harmonic)
      class(planet_turn_type), intent(inout) :: self
      !> Multiples of Lambda.
      integer, intent(in) :: harmonic(:)
      integer :: j, k

      if (.not. allocated(self%orbit)) return
      self%cosine = reshape([((cos(harmonic(k)*self%shift(j)), k=1, size(harmonic)), j=1, size(self%shift))], &
                            [size(harmonic), size(self%shift)])
      self%sine = reshape([((sin(harmonic(k)*self%shift(j)), k=1, size(harmonic)), j=1, size(self%shift))], &
                          [size(harmonic), size(self%shift)])
   end subroutine take_harmonics

   !> Takes the part of coefficients that has the symmetry.
   pure subroutine project(self, x)
      class(planet_turn_type), intent(in) :: self
      !> Coefficients [1], (block, unknown).
      real(dp), intent(inout) :: x(:, :)

      if (.not. allocated(self%orbit)) return
      call self%turn(-1, x)
      call average_equal(self%orbit, x)
      call self%turn(1, x)
   end subroutine project

   !> Delays each unknown by its shift, or takes the delay back.
   pure subroutine turn(self, sense, x)
      class(planet_turn_type), intent(in) :: self
      !> 1: delays; -1: takes the delay back.
      integer, intent(in) :: sense
      !> Coefficients of the lowest harmonics [1], (block, unknown).
      real(dp), intent(inout) :: x(:, :)
      real(dp) :: even
      integer :: j, k

      do j = 1, size(x, 2)
         do k = 1, size(x, 1)/2
            even = x(2*k, j)
            x(2*k, j) = self%cosine(k, j)*even - sense*self%sine(k, j)*x(2*k + 1, j)
            x(2*k + 1, j) = sense*self%sine(k, j)*even + self%cosine(k, j)*x(2*k + 1, j)
         end do
      end do
   end subroutine turn

   !> Columns of an unknown, of a matrix that acts on the coefficients, for those of the unknown that stands for it.
   pure subroutine turn_columns(self, unknown, columns)
      class(planet_turn_type), intent(in) :: self
      !> Number of the unknown.
      integer, intent(in) :: unknown
      !> (row, block).
      real(dp), intent(inout) :: columns(:, :)
      real(dp) :: even(size(columns, 1))
      integer :: k

      do k = 1, size(columns, 2)/2
         even = columns(:, 2*k)
         columns(:, 2*k) = self%cosine(k, unknown)*even + self%sine(k, unknown)*columns(:, 2*k + 1)
         columns(:, 2*k + 1) = self%cosine(k, unknown)*columns(:, 2*k + 1) - self%sine(k, unknown)*even
      end do
   end subroutine turn_columns

end module geartrain_balance_planet_turn
