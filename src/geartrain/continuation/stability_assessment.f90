!> Whether a point of a branch is stable, or whether its balance is too coarse to say.
!>
!> Two estimates of the multipliers: of the motion as the balance has it, and of the motion corrected by its estimated error,
!> which moves the contact events. What they differ by is the error of the first, as a rule to a few percent: over the 17172 points
!> of the cases in namelists, at most half of it is left. Where the error estimate itself is doubtful neither says anything of the
!> motion that is meant.
module geartrain_continuation_stability_assessment
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_error_estimate, only: error_estimate_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_floquet_monodromy, only: monodromy_type
   use geartrain_floquet_multipliers, only: is_neutral, is_stable, neutral
   use geartrain_linalg_trigonometric, only: evaluate
   implicit none (type, external)
   private
   public :: assess, assessment_type

   !> The multipliers are estimated a second time where the largest is as near to the unit circle as this many times what the events
   !> move by (root of the sum of squares) [dimensionless time], times itself: over the same points no change that matters is
   !> larger. Of the others, which tell no more than where special points lie, what such moves change as a rule is enough.
   real(dp), parameter :: sensitivity = 30, usual = 8
   !> Relative error of the waveform beyond which its first order, which the second estimate is, tells nothing of multipliers: with
   !> an error of 0.06 the largest one of two hunting stages at R = 213 was 0.55 for 1.46.
   real(dp), parameter :: largest_error = 0.03_dp
   !> A multiplier is decided to be on its side of the circle where it is farther from it than this many times its error.
   real(dp), parameter :: surely = 2

   type :: assessment_type
      !> By the first estimate.
      logical :: stable = .false.
      !> The largest multiplier may be on the other side of the circle, by its error; or the error estimate is doubtful, or no
      !> determinant confirms the multipliers.
      logical :: undecided = .false.
      !> Any of them may be: how many are outside is a guess.
      logical :: count_undecided = .false.
      !> Second estimate of the largest magnitude of a multiplier; negative where none was needed.
      real(dp) :: second = -1
   end type assessment_type

contains

   !> The verdict on the motion at which `balance` was last evaluated, with the multipliers that `monodromy` gave for it.
   subroutine assess(monodromy, balance, u, frequency_ratio, estimate, multipliers, assessment)
      type(monodromy_type), intent(inout) :: monodromy
      type(balance_type), intent(in) :: balance
      !> Coefficients (block, unknowns) and Lambda.
      real(dp), intent(in) :: u(:, :), frequency_ratio
      type(error_estimate_type), intent(in) :: estimate
      complex(dp), intent(in) :: multipliers(:)
      type(assessment_type), intent(out) :: assessment
      complex(dp) :: corrected(size(multipliers))
      real(dp) :: first(size(multipliers)), second(size(multipliers)), moved
      real(dp), allocatable :: shift(:, :)
      logical :: unsure(size(multipliers))
      integer :: i

      assessment%stable = is_stable(multipliers)
      ! Also where the multipliers were not found, which are NaN then.
      assessment%undecided = is_neutral(multipliers) .or. estimate%doubtful .or. estimate%relative > largest_error .or. &
                          .not. monodromy%confirmed
      assessment%count_undecided = assessment%undecided
      if (assessment%undecided .or. .not. any(balance%contact%events > 0)) return
      allocate (shift(maxval(balance%contact%events), balance%unknowns), source=0.0_dp)
      do i = 1, balance%unknowns
         call find_shift(balance, i, u(:, i), estimate, shift(:, i))
      end do
      first = abs(multipliers)
      moved = norm2(shift)/frequency_ratio*first(1)
      ! Those that stay on the circle, as of a mode without damping, are never outside.
      unsure = abs(first - 1) < sensitivity*moved .and. abs(first - 1) > neutral
      if (.not. (unsure(1) .or. any(unsure .and. abs(first - 1) < usual*moved))) return
      call monodromy%integrate(balance, frequency_ratio, shift)
      call monodromy%multipliers(corrected)
      second = abs(corrected)
      assessment%second = second(1)
      ! Both are sorted by magnitude.
      unsure = unsure .and. .not. surely*abs(second - first) < abs(first - 1) .or. .not. monodromy%confirmed
      assessment%undecided = unsure(1)
      assessment%count_undecided = any(unsure)
   end subroutine assess

   !> What the error of the waveform moves the contact events of unknown mesh i by [rad]: the nearer root of the parabola through
   !> the wall; its extreme where the corrected motion does not reach the wall any more.
   subroutine find_shift(balance, i, u, estimate, shift)
      type(balance_type), intent(in) :: balance
      integer, intent(in) :: i
      real(dp), intent(in) :: u(:)
      type(error_estimate_type), intent(in) :: estimate
      real(dp), intent(out) :: shift(:)
      real(dp) :: p, slope, curvature, inside, error, least
      integer :: k

      shift = 0
      least = 0
      associate (contact => balance%contact(i))
         do k = 1, contact%events
            call evaluate(u, balance%harmonic, contact%instant(k), p, slope, curvature)
            error = estimate%waveform_error(balance, i, contact%instant(k))
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

end module geartrain_continuation_stability_assessment
