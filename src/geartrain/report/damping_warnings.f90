!> Warnings of damping: modes with hardly any, and damping ratios asked of the modes that shafts and meshes cannot give.
module geartrain_report_damping_warnings
   use geartrain_base_error, only: error_type
   use geartrain_base_field, only: text_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_numbers, only: integer_text, real_text, short => text
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_network_check_train, only: check_train
   use geartrain_network_light_loads, only: reduce_light_loads
   use geartrain_train_bodies, only: bodies_of, body_count, find_ends
   use geartrain_train_mesh_groups, only: group_name, group_number, mesh_word
   use geartrain_network_elements, only: vibrating
   use geartrain_network_modal_damping, only: asked_ratios, find_modal_damping, modal_damping_type, resolve_damping
   use geartrain_network_natural_modes, only: modes_type, natural_modes
   use geartrain_network_nodes, only: join_rigid, nodes_type
   use geartrain_report_add_warning, only: add_warning
   use geartrain_train_labels, only: label_length, mesh_labels, shaft_labels
   use geartrain_train_mesh, only: is_given
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: three_digits, warn_of_damping_of_modes, warn_of_joined_inertias

   !> Damping ratio below which a mode is warned of [1], and below which it counts as undamped.
   real(dp), parameter :: hardly_any = 1e-3_dp, none = 1e-9_dp
   !> Relative error of a damping ratio that `modal_damping` asks for, from which on it is warned of [1].
   real(dp), parameter :: worth_telling = 0.05_dp
   !> Warns of a damping ratio where the mobility of the bodies alone exceeds the mobility of the joined bodies by this factor.
   real(dp), parameter :: far_off = 1.1_dp
   !> Modes that are told one by one.
   integer, parameter :: most_modes = 3
   !> Modes up to which damping ratios are those of eigenvalues: the time grows with the third power.
   integer, parameter :: most_eigenvalues = 100

contains

   !> Adds a warning for each mode of hardly any damping, and one where `modal_damping` is not met.
   subroutine warn_of_damping_of_modes(train, warnings)
      !> The train; nothing is added for a train that `check_train` refuses.
      type(train_type), intent(in) :: train
      !> Gets a sentence each.
      type(text_type), allocatable, intent(inout) :: warnings(:)
      type(train_type) :: plain
      type(modal_damping_type) :: found
      type(modes_type) :: modes
      type(error_type), allocatable :: error
      character(:), allocatable :: words
      real(dp), allocatable :: ratio(:)
      integer :: i, told

      call check_train(train, error)
      if (allocated(error)) return
      call plain_train(train, plain)
      call reduce_light_loads(plain)
      call resolve_damping(plain)
      call find_modal_damping(plain, found)
      ! The eigenvalues of the damped train, not the diagonal of its modal damping matrix: of two modes of nearly equal frequency
      ! one may have all the damping. Of large trains they take too long.
      ratio = found%ratio
      if (size(ratio) <= most_eigenvalues) then
         call natural_modes(train, modes, error)
         if (allocated(error)) return
         ratio = modes%damping_ratio
      end if
      told = 0
      do i = 1, size(ratio)
         if (ratio(i) >= hardly_any) cycle
         told = told + 1
         if (told > most_modes) cycle
         call put_mode(train, plain, found, i, ratio(i), words)
         call add_warning(warnings, 'train', 0, words)
      end do
      if (told > most_modes) call add_warning(warnings, 'train', 0, integer_text(told - most_modes)// &
                                               ' more modes have less than '//short(hardly_any)//' of critical damping')
      if (is_given(train%modal_damping)) call warn_of_misses(found, asked_ratios(train, size(found%ratio)), warnings)
   end subroutine warn_of_damping_of_modes

   !> Warns of damping ratios at rigidly joined bodies: the ratio refers to the inertias of the bodies alone.
   subroutine warn_of_joined_inertias(train, plain, warnings)
      !> The train that has been checked, and the same as the solver takes it.
      type(train_type), intent(in) :: train, plain
      !> Gets a sentence each.
      type(text_type), allocatable, intent(inout) :: warnings(:)
      type(nodes_type) :: nodes
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      real(dp), dimension(body_count(plain)) :: inertia, torque
      integer, allocatable :: balancing(:)
      integer :: i

      if (.not. allocated(plain%bodies)) return
      call bodies_of(plain, inertia, torque, balancing)
      call find_ends(plain, shaft_ends, mesh_ends)
      call join_rigid(plain, nodes)
      do i = 1, size(train%shafts)
         associate (shaft => train%shafts(i))
            if (.not. (shaft%rigid .or. shaft%damping_given) .and. shaft%damping_ratio > 0) &
               call compare('shaft', shaft%damping_ratio, shaft_ends(:, i), [1.0_dp, 1.0_dp])
         end associate
      end do
      do i = 1, size(train%meshes)
         associate (mesh => train%meshes(i), made => plain%meshes(i))
            if (.not. mesh%damping_given .and. mesh%damping_ratio > 0) &
               call compare(trim(group_name(train%meshes, i)), mesh%damping_ratio, mesh_ends(:, i), &
                            [made%driving_radius, made%driven_radius])
         end associate
      end do

   contains

      subroutine compare(group, ratio, ends, radius)
         character(*), intent(in) :: group
         real(dp), intent(in) :: ratio, radius(2)
         integer, intent(in) :: ends(2)
         real(dp) :: alone, joined
         integer :: number

         alone = sum(radius**2/vibrating(nodes, inertia, ends, .true.))
         joined = sum(radius**2/vibrating(nodes, inertia, ends, .false.))
         number = i
         if (group /= 'shaft') number = group_number(train%meshes, i)
         if (.not. alone > far_off*joined) return
         call add_warning(warnings, group, number, 'damping_ratio = '//real_text(ratio)//' of the bodies alone: with what is &
            &rigidly joined to them the same damping is '//short(ratio*sqrt(joined/alone)))
      end subroutine compare

   end subroutine warn_of_joined_inertias

   !> A mode and why it has hardly any damping, in words.
   subroutine put_mode(train, plain, found, i, ratio, words)
      !> The train as described, and its plain train with damping coefficients.
      type(train_type), intent(in) :: train, plain
      type(modal_damping_type), intent(in) :: found
      integer, intent(in) :: i
      real(dp), intent(in) :: ratio
      character(:), allocatable, intent(out) :: words
      real(dp) :: given, own
      integer :: n

      n = maxloc(found%share(:, i), 1)
      words = 'mode '//integer_text(i)//' at '//trim(frequency_text(train, plain, found%frequency(i)))//' has '
      if (ratio > none) words = words//'only '//trim(three_digits(ratio))//' of critical damping: '
      if (.not. ratio > none) words = words//'no damping: '
      words = words//short(real(nint(100*found%share(n, i)), dp))//' % of its strain energy is in '// &
              trim(element_text(train, found, n))
      own = found%frequency(i)*found%damping(n)/(2*found%stiffness(n))
      given = 0
      if (found%shaft(n) > 0) then
         if (.not. train%shafts(found%shaft(n))%damping_given) given = train%shafts(found%shaft(n))%damping_ratio
      else if (found%mesh(n) > 0) then
         if (.not. train%meshes(found%mesh(n))%damping_given) given = train%meshes(found%mesh(n))%damping_ratio
      end if
      if (.not. own > 0) then
         words = words//', which has none'
      else if (given > 0) then
         words = words//', whose damping_ratio = '//short(given)//' is that of its end inertias alone, at '// &
                 trim(frequency_text(train, plain, found%frequency(i)*given/own))//'; at the frequency of the mode it is '// &
                 trim(three_digits(own))
      else
         words = words//', whose damping is '//trim(three_digits(own))//' of critical at this frequency'
      end if
      words = words//'. loss_factor of the element or modal_damping of the train gives more'
   end subroutine put_mode

   !> A frequency in Hz, or as Lambda where the case has a characteristic frequency of its own.
   pure function frequency_text(train, plain, frequency) result(words)
      type(train_type), intent(in) :: train, plain
      !> Frequency [rad/s].
      real(dp), intent(in) :: frequency
      character(32) :: words

      if (abs(train%characteristic_frequency) > 0) then
         words = 'Lambda = '//trim(three_digits(frequency/plain%characteristic_frequency))
      else
         words = trim(three_digits(frequency/(2*pi)))//' Hz'
      end if
   end function frequency_text

   !> A number with three significant digits, as text.
   pure function three_digits(value) result(words)
      !> The number, in any unit.
      real(dp), intent(in) :: value
      character(16) :: words
      character(12) :: digits
      real(dp) :: rounded

      write (digits, '(es12.2e3)') value
      read (digits, *) rounded
      words = short(rounded)
   end function three_digits

   !> 'shaft 1 (motor - pinion)'.
   function element_text(train, found, n) result(words)
      type(train_type), intent(in) :: train
      type(modal_damping_type), intent(in) :: found
      integer, intent(in) :: n
      character(label_length + 24) :: words
      character(label_length) :: shafts(size(train%shafts)), meshes(size(train%meshes)), label

      if (found%shaft(n) > 0) then
         words = 'shaft '//integer_text(found%shaft(n))
         shafts = shaft_labels(train)
         label = shafts(found%shaft(n))
      else if (found%mesh(n) == 0) then
         label = 'a spring to ground'
         words = label
      else
         words = mesh_word(train%meshes, found%mesh(n))
         meshes = mesh_labels(train)
         label = meshes(found%mesh(n))
      end if
      if (label /= words) words = trim(words)//' ('//trim(label)//')'
   end function element_text

   !> Adds a warning where the modes do not have the damping ratios asked for.
   subroutine warn_of_misses(found, asked, warnings)
      type(modal_damping_type), intent(in) :: found
      real(dp), intent(in) :: asked(:)
      type(text_type), allocatable, intent(inout) :: warnings(:)
      character(:), allocatable :: list
      integer :: i, told

      told = 0
      list = ''
      do i = 1, size(asked)
         if (abs(found%ratio(i) - asked(i)) <= worth_telling*asked(i)) cycle
         told = told + 1
         if (told > most_modes) cycle
         list = list//', mode '//integer_text(i)//' has '//trim(three_digits(found%ratio(i)))//' in place of '//short(asked(i))
      end do
      if (told == 0) return
      if (told > most_modes) list = list//', and '//integer_text(told - most_modes)//' more'
      call add_warning(warnings, 'train', 0, 'modal_damping is not met: '//list(3:)//'. No damping >= 0 of shafts, &
         &meshes and couplings comes nearer to all modes together')
   end subroutine warn_of_misses

end module geartrain_report_damping_warnings
