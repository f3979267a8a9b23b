!> The points of a branch as a list: reversed, shortened, compared, taken as motions.
module geartrain_trace_points
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_repetition, only: repetitions_in
   use geartrain_balance_same_motion, only: is_same_motion
   use geartrain_base_kinds, only: dp
   use geartrain_network_system, only: system_type
   use geartrain_trace_branch, only: arrange_points, branch_type, coefficients_of, has_sets, special_point_type
   implicit none (type, external)
   private
   public :: drop_first, is_same_point, motion_of, put_in_front, repeats_of

contains

   !> Point i as a motion: period, Lambda and coefficients.
   pure type(motion_type) function motion_of(branch, i) result(motion)
      type(branch_type), intent(in) :: branch
      !> Index of the point.
      integer, intent(in) :: i

      motion%period = branch%subharmonic
      motion%frequency_ratio = branch%frequency_ratio(i)
      motion%coefficients = coefficients_of(branch, i)
   end function motion_of

   !> How often the motions of a branch go through their waveform within the period.
   pure integer function repeats_of(branch, system)
      type(branch_type), intent(in) :: branch
      !> Dimensionless system of its train.
      type(system_type), intent(in) :: system

      repeats_of = 1
      if (branch%subharmonic > 1) return
      repeats_of = system%excitation_order
      if (branch%points > 0) repeats_of = repetitions_in(system, branch%orders, branch%coefficients(:, :, :branch%points))
   end function repeats_of

   !> Reverses the points after number `forward` and puts them before the others, so that the branch is one curve.
   subroutine put_in_front(branch, forward)
      !> A branch traced both ways from its first point.
      type(branch_type), intent(inout), target :: branch
      !> Number of points of the first way.
      integer, intent(in) :: forward
      integer :: order(branch%points), segment(branch%points), i, n, position(branch%points)
      integer, allocatable :: sequence(:)
      logical :: backward(size(branch%special_points))
      type(special_point_type), allocatable :: sorted(:)

      n = branch%points
      order = [(i, i=n, forward + 1, -1), (i, i=1, forward)]
      ! Reversed points are a length behind the first point.
      associate (behind => [(i, i=forward + 1, n)])
         branch%arclength(behind) = -branch%arclength(behind)
         branch%free_slope(behind) = -branch%free_slope(behind)
         branch%rms_slope(:, behind) = -branch%rms_slope(:, behind)
      end associate
      call take_points(branch, order)
      position(order) = [(i, i=1, n)]
      ! Segments are numbered anew. The two segments that meet at the first point become one segment.
      segment = branch%segment(:n)
      branch%segment(1) = 1
      do i = 2, n
         branch%segment(i) = branch%segment(i - 1) + merge(0, 1, segment(i) == segment(i - 1) .or. i == n - forward + 1)
      end do
      ! A special point between the first points of the two ways has point number `forward` before it in the list.
      backward = branch%special_points%point > forward .or. &
                 branch%special_points%point == forward .and. branch%special_points%kind /= 'fold'
      where (backward) branch%special_points%arclength = -branch%special_points%arclength
      do i = 1, size(branch%special_points)
         associate (special => branch%special_points(i))
            ! In the reversed order the next point becomes the point before a special point; a fold is a point of the branch itself.
            if (backward(i) .and. special%kind /= 'fold') special%point = special%point + 1
            special%point = position(special%point)
         end associate
      end do
      sequence = [(i, i=size(backward), 1, -1)]
      sequence = [pack(sequence, backward(sequence)), pack([(i, i=1, size(backward))], .not. backward)]
      allocate (sorted(size(backward)))
      ! In a loop: gfortran 12 frees the components twice in one array assignment.
      do i = 1, size(backward)
         sorted(i) = branch%special_points(sequence(i))
      end do
      call move_alloc(sorted, branch%special_points)
   end subroutine put_in_front

   !> Removes the first points of a branch, and their special points.
   subroutine drop_first(branch, points)
      !> A branch; the first of its segments gets number 1.
      type(branch_type), intent(inout), target :: branch
      !> Number of points to remove.
      integer, intent(in) :: points
      integer :: i

      call take_points(branch, [(i, i=points + 1, branch%points)])
      branch%segment(:branch%points) = branch%segment(:branch%points) - branch%segment(1) + 1
      branch%special_points = pack(branch%special_points, branch%special_points%point > points)
      branch%special_points%point = branch%special_points%point - points
   end subroutine drop_first

   !> Whether two points have bitwise equal Lambda and equal motions. Motions of different numbers of harmonics may differ by three
   !> times their error estimates.
   pure logical function is_same_point(branch, i, j)
      type(branch_type), intent(in) :: branch
      !> Indices of the two points.
      integer, intent(in) :: i, j
      real(dp) :: uncertainty

      is_same_point = .false.
      if (abs(branch%frequency_ratio(i) - branch%frequency_ratio(j)) > 0) return
      uncertainty = 0
      if (branch%point_harmonics(i) /= branch%point_harmonics(j) .or. has_sets(branch)) &
         uncertainty = 3*(branch%error_estimate(i) + branch%error_estimate(j))
      is_same_point = is_same_motion(branch%coefficients(:, :, i), branch%coefficients(:, :, j), uncertainty)
   end function is_same_point

   !> Keeps the points of the numbers `order`, in this order.
   subroutine take_points(branch, order)
      type(branch_type), intent(inout), target :: branch
      integer, intent(in) :: order(:)

      call arrange_points(branch, order, size(order))
      branch%points = size(order)
   end subroutine take_points

end module geartrain_trace_points
