!> Settings and result of &basins: the variables of the group with their checks, the starts and what they reach, and the fields.
module geartrain_analyses_basin_grid
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_carry, only: carry, carry_text
   use geartrain_base_checker, only: checker_type
   use geartrain_base_field, only: field => field_type
   use geartrain_base_fields, only: fields_type, listing, reading
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text, text
   use geartrain_base_variable, only: row => variable_type, visitor_type
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_flow_motion_fields, only: visit_motions
   use geartrain_network_frequency_unit, only: check_unit, unit_length, visit_unit
   use geartrain_network_limits, only: check_frequency
   use geartrain_network_long_period, only: check_long_period, visit_long_period
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: basins_settings_type, basins_type, check_basins, not_done, ran_away, unsettled, visit_basins

   real(dp), parameter :: zero = 0, one = 1, most_points = 10000
   !> Labels of starts: not done yet; grown without bound; not settled.
   integer, parameter :: not_done = -2, ran_away = -1, unsettled = 0

   !> The variables of &basins.
   type :: basins_settings_type
      !> Frequency, by default Lambda.
      real(dp) :: frequency = 0
      !> Unit of the frequency: 'Lambda', 'rpm' or 'Hz'.
      character(unit_length) :: unit = 'Lambda'
      !> Mesh whose displacement and velocity vary.
      integer :: mesh = 1
      !> Ends of the ranges over b_c and over b_c times the characteristic frequency [1]; both 0: three times the resting
      !> displacement either way.
      real(dp) :: displacement_start = 0, displacement_stop = 0, velocity_start = 0, velocity_stop = 0
      !> Starts along each, both ends included.
      integer :: displacement_points = 200, velocity_points = 200
      !> Random starts that find the motions first; seed of the random numbers.
      integer :: starts = 200, random_seed = 0
      !> Periods of the fundamental after which a start is not recognised any more.
      integer :: max_periods = 500
      !> Whether they are found even where the period is long.
      logical :: long_period = .false.
   end type basins_settings_type

   !> Basins of attraction.
   type :: basins_type
      !> The motions, as of attractors, then those that only starts of the grid found; `share` is that of the random starts.
      type(motion_type), allocatable :: motions(:)
      !> Lambda [1].
      real(dp) :: frequency_ratio = 0
      !> Mesh whose displacement and velocity vary; random starts done; seed of the random numbers.
      integer :: mesh = 1, starts = 0, random_seed = 0
      !> Starts: displacement and velocity of the mesh [1], (displacement), (velocity).
      real(dp), allocatable :: displacement(:), velocity(:)
      !> State at phase 0 that the starts have [1], (state), but for the places of the displacement and the velocity.
      real(dp), allocatable :: base(:)
      integer :: displacement_place = 1, velocity_place = 1
      !> Number of the motion that each start reaches; 0: not settled, -1: grown without bound, -2: not done yet; (displacement,
      !> velocity).
      integer, allocatable :: label(:, :)
      !> Shares of the starts of the grid, their standard errors as shares of the area, and the standard errors of the shares of the
      !> random starts [1], (motion).
      real(dp), allocatable :: grid_share(:), grid_share_error(:), share_error(:)
      !> Share of the starts of the grid that did not settle; that grew without bound [1].
      real(dp) :: unsettled = 0, unbounded = 0
      !> 'all starts done', or why not; not allocated: the map is under way.
      character(:), allocatable :: ended
      !> Whether all starts are done.
      logical :: complete = .false.
   contains
      procedure :: conclude
      procedure :: visit
   end type basins_type

contains

   !> Leads a visitor over the variables of &basins.
   subroutine visit_basins(settings, v)
      !> Values of the variables; set by a visitor that reads them.
      type(basins_settings_type), intent(inout) :: settings
      !> The visitor.
      class(visitor_type), intent(inout) :: v

      call v%enter('basins', 1)
      call v%on_real(row('frequency', '', 'frequency, in `unit`', required=.true., above=zero), settings%frequency)
      call visit_unit(settings%unit, v)
      call v%on_integer(row('mesh', '', 'number of the mesh whose displacement and velocity the starts vary', &
                            least=one), settings%mesh)
      call v%on_real(row('displacement_from', '', 'displacement at one end of the grid over characteristic_length; where both ends &
                         &are 0, the range is plus and minus three times the static displacement'), settings%displacement_start)
      call v%on_real(row('displacement_to', '', 'displacement at the other end of the grid'), settings%displacement_stop)
      call v%on_integer(row('displacement_points', '', 'starts along the displacement, both ends included', least=one, &
                            most=most_points), &
                        settings%displacement_points)
      call v%on_real(row('velocity_from', '', 'velocity at one end of the grid over characteristic_length times &
                         &characteristic_frequency; both ends 0: plus and minus three times the static displacement times the &
                         &natural frequency of the mesh alone'), settings%velocity_start)
      call v%on_real(row('velocity_to', '', 'velocity at the other end of the grid'), settings%velocity_stop)
      call v%on_integer(row('velocity_points', '', 'starts along the velocity, both ends included', least=one, most=most_points), &
                        settings%velocity_points)
      call v%on_integer(row('starts', '', 'random starts that find the motions first, as in &attractors', least=one, &
                            most=1e6*one), settings%starts)
      call v%on_integer(row('random_seed', '', 'the same seed gives the same random starts'), settings%random_seed)
      call v%on_integer(row('max_periods', '', 'longest time of a start in periods of the fundamental; near no known &
                            &motion it then goes on for up to 64 periods', least=one), &
                        settings%max_periods)
      call visit_long_period(settings%long_period, v)
      call v%leave()
   end subroutine visit_basins

   !> Checks values of &basins against one another and against the train.
   subroutine check_basins(train, settings, checker)
      type(train_type), intent(in) :: train
      !> The settings.
      type(basins_settings_type), intent(in) :: settings
      !> Collects the problems; nothing is checked if it has a problem of this group.
      class(checker_type), intent(inout) :: checker
      type(train_type) :: plain

      if (checker%problems%in_group('basins')) return
      call checker%enter('basins', 1)
      call check_unit(train, settings%unit, checker)
      call plain_train(train, plain)
      call check_frequency(plain, ['frequency'], [settings%frequency], checker, settings%unit)
      call check_range('displacement', settings%displacement_start, settings%displacement_stop, settings%displacement_points)
      call check_range('velocity', settings%velocity_start, settings%velocity_stop, settings%velocity_points)
      call check_long_period(train, 'basins', 'every start flies over many periods', settings%long_period, checker)
      if (.not. checker%problems%of_train()) call check_mesh()
      call checker%leave()

   contains

      subroutine check_range(name, from, to, points)
         character(*), intent(in) :: name
         real(dp), intent(in) :: from, to
         integer, intent(in) :: points

         if (.not. (abs(from) > 0 .or. abs(to) > 0)) return
         if (abs(from - to) <= 0 .neqv. points == 1) call checker%complain(name//'_points', integer_text(points), &
            'must be 1 where "'//name//'_from" and "'//name//'_to" are equal, and only there')
      end subroutine check_range

      !> A mesh that closes a loop is no coordinate.
      subroutine check_mesh()
         type(system_type) :: system

         associate (mesh => settings%mesh)
            if (.not. allocated(train%meshes)) return
            if (mesh > size(train%meshes)) then
               call checker%complain('mesh', integer_text(mesh), 'must be 1 to '//integer_text(size(train%meshes))//', a mesh of &
                                     &the train')
               return
            end if
            call build_system(train, system)
            if (system%mesh_element(mesh) > system%coordinates) call checker%complain('mesh', integer_text(mesh), &
               'must be another mesh: this one closes a loop, so that its displacement follows from the others')
         end associate
      end subroutine check_mesh

   end subroutine check_basins

   !> Shares with their errors, and why the map ended.
   subroutine conclude(self, done)
      class(basins_type), intent(inout) :: self
      !> Rows done.
      integer, intent(in) :: done
      real(dp) :: starts
      integer :: i

      associate (label => self%label(:, :done), n => size(self%motions))
         starts = max(1, size(label))
         self%grid_share = [(count(label == i)/starts, i=1, n)]
         self%grid_share_error = [(sampling_error(label == i), i=1, n)]
         self%share_error = [(sqrt(self%motions(i)%share*(1 - self%motions(i)%share)/self%starts), i=1, n)]
         self%unsettled = count(label == unsettled)/starts
         self%unbounded = count(label == ran_away)/starts
      end associate
      self%complete = done == size(self%velocity)
      self%ended = 'all starts done'
      if (.not. self%complete) self%ended = 'cancelled after '//text(done)//' of '//text(size(self%velocity))//' rows'
   end subroutine conclude

   !> Standard error of the share of an area by a grid of points: the share of each point's cell is taken as known to as well as the
   !> points about it agree, p (1 - p) with p their share, and the cells as independent.
   pure real(dp) function sampling_error(hit) result(error)
      !> Whether each point is in the area.
      logical, intent(in) :: hit(:, :)
      real(dp) :: variance, p
      integer :: i, j

      variance = 0
      do j = 1, size(hit, 2)
         do i = 1, size(hit, 1)
            associate (about => hit(max(1, i - 1):min(size(hit, 1), i + 1), max(1, j - 1):min(size(hit, 2), j + 1)))
               p = count(about)/real(size(about), dp)
            end associate
            variance = variance + p*(1 - p)
         end do
      end do
      error = sqrt(variance)/max(1, size(hit))
   end function sampling_error

   !> Visits the fields, see geartrain_base_fields.
   subroutine visit(self, fields)
      class(basins_type), intent(inout) :: self
      class(fields_type), intent(inout) :: fields
      integer :: n, states

      if (.not. fields%enter('/basins', 'basins of attraction: the steady motion that each start reaches at one frequency', &
         .true.)) return
      n = 0
      if (allocated(self%motions)) n = size(self%motions)
      call carry_text(fields, field('ended', '', '', 'why it ended, in words'), self%ended, 'not yet: these are the rows so far')
      call carry(fields, field('complete', '', '', '1 = all starts are done'), self%complete)
      call carry(fields, field('frequency', '', '', 'Lambda'), self%frequency_ratio)
      call carry(fields, field('mesh_number', '', '', 'number of the mesh whose displacement and velocity vary', least=1), &
                               self%mesh)
      call carry(fields, field('starts', '', '', 'number of random starts that found the motions first', least=0), self%starts)
      call carry(fields, field('random_seed', '', '', 'seed of the random starts'), self%random_seed)
      call carry(fields, field('unsettled', '', '', 'share of the starts of the grid that reached no motion'), &
                 self%unsettled)
      call carry(fields, field('unbounded', '', '', 'share of the starts of the grid that grew without bound; with grid_share and &
                               &`unsettled` it sums to 1'), self%unbounded)
      call carry(fields, field('displacement', 'displacement', '1', 'displacement of the mesh at phase 0 / &
                               &characteristic_length'), &
                 self%displacement)
      call carry(fields, field('velocity', 'velocity', '1', 'velocity of the mesh at phase 0 / (characteristic_length times &
                               &characteristic_frequency)'), self%velocity)
      call carry(fields, field('label', 'velocity displacement', '1', 'number of the motion that the start reaches, from 1; 0: &
                               &none, -1: growth without bound, -2: not done yet', least=not_done), self%label)
      states = 0
      if (allocated(self%base)) states = size(self%base)
      call fields%index_axis('start_coordinate', states, 'coordinate of `start_state`, in the order of `initial_state`')
      call carry(fields, field('start_state', 'start_coordinate', '1', 'state of all starts at phase 0, apart from displacement &
                               &and velocity of the mesh'), self%base)
      call carry(fields, field('displacement_place', '', '', 'place of the displacement of the mesh in the state, from 1', &
                               least=1), self%displacement_place)
      call carry(fields, field('velocity_place', '', '', 'place of the velocity of the mesh in the state, from 1', least=1), &
                               self%velocity_place)
      call fields%index_axis('motion', n, 'motion: as random starts found them, largest share first, then those that only the &
                           &grid found')
      call carry(fields, field('grid_share', 'motion', '1', 'share of the starts of the grid that reach the motion', &
                               optional=.true.), &
                 self%grid_share)
      call carry(fields, field('grid_share_error', 'motion', '1', 'standard error of grid_share as a share of the area, from the &
                               &agreement of neighbouring starts', optional=.true.), self%grid_share_error)
      call carry(fields, field('share_error', 'motion', '1', 'standard error of `share`', &
                             optional=.true.), self%share_error)
      if (allocated(fields%wrong)) return
      if (fields%way == reading) then
         allocate (self%motions(n))
         if (allocated(self%label)) call fields%check(all(self%label <= n), 'label')
      end if
      if (n > 0 .or. fields%way == listing) call visit_motions(self%motions, 'motion', fields)
   end subroutine visit

end module geartrain_analyses_basin_grid
