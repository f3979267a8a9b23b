!> Exactly where along a branch a mesh begins or ceases to separate, or its back flanks to collide: by solving the balance there.
module geartrain_branch_contact_edges
   use geartrain_base_fftw, only: transform_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_observer, only: observer_type
   use geartrain_branch_bend, only: way_to
   use geartrain_branch_branch, only: branch_type, contact_edge_type, response_settings_type
   use geartrain_branch_contact_ranges, only: depth_below
   use geartrain_branch_path, only: place_type
   use geartrain_branch_special_points, only: between, go_along, shrink
   use geartrain_branch_start, only: begin_trace, place_of
   use geartrain_branch_decided, only: joined
   use geartrain_branch_tracer, only: tracer_type
   use geartrain_model_train, only: train_type
   use geartrain_motion_motion, only: motion_type
   use geartrain_motion_trigonometric, only: extremes, fine_samples
   implicit none (type, external)
   private
   public :: locate_contact_edges

   !> Edges that are located, of a train with many meshes the first ones along the branch; the others are interpolated.
   integer, parameter :: most_edges = 1000
   integer, parameter :: most_steps = 20
   !> How exactly on the cubic; how far from the wall the tangent is exact to the square of that.
   real(dp), parameter :: located = 1e-9_dp, nearly = 1e-6_dp

contains

   !> Fills branch%contact_edges.
   subroutine locate_contact_edges(train, settings, branch, observer)
      type(train_type), intent(in) :: train
      !> Those that the branch was traced with.
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(inout), target :: branch
      class(observer_type), intent(inout), optional :: observer
      type(tracer_type) :: tracer
      type(transform_type) :: transform
      type(contact_edge_type), allocatable :: edges(:)
      type(place_type) :: here, next, place
      real(dp) :: first, last, length
      integer :: i, j, k, n
      logical :: ready, success, keep_going, back

      if (allocated(branch%contact_edges)) deallocate (branch%contact_edges)
      if (branch%points < 2 .or. .not. allocated(branch%backlash)) return
      if (.not. any(branch%backlash > 0)) return
      allocate (edges(most_edges))
      n = 0
      call begin_trace(train, settings, tracer)
      tracer%path%local_control = .false.
      do i = 1, branch%points - 1
         if (.not. joined(branch, i)) cycle
         ready = .false.
         do j = 1, branch%meshes
            if (.not. branch%backlash(j) > 0) cycle
            do k = 1, 2
               back = k == 2
               first = depth_below(branch%minimum(j, i), branch%maximum(j, i), branch%backlash(j), back)
               last = depth_below(branch%minimum(j, i + 1), branch%maximum(j, i + 1), branch%backlash(j), back)
               if (first*last >= 0 .or. n == most_edges) cycle
               if (.not. ready) then
                  call prepare_piece(i, success)
                  if (.not. success) exit
                  ready = .true.
               end if
               n = n + 1
               edges(n)%point = i
               edges(n)%mesh = j
               edges(n)%back = back
               call locate(j, back, first, last, edges(n)%frequency, success)
               if (.not. success) n = n - 1
            end do
         end do
         if (.not. (ready .and. present(observer))) cycle
         keep_going = .true.
         call observer%on_step('response', branch%points, branch%frequency(i), keep_going)
         if (.not. keep_going) exit
      end do
      branch%contact_edges = edges(:n)

   contains

      !> The points i and i + 1 as places, the first one with its tangent.
      subroutine prepare_piece(i, success)
         integer, intent(in) :: i
         logical, intent(out) :: success
         type(motion_type) :: motion

         if (settings%harmonics == 0) call tracer%prepare(maxval(branch%point_harmonics(i:i + 1)))
         call transform%plan(fine_samples(tracer%path%balance%highest))
         motion%period = branch%subharmonic
         motion%frequency = branch%frequency(i + 1)
         motion%coefficients = branch%coefficients(:, :, i + 1)
         next = place_of(tracer, motion)
         motion%frequency = branch%frequency(i)
         motion%coefficients = branch%coefficients(:, :, i)
         here = place_of(tracer, motion)
         here%tangent = next%u - here%u
         here%tangent_frequency = next%frequency - here%frequency
         next%tangent = here%tangent
         next%tangent_frequency = here%tangent_frequency
         call tracer%path%correct(here, success)
         if (success) call tracer%path%correct(next, success)
         length = way_to(here, next, tracer%path%units)
         place = here
      end subroutine prepare_piece

      !> Where the depth of mesh j is zero between `here` and `next`: first on the cubic through them, which is nearly the branch.
      subroutine locate(j, back, first, last, frequency, success)
         integer, intent(in) :: j
         logical, intent(in) :: back
         real(dp), intent(in) :: first, last
         real(dp), intent(out) :: frequency
         logical, intent(out) :: success
         real(dp) :: a, b, fa, fb, f, s, slope
         integer :: kept, step

         a = 0
         b = length
         fa = first
         fb = last
         kept = 0
         do step = 1, most_steps
            s = between(a, b, fa, fb)
            f = depth_along(s, j, back)
            if (abs(f) < located*branch%backlash(j)) exit
            call shrink(a, b, fa, fb, s, f, kept)
         end do
         a = 1e-4_dp*length
         slope = (depth_along(s + a, j, back) - depth_along(s - a, j, back))/(2*a)
         do step = 1, most_steps
            call go_along(here, next, length, s, place)
            call tracer%path%correct(place, success)
            if (.not. success) return
            f = depth_at(place, j, back)
            frequency = place%frequency - place%tangent_frequency*f/slope
            if (abs(f) < nearly*branch%backlash(j)) return
            s = s - f/slope
            if (.not. abs(s - length/2) < length) exit
         end do
         success = .false.
      end subroutine locate

      !> Depth of mesh j on the cubic.
      real(dp) function depth_along(s, j, back)
         real(dp), intent(in) :: s
         integer, intent(in) :: j
         logical, intent(in) :: back

         call go_along(here, next, length, s, place)
         depth_along = depth_at(place, j, back)
      end function depth_along

      real(dp) function depth_at(place, j, back)
         type(place_type), intent(in) :: place
         integer, intent(in) :: j
         logical, intent(in) :: back
         real(dp) :: coefficients(1 + 2*tracer%path%balance%highest, branch%meshes), smallest, largest
         integer :: k

         call tracer%path%balance%full_coefficients(place%u, place%frequency, coefficients)
         call extremes(coefficients(:, j), [(k, k=1, tracer%path%balance%highest)], transform, smallest, largest)
         depth_at = depth_below(smallest, largest, branch%backlash(j), back)
      end function depth_at

   end subroutine locate_contact_edges

end module geartrain_branch_contact_edges
