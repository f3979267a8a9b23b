!> Limits of the scales of a train: of its frequencies relative to the characteristic frequency, of its displacements relative to
!> the characteristic length and to each other. Beyond these limits a number overflows or is lost in rounding.
module geartrain_network_scales
   use geartrain_base_checker, only: checker_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text, real_text, text
   use geartrain_network_limits, only: in_order
   use geartrain_train_bodies, only: bodies_of, body_count, find_ends
   use geartrain_train_gear_error, only: gear_words
   use geartrain_train_mesh, only: mesh_type
   use geartrain_train_mesh_groups, only: enter_mesh, group_name, group_number, mesh_word
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: check_scales

   !> Largest ratio between the characteristic frequency and the frequency of the slowest mesh [decades]: a step of the flow has the
   !> powers of this ratio up to 20.
   real(dp), parameter :: off_unit = 9
   !> Largest ratio between the largest displacement and the characteristic length [decades]: its square does not overflow.
   real(dp), parameter :: most_lengths = 20
   !> Ratio of two displacements beyond which the smaller displacement is lost in the rounding of the larger [decades].
   real(dp), parameter :: lost = 12
   !> Largest amplitude of kappa [1]: the growth rate of the motion of an unstable train is proportional to its root.
   real(dp), parameter :: most_variation = 1e3_dp
   !> Value for the logarithm of 0 [decades].
   real(dp), parameter :: none = -1e4_dp

contains

   !> Adds a problem where values of a train, each in its range, give together a scale beyond the limits. All by logarithms, which
   !> do not overflow for any values and any number of meshes.
   subroutine check_scales(train, own, derived, checker)
      !> The plain train.
      type(train_type), intent(in) :: train
      !> Frequency of its slowest mesh [rad/s].
      real(dp), intent(in) :: own
      !> Whether the characteristic frequency follows from the common period of all teeth at 1 rpm, because it is not given.
      logical, intent(in) :: derived
      class(checker_type), intent(inout) :: checker
      real(dp) :: static, unit, largest
      !> Logarithms of the reduced radius and of the force by the mean torque at this radius, (body); of the displacement of each
      !> mesh per force, (mesh) [decades].
      real(dp) :: radius(body_count(train)), force(body_count(train)), compliance(size(train%meshes))
      integer :: b, gear, j, before, strongest

      if (.not. in_order(train, checker)) return
      before = checker%problems%count
      call checker%enter('train', 1)
      if (abs(log10(own) - log10(train%characteristic_frequency)) > off_unit) then
         if (derived) then
            call checker%lacks('characteristic_frequency', '> 0 rad/s', ': the common period of all teeth at 1 rpm gives '// &
               text(train%characteristic_frequency)//' rad/s, and it must be within a factor of 1e9 of the frequency of the &
               &slowest mesh, '//text(own)//' rad/s. Give 1.0, and speeds with unit = ''rpm''')
         else
            call checker%complain('characteristic_frequency', real_text(train%characteristic_frequency), 'must be within a factor &
               &of 1e9 of the frequency of the slowest mesh, '//text(own)//' rad/s by its stiffness, radii and inertias')
         end if
      end if
      call checker%leave()
      unit = decades(train%characteristic_length)
      largest = none
      call find_scales(train, radius, force, compliance)
      strongest = maxloc(force, 1)
      do j = 1, size(train%meshes)
         associate (mesh => train%meshes(j))
            call check_torque(j, force(strongest) + compliance(j))
            call check_list('mesh', j, 'error_cos', mesh%error_cos, 0.0_dp, 'it')
            call check_list('mesh', j, 'error_sin', mesh%error_sin, 0.0_dp, 'it')
            do gear = 1, 2
               associate (error => mesh%gear_error(gear))
                  call check_list('mesh', j, trim(gear_words(gear))//'_error_cos', error%cosine, 0.0_dp, 'it')
                  call check_list('mesh', j, trim(gear_words(gear))//'_error_sin', error%sine, 0.0_dp, 'it')
               end associate
            end do
            call check_length('mesh', j, 'error_mean', mesh%error_mean, decades(mesh%error_mean), 'it')
            call check_length(trim(group_name(train%meshes, j)), group_number(train%meshes, j), trim(gap_name(mesh)), &
                              mesh%half_backlash, decades(mesh%half_backlash), 'it')
            call check_variation(j, 'stiffness_cos', mesh%stiffness_cos)
            call check_variation(j, 'stiffness_sin', mesh%stiffness_sin)
         end associate
      end do
      if (allocated(train%bodies)) then
         do b = 1, size(train%bodies)
            associate (body => train%bodies(b), gain => maxval(compliance) - radius(b))
               call check_list('body', b, 'torque_cos', body%torque_cos, gain, 'the deflection of a mesh by it')
               call check_list('body', b, 'torque_sin', body%torque_sin, gain, 'the deflection of a mesh by it')
               call check_list('body', b, 'revolution_torque_cos', body%revolution_torque_cos, gain, &
                               'the deflection of a mesh by it')
               call check_list('body', b, 'revolution_torque_sin', body%revolution_torque_sin, gain, &
                               'the deflection of a mesh by it')
            end associate
         end do
      else
         call check_list('train', 1, 'torque_cos', train%torque_cos, compliance(1), 'the deflection of &mesh 1 (by it, &
                         &driving_radius and stiffness)')
         call check_list('train', 1, 'torque_sin', train%torque_sin, compliance(1), 'the deflection of &mesh 1 (by it, &
                         &driving_radius and stiffness)')
      end if
      if (largest > none/2 .and. largest < unit - most_lengths) then
         call checker%enter('train', 1)
         call checker%complain('characteristic_length', real_text(train%characteristic_length), 'must be smaller: the largest &
            &displacement given (half_backlash, the static deflection, an error or that by a torque amplitude) is only '// &
            power(largest)//' m')
         call checker%leave()
      end if
      if (checker%problems%count == before) call check_rounding()

   contains

      !> Checks the static deflection of mesh j [decades of m].
      subroutine check_torque(j, static)
         integer, intent(in) :: j
         real(dp), intent(in) :: static
         character(:), allocatable :: what

         what = 'the static deflection of &'//trim(mesh_word(train%meshes, j))//' (by it, the radii up to there and the stiffness)'
         if (allocated(train%bodies)) then
            call check_length('body', strongest, 'torque', train%bodies(strongest)%torque, static, what)
         else
            call check_length('train', 1, 'input_torque', train%input_torque, static, what)
         end if
      end subroutine check_torque

      !> Checks a displacement `length` [decades of m] that a value causes.
      subroutine check_length(group, index, name, value, length, what)
         character(*), intent(in) :: group, name, what
         integer, intent(in) :: index
         real(dp), intent(in) :: value, length

         largest = max(largest, length)
         if (length <= unit + most_lengths) return
         call checker%enter(group, index)
         call checker%complain(name, real_text(value), 'must be smaller, or characteristic_length larger: '//what//' is '// &
                               power(length - unit)//' times characteristic_length, at most '//power(most_lengths)//' is allowed')
         call checker%leave()
      end subroutine check_length

      subroutine check_list(group, index, name, values, factor, what)
         character(*), intent(in) :: group, name, what
         integer, intent(in) :: index
         real(dp), allocatable, intent(in) :: values(:)
         !> Displacement per value [decades].
         real(dp), intent(in) :: factor
         integer :: i

         if (.not. allocated(values)) return
         do i = 1, size(values)
            call check_length(group, index, name, values(i), decades(values(i)) + factor, what)
         end do
      end subroutine check_list

      subroutine check_variation(index, name, values)
         integer, intent(in) :: index
         character(*), intent(in) :: name
         real(dp), allocatable, intent(in) :: values(:)
         integer :: i

         if (.not. allocated(values)) return
         i = findloc(abs(values) > most_variation, .true., dim=1)
         if (i == 0) return
         call checker%enter('mesh', index)
         call checker%complain(name, real_text(values(i)), 'must be of a magnitude <= '//text(most_variation)// &
                               ': it is a share of the mean stiffness', i)
         call checker%leave()
      end subroutine check_variation

      !> Adds a problem where the gap or the static deflection of a mesh is lost beside the other.
      subroutine check_rounding()
         real(dp) :: gap
         character(12) :: torque_name

         torque_name = merge('the torques ', 'input_torque', allocated(train%bodies))
         do j = 1, size(train%meshes)
            associate (mesh => train%meshes(j))
               static = force(strongest) + compliance(j)
               gap = decades(mesh%half_backlash)
               if (min(gap, static) < none/2) cycle
               if (static < gap - lost) then
                  if (allocated(train%bodies)) then
                     call checker%enter('body', strongest)
                     call checker%complain('torque', real_text(train%bodies(strongest)%torque), trim(lost_beside(j)))
                  else
                     call checker%enter('train', 1)
                     call checker%complain('input_torque', real_text(train%input_torque), trim(lost_beside(j)))
                  end if
               else if (gap < static - lost) then
                  call enter_mesh(checker, train%meshes, j)
                  call checker%complain(trim(gap_name(mesh)), real_text(mesh%half_backlash), 'must be 0 or larger: it is &
                     &lost in rounding beside the static deflection (by '//trim(torque_name)//', the radii up to there and the &
                     &stiffness), '// &
                     power(static)//' m')
               end if
            end associate
            call checker%leave()
         end do
      end subroutine check_rounding

      pure function lost_beside(j) result(words)
         integer, intent(in) :: j
         character(200) :: words

         words = 'must be 0 or larger: the static deflection of &'//trim(mesh_word(train%meshes, j))//' (by it, the radii up to &
                 &there and the stiffness), '//power(static)//' m, is lost in rounding beside its '// &
                 gap_name(train%meshes(j))
      end function lost_beside

   end subroutine check_scales

   !> Variable of the gap of a mesh.
   pure function gap_name(mesh) result(name)
      type(mesh_type), intent(in) :: mesh
      character(14) :: name

      name = merge('half_play    ', 'half_backlash', mesh%is_coupling)
      if (mesh%axis > 0) name = 'half_clearance'
   end function gap_name

   !> Sets the logarithms of `check_scales` [decades].
   subroutine find_scales(train, radius, force, compliance)
      type(train_type), intent(in) :: train
      real(dp), intent(out) :: radius(:), force(:), compliance(:)
      real(dp) :: inertia(size(radius)), torque(size(radius))
      logical :: known(size(radius)), changed
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      integer, allocatable :: balancing(:)
      integer :: i, k

      call find_ends(train, shaft_ends, mesh_ends)
      known = .false.
      known(1) = .true.
      radius = 0
      changed = .true.
      do while (changed)
         changed = .false.
         do i = 1, max(size(train%shafts), size(train%meshes))
            if (i <= size(train%shafts)) call hand_on(shaft_ends(:, i), 0.0_dp)
            if (i <= size(train%meshes)) call hand_on(mesh_ends(:, i), decades(train%meshes(i)%driven_radius) &
                                                                             - decades(train%meshes(i)%driving_radius))
         end do
      end do
      call bodies_of(train, inertia, torque, balancing)
      force = decades(torque) - radius
      force(balancing) = none
      do i = 1, size(compliance)
         associate (mesh => train%meshes(i), ends => mesh_ends(:, i))
            ! A bearing bears the force of a mesh of its body.
            k = i
            if (mesh%axis > 0) k = findloc(mesh_ends(1, :i - 1) == ends(1) .or. mesh_ends(2, :i - 1) == ends(1), .true., 1)
            compliance(i) = radius(mesh_ends(1, max(1, k))) - decades(train%meshes(max(1, k))%driving_radius) &
                            - decades(mesh%stiffness)
         end associate
      end do

   contains

      subroutine hand_on(ends, ratio)
         integer, intent(in) :: ends(2)
         real(dp), intent(in) :: ratio

         if (known(ends(1)) .eqv. known(ends(2))) return
         if (known(ends(1))) radius(ends(2)) = radius(ends(1)) + ratio
         if (known(ends(2))) radius(ends(1)) = radius(ends(2)) - ratio
         known(ends) = .true.
         changed = .true.
      end subroutine hand_on

   end subroutine find_scales

   !> Logarithm of a magnitude [decades]; `none` for 0.
   elemental real(dp) function decades(value)
      real(dp), intent(in) :: value

      decades = none
      if (abs(value) > 0) decades = log10(abs(value))
   end function decades

   !> A power of ten in words, by its rounded exponent: '1e305'.
   pure function power(exponent) result(text)
      real(dp), intent(in) :: exponent
      character(2 + len(integer_text(nint(exponent)))) :: text

      text = '1e'//integer_text(nint(exponent))
   end function power

end module geartrain_network_scales
