!> How the bodies of a train turn in steady running: their speeds, as far as shafts and gears determine them, and the senses in
!> which rotations count as positive.
!>
!> Every joint is a row of speeds of one sense: a shaft (1, -1); a gear pair z_a (n_a - n_c) + q z_b (n_b - n_c) = 0 with the
!> carrier c, q = 1 for an external and -1 for an internal pair (Willis). Speeds are the null space of the rows.
module geartrain_train_turning
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_rows, only: row_type, rows_type
   use geartrain_train_bodies, only: body_count, find_carriers, find_ends
   use geartrain_train_mesh, only: is_given, mesh_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: turning_type, find_locked, find_turning, lock_by_teeth

   !> A relative speed below this share of its terms is 0 [1].
   real(dp), parameter :: rounding = 1e-9_dp

   type :: turning_type
      !> Number of motions that shafts, gears, held bodies and springs to ground leave free; whether they and the speed ratios
      !> determine all speeds.
      integer :: motions = 0
      logical :: determined = .false.
      !> Body to whose speed all others refer: the first that may turn, or that of `speed_of`; 0: no body has that name.
      integer :: reference = 1
      !> Speed over that of the reference body, signed in one sense, 0 where not determined, (body); speed of the driving gear
      !> against its carrier, (mesh).
      real(dp), allocatable :: speed(:), relative(:)
      !> Whether gears and carrier turn, but as one, (mesh).
      logical, allocatable :: locked(:)
      !> Sense of one for all in which the rotation of each body is positive: that in which it turns, 1 or -1, (body).
      integer, allocatable :: sense(:)
   end type turning_type

contains

   !> Finds the speeds.
   pure subroutine find_turning(train, turning)
      !> The train; every joint has two bodies, and every mesh has numbers of teeth or radii.
      type(train_type), intent(in) :: train
      !> Its speeds.
      type(turning_type), intent(out) :: turning
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      integer :: carrier(size(train%meshes)), free, i
      type(rows_type) :: rows
      logical :: independent

      associate (bodies => body_count(train))
         allocate (turning%speed(bodies), turning%relative(size(train%meshes)), source=0.0_dp)
         allocate (turning%sense(bodies), source=0)
         allocate (turning%locked(size(train%meshes)), source=.false.)
         call find_ends(train, shaft_ends, mesh_ends)
         call find_carriers(train, carrier)
         call rows%setup(bodies, 0)
      end associate
      do i = 1, size(train%shafts)
         call rows%add(joint_row(shaft_ends(:, i), 0, [1.0_dp, -1.0_dp]), independent)
      end do
      do i = 1, size(train%meshes)
         call rows%add(joint_row(mesh_ends(:, i), carrier(i), entries_of(train%meshes(i))), independent)
      end do
      if (allocated(train%bodies)) then
         do i = 1, size(train%bodies)
            if (train%bodies(i)%held .or. train%bodies(i)%stiffness_to_ground > 0) &
               call rows%add(row_type([i], [1.0_dp]), independent)
         end do
      end if
      turning%motions = count(rows%free)
      call find_reference(train, rows, turning%reference)
      if (turning%reference > 0 .and. allocated(train%bodies)) then
         do i = 1, size(train%bodies)
            if (i == turning%reference .or. .not. train%bodies(i)%ratio_given) cycle
            call rows%add(row_type([i, turning%reference], [1.0_dp, -train%bodies(i)%speed_ratio]), independent)
         end do
      end if
      if (count(rows%free) == 1 .and. turning%reference > 0) then
         free = findloc(rows%free, .true., 1)
         associate (motion => rows%motion(:, free))
            turning%determined = abs(motion(turning%reference)) > 0
            if (turning%determined) turning%speed = motion/motion(turning%reference)
         end associate
      end if
      do i = 1, size(turning%relative)
         turning%relative(i) = turning%speed(mesh_ends(1, i))
         if (carrier(i) > 0) turning%relative(i) = turning%relative(i) - turning%speed(carrier(i))
         if (abs(turning%relative(i)) <= rounding*abs(turning%speed(mesh_ends(1, i)))) turning%relative(i) = 0
         if (carrier(i) > 0) turning%locked(i) = abs(turning%speed(carrier(i))) > 0 .and. .not. abs(turning%relative(i)) > 0
      end do
      call find_senses(train, shaft_ends, mesh_ends, carrier, turning)
   end subroutine find_turning

   !> Finds the meshes whose gears turn as one with their carrier.
   pure subroutine find_locked(train, turning, locked)
      !> The train; its values may be out of range.
      type(train_type), intent(in) :: train
      !> How the bodies turn, where it was found.
      type(turning_type), intent(inout) :: turning
      !> Whether they do, (mesh).
      logical, intent(out) :: locked(:)
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      integer :: carrier(size(train%meshes))

      locked = .false.
      call find_carriers(train, carrier)
      if (.not. any(carrier > 0)) return
      if (.not. allocated(turning%locked)) then
         call find_ends(train, shaft_ends, mesh_ends)
         if (any(shaft_ends == 0) .or. any(mesh_ends == 0) .or. any(carrier < 0)) return
         call find_turning(train, turning)
      end if
      locked = turning%locked
   end subroutine find_locked

   !> Whether the teeth of all meshes alone, without shafts and held bodies, keep a gear from turning against its carrier.
   pure logical function lock_by_teeth(train, gear, arm) result(lock)
      !> The train; every mesh has two bodies and numbers of teeth or radii.
      type(train_type), intent(in) :: train
      !> The bodies.
      integer, intent(in) :: gear, arm
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      integer :: carrier(size(train%meshes)), i
      type(rows_type) :: rows
      logical :: independent

      call find_ends(train, shaft_ends, mesh_ends)
      call find_carriers(train, carrier)
      call rows%setup(body_count(train), 0)
      do i = 1, size(train%meshes)
         if (train%meshes(i)%is_pair()) &
            call rows%add(joint_row(mesh_ends(:, i), carrier(i), entries_of(train%meshes(i))), independent)
      end do
      call rows%add(row_type([gear, arm], [1.0_dp, -1.0_dp]), independent)
      lock = .not. independent
   end function lock_by_teeth

   !> Row of a joint of two bodies, with a third entry where it rides on a carrier: all three turning together do not displace it.
   pure type(row_type) function joint_row(ends, carrier, entries) result(row)
      !> The two bodies; the carrier, 0: none.
      integer, intent(in) :: ends(2), carrier
      !> Entries of the two bodies.
      real(dp), intent(in) :: entries(2)

      row%node = ends
      row%entry = entries
      if (carrier == 0) return
      row%node = [ends, carrier]
      row%entry = [entries, -sum(entries)]
   end function joint_row

   !> Entries of a gear pair in speeds of one sense: numbers of teeth, else radii.
   pure function entries_of(mesh) result(entries)
      type(mesh_type), intent(in) :: mesh
      real(dp) :: entries(2)

      entries = [mesh%driving_radius, mesh%driven_radius]
      if (is_given(mesh%teeth)) then
         if (size(mesh%teeth) == 2) entries = mesh%teeth
      end if
      if (mesh%internal) entries(2) = -entries(2)
   end function entries_of

   !> The body to whose speed all others refer.
   pure subroutine find_reference(train, rows, reference)
      type(train_type), intent(in) :: train
      !> Rows without speed ratios.
      type(rows_type), intent(in) :: rows
      integer, intent(out) :: reference
      integer :: i

      reference = 1
      if (.not. allocated(train%bodies)) return
      if (train%speed_of /= '') then
         do i = size(train%bodies), 0, -1
            reference = i
            if (i == 0) return
            if (.not. allocated(train%bodies(i)%name)) cycle
            if (train%bodies(i)%name == train%speed_of) return
         end do
      end if
      do i = 1, size(train%bodies)
         if (.not. any(rows%free .and. abs(rows%motion(i, :)) > 0)) cycle
         reference = i
         return
      end do
   end subroutine find_reference

   !> Senses of bodies that turn are those of their speeds. Bodies at rest that are joined have the senses in which they would turn
   !> together.
   pure subroutine find_senses(train, shaft_ends, mesh_ends, carrier, turning)
      type(train_type), intent(in) :: train
      integer, intent(in) :: shaft_ends(:, :), mesh_ends(:, :), carrier(:)
      type(turning_type), intent(inout) :: turning
      integer :: i
      logical :: changed

      where (abs(turning%speed) > 0) turning%sense = nint(sign(1.0_dp, turning%speed))
      do while (any(turning%sense == 0))
         turning%sense(findloc(turning%sense, 0, 1)) = 1
         changed = .true.
         do while (changed)
            changed = .false.
            do i = 1, size(shaft_ends, 2)
               call pass(shaft_ends(:, i), 1, turning%sense, changed)
            end do
            do i = 1, size(mesh_ends, 2)
               if (carrier(i) == 0) call pass(mesh_ends(:, i), merge(1, -1, train%meshes(i)%internal), turning%sense, changed)
            end do
         end do
      end do
   end subroutine find_senses

   !> Hands the sense of one end of a joint to the other end, if just one of them has any.
   pure subroutine pass(ends, turn, sense, changed)
      !> The two bodies; 1: they turn in one sense, -1: in opposite senses.
      integer, intent(in) :: ends(2), turn
      integer, intent(inout) :: sense(:)
      logical, intent(inout) :: changed

      if (sense(ends(1)) == 0 .eqv. sense(ends(2)) == 0) return
      if (sense(ends(1)) == 0) then
         sense(ends(1)) = turn*sense(ends(2))
      else
         sense(ends(2)) = turn*sense(ends(1))
      end if
      changed = .true.
   end subroutine pass

end module geartrain_train_turning
