!> Slips of a drawing: one slip is told by one message, and a number in another unit is told with the unit that is meant.
module unit_slips
   use geartrain, only: case_type, error_type, read_case_text, warnings_text
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: slips_tests

   character(*), parameter :: n = new_line('a')
   !> A two-stage reducer without a slip.
   character(*), parameter :: reducer = &
      "&train title = 'reducer' /"//n// &
      "&body name = 'motor', inertia = 0.02, torque = 90.0 /"//n// &
      "&body name = 'p1' /"//n// &
      "&body name = 'w1' /"//n// &
      "&body name = 'p2' /"//n// &
      "&body name = 'w2' /"//n// &
      "&body name = 'load', outer_diameter = 0.5, width = 0.03, density = 7800.0, balances = .true. /"//n// &
      "&shaft between = 'motor', 'p1', diameter = 0.03, length = 0.15, damping_ratio = 0.01 /"//n// &
      "&shaft between = 'w1', 'p2', diameter = 0.04, length = 0.12, damping_ratio = 0.02 /"//n// &
      "&shaft between = 'w2', 'load', diameter = 0.06, length = 0.2, damping_ratio = 0.02 /"//n// &
      "&mesh between = 'p1', 'w1', teeth = 23, 71, normal_module = 2.5e-3, pressure_angle = 20.0, helix_angle = 15.0, "// &
      "face_width = 0.04, backlash = 60e-6, density = 7850.0, damping_ratio = 0.05, error_cos = 3e-6 /"//n// &
      "&mesh between = 'p2', 'w2', teeth = 19, 80, normal_module = 4e-3, face_width = 0.07, backlash = 60e-6 /"//n// &
      "&response from = 200.0, to = 4000.0, unit = 'rpm', harmonics = 0, tolerance = 1e-3 /"//n// &
      "&run_up from = 200.0, to = 4000.0, unit = 'rpm', duration = 5.0 /"//n

contains

   subroutine slips_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('one_message')) call one_message(tests)
      if (tests%runs('other_units')) call other_units(tests)
   end subroutine slips_tests

   !> What follows from a wrong value is not told beside it.
   subroutine one_message(tests)
      class(tests_type), intent(inout) :: tests

      call is_told(tests, 'title', 'title', '')
      call is_told(tests, 'teeth = 23, 71', 'teeth = 23', '&mesh 1: teeth = 1 values: must be 2 values')
      call is_told(tests, 'teeth = 23, 71', 'teeth = 23.5, 71', '&mesh 1: teeth value 1 = 23.5: must be >= 3 and <= 100000 and &
                   &whole')
      call is_told(tests, 'teeth = 23, 71', 'teeth = 23, -71', '&mesh 1: teeth value 2 = -71: must be >= 3 and <= 100000 and whole')
      call is_told(tests, 'pressure_angle = 20.0', 'pressure_angle = 0.349', '&mesh 1: pressure_angle = 0.349: must be >= 10 and &
                   &<= 35 degree')
      call is_told(tests, 'face_width = 0.07', 'face_width = 0,07', '&mesh 2: face_width = 0, 07: takes one value, not 2 (a text &
                   &needs quotes, a decimal is written with a point)')
      call is_told(tests, ', face_width = 0.07', '', '&mesh 2: lacks face_width (> 0 m) or stiffness or stiffness_table')
      call is_told(tests, ', normal_module = 4e-3', '', '&mesh 2: lacks normal_module (> 0 m), to which the rest of the drawing &
                   &belongs')
      call is_told(tests, ', length = 0.12', '', '&shaft 2: lacks length (> 0 m): as many as of the other')
      call is_told(tests, ', width = 0.03', '', '&body 6: lacks width (> 0 m): as many as of the other')
      call is_told(tests, "name = 'p1'", 'name = p1', "&body 2: name = p1: must be a text in quotes, '...'")
      call is_told(tests, "'w1', 'p2'", "'w1', 'p22'", "&shaft 2: between = 'p22': is the name of no &body (did you mean 'p2'?)")
      call is_told(tests, ', inertia = 0.02', ', inertia = -0.02', '&body 1: inertia = -0.02: must be >= 0 kg m^2')
      ! Two slips are told at once.
      call is_told(tests, 'face_width = 0.07', 'face_width = -0.07, damping_ratio = -1', &
                   '&mesh 2: face_width = -0.07: must be > 0 m'//n//'&mesh 2: damping_ratio = -1: must be >= 0')
   end subroutine one_message

   !> A length in millimetres or micrometres, an angle in rad, a ratio in percent, a density in g/cm^3.
   subroutine other_units(tests)
      class(tests_type), intent(inout) :: tests
      character(*), parameter :: nothing_left = ' m: it leaves nothing of the teeth, whose pitch at the working pitch circle is &
         &0.008131 m; the unit is the metre (60 um is 60e-6)'

      ! Impossible: no tooth is left by a gap as wide as the pitch, pi m_n/cos(beta) = 8.131 mm; along the line of action half a gap
      ! is half of that times cos(20.647 degrees).
      call is_told(tests, 'backlash = 60e-6', 'backlash = 0.06', '&mesh 1: backlash = 0.06: must be < 0.008131'//nothing_left)
      call is_told(tests, 'backlash = 60e-6', 'backlash = 60.0', '&mesh 1: backlash = 60.0: must be < 0.008131'//nothing_left)
      call is_told(tests, 'backlash = 60e-6', 'half_backlash = 0.03', &
                   '&mesh 1: half_backlash = 0.03: must be < 0.003804'//nothing_left)
      call is_told(tests, 'helix_angle = 15.0', 'helix_angle = 15.0, centre_distance = 0.13', '&mesh 1: centre_distance = 0.13: &
                   &contradicts teeth, profile_shift and backlash: the flanks touch without backlash at 0.121645 m, and have &
                   &0.008079 m of it here')
      call is_told(tests, 'helix_angle = 15.0', 'helix_angle = 15.0, centre_distance = 121.6', '&mesh 1: centre_distance = 121.6: &
                   &contradicts teeth, profile_shift and backlash: the flanks touch without backlash at 0.121645 m; the unit &
                   &is the metre: is it in millimetres?')
      call is_told(tests, 'helix_angle = 15.0, face_width = 0.04, backlash = 60e-6', 'helix_angle = 15.0, face_width = 0.04, &
                   &centre_distance = 121.6', '&mesh 1: centre_distance = 121.6: contradicts teeth and profile_shift: the flanks &
                   &touch without backlash at 0.121645 m; the unit is the metre: is it in millimetres?')
      call is_told(tests, 'normal_module = 2.5e-3', 'normal_module = 2.5', '&mesh 1: normal_module = 2.5: must be <= 1 m; the unit &
                   &is the metre (2.5 mm are 2.5e-3)')
      call is_told(tests, 'face_width = 0.04', 'face_width = 0.04, bore = 28, 40', '&mesh 1: bore value 1 = 28.0: must be < &
                   &0.059528 m, the reference diameter of the gear of 23 teeth; the unit is the metre (28 mm are 0.028)')
      ! Possible, but hardly meant.
      ! A centre distance that is rounded, 121.645 mm, is none; beyond the backlash it is an error.
      call is_warned(tests, 'helix_angle = 15.0', 'helix_angle = 15.0, centre_distance = 0.12162', '&mesh 1: centre_distance = &
                     &0.12162: teeth of full thickness touch at 0.121645 m already: the backlash takes teeth that are thinner by &
                     &1.8786e-5 m')
      call is_told(tests, 'helix_angle = 15.0', 'helix_angle = 15.0, centre_distance = 0.1215', '&mesh 1: centre_distance = &
                   &0.1215: contradicts teeth and profile_shift: the flanks touch without backlash at 0.121645 m already; &
                   &profile shifts with a sum of -0.057736 would fit')
      call is_warned(tests, 'backlash = 60e-6', 'backlash = 2e-3', '&mesh 1: backlash = 0.002: more than half a module')
      call is_warned(tests, 'error_cos = 3e-6', 'error_cos = 3.0', '&mesh 1: error_cos = 3.0: more than the backlash')
      call is_warned(tests, 'error_cos = 3e-6', 'error_sin = 0.0, -3e-3', '&mesh 1: error_sin = -0.003: more than the backlash')
      call is_warned(tests, 'diameter = 0.04', 'diameter = 40.0', '&shaft 2: diameter = 40.0: the unit is the metre')
      call is_warned(tests, 'length = 0.15', 'length = 150.0', '&shaft 1: length = 150.0: the unit is the metre')
      call is_warned(tests, 'damping_ratio = 0.01', 'damping_ratio = 1.0', '&shaft 1: damping_ratio = 1.0: from 1 on')
      call is_warned(tests, 'damping_ratio = 0.05', 'damping_ratio = 5.0', '&mesh 1: damping_ratio = 5.0: from 1 on')
      call is_warned(tests, 'density = 7850.0', 'density = 7.85', '&mesh 1: density = 7.85: the unit is kg/m^3')
      call is_warned(tests, 'density = 7800.0', 'density = 7.8', '&body 6: density = 7.8: the unit is kg/m^3')
      call is_warned(tests, 'outer_diameter = 0.5', 'outer_diameter = 500.0', '&body 6: outer_diameter = 500.0: the unit is the')
      call is_warned(tests, 'width = 0.03', 'width = 30.0', '&body 6: width = 30.0: the unit is the metre')
      call is_warned(tests, 'helix_angle = 15.0', 'helix_angle = 0.2618', '&mesh 1: helix_angle = 0.2618: the unit is the degree')
      call is_warned(tests, 'normal_module = 2.5e-3', 'normal_module = 0.25', '&mesh 1: normal_module = 0.25: the unit is')
      ! The teeth as drawn have 23*2.5e-3/cos(15 degrees) of pitch diameter; ISO 6336-1 gives about 20 N/(mm um) of 40 mm.
      call is_warned(tests, 'face_width = 0.04', 'face_width = 0.04, stiffness = 800.0', &
                     '&mesh 1: stiffness = 800.0: by ISO 6336-1')
      call is_warned(tests, 'diameter = 0.03', 'diameter = 0.30', '&shaft 1: diameter = 0.3: thicker than the gear of 23 teeth')
      call is_warned(tests, 'face_width = 0.04, backlash = 60e-6', 'face_width = 0.04', '&mesh 1: has no backlash, although other')
      call is_warned(tests, 'face_width = 0.07', 'face_width = 70.0', '&mesh 2: face_width = 70.0: beside a pitch diameter')
   end subroutine other_units

   !> The errors of the reducer with a part of its text replaced are these lines, without the places in the file.
   subroutine is_told(tests, part, by, lines)
      class(tests_type), intent(inout) :: tests
      character(*), intent(in) :: part, by, lines
      character(:), allocatable :: errors, warnings

      call read_slip(part, by, errors, warnings)
      call tests%is_text(errors, lines, by)
      call tests%is_text(warnings, '', 'no warning: '//by)
   end subroutine is_told

   !> The first warning of the reducer with a part of its text replaced begins so.
   subroutine is_warned(tests, part, by, beginning)
      class(tests_type), intent(inout) :: tests
      character(*), intent(in) :: part, by, beginning
      character(:), allocatable :: errors, warnings

      call read_slip(part, by, errors, warnings)
      call tests%is_true(errors == '' .and. index(warnings, beginning) == 1, by//': '//errors//warnings)
   end subroutine is_warned

   !> Errors and warnings of the reducer with a part of its text replaced.
   subroutine read_slip(part, by, errors, warnings)
      character(*), intent(in) :: part, by
      character(:), allocatable, intent(out) :: errors, warnings
      type(case_type) :: case
      type(error_type), allocatable :: error
      character(:), allocatable :: text
      integer :: i

      text = reducer
      i = index(text, part)
      if (i > 0) text = text(:i - 1)//by//text(i + len(part):)
      call read_case_text(text, '', case, error)
      errors = ''
      warnings = ''
      if (allocated(error)) then
         errors = error%message
      else
         call warnings_text(case%train, warnings)
      end if
   end subroutine read_slip

end module unit_slips
