!> A train whose one parameter varies while it runs at constant speed: what the continuation of its motions over the parameter takes
!> its systems from. All systems of a path have the same units and the same unknowns.
module geartrain_network_parameter_path
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type, fatal, in_a_line
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: real_text
   use geartrain_network_check_train, only: check_train
   use geartrain_network_divide_orders, only: divide_orders
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_network_light_loads, only: reduce_light_loads
   use geartrain_network_limits, only: check_frequency
   use geartrain_train_mesh, only: has_table, is_given
   use geartrain_network_modal_damping, only: modes_of_loss_factors
   use geartrain_network_network, only: network_type
   use geartrain_network_parameter, only: find_parameters, variation
   use geartrain_network_parameter_table, only: add_to_parameter, entry_type, parameter_type, table_type
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_train, only: train_type
   use geartrain_network_parameter_effect, only: has_effect
   implicit none (type, external)
   private
   public :: give_variation, parameter_path_type

   !> The path goes on beyond its ends by this share of its length, where the train allows it: Newton's method and differences look
   !> there.
   real(dp), parameter :: beyond = 0.1_dp
   !> The train is checked at so many places of the path beside its ends.
   integer, parameter :: places = 7
   real(dp), parameter :: golden = 0.618_dp

   type :: parameter_path_type
      !> Name of the parameter, as it is asked for, and its unit, '1' for a dimensionless one.
      character(:), allocatable :: name, unit
      !> Lambda of all motions [1].
      real(dp) :: frequency_ratio = 0
      !> Length of the path, and values between which there is a train [unit of the parameter].
      real(dp) :: length = 0, low = 0, high = 0
      !> A value amid the path, at which nothing is 0 by chance [unit of the parameter].
      real(dp) :: amid = 0
      !> Value of the train that the path was made from [unit of the parameter].
      real(dp) :: own_value = 0
      !> Whether all variables that take the value have it in that train, so that the train lies on the path.
      logical :: holds_train = .true.
      !> Meshes that are unknowns of the balance, (mesh): those that have backlash or a varying stiffness anywhere between the ends.
      logical, allocatable :: unknown(:)
      !> Network whose order of elements all systems have.
      type(network_type), allocatable :: like
      !> How often the motions go through their waveform in a period: the systems have the orders divided by it and so many times
      !> the characteristic frequency, so that Lambda is as before.
      integer :: repeats = 1
      type(train_type), private :: train
      !> Modes at which the loss factors of the train are equivalent amid the path, (element); 0: no loss factor.
      integer, allocatable, private :: loss_mode(:)
      !> The variables that take the value, with * one of each group.
      type(parameter_type), allocatable, private :: parameter(:)
   contains
      procedure :: setup
      procedure :: train_at
      procedure :: system_at
      procedure, private :: check_at
   end type parameter_path_type

contains

   !> Prepares a path.
   subroutine setup(self, train, name, frequency_ratio, start, stop, error)
      class(parameter_path_type), intent(inout) :: self
      !> A train that has passed `check_train`.
      type(train_type), intent(in) :: train
      !> Name of the parameter.
      character(*), intent(in) :: name
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Ends of the path [unit of the parameter].
      real(dp), intent(in) :: start, stop
      !> Added to where there is no such parameter, or no train somewhere between the ends.
      type(error_type), allocatable, intent(inout) :: error
      type(train_type) :: given, loaded, plain
      type(table_type) :: of_given, of_plain
      type(error_type), allocatable :: outside
      type(system_type) :: middle
      integer :: i

      self%name = trim(adjustl(name))
      self%frequency_ratio = frequency_ratio
      self%length = abs(stop - start)
      given = train
      call plain_train(train, plain)
      call of_given%take(given)
      call of_plain%take(plain)
      call find_parameters(given, plain, of_given, of_plain, name, self%parameter, error)
      if (allocated(error)) return
      self%parameter = pack(self%parameter, [(has_effect(train, self%parameter(i)), i=1, size(self%parameter))])
      if (size(self%parameter) == 0) call fatal(error, 'parameter "'//self%name//'": not in force in this train: what would follow &
                                                &from it is given, or is not used')
      if (allocated(error)) return
      self%own_value = self%parameter(1)%value
      self%holds_train = all(abs(self%parameter%value - self%own_value) <= 1e-12_dp*abs(self%own_value))
      self%unit = trim(self%parameter(1)%unit)
      if (self%unit == '') self%unit = '1'
      self%train = train
      if (any(self%parameter(1)%variable == [character(24) :: variation, 'stiffness_cos', 'stiffness_sin'])) &
         call give_variation(self%train)
      ! The units of displacement and time stay when the parameter is one that they would follow from.
      self%train%characteristic_length = plain%characteristic_length
      self%train%characteristic_frequency = plain%characteristic_frequency
      self%amid = start + golden*(stop - start)
      call self%system_at(self%amid, middle)
      self%unknown = middle%network%elements(middle%mesh_element)%unknown
      call self%train_at(self%amid, loaded)
      call plain_train(loaded, plain)
      call reduce_light_loads(plain)
      self%loss_mode = modes_of_loss_factors(plain)
      self%like = middle%network
      call self%check_at(start, middle, error)
      call self%check_at(stop, middle, error)
      do i = 1, places
         if (.not. allocated(error)) call self%check_at(start + i*(stop - start)/(places + 1), middle, error)
      end do
      if (allocated(error)) return
      self%low = min(start, stop) - beyond*self%length
      self%high = max(start, stop) + beyond*self%length
      call self%check_at(self%low, middle, outside)
      if (allocated(outside)) self%low = min(start, stop)
      if (allocated(outside)) deallocate (outside)
      call self%check_at(self%high, middle, outside)
      if (allocated(outside)) self%high = max(start, stop)
   end subroutine setup

   !> Gives the train the harmonics of its mesh stiffnesses that follow from a drawing, a contact ratio or a table.
   subroutine give_variation(train)
      !> The train as described.
      type(train_type), intent(inout) :: train
      type(train_type) :: loaded
      integer :: j

      ! The loads stay as they are when the harmonics change, and so do the mean stiffnesses.
      call plain_train(train, loaded)
      call reduce_light_loads(loaded)
      do j = 1, size(train%meshes)
         associate (mesh => train%meshes(j), own => loaded%meshes(j))
            if (.not. (is_given(own%stiffness_cos) .or. is_given(own%stiffness_sin))) cycle
            if (mesh%contact_ratio > 0 .or. has_table(mesh)) mesh%stiffness = own%stiffness
            mesh%contact_ratio = 0
            if (allocated(mesh%stiffness_table)) deallocate (mesh%stiffness_table)
            if (allocated(own%stiffness_cos)) mesh%stiffness_cos = own%stiffness_cos
            if (allocated(own%stiffness_sin)) mesh%stiffness_sin = own%stiffness_sin
            ! In the plain train these have the phase already.
            if (allocated(own%error_cos)) mesh%error_cos = own%error_cos
            if (allocated(own%error_sin)) mesh%error_sin = own%error_sin
            if (allocated(mesh%error_table)) deallocate (mesh%error_table)
            mesh%gear_error = own%gear_error
            mesh%error_mean = own%error_mean
            mesh%phase = 0
         end associate
      end do
   end subroutine give_variation

   !> Adds an error where the train is not in order at a value, or is one of another kind than in the middle of the path.
   subroutine check_at(self, value, middle, error)
      class(parameter_path_type), intent(in) :: self
      real(dp), intent(in) :: value
      type(system_type), intent(in) :: middle
      type(error_type), allocatable, intent(inout) :: error
      type(error_type), allocatable :: found
      type(system_type) :: system
      type(train_type) :: train, plain
      type(checker_type) :: checker
      type(table_type) :: table
      real(dp) :: has
      logical :: same
      integer :: i

      call self%train_at(value, train)
      call check_train(train, found)
      if (.not. allocated(found)) then
         call plain_train(train, plain)
         call check_frequency(plain, ['frequency'], [self%frequency_ratio], checker)
         call checker%problems%raise('', found)
      end if
      if (allocated(found)) then
         call refuse(in_a_line(found%message))
         return
      end if
      call table%take(plain)
      do i = 1, size(self%parameter)
         has = value_of(table, self%parameter(i))
         if (self%parameter(i)%direct .and. abs(has - value) > 1e-12_dp*max(abs(value), abs(self%own_value))) then
            call refuse('there the train takes '//real_text(has)//' from its drawing instead')
            return
         end if
      end do
      call self%system_at(value, system)
      same = system%elements == middle%elements .and. system%states == middle%states .and. &
             system%cut%unknowns == middle%cut%unknowns .and. size(system%torque) == size(middle%torque)
      if (.not. same) call refuse('there the train is of another kind, with another number of coordinates')
      if (.not. same) return
      call reduce_light_loads(plain)
      associate (mode => modes_of_loss_factors(plain))
         same = size(mode) == size(self%loss_mode)
         if (same) same = all(mode == self%loss_mode)
      end associate
      if (.not. same) call refuse('there a shaft or mesh with loss_factor has most strain energy in another mode than elsewhere in &
                                  &the range, and its damping jumps: give damping or modal_damping instead')

   contains

      subroutine refuse(why)
         character(*), intent(in) :: why

         call fatal(error, 'parameter "'//self%name//'" = '//real_text(value)//': '//why)
      end subroutine refuse

   end subroutine check_at

   !> The train with a value of the parameter.
   subroutine train_at(self, value, train)
      class(parameter_path_type), intent(in) :: self
      !> Value [unit of the parameter].
      real(dp), intent(in) :: value
      type(train_type), intent(out) :: train
      type(table_type) :: table
      integer :: i, j

      train = self%train
      if (self%parameter(1)%variable == variation) then
         associate (factor => value/self%parameter(1)%value)
            do j = 1, size(train%meshes)
               if (allocated(train%meshes(j)%stiffness_cos)) train%meshes(j)%stiffness_cos = factor*train%meshes(j)%stiffness_cos
               if (allocated(train%meshes(j)%stiffness_sin)) train%meshes(j)%stiffness_sin = factor*train%meshes(j)%stiffness_sin
            end do
         end associate
         return
      end if
      call table%take(train)
      do i = 1, size(self%parameter)
         call add_to_parameter(train, self%parameter(i), value - value_of(table, self%parameter(i)))
      end do
   end subroutine train_at

   !> Value of a parameter in a train.
   pure real(dp) function value_of(table, parameter)
      !> Variables of the train.
      type(table_type), intent(in) :: table
      type(parameter_type), intent(in) :: parameter
      type(entry_type) :: row
      integer :: found

      call table%find(parameter, found, row, value_of)
   end function value_of

   !> The dimensionless system of the train with a value of the parameter.
   subroutine system_at(self, value, system)
      class(parameter_path_type), intent(in) :: self
      !> Value [unit of the parameter].
      real(dp), intent(in) :: value
      type(system_type), intent(out) :: system
      type(train_type) :: train

      call self%train_at(value, train)
      train%characteristic_frequency = self%repeats*train%characteristic_frequency
      if (allocated(self%unknown)) then
         call build_system(train, system, unknown=self%unknown, like=self%like)
      else
         call build_system(train, system)
      end if
      call divide_orders(self%repeats, system)
   end subroutine system_at

end module geartrain_network_parameter_path
