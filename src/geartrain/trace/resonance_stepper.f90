!> Steps that pass resonances narrower than themselves: a step is refused where the branch is off its cubic there, or ends there
!> where only what is read off the branch has a resonance, as the torque of a light disc on a shaft of little damping.
module geartrain_trace_resonance_stepper
   use geartrain_balance_tail_harmonics, only: tail_harmonics
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_cubic, only: share_at
   use geartrain_trace_adaptive_corrector, only: adaptive_corrector_type
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_trace_narrow_resonances, only: narrow_resonances_type
   use geartrain_trace_readings_at, only: coarser, count_readings, find_readings, floors, swings
   use geartrain_trace_step_geometry, only: arc_length, go_along
   use geartrain_trace_step_length, only: carries_same, curve_limit
   implicit none (type, external)
   private
   public :: resonance_stepper_type

   !> Distance from the cubic through the ends of a step at which it passes a resonance unseen, over the limit of a cubic [1].
   real(dp), parameter :: off_cubic = 5
   !> Distance from the cubic over the motion at the ends of the step from which on a resonance stands out of it; least share of the
   !> distance above that matters [1].
   real(dp), parameter :: visible = 0.1_dp, hidden = 0.01_dp
   !> Height of a reading above its values at the ends of the step, over them, from which on it stands out [1].
   real(dp), parameter :: stands = 0.02_dp
   !> Share of a reading by a harmonic that is not carried, at its resonance, from which on a point shows it; share at the beginning
   !> of a step below which it is too small there [1].
   real(dp), parameter :: lacking = 0.1_dp, faint = 1e-5_dp
   !> Distance from a resonance over its half width at which a point is at it [1].
   real(dp), parameter :: at_it = 1e-6_dp

   type, extends(adaptive_corrector_type) :: resonance_stepper_type
      !> Resonances that a step may be wider than.
      type(narrow_resonances_type) :: resonances
   contains
      procedure :: pass_resonances
   end type resonance_stepper_type

contains

   !> Looks at the resonances within a step without a fold that are narrower than the step. The amplitude of a mode over its
   !> amplitude in resonance is the half width over the distance from there. So the ends bound the motion in between, unless both
   !> are next to an antiresonance; for harmonics that they do not carry, its size follows from the error estimate at the resonance.
   !> It matters where the curve promises as much, or where the motion or a reading stands out of what it is at the ends.
   !> Where teeth part a resonance is as wide as the branch is bent, and the branch is followed through it.
   subroutine pass_resonances(self, here, next, torques, passes, at, stops)
      class(resonance_stepper_type), intent(inout) :: self
      !> The ends, with their tangents.
      type(solution_point_type), intent(in) :: here, next
      !> Torques of shafts and forces of bearings are read.
      logical, intent(in) :: torques
      !> The branch is off the cubic at a resonance: the step is too long.
      logical, intent(out) :: passes
      !> Lambda, or the parameter, where the step is to end.
      real(dp), intent(out) :: at
      !> It is to end there, before `next`.
      logical, intent(out) :: stops
      real(dp) :: limit, off, felt
      type(solution_point_type) :: guess, solution
      integer, allocatable :: harmonic(:)
      !> Readings at both ends and at a resonance, (coefficient, reading, place); not allocated: not known.
      real(dp), allocatable :: readings(:, :, :), swing(:), least(:)
      integer :: h, n
      logical :: carried, matters, moved, reads, success

      passes = .false.
      stops = .false.
      at = 0
      if (.not. carries_same(here, next)) return
      moved = .false.
      associate (c => self%corrector, ends => [here%frequency_ratio, next%frequency_ratio], found => self%resonances)
         reads = torques .or. c%balance%unknowns < c%balance%system%meshes
         if (.not. found%known) call found%setup(c%balance)
         harmonic = next%harmonic
         if (merge(reads, .not. c%balance%parts(), self%settings%harmonics > 0)) &
            harmonic = [harmonic, tail_harmonics(c%balance, next%frequency_ratio)]
         limit = off_cubic*curve_limit(c, next)
         limit = min(limit, max(visible*max(motion(here), motion(next)), hidden*limit))
         do h = 1, size(harmonic)
            carried = h <= size(next%harmonic)
            felt = 1
            if (.not. carried .and. self%settings%harmonics > 0) then
               felt = coarser*self%estimate%felt_at(harmonic(h))
               if (felt < faint) cycle
            end if
            call found%find(c%balance, harmonic(h), ends)
            do n = 1, found%number
               associate (place => found%at(n), half_width => found%half_width(n))
                  if (abs(ends(1) - place) < at_it*half_width .or. abs(ends(2) - place) < at_it*half_width) then
                     ! The peak is met; its other flank is not, unless it is a peak of the motion, which has points beside it.
                     if (reads .and. carried .and. abs(ends(1) - place) < at_it*half_width) call stop_beside(place, half_width)
                     cycle
                  end if
                  matters = felt*abs(ends(1) - place) > lacking*half_width
                  if (carried) then
                     matters = max(norm2(here%u(2*h:2*h + 1, :))*abs(ends(1) - place), &
                                   norm2(next%u(2*h:2*h + 1, :))*abs(ends(2) - place)) > half_width*limit*c%units%length
                     if (reads .and. .not. matters) matters = may_stand_out()
                  end if
                  if (.not. matters) cycle
                  guess = here
                  call go_along(here, next, share_at(ends, [here%tangent_frequency, next%tangent_frequency] &
                                                     *arc_length(here, next, c%units), place), c%units, guess)
                  guess%frequency_ratio = place
                  solution = guess
                  call c%solve_at(solution, success)
                  moved = .true.
                  passes = .not. (success .or. c%balance%system%interrupt%raised())
                  if (success) then
                     off = c%length_of(solution%u - guess%u)
                     if (.not. carried) then
                        call self%estimate_error(solution)
                        if (self%settings%harmonics == 0) then
                           off = max(off, self%estimate%limited*norm2(solution%u(2:, :))/c%units%length)
                        else if (self%estimate%missing > lacking .and. off <= limit) then
                           call stop_beside(place, half_width)
                        end if
                     end if
                     passes = off > limit
                  end if
                  ! With given harmonics the step stays: whether this resonance is looked at follows from the latest estimate.
                  passes = passes .and. (carried .or. self%settings%harmonics == 0)
                  if (passes) return
                  if (.not. (success .and. reads .and. carried)) cycle
                  if (stands_out()) call stop_beside(place, half_width)
               end associate
            end do
         end do
         if (.not. moved) return
         ! The corrector goes back to the end of the step.
         solution = next
         call c%correct(solution, success)
         passes = .not. (success .or. c%balance%system%interrupt%raised())
      end associate

   contains

      !> Lets the step end at the first of the peak and its flanks, unless another resonance lets it end before.
      subroutine stop_beside(place, half_width)
         real(dp), intent(in) :: place, half_width
         real(dp) :: way, ahead
         integer :: k

         do k = -1, 1
            ahead = sign(1.0_dp, next%frequency_ratio - here%frequency_ratio)
            way = (place + k*half_width - here%frequency_ratio)*ahead
            if (way < at_it*half_width .or. way > abs(next%frequency_ratio - here%frequency_ratio) - at_it*half_width) cycle
            if (stops) then
               if (way >= (at - here%frequency_ratio)*ahead) cycle
            end if
            stops = .true.
            at = place + k*half_width
         end do
      end subroutine stop_beside

      !> Whether the ends allow for a reading that stands out at the resonance.
      logical function may_stand_out() result(may)
         real(dp) :: widths(2)
         integer :: r

         if (.not. allocated(readings)) then
            allocate (readings(self%corrector%balance%block, count_readings(self%corrector%balance, torques), 3))
            call find_readings(self%corrector%balance, here%u, here%frequency_ratio, readings(:, :, 1))
            call find_readings(self%corrector%balance, next%u, next%frequency_ratio, readings(:, :, 2))
            moved = .true.
            swing = max(swings(readings(:, :, 1)), swings(readings(:, :, 2)))
            least = max(floors(self%corrector%balance, readings(:, :, 1)), floors(self%corrector%balance, readings(:, :, 2)))
         end if
         associate (place => self%resonances%at(n), half_width => self%resonances%half_width(n))
            widths = hypot(1.0_dp, ([here%frequency_ratio, next%frequency_ratio] - place)/half_width)
         end associate
         may = .false.
         do r = 1, size(swing)
            may = may .or. max(widths(1)*norm2(readings(2*h:2*h + 1, r, 1)), widths(2)*norm2(readings(2*h:2*h + 1, r, 2))) &
                  > max((1 + stands)*swing(r), least(r))
         end do
      end function may_stand_out

      !> Whether a reading stands out at the resonance.
      logical function stands_out()
         if (.not. allocated(readings)) matters = may_stand_out()
         call find_readings(self%corrector%balance, solution%u, solution%frequency_ratio, readings(:, :, 3))
         stands_out = any(swings(readings(:, :, 3)) > max((1 + stands)*swing, least))
      end function stands_out

      !> Length of the coefficients without the means [1].
      pure real(dp) function motion(solution)
         type(solution_point_type), intent(in) :: solution

         motion = norm2(solution%u(2:, :))/sqrt(2.0_dp)/self%corrector%units%length
      end function motion

   end subroutine pass_resonances

end module geartrain_trace_resonance_stepper
