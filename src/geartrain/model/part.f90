!> A free linear part of a train, what hangs together when the unknown meshes are cut: masses on springs (see
!> geartrain_model_network), with the meshes that touch it as ports. Its receptance between the ports stands for it in the
!> harmonic balance.
!>
!> A mass is eliminated by the star-mesh transform: with springs s_j to the masses j and e, the rest of the diagonal, to ground,
!> it leaves springs s_i s_j/(e + sum of s) between these and e s_j/(e + sum of s) to ground. Nothing is subtracted that might
!> cancel: a stiff spring, a small mass beside a large one lose no digits.
module geartrain_model_part
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_graph, only: graph_type
   implicit none (type, external)
   private
   public :: part_type, part_state_type

   type :: part_type
      !> Body of the network of each mass, and masses over reduced radii squared [kg], (mass).
      integer, allocatable :: body(:)
      real(dp), allocatable :: mass(:)
      !> Damping to ground over reduced radii squared [N s/m], (mass); whether there is any.
      real(dp), allocatable :: drag(:)
      logical :: dragged = .false.
      !> Which masses springs join, with fill; stiffness [N/m] and damping [N s/m], (slot).
      type(graph_type) :: graph
      real(dp), allocatable :: stiffness(:), damping(:)
      !> Elements of the network that are springs here; whether something within excites it.
      integer, allocatable :: element(:)
      logical :: excited = .false.
      !> Mass of each port and displacement of its mesh per displacement of the mass, with its sign [1], (port).
      integer, allocatable :: at(:)
      real(dp), allocatable :: weight(:)
      !> Unknown that each port belongs to, (port), and the entries of the balance's graph between them, (port, port).
      integer, allocatable :: unknown(:), entry(:, :)
      !> What a receptance of the masses of two ports is multiplied with: displacement of the first mesh per phi of the second over
      !> k b_c [N/m], (port, port).
      real(dp), allocatable :: gain(:, :)
   contains
      procedure :: setup
      procedure :: receptance
      procedure :: receptance_of_two
      procedure :: factor
      procedure :: solve
      procedure :: derivative
   end type part_type

   !> A part at one frequency: factors of its masses.
   type :: part_state_type
      !> [rad/s]
      real(dp) :: omega = 0
      !> Springs as they are met [N/m], (slot); what goes to ground and the inverse pivot, (mass).
      complex(dp), allocatable :: spring(:), ground(:), inverse(:)
   end type part_state_type

contains

   !> Masses joined by springs, each column of `ends` one; parallel springs add up. The ports come later.
   pure subroutine setup(self, body, mass, drag, ends, stiffness, damping)
      class(part_type), intent(inout) :: self
      integer, intent(in) :: body(:), ends(:, :)
      real(dp), intent(in) :: mass(:), drag(:), stiffness(:), damping(:)
      integer :: n, slot

      self%body = body
      self%mass = mass
      self%drag = drag
      self%dragged = any(drag > 0)
      call self%graph%setup(size(mass), ends)
      allocate (self%stiffness(self%graph%slots), self%damping(self%graph%slots), source=0.0_dp)
      do n = 1, size(stiffness)
         slot = slot_of(self, ends(1, n), ends(2, n))
         self%stiffness(slot) = self%stiffness(slot) + stiffness(n)
         self%damping(slot) = self%damping(slot) + damping(n)
      end do
   end subroutine setup

   !> The slot of two masses that a spring joins.
   pure integer function slot_of(self, i, j)
      type(part_type), intent(in) :: self
      integer, intent(in) :: i, j

      slot_of = self%graph%entry_of(i, j) - self%graph%nodes
      if (slot_of > self%graph%slots) slot_of = slot_of - self%graph%slots
   end function slot_of

   !> Displacement per force between the masses of the ports [m/N], and its derivative with respect to omega, (port, port);
   !> omega > 0 [rad/s].
   pure subroutine receptance(self, omega, alpha, d_alpha)
      class(part_type), intent(in) :: self
      real(dp), intent(in) :: omega
      complex(dp), intent(out) :: alpha(:, :), d_alpha(:, :)
      type(part_state_type) :: state
      complex(dp) :: x(size(self%mass), size(self%at)), changed(size(self%mass)), difference(self%graph%slots)
      integer :: i, j

      call self%factor(omega, state)
      do j = 1, size(self%at)
         x(:, j) = 0
         x(self%at(j), j) = 1
         call self%solve(state, x(:, j), difference)
         alpha(:, j) = x(self%at, j)
      end do
      ! X^T Z X' = -X^T Z' X, Z being symmetric.
      do j = 1, size(self%at)
         changed = self%derivative(omega, x(:, j))
         do i = 1, size(self%at)
            d_alpha(i, j) = -sum(x(:, i)*changed)
         end do
      end do
   end subroutine receptance

   !> `receptance` in closed form between one mass, or two on a spring, without damping to ground: (1, 1), (1, 2) and (2, 2).
   pure subroutine receptance_of_two(self, omega, alpha, d_alpha)
      class(part_type), intent(in) :: self
      real(dp), intent(in) :: omega
      complex(dp), intent(out) :: alpha(3), d_alpha(3)
      complex(dp) :: spring, d_spring, inverse, d_denominator, d_numerator(3)
      real(dp) :: both, product

      if (size(self%mass) == 1) then
         alpha = -1/(omega**2*self%mass(1))
         d_alpha = -2*alpha/omega
         return
      end if
      spring = cmplx(self%stiffness(1), omega*self%damping(1), dp)
      d_spring = cmplx(0, self%damping(1), dp)
      both = self%mass(1) + self%mass(2)
      product = self%mass(1)*self%mass(2)
      inverse = 1/(omega**2*(omega**2*product - spring*both))
      d_denominator = 4*omega**3*product - 2*omega*spring*both - omega**2*d_spring*both
      alpha = [spring - omega**2*self%mass(2), spring, spring - omega**2*self%mass(1)]*inverse
      d_numerator = [d_spring - 2*omega*self%mass(2), d_spring, d_spring - 2*omega*self%mass(1)]
      d_alpha = (d_numerator - alpha*d_denominator)*inverse
   end subroutine receptance_of_two

   !> Eliminates the masses at omega > 0 [rad/s].
   pure subroutine factor(self, omega, state)
      class(part_type), intent(in) :: self
      real(dp), intent(in) :: omega
      type(part_state_type), intent(out) :: state
      complex(dp) :: share
      integer :: i, k, n, s, t, slot

      state%omega = omega
      state%spring = cmplx(self%stiffness, omega*self%damping, dp)
      state%ground = cmplx(-omega**2*self%mass, omega*self%drag, dp)
      allocate (state%inverse(size(self%mass)))
      associate (graph => self%graph)
         do k = 1, graph%nodes
            i = graph%order(k)
            associate (first => graph%first(k), last => graph%first(k + 1) - 1)
               state%inverse(i) = 1/(state%ground(i) + sum(state%spring(first:last)))
               n = graph%update(k)
               do s = first, last
                  share = state%spring(s)*state%inverse(i)
                  state%ground(graph%later(s)) = state%ground(graph%later(s)) + share*state%ground(i)
                  do t = first, s - 1
                     slot = graph%target(n + t - first + 1) - graph%nodes
                     if (slot > graph%slots) slot = slot - graph%slots
                     state%spring(slot) = state%spring(slot) + share*state%spring(t)
                  end do
                  n = n + last - first + 1
               end do
            end associate
         end do
      end associate
   end subroutine factor

   !> Displacements [m] in place of the forces on the masses [N], (mass), and of the earlier less the later mass of each slot,
   !> (slot), which is found by itself: a difference would cancel on a stiff spring.
   pure subroutine solve(self, state, x, difference)
      class(part_type), intent(in) :: self
      type(part_state_type), intent(in) :: state
      complex(dp), intent(inout) :: x(:)
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
                  ! The others as seen from later(s): the pivot times x(i) - x(later(s)).
                  difference(s) = force - state%ground(i)*x(graph%later(s))
                  do t = first, last
                     n = n + 1
                     if (t == s) cycle
                     slot = graph%target(n) - graph%nodes
                     if (slot > graph%slots) then
                        ! Row later(s), column later(t), which is eliminated first.
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

   !> (dZ/d omega) x.
   pure function derivative(self, omega, x) result(force)
      class(part_type), intent(in) :: self
      real(dp), intent(in) :: omega
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

end module geartrain_model_part
