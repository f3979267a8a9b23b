!> Basins: motions that flights are recognised by without tables, and what an observer is told within the work.
module unit_basins
   use fixtures, only: paper_train
   use geartrain, only: basins, basins_settings_type, basins_type, dp, error_type, observer_type
   use geartrain_analyses_basins, only: basins_analysis_type
   use geartrain_base_words, only: words_type
   use geartrain_flow_approach, only: approach_type
   use geartrain_flow_recognition, only: recognition_type
   use geartrain_flow_section_map, only: section_map_type
   use geartrain_network_system, only: build_system, system_type
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: basins_tests

   !> Counts the calls of each phase, and ends the work at a call.
   type, extends(observer_type) :: counter_type
      integer :: random_starts = 0, rows = 0, calls = 0, last = huge(0), most_done = 0
   contains
      procedure :: on_step
   end type counter_type

contains

   subroutine basins_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('by_approach')) call by_approach(tests)
      if (tests%runs('told_within')) call told_within(tests)
      if (tests%runs('ended_within')) call ended_within(tests)
   end subroutine basins_tests

   subroutine on_step(self, analysis, done, frequency_ratio, keep_going)
      class(counter_type), intent(inout) :: self
      character(*), intent(in) :: analysis
      integer, intent(in) :: done
      real(dp), intent(in) :: frequency_ratio
      logical, intent(inout) :: keep_going

      associate (unused => frequency_ratio)
      end associate
      self%calls = self%calls + 1
      if (analysis == 'random starts') self%random_starts = self%random_starts + 1
      if (analysis == 'basins') self%rows = self%rows + 1
      if (analysis == 'basins') self%most_done = max(self%most_done, done)
      if (self%calls >= self%last) keep_going = .false.
   end subroutine on_step

   type(basins_settings_type) function grid() result(settings)
      settings%frequency = 0.7_dp
      settings%mesh = 2
      settings%starts = 40
      settings%displacement_points = 12
      settings%velocity_points = 10
      settings%displacement_start = -4
      settings%displacement_stop = 6
   end function grid

   !> Three motions at Lambda = 0.7: every start of a grid, flown without tables, goes to the motion in whose ball it ends.
   subroutine by_approach(tests)
      class(tests_type), intent(inout) :: tests
      type(basins_type) :: found
      type(system_type), target :: system
      type(section_map_type) :: map
      type(recognition_type) :: known
      type(approach_type) :: watches, approach
      type(error_type), allocatable :: error
      real(dp), allocatable :: state(:)
      integer :: i, j, k, motion, other, flown
      logical :: lost

      call basins(paper_train(0.3_dp), grid(), found, error)
      call tests%is_true(.not. allocated(error) .and. size(found%motions) == 3, 'three motions')
      if (allocated(error)) return
      call build_system(paper_train(0.3_dp), system)
      call map%setup(system, found%frequency_ratio)
      map%intervals = 0
      do i = 1, size(found%motions)
         call known%setup(system, map, found%motions(i)%period, found%motions(i)%state)
         call tests%is_true(allocated(known%attraction), 'a motion without a ball')
         if (allocated(known%attraction)) call watches%add(known%attraction, i)
      end do
      other = 0
      flown = 0
      do j = 1, size(found%velocity)
         do i = 1, size(found%displacement)
            state = found%base
            state(found%displacement_place) = found%displacement(i)
            state(found%velocity_place) = found%velocity(j)
            approach = watches
            lost = .false.
            do k = 0, 500
               call approach%look(state, k, 1e-9_dp, motion)
               if (motion > 0) exit
               call map%pass_period(state, lost)
            end do
            flown = flown + k
            if (motion /= found%label(i, j)) other = other + 1
         end do
      end do
      call tests%is_true(other == 0, 'no start with another motion')
      ! A flight is at its motion, to the tolerance, after some hundred periods.
      call tests%is_true(flown < 100*size(found%label), 'long before it is there')
   end subroutine by_approach

   !> The observer gets every random start and every start of the grid, not only every 32nd and 256th.
   subroutine told_within(tests)
      class(tests_type), intent(inout) :: tests
      type(basins_type) :: found
      type(counter_type) :: counter
      type(error_type), allocatable :: error

      call basins(paper_train(0.3_dp), grid(), found, error, counter)
      call tests%is_true(.not. allocated(error), 'basins')
      call tests%is_true(counter%random_starts >= 40 .and. counter%rows >= 120, 'a call for each start')
      call tests%is_true(counter%most_done == 10, 'rows done')
   end subroutine told_within

   !> Ended during the random starts there are no basins; ended in the first batch of rows none of its rows counts as done.
   subroutine ended_within(tests)
      class(tests_type), intent(inout) :: tests
      type(basins_type), target :: found
      type(basins_type) :: begun
      type(basins_analysis_type) :: analysis
      type(words_type), allocatable :: early
      type(counter_type) :: counter
      type(error_type), allocatable :: error

      counter%last = 3
      call basins(paper_train(0.3_dp), grid(), found, error, counter)
      call tests%is_true(.not. allocated(error) .and. .not. allocated(found%label), 'ended during the random starts')
      call tests%is_true(counter%calls == 3, 'no call after that')
      analysis%result => found
      call analysis%tell_end(early)
      call tests%is_true(index(early%text, 'random starts') > 0, 'and the run says so')
      counter = counter_type()
      call basins(paper_train(0.3_dp), grid(), found, error, counter)
      counter%last = counter%calls - 60
      counter%calls = 0
      call basins(paper_train(0.3_dp), grid(), begun, error, counter)
      call tests%is_true(.not. allocated(error) .and. allocated(begun%label), 'ended in the grid')
      if (.not. allocated(begun%label)) return
      call tests%is_true(.not. begun%complete .and. all(begun%label == -2), 'without the rows of the batch')
   end subroutine ended_within

end module unit_basins
