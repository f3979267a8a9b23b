!> What results call bodies by, and shafts and meshes: by the bodies that they join, 'pinion - wheel', or in a chain 'shaft 1',
!> 'mesh 1'. A mesh may have a name of its own.
module geartrain_train_labels
   use geartrain_train_bearing_rows, only: row_text
   use geartrain_train_bodies, only: body_count
   use geartrain_train_body, only: name_length
   use geartrain_train_mesh, only: mesh_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: bearing_labels, body_labels, coupling_labels, held_labels, label_length, mesh_labels, shaft_labels

   !> Most characters of a label.
   integer, parameter :: label_length = 2*name_length + 16

contains

   !> Names of the bodies; in a chain 'driving end', 'driving gear 1', 'driven gear 1', ..., 'driven end', (body).
   pure function body_labels(train) result(labels)
      !> A train that is in order.
      type(train_type), intent(in) :: train
      character(label_length) :: labels(body_count(train))
      integer :: i

      do i = 1, size(labels)
         if (allocated(train%bodies)) then
            labels(i) = train%bodies(i)%name
         else if (i == 1 .or. i == size(labels)) then
            labels(i) = merge('driving end', 'driven end ', i == 1)
         else
            write (labels(i), '(2a, i0)') trim(merge('driving', 'driven ', mod(i, 2) == 0)), ' gear ', i/2
         end if
      end do
   end function body_labels

   !> Names of the held bodies, (held body).
   pure function held_labels(train) result(labels)
      !> A train that is in order.
      type(train_type), intent(in) :: train
      character(label_length), allocatable :: labels(:)
      integer :: i, n

      n = 0
      if (allocated(train%bodies)) n = count(train%bodies%held)
      allocate (labels(n))
      if (n == 0) return
      n = 0
      do i = 1, size(train%bodies)
         if (.not. train%bodies(i)%held) cycle
         n = n + 1
         labels(n) = train%bodies(i)%name
      end do
   end function held_labels

   !> Labels of the couplings, (coupling).
   pure function coupling_labels(train) result(labels)
      !> A train that is in order.
      type(train_type), intent(in) :: train
      character(label_length) :: labels(count(train%meshes%is_coupling))

      labels = pack(mesh_labels(train), train%meshes%is_coupling)
   end function coupling_labels

   !> Labels of the meshes, their names or the driving body first; no two are equal, (mesh).
   pure function mesh_labels(train) result(labels)
      !> A train that is in order.
      type(train_type), intent(in) :: train
      character(label_length) :: labels(size(train%meshes))
      integer :: i

      do i = 1, size(labels)
         call find_label('mesh', train%meshes(i)%between, name_of(train%meshes(i)), labels, i)
      end do
   end function mesh_labels

   !> Name of a mesh, blank: none. A bearing is named by its body, 'pinion bearing x'.
   pure function name_of(mesh) result(name)
      type(mesh_type), intent(in) :: mesh
      character(label_length) :: name

      name = mesh%name
      if (mesh%axis > 0) name = trim(mesh%between(1))//' bearing '//row_text(mesh)
   end function name_of

   !> Names of the bodies on bearings, (bearing).
   pure function bearing_labels(train) result(labels)
      !> A train that is in order.
      type(train_type), intent(in) :: train
      character(label_length) :: labels(count(train%meshes%axis == 1))

      labels = pack(train%meshes%between(1), train%meshes%axis == 1)
   end function bearing_labels

   !> Labels of the shafts; no two are equal, (shaft).
   pure function shaft_labels(train) result(labels)
      !> A train that is in order.
      type(train_type), intent(in) :: train
      character(label_length) :: labels(size(train%shafts))
      integer :: i

      do i = 1, size(labels)
         call find_label('shaft', train%shafts(i)%between, '', labels, i)
      end do
   end function shaft_labels

   !> Sets label number i; a second mesh between the bodies of an earlier one is 'pinion - wheel (2)'.
   pure subroutine find_label(kind, between, name, labels, i)
      !> 'shaft' or 'mesh'; names of the two bodies, blank in a chain.
      character(*), intent(in) :: kind, between(2)
      !> Name of its own, blank: none.
      character(*), intent(in) :: name
      !> Those before number i are set.
      character(label_length), intent(inout) :: labels(:)
      integer, intent(in) :: i
      character(label_length) :: names
      integer :: n

      names = trim(between(1))//' - '//between(2)
      if (between(1) == '') write (names, '(2a, i0)') kind, ' ', i
      if (name /= '') names = name
      labels(i) = names
      n = 1
      do while (any(labels(:i - 1) == labels(i)))
         n = n + 1
         write (labels(i), '(2a, i0, a)') trim(names), ' (', n, ')'
      end do
   end subroutine find_label

end module geartrain_train_labels
