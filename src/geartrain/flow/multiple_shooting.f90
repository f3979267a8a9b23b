!> Multiple shooting: Newton's method on the states at the beginnings of several sections of the period, at constant Lambda or along
!> the branch. For strongly unstable motions the gaps between sections are small, while a flight over the whole period ends far from
!> its beginning.
module geartrain_flow_multiple_shooting
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp
   use geartrain_flow_kept_states, only: keeps
   use geartrain_flow_sections, only: sections_type
   use geartrain_flow_start_state, only: states_of
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: find_orbit_in_sections, has_converged, max_iterations, most_parts, section_states

   !> Most Newton steps.
   integer, parameter :: max_iterations = 25
   !> Relative Newton step at which the orbit counts as found; rounding over a period leaves about 1e-13.
   real(dp), parameter :: converged = 1e-11_dp
   !> Relative gap at which the orbit counts as found although the Newton steps stay long: rounding leaves such gaps, which a weakly
   !> restrained motion, as between very large inertias, turns into long steps.
   real(dp), parameter :: closed = 1e-12_dp
   !> Largest relative change of Lambda by the correction of a step along the branch.
   real(dp), parameter :: farthest = 0.3_dp
   !> Most sections of a period of the fundamental; most elements of the matrices of all sections.
   integer, parameter :: usual_parts = 8
   real(dp), parameter :: largest = 2e7_dp

contains

   !> Whether Newton's method has found an orbit, as exactly as rounding allows.
   pure logical function has_converged(length, before, gap)
      !> Length of the last step, length of the step before, largest gap before the last step; all over the largest state [1].
      real(dp), intent(in) :: length, before, gap

      has_converged = length < converged .or. (length > 0.5_dp*before .and. (length < 100*converged .or. gap < closed))
   end function has_converged

   !> Number of sections of a period of the fundamental, which the memory for their matrices limits; even unless it is 1, so that a
   !> section begins after half the period.
   pure integer function most_parts(system, period)
      type(system_type), intent(in) :: system
      !> Period of the orbit [periods of the fundamental].
      integer, intent(in) :: period

      most_parts = max(1, 2*(min(usual_parts, int(largest/(real(system%states, dp)**2*period)))/2))
   end function most_parts

   !> States of a motion at the beginnings of the sections.
   subroutine section_states(system, motion, sections, states)
      type(system_type), intent(in) :: system
      !> The motion, with a state or with coefficients.
      type(motion_type), intent(in) :: motion
      !> Set up for the period of the motion.
      type(sections_type), intent(inout) :: sections
      !> States [1], (state, section).
      real(dp), allocatable, intent(out) :: states(:, :)

      allocate (states(system%states, sections%sections))
      if (allocated(motion%state)) then
         states(:, 1) = motion%state
         call sections%guess(motion%frequency_ratio, states)
      else
         call states_of(system, motion, states)
      end if
   end subroutine section_states

   !> Newton's method from a guess to an orbit, at constant Lambda without `row`; with `row`, states and Lambda change so that the
   !> product of the row with their change is 0.
   subroutine find_orbit_in_sections(sections, frequency_ratio, states, length, found, row, row_frequency, tangent, &
                                     tangent_frequency, weight, farthest_off)
      !> Set up for the period of the orbit.
      type(sections_type), intent(inout) :: sections
      !> Lambda [1] and states at the beginnings of the sections [1], (state, section): a guess, then the orbit.
      real(dp), intent(inout) :: frequency_ratio, states(:, :)
      !> Length of the last step, relative [1].
      real(dp), intent(out) :: length
      !> Whether Newton's method has converged.
      logical, intent(out) :: found
      !> Row of the states, (state, section), and of Lambda; both or none, with sections set up for variable Lambda.
      real(dp), intent(in), optional :: row(:, :), row_frequency
      !> With a row: tangent of the branch, states (state, section) and Lambda, whose product with the row is 1.
      real(dp), intent(out), optional :: tangent(:, :), tangent_frequency
      !> Metric of the states, (state, section), and distance from the guess in it beyond which Newton's method ends without an
      !> orbit; both or none.
      real(dp), intent(in), optional :: weight(:, :), farthest_off
      real(dp), allocatable :: guess(:, :)
      real(dp) :: first(size(states, 1) + 1, 2), step(size(states, 1), 1), begun, before, scale, gap
      real(dp), allocatable :: matrix(:, :)
      integer :: pivot(size(states, 1) + 1), i, k, n, m, info
      logical :: kept(size(states, 1))

      n = size(states, 1)
      m = n
      if (present(row)) m = n + 1
      allocate (matrix(m, m))
      found = .false.
      length = huge(1.0_dp)
      before = huge(1.0_dp)
      begun = frequency_ratio
      if (present(weight)) guess = states
      do i = 1, max_iterations
         call sections%fly(frequency_ratio, states)
         if (sections%interrupted() .or. sections%is_lost()) return
         matrix(:n, :n) = sections%monodromy
         ! What a period leaves as it is stays as it is.
         kept = keeps(sections%monodromy)
         do k = 1, n
            if (.not. kept(k)) matrix(k, k) = matrix(k, k) - 1
         end do
         first = 0
         first(:n, 1) = merge(0.0_dp, -sections%missed(:, sections%sections + 1), kept)
         if (present(row)) then
            matrix(:n, m) = merge(0.0_dp, sections%drift(:, sections%sections + 1), kept)
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
         scale = sections%size_of(states)
         gap = sections%size_of(sections%missed)/scale
         length = 0
         do k = 1, sections%sections
            step(:, 1) = sections%step_at(k, first(:n, 1), first(n + 1, 1))
            if (k > 1) step(:, 1) = step(:, 1) + sections%missed(:, k)
            length = max(length, sections%size_of(step)/scale)
            states(:, k) = states(:, k) + step(:, 1)
         end do
         length = max(length, abs(first(n + 1, 1))/frequency_ratio)
         if (.not. length < 10) return
         if (present(weight)) then
            if (sum(weight*(states - guess)**2) > farthest_off**2) return
         end if
         ! From a poor guess Newton's method may go anywhere, and a flight at Lambda near 0 would take very long.
         frequency_ratio = frequency_ratio + first(n + 1, 1)
         if (abs(frequency_ratio - begun) > farthest*begun .or. .not. sections%reaches(frequency_ratio)) return
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
