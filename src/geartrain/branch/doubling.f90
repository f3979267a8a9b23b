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
   use geartrain_branch_path, only: place_type
   use geartrain_branch_start, only: begin_trace, place_of
   use geartrain_branch_tracer, only: cancelled, full, stuck, tracer_type
   use geartrain_branch_variables, only: settings_for
   use geartrain_model_check, only: check_train
   use geartrain_model_train, only: train_type
   use geartrain_motion_motion, only: motion_type
   implicit none (type, external)
   private
   public :: period_doubled

   !> Way along the critical vector to the first point, in the metric of the branch.
   real(dp), parameter :: first_step = 0.01_dp

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
      type(response_settings_type) :: twice
      type(tracer_type) :: tracer
      type(branch_type) :: empty
      type(place_type) :: place
      integer :: outcome
      logical :: success

      ! All is new but where it comes from.
      call move_alloc(doubled%origin, empty%origin)
      doubled = empty
      doubled%subharmonic = 2*branch%subharmonic
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
      twice = settings_for(settings, 2*settings%subharmonic)
      call begin_trace(train, twice, tracer)
      tracer%analysis = 'branch'
      if (twice%harmonics == 0) call tracer%prepare(2*branch%point_harmonics(branch%special_points(special)%point))
      call tracer%recorder%setup(tracer%path%balance, settings%stability, doubled)
      call start_place(tracer, branch, special, place, success)
      if (.not. success) then
         doubled%ended = 'no critical vector found at Lambda = '//text(branch%special_points(special)%frequency) &
                         //' (more harmonics place the doubling more exactly)'
         return
      end if
      call tracer%adapt(place, success)
      call tracer%record(place, doubled)
      call tracer%trace(place, min(settings%start, settings%stop), max(settings%start, settings%stop), settings%stop, &
                        doubled, outcome, doubled%ended, observer)
      doubled%complete = all(outcome /= [cancelled, stuck, full])
      call tracer%tell_missed(doubled)
      call tracer%recorder%finish(doubled)
   end subroutine period_doubled

   !> The doubling as a place of the doubled balance, the critical vector as its tangent: the solution v of
   !> [J b; c 0] [v; g] = [0; 1] with b and c on the odd harmonics, which the branch of half the period lacks.
   subroutine start_place(tracer, branch, special, place, success)
      type(tracer_type), intent(inout) :: tracer
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: special
      type(place_type), intent(out) :: place
      logical, intent(out) :: success
      type(motion_type) :: motion
      type(place_type) :: start
      real(dp) :: share, y, length
      integer :: i, k, point

      point = branch%special_points(special)%point
      share = 0
      associate (a => branch%frequency(point), b => branch%frequency(point + 1), f => branch%special_points(special)%frequency)
         if (abs(b - a) > 0) share = (f - a)/(b - a)
         motion%frequency = f
      end associate
      motion%period = branch%subharmonic
      motion%coefficients = (1 - share)*branch%coefficients(:, :, point) + share*branch%coefficients(:, :, point + 1)
      place = place_of(tracer, motion)
      associate (path => tracer%path, matrix => tracer%path%matrix)
         call path%balance%evaluate(place%u, place%frequency)
         call matrix%linearize(path%balance)
         allocate (place%tangent(path%balance%block, path%balance%unknowns), source=0.0_dp)
         do i = 1, path%balance%unknowns
            do k = 1, size(path%balance%harmonic), 2
               place%tangent(2*k:2*k + 1, i) = [1.0_dp, 0.7_dp]/path%balance%harmonic(k)
            end do
         end do
         matrix%column = place%tangent
         matrix%row = place%tangent
         matrix%corner = 0
         call matrix%factor(path%balance, success)
         if (.not. success) return
         place%tangent = 0
         y = 1
         call matrix%solve(path%balance, place%tangent, y)
         length = path%length_of(place%tangent)
         place%tangent = place%tangent/length
         place%tangent_frequency = 0
         ! The doubling itself is a singular point; the branch is recorded from a short way along it.
         start = place
         call path%advance(start, first_step, place, success)
      end associate
   end subroutine start_place

end module geartrain_branch_doubling
