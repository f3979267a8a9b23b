!> Limits of the mesh frequency, of the frequencies of elements and of the number of harmonics. Beyond these limits a single point
!> would take hours, or a vibration would be lost in rounding, or an excitation would be left out without a message.
module geartrain_network_limits
   use geartrain_base_checker, only: checker_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text, real_text
   use geartrain_base_series, only: make_series, series_type
   use geartrain_train_bodies, only: bodies_of, body_count, find_ends
   use geartrain_network_frequency_unit, only: lambda_of
   use geartrain_network_excitation, only: lowest_harmonic
   use geartrain_mesh_law_characteristic, only: characteristic_type, find_characteristic
   use geartrain_network_elements, only: vibrating
   use geartrain_train_gear_error, only: gear_words
   use geartrain_train_mesh_groups, only: enter_mesh, mesh_word
   use geartrain_train_nearby_orders, only: most_cycles
   use geartrain_network_network, only: build_network, network_type, stiffening
   use geartrain_network_nodes, only: join_rigid, nodes_type
   use geartrain_network_system, only: put_excitation, system_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: check_common_period, check_frequency, check_harmonics, check_stiffest, in_order

   !> Smallest mesh frequency over the frequency of the slowest mesh [1]: below this limit a period of the fundamental takes more
   !> than about 1e5 steps of the flow.
   real(dp), parameter :: slowest = 1e-4_dp
   !> Largest mesh frequency over the frequency of the slowest mesh [1]: beyond this limit only the mean of a motion is left.
   real(dp), parameter :: fastest = 1e6_dp
   !> Largest ratio of the frequencies of two elements [1]: the fastest element determines the time step and the cost of the
   !> multipliers; a slower element is lost in rounding.
   real(dp), parameter :: largest_ratio = 1e6_dp

contains

   !> Adds a problem for every Lambda that is too small or too large, `name = value: must be >= ...`; nothing for a train not
   !> `in_order`.
   subroutine check_frequency(train, name, value, checker, unit)
      !> The plain train.
      type(train_type), intent(in) :: train
      !> Names of the variables, for the message.
      character(*), intent(in) :: name(:)
      !> Their frequencies in `unit`.
      real(dp), intent(in) :: value(:)
      class(checker_type), intent(inout) :: checker
      !> 'Lambda', 'rpm' or 'Hz'; absent: Lambda.
      character(*), intent(in), optional :: unit
      real(dp) :: decades, own, factor, least
      integer :: i

      if (.not. in_order(train, checker)) return
      ! By logarithms: the ratio itself may overflow.
      decades = log10(slowest_of(mesh_frequencies(train))) - log10(train%characteristic_frequency)
      factor = 1
      if (present(unit)) factor = lambda_of(train, unit)
      if (.not. factor > 0) return
      own = 10.0_dp**nint(max(-300.0_dp, min(300.0_dp, decades)))/factor
      ! The fundamental of hunting teeth is as slow as many periods of a mesh are long.
      least = slowest*own/minval(train%meshes%order)
      do i = 1, size(value)
         if (.not. value(i) >= least) call checker%complain(trim(name(i)), real_text(value(i)), 'must be >= '// &
            real_text(least)//': at a slower speed there are some '//integer_text(nint(1/slowest))//' vibrations or more of the &
            &slowest mesh'//trim(engaged())//', too many to be followed; begin there: a slower train follows its loads and &
            &errors without vibration')
         if (.not. value(i) <= fastest*own) call checker%complain(trim(name(i)), real_text(value(i)), 'must be <= '// &
            real_text(fastest*own)//': the train does not follow a faster frequency')
      end do

   contains

      !> In which cycle the vibrations are counted: of the mesh whose teeth engage least often.
      function engaged() result(words)
         character(64) :: words

         words = ' in a cycle of its teeth'
         if (size(train%meshes) > 1) words = ' in a cycle of the teeth of '//mesh_word(train%meshes, minloc(train%meshes%order, 1))
      end function engaged

   end subroutine check_frequency

   !> Adds a problem where the period of the fundamental has more cycles of a mesh than an analysis of whole periods can take. Time
   !> integration needs no such limit. Nothing for a train not `in_order`.
   subroutine check_common_period(train, group, checker, within)
      !> The plain train.
      type(train_type), intent(in) :: train
      !> Group of the analysis, for the message.
      character(*), intent(in) :: group
      class(checker_type), intent(inout) :: checker
      !> Whether the period can be taken.
      logical, intent(out), optional :: within
      integer :: fastest_mesh

      if (present(within)) within = .true.
      if (.not. in_order(train, checker)) return
      fastest_mesh = maxloc(train%meshes%order, 1)
      associate (order => train%meshes(fastest_mesh)%order)
         if (order <= most_cycles) return
         if (present(within)) within = .false.
         call checker%problems%add('all meshes together repeat themselves after '//integer_text(order)//' cycles of mesh '// &
            integer_text(fastest_mesh)//', and a periodic motion of more than '//integer_text(most_cycles)//' cycles is not &
            &computed: integrate in time (integration, run_up), give the errors of the gears of one shaft &
            &at a time, or take numbers of teeth with common divisors', group, 1)
      end associate
   end subroutine check_common_period

   !> Adds a problem where all harmonics of a source of excitation are higher than the harmonics of a motion; nothing for a train
   !> not `in_order`.
   subroutine check_harmonics(train, harmonics, subharmonic, most, checker)
      !> The plain train.
      type(train_type), intent(in) :: train
      !> Number of harmonics of Lambda/subharmonic, 0: chosen by the program; sub-harmonic index; most harmonics that the program
      !> chooses, 0: it chooses none.
      integer, intent(in) :: harmonics, subharmonic, most
      class(checker_type), intent(inout) :: checker
      type(system_type) :: system
      integer :: gear, j, lowest

      if (.not. in_order(train, checker)) return
      call put_excitation(train, system)
      do j = 1, size(system%torque)
         if (.not. has_too_few(system%torque(j))) cycle
         if (allocated(train%bodies)) then
            call complain('the fluctuation of the torque of &body '//integer_text(system%torque_body(j)))
         else
            call complain('the fluctuation of the torque')
         end if
      end do
      do j = 1, system%meshes
         if (has_too_few(system%law(j)%variation())) &
            call complain('the variation of the stiffness of &mesh '//integer_text(j))
         associate (mesh => train%meshes(j))
            if (has_too_few(make_series(mesh%error_cos, mesh%error_sin, 1.0_dp, mesh%order))) &
               call complain('the transmission error of &mesh '//integer_text(j))
            do gear = 1, 2
               associate (error => mesh%gear_error(gear))
                  if (has_too_few(make_series(error%cosine, error%sine, 1.0_dp, error%order))) &
                     call complain('the error of the '//trim(gear_words(gear))//' gear of &mesh '//integer_text(j))
               end associate
            end do
         end associate
      end do

   contains

      !> Whether the harmonics asked for leave out all of a source, whose lowest harmonic is then `lowest`.
      logical function has_too_few(source)
         type(series_type), intent(in) :: source

         lowest = lowest_harmonic(source)
         if (harmonics > 0) then
            has_too_few = lowest*subharmonic > harmonics
         else
            has_too_few = harmonics == 0 .and. lowest*subharmonic > most*merge(system%excitation_order, 1, subharmonic == 1)
         end if
      end function has_too_few

      subroutine complain(source)
         character(*), intent(in) :: source
         character(:), allocatable :: needed

         needed = integer_text(lowest)
         if (subharmonic > 1) needed = needed//'*subharmonic = '//integer_text(lowest*subharmonic)
         needed = needed//': '//source//' has no lower harmonic of Lambda and would be left out'
         if (harmonics == 0) then
            call checker%complain('harmonics', '0', 'chooses at most '//integer_text(most)//', and must choose >= '//needed)
            return
         end if
         if (most > 0) needed = needed//'; 0 chooses those that matter'
         call checker%complain('harmonics', integer_text(harmonics), 'must be >= '//needed)
      end subroutine complain

   end subroutine check_harmonics

   !> Adds a problem for every element that vibrates or creeps too fast, or vibrates too slowly, compared with the slowest mesh;
   !> nothing for a train not `in_order`.
   subroutine check_stiffest(train, own, checker)
      !> The plain train.
      type(train_type), intent(in) :: train
      !> Frequency of the slowest mesh, neither 0 nor infinite, of a train `in_order` [rad/s].
      real(dp), intent(out) :: own
      class(checker_type), intent(inout) :: checker
      type(nodes_type) :: nodes
      character(*), parameter :: units = 'are radii, inertias and stiffness in SI units?'
      real(dp) :: frequency(merge(size(train%meshes), 0, allocated(train%meshes)))
      type(characteristic_type) :: found
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      integer :: i

      own = 1
      if (.not. in_order(train, checker)) return
      frequency = mesh_frequencies(train)
      own = slowest_of(frequency)
      call find_ends(train, shaft_ends, mesh_ends)
      call join_rigid(train, nodes)
      do i = 1, size(train%shafts)
         associate (shaft => train%shafts(i), ends => shaft_ends(:, i))
            if (shaft%rigid) cycle
            call check_element(sqrt(shaft%stiffness)*sqrt(sum(1/vibrating(nodes, 0*nodes%node*1.0_dp, ends, .false.))), 'shaft', &
                               'stiffness', shaft%stiffness, &
                               shaft%damping_ratio, shaft%damping_given, shaft%damping, &
                               'make the shaft rigid, or give the inertias at its ends as they are')
         end associate
      end do
      do i = 1, size(nodes%node)
         if (.not. allocated(train%bodies)) exit
         if (nodes%node(i) == 0) cycle
         if (.not. train%bodies(i)%damping_to_ground > largest_ratio*own*nodes%inertia(nodes%node(i))) cycle
         call checker%enter('body', i)
         call checker%complain('damping_to_ground', real_text(train%bodies(i)%damping_to_ground), 'must be smaller: the rate at &
                               &which it brings the body to rest is more than 1e6 times the frequency of the slowest mesh, too &
                               &fast to be followed')
         call checker%leave()
      end do
      do i = 1, size(train%meshes)
         associate (mesh => train%meshes(i))
            if (mesh%axis > 2) cycle
            if (mesh%axis > 0) then
               call check_element(frequency(i), 'bearing', 'stiffness', mesh%stiffness/mesh%share, 0.0_dp, .true., &
                                  mesh%damping/mesh%share, &
                                  'are mass and stiffness in SI units?')
               cycle
            else if (mesh%is_coupling) then
               call find_characteristic(mesh%torsional_stiffness, mesh%half_play, mesh%angle, mesh%torque, found)
               associate (k => maxval(found%slope))
                  call check_element(frequency(i)*sqrt(k/found%stiffness), 'coupling', &
                                     merge('stiffness', 'torque   ', mesh%torsional_stiffness > 0), k, mesh%damping_ratio, &
                                     mesh%damping_given, mesh%torsional_damping, units)
               end associate
               cycle
            end if
            call check_element(frequency(i), 'mesh', 'stiffness', mesh%stiffness, mesh%damping_ratio, mesh%damping_given, &
                               mesh%damping, units)
            if (mesh%back_stiffness > 0) &
               call check_element(frequency(i)*sqrt(mesh%back_stiffness/mesh%stiffness), 'mesh', 'back_stiffness', &
                                  mesh%back_stiffness, 0.0_dp, .false., 0.0_dp, units)
         end associate
      end do

   contains

      subroutine check_element(frequency, group, name, stiffness, ratio, given, damping, cure)
         real(dp), intent(in) :: frequency, stiffness, ratio, damping
         logical, intent(in) :: given
         character(*), intent(in) :: group, name, cure
         character(*), parameter :: creeps = 'must be smaller: the rate at which it brings the part to rest, damping times &
            &frequency^2 over stiffness, is more than 1e6 times the frequency of the slowest mesh, too fast to be followed'

         if (group == 'shaft') call checker%enter(group, i)
         if (group /= 'shaft') call enter_mesh(checker, train%meshes, i)
         if (frequency > largest_ratio*own) then
            call checker%complain(trim(name), real_text(stiffness), 'must be smaller: it makes the part vibrate more than 1e6 &
                                  &times as fast as the slowest mesh, too fast to be followed: '//cure)
         else if (frequency < own/largest_ratio) then
            call checker%complain(trim(name), real_text(stiffness), 'must be larger: it makes the part vibrate more than 1e6 &
                                  &times as slowly as the slowest mesh, which is lost in rounding')
         else if (given) then
            if (damping*frequency/stiffness*frequency > largest_ratio*own) &
               call checker%complain('damping', real_text(damping), creeps)
         else if (2*ratio*frequency > largest_ratio*own) then
            call checker%complain('damping_ratio', real_text(ratio), creeps)
         end if
         call checker%leave()
      end subroutine check_element

   end subroutine check_stiffest

   !> Whether a train has all values that these limits are computed from, and no problem was found in its groups.
   pure logical function in_order(train, checker)
      !> The plain train.
      type(train_type), intent(in) :: train
      !> Problems found so far.
      class(checker_type), intent(in) :: checker

      in_order = allocated(train%shafts) .and. allocated(train%meshes)
      if (.not. in_order) return
      in_order = size(train%meshes) > 0 .and. train%characteristic_frequency > 0 .and. train%characteristic_length > 0
      ! A problem that stands outside of the groups belongs to no group, so the values are checked here as well.
      if (in_order) in_order = all(train%meshes%stiffness > 0 .and. train%meshes%driving_radius > 0 .and. &
                                   train%meshes%driven_radius > 0)
      if (in_order .and. .not. allocated(train%bodies)) &
         in_order = size(train%shafts) == size(train%meshes) + 1 .and. all(train%meshes%driving_inertia > 0 .and. &
                                                                           train%meshes%driven_inertia > 0)
      if (in_order) in_order = all(train%meshes%axis == 0 .or. train%meshes%mass > 0)
      if (in_order) in_order = .not. (checker%problems%in_group('train') .or. checker%problems%in_group('body') .or. &
                                      checker%problems%in_group('shaft') .or. checker%problems%in_group('mesh') .or. &
                                      checker%problems%in_group('coupling') .or. checker%problems%in_group('bearing'))
   end function in_order

   !> The slowest of these frequencies; neither 0 nor infinite.
   pure real(dp) function slowest_of(frequency)
      real(dp), intent(in) :: frequency(:)

      slowest_of = min(huge(1.0_dp), max(tiny(1.0_dp), minval(frequency)))
   end function slowest_of

   !> Frequency of each mesh [rad/s], (mesh): of its two gears alone, with the stiffening by loops; of a bearing of the mass that it
   !> carries.
   pure function mesh_frequencies(train) result(frequency)
      type(train_type), intent(in) :: train
      real(dp) :: frequency(size(train%meshes))
      real(dp), dimension(body_count(train)) :: inertia, torque
      type(network_type) :: network
      real(dp), allocatable :: factor(:)
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      integer, allocatable :: balancing(:)
      logical :: held(size(inertia))
      integer :: n

      call bodies_of(train, inertia, torque, balancing, held)
      where (held) inertia = huge(inertia)
      call find_ends(train, shaft_ends, mesh_ends)
      associate (mesh => train%meshes)
         frequency = sqrt(mesh%stiffness)*hypot(mesh%driving_radius/sqrt(inertia(mesh_ends(1, :))), &
                                                      mesh%driven_radius/sqrt(inertia(mesh_ends(2, :))))
         where (mesh%axis > 0) frequency = sqrt(mesh%stiffness/mesh%mass)
         do n = 1, merge(size(mesh), 0, any(mesh%axis == 1))
            if (.not. mesh(n)%is_pair()) cycle
            ! Masses on bearings come nearer along the line of action.
            frequency(n) = sqrt(frequency(n)**2 + mesh(n)%stiffness*sum(1/mesh%mass, mesh%axis == 1 .and. &
               (mesh_ends(1, :) == mesh_ends(1, n) .or. mesh_ends(1, :) == mesh_ends(2, n))))
         end do
      end associate
      if (.not. allocated(train%bodies)) return
      call build_network(train, network)
      factor = stiffening(network)
      do n = 1, size(factor)
         associate (j => network%elements(n)%mesh)
            if (j > 0) frequency(j) = frequency(j)*sqrt(factor(n))
         end associate
      end do
   end function mesh_frequencies

end module geartrain_network_limits
