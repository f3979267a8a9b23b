!> The table of input variables: those of &stability_map; and the train with the parameter of a row.
module geartrain_analyses_stability_map_variables
   use geartrain_analyses_stability_map_settings, only: stability_map_settings_type
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text, real_text
   use geartrain_base_variable, only: row => variable_type, visitor_type
   use geartrain_model_check, only: check_train
   use geartrain_model_limits, only: check_frequency, check_harmonics
   use geartrain_model_mesh, only: mesh_type, plain_mesh
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: visit_stability_map, check_stability_map, check_stability_map_consistency, train_with, unit_of

   real(dp), parameter :: zero = 0, one = 1
   !> Most points along either side of the map.
   real(dp), parameter :: most_points = 10000
   integer, parameter :: most_harmonics = 1000

contains

   subroutine visit_stability_map(settings, v)
      type(stability_map_settings_type), intent(inout) :: settings
      class(visitor_type), intent(inout) :: v
      character(:), allocatable :: word

      call v%enter('stability_map', 1)
      call v%on_real(row('from', '', 'one end of the range of Lambda (start in a call)', required=.true., above=zero), &
                     settings%start)
      call v%on_real(row('to', '', 'its other end (stop in a call)', required=.true., above=zero), settings%stop)
      call v%on_integer(row('points', '', 'frequencies in the range, both ends included', least=one, most=most_points), &
                        settings%points)
      word = trim(settings%parameter)
      call v%on_text(row('parameter', '', 'what varies from row to row. stiffness_variation: largest amplitude of any harmonic of &
                         &kappa, all scaled alike; input_torque [N m]; mesh_damping_ratio and half_backlash [m]: of every mesh', &
                         choices='stiffness_variation mesh_damping_ratio input_torque half_backlash'), word)
      settings%parameter = word
      call v%on_real(row('parameter_from', '', 'one end of the range of the parameter (parameter_start in a call)', &
                         required=.true., least=zero), settings%parameter_start)
      call v%on_real(row('parameter_to', '', 'its other end (parameter_stop in a call)', required=.true., least=zero), &
                     settings%parameter_stop)
      call v%on_integer(row('parameter_points', '', 'values of the parameter in the range, both ends included', least=one, &
                            most=most_points), settings%parameter_points)
      call v%on_logical(row('linear', '', 'the train without backlash, all teeth in contact: where its parametric resonances &
                            &are; else the motions on the branch of every row'), settings%linear)
      call v%on_integer(row('harmonics', '', 'harmonics R of Lambda of the motions; not used by a linear map', least=one, &
                            most=most_harmonics*one), settings%harmonics)
      call v%leave()
   end subroutine visit_stability_map

   !> Checks the settings for a train that is in order; the error tells every problem, one a line.
   subroutine check_stability_map(train, settings, error)
      type(train_type), intent(in) :: train
      type(stability_map_settings_type), intent(in) :: settings
      type(error_type), allocatable, intent(out) :: error
      type(stability_map_settings_type) :: copy
      type(checker_type) :: checker

      copy = settings
      call visit_stability_map(copy, checker)
      call check_stability_map_consistency(train, settings, checker)
      call checker%problems%raise('', error)
   end subroutine check_stability_map

   !> What single values cannot say; the problems are added to those of `checker`.
   subroutine check_stability_map_consistency(train, settings, checker)
      type(train_type), intent(in) :: train
      type(stability_map_settings_type), intent(in) :: settings
      class(checker_type), intent(inout) :: checker

      if (checker%problems%in_group('stability_map')) return
      call checker%enter('stability_map', 1)
      ! A branch needs a range; the linear train does not.
      if (abs(settings%start - settings%stop) <= 0 .and. (settings%points > 1 .or. .not. settings%linear)) &
         call checker%complain('to', real_text(settings%stop), 'must differ from "from"')
      if (abs(settings%start - settings%stop) > 0 .and. settings%points == 1) &
         call checker%complain('points', integer_text(settings%points), 'must be >= 2 where "from" and "to" differ')
      if (abs(settings%parameter_start - settings%parameter_stop) <= 0 .neqv. settings%parameter_points == 1) &
         call checker%complain('parameter_points', integer_text(settings%parameter_points), &
                               'must be 1 where "parameter_from" and "parameter_to" are equal, and only there')
      call check_frequency(train, 'from', settings%start, checker)
      call check_frequency(train, 'to', settings%stop, checker)
      if (.not. settings%linear) call check_harmonics(train, settings%harmonics, 1, most_harmonics, checker)
      if (settings%linear .and. (settings%parameter == 'input_torque' .or. settings%parameter == 'half_backlash')) &
         call checker%complain('parameter', "'"//trim(settings%parameter)//"'", &
                               'has no influence on the stability of the linear train: leave out linear = .true.')
      if (settings%parameter == 'input_torque' .and. allocated(train%bodies)) &
         call checker%complain('parameter', "'input_torque'", 'is that of a chain: the bodies of this train have torques')
      if (settings%parameter == 'stiffness_variation' .and. allocated(train%meshes)) then
         if (.not. largest_variation(train%meshes) > 0 .and. .not. checker%problems%in_group('mesh')) &
            call checker%complain('parameter', "'"//trim(settings%parameter)//"'", &
                                  'needs a mesh with stiffness_cos or stiffness_sin, which give the shape that is scaled')
      end if
      call check_end('parameter_from', settings%parameter_start)
      call check_end('parameter_to', settings%parameter_stop)
      call checker%leave()

   contains

      !> The train at an end of the range of the parameter is one that can be computed.
      subroutine check_end(name, value)
         character(*), intent(in) :: name
         real(dp), intent(in) :: value
         type(error_type), allocatable :: wrong

         if (checker%problems%in_group('stability_map')) return
         call check_train(train, wrong)
         if (allocated(wrong)) return
         call check_train(train_with(train, settings, value), wrong)
         if (allocated(wrong)) call checker%complain(name, real_text(value), 'must be a value with which the train can be &
            &computed: '//wrong%message(:index(wrong%message//new_line('a'), new_line('a')) - 1))
      end subroutine check_end

   end subroutine check_stability_map_consistency

   !> The train of one row of the map.
   function train_with(train, settings, value) result(changed)
      type(train_type), intent(in) :: train
      type(stability_map_settings_type), intent(in) :: settings
      real(dp), intent(in) :: value
      type(train_type) :: changed
      type(mesh_type) :: mesh
      real(dp) :: factor
      integer :: j

      changed = train
      if (settings%linear) changed%meshes%half_backlash = 0
      select case (settings%parameter)
      case ('stiffness_variation')
         factor = value/largest_variation(train%meshes)
         do j = 1, size(changed%meshes)
            call plain_mesh(train%meshes(j), mesh)
            if (allocated(mesh%stiffness_cos)) mesh%stiffness_cos = factor*mesh%stiffness_cos
            if (allocated(mesh%stiffness_sin)) mesh%stiffness_sin = factor*mesh%stiffness_sin
            changed%meshes(j) = mesh
         end do
      case ('mesh_damping_ratio')
         changed%meshes%damping_ratio = value
         changed%meshes%damping_given = .false.
      case ('input_torque')
         changed%input_torque = value
      case ('half_backlash')
         changed%meshes%half_backlash = value
      end select
   end function train_with

   pure function unit_of(parameter) result(unit)
      character(*), intent(in) :: parameter
      character(merge(3, 1, parameter == 'input_torque')) :: unit

      unit = '1'
      if (parameter == 'input_torque') unit = 'N m'
      if (parameter == 'half_backlash') unit = 'm'
   end function unit_of

   !> Largest amplitude of any harmonic of kappa of any mesh.
   pure real(dp) function largest_variation(meshes) result(largest)
      type(mesh_type), intent(in) :: meshes(:)
      type(mesh_type) :: mesh
      real(dp) :: cosine, sine
      integer :: j, h, most

      largest = 0
      do j = 1, size(meshes)
         call plain_mesh(meshes(j), mesh)
         most = 0
         if (allocated(mesh%stiffness_cos)) most = size(mesh%stiffness_cos)
         if (allocated(mesh%stiffness_sin)) most = max(most, size(mesh%stiffness_sin))
         do h = 1, most
            cosine = 0
            sine = 0
            if (allocated(mesh%stiffness_cos)) then
               if (h <= size(mesh%stiffness_cos)) cosine = mesh%stiffness_cos(h)
            end if
            if (allocated(mesh%stiffness_sin)) then
               if (h <= size(mesh%stiffness_sin)) sine = mesh%stiffness_sin(h)
            end if
            largest = max(largest, hypot(cosine, sine))
         end do
      end do
   end function largest_variation

end module geartrain_analyses_stability_map_variables
