!> One side of the curve of a special point over Lambda and a parameter of the train, from its first point on, with the points at
!> which two conditions meet.
module geartrain_curves_locus_side
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_base_words, only: lambda, operator(//), words_type
   use geartrain_curves_locus_corner, only: cross_corner
   use geartrain_curves_locus_half_period, only: is_of_half, passes_half, way_to_half
   use geartrain_curves_locus_limits, only: limits_type
   use geartrain_curves_locus_location, only: locate_grazing, locate_half, located, most_steps, nearest_half
   use geartrain_curves_locus_result, only: double_point_type
   use geartrain_curves_locus_tests, only: find_tests, grazing_name, most_tests, name_of, tests_type
   use geartrain_curves_locus_walls, only: find_grazing_mesh, touches
   use geartrain_exact_augmented_point, only: augmented_point_type
   use geartrain_exact_augmented_system, only: augmented_system_type
   use geartrain_linalg_bracket, only: between, shrink
   implicit none (type, external)
   private
   public :: side_type, trace_side

   !> First, shortest and longest step in the metric of the curve: the way from `start` to `stop` of the parameter has length 1.
   real(dp), parameter :: first_step = 5e-3_dp, shortest = 1e-8_dp, longest = 0.025_dp
   !> Cosine of the angle between the tangents at the ends of a step that is wanted, and the least.
   real(dp), parameter :: wanted_cosine = 0.995_dp, least_cosine = 0.95_dp
   !> Most points on either side of the first.
   integer, parameter :: most_points = 4000
   !> Value of a test function over the one before it from which on its sign is doubtful.
   real(dp), parameter :: doubtful = 0.2_dp
   !> Step below which a curve whose motion touches a wall is at a corner; most such steps before it ends there.
   real(dp), parameter :: crawling = 1e-5_dp
   integer, parameter :: most_crawls = 20
   !> Distance of the last point of a curve whose motion vanishes from the end of the range at which it would.
   real(dp), parameter :: near_end = 1e-3_dp
   !> Most failures to get across one.
   integer, parameter :: most_failures = 3
   !> A side of the curve as it is traced.
   type :: side_type
      type(augmented_point_type), allocatable :: point(:)
      type(double_point_type), allocatable :: special(:)
      integer :: points = 0, specials = 0
      !> Why it ended, in words and as one of the kinds of `locus_type%ends`.
      type(words_type), allocatable :: ended
      character(16) :: end_kind = ''
      logical :: at_end = .false., closed = .false.
   end type side_type

contains

   !> Follows the curve from its first point along the tangent. Both sides may run at a time.
   subroutine trace_side(augmented, first, start, stop, side, keep_going, done, covered, observer)
      !> The system of the special point, solved at the first point last.
      type(augmented_system_type), intent(inout) :: augmented
      !> The first point, with its tangent.
      type(augmented_point_type), intent(in) :: first
      !> Ends of the range of the parameter [unit of the parameter].
      real(dp), intent(in) :: start, stop
      !> The points after the first.
      type(side_type), intent(inout) :: side
      !> False once the observer or an interrupt has ended the analysis, of both sides.
      logical, intent(inout) :: keep_going
      !> Points found so far, of both sides.
      integer, intent(inout) :: done
      !> Share of the range of the parameter that this side has covered [1].
      real(dp), intent(inout) :: covered
      !> Told of each point; may end it.
      class(observer_type), intent(inout), optional :: observer
      !> The points at both ends of a step; the one before the latest corner; a place between points.
      type(augmented_point_type) :: here, next, corner, place
      type(tests_type) :: before, after
      type(limits_type) :: limits
      character(80) :: why, beyond
      real(dp) :: h, ends(2), cosine
      integer :: k, leapt, crawls, failures
      logical :: success, ends_here, at_wall, landed, go

      allocate (side%point(most_points), side%special(most_points))
      ends = ([min(start, stop), max(start, stop)] - augmented%origin)/augmented%scale
      here = first
      call find_tests(augmented, here, before)
      call limits%begin(augmented, first)
      h = first_step
      leapt = -10
      crawls = 0
      failures = 0
      beyond = ''
      do while (side%points < most_points)
         if (here%parameter <= ends(1) .and. here%tangent_parameter < 0 .or. here%parameter >= ends(2) &
             .and. here%tangent_parameter > 0) then
            call finish('range', words_type('the end of the range of the parameter'))
            side%at_end = .true.
            return
         end if
         call augmented%advance(here, h, next, success, roughly=.true.)
         !$omp atomic read
         go = keep_going
         ! A long step may lead to what is no orbit although the parameter keeps the symmetry.
         if (augmented%open .and. h < crawling) then
            call finish('symmetry', 'the parameter breaks the symmetry, at '//lambda(here%frequency_ratio))
            return
         end if
         if (augmented%moving%interrupted() .or. .not. go) then
            call finish('cancelled', words_type('cancelled'))
            return
         end if
         if (success) then
            cosine = augmented%metric%product_of(next%tangent, next%tangent_frequency, next%tangent_parameter, here)
            success = cosine > least_cosine
         end if
         if (.not. success) then
            h = h/3
            if (h > crawling) cycle
            crawls = crawls + 1
            at_wall = touches(augmented, here)
            if (at_wall .and. augmented%kind == 'fold' .and. is_of_half(augmented, here)) then
               call put(grazing_name('period doubling'), here)
               call finish('corner', 'meets a grazing doubling of motions of half the period at '//lambda(here%frequency_ratio))
               return
            end if
            if (at_wall) call leap(success)
            ! Where it does not get across, the curve may still get along in short steps.
            if (.not. success .and. h > shortest .and. crawls < most_crawls) cycle
            ! On the curve of an onset every motion touches a wall.
            if (.not. success .and. at_wall .and. augmented%mesh == 0) then
               call put(grazing_name(augmented%kind), here)
               ! What is across the corner says more than the corner.
               call finish('limit', trim(beyond)//' near '//lambda(here%frequency_ratio))
               if (beyond /= '') return
               call find_grazing_mesh(augmented, here, k)
               call finish('corner', 'a corner: '//trim(augmented%system%mesh_name(k))//' grazes a wall of its gap at '// &
                           lambda(here%frequency_ratio)//', parameter = '//text(augmented%origin + augmented%scale*here%parameter))
               return
            end if
            if (.not. success .and. h > shortest) cycle
            if (.not. success) then
               call finish('failed', 'Newton''s method does not converge at '//lambda(here%frequency_ratio))
               return
            end if
         end if
         landed = next%parameter < ends(1) .or. next%parameter > ends(2)
         if (landed) then
            call land(merge(ends(1), ends(2), next%parameter < ends(1)), success)
            if (.not. success) then
               h = h/3
               if (h > shortest) cycle
               call finish('failed', words_type('Newton''s method does not converge at the end of the range'))
               return
            end if
         end if
         call limits%forbids(augmented, next, why)
         if (why /= '') then
            call approach(why)
            return
         end if
         if (passes_half(augmented, here, next)) then
            ends_here = abs(way_to_half(here)) < 2*augmented%metric%distance(here, next)
            if (ends_here) call locate_half(augmented, here, place, success)
            if (ends_here .and. success) then
               call put('generalized doubling', place)
               call finish('double point', words_type('a generalized doubling'))
               return
            end if
            h = h/3
            if (h > nearest_half) cycle
            if (ends_here) then
               call finish('double point', 'meets the doubling of motions of half the period near '//lambda(here%frequency_ratio))
               return
            end if
         end if
         call find_tests(augmented, next, after)
         ! Near a zero the signs of values that rest on derivatives of before are not sure.
         if (.not. landed .and. any(after%value*before%value < 0 .or. abs(after%value) < doubtful*abs(before%value))) then
            call augmented%solve(next, .true., success)
            if (.not. success) then
               h = h/3
               if (h > shortest) cycle
               call finish('failed', 'Newton''s method does not converge at '//lambda(here%frequency_ratio))
               return
            end if
            call find_tests(augmented, next, after)
         end if
         ends_here = .false.
         do k = 1, most_tests
            if (name_of(augmented%kind, k) == '') exit
            if (before%value(k)*after%value(k) < 0) call locate(k, ends_here)
            if (ends_here) exit
         end do
         if (ends_here) return
         if (before%events /= after%events .and. augmented%mesh == 0) then
            call locate_grazing(augmented, here, next, place)
            call put(grazing_name(augmented%kind), place)
         end if
         side%points = side%points + 1
         side%point(side%points) = next
         !$omp critical (geartrain_locus)
         done = done + 1
         associate (end => ends(merge(2, 1, next%parameter > first%parameter)))
            if (abs(end - first%parameter) > 0) &
               covered = max(covered, abs(next%parameter - first%parameter)/abs(end - first%parameter))
         end associate
         go = keep_going
         if (go .and. present(observer)) call observer%on_step('locus', done, next%frequency_ratio, go)
         !$omp atomic write
         keep_going = go
         !$omp end critical (geartrain_locus)
         if (side%points > 3 .and. passes(augmented, here, next, first)) then
            call finish('closed', words_type('closed'))
            side%closed = .true.
            return
         end if
         call limits%ends_at(augmented, next, side%ended)
         if (allocated(side%ended)) then
            ! A curve over the torque from 0 on is whole where the motion vanishes.
            side%at_end = limits%vanishes(augmented) .and. minval(abs(next%parameter - ends)) < near_end
            side%end_kind = merge('range', 'limit', side%at_end)
            return
         end if
         if (cosine > least_cosine) call augmented%metric%find_bend(here, next)
         here = next
         before = after
         if (cosine > wanted_cosine) h = min(longest, 1.5_dp*h)
      end do
      call finish('limit', words_type('has the most points'))

   contains

      !> Goes on beyond a grazing, where the curve has a corner at which Newton's method fails.
      subroutine leap(success)
         logical, intent(out) :: success

         success = .false.
         if (side%points - leapt < 4 .or. failures == most_failures) return
         leapt = side%points
         beyond = ''
         call cross_corner(augmented, here, corner, next, success)
         if (success) then
            call limits%forbids(augmented, next, why)
            success = why == ''
            beyond = why
         end if
         if (.not. success) then
            failures = failures + 1
            return
         end if
         corner = here
         failures = 0
         crawls = 0
         h = first_step
         cosine = 0
      end subroutine leap

      !> Ends the curve at its last point before the one at the end of the step, which is no special point.
      subroutine approach(why)
         !> Why it is none.
         character(*), intent(in) :: why
         type(augmented_point_type) :: middle
         character(len(why)) :: found
         real(dp) :: a, b
         logical :: success

         a = 0
         b = h
         next = here
         do while (b - a > shortest)
            call augmented%advance(here, (a + b)/2, middle, success, roughly=.true.)
            if (success) success = middle%parameter >= ends(1) .and. middle%parameter <= ends(2)
            if (success) call limits%forbids(augmented, middle, found)
            if (success) success = found == ''
            if (success) then
               a = (a + b)/2
               next = middle
            else
               b = (a + b)/2
            end if
         end do
         if (a > 0) then
            side%points = side%points + 1
            side%point(side%points) = next
         end if
         ! Between motions with contact events and those without is a grazing.
         if (next%events > 0) call put(grazing_name(augmented%kind), next)
         call finish('limit', trim(why)//' near '//lambda(next%frequency_ratio))
         if (.not. augmented%moving%interrupted()) return
         call finish('cancelled', words_type('cancelled'))
      end subroutine approach

      !> Makes `next` the point at an end of the range.
      subroutine land(end_value, success)
         real(dp), intent(in) :: end_value
         logical, intent(out) :: success
         type(augmented_point_type) :: at_end
         real(dp) :: share

         share = (end_value - here%parameter)/(next%parameter - here%parameter)
         at_end = next
         at_end%states = here%states + share*(next%states - here%states)
         at_end%frequency_ratio = here%frequency_ratio + share*(next%frequency_ratio - here%frequency_ratio)
         at_end%parameter = end_value
         call augmented%solve(at_end, .false., success)
         ! The solution may leave it by rounding.
         at_end%parameter = end_value
         if (success) success = augmented%metric%distance(at_end, here) < 1.5_dp*augmented%metric%distance(next, here)
         if (success) next = at_end
      end subroutine land

      !> Locates where test k is 0 between `here` and `next`; the curve ends where a pair of multipliers becomes real.
      subroutine locate(k, ends_here)
         integer, intent(in) :: k
         logical, intent(out) :: ends_here
         type(augmented_point_type) :: middle
         type(tests_type) :: at
         real(dp) :: a, b, fa, fb, s
         integer :: i, kept
         logical :: success

         a = 0
         b = augmented%metric%product_of(next%states - here%states, next%frequency_ratio - here%frequency_ratio, &
                                  next%parameter - here%parameter, here)
         fa = before%value(k)
         fb = after%value(k)
         kept = 0
         ends_here = augmented%kind == 'neimark-sacker' .and. k <= 2
         do i = 1, most_steps
            s = between(a, b, fa, fb)
            call augmented%advance(here, s, middle, success)
            if (.not. success) exit
            call find_tests(augmented, middle, at)
            call shrink(a, b, fa, fb, s, at%value(k), kept)
            if (b - a < located .or. .not. abs(at%value(k)) > 0) exit
         end do
         ! A test function that jumps has no zero.
         if (success .and. abs(at%value(k)) > 1e-3_dp*max(abs(before%value(k)), abs(after%value(k)))) success = .false.
         if (success) call put(name_of(augmented%kind, k), middle)
         if (ends_here .and. success) then
            side%points = side%points + 1
            side%point(side%points) = middle
            call finish('double point', words_type('a '//trim(name_of(augmented%kind, k))))
         else if (ends_here) then
            call finish('double point', 'the pair of multipliers becomes real at '//lambda(next%frequency_ratio))
         end if
      end subroutine locate

      !> Says why the curve ends here: one of the kinds of `locus_type%ends`, and the words.
      subroutine finish(kind, words)
         character(*), intent(in) :: kind
         type(words_type), intent(in) :: words

         side%end_kind = kind
         side%ended = words
      end subroutine finish

      subroutine put(kind, point)
         character(*), intent(in) :: kind
         type(augmented_point_type), intent(in) :: point

         side%specials = side%specials + 1
         side%special(side%specials) = double_point_type(kind, point%frequency_ratio, &
                                                         augmented%origin + augmented%scale*point%parameter, side%points)
      end subroutine put

   end subroutine trace_side

   !> Whether the step from a point to the next one passes the first point of the curve.
   pure logical function passes(augmented, here, next, first)
      type(augmented_system_type), intent(in) :: augmented
      type(augmented_point_type), intent(in) :: here, next, first
      real(dp) :: way, before

      way = augmented%metric%distance(here, next)
      passes = augmented%metric%distance(here, first) < way .and. augmented%metric%distance(next, first) < way
      if (.not. passes) return
      before = augmented%metric%product_of(first%states - here%states, first%frequency_ratio - here%frequency_ratio, &
                                    first%parameter - here%parameter, here)
      passes = before > 0 .and. before <= way .and. &
               augmented%metric%product_of(here%tangent, here%tangent_frequency, here%tangent_parameter, first) > least_cosine
   end function passes

end module geartrain_curves_locus_side
