!> The points of a branch as a list: turned round, shortened, compared.
module geartrain_continuation_points
   use geartrain_base_kinds, only: dp
   use geartrain_continuation_branch, only: arrange_points, branch_type, special_point_type
   implicit none (type, external)
   private
   public :: drop_first, is_same_point, put_in_front, same_motion

   !> Relative distance of the coefficients up to which two motions at one frequency, both solved for, are one.
   real(dp), parameter :: same_motion = 1e-6_dp

contains

   !> Reverses the points after `forward`, which lead the other way from the first one, and puts them before the others.
   subroutine put_in_front(branch, forward)
      type(branch_type), intent(inout), target :: branch
      integer, intent(in) :: forward
      integer :: order(branch%points), segment(branch%points), i, n, solution(branch%points)
      integer, allocatable :: sequence(:)
      logical :: backward(size(branch%special_points))
      type(special_point_type), allocatable :: sorted(:)

      n = branch%points
      order = [(i, i=n, forward + 1, -1), (i, i=1, forward)]
      call take_points(branch, order)
      solution(order) = [(i, i=1, n)]
      ! Parts are numbered anew; what meets at the first point is one part.
      segment = branch%segment(:n)
      branch%segment(1) = 1
      do i = 2, n
         branch%segment(i) = branch%segment(i - 1) + merge(0, 1, segment(i) == segment(i - 1) .or. i == n - forward + 1)
      end do
      ! The solution point between the first point and the first one of the other way has the point `forward` before it in the list.
      backward = branch%special_points%point > forward .or. &
                 branch%special_points%point == forward .and. branch%special_points%kind /= 'fold'
      do i = 1, size(branch%special_points)
         associate (special => branch%special_points(i))
            ! The order being reversed, the point after a solution point comes before it; a fold is a point itself.
            if (backward(i) .and. special%kind /= 'fold') special%point = special%point + 1
            special%point = solution(special%point)
         end associate
      end do
      sequence = [(i, i=size(backward), 1, -1)]
      sequence = [pack(sequence, backward(sequence)), pack([(i, i=1, size(backward))], .not. backward)]
      allocate (sorted(size(backward)))
      ! One by one: in one assignment gfortran 12 frees the components twice.
      do i = 1, size(backward)
         sorted(i) = branch%special_points(sequence(i))
      end do
      call move_alloc(sorted, branch%special_points)
   end subroutine put_in_front

   !> Takes the first points off, with what is special among them.
   subroutine drop_first(branch, points)
      type(branch_type), intent(inout), target :: branch
      integer, intent(in) :: points
      integer :: i

      call take_points(branch, [(i, i=points + 1, branch%points)])
      branch%segment(:branch%points) = branch%segment(:branch%points) - branch%segment(1) + 1
      branch%special_points = pack(branch%special_points, branch%special_points%point > points)
      branch%special_points%point = branch%special_points%point - points
   end subroutine drop_first

   !> Whether two points at one frequency are one motion.
   pure logical function is_same_point(branch, i, j)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: i, j

      real(dp) :: allowed

      is_same_point = .false.
      if (abs(branch%frequency_ratio(i) - branch%frequency_ratio(j)) > 0) return
      allowed = same_motion
      if (branch%point_harmonics(i) /= branch%point_harmonics(j)) &
         allowed = allowed + 3*(branch%error_estimate(i) + branch%error_estimate(j))
      is_same_point = maxval(abs(branch%coefficients(:, :, i) - branch%coefficients(:, :, j))) &
                      <= allowed*maxval(abs(branch%coefficients(:, :, i)))
   end function is_same_point

   !> Leaves the points of these numbers, in this order.
   subroutine take_points(branch, order)
      type(branch_type), intent(inout), target :: branch
      integer, intent(in) :: order(:)

      call arrange_points(branch, order, size(branch%frequency_ratio), branch%harmonics)
      branch%points = size(order)
   end subroutine take_points

end module geartrain_continuation_points
