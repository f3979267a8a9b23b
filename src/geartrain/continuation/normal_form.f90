!> Coefficient of the normal form of a period doubling: which side the doubled motions are on, and whether they are stable.
module geartrain_continuation_normal_form
   use geartrain_base_kinds, only: dp
   use geartrain_continuation_augmented_point, only: augmented_point_type
   use geartrain_continuation_augmented_system, only: augmented_system_type
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
   implicit none (type, external)
   private
   public :: doubling_coefficient, degenerate

   !> Displacement for second and third derivatives, in the unit of displacement: truncation and rounding both make about 1e-7.
   real(dp), parameter :: small = 1e-4_dp
   !> A coefficient below this, in units of displacement, counts as 0: the motion stays on linear pieces.
   real(dp), parameter :: degenerate = 1e-5_dp

contains

   !> Coefficient b of x -> -x + b x^3 along the null vector of M + I, in units of displacement: positive where the doubling is
   !> supercritical: b = w.(C(q, q, q) + 3 B(q, (I - M)^-1 B(q, q)))/6, Kuznetsov, Elements of Applied Bifurcation Theory, section
   !> 5.4.
   real(dp) function doubling_coefficient(augmented, point) result(coefficient)
      !> The system, with the flight of the latest solution.
      type(augmented_system_type), intent(inout) :: augmented
      !> That solution.
      type(augmented_point_type), intent(in) :: point
      real(dp), allocatable :: q(:), w(:), matrix(:, :), second(:, :), above(:, :), below(:, :), middle(:, :)
      real(dp) :: h
      integer, allocatable :: pivot(:)
      integer :: info, k, n

      n = size(point%states, 1)
      q = augmented%minus%row
      w = augmented%minus%column/dot_product(augmented%minus%column, q)
      h = small*augmented%metric%units%length/maxval(abs(q(:augmented%system%displacements)))
      q = h*q
      w = w/h
      ! All derivatives are along q, which has the length of the displacement.
      allocate (above(n, 1), below(n, 1), middle(n, 1), second(n, 1), pivot(n))
      call fly(1.0_dp, q, above)
      call fly(-1.0_dp, q, below)
      call fly(0.0_dp, q, middle)
      second = (above - below)/2
      coefficient = dot_product(w, above(:, 1) - 2*middle(:, 1) + below(:, 1))
      matrix = -augmented%moving%monodromy
      do k = 1, n
         matrix(k, k) = matrix(k, k) + 1
      end do
      call factor_matrix(n, matrix, pivot, info)
      if (info == 0) call solve_factored(n, 1, matrix, pivot, second)
      call fly(1.0_dp, second(:, 1), above)
      call fly(-1.0_dp, second(:, 1), below)
      coefficient = (coefficient + 3*dot_product(w, above(:, 1) - below(:, 1))/2)/6/small**2

   contains

      !> Carries a vector over the period of the orbit displaced along q.
      subroutine fly(way, vector, final)
         real(dp), intent(in) :: way, vector(:)
         real(dp), intent(out) :: final(:, :)
         real(dp) :: states(n, size(point%states, 2))

         ! The later sections begin where the flow is: a displacement to first order would miss part of the third derivative.
         states(:, 1) = point%states(:, 1) + way*q
         call augmented%probe%guess(point%frequency_ratio, states)
         final(:, 1) = vector
         call augmented%probe%carry_vectors(point%frequency_ratio, states, final)
      end subroutine fly

   end function doubling_coefficient

end module geartrain_continuation_normal_form
