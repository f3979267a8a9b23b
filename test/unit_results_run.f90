!> Running a case: what is computed, cancelled, kept while it runs and left at the end.
module unit_results_run
   use geartrain_analyses_list, only: case_type, results_type
   use geartrain_base_error, only: error_type, status_ended_early, status_file
   use geartrain_base_kinds, only: dp
   use geartrain_base_observer, only: observer_type
   use geartrain_input_reader, only: read_case_text
   use geartrain_run_checkpoint, only: checkpoint_type
   use geartrain_run_results, only: write_results
   use geartrain_run_run_case, only: run_case
   use testing, only: scratch, tests_type
   implicit none (type, external)
   private
   public :: results_run_tests

   character(*), parameter :: path = scratch//'run.h5', newline = new_line('a')
   !> A single pair without backlash: quick.
   character(*), parameter :: pair = '&train input_torque = 1.0, characteristic_length = 1.0, &
      &characteristic_frequency = 1.0, prime_mover_inertia = 0.0, load_inertia = 0.0 /'//newline// &
      '&shaft rigid = .true. /'//newline// &
      '&mesh driving_radius = 1.0, driven_radius = 1.0, driving_inertia = 2.0, driven_inertia = 2.0, stiffness = 1.0, &
      &damping_ratio = 0.1, half_backlash = 0.0, stiffness_cos = 0.1 /'//newline// &
      '&shaft rigid = .true. /'//newline

   !> Counts the steps; says no at one of them.
   type, extends(observer_type) :: counter_type
      integer :: steps = 0, no_at = -1
      logical :: response = .false., branch = .false., integration = .false., attractors = .false.
      !> Given these, writes what another run goes on from when it says no.
      type(case_type), pointer :: case => null()
      type(results_type), pointer :: results => null()
   contains
      procedure :: on_step
   end type counter_type

contains

   subroutine results_run_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('whole')) call whole(tests)
      if (tests%runs('further_branches')) call further_branches(tests)
      if (tests%runs('cancelled')) call cancelled(tests)
      if (tests%runs('nowhere_to_write')) call nowhere_to_write(tests)
      if (tests%runs('checkpoints')) call checkpoints(tests)
      if (tests%runs('map_resumed')) call map_resumed(tests)
      if (tests%runs('ramp_resumed')) call ramp_resumed(tests)
      call remove(path)
      call remove(path//'.partial')
   end subroutine results_run_tests

   subroutine whole(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type) :: case
      type(results_type) :: results
      type(error_type), allocatable :: error
      type(counter_type) :: counter

      call read_pair(tests, '&modes /'//newline//'&response from = 0.4, to = 0.5 /'//newline// &
                     '&integration from = 0.4, to = 0.5, points = 2 /', case)
      call run_case(case, path, results, error, counter)
      call tests%is_true(.not. allocated(error), 'no error')
      call tests%is_true(allocated(results%modes) .and. allocated(results%response) .and. allocated(results%integration), &
                         'all three analyses are computed')
      call tests%is_true(counter%response .and. counter%integration, 'the observer is told of both')
      call tests%is_true(there(path), 'the file is there')
      call tests%is_true(.not. there(path//'.partial'), 'and no checkpoint beside it')
      call remove(path)

      case%modes = .false.
      deallocate (case%integration)
      call run_case(case, '', results, error)
      call tests%is_true(.not. allocated(results%modes) .and. .not. allocated(results%integration), 'only what is asked for')
      call tests%is_true(.not. there(path), 'without a path nothing is written')
   end subroutine whole

   !> Everything that follows from a response and from random starts: the single pair with backlash, strongly excited.
   subroutine further_branches(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type) :: case
      type(results_type) :: results
      type(error_type), allocatable :: error
      type(counter_type) :: counter, told
      integer :: i

      call read_pair(tests, '&response from = 1.2, to = 2.6, period_doublings = 1 /'//newline// &
                     '&attractors frequency = 1.6, starts = 8, max_periods = 300, follow = .true. /', case)
      case%train%meshes(1)%half_backlash = 1
      case%train%meshes(1)%damping_ratio = 0.03_dp
      case%train%meshes(1)%stiffness_cos = [0.4_dp]
      call run_case(case, path, results, error, counter)
      call tests%is_true(.not. allocated(error), 'no error')
      call tests%is_true(allocated(results%attractors) .and. allocated(results%branches), 'attractors and branches are computed')
      if (.not. allocated(results%branches)) return
      call tests%is_true(counter%branch .and. counter%attractors, 'the observer is told of both')
      call tests%is_true(size(results%branches) > 0, 'there is a further branch')
      do i = 1, size(results%branches)
         call tests%is_true(results%branches(i)%complete .and. results%branches(i)%points > 10, 'branch: '// &
                            results%branches(i)%origin%text//': '//results%branches(i)%ended%text)
      end do

      ! Cancelled in the first branch after the response.
      told%no_at = results%response%points + 2
      call run_case(case, path, results, error, told)
      call tests%is_true(allocated(error), 'cancelled in a branch: an error')
      if (allocated(error)) call tests%is_true(index(error%message, 'branch 1, period doubling of the response at') > 0, &
                                               'which says in which: '//error%message)
      call tests%is_true(told%steps == told%no_at .and. .not. allocated(results%attractors), 'nothing goes on after it')

      deallocate (case%response)
      call run_case(case, path, results, error)
      call tests%is_true(allocated(error), 'attractors to be followed without a response: an error')
      if (allocated(error)) call tests%is_text(error%message, '&attractors: follow = .true.: needs &response: its range and &
                                               &settings are those of the branches', 'message')
      call remove(path)
   end subroutine further_branches

   subroutine cancelled(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type) :: case
      type(results_type) :: results
      type(error_type), allocatable :: error
      type(counter_type) :: counter

      call read_pair(tests, '&response from = 0.4, to = 0.9 /'//newline// &
                     '&integration from = 0.4, to = 0.5, points = 2 /', case)
      counter%no_at = 3
      call run_case(case, path, results, error, counter)
      call tests%is_true(allocated(error), 'is an error')
      if (.not. allocated(error)) return
      call tests%is_true(error%status == status_ended_early, 'of an analysis that ended early')
      call tests%is_true(index(error%message, 'cancelled at Lambda') > 0, 'whose message says where: '//error%message)
      call tests%is_true(counter%steps == 3, 'nothing goes on after it')
      call tests%is_true(.not. results%response%complete .and. results%response%points >= 3, 'the points so far are kept')
      call tests%is_true(there(path) .and. .not. there(path//'.partial'), 'and written')
   end subroutine cancelled

   subroutine nowhere_to_write(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type) :: case
      type(results_type) :: results
      type(error_type), allocatable :: error
      type(counter_type) :: counter

      call read_pair(tests, '&response from = 0.4, to = 0.9 /', case)
      call run_case(case, 'build/no-such-folder/a.h5', results, error, counter)
      call tests%is_true(allocated(error), 'is an error')
      if (.not. allocated(error)) return
      call tests%is_true(error%status == status_file, 'of the file system')
      call tests%is_true(counter%steps == 0, 'known before anything is computed')
   end subroutine nowhere_to_write

   subroutine checkpoints(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type), target :: case
      type(results_type), target :: results
      type(counter_type), target :: counter
      type(checkpoint_type) :: checkpoint
      logical :: keep_going

      call read_pair(tests, '&modes /', case)
      checkpoint%observer => counter
      checkpoint%case => case
      checkpoint%results => results
      checkpoint%path = path//'.partial'
      call checkpoint%start(resumed=.false.)
      keep_going = .true.
      call checkpoint%on_step('response', 1, 0.5_dp, keep_going)
      call tests%is_true(.not. there(path//'.partial'), 'none before it is time')
      checkpoint%interval = 0
      call checkpoint%on_step('response', 2, 0.5_dp, keep_going)
      call tests%is_true(there(path//'.partial'), 'one when it is time')
      call tests%is_true(counter%steps == 2 .and. keep_going, 'the steps are passed on')
      counter%no_at = 3
      call checkpoint%on_step('response', 3, 0.5_dp, keep_going)
      call tests%is_true(.not. keep_going, 'no is passed back')
      keep_going = .true.
      call checkpoint%on_step('integration', 1, 0.5_dp, keep_going)
      call tests%is_true(.not. keep_going, 'no stays no')
   end subroutine checkpoints

   !> A map under way goes on with its missing rows, to the same bits as one computed in one go.
   subroutine map_resumed(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type), target :: case
      type(results_type), target :: results
      type(results_type) :: whole
      type(error_type), allocatable :: error
      type(counter_type) :: counter, told
      integer :: known

      call read_pair(tests, '&stability_map from = 0.5, to = 2.5, points = 5, parameter_from = 0.1, parameter_to = 0.5, &
                     &parameter_points = 40, linear = .true. /', case)
      call run_case(case, '', whole, error)
      told%no_at = 3
      told%case => case
      told%results => results
      call run_case(case, '', results, error, told)
      associate (map => results%stability_map)
         call tests%is_true(size(map%done) >= 3 .and. size(map%done) < 40 .and. all(map%done), 'a cancelled map holds its rows')
         call tests%is_true(all(shape(map%multiplier) == [5, size(map%done)]) .and. size(map%parameter) == size(map%done), &
                            'and no others')
      end associate
      call run_case(case, path, results, error, counter, path//'.partial')
      call tests%is_true(.not. allocated(error), 'no error')
      known = 40 - counter%steps
      call tests%is_true(known == 3, 'only the missing rows are computed')
      call tests%is_true(results%stability_map%complete .and. all(results%stability_map%done), 'all rows are there')
      call tests%is_true(.not. any(abs(results%stability_map%multiplier - whole%stability_map%multiplier) > 0), 'the same bits')
      call tests%is_true(.not. there(path//'.partial'), 'the checkpoint gone on with is removed')
   end subroutine map_resumed

   !> A run-up under way goes on at the window at which it stopped, to the same bits.
   subroutine ramp_resumed(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type), target :: case
      type(results_type), target :: results
      type(results_type) :: whole
      type(error_type), allocatable :: error
      type(counter_type) :: counter, told

      call read_pair(tests, '&run_up from = 0.5, to = 1.5, duration = 400.0 /', case)
      call run_case(case, '', whole, error)
      told%no_at = 20
      told%case => case
      told%results => results
      call run_case(case, '', results, error, told)
      associate (ramp => results%run_up)
         call tests%is_true(ramp%samples > 0 .and. ramp%windows < whole%run_up%windows .and. .not. ramp%complete, 'cancelled')
         call tests%is_true(index(ramp%ended%text, 'cancelled at Lambda = ') == 1, 'says so')
      end associate
      call run_case(case, path, results, error, counter, path//'.partial')
      call tests%is_true(.not. allocated(error), 'no error')
      if (allocated(error)) return
      call tests%is_true(counter%steps < whole%run_up%windows .and. counter%steps > 0, 'only what is missing is computed')
      associate (ramp => results%run_up, other => whole%run_up)
         call tests%is_true(ramp%complete .and. ramp%samples == other%samples .and. ramp%start_period == 1, 'all is there')
         call tests%is_true(.not. any(abs(ramp%displacement - other%displacement) > 0) .and. &
                            .not. any(abs(ramp%mesh_force - other%mesh_force) > 0) .and. &
                            .not. any(abs(ramp%time - other%time) > 0) .and. &
                            .not. any(abs(ramp%force_maximum - other%force_maximum) > 0), 'the same bits')
      end associate
      call tests%is_true(.not. there(path//'.partial'), 'the checkpoint gone on with is removed')
   end subroutine ramp_resumed

   !> The single pair with these analyses.
   subroutine read_pair(tests, analyses, case)
      class(tests_type), intent(inout) :: tests
      character(*), intent(in) :: analyses
      type(case_type), intent(out) :: case
      type(error_type), allocatable :: error

      call read_case_text(pair//analyses//newline, '', case, error)
      call tests%is_true(.not. allocated(error), 'the case is read')
   end subroutine read_pair

   subroutine on_step(self, analysis, done, frequency_ratio, keep_going)
      class(counter_type), intent(inout) :: self
      character(*), intent(in) :: analysis
      integer, intent(in) :: done
      real(dp), intent(in) :: frequency_ratio
      logical, intent(inout) :: keep_going
      type(error_type), allocatable :: error

      self%steps = self%steps + 1
      if (analysis == 'response') self%response = done > 0 .and. frequency_ratio > 0
      if (analysis == 'branch') self%branch = done > 0 .and. frequency_ratio > 0
      if (analysis == 'attractors') self%attractors = done > 0 .and. frequency_ratio > 0
      if (analysis == 'integration') self%integration = done > 0 .and. frequency_ratio > 0
      if (self%steps /= self%no_at) return
      keep_going = .false.
      if (associated(self%results)) call write_results(path//'.partial', self%case, self%results, error)
   end subroutine on_step

   logical function there(name)
      character(*), intent(in) :: name

      inquire (file=name, exist=there)
   end function there

   subroutine remove(name)
      character(*), intent(in) :: name
      integer :: unit

      if (.not. there(name)) return
      open (newunit=unit, file=name)
      close (unit, status='delete')
   end subroutine remove

end module unit_results_run
