!> Pairs of settings at random: of a small case two variables, whichever the tables hold, are given a value at an end of its range,
!> a choice, or what is likely to upset a program. The case is checked as `--check` does and run as the executable does: what the
!> check passes must not be refused as bad input by the run, what it refuses the run must refuse in the same words, and what comes
!> out is made of numbers. Each run is interrupted after a while, as by Ctrl-C.
!>
!> settings [COUNT [SEED [FIRST [MILLISECONDS]]]]: the last line is '1 passed, 0 failed' where all went well. Case number n of a
!> seed is the same whatever comes before it; the numbers are told before each run, so that one that ends the program can be run
!> alone.
program settings
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_invalid, ieee_set_flag, ieee_set_halting_mode
   use, intrinsic :: iso_c_binding, only: c_funloc, c_int, c_intptr_t
   use, intrinsic :: iso_fortran_env, only: output_unit
   use alarm_clock, only: alarm_rang, alarm_flag, on_alarm
   use drawing, only: draw_case
   use geartrain, only: branch_type, case_text, case_type, error_type, interrupt_by, read_case_text, results_type, run_case, &
                        status_input
   use testing, only: number_argument
   implicit none (type, external)
   character(*), parameter :: newline = new_line('a')
   integer(c_int), parameter :: sigalrm = 14
   !> Time that a run is given [us].
   integer(c_int) :: patience
   integer :: failed, refused, interrupted, count, seed, first, i

   interface
      integer(c_intptr_t) function c_signal(number, handler) bind(c, name='signal')
         import :: c_int, c_intptr_t
         implicit none (type, external)
         integer(c_int), value :: number
         integer(c_intptr_t), value :: handler
      end function c_signal

      integer(c_int) function c_ualarm(microseconds, interval) bind(c, name='ualarm')
         import :: c_int
         implicit none (type, external)
         integer(c_int), value :: microseconds, interval
      end function c_ualarm
   end interface

   count = number_argument(1, 600)
   seed = number_argument(2, 1)
   first = number_argument(3, 1)
   patience = 1000*number_argument(4, 250)
   failed = 0
   refused = 0
   interrupted = 0
   ! What is interrupted leaves multipliers that are not numbers behind, and goes.
   call ieee_set_halting_mode(ieee_invalid, .false.)
   call set_handler()
   do i = first, first + count - 1
      write (output_unit, '(i0, 1x)', advance='no') i
      flush (output_unit)
      call try(seed, i)
   end do
   call ieee_set_flag(ieee_invalid, .false.)
   write (output_unit, '(/, 4(i0, a))') count, ' cases: ', refused, ' refused, ', interrupted, ' interrupted, ', failed, ' wrong'
   write (output_unit, '(a)') trim(merge('1 passed, 0 failed', '0 passed, 1 failed', failed == 0))
   if (failed > 0) stop 1, quiet=.true.

contains

   subroutine set_handler()
      integer(c_intptr_t) :: before

      before = c_signal(sigalrm, transfer(c_funloc(on_alarm), before))
   end subroutine set_handler

   !> Case number `number`.
   subroutine try(seed, number)
      integer, intent(in) :: seed, number
      type(case_type) :: case, read_back
      type(results_type) :: results
      type(error_type), allocatable :: checked, ran
      character(:), allocatable :: text
      integer(c_int) :: left

      call draw_case(seed, number, case)
      call case_text(case, text)
      call read_case_text(text, 'case.nml', read_back, checked)
      alarm_flag = 0
      case%train%interrupt = interrupt_by(alarm_flag)
      left = c_ualarm(patience, patience)
      call run_case(case, '', results, ran)
      left = c_ualarm(0_c_int, 0_c_int)
      if (allocated(checked)) refused = refused + 1
      if (alarm_rang()) interrupted = interrupted + 1
      if (allocated(ran)) then
         if (ran%status == status_input .and. .not. allocated(checked)) &
            call fail('the check passes what the run refuses: '//ran%message, number, case)
         if (ran%status == status_input .and. allocated(checked)) then
            if (.not. all_told(ran%message, checked%message)) &
               call fail('the check says "'//checked%message//'", the run "'//ran%message//'"', number, case)
         end if
      end if
      if (allocated(checked) .and. .not. alarm_rang()) then
         if (.not. allocated(ran)) then
            call fail('the check refuses what runs: '//checked%message, number, case)
         else if (ran%status /= status_input) then
            call fail('the check refuses "'//checked%message//'", the run ends with "'//ran%message//'"', number, case)
         end if
      end if
      if (allocated(results%response)) then
         if (.not. is_finite(results%response)) call fail('a response that is not made of numbers', number, case)
      end if
   end subroutine try

   !> Whether every line of a message is there in another, which begins its lines with places.
   logical function all_told(message, all_of_them)
      character(*), intent(in) :: message, all_of_them
      integer :: from, to

      all_told = .true.
      from = 1
      do while (from <= len(message) .and. all_told)
         to = index(message(from:), newline)
         if (to == 0) to = len(message) - from + 2
         all_told = index(all_of_them, message(from:from + to - 2)) > 0
         from = from + to
      end do
   end function all_told

   pure logical function is_finite(branch)
      type(branch_type), intent(in) :: branch

      is_finite = branch%points == 0
      if (is_finite) return
      associate (n => branch%points)
         is_finite = all(ieee_is_finite(branch%frequency_ratio(:n))) .and. all(ieee_is_finite(branch%coefficients(:, :, :n))) &
                     .and. all(ieee_is_finite(branch%rms(:, :n))) .and. all(ieee_is_finite(branch%error_estimate(:n)))
      end associate
   end function is_finite

   subroutine fail(why, number, case)
      character(*), intent(in) :: why
      integer, intent(in) :: number
      type(case_type), intent(in) :: case
      character(:), allocatable :: text

      failed = failed + 1
      call case_text(case, text)
      write (output_unit, '(/, a, i0, 4a)') 'FAILED: case ', number, ': ', why, newline, text
   end subroutine fail

end program settings
