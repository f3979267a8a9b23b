!> The directions in which orbits go on from an orbit: how the states at the beginnings of all sections change with Lambda, with a
!> parameter of the train and along the null vector of M - I, and how far from closed that leaves the orbit. Bordered by fixed
!> vectors, M - I is regular even where an orbit folds: one number for each direction remains of the closing equations.
module geartrain_exact_orbit_directions
   use geartrain_base_kinds, only: dp
   use geartrain_flow_sections, only: sections_type
   use geartrain_linalg_border, only: border_type
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
   implicit none (type, external)
   private
   public :: along_lambda, along_null, along_parameter, find_directions, rest

   !> Directions: what remains of the equations, Lambda, the parameter, the null vector of M - I.
   integer, parameter :: rest = 1, along_lambda = 2, along_parameter = 3, along_null = 4

contains

   !> Finds the directions at the orbit of the latest flight.
   subroutine find_directions(sections, border, with_parameter, step, h, info)
      !> After `fly`.
      type(sections_type), intent(in) :: sections
      !> Of M - I.
      type(border_type), intent(in) :: border
      !> Whether a parameter of the train is variable.
      logical, intent(in) :: with_parameter
      !> Changes of the states, (state, section, direction).
      real(dp), intent(out) :: step(:, :, :)
      !> What is left of the closing equations, (direction).
      real(dp), intent(out) :: h(4)
      !> 0: found; else the bordered matrix is singular.
      integer, intent(out) :: info
      real(dp) :: matrix(size(step, 1) + 1, size(step, 1) + 1), right(size(step, 1) + 1, 4)
      integer :: pivot(size(step, 1) + 1), d, k, n, last

      n = size(step, 1)
      last = sections%sections + 1
      call border%fill(sections%monodromy, -1.0_dp, matrix)
      right = 0
      right(:n, rest) = -sections%missed(:, last)
      right(:n, along_lambda) = -sections%drift(:, last)
      if (with_parameter) right(:n, along_parameter) = -sections%parameter_drift(:, last)
      right(n + 1, along_null) = 1
      call factor_matrix(n + 1, matrix, pivot, info)
      if (info /= 0) return
      call solve_factored(n + 1, 4, matrix, pivot, right)
      h = right(n + 1, :)
      do d = 1, 4
         do k = 1, sections%sections
            step(:, k, d) = sections%step_at(k, right(:n, d), merge(1.0_dp, 0.0_dp, d == along_lambda), &
                                             merge(1.0_dp, 0.0_dp, d == along_parameter))
            if (d == rest .and. k > 1) step(:, k, d) = step(:, k, d) + sections%missed(:, k)
         end do
      end do
   end subroutine find_directions

end module geartrain_exact_orbit_directions
