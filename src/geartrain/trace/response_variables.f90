!> The table of input variables: the group &response, with its checks.
module geartrain_trace_response_variables
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type, in_a_line
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text, real_text
   use geartrain_base_variable, only: row => variable_type, visitor_type
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_network_check_coupling, only: has_friction
   use geartrain_network_check_train, only: check_train
   use geartrain_network_frequency_unit, only: check_unit, lambda_per, visit_unit
   use geartrain_network_limits, only: check_common_period, check_frequency, check_harmonics
   use geartrain_network_long_period, only: check_variable
   use geartrain_network_parameter_path, only: parameter_path_type
   use geartrain_trace_branch, only: response_settings_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: visit_response, check_response, check_response_consistency, settings_for

   real(dp), parameter :: zero = 0, one = 1
   integer, parameter :: most_harmonics = 1000, most_samples = 1048576, highest_of_sets = 100000

contains

   !> Leads a visitor over the variables of &response.
   subroutine visit_response(settings, v)
      !> Values of the variables; set by a visitor that reads them.
      type(response_settings_type), intent(inout) :: settings
      !> The visitor.
      class(visitor_type), intent(inout) :: v
      character(:), allocatable :: word
      logical :: given

      call v%enter('response', 1)
      call v%on_real(row('from', '', 'frequency, or value of parameter, at which the branch begins', &
                         required=.true.), settings%start)
      call v%on_real(row('to', '', 'frequency, or value of parameter, at which the branch ends, above or below', &
                         required=.true.), settings%stop)
      word = trim(settings%parameter)
      call v%on_text(row('parameter', '', "number of the train that varies at constant frequency, as in 'input_torque', 'mesh 2 &
                         &half_backlash', 'mesh * damping_ratio', 'stiffness_variation'; several that take the same value &
                         &are separated by commas; blank: none"), word)
      if (allocated(word)) settings%parameter = word
      given = abs(settings%frequency) > 0
      call v%on_real(row('frequency', '', 'constant frequency of a branch over parameter', above=zero), settings%frequency, given)
      call visit_unit(settings%unit, v)
      call v%on_integer(row('harmonics', '', 'harmonics R of Lambda/subharmonic; 0: as many as tolerance needs, recommended for &
                            &trains with teeth', least=one, &
                            most=most_harmonics*one, automatic=zero), settings%harmonics)
      call v%on_integer(row('subharmonic', '', 'period of the motion in periods of the fundamental, eta', least=one, &
         &most=1000*one), &
                        settings%subharmonic)
      call v%on_logical(row('stability', '', 'stability of every point, by Floquet multipliers or, where a period has more than &
                            &500 cycles of a mesh, by the growth rate'), settings%stability)
      call v%on_logical(row('multipliers', '', 'all Floquet multipliers of every point to full accuracy, also for long periods and &
                            &large trains'), &
                        settings%multipliers)
      call v%on_logical(row('shaft_torque', '', 'mean and extremes of the torque of every shaft at every point'), &
                        settings%shaft_torque)
      call v%on_real(row('amplitude_limit', '', 'rms over characteristic_length above which the branch is followed but not stored; &
                         &-1: 12 times the larger of half backlash and static deflection, 10000 times for a linear train, where it &
                         &counts as infinite', above=zero, automatic=-one), &
                     settings%amplitude_limit)
      word = trim(settings%coefficients)
      call v%on_text(row('coefficients', '', 'Fourier coefficients of the mesh force: exact from the contact events, or sampled by &
                         &the discrete transform of the paper', &
                         choices='exact sampled'), word)
      settings%coefficients = word
      call v%on_integer(row('samples', '', 'samples per period for sampled coefficients; 0: chosen by the program', least=one, &
                            most=most_samples*one, automatic=zero), settings%samples)
      word = trim(settings%control)
      call v%on_text(row('control', '', 'continuation by pseudo-arclength, or by local switching of the control parameter, &
                         &equation (11) of the paper', choices='arclength local'), word)
      settings%control = word
      call v%on_real(row('tolerance', '', 'relative error of the waveform to reach where harmonics = 0', above=zero, most=one), &
                     settings%tolerance)
      call v%on_real(row('step', '', 'largest step along the branch: in Lambda and in mesh displacements together, each divided &
                         &by a power of ten near its size in the train', above=zero), &
                     settings%step)
      call v%on_integer(row('max_points', '', 'largest number of points; the branch ends there', least=2*one, most=1e7*one), &
                        settings%max_points)
      call v%on_integer(row('period_doublings', '', 'levels of period doubling to follow; 1: branches of twice the period, 2: also &
                            &of four times the period, ...', least=zero, most=6*one), settings%period_doublings)
      call v%on_logical(row('branch_points', '', 'follow also the branches that cross at branch points, as where equal stages &
                            &begin to move differently'), &
                        settings%branch_points)
      call v%on_logical(row('refine', '', 'refine every point by shooting to about 1e-11, with its multipliers, also on further &
                            &branches'), settings%refine)
      call v%leave()
   end subroutine visit_response

   !> Checks the settings of a response; the error tells every problem, one a line.
   subroutine check_response(train, settings, seeded, error)
      !> A train that check_train accepts.
      type(train_type), intent(in) :: train
      !> The settings.
      type(response_settings_type), intent(in) :: settings
      !> Whether the response starts from a given motion, not from rest.
      logical, intent(in) :: seeded
      type(error_type), allocatable, intent(out) :: error
      type(response_settings_type) :: copy
      type(checker_type) :: checker

      copy = settings
      call visit_response(copy, checker)
      call check_response_consistency(train, settings, seeded, checker)
      call checker%problems%raise('', error)
   end subroutine check_response

   !> Checks values of &response against one another and against the train.
   subroutine check_response_consistency(train, settings, seeded, checker)
      type(train_type), intent(in) :: train
      !> The settings.
      type(response_settings_type), intent(in) :: settings
      !> Whether the response may start from a given motion.
      logical, intent(in) :: seeded
      !> Collects the problems; only the signs are checked if it has a problem of this group.
      class(checker_type), intent(inout) :: checker
      type(train_type) :: plain
      logical :: within, whole

      call checker%enter('response', 1)
      if (has_friction(train)) call check_friction()
      ! A range of frequencies has positive ends; the ends of a path in a parameter are in the parameter's own range.
      if (settings%parameter == '') then
         if (settings%start <= 0) call checker%complain('from', real_text(settings%start), 'must be > 0')
         if (settings%stop <= 0) call checker%complain('to', real_text(settings%stop), 'must be > 0')
      end if
      if (checker%problems%in_group('response')) then
         call checker%leave()
         return
      end if
      if (abs(settings%start - settings%stop) <= 0) then
         call checker%complain('to', real_text(settings%stop), 'must differ from "from": a branch needs a range')
      end if
      if (settings%harmonics > 0 .and. settings%harmonics < settings%subharmonic) then
         call checker%complain('harmonics', integer_text(settings%harmonics), 'must be >= subharmonic = '// &
                               integer_text(settings%subharmonic)//': the fundamental itself would be left out')
      end if
      call check_unit(train, settings%unit, checker)
      call plain_train(train, plain)
      if (settings%parameter == '') then
         call check_ends()
      else
         call check_path()
      end if
      ! Where the orders are high the program carries sets of harmonics, however high, but for longer periods.
      call check_common_period(plain, 'response', checker, within)
      ! Shooting stores as many as time integration at least.
      if (within .and. .not. has_friction(train)) &
         call check_harmonics(plain, settings%harmonics, settings%subharmonic, merge(highest_of_sets, most_harmonics, &
                              settings%harmonics == 0 .and. settings%subharmonic == 1), checker)
      if (settings%samples > 0) then
         if (settings%harmonics == 0) then
            call checker%complain('samples', integer_text(settings%samples), 'must be 0 where harmonics = 0: with the harmonics &
                                  &their number is left to the program')
         else if (settings%samples < fewest_samples(settings%harmonics)) then
            call checker%complain('samples', integer_text(settings%samples), 'must be >= 8 harmonics + 2 = '// &
                                  integer_text(fewest_samples(settings%harmonics))//', or 0 to leave the choice to the program')
         end if
      end if
      if (settings%period_doublings > 0 .and. .not. settings%stability) then
         call checker%complain('period_doublings', integer_text(settings%period_doublings), &
                               'needs stability = .true.: the multipliers tell where a period doubles')
      end if
      if (settings%period_doublings > 0 .and. settings%subharmonic > 1 .and. .not. seeded) then
         call checker%complain('period_doublings', integer_text(settings%period_doublings), 'must be 0 where subharmonic > 1: &
                               &from rest the motion is one of period 1, whose doublings are followed with subharmonic = 1')
      end if
      whole = .not. within .or. settings%stability .and. settings%multipliers
      if (settings%period_doublings > 0) &
         call check_variable(train, settings%subharmonic*2**(settings%period_doublings - 1), 'period_doublings', &
                             integer_text(settings%period_doublings), 'needs multipliers over whole periods', whole, checker)
      if (settings%branch_points) call check_variable(train, settings%subharmonic, 'branch_points', '.true.', &
                                                      'needs multipliers over whole periods', whole, checker)
      if (settings%refine) call check_variable(train, 1, 'refine', '.true.', &
                                               'shoots over whole periods', whole, checker)
      call checker%leave()

   contains

      !> Checks what the response of a train with dry friction does not have, which is by shooting.
      subroutine check_friction()
         character(*), parameter :: why = ' for a train with friction_torque, whose motions are found by shooting, not by &
                                          &harmonic balance'

         if (settings%coefficients /= 'exact') call checker%complain('coefficients', "'"//trim(settings%coefficients)//"'", &
                                                                     "must be 'exact'"//why)
         if (settings%control /= 'arclength') call checker%complain('control', "'"//trim(settings%control)//"'", &
                                                                    "must be 'arclength'"//why)
         if (settings%period_doublings > 0) call checker%complain('period_doublings', integer_text(settings%period_doublings), &
            'must be 0'//why//'; find a motion of twice the period by &integration, and begin a branch with it')
         if (settings%branch_points) call checker%complain('branch_points', '.true.', 'must be .false.'//why)
         call check_variable(train, settings%subharmonic, 'from', real_text(settings%start), 'shoots over whole periods, as &
                             &the train has friction_torque', .false., checker)
      end subroutine check_friction

      !> Checks the ends of a range of frequencies.
      subroutine check_ends()
         call check_frequency(plain, ['from', 'to  '], [settings%start, settings%stop], checker, settings%unit)
         if (abs(settings%frequency) > 0) &
            call checker%complain('frequency', real_text(settings%frequency), 'belongs to parameter, which is not given')
      end subroutine check_ends

      !> Checks a path in a parameter.
      subroutine check_path()
         type(parameter_path_type) :: path
         type(error_type), allocatable :: wrong

         if (.not. settings%frequency > 0) then
            call checker%complain('frequency', real_text(settings%frequency), 'must be given with parameter, > 0: &
                                  &the frequency stays constant')
            return
         end if
         call check_frequency(plain, ['frequency'], [settings%frequency], checker, settings%unit)
         if (checker%problems%of_train() .or. checker%problems%in_group('response')) return
         ! What is wrong with the train is told elsewhere.
         call check_train(train, wrong)
         if (allocated(wrong)) return
         if (.not. lambda_per(train, settings%unit) > 0) return
         call path%setup(train, settings%parameter, settings%frequency*lambda_per(train, settings%unit), settings%start, &
                         settings%stop, wrong)
         if (allocated(wrong)) call checker%complain('parameter', "'"//trim(settings%parameter)//"'", in_a_line(wrong%message))
      end subroutine check_path

   end subroutine check_response_consistency

   !> Fewest samples a period of the mesh force for the spectra of a harmonic balance.
   pure integer function fewest_samples(harmonics)
      !> Harmonics of the balance.
      integer, intent(in) :: harmonics

      fewest_samples = 8*harmonics + 2
   end function fewest_samples

   !> Settings for motions of another period, with as many harmonics and samples a period of the fundamental.
   pure function settings_for(settings, period) result(other)
      !> Settings to start from.
      type(response_settings_type), intent(in) :: settings
      !> The other period in periods of the fundamental.
      integer, intent(in) :: period
      type(response_settings_type) :: other

      other = settings
      other%subharmonic = period
      other%repeats = 0
      if (settings%harmonics > 0) &
         other%harmonics = max(period, min(most_harmonics, settings%harmonics*period/settings%subharmonic))
      if (settings%samples > 0) other%samples = max(fewest_samples(other%harmonics), &
                                                    min(most_samples, settings%samples*period/settings%subharmonic))
   end function settings_for

end module geartrain_trace_response_variables
