!> Rows of a bearing whose clearance has more than four flats: beside x and y the directions between them.
!>
!> A bearing with 2 n flats has n rows at angles i pi/n, each with the same clearance and 2/n of the stiffness and the damping, so
!> that without clearance they are together those of the bearing in every direction.
module geartrain_train_bearing_rows
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_numbers, only: number_text => text
   use geartrain_train_mesh, only: mesh_type, new_bearing
   implicit none (type, external)
   private
   public :: add_rows, flats_known, put_rows, row_direction, row_text

   !> Numbers of flats that there may be: the angles between them are multiples of 7.5 or 11.25 degrees.
   integer, parameter :: flats_known(5) = [4, 8, 12, 16, 24]

contains

   !> Adds the rows of all bearings beside x and y behind the meshes of a train, which has none yet.
   pure subroutine add_rows(meshes)
      !> The meshes.
      type(mesh_type), allocatable, intent(inout) :: meshes(:)
      type(mesh_type), allocatable :: found(:)
      integer :: i, k, n

      n = size(meshes)
      do i = 1, size(meshes)
         if (has_rows(i)) n = n + meshes(i)%flats/2 - 2
      end do
      if (n == size(meshes)) return
      allocate (found(n))
      n = size(meshes)
      found(:n) = meshes
      do i = 1, size(meshes)
         if (.not. has_rows(i)) cycle
         do k = 3, meshes(i)%flats/2
            n = n + 1
            found(n) = new_bearing(k)
            found(n)%between = meshes(i)%between
            found(n)%flats = meshes(i)%flats
         end do
      end do
      call move_alloc(found, meshes)

   contains

      pure logical function has_rows(i)
         integer, intent(in) :: i

         has_rows = meshes(i)%axis == 1 .and. meshes(i)%flats > 4 .and. any(meshes(i)%flats == flats_known)
      end function has_rows

   end subroutine add_rows

   !> Gives each row of a bearing its share of the stiffness and the damping; those of a plain train keep theirs.
   pure subroutine put_rows(meshes)
      !> The meshes.
      type(mesh_type), intent(inout) :: meshes(:)
      real(dp) :: share
      integer :: i, k

      do i = 1, size(meshes)
         if (meshes(i)%axis /= 1 .and. meshes(i)%axis /= 2) cycle
         share = 4/real(max(4, meshes(i)%flats), dp)
         meshes(i)%stiffness = share/meshes(i)%share*meshes(i)%stiffness
         meshes(i)%damping = share/meshes(i)%share*meshes(i)%damping
         meshes(i)%share = share
         if (meshes(i)%axis == 2) cycle
         do k = i + 2, size(meshes)
            if (meshes(k)%axis < 3 .or. meshes(k)%between(1) /= meshes(i)%between(1)) cycle
            meshes(k)%stiffness = meshes(i)%stiffness
            meshes(k)%damping = meshes(i)%damping
            meshes(k)%half_backlash = meshes(i)%half_backlash
            meshes(k)%mass = meshes(i)%mass
         end do
      end do
   end subroutine put_rows

   !> Unit vector of a row, x and y [1].
   pure function row_direction(row) result(direction)
      !> The row.
      type(mesh_type), intent(in) :: row
      real(dp) :: direction(2)

      direction = [cos(angle_of(row)*pi/180), sin(angle_of(row)*pi/180)]
      if (row%axis < 3) direction = merge([1, 0], [0, 1], row%axis == 1)
   end function row_direction

   !> 'x', 'y', or the angle from the x axis in degrees, '22.5'.
   pure function row_text(row) result(text)
      !> The row.
      type(mesh_type), intent(in) :: row
      character(6) :: text

      text = merge('x', 'y', row%axis == 1)
      if (row%axis > 2) text = number_text(angle_of(row))
   end function row_text

   !> Angle of a row from the x axis [degree].
   pure real(dp) function angle_of(row) result(angle)
      type(mesh_type), intent(in) :: row
      integer :: i

      ! The rows but x and y: 1 to n - 1 without n/2.
      i = row%axis - 2
      if (i >= row%flats/4) i = i + 1
      if (row%axis == 1) i = 0
      if (row%axis == 2) i = row%flats/4
      angle = 360*i/real(row%flats, dp)
   end function angle_of

end module geartrain_train_bearing_rows
