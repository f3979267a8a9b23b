!> The line of action of a gear pair in the transverse plane: the direction in which the driving gear pushes the driven gear.
!>
!> With the unit vector u from the axis of the driving gear to the pitch point, the unit vector v, u turned by 90 degrees in the
!> sense in which the driving gear turns, and the working pressure angle a, the direction is cos(a) v + sin(a) u: the flanks push
!> the gears apart. A driving ring pulls the pinion inside it outwards: cos(a) v - sin(a) u.
module geartrain_train_line_of_action
   use geartrain_base_kinds, only: dp, pi
   use geartrain_train_mesh, only: is_given
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: find_line, is_far, is_near, is_unplaced

   !> What a line may lack: the position of an axis; axes so near that the base circles overlap, or so far apart that no gears mesh.
   integer, parameter :: is_unplaced = 1, is_near = 2, is_far = 3
   !> Cosine of the largest working pressure angle, 60 degrees [1].
   real(dp), parameter :: least_cosine = 0.5_dp

contains

   !> Finds the line of action of a gear pair.
   pure subroutine find_line(train, ends, sense, mesh, direction, lacks)
      !> A plain train with bodies.
      type(train_type), intent(in) :: train
      !> Driving and driven body; sense in which the driving body turns, 1 from x to y; number of the mesh.
      integer, intent(in) :: ends(2), sense, mesh
      !> Unit vector [1]; 0 where the line lacks anything.
      real(dp), intent(out) :: direction(2)
      !> What the line lacks; 0: nothing.
      integer, intent(out) :: lacks
      real(dp) :: base, distance, cosine, u(2)

      lacks = 0
      direction = 0
      associate (pair => train%meshes(mesh), driving => train%bodies(ends(1)), driven => train%bodies(ends(2)))
         if (pair%line_given) then
            direction = [cos(pair%line_of_action*pi/180), sin(pair%line_of_action*pi/180)]
         else if (.not. (is_placed(driving%position) .and. is_placed(driven%position))) then
            lacks = is_unplaced
         else
            u = driven%position - driving%position
            distance = norm2(u)
            base = pair%driving_radius + pair%driven_radius
            if (pair%internal) base = abs(pair%driving_radius - pair%driven_radius)
            if (base > distance) lacks = is_near
            if (base < least_cosine*distance) lacks = is_far
            if (lacks > 0) return
            u = u/distance
            cosine = base/distance
            if (pair%internal .and. pair%driven_radius > pair%driving_radius) u = -u
            direction = sense*cosine*[-u(2), u(1)]
            associate (sine => sqrt((1 - cosine)*(1 + cosine)))
               if (pair%internal .and. pair%driving_radius > pair%driven_radius) then
                  direction = direction - sine*u
               else
                  direction = direction + sine*u
               end if
            end associate
         end if
      end associate
      ! A right angle is one: rounding would couple what is not coupled.
      where (abs(direction) < 4*epsilon(1.0_dp)) direction = 0

   contains

      pure logical function is_placed(position)
         real(dp), allocatable, intent(in) :: position(:)

         is_placed = is_given(position)
         if (is_placed) is_placed = size(position) == 2
      end function is_placed

   end subroutine find_line

end module geartrain_train_line_of_action
