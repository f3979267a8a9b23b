!> The analysis &run_up: Lambda goes linearly in time from one value to another, from the steady motion at the first value on.
module geartrain_analyses_run_up
   use geartrain_analyses_analysis, only: analysis_type, group_row_type
   use geartrain_base_words, only: lambda, operator(//), words_type
   use geartrain_readings_frequency_text, only: frequency_text, frequency_text_type, in_width
   use geartrain_train_names, only: list_meshes, list_numbers, mesh_names, name_length, shaft_names
   use geartrain_base_sheet, only: in_head, in_quality, in_result, in_run_up, sheet_type
   use geartrain_analyses_torque_table, only: torque_table_type
   use geartrain_analyses_run_up_pulling, only: say_pulling
   use geartrain_analyses_run_up_start, only: find_start, tell_start
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_carry, only: carry, carry_words
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type, fatal, status_ended_early
   use geartrain_base_field, only: field => field_type
   use geartrain_base_fields, only: fields_type, reading
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_numbers, only: counted, fixed, integer_text, real_text, significant, text
   use geartrain_base_observer, only: observer_type
   use geartrain_base_variable, only: row => variable_type, visitor_type
   use geartrain_flow_integration_settings, only: most_periods
   use geartrain_flow_motion_fields, only: about_frequency, about_mesh
   use geartrain_flow_ramp, only: make_ramp, ramp_type
   use geartrain_flow_ramped_flow, only: automatic_samples, follow_ramp, make_room, most_samples, run_up_type
   use geartrain_flow_torque_fields, only: about_coupling, about_held, carry_torque, coupling_row
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_network_frequency_unit, only: check_unit, lambda_per, unit_length, visit_unit
   use geartrain_network_limits, only: check_frequency
   use geartrain_train_mesh, only: coupling_radius
   use geartrain_train_mesh_groups, only: mesh_word
   use geartrain_network_rest, only: largest_residual
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: run_up, run_up_analysis_type, run_up_row, run_up_settings_type

   type(group_row_type), parameter :: run_up_row = group_row_type('run_up', &
      'Asks for a run-up or coast-down: the speed changes linearly in time. Where every mesh has teeth, torques accelerate the &
         &inertias.', &
      steps='periods', set_aside=.true.)

   real(dp), parameter :: zero = 0, one = 1
   !> Least share of the acceleration in a mean force or torque that is told [1].
   real(dp), parameter :: worth_telling = 0.01_dp

   !> The variables of &run_up.
   type :: run_up_settings_type
      !> Frequency at the beginning and at the end [unit], `from` and `to` in a case file.
      real(dp) :: start = 0, stop = 0
      !> Unit of these frequencies: 'Lambda', 'rpm' or 'Hz'.
      character(unit_length) :: unit = 'Lambda'
      !> Time from the beginning to the end [s].
      real(dp) :: duration = 0
      !> Samples of a period of the fundamental at the higher frequency; 0: see `automatic_samples`.
      integer :: samples = 0
      !> Mesh periods after which the search for the steady motion at `start` is given up; 0: no search.
      integer :: max_periods = 2000
   end type run_up_settings_type

   type, extends(analysis_type) :: run_up_analysis_type
      type(run_up_settings_type), pointer :: settings => null()
      type(run_up_type), pointer :: result => null()
   contains
      procedure :: visit_variables
      procedure :: check
      procedure :: run
      procedure :: tell_end
      procedure :: visit_fields
      procedure :: report
   end type run_up_analysis_type

contains

   subroutine visit_variables(self, v)
      class(run_up_analysis_type), intent(inout) :: self
      class(visitor_type), intent(inout) :: v
      type(run_up_settings_type), pointer :: settings

      settings => self%settings
      call v%enter('run_up', 1)
      call v%on_real(row('from', '', 'frequency at the beginning', required=.true., above=zero), &
                     settings%start)
      call v%on_real(row('to', '', 'frequency at the end, above or below the beginning', required=.true., &
                         above=zero), settings%stop)
      call v%on_real(row('duration', 's', 'time from the beginning to the end', &
                         required=.true., above=zero), settings%duration)
      call visit_unit(settings%unit, v)
      call v%on_integer(row('samples', '', 'samples per period of the fundamental at the higher frequency; 0: at least 32 per &
                            &cycle of the fastest mesh', &
                            least=one, most=most_samples*one, automatic=zero), settings%samples)
      call v%on_integer(row('max_periods', '', 'longest settling before the run-up, in periods of the fundamental, &
                            &never more than an integration takes by default; 0: start at &
                            &rest, or from the motion given in a call', least=zero), settings%max_periods)
      call v%leave()
   end subroutine visit_variables

   subroutine check(self, train, seeded, checker)
      class(run_up_analysis_type), intent(in) :: self
      type(train_type), intent(in) :: train
      logical, intent(in) :: seeded
      class(checker_type), intent(inout) :: checker
      type(train_type) :: plain
      real(dp) :: start, stop, period, samples, factor
      integer :: windows

      associate (settings => self%settings)
         if (checker%problems%in_group('run_up') .or. checker%problems%of_train()) return
         call checker%enter('run_up', 1)
         call plain_train(train, plain)
         factor = lambda_per(train, settings%unit)
         start = factor*settings%start
         stop = factor*settings%stop
         call check_unit(train, settings%unit, checker)
         call check_frequency(plain, ['from', 'to  '], [settings%start, settings%stop], checker, settings%unit)
         if (checker%problems%in_group('run_up')) return
         ! A mean period of the fundamental [s], which may be minutes long, and its windows.
         period = 2*pi/((start + stop)/2*plain%characteristic_frequency)
         windows = 1
         if (allocated(plain%meshes)) windows = max(1, minval([most_samples, plain%meshes%order]))
         if (.not. settings%duration >= period/windows*(1 - 1e-9_dp)) &
            call checker%complain('duration', real_text(settings%duration), 'must be >= '//real_text(period/windows)// &
                                  ' s: a run-up takes one mean cycle of the slowest mesh at least')
         samples = settings%samples*settings%duration/period*2*max(start, stop)/(start + stop)
         if (.not. windows*settings%duration/period <= most_samples) then
            call checker%complain('duration', real_text(settings%duration), 'must be shorter: the run-up has '// &
               text(anint(windows*settings%duration/period))//' cycles of the slowest mesh, and '// &
               integer_text(most_samples)//' at most')
         else if (.not. samples <= most_samples) then
            call checker%complain('samples', integer_text(settings%samples), 'must be fewer: the run-up has '// &
               text(anint(samples))//' samples, and '//integer_text(most_samples)//' at most')
         end if
         call checker%leave()
      end associate
   end subroutine check

   subroutine run(self, train, error, observer, start)
      class(run_up_analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      type(error_type), allocatable, intent(out) :: error
      class(observer_type), intent(inout) :: observer
      type(motion_type), intent(in), optional :: start

      if (.not. allocated(self%result%ended)) call run_up(train, self%settings, self%result, error, start, observer)
   end subroutine run

   subroutine tell_end(self, early)
      class(run_up_analysis_type), intent(in) :: self
      type(words_type), allocatable, intent(out) :: early

      if (.not. self%result%complete) early = self%result%ended
   end subroutine tell_end

   !> Follows the motion of a train while Lambda goes linearly in time from one value to another.
   subroutine run_up(train, settings, result, error, start, observer)
      !> The train as described.
      type(train_type), intent(in) :: train
      !> Ramp and samples.
      type(run_up_settings_type), intent(in) :: settings
      !> The run-up. A run-up under way, with a state but without `ended` as in a checkpoint of the same case, is taken up. A
      !> target: an observer may read the samples so far through a pointer.
      type(run_up_type), intent(inout), target :: result
      type(error_type), allocatable, intent(out) :: error
      !> Motion to settle from, with a state or coefficients; absent: at rest under the mean load.
      type(motion_type), intent(in), optional :: start
      !> Told of 'run up' after each period of the slowest mesh, of 'settling' or 'settling by time' before; may end the run-up.
      class(observer_type), intent(inout), optional :: observer
      type(run_up_settings_type), target :: copy
      type(run_up_analysis_type) :: analysis
      type(run_up_type) :: empty
      type(system_type) :: steady, system
      type(ramp_type) :: ramp
      real(dp), allocatable :: shift(:)
      logical :: stopped
      integer :: samples, periods

      if (allocated(result%ended) .or. .not. allocated(result%state)) result = empty
      copy = settings
      analysis%settings => copy
      call analysis%check_alone(train, error)
      if (allocated(error)) return
      call build_systems(train, settings, ramp, steady, system)
      if (.not. system%rest_residual < largest_residual) then
         call fatal(error, 'run up: how the loops share the torques that accelerate the inertias was not found: take a longer &
                    &duration', status_ended_early)
         return
      end if
      ! A state has the twists of shafts less those at rest, which the acceleration changes.
      allocate (shift(system%states), source=0.0_dp)
      where (system%element_mesh(:system%displacements) == 0) &
         shift(:system%displacements) = steady%static_force(:system%displacements) - system%static_force(:system%displacements)
      periods = min(settings%max_periods, most_periods(system, 0))
      samples = settings%samples
      if (samples == 0) samples = automatic_samples(system, ramp)
      call make_room(system, ramp, samples, system%torque_paths%torques, result, error)
      if (allocated(error)) return
      if (.not. allocated(result%state)) then
         call find_start(steady, system, shift, periods, ramp%start, result, error, stopped, start, observer)
         if (allocated(error)) return
         if (stopped) then
            result%ended = 'cancelled before the motion at '//lambda(ramp%start)//' was steady'
            return
         end if
      end if
      call follow_ramp(system, shift, ramp, result, observer)
      call tell_start(periods, ramp%start, result)
   end subroutine run_up

   !> Makes the ramp, and the system of a train at constant speed and on the ramp.
   subroutine build_systems(train, settings, ramp, steady, system)
      type(train_type), intent(in) :: train
      type(run_up_settings_type), intent(in) :: settings
      type(ramp_type), intent(out) :: ramp
      type(system_type), intent(out) :: steady, system

      call build_system(train, steady)
      associate (factor => lambda_per(train, settings%unit))
         ramp = make_ramp(factor*settings%start, factor*settings%stop, settings%duration*steady%characteristic_frequency, &
                          nint(minval(steady%law%order)))
      end associate
      call build_system(train, system, ramp%acceleration)
   end subroutine build_systems

   subroutine visit_fields(self, train, fields, summary)
      class(run_up_analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      class(fields_type), intent(inout) :: fields
      logical, intent(in) :: summary
      real(dp), allocatable :: time(:)
      character(*), parameter :: extreme = ' torque in the window, also between samples', smallest = 'smallest'//extreme, &
         largest = 'largest'//extreme
      integer :: n

      associate (result => self%result)
         if (.not. fields%enter('/run_up', 'motion while the speed changes linearly in time', .true.)) return
         if (result%samples > 0) call fields%describe('coordinates', 'frequency window_time')
         call carry_words(fields, field('ended', '', '', 'why it ended, in words, and whether it began with a steady motion'), &
                          result%ended, 'not yet: these are the samples so far')
         call carry(fields, field('complete', '', '', '1 = the end of the run-up was reached'), result%complete)
         call carry(fields, field('start_period', '', '', 'period of the steady motion at the beginning, in periods of the &
                                  &fundamental; 0: none, or not known', least=0), &
                                  result%start_period)
         call carry(fields, field('start_settling', '', 's', 'time of settling by the time constants of the train; 0: settled &
                                  &period by period, or not at all', optional=.true.), &
                    result%start_settling)
         call carry(fields, field('start_ringing', '', '1', 'as `ringing` of a motion, at the beginning, after settling by time &
                                  &constants; NaN: not known', none_is_negative=.true., optional=.true.), &
                    result%start_ringing)
         ! The axis `time` is as long as the samples that are done, and all arrays along it are cut to this length.
         if (allocated(result%time)) time = result%time(:result%samples)
         call carry(fields, field('time', 'time', 's', 'time from the beginning of the run-up'), time)
         if (fields%way == reading) call move_alloc(time, result%time)
         n = merge(size(train%meshes), 0, result%samples > 0)
         call fields%index_axis('mesh', n, about_mesh)
         n = merge(size(train%shafts), 0, result%samples > 0)
         call fields%index_axis('shaft', n, 'shaft, in the order of the train')
         ! Without samples these axes are as empty as those before: other groups may have them.
         n = 0
         if (allocated(train%bodies)) n = count(train%bodies%held)
         if (fields%has('reaction_torque', n > 0)) then
            if (result%samples == 0) n = 0
            call fields%index_axis('held', n, about_held)
         end if
         n = count(train%meshes%is_coupling)
         if (fields%has('coupling_torque', n > 0)) then
            if (result%samples == 0) n = 0
            call fields%index_axis('coupling', n, about_coupling)
         end if
         n = 0
         if (allocated(result%state)) n = size(result%state)
         call fields%index_axis('coordinate', n, 'displacement of each elastic element of the tree, then velocities')
         n = result%windows
         call fields%index_axis('window', n, 'period of the slowest mesh, from the beginning of the ramp')
         if (allocated(fields%wrong)) return
         call carry(fields, field('frequency', 'time', '1', about_frequency), result%frequency_ratio)
         call carry(fields, field('displacement', 'time mesh', '1', 'mesh displacement / characteristic_length'), &
                    result%displacement)
         call carry(fields, field('mesh_force', 'time mesh', 'N', 'total mesh force; of a coupling the torque, N m'), &
                    result%mesh_force)
         call carry_torque(fields, [field('shaft_torque', 'time shaft', 'N m', 'total torque of the shaft; NaN for a rigid &
                           &shaft'), field('reaction_torque', 'time held', 'N m', 'torque by which a held body is held', &
                                           'where a body is held'), coupling_row('coupling_torque', 'time', 'total')], &
                           result%shaft_torque)
         call carry(fields, field('window_time', 'window', 's', 'middle of the window, a cycle of the slowest mesh'), &
                    result%window_time)
         call carry(fields, field('mesh_force_minimum', 'window mesh', 'N', &
                                  'smallest mesh force in the window, also between samples'), result%force_minimum)
         call carry(fields, field('mesh_force_maximum', 'window mesh', 'N', &
                                  'largest mesh force in the window, also between samples'), result%force_maximum)
         call carry_torque(fields, [field('shaft_torque_minimum', 'window shaft', 'N m', smallest), &
                           field('reaction_torque_minimum', 'window held', 'N m', smallest, 'where a body is held'), &
                           coupling_row('coupling_torque_minimum', 'window', 'smallest')], &
                           result%torque_minimum)
         call carry_torque(fields, [field('shaft_torque_maximum', 'window shaft', 'N m', largest), &
                           field('reaction_torque_maximum', 'window held', 'N m', largest, 'where a body is held'), &
                           coupling_row('coupling_torque_maximum', 'window', 'largest')], &
                           result%torque_maximum)
         call carry(fields, field('state', 'coordinate', '1', 'state at the end of the last window, ordered as initial_state of a &
                                  &motion'), result%state)
         if (fields%way /= reading .or. allocated(fields%wrong)) return
         result%windows = n
         if (allocated(result%time)) result%samples = size(result%time)
         call fields%check(allocated(result%state) .or. n == 0, 'state')
         call fields%check(result%samples > 0 .eqv. n > 0, 'time')
      end associate
   end subroutine visit_fields

   subroutine report(self, train, sheet, torques)
      class(run_up_analysis_type), intent(in) :: self
      type(train_type), intent(in) :: train
      type(sheet_type), intent(inout) :: sheet
      type(torque_table_type), intent(inout) :: torques
      character(name_length) :: names(max(size(train%meshes), size(train%shafts)))
      type(system_type) :: steady, system
      type(ramp_type) :: ramp
      type(frequency_text_type) :: told
      character(:), allocatable :: words
      real(dp), allocatable :: at(:)
      integer :: i, n, width

      call build_systems(train, self%settings, ramp, steady, system)
      associate (result => self%result, unused => torques)
         n = result%windows
         told = frequency_text(train, self%settings%unit, max(ramp%start, ramp%stop), min(ramp%start, ramp%stop))
         call told%with_unit(text(ramp%start*told%per_lambda)//' to '//text(ramp%stop*told%per_lambda), words)
         call sheet%add(in_head, 'Run-up: '//words//' in '// &
                        significant(ramp%duration/system%characteristic_frequency)//' s, '//counted(n, 'cycle', 'cycles')// &
                        ' of the slowest mesh')
         if (n > 0) then
            at = ramp%start + ramp%acceleration*system%characteristic_frequency*result%window_time(:n)
            width = max(maxval(len_trim(mesh_names(train))) + 5, maxval([0, len_trim(shaft_names(train))]) + 5)
            call sheet%add(in_run_up, repeat(' ', width)//'     minimum  at '//told%unit(:8)//'   maximum  at '//told%unit)
            names(:size(train%meshes)) = mesh_names(train)
            do i = 1, size(train%meshes)
               if (train%meshes(i)%is_coupling) then
                  call put(trim(names(i))//', N m', ' N m', result%force_minimum(i, :n), result%force_maximum(i, :n), &
                           system%mesh_element(i), coupling_radius)
                  cycle
               end if
               call put(trim(names(i))//', N', ' N', result%force_minimum(i, :n), result%force_maximum(i, :n), &
                        system%mesh_element(i), 1.0_dp)
            end do
            names(:size(train%shafts)) = shaft_names(train)
            do i = 1, size(train%shafts)
               if (train%shafts(i)%rigid) cycle
               associate (element => findloc(system%element_shaft, i, 1))
                  call put(trim(names(i))//', N m', ' N m', result%torque_minimum(i, :n), result%torque_maximum(i, :n), element, &
                           system%network%elements(element)%radius)
               end associate
            end do
         end if
         if (n > 0) call say_result()
         if (abs(ramp%acceleration) > 0 .and. .not. any(abs(system%network%acceleration) > 0)) &
            call sheet%say(in_run_up, 'Without the acceleration of the inertias: not every mesh has teeth, which give the speeds &
                                      &of the bodies.')
         if (n > 0) then
            call say_pulling(train, result, steady%static_force(system%mesh_element), n, words)
            if (words /= '') call sheet%say(in_run_up, words)
         end if
         if (.not. allocated(result%ended)) then
            call sheet%say(in_quality, 'The run-up is under way.')
            return
         end if
         call told%of_words(result%ended, words)
         if (.not. result%complete .or. scan(words, ';:,') > 0 .or. sheet%verbose) call sheet%say(in_quality, 'The run-up ended: ' &
                                                                                                 //words//'.')
      end associate

   contains

      !> Adds extremes, and the mean by the mean torques where the acceleration of the inertias changes it by more than 1 %.
      subroutine put(what, of, low, high, element, radius)
         character(*), intent(in) :: what, of
         real(dp), intent(in) :: low(:), high(:)
         integer, intent(in) :: element
         !> Radius of the force [m]; 1 for a force.
         real(dp), intent(in) :: radius
         real(dp) :: usual, mean

         associate (at_low => told%number(at(minloc(low, 1))), at_high => told%number(at(maxloc(high, 1))))
            call sheet%add(in_run_up, what//repeat(' ', width - len(what))//in_width(significant(minval(low)), 12)//'  '// &
                           at_low(:11)//in_width(significant(maxval(high)), 12)//'  '//at_high)
         end associate
         ! Torques that follow the speed have no mean over the run-up that would compare.
         if (allocated(steady%speed_loads)) return
         associate (scale => system%stiffness(element)*system%characteristic_length*radius)
            usual = scale*steady%static_force(element)
            mean = scale*system%static_force(element)
         end associate
         if (abs(mean - usual) <= worth_telling*abs(usual)) return
         words = 'mean '//significant(mean)//of//', at constant speed '//significant(usual)//of
         ! The change of the magnitude: a load on the coast flank is negative.
         if (mean*usual < 0) then
            words = words//', the load is reversed'
         else if (abs(mean - usual) < 10*abs(usual)) then
            words = words//' ('//fixed(100*abs(abs(mean) - abs(usual))/abs(usual), 1)//' % '// &
                    trim(merge('more', 'less', abs(mean) > abs(usual)))//')'
         end if
         call sheet%say(in_run_up, '  '//words)
      end subroutine put

      !> Adds sentences on the largest mesh force, and on what loses contact or changes sign.
      subroutine say_result()
         type(train_type) :: plain
         logical :: lose(size(train%meshes)), reverse(size(train%shafts))
         character(:), allocatable :: list, place
         integer :: mesh, window, k

         call plain_train(train, plain)
         associate (result => self%result)
            ! Torques of couplings are in the table; without gear pairs they are all there is.
            mesh = maxloc(maxval(max(abs(result%force_minimum(:, :n)), abs(result%force_maximum(:, :n))), 2), 1, &
                          train%meshes%is_pair() .or. .not. any(train%meshes%is_pair()))
            associate (force => max(abs(result%force_minimum(mesh, :n)), abs(result%force_maximum(mesh, :n))))
               window = maxloc(force, 1)
               call told%with_unit(told%number(at(window)), place)
               words = 'Run-up: largest mesh force '//significant(force(window))//' N, mesh '//text(mesh)//' at '//place
               if (train%meshes(mesh)%is_coupling) words = 'Run-up: largest torque '//significant(force(window))//' N m, '// &
                                                           trim(mesh_word(train%meshes, mesh))//' at '//place
            end associate
            associate (gap => plain%meshes%half_backlash/plain%characteristic_length)
               lose = [(any(abs(result%displacement(k, :result%samples)) < gap(k)), k=1, size(lose))]
            end associate
            reverse = [(.not. train%shafts(k)%rigid .and. minval(result%torque_minimum(k, :n)) < 0 .and. &
                        maxval(result%torque_maximum(k, :n)) > 0, k=1, size(reverse))]
         end associate
         call list_meshes(train, lose, list)
         if (list == '') list = trim(merge('no coupling', 'no mesh    ', all(train%meshes%is_coupling)))
         words = words//'; '//list//trim(merge(' loses', ' lose ', count(lose) < 2))//' contact'
         call list_numbers(reverse, 'shaft', 'shafts', list)
         if (list /= '') words = words//'; the torque of '//list//' changes sign'
         call sheet%say(in_result, words//'.')
      end subroutine say_result

   end subroutine report

end module geartrain_analyses_run_up
