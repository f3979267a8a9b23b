! The border between Fortran and Python: flat subroutines with explicit shapes, from which f2py makes the extension. Here those
! that open and close a box, read a case or results, run an analysis and write a file; fields.f90 has those that carry results.
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

! A box with the case and the response of another one, which stays as it is.
subroutine open_copy(other, handle)
   use geartrain_python_box, only: box_type, box_of, handle_of
   implicit none
   integer(8), intent(in) :: other
   integer(8), intent(out) :: handle
   type(box_type), pointer :: box, from

   allocate (box)
   from => box_of(other)
   box%case = from%case
   if (allocated(from%results%response)) box%results%response = from%results%response
   handle = handle_of(box)
end subroutine open_copy

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

! Meshes of the case's train, and the size of its states.
subroutine train_sizes(handle, sizes)
   use geartrain_model_network, only: state_count
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(out) :: sizes(2)
   type(box_type), pointer :: box

   box => box_of(handle)
   sizes(1) = size(box%case%train%meshes)
   sizes(2) = state_count(box%case%train)
end subroutine train_sizes

! The natural modes of the case's train.
subroutine find_modes(handle, progress, status)
   use geartrain, only: error_type, natural_modes
   use geartrain_python_box, only: begin_watch, box_type, box_of, close_with, watch_type
   implicit none
   integer(8), intent(in) :: handle
   double precision, intent(inout), target :: progress(3)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   call begin_watch(watch, box, progress)
   allocate (box%results%modes)
   call natural_modes(box%case%train, box%results%modes, error)
   status = close_with(box, error)
end subroutine find_modes

! The seed is the box's first motion, if it has one. The branches that bifurcate from it are the box's further ones.
subroutine follow_response(handle, progress, status)
   use geartrain, only: error_type, follow_bifurcations, motion_type, refine_branch, response
   use geartrain_python_box, only: begin_watch, box_type, box_of, close_with, watch_type
   implicit none
   integer(8), intent(in) :: handle
   double precision, intent(inout), target :: progress(3)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(motion_type), pointer :: seed
   type(watch_type) :: watch
   integer :: i
   !f2py threadsafe

   box => box_of(handle)
   call begin_watch(watch, box, progress)
   nullify (seed)
   if (allocated(box%motions)) seed => box%motions(1)
   allocate (box%results%response)
   call response(box%case%train, box%case%response, box%results%response, error, seed, watch)
   if (.not. (allocated(error) .or. box%results%response%cancelled)) &
      call follow_bifurcations(box%case%train, box%case%response, box%results%response, box%results%branches, error, watch)
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
   use geartrain_python_box, only: begin_watch, box_type, box_of, close_with, watch_type
   implicit none
   integer(8), intent(in) :: handle
   double precision, intent(inout), target :: progress(3)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   call begin_watch(watch, box, progress)
   call refine_branch(box%case%train, box%results%response, error, watch)
   status = close_with(box, error)
end subroutine refine_points

! The stability map that the case asks for.
subroutine map_stability(handle, progress, status)
   use geartrain, only: error_type, stability_map
   use geartrain_python_box, only: begin_watch, box_type, box_of, close_with, watch_type
   implicit none
   integer(8), intent(in) :: handle
   double precision, intent(inout), target :: progress(3)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   call begin_watch(watch, box, progress)
   allocate (box%results%stability_map)
   call stability_map(box%case%train, box%case%stability_map, box%results%stability_map, error, watch)
   status = close_with(box, error)
end subroutine map_stability

! The branch of twice the period at one of the special points of the box's branch takes its place.
subroutine follow_doubled(handle, special, progress, status)
   use geartrain, only: branch_type, error_type, period_doubled
   use geartrain_python_box, only: begin_watch, box_type, box_of, close_with, watch_type
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
   call begin_watch(watch, box, progress)
   allocate (doubled)
   call period_doubled(box%case%train, box%case%response, box%results%response, special, doubled, error, watch)
   call move_alloc(doubled, box%results%response)
   status = close_with(box, error)
end subroutine follow_doubled

! Every solution of the box's branch at exactly `frequency`; they become the box's motions, refined where the branch is.
subroutine solve_at(handle, frequency, progress, status)
   use geartrain, only: error_type, refine, solutions_at
   use geartrain_python_box, only: begin_watch, box_type, box_of, close_with, watch_type
   implicit none
   integer(8), intent(in) :: handle
   double precision, intent(in) :: frequency
   double precision, intent(inout), target :: progress(3)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(watch_type) :: watch
   integer :: i
   !f2py threadsafe

   box => box_of(handle)
   call begin_watch(watch, box, progress)
   call solutions_at(box%case%train, box%case%response, box%results%response, frequency, box%motions, error)
   status = close_with(box, error)
   ! What there is then may not be solutions.
   if (box%case%train%interrupt%raised()) deallocate (box%motions)
   if (status /= 0 .or. .not. (allocated(box%results%response%correction) .and. allocated(box%motions))) return
   ! Like a point of the branch, one that shooting does not find stays as it is.
   do i = 1, size(box%motions)
      call refine(box%case%train, box%motions(i), error)
   end do
end subroutine solve_at

! Starts from the box's first motion, if it has one; the result takes its place.
subroutine integrate_at(handle, frequency, progress, status)
   use geartrain, only: error_type, integrate, motion_type
   use geartrain_python_box, only: begin_watch, box_type, box_of, close_with, watch_type
   implicit none
   integer(8), intent(in) :: handle
   double precision, intent(in) :: frequency
   double precision, intent(inout), target :: progress(3)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(motion_type), pointer :: start
   type(motion_type) :: motion
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   call begin_watch(watch, box, progress)
   nullify (start)
   if (allocated(box%motions)) start => box%motions(1)
   call integrate(box%case%train, frequency, box%case%integration, motion, error, start, watch)
   if (.not. allocated(error)) box%motions = [motion]
   status = close_with(box, error)
end subroutine integrate_at

subroutine sweep_range(handle, progress, status)
   use geartrain, only: error_type, sweep
   use geartrain_python_box, only: begin_watch, box_type, box_of, close_with, watch_type
   implicit none
   integer(8), intent(in) :: handle
   double precision, intent(inout), target :: progress(3)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   call begin_watch(watch, box, progress)
   allocate (box%results%integration)
   call sweep(box%case%train, box%case%integration, box%results%integration, error, watch)
   status = close_with(box, error)
end subroutine sweep_range

! Where the box holds a response, motions on neither it nor the box's further branches are followed; the new branches come last.
subroutine find_attractors(handle, progress, status)
   use geartrain, only: attractors, error_type, follow_attractors
   use geartrain_python_box, only: begin_watch, box_type, box_of, close_with, watch_type
   implicit none
   integer(8), intent(in) :: handle
   double precision, intent(inout), target :: progress(3)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   call begin_watch(watch, box, progress)
   allocate (box%results%attractors)
   call attractors(box%case%train, box%case%attractors, box%results%attractors, error, watch)
   if (.not. allocated(error) .and. box%results%attractors%complete .and. allocated(box%results%response)) &
      call follow_attractors(box%case%train, box%case%response, box%results%attractors, box%results%response, &
                             box%results%branches, error, watch)
   status = close_with(box, error)
end subroutine find_attractors

! Refines the box's first motion.
subroutine refine_motion(handle, progress, status)
   use geartrain, only: error_type, refine
   use geartrain_python_box, only: begin_watch, box_type, box_of, close_with, watch_type
   implicit none
   integer(8), intent(in) :: handle
   double precision, intent(inout), target :: progress(3)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   call begin_watch(watch, box, progress)
   call refine(box%case%train, box%motions(1), error)
   status = close_with(box, error)
end subroutine refine_motion

! Audits the box's branch: `points` of its points, which `random_seed` draws, and all special points.
subroutine audit_points(handle, points, random_seed, progress, status)
   use geartrain, only: audit_branch, error_type
   use geartrain_python_box, only: begin_watch, box_type, box_of, close_with, watch_type
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: points, random_seed
   double precision, intent(inout), target :: progress(3)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   call begin_watch(watch, box, progress)
   allocate (box%audit)
   call audit_branch(box%case%train, box%results%response, points, random_seed, box%audit, error, watch)
   status = close_with(box, error)
end subroutine audit_points

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
   use geartrain_python_box, only: begin_watch, box_type, box_of, close_with, watch_type
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
   call begin_watch(watch, box, progress)
   call run_case(box%case, path, box%results, error, watch, checkpoint)
   status = close_with(box, error)
end subroutine run_all

! Reads results and the case that they are of.
subroutine read_file(handle, path, status)
   use geartrain, only: error_type, read_results
   use geartrain_python_box, only: box_type, box_of, close_with
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: path
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error

   box => box_of(handle)
   call read_results(path, box%case, box%results, error)
   status = close_with(box, error)
end subroutine read_file

! Writes the box's results.
subroutine write_path(handle, path, status)
   use geartrain, only: error_type, locate_edges, write_results
   use geartrain_python_box, only: box_type, box_of, close_with
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: path
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error

   box => box_of(handle)
   call locate_edges(box%case, box%results)
   call write_results(path, box%case, box%results, error)
   status = close_with(box, error)
end subroutine write_path
