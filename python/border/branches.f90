! Branches with their special points, out and in; lists read off them.

! Number of further branches.
subroutine count_branches(handle, branches)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(out) :: branches
   type(box_type), pointer :: box

   box => box_of(handle)
   branches = 0
   if (allocated(box%results%branches)) branches = size(box%results%branches)
end subroutine count_branches

! Room for the further branches that are put next.
subroutine reserve_branches(handle, branches)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: branches
   type(box_type), pointer :: box

   box => box_of(handle)
   allocate (box%results%branches(branches))
end subroutine reserve_branches

! points, meshes, states (0: no stability), terms (1 + 2*harmonics), special points, subharmonic, complete, closed.
! Here and below, place 0 is the response, 1, 2, ... are the further branches.
subroutine branch_sizes(handle, place, sizes)
   use geartrain, only: branch_type
   use geartrain_python_box, only: box_of, branch_at
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: place
   integer, intent(out) :: sizes(8)
   type(branch_type), pointer :: branch

   branch => branch_at(box_of(handle), place)
   sizes = 0
   if (.not. associated(branch)) return
   sizes(1:2) = [branch%points, branch%meshes]
   if (allocated(branch%multipliers)) sizes(3) = size(branch%multipliers, 1)
   if (allocated(branch%coefficients)) sizes(4) = size(branch%coefficients, 1)
   if (allocated(branch%special_points)) sizes(5) = size(branch%special_points)
   sizes(6:8) = [branch%subharmonic, merge(1, 0, branch%complete), merge(1, 0, branch%closed)]
end subroutine branch_sizes

! numbers: frequency, error estimate, second estimate, correction; values: rms, mean, minimum, maximum, those of the mesh load;
! marks: part, stable, estimate doubtful, harmonics, undecided, refined (one for all points), count
! undecided.
subroutine copy_branch(handle, place, points, meshes, states, terms, numbers, coefficients, values, marks, multipliers)
   use geartrain, only: branch_type
   use geartrain_python_box, only: as_values, box_of, branch_at
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: place, points, meshes, states, terms
   double precision, intent(out) :: numbers(points, 4), coefficients(terms, meshes, points), values(meshes, points, 8)
   integer, intent(out) :: marks(points, 7)
   double precision, intent(out) :: multipliers(2, states, points)
   type(branch_type), pointer :: branch
   integer :: i

   if (points == 0) return
   branch => branch_at(box_of(handle), place)
   numbers(:, 1) = branch%frequency(:points)
   numbers(:, 2) = branch%error_estimate(:points)
   numbers(:, 3:4) = -1
   if (allocated(branch%correction)) numbers(:, 4) = branch%correction(:points)
   coefficients = branch%coefficients(:, :, :points)
   values(:, :, 1) = branch%rms(:, :points)
   values(:, :, 2) = branch%mean(:, :points)
   values(:, :, 3) = branch%minimum(:, :points)
   values(:, :, 4) = branch%maximum(:, :points)
   do i = 1, points
      values(:, i, 5:) = as_values(branch%mesh_load(:, i))
   end do
   marks(:, 1) = branch%part(:points)
   marks(:, [2, 5, 7]) = 0
   marks(:, 3) = merge(1, 0, branch%estimate_doubtful(:points))
   marks(:, 4) = branch%point_harmonics(:points)
   marks(:, 6) = merge(1, 0, allocated(branch%correction))
   if (states == 0) return
   marks(:, 2) = merge(1, 0, branch%stable(:points))
   marks(:, 5) = merge(1, 0, branch%undecided(:points))
   marks(:, 7) = merge(1, 0, branch%count_undecided(:points))
   numbers(:, 3) = branch%second_estimate(:points)
   multipliers(1, :, :) = real(branch%multipliers(:, :points))
   multipliers(2, :, :) = aimag(branch%multipliers(:, :points))
end subroutine copy_branch

! The inverse of copy_branch; flags: subharmonic, complete, closed, number of special points, points. Where there are no points
! the arrays have one that is not read: f2py passes none that are empty.
subroutine put_branch(handle, place, ended, origin, flags, numbers, coefficients, values, marks, multipliers, &
                      rows, meshes, states, terms)
   use geartrain, only: branch_type
   use geartrain_python_box, only: as_loads, box_type, box_of, branch_at
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: ended, origin
   integer, intent(in) :: place, rows, meshes, states, terms, flags(5), marks(rows, 7)
   double precision, intent(in) :: numbers(rows, 4), coefficients(terms, meshes, rows), values(meshes, rows, 8)
   double precision, intent(in) :: multipliers(2, states, rows)
   type(box_type), pointer :: box
   type(branch_type), pointer :: branch
   integer :: i, points

   box => box_of(handle)
   if (place == 0) allocate (box%results%response)
   branch => branch_at(box, place)
   if (origin /= '') branch%origin = origin
   points = flags(5)
   branch%points = points
   branch%meshes = meshes
   branch%states = states
   branch%harmonics = (terms - 1)/2
   branch%ended = ended
   branch%subharmonic = flags(1)
   branch%complete = flags(2) == 1
   branch%closed = flags(3) == 1
   allocate (branch%special_points(flags(4)))
   branch%frequency = numbers(:points, 1)
   branch%error_estimate = numbers(:points, 2)
   if (marks(1, 6) == 1) branch%correction = numbers(:points, 4)
   branch%coefficients = coefficients(:, :, :points)
   branch%rms = values(:, :points, 1)
   branch%mean = values(:, :points, 2)
   branch%minimum = values(:, :points, 3)
   branch%maximum = values(:, :points, 4)
   allocate (branch%mesh_load(meshes, points))
   do i = 1, points
      branch%mesh_load(:, i) = as_loads(values(:, i, 5:))
   end do
   associate (train => box%case%train)
      branch%backlash = train%meshes%half_backlash/train%characteristic_length
   end associate
   branch%part = marks(:points, 1)
   branch%estimate_doubtful = marks(:points, 3) == 1
   branch%point_harmonics = marks(:points, 4)
   if (states == 0) return
   branch%stable = marks(:points, 2) == 1
   branch%undecided = marks(:points, 5) == 1
   branch%count_undecided = marks(:points, 7) == 1
   branch%second_estimate = numbers(:points, 3)
   branch%multipliers = cmplx(multipliers(1, :, :points), multipliers(2, :, :points), kind(0d0))
end subroutine put_branch

! The special point number `special` of the branch at `place`; point counts from 1, as in Fortran; the kinds are the text
! 'special points'; undecided: it rests on undecided points.
subroutine copy_special(handle, place, special, meshes, frequency, point, undecided, rms)
   use geartrain, only: branch_type
   use geartrain_branch_decided, only: rests_on_undecided
   use geartrain_python_box, only: box_of, branch_at
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: place, special, meshes
   double precision, intent(out) :: frequency, rms(meshes)
   integer, intent(out) :: point, undecided
   type(branch_type), pointer :: branch

   branch => branch_at(box_of(handle), place)
   undecided = merge(1, 0, rests_on_undecided(branch, special))
   associate (this => branch%special_points(special))
      frequency = this%frequency
      point = this%point
      rms = this%rms
   end associate
end subroutine copy_special

subroutine put_special(handle, place, special, kind, frequency, point, rms, meshes)
   use geartrain, only: branch_type
   use geartrain_python_box, only: box_of, branch_at
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: kind
   integer, intent(in) :: place, special, point, meshes
   double precision, intent(in) :: frequency, rms(meshes)
   type(branch_type), pointer :: branch

   branch => branch_at(box_of(handle), place)
   associate (this => branch%special_points(special))
      this%kind = kind
      this%frequency = frequency
      this%point = point
      this%rms = rms
   end associate
end subroutine put_special

! Reads a list off the box's branch into the box's table (see summarize in box.f90); shape_: its columns and rows.
subroutine read_off(handle, what, mesh, stable_only, shape_)
   use geartrain_python_box, only: box_type, box_of, summarize
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: what
   integer, intent(in) :: mesh, stable_only
   integer, intent(out) :: shape_(2)
   type(box_type), pointer :: box

   box => box_of(handle)
   call summarize(box, what, mesh, stable_only == 1)
   shape_ = shape(box%table)
end subroutine read_off

subroutine copy_table(handle, columns, rows, table)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: columns, rows
   double precision, intent(out) :: table(columns, rows)
   type(box_type), pointer :: box

   box => box_of(handle)
   table = box%table
end subroutine copy_table
