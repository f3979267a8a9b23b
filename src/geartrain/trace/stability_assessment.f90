!> Whether a point of a branch is stable, or whether its balance is too coarse to say.
!>
!> The multipliers are estimated twice: of the motion of the balance, and of the motion corrected by its estimated error, which
!> moves the contact events. The difference is the error of the first estimate, as a rule to a few percent: over the 17172 points of
!> the cases in namelists, at most half of the error is left. Where the error estimate is doubtful, so are both estimates.
module geartrain_trace_stability_assessment
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_error_estimate, only: error_estimate_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_floquet_growth, only: find_growth, growth_type, shifted_rate
   use geartrain_floquet_monodromy, only: monodromy_type
   use geartrain_floquet_motion_contacts, only: motion_contacts_type
   use geartrain_floquet_multipliers, only: is_neutral, is_stable, neutral
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: evaluate
   use geartrain_mesh_law_contact, only: contact_type
   implicit none (type, external)
   private
   public :: assess, assess_growth, assessment_type

   !> Bounds of the change of a multiplier per shift of the events (root of the sum of squares) [dimensionless time] and per largest
   !> multiplier: over the 17172 points no change that matters is larger than `sensitivity`, as a rule none is larger than `usual`.
   !> The multipliers are estimated a second time where the largest is nearer to the unit circle than `sensitivity` allows, or any
   !> other nearer than `usual` does: the others tell no more than where special points lie.
   real(dp), parameter :: sensitivity = 30, usual = 8
   !> Relative error of the waveform [1] above which the second estimate, which is of first order in the error, is worthless: with
   !> an error of 0.06 the largest multiplier of two hunting stages at R = 213 was 0.55 instead of 1.46.
   real(dp), parameter :: largest_error = 0.03_dp
   !> Distance of a multiplier from the unit circle, over its error, above which its side of the circle is decided [1].
   real(dp), parameter :: surely = 2

   !> Events above which the error of the waveform is interpolated between samples.
   integer, parameter :: many_events = 64

   type :: assessment_type
      !> All multipliers are inside the unit circle, by the first estimate.
      logical :: stable = .false.
      !> The largest multiplier may be on the other side of the circle, by its error; or the error estimate is doubtful, or no
      !> determinant confirms the multipliers.
      logical :: undecided = .false.
      !> Any multiplier may be on the other side: the number of multipliers outside is a guess.
      logical :: count_undecided = .false.
      !> Second estimate of the largest magnitude of a multiplier [1]; negative: not needed.
      real(dp) :: second = -1
      !> Real part of the largest Floquet exponent [1/dimensionless time].
      real(dp) :: growth_rate = 0
   end type assessment_type

contains

   !> Assesses the stability of a motion.
   subroutine assess(monodromy, balance, motion, u, frequency_ratio, estimate, multipliers, verdict, assessment)
      !> Monodromy matrix of the motion; afterwards, where a second estimate is needed, of the corrected motion.
      type(monodromy_type), intent(inout) :: monodromy
      !> Balance last evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> Contacts of the motion over its period.
      class(motion_contacts_type), intent(in) :: motion
      !> Coefficients of the unknown meshes [1], (block, unknown), and Lambda [1].
      real(dp), intent(in) :: u(:, :), frequency_ratio
      !> Error estimate of the motion.
      type(error_estimate_type), intent(in) :: estimate
      !> Multipliers by `monodromy` [1], the largest magnitude first; NaN: not found.
      complex(dp), intent(in) :: multipliers(:)
      !> Only the verdict is wanted: the multipliers may be rough where all are inside the unit circle.
      logical, intent(in) :: verdict
      !> The assessment.
      type(assessment_type), intent(out) :: assessment
      complex(dp) :: corrected(size(multipliers))
      real(dp) :: first(size(multipliers)), second(size(multipliers)), moved
      real(dp), allocatable :: shift(:, :)
      type(growth_type) :: growth
      logical :: unsure(size(multipliers)), more

      assessment%stable = is_stable(multipliers)
      associate (time => 2*pi*balance%eta/frequency_ratio/balance%repeats)
         assessment%growth_rate = log(max(abs(multipliers(1)), tiny(time)))/time
      end associate
      ! Multipliers that were not found are neutral too.
      assessment%undecided = is_neutral(multipliers) .or. estimate%doubtful .or. estimate%relative > largest_error .or. &
                          .not. monodromy%confirmed
      ! Of a large train only the leading ones are known: where all are outside, there may be more.
      more = monodromy%is_partial() .and. abs(multipliers(size(multipliers))) > 1
      assessment%count_undecided = assessment%undecided .or. more
      if (.not. (abs(multipliers(1)) <= huge(1.0_dp) .or. monodromy%is_partial())) then
         ! Over a long period they leave the range of numbers; the rate does not.
         call find_growth(monodromy, motion, frequency_ratio, growth)
         assessment%growth_rate = growth%rate
         return
      end if
      if (assessment%undecided .or. .not. any(motion%contact%events > 0)) return
      shift = shifts(balance, motion, u, estimate, 2*pi)
      first = abs(multipliers)
      moved = norm2(shift)/frequency_ratio*first(1)
      ! Multipliers that stay on the circle, as of a mode without damping, are never outside.
      unsure = abs(first - 1) < sensitivity*moved .and. abs(first - 1) > neutral
      if (.not. (unsure(1) .or. any(unsure .and. abs(first - 1) < usual*moved))) return
      call monodromy%integrate(motion, frequency_ratio, shift, verdict)
      call monodromy%multipliers(corrected)
      second = abs(corrected)
      assessment%second = second(1)
      ! Both estimates are sorted by magnitude.
      unsure = unsure .and. .not. surely*abs(second - first) < abs(first - 1) .or. .not. monodromy%confirmed
      assessment%undecided = unsure(1)
      assessment%count_undecided = any(unsure) .or. more
   end subroutine assess

   !> Assesses the stability of a motion of long period, by its growth rate over a part of it.
   subroutine assess_growth(monodromy, balance, motion, u, frequency_ratio, estimate, assessment)
      !> Work space, set up for the train.
      type(monodromy_type), intent(inout) :: monodromy
      !> Balance last evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> Contacts of the motion over its period.
      class(motion_contacts_type), intent(in) :: motion
      !> Coefficients of the unknown meshes [1], (block, unknown), and Lambda [1].
      real(dp), intent(in) :: u(:, :), frequency_ratio
      !> Error estimate of the motion.
      type(error_estimate_type), intent(in) :: estimate
      !> The assessment; without a second estimate.
      type(assessment_type), intent(out) :: assessment
      type(growth_type) :: growth
      real(dp), allocatable :: shift(:, :)
      real(dp) :: theta, moved, other
      logical :: doubtful

      doubtful = estimate%doubtful .or. estimate%relative > largest_error
      call find_growth(monodromy, motion, frequency_ratio, growth, roughly=doubtful)
      assessment%growth_rate = growth%rate
      assessment%stable = growth%rate < -growth%error
      assessment%undecided = .not. growth%sure .or. doubtful
      if (.not. assessment%undecided .and. any(motion%contact%events > 0)) then
         theta = growth%time*frequency_ratio/balance%eta
         shift = shifts(balance, motion, u, estimate, theta)
         moved = norm2(shift)/frequency_ratio
         if (abs(growth%rate)*growth%time < sensitivity*moved) then
            other = shifted_rate(monodromy, motion, frequency_ratio, growth, shift)
            assessment%undecided = .not. abs(growth%rate) > surely*(abs(other - growth%rate) + growth%error)
         end if
      end if
      assessment%count_undecided = assessment%undecided
   end subroutine assess_growth

   !> Shifts of the contact events up to an instant by the error of the waveform [rad], (event, unknown mesh).
   function shifts(balance, motion, u, estimate, last)
      type(balance_type), intent(in) :: balance
      class(motion_contacts_type), intent(in) :: motion
      real(dp), intent(in) :: u(:, :), last
      type(error_estimate_type), intent(in) :: estimate
      real(dp), allocatable :: shifts(:, :)
      type(transform_type) :: transform
      integer :: i

      allocate (shifts(maxval(motion%contact%events), balance%unknowns), source=0.0_dp)
      do i = 1, balance%unknowns
         call find_shift(balance, motion%contact(i), i, u(:, i), estimate, last, transform, shifts(:, i))
      end do
   end function shifts

   !> Shift of the contact events of unknown mesh i up to an instant by the error of the waveform [rad], (event): to the nearer root
   !> of the parabola of the corrected motion, or to its extreme where the corrected motion misses the wall.
   subroutine find_shift(balance, contact, i, u, estimate, last, transform, shift)
      type(balance_type), intent(in) :: balance
      type(contact_type), intent(in) :: contact
      integer, intent(in) :: i
      real(dp), intent(in) :: u(:), last
      type(error_estimate_type), intent(in) :: estimate
      type(transform_type), intent(inout) :: transform
      real(dp), intent(out) :: shift(:)
      real(dp) :: p, slope, curvature, inside, error, least, place
      integer :: k, n
      logical :: sampled

      shift = 0
      least = 0
      ! A hunting train has thousands of events, and of harmonics of the error.
      sampled = count(contact%instant(:contact%events) <= last) > many_events
      if (sampled) call estimate%sample_error(balance, i, transform)
      do k = 1, contact%events
         if (contact%instant(k) > last) exit
         call evaluate(u, balance%harmonic, contact%instant(k), p, slope, curvature)
         if (sampled) then
            place = contact%instant(k)/(2*pi)*transform%samples
            n = int(place)
            error = transform%sample(modulo(n, transform%samples) + 1)
            error = error + (place - n)*(transform%sample(modulo(n + 1, transform%samples) + 1) - error)
         else
            error = estimate%waveform_error(balance, i, contact%instant(k))
         end if
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
   end subroutine find_shift

end module geartrain_trace_stability_assessment
