! Motions, sweeps and attractors, out and in.

! How many motions of a kind the box holds, -1: none were asked for; 1 for a sweep done to its end.
! Kinds: 0 motions on their own, 1 those of the sweep, 2 those of the search for attractors.
subroutine motions_sizes(handle, kind, sizes)
   use geartrain, only: motion_type
   use geartrain_python_box, only: box_type, box_of, motion_list, of_integration
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: kind
   integer, intent(out) :: sizes(2)
   type(box_type), pointer :: box
   type(motion_type), pointer :: motions(:)

   box => box_of(handle)
   sizes = [-1, 0]
   motions => motion_list(box, kind)
   if (associated(motions)) sizes(1) = size(motions)
   if (kind == of_integration .and. allocated(box%results%integration)) sizes(2) = merge(1, 0, box%results%integration%complete)
end subroutine motions_sizes

! terms (1 + 2*harmonics), meshes, states, multipliers, period, stable, undecided, floating; 0 where not allocated. Places count
! from 1. A motion that ran away has one term of each mesh.
subroutine motion_sizes(handle, kind, place, sizes)
   use geartrain, only: motion_type
   use geartrain_python_box, only: box_type, box_of, motion_list
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: kind, place
   integer, intent(out) :: sizes(8)
   type(box_type), pointer :: box
   type(motion_type), pointer :: motions(:)

   box => box_of(handle)
   motions => motion_list(box, kind)
   sizes = [1, size(box%case%train%meshes), 0, 0, 0, 0, 0, 0]
   if (allocated(motions(place)%coefficients)) sizes(1) = size(motions(place)%coefficients, 1)
   if (allocated(motions(place)%state)) sizes(3) = size(motions(place)%state)
   if (allocated(motions(place)%multipliers)) sizes(4) = size(motions(place)%multipliers)
   sizes(5:8) = [motions(place)%period, merge(1, 0, motions(place)%stable), merge(1, 0, motions(place)%undecided), &
                 merge(1, 0, motions(place)%floating)]
end subroutine motion_sizes

! numbers: frequency, error estimate, share, Lyapunov exponent (NaN: none) and its uncertainty; values: rms, mean,
! minimum, maximum, those of the mesh load (box.f90); NaN for a motion that ran away.
subroutine copy_motion(handle, kind, place, terms, meshes, states, roots, numbers, coefficients, values, state, multipliers)
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use geartrain, only: motion_type
   use geartrain_python_box, only: as_values, box_of, motion_list
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: kind, place, terms, meshes, states, roots
   double precision, intent(out) :: numbers(5), coefficients(terms, meshes), values(meshes, 8), state(states)
   double precision, intent(out) :: multipliers(2, roots)
   type(motion_type), pointer :: motions(:)

   motions => motion_list(box_of(handle), kind)
   associate (motion => motions(place))
      numbers = [motion%frequency, motion%error_estimate, motion%share, ieee_value(1d0, ieee_quiet_nan), &
                 motion%lyapunov_error]
      if (allocated(motion%lyapunov_exponent)) numbers(4) = motion%lyapunov_exponent
      coefficients = ieee_value(1d0, ieee_quiet_nan)
      values = ieee_value(1d0, ieee_quiet_nan)
      if (allocated(motion%coefficients)) then
         coefficients = motion%coefficients
         values(:, 1) = motion%rms
         values(:, 2) = motion%mean
         values(:, 3) = motion%minimum
         values(:, 4) = motion%maximum
         values(:, 5:) = as_values(motion%mesh_load)
      end if
      if (states > 0) state = motion%state
      if (roots > 0) then
         multipliers(1, :) = real(motion%multipliers)
         multipliers(2, :) = aimag(motion%multipliers)
      end if
   end associate
end subroutine copy_motion

! Room for the motions that are put next.
subroutine reserve_motions(handle, motions)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: motions
   type(box_type), pointer :: box

   box => box_of(handle)
   allocate (box%motions(motions))
end subroutine reserve_motions

! The inverse of copy_motion; what has no size stays unallocated.
subroutine put_motion(handle, place, what, period, stable, undecided, floating, numbers, coefficients, values, state, multipliers, &
                      terms, meshes, states, roots)
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use geartrain_python_box, only: as_loads, box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: what
   integer, intent(in) :: place, period, stable, undecided, floating, terms, meshes, states, roots
   double precision, intent(in) :: numbers(5), coefficients(terms, meshes), values(meshes, 8), state(states)
   double precision, intent(in) :: multipliers(2, roots)
   type(box_type), pointer :: box

   box => box_of(handle)
   associate (motion => box%motions(place))
      motion%kind = what
      motion%period = period
      motion%stable = stable == 1
      motion%undecided = undecided == 1
      motion%floating = floating == 1
      motion%frequency = numbers(1)
      motion%error_estimate = numbers(2)
      motion%share = numbers(3)
      motion%lyapunov_error = numbers(5)
      if (.not. ieee_is_nan(numbers(4))) motion%lyapunov_exponent = numbers(4)
      if (terms > 0) motion%coefficients = coefficients
      if (meshes > 0) then
         motion%rms = values(:, 1)
         motion%mean = values(:, 2)
         motion%minimum = values(:, 3)
         motion%maximum = values(:, 4)
         motion%mesh_load = as_loads(values(:, 5:))
      end if
      if (states > 0) motion%state = state
      if (roots > 0) motion%multipliers = cmplx(multipliers(1, :), multipliers(2, :), kind(0d0))
   end associate
end subroutine put_motion

! Makes the box's motions a sweep; directions: 4 characters a motion.
subroutine put_sweep(handle, directions, ended, complete)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: directions, ended
   integer, intent(in) :: complete
   type(box_type), pointer :: box
   integer :: i

   box => box_of(handle)
   allocate (box%results%integration)
   associate (sweep => box%results%integration)
      call move_alloc(box%motions, sweep%motions)
      allocate (sweep%direction(size(sweep%motions)))
      do i = 1, size(sweep%motions)
         sweep%direction(i) = directions(4*(i - 1) + 1:4*i)
      end do
      sweep%ended = ended
      sweep%complete = complete == 1
   end associate
end subroutine put_sweep

! numbers: frequency, unsettled share; whole: random seed, starts, complete.
subroutine copy_attractors(handle, numbers, whole)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   double precision, intent(out) :: numbers(2)
   integer, intent(out) :: whole(3)
   type(box_type), pointer :: box

   box => box_of(handle)
   associate (found => box%results%attractors)
      numbers = [found%frequency, found%unsettled]
      whole = [found%random_seed, found%starts, merge(1, 0, found%complete)]
   end associate
end subroutine copy_attractors

! Makes the box's motions those of a search for attractors; numbers and whole as in copy_attractors.
subroutine put_attractors(handle, ended, numbers, whole)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: ended
   double precision, intent(in) :: numbers(2)
   integer, intent(in) :: whole(3)
   type(box_type), pointer :: box

   box => box_of(handle)
   allocate (box%results%attractors)
   associate (found => box%results%attractors)
      call move_alloc(box%motions, found%motions)
      found%ended = ended
      found%frequency = numbers(1)
      found%unsettled = numbers(2)
      found%random_seed = whole(1)
      found%starts = whole(2)
      found%complete = whole(3) == 1
   end associate
end subroutine put_attractors
