!> The result of an audit of a branch: a row for each motion that shooting solved anew, and how many rows agree with the branch.
module geartrain_exact_audit_result
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: audit_type, audit_row_type, sum_up, within

   !> An estimate counts as right when the true error is within this factor of it.
   real(dp), parameter :: within = 3

   !> A point or a special point of the branch beside the exact branch.
   type :: audit_row_type
      !> 'point', or the kind of a special point.
      character(24) :: kind = 'point'
      !> Lambda of the point or special point of the branch; Lambda of the special point of the exact branch, negative for a point
      !> and where no special point was found.
      real(dp) :: frequency_ratio = 0, exact_frequency = -1
      !> Index of the point; of a special point the index of the point before it, of a fold the point itself.
      integer :: point = 0
      !> Relative error of the waveform [1] as estimated and as found; negative: none. Where the exact branch turns before the
      !> Lambda of the point, the distance to its fold.
      real(dp) :: estimate = -1, error = -1
      !> Rounding error of the waveform [1], relative.
      real(dp) :: rounding = 0
      !> Whether the branch calls the estimate doubtful.
      logical :: doubtful = .false.
      !> Stability according to the branch and to shooting; of a special point the numbers of multipliers outside the unit circle
      !> before and after it; '': not known.
      character(16) :: verdict = '', exact_verdict = ''
      !> Whether the estimate is wrong; whether shooting contradicts the stability of the branch.
      logical :: estimate_wrong = .false., verdict_wrong = .false.
      !> What is wrong or worth knowing, in words; '': all is as the branch says.
      character(80) :: finding = ''
   contains
      procedure :: ratio
   end type audit_row_type

   !> The rows of an audit and their sums.
   type :: audit_type
      !> Points first, then special points, each in the order of the branch.
      type(audit_row_type), allocatable :: rows(:)
      !> Numbers of points, of points whose error is as estimated, and of other points that the branch calls doubtful.
      integer :: points = 0, as_estimated = 0, doubtful = 0
      !> Numbers of special points, and of special points that the exact branch has as well or that rest on undecided points.
      integer :: special_points = 0, confirmed = 0
      !> Number of points and special points whose stability shooting contradicts.
      integer :: wrong_verdicts = 0
      !> All points are as estimated or doubtful, all special points confirmed, no stability is wrong, and no row is missing.
      logical :: ok = .false.
      !> The observer ended the audit: rows are missing.
      logical :: cancelled = .false.
   end type audit_type

contains

   !> True error over estimate [1]; negative where the error or the estimate is not known.
   elemental real(dp) function ratio(self)
      class(audit_row_type), intent(in) :: self

      ratio = -1
      if (self%estimate < 0 .or. self%error < 0) return
      ratio = 1
      if (max(self%estimate, self%error) > self%rounding) ratio = (self%error + self%rounding)/(self%estimate + self%rounding)
   end function ratio

   !> Counts the rows.
   pure subroutine sum_up(audit)
      !> The audit; `rows` and `cancelled` are given.
      type(audit_type), intent(inout) :: audit

      associate (rows => audit%rows, is_point => audit%rows%kind == 'point')
         audit%points = count(is_point)
         audit%doubtful = count(is_point .and. rows%doubtful .and. .not. as_estimated(rows))
         audit%as_estimated = count(is_point .and. as_estimated(rows))
         audit%special_points = count(.not. is_point)
         audit%confirmed = count(.not. (is_point .or. rows%estimate_wrong .or. rows%verdict_wrong))
         audit%wrong_verdicts = count(rows%verdict_wrong)
         audit%ok = .not. (audit%cancelled .or. any(rows%estimate_wrong .or. rows%verdict_wrong))
      end associate
   end subroutine sum_up

   !> Whether the error is as estimated, up to the factor `within`.
   elemental logical function as_estimated(row)
      type(audit_row_type), intent(in) :: row

      as_estimated = row%ratio() > 1/within .and. row%ratio() < within
   end function as_estimated

end module geartrain_exact_audit_result
