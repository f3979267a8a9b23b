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
      integer :: leapt, crawls, failures
      logical :: landed

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
      do while (side%points < most_points .and. .not. allocated(side%ended))
         if (here%parameter <= ends(1) .and. here%tangent_parameter < 0 .or. here%parameter >= ends(2) &
             .and. here%tangent_parameter > 0) then
            side%at_end = .true.
            call finish('range', words_type('the end of the range of the parameter'))
         else
            call take_step()
         end if
      end do
      if (.not. allocated(side%ended)) call finish('limit', words_type('has the most points'))

   contains

      !> Takes a step from `here`, or makes the next one shorter, or ends the curve.
      subroutine take_step()
         logical :: reached

         call reach(reached)
         if (reached) call keep_to_range(reached)
         if (reached) call keep_to_special(reached)
         if (reached) call pass_half(reached)
         if (reached) call pass_tests(reached)
         if (reached) call record(reached)
         if (.not. reached) return
         if (cosine > least_cosine) call augmented%metric%find_bend(here, next)
         here = next
         before = after
         if (cosine > wanted_cosine) h = min(longest, 1.5_dp*h)
      end subroutine take_step

      !> Makes the next step shorter; the curve ends where it would be too short.
      subroutine shorten(words)
         type(words_type), intent(in) :: words

         h = h/3
         if (.not. h > shortest) call finish('failed', words)
      end subroutine shorten

      !> Solves for `next` at the end of a step.
      subroutine reach(reached)
         logical, intent(out) :: reached
         logical :: go

         call augmented%advance(here, h, next, reached, roughly=.true.)
         !$omp atomic read
         go = keep_going
         ! A long step may lead to what is no orbit although the parameter keeps the symmetry.
         if (augmented%open .and. h < crawling) then
            call finish('symmetry', 'the parameter breaks the symmetry, at '//lambda(here%frequency_ratio))
         else if (augmented%moving%interrupted() .or. .not. go) then
            call finish('cancelled', words_type('cancelled'))
         else
            if (reached) cosine = augmented%metric%product_of(next%tangent, next%tangent_frequency, next%tangent_parameter, here)
            if (reached) reached = cosine > least_cosine
            if (.not. reached) call get_along(reached)
         end if
         reached = reached .and. .not. allocated(side%ended)
      end subroutine reach

      !> After a step that failed: a shorter one, across a corner where there is one, or the end of the curve.
      subroutine get_along(success)
         logical, intent(out) :: success
         logical :: at_wall
         integer :: mesh

         success = .false.
         h = h/3
         if (h > crawling) return
         crawls = crawls + 1
         at_wall = touches(augmented, here)
         if (at_wall .and. augmented%kind == 'fold' .and. is_of_half(augmented, here)) then
            call put(grazing_name('period doubling'), here)
            call finish('corner', 'meets a grazing doubling of motions of half the period at '//lambda(here%frequency_ratio))
            return
         end if
         if (at_wall) call leap(success)
         if (success) return
         ! Where it does not get across, the curve may still get along in short steps.
         if (h > shortest .and. crawls < most_crawls) return
         ! On the curve of an onset every motion touches a wall.
         if (at_wall .and. augmented%mesh == 0) then
            call put(grazing_name(augmented%kind), here)
            ! What is across the corner says more than the corner.
            if (beyond /= '') then
               call finish('limit', trim(beyond)//' near '//lambda(here%frequency_ratio))
               return
            end if
            call find_grazing_mesh(augmented, here, mesh)
            call finish('corner', 'a corner: '//trim(augmented%system%mesh_name(mesh))//' grazes a wall of its gap at '// &
                        lambda(here%frequency_ratio)//', parameter = '//text(augmented%origin + augmented%scale*here%parameter))
         else if (.not. h > shortest) then
            call finish('failed', 'Newton''s method does not converge at '//lambda(here%frequency_ratio))
         end if
      end subroutine get_along

      !> Puts `next` onto the end of the range where the step goes beyond it.
      subroutine keep_to_range(reached)
         logical, intent(out) :: reached

         reached = .true.
         landed = next%parameter < ends(1) .or. next%parameter > ends(2)
         if (.not. landed) return
         call land(merge(ends(1), ends(2), next%parameter < ends(1)), reached)
         if (.not. reached) call shorten(words_type('Newton''s method does not converge at the end of the range'))
      end subroutine keep_to_range

      !> Ends the curve before `next` where that is no special point.
      subroutine keep_to_special(reached)
         logical, intent(out) :: reached

         call limits%forbids(augmented, next, why)
         reached = why == ''
         if (.not. reached) call approach(why)
      end subroutine keep_to_special

      !> Ends the curve where it meets motions of half the period.
      subroutine pass_half(reached)
         logical, intent(out) :: reached
         logical :: meets, success

         reached = .not. passes_half(augmented, here, next)
         if (reached) return
         meets = abs(way_to_half(here)) < 2*augmented%metric%distance(here, next)
         if (meets) then
            call locate_half(augmented, here, place, success)
            if (success) then
               call put('generalized doubling', place)
               call finish('double point', words_type('a generalized doubling'))
               return
            end if
         end if
         h = h/3
         if (h > nearest_half) return
         reached = .not. meets
         if (meets) call finish('double point', 'meets the doubling of motions of half the period near '// &
                                lambda(here%frequency_ratio))
      end subroutine pass_half

      !> Lists the points between `here` and `next` at which a second condition is met; at some of them the curve ends.
      subroutine pass_tests(reached)
         logical, intent(out) :: reached
         logical :: ends_here
         integer :: k

         reached = .true.
         call find_tests(augmented, next, after)
         ! Near a zero the signs of values that rest on derivatives of before are not sure.
         if (.not. landed .and. any(after%value*before%value < 0 .or. abs(after%value) < doubtful*abs(before%value))) then
            call augmented%solve(next, .true., reached)
            if (.not. reached) then
               call shorten('Newton''s method does not converge at '//lambda(here%frequency_ratio))
               return
            end if
            call find_tests(augmented, next, after)
         end if
         do k = 1, most_tests
            if (name_of(augmented%kind, k) == '') exit
            if (.not. before%value(k)*after%value(k) < 0) cycle
            call locate(k, ends_here)
            reached = .not. ends_here
            if (ends_here) return
         end do
         if (before%events /= after%events .and. augmented%mesh == 0) then
            call locate_grazing(augmented, here, next, place)
            call put(grazing_name(augmented%kind), place)
         end if
      end subroutine pass_tests

      !> Makes `next` a point of the curve, with which it may end.
      subroutine record(goes_on)
         logical, intent(out) :: goes_on
         logical :: go

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
         side%closed = side%points > 3 .and. passes(augmented, here, next, first)
         if (side%closed) then
            call finish('closed', words_type('closed'))
         else
            call limits%ends_at(augmented, next, side%ended)
            ! A curve over the torque from 0 on is whole where the motion vanishes.
            side%at_end = allocated(side%ended) .and. limits%vanishes(augmented) .and. minval(abs(next%parameter - ends)) < near_end
            if (allocated(side%ended)) side%end_kind = merge('range', 'limit', side%at_end)
         end if
         goes_on = .not. allocated(side%ended)
      end subroutine record

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
