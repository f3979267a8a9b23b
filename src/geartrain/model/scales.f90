!> How far apart the scales of a train may lie: its frequencies from the characteristic one, its displacements from the
!> characteristic length and from one another. What lies beyond is no number any more, or lost in rounding.
module geartrain_model_scales
   use geartrain_base_checker, only: checker_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text, real_text, text
   use geartrain_model_limits, only: in_order, own_frequency
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: check_scales

   !> Largest ratio of the characteristic frequency to that of the slowest mesh, either way [decades]: a step of the flow has its
   !> powers up to 20.
   real(dp), parameter :: off_unit = 7
   !> The largest displacement lies within this of the characteristic length [decades]: its square is a number.
   real(dp), parameter :: most_lengths = 20
   !> Of two displacements further apart [decades] the smaller one is lost in the rounding of the larger one.
   real(dp), parameter :: lost = 12
   !> Largest amplitude of kappa: the motion of an unstable train grows with the exponential of its root.
   real(dp), parameter :: most_variation = 1e3_dp
   !> Decades of 0.
   real(dp), parameter :: none = -1e4_dp

contains

   !> Adds a problem for what the values of a train give together, each of them being in its range. By logarithms: those are numbers
   !> whatever the values are, and however many meshes hand the torque on.
   subroutine check_scales(train, checker)
      type(train_type), intent(in) :: train
      class(checker_type), intent(inout) :: checker
      real(dp) :: torque, static, compliance, unit, largest, own
      integer :: j, before

      if (.not. in_order(train, checker)) return
      own = own_frequency(train)
      before = checker%problems%count
      call checker%enter('train', 1)
      if (abs(log10(own) - log10(train%characteristic_frequency)) > off_unit) &
         call checker%complain('characteristic_frequency', real_text(train%characteristic_frequency), 'must be within a factor of &
            &1e7 of the frequency of the slowest mesh, '//text(own)//' rad/s by its stiffness, radii and inertias')
      call checker%leave()
      unit = decades(train%characteristic_length)
      torque = decades(train%input_torque)
      largest = none
      do j = 1, size(train%meshes)
         associate (mesh => train%meshes(j))
            compliance = -decades(mesh%driving_radius) - decades(mesh%stiffness)
            static = torque + compliance
            call check_length('train', 1, 'input_torque', train%input_torque, static, 'the static deflection of &mesh ' &
                              //integer_text(j)//' (by it, the radii up to there and the stiffness)')
            if (j == 1) then
               call check_list('train', 1, 'torque_cos', train%torque_cos, compliance, 'the deflection of &mesh 1 (by it, &
                               &driving_radius and stiffness)')
               call check_list('train', 1, 'torque_sin', train%torque_sin, compliance, 'the deflection of &mesh 1 (by it, &
                               &driving_radius and stiffness)')
            end if
            call check_list('mesh', j, 'error_cos', mesh%error_cos, 0.0_dp, 'it')
            call check_list('mesh', j, 'error_sin', mesh%error_sin, 0.0_dp, 'it')
            call check_length('mesh', j, 'half_backlash', mesh%half_backlash, decades(mesh%half_backlash), 'it')
            call check_variation(j, 'stiffness_cos', mesh%stiffness_cos)
            call check_variation(j, 'stiffness_sin', mesh%stiffness_sin)
            torque = torque + decades(mesh%driven_radius) - decades(mesh%driving_radius)
         end associate
      end do
      if (largest > none/2 .and. largest < unit - most_lengths) then
         call checker%enter('train', 1)
         call checker%complain('characteristic_length', real_text(train%characteristic_length), 'must be smaller: the largest &
            &displacement given (half_backlash, the static deflection, an error or that by a torque amplitude) is only '// &
            power(largest)//' m')
         call checker%leave()
      end if
      if (checker%problems%count == before) call check_rounding()

   contains

      !> A displacement [decades of m] that a value gives.
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
         !> To a displacement [decades].
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

      !> A gap and the deflection over it that cannot be told from the larger of them.
      subroutine check_rounding()
         real(dp) :: gap

         torque = decades(train%input_torque)
         do j = 1, size(train%meshes)
            associate (mesh => train%meshes(j))
               static = torque - decades(mesh%driving_radius) - decades(mesh%stiffness)
               torque = torque + decades(mesh%driven_radius) - decades(mesh%driving_radius)
               gap = decades(mesh%half_backlash)
               if (min(gap, static) < none/2) cycle
               if (static < gap - lost) then
                  call checker%enter('train', 1)
                  call checker%complain('input_torque', real_text(train%input_torque), 'must be 0 or larger: the static deflection &
                     &of &mesh '//integer_text(j)//' (by it, the radii up to there and the stiffness), '//power(static)// &
                     ' m, is lost in rounding beside its half_backlash')
               else if (gap < static - lost) then
                  call checker%enter('mesh', j)
                  call checker%complain('half_backlash', real_text(mesh%half_backlash), 'must be 0 or larger: it is lost in &
                     &rounding beside the static deflection (by input_torque, the radii up to there and the stiffness), '// &
                     power(static)//' m')
               end if
            end associate
            call checker%leave()
         end do
      end subroutine check_rounding

   end subroutine check_scales

   !> log10 of a magnitude, also of 0.
   elemental real(dp) function decades(value)
      real(dp), intent(in) :: value

      decades = none
      if (abs(value) > 0) decades = log10(abs(value))
   end function decades

   !> A number by its logarithm, roughly: '1e305'.
   pure function power(exponent) result(text)
      real(dp), intent(in) :: exponent
      character(2 + len(integer_text(nint(exponent)))) :: text

      text = '1e'//integer_text(nint(exponent))
   end function power

end module geartrain_model_scales
