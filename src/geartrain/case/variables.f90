!> The table of input variables, second part: the groups of a case file, and the variables of the analyses.
module geartrain_case_variables
   use geartrain_base_kinds, only: dp
   use geartrain_base_variable, only: row => variable_type, visitor_type
   use geartrain_branch_branch, only: response_settings_type
   use geartrain_case_case, only: case_type
   use geartrain_model_variables, only: visit_model
   use geartrain_motion_integration_settings, only: integration_settings_type
   implicit none (type, external)
   private
   public :: groups, visit_case, visit_modes, visit_response, visit_integration, visit_output, check_response, check_integration

   !> A group that a case file may hold.
   type :: group_row_type
      character(12) :: name = ''
      character(200) :: description = ''
   end type group_row_type

   type(group_row_type), parameter :: groups(*) = [ &
      group_row_type('train', 'The train as a whole. Once, first in the file.'), &
      group_row_type('shaft', 'A shaft. M times, alternating with &mesh: shaft, mesh, shaft, ..., shaft; at least two.'), &
      group_row_type('mesh', 'A gear pair. M-1 times, each between two &shaft groups.'), &
      group_row_type('modes', 'Asks for undamped and damped natural frequencies and mode shapes of the mean system.'), &
      group_row_type('response', 'Asks for the branch of periodic motions over frequency, by harmonic balance.'), &
      group_row_type('integration', 'Asks for the steady motions that time integration settles on, over frequency.'), &
      group_row_type('output', 'Where the results go.')]

   real(dp), parameter :: zero = 0, one = 1

contains

   !> All groups of a case, in the order of a case file.
   subroutine visit_case(case, visitor)
      type(case_type), intent(inout) :: case
      class(visitor_type), intent(inout) :: visitor

      call visit_model(case%train, visitor)
      if (case%modes) call visit_modes(visitor)
      if (allocated(case%response)) call visit_response(case%response, visitor)
      if (allocated(case%integration)) call visit_integration(case%integration, visitor)
      call visit_output(case%output_file, visitor)
   end subroutine visit_case

   !> The group has no variables.
   subroutine visit_modes(v)
      class(visitor_type), intent(inout) :: v

      call v%enter('modes', 1)
      call v%leave()
   end subroutine visit_modes

   subroutine visit_response(settings, v)
      type(response_settings_type), intent(inout) :: settings
      class(visitor_type), intent(inout) :: v
      character(:), allocatable :: word

      call v%enter('response', 1)
      call v%on_real(row('from', '', 'Lambda at which the branch begins (start in a call)', required=.true., above=zero), &
                     settings%start)
      call v%on_real(row('to', '', 'Lambda at which it ends, above or below (stop in a call)', required=.true., above=zero), &
                     settings%stop)
      call v%on_integer(row('harmonics', '', 'harmonics R of Lambda/subharmonic; 0: as many as tolerance needs', least=one, &
                            automatic=zero), settings%harmonics)
      call v%on_integer(row('subharmonic', '', 'period of the motion in fundamental mesh periods, eta', least=one), &
                        settings%subharmonic)
      call v%on_logical(row('stability', '', 'Floquet multipliers of every point'), settings%stability)
      call v%on_real(row('amplitude_limit', '', 'rms over characteristic length at which the branch is given up; -1: 12 with &
                         &backlash, none for a linear train', above=zero, automatic=-one), settings%amplitude_limit)
      word = trim(settings%coefficients)
      call v%on_text(row('coefficients', '', 'Fourier coefficients of the mesh force: exact from the contact events, or sampled &
                         &(the discrete transform of the paper)', choices='exact sampled'), word)
      settings%coefficients = word
      call v%on_integer(row('samples', '', 'points a period for sampled coefficients; 0: chosen by the program', least=one, &
                            automatic=zero), settings%samples)
      word = trim(settings%control)
      call v%on_text(row('control', '', 'pseudo-arclength, or the local switching of the control parameter of the paper, &
                         &equation (11)', choices='arclength local'), word)
      settings%control = word
      call v%on_real(row('tolerance', '', 'relative error of the waveform aimed at where harmonics = 0', above=zero, most=one), &
                     settings%tolerance)
      call v%on_real(row('step', '', 'largest step along the branch, in Lambda and mesh displacement together', above=zero), &
                     settings%step)
      call v%on_integer(row('max_points', '', 'points after which the branch is given up', least=2*one), settings%max_points)
      call v%leave()
   end subroutine visit_response

   subroutine visit_integration(settings, v)
      type(integration_settings_type), intent(inout) :: settings
      class(visitor_type), intent(inout) :: v
      character(:), allocatable :: word

      call v%enter('integration', 1)
      call v%on_real(row('from', '', 'one end of the range of Lambda (start in a call)', required=.true., above=zero), &
                     settings%start)
      call v%on_real(row('to', '', 'its other end (stop in a call)', required=.true., above=zero), settings%stop)
      call v%on_integer(row('points', '', 'frequencies in the range, both ends included', least=one), settings%points)
      word = trim(settings%direction)
      call v%on_text(row('direction', '', 'order in which the frequencies are visited, each starting from the motion before', &
                         choices='up down both'), word)
      settings%direction = word
      call v%on_integer(row('harmonics', '', 'harmonics of the motion that are stored', least=one), settings%harmonics)
      call v%on_integer(row('max_periods', '', 'mesh periods after which an unsettled motion is given up', least=one), &
                        settings%max_periods)
      call v%on_real(row('tolerance', '', 'relative change over a period of the motion at which it counts as settled', &
                         above=zero, most=one), settings%tolerance)
      call v%on_logical(row('stability', '', 'Floquet multipliers of every settled motion'), settings%stability)
      call v%leave()
   end subroutine visit_integration

   subroutine visit_output(file, v)
      character(:), allocatable, intent(inout) :: file
      class(visitor_type), intent(inout) :: v

      call v%enter('output', 1)
      call v%on_text(row('file', '', 'name of the HDF5 file, relative to the working directory; empty: the name of the case file &
                         &with .h5, in the working directory'), file)
      call v%leave()
   end subroutine visit_output

   !> What single values of &response cannot say; '' where they agree. `name` is the variable that the message is about.
   subroutine check_response(settings, name, text)
      type(response_settings_type), intent(in) :: settings
      character(:), allocatable, intent(out) :: name, text

      name = ''
      text = ''
      if (abs(settings%start - settings%stop) <= 0) then
         name = 'to'
         text = 'from and to are equal: give two frequencies'
      else if (settings%harmonics > 0 .and. settings%harmonics < settings%subharmonic) then
         name = 'harmonics'
         text = 'harmonics is below subharmonic: the mesh frequency itself would be left out'
      else if (settings%samples > 0 .and. settings%samples <= 2*settings%harmonics) then
         name = 'samples'
         text = 'samples must be above twice the number of harmonics, or 0'
      end if
   end subroutine check_response

   !> What single values of &integration cannot say, likewise.
   subroutine check_integration(settings, name, text)
      type(integration_settings_type), intent(in) :: settings
      character(:), allocatable, intent(out) :: name, text

      name = ''
      text = ''
      if (abs(settings%start - settings%stop) <= 0 .and. settings%points > 1) then
         name = 'points'
         text = 'from and to are equal: points must be 1'
      end if
   end subroutine check_integration

end module geartrain_case_variables
