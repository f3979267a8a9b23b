!> The length of a step along a branch, and whether it stayed on the branch.
module geartrain_continuation_step_length
   use geartrain_base_kinds, only: dp
   use geartrain_continuation_corrector, only: corrector_type, solution_point_type
   use geartrain_continuation_step_geometry, only: cosine, cosine_limit, loses_odd
   implicit none (type, external)
   private
   public :: acceptable, next_step, crosses_branch, jump_step, large

   !> Angle between tangents of neighbouring points aimed at [rad], and Newton's first correction over the step: as a rule; and on
   !> branches of longer periods, whose doublings lie closer together with each generation, and beyond the amplitude `large`.
   real(dp), parameter :: angle_aim(2) = [0.25_dp, 0.2_dp], correction_aim(2) = [0.08_dp, 0.05_dp]
   !> Newton's first correction over the step that is refused.
   real(dp), parameter :: correction_limit = 0.35_dp
   !> A change of orientation is a jump to another branch, unless it persists below this step: then branches cross here.
   real(dp), parameter :: jump_step = 1e-4_dp
   !> Amplitude, in the unit of the branch, above which the largest step grows in proportion to it.
   real(dp), parameter :: large = 5

contains

   !> Whether a step stayed on the branch: a small correction, a small turn, the same orientation, and not a jump onto the branch of
   !> half the period, which it crosses.
   logical function acceptable(corrector, here, next, h)
      !> As the step from `here` to `next` left it.
      type(corrector_type), intent(in) :: corrector
      type(solution_point_type), intent(in) :: here, next
      !> Length of the step, in the metric of the branch.
      real(dp), intent(in) :: h

      acceptable = corrector%correction < correction_limit .and. cosine(here, next, corrector%units) > cosine_limit
      acceptable = acceptable .and. .not. loses_odd(here, next, corrector%balance%eta, corrector%units)
      if (corrector%local_control) return
      acceptable = acceptable .and. (h < jump_step .or. .not. crosses_branch(here, next))
   end function acceptable

   !> Whether the bordered determinant changes sign between two solution points, as it does where another branch crosses this one.
   pure logical function crosses_branch(here, next)
      type(solution_point_type), intent(in) :: here, next

      crosses_branch = here%orientation*next%orientation < 0
   end function crosses_branch

   !> Length of the step to come: aims at a certain turn and a certain first Newton correction (which goes with the square of the
   !> step); at most `longest`.
   real(dp) function next_step(corrector, here, next, h, longest)
      !> As the step of length h from `here` to `next` left it.
      type(corrector_type), intent(in) :: corrector
      type(solution_point_type), intent(in) :: here, next
      real(dp), intent(in) :: h, longest
      real(dp) :: angle
      integer :: i

      i = merge(1, 2, corrector%balance%eta == 1 .and. corrector%length_of(next%u) < large)
      angle = acos(max(-1.0_dp, min(1.0_dp, cosine(here, next, corrector%units))))
      next_step = h*max(0.4_dp, min(1.8_dp, angle_aim(i)/max(angle, 1e-8_dp), &
                                    sqrt(correction_aim(i)/max(corrector%correction, 1e-8_dp))))
      next_step = min(next_step, longest)
   end function next_step

end module geartrain_continuation_step_length
