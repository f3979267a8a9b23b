!> From the drawing to numbers: closed forms, published examples, and what is told of drawings that contradict themselves.
module unit_drawing
   use geartrain, only: branch_type, case_type, dp, error_type, explanation_text, read_case_text, response, &
      response_settings_type, train_type, warnings_text
   use geartrain_base_words, only: lambda, operator(//)
   use geartrain_readings_frequency_text, only: frequency_text, frequency_text_type, in_width
   use geartrain_readings_length_text, only: length_text, length_text_type
   use geartrain_base_kinds, only: pi
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_network_frequency_unit, only: lambda_per
   use geartrain_drawing_gear_pair, only: find_geometry, find_stiffness, gear_pair_type, pair_geometry_type, pair_stiffness_type, &
                                        rectangular_wave
   use geartrain_network_light_loads, only: reduce_light_loads
   use geartrain_train_kinematics, only: find_kinematics, kinematics_type
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: drawing_tests

   character(*), parameter :: n = new_line('a')
   !> The two-stage reducer, a gear and a shaft a line; the pinions may have more.
   character(*), parameter :: bodies = "&train title = 'reducer' /"//n// &
      "&body name = 'motor', inertia = 0.02, torque = 90.0 /"//n// &
      "&body name = 'p1' /"//n//"&body name = 'w1' /"//n//"&body name = 'p2' /"//n//"&body name = 'w2' /"//n// &
      "&body name = 'load', inertia = 1.5, balances = .true. /"//n//"&shaft between = 'motor', 'p1', diameter = 0.03, &
      &length = 0.15, damping_ratio = 0.01 /"//n//"&shaft between = 'w1', 'p2', diameter = 0.04, length = 0.12, damping_ratio = &
      &0.01 /"//n//"&shaft between = 'w2', 'load', diameter = 0.06, length = 0.2, damping_ratio = 0.01 /"//n
   character(*), parameter :: first = "&mesh between = 'p1', 'w1', teeth = 23, 71, normal_module = 2.5e-3, face_width = 0.04, &
      &helix_angle = 15.0, backlash = 60e-6, damping_ratio = 0.05, stiffness_harmonics = 3, error_cos = 3e-6"
   character(*), parameter :: second = " /"//n//"&mesh between = 'p2', 'w2', teeth = 19, 80, normal_module = 4e-3, &
      &face_width = 0.07, helix_angle = 15.0, backlash = 60e-6, damping_ratio = 0.05, stiffness_harmonics = 3, &
      &error_cos = 3e-6 /"//n

contains

   subroutine drawing_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('geometry')) call geometry(tests)
      if (tests%runs('internal')) call internal(tests)
      if (tests%runs('stiffness')) call stiffness(tests)
      if (tests%runs('waves')) call waves(tests)
      if (tests%runs('reducer')) call reducer(tests)
      if (tests%runs('kinematics')) call kinematics(tests)
      if (tests%runs('units')) call units(tests)
      if (tests%runs('words_in_a_unit')) call words_in_a_unit(tests)
      if (tests%runs('teeth_that_meet')) call teeth_that_meet(tests)
      if (tests%runs('given_wins')) call given_wins(tests)
      if (tests%runs('contradictions')) call contradictions(tests)
      if (tests%runs('warnings')) call warnings(tests)
      if (tests%runs('chain')) call chain(tests)
   end subroutine drawing_tests

   !> Contact ratio of equal gears in closed form; diameters, angles and distances of the worked examples of KHK, Gear Technical
   !> Reference, tables 4.3 (profile shifted spur gears) and 4.19 (helical gears).
   subroutine geometry(tests)
      class(tests_type), intent(inout) :: tests
      type(pair_geometry_type) :: g
      real(dp) :: alpha

      call find_geometry(gear_pair_type(teeth=[62, 62], normal_module=2.5e-3_dp), g)
      alpha = 20*pi/180
      call tests%is_close(g%contact_ratio, 62/pi*(tan(acos(31*cos(alpha)/32)) - tan(alpha)), 1e-13_dp, 'contact ratio of 62/62')
      call tests%is_close(g%contact_ratio, 1.7897798668_dp, 1e-10_dp, 'contact ratio of 62/62, as a number')
      call find_geometry(gear_pair_type(teeth=[12, 24], normal_module=3e-3_dp, profile_shift=[0.6_dp, 0.36_dp]), g)
      call tests%is_close(g%working_angle*180/pi, 26.0886_dp, 1e-4_dp, 'working pressure angle, shifted spur gears')
      call tests%is_close(g%centre_distance, 56.4999e-3_dp, 1e-7_dp, 'centre distance')
      call tests%is_close(g%tip_diameter(1), 44.840e-3_dp, 1e-6_dp, 'tip diameter of the pinion')
      call tests%is_close(g%tip_diameter(2), 79.400e-3_dp, 1e-6_dp, 'tip diameter of the wheel')
      call find_geometry(gear_pair_type(teeth=[12, 60], normal_module=3e-3_dp, helix_angle=30*pi/180, &
                                        profile_shift=[0.09809_dp, 0.0_dp]), g)
      call tests%is_close(g%transverse_angle*180/pi, 22.79588_dp, 1e-5_dp, 'transverse pressure angle, helical gears')
      call tests%is_close(g%working_angle*180/pi, 23.1126_dp, 1e-4_dp, 'working transverse pressure angle')
      call tests%is_close(g%centre_distance, 125.0e-3_dp, 1e-6_dp, 'centre distance')
      call tests%is_close(2*g%base_radius(1), 38.322e-3_dp, 1e-6_dp, 'base diameter of the pinion')
      call tests%is_close(2*g%base_radius(2), 191.611e-3_dp, 1e-6_dp, 'base diameter of the wheel')
      call tests%is_close(g%tip_diameter(1), 48.153e-3_dp, 1e-6_dp, 'tip diameter of the pinion')
      call tests%is_close(g%tip_diameter(2), 213.842e-3_dp, 1e-6_dp, 'tip diameter of the wheel')
      ! Without shift a distance larger by d gives the backlash 2 (a + d) (inv alpha_w - inv alpha), for small d about 2 d tan
      ! alpha.
      call find_geometry(gear_pair_type(teeth=[30, 40], normal_module=2e-3_dp, centre_distance=70.001e-3_dp), g)
      call tests%is_close(g%distance_backlash, 2e-6_dp*tan(alpha), 1e-10_dp, 'backlash by the centre distance')
      call find_geometry(gear_pair_type(teeth=[30, 40], normal_module=2e-3_dp, backlash=1e-4_dp), g)
      call tests%is_close(g%half_backlash, 0.5e-4_dp*cos(alpha), 1e-16_dp, 'half of the backlash on the line of action')
      call find_geometry(gear_pair_type(teeth=[14, 40], normal_module=2e-3_dp), g)
      call tests%is_close(g%undercut(1), (17.0973_dp - 14)/17.0973_dp, 1e-5_dp, 'least shift without undercut')
      call tests%is_true(g%undercut(2) < 0, '40 teeth are not undercut')
   end subroutine geometry

   !> The internal gears of the same source, table 4.5 (its shift of the internal gear is positive outwards); the contact ratio by
   !> the path from the tip circle of the pinion to that of the ring; a ring that drives.
   subroutine internal(tests)
      class(tests_type), intent(inout) :: tests
      type(pair_geometry_type) :: g, turned
      real(dp) :: alpha, path

      call find_geometry(gear_pair_type(teeth=[16, 24], internal=.true., normal_module=3e-3_dp, &
                                        profile_shift=[0.0_dp, -0.5_dp]), g)
      call tests%is_close(g%working_angle*180/pi, 31.0937_dp, 1e-4_dp, 'working pressure angle of an internal pair')
      call tests%is_close(g%centre_distance, 13.1683e-3_dp, 1e-7_dp, 'centre distance')
      call find_geometry(gear_pair_type(teeth=[20, 80], internal=.true., normal_module=1e-3_dp), g)
      alpha = 20*pi/180
      path = sqrt(11.0_dp**2 - (10*cos(alpha))**2) - sqrt(39.0_dp**2 - (40*cos(alpha))**2) + 30*sin(alpha)
      call tests%is_close(g%contact_ratio, path/(pi*cos(alpha)), 1e-12_dp, 'contact ratio of an internal pair')
      call find_geometry(gear_pair_type(teeth=[80, 20], internal=.true., normal_module=1e-3_dp), turned)
      call tests%is_close(turned%contact_ratio, g%contact_ratio, 1e-15_dp, 'the ring drives')
      call tests%is_close(turned%base_radius(1), g%base_radius(2), 1e-18_dp, 'base radius of the ring')
   end subroutine internal

   !> ISO 6336-1 by hand for 62/62 spur gears; the pinion is gear 1 whichever drives; other materials; light loads.
   subroutine stiffness(tests)
      class(tests_type), intent(inout) :: tests
      type(gear_pair_type) :: pair
      type(pair_geometry_type) :: g
      type(pair_stiffness_type) :: full, other
      real(dp) :: q

      pair = gear_pair_type(teeth=[62, 62], normal_module=2.5e-3_dp, face_width=0.02_dp)
      call find_geometry(pair, g)
      call find_stiffness(pair, g, 0.0_dp, full)
      q = 0.04723_dp + (0.15551_dp + 0.25791_dp)/62
      call tests%is_close(full%theoretical, 1e9_dp/q, 1.0_dp, "c'_th")
      call tests%is_close(full%single, 0.8_dp*0.975_dp*1e9_dp/q, 1.0_dp, "c' with C_M = 0.8 and C_B = 0.975")
      call tests%is_close(full%mesh, full%single*(0.75_dp*1.7897798668_dp + 0.25_dp), 10.0_dp, 'c_gamma_alpha')
      call find_stiffness(pair, g, 0.5e5_dp, other)
      call tests%is_close(other%mesh/full%mesh, 0.5_dp**0.25_dp, 1e-14_dp, 'light load')
      pair%elastic_modulus = [2.06e11_dp, 1.03e11_dp]
      call find_stiffness(pair, g, 0.0_dp, other)
      call tests%is_close(other%mesh/full%mesh, 2.0_dp/3, 1e-14_dp, 'another material')
      pair = gear_pair_type(teeth=[23, 71], normal_module=2.5e-3_dp, profile_shift=[0.3_dp, -0.1_dp])
      call find_geometry(pair, g)
      call find_stiffness(pair, g, 0.0_dp, full)
      q = 0.04723_dp + 0.15551_dp/23 + 0.25791_dp/71 - 0.00635_dp*0.3_dp - 0.11654_dp*0.3_dp/23 + 0.00193_dp*0.1_dp &
          + 0.24188_dp*0.1_dp/71 + 0.00529_dp*0.09_dp + 0.00182_dp*0.01_dp
      call tests%is_close(full%theoretical*q, 1e9_dp, 1e-3_dp, "c'_th with profile shift")
      pair = gear_pair_type(teeth=[71, 23], normal_module=2.5e-3_dp, profile_shift=[-0.1_dp, 0.3_dp])
      call find_geometry(pair, g)
      call find_stiffness(pair, g, 0.0_dp, other)
      call tests%is_close(other%single/full%single, 1.0_dp, 1e-14_dp, 'the wheel drives')
   end subroutine stiffness

   !> Amplitudes of the rectangular wave, those of the paper; averaged over the face by quadrature.
   subroutine waves(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: points = 20000
      real(dp) :: average, wave(-points:points), theta
      integer :: h, i, k

      call tests%is_close(rectangular_wave(1, 1.5_dp, 0.0_dp), 0.42441_dp, 5e-6_dp, 'contact ratio 1.5')
      call tests%is_close(rectangular_wave(1, 1.7_dp, 0.0_dp), 0.30296_dp, 5e-6_dp, 'contact ratio 1.7')
      call tests%is_close(rectangular_wave(1, 1.8_dp, 0.0_dp), 0.20789_dp, 5e-6_dp, 'contact ratio 1.8')
      call tests%is_close(rectangular_wave(1, 1.9_dp, 0.0_dp), 0.10354_dp, 5e-6_dp, 'contact ratio 1.9')
      ! kappa at an instant theta and a place y of the face: 2 pairs for a share 0.6 of the cycle around theta = 2 pi eps_beta y.
      do h = 1, 3
         average = 0
         do k = 1, 400
            do i = 0, 399
               theta = 2*pi*((i + 0.5_dp)/400 - 1.3_dp*((k - 0.5_dp)/400 - 0.5_dp))
               theta = theta - 2*pi*anint(theta/(2*pi))
               average = average + merge(2, 1, abs(theta) < 0.6_dp*pi)*cos(h*2*pi*(i + 0.5_dp)/400)*2/1.6_dp/400**2
            end do
         end do
         call tests%is_close(average, rectangular_wave(h, 1.6_dp, 1.3_dp), 2e-3_dp, 'averaged over the face')
      end do
      wave = 0
   end subroutine waves

   !> The reducer: orders, stiffnesses, inertias, backlash, light load of the first stage.
   subroutine reducer(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train, plain
      real(dp), allocatable :: factor(:)
      character(:), allocatable :: text
      real(dp) :: beta, d

      call read(first//second, train, text)
      call tests%is_text(text, '', 'the reducer is in order')
      if (text /= '') return
      call plain_train(train, plain)
      beta = 15*pi/180
      call tests%is_true(all(plain%meshes%order == [71, 19]), 'orders 71 and 19')
      call tests%is_close(plain%characteristic_length, 1e-6_dp, 1e-20_dp, 'unit of length')
      call tests%is_close(plain%speed_ratio, 71.0_dp/23, 1e-14_dp, 'turns of the motor per fundamental')
      call tests%is_close(plain%characteristic_frequency, 2*pi/60*23/71, 1e-15_dp, 'Lambda is the speed in rpm')
      call tests%is_close(plain%shafts(1)%stiffness, pi*8e10_dp*0.03_dp**4/(32*0.15_dp), 1e-7_dp, 'stiffness of a shaft')
      d = 71*2.5e-3_dp/cos(beta)
      call tests%is_close(plain%bodies(3)%inertia, pi*7850*0.04_dp*d**4/32, 1e-15_dp, 'inertia of a wheel')
      d = tan(20*pi/180)/cos(beta)
      call tests%is_close(plain%meshes(1)%half_backlash, 30e-6_dp/sqrt(1 + d**2), 1e-18_dp, 'half backlash')
      call reduce_light_loads(plain, factor)
      d = 90/(23*2.5e-3_dp/cos(beta)/2)/0.04_dp
      call tests%is_close(factor(1), (d/1e5_dp)**0.25_dp, 1e-12_dp, 'the first stage is lightly loaded')
      call tests%is_close(factor(2), 1.0_dp, 1e-15_dp, 'the second is not')
      call explanation_text(train, text)
      call tests%is_true(index(text, 'one turn of w1') > 0, 'the fundamental is told')
      call tests%is_true(index(text, 'ISO 6336-1:2006') > 0, 'the source of the stiffness is told')
   end subroutine reducer

   !> Orders by hand: three stages; a torque of the motor's own revolution; an idler.
   subroutine kinematics(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train, plain
      type(kinematics_type) :: found
      character(:), allocatable :: text

      call read(first//second//"&body name = 'p3' /"//n//"&body name = 'w3' /"//n// &
      "&shaft between = 'w2', 'p3', rigid = .true. /"// &
                n//"&mesh between = 'p3', 'w3', teeth = 17, 83, normal_module = 5e-3, face_width = 0.1 /"//n, train, text)
      call tests%is_text(text, '', 'three stages')
      if (text == '') then
         call find_kinematics(train, found)
         call tests%is_true(found%known .and. all(found%order == [5680, 1520, 323]), 'orders of three stages')
      end if
      call read(first//second//"&body name = 'x' /"//n, train, text)
      call tests%is_true(index(text, "'x' is joined with 'motor' by no shaft") > 0, 'a body on nothing')
      call read(replaced(first, 'error_cos = 3e-6', 'error_cos = 3e-6, order = 5')//second, train, text)
      call tests%is_true(index(text, 'order = 5: contradicts the teeth, by which it is 71') > 0, 'an order against the teeth')
      call read("&body name = 'gear', revolution_torque_cos = 0.0, 5.0 /"//n// &
      "&shaft between = 'motor', 'gear', stiffness = 1e4 /"// &
                n//first//second, train, text)
      call tests%is_text(text, 'x.nml:11:1: error: &body 7: lacks inertia (> 0 kg m^2) or outer_diameter and width, or gears with &
                         &teeth, normal_module and face_width', 'a body without gears or inertia')
      call read("&body name = 'gear', inertia = 1e-3, revolution_torque_cos = 0.0, 5.0 /"//n//"&shaft between = 'motor', 'gear', &
                &stiffness = 1e4 /"//n//first//second, train, text)
      call tests%is_text(text, '', 'a torque of twice a revolution')
      if (text /= '') return
      call find_kinematics(train, found)
      call plain_train(train, plain)
      call tests%is_true(all(found%order == [1633, 437]) .and. found%revolution_order(7) == 71, 'orders of 1/71 revolution')
      call tests%is_close(plain%speed_ratio, 1/71.0_dp*71**2, 1e-12_dp, 'a motor that turns 71 times')
   end subroutine kinematics

   !> rpm, Hz and Lambda are one motion; without teeth there is no speed.
   subroutine units(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: rpm, hertz
      type(error_type), allocatable :: error
      type(response_settings_type) :: settings
      character(:), allocatable :: text

      call read(first//second, train, text)
      train%characteristic_frequency = 1000
      train%characteristic_length = 1e-5_dp
      call tests%is_close(lambda_per(train, 'rpm'), 2*pi/60*23/71/1000, 1e-15_dp, 'Lambda per rpm')
      call tests%is_close(lambda_per(train, 'Hz'), 2*pi/1000, 1e-15_dp, 'Lambda per Hz')
      settings = response_settings_type(start=500.0_dp, stop=505.0_dp, unit='rpm', harmonics=80, stability=.false.)
      call response(train, settings, rpm, error)
      call tests%is_true(.not. allocated(error), 'a response in rpm')
      settings%start = 500*23/(60*71.0_dp)
      settings%stop = 505*23/(60*71.0_dp)
      settings%unit = 'Hz'
      call response(train, settings, hertz, error)
      if (rpm%points /= hertz%points) then
         call tests%is_true(.false., 'as many points in Hz')
      else
         call tests%is_close(maxval(abs(rpm%frequency_ratio - hertz%frequency_ratio)), 0.0_dp, 1e-14_dp, 'likewise in Hz')
         call tests%is_close(rpm%frequency_ratio(1), 500*lambda_per(train, 'rpm'), 1e-14_dp, 'it begins at 500 rpm')
      end if
      train%meshes(1)%driving_radius = 0.0278_dp
      train%meshes(1)%driven_radius = 0.0278_dp*71/23
      deallocate (train%meshes(1)%teeth)
      call tests%is_close(lambda_per(train, 'rpm'), 0.0_dp, 1e-300_dp, 'no speed without teeth')
   end subroutine units

   !> What a report says of frequencies, in the unit asked for; rpm where Lambda is the speed in rpm.
   subroutine words_in_a_unit(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(frequency_text_type) :: told
      type(length_text_type) :: lengths
      character(:), allocatable :: text

      call read(first//second, train, text)
      told = frequency_text(train, 'Lambda', 1500.0_dp)
      call tests%is_text(trim(told%unit), 'rpm', 'Lambda is the speed')
      call tests%is_text(trim(told%number(1500.126_dp)), '1500', 'four digits')
      told = frequency_text(train, 'Lambda', 1500.0_dp, 1450.0_dp)
      call tests%is_text(trim(told%number(1500.126_dp)), '1500.1', 'five of a narrow range')
      call told%of_words('from '//lambda(1450.5_dp)//': closed; '//('from '//lambda(0.5_dp, 1600.0_dp)//'; left the range'), text)
      call tests%is_text(text, 'from 1450.5 rpm: closed; from 0.5 to 1600 rpm; left the range', 'numbers in words')
      call told%rounded(1450.53_dp, text)
      call tests%is_text(text, '1451 rpm', 'four digits in words')
      told = frequency_text(train, 'Hz', 0.0_dp)
      call told%of_words('reached '//lambda(1500.0_dp), text)
      call tests%is_text(text, 'reached 8.098592 Hz', '1500/60 times 23/71')
      call tests%is_text(in_width(told%number(1500.0_dp), 9), '   8.0986', 'a column')
      call tests%is_text(in_width('123456789', 9), ' 123456789', 'a column that is too narrow')
      lengths = length_text(train)
      call tests%is_text(trim(lengths%name), 'true rms [um]', 'lengths are in um')
      call tests%is_text(trim(lengths%rms(sqrt(2.0_dp))), '1', 'the paper has sqrt(2) times the root mean square')
      train%characteristic_frequency = 1000
      train%characteristic_length = 1e-5_dp
      told = frequency_text(train, 'Lambda', 0.0_dp)
      call told%of_words('reached '//lambda(1.5_dp), text)
      call tests%is_text(text, 'reached Lambda = 1.5', 'a Lambda of its own')
      call told%with_unit('1 to 2', text)
      call tests%is_text(text, 'Lambda 1 to 2', 'likewise a range')
      lengths = length_text(train)
      call tests%is_text(trim(lengths%name), 'rms of the paper', 'a length of its own')
   end subroutine words_in_a_unit

   !> Teeth that hunt and teeth that do not, what repeats, and the orders that a mesh excites.
   subroutine teeth_that_meet(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      character(:), allocatable :: text

      call read(first//second, train, text)
      call explanation_text(train, text)
      call tests%is_true(index(text, '23:71, hunting: no common divisor, every tooth meets every tooth of the mate; two teeth meet &
         &again after 71 turns of the driving gear') > 0, 'stage 1 hunts')
      call tests%is_true(index(text, 'excited_orders            71, 142, 213   (') > 0, 'three harmonics of stage 1')
      call tests%is_true(index(text, 'excited_orders            19, 38, 57   (') > 0, 'three of stage 2')
      call tests%is_true(index(text, 'fundamental_frequency     5.399061 Hz   (at 1000 rpm of motor') > 0, '1000/60 times 23/71')
      call read(replaced(first, 'teeth = 23, 71', 'teeth = 24, 72')//second, train, text)
      call explanation_text(train, text)
      call tests%is_true(index(text, '24:72, not hunting: common divisor 24, a tooth meets only every 24th tooth of the mate; two &
         &teeth meet again after 3 turns of the driving gear') > 0, 'three teeth of the wheel, each in its turn')
   end subroutine teeth_that_meet

   !> What is given directly wins.
   subroutine given_wins(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train, plain
      character(:), allocatable :: text

      call read(first//", stiffness = 5e8, driving_radius = 0.03, driven_radius = 0.0926086956521739, stiffness_cos = 0.1"// &
      second, &
                train, text)
      call tests%is_text(text, '', 'numbers beside the drawing')
      if (text /= '') return
      call plain_train(train, plain)
      call tests%is_close(plain%meshes(1)%stiffness, 5e8_dp, 1e-3_dp, 'a given stiffness')
      call tests%is_close(plain%meshes(1)%light_force, 0.0_dp, 1e-300_dp, 'is that of any load')
      call tests%is_close(plain%meshes(1)%driving_radius, 0.03_dp, 1e-16_dp, 'a given radius')
      call tests%is_true(size(plain%meshes(1)%stiffness_cos) == 1, 'given harmonics')
   end subroutine given_wins

   !> Every contradiction is told with its numbers.
   subroutine contradictions(tests)
      class(tests_type), intent(inout) :: tests

      call told(', centre_distance = 0.12', 'centre_distance = 0.12: contradicts teeth and profile_shift: the flanks touch without &
                &backlash at 0.121645 m already')
      call told(', centre_distance = 0.11', 'centre_distance = 0.11: must be larger than that of the base circles, 0.113832 m')
      call told(', centre_distance = 0.1225', 'centre_distance = 0.1225: contradicts teeth, profile_shift and backlash: the flanks &
                &touch without backlash at 0.121645 m, and have 0.00066461 m of it here')
      call told(', centre_distance = 121.6', 'centre_distance = 121.6: contradicts teeth, profile_shift and backlash: the flanks &
                &touch without backlash at 0.121645 m; the unit is the metre: is it in millimetres?')
      call told(', tip_diameter = 0.05, 0.18', 'tip_diameter = 0.05: must be > 0.055705 m, the base circle of the gear of 23 teeth')
      call told(', tip_diameter = 0.08, 0.18', 'tip_diameter = 0.08: must be smaller: the flanks of the gear of 23 teeth meet &
                &below it')
      call told(', tip_diameter = 0.0605, 0.1845', 'teeth = 23, 71: must give a transverse contact ratio > 1: it is')
      call told(', half_backlash = 1e-5', 'backlash = 6.0e-5: contradicts half_backlash, along the line of action: leave out one &
                &of the two')
      call told(', driving_radius = 0.03', 'driving_radius = 0.03: contradicts teeth and normal_module, by which it is 0.027852 m: &
                &leave it out')
      call told(', bore = 0.01', 'bore = 1 values: must be 2 values')

   contains

      subroutine told(more, message)
         character(*), intent(in) :: more, message
         type(train_type) :: train
         character(:), allocatable :: text

         call read(first//more//second, train, text)
         call tests%is_true(index(text, message) > 0, message//'; got '//text)
      end subroutine told

   end subroutine contradictions

   !> Outside the range of a formula there is a warning, and a number all the same.
   subroutine warnings(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      character(:), allocatable :: text

      call read(first//second, train, text)
      call warnings_text(train, text)
      call tests%is_text(text, '', 'no warning about the reducer')
      call read(replaced(first, 'helix_angle = 15.0', 'helix_angle = 35.0')//second, train, text)
      call warnings_text(train, text)
      call tests%is_true(index(text, '&mesh 1: the mesh stiffness by ISO 6336-1 is for helix angles up to 30 degrees') == 1, &
                         'helix angle: '//text)
      call read(replaced(first, 'teeth = 23, 71', 'teeth = 12, 71')//second, train, text)
      call warnings_text(train, text)
      call tests%is_true(index(text, '&mesh 1: the gear of 12 teeth is undercut') == 1, 'undercut: '//text)
      call read(first//second, train, text)
      train%bodies(1)%torque = 0
      call warnings_text(train, text)
      call tests%is_true(index(text, '&train: no mesh carries a load, as no body has a mean torque') == 1 .and. &
                         index(text, 'give the torque') > 0 .and. index(text, '&mesh') == 0, 'no load, and what to do: '//text)
      train%meshes(1)%stiffness = 1e8_dp
      train%meshes(2)%stiffness = 1e8_dp
      call warnings_text(train, text)
      call tests%is_text(text, '', 'a stiffness that is given')
   end subroutine warnings

   !> A chain from its drawing: inertias of the gears, rpm of the driving end.
   subroutine chain(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type) :: case
      type(train_type) :: plain
      type(error_type), allocatable :: error

      call read_case_text('&train input_torque = 100.0, prime_mover_inertia = 1e-2, load_inertia = 1e-1 /'//n// &
                          '&shaft diameter = 0.02, 0.03, length = 0.1, 0.2, bore = 0.01 /'//n// &
                          '&mesh teeth = 20, 40, normal_module = 2e-3, face_width = 0.02, bore = 0.02, 0.03 /'//n// &
                          '&shaft diameter = 0.03, length = 0.2 /'//n//'&modes /'//n, 'x.nml', case, error)
      call tests%is_true(.not. allocated(error), 'a chain from its drawing')
      if (allocated(error)) return
      call plain_train(case%train, plain)
      call tests%is_close(plain%meshes(1)%driving_inertia, pi*7850*0.02_dp*(0.04_dp**4 - 0.02_dp**4)/32, 1e-18_dp, &
                          'inertia of a gear with a bore')
      call tests%is_close(1/plain%shafts(1)%stiffness, 32/(pi*8e10_dp)*(0.1_dp/(0.02_dp**4 - 0.01_dp**4) &
                                                                       + 0.2_dp/(0.03_dp**4 - 0.01_dp**4)), 1e-18_dp, &
                          'compliance of two sections')
      call tests%is_true(plain%meshes(1)%order == 1, 'one mesh is the fundamental')
      call tests%is_close(plain%speed_ratio, 1/20.0_dp, 1e-16_dp, 'a twentieth of a turn a tooth')
   end subroutine chain

   !> Reads the reducer with these meshes; the message of what is wrong, '' where nothing is.
   subroutine read(meshes, train, message)
      character(*), intent(in) :: meshes
      type(train_type), intent(out) :: train
      character(:), allocatable, intent(out) :: message
      type(case_type) :: case
      type(error_type), allocatable :: error

      call read_case_text(bodies//meshes//'&modes /'//n, 'x.nml', case, error)
      message = ''
      if (allocated(error)) message = error%message
      if (.not. allocated(error)) train = case%train
   end subroutine read

   !> A text with one part replaced.
   function replaced(text, part, by) result(new)
      character(*), intent(in) :: text, part, by
      character(len(text) - len(part) + len(by)) :: new
      integer :: i

      i = index(text, part)
      new = text(:i - 1)//by//text(i + len(part):)
   end function replaced

end module unit_drawing
