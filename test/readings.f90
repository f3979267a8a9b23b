!> Motions and curves as tests ask for them, and what one reads off a curve of the paper with a ruler: the largest peak in a range,
!> the smallest displacement, a fold.
module readings
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use fixtures, only: settings_of
   use geartrain, only: branch_type, dp, error_type, motion_type, response, response_settings_type, solutions_at, train_type
   use geartrain_base_kinds, only: pi
   use geartrain_flow_flow, only: flow_type
   use geartrain_network_system, only: system_type
   use geartrain_readings_summary, only: band_type, bands_without_stability, folds, peak_type, peaks
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: nearest_approach, solution, solve, traced
   public :: peak_between, largest_between, smallest_between, has_fold, folds_between, is_band, stable_somewhere

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
         if (found(i)%frequency_ratio < from .or. found(i)%frequency_ratio > to .or. found(i)%rms <= peak%rms) cycle
         peak = found(i)
      end do
   end function peak_between

   !> Largest rms of a mesh between two frequencies, at any level of the branch.
   pure real(dp) function largest_between(branch, mesh, from, to) result(rms)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: mesh
      real(dp), intent(in) :: from, to

      rms = maxval(branch%rms(mesh, :branch%points), &
                   branch%frequency_ratio(:branch%points) >= from .and. branch%frequency_ratio(:branch%points) <= to)
   end function largest_between

   !> Smallest displacement of a mesh between two frequencies: below 1 it separates, below -1 its back flanks collide.
   pure real(dp) function smallest_between(branch, mesh, from, to) result(displacement)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: mesh
      real(dp), intent(in) :: from, to

      displacement = minval(branch%minimum(mesh, :branch%points), &
                            branch%frequency_ratio(:branch%points) >= from .and. branch%frequency_ratio(:branch%points) <= to)
   end function smallest_between

   pure logical function has_fold(branch, frequency_ratio, tolerance)
      type(branch_type), intent(in) :: branch
      real(dp), intent(in) :: frequency_ratio, tolerance

      has_fold = folds_between(branch, frequency_ratio - tolerance, frequency_ratio + tolerance) > 0
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
                         .and. minval(branch%frequency_ratio(:branch%points)) <= from &
                         .and. maxval(branch%frequency_ratio(:branch%points)) >= to
   end function stable_somewhere

   !> The response of a train; empty where the input was refused.
   function solve(train, settings) result(branch)
      type(train_type), intent(in) :: train
      type(response_settings_type), intent(in) :: settings
      type(branch_type) :: branch
      type(error_type), allocatable :: error

      call response(train, settings, branch, error)
   end function solve

   !> The only motion of a train at a frequency, by the balance; its rms is NaN, which no tolerance allows, where there is not
   !> exactly one.
   function solution(train, settings) result(motion)
      type(train_type), intent(in) :: train
      !> A short range that begins at the frequency.
      type(response_settings_type), intent(in) :: settings
      type(motion_type) :: motion
      type(branch_type) :: branch
      type(motion_type), allocatable :: motions(:)
      type(error_type), allocatable :: error

      allocate (motions(0))
      branch = solve(train, settings)
      if (branch%points > 0) call solutions_at(train, settings, branch, settings%start, motions, error)
      if (size(motions) == 1) then
         motion = motions(1)
      else
         allocate (motion%rms(size(train%meshes)), source=ieee_value(1.0_dp, ieee_quiet_nan))
         motion%mean = motion%rms
      end if
   end function solution

   !> How near the flow from a state comes to a motion within some periods of the fundamental, over how far it was: by nothing but
   !> integration. Ends where it is near enough.
   real(dp) function nearest_approach(system, start, motion, enough, periods) result(nearest)
      type(system_type), target, intent(in) :: system
      !> (2*elements) at phase 0.
      real(dp), intent(in) :: start(:)
      type(motion_type), intent(in) :: motion
      real(dp), intent(in) :: enough
      integer, intent(in) :: periods
      type(flow_type) :: flow
      integer :: k

      call flow%setup(system, 1, 20, 1e-15_dp)
      flow%x(1, :) = start
      nearest = 1
      do k = 1, periods
         call flow%start(motion%frequency_ratio, 0.0_dp)
         call flow%advance(2*pi/motion%frequency_ratio)
         nearest = min(nearest, maxval(abs(flow%x(1, :) - motion%state))/maxval(abs(start - motion%state)))
         if (nearest <= enough) return
      end do
   end function nearest_approach

end module readings
