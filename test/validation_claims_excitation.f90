!> The claims of the paper's section 4.3 (figures 6 to 11); docs/claims.md has the table.
module validation_claims_excitation
   use fixtures, only: paper_train
   use geartrain, only: branch_type, dp, train_type
   use geartrain_base_kinds, only: pi
   use geartrain_readings_summary, only: band_type, bands_without_stability, peak_type
   use readings, only: folds_between, has_fold, is_band, largest_between, peak_between, smallest_between, stable_somewhere, &
                       traced
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: claims_excitation_tests

contains

   subroutine claims_excitation_tests(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: reference

      if (tests%runs('figure_3')) then
         reference = traced(tests, paper_train(), 0.2_dp, 2.6_dp, 6, '150 N m, kappa 0.3, zeta 0.05')
         call torque(tests, reference)
         call stiffness(tests, reference)
         call damping(tests, reference)
      end if
      if (tests%runs('five_harmonics')) call five_harmonics(tests)
      if (tests%runs('orders')) call orders(tests)
   end subroutine claims_excitation_tests

   !> Claims 34 to 41, figure 6. Without back collision p - b is proportional to the torque, so everything but the amplitude
   !> is the same at each torque.
   subroutine torque(tests, high)
      class(tests_type), intent(inout) :: tests
      type(branch_type), intent(in) :: high
      type(branch_type) :: middle, low
      type(train_type) :: train
      real(dp), parameter :: same(5) = [0.4621_dp, 0.7923_dp, 1.6645_dp, 0.4586_dp, 1.5473_dp]
      real(dp) :: ratio
      integer :: i

      train = paper_train()
      train%input_torque = 100
      middle = traced(tests, train, 0.2_dp, 2.6_dp, 6, '100 N m')
      train%input_torque = 50
      low = traced(tests, train, 0.2_dp, 2.6_dp, 6, '50 N m')
      call tests%is_true(smallest_between(low, 2, 0.7_dp, 1.1_dp) < 1, 'claim 35: separation at 50 N m')
      call tests%is_true(smallest_between(middle, 2, 0.7_dp, 1.1_dp) < 1, 'claim 35: separation at 100 N m')
      call tests%is_true(smallest_between(high, 2, 0.7_dp, 1.1_dp) < 1, 'claim 35: separation at 150 N m')
      ratio = largest_between(high, 1, 1.5_dp, 2.2_dp)/largest_between(low, 1, 1.5_dp, 2.2_dp)
      call tests%is_close(ratio, 3.0_dp, 1e-2_dp, 'claim 36: three times the torque, three times the resonance b')
      call tests%is_true(largest_between(high, 2, 0.5_dp, 1.2_dp) > largest_between(middle, 2, 0.5_dp, 1.2_dp), &
                         'claim 36: resonance a grows from 100 to 150 N m')
      call tests%is_true(largest_between(middle, 2, 0.5_dp, 1.2_dp) > largest_between(low, 2, 0.5_dp, 1.2_dp), &
                         'claim 36: resonance a grows from 50 to 100 N m')
      call tests%is_true(smallest_between(low, 2, 0.2_dp, 2.6_dp) > -1, 'claim 37: no back collision at 50 N m')
      call tests%is_true(folds_between(low, 0.5_dp, 0.78_dp) == 1, 'claim 37: softening only, at 50 N m')
      call tests%is_true(smallest_between(middle, 2, 0.5_dp, 0.6_dp) < -1, 'claim 38: back collision at 100 N m')
      call tests%is_true(folds_between(middle, 0.5_dp, 0.56_dp) == 3, 'claim 38: hardening at 100 N m, 0.517 to 0.528 only')
      call tests%is_true(smallest_between(high, 2, 0.5_dp, 0.78_dp) < -2, 'claim 38: back collision at 150 N m')
      call tests%is_true(has_fold(high, 0.732_dp, 2e-3_dp), 'claim 38: hardening at 150 N m up to 0.732')
      call tests%is_close(largest_between(high, 2, 0.45_dp, 0.48_dp)/largest_between(low, 2, 0.45_dp, 0.48_dp), 3.0_dp, &
                          1e-3_dp, 'claim 39: super-harmonic w_a/2 in proportion to the torque')
      ratio = height(high, 1, 0.88_dp, 0.95_dp)/height(low, 1, 0.88_dp, 0.95_dp)
      call tests%is_close(ratio, 3.0_dp, 1e-3_dp, 'claim 39: super-harmonic w_b/2 in proportion to the torque')
      call tests%is_true(is_band(high, 1.7492_dp, 2.0439_dp, 1e-3_dp) .and. is_band(middle, 1.7492_dp, 2.0439_dp, 1e-3_dp) &
                         .and. is_band(low, 1.7492_dp, 2.0439_dp, 1e-3_dp), 'claim 40: the unstable range is the same')
      do i = 1, 5
         call tests%is_true(has_fold(high, same(i), 2e-4_dp) .and. has_fold(middle, same(i), 2e-4_dp) &
                            .and. has_fold(low, same(i), 2e-4_dp), 'claim 41: the jump frequencies are the same')
      end do
   end subroutine torque

   !> Claims 42 to 51, figure 7.
   subroutine stiffness(tests, kappa3)
      class(tests_type), intent(inout) :: tests
      type(branch_type), intent(in) :: kappa3
      type(branch_type) :: kappa1, kappa2, kappa4
      type(band_type), allocatable :: bands(:)
      real(dp) :: a(4), b(4), half_a(4), half_b(4)

      kappa1 = traced(tests, paper_train(0.1_dp), 0.2_dp, 4.5_dp, 6, 'kappa 0.1')
      kappa2 = traced(tests, paper_train(0.2_dp), 0.2_dp, 2.6_dp, 6, 'kappa 0.2')
      kappa4 = traced(tests, paper_train(0.42_dp), 0.2_dp, 2.6_dp, 6, 'kappa 0.42')
      a = largest_of(2, 0.5_dp, 1.2_dp)
      b = largest_of(1, 1.2_dp, 2.2_dp)
      half_a = largest_of(2, 0.39_dp, 0.48_dp)
      call tests%is_true(all(a(2:) > a(:3)) .and. all(b(2:) > b(:3)), 'claim 42: larger kappa, larger resonances')
      call tests%is_true(a(4)/a(1) > 10, 'claim 43: from 0.1 to 0.42 resonance a grows more than tenfold')
      call tests%is_true(folds_between(kappa1, 0.7_dp, 1.0_dp) == 2, 'claim 44: minor softening at resonance a, kappa 0.1')
      call tests%is_close(height(kappa1, 1, 0.75_dp, 1.0_dp), 0.1975_dp, 2e-3_dp, 'claim 44: its height in mesh 1')
      call tests%is_true(folds_between(kappa1, 1.3_dp, 2.6_dp) == 0, 'claim 45: resonance b without fold at kappa 0.1')
      call tests%is_true(smallest_between(kappa1, 1, 1.3_dp, 2.6_dp) > 1, 'claim 45: and without separation')
      call tests%is_true(folds_between(kappa2, 0.6_dp, 0.9_dp) == 2, 'claim 46: resonance a folds at kappa 0.2')
      call tests%is_true(folds_between(kappa2, 1.7_dp, 1.8_dp) == 2, 'claim 46: resonance b folds at kappa 0.2')
      call tests%is_true(smallest_between(kappa2, 2, 0.6_dp, 1.0_dp) < 1, 'claim 46: mesh 2 separates')
      call tests%is_true(smallest_between(kappa2, 1, 1.7_dp, 1.9_dp) < 1, 'claim 46: mesh 1 separates')
      call tests%is_true(smallest_between(kappa2, 2, 0.2_dp, 2.6_dp) > -1, 'claim 47: no back collision at 0.2')
      call tests%is_true(smallest_between(kappa3, 2, 0.5_dp, 0.78_dp) < -1, 'claim 47: back collision at 0.3')
      call tests%is_true(smallest_between(kappa4, 2, 0.5_dp, 0.9_dp) < -1, 'claim 47: back collision at 0.42')
      call tests%is_true(all(half_a(2:) > 1.7_dp*half_a(:3)), 'claim 48: super-harmonic w_a/2')
      half_b = [height(kappa1, 1, 0.89_dp, 1.0_dp), height(kappa2, 1, 0.87_dp, 1.0_dp), height(kappa3, 1, 0.85_dp, 1.0_dp), &
                height(kappa4, 1, 0.7_dp, 0.775_dp)]
      call tests%is_true(half_b(1) <= 0, 'claim 48: at 0.1 there is no peak at w_b/2 yet')
      call tests%is_close(half_b(2), 0.2578_dp, 3e-3_dp, 'claim 48: at 0.2')
      call tests%is_close(half_b(3), 0.4189_dp, 3e-3_dp, 'claim 48: at 0.3')
      call tests%is_true(is_band(kappa2, 1.817_dp, 1.993_dp, 2e-3_dp), 'claim 49: the band at 0.2')
      call tests%is_true(is_band(kappa3, 1.749_dp, 2.044_dp, 2e-3_dp), 'claim 49: the wider band at 0.3')
      bands = bands_without_stability(kappa1)
      call tests%is_true(size(bands) == 0, 'claim 50: a stable motion everywhere up to 4.5 at kappa 0.1')
      call tests%is_true(all(kappa1%stable .or. kappa1%frequency_ratio < 0.92_dp), 'claim 50: unstable only between the folds')
      call tests%is_true(is_band(kappa4, 1.6736_dp, 2.1001_dp, 2e-3_dp), 'claim 51: 1.674 to 2.100, not 1.65 to 2.15')

   contains

      function largest_of(mesh, from, to) result(rms)
         integer, intent(in) :: mesh
         real(dp), intent(in) :: from, to
         real(dp) :: rms(4)

         rms = [largest_between(kappa1, mesh, from, to), largest_between(kappa2, mesh, from, to), &
                largest_between(kappa3, mesh, from, to), largest_between(kappa4, mesh, from, to)]
      end function largest_of

   end subroutine stiffness

   !> Claims 52 to 55, figure 8, with the printed fifth harmonic and with that of the rectangular wave.
   subroutine five_harmonics(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: whole, printed, rectangular, linear
      type(train_type) :: train
      real(dp), parameter :: second_pair(4) = [0.5_dp, 0.7_dp, 0.8_dp, 0.9_dp], kappa(4) = [0.42_dp, 0.3_dp, 0.2_dp, 0.1_dp]

      train = paper_train()
      train%meshes(1)%stiffness_cos = [0.42_dp, 0.0_dp, -0.141_dp, 0.0_dp, -0.085_dp]
      train%meshes(2)%stiffness_cos = train%meshes(1)%stiffness_cos
      call tests%is_close(maxval(abs(2/pi*sin(pi*second_pair)/(1 + second_pair) - kappa)), 0.0_dp, 0.009_dp, &
                          'claim 52: one or two pairs in contact, contact ratios 1.5 to 1.9')
      whole = traced(tests, train, 0.2_dp, 2.6_dp, 6, 'figure 8 as printed')
      call tests%is_true(largest_between(whole, 2, 0.8_dp, 0.95_dp) > 12, 'claim 53: resonance a is unbounded')
      call tests%is_close(position(whole, 1, 1.2_dp, 2.2_dp), 1.2925_dp, 3e-3_dp, 'claim 53: resonance b softens to 1.29')
      call tests%is_close(position(whole, 2, 0.39_dp, 0.50_dp), 0.4254_dp, 3e-3_dp, 'claim 53: w_a/2 softens to 0.425')
      call tests%is_close(position(whole, 2, 0.820_dp, 0.825_dp), 0.8228_dp, 2e-3_dp, 'claim 53: w_b/2 softens to 0.823')
      printed = traced(tests, train, 0.7_dp, 0.17_dp, 12, 'figure 8 as printed, low frequencies')
      train%meshes(1)%stiffness_cos(5) = 0.084_dp
      train%meshes(2)%stiffness_cos(5) = 0.084_dp
      rectangular = traced(tests, train, 0.7_dp, 0.17_dp, 12, 'figure 8 rectangular, low frequencies')
      ! Random starts at 0.305 and at 0.29 all settle on period 2; R = 36 has both limits within 1.2e-3.
      call tests%is_true(is_band(printed, 0.2937_dp, 0.3189_dp, 2e-3_dp), 'figure 8 as printed: no stable motion next to w_a/3')
      call tests%is_true(is_band(rectangular, 0.2819_dp, 0.2977_dp, 2e-3_dp), 'figure 8 rectangular: nor there')
      train%meshes%half_backlash = 0
      linear = traced(tests, train, 0.7_dp, 0.17_dp, 12, 'figure 8 without backlash')
      call tests%is_close(position(linear, 2, 0.3_dp, 0.33_dp), 0.319_dp, 8e-3_dp, 'claim 54: w_a/3 without backlash')
      call tests%is_close(position(printed, 2, 0.22_dp, 0.33_dp), 0.230_dp, 4e-3_dp, 'claim 54: w_a/3 softens to 0.230')
      call tests%is_close(height(printed, 2, 0.22_dp, 0.33_dp), 1.36_dp, 2e-2_dp, 'claim 54: its height')
      call tests%is_close(position(printed, 1, 0.55_dp, 0.65_dp), 0.609_dp, 4e-3_dp, 'claim 54: w_b/3 as printed')
      call tests%is_close(position(rectangular, 1, 0.55_dp, 0.65_dp), 0.598_dp, 4e-3_dp, 'claim 54: w_b/3, rectangular')
      call tests%is_close(position(printed, 1, 0.34_dp, 0.39_dp), 0.363_dp, 4e-3_dp, 'claim 55: w_b/5 as printed')
      call tests%is_true(height(rectangular, 1, 0.34_dp, 0.39_dp) <= 0, 'claim 55: none with the rectangular wave')
      call tests%is_close(position(rectangular, 2, 0.18_dp, 0.2_dp), 0.1903_dp, 2e-3_dp, 'claim 55: w_a/5, rectangular')
      call tests%is_true(height(printed, 2, 0.18_dp, 0.2_dp) <= 0, 'claim 55: none in mesh 2 as printed')
   end subroutine five_harmonics

   !> Claims 56 to 58, figure 9.
   subroutine damping(tests, zeta5)
      class(tests_type), intent(inout) :: tests
      type(branch_type), intent(in) :: zeta5
      type(branch_type) :: zeta3, zeta1
      type(train_type) :: train

      train = paper_train()
      train%meshes%damping_ratio = 0.03_dp
      zeta3 = traced(tests, train, 0.2_dp, 2.6_dp, 6, 'zeta 0.03')
      train%meshes%damping_ratio = 0.01_dp
      zeta1 = traced(tests, train, 2.6_dp, 1.0_dp, 6, 'zeta 0.01')
      call tests%is_true(index(zeta1%ended%text, 'beyond the amplitude limit 12 from') > 0, &
                         'claim 56: resonance b is unbounded at 0.01')
      call tests%is_true(largest_between(zeta3, 2, 0.6_dp, 1.0_dp) > 2.5_dp*largest_between(zeta5, 2, 0.6_dp, 1.0_dp), &
                         'claim 56: resonance a at 0.03 and at 0.05')
      call tests%is_true(largest_between(zeta3, 1, 1.3_dp, 2.0_dp) > 1.4_dp*largest_between(zeta5, 1, 1.3_dp, 2.0_dp), &
                         'claim 56: resonance b at 0.03 and at 0.05')
      call tests%is_true(height(zeta3, 2, 0.4_dp, 0.48_dp) > 1.3_dp*height(zeta5, 2, 0.4_dp, 0.48_dp), &
                         'claim 57: super-harmonic w_a/2')
      call tests%is_true(is_band(zeta5, 1.7492_dp, 2.0439_dp, 1e-3_dp), 'claim 58: unstable range at 0.05')
      call tests%is_true(is_band(zeta3, 1.7344_dp, 2.0498_dp, 1e-3_dp), 'claim 58: wider at 0.03')
      call tests%is_true(is_band(zeta1, 1.7260_dp, 2.0526_dp, 1e-3_dp), 'claim 58: wider still at 0.01')
   end subroutine damping

   !> Claims 59 to 64, figures 10 and 11.
   subroutine orders(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch, linear
      type(train_type) :: train

      train = paper_train()
      train%meshes(2)%order = 2
      branch = traced(tests, train, 0.2_dp, 2.6_dp, 12, 'figure 10')
      train%meshes%half_backlash = 0
      linear = traced(tests, train, 0.2_dp, 0.7_dp, 12, 'figure 10 without backlash')
      call tests%is_close(position(linear, 2, 0.4_dp, 0.6_dp), 0.4785_dp, 8e-3_dp, 'claim 59: w_a/m_4 without backlash')
      call tests%is_true(largest_between(branch, 2, 0.80_dp, 0.97_dp) > 12, 'claim 59: w_a/m_2 and w_b/m_4: unbounded')
      call tests%is_close(position(branch, 2, 0.33_dp, 0.35_dp), 0.34_dp, 5e-3_dp, 'claim 59: w_a/m_4 ends at 0.34')
      call tests%is_close(position(branch, 1, 1.3_dp, 2.2_dp), 1.40_dp, 5e-3_dp, 'claim 59: w_b/m_2 softens to 1.40')
      call tests%is_true(folds_between(branch, 0.70_dp, 0.96_dp) >= 12, 'claim 60: several jumps below 0.96')
      call tests%is_true(smallest_between(branch, 2, 0.2_dp, 0.4_dp) < -1, 'claim 61: back collision at w_a/m_4')
      call tests%is_true(smallest_between(branch, 2, 0.5_dp, 1.0_dp) < -1, 'claim 61: back collision at w_a/m_2')

      train = paper_train()
      train%meshes%order = [3, 2]
      branch = traced(tests, train, 0.2_dp, 2.6_dp, 12, 'figure 11')
      train%meshes%half_backlash = 0
      linear = traced(tests, train, 0.2_dp, 0.7_dp, 12, 'figure 11 without backlash')
      call tests%is_close(position(linear, 2, 0.30_dp, 0.34_dp), 0.319_dp, 8e-3_dp, 'claim 62: w_a/3')
      call tests%is_close(position(linear, 2, 0.40_dp, 0.60_dp), 0.4785_dp, 8e-3_dp, 'claim 62: w_a/2')
      call tests%is_close(position(linear, 1, 0.57_dp, 0.70_dp), 0.611_dp, 8e-3_dp, 'claim 62: w_b/3 is 0.62, not 0.65')
      call tests%is_true(folds_between(branch, 0.2_dp, 1.0_dp) >= 25, 'claim 63: many folds')
      call tests%is_true(any(branch%stable(:branch%points)) .and. .not. all(branch%stable(:branch%points)), &
                         'claim 63: stable and unstable')
      call tests%is_true(stable_somewhere(branch, 1.4_dp, 2.6_dp), 'claim 64: all of it below 1.4')
   end subroutine orders

   pure real(dp) function height(branch, mesh, from, to)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: mesh
      real(dp), intent(in) :: from, to
      type(peak_type) :: peak

      peak = peak_between(branch, mesh, from, to)
      height = peak%rms
   end function height

   pure real(dp) function position(branch, mesh, from, to)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: mesh
      real(dp), intent(in) :: from, to
      type(peak_type) :: peak

      peak = peak_between(branch, mesh, from, to)
      position = peak%frequency_ratio
   end function position

end module validation_claims_excitation
