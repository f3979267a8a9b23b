!> Coefficients of the normal forms of a period doubling and a Neimark-Sacker point: on which side the motions that leave there are,
!> and whether they are stable.
module geartrain_exact_normal_form
   use geartrain_base_kinds, only: dp
   use geartrain_exact_augmented_point, only: augmented_point_type
   use geartrain_exact_augmented_system, only: augmented_system_type
   use geartrain_floquet_critical_pair, only: pair_of
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
   implicit none (type, external)
   private
   public :: degenerate, doubling_coefficient, neimark_sacker_coefficient

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

   !> First Lyapunov coefficient of a Neimark-Sacker point, in units of displacement, at multipliers exp(+-i theta): negative where
   !> it is supercritical, so that the circles that leave there are stable: the real part of
   !> exp(-i theta) <p, C(q, q, q*) + 2 B(q, (I - M)^-1 B(q, q*)) + B(q*, (exp(2 i theta) I - M)^-1 B(q, q))>/2, Kuznetsov, Elements
   !> of Applied Bifurcation Theory, section 5.4. 0: M has no such pair, or 3 theta is a full turn, where it does not decide.
   real(dp) function neimark_sacker_coefficient(augmented, point) result(coefficient)
      !> The system, with the flight of the latest solution.
      type(augmented_system_type), intent(inout) :: augmented
      !> That solution.
      type(augmented_point_type), intent(in) :: point
      complex(dp), allocatable :: q(:), p(:), between(:), doubled(:), cubic(:)
      real(dp), allocatable :: sides(:, :, :), middle(:, :)
      complex(dp) :: pair(2), multiplier
      integer :: info, n

      coefficient = 0
      n = size(point%states, 1)
      pair = pair_of(point%multipliers, point%pair_sum)
      multiplier = merge(pair(1), pair(2), pair(1)%im > 0)
      if (.not. multiplier%im > 0) return
      associate (m => augmented%moving%monodromy)
         q = null_vector(m, multiplier)
         p = null_vector(transpose(m), conjg(multiplier))
         q = q*small*augmented%metric%units%length/maxval(abs(q(:augmented%system%displacements)))
         p = p/conjg(dot_product(p, q))
         ! Sides: displaced along the real part of q, then its imaginary part, and back; columns: what M makes of both parts.
         allocate (sides(n, 2, 4), middle(n, 2))
         call fly_all(reshape([q%re, q%im], [n, 2]), sides)
         middle(:, 1) = matmul(m, q%re)
         middle(:, 2) = matmul(m, q%im)
         associate (first => sides(:, :, 1) - sides(:, :, 3), second => sides(:, :, 2) - sides(:, :, 4), &
                    along => sides(:, :, 1) + sides(:, :, 3) - 2*middle, across => sides(:, :, 2) + sides(:, :, 4) - 2*middle)
            cubic = cmplx(along(:, 1) + across(:, 1), along(:, 2) + across(:, 2), dp)
            between = cmplx((first(:, 1) + second(:, 2))/2, 0, dp)
            doubled = cmplx((first(:, 1) - second(:, 2))/2, first(:, 2), dp)
         end associate
         ! Both are solutions of (M - z I) x = -B.
         call solve_shifted(m, (1.0_dp, 0.0_dp), between, info)
         if (info /= 0) return
         call solve_shifted(m, multiplier**2, doubled, info)
         if (info /= 0 .or. .not. maxval(abs(doubled)) < maxval(abs(q))) return
         between = -between
         doubled = -doubled
         deallocate (sides)
         allocate (sides(n, 3, 4))
         call fly_all(reshape([between%re, doubled%re, doubled%im], [n, 3]), sides)
         associate (first => (sides(:, :, 1) - sides(:, :, 3))/2, second => (sides(:, :, 2) - sides(:, :, 4))/2)
            cubic = cubic + 2*cmplx(first(:, 1), second(:, 1), dp) &
                    + cmplx(first(:, 2) + second(:, 3), first(:, 3) - second(:, 2), dp)
         end associate
         coefficient = real(conjg(multiplier)*dot_product(p, cubic), dp)/2/small**2
      end associate

   contains

      !> Carries vectors over the period of the orbits displaced along the real and the imaginary part of q, then against them.
      subroutine fly_all(vectors, final)
         real(dp), intent(in) :: vectors(:, :)
         real(dp), intent(out) :: final(:, :, :)
         real(dp) :: states(n, size(point%states, 2))
         integer :: k

         do k = 1, 4
            states(:, 1) = point%states(:, 1) + merge(1, -1, k <= 2)*merge(q%re, q%im, mod(k, 2) == 1)
            call augmented%probe%guess(point%frequency_ratio, states)
            final(:, :, k) = vectors
            call augmented%probe%carry_vectors(point%frequency_ratio, states, final(:, :, k))
         end do
      end subroutine fly_all

   end function neimark_sacker_coefficient

   !> Unit eigenvector of a simple eigenvalue, by inverse iteration next to it.
   function null_vector(matrix, value) result(vector)
      real(dp), intent(in) :: matrix(:, :)
      complex(dp), intent(in) :: value
      complex(dp) :: vector(size(matrix, 1))
      integer :: i, info

      ! Without any symmetry, so that it is not orthogonal to the eigenvector.
      vector = [(cmplx(modulo(i*0.6180339887498949_dp, 1.0_dp) - 0.5_dp, modulo(i*0.4142135623730951_dp, 1.0_dp) - 0.5_dp, dp), &
                 i=1, size(vector))]
      do i = 1, 3
         call solve_shifted(matrix, value*(1 + 1e-7_dp), vector, info)
         vector = vector/norm2(abs(vector))
      end do
   end function null_vector

   !> Solves (M - z I) x = b by a real matrix of twice as many rows.
   subroutine solve_shifted(m, z, x, info)
      real(dp), intent(in) :: m(:, :)
      complex(dp), intent(in) :: z
      !> The right-hand side, then the solution.
      complex(dp), intent(inout) :: x(:)
      integer, intent(out) :: info
      real(dp) :: matrix(2*size(x), 2*size(x)), right(2*size(x), 1)
      integer :: pivot(2*size(x)), k, n

      n = size(x)
      matrix = 0
      matrix(:n, :n) = m
      matrix(n + 1:, n + 1:) = m
      do k = 1, n
         matrix(k, k) = matrix(k, k) - z%re
         matrix(n + k, n + k) = matrix(n + k, n + k) - z%re
         matrix(k, n + k) = z%im
         matrix(n + k, k) = -z%im
      end do
      right(:, 1) = [x%re, x%im]
      call factor_matrix(2*n, matrix, pivot, info)
      if (info /= 0) return
      call solve_factored(2*n, 1, matrix, pivot, right)
      x = cmplx(right(:n, 1), right(n + 1:, 1), dp)
   end subroutine solve_shifted

end module geartrain_exact_normal_form
