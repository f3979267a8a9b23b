!> Follows a branch beyond the amplitude limit, unrecorded, until it comes back.
!>
!> At infinite amplitude the gap no longer matters: the branch climbs along s phi, phi an eigenfunction of the linear train with
!> multiplier +1, and comes back along -s phi, as every resonance of a linear train without loss does. So it is followed with
!> steps in proportion to its amplitude until s is large, and its sign is changed there; Lambda follows from the balance.
module geartrain_branch_beyond
   use geartrain_base_kinds, only: dp
   use geartrain_branch_bend, only: odd_product
   use geartrain_branch_path, only: inner, place_type
   use geartrain_branch_step, only: acceptable, next_step
   use geartrain_branch_tracer, only: tracer_type
   use geartrain_motion_trigonometric, only: rms
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

   !> From `place`, where the branch left by the amplitude limit, to the last place before it is below it again (so that nothing
   !> below it is left out) or to where it leaves [low, high].
   subroutine pass_beyond(tracer, place, low, high, outcome)
      type(tracer_type), intent(inout) :: tracer
      type(place_type), intent(inout) :: place
      real(dp), intent(in) :: low, high
      integer, intent(out) :: outcome
      type(place_type) :: next
      real(dp) :: h, size
      integer :: steps
      logical :: success

      outcome = lost
      next = place
      h = tracer%settings%step
      do steps = 1, most_steps
         call tracer%path%advance(place, h, next, success)
         if (success) success = acceptable(tracer%path, place, next, h)
         ! The last step, to below the limit, is one as the branch has it.
         if (success) success = h <= tracer%settings%step .or. amplitude(tracer, next) > tracer%amplitude_limit
         if (.not. success) then
            h = h/3
            if (h < smallest_step) return
            cycle
         end if
         h = next_step(tracer%path, place, next, h, largest_step*tracer%path%length_of(next%u))
         size = amplitude(tracer, next)
         if (next%frequency < low .or. next%frequency > high) outcome = left_range
         if (outcome == lost .and. size <= tracer%amplitude_limit) then
            call tracer%path%correct(place, success)
            if (success) outcome = came_down
            return
         end if
         place = next
         if (outcome /= lost) return
         if (size < far*tracer%amplitude_limit .or. inner(place%tangent, place%u) < 0) cycle
         ! Shifted by half the period the odd harmonics change sign, and phi is either odd or even.
         if (mod(tracer%settings%subharmonic, 2) == 0 .and. 2*odd_product(place, place) > sum(place%u**2)) then
            outcome = mirrored
            return
         end if
         place%u = -place%u
         place%tangent = -place%u/tracer%path%length_of(place%u)
         place%tangent_frequency = 0
         call tracer%path%correct(place, success)
         if (.not. success) return
      end do
   end subroutine pass_beyond

   !> Largest rms of any mesh.
   real(dp) function amplitude(tracer, place)
      type(tracer_type), intent(inout) :: tracer
      type(place_type), intent(in) :: place
      real(dp) :: coefficients(1 + 2*tracer%path%balance%highest, tracer%system%meshes)
      integer :: j

      call tracer%path%balance%full_coefficients(place%u, place%frequency, coefficients)
      amplitude = 0
      do j = 1, tracer%system%meshes
         amplitude = max(amplitude, rms(coefficients(:, j)))
      end do
   end function amplitude

end module geartrain_branch_beyond
