!> Branches that no other one leads to, or that are joined to others only beyond the amplitude limit.
module hard_branches
   use fixtures, only: paper_train, settings_of
   use geartrain, only: attractors, attractors_settings_type, attractors_type, branch_type, dp, error_type, follow_attractors, &
                        motion_type, refine, response_settings_type, solutions_at, train_type
   use geartrain_readings_summary, only: folds
   use geartrain_trace_branch, only: arrange_points
   use readings, only: solve
   use testing, only: full, tests_type
   implicit none (type, external)
   private
   public :: branches_cases

contains

   subroutine branches_cases(tests)
      class(tests_type), intent(inout) :: tests

      call tests%heading('Branches on their own')
      if (tests%runs('between_far_points')) call between_far_points(tests)
      if (tests%runs('island_of_figure_9', full)) call island_of_figure_9(tests)
   end subroutine branches_cases

   !> Motions in a resonance between the only two points of a branch, against those from a branch that follows it.
   subroutine between_far_points(tests)
      class(tests_type), intent(inout) :: tests
      character(*), parameter :: name = 'a resonance between far points'
      type(train_type) :: train
      type(response_settings_type) :: settings
      type(branch_type) :: branch, far
      type(motion_type), allocatable :: expected(:), motions(:)
      type(error_type), allocatable :: error
      real(dp) :: off
      integer :: i

      train = paper_train()
      train%meshes%damping_ratio = 0.001_dp
      do i = 1, 2
         train%meshes(i)%stiffness_cos = [2e-4_dp]
      end do
      settings = settings_of(0.9_dp, 1.0_dp, 3)
      settings%stability = .false.
      branch = solve(train, settings)
      far = branch
      call arrange_points(far, [1, branch%points], 2)
      far%points = 2
      off = 0
      do i = 1, 19
         call solutions_at(train, settings, branch, 0.9_dp + 0.005_dp*i, expected, error)
         call solutions_at(train, settings, far, 0.9_dp + 0.005_dp*i, motions, error)
         call tests%holds(name, 'one motion', size(expected) == 1 .and. size(motions) == 1)
         if (size(expected) == 1 .and. size(motions) == 1) off = max(off, maxval(abs(motions(1)%rms - expected(1)%rms)))
      end do
      call tests%measured(name, 'rms of the meshes', off, 1e-10_dp)
   end subroutine between_far_points

   !> Figure 9 at zeta 0.01 has a closed branch of period 1, part of it beyond the amplitude limit, that is joined to no other. One
   !> of its motions attracts one random start in six at 0.85.
   subroutine island_of_figure_9(tests)
      class(tests_type), intent(inout) :: tests
      character(*), parameter :: name = 'closed branch of figure 9, zeta 0.01'
      type(train_type) :: train
      type(response_settings_type) :: settings
      type(attractors_type) :: found
      type(branch_type) :: once
      type(branch_type), allocatable :: branches(:)
      type(motion_type), allocatable :: motions(:)
      type(motion_type) :: exact
      type(error_type), allocatable :: error
      real(dp), allocatable :: at_fold(:)
      real(dp) :: off
      integer :: i

      train = paper_train()
      train%meshes%damping_ratio = 0.01_dp
      settings = settings_of(0.2_dp, 2.6_dp, 12)
      once = solve(train, settings)
      call attractors(train, attractors_settings_type(frequency=0.85_dp, starts=60), found, error)
      ! Branches of longer periods are there as well, some of them very long.
      found%motions = pack(found%motions, found%motions%period == 1)
      call follow_attractors(train, settings, found, once, branches, error)
      call tests%holds(name, 'found by random starts at 0.85, and on no other branch', size(branches) == 1)
      if (size(branches) /= 1) return
      associate (island => branches(1))
         call tests%holds(name, 'followed beyond the amplitude limit and back to where it began', &
                          island%closed .and. maxval(island%segment) == 2)
         at_fold = folds(island)
         call tests%holds(name, 'one fold', size(at_fold) == 1)
         if (size(at_fold) == 1) call tests%measured(name, 'its fold at R = 48', abs(at_fold(1) - 0.74431157_dp), 1e-5_dp)
         call solutions_at(train, settings, island, 0.8_dp, motions, error)
         call tests%holds(name, 'two motions at 0.8', size(motions) == 2)
         off = 0
         do i = 1, size(motions)
            exact = motions(i)
            call refine(train, exact, error)
            if (allocated(error)) exact%rms = huge(1.0_dp)
            off = max(off, maxval(abs(motions(i)%rms - exact%rms)))
         end do
         call tests%measured(name, 'shooting at 0.8: rms of the meshes', off, 2e-4_dp)
      end associate
   end subroutine island_of_figure_9

end module hard_branches
