!> Case files, good and bad: what is read, and the messages word for word.
module unit_case_reader
   use geartrain_analyses_list, only: case_type
   use geartrain_base_error, only: error_type, status_input
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text
   use geartrain_input_reader, only: read_case, read_case_text
   use testing, only: full, tests_type
   implicit none (type, external)
   private
   public :: case_reader_tests

   character(*), parameter :: n = new_line('a')
   character(*), parameter :: train = '&train input_torque=150.0, prime_mover_inertia=2e-7, load_inertia=2e-7'//n// &
      'characteristic_length=3e-5 characteristic_frequency=9870 /'//n
   character(*), parameter :: shaft = '&shaft stiffness=1e3, damping_ratio=0.01 /'//n
   character(*), parameter :: mesh = '&mesh driving_radius=0.05 driven_radius=0.1 driving_inertia=0.002 driven_inertia=0.04'//n// &
      'stiffness=2e8 /'//n
   !> Seven lines.
   character(*), parameter :: good = train//shaft//mesh//shaft
   character(*), parameter :: response = '&response from=0.2, to=2.6 /'//n

contains

   subroutine case_reader_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('what_is_read')) call what_is_read(tests)
      if (tests%runs('forms')) call forms(tests)
      if (tests%runs('names')) call names(tests)
      if (tests%runs('values')) call values(tests)
      if (tests%runs('structure')) call structure(tests)
      if (tests%runs('agreement')) call agreement(tests)
      if (tests%runs('without_a_file')) call without_a_file(tests)
      if (tests%runs('files')) call files(tests)
      if (tests%runs('threads', full)) call threads(tests)
   end subroutine case_reader_tests

   subroutine what_is_read(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type) :: case
      type(error_type), allocatable :: error

      call read_case('namelists/fig03.nml', case, error)
      call tests%is_true(.not. allocated(error), 'figure 3 is read')
      if (allocated(error)) return
      call tests%is_text(case%train%title, 'Al-shyyab and Kahraman 2007, figure 3', 'title')
      call tests%is_true(size(case%train%shafts) == 3 .and. size(case%train%meshes) == 2, 'three shafts, two meshes')
      call tests%is_close(case%train%shafts(2)%stiffness, 1e8_dp, 0.0_dp, 'stiffness of shaft 2')
      call tests%is_close(case%train%meshes(2)%driven_inertia, 0.074_dp, 0.0_dp, 'driven inertia of mesh 2')
      call tests%is_true(size(case%train%meshes(1)%stiffness_cos) == 1, 'one stiffness harmonic')
      call tests%is_true(case%modes .and. allocated(case%response) .and. allocated(case%integration), 'three analyses')
      call tests%is_close(case%response%stop, 2.6_dp, 0.0_dp, 'to of the response')
      call tests%is_text(trim(case%integration%direction), 'both', 'direction')
      call tests%is_text(case%output_file, 'fig03.h5', 'output file')
      call read_case('namelists/single_pair.nml', case, error)
      call tests%is_true(.not. allocated(error), 'the single pair is read')
      if (.not. allocated(error)) call tests%is_true(all(case%train%shafts%rigid), 'its shafts are rigid')
      call read_case('namelists/fig03_linear.nml', case, error)
      call tests%is_true(.not. allocated(error), 'the linear train is read')
      if (.not. allocated(error)) call tests%is_close(maxval(case%train%meshes%half_backlash), 0.0_dp, 0.0_dp, 'no backlash')
   end subroutine what_is_read

   !> What the form of a namelist allows.
   subroutine forms(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type) :: case
      type(error_type), allocatable :: error
      character(*), parameter :: crlf = char(13)//n

      call read_case_text(char(239)//char(187)//char(191)//'! comment'//crlf//'&TRAIN Title = ''it''''s "x" ! / &'','// &
                          achar(9)//'input_torque= +1.5D2'//crlf//'prime_mover_inertia =2.e-7 ,load_inertia=.2E-6'//crlf// &
                          'characteristic_length'//crlf//' = ! here'//crlf//'3e-5 characteristic_frequency=9870, '// &
                          'torque_cos = 2*0.5, -1'//crlf//'   7 ,/ ! done'//crlf//shaft//mesh//shaft// &
                          '&modes/ &output file="a/b.h5"/', 'x.nml', case, error)
      call tests%is_true(.not. allocated(error), 'byte order mark, CRLF, tabs, quotes, comments, repeat counts')
      if (allocated(error)) then
         call tests%is_text(error%message, '', 'no message')
         return
      end if
      call tests%is_text(case%train%title, 'it''s "x" ! / &', 'doubled quote, marks in quotes')
      call tests%is_close(case%train%input_torque, 150.0_dp, 0.0_dp, 'd exponent')
      call tests%is_true(size(case%train%torque_cos) == 4, 'a repeat count and a list over two lines')
      call tests%is_close(sum(case%train%torque_cos), 7.0_dp, 0.0_dp, 'values of the list')
      call tests%is_text(case%output_file, 'a/b.h5', 'double quotes, a second group on the line')
      call tests%is_true(case%modes, 'a group without variables')
   end subroutine forms

   subroutine names(tests)
      class(tests_type), intent(inout) :: tests

      call refused(tests, train//shaft//'&mesh'//n//'   stifness = 2.5e8, driving_radius=0.05 driven_radius=0.1'//n// &
                   'driving_inertia=0.002 driven_inertia=0.04 /'//n//shaft, &
                   'x.nml:5:4: error: unknown variable "stifness" in &mesh (did you mean "stiffness"?)')
      call refused(tests, good//'&response start=-0.2, to=1 /', 'x.nml:7:17: error: &response: from = -0.2: must be > 0')
      call refused(tests, good//'&response start=0.2, to=1, from = 0.3 /', &
                   'x.nml:7:28: error: &response: from is given twice; the first is on line 7')
      call refused(tests, good//'&attractors frequency=0.6, start=20 /', &
                   'x.nml:7:28: error: unknown variable "start" in &attractors (did you mean "starts"?)')
      call refused(tests, good//'&modes title = ''x'' /', &
                   'x.nml:7:8: error: unknown variable "title" in &modes (it belongs to &train)')
      call refused(tests, good//'&output qqqqqqq = 1 /', &
                   'x.nml:7:9: error: unknown variable "qqqqqqq" in &output (there are file)')
      call refused(tests, good//'&respnse from=1 /', 'x.nml:7:1: error: unknown group &respnse (did you mean &response?)')
      call refused(tests, good//'&modes /'//n//'&xyzzy /', 'x.nml:8:1: error: unknown group &xyzzy (there are &train &body &&
                   &planetary &shaft &mesh &coupling &bearing &modes &response &integration &attractors &basins &&
                   &bifurcation_diagram &stability_map &run_up &locus &output)')
      call refused(tests, good//'&response from=0.2, to=2.6, from = 0.3 /', &
                   'x.nml:7:29: error: &response: from is given twice; the first is on line 7')
   end subroutine names

   subroutine values(tests)
      class(tests_type), intent(inout) :: tests

      call one_value(tests, 'harmonics = 1.5', 0, 'harmonics = 1.5: must be a whole number')
      call one_value(tests, 'harmonics = -1', 0, &
                     'harmonics = -1: must be >= 1 and <= 1000, or 0 to leave the choice to the program')
      call one_value(tests, 'harmonics = 3000000000', 0, &
                     'harmonics = 3000000000: must be a whole number below 2147483648')
      call one_value(tests, 'subharmonic = 0', 0, 'subharmonic = 0: must be >= 1 and <= 1000')
      call refused(tests, good//'&response from=0.2, to=2.6, subharmonic=7 /', 'x.nml:7:1: error: &response: harmonics = 6: &
                   &must be >= subharmonic = 7: the fundamental itself would be left out')
      call one_value(tests, 'tolerance = 0.0', 0, 'tolerance = 0.0: must be > 0 and <= 1')
      call one_value(tests, 'step = NaN', 0, 'step = NaN: must be a finite number')
      call one_value(tests, 'step = -Inf', 0, 'step = -Inf: must be a finite number')
      call one_value(tests, 'step = 1e999', 0, 'step = 1e999: must be a finite number (it is too large)')
      call one_value(tests, 'step = 0.1x', 0, 'step = 0.1x: must be a number')
      call one_value(tests, 'step = 1.0+5', 0, 'step = 1.0+5: must be a number')
      call one_value(tests, 'step = ''0.1''', 0, 'step = ''0.1'': must be a number, without quotes')
      call one_value(tests, 'step = 0,1', 0, 'step = 0, 1: takes one value, not 2 (a text needs quotes, a decimal is &
                     &written with a point)')
      call one_value(tests, 'step = 2*0.1', 0, 'step = 0.1, 0.1: takes one value, not 2 (a text needs quotes, a decimal is &
                     &written with a point)')
      call one_value(tests, 'stability = maybe', 0, 'stability = maybe: must be .true. or .false.')
      call one_value(tests, 'control = ''newton''', 0, 'control = ''newton'': must be ''arclength'' or ''local''')
      call one_value(tests, 'control = local', 0, 'control = local: must be a text in quotes, ''...''')
      call one_value(tests, 'samples = 37', 0, 'samples = 37: must be >= 8 harmonics + 2 = 50, or 0 to leave the choice to &
                     &the program')
      call one_value(tests, 'step = ', 4, 'step has no value: give one, or leave the variable out')
      call one_value(tests, 'step = ,', 0, 'step: an empty value before the comma')
      call one_value(tests, 'step(1) = 0.1', 4, '"step" with an index or component: give the whole list, step = first, &
                     &second, ...')
      call refused(tests, good//'&response step 0.1, from = 0.2, to = 2.6 /', &
                   'x.nml:7:11: error: &response: expected "=" after "step"')
      call one_value(tests, 'control = ''local', 0, 'control: the quote is not closed on its line')
   end subroutine values

   !> `assignment` stands on line 8 from column 4; the message points to `column`, 0: to the value.
   subroutine one_value(tests, assignment, column, text)
      class(tests_type), intent(inout) :: tests
      character(*), intent(in) :: assignment, text
      integer, intent(in) :: column
      character(:), allocatable :: place

      place = integer_text(merge(column, index(assignment, '= ') + 5, column > 0))
      call refused(tests, good//'&response from = 0.2, to = 2.6'//n//'   '//assignment//n//'/', &
                   'x.nml:8:'//place//': error: &response: '//text)
   end subroutine one_value

   subroutine structure(tests)
      class(tests_type), intent(inout) :: tests

      call refused(tests, good//'&response from=0.2 to=2.6', 'x.nml:7:1: error: &response: has no closing /')
      call refused(tests, good//'&response from=0.2 to=2.6'//n//'&modes /', 'x.nml:7:1: error: &response: has no closing /')
      call refused(tests, good//'&modes &end', 'x.nml:7:8: error: &modes: ends with &end: write / instead')
      call refused(tests, good//'&modes / x', 'x.nml:7:10: error: &modes: text after the closing /: it would be ignored &
                   &(text with a / in it needs quotes)')
      call refused(tests, good//'modes'//n//'more'//n, 'x.nml:7:1: error: text outside of a group: a group begins with &name &
                   &and ends with /')
      call refused(tests, good//'&modes /'//n//'&modes /', 'x.nml:8:1: error: &modes: stands twice; the first is on line 7')
      call refused(tests, good//train, 'x.nml:7:1: error: &train: stands twice; the first is on line 1')
      call refused(tests, shaft//mesh//shaft//train, 'x.nml:5:1: error: &train: must be the first group')
      call refused(tests, shaft//mesh//shaft, 'x.nml: error: there is no &train group: it comes first in the file')
      call refused(tests, train//shaft//mesh//mesh//shaft, &
                   'x.nml:6:1: error: &mesh 2: follows &mesh 1: a &shaft must stand between them')
      call refused(tests, good//shaft, 'x.nml:7:1: error: &shaft 3: follows &shaft 2: a &mesh must stand between them')
      call refused(tests, train//mesh//shaft, 'x.nml:3:1: error: &mesh 1: stands before any &shaft: the train begins with a shaft')
      call refused(tests, train//shaft//mesh, 'x.nml:4:1: error: &mesh 1: is the last group of the train: a &shaft must follow it')
      call refused(tests, train//shaft//mesh//response//shaft, &
                   'x.nml:7:1: error: &shaft 2: stands after &response: the train comes before the analyses')
      call refused(tests, train//shaft, 'x.nml: error: there are 1 &shaft and 0 &mesh groups: a train needs &
                   &&shaft, &mesh, &shaft at least')
      call refused(tests, good//achar(0), 'x.nml: error: this is a binary file, not a namelist')
   end subroutine structure

   subroutine agreement(tests)
      class(tests_type), intent(inout) :: tests
      character(*), parameter :: locus = '&locus parameter=''input_torque'', near=3.0, from=50, to=200 /'
      character(*), parameter :: rigid = '&shaft rigid=.true. /'//n

      call refused(tests, train//'&shaft damping_ratio=0.01 /'//n//mesh//shaft, &
                   'x.nml:3:1: error: &shaft 1: lacks stiffness (> 0 N m/rad) or rigid = .true., or diameter and &
                   &length')
      call refused(tests, train//'&shaft rigid=.true., stiffness=3.0 /'//n//mesh//shaft, &
                   'x.nml:3:32: error: &shaft 1: stiffness = 3.0: contradicts rigid = .true.: leave out one of the two')
      call refused(tests, train//'&shaft stiffness=3, damping=1.0, damping_ratio=0.1 /'//n//mesh//shaft, &
                   'x.nml:3:29: error: &shaft 1: damping = 1.0: is given together with damping_ratio: leave out one of the two')
      call refused(tests, '&train input_torque=1 prime_mover_inertia=1 load_inertia=0.0'//n// &
                   'characteristic_length=3e-5 characteristic_frequency=9870 /'//n//rigid//mesh//shaft, 'x.nml:1:58: error: &
                   &&train: load_inertia = 0.0: must be > 0 kg m^2, or the last shaft must have rigid = .true.')
      call refused(tests, good//'&response from=1, to=1.0 /', &
                   'x.nml:7:22: error: &response: to = 1.0: must differ from "from": a branch needs a range')
      call refused(tests, good//'&integration from=1, to=1.0 /', &
                   'x.nml:7:1: error: &integration: points = 121: must be 1 where "from" and "to" are equal')
      call refused(tests, good//'&response from=0.2, to=2.6, period_doublings = 1, stability = .false. /', 'x.nml:7:48: error: &
                   &&response: period_doublings = 1: needs stability = .true.: the multipliers tell where a period doubles')
      call refused(tests, good//'&attractors starts=10 /', 'x.nml:7:1: error: &attractors: lacks frequency (> 0)')
      call refused(tests, good//'&attractors frequency=1.0, follow=.true. /', 'x.nml:7:35: error: &attractors: follow = .true.: &
                   &needs &response: its range and settings are those of the branches')
      call refused(tests, good//response//'&attractors frequency=3.0, follow=.true. /', 'x.nml:8:23: error: &attractors: &
                   &frequency = 3.0: must lie in the range of &response, 0.2 to 2.6, where follow = .true.')
      call refused(tests, good//locus, 'x.nml:7:39: error: &locus: near = 3.0: needs &response, which has the special point')
      call refused(tests, good//response//locus, &
                   'x.nml:8:39: error: &locus: near = 3.0: must lie in the range of &response, 0.2 to 2.6')
      call refused(tests, good//'&response parameter=''input_torque'', frequency=1.0, from=50, to=200 /'//n//locus, &
                   'x.nml:8:39: error: &locus: near = 3.0: needs a &response over frequency, not over a parameter')
      call refused(tests, good//response//'&locus parameter=''input_torqe'', near=1.0, from=50, to=200 /', 'x.nml:8:18: error: &
                   &&locus: parameter = ''input_torqe'': parameter "input_torqe": no variable of &train (did you mean &
                   &"input_torque"?)')
      call refused(tests, good//response//'&locus parameter=''input_torque'', near=1.0, from=50, to=100 /', 'x.nml:8:18: error: &
                   &&locus: parameter = ''input_torque'': locus: from 50.0 to 100.0: the value of "input_torque" in the train, &
                   &150.0, must lie between them')
      ! Everything at once, in the order of the file.
      call refused(tests, train//'&shaft stiffness=-1.0 /'//n//mesh//shaft//'&response from=0.2 harmonics=x /', &
                   'x.nml:3:18: error: &shaft 1: stiffness = -1.0: must be > 0 N m/rad'//n// &
                   'x.nml:7:1: error: &response: lacks to'//n// &
                   'x.nml:7:30: error: &response: harmonics = x: must be a whole number')
   end subroutine agreement

   !> Messages to a caller who has no file name the group instead of the place.
   subroutine without_a_file(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type) :: case
      type(error_type), allocatable :: error

      call read_case_text(train//shaft//'&mesh driving_radius=0.05 driven_radius=0.1 driving_inertia=0.002 driven_inertia=0.04 &
                          &stiffness = -1.0, stiffness_cos = 0.1, nan /'//n//shaft//response, '', case, error)
      call tests%is_true(allocated(error), 'a call with bad values is refused')
      if (.not. allocated(error)) return
      call tests%is_text(error%message, '&mesh 1: stiffness = -1.0: must be > 0 N/m'//n// &
                         '&mesh 1: stiffness_cos harmonic 2 = nan: must be a finite number', 'message without a file')
   end subroutine without_a_file

   subroutine files(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type) :: case
      type(error_type), allocatable :: error

      call read_case('namelists/nosuch.nml', case, error)
      call tests%is_text(error%message, 'namelists/nosuch.nml: error: there is no such file', 'a missing file')
      call tests%is_true(error%status == status_input, 'is bad input')
      call read_case('namelists', case, error)
      call tests%is_true(allocated(error), 'a directory is refused')
   end subroutine files

   !> Threads that read bad cases at once get the messages that each gets alone, whatever their lengths.
   subroutine threads(tests)
      class(tests_type), intent(inout) :: tests
      integer :: i, different, repetitions

      different = 0
      repetitions = tests%times(12000)
      !$omp parallel do num_threads(8) schedule(static, 1) reduction(+:different)
      do i = 1, repetitions
         if (.not. is_told(i)) different = different + 1
      end do
      !$omp end parallel do
      call tests%is_true(different == 0, 'messages of eight threads')
   end subroutine threads

   !> Whether a text with numbers as long as `number` makes them has its message, byte for byte.
   logical function is_told(number)
      integer, intent(in) :: number
      character(*), parameter :: from(4) = [character(22) :: '-1.0', '-0.12345678901234566', '-1.2345678901234567e9', '-2.5e8']
      character(*), parameter :: harmonics(3) = [character(10) :: '-1', '1234567890', '-12345']
      type(case_type) :: case
      type(error_type), allocatable :: error
      character(:), allocatable :: a, b, expected

      a = trim(from(1 + mod(number, size(from))))
      b = trim(harmonics(1 + mod(number, size(harmonics))))
      call read_case_text(good//'&response from='//a//' to=2.6 harmonics='//b//' /', 'x.nml', case, error)
      expected = 'x.nml:7:16: error: &response: from = '//a//': must be > 0'//n//'x.nml:7:'//integer_text(34 + len(a))// &
                 ': error: &response: harmonics = '//b//': must be >= 1 and <= 1000, or 0 to leave the choice to the program'
      is_told = allocated(error)
      if (is_told) is_told = len(error%message) == len(expected) .and. error%message == expected
   end function is_told

   !> The text is refused with exactly this message, and nothing of it is taken over.
   subroutine refused(tests, text, message)
      class(tests_type), intent(inout) :: tests
      character(*), intent(in) :: text, message
      type(case_type) :: case
      type(error_type), allocatable :: error

      call read_case_text(text, 'x.nml', case, error)
      call tests%is_true(allocated(error) .and. .not. allocated(case%train%shafts), 'refused: '//message)
      if (allocated(error)) call tests%is_text(error%message, message, 'message')
   end subroutine refused

end module unit_case_reader
