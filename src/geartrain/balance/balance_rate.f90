!> Derivative of the residual of a harmonic balance with respect to a parameter, at constant coefficients and Lambda, and of the
!> displacements of the linear elements.
!>
!> In each linear part Z x = f with the dynamic stiffness Z, and S_i = u_i - e_i - w_i . x. So dS_i = -de_i - dw_i . x
!> - w_i . Z^-1 (df - dZ x): with x and the receptances Z^-1 w_i at hand a parameter costs a sum over masses and springs.
module geartrain_balance_balance_rate
   use geartrain_balance_balance, only: balance_type
   use geartrain_base_kinds, only: dp
   use geartrain_model_part, only: part_state_type
   use geartrain_model_receptance, only: amplitude_at, find_sources
   use geartrain_model_system_rate, only: system_rate_type
   implicit none (type, external)
   private
   public :: balance_rate_type

   !> A linear part at one harmonic.
   type :: part_motion_type
      type(part_state_type) :: state
      !> Displacements over b_c [1], (mass), and their differences, (slot).
      complex(dp), allocatable :: x(:), difference(:)
      !> Receptance of each port [m/N], (mass, port), and its differences, (slot, port).
      complex(dp), allocatable :: reach(:, :), reach_difference(:, :)
   end type part_motion_type

   type :: balance_rate_type
      !> phi of the unknown meshes that move the parts, (block, unknown); whether torques and transmission errors do as well.
      real(dp), allocatable :: force(:, :)
      logical :: excited = .true.
      type(part_motion_type), allocatable, private :: at(:, :)
   contains
      procedure :: setup
      procedure :: residual
      procedure :: displacements
      procedure, private :: push
   end type balance_rate_type

contains

   !> Finds the motion of the parts.
   subroutine setup(self, balance, force, excited)
      class(balance_rate_type), intent(inout) :: self
      !> The balance, evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> Coefficients of phi of the unknown meshes [1], (block, unknown).
      real(dp), intent(in) :: force(:, :)
      !> Whether torques and transmission errors act.
      logical, intent(in) :: excited
      complex(dp), allocatable :: unused(:)
      real(dp) :: omega
      integer :: j, k, p

      self%force = force
      self%excited = excited
      if (allocated(self%at)) deallocate (self%at)
      associate (system => balance%system, cut => balance%system%cut)
         allocate (self%at(size(cut%part), size(balance%harmonic)))
         do k = 1, size(balance%harmonic)
            omega = system%characteristic_frequency*balance%harmonic(k)/balance%eta*balance%frequency_ratio
            do p = 1, size(cut%part)
               associate (part => cut%part(p), at => self%at(p, k))
                  allocate (at%x(size(part%mass)), at%difference(part%graph%slots), unused(size(part%mass)))
                  at%x = 0
                  if (excited) call find_sources(system, p, omega, balance%harmonic(k), balance%eta, at%x, unused)
                  deallocate (unused)
                  do j = 1, size(part%at)
                     associate (i => part%unknown(j))
                        at%x(part%at(j)) = at%x(part%at(j)) - part%weight(j)*system%stiffness(cut%element(i)) &
                                           *cmplx(force(2*k, i), -force(2*k + 1, i), dp)
                     end associate
                  end do
                  call part%factor(omega, at%state)
                  call part%solve(at%state, at%x, at%difference)
                  allocate (at%reach(size(part%mass), size(part%at)), at%reach_difference(part%graph%slots, size(part%at)))
                  at%reach = 0
                  do j = 1, size(part%at)
                     at%reach(part%at(j), j) = part%weight(j)
                     call part%solve(at%state, at%reach(:, j), at%reach_difference(:, j))
                  end do
               end associate
            end do
         end do
      end associate
   end subroutine setup

   !> Derivative of the residual.
   subroutine residual(self, balance, rate, u, d_force, s)
      class(balance_rate_type), intent(in) :: self
      !> The balance.
      type(balance_type), intent(in) :: balance
      !> Derivatives of the system.
      type(system_rate_type), intent(in) :: rate
      !> Coefficients over b_c [1], and derivative of phi [1/unit of the parameter], (block, unknown).
      real(dp), intent(in) :: u(:, :), d_force(:, :)
      !> Derivative of S, (block, unknown).
      real(dp), intent(out) :: s(:, :)
      complex(dp) :: masses(size(balance%system%network%inertia)), springs(balance%system%elements), total
      logical :: moves(size(balance%system%cut%part)), sources
      integer :: i, j, k, n, p

      associate (cut => balance%system%cut, graph => balance%system%cut%graph, mean => balance%system%mean)
         do i = 1, balance%unknowns
            s(1, i) = 0
            if (self%excited) s(1, i) = -rate%mean%static_force(i)
            do n = graph%row(i), graph%row(i + 1) - 1
               associate (other => graph%column(n), entry => graph%entry(n))
                  s(1, i) = s(1, i) + mean%force(entry)*d_force(1, other) + rate%mean%force(entry)*self%force(1, other) &
                            + rate%mean%displacement(entry)*u(1, other)
               end associate
            end do
         end do
         ! Most parameters touch one part or two.
         sources = .false.
         do j = 1, size(rate%torque)
            sources = sources .or. size(rate%torque(j)%amplitude) > 0
         end do
         do j = 1, size(rate%transmission_error)
            sources = sources .or. size(rate%transmission_error(j)%amplitude) > 0
         end do
         do p = 1, size(cut%part)
            associate (part => cut%part(p), d => rate%network)
               moves(p) = sources
               do j = 1, size(part%body)
                  associate (b => part%body(j))
                     moves(p) = moves(p) .or. abs(d%mass(b)) > 0 .or. abs(d%drag(b)) > 0 .or. abs(d%radius(b)) > 0
                  end associate
               end do
               do j = 1, size(part%element)
                  moves(p) = moves(p) .or. touched(part%element(j))
               end do
               do j = 1, size(part%unknown)
                  moves(p) = moves(p) .or. touched(cut%element(part%unknown(j))) .or. any(abs(d_force(:, part%unknown(j))) > 0)
               end do
               if (size(part%at) == 0) moves(p) = .false.
            end associate
         end do
         do k = 1, size(balance%harmonic)
            do i = 1, balance%unknowns
               total = 0
               if (self%excited) total = -amplitude_at(rate%transmission_error(balance%mesh(i)), balance%harmonic(k), balance%eta)
               s(2*k:2*k + 1, i) = [total%re, -total%im]
            end do
            do p = 1, size(cut%part)
               associate (part => cut%part(p), at => self%at(p, k))
                  if (.not. moves(p)) cycle
                  call self%push(balance, rate, p, k, d_force, masses, springs)
                  do j = 1, size(part%at)
                     associate (i => part%unknown(j))
                        total = part%weight(j)*rate%network%gain(cut%element(i))*at%x(part%at(j)) &
                                + sum(at%reach(:, j)*masses(:size(part%mass)))
                        do n = 1, size(part%element)
                           associate (e => part%element(n))
                              total = total - cut%scale(e)*at%reach_difference(cut%slot(e), j)*springs(n)
                           end associate
                        end do
                        s(2*k, i) = s(2*k, i) - total%re
                        s(2*k + 1, i) = s(2*k + 1, i) + total%im
                     end associate
                  end do
               end associate
            end do
         end do
      end associate
   contains

      pure logical function touched(e)
         integer, intent(in) :: e

         touched = abs(rate%network%stiffness(e)) > 0 .or. abs(rate%network%element_damping(e)) > 0 &
                   .or. abs(rate%network%gain(e)) > 0
      end function touched

   end subroutine residual

   !> df - dZ x in a part at a harmonic: what acts on masses, and pairs of forces by springs, positive as elastic forces are.
   subroutine push(self, balance, rate, p, k, d_force, masses, springs)
      class(balance_rate_type), intent(in) :: self
      type(balance_type), intent(in) :: balance
      type(system_rate_type), intent(in) :: rate
      integer, intent(in) :: p, k
      real(dp), intent(in) :: d_force(:, :)
      !> Force over b_c [N/m], (mass); (number in part%element).
      complex(dp), intent(out) :: masses(:), springs(:)
      complex(dp) :: stiffness, error, d_error
      real(dp) :: omega
      integer :: j, n, r

      associate (system => balance%system, cut => balance%system%cut, part => balance%system%cut%part(p), at => self%at(p, k), &
                 d => rate%network, network => balance%system%network)
         r = balance%harmonic(k)
         omega = at%state%omega
         do n = 1, size(part%mass)
            associate (node => part%body(n))
               masses(n) = cmplx(omega**2*d%mass(node), -omega*d%drag(node), dp)*at%x(n)
            end associate
         end do
         if (self%excited) then
            do j = 1, size(system%torque)
               associate (node => network%node(system%torque_body(j)))
                  if (cut%home(node) /= p) cycle
                  masses(cut%mass(node)) = masses(cut%mass(node)) + (amplitude_at(rate%torque(j), r, balance%eta) &
                     - amplitude_at(system%torque(j), r, balance%eta)*d%radius(node))/network%radius(node)
               end associate
            end do
         end if
         do j = 1, size(part%at)
            associate (i => part%unknown(j), e => cut%element(part%unknown(j)))
               masses(part%at(j)) = masses(part%at(j)) - part%weight(j) &
                  *((d%gain(e)*system%stiffness(e) + d%stiffness(e))*cmplx(self%force(2*k, i), -self%force(2*k + 1, i), dp) &
                    + system%stiffness(e)*cmplx(d_force(2*k, i), -d_force(2*k + 1, i), dp))
            end associate
         end do
         do n = 1, size(part%element)
            associate (e => part%element(n), element => network%elements(part%element(n)))
               error = 0
               d_error = 0
               if (self%excited .and. element%mesh > 0) then
                  error = amplitude_at(system%transmission_error(element%mesh), r, balance%eta)
                  d_error = amplitude_at(rate%transmission_error(element%mesh), r, balance%eta)
               end if
               stiffness = cmplx(element%stiffness, omega*element%damping, dp)
               associate (stretch => cut%scale(e)*at%difference(cut%slot(e)))
                  springs(n) = (d%gain(e)*stiffness + cmplx(d%stiffness(e), omega*d%element_damping(e), dp))*(stretch + error) &
                               + stiffness*(d%gain(e)*stretch + d_error)
               end associate
            end associate
         end do
      end associate
   end subroutine push

   !> Derivatives of the complex amplitudes of all elements at the carried harmonics; 0 where `linear_displacements` sets nothing.
   subroutine displacements(self, balance, rate, d_u, d_force, d_p)
      class(balance_rate_type), intent(in) :: self
      !> The balance.
      type(balance_type), intent(in) :: balance
      !> Derivatives of the system.
      type(system_rate_type), intent(in) :: rate
      !> Whole derivatives of coefficients and of phi, (block, unknown).
      real(dp), intent(in) :: d_u(:, :), d_force(:, :)
      !> Derivatives of displacements over b_c, (element, harmonic).
      complex(dp), intent(out) :: d_p(:, :)
      complex(dp) :: masses(size(balance%system%network%inertia)), springs(balance%system%elements)
      complex(dp), allocatable :: difference(:)
      integer :: i, k, l, n

      d_p = 0
      associate (system => balance%system, cut => balance%system%cut)
         do k = 1, size(balance%harmonic)
            do i = 1, balance%unknowns
               d_p(cut%element(i), k) = cmplx(d_u(2*k, i), -d_u(2*k + 1, i), dp)
            end do
            do l = 1, size(cut%part)
               associate (part => cut%part(l), at => self%at(l, k))
                  if (size(part%mass) == 1 .and. .not. part%dragged) cycle
                  call self%push(balance, rate, l, k, d_force, masses, springs)
                  do n = 1, size(part%element)
                     associate (e => part%element(n), ends => cut%mass([system%network%elements(part%element(n))%from, &
                                                                       system%network%elements(part%element(n))%to]))
                        masses(ends) = masses(ends) - [1, -1]*abs(cut%scale(e))*springs(n)
                     end associate
                  end do
                  allocate (difference(part%graph%slots))
                  call part%solve(at%state, masses(:size(part%mass)), difference)
                  do n = 1, size(part%element)
                     associate (e => part%element(n), mesh => system%element_mesh(part%element(n)))
                        d_p(e, k) = cut%scale(e)*(rate%network%gain(e)*at%difference(cut%slot(e)) + difference(cut%slot(e)))
                        if (mesh > 0) d_p(e, k) = d_p(e, k) + amplitude_at(rate%transmission_error(mesh), balance%harmonic(k), &
                                                                           balance%eta)
                     end associate
                  end do
                  deallocate (difference)
                  ! The vibration of every node with damping to ground, those that close loops too.
                  do n = system%displacements + 1, system%elements
                     associate (element => system%network%elements(n))
                        if (.not. element%grounded) cycle
                        if (cut%home(element%from) == l) d_p(n, k) = masses(cut%mass(element%from))
                     end associate
                  end do
               end associate
            end do
         end do
      end associate
   end subroutine displacements

end module geartrain_balance_balance_rate
