!> Special points and contact onsets of the exact motion: where they are, the motion there, and which multipliers cross.
module geartrain_exact_exact_point
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_error, only: error_type, fatal, status_ended_early
   use geartrain_base_kinds, only: dp
   use geartrain_base_observer, only: observer_type
   use geartrain_base_words, only: lambda, operator(//)
   use geartrain_exact_augmented_point, only: augmented_point_type, trains_type
   use geartrain_exact_augmented_system, only: augmented_system_type
   use geartrain_trace_branch, only: branch_type, special_point_type
   use geartrain_trace_decided, only: joined
   use geartrain_exact_exact_search, only: change_at, find_exact
   use geartrain_exact_normal_form, only: degenerate, doubling_coefficient, neimark_sacker_coefficient
   use geartrain_exact_orbit_corrector, only: orbit_corrector_type, orbit_type
   use geartrain_exact_orbit_tests, only: back_contact, is_onset, outside, separation
   use geartrain_trace_points, only: repeats_of
   use geartrain_trace_stages, only: no_stage, stage_kind
   use geartrain_exact_refinement, only: cancel_refinement
   use geartrain_floquet_multipliers, only: is_stable, power
   use geartrain_flow_multiple_shooting, only: most_parts, section_states
   use geartrain_flow_orbit, only: measure
   use geartrain_flow_sections, only: sections_type
   use geartrain_network_check_coupling, only: has_friction, refuse_friction_of
   use geartrain_network_check_train, only: check_train
   use geartrain_network_long_period, only: refuse_long_period
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: branch_with_multipliers, check_whole_period, exact_point_type, find_exact_point, onsets_of, refine_special_points

   !> Distance from a special point to the orbits on either side whose multipliers are counted, in the units of units_type.
   real(dp), parameter :: beside = 1e-4_dp
   !> Tenths to which this distance is reduced at most, where another special point is as near.
   integer, parameter :: most_tenths = 4
   !> Distance of the pair of multipliers of a Neimark-Sacker point from the unit circle that is the error of its place.
   real(dp), parameter :: on_circle = 1e-5_dp
   !> Change of Lambda up to which the solution of the augmented system is the special point that was found, in its unit.
   real(dp), parameter :: near = 1e-6_dp

   !> What a message recommends.
   character(*), parameter :: branch_with_multipliers = 'a response with stability = .true. and multipliers = .true.'

   type :: exact_point_type
      !> Kind as in special_point_type; number of the mesh of a contact onset, else 0.
      character(24) :: kind = ''
      integer :: mesh = 0
      !> Number of multipliers, or of pairs, that pass the unit circle there together, as of a special point.
      integer :: multiplicity = 1
      !> Lambda [1].
      real(dp) :: frequency_ratio = 0
      !> The motion with its state, multipliers and figures.
      type(motion_type) :: motion
      !> Number of multipliers outside the unit circle just before and just after it along the branch; -1: not known.
      integer :: before = -1, after = -1
      !> Smallest mesh speed at a contact event [1]: near 0 the motion grazes; huge: no event, or not known.
      real(dp) :: slowest_event = huge(1.0_dp)
      !> Of a period doubling or a Neimark-Sacker point 'supercritical' or 'subcritical'; blank where the motion stays on linear
      !> pieces, or it is not known.
      character(16) :: criticality = ''
   end type exact_point_type

contains

   !> The contact onsets of a branch: its contact edges as special points.
   subroutine onsets_of(branch, onsets)
      !> A branch whose contact edges are located.
      type(branch_type), intent(in) :: branch
      !> The onsets, in the order along the branch.
      type(special_point_type), allocatable, intent(out) :: onsets(:)
      integer :: i, n

      n = 0
      if (allocated(branch%contact_edges)) n = size(branch%contact_edges)
      allocate (onsets(n))
      do i = 1, n
         associate (edge => branch%contact_edges(i))
            onsets(i)%kind = merge(back_contact, separation//'  ', edge%back)
            if (edge%stage /= no_stage) onsets(i)%kind = stage_kind(edge%stage)
            onsets(i)%mesh = edge%mesh
            onsets(i)%point = edge%point
            onsets(i)%frequency_ratio = edge%frequency_ratio
            onsets(i)%rms = edge%rms
         end associate
      end do
   end subroutine onsets_of

   !> Finds the special point of the exact motion that is nearest to a special point, or to a contact onset, of a branch.
   subroutine find_exact_point(train, branch, number, special, exact, error)
      !> The train.
      type(train_type), intent(in) :: train
      !> The branch.
      type(branch_type), intent(in) :: branch
      !> Number of the special point; 0: a contact onset.
      integer, intent(in) :: number
      !> The special point or the contact onset.
      type(special_point_type), intent(in) :: special
      !> The special point of the exact motion.
      type(exact_point_type), intent(out) :: exact
      !> Bad input, or there is none near it (status_ended_early).
      type(error_type), allocatable, intent(out) :: error
      type(system_type), target :: system, divided
      type(orbit_corrector_type) :: corrector
      type(orbit_type) :: orbit
      logical :: found

      call check_train(train, error)
      if (.not. allocated(error)) call refuse_friction_of(train, 'exact: special points', error)
      if (allocated(error)) return
      if (allocated(branch%parameter)) then
         call fatal(error, 'exact: the branch is over a parameter: only special points of a branch over frequency are made exact')
         return
      end if
      call check_whole_period(train, branch, special, 'exact', error)
      if (allocated(error)) return
      call build_system(train, system)
      divided = system
      call corrector%setup(divided, branch%subharmonic, repeats_of(branch, system))
      call find_exact(corrector, branch, special, change_at(branch, number, special), orbit, found)
      if (train%interrupt%raised()) found = .false.
      if (.not. found) then
         call none_found()
         return
      end if
      exact%kind = special%kind
      exact%mesh = special%mesh
      exact%multiplicity = special%multiplicity
      call take_orbit(system, corrector, orbit, exact, found)
      if (.not. found) call none_found()

   contains

      subroutine none_found()
         call fatal(error, 'exact: no '//trim(special%kind)//' of the exact motion was found near ' &
                    //lambda(special%frequency_ratio), status_ended_early)
      end subroutine none_found

   end subroutine find_exact_point

   !> Makes it an error where a special point needs multipliers that the branch does not have, because its period is long.
   subroutine check_whole_period(train, branch, special, what, error)
      !> A train that check_train accepts.
      type(train_type), intent(in) :: train
      !> The branch.
      type(branch_type), intent(in) :: branch
      !> A special point or a contact onset of the branch.
      type(special_point_type), intent(in) :: special
      !> What is to be done, for the message.
      character(*), intent(in) :: what
      !> Bad input.
      type(error_type), allocatable, intent(inout) :: error

      if (special%kind == 'stability change') then
         call fatal(error, what//': a stability change is where the growth rate passes 0 on a branch of long period; how a &
                    &multiplier passes the unit circle there is known only of '//branch_with_multipliers)
      else
         call refuse_long_period(train, what//': solves for the motion over whole periods', 'take '//branch_with_multipliers, &
                                 branch%states > 0, error)
      end if
   end subroutine check_whole_period

   !> Replaces the special points of a branch by those of the exact motion near them; one near which none is found stays as it is.
   !> Those that were tried before, as in a checkpoint, are not tried again. On a branch over a parameter all stay as they are.
   subroutine refine_special_points(train, branch, observer)
      !> The train.
      type(train_type), intent(in) :: train
      !> The branch.
      type(branch_type), intent(inout), target :: branch
      !> Told of each special point as of a further point of 'refinement', by one thread at a time; may end it.
      class(observer_type), intent(inout), optional :: observer
      type(exact_point_type) :: exact
      type(error_type), allocatable :: error
      integer :: i, done
      logical :: keep_going, go

      if (.not. allocated(branch%special_points) .or. allocated(branch%parameter) .or. has_friction(train)) return
      done = branch%points + count(branch%special_points%correction > -2)
      keep_going = .true.
      ! A special point's place among the points bounds the search of its neighbours: it stays until all are found.
      !$omp parallel do private(exact, error, go) schedule(dynamic)
      do i = 1, size(branch%special_points)
         !$omp atomic read
         go = keep_going
         if (.not. go .or. branch%special_points(i)%correction > -2) cycle
         call find_exact_point(train, branch, i, branch%special_points(i), exact, error)
         if (train%interrupt%raised()) cycle
         !$omp critical (geartrain_refine_special_points)
         associate (special => branch%special_points(i))
            special%correction = -1
            if (exact%frequency_ratio > 0) then
               special%correction = abs(exact%frequency_ratio - special%frequency_ratio)
               special%frequency_ratio = exact%frequency_ratio
               special%rms = exact%motion%rms
            end if
            done = done + 1
            go = keep_going
            if (go .and. present(observer)) call observer%on_step('refinement', done, special%frequency_ratio, go)
         end associate
         !$omp atomic write
         keep_going = go
         !$omp end critical (geartrain_refine_special_points)
      end do
      !$omp end parallel do
      if (any(branch%special_points%correction <= -2)) then
         call cancel_refinement(branch)
         return
      end if
      do i = 1, size(branch%special_points)
         if (branch%special_points(i)%kind /= 'fold' .and. .not. branch%special_points(i)%correction < 0) &
            call place_between(branch, branch%special_points(i))
      end do
   end subroutine refine_special_points

   !> Finds the two points that an exact special point lies between: it may lie beyond one of the two between which it was found.
   subroutine place_between(branch, special)
      type(branch_type), intent(in) :: branch
      type(special_point_type), intent(inout) :: special
      integer :: k, n(3)

      n = special%point + [0, 1, -1]
      do k = 1, 3
         if (n(k) < 1 .or. n(k) >= branch%points) cycle
         if (.not. joined(branch, n(k))) cycle
         associate (ends => branch%frequency_ratio(n(k):n(k) + 1))
            if (special%frequency_ratio < minval(ends) .or. special%frequency_ratio > maxval(ends)) cycle
         end associate
         special%point = n(k)
         return
      end do
   end subroutine place_between

   !> Takes the motion from the orbit at a special point, solved for both conditions at once, and counts multipliers beside it.
   subroutine take_orbit(system, corrector, orbit, exact, found)
      type(system_type), intent(in) :: system
      type(orbit_corrector_type), intent(inout) :: corrector
      type(orbit_type), intent(in) :: orbit
      type(exact_point_type), intent(inout) :: exact
      !> Of a branch point, of which the search only has a guess, whether it was solved for; of a Neimark-Sacker point whether a
      !> pair crosses the unit circle there: the product of a pair jumps where it becomes real.
      logical, intent(out) :: found
      complex(dp), allocatable :: multipliers(:)
      logical :: polished

      associate (motion => exact%motion)
         motion%frequency_ratio = orbit%frequency_ratio/corrector%times
         motion%period = corrector%period
         motion%state = orbit%states(:, 1)
         motion%multipliers = orbit%multipliers
         ! The augmented system is singular where several multipliers pass together: the zero of the search stands.
         polished = exact%multiplicity > 1
         if (.not. polished) call polish(corrector, exact, polished)
         multipliers = motion%multipliers
         motion%multipliers = power(multipliers, corrector%times)
         found = polished .or. exact%kind /= 'branch point'
         if (.not. found) return
         call measure(system, 0, motion)
         ! On a special point itself a multiplier is on the unit circle; a contact onset is a motion like any other.
         motion%undecided = .not. is_onset(exact%kind)
         motion%stable = .not. motion%undecided .and. is_stable(motion%multipliers)
         motion%error_estimate = 0
         exact%frequency_ratio = motion%frequency_ratio
      end associate
      call count_beside(corrector, orbit, exact)
      if (exact%kind == 'neimark-sacker') found = exact%before /= exact%after .or. &
         any(multipliers%im > 0 .and. abs(abs(multipliers) - 1) < on_circle)
   end subroutine take_orbit

   !> Counts the multipliers outside the unit circle on either side, as near as it takes for those alone to cross that must.
   subroutine count_beside(corrector, orbit, exact)
      type(orbit_corrector_type), intent(inout) :: corrector
      type(orbit_type), intent(in) :: orbit
      type(exact_point_type), intent(inout) :: exact
      type(orbit_type) :: side
      integer :: counted(2), i, k, crossing
      logical :: success

      crossing = 0
      if (exact%kind == 'fold' .or. exact%kind == 'period doubling') crossing = 1
      if (exact%kind == 'branch point' .and. exact%multiplicity > 1) crossing = 1
      if (exact%kind == 'neimark-sacker') crossing = 2
      crossing = crossing*exact%multiplicity
      do k = 0, most_tenths
         counted = -1
         do i = 1, 2
            call corrector%advance(orbit, merge(-1, 1, i == 1)*beside/10**k, side, success)
            if (success) counted(i) = outside(side%multipliers)
         end do
         if (k == 0 .or. all(counted >= 0) .and. abs(counted(2) - counted(1)) == crossing) then
            exact%before = counted(1)
            exact%after = counted(2)
         end if
         if (crossing == 0 .or. any(counted < 0) .or. abs(counted(2) - counted(1)) == crossing) return
      end do
   end subroutine count_beside

   !> Solves the augmented system, from the special point of the search, whose error is that of a bracket. Where the system is
   !> singular, as where multipliers coincide by symmetry, the point stays as it is.
   subroutine polish(corrector, exact, success)
      type(orbit_corrector_type), intent(in) :: corrector
      !> Its motion has Lambda, period, state and the multipliers over one repetition.
      type(exact_point_type), intent(inout) :: exact
      logical, intent(out) :: success
      type(trains_type), target :: trains
      type(augmented_system_type) :: augmented
      type(augmented_point_type) :: point
      type(motion_type) :: one
      type(sections_type) :: sections
      real(dp) :: coefficient
      integer :: i, info

      associate (motion => exact%motion, system => corrector%system, times => corrector%times)
         call augmented%setup(trains, system, motion%period, exact%kind, exact%mesh)
         call sections%setup(system, motion%period, most_parts(system, motion%period), moves=.false.)
         one = motion
         one%frequency_ratio = times*motion%frequency_ratio
         call section_states(system, one, sections, point%states)
         point%frequency_ratio = one%frequency_ratio
         call augmented%solve(point, .false., success)
         ! The form that stands for the symmetry is exact only at the branch point itself.
         do i = 1, 2
            if (.not. (success .and. augmented%is_symmetric)) exit
            call augmented%find_borders(point, info)
            if (info == 0) call augmented%solve(point, .false., success)
         end do
         if (success) success = abs(point%frequency_ratio - one%frequency_ratio) &
                                < merge(beside, near, exact%kind == 'branch point')*augmented%metric%units%frequency_ratio
         if (.not. success) return
         motion%frequency_ratio = point%frequency_ratio/times
         motion%state = point%states(:, 1)
         motion%multipliers = point%multipliers
         exact%slowest_event = point%slowest_event
      end associate
      coefficient = 0
      ! Without contact events the equation of motion is linear.
      if (point%events == 0) return
      if (exact%kind == 'period doubling') coefficient = doubling_coefficient(augmented, point)
      if (exact%kind == 'neimark-sacker') coefficient = -neimark_sacker_coefficient(augmented, point)
      if (coefficient > degenerate) exact%criticality = 'supercritical'
      if (coefficient < -degenerate) exact%criticality = 'subcritical'
   end subroutine polish

end module geartrain_exact_exact_point
