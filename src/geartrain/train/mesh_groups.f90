!> Which meshes of a train are gear pairs and which are couplings: both are counted by themselves in a case, and stand in one list.
module geartrain_train_mesh_groups
   use geartrain_base_checker, only: checker_type
   use geartrain_base_numbers, only: integer_text
   use geartrain_train_mesh, only: mesh_type
   implicit none (type, external)
   private
   public :: enter_mesh, group_length, group_name, group_number, mesh_word, place_of

   !> Most characters of the name of a group.
   integer, parameter :: group_length = 8

contains

   !> Name of the group of a mesh, 'mesh' or 'coupling'.
   pure function group_name(meshes, i) result(name)
      !> The meshes of the train.
      type(mesh_type), intent(in) :: meshes(:)
      !> Number among them.
      integer, intent(in) :: i
      character(group_length) :: name

      name = merge('coupling', 'mesh    ', meshes(i)%is_coupling)
   end function group_name

   !> Number of a mesh among the groups of its name.
   pure integer function group_number(meshes, i)
      !> The meshes of the train.
      type(mesh_type), intent(in) :: meshes(:)
      !> Number among them.
      integer, intent(in) :: i

      group_number = count(meshes(:i)%is_coupling .eqv. meshes(i)%is_coupling)
   end function group_number

   !> Number among all meshes of number `n` of a group; 0: there is none.
   pure integer function place_of(meshes, group, n) result(i)
      !> The meshes of the train.
      type(mesh_type), intent(in) :: meshes(:)
      !> 'mesh' or 'coupling'.
      character(*), intent(in) :: group
      !> Number in the group.
      integer, intent(in) :: n

      do i = size(meshes), 1, -1
         if (group_name(meshes, i) == group .and. group_number(meshes, i) == n) return
      end do
   end function place_of

   !> 'mesh 2', 'coupling 1'.
   pure function mesh_word(meshes, i) result(word)
      !> The meshes of the train.
      type(mesh_type), intent(in) :: meshes(:)
      !> Number among them.
      integer, intent(in) :: i
      character(group_length + 12) :: word

      word = trim(group_name(meshes, i))//' '//integer_text(group_number(meshes, i))
   end function mesh_word

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
