!> Figures of a branch: peaks, folds, and ranges of Lambda without a stable motion.
module geartrain_readings_summary
   use geartrain_base_kinds, only: dp
   use geartrain_base_sorting, only: ascending
   use geartrain_linalg_cubic, only: value_on
   use geartrain_readings_curve, only: arc_between, arc_type
   use geartrain_trace_branch, only: branch_type
   use geartrain_trace_decided, only: is_undecided, joined
   implicit none (type, external)
   private
   public :: peak_type, band_type, peaks, folds, gaps, bands_without_stability, change

   !> Change of the rms that is rounding, relative [1].
   real(dp), parameter :: rounding = 1e-9_dp

   !> A local maximum of a mesh's rms along the branch.
   type :: peak_type
      !> Lambda and rms over characteristic length [1], on the cubic between two points; one of them is the peak as a rule.
      real(dp) :: frequency_ratio = 0, rms = 0
      !> Index of the nearest point.
      integer :: point = 0
      !> Whether this point is stable; whether `stable` is a guess.
      logical :: stable = .false., undecided = .false.
   end type peak_type

   !> A range of Lambda.
   type :: band_type
      !> Lower and upper end, Lambda [1].
      real(dp) :: from = 0, to = 0
      !> Whether the range follows from undecided points alone.
      logical :: undecided = .false.
   end type band_type

contains

   !> Local maxima of the rms of `mesh`, in the order of the branch.
   pure function peaks(branch, mesh) result(found)
      type(branch_type), intent(in) :: branch
      !> Number of the mesh.
      integer, intent(in) :: mesh
      type(peak_type), allocatable :: found(:)
      type(arc_type) :: arc
      real(dp) :: share
      integer :: i, point
      logical :: has_peak

      allocate (found(0))
      do i = 1, branch%points - 1
         if (.not. joined(branch, i)) cycle
         arc = arc_between(branch, mesh, i)
         call arc%peak(share, has_peak)
         if (.not. has_peak) cycle
         associate (height => value_on(arc%rms, arc%rms_slope, share))
            ! Over a parameter on which the motion does not depend rounding makes no peaks.
            if (height - minval(branch%rms(mesh, max(1, i - 1):min(branch%points, i + 2))) < rounding*height) cycle
            point = i + nint(share)
            found = [found, peak_type(value_on(arc%free, arc%free_slope, share), height, point, is_stable(branch, point), &
                                      is_undecided(branch, point))]
         end associate
      end do
   end function peaks

   !> Lambda of the folds, ascending.
   pure function folds(branch) result(frequency_ratio)
      type(branch_type), intent(in) :: branch
      real(dp), allocatable :: frequency_ratio(:)
      integer :: i

      allocate (frequency_ratio(0))
      if (.not. allocated(branch%special_points)) return
      do i = 1, size(branch%special_points)
         if (branch%special_points(i)%kind == 'fold') frequency_ratio = [frequency_ratio, branch%special_points(i)%frequency_ratio]
      end do
      frequency_ratio = frequency_ratio(ascending(frequency_ratio))
   end function folds

   !> Ranges of Lambda that the branch spans without a stable point at any of its levels, ascending; none where stability is not
   !> known. A range is undecided if it would vanish with every undecided point taken as stable.
   pure function bands_without_stability(branch) result(bands)
      type(branch_type), intent(in) :: branch
      type(band_type), allocatable :: bands(:), certain(:)
      integer :: i

      allocate (bands(0))
      if (.not. allocated(branch%stable) .or. branch%points < 2) return
      associate (n => branch%points)
         bands = bands_without(branch, branch%stable(:n))
         if (.not. allocated(branch%undecided)) return
         certain = bands_without(branch, branch%stable(:n) .or. branch%undecided(:n))
      end associate
      do i = 1, size(bands)
         bands(i)%undecided = .not. any(certain%from < bands(i)%to .and. certain%to > bands(i)%from)
      end do
   end function bands_without_stability

   !> Ranges of Lambda that the branch spans without a point that `stable`, (point), calls stable, ascending. Between two points
   !> stability changes at the Lambda that `change` gives.
   pure function bands_without(branch, stable) result(bands)
      type(branch_type), intent(in) :: branch
      logical, intent(in) :: stable(:)
      type(band_type), allocatable :: bands(:), between(:)
      real(dp), allocatable :: low(:), high(:)
      real(dp) :: first, last, edge, other
      integer :: i

      allocate (low(0), high(0))
      do i = 1, branch%points - 1
         if (.not. joined(branch, i)) cycle
         if (.not. (stable(i) .or. stable(i + 1))) cycle
         edge = branch%frequency_ratio(i + 1)
         if (stable(i) .neqv. stable(i + 1)) edge = change(branch, i)
         other = branch%frequency_ratio(i)
         if (.not. stable(i)) other = branch%frequency_ratio(i + 1)
         call add_range(low, high, min(edge, other), max(edge, other))
      end do
      ! With harmonics that changed on the way, an island closes at a Lambda slightly off that of its first point.
      if (branch%closed .and. stable(1) .and. stable(branch%points)) then
         low = [low, min(branch%frequency_ratio(1), branch%frequency_ratio(branch%points))]
         high = [high, max(branch%frequency_ratio(1), branch%frequency_ratio(branch%points))]
      end if
      ! Between segments that do not meet there are no points: the range counts as neither stable nor unstable.
      between = gaps(branch)
      low = [low, between%from]
      high = [high, between%to]
      first = minval(branch%frequency_ratio(:branch%points))
      last = maxval(branch%frequency_ratio(:branch%points))
      bands = uncovered(low, high, first, last, 1e-9_dp*(last - first))
   end function bands_without

   !> Ranges of `first` to `last`, longer than `slack`, that none of the ranges `low` to `high` covers, ascending.
   pure function uncovered(low, high, first, last, slack) result(bands)
      real(dp), intent(in) :: low(:), high(:), first, last, slack
      type(band_type), allocatable :: bands(:)
      logical :: left(size(low))
      real(dp) :: reached
      integer :: i, lowest

      allocate (bands(0))
      left = .true.
      reached = first
      do i = 1, size(low)
         lowest = minloc(low, dim=1, mask=left)
         if (low(lowest) > reached + slack) bands = [bands, band_type(reached, low(lowest))]
         reached = max(reached, high(lowest))
         left(lowest) = .false.
      end do
      if (last > reached + slack) bands = [bands, band_type(reached, last)]
   end function uncovered

   !> Adds a range to a list, or enlarges the last range of the list if both overlap, as ranges along a branch do as a rule.
   pure subroutine add_range(low, high, from, to)
      real(dp), allocatable, intent(inout) :: low(:), high(:)
      real(dp), intent(in) :: from, to
      integer :: n

      n = size(low)
      if (n > 0) then
         if (from <= high(n) .and. to >= low(n)) then
            low(n) = min(low(n), from)
            high(n) = max(high(n), to)
            return
         end if
      end if
      low = [low, from]
      high = [high, to]
   end subroutine add_range

   !> Ranges of Lambda between the segments of a branch, which no segment spans, ascending; within a range, if one is given, which
   !> may be longer than the branch.
   pure function gaps(branch, range) result(between)
      !> A branch with points.
      type(branch_type), intent(in) :: branch
      !> Both ends of the range, Lambda [1].
      real(dp), intent(in), optional :: range(2)
      type(band_type), allocatable :: between(:)
      real(dp), allocatable :: low(:), high(:)
      integer :: first, last

      allocate (between(0), low(0), high(0))
      if (.not. allocated(branch%segment)) return
      first = 1
      do while (first <= branch%points)
         last = first
         do while (last < branch%points)
            if (.not. joined(branch, last)) exit
            last = last + 1
         end do
         low = [low, minval(branch%frequency_ratio(first:last))]
         high = [high, maxval(branch%frequency_ratio(first:last))]
         first = last + 1
      end do
      if (present(range)) then
         between = uncovered(low, high, minval(range), maxval(range), 1e-9_dp*maxval(range))
      else
         between = uncovered(low, high, minval(low), maxval(high), 0.0_dp)
      end if
   end function gaps

   !> Lambda at which stability changes between points i and i + 1: at a special point between them, or a fold that is one of them,
   !> else halfway.
   pure real(dp) function change(branch, i)
      type(branch_type), intent(in) :: branch
      !> Index of the first of the two points.
      integer, intent(in) :: i
      integer :: j

      change = (branch%frequency_ratio(i) + branch%frequency_ratio(i + 1))/2
      if (.not. allocated(branch%special_points)) return
      ! Where two segments meet, the point at which both change is listed with one of them.
      associate (from => minval(branch%frequency_ratio(i:i + 1)), to => maxval(branch%frequency_ratio(i:i + 1)))
         do j = 1, size(branch%special_points)
            associate (special => branch%special_points(j))
               if (special%kind == 'branch point' .and. special%frequency_ratio > from .and. special%frequency_ratio < to) &
                  change = special%frequency_ratio
            end associate
         end do
      end associate
      do j = 1, size(branch%special_points)
         associate (special => branch%special_points(j))
            if (special%point == i + 1 .and. special%kind == 'fold') change = special%frequency_ratio
         end associate
      end do
      do j = 1, size(branch%special_points)
         if (branch%special_points(j)%point == i) change = branch%special_points(j)%frequency_ratio
      end do
   end function change

   pure logical function is_stable(branch, i)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: i

      is_stable = .false.
      if (allocated(branch%stable)) is_stable = branch%stable(i)
   end function is_stable

end module geartrain_readings_summary
