!> Chooses tests by the arguments of the program and runs each suite in a process of its own. A test that ends its process (a
!> floating-point exception, a segmentation fault, a stop, a hang) is one failure; the tests after it run in another process.
module runner
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_size_t
   use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit
   use geartrain_base_kinds, only: dp
   use geartrain_base_nearest, only: nearest_name
   use geartrain_linalg_openblas, only: blas_kernels, blas_threads
   use testing, only: check_failed, check_passed, suite_ended, suite_type, test_begins, tests_type, tier_names, &
      time_limit
   implicit none (type, external)
   private
   public :: run_suites

   !> What was found so far.
   type :: findings_type
      integer :: passed = 0, failed = 0
      !> Names of the tests of the present suite that were begun.
      character(40), allocatable :: tests(:)
      !> The present suite came to its end.
      logical :: ended = .false.
   end type findings_type

   interface
      integer(c_int) function c_fork() bind(c, name='fork')
         import :: c_int
         implicit none (type, external)
      end function c_fork

      integer(c_int) function c_pipe(ends) bind(c, name='pipe')
         import :: c_int
         implicit none (type, external)
         integer(c_int), intent(out) :: ends(2)
      end function c_pipe

      integer(c_int) function c_close(file) bind(c, name='close')
         import :: c_int
         implicit none (type, external)
         integer(c_int), value :: file
      end function c_close

      integer(c_size_t) function c_read(file, text, length) bind(c, name='read')
         import :: c_char, c_int, c_size_t
         implicit none (type, external)
         integer(c_int), value :: file
         character(kind=c_char), intent(inout) :: text(*)
         integer(c_size_t), value :: length
      end function c_read

      integer(c_int) function c_waitpid(process, status, options) bind(c, name='waitpid')
         import :: c_int
         implicit none (type, external)
         integer(c_int), value :: process, options
         integer(c_int), intent(out) :: status
      end function c_waitpid
   end interface

contains

   !> Runs what the arguments name, everything where they name nothing: a kind (unit), a suite (unit_flow, or flow, whatever its
   !> kind), tests of a suite by a part of their names (flow/tang). Options: --tier=quick,full,nightly, those tiers, of a test that
   !> is named any (default: quick,full); --list, names of tests alone; --suites, of suites alone; --table,
   !> a row for each comparison of a hard case; --seed=N, other random trains; --record=FOLDER, adds each comparison to a file of
   !> its test: difference, allowed difference, name.
   subroutine run_suites(suites)
      type(suite_type), intent(in) :: suites(:)
      type(tests_type) :: tests
      type(findings_type) :: findings
      character(80), allocatable :: arguments(:)
      character(240) :: argument
      real(dp), allocatable :: seconds(:)
      integer :: before, i, j
      logical :: names_alone

      call blas_kernels()
      before = blas_threads(1)
      names_alone = .false.
      allocate (arguments(0))
      do i = 1, command_argument_count()
         call get_command_argument(i, argument)
         select case (argument(:scan(trim(argument)//'=', '=') - 1))
         case ('--list')
            tests%listing = .true.
         case ('--suites')
            names_alone = .true.
         case ('--table')
            tests%table = .true.
         case ('--tier')
            tests%tier = tiers_in(argument(8:))
         case ('--seed')
            read (argument(8:), *) tests%seed
         case ('--record')
            tests%record = argument(10:)
         case default
            arguments = [character(80) :: arguments, argument]
         end select
      end do
      do i = 1, size(arguments)
         call check_argument(suites, arguments(i))
      end do
      allocate (seconds(size(suites)), source=-1.0_dp)
      do i = 1, size(suites)
         if (size(arguments) > 0 .and. .not. any(is_in(suites(i), arguments))) cycle
         if (names_alone) then
            write (output_unit, '(a)') trim(suites(i)%name)
            cycle
         end if
         seconds(i) = -wall_time()
         tests%wanted = wanted_of(suites(i), arguments)
         call run_suite(suites(i), tests, findings)
         if (tests%listing) write (output_unit, '(3a)') (trim(suites(i)%name), '/', trim(findings%tests(j)), &
                                                         j=1, size(findings%tests))
         seconds(i) = seconds(i) + wall_time()
      end do
      if (names_alone) return
      do while (.not. tests%listing .and. any(seconds >= 0))
         i = maxloc(seconds, 1)
         write (output_unit, '(f8.1, 2a)') seconds(i), ' s  ', trim(suites(i)%name)
         seconds(i) = -1
      end do
      if (.not. tests%listing) write (output_unit, '(i0, a, i0, a)') findings%passed, ' passed, ', findings%failed, ' failed'
      if (findings%failed > 0) stop 1, quiet=.true.
      if (findings%passed == 0 .and. size(arguments) == 0 .and. .not. tests%listing) stop 1, quiet=.true.
   end subroutine run_suites

   !> Tiers that a list with commas names; ends the program at a word that is none.
   function tiers_in(list) result(tier)
      character(*), intent(in) :: list
      logical :: tier(size(tier_names))
      integer :: first, last

      tier = .false.
      first = 1
      do while (first <= len_trim(list))
         last = first + scan(list(first:)//',', ',') - 2
         if (.not. any(tier_names == list(first:last))) then
            write (error_unit, '(3a, *(1x, a))') 'error: "', list(first:last), '" is no tier of tests; there are', tier_names
            stop 1, quiet=.true.
         end if
         tier = tier .or. tier_names == list(first:last)
         first = last + 2
      end do
   end function tiers_in

   !> Time from some beginning [s].
   real(dp) function wall_time()
      integer(int64) :: now, rate

      call system_clock(now, rate)
      wall_time = real(now, dp)/real(rate, dp)
   end function wall_time

   !> Whether an argument names the suite, its kind or tests of it.
   elemental logical function is_in(suite, argument)
      type(suite_type), intent(in) :: suite
      character(*), intent(in) :: argument
      integer :: underscore

      underscore = index(suite%name, '_')
      associate (name => argument(:scan(argument//'/', '/') - 1))
         is_in = name == suite%name .or. name == suite%name(underscore + 1:) .or. argument == suite%name(:underscore - 1)
      end associate
   end function is_in

   !> The parts of names of tests that the arguments ask for in a suite; none: all of its tests.
   pure function wanted_of(suite, arguments) result(parts)
      type(suite_type), intent(in) :: suite
      character(*), intent(in) :: arguments(:)
      character(40), allocatable :: parts(:)
      integer :: i, slash

      allocate (parts(0))
      do i = 1, size(arguments)
         if (.not. is_in(suite, arguments(i))) cycle
         slash = index(arguments(i), '/')
         if (slash == 0) then
            parts = parts(:0)
            return
         end if
         parts = [character(40) :: parts, arguments(i)(slash + 1:)]
      end do
   end function wanted_of

   !> Ends the program where an argument names nothing, and says what there is.
   subroutine check_argument(suites, argument)
      type(suite_type), intent(in) :: suites(:)
      character(*), intent(in) :: argument
      type(tests_type) :: tests
      type(findings_type) :: findings
      character(40), allocatable :: names(:)
      integer :: i, j, slash, near
      logical :: known

      slash = scan(trim(argument)//'/', '/')
      if (.not. any(is_in(suites, argument))) then
         names = [character(40) :: 'unit', 'validation', 'hard', suites%name, &
                  (suites(i)%name(index(suites(i)%name, '_') + 1:), i=1, size(suites))]
         near = nearest_name(argument(:slash - 1), names)
         write (error_unit, '(3a)', advance='no') 'error: no suite of tests is named "', argument(:slash - 1), '"'
         if (near > 0) write (error_unit, '(3a)', advance='no') ' (did you mean "', trim(names(near)), '"?)'
         write (error_unit, '(a)') '; there are'
         write (error_unit, '(3x, a)') (trim(names(i)), i=1, size(suites) + 3)
         stop 1, quiet=.true.
      end if
      if (slash > len_trim(argument)) return
      tests%listing = .true.
      allocate (tests%wanted(0), names(0))
      known = .false.
      do i = 1, size(suites)
         if (.not. is_in(suites(i), argument)) cycle
         call run_suite(suites(i), tests, findings)
         names = [character(40) :: names, findings%tests]
         known = known .or. any([(index(findings%tests(j), trim(argument(slash + 1:))) > 0, j=1, size(findings%tests))])
      end do
      if (known) return
      write (error_unit, '(5a)') 'error: no test of ', argument(:slash - 1), ' has "', trim(argument(slash + 1:)), &
         '" in its name; there are'
      write (error_unit, '(3x, a)') (trim(names(i)), i=1, size(names))
      stop 1, quiet=.true.
   end subroutine check_argument

   !> Runs a suite, again where it ended before its time, without the tests that were begun.
   subroutine run_suite(suite, tests, findings)
      type(suite_type), intent(in) :: suite
      type(tests_type), intent(inout) :: tests
      type(findings_type), intent(inout) :: findings
      character(80) :: how
      integer(c_int) :: status

      tests%suite = suite%name
      tests%begun = 0
      tests%done_before = 0
      findings%tests = [character(40) ::]
      do
         call run_in_a_process(suite, tests, findings, status)
         if (findings%ended .and. status == 0) return
         findings%failed = findings%failed + 1
         how = ending(status)
         if (findings%ended) then
            write (output_unit, '(4a)') 'FAILED ', trim(suite%name), ': after its tests it ', trim(how)
            return
         else if (size(findings%tests) == tests%done_before) then
            write (output_unit, '(4a)') 'FAILED ', trim(suite%name), ': outside its tests it ', trim(how)
            return
         end if
         tests%done_before = size(findings%tests)
         write (output_unit, '(6a)') 'FAILED ', trim(suite%name), '/', trim(findings%tests(tests%done_before)), ': ', trim(how)
      end do
   end subroutine run_suite

   !> What a status of waitpid says.
   function ending(status) result(text)
      integer(c_int), intent(in) :: status
      character(80) :: text
      integer :: signal

      signal = iand(status, 127)
      select case (signal)
      case (0)
         write (text, '(a, i0)') 'ended with exit status ', iand(ishft(status, -8), 255)
      case (8)
         text = 'ended by a floating-point exception'
      case (11)
         text = 'ended by a segmentation fault'
      case (14)
         write (text, '(a, i0, a)') 'took longer than ', time_limit, ' s'
      case default
         write (text, '(a, i0)') 'ended by signal ', signal
      end select
   end function ending

   !> Runs what is left of a suite in a process of its own, up to its end.
   subroutine run_in_a_process(suite, tests, findings, status)
      type(suite_type), intent(in) :: suite
      type(tests_type), intent(inout) :: tests
      type(findings_type), intent(inout) :: findings
      integer(c_int), intent(out) :: status
      character(4096) :: text
      character(:), allocatable :: name
      integer(c_int) :: ends(2), process, done
      integer :: i, length

      findings%ended = .false.
      flush (output_unit)
      flush (error_unit)
      if (c_pipe(ends) /= 0) error stop 'no pipe to a process for a suite of tests'
      process = c_fork()
      if (process < 0) error stop 'no process for a suite of tests'
      if (process == 0) then
         tests%pipe = ends(2)
         done = c_close(ends(1))
         call suite%run(tests)
         call tests%tell(suite_ended)
         stop 0, quiet=.true.
      end if
      done = c_close(ends(2))
      do
         length = int(c_read(ends(1), text, len(text, c_size_t)))
         if (length <= 0) exit
         do i = 1, length
            if (allocated(name)) then
               if (text(i:i) /= new_line('a')) then
                  name = name//text(i:i)
               else
                  findings%tests = [character(40) :: findings%tests, name]
                  deallocate (name)
               end if
               cycle
            end if
            select case (text(i:i))
            case (test_begins)
               name = ''
            case (check_passed)
               findings%passed = findings%passed + 1
            case (check_failed)
               findings%failed = findings%failed + 1
            case (suite_ended)
               findings%ended = .true.
            end select
         end do
      end do
      done = c_close(ends(1))
      done = c_waitpid(process, status, 0_c_int)
   end subroutine run_in_a_process

end module runner
