!> A step along a branch: its guess, its length, and whether it stayed on the branch.
module geartrain_trace_step_length
   use geartrain_base_kinds, only: dp
   use geartrain_trace_corrector, only: corrector_type, solution_point_type
   use geartrain_trace_step_geometry, only: arc_length, cosine, cosine_limit, go_along, loses_odd, way_to
   implicit none (type, external)
   private
   public :: acceptable, carries_same, closes, crosses_branch, curve_error, curve_limit, jump_step, large, next_step, predict

   !> Angle between tangents of neighbouring points aimed at [rad]: (1) as a rule; (2) on branches of longer periods, whose period
   !> doublings lie closer together with each generation, and above the amplitude `large`; (3) of balances that carry sets of
   !> harmonics, each point of which costs more: the path of their many harmonics bends, seldom back.
   real(dp), parameter :: angle_aim(3) = [0.8_dp, 0.4_dp, 0.6_dp]
   !> First Newton correction over the step aimed at [1], of guesses along the tangent and along the cubic, in the cases of
   !> `angle_aim`.
   real(dp), parameter :: correction_aim(3, 2) = reshape([0.08_dp, 0.05_dp, 0.2_dp, 0.15_dp, 0.05_dp, 0.15_dp], [3, 2])
   !> First Newton correction over the step from which on a step is refused [1].
   real(dp), parameter :: correction_limit = 0.35_dp
   !> Cosine of the angle between the tangent of a point and that of its guess from which on a step is refused [1].
   real(dp), parameter :: guess_limit = 0.85_dp
   !> Distance of the branch from the cubic through two neighbouring points, estimated, above which a step is refused; what a step
   !> aims at, over this limit [units_type].
   real(dp), parameter :: curve_tolerance = 1e-3_dp, curve_aim = 0.4_dp
   !> Largest length of a step over that of the step before for which the cubic is extrapolated [1].
   real(dp), parameter :: longest_extrapolation = 10
   !> Length of a step below which a change of orientation is no jump to another branch: there another branch crosses.
   real(dp), parameter :: jump_step = 1e-4_dp
   !> Length of the coefficients, in the metric of the branch, above which the largest step grows in proportion to it.
   real(dp), parameter :: large = 5

contains

   !> Guess of the next point: on the cubic through the latest two points, where they serve, else along the tangent.
   subroutine predict(corrector, before, here, h, guess, base)
      type(corrector_type), intent(in) :: corrector
      !> The point before the latest one; its coefficients are not allocated where there is none.
      type(solution_point_type), intent(in) :: before
      !> The latest point, with its tangent.
      type(solution_point_type), intent(in) :: here
      !> Distance of the guess from `here` along the tangent, in the metric of the branch [1].
      real(dp), intent(in) :: h
      !> The guess, with the tangent expected there.
      type(solution_point_type), intent(inout) :: guess
      !> Length of the cubic through the points before [1]; 0: the guess is on the tangent.
      real(dp), intent(out) :: base
      type(solution_point_type) :: first
      real(dp) :: length, short
      logical :: curved

      guess = here
      curved = allocated(before%u) .and. .not. corrector%local_control
      if (curved) then
         first = before
         if (.not. carries_same(first, here)) call corrector%refit(first)
         base = arc_length(first, here, corrector%units)
         curved = base > 0 .and. h < longest_extrapolation*base
      end if
      if (curved) then
         call go_along(first, here, 1 + h/base, corrector%units, guess)
         length = corrector%length_of(guess%tangent, guess%tangent_frequency)
         guess%tangent = guess%tangent/length
         guess%tangent_frequency = guess%tangent_frequency/length
         ! Beyond a turn by so much the cubic is no guess.
         curved = cosine(here, guess, corrector%units) > cosine_limit
      end if
      short = h
      if (curved) then
         short = h - way_to(here, guess, corrector%units)
      else
         base = 0
         guess = here
      end if
      guess%u = guess%u + short*here%tangent
      guess%frequency_ratio = guess%frequency_ratio + short*here%tangent_frequency
   end subroutine predict

   !> Whether two solution points carry the same harmonics.
   pure logical function carries_same(one, other)
      !> Solved points.
      type(solution_point_type), intent(in) :: one, other

      carries_same = size(one%harmonic) == size(other%harmonic)
      if (carries_same) carries_same = all(one%harmonic == other%harmonic)
   end function carries_same

   !> Whether a step stayed on the branch: a small correction, a small turn, no change of orientation and no jump onto the branch of
   !> half the period; and the cubic through its ends is near to the branch.
   logical function acceptable(corrector, here, next, h, guess, error)
      !> Corrector after the step from `here` to `next`.
      type(corrector_type), intent(in) :: corrector
      !> Solution points at the beginning and the end of the step.
      type(solution_point_type), intent(in) :: here, next
      !> Length of the step, in the metric of the branch [1].
      real(dp), intent(in) :: h
      !> The guess; distance of the branch from the cubic through the ends [1], see `curve_error`.
      type(solution_point_type), intent(in), optional :: guess
      real(dp), intent(in), optional :: error

      acceptable = corrector%correction < correction_limit .and. cosine(here, next, corrector%units) > cosine_limit
      acceptable = acceptable .and. .not. loses_odd(here, next, corrector%balance%waves(), corrector%units)
      if (corrector%local_control) return
      if (present(guess)) then
         acceptable = acceptable .and. cosine(guess, next, corrector%units) > guess_limit
      else
         acceptable = acceptable .and. cosine(here, next, corrector%units) > guess_limit
      end if
      if (present(error)) acceptable = acceptable .and. error < curve_limit(corrector, next)
      acceptable = acceptable .and. (h < jump_step .or. .not. crosses_branch(here, next))
   end function acceptable

   !> Whether the bordered determinant changes sign between two solution points, as it does where another branch crosses.
   pure logical function crosses_branch(here, next)
      !> Neighbouring solution points of a branch, with their orientations.
      type(solution_point_type), intent(in) :: here, next

      crosses_branch = here%orientation == -next%orientation .and. here%orientation /= 0
   end function crosses_branch

   !> Distance of the branch from the cubic through the ends of a step, in the metric of the branch [1]. It follows from the error
   !> of the guess on the cubic through the points before: both are the fourth derivative times a polynomial of the lengths.
   pure real(dp) function curve_error(corrector, h, base)
      !> Corrector after the step.
      type(corrector_type), intent(in) :: corrector
      !> Lengths of the step and of the cubic by which it was guessed, in the metric of the branch; 0: on the tangent [1].
      real(dp), intent(in) :: h, base

      curve_error = 0
      if (base > 0) curve_error = corrector%correction*h*(h/(4*(h + base)))**2
   end function curve_error

   !> Whether the next step closes the branch: `origin` lies ahead, within the step and near to the guess of a step to it.
   logical function closes(corrector, before, here, origin, met, h, gap)
      type(corrector_type), intent(in) :: corrector
      !> The point before the latest one, see `predict`; the latest point and the first point of the branch, with their tangents.
      type(solution_point_type), intent(in) :: before, here, origin
      !> Lambda of the points of the branch [1].
      real(dp), intent(in) :: met(:)
      !> Length of the next step, in the metric of the branch [1].
      real(dp), intent(in) :: h
      !> Distance from `here` to `origin` along the tangent at `here` [1].
      real(dp), intent(out) :: gap
      type(solution_point_type) :: guess
      real(dp) :: base, along(2)

      gap = way_to(here, origin, corrector%units)
      closes = gap > 0 .and. gap <= h .and. cosine(here, origin, corrector%units) > cosine_limit
      closes = closes .and. .not. crosses_branch(here, origin)
      if (.not. closes) return
      call predict(corrector, before, here, gap, guess, base)
      closes = corrector%length_of(origin%u - guess%u, origin%frequency_ratio - guess%frequency_ratio) < correction_limit*gap
      ! Of a train with soft shafts the whole range of Lambda may be short in the metric, and the motions at its ends alike.
      along = abs([origin%frequency_ratio, guess%frequency_ratio] - here%frequency_ratio)
      closes = closes .and. abs(origin%frequency_ratio - guess%frequency_ratio) &
               < correction_limit*max((maxval(met) - minval(met))/10, maxval(along))
   end function closes

   !> Length of the next step [1]: aims at `angle_aim`, `correction_aim` and `curve_aim`. The first Newton correction over the step
   !> grows with the cube of the step where the guess is on a cubic; the distance from the cubic with its fourth power.
   real(dp) function next_step(corrector, here, next, h, longest, error)
      !> Corrector after the step from `here` to `next`.
      type(corrector_type), intent(in) :: corrector
      !> Solution points at the beginning and the end of the latest step.
      type(solution_point_type), intent(in) :: here, next
      !> Length of the latest step and largest length of the next one, in the metric of the branch [1].
      real(dp), intent(in) :: h, longest
      !> Distance of the branch from the cubic through both points [1]; absent or 0: the guess was along the tangent.
      real(dp), intent(in), optional :: error
      real(dp) :: angle, factor
      integer :: i
      logical :: curved

      curved = present(error)
      if (curved) curved = error > 0
      i = merge(1, 2, corrector%balance%waves() == 1 .and. corrector%length_of(next%u) < large)
      if (i == 1 .and. corrector%balance%chosen) i = 3
      angle = acos(max(-1.0_dp, min(1.0_dp, cosine(here, next, corrector%units))))
      factor = angle_aim(i)/max(angle, 1e-8_dp)
      associate (correction => max(corrector%correction, 1e-8_dp))
         if (curved) then
            factor = min(factor, (correction_aim(i, 2)/correction)**(1/3.0_dp), &
                         (curve_aim*curve_limit(corrector, next)/error)**0.25_dp)
         else
            factor = min(factor, sqrt(correction_aim(i, 1)/correction))
         end if
      end associate
      next_step = min(h*max(0.4_dp, min(1.8_dp, factor)), longest)
   end function next_step

   !> Distance of the branch from the cubic through two points above which a step between them is refused [1]; it grows with the
   !> length of the coefficients above `large`.
   pure real(dp) function curve_limit(corrector, solution)
      type(corrector_type), intent(in) :: corrector
      !> A point of the step.
      type(solution_point_type), intent(in) :: solution

      curve_limit = curve_tolerance*max(1.0_dp, corrector%length_of(solution%u)/large)
   end function curve_limit

end module geartrain_trace_step_length
