!> Closed forms: boundaries of stability of Mathieu's and Meissner's equations, reflection.
module hard_closed_forms
   use fixtures, only: paper_train, settings_of, single_pair
   use geartrain, only: branch_type, dp, error_type, motion_type, refine, train_type
   use geartrain_base_kinds, only: pi
   use readings, only: solution, solve
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: closed_forms_cases

contains

   subroutine closed_forms_cases(tests)
      class(tests_type), intent(inout) :: tests

      call tests%heading('Closed forms')
      if (tests%runs('mathieu')) then
         ! Characteristic values: eigenvalues of the recurrences DLMF 28.4.5 to 28.4.8, 60 terms; those at q = 5 stand to eight
         ! decimals in Abramowitz and Stegun, table 20.1.
         call mathieu(tests, 'a1(1)', 1.859108072514_dp, 1.0_dp, -1, 0.0_dp)
         call mathieu(tests, 'b2(1)', 3.917024772998_dp, 1.0_dp, 1, 0.0_dp)
         call mathieu(tests, 'a2(1)', 4.371300982735_dp, 1.0_dp, 1, 0.0_dp)
         call mathieu(tests, 'a1(5)', 1.858187541548_dp, 5.0_dp, -1, 0.0_dp)
         call mathieu(tests, 'b2(5)', 2.099460445487_dp, 5.0_dp, 1, 0.0_dp)
         call mathieu(tests, 'a2(5)', 7.449109739529_dp, 5.0_dp, 1, 0.0_dp)
         call mathieu(tests, 'a1(1)', 1.859108072514_dp, 1.0_dp, -1, 0.1_dp)
         call mathieu(tests, 'a2(1)', 4.371300982735_dp, 1.0_dp, 1, 0.1_dp)
      end if
      if (tests%runs('meissner')) then
         call meissner(tests, 1.3_dp, 0.0_dp)
         call meissner(tests, 2.05_dp, 0.0_dp)
         call meissner(tests, 2.05_dp, 0.05_dp)
      end if
      if (tests%runs('boundary')) then
         ! Edges of the principal instability, multiplier -1: zeros of Hill's determinant (61 harmonics), by integration (DOP853)
         ! equal to 1e-13; zeros of 1 + trace + exp(-2 zeta T) of the rectangular wave.
         call boundary(tests, 'Mathieu', [0.3_dp], 0.05_dp, [1.8831440170837_dp, 2.1063923779291_dp])
         call boundary(tests, 'Mathieu', [0.6_dp], 0.1_dp, [1.7582959167643_dp, 2.2019461807863_dp])
         call boundary(tests, 'Meissner', rectangular_wave(0.4_dp), 0.0_dp, [1.7406868289481_dp, 2.2460985098936_dp])
         call boundary(tests, 'Meissner', rectangular_wave(0.4_dp), 0.05_dp, [1.7584523130347_dp, 2.2232619075615_dp])
      end if
      if (tests%runs('reflection')) call reflection(tests)
      if (tests%runs('in_contact')) call in_contact(tests)
   end subroutine closed_forms_cases

   !> x'' + 2 zeta x' + (1 + kappa cos Lambda t) x = f, no gap: with x = exp(-zeta t) y and tau = Lambda t/2 this is Mathieu's
   !> y'' + (a - 2 q cos 2 tau) y with a = 4 (1 - zeta^2)/Lambda^2, q = kappa a/(2 (1 - zeta^2)) up to a shift of tau. On a
   !> boundary the two multipliers of y are one, +1 or -1; their sum is well conditioned there.
   subroutine mathieu(tests, name, a, q, sign_, zeta)
      class(tests_type), intent(inout) :: tests
      character(*), intent(in) :: name
      real(dp), intent(in) :: a, q, zeta
      integer, intent(in) :: sign_
      type(train_type) :: train
      type(branch_type) :: branch
      real(dp) :: frequency_ratio, total
      character(16) :: text

      frequency_ratio = 2*sqrt((1 - zeta**2)/a)
      ! Without a load: where a multiplier is 1 a loaded train has no motion.
      train = single_pair(zeta, 2*q*(1 - zeta**2)/a, 0.0_dp)
      train%meshes%half_backlash = 0
      branch = solve(train, settings_of(frequency_ratio, 1.001_dp*frequency_ratio, 8))
      total = real(sum(branch%multipliers(:, 1)), dp)
      write (text, '(a, f4.1)') ', zeta =', zeta
      call tests%measured('Mathieu boundary '//name//trim(text), 'sum of the multipliers +-2 exp(-zeta T)', &
                          abs(total - sign_*2*exp(-zeta*2*pi/frequency_ratio)), 1e-9_dp)
   end subroutine mathieu

   !> A rectangular wave of stiffness 1 +- 0.4, by 199 harmonics: the trace of two half periods of constant stiffness.
   subroutine meissner(tests, frequency_ratio, zeta)
      class(tests_type), intent(inout) :: tests
      real(dp), intent(in) :: frequency_ratio, zeta
      type(train_type) :: train
      type(branch_type) :: branch
      real(dp), parameter :: depth = 0.4_dp
      real(dp) :: fast, slow, half, trace
      character(40) :: text

      train = single_pair(zeta, 0.0_dp, 1.0_dp)
      train%meshes%half_backlash = 0
      train%meshes(1)%stiffness_cos = rectangular_wave(depth)
      branch = solve(train, settings_of(frequency_ratio, 1.001_dp*frequency_ratio, 8))
      fast = sqrt(1 + depth - zeta**2)
      slow = sqrt(1 - depth - zeta**2)
      half = pi/frequency_ratio
      trace = 2*cos(fast*half)*cos(slow*half) - (fast/slow + slow/fast)*sin(fast*half)*sin(slow*half)
      write (text, '(a, f5.2, a, f5.2)') 'Meissner, Lambda =', frequency_ratio, ', zeta =', zeta
      call tests%measured(trim(text), 'sum of the multipliers in closed form (199 harmonics of the wave)', &
                          abs(real(sum(branch%multipliers(:, 1)), dp) - trace*exp(-zeta*2*half)), 1e-6_dp)
   end subroutine meissner

   !> Harmonics 1 to 199 of a wave of +depth and -depth.
   pure function rectangular_wave(depth) result(amplitude)
      real(dp), intent(in) :: depth
      real(dp) :: amplitude(199)
      integer :: h

      amplitude = [(4*depth/(pi*h)*sin(h*pi/2), h=1, size(amplitude))]
   end function rectangular_wave

   !> Where a multiplier is -1 on the lower and the upper edge of a band of instability; the verdict changes there.
   subroutine boundary(tests, name, stiffness, zeta, edge)
      class(tests_type), intent(inout) :: tests
      character(*), intent(in) :: name
      real(dp), intent(in) :: stiffness(:), zeta, edge(2)
      type(train_type) :: train
      type(branch_type) :: branch
      real(dp) :: off
      logical :: changes
      character(16) :: text
      integer :: i

      train = single_pair(zeta, 0.0_dp, 1.0_dp)
      train%meshes%half_backlash = 0
      train%meshes(1)%stiffness_cos = stiffness
      off = 0
      changes = .true.
      do i = 1, 2
         branch = solve(train, settings_of(edge(i), 1.001_dp*edge(i), 8))
         ! Well conditioned also where both are -1.
         off = max(off, abs(1 + sum(branch%multipliers(:, 1)) + product(branch%multipliers(:, 1))))
         branch = solve(train, settings_of(0.999_dp*edge(i), 0.9991_dp*edge(i), 8))
         changes = changes .and. (branch%stable(1) .eqv. i == 1)
         branch = solve(train, settings_of(1.001_dp*edge(i), 1.0011_dp*edge(i), 8))
         changes = changes .and. (branch%stable(1) .eqv. i == 2)
      end do
      write (text, '(a, f5.2)') ', zeta =', zeta
      call tests%measured(name//', edges of the principal instability'//trim(text), &
                          'a multiplier is -1: 1 + their sum + their product', off, merge(1e-9_dp, 1e-6_dp, name == 'Mathieu'))
      if (zeta > 0) call tests%holds(name//', 0.1 % beside these edges'//trim(text), 'stable outside, unstable inside', changes)
   end subroutine boundary

   !> Torque and transmission errors with the other sign: every displacement with the other sign.
   subroutine reflection(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train, mirrored
      type(branch_type) :: branch, mirror
      real(dp) :: worst
      integer :: j

      train = paper_train()
      do j = 1, 2
         train%meshes(j)%error_cos = [2e-6_dp, -1e-6_dp]
      end do
      mirrored = train
      mirrored%input_torque = -train%input_torque
      do j = 1, 2
         mirrored%meshes(j)%error_cos = -train%meshes(j)%error_cos
      end do
      branch = solve(train, settings_of(0.2_dp, 2.6_dp, 6))
      mirror = solve(mirrored, settings_of(0.2_dp, 2.6_dp, 6))
      worst = huge(1.0_dp)
      if (branch%points == mirror%points .and. branch%complete) then
         worst = max(maxval(abs(branch%coefficients + mirror%coefficients)), maxval(abs(branch%minimum + mirror%maximum)), &
                     maxval(abs(abs(branch%multipliers) - abs(mirror%multipliers))))
      end if
      call tests%measured('negative torque and errors, figure 3', 'the mirror image, point by point, multipliers too', worst, &
                          1e-9_dp)
   end subroutine reflection

   !> While contact holds the balance converges spectrally to the solution of linear equations.
   subroutine in_contact(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(motion_type) :: motion, exact
      type(error_type), allocatable :: error

      train = paper_train()
      motion = solution(train, settings_of(0.4_dp, 0.41_dp, 24))
      exact = motion
      call refine(train, exact, error)
      if (allocated(error)) exact%rms = 0
      call tests%measured('contact just holds (figure 3 at 0.4)', 'shooting: rms at R = 24', maxval(abs(motion%rms - exact%rms)), &
                          1e-11_dp)
      train%meshes%half_backlash = 0
      train%input_torque = -1e3_dp
      motion = solution(train, settings_of(1.6_dp, 1.61_dp, 24))
      exact = motion
      call refine(train, exact, error)
      if (allocated(error)) exact%rms = 0
      call tests%measured('no gap, where the other flank would be hit (figure 3 at 1.6)', 'shooting: rms at R = 24, relative', &
                          maxval(abs(motion%rms/exact%rms - 1)), 1e-11_dp)
   end subroutine in_contact

end module hard_closed_forms
