!> The mean load of a train in a report: the torques, the mean mesh forces and the flanks that bear them.
module geartrain_analyses_load_sentences
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: significant, text
   use geartrain_network_network, only: balance_torques
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_body, only: follows_speed
   use geartrain_train_mesh, only: mesh_type
   use geartrain_train_names, only: list_numbers
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: load_sides, say_load, unloaded_side

   !> Most torques and most mean forces that are named; smallest mean force that counts, over the largest [1].
   integer, parameter :: most = 4
   real(dp), parameter :: least = 1e-12_dp

contains

   !> Mean force of each mesh [N], of a coupling mean torque [N m], negative on the coast flank, (mesh).
   function mean_forces(train) result(force)
      !> A train that has passed `check_train`.
      type(train_type), intent(in) :: train
      real(dp) :: force(size(train%meshes))
      type(system_type) :: system

      call build_system(train, system)
      force = system%static_force(system%mesh_element)*system%load_unit
      where (abs(force) <= least*maxval(abs(force))) force = 0
   end function mean_forces

   !> Flank that bears the mean load of each mesh: 1 the drive flank, -1 the coast flank, 0 none, (mesh).
   function load_sides(train) result(sides)
      !> A train that has passed `check_train`.
      type(train_type), intent(in) :: train
      integer :: sides(size(train%meshes))

      associate (force => mean_forces(train))
         sides = 0
         where (force > 0) sides = 1
         where (force < 0) sides = -1
      end associate
   end function load_sides

   !> What hits where the load is on the other side: 'its coast flanks hit', of a bearing 'its unloaded side hits'.
   pure function unloaded_side(mesh, side) result(words)
      type(mesh_type), intent(in) :: mesh
      !> Flank that bears its load, as `load_sides` gives it.
      integer, intent(in) :: side
      character(22) :: words

      words = 'its '//trim(merge('drive', 'coast', side < 0))//' flanks hit'
      if (mesh%axis > 0) words = 'its unloaded side hits'
   end function unloaded_side

   !> The line on the load: 'Load: 90 N m on motor, balanced by load (-210 N m); mean mesh forces 3231 N, 7547 N'.
   subroutine say_load(train, words)
      !> A train that has passed `check_train`.
      type(train_type), intent(in) :: train
      !> The line.
      character(:), allocatable, intent(out) :: words
      real(dp), allocatable :: force(:)
      character(:), allocatable :: balancing, list
      integer :: i, n

      force = pack(mean_forces(train), train%meshes%is_pair())
      words = 'Load: '
      if (allocated(train%bodies)) then
         n = 0
         do i = 1, size(train%bodies)
            associate (body => train%bodies(i))
               if (body%balances .or. .not. abs(body%torque) > 0) cycle
               n = n + 1
               if (n > most) cycle
               if (n > 1) words = words//', '
               words = words//significant(body%torque)//' N m on '//body%name
               if (follows_speed(body)) words = words//' at its '//significant(body%torque_speed)//' rpm, with the power '// &
                                                significant(body%torque_speed_exponent)//' of the speed'
            end associate
         end do
         if (n > most) words = words//', and '//text(n - most)//' more torques'
         if (n == 0) words = words//'none'
         call list_balancing(train, balancing)
         if (n > 0) words = words//balancing
      else
         words = words//'input torque '//significant(train%input_torque)//' N m'
      end if
      if (size(force) <= most .and. any(abs(force) > 0)) then
         words = words//'; mean mesh '//trim(merge('force ', 'forces', size(force) == 1))//' '
         do i = 1, size(force)
            if (i > 1) words = words//', '
            words = words//significant(force(i))
         end do
         words = words//' N'
      end if
      call list_numbers(force < 0, 'mesh', 'meshes', list)
      if (list == '') return
      if (all(force < 0)) list = trim(merge('the mesh  ', 'all meshes', size(force) == 1))
      words = words//'; on the coast flanks of '//list
   end subroutine say_load

   !> Bodies that balance the torques, and their mean torques: ', balanced by motor (-20 N m) and car (-64 N m)'; '' for none.
   subroutine list_balancing(train, words)
      type(train_type), intent(in) :: train
      character(:), allocatable, intent(out) :: words
      type(system_type) :: system
      real(dp) :: torque(size(train%bodies))
      integer :: i, n

      words = ''
      call build_system(train, system)
      torque = train%bodies%torque
      call balance_torques(system%network, torque)
      n = 0
      do i = 1, size(torque)
         if (.not. train%bodies(i)%balances) cycle
         n = n + 1
         if (n == 1) words = ', balanced by '
         if (n > 1) words = words//' and '
         words = words//trim(train%bodies(i)%name)//' ('//significant(torque(i))//' N m)'
      end do
   end subroutine list_balancing

end module geartrain_analyses_load_sentences
