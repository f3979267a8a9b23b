!> Parameters of trains by name, and trains with a parameter changed.
module parameters_of_trains
   use geartrain, only: dp, error_type, train_type
   use geartrain_base_numbers, only: integer_text
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_network_light_loads, only: reduce_light_loads
   use geartrain_network_parameter, only: find_parameter
   use geartrain_network_parameter_table, only: add_to_parameter, parameter_type, table_type
   implicit none (type, external)
   private
   public :: all_parameters, change, name_length, parameter_of

   integer, parameter :: name_length = 40

contains

   !> Every continuous parameter of a train, by its name.
   subroutine all_parameters(train, names)
      type(train_type), intent(in) :: train
      character(name_length), allocatable, intent(out) :: names(:)
      character(*), parameter :: of_train(*) = [character(20) :: 'input_torque', 'torque_cos 1', 'torque_sin 1', 'torque_sin 2', &
         'prime_mover_inertia', 'load_inertia', 'stiffness_variation'], &
         of_body(*) = [character(20) :: 'inertia', 'torque', 'torque_cos 1', 'damping_to_ground'], &
         of_shaft(*) = [character(20) :: 'stiffness', 'damping_ratio', 'damping'], &
         of_mesh(*) = [character(20) :: 'driving_radius', 'driven_radius', 'driving_inertia', 'driven_inertia', 'stiffness', &
                       'damping_ratio', 'damping', 'half_backlash', 'stiffness_cos 1', 'stiffness_cos 2', 'stiffness_sin 1', &
                       'back_stiffness', 'back_phase', 'phase', 'error_cos 1', 'error_sin 1']
      integer :: i, j

      allocate (names(0))
      do i = 1, size(of_train)
         call try(trim(of_train(i)))
      end do
      if (allocated(train%bodies)) then
         do j = 1, size(train%bodies)
            do i = 1, size(of_body)
               call try('body '//train%bodies(j)%name//' '//trim(of_body(i)))
            end do
         end do
      end if
      do j = 1, size(train%shafts)
         do i = 1, size(of_shaft)
            if (.not. train%shafts(j)%rigid) call try('shaft '//integer_text(j)//' '//trim(of_shaft(i)))
         end do
      end do
      do j = 1, size(train%meshes)
         do i = 1, size(of_mesh)
            call try('mesh '//integer_text(j)//' '//trim(of_mesh(i)))
         end do
      end do

   contains

      subroutine try(name)
         character(*), intent(in) :: name
         type(parameter_type) :: parameter
         type(error_type), allocatable :: error
         character(name_length) :: padded

         call parameter_of(train, name, parameter, error)
         padded = name
         if (.not. allocated(error)) names = [character(name_length) :: names, padded]
      end subroutine try

   end subroutine all_parameters

   subroutine parameter_of(train, name, parameter, error)
      type(train_type), intent(in) :: train
      character(*), intent(in) :: name
      type(parameter_type), intent(out) :: parameter
      type(error_type), allocatable, intent(inout) :: error
      type(train_type) :: copy, plain
      type(table_type) :: given, derived

      copy = train
      call plain_train(train, plain)
      call given%take(copy)
      call derived%take(plain)
      call find_parameter(train, plain, given, derived, name, parameter, error)
   end subroutine parameter_of

   subroutine change(train, parameter, h, changed)
      type(train_type), intent(in) :: train
      type(parameter_type), intent(in) :: parameter
      real(dp), intent(in) :: h
      type(train_type), intent(out) :: changed
      integer :: j

      changed = train
      if (parameter%derived) then
         ! The drawing gives its value, so it is there in the plain train alone.
         call plain_train(train, changed)
         call reduce_light_loads(changed)
      end if
      if (parameter%variable == 'stiffness_variation') then
         do j = 1, size(train%meshes)
            associate (mesh => changed%meshes(j), factor => 1 + h/parameter%value)
               if (allocated(mesh%stiffness_cos)) mesh%stiffness_cos = factor*mesh%stiffness_cos
               if (allocated(mesh%stiffness_sin)) mesh%stiffness_sin = factor*mesh%stiffness_sin
            end associate
         end do
      else
         call add_to_parameter(changed, parameter, h)
      end if
   end subroutine change

end module parameters_of_trains
