!> Values where a branch loses stability: at a fold the branch has a point, elsewhere values are interpolated between two points.
module geartrain_readings_stability_edges
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_cubic, only: share_at
   use geartrain_readings_curve, only: arc_between, arc_type
   use geartrain_trace_branch, only: branch_type, special_point_type
   implicit none (type, external)
   private
   public :: edges_of, with_edges

contains

   !> Numbers of the special points between a motion that counts and one that does not.
   pure function edges_of(branch, counts) result(edges)
      type(branch_type), intent(in) :: branch
      !> Whether a motion counts, (point).
      logical, intent(in) :: counts(:)
      integer, allocatable :: edges(:)
      integer :: s

      edges = pack([(s, s=1, size(branch%special_points))], [(is_edge(branch%special_points(s)), s=1, size(branch%special_points))])

   contains

      pure logical function is_edge(special)
         type(special_point_type), intent(in) :: special

         is_edge = special%kind /= 'fold' .and. special%point > 0 .and. special%point < size(counts)
         if (is_edge) is_edge = counts(special%point) .neqv. counts(special%point + 1)
      end function is_edge

   end function edges_of

   !> Values at the points, then at special points: interpolated between the points on both sides, (value, place).
   pure function with_edges(branch, edges, values) result(all_of_them)
      type(branch_type), intent(in) :: branch
      !> Numbers of the special points.
      integer, intent(in) :: edges(:)
      !> Values at the points, (value, point).
      real(dp), intent(in) :: values(:, :)
      real(dp) :: all_of_them(size(values, 1), size(values, 2) + size(edges)), share
      type(arc_type) :: arc
      integer :: i

      all_of_them(:, :size(values, 2)) = values
      do i = 1, size(edges)
         associate (special => branch%special_points(edges(i)))
            arc = arc_between(branch, 1, special%point)
            share = share_at(arc%free, arc%free_slope, special%frequency_ratio)
            all_of_them(:, size(values, 2) + i) = (1 - share)*values(:, special%point) + share*values(:, special%point + 1)
         end associate
      end do
   end function with_edges

end module geartrain_readings_stability_edges
