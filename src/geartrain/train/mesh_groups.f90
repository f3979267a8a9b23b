!> Which meshes of a train are gear pairs, couplings and bearings: each kind is counted by itself in a case, and all stand in one
!> list, a bearing with its two directions.
module geartrain_train_mesh_groups
   use geartrain_base_checker, only: checker_type
   use geartrain_base_numbers, only: integer_text
   use geartrain_train_bearing_rows, only: row_text
   use geartrain_train_mesh, only: mesh_type
   implicit none (type, external)
   private
   public :: enter_mesh, group_length, group_name, group_number, mesh_word, place_of, short_word

   !> Most characters of the name of a group.
   integer, parameter :: group_length = 8

contains

   !> Name of the group of a mesh, 'mesh', 'coupling' or 'bearing'.
   pure function group_name(meshes, i) result(name)
      !> The meshes of the train.
      type(mesh_type), intent(in) :: meshes(:)
      !> Number among them.
      integer, intent(in) :: i
      character(group_length) :: name

      name = merge('coupling', 'mesh    ', meshes(i)%is_coupling)
      if (meshes(i)%axis > 0) name = 'bearing'
   end function group_name

   !> Number of a mesh among the groups of its name.
   pure integer function group_number(meshes, i)
      !> The meshes of the train.
      type(mesh_type), intent(in) :: meshes(:)
      !> Number among them.
      integer, intent(in) :: i

      if (meshes(i)%axis > 2) then
         group_number = count(meshes(:findloc(meshes%axis == 1 .and. meshes%between(1) == meshes(i)%between(1), .true., 1))%axis &
                              == 1)
      else if (meshes(i)%axis > 0) then
         group_number = count(meshes(:i)%axis == 1)
      else
         group_number = count(meshes(:i)%axis == 0 .and. (meshes(:i)%is_coupling .eqv. meshes(i)%is_coupling))
      end if
   end function group_number

   !> Number among all meshes of number `n` of a group, of a bearing its x direction; 0: there is none.
   pure integer function place_of(meshes, group, n) result(i)
      !> The meshes of the train.
      type(mesh_type), intent(in) :: meshes(:)
      !> 'mesh', 'coupling' or 'bearing'.
      character(*), intent(in) :: group
      !> Number in the group.
      integer, intent(in) :: n

      do i = 1, size(meshes)
         if (group_name(meshes, i) == group .and. group_number(meshes, i) == n) return
      end do
      i = 0
   end function place_of

   !> 'mesh 2', 'coupling 1', 'bearing 1 x', 'bearing 1 22.5' (degrees).
   pure function mesh_word(meshes, i) result(word)
      !> The meshes of the train.
      type(mesh_type), intent(in) :: meshes(:)
      !> Number among them.
      integer, intent(in) :: i
      character(group_length + 12) :: word

      word = trim(group_name(meshes, i))//' '//integer_text(group_number(meshes, i))
      if (meshes(i)%axis > 0) word = trim(word)//' '//row_text(meshes(i))
   end function mesh_word

   !> 'mesh 2', 'coupl 1', 'brg 1 x': the head of a narrow column.
   pure function short_word(meshes, i) result(word)
      !> The meshes of the train.
      type(mesh_type), intent(in) :: meshes(:)
      !> Number among them.
      integer, intent(in) :: i
      character(group_length + 12) :: word

      word = mesh_word(meshes, i)
      if (meshes(i)%is_coupling) word = 'coupl'//word(len('coupling') + 1:)
      if (meshes(i)%axis > 0) word = 'brg'//word(len('bearing') + 1:)
   end function short_word

   !> Enters the group of a mesh.
   subroutine enter_mesh(checker, meshes, i)
      !> The checker.
      class(checker_type), intent(inout) :: checker
      !> The meshes of the train.
      type(mesh_type), intent(in) :: meshes(:)
      !> Number among them.
      integer, intent(in) :: i

      call checker%enter(trim(group_name(meshes, i)), group_number(meshes, i))
   end subroutine enter_mesh

end module geartrain_train_mesh_groups
