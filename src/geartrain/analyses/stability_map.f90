!> The analysis &stability_map: stability over Lambda and one parameter of the train: of the linear train from its equations alone,
!> of the train with backlash from the motions on the branch at each value of the parameter. Rows, one for each value of the
!> parameter, are spread over threads and do not depend on one another, so that the numbers do not depend on how many threads there
!> are.
module geartrain_analyses_stability_map
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_analyses_analysis, only: analysis_type, group_row_type
   use geartrain_analyses_map_trains, only: map_trains_type
   use geartrain_base_words, only: words_type
   use geartrain_readings_frequency_text, only: frequency_text, frequency_text_type
   use geartrain_analyses_stability_grid, only: check_consistency, map_row_type, &
      stability_map_settings_type, stability_map_type, visit_map, visit_stability_map
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_same_motion, only: is_same_motion
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type
   use geartrain_base_fields, only: fields_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_memory, only: need
   use geartrain_base_numbers, only: counted, fixed, text
   use geartrain_base_observer, only: observer_type
   use geartrain_base_variable, only: visitor_type
   use geartrain_trace_branch, only: branch_type, response_settings_type
   use geartrain_analyses_response_branch, only: response
   use geartrain_readings_solutions, only: record_crossings
   use geartrain_trace_start, only: begin_trace
   use geartrain_trace_tracer, only: tracer_type
   use geartrain_floquet_monodromy, only: monodromy_type
   use geartrain_floquet_multipliers, only: is_stable, power
   use geartrain_network_frequency_unit, only: lambda_per
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_train, only: train_type
   use geartrain_base_sheet, only: in_quality, in_result, sheet_type
   use geartrain_analyses_torque_table, only: torque_table_type
   implicit none (type, external)
   private
   public :: stability_map, stability_map_analysis_type, stability_map_row

   type(group_row_type), parameter :: stability_map_row = group_row_type('stability_map', &
      'Asks for a stability map: stability over frequency and one parameter of the train.', steps='rows', set_aside=.true.)

   type, extends(analysis_type) :: stability_map_analysis_type
      type(stability_map_settings_type), pointer :: settings => null()
      type(stability_map_type), pointer :: result => null()
   contains
      procedure :: visit_variables
      procedure :: check
      procedure :: run
      procedure :: tell_end
      procedure :: visit_fields
      procedure :: report
   end type stability_map_analysis_type

contains

   subroutine visit_variables(self, v)
      class(stability_map_analysis_type), intent(inout) :: self
      class(visitor_type), intent(inout) :: v

      call visit_stability_map(self%settings, v)
   end subroutine visit_variables

   subroutine check(self, train, seeded, checker)
      class(stability_map_analysis_type), intent(in) :: self
      type(train_type), intent(in) :: train
      logical, intent(in) :: seeded
      class(checker_type), intent(inout) :: checker

      call check_consistency(train, self%settings, checker)
   end subroutine check

   subroutine run(self, train, error, observer, start)
      class(stability_map_analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      type(error_type), allocatable, intent(out) :: error
      class(observer_type), intent(inout) :: observer
      type(motion_type), intent(in), optional :: start

      if (.not. allocated(self%result%ended)) call stability_map(train, self%settings, self%result, error, observer)
   end subroutine run

   subroutine tell_end(self, early)
      class(stability_map_analysis_type), intent(in) :: self
      type(words_type), allocatable, intent(out) :: early

      if (.not. self%result%complete) early = words_type(self%result%ended)
   end subroutine tell_end

   subroutine visit_fields(self, train, fields, summary)
      class(stability_map_analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      class(fields_type), intent(inout) :: fields
      logical, intent(in) :: summary

      call visit_map(self%result, self%settings, fields)
   end subroutine visit_fields

   subroutine report(self, train, sheet, torques)
      class(stability_map_analysis_type), intent(in) :: self
      type(train_type), intent(in) :: train
      type(sheet_type), intent(inout) :: sheet
      type(torque_table_type), intent(inout) :: torques
      type(frequency_text_type) :: told
      character(:), allocatable :: words
      integer :: points

      told = frequency_text(train, self%settings%unit, 0.0_dp)
      associate (map => self%result, unused => torques)
         words = 'Stability map: '//counted(size(map%parameter), 'value', 'values')//' of '//map%name//' with '// &
                 counted(size(map%frequency_ratio), 'frequency', 'frequencies')//' each ('//trim(told%unit)//')'
         points = size(map%frequency_ratio)*count(map%done)
         if (points > 0) then
            words = words//'; no stable motion on '//fixed(100*real(count(map%stable_motions == 0), dp)/points, 2)// &
                    ' % of the map, several stable motions on '// &
                    fixed(100*real(count(map%stable_motions > 1), dp)/points, 2)//' %'
         end if
         call sheet%say(in_result, words//'.')
         if (.not. allocated(map%ended)) return
         call sheet%say(in_quality, 'The stability map ended: '//map%ended//'.')
      end associate
   end subroutine report

   !> Computes a stability map.
   subroutine stability_map(train, settings, map, error, observer)
      !> The train as described.
      type(train_type), intent(in) :: train
      !> Grid, parameter and what else &stability_map asks for.
      type(stability_map_settings_type), intent(in) :: settings
      !> The map. A map under way, with `rows` but without `ended` as in a checkpoint of the same case, is taken up. A target: an
      !> observer may read the rows so far through a pointer.
      type(stability_map_type), intent(inout), target :: map
      type(error_type), allocatable, intent(out) :: error
      !> Told of 'stability map' after each row, by one thread at a time; may end the work, and the map then holds the rows done.
      class(observer_type), intent(inout), optional :: observer
      type(stability_map_settings_type), target :: copy
      type(stability_map_analysis_type) :: analysis
      type(map_trains_type) :: trains
      type(train_type) :: changed
      type(map_row_type) :: row
      integer :: i, done
      logical :: keep_going, go
      logical, allocatable :: known(:)

      copy = settings
      analysis%settings => copy
      call analysis%check_alone(train, error)
      if (allocated(error)) return
      call trains%setup(train, trim(settings%parameter), settings%start*lambda_per(train, settings%unit), &
                        settings%parameter_start, settings%parameter_stop, settings%linear, error)
      if (allocated(error)) return
      if (allocated(map%ended) .or. .not. allocated(map%rows)) call make_room(train, settings, trains%unit, map, error)
      if (allocated(error)) return
      done = count(map%done)
      known = map%done
      keep_going = .true.
      !$omp parallel do private(row, go, changed) schedule(dynamic)
      do i = 1, settings%parameter_points
         if (known(i)) cycle
         !$omp atomic read
         go = keep_going
         if (.not. go) cycle
         call trains%train_at(map%parameter(i), changed)
         call compute_row(changed, settings, map%frequency_ratio, row)
         if (train%interrupt%raised()) then
            !$omp atomic write
            keep_going = .false.
            cycle
         end if
         !$omp critical (geartrain_map)
         done = done + 1
         map%rows(i) = row
         map%whole(i) = row%whole
         map%done(i) = .true.
         go = keep_going
         if (go .and. present(observer)) call observer%on_step('stability map', done, map%parameter(i), go)
         !$omp atomic write
         keep_going = go
         !$omp end critical (geartrain_map)
      end do
      !$omp end parallel do
      call conclude(map)
   end subroutine stability_map

   !> Makes an empty map. Whether memory will suffice is found out here, not after hours.
   subroutine make_room(train, settings, unit_of_parameter, map, error)
      type(train_type), intent(in) :: train
      type(stability_map_settings_type), intent(in) :: settings
      character(*), intent(in) :: unit_of_parameter
      type(stability_map_type), intent(inout), target :: map
      type(error_type), allocatable, intent(inout) :: error
      type(stability_map_type) :: empty
      ! Bytes of a motion in the map without rms; bytes of rms for each mesh; number of copies: the map, the fields and the bytes of
      ! the file.
      integer(int64), parameter :: plain = 24, each_mesh = 8, times = 3
      integer(int64) :: bytes

      map = empty
      map%name = trim(settings%parameter)
      map%unit = unit_of_parameter
      map%linear = settings%linear
      associate (points => settings%points, rows => settings%parameter_points)
         bytes = plain
         if (.not. settings%linear) bytes = bytes + each_mesh*size(train%meshes)
         call need(real(times*bytes, dp)*points*rows, 'stability map: no memory for '//text(points)//' times '//text(rows)// &
                   ' motions', 'take fewer points', error)
         if (allocated(error)) then
            map = empty
            return
         end if
         allocate (map%rows(rows))
         allocate (map%done(rows), map%whole(rows), source=.false.)
      end associate
      map%frequency_ratio = spaced(settings%start, settings%stop, settings%points)*lambda_per(train, settings%unit)
      map%parameter = spaced(settings%parameter_start, settings%parameter_stop, settings%parameter_points)
   end subroutine make_room

   !> Equally spaced values, `from` and `to` exact.
   pure function spaced(from, to, points) result(values)
      real(dp), intent(in) :: from, to
      integer, intent(in) :: points
      real(dp) :: values(points)
      integer :: i

      values = [(from + (to - from)*(i - 1)/max(1, points - 1), i=1, points)]
      if (points > 1) values(points) = to
   end function spaced

   !> Makes the arrays of the rows and says why the map ended.
   subroutine conclude(map)
      type(stability_map_type), intent(inout) :: map
      integer :: rows, short

      rows = size(map%done)
      short = count(map%done .and. .not. map%whole)
      map%complete = all(map%done) .and. short == 0
      map%ended = 'all rows done'
      if (.not. all(map%done)) map%ended = 'cancelled after '//text(count(map%done))//' of '//text(rows)//' rows'
      call map%gather()
      if (short > 0) map%ended = map%ended//'; the branch did not get through the range in '//text(short)//' of them, where &
                                 &motions may be missing'
   end subroutine conclude

   subroutine compute_row(train, settings, frequency_ratio, row)
      type(train_type), intent(in) :: train
      type(stability_map_settings_type), intent(in) :: settings
      real(dp), intent(in) :: frequency_ratio(:)
      type(map_row_type), intent(out) :: row
      real(dp) :: nan

      nan = ieee_value(nan, ieee_quiet_nan)
      allocate (row%motions(size(frequency_ratio)), row%stable_motions(size(frequency_ratio)), source=0)
      allocate (row%multiplier(size(frequency_ratio)), source=cmplx(nan, nan, dp))
      if (settings%linear) then
         call compute_linear_row(train, frequency_ratio, row)
      else
         allocate (row%rms(size(train%meshes), size(frequency_ratio)), source=nan)
         call compute_nonlinear_row(train, settings, frequency_ratio, row)
      end if
   end subroutine compute_row

   !> A row of a linear map: without backlash the multipliers do not depend on the motion, which need not be found.
   subroutine compute_linear_row(train, frequency_ratio, row)
      type(train_type), intent(in) :: train
      real(dp), intent(in) :: frequency_ratio(:)
      type(map_row_type), intent(inout) :: row
      type(system_type), target :: system
      type(balance_type) :: balance
      type(monodromy_type) :: monodromy
      complex(dp), allocatable :: multipliers(:)
      integer :: k

      call build_system(train, system)
      call monodromy%setup(system)
      allocate (multipliers(monodromy%given))
      ! A balance without unknowns: no mesh ever separates.
      balance%system => system
      balance%eta = 1
      balance%repeats = system%excitation_order
      balance%unknowns = 0
      row%motions = 1
      do k = 1, size(frequency_ratio)
         if (system%interrupt%raised()) return
         call monodromy%integrate(balance, frequency_ratio(k))
         call monodromy%multipliers(multipliers)
         row%multiplier(k) = power(multipliers(1), balance%repeats)
         if (is_stable(multipliers)) row%stable_motions(k) = 1
      end do
   end subroutine compute_linear_row

   !> A row of a map with backlash: traces the branch without stability, then solves the motions, with stability, at each Lambda
   !> that the branch passes.
   subroutine compute_nonlinear_row(train, settings, frequency_ratio, row)
      type(train_type), intent(in) :: train
      type(stability_map_settings_type), intent(in) :: settings
      real(dp), intent(in) :: frequency_ratio(:)
      type(map_row_type), intent(inout) :: row
      type(response_settings_type) :: branch_settings
      type(branch_type) :: branch, found
      type(system_type), target :: systems(2)
      type(tracer_type) :: tracer
      type(error_type), allocatable :: error
      integer :: k, i, first

      branch_settings%start = settings%start
      branch_settings%stop = settings%stop
      branch_settings%unit = settings%unit
      branch_settings%harmonics = settings%harmonics
      branch_settings%tolerance = settings%tolerance
      branch_settings%stability = .false.
      call response(train, branch_settings, branch, error)
      row%whole = branch%complete .and. .not. allocated(error)
      if (allocated(error)) return
      call begin_trace(train, branch_settings, systems, tracer, branch)
      call tracer%recorder%setup(tracer%corrector%balance, .true., found, multipliers=.true.)
      do k = 1, size(frequency_ratio)
         if (train%interrupt%raised()) return
         first = found%points + 1
         call record_crossings(tracer, branch, frequency_ratio(k), found)
         ! After an interrupt the motions found are not valid.
         if (train%interrupt%raised()) return
         do i = first, found%points
            if (.not. is_new(found, first, i)) cycle
            row%motions(k) = row%motions(k) + 1
            if (row%motions(k) == 1) row%multiplier(k) = found%multipliers(1, i)
            if (abs(found%multipliers(1, i)) < abs(row%multiplier(k))) row%multiplier(k) = found%multipliers(1, i)
            if (.not. found%stable(i)) cycle
            row%stable_motions(k) = row%stable_motions(k) + 1
            if (row%stable_motions(k) == 1) row%rms(:, k) = found%rms(:, i)
            row%rms(:, k) = max(row%rms(:, k), found%rms(:, i))
         end do
      end do
   end subroutine compute_nonlinear_row

   !> Whether motion i equals none of motions first .. i - 1: two segments of a branch may pass through one motion.
   logical function is_new(found, first, i)
      type(branch_type), intent(in) :: found
      integer, intent(in) :: first, i
      integer :: k

      is_new = .not. any([(is_same_motion(found%coefficients(:, :, i), found%coefficients(:, :, k)), k=first, i - 1)])
   end function is_new

end module geartrain_analyses_stability_map
