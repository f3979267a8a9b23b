!> The trains of a stability map, one for each value of its parameter.
module geartrain_analyses_map_trains
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp
   use geartrain_drawing_drawing, only: drop_drawing, plain_train
   use geartrain_network_parameter_path, only: parameter_path_type
   use geartrain_train_mesh, only: straighten
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: map_trains_type, moves_linear_train

   type :: map_trains_type
      !> Unit of the parameter, '1' for a dimensionless one.
      character(:), allocatable :: unit
      type(parameter_path_type), private :: path
      !> Whether the trains have no backlash.
      logical, private :: linear = .false.
   contains
      procedure :: setup
      procedure :: train_at
   end type map_trains_type

contains

   !> Prepares the trains. The short names 'mesh_damping_ratio' and 'half_backlash' stand for these numbers of every mesh, whatever
   !> they follow from in the train as described; any other name is one of `find_parameters`.
   subroutine setup(self, train, name, frequency_ratio, start, stop, linear, error)
      class(map_trains_type), intent(inout) :: self
      !> A train that has passed `check_train`.
      type(train_type), intent(in) :: train
      !> Name of the parameter.
      character(*), intent(in) :: name
      !> Lambda at which the trains are checked [1]; ends of the range of the parameter [unit of the parameter].
      real(dp), intent(in) :: frequency_ratio, start, stop
      !> Whether the trains have no backlash.
      logical, intent(in) :: linear
      !> Added to where there is no such parameter, or no train somewhere in the range.
      type(error_type), allocatable, intent(inout) :: error
      type(train_type) :: plain

      self%linear = linear
      select case (name)
      case ('mesh_damping_ratio', 'half_backlash')
         call plain_train(train, plain)
         call drop_drawing(plain%meshes)
         if (name == 'mesh_damping_ratio') plain%meshes%damping_given = .false.
         call self%path%setup(plain, 'mesh * '//trim(merge('damping_ratio', 'half_backlash', name == 'mesh_damping_ratio')), &
                              frequency_ratio, start, stop, error)
      case default
         call self%path%setup(train, name, frequency_ratio, start, stop, error)
      end select
      if (.not. allocated(error)) self%unit = self%path%unit
   end subroutine setup

   !> The train with a value of the parameter.
   subroutine train_at(self, value, train)
      class(map_trains_type), intent(in) :: self
      !> Value [unit of the parameter].
      real(dp), intent(in) :: value
      type(train_type), intent(out) :: train
      type(train_type) :: given

      call self%path%train_at(value, given)
      if (.not. self%linear) then
         train = given
         return
      end if
      call plain_train(given, train)
      call drop_drawing(train%meshes)
      call straighten(train%meshes)
   end subroutine train_at

   !> Whether a parameter may change the stability of the train without backlash: neither gaps nor excitations do, and torques only
   !> through the stiffness of teeth under light loads.
   pure logical function moves_linear_train(train, name) result(moves)
      !> The train as described.
      type(train_type), intent(in) :: train
      !> Name of the parameter.
      character(*), intent(in) :: name

      moves = .not. (has_word('half_backlash') .or. has_word('backlash') .or. has_word('half_play') .or. has_word('torque_cos') &
                     .or. has_word('torque_sin') .or. has_word('error_cos') .or. has_word('error_sin') &
                     .or. has_word('error_table') .or. has_word('revolution_torque_cos') .or. has_word('revolution_torque_sin') &
                     .or. index(name, 'driving_error_') > 0 .or. index(name, 'driven_error_') > 0 &
                     .or. index(name, 'pitch_error') > 0 .or. index(name, 'runout') > 0)
      if (has_word('input_torque') .or. has_word('torque') .or. has_word('torque_table')) moves = any(train%meshes%face_width > 0)

   contains

      pure logical function has_word(word)
         character(*), intent(in) :: word

         has_word = index(' '//trim(adjustl(name))//' ', ' '//word//' ') > 0
      end function has_word

   end function moves_linear_train

end module geartrain_analyses_map_trains
