!> Shooting in several sections of the period, at constant Lambda or along the branch. What is missed between sections is small
!> where the motion is strongly unstable, and one flight over the period is far off.
module geartrain_flow_multiple_shooting
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp
   use geartrain_flow_sections, only: sections_type
   use geartrain_flow_start_state, only: states_of
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
   use geartrain_model_system, only: system_type
   implicit none (type, external)
   private
   public :: find_orbit_in_sections, has_converged, max_iterations, most_parts, section_states

   integer, parameter :: max_iterations = 25
   !> Relative Newton step at which the orbit counts as found; rounding over a period leaves about 1e-13.
   real(dp), parameter :: converged = 1e-11_dp
   !> What an orbit may lack to be closed, relative, where the Newton steps do not get shorter any more: of a motion that hardly
   !> anything holds, as of a train between very large inertias, rounding leaves that much and the step says what it makes of it.
   real(dp), parameter :: closed = 1e-12_dp
   !> Largest change of Lambda, relative, that a step along the branch may be corrected by.
   real(dp), parameter :: farthest = 0.3_dp
   !> Sections of a mesh period, and numbers that the matrices of all sections may have.
   integer, parameter :: usual_parts = 8
   real(dp), parameter :: largest = 2e7_dp

contains

   !> Whether Newton's method has found an orbit, or comes no nearer to it.
   pure logical function has_converged(length, before, gap)
      !> Of the last step and the one before; what the orbit lacked before it; all relative.
      real(dp), intent(in) :: length, before, gap

      has_converged = length < converged .or. (length > 0.5_dp*before .and. (length < 100*converged .or. gap < closed))
   end function has_converged

   !> Sections of a mesh period, fewer where their matrices would not fit.
   pure integer function most_parts(system, period)
      type(system_type), intent(in) :: system
      integer, intent(in) :: period

      most_parts = max(1, min(usual_parts, int(largest/(real(system%states, dp)**2*period))))
   end function most_parts

   !> A motion's states where the sections begin, (state, section).
   subroutine section_states(system, motion, sections, states)
      type(system_type), intent(in) :: system
      type(motion_type), intent(in) :: motion
      type(sections_type), intent(inout) :: sections
      real(dp), allocatable, intent(out) :: states(:, :)

      allocate (states(system%states, sections%sections))
      if (allocated(motion%state)) then
         states(:, 1) = motion%state
         call sections%guess(motion%frequency_ratio, states)
      else
         call states_of(system, motion, states)
      end if
   end subroutine section_states

   !> Newton on the flow over the period, from states nearby to those of an orbit. Lambda stays, unless a row is given: then states
   !> and Lambda move together, to where the row times their change is 0.
   subroutine find_orbit_in_sections(sections, frequency_ratio, states, length, found, row, row_frequency, tangent, &
                                     tangent_frequency)
      type(sections_type), intent(inout) :: sections
      !> Lambda and the states, (state, section): a guess, then the orbit's.
      real(dp), intent(inout) :: frequency_ratio, states(:, :)
      !> Largest change by the last step, relative.
      real(dp), intent(out) :: length
      logical, intent(out) :: found
      !> Both or none; with sections that were set up for a Lambda that moves.
      real(dp), intent(in), optional :: row(:, :), row_frequency
      !> Given a row: a motion along the branch, with which the row makes 1.
      real(dp), intent(out), optional :: tangent(:, :), tangent_frequency
      real(dp) :: first(size(states, 1) + 1, 2), step(size(states, 1)), begun, before, scale, gap
      real(dp), allocatable :: matrix(:, :)
      integer :: pivot(size(states, 1) + 1), i, k, n, m, info

      n = size(states, 1)
      m = n
      if (present(row)) m = n + 1
      allocate (matrix(m, m))
      found = .false.
      length = huge(1.0_dp)
      before = huge(1.0_dp)
      begun = frequency_ratio
      do i = 1, max_iterations
         call sections%fly(frequency_ratio, states)
         if (sections%interrupted()) return
         matrix(:n, :n) = sections%monodromy
         do k = 1, n
            matrix(k, k) = matrix(k, k) - 1
         end do
         first = 0
         first(:n, 1) = -sections%missed(:, sections%sections + 1)
         if (present(row)) then
            matrix(:n, m) = sections%drift(:, sections%sections + 1)
            matrix(m, :n) = row(:, 1)
            matrix(m, m) = row_frequency
            do k = 2, sections%sections
               matrix(m, :n) = matrix(m, :n) + matmul(row(:, k), sections%transfer(:, :, k))
               matrix(m, m) = matrix(m, m) + dot_product(row(:, k), sections%drift(:, k))
               first(m, 1) = first(m, 1) - dot_product(row(:, k), sections%missed(:, k))
            end do
            first(m, 2) = 1
         end if
         call factor_matrix(m, matrix, pivot, info)
         if (info /= 0) return
         call solve_factored(m, 1, matrix, pivot, first(:m, 1))
         scale = max(maxval(abs(states)), tiny(1.0_dp))
         gap = maxval(abs(sections%missed))/scale
         length = 0
         do k = 1, sections%sections
            step = sections%step_at(k, first(:n, 1), first(n + 1, 1))
            if (k > 1) step = step + sections%missed(:, k)
            length = max(length, maxval(abs(step))/scale)
            states(:, k) = states(:, k) + step
         end do
         length = max(length, abs(first(n + 1, 1))/frequency_ratio)
         if (.not. length < 10) return
         ! From far off Newton's method may go anywhere, and a flight at Lambda near 0 would have no end.
         frequency_ratio = frequency_ratio + first(n + 1, 1)
         if (abs(frequency_ratio - begun) > farthest*begun) return
         found = has_converged(length, before, gap)
         if (found) exit
         before = length
      end do
      if (.not. (found .and. present(tangent))) return
      call solve_factored(m, 1, matrix, pivot, first(:m, 2))
      tangent_frequency = first(m, 2)
      do k = 1, sections%sections
         tangent(:, k) = sections%step_at(k, first(:n, 2), first(m, 2))
      end do
   end subroutine find_orbit_in_sections

end module geartrain_flow_multiple_shooting
