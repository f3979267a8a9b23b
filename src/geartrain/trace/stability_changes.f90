!> Locates changes of stability between two places of a branch, by counting the multipliers outside the unit circle:
!> real multipliers below -1, real multipliers above +1 and complex pairs.
!>
!> Counts by kind, unlike their sum, tell two period doublings in one step, a period doubling where a pair enters, and a pair that
!> becomes real outside the circle, which is no change at all. Multipliers that stay on the circle to rounding, as of a mode without
!> damping, are never outside. Real multipliers pass +1 at folds and branch points, which the balance locates more exactly.
module geartrain_trace_stability_changes
   use geartrain_base_kinds, only: dp
   use geartrain_floquet_monodromy, only: monodromy_type
   use geartrain_floquet_multipliers, only: are_numbers, neutral, side_of_fold
   use geartrain_linalg_bracket, only: between, shrink
   use geartrain_trace_branch, only: branch_type, multipliers_at
   use geartrain_trace_corrector, only: corrector_type, solution_point_type
   use geartrain_trace_special_points, only: add_special_point, rms_of
   use geartrain_trace_step_geometry, only: go_along
   implicit none (type, external)
   private
   public :: find_multipliers, hides_pair, jumped, largest_multiplier, outside, piece_type, separate

   public :: above_one, doubling, neimark_sacker
   !> Kinds of multipliers outside the circle: real below -1, complex pairs, real above +1.
   integer, parameter :: doubling = 1, neimark_sacker = 2, above_one = 3
   character(*), parameter :: names(*) = [character(15) :: 'period doubling', 'neimark-sacker']
   !> Magnitude of a multiplier beside which multipliers near the unit circle are rounding, as of an unstable motion over a period
   !> of many teeth: no changes are located there.
   real(dp), parameter :: largest_multiplier = 1e11_dp
   !> Imaginary over real part up to which a pair is two real multipliers, as of equal stages that are nearly decoupled.
   real(dp), parameter :: real_enough = 1e-6_dp
   !> Distance of changes, as a share of the step, below which changes are simultaneous; distance of a multiplier from the unit
   !> circle, and of the place from the change as a share of the step, up to which the chord through the latest two places is taken;
   !> product of the two distances at these places, to which the error of the chord is proportional.
   real(dp), parameter :: together = 1e-6_dp, nearly = 1e-5_dp, closely = 1e-12_dp
   !> Distance from +1 within which a real multiplier may pass +1 at an end of a piece; length of a piece, as a share of the step,
   !> in which no more hidden pairs are sought.
   real(dp), parameter :: next_to_one = 0.02_dp, least = 1e-3_dp
   !> Width of the bracket of a change, as a share of the step, at which it is located where chords are not exact.
   real(dp), parameter :: located = 1e-9_dp
   integer, parameter :: most_steps = 60
   !> Distance from the circle of a multiplier of which nothing is known but that it is inside.
   real(dp), parameter :: none = -0.5_dp
   !> Distance from the circle up to which a multiplier may be the one that passes.
   real(dp), parameter :: beside = 1e-3_dp
   !> Difference of multipliers that are equal by the symmetry of the train.
   real(dp), parameter :: equal = 1e-7_dp

   !> A piece of a branch between two solution points with tangents, its length and the length of the branch up to it, in the metric
   !> of the branch.
   type :: piece_type
      type(solution_point_type) :: here, next
      real(dp) :: length = 0, start = 0
   end type piece_type

contains

   !> Whether the latest step of a branch led to another one: along a branch the number of real multipliers above 1 is even or odd,
   !> and changes this at a fold and at a branch point alone. Only points at which it is decided count.
   pure logical function jumped(branch, before, passages)
      !> A branch with stability.
      type(branch_type), intent(in) :: branch
      !> Number of the point at which the step began; number of folds in it and of multipliers that pass +1 at branch points.
      integer, intent(in) :: before, passages
      complex(dp) :: first(branch%states), last(branch%states)

      jumped = .false.
      if (branch%states == 0) return
      if (branch%count_undecided(before) .or. branch%count_undecided(branch%points)) return
      first = multipliers_at(branch, before)
      last = multipliers_at(branch, branch%points)
      if (.not. (are_numbers(first) .and. are_numbers(last))) return
      if (max(abs(first(1)), abs(last(1))) > largest_multiplier) return
      jumped = mod(side_of_fold(first) + side_of_fold(last) + passages, 2) /= 0
   end function jumped

   !> Number of multipliers outside the unit circle, of each kind.
   pure function outside(multipliers)
      !> Multipliers, largest magnitude first.
      complex(dp), intent(in) :: multipliers(:)
      integer :: outside(3), i

      outside = 0
      do i = 1, size(multipliers)
         if (.not. abs(multipliers(i)) > 1 + neutral) exit
         associate (kind => merge(merge(doubling, above_one, multipliers(i)%re < 0), neimark_sacker, is_real(multipliers(i))))
            outside(kind) = outside(kind) + 1
         end associate
      end do
      ! Where only the leading multipliers are known the last multiplier may lack its conjugate.
      outside(neimark_sacker) = (outside(neimark_sacker) + 1)/2
   end function outside

   elemental logical function is_real(multiplier)
      complex(dp), intent(in) :: multiplier

      is_real = abs(multiplier%im) <= real_enough*abs(multiplier%re)
   end function is_real

   !> Halves the piece from a to b until each change is alone, or all remaining changes are simultaneous.
   recursive subroutine separate(corrector, monodromy, piece, a, b, first, last, after, branch)
      type(corrector_type), intent(inout) :: corrector
      !> Monodromy matrix set up for the system; work space.
      type(monodromy_type), intent(inout) :: monodromy
      !> The step.
      type(piece_type), intent(in) :: piece
      !> Distances of the ends of a part of the step from its beginning [1].
      real(dp), intent(in) :: a, b
      !> Multipliers at the ends of the part.
      complex(dp), intent(in) :: first(:), last(:)
      !> The special points are listed after point `after` - 1.
      integer, intent(in) :: after
      !> Its `special_points` grow.
      type(branch_type), intent(inout), target :: branch
      complex(dp) :: middle(size(first))
      type(solution_point_type) :: solution
      real(dp) :: s
      integer :: change(3), kind
      logical :: above, fits, success

      change = outside(last) - outside(first)
      if (change(doubling) == 0 .and. change(neimark_sacker) == 0) then
         if (.not. hides_pair(first, last) .or. b - a < least*piece%length) return
      end if
      if (all(mod(change([doubling, above_one]), 2) == 0) .and. stays(first, last)) return
      kind = merge(doubling, neimark_sacker, change(neimark_sacker) == 0)
      above = change(above_one) == 0
      if (any(change([doubling, neimark_sacker]) /= 0) .and. &
          change(doubling)*change(neimark_sacker) == 0 .and. (kind == doubling .or. above) .and. &
          (abs(change(kind)) == 1 .or. pass_together(first, last, kind))) then
         call locate(corrector, monodromy, piece, a, b, first, last, kind, above, solution, s, fits)
         ! Else multipliers of another kind pass, which become of this kind outside.
         if (fits .or. b - a <= together*piece%length) then
            call list(abs(change(kind)))
            return
         end if
      end if
      s = (a + b)/2
      call find_multipliers(corrector, monodromy, piece, a, b, .false., s, solution, middle, success)
      if (success .and. b - a > together*piece%length) then
         call separate(corrector, monodromy, piece, a, s, first, middle, after, branch)
         call separate(corrector, monodromy, piece, s, b, middle, last, after, branch)
         return
      end if
      ! A pair became two real multipliers, or the reverse: only the rest of the change crosses the circle.
      if (change(doubling)*change(neimark_sacker) < 0) change = [mod(change(doubling), 2), 0, 0]
      if (change(above_one)*change(neimark_sacker) < 0) change(neimark_sacker) = 0
      do kind = doubling, neimark_sacker
         call list(abs(change(kind)))
      end do

   contains

      !> Lists so many changes at `solution`: as one special point where they are the differences of equal branches.
      subroutine list(changes)
         integer, intent(in) :: changes
         integer :: k, multiplicity

         multiplicity = 1
         if (corrector%fixed%has_differences(changes)) multiplicity = changes
         do k = 1, changes/max(1, multiplicity)
            call add_special_point(branch, trim(names(kind)), solution%frequency_ratio, after - 1, rms_of(corrector, solution), &
                                   multiplicity, piece%start + s)
         end do
      end subroutine list
   end subroutine separate

   !> Whether a pair must have left the circle, or come back to it, and become real within a piece: of the real multipliers above 1
   !> only one passes +1 in a piece, at a fold, and is near +1 at this end.
   pure logical function hides_pair(first, last)
      !> Multipliers at the ends of the piece, (state).
      complex(dp), intent(in) :: first(:), last(:)

      hides_pair = least_above(first) > most_above(last) .or. least_above(last) > most_above(first)
   end function hides_pair

   !> Number of real multipliers that are above 1 for sure, and that may be.
   pure integer function least_above(multipliers)
      complex(dp), intent(in) :: multipliers(:)

      least_above = count(is_real(multipliers) .and. multipliers%re > 1 + next_to_one)
   end function least_above

   pure integer function most_above(multipliers)
      complex(dp), intent(in) :: multipliers(:)

      most_above = count(abs(multipliers%im) <= next_to_one .and. multipliers%re > 1 - next_to_one)
   end function most_above

   !> Whether the multipliers of a kind that pass the circle are equal at both ends, as the differences of equal branches have them.
   pure logical function pass_together(first, last, kind)
      complex(dp), intent(in) :: first(:), last(:)
      integer, intent(in) :: kind
      integer :: counts(3, 2), number(2)

      counts(:, 1) = outside(first)
      counts(:, 2) = outside(last)
      number = [minval(counts(kind, :)) + 1, maxval(counts(kind, :))]
      pass_together = are_equal(first) .and. are_equal(last)

   contains

      pure logical function are_equal(multipliers)
         complex(dp), intent(in) :: multipliers(:)
         real(dp) :: length(size(multipliers))
         integer :: place(2)

         length = of_kind(multipliers, kind)
         ! A pair has two places.
         place = merge(number, 2*number - 1, kind == doubling)
         are_equal = abs(in_order(length, place(1)) - in_order(length, place(2))) <= equal
      end function are_equal

   end function pass_together

   !> Magnitudes of the multipliers that are real and negative, or in pairs; 0 of the others.
   pure function of_kind(multipliers, kind) result(length)
      complex(dp), intent(in) :: multipliers(:)
      integer, intent(in) :: kind
      real(dp) :: length(size(multipliers))

      if (kind == doubling) then
         length = merge(max(0.0_dp, -multipliers%re), 0.0_dp, is_real(multipliers))
      else
         length = merge(0.0_dp, abs(multipliers), is_real(multipliers))
      end if
   end function of_kind

   !> The length at a place in their descending order.
   pure real(dp) function in_order(length, place)
      real(dp), intent(in) :: length(:)
      integer, intent(in) :: place
      logical :: left(size(length))
      integer :: i

      left = .true.
      do i = 1, place - 1
         left(maxloc(length, 1, left)) = .false.
      end do
      in_order = maxval(length, left)
   end function in_order

   !> Whether no multiplier crosses the circle: as many are outside at both ends of a piece, and the multipliers next to the circle
   !> are farther from it than they move. Then pairs only become real, or complex, on their side of the circle.
   pure logical function stays(first, last)
      complex(dp), intent(in) :: first(:), last(:)
      real(dp) :: a(2), b(2)
      integer :: n

      n = count(abs(first) > 1 + neutral)
      stays = n == count(abs(last) > 1 + neutral) .and. n > 0 .and. n < size(first)
      if (.not. stays) return
      ! The multipliers are sorted by magnitude.
      a = abs(first(n:n + 1))
      b = abs(last(n:n + 1))
      stays = all(abs(b - a) < min(abs(a - 1), abs(b - 1)))
   end function stays

   !> The solution point between the distances `from` and `to` along a piece where a multiplier passes the circle.
   subroutine locate(corrector, monodromy, piece, from, to, first, last, kind, above, solution, s, fits)
      type(corrector_type), intent(inout) :: corrector
      type(monodromy_type), intent(inout) :: monodromy
      type(piece_type), intent(in) :: piece
      real(dp), intent(in) :: from, to
      complex(dp), intent(in) :: first(:), last(:)
      integer, intent(in) :: kind
      !> Real multipliers above +1 count: as many at both ends.
      logical, intent(in) :: above
      type(solution_point_type), intent(inout) :: solution
      !> Distance of the point from the beginning of the piece [1].
      real(dp), intent(out) :: s
      !> A multiplier of the kind is next to the circle there; or none was found.
      logical, intent(out) :: fits
      complex(dp) :: multipliers(size(first))
      !> Place, excess and Lambda of the latest two places at which the multiplier is outside or, inside, known.
      real(dp) :: known(3, 2)
      real(dp) :: a, b, fa, fb, f, chord
      integer :: i, kept, number, taken
      logical :: success

      fits = .true.
      number = max(number_outside(first, above), number_outside(last, above))
      kept = 0
      a = from
      b = to
      fa = excess(first, kind, number, above)
      fb = excess(last, kind, number, above)
      known(:2, 1) = merge([a, fa], [b, fb], fa > 0)
      known(:2, 2) = merge([b, fb], [a, fa], fa > 0)
      if (known(2, 2) <= none) known(:, 2) = known(:, 1)
      taken = 0
      do i = 1, most_steps
         s = between(a, b, fa, fb)
         associate (at => known(1, :), e => known(2, :))
            if (abs(e(2) - e(1)) > 0) s = at(2) - e(2)*(at(2) - at(1))/(e(2) - e(1))
         end associate
         ! Inside, other multipliers may be as near to the circle: chords then hardly move.
         if (.not. (s > a .and. s < b) .or. mod(i, 4) == 0) s = (a + b)/2
         call find_multipliers(corrector, monodromy, piece, a, b, .false., s, solution, multipliers, success)
         if (.not. success) return
         f = excess(multipliers, kind, number, above)
         fits = any(abs(of_kind(multipliers, kind) - 1) <= beside)
         if (f > none) then
            known(:, 1) = known(:, 2)
            known(:, 2) = [s, f, solution%frequency_ratio]
            taken = taken + 1
            ! How far the chord through the latest two places leads: where multipliers hardly change, as of a train of little
            ! damping, a multiplier next to the circle may be far from where it passes.
            chord = huge(chord)
            if (taken > 1 .and. abs(f - known(2, 1)) > 0) chord = -f*(s - known(1, 1))/(f - known(2, 1))
            if (max(abs(f), abs(chord)/(to - from)) < nearly) then
               if (max(abs(f*known(2, 1)), abs(chord*(s + chord - known(1, 1)))/(to - from)**2) < closely) then
                  ! Lambda follows from the chord too: s is a place on the cubic through the ends, not on the branch.
                  solution%frequency_ratio = known(3, 2) + chord*(known(3, 2) - known(3, 1))/(s - known(1, 1))
                  s = s + chord
                  return
               end if
            end if
         end if
         call shrink(a, b, fa, fb, s, f, kept)
         if (b - a < located*(to - from)) return
      end do
   end subroutine locate

   !> Number of multipliers outside the circle, with those above +1 or without.
   pure integer function number_outside(multipliers, above) result(number)
      complex(dp), intent(in) :: multipliers(:)
      logical, intent(in) :: above
      integer :: kinds(3)

      kinds = outside(multipliers)
      number = kinds(doubling) + 2*kinds(neimark_sacker)
      if (above) number = number + kinds(above_one)
      ! Where only the leading multipliers are known the last one may lack its conjugate.
      number = min(number, size(multipliers))
   end function number_outside

   !> Distance from the circle of the multiplier that is farthest but number - 1; negative where it is inside, of the farthest
   !> there of the kind. Outside, magnitudes of any kind: where two real multipliers become a pair they are continuous, and nothing
   !> passes.
   pure real(dp) function excess(multipliers, kind, number, above)
      !> Multipliers, largest magnitude first.
      complex(dp), intent(in) :: multipliers(:)
      integer, intent(in) :: kind, number
      !> Real positive multipliers count.
      logical, intent(in) :: above
      real(dp) :: length(size(multipliers))

      length = abs(multipliers)
      if (.not. above) length = merge(0.0_dp, length, is_real(multipliers) .and. multipliers%re > 0)
      excess = in_order(length, number) - 1 - neutral
      if (excess > 0) return
      length = of_kind(multipliers, kind)
      excess = max(none, maxval(length, length <= 1 + neutral) - 1 - neutral)
      ! A pair that stays on the circle to rounding tells nothing of how far from here another passes.
      if (kind == neimark_sacker .and. excess > -10*neutral) excess = none
   end function excess

   !> Multipliers at the distance s along a piece. Newton's method begins at the cubic through the ends. Where it fails, as may be
   !> next to a resonance without damping, s becomes another distance between a and b; where it fails at all of them, `solution` is
   !> a point of the cubic.
   subroutine find_multipliers(corrector, monodromy, piece, a, b, verdict, s, solution, multipliers, success)
      type(corrector_type), intent(inout) :: corrector
      !> Monodromy matrix set up for the system; work space.
      type(monodromy_type), intent(inout) :: monodromy
      !> The step.
      type(piece_type), intent(in) :: piece
      !> Distances along the step between which another place is tried [1].
      real(dp), intent(in) :: a, b
      !> Only sides of the unit circle are wanted: of a train of many states multipliers are found roughly.
      logical, intent(in) :: verdict
      !> Distance of the place from the beginning of the step [1].
      real(dp), intent(inout) :: s
      !> The point.
      type(solution_point_type), intent(inout) :: solution
      !> Its multipliers.
      complex(dp), intent(out) :: multipliers(:)
      !> Newton's method has converged, and multipliers were found.
      logical, intent(out) :: success
      real(dp), parameter :: share(*) = [0.37_dp, 0.67_dp, 0.21_dp, 0.83_dp]
      integer :: attempt

      do attempt = 0, size(share)
         if (attempt > 0) s = a + share(attempt)*(b - a)
         solution = piece%here
         call go_along(piece%here, piece%next, s/piece%length, corrector%units, solution)
         call corrector%correct(solution, success)
         if (success) exit
      end do
      if (.not. success) call go_along(piece%here, piece%next, s/piece%length, corrector%units, solution)
      if (.not. success) return
      call monodromy%integrate(corrector%balance, corrector%balance%frequency_ratio, verdict=verdict)
      call monodromy%multipliers(multipliers)
      success = are_numbers(multipliers)
   end subroutine find_multipliers

end module geartrain_trace_stability_changes
