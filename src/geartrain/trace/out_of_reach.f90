!> Ends a branch early where teeth part and its motions are out of reach of the balance: mesh cycles that all differ have as many
!> nearly equal amplitudes, a point may take seconds, and what comes of it winds through folds that do not exist.
module geartrain_trace_out_of_reach
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_words, only: lambda, operator(//), words_type
   use geartrain_trace_branch, only: branch_type
   implicit none (type, external)
   private
   public :: find_out_of_reach

   !> Points in a long period that may miss the tolerance, in all and in a row; points in a long and in a short period that may have
   !> an estimate above `useless`.
   integer, parameter :: most_missed = 25, most_in_a_row = 15, most_useless = 5, most_useless_of_short = 20
   real(dp), parameter :: useless = 0.1_dp

contains

   !> Sets the reason for which the branch ends at its latest point; leaves it unallocated where the branch goes on.
   subroutine find_out_of_reach(branch, tolerance, long, reason)
      type(branch_type), intent(in) :: branch
      !> The tolerance [1].
      real(dp), intent(in) :: tolerance
      !> The period is long, as of hunting teeth.
      logical, intent(in) :: long
      !> The reason.
      type(words_type), allocatable, intent(out) :: reason
      !> Those of this segment: a trace from the other end may reach motions again.
      real(dp), allocatable :: estimate(:)
      real(dp) :: enough

      associate (n => branch%points)
         estimate = pack(branch%error_estimate(:n), branch%segment(:n) == branch%segment(n))
         if (count(estimate > useless) < merge(most_useless, most_useless_of_short, long) &
             .and. .not. (long .and. (count(estimate > tolerance) >= most_missed .or. in_a_row() >= most_in_a_row))) return
         ! Doubled until only a quarter of the estimates that miss the tolerance miss this one.
         enough = 2*tolerance
         do while (4*count(estimate > enough) > count(estimate > tolerance))
            enough = 2*enough
         end do
         reason = 'teeth part in mesh cycles that all differ, at '//lambda(branch%frequency_ratio(n))//': '
         if (enough < useless) reason = reason//'a tolerance of '//text(enough)//' is within reach; '
         reason = reason//'&integration follows such motions'
      end associate

   contains

      !> Latest points that all miss the tolerance.
      integer function in_a_row()
         in_a_row = size(estimate) - findloc(estimate <= tolerance, .true., 1, back=.true.)
      end function in_a_row

   end subroutine find_out_of_reach

end module geartrain_trace_out_of_reach
