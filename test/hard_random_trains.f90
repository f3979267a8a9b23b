!> Trains at random, and one of hunting teeth, against shooting: what is told as certain must be so.
module hard_random_trains
   use fixtures, only: random_train, reducer, settings_of
   use geartrain, only: branch_type, dp, error_type, motion_type, refine, refine_branch, response_settings_type, solutions_at, &
      train_type
   use geartrain_readings_jumps, only: jump_type, jumps
   use geartrain_readings_summary, only: band_type, bands_without_stability
   use geartrain_trace_decided, only: rests_on_undecided
   use readings, only: solve
   use testing, only: full, tests_type
   implicit none (type, external)
   private
   public :: random_trains_cases

   !> A point whose orbit differs by more than this many times its estimated error has another orbit next to it.
   real(dp), parameter :: another = 10
   !> The estimate may be off by this factor at points that are not doubtful (docs/numerics.md: all but those next to a fold).
   real(dp), parameter :: factor = 3

contains

   subroutine random_trains_cases(tests)
      class(tests_type), intent(inout) :: tests

      call tests%heading('Random trains and hunting teeth')
      if (tests%runs('random', full)) call random(tests)
      if (tests%runs('refined', full)) call refined(tests)
      if (tests%runs('hunting', full)) call hunting(tests)
   end subroutine random_trains_cases

   !> Every branch of the trains at a dozen of its points, solved anew by shooting.
   subroutine random(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: branch
      type(response_settings_type) :: settings
      character(80) :: wrong
      integer :: seed, trains, points, found, missed, wrong_verdicts, wrong_estimates, undecided, doublings, wrong_doublings

      trains = tests%times(60)
      points = 0
      found = 0
      missed = 0
      undecided = 0
      wrong_verdicts = 0
      wrong_estimates = 0
      doublings = 0
      wrong_doublings = 0
      wrong = ''
      do seed = 1 + 1000*tests%seed, trains + 1000*tests%seed
         call random_train(seed, train, settings)
         branch = solve(train, settings)
         call compare(train, settings, branch, points, found, missed, undecided, wrong_verdicts, wrong_estimates, doublings, &
                      wrong_doublings)
         if (wrong_verdicts + wrong_doublings > 0 .and. wrong == '') write (wrong, '(a, i0)') ', first wrong: train ', seed
      end do
      call tests%holds('random trains, a dozen points each', 'shooting finds an orbit next to all without doubt', missed == 0)
      ! Shares over many trains: six others may have less, or more.
      call tests%holds('random trains, a dozen points each', 'shooting finds an orbit next to 9 of 10', &
                       10*found >= 9*points .or. tests%seed > 0)
      call tests%holds('random trains', 'shooting: no decided verdict wrong'//trim(wrong), wrong_verdicts == 0)
      call tests%holds('random trains', 'shooting: estimates of 49 of 50 points without doubt within a factor 3', &
                       50*wrong_estimates <= found)
      call tests%holds('random trains', 'shooting: multipliers pass -1 at the doublings listed, and nowhere else'//trim(wrong), &
                       (doublings > 0 .or. tests%seed > 0) .and. wrong_doublings == 0)
      call tests%holds('random trains', 'at most one point in four undecided', 4*undecided <= points .or. tests%seed > 0)
   end subroutine random

   subroutine compare(train, settings, branch, points, found, missed, undecided, wrong_verdicts, wrong_estimates, doublings, &
                      wrong_doublings)
      type(train_type), intent(in) :: train
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: branch
      !> Points with an orbit next to them, and points without doubt that have none.
      integer, intent(inout) :: points, found, missed, undecided, wrong_verdicts, wrong_estimates
      !> Doublings listed between two points of one part with orbits of decided stability, and pairs of such points between which
      !> shooting sees another number of them, modulo 2: what becomes a complex pair takes two.
      integer, intent(inout) :: doublings, wrong_doublings
      type(motion_type) :: motion
      type(error_type), allocatable :: error
      real(dp) :: off
      integer :: i, before, below, below_balance, below_before, listed

      before = 0
      below_before = 0
      do i = 1, branch%points, max(1, branch%points/12)
         points = points + 1
         if (branch%undecided(i)) undecided = undecided + 1
         motion = motion_type(frequency_ratio=branch%frequency_ratio(i), period=branch%subharmonic)
         motion%coefficients = branch%coefficients(:, :, i)
         call refine(train, motion, error)
         if (allocated(error)) then
            if (.not. branch%estimate_doubtful(i)) missed = missed + 1
            cycle
         end if
         off = difference(branch%coefficients(:, :, i), motion%coefficients)
         if (off > factor*branch%error_estimate(i) + 1e-7_dp) call find_nearer(train, branch, i, motion, off)
         if (off > max(another*branch%error_estimate(i), 1e-6_dp)) then
            if (.not. branch%estimate_doubtful(i)) missed = missed + 1
            cycle
         end if
         found = found + 1
         if (off > factor*branch%error_estimate(i) + 1e-7_dp .and. .not. branch%estimate_doubtful(i)) &
            wrong_estimates = wrong_estimates + 1
         if (branch%undecided(i) .or. motion%undecided) cycle
         if (branch%stable(i) .neqv. motion%stable) then
            if (is_of_another_sheet(train, settings, branch, i, motion)) cycle
            wrong_verdicts = wrong_verdicts + 1
         end if
         ! Beyond that the smaller multipliers are rounding.
         if (abs(motion%multipliers(1)) > 1e6_dp) cycle
         ! Where a motion repeats itself within its period, what is doubled is a repetition.
         if (allocated(branch%repetition_multipliers)) then
            below = beyond_minus_one(motion%repetition_multipliers)
            below_balance = beyond_minus_one(branch%repetition_multipliers(:, i))
         else
            below = beyond_minus_one(motion%multipliers)
            below_balance = beyond_minus_one(branch%multipliers(:, i))
         end if
         ! Where the balance counts others, its error moves the doubling past this point.
         if (below /= below_balance) then
            before = 0
            cycle
         end if
         if (before > 0) then
            if (branch%segment(before) == branch%segment(i)) then
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

   !> Looks for an orbit by shooting in sections, and takes it where it is nearer to point i than the orbit at hand. Near a fold two
   !> orbits have this Lambda, and the estimate is of the distance to the nearer one: of a strongly unstable motion, shooting over
   !> the whole period often finds the other one.
   subroutine find_nearer(train, branch, i, motion, off)
      type(train_type), intent(in) :: train
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: i
      !> The orbit at hand, then the nearer one, and its difference from the point.
      type(motion_type), intent(inout) :: motion
      real(dp), intent(inout) :: off
      type(motion_type) :: other
      type(error_type), allocatable :: error

      other = motion_type(frequency_ratio=branch%frequency_ratio(i), period=branch%subharmonic)
      other%coefficients = branch%coefficients(:, :, i)
      call refine(train, other, error, in_sections=.true.)
      if (allocated(error)) return
      if (difference(branch%coefficients(:, :, i), other%coefficients) >= off) return
      motion = other
      off = difference(branch%coefficients(:, :, i), motion%coefficients)
   end subroutine find_nearer

   !> A train with folds 1e-5 apart in Lambda and multipliers of 1e4 between them, where the side of the points is not known: single
   !> shooting finds an orbit of the other side, or none that it can tell from it, and refinement takes the nearer orbit of two.
   subroutine refined(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(response_settings_type) :: settings
      type(branch_type) :: branch
      type(error_type), allocatable :: error
      real(dp), allocatable :: estimate(:)
      logical, allocatable :: sure(:)

      call random_train(20003, train, settings)
      branch = solve(train, settings)
      estimate = branch%error_estimate(:branch%points)
      sure = .not. branch%estimate_doubtful(:branch%points)
      call refine_branch(train, branch, error)
      call tests%is_true(.not. allocated(error) .and. branch%points > 30, 'a branch through the folds')
      associate (correction => branch%correction(:branch%points))
         call tests%holds('a train with folds 1e-5 apart', 'refined: 49 of 50 points without doubt as estimated, within 3', &
                          50*count(sure .and. (correction < 0 .or. correction > factor*estimate)) <= count(sure))
      end associate
   end subroutine refined

   !> Two stages of 71 and 19 teeth a revolution of the shaft between them with 213 harmonics, far too few (1278 hold 1.5e-4 at
   !> Lambda = 0.82): all that the balance sees of instability there is wrong (the motion from rest is stable by integration and
   !> shooting), and marked as undecided.
   subroutine hunting(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(jump_type), allocatable :: found(:)
      type(band_type), allocatable :: bands(:)
      integer :: i

      branch = solve(reducer(), settings_of(0.80_dp, 0.83_dp, 213))
      found = jumps(branch)
      bands = bands_without_stability(branch)
      call tests%holds('71 and 19 teeth, 213 harmonics', 'errors beyond 0.1, motions told as unstable', &
                       any(branch%error_estimate > 0.1_dp) .and. .not. all(branch%stable))
      call tests%holds('the same', 'none of them without being undecided', all(branch%stable .or. branch%undecided))
      call tests%holds('the same', 'jumps, all undecided', size(found) > 0 .and. all(found%undecided))
      call tests%holds('the same', 'bands without stability, all undecided', all(bands%undecided))
      call tests%holds('the same', 'special points, all resting on undecided points', &
                       size(branch%special_points) > 0 .and. &
                       all([(rests_on_undecided(branch, i), i=1, size(branch%special_points))]))
   end subroutine hunting

   !> Number of real multipliers below -1.
   pure integer function beyond_minus_one(multipliers)
      complex(dp), intent(in) :: multipliers(:)

      beyond_minus_one = count(abs(multipliers%im) <= 1e-6_dp*abs(multipliers) .and. multipliers%re < -1)
   end function beyond_minus_one

   !> Whether shooting goes to the same orbit from another motion of the branch at the Lambda of point i: beside a fold the error of
   !> the balance is as large as the distance of the two sheets, and the orbit may belong to either.
   logical function is_of_another_sheet(train, settings, branch, i, motion)
      type(train_type), intent(in) :: train
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: i
      type(motion_type), intent(in) :: motion
      real(dp), parameter :: same = 1e-6_dp
      type(motion_type), allocatable :: motions(:)
      type(error_type), allocatable :: error
      integer :: k

      is_of_another_sheet = .false.
      call solutions_at(train, settings, branch, branch%frequency_ratio(i), motions, error)
      if (allocated(error)) return
      do k = 1, size(motions)
         if (difference(branch%coefficients(:, :, i), motions(k)%coefficients) < same) cycle
         call refine(train, motions(k), error)
         if (.not. allocated(error)) is_of_another_sheet = is_of_another_sheet .or. &
            difference(motion%coefficients, motions(k)%coefficients) < same
      end do
   end function is_of_another_sheet

   !> Relative difference of the waveforms of two sets of coefficients, all meshes together, as the error estimate has it.
   pure real(dp) function difference(a, b)
      real(dp), intent(in) :: a(:, :), b(:, :)
      integer :: n

      n = min(size(a, 1), size(b, 1))
      difference = sqrt((2*sum((b(1, :) - a(1, :))**2) + sum((b(2:n, :) - a(2:n, :))**2) + sum(b(n + 1:, :)**2)) &
                        /max(sum(b(2:, :)**2), tiny(1.0_dp)))
   end function difference

end module hard_random_trains
