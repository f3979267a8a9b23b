! The border between Fortran and Python: flat subroutines with explicit shapes, which f2py turns into an extension.
!
! Every call works on a box (python/box.f90) by its handle; `status` is 0 or the exit status of the error whose message
! the box then holds. Nothing here computes: it calls the library and copies. Complex numbers travel as pairs
! (real, imaginary); `threadsafe` releases Python's global lock, which no call needs, since none calls back.

subroutine open_box(handle)
   use geartrain_python_box, only: box_type, handle_of
   implicit none
   integer(8), intent(out) :: handle
   type(box_type), pointer :: box

   allocate (box)
   handle = handle_of(box)
end subroutine open_box

subroutine close_box(handle)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   type(box_type), pointer :: box

   box => box_of(handle)
   deallocate (box)
end subroutine close_box

! Reads a case from namelist text that a Python call wrote.
subroutine read_text(handle, text, status)
   use geartrain, only: error_type, read_case_text
   use geartrain_python_box, only: box_type, box_of, close_with
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: text
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error

   box => box_of(handle)
   call read_case_text(text, '', box%case, error)
   status = close_with(box, error)
end subroutine read_text

! Reads a case from a file.
subroutine read_path(handle, path, status)
   use geartrain, only: error_type, read_case
   use geartrain_python_box, only: box_type, box_of, close_with
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: path
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error

   box => box_of(handle)
   call read_case(path, box%case, error)
   status = close_with(box, error)
end subroutine read_path

! ---------------------------------------------------------------------------------------------------- the analyses

subroutine find_modes(handle, status)
   use geartrain, only: error_type, natural_modes
   use geartrain_python_box, only: box_type, box_of, close_with
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error

   box => box_of(handle)
   allocate (box%results%modes)
   call natural_modes(box%case%train, box%results%modes, error)
   status = close_with(box, error)
end subroutine find_modes

! The seed is the box's first motion, if it has one. The branches that follow from period doublings are the box's further ones.
subroutine follow_response(handle, progress, status)
   use geartrain, only: error_type, follow_doublings, motion_type, refine_branch, response
   use geartrain_python_box, only: box_type, box_of, close_with, loose, motion_list, watch_type
   implicit none
   integer(8), intent(in) :: handle
   double precision, intent(inout), target :: progress(3)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(motion_type), pointer :: motions(:), seed
   type(watch_type) :: watch
   integer :: i
   !f2py threadsafe

   box => box_of(handle)
   watch%progress => progress
   motions => motion_list(box, loose)
   nullify (seed)
   if (associated(motions)) seed => motions(1)
   allocate (box%results%response)
   call response(box%case%train, box%case%response, box%results%response, error, seed, watch)
   if (.not. (allocated(error) .or. box%results%response%cancelled)) &
      call follow_doublings(box%case%train, box%case%response, box%results%response, box%results%branches, error, watch)
   if (box%case%response%refine .and. .not. (allocated(error) .or. box%results%response%cancelled)) then
      call refine_branch(box%case%train, box%results%response, error, watch)
      if (allocated(box%results%branches)) then
         do i = 1, size(box%results%branches)
            if (.not. allocated(error)) call refine_branch(box%case%train, box%results%branches(i), error, watch)
         end do
      end if
   end if
   status = close_with(box, error)
end subroutine follow_response

! Refines the box's branch.
subroutine refine_points(handle, progress, status)
   use geartrain, only: error_type, refine_branch
   use geartrain_python_box, only: box_type, box_of, close_with, watch_type
   implicit none
   integer(8), intent(in) :: handle
   double precision, intent(inout), target :: progress(3)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   watch%progress => progress
   call refine_branch(box%case%train, box%results%response, error, watch)
   status = close_with(box, error)
end subroutine refine_points

! The stability map that the case asks for.
subroutine map_stability(handle, progress, status)
   use geartrain, only: error_type, stability_map
   use geartrain_python_box, only: box_type, box_of, close_with, watch_type
   implicit none
   integer(8), intent(in) :: handle
   double precision, intent(inout), target :: progress(3)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   watch%progress => progress
   allocate (box%results%stability_map)
   call stability_map(box%case%train, box%case%stability_map, box%results%stability_map, error, watch)
   status = close_with(box, error)
end subroutine map_stability

! The branch of twice the period at one of the special points of the box's branch takes its place.
subroutine follow_doubled(handle, special, progress, status)
   use geartrain, only: branch_type, error_type, period_doubled
   use geartrain_python_box, only: box_type, box_of, close_with, watch_type
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: special
   double precision, intent(inout), target :: progress(3)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(branch_type), allocatable :: doubled
   type(error_type), allocatable :: error
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   watch%progress => progress
   allocate (doubled)
   call period_doubled(box%case%train, box%case%response, box%results%response, special, doubled, error, watch)
   call move_alloc(doubled, box%results%response)
   status = close_with(box, error)
end subroutine follow_doubled

! Every solution of the box's branch at exactly `frequency`; they become the box's motions, refined where the branch is.
subroutine solve_at(handle, frequency, status)
   use geartrain, only: error_type, refine, solutions_at
   use geartrain_python_box, only: box_type, box_of, close_with
   implicit none
   integer(8), intent(in) :: handle
   double precision, intent(in) :: frequency
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   integer :: i
   !f2py threadsafe

   box => box_of(handle)
   call solutions_at(box%case%train, box%case%response, box%results%response, frequency, box%motions, error)
   status = close_with(box, error)
   if (status /= 0 .or. .not. allocated(box%results%response%correction)) return
   ! Like a point of the branch, one that shooting does not find stays as it is.
   do i = 1, size(box%motions)
      call refine(box%case%train, box%motions(i), error)
   end do
end subroutine solve_at

! Starts from the box's first motion, if it has one; the result takes its place.
subroutine integrate_at(handle, frequency, progress, status)
   use geartrain, only: error_type, integrate, motion_type
   use geartrain_python_box, only: box_type, box_of, close_with, loose, motion_list, watch_type
   implicit none
   integer(8), intent(in) :: handle
   double precision, intent(in) :: frequency
   double precision, intent(inout), target :: progress(3)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(motion_type), pointer :: motions(:), start
   type(motion_type) :: motion
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   watch%progress => progress
   motions => motion_list(box, loose)
   nullify (start)
   if (associated(motions)) start => motions(1)
   call integrate(box%case%train, frequency, box%case%integration, motion, error, start, watch)
   if (.not. allocated(error)) box%motions = [motion]
   status = close_with(box, error)
end subroutine integrate_at

subroutine sweep_range(handle, progress, status)
   use geartrain, only: error_type, sweep
   use geartrain_python_box, only: box_type, box_of, close_with, watch_type
   implicit none
   integer(8), intent(in) :: handle
   double precision, intent(inout), target :: progress(3)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   watch%progress => progress
   allocate (box%results%integration)
   call sweep(box%case%train, box%case%integration, box%results%integration, error, watch)
   status = close_with(box, error)
end subroutine sweep_range

! Where the box holds a response, motions on neither it nor the box's further branches are followed; the new branches come last.
subroutine find_attractors(handle, progress, status)
   use geartrain, only: attractors, error_type, follow_attractors
   use geartrain_python_box, only: box_type, box_of, close_with, watch_type
   implicit none
   integer(8), intent(in) :: handle
   double precision, intent(inout), target :: progress(3)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   watch%progress => progress
   allocate (box%results%attractors)
   call attractors(box%case%train, box%case%attractors, box%results%attractors, error, watch)
   if (.not. allocated(error) .and. box%results%attractors%complete .and. allocated(box%results%response)) &
      call follow_attractors(box%case%train, box%case%response, box%results%attractors, box%results%response, &
                             box%results%branches, error, watch)
   status = close_with(box, error)
end subroutine find_attractors

! Refines the box's first motion.
subroutine refine_motion(handle, status)
   use geartrain, only: error_type, refine
   use geartrain_python_box, only: box_type, box_of, close_with
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   !f2py threadsafe

   box => box_of(handle)
   call refine(box%case%train, box%motions(1), error)
   status = close_with(box, error)
end subroutine refine_motion

! One period of the box's first motion; force in N.
subroutine sample_waveform(handle, samples, meshes, time, displacement, force)
   use geartrain, only: waveform
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: samples, meshes
   double precision, intent(out) :: time(samples), displacement(samples, meshes), force(samples, meshes)
   type(box_type), pointer :: box

   box => box_of(handle)
   call waveform(box%case%train, box%motions(1), samples, time, displacement, force)
end subroutine sample_waveform

! Everything that the case asks for; `path` is where the results go, '' nowhere; `checkpoint` the file to go on from, '' none.
subroutine run_all(handle, path, checkpoint, progress, status)
   use geartrain, only: error_type, run_case
   use geartrain_python_box, only: box_type, box_of, close_with, watch_type
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: path, checkpoint
   double precision, intent(inout), target :: progress(3)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   watch%progress => progress
   call run_case(box%case, path, box%results, error, watch, checkpoint)
   status = close_with(box, error)
end subroutine run_all

! Writes the box's results.
subroutine write_path(handle, path, status)
   use geartrain, only: error_type, write_results
   use geartrain_python_box, only: box_type, box_of, close_with
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: path
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error

   box => box_of(handle)
   call write_results(path, box%case, box%results, error)
   status = close_with(box, error)
end subroutine write_path

! ------------------------------------------------------------------------------------------------------------- text

! Number of bytes of a text of the box: 'message', 'case' (the resolved namelist), 'elements', 'integration', 'attractors' (why
! each ended), 'map' (why it ended), 'map name', 'map unit', 'directions', 'version'; of the branch at a place (0: the response,
! else a further one): 'branch' (why it ended), 'origin', 'special points', 'jump kinds', 'jump causes'. Lists have one item a line.
subroutine text_size(handle, name, place, bytes)
   use geartrain_python_box, only: box_of, box_text
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: name
   integer, intent(in) :: place
   integer, intent(out) :: bytes

   bytes = len(box_text(box_of(handle), name, place))
end subroutine text_size

subroutine copy_text(handle, name, place, bytes, text)
   use geartrain_python_box, only: box_of, box_text
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: name
   integer, intent(in) :: place, bytes
   integer(1), intent(out) :: text(bytes)

   text = transfer(box_text(box_of(handle), name, place), text)
end subroutine copy_text

! ------------------------------------------------------------------------------------------------------------ modes

! elements, modes
subroutine modes_sizes(handle, sizes)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(out) :: sizes(2)
   type(box_type), pointer :: box

   box => box_of(handle)
   sizes = 0
   if (allocated(box%results%modes)) sizes = shape(box%results%modes%shape)
end subroutine modes_sizes

! values: undamped frequency, damped frequency, damping ratio.
subroutine copy_modes(handle, elements, modes, values, shapes)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: elements, modes
   double precision, intent(out) :: values(modes, 3), shapes(elements, modes)
   type(box_type), pointer :: box

   box => box_of(handle)
   values(:, 1) = box%results%modes%natural_frequency
   values(:, 2) = box%results%modes%damped_frequency
   values(:, 3) = box%results%modes%damping_ratio
   shapes = box%results%modes%shape
end subroutine copy_modes

! names: 16 characters an element.
subroutine put_modes(handle, names, values, shapes, elements, modes)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: elements, modes
   character(*), intent(in) :: names
   double precision, intent(in) :: values(modes, 3), shapes(elements, modes)
   type(box_type), pointer :: box
   integer :: i

   box => box_of(handle)
   allocate (box%results%modes)
   box%results%modes%natural_frequency = values(:, 1)
   box%results%modes%damped_frequency = values(:, 2)
   box%results%modes%damping_ratio = values(:, 3)
   box%results%modes%shape = shapes
   allocate (box%results%modes%element(elements))
   do i = 1, elements
      box%results%modes%element(i) = names(16*(i - 1) + 1:16*i)
   end do
end subroutine put_modes

! ---------------------------------------------------------------------------------------------------------- motions

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

! numbers: frequency, error estimate, share, Lyapunov exponent (NaN: none); values: rms, mean, minimum, maximum, those of
! the mesh load (box.f90); NaN for a motion that ran away.
subroutine copy_motion(handle, kind, place, terms, meshes, states, roots, numbers, coefficients, values, state, multipliers)
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use geartrain, only: motion_type
   use geartrain_python_box, only: as_values, box_of, motion_list
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: kind, place, terms, meshes, states, roots
   double precision, intent(out) :: numbers(4), coefficients(terms, meshes), values(meshes, 8), state(states)
   double precision, intent(out) :: multipliers(2, roots)
   type(motion_type), pointer :: motions(:)

   motions => motion_list(box_of(handle), kind)
   associate (motion => motions(place))
      numbers = [motion%frequency, motion%error_estimate, motion%share, ieee_value(1d0, ieee_quiet_nan)]
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
subroutine put_motion(handle, place, period, stable, undecided, floating, numbers, coefficients, values, state, multipliers, &
                      terms, meshes, states, roots)
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use geartrain_python_box, only: as_loads, box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: place, period, stable, undecided, floating, terms, meshes, states, roots
   double precision, intent(in) :: numbers(4), coefficients(terms, meshes), values(meshes, 8), state(states)
   double precision, intent(in) :: multipliers(2, roots)
   type(box_type), pointer :: box

   box => box_of(handle)
   associate (motion => box%motions(place))
      motion%period = period
      motion%stable = stable == 1
      motion%undecided = undecided == 1
      motion%floating = floating == 1
      motion%frequency = numbers(1)
      motion%error_estimate = numbers(2)
      motion%share = numbers(3)
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

! ---------------------------------------------------------------------------------------------------- stability map

! points, rows, meshes (0: the linear train), linear, complete; points 0: there is none.
subroutine map_sizes(handle, sizes)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(out) :: sizes(5)
   type(box_type), pointer :: box

   box => box_of(handle)
   sizes = 0
   if (.not. allocated(box%results%stability_map)) return
   associate (map => box%results%stability_map)
      if (.not. allocated(map%frequency)) return
      sizes(1:2) = [size(map%frequency), size(map%parameter)]
      if (allocated(map%rms)) sizes(3) = size(map%rms, 1)
      sizes(4:5) = [merge(1, 0, map%linear), merge(1, 0, map%complete)]
   end associate
end subroutine map_sizes

! counts: motions, stable motions; marks: rows done, whole.
subroutine copy_map(handle, points, rows, meshes, frequency, parameter_, counts, multiplier, rms, marks)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: points, rows, meshes
   double precision, intent(out) :: frequency(points), parameter_(rows), multiplier(2, points, rows), rms(meshes, points, rows)
   integer, intent(out) :: counts(points, rows, 2), marks(rows, 2)
   type(box_type), pointer :: box

   box => box_of(handle)
   associate (map => box%results%stability_map)
      frequency = map%frequency
      parameter_ = map%parameter
      counts(:, :, 1) = map%motions
      counts(:, :, 2) = map%stable_motions
      multiplier(1, :, :) = real(map%multiplier)
      multiplier(2, :, :) = aimag(map%multiplier)
      if (meshes > 0) rms = map%rms
      marks(:, 1) = merge(1, 0, map%done)
      marks(:, 2) = merge(1, 0, map%whole)
   end associate
end subroutine copy_map

! The inverse of copy_map; flags: linear, complete.
subroutine put_map(handle, name, unit, ended, flags, frequency, parameter_, counts, multiplier, rms, marks, points, rows, meshes)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: name, unit, ended
   integer, intent(in) :: points, rows, meshes, flags(2), counts(points, rows, 2), marks(rows, 2)
   double precision, intent(in) :: frequency(points), parameter_(rows), multiplier(2, points, rows), rms(meshes, points, rows)
   type(box_type), pointer :: box

   box => box_of(handle)
   allocate (box%results%stability_map)
   associate (map => box%results%stability_map)
      map%name = name
      map%unit = unit
      map%ended = ended
      map%linear = flags(1) == 1
      map%complete = flags(2) == 1
      map%frequency = frequency
      map%parameter = parameter_
      map%motions = counts(:, :, 1)
      map%stable_motions = counts(:, :, 2)
      map%multiplier = cmplx(multiplier(1, :, :), multiplier(2, :, :), kind(0d0))
      if (meshes > 0) map%rms = rms
      map%done = marks(:, 1) == 1
      map%whole = marks(:, 2) == 1
   end associate
end subroutine put_map

! ----------------------------------------------------------------------------------------------------------- branch

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
! marks: part, stable, estimate doubtful, harmonics, undecided, refined (one for all points).
subroutine copy_branch(handle, place, points, meshes, states, terms, numbers, coefficients, values, marks, multipliers)
   use geartrain, only: branch_type
   use geartrain_python_box, only: as_values, box_of, branch_at
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: place, points, meshes, states, terms
   double precision, intent(out) :: numbers(points, 4), coefficients(terms, meshes, points), values(meshes, points, 8)
   integer, intent(out) :: marks(points, 6)
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
   marks(:, [2, 5]) = 0
   marks(:, 3) = merge(1, 0, branch%estimate_doubtful(:points))
   marks(:, 4) = branch%point_harmonics(:points)
   marks(:, 6) = merge(1, 0, allocated(branch%correction))
   if (states == 0) return
   marks(:, 2) = merge(1, 0, branch%stable(:points))
   marks(:, 5) = merge(1, 0, branch%undecided(:points))
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
   integer, intent(in) :: place, rows, meshes, states, terms, flags(5), marks(rows, 6)
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
   branch%second_estimate = numbers(:points, 3)
   branch%multipliers = cmplx(multipliers(1, :, :points), multipliers(2, :, :points), kind(0d0))
end subroutine put_branch

! The special point number `special` of the branch at `place`; point counts from 1, as in Fortran; the kinds are the text
! 'special points'.
subroutine copy_special(handle, place, special, meshes, frequency, point, rms)
   use geartrain, only: branch_type
   use geartrain_python_box, only: box_of, branch_at
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: place, special, meshes
   double precision, intent(out) :: frequency, rms(meshes)
   integer, intent(out) :: point
   type(branch_type), pointer :: branch

   branch => branch_at(box_of(handle), place)
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
