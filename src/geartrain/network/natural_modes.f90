!> Natural frequencies and mode shapes of the mean linear system: every mesh is on the flank of its mean load, with the mean
!> stiffness of this flank.
module geartrain_network_natural_modes
   use geartrain_base_error, only: error_type, fatal, status_ended_early
   use geartrain_base_kinds, only: dp
   use geartrain_base_sorting, only: ascending
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_linalg_lapack, only: dgeev
   use geartrain_network_check_train, only: check_train
   use geartrain_train_mesh_groups, only: mesh_word
   use geartrain_network_network, only: network_type
   use geartrain_network_system, only: build_system, system_type
   use geartrain_network_system_spectrum, only: eigenvalue_ranges, eigenvalues_of
   use geartrain_train_labels, only: body_labels, label_length, mesh_labels, shaft_labels
   use geartrain_train_planetary_sets, only: find_sets, planetary_set_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: modes_type, natural_modes, natural_frequency_ranges, state_matrix, stiffness_at_rest

   !> Rotation over the largest of a mode that is rounding [1].
   real(dp), parameter :: still = 1e-6_dp

   type :: modes_type
      !> Undamped natural frequencies over characteristic frequency [1], ascending, without the rigid-body mode, (mode).
      real(dp), allocatable :: natural_frequency(:)
      !> Imaginary part of the damped eigenvalue over characteristic frequency [1], 0 for an overdamped mode, and damping ratio [1],
      !> (mode).
      real(dp), allocatable :: damped_frequency(:), damping_ratio(:)
      !> Displacement of each element (mesh displacement, or shaft twist times base radius), largest 1, (element, mode).
      real(dp), allocatable :: shape(:, :)
      !> Rotation of each body, the turning of the whole train left out, largest 1, (body, mode); stiffness times squared
      !> displacement of each element in this motion [N m], (element, mode).
      real(dp), allocatable :: rotation(:, :), energy(:, :)
      !> Rotation of each body in the motions that deflect no element, largest 1, (body, motion).
      real(dp), allocatable :: rigid(:, :)
      !> 'shaft 1', 'mesh 1', ...: the elastic elements in the order of the case, (element).
      character(20), allocatable :: element(:)
      !> Names of the two bodies that an element joins, 'pinion - wheel'; in a chain as `element`, (element).
      character(label_length), allocatable :: element_label(:)
      !> What the values of a state are: 'mesh 1' the displacement of this element, 'rate of mesh 1' its velocity, (state).
      character(28), allocatable :: state(:)
      !> Names of the bodies, (body).
      character(label_length), allocatable :: body(:)
      !> With planetary sets 'torsional': the planets of each set move alike; 'planets of stage 1': sun, ring and carrier stand
      !> still; else 'mixed', (mode).
      character(label_length), allocatable :: kind(:)
   end type modes_type

contains

   !> Computes the modes of a train.
   subroutine natural_modes(train, modes, error)
      type(train_type), intent(in) :: train
      type(modes_type), intent(out) :: modes
      type(error_type), allocatable, intent(out) :: error
      type(system_type) :: system
      integer :: info

      call check_train(train, error)
      if (allocated(error)) return
      call build_system(train, system)
      call undamped(system, modes, info)
      if (system%interrupt%raised()) then
         call fatal(error, 'natural modes: interrupted', status_ended_early)
         return
      end if
      if (info == 0) call damped(system, modes, info)
      if (info /= 0) call fatal(error, 'natural modes: LAPACK did not converge', status_ended_early)
      call name_elements(train, system, modes)
      if (info == 0) call find_kinds(train, modes)
   end subroutine natural_modes

   subroutine name_elements(train, system, modes)
      type(train_type), intent(in) :: train
      type(system_type), intent(in) :: system
      type(modes_type), intent(inout) :: modes
      character(label_length) :: shafts(size(train%shafts)), meshes(size(train%meshes))
      character(len(modes%element)) :: names(system%elements)
      integer, allocatable :: shown(:)
      integer :: body, i

      shafts = shaft_labels(train)
      meshes = mesh_labels(train)
      modes%body = body_labels(train)
      shown = elastic(system)
      allocate (modes%element_label(size(shown)))
      do i = 1, system%elements
         associate (shaft => system%element_shaft(i), mesh => system%element_mesh(i))
            if (mesh > 0) then
               names(i) = mesh_word(train%meshes, mesh)
            else if (shaft > 0) then
               write (names(i), '(a, i0)') 'shaft ', shaft
            else
               write (names(i), '(a, i0)') 'ground ', grounded(i)
            end if
         end associate
      end do
      do i = 1, size(shown)
         associate (shaft => system%element_shaft(shown(i)), mesh => system%element_mesh(shown(i)))
            if (mesh > 0) then
               modes%element_label(i) = meshes(mesh)
            else if (shaft > 0) then
               modes%element_label(i) = shafts(shaft)
            else
               body = grounded(shown(i))
               modes%element_label(i) = trim(modes%body(body))//' - ground'
            end if
         end associate
      end do
      modes%element = names(shown)
      allocate (modes%state(system%states))
      do i = 1, system%displacements
         modes%state(i) = names(i)
      end do
      do i = 1, system%coordinates
         modes%state(system%displacements + i) = 'rate of '//names(i)
      end do

   contains

      !> Number of the body that an element joins with ground.
      pure integer function grounded(element)
         integer, intent(in) :: element

         grounded = findloc(system%network%node, system%network%elements(element)%node(1), 1)
      end function grounded

   end subroutine name_elements

   !> Sets the kinds of the modes of a train with planetary sets.
   subroutine find_kinds(train, modes)
      type(train_type), intent(in) :: train
      type(modes_type), intent(inout) :: modes
      type(train_type) :: plain
      type(planetary_set_type), allocatable :: sets(:)
      character(:), allocatable :: names
      logical :: mixed
      integer :: i, j

      call plain_train(train, plain)
      if (.not. any(plain%meshes%carrier /= '')) return
      call find_sets(plain, sets)
      if (size(sets) == 0) return
      allocate (modes%kind(size(modes%natural_frequency)))
      do i = 1, size(modes%kind)
         names = ''
         mixed = .false.
         do j = 1, size(sets)
            associate (planets => modes%rotation(sets(j)%planets, i), &
                       members => pack([sets(j)%sun, sets(j)%ring, sets(j)%carrier], &
                                       [sets(j)%sun, sets(j)%ring, sets(j)%carrier] > 0))
               if (maxval(planets) - minval(planets) <= still) cycle
               mixed = mixed .or. maxval(abs(modes%rotation(members, i))) > still .or. abs(sum(planets)) > still*size(planets)
               names = names//', '//trim(sets(j)%name)
            end associate
         end do
         if (mixed) then
            modes%kind(i) = 'mixed'
         else if (names == '') then
            modes%kind(i) = 'torsional'
         else
            ! Of several equal sets the modes of one frequency are any mixture.
            modes%kind(i) = 'planets of '//names(3:)
         end if
      end do
   end subroutine find_kinds

   !> Numbers of the elastic elements in the order of the case: shaft 1, mesh 1, shaft 2, ...
   pure function elastic(system) result(shown)
      type(system_type), intent(in) :: system
      integer, allocatable :: shown(:), place(:)
      integer :: n

      shown = pack([(n, n=1, system%elements)], system%spring > 0)
      place = max(2*system%element_shaft(shown) - 1, 2*system%element_mesh(shown))
      where (place < 0) place = huge(place)
      shown = shown(ascending(place*1.0_dp))
   end function elastic

   !> Ranges that hold all natural frequencies: the lowest and the highest one of each range over characteristic frequency [1], (2,
   !> range). Within a range each natural frequency is at most `ratio` times the next lower one.
   pure function natural_frequency_ranges(system, ratio) result(ranges)
      type(system_type), intent(in) :: system
      !> Ratio > 1 [1].
      real(dp), intent(in) :: ratio
      real(dp), allocatable :: ranges(:, :)

      ranges = sqrt(eigenvalue_ranges(system, stiffness_at_rest(system), ratio**2))
   end function natural_frequency_ranges

   subroutine undamped(system, modes, info)
      type(system_type), intent(in) :: system
      type(modes_type), intent(inout) :: modes
      integer, intent(out) :: info
      real(dp) :: square(system%displacements), force(system%elements), turn
      integer :: i

      associate (nodes => system%network%node, modes_there => system%displacements)
         allocate (modes%shape(system%elements, modes_there), modes%energy(system%elements, modes_there))
         allocate (modes%rotation(size(nodes), modes_there))
         allocate (modes%rigid(size(nodes), size(system%network%rigid, 2)), source=0.0_dp)
         do i = 1, size(nodes)
            if (nodes(i) > 0) modes%rigid(i, :) = system%network%rigid(nodes(i), :)
         end do
         do i = 1, size(modes%rigid, 2)
            modes%rigid(:, i) = modes%rigid(:, i)/maxval(abs(modes%rigid(:, i)))
         end do
      end associate
      call eigenvalues_of(system, stiffness_at_rest(system), square, info, modes%shape)
      if (info /= 0) return
      modes%natural_frequency = sqrt(max(square, 0.0_dp))
      do i = 1, system%displacements
         modes%shape(:, i) = modes%shape(:, i) &
                             /sqrt(system%stiffness*merge(stiffness_at_rest(system), 1.0_dp, system%spring > 0))
         modes%shape(:, i) = modes%shape(:, i)/modes%shape(maxloc(abs(modes%shape(:, i)), 1), i)
         force = system%stiffness*stiffness_at_rest(system)*modes%shape(:, i)
         call find_rotations(system%network, force, modes%rotation(:, i), turn)
         ! Rotations are B^T k p/(I omega^2).
         modes%energy(:, i) = force*modes%shape(:, i)*(square(i)*system%characteristic_frequency**2/turn)**2
      end do
      modes%shape = modes%shape(elastic(system), :)
      modes%energy = modes%energy(elastic(system), :)
   end subroutine undamped

   !> Finds the rotations of the bodies from the elastic forces, in proportion to the inertia forces: the rigid motions are left
   !> out.
   pure subroutine find_rotations(network, force, rotation, largest)
      type(network_type), intent(in) :: network
      !> Force of each element, (element).
      real(dp), intent(in) :: force(:)
      !> Rotation of each body, largest 1, or 0 of a motion of bearings alone, (body); what it was divided by [rad/s^2], or of such
      !> a motion the largest displacement [m/s^2].
      real(dp), intent(out) :: rotation(:), largest
      real(dp) :: theta(0:size(network%inertia))
      real(dp), allocatable :: moving(:)
      integer :: n

      theta = 0
      do n = 1, size(network%elements)
         associate (element => network%elements(n))
            theta(element%node) = theta(element%node) + element%entry*force(n)/network%inertia(element%node)
         end associate
      end do
      associate (moves => pack(network%moves, network%moves > 0))
         moving = theta(moves)
         theta(moves) = 0
      end associate
      largest = maxval(abs(theta))
      if (largest <= still*maxval([0.0_dp, abs(moving)])) then
         theta = 0
         largest = maxval(abs(moving))
      end if
      theta = theta/largest
      rotation = theta(network%node)
   end subroutine find_rotations

   !> Stiffness of each element at rest over its mean stiffness [1], (element): 1 except on back flanks of another stiffness; 0 of
   !> damping to ground.
   pure function stiffness_at_rest(system) result(stiffness)
      type(system_type), intent(in) :: system
      real(dp) :: stiffness(system%elements)
      integer :: j

      stiffness = system%spring
      do j = 1, system%meshes
         associate (n => system%mesh_element(j), law => system%law(j))
            stiffness(n) = law%stiffness(law%bearing(system%static_force(n)))
         end associate
      end do
   end function stiffness_at_rest

   !> Matrix of the mean system at rest, (state, state): the time derivative of a small difference of states is the matrix times the
   !> difference. p'' + W Gamma p' + W K p = 0, K the stiffness at rest.
   pure function state_matrix(system) result(matrix)
      type(system_type), intent(in) :: system
      real(dp) :: matrix(system%states, system%states)
      real(dp) :: a(2*system%coordinates, 2*system%coordinates), stiffness(system%elements)
      integer :: kept(system%states), n, i, j

      n = system%coordinates
      stiffness = stiffness_at_rest(system)
      a = 0
      do i = 1, n
         a(i, n + i) = 1
         a(n + i, i) = -system%own(i)*stiffness(i)
         a(n + i, n + i) = -system%own(i)*system%damping(i)
         do j = system%first(i), system%first(i + 1) - 1
            associate (m => system%neighbour(j))
               if (m <= n) then
                  a(n + i, m) = a(n + i, m) - system%coupling(j)*stiffness(m)
                  a(n + i, n + m) = a(n + i, n + m) - system%coupling(j)*system%damping(m)
               else
                  associate (loop => system%network%loop(m - n, :))
                     a(n + i, :n) = a(n + i, :n) - system%coupling(j)*stiffness(m)*loop
                     a(n + i, n + 1:) = a(n + i, n + 1:) - system%coupling(j)*system%damping(m)*loop
                  end associate
               end if
            end associate
         end do
      end do
      kept = [(i, i=1, system%displacements), (n + i, i=1, n)]
      matrix = a(kept, kept)
   end function state_matrix

   !> Eigenvalues of the mean system at rest; each mode gets the eigenvalue of the nearest magnitude.
   !> With damping to ground the smallest real eigenvalue is the rate at which the whole train comes to rest: it is no mode.
   subroutine damped(system, modes, info)
      type(system_type), intent(in) :: system
      type(modes_type), intent(inout) :: modes
      integer, intent(out) :: info
      real(dp), allocatable :: a(:, :), wr(:), wi(:), work(:), empty(:, :)
      logical, allocatable :: taken(:)
      integer :: n, i, best, states

      states = system%states
      allocate (a(states, states), wr(states), wi(states), work(16*system%coordinates), empty(1, 1))
      a = state_matrix(system)
      call dgeev('N', 'N', states, a, states, wr, wi, empty, 1, empty, 1, work, size(work), info)
      n = system%displacements
      allocate (modes%damped_frequency(n), modes%damping_ratio(n))
      taken = wi < 0
      do i = n + 1, system%coordinates
         taken(minloc(abs(wr), 1, .not. (abs(wi) > 0 .or. taken))) = .true.
      end do
      do i = 1, n
         best = minloc(abs(hypot(wr, wi) - modes%natural_frequency(i)), 1, .not. taken)
         taken(best) = .true.
         modes%damped_frequency(i) = abs(wi(best))
         modes%damping_ratio(i) = -wr(best)/hypot(wr(best), wi(best))
      end do
   end subroutine damped

end module geartrain_network_natural_modes
