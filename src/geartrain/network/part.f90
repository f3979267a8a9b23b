!> A free linear part of a train: masses and springs (see geartrain_network_network) that remain joined when the unknown meshes are
!> cut. The cut meshes are its ports; the harmonic balance uses the receptance between the ports.
!>
!> A mass is eliminated by the star-mesh transform. With springs s_j to the masses j and a spring e, the rest of the diagonal, to
!> ground, the elimination leaves springs s_i s_j/(e + sum of s) between masses i and j and e s_j/(e + sum of s) from mass j to
!> ground. There are no differences that might cancel: a stiff spring or a small mass beside a large mass loses no digits.
module geartrain_network_part
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_graph, only: graph_type
   implicit none (type, external)
   private
   public :: part_type, part_state_type

   type :: part_type
      !> Node of the network of each mass; inertia over reduced radius squared [kg], (mass).
      integer, allocatable :: body(:)
      real(dp), allocatable :: mass(:)
      !> Damping [N s/m] and stiffness [N/m] to ground over reduced radius squared, (mass); whether any is > 0.
      real(dp), allocatable :: drag(:), support(:)
      logical :: grounded = .false.
      !> Pairs of masses joined by springs, with fill; stiffness [N/m] and damping [N s/m] of the springs, (slot).
      type(graph_type) :: graph
      real(dp), allocatable :: stiffness(:), damping(:)
      !> Elements of the network that are springs of the part; springs and dampers to ground; whether a torque or a transmission
      !> error excites the part.
      integer, allocatable :: element(:), ground_element(:)
      logical :: excited = .false.
      !> Mass of each port; displacement of the mesh of the port over displacement of the mass, with sign [1], (port).
      integer, allocatable :: at(:)
      real(dp), allocatable :: weight(:)
      !> Unknown of each port, (port); entry of the graph of the unknowns of each pair of ports, (port, port).
      integer, allocatable :: unknown(:), entry(:, :)
      !> Factor of the receptance between the masses of two ports [N/m], (port, port): gain times receptance is the displacement
      !> over b_c of the first mesh per phi of the second mesh.
      real(dp), allocatable :: gain(:, :)
   contains
      procedure :: setup
      procedure :: has_closed_form
      procedure :: receptance
      procedure :: receptance_of_two
      procedure :: factor
      procedure :: solve
      procedure :: derivative
   end type part_type

   !> Factors of the dynamic stiffness Z of a part at one frequency.
   type :: part_state_type
      !> Frequency [rad/s].
      real(dp) :: omega = 0
      !> Springs when the first of their masses is eliminated [N/m], (slot); springs to ground [N/m] and inverse pivots [m/N],
      !> (mass).
      complex(dp), allocatable :: spring(:), ground(:), inverse(:)
   end type part_state_type

contains

   !> Makes a part without ports; parallel springs add up.
   pure subroutine setup(self, body, mass, drag, support, ends, stiffness, damping)
      class(part_type), intent(inout) :: self
      !> Node of the network of each mass, (mass); the two masses that each spring joins, (2, spring).
      integer, intent(in) :: body(:), ends(:, :)
      !> Masses [kg], damping [N s/m] and stiffness [N/m] to ground, (mass); stiffness [N/m] and damping [N s/m] of each spring,
      !> (spring).
      real(dp), intent(in) :: mass(:), drag(:), support(:), stiffness(:), damping(:)
      integer :: n, slot

      self%body = body
      self%mass = mass
      self%drag = drag
      self%support = support
      self%grounded = any(drag > 0 .or. support > 0)
      call self%graph%setup(size(mass), ends)
      allocate (self%stiffness(self%graph%slots), self%damping(self%graph%slots), source=0.0_dp)
      do n = 1, size(stiffness)
         slot = slot_of(self, ends(1, n), ends(2, n))
         self%stiffness(slot) = self%stiffness(slot) + stiffness(n)
         self%damping(slot) = self%damping(slot) + damping(n)
      end do
   end subroutine setup

   !> Whether `receptance_of_two` has its receptance.
   pure logical function has_closed_form(self)
      class(part_type), intent(in) :: self

      has_closed_form = size(self%mass) == 1 .or. size(self%mass) == 2 .and. .not. self%grounded
   end function has_closed_form

   !> Slot of two masses joined by a spring.
   pure integer function slot_of(self, i, j)
      type(part_type), intent(in) :: self
      integer, intent(in) :: i, j

      slot_of = self%graph%entry_of(i, j) - self%graph%nodes
      if (slot_of > self%graph%slots) slot_of = slot_of - self%graph%slots
   end function slot_of

   !> Receptance between the masses of the ports.
   pure subroutine receptance(self, omega, alpha, d_alpha)
      class(part_type), intent(in) :: self
      !> Frequency > 0 [rad/s].
      real(dp), intent(in) :: omega
      !> Displacement over force [m/N], (port, port).
      complex(dp), intent(out) :: alpha(:, :)
      !> Derivative of `alpha` with respect to omega [m s/(N rad)], (port, port).
      complex(dp), intent(out), optional :: d_alpha(:, :)
      !> One array for all work space: an allocation for each array would cost more than the arithmetic.
      complex(dp) :: room(self%graph%slots + 2*size(self%mass) + size(self%at)*(size(self%mass) + 1))

      associate (slots => self%graph%slots, masses => size(self%mass), ports => size(self%at))
         call receptance_in(self, omega, slots, masses, ports, room, room(slots + 1), room(slots + masses + 1), &
                            room(slots + 2*masses + 1), room(slots + 2*masses + ports*masses + 1), alpha, d_alpha)
      end associate
   end subroutine receptance

   !> `receptance` with its work space.
   pure subroutine receptance_in(self, omega, slots, masses, ports, spring, ground, inverse, x, difference, alpha, d_alpha)
      type(part_type), intent(in) :: self
      real(dp), intent(in) :: omega
      integer, intent(in) :: slots, masses, ports
      complex(dp), intent(inout) :: spring(slots), ground(masses), inverse(masses), x(ports, masses), difference(ports)
      complex(dp), intent(out) :: alpha(:, :)
      complex(dp), intent(out), optional :: d_alpha(:, :)
      integer :: j, k, s

      call eliminate(self, omega, spring, ground, inverse)
      x = 0
      do j = 1, size(self%at)
         x(j, self%at(j)) = 1
      end do
      associate (graph => self%graph)
         do k = 1, graph%nodes
            associate (i => graph%order(k))
               do s = graph%first(k), graph%first(k + 1) - 1
                  x(:, graph%later(s)) = x(:, graph%later(s)) + (spring(s)*inverse(i))*x(:, i)
               end do
            end associate
         end do
         do k = graph%nodes, 1, -1
            associate (i => graph%order(k))
               do s = graph%first(k), graph%first(k + 1) - 1
                  x(:, i) = x(:, i) + spring(s)*x(:, graph%later(s))
               end do
               x(:, i) = inverse(i)*x(:, i)
            end associate
         end do
         do j = 1, size(self%at)
            alpha(:, j) = x(:, self%at(j))
         end do
         if (.not. present(d_alpha)) return
         ! X^T Z X' = -X^T Z' X, Z being symmetric.
         d_alpha = 0
         do k = 1, graph%nodes
            associate (i => graph%order(k))
               call subtract(cmplx(-2*omega*self%mass(i), self%drag(i), dp), x(:, i), d_alpha)
               do s = graph%first(k), graph%first(k + 1) - 1
                  difference = x(:, i) - x(:, graph%later(s))
                  call subtract(cmplx(0, self%damping(s), dp), difference, d_alpha)
               end do
            end associate
         end do
      end associate
   end subroutine receptance_in

   !> a := a - factor y y^T.
   pure subroutine subtract(factor, y, a)
      complex(dp), intent(in) :: factor, y(:)
      complex(dp), intent(inout) :: a(:, :)
      complex(dp) :: product
      integer :: i, j

      do j = 1, size(y)
         product = factor*y(j)
         do i = 1, size(y)
            a(i, j) = a(i, j) - product*y(i)
         end do
      end do
   end subroutine subtract

   !> Receptance in closed form of a part of one mass, or of two masses on a spring without springs and dampers to ground.
   pure subroutine receptance_of_two(self, omega, alpha, d_alpha)
      class(part_type), intent(in) :: self
      !> Frequency > 0 [rad/s].
      real(dp), intent(in) :: omega
      !> Displacement over force [m/N] between masses 1 and 1, 1 and 2, 2 and 2; of one mass all three are equal.
      complex(dp), intent(out) :: alpha(3)
      !> Derivatives of `alpha` with respect to omega [m s/(N rad)].
      complex(dp), intent(out), optional :: d_alpha(3)
      complex(dp) :: spring, determinant, inverse, d_denominator
      real(dp) :: square, both, product, scale

      if (size(self%mass) == 1) then
         if (self%grounded) then
            alpha = 1/cmplx(self%support(1) - omega**2*self%mass(1), omega*self%drag(1), dp)
            if (present(d_alpha)) d_alpha = alpha**2*cmplx(2*omega*self%mass(1), -self%drag(1), dp)
         else
            alpha = -1/(omega**2*self%mass(1))
            if (present(d_alpha)) d_alpha = -2*alpha/omega
         end if
         return
      end if
      square = omega**2
      both = self%mass(1) + self%mass(2)
      product = self%mass(1)*self%mass(2)
      spring = cmplx(self%stiffness(1), omega*self%damping(1), dp)
      ! In real parts: gfortran makes a complex number of a real factor, and a division cautious.
      determinant = cmplx(square*product - spring%re*both, -spring%im*both, dp)
      scale = 1/(square*(determinant%re**2 + determinant%im**2))
      inverse = cmplx(determinant%re*scale, -determinant%im*scale, dp)
      alpha(1) = cmplx(spring%re - square*self%mass(2), spring%im, dp)*inverse
      alpha(2) = spring*inverse
      alpha(3) = cmplx(spring%re - square*self%mass(1), spring%im, dp)*inverse
      if (.not. present(d_alpha)) return
      d_denominator = cmplx(2*omega*(determinant%re + square*product), &
                            2*omega*determinant%im - square*both*self%damping(1), dp)
      d_alpha(1) = (cmplx(-2*omega*self%mass(2), self%damping(1), dp) - alpha(1)*d_denominator)*inverse
      d_alpha(2) = (cmplx(0, self%damping(1), dp) - alpha(2)*d_denominator)*inverse
      d_alpha(3) = (cmplx(-2*omega*self%mass(1), self%damping(1), dp) - alpha(3)*d_denominator)*inverse
   end subroutine receptance_of_two

   !> Eliminates the masses.
   pure subroutine factor(self, omega, state)
      class(part_type), intent(in) :: self
      !> Frequency > 0 [rad/s].
      real(dp), intent(in) :: omega
      !> The factors.
      type(part_state_type), intent(out) :: state

      state%omega = omega
      allocate (state%spring(self%graph%slots), state%ground(size(self%mass)), state%inverse(size(self%mass)))
      call eliminate(self, omega, state%spring, state%ground, state%inverse)
   end subroutine factor

   !> Springs when the first of their masses is eliminated, springs to ground and inverse pivots, as `part_state_type` has them.
   pure subroutine eliminate(self, omega, spring, ground, inverse)
      type(part_type), intent(in) :: self
      real(dp), intent(in) :: omega
      complex(dp), intent(out) :: spring(:), ground(:), inverse(:)
      complex(dp) :: share
      integer :: i, k, n, s, t, slot

      spring = cmplx(self%stiffness, omega*self%damping, dp)
      ground = cmplx(self%support - omega**2*self%mass, omega*self%drag, dp)
      associate (graph => self%graph)
         do k = 1, graph%nodes
            i = graph%order(k)
            associate (first => graph%first(k), last => graph%first(k + 1) - 1)
               inverse(i) = 1/(ground(i) + sum(spring(first:last)))
               n = graph%update(k)
               do s = first, last
                  share = spring(s)*inverse(i)
                  ground(graph%later(s)) = ground(graph%later(s)) + share*ground(i)
                  do t = first, s - 1
                     slot = graph%target(n + t - first + 1) - graph%nodes
                     if (slot > graph%slots) slot = slot - graph%slots
                     spring(slot) = spring(slot) + share*spring(t)
                  end do
                  n = n + last - first + 1
               end do
            end associate
         end do
      end associate
   end subroutine eliminate

   !> Solves for displacements, and for the differences of displacements by their own recurrence: a difference of two displacements
   !> would cancel on a stiff spring.
   pure subroutine solve(self, state, x, difference)
      class(part_type), intent(in) :: self
      !> Factors from `factor`.
      type(part_state_type), intent(in) :: state
      !> Forces on the masses [N], then displacements [m], (mass).
      complex(dp), intent(inout) :: x(:)
      !> Displacement of the mass eliminated earlier less displacement of the mass eliminated later [m], (slot).
      complex(dp), intent(out) :: difference(:)
      complex(dp) :: force
      integer :: i, k, n, s, t, slot

      associate (graph => self%graph)
         do k = 1, graph%nodes
            i = graph%order(k)
            do s = graph%first(k), graph%first(k + 1) - 1
               x(graph%later(s)) = x(graph%later(s)) + state%spring(s)*state%inverse(i)*x(i)
            end do
         end do
         do k = graph%nodes, 1, -1
            i = graph%order(k)
            associate (first => graph%first(k), last => graph%first(k + 1) - 1)
               force = x(i)
               x(i) = state%inverse(i)*(force + sum(state%spring(first:last)*x(graph%later(first:last))))
               n = graph%update(k)
               do s = first, last
                  ! `difference` so far is the pivot times x(i) - x(later(s)).
                  difference(s) = force - state%ground(i)*x(graph%later(s))
                  do t = first, last
                     n = n + 1
                     if (t == s) cycle
                     slot = graph%target(n) - graph%nodes
                     if (slot > graph%slots) then
                        ! later(t) is eliminated before later(s).
                        difference(s) = difference(s) + state%spring(t)*difference(slot - graph%slots)
                     else
                        difference(s) = difference(s) - state%spring(t)*difference(slot)
                     end if
                  end do
                  difference(s) = state%inverse(i)*difference(s)
               end do
            end associate
         end do
      end associate
   end subroutine solve

   !> Product (dZ/d omega) x with the dynamic stiffness Z.
   pure function derivative(self, omega, x) result(force)
      class(part_type), intent(in) :: self
      !> Frequency > 0 [rad/s].
      real(dp), intent(in) :: omega
      !> Displacements [m], (mass).
      complex(dp), intent(in) :: x(:)
      complex(dp) :: force(size(x)), damping
      integer :: i, k, s

      force = cmplx(-2*omega*self%mass, self%drag, dp)*x
      do k = 1, self%graph%nodes
         i = self%graph%order(k)
         do s = self%graph%first(k), self%graph%first(k + 1) - 1
            associate (j => self%graph%later(s))
               damping = cmplx(0, self%damping(s), dp)*(x(i) - x(j))
               force(i) = force(i) + damping
               force(j) = force(j) - damping
            end associate
         end do
      end do
   end function derivative

end module geartrain_network_part
