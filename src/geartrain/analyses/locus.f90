!> The analysis &locus: the curve of a special point or contact onset over Lambda and a parameter of the train.
module geartrain_analyses_locus
   use geartrain_analyses_analysis, only: analysis_type, group_row_type
   use geartrain_base_words, only: words_type
   use geartrain_readings_frequency_text, only: frequency_text, frequency_text_type
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_carry, only: carry, carry_text, carry_words
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type, fatal, in_a_line, status_ended_early, status_input
   use geartrain_base_field, only: field => field_type
   use geartrain_base_fields, only: fields_type, listing, reading
   use geartrain_network_check_coupling, only: refuse_friction
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: counted, significant, text
   use geartrain_base_observer, only: observer_type
   use geartrain_base_variable, only: row => variable_type, visitor_type
   use geartrain_trace_branch, only: branch_type, response_settings_type, special_point_type
   use geartrain_readings_contact_edges, only: locate_contact_edges
   use geartrain_exact_exact_point, only: exact_point_type, find_exact_point, onsets_of
   use geartrain_curves_locus_trace, only: find_path, refusal_of, trace_locus
   use geartrain_curves_locus_result, only: double_point_type, locus_type
   use geartrain_flow_motion_fields, only: about_frequency, about_multipliers
   use geartrain_network_check_train, only: check_train
   use geartrain_network_frequency_unit, only: check_unit, lambda_per, unit_length, visit_unit
   use geartrain_network_long_period, only: describe_period
   use geartrain_network_parameter_path, only: parameter_path_type
   use geartrain_network_parameter_table, only: settings_length
   use geartrain_train_train, only: train_type
   use geartrain_base_sheet, only: in_quality, in_result, sheet_type
   use geartrain_analyses_torque_table, only: torque_table_type
   implicit none (type, external)
   private
   public :: locus_analysis_type, locus_row, locus_settings_type

   type(group_row_type), parameter :: locus_row = group_row_type('locus', &
      'Asks for the curve of a special point or contact onset of the response over frequency and a number of the train.', &
         set_aside=.true.)

   real(dp), parameter :: zero = 0

   !> The variables of &locus.
   type :: locus_settings_type
      !> Kind of the special point, with underscores for blanks.
      character(16) :: kind = 'fold'
      !> Frequency near which it is on the response, and its unit: 'Lambda', 'rpm' or 'Hz'.
      real(dp) :: near = 0
      character(unit_length) :: unit = 'Lambda'
      !> Of a contact onset the number of the mesh, else 0.
      integer :: mesh = 0
      !> Name of the parameter, and the ends of its range [unit of the parameter], `from` and `to` in a case file.
      character(settings_length) :: parameter = ''
      real(dp) :: start = 0, stop = 0
   end type locus_settings_type

   type, extends(analysis_type) :: locus_analysis_type
      type(locus_settings_type), pointer :: settings => null()
      type(locus_type), pointer :: result => null()
      !> The response that has the special point, and its settings; not associated: there is none.
      type(branch_type), pointer :: response => null()
      type(response_settings_type), pointer :: response_settings => null()
   contains
      procedure :: visit_variables
      procedure :: check
      procedure :: run
      procedure :: tell_end
      procedure :: visit_fields
      procedure :: report
   end type locus_analysis_type

contains

   subroutine visit_variables(self, v)
      class(locus_analysis_type), intent(inout) :: self
      class(visitor_type), intent(inout) :: v
      type(locus_settings_type), pointer :: settings
      character(:), allocatable :: word

      settings => self%settings
      call v%enter('locus', 1)
      word = trim(settings%kind)
      call v%on_text(row('kind', '', 'kind of the point; separation and back_contact are the onsets of tooth separation and of &
                         &contact of the back flanks', choices='fold period_doubling neimark-sacker branch_point &
                         &separation back_contact'), word)
      if (allocated(word)) settings%kind = word
      call v%on_real(row('near', '', 'frequency near which the point lies on the response', required=.true., above=zero), &
                     settings%near)
      call visit_unit(settings%unit, v)
      call v%on_integer(row('mesh', '', 'number of the mesh of a contact onset; 0 for other kinds', &
                            least=zero), settings%mesh)
      word = trim(settings%parameter)
      call v%on_text(row('parameter', '', "number of the train that varies, as in &response; must be given"), word)
      if (allocated(word)) settings%parameter = word
      call v%on_real(row('from', '', 'value of parameter at one end of the curve', required=.true.), &
                     settings%start)
      call v%on_real(row('to', '', 'value of parameter at the other end; the value of the train lies between', &
                         required=.true.), settings%stop)
      call v%leave()
   end subroutine visit_variables

   subroutine check(self, train, seeded, checker)
      class(locus_analysis_type), intent(in) :: self
      type(train_type), intent(in) :: train
      logical, intent(in) :: seeded
      class(checker_type), intent(inout) :: checker
      logical :: onset
      integer :: meshes

      if (checker%problems%in_group('locus') .or. checker%problems%of_train()) return
      call refuse_friction(train, 'a locus', checker)
      associate (settings => self%settings)
         call checker%enter('locus', 1)
         call check_unit(train, settings%unit, checker)
         if (settings%parameter == '') call checker%complain('parameter', "''", "must be given, as in 'input_torque'")
         onset = settings%kind == 'separation' .or. settings%kind == 'back_contact'
         meshes = 0
         if (allocated(train%meshes)) meshes = size(train%meshes)
         if (onset .and. (settings%mesh < 1 .or. settings%mesh > meshes)) then
            call checker%complain('mesh', text(settings%mesh), 'must be 1 to '//text(meshes)//' for kind = '''// &
                                  trim(settings%kind)//'''')
         else if (settings%mesh > 0 .and. .not. onset) then
            call checker%complain('mesh', text(settings%mesh), 'must be 0 for kind = '''//trim(settings%kind)//'''')
         end if
         if (.not. abs(settings%stop - settings%start) > 0) call checker%complain('to', text(settings%stop), &
                                                                                    'must differ from the other end')
         if (.not. checker%problems%in_group('locus')) call check_path()
         call checker%leave()
      end associate

   contains

      !> Checks the parameter and its range.
      subroutine check_path()
         type(parameter_path_type) :: path
         type(error_type), allocatable :: wrong
         character(:), allocatable :: period, refusal
         integer :: cycles

         ! What is wrong with the train is told elsewhere.
         call check_train(train, wrong)
         if (allocated(wrong) .or. seeded) return
         call describe_period(train, 1, cycles, period)
         call refusal_of(cycles, period, replaced(self%settings%kind), refusal)
         if (refusal /= '') then
            call checker%problems%add(refusal, 'locus', 1)
            return
         end if
         call find_path(train, self%settings%parameter, self%settings%near*lambda_per(train, self%settings%unit), &
                        self%settings%start, self%settings%stop, path, wrong)
         if (allocated(wrong)) call checker%complain('parameter', "'"//trim(self%settings%parameter)//"'", in_a_line(wrong%message))
      end subroutine check_path

   end subroutine check

   subroutine run(self, train, error, observer, start)
      class(locus_analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      type(error_type), allocatable, intent(out) :: error
      class(observer_type), intent(inout) :: observer
      type(motion_type), intent(in), optional :: start
      type(motion_type) :: motion
      type(frequency_text_type) :: told
      character(:), allocatable :: ended
      character(16) :: kind

      if (allocated(self%result%ended)) return
      kind = replaced(self%settings%kind)
      if (present(start)) then
         motion = start
      else
         call find_start(self, train, kind, motion, error)
         if (allocated(error)) return
      end if
      associate (settings => self%settings)
         call trace_locus(train, motion, kind, settings%mesh, settings%parameter, settings%start, settings%stop, self%result, &
                          error, observer)
         if (.not. allocated(self%result%ended)) return
         told = frequency_text(train, settings%unit, maxval(self%result%frequency_ratio))
      end associate
      call told%of_words(self%result%ended, ended)
      self%result%ended = words_type(ended)
   end subroutine run

   !> A kind as special points have it, with a blank.
   pure character(16) function replaced(kind)
      character(16), intent(in) :: kind
      integer :: place

      replaced = kind
      place = index(kind, '_')
      if (place > 0) replaced(place:place) = ' '
   end function replaced

   !> Finds the special point of the exact motion near that of the response that is nearest to `near`.
   subroutine find_start(self, train, kind, motion, error)
      class(locus_analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      character(*), intent(in) :: kind
      type(motion_type), intent(out) :: motion
      type(error_type), allocatable, intent(inout) :: error
      type(special_point_type), allocatable :: specials(:)
      type(exact_point_type) :: exact
      real(dp) :: near
      integer :: best, i

      if (.not. associated(self%response)) then
         call fatal(error, 'locus: needs &response, which has the special point', status_input)
         return
      end if
      near = self%settings%near*lambda_per(train, self%settings%unit)
      if (self%settings%mesh > 0) then
         call locate_contact_edges(train, self%response_settings, self%response)
         call onsets_of(self%response, specials)
      else
         allocate (specials(0))
         if (allocated(self%response%special_points)) specials = self%response%special_points
      end if
      best = 0
      do i = 1, size(specials)
         if (specials(i)%kind /= kind .or. specials(i)%mesh /= self%settings%mesh) cycle
         if (best == 0) best = i
         if (abs(specials(i)%frequency_ratio - near) < abs(specials(best)%frequency_ratio - near)) best = i
      end do
      if (best == 0) then
         call fatal(error, 'locus: the response has no '//trim(kind), status_ended_early)
         return
      end if
      call find_exact_point(train, self%response, merge(0, best, self%settings%mesh > 0), specials(best), exact, error)
      motion = exact%motion
   end subroutine find_start

   subroutine tell_end(self, early)
      class(locus_analysis_type), intent(in) :: self
      type(words_type), allocatable, intent(out) :: early

      if (.not. self%result%complete) early = self%result%ended
   end subroutine tell_end

   subroutine visit_fields(self, train, fields, summary)
      class(locus_analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      class(fields_type), intent(inout) :: fields
      logical, intent(in) :: summary
      integer :: n

      associate (locus => self%result)
         if (.not. fields%enter('/locus', 'curve of a special point of the exact motion over frequency and a parameter', &
                                .true.)) return
         if (allocated(locus%frequency_ratio)) call fields%describe('coordinates', 'frequency parameter')
         n = 2
         call fields%index_axis('side', n, 'end of the curve: 1 its first point, 2 its last one')
         call carry_words(fields, field('ended', '', '', 'why the curve ended at either end, in words'), locus%ended, 'not yet')
         call carry(fields, field('ends', 'side', '', "why the curve ended at its first and last point: range (end of the range of &
                                  &the parameter), closed, corner (the motion grazes a wall of a gap), double point, limit, &
                                  &symmetry, cancelled, failed", optional=.true.), locus%ends)
         call carry(fields, field('complete', '', '', '1 = the curve reached both ends of the range, or closes'), locus%complete)
         call carry(fields, field('closed', '', '', '1 = the curve closes'), locus%closed)
         call carry(fields, field('kind', '', '', 'kind of the special point'), locus%kind)
         call carry(fields, field('mesh', '', '', 'number of the mesh of a contact onset; else 0', least=0, &
                                  most=size(train%meshes)), locus%mesh)
         call carry(fields, field('period', '', '', 'period of the motions in periods of the fundamental', least=1), locus%period)
         call carry(fields, field('start_frequency', '', '1', 'Lambda of the special point at which the curve begins, at the &
                                  &parameter of the train'), locus%start_frequency)
         call carry_text(fields, field('parameter_name', '', '', 'name of the parameter', optional=.true.), locus%name)
         n = 0
         if (allocated(locus%frequency_ratio)) n = size(locus%frequency_ratio)
         call fields%index_axis('point', n, 'point, along the curve')
         call carry(fields, field('frequency', 'point', '1', about_frequency, optional=n == 0), locus%frequency_ratio)
         call carry(fields, field('parameter', 'point', '', 'value of the parameter in its unit', optional=n == 0), &
                    locus%parameter)
         n = 0
         if (allocated(locus%state)) n = size(locus%state, 1)
         call fields%index_axis('state', n, 'number of the multiplier')
         call carry(fields, field('initial_state', 'point state', '1', 'state at phase 0: displacements of the elastic elements, &
                                  &then velocities', optional=n == 0), locus%state)
         call carry(fields, field('multipliers', 'point state complex', '1', about_multipliers, optional=n == 0), locus%multipliers)
         call visit_double_points(locus, fields)
      end associate
   end subroutine visit_fields

   !> Visits the points at which two conditions meet.
   subroutine visit_double_points(locus, fields)
      type(locus_type), intent(inout) :: locus
      class(fields_type), intent(inout) :: fields
      type(double_point_type), allocatable :: list(:)
      integer :: i, n

      n = 0
      if (allocated(locus%special_points)) n = size(locus%special_points)
      if (fields%way == reading) allocate (list(0))
      if (fields%enter('/locus/special_points', 'points of the curve at which two conditions are met', n > 0)) then
         call fields%describe('coordinates', 'frequency kind')
         call fields%index_axis('special_point', n, 'special point, along the curve')
         if (allocated(list)) deallocate (list)
         allocate (list(merge(1, n, fields%way == listing)))
         if (n > 0 .and. fields%way /= reading) list = locus%special_points
         call fields%begin_list('special_point')
         do i = 1, size(list)
            call fields%visit_item(i)
            call carry(fields, field('kind', '', '', 'cusp, isola centre, 1:1 to 1:4 resonance, generalized doubling, fold-flip, &
                                     &fold-neimark-sacker, flip-neimark-sacker, grazing, grazing on a fold, grazing on a &
                                     &doubling'), list(i)%kind)
            call carry(fields, field('frequency', '', '1', about_frequency), list(i)%frequency_ratio)
            call carry(fields, field('parameter', '', '', 'value of the parameter in its unit'), list(i)%parameter)
            call carry(fields, field('after_point', '', '1', 'point of the curve before the special point', least=0), list(i)%point)
         end do
         call fields%end_list()
      end if
      if (fields%way == reading) call move_alloc(list, locus%special_points)
   end subroutine visit_double_points

   subroutine report(self, train, sheet, torques)
      class(locus_analysis_type), intent(in) :: self
      type(train_type), intent(in) :: train
      type(sheet_type), intent(inout) :: sheet
      type(torque_table_type), intent(inout) :: torques
      type(frequency_text_type) :: told
      character(:), allocatable :: words
      integer :: i

      associate (locus => self%result, unused => torques)
         if (.not. allocated(locus%ended)) return
         told = frequency_text(train, self%settings%unit, maxval([0.0_dp, locus%frequency_ratio]))
         call told%rounded(locus%start_frequency, words)
         call sheet%say(in_result, 'Locus of the '//trim(locus%kind)//' at '//words//' over '//trim(locus%name)//': '// &
                        counted(size(locus%frequency_ratio), 'point', 'points')//'.')
         do i = 1, size(locus%special_points)
            associate (special => locus%special_points(i))
               call told%rounded(special%frequency_ratio, words)
               call sheet%say(in_result, '  '//trim(special%kind)//' at '//words//', '//locus%name//' = '// &
                              significant(special%parameter))
            end associate
         end do
         call told%of_words(locus%ended, words)
         call sheet%say(in_quality, 'The locus ended: '//words//'.')
      end associate
   end subroutine report

end module geartrain_analyses_locus
