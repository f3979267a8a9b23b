!> Motions of a planetary set in which each planet moves as the one before it, a share of the mesh cycle later: a turn of the
!> planets by one place, with a shift in time, leaves them as they are. The Jacobian of the balance leaves these motions to
!> themselves, and one planet stands for all.
!>
!> The other motions come in pairs, whose parts of the Jacobian are conjugate and have a positive determinant; but with an even
!> number of planets the motions in which each planet moves with the other sign than the one before are a part by themselves.
!>
!> A motion on the torus of the phases of several sources of excitation may have this symmetry for each of several sets, each with
!> a shift of the phase of its own meshes alone. The shift turns a harmonic by the number of this source in it. A mesh outside the
!> set has no amplitude at harmonics that the shift would change.
module geartrain_balance_planet_turn
   use geartrain_balance_fixed_space, only: average_equal, mean_equations
   use geartrain_balance_winding, only: winding_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_network_planet_symmetry, only: symmetry_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: planet_turn_type

   !> Largest difference of two planets that move alike, over the largest coefficient; the same of a motion and of a direction on a
   !> winding, whose coefficients have errors where teeth part.
   real(dp), parameter :: same = 1e-7_dp, same_on_torus(2) = [1e-5_dp, 1e-2_dp]
   !> Rounding of a whole number of turns.
   real(dp), parameter :: rounding = 1e-6_dp

   !> A set whose planets move so.
   type :: set_type
      !> Number of the planet of each unknown, from 0; -1: the unknown is not in the set, (unknown).
      integer, allocatable :: place(:)
      !> Shift from planet to planet [rad of Lambda], and order of the source whose phase alone it is; 0: a shift in time.
      real(dp) :: shift = 0
      integer :: order = 0
   end type set_type

   type :: planet_turn_type
      !> Unknown that stands for each, (unknown); not allocated: the motions have no such symmetry.
      integer, allocatable :: orbit(:)
      !> Equations of the mean where every mesh has its mean stiffness, (equation, unknown), and their inverse.
      real(dp), allocatable :: mean(:, :), inverse(:, :)
      !> Cosine and sine of the angle by which each harmonic of an unknown is behind that of the one that stands for it,
      !> (harmonic, unknown).
      real(dp), allocatable :: cosine(:, :), sine(:, :)
      !> Harmonics that have no amplitude, (harmonic, unknown).
      logical, allocatable :: still(:, :)
      !> Unknowns of every other planet; allocated for an even number of planets of a set alone, (unknown).
      logical, allocatable :: other(:)
      !> The sets; the motions are on the torus of a winding.
      type(set_type), allocatable, private :: set(:)
      logical, private :: on_torus = .false.
   contains
      procedure :: find
      procedure :: take_harmonics
      procedure :: project
      procedure :: turn
      procedure :: turn_columns
      procedure, private :: make
   end type planet_turn_type

contains

   !> Finds whether the planets of a set that is the whole train move so or, on the torus of a winding, of all sets.
   subroutine find(self, system, symmetries, winding, mesh, harmonic, u, tangent)
      class(planet_turn_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Symmetric sets of the train.
      type(symmetry_type), intent(in) :: symmetries(:)
      !> Winding of the balance; without cycles: none.
      type(winding_type), intent(in) :: winding
      !> Mesh of each unknown, (unknown).
      integer, intent(in) :: mesh(:)
      !> Harmonics of the coefficients in multiples of Lambda.
      integer, intent(in) :: harmonic(:)
      !> A motion, and a direction in which it is to be followed: coefficients of the unknown meshes [1], (block, unknown).
      real(dp), intent(in) :: u(:, :), tangent(:, :)
      type(planet_turn_type) :: next
      logical :: suits(size(symmetries))
      real(dp) :: allowed(2)
      integer :: i, k

      if (allocated(self%orbit)) deallocate (self%orbit)
      if (allocated(self%other)) deallocate (self%other)
      do i = 1, size(symmetries)
         associate (places => symmetries(i)%mesh, shift => symmetries(i)%shift, order => symmetries(i)%order)
            if (winding%cycles > 0) then
               suits(i) = winding%source_of(order) > 0 .or. .not. abs(shift) > 0
            else
               suits(i) = order == 0 .and. abs(shift) > 0 .and. size(places) == size(mesh) .and. &
                          all([(any(places == mesh(k)), k=1, size(mesh))])
            end if
         end associate
      end do
      i = findloc(suits, .true., 1)
      if (i == 0) return
      if (winding%cycles == 0) suits(i + 1:) = .false.
      call next%make(symmetries, suits, winding, mesh)
      call next%take_harmonics(harmonic, winding)
      allowed = same
      if (next%on_torus) allowed = same_on_torus
      if (.not. (moves_so(u, allowed(1)) .and. moves_so(tangent, allowed(2)))) return
      call mean_equations(system, next%mean, next%inverse)
      if (.not. allocated(next%inverse)) return
      select type (self)
      type is (planet_turn_type)
         self = next
      end select

   contains

      !> Whether all planets move as the first one does, each by its own shift later.
      logical function moves_so(x, allowed)
         real(dp), intent(in) :: x(:, :), allowed
         real(dp) :: turned(size(x, 1), size(x, 2))

         turned = x(:, next%orbit)
         call next%turn(1, turned)
         moves_so = maxval(abs(turned - x)) <= allowed*maxval(abs(x))
      end function moves_so

   end subroutine find

   !> Takes the sets that suit.
   subroutine make(self, symmetries, suits, winding, mesh)
      class(planet_turn_type), intent(inout) :: self
      type(symmetry_type), intent(in) :: symmetries(:)
      logical, intent(in) :: suits(:)
      type(winding_type), intent(in) :: winding
      integer, intent(in) :: mesh(:)
      integer :: at(2), i, k, n

      self%on_torus = winding%cycles > 0
      self%orbit = [(k, k=1, size(mesh))]
      allocate (self%set(count(suits)))
      n = 0
      do i = 1, size(symmetries)
         if (.not. suits(i)) cycle
         n = n + 1
         associate (places => symmetries(i)%mesh, set => self%set(n))
            set%shift = symmetries(i)%shift
            set%order = symmetries(i)%order
            allocate (set%place(size(mesh)), source=-1)
            do k = 1, size(mesh)
               ! The mesh among those of its planet, and the planet.
               at = findloc(places, mesh(k))
               if (at(2) == 0) cycle
               set%place(k) = at(2) - 1
               self%orbit(k) = findloc(mesh, places(at(1), 1), 1)
            end do
            if (.not. self%on_torus .and. mod(size(places, 2), 2) == 0) self%other = mod(set%place, 2) == 1
         end associate
      end do
   end subroutine make

   !> Takes the harmonics of the coefficients; to be called whenever they change. Without a winding the symmetry on the torus of one
   !> is given up.
   pure subroutine take_harmonics(self, harmonic, winding)
      class(planet_turn_type), intent(inout) :: self
      !> Multiples of Lambda.
      integer, intent(in) :: harmonic(:)
      !> Winding of the balance; without cycles: none.
      type(winding_type), intent(in) :: winding
      real(dp) :: angle(size(harmonic)), shift(size(harmonic))
      integer :: j, s

      if (.not. allocated(self%orbit)) return
      if (self%on_torus .and. winding%cycles == 0) then
         deallocate (self%orbit)
         return
      end if
      if (allocated(self%cosine)) deallocate (self%cosine, self%sine, self%still)
      allocate (self%cosine(size(harmonic), size(self%orbit)), self%sine(size(harmonic), size(self%orbit)), &
                self%still(size(harmonic), size(self%orbit)))
      do j = 1, size(self%orbit)
         angle = 0
         self%still(:, j) = .false.
         do s = 1, size(self%set)
            shift = shift_of(self%set(s))
            associate (place => self%set(s)%place(j))
               if (place >= 0) then
                  angle = angle + place*shift
               else
                  self%still(:, j) = self%still(:, j) .or. abs(shift/(2*pi) - anint(shift/(2*pi))) > rounding
               end if
            end associate
         end do
         self%cosine(:, j) = merge(0.0_dp, cos(angle), self%still(:, j))
         self%sine(:, j) = merge(0.0_dp, sin(angle), self%still(:, j))
      end do

   contains

      !> Angles by which the harmonics are shifted from planet to planet [rad].
      pure function shift_of(set) result(shift)
         type(set_type), intent(in) :: set
         real(dp) :: shift(size(harmonic))
         integer :: numbers(winding%sources()), k

         shift = harmonic*set%shift
         if (set%order == 0) return
         do k = 1, size(harmonic)
            numbers = winding%numbers_of(harmonic(k))
            shift(k) = numbers(winding%source_of(set%order))*set%order*set%shift
         end do
      end function shift_of

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
