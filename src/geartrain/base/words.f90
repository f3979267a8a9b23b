!> Sentences that state frequencies. Each Lambda is a value beside the text, so that a report can state it in another unit.
module geartrain_base_words
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: short => text
   implicit none (type, external)
   private
   public :: lambda, operator(//), place_type, words_type

   !> A frequency, or a range of frequencies, in a text.
   type :: place_type
      !> Its first and last letter in the text.
      integer :: first = 0, last = 0
      !> Lambda; of a range its begin and its end [1].
      real(dp) :: from = 0, to = 0
   end type place_type

   type :: words_type
      !> The sentence, with frequencies as 'Lambda = 0.5' or 'Lambda = 0.5 to 1'.
      character(:), allocatable :: text
      !> The frequencies in it, in their order.
      type(place_type), allocatable :: places(:)
   end type words_type

   !> Makes words of a text without frequencies.
   interface words_type
      module procedure plain
   end interface words_type

   !> Joins two pieces of a sentence.
   interface operator(//)
      module procedure after_text
      module procedure before_text
      module procedure joined
   end interface operator(//)

contains

   pure type(words_type) function plain(text) result(words)
      !> Any text.
      character(*), intent(in) :: text

      words%text = text
      allocate (words%places(0))
   end function plain

   !> A frequency, or a range of frequencies, as a piece of a sentence.
   pure type(words_type) function lambda(from, to) result(words)
      !> Lambda [1].
      real(dp), intent(in) :: from
      !> End of a range [1]; absent: there is one frequency.
      real(dp), intent(in), optional :: to

      words%text = 'Lambda = '//short(from)
      if (present(to)) words%text = words%text//' to '//short(to)
      allocate (words%places(1))
      words%places = place_type(1, len(words%text), from, from)
      if (present(to)) words%places%to = to
   end function lambda

   pure type(words_type) function after_text(text, words) result(both)
      character(*), intent(in) :: text
      type(words_type), intent(in) :: words

      both%text = text//words%text
      both%places = words%places
      both%places%first = both%places%first + len(text)
      both%places%last = both%places%last + len(text)
   end function after_text

   pure type(words_type) function before_text(words, text) result(both)
      type(words_type), intent(in) :: words
      character(*), intent(in) :: text

      both%text = words%text//text
      both%places = words%places
   end function before_text

   pure type(words_type) function joined(words, more) result(both)
      type(words_type), intent(in) :: words, more

      both = words%text//more
      both%places = [words%places, both%places]
   end function joined

end module geartrain_base_words
