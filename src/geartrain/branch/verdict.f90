!> Whether a point of a branch is stable, or whether its balance is too coarse to say.
!>
!> Two estimates of the largest multiplier: that of the motion as the balance has it, and that of the motion corrected by its
!> estimated error, which moves the contact events. What they differ by is the error of the first. Where the error estimate itself
!> is doubtful neither says anything of the motion that is meant.
module geartrain_branch_verdict
   use geartrain_base_kinds, only: dp, pi
   use geartrain_motion_balance, only: balance_type
   use geartrain_motion_trigonometric, only: evaluate
   use geartrain_motion_truncation, only: truncation_type
   use geartrain_stability_monodromy, only: monodromy_type
   use geartrain_stability_multipliers, only: is_neutral, is_stable
   implicit none (type, external)
   private
   public :: judge, verdict_type

   !> A largest multiplier as near as this to the unit circle is estimated a second time, or as near as this many times the error of
   !> the waveform.
   real(dp), parameter :: near = 0.1_dp, near_error = 10

   type :: verdict_type
      !> By the first estimate.
      logical :: stable = .false.
      !> The two estimates do not agree, or the first is as near to 1 as its error, or the error estimate is doubtful, or no
      !> determinant confirms the multipliers.
      logical :: undecided = .false.
      !> Second estimate of the largest magnitude of a multiplier; negative where none was needed.
      real(dp) :: second = -1
   end type verdict_type

contains

   !> The verdict on the motion at which `balance` was last evaluated, with the multipliers that `monodromy` gave for it.
   subroutine judge(monodromy, balance, u, frequency, truncation, multipliers, verdict)
      type(monodromy_type), intent(inout) :: monodromy
      type(balance_type), intent(in) :: balance
      !> Coefficients (block, unknowns) and Lambda.
      real(dp), intent(in) :: u(:, :), frequency
      type(truncation_type), intent(in) :: truncation
      complex(dp), intent(in) :: multipliers(:)
      type(verdict_type), intent(out) :: verdict
      complex(dp) :: corrected(size(multipliers))
      real(dp), allocatable :: shift(:, :)
      real(dp) :: margin
      integer :: i

      verdict%stable = is_stable(multipliers)
      margin = abs(multipliers(1)) - 1
      ! Also where the multipliers were not found, which are NaN then.
      verdict%undecided = is_neutral(multipliers)
      if (verdict%undecided) return
      verdict%undecided = truncation%doubtful .or. .not. monodromy%confirmed
      if (abs(margin) > max(near, near_error*truncation%estimate)) return
      if (.not. any(balance%contact%events > 0)) return
      allocate (shift(maxval(balance%contact%events), balance%unknowns))
      do i = 1, balance%unknowns
         call find_shift(balance, i, u(:, i), truncation, shift(:, i))
      end do
      call monodromy%integrate(balance, frequency, shift)
      call monodromy%multipliers(corrected)
      verdict%second = abs(corrected(1))
      verdict%undecided = verdict%undecided .or. .not. abs(verdict%second - abs(multipliers(1))) < abs(margin) &
                          .or. .not. monodromy%confirmed
   end subroutine judge

   !> What the error of the waveform moves the contact events of unknown mesh i by [rad]: the nearer root of the parabola through
   !> the wall; its extreme where the corrected motion does not reach the wall any more.
   subroutine find_shift(balance, i, u, truncation, shift)
      type(balance_type), intent(in) :: balance
      integer, intent(in) :: i
      real(dp), intent(in) :: u(:)
      type(truncation_type), intent(in) :: truncation
      real(dp), intent(out) :: shift(:)
      real(dp) :: p, slope, curvature, inside, error, least
      integer :: k

      shift = 0
      least = 0
      associate (contact => balance%contact(i))
         do k = 1, contact%events
            call evaluate(u, balance%harmonic, contact%instant(k), p, slope, curvature)
            error = truncation%waveform_error(balance, i, contact%instant(k))
            inside = slope**2 - 2*curvature*error
            if (inside > 0) then
               shift(k) = -2*error/(slope + sign(sqrt(inside), slope))
            else
               shift(k) = -slope/curvature
            end if
            ! The events of a mesh keep their order, and stay within the period.
            shift(k) = min(max(contact%instant(k) + shift(k), least), 2*pi) - contact%instant(k)
            least = contact%instant(k) + shift(k)
         end do
      end associate
   end subroutine find_shift

end module geartrain_branch_verdict
