!> The torque of a coupling over its twist: a polygon that goes on beyond its ends. In each part of it
!>    torque = slope (twist - origin).
!> Twists are counted from the middle of the play or, without play, from the twist without torque.
module geartrain_mesh_law_characteristic
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: characteristic_type, ascends, find_characteristic

   type :: characteristic_type
      !> First and last part: those of positive torque from 1 on, the play 0, those of negative torque down from -1. Without play
      !> all from 1 on.
      integer :: lowest = 1, highest = 1
      !> Twists between parts s and s + 1 [rad], ascending, (lowest:highest - 1); slopes [N m/rad] and origins [rad],
      !> (lowest:highest).
      real(dp), allocatable :: corner(:), slope(:), origin(:)
      !> Half of the play [rad]; slope beside the play on the side of positive torques or, without play, at rest without load
      !> [N m/rad], 0: the polygon is not in order.
      real(dp) :: half_play = 0, stiffness = 0
      !> Twist as given from which twists are counted [rad].
      real(dp) :: middle = 0
   end type characteristic_type

contains

   !> Finds the parts: of the polygon, if it has any corners, else of one slope beside the play.
   pure subroutine find_characteristic(stiffness, half_play, angle, torque, found)
      !> One slope [N m/rad]; half of the play [rad].
      real(dp), intent(in) :: stiffness, half_play
      !> Corners of a polygon, [rad] and [N m], (corner); not allocated or empty: none.
      real(dp), allocatable, intent(in) :: angle(:), torque(:)
      !> The parts.
      type(characteristic_type), intent(out) :: found
      logical :: polygon

      polygon = .false.
      if (allocated(angle)) polygon = size(angle) > 0
      if (.not. polygon) then
         found%stiffness = stiffness
         found%half_play = half_play
         if (half_play > 0) then
            call make_room(found, -1, 3)
            found%corner(:) = [-half_play, half_play]
            found%slope(:) = [stiffness, 0.0_dp, stiffness]
            found%origin(:) = [-half_play, 0.0_dp, half_play]
         else
            call make_room(found, 1, 1)
            found%slope = stiffness
         end if
      else if (ascends(angle, torque)) then
         call take_polygon(angle, torque, found)
      else
         call make_room(found, 1, 1)
      end if
   end subroutine find_characteristic

   !> Whether corners make a characteristic with one rest under every torque: angles ascend; torques ascend, but for a play, within
   !> which they are 0.
   pure logical function ascends(angle, torque)
      !> Corners, [rad] and [N m], (corner).
      real(dp), allocatable, intent(in) :: angle(:), torque(:)
      integer :: n

      ascends = .false.
      if (.not. (allocated(angle) .and. allocated(torque))) return
      n = size(angle)
      if (n < 2 .or. size(torque) /= n) return
      ascends = all(angle(2:) > angle(:n - 1)) .and. torque(2) > torque(1) .and. torque(n) > torque(n - 1) &
                .and. all(torque(2:) > torque(:n - 1) .or. .not. (abs(torque(2:)) > 0 .or. abs(torque(:n - 1)) > 0))
   end function ascends

   pure subroutine make_room(found, lowest, parts)
      type(characteristic_type), intent(inout) :: found
      integer, intent(in) :: lowest, parts

      found%lowest = lowest
      found%highest = lowest + parts - 1
      allocate (found%corner(lowest:found%highest - 1), found%slope(lowest:found%highest), &
                found%origin(lowest:found%highest), source=0.0_dp)
   end subroutine make_room

   !> The parts of a polygon that `ascends`.
   pure subroutine take_polygon(angle, torque, found)
      real(dp), intent(in) :: angle(:), torque(:)
      type(characteristic_type), intent(inout) :: found
      logical :: kept(size(angle))
      real(dp), allocatable :: x(:), y(:), slope(:)
      integer :: i, parts, rest

      ! A corner amid the play is none.
      kept = .true.
      do i = 2, size(angle) - 1
         kept(i) = any(abs(torque(i - 1:i + 1)) > 0)
      end do
      x = pack(angle, kept)
      y = pack(torque, kept)
      parts = size(x) - 1
      slope = (y(2:) - y(:parts))/(x(2:) - x(:parts))
      rest = findloc(slope > 0, .false., 1)
      if (rest > 0) then
         call make_room(found, 1 - rest, parts)
         found%middle = (x(rest) + x(rest + 1))/2
         found%half_play = (x(rest + 1) - x(rest))/2
         found%stiffness = slope(rest + 1)
      else
         call make_room(found, 1, parts)
         rest = findloc(y(2:) > 0, .true., 1)
         if (rest == 0) rest = parts
         found%middle = x(rest) - y(rest)/slope(rest)
         found%stiffness = slope(rest)
      end if
      found%slope(:) = slope
      found%corner(:) = x(2:parts) - found%middle
      do i = 1, parts
         if (slope(i) > 0) found%origin(found%lowest + i - 1) = x(i) - found%middle - y(i)/slope(i)
      end do
      if (found%lowest < 0) then
         ! Without rounding: the play reaches as far to both sides, and what bears begins to bear there.
         found%corner(-1:0) = [-found%half_play, found%half_play]
         found%origin(-1:1) = [-found%half_play, 0.0_dp, found%half_play]
      else
         found%origin(rest) = 0
      end if
   end subroutine take_polygon

end module geartrain_mesh_law_characteristic
