!> An audit of a branch: random points and all special points are solved anew by shooting. They are spread over threads and do not
!> depend on one another, so that the numbers do not depend on how many threads there are.
module geartrain_exact_audit
   use geartrain_base_error, only: error_type, fatal
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_base_random, only: begin_random, generator_type
   use geartrain_exact_audit_point, only: audit_point
   use geartrain_exact_audit_result, only: audit_row_type, audit_type, sum_up
   use geartrain_exact_audit_special_point, only: audit_special_point
   use geartrain_exact_exact_point, only: branch_with_multipliers
   use geartrain_exact_orbit_corrector, only: orbit_corrector_type, orbit_type
   use geartrain_network_check_coupling, only: refuse_friction_of
   use geartrain_network_check_train, only: check_train
   use geartrain_network_long_period, only: refuse_long_period
   use geartrain_network_system, only: build_system, system_type
   use geartrain_trace_branch, only: branch_type
   use geartrain_trace_decided, only: rests_on_undecided
   use geartrain_trace_points, only: repeats_of
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: audit_branch

   !> Special points of the exact branch nearer to each other than `same`, in the units of units_type, are equal.
   real(dp), parameter :: same = 1e-6_dp

contains

   !> Audits random points of a branch and all special points.
   subroutine audit_branch(train, branch, points, random_seed, audit, error, observer)
      !> The train of the branch.
      type(train_type), intent(in) :: train
      !> The branch.
      type(branch_type), intent(in) :: branch
      !> Number of points to audit, >= 0, all points of a shorter branch; seed of the random numbers that choose the points.
      integer, intent(in) :: points, random_seed
      !> What was found.
      type(audit_type), intent(out) :: audit
      type(error_type), allocatable, intent(out) :: error
      !> Told of each row of 'audit', by one thread at a time; may end it.
      class(observer_type), intent(inout), optional :: observer
      type(orbit_corrector_type) :: corrector
      type(system_type), target :: system
      type(orbit_type), allocatable :: exact(:)
      integer, allocatable :: chosen(:)
      logical, allocatable :: is_done(:)
      integer :: n
      logical :: keep_going

      call check_train(train, error)
      if (.not. allocated(error)) call refuse_friction_of(train, 'audit: points', error)
      if (allocated(error)) return
      if (points < 0) then
         call fatal(error, 'audit: points = '//text(points)//': must be >= 0')
         return
      end if
      if (allocated(branch%parameter)) then
         call fatal(error, 'audit: of a branch over a frequency, not over a parameter')
         return
      end if
      call refuse_long_period(train, 'audit: solves anew over whole periods', 'take '//branch_with_multipliers, &
                              branch%states > 0, error)
      if (allocated(error)) return
      call build_system(train, system)
      chosen = draw(branch, points, random_seed)
      n = size(chosen)
      if (allocated(branch%special_points)) n = n + size(branch%special_points)
      allocate (audit%rows(n), exact(n))
      allocate (is_done(n), source=.false.)
      keep_going = .true.
      !$omp parallel
      call audit_share(train, branch, system, chosen, audit%rows, exact, is_done, keep_going, observer)
      !$omp end parallel
      n = repeats_of(branch, system)
      call corrector%setup(system, branch%subharmonic, n)
      call mark_twins(corrector, branch, exact, audit%rows)
      audit%cancelled = .not. keep_going
      audit%rows = pack(audit%rows, is_done)
      call sum_up(audit)
   end subroutine audit_branch

   !> What a thread of the team does.
   subroutine audit_share(train, branch, system, chosen, rows, exact, is_done, keep_going, observer)
      type(train_type), intent(in) :: train
      type(branch_type), intent(in) :: branch
      type(system_type), intent(in) :: system
      integer, intent(in) :: chosen(:)
      type(audit_row_type), intent(inout) :: rows(:)
      type(orbit_type), intent(inout) :: exact(:)
      logical, intent(inout) :: is_done(:), keep_going
      class(observer_type), intent(inout), optional :: observer
      type(orbit_corrector_type) :: corrector
      type(system_type), target :: own
      type(audit_row_type) :: row
      type(orbit_type) :: orbit
      integer :: i
      logical :: go

      own = system
      call corrector%setup(own, branch%subharmonic, repeats_of(branch, system))
      !$omp do schedule(dynamic)
      do i = 1, size(rows)
         !$omp atomic read
         go = keep_going
         if (.not. go) cycle
         row = audit_row_type()
         if (i <= size(chosen)) then
            row%point = chosen(i)
            call audit_point(corrector, branch, row)
         else
            call audit_special_point(corrector, branch, i - size(chosen), row, orbit)
         end if
         if (train%interrupt%raised()) then
            !$omp atomic write
            keep_going = .false.
            cycle
         end if
         !$omp critical (geartrain_audit)
         rows(i) = row
         if (row%exact_frequency > 0) exact(i) = orbit
         is_done(i) = .true.
         go = keep_going
         if (go .and. present(observer)) call observer%on_step('audit', count(is_done), row%frequency_ratio, go)
         !$omp atomic write
         keep_going = go
         !$omp end critical (geartrain_audit)
      end do
      !$omp end do
   end subroutine audit_share

   !> Indices of random points, ascending; no folds, which are audited as special points.
   function draw(branch, points, random_seed) result(chosen)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: points, random_seed
      integer, allocatable :: chosen(:)
      logical :: fold(branch%points), is_chosen(branch%points)
      integer, allocatable :: left(:)
      type(generator_type) :: generator
      integer :: i, k

      fold = .false.
      if (allocated(branch%special_points)) then
         do i = 1, size(branch%special_points)
            if (branch%special_points(i)%kind == 'fold') fold(branch%special_points(i)%point) = .true.
         end do
      end if
      left = pack([(i, i=1, branch%points)], .not. fold)
      is_chosen = .false.
      generator = begin_random(random_seed, 1)
      do i = 1, min(points, size(left))
         k = generator%one_of(size(left))
         is_chosen(left(k)) = .true.
         left = [left(:k - 1), left(k + 1:)]
      end do
      chosen = pack([(i, i=1, branch%points)], is_chosen)
   end function draw

   !> Marks special points of the branch that share a special point of the exact branch with a nearer special point of the branch.
   subroutine mark_twins(corrector, branch, exact, rows)
      type(orbit_corrector_type), intent(in) :: corrector
      type(branch_type), intent(in) :: branch
      !> The special point of the exact branch for each row; without states where none was found.
      type(orbit_type), intent(in) :: exact(:)
      type(audit_row_type), intent(inout) :: rows(:)
      integer :: i, k

      do i = 1, size(rows)
         do k = 1, size(rows)
            if (k == i .or. rows(k)%kind /= rows(i)%kind) cycle
            if (.not. (allocated(exact(i)%states) .and. allocated(exact(k)%states))) cycle
            if (corrector%distance(exact(i), exact(k)) > same) cycle
            associate (here => abs(rows(i)%frequency_ratio - rows(i)%exact_frequency), &
                       there => abs(rows(k)%frequency_ratio - rows(k)%exact_frequency))
               if (here < there .or. (here <= there .and. i < k)) cycle
            end associate
            rows(i)%verdict_wrong = rows(i)%kind == 'fold' .or. &
                                    .not. rests_on_undecided(branch, i - (size(rows) - size(branch%special_points)))
            rows(i)%finding = 'none but that of '//text(rows(k)%frequency_ratio)
            if (.not. rows(i)%verdict_wrong) rows(i)%finding = trim(rows(i)%finding)//', undecided'
         end do
      end do
   end subroutine mark_twins

end module geartrain_exact_audit
