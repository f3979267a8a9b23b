!> Damping coefficients of shafts and meshes by their loss factors, and by damping ratios of the modes.
!>
!> Every damper stands in a shaft or a mesh, as its spring does. With the natural frequencies omega_i of the undamped train at rest
!> and the share S_ni that element n has of the strain energy of mode i, the damping ratios of the modes are
!>     zeta_i = sum over n of S_ni omega_i c_n/(2 k_n),
!> the diagonal of the modal damping matrix over 2 omega_i. It is linear in the coefficients c_n. The other entries of this matrix
!> couple the modes; they change the ratios in second order, where natural frequencies are further apart than a ratio times them.
!>
!> A loss factor eta takes pi eta k X^2 out of a cycle of amplitude X at every frequency, a damper pi c omega X^2. They are
!> equivalent at one frequency, c = eta k/omega (Rao, Mechanical Vibrations, hysteretic damping): here the natural frequency of the
!> mode in which the element has its largest share.
!>
!> Ratios of the modes are met by c_n >= 0 of the elements without damping of their own, with the least sum of squares of the
!> relative errors of the ratios. A chain has as many elements as modes: where the solution of the linear equations is not negative,
!> the ratios are met exactly.
module geartrain_network_modal_damping
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_band_eigenvalues, only: band_eigenvalues
   use geartrain_linalg_non_negative, only: non_negative_least_squares
   use geartrain_mesh_law_law, only: law_type
   use geartrain_train_mesh, only: coupling_radius, is_given, put_law
   use geartrain_network_elements, only: element_type
   use geartrain_network_network, only: build_network, network_type
   use geartrain_network_rest, only: rest_forces
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: asked_ratios, damps_by_modes, find_modal_damping, modal_damping_type, modes_of_loss_factors, resolve_damping

   !> Natural frequencies that differ by less than this share are equal: their mode shapes are arbitrary, the mean of these is not.
   real(dp), parameter :: equal_frequencies = 1e-6_dp
   !> Differences of shares, and of effects of elements on the modes over their size, that are rounding.
   real(dp), parameter :: rounding = 1e-9_dp
   !> Weight of the coefficients themselves in the least squares, relative: of elements between which the modes do not decide it
   !> makes equal ones equal.
   real(dp), parameter :: weight_of_size = 1e-7_dp

   type :: modal_damping_type
      !> Natural frequencies [rad/s], ascending, and damping ratios by the diagonal of the modal damping matrix [1], (mode).
      real(dp), allocatable :: frequency(:), ratio(:)
      !> Share of each element in the strain energy of each mode [1], (element, mode); the mean of modes of equal frequency.
      real(dp), allocatable :: share(:, :)
      !> Stiffness at rest [N/m] and damping [N s/m] along the line of action; base radius of a shaft [m], (element).
      real(dp), allocatable :: stiffness(:), damping(:), radius(:)
      !> Number of the shaft or of the mesh in the train, else 0, (element).
      integer, allocatable :: shaft(:), mesh(:)
      !> Mode in which the element has its largest share, the lowest of equal ones, (element).
      integer, allocatable :: mode(:)
   end type modal_damping_type

contains

   !> Whether a train has damping that follows from its modes.
   pure logical function damps_by_modes(train)
      !> The train as described.
      type(train_type), intent(in) :: train

      damps_by_modes = is_given(train%modal_damping)
      if (allocated(train%shafts)) damps_by_modes = damps_by_modes .or. any(train%shafts%loss_factor > 0)
      if (allocated(train%meshes)) damps_by_modes = damps_by_modes .or. any(train%meshes%loss_factor > 0)
   end function damps_by_modes

   !> Ratios that `modal_damping` asks for: its last value holds for all higher modes.
   pure function asked_ratios(train, modes) result(asked)
      !> A train with `modal_damping`.
      type(train_type), intent(in) :: train
      !> Number of modes.
      integer, intent(in) :: modes
      real(dp) :: asked(modes)
      integer :: i

      asked = [(train%modal_damping(min(i, size(train%modal_damping))), i=1, modes)]
   end function asked_ratios

   !> Gives shafts and meshes the damping coefficients that follow from loss factors and from damping ratios of the modes.
   pure subroutine resolve_damping(train)
      !> A plain train (geartrain_drawing_drawing) with mesh stiffnesses for its loads; left as it is without such damping.
      type(train_type), intent(inout) :: train
      type(modal_damping_type) :: found
      real(dp), allocatable :: asked(:)
      logical, allocatable :: free(:)
      real(dp), allocatable :: eta(:)
      integer :: n

      if (.not. damps_by_modes(train)) return
      call find_modal_damping(train, found)
      free = .not. found%damping > 0 .and. found%shaft + found%mesh > 0
      eta = loss_factors(train, found)
      do n = 1, size(found%damping)
         if (.not. eta(n) > 0) cycle
         free(n) = .false.
         found%damping(n) = eta(n)*found%stiffness(n)/found%frequency(found%mode(n))
         found%ratio = found%ratio + ratios_by(found, n)
      end do
      if (is_given(train%modal_damping)) then
         asked = asked_ratios(train, size(found%frequency))
         if (any(asked > 0) .and. any(free)) call fit(found, asked, free)
      end if
      do n = 1, size(found%damping)
         if (found%shaft(n) > 0) then
            associate (shaft => train%shafts(found%shaft(n)))
               shaft%damping = found%damping(n)*found%radius(n)**2
               shaft%damping_given = .true.
               shaft%loss_factor = 0
            end associate
         else if (found%mesh(n) > 0) then
            associate (mesh => train%meshes(found%mesh(n)))
               mesh%damping = found%damping(n)
               mesh%torsional_damping = found%damping(n)*coupling_radius**2
               mesh%damping_given = .true.
               mesh%loss_factor = 0
            end associate
         end if
      end do
      if (allocated(train%modal_damping)) deallocate (train%modal_damping)
   end subroutine resolve_damping

   !> Loss factor of each element [1], (element); 0: not given.
   pure function loss_factors(train, found) result(eta)
      type(train_type), intent(in) :: train
      type(modal_damping_type), intent(in) :: found
      real(dp) :: eta(size(found%damping))
      integer :: n

      do n = 1, size(eta)
         if (found%shaft(n) > 0) then
            eta(n) = train%shafts(found%shaft(n))%loss_factor
         else
            eta(n) = train%meshes(found%mesh(n))%loss_factor
         end if
      end do
   end function loss_factors

   !> Modes at which the loss factors of a train are equivalent to dampers, (element); 0: no loss factor; empty: none at all.
   pure function modes_of_loss_factors(train) result(mode)
      !> A plain train (geartrain_drawing_drawing) with mesh stiffnesses for its loads, before `resolve_damping`.
      type(train_type), intent(in) :: train
      integer, allocatable :: mode(:)
      type(modal_damping_type) :: found

      allocate (mode(0))
      if (.not. (any(train%shafts%loss_factor > 0) .or. any(train%meshes%loss_factor > 0))) return
      call find_modal_damping(train, found)
      mode = merge(found%mode, 0, loss_factors(train, found) > 0)
   end function modes_of_loss_factors

   !> Finds the modes of a train, without regard to loss factors and damping ratios of modes.
   pure subroutine find_modal_damping(train, found)
      !> A plain train (geartrain_drawing_drawing) with mesh stiffnesses for its loads.
      type(train_type), intent(in) :: train
      !> Modes and damping.
      type(modal_damping_type), intent(out) :: found
      type(network_type) :: network
      type(element_type), allocatable :: elements(:)
      type(law_type) :: law(size(train%meshes))
      real(dp), allocatable :: force(:), vector(:, :)
      integer, allocatable :: elastic(:)
      real(dp) :: residual
      integer :: i, j, n, modes

      call build_network(train, network)
      do j = 1, size(law)
         call put_law(train%meshes(j), train%characteristic_length, law(j))
      end do
      allocate (force(size(network%elements)))
      call rest_forces(network, law, train%characteristic_length, force, residual)
      elastic = pack([(n, n=1, size(force))], network%elements%elastic)
      force = force(elastic)
      elements = network%elements(elastic)
      found%stiffness = elements%stiffness
      found%damping = elements%damping
      found%radius = elements%radius
      found%shaft = elements%shaft
      found%mesh = elements%mesh
      do n = 1, size(elements)
         j = elements(n)%mesh
         if (j > 0) found%stiffness(n) = elements(n)%stiffness &
                                         *law(j)%stiffness(law(j)%bearing(force(n)/(elements(n)%stiffness &
                                                                                        *train%characteristic_length)))
      end do
      modes = network%displacements
      call find_modes(network, elements, found, modes, vector)
      found%share = vector**2
      found%ratio = [(sum(found%share(:, i)*found%damping/found%stiffness)*found%frequency(i)/2, i=1, modes)]
      call add_ground(network, elements, vector, found)
      call average(found)
      found%mode = [(findloc(found%share(n, :) >= maxval(found%share(n, :)) - rounding, .true., 1), n=1, size(elements))]
   end subroutine find_modal_damping

   !> B_n I^-1 B_m [1/kg] of two elements.
   pure real(dp) function coupling(network, a, b)
      type(network_type), intent(in) :: network
      type(element_type), intent(in) :: a, b

      integer :: i

      coupling = sum([(a%entry(i)*b%entry_at(a%node(i))/network%inertia(a%node(i)), i=1, size(a%node))])
   end function coupling

   !> Finds the natural frequencies, and the eigenvectors of sqrt(K) B I^-1 B' sqrt(K): squares of their values are shares of the
   !> strain energy. Each element that closes a loop adds an eigenvalue 0.
   pure subroutine find_modes(network, elements, found, modes, vector)
      type(network_type), intent(in) :: network
      type(element_type), intent(in) :: elements(:)
      type(modal_damping_type), intent(inout) :: found
      integer, intent(in) :: modes
      real(dp), allocatable, intent(out) :: vector(:, :)
      real(dp), allocatable :: band(:, :), value(:), all_vectors(:, :)
      integer :: i, j, n, info

      n = size(elements)
      allocate (band(n, n), value(n), all_vectors(n, n))
      band = 0
      do j = 1, n
         do i = 1, j
            band(n + i - j, j) = coupling(network, elements(i), elements(j))*sqrt(found%stiffness(i)*found%stiffness(j))
         end do
      end do
      call band_eigenvalues(band, value, info, all_vectors)
      found%frequency = sqrt(max(value(n - modes + 1:), tiny(1.0_dp)))
      vector = all_vectors(:, n - modes + 1:)
   end subroutine find_modes

   !> Adds damping to ground to the ratios.
   pure subroutine add_ground(network, elements, vector, found)
      type(network_type), intent(in) :: network
      type(element_type), intent(in) :: elements(:)
      real(dp), intent(in) :: vector(:, :)
      type(modal_damping_type), intent(inout) :: found
      real(dp) :: rotation
      integer :: i, n, node

      do node = 1, size(network%damping)
         if (.not. network%damping(node) > 0) cycle
         do i = 1, size(found%frequency)
            rotation = sum([(elements(n)%entry_at(node)*sqrt(found%stiffness(n))*vector(n, i), n=1, size(elements))]) &
                       /(network%inertia(node)*found%frequency(i))
            found%ratio(i) = found%ratio(i) + network%damping(node)*rotation**2/(2*found%frequency(i))
         end do
      end do
   end subroutine add_ground

   !> Gives modes of equal frequency the mean of their shares and ratios.
   pure subroutine average(found)
      type(modal_damping_type), intent(inout) :: found
      integer :: first, last, modes, n

      modes = size(found%frequency)
      first = 1
      do while (first <= modes)
         last = first
         do while (last < modes)
            if (found%frequency(last + 1) > found%frequency(last)*(1 + equal_frequencies)) exit
            last = last + 1
         end do
         if (last > first) then
            found%ratio(first:last) = sum(found%ratio(first:last))/(last - first + 1)
            do n = 1, size(found%share, 1)
               found%share(n, first:last) = sum(found%share(n, first:last))/(last - first + 1)
            end do
         end if
         first = last + 1
      end do
   end subroutine average

   !> Damping ratios of all modes by the damping of one element.
   pure function ratios_by(found, n) result(ratio)
      type(modal_damping_type), intent(in) :: found
      integer, intent(in) :: n
      real(dp) :: ratio(size(found%frequency))

      ratio = found%share(n, :)*found%frequency*found%damping(n)/(2*found%stiffness(n))
   end function ratios_by

   !> Gives the free elements the damping with which the ratios come nearest to the ratios asked for.
   pure subroutine fit(found, asked, free)
      type(modal_damping_type), intent(inout) :: found
      !> Ratios asked for [1], some > 0, (mode).
      real(dp), intent(in) :: asked(:)
      !> Elements without damping of their own, (element).
      logical, intent(in) :: free(:)
      real(dp), dimension(size(asked)) :: scale, column
      real(dp) :: columns(size(asked), count(free)), members(count(free)), size_of(count(free))
      real(dp), allocatable :: a(:, :), b(:), x(:)
      integer :: group(size(free)), groups, i, n

      ! The error of a mode without damping is relative to the largest ratio.
      scale = merge(asked, maxval(asked), asked > 0)
      groups = 0
      group = 0
      members = 0
      do n = 1, size(free)
         if (.not. free(n)) cycle
         column = found%share(n, :)*found%frequency/scale
         if (.not. norm2(column) > 0) cycle
         ! Elements of equal effect on all modes, as of equal branches, get equal damping.
         do i = 1, groups
            if (norm2(column - columns(:, i)) <= rounding*norm2(column)) exit
         end do
         if (i > groups) then
            groups = i
            columns(:, i) = column
            size_of(i) = norm2(column)
         end if
         group(n) = i
         members(i) = members(i) + 1
      end do
      allocate (a(size(asked) + groups, groups), b(size(asked) + groups), x(groups))
      a = 0
      b = 0
      b(:size(asked)) = (asked - found%ratio)/scale
      do i = 1, groups
         a(:size(asked), i) = columns(:, i)/size_of(i)
         a(size(asked) + i, i) = weight_of_size
      end do
      call non_negative_least_squares(a, b, x)
      do n = 1, size(free)
         i = group(n)
         if (i == 0) cycle
         found%damping(n) = 2*found%stiffness(n)*x(i)/(size_of(i)*members(i))
         found%ratio = found%ratio + ratios_by(found, n)
      end do
   end subroutine fit

end module geartrain_network_modal_damping
