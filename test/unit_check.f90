!> Trains and settings that a Fortran caller fills: what is refused, word for word.
module unit_check
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use geartrain_analyses_attractors, only: attractors_settings_type, check_attractors
   use geartrain_analyses_integration, only: check_integration
   use geartrain_analyses_list, only: case_type
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp
   use geartrain_flow_integration_settings, only: integration_settings_type
   use geartrain_input_template, only: paper_case
   use geartrain_network_check_train, only: check_train
   use geartrain_trace_branch, only: response_settings_type
   use geartrain_trace_response_variables, only: check_response
   use geartrain_train_train, only: train_type
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: check_tests

contains

   subroutine check_tests(tests)
      class(tests_type), intent(inout) :: tests
      type(error_type), allocatable :: error
      type(case_type) :: case

      if (tests%runs('good_trains')) then
         case = paper_case()
         call check_train(case%train, error)
         call tests%is_true(.not. allocated(error), 'the train of the paper is sound')
         case%train%input_torque = -1
         call check_train(case%train, error)
         call tests%is_true(.not. allocated(error), 'a negative torque is allowed')
         case%train%shafts(1)%rigid = .true.
         case%train%shafts(1)%stiffness = 0
         case%train%shafts(1)%damping_ratio = 0
         case%train%prime_mover_inertia = 0
         call check_train(case%train, error)
         call tests%is_true(.not. allocated(error), 'no inertia at the end of a rigid shaft')
      end if
      if (tests%runs('bad_trains')) call bad_trains(tests)
      if (tests%runs('bad_scales')) call bad_scales(tests)
      if (tests%runs('bad_settings')) call bad_settings(tests)
   end subroutine check_tests

   subroutine bad_trains(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: empty
      type(case_type) :: case

      case = paper_case()
      case%train%meshes(2)%stiffness = -1
      case%train%meshes(1)%error_sin = [0.0_dp, ieee_value(1.0_dp, ieee_quiet_nan)]
      call refused(tests, case%train, '&mesh 1: error_sin harmonic 2 = NaN: must be finite'//new_line('a')// &
                   '&mesh 2: stiffness = -1.0: must be > 0 N/m')
      case = paper_case()
      case%train%load_inertia = 0
      call refused(tests, case%train, '&train: load_inertia = 0.0: must be > 0 kg m^2, or the last shaft must have rigid = .true.')
      case = paper_case()
      case%train%shafts(2)%rigid = .true.
      case%train%shafts(2)%damping_ratio = 0
      call refused(tests, case%train, '&shaft 2: stiffness = 1.0e8: contradicts rigid = .true.: leave out one of the two')
      case = paper_case()
      case%train%shafts(3)%stiffness = 0
      call refused(tests, case%train, '&shaft 3: lacks stiffness (> 0 N m/rad) or rigid = .true., or diameter and &
                   &length')
      case = paper_case()
      case%train%load_inertia = 1e-20_dp
      call refused(tests, case%train, '&shaft 3: stiffness = 1000.0: must be smaller: it makes the part vibrate more than 1e6 &
                   &times as fast as the slowest mesh, too fast to be followed: make the shaft rigid, or give the inertias at &
                   &its ends as they are')
      case = paper_case()
      case%train%meshes = case%train%meshes(:1)
      call refused(tests, case%train, 'the train has 3 &shaft and 1 &mesh: a train is shaft, mesh, shaft, ..., shaft, at least &
                   &2 shafts and one mesh less than shafts')
      empty%characteristic_length = 1
      empty%characteristic_frequency = 1
      call refused(tests, empty, 'the train has 0 &shaft and 0 &mesh: a train is shaft, mesh, shaft, ..., shaft, at least &
                   &2 shafts and one mesh less than shafts')
   end subroutine bad_trains

   !> Values in their ranges whose products are not. By hand, of the paper's train: the slowest mesh vibrates at
   !> sqrt(2.5e8 (0.05^2/0.0023 + 0.1^2/0.037)) = 18420.28 rad/s, and T deflects mesh 1 by T/(0.05*2.5e8) = T*8e-8 m.
   subroutine bad_scales(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type) :: case

      case = paper_case()
      case%train%input_torque = 1e300_dp
      case%train%meshes(1)%stiffness = 1e-300_dp
      call refused(tests, case%train, '&train: input_torque = 1.0e300: must be finite, of a magnitude from 1.0e-20 to 1.0e20' &
                   //new_line('a')//'&mesh 1: stiffness = 1.0e-300: must be > 0 N/m, of a magnitude from 1.0e-20 to 1.0e20')
      case = paper_case()
      case%train%characteristic_frequency = 1e-6_dp
      call refused(tests, case%train, '&train: characteristic_frequency = 1.0e-6: must be within a factor of 1e9 of the &
                   &frequency of the slowest mesh, 18420.279531 rad/s by its stiffness, radii and inertias')
      case = paper_case()
      case%train%input_torque = 1e20_dp
      case%train%characteristic_length = 1e-12_dp
      call refused(tests, case%train, '&train: input_torque = 1.0e20: must be smaller, or characteristic_length larger: the &
                   &static deflection of &mesh 1 (by it, the radii up to there and the stiffness) is 1e25 times &
                   &characteristic_length, at most 1e20 is allowed')
      case = paper_case()
      case%train%input_torque = 1e-10_dp
      call refused(tests, case%train, '&train: input_torque = 1.0e-10: must be 0 or larger: the static deflection of &mesh 1 &
                   &(by it, the radii up to there and the stiffness), 1e-17 m, is lost in rounding beside its half_backlash')
      case = paper_case()
      case%train%meshes(2)%half_backlash = 1e-19_dp
      call refused(tests, case%train, '&mesh 2: half_backlash = 1.0e-19: must be 0 or larger: it is lost in rounding beside the &
                   &static deflection (by input_torque, the radii up to there and the stiffness), 1e-5 m')
      case = paper_case()
      case%train%meshes(2)%error_sin = [0.0_dp, 1e19_dp]
      case%train%characteristic_length = 1e-6_dp
      case%train%meshes(1)%stiffness_cos = [0.3_dp, -2000.0_dp]
      call refused(tests, case%train, '&mesh 1: stiffness_cos harmonic 2 = -2000.0: must be of a magnitude <= 1000: it is a &
                   &share of the mean stiffness'//new_line('a')//'&mesh 2: error_sin = 1.0e19: must be smaller, or &
                   &characteristic_length larger: it is 1e25 times characteristic_length, at most 1e20 is allowed')
      case = paper_case()
      case%train%input_torque = 0
      case%train%meshes%half_backlash = 0
      case%train%meshes(1)%error_cos = [1e-30_dp]
      call refused(tests, case%train, '&train: characteristic_length = 3.0e-5: must be smaller: the largest displacement given &
                   &(half_backlash, the static deflection, an error or that by a torque amplitude) is only 1e-30 m')
      case = paper_case()
      case%train%shafts(2)%stiffness = 1e-9_dp
      call refused(tests, case%train, '&shaft 2: stiffness = 1.0e-9: must be larger: it makes the part vibrate more than 1e6 &
                   &times as slowly as the slowest mesh, which is lost in rounding')
      case = paper_case()
      case%train%meshes(1)%damping_ratio = 1e6_dp
      call refused(tests, case%train, '&mesh 1: damping_ratio = 1.0e6: must be smaller: the rate at which it brings the part &
                   &to rest, damping times frequency^2 over stiffness, is more than 1e6 times the frequency of the slowest &
                   &mesh, too fast to be followed')
   end subroutine bad_scales

   subroutine refused(tests, train, message)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      character(*), intent(in) :: message
      type(error_type), allocatable :: error

      call check_train(train, error)
      call tests%is_true(allocated(error), 'refused: '//message)
      if (allocated(error)) call tests%is_text(error%message, message, 'message')
   end subroutine refused

   subroutine bad_settings(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(case_type) :: case
      type(error_type), allocatable :: error

      case = paper_case()
      train = case%train
      call check_response(train, response_settings_type(start=0.2_dp, stop=2.6_dp), .false., error)
      call tests%is_true(.not. allocated(error), 'default settings of a response')
      call check_response(train, response_settings_type(start=0.2_dp, stop=2.6_dp, control='x', step=0.0_dp), .false., error)
      call tests%is_true(allocated(error), 'bad settings of a response are refused')
      if (allocated(error)) call tests%is_text(error%message, '&response: control = ''x'': must be ''arclength'' or ''local''' &
                                               //new_line('a')//'&response: step = 0.0: must be > 0', 'message')
      call check_integration(train, integration_settings_type(start=0.2_dp, stop=2.6_dp), error)
      call tests%is_true(.not. allocated(error), 'default settings of a sweep')
      call check_integration(train, integration_settings_type(start=0.2_dp, stop=2.6_dp, points=0), error)
      call tests%is_true(allocated(error), 'bad settings of a sweep are refused')
      if (allocated(error)) call tests%is_text(error%message, '&integration: points = 0: must be >= 1 and <= 100000', 'message')
      ! What would keep the program busy for hours, fill the memory, or leave an excitation out.
      call check_response(train, response_settings_type(start=5e-5_dp, stop=2.6_dp), .false., error)
      call tests%is_true(allocated(error), 'a Lambda far below what the train vibrates at is refused')
      if (allocated(error)) call tests%is_text(error%message, '&response: from = 5.0e-5: must be >= 0.0001: at a slower &
         &speed there are some 10000 vibrations or more of the slowest mesh in a cycle of the teeth of mesh 1, too many to be &
         &followed; begin there: a slower train follows its loads and errors without vibration', 'message')
      train%characteristic_frequency = 1e6_dp*train%characteristic_frequency
      call check_response(train, response_settings_type(start=2e-7_dp, stop=2.6e-6_dp), .false., error)
      call tests%is_true(.not. allocated(error), 'the same Lambda over the own frequency of the train: any unit will do')
      train = case%train
      train%characteristic_frequency = 1e-300_dp
      train%meshes%stiffness = [1e300_dp, 1e300_dp]
      train%meshes%driving_inertia = 1e-300_dp
      call check_response(train, response_settings_type(start=0.2_dp, stop=2.6_dp), .false., error)
      call tests%is_true(allocated(error), 'a frequency beyond all numbers: refused without an overflow')
      train = case%train
      train%meshes%order = [2, 17]
      call check_response(train, response_settings_type(start=0.2_dp, stop=2.6_dp, harmonics=33, subharmonic=2), .false., error)
      call tests%is_true(allocated(error), 'harmonics that do not reach the mesh frequency are refused')
      if (allocated(error)) call tests%is_text(error%message, '&response: harmonics = 33: must be >= 17*subharmonic = 34: the &
                                               &variation of the stiffness of &mesh 2 has no lower harmonic of Lambda and would &
                                               &be left out; 0 chooses those that matter', 'message')
      call check_response(train, response_settings_type(start=0.2_dp, stop=2.6_dp, harmonics=0, subharmonic=59), .false., error)
      call tests%is_true(allocated(error), 'and so they are where the program would choose them: 17*59 is more than 1000')
      train%torque_cos = [0.0_dp, 0.0_dp, 1.0_dp]
      call check_response(train, response_settings_type(start=0.2_dp, stop=2.6_dp, harmonics=17), .false., error)
      call tests%is_true(.not. allocated(error), 'a torque of order 3 with 17 harmonics')
      train%meshes%order = 1
      call check_response(train, response_settings_type(start=0.2_dp, stop=2.6_dp, harmonics=2), .false., error)
      call tests%is_true(allocated(error), 'with 2 it would be left out')
      deallocate (train%torque_cos)
      train%meshes%order = [2, 17]
      call check_integration(train, integration_settings_type(start=0.2_dp, stop=2.6_dp, harmonics=16), error)
      call tests%is_true(allocated(error), 'and so are those of a motion that is integrated')
      if (allocated(error)) call tests%is_text(error%message, '&integration: harmonics = 16: must be >= 17: the variation of the &
                                               &stiffness of &mesh 2 has no lower harmonic of Lambda and would be left out; &
                                               &0 chooses those that matter', &
                                               'message')
      call check_attractors(train, attractors_settings_type(frequency=0.2_dp, harmonics=16), error)
      call tests%is_true(allocated(error), 'and of random starts')
      ! Spectra of sampled coefficients reach twice the harmonics.
      call check_response(train, response_settings_type(start=0.2_dp, stop=2.6_dp, harmonics=0, coefficients='sampled', &
                                                        samples=2), .false., error)
      call tests%is_true(allocated(error), 'a number of samples for harmonics that are not known is refused')
      if (allocated(error)) call tests%is_text(error%message, '&response: samples = 2: must be 0 where harmonics = 0: with the &
                                               &harmonics their number is left to the program', 'message')
      call check_response(train, response_settings_type(start=0.2_dp, stop=2.6_dp, harmonics=34, subharmonic=2), .false., error)
      call tests%is_true(.not. allocated(error), 'harmonics that just reach it')
      train%meshes(2)%stiffness_cos = [0.0_dp]
      call check_response(train, response_settings_type(start=0.2_dp, stop=2.6_dp, harmonics=4, subharmonic=2), .false., error)
      call tests%is_true(.not. allocated(error), 'a mesh that excites nothing needs no harmonics')
      call check_response(train, response_settings_type(start=0.2_dp, stop=2.6_dp, subharmonic=2, period_doublings=1), .false., &
                          error)
      call tests%is_true(allocated(error), 'doublings of period 1 are not found with subharmonic 2')
      call check_response(train, response_settings_type(start=0.2_dp, stop=2.6_dp, subharmonic=2, period_doublings=1), .true., &
                          error)
      call tests%is_true(.not. allocated(error), 'those of a seed of period 2 are')
      call check_integration(case%train, integration_settings_type(start=0.2_dp, stop=2.6_dp, points=2000000000), error)
      call tests%is_true(allocated(error), 'more points than memory are refused')
   end subroutine bad_settings

end module unit_check
