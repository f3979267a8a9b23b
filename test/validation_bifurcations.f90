!> Bifurcations of equal stages, which lose their symmetry, and what is told of special points wherever a trace begins and ends.
module validation_bifurcations
   use fixtures, only: closest, paper_train, settings_of
   use geartrain, only: band_type, branch_type, dp, error_type, follow_bifurcations, jump_type, jumps, &
                        locate_contact_edges, mesh_type, motion_type, refine, response, response_settings_type, &
                        separation_ranges, shaft_type, solutions_at, train_type
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: bifurcations_tests

contains

   subroutine bifurcations_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('antisymmetric_doublings')) call antisymmetric_doublings(tests)
      if (tests%runs('doublings_together')) call doublings_together(tests)
      if (tests%runs('asymmetric_motions')) call asymmetric_motions(tests)
      if (tests%runs('each_crossing_once')) call each_crossing_once(tests)
      if (tests%runs('seeds_and_bounds')) call seeds_and_bounds(tests)
      if (tests%runs('closed_once')) call closed_once(tests)
      if (tests%runs('contact_edge')) call contact_edge(tests)
   end subroutine bifurcations_tests

   !> Two equal pairs on a shaft between rigid ends.
   function equal_stages(stiffness, damping_ratio) result(train)
      real(dp), intent(in) :: stiffness, damping_ratio
      type(train_type) :: train
      type(mesh_type) :: mesh
      type(shaft_type) :: shaft

      mesh%driving_radius = 0.05_dp
      mesh%driven_radius = 0.05_dp
      mesh%driving_inertia = 0.003_dp
      mesh%driven_inertia = 0.003_dp
      mesh%stiffness = 2.5e8_dp
      mesh%damping_ratio = 0.05_dp
      mesh%half_backlash = 30e-6_dp
      mesh%stiffness_cos = [0.3_dp]
      train%input_torque = 100
      train%characteristic_length = 30e-6_dp
      train%characteristic_frequency = 2e4_dp
      train%meshes = [mesh, mesh]
      shaft%rigid = .true.
      train%shafts = [shaft, shaft, shaft]
      train%shafts(2)%rigid = .false.
      train%shafts(2)%stiffness = stiffness
      if (damping_ratio > 0) train%shafts(2)%damping_ratio = damping_ratio
      if (.not. damping_ratio > 0) train%shafts(2)%damping = 0
   end function equal_stages

   !> Lambda of the special points of a kind.
   pure function places(branch, kind) result(frequency_ratio)
      type(branch_type), intent(in) :: branch
      character(*), intent(in) :: kind
      real(dp), allocatable :: frequency_ratio(:)
      integer :: i

      allocate (frequency_ratio(0))
      do i = 1, size(branch%special_points)
         if (branch%special_points(i)%kind == kind) frequency_ratio = [frequency_ratio, branch%special_points(i)%frequency_ratio]
      end do
   end function places

   !> In the stages' antisymmetric motion the bodies on the shaft move together and do not twist it: while the teeth do not separate
   !> it doubles where one pair alone does. A branch begins at each doubling, and leaves vertically.
   subroutine antisymmetric_doublings(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: once
      type(branch_type), allocatable :: branches(:)
      type(response_settings_type) :: settings
      type(error_type), allocatable :: error
      type(train_type) :: alone
      real(dp), allocatable :: doublings(:), expected(:)
      real(dp), parameter :: stiffness(2) = [1e5_dp, 1e6_dp]
      integer :: i, j

      settings = settings_of(1.6_dp, 2.6_dp, 12)
      settings%period_doublings = 1
      alone = equal_stages(1e5_dp, 0.0_dp)
      alone%meshes = alone%meshes(:1)
      alone%shafts = alone%shafts([1, 3])
      call response(alone, settings, once, error)
      expected = places(once, 'period doubling')
      call tests%is_true(size(expected) == 2, 'one pair alone doubles twice')
      if (size(expected) /= 2) return
      do i = 1, 2
         call response(equal_stages(stiffness(i), 0.0_dp), settings, once, error)
         doublings = places(once, 'period doubling')
         call tests%is_true(size(doublings) == merge(4, 2, i == 1), 'doublings of equal stages')
         if (allocated(branches)) deallocate (branches)
         call follow_bifurcations(equal_stages(stiffness(i), 0.0_dp), settings, once, branches, error)
         call tests%is_true(size(branches) == size(doublings), 'as many branches')
         if (size(branches) /= merge(4, 2, i == 1)) cycle
         do j = 1, size(branches)
            call tests%is_true(branches(j)%complete .and. branches(j)%points > 10, 'a branch of period 2')
            ! To what the multipliers of 12 harmonics are worth where contact is kept; the steps end at 1e-10.
            call tests%is_close(branches(j)%frequency_ratio(1), doublings(j), 1e-8_dp, 'it begins at its doubling')
            call tests%is_true(.not. any(abs(places(branches(j), 'fold') - doublings(j)) < 1e-6_dp), 'vertical, not a fold')
         end do
         call tests%is_close(doublings(1), expected(1), 1e-8_dp, 'the antisymmetric motion, as one pair alone')
         call tests%is_close(doublings(merge(3, 2, i == 1)), expected(2), 1e-8_dp, 'and its end')
      end do
   end subroutine antisymmetric_doublings

   !> With a soft shaft a symmetric and an antisymmetric doubling lie within one step; that shaft's own mode is on the unit circle
   !> to 1e-9 where it has no damping, and no Neimark-Sacker point of the branch.
   subroutine doublings_together(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(response_settings_type) :: settings
      type(error_type), allocatable :: error
      real(dp), parameter :: stiffness(2) = [1e3_dp, 100.0_dp], ratio(2) = [0.02_dp, 0.0_dp], step(2) = [0.05_dp, 0.007_dp]
      real(dp), parameter :: expected(4, 2) = reshape([1.92197581_dp, 1.92357223_dp, 2.14979022_dp, 2.14982772_dp, &
                                                       1.92197581_dp, 1.92206606_dp, 2.14982772_dp, 2.14990163_dp], [4, 2])
      integer :: i, j

      do i = 1, 2
         do j = 1, 2
            settings = settings_of(1.6_dp, 2.6_dp, 12)
            settings%step = step(j)
            call response(equal_stages(stiffness(i), ratio(i)), settings, branch, error)
            call tests%is_true(size(branch%special_points) == 4, 'four special points, whatever the step')
            if (size(branch%special_points) /= 4) cycle
            call tests%is_true(all(branch%special_points%kind == 'period doubling'), 'doublings, no Neimark-Sacker point')
            call tests%is_close(maxval(abs(branch%special_points%frequency_ratio - expected(:, i))), 0.0_dp, 2e-8_dp, &
                                'their places')
         end do
      end do
   end subroutine doublings_together

   !> The symmetric branch is crossed twice by one closed branch on which the stages move differently; two of its motions at 0.87,
   !> mirror images of one another, are stable: so says shooting.
   subroutine asymmetric_motions(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: branch
      type(branch_type), allocatable :: branches(:)
      type(response_settings_type) :: settings
      type(motion_type), allocatable :: motions(:), below(:), above(:)
      type(motion_type) :: motion
      type(error_type), allocatable :: error
      type(jump_type), allocatable :: leaps(:)
      real(dp), allocatable :: points(:)
      integer :: i, found

      train = equal_stages(1e5_dp, 0.0_dp)
      settings = settings_of(0.7_dp, 1.1_dp, 12)
      settings%branch_points = .true.
      call response(train, settings, branch, error)
      points = places(branch, 'branch point')
      call tests%is_true(size(points) == 2, 'two branch points')
      if (size(points) /= 2) return
      ! A real multiplier passes +1 there: told by motions to either side of the lower branch's end.
      call solutions_at(train, settings, branch, points(1) - 2e-4_dp, below, error)
      call solutions_at(train, settings, branch, points(1) + 2e-4_dp, above, error)
      call tests%is_true(below(1)%stable .and. .not. above(1)%stable, 'stability is lost there')
      call tests%is_close(largest_real(below(1)), 1.0_dp, 0.05_dp, 'by a multiplier next to +1')
      call tests%is_true(largest_real(below(1)) < 1 .and. largest_real(above(1)) > 1, 'that passes it')

      leaps = jumps(branch)
      call tests%is_true(any(leaps%kind == 'leaves' .and. leaps%cause == 'branch point' .and. leaps%rising &
                             .and. abs(leaps%frequency_ratio - points(1)) < 1e-9_dp), 'rising, a sweep leaves the branch there')

      call follow_bifurcations(train, settings, branch, branches, error)
      call tests%is_true(size(branches) == 1, 'one branch crosses at both')
      if (size(branches) /= 1) return
      call tests%is_true(branches(1)%closed .and. branches(1)%complete, 'it closes')
      call tests%is_true(size(places(branches(1), 'branch point')) == 2, 'it passes both branch points')
      if (size(places(branches(1), 'branch point')) == 2) &
         call tests%is_close(maxval(abs(places(branches(1), 'branch point') - points([2, 1]))), 0.0_dp, 1e-8_dp, 'the same')
      leaps = jumps(branches(1))
      call tests%is_true(count(leaps%rising) == 2 .and. all(leaps%kind == 'leaves'), 'no jump from a fold to its mirror image')
      call solutions_at(train, settings, branches(1), 0.87_dp, motions, error)
      call tests%is_true(size(motions) == 6 .and. count(motions%stable) == 2, 'six motions at 0.87, two of them stable')
      found = 0
      do i = 1, size(motions)
         if (.not. motions(i)%stable) cycle
         found = found + 1
         call tests%is_close(maxval(motions(i)%rms), 0.600_dp, 1e-3_dp, 'rms of one stage')
         call tests%is_close(minval(motions(i)%rms), 0.293_dp, 1e-3_dp, 'and of the other')
         motion = motions(i)
         call refine(train, motion, error)
         call tests%is_true(.not. allocated(error) .and. motion%stable, 'stable by shooting')
         call tests%is_close(maxval(abs(motion%rms - motions(i)%rms)), 0.0_dp, 5e-6_dp, 'shooting and balance, R = 12')
         if (found == 2) call tests%is_true(motions(i)%rms(1) > motions(i)%rms(2) .neqv. first_is_larger(motions), 'mirror images')
      end do
   end subroutine asymmetric_motions

   !> Largest real multiplier.
   pure real(dp) function largest_real(motion)
      type(motion_type), intent(in) :: motion

      associate (multipliers => motion%multipliers)
         largest_real = maxval(multipliers%re, abs(multipliers%im) <= 0)
      end associate
   end function largest_real

   !> Of the first stable motion.
   pure logical function first_is_larger(motions)
      type(motion_type), intent(in) :: motions(:)
      integer :: i

      first_is_larger = .false.
      do i = size(motions), 1, -1
         if (motions(i)%stable) first_is_larger = motions(i)%rms(1) > motions(i)%rms(2)
      end do
   end function first_is_larger

   !> Doublings and branch points followed together, of more harmonics than are eliminated: no branch is there twice, each ends at
   !> another one or closes.
   subroutine each_crossing_once(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(branch_type), allocatable :: branches(:)
      type(response_settings_type) :: settings
      type(error_type), allocatable :: error
      integer :: i

      settings = settings_of(1.2_dp, 2.6_dp, 12)
      settings%period_doublings = 1
      settings%branch_points = .true.
      call response(equal_stages(1e5_dp, 0.0_dp), settings, branch, error)
      call follow_bifurcations(equal_stages(1e5_dp, 0.0_dp), settings, branch, branches, error)
      ! From 1.922 to 2.150 and from 2.018 to 2.228; and one that crosses the first at 1.920 and 1.394, one both at 2.149 and 1.554.
      call tests%is_true(size(branches) == 4, 'four branches of period 2')
      do i = 1, size(branches)
         call tests%is_true(branches(i)%subharmonic == 2 .and. branches(i)%complete, 'each to its end: '//branches(i)%ended%text)
      end do
   end subroutine each_crossing_once

   !> Neither the first step backwards from a seed nor the last one to a bound loses a change of stability.
   subroutine seeds_and_bounds(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: whole, branch
      type(motion_type), allocatable :: seeds(:)
      type(error_type), allocatable :: error
      real(dp), parameter :: at(*) = [1.7491_dp, 1.7493_dp, 1.75_dp, 1.752_dp, 2.04_dp, 2.05_dp]
      real(dp), allocatable :: doublings(:)
      integer :: i

      call response(paper_train(), settings_of(1.5_dp, 2.6_dp, 6), whole, error)
      doublings = places(whole, 'period doubling')
      call tests%is_true(size(doublings) == 2, 'two doublings')
      if (size(doublings) /= 2) return
      do i = 1, size(at)
         call solutions_at(paper_train(), settings_of(1.5_dp, 2.6_dp, 6), whole, at(i), seeds, error)
         call response(paper_train(), settings_of(1.5_dp, 2.6_dp, 6), branch, error, seed=seeds(1))
         call check(branch, 'from a seed')
      end do
      call response(paper_train(), settings_of(1.7_dp, 1.75_dp, 6), branch, error)
      call tests%is_true(size(places(branch, 'period doubling')) == 1, 'in the last step to the upper bound')
      call response(paper_train(), settings_of(1.76_dp, 1.749_dp, 6), branch, error)
      call tests%is_true(size(places(branch, 'period doubling')) == 1, 'and to the lower one')

   contains

      subroutine check(branch, name)
         type(branch_type), intent(in) :: branch
         character(*), intent(in) :: name
         real(dp), allocatable :: found(:)
         integer :: k

         found = places(branch, 'period doubling')
         call tests%is_true(size(found) == 2, name//': both doublings')
         if (size(found) /= 2) return
         call tests%is_close(maxval(abs(found - doublings)), 0.0_dp, 1e-7_dp, name//': in their places')
         associate (special => branch%special_points)
            call tests%is_true(all(special(2:)%point >= special(:size(special) - 1)%point), name//': along the branch')
            do k = 1, size(special)
               if (special(k)%kind /= 'period doubling') cycle
               associate (before => branch%frequency_ratio(special(k)%point), after => branch%frequency_ratio(special(k)%point + 1))
                  call tests%is_true((special(k)%frequency_ratio - before)*(special(k)%frequency_ratio - after) <= 0, &
                                     name//': between its points')
               end associate
            end do
         end associate
      end subroutine check

   end subroutine seeds_and_bounds

   !> A closed branch has each motion once, that which it was traced from as well.
   subroutine closed_once(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: branch, island
      type(branch_type), allocatable :: branches(:)
      type(response_settings_type) :: settings
      type(motion_type), allocatable :: motions(:)
      type(error_type), allocatable :: error
      integer :: i

      train = equal_stages(1e5_dp, 0.0_dp)
      settings = settings_of(0.7_dp, 1.1_dp, 6)
      settings%branch_points = .true.
      settings%stability = .false.
      call response(train, settings, branch, error)
      call follow_bifurcations(train, settings, branch, branches, error)
      call tests%is_true(size(branches) == 1, 'found without stability as well')
      if (size(branches) /= 1) return
      call solutions_at(train, settings, branches(1), 0.86_dp, motions, error)
      do i = 1, size(motions)
         call response(train, settings, island, error, seed=motions(i))
         call tests%is_true(island%closed, 'closed from any of its motions')
         call tests%is_close(island%frequency_ratio(island%points), 0.86_dp, 0.0_dp, 'at exactly the Lambda that it began with')
         call tests%is_true(count_at(0.86_dp) == size(motions), 'the seed counts once')
         call tests%is_true(count_at(0.86_dp - 1e-13_dp) == size(motions) .and. count_at(0.86_dp + 1e-13_dp) == size(motions), &
                            'and next to it')
      end do

   contains

      integer function count_at(frequency_ratio)
         real(dp), intent(in) :: frequency_ratio
         type(motion_type), allocatable :: again(:)

         call solutions_at(train, settings, island, frequency_ratio, again, error)
         count_at = size(again)
      end function count_at

   end subroutine closed_once

   !> Where mesh 2 of figure 3 ceases to separate: found by shooting at 1.1027590, where its smallest displacement is b.
   subroutine contact_edge(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(motion_type), allocatable :: motions(:)
      type(motion_type) :: motion
      type(band_type), allocatable :: ranges(:)
      type(error_type), allocatable :: error
      integer, parameter :: harmonics(3) = [6, 12, 24]
      integer :: i

      do i = 1, size(harmonics)
         call response(paper_train(), settings_of(0.9_dp, 1.4_dp, harmonics(i)), branch, error)
         call locate_contact_edges(paper_train(), settings_of(0.9_dp, 1.4_dp, harmonics(i)), branch)
         ranges = separation_ranges(branch, 2, .false.)
         call tests%is_true(size(ranges) == 1, 'mesh 2 separates in one range')
         if (size(ranges) /= 1) return
         call tests%is_close(ranges(1)%to, 1.1027590_dp, 1e-7_dp, 'the edge where it ceases to')
      end do
      call solutions_at(paper_train(), settings_of(0.9_dp, 1.4_dp, 24), branch, ranges(1)%to, motions, error)
      motion = motions(closest(motions, 0.0_dp))
      call refine(paper_train(), motion, error)
      call tests%is_close(motion%minimum(2), 1.0_dp, 1e-8_dp, 'by shooting the teeth just touch there')
   end subroutine contact_edge

end module validation_bifurcations
