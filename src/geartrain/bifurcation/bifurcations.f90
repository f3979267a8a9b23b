!> All branches that leave a branch: the period-doubling cascade, generation by generation, and the branches that cross at branch
!> points.
module geartrain_bifurcation_bifurcations
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_base_words, only: lambda, operator(//), words_type
   use geartrain_bifurcation_critical_point, only: find_critical, find_meeting, harmonics_at, patterns_of
   use geartrain_bifurcation_switching, only: trace_switched
   use geartrain_network_check_train, only: check_train
   use geartrain_network_system, only: system_type
   use geartrain_trace_branch, only: branch_type, coefficients_of, response_settings_type
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_trace_response_variables, only: settings_for
   use geartrain_trace_same_solution, only: put_in_order, same_solution
   use geartrain_trace_start, only: begin_trace, doubled_settings, solution_of
   use geartrain_trace_tracer, only: tracer_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: follow_bifurcations, add_branch

   !> Solution points whose Lambdas differ by more than this are different, whatever their harmonics [unit of Lambda, units_type].
   real(dp), parameter :: near = 0.05_dp

   !> A solution point at which two branches cross, or at which a period-doubled branch begins or ends.
   type :: meeting_type
      type(solution_point_type) :: solution
      !> Period of whose frequency the harmonics of `solution` are multiples [periods of the excitation].
      integer :: period = 0
      !> Two branches of equal period cross; else a period-doubled branch begins or ends.
      logical :: crossing = .false.
      !> Number of the branch on which the point was found; 0: the branch that all others come from.
      integer :: branch = 0
      !> Pattern in which equal branches begin to move differently; 0: any.
      integer :: pattern = 0
      !> Number of the special point of the branch on which the point was found; 0: at the end of a branch.
      integer :: special = 0
   end type meeting_type

contains

   !> Appends to `branches` the branches that leave `branch`, then the branches that leave the appended branches, and so on:
   !> settings%period_doublings generations at period doublings, all generations at branch points if settings%branch_points.
   !> A branch that begins at one period doubling and ends at another, or passes several branch points, is traced once.
   subroutine follow_bifurcations(train, settings, branch, branches, error, observer, known)
      !> The train as described.
      type(train_type), intent(in) :: train
      !> Settings that `branch` was traced with.
      type(response_settings_type), intent(in) :: settings
      !> The response, with its special points.
      type(branch_type), intent(in) :: branch
      !> Branches so far; not allocated: none. A target: an observer may read the branches through a pointer.
      type(branch_type), allocatable, intent(inout), target :: branches(:)
      type(error_type), allocatable, intent(out) :: error
      !> Is told of each step, and may cancel.
      class(observer_type), intent(inout), optional :: observer
      !> Branches that another run has traced already: known(n) is copied into branches(n) instead of a new trace.
      type(branch_type), intent(in), optional :: known(:)
      type(branch_type), allocatable :: earlier(:)
      type(branch_type) :: parent
      type(meeting_type), allocatable :: meetings(:)
      integer :: first, i, longest

      if (.not. allocated(branches)) allocate (branches(0))
      call check_train(train, error)
      if (allocated(error)) return
      allocate (earlier(0), meetings(0))
      if (present(known)) earlier = known
      first = size(branches)
      longest = 0
      call follow(train, settings, branch, 'the response', 0, longest, branches, meetings, earlier, observer)
      ! `branches` grows within the loop.
      i = first + 1
      do while (i <= size(branches))
         if (branches(size(branches))%cancelled) return
         ! A copy: `branches` moves in memory when it grows.
         parent = branches(i)
         call follow(train, settings_for(settings, parent%subharmonic), parent, 'branch '//text(i), i, longest, branches, &
                     meetings, earlier, observer)
         i = i + 1
      end do
   end subroutine follow_bifurcations

   !> Appends to `branches` the branches that leave `parent`.
   subroutine follow(train, settings, parent, name, number, longest, branches, meetings, known, observer)
      type(train_type), intent(in) :: train
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: parent
      !> `parent` in words.
      character(*), intent(in) :: name
      !> Number of `parent`, 0 for the response.
      integer, intent(in) :: number
      !> Longest period of the branches that are followed [periods of the excitation]: found where `parent` is the response.
      integer, intent(inout) :: longest
      type(branch_type), allocatable, intent(inout), target :: branches(:)
      !> Meetings known so far.
      type(meeting_type), allocatable, intent(inout) :: meetings(:)
      type(branch_type), intent(in) :: known(:)
      class(observer_type), intent(inout), optional :: observer
      type(solution_point_type), allocatable :: before(:), taken(:)
      type(solution_point_type) :: solution
      type(meeting_type) :: here
      type(system_type), target :: systems(2)
      type(tracer_type) :: tracer
      logical :: found, met, doubles, again
      type(response_settings_type) :: doubled
      integer :: equal, i, pattern

      if (.not. allocated(parent%special_points)) return
      call begin_trace(train, settings, systems, tracer, parent)
      if (number == 0) longest = tracer%corrector%balance%waves()*2**settings%period_doublings
      doubled = doubled_settings(train, settings, parent)
      allocate (taken(0))
      do i = 1, size(parent%special_points)
         if (train%interrupt%raised()) return
         associate (special => parent%special_points(i))
            doubles = special%kind == 'period doubling'
            if (doubles .and. tracer%corrector%balance%waves() >= longest) cycle
            if (.not. doubles .and. .not. (special%kind == 'branch point' .and. settings%branch_points)) cycle
            call find_critical(train, settings, parent, i, solution, found, taken=taken, again=again, equal=equal)
            ! A branch may pass a branch point twice, the second time shifted by some periods of the fundamental.
            if (again .and. .not. (found .or. doubles)) cycle
            before = taken
            if (found) taken = [taken, solution]
            do pattern = 1, patterns_of(equal, doubles)
               if (pattern > 1) call find_critical(train, settings, parent, i, solution, found, taken=before, pattern=pattern)
               call follow_one()
               if (size(branches) > 0) then
                  if (branches(size(branches))%cancelled) return
               end if
            end do
         end associate
      end do

   contains

      !> Follows the branch that leaves at `solution`, unless it is known.
      subroutine follow_one()
         character(:), allocatable :: words
         integer :: n, some(2)

         associate (special => parent%special_points(i))
            if (.not. (found .or. doubles)) call take_point(train, settings, parent, i, solution)
            if (found .or. .not. doubles) then
               here = meeting_type(solution, period(doubles), .not. doubles, number, merge(pattern, 0, equal > 0), i)
               call put_in_order(tracer%corrector%sets, here%solution)
               met = is_known(train, settings, parent, i, here, meetings, tracer)
               ! At a branch point all patterns are followed from here: another branch that comes to it has none left.
               here%pattern = 0
               if (found .and. (pattern == 1 .and. (.not. met .or. here%crossing) .or. doubles .and. .not. met)) &
                  meetings = [meetings, here]
               if (met) return
            end if
            words = ''
            if (equal > 2) then
               some = [pattern, equal - pattern]
               if (pattern > equal/2) some = pattern - equal/2
               words = ', '//text(some(1))//' of '//text(equal)//' equal branches against '//text(some(2))
            end if
            call add_branch(branches, trim(special%kind)//' of '//name//' at '//lambda(special%frequency_ratio)//words)
         end associate
         n = size(branches)
         if (n <= size(known)) then
            branches(n) = known(n)
         else
            call trace_switched(train, settings, parent, i, solution, found, branches(n), observer)
         end if
         if (branches(n)%cancelled) return
         if (doubles) then
            call find_meeting(train, doubled, branches(n), solution, met)
            here = meeting_type(solution, period(doubles), .false., n)
            if (met) call put_in_order(tracer%corrector%sets, here%solution)
            ! From a variable: gfortran 12 never frees a structure constructor within an array constructor.
            if (met) meetings = [meetings, here]
         else
            call note_crossings(train, settings, branches(n), n, period(doubles), merge(pattern, 0, equal > 0), tracer, meetings)
         end if
      end subroutine follow_one

      pure integer function period(doubles)
         logical, intent(in) :: doubles

         period = merge(doubled%subharmonic, parent%subharmonic, doubles)*tracer%system%excitation_order
      end function period

   end subroutine follow

   !> Adds to `meetings` the branch points of `branch`, which was just traced from a branch point.
   subroutine note_crossings(train, settings, branch, number, period, pattern, tracer, meetings)
      type(train_type), intent(in) :: train
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: branch
      !> Number of the branch; period of whose frequency the harmonics are multiples [periods of the excitation]; pattern in which
      !> equal branches move differently on it.
      integer, intent(in) :: number, period, pattern
      !> Of the branch from which it was traced.
      type(tracer_type), intent(in) :: tracer
      type(meeting_type), allocatable, intent(inout) :: meetings(:)
      type(solution_point_type) :: solution
      type(meeting_type) :: here
      logical :: found
      integer :: i

      if (.not. allocated(branch%special_points)) return
      do i = 1, size(branch%special_points)
         if (branch%special_points(i)%kind /= 'branch point') cycle
         call find_critical(train, settings, branch, i, solution, found)
         if (.not. found) call take_point(train, settings, branch, i, solution)
         here = meeting_type(solution, period, .true., number, pattern)
         call put_in_order(tracer%corrector%sets, here%solution)
         meetings = [meetings, here]
      end do
   end subroutine note_crossings

   !> The point of a branch next to a special point, where the search for it fails, as where the branch turns in its midst.
   subroutine take_point(train, settings, branch, special, solution)
      type(train_type), intent(in) :: train
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: special
      !> The point; no critical vector is known: its tangent is 0.
      type(solution_point_type), intent(out) :: solution
      type(system_type), target :: systems(2)
      type(tracer_type) :: tracer
      type(motion_type) :: motion
      integer :: n

      associate (at => branch%special_points(special))
         n = at%point
         if (n < branch%points) n = n + minloc(abs(branch%frequency_ratio(n:n + 1) - at%frequency_ratio), 1) - 1
      end associate
      call begin_trace(train, settings, systems, tracer, branch)
      if (settings%harmonics == 0) call tracer%prepare(harmonics_at(branch, special))
      motion%frequency_ratio = branch%frequency_ratio(n)
      motion%period = branch%subharmonic
      motion%coefficients = coefficients_of(branch, n)
      solution = solution_of(tracer, motion)
      solution%tangent = 0*solution%u
   end subroutine take_point

   !> Whether the branch that leaves `parent` at its special point number `special` is known: whether `here` is among `meetings`.
   !> Where the program chooses the number of harmonics, a bifurcation point moves with the number: `here` is then found again
   !> with as many harmonics as the meeting it is compared with.
   logical function is_known(train, settings, parent, special, here, meetings, tracer)
      type(train_type), intent(in) :: train
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: parent
      integer, intent(in) :: special
      type(meeting_type), intent(in) :: here, meetings(:)
      !> Of `parent`.
      type(tracer_type), intent(in) :: tracer
      type(solution_point_type) :: again
      logical :: found
      integer :: i, times

      is_known = .false.
      times = merge(1, 2, here%crossing)
      do i = 1, size(meetings)
         associate (other => meetings(i), units => tracer%corrector%units)
            if (other%period /= here%period .or. (other%crossing .neqv. here%crossing)) cycle
            if (here%crossing .and. other%branch == here%branch) cycle
            if (min(here%pattern, other%pattern) > 0 .and. here%pattern /= other%pattern) cycle
            ! Patterns of one special point are as many branches.
            if (here%branch == other%branch .and. here%special == other%special) cycle
            is_known = same_solution(here%solution, other%solution, here%period, units, .not. here%crossing)
            if (is_known) return
            if (size(here%solution%u, 1) == size(other%solution%u, 1)) cycle
            if (abs(here%solution%frequency_ratio - other%solution%frequency_ratio) > near*units%frequency_ratio) cycle
            call find_critical(train, settings, parent, special, again, found, &
                               harmonics=tracer%settings%repeats*((size(other%solution%u, 1) - 1)/(2*times)), &
                               pattern=max(1, here%pattern))
            if (found) call put_in_order(tracer%corrector%sets, again)
            if (found) is_known = same_solution(again, other%solution, here%period, units, .not. here%crossing)
            if (is_known) return
         end associate
      end do
   end function is_known

   !> Appends an empty branch to `branches`.
   subroutine add_branch(branches, origin)
      !> At least allocated; moves in memory.
      type(branch_type), allocatable, intent(inout), target :: branches(:)
      !> Where the new branch comes from, in words.
      type(words_type), intent(in) :: origin
      type(branch_type), allocatable :: longer(:)
      integer :: i

      allocate (longer(size(branches) + 1))
      do i = 1, size(branches)
         longer(i) = branches(i)
      end do
      longer(size(longer))%origin = origin
      call move_alloc(longer, branches)
   end subroutine add_branch

end module geartrain_bifurcation_bifurcations
