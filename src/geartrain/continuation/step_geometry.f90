!> How a branch bends from one point to the next: the sense of Lambda, the angle between tangents, coming back to where it began.
module geartrain_continuation_step_geometry
   use geartrain_base_kinds, only: dp
   use geartrain_continuation_corrector, only: inner, solution_point_type
   use geartrain_continuation_units, only: units_type
   implicit none (type, external)
   private
   public :: cosine_limit, sense_of, hides_folds, odd_product, loses_odd, passes_half_period, cosine, way_to, closes

   !> Cosine of the largest angle between tangents of neighbouring points.
   real(dp), parameter :: cosine_limit = 0.85_dp
   !> Lambda's part of a tangent below which its sign is rounding: a branch of period 2 leaves vertically and stays so until
   !> contact is lost.
   real(dp), parameter :: vertical = 1e-6_dp

contains

   !> Whether Lambda grows, +1, or falls, -1, along the branch at a solution point; 0 where the branch is vertical.
   pure integer function sense_of(solution, units)
      type(solution_point_type), intent(in) :: solution
      type(units_type), intent(in) :: units

      sense_of = 0
      if (abs(solution%tangent_frequency) > vertical*units%frequency_ratio) sense_of = merge(1, -1, solution%tangent_frequency > 0)
   end function sense_of

   !> Whether Lambda seems to turn twice between two points: whether the cubic through them, with their slopes, does.
   pure logical function hides_folds(here, next, units, h)
      type(solution_point_type), intent(in) :: here, next
      type(units_type), intent(in) :: units
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

   !> Inner product of the odd harmonics of two solution points.
   pure real(dp) function odd_product(here, next)
      type(solution_point_type), intent(in) :: here, next
      integer :: k

      odd_product = 0
      do k = 1, (size(next%u, 1) - 1)/2, 2
         odd_product = odd_product + sum(here%u(2*k:2*k + 1, :)*next%u(2*k:2*k + 1, :))
      end do
   end function odd_product

   !> Whether the odd harmonics of a motion of even period vanish from one point to the next: a jump onto the branch of half the
   !> period, which goes through one of them.
   pure logical function loses_odd(here, next, subharmonic, units)
      type(solution_point_type), intent(in) :: here, next
      integer, intent(in) :: subharmonic
      type(units_type), intent(in) :: units
      !> Share of them that is left by rounding; what is less than that to begin with is none.
      real(dp), parameter :: none = 1e-12_dp
      real(dp) :: before

      loses_odd = .false.
      if (mod(subharmonic, 2) /= 0) return
      before = odd_product(here, here)
      loses_odd = before > none*units%length**2 .and. odd_product(next, next) < none*before
   end function loses_odd

   !> Whether the odd harmonics of a motion of even period change sign between two points: the branch passes through one of
   !> half its period there, and goes on as its own mirror image, shifted by half a period.
   pure logical function passes_half_period(here, next, subharmonic)
      type(solution_point_type), intent(in) :: here, next
      integer, intent(in) :: subharmonic
      !> Odd harmonics below this share of the motion are rounding: a motion of half the period has none.
      real(dp), parameter :: none = 1e-7_dp

      passes_half_period = .false.
      if (mod(subharmonic, 2) /= 0) return
      passes_half_period = odd_product(here, next) < 0 .and. odd_product(next, next) > none**2*sum(next%u**2)
   end function passes_half_period

   !> Of the angle between two tangents.
   pure real(dp) function cosine(here, next, units)
      type(solution_point_type), intent(in) :: here, next
      type(units_type), intent(in) :: units

      cosine = inner(here%tangent, next%tangent)/units%length**2 &
               + here%tangent_frequency*next%tangent_frequency/units%frequency_ratio**2
   end function cosine

   !> The way from `here` to a solution point, along the tangent at `here`.
   pure real(dp) function way_to(here, solution, units)
      type(solution_point_type), intent(in) :: here, solution
      type(units_type), intent(in) :: units

      way_to = inner(solution%u - here%u, here%tangent)/units%length**2 &
               + (solution%frequency_ratio - here%frequency_ratio)*here%tangent_frequency/units%frequency_ratio**2
   end function way_to

   !> Whether `origin` lies ahead, within the next step and close to the tangent; `gap` is the way there.
   logical function closes(here, origin, h, units, gap)
      type(solution_point_type), intent(in) :: here, origin
      real(dp), intent(in) :: h
      type(units_type), intent(in) :: units
      real(dp), intent(out) :: gap
      real(dp) :: du(size(here%u, 1), size(here%u, 2)), df

      du = (origin%u - here%u)/units%length
      df = (origin%frequency_ratio - here%frequency_ratio)/units%frequency_ratio
      gap = way_to(here, origin, units)
      closes = gap > 0 .and. gap <= h .and. inner(du, du) + df**2 < 1.1_dp*gap**2 &
               .and. cosine(here, origin, units) > cosine_limit
   end function closes

end module geartrain_continuation_step_geometry
