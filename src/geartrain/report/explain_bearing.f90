!> What a bearing, and the line of action of a mesh on bearings, is in numbers.
module geartrain_report_explain_bearing
   use geartrain_base_carry, only: carry
   use geartrain_base_field, only: field_type
   use geartrain_base_fields, only: fields_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_numbers, only: integer_text
   use geartrain_network_system, only: system_type
   use geartrain_train_bearing_rows, only: row_direction
   use geartrain_train_bodies, only: find_ends
   use geartrain_train_line_of_action, only: find_line
   use geartrain_train_mesh_groups, only: group_number
   use geartrain_train_train, only: train_type
   use geartrain_train_turning, only: find_turning, turning_type
   implicit none (type, external)
   private
   public :: explain_bearing, explain_line

contains

   !> Adds the group of a bearing.
   subroutine explain_bearing(train, system, i, fields)
      !> The train as given.
      type(train_type), intent(in) :: train
      !> Its system.
      type(system_type), intent(in) :: system
      !> Number of the direction x among all meshes; the direction y follows.
      integer, intent(in) :: i
      !> Gets the fields.
      class(fields_type), intent(inout) :: fields
      real(dp), allocatable :: list(:)
      real(dp) :: value, corner
      integer :: flats, k

      if (.not. fields%enter('bearing '//integer_text(group_number(train%meshes, i)), 'of '//trim(train%meshes(i)%between(1)), &
                             .true.)) return
      associate (bearing => train%meshes(i:i + 1))
         value = bearing(1)%mass
         call carry(fields, field_type('mass', '', 'kg', 'as given'), value)
         list = bearing%stiffness
         call carry(fields, field_type('stiffness', 'axis', 'N/m', 'x and y, as given'), list)
         list = bearing%damping
         call carry(fields, field_type('damping', 'axis', 'N s/m', 'x and y'), list)
         value = bearing(1)%half_backlash
         call carry(fields, field_type('half_clearance', '', 'm', 'as given'), value)
      end associate
      list = system%static_force(system%mesh_element(i:i + 1))*system%load_unit(i:i + 1)
      do k = i + 2, size(train%meshes)
         if (train%meshes(k)%axis > 2 .and. train%meshes(k)%between(1) == train%meshes(i)%between(1)) &
            list = list + system%static_force(system%mesh_element(k))*system%load_unit(k)*row_direction(train%meshes(k))
      end do
      call carry(fields, field_type('mean_force', 'axis', 'N', 'x and y, static, from the mesh forces'), list)
      if (.not. value > 0) return
      flats = train%meshes(i)%flats
      call carry(fields, field_type('flats', '', '', 'as given: so many springs in a ring, each with half_clearance'), flats)
      corner = value/cos(pi/flats)
      call carry(fields, field_type('corner_clearance', '', 'm', 'half_clearance/cos(180 degrees/flats), in the corners of the &
         &polygon; that of a circle is half_clearance'), corner)
      if (flats > 4 .or. .not. norm2(list) > 0) return
      value = value*sum(abs(list))/norm2(list)
      call carry(fields, field_type('loaded_clearance', '', 'm', 'play in the direction of the mean force: the flats of the &
         &directions x and y are a square. The play of a circle is half_clearance in every direction'), value)
   end subroutine explain_bearing

   !> Adds the line of action of a mesh of which a body is on a bearing.
   subroutine explain_line(train, i, fields)
      !> The plain train.
      type(train_type), intent(in) :: train
      !> Number of the mesh.
      integer, intent(in) :: i
      !> Gets the fields, in the group of the mesh.
      class(fields_type), intent(inout) :: fields
      type(turning_type) :: turning
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      character(:), allocatable :: words
      real(dp) :: direction(2), angle
      integer :: lacks

      if (.not. any(train%meshes%axis > 0)) return
      call find_ends(train, shaft_ends, mesh_ends)
      if (.not. any(train%meshes%axis == 1 .and. (mesh_ends(1, :) == mesh_ends(1, i) .or. &
                                                  mesh_ends(1, :) == mesh_ends(2, i)))) return
      call find_turning(train, turning)
      call find_line(train, mesh_ends(:, i), turning%sense(mesh_ends(1, i)), i, direction, lacks)
      angle = atan2(direction(2), direction(1))*180/pi
      words = 'from the positions of the axes and the base radii: cos(pressure angle) is the sum of the base radii, for an &
         &internal pair their difference, over the distance'
      if (train%meshes(i)%line_given) words = 'as given'
      call carry(fields, field_type('line_of_action', '', 'degree', 'direction in which the driving gear pushes the driven gear, &
         &from x towards y; '//words), angle)
   end subroutine explain_line

end module geartrain_report_explain_bearing
