!> The table of input variables: those of &integration and &attractors.
module geartrain_flow_variables
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text
   use geartrain_base_variable, only: row => variable_type, visitor_type
   use geartrain_flow_attractors_settings, only: attractors_settings_type
   use geartrain_flow_integration_settings, only: integration_settings_type
   use geartrain_model_limits, only: check_frequency, check_harmonics
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: visit_integration, check_integration, check_integration_consistency, visit_attractors, check_attractors, &
      check_attractors_consistency

   real(dp), parameter :: zero = 0, one = 1
   integer, parameter :: most_harmonics = 20000

contains

   subroutine visit_integration(settings, v)
      type(integration_settings_type), intent(inout) :: settings
      class(visitor_type), intent(inout) :: v
      character(:), allocatable :: word

      call v%enter('integration', 1)
      call v%on_real(row('from', '', 'one end of the range of Lambda (start in a call)', required=.true., above=zero), &
                     settings%start)
      call v%on_real(row('to', '', 'its other end (stop in a call)', required=.true., above=zero), settings%stop)
      call v%on_integer(row('points', '', 'frequencies in the range, both ends included', least=one, most=1e5*one), settings%points)
      word = trim(settings%direction)
      call v%on_text(row('direction', '', 'order in which the frequencies are visited, each starting from the motion before', &
                         choices='up down both'), word)
      settings%direction = word
      call v%on_integer(row('harmonics', '', 'harmonics of Lambda that are stored of the motion; 0: 16 of the highest &
                            &mesh order', &
                            least=one, most=most_harmonics*one, automatic=zero), settings%harmonics)
      call v%on_integer(row('max_periods', '', 'mesh periods after which an unsettled motion is given up', least=one), &
                        settings%max_periods)
      call v%on_real(row('tolerance', '', 'relative change over a period of the motion at which it counts as settled', &
                         above=zero, most=one), settings%tolerance)
      call v%on_logical(row('stability', '', 'Floquet multipliers of every settled motion'), settings%stability)
      call v%leave()
   end subroutine visit_integration

   !> Checks the settings of a sweep for a train that is in order; the error tells every problem, one a line.
   subroutine check_integration(train, settings, error)
      type(train_type), intent(in) :: train
      type(integration_settings_type), intent(in) :: settings
      type(error_type), allocatable, intent(out) :: error
      type(integration_settings_type) :: copy
      type(checker_type) :: checker

      copy = settings
      call visit_integration(copy, checker)
      call check_integration_consistency(train, settings, checker)
      call checker%problems%raise('', error)
   end subroutine check_integration

   !> What single values cannot say; the problems are added to those of `checker`.
   subroutine check_integration_consistency(train, settings, checker)
      type(train_type), intent(in) :: train
      type(integration_settings_type), intent(in) :: settings
      class(checker_type), intent(inout) :: checker

      if (checker%problems%in_group('integration')) return
      call checker%enter('integration', 1)
      if (abs(settings%start - settings%stop) <= 0 .and. settings%points /= 1) &
         call checker%complain('points', integer_text(settings%points), 'must be 1 where "from" and "to" are equal')
      call check_frequency(train, 'from', settings%start, checker)
      call check_frequency(train, 'to', settings%stop, checker)
      if (settings%harmonics > 0) call check_harmonics(train, settings%harmonics, 1, most_harmonics, checker)
      call checker%leave()
   end subroutine check_integration_consistency

   subroutine visit_attractors(settings, v)
      type(attractors_settings_type), intent(inout) :: settings
      class(visitor_type), intent(inout) :: v

      call v%enter('attractors', 1)
      call v%on_real(row('frequency', '', 'Lambda', required=.true., above=zero), settings%frequency_ratio)
      call v%on_integer(row('starts', '', 'random starts: mesh displacements and velocities within three times the resting &
                            &displacement', least=one, most=1e6*one), settings%starts)
      call v%on_integer(row('random_seed', '', 'the same seed gives the same starts'), settings%random_seed)
      call v%on_logical(row('follow', '', 'each motion found that lies on no branch of the case yet is followed as one, over the &
                            &range of &response and with its settings'), settings%follow)
      call v%on_integer(row('harmonics', '', 'harmonics of Lambda that are stored of each motion; 0: 16 of the highest &
                            &mesh order', &
                            least=one, most=most_harmonics*one, automatic=zero), settings%harmonics)
      call v%on_integer(row('max_periods', '', 'mesh periods after which an unsettled start is given up', least=one), &
                        settings%max_periods)
      call v%on_real(row('tolerance', '', 'relative change over a period of the motion at which it counts as settled', &
                         above=zero, most=one), settings%tolerance)
      call v%on_logical(row('stability', '', 'Floquet multipliers of every motion'), settings%stability)
      call v%leave()
   end subroutine visit_attractors

   !> Checks the settings of a search for a train that is in order; the error tells every problem, one a line.
   subroutine check_attractors(train, settings, error)
      type(train_type), intent(in) :: train
      type(attractors_settings_type), intent(in) :: settings
      type(error_type), allocatable, intent(out) :: error
      type(attractors_settings_type) :: copy
      type(checker_type) :: checker

      copy = settings
      call visit_attractors(copy, checker)
      call check_attractors_consistency(train, settings, checker)
      call checker%problems%raise('', error)
   end subroutine check_attractors

   !> What single values cannot say; the problems are added to those of `checker`.
   subroutine check_attractors_consistency(train, settings, checker)
      type(train_type), intent(in) :: train
      type(attractors_settings_type), intent(in) :: settings
      class(checker_type), intent(inout) :: checker

      if (checker%problems%in_group('attractors')) return
      call checker%enter('attractors', 1)
      call check_frequency(train, 'frequency', settings%frequency_ratio, checker)
      if (settings%harmonics > 0) call check_harmonics(train, settings%harmonics, 1, most_harmonics, checker)
      call checker%leave()
   end subroutine check_attractors_consistency

end module geartrain_flow_variables
