!> Geometry of a step between neighbouring points of a branch: sense of Lambda, angle between tangents, hidden folds, return to the
!> beginning, and the odd harmonics of motions of even period.
module geartrain_continuation_step_geometry
   use geartrain_base_kinds, only: dp
   use geartrain_continuation_corrector, only: inner, solution_point_type
   use geartrain_model_units, only: units_type
   implicit none (type, external)
   private
   public :: cosine_limit, sense_of, hides_folds, odd_product, odd_share, loses_odd, passes_half_period, cosine, way_to, closes

   !> Cosine of the largest angle between tangents of neighbouring points.
   real(dp), parameter :: cosine_limit = 0.85_dp
   !> Lambda part of a unit tangent, in the unit of Lambda, below which its sign is rounding [1]: a branch of period 2 leaves
   !> vertically and is vertical until contact is lost.
   real(dp), parameter :: vertical = 1e-6_dp

contains

   !> Whether Lambda grows, +1, or falls, -1, along the branch at a solution point; 0 where the branch is vertical.
   pure integer function sense_of(solution, units)
      !> Solution point with its tangent.
      type(solution_point_type), intent(in) :: solution
      !> Units of the metric of the branch.
      type(units_type), intent(in) :: units

      sense_of = 0
      if (abs(solution%tangent_frequency) > vertical*units%frequency_ratio) sense_of = merge(1, -1, solution%tangent_frequency > 0)
   end function sense_of

   !> Whether Lambda turns twice between two points, going by the cubic through the points with their slopes.
   pure logical function hides_folds(here, next, units, h)
      !> Neighbouring solution points with their tangents.
      type(solution_point_type), intent(in) :: here, next
      !> Units of the metric of the branch.
      type(units_type), intent(in) :: units
      !> Distance of the points, in the metric of the branch [1].
      real(dp), intent(in) :: h
      real(dp) :: curvature, share, chord

      hides_folds = .false.
      chord = (next%frequency_ratio - here%frequency_ratio)/h
      associate (first => here%tangent_frequency, last => next%tangent_frequency)
         if (first*last <= 0 .or. max(abs(first), abs(last), abs(chord)) < vertical*units%frequency_ratio) return
         curvature = first + last - 2*chord
         if (abs(curvature) <= 0) return
         share = (2*first + last - 3*chord)/(3*curvature)
         if (share <= 0 .or. share >= 1) return
         hides_folds = first*(first - 3*curvature*share**2) < 0
      end associate
   end function hides_folds

   !> Inner product of the odd harmonics of two solution points, for motions of even period, whose balance carries all harmonics.
   pure real(dp) function odd_product(here, next)
      !> Solution points with equal numbers of harmonics.
      type(solution_point_type), intent(in) :: here, next
      integer :: k

      odd_product = 0
      do k = 1, (size(next%u, 1) - 1)/2, 2
         odd_product = odd_product + sum(here%u(2*k:2*k + 1, :)*next%u(2*k:2*k + 1, :))
      end do
   end function odd_product

   !> Share of the odd harmonics in the sum of squares of a motion's harmonics, or of a direction's [1].
   pure real(dp) function odd_share(u)
      !> Coefficients [1], (coefficient, mesh).
      real(dp), intent(in) :: u(:, :)
      integer :: k

      odd_share = 0
      do k = 1, (size(u, 1) - 1)/2, 2
         odd_share = odd_share + sum(u(2*k:2*k + 1, :)**2)
      end do
      if (odd_share > 0) odd_share = odd_share/sum(u**2)
   end function odd_share

   !> Whether the odd harmonics of a motion of even period vanish from one point to the next: a jump onto the branch of half the
   !> period.
   pure logical function loses_odd(here, next, waves, units)
      !> Solution points at the beginning and the end of a step.
      type(solution_point_type), intent(in) :: here, next
      !> Period of the motions in periods of the excitation.
      integer, intent(in) :: waves
      !> Units of the metric of the branch.
      type(units_type), intent(in) :: units
      !> Sum of squares of the odd harmonics that is rounding [1]: over the square of the unit of length, or over the sum at `here`.
      real(dp), parameter :: none = 1e-12_dp
      real(dp) :: before

      loses_odd = .false.
      if (mod(waves, 2) /= 0) return
      before = odd_product(here, here)
      loses_odd = before > none*units%length**2 .and. odd_product(next, next) < none*before
   end function loses_odd

   !> Whether the odd harmonics of a motion of even period change sign between two points: there the branch passes through a motion
   !> of half its period and goes on as its own mirror image, shifted by half a period.
   pure logical function passes_half_period(here, next, waves)
      !> Neighbouring solution points.
      type(solution_point_type), intent(in) :: here, next
      !> Period of the motions in periods of the excitation.
      integer, intent(in) :: waves
      !> Share of the motion below which odd harmonics are rounding [1]: a motion of half the period has none.
      real(dp), parameter :: none = 1e-7_dp

      passes_half_period = .false.
      if (mod(waves, 2) /= 0) return
      passes_half_period = odd_product(here, next) < 0 .and. odd_product(next, next) > none**2*sum(next%u**2)
   end function passes_half_period

   !> Cosine of the angle between the unit tangents of two solution points [1].
   pure real(dp) function cosine(here, next, units)
      !> Solution points with their tangents.
      type(solution_point_type), intent(in) :: here, next
      !> Units of the metric of the branch.
      type(units_type), intent(in) :: units

      cosine = inner(here%tangent, next%tangent)/units%length**2 &
               + here%tangent_frequency*next%tangent_frequency/units%frequency_ratio**2
   end function cosine

   !> Distance of `solution` from `here` along the tangent at `here`, in the metric of the branch [1]; negative behind `here`.
   pure real(dp) function way_to(here, solution, units)
      !> Solution point with its tangent, and another solution point.
      type(solution_point_type), intent(in) :: here, solution
      !> Units of the metric of the branch.
      type(units_type), intent(in) :: units

      way_to = inner(solution%u - here%u, here%tangent)/units%length**2 &
               + (solution%frequency_ratio - here%frequency_ratio)*here%tangent_frequency/units%frequency_ratio**2
   end function way_to

   !> Whether the next step closes the branch: `origin` lies ahead, within the step and close to the tangent.
   logical function closes(here, origin, h, units, gap)
      !> Latest point and first point of the branch, with their tangents.
      type(solution_point_type), intent(in) :: here, origin
      !> Length of the next step, in the metric of the branch [1].
      real(dp), intent(in) :: h
      !> Units of the metric of the branch.
      type(units_type), intent(in) :: units
      !> Distance from `here` to `origin` along the tangent at `here` [1].
      real(dp), intent(out) :: gap
      real(dp) :: du(size(here%u, 1), size(here%u, 2)), df

      du = (origin%u - here%u)/units%length
      df = (origin%frequency_ratio - here%frequency_ratio)/units%frequency_ratio
      gap = way_to(here, origin, units)
      closes = gap > 0 .and. gap <= h .and. inner(du, du) + df**2 < 1.1_dp*gap**2 &
               .and. cosine(here, origin, units) > cosine_limit
   end function closes

end module geartrain_continuation_step_geometry
