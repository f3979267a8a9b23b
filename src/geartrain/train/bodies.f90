!> The bodies of a train, and which of them its shafts and meshes join. A chain has the bodies prime mover, driving and driven gear
!> of each mesh, load.
module geartrain_train_bodies
   use geartrain_base_kinds, only: dp
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: bodies_of, body_count, find_carriers, find_ends

   !> Bodies by what their names make of a place in a table: the last body of each place, and the body before each body.
   type :: name_table_type
      integer, allocatable :: last(:), before(:)
   end type name_table_type

contains

   !> Number of bodies.
   pure integer function body_count(train)
      !> The train, with its bodies or its shafts.
      type(train_type), intent(in) :: train

      if (allocated(train%bodies)) then
         body_count = size(train%bodies)
      else
         body_count = 2*size(train%shafts)
      end if
   end function body_count

   !> Inertias and mean torques of the bodies.
   pure subroutine bodies_of(train, inertia, torque, balancing, held)
      type(train_type), intent(in) :: train
      !> Polar moments of inertia [kg m^2] and mean torques as given [N m], (body); the torque by which the last body of a chain
      !> balances the others is not given: 0.
      real(dp), intent(out) :: inertia(:), torque(:)
      !> Numbers of the bodies whose mean torques balance all others.
      integer, allocatable, intent(out) :: balancing(:)
      !> Bodies that stand still, (body).
      logical, intent(out), optional :: held(:)
      integer :: j

      if (present(held)) held = .false.

      if (allocated(train%bodies)) then
         inertia = train%bodies%inertia
         torque = train%bodies%torque
         balancing = pack([(j, j=1, size(inertia))], train%bodies%balances)
         if (present(held)) held = train%bodies%held
      else
         inertia(1) = train%prime_mover_inertia
         do j = 1, size(train%meshes)
            inertia(2*j:2*j + 1) = [train%meshes(j)%driving_inertia, train%meshes(j)%driven_inertia]
         end do
         balancing = [size(inertia)]
         inertia(size(inertia)) = train%load_inertia
         torque = 0
         torque(1) = train%input_torque
      end if
   end subroutine bodies_of

   !> Numbers of the bodies that shafts and meshes join.
   pure subroutine find_ends(train, shafts, meshes)
      type(train_type), intent(in) :: train
      !> Bodies at the two ends of each shaft, (2, shaft), and of each mesh, (2, mesh); 0: no body has the name.
      integer, allocatable, intent(out) :: shafts(:, :), meshes(:, :)
      type(name_table_type) :: table
      integer :: i, j

      allocate (shafts(2, size(train%shafts)), meshes(2, size(train%meshes)))
      if (.not. allocated(train%bodies)) then
         shafts = reshape([(2*((i + 1)/2) + mod(i + 1, 2) - 1, i=1, size(shafts))], shape(shafts))
         meshes = shafts(:, :size(train%meshes)) + 1
         return
      end if
      call tabulate_names(train, table)
      do i = 1, 2
         do j = 1, size(shafts, 2)
            shafts(i, j) = body_named(train, table, train%shafts(j)%between(i))
         end do
         do j = 1, size(meshes, 2)
            meshes(i, j) = body_named(train, table, train%meshes(j)%between(i))
         end do
      end do
   end subroutine find_ends

   !> Numbers of the bodies that carry the gears of meshes.
   pure subroutine find_carriers(train, carrier)
      type(train_type), intent(in) :: train
      !> The carrier of each mesh; 0: none, -1: no body has the name, (mesh).
      integer, intent(out) :: carrier(:)
      type(name_table_type) :: table
      integer :: j

      carrier = 0
      if (.not. any(train%meshes%carrier /= '')) return
      carrier = -1
      if (.not. allocated(train%bodies)) return
      call tabulate_names(train, table)
      do j = 1, size(carrier)
         carrier(j) = 0
         if (train%meshes(j)%carrier == '') cycle
         carrier(j) = body_named(train, table, train%meshes(j)%carrier)
         if (carrier(j) == 0) carrier(j) = -1
      end do
   end subroutine find_carriers

   pure subroutine tabulate_names(train, table)
      type(train_type), intent(in) :: train
      type(name_table_type), intent(out) :: table
      integer :: j, k

      allocate (table%last(0:2*size(train%bodies)), table%before(size(train%bodies)), source=0)
      do j = 1, size(train%bodies)
         if (.not. allocated(train%bodies(j)%name)) cycle
         k = place(train%bodies(j)%name, size(table%last))
         table%before(j) = table%last(k)
         table%last(k) = j
      end do
   end subroutine tabulate_names

   !> Place of a name in a table of so many.
   pure integer function place(name, places)
      character(*), intent(in) :: name
      integer, intent(in) :: places
      integer :: k

      place = 1
      do k = 1, len_trim(name)
         place = 1 + mod(31*place + ichar(name(k:k)), 10000019)
      end do
      place = mod(place, places)
   end function place

   !> Number of the last body of a name, 0: none has it.
   pure integer function body_named(train, table, name)
      type(train_type), intent(in) :: train
      type(name_table_type), intent(in) :: table
      character(*), intent(in) :: name

      body_named = table%last(place(name, size(table%last)))
      do while (body_named > 0)
         if (train%bodies(body_named)%name == name) return
         body_named = table%before(body_named)
      end do
   end function body_named

end module geartrain_train_bodies
