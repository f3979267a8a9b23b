!> What one reads off a curve of the paper with a ruler: the largest peak in a range, the smallest displacement, a fold.
module readings
   use geartrain, only: branch_type, dp, error_type, response, train_type
   use geartrain_branch_summary, only: band_type, bands_without_stability, folds, peak_type, peaks
   use fixtures, only: settings_of
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: traced, peak_between, largest_between, smallest_between, has_fold, folds_between, is_band, stable_somewhere

contains

   !> The response of a train at R harmonics; a branch that is not complete is a failed check.
   function traced(tests, train, from, to, harmonics, name) result(branch)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      real(dp), intent(in) :: from, to
      integer, intent(in) :: harmonics
      character(*), intent(in) :: name
      type(branch_type) :: branch
      type(error_type), allocatable :: error

      call response(train, settings_of(from, to, harmonics), branch, error)
      call tests%is_true(.not. allocated(error) .and. branch%complete, name//': the branch is complete')
   end function traced

   !> The highest peak of a mesh between two frequencies; its rms is 0 where there is none.
   pure function peak_between(branch, mesh, from, to) result(peak)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: mesh
      real(dp), intent(in) :: from, to
      type(peak_type) :: peak
      type(peak_type), allocatable :: found(:)
      integer :: i

      found = peaks(branch, mesh)
      do i = 1, size(found)
         if (found(i)%frequency < from .or. found(i)%frequency > to .or. found(i)%rms <= peak%rms) cycle
         peak = found(i)
      end do
   end function peak_between

   !> Largest rms of a mesh between two frequencies, at any level of the branch.
   pure real(dp) function largest_between(branch, mesh, from, to) result(rms)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: mesh
      real(dp), intent(in) :: from, to

      rms = maxval(branch%rms(mesh, :branch%points), &
                   branch%frequency(:branch%points) >= from .and. branch%frequency(:branch%points) <= to)
   end function largest_between

   !> Smallest displacement of a mesh between two frequencies: below 1 it separates, below -1 its back flanks collide.
   pure real(dp) function smallest_between(branch, mesh, from, to) result(displacement)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: mesh
      real(dp), intent(in) :: from, to

      displacement = minval(branch%minimum(mesh, :branch%points), &
                            branch%frequency(:branch%points) >= from .and. branch%frequency(:branch%points) <= to)
   end function smallest_between

   pure logical function has_fold(branch, frequency, tolerance)
      type(branch_type), intent(in) :: branch
      real(dp), intent(in) :: frequency, tolerance

      has_fold = folds_between(branch, frequency - tolerance, frequency + tolerance) > 0
   end function has_fold

   pure integer function folds_between(branch, from, to)
      type(branch_type), intent(in) :: branch
      real(dp), intent(in) :: from, to
      real(dp), allocatable :: found(:)

      found = folds(branch)
      folds_between = count(found >= from .and. found <= to)
   end function folds_between

   !> The branch has no stable motion between exactly these frequencies.
   pure logical function is_band(branch, from, to, tolerance)
      type(branch_type), intent(in) :: branch
      real(dp), intent(in) :: from, to, tolerance
      type(band_type), allocatable :: bands(:)

      bands = bands_without_stability(branch)
      is_band = any(abs(bands%from - from) < tolerance .and. abs(bands%to - to) < tolerance)
   end function is_band

   !> A stable motion of the branch exists at every frequency of a range.
   pure logical function stable_somewhere(branch, from, to)
      type(branch_type), intent(in) :: branch
      real(dp), intent(in) :: from, to
      type(band_type), allocatable :: bands(:)

      bands = bands_without_stability(branch)
      stable_somewhere = .not. any(bands%from < to .and. bands%to > from) &
                         .and. minval(branch%frequency(:branch%points)) <= from &
                         .and. maxval(branch%frequency(:branch%points)) >= to
   end function stable_somewhere

end module readings
