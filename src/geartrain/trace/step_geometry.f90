!> Geometry of a step between neighbouring points of a branch: the cubic through both, sense of Lambda, angle between tangents,
!> hidden folds, and the odd harmonics of motions of even period.
module geartrain_trace_step_geometry
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_trigonometric, only: inner
   use geartrain_network_units, only: units_type
   use geartrain_trace_corrector, only: solution_point_type
   implicit none (type, external)
   private
   public :: arc_length, cosine_limit, go_along, sense_of, hides_folds, odd_product, odd_share, loses_odd, passes_half_period, &
      cosine, way_to

   !> Cosine of the largest angle between tangents of neighbouring points.
   real(dp), parameter :: cosine_limit = 0.5_dp
   !> Lambda part of a unit tangent, in the unit of Lambda, below which its sign is rounding [1]: a branch of period 2 leaves
   !> vertically and is vertical until contact is lost.
   real(dp), parameter :: vertical = 1e-5_dp

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

   !> Whether Lambda may turn twice between two points, going by the cubic through the points with their slopes.
   pure logical function hides_folds(here, next, units, uncertain)
      !> Neighbouring solution points with their tangents.
      type(solution_point_type), intent(in) :: here, next
      !> Units of the metric of the branch.
      type(units_type), intent(in) :: units
      !> Uncertainty of the slope of the cubic [1].
      real(dp), intent(in) :: uncertain
      real(dp) :: curvature, share, chord

      hides_folds = .false.
      chord = (next%frequency_ratio - here%frequency_ratio)/arc_length(here, next, units)
      associate (first => here%tangent_frequency, last => next%tangent_frequency)
         if (first*last <= 0 .or. max(abs(first), abs(last), abs(chord)) < vertical*units%frequency_ratio) return
         curvature = first + last - 2*chord
         if (abs(curvature) <= 0) return
         share = (2*first + last - 3*chord)/(3*curvature)
         if (share <= 0 .or. share >= 1) return
         hides_folds = sign(1.0_dp, first)*(first - 3*curvature*share**2) < uncertain
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

   !> Length of the branch between two neighbouring points: that of a circle through both with these tangents, but for the fourth
   !> power of the angle between them, by which the cubic through the points fits the circle best [1].
   pure real(dp) function arc_length(here, next, units)
      !> Neighbouring solution points with their tangents.
      type(solution_point_type), intent(in) :: here, next
      !> Units of the metric of the branch.
      type(units_type), intent(in) :: units
      real(dp) :: du(size(here%u, 1), size(here%u, 2)), df

      du = (next%u - here%u)/units%length
      df = (next%frequency_ratio - here%frequency_ratio)/units%frequency_ratio
      arc_length = 2*sqrt(inner(du, du) + df**2)/(1 + sqrt(max(0.0_dp, (1 + cosine(here, next, units))/2)))
   end function arc_length

   !> The point of the cubic through two solution points and their tangents, with its derivative as its tangent; also beyond its
   !> ends.
   pure subroutine go_along(here, next, share, units, solution)
      !> Ends of the cubic, with their tangents.
      type(solution_point_type), intent(in) :: here, next
      !> Distance from `here` along the cubic, as a share of the length between its ends [1].
      real(dp), intent(in) :: share
      !> Units of the metric of the branch.
      type(units_type), intent(in) :: units
      !> Point of the cubic: coefficients, Lambda and tangent.
      type(solution_point_type), intent(inout) :: solution
      real(dp) :: length, a(4), b(4)

      length = max(arc_length(here, next, units), tiny(1.0_dp))
      associate (t => share)
         a = [(1 + 2*t)*(1 - t)**2, t*(1 - t)**2*length, t**2*(3 - 2*t), t**2*(t - 1)*length]
         b = [6*t*(t - 1)/length, (1 - t)*(1 - 3*t), 6*t*(1 - t)/length, t*(3*t - 2)]
      end associate
      solution%u = a(1)*here%u + a(2)*here%tangent + a(3)*next%u + a(4)*next%tangent
      solution%frequency_ratio = a(1)*here%frequency_ratio + a(2)*here%tangent_frequency + a(3)*next%frequency_ratio + a(4)* &
           next%tangent_frequency
      solution%tangent = b(1)*here%u + b(2)*here%tangent + b(3)*next%u + b(4)*next%tangent
      solution%tangent_frequency = b(1)*here%frequency_ratio + b(2)*here%tangent_frequency + b(3)*next%frequency_ratio &
                                + b(4)*next%tangent_frequency
   end subroutine go_along

end module geartrain_trace_step_geometry
