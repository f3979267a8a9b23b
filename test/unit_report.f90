!> How a report writes: numbers, plurals, ranges, lines.
module unit_report
   use geartrain, only: dp
   use geartrain_base_numbers, only: counted, fixed, ordinal, significant
   use geartrain_base_sheet, only: in_head, in_quality, in_result, sheet_type
   use geartrain_readings_frequency_text, only: frequency_text_type
   use geartrain_readings_range_sentences, only: range_words, ranges_of_points
   use geartrain_readings_summary, only: band_type
   use geartrain_train_names, only: list_numbers
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: report_tests

contains

   subroutine report_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('numbers')) call numbers(tests)
      if (tests%runs('grammar')) call grammar(tests)
      if (tests%runs('ranges')) call ranges(tests)
      if (tests%runs('sections')) call sections(tests)
   end subroutine report_tests

   !> Four significant digits, without exponent from 1e-4 to 1e9.
   subroutine numbers(tests)
      class(tests_type), intent(inout) :: tests

      call tests%is_text(significant(38807.8_dp), '38810', 'more than four digits')
      call tests%is_text(significant(9999.6_dp), '10000', 'rounded to a digit more')
      call tests%is_text(significant(8832.46_dp), '8832', 'four digits')
      call tests%is_text(significant(97.1634_dp), '97.16', 'two digits before the point')
      call tests%is_text(significant(0.36564_dp), '0.3656', 'none before the point')
      call tests%is_text(significant(1.5_dp), '1.5', 'no zeros at the end')
      call tests%is_text(significant(300.0_dp), '300', 'zeros before the point stay')
      call tests%is_text(significant(-25.046_dp), '-25.05', 'a negative number')
      call tests%is_text(significant(0.0_dp), '0', 'zero')
      call tests%is_text(significant(2.345678e-7_dp), '2.346e-7', 'a small number')
      call tests%is_text(significant(4.383e12_dp), '4.383e12', 'a large number')
      call tests%is_text(fixed(1549.6_dp, 0), '1550', 'no point at the end')
      call tests%is_text(fixed(0.5_dp, 2), '0.50', 'a zero before the point')
   end subroutine numbers

   !> One of a kind is singular; the second is not 2th.
   subroutine grammar(tests)
      class(tests_type), intent(inout) :: tests
      character(:), allocatable :: words

      call tests%is_text(counted(1, 'point', 'points'), '1 point', 'one')
      call tests%is_text(counted(0, 'mesh', 'meshes'), '0 meshes', 'none')
      call tests%is_text(counted(12, 'mesh', 'meshes'), '12 meshes', 'several')
      call tests%is_text(ordinal(1), '1st', 'first')
      call tests%is_text(ordinal(3), '3rd', 'third')
      call tests%is_text(ordinal(11), '11th', 'eleventh')
      call tests%is_text(ordinal(12), '12th', 'twelfth')
      call tests%is_text(ordinal(22), '22nd', 'twenty-second')
      call tests%is_text(ordinal(113), '113th', 'hundred and thirteenth')
      call list_numbers([.false., .true.], 'mesh', 'meshes', words)
      call tests%is_text(words, 'mesh 2', 'one of two')
      call list_numbers([.true., .true.], 'mesh', 'meshes', words)
      call tests%is_text(words, 'meshes 1, 2', 'both')
      call list_numbers([.true., .true., .true.], 'mesh', 'meshes', words)
      call tests%is_text(words, 'all meshes', 'all')
      call list_numbers([.false., .false.], 'mesh', 'meshes', words)
      call tests%is_text(words, '', 'none')
   end subroutine grammar

   !> Ranges are joined where they touch in the digits printed; a sweep up and down passes each speed twice.
   subroutine ranges(tests)
      class(tests_type), intent(inout) :: tests
      type(frequency_text_type) :: told
      type(band_type), allocatable :: found(:)
      character(:), allocatable :: words
      integer :: i
      real(dp), parameter :: at(8) = [1.0_dp, 2.0_dp, 3.0_dp, 4.0_dp, 4.0_dp, 3.0_dp, 2.0_dp, 1.0_dp]
      logical, parameter :: holds(8) = [.false., .true., .true., .false., .true., .true., .false., .false.]

      told%unit = 'rpm'
      told%decimals = 0
      found = [band_type(100.0_dp, 200.2_dp), band_type(200.4_dp, 300.0_dp), band_type(500.0_dp, 500.1_dp)]
      call range_words(found, told, .true., words)
      call tests%is_text(words, '100 to 300 rpm', 'joined, and without width left out')
      call range_words([band_type(500.0_dp, 500.1_dp)], told, .true., words)
      call tests%is_text(words, '500 rpm', 'alone without width')
      found = ranges_of_points(at, holds, [(.true., i=1, 8)])
      call tests%is_true(size(found) == 1, 'up 2 to 3 and down 4 to 3 are one range')
      if (size(found) /= 1) return
      call tests%is_close(found(1)%from, 2.0_dp, 0.0_dp, 'its beginning')
      call tests%is_close(found(1)%to, 4.0_dp, 0.0_dp, 'its end')
   end subroutine ranges

   !> Sections stand in their order whichever is written first, and no line of a sentence is long.
   subroutine sections(tests)
      class(tests_type), intent(inout) :: tests
      type(sheet_type) :: sheet
      character(:), allocatable :: text
      integer :: first, next

      call sheet%say(in_quality, 'Good.')
      call sheet%say(in_result, repeat('a sentence of many words ', 20)//'ends here.')
      call sheet%add(in_head, 'A title')
      call sheet%put_together(text)
      call tests%is_true(index(text, 'A title'//new_line('a')//'RESULT'//new_line('a')) == 1, 'the title, then the result')
      call tests%is_true(index(text, 'QUALITY'//new_line('a')//'  Good.') > index(text, 'ends here.'), 'the quality after it')
      first = 1
      do while (first <= len(text))
         next = index(text(first:), new_line('a'))
         call tests%is_true(next - 1 <= 104, 'a line of at most 104 columns')
         first = first + next
      end do
   end subroutine sections

end module unit_report
