!> The two orbits beside a fold. Newton's method may land on either of them, by the last bits of its guess; the guess itself tells
!> on which side of the fold it is.
!>
!> Near an orbit x the flow over its period is P(x + y) - x - y = (M - 1) y + Q(y, y). Let v and w be the right and the left vector
!> of the multiplier 1 + d nearest to 1, w v = 1. Of a guess with c = w y the residual is r = d c + q c^2, and the other orbit is
!> at c = -d/q: so q, the curvature of the fold, need not be known. From there a secant in c leads to the other orbit: for a given
!> c the state and g with P(x + y) - x - y + g w = 0, w y = c, are found by Newton's method, whose matrix is regular; g/c is 0
!> there.
module geartrain_flow_across_fold
   use geartrain_base_kinds, only: dp
   use geartrain_floquet_multipliers, only: multipliers_of, side_of_fold
   use geartrain_flow_orbit, only: propagate
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: look_beyond_fold

   !> Distance of a multiplier from 1 up to which there may be a fold near an orbit, unless the side is told [1].
   real(dp), parameter :: near_one = 0.5_dp
   !> Error of the multiplier relative to its distance from 1 above which it is none of a single real vector [1].
   real(dp), parameter :: exact = 1e-3_dp
   !> Distance of a guess from its orbit, relative to the orbit, that is rounding [1].
   real(dp), parameter :: rounding = 1e-9_dp
   !> Error of the way to the other orbit from which on Newton's method finds it; growth of the way in one step [1].
   real(dp), parameter :: close = 1e-2_dp, most_growth = 10
   integer, parameter :: most_iterations = 30, most_secants = 6, most_steps = 6

contains

   !> Tells whether the orbit on the other side of a fold was meant: the one on the side that is asked for, else the one that is
   !> nearer to the guess.
   subroutine look_beyond_fold(system, frequency_ratio, period, guess, state, monodromy, other, beyond, side)
      type(system_type), intent(in) :: system
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Period of the orbit [periods of the fundamental].
      integer, intent(in) :: period
      !> State of the guess and of the orbit at phase 0 [1], (state); monodromy matrix of the orbit [1], (state, state).
      real(dp), intent(in) :: guess(:), state(:), monodromy(:, :)
      !> State near the other orbit [1], (state).
      real(dp), intent(out) :: other(:)
      !> The other orbit is meant.
      logical, intent(out) :: beyond
      !> The side as `side_of_fold` counts it. Absent or negative: the side of the guess.
      integer, intent(in), optional :: side
      real(dp) :: right(size(state)), left(size(state)), final(size(state)), d, c, share
      integer :: wanted
      logical :: single

      other = guess
      wanted = -1
      if (present(side)) wanted = side
      beyond = .false.
      if (wanted >= 0) beyond = side_of_fold(multipliers_of(monodromy)) /= wanted
      call find_vectors(monodromy, right, left, d, single)
      if (.not. single) return
      c = dot_product(left, guess - state)
      if (norm2(c*right) < rounding*norm2(state)) return
      if (wanted < 0 .and. abs(d) > near_one .or. wanted >= 0 .and. .not. beyond) return
      call propagate(system, frequency_ratio, period, guess, final)
      share = dot_product(left, final - guess)/(d*c)
      ! Halfway between the orbits c is half of -d/q, where this share is a half.
      if (wanted < 0) beyond = share < 0.5_dp
      if (beyond) call go_beyond(system, frequency_ratio, period, state, right, left, d, c/(1 - share), other)
   end subroutine look_beyond_fold

   !> Finds a state near the orbit on the other side of a fold.
   subroutine go_beyond(system, frequency_ratio, period, state, right, left, d, guess, other)
      type(system_type), intent(in) :: system
      real(dp), intent(in) :: frequency_ratio, state(:), right(:), left(:), d
      integer, intent(in) :: period
      !> Way to the other orbit in the direction of `right` [1].
      real(dp), intent(in) :: guess
      real(dp), intent(out) :: other(:)
      real(dp) :: c, slope, before, held, step
      integer :: i
      logical :: success

      c = guess
      other = state + c*right
      held = 0
      before = d
      do i = 1, most_secants
         call solve_at(slope, success)
         if (.not. success .or. abs(slope) < close*abs(d)) return
         step = -slope*(c - held)/(slope - before)
         held = c
         before = slope
         if (.not. abs(step) < most_growth*abs(c)) return
         c = c + step
         other = other + step*right
      end do

   contains

      !> Finds -g w w/c, which is d at the orbit that is known.
      subroutine solve_at(slope, success)
         real(dp), intent(out) :: slope
         logical, intent(out) :: success
         real(dp) :: matrix(size(state) + 1, size(state) + 1), x(size(state) + 1), final(size(state))
         integer :: pivot(size(state) + 1), row, k, n, info

         n = size(state)
         slope = 0
         do k = 1, most_steps
            call propagate(system, frequency_ratio, period, other, final, matrix(:n, :n))
            success = .not. system%interrupt%raised()
            if (.not. success) return
            do row = 1, n
               matrix(row, row) = matrix(row, row) - 1
            end do
            matrix(:n, n + 1) = left
            matrix(n + 1, :n) = left
            matrix(n + 1, n + 1) = 0
            x(:n) = other - final
            x(n + 1) = c - dot_product(left, other - state)
            call factor_matrix(n + 1, matrix, pivot, info)
            success = info == 0
            if (.not. success) return
            call solve_factored(n + 1, 1, matrix, pivot, x)
            other = other + x(:n)
            slope = -x(n + 1)*dot_product(left, left)/c
            if (norm2(x(:n)) < close*norm2(c*right)) return
         end do
         success = .false.
      end subroutine solve_at

   end subroutine go_beyond

   !> Finds the vectors of the multiplier nearest to 1 by inverse iteration.
   pure subroutine find_vectors(monodromy, right, left, d, single)
      real(dp), intent(in) :: monodromy(:, :)
      !> Vectors with product 1 [1], (state), and the distance of the multiplier from 1 [1].
      real(dp), intent(out) :: right(:), left(:), d
      !> The multiplier nearest to 1 is real and single.
      logical, intent(out) :: single
      real(dp), dimension(size(right), size(right)) :: matrix, factors, transposed
      integer, dimension(size(right)) :: pivot, pivot_transposed
      integer :: i, n, info

      n = size(right)
      matrix = monodromy
      do i = 1, n
         matrix(i, i) = matrix(i, i) - 1
      end do
      factors = matrix
      transposed = transpose(matrix)
      right = 1/sqrt(real(n, dp))
      left = right
      d = 0
      call factor_matrix(n, factors, pivot, info)
      if (info == 0) call factor_matrix(n, transposed, pivot_transposed, info)
      single = info == 0
      if (.not. single) return
      do i = 1, most_iterations
         call solve_factored(n, 1, factors, pivot, right)
         call solve_factored(n, 1, transposed, pivot_transposed, left)
         right = right/norm2(right)
         left = left/norm2(left)
         d = dot_product(right, matmul(matrix, right))
         single = norm2(matmul(matrix, right) - d*right) < exact*abs(d) &
                  .and. norm2(matmul(left, matrix) - d*left) < exact*abs(d)
         if (single) exit
      end do
      if (.not. single) return
      ! The product of the two is 0 only where multipliers coincide.
      single = abs(dot_product(left, right)) > exact
      if (single) left = left/dot_product(left, right)
   end subroutine find_vectors

end module geartrain_flow_across_fold
