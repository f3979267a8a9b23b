!> What a balance leaves out: the harmonics above its highest, and what they do to those it carries.
module geartrain_motion_truncation
   use geartrain_base_kinds, only: dp
   use geartrain_model_receptance, only: find_receptance, receptance_type
   use geartrain_motion_balance, only: balance_type
   use geartrain_motion_linearization, only: linearization_type
   use geartrain_motion_trigonometric, only: sample
   implicit none (type, external)
   private
   public :: truncation_error

contains

   !> Relative error of the waveform, to first order: the missing tail follows from the force at harmonics highest+1 ..
   !> 3 highest, and its effect on the kept harmonics, at constant Lambda, costs one solve with `matrix`, factored at this
   !> solution with any border row; the tangent (and its Lambda part) takes out what that row lets Lambda move.
   !>
   !> Where that is y and Lambda = slope s + bend s**2/2 along the branch, the way back along it is about y/slope, and
   !> sqrt(2 y/bend) at a fold, which moves by y.
   subroutine truncation_error(balance, u, frequency, tangent, tangent_frequency, bend, matrix, estimate)
      type(balance_type), intent(inout) :: balance
      !> The solution, the unit tangent there and the change of its Lambda part along the branch.
      real(dp), intent(in) :: u(:, :), frequency, tangent(:, :), tangent_frequency, bend
      type(linearization_type), intent(inout) :: matrix
      real(dp), intent(out) :: estimate
      complex(dp) :: tail(2*balance%highest, balance%unknowns), shift
      real(dp) :: correction(balance%block, balance%unknowns), d_phi(balance%block, balance%unknowns), y, slope
      integer :: i, k, neighbour

      if (balance%unknowns == 0 .or. size(balance%harmonic) == 0) then
         estimate = 0
         return
      end if
      call forces_beyond(balance, u, tail)
      call find_tail(balance, frequency, tail)
      do i = 1, balance%unknowns
         if (balance%is_direct()) then
            d_phi(:, i) = tail_force(balance, i, tail(:, i))
         else
            call transform_tail(balance, i, tail(:, i), d_phi(:, i))
         end if
      end do
      do i = 1, balance%unknowns
         correction(1, i) = -d_phi(1, i)
         do k = 1, size(balance%harmonic)
            shift = 0
            do neighbour = max(1, i - 1), min(balance%unknowns, i + 1)
               shift = shift - balance%receptance(k)%h(neighbour - i + 2, balance%mesh(i)) &
                       *cmplx(d_phi(2*k, neighbour), -d_phi(2*k + 1, neighbour), dp)
            end do
            correction(2*k, i) = shift%re
            correction(2*k + 1, i) = -shift%im
         end do
      end do
      y = 0
      call matrix%solve(balance, correction, y)
      slope = abs(tangent_frequency)/2 + sqrt(tangent_frequency**2/4 + abs(bend*y)/2)
      correction = correction - y/sign(max(slope, tiny(1.0_dp)), tangent_frequency)*tangent
      estimate = sqrt((sum(abs(tail)**2) + 2*sum(correction(1, :)**2) + sum(correction(2:, :)**2)) &
                      /max(sum(u(2:, :)**2), tiny(1.0_dp)))
   end subroutine truncation_error

   !> Forces of the unknown meshes at harmonics highest+1 .. 3 highest, (2*highest, unknowns), that the kept ones cause.
   subroutine forces_beyond(balance, u, force)
      type(balance_type), intent(inout) :: balance
      real(dp), intent(in) :: u(:, :)
      complex(dp), intent(out) :: force(:, :)
      integer :: i, m

      do i = 1, balance%unknowns
         if (balance%is_direct()) then
            do m = 1, size(force, 1)
               force(m, i) = force_at(balance, i, u(:, i), balance%highest + m)
            end do
         else
            associate (contact => balance%contact(i), wide => balance%wide, n => balance%highest)
               call sample(u(:, i), balance%harmonic, wide)
               call multiply(balance, i)
               force(:, i) = 2*(wide%coefficient(n + 2:3*n + 1) - contact%backlash*contact%offset(n + 1:3*n))
            end associate
         end if
      end do
   end subroutine forces_beyond

   !> Multiplies the waveform in balance%wide%sample with the stiffness in contact of unknown mesh i; leaves coefficients there.
   subroutine multiply(balance, i)
      type(balance_type), intent(inout) :: balance
      integer, intent(in) :: i
      real(dp) :: waveform(balance%wide%samples)

      associate (wide => balance%wide)
         waveform = wide%sample/wide%samples
         wide%coefficient = 0
         wide%coefficient(:4*balance%highest + 1) = balance%contact(i)%stiffness
         call wide%to_samples()
         wide%sample = waveform*wide%sample
         call wide%to_coefficients()
      end associate
   end subroutine multiply

   !> Complex amplitudes at harmonics highest+1 .. 3 highest, in place of the forces there, (2*highest, unknowns): each harmonic by
   !> itself, the meshes coupled and with their mean stiffness in contact (a harmonic near a natural frequency resonates).
   subroutine find_tail(balance, frequency, tail)
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: frequency
      complex(dp), intent(inout) :: tail(:, :)
      type(receptance_type) :: local
      complex(dp) :: force(balance%unknowns), stiffness(balance%unknowns), pivot(balance%unknowns), ratio
      integer :: i, m, r, neighbour

      do m = 1, size(tail, 1)
         r = balance%highest + m
         force = tail(m, :)
         tail(m, :) = 0
         do i = 1, balance%unknowns
            stiffness(i) = balance%mean_stiffness(i, r)
         end do
         if (all(abs(force) < tiny(1.0_dp)) .and. balance%eta == 1 .and. mod(r, balance%system%excitation_order) /= 0) cycle
         call find_receptance(balance%system, balance%unknown, frequency, r, balance%eta, local)
         ! Elimination down the chain and back; the diagonal is 1 plus something small, save at a resonance.
         associate (p => tail(m, :), h => local%h(:, balance%mesh))
            do i = 1, balance%unknowns
               p(i) = local%a(balance%mesh(i))
               do neighbour = max(1, i - 1), min(balance%unknowns, i + 1)
                  p(i) = p(i) - h(neighbour - i + 2, i)*force(neighbour)
               end do
               pivot(i) = 1 + h(2, i)*stiffness(i)
               if (i == 1) cycle
               ratio = h(1, i)*stiffness(i - 1)/pivot(i - 1)
               pivot(i) = pivot(i) - ratio*h(3, i - 1)*stiffness(i)
               p(i) = p(i) - ratio*p(i - 1)
            end do
            do i = balance%unknowns, 1, -1
               if (i < balance%unknowns) p(i) = p(i) - h(3, i)*stiffness(i + 1)*p(i + 1)
               p(i) = p(i)/pivot(i)
            end do
            tail(m, :) = p
         end associate
      end do
   end subroutine find_tail

   !> Force of unknown mesh i at harmonic r, not a kept one, that the kept ones cause.
   pure complex(dp) function force_at(balance, i, u, r)
      type(balance_type), intent(in) :: balance
      integer, intent(in) :: i, r
      real(dp), intent(in) :: u(:)
      integer :: k

      associate (w => balance%contact(i)%stiffness, contact => balance%contact(i))
         force_at = 2*w(r)*u(1) - 2*contact%backlash*contact%offset(r)
         do k = 1, size(balance%harmonic)
            force_at = force_at + w(r - balance%harmonic(k))*cmplx(u(2*k), -u(2*k + 1), dp) &
                       + w(r + balance%harmonic(k))*cmplx(u(2*k), u(2*k + 1), dp)
         end do
      end associate
   end function force_at

   !> Force at the kept harmonics that the missing tail causes, to first order.
   pure function tail_force(balance, i, tail) result(d_phi)
      type(balance_type), intent(in) :: balance
      integer, intent(in) :: i
      complex(dp), intent(in) :: tail(:)
      real(dp) :: d_phi(balance%block)
      complex(dp) :: total
      integer :: k, m, r

      associate (w => balance%contact(i)%stiffness)
         d_phi(1) = 0
         do m = 1, size(tail)
            d_phi(1) = d_phi(1) + real(conjg(w(balance%highest + m))*tail(m), dp)
         end do
         do k = 1, size(balance%harmonic)
            total = 0
            do m = 1, size(tail)
               r = balance%highest + m
               total = total + conjg(w(r - balance%harmonic(k)))*tail(m) + w(r + balance%harmonic(k))*conjg(tail(m))
            end do
            d_phi(2*k) = total%re
            d_phi(2*k + 1) = -total%im
         end do
      end associate
   end function tail_force

   !> The same by FFT.
   subroutine transform_tail(balance, i, tail, d_phi)
      type(balance_type), intent(inout) :: balance
      integer, intent(in) :: i
      complex(dp), intent(in) :: tail(:)
      real(dp), intent(out) :: d_phi(:)
      integer :: k

      associate (wide => balance%wide, r => balance%harmonic, n => balance%highest)
         wide%coefficient = 0
         wide%coefficient(n + 2:3*n + 1) = tail/2
         call wide%to_samples()
         call multiply(balance, i)
         d_phi(1) = real(wide%coefficient(1), dp)
         do k = 1, size(r)
            d_phi(2*k) = 2*real(wide%coefficient(r(k) + 1), dp)
            d_phi(2*k + 1) = -2*aimag(wide%coefficient(r(k) + 1))
         end do
      end associate
   end subroutine transform_tail

end module geartrain_motion_truncation
