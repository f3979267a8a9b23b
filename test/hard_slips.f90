!> Case files with two or three slips: each is read, or refused with a place; none crashes the reader, whatever it breaks together.
module hard_slips
   use geartrain, only: case_type, error_type, explanation_text, read_case_text, status_input, warnings_text
   use geartrain_base_random, only: begin_random, generator_type
   use testing, only: full, nightly, scratch, tests_type
   implicit none (type, external)
   private
   public :: slips_at_random_tests

   character(*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_', digits = '0123456789'
   character(*), parameter :: n = new_line('a')

   type :: text_type
      character(:), allocatable :: text
   end type text_type

contains

   subroutine slips_at_random_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('pairs_and_triples', full)) call pairs_and_triples(tests)
   end subroutine slips_at_random_tests

   !> Slips in all shipped cases. The text at hand lies in a file while it is read, to be looked at after a crash.
   subroutine pairs_and_triples(tests)
      class(tests_type), intent(inout) :: tests
      type(text_type), allocatable :: shipped(:)
      type(generator_type) :: random
      type(case_type) :: case
      type(error_type), allocatable :: error
      character(:), allocatable :: text, told
      integer :: i, k, texts, refused

      call read_shipped(shipped)
      call tests%is_true(size(shipped) >= 10, 'the shipped cases are found')
      if (size(shipped) == 0) return
      random = begin_random(tests%seed, 1)
      refused = 0
      texts = merge(100000, 2000, tests%tier(nightly))
      do i = 1, texts
         k = random%one_of(size(shipped))
         text = shipped(k)%text
         do k = 1, 1 + random%one_of(2)
            call slip(random, text)
         end do
         call keep(text)
         call read_case_text(text, 'slips.nml', case, error)
         if (allocated(error)) then
            refused = refused + 1
            if (error%status == status_input .and. index(error%message, 'slips.nml') == 1) cycle
            call tests%is_true(.false., 'an error without place or with the wrong status: '//error%message//n//text)
         else
            call warnings_text(case%train, told)
            call explanation_text(case%train, told)
         end if
      end do
      call tests%is_true(refused > texts/10, 'slips are refused')
   end subroutine pairs_and_triples

   subroutine read_shipped(shipped)
      type(text_type), allocatable, intent(out) :: shipped(:)
      character(*), parameter :: list = scratch//'shipped-cases'
      character(200) :: path
      character(:), allocatable :: text
      integer :: unit, file, status, length

      allocate (shipped(0))
      call execute_command_line('ls namelists/*.nml >'//list)
      open (newunit=unit, file=list, status='old', action='read')
      do
         read (unit, '(a)', iostat=status) path
         if (status /= 0) exit
         open (newunit=file, file=trim(path), access='stream', form='unformatted', status='old', action='read')
         inquire (file, size=length)
         if (allocated(text)) deallocate (text)
         allocate (character(length) :: text)
         read (file) text
         close (file)
         shipped = [shipped, text_type(text)]
      end do
      close (unit)
   end subroutine read_shipped

   subroutine keep(text)
      character(*), intent(in) :: text
      integer :: unit

      open (newunit=unit, file=scratch//'slips.nml', access='stream', form='unformatted', status='replace', action='write')
      write (unit) text
      close (unit)
   end subroutine keep

   !> One slip of a hand: in a word, in a number, a variable left out, a line left out, doubled or in the wrong place.
   subroutine slip(random, text)
      type(generator_type), intent(inout) :: random
      character(:), allocatable, intent(inout) :: text
      character(*), parameter :: in_number(*) = [character(3) :: '-', '.', ',', '0', '1e3', 'e-3', ' ', ', 2', '*']
      character(*), parameter :: stops(*) = [character(1) :: '''', '=', ',', '/', '&', '!', n]
      integer :: first, last, other
      character(:), allocatable :: line

      select case (random%one_of(8))
      case (1, 2)
         ! A letter too few, too many or another.
         call find_stretch(random, text, letters, first, last)
         if (last < first) return
         first = first - 1 + random%one_of(last - first + 1)
         select case (random%one_of(3))
         case (1)
            text = text(:first - 1)//text(first + 1:)
         case (2)
            text = text(:first)//text(first:)
         case default
            other = random%one_of(len(letters))
            text(first:first) = letters(other:other)
         end select
      case (3, 4)
         ! A sign, a point, a power of ten; a digit too few.
         call find_stretch(random, text, digits, first, last)
         if (last < first) return
         first = first - 1 + random%one_of(last - first + 1)
         if (random%one_of(4) == 1) then
            text = text(:first - 1)//text(first + 1:)
         else
            other = random%one_of(size(in_number))
            text = text(:first - 1)//trim(in_number(other))//text(first:)
         end if
      case (5)
         ! One of the marks that hold the text together.
         call find_stretch(random, text, stops(random%one_of(size(stops))), first, last)
         if (last < first) return
         text = text(:first - 1)//text(first + 1:)
      case (6)
         ! A variable, up to the comma.
         call find_stretch(random, text, ',', first, last)
         if (last < first) return
         other = index(text(first + 1:), ',')
         if (other > 0) text = text(:first - 1)//text(first + other:)
      case (7)
         call find_line(random, text, first, last)
         text = text(:first - 1)//text(last + 1:)
      case default
         call find_line(random, text, first, last)
         line = text(first:last)
         call find_line(random, text, first, last)
         text = text(:first - 1)//line//text(first:)
      end select
   end subroutine slip

   !> A stretch of characters of a set, drawn at random; from a place on, or before.
   subroutine find_stretch(random, text, set, first, last)
      type(generator_type), intent(inout) :: random
      character(*), intent(in) :: text, set
      integer, intent(out) :: first, last
      integer :: from

      first = 1
      last = 0
      if (scan(text, set) == 0) return
      from = random%one_of(len(text))
      if (scan(text(from:), set) == 0) from = 1
      first = from - 1 + scan(text(from:), set)
      last = first - 1 + max(1, verify(text(first:)//n//'=', set) - 1)
   end subroutine find_stretch

   !> A line with its end.
   subroutine find_line(random, text, first, last)
      type(generator_type), intent(inout) :: random
      character(*), intent(in) :: text
      integer, intent(out) :: first, last
      integer :: from

      first = 1
      last = 0
      if (len(text) == 0) return
      from = random%one_of(len(text))
      first = index(text(:from - 1), n, back=.true.) + 1
      last = index(text(first:)//n, n) + first - 1
      last = min(last, len(text))
   end subroutine find_line

end module hard_slips
