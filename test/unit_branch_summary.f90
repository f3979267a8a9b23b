!> Peaks, folds, bands, jumps and ranges of contact of branches made by hand.
module unit_branch_summary
   use geartrain_base_kinds, only: dp
   use geartrain_branch_branch, only: branch_type, special_point_type
   use geartrain_branch_summary, only: band_type, bands_without_stability, folds, peak_type, peaks
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: branch_summary_tests

contains

   subroutine branch_summary_tests(tests)
      class(tests_type), intent(inout) :: tests

      call tests%begin('branch summary')
      call resonance(tests)
      call period_doubling(tests)
      call two_parts(tests)
      call without_stability(tests)
   end subroutine branch_summary_tests

   !> A softening resonance: up to the peak, back through the fold at 0.72, out through the fold at 0.95; the stable levels overlap.
   subroutine resonance(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(peak_type), allocatable :: found(:)

      branch = branch_of([0.60_dp, 0.80_dp, 0.94_dp, 0.85_dp, 0.73_dp, 0.74_dp, 0.90_dp, 1.00_dp], &
                         [0.10_dp, 0.20_dp, 0.40_dp, 0.60_dp, 0.90_dp, 1.00_dp, 0.80_dp, 0.50_dp], [1, 1, 1, 0, 0, 1, 1, 1])
      branch%special_points = [special_point_type(kind='fold', frequency=0.95_dp, point=3), &
                               special_point_type(kind='fold', frequency=0.72_dp, point=5), &
                               special_point_type(kind='symmetry', frequency=0.5_dp, point=1)]
      found = peaks(branch, 1)
      call tests%is_true(size(found) == 1, 'one peak')
      call tests%is_close(found(1)%frequency, 0.74_dp, 0.0_dp, 'its frequency')
      call tests%is_close(found(1)%rms, 1.0_dp, 0.0_dp, 'its rms')
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
      branch%special_points = [special_point_type(kind='period doubling', frequency=1.74_dp, point=2), &
                               special_point_type(kind='period doubling', frequency=2.05_dp, point=4)]
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
      branch%part = [1, 1, 1, 2, 2, 2]
      bands = bands_without_stability(branch)
      call tests%is_true(size(bands) == 0, 'nothing was traced between the parts, so nothing is said of it')
      call tests%is_true(size(peaks(branch, 1)) == 0, 'the ends of the parts are no peaks')
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

   pure function branch_of(frequency, rms, stable) result(branch)
      real(dp), intent(in) :: frequency(:), rms(:)
      integer, intent(in) :: stable(:)
      type(branch_type) :: branch

      branch%points = size(frequency)
      branch%meshes = 1
      branch%frequency = frequency
      branch%rms = reshape(rms, [1, size(rms)])
      branch%stable = stable == 1
      allocate (branch%part(size(frequency)), source=1)
   end function branch_of

end module unit_branch_summary
