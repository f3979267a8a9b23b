!> Derivatives with respect to parameters of a train: of its system, which all others follow from, and of its natural frequencies.
module geartrain_network_gradient
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
   use geartrain_base_error, only: error_type, fatal, status_ended_early
   use geartrain_base_kinds, only: dp
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_network_check_train, only: check_train
   use geartrain_network_light_loads, only: reduce_light_loads
   use geartrain_network_modal_damping, only: resolve_damping
   use geartrain_network_mode_rates, only: mode_shapes_type
   use geartrain_network_network, only: locks
   use geartrain_network_parameter, only: find_parameters, variation
   use geartrain_network_parameter_effect, only: has_effect
   use geartrain_network_parameter_table, only: add_to_parameter, parameter_type, table_type
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: gradient_type, parameters_type, sides_type, begin_gradient, check_parameters, frequency_gradient, reason_length

   integer, parameter :: reason_length = 120
   !> Change of a parameter over its value for differences of natural frequencies: an error of its fourth power, and rounding over
   !> it.
   real(dp), parameter :: step_of_modes = 5e-4_dp

   type :: gradient_type
      !> Derivatives [unit of the figure/unit of the parameter], (mesh, shaft or mode, parameter); NaN where there is none.
      real(dp), allocatable :: values(:, :)
      !> Estimated errors of derivatives that are differences, 0 of others; like values.
      real(dp), allocatable :: uncertainty(:, :)
      !> Why there is none, blank where there is one, (parameter).
      character(reason_length), allocatable :: reason(:)
      !> Lambda of the special point as the balance has it [1].
      real(dp) :: frequency_ratio = 0
   end type gradient_type

   !> What a name stands for: one parameter, or with * those of several groups.
   type :: named_type
      type(parameter_type), allocatable :: parameter(:)
   end type named_type

   !> Trains beside a train, with other values of a parameter, in the same units, with the same unknowns and order of elements. The
   !> derivative of what a train has is the sum of weight(i) times what system(i) has.
   type :: sides_type
      !> The trains; what is added to the parameter [its unit]; weights [1/its unit].
      type(system_type), allocatable :: system(:)
      real(dp), allocatable :: change(:), weight(:)
   end type sides_type

   !> A train and parameters of it by their names.
   type :: parameters_type
      !> The train; its plain train.
      type(train_type) :: train
      type(train_type), private :: plain
      type(system_type) :: system
      type(named_type), allocatable :: named(:)
   contains
      procedure :: setup
      procedure :: find_sides
      procedure, private :: build_sides
      procedure :: changed_system
      procedure :: allows
      procedure :: value_of
   end type parameters_type

contains

   !> Refuses names of no parameters, and of those that are not in force.
   subroutine check_parameters(train, names, error)
      type(train_type), intent(in) :: train
      !> Names of the parameters, (parameter).
      character(*), intent(in) :: names(:)
      type(error_type), allocatable, intent(out) :: error
      type(parameters_type) :: given

      call given%setup(train, names, error)
   end subroutine check_parameters

   !> Finds the derivatives of the natural frequencies over characteristic frequency.
   subroutine frequency_gradient(train, names, gradient, error)
      type(train_type), intent(in) :: train
      !> Names of the parameters, (parameter).
      character(*), intent(in) :: names(:)
      !> The derivatives, (mode, parameter).
      type(gradient_type), intent(out) :: gradient
      type(error_type), allocatable, intent(out) :: error
      type(parameters_type) :: given
      type(mode_shapes_type) :: shapes
      type(sides_type) :: sides
      integer :: info, n

      call given%setup(train, names, error)
      if (allocated(error)) return
      call begin_gradient(gradient, given%system%displacements, size(names))
      call shapes%setup(given%system, info)
      if (info /= 0) call fatal(error, 'gradient: LAPACK did not converge', status_ended_early)
      if (info /= 0) return
      do n = 1, size(names)
         call given%find_sides(n, step_of_modes, sides, gradient%reason(n))
         if (gradient%reason(n) /= '') cycle
         call shapes%rates(given%system, sides%system, sides%weight, gradient%values(:, n))
         if (any(ieee_is_nan(gradient%values(:, n)))) &
            gradient%reason(n) = 'natural frequencies that are equal and part'
      end do
   end subroutine frequency_gradient

   !> All derivatives NaN, no reasons.
   subroutine begin_gradient(gradient, items, parameters)
      !> Gets its size.
      type(gradient_type), intent(inout) :: gradient
      !> Number of meshes, shafts or modes; number of parameters.
      integer, intent(in) :: items, parameters
      real(dp) :: none

      none = ieee_value(none, ieee_quiet_nan)
      allocate (gradient%values(items, parameters), source=none)
      allocate (gradient%uncertainty(items, parameters), source=0.0_dp)
      allocate (gradient%reason(parameters))
      gradient%reason = ''
   end subroutine begin_gradient

   !> Finds the parameters and the system.
   subroutine setup(self, train, names, error)
      class(parameters_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      !> Names of the parameters, (parameter).
      character(*), intent(in) :: names(:)
      type(error_type), allocatable, intent(out) :: error
      type(table_type) :: given, derived
      type(parameter_type), allocatable :: found(:)
      integer :: i, n

      call check_train(train, error)
      if (allocated(error)) return
      self%train = train
      call plain_train(train, self%plain)
      call given%take(self%train)
      call derived%take(self%plain)
      allocate (self%named(size(names)))
      do n = 1, size(names)
         call find_parameters(self%train, self%plain, given, derived, names(n), found, error)
         if (size(found) > 0) found = pack(found, [(has_effect(self%train, found(i)), i=1, size(found))])
         if (.not. allocated(error) .and. size(found) == 0) call fatal(error, 'parameter "'//trim(adjustl(names(n)))//'": not in &
            &force in this train: what would follow from it is given, or is not used')
         self%named(n)%parameter = found
      end do
      if (allocated(error)) return
      call reduce_light_loads(self%plain)
      call resolve_damping(self%plain)
      call build_system(train, self%system)
   end subroutine setup

   !> Finds the trains beside the train, with a little more and a little less of a parameter.
   subroutine find_sides(self, n, step, sides, reason)
      class(parameters_type), intent(in) :: self
      !> Number of the parameter.
      integer, intent(in) :: n
      !> Change of the parameter over its value [1]; of a parameter that is 0 over a hundredth of its unit, of b_c for a length, or
      !> over one radian.
      real(dp), intent(in) :: step
      !> The trains, where there is a derivative: it is the sum of weight(i) times what sides%system(i) has.
      type(sides_type), intent(out) :: sides
      !> Why there is no derivative; blank where there is one.
      character(*), intent(out) :: reason
      real(dp) :: h
      logical :: fits

      h = step*self%value_of(n)
      if (.not. h > 0) then
         select case (self%named(n)%parameter(1)%unit)
         case ('m')
            h = step*self%plain%characteristic_length/100
         case ('rad')
            h = step
         case default
            h = step/100
         end select
      end if
      ! Of fourth order in h, at an end of the range of the parameter to one side.
      sides%change = h*[-2, -1, 1, 2]
      sides%weight = [1, -8, 8, -1]/(12*h)
      call self%build_sides(n, sides, fits, reason)
      if (fits) return
      sides%change = h*[0, 1, 2, 3, 4]
      sides%weight = [-25, 48, -36, 16, -3]/(12*h)
      call self%build_sides(n, sides, fits, reason)
      if (fits) return
      sides%change = -sides%change
      sides%weight = -sides%weight
      call self%build_sides(n, sides, fits, reason)
      if (.not. fits) reason = 'no train has a value next to it'
   end subroutine find_sides

   !> Builds the trains beside the train.
   subroutine build_sides(self, n, sides, fits, reason)
      class(parameters_type), intent(in) :: self
      !> Number of the parameter.
      integer, intent(in) :: n
      !> Gets the trains for its changes.
      type(sides_type), intent(inout) :: sides
      !> All changes are allowed.
      logical, intent(out) :: fits
      !> Why there is no derivative; blank where there is one.
      character(*), intent(out) :: reason
      integer :: i

      if (allocated(sides%system)) deallocate (sides%system)
      allocate (sides%system(size(sides%change)))
      reason = ''
      do i = 1, size(sides%change)
         call self%changed_system(n, sides%change(i), sides%system(i), fits)
         if (.not. fits) return
         associate (side => sides%system(i))
            if (locks(side%network)) then
               reason = 'the gears of a loop would lock'
            else if (.not. is_of_kind(side, self%system)) then
               reason = 'the drawing gives another train with a value next to it'
               if (.not. self%value_of(n) > 0) reason = 'it is 0, and with another value the train is of another kind'
            else if (.not. has_lists_of(side, sides%system(1)) .and. .not. has_lists_of(side, self%system)) then
               reason = 'the drawing gives another train with a value next to it'
            end if
         end associate
         if (reason /= '') return
      end do
   end subroutine build_sides

   !> The system of the train with a changed value of a parameter, in the same units and with the same unknowns.
   subroutine changed_system(self, n, change, system, allowed)
      class(parameters_type), intent(in) :: self
      !> Number of the parameter.
      integer, intent(in) :: n
      !> What is added to the value [unit of the parameter].
      real(dp), intent(in) :: change
      !> Becomes the system, where the change is allowed.
      type(system_type), intent(inout) :: system
      !> Whether the changed value is in the range of its variable.
      logical, intent(out) :: allowed
      type(train_type) :: described, train
      logical :: derives
      integer :: i, j

      allowed = .true.
      described = self%train
      derives = .false.
      associate (parameters => self%named(n)%parameter)
         do i = 1, size(parameters)
            if (parameters(i)%direct .or. parameters(i)%variable == variation) cycle
            derives = .true.
            call add_to_parameter(described, parameters(i), change, allowed)
            if (.not. allowed) return
         end do
         if (derives) then
            call plain_train(described, train)
            call reduce_light_loads(train)
         else
            train = self%plain
         end if
         do i = 1, size(parameters)
            if (parameters(i)%variable == variation) then
               do j = 1, size(train%meshes)
                  associate (mesh => train%meshes(j), factor => 1 + change/parameters(i)%value)
                     if (allocated(mesh%stiffness_cos)) mesh%stiffness_cos = factor*mesh%stiffness_cos
                     if (allocated(mesh%stiffness_sin)) mesh%stiffness_sin = factor*mesh%stiffness_sin
                  end associate
               end do
            else if (parameters(i)%direct) then
               call add_to_parameter(train, parameters(i), change, allowed)
               if (.not. allowed) return
            end if
         end do
      end associate
      train%characteristic_length = self%plain%characteristic_length
      train%characteristic_frequency = self%plain%characteristic_frequency
      associate (network => self%system%network)
         call build_system(train, system, unknown=network%elements(self%system%mesh_element)%unknown, like=network)
      end associate
   end subroutine changed_system

   !> Whether a changed value of a parameter is in the range of its variable.
   logical function allows(self, n, change)
      class(parameters_type), intent(in) :: self
      !> Number of the parameter.
      integer, intent(in) :: n
      !> What is added to the value [unit of the parameter].
      real(dp), intent(in) :: change
      type(system_type) :: system

      call self%changed_system(n, change, system, allows)
   end function allows

   !> Value of a parameter, the largest where it stands for several [unit of the parameter].
   pure real(dp) function value_of(self, n)
      class(parameters_type), intent(in) :: self
      !> Number of the parameter.
      integer, intent(in) :: n

      value_of = maxval(abs(self%named(n)%parameter%value))
   end function value_of

   !> Whether a train has the unknowns, elements and laws of another.
   pure logical function is_of_kind(system, other)
      !> The trains.
      type(system_type), intent(in) :: system, other
      integer :: j

      is_of_kind = system%cut%unknowns == other%cut%unknowns .and. system%elements == other%elements
      if (is_of_kind) is_of_kind = all([(size(system%law(j)%wall) == size(other%law(j)%wall) .and. &
                                         (system%law(j)%jumps .eqv. other%law(j)%jumps), j=1, system%meshes)])
   end function is_of_kind

   !> Whether the excitations of a train have as many harmonics as those of another.
   pure logical function has_lists_of(system, other)
      !> The trains.
      type(system_type), intent(in) :: system, other
      integer :: j

      has_lists_of = all([(size(system%torque(j)%harmonic) == size(other%torque(j)%harmonic), j=1, size(system%torque)), &
                          (size(system%law(j)%harmonic) == size(other%law(j)%harmonic) .and. &
                           size(system%transmission_error(j)%harmonic) == size(other%transmission_error(j)%harmonic), &
                           j=1, system%meshes)])
   end function has_lists_of

end module geartrain_network_gradient
