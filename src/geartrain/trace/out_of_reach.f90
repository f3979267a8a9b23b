!> Ends a branch in a long period early where teeth part and its motions are out of reach of the balance: thousands of mesh cycles
!> that all differ have thousands of nearly equal amplitudes, and each point takes seconds.
module geartrain_trace_out_of_reach
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_words, only: lambda, operator(//), words_type
   implicit none (type, external)
   private
   public :: find_out_of_reach

   !> Points that may miss the tolerance, and points that may have an estimate above `useless`.
   integer, parameter :: most_missed = 40, most_useless = 5
   real(dp), parameter :: useless = 0.1_dp

contains

   !> Sets the reason for which the branch ends at its latest point; leaves it unallocated where the branch goes on.
   subroutine find_out_of_reach(estimate, missed, tolerance, frequency_ratio, reason)
      !> Error estimates of the points so far [1], (point); the tolerance [1].
      real(dp), intent(in) :: estimate(:), tolerance
      !> Number of points that miss the tolerance.
      integer, intent(in) :: missed
      !> Lambda of the latest point [1].
      real(dp), intent(in) :: frequency_ratio
      !> The reason.
      type(words_type), allocatable, intent(out) :: reason
      real(dp) :: enough

      if (missed < most_missed .and. count(estimate > useless) < most_useless) return
      ! Doubled until only a quarter of the estimates that miss the tolerance miss this one.
      enough = 2*tolerance
      do while (4*count(estimate > enough) > count(estimate > tolerance))
         enough = 2*enough
      end do
      reason = 'teeth part in hundreds of mesh cycles that all differ, at '//lambda(frequency_ratio)//': '
      if (enough < useless) reason = reason//'a tolerance of '//text(enough)//' is within reach; '
      reason = reason//'&integration follows such motions'
   end subroutine find_out_of_reach

end module geartrain_trace_out_of_reach
