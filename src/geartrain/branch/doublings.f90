!> All branches that follow from the period doublings of a branch, generation by generation.
module geartrain_branch_doublings
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_branch_branch, only: branch_type, response_settings_type
   use geartrain_branch_doubling, only: period_doubled
   use geartrain_branch_units, only: units_of, units_type
   use geartrain_branch_variables, only: settings_for
   use geartrain_model_system, only: build_system, system_type
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: follow_doublings, add_branch, is_known

   !> A doubled branch ends at that doubling of its parent which is this close in the metric of the branch. The truncated balance
   !> and the monodromy do not place a doubling alike: measured on figure 12 and on a single pair with kappa = 0.6 they are 2e-6
   !> to 9e-4 apart with 6 harmonics or more, 0.02 with 3; different doublings are 0.15 apart or more.
   real(dp), parameter :: same_place = 0.05_dp

contains

   !> Appends to `branches` those of twice the period that leave `branch`, then those that leave these, and so on,
   !> settings%period_doublings times. A branch that ends at another doubling of its parent is traced once.
   subroutine follow_doublings(train, settings, branch, branches, error, observer, known)
      type(train_type), intent(in) :: train
      !> Those that `branch` was traced with.
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: branch
      !> A target: an observer may read them through a pointer. Not allocated: there are none yet.
      type(branch_type), allocatable, intent(inout), target :: branches(:)
      type(error_type), allocatable, intent(out) :: error
      class(observer_type), intent(inout), optional :: observer
      !> The first of them, where another run has traced these already.
      type(branch_type), intent(in), optional :: known(:)
      type(branch_type) :: parent
      integer :: generation, first, last, i

      if (.not. allocated(branches)) allocate (branches(0))
      last = size(branches)
      if (settings%period_doublings > 0) &
         call follow(train, settings, branch, 'the response', branches, error, observer, known)
      do generation = 2, settings%period_doublings
         first = last + 1
         last = size(branches)
         do i = first, last
            if (allocated(error) .or. branches(size(branches))%cancelled) return
            ! A copy, because the list moves when it grows.
            parent = branches(i)
            call follow(train, settings_for(settings, parent%subharmonic), parent, 'branch '//text(i), branches, error, observer, &
                        known)
         end do
      end do
   end subroutine follow_doublings

   !> One generation: the branches that leave `parent`.
   subroutine follow(train, settings, parent, name, branches, error, observer, known)
      type(train_type), intent(in) :: train
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: parent
      character(*), intent(in) :: name
      type(branch_type), allocatable, intent(inout), target :: branches(:)
      type(error_type), allocatable, intent(inout) :: error
      class(observer_type), intent(inout), optional :: observer
      type(branch_type), intent(in), optional :: known(:)
      type(system_type) :: system
      logical :: met(size(parent%special_points))
      integer :: i, n

      call build_system(train, system)
      met = .false.
      do i = 1, size(parent%special_points)
         if (parent%special_points(i)%kind /= 'period doubling' .or. met(i)) cycle
         call add_branch(branches, 'period doubling of '//name//' at Lambda = '//text(parent%special_points(i)%frequency))
         n = size(branches)
         if (is_known(n, known)) then
            branches(n) = known(n)
         else
            call period_doubled(train, settings, parent, i, branches(n), error, observer)
         end if
         if (allocated(error)) return
         if (branches(n)%cancelled) return
         call mark_end(parent, branches(n), i, units_of(system), met)
      end do
   end subroutine follow

   !> Whether branch n is among those that another run has traced.
   pure logical function is_known(n, known)
      integer, intent(in) :: n
      type(branch_type), intent(in), optional :: known(:)

      is_known = .false.
      if (present(known)) is_known = n <= size(known)
   end function is_known

   !> Room for one more branch.
   subroutine add_branch(branches, origin)
      type(branch_type), allocatable, intent(inout), target :: branches(:)
      character(*), intent(in) :: origin
      type(branch_type), allocatable :: longer(:)
      integer :: i

      allocate (longer(size(branches) + 1))
      do i = 1, size(branches)
         longer(i) = branches(i)
      end do
      longer(size(longer))%origin = origin
      call move_alloc(longer, branches)
   end subroutine add_branch

   !> Marks the doubling of `parent`, other than number `start`, at which `doubled` ends, if it does.
   subroutine mark_end(parent, doubled, start, units, met)
      type(branch_type), intent(in) :: parent, doubled
      integer, intent(in) :: start
      type(units_type), intent(in) :: units
      logical, intent(inout) :: met(:)
      real(dp) :: here(size(parent%coefficients, 1), parent%meshes), place(size(parent%coefficients, 1), parent%meshes)
      real(dp) :: share, frequency, away, nearest
      integer :: i, closest

      call meeting(doubled, share, frequency, here)
      if (share < 0) return
      nearest = same_place
      closest = 0
      do i = 1, size(met)
         if (i == start .or. parent%special_points(i)%kind /= 'period doubling') cycle
         call between(parent, i, place)
         away = sqrt((sum((place(1, :) - here(1, :))**2) + 0.5_dp*sum((place(2:, :) - here(2:, :))**2))/units%length**2 &
                     + ((parent%special_points(i)%frequency - frequency)/units%frequency)**2)
         if (away > nearest) cycle
         nearest = away
         closest = i
      end do
      if (closest > 0) met(closest) = .true.
   end subroutine mark_end

   !> Where the odd harmonics vanish between the last two points of a branch, and the even ones there, which are all the
   !> harmonics of the branch of half the period; share < 0 where they do not vanish.
   pure subroutine meeting(branch, share, frequency, coefficients)
      type(branch_type), intent(in) :: branch
      real(dp), intent(out) :: share, frequency, coefficients(:, :)
      real(dp) :: product, before, after
      integer :: j, k, n

      share = -1
      frequency = 0
      coefficients = 0
      n = branch%points
      if (n < 2) return
      product = 0
      before = 0
      after = 0
      do k = 1, branch%harmonics, 2
         associate (a => branch%coefficients(2*k:2*k + 1, :, n - 1), b => branch%coefficients(2*k:2*k + 1, :, n))
            product = product + sum(a*b)
            before = before + sum(a**2)
            after = after + sum(b**2)
         end associate
      end do
      if (product >= 0) return
      share = sqrt(before)/(sqrt(before) + sqrt(after))
      frequency = (1 - share)*branch%frequency(n - 1) + share*branch%frequency(n)
      coefficients(1, :) = (1 - share)*branch%coefficients(1, :, n - 1) + share*branch%coefficients(1, :, n)
      do j = 1, min((size(coefficients, 1) - 1)/2, branch%harmonics/2)
         k = 2*j
         coefficients(2*j:2*j + 1, :) = (1 - share)*branch%coefficients(2*k:2*k + 1, :, n - 1) &
                                        + share*branch%coefficients(2*k:2*k + 1, :, n)
      end do
   end subroutine meeting

   !> The coefficients of a branch at its special point number i, which lies between two points.
   pure subroutine between(branch, i, coefficients)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: i
      real(dp), intent(out) :: coefficients(:, :)
      real(dp) :: share
      integer :: point

      point = branch%special_points(i)%point
      share = 0
      associate (a => branch%frequency(point), b => branch%frequency(point + 1))
         if (abs(b - a) > 0) share = (branch%special_points(i)%frequency - a)/(b - a)
      end associate
      coefficients = (1 - share)*branch%coefficients(:, :, point) + share*branch%coefficients(:, :, point + 1)
   end subroutine between

end module geartrain_branch_doublings
