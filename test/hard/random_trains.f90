!> Trains at random, and one of hunting teeth, against shooting: what is told as certain must be so.
module hard_random_trains
   use, intrinsic :: iso_fortran_env, only: int64
   use fixtures, only: settings_of
   use geartrain, only: branch_type, dp, error_type, mesh_type, motion_type, refine, response_settings_type, shaft_type, train_type
   use geartrain_branch_decided, only: rests_on_undecided
   use geartrain_branch_jumps, only: jump_type, jumps
   use geartrain_branch_summary, only: band_type, bands_without_stability
   use hard_cases, only: cases_type, solve
   implicit none (type, external)
   private
   public :: random_trains_cases

   !> A point whose orbit differs by more than this many times its estimated error has another orbit next to it.
   real(dp), parameter :: another = 10
   !> The estimate may be off by this factor at points that are not doubtful (docs/numerics.md: all but those next to a fold).
   real(dp), parameter :: factor = 3

contains

   subroutine random_trains_cases(cases)
      class(cases_type), intent(inout) :: cases

      call cases%heading('Random trains and hunting teeth')
      call random(cases)
      call hunting(cases)
   end subroutine random_trains_cases

   !> Every branch of the trains at a dozen of its points, solved anew by shooting.
   subroutine random(cases)
      class(cases_type), intent(inout) :: cases
      type(train_type) :: train
      type(branch_type) :: branch
      type(response_settings_type) :: settings
      integer :: seed, trains, points, found, wrong_verdicts, wrong_estimates, undecided, doublings, wrong_doublings

      trains = merge(8, 60, cases%slow_build)
      points = 0
      found = 0
      undecided = 0
      wrong_verdicts = 0
      wrong_estimates = 0
      doublings = 0
      wrong_doublings = 0
      do seed = 1, trains
         call random_train(seed, train, settings)
         branch = solve(train, settings)
         call compare(train, branch, points, found, undecided, wrong_verdicts, wrong_estimates, doublings, wrong_doublings)
      end do
      call cases%holds('random trains, a dozen points each', 'shooting finds an orbit next to 9 of 10', 10*found >= 9*points)
      call cases%holds('random trains', 'shooting: no decided verdict wrong', wrong_verdicts == 0)
      call cases%holds('random trains', 'shooting: estimates of 49 of 50 points without doubt within a factor 3', &
                       50*wrong_estimates <= found)
      call cases%holds('random trains', 'shooting: multipliers pass -1 at the doublings listed, and nowhere else', &
                       (doublings > 0 .or. cases%slow_build) .and. wrong_doublings == 0)
      call cases%holds('random trains', 'at most one point in four undecided', 4*undecided <= points)
   end subroutine random

   subroutine compare(train, branch, points, found, undecided, wrong_verdicts, wrong_estimates, doublings, wrong_doublings)
      type(train_type), intent(in) :: train
      type(branch_type), intent(in) :: branch
      integer, intent(inout) :: points, found, undecided, wrong_verdicts, wrong_estimates
      !> Doublings listed between two points of one part with orbits of decided stability, and pairs of such points between which
      !> shooting sees another number of them, modulo 2: what becomes a complex pair takes two.
      integer, intent(inout) :: doublings, wrong_doublings
      type(motion_type) :: motion
      type(error_type), allocatable :: error
      real(dp) :: off
      integer :: i, before, below, below_before, listed

      before = 0
      below_before = 0
      do i = 1, branch%points, max(1, branch%points/12)
         points = points + 1
         if (branch%undecided(i)) undecided = undecided + 1
         motion = motion_type(frequency=branch%frequency(i), period=branch%subharmonic)
         motion%coefficients = branch%coefficients(:, :, i)
         call refine(train, motion, error)
         if (allocated(error)) cycle
         off = difference(branch%coefficients(:, :, i), motion%coefficients)
         if (off > max(another*branch%error_estimate(i), 1e-6_dp)) cycle
         found = found + 1
         if (off > factor*branch%error_estimate(i) + 1e-7_dp .and. .not. branch%estimate_doubtful(i)) &
            wrong_estimates = wrong_estimates + 1
         if (branch%undecided(i) .or. motion%undecided) cycle
         if (branch%stable(i) .neqv. motion%stable) wrong_verdicts = wrong_verdicts + 1
         ! Beyond that the smaller multipliers are rounding.
         if (abs(motion%multipliers(1)) > 1e6_dp) cycle
         below = count(abs(motion%multipliers%im) <= 1e-6_dp*abs(motion%multipliers) .and. motion%multipliers%re < -1)
         if (before > 0) then
            if (branch%part(before) == branch%part(i)) then
               listed = count(branch%special_points%kind == 'period doubling' .and. branch%special_points%point >= before &
                              .and. branch%special_points%point < i)
               doublings = doublings + listed
               if (mod(below - below_before - listed, 2) /= 0) then
                  wrong_doublings = wrong_doublings + 1
               end if
            end if
         end if
         before = i
         below_before = below
      end do
   end subroutine compare

   !> One to three pairs: equal stages or not, orders 1, alike up to 80 or unlike up to 7, shafts with and without damping, torque
   !> of either sign; a range below, at or above the first resonance; few harmonics.
   subroutine random_train(seed, train, settings)
      integer, intent(in) :: seed
      type(train_type), intent(out) :: train
      type(response_settings_type), intent(out) :: settings
      integer(int64) :: generator
      integer :: i, j, meshes, order, highest
      logical :: equal, damped
      real(dp) :: start

      generator = 7919_int64*seed + 17
      do i = 1, 10
         start = uniform()
      end do
      meshes = 1 + int(3*uniform())
      equal = uniform() < 0.3_dp
      damped = uniform() < 0.7_dp
      train%input_torque = merge(1, -1, uniform() < 0.75_dp)*(50 + 250*uniform())
      train%prime_mover_inertia = 0.001_dp*(0.2_dp + 3*uniform())
      train%load_inertia = 0.001_dp*(0.2_dp + 3*uniform())
      train%characteristic_length = 30e-6_dp
      train%characteristic_frequency = 1e4_dp
      allocate (train%shafts(meshes + 1), train%meshes(meshes))
      do j = 1, meshes + 1
         train%shafts(j) = shaft_type(stiffness=10**(3 + 3*uniform()), damping_ratio=merge(0.02_dp, 0.0_dp, damped))
         if (uniform() < 0.3_dp) train%shafts(j) = shaft_type(rigid=.true.)
      end do
      order = 1
      if (uniform() < 0.4_dp) order = 2 + int(79*uniform())
      highest = order
      do j = 1, meshes
         associate (mesh => train%meshes(j))
            mesh%driving_radius = 0.03_dp + 0.04_dp*uniform()
            mesh%driven_radius = 0.03_dp + 0.08_dp*uniform()
            mesh%driving_inertia = 0.001_dp + 0.006_dp*uniform()
            mesh%driven_inertia = 0.002_dp + 0.04_dp*uniform()
            mesh%stiffness = 1e8_dp + 4e8_dp*uniform()
            mesh%damping_ratio = 0.02_dp + 0.06_dp*uniform()
            mesh%half_backlash = 10e-6_dp + 50e-6_dp*uniform()
            mesh%stiffness_cos = [0.05_dp + 0.3_dp*uniform()]
            mesh%stiffness_sin = [0.1_dp*uniform()]
            mesh%error_cos = [5e-6_dp*uniform()]
            mesh%order = order
            if (order == 1 .and. j > 1 .and. uniform() < 0.5_dp) mesh%order = 1 + int(7*uniform())
            highest = max(highest, mesh%order)
         end associate
         if (equal .and. j > 1) train%meshes(j) = train%meshes(1)
      end do
      if (equal) highest = train%meshes(1)%order
      start = (0.2_dp + 1.8_dp*uniform())/highest
      settings = settings_of(start, 1.3_dp*start, highest*(2 + int(6*uniform())))
      settings%max_points = 400

   contains

      !> Park and Miller's minimal standard generator, in (0, 1).
      real(dp) function uniform()

         generator = mod(48271_int64*generator, 2147483647_int64)
         uniform = real(generator, dp)/2147483647.0_dp
      end function uniform

   end subroutine random_train

   !> Two stages of 71 and 19 teeth a revolution of the shaft between them with 213 harmonics, far too few (1278 hold 1.5e-4 at
   !> Lambda = 0.82): all that the balance sees of instability there is wrong (the motion from rest is stable by integration and
   !> shooting), and marked as undecided.
   subroutine hunting(cases)
      class(cases_type), intent(inout) :: cases
      type(branch_type) :: branch
      type(jump_type), allocatable :: found(:)
      type(band_type), allocatable :: bands(:)
      integer :: i

      if (cases%slow_build) return
      branch = solve(reducer(), settings_of(0.80_dp, 0.83_dp, 213))
      found = jumps(branch)
      bands = bands_without_stability(branch)
      call cases%holds('71 and 19 teeth, 213 harmonics', 'errors beyond 0.1, motions told as unstable', &
                       any(branch%error_estimate > 0.1_dp) .and. .not. all(branch%stable))
      call cases%holds('the same', 'none of them without being undecided', all(branch%stable .or. branch%undecided))
      call cases%holds('the same', 'jumps, all undecided', size(found) > 0 .and. all(found%undecided))
      call cases%holds('the same', 'bands without stability, all undecided', all(bands%undecided))
      call cases%holds('the same', 'special points, all resting on undecided points', &
                       size(branch%special_points) > 0 .and. &
                       all([(rests_on_undecided(branch, i), i=1, size(branch%special_points))]))
   end subroutine hunting

   !> 23/71 and 19/80 teeth, modules of 2.5 and 4 mm, faces of 40 and 70 mm, 20 and 15 degrees, solid discs, steel shafts; Lambda
   !> counts 1000 rpm of the first shaft.
   function reducer() result(train)
      type(train_type) :: train
      real(dp), parameter :: pi = acos(-1.0_dp), degree = pi/180, teeth(2, 2) = reshape([23, 71, 19, 80], [2, 2]), &
                             module_(2) = [2.5e-3_dp, 4e-3_dp], face(2) = [0.04_dp, 0.07_dp], &
                             diameter(3) = [0.03_dp, 0.04_dp, 0.06_dp], length(3) = [0.15_dp, 0.12_dp, 0.2_dp]
      real(dp) :: pitch(2), transverse
      integer :: j

      train%input_torque = 90
      train%prime_mover_inertia = 0.02_dp
      train%load_inertia = 1.5_dp
      train%characteristic_length = 1e-6_dp
      train%characteristic_frequency = 2*pi*1000/60*23/71
      allocate (train%shafts(3), train%meshes(2))
      train%shafts%stiffness = 8e10_dp*pi*diameter**4/32/length
      train%shafts%damping_ratio = 0.01_dp
      transverse = atan(tan(20*degree)/cos(15*degree))
      do j = 1, 2
         pitch = module_(j)*teeth(:, j)/cos(15*degree)
         associate (mesh => train%meshes(j))
            mesh%driving_radius = pitch(1)/2*cos(transverse)
            mesh%driven_radius = pitch(2)/2*cos(transverse)
            mesh%driving_inertia = 7850*face(j)*pi*pitch(1)**4/32
            mesh%driven_inertia = 7850*face(j)*pi*pitch(2)**4/32
            mesh%stiffness = 14e9_dp*face(j)
            mesh%damping_ratio = 0.05_dp
            mesh%half_backlash = 28e-6_dp
            mesh%stiffness_cos = [0.1_dp, 0.05_dp, 0.02_dp]
            mesh%error_cos = [3e-6_dp]
         end associate
      end do
      train%meshes%order = [71, 19]
   end function reducer

   !> Relative difference of the waveforms of two sets of coefficients, all meshes together, as the error estimate has it.
   pure real(dp) function difference(a, b)
      real(dp), intent(in) :: a(:, :), b(:, :)
      integer :: n

      n = min(size(a, 1), size(b, 1))
      difference = sqrt((2*sum((b(1, :) - a(1, :))**2) + sum((b(2:n, :) - a(2:n, :))**2) + sum(b(n + 1:, :)**2)) &
                        /max(sum(b(2:, :)**2), tiny(1.0_dp)))
   end function difference

end module hard_random_trains
