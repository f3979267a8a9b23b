!> Checks that count themselves, in tests that can be chosen by name. What a test finds goes to the runner through a pipe as it is
!> found, so that a crash loses nothing of what came before it.
module testing
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_size_t
   use, intrinsic :: iso_fortran_env, only: compiler_options, output_unit
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: full, nightly, number_argument, quick, scratch, suite_type, tests_type, tier_names, time_limit
   public :: test_begins, check_passed, check_failed, suite_ended

   !> Time that a test may take [s], a hang apart from the slowest debug build under valgrind.
   integer, parameter :: time_limit = 1800
   !> Tiers: what a newcomer runs, what each change runs beside, what runs by night.
   integer, parameter :: quick = 1, full = 2, nightly = 3
   character(*), parameter :: tier_names(*) = [character(7) :: 'quick', 'full', 'nightly']
   !> Of a repetition, the share that runs where the tier `nightly` does not.
   integer, parameter :: by_day = 10
   !> How names of files of tests begin: debug and release tests may run at the same time.
   character(*), parameter :: scratch = merge('build/checked-', 'build/release-', index(compiler_options(), '-fcheck') > 0)
   !> What the runner is told; the name of a test follows `test_begins` and ends with a line feed.
   character, parameter :: test_begins = 't', check_passed = '+', check_failed = '-', suite_ended = '.'

   !> The tests of a suite while they run.
   type :: tests_type
      character(40) :: suite = '', test = ''
      !> Parts of the names of the tests that are wanted; empty: all are.
      character(40), allocatable :: wanted(:)
      !> Tests that were begun or passed over; how many to pass over as they ran before.
      integer :: begun = 0, done_before = 0
      !> Tell the names alone.
      logical :: listing = .false.
      !> Print a row for each comparison of a hard case.
      logical :: table = .false.
      !> Tiers that are wanted, (tier).
      logical :: tier(3) = [.true., .true., .false.]
      !> Number of the random trains, starts and so on that the random suites draw: 0, 1, ...
      integer :: seed = 0
      !> Folder in whose files, one a test, each comparison gets a line (scripts/arithmetic); blank: none.
      character(200) :: record = ''
      !> Where the runner listens: the writing end of a pipe.
      integer(c_int) :: pipe = -1
   contains
      procedure :: runs
      procedure :: times
      procedure :: is_true
      procedure :: is_close
      procedure :: is_text
      procedure :: heading
      procedure :: measured
      procedure :: holds
      procedure :: tell
   end type tests_type

   abstract interface
      !> Runs each test of a suite that `tests%runs` asks for.
      subroutine suite_interface(tests)
         import :: tests_type
         implicit none (type, external)
         class(tests_type), intent(inout) :: tests
      end subroutine suite_interface
   end interface

   !> A suite is a module; its name begins with its kind: unit, validation or hard.
   type :: suite_type
      character(40) :: name
      procedure(suite_interface), pointer, nopass :: run
   end type suite_type

   interface
      integer(c_size_t) function c_write(file, text, length) bind(c, name='write')
         import :: c_char, c_int, c_size_t
         implicit none (type, external)
         integer(c_int), value :: file
         character(kind=c_char), intent(in) :: text(*)
         integer(c_size_t), value :: length
      end function c_write

      integer(c_int) function c_alarm(seconds) bind(c, name='alarm')
         import :: c_int
         implicit none (type, external)
         integer(c_int), value :: seconds
      end function c_alarm
   end interface

contains

   !> Whether the test of this name is to run now. A suite asks once for each of its tests; every check belongs to one.
   logical function runs(self, name, tier)
      class(tests_type), intent(inout) :: self
      character(*), intent(in) :: name
      !> Tier of the test; absent: `quick`.
      integer, intent(in), optional :: tier
      integer :: i
      integer(c_int) :: left

      runs = self%tier(quick)
      if (present(tier)) runs = self%tier(tier)
      if (size(self%wanted) > 0) runs = any([(index(name, trim(self%wanted(i))) > 0, i=1, size(self%wanted))])
      if (.not. runs) return
      self%begun = self%begun + 1
      runs = self%begun > self%done_before
      if (.not. runs) return
      self%test = name
      call self%tell(test_begins//name//new_line('a'))
      runs = .not. self%listing
      if (runs) left = c_alarm(int(time_limit, c_int))
   end function runs

   !> How often a test whose cost is repetition repeats what it does.
   pure integer function times(self, all_of_them)
      class(tests_type), intent(in) :: self
      !> Repetitions of the tier `nightly`, of which the others run a tenth.
      integer, intent(in) :: all_of_them

      times = all_of_them
      if (.not. self%tier(nightly)) times = ceiling(real(all_of_them, dp)/by_day)
   end function times

   subroutine is_true(self, claim, name)
      class(tests_type), intent(inout) :: self
      logical, intent(in) :: claim
      character(*), intent(in) :: name

      call self%tell(merge(check_passed, check_failed, claim))
      if (.not. claim) write (output_unit, '(6a)') 'FAILED ', trim(self%suite), '/', trim(self%test), ': ', name
   end subroutine is_true

   !> |value - expected| <= tolerance; NaN fails.
   subroutine is_close(self, value, expected, tolerance, name)
      class(tests_type), intent(inout) :: self
      real(dp), intent(in) :: value, expected, tolerance
      character(*), intent(in) :: name
      character(160) :: text

      write (text, '(a, es23.15, a, es23.15, a, es9.2, a, es9.2)') ': got', value, ', expected', expected, ', off by', &
         abs(value - expected), ', allowed', tolerance
      if (self%record /= '' .and. tolerance > 0) call put_on_record(self, value - expected, tolerance, name)
      call self%is_true(abs(value - expected) <= tolerance, name//trim(text))
   end subroutine is_close

   !> Adds a comparison to the record: difference, allowed difference, test and check.
   subroutine put_on_record(self, difference, tolerance, name)
      class(tests_type), intent(in) :: self
      real(dp), intent(in) :: difference, tolerance
      character(*), intent(in) :: name
      integer :: unit

      open (newunit=unit, file=trim(self%record)//'/'//trim(self%suite)//'.'//trim(self%test), position='append', action='write')
      write (unit, '(es23.15e3, es10.2e3, 5a)') difference, tolerance, ' ', trim(self%suite), '/', trim(self%test)//': ', name
      close (unit)
   end subroutine put_on_record

   subroutine is_text(self, value, expected, name)
      class(tests_type), intent(inout) :: self
      character(*), intent(in) :: value, expected, name

      call self%is_true(value == expected, name//': got "'//value//'", expected "'//expected//'"')
   end subroutine is_text

   !> Begins a table of comparisons: what is hard, what it is checked against, how far off it is and how far it may be.
   subroutine heading(self, title)
      class(tests_type), intent(in) :: self
      character(*), intent(in) :: title

      if (self%table) write (output_unit, '(/a//a/a)') '### '//title, '| hard case | checked against | off by | allowed |', &
         '|---|---|---|---|'
   end subroutine heading

   !> A hard case whose difference from the second method is measured.
   subroutine measured(self, what, against, difference, allowed)
      class(tests_type), intent(inout) :: self
      character(*), intent(in) :: what, against
      real(dp), intent(in) :: difference, allowed
      character(12) :: is, may

      call self%is_close(difference, 0.0_dp, allowed, what//', '//against)
      if (.not. self%table) return
      write (is, '(es8.1)') difference
      write (may, '(es8.0)') allowed
      write (output_unit, '(9a)') '| ', what, ' | ', against, ' | ', trim(adjustl(is)), ' | ', trim(adjustl(may)), ' |'
   end subroutine measured

   !> A hard case that holds or does not.
   subroutine holds(self, what, against, claim)
      class(tests_type), intent(inout) :: self
      character(*), intent(in) :: what, against
      logical, intent(in) :: claim

      call self%is_true(claim, what//', '//against)
      if (self%table) write (output_unit, '(5a)') '| ', what, ' | ', against, ' | '//merge('holds', 'FAILS', claim)//' | |'
   end subroutine holds

   !> Tells the runner.
   subroutine tell(self, text)
      class(tests_type), intent(in) :: self
      character(*), intent(in) :: text

      if (c_write(self%pipe, text, len(text, c_size_t)) /= len(text)) error stop 'the runner of the tests does not listen'
   end subroutine tell

   !> A whole number among the arguments of a program without suites; `default` where there is none. A word there is the name of
   !> a test of another program: there is nothing to do.
   integer function number_argument(place, default) result(number)
      integer, intent(in) :: place, default
      character(24) :: word
      integer :: status

      number = default
      call get_command_argument(place, word)
      if (word == '') return
      read (word, *, iostat=status) number
      if (status == 0) return
      write (output_unit, '(a)') '0 passed, 0 failed'
      stop
   end function number_argument

end module testing
