!> Peaks, folds, bands, jumps and ranges of contact of branches made by hand.
module unit_branch_summary
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use geartrain_base_kinds, only: dp
   use geartrain_base_sheet, only: in_result, sheet_type
   use geartrain_readings_curve, only: arc_type
   use geartrain_readings_contact_ranges, only: back_collision_ranges, separation_ranges
   use geartrain_readings_frequency_text, only: frequency_text_type
   use geartrain_readings_jump_sentences, only: say_jumps
   use geartrain_readings_jumps, only: jump_type, jumps
   use geartrain_readings_summary, only: band_type, bands_without_stability, folds, gaps, peak_type, peaks
   use geartrain_trace_branch, only: arrange_points, branch_type, special_point_type
   use geartrain_trace_recorder, only: follow_branch_points
   use fixtures, only: single_pair
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: branch_summary_tests

contains

   subroutine branch_summary_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('resonance')) call resonance(tests)
      if (tests%runs('period_doubling')) call period_doubling(tests)
      if (tests%runs('two_parts')) call two_parts(tests)
      if (tests%runs('without_stability')) call without_stability(tests)
      if (tests%runs('jumps_of_a_resonance')) call jumps_of_a_resonance(tests)
      if (tests%runs('jump_among_three')) call jump_among_three(tests)
      if (tests%runs('equal_sentences_of_jumps')) call equal_sentences_of_jumps(tests)
      if (tests%runs('jump_beside_a_fold')) call jump_beside_a_fold(tests)
      if (tests%runs('ranges_of_contact')) call ranges_of_contact(tests)
      if (tests%runs('closed_island')) call closed_island(tests)
      if (tests%runs('peaks_between_points')) call peaks_between_points(tests)
      if (tests%runs('beside_a_branch_point')) call beside_a_branch_point(tests)
      if (tests%runs('field_of_a_later_version')) call field_of_a_later_version(tests)
   end subroutine branch_summary_tests

   !> A multiplier passes +1 between points 3 and 4, the balance's branch point lies after point 6.
   subroutine beside_a_branch_point(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch

      branch = passing([1, 1, 1, 0, 0, 0, 0, 0, 0])
      branch%special_points = [special_point_type('branch point', 1.065_dp, 6)]
      call follow_branch_points(branch)
      call tests%is_true(all(branch%stable .eqv. [1, 1, 1, 1, 1, 1, 0, 0, 0] == 1), 'too early: stable up to the branch point')
      call tests%is_true(all(branch%undecided .eqv. [0, 0, 0, 1, 1, 1, 0, 0, 0] == 1), 'too early: undecided between')
      branch = passing([1, 1, 1, 1, 1, 1, 0, 0, 0])
      branch%special_points = [special_point_type('branch point', 1.035_dp, 3)]
      call follow_branch_points(branch)
      call tests%is_true(all(branch%stable .eqv. [1, 1, 1, 0, 0, 0, 0, 0, 0] == 1), 'too late: unstable from the branch point on')
      call tests%is_true(all(branch%undecided .eqv. [0, 0, 0, 1, 1, 1, 0, 0, 0] == 1), 'too late: undecided between')
      branch = passing([1, 1, 1, 0, 0, 0, 0, 0, 0])
      branch%special_points = [special_point_type('branch point', 1.035_dp, 3)]
      call follow_branch_points(branch)
      call tests%is_true(.not. any(branch%undecided), 'at once: nothing is doubted')
      branch%special_points = [special_point_type('branch point', 1.065_dp, 6), special_point_type('fold', 1.04_dp, 4)]
      call follow_branch_points(branch)
      call tests%is_true(.not. any(branch%undecided), 'a passage at a fold belongs to the fold')
      ! Of three equal branches two multipliers pass at once, a complex pair by their rounding.
      branch = passing([1, 1, 1, 0, 0, 0, 0, 0, 0], 1e-9_dp)
      branch%special_points = [special_point_type('branch point', 1.065_dp, 6, multiplicity=2)]
      call follow_branch_points(branch)
      call tests%is_true(all(branch%stable .eqv. [1, 1, 1, 1, 1, 1, 0, 0, 0] == 1), 'both too early: stable up to there')
      call tests%is_true(all(branch%undecided .eqv. [0, 0, 0, 1, 1, 1, 0, 0, 0] == 1), 'both too early: undecided between')
      branch = passing([1, 1, 1, 1, 1, 1, 0, 0, 0], 1e-9_dp)
      branch%special_points = [special_point_type('branch point', 1.035_dp, 3, multiplicity=2)]
      call follow_branch_points(branch)
      call tests%is_true(all(branch%stable .eqv. [1, 1, 1, 0, 0, 0, 0, 0, 0] == 1), 'both too late: unstable from there on')
      branch = passing([1, 1, 1, 0, 0, 0, 0, 0, 0], 1e-9_dp)
      branch%special_points = [special_point_type('branch point', 1.035_dp, 3, multiplicity=2)]
      call follow_branch_points(branch)
      call tests%is_true(.not. any(branch%undecided), 'both at once: nothing is doubted')

   contains

      !> Points whose largest multiplier is 0.99, of those that are stable, else 1.02; the other one 0.5, or as large and a complex
      !> pair with it.
      type(branch_type) function passing(stable, apart)
         integer, intent(in) :: stable(:)
         !> Imaginary part of the pair.
         real(dp), intent(in), optional :: apart
         integer :: i

         passing = branch_of([(1 + 0.01_dp*i, i=1, size(stable))], [(1.0_dp, i=1, size(stable))], stable)
         passing%states = 2
         passing%segment = [(1, i=1, size(stable))]
         passing%undecided = [(.false., i=1, size(stable))]
         passing%count_undecided = passing%undecided
         passing%multipliers = reshape([(cmplx(merge(0.99_dp, 1.02_dp, stable(i) == 1), 0, dp), (0.5_dp, 0.0_dp), &
                                         i=1, size(stable))], [2, size(stable)])
         if (.not. present(apart)) return
         passing%multipliers(2, :) = passing%multipliers(1, :) - (0, 1)*apart
         passing%multipliers(1, :) = passing%multipliers(1, :) + (0, 1)*apart
      end function passing

   end subroutine beside_a_branch_point

   !> Where the curve between two points has a peak, by values and slopes of functions whose peaks are known.
   subroutine peaks_between_points(tests)
      class(tests_type), intent(inout) :: tests
      type(arc_type) :: arc
      real(dp) :: share
      logical :: found

      arc%rms = [0.0_dp, 1.0_dp]
      ! Solved at the peak, after a steep rise: the cubic is above the peak before it.
      arc%rms_slope = [9.0_dp, 1e-9_dp]
      call arc%peak(share, found)
      call tests%is_true(found, 'a peak at a point whose slope is rounding')
      call tests%is_close(share, 1.0_dp, 0.0_dp, 'not before it')
      arc%rms_slope = [1e-9_dp, 2.0_dp]
      call arc%peak(share, found)
      call tests%is_true(.not. found, 'nor after it')
      arc%rms_slope = [0.5_dp, 0.7_dp]
      call arc%peak(share, found)
      call tests%is_true(.not. found, 'a rise throughout')
      ! y = -2 t**3 + 2.9 t**2 - 0.3 t: y' = 0 at t = (5.8 +- sqrt(26.44))/12.
      arc%rms = [0.0_dp, 0.6_dp]
      arc%rms_slope = [-0.3_dp, -0.5_dp]
      call arc%peak(share, found)
      call tests%is_true(found, 'a dip, then a peak, against the slopes')
      call tests%is_close(share, (5.8_dp + sqrt(26.44_dp))/12, 1e-14_dp, 'its place')
      arc%rms = -arc%rms
      arc%rms_slope = -arc%rms_slope
      call arc%peak(share, found)
      call tests%is_true(found, 'a peak, then a dip, against the slopes')
      call tests%is_close(share, (5.8_dp - sqrt(26.44_dp))/12, 1e-14_dp, 'its place')
      arc%rms = [0.6_dp, 0.0_dp]
      arc%rms_slope = [-0.5_dp, -0.7_dp]
      call arc%peak(share, found)
      call tests%is_true(.not. found, 'a fall throughout')
   end subroutine peaks_between_points

   !> An array that a checkpoint of before does not have: NaN for the points of before, not a number that looks like one.
   subroutine field_of_a_later_version(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch

      branch = branch_of([0.6_dp, 0.8_dp, 0.9_dp], [0.1_dp, 0.2_dp, 0.3_dp], [1, 1, 1])
      branch%orders = [1]
      call arrange_points(branch, [1, 2, 3], 5)
      call tests%is_true(all(ieee_is_nan(branch%mean(:, :3))), 'points of before')
      call tests%is_true(all(abs(branch%mean(:, 4:)) <= 0), 'room for points to come')
      call tests%is_close(branch%rms(1, 2), 0.2_dp, 1e-15_dp, 'what was there')
   end subroutine field_of_a_later_version

   !> A softening resonance: up to the peak, back through the fold at 0.72, out through the fold at 0.95; the stable levels overlap.
   subroutine resonance(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(peak_type), allocatable :: found(:)

      branch = branch_of([0.60_dp, 0.80_dp, 0.94_dp, 0.85_dp, 0.73_dp, 0.74_dp, 0.90_dp, 1.00_dp], &
                         [0.10_dp, 0.20_dp, 0.40_dp, 0.60_dp, 0.90_dp, 1.00_dp, 0.80_dp, 0.50_dp], [1, 1, 1, 0, 0, 1, 1, 1])
      branch%special_points = [special_point_type(kind='fold', frequency_ratio=0.95_dp, point=3), &
                               special_point_type(kind='fold', frequency_ratio=0.72_dp, point=5), &
                               special_point_type(kind='branch point', frequency_ratio=0.5_dp, point=1)]
      found = peaks(branch, 1)
      call tests%is_true(size(found) == 1, 'one peak')
      ! Cubics over the length of the chord from (0.74, 1) to (0.9, 0.8), by numpy.poly1d: without derivatives of the branch those
      ! of parabolas through three points.
      call tests%is_close(found(1)%frequency_ratio, 0.749393066756758_dp, 1e-12_dp, 'its frequency')
      call tests%is_close(found(1)%rms, 1.006671808407637_dp, 1e-12_dp, 'its rms')
      call tests%is_true(found(1)%stable .and. found(1)%point == 6, 'its stability and point')
      call tests%is_true(size(folds(branch)) == 2, 'two folds')
      call tests%is_close(sum(folds(branch)*[1.0_dp, 10.0_dp]), 0.72_dp + 9.5_dp, 1e-12_dp, 'ascending')
      call tests%is_true(size(bands_without_stability(branch)) == 0, 'a stable motion everywhere')
   end subroutine resonance

   subroutine period_doubling(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(band_type), allocatable :: bands(:)

      branch = branch_of([1.6_dp, 1.7_dp, 1.8_dp, 2.0_dp, 2.1_dp, 2.2_dp, 2.3_dp], &
                         [0.5_dp, 0.4_dp, 0.3_dp, 0.2_dp, 0.1_dp, 0.1_dp, 0.1_dp], [1, 1, 0, 0, 1, 1, 0])
      branch%special_points = [special_point_type(kind='period doubling', frequency_ratio=1.74_dp, point=2), &
                               special_point_type(kind='period doubling', frequency_ratio=2.05_dp, point=4)]
      bands = bands_without_stability(branch)
      call tests%is_true(size(bands) == 2, 'two bands')
      call tests%is_close(bands(1)%from, 1.74_dp, 1e-14_dp, 'the band begins at the special point')
      call tests%is_close(bands(1)%to, 2.05_dp, 1e-14_dp, 'and ends at the next')
      call tests%is_close(bands(2)%from, 2.25_dp, 1e-14_dp, 'without one it begins halfway')
      call tests%is_close(bands(2)%to, 2.3_dp, 1e-14_dp, 'and ends with the branch')
      call tests%is_true(size(peaks(branch, 1)) == 0, 'a falling curve has no peak')
      call tests%is_true(size(folds(branch)) == 0, 'no fold')
      branch%stable = .false.
      bands = bands_without_stability(branch)
      call tests%is_true(size(bands) == 1, 'nothing stable: one band')
      call tests%is_close(bands(1)%to - bands(1)%from, 0.7_dp, 1e-14_dp, 'as wide as the branch')
   end subroutine period_doubling

   !> Two parts that come from either end and do not meet.
   subroutine two_parts(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(band_type), allocatable :: bands(:)

      branch = branch_of([0.5_dp, 0.6_dp, 0.7_dp, 1.0_dp, 0.9_dp, 0.8_dp], &
                         [1.0_dp, 2.0_dp, 3.0_dp, 1.0_dp, 2.0_dp, 3.0_dp], [1, 1, 1, 1, 1, 1])
      branch%segment = [1, 1, 1, 2, 2, 2]
      bands = bands_without_stability(branch)
      call tests%is_true(size(bands) == 0, 'nothing was traced between the parts, so nothing is said of it')
      call tests%is_true(size(peaks(branch, 1)) == 0, 'the ends of the parts are no peaks')
      bands = gaps(branch)
      call tests%is_true(size(bands) == 1, 'what lies between the parts was not computed')
      call tests%is_close(bands(1)%from + 10*bands(1)%to, 8.7_dp, 1e-14_dp, '0.7 to 0.8')
      bands = gaps(branch, [1.2_dp, 0.5_dp])
      call tests%is_true(size(bands) == 2, 'nor what is asked for beyond them')
      call tests%is_close(bands(2)%from + 10*bands(2)%to, 13.0_dp, 1e-14_dp, '1.0 to 1.2')
   end subroutine two_parts

   subroutine without_stability(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch, empty

      branch = branch_of([0.5_dp, 0.6_dp, 0.7_dp], [1.0_dp, 2.0_dp, 1.0_dp], [1, 1, 1])
      deallocate (branch%stable)
      call tests%is_true(size(peaks(branch, 1)) == 1, 'a peak without stability')
      call tests%is_true(size(bands_without_stability(branch)) == 0, 'no bands where it was not asked for')
      call tests%is_true(size(peaks(empty, 1)) == 0 .and. size(folds(empty)) == 0, 'an empty branch')
   end subroutine without_stability

   !> The same resonance, the folds being points now; rising speed jumps up at 0.95, falling speed down at 0.72.
   subroutine jumps_of_a_resonance(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(jump_type), allocatable :: found(:)
      integer :: i

      branch = branch_of([0.60_dp, 0.80_dp, 0.95_dp, 0.85_dp, 0.72_dp, 0.74_dp, 0.90_dp, 1.00_dp], &
                         [0.10_dp, 0.20_dp, 0.40_dp, 0.60_dp, 0.90_dp, 1.00_dp, 0.80_dp, 0.50_dp], [1, 1, 1, 0, 0, 1, 1, 1])
      branch%special_points = [special_point_type('fold', 0.95_dp, 3), special_point_type('fold', 0.72_dp, 5)]
      call put_rms(branch, [0.4_dp, 0.9_dp])
      found = jumps(branch)
      call tests%is_true(size(found) == 2, 'two jumps')
      if (size(found) /= 2) return
      call tests%is_text(trim(found(1)%kind), 'jump down', 'at the lower fold')
      call tests%is_true(.not. found(1)%rising, 'it is falling speed that jumps there')
      call tests%is_close(found(1)%frequency_ratio, 0.72_dp, 0.0_dp, 'Lambda of the jump down')
      call tests%is_close(found(1)%after(1), 0.16_dp, 1e-14_dp, 'rms below it, between 0.1 and 0.2')
      call tests%is_text(trim(found(2)%kind), 'jump up', 'at the upper fold')
      call tests%is_true(found(2)%rising, 'it is rising speed that jumps there')
      call tests%is_close(found(2)%after(1), 0.65_dp, 1e-14_dp, 'rms above it, halfway from 0.8 to 0.5')
      branch%stable(6:) = .false.
      found = jumps(branch)
      call tests%is_true(size(found) == 1, 'a fold between two unstable sides is no jump')
      call tests%is_text(trim(found(1)%kind), 'leaves', 'without another stable motion the sweep leaves the branch')
      deallocate (branch%stable)
      call tests%is_true(size(jumps(branch)) == 0, 'without stability no jumps')
      ! Where the harmonics change a point may lie beyond the fold, and behind it an undecided point may count as stable.
      branch = branch_of([0.60_dp, 0.80_dp, 0.9501_dp, 0.95_dp, 0.949_dp, 0.85_dp, 0.72_dp, 0.74_dp, 0.90_dp, 1.00_dp], &
                         [0.10_dp, 0.20_dp, 0.39_dp, 0.40_dp, 0.41_dp, 0.60_dp, 0.90_dp, 1.00_dp, 0.80_dp, 0.50_dp], &
                         [1, 1, 1, 1, 1, 0, 0, 1, 1, 1])
      branch%undecided = [(i == 5, i=1, 10)]
      branch%special_points = [special_point_type('fold', 0.95_dp, 4), special_point_type('fold', 0.72_dp, 7)]
      call put_rms(branch, [0.4_dp, 0.9_dp])
      found = jumps(branch)
      call tests%is_true(size(found) == 2, 'two jumps of an uneven fold')
      if (size(found) /= 2) return
      call tests%is_true(found(2)%rising, 'rising speed jumps at an uneven fold')
      call tests%is_close(found(2)%after(1), 0.65_dp, 1e-14_dp, 'not to the fold itself')
   end subroutine jumps_of_a_resonance

   !> Of two stable motions the one with the nearest rms; a loss of stability without a fold leaves the branch.
   subroutine jump_among_three(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(jump_type), allocatable :: found(:)

      branch = branch_of([0.5_dp, 1.0_dp, 0.6_dp, 1.2_dp, 0.4_dp, 1.5_dp, 1.7_dp], &
                         [0.1_dp, 0.2_dp, 0.3_dp, 0.5_dp, 0.6_dp, 0.9_dp, 1.0_dp], [1, 1, 0, 1, 0, 1, 0])
      branch%special_points = [special_point_type('fold', 1.0_dp, 2), special_point_type('period doubling', 1.6_dp, 6)]
      call put_rms(branch, [0.2_dp, 1.0_dp])
      found = jumps(branch)
      call tests%is_true(size(found) == 2, 'a fold and a doubling')
      if (size(found) /= 2) return
      ! At 1.0 the pieces from (0.6, 0.3) to (1.2, 0.5) and from (0.4, 0.6) to (1.5, 0.9); stability changes halfway.
      call tests%is_close(found(1)%after(1), 0.3_dp + 0.2_dp*2/3, 1e-14_dp, 'the nearer one')
      call tests%is_text(trim(found(2)%kind), 'leaves', 'a doubling leaves the branch')
      call tests%is_true(found(2)%rising, 'when the speed rises')
      call tests%is_text(trim(found(2)%cause), 'period doubling', 'by a doubling')
      call tests%is_true(all(found(2)%after < 0), 'and rms after it is not known')
   end subroutine jump_among_three

   !> Stability is lost twice with rising speed within the digits that are printed: one sentence with the number of jumps.
   subroutine equal_sentences_of_jumps(tests)
      class(tests_type), intent(inout) :: tests
      character(*), parameter :: ending = ' vibration jumps to a motion that is not on this curve'
      type(branch_type) :: branch
      type(frequency_text_type) :: told
      type(sheet_type) :: sheet

      branch = branch_of([0.6_dp, 0.80001_dp, 0.80002_dp, 0.80003_dp, 0.80004_dp, 0.9_dp], &
                         [0.1_dp, 0.20_dp, 0.20_dp, 0.20_dp, 0.20_dp, 0.3_dp], [1, 1, 0, 1, 0, 0])
      branch%special_points = [special_point_type('stability change', 0.800015_dp, 2), &
                               special_point_type('stability change', 0.800025_dp, 3), &
                               special_point_type('stability change', 0.800035_dp, 4)]
      call put_rms(branch, [0.2_dp, 0.2_dp, 0.2_dp])
      call say_jumps(branch, single_pair(0.05_dp, 0.3_dp, 0.4_dp), told, sheet)
      call tests%is_text(sheet%sections(in_result)%text, &
                         '    speed up: at Lambda 0.8000'//ending//' (stability change):'//new_line('a')// &
                         '    2 jumps'//new_line('a')//'    speed down: at Lambda 0.8000'//ending//' (stability'// &
                         new_line('a')//'    change)'//new_line('a'), 'three jumps')
   end subroutine equal_sentences_of_jumps

   !> The stable motion above the fold at 1.0 ends at 1.0005: whether it is there at 1.0 is a matter of errors of 0.001, and not of
   !> 0.00001.
   subroutine jump_beside_a_fold(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(jump_type), allocatable :: found(:)

      branch = branch_of([0.60_dp, 0.90_dp, 1.0_dp, 0.90_dp, 0.50_dp, 0.80_dp, 1.0005_dp, 0.70_dp], &
                         [0.10_dp, 0.20_dp, 0.4_dp, 0.60_dp, 0.70_dp, 0.80_dp, 0.9_dp, 1.0_dp], [1, 1, 1, 0, 0, 1, 1, 0])
      branch%special_points = [special_point_type('fold', 1.0_dp, 3), special_point_type('fold', 0.5_dp, 5), &
                               special_point_type('fold', 1.0005_dp, 7)]
      call put_rms(branch, [0.4_dp, 0.7_dp, 0.9_dp])
      allocate (branch%error_estimate(8), source=1e-3_dp)
      found = jumps(branch)
      call tests%is_true(size(found) == 3, 'from each fold')
      if (size(found) /= 3) return
      call tests%is_text(trim(found(2)%kind), 'jump up', 'to the motion above')
      call tests%is_true(found(2)%undecided, 'which may have ended')
      branch%error_estimate = 1e-5_dp
      found = jumps(branch)
      call tests%is_true(.not. found(2)%undecided, 'which is there')
      ! Made exact, the fold lies before the point where the balance turns; its own points pass its Lambda once more.
      branch%special_points(1)%frequency_ratio = 0.98_dp
      branch%special_points(1)%correction = 0.02_dp
      found = jumps(branch)
      call tests%is_true(found(2)%candidates == 1 .and. found(2)%after(1) > 0.8_dp, 'no jump to the motion that ends')
   end subroutine jump_beside_a_fold

   !> b = 1: separation between edges at 0.75 and 1.3 with one level stable only up to 1.1; back collision where p < -1.
   subroutine ranges_of_contact(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(band_type), allocatable :: ranges(:)

      branch = branch_of([0.7_dp, 0.8_dp, 0.9_dp, 1.0_dp, 1.2_dp, 1.4_dp], [1.0_dp, 2.0_dp, 3.0_dp, 3.0_dp, 2.0_dp, 1.0_dp], &
                         [1, 1, 1, 1, 0, 0])
      branch%minimum = reshape([1.5_dp, 0.5_dp, -1.5_dp, -0.5_dp, 0.5_dp, 1.5_dp], [1, 6])
      branch%maximum = branch%minimum + 2
      allocate (branch%special_points(0))
      call tests%is_true(size(separation_ranges(branch, 1, .false.)) == 0, 'unknown backlash: nothing is said')
      branch%half_backlash = [1.0_dp]
      ranges = separation_ranges(branch, 1, .false.)
      call tests%is_true(size(ranges) == 1, 'one range of separation')
      call tests%is_close(ranges(1)%from, 0.75_dp, 1e-14_dp, 'from where the smallest displacement is b')
      call tests%is_close(ranges(1)%to, 1.3_dp, 1e-14_dp, 'to where it is again')
      ranges = separation_ranges(branch, 1, .true.)
      call tests%is_close(ranges(1)%to, 1.1_dp, 1e-14_dp, 'at stable motions up to where stability ends')
      ranges = back_collision_ranges(branch, 1, .false.)
      call tests%is_true(size(ranges) == 1, 'one range of back collision')
      call tests%is_close(ranges(1)%from, 0.875_dp, 1e-14_dp, 'from where the smallest displacement is -b')
      call tests%is_close(ranges(1)%to, 0.95_dp, 1e-14_dp, 'to where it is again')
      ! Turned round: the teeth rest on the back flanks.
      branch%maximum = -branch%minimum
      branch%minimum = branch%maximum - 2
      ranges = separation_ranges(branch, 1, .false.)
      call tests%is_close(ranges(1)%from + ranges(size(ranges))%to, 0.75_dp + 1.3_dp, 1e-14_dp, 'the same range turned round')
      branch%half_backlash = [0.0_dp]
      call tests%is_true(size(separation_ranges(branch, 1, .false.)) == 0, 'no backlash, no separation')
   end subroutine ranges_of_contact

   !> An island traced from 1.0, stable up to 1.2 and down to 0.8, that comes back to its first motion at 0.999: no gap there.
   subroutine closed_island(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(band_type), allocatable :: ranges(:)

      branch = branch_of([1.0_dp, 1.2_dp, 1.0_dp, 0.8_dp, 0.999_dp], [2.0_dp, 1.5_dp, 1.0_dp, 1.5_dp, 2.0_dp], [1, 1, 0, 1, 1])
      allocate (branch%special_points(2))
      branch%special_points%kind = 'fold'
      branch%special_points%point = [2, 3]
      branch%special_points%frequency_ratio = [1.2_dp, 0.8_dp]
      branch%half_backlash = [1.0_dp]
      branch%minimum = reshape([0.5_dp, 0.5_dp, 1.5_dp, 0.5_dp, 0.5_dp], [1, 5])
      branch%maximum = branch%minimum + 3
      call tests%is_true(size(bands_without_stability(branch)) == 1, 'an open end leaves a band')
      call tests%is_true(size(separation_ranges(branch, 1, .true.)) == 2, 'and two ranges')
      branch%closed = .true.
      call tests%is_true(size(bands_without_stability(branch)) == 0, 'a closed one leaves none')
      ranges = separation_ranges(branch, 1, .true.)
      call tests%is_true(size(ranges) == 1, 'and one range')
      if (size(ranges) /= 1) return
      call tests%is_close(ranges(1)%from, 0.8_dp, 1e-14_dp, 'from its one end')
      call tests%is_close(ranges(1)%to, 1.2_dp, 1e-14_dp, 'to its other')
   end subroutine closed_island

   pure function branch_of(frequency_ratio, rms, stable) result(branch)
      real(dp), intent(in) :: frequency_ratio(:), rms(:)
      integer, intent(in) :: stable(:)
      type(branch_type) :: branch

      branch%points = size(frequency_ratio)
      branch%meshes = 1
      branch%frequency_ratio = frequency_ratio
      branch%rms = reshape(rms, [1, size(rms)])
      branch%stable = stable == 1
      allocate (branch%segment(size(frequency_ratio)), source=1)
   end function branch_of

   !> The rms of each special point. (gfortran 12 never frees it in an array constructor.)
   subroutine put_rms(branch, rms)
      type(branch_type), intent(inout) :: branch
      real(dp), intent(in) :: rms(:)
      integer :: i

      do i = 1, size(rms)
         branch%special_points(i)%rms = [rms(i)]
      end do
   end subroutine put_rms

end module unit_branch_summary
