!> Checks of a coupling: its characteristic has one rest under every torque.
module geartrain_network_check_coupling
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type, fatal
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text, real_text
   use geartrain_linalg_rows, only: rows_type
   use geartrain_mesh_law_characteristic, only: ascends, characteristic_type, find_characteristic
   use geartrain_train_mesh_groups, only: enter_mesh
   use geartrain_network_network, only: network_type
   use geartrain_train_mesh, only: is_given, mesh_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: check_coupling, check_friction, check_middles, has_friction, refuse_friction, refuse_friction_of

contains

   !> Adds every problem of a coupling, whose group has been entered.
   subroutine check_coupling(coupling, checker)
      !> The coupling as given.
      type(mesh_type), intent(in) :: coupling
      class(checker_type), intent(inout) :: checker
      character(*), parameter :: cure = 'contradicts angle and torque: leave out one of the two'
      integer :: i

      if (.not. (is_given(coupling%angle) .or. is_given(coupling%torque))) then
         if (.not. coupling%torsional_stiffness > 0) call checker%lacks('stiffness', '> 0 N m/rad', ' or angle and torque')
         return
      end if
      if (coupling%torsional_stiffness > 0) call checker%complain('stiffness', real_text(coupling%torsional_stiffness), cure)
      if (coupling%half_play > 0) call checker%complain('half_play', real_text(coupling%half_play), cure)
      if (.not. is_given(coupling%angle)) call checker%lacks('angle', 'as many as torque')
      if (.not. is_given(coupling%torque)) call checker%lacks('torque', 'as many as angle')
      if (.not. (is_given(coupling%angle) .and. is_given(coupling%torque))) return
      if (ascends(coupling%angle, coupling%torque)) return
      associate (angle => coupling%angle, torque => coupling%torque, n => size(coupling%angle))
         if (n < 2 .or. size(torque) /= n) then
            call checker%complain('torque', integer_text(size(torque))//' values', 'must be as many as angle, which has '// &
                                  integer_text(n)//', and at least 2')
            return
         end if
         i = findloc(angle(2:) > angle(:n - 1), .false., 1)
         if (i > 0) then
            call checker%complain('angle', real_text(angle(i + 1)), 'must be > '//real_text(angle(i))//', the angle before it', &
                                  i + 1)
            return
         end if
         i = findloc(torque(2:) < torque(:n - 1), .true., 1)
         if (i > 0) then
            call checker%complain('torque', real_text(torque(i + 1)), 'must be > '//real_text(torque(i))//', the torque before &
               &it: where a characteristic falls, a load has several rests', i + 1)
            return
         end if
         if (.not. torque(2) > torque(1) .or. .not. torque(n) > torque(n - 1)) then
            call checker%complain('torque', real_text(merge(torque(1), torque(n), .not. torque(2) > torque(1))), 'must differ from &
               &the torque beside it: the slope at either end, which goes on there, bears a load of either sign')
            return
         end if
         i = findloc(torque(2:) > torque(:n - 1) .or. .not. abs(torque(2:)) > 0, .false., 1)
         call checker%complain('torque', real_text(torque(i + 1)), 'must be > '//real_text(torque(i))//', the torque before it: &
            &only a play, of torque 0, has no slope', i + 1)
      end associate
   end subroutine check_coupling

   !> Adds a problem for a coupling in a loop whose characteristic begins to bear unequally far from the angle 0: this would strain
   !> the loop.
   subroutine check_middles(meshes, network, checker)
      !> The meshes of a plain train.
      type(mesh_type), intent(in) :: meshes(:)
      type(network_type), intent(in) :: network
      class(checker_type), intent(inout) :: checker
      type(characteristic_type) :: found
      integer :: i, n

      do n = 1, size(network%elements)
         i = network%elements(n)%mesh
         if (i == 0 .or. size(network%loop, 1) == 0) cycle
         if (.not. (meshes(i)%is_coupling .and. is_given(meshes(i)%angle))) cycle
         if (n <= network%coordinates) then
            if (.not. any(abs(network%loop(:, n)) > 0)) cycle
         end if
         call find_characteristic(meshes(i)%torsional_stiffness, meshes(i)%half_play, meshes(i)%angle, meshes(i)%torque, found)
         if (abs(found%middle) <= 1e-12_dp*maxval(abs(meshes(i)%angle))) cycle
         call enter_mesh(checker, meshes, i)
         call checker%complain('angle', '...', 'must have the middle of the play, or the torque 0, at the angle 0, not at '// &
            real_text(found%middle)//' rad: the coupling is part of a loop, which would be strained without load')
         call checker%leave()
      end do
   end subroutine check_middles

   !> Adds a problem for a coupling with dry friction whose twist follows from the twists of other couplings with friction: where
   !> all of them stick, nothing determines their torques.
   subroutine check_friction(meshes, network, checker)
      !> The meshes of a plain train.
      type(mesh_type), intent(in) :: meshes(:)
      type(network_type), intent(in) :: network
      class(checker_type), intent(inout) :: checker
      type(rows_type) :: rows
      logical :: independent
      integer :: i, n

      if (.not. any(meshes%friction_torque > 0)) return
      call rows%setup(size(network%inertia), 0)
      do n = 1, size(network%elements)
         i = network%elements(n)%mesh
         if (i == 0) cycle
         if (.not. meshes(i)%friction_torque > 0) cycle
         call rows%add(network%elements(n)%row_type, independent)
         if (independent) cycle
         call enter_mesh(checker, meshes, i)
         call checker%complain('friction_torque', real_text(meshes(i)%friction_torque), 'must be 0: its loop has no other element &
            &than couplings with friction, and where all of them stick, nothing determines their torques; give the friction of &
            &the loop to one coupling')
         call checker%leave()
      end do
   end subroutine check_friction

   !> Whether a coupling of a train has dry friction.
   pure logical function has_friction(train)
      type(train_type), intent(in) :: train

      has_friction = .false.
      if (allocated(train%meshes)) has_friction = any(train%meshes%friction_torque > 0)
   end function has_friction

   !> Adds a problem for each coupling with dry friction, which an analysis does not have.
   subroutine refuse_friction(train, what, checker)
      type(train_type), intent(in) :: train
      !> The analysis, '&response'; and what it does, in words.
      character(*), intent(in) :: what
      class(checker_type), intent(inout) :: checker
      integer :: i

      if (.not. has_friction(train)) return
      do i = 1, size(train%meshes)
         if (.not. train%meshes(i)%friction_torque > 0) cycle
         call enter_mesh(checker, train%meshes, i)
         call checker%complain('friction_torque', real_text(train%meshes(i)%friction_torque), 'must be 0 for '//what//', whose &
            &harmonics do not represent sticking; find motions with friction by shooting and time integration: &response, &
            &&integration, &bifurcation_diagram, &attractors, &basins or &run_up')
         call checker%leave()
      end do
   end subroutine refuse_friction

   !> Makes it an error to make exact what shooting found, and what lies on corners of the branch where it is not smooth.
   subroutine refuse_friction_of(train, what, error)
      type(train_type), intent(in) :: train
      !> What is asked for, as in 'audit: points'.
      character(*), intent(in) :: what
      !> Added to where a coupling has dry friction.
      type(error_type), allocatable, intent(inout) :: error

      if (has_friction(train)) call fatal(error, what//' of a response of a train with friction_torque are found by shooting &
                                          &already, and have no derivatives')
   end subroutine refuse_friction_of

end module geartrain_network_check_coupling
