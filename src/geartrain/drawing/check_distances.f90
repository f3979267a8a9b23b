!> Checks that the axes of drawn gears are as far apart by their positions as by the drawing.
module geartrain_drawing_check_distances
   use geartrain_base_checker, only: checker_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_drawing_drawing, only: has_geometry, pair_of
   use geartrain_drawing_gear_pair, only: find_geometry, pair_geometry_type
   use geartrain_train_bodies, only: find_ends
   use geartrain_train_mesh, only: is_given
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: check_distances

   !> Relative difference of two distances that is rounding of a drawing [1]; it turns the line of action by less than 0.2 degrees.
   real(dp), parameter :: rounding = 1e-3_dp

contains

   !> Adds a problem for every drawn mesh whose axes are elsewhere.
   subroutine check_distances(train, checker)
      !> The train as given, with any values.
      type(train_type), intent(in) :: train
      class(checker_type), intent(inout) :: checker
      type(pair_geometry_type) :: geometry
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      integer :: i

      if (.not. (allocated(train%bodies) .and. allocated(train%shafts) .and. allocated(train%meshes))) return
      if (.not. any(train%meshes%axis > 0)) return
      call find_ends(train, shaft_ends, mesh_ends)
      do i = 1, size(train%meshes)
         associate (mesh => train%meshes(i), ends => mesh_ends(:, i))
            if (mesh%line_given .or. .not. has_geometry(mesh) .or. any(ends == 0)) cycle
            if (.not. (is_given(train%bodies(ends(1))%position) .and. is_given(train%bodies(ends(2))%position))) cycle
            if (any([size(train%bodies(ends(1))%position), size(train%bodies(ends(2))%position)] /= 2)) cycle
            call find_geometry(pair_of(mesh), geometry)
            associate (distance => norm2(train%bodies(ends(2))%position - train%bodies(ends(1))%position))
               if (abs(distance - geometry%centre_distance) <= rounding*geometry%centre_distance) cycle
               call checker%enter('mesh', i)
               call checker%complain('between', "'"//trim(mesh%between(1))//"' and '"//trim(mesh%between(2))//"'", &
                  'have axes '//text(distance)//' m apart by their positions, '//text(geometry%centre_distance)// &
                  ' m by the drawing: correct position, or give centre_distance')
               call checker%leave()
            end associate
         end associate
      end do
   end subroutine check_distances

end module geartrain_drawing_check_distances
