!> Speeds of the bodies of a train whose meshes all have teeth, and the orders of the fundamental that follow.
!>
!> A body turns `rate` times per turn of the first body, a ratio of whole numbers. The fundamental is the greatest common divisor of
!> all mesh frequencies and of the speeds of bodies with a torque of their own revolution: the frequency at which all repeats.
module geartrain_model_kinematics
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_base_kinds, only: dp
   use geartrain_model_bodies, only: body_count, find_ends
   use geartrain_model_mesh, only: is_given
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: kinematics_type, all_toothed, find_kinematics, greatest_divisor

   !> Largest whole number of a rate: the product of two such numbers and a number of teeth does not overflow.
   integer(int64), parameter :: most = 2_int64**22

   type :: kinematics_type
      !> Whether orders and speeds were found; .false. also where a number exceeds 2^22.
      logical :: known = .false.
      !> Turns per turn of the first body as numerator and denominator, (2, body); turns of the first body per period of the
      !> fundamental are fundamental(2)/fundamental(1).
      integer(int64), allocatable :: rate(:, :)
      integer(int64) :: fundamental(2) = [1_int64, 1_int64]
      !> Mesh frequency and revolution of a body as multiples of the fundamental, (mesh) and (body); revolution_order is 0 where the
      !> body has no torque of its own revolution.
      integer, allocatable :: order(:), revolution_order(:)
      !> Number of the body whose revolutions are the speed, 0: no body has the name; its turns per period of the fundamental [1].
      integer :: speed_body = 1
      real(dp) :: speed_ratio = 0
   end type kinematics_type

contains

   !> Whether every mesh has the numbers of teeth of both gears.
   pure logical function all_toothed(train)
      !> The train; its meshes are allocated.
      type(train_type), intent(in) :: train
      integer :: i

      all_toothed = size(train%meshes) > 0
      do i = 1, size(train%meshes)
         if (.not. all_toothed) return
         all_toothed = is_given(train%meshes(i)%teeth)
         if (all_toothed) all_toothed = size(train%meshes(i)%teeth) == 2
         if (all_toothed) all_toothed = all(train%meshes(i)%teeth >= 1 .and. train%meshes(i)%teeth <= 1e5_dp)
      end do
   end function all_toothed

   !> Finds speeds and orders; not `known` where a mesh has no teeth, a name is unknown or bodies are not joined.
   pure subroutine find_kinematics(train, found)
      !> The train; its shafts and meshes are allocated, with M shafts and M - 1 meshes in a chain.
      type(train_type), intent(in) :: train
      !> Speeds and orders.
      type(kinematics_type), intent(out) :: found
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      integer(int64) :: common, divisor, multiple
      logical :: fits
      integer :: i

      allocate (found%rate(2, body_count(train)), source=0_int64)
      allocate (found%order(size(train%meshes)), found%revolution_order(body_count(train)), source=0)
      if (.not. all_toothed(train)) return
      call find_ends(train, shaft_ends, mesh_ends)
      if (any(shaft_ends == 0) .or. any(mesh_ends == 0)) return
      ! A train that is held vibrates about its rest.
      if (allocated(train%bodies)) then
         if (any(train%bodies%held .or. train%bodies%stiffness_to_ground > 0)) return
      end if
      call hand_on(train, shaft_ends, mesh_ends, found%rate)
      if (any(found%rate == 0)) return
      found%speed_body = 1
      if (allocated(train%bodies) .and. train%speed_of /= '') then
         do i = size(train%bodies), 0, -1
            found%speed_body = i
            if (i == 0) return
            if (.not. allocated(train%bodies(i)%name)) cycle
            if (train%bodies(i)%name == train%speed_of) exit
         end do
      end if
      ! All frequencies over the frequency of the first body, as multiples of 1/common.
      common = 1
      do i = 1, size(found%rate, 2)
         common = common*(found%rate(2, i)/greatest_divisor(common, found%rate(2, i)))
         if (common > most) return
      end do
      divisor = 0
      fits = .true.
      do i = 1, size(train%meshes)
         multiple = int(train%meshes(i)%teeth(1), int64)*found%rate(1, mesh_ends(1, i))*(common/found%rate(2, mesh_ends(1, i)))
         fits = fits .and. multiple > 0 .and. multiple/common <= most
         divisor = greatest_divisor(divisor, multiple)
      end do
      do i = 1, size(found%rate, 2)
         if (.not. turns(train, i)) cycle
         divisor = greatest_divisor(divisor, found%rate(1, i)*(common/found%rate(2, i)))
      end do
      do i = 1, size(train%meshes)
         multiple = int(train%meshes(i)%teeth(1), int64)*found%rate(1, mesh_ends(1, i))*(common/found%rate(2, mesh_ends(1, i)))
         fits = fits .and. multiple/divisor <= most
         if (fits) found%order(i) = int(multiple/divisor)
      end do
      do i = 1, size(found%rate, 2)
         if (.not. turns(train, i)) cycle
         multiple = found%rate(1, i)*(common/found%rate(2, i))/divisor
         fits = fits .and. multiple <= most
         if (fits) found%revolution_order(i) = int(multiple)
      end do
      if (.not. fits) return
      multiple = greatest_divisor(divisor, common)
      found%fundamental = [divisor, common]/multiple
      associate (rate => found%rate(:, found%speed_body))
         found%speed_ratio = real(rate(1), dp)/real(rate(2), dp)*(real(common, dp)/real(divisor, dp))
      end associate
      found%known = .true.
   end subroutine find_kinematics

   !> Whether a body has a torque of its own revolution.
   pure logical function turns(train, body)
      type(train_type), intent(in) :: train
      !> Number of the body.
      integer, intent(in) :: body

      turns = .false.
      if (.not. allocated(train%bodies)) return
      turns = is_given(train%bodies(body)%revolution_torque_cos) .or. is_given(train%bodies(body)%revolution_torque_sin)
   end function turns

   !> Finds the rates from the first body on, over shafts and meshes; a body that is not reached, or whose rate has a number beyond
   !> `most`, keeps 0.
   pure subroutine hand_on(train, shaft_ends, mesh_ends, rate)
      type(train_type), intent(in) :: train
      !> Bodies that each shaft and each mesh joins, (2, shaft) and (2, mesh).
      integer, intent(in) :: shaft_ends(:, :), mesh_ends(:, :)
      !> Numerator and denominator, (2, body).
      integer(int64), intent(inout) :: rate(:, :)
      logical :: changed
      integer :: i

      rate = 0
      rate(:, 1) = 1
      changed = .true.
      do while (changed)
         changed = .false.
         do i = 1, size(shaft_ends, 2)
            call pass(rate, shaft_ends(:, i), [1_int64, 1_int64], changed)
         end do
         do i = 1, size(mesh_ends, 2)
            call pass(rate, mesh_ends(:, i), int(train%meshes(i)%teeth, int64), changed)
         end do
      end do
   end subroutine hand_on

   !> Hands the rate of one end of a joint to the other end, if just one of them is known.
   pure subroutine pass(rate, ends, teeth, changed)
      !> Numerator and denominator, (2, body).
      integer(int64), intent(inout) :: rate(:, :)
      integer, intent(in) :: ends(2)
      !> rate(ends(1))*teeth(1) = rate(ends(2))*teeth(2).
      integer(int64), intent(in) :: teeth(2)
      logical, intent(inout) :: changed
      integer(int64) :: next(2)
      integer :: from

      if (rate(1, ends(1)) /= 0 .eqv. rate(1, ends(2)) /= 0) return
      from = merge(1, 2, rate(1, ends(1)) /= 0)
      next = rate(:, ends(from))/greatest_divisor(rate(1, ends(from)), rate(2, ends(from)))
      next = next*[teeth(from), teeth(3 - from)]
      next = next/greatest_divisor(next(1), next(2))
      if (any(next > most)) return
      rate(:, ends(3 - from)) = next
      changed = .true.
   end subroutine pass

   !> Greatest common divisor of two numbers >= 0, of which one may be 0.
   elemental integer(int64) function greatest_divisor(a, b) result(divisor)
      !> The numbers.
      integer(int64), intent(in) :: a, b
      integer(int64) :: x, y, rest

      x = a
      y = b
      do while (y /= 0)
         rest = mod(x, y)
         x = y
         y = rest
      end do
      divisor = x
   end function greatest_divisor

end module geartrain_model_kinematics
