!> Follows a branch beyond the amplitude limit, unrecorded, until it comes back.
!>
!> At infinite amplitude the gap no longer matters: the branch climbs along s phi, phi an eigenfunction of the linear train with
!> multiplier +1, and comes back along -s phi, as every resonance of a linear train without loss does. So it is followed with
!> steps in proportion to its amplitude until s is large, and its sign is changed there; Lambda follows from the balance.
module geartrain_continuation_large_amplitude
   use geartrain_base_kinds, only: dp
   use geartrain_continuation_corrector, only: inner, solution_point_type
   use geartrain_continuation_step_geometry, only: odd_product
   use geartrain_continuation_step_length, only: acceptable, next_step
   use geartrain_continuation_tracer, only: tracer_type
   use geartrain_linalg_trigonometric, only: rms
   implicit none (type, external)
   private
   public :: pass_beyond, came_down, left_range, mirrored, lost

   !> What became of the branch: below the limit again; out of the range of Lambda; it comes back as its own mirror image, shifted
   !> by half its period; not to be followed further.
   integer, parameter :: came_down = 1, left_range = 2, mirrored = 3, lost = 4

   !> Amplitude, as a multiple of the limit, at which the sign changes: what is neglected there is of the order of its inverse.
   real(dp), parameter :: far = 1e4_dp
   !> Largest step in proportion to the amplitude, the smallest one to go on with, and the most steps.
   real(dp), parameter :: largest_step = 0.2_dp, smallest_step = 1e-9_dp
   integer, parameter :: most_steps = 5000

contains

   !> From `solution`, where the branch left by the amplitude limit, to the last solution point before it is below it again (so that
   !> nothing below it is left out) or to where it leaves [low, high].
   subroutine pass_beyond(tracer, solution, low, high, outcome)
      type(tracer_type), intent(inout) :: tracer
      type(solution_point_type), intent(inout) :: solution
      real(dp), intent(in) :: low, high
      integer, intent(out) :: outcome
      type(solution_point_type) :: next
      real(dp) :: h, size
      integer :: steps
      logical :: success

      outcome = lost
      next = solution
      h = tracer%settings%step
      do steps = 1, most_steps
         call tracer%corrector%advance(solution, h, next, success)
         if (success) success = acceptable(tracer%corrector, solution, next, h)
         ! The last step, to below the limit, is one as the branch has it.
         if (success) success = h <= tracer%settings%step .or. amplitude(tracer, next) > tracer%amplitude_limit
         if (.not. success) then
            h = h/3
            if (h < smallest_step) return
            cycle
         end if
         h = next_step(tracer%corrector, solution, next, h, largest_step*tracer%corrector%length_of(next%u))
         size = amplitude(tracer, next)
         if (next%frequency_ratio < low .or. next%frequency_ratio > high) outcome = left_range
         if (outcome == lost .and. size <= tracer%amplitude_limit) then
            call tracer%corrector%correct(solution, success)
            if (success) outcome = came_down
            return
         end if
         solution = next
         if (outcome /= lost) return
         if (size < far*tracer%amplitude_limit .or. inner(solution%tangent, solution%u) < 0) cycle
         ! Shifted by half the period the odd harmonics change sign, and phi is either odd or even.
         if (mod(tracer%settings%subharmonic, 2) == 0 .and. 2*odd_product(solution, solution) > sum(solution%u**2)) then
            outcome = mirrored
            return
         end if
         solution%u = -solution%u
         solution%tangent = -solution%u/tracer%corrector%length_of(solution%u)
         solution%tangent_frequency = 0
         call tracer%corrector%correct(solution, success)
         if (.not. success) return
      end do
   end subroutine pass_beyond

   !> Largest rms of any mesh.
   real(dp) function amplitude(tracer, solution)
      type(tracer_type), intent(inout) :: tracer
      type(solution_point_type), intent(in) :: solution
      real(dp) :: coefficients(1 + 2*tracer%corrector%balance%highest, tracer%system%meshes)
      integer :: j

      call tracer%corrector%balance%full_coefficients(solution%u, solution%frequency_ratio, coefficients)
      amplitude = 0
      do j = 1, tracer%system%meshes
         amplitude = max(amplitude, rms(coefficients(:, j)))
      end do
   end function amplitude

end module geartrain_continuation_large_amplitude
