!> What an audit of a branch gives: a row for each motion that shooting has solved anew, and how many are as the branch says.
module geartrain_analyses_audit_result
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: audit_type, audit_row_type, sum_up, within

   !> An estimate counts as right when the true error is within this factor of it.
   real(dp), parameter :: within = 3

   type :: audit_row_type
      !> 'point', or the kind of a special point.
      character(16) :: kind = 'point'
      !> Lambda as the branch has it; of the exact special point, negative for a point and where none was found.
      real(dp) :: frequency_ratio = 0, exact_frequency = -1
      !> Index of the point, or of the one before the special point (of a fold itself).
      integer :: point = 0
      !> Relative error of the waveform as estimated and as found; negative: none. Where the branch turns before the Lambda of the
      !> point, that against the fold.
      real(dp) :: estimate = -1, error = -1
      !> What neither can tell, relative: rounding.
      real(dp) :: rounding = 0
      !> The branch says that the estimate is doubtful.
      logical :: doubtful = .false.
      !> Stability as the branch has it and by shooting; of a special point the multipliers beyond the unit circle before it and
      !> after it; '' where not known.
      character(16) :: verdict = '', exact_verdict = ''
      !> What is wrong: with the estimate, with the verdict.
      logical :: estimate_wrong = .false., verdict_wrong = .false.
      !> In words; '' where all is as the branch says.
      character(80) :: finding = ''
   contains
      procedure :: ratio
   end type audit_row_type

   type :: audit_type
      !> Points first, then special points, each in the order of the branch.
      type(audit_row_type), allocatable :: rows(:)
      !> Points; those whose error is as estimated; others that the branch calls doubtful.
      integer :: points = 0, as_estimated = 0, doubtful = 0
      !> Special points; those that the exact branch has as well, or that rest on undecided points.
      integer :: special_points = 0, confirmed = 0
      !> Of points and special points.
      integer :: wrong_verdicts = 0
      !> All points are as estimated or doubtful, all special points confirmed, no verdict is wrong, and nothing was left out.
      logical :: ok = .false.
      !> The observer ended it: rows are missing.
      logical :: cancelled = .false.
   end type audit_type

contains

   !> True error over estimate; negative where one of them is not known.
   elemental real(dp) function ratio(self)
      class(audit_row_type), intent(in) :: self

      ratio = -1
      if (self%estimate < 0 .or. self%error < 0) return
      ratio = 1
      if (max(self%estimate, self%error) > self%rounding) ratio = (self%error + self%rounding)/(self%estimate + self%rounding)
   end function ratio

   !> Counts the rows.
   pure subroutine sum_up(audit)
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

   !> Whether the error is within the factor of the estimate.
   elemental logical function as_estimated(row)
      type(audit_row_type), intent(in) :: row

      as_estimated = row%ratio() > 1/within .and. row%ratio() < within
   end function as_estimated

end module geartrain_analyses_audit_result
