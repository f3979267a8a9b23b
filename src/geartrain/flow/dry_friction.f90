!> Dry friction of couplings along the flow: each coupling with friction slips one way or the other, or sticks.
!>
!> A slipping coupling has the constant force of its limit against its velocity. A sticking coupling has the force that keeps its
!> velocity 0; where this force comes to the limit, it slips. The friction forces F act as -W F on the accelerations (see
!> geartrain_network_system), like all other forces of elements.
module geartrain_flow_dry_friction
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
   use geartrain_linalg_first_root, only: first_root, polynomial
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: friction_type, sticks, undecided

   !> Mode of a coupling that sticks; of one whose mode is about to be found, without friction until then. Slipping forwards and
   !> backwards are the modes 1 and -1.
   integer, parameter :: sticks = 0, undecided = 2
   !> Velocity that counts as none at the beginning of a flight, over the largest velocity of the state.
   real(dp), parameter :: standstill = 1e-12_dp
   !> Relative error of the series of a sticking force over a step.
   real(dp), parameter :: tolerance = 1e-13_dp

   type :: friction_type
      !> Number of couplings with friction, which all lists are over.
      integer :: count = 0
      !> Mesh and element of each coupling; largest friction force over k b_c [1].
      integer, allocatable :: mesh(:), element(:)
      real(dp), allocatable :: limit(:)
      !> Mode of each coupling.
      integer, allocatable :: mode(:)
      !> Friction forces over the latest step, Taylor coefficients, (0:order, coupling).
      real(dp), allocatable :: force(:, :)
      !> W of a coordinate and of a coupling with a coupling [1], (coordinate, coupling) and (coupling, coupling).
      real(dp), allocatable :: column(:, :), gain(:, :)
      !> Order of the zero that the velocity of a coupling that slips has at the beginning of the step, as far as an event
      !> before it made it 0; couplings that stick; factors of their part of `gain`.
      integer, allocatable, private :: zeros(:), held(:), pivot(:)
      real(dp), allocatable, private :: factors(:, :)
   contains
      procedure :: setup
      procedure :: begin
      procedure :: prepare
      procedure :: begin_series
      procedure :: act
      procedure :: rates
      procedure :: hold
      procedure :: stop
      procedure :: limit_step
      procedure :: first_event
      procedure :: forces_at
      procedure :: accelerations_at
      procedure :: choose
      procedure :: pass
      procedure :: release
   end type friction_type

contains

   !> Finds the couplings with friction.
   pure subroutine setup(self, system, order)
      class(friction_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Order of the Taylor series.
      integer, intent(in) :: order
      integer :: i, j, k, m

      if (allocated(self%mesh)) deallocate (self%mesh, self%element, self%limit, self%mode, self%force, self%column, self%gain, &
                                            self%zeros, self%held)
      self%mesh = pack([(j, j=1, system%meshes)], system%friction > 0)
      self%count = size(self%mesh)
      self%element = system%mesh_element(self%mesh)
      self%limit = system%friction(self%mesh)
      associate (n => self%count)
         allocate (self%mode(n), source=sticks)
         allocate (self%zeros(n), source=0)
         allocate (self%held(0))
         allocate (self%force(0:order, n), self%column(system%coordinates, n), self%gain(n, n), source=0.0_dp)
         do i = 1, n
            associate (e => self%element(i))
               if (e <= system%coordinates) self%column(e, i) = system%own(e)
               self%gain(i, i) = system%own(e)
               ! W is looked up by rows.
               do m = 1, system%elements
                  do k = system%first(m), system%first(m + 1) - 1
                     if (system%neighbour(k) /= e) cycle
                     if (m <= system%coordinates) self%column(m, i) = system%coupling(k)
                     j = findloc(self%element, m, 1)
                     if (j > 0) self%gain(j, i) = system%coupling(k)
                  end do
               end do
            end associate
         end do
      end associate
   end subroutine setup

   !> Finds the modes at the beginning of a flight: what has a velocity slips, all others are undecided.
   pure subroutine begin(self, velocity, largest)
      class(friction_type), intent(inout) :: self
      !> Velocities [1], (coupling); largest velocity of the state [1].
      real(dp), intent(in) :: velocity(:), largest

      self%zeros = 0
      self%mode = merge(merge(1, -1, velocity > 0), undecided, abs(velocity) > standstill*largest)
   end subroutine begin

   !> Prepares `hold` and `act` for the present modes.
   pure subroutine prepare(self)
      class(friction_type), intent(inout) :: self
      integer :: i, info

      self%held = pack([(i, i=1, self%count)], self%mode == sticks)
      self%factors = self%gain(self%held, self%held)
      if (allocated(self%pivot)) deallocate (self%pivot)
      allocate (self%pivot(size(self%held)))
      call factor_matrix(size(self%held), self%factors, self%pivot, info)
   end subroutine prepare

   !> Begins the series of the forces, those of a step to come, for `act`.
   pure subroutine begin_series(self)
      class(friction_type), intent(inout) :: self

      call self%prepare()
      self%force = 0
      where (abs(self%mode) == 1) self%force(0, :) = self%mode*self%limit
   end subroutine begin_series

   !> Lets friction act on the Taylor coefficients k of all accelerations: subtracts slipping forces, and finds and subtracts the
   !> forces of what sticks, which has no acceleration.
   pure subroutine act(self, system, columns, k, loop, acceleration)
      class(friction_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Number of columns (state and tangents); number of the coefficient.
      integer, intent(in) :: columns, k
      !> Taylor coefficients of the displacements of the elements that close loops where the coordinates are 0 [1].
      real(dp), intent(in) :: loop(0:, :)
      !> The coefficients [1], (column, coordinate).
      real(dp), intent(inout) :: acceleration(columns, system%coordinates)
      real(dp) :: rate(size(self%held), columns)
      integer :: h, i

      if (k == 0) then
         do i = 1, self%count
            if (abs(self%mode(i)) == 1) acceleration(1, :) = acceleration(1, :) - self%column(:, i)*self%force(0, i)
         end do
      end if
      if (size(self%held) == 0) return
      do h = 1, size(self%held)
         associate (e => self%element(self%held(h)), c => system%coordinates)
            if (e <= c) then
               rate(h, :) = acceleration(:, e)
            else
               rate(h, :) = matmul(acceleration, system%network%loop(e - c, :))
               rate(h, 1) = rate(h, 1) + (k + 1)*(k + 2)*loop(k + 2, e - c)
            end if
         end associate
      end do
      call solve_factored(size(self%held), columns, self%factors, self%pivot, rate)
      do h = 1, size(self%held)
         do i = 1, system%coordinates
            if (abs(self%column(i, self%held(h))) > 0) &
               acceleration(:, i) = acceleration(:, i) - self%column(i, self%held(h))*rate(h, :)
         end do
         self%force(k, self%held(h)) = rate(h, 1)
      end do
      do h = 1, size(self%held)
         if (self%element(self%held(h)) <= system%coordinates) acceleration(:, self%element(self%held(h))) = 0
      end do
   end subroutine act

   !> Velocities of a coupling by those of the coordinates [1], (column).
   pure function rates(self, system, i, velocity) result(rate)
      class(friction_type), intent(in) :: self
      type(system_type), intent(in) :: system
      !> Number of the coupling.
      integer, intent(in) :: i
      !> Velocities of tangents [1], (column, coordinate).
      real(dp), intent(in) :: velocity(:, :)
      real(dp) :: rate(size(velocity, 1))

      associate (e => self%element(i), c => system%coordinates)
         if (e <= c) then
            rate = velocity(:, e)
         else
            rate = matmul(velocity, system%network%loop(e - c, :))
         end if
      end associate
   end function rates

   !> Takes from velocities of tangents what a coupling that sticks would not let pass, as an impact would.
   pure subroutine hold(self, system, velocity)
      class(friction_type), intent(in) :: self
      type(system_type), intent(in) :: system
      !> Velocities [1], (column, coordinate).
      real(dp), intent(inout) :: velocity(:, :)
      real(dp) :: rate(size(self%held), size(velocity, 1))
      integer :: h

      if (size(self%held) == 0 .or. size(velocity, 1) == 0) return
      do h = 1, size(self%held)
         rate(h, :) = self%rates(system, self%held(h), velocity)
      end do
      call solve_factored(size(self%held), size(velocity, 1), self%factors, self%pivot, rate)
      velocity = velocity - transpose(matmul(self%column(:, self%held), rate))
      call self%stop(velocity)
   end subroutine hold

   !> Makes velocities of what sticks, which are rounding, exactly 0.
   pure subroutine stop(self, velocity)
      class(friction_type), intent(in) :: self
      !> Velocities [1], (column, coordinate).
      real(dp), intent(inout) :: velocity(:, :)
      integer :: h

      do h = 1, size(self%held)
         if (self%element(self%held(h)) <= size(velocity, 2)) velocity(:, self%element(self%held(h))) = 0
      end do
   end subroutine stop

   !> Shortens a step to where the series of a sticking force is exact.
   pure subroutine limit_step(self, h)
      class(friction_type), intent(in) :: self
      !> Length of the step [1].
      real(dp), intent(inout) :: h
      integer :: i, k

      do i = 1, self%count
         if (self%mode(i) /= sticks) cycle
         ! The last coefficient is not known.
         do k = ubound(self%force, 1) - 2, ubound(self%force, 1) - 1
            if (abs(self%force(k, i)) > 0) h = min(h, (tolerance*self%limit(i)/abs(self%force(k, i)))**(1.0_dp/k))
         end do
      end do
   end subroutine limit_step

   !> Finds the first instant in (0, h] at which a coupling ceases to slip or to stick, and shortens h to this instant.
   pure subroutine first_event(self, velocity, h, found)
      class(friction_type), intent(in) :: self
      !> Taylor coefficients of the velocities of all elements [1], (element, 0:order).
      real(dp), intent(in) :: velocity(:, 0:)
      !> Length of the step [1].
      real(dp), intent(inout) :: h
      !> Number of the coupling; 0: none.
      integer, intent(out) :: found
      real(dp) :: f(0:ubound(velocity, 2)), root
      integer :: i, side
      logical :: hit

      found = 0
      do i = 1, self%count
         if (self%mode(i) == sticks) then
            do side = -1, 1, 2
               f = side*self%force(:, i)
               f(0) = self%limit(i) + f(0)
               call first_root(f, h, root, hit)
               if (.not. hit) cycle
               h = root
               found = i
            end do
         else
            f = eoshift(self%mode(i)*velocity(self%element(i), :), self%zeros(i))
            call first_root(f, h, root, hit)
            if (.not. hit) cycle
            h = root
            found = i
         end if
      end do
   end subroutine first_event

   !> Friction forces within the latest step [1], (coupling).
   pure function forces_at(self, tau) result(force)
      class(friction_type), intent(in) :: self
      !> Time since the beginning of the step [1].
      real(dp), intent(in) :: tau
      real(dp) :: force(self%count), slope
      integer :: i

      do i = 1, self%count
         call polynomial(self%force(:, i), tau, force(i), slope)
      end do
   end function forces_at

   !> Accelerations of the couplings at the end of a step, as they were before it [1], (coupling).
   pure function accelerations_at(self, velocity, tau) result(acceleration)
      class(friction_type), intent(in) :: self
      !> Taylor coefficients of the velocities of all elements [1], (element, 0:order); length of the step [1].
      real(dp), intent(in) :: velocity(:, 0:), tau
      real(dp) :: acceleration(self%count), now
      integer :: i

      do i = 1, self%count
         call polynomial(velocity(self%element(i), :), tau, now, acceleration(i))
      end do
   end function accelerations_at

   !> Chooses the modes of the undecided couplings, which have no velocity, and sets the friction forces of all couplings as they
   !> are then. Exactly one choice is free of contradiction: what sticks needs no more than its limit, and what slips is
   !> accelerated in the direction in which it slips.
   pure subroutine choose(self, acceleration, force)
      class(friction_type), intent(inout) :: self
      !> Accelerations of the couplings without the friction of those undecided [1], (coupling).
      real(dp), intent(in) :: acceleration(:)
      !> Friction forces [1], (coupling).
      real(dp), intent(out) :: force(:)
      ! Changes of one mode at a time until they are free of contradiction; a few for each coupling in practice.
      integer, parameter :: most = 1000
      integer, allocatable :: open(:), held(:), pivot(:)
      real(dp), allocatable :: matrix(:, :), forces(:)
      real(dp) :: left
      integer :: i, n, info

      open = pack([(i, i=1, self%count)], self%mode == undecided)
      self%mode(open) = sticks
      force = merge(self%mode*self%limit, 0.0_dp, abs(self%mode) == 1)
      changes: do n = 1, most
         held = pack(open, self%mode(open) == sticks)
         force(open) = self%mode(open)*self%limit(open)
         forces = acceleration(held) - matmul(self%gain(held, open), force(open))
         matrix = self%gain(held, held)
         if (allocated(pivot)) deallocate (pivot)
         allocate (pivot(size(held)))
         call factor_matrix(size(held), matrix, pivot, info)
         call solve_factored(size(held), 1, matrix, pivot, forces)
         force(held) = forces
         do i = 1, size(open)
            associate (c => open(i))
               if (self%mode(c) == sticks) then
                  if (abs(force(c)) <= self%limit(c)) cycle
                  self%mode(c) = merge(1, -1, force(c) > 0)
               else
                  left = acceleration(c) - dot_product(self%gain(c, open), force(open))
                  if (self%mode(c)*left >= 0) cycle
                  self%mode(c) = sticks
               end if
            end associate
            cycle changes
         end do
         exit
      end do changes
      self%zeros(open) = merge(0, 1, self%mode(open) == sticks)
   end subroutine choose

   !> Forgets the events before a step.
   pure subroutine pass(self)
      class(friction_type), intent(inout) :: self

      self%zeros = 0
   end subroutine pass

   !> Lets a coupling slip whose sticking force has come to its limit: it begins to slip without acceleration.
   pure subroutine release(self, i, force)
      class(friction_type), intent(inout) :: self
      !> Number of the coupling.
      integer, intent(in) :: i
      !> The force [1].
      real(dp), intent(in) :: force

      self%mode(i) = merge(1, -1, force > 0)
      self%zeros(i) = 2
   end subroutine release

end module geartrain_flow_dry_friction
