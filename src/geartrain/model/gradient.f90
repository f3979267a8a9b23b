!> Derivatives with respect to parameters of a train: of its system, which all others follow from, and of its natural frequencies.
module geartrain_model_gradient
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
   use geartrain_base_error, only: error_type, fatal, status_ended_early
   use geartrain_base_kinds, only: dp
   use geartrain_model_check, only: check_train
   use geartrain_model_drawing, only: plain_train, reduce_light_loads
   use geartrain_model_modal_damping, only: resolve_damping
   use geartrain_model_mode_rates, only: mode_shapes_type
   use geartrain_model_parameter, only: find_parameters, variation
   use geartrain_model_parameter_table, only: add_to_parameter, parameter_type, table_type
   use geartrain_model_system, only: build_system, system_type
   use geartrain_model_system_rate, only: find_system_rate, system_rate_type
   use geartrain_model_train, only: train_type
   use geartrain_model_train_rate, only: find_train_rate, has_effect
   implicit none (type, external)
   private
   public :: gradient_type, parameters_type, begin_gradient, check_parameters, frequency_gradient, reason_length

   integer, parameter :: reason_length = 120
   !> Variables that make a train of another kind where they are 0.
   character(*), parameter :: structural = ' half_backlash backlash damping_to_ground damping damping_ratio stiffness_cos &
      &stiffness_sin '

   type :: gradient_type
      !> Derivatives [unit of the figure/unit of the parameter], (mesh, shaft or mode, parameter); NaN where there is none.
      real(dp), allocatable :: values(:, :)
      !> Why there is none, blank where there is one, (parameter).
      character(reason_length), allocatable :: reason(:)
      !> Lambda of the special point as the balance has it [1].
      real(dp) :: frequency_ratio = 0
   end type gradient_type

   !> What a name stands for: one parameter, or with * those of several groups.
   type :: named_type
      type(parameter_type), allocatable :: parameter(:)
   end type named_type

   !> A train and parameters of it by their names.
   type :: parameters_type
      !> The train; its plain train; the plain train with 0 for all numbers; derivatives of its numbers.
      type(train_type) :: train
      type(train_type), private :: plain, zero, rate
      type(system_type) :: system
      type(named_type), allocatable :: named(:)
   contains
      procedure :: setup
      procedure :: rate_of
      procedure :: changed_system
      procedure :: allows
      procedure :: value_of
      procedure, private :: clear
   end type parameters_type

contains

   !> Refuses names of no parameters, and of those that are not in force.
   subroutine check_parameters(train, names, error)
      !> The train.
      type(train_type), intent(in) :: train
      !> Names of the parameters, (parameter).
      character(*), intent(in) :: names(:)
      type(error_type), allocatable, intent(out) :: error
      type(parameters_type) :: given

      call given%setup(train, names, error)
   end subroutine check_parameters

   !> Finds the derivatives of the natural frequencies over characteristic frequency.
   subroutine frequency_gradient(train, names, gradient, error)
      !> The train.
      type(train_type), intent(in) :: train
      !> Names of the parameters, (parameter).
      character(*), intent(in) :: names(:)
      !> The derivatives, (mode, parameter).
      type(gradient_type), intent(out) :: gradient
      type(error_type), allocatable, intent(out) :: error
      type(parameters_type) :: given
      type(mode_shapes_type) :: shapes
      type(system_rate_type) :: rate
      integer :: info, n

      call given%setup(train, names, error)
      if (allocated(error)) return
      call begin_gradient(gradient, given%system%displacements, size(names))
      call shapes%setup(given%system, info)
      if (info /= 0) call fatal(error, 'gradient: LAPACK did not converge', status_ended_early)
      if (info /= 0) return
      do n = 1, size(names)
         call given%rate_of(n, rate, gradient%reason(n))
         if (gradient%reason(n) /= '') cycle
         call shapes%rates(given%system, rate, gradient%values(:, n))
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
      allocate (gradient%reason(parameters))
      gradient%reason = ''
   end subroutine begin_gradient

   !> Finds the parameters and the system.
   subroutine setup(self, train, names, error)
      class(parameters_type), intent(inout) :: self
      !> The train.
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
      self%zero = self%plain
      derived%number = 0
      call derived%give(self%zero)
      self%rate = self%zero
      call build_system(train, self%system)
   end subroutine setup

   !> Derivatives of the system with respect to a parameter.
   subroutine rate_of(self, n, rate, reason)
      class(parameters_type), intent(inout) :: self
      !> Number of the parameter.
      integer, intent(in) :: n
      !> The derivatives, where there are any; of the same system from call to call.
      type(system_rate_type), intent(inout) :: rate
      !> Why there are none; blank where there are.
      character(*), intent(out) :: reason
      logical :: differentiable
      integer :: i

      reason = ''
      do i = 1, size(self%named(n)%parameter)
         associate (parameter => self%named(n)%parameter(i))
            if (.not. abs(parameter%value) > 0 .and. index(structural, ' '//trim(parameter%variable)//' ') > 0) then
               if (changes_kind(self%train, parameter, self%system)) &
                  reason = 'it is 0, and with another value the train is of another kind'
            end if
            if (reason /= '') exit
            call find_train_rate(self%train, self%plain, parameter, self%rate, differentiable)
            if (.not. differentiable) reason = 'the drawing gives another train with a value next to it'
            if (reason /= '') exit
         end associate
      end do
      if (reason == '') then
         call find_system_rate(self%plain, self%rate, self%system, rate)
         if (rate%network%locks) reason = 'the gears of a loop would lock'
      end if
      call self%clear(n)
   end subroutine rate_of

   !> The system of the train with a changed value of a parameter, in the same units and with the same unknowns.
   subroutine changed_system(self, n, change, system, allowed)
      class(parameters_type), intent(in) :: self
      !> Number of a parameter for which `rate_of` has no reason against derivatives.
      integer, intent(in) :: n
      !> What is added to the value [unit of the parameter].
      real(dp), intent(in) :: change
      !> The system, where the change is allowed.
      type(system_type), intent(out) :: system
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
      call build_system(train, system, unknown=self%system%network%elements(self%system%mesh_element)%unknown)
      allowed = system%states == self%system%states
   end subroutine changed_system

   !> Whether a changed value of a parameter is in the range of its variable.
   logical function allows(self, n, change)
      class(parameters_type), intent(in) :: self
      !> Number of a parameter for which `rate_of` has no reason against derivatives.
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

   !> Sets the derivatives of the numbers of the train to 0 again. A copy of the whole would cost as much as the derivatives.
   subroutine clear(self, n)
      class(parameters_type), intent(inout) :: self
      !> Number of the parameter.
      integer, intent(in) :: n
      integer :: i

      associate (parameter => self%named(n)%parameter)
         if (.not. all(parameter%direct .and. (parameter%group == 'shaft' .or. parameter%group == 'mesh'))) then
            self%rate = self%zero
            return
         end if
         do i = 1, size(parameter)
            associate (place => parameter(i)%index)
               if (parameter(i)%group == 'shaft') self%rate%shafts(place) = self%zero%shafts(place)
               if (parameter(i)%group == 'mesh') self%rate%meshes(place) = self%zero%meshes(place)
            end associate
         end do
      end associate
   end subroutine clear

   !> Whether a train has other unknowns, elements or laws where a parameter is not 0.
   logical function changes_kind(train, parameter, system)
      type(train_type), intent(in) :: train
      type(parameter_type), intent(in) :: parameter
      type(system_type), intent(in) :: system
      type(train_type) :: changed
      type(system_type) :: other
      integer :: j

      changed = train
      call add_to_parameter(changed, parameter, 1e-6_dp)
      call build_system(changed, other)
      changes_kind = system%cut%unknowns /= other%cut%unknowns .or. system%elements /= other%elements
      if (changes_kind) return
      changes_kind = any([(size(system%law(j)%wall) /= size(other%law(j)%wall) .or. &
                           (system%law(j)%jumps .neqv. other%law(j)%jumps), j=1, system%meshes)])
   end function changes_kind

end module geartrain_model_gradient
