!> Torques of the shafts over all motions of a case: the table of extremes, and where they change sign.
module geartrain_analyses_torque_table
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: counted, significant
   use geartrain_base_sheet, only: in_result, in_shafts, sheet_type
   use geartrain_readings_frequency_text, only: frequency_text_type, in_width
   use geartrain_readings_range_sentences, only: range_words, ranges_of_points
   use geartrain_readings_summary, only: band_type
   use geartrain_train_names, only: name_length, shaft_names, torque_names
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: say_reversals, torque_table_type

   !> Most shafts of the table of a short report.
   integer, parameter :: most = 8
   !> Share of the largest torque below which a torque of the other sign is rounding [1].
   real(dp), parameter :: rounding = 1e-6_dp
   !> Range of a torque over its largest magnitude above which an extreme where stability is lost is marked [1].
   real(dp), parameter :: worth_a_mark = 0.01_dp

   type :: torque_table_type
      private
      !> Smallest torque of each shaft, mean torque of the motion with the torque of largest magnitude, and largest torque [N m],
      !> (shaft).
      real(dp), allocatable :: low(:), mean(:), high(:)
      !> Speeds of the extremes, (shaft).
      character(40), allocatable :: at_low(:), at_high(:)
      !> Whether a shaft has a torque; whether its extremes are where stability is lost, between two motions, (shaft).
      logical, allocatable :: known(:), low_at_edge(:), high_at_edge(:)
   contains
      procedure :: take
      procedure :: put
   end type torque_table_type

contains

   !> Takes motions into account.
   subroutine take(self, mean, low, high, at, counts, told, edge)
      class(torque_table_type), intent(inout) :: self
      !> Mean, smallest and largest torque [N m], NaN where nothing determines them, (shaft, motion).
      real(dp), intent(in) :: mean(:, :), low(:, :), high(:, :)
      !> Lambda, or the parameter, of each motion, (motion).
      real(dp), intent(in) :: at(:)
      !> Whether a motion counts, (motion).
      logical, intent(in) :: counts(:)
      !> How frequencies are stated.
      type(frequency_text_type), intent(in) :: told
      !> Whether the values are interpolated between two motions, where stability is lost, (motion); absent: none is.
      logical, intent(in), optional :: edge(:)
      character(:), allocatable :: place
      logical :: there(size(at)), at_edge(size(at))
      integer :: i, j

      if (.not. allocated(self%low)) then
         allocate (self%low(size(mean, 1)), self%mean(size(mean, 1)), self%high(size(mean, 1)), source=0.0_dp)
         allocate (self%at_low(size(mean, 1)), self%at_high(size(mean, 1)))
         allocate (self%known(size(mean, 1)), self%low_at_edge(size(mean, 1)), self%high_at_edge(size(mean, 1)), source=.false.)
      end if
      at_edge = .false.
      if (present(edge)) at_edge = edge
      do i = 1, size(mean, 1)
         ! A shaft without a torque has NaN.
         there = counts .and. low(i, :) <= high(i, :)
         if (.not. any(there)) cycle
         associate (largest => max(abs(low(i, :)), abs(high(i, :))))
            j = maxloc(largest, 1, there)
            if (.not. self%known(i) .or. largest(j) > max(abs(self%low(i)), abs(self%high(i)))) self%mean(i) = mean(i, j)
         end associate
         j = minloc(low(i, :), 1, there)
         if (.not. self%known(i) .or. low(i, j) < self%low(i)) then
            self%low(i) = low(i, j)
            call told%with_unit(told%number(at(j)), place)
            self%at_low(i) = place
            self%low_at_edge(i) = at_edge(j)
         end if
         j = maxloc(high(i, :), 1, there)
         if (.not. self%known(i) .or. high(i, j) > self%high(i)) then
            self%high(i) = high(i, j)
            call told%with_unit(told%number(at(j)), place)
            self%at_high(i) = place
            self%high_at_edge(i) = at_edge(j)
         end if
         self%known(i) = .true.
      end do
   end subroutine take

   !> Writes the table.
   subroutine put(self, train, sheet)
      class(torque_table_type), intent(in) :: self
      !> The train as given.
      type(train_type), intent(in) :: train
      type(sheet_type), intent(inout) :: sheet
      character(name_length), allocatable :: names(:)
      logical, dimension(size(self%known)) :: shown, low_marked, high_marked
      integer :: i, width

      if (.not. allocated(self%low)) return
      shown = self%known
      do while (count(shown) > most .and. .not. sheet%verbose)
         ! The shaft whose torque varies least, compared with its mean, is left out.
         i = minloc((self%high - self%low)/max(abs(self%mean), 1e-300_dp), 1, shown)
         shown(i) = .false.
      end do
      if (.not. any(shown)) return
      low_marked = shown .and. self%high - self%low > worth_a_mark*max(abs(self%low), abs(self%high))
      high_marked = low_marked .and. self%high_at_edge
      low_marked = low_marked .and. self%low_at_edge
      names = torque_names(train)
      width = maxval(len_trim(names), 1, shown)
      call sheet%add(in_shafts, repeat(' ', width)//'   mean [N m]   minimum  at                 maximum  at')
      do i = 1, size(names)
         if (.not. shown(i)) cycle
         call sheet%add(in_shafts, names(i)(:width)//in_width(significant(self%mean(i)), 13)//in_width(significant(self%low(i)), &
                        10)//merge('* ', '  ', low_marked(i))//self%at_low(i)(:14)// &
                        in_width(significant(self%high(i)), 12)//merge('* ', '  ', high_marked(i))//self%at_high(i))
      end do
      if (any(low_marked .or. high_marked)) call sheet%say(in_shafts, '* Where stability is lost, interpolated between two &
                                                                     &motions.')
      if (count(shown) < count(self%known)) call sheet%say(in_shafts, 'and '//counted(count(self%known) - count(shown), &
         'shaft whose torque varies', 'shafts whose torque varies')//' less')
   end subroutine put

   !> Adds sentences on the shafts whose torque changes its sign within a period.
   subroutine say_reversals(train, low, high, at, counts, connected, told, sheet)
      !> The train as given.
      type(train_type), intent(in) :: train
      !> Smallest and largest torque [N m], (shaft, motion).
      real(dp), intent(in) :: low(:, :), high(:, :)
      !> Lambda, or the parameter, of each motion, (motion).
      real(dp), intent(in) :: at(:)
      !> Whether a motion counts; whether a motion follows on the motion before it, (motion).
      logical, intent(in) :: counts(:), connected(:)
      !> How frequencies are stated.
      type(frequency_text_type), intent(in) :: told
      type(sheet_type), intent(inout) :: sheet
      character(name_length) :: names(size(train%shafts))
      type(band_type), allocatable :: ranges(:)
      character(:), allocatable :: words
      logical :: reverses(size(at))
      integer :: i, n

      names = shaft_names(train)
      n = 0
      do i = 1, size(names)
         reverses = counts .and. min(-low(i, :), high(i, :)) > rounding*max(abs(low(i, :)), abs(high(i, :)))
         if (.not. any(reverses)) cycle
         n = n + 1
         if (n > most .and. .not. sheet%verbose) cycle
         ranges = ranges_of_points(at, reverses, connected)
         call range_words(ranges, told, sheet%verbose, words)
         if (words == '') call told%with_unit(told%number(ranges(1)%from), words)
         call sheet%say(in_result, 'The torque of '//trim(names(i))//' changes sign within a period at '//words//'.')
      end do
      if (n > most .and. .not. sheet%verbose) call sheet%say(in_result, 'So does the torque of '//counted(n - most, 'more shaft', &
                                                             'more shafts')//'.')
   end subroutine say_reversals

end module geartrain_analyses_torque_table
