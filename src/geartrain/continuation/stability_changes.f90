!> Locates changes of stability between two neighbouring points of a branch, by counting the multipliers outside the unit circle:
!> real ones below -1, real ones above +1 and complex pairs.
!>
!> A count by kind tells what a sum cannot: two doublings in one step, a doubling where a pair enters, and a pair that becomes real
!> outside the circle, which is no change at all. Multipliers that stay on the circle to rounding, as of a mode without damping,
!> are never outside. Real ones pass +1 at folds and where branches cross, which the balance tells more exactly than its monodromy.
module geartrain_continuation_stability_changes
   use geartrain_base_kinds, only: dp
   use geartrain_continuation_branch, only: branch_type
   use geartrain_continuation_corrector, only: corrector_type, solution_point_type
   use geartrain_continuation_special_points, only: add_special_point, go_along
   use geartrain_floquet_monodromy, only: monodromy_type
   use geartrain_floquet_multipliers, only: are_numbers, neutral
   use geartrain_linalg_bracket, only: between, shrink
   implicit none (type, external)
   private
   public :: add_stability_changes

   !> Kinds of multipliers outside the circle: real below -1, complex pairs, real above +1.
   integer, parameter :: doubling = 1, neimark_sacker = 2, beyond_one = 3
   character(*), parameter :: names(*) = [character(15) :: 'period doubling', 'neimark-sacker']
   !> Beside a multiplier larger than this those near the unit circle are rounding: over a period of many teeth an unstable motion
   !> has such ones. Nothing is said of changes there.
   real(dp), parameter :: drowning = 1e11_dp
   !> A complex pair as near as this to the real axis is two real multipliers: of equal stages that hardly know of one another.
   real(dp), parameter :: real_enough = 1e-6_dp
   !> Changes as near together as this share of the step are simultaneous. How far outside a multiplier is where a chord through the
   !> latest two steps is exact enough.
   real(dp), parameter :: together = 1e-6_dp, nearly = 1e-5_dp
   integer, parameter :: most_steps = 60

   !> A piece of a branch, along which solution points are told by the way from its beginning.
   type :: piece_type
      type(solution_point_type) :: here, next
      real(dp) :: length = 0
   end type piece_type

contains

   !> Puts the changes of stability between point `before` of the branch and point `after`, the next one traced, on the list.
   subroutine add_stability_changes(corrector, monodromy, here, next, length, before, after, branch)
      type(corrector_type), intent(inout) :: corrector
      type(monodromy_type), intent(inout) :: monodromy
      !> The two points, with their tangents, and how far they are apart.
      type(solution_point_type), intent(in) :: here, next
      real(dp), intent(in) :: length
      integer, intent(in) :: before, after
      type(branch_type), intent(inout), target :: branch
      type(piece_type) :: piece
      complex(dp) :: first(branch%states), last(branch%states)

      first = branch%multipliers(:, before)
      last = branch%multipliers(:, after)
      if (.not. (are_numbers(first) .and. are_numbers(last))) return
      if (max(maxval(abs(first)), maxval(abs(last))) > drowning) return
      if (all(outside(first) == outside(last))) return
      piece = piece_type(here, next, length)
      call separate(corrector, monodromy, piece, 0.0_dp, length, first, last, after, branch)
   end subroutine add_stability_changes

   !> Number of multipliers outside the unit circle, of each kind.
   pure function outside(multipliers)
      complex(dp), intent(in) :: multipliers(:)
      integer :: outside(3)

      associate (real_ones => is_real(multipliers), size => abs(multipliers))
         outside(doubling) = count(real_ones .and. multipliers%re < -1 - neutral)
         outside(beyond_one) = count(real_ones .and. multipliers%re > 1 + neutral)
         ! Of the leading multipliers of many the last one may lack its conjugate.
         outside(neimark_sacker) = (count(.not. real_ones .and. size > 1 + neutral) + 1)/2
      end associate
   end function outside

   elemental logical function is_real(multiplier)
      complex(dp), intent(in) :: multiplier

      is_real = abs(multiplier%im) <= real_enough*abs(multiplier)
   end function is_real

   !> Halves the piece from a to b until each change is alone, or all that are left are simultaneous.
   recursive subroutine separate(corrector, monodromy, piece, a, b, first, last, after, branch)
      type(corrector_type), intent(inout) :: corrector
      type(monodromy_type), intent(inout) :: monodromy
      type(piece_type), intent(in) :: piece
      real(dp), intent(in) :: a, b
      complex(dp), intent(in) :: first(:), last(:)
      integer, intent(in) :: after
      type(branch_type), intent(inout), target :: branch
      complex(dp) :: middle(size(first))
      type(solution_point_type) :: solution
      real(dp) :: s
      integer :: change(3), kind, i
      logical :: success

      change = outside(last) - outside(first)
      if (change(doubling) == 0 .and. change(neimark_sacker) == 0) return
      if (all(mod(change([doubling, beyond_one]), 2) == 0) .and. stays(first, last)) return
      if (abs(change(doubling)) == 1 .and. change(neimark_sacker) == 0 .or. &
          abs(change(neimark_sacker)) == 1 .and. change(doubling) == 0 .and. change(beyond_one) == 0) then
         kind = merge(doubling, neimark_sacker, change(neimark_sacker) == 0)
         call locate(corrector, monodromy, piece, a, b, first, last, kind, solution)
         call add_special_point(branch, trim(names(kind)), solution%frequency_ratio, after - 1, branch%rms(:, after))
         return
      end if
      s = (a + b)/2
      call find_multipliers(corrector, monodromy, piece, a, b, s, solution, middle, success)
      if (success .and. b - a > together*piece%length) then
         call separate(corrector, monodromy, piece, a, s, first, middle, after, branch)
         call separate(corrector, monodromy, piece, s, b, middle, last, after, branch)
         return
      end if
      ! A pair became two real multipliers, or the reverse: what is left of the change is a crossing.
      if (change(doubling)*change(neimark_sacker) < 0) change = [mod(change(doubling), 2), 0, 0]
      if (change(beyond_one)*change(neimark_sacker) < 0) change(neimark_sacker) = 0
      do kind = doubling, neimark_sacker
         do i = 1, abs(change(kind))
            call add_special_point(branch, trim(names(kind)), solution%frequency_ratio, after - 1, branch%rms(:, after))
         end do
      end do
   end subroutine separate

   !> Whether as many multipliers are outside the circle at both ends of a piece, and those next to it are farther from it than they
   !> move: then pairs of them only become real, or complex, on their side of it.
   pure logical function stays(first, last)
      complex(dp), intent(in) :: first(:), last(:)
      real(dp) :: a(2), b(2)
      integer :: n

      n = count(abs(first) > 1 + neutral)
      stays = n == count(abs(last) > 1 + neutral) .and. n > 0 .and. n < size(first)
      if (.not. stays) return
      ! Sorted by magnitude.
      a = abs(first(n:n + 1))
      b = abs(last(n:n + 1))
      stays = all(abs(b - a) < min(abs(a - 1), abs(b - 1)))
   end function stays

   !> The solution point between `from` and `to` where a multiplier of a kind passes the circle.
   subroutine locate(corrector, monodromy, piece, from, to, first, last, kind, solution)
      type(corrector_type), intent(inout) :: corrector
      type(monodromy_type), intent(inout) :: monodromy
      type(piece_type), intent(in) :: piece
      real(dp), intent(in) :: from, to
      complex(dp), intent(in) :: first(:), last(:)
      integer, intent(in) :: kind
      type(solution_point_type), intent(inout) :: solution
      complex(dp) :: multipliers(size(first))
      real(dp) :: a, b, fa, fb, f, f_before, s, s_before
      integer :: i, kept, critical(3), number
      logical :: success

      critical = max(outside(first), outside(last))
      number = critical(kind)
      kept = 0
      a = from
      b = to
      fa = excess(first, kind, number)
      fb = excess(last, kind, number)
      do i = 1, most_steps
         s = between(a, b, fa, fb)
         ! Where other multipliers stay on the circle the function has a kink, at which chords hardly move.
         if (mod(i, 6) == 0) s = (a + b)/2
         call find_multipliers(corrector, monodromy, piece, a, b, s, solution, multipliers, success)
         if (.not. success) return
         f = excess(multipliers, kind, number)
         ! Just below the circle it may be a multiplier that stays there.
         if (i > 1 .and. abs(f) < nearly .and. (f > 0 .or. f < -10*neutral)) then
            if (abs(f - f_before) > 0) solution%frequency_ratio = solution%frequency_ratio - solution%tangent_frequency* &
                 f*(s - s_before)/(f - f_before)
            return
         end if
         call shrink(a, b, fa, fb, s, f, kept)
         if (b - a < together*(to - from)) return
         f_before = f
         s_before = s
      end do
   end subroutine locate

   !> How far the multiplier of a kind with this number, counted from the farthest, is outside the circle.
   pure real(dp) function excess(multipliers, kind, number)
      complex(dp), intent(in) :: multipliers(:)
      integer, intent(in) :: kind, number
      real(dp), parameter :: none = -0.5_dp
      real(dp) :: length(size(multipliers))
      integer :: i, n

      if (kind == doubling) then
         length = merge(-multipliers%re, 0.0_dp, is_real(multipliers))
         n = number
      else
         length = merge(0.0_dp, abs(multipliers), is_real(multipliers))
         n = 2*number - 1
      end if
      do i = 1, n - 1
         length(maxloc(length, 1)) = 0
      end do
      excess = max(none, maxval(length) - 1 - neutral)
   end function excess

   !> Multipliers at the way s along a piece, or where Newton's method fails, as it may next to a resonance without damping, at
   !> another one between a and b. It begins at the cubic through the ends, which is the solution point where it fails at all of
   !> them.
   subroutine find_multipliers(corrector, monodromy, piece, a, b, s, solution, multipliers, success)
      type(corrector_type), intent(inout) :: corrector
      type(monodromy_type), intent(inout) :: monodromy
      type(piece_type), intent(in) :: piece
      real(dp), intent(in) :: a, b
      real(dp), intent(inout) :: s
      type(solution_point_type), intent(inout) :: solution
      complex(dp), intent(out) :: multipliers(:)
      logical, intent(out) :: success
      real(dp), parameter :: share(*) = [0.37_dp, 0.67_dp, 0.21_dp, 0.83_dp]
      integer :: attempt

      do attempt = 0, size(share)
         if (attempt > 0) s = a + share(attempt)*(b - a)
         solution = piece%here
         call go_along(piece%here, piece%next, piece%length, s, solution)
         call corrector%correct(solution, success)
         if (success) exit
      end do
      if (.not. success) call go_along(piece%here, piece%next, piece%length, s, solution)
      if (.not. success) return
      call monodromy%integrate(corrector%balance, solution%frequency_ratio)
      call monodromy%multipliers(multipliers)
   end subroutine find_multipliers

end module geartrain_continuation_stability_changes
