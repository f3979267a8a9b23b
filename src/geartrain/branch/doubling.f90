!> From a branch that loses stability by period doubling to the branch of twice its period, without a seed.
!>
!> The system is exactly linear until a tooth separates, so such a branch leaves vertically: Lambda stays, the amplitude grows
!> until contact is lost. Steps along the critical vector of the doubled balance follow it there as any other branch.
module geartrain_branch_doubling
   use geartrain_base_error, only: error_type, fatal
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_branch_branch, only: branch_type, response_settings_type
   use geartrain_branch_doubling_point, only: find_doubling, harmonics_at
   use geartrain_branch_interruption, only: drop_step
   use geartrain_branch_path, only: place_type
   use geartrain_branch_start, only: begin_trace
   use geartrain_branch_tracer, only: cancelled, full, stuck, tracer_type
   use geartrain_branch_variables, only: settings_for
   use geartrain_model_check, only: check_train
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: period_doubled, trace_doubled

   !> Way along the critical vector to the first point, in the metric of the branch, and the least that is tried.
   real(dp), parameter :: first_step = 1e-3_dp, least_step = 1e-5_dp

contains

   !> Follows the branch of twice the period that leaves `branch` at its special point number `special`, a period doubling,
   !> within the range of `settings` (those that `branch` was traced with; harmonics and subharmonic are doubled), until it
   !> meets the branch of half its period again or leaves the range.
   subroutine period_doubled(train, settings, branch, special, doubled, error, observer)
      type(train_type), intent(in) :: train
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: special
      type(branch_type), intent(inout), target :: doubled
      type(error_type), allocatable, intent(out) :: error
      class(observer_type), intent(inout), optional :: observer
      type(place_type) :: place
      logical :: success

      call check_train(train, error)
      if (allocated(error)) return
      if (special < 1 .or. special > size(branch%special_points)) then
         call fatal(error, 'special = '//text(special)//': the branch has '//text(size(branch%special_points)) &
                    //' special points')
         return
      end if
      if (branch%special_points(special)%kind /= 'period doubling') then
         call fatal(error, 'special = '//text(special)//': a '//trim(branch%special_points(special)%kind) &
                    //', not a period doubling')
         return
      end if
      call find_doubling(train, settings, branch, special, place, success)
      call trace_doubled(train, settings, branch, special, place, success, doubled, observer)
   end subroutine period_doubled

   !> The same from the balance's own doubling, as `find_doubling` gives it.
   subroutine trace_doubled(train, settings, branch, special, doubling, found, doubled, observer)
      type(train_type), intent(in) :: train
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: special
      type(place_type), intent(in) :: doubling
      !> Whether there is such a doubling.
      logical, intent(in) :: found
      type(branch_type), intent(inout), target :: doubled
      class(observer_type), intent(inout), optional :: observer
      type(response_settings_type) :: twice
      type(tracer_type) :: tracer
      type(branch_type) :: empty
      type(place_type) :: place
      real(dp) :: h
      integer :: outcome
      logical :: success

      ! All is new but where it comes from.
      call move_alloc(doubled%origin, empty%origin)
      doubled = empty
      doubled%subharmonic = 2*branch%subharmonic
      twice = settings_for(settings, 2*settings%subharmonic)
      call begin_trace(train, twice, tracer)
      tracer%analysis = 'branch'
      if (twice%harmonics == 0) call tracer%prepare(2*harmonics_at(branch, special))
      call tracer%recorder%setup(tracer%path%balance, settings%stability, doubled)
      if (.not. found) then
         doubled%ended = 'the balance has no doubling of its own near Lambda = ' &
                         //text(branch%special_points(special)%frequency)//' (more harmonics place it more exactly)'
         call drop_step(tracer, doubled)
         call tracer%recorder%finish(doubled)
         return
      end if
      ! The doubling itself is a singular point; the branch is recorded from a short way along it.
      h = first_step
      do
         call tracer%path%advance(doubling, h, place, success)
         h = h/3
         if (success .or. h < least_step) exit
      end do
      if (.not. success) then
         call tracer%recorder%finish(doubled)
         doubled%ended = 'no branch found along the critical vector at Lambda = '//text(doubling%frequency)
         call drop_step(tracer, doubled)
         return
      end if
      call tracer%adapt(place, success)
      call tracer%record(place, doubled)
      call tracer%trace(place, min(settings%start, settings%stop), max(settings%start, settings%stop), settings%stop, &
                        doubled, outcome, doubled%ended, observer)
      doubled%complete = all(outcome /= [cancelled, stuck, full])
      call tracer%tell_missed(doubled)
      call drop_step(tracer, doubled)
      call tracer%recorder%finish(doubled)
   end subroutine trace_doubled

end module geartrain_branch_doubling
