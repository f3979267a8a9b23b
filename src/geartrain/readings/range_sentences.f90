!> Ranges of the speed, or of a parameter, as words.
module geartrain_readings_range_sentences
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_sorting, only: ascending
   use geartrain_readings_frequency_text, only: frequency_text_type
   use geartrain_readings_summary, only: band_type
   implicit none (type, external)
   private
   public :: place_words, ranges_of_points, range_words

   !> Most ranges, and most places, of a list in a short report.
   integer, parameter :: most = 4, most_places = 3

contains

   !> Ranges with their unit: 'Lambda 0.5772 to 0.7320, 0.8849 to 0.9375', '1667 to 1680 rpm'. Ranges that touch in the digits
   !> printed are joined; of several ranges those without width in these digits are left out.
   subroutine range_words(ranges, told, all, words)
      !> The ranges, ascending.
      type(band_type), intent(in) :: ranges(:)
      !> How frequencies are stated.
      type(frequency_text_type), intent(in) :: told
      !> Whether all ranges are listed, however many they are.
      logical, intent(in) :: all
      !> The words; '' without ranges.
      character(:), allocatable, intent(out) :: words
      character(:), allocatable :: list
      type(band_type) :: shown(size(ranges))
      integer :: i, n, listed, left

      n = 0
      do i = 1, size(ranges)
         if (n > 0) then
            if (told%number(ranges(i)%from) == told%number(shown(n)%to)) then
               shown(n)%to = ranges(i)%to
               cycle
            end if
         end if
         n = n + 1
         shown(n) = ranges(i)
      end do
      list = ''
      listed = 0
      left = 0
      do i = 1, n
         associate (from => told%number(shown(i)%from), to => told%number(shown(i)%to))
            if (n > 1 .and. from == to) cycle
            listed = listed + 1
            if (listed > most .and. .not. all) then
               left = left + 1
               cycle
            end if
            if (list /= '') list = list//', '
            list = list//trim(from)
            if (from /= to) list = list//' to '//trim(to)
         end associate
      end do
      words = ''
      if (list /= '') call told%with_unit(list, words)
      if (left > 0) words = words//' and '//text(left)//trim(merge(' more range ', ' more ranges', left == 1))
   end subroutine range_words

   !> Distinct places with their unit, ascending: 'Lambda 0.5772, 0.7320', '1613, 1620 rpm and 3 more'.
   subroutine place_words(at, told, all, words)
      !> Lambda, or the parameter, of each place, at least one.
      real(dp), intent(in) :: at(:)
      !> How frequencies are stated.
      type(frequency_text_type), intent(in) :: told
      !> Whether all places are listed, however many they are.
      logical, intent(in) :: all
      !> The words.
      character(:), allocatable, intent(out) :: words
      character(:), allocatable :: list, last
      real(dp) :: sorted(size(at))
      integer :: i, listed, left

      sorted = at(ascending(at))
      list = ''
      last = ''
      listed = 0
      left = 0
      do i = 1, size(sorted)
         if (trim(told%number(sorted(i))) == last) cycle
         last = trim(told%number(sorted(i)))
         if (listed == most_places .and. .not. all) then
            left = left + 1
            cycle
         end if
         listed = listed + 1
         if (list /= '') list = list//', '
         list = list//last
      end do
      call told%with_unit(list, words)
      if (left > 0) words = words//' and '//text(left)//' more'
   end subroutine place_words

   !> Ranges that neighbouring points of a list span where a condition holds.
   pure function ranges_of_points(at, holds, connected) result(ranges)
      !> Lambda, or the parameter, of each point, (point).
      real(dp), intent(in) :: at(:)
      !> Whether the condition holds at the point, and whether the point follows on the point before it, (point).
      logical, intent(in) :: holds(:), connected(:)
      type(band_type), allocatable :: ranges(:)
      type(band_type) :: swap
      integer :: i, n

      allocate (ranges(0))
      do i = 1, size(at)
         if (.not. holds(i)) cycle
         n = size(ranges)
         if (i > 1 .and. n > 0) then
            if (connected(i) .and. holds(i - 1)) then
               ranges(n)%from = min(ranges(n)%from, at(i))
               ranges(n)%to = max(ranges(n)%to, at(i))
               cycle
            end if
         end if
         ranges = [ranges, band_type(at(i), at(i))]
      end do
      ! Ascending, and ranges that overlap joined: a sweep up and down passes each speed twice.
      do i = 2, size(ranges)
         do n = i, 2, -1
            if (ranges(n)%from >= ranges(n - 1)%from) exit
            swap = ranges(n)
            ranges(n) = ranges(n - 1)
            ranges(n - 1) = swap
         end do
      end do
      n = min(1, size(ranges))
      do i = 2, size(ranges)
         if (ranges(i)%from <= ranges(n)%to) then
            ranges(n)%to = max(ranges(n)%to, ranges(i)%to)
         else
            n = n + 1
            ranges(n) = ranges(i)
         end if
      end do
      ranges = ranges(:n)
   end function ranges_of_points

end module geartrain_readings_range_sentences
