!> Branch switching at period doublings: to period 2 and on to period 4, without a seed.
module validation_doubling
   use fixtures, only: closest, paper_train, settings_of
   use geartrain, only: attractors, attractors_settings_type, attractors_type, branch_type, dp, error_type, follow_attractors, &
                        follow_bifurcations, motion_type, period_doubled, refine, response, response_settings_type, solutions_at, &
                        train_type
   use testing, only: full, tests_type
   implicit none (type, external)
   private
   public :: doubling_tests

contains

   subroutine doubling_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('each_branch_once')) call each_branch_once(tests)
      if (tests%runs('doublings_in_pairs', full)) call doublings_in_pairs(tests)
      if (tests%runs('joined_parents')) call joined_parents(tests)
      if (tests%runs('island')) call island(tests)
      if (tests%runs('cascade')) call cascade(tests)
   end subroutine doubling_tests

   !> Period 1 to 2 to 4.
   subroutine cascade(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: once, twice, four
      type(response_settings_type) :: settings
      type(motion_type), allocatable :: motions(:)
      type(error_type), allocatable :: error
      integer :: i, last

      settings = settings_of(1.2_dp, 2.6_dp, 12)
      call response(paper_train(), settings, once, error)
      last = doubling(once, last=.true.)
      call tests%is_true(last > 0, 'the period-1 branch doubles its period')
      if (last == 0) return
      ! The upper doubling, where contact is never lost: the branch leaves vertically.
      ! Found independently: 2.044; the fourth decimal is this library's own.
      call tests%is_close(once%special_points(last)%frequency_ratio, 2.0438_dp, 2e-4_dp, 'upper doubling')
      call period_doubled(paper_train(), settings, once, last, twice, error)
      call tests%is_true(twice%complete .and. twice%points > 10, 'period 2: '//twice%ended%text)
      call tests%is_close(twice%frequency_ratio(1), once%special_points(last)%frequency_ratio, 1e-6_dp, 'it leaves vertically')

      settings%subharmonic = 2
      settings%harmonics = 24
      call solutions_at(paper_train(), settings, twice, 1.92_dp, motions, error)
      i = closest(motions, 0.45639898_dp)
      call tests%is_true(i > 0, 'period 2 at 1.92')
      if (i == 0) return
      call tests%is_true(motions(i)%stable, 'stable at 1.92')
      call refine(paper_train(), motions(i), error)
      ! Time-integrated values.
      call tests%is_close(motions(i)%rms(1), 0.45639898_dp, 6e-9_dp, 'rms of mesh 1 at 1.92')
      call tests%is_close(motions(i)%rms(2), 0.54946446_dp, 6e-9_dp, 'rms of mesh 2 at 1.92')

      i = doubling(twice, last=.false.)
      call tests%is_true(i > 0, 'the period-2 branch doubles again')
      if (i == 0) return
      call period_doubled(paper_train(), settings, twice, i, four, error)
      call tests%is_true(four%complete .and. four%subharmonic == 4, 'period 4: '//four%ended%text)
      call period_four_is_genuine(tests, four)
      call period_doubled(paper_train(), settings, twice, size(twice%special_points) + 1, four, error)
      call tests%is_true(allocated(error), 'no such special point: an error')
   end subroutine cascade

   !> Place of the first or the last period doubling among the special points of a branch; 0 without one. No findloc: of a
   !> component it makes a copy, which the run-time checks report.
   integer function doubling(branch, last)
      type(branch_type), intent(in) :: branch
      logical, intent(in) :: last
      integer :: i

      doubling = 0
      do i = 1, size(branch%special_points)
         if (branch%special_points(i)%kind /= 'period doubling') cycle
         doubling = i
         if (.not. last) return
      end do
   end function doubling

   !> The two doublings around 2 w_b are the ends of one branch, which is traced once, whatever the number of harmonics; those
   !> around 2 w_a are not: both their branches leave by the amplitude limit.
   subroutine each_branch_once(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: once
      type(branch_type), allocatable :: branches(:)
      type(response_settings_type) :: settings
      type(error_type), allocatable :: error
      integer :: harmonics, doublings

      do harmonics = 2, 12, 5
         settings = settings_of(1.7_dp, 4.2_dp, harmonics)
         settings%period_doublings = 1
         call response(paper_train(), settings, once, error)
         doublings = count(once%special_points%kind == 'period doubling')
         call follow_bifurcations(paper_train(), settings, once, branches, error)
         call tests%is_true(doublings == 4, 'four doublings')
         call tests%is_true(size(branches) == 3, 'three branches')
         call tests%is_true(all(branches%complete) .and. all(branches%subharmonic == 2), 'all complete, of period 2')
         if (size(branches) /= 3) return
         call tests%is_true(index(branches(3)%origin%text, 'period doubling of the response at Lambda = 3.5') == 1, &
                            branches(3)%origin%text)
         call tests%is_true(index(branches(3)%ended%text, 'met the branch of half its period') == 1, branches(3)%ended%text)
         deallocate (branches)
      end do

      ! The second generation: period 4, from a branch of period 2.
      settings = settings_of(1.2_dp, 2.6_dp, 12)
      settings%period_doublings = 2
      call response(paper_train(), settings, once, error)
      call follow_bifurcations(paper_train(), settings, once, branches, error)
      call tests%is_true(any(branches%subharmonic == 4) .and. all(branches%subharmonic <= 4), 'twice doubled, period 4')
      call tests%is_true(all(branches%harmonics == 12*branches%subharmonic), 'as many harmonics of Lambda')
      call tests%is_true(index(branches(size(branches))%origin%text, 'period doubling of branch ') == 1, &
                         branches(size(branches))%origin%text)
   end subroutine each_branch_once

   !> Every doubling of the two branches of period 2 is one end of one branch of period 4, with few harmonics as with many. Which
   !> doublings belong together does not depend on the harmonics; the multipliers place them independently of where the branches
   !> of period 4 begin and end. The one at 1.4458 lies so near to a fold that a step has both.
   !>
   !> The branches of period 4 double an even number of times: with M the monodromy matrix of period 2 at either end, that of
   !> period 4 is M**2 there, and det(M**2 + I) = |det(M + iI)|**2 is positive at both.
   subroutine doublings_in_pairs(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: once
      type(branch_type), allocatable :: branches(:), again(:)
      type(response_settings_type) :: settings
      type(error_type), allocatable :: error
      !> By the multipliers of 16 harmonics (of Lambda).
      real(dp), parameter :: pairs(2, 6) = reshape([1.2426_dp, 1.3624_dp, 1.4296_dp, 1.5003_dp, 1.4458_dp, 1.5333_dp, &
                                                    1.5121_dp, 1.7049_dp, 1.6098_dp, 1.7633_dp, 1.5181_dp, 1.6543_dp], [2, 6])
      !> Harmonics, and how far truncation leaves the doublings from those places: with 4 the one at 1.5333 is at 1.5384. Any two
      !> pairs are 0.03 apart at one end or the other. With 0, for a tolerance of 1e-3, they change along a branch, and four do for
      !> some of the doublings (1.51413 with 0 and with 4, 1.51214 with 12).
      integer, parameter :: harmonics(4) = [4, 6, 8, 0]
      real(dp), parameter :: accuracy(4) = [6e-3_dp, 1.5e-3_dp, 1e-3_dp, 6e-3_dp]
      !> Times that each pair was met.
      integer :: met(6), doublings
      real(dp) :: ends(2)
      integer :: i, j, k
      logical :: all_met

      do i = 1, size(harmonics)
         settings = settings_of(0.9_dp, 2.6_dp, harmonics(i))
         settings%tolerance = 1e-3_dp
         settings%period_doublings = 2
         call response(paper_train(), settings, once, error)
         if (allocated(branches)) deallocate (branches)
         call follow_bifurcations(paper_train(), settings, once, branches, error)
         met = 0
         all_met = .true.
         doublings = 0
         do j = 1, size(branches)
            do k = 1, size(branches(j)%special_points)
               associate (special => branches(j)%special_points(k))
                  if (branches(j)%subharmonic == 2 .and. special%kind == 'period doubling') then
                     all_met = all_met .and. any(abs(pairs - special%frequency_ratio) < accuracy(i))
                     doublings = doublings + 1
                  end if
               end associate
            end do
            associate (special => branches(j)%special_points)
               call tests%is_true(all(special(2:)%point >= special(:size(special) - 1)%point), 'special points along the branch')
               if (branches(j)%subharmonic == 4) &
                  call tests%is_true(mod(count(special%kind == 'period doubling'), 2) == 0, 'period 4 doubles in pairs')
            end associate
            if (branches(j)%subharmonic /= 4 .or. branches(j)%points < 2) cycle
            ends = [branches(j)%frequency_ratio(1), branches(j)%frequency_ratio(branches(j)%points)]
            where (maxval(abs(pairs - spread([minval(ends), maxval(ends)], 2, 6)), 1) < accuracy(i)) met = met + 1
         end do
         call tests%is_true(all_met .and. doublings == 12, 'each doubling of a branch of period 2 is in a pair')
         call tests%is_true(count(branches%subharmonic == 4) == 6 .and. all(met == 1), 'six branches of period 4 join them')
         call tests%is_true(all(branches%complete), 'each to its end')
         ! A run that is taken up again knows where the branches ended that it does not trace.
         if (allocated(again)) deallocate (again)
         call follow_bifurcations(paper_train(), settings, once, again, error, known=branches(:4))
         call tests%is_true(size(again) == size(branches), 'as many, four of them known')
         if (size(again) /= size(branches)) cycle
         call tests%is_true(all(again%points == branches%points), 'and the same')
      end do
   end subroutine doublings_in_pairs

   !> With gaps of 10 and 60 um the two branches of period 2 around 2 w_b do not meet within the amplitude limit, and one branch of
   !> period 4 leads from a doubling of the one to a doubling of the other. Its motions are there once; the two branches of period 2
   !> have three doublings, and the third one's branch leaves by the limit. At 3.4 its rms of mesh 1 is 1.687, and 1.782 that of
   !> the one that joins them.
   subroutine joined_parents(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: once
      type(branch_type), allocatable :: branches(:)
      type(response_settings_type) :: settings
      type(motion_type), allocatable :: motions(:)
      type(error_type), allocatable :: error
      integer :: i, j, doublings, at

      train = paper_train()
      train%meshes%half_backlash = [10e-6_dp, 60e-6_dp]
      settings = settings_of(2.6_dp, 4.3_dp, 12)
      settings%period_doublings = 2
      ! Beyond it there is a fourth doubling.
      settings%amplitude_limit = 12
      call response(train, settings, once, error)
      call follow_bifurcations(train, settings, once, branches, error)
      doublings = 0
      at = 0
      do i = 1, size(branches)
         if (branches(i)%subharmonic == 2) doublings = doublings + count(branches(i)%special_points%kind == 'period doubling')
         if (branches(i)%subharmonic /= 4) cycle
         settings%subharmonic = 4
         settings%harmonics = branches(i)%harmonics
         call solutions_at(train, settings, branches(i), 3.4_dp, motions, error)
         do j = 1, size(motions)
            if (abs(motions(j)%rms(1) - 1.782_dp) < 1e-2_dp) at = at + 1
         end do
      end do
      call tests%is_true(count(branches%subharmonic == 2) == 2 .and. doublings == 3, 'two branches of period 2, three doublings')
      call tests%is_true(count(branches%subharmonic == 4) == 2, 'one branch of period 4 joins two of them')
      call tests%is_true(at == 1, 'its motion at 3.4 is there once')
   end subroutine joined_parents

   !> A branch through an attractor is traced where it is on none that is known, and only once.
   subroutine island(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: once
      type(branch_type), allocatable :: branches(:)
      type(attractors_type) :: found
      type(error_type), allocatable :: error

      call response(paper_train(), settings_of(1.0_dp, 3.2_dp, 6), once, error)
      call attractors(paper_train(), attractors_settings_type(frequency=2.4_dp, starts=40), found, error)
      call follow_attractors(paper_train(), settings_of(1.0_dp, 3.2_dp, 6), found, once, branches, error)
      call tests%is_true(size(found%motions) == 2 .and. size(branches) == 1, 'two motions at 2.4, one of them on the response')
      if (size(branches) /= 1) return
      call tests%is_true(branches(1)%closed .and. branches(1)%complete .and. branches(1)%subharmonic == 3, 'a closed island')
      call tests%is_text(branches(1)%origin%text, 'attractor 2 at Lambda = 2.4', 'origin')
      call follow_attractors(paper_train(), settings_of(1.0_dp, 3.2_dp, 6), found, once, branches, error)
      call tests%is_true(size(branches) == 1, 'a second time nothing is new')
   end subroutine island

   !> Shooting over four periods of the fundamental from a point of the branch converges to an orbit that does not repeat after two.
   subroutine period_four_is_genuine(tests, four)
      class(tests_type), intent(inout) :: tests
      type(branch_type), intent(in) :: four
      type(motion_type) :: motion
      type(error_type), allocatable :: error
      integer :: middle, k
      real(dp) :: odd

      middle = four%points/2
      motion%frequency_ratio = four%frequency_ratio(middle)
      motion%period = 4
      motion%coefficients = four%coefficients(:, :, middle)
      call refine(paper_train(), motion, error)
      call tests%is_true(.not. allocated(error), 'shooting on period 4 converges')
      if (allocated(error)) return
      call tests%is_close(maxval(abs(motion%rms - four%rms(:, middle))), 0.0_dp, 2e-3_dp, 'period 4: shooting and balance')
      odd = 0
      do k = 1, (size(motion%coefficients, 1) - 1)/2, 2
         odd = max(odd, maxval(abs(motion%coefficients(2*k:2*k + 1, :))))
      end do
      call tests%is_true(odd > 1e-2_dp, 'odd harmonics of Lambda/4 are there')
   end subroutine period_four_is_genuine

end module validation_doubling
