!> Corners of the curve of a special point, where the motion grazes a wall of a gap: on the side with the more contact events the
!> multipliers change by the square root of the depth beyond the wall, so that Newton's method fails next to it.
module geartrain_curves_locus_corner
   use geartrain_base_kinds, only: dp, pi
   use geartrain_curves_locus_walls, only: from_wall
   use geartrain_exact_augmented_point, only: add_tangent, augmented_point_type, scale_tangent
   use geartrain_exact_augmented_system, only: augmented_system_type
   use geartrain_exact_orbit_directions, only: along_lambda, along_null, along_parameter, find_directions
   use geartrain_linalg_border, only: border_type
   implicit none (type, external)
   private
   public :: cross_corner

   !> Steps that are tried across a corner, in the metric of the curve; the longest way to a point found, over the step; cosine of
   !> the angle between this way and the tangent there, and the least.
   real(dp), parameter :: steps(*) = [3e-3_dp, 1e-3_dp, 1e-2_dp, 1e-4_dp, 3e-2_dp], farthest = 3, least_cosine = 0.95_dp
   !> Steps up to which the tangent may lead to a corner beside the point that the curve has come to.
   real(dp), parameter :: short = 2e-3_dp
   !> Angles to the wall at which they are tried, each half the one before.
   integer, parameter :: angles = 18
   !> Depth at which a step ends that leads beyond the wall, over the size of the motion: nearer to it the curve is hard to follow.
   real(dp), parameter :: deep = 1e-6_dp
   !> Distance of a point from the tangent of another one, over its distance from that point, below which it is on its curve.
   real(dp), parameter :: aside_share = 0.2_dp
   !> Length of the difference for the angle of the wall.
   real(dp), parameter :: small = 1e-7_dp

contains

   !> Finds a point of the curve beyond a corner, with more or fewer events, whose tangent leads to the corner.
   !> Of the two directions in which orbits go on from the corner one leaves the distance from the wall as it is. With fewer events
   !> the curve leaves the wall at some angle. With more it leaves along the wall, to this side or that; there Newton's method needs
   !> a guess of about the right depth.
   subroutine cross_corner(augmented, here, before, next, success)
      !> The system of the special point, solved at `here`.
      type(augmented_system_type), intent(inout) :: augmented
      !> A point next to a corner, with its tangent.
      type(augmented_point_type), intent(in) :: here
      !> The point before the latest corner, if there was one: the curve that led to it is not taken.
      type(augmented_point_type), intent(in) :: before
      !> The point beyond the corner, with its tangent; its bend is not known.
      type(augmented_point_type), intent(inout) :: next
      !> Whether there is one.
      logical, intent(out) :: success
      type(augmented_point_type) :: along, across, corner
      type(border_type) :: plus, minus
      real(dp) :: way, angle, gap, rise(2)
      integer :: i, j, sense, info

      success = .false.
      across = here
      call turn_aside(augmented, across, info)
      if (info /= 0) return
      gap = from_wall(augmented, here)
      rise = [(from_wall(augmented, moved(here, small)) - gap)/small, (from_wall(augmented, moved(across, small)) - gap)/small]
      if (.not. norm2(rise) > 0) return
      along = here
      call scale_tangent(along, rise(2)/norm2(rise))
      call add_tangent(along, -rise(1)/norm2(rise), across)
      ! Towards the wall and beyond it.
      call scale_tangent(across, -rise(2)/norm2(rise))
      call add_tangent(across, -rise(1)/norm2(rise), here)
      corner = moved(across, gap/norm2(rise))
      plus = augmented%plus
      minus = augmented%minus
      do i = 1, size(steps)
         do sense = 1, -1, -2
            angle = pi/2
            do j = 1, angles
               next = corner
               call scale_tangent(next, sin(angle))
               call add_tangent(next, sense*cos(angle), along)
               next = moved(next, steps(i))
               augmented%plus = plus
               augmented%minus = minus
               call augmented%solve(next, .true., success)
               angle = angle/2
               if (success) success = next%events /= here%events
               if (.not. success) cycle
               way = augmented%metric%product_of(next%states - here%states, next%frequency_ratio - here%frequency_ratio, &
                                                 next%parameter - here%parameter, next)
               success = abs(way) < farthest*steps(i) .and. (abs(way) > least_cosine*augmented%metric%distance(here, next) &
                                                             .or. begins_at(augmented, next, here, sign(steps(i), way)))
               if (success .and. allocated(before%states)) success = .not. lies_behind(augmented, next, before)
               if (success .and. next%events > here%events) success = from_wall(augmented, next) > deep
               if (.not. success) cycle
               if (way < 0) call scale_tangent(next, -1.0_dp)
               if (allocated(next%bend)) deallocate (next%bend)
               return
            end do
         end do
      end do
      augmented%plus = plus
      augmented%minus = minus
   end subroutine cross_corner

   !> Turns the tangent of a point to the other direction in which orbits go on from there, square to the tangent in the metric.
   subroutine turn_aside(augmented, point, info)
      type(augmented_system_type), intent(inout) :: augmented
      !> A point with its tangent.
      type(augmented_point_type), intent(inout) :: point
      !> 0: turned.
      integer, intent(out) :: info
      type(augmented_point_type) :: aside(2)
      real(dp) :: step(size(point%states, 1), size(point%states, 2), 4), h(4), norm(2)
      integer :: i

      call augmented%stand_at(point%parameter, .false.)
      call augmented%moving%fly(point%frequency_ratio, point%states)
      call find_directions(augmented%moving, augmented%plus, .true., step, h, info)
      if (info /= 0) return
      ! Orbits are closed in two directions; one of them at least is not the tangent.
      do i = 1, 2
         aside(i) = point
         associate (l => merge(-h(along_null), h(along_parameter), i == 1), m => merge(0.0_dp, -h(along_lambda), i == 1))
            aside(i)%tangent = l*step(:, :, along_lambda) + m*step(:, :, along_parameter)
            if (i == 1) aside(i)%tangent = aside(i)%tangent + h(along_lambda)*step(:, :, along_null)
            aside(i)%tangent_frequency = l
            aside(i)%tangent_parameter = m
         end associate
         norm(i) = sqrt(product_with(aside(i)))
         if (norm(i) > 0) call scale_tangent(aside(i), 1/norm(i))
         call add_tangent(aside(i), -product_with(point), point)
         norm(i) = product_with(aside(i))
      end do
      i = maxloc(norm, 1)
      point = aside(i)
      call scale_tangent(point, 1/sqrt(norm(i)))

   contains

      !> Product of the tangent that is turned with another one.
      real(dp) function product_with(other)
         type(augmented_point_type), intent(in) :: other

         product_with = augmented%metric%product_of(aside(i)%tangent, aside(i)%tangent_frequency, aside(i)%tangent_parameter, other)
      end function product_with

   end subroutine turn_aside

   !> Whether the curve of a point, followed straight on towards the wall, ends near another point.
   logical function begins_at(augmented, point, other, step)
      type(augmented_system_type), intent(inout) :: augmented
      type(augmented_point_type), intent(in) :: point, other
      !> Length of the step from the other point; negative where the tangent points to the wall.
      real(dp), intent(in) :: step
      real(dp) :: gap, rise

      begins_at = .false.
      if (abs(step) > short) return
      gap = from_wall(augmented, point)
      rise = (from_wall(augmented, moved(point, sign(small, step))) - gap)/small
      if (.not. rise > 0) return
      begins_at = augmented%metric%distance(moved(point, -sign(gap/rise, step)), other) < 2*abs(step)
   end function begins_at

   !> Whether a point lies on the curve that led to another one.
   pure logical function lies_behind(augmented, point, other)
      type(augmented_system_type), intent(in) :: augmented
      type(augmented_point_type), intent(in) :: point, other
      real(dp) :: way, apart

      way = augmented%metric%product_of(point%states - other%states, point%frequency_ratio - other%frequency_ratio, &
                                        point%parameter - other%parameter, other)
      apart = augmented%metric%distance(point, other)
      lies_behind = way < 0 .and. apart**2 - way**2 < (aside_share*apart)**2
   end function lies_behind

   !> A point moved along its tangent.
   pure function moved(point, way) result(there)
      type(augmented_point_type), intent(in) :: point
      real(dp), intent(in) :: way
      type(augmented_point_type) :: there

      there = point
      there%states = point%states + way*point%tangent
      there%frequency_ratio = point%frequency_ratio + way*point%tangent_frequency
      there%parameter = point%parameter + way*point%tangent_parameter
   end function moved

end module geartrain_curves_locus_corner
