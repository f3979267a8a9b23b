!> What a balance leaves out: the harmonics above its highest, and what they do to those it carries.
module geartrain_motion_truncation
   use geartrain_base_kinds, only: dp
   use geartrain_model_receptance, only: find_receptance, receptance_type
   use geartrain_motion_balance, only: balance_type
   use geartrain_motion_bordered, only: bordered_type
   use geartrain_motion_trigonometric, only: evaluate
   implicit none (type, external)
   private
   public :: truncation_type, find_truncation, harmonics_for

   !> Beyond this the estimate is doubtful: 2 bend y/slope**2 (1: the fold lies at the point itself), relative error.
   real(dp), parameter :: near_fold = 0.3_dp, large = 0.1_dp
   !> Steepest branch, dLambda along it, on which a number of harmonics is to hold a tolerance: at a fold itself an error at constant
   !> Lambda falls with the root of the shift of the fold only.
   real(dp), parameter :: steepest = 0.05_dp

   type :: truncation_type
      !> Relative error of the waveform at the same Lambda, to first order.
      real(dp) :: estimate = 0
      !> The same on a branch that is nowhere steeper than `steepest`: what the number of harmonics is chosen by.
      real(dp) :: limited = 0
      !> The first order may not hold: a fold as near as it is itself misplaced, a contact that begins or ends within the error,
      !> or an error that is not small.
      logical :: doubtful = .false.
      !> Root of the sum of squares of the amplitudes above harmonic r, all meshes together, (0:3*highest).
      real(dp), allocatable :: remainder(:)
      !> The error itself, which corrects the motion to first order: of the kept coefficients (block, unknowns), and the complex
      !> amplitudes at the missing harmonics, (missing, unknowns).
      real(dp), allocatable, private :: error(:, :)
      complex(dp), allocatable, private :: tail(:, :)
   contains
      procedure :: waveform_error
   end type truncation_type

contains

   !> The missing tail follows from the force at harmonics highest+1 .. 3 highest, and its effect on the kept harmonics, at
   !> constant Lambda, costs one solve with `matrix`, factored at this solution with any border row; the tangent (and its
   !> Lambda part) takes out what that row lets Lambda move.
   !>
   !> Where that is y and Lambda = slope s + bend s**2/2 along the branch, the way back along it is the nearer root s of
   !> y + slope s + bend s**2/2 = 0.
   subroutine find_truncation(balance, u, frequency, tangent, slope, bend, unit, matrix, truncation)
      type(balance_type), intent(in) :: balance
      !> The solution, the unit tangent there, its Lambda part and the change of that along the branch.
      real(dp), intent(in) :: u(:, :), frequency, tangent(:, :), slope, bend
      !> Of Lambda, for what counts as steep.
      real(dp), intent(in) :: unit
      type(bordered_type), intent(inout) :: matrix
      type(truncation_type), intent(inout) :: truncation
      complex(dp) :: tail(size(balance%missing), balance%unknowns)
      real(dp) :: correction(balance%block, balance%unknowns), error(balance%block, balance%unknowns), y, way, scale
      integer :: i

      truncation%estimate = 0
      truncation%limited = 0
      truncation%doubtful = .false.
      call find_tail(balance, u, frequency, tail)
      call find_remainder(balance, u, tail, truncation%remainder)
      if (balance%unknowns == 0 .or. size(balance%harmonic) == 0) return
      call find_shift(balance, tail, correction)
      y = 0
      call matrix%solve(correction, y)
      scale = sqrt(max(sum(u(2:, :)**2), tiny(1.0_dp)))
      way = -y/sign(max(abs(slope), steepest*unit), slope)
      error = correction + way*tangent
      truncation%limited = sqrt(sum(abs(tail)**2) + 2*sum(error(1, :)**2) + sum(error(2:, :)**2))/scale
      error = correction + way_back(y, slope, bend)*tangent
      truncation%estimate = sqrt(sum(abs(tail)**2) + 2*sum(error(1, :)**2) + sum(error(2:, :)**2))/scale
      truncation%error = error
      truncation%tail = tail
      truncation%doubtful = truncation%estimate > large .or. abs(2*bend*y) > near_fold*slope**2
      do i = 1, balance%unknowns
         if (balance%contact(i)%clearance() < sqrt(sum(abs(tail(:, i))**2) + 2*error(1, i)**2 + sum(error(2:, i)**2))) &
            truncation%doubtful = .true.
      end do
   end subroutine find_truncation

   !> The estimated error of unknown mesh i at theta [rad], with the sign of what is missing.
   pure real(dp) function waveform_error(self, balance, i, theta)
      class(truncation_type), intent(in) :: self
      type(balance_type), intent(in) :: balance
      integer, intent(in) :: i
      real(dp), intent(in) :: theta
      real(dp) :: slope, curvature
      integer :: m

      call evaluate(self%error(:, i), balance%harmonic, theta, waveform_error, slope, curvature)
      do m = 1, size(self%tail, 1)
         waveform_error = waveform_error + real(self%tail(m, i)*exp(cmplx(0, balance%missing(m)*theta, dp)), dp)
      end do
   end function waveform_error

   !> The nearer root s of y + slope s + bend s**2/2 = 0; where there is none, as far as if the fold had moved the other way.
   pure real(dp) function way_back(y, slope, bend)
      real(dp), intent(in) :: y, slope, bend
      real(dp) :: inside

      inside = slope**2 - 2*bend*y
      if (inside < 0) inside = slope**2 + abs(2*bend*y)
      way_back = -2*y/sign(max(abs(slope) + sqrt(inside), tiny(1.0_dp)), slope)
   end function way_back

   !> Fewest harmonics for which the error is to be `share` of what it is, by the decay of the harmonics; at most twice as many as
   !> there are, because more of the tail is not known.
   pure integer function harmonics_for(truncation, share) result(highest)
      type(truncation_type), intent(in) :: truncation
      real(dp), intent(in) :: share
      integer :: now

      now = ubound(truncation%remainder, 1)/3
      do highest = 1, 2*now - 1
         if (truncation%remainder(highest) <= share*truncation%remainder(now)) return
      end do
   end function harmonics_for

   !> Root of the sum of squares above each harmonic.
   pure subroutine find_remainder(balance, u, tail, remainder)
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: u(:, :)
      complex(dp), intent(in) :: tail(:, :)
      real(dp), allocatable, intent(inout) :: remainder(:)
      integer :: k, m

      if (allocated(remainder)) then
         if (ubound(remainder, 1) /= 3*balance%highest) deallocate (remainder)
      end if
      if (.not. allocated(remainder)) allocate (remainder(0:3*balance%highest))
      remainder = 0
      do k = 1, size(balance%harmonic)
         remainder(balance%harmonic(k) - 1) = sum(u(2*k:2*k + 1, :)**2)
      end do
      do m = 1, size(tail, 1)
         remainder(balance%missing(m) - 1) = sum(abs(tail(m, :))**2)
      end do
      do k = ubound(remainder, 1) - 1, 0, -1
         remainder(k) = remainder(k) + remainder(k + 1)
      end do
      remainder = sqrt(remainder)
   end subroutine find_remainder

   !> What the tail's force moves the kept harmonics by, before the balance answers.
   pure subroutine find_shift(balance, tail, correction)
      type(balance_type), intent(in) :: balance
      complex(dp), intent(in) :: tail(:, :)
      real(dp), intent(out) :: correction(:, :)
      real(dp) :: d_phi(balance%block, balance%unknowns)
      complex(dp) :: shift
      integer :: i, k, neighbour

      do i = 1, balance%unknowns
         d_phi(:, i) = tail_force(balance, i, tail(:, i))
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
   end subroutine find_shift

   !> Complex amplitudes at the missing harmonics, (missing, unknowns): each harmonic by itself under the force of the
   !> kept ones, the meshes coupled and with their mean stiffness in contact (a harmonic near a natural frequency resonates).
   pure subroutine find_tail(balance, u, frequency, tail)
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: u(:, :), frequency
      complex(dp), intent(out) :: tail(:, :)
      type(receptance_type) :: local
      complex(dp) :: force(balance%unknowns), stiffness(balance%unknowns), pivot(balance%unknowns), ratio
      integer :: i, m, r, neighbour

      tail = 0
      do m = 1, size(tail, 1)
         r = balance%missing(m)
         do i = 1, balance%unknowns
            force(i) = force_at(balance, i, u(:, i), r)
            stiffness(i) = cmplx(real(balance%contact(i)%stiffness(0), dp), balance%damping_of(i)*r*frequency/balance%eta, dp)
         end do
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
            force_at = force_at + two_sided(w, r - balance%harmonic(k))*cmplx(u(2*k), -u(2*k + 1), dp) &
                       + w(r + balance%harmonic(k))*cmplx(u(2*k), u(2*k + 1), dp)
         end do
      end associate
   end function force_at

   pure complex(dp) function two_sided(w, k)
      complex(dp), intent(in) :: w(0:)
      integer, intent(in) :: k

      two_sided = w(abs(k))
      if (k < 0) two_sided = conjg(two_sided)
   end function two_sided

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
            d_phi(1) = d_phi(1) + real(conjg(w(balance%missing(m)))*tail(m), dp)
         end do
         do k = 1, size(balance%harmonic)
            total = 0
            do m = 1, size(tail)
               r = balance%missing(m)
               total = total + conjg(two_sided(w, r - balance%harmonic(k)))*tail(m) + w(r + balance%harmonic(k))*conjg(tail(m))
            end do
            d_phi(2*k) = total%re
            d_phi(2*k + 1) = -total%im
         end do
      end associate
   end function tail_force

end module geartrain_motion_truncation
