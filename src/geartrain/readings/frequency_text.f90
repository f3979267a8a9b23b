!> Frequencies as a report states them: in the unit that the case asks for, the speed in rpm where Lambda is the speed in
!> rpm. Of a branch over a parameter of the train the values of the parameter take the place of frequencies.
module geartrain_readings_frequency_text
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: fixed, short => text, significant
   use geartrain_base_words, only: lambda, words_type
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_network_frequency_unit, only: lambda_per, speed_per_lambda
   use geartrain_network_parameter_table, only: settings_length
   use geartrain_trace_branch, only: branch_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: frequency_text_type, frequency_text, in_width, text_for

   !> Lambda from here on has two digits after the point, else four.
   real(dp), parameter :: large = 1000
   !> A range of rpm or Hz narrower than this share of its end has a digit more.
   real(dp), parameter :: narrow = 0.2_dp

   type :: frequency_text_type
      !> Name of the parameter of the train; blank: frequencies are told.
      character(settings_length) :: parameter = ''
      !> 'Lambda', 'rpm' or 'Hz', or the unit of the parameter; its value at Lambda = 1.
      character(12) :: unit = 'Lambda'
      real(dp) :: per_lambda = 1
      !> Digits after the point.
      integer :: decimals = 4
   contains
      procedure :: number
      procedure :: number_differs
      procedure :: with_unit
      procedure :: of_words
      procedure :: rounded
   end type frequency_text_type

contains

   !> How the frequencies of an analysis are told.
   pure type(frequency_text_type) function frequency_text(train, unit, largest, smallest) result(told)
      !> The train as given.
      type(train_type), intent(in) :: train
      !> The unit that the analysis is asked in.
      character(*), intent(in) :: unit
      !> Largest Lambda to be told [1]; 0: not known.
      real(dp), intent(in) :: largest
      !> Smallest Lambda to be told [1]; absent: 0.
      real(dp), intent(in), optional :: smallest
      type(train_type) :: plain
      real(dp) :: from

      told%unit = unit
      if (unit == 'Lambda') then
         if (.not. abs(train%characteristic_frequency) > 0) then
            call plain_train(train, plain)
            if (speed_per_lambda(plain) > 0) told%unit = 'rpm'
         end if
      else
         told%per_lambda = 1/lambda_per(train, unit)
      end if
      if (largest*told%per_lambda >= large) told%decimals = 2
      if (told%unit == 'Lambda' .or. .not. largest > 0) return
      ! Four digits, or five of a narrow range.
      from = 0
      if (present(smallest)) from = smallest
      told%decimals = max(0, 3 - floor(log10(largest*told%per_lambda)))
      if (largest - from < narrow*largest) told%decimals = told%decimals + 1
   end function frequency_text

   !> How the free parameter of a branch is told.
   pure type(frequency_text_type) function text_for(branch, train, unit) result(told)
      type(branch_type), intent(in) :: branch
      !> The train as given.
      type(train_type), intent(in) :: train
      !> The unit of frequencies that the analysis is asked in.
      character(*), intent(in) :: unit

      if (allocated(branch%parameter)) then
         told%parameter = branch%parameter
         told%unit = branch%parameter_unit
         if (told%unit == '1') told%unit = 'value'
      else
         associate (at => branch%frequency_ratio(:branch%points))
            told = frequency_text(train, unit, maxval([0.0_dp, at]), minval([maxval([0.0_dp, at]), at]))
         end associate
      end if
   end function text_for

   !> A frequency as a number, with blanks at the end.
   pure function number(self, frequency_ratio) result(text)
      class(frequency_text_type), intent(in) :: self
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      character(32) :: text
      real(dp) :: rounded

      if (self%parameter == '') then
         text = fixed(frequency_ratio*self%per_lambda, self%decimals)
      else
         ! Six significant digits, no more of them than the number has.
         write (text, '(es13.5e3)') frequency_ratio
         read (text, *) rounded
         text = short(rounded)
      end if
   end function number

   !> Whether two frequencies differ in the digits printed.
   elemental logical function number_differs(self, one, other)
      class(frequency_text_type), intent(in) :: self
      !> Lambda of each [1].
      real(dp), intent(in) :: one, other

      number_differs = self%number(one) /= self%number(other)
   end function number_differs

   !> Numbers with their unit: 'Lambda 0.5', '1500 to 1600 rpm'.
   subroutine with_unit(self, numbers, text)
      class(frequency_text_type), intent(in) :: self
      !> The numbers, of any form.
      character(*), intent(in) :: numbers
      !> The text.
      character(:), allocatable, intent(out) :: text

      if (self%unit == 'Lambda') then
         text = 'Lambda '//trim(numbers)
      else if (self%unit == 'value') then
         text = trim(numbers)
      else
         text = trim(numbers)//' '//trim(self%unit)
      end if
   end subroutine with_unit

   !> A sentence with its frequencies in the unit: 'reached Lambda = 1550' becomes 'reached 1550 rpm'.
   subroutine of_words(self, words, text)
      class(frequency_text_type), intent(in) :: self
      !> The sentence.
      type(words_type), intent(in) :: words
      !> The sentence in the unit.
      character(:), allocatable, intent(out) :: text
      integer :: i, last

      text = ''
      last = 0
      do i = 1, merge(0, size(words%places), self%unit == 'Lambda')
         associate (place => words%places(i))
            text = text//words%text(last + 1:place%first - 1)
            if (self%parameter /= '') text = text//trim(self%parameter)//' = '
            text = text//short(place%from*self%per_lambda)
            if (abs(place%to - place%from) > 0) text = text//' to '//short(place%to*self%per_lambda)
            if (self%unit /= 'value') text = text//' '//trim(self%unit)
            last = place%last
         end associate
      end do
      text = text//words%text(last + 1:)
   end subroutine of_words

   !> A frequency to four digits as a part of a sentence: 'Lambda = 0.3656', '1550 rpm'.
   subroutine rounded(self, frequency_ratio, text)
      class(frequency_text_type), intent(in) :: self
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> The frequency in the unit.
      character(:), allocatable, intent(out) :: text
      real(dp) :: value

      text = significant(frequency_ratio)
      read (text, *) value
      call self%of_words(lambda(value), text)
   end subroutine rounded

   !> A number at the right end of a column, at least a blank before it.
   pure function in_width(number, width) result(text)
      !> The number; blanks at its end do not count.
      character(*), intent(in) :: number
      !> Width of the column.
      integer, intent(in) :: width
      character(max(width, len_trim(number) + 1)) :: text

      text = adjustr(repeat(' ', len(text) - len_trim(number))//trim(number))
   end function in_width

end module geartrain_readings_frequency_text
