!> A case as text: what is written reads back to the same bits; the template and the reference page agree with the table.
module unit_case_text
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_analyses_list, only: case_type
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: real_text
   use geartrain_input_reader, only: read_case, read_case_text
   use geartrain_input_template, only: paper_case, template_text
   use geartrain_input_text, only: case_text, commented_text, reference_text
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: case_text_tests

contains

   subroutine case_text_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('numbers')) call numbers(tests)
      if (tests%runs('round_trip')) call round_trip(tests)
      if (tests%runs('template')) call template(tests)
      if (tests%runs('reference')) call reference(tests)
   end subroutine case_text_tests

   subroutine numbers(tests)
      class(tests_type), intent(inout) :: tests
      real(dp) :: value, again
      integer(int64) :: bits
      integer :: i, different
      real :: random(2)
      character(:), allocatable :: text
      character(32) :: decimal

      call tests%is_text(real_text(0.05_dp), '0.05', 'a short number')
      call tests%is_text(real_text(2.5e8_dp), '2.5e8', 'a large number')
      call tests%is_text(real_text(9870.0_dp), '9870.0', 'a whole number')
      call tests%is_text(real_text(-30e-6_dp), '-3.0e-5', 'a small number')
      call tests%is_text(real_text(0.0_dp), '0.0', 'zero')
      call tests%is_text(real_text(0.1_dp + 0.2_dp), '0.30000000000000004', 'seventeen digits where they are needed')
      different = 0
      do i = 1, 2000
         call random_number(random)
         bits = transfer(real(random(1), dp)*10.0_dp**(600*random(2) - 300), bits)
         bits = ieor(bits, int(1e6*random(1), int64))
         value = transfer(bits, value)
         if (random(2) > 0.5) value = -value
         text = real_text(value)
         read (text, *) again
         if (transfer(again, bits) /= transfer(value, bits)) different = different + 1
      end do
      call tests%is_true(different == 0, '2000 random numbers read back to identical bits')
      ! A decimal of up to 15 digits is the shortest that reads back to its number.
      different = 0
      do i = 1, 2000
         call random_number(random)
         write (decimal, '(i0, a, i0)') int(10.0_dp**(mod(i, 15) + 1)*random(1), int64), 'e', int(600*random(2) - 300)
         read (decimal, *) value
         text = real_text(value)
         if (digits_of(text) > digits_of(decimal)) different = different + 1
      end do
      call tests%is_true(different == 0, 'no more digits than the shortest decimal has')

   contains

      !> Number of digits before the exponent, without zeros at either end.
      pure integer function digits_of(text)
         character(*), intent(in) :: text
         integer :: last, k

         last = index(text//'e', 'e') - 1
         digits_of = 0
         do k = scan(text(:last), '123456789'), scan(text(:last), '123456789', back=.true.)
            if (text(max(1, k):max(1, k)) /= '.') digits_of = digits_of + 1
         end do
      end function digits_of

   end subroutine numbers

   !> A case of awkward numbers is written, read and written again.
   subroutine round_trip(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type) :: case, again
      type(error_type), allocatable :: error
      character(:), allocatable :: text, text_again
      real(dp) :: random(6)

      call random_number(random)
      case = paper_case()
      case%train%title = 'it''s "quoted" / ! & = 2*3'
      case%train%input_torque = random(1)/3
      case%train%torque_sin = random*1e-9_dp
      case%train%shafts(1)%rigid = .true.
      case%train%shafts(1)%stiffness = 0
      case%train%shafts(1)%damping_ratio = 0
      case%train%shafts(2)%damping_given = .true.
      case%train%shafts(2)%damping = random(2)
      case%train%meshes(2)%error_cos = [random(3), -tiny(1.0_dp)]
      case%train%meshes(2)%order = 3
      case%response%amplitude_limit = random(4)
      case%response%coefficients = 'sampled'
      case%integration%tolerance = random(5)*1e-12_dp
      case%attractors%random_seed = -huge(1)
      case%attractors%follow = .true.
      case%output_file = 'a b.h5'
      call case_text(case, text)
      call read_case_text(text, 'x.nml', again, error)
      call tests%is_true(.not. allocated(error), 'the resolved text is a case')
      if (allocated(error)) then
         call tests%is_text(error%message, '', 'no message')
         return
      end if
      call case_text(again, text_again)
      call tests%is_text(text_again, text, 'the resolved text of the resolved text')
      call tests%is_text(again%train%title, case%train%title, 'title')
      call tests%is_true(same(again%train%input_torque, case%train%input_torque), 'identical bits: input torque')
      call tests%is_true(all(same(again%train%torque_sin, case%train%torque_sin)), 'identical bits: torque harmonics')
      call tests%is_true(all(same(again%train%meshes(2)%error_cos, case%train%meshes(2)%error_cos)), 'identical bits: errors')
      call tests%is_true(again%train%shafts(1)%rigid .and. again%train%shafts(2)%damping_given .and. &
                         .not. again%train%shafts(3)%damping_given, 'rigid, damping or ratio')
      call tests%is_true(again%attractors%random_seed == -huge(1) .and. again%attractors%follow, 'attractors')
      call tests%is_true(same(again%train%shafts(2)%damping, case%train%shafts(2)%damping), 'identical bits: damping')
   end subroutine round_trip

   elemental logical function same(a, b)
      real(dp), intent(in) :: a, b

      same = transfer(a, 0_int64) == transfer(b, 0_int64)
   end function same

   !> The template is complete, runnable, and the paper's train as namelists/fig03.nml gives it.
   subroutine template(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type) :: case, figure
      type(error_type), allocatable :: error
      character(:), allocatable :: text, expected, page

      call template_text(page)
      call read_case_text(page, 'template', case, error)
      call tests%is_true(.not. allocated(error), 'the template is a case')
      if (allocated(error)) return
      call read_case('namelists/fig03.nml', figure, error)
      if (allocated(error)) return
      figure%output_file = ''
      call case_text(case, text)
      call case_text(figure, expected)
      call tests%is_text(text, expected, 'the template is figure 3')
      call tests%is_true(.not. allocated(case%attractors) .and. index(page, new_line('a')//'! &attractors') > 0, &
                         'a search for attractors stands in the template as a comment')
      call commented_text(paper_case(), page)
      call read_case_text(page, 'template', case, error)
      call tests%is_true(.not. allocated(error) .and. allocated(case%attractors), 'which is right without the !')
   end subroutine template

   subroutine reference(tests)
      class(tests_type), intent(inout) :: tests
      character(:), allocatable :: page, text
      integer :: unit, bytes

      open (newunit=unit, file='docs/reference.md', access='stream', form='unformatted', status='old', action='read')
      inquire (unit=unit, size=bytes)
      allocate (character(bytes) :: page)
      read (unit) page
      close (unit)
      call reference_text(text)
      call tests%is_true(index(page, text) > 0, 'docs/reference.md holds what geartrain --reference prints')
   end subroutine reference

end module unit_case_text
