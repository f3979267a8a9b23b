!> Special points that the balance alone locates between two neighbouring points of a branch: folds, and where a branch meets the
!> branch of half its period.
module geartrain_trace_special_points
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_bracket, only: between, shrink
   use geartrain_linalg_cubic, only: highest_share
   use geartrain_linalg_trigonometric, only: rms
   use geartrain_trace_branch, only: branch_type, special_point_type
   use geartrain_trace_corrector, only: corrector_type, solution_point_type
   use geartrain_trace_step_geometry, only: arc_length, go_along, odd_product, way_to
   implicit none (type, external)
   private
   public :: locate_fold, locate_half_period, add_special_point, is_known_fold
   public :: generic_vector, rms_of

   integer, parameter :: max_steps = 30
   !> Relative distances of two folds, in Lambda and of their motions, up to which they are the same [1].
   real(dp), parameter :: same_place = 1e-8_dp, same_motion = 1e-5_dp

contains

   !> Locates the fold within a step, to 1e-6 of the step.
   subroutine locate_fold(corrector, here, next, h, fold, s, success)
      !> Corrector of the branch; it worked on `fold` last.
      type(corrector_type), intent(inout) :: corrector
      !> Beginning and end of the step, with tangents of opposite Lambda parts.
      type(solution_point_type), intent(in) :: here, next
      !> Length of the step, in the metric of the branch [1].
      real(dp), intent(in) :: h
      !> Solution point at which Lambda turns.
      type(solution_point_type), intent(inout) :: fold
      !> Distance of `fold` from `here` [1].
      real(dp), intent(out) :: s
      !> False where Newton's method fails.
      logical, intent(out) :: success
      type(solution_point_type) :: guess, cubic
      real(dp) :: a, b, fa, fb, length, before
      integer :: i, kept

      before = 0
      kept = 0
      a = 0
      b = h
      fa = here%tangent_frequency
      fb = next%tangent_frequency
      length = sign(arc_length(here, next, corrector%units), fa)
      guess = next
      cubic = next
      do i = 1, max_steps
         s = between(a, b, fa, fb)
         if (i == 1) s = h*min(0.999_dp, max(0.001_dp, highest_share([0.0_dp, sign(1.0_dp, fa)*(next%frequency_ratio &
                                                                     - here%frequency_ratio)], length*[fa, fb])))
         call go_along(here, next, s/h, corrector%units, guess)
         if (i > 1) then
            ! Next to the point before, the branch is as far from the cubic as there.
            call go_along(here, next, before/h, corrector%units, cubic)
            guess%u = guess%u + (fold%u - cubic%u)
            guess%frequency_ratio = guess%frequency_ratio + (fold%frequency_ratio - cubic%frequency_ratio)
         end if
         associate (short => s - way_to(here, guess, corrector%units))
            guess%u = guess%u + short*here%tangent
            guess%frequency_ratio = guess%frequency_ratio + short*here%tangent_frequency
         end associate
         call corrector%advance(here, s, fold, success, guess)
         if (.not. success) return
         before = s
         if (abs(fold%tangent_frequency) < 1e-7_dp*corrector%units%frequency_ratio) return
         call shrink(a, b, fa, fb, s, fold%tangent_frequency, kept)
         if (b - a < 1e-6_dp*h) return
      end do
   end subroutine locate_fold

   !> Whether the latest point of a branch, a fold, is an earlier fold of its segment.
   pure logical function is_known_fold(branch) result(known)
      !> The branch; its latest special point is that fold.
      type(branch_type), intent(in) :: branch
      integer :: s

      known = .false.
      associate (n => branch%points, special => branch%special_points, x => branch%frequency_ratio, u => branch%coefficients)
         do s = 1, size(special) - 1
            associate (i => special(s)%point)
               if (special(s)%kind /= 'fold') cycle
               if (branch%segment(i) /= branch%segment(n) .or. abs(x(i) - x(n)) > same_place*abs(x(n))) cycle
               known = known .or. norm2(u(:, :, i) - u(:, :, n)) <= same_motion*norm2(u(:, :, n))
            end associate
         end do
      end associate
   end function is_known_fold

   !> Locates where the odd harmonics vanish within a step: there a branch of even period meets the branch of half its period. The
   !> matrix is singular there and Newton's method fails next to it: from there on the branch is taken as a straight line.
   subroutine locate_half_period(corrector, here, next, h, solution)
      !> Corrector of the branch of even period.
      type(corrector_type), intent(inout) :: corrector
      !> Beginning, with its tangent, and end of the step; the inner product of their odd harmonics is negative.
      type(solution_point_type), intent(in) :: here, next
      !> Length of the step, in the metric of the branch [1].
      real(dp), intent(in) :: h
      !> Coefficients and Lambda where the odd harmonics vanish.
      type(solution_point_type), intent(inout) :: solution
      type(solution_point_type) :: first, last
      real(dp) :: a, b, fa, fb, f, s, share
      integer :: i, kept
      logical :: success

      kept = 0
      a = 0
      b = h
      fa = odd_product(here, here)
      fb = odd_product(here, next)
      first = here
      last = next
      do i = 1, max_steps
         s = between(a, b, fa, fb)
         call corrector%advance(here, s, solution, success)
         if (.not. success) exit
         f = odd_product(here, solution)
         if (f > 0) then
            first = solution
         else
            last = solution
         end if
         call shrink(a, b, fa, fb, s, f, kept)
         if (b - a < 1e-6_dp*h) exit
      end do
      share = odd_product(here, first)/(odd_product(here, first) - odd_product(here, last))
      solution = first
      solution%u = first%u + share*(last%u - first%u)
      solution%frequency_ratio = first%frequency_ratio + share*(last%frequency_ratio - first%frequency_ratio)
   end subroutine locate_half_period

   !> A vector without any symmetry, so that it is orthogonal to no motion of a symmetric train.
   pure subroutine generic_vector(number, x, y)
      !> Different numbers give different vectors.
      integer, intent(in) :: number
      !> Coefficients, (block, unknown), and Lambda part.
      real(dp), intent(out) :: x(:, :), y
      real(dp), parameter :: golden = 0.6180339887498949_dp, silver = 0.4142135623730951_dp
      integer :: i, l

      do i = 1, size(x, 2)
         do l = 1, size(x, 1)
            ! Fractions of multiples of irrational numbers spread evenly. Low harmonics, most of a motion, weigh more.
            x(l, i) = (modulo((l + size(x, 1)*i)*golden + number*i*silver, 1.0_dp) - 0.5_dp)/(1 + l/2)
         end do
      end do
      y = 0.3_dp
   end subroutine generic_vector

   !> The rms of a solution point on which the corrector worked last [1], (mesh).
   function rms_of(corrector, solution)
      type(corrector_type), intent(inout) :: corrector
      !> The solution point.
      type(solution_point_type), intent(in) :: solution
      real(dp) :: rms_of(corrector%balance%system%meshes)
      real(dp) :: coefficients(corrector%balance%block, corrector%balance%system%meshes)
      integer :: j

      call corrector%balance%full_coefficients(solution%u, coefficients)
      do j = 1, size(rms_of)
         rms_of(j) = rms(coefficients(:, j))
      end do
   end function rms_of

   !> Lists a special point of a branch, in the order along the branch.
   subroutine add_special_point(branch, kind, frequency_ratio, point, rms, multiplicity, arclength)
      !> Branch whose `special_points` grow.
      type(branch_type), intent(inout) :: branch
      !> Kind as in special_point_type.
      character(*), intent(in) :: kind
      !> Lambda [1], and rms over characteristic length [1], (mesh).
      real(dp), intent(in) :: frequency_ratio, rms(:)
      !> Number of the point of the branch before the special point; of a fold, which is a point, its own number.
      integer, intent(in) :: point
      !> Number of multipliers, or of pairs, that pass the unit circle together; 1 unless it is given.
      integer, intent(in), optional :: multiplicity
      !> Length of the branch up to it [1]; not known unless it is given.
      real(dp), intent(in), optional :: arclength
      type(special_point_type) :: special
      integer :: n

      special%kind = kind
      special%frequency_ratio = frequency_ratio
      special%point = point
      special%rms = rms
      if (present(multiplicity)) special%multiplicity = multiplicity
      if (present(arclength)) special%arclength = arclength
      n = count(branch%special_points%point <= point)
      branch%special_points = [branch%special_points(:n), special, branch%special_points(n + 1:)]
   end subroutine add_special_point

end module geartrain_trace_special_points
