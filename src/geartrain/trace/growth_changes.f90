!> Locates where the motions of a branch of long period become stable or unstable between two neighbouring points: where their
!> growth rate passes 0. At a fold, which the balance locates more exactly, that is no further special point.
module geartrain_trace_growth_changes
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_balance_whole_contacts, only: find_whole_contacts
   use geartrain_base_kinds, only: dp
   use geartrain_floquet_growth, only: find_growth, growth_type
   use geartrain_floquet_monodromy, only: monodromy_type
   use geartrain_floquet_motion_contacts, only: motion_contacts_type
   use geartrain_linalg_bracket, only: between, shrink
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_trace_branch, only: branch_type
   use geartrain_trace_corrector, only: corrector_type, solution_point_type
   use geartrain_trace_special_points, only: add_special_point, rms_of
   use geartrain_trace_step_geometry, only: arc_length, go_along
   implicit none (type, external)
   private
   public :: add_growth_change

   !> Width of the bracket of a change, as a share of the step, and the most motions that are tried.
   real(dp), parameter :: located = 1e-6_dp
   !> Error of the rates there over the change of the rate within the step.
   real(dp), parameter :: rate_share = 1e-4_dp
   integer, parameter :: most_steps = 30

contains

   !> Lists the change of stability between two neighbouring points of a branch, if any, as a special point.
   subroutine add_growth_change(corrector, monodromy, here, next, before, after, branch)
      type(corrector_type), intent(inout) :: corrector
      !> Work space, set up for the system.
      type(monodromy_type), intent(inout) :: monodromy
      !> The two points with their tangents.
      type(solution_point_type), intent(in) :: here, next
      !> Numbers of the two points; the special point is listed after point `after` - 1.
      integer, intent(in) :: before, after
      !> Branch with the growth rates of both points; its `special_points` may grow.
      type(branch_type), intent(inout), target :: branch
      type(solution_point_type) :: solution
      type(growth_type) :: growth
      type(motion_contacts_type) :: whole
      type(transform_type) :: transform
      real(dp) :: length, a, b, fa, fb, s, enough
      integer(int64) :: began, now, rate
      integer :: i, kept
      logical :: success

      if (branch%stable(before) .eqv. branch%stable(after)) return
      if (any(branch%special_points%kind == 'fold' .and. &
              branch%special_points%point >= before .and. branch%special_points%point <= after)) return
      length = arc_length(here, next, corrector%units)
      a = 0
      b = length
      fa = branch%growth_rate(before)
      fb = branch%growth_rate(after)
      if ((fa > 0) .eqv. (fb > 0)) return
      call system_clock(began, rate)
      kept = 0
      solution = next
      enough = rate_share*abs(fb - fa)/corrector%balance%system%characteristic_frequency
      do i = 1, most_steps
         s = between(a, b, fa, fb)
         solution = here
         call go_along(here, next, s/length, corrector%units, solution)
         call corrector%correct(solution, success)
         if (.not. success) exit
         call find_rate()
         ! Interrupted: the step is repeated by the run that goes on.
         if (ieee_is_nan(growth%rate)) return
         call shrink(a, b, fa, fb, s, growth%rate*corrector%balance%system%characteristic_frequency, kept)
         if (b - a < located*length .or. abs(growth%rate) < growth%error) exit
      end do
      call add_special_point(branch, 'stability change', solution%frequency_ratio, after - 1, rms_of(corrector, solution), &
                             arclength=branch%arclength(before) + s)
      call system_clock(now)
      branch%verdict_seconds = branch%verdict_seconds + real(now - began, dp)/real(rate, dp)

   contains

      subroutine find_rate()
         associate (balance => corrector%balance)
            if (balance%is_wound()) then
               call find_whole_contacts(balance, solution%u, transform, whole)
               call find_growth(monodromy, whole, balance%frequency_ratio, growth, enough=enough)
            else
               call find_growth(monodromy, balance, balance%frequency_ratio, growth, enough=enough)
            end if
         end associate
      end subroutine find_rate

   end subroutine add_growth_change

end module geartrain_trace_growth_changes
