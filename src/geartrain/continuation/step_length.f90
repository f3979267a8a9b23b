!> The length of a step along a branch, and whether it stayed on the branch.
module geartrain_continuation_step_length
   use geartrain_base_kinds, only: dp
   use geartrain_continuation_corrector, only: corrector_type, solution_point_type
   use geartrain_continuation_step_geometry, only: cosine, cosine_limit, loses_odd
   implicit none (type, external)
   private
   public :: acceptable, next_step, crosses_branch, jump_step, large

   !> Angle between tangents of neighbouring points aimed at [rad], and first Newton correction over the step aimed at [1]: (1) as a
   !> rule; (2) on branches of longer periods, whose period doublings lie closer together with each generation, and above the
   !> amplitude `large`; (3) of balances that carry sets of harmonics, each point of which costs more: the path of their many
   !> harmonics bends, seldom back.
   real(dp), parameter :: angle_aim(3) = [0.25_dp, 0.2_dp, 0.4_dp], correction_aim(3) = [0.08_dp, 0.05_dp, 0.2_dp]
   !> First Newton correction over the step from which on a step is refused [1].
   real(dp), parameter :: correction_limit = 0.35_dp
   !> Length of a step below which a change of orientation is no jump to another branch: there another branch crosses.
   real(dp), parameter :: jump_step = 1e-4_dp
   !> Length of the coefficients, in the metric of the branch, above which the largest step grows in proportion to it.
   real(dp), parameter :: large = 5

contains

   !> Whether a step stayed on the branch: a small correction, a small turn, no change of orientation and no jump onto the branch of
   !> half the period.
   logical function acceptable(corrector, here, next, h)
      !> Corrector after the step from `here` to `next`.
      type(corrector_type), intent(in) :: corrector
      !> Solution points at the beginning and the end of the step.
      type(solution_point_type), intent(in) :: here, next
      !> Length of the step, in the metric of the branch [1].
      real(dp), intent(in) :: h

      acceptable = corrector%correction < correction_limit .and. cosine(here, next, corrector%units) > cosine_limit
      acceptable = acceptable .and. .not. loses_odd(here, next, corrector%balance%waves(), corrector%units)
      if (corrector%local_control) return
      acceptable = acceptable .and. (h < jump_step .or. .not. crosses_branch(here, next))
   end function acceptable

   !> Whether the bordered determinant changes sign between two solution points, as it does where another branch crosses.
   pure logical function crosses_branch(here, next)
      !> Neighbouring solution points of a branch, with their orientations.
      type(solution_point_type), intent(in) :: here, next

      crosses_branch = here%orientation == -next%orientation .and. here%orientation /= 0
   end function crosses_branch

   !> Length of the next step [1]: aims at `angle_aim` and `correction_aim`. The first Newton correction grows with the square of a
   !> step.
   real(dp) function next_step(corrector, here, next, h, longest)
      !> Corrector after the step from `here` to `next`.
      type(corrector_type), intent(in) :: corrector
      !> Solution points at the beginning and the end of the latest step.
      type(solution_point_type), intent(in) :: here, next
      !> Length of the latest step and largest length of the next one, in the metric of the branch [1].
      real(dp), intent(in) :: h, longest
      real(dp) :: angle
      integer :: i

      i = merge(1, 2, corrector%balance%waves() == 1 .and. corrector%length_of(next%u) < large)
      if (i == 1 .and. corrector%balance%chosen) i = 3
      angle = acos(max(-1.0_dp, min(1.0_dp, cosine(here, next, corrector%units))))
      next_step = h*max(0.4_dp, min(1.8_dp, angle_aim(i)/max(angle, 1e-8_dp), &
                                    sqrt(correction_aim(i)/max(corrector%correction, 1e-8_dp))))
      next_step = min(next_step, longest)
   end function next_step

end module geartrain_continuation_step_length
