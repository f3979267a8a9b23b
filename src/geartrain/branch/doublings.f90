!> All branches that follow from the period doublings of a branch, generation by generation.
module geartrain_branch_doublings
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_branch_branch, only: branch_type, response_settings_type
   use geartrain_branch_doubling, only: trace_doubled
   use geartrain_branch_doubling_point, only: find_doubling, find_meeting, same_doubling
   use geartrain_branch_path, only: place_type
   use geartrain_branch_units, only: units_of, units_type
   use geartrain_branch_variables, only: settings_for
   use geartrain_model_check, only: check_train
   use geartrain_model_system, only: build_system, system_type
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: follow_doublings, add_branch

   !> Doublings farther apart in Lambda than this, in the unit of the branch, are different whatever the harmonics.
   real(dp), parameter :: near = 0.05_dp

contains

   !> Appends to `branches` those of twice the period that leave `branch`, then those that leave these, and so on,
   !> settings%period_doublings times. A branch that ends at another doubling, of its parent or of another one, is traced once.
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
      type(branch_type), allocatable :: earlier(:)
      type(branch_type) :: parent
      !> Where the branches of this generation begin and end.
      type(place_type), allocatable :: places(:)
      integer :: generation, first, last, i, count

      if (.not. allocated(branches)) allocate (branches(0))
      call check_train(train, error)
      if (allocated(error)) return
      allocate (earlier(0))
      if (present(known)) earlier = known
      last = size(branches)
      if (settings%period_doublings > 0) then
         allocate (places(2*size(branch%special_points)))
         count = 0
         call follow(train, settings, branch, 'the response', places, count, branches, observer, earlier)
      end if
      do generation = 2, settings%period_doublings
         first = last + 1
         last = size(branches)
         count = 0
         do i = first, last
            if (allocated(branches(i)%special_points)) count = count + size(branches(i)%special_points)
         end do
         deallocate (places)
         allocate (places(2*count))
         count = 0
         do i = first, last
            if (branches(size(branches))%cancelled) return
            ! A copy, because the list moves when it grows.
            parent = branches(i)
            call follow(train, settings_for(settings, parent%subharmonic), parent, 'branch '//text(i), places, count, &
                        branches, observer, earlier)
         end do
      end do
   end subroutine follow_doublings

   !> One generation: the branches that leave `parent`.
   subroutine follow(train, settings, parent, name, places, count, branches, observer, known)
      type(train_type), intent(in) :: train
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: parent
      character(*), intent(in) :: name
      !> Where the branches of this generation begin and end, so far `count` of them; room for two a doubling.
      type(place_type), intent(inout) :: places(:)
      integer, intent(inout) :: count
      type(branch_type), allocatable, intent(inout), target :: branches(:)
      class(observer_type), intent(inout), optional :: observer
      !> The first of `branches`, which another run has traced.
      type(branch_type), intent(in) :: known(:)
      type(place_type) :: place
      type(system_type) :: system
      type(units_type) :: units
      logical :: found, met
      integer :: i, n

      call build_system(train, system)
      units = units_of(system)
      do i = 1, size(parent%special_points)
         if (parent%special_points(i)%kind /= 'period doubling') cycle
         if (train%interrupt%raised()) return
         call find_doubling(train, settings, parent, i, place, found)
         if (found) then
            if (is_among(train, settings, parent, i, place, places(:count), units)) cycle
            count = count + 1
            places(count) = place
         end if
         call add_branch(branches, 'period doubling of '//name//' at Lambda = '//text(parent%special_points(i)%frequency))
         n = size(branches)
         if (n <= size(known)) then
            branches(n) = known(n)
         else
            call trace_doubled(train, settings, parent, i, place, found, branches(n), observer)
         end if
         if (branches(n)%cancelled) return
         call find_meeting(train, settings_for(settings, 2*parent%subharmonic), branches(n), place, met)
         if (.not. met) cycle
         count = count + 1
         places(count) = place
      end do
   end subroutine follow

   !> Whether doubling number `special` of `parent`, found at `place`, is one of `places`. Where the number of harmonics is left to
   !> the program the same doubling may be at another place for each number: it is found again with that of the other.
   logical function is_among(train, settings, parent, special, place, places, units)
      type(train_type), intent(in) :: train
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: parent
      integer, intent(in) :: special
      type(place_type), intent(in) :: place, places(:)
      type(units_type), intent(in) :: units
      type(place_type) :: again
      logical :: found
      integer :: i

      is_among = .false.
      do i = 1, size(places)
         is_among = same_doubling(place, places(i), parent%subharmonic, units)
         if (is_among) return
         if (size(place%u, 1) == size(places(i)%u, 1)) cycle
         if (abs(place%frequency - places(i)%frequency) > near*units%frequency) cycle
         call find_doubling(train, settings, parent, special, again, found, harmonics=size(places(i)%u, 1)/4)
         if (found) is_among = same_doubling(again, places(i), parent%subharmonic, units)
         if (is_among) return
      end do
   end function is_among

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

end module geartrain_branch_doublings
