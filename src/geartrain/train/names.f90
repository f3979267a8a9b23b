!> How a report calls meshes, shafts and harmonics.
module geartrain_train_names
   use geartrain_base_numbers, only: text
   use geartrain_train_mesh_groups, only: group_number, mesh_word
   use geartrain_train_labels, only: coupling_labels, held_labels, label_length, mesh_labels, shaft_labels
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: list_meshes, list_numbers, mesh_names, name_length, shaft_names, torque_names

   !> Most characters of a name.
   integer, parameter :: name_length = label_length + 20
   !> Most numbers of a list.
   integer, parameter :: most_numbers = 6

contains

   !> Names of the meshes, 'mesh 1', with the bodies where these have names: 'mesh 1 (pinion - wheel)', 'coupling 1 (wheel - load)',
   !> (mesh).
   pure function mesh_names(train) result(names)
      !> The train as given.
      type(train_type), intent(in) :: train
      character(name_length) :: names(size(train%meshes))
      character(label_length) :: labels(size(train%meshes))
      integer :: i

      labels = mesh_labels(train)
      do i = 1, size(names)
         names(i) = mesh_word(train%meshes, i)
         if (allocated(train%bodies)) names(i) = trim(names(i))//' ('//trim(labels(i))//')'
      end do
   end function mesh_names

   !> Names of the shafts, as of the meshes, (shaft).
   pure function shaft_names(train) result(names)
      !> The train as given.
      type(train_type), intent(in) :: train
      character(name_length) :: names(size(train%shafts))
      character(label_length) :: labels(size(train%shafts))
      integer :: i

      labels = shaft_labels(train)
      do i = 1, size(names)
         names(i) = 'shaft '//text(i)
         if (allocated(train%bodies)) names(i) = 'shaft '//text(i)//' ('//trim(labels(i))//')'
      end do
   end function shaft_names

   !> Names of the torques of a train: of the shafts, then 'reaction of housing' of the held bodies, then of the couplings, (shaft,
   !> then held body, then coupling).
   pure function torque_names(train) result(names)
      !> The train as given.
      type(train_type), intent(in) :: train
      character(name_length), allocatable :: names(:)
      character(label_length), allocatable :: held(:)
      integer :: i, before

      held = held_labels(train)
      before = size(train%shafts) + size(held)
      allocate (names(before + count(train%meshes%is_coupling)))
      names(:size(train%shafts)) = shaft_names(train)
      do i = 1, size(held)
         names(size(train%shafts) + i) = 'reaction of '//held(i)
      end do
      associate (labels => coupling_labels(train))
         do i = 1, size(labels)
            names(before + i) = 'coupling '//text(i)//' ('//trim(labels(i))//')'
         end do
      end associate
   end function torque_names

   !> The numbers of those that are there by their kinds: 'meshes 1, 2 and coupling 1', '' for none.
   subroutine list_meshes(train, is_there, words)
      !> The train as given.
      type(train_type), intent(in) :: train
      !> Whether each mesh, coupling or direction of a bearing is there, (mesh).
      logical, intent(in) :: is_there(:)
      !> The list.
      character(:), allocatable, intent(out) :: words
      integer :: numbers(size(is_there)), i

      words = ''
      associate (meshes => train%meshes)
         call add(pack(is_there, meshes%is_pair()), 'mesh', 'meshes')
         call add(pack(is_there, meshes%is_coupling), 'coupling', 'couplings')
         numbers = [(group_number(meshes, i), i=1, size(meshes))]
         call add([(any(is_there .and. meshes%axis > 0 .and. numbers == i), i=1, count(meshes%axis == 1))], 'bearing', 'bearings')
      end associate

   contains

      subroutine add(those, one, many)
         logical, intent(in) :: those(:)
         character(*), intent(in) :: one, many
         character(:), allocatable :: list

         call list_numbers(those, one, many, list)
         if (words /= '' .and. list /= '') words = words//' and '
         words = words//list
      end subroutine add

   end subroutine list_meshes

   !> The numbers of those that are there, with a word before: 'mesh 2', 'meshes 1, 2, 5'; '' for none.
   subroutine list_numbers(is_there, one, many, words)
      !> Whether each is there.
      logical, intent(in) :: is_there(:)
      !> The word for one, and the word for several.
      character(*), intent(in) :: one, many
      !> The list.
      character(:), allocatable, intent(out) :: words
      integer :: i, n

      words = ''
      n = 0
      do i = 1, size(is_there)
         if (.not. is_there(i)) cycle
         n = n + 1
         if (n > most_numbers) cycle
         if (n > 1) words = words//', '
         words = words//text(i)
      end do
      if (n == 0) return
      if (n > most_numbers) words = words//' and '//text(n - most_numbers)//' more'
      if (n == 1) words = one//' '//words
      if (n > 1) words = many//' '//words
      if (n > 2 .and. n == size(is_there)) words = 'all '//many
   end subroutine list_numbers

end module geartrain_train_names
