!> Settings and result of a stability map (stability chart, of a linear train an Ince-Strutt diagram): the variables of
!> &stability_map with their checks, the grid, its rows while the map is under way, and its fields.
module geartrain_analyses_stability_grid
   use geartrain_analyses_map_trains, only: map_trains_type, moves_linear_train
   use geartrain_base_carry, only: carry, carry_text
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type, in_a_line
   use geartrain_base_field, only: field => field_type
   use geartrain_base_fields, only: fields_type, listing, reading
   use geartrain_network_check_coupling, only: refuse_friction
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text, real_text
   use geartrain_base_variable, only: row => variable_type, visitor_type
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_flow_motion_fields, only: about_frequency, about_mesh
   use geartrain_network_check_train, only: check_train
   use geartrain_network_frequency_unit, only: check_unit, lambda_per, unit_length, visit_unit
   use geartrain_network_limits, only: check_common_period, check_frequency, check_harmonics
   use geartrain_network_long_period, only: check_long_period, visit_long_period
   use geartrain_network_parameter, only: largest_variation
   use geartrain_network_parameter_table, only: settings_length
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: check_consistency, map_row_type, stability_map_settings_type, stability_map_type, visit_map, &
      visit_stability_map

   real(dp), parameter :: zero = 0, one = 1
   !> Largest number of points along either side of the map.
   real(dp), parameter :: most_points = 10000
   !> Most harmonics of every motion, and highest harmonic where the program chooses them.
   integer, parameter :: most_harmonics = 1000, highest_chosen = 100000

   character(*), parameter :: home = '/stability_map', grid = 'parameter frequency'

   !> The variables of &stability_map; from, to, parameter_from and parameter_to are `start`, `stop`, `parameter_start` and
   !> `parameter_stop`.
   type :: stability_map_settings_type
      !> Ends of the range, by default of Lambda.
      real(dp) :: start = 0, stop = 0
      !> Unit of these frequencies: 'Lambda', 'rpm' or 'Hz'.
      character(unit_length) :: unit = 'Lambda'
      !> Number of frequencies in the range, both ends included.
      integer :: points = 200
      !> Parameter that varies from row to row: a number of the train, or 'mesh_damping_ratio' or 'half_backlash' of every mesh.
      character(settings_length) :: parameter = 'stiffness_variation'
      !> Ends of the range of the parameter [unit of the parameter].
      real(dp) :: parameter_start = 0, parameter_stop = 0
      !> Number of values of the parameter, both ends included.
      integer :: parameter_points = 200
      !> Whether the map is one of the train without backlash, all teeth in contact.
      logical :: linear = .false.
      !> Harmonics of the branch of each row, as in &response, 0: chosen by the program for each point; not used by a linear map.
      integer :: harmonics = 6
      !> Relative error of the waveform aimed at where harmonics = 0.
      real(dp) :: tolerance = 1e-4_dp
      !> Whether it is computed even where the period is long.
      logical :: long_period = .false.
   end type stability_map_settings_type

   !> A row of a map: components as in stability_map_type without the last index; not allocated where the row is not done.
   type :: map_row_type
      !> Numbers of motions and of stable motions, (point).
      integer, allocatable :: motions(:), stable_motions(:)
      !> Critical multiplier, (point).
      complex(dp), allocatable :: multiplier(:)
      !> Largest rms of the stable motions [1], (mesh, point).
      real(dp), allocatable :: rms(:, :)
      !> Whether the branch of the row got from one end of the range to the other.
      logical :: whole = .true.
   end type map_row_type

   !> A map: the grid over Lambda (first index) and the parameter (second index), of the rows that are done.
   type :: stability_map_type
      !> Name of the parameter, 'stiffness_variation', ..., and its unit.
      character(:), allocatable :: name, unit
      !> Whether the map is one of the train without backlash.
      logical :: linear = .false.
      !> Lambda [1], (point); values of the parameter in its unit, (row).
      real(dp), allocatable :: frequency_ratio(:), parameter(:)
      !> Numbers of motions of the period of the fundamental and of stable motions among them, (point, row).
      integer, allocatable :: motions(:, :), stable_motions(:, :)
      !> Floquet multiplier of largest magnitude of the motion for which this magnitude is smallest, (point, row); NaN: no motion.
      complex(dp), allocatable :: multiplier(:, :)
      !> Largest rms of the stable motions, see motion_type, (mesh, point, row); NaN: no stable motion. Not allocated: linear map.
      real(dp), allocatable :: rms(:, :, :)
      !> Whether a row is done; whether its branch got from one end of the range to the other, (row).
      logical, allocatable :: done(:), whole(:)
      !> Rows of a map under way, so that it takes memory as it grows; `gather` makes the arrays of them.
      type(map_row_type), allocatable :: rows(:)
      !> 'all rows done', or what is missing; not allocated: the map is under way.
      character(:), allocatable :: ended
      !> Whether all rows are done and the branch of each got from one end of the range to the other.
      logical :: complete = .false.
   contains
      procedure :: gather
   end type stability_map_type

contains

   !> Leads a visitor over the variables of &stability_map.
   subroutine visit_stability_map(settings, v)
      !> Values of the variables; set by a visitor that reads them.
      type(stability_map_settings_type), intent(inout) :: settings
      !> The visitor.
      class(visitor_type), intent(inout) :: v
      character(:), allocatable :: word

      call v%enter('stability_map', 1)
      call v%on_real(row('from', '', 'one end of the frequency range', required=.true., above=zero), &
                     settings%start)
      call v%on_real(row('to', '', 'other end of the frequency range', required=.true., above=zero), settings%stop)
      call visit_unit(settings%unit, v)
      call v%on_integer(row('points', '', 'frequencies in the range, both ends included', least=one, most=most_points), &
                        settings%points)
      word = trim(settings%parameter)
      call v%on_text(row('parameter', '', "number of the train that varies from row to row, as in &response; &
                         &mesh_damping_ratio and half_backlash: of every mesh"), word)
      if (allocated(word)) settings%parameter = word
      call v%on_real(row('parameter_from', '', 'one end of the range of the parameter', &
                         required=.true.), settings%parameter_start)
      call v%on_real(row('parameter_to', '', 'other end of the range of the parameter', required=.true.), &
                     settings%parameter_stop)
      call v%on_integer(row('parameter_points', '', 'values of the parameter in the range, both ends included', least=one, &
                            most=most_points), settings%parameter_points)
      call v%on_logical(row('linear', '', 'the train without backlash, all teeth in contact: shows parametric resonances; .false.: &
                            &the motions on the branch of each row'), settings%linear)
      call v%on_integer(row('harmonics', '', 'harmonics R of Lambda; 0: as many as tolerance needs, recommended for &
                            &trains with teeth; not used by a linear map', least=one, most=most_harmonics*one, &
                            automatic=zero), settings%harmonics)
      call v%on_real(row('tolerance', '', 'relative error of the waveform to reach where harmonics = 0', above=zero, most=one), &
                     settings%tolerance)
      call visit_long_period(settings%long_period, v)
      call v%leave()
   end subroutine visit_stability_map

   !> Checks values of &stability_map against one another and against the train.
   subroutine check_consistency(train, settings, checker)
      type(train_type), intent(in) :: train
      !> The settings.
      type(stability_map_settings_type), intent(in) :: settings
      !> Collects the problems; nothing is checked if it has a problem of this group.
      class(checker_type), intent(inout) :: checker
      type(train_type) :: plain
      logical :: within

      if (checker%problems%in_group('stability_map')) return
      call refuse_friction(train, 'a stability map', checker)
      call checker%enter('stability_map', 1)
      ! A branch needs a range; the linear train does not.
      if (abs(settings%start - settings%stop) <= 0 .and. (settings%points > 1 .or. .not. settings%linear)) &
         call checker%complain('to', real_text(settings%stop), 'must differ from "from"')
      if (abs(settings%start - settings%stop) > 0 .and. settings%points == 1) &
         call checker%complain('points', integer_text(settings%points), 'must be >= 2 where "from" and "to" differ')
      if (abs(settings%parameter_start - settings%parameter_stop) <= 0 .neqv. settings%parameter_points == 1) &
         call checker%complain('parameter_points', integer_text(settings%parameter_points), &
                               'must be 1 where "parameter_from" and "parameter_to" are equal, and only there')
      call check_unit(train, settings%unit, checker)
      call plain_train(train, plain)
      call check_frequency(plain, ['from', 'to  '], [settings%start, settings%stop], checker, settings%unit)
      call check_common_period(plain, 'stability_map', checker, within)
      if (within) call check_long_period(train, 'stability_map', 'every point takes multipliers over a period', &
                                         settings%long_period, checker)
      if (within .and. .not. settings%linear) call check_harmonics(plain, settings%harmonics, 1, highest_chosen, checker)
      if (settings%parameter == '') call checker%complain('parameter', "''", "must be given, as in 'stiffness_variation'")
      if (settings%linear .and. allocated(train%meshes)) then
         if (.not. moves_linear_train(train, settings%parameter)) &
            call checker%complain('parameter', "'"//trim(settings%parameter)//"'", &
                                  'has no influence on the stability of the linear train: leave out linear = .true.')
      end if
      if (settings%parameter == 'stiffness_variation' .and. allocated(train%meshes)) then
         if (.not. largest_variation(plain%meshes) > 0 .and. .not. checker%problems%in_group('mesh')) &
            call checker%complain('parameter', "'"//trim(settings%parameter)//"'", &
                                  'needs a mesh with stiffness_cos or stiffness_sin, which give the shape that is scaled')
      end if
      if (.not. checker%problems%in_group('stability_map')) call check_trains()
      call checker%leave()

   contains

      !> Checks the parameter and the trains of its range.
      subroutine check_trains()
         type(map_trains_type) :: trains
         type(error_type), allocatable :: wrong

         ! What is wrong with the train is told elsewhere.
         if (checker%problems%of_train()) return
         call check_train(train, wrong)
         if (allocated(wrong)) return
         if (.not. lambda_per(train, settings%unit) > 0) return
         call trains%setup(train, settings%parameter, settings%start*lambda_per(train, settings%unit), settings%parameter_start, &
                           settings%parameter_stop, settings%linear, wrong)
         if (allocated(wrong)) call checker%complain('parameter', "'"//trim(settings%parameter)//"'", in_a_line(wrong%message))
      end subroutine check_trains

   end subroutine check_consistency

   !> Makes the arrays of the rows that are done, and frees these rows one by one.
   subroutine gather(self)
      class(stability_map_type), intent(inout) :: self
      integer :: i, n

      n = count(self%done)
      associate (points => size(self%frequency_ratio))
         allocate (self%motions(points, n), self%stable_motions(points, n), self%multiplier(points, n))
         do i = 1, size(self%rows)
            if (self%done(i) .and. .not. self%linear) then
               allocate (self%rms(size(self%rows(i)%rms, 1), points, n))
               exit
            end if
         end do
         if (.not. (self%linear .or. allocated(self%rms))) allocate (self%rms(0, points, 0))
      end associate
      self%parameter = pack(self%parameter, self%done)
      self%whole = pack(self%whole, self%done)
      n = 0
      do i = 1, size(self%rows)
         if (.not. self%done(i)) cycle
         n = n + 1
         self%motions(:, n) = self%rows(i)%motions
         self%stable_motions(:, n) = self%rows(i)%stable_motions
         self%multiplier(:, n) = self%rows(i)%multiplier
         if (.not. self%linear) self%rms(:, :, n) = self%rows(i)%rms
         deallocate (self%rows(i)%motions, self%rows(i)%stable_motions, self%rows(i)%multiplier)
         if (.not. self%linear) deallocate (self%rows(i)%rms)
      end do
      self%done = pack(self%done, self%done)
      deallocate (self%rows)
   end subroutine gather

   !> Visits the groups of a map.
   subroutine visit_map(map, settings, fields)
      !> The map; set by reading.
      type(stability_map_type), intent(inout) :: map
      !> Settings that a map read must agree with; not associated: any map is accepted.
      type(stability_map_settings_type), pointer, intent(in) :: settings
      class(fields_type), intent(inout) :: fields
      type(stability_map_type) :: rows_done

      if (.not. fields%enter(home, 'stability over frequency and one parameter of the train', .true.)) return
      if (allocated(map%rows) .and. fields%way /= reading) then
         rows_done = map
         call rows_done%gather()
         call visit_grid(rows_done, fields)
      else
         call visit_grid(map, fields)
      end if
      if (fields%way == listing) return
      call visit_rows(map, fields)
      if (fields%way /= reading .or. allocated(fields%wrong) .or. .not. associated(settings)) return
      call fields%check(map%linear .eqv. settings%linear, 'linear')
      if (allocated(map%frequency_ratio)) call fields%check(size(map%frequency_ratio) == settings%points, 'frequency')
      if (allocated(map%done)) call fields%check(size(map%done) == settings%parameter_points .or. .not. map%complete .and. &
                                                 .not. allocated(map%rows), 'row_done')
   end subroutine visit_map

   subroutine visit_grid(map, fields)
      type(stability_map_type), intent(inout) :: map
      class(fields_type), intent(inout) :: fields
      real(dp), allocatable :: radius(:, :)
      logical :: begun
      integer :: meshes

      call carry_text(fields, field('ended', '', '', 'why it ended, in words'), map%ended, 'not yet: these are the rows so far')
      call carry(fields, field('complete', '', '', '1 = all rows are done, and each branch passed through the range'), &
                 map%complete)
      begun = fields%has('parameter', allocated(map%parameter))
      call carry(fields, field('linear', '', '', '1 = map of the train without backlash', optional=.not. begun), map%linear)
      if (.not. begun) return
      call carry_text(fields, field('parameter_name', '', '', 'name of the parameter'), map%name)
      call carry_text(fields, field('parameter_unit', '', '', 'unit of the parameter'), map%unit)
      call carry(fields, field('parameter', 'parameter', unit_of_grid(map), 'value of the parameter'), map%parameter)
      call carry(fields, field('frequency', 'frequency', '1', about_frequency), map%frequency_ratio)
      call carry(fields, field('row_done', 'parameter', '1', '1 = the row is computed'), map%done)
      call carry(fields, field('row_whole', 'parameter', '1', '1 = the branch of the row passed through the range; 0 = motions may &
                               &be missing'), map%whole)
      call carry(fields, field('motions', grid, '1', 'number of motions of period 1 on the branch of the row', &
         &least=0), map%motions)
      call carry(fields, field('stable_motions', grid, '1', 'number of stable motions of period 1; 0: the train has another &
                               &motion, of a longer period or of none', least=0), map%stable_motions)
      if (allocated(map%multiplier)) radius = abs(map%multiplier)
      if (fields%way /= reading) call carry(fields, field('spectral_radius', grid, '1', 'largest magnitude of a multiplier of the &
                                        &most stable motion over a period of the fundamental; NaN: no motion'), radius)
      call carry(fields, field('multiplier', grid//' complex', '1', 'multiplier of this magnitude: near +1 a fold or a resonance &
                               &at a natural frequency, near -1 a period doubling'), map%multiplier)
      if (.not. fields%has('rms', allocated(map%rms))) then
         call fields%check(map%linear, 'rms')
         return
      end if
      meshes = 0
      if (allocated(map%rms)) meshes = size(map%rms, 1)
      call fields%index_axis('mesh', meshes, about_mesh)
      call carry(fields, field('rms', grid//' mesh', '1', 'largest `rms` of the stable motions, as in /response; NaN: no stable &
                               &motion', 'without `linear`'), map%rms)
   end subroutine visit_grid

   !> Visits, of a map under way, all values of the parameter, and which rows the grid holds.
   subroutine visit_rows(map, fields)
      type(stability_map_type), intent(inout) :: map
      class(fields_type), intent(inout) :: fields
      real(dp), allocatable :: parameter(:)
      logical, allocatable :: done(:)
      integer :: n

      if (.not. fields%enter(home//'/rows', 'which rows of a map under way are done', allocated(map%rows))) return
      n = 0
      if (allocated(map%rows)) n = size(map%rows)
      if (allocated(map%rows)) done = map%done
      if (allocated(map%rows)) parameter = map%parameter
      call fields%index_axis('row', n, 'row of the whole map')
      call carry(fields, field('value', 'row'), parameter)
      call carry(fields, field('done', 'row'), done)
      if (fields%way /= reading .or. allocated(fields%wrong)) return
      call fields%check(count(done) == size(map%parameter), 'done')
      if (allocated(fields%wrong)) return
      call scatter(map, parameter, done)
   end subroutine visit_rows

   !> Inverse of `gather`: makes rows of the arrays, among rows that are still to be done.
   subroutine scatter(map, parameter, done)
      type(stability_map_type), intent(inout) :: map
      real(dp), intent(in) :: parameter(:)
      logical, intent(in) :: done(:)
      integer :: i, n

      allocate (map%rows(size(done)))
      n = 0
      do i = 1, size(done)
         if (.not. done(i)) cycle
         n = n + 1
         map%rows(i)%motions = map%motions(:, n)
         map%rows(i)%stable_motions = map%stable_motions(:, n)
         map%rows(i)%multiplier = map%multiplier(:, n)
         if (allocated(map%rms)) map%rows(i)%rms = map%rms(:, :, n)
         map%rows(i)%whole = map%whole(n)
      end do
      map%whole = unpack(map%whole, done, .false.)
      map%done = done
      map%parameter = parameter
      deallocate (map%motions, map%stable_motions, map%multiplier)
      if (allocated(map%rms)) deallocate (map%rms)
   end subroutine scatter

   pure character(8) function unit_of_grid(map)
      type(stability_map_type), intent(in) :: map

      unit_of_grid = ''
      if (allocated(map%unit)) unit_of_grid = map%unit
   end function unit_of_grid

end module geartrain_analyses_stability_grid
