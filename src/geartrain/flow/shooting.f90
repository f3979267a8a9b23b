!> Shooting: a periodic orbit to integration accuracy by Newton's method on the flow over its period, in one piece or, where this
!> does not converge, in sections. Tangents pass contact events exactly, so the monodromy matrix of the flow is the exact
!> derivative.
module geartrain_flow_shooting
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_repetition, only: repeat_motion, repetitions_of, take_one
   use geartrain_base_error, only: error_type, fatal, status_ended_early
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_words, only: lambda, operator(//)
   use geartrain_flow_across_fold, only: look_beyond_fold
   use geartrain_floquet_multipliers, only: is_neutral, is_stable
   use geartrain_flow_kept_states, only: judge, keeps
   use geartrain_flow_multiple_shooting, only: find_orbit_in_sections, has_converged, max_iterations, most_parts, &
      section_states
   use geartrain_flow_orbit, only: measure, stored_harmonics
   use geartrain_flow_sections, only: sections_type
   use geartrain_flow_start_state, only: state_of
   use geartrain_flow_tangent_flight, only: tangent_flight_type
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
   use geartrain_network_divide_orders, only: divide_orders
   use geartrain_network_check_train, only: check_train
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_train, only: train_type
   use geartrain_network_units, only: units_of, units_type
   implicit none (type, external)
   private
   public :: find_orbit, newton_step, refine

contains

   !> Refines a motion to a relative error of about 1e-11, with multipliers and the state at time 0. Beside a fold the motion stays
   !> on its side. On failure the motion is unchanged and the error says why.
   subroutine refine(train, motion, error, in_sections, harmonics, repeats, side)
      type(train_type), intent(in) :: train
      !> A motion with a period and a state or coefficients, then the refined motion.
      type(motion_type), intent(inout) :: motion
      type(error_type), allocatable, intent(out) :: error
      !> Divides the period into sections, which finds more of the strongly unstable orbits and takes longer. Unless it is given,
      !> sections are used where one piece does not converge.
      logical, intent(in), optional :: in_sections
      !> Harmonics of Lambda in the refined motion; unless it is given as many as `motion` has, at least `stored_harmonics`.
      integer, intent(in), optional :: harmonics
      !> How often the motion goes through its waveform within its period; absent: as its coefficients tell.
      integer, intent(in), optional :: repeats
      !> Side of a fold on which the orbit is to be, as `side_of_fold` counts it. Absent or negative: the side of the motion.
      integer, intent(in), optional :: side
      type(system_type), target :: system
      type(sections_type) :: sections
      type(motion_type) :: guess, refined
      real(dp), allocatable :: state(:), begun(:), other(:), monodromy(:, :)
      real(dp) :: length
      integer :: attempt, n, times, kept
      logical :: found, beyond, pieces(2)

      call check_train(train, error)
      if (allocated(error)) return
      if (motion%period < 1) then
         call fatal(error, 'refine: no period was found for this motion, so there is no orbit to refine')
         return
      end if
      if (.not. (allocated(motion%state) .or. allocated(motion%coefficients))) then
         call fatal(error, 'refine: the motion has neither a state nor coefficients')
         return
      end if
      call build_system(train, system)
      n = system%states
      if (allocated(motion%state)) then
         if (size(motion%state) /= n) call fatal(error, 'refine: a state of '//text(size(motion%state))//' values: must have ' &
                                                 //text(n)//' (displacement of each elastic element, then the velocities)')
      end if
      if (.not. motion%frequency_ratio > 0) call fatal(error, 'refine: frequency = '//text(motion%frequency_ratio)//': must be > 0')
      if (allocated(error)) return
      kept = stored_harmonics(system)
      if (allocated(motion%coefficients)) kept = max(kept, ((size(motion%coefficients, 1) - 1)/2)/motion%period)
      if (present(harmonics)) kept = harmonics
      guess = motion
      times = repetitions_of(system, motion)
      if (present(repeats)) times = repeats
      if (times > 1) then
         call divide_orders(times, system)
         call take_one(times, guess)
      end if
      ! Which ways are tried: in one piece, in sections.
      pieces = .true.
      if (present(in_sections)) pieces = [.not. in_sections, in_sections]
      allocate (state(n), begun(n), other(n), monodromy(n, n))
      call state_of(system, guess, begun)
      do attempt = 1, 2
         call solve()
         if (.not. found) exit
         call look_beyond_fold(system, guess%frequency_ratio, motion%period, begun, state, monodromy, other, beyond, side)
         if (.not. beyond) exit
         guess%state = other
      end do
      ! Only where the side is told, an orbit can be on the wrong side.
      if (found .and. present(side)) found = side < 0 .or. .not. beyond
      if (system%interrupt%raised()) then
         call fatal(error, 'refine: interrupted', status_ended_early)
      else if (found) then
         call finish()
      else
         call fatal(error, 'refine: shooting does not converge at '//lambda(motion%frequency_ratio)//' (period ' &
                    //text(motion%period)//', last relative step '//text(length)//')', status_ended_early)
      end if

   contains

      subroutine solve()
         type(tangent_flight_type) :: flight
         real(dp), allocatable :: states(:, :)
         real(dp) :: frequency_ratio

         found = .false.
         frequency_ratio = guess%frequency_ratio
         if (pieces(1)) then
            call state_of(system, guess, state)
            call flight%setup(system, exact=.true.)
            call find_orbit(flight, frequency_ratio, motion%period, max_iterations, state, monodromy, length, found)
         end if
         if (pieces(2) .and. .not. (found .or. system%interrupt%raised())) then
            call sections%setup(system, motion%period, most_parts(system, motion%period), moves=.false.)
            call section_states(system, guess, sections, states)
            call find_orbit_in_sections(sections, frequency_ratio, states, length, found)
            state = states(:, 1)
            monodromy = sections%monodromy
         end if
      end subroutine solve

      subroutine finish()
         refined%frequency_ratio = guess%frequency_ratio
         refined%period = motion%period
         refined%share = motion%share
         refined%state = state
         refined%error_estimate = length
         call measure(system, max(1, kept/times), refined)
         allocate (refined%multipliers(n))
         call judge(monodromy, refined%multipliers, refined%stable, refined%undecided)
         if (times > 1) call repeat_motion(times, kept, refined)
         if (times > 1 .and. .not. any(keeps(monodromy))) then
            refined%stable = is_stable(refined%multipliers)
            refined%undecided = is_neutral(refined%multipliers)
         end if
         refined%frequency_ratio = motion%frequency_ratio
         motion = refined
      end subroutine finish

   end subroutine refine

   !> Newton's method on the flow over a period, from a state to the state of an orbit nearby.
   subroutine find_orbit(flight, frequency_ratio, period, most, state, monodromy, length, found, flights)
      !> Set up.
      type(tangent_flight_type), intent(inout) :: flight
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Period of the orbit [periods of the fundamental]; most Newton steps.
      integer, intent(in) :: period, most
      !> State at phase 0 [1], (state): a guess, then the orbit; where no orbit is found the result of the last step.
      real(dp), intent(inout) :: state(:)
      !> Monodromy matrix of the orbit [1], (state, state).
      real(dp), intent(out) :: monodromy(:, :)
      !> Last Newton step relative to the state [1].
      real(dp), intent(out) :: length
      !> An orbit was found.
      logical, intent(out) :: found
      !> Number of flights over the period.
      integer, intent(out), optional :: flights
      real(dp) :: final(size(state)), step(size(state)), before, scale, gap
      type(units_type) :: units
      integer :: i, info

      found = .false.
      length = 0
      before = huge(1.0_dp)
      units = units_of(flight%system)
      do i = 1, most
         if (present(flights)) flights = i
         call flight%fly(frequency_ratio, period, state, final, monodromy)
         if (flight%system%interrupt%raised()) return
         call newton_step(state, final, monodromy, step, info)
         scale = max(size_of(state), tiny(1.0_dp))
         gap = size_of(final - state)/scale
         length = size_of(step)/scale
         if (info /= 0 .or. .not. length < 10) return
         state = state + step
         found = has_converged(length, before, gap)
         if (found) return
         before = length
      end do

   contains

      !> Size of a state or a change of it, in the units of the train [1].
      pure real(dp) function size_of(values)
         real(dp), intent(in) :: values(:)

         size_of = units%size_of(flight%system%displacements, reshape(values, [size(values), 1]))
      end function size_of

   end subroutine find_orbit

   !> The step of Newton's method towards a state that the flow carries into itself.
   subroutine newton_step(state, final, monodromy, step, info)
      !> A state, and the state after the period [1], (state).
      real(dp), intent(in) :: state(:), final(:)
      !> Derivative of `final` with respect to `state` [1], (state, state).
      real(dp), intent(in) :: monodromy(:, :)
      !> Change of the state [1], (state).
      real(dp), intent(out) :: step(:)
      !> 0: the step was found; else the matrix is singular.
      integer, intent(out) :: info
      real(dp) :: matrix(size(state), size(state))
      logical :: kept(size(state))
      integer :: pivot(size(state)), k

      step = state - final
      matrix = monodromy
      kept = keeps(monodromy)
      do k = 1, size(state)
         ! What a period leaves as it is stays as it is.
         if (.not. kept(k)) matrix(k, k) = matrix(k, k) - 1
      end do
      call factor_matrix(size(state), matrix, pivot, info)
      if (info == 0) call solve_factored(size(state), 1, matrix, pivot, step)
   end subroutine newton_step

end module geartrain_flow_shooting
