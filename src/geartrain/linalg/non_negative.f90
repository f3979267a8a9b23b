!> Linear least squares with unknowns >= 0.
module geartrain_linalg_non_negative
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_lapack, only: dgels
   implicit none (type, external)
   private
   public :: non_negative_least_squares

   !> Slope of the sum of squares, over its scale, at which an unknown at 0 stays there [1].
   real(dp), parameter :: flat = 1e-12_dp

contains

   !> Finds the x >= 0 of least |a x - b| by active sets: Lawson and Hanson, Solving Least Squares Problems, chapter 23.
   pure subroutine non_negative_least_squares(a, b, x)
      !> Matrix of full column rank, (row, unknown); right-hand side, (row).
      real(dp), intent(in) :: a(:, :), b(:)
      !> The unknowns, (unknown).
      real(dp), intent(out) :: x(:)
      logical :: positive(size(x))
      real(dp) :: slope(size(x)), trial(size(x)), scale, step
      integer :: i, rounds

      x = 0
      positive = .false.
      scale = norm2(b)*maxval([norm2(a, 1), 0.0_dp])
      do rounds = 1, 3*size(x)
         slope = matmul(b - matmul(a, x), a)
         i = maxloc(slope, 1, .not. positive)
         if (i == 0) return
         if (.not. slope(i) > flat*scale) return
         positive(i) = .true.
         do
            trial = solution(a, b, positive)
            if (all(trial > 0 .or. .not. positive)) exit
            ! Towards the trial until the first unknown gets 0, which is then kept there.
            step = minval(x/(x - trial), positive .and. .not. trial > 0)
            x = x + step*(trial - x)
            positive = positive .and. x > epsilon(scale)*maxval(x)
            where (.not. positive) x = 0
            if (.not. any(positive)) return
         end do
         x = trial
      end do
   end subroutine non_negative_least_squares

   !> Least squares with the chosen unknowns, the others 0.
   pure function solution(a, b, chosen) result(x)
      real(dp), intent(in) :: a(:, :), b(:)
      logical, intent(in) :: chosen(:)
      real(dp) :: x(size(chosen))
      real(dp) :: matrix(size(a, 1), count(chosen)), right(max(size(a, 1), 1), 1), work(64*(size(a, 1) + count(chosen)) + 64)
      integer, allocatable :: columns(:)
      integer :: i, info

      columns = pack([(i, i=1, size(chosen))], chosen)
      matrix = a(:, columns)
      right(:, 1) = b
      call dgels('N', size(matrix, 1), size(matrix, 2), 1, matrix, size(matrix, 1), right, size(right, 1), work, size(work), info)
      x = 0
      x(columns) = right(:size(columns), 1)
   end function solution

end module geartrain_linalg_non_negative
