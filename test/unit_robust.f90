!> What keeps a run from harm: checksums, fields that do not agree with themselves, work that is interrupted in its midst.
module unit_robust
   use, intrinsic :: iso_fortran_env, only: int64, int8
   use fixtures, only: rattling_pair, settings_of
   use geartrain, only: attractors, attractors_type, branch_type, case_type, dp, error_type, interrupt_by, observer_type, &
      read_case_text, response, results_type, run_case, run_up, run_up_type, stability_map, stability_map_type, &
      status_file, status_input, sweep, sweep_type
   use geartrain_base_checksum, only: crc64
   use geartrain_base_field, only: values_type
   use geartrain_base_fields, only: fields_type
   use geartrain_results_seal, only: add_seal, is_whole
   use geartrain_run_results, only: results_bytes, take_results, visit_results
   use testing, only: scratch, tests_type
   implicit none (type, external)
   private
   public :: robust_tests

   !> Says no to all, and counts.
   type, extends(observer_type) :: stopper_type
      integer :: calls = 0
   contains
      procedure :: on_step
   end type stopper_type

   character(*), parameter :: path = scratch//'robust.h5', newline = new_line('a')
   !> A single pair with backlash: quick.
   character(*), parameter :: pair = '&train input_torque = 0.8, characteristic_length = 1.0, &
      &characteristic_frequency = 1.0, prime_mover_inertia = 0.0, load_inertia = 0.0 /'//newline// &
      '&shaft rigid = .true. /'//newline// &
      '&mesh driving_radius = 1.0, driven_radius = 1.0, driving_inertia = 2.0, driven_inertia = 2.0, stiffness = 1.0, &
      &damping_ratio = 0.05, half_backlash = 1.0, stiffness_cos = 0.3 /'//newline// &
      '&shaft rigid = .true. /'//newline
   character(*), parameter :: analyses = '&response from = 0.4, to = 1.2, period_doublings = 1 /'//newline// &
      '&integration from = 0.4, to = 0.5, points = 3 /'//newline//'&attractors frequency = 0.6, starts = 4 /'//newline// &
      '&stability_map from = 0.4, to = 0.5, points = 3, parameter_from = 0.1, parameter_to = 0.2, parameter_points = 3 /'// &
      newline//'&run_up from = 0.4, to = 0.5, duration = 200.0, samples = 8 /'//newline

contains

   subroutine robust_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('checksums')) call checksums(tests)
      if (tests%runs('damaged_fields')) call damaged_fields(tests)
      if (tests%runs('measured')) call measured(tests)
      if (tests%runs('interrupted')) call interrupted(tests)
      if (tests%runs('stopped_before_a_motion')) call stopped_before_a_motion(tests)
      if (tests%runs('others_checkpoint')) call others_checkpoint(tests)
   end subroutine robust_tests

   subroutine on_step(self, analysis, done, frequency_ratio, keep_going)
      class(stopper_type), intent(inout) :: self
      character(*), intent(in) :: analysis
      integer, intent(in) :: done
      real(dp), intent(in) :: frequency_ratio
      logical, intent(inout) :: keep_going

      associate (unused_1 => analysis, unused_2 => done, unused_3 => frequency_ratio)
      end associate
      self%calls = self%calls + 1
      keep_going = .false.
   end subroutine on_step

   !> Newton's method from rest finds no motion of this train: the first call of the observer is that of the flow from rest.
   subroutine stopped_before_a_motion(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type), target :: branch
      type(error_type), allocatable :: error
      type(stopper_type) :: observer

      call response(rattling_pair(0.02_dp), settings_of(0.5_dp, 0.55_dp, 3, 1), branch, error, observer=observer)
      call tests%is_true(.not. allocated(error) .and. branch%cancelled .and. branch%points == 0, &
                         'a no to the flow ends the response')
      call tests%is_true(branch%ended%text == 'cancelled at Lambda = 0.5' .and. observer%calls == 1, &
                         'and it says so, after one call')
   end subroutine stopped_before_a_motion

   !> The check value of CRC-64/XZ is that of the catalogue of parametrised CRC algorithms.
   subroutine checksums(tests)
      class(tests_type), intent(inout) :: tests
      integer(int8), allocatable :: content(:), damaged(:)
      logical :: seen
      integer :: i, k

      content = transfer('123456789', content)
      call tests%is_true(crc64(content) == int(z'995DC9BBDF1939FA', int64), 'of the nine digits')
      call tests%is_true(crc64(content(:0)) == 0_int64, 'of nothing')
      content = [(int(mod(37*i, 256) - 128, int8), i=1, 300)]
      call add_seal(content)
      call tests%is_true(is_whole(content), 'a sealed file is whole')
      seen = .true.
      do i = 1, size(content)
         do k = 0, 7
            damaged = content
            damaged(i) = ieor(damaged(i), int(shiftl(1, k) - merge(256, 0, k == 7), int8))
            seen = seen .and. .not. is_whole(damaged)
         end do
         seen = seen .and. .not. is_whole(content(:i - 1))
      end do
      call tests%is_true(seen, 'every flip of a bit and every loss of its end is seen')
   end subroutine checksums

   !> Without the checksum, as if another program had written them: fields that are changed are told apart or can be used, never a
   !> crash (and never memory that is not theirs, in the debug profile).
   subroutine damaged_fields(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type) :: case
      type(results_type) :: results, again
      type(error_type), allocatable :: error
      type(fields_type) :: fields, damaged
      character(:), allocatable :: wrong
      integer(int64) :: generator
      integer :: i, told

      call read_pair(tests, analyses, case)
      call run_case(case, '', results, error)
      call tests%is_true(.not. allocated(error), 'the case runs')
      call visit_results(results, case, fields, summary=.true.)
      damaged = fields
      call take_results(damaged, case, again, wrong)
      call tests%is_text(wrong, '', 'what is read back agrees with its case')
      generator = 1
      told = 0
      do i = 1, 3000
         damaged = fields
         call damage(damaged, generator)
         call take_results(damaged, case, again, wrong)
         if (wrong /= '') told = told + 1
      end do
      call tests%is_true(told > 300, 'what does not fit is told')
      do i = 1, fields%count
         damaged = fields
         damaged%groups(i)%count = 0
         call take_results(damaged, case, again, wrong)
         call tests%is_true((wrong == '') .eqv. is_computed(fields%groups(i)%path), 'an empty group: '//fields%groups(i)%path)
      end do
      deallocate (case%attractors)
      damaged = fields
      call take_results(damaged, case, again, wrong)
      call tests%is_text(wrong, 'attractors in it does not agree with the rest', 'attractors that nobody asked for')
   end subroutine damaged_fields

   !> Whether a group is read off a branch anew, so that nobody misses it.
   pure logical function is_computed(path)
      character(*), intent(in) :: path

      is_computed = index(path, 'peaks') + index(path, 'jumps') + index(path, 'bands') + index(path, 'ranges') > 0
   end function is_computed

   !> Changes a field: its name, an extent, its kind, a value, or how many values there are.
   subroutine damage(fields, generator)
      type(fields_type), intent(inout) :: fields
      integer(int64), intent(inout) :: generator
      integer :: i

      i = 1 + below(generator, fields%count)
      call damage_field(fields%groups(i)%fields(1 + below(generator, fields%groups(i)%count)), generator)
   end subroutine damage

   subroutine damage_field(field, generator)
      type(values_type), intent(inout) :: field
      integer(int64), intent(inout) :: generator
      integer :: n, at

      n = product(field%extents)
      at = below(generator, n)
      select case (below(generator, 5))
      case (0)
         field%about%name = 'another'
      case (1)
         if (size(field%extents) == 0) return
         at = 1 + below(generator, size(field%extents))
         field%extents(at) = field%extents(at) + below(generator, 3) - 1
      case (2)
         field%kind = 'r'
         if (.not. allocated(field%reals)) allocate (field%reals(0))
      case (3)
         if (n == 0) return
         if (allocated(field%integers)) field%integers(1 + at) = below(generator, 1000) - 500
         if (allocated(field%texts)) field%texts(1 + at)%text = 'another'
      case default
         if (allocated(field%reals)) field%reals = field%reals(:at)
         if (allocated(field%integers)) field%integers = field%integers(:at)
      end select
   end subroutine damage_field

   !> 0 .. n - 1.
   integer function below(generator, n)
      integer(int64), intent(inout) :: generator
      integer, intent(in) :: n

      generator = mod(48271_int64*generator, 2147483647_int64)
      below = int(mod(generator/7, int(max(1, n), int64)))
   end function below

   !> Measuring results under way, as is done between two steps, changes none of them, and finds the bytes that writing takes.
   subroutine measured(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type) :: case
      type(results_type) :: results
      type(error_type), allocatable :: error
      type(fields_type) :: before, after
      integer(int64) :: bytes, found
      integer :: i, j

      call read_pair(tests, analyses, case)
      call run_case(case, '', results, error)
      call tests%is_true(.not. allocated(error), 'the case runs')
      call visit_results(results, case, before, summary=.false.)
      found = results_bytes(results, case)
      call visit_results(results, case, after, summary=.false.)
      call tests%is_true(before%count == after%count, 'as many groups after measuring')
      bytes = 0
      do i = 1, after%count
         call tests%is_true(before%groups(i)%count == after%groups(i)%count, 'as many fields in '//after%groups(i)%path)
         do j = 1, after%groups(i)%count
            associate (field => after%groups(i)%fields(j), old => before%groups(i)%fields(j))
               call tests%is_true(all(old%extents == field%extents), 'the extents of '//field%about%name)
               if (allocated(field%reals)) then
                  call tests%is_true(all(transfer(old%reals, [0_int64]) == transfer(field%reals, [0_int64])), field%about%name)
                  bytes = bytes + 8*size(field%reals)
               end if
               if (allocated(field%integers)) then
                  call tests%is_true(all(old%integers == field%integers), field%about%name)
                  bytes = bytes + 4*size(field%integers)
               end if
            end associate
         end do
      end do
      ! Speeds, which follow from the frequencies, are written but not measured; texts are measured roughly.
      call tests%is_true(found > 0.8_dp*bytes .and. found < 1.5_dp*bytes, 'the bytes of the fields')
   end subroutine measured

   !> The flag is up from the beginning: every analysis ends at once, says that it is not complete and keeps nothing half done.
   subroutine interrupted(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type) :: case
      type(results_type) :: results
      type(branch_type) :: branch
      type(sweep_type) :: motions
      type(stability_map_type) :: map
      type(attractors_type) :: found
      type(run_up_type) :: ramp
      type(error_type), allocatable :: error
      integer(int64), target :: flag

      call read_pair(tests, analyses, case)
      flag = 1
      case%train%interrupt = interrupt_by(flag)
      call response(case%train, case%response, branch, error)
      call tests%is_true(branch%cancelled .and. branch%points == 0 .and. .not. branch%complete, 'a response')
      call tests%is_text(branch%ended%text, 'cancelled before its first point', 'says so')
      call sweep(case%train, case%integration, motions, error)
      call tests%is_true(size(motions%motions) == 0 .and. .not. motions%complete, 'a sweep')
      call attractors(case%train, case%attractors, found, error)
      call tests%is_true(size(found%motions) == 0 .and. found%starts == 0 .and. .not. found%complete, 'a search')
      call stability_map(case%train, case%stability_map, map, error)
      call tests%is_true(size(map%parameter) == 0 .and. .not. map%complete, 'a map')
      call run_up(case%train, case%run_up, ramp, error)
      call tests%is_true(ramp%samples == 0 .and. .not. ramp%complete .and. allocated(ramp%ended), 'a run-up')
      call run_case(case, '', results, error)
      call tests%is_true(allocated(error) .and. .not. allocated(results%integration), 'a run goes on with nothing more')
      flag = 0
      call response(case%train, case%response, branch, error)
      call tests%is_true(branch%complete, 'with the flag down the work is done')
   end subroutine interrupted

   !> A file where the checkpoint goes that this run has neither begun nor gone on with.
   subroutine others_checkpoint(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type) :: case
      type(results_type) :: results
      type(error_type), allocatable :: error
      character(5) :: content
      integer :: unit

      call read_pair(tests, '&modes /'//newline, case)
      open (newunit=unit, file=path//'.partial', access='stream', form='unformatted', status='replace')
      write (unit) 'whose'
      close (unit)
      call run_case(case, path, results, error)
      call tests%is_true(allocated(error), 'is an error')
      if (allocated(error)) then
         call tests%is_true(error%status == status_input, 'of what was asked for')
         call tests%is_true(index(error%message, path//'.partial: error: ') == 1, 'and names the file: '//error%message)
      end if
      call run_case(case, path, results, error, resume=path//'.partial')
      call tests%is_true(allocated(error), 'to go on with it is an error')
      if (allocated(error)) call tests%is_true(error%status == status_file, 'of the file')
      open (newunit=unit, file=path//'.partial', access='stream', form='unformatted', status='old')
      read (unit) content
      close (unit, status='delete')
      call tests%is_text(content, 'whose', 'the file is as it was')
   end subroutine others_checkpoint

   subroutine read_pair(tests, analyses, case)
      class(tests_type), intent(inout) :: tests
      character(*), intent(in) :: analyses
      type(case_type), intent(out) :: case
      type(error_type), allocatable :: error

      call read_case_text(pair//analyses, '', case, error)
      call tests%is_true(.not. allocated(error), 'the case is read')
   end subroutine read_pair

end module unit_robust
